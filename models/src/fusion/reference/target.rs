//! One target: what its rows are.
//!
//! Slow errors are numbers of the state where sensors of different kinds see the target, so that each shows what the others err
//! by. Where it is seen by radars alone, or by one sensor, nothing shows them, and what little a smoother would find of them is
//! noise: there they are only added to what is stated (Schmidt). As long as a target stands its echo lies off by the same.

mod learning;

use super::gathered::Gathered;
use super::linear::{Forwards, MOTION, Moment, Row, Smoothed, Start};
use super::shared::{OF_ECHO, OF_SITE, Shared};
use crate::frames::{Matrix2, Point2, Vector2};
use crate::fusion::config::TrackingConfig;
use crate::fusion::near_side::{self, EchoLaw};
use crate::plot::{Plot, SensorId};
use crate::time::SimTime;
use std::f64::consts::FRAC_2_PI;

/// Density of the acceleration to begin with, m²/s³.
const FIRST_Q: f64 = 1.0;
/// Density while the target stands, m²/s³, and the deviation of the velocity that is then none, m/s.
const STANDING_Q: f64 = 1e-6;
const STANDING_MPS: f64 = 0.05;
/// Sensors whose nearest plots are no farther apart than this are averaged, s.
const TOGETHER_S: f64 = 3.0;
/// The error of a receiver stays for this long at least, whatever is assumed on line: smoothing makes small lies large, s.
const LEAST_TAU_S: f64 = 100.0;
/// Deviations of the place and velocity before the first plot, m and m/s.
const START: (f64, f64) = (1e3, 50.0);

/// Slow errors of one sensor: two numbers of the state, of a late one three.
#[derive(Clone, Copy, Debug)]
struct Slow {
    sensor: SensorId,
    at: usize,
    tau_s: f64,
    /// Of a radar: it stays as long as the target shows it the same side.
    echo: bool,
    /// Where the delay of this target's reports stands, and its deviation, s.
    late: Option<(usize, f64)>,
}

impl Slow {
    fn count(&self) -> usize {
        2 + usize::from(self.late.is_some())
    }
}

/// A moment: with a plot, or one that is asked for.
#[derive(Clone, Copy, Debug)]
struct At {
    time: SimTime,
    plot: Option<usize>,
}

/// See the module's text.
#[derive(Debug)]
pub(super) struct Target<'a> {
    pub(super) gathered: &'a Gathered,
    config: &'a TrackingConfig,
    law: EchoLaw,
    /// Radars alone see it, or one sensor: what their slow errors are shows nowhere.
    pub(super) alone: bool,
    at: Vec<At>,
    slow: Vec<Slow>,
    /// Of each sensor: factors on the variances along and across.
    factors: Vec<(SensorId, [f64; 2])>,
    /// Of each moment.
    q: Vec<f64>,
    stands: Vec<bool>,
    /// It was held to stand, and did not.
    moves: Vec<bool>,
    velocity: Vec<Vector2<f64>>,
    /// Empty before anything is known.
    position: Vec<Point2<f64>>,
    course: Vec<Option<Vector2<f64>>>,
    /// Of each plot.
    weights: Vec<f64>,
}

