//! The path of a leg: smooth, near the positions, not sharper than the type can turn.

use super::super::dubins::{self, Pose};
use super::super::fit::{Bound, Control, Datum, Fit};
use super::super::spline::Spline;
use super::Work;
use super::reject::on_track;
use crate::frames::{Point2, Vector2};

/// Distance of the controls of a path, m.
const PATH_STEP_M: f64 = 4.0;
/// Smooth path before the first and after the last position, m.
const MARGIN_M: f64 = 12.0;
/// Straight path before and after that: in a run at its end the truth may be that far from positions, m.
const BEYOND_M: f64 = 600.0;
/// Place of the first position on the path of a leg that does not begin where one before it ended, m.
pub(super) const BEGIN_M: f64 = BEYOND_M + MARGIN_M;

impl Work<'_> {
    /// Points that the path shall meet: the rough track, thinned, with each standstill one point.
    fn points(&self, from: usize, to: usize) -> Vec<(f64, Point2<f64>)> {
        let step_m = (0.7 * self.clean.sigma_m).max(2.0);
        let mut points: Vec<(f64, Point2<f64>)> = Vec::new();
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

    /// True if the mover hardly goes on around `t`: what the track does there is wander.
    fn is_slow(&self, t: f64) -> bool {
        let next = self.clean.fixes.partition_point(|f| f.t < t);
        let speed = self.clean.speeds_mps[next.min(self.clean.fixes.len() - 1)];
        speed < 1.5
    }

    /// The path from second `from` to second `to`; its parameter is length.
    pub(super) fn path(
        &self,
        from: usize,
        to: usize,
        begin: Option<(Point2<f64>, Vector2<f64>)>,
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
        let points: Vec<Point2<f64>> = timed.iter().map(|p| p.1).collect();
        let speeds: Vec<f64> = timed.iter().map(|p| self.clean.speed(p.0)).collect();
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
        path = by_length(&path, begin, 0.0)?;
        by_length(&path, begin, BEYOND_M)
    }

    /// Smooth path near points at given places, curvature within the limit.
    fn path_through(
        &self,
        points: &[Point2<f64>],
        places: &[f64],
        speeds: &[f64],
        begin: Option<(Point2<f64>, Vector2<f64>)>,
    ) -> Option<Spline<2>> {
        // Spectral density of the change of curvature along the path, 1/m³.
        const BEND_DENSITY: f64 = 1e-4;
        // Above this speed that density falls.
        const STEADY_MPS: f64 = 12.0;
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
        let bounds = (0..pieces + 1).map(|first| Bound {
            order: 2,
            first,
            lean: 0.0,
            centre: [0.0; 2],
            radius,
        });
        let fit = Fit {
            controls,
            data: data.collect(),
            roughness: 1.0 / (h * h * h * h * h * BEND_DENSITY),
            stiffness: (0..pieces)
                .map(|piece| {
                    let next = places.partition_point(|place| *place < piece as f64 * h);
                    let speed = speeds[next.min(speeds.len() - 1)];
                    // Lateral jerk is v³ times the change of curvature: fast parts are straighter.
                    (speed / STEADY_MPS).max(1.0).powi(4)
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
}

/// Takes detours out of slow phases: from each point the farthest one within `reach_m` that is reached
/// by a line much longer than straight, all of it slow, comes next.
fn straightened(
    points: &[(f64, Point2<f64>)],
    reach_m: f64,
    is_slow: impl Fn(f64) -> bool,
) -> Vec<(f64, Point2<f64>)> {
    let mut kept: Vec<(f64, Point2<f64>)> = Vec::with_capacity(points.len());
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
pub(in crate::truth) fn turned(
    timed: &[(f64, Point2<f64>)],
    radius_m: f64,
) -> Vec<(f64, Point2<f64>)> {
    const WINDOW_M: f64 = 24.0;
    const STEP_M: f64 = 2.0;
    let count = timed.len();
    if count < 4 {
        return timed.to_vec();
    }
    let points: Vec<Point2<f64>> = timed.iter().map(|p| p.1).collect();
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

/// The same path over its own length: what goes along it goes exactly as fast as its parameter. It
/// goes on straight for `beyond_m` at its end, and before its begin unless that is given.
fn by_length(
    path: &Spline<2>,
    begin: Option<(Point2<f64>, Vector2<f64>)>,
    beyond_m: f64,
) -> Option<Spline<2>> {
    let table = PathTable::of(path);
    let h = PATH_STEP_M;
    let straight = |at: f64, along_m: f64| {
        let jet = path.at(at);
        let ahead = Vector2::from(jet.first).normalize();
        Point2::from(jet.value) + ahead * along_m
    };
    let (before_m, margin_m) = match begin {
        Some(_) => (0.0, 0.0),
        None => (beyond_m, table.length_to(MARGIN_M) - MARGIN_M),
    };
    let length_m = table.lengths[table.lengths.len() - 1];
    let steps = |length_m: f64| (length_m / TABLE_STEP_M) as usize;
    let samples = table.points.iter().zip(&table.lengths).map(|(p, length)| (*p, *length));
    let head = (1..=steps(before_m)).map(|i| -(i as f64) * TABLE_STEP_M);
    let tail = (1..=steps(beyond_m)).map(|i| i as f64 * TABLE_STEP_M);
    let data = samples
        .chain(head.map(|m| (straight(path.start(), m), m)))
        .chain(tail.map(|m| (straight(path.end(), m), length_m + m)))
        .map(|(p, length)| (p, (length + before_m - margin_m) / h));
    let pieces = ((length_m + before_m + beyond_m - margin_m) / h).floor().max(1.0) as usize;
    let control = |j: usize| match begin {
        Some((here, ahead)) if j < 3 => {
            Control::Fixed((here + ahead * (h * (j as f64 - 1.0))).into())
        }
        Some(_) => Control::Free(j - 3),
        None => Control::Free(j),
    };
    let data = data.filter(|(_, place)| (0.0..=pieces as f64).contains(place));
    let fit = Fit {
        controls: (0..pieces + 3).map(control).collect(),
        data: data.map(|(p, place)| Datum { place, value: p.into(), weight: 1.0 }).collect(),
        roughness: 1e-3,
        stiffness: Vec::new(),
        bounds: Vec::new(),
    };
    Spline::new(0.0, h, fit.unbounded()?)
}

/// A path sampled every half metre.
pub(super) struct PathTable {
    points: Vec<Point2<f64>>,
    /// Curvature, 1/m.
    bends: Vec<f64>,
    /// Length from the begin, m.
    lengths: Vec<f64>,
}

pub(super) const TABLE_STEP_M: f64 = 0.5;

impl PathTable {
    pub(super) fn of(path: &Spline<2>) -> Self {
        let count = ((path.end() - path.start()) / TABLE_STEP_M) as usize + 1;
        let mut table = Self { points: Vec::new(), bends: Vec::new(), lengths: Vec::new() };
        for i in 0..count {
            let jet = path.at(path.start() + i as f64 * TABLE_STEP_M);
            let (d, dd) = (jet.first, jet.second);
            let speed2 = d[0] * d[0] + d[1] * d[1];
            let bend = (d[0] * dd[1] - d[1] * dd[0]).abs() / (speed2 * speed2.sqrt()).max(1e-6);
            let point = Point2::from(jet.value);
            let length = table.points.last().map_or(0.0, |p: &Point2<f64>| (point - p).norm());
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
    pub(super) fn nearest(&self, p: Point2<f64>, from_m: f64, to_m: f64) -> (f64, f64) {
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

    /// Fastest speed at each place, m/s: the lateral acceleration holds, and the speed can be reached and
    /// left with the given acceleration and braking.
    pub(super) fn fastest(&self, lateral_ms2: f64, acc_ms2: f64, dec_ms2: f64) -> Vec<f64> {
        let around = |i: usize| {
            self.bends[i.saturating_sub(3)..(i + 4).min(self.bends.len())].iter().copied()
        };
        let bend = |i: usize| around(i).fold(1e-9, f64::max);
        let mut fastest: Vec<f64> =
            (0..self.bends.len()).map(|i| (lateral_ms2 / bend(i)).sqrt()).collect();
        for i in 1..fastest.len() {
            let before = fastest[i - 1];
            fastest[i] = fastest[i].min((before * before + 2.0 * acc_ms2 * TABLE_STEP_M).sqrt());
        }
        for i in (1..fastest.len()).rev() {
            let after = fastest[i];
            let here = fastest[i - 1];
            fastest[i - 1] = here.min((after * after + 2.0 * dec_ms2 * TABLE_STEP_M).sqrt());
        }
        fastest
    }

    fn length_to(&self, place_m: f64) -> f64 {
        let place = (place_m / TABLE_STEP_M).clamp(0.0, (self.points.len() - 1) as f64);
        let i = (place as usize).min(self.points.len().saturating_sub(2));
        let next = self.lengths[(i + 1).min(self.lengths.len() - 1)];
        self.lengths[i] + (next - self.lengths[i]) * (place - i as f64)
    }
}
