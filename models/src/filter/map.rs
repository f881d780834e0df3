//! Map-aided: the target follows a known centreline, with a known probability of not doing so.
//!
//! On a known route a turn is no manoeuvre any more, only a change of speed is. The state is the path
//! length s with its two derivatives, and the lateral deviation d from the centreline. The deviation
//! persists for tens of seconds, so it is a state of its own (first-order Gauss–Markov) and not white
//! noise added to every plot: taken as white it makes the filter claim 0.67 m and deliver 0.99 m. With a
//! deviation of zero this is the projection of each plot onto the centreline, weighted by its covariance.
//!
//! Changes of speed are mode histories, a junction is one history per way out, and a free filter runs
//! beside for a target that has left the map; the plots decide between them.

use super::gaussian::{Factor, Gaussian, Measurement, Nis};
use super::imm::Imm;
use super::lanes::Pair;
use super::modes::{MAX_MODES, Modes, ca, cv};
use super::motion::Step;
use super::route::Network;
use super::three_state::start_position;
use super::{Declared, Estimator};
use super::{Estimate, Start, StateEstimator, Sym2, UpdateError, interval, weights};
use crate::frames::{Point2, Vector2};
use crate::plot::Plot;
use crate::time::SimTime;
use std::sync::Arc;

/// What is known of how targets keep to their centrelines.
#[derive(Clone, Debug, PartialEq)]
pub struct MapKnowledge {
    /// The ways.
    pub network: Network,
    /// Standard deviation of the lateral deviation, m, where an edge states no width; 0 for a target that is
    /// exactly on its centreline.
    pub lateral_sigma_m: f64,
    /// The same as a share of the width, where an edge states one (assumed: 1.5 m on a taxiway of 23 m).
    pub lateral_share: f64,
    /// Time over which the deviation persists, s.
    pub lateral_time_s: f64,
    /// Probability per second of leaving the map.
    pub leave_per_s: f64,
    /// Probability per second of coming back to it.
    pub return_per_s: f64,
    /// Probability that a new target on a centreline is there by chance.
    pub off_prior: f64,
    /// Modes of the motion along the route.
    pub along: Modes,
}

impl MapKnowledge {
    /// A network with the defaults of the other fields: no deviation, rarely off the map.
    #[must_use]
    pub fn of(network: Network) -> Self {
        Self {
            network,
            lateral_sigma_m: 0.0,
            lateral_share: 1.0 / 15.0,
            lateral_time_s: 30.0,
            leave_per_s: 1e-3,
            return_per_s: 1e-2,
            off_prior: 0.05,
            along: Modes::new(
                &[cv(0.01), ca(0.003), ca(1.0)],
                &[&[0.96, 0.03, 0.01], &[0.03, 0.96, 0.01], &[0.10, 0.10, 0.80]],
                &[0.45, 0.45, 0.10],
            )
            .expect("rows sum to 1"),
        }
    }
}

impl MapKnowledge {
    /// Standard deviation of the lateral deviation on an edge, m.
    fn lateral_m(&self, edge: usize) -> f64 {
        let width = self.network.edges[edge].width_m;
        if width > 0.0 { width * self.lateral_share } else { self.lateral_sigma_m }
    }
}

/// One history of modes and ways: path length, speed, acceleration, lateral deviation.
#[derive(Clone, Copy, Debug, Default)]
struct Along {
    x: [f64; 4],
    /// Covariance of the first three: ss, sv, sa, vv, va, aa.
    p: [f64; 6],
    /// Covariance of each of them with the deviation.
    pd: [f64; 3],
    dd: f64,
    edge: u16,
    mode: u8,
    log_weight: f64,
}

/// The filter with at most N histories on the map and a three-mode filter off it.
#[derive(Clone, Debug)]
pub struct MapAided<const N: usize> {
    time: SimTime,
    len: usize,
    kept: [Along; N],
    /// ln of the probability of being off the map.
    log_off: f64,
    off: Imm<3>,
    map: Arc<MapKnowledge>,
    start: Start,
}

const CHILDREN: usize = 128;
/// Least lateral standard deviation stated in the output, m: painted lines are not better known.
const PAINT_M: f64 = 0.05;
/// ln of how much less likely it is that a target moves against the direction of a way.
const BACKWARDS: f64 = -2.0;
/// Below this probability of being on the map the histories are found anew from the free filter.
const LOST: f64 = 1e-6;

