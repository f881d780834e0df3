//! Filters: plots of one target in, its state with covariance out. From cheap to exact, behind one
//! interface ([`StateEstimator`]), so that error and time can be compared before choosing.
//!
//! | rung | what | file |
//! |---|---|---|
//! | `abg` | alpha-beta-gamma: gains computed once | [`steady`] |
//! | `ca3` | constant acceleration per axis: the paper's Kalman filter | [`three_state`] |
//! | `ca3-ud` | the same as U D Uᵀ: cannot lose its positive definiteness | [`ud`] |
//! | `ca6`, `ca6-ud` | both axes joined, with the plot's full covariance | [`six_state`], [`ud`] |
//! | `imm3` | three modes, mixed | [`imm`] |
//! | `mh3`, `mh9`, `mh27` | the 3, 9, 27 most likely histories of modes | [`histories`] |
//! | `mh9-lag1` | the same, published one scan later with what that scan says | [`histories`] |
//! | `events9`, `events27` | histories of accelerations that begin, change and end | [`events`] |
//! | `choice` | `imm3`, or `events27` where the innovations call for it: one at a time | [`chosen`] |
//! | `pair` | `imm3` and `events27`, averaged by the likelihood of the plots | [`averaged`] |
//! | `mh9-map` | histories along a known centreline, and a free filter beside | [`map`], [`route`] |
//! | `rts` | off-line: every state from all plots | [`smoother`] |
//!
//! A filter keeps its state at the time of its last plot. [`StateEstimator::predicted`] gives the
//! state at a later time without changing anything (for gates, for publication); an update predicts
//! to the plot's own time by itself. Time never runs backwards here: a late plot is an error, and
//! the tracker goes back to a saved copy (every filter is cheap to clone).

pub mod bulk;
pub mod choice;
pub mod consistency;
pub mod declared;
pub mod estimator;
pub mod fixed_lag;
pub mod gaussian;
#[cfg(test)]
mod hard_cases;
pub mod lanes;
pub mod mixtures;
pub mod modes;
pub mod motion;
pub mod own;
pub mod route;
pub mod smoother;
#[cfg(test)]
pub(crate) mod testing;
mod turning;
pub mod weights;

use crate::frames::{Matrix2, Point2, Vector2};
use crate::plot::Plot;
use crate::time::SimTime;
pub use declared::Declared;
pub use estimator::Estimator;
pub use gaussian::{Gaussian, Innovation, Measurement, Nis, Sym2, nis_at};
use map::MapKnowledge;
use modes::Modes;
use motion::Motion;
use std::sync::Arc;
use steady::Gains;

/// Why a filter refused a plot. The filter is left as it was; the caller counts the plot and drops it.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum UpdateError {
    /// The innovation covariance (here its least variance or determinant) is not finite and positive.
    #[error("innovation covariance {0:e} is not finite and positive definite")]
    BadInnovation(f64),
    /// The plot (or the time asked for) is this much older than the state, s.
    #[error("{0} s before the time of the state")]
    BackInTime(f64),
    /// A coordinate is not finite, a variance negative or NaN, or one direction only where both are needed.
    #[error("plot with a coordinate that is not finite or a variance that is negative or missing")]
    UnsoundPlot,
    /// The covariance after an update is not finite and positive: start the track again.
    #[error("covariance is not finite and positive definite")]
    BadCovariance,
}

/// The seconds from `from` to `to`.
///
/// # Errors
/// If they are negative.
#[inline]
fn interval(from: SimTime, to: SimTime) -> Result<f64, UpdateError> {
    let t = to.since_s(from);
    if t < 0.0 { Err(UpdateError::BackInTime(-t)) } else { Ok(t) }
}

/// What is assumed of a target seen for the first time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Standard deviation of the unknown velocity, m/s per axis.
    pub sigma_v_mps: f64,
    /// Standard deviation of the unknown acceleration, m/s² per axis.
    pub sigma_a_ms2: f64,
}

impl Default for Start {
    /// 50 m/s and 3 m/s²: any aircraft on or near a runway.
    fn default() -> Self {
        Self { sigma_v_mps: 50.0, sigma_a_ms2: 3.0 }
    }
}

/// State of a target at a time, with covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Time of validity.
    pub time: SimTime,
    /// Mean and covariance.
    pub state: Gaussian,
}

