//! Labels from the flight data list: by identity, by the stand of a departure, by the runway of an
//! arrival. A label sticks to its track.

use super::config::{LabelRules, TrackingConfig};
use super::track_file::{Stage, Track};
use crate::association::assignment::Solver;
use crate::filter::Estimate;
use crate::flight_list::{FlightEntry, FlightList, MovementKind};
use crate::plot::Callsign;
use crate::time::SimTime;
use crate::track::{Label, TrackType};

/// Gives labels to confirmed tracks; returns how many conflicts of one identity on two tracks it saw.
pub(super) fn assign(
    tracks: &mut [Track],
    flights: &FlightList,
    config: &TrackingConfig,
    now: SimTime,
    solver: &mut Solver,
) -> u64 {
    if flights.entries.is_empty() {
        return 0;
    }
    let mut conflicts = 0;
    // By identity; asked again only while there is no answer or the plots said something new.
    let named: Vec<(usize, Callsign)> = (0..tracks.len())
        .filter(|&t| !tracks[t].name_settled)
        .filter_map(|t| identified(&tracks[t], flights).map(|e| (t, e.callsign)))
        .collect();
    for (index, entry) in named {
        if tracks[index].entry != Some(entry) {
            for other in tracks.iter_mut().filter(|t| t.entry == Some(entry)) {
                conflicts += 1;
                give(other, None, config);
            }
            give(&mut tracks[index], flights.by_callsign(entry), config);
        }
        tracks[index].name_settled = true;
    }
    // By stand and runway: one assignment of unlabelled tracks to free entries.
    let mut taken: Vec<Callsign> = tracks.iter().filter_map(|t| t.entry).collect();
    taken.sort_unstable();
    let candidates: Vec<usize> = (0..tracks.len())
        .filter(|&t| tracks[t].stage == Stage::Confirmed && tracks[t].entry.is_none())
        .filter(|&t| !tracks[t].outside)
        .filter(|&t| tracks[t].callsign.is_none() && tracks[t].address.is_none())
        .collect();
    if candidates.is_empty() {
        return conflicts;
    }
    let free: Vec<&FlightEntry> = flights
        .entries
        .iter()
        .filter(|e| e.movement != MovementKind::Vehicle)
        .filter(|e| taken.binary_search(&e.callsign).is_err())
        .collect();
    if free.is_empty() {
        return conflicts;
    }
    let costs: Vec<Option<f64>> = candidates
        .iter()
        .flat_map(|&t| free.iter().map(move |e| (t, *e)))
        .map(|(t, e)| cost(&tracks[t], e, flights, &config.labels, now))
        .collect();
    let at = |row: usize, column: usize| costs[row * free.len() + column];
    // A label is worth its acceptance limit: dearer ones are not given at all.
    let limit = config.labels.accept_below;
    let found = solver.pairs_and_misses(candidates.len(), free.len(), |row, column| {
        at(row, column).map(|c| c - limit)
    });
    for (row, &column) in found.iter().enumerate() {
        let Some(column) = column else { continue };
        let Some(best) = at(row, column) else { continue };
        let clear = best + config.labels.clearer_by;
        let rivals = (0..free.len())
            .filter(|&c| c != column)
            .map(|c| at(row, c))
            .chain((0..candidates.len()).filter(|&r| r != row).map(|r| at(r, column)));
        if rivals.flatten().all(|rival| rival >= clear) {
            give(&mut tracks[candidates[row]], Some(free[column]), config);
        }
    }
    conflicts
}

fn identified<'a>(track: &Track, flights: &'a FlightList) -> Option<&'a FlightEntry> {
    let by_name = track.callsign.and_then(|c| flights.by_callsign(c));
    by_name.or_else(|| track.address.and_then(|a| flights.by_address(a)))
}

fn give(track: &mut Track, entry: Option<&FlightEntry>, config: &TrackingConfig) {
    track.entry = entry.map(|e| e.callsign);
    track.limits = config.limits_of(entry);
    track.size_m = entry.map(|e| config.size_of(e));
    track.vehicle = entry.is_some_and(|e| e.movement == MovementKind::Vehicle);
}

/// Cost of this label for this track: squared deviations of time and place, each in its own sigma (a
/// third of the rule's limit); `None` where the rule does not apply.
fn cost(
    track: &Track,
    entry: &FlightEntry,
    flights: &FlightList,
    rules: &LabelRules,
    now: SimTime,
) -> Option<f64> {
    let estimate = track.filter().estimate();
    match entry.movement {
        MovementKind::Departure => departure_cost(track, &estimate, entry, rules, now)
            .or_else(|| line_up_cost(&estimate, entry, flights, rules)),
        MovementKind::Arrival => arrival_cost(&estimate, entry, flights, rules),
        MovementKind::Vehicle => None,
    }
}

