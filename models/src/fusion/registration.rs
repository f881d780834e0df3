//! Errors of radar sites and of echoes, estimated together from targets that report their own position.
//!
//! `δ = J θ + v`, `θ` = (range bias, azimuth bias, time offset) of each site and (κ of aircraft, κ of vehicles) of all,
//! `J = (e_r, d e_c, −velocity, −h e_r)` (see [`super::near_side`]): `Λ += JᵀJ/r`, `y += Jᵀδ/r`, along and across the line of
//! sight, `θ̂ = Λ⁻¹y`. A reporting target's own error is slow, so its pairs are not independent: about one counts in
//! 2τ/T. What is known ages, so that a site may be moved.
//!
//! The near side of an echo is not an error of the site: one vehicle's 0.9 m and a heavy jet's 4 m, taken for a bias of the
//! range, would be taken off everything else.

use super::near_side::{self, Body, EchoLaw};
use super::on_lanes;
use crate::filter::route::Network;
use crate::frames::{Point2, Vector2};
use crate::plot::{Plot, SensorId};
use crate::time::SimTime;

/// Parameters of one site: range (m), azimuth (rad), time (s).
const OF_SITE: usize = 3;
/// Parameters of all sites: κ of aircraft, of vehicles.
const OF_ECHO: usize = 2;

/// Most radars whose errors are estimated.
const MOST_SITES: usize = 16;

/// What is assumed of a site and of echoes before anything is seen, standard deviations (assumed).
const PRIOR_SITE: [f64; OF_SITE] = [3.0, 2e-3, 0.2];
const PRIOR_ECHO: [f64; OF_ECHO] = [0.02, 0.1];

/// What is known is half forgotten after 1250 s: Λ is drawn back to the prior with this time constant, s.
const AGEING_S: f64 = 1800.0;

/// A report may be this long before or after a radar plot that is held against it, s.
const OLDEST_REFERENCE_S: f64 = 1.5;

/// Radar plots that are kept between two reports of a target.
const MOST_WAITING: usize = 4;

/// Acceleration that bends the way between two reports, m/s² (assumed, rms).
const ACCELERATION_MPS2: f64 = 1.0;

/// Slower than this a target stands, m/s.
const STANDS_MPS: f64 = 0.5;
/// Faster than this it drives, m/s, and shows other sides: its echo lies off across the line of sight by half as much (measured).
const DRIVES_MPS: f64 = 2.0;

/// A pair more than so many standard deviations off (with the prior's uncertainty) is of something else.
const FARTHEST_SIGMA: f64 = 4.0;

/// A parameter is applied once its deviation has come below this share of the prior's.
const KNOWN_SHARE: f64 = 0.5;

/// What was found is applied less so many of its own variances over its square.
const STANDS_OUT: f64 = 2.0;

/// One pair as the law of the estimate sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Unit vector of the line of sight.
    pub axis: Vector2<f64>,
    /// Ground distance, m.
    pub ground_m: f64,
    /// Velocity of the target, m/s.
    pub velocity_mps: Vector2<f64>,
    /// The target is a vehicle.
    pub vehicle: bool,
    /// Half extent that is seen, see [`near_side::Kappa::joint_half_extent_m`], m; 0 where it is not known.
    pub half_extent_m: f64,
    /// Variances of the difference along and across, m².
    pub variance_m2: [f64; 2],
    /// Plot less reference, m.
    pub delta_m: Vector2<f64>,
}

/// Joint estimate of the parameters of all sites, in units of the prior's deviations.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    mean: Vec<f64>,
    scale: Vec<f64>,
    information: Vec<f64>,
    vector: Vec<f64>,
    /// θ̂ less the prior's mean, and its covariance; both of the time of [`Self::solve`].
    estimate: Vec<f64>,
    covariance: Vec<f64>,
}

