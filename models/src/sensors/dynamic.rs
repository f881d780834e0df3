//! On-board dead reckoning ("dynamic" sensor): odometer and heading, sent by the target.
//!
//! The position drifts with the way travelled: a scale error of the odometer along the way, a heading
//! error that wanders across it. The drift is taken off where the place is known (a loop, a stand).
//! The covariance follows the same linear equations as the error, so it is what it says.
//!
//! Source: error propagation of dead reckoning, as in Borenstein & Feng, "Measurement and correction
//! of systematic odometry errors", IEEE Trans. Robotics and Automation 12 (1996); figures assumed.

use nalgebra::{Matrix4, Vector4};

use crate::draw::{DrawKey, Purpose, normal_pair};
use crate::environment::Weather;
use crate::frames::{Azimuth, Vector2};
use crate::plot::{SensorId, SensorKind};
use crate::sensors::config::{ConfigError, count, number};
use crate::sensors::cooperative::{Equipage, Fix, Fleet, Reporting, Reports};
use crate::sensors::ranging::ellipse;
use crate::sensors::{PlotSink, ScanInterval, Sensor, Truth};
use crate::time::SimTime;

/// Parameters of a [`Dynamic`].
#[derive(Clone, Debug, PartialEq)]
pub struct DynamicConfig {
    /// Number of the sensor in the scene.
    pub id: SensorId,
    /// Who is equipped.
    pub equipped: Equipage,
    /// Time between two reports of a target, s.
    pub report_s: f64,
    /// Scale error of the odometer, deviation over targets.
    pub sigma_scale: f64,
    /// Heading error at the start, deviation, degrees.
    pub sigma_heading_deg: f64,
    /// Growth of the heading error, degrees per root of an hour.
    pub heading_walk_deg_per_sqrt_h: f64,
    /// Position error at the start and after a reset, m.
    pub sigma_start_m: f64,
    /// White error of each report, m.
    pub sigma_white_m: f64,
    /// Places where the position becomes known again, airport frame, m; at most 256.
    pub resets_m: Vec<Vector2<f64>>,
    /// How near a target must come to one, m.
    pub reset_radius_m: f64,
}

impl DynamicConfig {
    /// 0.5 % of the way along, half a degree across, growing by 3° in an hour.
    #[must_use]
    pub fn odometer(id: SensorId) -> Self {
        Self {
            id,
            equipped: Equipage::all(),
            report_s: 1.0,
            sigma_scale: 0.005,
            sigma_heading_deg: 0.5,
            heading_walk_deg_per_sqrt_h: 3.0,
            sigma_start_m: 1.0,
            sigma_white_m: 0.2,
            resets_m: Vec::new(),
            reset_radius_m: 10.0,
        }
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.reporting().validate()?;
        number("sigma_scale", self.sigma_scale, 0.0, 1.0)?;
        number("sigma_heading_deg", self.sigma_heading_deg, 0.0, 90.0)?;
        number("heading_walk_deg_per_sqrt_h", self.heading_walk_deg_per_sqrt_h, 0.0, 360.0)?;
        number("sigma_start_m", self.sigma_start_m, 1e-3, 1e4)?;
        number("sigma_white_m", self.sigma_white_m, 0.0, 1e4)?;
        count("resets_m", self.resets_m.len(), 0, 256)?;
        for place in &self.resets_m {
            number("reset_east_m", place.x, -1e6, 1e6)?;
            number("reset_north_m", place.y, -1e6, 1e6)?;
        }
        number("reset_radius_m", self.reset_radius_m, 0.0, 1e4)
    }

    fn reporting(&self) -> Reporting {
        Reporting {
            id: self.id,
            kind: SensorKind::Dynamic,
            equipped: self.equipped.clone(),
            period_s: self.report_s,
        }
    }
}

/// Drift of one target: errors east and north (m), of scale, and of heading (rad), with covariance.
#[derive(Clone, Debug)]
struct Drift {
    error: Vector4<f64>,
    covariance: Matrix4<f64>,
    last: (SimTime, Vector2<f64>),
}

