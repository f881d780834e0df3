//! Protected areas, types that are too large for their runway, and what a message says of a roll.

use super::*;
use crate::airport::{Area, AreaKind};

/// What stands in each scan for one aircraft, with these clearances and areas.
fn standing(
    board: &mut Board,
    areas: &[Area],
    seconds: u32,
    targets: impl Fn(u32) -> Vec<Target>,
) -> Vec<(u32, crate::control::alert::Alert)> {
    let mut net = SafetyNet::new(layout(), Parameters::default());
    let mut found = Vec::new();
    for second in 1..=seconds {
        let now = SimTime::from_s(f64::from(second));
        board.advance(now);
        let targets = targets(second);
        let scan = Scan { now, targets: &targets, board, bars: &[], areas, low_visibility: false };
        for (change, alert) in net.scan(&scan) {
            if *change == Change::Raised {
                found.push((second, alert.clone()));
            }
        }
    }
    found
}

fn given(name: &str, kind: ClearanceKind, runway: Option<usize>) -> Clearance {
    Clearance {
        callsign: Callsign::new(name),
        kind,
        runway: runway.map(|r| (r, None)),
        place_m: None,
        from: SimTime::from_s(0.0),
        until: None,
    }
}

fn first_of(found: &[(u32, crate::control::alert::Alert)], kind: &str) -> Option<u32> {
    found.iter().find(|(_, alert)| alert.condition.kind.word() == kind).map(|(s, _)| *s)
}

/// An area of the instrument landing system lies over the end of its runway: every lawful line-up was told of.
#[test]
fn who_is_cleared_onto_a_runway_may_be_in_an_area_over_its_strip() {
    let outline_m = [[-80.0, 100.0], [80.0, 100.0], [80.0, 500.0], [-80.0, 500.0]]
        .map(|[x, y]| Point2::new(x, y));
    let enters = |kind: Option<ClearanceKind>, area: AreaKind| {
        let areas = [Area {
            kind: area,
            outline_m: outline_m.to_vec(),
            from: SimTime::from_s(0.0),
            until: SimTime::from_s(1e6),
        }];
        let mut board = Board::default();
        board.give(given("ABC1", ClearanceKind::Taxi, None));
        if let Some(kind) = kind {
            board.give(given("ABC1", kind, Some(0)));
        }
        let found = standing(&mut board, &areas, 40, |s| {
            let x = (-200.0 + 5.0 * f64::from(s)).min(0.0);
            vec![target(5, "ABC1", (x, 300.0), (if x < 0.0 { 5.0 } else { 0.0 }, 0.0), s)]
        });
        first_of(&found, "AREA")
    };
    for kind in [ClearanceKind::LineUp, ClearanceKind::TakeOff, ClearanceKind::Cross] {
        assert_eq!(enters(Some(kind), AreaKind::Ils), None, "{kind:?}");
        assert!(enters(Some(kind), AreaKind::Closed).is_some(), "a closed one is closed to all");
    }
    assert!(enters(None, AreaKind::Ils).is_some_and(|s| s <= 25), "on his own");
}

/// Who lands on a runway that is too narrow for him was told of when he had turned off it.
#[test]
fn a_runway_that_is_too_small_is_told_of_before_the_landing() {
    for too_small in [true, false] {
        let mut board = Board::default();
        board.give(given("ABC1", ClearanceKind::Land, Some(0)));
        board.strip(Callsign::new("ABC1")).expect("a strip").too_small = too_small;
        let found = standing(&mut board, &[], 50, |s| {
            vec![target(5, "ABC1", (0.0, -4000.0 + 70.0 * f64::from(s)), (0.0, 70.0), s)]
        });
        let told = first_of(&found, "WRTY");
        assert_eq!(told.is_some_and(|s| s < 20), too_small, "{told:?}");
    }
}

/// Category 004 has a type of its own for a roll towards somebody who crosses.
#[test]
fn a_roll_towards_who_crosses_and_one_towards_who_stands_are_messages_of_their_own() {
    for (crosses_mps, message) in [(6.0, 13), (0.0, 12)] {
        let mut board = Board::default();
        board.give(given("ABC1", ClearanceKind::TakeOff, Some(0)));
        board.give(given("XYZ2", ClearanceKind::Cross, Some(0)));
        let found = standing(&mut board, &[], 30, |s| {
            let t = f64::from(s);
            let x = if crosses_mps > 0.0 { -150.0 + crosses_mps * t } else { 0.0 };
            vec![
                target(3, "ABC1", (0.0, 300.0 + 1.1 * t * t), (0.0, 2.2 * t), s),
                target(4, "XYZ2", (x, 2200.0), (crosses_mps, 0.0), s),
            ]
        });
        let roll = found.iter().find(|(_, a)| a.condition.kind.word() == "RMCA_ROLL");
        assert_eq!(roll.map(|(_, a)| a.condition.asterix()), Some(message), "{found:?}");
    }
}