impl<'a> Target<'a> {
    /// Of these plots; what is known is told at `asked` times too.
    pub(super) fn new(
        gathered: &'a Gathered,
        config: &'a TrackingConfig,
        law: EchoLaw,
        asked: &[SimTime],
    ) -> Self {
        let plots = &gathered.plots;
        let mut at: Vec<At> =
            plots.iter().enumerate().map(|(k, p)| At { time: p.time, plot: Some(k) }).collect();
        at.extend(asked.iter().map(|time| At { time: *time, plot: None }));
        at.sort_by_key(|a| (a.time, a.plot.is_none()));
        let (mut slow, mut factors): (Vec<Slow>, Vec<_>) = (Vec::new(), Vec::new());
        let first = plots.first().map(|p| p.sensor);
        let alone =
            plots.iter().all(|p| p.kind.radar) || plots.iter().all(|p| Some(p.sensor) == first);
        for plot in plots {
            if factors.iter().any(|(sensor, _)| *sensor == plot.sensor) {
                continue;
            }
            factors.push((plot.sensor, [1.0; 2]));
            let model = config.sensor(plot.sensor, plot.kind).sound();
            let of_law = law.wanders && law.residual_m > 0.0;
            let echo = plot.kind.radar;
            if alone {
                continue;
            }
            let late_s = if echo { 0.0 } else { model.late_sigma_s };
            let is_slow = if echo { of_law } else { model.slow_share > 0.0 || late_s > 0.0 };
            if is_slow {
                let tau_s =
                    if echo { law.residual_tau_s } else { model.slow_tau_s.max(LEAST_TAU_S) };
                let at = MOTION + slow.iter().map(Slow::count).sum::<usize>();
                let late = (late_s > 0.0).then_some((at + 2, late_s));
                slow.push(Slow { sensor: plot.sensor, at, tau_s, echo, late });
            }
        }
        let count = at.len();
        Self {
            gathered,
            config,
            law,
            alone,
            at,
            slow,
            factors,
            q: vec![FIRST_Q; count],
            stands: vec![false; count],
            moves: vec![false; count],
            velocity: vec![Vector2::zeros(); count],
            position: Vec::new(),
            course: vec![None; count],
            weights: vec![1.0; plots.len()],
        }
    }

    /// The way of the target; with the columns of the shared parameters, or with what is applied of them taken off.
    pub(super) fn moments(&self, shared: &Shared, columns: bool) -> Vec<Moment> {
        let mut before = self.at.first().map_or(SimTime(0), |a| a.time);
        let mut out = Vec::with_capacity(self.at.len());
        for (k, at) in self.at.iter().enumerate() {
            let after_s = at.time.since_s(before);
            before = at.time;
            let fade = self.slow.iter().flat_map(|s| {
                let stays = s.echo && self.stands[k];
                let fade = if stays { 1.0 } else { libm::exp(-after_s / s.tau_s) };
                [fade, fade, 1.0].into_iter().take(s.count())
            });
            let mut moment = Moment {
                after_s,
                q: if self.stands[k] { STANDING_Q } else { self.q[k] },
                fade: fade.collect(),
                rows: Vec::new(),
            };
            if let Some(index) = at.plot {
                self.rows(k, index, shared, columns, &mut moment.rows);
            }
            if self.stands[k] {
                for h in [1, 3] {
                    moment.rows.push(Row {
                        h: [(h, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)],
                        z: 0.0,
                        variance: STANDING_MPS * STANDING_MPS,
                        columns: Vec::new(),
                    });
                }
            }
            out.push(moment);
        }
        out
    }

    /// Where the way begins.
    pub(super) fn start(&self) -> Start {
        let place = self.gathered.plots.first().map_or([0.0; 2], |p| p.position_m.into());
        Start { place, sigma_m: START.0, sigma_mps: START.1 }
    }

    /// The way forwards and back, and when each moment is.
    pub(super) fn smoothed(&self, shared: &Shared) -> Option<Vec<Smoothed>> {
        let moments = self.moments(shared, false);
        Some(Forwards::of(&moments, self.start(), 0)?.back())
    }

