use super::*;
use crate::control::clearance::{Clearance, ClearanceKind};
use crate::control::layout::RunwayAxis;
use crate::control::situation::TargetClass;
use crate::frames::Point2;
use crate::frames::Vector2;

mod jumps;
mod low_finals;
mod places;
mod sets_off;
mod stands;

/// A runway from the origin to the north, 3 km.
fn layout() -> Layout {
    let ends = [Point2::new(0.0, 0.0), Point2::new(0.0, 3000.0)];
    let axis = RunwayAxis::new(["36".into(), "18".into()], ends, 45.0, 90.0);
    Layout::new(axis.into_iter().collect())
}

fn target(number: u16, name: &str, at: (f64, f64), v: (f64, f64), second: u32) -> Target {
    let now = SimTime::from_s(f64::from(second));
    Target {
        number,
        callsign: (!name.is_empty()).then(|| Callsign::new(name)),
        class: if name.is_empty() { TargetClass::Unknown } else { TargetClass::Aircraft },
        arriving: false,
        length_m: if name.is_empty() { 0.0 } else { 38.0 },
        position_m: Point2::new(at.0, at.1),
        velocity_mps: Vector2::new(v.0, v.1),
        altitude_m: None,
        last_plot: now,
        first: second == 1,
    }
}

/// What is raised, with the second, while `targets` gives the tracks of each second.
fn raised(
    parameters: Parameters,
    seconds: u32,
    targets: impl Fn(u32) -> Vec<Target>,
) -> Vec<(u32, String)> {
    let mut board = Board::default();
    board.strip(Callsign::new("ABC1"));
    raised_with(board, parameters, seconds, targets)
}

/// The same with the strips and clearances of `board`.
fn raised_with(
    mut board: Board,
    parameters: Parameters,
    seconds: u32,
    targets: impl Fn(u32) -> Vec<Target>,
) -> Vec<(u32, String)> {
    let mut net = SafetyNet::new(layout(), parameters);
    let mut found = Vec::new();
    for second in 1..=seconds {
        let targets = targets(second);
        board.advance(SimTime::from_s(f64::from(second)));
        let scan = Scan {
            now: SimTime::from_s(f64::from(second)),
            targets: &targets,
            board: &board,
            bars: &[],
            areas: &[],
            low_visibility: false,
        };
        for (change, alert) in net.scan(&scan) {
            if *change == Change::Raised {
                found.push((second, alert.condition.kind.word()));
            }
        }
    }
    found
}

#[test]
fn a_track_without_a_name_raises_an_alert_when_it_is_four_seconds_old() {
    let stands = |s: u32| vec![target(7, "", (30.0, 1000.0), (0.0, 0.0), s)];
    let exact = raised(Parameters::default(), 10, stands);
    assert_eq!(exact, [(1, "NOCLR_RWY".into())]);
    assert_eq!(raised(Parameters::on_tracks(), 10, stands), [(5, "NOCLR_RWY".into())]);
    // A named one a second earlier.
    let named = |s: u32| vec![target(7, "ABC1", (30.0, 1000.0), (0.0, 0.0), s)];
    assert_eq!(raised(Parameters::on_tracks(), 10, named), [(4, "NOCLR_RWY".into())]);
    // Who comes in when his track is old, in the scan in which he does.
    let enters =
        |s: u32| vec![target(7, "ABC1", (180.0 - 6.0 * f64::from(s), 1000.0), (-6.0, 0.0), s)];
    let when = |parameters| {
        let all = raised(parameters, 30, enters);
        all.iter().find(|r| r.1 == "NOCLR_RWY").map(|r| r.0)
    };
    assert_eq!(when(Parameters::on_tracks()), when(Parameters::default()));
    assert!(when(Parameters::default()).is_some());
}