impl<const N: usize> MapAided<N> {
    /// One plot: position measured, velocity unknown.
    ///
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    pub fn from_plot(
        plot: &Plot,
        map: Arc<MapKnowledge>,
        free: Arc<Modes>,
        start: Start,
    ) -> Result<Self, UpdateError> {
        let off = Imm::from_plot(plot, free, start)?;
        let mut filter = Self {
            time: plot.time,
            len: 0,
            kept: [Along::default(); N],
            log_off: 0.0,
            off,
            map,
            start,
        };
        let (z, r) = start_position(plot)?;
        let state = Gaussian::at_position(z, r, start.sigma_v_mps, start.sigma_a_ms2);
        filter.find_on_map(&state, 1.0 - filter.map.off_prior);
        Ok(filter)
    }

    /// Probability of being on the map.
    #[must_use]
    pub fn on_map(&self) -> f64 {
        -libm::expm1(self.log_off.min(0.0))
    }

    /// New histories from a free state: one for every mode and every edge that fits it, with `weight` in all.
    fn find_on_map(&mut self, state: &Gaussian, weight: f64) {
        self.len = 0;
        let prior = self.map.along.prior();
        let at = state.position();
        let spread = state.position_cov();
        let mut found: Vec<(f64, Along)> = Vec::new();
        for (number, edge) in self.map.network.edges.iter().enumerate() {
            let sigma = self.map.lateral_m(number);
            let farthest = GATE_1D * (spread.xx.max(0.0) + spread.yy.max(0.0) + sigma * sigma);
            if edge.route.is_beyond(at, farthest.sqrt()) {
                continue;
            }
            let (s, distance) = edge.route.nearest(at);
            let point = edge.route.at(s);
            let cov = turned(spread, point.along);
            let lateral = cov.yy + sigma * sigma;
            let (v, across) = rates(state, point.along, 1);
            let (a, _) = rates(state, point.along, 2);
            let fits = distance * distance <= GATE_1D * lateral
                && across.0 * across.0 <= GATE_1D * (across.1 + 0.01 * v.0 * v.0 + 0.25);
            if !fits {
                continue;
            }
            let mut x = Along {
                x: [s, v.0, a.0, 0.0],
                p: [1e6, 0.0, 0.0, v.1, 0.0, a.1],
                pd: [0.0; 3],
                dd: sigma * sigma,
                edge: number as u16,
                mode: 0,
                log_weight: 0.0,
            };
            if let Ok(log) = x.update(&self.map, at, spread) {
                // Where the velocity is known, a way across it is no way.
                let course = -0.5 * across.0 * across.0 / (across.1 + 0.01 * v.0 * v.0 + 0.25);
                let backwards = if v.0 < 0.0 { BACKWARDS } else { 0.0 };
                found.push((log + course + backwards, x));
            }
        }
        // The best ways; there is room for all modes of each.
        found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.edge.cmp(&b.1.edge)));
        for (log, x) in found {
            for (mode, prior) in prior.iter().enumerate().take(self.map.along.count()) {
                if self.len < N && *prior > 0.0 {
                    let log_weight = log + libm::log(*prior);
                    self.kept[self.len] = Along { mode: mode as u8, log_weight, ..x };
                    self.len += 1;
                }
            }
        }
        let mut logs = [f64::NEG_INFINITY; N];
        for (log, kept) in logs.iter_mut().zip(&self.kept[..self.len]) {
            *log = kept.log_weight;
        }
        match weights::normalise(&mut logs) {
            Some(sum) => {
                for kept in &mut self.kept[..self.len] {
                    kept.log_weight += libm::log(weight) - sum;
                }
                self.log_off = libm::log1p(-weight);
            }
            None => self.log_off = 0.0,
        }
    }

    fn log_on(&self) -> f64 {
        let mut logs = [f64::NEG_INFINITY; N];
        for (log, kept) in logs.iter_mut().zip(&self.kept[..self.len]) {
            *log = kept.log_weight;
        }
        weights::normalise(&mut logs).unwrap_or(f64::NEG_INFINITY)
    }

    /// Every child of every history after `t` seconds; the log weight includes how likely the way to it is.
    fn children(&self, t: f64, out: &mut [Along; CHILDREN]) -> usize {
        let (steps, logs) = (self.map.along.steps(t), self.map.along.log_transition(t));
        let keep = libm::exp(-t / self.map.lateral_time_s);
        let mut count = 0;
        for kept in &self.kept[..self.len] {
            let sigma = self.map.lateral_m(usize::from(kept.edge));
            let fresh = sigma * sigma * (1.0 - keep * keep);
            for mode in 0..self.map.along.count() {
                let log = logs[usize::from(kept.mode)][mode];
                if log == f64::NEG_INFINITY {
                    continue;
                }
                let mut child = kept.predicted(&steps[mode], keep, fresh);
                child.mode = mode as u8;
                child.log_weight += log;
                let edge = &self.map.network.edges[usize::from(child.edge)];
                let reach = child.x[0] + 2.0 * child.p[0].max(0.0).sqrt();
                if edge.next.is_empty() || reach <= edge.route.length_m() {
                    push(out, &mut count, child);
                    continue;
                }
                for (next, share) in &edge.next {
                    let mut way = child;
                    way.edge = *next as u16;
                    way.x[0] -= edge.route.length_m();
                    way.log_weight += libm::log(*share);
                    push(out, &mut count, way);
                }
            }
        }
        count
    }

    fn take(
        &mut self,
        at: SimTime,
        z: Point2<f64>,
        r: Sym2,
        free: impl Fn(&mut Imm<3>) -> Result<Nis, UpdateError>,
    ) -> Result<Nis, UpdateError> {
        let t = interval(self.time, at)?;
        let mut off = self.off.clone();
        let nis = free(&mut off)?;
        let mut children = [Along::default(); CHILDREN];
        let count = self.children(t, &mut children);
        let log_on = self.log_on();
        // Leaving and returning, a chain of two states.
        let leave = -libm::expm1(-self.map.leave_per_s * t);
        let back = -libm::expm1(-self.map.return_per_s * t);
        let (w_on, w_off) = (libm::exp(log_on), libm::exp(self.log_off));
        let on_gain = if w_on > 0.0 { (w_on * (1.0 - leave) + w_off * back) / w_on } else { 0.0 };
        let mut log_off =
            libm::log(w_off * (1.0 - back) + w_on * leave) - 0.5 * (nis.d2 + nis.ln_det());
        let mut updated = 0;
        for k in 0..count {
            let mut child = children[k];
            if let Ok(found) = child.update(&self.map, z, r) {
                child.log_weight += libm::log(on_gain) + found;
                if child.log_weight > f64::NEG_INFINITY {
                    children[updated] = child;
                    updated += 1;
                }
            }
        }
        let children = &mut children[..updated];
        children.sort_by(|a, b| {
            b.log_weight.total_cmp(&a.log_weight).then((a.edge, a.mode).cmp(&(b.edge, b.mode)))
        });
        self.len = updated.min(N);
        self.kept[..self.len].copy_from_slice(&children[..self.len]);
        let on = self.log_on();
        let largest = on.max(log_off);
        if largest == f64::NEG_INFINITY || largest.is_nan() {
            // Nothing explains the plot: keep what was believed of the map.
            log_off = self.log_off;
            self.len = 0;
        } else {
            let sum = largest + libm::log(libm::exp(on - largest) + libm::exp(log_off - largest));
            self.kept[..self.len].iter_mut().for_each(|k| k.log_weight -= sum);
            log_off -= sum;
        }
        (self.time, self.off, self.log_off) = (at, off, log_off);
        if self.len == 0 || self.on_map() < LOST {
            let state = self.off.estimate().state;
            self.find_on_map(&state, back.max(LOST));
        }
        Ok(nis)
    }

    /// Weighted Cartesian states of the histories and of the free filter.
    fn mixed(&self, along: &[Along], off: &Gaussian) -> Gaussian {
        let mut weights = [0.0; CHILDREN + 1];
        let mut states = [Gaussian::default(); CHILDREN + 1];
        let mut count = 0;
        for kept in along {
            let weight = libm::exp(kept.log_weight);
            // What cannot be seen in the mean is not worth turning into Cartesian form.
            if weight > 1e-12 {
                weights[count] = weight;
                states[count] = kept.cartesian(&self.map);
                count += 1;
            }
        }
        weights[count] = libm::exp(self.log_off);
        states[count] = *off;
        let sum: f64 = weights[..=count].iter().sum();
        weights[..=count].iter_mut().for_each(|w| *w /= sum);
        Gaussian::mixture(&weights[..=count], &states[..=count])
    }
}

