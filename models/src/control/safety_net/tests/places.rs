//! Where noise puts a track decides nothing: lines, stands, anchors, thresholds; and who is on final to which runway.

use super::*;
use crate::frames::Point2;

/// What is raised with the second, at an airport with bars; strips and clearances on `board`.
pub(super) fn seen(
    layout: &Layout,
    board: &Board,
    parameters: Parameters,
    seconds: u32,
    targets: impl Fn(u32) -> Vec<Target>,
) -> Vec<(u32, String)> {
    let (mut board, mut found) = (board.clone(), Vec::new());
    let mut net = SafetyNet::new(layout.clone(), parameters);
    for second in 1..=seconds {
        let (now, targets) = (SimTime::from_s(f64::from(second)), targets(second));
        board.advance(now);
        let bars = &layout.bars;
        let scan =
            Scan { now, targets: &targets, board: &board, bars, areas: &[], low_visibility: false };
        let raised = net.scan(&scan).iter().filter(|(change, _)| *change == Change::Raised);
        found.extend(raised.map(|(_, alert)| (second, alert.condition.kind.word())));
    }
    found
}

pub(super) fn first(found: &[(u32, String)], kind: &str) -> Option<u32> {
    found.iter().find(|(_, word)| word == kind).map(|(second, _)| *second)
}

/// Cleared from the first second on.
pub(super) fn cleared(callsign: &str, kind: ClearanceKind, runway: usize) -> Board {
    let mut board = Board::default();
    board.give(Clearance {
        callsign: Callsign::new(callsign),
        kind,
        runway: Some((runway, Some(0))),
        place_m: None,
        from: SimTime::from_s(1.0),
        until: None,
    });
    board
}

/// Errors of a place that come again after a while, within 2 m.
pub(super) fn noise(second: u32) -> f64 {
    [0.4, -1.7, 1.9, -0.3, 1.2, -2.0, 0.1, 1.6, -0.9, -1.1][second as usize % 10]
}

/// A second runway begins beside the first, a kilometre on: whoever has landed on the first flies at its threshold, too, and was on
/// final to it (30 of 42 alerts of that kind at an airport like this came to nothing).
#[test]
fn who_is_fast_on_a_runway_is_on_final_to_no_other() {
    let ends = [Point2::new(95.0, 1100.0), Point2::new(95.0, 3600.0)];
    let beside = RunwayAxis::new(["36R".into(), "18L".into()], ends, 45.0, 90.0);
    let layout = Layout::new(layout().runways.into_iter().chain(beside).collect());
    let lands = |altitude_m: Option<f64>| {
        move |s: u32| {
            let at = (0.0, -1200.0 + 60.0 * f64::from(s));
            let comes = Target { altitude_m, ..target(1, "ABC1", at, (0.0, 60.0), s) };
            // Beyond the strip of the first runway, in that of the second.
            vec![comes, target(2, "XYZ2", (130.0, 1150.0), (0.0, 0.0), s)]
        }
    };
    let arrivals = |parameters, board: &Board, altitude_m| {
        first(&seen(&layout, board, parameters, 35, lands(altitude_m)), "RMCA_ARR")
    };
    let own = cleared("ABC1", ClearanceKind::Land, 0);
    let other = cleared("ABC1", ClearanceKind::Land, 1);
    assert_eq!(arrivals(Parameters::default(), &own, Some(5.0)), None, "on the ground");
    assert_eq!(arrivals(Parameters::on_tracks(), &own, None), None);
    // In the air over the first, and cleared to land on the second, he comes to that.
    assert!(arrivals(Parameters::default(), &other, Some(60.0)).is_some());
    assert!(arrivals(Parameters::on_tracks(), &other, None).is_some());
}

/// Manchester's 23L: who enters along the axis holds 56 m short of the runway, where the strip would reach 60 m. He was alarmed over 17
/// times in nine minutes.
#[test]
fn who_holds_on_the_axis_short_of_the_end_is_in_no_strip() {
    let comes = |stops_m: f64| {
        move |second: u32| {
            let s = f64::from(second);
            let at = (0.3 * noise(second), (-320.0 + 10.0 * s).min(stops_m) + 0.3 * noise(second));
            let speed_mps = if -320.0 + 10.0 * s < stops_m { 10.0 } else { 0.0 };
            vec![target(1, "ABC1", at, (0.0, speed_mps), second)]
        }
    };
    let alarmed = |held_m: f64, nose_m: f64| {
        let mut layout = layout();
        layout.runways[0].ends_held_m[0] = held_m;
        let mut board = Board::default();
        board.strip(Callsign::new("ABC1"));
        let found = seen(&layout, &board, Parameters::on_tracks(), 90, comes(nose_m - 19.0));
        first(&found, "NOCLR_RWY")
    };
    assert_eq!(alarmed(55.7, -58.5), None, "3 m short of the line");
    assert!(alarmed(f64::INFINITY, -50.0).is_some(), "a strip without such a line");
    assert!(alarmed(55.7, -40.0).is_some(), "over the line, uncleared");
}