/// A radar alone names nobody: whoever entered a runway by his clearance was "without clearance" (299 false alerts in six hours).
#[test]
fn a_track_without_a_name_may_be_one_who_is_cleared_and_whom_no_track_is_known_to_be() {
    let board = || {
        let mut board = Board::default();
        board.give(Clearance {
            callsign: Callsign::new("ABC1"),
            kind: ClearanceKind::LineUp,
            runway: Some((0, None)),
            place_m: None,
            from: SimTime::from_s(1.0),
            until: None,
        });
        board
    };
    let enters = |number, x: f64| {
        move |s: u32| target(number, "", (x - 6.0 * f64::from(s), 300.0), (-6.0, 0.0), s)
    };
    let count = |parameters, targets: &dyn Fn(u32) -> Vec<Target>| {
        let all = raised_with(board(), parameters, 25, targets);
        all.iter().filter(|r| r.1 == "NOCLR_RWY").count()
    };
    let one = |s: u32| vec![enters(4, 180.0)(s)];
    assert_eq!(count(Parameters::on_tracks(), &one), 0);
    assert_eq!(count(Parameters::default(), &one), 1, "exact truth has names");
    // Two of them, and one clearance.
    let far = |s: u32| target(5, "", (180.0 - 6.0 * f64::from(s), 2000.0), (-6.0, 0.0), s);
    let two = |s: u32| vec![enters(4, 180.0)(s), far(s)];
    assert_eq!(count(Parameters::on_tracks(), &two), 2);
    // The one who is cleared is seen elsewhere.
    let seen = |s: u32| vec![target(3, "ABC1", (800.0, 900.0), (0.0, 0.0), s), enters(4, 180.0)(s)];
    assert_eq!(count(Parameters::on_tracks(), &seen), 1);
}

#[test]
fn the_double_of_a_named_track_raises_nothing() {
    let beside = |off_m: f64| {
        move |s: u32| {
            vec![
                target(3, "ABC1", (150.0, 1000.0), (0.0, 0.0), s),
                target(7, "", (150.0 - off_m, 1000.0), (0.0, 0.0), s),
            ]
        }
    };
    let of = |off_m| raised(Parameters::on_tracks(), 20, beside(off_m)).len();
    assert_eq!((of(78.0), of(140.0)), (1, 1), "farther than 45 m: another one");
    let near = |s: u32| {
        vec![
            target(3, "ABC1", (100.0, 1000.0), (0.0, 0.0), s),
            target(7, "", (70.0, 1000.0), (0.0, 0.0), s),
        ]
    };
    assert!(raised(Parameters::on_tracks(), 20, near).is_empty());
    assert_eq!(raised(Parameters::default(), 20, near).len(), 1);
}

#[test]
fn an_echo_that_flies_along_a_runway_is_no_roll_and_a_roll_from_rest_is_one() {
    let flies = |s: u32| vec![target(9, "", (0.0, -500.0 + 79.0 * f64::from(s)), (2.0, 79.0), s)];
    assert!(raised(Parameters::on_tracks(), 40, flies).is_empty());
    assert!(!raised(Parameters::default(), 40, flies).is_empty());
    let rolls = |s: u32| {
        let t = f64::from(s.saturating_sub(10));
        vec![target(9, "", (0.0, 300.0 + t * t), (0.0, 2.0 * t), s)]
    };
    let found = raised(Parameters::on_tracks(), 40, rolls);
    let exact = raised(Parameters::default(), 40, rolls);
    let roll = |all: &[(u32, String)]| all.iter().find(|r| r.1 == "NOCLR_TOF").map(|r| r.0);
    assert_eq!(roll(&found), roll(&exact));
    assert!(roll(&found).is_some());
}

/// The second echo of one on final, 7.5 km short of him, got his name and was high speed on a taxiway.
#[test]
fn what_crosses_the_airport_at_eighty_and_never_was_slow_is_no_taxiing() {
    let mut found = 0;
    for (v, most) in [(82.0, 0), (30.0, 1)] {
        let passes =
            |s: u32| vec![target(6, "ABC1", (-900.0 + v * f64::from(s), 900.0), (v, 0.0), s)];
        let all = raised(Parameters::on_tracks(), 9, passes);
        let alerts = all.iter().filter(|r| r.1 == "HIGH_SPEED").count();
        assert!(alerts <= most, "{v}: {all:?}");
        found += alerts;
    }
    assert_eq!(found, 1, "somebody who drives much too fast is told of");
    // The scan in which the name goes from it to who it is of, and is kept for a while, makes no other of it.
    let loses = |s: u32| {
        let name = if s < 7 { "ABC1" } else { "" };
        vec![target(6, name, (-900.0 + 82.0 * f64::from(s), 900.0), (82.0, 0.0), s)]
    };
    let all = raised(Parameters::on_tracks(), 12, loses);
    assert!(all.is_empty(), "{all:?}");
}