/// The 99.9 % quantile of χ² with one degree of freedom.
const GATE_1D: f64 = 10.828;

fn push(out: &mut [Along; CHILDREN], count: &mut usize, child: Along) {
    if *count < CHILDREN {
        out[*count] = child;
        *count += 1;
    }
}

/// Mean and variance of the k-th derivative along and across a direction.
fn rates(state: &Gaussian, along: Vector2<f64>, k: usize) -> ((f64, f64), (f64, f64)) {
    let (slot, cross) = if k == 1 { (3, 4) } else { (5, 8) };
    let x = Vector2::new(state.x[k].east(), state.x[k].north());
    let p = turned(
        Sym2 { xx: state.p[slot].east(), xy: state.cross[cross], yy: state.p[slot].north() },
        along,
    );
    ((x.dot(&along), p.xx), (along.x * x.y - along.y * x.x, p.yy))
}

/// A covariance in the axes along and to the left of `u`.
fn turned(r: Sym2, u: Vector2<f64>) -> Sym2 {
    let (c, s) = (u.x, u.y);
    Sym2 {
        xx: r.xx * c * c + 2.0 * r.xy * c * s + r.yy * s * s,
        xy: (r.yy - r.xx) * c * s + r.xy * (c * c - s * s),
        yy: r.xx * s * s - 2.0 * r.xy * c * s + r.yy * c * c,
    }
}

