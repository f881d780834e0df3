//! The off-line approach: tracking reduced to figures that were fitted from the on-line chain.
//!
//! No plot, gate or filter: a system track is the truth plus an error with the mean, covariance and
//! correlation from scan to scan that tracks had in the same kind of motion ([`Motion`]). Tracks come
//! and go by a two-state chain with the measured share and mean length of gaps. [`fit`] makes the
//! figures from samples of on-line runs, [`OfflineTracker`] draws from them.
//!
//! What is lost on the way: everything that depends on place, weather and neighbours beyond its
//! average: swaps, false tracks, errors that grow in a coast, correlation beyond the first order.
//!
//! Source: first-order Gauss-Markov errors by moments; Cox & Miller, *The Theory of Stochastic
//! Processes* (1965), ch. 3, for the chain.

use crate::draw::{DrawKey, Purpose, normal_pair, uniform};
use crate::frames::{Point2, Vector2, wrap_pi};
use std::collections::BTreeMap;

/// How a target moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Motion {
    /// Slower than 1 m/s.
    Standing,
    /// Straight on at constant speed.
    Steady,
    /// Braking or speeding up by more than 0.3 m/s².
    Changing,
    /// Turning by more than 0.02 rad/s.
    Turning,
}

impl Motion {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Standing, Self::Steady, Self::Changing, Self::Turning];

    /// Word for reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Standing => "standing",
            Self::Steady => "steady",
            Self::Changing => "changing speed",
            Self::Turning => "turning",
        }
    }

    /// The kind of motion between two velocities (m/s) `dt_s` apart; kinds are told apart at limits
    /// that are assumptions.
    #[must_use]
    pub fn of(before_ms: Vector2<f64>, now_ms: Vector2<f64>, dt_s: f64) -> Self {
        let speed = |v: Vector2<f64>| libm::hypot(v.x, v.y);
        let course = |v: Vector2<f64>| libm::atan2(v.y, v.x);
        if speed(now_ms) < 1.0 {
            Self::Standing
        } else if speed(before_ms) >= 1.0
            && wrap_pi(course(now_ms) - course(before_ms)).abs() > 0.02 * dt_s
        {
            Self::Turning
        } else if (speed(now_ms) - speed(before_ms)).abs() > 0.3 * dt_s {
            Self::Changing
        } else {
            Self::Steady
        }
    }
}

/// One scan of one target in an on-line run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Key of the target, different from run to run.
    pub key: u64,
    /// Number of the scan.
    pub scan: u64,
    /// How it moves.
    pub motion: Motion,
    /// Errors of the track, if there was one: position along and across the target's motion, m, then
    /// velocity along and across, m/s.
    pub error: Option<[f64; 4]>,
}

/// Figures of one kind of motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionFigures {
    /// Mean errors, as in [`Sample::error`].
    pub mean: [f64; 4],
    /// Deviations of the errors.
    pub sigma: [f64; 4],
    /// Correlation of the errors along and across.
    pub cross: f64,
    /// Correlation of the position errors with those one scan before.
    pub rho: f64,
    /// Samples that they rest on.
    pub samples: u64,
}

/// Figures of a chain.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// One for each kind of motion, in the order of [`Motion::ALL`].
    pub motions: [MotionFigures; 4],
    /// Share of the scans with a report, after the first one.
    pub reported: f64,
    /// Mean length of a gap, scans.
    pub gap_scans: f64,
    /// Scans from a target's first to its first report, mean.
    pub delay_scans: f64,
}

/// Why no figures could be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{found} reports are too few to fit a tracker; {needed} are needed")]
pub struct TooFew {
    /// Reports found.
    pub found: usize,
    /// Reports needed.
    pub needed: usize,
}

/// Fewest reports for a fit.
const FEWEST: usize = 100;
/// Kinds of motion with fewer reports than this take the figures of all reports.
const FEWEST_OF_MOTION: usize = 30;

