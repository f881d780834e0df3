//! Sensors: truth and weather in, plots out.

pub mod config;
pub mod declared;
pub mod measurement;
pub mod offline;
pub mod planned;
pub mod radar;
pub mod reporting;

#[cfg(test)]
pub(crate) mod testing;

use crate::environment::Weather;
use crate::frames::{Point3, Vector3};
use crate::plot::{Callsign, Plot};
use crate::time::SimTime;
use radar::shape::Shape;
use std::sync::Arc;

/// Every kind of sensor: its file, and the name of its kind.
macro_rules! kinds {
    ($($file:ident as $name:ident,)+) => {
        $(pub mod $file;)+

        /// Every kind of sensor, in the order in which lists show them.
        pub static KINDS: &[&declared::Declared] = &[$(&$file::DECLARED,)+];

        #[allow(non_upper_case_globals, reason = "named like the kinds of an enumeration")]
        impl crate::kind::SensorKind {
            $(
                #[doc = concat!("The kind that `sensors::", stringify!($file), "` declares.")]
                pub const $name: Self = Self(&$file::DECLARED.kind);
            )+
        }
    };
}

// One line a kind; its file says all else (CONTRIBUTING.md).
kinds! {
    asde as Asde,
    gps as Gps,
    dgps as Dgps,
    adsb as Adsb,
    mlat as Mlat,
    induction_loop as Loop,
    dynamic as Dynamic,
}

/// The planned models of all kinds, and last the one by fitted figures.
pub fn models() -> impl Iterator<Item = &'static declared::Modelled> {
    KINDS.iter().flat_map(|d| d.models).chain([&offline::MODELLED])
}

/// The planned model of that name.
#[must_use]
pub fn model_named(name: &str) -> Option<&'static declared::Modelled> {
    models().find(|m| m.model.name == name)
}

/// Size and echo of a kind of target; shared by all targets of a type.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetClass {
    /// Type designator of `types.csv` ("A320", "FOLLOWME").
    pub designator: String,
    /// Aircraft (true) or ground vehicle.
    pub aircraft: bool,
    /// Length over all, m.
    pub length_m: f64,
    /// Wing span, or width of a vehicle, m.
    pub span_m: f64,
    /// Height over all, m.
    pub height_m: f64,
    /// Median radar cross section, m².
    pub rcs_m2: f64,
    /// Where its echo comes from.
    pub shape: Arc<Shape>,
}

/// One target at one time, airport frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetState {
    /// Reference point (centre), m east, north, up (up from the aerodrome reference plane).
    pub position_m: Point3<f64>,
    /// Velocity, m/s east, north, up.
    pub velocity_mps: Vector3<f64>,
    /// Where the nose points, radians clockwise from north.
    pub heading_rad: f64,
}

/// The truth of one scan interval as the sensors may ask for it: each target at the time it is seen.
///
/// Targets are sorted by `key`; the index is stable within a scan only.
pub trait Truth {
    /// Number of targets.
    fn len(&self) -> usize;
    /// True if there is none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Key of the target for draws and per-target sensor memory; the same in every process and scan.
    fn key(&self, index: usize) -> u64;
    /// Its class.
    fn class(&self, index: usize) -> &TargetClass;
    /// Its name, as its own transponder would report it.
    fn callsign(&self, index: usize) -> Callsign;
    /// Its 24-bit address, where it has one.
    fn address(&self, index: usize) -> Option<u32>;
    /// Whether its transponder answers at `time`.
    fn answers(&self, _index: usize, _time: SimTime) -> bool {
        true
    }
    /// Its state at `time`, or `None` while it does not exist.
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState>;
}

/// One scan of the whole sensor stage: the interval (`from`, `to`] of simulated time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScanInterval {
    /// Seed of the run, for draw keys.
    pub run_seed: u64,
    /// Number of the scan, from 1.
    pub scan: u64,
    /// End of the previous scan (not included).
    pub from: SimTime,
    /// End of this scan (included), the publication time.
    pub to: SimTime,
}

/// What one simulated effect did to one plot; the evaluation log's row, never part of the plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// Name of the effect, as in the plan ("rain attenuation").
    pub effect: &'static str,
    /// What it changed.
    pub value: f64,
    /// Unit of `value` ("dB", "m", "deg").
    pub unit: &'static str,
}

/// Which entity caused a plot and how; kept beside the plots for evaluation, never seen by estimation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cause {
    /// Key of the entity; `None` for false alarms.
    pub key: Option<u64>,
    /// True position at the plot's own time, m (the state the sensor looked at).
    pub truth_m: Option<crate::frames::Point2<f64>>,
    /// What each simulated effect did (filled only where the scan is asked to explain).
    pub effects: Vec<Contribution>,
}

/// Plots of one scan with their causes, index by index.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlotSink {
    /// The plots.
    pub plots: Vec<Plot>,
    /// `causes[i]` belongs to `plots[i]`.
    pub causes: Vec<Cause>,
    /// Looks at targets (expected reports), for Pd statistics.
    pub looks: u64,
    /// Whether to fill `Cause::effects`.
    pub explain: bool,
}

/// A sensor of the scene. `scan` appends the plots of one interval in a fixed order (by target key,
/// then false alarms), so the result depends on nothing but its arguments and the sensor's own state.
pub trait Sensor: Send {
    /// Its number in the scene.
    fn id(&self) -> crate::plot::SensorId;
    /// Its kind.
    fn kind(&self) -> crate::plot::SensorKind;
    /// Its effect plan, for sensors that have one; empty before the first scan.
    fn plan(&self) -> &[crate::effects::PlanRow] {
        &[]
    }
    /// Of a radar: the boxes of its plan met since the last weather notice.
    fn boxes(&self) -> &[asde::plan::PlannedBox] {
        &[]
    }
    /// Of a radar with a budget of time: what it came to in the last scan.
    fn fitted(&self) -> Option<asde::plan::Fitted> {
        None
    }
    /// Of a radar: where the targets of the last scan were.
    fn placed(&self) -> &[asde::Placed] {
        &[]
    }
    /// How often each effect was evaluated so far, in the order of the plan.
    fn evaluations(&self) -> Vec<(&'static str, u64)> {
        Vec::new()
    }
    /// Looks at the truth during `interval` and appends what it reports.
    fn scan(
        &mut self,
        interval: &ScanInterval,
        truth: &dyn Truth,
        weather: &Weather,
        out: &mut PlotSink,
    );
}
