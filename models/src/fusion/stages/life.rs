//! Confirmation, coasting and deletion.

use crate::filter::Estimate;
use crate::flight_list::FlightList;
use crate::frames::Point2;
use crate::fusion::config::{Life, TrackingConfig};
use crate::fusion::filter::predict;
use crate::fusion::numbers::Numbers;
use crate::fusion::own::{Initiation, Shown, Trial};
use crate::fusion::state::{Statistics, Tracker};
use crate::fusion::track_file::{Missed, Stage, Track};
use crate::fusion::way::Ring;
use crate::time::SimTime;
use crate::track::{HEIGHT_KEPT_S, SecondAgo, SystemTrack, TrackStatus, TrackType};

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
                made_up(track, now);
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
                    track.missed = Some(Missed { at: now, looks: track.looks });
                    if let (Some(doubt), Some(rules)) = (&mut track.doubt, &config.life.existence) {
                        doubt.survive(now, track.evidence.took_off.is_some(), rules);
                        doubt.miss(position_m, places);
                    }
                    track.due = track.due.plus_s(track.wait_s.max(1e-3));
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
        let at = predict(track.filter(), now, track.way.gaps(config)).ok()?;
        at.state.is_sound().then_some(at)
    };
    let at = sound(track);
    if at.is_some() {
        return at;
    }
    statistics.not_positive_definite += 1;
    let again = if track.way.begin_again(config, ring) { sound(track) } else { None };
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
    if track.born > then {
        return None;
    }
    let (position_m, cov_m2) = track.way.second_ago(then, config, ring)?;
    let coasted = track.last_hit <= then;
    // What the echo's law leaves open is as open a scan ago.
    let cov_m2 = cov_m2 + track.echo_left_m2;
    Some(SecondAgo { time: then, position_m, cov_m2, coasted })
}

/// A track in this state as it is published, but for its label and status.
fn published(track: &Track, number: u16, at: &Estimate) -> SystemTrack {
    let altitude = track.altitude.filter(|(_, told)| at.time.since_s(*told) <= HEIGHT_KEPT_S);
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
        altitude_m: altitude.map(|(height_m, _)| height_m),
        altitude_at: altitude.map(|(_, told)| told),
        heading_rad: at.heading_rad().map_or(track.heading_rad, |(heading, _)| heading),
        manoeuvre: track.manoeuvre,
        label: None,
        reported: track.callsign,
        assumed: None,
        label_p: None,
        address: track.address,
        existence_p: track.doubt.as_ref().map(|doubt| doubt.existence.there()),
        unresolved: track.unresolved,
        second_ago: None,
    }
}

fn look(track: &mut Track, hit: bool) {
    track.history = (track.history << 1) | u32::from(hit);
    track.looks = track.looks.saturating_add(1);
}

/// The looks of a track that has had plots in this scan. What was measured before a miss was counted, and came after that, was
/// no miss; it says nothing of this look.
fn made_up(track: &mut Track, now: SimTime) {
    if track.came_late
        && let Some(missed) = track.missed.take()
    {
        let before = track.looks.saturating_sub(missed.looks);
        track.history |= 1_u32.checked_shl(before).unwrap_or(0);
    }
    if track.came_in_time {
        look(track, true);
        return;
    }
    for _ in 0..u32::BITS {
        if now < track.due {
            break;
        }
        look(track, false);
        track.missed = Some(Missed { at: now, looks: track.looks });
        track.due = track.due.plus_s(track.wait_s.max(1e-3));
    }
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
    // Nothing on or over a runway is that fast: a state that has gone wrong. Who says that he is high may be.
    let fresh = |told: &SimTime| at.time.since_s(*told) <= HEIGHT_KEPT_S;
    let high =
        track.altitude.is_some_and(|(height_m, told)| height_m > OVERFLIES_M && fresh(&told));
    let fast = at.velocity_mps().norm() > IMPOSSIBLE_MPS && !high;
    track.too_fast = if fast { track.too_fast + 1 } else { 0 };
    if track.too_fast >= TOO_FAST_SCANS {
        track.stage = Stage::Ended;
        statistics.deleted += 1;
        return;
    }
    let gap = at.time.since_s(track.last_hit);
    let lost = is_lost(track, at, life.delete_radius_m);
    if let Some(rules) = &life.existence {
        let over = track.doubt.as_ref().is_some_and(|doubt| doubt.is_over(rules));
        if over || (lost && !track.unresolved) {
            track.stage = Stage::Ended;
            statistics.deleted += 1;
        }
        return;
    }
    let soonest = life.delete_moving_s.min(life.delete_standing_s);
    let left = track.evidence.took_off.is_some();
    if gap <= soonest && !lost && !left {
        return;
    }
    let (position, velocity) = track.filter().motion();
    // What has taken off and is not seen has left the field of a surface sensor: nothing to wait for.
    let unseen_s = life.delete_least_updates * track.interval_s.max(TOLD_AGAIN_S);
    if left && velocity.norm() > AIRBORNE_MPS && gap > unseen_s {
        track.stage = Stage::Ended;
        statistics.deleted += 1;
        return;
    }
    let at_stand = || {
        let radius = config.labels.stand_radius_m;
        let near = |stand: Point2<f64>| (stand - position).norm() <= radius;
        flights.entries.iter().filter_map(|e| e.stand_m).any(near)
    };
    let standing = velocity.norm() < 1.0 || at_stand();
    let limit = if standing { life.delete_standing_s } else { life.delete_moving_s };
    let limit = limit.max(life.delete_least_updates * track.interval_s);
    // Where nothing can be told apart a track is wide, but not lost.
    if gap > limit || (lost && !standing && !track.unresolved) {
        track.stage = Stage::Ended;
        statistics.deleted += 1;
    }
}

