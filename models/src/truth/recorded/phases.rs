//! When the mover stood, turned back on its track, and rolled on a runway; where times are missing.

use super::super::limits::Limits;
use super::reject::{Clean, on_track};
use super::report::Refusal;

/// Longest time without a position while moving, s.
const LONGEST_GAP_S: f64 = 120.0;

/// Longest gap with the line after it, and the number of gaps above 2 s.
pub(super) fn gaps(clean: &Clean) -> Result<((f64, usize), usize), Refusal> {
    let mut longest = (0.0, clean.fixes[0].line);
    let mut count = 0;
    for pair in clean.fixes.windows(2) {
        let gap_s = pair[1].t - pair[0].t;
        let moved_m = (pair[1].p - pair[0].p).norm();
        if gap_s > 2.0 {
            count += 1;
        }
        if gap_s > longest.0 {
            longest = (gap_s, pair[1].line);
        }
        if gap_s > LONGEST_GAP_S && moved_m > 20.0 {
            let limit_s = LONGEST_GAP_S;
            return Err(Refusal::Gap { line: pair[1].line, gap_s, moved_m, limit_s });
        }
    }
    Ok((longest, count))
}

/// A time of standstill, whole seconds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stand {
    pub(super) from: usize,
    pub(super) to: usize,
}

impl Stand {
    pub(super) fn middle(&self) -> usize {
        (self.from + self.to) / 2
    }

    pub(super) fn duration_s(&self) -> f64 {
        (self.to - self.from) as f64
    }
}

/// Times in which the rough track moves by less than 0.3 m/s over a window of four sigma (6 to 30 s).
pub(super) fn stands(clean: &Clean) -> Vec<Stand> {
    const SLOW_MPS: f64 = 0.3;
    let window_s = (4.0 * clean.sigma_m).clamp(6.0, 30.0);
    let reach_m = (2.0 * clean.sigma_m).max(2.5);
    let last = clean.rough.len() - 1;
    let at = |t: f64| on_track(&clean.rough, t);
    let still = |i: usize| {
        let from = (i as f64 - 0.5 * window_s).max(0.0);
        let to = (i as f64 + 0.5 * window_s).min(last as f64);
        (at(to) - at(from)).norm() < SLOW_MPS * (to - from)
    };
    let mut stands: Vec<Stand> = Vec::new();
    let mut open: Option<usize> = None;
    for i in 0..=last + 1 {
        let here = i <= last && still(i);
        let drifted = open.is_some_and(|from| {
            here && (clean.rough[i] - clean.rough[from]).norm() > 2.0 * reach_m
        });
        match open {
            Some(from) if !here || drifted => {
                stands.push(Stand { from, to: i - 1 });
                open = None;
            }
            None if here => {
                // After a standstill it takes some seconds to go on and stop again.
                let free = stands.last().is_none_or(|s| i >= s.to + 7);
                open = free.then_some(i);
            }
            _ => {}
        }
    }
    // At least three whole pieces of the progress have to stand.
    stands.retain(|s| s.to >= s.from + 4);
    stands
}

/// Indices of standstills after which the mover goes back where it came from.
pub(super) fn turns(clean: &Clean, stands: &[Stand]) -> Vec<usize> {
    let reach_m = (3.0 * clean.sigma_m).max(12.0);
    let mut turns = Vec::new();
    let mut since = 0;
    for (index, stand) in stands.iter().enumerate() {
        let here = clean.rough[stand.middle()];
        let away = |i: &usize| (clean.rough[*i] - here).norm() > reach_m;
        let before = (since..stand.from).rev().find(away);
        let after = (stand.to..clean.rough.len()).find(away);
        if let (Some(before), Some(after)) = (before, after) {
            let came = here - clean.rough[before];
            let goes = clean.rough[after] - here;
            if came.dot(&goes) < -0.5 * came.norm() * goes.norm() {
                turns.push(index);
                since = stand.to;
            }
        }
    }
    turns
}