/// A track that says 18 to 28 m/s of somebody who drives along the runway at 11 is no roll; rolls of every acceleration that
/// aircraft have are raised when they are on exact truth, at most a second later.
#[test]
fn a_speed_that_its_places_do_not_show_is_no_take_off() {
    let drives = |says: f64| {
        move |s: u32| {
            let y = 300.0 + 11.0 * f64::from(s);
            vec![target(5, "ABC1", (0.0, y), (0.0, says), s)]
        }
    };
    let take_off = |found: &[(u32, String)]| found.iter().find(|r| r.1 == "NOCLR_TOF").map(|r| r.0);
    for says in [18.5, 22.0, 28.0] {
        assert_eq!(take_off(&raised(Parameters::on_tracks(), 60, drives(says))), None, "{says}");
        assert!(take_off(&raised(Parameters::default(), 60, drives(says))).is_some());
    }
    for mps2 in [1.0, 1.8, 2.5, 3.0] {
        let rolls = |s: u32| {
            let t = f64::from(s.saturating_sub(15));
            vec![target(5, "ABC1", (0.0, 300.0 + 0.5 * mps2 * t * t), (0.0, mps2 * t), s)]
        };
        let exact = take_off(&raised(Parameters::default(), 40, rolls)).expect("a roll");
        let found = take_off(&raised(Parameters::on_tracks(), 40, rolls)).expect("a roll");
        assert!((exact..=exact + 1).contains(&found), "{mps2} m/s²: {exact} s, {found} s");
    }
}

#[test]
fn a_velocity_that_jumps_is_no_speed_and_a_steady_one_is() {
    let at = |v: f64, swing: f64| {
        move |s: u32| {
            let other = if s.is_multiple_of(4) { swing } else { 0.0 };
            vec![target(5, "ABC1", (600.0, v * f64::from(s)), (0.0, v + other), s)]
        }
    };
    let of = |v, swing| {
        let found = raised(Parameters::on_tracks(), 60, at(v, swing));
        found.iter().filter(|r| r.1 == "HIGH_SPEED").count()
    };
    assert_eq!(of(9.0, 0.0), 0);
    assert_eq!(of(9.0, 13.0), 0, "a speed that its places do not show");
    assert_eq!(of(22.0, 0.0), 1);
}

/// An aircraft on its stand whose track is drawn away by one that passes, at 12 m/s at once, and comes back: no push-back.
#[test]
fn a_parked_track_that_is_drawn_away_is_no_push_back_and_a_push_back_is_one() {
    let pushed = |place: fn(f64) -> f64| {
        let mut net = SafetyNet::new(layout(), Parameters::on_tracks());
        let mut board = Board::default();
        if let Some(strip) = board.strip(Callsign::new("ABC1")) {
            strip.stand_m = Some(Point2::new(600.0, 500.0));
        }
        let mut found = None;
        for second in 1..=80_u32 {
            let (t, before) = (f64::from(second), f64::from(second - 1));
            let speed_mps = place(t) - place(before);
            let targets = [target(7, "ABC1", (600.0, 500.0 + place(t)), (0.0, speed_mps), second)];
            let scan = Scan {
                now: SimTime::from_s(t),
                targets: &targets,
                board: &board,
                bars: &[],
                areas: &[],
                low_visibility: false,
            };
            let raised = net.scan(&scan).iter().any(|(_, a)| {
                a.condition.kind == crate::control::alert::AlertKind::NoPushClearance
            });
            if raised && found.is_none() {
                found = Some(second);
            }
        }
        found
    };
    let drawn = |t: f64| match t - 40.0 {
        t if t <= 0.0 => 0.0,
        t if t <= 3.0 => 12.0 * t,
        t if t <= 12.0 => 36.0 - 4.0 * (t - 3.0),
        _ => 0.0,
    };
    assert_eq!(pushed(drawn), None);
    // 0.2 m/s² to 1.5 m/s from 40 s on: within 14 s.
    let backs = |t: f64| match (t - 40.0).max(0.0) {
        t if t <= 7.5 => 0.1 * t * t,
        t => 5.625 + 1.5 * (t - 7.5),
    };
    assert!(pushed(backs).is_some_and(|s| (49..=54).contains(&s)), "{:?}", pushed(backs));
}

