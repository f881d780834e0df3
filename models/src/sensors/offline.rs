//! The off-line approach: a sensor reduced to figures that were fitted from its on-line model.
//!
//! Mean, deviation and correlation time of the error along two axes, share of reports obtained and
//! mean length of an outage. [`observe`] runs an on-line sensor and collects its errors, [`fit`] makes
//! the figures, [`Offline`] draws from them: a first-order Gauss-Markov error and a two-state chain.
//! So one scene can be run with either, and compared in accuracy and in time.
//!
//! What is lost on the way: everything that depends on place, aspect, weather and geometry beyond its
//! average, common errors between targets, false alarms, and errors far outside the rest, whose share
//! is reported ([`OfflineFit::far_share`]).
//!
//! Source: moment fits of an exponential autocorrelation; Cox & Miller, *The Theory of Stochastic
//! Processes* (1965), ch. 3, for the chain.

use crate::draw::{DrawKey, Purpose, uniform};
use crate::effects::positioning::{Ladders, Model, Planning, PositioningEffect as E};
use crate::effects::{Level, Loss, PlanRow};
use crate::environment::Weather;
use crate::frames::{Azimuth, Point2, Vector2};
use crate::plot::{SensorId, SensorKind};
use crate::sensors::config::{ConfigError, number};
use crate::sensors::declared::{Modelled, Settings};
use crate::sensors::planned::Planned;
use crate::sensors::reporting::bounds::{GEOMETRY_SHARE, SIGMAS, given, noise, percent, two};
use crate::sensors::reporting::cooperative::{Equipage, Fix, Fleet, Reporting, Reports, shown};
use crate::sensors::reporting::statistical::Wander;
use crate::sensors::{PlotSink, ScanInterval, Sensor, Truth};
use crate::time::SimTime;

/// Axes of the error figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OfflineAxes {
    /// First axis north, second east.
    NorthEast,
    /// First axis away from a site (east, north, m), second clockwise around it.
    Radial(Point2<f64>),
}

impl OfflineAxes {
    /// The first axis at a place.
    fn at(self, position_m: Point2<f64>) -> Vector2<f64> {
        match self {
            Self::NorthEast => Vector2::new(0.0, 1.0),
            Self::Radial(site_m) => Azimuth::of(position_m - site_m).unit(),
        }
    }

    /// An error at a place along the first and the second axis.
    fn parts(self, position_m: Point2<f64>, error_m: Vector2<f64>) -> [f64; 2] {
        let first = self.at(position_m);
        [error_m.dot(&first), error_m.dot(&Vector2::new(first.y, -first.x))]
    }
}

/// Error of one report, or none, of one target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Key of the target.
    pub key: u64,
    /// Time of the report.
    pub time: SimTime,
    /// Error along the first and the second axis, m.
    pub error_m: [f64; 2],
}

/// What a run of an on-line sensor showed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Observation {
    /// Reports, sorted by target, then time.
    pub samples: Vec<Sample>,
    /// Reports expected.
    pub looks: u64,
    /// Plots without a target.
    pub false_plots: u64,
    /// Simulated time, s.
    pub duration_s: f64,
}

impl Observation {
    /// Adds the plots of one scan, with the errors that are numbers; `target` gives a target its key.
    pub fn add(&mut self, sink: &PlotSink, axes: OfflineAxes, target: impl Fn(u64) -> u64) {
        self.looks += sink.looks;
        for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
            let (Some(key), Some(truth_m)) = (cause.key, cause.truth_m) else {
                self.false_plots += 1;
                continue;
            };
            let error_m = axes.parts(truth_m, plot.position_m - truth_m);
            if error_m.iter().all(|e| e.is_finite()) {
                self.samples.push(Sample { key: target(key), time: plot.time, error_m });
            }
        }
    }
}

