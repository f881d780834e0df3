//! Which recorded positions cannot be true.
//!
//! Position reports of real transponders repeat a position that was not renewed, come late, or are
//! decoded wrongly. The rules here look at positions and times only; ground speed and track are not
//! used, because they may be held at their last airborne value.

use super::super::fit::{Control, Datum, Fit};
use super::{Record, Rule, Tally};
use crate::frames::{Point2, Vector2};

/// Positions that are left, with times in seconds since the first of them.
#[derive(Clone, Debug)]
pub(super) struct Clean {
    pub(super) fixes: Vec<Fix>,
    /// Time 0: that of the first position.
    pub(super) t0_ms: i64,
    /// Typical error of a position across the track, m.
    pub(super) sigma_m: f64,
    /// Smoothed track at whole seconds.
    pub(super) rough: Vec<Point2<f64>>,
    /// Typical speed around each fix, m/s.
    pub(super) speeds_mps: Vec<f64>,
}

impl Clean {
    /// Last whole second of the track.
    pub(super) fn last_s(&self) -> usize {
        self.rough.len() - 1
    }

    /// Velocity of the smoothed track over 4 s around `t`, m/s.
    pub(super) fn velocity(&self, t: f64) -> Vector2<f64> {
        let (a, b) = ((t - 2.0).max(0.0), (t + 2.0).min(self.last_s() as f64));
        (on_track(&self.rough, b) - on_track(&self.rough, a)) / (b - a).max(1.0)
    }