/// A name that another track had a moment ago is not believed at once; one that comes without a bearer is.
#[test]
fn a_name_that_is_taken_over_is_doubted_for_eight_seconds() {
    let when = |other: bool| {
        let found = raised(Parameters::on_tracks(), 60, |s| {
            let stands = |number, name, x| target(number, name, (x, 1000.0), (0.0, 0.0), s);
            match (other, s < 20) {
                (true, true) => vec![stands(3, "ABC1", 400.0), stands(7, "", 900.0)],
                (false, true) => vec![stands(7, "", 900.0)],
                // The number 7 jumps nowhere: it stands on the runway from its first scan with the name on.
                _ => vec![Target { first: s == 20, ..stands(8, "ABC1", 30.0) }],
            }
        });
        found.iter().find(|r| r.1 == "NOCLR_RWY").map(|r| r.0)
    };
    assert_eq!((when(false), when(true)), (Some(23), Some(28)));
}

/// Who goes around is not on final, and without altitude he is in the air: nobody below is in his way.
#[test]
fn who_was_sent_around_lands_no_more() {
    let kinds = |sent: bool| {
        let mut net = SafetyNet::new(layout(), Parameters::on_tracks());
        let mut board = Board::default();
        let give = |board: &mut Board, name: &str, kind| {
            board.give(Clearance {
                callsign: Callsign::new(name),
                kind,
                runway: Some((0, Some(0))),
                place_m: None,
                from: SimTime::from_s(0.0),
                until: None,
            })
        };
        give(&mut board, "ABC1", if sent { ClearanceKind::GoAround } else { ClearanceKind::Land });
        give(&mut board, "CAR1", ClearanceKind::Enter);
        let mut found = Vec::new();
        for second in 1..=70_u32 {
            let t = f64::from(second);
            board.advance(SimTime::from_s(t));
            let y = -3500.0 + 70.0 * t;
            let targets = [
                target(3, "ABC1", (0.0, y), (0.0, 70.0), second),
                target(7, "CAR1", (20.0, 1000.0), (0.0, 0.0), second),
            ];
            let scan = Scan {
                now: SimTime::from_s(t),
                targets: &targets,
                board: &board,
                bars: &[],
                areas: &[],
                low_visibility: false,
            };
            found.extend(net.scan(&scan).iter().map(|(_, a)| a.condition.kind.word()));
        }
        found.retain(|k| k.starts_with("RMCA"));
        found.dedup();
        found
    };
    assert_eq!(kinds(true), Vec::<String>::new());
    assert_eq!(kinds(false)[..2], ["RMCA_ARR", "RMCA_ROLL"].map(str::to_owned));
}

/// The nose of one that stands before a line is where its way leads, not where the noise of its velocity points.
#[test]
fn the_nose_of_a_standing_track_does_not_turn_with_its_noise() {
    let at = |on_way: bool| {
        let mut net = SafetyNet::new(layout(), Parameters::on_tracks());
        let mut board = Board::default();
        if let Some(strip) = board.strip(Callsign::new("ABC1")).filter(|_| on_way) {
            strip.way_m = (0..40).map(|i| Point2::new(110.0, 800.0 + 8.0 * f64::from(i))).collect();
        }
        let mut worst: f64 = 0.0;
        for second in 1..=40_u32 {
            let noise = if second % 2 == 0 { 1.5 } else { -1.5 };
            let targets = [target(3, "ABC1", (110.0 + noise, 900.0), (-2.0 * noise, 0.3), second)];
            let scan = Scan {
                now: SimTime::from_s(f64::from(second)),
                targets: &targets,
                board: &board,
                bars: &[],
                areas: &[],
                low_visibility: false,
            };
            net.scan(&scan);
            let situation = net.surveillance().situations()[0];
            worst = worst.max((situation.nose_m - Point2::new(110.0, 919.0)).norm());
        }
        worst
    };
    assert!(at(true) < 2.0, "{}", at(true));
    assert!(at(false) > 5.0, "{}", at(false));
}