/// Runs `sensor` over `scans` intervals of `scan_s` from time 0 and collects its errors.
pub fn observe(
    sensor: &mut dyn Sensor,
    truth: &dyn Truth,
    weather: &Weather,
    axes: OfflineAxes,
    run_seed: u64,
    scan_s: f64,
    scans: u64,
) -> Observation {
    let mut seen = Observation { duration_s: scan_s * scans as f64, ..Observation::default() };
    let at = |scan: u64| SimTime(SimTime::from_s(scan_s).0 * scan as i64);
    for scan in 1..=scans {
        let mut sink = PlotSink::default();
        let interval = ScanInterval { run_seed, scan, from: at(scan - 1), to: at(scan) };
        sensor.scan(&interval, truth, weather, &mut sink);
        seen.add(&sink, axes, |key| key);
    }
    seen.samples.sort_by_key(|s| (s.key, s.time));
    seen
}

/// Figures of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisFigures {
    /// Mean error, m.
    pub mean_m: f64,
    /// Deviation, m.
    pub sigma_m: f64,
}

/// Figures of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OfflineFit {
    /// Errors along the first and the second axis.
    pub axes: [AxisFigures; 2],
    /// Share of the variance that is correlated in time.
    pub correlated_share: f64,
    /// Its correlation time, s.
    pub tau_s: f64,
    /// Share of expected reports that come.
    pub pd: f64,
    /// Mean length of a run of missing reports, in reports, at least 1.
    pub outage_reports: f64,
    /// Time between two reports, s.
    pub period_s: f64,
    /// Share of reports too far off to belong to the rest; left out of the other figures.
    pub far_share: f64,
    /// Reports that the figures rest on.
    pub samples: usize,
}

impl OfflineFit {
    /// Figures that rest on nothing: every report comes, with an error of `sigma_m` along either axis
    /// that is new in each.
    #[must_use]
    pub fn white(sigma_m: f64, period_s: f64) -> Self {
        Self {
            axes: [AxisFigures { mean_m: 0.0, sigma_m }; 2],
            correlated_share: 0.0,
            tau_s: period_s,
            pd: 1.0,
            outage_reports: 1.0,
            period_s,
            far_share: 0.0,
            samples: 0,
        }
    }
}

/// Why no figures could be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FitError {
    /// Too few reports for any figure.
    #[error("{found} reports are too few to fit a sensor; {needed} are needed")]
    TooFew {
        /// Reports found.
        found: usize,
        /// Reports needed.
        needed: usize,
    },
}

/// Fewest reports for a fit.
const FEWEST: usize = 100;
/// Errors beyond so many robust deviations belong to something else (a soft failure, a ghost).
const FAR: f64 = 8.0;

/// Makes the figures of an observation with a report every `period_s`.
///
/// # Errors
/// [`FitError`] with fewer than a hundred reports.
pub fn fit(seen: &Observation, period_s: f64) -> Result<OfflineFit, FitError> {
    let too_few = |found| FitError::TooFew { found, needed: FEWEST };
    if seen.samples.len() < FEWEST {
        return Err(too_few(seen.samples.len()));
    }
    // Robust centre and spread first: median and median deviation.
    let robust = [0, 1].map(|axis| {
        let centre = median(seen.samples.iter().map(|s| s.error_m[axis]).collect());
        let spread =
            median(seen.samples.iter().map(|s| (s.error_m[axis] - centre).abs()).collect());
        (centre, (1.4826 * spread).max(1e-9))
    });
    let near: Vec<Sample> = seen
        .samples
        .iter()
        .filter(|s| (0..2).all(|a| (s.error_m[a] - robust[a].0).abs() <= FAR * robust[a].1))
        .copied()
        .collect();
    if near.len() < FEWEST {
        return Err(too_few(near.len()));
    }
    let n = near.len() as f64;
    let axes = [0, 1].map(|axis| {
        let mean_m = near.iter().map(|s| s.error_m[axis]).sum::<f64>() / n;
        let square = near.iter().map(|s| (s.error_m[axis] - mean_m).powi(2)).sum::<f64>();
        AxisFigures { mean_m, sigma_m: (square / n).sqrt().max(1e-6) }
    });
    let (correlated_share, tau_s) = correlation(&near, &axes, period_s);
    let pd = (seen.samples.len() as f64 / (seen.looks.max(1)) as f64).clamp(0.0, 1.0);
    Ok(OfflineFit {
        axes,
        correlated_share,
        tau_s,
        pd,
        outage_reports: outage_reports(&seen.samples, period_s, pd),
        period_s,
        far_share: 1.0 - n / seen.samples.len() as f64,
        samples: near.len(),
    })
}

fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Share and time of the correlated part: the autocorrelation s e^(−t/τ) at one lag and at the lag
/// where it has fallen to about half.
fn correlation(near: &[Sample], axes: &[AxisFigures; 2], period_s: f64) -> (f64, f64) {
    let rho = |lag: usize| {
        let (mut sum, mut n) = (0.0, 0.0);
        let wanted_ns = SimTime::from_s(period_s * lag as f64).0;
        for target in near.chunk_by(|a, b| a.key == b.key) {
            let mut ahead = 0;
            for early in target {
                while ahead < target.len()
                    && target[ahead].time.0 - early.time.0
                        < wanted_ns - wanted_ns / (4 * lag as i64)
                {
                    ahead += 1;
                }
                let Some(late) = target.get(ahead) else { break };
                if late.time.0 - early.time.0 <= wanted_ns + wanted_ns / (4 * lag as i64) {
                    for (axis, figures) in axes.iter().enumerate() {
                        let unit =
                            |s: &Sample| (s.error_m[axis] - figures.mean_m) / figures.sigma_m;
                        sum += unit(early) * unit(late);
                        n += 1.0;
                    }
                }
            }
        }
        if n > 0.0 { (sum / n, n) } else { (0.0, 0.0) }
    };
    let (first, pairs) = rho(1);
    // Below four deviations of an estimate from nothing, it is nothing.
    if pairs == 0.0 || first < 4.0 / pairs.sqrt() {
        return (0.0, period_s);
    }
    let mut lag = 2;
    loop {
        let (later, pairs) = rho(lag);
        if later < 0.6 * first || lag >= 4096 || pairs < 100.0 {
            let floor = (0.05 * first).max(1e-6);
            let ratio = (first / later.max(floor)).max(1.0 + 1e-6);
            let tau_s = (lag as f64 - 1.0) * period_s / libm::log(ratio);
            let share = first * libm::exp(period_s / tau_s);
            return (share.clamp(0.0, 1.0), tau_s.clamp(1e-3, 1e6));
        }
        lag *= 2;
    }
}

/// Mean run of missing reports between two that came.
fn outage_reports(samples: &[Sample], period_s: f64, pd: f64) -> f64 {
    let (mut missing, mut runs) = (0.0, 0.0);
    for target in samples.chunk_by(|a, b| a.key == b.key) {
        for pair in target.windows(2) {
            let lost = (pair[1].time.since_s(pair[0].time) / period_s).round() - 1.0;
            if lost > 0.0 {
                missing += lost;
                runs += 1.0;
            }
        }
    }
    // Without a closed gap, as if each report were lost by itself.
    if runs > 0.0 { missing / runs } else { 1.0 / pd.max(1e-6) }
}

/// Parameters of an [`Offline`].
#[derive(Clone, Debug, PartialEq)]
pub struct OfflineConfig {
    /// Number of the sensor in the scene.
    pub id: SensorId,
    /// The kind it stands for.
    pub kind: SensorKind,
    /// Who is equipped, or seen.
    pub equipped: Equipage,
    /// Whether it reports identities.
    pub identified: bool,
    /// Axes of the figures.
    pub axes: OfflineAxes,
    /// A place (east, north, m) and the distance from it beyond which nothing is seen, m.
    pub reach: Option<(Point2<f64>, f64)>,
    /// The figures.
    pub figures: OfflineFit,
}

