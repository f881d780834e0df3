//! A sound truth from a recorded movement, step by step:
//!
//! ```text
//! reject      positions that cannot be true
//! phases      standstills, turns back on the track (legs; the first of two is driven backward), runs
//! centreline  positions of a run are drawn across towards the centreline of its runway
//! path        of each leg: smooth, with a limited curvature
//! progress    along it: the function of time nearest to the positions within the limits of the type
//! air         height: zero on the ground, the reported altitude less its offset on the ground above it
//! report      what was done, by rule and number
//! ```

mod air;
mod centreline;
mod path;
mod phases;
mod progress;
mod reject;
mod report;

pub(super) use path::turned;
pub use report::{Held, Holding, Refusal, Report, Rule, Tally};

use super::limits::Limits;
use super::spline::{Jet, Spline};
use super::trajectory::{Leg, Trajectory};
use crate::airport::Runway;
use crate::frames::{Point2, Vector2};
use crate::time::SimTime;
use air::Air;
use path::{BEGIN_M, PathTable};
use phases::{Roll, Stand};
use progress::Seen;
use reject::{Clean, Fix, LATENESS_S};
use std::collections::BTreeMap;

/// One line of a recording. What is missing or damaged in the file is `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// Line in the file.
    pub line: usize,
    /// UTC, milliseconds.
    pub time_ms: Option<i64>,
    /// East and north, m.
    pub position_m: Option<Point2<f64>>,
    /// Pressure altitude over the field elevation, m.
    pub altitude_m: Option<f64>,
    /// What the transponder said.
    pub on_ground: Option<bool>,
}

/// Longest movement, s.
const LONGEST_S: f64 = 4.0 * 3600.0;
/// Longest way, m.
const LONGEST_M: f64 = 100_000.0;
/// Largest distance along the path that smoothing may leave (95 % of positions), m; in runs the way
/// that the type cannot follow comes on top.
const FARTHEST_M: f64 = 150.0;
/// A sound truth from records in the order of the file; it begins at `start`.
///
/// # Errors
/// If too little of the recording can be true, see [`Refusal`].
pub fn import(
    records: &[Record],
    limits: &Limits,
    runways: &[Runway],
    start: SimTime,
) -> Result<(Trajectory, Report), Refusal> {
    let mut tally = Tally::default();
    let last_line = records.last().map_or(1, |r| r.line);
    let refused = |left, why: String| {
        let records = records.len();
        Refusal::TooFew { line: last_line, left, records, why }
    };
    let clean = reject::clean(records, 2.2 * limits.takeoff_mps, LONGEST_S, &mut tally);
    let mut clean = clean.ok_or_else(|| refused(0, tally.most()))?;
    let positions = clean.fixes.len();
    let span_s = clean.fixes.last().map_or(0.0, |f| f.t);
    if span_s > LONGEST_S {
        return Err(Refusal::TooLong { line: last_line, span_s, limit_s: LONGEST_S });
    }
    if positions < 10 || positions * 8 < records.len() - tally.count(Rule::TooOften) {
        return Err(refused(positions, tally.most()));
    }
    let way_m = clean.rough.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    if way_m > LONGEST_M {
        return Err(Refusal::TooFar { line: last_line, way_m, limit_m: LONGEST_M });
    }
    let first_line = clean.fixes[0].line;
    let no_fit = |what| Refusal::NoFit { line: last_line, from: first_line, what };
    let gaps = phases::gaps(&clean)?;
    let stands = phases::stands(&clean);
    let rolls = phases::rolls(&clean, limits);
    let stands = phases::shortened(stands, &rolls);
    let turns = phases::turns(&clean, &stands);
    let air = Air::seen(records, &clean, limits, &mut tally);
    let centred_m = centreline::centred(&mut clean, &rolls, runways, &mut tally);
    let mut work = Work { limits, clean: &clean, stands: &stands, rolls: &rolls, air, tally };
    // Legs by time: from a turn to the next, in whole seconds.
    let mut bounds: Vec<usize> = turns.iter().map(|i| stands[*i].middle()).collect();
    bounds.insert(0, 0);
    bounds.push(clean.last_s());
    let mut legs: Vec<Leg> = Vec::new();
    let mut controls: Vec<[f64; 1]> = Vec::new();
    let mut residuals = Residuals::default();
    let mut from_m = 0.0;
    for (index, span) in bounds.windows(2).enumerate() {
        let begin = legs.last().map(|leg: &Leg| {
            let end = leg.path.at(from_m - leg.from_m);
            let tangent = -Vector2::from(end.first).normalize();
            (Point2::from(end.value), tangent)
        });
        let last = index + 2 == bounds.len();
        let (path, progress) = work.leg(span[0], span[1], begin, last, &mut residuals)?;
        let end_m = progress[progress.len() - 1][0];
        controls.truncate(span[0]);
        controls.extend(progress.iter().map(|c| [c[0] + from_m]));
        let backward = (bounds.len() - 2 - index) % 2 == 1;
        legs.push(Leg { from_m, path, backward });
        from_m += end_m;
    }
    let progress = Spline::new(0.0, 1.0, controls).ok_or(no_fit("progress"))?;
    if residuals.rows.len() * 2 < positions {
        // Most positions lie beside every path that the type can take.
        let off_m = residuals.rows.iter().map(|r| r.across_m).fold(0.0, f64::max);
        return Err(Refusal::BeyondType { line: last_line, off_m });
    }
    if let Some((off_m, line)) = residuals.beyond() {
        return Err(Refusal::BeyondType { line, off_m });
    }
    work.air.settle(&progress, limits);
    let end = start.plus_s(span_s);
    let report = Report {
        records: records.len(),
        used: residuals.rows.len(),
        longest_gap: gaps.0,
        gaps: gaps.1,
        stands: (stands.len(), stands.iter().map(Stand::duration_s).sum()),
        pushbacks: legs.iter().filter(|l| l.backward).count(),
        sigma_m: clean.sigma_m,
        across_m: residuals.summary(|r| r.across_m),
        along_m: residuals.summary(|r| r.along_m),
        held: work.held(&legs, &progress, &residuals),
        centred_m,
        altitude_offset_m: work.air.offset_m,
        liftoff_s: work.air.liftoff_s(),
        touchdown_s: work.air.touchdown_s(),
        tally: work.tally,
    };
    let height = work.air.height();
    let trajectory = Trajectory::new(start, end, legs, progress, height);
    Ok((trajectory.ok_or(no_fit("path"))?, report))
}