impl Estimate {
    /// This state at this time.
    #[must_use]
    pub fn new(time: SimTime, state: Gaussian) -> Self {
        Self { time, state }
    }
    /// Position, m east and north.
    #[must_use]
    pub fn position_m(&self) -> Point2<f64> {
        self.state.position()
    }
    /// Velocity, m/s east and north.
    #[must_use]
    pub fn velocity_mps(&self) -> Vector2<f64> {
        Vector2::new(self.state.x[1].east(), self.state.x[1].north())
    }
    /// Acceleration, m/s² east and north.
    #[must_use]
    pub fn acceleration_ms2(&self) -> Vector2<f64> {
        Vector2::new(self.state.x[2].east(), self.state.x[2].north())
    }
    /// Covariance of the position, m².
    #[must_use]
    pub fn position_cov_m2(&self) -> Matrix2<f64> {
        self.state.position_cov().matrix()
    }
    /// Covariance of the velocity, m²/s².
    #[must_use]
    pub fn velocity_cov_m2s2(&self) -> Matrix2<f64> {
        let (p, c) = (self.state.p[3], self.state.cross[4]);
        Matrix2::new(p.east(), c, c, p.north())
    }
    /// Covariance of position (row) with velocity (column), m²/s.
    #[must_use]
    pub fn position_velocity_cov_m2s(&self) -> Matrix2<f64> {
        let (p, c) = (self.state.p[1], &self.state.cross);
        Matrix2::new(p.east(), c[1], c[3], p.north())
    }
    /// Ground speed and its standard deviation, m/s. At standstill the larger axis of the velocity's covariance.
    #[must_use]
    pub fn speed_mps(&self) -> (f64, f64) {
        let (v, s) = (self.velocity_mps(), self.state_velocity_cov());
        let speed = libm::hypot(v.x, v.y);
        if speed == 0.0 {
            return (0.0, s.xx.max(s.yy).max(0.0).sqrt());
        }
        (speed, gaussian::quadratic(s, v / speed).max(0.0).sqrt())
    }
    /// Course over ground, radians clockwise from north in [0, 2π), and its standard deviation.
    ///
    /// `None` below 1 m/s or where the deviation is above 30°: keep the last one then.
    #[must_use]
    pub fn heading_rad(&self) -> Option<(f64, f64)> {
        let (v, s) = (self.velocity_mps(), self.state_velocity_cov());
        // No hypot: what is that fast or slow that a square leaves the range has no course anyhow.
        let speed = (v.x * v.x + v.y * v.y).sqrt();
        if !(1.0..f64::INFINITY).contains(&speed) {
            return None;
        }
        let across = Vector2::new(v.y, -v.x) / speed;
        let sigma = gaussian::quadratic(s, across).max(0.0).sqrt() / speed;
        let heading = libm::atan2(v.x, v.y);
        let heading = if heading < 0.0 { heading + std::f64::consts::TAU } else { heading };
        // −1e-17 + 2π rounds to 2π.
        let heading = if heading >= std::f64::consts::TAU { 0.0 } else { heading };
        (sigma <= 30f64.to_radians()).then_some((heading, sigma))
    }
    fn state_velocity_cov(&self) -> Sym2 {
        Sym2 { xx: self.state.p[3].east(), xy: self.state.cross[4], yy: self.state.p[3].north() }
    }
    /// The innovation of a plot against this state; predict to the plot's time first.
    ///
    /// # Errors
    /// If the plot is unsound or the innovation covariance not positive definite.
    #[inline]
    pub fn innovation(&self, plot: &Plot) -> Result<Innovation, UpdateError> {
        self.state.innovation(&Measurement::of(plot)?)
    }
    /// This state without plots until `time`, at constant velocity (spectral density `q`, m²/s³).
    ///
    /// For coasts beyond about two seconds: an acceleration that is not known better than 3 m/s² alone
    /// is 96 m after 8 s.
    ///
    /// # Errors
    /// If `time` is before this state's.
    pub fn coasted(&self, time: SimTime, q: f64) -> Result<Self, UpdateError> {
        let t = interval(self.time, time)?;
        let step = Motion::ConstantVelocity { q }.step(t);
        Ok(Self::new(time, self.state.without_acceleration().predicted(&step)))
    }
}

/// One target's filter: every rung of the ladder offers this.
pub trait StateEstimator: Clone {
    /// Time of the state: that of the last plot.
    fn time(&self) -> SimTime;

    /// The state at [`Self::time`]; of a mixture its mean and covariance.
    fn estimate(&self) -> Estimate;