#[test]
fn the_first_speed_of_a_track_says_not_that_it_was_slow() {
    // A light aircraft beside the runway's line, still in the air; a taxiing one that becomes as fast.
    let light = |first_mps: f64| {
        move |s: u32| {
            let v = if s <= 2 { first_mps } else { 29.0 };
            let at = (0.0, -1500.0 + 29.0 * f64::from(s));
            vec![Target { arriving: true, ..target(1, "ABC1", at, (0.0, v), s) }]
        }
    };
    let board = cleared("ABC1", ClearanceKind::Land, 0);
    let found = |first_mps| {
        first(&seen(&layout(), &board, Parameters::on_tracks(), 45, light(first_mps)), "HIGH_SPEED")
    };
    assert_eq!((found(29.0), found(5.0)), (None, None));
    let taxies = |s: u32| {
        let t = f64::from(s);
        let (y, v) = if s < 20 { (5.0 * t, 5.0) } else { (100.0 + 29.0 * (t - 20.0), 29.0) };
        vec![Target { arriving: true, ..target(1, "ABC1", (400.0, y), (0.0, v), s) }]
    };
    assert!(
        first(&seen(&layout(), &board, Parameters::on_tracks(), 45, taxies), "HIGH_SPEED")
            .is_some()
    );
}

/// An arrival that flies over the begin of a runway whose threshold is displaced is no roll there.
#[test]
fn who_lands_is_on_the_ground_behind_the_threshold() {
    let mut layout = layout();
    layout.runways[0].displaced_m[0] = 300.0;
    let comes = |altitude: bool| {
        move |s: u32| {
            let y = -900.0 + 29.0 * f64::from(s);
            let altitude_m = altitude.then_some(((586.0 - y) * 0.0524).max(0.0));
            let one = target(1, "ABC1", (0.0, y), (0.0, 29.0), s);
            vec![Target { arriving: true, altitude_m, ..one }]
        }
    };
    let board = cleared("XYZ2", ClearanceKind::Taxi, 0);
    let at = |parameters, altitude| {
        let found = seen(&layout, &board, parameters, 60, comes(altitude));
        first(&found, "NOCLR_TOF").map(f64::from).expect("raised")
    };
    let (exact, tracks) = (at(Parameters::default(), true), at(Parameters::on_tracks(), false));
    assert!((tracks - exact).abs() <= 3.0, "{tracks} and {exact}");
}

/// From line-ups at many speeds, which end anywhere between two anchors: told within 5 s of exact truth, also where noise puts the one
/// who stands farther from the last anchor than another one would be.
#[test]
fn who_stands_moves_no_anchor() {
    let board = cleared("ABC1", ClearanceKind::LineUp, 0);
    for tenth in 0..30 {
        // At 4 to 7 m/s, then with 0.6 m/s² to a stop at second 40.
        let speed_mps = 4.0 + 0.1 * f64::from(tenth);
        let place = move |s: u32| {
            let left_s = (40.0 - f64::from(s)).max(0.0);
            let brakes_m = 0.3 * left_s.min(10.0) * left_s.min(10.0);
            1000.0 - brakes_m - speed_mps * (left_s - 10.0).max(0.0)
        };
        let at = |parameters, noise: fn(u32) -> f64| {
            let one = move |s: u32| {
                let v = f64::from(u8::from(s < 40)) * 3.0;
                vec![target(1, "ABC1", (noise(s), place(s) + noise(s + 3)), (0.0, v), s)]
            };
            let found = first(&seen(&layout(), &board, parameters, 160, one), "NOMOV");
            i64::from(found.expect("raised"))
        };
        let (exact, tracks) =
            (at(Parameters::default(), |_| 0.0), at(Parameters::on_tracks(), noise));
        assert!((tracks - exact).abs() <= 5, "{speed_mps} m/s: {tracks} and {exact}");
    }
}