impl Along {
    fn predicted(&self, step: &Step, keep: f64, fresh: f64) -> Self {
        let Step { t, f02, f12, f22, q } = *step;
        let [s, v, a, d] = self.x;
        let [ss, sv, sa, vv, va, aa] = self.p;
        let (c0, f0) = (sa + va * t + aa * f02, va + aa * f12);
        let (b0, e0) = (sv + vv * t + va * f02, vv + va * f12);
        let a0 = ss + sv * t + sa * f02;
        let [pd, vd, ad] = self.pd;
        Self {
            x: [s + v * t + a * f02, v + a * f12, a * f22, d * keep],
            p: [
                a0 + b0 * t + c0 * f02 + q[0],
                b0 + c0 * f12 + q[1],
                c0 * f22 + q[2],
                e0 + f0 * f12 + q[3],
                f0 * f22 + q[4],
                aa * f22 * f22 + q[5],
            ],
            pd: [(pd + vd * t + ad * f02) * keep, (vd + ad * f12) * keep, ad * f22 * keep],
            dd: self.dd * keep * keep + fresh,
            ..*self
        }
    }

    /// Takes a measured position; the foot point on the route is found by iteration. Returns the log likelihood.
    fn update(&mut self, map: &MapKnowledge, z: Point2<f64>, r: Sym2) -> Result<f64, UpdateError> {
        let route = &map.network.edges[usize::from(self.edge)].route;
        let mut foot = self.x[0];
        let mut best: Option<(f64, Factor, [f64; 2])> = None;
        for _ in 0..4 {
            let point = route.at(foot);
            let offset = z - point.position;
            let r = turned(r, point.along);
            let nu = Vector2::new(
                offset.dot(&point.along) + foot - self.x[0],
                offset.dot(&point.left()) - self.x[3],
            );
            let s = Sym2 { xx: self.p[0] + r.xx, xy: self.pd[0] + r.xy, yy: self.dd + r.yy };
            let factor = Factor::of(s)?;
            let (y, d2) = factor.independent(nu);
            if best.is_none_or(|(least, ..)| d2 < least) {
                best = Some((d2, factor, y));
            }
            let next = self.x[0] + factor.dot(factor.row([self.p[0], self.pd[0]]), y);
            let moved = (next - foot).abs();
            let straight = point.curvature == 0.0 && route.at(next).piece == point.piece;
            foot = next;
            if moved < 1e-3 || straight {
                break;
            }
        }
        let Some((d2, factor, y)) = best else { return Err(UpdateError::UnsoundPlot) };
        if !d2.is_finite() {
            return Err(UpdateError::BadInnovation(d2));
        }
        let n: [[f64; 2]; 4] = [
            factor.row([self.p[0], self.pd[0]]),
            factor.row([self.p[1], self.pd[1]]),
            factor.row([self.p[2], self.pd[2]]),
            factor.row([self.pd[0], self.dd]),
        ];
        for (x, n) in self.x.iter_mut().zip(n) {
            *x += factor.dot(n, y);
        }
        let dot = |i: usize, j: usize| factor.dot(n[i], n[j]);
        for (p, (i, j)) in self.p.iter_mut().zip([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]) {
            *p -= dot(i, j);
        }
        for (i, p) in self.pd.iter_mut().enumerate() {
            *p -= dot(i, 3);
        }
        self.dd -= dot(3, 3);
        Ok(-0.5 * (d2 + factor.ln_det()))
    }