    /// The state at a later time; nothing is stored.
    ///
    /// # Errors
    /// If `time` is before the state's.
    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError>;

    /// Position (m) and its covariance (m²) at a later time: what a gate asks for, without the rest.
    ///
    /// # Errors
    /// If `time` is before the state's.
    #[inline]
    fn position_at(&self, time: SimTime) -> Result<(Point2<f64>, Sym2), UpdateError> {
        let at = self.predicted(time)?.state;
        Ok((at.position(), at.position_cov()))
    }

    /// Position (m) at a later time.
    ///
    /// # Errors
    /// If `time` is before the state's.
    #[inline]
    fn place_at(&self, time: SimTime) -> Result<Point2<f64>, UpdateError> {
        Ok(self.position_at(time)?.0)
    }

    /// Position (m) and velocity (m/s) at [`Self::time`].
    #[inline]
    fn motion(&self) -> (Point2<f64>, Vector2<f64>) {
        let now = self.estimate();
        (now.position_m(), now.velocity_mps())
    }

    /// The same if the state may be used, see [`Gaussian::is_sound`].
    #[inline]
    fn sound_motion(&self) -> Option<(Point2<f64>, Vector2<f64>)> {
        let state = self.estimate().state;
        state.is_sound().then(|| state.motion())
    }

    /// Predicts to the plot's time and takes the plot.
    ///
    /// # Errors
    /// If the plot is late or unsound, or the innovation covariance not positive definite; the filter
    /// is left as it was.
    fn update(&mut self, plot: &Plot) -> Result<Nis, UpdateError>;

    /// [`Self::update`] as it flies: filters that know one motion only take a plot that it cannot explain (beyond
    /// 99.99 %) as a manoeuvre. Bare, they were worse than the plots when a vehicle brakes hard.
    ///
    /// # Errors
    /// As [`Self::update`].
    #[inline]
    fn take(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        self.update(plot)
    }

    /// The same for a plot that only a kinematic gate accepted: a manoeuvre that the model did not
    /// foresee. The prediction is widened until the plot fits (mode filters raise their jump mode instead).
    ///
    /// # Errors
    /// As [`Self::update`].
    fn update_manoeuvre(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        let mut at = self.predicted(plot.time)?;
        let m = Measurement::of(plot)?;
        let innovation = at.state.innovation(&m)?;
        at.state.inflate(&innovation, interval(self.time(), plot.time)?, MANOEUVRE_D2);
        let nis = at.state.update(&m)?;
        self.replace(plot.time, &at.state);
        Ok(nis)
    }

    /// Takes several plots of one time of which at most one is of this target, with the probability of
    /// each (joint probabilistic data association); the rest of 1 is "none of them".
    ///
    /// # Errors
    /// As [`Self::update`]; also for an empty list.
    fn update_weighted(&mut self, plots: &[(&Plot, f64)]) -> Result<(), UpdateError> {
        let Some((first, _)) = plots.first() else { return Err(UpdateError::UnsoundPlot) };
        let mut at = self.predicted(first.time)?;
        at.state.update_weighted(&measurements(plots)?)?;
        self.replace(first.time, &at.state);
        Ok(())
    }

    /// Starts again from the last two plots, the older one first; what was known before is forgotten.
    ///
    /// # Errors
    /// If a plot is unsound or the second one is not later than the first.
    fn restart(&mut self, first: &Plot, last: &Plot) -> Result<(), UpdateError> {
        let state = two_plot_start(first, last, self.start(), false)?;
        self.replace(last.time, &state);
        Ok(())
    }

    /// Sets the state; mode filters forget what they knew of modes.
    fn replace(&mut self, time: SimTime, state: &Gaussian);

    /// What is assumed of a new target.
    fn start(&self) -> Start;

    /// The state one update ago as it is known now, where the rung keeps it (one scan of lag).
    fn lagged(&self) -> Option<Estimate> {
        None
    }
}

/// Squared innovations beyond this are no error of measurement: the 99.99 % quantile of χ² with two degrees of freedom, as
/// the gate of plots with a name.
pub(crate) const SURPRISING_D2: f64 = 18.43;

/// [`StateEstimator::take`] of a filter that knows one motion only.
fn taken<F: StateEstimator>(filter: &mut F, plot: &Plot) -> Result<Nis, UpdateError> {
    let before = filter.clone();
    let nis = filter.update(plot)?;
    if !(nis.d2 > SURPRISING_D2) {
        return Ok(nis);
    }
    *filter = before;
    filter.update_manoeuvre(plot)
}