/// A clearance that ended as the wheels left the ground, and a go-around, are somebody's: of a track without a name, too, but of one
/// only, and on that runway only.
#[test]
fn who_just_flew_or_was_sent_around_may_be_the_track_without_a_name() {
    let give = |kind, until_s: Option<f64>| {
        let mut board = Board::default();
        board.give(Clearance {
            callsign: Callsign::new("ABC1"),
            kind,
            runway: Some((0, Some(0))),
            place_m: None,
            from: SimTime::from_s(1.0),
            until: until_s.map(SimTime::from_s),
        });
        board
    };
    let rolls = |x: f64| {
        move |s: u32| {
            let t = f64::from(s.saturating_sub(10));
            target(9, "", (x, 300.0 + t * t), (0.0, 2.0 * t), s)
        }
    };
    let comes = |number: u16, x: f64| {
        move |s: u32| target(number, "", (x, -4000.0 + 70.0 * f64::from(s)), (0.0, 70.0), s)
    };
    let count = |board, seconds, kind: &str, targets: &dyn Fn(u32) -> Vec<Target>| {
        let all = raised_with(board, Parameters::on_tracks(), seconds, targets);
        all.iter().filter(|r| r.1 == kind).count()
    };
    let roll = |s: u32| vec![rolls(0.0)(s)];
    let taken_off = |until| give(ClearanceKind::TakeOff, Some(until));
    assert_eq!(count(taken_off(18.0), 45, "NOCLR_TOF", &roll), 0, "wheels up in the 18th second");
    assert_eq!(count(Board::default(), 45, "NOCLR_TOF", &roll), 1);
    let one = |s: u32| vec![comes(4, 0.0)(s)];
    let around = || give(ClearanceKind::GoAround, None);
    assert_eq!(count(around(), 50, "NOCLR_LND", &one), 0);
    assert_eq!(count(Board::default(), 50, "NOCLR_LND", &one), 1);
    let two = |s: u32| vec![comes(4, 0.0)(s), target(5, "", (20.0, 900.0), (0.0, 0.0), s)];
    assert_eq!(count(around(), 50, "NOCLR_LND", &two), 1, "two without a name, one sent around");
}

/// A roll whose track lags and then catches up by a leap along the runway is told of like one that is followed (it was 5 s late).
#[test]
fn a_roll_that_a_lagging_track_catches_up_with_is_told_of_at_once() {
    let roll = |lag: bool| {
        let rolls = move |s: u32| {
            let t = f64::from(s.saturating_sub(15));
            let followed = |t: f64| (300.0 + 1.3 * t * t, 2.6 * t);
            let (y, v) = match t {
                // Seven seconds behind half of the way, then where it is.
                t if lag && t <= 5.0 => (300.0 + 0.3 * t * t, 0.6 * t),
                t => followed(t),
            };
            vec![target(5, "ABC1", (0.0, y), (0.0, v), s)]
        };
        let found = raised(Parameters::on_tracks(), 40, rolls);
        found.iter().find(|r| r.1 == "NOCLR_TOF").map(|r| r.0).expect("a roll")
    };
    assert!(roll(true) <= roll(false) + 1, "{} {}", roll(true), roll(false));
}

/// One that taxies along a runway and leaps ahead for a scan does not take off.
#[test]
fn a_leap_along_the_runway_is_no_take_off() {
    let leaps = |ahead_m: f64| {
        raised(Parameters::on_tracks(), 60, move |s| {
            let y = 300.0 + 8.0 * f64::from(s);
            let (y, v) = if s == 40 { (y + ahead_m, 8.0 + ahead_m) } else { (y, 8.0) };
            vec![target(5, "ABC1", (0.0, y), (0.0, v), s)]
        })
    };
    for ahead_m in [9.0, 13.0, 16.0, 25.0] {
        let found = leaps(ahead_m);
        assert!(found.iter().all(|r| r.1 != "NOCLR_TOF"), "{ahead_m} m: {found:?}");
    }
}