fn departure_cost(
    track: &Track,
    estimate: &Estimate,
    entry: &FlightEntry,
    rules: &LabelRules,
    now: SimTime,
) -> Option<f64> {
    let distance = (estimate.position_m() - entry.stand_m?).norm();
    let off_block = entry.off_block.unwrap_or(entry.eta_ctd);
    let late = track.born.since_s(off_block).max(0.0);
    // It is at its stand now (it may have been there for hours before its off-block time), or it is seen for
    // the first time and was pushed back since.
    let radius = if now.since_s(track.born) <= FIRST_SEEN_S {
        let pushed = rules.stand_radius_m + rules.push_back_ms * late;
        pushed.min(rules.push_back_reach_m.max(rules.stand_radius_m))
    } else {
        rules.stand_radius_m
    };
    if distance > radius {
        return None;
    }
    let early = off_block.since_s(now).max(0.0);
    let deviation = late.max(early);
    (deviation <= rules.off_block_window_s)
        .then(|| square(3.0 * distance / radius) + square(deviation / rules.off_block_window_s))
}

/// How long a track has been seen for the first time, s.
const FIRST_SEEN_S: f64 = 15.0;

/// A target that stands or rolls on the first half of its departure runway about its time of departure:
/// it may have left its stand before the run began, or stand where the list knows no stand. Faster than
/// an arrival on final it is not labelled any more: it could be one.
fn line_up_cost(
    estimate: &Estimate,
    entry: &FlightEntry,
    flights: &FlightList,
    rules: &LabelRules,
) -> Option<f64> {
    let on = on_runway(estimate, entry, flights)?;
    let lined_up = (0.0..=0.5 * on.length).contains(&on.way)
        && on.aside.abs() <= 0.5 * rules.arrival_lateral_m
        && (1.0..rules.arrival_speed_ms).contains(&on.forward);
    let deviation = estimate.time.since_s(entry.eta_ctd).abs();
    (lined_up && deviation <= rules.arrival_window_s).then(|| {
        square(3.0 * deviation / rules.arrival_window_s)
            + square(1.5 * on.aside / rules.arrival_lateral_m)
    })
}

/// Where a target is on the runway of an entry.
struct OnRunway {
    /// Length of the runway, m.
    length: f64,
    /// From its threshold along it, m.
    way: f64,
    /// Beside its centreline, m.
    aside: f64,
    /// Speed along it, m/s; 0 if the target moves another way.
    forward: f64,
}

fn on_runway(estimate: &Estimate, entry: &FlightEntry, flights: &FlightList) -> Option<OnRunway> {
    let (_, [threshold, far_end]) =
        flights.runways.iter().find(|(name, _)| *name == entry.runway)?;
    let along = far_end - threshold;
    let length = along.norm();
    if !(length > 1.0) {
        return None;
    }
    let along = along / length;
    let velocity = estimate.velocity_ms();
    let (speed, forward) = (velocity.norm(), velocity.dot(&along));
    let from_threshold = estimate.position_m() - threshold;
    Some(OnRunway {
        length,
        way: from_threshold.dot(&along),
        aside: from_threshold.x * along.y - from_threshold.y * along.x,
        forward: if forward > 0.95 * speed { forward } else { 0.0 },
    })
}

fn arrival_cost(
    estimate: &Estimate,
    entry: &FlightEntry,
    flights: &FlightList,
    rules: &LabelRules,
) -> Option<f64> {
    let on = on_runway(estimate, entry, flights)?;
    let landing = on.way >= -rules.final_length_m
        && on.way <= 0.5 * on.length
        && on.aside.abs() <= rules.arrival_lateral_m
        && on.forward > rules.arrival_speed_ms;
    if !landing {
        return None;
    }
    let over_threshold = estimate.time.plus_s(-on.way / on.forward);
    let deviation = over_threshold.since_s(entry.eta_ctd).abs();
    (deviation <= rules.arrival_window_s).then(|| {
        square(3.0 * deviation / rules.arrival_window_s)
            + square(1.5 * on.aside / rules.arrival_lateral_m)
    })
}

fn square(x: f64) -> f64 {
    x * x
}

/// What the list says of the track now.
pub(super) fn label(entry: Option<Callsign>, flights: &FlightList) -> (TrackType, Option<Label>) {
    let Some(entry) = entry.and_then(|c| flights.by_callsign(c)) else {
        return (TrackType::NotAssociated, None);
    };
    let track_type = match entry.movement {
        MovementKind::Vehicle => TrackType::Vehicle,
        MovementKind::Arrival | MovementKind::Departure => TrackType::Aircraft,
    };
    let label = Label {
        callsign: entry.callsign,
        type_designator: entry.type_designator.clone(),
        wake: entry.wake,
        movement: entry.movement,
        runway_stand: match (entry.runway.as_str(), entry.stand.as_str()) {
            ("", stand) => stand.to_owned(),
            (runway, "") => runway.to_owned(),
            (runway, stand) => format!("{runway}/{stand}"),
        },
        ctd_eta: entry.eta_ctd,
        routing: entry.routing.clone(),
    };
    (track_type, Some(label))
}