    /// Position, velocity and acceleration in the airport frame.
    fn cartesian(&self, map: &MapKnowledge) -> Gaussian {
        let route = &map.network.edges[usize::from(self.edge)].route;
        let [s, v, a, d] = self.x;
        let point = route.at(s);
        let (u, n, k) = (point.along, point.left(), point.curvature);
        let vector = |w: Vector2<f64>| Pair::new(w.x, w.y);
        let mut out = Gaussian {
            x: [
                vector((point.position + n * d).coords),
                vector(u * v),
                vector(u * a + n * (k * v * v)),
            ],
            ..Gaussian::default()
        };
        // Square roots of the covariance, carried over column by column: P = Σ g gᵀ.
        let [ss, sv, sa, vv, va, aa] = self.p;
        let l0 = ss.max(0.0).sqrt();
        let i0 = if l0 > 0.0 { 1.0 / l0 } else { 0.0 };
        let (l10, l20, l30) = (sv * i0, sa * i0, self.pd[0] * i0);
        let l1 = (vv - l10 * l10).max(0.0).sqrt();
        let i1 = if l1 > 0.0 { 1.0 / l1 } else { 0.0 };
        let (l21, l31) = ((va - l10 * l20) * i1, (self.pd[1] - l10 * l30) * i1);
        let l2 = (aa - l20 * l20 - l21 * l21).max(0.0).sqrt();
        let i2 = if l2 > 0.0 { 1.0 / l2 } else { 0.0 };
        let l32 = (self.pd[2] - l20 * l30 - l21 * l31) * i2;
        let rest = (self.dd - l30 * l30 - l31 * l31 - l32 * l32).max(0.0).sqrt();
        let columns = [
            [l0, l10, l20, l30],
            [0.0, l1, l21, l31],
            [0.0, 0.0, l2, l32],
            [0.0, 0.0, 0.0, rest.max(PAINT_M)],
        ];
        // Across: a target that drifts within its deviation, and the side force of a turn.
        let drift = if map.lateral_m(usize::from(self.edge)) > 0.0 { 0.05 * v } else { 0.0 };
        for [ds, dv, da, dd] in columns {
            let g = [
                vector(u * ds + n * dd),
                vector(u * dv + n * (k * v * ds)),
                vector(u * da + n * (2.0 * k * v * dv)),
            ];
            out.add_outer(&g, 1.0);
        }
        let zero = Pair::default();
        out.add_outer(&[zero, vector(n * drift), zero], 1.0);
        out.add_outer(&[zero, zero, vector(n * SIDE_ACCELERATION_MS2)], 1.0);
        out
    }
}

/// How well the lateral acceleration is known from speed and curvature, m/s².
const SIDE_ACCELERATION_MS2: f64 = 0.3;
/// Variance across the direction of a plot that measures one direction only, m²: nothing is known.
const UNKNOWN_M2: f64 = 1e8;