impl Joint {
    /// Nothing seen yet: `sites` times (range, azimuth, time), then κ of aircraft and of vehicles.
    #[must_use]
    pub fn new(mean: &[f64], sigma: &[f64]) -> Self {
        let n = mean.len();
        let mut joint = Self {
            mean: mean.to_vec(),
            scale: sigma.to_vec(),
            information: identity(n),
            vector: vec![0.0; n],
            estimate: vec![0.0; n],
            covariance: identity(n),
        };
        joint.solve();
        joint
    }

    fn count(&self) -> usize {
        self.mean.len()
    }

    /// The two rows of J of a pair seen by `site`, in units of the prior.
    fn rows(&self, site: usize, pair: &Pair) -> [Vec<f64>; 2] {
        let n = self.count();
        let [range, azimuth, time, length, _] = near_side::derivatives(
            pair.axis,
            pair.ground_m,
            pair.velocity_mps,
            (pair.half_extent_m, 0.0),
        );
        let across = Vector2::new(pair.axis.y, -pair.axis.x);
        [pair.axis, across].map(|u| {
            let mut row = vec![0.0; n];
            for (k, column) in [range, azimuth, time].iter().enumerate() {
                row[OF_SITE * site + k] = u.dot(column);
            }
            row[n - OF_ECHO + usize::from(pair.vehicle)] = u.dot(&length);
            row.iter_mut().zip(&self.scale).for_each(|(j, s)| *j *= s);
            row
        })
    }

    /// Whether a pair of `site` may be what it seems: within four deviations of what the prior foresees.
    #[must_use]
    pub fn fits(&self, site: usize, pair: &Pair) -> bool {
        let rows = self.rows(site, pair);
        let found = self.news(&rows, pair);
        (0..2).all(|k| {
            let spread = rows[k].iter().map(|j| j * j).sum::<f64>() + pair.variance_m2[k];
            found[k] * found[k] <= FARTHEST_SIGMA * FARTHEST_SIGMA * spread
        })
    }

    /// Takes a pair of `site`; [`Self::solve`] shows it.
    pub fn learn(&mut self, site: usize, pair: &Pair) {
        let rows = self.rows(site, pair);
        let found = self.news(&rows, pair);
        self.add(&rows, found, pair.variance_m2);
    }

    /// Takes what a pair of `site` says along a direction alone, off a lane: its variance grows with what it is off the estimate
    /// ([`on_lanes::variance_m2`]). Whether it was taken: within four deviations of what the prior foresees.
    fn learn_along(&mut self, site: usize, pair: &Pair, direction: Vector2<f64>) -> bool {
        let rows = self.rows(site, pair);
        let across = Vector2::new(pair.axis.y, -pair.axis.x);
        let part = [direction.dot(&pair.axis), direction.dot(&across)];
        let news = self.news(&rows, pair);
        let row: Vec<f64> =
            rows[0].iter().zip(&rows[1]).map(|(a, b)| part[0] * a + part[1] * b).collect();
        let found = part[0] * news[0] + part[1] * news[1];
        let spread: f64 = part.iter().zip(pair.variance_m2).map(|(p, v)| p * p * v).sum();
        let foreseen: f64 = row.iter().zip(&self.estimate).map(|(j, e)| j * e).sum();
        let variance = on_lanes::variance_m2(found - foreseen, spread);
        let of_prior = row.iter().map(|j| j * j).sum::<f64>() + on_lanes::variance_m2(0.0, spread);
        let fits = found * found <= FARTHEST_SIGMA * FARTHEST_SIGMA * of_prior;
        if fits {
            self.add(&[row.clone(), row], [found, 0.0], [variance, f64::INFINITY]);
        }
        fits
    }

    /// What a pair says beyond what the prior's mean foresees, along and across, m.
    fn news(&self, rows: &[Vec<f64>; 2], pair: &Pair) -> [f64; 2] {
        let across = Vector2::new(pair.axis.y, -pair.axis.x);
        let axes = [pair.axis, across];
        [0, 1].map(|k| {
            let foreseen: f64 =
                rows[k].iter().zip(&self.mean).zip(&self.scale).map(|((j, m), s)| j * m / s).sum();
            axes[k].dot(&pair.delta_m) - foreseen
        })
    }

