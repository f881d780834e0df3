//! Confirmation, coasting, deletion, and duplicates of one long target.

use crate::filter::Estimate;
use crate::flight_list::FlightList;
use crate::frames::Vector2;
use crate::fusion::config::{Life, TrackingConfig};
use crate::fusion::filter::predict;
use crate::fusion::numbers::Numbers;
use crate::fusion::own::{Initiation, Shown, Trial};
use crate::fusion::size;
use crate::fusion::state::{Statistics, Tracker, Work};
use crate::fusion::track_file::{Ring, Stage, Track};
use crate::time::SimTime;
use crate::track::{SecondAgo, SystemTrack, TrackStatus, TrackType};

impl Tracker {
    /// End of the scan for every track: count the look, confirm or end it. Gives the confirmed tracks as they are now,
    /// without a label, and puts their indices into `seen`.
    pub(in crate::fusion) fn end_of_scan(
        &mut self,
        now: SimTime,
        flights: &FlightList,
        seen: &mut Vec<u32>,
    ) -> Vec<SystemTrack> {
        let Self {
            tracks, ring, numbers, config, statistics, previous, initiation, places, ..
        } = self;
        seen.clear();
        let mut out = Vec::with_capacity(tracks.len());
        for (index, track) in tracks.iter_mut().enumerate() {
            // Where it is by its last plot: near enough for a square of the grid of places.
            let position_m = track.filter().motion().0;
            if track.updated {
                look(track, true);
                if let (Some(doubt), Stage::Confirmed) = (&mut track.doubt, track.stage) {
                    doubt.seen(position_m, places);
                }
            } else {
                // As many expected updates as have passed; more than the window holds say no more.
                for _ in 0..u32::BITS {
                    if now < track.due {
                        break;
                    }
                    look(track, false);
                    if let (Some(doubt), Some(rules)) = (&mut track.doubt, &config.life.existence) {
                        doubt.survive(now, track.evidence.took_off.is_some(), rules);
                        doubt.miss(position_m, places);
                    }
                    track.due = track.due.plus_s(track.interval_s.max(1e-3));
                }
            }
            let before = track.stage;
            if before == Stage::Tentative {
                judge(track, initiation.as_deref(), numbers, now, config, statistics);
            }
            let (Stage::Confirmed, Some(number)) = (track.stage, track.number) else { continue };
            let Some(at) = present(track, ring, now, config, statistics) else { continue };
            if before == Stage::Confirmed {
                drop_if_lost(track, &at, flights, config, statistics);
            }
            track.evidence.take_state(&at, track.plots, flights, &config.labels);
            seen.push(index as u32);
            let mut shown = published(track, number, &at);
            if let Some(then) = previous.filter(|_| config.second_ago && track.published) {
                shown.second_ago = second_ago(track, then, config, ring);
            }
            out.push(shown);
        }
        out
    }
}

/// The state at the end of the scan. One that may not be used is never used: it is counted, and the track
/// begins again from its last plot; if that does not help either, it ends.
fn present(
    track: &mut Track,
    ring: &Ring,
    now: SimTime,
    config: &TrackingConfig,
    statistics: &mut Statistics,
) -> Option<Estimate> {
    let sound = |track: &Track| {
        let at = predict(track.filter(), now, &config.life).ok()?;
        at.state.is_sound().then_some(at)
    };
    let at = sound(track);
    if at.is_some() {
        return at;
    }
    statistics.not_positive_definite += 1;
    let again = if track.begin_again(config, ring) { sound(track) } else { None };
    if again.is_none() {
        track.stage = Stage::Ended;
        statistics.deleted += 1;
    }
    again
}

/// The publication before, by what is known now.
fn second_ago(
    track: &Track,
    then: SimTime,
    config: &TrackingConfig,
    ring: &Ring,
) -> Option<SecondAgo> {
    let (position_m, cov_m2) = track.second_ago(then, config, ring)?;
    let coasted = track.last_hit <= then;
    // What the echo's law leaves open is as open a scan ago.
    let cov_m2 = cov_m2 + track.echo_left_m2;
    Some(SecondAgo { time: then, position_m, cov_m2, coasted })
}