/// A measured position with its covariance, whatever the plot measures.
fn position_of(m: &Measurement) -> (Point2<f64>, Sym2) {
    match *m {
        Measurement::Position { z, r } => (z, r),
        Measurement::Line { z, axis, variance } => {
            let (a, b) = (axis, Vector2::new(axis.y, -axis.x));
            let r = Sym2 {
                xx: variance * a.x * a.x + UNKNOWN_M2 * b.x * b.x,
                xy: variance * a.x * a.y + UNKNOWN_M2 * b.x * b.y,
                yy: variance * a.y * a.y + UNKNOWN_M2 * b.y * b.y,
            };
            (z, r)
        }
    }
}

impl<const N: usize> StateEstimator for MapAided<N> {
    fn time(&self) -> SimTime {
        self.time
    }

    fn estimate(&self) -> Estimate {
        let off = self.off.estimate().state;
        Estimate::new(self.time, self.mixed(&self.kept[..self.len], &off))
    }

    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        let t = interval(self.time, time)?;
        let mut children = [Along::default(); CHILDREN];
        let count = self.children(t, &mut children);
        let off = self.off.predicted(time)?.state;
        Ok(Estimate::new(time, self.mixed(&children[..count], &off)))
    }

    fn update(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        let (z, r) = position_of(&Measurement::of(plot)?);
        self.take(plot.time, z, r, |off| off.update(plot))
    }

    fn update_manoeuvre(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        let (z, r) = position_of(&Measurement::of(plot)?);
        self.take(plot.time, z, r, |off| off.update_manoeuvre(plot))
    }

    /// Along the route the plots are taken as one: their mean, with the covariance of one plus their
    /// spread, divided by the probability that one of them is right.
    fn update_weighted(&mut self, plots: &[(&Plot, f64)]) -> Result<(), UpdateError> {
        let Some((first, _)) = plots.first() else { return Err(UpdateError::UnsoundPlot) };
        let sum: f64 = plots.iter().map(|p| p.1).sum();
        if sum.is_nan() || sum <= 0.0 {
            return Err(UpdateError::UnsoundPlot);
        }
        let mut all = super::mixtures::PositionMoments::about(first.position_m);
        for (plot, beta) in plots {
            let (z, r) = position_of(&Measurement::of(plot)?);
            all.add(*beta, z, r);
        }
        let (mean, cov) = all.moments();
        let r = Sym2 { xx: cov.xx / sum, xy: cov.xy / sum, yy: cov.yy / sum };
        self.take(first.time, mean, r, |off| {
            off.update_weighted(plots)?;
            Ok(Nis { d2: 2.0, det: r.xx * r.yy - r.xy * r.xy, dof: 2 })
        })?;
        Ok(())
    }

    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        self.time = time;
        self.off.replace(time, state);
        let weight = 1.0 - self.map.off_prior;
        self.find_on_map(state, weight);
    }

    fn start(&self) -> Start {
        self.start
    }
}

const _: () = assert!(MAX_MODES * 27 <= CHILDREN);

/// The rung `mh9-map`.
pub const MH9_MAP: Declared = Declared {
    word: "mh9-map",
    about: "9 histories and the taxiways",
    cost: 480,
    modes: Modes::mixed,
    histories: Some(0),
    start: |config, plot| {
        let (modes, start) = (Arc::clone(&config.modes), config.start);
        let Some(map) = &config.map else {
            return (super::imm::IMM3.start)(config, plot);
        };
        let filter = MapAided::from_plot(plot, Arc::clone(map), modes, start)?;
        Ok(Estimator::Map9(Box::new(filter)))
    },
};

#[cfg(test)]
mod laws;

#[cfg(test)]
mod tests {
    use super::super::testing::plot_at;
    use super::*;
    use crate::filter::route::{Edge, Route};

    fn straight_then_turn() -> Route {
        Route::from_course(Point2::origin(), 0.0).line(400.0, 0.0).arc(1.2, 60.0).line(400.0, 0.0)
    }

    fn on(map: MapKnowledge, plot: &Plot) -> MapAided<9> {
        MapAided::from_plot(plot, Arc::new(map), Arc::new(Modes::three()), Start::default())
            .unwrap()
    }