/// Makes the figures of samples sorted by target, then scan.
///
/// # Errors
/// [`TooFew`] with fewer than a hundred reports.
pub fn fit(samples: &[Sample]) -> Result<Figures, TooFew> {
    let found = samples.iter().filter(|s| sound(s).is_some()).count();
    if found < FEWEST {
        return Err(TooFew { found, needed: FEWEST });
    }
    let all = figures_of(samples, |_| true);
    let motions = Motion::ALL.map(|motion| {
        let own = figures_of(samples, |m| m == motion);
        if own.samples as usize >= FEWEST_OF_MOTION { own } else { all }
    });
    let (mut present, mut due, mut gaps, mut delay, mut targets) = (0u64, 0u64, 0u64, 0u64, 0u64);
    for target in samples.chunk_by(|a, b| a.key == b.key) {
        let Some(first) = target.iter().position(|s| sound(s).is_some()) else { continue };
        targets += 1;
        delay += first as u64;
        let after = &target[first..];
        due += after.len() as u64;
        present += after.iter().filter(|s| sound(s).is_some()).count() as u64;
        let begins = |w: &[Sample]| sound(&w[0]).is_some() && sound(&w[1]).is_none();
        gaps += after.windows(2).filter(|w| begins(w)).count() as u64;
    }
    let missing = due - present;
    Ok(Figures {
        motions,
        reported: present as f64 / due.max(1) as f64,
        gap_scans: if gaps > 0 { missing as f64 / gaps as f64 } else { 1.0 },
        delay_scans: delay as f64 / targets.max(1) as f64,
    })
}

fn sound(sample: &Sample) -> Option<[f64; 4]> {
    sample.error.filter(|e| e.iter().all(|x| x.is_finite()))
}

fn figures_of(samples: &[Sample], of: impl Fn(Motion) -> bool) -> MotionFigures {
    let errors = || samples.iter().filter(|s| of(s.motion)).filter_map(sound);
    let n = errors().count();
    if n == 0 {
        return MotionFigures::default();
    }
    let mut mean = [0.0; 4];
    errors().for_each(|e| (0..4).for_each(|i| mean[i] += e[i] / n as f64));
    let (mut square, mut cross) = ([0.0; 4], 0.0);
    for e in errors() {
        (0..4).for_each(|i| square[i] += (e[i] - mean[i]).powi(2) / n as f64);
        cross += (e[0] - mean[0]) * (e[1] - mean[1]) / n as f64;
    }
    let sigma = square.map(f64::sqrt);
    let (mut sum, mut pairs) = (0.0, 0.0);
    for pair in samples.windows(2) {
        let next = pair[0].key == pair[1].key && pair[1].scan == pair[0].scan + 1;
        if let (true, Some(a), Some(b)) =
            (next && of(pair[0].motion) && of(pair[1].motion), sound(&pair[0]), sound(&pair[1]))
        {
            for i in 0..2 {
                if sigma[i] > 0.0 {
                    sum += (a[i] - mean[i]) * (b[i] - mean[i]) / (sigma[i] * sigma[i]);
                    pairs += 1.0;
                }
            }
        }
    }
    let product = sigma[0] * sigma[1];
    MotionFigures {
        mean,
        sigma,
        cross: if product > 0.0 { (cross / product).clamp(-1.0, 1.0) } else { 0.0 },
        rho: if pairs > 0.0 { f64::clamp(sum / pairs, 0.0, 0.9999) } else { 0.0 },
        samples: n as u64,
    }
}

/// The truth of one target at the end of a scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueState {
    /// Key of the target.
    pub key: u64,
    /// Position, m.
    pub position_m: Point2<f64>,
    /// Velocity, m/s.
    pub velocity_mps: Vector2<f64>,
}

/// A track that was drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnTrack {
    /// Key of its target.
    pub key: u64,
    /// Position, m.
    pub position_m: Point2<f64>,
    /// Velocity, m/s.
    pub velocity_mps: Vector2<f64>,
}

#[derive(Clone, Copy, Debug)]
struct State {
    unit: [f64; 4],
    up: bool,
    wait: f64,
    velocity_mps: Vector2<f64>,
    scan: u64,
}

/// Tracks by figures.
#[derive(Clone, Debug)]
pub struct OfflineTracker {
    figures: Figures,
    /// Time between two scans, s.
    scan_s: f64,
    states: BTreeMap<u64, State>,
}

/// The sensor number of the tracker's draws: above all sensors.
const TRACKER: u32 = 1 << 16;

impl OfflineTracker {
    /// A tracker with these figures.
    #[must_use]
    pub fn new(figures: Figures, scan_s: f64) -> Self {
        Self { figures, scan_s, states: BTreeMap::new() }
    }

