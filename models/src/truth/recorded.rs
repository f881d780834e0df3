//! A sound truth from a recorded movement.
//!
//! 1. Positions that cannot be true are rejected (`repair`).
//! 2. Times of standstill are found; where the mover turns back on its track after one, the movement
//!    is cut into legs, and the first of the two is driven backward (pushback).
//! 3. Each leg gets a smooth path with a limited curvature.
//! 4. Progress along it is the smooth function of time, within the limits of the type, that is nearest
//!    to the positions; it is constant at standstill.
//! 5. Height is zero on the ground and follows the reported altitude, less the offset that the same
//!    flight shows on the ground, in the air.

use super::dubins::{self, Pose};
use super::fit::{Bound, Control, Datum, Fit};
use super::limits::{AIR_LATERAL_MS2, Limits};
use super::repair::{self, Clean, Fix, LATENESS_S, median, on_track};
use super::spline::Spline;
use super::trajectory::{Leg, Trajectory};
use crate::frames::Vector2;
use crate::time::SimTime;
use std::collections::BTreeMap;

/// One line of a recording. What is missing or damaged in the file is `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// Line in the file.
    pub line: usize,
    /// UTC, milliseconds.
    pub time_ms: Option<i64>,
    /// East and north, m.
    pub position_m: Option<Vector2<f64>>,
    /// Pressure altitude over the field elevation, m.
    pub altitude_m: Option<f64>,
    /// What the transponder said.
    pub on_ground: Option<bool>,
}

/// What was done to records, by rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rule {
    /// No sound time.
    NoTime,
    /// Not later than the record before.
    TimeOrder,
    /// No sound position.
    NoPosition,
    /// More than 60 km from the airport.
    OutOfReach,
    /// Cannot be reached from its neighbours.
    Jump,
    /// A position repeated although the mover went on.
    NotRenewed,
    /// Far beside the path.
    BesidePath,
    /// Far from where the mover can have been at the time.
    OffTime,
    /// An altitude that cannot be flown.
    AltitudeSpike,
    /// The ground flag contradicts height and speed.
    GroundFlag,
}

impl Rule {
    /// One line for people.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::NoTime => "rejected: time missing or not a number",
            Self::TimeOrder => "rejected: time not after the record before",
            Self::NoPosition => "filled: position missing or not a number",
            Self::OutOfReach => "rejected: position more than 60 km away",
            Self::Jump => "rejected: position cannot be reached from its neighbours",
            Self::NotRenewed => "rejected: position repeated, not renewed, while moving",
            Self::BesidePath => "rejected: position beside the path by more than 6 sigma + 5 m",
            Self::OffTime => "smoothed away: position along the path off by more than 4 sigma",
            Self::AltitudeSpike => "rejected: altitude cannot be flown",
            Self::GroundFlag => "ignored: ground flag contradicts height and speed",
        }
    }
}

/// Counts of rules with the first line each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally(BTreeMap<Rule, (usize, usize)>);

impl Tally {
    pub(super) fn add(&mut self, rule: Rule, line: usize) {
        let entry = self.0.entry(rule).or_insert((0, line));
        entry.0 += 1;
        entry.1 = entry.1.min(line);
    }

    /// How often a rule was applied.
    #[must_use]
    pub fn count(&self, rule: Rule) -> usize {
        self.0.get(&rule).map_or(0, |e| e.0)
    }

    /// Rules with count and first line.
    pub fn rows(&self) -> impl Iterator<Item = (Rule, usize, usize)> {
        self.0.iter().map(|(rule, (count, line))| (*rule, *count, *line))
    }
}

/// What the import did, for people.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Records in the file (after the cut).
    pub records: usize,
    /// Positions that the truth follows.
    pub used: usize,
    /// By rule and number.
    pub tally: Tally,
    /// Longest time without a used position, s, and the line after it.
    pub longest_gap: (f64, usize),
    /// Number of times without a used position for more than 2 s.
    pub gaps: usize,
    /// Standstills: number and duration in s.
    pub stands: (usize, f64),
    /// Legs driven backward.
    pub pushbacks: usize,
    /// Typical error of a position across the path, m.
    pub sigma_m: f64,
    /// Root mean square and largest distance of used positions across the path, m.
    pub across_m: (f64, f64),
    /// Root mean square and largest distance of used positions along the path, m.
    pub along_m: (f64, f64),
    /// Pressure altitude on the ground over the field elevation, m; removed.
    pub altitude_offset_m: Option<f64>,
    /// Lift-off and touchdown, s after the first record.
    pub liftoff_s: Option<f64>,
    /// Touchdown, s after the first record.
    pub touchdown_s: Option<f64>,
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "{} records, {} positions used", self.records, self.used)?;
        for (rule, count, line) in self.tally.rows() {
            writeln!(f, "  {count:5}  {} (first in line {line})", rule.text())?;
        }
        let (gap_s, gap_line) = self.longest_gap;
        writeln!(
            f,
            "  {:5}  filled: time without a position above 2 s; longest {gap_s:.1} s, to line {gap_line}",
            self.gaps
        )?;
        let (stands, stand_s) = self.stands;
        writeln!(
            f,
            "  {stands:5}  standstills, {stand_s:.0} s in all; backward legs: {}",
            self.pushbacks
        )?;
        writeln!(
            f,
            "         error of a position: sigma {:.1} m; left across the path rms {:.1} m, max {:.1} m; along it rms {:.1} m, max {:.1} m",
            self.sigma_m, self.across_m.0, self.across_m.1, self.along_m.0, self.along_m.1
        )?;
        if let Some(offset_m) = self.altitude_offset_m {
            writeln!(f, "         altitude offset removed: {offset_m:+.1} m")?;
        }
        let time = |t: Option<f64>| t.map_or("none".into(), |t| format!("{t:.1} s"));
        write!(
            f,
            "         lift-off {}, touchdown {}",
            time(self.liftoff_s),
            time(self.touchdown_s)
        )
    }
}