    fn add(&mut self, rows: &[Vec<f64>; 2], found: [f64; 2], variance_m2: [f64; 2]) {
        let n = self.count();
        for k in 0..2 {
            let weight = 1.0 / variance_m2[k];
            if !(weight > 0.0 && weight.is_finite()) {
                continue;
            }
            for i in 0..n {
                self.vector[i] += weight * rows[k][i] * found[k];
                for j in 0..n {
                    self.information[n * i + j] += weight * rows[k][i] * rows[k][j];
                }
            }
        }
    }

    /// Draws what is known back to the prior.
    fn age(&mut self, seconds: f64) {
        let (n, kept) = (self.count(), libm::exp(-seconds.max(0.0) / AGEING_S));
        for i in 0..n {
            self.vector[i] *= kept;
            for j in 0..n {
                let prior = if i == j { 1.0 - kept } else { 0.0 };
                self.information[n * i + j] = kept * self.information[n * i + j] + prior;
            }
        }
    }

    /// `θ̂ = Λ⁻¹ y` and Λ⁻¹, by L D Lᵀ.
    pub fn solve(&mut self) {
        let n = self.count();
        let (mut l, mut d) = (self.information.clone(), vec![0.0; n]);
        for j in 0..n {
            let mut pivot = l[n * j + j];
            for k in 0..j {
                pivot -= l[n * j + k] * l[n * j + k] * d[k];
            }
            d[j] = pivot;
            for i in j + 1..n {
                let mut sum = l[n * i + j];
                for k in 0..j {
                    sum -= l[n * i + k] * l[n * j + k] * d[k];
                }
                l[n * i + j] = sum / pivot;
            }
        }
        let solve = |b: &[f64]| {
            let mut x = b.to_vec();
            for i in 0..n {
                for k in 0..i {
                    x[i] -= l[n * i + k] * x[k];
                }
            }
            for i in 0..n {
                x[i] /= d[i];
            }
            for i in (0..n).rev() {
                for k in i + 1..n {
                    x[i] -= l[n * k + i] * x[k];
                }
            }
            x
        };
        self.estimate = solve(&self.vector);
        let unit = identity(n);
        for j in 0..n {
            let column = solve(&unit[n * j..n * (j + 1)]);
            (0..n).for_each(|i| self.covariance[n * i + j] = column[i]);
        }
    }

    /// Estimate and standard deviation of a parameter.
    #[must_use]
    pub fn parameter(&self, k: usize) -> (f64, f64) {
        let n = self.count();
        let sigma = self.scale[k] * self.covariance[n * k + k].max(0.0).sqrt();
        (self.mean[k] + self.scale[k] * self.estimate[k], sigma)
    }

    /// Correlation of the errors of two parameters.
    #[must_use]
    pub fn correlation(&self, i: usize, j: usize) -> f64 {
        let n = self.count();
        let at = |i: usize, j: usize| self.covariance[n * i + j];
        at(i, j) / (at(i, i) * at(j, j)).sqrt()
    }

    /// The estimate as it is applied: the prior's mean until it is known, and no more of what was found than stands out of
    /// its own uncertainty. Sites are surveyed: most have no error that could be found, and half a milliradian of noise,
    /// taken off every plot, is 1.5 m at 3 km.
    fn applied(&self, k: usize) -> f64 {
        let n = self.count();
        let (found, variance) = (self.estimate[k], self.covariance[n * k + k].max(0.0));
        if variance.sqrt() >= KNOWN_SHARE || found == 0.0 {
            return self.mean[k];
        }
        let kept = (1.0 - STANDS_OUT * variance / (found * found)).max(0.0);
        self.mean[k] + self.scale[k] * kept * found
    }