    /// One scan: the truth in, tracks out, in the same order. Targets that are not there any more are
    /// forgotten.
    pub fn scan(&mut self, run_seed: u64, scan: u64, truth: &[TrueState]) -> Vec<DrawnTrack> {
        let mut tracks = Vec::with_capacity(truth.len());
        let figures = &self.figures;
        // Up and down so that the share and the mean gap are those measured.
        let back = 1.0 / figures.gap_scans.max(1.0);
        let reported = figures.reported.clamp(1e-9, 1.0);
        let lost = (back * (1.0 - reported) / reported).min(1.0);
        for target in truth {
            let key = DrawKey { run_seed, sensor: TRACKER, entity: target.key, scan };
            let mut rng = key.rng(Purpose::Offline);
            let fresh = uniform(&mut rng);
            let ((a, b), (c, d)) = (normal_pair(&mut rng), normal_pair(&mut rng));
            let draws = [a, b, c, d];
            let known = self.states.get(&target.key).copied();
            let before = known.map_or(target.velocity_mps, |s| s.velocity_mps);
            let motion = Motion::of(before, target.velocity_mps, self.scan_s);
            let of = &figures.motions[motion as usize];
            let state = self.states.entry(target.key).or_insert(State {
                unit: draws,
                up: true,
                wait: figures.delay_scans,
                velocity_mps: target.velocity_mps,
                scan,
            });
            if known.is_some() {
                let (keep, new) = (of.rho, (1.0 - of.rho * of.rho).max(0.0).sqrt());
                (0..4).for_each(|i| state.unit[i] = keep * state.unit[i] + new * draws[i]);
                state.up = if state.up { fresh >= lost } else { fresh < back };
                state.wait -= 1.0;
            }
            (state.velocity_mps, state.scan) = (target.velocity_mps, scan);
            // The mean delay may be a fraction of a scan.
            if !state.up || state.wait >= 0.5 {
                continue;
            }
            let u = state.unit;
            let rest = (1.0 - of.cross * of.cross).max(0.0).sqrt();
            let along = of.mean[0] + of.sigma[0] * u[0];
            let across = of.mean[1] + of.sigma[1] * (of.cross * u[0] + rest * u[1]);
            let (ahead, right) = axes(target.velocity_mps);
            tracks.push(DrawnTrack {
                key: target.key,
                position_m: target.position_m + ahead * along + right * across,
                velocity_mps: target.velocity_mps
                    + ahead * (of.mean[2] + of.sigma[2] * u[2])
                    + right * (of.mean[3] + of.sigma[3] * u[3]),
            });
        }
        self.states.retain(|_, state| state.scan == scan);
        tracks
    }
}