/// Faster than any target of a surface sensor, m/s (assumed; the fastest touch down at 90).
const IMPOSSIBLE_MPS: f64 = 150.0;

/// Higher than this one flies over the field, m (assumed).
const OVERFLIES_M: f64 = 150.0;

/// Faster than this what has begun its run is in the air, m/s (assumed; rotation at 60 to 80).
const AIRBORNE_MPS: f64 = 70.0;

/// One who is heard more often than this is not gone with a few of its reports, s: those of one transponder are lost together.
const TOLD_AGAIN_S: f64 = 1.0;

/// Scans in a row at such a speed that end a track.
const TOO_FAST_SCANS: u8 = 3;

/// Whether two looks lack and its 95 % radius has grown beyond `radius_m` since the last plot. Nobody is lost between two looks that
/// come as they are due, nor by one that fails, however long that is; nor is who tells his place no better than that.
fn is_lost(track: &Track, at: &Estimate, radius_m: f64) -> bool {
    widened(at, radius_m)
        && at.time.since_s(track.last_hit) > TWO_LACK * track.wait_s
        && widened(at, GROWN * radius_95_m(&track.filter().estimate()))
}

/// After so many of its intervals two looks lack.
const TWO_LACK: f64 = 2.5;

/// A track that is so many times wider than with its last plot has grown since (assumed).
const GROWN: f64 = 2.0;

/// Radius within which the target is with 95 %, m.
fn radius_95_m(at: &Estimate) -> f64 {
    let p = at.state.position_cov();
    let largest = 0.5 * (p.xx + p.yy) + libm::hypot(0.5 * (p.xx - p.yy), p.xy);
    2.45 * largest.max(0.0).sqrt()
}

/// Whether the 95 % radius of the position is above `radius_m`.
fn widened(at: &Estimate, radius_m: f64) -> bool {
    let p = at.state.position_cov();
    let (half_sum, half_gap) = (0.5 * (p.xx + p.yy), 0.5 * (p.xx - p.yy));
    // The larger eigenvalue is not above this; mostly that is enough.
    let bound = 2.45 * 2.45 * (half_sum + half_gap.abs() + p.xy.abs());
    if bound <= 0.998 * radius_m * radius_m {
        return false;
    }
    !(radius_95_m(at) <= radius_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::{Gaussian, Sym2};

    /// The radius within which a target is with 95 %: of the longer axis, however it lies.
    #[test]
    fn a_track_is_too_wide_by_its_longer_axis() {
        let is = |xx: f64, xy: f64, yy: f64| {
            let r = Sym2 { xx, xy, yy };
            let state = Gaussian::at_position(Point2::origin(), r, 1.0, 0.1);
            widened(&Estimate::new(SimTime::ZERO, state), 60.0)
        };
        let edge = (60.0f64 / 2.447_747).powi(2);
        for share in [0.98, 1.02] {
            let wide = share > 1.0;
            assert_eq!(is(share * edge, 0.0, 1.0), wide);
            assert_eq!(is(1.0, 0.0, share * edge), wide);
            assert_eq!(is(share * edge, 0.0, share * edge), wide);
            // Along the diagonal.
            let half = 0.5 * share * edge;
            assert_eq!(is(half + 0.5, half - 0.5, half + 0.5), wide);
        }
    }
}
