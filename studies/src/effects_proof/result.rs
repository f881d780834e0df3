//! What both runs of a scene had, target by target, and what of it is beyond a tolerance.

use super::tails::{binomial_tail, poisson_tail};
use models::effects::Tolerance;
use models::frames::Point2;
use models::sensors::PlotSink;
use models::sensors::radar::effects::RadarEffect;
use models::time::SimTime;

/// One target in both runs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TargetResult {
    /// Scans with a plot in some run.
    pub both: u64,
    /// Plots of the planned run only, and of the exact one only.
    pub only: (u64, u64),
    /// Scans.
    pub scans: u64,
    /// Sum of squares of the distances of plots that both have, m², and of their squares.
    pub squares: (f64, f64),
    /// Plots farther apart than five times the tolerated rms.
    pub beyond: u64,
}

impl TargetResult {
    /// Rms distance, m.
    #[must_use]
    pub fn rms_m(&self) -> f64 {
        self.mean_m2().sqrt()
    }

    fn mean_m2(&self) -> f64 {
        self.squares.0 / self.both.max(1) as f64
    }

    /// Standard error of the mean square, by the sample itself.
    fn error_m2(&self) -> f64 {
        let n = self.both.max(1) as f64;
        let mean = self.mean_m2();
        ((self.squares.1 / n - mean * mean).max(0.0) / n).sqrt()
    }

    /// Whether the rms distance is beyond what is tolerated, and what it may be off in so many plots.
    fn is_shifted(&self, tolerance: &Tolerance) -> bool {
        let most = tolerance.position_m * (1.0 + 6.0 / (self.both.max(1) as f64).sqrt());
        self.both >= 30 && self.rms_m() > most + 1e-9
    }
}

/// Both runs of a scene.
#[derive(Clone, Debug, Default)]
pub struct SceneResult {
    /// Target by target.
    pub targets: Vec<TargetResult>,
    /// False plots and ghosts of one run only.
    pub false_plots: u64,
    /// Scans.
    pub scans: u64,
    /// Cost per target and scan by the table: exact, without what is not there and tables, planned, ns.
    pub cost_ns: (f64, f64, f64),
    /// Of that, effect by effect: simulated and left out, ns a target and scan.
    pub by_effect: Vec<(RadarEffect, f64, f64)>,
}

type Look = ((u64, SimTime), Point2<f64>);

/// A false plot or a ghost.
#[derive(Clone, Copy, Debug)]
struct Other {
    time: SimTime,
    place_m: Point2<f64>,
    /// Power of the ghost's way, dB: it names the target, the facade and the way. `None` for noise.
    way_db: Option<f64>,
}

impl Other {
    /// Whether two runs have the same one: noise at the same place, a ghost by the same way and no farther off
    /// than a plot may be. (Its place follows from what it states of its errors, which tables hold to their error.)
    fn is(&self, other: &Self, limit_m: f64) -> bool {
        let within_m = if self.way_db.is_some() { limit_m.max(1e-6) } else { 1e-6 };
        self.time == other.time
            && self.way_db == other.way_db
            && (self.place_m - other.place_m).norm() < within_m
    }
}

fn by_look(sink: &PlotSink) -> (Vec<Look>, Vec<Other>) {
    let (mut looks, mut others) = (Vec::new(), Vec::new());
    for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
        let place_m = plot.position_m;
        match cause.key {
            Some(key) => looks.push(((key, plot.time), place_m)),
            None => {
                let way_db = cause.effects.first().map(|way| way.value);
                others.push(Other { time: plot.time, place_m, way_db });
            }
        }
    }
    (looks, others)
}

impl SceneResult {
    pub(super) fn new(targets: usize) -> Self {
        Self { targets: vec![TargetResult::default(); targets], ..Self::default() }
    }

    pub(super) fn add(&mut self, planned: &PlotSink, exact: &PlotSink, limit_m: f64) {
        let ((a, a_false), (b, b_false)) = (by_look(planned), by_look(exact));
        for target in &mut self.targets {
            target.scans += 1;
        }
        for (look, place) in &a {
            let target = &mut self.targets[look.0 as usize - 1];
            match b.iter().find(|(other, _)| other == look) {
                Some((_, exact)) => {
                    let square = (place - exact).norm_squared();
                    target.both += 1;
                    target.squares.0 += square;
                    target.squares.1 += square * square;
                    target.beyond += u64::from(square > limit_m * limit_m);
                }
                None => target.only.0 += 1,
            }
        }
        for (look, _) in b.iter().filter(|(look, _)| !a.iter().any(|(other, _)| other == look)) {
            self.targets[look.0 as usize - 1].only.1 += 1;
        }
        let lacks = |list: &[Other], one: &Other| !list.iter().any(|other| one.is(other, limit_m));
        self.false_plots += a_false.iter().filter(|f| lacks(&b_false, f)).count() as u64;
        self.false_plots += b_false.iter().filter(|f| lacks(&a_false, f)).count() as u64;
    }

