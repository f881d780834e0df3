//! Truth for the tests of sensors: targets that stand, or roll straight on.

use crate::environment::Weather;
use crate::frames::Point3;
use crate::frames::{Vector2, Vector3};
use crate::plot::Callsign;
use crate::sensors::radar::sample_shapes;
use crate::sensors::{PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use crate::time::SimTime;

/// Outages of the reports of all targets, as a sensor with a report every `period_s` shows them.
#[derive(Debug)]
pub(crate) struct Outages {
    /// Share of expected reports that come.
    pub(crate) share: f64,
    /// Mean length of a gap between two reports of a target, s.
    pub(crate) mean_s: f64,
    /// Number of gaps.
    pub(crate) number: f64,
    /// Errors of the reports (east, north), m, by target and time.
    pub(crate) errors_m: Vec<(u64, SimTime, Vector2<f64>)>,
}

/// Plays `seconds` in scans of 1 s.
pub(crate) fn outages(
    sensor: &mut dyn Sensor,
    truth: &Parked,
    period_s: f64,
    seconds: u64,
) -> Outages {
    let (mut looks, mut errors_m) = (0, Vec::new());
    let mut sink = PlotSink::default();
    for scan in 1..=seconds {
        let at = |scan: u64| SimTime(scan as i64 * 1_000_000_000);
        let interval = ScanInterval { run_seed: 12, scan, from: at(scan - 1), to: at(scan) };
        (sink.looks, _) = (0, (sink.plots.clear(), sink.causes.clear()));
        sensor.scan(&interval, truth, &Weather::default(), &mut sink);
        looks += sink.looks;
        for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
            let truth_m = cause.truth_m.expect("a report has a target");
            let key = cause.key.expect("a report has a target");
            errors_m.push((key, plot.time, plot.position_m - truth_m));
        }
    }
    errors_m.sort_by_key(|e| (e.0, e.1));
    let (mut missing, mut number) = (0.0, 0.0);
    for target in errors_m.chunk_by(|a, b| a.0 == b.0) {
        for pair in target.windows(2) {
            let lost = (pair[1].1.since_s(pair[0].1) / period_s).round() - 1.0;
            missing += lost;
            number += f64::from(u8::from(lost > 0.0));
        }
    }
    let share = errors_m.len() as f64 / looks as f64;
    Outages { share, mean_s: missing * period_s / number, number, errors_m }
}

/// What outages of mean `mean_s` show as, looked at every `period_s`: those that are seen at all.
pub(crate) fn seen_mean_s(mean_s: f64, period_s: f64) -> f64 {
    period_s / -libm::expm1(-period_s / mean_s)
}

/// Targets on a line, 100 m apart, all with the same velocity.
#[derive(Clone, Debug)]
pub(crate) struct Parked {
    keys: Vec<u64>,
    class: TargetClass,
    /// Velocity of all, m/s.
    pub(crate) velocity_mps: Vector3<f64>,
    /// Heading of all, radians clockwise from north.
    pub(crate) heading_rad: f64,
    /// Height of all at the begin, m.
    pub(crate) up_m: f64,
}

impl Parked {
    /// Aircraft with these keys (sorted), standing, nose east.
    pub(crate) fn aircraft(keys: &[u64]) -> Self {
        let class = TargetClass {
            designator: "A320".into(),
            aircraft: true,
            length_m: 37.6,
            span_m: 35.8,
            height_m: 11.8,
            rcs_m2: 20.0,
            shape: super::radar::sample_shapes::of(true),
        };
        Self {
            keys: keys.to_vec(),
            class,
            velocity_mps: Vector3::zeros(),
            heading_rad: std::f64::consts::FRAC_PI_2,
            up_m: 0.0,
        }
    }

    /// The same as vehicles.
    pub(crate) fn of_vehicles(mut self) -> Self {
        self.class.aircraft = false;
        self
    }
}

impl Truth for Parked {
    fn len(&self) -> usize {
        self.keys.len()
    }
    fn key(&self, index: usize) -> u64 {
        self.keys[index]
    }
    fn class(&self, _index: usize) -> &TargetClass {
        &self.class
    }
    fn callsign(&self, index: usize) -> Callsign {
        Callsign::new(&format!("T{}", self.keys[index]))
    }
    fn address(&self, index: usize) -> Option<u32> {
        Some(self.keys[index] as u32)
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        Some(TargetState {
            position_m: Point3::new(0.0, self.keys[index] as f64 * 100.0, self.up_m)
                + self.velocity_mps * time.s(),
            velocity_mps: self.velocity_mps,
            heading_rad: self.heading_rad,
        })
    }
}

/// A class of that size, m, and cross section, m², 10 m high, with the shape of the narrow body, or of the car.
pub(crate) fn class(aircraft: bool, length_m: f64, span_m: f64, rcs_m2: f64) -> TargetClass {
    TargetClass {
        designator: "T".into(),
        aircraft,
        length_m,
        span_m,
        height_m: 10.0,
        rcs_m2,
        shape: sample_shapes::of(aircraft),
    }
}