impl Drift {
    fn start(config: &DynamicConfig, key: DrawKey, now: SimTime, position_m: Vector2<f64>) -> Self {
        let mut rng = DrawKey { scan: u64::MAX, ..key }.rng(Purpose::Dynamic);
        let (a, b) = normal_pair(&mut rng);
        let (c, d) = normal_pair(&mut rng);
        let sigma = Vector4::new(
            config.sigma_start_m,
            config.sigma_start_m,
            config.sigma_scale,
            config.sigma_heading_deg.to_radians(),
        );
        Self {
            error: Vector4::new(a, b, c, d).component_mul(&sigma),
            covariance: Matrix4::from_diagonal(&sigma.component_mul(&sigma)),
            last: (now, position_m),
        }
    }

    /// The way since the last report adds scale and heading error to the position.
    fn advance(
        &mut self,
        config: &DynamicConfig,
        normal: f64,
        now: SimTime,
        position_m: Vector2<f64>,
    ) {
        let (then, there_m) = self.last;
        let way_m = position_m - there_m;
        let walk = config.heading_walk_deg_per_sqrt_h.to_radians();
        let q = walk * walk * now.since_s(then) / 3600.0;
        // A clockwise heading error turns the way to its right.
        let right_m = Vector2::new(way_m.y, -way_m.x);
        let mut f = Matrix4::identity();
        (f[(0, 2)], f[(1, 2)]) = (way_m.x, way_m.y);
        (f[(0, 3)], f[(1, 3)]) = (right_m.x, right_m.y);
        self.error = f * self.error;
        self.error[3] += q.sqrt() * normal;
        let moved = f * self.covariance * f.transpose();
        self.covariance = 0.5 * (moved + moved.transpose());
        self.covariance[(3, 3)] += q;
        self.last = (now, position_m);
    }

    /// The position becomes known: its error is drawn anew, scale and heading stay as they are.
    fn reset(&mut self, config: &DynamicConfig, (east, north): (f64, f64)) {
        (self.error[0], self.error[1]) =
            (config.sigma_start_m * east, config.sigma_start_m * north);
        for i in 0..2 {
            for j in 0..4 {
                self.covariance[(i, j)] = 0.0;
                self.covariance[(j, i)] = 0.0;
            }
            self.covariance[(i, i)] = config.sigma_start_m * config.sigma_start_m;
        }
    }
}

/// Dead reckoning reported by equipped targets.
#[derive(Clone, Debug)]
pub struct Dynamic {
    config: DynamicConfig,
    reporting: Reporting,
    fleet: Fleet<Drift>,
}

impl Dynamic {
    /// A sensor with these parameters, which knows no target yet.
    ///
    /// # Errors
    /// [`ConfigError`] if a parameter is outside its limits.
    pub fn new(config: DynamicConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let reporting = config.reporting();
        Ok(Self { config, reporting, fleet: Fleet::default() })
    }
}

impl Sensor for Dynamic {
    fn id(&self) -> SensorId {
        self.config.id
    }

    fn kind(&self) -> SensorKind {
        SensorKind::Dynamic
    }