    /// Its amount.
    pub(super) fn speed(&self, t: f64) -> f64 {
        self.velocity(t).norm()
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Fix {
    pub(super) line: usize,
    pub(super) t: f64,
    pub(super) p: Point2<f64>,
}

/// Positions are late by up to about this, s: an error along the track that grows with speed.
pub(super) const LATENESS_S: f64 = 0.7;
/// In so short a time errors of positions make a speed, s.
const SHORT_S: f64 = 5.0;
/// Smoothing of the rough track: spectral density of the jerk, m²/s⁵.
const JERK_DENSITY: f64 = 0.05;

/// Applies the rules; `None` if hardly anything is left.
pub(super) fn clean(
    records: &[Record],
    fastest_mps: f64,
    span_s: f64,
    tally: &mut Tally,
) -> Option<Clean> {
    let ordered = in_order(records, span_s, tally);
    let t0 = ordered.first()?.0;
    let mut fixes: Vec<Fix> = Vec::with_capacity(ordered.len());
    for (time_ms, record) in &ordered {
        let t = (time_ms - t0) as f64 * 1e-3;
        match record.position_m {
            Some(p) if p.coords.norm() <= REACH_M => {
                if fixes.last().is_some_and(|last| t - last.t < OFTEN_S) {
                    tally.add(Rule::TooOften, record.line);
                } else {
                    fixes.push(Fix { line: record.line, t, p });
                }
            }
            Some(_) => tally.add(Rule::OutOfReach, record.line),
            None => tally.add(Rule::NoPosition, record.line),
        }
    }
    let mut fixes = consistent(&fixes, fastest_mps, tally);
    if fixes.len() < 4 {
        return None;
    }
    let first_s = fixes[0].t;
    fixes.iter_mut().for_each(|fix| fix.t -= first_s);
    let t0_ms = t0 + (first_s * 1e3).round() as i64;
    let repeat_weight = |fixes: &[Fix]| -> Vec<f64> {
        let same = |i: usize| i > 0 && fixes[i].p == fixes[i - 1].p;
        (0..fixes.len()).map(|i| if same(i) { 0.02 } else { 1.0 }).collect()
    };
    let first = rough_track(&fixes, &repeat_weight(&fixes), 3.0)?;
    let grid_m = grid_m(&fixes, 0).max(grid_m(&fixes, 1));
    let sigma_m = cross_error_m(&fixes, &first).max(grid_m / 12f64.sqrt());
    let fixes = renewed(&fixes, sigma_m, tally);
    if fixes.len() < 4 {
        return None;
    }
    let even = vec![1.0; fixes.len()];
    let rough = rough_track(&fixes, &even, sigma_m)?;
    let sigma_m = cross_error_m(&fixes, &rough).max(grid_m / 12f64.sqrt());
    let speeds_mps = typical_speeds(&fixes, SHORT_S);
    let rough = held_in_gaps(rough, &fixes, sigma_m);
    let rough = steadied(&rough, &fixes, &speeds_mps);
    Some(Clean { speeds_mps, fixes, t0_ms, sigma_m, rough })
}

/// Positions nearer to each other in time say nothing more, s.
const OFTEN_S: f64 = 0.199;
/// No position of a surface movement is farther from the reference point, m.
const REACH_M: f64 = 60_000.0;

/// Records in the order of time; those more than `span_s` from the median time are left out.
fn in_order<'a>(records: &'a [Record], span_s: f64, tally: &mut Tally) -> Vec<(i64, &'a Record)> {
    let mut times: Vec<i64> = records.iter().filter_map(|r| r.time_ms).collect();
    times.sort_unstable();
    let middle_ms = times.get(times.len() / 2).copied().unwrap_or(0);
    let reach_ms = (span_s * 1e3) as u64;
    let mut ordered: Vec<(i64, &Record)> = Vec::with_capacity(records.len());
    for record in records {
        let Some(time_ms) = record.time_ms else {
            tally.add(Rule::NoTime, record.line);
            continue;
        };
        if time_ms.abs_diff(middle_ms) > reach_ms {
            tally.add(Rule::TimeOrder, record.line);
            continue;
        }
        // One clock that runs far ahead must not reject everything behind it.
        while ordered.last().is_some_and(|(last, _)| *last >= time_ms) {
            let behind = ordered.iter().rev().take_while(|(last, _)| *last >= time_ms).count();
            if behind > 1 || ordered.last().is_some_and(|(last, _)| *last == time_ms) {
                break;
            }
            let (_, dropped) = ordered.pop().unwrap_or((0, record));
            tally.add(Rule::TimeOrder, dropped.line);
        }
        if ordered.last().is_some_and(|(last, _)| *last >= time_ms) {
            tally.add(Rule::TimeOrder, record.line);
        } else {
            ordered.push((time_ms, record));
        }
    }
    ordered
}

/// The longest chain in which every step can be driven or flown.
///
/// A step may be as fast as twice the typical speed around it plus 20 m/s, and never faster than the
/// type; 1.5 s and 20 m are allowed for lateness and error.
fn consistent(fixes: &[Fix], fastest_mps: f64, tally: &mut Tally) -> Vec<Fix> {
    const LOOK_BACK: usize = 180;
    let speeds: Vec<f64> =
        typical_speeds(fixes, 0.0).into_iter().map(|v| (2.0 * v + 20.0).min(fastest_mps)).collect();
    let mut best: Vec<(usize, Option<usize>)> = Vec::with_capacity(fixes.len());
    for (j, b) in fixes.iter().enumerate() {
        let mut link = (1, None);
        for i in (j.saturating_sub(LOOK_BACK)..j).rev() {
            let a = fixes[i];
            let speed = speeds[i].max(speeds[j]);
            let possible = (b.p - a.p).norm() <= speed * (b.t - a.t + 1.5) + 20.0;
            if possible && best[i].0 + 1 > link.0 {
                link = (best[i].0 + 1, Some(i));
            }
        }
        best.push(link);
    }
    let mut at = (0..fixes.len()).max_by_key(|i| (best[*i].0, std::cmp::Reverse(*i)));
    let mut keep = vec![false; fixes.len()];
    while let Some(i) = at {
        keep[i] = true;
        at = best[i].1;
    }
    for (fix, _) in fixes.iter().zip(&keep).filter(|(_, keep)| !**keep) {
        tally.add(Rule::Jump, fix.line);
    }
    fixes.iter().zip(&keep).filter(|(_, keep)| **keep).map(|(fix, _)| *fix).collect()
}

/// Speed between the median positions of the 20 s before and the 20 s after each fix, m/s.
///
/// Few fixes between two long gaps, or at an end behind one, say little: where the medians lie no more than
/// `short_s` apart, what is beyond the gaps counts as well, and the lower speed holds.
fn typical_speeds(fixes: &[Fix], short_s: f64) -> Vec<f64> {
    const SPAN_S: f64 = 20.0;
    let median_of = |part: &[Fix]| -> Option<(f64, Point2<f64>)> {
        let middle = |value: fn(&Fix) -> f64| median(part.iter().map(value).collect());
        Some((middle(|f| f.t)?, Point2::new(middle(|f| f.p.x)?, middle(|f| f.p.y)?)))
    };
    let (mut from, mut to) = (0, 0);
    let mut speeds = Vec::with_capacity(fixes.len());
    for (i, fix) in fixes.iter().enumerate() {
        while fixes[from].t < fix.t - SPAN_S {
            from += 1;
        }
        while to < fixes.len() && fixes[to].t <= fix.t + SPAN_S {
            to += 1;
        }
        let between = |from: usize, to: usize| {
            let (ta, a) = median_of(&fixes[from..=i])?;
            let (tb, b) = median_of(&fixes[i..to])?;
            (tb > ta).then(|| (tb - ta, (b - a).norm() / (tb - ta)))
        };
        let (step_s, mut speed) = between(from, to).unwrap_or((0.0, f64::INFINITY));
        if step_s <= short_s {
            let earliest_s = fixes[from.saturating_sub(1)].t - SPAN_S;
            let latest_s = fixes[to.min(fixes.len() - 1)].t + SPAN_S;
            let wider = fixes.partition_point(|f| f.t < earliest_s);
            let wide = between(wider, fixes.partition_point(|f| f.t <= latest_s));
            speed = speed.min(wide.map_or(f64::INFINITY, |w| w.1));
        }
        speeds.push(speed);
    }
    speeds
}

/// Drops positions that were repeated although the mover went on.
///
/// A run of equal positions is a true standstill only if the next other position can be reached from
/// rest in the step that leads to it (4 sigma + 2 m + ½ · 0.7 m/s² · step²); else only its first
/// report is kept. A run at the end of the file is kept if the mover was slow before it, or had the time to brake in a gap.
fn renewed(fixes: &[Fix], sigma_m: f64, tally: &mut Tally) -> Vec<Fix> {
    let mut kept: Vec<Fix> = Vec::with_capacity(fixes.len());
    let mut i = 0;
    while i < fixes.len() {
        let same = fixes[i..].iter().take_while(|f| f.p == fixes[i].p).count();
        let last = fixes[i + same - 1];
        // As far as the mover goes from rest, or to rest, in `step`.
        let reach_m = |step: f64| 4.0 * sigma_m + 2.0 + 0.35 * step * step;
        let stands = match fixes.get(i + same) {
            Some(next) => (next.p - last.p).norm() <= reach_m(next.t - last.t),
            None => {
                let before = kept.iter().rev().find(|f| f.t <= fixes[i].t - 5.0);
                before.is_none_or(|b| {
                    let (way_m, step) = ((fixes[i].p - b.p).norm(), fixes[i].t - b.t);
                    way_m < 4.0 * step || way_m <= reach_m(step)
                })
            }
        };
        kept.push(fixes[i]);
        for repeat in &fixes[i + 1..i + same] {
            if stands {
                kept.push(*repeat);
            } else {
                tally.add(Rule::NotRenewed, repeat.line);
            }
        }
        i += same;
    }
    kept
}

/// A smoothing spline with bad positions weighted down (Cauchy weights, first absolute errors).
fn rough_track(fixes: &[Fix], weights: &[f64], sigma_m: f64) -> Option<Vec<Point2<f64>>> {
    let end = fixes.last()?.t;
    let pieces = (end.ceil() as usize).max(1);
    let controls: Vec<Control<2>> = (0..pieces + 3).map(Control::Free).collect();
    let mut track: Option<Vec<[f64; 2]>> = None;
    for round in 0..12 {
        let data = fixes.iter().zip(weights).map(|(fix, weight)| {
            let (error, speed) = track.as_ref().map_or((0.0, 0.0), |controls| {
                let (p, v) = value_at(controls, fix.t);
                ((fix.p - p).norm(), v.norm())
            });
            let sigma2 = sigma_m * sigma_m + speed * speed * LATENESS_S * LATENESS_S;
            let ratio2 = error * error / sigma2;
            let robust =
                if round < 4 { 1.0 / (0.1 + ratio2).sqrt() } else { 1.0 / (1.0 + 0.25 * ratio2) };
            Datum { place: fix.t, value: fix.p.into(), weight: weight * robust / sigma2 }
        });
        let fit = Fit {
            controls: controls.clone(),
            data: data.collect(),
            roughness: 1.0 / JERK_DENSITY,
            stiffness: Vec::new(),
            bounds: Vec::new(),
        };
        track = Some(fit.unbounded()?);
    }
    let controls = track?;
    Some((0..=pieces).map(|i| value_at(&controls, i as f64).0).collect())
}

/// The rough track without the swings that the spline makes in gaps between rest and speed.
///
/// Where it goes back behind the begin of a gap, or beyond its end and back, although the positions on
/// that side do not go that way, it stands at that begin or end.
fn held_in_gaps(mut rough: Vec<Point2<f64>>, fixes: &[Fix], sigma_m: f64) -> Vec<Point2<f64>> {
    const LEAST_GAP_S: f64 = 10.0;
    const ASIDE_S: f64 = 5.0;
    let noise_m = 4.0 * sigma_m + 2.0;
    for i in 1..fixes.len() {
        let (a, b) = (fixes[i - 1], fixes[i]);
        if b.t - a.t < LEAST_GAP_S {
            continue;
        }
        let came = fixes[..i].iter().rev().find(|f| f.t <= a.t - ASIDE_S).unwrap_or(&a);
        let goes = fixes[i..].iter().find(|f| f.t >= b.t + ASIDE_S).unwrap_or(&b);
        let (begin, end) = (on_track(&rough, a.t), on_track(&rough, b.t));
        // A gap without a way lies on the way of the positions around it.
        let ways = [end - begin, goes.p - came.p];
        let Some(way) = ways.iter().find(|way| way.norm() > noise_m) else { continue };
        let ahead = way.normalize();
        let way_m = (end - begin).dot(&ahead).max(0.0);
        let backs_in = (a.p - came.p).dot(&ahead) < -noise_m;
        let backs_out = (goes.p - b.p).dot(&ahead) < -noise_m;
        for place in &mut rough[a.t as usize + 1..b.t.ceil() as usize] {
            let along_m = (*place - begin).dot(&ahead);
            if along_m < 0.0 && !backs_in {
                *place = begin;
            } else if along_m > way_m && !backs_out {
                *place = end;
            }
        }
    }
    rough
}

/// The rough track with the wander of slow phases taken out: a running median over up to ±10 s where
/// the typical speed is below 2 m/s, over shorter times near it.
fn steadied(rough: &[Point2<f64>], fixes: &[Fix], speeds_mps: &[f64]) -> Vec<Point2<f64>> {
    const HALF_S: f64 = 10.0;
    const SLOW_MPS: f64 = 2.0;
    let mut next = 0;
    let mut steady = Vec::with_capacity(rough.len());
    for (i, here) in rough.iter().enumerate() {
        while next + 1 < fixes.len() && fixes[next].t < i as f64 {
            next += 1;
        }
        let half = (HALF_S * (1.0 - speeds_mps[next] / SLOW_MPS).clamp(0.0, 1.0)) as usize;
        // As far to the left as to the right, or a moving end would be pulled inward.
        let half = half.min(i).min(rough.len() - 1 - i);
        let window = &rough[i - half..=i + half];
        let middle = |value: fn(&Point2<f64>) -> f64| median(window.iter().map(value).collect());
        let median_m =
            Point2::new(middle(|p| p.x).unwrap_or(here.x), middle(|p| p.y).unwrap_or(here.y));
        steady.push(median_m);
    }
    steady
}

/// Value and slope at `t` of a spline with step 1 from 0.
fn value_at(controls: &[[f64; 2]], t: f64) -> (Point2<f64>, Vector2<f64>) {
    let pieces = controls.len() - 3;
    let place = t.clamp(0.0, pieces as f64);
    let piece = (place as usize).min(pieces - 1);
    let t = place - piece as f64;
    let s = 1.0 - t;
    let b = [
        s * s * s / 6.0,
        (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0,
        (1.0 + 3.0 * t + 3.0 * t * t - 3.0 * t * t * t) / 6.0,
        t * t * t / 6.0,
    ];
    let d = [-0.5 * s * s, 1.5 * t * t - 2.0 * t, 0.5 + t - 1.5 * t * t, 0.5 * t * t];
    let mut value = (Point2::origin(), Vector2::zeros());
    for (k, control) in controls[piece..piece + 4].iter().enumerate() {
        let c = Vector2::from(*control);
        value.0 += c * b[k];
        value.1 += c * d[k];
    }
    value
}

/// Position on the rough track at `t`, straight between whole seconds.
pub(super) fn on_track(rough: &[Point2<f64>], t: f64) -> Point2<f64> {
    let place = t.clamp(0.0, (rough.len() - 1) as f64);
    let i = (place as usize).min(rough.len().saturating_sub(2));
    let next = rough[(i + 1).min(rough.len() - 1)];
    rough[i] + (next - rough[i]) * (place - i as f64)
}

/// Distance of the grid lines that the positions lie on along one axis, m; 0 without a coarse grid.
///
/// Some decoders round positions to a grid of more than 10 m. The median step between the different
/// values is taken for the grid if four fifths of them lie on its lines.
fn grid_m(fixes: &[Fix], axis: usize) -> f64 {
    const LEAST_VALUES: usize = 12;
    let mut values: Vec<f64> = fixes.iter().map(|f| f.p[axis]).collect();
    values.sort_by(f64::total_cmp);
    values.dedup_by(|b, a| *b - *a < 1.0);
    let steps: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).collect();
    let Some(step) = median(steps).filter(|s| *s > 4.0 && values.len() >= LEAST_VALUES) else {
        return 0.0;
    };
    // The value nearest to a line through its neighbours; an exact step from the longest span.
    let on_line = values.windows(2).filter(|w| {
        let steps = (w[1] - w[0]) / step;
        (steps - steps.round()).abs() < 0.1 && steps.round() <= 3.0
    });
    if 5 * on_line.count() >= 4 * (values.len() - 1) { step } else { 0.0 }
}

/// Robust standard deviation of the errors across the track (of a component where it is slow), 0.7 to 12 m.
fn cross_error_m(fixes: &[Fix], rough: &[Point2<f64>]) -> f64 {
    let mut errors = Vec::with_capacity(fixes.len());
    for fix in fixes {
        let error = fix.p - on_track(rough, fix.t);
        let v = (on_track(rough, fix.t + 1.0) - on_track(rough, fix.t - 1.0)) * 0.5;
        if v.norm() > 2.0 {
            errors.push((error.dot(&Vector2::new(-v.y, v.x)) / v.norm()).abs());
        } else {
            errors.push(error.x.abs());
            errors.push(error.y.abs());
        }
    }
    // The upper quartile as well: a grid of positions has most errors at zero.
    errors.sort_by(f64::total_cmp);
    let quantile = |q: f64| errors.get((q * errors.len() as f64) as usize).copied().unwrap_or(0.0);
    (1.4826 * quantile(0.5)).max(quantile(0.75) / 1.15).clamp(0.7, 12.0)
}

/// The middle value, `None` of nothing.
pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
