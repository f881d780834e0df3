//! Labels from the flight data list: by the names in the plots, else as a distribution over the lines of the list.
//!
//! The odds of each unnamed track and line (`identity`) make a one-to-one distribution (`association::one_to_one`). A label
//! is given from [`GIVEN`] on and taken back below [`KEPT`]; from [`ASSUMED`] on it is published as assumed.

use crate::association::lbp::Edge;
use crate::association::one_to_one::OneToOne;
use crate::flight_list::{FlightEntry, FlightList, MovementKind};
use crate::fusion::budget::Budget;
use crate::fusion::config::TrackingConfig;
use crate::fusion::identity::{List, ListTimes, SIGMAS};
use crate::fusion::resting::Resting;
use crate::fusion::track_file::{Stage, Track};
use crate::plot::Callsign;
use crate::time::SimTime;
use crate::track::{Label, TrackType};
use std::collections::BTreeMap;

/// A label that is at least this probable is given.
pub(in crate::fusion) const GIVEN: f64 = 0.9;
/// A given one that is less probable is taken back.
const KEPT: f64 = 0.8;
/// From here on a label is published as assumed.
const ASSUMED: f64 = 0.5;
/// Probability of a label by the target's own name.
pub(in crate::fusion) const NAMED: f64 = 0.999;
/// No label of a track that has not been seen lately is more probable.
pub(in crate::fusion) const UNSEEN_P: f64 = 0.7;
/// Odds are weighed this often, s, and whenever something has happened.
const EVERY_S: f64 = 5.0;
/// ln of odds that are left out.
const NEGLIGIBLE: f64 = -7.0;
/// Pairs of tracks and lines for which all tracks are weighed; of more, those that have shown something.
const MOST_PAIRS: usize = 200_000;
/// Landings and take-offs of which the list's error is learnt at a time, lines that each is held against, and how far off
/// these may be, s.
const MOST_EVENTS: usize = 32;
const MOST_LINES: usize = 64;
const WINDOW_S: f64 = 900.0;
/// An arrival that the list has so long before another one on its runway may be late enough to be taken for it, s.
const IN_TURN_S: f64 = 300.0;

/// What changed.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::fusion) struct Changes {
    /// One identity seen on two tracks.
    pub(in crate::fusion) conflicts: u64,
    /// Labels taken back.
    pub(in crate::fusion) revisions: u64,
}

/// Gives labels to confirmed tracks.
pub(in crate::fusion) fn assign(
    labels: &mut Resting,
    tracks: &mut [Track],
    flights: &FlightList,
    config: &TrackingConfig,
    now: SimTime,
    (pairing, budget): (&mut OneToOne, &mut Budget),
) -> Changes {
    let mut changes = Changes::default();
    if flights.entries.is_empty() {
        return changes;
    }
    // By identity; asked again only while there is no answer or the plots said something new.
    let named: Vec<(usize, Callsign)> = (0..tracks.len())
        .filter(|&t| !tracks[t].name_settled)
        .filter_map(|t| identified(&tracks[t], flights).map(|e| (t, e.callsign)))
        .collect();
    let mut news = !named.is_empty();
    let mut holders: BTreeMap<Callsign, usize> = BTreeMap::new();
    if news {
        holders.extend((0..tracks.len()).filter_map(|t| tracks[t].entry.map(|e| (e, t))));
    }
    for (index, entry) in named {
        if tracks[index].entry != Some(entry) {
            if let Some(before) = tracks[index].entry {
                holders.remove(&before);
            }
            if let Some(other) = holders.insert(entry, index) {
                changes.conflicts += 1;
                give(&mut tracks[other], None, config);
            }
            give(&mut tracks[index], flights.by_callsign(entry), config);
        }
        tracks[index].label_p = Some(NAMED);
        tracks[index].name_settled = true;
    }
    labels.began.get_or_insert(now);
    labels.resting.retain(|(_, until)| *until > now);
    news |= tracks.iter().any(|t| t.evidence.news);
    if news || labels.next.is_none_or(|next| next <= now) {
        labels.next = Some(now.plus_s(EVERY_S));
        changes.revisions = weigh(labels, tracks, flights, config, now, (pairing, budget));
    }
    changes
}