    /// One site more, before the echo's parameters.
    fn with_site(&self) -> Self {
        let (n, at) = (self.count(), self.count() - OF_ECHO);
        let place = |i: usize| if i < at { i } else { i + OF_SITE };
        let m = n + OF_SITE;
        let mut wide = Self::new(&vec![0.0; m], &vec![1.0; m]);
        wide.scale[at..at + OF_SITE].copy_from_slice(&PRIOR_SITE);
        for i in 0..n {
            wide.mean[place(i)] = self.mean[i];
            wide.scale[place(i)] = self.scale[i];
            wide.vector[place(i)] = self.vector[i];
            for j in 0..n {
                wide.information[m * place(i) + place(j)] = self.information[n * i + j];
            }
        }
        wide.solve();
        wide
    }
}

fn identity(n: usize) -> Vec<f64> {
    let mut unit = vec![0.0; n * n];
    (0..n).for_each(|k| unit[n * k + k] = 1.0);
    unit
}

/// What is known of the errors of all radars and echoes.
#[derive(Clone, Debug)]
pub(super) struct Registration {
    sites: Vec<SensorId>,
    law: EchoLaw,
    joint: Joint,
    aged: Option<SimTime>,
    changed: bool,
}

/// A target's own report, kept to compare radar plots with.
#[derive(Clone, Debug)]
pub(super) struct Reference {
    pub(super) time: SimTime,
    pub(super) position_m: Point2<f64>,
    /// Variance per axis, m².
    pub(super) variance_m2: f64,
    /// Pairs that count as one: 2τ/T, at least 1.
    pub(super) repeats: f64,
    /// Radar plots of the target since then.
    waiting: Vec<Waiting>,
}

impl Reference {
    /// A report without plots.
    pub(super) fn new(
        time: SimTime,
        position_m: Point2<f64>,
        variance_m2: f64,
        repeats: f64,
    ) -> Self {
        Self { time, position_m, variance_m2, repeats, waiting: Vec::new() }
    }

    /// Keeps a radar plot until the target's next report; more than a few say nothing more.
    pub(super) fn keep(&mut self, waiting: Waiting) {
        if self.waiting.len() < MOST_WAITING {
            self.waiting.push(waiting);
        }
    }
}

/// A radar plot that waits for the target's next report.
#[derive(Clone, Debug)]
pub(super) struct Waiting {
    /// As it was measured, but for `taken_off_m`.
    pub(super) plot: Plot,
    /// What had been taken off it.
    pub(super) taken_off_m: Vector2<f64>,
    /// Velocity of the track.
    pub(super) velocity_mps: Vector2<f64>,
    /// Of the target, where it is known.
    pub(super) body: Option<Body>,
    /// Of the target, where it is known.
    pub(super) course: Option<Vector2<f64>>,
    /// Between two looks of the radar, s.
    pub(super) interval_s: f64,
}

/// What is known of where the echo of a target lies.
struct OfBody {
    /// Half extent that κ multiplies, m; 0 where it is not known.
    half_extent_m: f64,
    /// Mean offset towards the radar where it is not, m.
    mean_m: f64,
    /// What is left of it along and across the line of sight, standard deviations, m.
    left_m: [f64; 2],
}

/// Bias of a radar with its standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SiteBias {
    /// The radar.
    pub sensor: SensorId,
    /// Measured minus true range, m.
    pub range_m: f64,
    /// Its standard deviation, m.
    pub sigma_range_m: f64,
    /// Measured minus true azimuth, rad.
    pub azimuth_rad: f64,
    /// Its standard deviation, rad.
    pub sigma_azimuth_rad: f64,
    /// Stamp minus true time, s.
    pub time_s: f64,
    /// Its standard deviation, s.
    pub sigma_time_s: f64,
}

impl Registration {
    pub(super) fn new(law: EchoLaw) -> Self {
        let mean = [law.aircraft.length, law.vehicle.length];
        let joint = Joint::new(&mean, &PRIOR_ECHO);
        Self { sites: Vec::new(), law, joint, aged: None, changed: false }
    }

