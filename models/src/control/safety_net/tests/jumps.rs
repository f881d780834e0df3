//! What a jump, an echo or a lost name makes of a track: nobody lands, creeps, stands or lifts off otherwise by it.

use super::places::{cleared, first, noise, seen, with_bar};
use super::*;
use crate::frames::Point2;

/// A light aircraft on its approach, slower than what is taken for a final: at one second its track jumps and is slow.
fn light(jump_s: u32, jump_m: f64, jump_mps: f64) -> impl Fn(u32) -> Vec<Target> {
    move |s: u32| {
        let t = f64::from(s);
        let (off_m, v) = if s == jump_s { (jump_m, jump_mps) } else { (0.0, 29.0) };
        let at = (0.0, -1500.0 + 29.0 * t + off_m);
        vec![Target { arriving: true, ..target(1, "ABC1", at, (0.0, v), s) }]
    }
}

/// At nine airports of light traffic one slow speed in a jump took arrivals for taxiing ones: `HIGH_SPEED`, `NOCLR_TAXI`.
#[test]
fn one_slow_speed_of_a_jump_takes_no_arrival_from_the_air() {
    let board = cleared("ABC1", ClearanceKind::Land, 0);
    let found = |speed_mps| {
        let targets = light(20, -9.0, speed_mps);
        seen(&layout(), &board, Parameters::on_tracks(), 45, targets)
    };
    assert_eq!((found(29.0), found(12.0)), (vec![], vec![]));
    // Who has really been slow is on the ground.
    let slow = |s: u32| {
        let t = f64::from(s);
        let (x, v) = if s < 20 { (10.0 * t, 10.0) } else { (200.0 + 29.0 * (t - 20.0), 29.0) };
        vec![Target { arriving: true, ..target(1, "ABC1", (300.0 + x, 900.0), (v, 0.0), s) }]
    };
    let told = seen(&layout(), &board, Parameters::on_tracks(), 45, slow);
    assert!(first(&told, "HIGH_SPEED").is_some(), "{told:?}");
}

/// A speed of 42 m/s in one scan made it one that had been on final: its landing without clearance was told as another kind than on truth.
#[test]
fn one_fast_speed_of_a_jump_is_no_final() {
    let mut board = Board::default();
    board.strip(Callsign::new("ABC1"));
    let told = seen(&layout(), &board, Parameters::on_tracks(), 80, light(20, 9.0, 42.0));
    assert_eq!(first(&told, "NOCLR_LND"), None, "{told:?}");
    assert!(first(&told, "NOCLR_TOF").is_some(), "{told:?}");
}

/// Pushed back along the edge of a strip, its nose 3 m outside: noise put it in (11 false alerts in fifteen hours at one airport). Who is pushed
/// in is told of, soon.
#[test]
fn who_is_pushed_along_a_strip_is_not_in_it_by_noise() {
    let board = cleared("ABC1", ClearanceKind::Push, 0);
    // The strip reaches to 82.5 m.
    let told = |parameters, noise: fn(u32) -> f64, x: &dyn Fn(u32) -> f64| {
        let one = |s: u32| {
            let at = (x(s) + noise(s), 1000.0 + 1.5 * f64::from(s) + noise(s + 4));
            let v = (x(s) - x(s - 1) + 0.2 * noise(s + 2), 1.5 + 0.2 * noise(s + 6));
            vec![target(1, "ABC1", at, v, s)]
        };
        first(&seen(&layout(), &board, parameters, 70, one), "NOCLR_RWY")
    };
    let along = |_: u32| 85.5;
    assert_eq!(told(Parameters::on_tracks(), noise, &along), None);
    let inward = |s: u32| 125.0 - 1.2 * f64::from(s.max(20) - 20);
    let exact = told(Parameters::default(), |_| 0.0, &inward).expect("raised");
    let tracks = told(Parameters::on_tracks(), noise, &inward).expect("raised");
    assert!((exact - 1..=exact + 3).contains(&tracks), "{tracks} and {exact}");
}

/// Stands beside a line and has never moved: by one jump towards the runway its nose was half a length ahead of it, over the bar and in the strip.
#[test]
fn who_stands_has_no_nose_by_a_jump() {
    let mut board = Board::default();
    board.strip(Callsign::new("ABC1"));
    for far_m in [92.5, 95.0, 100.0] {
        let stands = |s: u32| {
            let (off_m, v) = if s % 25 == 15 { (-3.0, -4.0) } else { (0.0, 0.0) };
            vec![target(1, "ABC1", (far_m + off_m + 0.3 * noise(s), 1000.0), (v, 0.0), s)]
        };
        let told = seen(&with_bar(), &board, Parameters::on_tracks(), 120, stands);
        assert_eq!(told, vec![], "{far_m} m");
    }
}

/// After its take-off the track of a light aircraft loses its name and strays from the runway: it is the same one in the air.
#[test]
fn who_has_lifted_off_flies_under_his_old_name() {
    let told = |name_until: u32, slow_at: u32| {
        let mut board = Board::default();
        assert!(board.give(Clearance {
            callsign: Callsign::new("ABC1"),
            kind: ClearanceKind::TakeOff,
            runway: Some((0, Some(0))),
            place_m: None,
            from: SimTime::from_s(1.0),
            until: Some(SimTime::from_s(20.0)),
        }));
        let rolls = |s: u32| {
            let t = f64::from(s);
            let v = (2.0 * t).min(36.0);
            let y = 200.0 + if s < 18 { t * t } else { 324.0 + 36.0 * (t - 18.0) };
            let x = 1.5 * (t - 20.0).max(0.0);
            let named = if s < name_until { "ABC1" } else { "" };
            let v = if s == slow_at { 15.0 } else { v };
            vec![target(1, named, (x, y), (0.0, v), s)]
        };
        seen(&layout(), &board, Parameters::on_tracks(), 50, rolls)
    };
    assert_eq!(told(99, 99), vec![]);
    assert_eq!(told(25, 99), vec![], "without its name");
    assert_eq!(told(99, 30), vec![], "slow by a jump");
}