pub(super) fn with_bar() -> Layout {
    let bar =
        StopBar { runway: 0, place_m: 1000.0, across_m: Some(90.0), entry_m: 1000.0, lit: true };
    Layout { bars: vec![bar], ..layout() }
}

#[test]
fn noise_takes_nobody_over_a_bar_and_who_passes_it_is_told() {
    let board = cleared("ABC1", ClearanceKind::Taxi, 0);
    let bars = |parameters, noise: fn(u32) -> f64, x: &dyn Fn(u32) -> f64| {
        let one = |s: u32| {
            let v = x(s) - x(s.saturating_sub(1));
            vec![target(1, "ABC1", (x(s) + noise(s), 1000.0), (v, 0.3 * noise(s + 5)), s)]
        };
        first(&seen(&with_bar(), &board, parameters, 90, one), "STOPBAR")
    };
    // Comes to a stop with its nose a metre before the line, and stands there.
    let stands = |s: u32| 110.0 + (30.0 - 3.0 * f64::from(s)).max(0.0);
    assert_eq!(bars(Parameters::on_tracks(), noise, &stands), None);
    assert_eq!(bars(Parameters::default(), |_| 0.0, &stands), None);
    // Passes it at 5 m/s, and so slowly that noise is as fast.
    for (speed_mps, most_s) in [(5.0, 2), (1.2, 4)] {
        let passes = |s: u32| 125.0 - speed_mps * f64::from(s);
        let exact = bars(Parameters::default(), |_| 0.0, &passes).expect("raised");
        let tracks = bars(Parameters::on_tracks(), noise, &passes).expect("raised on tracks");
        assert!((exact..=exact + most_s).contains(&tracks), "{speed_mps}: {tracks}, {exact}");
    }
}

/// `bar_margin_m`: so far behind the bar the nose is over it.
#[test]
fn a_bar_is_passed_so_far_behind_it() {
    let board = cleared("ABC1", ClearanceKind::Taxi, 0);
    let at = |bar_margin_m: f64| {
        let passes = |s: u32| {
            let x = 125.0 - 5.0 * f64::from(s);
            vec![target(1, "ABC1", (x, 1000.0), (-5.0, 0.0), s)]
        };
        [Parameters::default(), Parameters::on_tracks()].map(|parameters| {
            let parameters = Parameters { bar_margin_m, ..parameters };
            first(&seen(&with_bar(), &board, parameters, 30, passes), "STOPBAR").expect("raised")
        })
    };
    let [exact, tracks] = at(0.0);
    assert_eq!(at(10.0), [exact + 2, tracks + 2]);
}

/// Stands 26 m from each other: who stands on one occupied the other whenever noise put him there (28 false alerts in ten hours).
#[test]
fn who_stands_on_a_stand_occupies_no_other_unless_they_are_one() {
    let stand_m = Point2::new(600.0, 900.0);
    let mut board = cleared("ABC1", ClearanceKind::Taxi, 0);
    board.strip(Callsign::new("ABC1")).expect("room").stand_m = Some(stand_m);
    let told = |other_m: f64, stands_at_m: f64| {
        let stands_m = vec![stand_m, stand_m + Vector2::new(other_m, 0.0)];
        let layout = Layout { stands_m, ..layout() };
        let targets = |s: u32| {
            let at = (400.0, 900.0 - 5.0 * f64::from(s));
            let comes = Target { arriving: true, ..target(1, "ABC1", at, (0.0, -5.0), s) };
            let x = 600.0 + stands_at_m + noise(s);
            vec![comes, target(2, "XYZ2", (x, 900.0), (0.0, 0.0), s)]
        };
        first(&seen(&layout, &board, Parameters::on_tracks(), 30, targets), "STOCC").is_some()
    };
    assert!(!told(26.0, 26.0), "on the other");
    assert!(told(26.0, 0.0), "on it");
    assert!(told(26.0, 12.0), "between them, nearer to it");
    assert!(told(10.0, 10.0), "two markings of one place");
}