/// Motion along a path, SI units.
struct Motion {
    speed_mps: f64,
    along_ms2: f64,
    lateral_ms2: f64,
}

/// `v = |p'| ṡ`, `a = p'' ṡ² + p' s̈`, split along and across `p'`.
fn motion(path: &Spline<2>, progress: &Jet<1>) -> Motion {
    let (s, ds, dds) = (progress.value[0], progress.first[0], progress.second[0]);
    let jet = path.at(s);
    let (first, second) = (Vector2::from(jet.first), Vector2::from(jet.second));
    let length = first.norm();
    let ahead = first / length.max(1e-9);
    let bend = second * (ds * ds);
    Motion {
        speed_mps: length * ds,
        along_ms2: bend.dot(&ahead) + length * dds,
        lateral_ms2: (bend.x * ahead.y - bend.y * ahead.x).abs(),
    }
}

#[derive(Clone, Debug, Default)]
struct Residuals {
    rows: Vec<Residual>,
}

#[derive(Clone, Copy, Debug)]
struct Residual {
    line: usize,
    t: f64,
    across_m: f64,
    along_m: f64,
    /// How far it may be along the path, m.
    room_m: f64,
}

impl Residuals {
    fn summary(&self, value: fn(&Residual) -> f64) -> (f64, f64) {
        let squares: f64 = self.rows.iter().map(|r| value(r) * value(r)).sum();
        let largest = self.rows.iter().map(|r| value(r).abs()).fold(0.0, f64::max);
        ((squares / self.rows.len().max(1) as f64).sqrt(), largest)
    }

    /// The largest distance along the path, if more than one position in twenty is too far.
    fn beyond(&self) -> Option<(f64, usize)> {
        let beyond = self.rows.iter().filter(|r| r.along_m.abs() > r.room_m);
        let worst = beyond.clone().max_by(|a, b| a.along_m.abs().total_cmp(&b.along_m.abs()))?;
        (beyond.count() * 20 > self.rows.len()).then_some((worst.along_m.abs(), worst.line))
    }
}

struct Work<'a> {
    limits: &'a Limits,
    clean: &'a Clean,
    stands: &'a [Stand],
    rolls: &'a [Roll],
    air: Air,
    tally: Tally,
}