/// A leap onto a runway is doubted; that of one who is on it makes no difference to those who come.
#[test]
fn who_leaps_onto_a_runway_is_doubted_and_who_leaps_on_it_is_not() {
    let when = |from_x: f64| {
        raised(Parameters::on_tracks(), 40, move |s| {
            let x = if s < 20 { from_x } else { 30.0 };
            vec![target(5, "ABC1", (x, 1000.0), (0.0, 0.0), s)]
        })
    };
    assert_eq!(when(200.0), [(26, "NOCLR_RWY".into())]);
    // On it from the first scan on, whatever it does there.
    assert_eq!(when(-30.0), [(4, "NOCLR_RWY".into())]);
    let comes = |leaps: bool| {
        let found = raised(Parameters::on_tracks(), 60, move |s| {
            let y = if leaps && s >= 30 { 1060.0 } else { 1000.0 };
            let last = -70.0 * f64::from(30_u32 + 30) + 70.0 * f64::from(s);
            vec![
                target(5, "ABC1", (0.0, y), (0.0, 0.0), s),
                target(6, "", (0.0, last), (0.0, 70.0), s),
            ]
        });
        found.iter().find(|r| r.1 == "RMCA_ARR").map(|r| r.0)
    };
    assert_eq!(comes(true), comes(false));
    assert!(comes(true).is_some());
}

/// A car whose track has seen no plot for twelve seconds and then one, far away, is not on a runway there.
#[test]
fn who_is_found_again_after_coasting_is_doubted_like_one_who_is_new() {
    let when = |seen_again: fn(u32) -> bool| {
        let mut board = Board::default();
        board.strip(Callsign::new("CAR1"));
        let found = raised_with(board, Parameters::on_tracks(), 60, |s| {
            let car = |x: f64| target(5, "CAR1", (x, 1000.0), (0.0, 0.0), s);
            let last = if s < 20 || seen_again(s) {
                s
            } else {
                (20..=s).rev().find(|t| seen_again(*t)).unwrap_or(19)
            };
            let x = if s < 32 { 200.0 } else { 40.0 };
            vec![Target { last_plot: SimTime::from_s(f64::from(last)), ..car(x) }]
        });
        found.first().map(|r| r.0)
    };
    assert_eq!(when(|s| s == 32), None, "one plot");
    assert_eq!(when(|s| s >= 32), Some(36), "as long as a new one");
}

/// A push-back whose track had jumped a moment before is told of as one that had not (it was 5 s late and more).
#[test]
fn a_jump_before_a_push_back_or_on_a_wrong_way_delays_nothing() {
    let when = |kind: &str, jump_m: f64, off_way: bool| {
        let mut board = Board::default();
        let name = Callsign::new("ABC1");
        if off_way {
            board.give(Clearance {
                callsign: name,
                kind: ClearanceKind::Taxi,
                runway: None,
                place_m: None,
                from: SimTime::from_s(0.0),
                until: None,
            });
        }
        if let Some(strip) = board.strip(name) {
            strip.stand_m = Some(Point2::new(600.0, if off_way { 5000.0 } else { 500.0 }));
            strip.way_m = (0..90).map(|i| Point2::new(600.0, 400.0 + 8.0 * f64::from(i))).collect();
        }
        let found = raised_with(board, Parameters::on_tracks(), 80, |s| {
            let t = (f64::from(s) - 40.0).max(0.0);
            let (x, y) = if off_way {
                (600.0 + 5.0 * t, 500.0 + 5.0 * f64::from(s.min(40)))
            } else {
                (600.0, 500.0 + if t <= 7.5 { 0.1 * t * t } else { 5.625 + 1.5 * (t - 7.5) })
            };
            let jumped = if (37..=38).contains(&s) { jump_m } else { 0.0 };
            let v = if off_way { 5.0 } else { 0.2 * t.min(7.5) };
            let v = if off_way && s > 40 { (v, 0.0) } else { (0.0, v) };
            vec![target(5, "ABC1", (x - jumped, y), v, s)]
        });
        found.iter().find(|r| r.1 == kind).map(|r| r.0)
    };
    for (kind, off_way) in [("NOCLR_PUSH", false), ("ROUTE_DEV", true)] {
        let (steady, jumped) = (when(kind, 0.0, off_way), when(kind, 7.0, off_way));
        let (steady, jumped) = (steady.expect("raised"), jumped.expect("raised"));
        assert!(jumped <= steady + 1, "{kind}: {jumped} s after a jump, else {steady} s");
    }
}

