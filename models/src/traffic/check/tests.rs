use super::*;
use crate::airport::{Edge, Hold, Node, Runway, Stand};
use crate::flight_list::WakeCategory;
use crate::frames::Azimuth;
use crate::frames::{Point2, Point3};

/// A runway from south to north, a taxiway beside it with one entry, a stand.
fn airport() -> Airport {
    let node = |name: &str, x: f64, y: f64, hold| Node {
        name: name.into(),
        position_m: Point2::new(x, y),
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
    let ends_m = [Point2::new(0.0, 0.0), Point2::new(0.0, 2500.0)];
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
            position_m: Point2::new(300.0, 900.0),
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
        wake: Some(WakeCategory::Medium.into()),
        direction: Some(direction),
        due_s: 0.0,
    }
}

fn seen(who: usize, x: f64, y: f64, vx: f64, vy: f64) -> Seen {
    let v = Vector2::new(vx, vy);
    let heading_rad = if v.norm() > 0.0 { Azimuth::of(v).rad() } else { 0.0 };
    Seen { who, position_m: Point3::new(x, y, 0.0), velocity_mps: v, heading_rad }
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

/// A bend of a right angle is driven on an arc of 45 m, whose middle is 13.2 m from both edges, and the middle of a long body 19 m:
/// the arc is a part of the network. Who cuts the corner by more than such an arc and a body on it is off.
#[test]
fn the_arc_over_a_bend_is_pavement() {
    // From the hold over the bend at (200, 100) to the north: the line of the nose, and the middle 0.4 of the length behind it
    // as the gear follows.
    let drive = |radius_m: f64, length_m: f64, wheelbase_m: f64| {
        let points = [(20.0, 100.0), (200.0, 100.0), (200.0, 400.0)];
        let points = points.map(|(x, y)| Point2::new(x, y));
        let (path, _) = crate::traffic::path::Path::over(&points, |_, _| radius_m);
        let mut c = checker(&[who("A", Direction::Departure)]);
        let (mut heading_rad, step_m) = (path.at(0.0).heading_rad, 0.5);
        for k in 0..(path.length_m() / step_m) as usize {
            let on = path.at(step_m * k as f64);
            heading_rad += step_m * libm::sin(on.heading_rad - heading_rad) / wheelbase_m;
            let middle = on.at_m - Azimuth::from_rad(heading_rad).unit() * (0.4 * length_m);
            let v = Azimuth::from_rad(heading_rad).unit() * 5.0;
            let one = seen(0, middle.x, middle.y, v.x, v.y);
            c.frame(0.1 * k as f64, &[one]);
        }
        let rows = c.finish(&[]);
        rows.iter().find(|r| r.name == "pavement").expect("a row").value
    };
    for (name, length_m, wheelbase_m) in
        [("A320", 37.6, 12.6), ("A333", 63.7, 25.4), ("B77W", 73.9, 31.2), ("A388", 72.7, 31.9)]
    {
        assert_eq!(drive(45.0, length_m, wheelbase_m), 1.0, "{name}");
    }
    assert!(drive(85.0, 37.6, 12.6) < 0.97, "an arc that nothing is paved for");
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
    assert!(
        drive(5.0, 1.1, 0.0).is_empty(),
        "one speed of two off by what dead reckoning lets pass"
    );
    assert_eq!(drive(5.0, 1.2, 0.0), ["accelerations"]);
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
        movers[0].wake = Some(WakeCategory::Heavy.into());
        movers[1].wake = Some(WakeCategory::Light.into());
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

/// A take-off sampled half a second behind its lift-off was 0.6 m/s faster than a roll may be.
#[test]
fn a_sample_behind_the_lift_off_is_not_taken_for_a_roll() {
    let roll = |rules: Rules, samples: &[(f64, f64)]| {
        let mut c = Checker::new(&airport(), vec![who("A", Direction::Departure)], rules);
        let mut y = 500.0;
        for (t, (speed, height)) in samples.iter().enumerate() {
            let mut s = seen(0, 0.0, y, 0.0, *speed);
            s.position_m.z = *height;
            c.frame(t as f64, &[s]);
            y += speed;
        }
        kept(&c.finish(&[]), "speeds")
    };
    // Half a second behind the lift-off, 0.06 m high; then clearly in the air.
    let lifts = |speed: f64| [(84.0, 0.0), (speed, 0.06), (87.0, 1.2), (88.0, 2.5)];
    assert!(roll(Rules::default(), &lifts(86.2)));
    assert!(!roll(Rules::default(), &lifts(88.0)), "faster than it can have become since");
    assert!(!roll(Rules::default(), &[(84.0, 0.0), (86.2, 0.0), (86.2, 0.0)]), "it rolls on");
    assert!(roll(Rules::exact(), &lifts(88.0)), "it flies");
    assert!(!roll(Rules::exact(), &[(85.4, 0.0), (86.0, 0.1), (86.0, 0.2)]), "it rolled too fast");
    assert!(roll(Rules::exact(), &[(85.2, 0.0), (86.0, 0.1), (86.0, 0.2)]));
}

#[test]
fn each_act_needs_its_clearance() {
    let fly = |kinds: &[ClearanceKind]| {
        let mut c = checker(&[who("A", Direction::Departure), who("B", Direction::Arrival)]);
        for t in 0..60 {
            let x = f64::from(t);
            let moves = if t < 10 { 0.0 } else { 2.0 };
            let mut a = seen(0, 300.0 - moves * (x - 10.0).max(0.0), 900.0, -moves, 0.0);
            a.position_m.z = if t > 40 { 20.0 } else { 0.0 };
            let mut b = seen(1, 0.0, 50.0 * x, 0.0, 50.0);
            b.position_m.z = (20.0 - x).max(0.0);
            c.frame(x, &[a, b]);
        }
        let given = kinds.iter().map(|kind| Given {
            who: usize::from(*kind == ClearanceKind::Land),
            kind: *kind,
            runway: if *kind == ClearanceKind::Push { "".into() } else { "36".into() },
            from_s: 1.0,
            until_s: f64::INFINITY,
        });
        let rows = c.finish(&given.collect::<Vec<_>>());
        rows.iter().find(|r| r.name == "clearances").map(|r| (r.value, r.of))
    };
    use ClearanceKind::{Land, Push, TakeOff};
    assert_eq!(fly(&[Push, TakeOff, Land]), Some((0.0, 3)));
    for missing in [Push, TakeOff, Land] {
        let others: Vec<_> = [Push, TakeOff, Land].into_iter().filter(|k| *k != missing).collect();
        assert_eq!(fly(&others), Some((1.0, 3)), "{missing:?}");
    }
}

/// The end of one runway in the strip of another: who is cleared to cross that one has both.
#[test]
fn a_clearance_holds_for_a_runway_whose_end_lies_in_the_strip() {
    let cross = |end_y: f64| {
        let mut a = airport();
        let ends_m = [Point2::new(-end_y, 120.0), Point2::new(-end_y - 1500.0, 120.0)];
        a.runways.push(Runway {
            names: ["27".into(), "09".into()],
            ends_m,
            thresholds_m: ends_m,
            width_m: 45.0,
        });
        let mut c = Checker::new(&a, vec![who("A", Direction::Departure)], Rules::default());
        for t in 0..60 {
            c.frame(f64::from(t), &[seen(0, 200.0 - 8.0 * f64::from(t), 100.0, -8.0, 0.0)]);
        }
        let kind = ClearanceKind::Cross;
        let given = Given { who: 0, kind, runway: "18/36".into(), from_s: 0.0, until_s: 60.0 };
        kept(&c.finish(&[given]), "holds")
    };
    assert!(cross(60.0));
    assert!(!cross(150.0), "its own strip begins farther on");
}
