//! Gaps: room between landings to cross a runway or to take off, as the finals are seen.

use super::{Found, Picture, What};
use crate::control::actors::message::Seat;
use crate::control::actors::sight::Waiting;
use crate::control::clearance::ClearanceKind;
use crate::control::situation::Situation;

/// Landings farther off do not count, s.
pub const AHEAD_S: f64 = 240.0;
/// From the threshold until the next may go, s (assumed).
const OCCUPIED_S: f64 = 60.0;
/// Left over in a gap, s (assumed).
const MARGIN_S: f64 = 15.0;
/// From the words to a movement, s (assumed: clearance, readback, engines).
const BEGINS_S: f64 = 10.0;
/// Over a strip, m/s (assumed).
const CROSSES_MPS: f64 = 7.0;
/// From the line to the lift-off, s (assumed: 35 to line up, 45 to roll).
const TAKES_OFF_S: f64 = 80.0;

/// What can be cleared in a gap now, or when the next one opens.
pub(super) fn look(now_s: f64, picture: &Picture<'_>) -> Vec<Found> {
    let mut found: Vec<Found> =
        picture.waiting.iter().filter_map(|w| of_one(now_s, w, picture)).collect();
    found.sort_by_key(|f| f.flight);
    found.dedup_by_key(|f| f.flight);
    found
}

fn of_one(now_s: f64, w: &Waiting, picture: &Picture<'_>) -> Option<Found> {
    let (kind, flight) = (w.wanted.kind, w.wanted.flight);
    let runway = w.runway?;
    let axis = picture.known.layout.runways.get(runway)?;
    let length_m = picture.flights.get(flight as usize)?.size.length_m;
    let needs_s = match kind {
        ClearanceKind::Cross => BEGINS_S + (2.0 * axis.hold_m + length_m) / CROSSES_MPS,
        ClearanceKind::LineUp => BEGINS_S + TAKES_OFF_S,
        _ => return None,
    };
    let seen = picture.known.surveillance;
    let others = || seen.situations().iter().filter(|s| s.strip.is_none() || s.strip != w.strip);
    let lands = |s: &&Situation| s.on_final.is_some_and(|f| f.runway == runway);
    let mut finals: Vec<(f64, Option<u32>)> = others()
        .filter(|s| s.doubt.is_none())
        .filter(lands)
        .filter_map(|s| Some((s.on_final?.time_s, s.strip.and_then(|i| picture.flight_of(i)))))
        .filter(|(time_s, _)| *time_s <= AHEAD_S)
        .collect();
    finals.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // Where nobody lands there is no gap to look for.
    let (next_s, next) = *finals.first()?;
    let stands = |s: &Situation| s.in_strip(runway) && !s.airborne && s.doubt.is_none();
    let enough = |room_s: f64| room_s >= needs_s + MARGIN_S;
    let occupied = others().any(stands);
    let (opens_s, other, lands_s) = if !occupied && enough(next_s) {
        (0.0, next, Some(next_s))
    } else {
        let ends = finals.iter().skip(1).map(|f| Some(f.0)).chain([None]);
        let mut gaps = finals.iter().zip(ends);
        let fits = |until_s: Option<f64>, f: f64| {
            until_s.is_none_or(|until_s| enough(until_s - f - OCCUPIED_S))
        };
        let (behind, until_s) = gaps.find(|(f, until_s)| fits(*until_s, f.0))?;
        (behind.0 + OCCUPIED_S, behind.1, until_s)
    };
    // Open now: what it waits longer otherwise. Later: what the gap has left over, at least.
    let ends_s = lands_s.unwrap_or(opens_s + AHEAD_S);
    let value = if opens_s == 0.0 { next_s + OCCUPIED_S } else { ends_s - opens_s - needs_s };
    Some(Found {
        seat: Seat::of(kind, w.wanted.group),
        flight,
        other,
        until_s: now_s + ends_s - needs_s,
        value,
        what: What::Gap {
            clearance: kind,
            runway,
            open: opens_s == 0.0,
            opens_s: now_s + opens_s,
            lands_s: lands_s.map(|s| now_s + s),
            needs_s,
        },
    })
}