/// Flies over the far end of a runway on which somebody rolls: on exact truth that was one ahead in the strip, which no track without altitude
/// can be. Along the runway it is.
#[test]
fn who_flies_across_a_runway_is_over_its_strip() {
    let told = |v: (f64, f64), altitude_m| {
        let mut board = cleared("ABC1", ClearanceKind::TakeOff, 0);
        board.strip(Callsign::new("XYZ2"));
        let targets = |s: u32| {
            let t = f64::from(s);
            let rolls = Target {
                altitude_m: Some(0.0),
                ..target(1, "ABC1", (0.0, 200.0 + 20.0 * t), (0.0, 20.0), s)
            };
            let at = (v.0 * (t - 10.0), 1500.0 + v.1 * t);
            vec![rolls, Target { altitude_m: Some(altitude_m), ..target(2, "XYZ2", at, v, s) }]
        };
        let found = seen(&layout(), &board, Parameters::default(), 20, targets);
        first(&found, "RMCA_ROLL").is_some()
    };
    assert!(!told((55.0, 5.0), 60.0), "across, in the air");
    assert!(told((12.0, 1.0), 0.0), "across, on the ground");
    assert!(told((0.0, 14.0), 60.0), "along it");
}

/// Two ways meet before a runway, one held at 93 m, the other 33 m on at 84 m: who stops at the second has not passed the first.
#[test]
fn of_bars_beside_each_other_one_passes_that_of_his_way() {
    let bar = |place_m, across_m| StopBar {
        runway: 0,
        place_m,
        across_m: Some(across_m),
        entry_m: 1020.0,
        lit: true,
    };
    let layout = Layout { bars: vec![bar(1000.0, 93.0), bar(1033.0, 84.0)], ..layout() };
    let board = cleared("ABC1", ClearanceKind::Taxi, 0);
    let told = |y: f64, last_m: f64| {
        let comes = |s: u32| {
            let x = (180.0 - 4.0 * f64::from(s)).max(last_m + 19.0);
            let v = if x > last_m + 19.0 { -4.0 } else { 0.0 };
            vec![target(1, "ABC1", (x, y), (v, 0.0), s)]
        };
        [Parameters::default(), Parameters::on_tracks()]
            .map(|p| first(&seen(&layout, &board, p, 45, comes), "STOPBAR").is_some())
    };
    assert_eq!(told(1033.0, 88.0), [false; 2], "stops at the second");
    assert_eq!(told(1033.0, 70.0), [true; 2], "passes the second");
    assert_eq!(told(1000.0, 88.0), [true; 2], "passes the first");
}

/// The echo of one who is beyond the radar's unambiguous range flies down the same final at his speed there, which nobody has so near.
#[test]
fn the_echo_of_a_far_final_is_nobody() {
    let told = |speed_mps: f64| {
        let comes = |s: u32| {
            let at = (2.0 * noise(s), -4600.0 + speed_mps * f64::from(s));
            let mut one = target(7, "", at, (0.0, speed_mps + noise(s)), s);
            one.first = s == 1;
            vec![one]
        };
        first(&seen(&layout(), &Board::default(), Parameters::on_tracks(), 45, comes), "NOCLR_LND")
    };
    assert_eq!(told(83.0), None);
    assert!(told(72.0).is_some());
}

/// The double of one who goes around falls behind him, slower and slower: it is nobody who has come onto the runway.
#[test]
fn the_double_of_one_who_flies_falls_behind_him() {
    let told = |beside: bool| {
        let board = cleared("ABC1", ClearanceKind::GoAround, 0);
        let targets = |s: u32| {
            let t = f64::from(s);
            let flies = target(1, "ABC1", (0.0, 500.0 + 29.0 * t), (0.0, 29.0), s);
            let mut all = vec![flies];
            if s >= 10 {
                let from = if beside { 780.0 } else { 2400.0 };
                let y = from + 12.0 * (t - 10.0);
                all.push(Target { first: s == 10, ..target(7, "", (3.0, y), (0.0, 12.0), s) });
            }
            all
        };
        let found = seen(&layout(), &board, Parameters::on_tracks(), 17, targets);
        first(&found, "NOCLR_RWY").is_some()
    };
    assert!(!told(true));
    assert!(told(false), "somebody else");
}

/// A new track of one who stands begins 30 m off: that is no push-back.
#[test]
fn where_a_track_was_in_its_first_seconds_moves_nobody() {
    let mut board = Board::default();
    board.strip(Callsign::new("ABC1")).expect("room").stand_m = Some(Point2::new(600.0, 900.0));
    let told = |off_m: &dyn Fn(u32) -> f64| {
        let stands = |s: u32| {
            let v = off_m(s) - off_m(s - 1);
            vec![target(1, "ABC1", (600.0 + off_m(s), 900.0), (0.4 * v, 0.0), s)]
        };
        first(&seen(&layout(), &board, Parameters::on_tracks(), 40, stands), "NOCLR_PUSH")
    };
    let begins =
        |s: u32| [0.0, 15.0, 24.0, 8.0, 4.0, 2.0, 1.0].get(s as usize).copied().unwrap_or(0.0);
    assert_eq!(told(&|s| begins(s) + 0.8 * noise(s)), None);
    assert!(told(&|s| 1.5 * f64::from(s.max(5) - 5)).is_some(), "pushed");
}