/// A track in this state as it is published, but for its label and status.
fn published(track: &Track, number: u16, at: &Estimate) -> SystemTrack {
    SystemTrack {
        number,
        track_type: TrackType::NotAssociated,
        status: TrackStatus::Confirmed,
        first: !track.published,
        time: at.time,
        last_plot: track.last_hit,
        position_m: at.position_m(),
        velocity_mps: at.velocity_mps(),
        acceleration_ms2: at.acceleration_ms2(),
        position_cov_m2: at.position_cov_m2() + track.echo_left_m2,
        velocity_cov_m2s2: at.velocity_cov_m2s2(),
        altitude_m: track.altitude_m,
        heading_rad: at.heading_rad().map_or(track.heading_rad, |(heading, _)| heading),
        manoeuvre: track.manoeuvre,
        label: None,
        reported: track.callsign,
        assumed: None,
        label_p: None,
        second_ago: None,
    }
}

fn look(track: &mut Track, hit: bool) {
    track.history = (track.history << 1) | u32::from(hit);
    track.looks = track.looks.saturating_add(1);
}

/// M of N, sliding window; out of reach as soon as the last N looks hold more than N − M misses.
fn m_of_n(shown: &Shown, life: &Life) -> Trial {
    let (m, n) = if shown.named {
        (life.identified_hits, life.identified_of)
    } else {
        (life.confirm_hits, life.confirm_of)
    };
    let n = n.clamp(1, u32::BITS);
    let mask = if n == u32::BITS { u32::MAX } else { (1 << n) - 1 };
    let hits = (shown.history & mask).count_ones();
    let misses = shown.looks.min(n) - hits;
    if hits >= m {
        Trial::Confirmed
    } else if misses + m > n {
        Trial::Dropped
    } else {
        Trial::Goes
    }
}

/// What becomes of a track on trial, by our rule or somebody's own.
fn judge(
    track: &mut Track,
    own: Option<&dyn Initiation>,
    numbers: &mut Numbers,
    now: SimTime,
    config: &TrackingConfig,
    statistics: &mut Statistics,
) {
    let shown = Shown {
        history: track.history,
        looks: track.looks,
        plots: track.plots,
        named: track.callsign.is_some() || track.address.is_some(),
    };
    let ours = || match (&track.doubt, &config.life.existence) {
        (Some(doubt), Some(rules)) => doubt.judge(rules),
        _ => m_of_n(&shown, &config.life),
    };
    match own.map_or_else(ours, |own| own.judge(&shown)) {
        Trial::Goes => {}
        Trial::Confirmed => {
            if let Some(number) = numbers.take(now, track.outside) {
                track.number = Some(number);
                track.stage = Stage::Confirmed;
                statistics.confirmed += 1;
            } else {
                track.stage = Stage::Ended;
                statistics.no_number += 1;
            }
        }
        Trial::Dropped => {
            track.stage = Stage::Ended;
            statistics.tentative_dropped += 1;
        }
    }
}