impl OfflineConfig {
    /// In place of a sensor of this kind: everybody, everywhere, errors north and east, and identities
    /// where the kind reports them.
    #[must_use]
    pub fn of(id: SensorId, kind: SensorKind, figures: OfflineFit) -> Self {
        Self {
            id,
            kind,
            equipped: Equipage::all(),
            identified: kind.carried,
            axes: OfflineAxes::NorthEast,
            reach: None,
            figures,
        }
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.reporting().validate()?;
        for axis in &self.figures.axes {
            number("mean_m", axis.mean_m, -1e6, 1e6)?;
            number("sigma_m", axis.sigma_m, 1e-6, 1e6)?;
        }
        if let Some((_, reach_m)) = self.reach {
            number("reach_m", reach_m, 0.0, 1e6)?;
        }
        number("correlated_share", self.figures.correlated_share, 0.0, 1.0)?;
        number("tau_s", self.figures.tau_s, 1e-3, 1e6)?;
        number("pd", self.figures.pd, 0.0, 1.0)?;
        number("outage_reports", self.figures.outage_reports, 1.0, 1e9)
    }

    fn reporting(&self) -> Reporting {
        Reporting {
            id: self.id,
            kind: self.kind,
            equipped: self.equipped.clone(),
            period_s: self.figures.period_s,
            transponder: [SensorKind::Mlat, SensorKind::Adsb].contains(&self.kind),
        }
    }

    /// Probability that a report comes after one that came, and after one that did not: the chain
    /// with the fitted share and mean outage.
    fn chain(&self) -> (f64, f64) {
        let figures = &self.figures;
        let back = 1.0 / figures.outage_reports.max(1.0);
        let lost = if figures.pd > 0.0 { back * (1.0 - figures.pd) / figures.pd } else { 1.0 };
        ((1.0 - lost).max(0.0), if figures.pd > 0.0 { back } else { 0.0 })
    }
}

/// A sensor by its figures.
#[derive(Clone, Debug)]
pub struct Offline {
    config: OfflineConfig,
    reporting: Reporting,
    chain: (f64, f64),
    fleet: Fleet<State>,
    planning: Planning,
}

#[derive(Clone, Debug, Default)]
struct State {
    wander: Wander,
    /// Whether the last report came; drawn when it is first wanted.
    up: Option<bool>,
}

impl Offline {
    /// A sensor with these figures.
    ///
    /// # Errors
    /// [`ConfigError`] if a figure is outside its limits.
    pub fn new(config: OfflineConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let (reporting, chain) = (config.reporting(), config.chain());
        let planning = Planning::new(config.id, &MODEL);
        Ok(Self { config, reporting, chain, fleet: Fleet::default(), planning })
    }
}

impl Planned for Offline {
    fn planning(&self) -> &Planning {
        &self.planning
    }

    fn planning_mut(&mut self) -> &mut Planning {
        &mut self.planning
    }
}

impl Sensor for Offline {
    fn id(&self) -> SensorId {
        self.config.id
    }

    fn kind(&self) -> SensorKind {
        self.config.kind
    }

    fn plan(&self) -> &[PlanRow] {
        self.planning.rows()
    }

    fn evaluations(&self) -> Vec<(&'static str, u64)> {
        self.planning.evaluations()
    }

