use super::*;
use crate::frames::Point2;

/// Who stops 20 m from the stand of an arrival on his way to the runway was told of as one who is on it, at each line with a stand beside it.
#[test]
fn who_stops_beside_a_stand_on_his_way_does_not_occupy_it() {
    let stand_m = Point2::new(800.0, 900.0);
    // Another aircraft stands 20 m away: cleared to taxi or not, with a stand of its own or not.
    let told = |cleared: Option<ClearanceKind>, own_m: Option<Point2<f64>>| {
        let mut board = Board::default();
        let mut clear = |name: &str, kind: Option<ClearanceKind>, stand_m| {
            let callsign = Callsign::new(name);
            let runway = kind.filter(|kind| *kind != ClearanceKind::Taxi).map(|_| (0, Some(0)));
            if let Some(kind) = kind {
                let from = SimTime::from_s(0.0);
                board.give(Clearance { callsign, kind, runway, place_m: None, from, until: None });
            }
            if let Some(strip) = board.strip(callsign) {
                strip.stand_m = stand_m;
            }
        };
        clear("IN1", Some(ClearanceKind::Taxi), Some(stand_m));
        clear("OUT2", cleared, own_m);
        let found = raised_with(board, Parameters::default(), 30, |s| {
            let comes = target(3, "IN1", (800.0, 8.0 * f64::from(s)), (0.0, 8.0), s);
            let stands = target(4, "OUT2", (820.0, 900.0), (0.0, 0.0), s);
            vec![Target { arriving: true, ..comes }, stands]
        });
        found.iter().any(|r| r.1 == "STOCC")
    };
    let (elsewhere, taxi) = (Some(Point2::new(300.0, 900.0)), Some(ClearanceKind::Taxi));
    assert!(!told(taxi, elsewhere), "holds on his way");
    assert!(told(None, elsewhere), "has arrived at the wrong one, or been towed there");
    assert!(told(taxi, Some(stand_m)), "has not left it yet, or comes to the same");
    assert!(told(taxi, None), "nobody knows where he came from");
    // At the line beside which his stand was.
    for kind in [ClearanceKind::LineUp, ClearanceKind::Cross, ClearanceKind::TakeOff] {
        assert!(!told(Some(kind), Some(stand_m)), "{kind:?}");
    }
    assert!(told(Some(ClearanceKind::Push), elsewhere), "is to be pushed off it");
}