/// The 90 % quantile of χ² with two degrees of freedom: an innovation that fits, but only just.
pub(crate) const MANOEUVRE_D2: f64 = 4.6;

fn measurements(plots: &[(&Plot, f64)]) -> Result<Vec<(Measurement, f64)>, UpdateError> {
    plots.iter().map(|(plot, beta)| Ok((Measurement::of(plot)?, *beta))).collect()
}

/// The state after two plots, see [`Gaussian::from_two`].
///
/// # Errors
/// If a plot is unsound or the second one is not later than the first.
pub fn two_plot_start(
    first: &Plot,
    last: &Plot,
    start: Start,
    vague: bool,
) -> Result<Gaussian, UpdateError> {
    let t = interval(first.time, last.time)?;
    if t == 0.0 {
        return Err(UpdateError::BackInTime(0.0));
    }
    let (one, two) = (three_state::start_position(first)?, three_state::start_position(last)?);
    Ok(Gaussian::from_two(one, two, t, start.sigma_a_ms2, vague))
}

/// Every rung, from cheap to exact: the file that is new with it, its name here, where it declares itself.
macro_rules! rungs {
    ($($([$file:ident])? $name:ident = $declared:path,)+) => {
        $($(pub mod $file;)?)+

        /// Which filter.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Rung {
            $(#[doc = concat!("Declared by `filter::", stringify!($declared), "`.")] $name,)+
        }

        impl Rung {
            /// All rungs with their names, from cheap to exact.
            pub const ALL: [(Self, &'static str); [$(stringify!($name)),+].len()] =
                [$((Self::$name, $declared.word)),+];

            /// What its file says of it.
            #[must_use]
            pub fn declared(self) -> &'static Declared {
                match self { $(Self::$name => &$declared,)+ }
            }
        }
    };
}

// One line a rung; its file says all else (CONTRIBUTING.md).
rungs! {
    [steady] Abg = steady::ABG,
    [three_state] Ca3 = three_state::CA3,
    [ud] Ca3Ud = ud::CA3_UD,
    [six_state] Ca6 = six_state::CA6,
    Ca6Ud = ud::CA6_UD,
    [imm] Imm3 = imm::IMM3,
    [histories] Mh3 = histories::MH3,
    Mh9 = histories::MH9,
    Mh27 = histories::MH27,
    Mh9Lag1 = histories::MH9_LAG1,
    [map] Mh9Map = map::MH9_MAP,
    [events] Events9 = events::EVENTS9,
    Events27 = events::EVENTS27,
    [chosen] Choice = chosen::CHOICE,
    [averaged] Pair = averaged::PAIR,
}

impl Rung {
    /// The rung of this name.
    #[must_use]
    pub fn of(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, n)| *n == name).map(|(rung, _)| *rung)
    }

    /// Its name in scenes and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.declared().word
    }
}

/// Which filter with which numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct FilterConfig {
    /// The rung.
    pub rung: Rung,
    /// Spectral density of the jerk for the single-model rungs, m²/s⁵.
    pub q: f64,
    /// `ca3` for targets that only roll on: constant velocity, and `q` the density of the acceleration, m²/s³.
    pub rolling: bool,
    /// Gains of the alpha-beta-gamma filter.
    pub gains: Arc<Gains>,
    /// What is assumed of a new target.
    pub start: Start,
    /// The modes of the mode filters; `imm3` and `mh9-map` need three.
    pub modes: Arc<Modes>,
    /// Centrelines, for `mh9-map`; without a map that rung is `imm3`.
    pub map: Option<Arc<MapKnowledge>>,
}

impl FilterConfig {
    /// `rung` with the defaults of the other fields.
    #[must_use]
    pub fn new(rung: Rung) -> Self {
        let modes = Arc::new((rung.declared().modes)());
        let start = Start::default();
        // Λ = 0.05 at one plot a second: 30 % less variance on a target that follows the model.
        let gains = Arc::new(Gains::new(0.05, 1.0, start, 3.0));
        Self { rung, q: 0.3, rolling: false, gains, start, modes, map: None }
    }
}

impl FilterConfig {
    /// How many modes the rung switches between; 1 for those that know one motion only.
    #[must_use]
    pub fn modes_of_rung(&self) -> usize {
        match self.rung.declared().histories {
            None => 1,
            Some(_) => self.modes.count(),
        }
    }
}