    /// What is known up to now holds for the scan that begins.
    pub(super) fn begin(&mut self, now: SimTime) {
        if let Some(before) = self.aged
            && !self.sites.is_empty()
        {
            self.joint.age(now.since_s(before));
        }
        self.aged = Some(now);
        if std::mem::take(&mut self.changed) {
            self.joint.solve();
            self.law.aircraft = self.kappa(0, self.law.aircraft);
            self.law.vehicle = self.kappa(1, self.law.vehicle);
        }
    }

    /// The numbers of a kind of body as they are known now, in the ratio that is assumed.
    fn kappa(&self, kind: usize, before: near_side::Kappa) -> near_side::Kappa {
        let length = self.joint.applied(self.joint.count() - OF_ECHO + kind).max(0.0);
        let ratio = if before.length > 0.0 { before.span / before.length } else { 0.0 };
        near_side::Kappa { length, span: ratio * length }
    }

    /// The law of echoes with what was learnt.
    pub(super) fn law(&self) -> &EchoLaw {
        &self.law
    }

    /// Holds the radar plots between two reports of one target against the straight way from the one to the other: no
    /// estimate of its speed is needed, which lags where a target accelerates and would be taken for an error of the clock.
    pub(super) fn learn(&mut self, before: &Reference, after: &Reference) {
        for waiting in &before.waiting {
            let Some(pair) = self.pair(waiting, before, after) else { continue };
            let Some(site) = self.site(waiting.plot.sensor) else { return };
            if self.joint.fits(site, &pair) {
                self.joint.learn(site, &pair);
                self.changed = true;
            }
        }
    }

    /// Holds a radar plot against the lane that its target keeps to; whether there was one.
    pub(super) fn learn_lane(&mut self, waiting: &Waiting, lanes: &Network) -> bool {
        let Waiting { plot, taken_off_m, velocity_mps, .. } = waiting;
        let Some(polar) = plot.polar.filter(|p| p.range_m > 1.0) else { return false };
        let found = on_lanes::beside(lanes, plot.position_m, *velocity_mps);
        let Some((normal, off_m)) = found else { return false };
        let Some(site) = self.site(plot.sensor) else { return false };
        let of = self.of_body(waiting);
        let pair = Pair {
            axis: plot.axis,
            ground_m: polar.range_m,
            velocity_mps: *velocity_mps,
            vehicle: waiting.body.as_ref().is_some_and(|b| b.vehicle),
            half_extent_m: of.half_extent_m,
            variance_m2: [
                plot.along_m2 + of.left_m[0] * of.left_m[0],
                plot.across_m2 + of.left_m[1] * of.left_m[1],
            ],
            delta_m: normal * off_m + taken_off_m + plot.axis * of.mean_m,
        };
        self.changed |= self.joint.learn_along(site, &pair, normal);
        true
    }

    /// What is known of where the echo of a target lies.
    fn of_body(&self, waiting: &Waiting) -> OfBody {
        let Waiting { plot, body, course, velocity_mps, .. } = waiting;
        let (mean_m, along_m) = self.law.offset_m(body.as_ref(), *course, plot.axis);
        let drives = velocity_mps.norm_squared() > DRIVES_MPS * DRIVES_MPS;
        let across_m = self.law.across_m(body.as_ref()) * if drives { 0.5 } else { 1.0 };
        let left_m = [along_m, across_m];
        match (body, course) {
            (Some(body), Some(course)) => {
                let seen = near_side::half_extents_m(body, plot.axis, *course);
                let half_extent_m = self.law.of(body).joint_half_extent_m(seen);
                OfBody { half_extent_m, mean_m: 0.0, left_m }
            }
            // The mean offset is taken off: what it may be wrong by tells nothing of κ.
            _ => OfBody { half_extent_m: 0.0, mean_m, left_m },
        }
    }

