use super::*;
use crate::draw::{Purpose, exponential, normal_pair, uniform};
use crate::effects::Level;
use crate::frames::Point2;
use crate::frames::Point3;
use crate::frames::Vector3;
use crate::plot::Callsign;
use crate::sensors::radar::detection::{from_db, to_db};
use crate::sensors::radar::equation::{BudgetLevels, Echo, Polarisation};
use crate::sensors::radar::extended::ExtentLevel;
use std::f64::consts::TAU;

mod assigned;
mod cells;
mod looks;
mod measured;
mod merged;
mod picture;
mod planned;
mod reckoned;
mod shadows;
mod stated;

type Pair = (f64, f64);

/// Targets that move straight from where they are at time zero.
pub(crate) struct Straight {
    pub(crate) class: TargetClass,
    pub(crate) targets: Vec<(Point3<f64>, Vector3<f64>)>,
}

impl Straight {
    /// From (position, velocity), each (east, north).
    pub(crate) fn new(targets: &[(Pair, Pair)]) -> Self {
        let class = TargetClass {
            designator: "CAR".into(),
            aircraft: false,
            length_m: 4.0,
            span_m: 2.0,
            height_m: 3.0,
            rcs_m2: 10.0,
            shape: crate::sensors::radar::sample_shapes::of(false),
        };
        let vector = |(x, y): Pair| Vector3::new(x, y, 0.0);
        Self {
            class,
            targets: targets.iter().map(|&(p, v)| (vector(p).into(), vector(v))).collect(),
        }
    }
}

impl Truth for Straight {
    fn len(&self) -> usize {
        self.targets.len()
    }
    fn key(&self, index: usize) -> u64 {
        index as u64 + 1
    }
    fn class(&self, _: usize) -> &TargetClass {
        &self.class
    }
    fn callsign(&self, _: usize) -> Callsign {
        Callsign::default()
    }
    fn address(&self, _: usize) -> Option<u32> {
        None
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        let (start, velocity_mps) = self.targets[index];
        let position_m = start + velocity_mps * time.s();
        Some(TargetState { position_m, velocity_mps, heading_rad: 0.0 })
    }
}

pub(crate) fn interval(scan: u64, scan_s: f64) -> ScanInterval {
    let time = |n: u64| SimTime::from_s(n as f64 * scan_s);
    ScanInterval { run_seed: 7, scan, from: time(scan - 1), to: time(scan) }
}

fn asde(change: impl FnOnce(&mut AsdeParameters)) -> Asde {
    let mut parameters = AsdeParameters::ku_band();
    change(&mut parameters);
    Asde::new(SensorId(1), Point2::origin(), parameters).expect("sound parameters")
}

/// Many targets on a ring round the radar: all at the same ratio.
fn ring(count: u32, ground_m: f64, rcs_m2: f64) -> Straight {
    let place = |i: u32| {
        let (sin, cos) = libm::sincos(f64::from(i) / f64::from(count) * std::f64::consts::TAU);
        ((ground_m * sin, ground_m * cos), (0.0, 0.0))
    };
    let targets: Vec<(Pair, Pair)> = (0..count).map(place).collect();
    let mut truth = Straight::new(&targets);
    truth.class.rcs_m2 = rcs_m2;
    truth
}

fn plain() -> RadarLevels {
    RadarLevels::EXACT
        .with(RadarEffect::Extent, Level::Skipped)
        .with(RadarEffect::Merging, Level::Skipped)
        .with(RadarEffect::FalseAlarms, Level::Skipped)
}