/// Where the finals of two runways run into each other, who is cleared to land on one of them comes to that one, however near the other
/// is; in front of the other's threshold he is nobody's.
#[test]
fn a_cleared_landing_is_on_final_to_its_runway() {
    let finals = |cleared: Option<(usize, usize)>| {
        let mut layout = layout();
        let ends = [Point2::new(200.0, 0.0), Point2::new(200.0, 3000.0)];
        layout.runways.extend(RunwayAxis::new(["36R".into(), "18L".into()], ends, 45.0, 90.0));
        let mut net = SafetyNet::new(layout, Parameters::default());
        let mut board = Board::default();
        if let Some((r, end)) = cleared {
            board.give(Clearance {
                callsign: Callsign::new("ABC1"),
                kind: ClearanceKind::Land,
                runway: Some((r, Some(end))),
                place_m: None,
                from: SimTime::from_s(0.0),
                until: None,
            });
        }
        let mut found = Vec::new();
        for second in 1..=60_u32 {
            let t = f64::from(second);
            board.advance(SimTime::from_s(t));
            let y = -5000.0 + 70.0 * t;
            let targets = [target(3, "ABC1", (120.0, y), (0.0, 70.0), second)];
            let scan = Scan {
                now: SimTime::from_s(t),
                targets: &targets,
                board: &board,
                bars: &[],
                areas: &[],
                low_visibility: false,
            };
            net.scan(&scan);
            found.push(net.surveillance().situations()[0].on_final.map(|f| f.runway));
        }
        found
    };
    assert_eq!(finals(Some((0, 0)))[0], Some(0), "the farther one, cleared");
    assert_eq!(finals(Some((0, 1)))[0], Some(1), "cleared for its other end");
    assert_eq!(finals(Some((1, 0)))[0], Some(1));
    assert_eq!(finals(None)[0], Some(1), "the nearer one");
    // Near the ground he flies to the other, whatever he was cleared for.
    assert_eq!(finals(Some((0, 0)))[50], Some(1));
}

/// Who is over the threshold of his runway, still in the air, is not on final to another whose threshold lies a kilometre farther on (at
/// Osnova an information "without landing clearance" in every other landing).
#[test]
fn who_is_over_his_runway_is_on_final_to_no_other() {
    for (beside_m, on_m) in [(100.0, 1200.0), (-90.0, 600.0)] {
        let mut layout = layout();
        let ends = [Point2::new(beside_m, on_m), Point2::new(beside_m, 3000.0)];
        layout.runways.extend(RunwayAxis::new(["36R".into(), "18L".into()], ends, 45.0, 90.0));
        let mut net = SafetyNet::new(layout, Parameters::default());
        let mut board = Board::default();
        board.give(Clearance {
            callsign: Callsign::new("ABC1"),
            kind: ClearanceKind::Land,
            runway: Some((0, Some(0))),
            place_m: None,
            from: SimTime::from_s(0.0),
            until: None,
        });
        for second in 1..=60_u32 {
            let t = f64::from(second);
            board.advance(SimTime::from_s(t));
            // Over the threshold at 35 m: in the air for 385 m of his runway.
            let y = -2000.0 + 70.0 * t;
            let mut lands = target(3, "ABC1", (0.0, y), (0.0, 70.0), second);
            lands.altitude_m = Some((35.0 - 0.052 * y).max(0.0));
            let scan = Scan {
                now: SimTime::from_s(t),
                targets: &[lands],
                board: &board,
                bars: &[],
                areas: &[],
                low_visibility: false,
            };
            let raised = net.scan(&scan).iter().map(|c| c.1.condition.kind.word());
            assert_eq!(raised.collect::<Vec<_>>(), Vec::<String>::new(), "at {y} m");
            let on_final = net.surveillance().situations()[0].on_final.map(|f| f.runway);
            assert_eq!(on_final, (y <= 0.0).then_some(0), "at {y} m");
        }
    }
}