    /// Every scan was of so many turns.
    pub(super) fn of_turns(&mut self, turns: u64) {
        self.scans *= turns;
        self.targets.iter_mut().for_each(|target| target.scans *= turns);
    }

    pub(super) fn is_suspicious(&self, tolerance: &Tolerance) -> bool {
        // Of a rate of a thousandth four hundred scans say little: what looks but a little much is played longer.
        const RARE: f64 = 0.01;
        let rare = |n: u64, p: f64, k: u64| binomial_tail(n, p, k) < RARE;
        let limit2 = tolerance.position_m * tolerance.position_m;
        self.targets.iter().any(|t| {
            let (mean, error) = (t.mean_m2(), t.error_m2());
            rare(t.scans, tolerance.detection, t.only.0 + t.only.1)
                || rare(t.both, tolerance.tail, t.beyond)
                || (t.both > 0
                    && mean - limit2 > 4.0 * error.max(if t.both < 30 { mean } else { 0.0 }))
        }) || poisson_tail(self.scans as f64 * tolerance.false_plots, self.false_plots) < RARE
    }

    /// Whether nothing but shifts is beyond the tolerance, and these by so few plots that more may say otherwise: a
    /// coarse step that carries one plot of two thousand is the mean square of all of them.
    pub(super) fn is_open(&self, tolerance: &Tolerance) -> bool {
        let few = |t: &&TargetResult| {
            let error = t.error_m2();
            t.mean_m2() - tolerance.position_m * tolerance.position_m <= 6.0 * error
        };
        let beyond = |t: &&TargetResult| t.is_shifted(tolerance);
        let shifted: Vec<&TargetResult> = self.targets.iter().filter(beyond).collect();
        self.violations(tolerance).len() == shifted.len() && shifted.iter().any(few)
    }

    /// What of the result is beyond the tolerance.
    #[must_use]
    pub fn violations(&self, tolerance: &Tolerance) -> Vec<String> {
        let mut found = Vec::new();
        for (i, t) in self.targets.iter().enumerate() {
            let n = i + 1;
            let only = t.only.0 + t.only.1;
            if binomial_tail(t.scans, tolerance.detection, only) < 1e-9 {
                found.push(format!(
                    "target {n}: {only} of {} scans have a plot in one run only, {} tolerated",
                    t.scans, tolerance.detection
                ));
            }
            if binomial_tail(t.both, tolerance.tail, t.beyond) < 1e-9 {
                found.push(format!(
                    "target {n}: {} of {} plots beyond {} m, {} tolerated",
                    t.beyond,
                    t.both,
                    5.0 * tolerance.position_m,
                    tolerance.tail
                ));
            }
            if t.is_shifted(tolerance) {
                found.push(format!(
                    "target {n}: {} m rms over {} plots, {} m tolerated",
                    digits(t.rms_m()),
                    t.both,
                    tolerance.position_m
                ));
            }
        }
        if poisson_tail(self.scans as f64 * tolerance.false_plots, self.false_plots) < 1e-9 {
            found.push(format!(
                "{} false plots and ghosts of one run only in {} scans, {} a scan tolerated",
                self.false_plots, self.scans, tolerance.false_plots
            ));
        }
        found
    }