    fn pair(&self, waiting: &Waiting, before: &Reference, after: &Reference) -> Option<Pair> {
        let Waiting { plot, body, velocity_mps, interval_s, .. } = waiting;
        let polar =
            plot.polar.filter(|p| p.range_m > 1.0 && near_side::on_ground(*velocity_mps))?;
        let (gap_s, dt_s) = (after.time.since_s(before.time), plot.time.since_s(before.time));
        let left_s = gap_s - dt_s;
        let near = |s: f64| (0.0..=OLDEST_REFERENCE_S).contains(&s);
        if !(gap_s > 0.0 && near(dt_s) && near(left_s)) {
            return None;
        }
        let u = dt_s / gap_s;
        let expected = before.position_m + (after.position_m - before.position_m) * u;
        let bent_m = 0.5 * ACCELERATION_MPS2 * dt_s * left_s;
        let report = |r: &Reference, share: f64| share * share * r.variance_m2 * r.repeats;
        let report = report(before, 1.0 - u) + report(after, u) + bent_m * bent_m;
        let of = self.of_body(waiting);
        let delta_m = plot.position_m + waiting.taken_off_m - expected + plot.axis * of.mean_m;
        // What the law leaves is slow, as the error of the report is: the same echo as long as the target stands.
        let stands = velocity_mps.norm_squared() < STANDS_MPS * STANDS_MPS;
        let tau_s = if stands { AGEING_S } else { self.law.residual_tau_s };
        let repeats = (2.0 * tau_s / interval_s.max(1e-3)).max(1.0);
        let slow = of.left_m.map(|left_m| left_m * left_m * repeats);
        Some(Pair {
            axis: plot.axis,
            ground_m: polar.range_m,
            velocity_mps: if stands { Vector2::zeros() } else { *velocity_mps },
            vehicle: body.as_ref().is_some_and(|b| b.vehicle),
            half_extent_m: of.half_extent_m,
            variance_m2: [plot.along_m2 + slow[0] + report, plot.across_m2 + slow[1] + report],
            delta_m,
        })
    }

    /// What is taken off every plot of a radar before anything is known of its target, m: the site's errors.
    pub(super) fn correction_m(&self, plot: &Plot) -> Vector2<f64> {
        let site = self.sites.iter().position(|id| *id == plot.sensor);
        let (Some(polar), Some(site)) = (plot.polar, site) else { return Vector2::zeros() };
        let [range, azimuth] = [0, 1].map(|k| self.joint.applied(OF_SITE * site + k));
        plot.axis * range + plot.across_axis() * (polar.range_m * azimuth)
    }

    /// How late a radar's stamps are, s.
    pub(super) fn late_s(&self, sensor: SensorId) -> f64 {
        let site = self.sites.iter().position(|id| *id == sensor);
        site.map_or(0.0, |site| self.joint.applied(OF_SITE * site + 2))
    }

    /// The estimate for one radar, if any pair was seen.
    pub(super) fn bias(&self, sensor: SensorId) -> Option<SiteBias> {
        let site = self.sites.iter().position(|id| *id == sensor)?;
        let [range, azimuth, time] = [0, 1, 2].map(|k| self.joint.parameter(OF_SITE * site + k));
        Some(SiteBias {
            sensor,
            range_m: range.0,
            sigma_range_m: range.1,
            azimuth_rad: azimuth.0,
            sigma_azimuth_rad: azimuth.1,
            time_s: time.0,
            sigma_time_s: time.1,
        })
    }

    /// All estimates.
    pub(super) fn biases(&self) -> Vec<SiteBias> {
        self.sites.iter().filter_map(|id| self.bias(*id)).collect()
    }

    fn site(&mut self, sensor: SensorId) -> Option<usize> {
        let found = self.sites.iter().position(|id| *id == sensor);
        if found.is_none() && self.sites.len() < MOST_SITES {
            self.sites.push(sensor);
            self.joint = self.joint.with_site();
            return Some(self.sites.len() - 1);
        }
        found
    }
}

#[cfg(test)]
mod tests;
