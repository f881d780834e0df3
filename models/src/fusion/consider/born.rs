//! Tracks that begin with a report: what its first report errs by is what the others err by.
//!
//! A place that was told by a receiver alone is off by that receiver's slow error and by what its reports are late by:
//! `x = z − Jb − v`, so that `cov(x, b) = −J`. Taken for an error of its own, the first report would say of the second one that it
//! errs by nothing. What reports are late by shows only beside another sensor's plots. As long as there is none it is respected and
//! not learnt (Schmidt 1966: a gain of 0): where a target brakes, a filter that may learn it takes for a delay what its modes lack.

use super::{Consider, MOTION, SlowError};
use crate::filter::{Estimator, FilterConfig, Gaussian, StateEstimator, UpdateError};
use crate::frames::Vector2;
use crate::plot::{Plot, SensorId};

/// The only sensor that has told of a target so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Alone {
    sensor: SensorId,
    /// The place is known to be off by what the reports are late by.
    tied: bool,
}

/// A velocity is known whose standard deviation is below this share of it, or below this, m/s.
const KNOWN_SHARE: f64 = 1.0 / 3.0;
const KNOWN_MPS: f64 = 1.0;

impl Consider {
    /// A track's filter from its first plot, a report that errs as `slow` says.
    ///
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    pub fn born(plot: &Plot, config: &FilterConfig, slow: SlowError) -> Result<Self, UpdateError> {
        let first = Estimator::from_plot(config, plot)?.estimate();
        let mut filter = Self::from_estimate(&first, config);
        filter.alone = Some(Alone { sensor: plot.sensor, tied: false });
        let rows = filter.rows(plot, slow)?;
        for row in &rows.rows[..rows.count] {
            let [(at, factor), _] = row.slow;
            if factor != 0.0 {
                filter.tie(at, -row.u * factor, 0.0);
            }
        }
        Ok(filter)
    }

    /// A plot of `sensor` is about to be taken: once the velocity is known, so is what the place is off by, `late_s` being the
    /// standard deviation of the delay.
    pub(super) fn hear(&mut self, sensor: SensorId, slow: SlowError) {
        self.alone = self.alone.filter(|alone| alone.sensor == sensor);
        let SlowError::Receiver { late_s, .. } = slow else { return };
        let (Some(at), Some(alone)) = (self.frozen(), self.alone) else { return };
        let now = self.estimate();
        let (velocity, spread) = (now.velocity_mps(), now.velocity_cov_m2s2().trace().sqrt());
        if !alone.tied && spread < KNOWN_MPS.max(KNOWN_SHARE * velocity.norm()) {
            self.tie(at, velocity * late_s, 1.0);
            self.alone = Some(Alone { tied: true, ..alone });
        }
    }

    /// The track begins again in this state, by plots of which this is the last.
    pub fn begin_again(&mut self, last: &Plot, state: &Gaussian) {
        let same = self.alone.filter(|alone| alone.sensor == last.sensor);
        self.alone = same.map(|alone| Alone { tied: false, ..alone });
        self.replace(last.time, state);
    }

    /// Whether reports of `sensor` are not yet held to be late: nothing says by how many metres.
    pub(super) fn waits(&self, sensor: SensorId) -> bool {
        self.alone.is_some_and(|alone| alone.sensor == sensor && !alone.tied)
    }

    /// Where the delay stands that its own reports do not teach.
    pub(super) fn frozen(&self) -> Option<usize> {
        let sensor = self.alone?.sensor;
        self.slow.iter().find(|s| s.delay && s.sensor == Some(sensor)).map(|s| s.at)
    }

    /// What ties the place to a delay that nobody has shown, m: covariances of east and north, of all parts alike.
    pub(super) fn tied(&self) -> Option<(usize, [f64; 2])> {
        let at = self.frozen().filter(|_| self.alone.is_some_and(|alone| alone.tied))?;
        let n = self.size();
        let of =
            |row: usize| self.parts.iter().map(|part| part.weight * part.p[n * row + at]).sum();
        Some((at, [of(0), of(MOTION / 2)]))
    }

