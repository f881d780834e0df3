//! Confirmation, coasting, deletion, and duplicates of one long target.

use super::config::TrackingConfig;
use super::numbers::Numbers;
use super::track_file::{Stage, Track, predict};
use super::tracker::Statistics;
use crate::association::grid::Grid;
use crate::flight_list::FlightList;
use crate::frames::Vector2;
use crate::time::SimTime;

/// End of the scan for every track: count the look, confirm or end it.
pub(super) fn end_of_scan(
    tracks: &mut [Track],
    numbers: &mut Numbers,
    now: SimTime,
    flights: &FlightList,
    config: &TrackingConfig,
    statistics: &mut Statistics,
) {
    for track in tracks {
        if track.updated {
            look(track, true);
        } else {
            // As many expected updates as have passed; more than the window holds say no more.
            for _ in 0..u32::BITS {
                if now < track.due {
                    break;
                }
                look(track, false);
                track.due = track.due.plus_s(track.interval_s.max(1e-3));
            }
        }
        match track.stage {
            Stage::Tentative => confirm_or_drop(track, numbers, now, config, statistics),
            Stage::Confirmed => drop_if_lost(track, now, flights, config, statistics),
            Stage::Ended => {}
        }
    }
}

fn look(track: &mut Track, hit: bool) {
    track.history = (track.history << 1) | u32::from(hit);
    track.looks = track.looks.saturating_add(1);
}

/// M of N, sliding window; out of reach as soon as the last N looks hold more than N − M misses.
fn confirm_or_drop(
    track: &mut Track,
    numbers: &mut Numbers,
    now: SimTime,
    config: &TrackingConfig,
    statistics: &mut Statistics,
) {
    let life = &config.life;
    let identified = track.callsign.is_some() || track.address.is_some();
    let (m, n) = if identified {
        (life.identified_hits, life.identified_of)
    } else {
        (life.confirm_hits, life.confirm_of)
    };
    let n = n.clamp(1, u32::BITS);
    let mask = if n == u32::BITS { u32::MAX } else { (1 << n) - 1 };
    let hits = (track.history & mask).count_ones();
    let misses = track.looks.min(n) - hits;
    if hits >= m {
        if let Some(number) = numbers.take(now) {
            track.number = Some(number);
            track.stage = Stage::Confirmed;
            statistics.confirmed += 1;
        } else {
            track.stage = Stage::Ended;
            statistics.no_number += 1;
        }
    } else if misses + m > n {
        track.stage = Stage::Ended;
        statistics.tentative_dropped += 1;
    }
}

fn drop_if_lost(
    track: &mut Track,
    now: SimTime,
    flights: &FlightList,
    config: &TrackingConfig,
    statistics: &mut Statistics,
) {
    let life = &config.life;
    let gap = now.since_s(track.last_hit);
    if gap <= life.delete_moving_s.min(life.delete_standing_s) && !widened(track, now, config) {
        return;
    }
    let estimate = track.filter().estimate();
    let at_stand = || {
        let radius = config.labels.stand_radius_m;
        let near = |stand: Vector2<f64>| (stand - estimate.position_m()).norm() <= radius;
        flights.entries.iter().filter_map(|e| e.stand_m).any(near)
    };
    let standing = estimate.velocity_ms().norm() < 1.0 || at_stand();
    let limit = if standing { life.delete_standing_s } else { life.delete_moving_s };
    let limit = limit.max(life.delete_least_updates * track.interval_s);
    if gap > limit || (widened(track, now, config) && !standing) {
        track.stage = Stage::Ended;
        statistics.deleted += 1;
    }
}

/// Whether the 95 % radius of the position has grown beyond use.
fn widened(track: &Track, now: SimTime, config: &TrackingConfig) -> bool {
    let Ok(estimate) = predict(track.filter(), now, &config.life) else { return false };
    let p = estimate.position_cov_m2();
    let (half_sum, half_gap) = (0.5 * (p[(0, 0)] + p[(1, 1)]), 0.5 * (p[(0, 0)] - p[(1, 1)]));
    let largest = half_sum + libm::hypot(half_gap, p[(0, 1)]);
    !(2.45 * largest.max(0.0).sqrt() <= config.life.delete_radius_m)
}

/// Scans for which two tracks must look like one target before the younger ends.
const TWIN_SCANS: u32 = 3;

/// Ends tracks that follow another part of a target that already has a track: for some scans on the body of
/// a labelled aircraft, or nearer than any two targets stand, and moving alike.
pub(super) fn merge_duplicates(
    tracks: &mut [Track],
    now: SimTime,
    config: &TrackingConfig,
    grid: &mut Grid,
    statistics: &mut Statistics,
) {
    let states: Vec<(Vector2<f64>, Vector2<f64>)> = tracks
        .iter()
        .map(|t| {
            predict(t.filter(), now, &config.life)
                .map_or((Vector2::zeros(), Vector2::zeros()), |e| (e.position_m(), e.velocity_ms()))
        })
        .collect();
    let positions: Vec<_> = states.iter().map(|s| s.0).collect();
    let longest = tracks.iter().filter_map(|t| t.size_m).map(|s| 0.5 * s.0.max(s.1));
    let reach = longest.fold(config.duplicate_radius_m, f64::max);
    grid.fill(&positions, reach);
    for young in 0..tracks.len() {
        let candidate = &tracks[young];
        // A track with a name of its own is a target of its own.
        if candidate.stage != Stage::Confirmed
            || candidate.entry.is_some()
            || candidate.callsign.is_some()
            || candidate.address.is_some()
        {
            continue;
        }
        let (position, velocity) = states[young];
        let around = Vector2::repeat(reach);
        let mut twin: Option<u64> = None;
        grid.visit(position - around, position + around, |old| {
            let other = &tracks[old];
            let older = old != young
                && other.stage == Stage::Confirmed
                && (other.serial < candidate.serial || other.entry.is_some());
            if older
                && (states[old].1 - velocity).norm() < 2.0 + 0.1 * velocity.norm()
                && on_body(other, states[old].0, position, config.duplicate_radius_m)
            {
                twin = Some(twin.map_or(other.serial, |s| s.min(other.serial)));
            }
        });
        let candidate = &mut tracks[young];
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

/// Whether `point_m` lies on the body of `track` (its type known) or within `radius_m` of it.
pub(super) fn on_body(
    track: &Track,
    position_m: Vector2<f64>,
    point_m: Vector2<f64>,
    radius_m: f64,
) -> bool {
    let offset = point_m - position_m;
    let Some((length, span)) = track.size_m else { return offset.norm() <= radius_m };
    let (sin, cos) = libm::sincos(track.heading_rad);
    let along = offset.x * sin + offset.y * cos;
    let aside = offset.x * cos - offset.y * sin;
    // The track follows some part of the target, so another part is almost a length away.
    along.abs() <= 0.9 * length && aside.abs() <= 0.6 * span
}
