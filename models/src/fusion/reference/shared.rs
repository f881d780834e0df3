//! Parameters that all targets share: errors of each radar's site and clock, and the law of echoes.
//!
//! What the smoothers of all targets say of them is Gaussian ([`super::linear`]). A site is surveyed: of each of its errors it is
//! as likely that there is none as that there is one of the prior's size, so all choices of errors are weighed by their
//! evidence, and what is applied is the mean over them (Hoeting, Madigan, Raftery, Volinsky, Statistical Science 14, 1999).

use crate::frames::{Matrix2, Point2, Vector2};
use crate::fusion::near_side::EchoLaw;
use crate::plot::{Plot, SensorId};

/// Parameters of one site: range (m), azimuth (rad), time (s).
pub(super) const OF_SITE: usize = 3;
/// Parameters of all sites: κ of aircraft, of vehicles.
pub(super) const OF_ECHO: usize = 2;

/// Deviations of errors that are there (assumed, as on line).
const PRIOR_SITE: [f64; OF_SITE] = [3.0, 2e-3, 0.2];
const PRIOR_ECHO: [f64; OF_ECHO] = [0.02, 0.1];
/// Probability that a site has one of its errors (assumed).
const THERE: f64 = 0.5;
/// More errors than this are not weighed one by one: all are taken to be there.
const MOST_WEIGHED: usize = 9;
/// A parameter whose deviation is more than this share of the prior's is not known: nothing is applied.
const KNOWN_SHARE: f64 = 0.5;
/// Lines of sight that spread less than this (mean square of the sine about their middle) do not say where they meet.
const LEAST_SPREAD: f64 = 1e-3;

/// One parameter as it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Estimate; where it is not known, what is assumed in its place.
    pub value: f64,
    /// Standard deviation of the estimate; that of the prior where nothing was seen.
    pub sigma: f64,
    /// Whether it was found well enough to be applied; else trajectories are what the sensor says in this respect.
    pub known: bool,
}

/// Errors of one radar: measured less true.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SiteFound {
    /// Which radar.
    pub sensor: SensorId,
    /// Range, m.
    pub range_m: Found,
    /// Azimuth, rad.
    pub azimuth_rad: Found,
    /// How late its stamps are, s.
    pub time_s: Found,
}

/// Where a radar stands by its own plots, m: where their lines of sight meet, `Σ(I − aaᵀ) s = Σ(I − aaᵀ) p`; none where they are
/// all one.
pub(super) fn meeting_m<'a>(plots: impl Iterator<Item = &'a Plot>) -> Option<Point2<f64>> {
    let (mut left, mut right, mut count) = (Matrix2::zeros(), Vector2::zeros(), 0.0);
    for plot in plots {
        let beside = Matrix2::identity() - plot.axis * plot.axis.transpose();
        left += beside;
        right += beside * plot.position_m.coords;
        count += 1.0;
    }
    let least = left.symmetric_eigenvalues().min();
    (least > LEAST_SPREAD * count)
        .then(|| left.try_inverse().map(|inverse| Point2::from(inverse * right)))?
}

/// All shared parameters.
#[derive(Clone, Debug)]
pub(super) struct Shared {
    sites: Vec<(SensorId, Option<Point2<f64>>)>,
    /// Prior: mean and deviation.
    mean: Vec<f64>,
    scale: Vec<f64>,
    /// Estimate and covariance in units of the prior, less its mean.
    estimate: Vec<f64>,
    covariance: Vec<f64>,
}

impl Shared {
    /// Of these radars, each where it stands if that is known; nothing seen yet.
    pub(super) fn new(sites: Vec<(SensorId, Option<Point2<f64>>)>, law: &EchoLaw) -> Self {
        let n = OF_SITE * sites.len() + OF_ECHO;
        let (mut mean, mut scale) = (vec![0.0; n], vec![1.0; n]);
        for site in 0..sites.len() {
            scale[OF_SITE * site..OF_SITE * (site + 1)].copy_from_slice(&PRIOR_SITE);
        }
        mean[n - OF_ECHO..].copy_from_slice(&[law.aircraft.length, law.vehicle.length]);
        scale[n - OF_ECHO..].copy_from_slice(&PRIOR_ECHO);
        let mut covariance = vec![0.0; n * n];
        (0..n).for_each(|i| covariance[n * i + i] = 1.0);
        Self { sites, mean, scale, estimate: vec![0.0; n], covariance }
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.mean.len()
    }