    fn scan(
        &mut self,
        interval: &ScanInterval,
        truth: &dyn Truth,
        _weather: &Weather,
        out: &mut PlotSink,
    ) {
        let (config, reporting, chain) = (&self.config, &self.reporting, self.chain);
        let figures = &config.figures;
        let [first, second] = figures.axes;
        let planning = &mut self.planning;
        let mut reports = Reports::new(reporting, truth, out);
        if planning.wants_survey(truth.len()) {
            self.fleet.survey(reporting, interval, truth, |s| planning.see(&s.velocity_mps, 0.0));
        }
        planning.prepare(|_| ladders(config));
        self.fleet.for_each_due(
            reporting,
            interval,
            truth,
            |_| State::default(),
            |state, due| {
                let beyond = |&(site_m, reach_m): &(Point2<f64>, f64)| {
                    (due.state.position_m.xy() - site_m).norm() > reach_m
                };
                if config.reach.as_ref().is_some_and(beyond) {
                    return;
                }
                reports.expected();
                let key = reporting.key(interval, due);
                let levels = planning.levels_for(&due.state.velocity_mps, || 0.0);
                // The error goes on whether the report comes or not.
                let share = (figures.correlated_share, figures.tau_s);
                let parts = state.wander.parts(share, key, due.time, &levels, planning);
                if levels.on(E::HardFailures) {
                    planning.count(E::HardFailures);
                    let before = state.up.unwrap_or_else(|| {
                        let start = DrawKey { scan: u64::MAX, ..key };
                        uniform(&mut start.rng(Purpose::Offline)) < figures.pd
                    });
                    let comes = if before { chain.0 } else { chain.1 };
                    let up = uniform(&mut key.rng(Purpose::Offline)) < comes;
                    state.up = Some(up);
                    if !up {
                        return;
                    }
                }
                let unit = parts.total();
                let position_m = due.state.position_m.xy();
                let axis = config.axes.at(position_m);
                let across = Vector2::new(axis.y, -axis.x);
                let error_m = axis * (first.mean_m + first.sigma_m * unit.x)
                    + across * (second.mean_m + second.sigma_m * unit.y);
                reports.push(
                    due,
                    Fix {
                        time: due.time,
                        position_m: position_m + error_m,
                        axis,
                        variance_m2: [
                            first.sigma_m * first.sigma_m,
                            second.sigma_m * second.sigma_m,
                        ],
                        altitude_m: None,
                    },
                    config.identified,
                    || {
                        let norm = |u: Vector2<f64>| {
                            Vector2::new(first.sigma_m * u.x, second.sigma_m * u.y).norm()
                        };
                        [
                            shown(&levels, E::Correlation, norm(parts.lasting()), "m"),
                            shown(&levels, E::White, norm(parts.fresh()), "m"),
                        ]
                    },
                );
            },
        );
    }
}

/// Figures in place of any kind of sensor.
pub static MODELLED: Modelled = Modelled {
    model: &MODEL,
    example: |id| {
        let figures = OfflineFit {
            correlated_share: 0.8,
            tau_s: 100.0,
            pd: 0.95,
            outage_reports: 5.0,
            ..OfflineFit::white(3.0, 1.0)
        };
        Ok(Box::new(Offline::new(OfflineConfig::of(id, SensorKind::Gps, figures))?))
    },
    file: file!(),
};

impl Settings for OfflineConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        self.validate()
    }

    fn timing_s(&self) -> (f64, f64) {
        (self.figures.period_s, 0.0)
    }

    fn model(&self) -> Result<Box<dyn Planned>, ConfigError> {
        Ok(Box::new(Offline::new(self.clone())?))
    }
}

/// What is planned of it.
pub static MODEL: Model = Model {
    name: "off-line figures",
    reads_speed: false,
    reads_distance: false,
    costs: &[
        (E::Geometry, Level::Cheap, 0),
        (E::HardFailures, Level::Exact, 75),
        (E::Correlation, Level::Exact, 135),
        (E::White, Level::Exact, 129),
    ],
};