    fn scan(
        &mut self,
        interval: &ScanInterval,
        truth: &dyn Truth,
        _weather: &Weather,
        out: &mut PlotSink,
    ) {
        let (config, reporting) = (&self.config, &self.reporting);
        let mut reports = Reports::new(reporting, truth, out);
        self.fleet.for_each_due(
            reporting,
            interval,
            truth,
            |due| {
                let key = reporting.key(interval, due);
                Drift::start(config, key, due.time, due.state.position_m.xy())
            },
            |drift, due| {
                reports.expected();
                let position_m = due.state.position_m.xy();
                let mut rng = reporting.key(interval, due).rng(Purpose::Dynamic);
                let (walk, _) = normal_pair(&mut rng);
                let (white, fresh) = (normal_pair(&mut rng), normal_pair(&mut rng));
                drift.advance(config, walk, due.time, position_m);
                let known = config
                    .resets_m
                    .iter()
                    .any(|place| (place - position_m).norm() <= config.reset_radius_m);
                if known {
                    drift.reset(config, fresh);
                }
                let p = &drift.covariance;
                let white_m2 = config.sigma_white_m * config.sigma_white_m;
                let (axis, variance_m2) =
                    ellipse([p[(0, 0)] + white_m2, p[(0, 1)], p[(1, 1)] + white_m2]);
                let drift_m = Vector2::new(drift.error[0], drift.error[1]);
                let white_m = config.sigma_white_m * Vector2::new(white.0, white.1);
                let heading = Azimuth::from_rad(due.state.heading_rad).unit();
                reports.push(
                    due,
                    Fix {
                        time: due.time,
                        position_m: position_m + drift_m + white_m,
                        axis,
                        variance_m2,
                        altitude_m: None,
                    },
                    true,
                    &[
                        ("drift along", drift_m.dot(&heading), "m"),
                        ("drift", drift_m.norm(), "m"),
                        ("white error", white_m.norm(), "m"),
                    ],
                );
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Vector3;
    use crate::sensors::testing::Parked;

    fn run(config: DynamicConfig, speed_ms: f64, seconds: u64) -> PlotSink {
        let keys: Vec<u64> = (0..1500).collect();
        let mut truth = Parked::aircraft(&keys);
        truth.velocity_ms = Vector3::new(speed_ms, 0.0, 0.0);
        let mut sensor = Dynamic::new(config).expect("sound");
        let mut sink = PlotSink::default();
        for scan in 1..=seconds {
            sink = PlotSink::default();
            let at = |scan: u64| SimTime(scan as i64 * 1_000_000_000);
            let interval = ScanInterval { run_seed: 6, scan, from: at(scan - 1), to: at(scan) };
            sensor.scan(&interval, &truth, &Weather::default(), &mut sink);
        }
        sink
    }

    fn spread(sink: &PlotSink) -> (f64, f64, f64) {
        let n = sink.plots.len() as f64;
        let (mut east, mut north, mut chi) = (0.0, 0.0, 0.0);
        for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
            let error = plot.position_m - cause.truth_m.expect("a target");
            let (along, across) = (error.dot(&plot.axis), error.dot(&plot.across_axis()));
            chi += along * along / plot.along_m2 + across * across / plot.across_m2;
            east += error.x * error.x;
            north += error.y * error.y;
        }
        ((east / n).sqrt(), (north / n).sqrt(), chi / n)
    }

    #[test]
    fn the_drift_grows_with_the_way_and_is_as_large_as_it_says() {
        let config = DynamicConfig::odometer(SensorId(9));
        let (east, north, chi) = spread(&run(config.clone(), 10.0, 100));
        // 1 km: 5 m along, 8.7 m across by the first half degree; 1 m at the start.
        assert!((east - 26_f64.sqrt()).abs() < 0.4, "{east}");
        assert!(north > 8.0 && north < 10.5, "{north}");
        assert!((chi - 2.0).abs() < 4.0 * 2.0 / 1500_f64.sqrt(), "{chi}");
        let (east, north, chi) = spread(&run(config, 0.0, 100));
        assert!((east - 1.02).abs() < 0.08 && (north - 1.02).abs() < 0.08, "standing: no drift");
        assert!((chi - 2.0).abs() < 0.21, "{chi}");
    }

    #[test]
    fn a_known_place_takes_the_drift_off() {
        // Each target passes its own place at 905 m; 80 m or 0.4 m of drift are left after it.
        let config = DynamicConfig {
            resets_m: (0..250).map(|k| Vector2::new(905.0, f64::from(k) * 100.0)).collect(),
            reset_radius_m: 10.0,
            ..DynamicConfig::odometer(SensorId(9))
        };
        let mut sink = run(config, 10.0, 100);
        sink.plots.truncate(250);
        let (east, _, chi) = spread(&sink);
        assert!(east < 1.3, "{east}");
        assert!((chi - 2.0).abs() < 4.0 * 2.0 / 250_f64.sqrt(), "{chi}");
    }
}