    /// Where the parameters of a radar begin.
    pub(super) fn site(&self, sensor: SensorId) -> Option<usize> {
        self.sites.iter().position(|s| s.0 == sensor).map(|site| OF_SITE * site)
    }

    /// Where a radar stands, m.
    pub(super) fn site_m(&self, sensor: SensorId) -> Option<Point2<f64>> {
        self.sites.iter().find(|s| s.0 == sensor)?.1
    }

    /// The unit in which a parameter is counted, and its prior mean.
    pub(super) fn unit(&self, k: usize) -> (f64, f64) {
        (self.scale[k], self.mean[k])
    }

    /// What is applied of a parameter, in its unit and less its prior mean.
    pub(super) fn applied(&self, k: usize) -> f64 {
        if self.known(k) { self.estimate[k] } else { 0.0 }
    }

    fn known(&self, k: usize) -> bool {
        let n = self.count();
        self.covariance[n * k + k].max(0.0).sqrt() < KNOWN_SHARE
    }

    /// Covariance of what is applied, in units: that of what is not known counts as none.
    pub(super) fn applied_covariance(&self, i: usize, j: usize) -> f64 {
        let n = self.count();
        if self.known(i) && self.known(j) { self.covariance[n * i + j] } else { 0.0 }
    }

    /// Takes what all targets together say.
    pub(super) fn learn(&mut self, information: &[f64], vector: &[f64]) {
        let n = self.count();
        let errors = n - OF_ECHO;
        let choices: u32 = if errors <= MOST_WEIGHED { 1 << errors } else { 1 };
        let (mut solved, mut best) = (Vec::new(), f64::NEG_INFINITY);
        for choice in 0..choices {
            let there = |k: usize| choices == 1 || k >= errors || choice & (1 << k) != 0;
            let kept: Vec<usize> = (0..n).filter(|k| there(*k)).collect();
            let Some((log, mean, covariance)) = posterior(information, vector, n, &kept) else {
                continue;
            };
            let count = (kept.len() - OF_ECHO) as f64;
            let log =
                log + count * libm::log(THERE) + (errors as f64 - count) * libm::log(1.0 - THERE);
            best = best.max(log);
            solved.push((log, kept, mean, covariance));
        }
        let sum: f64 = solved.iter().map(|s| libm::exp(s.0 - best)).sum();
        if !(sum > 0.0 && sum.is_finite()) {
            return;
        }
        let (mut mean, mut square) = (vec![0.0; n], vec![0.0; n * n]);
        for (log, kept, own, covariance) in &solved {
            let weight = libm::exp(log - best) / sum;
            let m = kept.len();
            for (a, i) in kept.iter().enumerate() {
                mean[*i] += weight * own[a];
                for (b, j) in kept.iter().enumerate() {
                    square[n * i + j] += weight * (covariance[m * a + b] + own[a] * own[b]);
                }
            }
        }
        for i in 0..n {
            for j in 0..n {
                square[n * i + j] -= mean[i] * mean[j];
            }
        }
        (self.estimate, self.covariance) = (mean, square);
    }

    /// A parameter in its own unit.
    pub(super) fn found(&self, k: usize) -> Found {
        let n = self.count();
        let sigma = self.scale[k] * self.covariance[n * k + k].max(0.0).sqrt();
        let value = self.mean[k] + self.scale[k] * self.applied(k);
        Found { value, sigma, known: self.known(k) }
    }

    /// The errors of all radars.
    pub(super) fn sites(&self) -> Vec<SiteFound> {
        let of = |(site, (sensor, _)): (usize, &(SensorId, Option<Point2<f64>>))| SiteFound {
            sensor: *sensor,
            range_m: self.found(OF_SITE * site),
            azimuth_rad: self.found(OF_SITE * site + 1),
            time_s: self.found(OF_SITE * site + 2),
        };
        self.sites.iter().enumerate().map(of).collect()
    }
}

