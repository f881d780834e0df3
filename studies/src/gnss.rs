//! The ladder of satellite positioning: figures, services, constellation, ranges.

use crate::clock;
use crate::{Ladder, Options, Outcome, Progress, Row, SceneAbout};
use geodesy::Geodetic;
use models::environment::Weather;
use models::frames::{Point3, Vector3};
use models::plot::{Callsign, SensorId, SensorKind};
use models::sensors::gps::{Diluted, Gps, GpsConfig, GpsModel, Statistical};
use models::sensors::offline::{
    Observation, Offline, OfflineAxes, OfflineConfig, OfflineFit, fit, observe,
};
use models::sensors::reporting::constellation::{SatelliteFailures, SkyConfig};
use models::sensors::reporting::ranging::{RangeBudget, RangingConfig};
use models::sensors::reporting::service::Service;
use models::sensors::{PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use models::time::SimTime;

const SCENE: &str = "standing, 47 N";
/// Deviation of one range at the constellation level, m.
const UERE_M: f64 = 3.6;

struct Standing {
    class: TargetClass,
    count: usize,
}

impl Truth for Standing {
    fn len(&self) -> usize {
        self.count
    }
    fn key(&self, index: usize) -> u64 {
        index as u64
    }
    fn class(&self, _: usize) -> &TargetClass {
        &self.class
    }
    fn callsign(&self, _: usize) -> Callsign {
        Callsign::new("TARGET")
    }
    fn address(&self, _: usize) -> Option<u32> {
        None
    }
    fn at(&self, index: usize, _: SimTime) -> Option<TargetState> {
        Some(TargetState {
            position_m: Point3::new(0.0, index as f64, 0.0),
            velocity_mps: Vector3::zeros(),
            heading_rad: 0.0,
        })
    }
}

/// Names of the rungs, cheap first; the last one is the reference.
const RUNGS: [&str; 4] = ["offline", "statistical", "constellation", "per_satellite"];

/// The exact rung's parameters, and the figures that the cheapest one has of it.
struct Exact {
    ranges: RangingConfig,
    figures: Option<OfflineFit>,
}

impl Exact {
    fn new(seed: u64, truth: &Standing) -> Self {
        let site = Geodetic::from_degrees(47.45, 8.55, 432.0);
        let mut sky = SkyConfig::reference(site, 8.3e8);
        sky.failures = SatelliteFailures::never();
        sky.step_s = 1.0;
        let budget = RangeBudget::modern();
        let ranges = RangingConfig { sky, budget, weighted: false, corrections: None };
        // Satellites and weather of the sky differ from hour to hour: a day, one minute in the hour.
        let mut days = Vec::new();
        let mut looks = 0;
        for hour in 0..24 {
            let mut config = ranges.clone();
            config.sky.epoch_s += 3600.0 * f64::from(hour);
            let model = GpsModel::PerSatellite(config);
            let Ok(mut gps) = Gps::new(GpsConfig::of(SensorId(1), model)) else { continue };
            let (axes, run_seed) = (OfflineAxes::NorthEast, seed + 1000 + hour as u64);
            let seen = observe(&mut gps, truth, &Weather::default(), axes, run_seed, 1.0, 60);
            looks += seen.looks;
            // Another hour is another target: nothing is correlated across.
            days.extend(seen.samples.into_iter().map(|mut s| {
                s.key += 1_000_000 * hour as u64;
                s
            }));
        }
        let seen = Observation { samples: days, looks, false_plots: 0, duration_s: 1440.0 };
        Self { ranges, figures: fit(&seen, 1.0).ok() }
    }

    fn sensor(&self, rung: &str) -> Option<Box<dyn Sensor>> {
        let id = SensorId(1);
        let model = match rung {
            "offline" => {
                let config = OfflineConfig::of(id, SensorKind::Gps, self.figures?);
                return Some(Box::new(Offline::new(config).ok()?));
            }
            "statistical" => GpsModel::Statistical(Statistical {
                service: Service::PERFECT,
                ..Statistical::sps_2020()
            }),
            "constellation" => {
                let sky = SkyConfig { step_s: 10.0, ..self.ranges.sky.clone() };
                GpsModel::Constellation(Diluted { uere_m: UERE_M, ..Diluted::reference(sky) })
            }
            _ => GpsModel::PerSatellite(self.ranges.clone()),
        };
        Some(Box::new(Gps::new(GpsConfig::of(id, model)).ok()?))
    }
}

/// Measures the ladder.
pub(crate) fn run(options: &Options, progress: &mut dyn FnMut(Progress)) -> Outcome {
    let class = TargetClass {
        designator: "A320".into(),
        aircraft: true,
        length_m: 37.6,
        span_m: 35.8,
        height_m: 11.8,
        rcs_m2: 20.0,
        shape: scenarios::shapes::named("narrow"),
    };
    let truth = Standing { class, count: if options.quick { 50 } else { 200 } };
    // Hours apart, so that satellites and their errors are others.
    let (runs, scans) = if options.quick { (30_u32, 20) } else { (200, 20) };
    let mut rows = Vec::new();
    let exact = Exact::new(options.seed, &truth);
    for (done, name) in RUNGS.into_iter().enumerate() {
        let (mut squares, mut nees, mut reports, mut ns) = (Vec::new(), 0.0, 0.0, 0.0);
        for run in 0..runs {
            let Some(mut sensor) = exact.sensor(name) else { continue };
            let begin_s = 3600.0 * f64::from(run);
            let at = |k: u64| SimTime::from_s(begin_s + k as f64);
            let mut sink = PlotSink::default();
            let before = clock::thread_ns();
            for scan in 1..=scans {
                let run_seed = options.seed + u64::from(run);
                let interval = ScanInterval { run_seed, scan, from: at(scan - 1), to: at(scan) };
                sensor.scan(&interval, &truth, &Weather::default(), &mut sink);
            }
            ns += (clock::thread_ns() - before) as f64;
            for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
                let Some(truth_m) = cause.truth_m else { continue };
                let error = plot.position_m - truth_m;
                let (along, across) = (error.dot(&plot.axis), error.dot(&plot.across_axis()));
                squares.push(error.norm_squared());
                nees += along * along / plot.along_m2 + across * across / plot.across_m2;
                reports += 1.0;
            }
        }
        squares.sort_by(f64::total_cmp);
        let enough = !squares.is_empty();
        rows.push(Row {
            group: "positioning".into(),
            scene: SCENE.into(),
            rung: name.into(),
            rmse_m: enough.then(|| (squares.iter().sum::<f64>() / reports).sqrt()),
            p95_m: enough.then(|| squares[squares.len() * 95 / 100].sqrt()),
            nees: enough.then(|| nees / reports),
            ns_per_update: enough.then(|| ns / reports),
            ..Row::default()
        });
        let what = format!("{SCENE} {name}");
        progress(Progress { group: "positioning", what, done: done + 1, total: RUNGS.len() });
    }
    let exact_m = rows.last().and_then(|r| r.rmse_m);
    for row in &mut rows {
        row.error = row.rmse_m.zip(exact_m).map(|(found, exact)| (found - exact).abs());
        row.error_unit = Some("m against per_satellite".into());
    }
    let ladder = Ladder {
        group: "positioning".into(),
        title: "Satellite positioning: figures, services, constellation, ranges".into(),
        about: format!(
            "{runs} runs an hour apart with {} receivers, {scans} s each, no failures. NEES holds each \
             report against the covariance it states. Time is one report, as processor time of the \
             thread, with the sky's share.",
            truth.count
        ),
        error_label: "horizontal position error, m (root mean square)".into(),
        scenes: vec![SceneAbout { name: SCENE.into(), about: "receivers that stand".into() }],
        ..Ladder::default()
    };
    Outcome { ladder, rows, ..Outcome::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rung_is_measured_and_states_its_own_error() {
        let options = Options { quick: true, seed: 1, ..Options::default() };
        let outcome = run(&options, &mut |_| {});
        let names: Vec<_> = outcome.rows.iter().map(|r| r.rung.as_str()).collect();
        assert_eq!(names, RUNGS);
        for row in &outcome.rows {
            println!("{row:?}");
            let (rmse, nees) = (row.rmse_m.expect("reports"), row.nees.expect("reports"));
            // 30 hours of errors common to all receivers: 30 samples of the exact rung.
            assert!(rmse > 2.0 && rmse < 9.0, "{}: {rmse} m", row.rung);
            assert!(nees > 1.0 && nees < 3.5, "{}: {nees}", row.rung);
        }
        assert_eq!(outcome.rows[3].error, Some(0.0));
    }
}