/// Weighs the odds of all tracks without a name and all lines that no name holds.
fn weigh(
    labels: &Resting,
    tracks: &mut [Track],
    flights: &FlightList,
    config: &TrackingConfig,
    now: SimTime,
    (pairing, budget): (&mut OneToOne, &mut Budget),
) -> u64 {
    let free = |t: &Track| {
        t.stage == Stage::Confirmed && !t.outside && t.callsign.is_none() && t.address.is_none()
    };
    let frozen = |t: &Track| !free(t) || t.unresolved;
    let mut taken: Vec<Callsign> =
        tracks.iter().filter(|t| frozen(t)).filter_map(|t| t.entry).collect();
    taken.extend(labels.resting.iter().map(|(entry, _)| *entry));
    taken.sort_unstable();
    let lines: Vec<&FlightEntry> = flights
        .entries
        .iter()
        .filter(|e| e.movement != MovementKind::Vehicle)
        .filter(|e| taken.binary_search(&e.callsign).is_err())
        .collect();
    let mut rows: Vec<usize> = (0..tracks.len()).filter(|&t| !frozen(&tracks[t])).collect();
    if rows.len().saturating_mul(lines.len()) > MOST_PAIRS {
        rows.retain(|&t| tracks[t].evidence.shows() || tracks[t].entry.is_some());
        rows.truncate(MOST_PAIRS / lines.len().max(1));
    }
    let times = list_times(labels, tracks, &lines, flights, config, now);
    let list = List { flights, config, now, times };
    tracks.iter_mut().for_each(|track| track.evidence.news = false);
    let mut edges = Vec::new();
    for (row, &t) in rows.iter().enumerate() {
        let track = &tracks[t];
        for (column, entry) in lines.iter().enumerate() {
            let gain = track.evidence.log_ratio(&track.spread, track.born, entry, &list);
            if gain > NEGLIGIBLE {
                edges.push(Edge { row: row as u32, column: column as u32, gain });
            }
        }
    }
    budget.spend((8 * rows.len() * lines.len()) as u64);
    budget.spend(pairing.run(rows.len(), lines.len(), &edges, 200, 1e-6));
    let mut shown = vec![false; lines.len()];
    for row in 0..rows.len() {
        for e in pairing.edges_of(row).filter(|&e| pairing.share(e) >= ASSUMED) {
            shown[edges[e].column as usize] = true;
        }
    }
    let began = labels.began.unwrap_or(now);
    let mut revisions = 0;
    for (row, &t) in rows.iter().enumerate() {
        let track = &mut tracks[t];
        let shares =
            pairing.edges_of(row).map(|e| (pairing.share(e), lines[edges[e].column as usize]));
        let best =
            shares.clone().max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.callsign.cmp(&a.1.callsign)));
        if let Some(entry) = track.entry {
            let share = shares.clone().find(|(_, e)| e.callsign == entry).map_or(0.0, |s| s.0);
            track.label_p = Some(share);
            if share >= KEPT {
                continue;
            }
            revisions += 1;
            give(track, None, config);
        }
        (track.assumed, track.label_p) = (None, None);
        let Some((share, entry)) = best.filter(|(share, _)| *share >= ASSUMED) else { continue };
        // What is only assumed says nothing of size and limits: a wrong type is worse than none.
        let lands = track.evidence.landed.is_some();
        if share >= GIVEN && !(lands && comes_after_a_missing_one(entry, &lines, &shown, began)) {
            give(track, Some(entry), config);
        } else {
            track.assumed = Some(entry.callsign);
        }
        track.label_p = Some(share);
    }
    revisions
}

/// Whether an arrival that the list has on the same runway not long before this one has not been seen yet: arrivals keep their
/// turn, so whoever lands at this one's time may well be that one, late.
fn comes_after_a_missing_one(
    entry: &FlightEntry,
    lines: &[&FlightEntry],
    shown: &[bool],
    began: SimTime,
) -> bool {
    lines.iter().zip(shown).any(|(line, shown)| {
        let before_s = entry.eta_ctd.since_s(line.eta_ctd);
        let same = line.movement == MovementKind::Arrival && line.runway == entry.runway;
        same && !shown && line.eta_ctd > began && before_s > 0.0 && before_s <= IN_TURN_S
    })
}

/// How far the list is off, by all landings and take-offs: of tracks with a name against their own line, of others against
/// any line, `ln(1 + Σ odds)`.
fn list_times(
    labels: &Resting,
    tracks: &[Track],
    lines: &[&FlightEntry],
    flights: &FlightList,
    config: &TrackingConfig,
    now: SimTime,
) -> ListTimes {
    let stated = ListTimes::stated(config.labels.list_sigma_s);
    let mut sum = labels.ended;
    for track in tracks.iter().filter(|t| t.evidence.is_event()).take(MOST_EVENTS) {
        let own = track.entry.and_then(|entry| flights.by_callsign(entry));
        let said = match own {
            Some(line) => likelihoods(track, line, flights, config, now),
            None => {
                let mut odds = [1.0; SIGMAS];
                let event = track.evidence.event();
                let near = |e: &&&FlightEntry| {
                    event.is_some_and(|at| at.since_s(e.eta_ctd).abs() < WINDOW_S)
                };
                for line in lines.iter().filter(near).take(MOST_LINES) {
                    let said = likelihoods(track, line, flights, config, now);
                    odds.iter_mut().zip(said).for_each(|(sum, l)| *sum += libm::exp(l));
                }
                odds.map(libm::log)
            }
        };
        sum.iter_mut().zip(said).for_each(|(sum, l)| *sum += l);
    }
    stated.after(&sum)
}

/// ln likelihood of what a track has shown under each deviation, if it is this line.
pub(in crate::fusion) fn likelihoods(
    track: &Track,
    line: &FlightEntry,
    flights: &FlightList,
    config: &TrackingConfig,
    now: SimTime,
) -> [f64; SIGMAS] {
    let stated = ListTimes::stated(config.labels.list_sigma_s);
    std::array::from_fn(|k| {
        let list = List { flights, config, now, times: stated.only(k) };
        track.evidence.log_ratio(&track.spread, track.born, line, &list).clamp(-50.0, 50.0)
    })
}

fn identified<'a>(track: &Track, flights: &'a FlightList) -> Option<&'a FlightEntry> {
    let by_name = track.callsign.and_then(|c| flights.by_callsign(c));
    by_name.or_else(|| track.address.and_then(|a| flights.by_address(a)))
}

fn give(track: &mut Track, entry: Option<&FlightEntry>, config: &TrackingConfig) {
    (track.entry, track.assumed, track.label_p) = (entry.map(|e| e.callsign), None, None);
    track.limits = config.limits_of(entry);
    track.size_m = entry.map(|e| config.size_of(e));
    track.vehicle = entry.is_some_and(|e| e.movement == MovementKind::Vehicle);
}

/// What the list says of the track now.
pub(in crate::fusion) fn label(
    entry: Option<Callsign>,
    flights: &FlightList,
) -> (TrackType, Option<Label>) {
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