    #[test]
    fn a_target_on_its_route_is_held_there_through_the_turn() {
        let route = straight_then_turn();
        let mut filter =
            on(MapKnowledge::of(Network::single(route.clone())), &plot_at(0.0, 0.0, 0.0, 4.0));
        for k in 1..60 {
            let truth = route.at(12.0 * f64::from(k)).position;
            let error = if k % 2 == 0 { 1.5 } else { -1.5 };
            filter.update(&plot_at(f64::from(k), truth.x + error, truth.y - error, 4.0)).unwrap();
            assert!(filter.on_map() > 0.9, "scan {k}: {}", filter.on_map());
            if k > 10 {
                let off = (filter.estimate().position_m() - truth).norm();
                assert!(off < 1.6, "scan {k}: {off} m");
            }
        }
    }

    #[test]
    fn a_target_that_leaves_the_map_is_followed_and_found_again() {
        let route = Route::from_course(Point2::origin(), 0.0).line(4_000.0, 0.0);
        let mut filter = on(MapKnowledge::of(Network::single(route)), &plot_at(0.0, 0.0, 0.0, 4.0));
        // 30 m to the left between 300 m and 900 m, at 10 m/s.
        let truth = |t: f64| {
            let x = 10.0 * t;
            let ramp = ((x - 300.0) / 60.0).clamp(0.0, 1.0) - ((x - 900.0) / 60.0).clamp(0.0, 1.0);
            Point2::new(x, 30.0 * ramp)
        };
        let mut least: f64 = 1.0;
        for k in 1..=150 {
            let t = f64::from(k);
            let at = truth(t);
            filter.update(&plot_at(t, at.x, at.y, 4.0)).unwrap();
            assert!((filter.estimate().position_m() - at).norm() < 5.0, "scan {k}");
            if (40..=85).contains(&k) {
                least = least.min(filter.on_map());
            }
        }
        assert!(least < 1e-3, "30 m beside the line is not on it: {least}");
        assert!(filter.on_map() > 0.9, "back on the line: {}", filter.on_map());
    }

    #[test]
    fn at_a_junction_the_plots_choose_the_way() {
        let stem = Route::from_course(Point2::origin(), 0.0).line(200.0, 0.0);
        let end = Point2::new(200.0, 0.0);
        let ahead = Route::from_course(end, 0.0).line(400.0, 0.0);
        let left = Route::from_course(end, 0.0).arc(1.5, 50.0).line(400.0, 0.0);
        // The clearance says straight ahead; the target turns left.
        let network = Network {
            edges: vec![
                Edge { route: stem, next: vec![(1, 0.9), (2, 0.1)], width_m: 0.0 },
                Edge { route: ahead, next: vec![], width_m: 0.0 },
                Edge { route: left.clone(), next: vec![], width_m: 0.0 },
            ],
        };
        let mut filter = on(MapKnowledge::of(network), &plot_at(0.0, 0.0, 0.0, 4.0));
        for k in 1..40 {
            let s = 10.0 * f64::from(k);
            let at = if s < 200.0 { Point2::new(s, 0.0) } else { left.at(s - 200.0).position };
            filter.update(&plot_at(f64::from(k), at.x, at.y, 4.0)).unwrap();
            assert!((filter.estimate().position_m() - at).norm() < 4.0, "scan {k}");
        }
        assert!(filter.on_map() > 0.5);
        assert!(filter.kept[..filter.len].iter().all(|h| h.edge == 2));
    }

    #[test]
    fn a_deviation_that_persists_is_an_honest_error() {
        // 1.5 m beside the line all the time, plots of 3.3 m²: the claim must cover the error.
        let route = Route::from_course(Point2::origin(), 0.0).line(4_000.0, 0.0);
        let map = MapKnowledge { lateral_sigma_m: 1.5, ..MapKnowledge::of(Network::single(route)) };
        let mut filter = on(map, &plot_at(0.0, 0.0, 1.5, 3.3));
        for k in 1..120 {
            let t = f64::from(k);
            filter.update(&plot_at(t, 10.0 * t, 1.5, 3.3)).unwrap();
        }
        let estimate = filter.estimate();
        let sigma = estimate.position_cov_m2()[(1, 1)].sqrt();
        let error = (estimate.position_m().y - 1.5).abs();
        assert!(sigma > 0.3 && sigma < 1.2, "claims {sigma}");
        assert!(error < 3.0 * sigma, "error {error}, claims {sigma}");
    }
}
