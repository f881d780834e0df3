//! The truth of the Zurich scene is physically sound at every frame, and lies where the runways are.

use models::flight_list::MovementKind;
use models::frames::{Vector2, center, wrap_pi};
use models::plot::Callsign;
use models::time::SimTime;
use models::truth::{Limits, TruthState};
use scenarios::{Entity, Scene, load};
use std::path::Path;

const FRAME: i64 = 50_000_000;

fn zurich() -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("zurich.toml");
    load(&file).unwrap_or_else(|e| panic!("{e}"))
}

fn states(entity: &Entity, run: SimTime) -> Vec<(SimTime, TruthState)> {
    let trajectory = entity.trajectory.as_ref().expect("loaded with truth");
    let from = (trajectory.start().0.max(0) + FRAME - 1) / FRAME;
    let to = trajectory.end().0.min(run.0) / FRAME;
    let at = |k: i64| (SimTime(k * FRAME), trajectory.at(SimTime(k * FRAME)));
    (from..=to).map(at).filter_map(|(t, s)| s.map(|s| (t, s))).collect()
}

/// Speed, acceleration along and across, of a state; braking is negative.
fn motion(state: &TruthState) -> (f64, f64, f64) {
    let v = state.velocity_mps.xy();
    let nose = Vector2::new(libm::sin(state.heading_rad), libm::cos(state.heading_rad));
    let along = state.acceleration_ms2.xy().dot(&nose);
    let across = (state.acceleration_ms2.xy() - nose * along).norm();
    (v.norm(), along * if v.dot(&nose) < 0.0 { -1.0 } else { 1.0 }, across)
}

/// Which states belong to a run on the runway or a flight: from where an acceleration begins that goes
/// beyond taxi speed to where the braking ends that comes back from it.
fn runs(motions: &[(f64, f64, f64)], taxi_mps: f64) -> Vec<bool> {
    let mut runs: Vec<bool> = motions.iter().map(|m| m.0 > taxi_mps).collect();
    for i in (1..runs.len()).rev() {
        runs[i - 1] |= runs[i] && motions[i - 1].1 > 0.0;
    }
    for i in 1..runs.len() {
        runs[i] |= runs[i - 1] && motions[i].1 < 0.0;
    }
    runs
}

#[test]
fn every_movement_keeps_within_the_table_of_types_every_50_ms() {
    let scene = zurich();
    for entity in &scene.traffic.entities {
        let name = entity.callsign;
        let row = scene.traffic.types.get(&entity.class.designator).expect("a known type");
        // Straight from the columns of types.csv.
        let table = row.kinematics;
        let flight = scene.flight_list.entries.iter().find(|e| e.callsign == name).expect("listed");
        let (run_ms, acc_ms2, dec_ms2, radius_m) = match flight.movement {
            MovementKind::Arrival => {
                (table.touchdown_mps, table.takeoff_acc_ms2, table.braking_ms2, 15.0)
            }
            MovementKind::Departure => {
                (table.liftoff_mps, table.takeoff_acc_ms2, table.braking_ms2, 15.0)
            }
            MovementKind::Vehicle => (None, None, None, 12.0),
        };
        let lateral_ms2 = table.taxi_turn_mps * table.taxi_turn_mps / radius_m;
        let trajectory = entity.trajectory.as_ref().expect("loaded with truth");
        let states = states(entity, trajectory.end());
        assert!(states.len() > 2000, "{name}: only {} states", states.len());
        let motions: Vec<_> = states.iter().map(|(_, state)| motion(state)).collect();
        let runs = runs(&motions, table.taxi_straight_mps);
        assert_eq!(
            runs.contains(&true),
            row.class.aircraft,
            "{name}: aircraft run, vehicles do not"
        );
        for (((time, state), (speed, along, across)), runs) in
            states.iter().zip(&motions).zip(&runs)
        {
            let at = format!("{name} at {:.2} s", time.s());
            let flies = state.position_m.z > 0.0;
            let (fastest, acc, dec) = if *runs {
                (
                    if flies { 100.0 } else { run_ms.expect("a figure") },
                    acc_ms2.expect("a figure"),
                    dec_ms2.expect("a figure"),
                )
            } else {
                (table.taxi_straight_mps, table.taxi_acc_ms2, table.taxi_dec_ms2)
            };
            assert!(*speed <= fastest, "{at}: {speed} m/s above {fastest}");
            assert!(*along <= acc, "{at}: accelerates with {along} m/s2 above {acc}");
            assert!(-along <= dec, "{at}: brakes with {along} m/s2 beyond {dec}");
            // In the air a bank of 30 degrees.
            let most = if flies { 5.67 } else { lateral_ms2 };
            assert!(*across <= most, "{at}: lateral {across} m/s2 above {most}");
            assert!((0.0..500.0).contains(&state.position_m.z), "{at}: height");
            let least_air_mps = Limits::of(row.class.aircraft, &table).least_air_mps;
            assert!(!flies || *speed > 0.97 * least_air_mps, "{at}: flies at {speed} m/s");
        }
    }
}