    /// What slow errors of sensors that are alone add to the covariance of the place at a moment, m²: they are no states, as they
    /// stay for longer than plots are averaged. Of several radars by the weight that each has: `Σ A C Aᵀ`, `A = (Σ R⁻¹)⁻¹ R⁻¹`.
    pub(super) fn left_m2(&self, k: usize) -> Matrix2<f64> {
        if !self.alone {
            return Matrix2::zeros();
        }
        let time = self.at[k].time;
        let off = |p: &Plot| p.time.since_s(time).abs();
        let (mut parts, mut whole) = (Vec::new(), Matrix2::zeros());
        let least = self.factors.iter().filter_map(|f| self.nearest(f.0, time)).map(off);
        let least = least.fold(f64::INFINITY, f64::min);
        for (sensor, factors) in &self.factors {
            let Some(plot) = self.nearest(*sensor, time) else { continue };
            if off(plot) > least + TOGETHER_S {
                continue;
            }
            let sigma = if plot.polar.is_some() {
                self.echo(plot, plot.axis, k, *factors).sigma_m
            } else {
                let share = self.config.sensor(plot.sensor, plot.kind).sound().slow_share;
                [plot.along_m2, plot.across_m2].map(|v| (share * v).sqrt())
            };
            let stated = [plot.along_m2 * factors[0], plot.across_m2 * factors[1]];
            let turned = |[a, c]: [f64; 2]| {
                let across = plot.across_axis();
                plot.axis * plot.axis.transpose() * a + across * across.transpose() * c
            };
            let information = turned(stated.map(|v| 1.0 / v));
            let square = sigma.map(|s| if s.is_finite() { s * s } else { 0.0 });
            parts.push((information, turned(square)));
            whole += information;
        }
        let Some(inverse) = whole.try_inverse() else { return Matrix2::zeros() };
        let of = |(w, c): &(Matrix2<f64>, Matrix2<f64>)| inverse * w * c * w * inverse;
        parts.iter().map(of).fold(Matrix2::zeros(), |a, b| a + b)
    }

    /// The plot of a sensor that is nearest in time.
    fn nearest(&self, sensor: SensorId, time: SimTime) -> Option<&Plot> {
        let plots = &self.gathered.plots;
        let after = plots.partition_point(|p| p.time < time);
        let own = |p: &&Plot| p.sensor == sensor;
        let later = plots[after..].iter().find(own);
        let earlier = plots[..after].iter().rev().find(own);
        let off = |p: &Plot| p.time.since_s(time).abs();
        match (earlier, later) {
            (Some(a), Some(b)) => Some(if off(a) <= off(b) { a } else { b }),
            (a, b) => a.or(b),
        }
    }

    /// Times of the moments; whether each was asked for.
    pub(super) fn times(&self) -> impl Iterator<Item = (SimTime, bool)> {
        self.at.iter().map(|at| (at.time, at.plot.is_none()))
    }

    pub(super) fn stands(&self, k: usize) -> bool {
        self.stands[k]
    }

    fn rows(&self, k: usize, index: usize, shared: &Shared, columns: bool, out: &mut Vec<Row>) {
        let plot = &self.gathered.plots[index];
        let weight = self.weights[index];
        let factors = self.factors.iter().find(|f| f.0 == plot.sensor).map_or([1.0; 2], |f| f.1);
        let slow = self.slow.iter().find(|s| s.sensor == plot.sensor);
        let axis = self.line_of_sight(plot, k, shared);
        let echo = plot.polar.is_some().then(|| self.echo(plot, axis, k, factors));
        let share = if echo.is_some() {
            0.0
        } else {
            self.config.sensor(plot.sensor, plot.kind).sound().slow_share.clamp(0.0, 0.999)
        };
        let stated = [plot.along_m2, plot.across_m2];
        for (side, u) in [axis, Vector2::new(axis.y, -axis.x)].into_iter().enumerate() {
            if !stated[side].is_finite() {
                continue;
            }
            let slope = match (&echo, slow) {
                (_, None) => 0.0,
                (Some(echo), _) => echo.sigma_m[side],
                (None, _) => (share * stated[side]).sqrt(),
            };
            let mut z = u.dot(&plot.position_m.coords);
            let mut own = Vec::new();
            if let Some(echo) = &echo {
                if side == 0 {
                    z += echo.offset_m;
                }
                own = self.columns(plot, k, echo, [axis, u], shared);
                if !columns {
                    z -= own.iter().enumerate().map(|(k, j)| j * shared.applied(k)).sum::<f64>();
                    own = Vec::new();
                }
            }
            out.push(Row {
                h: [
                    (0, u.x),
                    (2, u.y),
                    slow.map_or((0, 0.0), |s| (s.at + side, slope)),
                    slow.and_then(|s| s.late)
                        .map_or((0, 0.0), |(at, late_s)| (at, -late_s * u.dot(&self.velocity[k]))),
                ],
                z,
                variance: (1.0 - share) * stated[side] * factors[side] / weight,
                columns: own,
            });
        }
    }

