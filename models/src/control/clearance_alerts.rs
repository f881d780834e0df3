//! Conflicting clearances: what may not stand at the same time on one runway.

use super::alert::{AlertKind, Condition, Stage, Subject};
use super::clearance::{Board, Clearance, ClearanceKind};
use super::layout::{Layout, RunwayAxis};
use super::parameters::Parameters;
use super::situation::Surveillance;

/// A clearance that counts, with where its holder is along the runway, if a track tells.
struct Held<'a> {
    strip: u32,
    clearance: &'a Clearance,
    place_m: Option<f64>,
}

impl Held<'_> {
    /// Place of an entry or a crossing along the axis, m: as cleared, else where its holder is.
    fn entry_m(&self) -> Option<f64> {
        self.clearance.place_m.or(self.place_m)
    }

    /// +1 or −1: the direction that the clearance flies; `None` where only the runway is named.
    fn direction(&self) -> Option<f64> {
        let end = self.clearance.runway?.1?;
        Some(if end == 0 { 1.0 } else { -1.0 })
    }

    /// Place of one that rolls or lands: its track, else its entry, else the end it comes from.
    fn roller_m(&self, runway: &RunwayAxis) -> Option<f64> {
        let start = |direction: f64| if direction > 0.0 { 0.0 } else { runway.length_m };
        let landing = self.clearance.kind == ClearanceKind::Land;
        let entry = if landing { None } else { self.clearance.place_m };
        self.place_m.or(entry).or_else(|| self.direction().map(start))
    }
}

/// Adds the conflicts of all runways (`CATC_*`).
pub(super) fn conditions(
    layout: &Layout,
    parameters: &Parameters,
    board: &Board,
    surveillance: &Surveillance,
    out: &mut Vec<Condition>,
) {
    if board.on_runways().len() < 2 {
        return;
    }
    for (r, runway) in layout.runways.iter().enumerate() {
        let mut held: Vec<Held<'_>> = Vec::new();
        for strip in board.on_runways() {
            let situation = surveillance.of_strip(*strip);
            for clearance in board.strips()[*strip as usize].on_runway(r) {
                // A take-off is over once airborne.
                let airborne = situation.is_some_and(|s| s.airborne);
                if clearance.kind == ClearanceKind::TakeOff && airborne {
                    continue;
                }
                let place_m = situation.map(|s| runway.place_m(s.target.position_m).0);
                held.push(Held { strip: *strip, clearance, place_m });
            }
        }
        for (i, a) in held.iter().enumerate() {
            for b in held[i + 1..].iter().filter(|b| b.strip != a.strip) {
                if !conflict(runway, parameters, a, b) {
                    continue;
                }
                let (x, y) = (a.clearance.kind, b.clearance.kind);
                let (first, second) = (Subject::Strip(a.strip), Subject::Strip(b.strip));
                let at = |h: &Held<'_>| surveillance.of_strip(h.strip).map(|s| s.target.position_m);
                out.push(Condition {
                    kind: AlertKind::Conflicting(x.min(y), x.max(y)),
                    subjects: (first.min(second), Some(first.max(second))),
                    stage: Stage::Alarm,
                    runway: Some(r),
                    place_m: at(b).or_else(|| at(a)).unwrap_or(runway.origin_m),
                    crosses: false,
                });
            }
        }
    }
}

/// The table of what excludes what.
fn conflict(runway: &RunwayAxis, parameters: &Parameters, a: &Held<'_>, b: &Held<'_>) -> bool {
    use ClearanceKind::{Cross, Enter, Land, LineUp, TakeOff};
    let flies = |kind| matches!(kind, TakeOff | Land);
    match (a.clearance.kind, b.clearance.kind) {
        (LineUp, LineUp) => {
            let opposite = match (a.direction(), b.direction()) {
                (Some(x), Some(y)) => x != y,
                _ => false,
            };
            let apart = match (a.entry_m(), b.entry_m()) {
                (Some(x), Some(y)) => (x - y).abs() > parameters.entries_apart_m,
                _ => false,
            };
            opposite || apart
        }
        (x, y) if flies(x) && flies(y) => true,
        (x, LineUp | Cross | Enter) if flies(x) => ahead(runway, a, b),
        (LineUp | Cross | Enter, y) if flies(y) => ahead(runway, b, a),
        _ => false,
    }
}

/// Whether the entry or crossing of one is ahead of one that rolls or lands.
fn ahead(runway: &RunwayAxis, flies: &Held<'_>, enters: &Held<'_>) -> bool {
    let (Some(direction), Some(entry_m)) = (flies.direction(), enters.entry_m()) else {
        // Nobody can tell on which side: taken for a conflict.
        return true;
    };
    flies.roller_m(runway).is_none_or(|place_m| (entry_m - place_m) * direction > 0.0)
}