/// A time on the runway at speed and in the air, whole seconds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Roll {
    pub(super) from: usize,
    pub(super) to: usize,
    /// Slower at its end than at its begin.
    pub(super) lands: bool,
    /// Largest speed in it on the ground, m/s.
    pub(super) ground_mps: f64,
    /// Largest speed in it in the air, m/s.
    pub(super) air_mps: f64,
    /// How much earlier or longer the type needs than the recording, s.
    pub(super) lead: usize,
    /// Distance along the path that has to be left for that reason, m: half of the way that it means
    /// before, half after.
    pub(super) mismatch_m: f64,
}

/// Times on the runway at speed and in the air: other limits hold.
pub(super) fn rolls(clean: &Clean, limits: &Limits) -> Vec<Roll> {
    let last = clean.last_s();
    let speed = |i: usize| clean.speed(i as f64);
    let mut rolls = Vec::new();
    let mut i = 0;
    while i <= last {
        if speed(i) <= 1.15 * limits.taxi_mps || limits.least_air_mps.is_infinite() {
            i += 1;
            continue;
        }
        let end = (i..=last).take_while(|j| speed(*j) > 1.15 * limits.taxi_mps).last().unwrap_or(i);
        let fastest = (i..=end).map(speed).fold(0.0, f64::max);
        if fastest > 0.6 * limits.least_air_mps {
            let lands = speed(end) < speed(i);
            let begin = (i.saturating_sub(40)..i).rev().find(|j| speed(*j) < 2.0);
            // A rolling start: from the slowest second before it.
            let slowest = (i.saturating_sub(40)..i).min_by(|a, b| speed(*a).total_cmp(&speed(*b)));
            let begin = begin.or(slowest).unwrap_or(i);
            let stop = (end..=last).find(|j| speed(*j) < 0.8 * limits.taxi_mps).unwrap_or(last);
            let ground_mps = if lands { limits.landing_mps } else { limits.takeoff_mps };
            let around = clean.fixes.iter().zip(&clean.speeds_mps);
            let within = around.filter(|(f, _)| f.t >= i as f64 && f.t <= end as f64);
            let steady_mps = within.map(|(_, v)| *v).filter(|v| v.is_finite()).fold(0.0, f64::max);
            // What the recording gains or loses, and how much longer the type takes for it.
            let change = |j: usize| (speed((j + 10).min(last)) - speed(j)) / 10.0;
            let changes = (begin..=stop.saturating_sub(10).max(begin)).map(change);
            let (recorded_ms2, limit_ms2) = if lands {
                (changes.map(|c| -c).fold(0.0, f64::max), limits.roll_dec_ms2)
            } else {
                (changes.fold(0.0, f64::max), limits.roll_acc_ms2)
            };
            let longer = (1.0 / limit_ms2 - 1.0 / recorded_ms2.max(limit_ms2)).max(0.0);
            let lead = (0.75 * ground_mps * longer).ceil() as usize;
            rolls.push(Roll {
                from: begin.saturating_sub(2 + lead),
                to: stop + 3 + lead,
                lands,
                ground_mps,
                air_mps: (1.1 * ground_mps).max(1.05 * steady_mps),
                lead,
                mismatch_m: ground_mps * ground_mps * longer / 8.0,
            });
        }
        i = end + 1;
    }
    rolls
}

/// Standstills end as much earlier as the type needs more time for the run that follows.
pub(super) fn shortened(stands: Vec<Stand>, rolls: &[Roll]) -> Vec<Stand> {
    let shorten = |mut stand: Stand| {
        let near = |roll: &&Roll| {
            let begin = roll.from + 2 + roll.lead;
            stand.to + 8 >= begin && stand.from < begin
        };
        if let Some(roll) = rolls.iter().find(near) {
            stand.to = stand.to.min(roll.from + 2);
        }
        stand
    };
    stands.into_iter().map(shorten).filter(|s| s.to >= s.from + 4).collect()
}