    /// The line of sight to where the target was by what is known of it. Along that to the plot a radar's error would turn the
    /// directions in which it is counted: a place nearer to the radar explains away what echoes wander across, by metres in an hour
    /// of standing, wherever an error along is free.
    fn line_of_sight(&self, plot: &Plot, k: usize, shared: &Shared) -> Vector2<f64> {
        let site_m = plot.polar.and_then(|_| shared.site_m(plot.sensor));
        let (Some(site_m), Some(at_m)) = (site_m, self.position.get(k)) else { return plot.axis };
        let axis = (at_m - site_m).try_normalize(1.0).unwrap_or(plot.axis);
        if axis.dot(&plot.axis) > 0.0 { axis } else { plot.axis }
    }

    /// What the shared parameters do to a plot along `u`, each in its unit.
    fn columns(
        &self,
        plot: &Plot,
        k: usize,
        echo: &Echo,
        [axis, u]: [Vector2<f64>; 2],
        shared: &Shared,
    ) -> Vec<f64> {
        let mut own = vec![0.0; shared.count()];
        let ground_m = plot.polar.map_or(0.0, |p| p.range_m);
        let of = near_side::derivatives(
            axis,
            ground_m,
            if self.stands[k] { Vector2::zeros() } else { self.velocity[k] },
            (echo.half_extent_m, 0.0),
        );
        if let Some(site) =
            shared.site(plot.sensor).filter(|_| near_side::on_ground(self.velocity[k]))
        {
            (0..OF_SITE).for_each(|m| own[site + m] = u.dot(&of[m]));
        }
        let vehicle = self.gathered.body.is_some_and(|b| b.vehicle);
        own[shared.count() - OF_ECHO + usize::from(vehicle)] = u.dot(&of[3]);
        own.iter_mut().enumerate().for_each(|(k, j)| *j *= shared.unit(k).0);
        own
    }

    /// How the echo of a plot lies.
    fn echo(&self, plot: &Plot, axis: Vector2<f64>, k: usize, factors: [f64; 2]) -> Echo {
        if !self.law.wanders {
            return Echo { offset_m: 0.0, half_extent_m: 0.0, sigma_m: [0.0; 2] };
        }
        let (law, course) = (&self.law, self.course[k]);
        let Some(body) = self.gathered.body else {
            let variance_m2 = 0.5 * (plot.along_m2 * factors[0] + plot.across_m2 * factors[1]);
            let triples = self.gathered.plots.len() as f64;
            let (offset_m, along) = law.offset_of_unknown_m(variance_m2, triples, course, axis);
            let across = law.across_of_unknown_m(variance_m2, triples);
            return Echo { offset_m, half_extent_m: 0.0, sigma_m: [along, across] };
        };
        let kappa = law.of(&body);
        let seen = course.map_or_else(
            || (FRAC_2_PI * 0.5 * body.length_m, FRAC_2_PI * 0.5 * body.span_m),
            |course| near_side::half_extents_m(&body, axis, course),
        );
        let open = if course.is_some() { 0.0 } else { kappa.mean_offset_m(&body).1 };
        let along = libm::hypot(open, law.residual_m);
        Echo {
            offset_m: kappa.offset_m(seen),
            half_extent_m: kappa.joint_half_extent_m(seen),
            sigma_m: [along, law.across_m(Some(&body))],
        }
    }
}

/// How an echo lies: towards the radar, the half extent that the law's number counts, deviations of what is left.
#[derive(Clone, Copy, Debug)]
struct Echo {
    offset_m: f64,
    half_extent_m: f64,
    sigma_m: [f64; 2],
}