#[test]
fn every_movement_is_smooth_and_its_own_derivative_every_50_ms() {
    let scene = zurich();
    for entity in &scene.traffic.entities {
        let name = entity.callsign;
        let trajectory = entity.trajectory.as_ref().expect("loaded with truth");
        let mut before: Option<TruthState> = None;
        for (time, state) in states(entity, trajectory.end()) {
            let at = format!("{name} at {:.2} s", time.s());
            let v = state.velocity_mps.xy();
            let nose = Vector2::new(libm::sin(state.heading_rad), libm::cos(state.heading_rad));
            let speed = v.norm();
            // Heading is where it goes (or, pushed back, where it comes from); no sideways slip.
            assert!((v - nose * v.dot(&nose)).norm() <= 1e-6 * (1.0 + speed), "{at}: slips");
            assert!(state.angular_rate_rads.z.abs() < 0.6, "{at}: turns too fast");
            if let Some(last) = before {
                let step = (state.position_m - last.position_m).norm();
                let fastest = state.velocity_mps.norm().max(last.velocity_mps.norm());
                assert!(step <= 0.0501 * (fastest + 0.1), "{at}: jumps {step} m");
                let jerk = (state.acceleration_ms2 - last.acceleration_ms2).norm() / 0.05;
                assert!(jerk < 5.0, "{at}: jerk {jerk} m/s3");
                let turned = wrap_pi(state.heading_rad - last.heading_rad).abs();
                assert!(turned < 0.03, "{at}: heading jumps by {turned}");
                // Velocity is the derivative of position, acceleration that of velocity (trapezium rule).
                let mean = (state.velocity_mps + last.velocity_mps) * 0.5;
                let difference = (state.position_m - last.position_m) / 0.05;
                assert!((difference - mean).norm() < 0.02, "{at}: velocity is not the derivative");
                let mean = (state.acceleration_ms2 + last.acceleration_ms2) * 0.5;
                let difference = (state.velocity_mps - last.velocity_mps) / 0.05;
                assert!(
                    (difference - mean).norm() < 0.1,
                    "{at}: acceleration is not the derivative"
                );
            }
            before = Some(state);
        }
    }
}

