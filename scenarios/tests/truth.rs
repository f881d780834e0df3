//! The truth of the Zurich scene is physically sound at every frame, and lies where the runways are.

use models::frames::{Vector2, wrap_pi};
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

#[test]
fn every_mover_keeps_within_its_type_at_every_frame() {
    let scene = zurich();
    for entity in &scene.traffic.entities {
        let name = entity.callsign;
        let row = scene.traffic.types.get(&entity.class.designator).expect("a known type");
        let limits = Limits::of(row.class.aircraft, &row.kinematics);
        let states = states(entity, scene.run.duration);
        assert!(states.len() > 2000, "{name}: only {} frames", states.len());
        let mut before: Option<TruthState> = None;
        for (time, state) in &states {
            let at = format!("{name} at {:.2} s", time.s());
            let v = state.velocity_ms.xy();
            let nose = Vector2::new(libm::sin(state.heading_rad), libm::cos(state.heading_rad));
            let speed = v.norm();
            let along = state.acceleration_ms2.xy().dot(&nose);
            let across = (state.acceleration_ms2.xy() - nose * along).norm();
            // Heading is where it goes (or, pushed back, where it comes from); no sideways slip.
            assert!((v - nose * v.dot(&nose)).norm() <= 1e-6 * (1.0 + speed), "{at}: slips");
            let along = along * if v.dot(&nose) < 0.0 { -1.0 } else { 1.0 };
            assert!(speed <= limits.takeoff_ms.max(limits.landing_ms), "{at}: {speed} m/s");
            assert!(along <= 1.02 * limits.roll_acc_ms2, "{at}: accelerates with {along} m/s2");
            assert!(-along <= 1.02 * limits.roll_dec_ms2, "{at}: brakes with {along} m/s2");
            let lateral = if speed > limits.least_air_ms { 5.7 } else { 1.1 * limits.lateral_ms2 };
            assert!(across <= lateral, "{at}: lateral {across} m/s2");
            assert!(state.angular_rate_rads.z.abs() < 0.6, "{at}: turns too fast");
            assert!((0.0..500.0).contains(&state.position_m.z), "{at}: height");
            assert!(
                state.position_m.z == 0.0 || speed > limits.least_air_ms,
                "{at}: flies too slowly"
            );
            if let Some(last) = before {
                let step = (state.position_m - last.position_m).norm();
                assert!(
                    step <= 0.0501 * (speed.max(last.velocity_ms.norm()) + 1.6),
                    "{at}: jumps {step} m"
                );
                let change = (state.acceleration_ms2 - last.acceleration_ms2).xy().norm() / 0.05;
                assert!(change < 6.0, "{at}: jerk {change} m/s3");
                let turned = wrap_pi(state.heading_rad - last.heading_rad).abs();
                assert!(turned < 0.035, "{at}: heading jumps by {turned}");
                // Velocity is the derivative of position, acceleration that of velocity (trapezium rule).
                let mean = (state.velocity_ms + last.velocity_ms) * 0.5;
                let difference = (state.position_m - last.position_m) / 0.05;
                assert!((difference - mean).norm() < 0.02, "{at}: velocity is not the derivative");
                let mean = (state.acceleration_ms2 + last.acceleration_ms2) * 0.5;
                let difference = (state.velocity_ms - last.velocity_ms) / 0.05;
                assert!(
                    (difference - mean).norm() < 0.1,
                    "{at}: acceleration is not the derivative"
                );
            }
            before = Some(*state);
        }
    }
}

#[test]
fn runs_on_the_runway_are_on_its_centreline() {
    let scene = zurich();
    for (callsign, runway, within_m) in [
        ("EDW229", "28", 5.0),
        ("CAI3208", "14", 5.0),
        ("SWR137H", "28", 5.0),
        ("AEE5ZH", "28", 5.0),
        // Its received positions lie 5 to 9 m beside the centreline of the layout.
        ("ACA879", "16", 8.0),
        // Its positions lie on a grid of 13 m by 19 m: one step of it.
        ("ENT57BW", "28", 19.0),
    ] {
        let find = |e: &&Entity| e.callsign.as_str() == callsign;
        let entity = scene.traffic.entities.iter().find(find).expect(callsign);
        let runway = scene.airport.layout.runway(runway).expect("a runway of Zurich");
        let centre = (runway.ends_m[0] + runway.ends_m[1]) * 0.5;
        let half_m = (runway.ends_m[1] - runway.ends_m[0]).norm() * 0.5;
        let mut seen = 0;
        for (time, state) in states(entity, scene.run.duration) {
            let p = state.position_m.xy();
            let on_it = (p - centre).norm() < half_m - 100.0 && state.velocity_ms.norm() > 30.0;
            if on_it && state.position_m.z == 0.0 {
                seen += 1;
                let off_m = runway.distance_m(p);
                assert!(off_m <= within_m, "{callsign} at {:.1} s: {off_m:.1} m", time.s());
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
        let first = states[0].1.position_m;
        assert!(states[..20 * 30].iter().all(|(_, s)| s.position_m == first), "to the last bit");
    }
}