/// The nose is over the bar by noise a second time: of the same aircraft that is no news. Who goes on over it is, also then.
#[test]
fn a_bar_is_told_of_once_to_who_stands_before_it() {
    let board = cleared("ABC1", ClearanceKind::Taxi, 0);
    let count = |x: fn(u32) -> f64| {
        let one = |s: u32| {
            let v = x(s) - x(s.saturating_sub(1));
            vec![target(1, "ABC1", (x(s), 1000.0), (v.clamp(-2.0, 0.0), 0.0), s)]
        };
        let found = seen(&with_bar(), &board, Parameters::on_tracks(), 90, one);
        found.iter().filter(|(_, kind)| kind == "STOPBAR").count()
    };
    // Its nose is 6 m before the line: by 2 m a second it seems to come 5 m over it, and to be where it was.
    fn strays(s: u32) -> f64 {
        115.0
            - 1.9
                * f64::from(
                    [0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 6, 5, 4, 3, 2, 1][s as usize % 20],
                )
    }
    assert_eq!(count(strays), 1, "in four times");
    fn goes(s: u32) -> f64 {
        if s < 60 { strays(s) } else { 115.0 - 5.0 * f64::from(s - 60) }
    }
    assert_eq!(count(goes), 2);
}

/// One jump silences who has a name for three seconds; who jumps again, and who has none and does not go on from it, for twelve.
#[test]
fn who_jumps_time_and_again_is_silent_for_longer() {
    let board = || {
        let mut board = Board::default();
        board.strip(Callsign::new("ABC1"));
        board
    };
    let jump = |s: u32, at: &[u32]| if at.contains(&s) { 12.0 } else { 0.0 };
    // Taxies without clearance from second 31 on, having jumped aside for a scan.
    let taxies = |at: &'static [u32]| {
        move |s: u32| {
            let t = f64::from(s.saturating_sub(31));
            let v = if s > 31 { 5.0 } else { 0.0 };
            vec![target(1, "ABC1", (400.0 + jump(s, at), 900.0 + 5.0 * t), (0.0, v), s)]
        }
    };
    let told = |at| {
        let found = seen(&layout(), &board(), Parameters::on_tracks(), 70, taxies(at));
        first(&found, "NOCLR_TAXI").expect("raised")
    };
    let (never, once, again) = (told(&[]), told(&[28]), told(&[15, 28]));
    assert!(once <= never + 2 && again >= 28 + 12, "{never} {once} {again}");
    // Nobody's track enters the runway from second 31 on: at 3 m/s, by no jump, and at 6 m/s, by one that goes on.
    let enters = |speed_mps: f64, from_m: f64, at: &'static [u32]| {
        let one = move |s: u32| {
            let x = from_m - speed_mps * f64::from(s.max(30) - 30);
            let v = if s < 31 { 0.0 } else { -speed_mps };
            vec![target(7, "", (x, 1000.0 + jump(s, at)), (v, 0.0), s)]
        };
        let found = seen(&layout(), &Board::default(), Parameters::on_tracks(), 60, one);
        first(&found, "NOCLR_RWY").expect("raised")
    };
    let (never, once) = (enters(3.0, 92.0, &[]), enters(3.0, 92.0, &[25]));
    assert!(never <= 35 && once >= 25 + 12, "{never} {once}");
    let goes_on = enters(6.0, 100.0, &[25]);
    assert!((33..=35).contains(&goes_on), "{goes_on}");
}

/// Light ones go around slower than what is taken for a final: they are over the strip, not in it.
#[test]
fn who_was_sent_around_is_over_the_strip_however_slow() {
    let kinds = |kind| {
        let mut board = Board::default();
        for (name, kind) in [("ABC1", kind), ("DEP1", ClearanceKind::TakeOff)] {
            assert!(board.give(Clearance {
                callsign: Callsign::new(name),
                kind,
                runway: Some((0, Some(0))),
                place_m: None,
                from: SimTime::from_s(0.0),
                until: None,
            }));
        }
        let found = raised_with(board, Parameters::on_tracks(), 90, |s| {
            let t = f64::from(s);
            let comes = target(3, "ABC1", (0.0, -600.0 + 29.0 * t), (0.0, 29.0), s);
            vec![comes, target(7, "DEP1", (0.0, 100.0 + 20.0 * t), (0.0, 20.0), s)]
        });
        found
            .into_iter()
            .map(|(_, kind)| kind)
            .filter(|k| k.starts_with("RMCA"))
            .collect::<Vec<_>>()
    };
    assert_eq!(kinds(ClearanceKind::GoAround), Vec::<String>::new());
    assert_eq!(kinds(ClearanceKind::Land)[..], ["RMCA_ROLL".to_owned()]);
}