#[test]
fn runs_on_the_runway_are_on_its_centreline() {
    let scene = zurich();
    for (callsign, runway) in [
        ("EDW229", "28"),
        ("CAI3208", "14"),
        ("SWR137H", "28"),
        ("AEE5ZH", "28"),
        // Its received positions lie 5 to 9 m beside the centreline of the layout.
        ("ACA879", "16"),
        // Its positions lie on a grid of 13 m by 19 m.
        ("ENT57BW", "28"),
    ] {
        let find = |e: &&Entity| e.callsign.as_str() == callsign;
        let entity = scene.traffic.entities.iter().find(find).expect(callsign);
        let runway = scene.airport.layout.runway(runway).expect("a runway of Zurich");
        let centre = center(&runway.ends_m[0], &runway.ends_m[1]);
        let half_m = (runway.ends_m[1] - runway.ends_m[0]).norm() * 0.5;
        let mut seen = 0;
        for (time, state) in states(entity, scene.run.duration) {
            let p = state.position_m.xy();
            let on_it = (p - centre).norm() < half_m - 100.0 && state.velocity_mps.norm() > 30.0;
            if on_it && state.position_m.z == 0.0 {
                seen += 1;
                let off_m = runway.distance_m(p);
                assert!(off_m <= 3.0, "{callsign} at {:.1} s: {off_m:.1} m", time.s());
            }
        }
        assert!(seen > 100, "{callsign}: only {seen} frames at speed on the runway");
    }
}

#[test]
fn most_movers_are_there_at_the_same_time_and_vehicles_stand_exactly_still() {
    let scene = zurich();
    let there = |s: i64| {
        let time = SimTime(s * 1_000_000_000);
        scene
            .traffic
            .entities
            .iter()
            .filter(|e| e.trajectory.as_ref().is_some_and(|t| t.within(time)))
            .count()
    };
    assert!((0..=600).all(|s| there(s) >= 3));
    assert!((100..200).all(|s| there(s) == 8), "all eight overlap");
    for vehicle in scene.traffic.entities.iter().filter(|e| !e.class.aircraft) {
        let states = states(vehicle, scene.run.duration);
        assert_eq!(states.len(), 12_001, "{}: there during the whole run", vehicle.callsign);
        let still = states.iter().filter(|(_, s)| s.is_still()).count();
        assert!(still > 20 * 60, "{}: still for {} s", vehicle.callsign, still / 20);
        let stands = states.chunk_by(|a, b| a.1.position_m == b.1.position_m).map(<[_]>::len);
        let longest = stands.max().unwrap_or(0);
        assert!(longest >= 20 * 30, "{}: {longest} frames to the last bit", vehicle.callsign);
        if vehicle.callsign != Callsign::new("FOLLOW1") {
            // FOLLOW1 sets off at 5 s.
            let first = states[0].1.position_m;
            assert!(
                states[..20 * 30].iter().all(|(_, s)| s.position_m == first),
                "to the last bit"
            );
        }
    }
}

/// FOLLOW1 drove at 14 m/s through AEE5ZH, which was taxiing out of the same stand (5.4 m deep, 61 to 65 s).
#[test]
fn nobody_of_zurich_overlaps_anybody() {
    use models::traffic::outline::{Size, distance_m, outline};
    let scene = zurich();
    let bodies: Vec<_> = scene
        .traffic
        .entities
        .iter()
        .map(|entity| {
            let class = &entity.class;
            let (length_m, span_m) = (class.length_m, class.span_m);
            (
                Size { length_m, span_m, aircraft: class.aircraft },
                states(entity, scene.run.duration),
            )
        })
        .collect();
    for (i, (size_a, a)) in bodies.iter().enumerate() {
        for (j, (size_b, b)) in bodies.iter().enumerate().skip(i + 1) {
            let mut at = b.iter().peekable();
            for (time, state) in a.iter().filter(|(_, s)| s.position_m.z < 15.0) {
                while at.next_if(|(t, _)| t < time).is_some() {}
                let Some((_, other)) =
                    at.peek().filter(|(t, s)| t == time && s.position_m.z < 15.0)
                else {
                    continue;
                };
                let (p, q) = (state.position_m.xy(), other.position_m.xy());
                if (p - q).norm() < 120.0 {
                    let gap = distance_m(
                        &outline(*size_a, p, state.heading_rad),
                        &outline(*size_b, q, other.heading_rad),
                    );
                    let name = |k: usize| scene.traffic.entities[k].callsign;
                    assert!(gap > 2.0, "{} and {}: {gap:.1} m at {} s", name(i), name(j), time.s());
                }
            }
        }
    }
}