/// Why a recording cannot be repaired.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// Hardly any sound positions.
    #[error("only {left} of {records} positions are sound, needed are 10 and an eighth of all")]
    TooFew {
        /// Line to look at.
        line: usize,
        /// Sound positions.
        left: usize,
        /// Records.
        records: usize,
    },
    /// Too long without a position while the mover went on.
    #[error(
        "no sound position for {gap_s:.0} s while it moved {moved_m:.0} m, allowed is {limit_s:.0} s"
    )]
    Gap {
        /// Line after the gap.
        line: usize,
        /// Duration.
        gap_s: f64,
        /// Distance.
        moved_m: f64,
        /// Limit.
        limit_s: f64,
    },
    /// Longer than anything on the surface.
    #[error("spans {span_s:.0} s, allowed is {limit_s:.0} s")]
    TooLong {
        /// Last line.
        line: usize,
        /// Duration.
        span_s: f64,
        /// Limit.
        limit_s: f64,
    },
    /// The limits of the type do not allow anything near the positions.
    #[error(
        "the type cannot move like this: {off_m:.0} m off the recorded positions within its speeds and accelerations"
    )]
    BeyondType {
        /// Line of the largest distance.
        line: usize,
        /// Distance.
        off_m: f64,
    },
}

impl Refusal {
    /// Line of the file to look at.
    #[must_use]
    pub fn line(&self) -> usize {
        match self {
            Self::TooFew { line, .. }
            | Self::Gap { line, .. }
            | Self::TooLong { line, .. }
            | Self::BeyondType { line, .. } => *line,
        }
    }
}

/// Longest time without a position while moving, s.
const LONGEST_GAP_S: f64 = 120.0;
/// Longest movement, s.
const LONGEST_S: f64 = 4.0 * 3600.0;
/// Largest distance along the path that smoothing may leave (95 % of positions), m.
const FARTHEST_M: f64 = 150.0;
/// Distance of the controls of a path, m.
const PATH_STEP_M: f64 = 4.0;
/// Path before the first and after the last position, m.
const MARGIN_M: f64 = 12.0;

/// A sound truth from records in the order of the file; it begins at `start`.
///
/// # Errors
/// If too little of the recording can be true, see [`Refusal`].
pub fn import(
    records: &[Record],
    limits: &Limits,
    start: SimTime,
) -> Result<(Trajectory, Report), Refusal> {
    let mut tally = Tally::default();
    let last_line = records.last().map_or(1, |r| r.line);
    let too_few = |left| Refusal::TooFew { line: last_line, left, records: records.len() };
    let clean = repair::clean(records, 2.0 * limits.takeoff_ms, LONGEST_S, &mut tally);
    let clean = clean.ok_or(too_few(0))?;
    let span_s = clean.fixes.last().map_or(0.0, |f| f.t);
    if span_s > LONGEST_S {
        return Err(Refusal::TooLong { line: last_line, span_s, limit_s: LONGEST_S });
    }
    if clean.fixes.len() < 10 || clean.fixes.len() * 8 < records.len() {
        return Err(too_few(clean.fixes.len()));
    }
    let gaps = gaps(&clean)?;
    let stands = stands(&clean);
    let rolls = rolls(&clean, limits);
    let turns = turns(&clean, &stands);
    let mut work = Work { limits, clean: &clean, stands: &stands, rolls: &rolls, tally };
    let pieces = clean.rough.len() - 1;
    // Legs by time: from a turn to the next, in whole seconds.
    let mut bounds: Vec<usize> = turns.iter().map(|i| stands[*i].middle()).collect();
    bounds.insert(0, 0);
    bounds.push(pieces);
    let mut legs: Vec<Leg> = Vec::new();
    let mut controls: Vec<[f64; 1]> = Vec::new();
    let mut residuals = Residuals::default();
    let mut from_m = 0.0;
    for (index, span) in bounds.windows(2).enumerate() {
        let begin = legs.last().map(|leg: &Leg| {
            let end = leg.path.at(from_m - leg.from_m);
            let tangent = -Vector2::from(end.first).normalize();
            (Vector2::from(end.value), tangent)
        });
        let last = index + 2 == bounds.len();
        let (path, progress) = work
            .leg(span[0], span[1], begin, last, &mut residuals)
            .ok_or(too_few(clean.fixes.len()))?;
        let end_m = progress[progress.len() - 1][0];
        controls.truncate(span[0]);
        controls.extend(progress.iter().map(|c| [c[0] + from_m]));
        let backward = (bounds.len() - 2 - index) % 2 == 1;
        legs.push(Leg { from_m, path, backward });
        from_m += end_m;
    }
    let progress = Spline::new(0.0, 1.0, controls).ok_or(too_few(clean.fixes.len()))?;
    if residuals.rows.len() * 2 < clean.fixes.len() {
        // Most positions lie beside every path that the type can take.
        let off_m = residuals.rows.iter().map(|r| r.across_m).fold(0.0, f64::max);
        return Err(Refusal::BeyondType { line: last_line, off_m });
    }
    if let Some((off_m, line)) = residuals.beyond(FARTHEST_M) {
        return Err(Refusal::BeyondType { line, off_m });
    }
    let air = Air::of(records, clean.t0_ms, &progress, limits, &mut work.tally);
    let end = start.plus_s(clean.fixes.last().map_or(0.0, |f| f.t));
    let pushbacks = legs.iter().filter(|l| l.backward).count();
    let height = air.height.clone();
    let trajectory =
        Trajectory::new(start, end, legs, progress, height).ok_or(too_few(clean.fixes.len()))?;
    let report = Report {
        records: records.len(),
        used: residuals.rows.len(),
        tally: work.tally,
        longest_gap: gaps.0,
        gaps: gaps.1,
        stands: (stands.len(), stands.iter().map(Stand::duration_s).sum()),
        pushbacks,
        sigma_m: clean.sigma_m,
        across_m: residuals.summary(|r| r.across_m),
        along_m: residuals.summary(|r| r.along_m),
        altitude_offset_m: air.offset_m,
        liftoff_s: air.liftoff_s,
        touchdown_s: air.touchdown_s,
    };
    Ok((trajectory, report))
}