/// A bar may stand farther from its runway than holding positions do elsewhere: there, too, who passes it is told of.
#[test]
fn a_bar_beyond_the_holding_distance_is_a_bar() {
    let at = |across_m: f64| {
        let mut layout = layout();
        let bar = StopBar {
            runway: 0,
            place_m: 1000.0,
            across_m: Some(across_m),
            entry_m: 1000.0,
            lit: true,
        };
        layout.bars.push(bar);
        let comes =
            |s: u32| vec![target(1, "ABC1", (240.0 - 5.0 * f64::from(s), 1000.0), (-5.0, 0.0), s)];
        let mut board = Board::default();
        board.strip(Callsign::new("ABC1"));
        first(&seen(&layout, &board, Parameters::default(), 40, comes), "STOPBAR")
    };
    // The nose is 19 m ahead: at 220 m after the first second.
    assert_eq!((at(90.0), at(190.0)), (Some(27), Some(7)));
}

/// A light aircraft that comes at 29 m/s was "on final" at 51 in the first scan of its track, and two minutes later one who lands without
/// clearance, where exact truth has one who rolls without.
#[test]
fn the_first_velocity_of_a_track_makes_nobody_one_who_lands() {
    let rolls = |first_mps: f64, scans: u32| {
        let found = raised(Parameters::on_tracks(), 120, |s| {
            let y = -1700.0 + 29.0 * f64::from(s);
            let v = if s <= scans { first_mps } else { 29.0 };
            vec![Target { arriving: true, ..target(5, "ABC1", (0.0, y), (0.0, v), s) }]
        });
        let flies = |kind: &String| kind == "NOCLR_LND" || kind == "NOCLR_TOF";
        found.into_iter().map(|r| r.1).filter(flies).collect::<Vec<_>>()
    };
    assert_eq!(rolls(29.0, 0), ["NOCLR_TOF"]);
    assert_eq!(rolls(51.0, 1), ["NOCLR_TOF"]);
    // Who really comes so fast is one who lands.
    let lands = raised(Parameters::on_tracks(), 60, |s| {
        let y = -1700.0 + 51.0 * f64::from(s);
        vec![Target { arriving: true, ..target(5, "ABC1", (0.0, y), (0.0, 51.0), s) }]
    });
    let kinds: Vec<_> = lands.into_iter().map(|r| r.1).collect();
    assert!(kinds.contains(&"NOCLR_LND".to_owned()), "{kinds:?}");
    assert!(!kinds.contains(&"NOCLR_TOF".to_owned()), "{kinds:?}");
}

/// A roll without clearance whose velocity pointed aside for one scan was no roll in that, and somebody on the runway without clearance
/// (KSFZ, one of 32 movements).
#[test]
fn a_roll_that_points_aside_for_a_scan_is_nobody_who_entered() {
    let kinds = |parameters, stops_at: u32, aside: u32| {
        let found = raised(parameters, 60, |s| {
            let t = f64::from(s.min(stops_at));
            let (y, v) =
                if s < 20 { (300.0, 0.0) } else { (300.0 + (t - 19.0).powi(2), 2.0 * (t - 19.0)) };
            let v = if s > stops_at { 0.0 } else { v };
            let across = if s == aside { 0.6 * v } else { 0.0 };
            vec![target(5, "ABC1", (0.0, y), (across, v), s)]
        });
        let on_runway: Vec<u32> =
            found.iter().filter(|r| r.1 == "NOCLR_RWY").map(|r| r.0).collect();
        // He lined up without clearance, too: that is told of as his track begins.
        on_runway.into_iter().filter(|s| *s > 20).collect::<Vec<_>>()
    };
    let tracks = Parameters::on_tracks();
    assert_eq!(kinds(tracks, 60, 0), Vec::<u32>::new());
    assert_eq!(kinds(tracks, 60, 33), Vec::<u32>::new(), "for a scan");
    assert_eq!(kinds(Parameters::default(), 60, 33), [33], "exact truth points where it goes");
    // Who stops is somebody on the runway, a scan later than on exact truth at most.
    let (exact, found) = (kinds(Parameters::default(), 40, 0), kinds(tracks, 40, 0));
    assert_eq!(exact, [41]);
    assert!(found.len() == 1 && found[0] <= 42, "{found:?}");
}