    /// The place, and its copy ([`super::past`]), is off by `off_m` times the slow error at `at`; `own`: and its covariance has not
    /// counted that yet (1) or has (0).
    fn tie(&mut self, at: usize, off_m: Vector2<f64>, own: f64) {
        let n = self.size();
        let copy = self.slow.iter().find(|s| s.sensor.is_none()).map(|s| [s.at, s.at + 1]);
        let places = [Some([0, MOTION / 2]), copy];
        let rows: Vec<(usize, f64)> =
            places.into_iter().flatten().flat_map(|[e, n]| [(e, off_m.x), (n, off_m.y)]).collect();
        for part in &mut self.parts {
            for &(i, a) in &rows {
                part.p[n * i + at] += a;
                part.p[n * at + i] += a;
                for &(j, b) in &rows {
                    part.p[n * i + j] += own * a * b;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::report;
    use super::*;
    use crate::filter::consistency::position_nees;
    use crate::filter::testing::{drawn, slower};
    use crate::filter::{Rung, two_plot_start};
    use crate::frames::Point2;

    /// Standard deviation of the delay, s, and share of the variance of a report that is slow.
    const LATE_S: f64 = 0.144;
    const SHARE: f64 = 0.94;

    fn slow() -> SlowError {
        SlowError::Receiver { share: SHARE, tau_s: 300.0, late_s: LATE_S }
    }

    /// On final at 70 m/s for 40 s, braking to 10 m/s by 2 m/s², then on: place at a time, m.
    fn place(t: f64) -> Point2<f64> {
        let (at_speed, braking, after) =
            (t.min(40.0), (t - 40.0).clamp(0.0, 30.0), (t - 70.0).max(0.0));
        let way = 70.0 * at_speed + (70.0 - braking) * braking + 10.0 * after;
        Point2::new(0.6, 0.8) * way
    }

    /// What a landing is published with that only its own reports tell of, each run with a delay and an error of its own: mean square
    /// error and mean NEES on final (from 10 to 40 s) and while it brakes and rolls (to 90 s); then what a sensor that is not late
    /// makes of the delay: root mean square of its error before and after, in standard deviations.
    fn landings(config: &FilterConfig, born: bool) -> ([[f64; 2]; 2], [f64; 2]) {
        let (mut sums, mut delays) = ([[0.0; 2]; 2], [0.0; 2]);
        let runs = 150;
        for run in 0..runs {
            let draw = |sensor, scan: u32| drawn(4000 + run, sensor, 0, scan.into());
            let rho = libm::exp(-1.0f64 / 300.0);
            let (mut error, delay) = (draw(3, 0), draw(4, 0).x);
            let mut filter: Option<Consider> = None;
            for k in 1..=100u32 {
                let t = f64::from(k);
                error = slower(error, rho, draw(3, k));
                let off = (error * SHARE.sqrt() + draw(2, k) * (1.0 - SHARE).sqrt()) * 2.0;
                let said = report(t, place(t - delay * LATE_S) + off, 4.0);
                let Some(filter) = &mut filter else {
                    let first = Estimator::from_plot(config, &said).expect("sound").estimate();
                    let unborn = Consider::from_estimate(&first, config);
                    let own = Consider::born(&said, config, slow()).expect("sound");
                    filter = Some(if born { own } else { unborn });
                    continue;
                };
                filter.update(&said, slow(), false).expect("sound");
                let of_delay = |f: &Consider| {
                    let at = f.slow.iter().find(|s| s.delay).expect("has one").at;
                    f.parts.iter().map(|p| p.weight * p.x[at]).sum::<f64>() - delay
                };
                if k == 30 {
                    // A second sensor sees it for ten seconds: not in what is published.
                    let mut seen_too = filter.clone();
                    delays[0] += of_delay(&seen_too).powi(2) / runs as f64;
                    for s in 0..10 {
                        let t = t + 0.1 + f64::from(s);
                        let seen = Plot {
                            sensor: SensorId(1),
                            ..report(t, place(t) + draw(1, 100 + s) * 2.0, 4.0)
                        };
                        seen_too.update(&seen, SlowError::White, false).expect("sound");
                    }
                    delays[1] += of_delay(&seen_too).powi(2) / runs as f64;
                }
                let part = usize::from(k > 40);
                if (10..=90).contains(&k) {
                    let found = filter.estimate();
                    let count = runs as f64 * if part == 0 { 31.0 } else { 50.0 };
                    sums[part][0] += (found.position_m() - place(t)).norm_squared() / count;
                    sums[part][1] += position_nees(&found, place(t)) / count;
                }
            }
        }
        (sums, delays.map(f64::sqrt))
    }

    /// Begun again from two of its own reports it is as far off as it says, at once: 150 runs, mean NEES of the three reports after.
    #[test]
    fn a_new_beginning_from_its_own_reports_is_as_late_as_they_are() {
        let config = FilterConfig::new(Rung::Imm3);
        let (mut nees, mut count) = (0.0, 0.0);
        for run in 0..150u64 {
            let draw = |sensor, scan: u32| drawn(8000 + run, sensor, 0, scan.into());
            let delay = draw(4, 0).x * LATE_S;
            let said =
                |k: u32| report(f64::from(k), place(f64::from(k) - delay) + draw(2, k) * 2.0, 4.0);
            let white = SlowError::Receiver { share: 0.0, tau_s: 300.0, late_s: LATE_S };
            let mut filter = Consider::born(&said(1), &config, white).expect("sound");
            (2..=20).for_each(|k| filter.update(&said(k), white, false).expect("sound"));
            let (first, last) = (said(21), said(22));
            let state = two_plot_start(&first, &last, config.start, false).expect("sound");
            filter.begin_again(&last, &state);
            for k in 23..=26 {
                filter.update(&said(k), white, false).expect("sound");
                if k > 23 {
                    nees += position_nees(&filter.estimate(), place(f64::from(k)));
                    count += 1.0;
                }
            }
        }
        let mean = nees / count;
        println!("NEES {mean:.2}");
        assert!((1.5..2.6).contains(&mean), "{mean}");
    }

    /// Its error is that of its reports, and it says so, at speed and while it brakes; no delay is learnt of that, and most of it as
    /// soon as somebody shows it. With its first report taken for punctual it called itself three times as good as it was.
    #[test]
    fn what_only_its_own_reports_tell_of_says_what_they_err_by() {
        for rung in [Rung::Ca6, Rung::Imm3] {
            let config = FilterConfig::new(rung);
            let (born, delays) = landings(&config, true);
            let (unborn, _) = landings(&config, false);
            println!("{rung:?}: {born:?} {delays:?}, without {unborn:?}");
            for ([m2, nees], [before_m2, _]) in born.into_iter().zip(unborn) {
                assert!((1.5..2.6).contains(&nees), "{born:?}");
                // What may not be learnt of its own reports costs little where it brakes: 1.00, 1.08 times.
                assert!(m2 < 1.12 * before_m2, "{m2} {before_m2}");
            }
            assert!(unborn[0][1] > 1.5 * born[0][1], "{unborn:?} {born:?}");
            assert!((0.8..1.2).contains(&delays[0]) && delays[1] < 0.4 * delays[0], "{delays:?}");
        }
    }
}