/// Longest gap with the line after it, and the number of gaps above 2 s.
fn gaps(clean: &Clean) -> Result<((f64, usize), usize), Refusal> {
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
struct Stand {
    from: usize,
    to: usize,
}

impl Stand {
    fn middle(&self) -> usize {
        (self.from + self.to) / 2
    }

    fn duration_s(&self) -> f64 {
        (self.to - self.from) as f64
    }
}

/// Times in which the rough track moves by less than 0.3 m/s over a window of four sigma (6 to 30 s).
fn stands(clean: &Clean) -> Vec<Stand> {
    const SLOW_MS: f64 = 0.3;
    let window_s = (4.0 * clean.sigma_m).clamp(6.0, 30.0);
    let reach_m = (2.0 * clean.sigma_m).max(2.5);
    let last = clean.rough.len() - 1;
    let at = |t: f64| on_track(&clean.rough, t);
    let still = |i: usize| {
        let from = (i as f64 - 0.5 * window_s).max(0.0);
        let to = (i as f64 + 0.5 * window_s).min(last as f64);
        (at(to) - at(from)).norm() < SLOW_MS * (to - from)
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
fn turns(clean: &Clean, stands: &[Stand]) -> Vec<usize> {
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
struct Roll {
    from: usize,
    to: usize,
    /// Largest speed in it, m/s.
    fastest_ms: f64,
}

/// Times on the runway at speed and in the air: other limits hold.
fn rolls(clean: &Clean, limits: &Limits) -> Vec<Roll> {
    let last = clean.rough.len() - 1;
    let speed = |i: usize| {
        let (a, b) = (i.saturating_sub(2), (i + 2).min(last));
        (clean.rough[b] - clean.rough[a]).norm() / (b - a).max(1) as f64
    };
    let mut rolls = Vec::new();
    let mut i = 0;
    while i <= last {
        if speed(i) <= 1.15 * limits.taxi_ms || limits.least_air_ms.is_infinite() {
            i += 1;
            continue;
        }
        let end = (i..=last).take_while(|j| speed(*j) > 1.15 * limits.taxi_ms).last().unwrap_or(i);
        let fastest = (i..=end).map(speed).fold(0.0, f64::max);
        if fastest > 0.6 * limits.least_air_ms {
            let from = (i.saturating_sub(40)..i).rev().find(|j| speed(*j) < 2.0);
            let to = (end..=last).find(|j| speed(*j) < 0.8 * limits.taxi_ms).unwrap_or(last);
            let from = from.unwrap_or(i.saturating_sub(40)).saturating_sub(2);
            // Slower at its end than at its begin: a landing.
            let lands = speed(end) < speed(i);
            let column_ms = if lands { limits.landing_ms } else { limits.takeoff_ms };
            let around = clean.fixes.iter().zip(&clean.speeds_ms);
            let within = around.filter(|(f, _)| f.t >= i as f64 && f.t <= end as f64);
            let steady_ms = within.map(|(_, v)| *v).filter(|v| v.is_finite()).fold(0.0, f64::max);
            rolls.push(Roll { from, to: to + 3, fastest_ms: column_ms.max(1.05 * steady_ms) });
        }
        i = end + 1;
    }
    rolls
}

#[derive(Clone, Debug, Default)]
struct Residuals {
    rows: Vec<Residual>,
}

#[derive(Clone, Copy, Debug)]
struct Residual {
    line: usize,
    across_m: f64,
    along_m: f64,
}

impl Residuals {
    fn summary(&self, value: fn(&Residual) -> f64) -> (f64, f64) {
        let squares: f64 = self.rows.iter().map(|r| value(r) * value(r)).sum();
        let largest = self.rows.iter().map(|r| value(r).abs()).fold(0.0, f64::max);
        ((squares / self.rows.len().max(1) as f64).sqrt(), largest)
    }

    /// The largest distance along the path, if more than one position in twenty is beyond `limit_m`.
    fn beyond(&self, limit_m: f64) -> Option<(f64, usize)> {
        let beyond = self.rows.iter().filter(|r| r.along_m.abs() > limit_m);
        let worst = beyond.clone().max_by(|a, b| a.along_m.abs().total_cmp(&b.along_m.abs()))?;
        (beyond.count() * 20 > self.rows.len()).then_some((worst.along_m.abs(), worst.line))
    }
}

struct Work<'a> {
    limits: &'a Limits,
    clean: &'a Clean,
    stands: &'a [Stand],
    rolls: &'a [Roll],
    tally: Tally,
}

impl Work<'_> {
    /// Path and controls of the progress of the leg from second `from` to second `to`.
    fn leg(
        &mut self,
        from: usize,
        to: usize,
        begin: Option<(Vector2<f64>, Vector2<f64>)>,
        last: bool,
        residuals: &mut Residuals,
    ) -> Option<(Spline<2>, Vec<[f64; 1]>)> {
        let path = self.path(from, to, begin)?;
        let table = PathTable::of(&path);
        let (low, high) = (from as f64, to as f64);
        let fixes: Vec<Fix> = self
            .clean
            .fixes
            .iter()
            .filter(|f| f.t >= low && (f.t < high || last))
            .copied()
            .collect();
        // Where the rough track is on the path, second by second, never backward.
        let mut places = Vec::with_capacity(to - from + 1);
        let mut place_m = if begin.is_some() { 0.0 } else { MARGIN_M };
        for i in from..=to {
            let near = table.nearest(self.clean.rough[i], place_m - 5.0, place_m + 150.0);
            place_m = near.0.max(place_m);
            places.push(place_m);
        }
        let mut seen = Vec::with_capacity(fixes.len());
        for fix in &fixes {
            let i = (fix.t as usize - from).min(places.len() - 1);
            let speed = places[(i + 1).min(places.len() - 1)] - places[i];
            let span = 30.0 + 4.0 * self.clean.sigma_m + 3.0 * speed;
            let (place, across_m) = table.nearest(fix.p, places[i] - span, places[i] + span);
            if across_m > 6.0 * self.clean.sigma_m + 5.0 {
                self.tally.add(Rule::BesidePath, fix.line);
            } else {
                seen.push((*fix, place, across_m));
            }
        }
        let begins_at = begin.map(|_| 0.0);
        let progress = self.progress(from, to, &table, &places, &seen, begins_at)?;
        let spline = Spline::new(low, 1.0, progress.clone())?;
        for (fix, place, across_m) in seen {
            let at = spline.at(fix.t);
            let sigma_m = self.sigma_along_m(at.first[0]);
            let along_m = place - at.value[0];
            if along_m.abs() > 4.0 * sigma_m {
                self.tally.add(Rule::OffTime, fix.line);
            }
            residuals.rows.push(Residual { line: fix.line, across_m, along_m });
        }
        Some((path, progress))
    }

    fn sigma_along_m(&self, speed_ms: f64) -> f64 {
        libm::hypot(self.clean.sigma_m, speed_ms * LATENESS_S)
    }

    /// Points that the path shall meet: the rough track, thinned, with each standstill one point.
    fn points(&self, from: usize, to: usize) -> Vec<(f64, Vector2<f64>)> {
        let step_m = (0.7 * self.clean.sigma_m).max(2.0);
        let mut points: Vec<(f64, Vector2<f64>)> = Vec::new();
        let mut quarter = 4 * from;
        while quarter <= 4 * to {
            let t = quarter as f64 * 0.25;
            quarter += 1;
            let here = on_track(&self.clean.rough, t);
            let second = t as usize;
            if self.stands.iter().any(|s| second > s.from && second < s.to) {
                continue;
            }
            if points.last().is_none_or(|(_, last)| (here - last).norm() >= step_m) {
                points.push((t, here));
            }
        }
        let reach_m = (5.0 * self.clean.sigma_m).max(25.0);
        let points = straightened(&points, reach_m, |t| self.is_slow(t));
        turned(&points, 1.25 * self.limits.least_radius_m)
    }

    /// Speed of the rough track over 4 s around `t`, m/s.
    fn rough_speed(&self, t: f64) -> f64 {
        let last = (self.clean.rough.len() - 1) as f64;
        let (a, b) = ((t - 2.0).max(0.0), (t + 2.0).min(last));
        let way = on_track(&self.clean.rough, b) - on_track(&self.clean.rough, a);
        way.norm() / (b - a).max(1.0)
    }

    /// True if the mover hardly goes on around `t`: what the track does there is wander.
    fn is_slow(&self, t: f64) -> bool {
        let next = self.clean.fixes.partition_point(|f| f.t < t);
        let speed = self.clean.speeds_ms[next.min(self.clean.fixes.len() - 1)];
        speed < 1.5
    }

    fn path(
        &self,
        from: usize,
        to: usize,
        begin: Option<(Vector2<f64>, Vector2<f64>)>,
    ) -> Option<Spline<2>> {
        let mut timed = self.points(from, to);
        if let Some((here, ahead)) = begin {
            timed.retain(|(_, p)| (p - here).dot(&ahead) > 0.0 || (p - here).norm() > 15.0);
            timed.insert(0, (from as f64, here));
        }
        if timed.len() < 2 {
            // Never moved: a line along the last known direction.
            let here = timed.first().map_or(self.clean.rough[from], |p| p.1);
            let ahead = begin.map_or(Vector2::new(0.0, 1.0), |b| b.1);
            timed = vec![(from as f64, here), (to as f64, here + ahead * 2.0)];
        }
        let points: Vec<Vector2<f64>> = timed.iter().map(|p| p.1).collect();
        let speeds: Vec<f64> = timed.iter().map(|p| self.rough_speed(p.0)).collect();
        let mut places = vec![if begin.is_some() { 0.0 } else { MARGIN_M }];
        for pair in points.windows(2) {
            places.push(places[places.len() - 1] + (pair[1] - pair[0]).norm());
        }
        let mut path = self.path_through(&points, &places, &speeds, begin)?;
        for _ in 0..3 {
            // Places by length along the path itself, so that its parameter is length.
            let table = PathTable::of(&path);
            places = points
                .iter()
                .zip(&places)
                .map(|(p, place)| table.nearest(*p, place - 20.0, place + 20.0).0)
                .map(|u| table.length_to(u))
                .collect();
            let shift = (if begin.is_some() { 0.0 } else { MARGIN_M }) - places[0];
            let mut least = 0.0;
            for place in &mut places {
                *place = (*place + shift).max(least);
                least = *place;
            }
            path = self.path_through(&points, &places, &speeds, begin)?;
        }
        Some(path)
    }

    /// Smooth path near points at given places, curvature within the limit.
    fn path_through(
        &self,
        points: &[Vector2<f64>],
        places: &[f64],
        speeds: &[f64],
        begin: Option<(Vector2<f64>, Vector2<f64>)>,
    ) -> Option<Spline<2>> {
        // Spectral density of the change of curvature along the path, 1/m³.
        const BEND_DENSITY: f64 = 1e-4;
        // Above this speed that density falls.
        const STEADY_MS: f64 = 12.0;
        let h = PATH_STEP_M;
        let pieces = ((places[places.len() - 1] + MARGIN_M) / h).ceil() as usize + 1;
        let sigma_m = (0.5 * self.clean.sigma_m).max(0.4);
        let mut controls: Vec<Control<2>> = Vec::with_capacity(pieces + 3);
        for j in 0..pieces + 3 {
            controls.push(match begin {
                Some((here, ahead)) if j < 3 => {
                    Control::Fixed((here + ahead * (h * (j as f64 - 1.0))).into())
                }
                Some(_) => Control::Free(j - 3),
                None => Control::Free(j),
            });
        }
        let data = points.iter().zip(places).map(|(p, place)| Datum {
            place: place / h,
            value: (*p).into(),
            weight: 1.0 / (sigma_m * sigma_m),
        });
        let radius = h * h / self.limits.least_radius_m;
        let bounds =
            (0..pieces + 1).map(|first| Bound { order: 2, first, centre: [0.0; 2], radius });
        let fit = Fit {
            controls,
            data: data.collect(),
            roughness: 1.0 / (h * h * h * h * h * BEND_DENSITY),
            stiffness: (0..pieces)
                .map(|piece| {
                    let next = places.partition_point(|place| *place < piece as f64 * h);
                    let speed = speeds[next.min(speeds.len() - 1)];
                    // Lateral jerk is v³ times the change of curvature: fast parts are straighter.
                    (speed / STEADY_MS).max(1.0).powi(4)
                })
                .collect(),
            bounds: bounds.collect(),
        };
        // The bound holds where the parameter is length. Where wander bunches it, stiffen the path.
        let mut fit = fit;
        let mut path = Spline::new(0.0, h, fit.bounded()?)?;
        for _ in 0..6 {
            let bad = PathTable::of(&path).undrivable_m(self.limits.least_radius_m);
            if bad.is_empty() {
                break;
            }
            let mut stiffer = vec![false; pieces];
            for place_m in bad {
                let piece = (place_m / h) as usize;
                let (low, high) = (piece.saturating_sub(6), (piece + 6).min(pieces));
                stiffer[low.min(high)..high].fill(true);
            }
            let factors = fit.stiffness.iter_mut().zip(stiffer);
            factors.filter(|(_, s)| *s).for_each(|(factor, _)| *factor *= 5.0);
            path = Spline::new(0.0, h, fit.bounded()?)?;
        }
        Some(path)
    }

    /// Controls of the progress, second by second, within the limits.
    fn progress(
        &self,
        from: usize,
        to: usize,
        table: &PathTable,
        places: &[f64],
        seen: &[(Fix, f64, f64)],
        begins_at: Option<f64>,
    ) -> Option<Vec<[f64; 1]>> {
        let pieces = (to - from).max(1);
        let count = pieces + 3;
        // Controls within a standstill are one variable; before a fixed begin they do not move.
        let mut joined = vec![false; count];
        for stand in self.stands {
            let (a, b) = (stand.from.max(from), stand.to.min(to));
            if b > a + 1 {
                joined[a - from + 1..(b - from + 3).min(count)].fill(true);
            }
        }
        let mut controls = Vec::with_capacity(count);
        let mut next = 0;
        let mut fixed = begins_at;
        for (j, same) in joined.iter().enumerate() {
            if j > 0 && !same && fixed.take().is_none() {
                next += 1;
            }
            controls.push(fixed.map_or(Control::Free(next), |m| Control::Fixed([m])));
        }
        let mut solution: Option<Spline<1>> = None;
        for round in 0..6 {
            let data: Vec<Datum<1>> = seen
                .iter()
                .map(|(fix, place, _)| {
                    let (error, speed) = match &solution {
                        Some(spline) => {
                            let jet = spline.at(fix.t - from as f64);
                            (place - jet.value[0], jet.first[0])
                        }
                        None => {
                            let i = ((fix.t as usize).max(from) - from).min(places.len() - 1);
                            (place - places[i], places[(i + 1).min(places.len() - 1)] - places[i])
                        }
                    };
                    let sigma = self.sigma_along_m(speed);
                    let ratio2 = error * error / (sigma * sigma);
                    let weight = 1.0 / (sigma * sigma * (1.0 + 0.25 * ratio2));
                    Datum { place: fix.t - from as f64, value: [*place], weight }
                })
                .collect();
            let data = if data.is_empty() {
                let stay = Datum { place: 0.0, value: [places[0]], weight: 1.0 };
                vec![stay]
            } else {
                data
            };
            let bounds = self.progress_bounds(from, count, table, solution.as_ref());
            let fit = Fit {
                controls: controls.clone(),
                data,
                roughness: 1.0 / JERK_DENSITY,
                stiffness: Vec::new(),
                bounds,
            };
            let found = fit.bounded()?;
            solution = Spline::new(0.0, 1.0, found);
            solution.as_ref()?;
            if round >= 3 && self.lateral_excess(from, table, solution.as_ref()?) <= 1.0 {
                break;
            }
        }
        let mut controls = solution?.controls().to_vec();
        // A leg that stands at its end stands exactly.
        for j in 1..count {
            controls[j][0] = controls[j][0].max(controls[j - 1][0]);
        }
        Some(controls)
    }

    /// The run or flight that second `t` of the whole recording belongs to.
    fn roll(&self, t: usize) -> Option<&Roll> {
        self.rolls.iter().find(|roll| (roll.from..=roll.to).contains(&t))
    }

    fn progress_bounds(
        &self,
        from: usize,
        count: usize,
        table: &PathTable,
        before: Option<&Spline<1>>,
    ) -> Vec<Bound<1>> {
        let limits = self.limits;
        let mut bounds = Vec::with_capacity(3 * count);
        for j in 0..count {
            // The difference of order k at j bears on the pieces j − 3 + k to j.
            let roll = |k: usize| {
                let low = (j + k).saturating_sub(3);
                (low..=j + 1).find_map(|piece| self.roll(from + piece))
            };
            if j + 1 < count {
                let mut fastest = roll(1).map_or(limits.taxi_ms, |r| r.fastest_ms);
                if let Some(spline) = before {
                    let (low, high) = ((j as f64 - 3.0).max(0.0), j as f64 + 2.0);
                    let (a, b) = (spline.at(low).value[0] - 2.0, spline.at(high).value[0] + 2.0);
                    let bend = table.sharpest(a, b).max(1e-9);
                    fastest = fastest.min((self.lateral_ms2(fastest) / bend).sqrt());
                }
                // The parameter of the path is length within some percent: keep clear.
                bounds.push(Bound::between(1, j, 0.0, 0.98 * fastest.max(0.5)));
            }
            if j + 2 < count {
                let (acc, dec) = if roll(2).is_some() {
                    (limits.roll_acc_ms2, limits.roll_dec_ms2)
                } else {
                    (limits.taxi_acc_ms2, limits.taxi_dec_ms2)
                };
                bounds.push(Bound::between(2, j, -0.98 * dec, 0.98 * acc));
            }
            if j + 3 < count {
                let jerk = if roll(3).is_some() { limits.roll_jerk_ms3 } else { limits.jerk_ms3 };
                bounds.push(Bound::between(3, j, -jerk, jerk));
            }
        }
        bounds
    }

    /// Lateral acceleration allowed at a speed: above taxi speeds with some room for turns in the air.
    fn lateral_ms2(&self, speed_ms: f64) -> f64 {
        if speed_ms > self.limits.least_air_ms { AIR_LATERAL_MS2 } else { self.limits.lateral_ms2 }
    }

    /// Largest lateral acceleration over its limit.
    fn lateral_excess(&self, _from: usize, table: &PathTable, progress: &Spline<1>) -> f64 {
        let mut worst = 0.0_f64;
        let mut t = progress.start();
        while t <= progress.end() {
            let jet = progress.at(t);
            let speed = jet.first[0];
            let bend = table.sharpest(jet.value[0] - 1.0, jet.value[0] + 1.0);
            worst = worst.max(speed * speed * bend / self.lateral_ms2(speed));
            t += 0.25;
        }
        worst
    }
}

/// Takes detours out of slow phases: from each point the farthest one within `reach_m` that is reached
/// by a line much longer than straight, all of it slow, comes next.
fn straightened(
    points: &[(f64, Vector2<f64>)],
    reach_m: f64,
    is_slow: impl Fn(f64) -> bool,
) -> Vec<(f64, Vector2<f64>)> {
    let mut kept: Vec<(f64, Vector2<f64>)> = Vec::with_capacity(points.len());
    let mut i = 0;
    while i < points.len() {
        kept.push(points[i]);
        let mut next = i + 1;
        let mut length_m = 0.0;
        for j in i + 1..points.len() {
            if !is_slow(points[j].0) {
                break;
            }
            length_m += (points[j].1 - points[j - 1].1).norm();
            let straight_m = (points[j].1 - points[i].1).norm();
            if straight_m < reach_m && length_m > 1.3 * straight_m + 2.0 {
                next = j;
            }
        }
        i = next;
    }
    // The last step of a detour may be no step at all.
    kept.dedup_by(|b, a| (b.1 - a.1).norm() < 1.0);
    kept
}

/// Replaces what turns sharper than `radius_m` by the shortest way that does not.
pub(super) fn turned(timed: &[(f64, Vector2<f64>)], radius_m: f64) -> Vec<(f64, Vector2<f64>)> {
    const WINDOW_M: f64 = 24.0;
    const STEP_M: f64 = 2.0;
    let count = timed.len();
    if count < 4 {
        return timed.to_vec();
    }
    let points: Vec<Vector2<f64>> = timed.iter().map(|p| p.1).collect();
    let mut places = vec![0.0];
    for pair in points.windows(2) {
        places.push(places[places.len() - 1] + (pair[1] - pair[0]).norm());
    }
    // Direction over some metres around a point, looking back or ahead.
    let ahead_of = |i: usize, forward: bool| {
        let other = if forward {
            (i + 1..count).find(|j| places[*j] - places[i] >= 6.0).unwrap_or(count - 1)
        } else {
            (0..i).rev().find(|j| places[i] - places[*j] >= 6.0).unwrap_or(0)
        };
        let along = if forward { points[other] - points[i] } else { points[i] - points[other] };
        along.try_normalize(1e-9).unwrap_or(Vector2::new(1.0, 0.0))
    };
    // Sharp: within the window the direction changes by an arc of the radius and half a radian more.
    let sharp: Vec<usize> = (1..count - 1)
        .filter(|i| {
            [4.0, 8.0, 16.0, WINDOW_M].iter().any(|window_m| {
                let to = (*i..count).take_while(|j| places[*j] - places[*i] <= *window_m).last();
                let to = to.unwrap_or(*i).min(count - 2);
                let (u, v) = (ahead_of(*i, false), ahead_of(to.max(*i), true));
                let change = libm::atan2(u.x * v.y - u.y * v.x, u.dot(&v)).abs();
                change > (places[to.max(*i)] - places[*i] + 6.0) / radius_m + 0.5
            })
        })
        .collect();
    let mut result = Vec::with_capacity(count);
    let mut i = 0;
    let mut next_sharp = 0;
    while i < count {
        result.push(timed[i]);
        while next_sharp < sharp.len() && sharp[next_sharp] < i {
            next_sharp += 1;
        }
        let near = sharp.get(next_sharp).filter(|s| places[**s] - places[i] <= 0.5 * WINDOW_M);
        let Some(first) = near.copied() else {
            i += 1;
            continue;
        };
        // The end of this cluster of sharp places.
        let mut last = first;
        for s in &sharp[next_sharp..] {
            if places[*s] - places[last] <= WINDOW_M {
                last = *s;
            }
        }
        let beyond = |j: &usize| places[*j] - places[last] >= 1.5 * WINDOW_M;
        let end = (last..count).find(beyond).unwrap_or(count - 1);
        let from = Pose { place: points[i], ahead: ahead_of(i, false) };
        let from = if i == 0 { Pose { ahead: ahead_of(0, true), ..from } } else { from };
        let to = Pose { place: points[end], ahead: ahead_of(end, end + 1 < count) };
        let way = dubins::connect(from, to, radius_m, STEP_M);
        let inner = way.len() - 1;
        let span_s = timed[end].0 - timed[i].0;
        for (k, point) in way.iter().enumerate().take(inner).skip(1) {
            result.push((timed[i].0 + span_s * k as f64 / inner as f64, *point));
        }
        i = end;
        while next_sharp < sharp.len() && sharp[next_sharp] <= end {
            next_sharp += 1;
        }
    }
    result
}

/// Spectral density of the change of acceleration along the path, m²/s⁵.
const JERK_DENSITY: f64 = 0.05;

/// A path sampled every half metre.
struct PathTable {
    points: Vec<Vector2<f64>>,
    /// Curvature, 1/m.
    bends: Vec<f64>,
    /// Length from the begin, m.
    lengths: Vec<f64>,
}

const TABLE_STEP_M: f64 = 0.5;

impl PathTable {
    fn of(path: &Spline<2>) -> Self {
        let count = ((path.end() - path.start()) / TABLE_STEP_M) as usize + 1;
        let mut table = Self { points: Vec::new(), bends: Vec::new(), lengths: Vec::new() };
        for i in 0..count {
            let jet = path.at(path.start() + i as f64 * TABLE_STEP_M);
            let (d, dd) = (jet.first, jet.second);
            let speed2 = d[0] * d[0] + d[1] * d[1];
            let bend = (d[0] * dd[1] - d[1] * dd[0]).abs() / (speed2 * speed2.sqrt()).max(1e-6);
            let point = Vector2::from(jet.value);
            let length = table.points.last().map_or(0.0, |p: &Vector2<f64>| (point - p).norm());
            table.lengths.push(table.lengths.last().copied().unwrap_or(0.0) + length);
            table.points.push(point);
            table.bends.push(bend);
        }
        table
    }

    fn range(&self, from_m: f64, to_m: f64) -> std::ops::Range<usize> {
        let last = self.points.len() - 1;
        let index = |m: f64| ((m / TABLE_STEP_M).max(0.0) as usize).min(last);
        index(from_m)..index(to_m) + 1
    }

    /// Place of the nearest point between two places, and its distance.
    fn nearest(&self, p: Vector2<f64>, from_m: f64, to_m: f64) -> (f64, f64) {
        let range = self.range(from_m, to_m);
        let best = range
            .map(|i| (i, (self.points[i] - p).norm_squared()))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map_or((0, 0.0), |b| b);
        let i = best.0;
        // Between the samples: the foot on the line of the neighbours.
        let (a, b) = (i.saturating_sub(1), (i + 1).min(self.points.len() - 1));
        let along = self.points[b] - self.points[a];
        let share = if along.norm_squared() > 0.0 {
            ((p - self.points[a]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let place = (a as f64 + share * (b - a) as f64) * TABLE_STEP_M;
        (place, (self.points[a] + along * share - p).norm())
    }

    /// Places that bend a quarter more than 1 / `radius_m`, or where the parameter is not length
    /// within a tenth.
    fn undrivable_m(&self, radius_m: f64) -> Vec<f64> {
        let stretched = |i: usize| {
            let step = if i == 0 { TABLE_STEP_M } else { self.lengths[i] - self.lengths[i - 1] };
            (step / TABLE_STEP_M - 1.0).abs() > 0.1
        };
        let bad =
            (0..self.bends.len()).filter(|i| self.bends[*i] * radius_m > 1.25 || stretched(*i));
        bad.map(|i| i as f64 * TABLE_STEP_M).collect()
    }

    fn sharpest(&self, from_m: f64, to_m: f64) -> f64 {
        self.bends[self.range(from_m, to_m)].iter().copied().fold(0.0, f64::max)
    }

    fn length_to(&self, place_m: f64) -> f64 {
        let place = (place_m / TABLE_STEP_M).clamp(0.0, (self.points.len() - 1) as f64);
        let i = (place as usize).min(self.points.len().saturating_sub(2));
        let next = self.lengths[(i + 1).min(self.lengths.len() - 1)];
        self.lengths[i] + (next - self.lengths[i]) * (place - i as f64)
    }
}

/// Height and the times at which the wheels leave and touch the ground.
struct Air {
    height: Option<Spline<1>>,
    offset_m: Option<f64>,
    liftoff_s: Option<f64>,
    touchdown_s: Option<f64>,
}

impl Air {
    /// Steepest climb and sink, m/s; largest vertical acceleration, m/s².
    const CLIMB_MS: f64 = 30.0;
    const VERTICAL_MS2: f64 = 2.5;
    /// Height below which the wheels may be on the ground: one step of the altitude code, m.
    const STEP_M: f64 = 7.62;

    fn of(
        records: &[Record],
        t0_ms: i64,
        progress: &Spline<1>,
        limits: &Limits,
        tally: &mut Tally,
    ) -> Self {
        let none = Self { height: None, offset_m: None, liftoff_s: None, touchdown_s: None };
        let end = progress.end();
        let time = |r: &Record| r.time_ms.map(|ms| ms.saturating_sub(t0_ms) as f64 * 1e-3);
        let speed = |t: f64| progress.at(t).first[0];
        let slow = |t: f64| speed(t) < 0.5 * limits.least_air_ms;
        let mut altitudes: Vec<(usize, f64, f64)> = Vec::new();
        let mut on_ground = Vec::new();
        for record in records {
            let (Some(t), Some(altitude_m)) = (time(record), record.altitude_m) else { continue };
            if !(0.0..=end).contains(&t) {
                continue;
            }
            if slow(t) && altitude_m.abs() > 300.0 {
                tally.add(Rule::AltitudeSpike, record.line);
                continue;
            }
            if slow(t) {
                on_ground.push(altitude_m);
            }
            altitudes.push((record.line, t, altitude_m));
        }
        let offset_m = median(on_ground);
        if limits.least_air_ms.is_infinite() {
            return Self { offset_m, ..none };
        }
        let offset = offset_m.unwrap_or(0.0);
        let heights = flyable(&altitudes, offset, tally);
        let pieces = progress.controls().len() - 3;
        // In the air: fast enough, and above one step of the altitude code around it.
        let high_near = |t: f64| {
            let near = heights.iter().filter(|(ht, _)| (ht - t).abs() <= 4.0);
            let (count, high) = near
                .fold((0, 0), |(n, h), (_, z)| (n + 1, h + usize::from(*z > 1.5 * Self::STEP_M)));
            (count, high)
        };
        let mut flying: Vec<bool> = (0..=pieces)
            .map(|i| {
                let t = i as f64;
                if speed(t) < limits.least_air_ms {
                    return false;
                }
                let (count, high) = high_near(t);
                if count == 0 { speed(t) > 1.1 * limits.least_air_ms } else { 2 * high > count }
            })
            .collect();
        drop_short_runs(&mut flying, true, 5);
        drop_short_runs(&mut flying, false, 5);
        for record in records {
            let (Some(t), Some(flag)) = (time(record), record.on_ground) else { continue };
            if !(0.0..=end).contains(&t) {
                continue;
            }
            let i = t as usize;
            let (before, after) = (i.saturating_sub(3), (i + 3).min(pieces));
            if i <= pieces && flying[before] == flying[after] && flag == flying[i] {
                tally.add(Rule::GroundFlag, record.line);
            }
        }
        if !flying.iter().any(|f| *f) {
            return Self { offset_m, ..none };
        }
        Self::fitted(&flying, &heights, offset_m, pieces)
    }

    fn fitted(
        flying: &[bool],
        heights: &[(f64, f64)],
        offset_m: Option<f64>,
        pieces: usize,
    ) -> Self {
        // A piece flies if both its ends do; a control is free if any of its four pieces flies.
        let flies = |piece: usize| flying[piece] && flying[piece + 1];
        let mut next = 0;
        let mut controls = Vec::with_capacity(pieces + 3);
        for j in 0..pieces + 3 {
            let (low, high) = (j.saturating_sub(3), j.min(pieces - 1));
            if (low..=high).all(flies) {
                controls.push(Control::Free(next));
                next += 1;
            } else {
                controls.push(Control::Fixed([0.0]));
            }
        }
        let switch =
            |from: bool| (1..flying.len()).find(|i| flying[i - 1] == from && flying[*i] != from);
        let (liftoff_s, touchdown_s) =
            (switch(false).map(|i| i as f64), switch(true).map(|i| i as f64));
        let none = Self { height: None, offset_m, liftoff_s, touchdown_s };
        let weight = 1.0 / (0.5 * Self::STEP_M * Self::STEP_M);
        let seen = |t: f64| flying[(t as usize).min(flying.len() - 1)];
        let data: Vec<Datum<1>> = heights
            .iter()
            .filter(|(t, _)| seen(*t))
            .map(|(t, z)| Datum { place: *t, value: [z.max(0.0)], weight })
            .collect();
        if data.len() < 2 || next < 4 {
            return none;
        }
        let mut bounds = Vec::new();
        for j in 0..pieces + 3 {
            bounds.push(Bound::between(0, j, -1e-6, 20_000.0));
            if j + 1 < pieces + 3 {
                bounds.push(Bound::between(1, j, -Self::CLIMB_MS, Self::CLIMB_MS));
            }
            if j + 2 < pieces + 3 {
                bounds.push(Bound::between(2, j, -Self::VERTICAL_MS2, Self::VERTICAL_MS2));
            }
        }
        let roughness = 1.0 / 0.02;
        let fit = Fit { controls, data, roughness, stiffness: Vec::new(), bounds };
        let height = fit.bounded().and_then(|found| {
            let floor = found.into_iter().map(|[z]| [z.max(0.0)]).collect();
            Spline::new(0.0, 1.0, floor)
        });
        Self { height, ..none }
    }
}

/// Flips runs of `value` of fewer than `least` elements.
fn drop_short_runs(flags: &mut [bool], value: bool, least: usize) {
    let mut i = 0;
    while i < flags.len() {
        let run = flags[i..].iter().take_while(|f| **f == value).count();
        if run > 0 && run < least {
            flags[i..i + run].fill(!value);
        }
        i += run.max(1);
    }
}

/// Heights that can be flown one after the other: the longest chain with at most 30 m/s and 25 m.
fn flyable(altitudes: &[(usize, f64, f64)], offset_m: f64, tally: &mut Tally) -> Vec<(f64, f64)> {
    const LOOK_BACK: usize = 60;
    let mut best: Vec<(usize, Option<usize>)> = Vec::with_capacity(altitudes.len());
    for (j, (_, tb, zb)) in altitudes.iter().enumerate() {
        let mut link = (1, None);
        for i in (j.saturating_sub(LOOK_BACK)..j).rev() {
            let (_, ta, za) = altitudes[i];
            if (zb - za).abs() <= 30.0 * (tb - ta) + 25.0 && best[i].0 + 1 > link.0 {
                link = (best[i].0 + 1, Some(i));
            }
        }
        best.push(link);
    }
    let mut at = (0..altitudes.len()).max_by_key(|i| (best[*i].0, std::cmp::Reverse(*i)));
    let mut keep = vec![false; altitudes.len()];
    while let Some(i) = at {
        keep[i] = true;
        at = best[i].1;
    }
    let mut heights = Vec::new();
    for ((line, t, z), keep) in altitudes.iter().zip(keep) {
        if keep {
            heights.push((*t, z - offset_m));
        } else {
            tally.add(Rule::AltitudeSpike, *line);
        }
    }
    heights
}

#[cfg(test)]
mod tests;