fn drop_if_lost(
    track: &mut Track,
    at: &Estimate,
    flights: &FlightList,
    config: &TrackingConfig,
    statistics: &mut Statistics,
) {
    let life = &config.life;
    // Nothing on or over a runway is that fast: a state that has gone wrong.
    let fast = at.velocity_mps().norm() > IMPOSSIBLE_MPS;
    track.too_fast = if fast { track.too_fast + 1 } else { 0 };
    if track.too_fast >= TOO_FAST_SCANS {
        track.stage = Stage::Ended;
        statistics.deleted += 1;
        return;
    }
    let gap = at.time.since_s(track.last_hit);
    let widened = widened(at, life.delete_radius_m);
    if let Some(rules) = &life.existence {
        let over = track.doubt.as_ref().is_some_and(|doubt| doubt.is_over(rules));
        if over || (widened && !track.unresolved) {
            track.stage = Stage::Ended;
            statistics.deleted += 1;
        }
        return;
    }
    let soonest = life.delete_moving_s.min(life.delete_standing_s);
    let left = track.evidence.took_off.is_some();
    if gap <= soonest && !widened && !left {
        return;
    }
    let (position, velocity) = track.filter().motion();
    // What has taken off and is not seen has left the field of a surface sensor: nothing to wait for.
    if left && velocity.norm() > AIRBORNE_MPS && gap > life.delete_least_updates * track.interval_s
    {
        track.stage = Stage::Ended;
        statistics.deleted += 1;
        return;
    }
    let at_stand = || {
        let radius = config.labels.stand_radius_m;
        let near = |stand: Vector2<f64>| (stand - position).norm() <= radius;
        flights.entries.iter().filter_map(|e| e.stand_m).any(near)
    };
    let standing = velocity.norm() < 1.0 || at_stand();
    let limit = if standing { life.delete_standing_s } else { life.delete_moving_s };
    let limit = limit.max(life.delete_least_updates * track.interval_s);
    // Where nothing can be told apart a track is wide, but not lost.
    if gap > limit || (widened && !standing && !track.unresolved) {
        track.stage = Stage::Ended;
        statistics.deleted += 1;
    }
}

/// Faster than any target of a surface sensor, m/s (assumed; the fastest touch down at 90).
const IMPOSSIBLE_MPS: f64 = 150.0;

/// Faster than this what has begun its run is in the air, m/s (assumed; rotation at 60 to 80).
const AIRBORNE_MPS: f64 = 70.0;

/// Scans in a row at such a speed that end a track.
const TOO_FAST_SCANS: u8 = 3;

/// Whether the 95 % radius of the position has grown beyond `radius_m`.
fn widened(at: &Estimate, radius_m: f64) -> bool {
    let p = at.state.position_cov();
    let (half_sum, half_gap) = (0.5 * (p.xx + p.yy), 0.5 * (p.xx - p.yy));
    // The larger eigenvalue is not above this; mostly that is enough.
    let bound = 2.45 * 2.45 * (half_sum + half_gap.abs() + p.xy.abs());
    if bound <= 0.998 * radius_m * radius_m {
        return false;
    }
    let largest = half_sum + libm::hypot(half_gap, p.xy);
    !(2.45 * largest.max(0.0).sqrt() <= radius_m)
}

/// Tracks beside one that are looked at.
const NEIGHBOURS: usize = 64;

/// Scans for which two tracks must look like one target before the younger ends.
const TWIN_SCANS: u32 = 3;