impl Work<'_> {
    /// Path and controls of the progress of the leg from second `from` to second `to`.
    fn leg(
        &mut self,
        from: usize,
        to: usize,
        begin: Option<(Point2<f64>, Vector2<f64>)>,
        last: bool,
        residuals: &mut Residuals,
    ) -> Result<(Spline<2>, Vec<[f64; 1]>), Refusal> {
        let no_fit = |what| {
            let within = self.clean.fixes.iter().filter(|f| (from..=to).contains(&(f.t as usize)));
            let mut lines = within.map(|f| f.line);
            let first = lines.next().unwrap_or(self.clean.fixes[0].line);
            Refusal::NoFit { line: lines.next_back().unwrap_or(first), from: first, what }
        };
        let path = self.path(from, to, begin).ok_or_else(|| no_fit("path"))?;
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
        let mut place_m = if begin.is_some() { 0.0 } else { BEGIN_M };
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
        let progress = self.progress(&Seen {
            span: (from, to),
            path: &path,
            table: &table,
            places: &places,
            fixes: &seen,
            begins_at: begin.map(|_| 0.0),
        });
        let spline = progress.and_then(|controls| Spline::new(low, 1.0, controls));
        let spline = spline.ok_or_else(|| no_fit("progress"))?;
        for (fix, place, across_m) in seen {
            let at = spline.at(fix.t);
            let sigma_m = self.sigma_along_m(fix.t, at.first[0]);
            let along_m = place - at.value[0];
            if along_m.abs() > 4.0 * sigma_m {
                self.tally.add(Rule::OffTime, fix.line);
            }
            let room_m = FARTHEST_M + self.roll(fix.t as usize).map_or(0.0, |r| r.mismatch_m);
            residuals.rows.push(Residual { line: fix.line, t: fix.t, across_m, along_m, room_m });
        }
        Ok((path, spline.controls().to_vec()))
    }

    /// Error of a position along the path, m; in a run the way that the type cannot follow, too.
    fn sigma_along_m(&self, t: f64, speed_mps: f64) -> f64 {
        let roll = self.roll(t as usize);
        let mismatch_m = roll.map_or(0.0, |roll| roll.mismatch_m);
        let own_m = libm::hypot(self.clean.sigma_m, speed_mps * LATENESS_S);
        libm::hypot(own_m, mismatch_m)
    }

    /// Where the truth is at a limit of the type and the recording is beyond it.
    fn held(&self, legs: &[Leg], progress: &Spline<1>, residuals: &Residuals) -> Vec<Holding> {
        const AT_IT: f64 = 0.94;
        const HALF_S: f64 = 5.0;
        let mut found: BTreeMap<Held, Holding> = BTreeMap::new();
        for i in 0..self.clean.last_s() {
            let t = i as f64 + 0.5;
            let jet = progress.at(t);
            let leg = &legs[legs.partition_point(|l| l.from_m < jet.value[0]).max(1) - 1];
            let mut within = jet;
            within.value[0] -= leg.from_m;
            let now = motion(&leg.path, &within);
            let allowed = self.allowed(i);
            let speed = self.clean.speed(t);
            let gain =
                (self.clean.speed(t + HALF_S) - self.clean.speed(t - HALF_S)) / (2.0 * HALF_S);
            // Turns are shaped by the path, the type's own radius included: no contradiction there.
            for ((limit, rule), truth, recorded) in [
                (allowed.speed, now.speed_mps, if allowed.flies { 0.0 } else { speed }),
                (allowed.acceleration, now.along_ms2, gain),
                (allowed.braking, -now.along_ms2, -gain),
            ] {
                if truth < AT_IT * limit || recorded <= limit {
                    continue;
                }
                let near = residuals.rows.iter().filter(|r| (r.t - t).abs() <= 1.0);
                let along_m = near.map(|r| r.along_m.abs()).fold(0.0, f64::max);
                let none =
                    Holding { limit: rule, value: limit, duration_s: 0.0, recorded, along_m };
                let holding = found.entry(rule).or_insert(none);
                holding.duration_s += 1.0;
                holding.recorded = holding.recorded.max(recorded);
                holding.along_m = holding.along_m.max(along_m);
            }
        }
        found.into_values().collect()
    }
}

#[cfg(test)]
mod tests;