    /// Largest measured over allowed of any criterion, chance taken off: counts and means at three deviations below what
    /// was found. One plot in a hundred scans is ten times a detection of 0.001 and says nothing: a search that counts
    /// it follows the dice.
    #[must_use]
    pub fn surely(&self, tolerance: &Tolerance) -> f64 {
        let count = |k: u64, n: u64, allowed: f64| {
            let least = (k as f64 - 3.0 * (k as f64).sqrt()).max(0.0);
            if least == 0.0 { 0.0 } else { least / (n as f64 * allowed).max(1e-12) }
        };
        let of_target = |t: &TargetResult| {
            let mean = t.mean_m2();
            let least =
                if t.both >= 30 { (mean - 3.0 * t.error_m2()).max(0.0).sqrt() } else { 0.0 };
            let shift = if least == 0.0 { 0.0 } else { least / tolerance.position_m };
            shift.max(count(t.only.0 + t.only.1, t.scans, tolerance.detection)).max(count(
                t.beyond,
                t.both,
                tolerance.tail,
            ))
        };
        let false_plots = count(self.false_plots, self.scans, tolerance.false_plots);
        self.targets.iter().map(of_target).fold(false_plots, f64::max)
    }

    /// Largest measured over allowed of each criterion: shift, detection, false plots.
    #[must_use]
    pub fn largest(&self, tolerance: &Tolerance) -> [f64; 3] {
        let of = |f: &dyn Fn(&TargetResult) -> f64| self.targets.iter().map(f).fold(0.0, f64::max);
        [
            of(&|t| if t.both >= 30 { t.rms_m() / tolerance.position_m } else { 0.0 }),
            of(&|t| (t.only.0 + t.only.1) as f64 / t.scans.max(1) as f64 / tolerance.detection),
            self.false_plots as f64 / self.scans.max(1) as f64 / tolerance.false_plots,
        ]
    }
}

/// A length with four digits behind the point, or in powers of ten where these say nothing.
fn digits(metres: f64) -> String {
    if metres < 1e-3 { format!("{metres:.2e}") } else { format!("{metres:.4}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_plot_that_a_coarse_step_carries_is_no_verdict_and_forty_are() {
        let tolerance = Tolerance { position_m: 0.02, ..Tolerance::default() };
        let with = |carried: u64, by_m: f64| {
            let (n, square) = (carried as f64, by_m * by_m);
            let squares = (n * square, n * square * square);
            let target =
                TargetResult { both: 2000, scans: 2000, squares, ..TargetResult::default() };
            SceneResult { targets: vec![target], scans: 2000, ..SceneResult::default() }
        };
        // As the search at six restarts found it: 0.032 m rms of 0.02 by one plot.
        let one = with(1, 1.43);
        assert!(one.violations(&tolerance).len() == 1 && one.is_open(&tolerance));
        assert_eq!(one.surely(&tolerance), 0.0, "a search does not go after it");
        let many = with(100, 0.4);
        assert!(many.violations(&tolerance).len() == 1 && !many.is_open(&tolerance));
        assert!(many.surely(&tolerance) > 3.0);
        let within = with(1, 0.5);
        assert!(within.violations(&tolerance).is_empty() && !within.is_open(&tolerance));
        // Another criterion beyond is a verdict by itself.
        let mut lost = one.clone();
        lost.targets[0].only.0 = 400;
        assert!(lost.violations(&tolerance).len() == 2 && !lost.is_open(&tolerance));
        assert!(lost.surely(&tolerance) > 15.0);
        let ghosts = SceneResult { false_plots: 200, ..within };
        assert!(ghosts.surely(&tolerance) > 5.0 && ghosts.surely(&tolerance) < 10.0);
    }

    #[test]
    fn a_ghost_is_the_same_by_its_way_and_noise_by_its_place() {
        let at = |seconds: f64, east_m: f64, way_db: Option<f64>| Other {
            time: SimTime::from_s(seconds),
            place_m: Point2::new(east_m, 0.0),
            way_db,
        };
        let ghost = at(1.0, 100.0, Some(-12.0));
        assert!(ghost.is(&at(1.0, 100.4, Some(-12.0)), 0.5), "moved by less than a plot may be");
        assert!(!ghost.is(&at(1.0, 100.6, Some(-12.0)), 0.5), "by more");
        assert!(!ghost.is(&at(1.0, 100.0, Some(-12.1)), 0.5), "another way");
        assert!(!ghost.is(&at(1.1, 100.0, Some(-12.0)), 0.5), "another time");
        assert!(!ghost.is(&at(1.0, 100.0, None), 0.5), "noise");
        let noise = at(1.0, 100.0, None);
        assert!(noise.is(&noise, 0.5) && !noise.is(&at(1.0, 100.001, None), 0.5));
        // Nothing may move: ghosts that do not are the same.
        assert!(ghost.is(&ghost, 0.0) && !ghost.is(&at(1.0, 100.001, Some(-12.0)), 0.0));
    }
}