/// An echo of one who lands begins a few seconds before the threshold: nobody comes from nowhere.
#[test]
fn a_track_without_a_name_that_begins_on_short_final_does_not_land() {
    let lands = |from_m: f64, v: f64| {
        let found = raised(Parameters::on_tracks(), 60, |s| {
            vec![target(9, "", (0.0, -from_m + v * f64::from(s)), (0.0, v), s)]
        });
        found.iter().filter(|r| r.1 == "NOCLR_LND").count()
    };
    assert_eq!((lands(1000.0, 70.0), lands(1050.0, 72.0)), (0, 0));
    assert!(lands(2000.0, 70.0) > 0);
}

/// Who has just lifted off flies over the end of another runway: no take-off there, and nobody in its strip.
#[test]
fn who_has_lifted_off_is_in_the_air_over_another_runway_too() {
    let kinds = |until_s: Option<f64>, v: f64| {
        let mut board = Board::default();
        board.give(Clearance {
            callsign: Callsign::new("ABC1"),
            kind: ClearanceKind::TakeOff,
            runway: Some((7, Some(0))),
            place_m: None,
            from: SimTime::from_s(1.0),
            until: until_s.map(SimTime::from_s),
        });
        let found = raised_with(board, Parameters::on_tracks(), 40, |s| {
            vec![target(5, "ABC1", (0.0, 100.0 + v * f64::from(s)), (0.0, v), s)]
        });
        found.into_iter().map(|r| r.1).collect::<Vec<_>>()
    };
    for v in [36.0, 75.0] {
        assert_eq!(kinds(Some(2.0), v), Vec::<String>::new(), "{v} m/s");
        assert!(kinds(None, v).contains(&"NOCLR_TOF".to_owned()), "{v} m/s");
    }
    assert_eq!(kinds(Some(2.0), 9.0), ["NOCLR_RWY"], "who is back on the ground");
    // Who has landed is on the ground: too fast on a taxiway.
    let mut board = Board::default();
    board.give(Clearance {
        callsign: Callsign::new("ABC1"),
        kind: ClearanceKind::Land,
        runway: Some((0, Some(0))),
        place_m: None,
        from: SimTime::from_s(1.0),
        until: Some(SimTime::from_s(2.0)),
    });
    let found = raised_with(board, Parameters::on_tracks(), 30, |s| {
        vec![target(5, "ABC1", (600.0, 24.0 * f64::from(s)), (0.0, 24.0), s)]
    });
    assert!(found.iter().any(|r| r.1 == "HIGH_SPEED"), "{found:?}");
}

/// A light aircraft comes at 29 m/s, slower than what counts as a final: it does not taxi too fast.
#[test]
fn a_slow_arrival_is_in_the_air_until_it_is_over_its_runway() {
    let kinds = |arriving: bool| {
        let mut board = Board::default();
        board.give(Clearance {
            callsign: Callsign::new("ABC1"),
            kind: ClearanceKind::Land,
            runway: Some((0, Some(0))),
            place_m: None,
            from: SimTime::from_s(1.0),
            until: None,
        });
        let found = raised_with(board, Parameters::on_tracks(), 60, |s| {
            let at = (0.0, -1200.0 + 29.0 * f64::from(s));
            vec![Target { arriving, ..target(5, "ABC1", at, (0.0, 29.0), s) }]
        });
        found.into_iter().map(|r| r.1).collect::<Vec<_>>()
    };
    assert_eq!(kinds(true), Vec::<String>::new());
    assert!(kinds(false).contains(&"HIGH_SPEED".to_owned()));
    // One that was slow has landed, also where nobody saw it roll.
    let fast = raised(Parameters::on_tracks(), 40, |s| {
        let t = f64::from(s);
        let (y, v) = if s < 20 { (10.0 * t, 10.0) } else { (200.0 + 24.0 * (t - 20.0), 24.0) };
        vec![Target { arriving: true, ..target(5, "ABC1", (600.0, y), (0.0, v), s) }]
    });
    assert!(fast.iter().any(|r| r.1 == "HIGH_SPEED"), "{fast:?}");
}