/// Ends tracks that follow another part of a target that already has a track: for some scans on the body of
/// a labelled aircraft, or nearer than any two targets stand, and moving alike.
pub(in crate::fusion) fn merge_duplicates(
    tracks: &mut [Track],
    shown: &[SystemTrack],
    config: &TrackingConfig,
    work: &mut Work,
    statistics: &mut Statistics,
) {
    let Work { seen, positions, plots: grid, near, .. } = work;
    positions.clear();
    positions.extend(shown.iter().map(|s| s.position_m));
    let named = |track: &Track| track.callsign.is_some() || track.address.is_some();
    let mut reach = config.duplicate_radius_m;
    for track in seen.iter().map(|&s| &tracks[s as usize]) {
        if let Some((length, span)) = track.size_m.or_else(|| track.extent.size_m()) {
            reach = reach.max(libm::hypot(ALONG * length, ASIDE * span));
        }
        if named(track) {
            reach = reach.max(NAMESAKES_M);
        }
    }
    if !(reach > 0.0) {
        return;
    }
    grid.fill(positions, reach);
    let around = Vector2::repeat(reach);
    for young in 0..seen.len() {
        let position = positions[young];
        // Mostly nobody else is there: it finds only itself.
        let mut there = 0;
        let (low, high) = (position - around, position + around);
        grid.visit_near(low, high, NEIGHBOURS, near, |old| {
            let offset = positions[old] - position;
            there += u32::from(offset.x.abs() <= reach) & u32::from(offset.y.abs() <= reach);
        });
        let candidate = &mut tracks[seen[young] as usize];
        if there <= 1 || candidate.unresolved {
            candidate.twin = None;
            continue;
        }
        let candidate = &tracks[seen[young] as usize];
        if candidate.stage != Stage::Confirmed {
            continue;
        }
        let nameless = candidate.entry.is_none() && !named(candidate);
        let velocity = shown[young].velocity_mps;
        let alike = 2.0 + 0.1 * velocity.norm();
        let mut twin: Option<u64> = None;
        grid.visit_near(low, high, NEIGHBOURS, near, |old| {
            let offset = positions[old] - position;
            if old == young || offset.x.abs() > reach || offset.y.abs() > reach {
                return;
            }
            let other = &tracks[seen[old] as usize];
            // A track with a name of its own is a target of its own.
            let double = if nameless {
                (other.serial < candidate.serial || other.entry.is_some())
                    && (shown[old].velocity_mps - velocity).norm() < alike
                    && on_body(other, positions[old], position, config.duplicate_radius_m)
            } else {
                other.serial < candidate.serial
                    && same_name(candidate, other)
                    && (positions[old] - position).norm() <= NAMESAKES_M
            };
            if other.stage == Stage::Confirmed && double {
                twin = Some(twin.map_or(other.serial, |s| s.min(other.serial)));
            }
        });
        let candidate = &mut tracks[seen[young] as usize];
        candidate.twin = twin.map(|serial| match candidate.twin {
            Some((before, scans)) if before == serial => (serial, scans + 1),
            _ => (serial, 1),
        });
        if candidate.twin.is_some_and(|(_, scans)| scans >= TWIN_SCANS) {
            candidate.stage = Stage::Ended;
            statistics.merged += 1;
        }
    }
}

/// Two tracks of one name this near are one target, m.
const NAMESAKES_M: f64 = 60.0;

/// Whether both were called the same by their plots.
fn same_name(a: &Track, b: &Track) -> bool {
    (a.callsign.is_some() && a.callsign == b.callsign)
        || (a.address.is_some() && a.address == b.address)
}

/// The track follows some part of the target, so another part is almost a length away.
const ALONG: f64 = 0.9;
/// The same across, of the span.
const ASIDE: f64 = 0.6;

/// How far from the middle of a target of unknown type another echo of it may lie, m: what its echoes show of its size, and
/// the errors of two plots. Two small aircraft parked ten metres apart are two.
fn reach_of_body_m(track: &Track) -> f64 {
    match track.spread.variance_m2() {
        Some((seen_m2, triples)) if triples >= size::FEWEST_TRIPLES => {
            0.75 * size::diagonal_m(1.3 * seen_m2) + BESIDE_M
        }
        _ => f64::INFINITY,
    }
}

/// Two plots of one point are no farther apart than this, m.
const BESIDE_M: f64 = 2.0;

/// Whether `point_m` lies on the body of `track` (its type known) or within `radius_m` of it.
pub(in crate::fusion) fn on_body(
    track: &Track,
    position_m: Vector2<f64>,
    point_m: Vector2<f64>,
    radius_m: f64,
) -> bool {
    let offset = point_m - position_m;
    let (length, span, beside) = match (track.size_m, track.extent.size_m()) {
        (Some((length, span)), _) => (length, span, 0.0),
        // As the cells show it, with the errors of two plots: a box where the course is known, else all round.
        (None, Some((length, width))) if track.course.is_some() => (length, width, BESIDE_M),
        (None, Some((length, _))) => return offset.norm() <= ALONG * length + BESIDE_M,
        (None, None) => return offset.norm() <= radius_m.min(reach_of_body_m(track)),
    };
    let (sin, cos) = libm::sincos(track.heading_rad);
    let along = offset.x * sin + offset.y * cos;
    let aside = offset.x * cos - offset.y * sin;
    along.abs() <= ALONG * length + beside && aside.abs() <= ASIDE * span + beside
}