/// Unit vectors along and across (to the right of) a velocity; north and east of one that stands.
#[must_use]
pub fn axes(velocity_mps: Vector2<f64>) -> (Vector2<f64>, Vector2<f64>) {
    let speed = libm::hypot(velocity_mps.x, velocity_mps.y);
    let ahead = if speed >= 1.0 { velocity_mps / speed } else { Vector2::new(0.0, 1.0) };
    (ahead, Vector2::new(ahead.y, -ahead.x))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures() -> Figures {
        let of = MotionFigures {
            mean: [-0.5, 0.1, 0.0, 0.0],
            sigma: [1.5, 0.8, 0.6, 0.3],
            cross: 0.4,
            rho: 0.6,
            samples: 1000,
        };
        Figures { motions: [of; 4], reported: 0.9, gap_scans: 3.0, delay_scans: 2.0 }
    }

    /// Targets that drive north at 10 m/s.
    fn drive(tracker: &mut OfflineTracker, scans: u64, targets: u64) -> Vec<Sample> {
        let mut samples = Vec::new();
        for scan in 1..=scans {
            let truth: Vec<TrueState> = (0..targets)
                .map(|key| TrueState {
                    key,
                    position_m: Point2::new(100.0 * key as f64, 10.0 * scan as f64),
                    velocity_mps: Vector2::new(0.0, 10.0),
                })
                .collect();
            let tracks = tracker.scan(9, scan, &truth);
            for state in truth {
                let track = tracks.iter().find(|t| t.key == state.key);
                let error = track.map(|t| {
                    let (e, v) =
                        (t.position_m - state.position_m, t.velocity_mps - state.velocity_mps);
                    [e.y, e.x, v.y, v.x]
                });
                samples.push(Sample { key: state.key, scan, motion: Motion::Steady, error });
            }
        }
        samples.sort_by_key(|s| (s.key, s.scan));
        samples
    }

    #[test]
    fn what_is_drawn_is_fitted_again() {
        let wanted = figures();
        let samples = drive(&mut OfflineTracker::new(wanted.clone(), 1.0), 1000, 60);
        let found = fit(&samples).expect("enough");
        let (w, f) = (&wanted.motions[1], &found.motions[1]);
        for i in 0..4 {
            assert!((w.mean[i] - f.mean[i]).abs() < 0.05, "{f:?}");
            assert!((w.sigma[i] - f.sigma[i]).abs() < 0.05, "{f:?}");
        }
        assert!((w.rho - f.rho).abs() < 0.04 && (w.cross - f.cross).abs() < 0.03, "{f:?}");
        assert!((found.reported - 0.9).abs() < 0.01, "{found:?}");
        assert!((found.gap_scans - 3.0).abs() < 0.2, "{found:?}");
        assert!((found.delay_scans - 2.0).abs() < 0.7, "{found:?}");
    }

    #[test]
    fn draws_do_not_depend_on_who_else_is_there() {
        let alone = drive(&mut OfflineTracker::new(figures(), 1.0), 50, 1);
        let among = drive(&mut OfflineTracker::new(figures(), 1.0), 50, 5);
        assert_eq!(alone, among[..50]);
    }

    #[test]
    fn too_little_and_nonsense_are_refused_or_left_out() {
        let sample = |scan, error| Sample { key: 1, scan, motion: Motion::Standing, error };
        assert_eq!(fit(&[]), Err(TooFew { found: 0, needed: 100 }));
        let mut samples: Vec<Sample> =
            (0..120).map(|scan| sample(scan, Some([0.0, 0.0, 0.0, 0.0]))).collect();
        samples.push(sample(120, Some([f64::NAN, 0.0, 0.0, 0.0])));
        let found = fit(&samples).expect("enough");
        assert_eq!(found.motions[0].samples, 120);
        let exact = OfflineTracker::new(found, 1.0).scan(
            1,
            1,
            &[TrueState {
                key: 4,
                position_m: Point2::new(7.0, 8.0),
                velocity_mps: Vector2::zeros(),
            }],
        );
        assert_eq!(exact[0].position_m, Point2::new(7.0, 8.0));
    }

    #[test]
    fn motions_are_told_apart() {
        let v = |x: f64, y: f64| Vector2::new(x, y);
        assert_eq!(Motion::of(v(0.0, 0.5), v(0.0, 0.4), 1.0), Motion::Standing);
        assert_eq!(Motion::of(v(0.0, 10.0), v(0.0, 10.1), 1.0), Motion::Steady);
        assert_eq!(Motion::of(v(0.0, 10.0), v(0.0, 11.0), 1.0), Motion::Changing);
        assert_eq!(Motion::of(v(0.0, 10.0), v(0.5, 10.0), 1.0), Motion::Turning);
        assert_eq!(Motion::of(v(-10.0, 1e-9), v(-10.0, -1e-9), 1.0), Motion::Steady);
    }

    /// Each figure by its definition, over all that were sorted out by hand.
    #[test]
    fn figures_are_those_of_their_definitions() {
        let mut samples = Vec::new();
        let mut rng = DrawKey { run_seed: 11, sensor: 1, entity: 0, scan: 0 }.rng(Purpose::Study);
        for key in 0..40u64 {
            let mut error = [3.0, -1.0, 0.5, 0.2].map(|e| e * (1.0 + key as f64 / 10.0));
            let mut scan = 3 * key;
            for k in 0..60u64 {
                // A scan is left out now and then: what follows it is no neighbour.
                scan += 1 + u64::from(uniform(&mut rng) < 0.1);
                let (a, b) = normal_pair(&mut rng);
                let (c, d) = normal_pair(&mut rng);
                error = [0.7 * error[0] + a, 0.7 * error[1] + 0.6 * a + b, c, 2.0 * d];
                let share = uniform(&mut rng);
                let error = match () {
                    () if k < key % 4 || share < 0.1 => None,
                    () if share < 0.12 => Some([0.0, f64::NAN, 0.0, 0.0]),
                    () => Some(error),
                };
                // Few turn: they take the figures of all.
                let turns = key == 7 && k > 40;
                let kind = if turns { 3 } else { (key % 3) as usize };
                samples.push(Sample { key, scan, motion: Motion::ALL[kind], error });
            }
        }
        let found = fit(&samples).expect("enough");
        let near = |what: &str, found: f64, wanted: f64| {
            assert!(
                (found - wanted).abs() < 1e-9 * (1.0 + wanted.abs()),
                "{what}: {found} {wanted}"
            );
        };
        let good = |s: &&Sample| s.error.is_some_and(|e| e.iter().all(|x| x.is_finite()));
        for (kind, figures) in Motion::ALL.into_iter().zip(found.motions) {
            let of = |s: &&Sample| kind == Motion::Turning || s.motion == kind;
            let own: Vec<Sample> = samples.iter().filter(of).filter(good).copied().collect();
            assert_eq!(figures.samples, own.len() as u64, "{kind:?}");
            let values =
                |i: usize| own.iter().map(|s| s.error.expect("good")[i]).collect::<Vec<_>>();
            let mean_of = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
            let units: Vec<Vec<f64>> = (0..4)
                .map(|i| {
                    let all = values(i);
                    let mean = mean_of(&all);
                    let off: Vec<f64> = all.iter().map(|v| v - mean).collect();
                    let sigma = mean_of(&off.iter().map(|o| o * o).collect::<Vec<_>>()).sqrt();
                    near("mean", figures.mean[i], mean);
                    near("sigma", figures.sigma[i], sigma);
                    off.iter().map(|o| o / sigma).collect()
                })
                .collect();
            let both: Vec<f64> = units[0].iter().zip(&units[1]).map(|(a, b)| a * b).collect();
            near("cross", figures.cross, mean_of(&both));
            let mut products = Vec::new();
            for (at, s) in own.iter().enumerate() {
                let before = own.iter().position(|b| b.key == s.key && b.scan + 1 == s.scan);
                let pairs = before.map(|b| [0, 1].map(|axis| units[axis][at] * units[axis][b]));
                products.extend(pairs.into_iter().flatten());
            }
            near("rho", figures.rho, mean_of(&products));
        }
        let (mut delays, mut present, mut due, mut gaps) = (Vec::new(), 0.0, 0.0, 0.0);
        for key in 0..40 {
            let there: Vec<bool> =
                samples.iter().filter(|s| s.key == key).map(|s| good(&s)).collect();
            let first = there.iter().position(|t| *t).expect("one");
            delays.push(first as f64);
            let after = &there[first..];
            due += after.len() as f64;
            present += after.iter().filter(|t| **t).count() as f64;
            gaps += (1..after.len()).filter(|&i| after[i - 1] && !after[i]).count() as f64;
        }
        near("delay", found.delay_scans, delays.iter().sum::<f64>() / 40.0);
        near("reported", found.reported, present / due);
        near("gap", found.gap_scans, (due - present) / gaps);
    }

    /// Figures of each kind of motion are drawn along and across that motion, whichever way it goes.
    #[test]
    fn errors_lie_along_the_motion_and_are_those_of_its_kind() {
        let of = |k: f64| MotionFigures {
            mean: [k, -2.0 * k, 0.1 * k, -0.2 * k],
            sigma: [0.3 * k, 0.1 * k, 0.05 * k, 0.02 * k],
            cross: -0.5,
            rho: 0.2,
            samples: 100,
        };
        let motions = [of(1.0), of(2.0), of(3.0), of(4.0)];
        let figures = Figures { motions, reported: 1.0, gap_scans: 1.0, delay_scans: 0.0 };
        for (place, course_deg) in [(0, 20.0), (1, 75.0), (2, 160.0), (3, 250.0), (1, 340.0)] {
            let mut tracker = OfflineTracker::new(figures.clone(), 2.0);
            let mut errors: Vec<[f64; 4]> = Vec::new();
            let course = f64::to_radians(course_deg);
            // Speed and course in a scan: at the limits of their kinds, seen from within.
            let (mut speed, mut turned) = if place == 0 { (0.99, 0.0) } else { (5.0, 0.0) };
            for scan in 1..=4000 {
                match place {
                    2 => speed += 0.61,
                    3 => turned += 0.041,
                    _ => turned = 0.038 * (scan % 2) as f64,
                }
                let (sin, cos) = libm::sincos(course + turned);
                let velocity_mps = Vector2::new(sin, cos) * speed;
                let state = TrueState { key: 1, position_m: Point2::new(1.0, 2.0), velocity_mps };
                let track = tracker.scan(3, scan, &[state])[0];
                let (off, faster) =
                    (track.position_m - state.position_m, track.velocity_mps - velocity_mps);
                let (sin, cos) = if place == 0 { (0.0, 1.0) } else { (sin, cos) };
                let parts = |v: Vector2<f64>| [v.x * sin + v.y * cos, v.x * cos - v.y * sin];
                let ([a, b], [c, d]) = (parts(off), parts(faster));
                errors.push([a, b, c, d]);
            }
            let n = errors.len() as f64;
            let wanted = &motions[place];
            for i in 0..4 {
                let mean = errors.iter().map(|e| e[i]).sum::<f64>() / n;
                let square = errors.iter().map(|e| (e[i] - mean) * (e[i] - mean)).sum::<f64>() / n;
                let by = 0.1 * wanted.sigma[i];
                assert!((mean - wanted.mean[i]).abs() < by, "{place} {i}: {mean}");
                assert!((square.sqrt() - wanted.sigma[i]).abs() < by, "{place} {i}: {square}");
            }
        }
    }
}
