use super::*;
use crate::airport::{Edge, Hold, Node, Runway, Stand};
use crate::frames::Azimuth;

/// A runway from south to north, a taxiway beside it with one entry, a stand.
fn airport() -> Airport {
    let node = |name: &str, x: f64, y: f64, hold| Node {
        name: name.into(),
        position_m: Vector2::new(x, y),
        hold,
    };
    let edge = |from, to| Edge {
        from,
        to,
        two_way: true,
        runway: false,
        name: String::new(),
        width_m: 23.0,
    };
    let ends_m = [Vector2::new(0.0, 0.0), Vector2::new(0.0, 2500.0)];
    Airport {
        runways: vec![Runway {
            names: ["36".into(), "18".into()],
            ends_m,
            thresholds_m: ends_m,
            width_m: 45.0,
        }],
        nodes: vec![
            node("on", 0.0, 100.0, Hold::None),
            node("hold", 90.0, 100.0, Hold::Runway),
            node("a", 200.0, 100.0, Hold::None),
            node("b", 200.0, 900.0, Hold::None),
            node("stand", 300.0, 900.0, Hold::None),
        ],
        edges: vec![edge(0, 1), edge(1, 2), edge(2, 3), edge(3, 4)],
        stands: vec![Stand {
            name: "S".into(),
            position_m: Vector2::new(300.0, 900.0),
            heading_rad: Azimuth::of(Vector2::new(1.0, 0.0)).rad(),
            node: Some(4),
        }],
        ..Airport::default()
    }
}

fn who(callsign: &str, direction: Direction) -> Who {
    Who {
        callsign: callsign.into(),
        size: Size { length_m: 37.57, span_m: 35.8, aircraft: true },
        limits: TypeLimits {
            taxi_mps: 15.4,
            taxi_mps2: (0.7, 0.7),
            runway_mps: 85.3,
            runway_mps2: (2.6, 3.0),
        },
        wake: Some(WakeCategory::Medium),
        direction: Some(direction),
        due_s: 0.0,
    }
}

fn seen(who: usize, x: f64, y: f64, vx: f64, vy: f64) -> Seen {
    let v = Vector2::new(vx, vy);
    let heading_rad = if v.norm() > 0.0 { Azimuth::of(v).rad() } else { 0.0 };
    Seen { who, position_m: Vector3::new(x, y, 0.0), velocity_mps: v, heading_rad }
}

fn checker(movers: &[Who]) -> Checker {
    Checker::new(&airport(), movers.to_vec(), Rules::default())
}

fn kept(rows: &[Row], name: &str) -> bool {
    rows.iter().find(|r| r.name == name).expect("a row").kept
}

fn broken(rows: &[Row]) -> Vec<&'static str> {
    rows.iter().filter(|r| !r.kept).map(|r| r.name).collect()
}

#[test]
fn a_taxi_along_the_network_breaks_nothing() {
    let mut c = checker(&[who("A", Direction::Departure)]);
    for t in 0..60 {
        c.frame(f64::from(t), &[seen(0, 200.0, 800.0 - 10.0 * f64::from(t), 0.0, -10.0)]);
    }
    assert_eq!(broken(&c.finish(&[])), Vec::<&str>::new());
}

#[test]
fn two_that_overlap_are_told_once() {
    let mut c = checker(&[who("A", Direction::Departure), who("B", Direction::Departure)]);
    for t in 0..10 {
        let apart = if t < 5 { 60.0 } else { 20.0 };
        c.frame(
            f64::from(t),
            &[seen(0, 200.0, 300.0, 0.0, 0.0), seen(1, 200.0, 300.0 + apart, 0.0, 0.0)],
        );
    }
    let rows = c.finish(&[]);
    let row = rows.iter().find(|r| r.name == "overlaps").expect("a row");
    assert_eq!((row.value, row.cases.len()), (1.0, 1));
    assert!(row.cases[0].starts_with("A and B"), "{}", row.cases[0]);
}

#[test]
fn who_leaves_the_network_is_off_the_pavement() {
    let share = |off_m: f64| {
        let mut c = checker(&[who("A", Direction::Departure)]);
        for t in 0..60 {
            c.frame(
                f64::from(t),
                &[seen(0, 200.0 + off_m, 800.0 - 10.0 * f64::from(t), 0.0, -10.0)],
            );
        }
        kept(&c.finish(&[]), "pavement")
    };
    assert!(share(11.0));
    assert!(!share(12.0));
}