/// Fitted figures.
fn ladders(config: &OfflineConfig) -> Ladders {
    let f = &config.figures;
    let sigma_m = f.axes[0].sigma_m.max(f.axes[1].sigma_m);
    let [correlated, white] = noise(sigma_m, f.correlated_share, f.tau_s);
    let called = format!("figures of {} reports, fixed by the scene", f.samples);
    Ladders {
        model: &MODEL,
        effects: vec![
            given(E::Geometry, Level::Cheap, called, SIGMAS * GEOMETRY_SHARE * sigma_m),
            two(
                E::HardFailures,
                format!("{} of reports come", percent(f.pd)),
                Loss::odds(1.0 - f.pd),
            ),
            correlated,
            white,
        ],
        step_m: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::gps::{Gps, GpsConfig, GpsModel, Statistical};
    use crate::sensors::reporting::service::{Alternating, Service};
    use crate::sensors::reporting::statistical::NorthEast;
    use crate::sensors::testing::Parked;

    fn gps() -> GpsConfig {
        let service = Service {
            coverage: Alternating::from_share(0.9, 20.0),
            reliability: Alternating::from_share(0.98, 20.0),
            ..Service::PERFECT
        };
        let error = NorthEast {
            mean_north_m: 1.0,
            mean_east_m: -2.0,
            sigma_north_m: 4.0,
            sigma_east_m: 3.0,
            correlated_share: 0.8,
            tau_s: 30.0,
        };
        let model = Statistical { service, error, ..Statistical::sps_1995() };
        GpsConfig::of(SensorId(1), GpsModel::Statistical(model))
    }

    fn fitted(sensor: &mut dyn Sensor) -> OfflineFit {
        let truth = Parked::aircraft(&(0..200).collect::<Vec<_>>());
        let weather = Weather::default();
        let seen = observe(sensor, &truth, &weather, OfflineAxes::NorthEast, 5, 1.0, 1500);
        fit(&seen, 1.0).expect("enough reports")
    }

    /// By hand: errors of ±3 and ±4 cm about their means, one report of four missing.
    #[test]
    fn figures_are_the_moments_of_what_is_near_and_what_is_far_is_counted() {
        let mut seen = Observation { looks: 600, ..Observation::default() };
        for key in 0..4u64 {
            for k in (0..150i64).filter(|k| k % 4 != 3) {
                let (a, b) = ((k * 7 + k / 4) % 2, (k * 3 + k / 8) % 2);
                let error_m = [1.0 + 0.03 * (2 * a - 1) as f64, -2.0 + 0.04 * (2 * b - 1) as f64];
                seen.samples.push(Sample { key, time: SimTime::from_s(2.0 * k as f64), error_m });
            }
        }
        let n = seen.samples.len() as f64;
        // One of each target is far off.
        for key in 0..4 {
            let at = seen.samples.iter().position(|s| s.key == key).expect("one");
            seen.samples[at].error_m = [500.0, -2.0];
        }
        let fit = fit(&seen, 2.0).expect("enough");
        let near = |found: f64, expected: f64, by: f64| {
            assert!((found - expected).abs() < by, "{found} for {expected}: {fit:?}");
        };
        near(fit.axes[0].mean_m, 1.0, 2e-3);
        near(fit.axes[1].mean_m, -2.0, 2e-3);
        near(fit.axes[0].sigma_m, 0.03, 1e-3);
        near(fit.axes[1].sigma_m, 0.04, 1e-3);
        near(fit.far_share, 4.0 / n, 1e-12);
        near(fit.pd, n / 600.0, 1e-12);
        near(fit.outage_reports, 1.0, 1e-12);
        assert_eq!((fit.samples as f64, fit.period_s), (n - 4.0, 2.0));
        seen.samples.truncate(99);
        assert_eq!(super::fit(&seen, 2.0), Err(FitError::TooFew { found: 99, needed: 100 }));
        // Nothing that wanders is nothing: a deviation of a micrometre at least.
        let still = Observation {
            samples: (0..200)
                .map(|k| Sample { key: 0, time: SimTime::from_s(k as f64), error_m: [0.0; 2] })
                .collect(),
            looks: 200,
            ..Observation::default()
        };
        let fit = super::fit(&still, 1.0).expect("enough");
        assert_eq!((fit.axes[0].sigma_m, fit.pd, fit.outage_reports), (1e-6, 1.0, 1.0));
    }

    /// Errors of which a share lasts: e^(−t/τ) of it is left after t.
    #[test]
    fn what_lasts_of_an_error_is_found_with_its_time() {
        for (share, tau_s) in [(0.8, 30.0), (0.5, 10.0), (1.0, 60.0)] {
            let mut seen = Observation::default();
            for key in 0..40 {
                let mut rng = crate::draw::DrawKey { run_seed: 5, sensor: 1, entity: key, scan: 0 }
                    .rng(crate::draw::Purpose::Study);
                let keep = libm::exp(-1.0 / tau_s);
                let (mut a, mut b) = crate::draw::normal_pair(&mut rng);
                for k in 0..500 {
                    let (x, y) = crate::draw::normal_pair(&mut rng);
                    let rest = f64::sqrt(1.0 - keep * keep);
                    (a, b) = (keep * a + rest * x, keep * b + rest * y);
                    let (x, y) = crate::draw::normal_pair(&mut rng);
                    let (lasting, white) = (f64::sqrt(share), f64::sqrt(1.0 - share));
                    let error_m = [2.0 * (lasting * a + white * x), lasting * b + white * y];
                    seen.samples.push(Sample { key, time: SimTime::from_s(f64::from(k)), error_m });
                }
            }
            seen.looks = seen.samples.len() as u64;
            let fit = fit(&seen, 1.0).expect("enough");
            assert!((fit.axes[0].sigma_m / 2.0 - 1.0).abs() < 0.1, "{fit:?}");
            assert!((fit.correlated_share - share).abs() < 0.07, "{share} {tau_s}: {fit:?}");
            assert!((fit.tau_s / tau_s - 1.0).abs() < 0.25, "{share} {tau_s}: {fit:?}");
        }
    }

    #[test]
    fn figures_of_the_figures_are_the_figures() {
        let online = fitted(&mut Gps::new(gps()).expect("sound"));
        let close = |name: &str, found: f64, expected: f64, tolerance: f64| {
            assert!((found - expected).abs() <= tolerance, "{name}: {found}, not {expected}");
        };
        close("north", online.axes[0].sigma_m, 4.0, 0.15);
        close("east", online.axes[1].sigma_m, 3.0, 0.15);
        close("mean north", online.axes[0].mean_m, 1.0, 0.15);
        close("mean east", online.axes[1].mean_m, -2.0, 0.15);
        close("share", online.correlated_share, 0.8, 0.05);
        close("time", online.tau_s, 30.0, 4.0);
        close("obtained", online.pd, 0.9, 0.01);
        close("outage", online.outage_reports, 20.0, 2.0);
        close("far", online.far_share, 0.02, 0.006);
        let config = OfflineConfig::of(SensorId(1), SensorKind::Gps, online);
        let again = fitted(&mut Offline::new(config).expect("sound"));
        close("north again", again.axes[0].sigma_m, online.axes[0].sigma_m, 0.15);
        close("east again", again.axes[1].sigma_m, online.axes[1].sigma_m, 0.15);
        close("time again", again.tau_s, online.tau_s, 4.0);
        close("obtained again", again.pd, online.pd, 0.01);
        close("outage again", again.outage_reports, online.outage_reports, 2.0);
        assert_eq!(again.far_share, 0.0);
    }

    #[test]
    fn figures_name_targets_where_their_kind_does() {
        use crate::sensors::adsb::{Adsb, AdsbConfig};
        use crate::sensors::dgps::{Dgps, DgpsConfig};
        use crate::sensors::dynamic::{Dynamic, DynamicConfig};
        use crate::sensors::mlat::{Mlat, MlatConfig};
        let (id, here) = (SensorId(1), Point2::origin());
        let stations = [(-500.0, -500.0), (4000.0, 0.0), (4000.0, 2500.0), (0.0, 2500.0)]
            .map(|(x, y)| Point2::new(x, y));
        let online: [Box<dyn Sensor>; 5] = [
            Box::new(Gps::new(gps()).expect("sound")),
            Box::new(Dgps::new(DgpsConfig::on_airport(id, here)).expect("sound")),
            Box::new(Adsb::new(AdsbConfig::surface(id, 47.45)).expect("sound")),
            Box::new(Mlat::new(MlatConfig::with_stations(id, &stations)).expect("sound")),
            Box::new(Dynamic::new(DynamicConfig::odometer(id)).expect("sound")),
        ];
        let truth = Parked::aircraft(&[1, 2, 3]);
        let interval =
            ScanInterval { run_seed: 1, scan: 1, from: SimTime::ZERO, to: SimTime::from_s(10.0) };
        for mut online in online {
            let config = OfflineConfig::of(id, online.kind(), OfflineFit::white(1.0, 1.0));
            let mut offline = Offline::new(config).expect("sound");
            let [real, figures] = [online.as_mut(), &mut offline].map(|sensor| {
                let mut sink = PlotSink::default();
                sensor.scan(&interval, &truth, &Weather::default(), &mut sink);
                assert!(!sink.plots.is_empty(), "{:?}", sensor.kind());
                sink.plots.iter().all(|plot| plot.identity.is_some())
            });
            assert_eq!(real, figures, "{:?}", online.kind());
        }
    }

    #[test]
    fn hard_fits_answer() {
        let sample = |k: i64, error_m| Sample { key: 1, time: SimTime(k * 1_000_000_000), error_m };
        let seen = |samples: Vec<Sample>| Observation {
            looks: samples.len() as u64,
            samples,
            false_plots: 0,
            duration_s: 1.0,
        };
        assert_eq!(fit(&seen(vec![]), 1.0), Err(FitError::TooFew { found: 0, needed: 100 }));
        for (name, samples) in [
            ("no error at all", (0..200).map(|k| sample(k, [0.0, 0.0])).collect::<Vec<_>>()),
            ("the same error", (0..200).map(|k| sample(k, [5.0, -5.0])).collect()),
            (
                "one jump",
                (0..200).map(|k| sample(k, [f64::from(u8::from(k > 100)), 0.0])).collect(),
            ),
            ("to and fro", (0..200).map(|k| sample(k, [(k % 2) as f64, 0.0])).collect()),
            ("a long wave", (0..9000).map(|k| sample(k, [(k / 4500) as f64, 0.0])).collect()),
            ("far apart", (0..200).map(|k| sample(k * 1000, [(k % 7) as f64, 1.0])).collect()),
        ] {
            // Slower and quicker: figures stay within what a sensor may have.
            for period_s in [1e-6, 1e-3, 3e3] {
                let mut slower = samples.clone();
                slower.iter_mut().for_each(|s| s.time = SimTime::from_s(s.time.s() * period_s));
                let f = fit(&seen(slower), period_s).expect(name);
                let within = (1e-3..=1e6).contains(&f.tau_s) || f.correlated_share == 0.0;
                assert!(within && (0.0..=1.0).contains(&f.correlated_share), "{name}: {f:?}");
            }
            let figures = fit(&seen(samples), 1.0).expect(name);
            let config = OfflineConfig {
                axes: OfflineAxes::Radial(Point2::origin()),
                ..OfflineConfig::of(SensorId(1), SensorKind::Asde, figures)
            };
            assert!(config.validate().is_ok(), "{name}: {figures:?}");
        }
    }

    /// An error that has gone after one report lasts no less than a third of one: what is left is not known to less than a
    /// twentieth.
    #[test]
    fn what_lasts_one_report_has_a_time_of_a_third_of_one() {
        for seed in 1..=6 {
            let mut seen = Observation::default();
            for key in 0..40 {
                let mut rng =
                    crate::draw::DrawKey { run_seed: seed, sensor: 1, entity: key, scan: 0 }
                        .rng(crate::draw::Purpose::Study);
                let mut before = crate::draw::normal_pair(&mut rng);
                for k in 0..500 {
                    let now = crate::draw::normal_pair(&mut rng);
                    let error_m = [now.0 + before.0, now.1 + before.1];
                    seen.samples.push(Sample { key, time: SimTime::from_s(f64::from(k)), error_m });
                    before = now;
                }
            }
            seen.looks = seen.samples.len() as u64;
            let fit = fit(&seen, 1.0).expect("enough");
            assert!((0.33..0.36).contains(&fit.tau_s), "{fit:?}");
            assert!((0.9..=1.0).contains(&fit.correlated_share), "{fit:?}");
        }
    }
}