/// ln of the evidence, mean and covariance of the `kept` parameters where all others are 0: `(I + Λ)⁻¹ y` by Cholesky.
fn posterior(
    information: &[f64],
    vector: &[f64],
    n: usize,
    kept: &[usize],
) -> Option<(f64, Vec<f64>, Vec<f64>)> {
    let m = kept.len();
    let mut l = vec![0.0; m * m];
    for a in 0..m {
        for b in 0..=a {
            let prior = if a == b { 1.0 } else { 0.0 };
            let mut sum = prior + information[n * kept[a] + kept[b]];
            sum -= (0..b).map(|k| l[m * a + k] * l[m * b + k]).sum::<f64>();
            l[m * a + b] = if a == b {
                if !(sum > 0.0 && sum.is_finite()) {
                    return None;
                }
                sum.sqrt()
            } else {
                sum / l[m * b + b]
            };
        }
    }
    let solve = |y: &[f64]| {
        let mut x = y.to_vec();
        for a in 0..m {
            let sum: f64 = (0..a).map(|k| l[m * a + k] * x[k]).sum();
            x[a] = (x[a] - sum) / l[m * a + a];
        }
        let half: f64 = x.iter().map(|v| v * v).sum();
        for a in (0..m).rev() {
            let sum: f64 = (a + 1..m).map(|k| l[m * k + a] * x[k]).sum();
            x[a] = (x[a] - sum) / l[m * a + a];
        }
        (x, half)
    };
    let own: Vec<f64> = kept.iter().map(|k| vector[*k]).collect();
    let (mean, square) = solve(&own);
    let ln_det: f64 = (0..m).map(|a| 2.0 * libm::log(l[m * a + a])).sum();
    let mut covariance = vec![0.0; m * m];
    for b in 0..m {
        let unit: Vec<f64> = (0..m).map(|a| if a == b { 1.0 } else { 0.0 }).collect();
        let (column, _) = solve(&unit);
        (0..m).for_each(|a| covariance[m * a + b] = column[a]);
    }
    let log = 0.5 * (square - ln_det);
    log.is_finite().then_some((log, mean, covariance))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::testing::plot_at;
    use nalgebra::{DMatrix, DVector};

    fn one_site() -> Shared {
        Shared::new(vec![(SensorId(4), Some(Point2::new(1.0, 2.0)))], &EchoLaw::default())
    }

    /// What targets say of five parameters: three errors of a site, that go together a little, and two of echoes.
    fn said() -> (DMatrix<f64>, DVector<f64>) {
        let a = DMatrix::from_fn(7, 5, |i, j| ((i * 5 + j * j + 3 * i * j) % 7) as f64 - 3.0);
        let unit = DVector::from_vec(vec![2.0, 0.7, 0.05, 0.5, 3.0]);
        let a = a * DMatrix::from_diagonal(&unit);
        (a.transpose() * &a, a.transpose() * DVector::from_fn(7, |i, _| 1.3 - 0.4 * i as f64))
    }

    #[test]
    fn errors_of_a_site_are_the_mean_over_all_choices_of_them_by_their_evidence() {
        let (information, vector) = said();
        let mut shared = one_site();
        shared.learn(information.transpose().as_slice(), vector.as_slice());
        let (mut sum, mut mean, mut square) = (0.0, DVector::zeros(5), DMatrix::zeros(5, 5));
        for choice in 0..8 {
            // What is not there has a prior of next to no width.
            let prior =
                DVector::from_fn(
                    5,
                    |k, _| {
                        if k >= 3 || choice >> k & 1 == 1 { 1.0 } else { 1e-14 }
                    },
                );
            let precision = DMatrix::from_diagonal(&prior.map(|v| 1.0 / v)) + &information;
            let covariance = precision.clone().try_inverse().expect("regular");
            let own = &covariance * &vector;
            // Evidence: exp(½ yᵀ(P⁻¹ + Λ)⁻¹y) / √(det P det(P⁻¹ + Λ)).
            let factor = (precision.determinant() * prior.product()).sqrt();
            let weight = libm::exp(0.5 * vector.dot(&own)) / factor;
            sum += weight;
            mean += &own * weight;
            square += (covariance + &own * own.transpose()) * weight;
        }
        mean /= sum;
        square = square / sum - &mean * mean.transpose();
        for i in 0..5 {
            let (found, expected) = (shared.estimate[i], mean[i]);
            assert!((found - expected).abs() < 1e-6, "{i}: {found} for {expected}");
            for j in 0..5 {
                let (found, expected) = (shared.covariance[5 * i + j], square[(i, j)]);
                assert!((found - expected).abs() < 1e-6, "{i} {j}: {found} for {expected}");
            }
        }
        let of = shared.found(1);
        assert!((of.sigma - 2e-3 * square[(1, 1)].sqrt()).abs() < 1e-9);
    }

    #[test]
    fn what_is_not_known_to_half_its_prior_is_not_applied() {
        let mut shared = one_site();
        assert_eq!(
            (shared.count(), shared.site(SensorId(4)), shared.site(SensorId(5))),
            (5, Some(0), None)
        );
        assert_eq!(shared.site_m(SensorId(4)), Some(Point2::new(1.0, 2.0)));
        for k in 0..5 {
            shared.estimate[k] = 0.5;
            for j in 0..5 {
                shared.covariance[5 * k + j] =
                    if k == j { [0.24, 0.26, 0.01, 1.0, 0.25][k] } else { 0.005 };
            }
        }
        let known = [true, false, true, false, false];
        let law = EchoLaw::default();
        let mean = [0.0, 0.0, 0.0, law.aircraft.length, law.vehicle.length];
        let unit = [3.0, 2e-3, 0.2, 0.02, 0.1];
        for i in 0..5 {
            let found = shared.found(i);
            assert_eq!((found.known, shared.unit(i)), (known[i], (unit[i], mean[i])), "{i}");
            assert_eq!(shared.applied(i), if known[i] { 0.5 } else { 0.0 });
            let value = if known[i] { 0.5 * unit[i] } else { mean[i] };
            assert!((found.value - value).abs() < 1e-12, "{i}: {}", found.value);
            for j in 0..5 {
                let both = known[i] && known[j];
                let own = shared.covariance[5 * i + j];
                assert_eq!(
                    shared.applied_covariance(i, j),
                    if both { own } else { 0.0 },
                    "{i} {j}"
                );
            }
        }
        let site = shared.sites()[0];
        assert_eq!(
            (site.sensor, site.range_m.known, site.azimuth_rad.known),
            (SensorId(4), true, false)
        );
        assert!((site.time_s.value - 0.1).abs() < 1e-12);
        // What says nonsense teaches nothing.
        let before = shared.estimate.clone();
        shared.learn(&[f64::NAN; 25], &[1.0; 5]);
        assert_eq!(shared.estimate, before);
    }

    #[test]
    fn lines_of_sight_meet_where_the_radar_stands_unless_they_are_one() {
        let site = Point2::new(-40.0, 700.0);
        let seen = |degrees: f64| {
            let (sin, cos) = libm::sincos(degrees.to_radians());
            let axis = Vector2::new(cos, sin);
            let at = site + axis * (300.0 + 7.0 * degrees);
            Plot { axis, ..plot_at(0.0, at.x, at.y, 1.0) }
        };
        for spread in [4.0, 20.0, 90.0, 179.0] {
            let plots: Vec<_> = (0..9).map(|k| seen(30.0 + spread * f64::from(k) / 8.0)).collect();
            // The mean square of the sine about their middle: 1.4° are too little to tell.
            match meeting_m(plots.iter()) {
                Some(found) => assert!((found - site).norm() < 1e-6, "{spread}: {found}"),
                None => assert!(spread < 7.0, "{spread}"),
            }
            assert_eq!(meeting_m(plots.iter()).is_some(), spread > 7.0, "{spread}");
        }
        assert_eq!(meeting_m([].iter()), None);
    }
}