#[test]
fn a_holding_position_needs_a_clearance_that_stands() {
    let enter = |from_s: f64, until_s: f64, runway: &str, kind| {
        let mut c = checker(&[who("A", Direction::Departure)]);
        for t in 0..20 {
            c.frame(f64::from(t), &[seen(0, 200.0 - 8.0 * f64::from(t), 100.0, -8.0, 0.0)]);
        }
        let given = Given { who: 0, kind, runway: runway.into(), from_s, until_s };
        kept(&c.finish(&[given]), "holds")
    };
    let line_up = ClearanceKind::LineUp;
    assert!(enter(5.0, f64::INFINITY, "36", line_up));
    assert!(enter(0.0, 30.0, "18/36", ClearanceKind::Cross));
    assert!(!enter(19.0, f64::INFINITY, "36", line_up), "given too late");
    assert!(!enter(0.0, 4.0, "36", line_up), "ended before");
    assert!(!enter(0.0, 30.0, "09", line_up), "of another runway");
    assert!(!enter(0.0, 30.0, "36", ClearanceKind::Taxi), "of another kind");
}

#[test]
fn one_roll_a_runway() {
    let roll = |other_y: f64, other_x: f64| {
        let mut c = checker(&[who("A", Direction::Departure), who("B", Direction::Departure)]);
        for t in 0..10 {
            let y = 500.0 + 40.0 * f64::from(t);
            c.frame(
                f64::from(t),
                &[seen(0, 0.0, y, 0.0, 40.0), seen(1, other_x, other_y, 0.0, 0.0)],
            );
        }
        kept(&c.finish(&[]), "runways")
    };
    assert!(!roll(1500.0, 0.0), "ahead on the runway");
    assert!(!roll(1500.0, 60.0), "ahead in the strip");
    assert!(roll(100.0, 0.0), "behind");
    assert!(roll(1500.0, 130.0), "beyond the strip");
}

#[test]
fn too_fast_too_hard_and_elsewhere() {
    let drive = |speed: f64, gain: f64, jump: f64| {
        let mut c = checker(&[who("A", Direction::Departure)]);
        let (mut y, mut v) = (200.0, speed);
        for t in 0..20 {
            c.frame(f64::from(t), &[seen(0, 300.0, y, 0.0, v)]);
            let next = if t == 8 { v + gain } else { v };
            y += 0.5 * (v + next) + if t == 12 { jump } else { 0.0 };
            v = next;
        }
        let rows = c.finish(&[]);
        broken(&rows).into_iter().filter(|n| *n != "pavement").collect::<Vec<_>>()
    };
    assert!(drive(15.0, 0.0, 0.0).is_empty());
    assert_eq!(drive(16.5, 0.0, 0.0), ["speeds"]);
    assert_eq!(drive(5.0, 1.5, 0.0), ["accelerations"]);
    assert_eq!(drive(5.0, -1.5, 0.0), ["accelerations"]);
    assert_eq!(drive(5.0, 0.0, 4.0), ["teleports"]);
}

#[test]
fn nothing_moves_and_somebody_waits_is_a_gridlock() {
    let stand = |x: f64, y: f64| {
        let mut c = checker(&[who("A", Direction::Arrival)]);
        c.frame(0.0, &[seen(0, x, y, 0.0, 5.0)]);
        for t in 1..1400 {
            c.frame(f64::from(t), &[seen(0, x, y, 0.0, 0.0)]);
        }
        let rows = c.finish(&[]);
        (kept(&rows, "gridlocks"), kept(&rows, "stuck"))
    };
    assert_eq!(stand(200.0, 400.0), (false, false));
    assert_eq!(stand(300.0, 900.0), (true, true), "on its stand");
}

#[test]
fn served_is_airborne_or_on_a_stand() {
    let fly = |climbs: bool, direction, ends_on_stand: bool| {
        let mut c = checker(&[who("A", direction)]);
        let high = |t: i32| {
            let up = if direction == Direction::Departure { t > 100 } else { t < 100 };
            if up && climbs { 50.0 } else { 0.0 }
        };
        for t in 0..2000 {
            let (x, y) = if ends_on_stand { (300.0, 900.0) } else { (200.0, 500.0) };
            let mut s = seen(0, x, y, 0.0, 0.0);
            s.position_m.z = high(t);
            c.frame(f64::from(t), &[s]);
        }
        kept(&c.finish(&[]), "served")
    };
    assert!(fly(true, Direction::Departure, true));
    assert!(!fly(false, Direction::Departure, true));
    assert!(fly(true, Direction::Arrival, true));
    assert!(!fly(true, Direction::Arrival, false));
}

#[test]
fn a_light_one_takes_off_two_minutes_behind_a_heavy_one() {
    let gap = |gap_s: i32| {
        let mut movers = [who("H", Direction::Departure), who("L", Direction::Departure)];
        movers[0].wake = Some(WakeCategory::Heavy);
        movers[1].wake = Some(WakeCategory::Light);
        let mut c = checker(&movers);
        for t in 0..300 {
            let one = |who: usize, lifts: i32| {
                let mut s = seen(who, 0.0, 200.0 + 100.0 * who as f64, 0.0, 0.0);
                s.position_m.z = f64::from((t - lifts).clamp(0, 100)) * 5.0;
                s
            };
            c.frame(f64::from(t), &[one(0, 20), one(1, 20 + gap_s)]);
        }
        kept(&c.finish(&[]), "wake")
    };
    assert!(gap(121));
    assert!(!gap(100));
}
