//! Who has just left a runway that he was cleared to cross or to drive on.

use super::*;

/// The track of one that crosses lags behind the clearance, which ends as the tail is off. Where nobody remembers that, it is an
/// intruder for the scans between (half of the false alerts of a radar alone at Bratislava).
#[test]
fn who_has_just_left_a_crossing_is_no_intruder_and_who_stays_is() {
    let crosses = |kind, ended_s: Option<f64>, name: &'static str, off_s: u32, on_tracks: bool| {
        let mut board = Board::default();
        board.give(Clearance {
            callsign: Callsign::new("ABC1"),
            kind,
            runway: Some((0, None)),
            place_m: None,
            from: SimTime::from_s(1.0),
            until: ended_s.map(SimTime::from_s),
        });
        let parameters = if on_tracks { Parameters::on_tracks() } else { Parameters::default() };
        let found = raised_with(board, parameters, 45, move |s| {
            // At 5 m/s over the axis; 20 m from the edge of the strip when the clearance ends; stops there or goes on.
            let x = -65.0 + 5.0 * f64::from(s.min(off_s));
            let v = if s < off_s { 5.0 } else { 0.0 };
            vec![target(5, name, (x, 1500.0), (v, 0.0), s)]
        });
        let entries: Vec<u32> = found.iter().filter(|r| r.1 == "NOCLR_RWY").map(|r| r.0).collect();
        assert!(entries.len() <= 1, "{entries:?}");
        entries.first().copied()
    };
    for kind in [ClearanceKind::Cross, ClearanceKind::Backtrack, ClearanceKind::Enter] {
        for name in ["ABC1", ""] {
            assert_eq!(crosses(kind, Some(25.0), name, 45, true), None, "{kind:?} {name}");
            assert_eq!(crosses(kind, None, name, 27, true), None, "{kind:?} {name} stays cleared");
            let stays = crosses(kind, Some(25.0), name, 27, true).expect("it stays in the strip");
            assert!((31..=33).contains(&stays), "{kind:?} {name}: {stays}");
        }
        assert_eq!(
            crosses(kind, Some(25.0), "ABC1", 45, false),
            Some(25),
            "exact truth lags by nothing"
        );
    }
    assert_eq!(
        crosses(ClearanceKind::Taxi, Some(25.0), "ABC1", 45, true).map(|s| s < 12),
        Some(true)
    );
}
