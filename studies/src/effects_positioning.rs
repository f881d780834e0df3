//! The effect plan of the sensors other than radars against everything exact: random scenes of each
//! model, the same draws, what the plan loses and saves.

use crate::Row;
use crate::clock::thread_ns;
use crate::effects_common::{between, box_building, exact_row, pick, row};
use geodesy::Geodetic;
use models::draw::{DrawKey, Purpose, uniform};
use models::effects::Tolerance;
use models::effects::positioning::{PositioningEffect, PositioningLevels};
use models::environment::Weather;
use models::frames::{Point2, Point3, Vector2, Vector3};
use models::keys::Holds;
use models::plot::{Callsign, SensorId, SensorKind};
use models::sensors::adsb::AdsbConfig;
use models::sensors::config::ConfigError;
use models::sensors::declared::{Declared, Given, Modelled, Settings, Value};
use models::sensors::dgps::{Budgeted, DgpsConfig, DgpsModel, ReferenceLoss};
use models::sensors::dynamic::DynamicConfig;
use models::sensors::gps::{Diluted, GpsConfig, GpsModel, Statistical};
use models::sensors::induction_loop::LoopConfig;
use models::sensors::mlat::MlatConfig;
use models::sensors::offline::{AxisFigures, OfflineConfig, OfflineFit};
use models::sensors::reporting::constellation::{SatelliteFailures, SkyConfig};
use models::sensors::reporting::cooperative::{Equipage, Equipped};
use models::sensors::reporting::ranging::{RangeBudget, RangeCorrections, RangingConfig};
use models::sensors::reporting::service::Alternating;
use models::sensors::reporting::statistical::NorthEast;
use models::sensors::{KINDS, PlotSink, ScanInterval, TargetClass, TargetState, Truth, models};
use models::time::SimTime;
use rand::rngs::ChaCha8Rng;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;

const ID: SensorId = SensorId(1);

/// Between `low` and `high`, as often in each decade.
fn decades(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low * libm::pow(high / low, uniform(rng))
}

/// Targets that move straight on, or stand; some of them appear later.
#[derive(Clone, Debug)]
struct Traffic {
    class: TargetClass,
    /// Place at time zero, velocity, and when it appears, s.
    targets: Vec<(Point2<f64>, Vector2<f64>, f64)>,
}

impl Traffic {
    fn random(rng: &mut ChaCha8Rng, reach_m: f64) -> Self {
        let class = TargetClass {
            designator: "X".into(),
            aircraft: true,
            length_m: 37.6,
            span_m: 35.8,
            height_m: 11.8,
            rcs_m2: 20.0,
            shape: scenarios::shapes::named("narrow"),
        };
        let fastest = pick(rng, &[0.0, 5.0, 15.0, 70.0]);
        let later = pick(rng, &[0.0, 0.0, 10.0]);
        let target = |rng: &mut ChaCha8Rng| {
            let place =
                Point2::new(between(rng, -reach_m, reach_m), between(rng, -reach_m, reach_m));
            let (sin, cos) = libm::sincos(between(rng, 0.0, std::f64::consts::TAU));
            let speed = fastest * uniform(rng);
            (place, Vector2::new(sin, cos) * speed, later * uniform(rng))
        };
        let count = 1 + (uniform(rng) * 15.0) as usize;
        Self { class, targets: (0..count).map(|_| target(rng)).collect() }
    }

    /// All of them on their way over the place (0, 0) to the east.
    fn over_the_loop(rng: &mut ChaCha8Rng) -> Self {
        let mut traffic = Self::random(rng, 100.0);
        for (place, velocity, appears) in &mut traffic.targets {
            *velocity = Vector2::new(3.0 + velocity.norm().min(27.0), 0.0);
            *place = Point2::new(-60.0 - 100.0 * uniform(rng), between(rng, -8.0, 8.0));
            *appears = 0.0;
        }
        traffic
    }
}

impl Truth for Traffic {
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
    fn address(&self, index: usize) -> Option<u32> {
        Some(index as u32)
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        let (place, velocity, appears) = self.targets[index];
        let position_m = place + velocity * time.s();
        (time.s() >= appears).then(|| TargetState {
            position_m: Point3::new(position_m.x, position_m.y, 0.0),
            velocity_mps: Vector3::new(velocity.x, velocity.y, 0.0),
            heading_rad: if velocity.norm() > 0.0 {
                libm::atan2(velocity.x, velocity.y)
            } else {
                0.0
            },
        })
    }
}

/// One scene: a sensor, its targets and the length of the run.
#[derive(Clone, Debug)]
struct PositioningStudy {
    config: Arc<dyn Settings>,
    truth: Traffic,
    scans: u64,
}

fn service(rng: &mut ChaCha8Rng) -> Alternating {
    if uniform(rng) < 0.3 {
        return Alternating::NEVER_FAILS;
    }
    let outage_s = decades(rng, 2.0, 2000.0);
    Alternating::from_mtbf(decades(rng, 20.0, 1e7), outage_s)
}

fn statistical(rng: &mut ChaCha8Rng) -> Statistical {
    let mut model = Statistical::sps_2020();
    model.service.coverage = service(rng);
    model.service.availability = service(rng);
    model.service.reliability = service(rng);
    let sigma_m = decades(rng, 0.003, 30.0);
    model.error = NorthEast {
        mean_north_m: between(rng, -1.0, 1.0),
        mean_east_m: 0.0,
        sigma_north_m: sigma_m,
        sigma_east_m: 0.7 * sigma_m,
        correlated_share: pick(rng, &[0.0, 0.3, 0.95, 0.9999, 1.0]),
        tau_s: decades(rng, 1.0, 1000.0),
    };
    model
}

fn ranges(rng: &mut ChaCha8Rng, corrections: bool) -> RangingConfig {
    let latitude = between(rng, -65.0, 65.0);
    let site = Geodetic::from_degrees(latitude, between(rng, -180.0, 180.0), 100.0);
    let mut sky = SkyConfig::reference(site, between(rng, 0.0, 8.6e8).floor());
    sky.step_s = pick(rng, &[1.0, 2.0, 10.0]);
    sky.mask_deg = pick(rng, &[5.0, 10.0]);
    let failures = pick(rng, &[0, 1, 2]);
    if failures < 2 {
        sky.failures = SatelliteFailures::never();
    }
    if failures == 0 {
        sky.failures.soft.mtbf = decades(rng, 1e4, 1e9);
        sky.failures.soft.mttr = 600.0;
    }
    let mut budget = RangeBudget::modern();
    let scale = decades(rng, 1e-3, 1.0);
    budget.clock_ephemeris.sigma_m *= scale;
    budget.ionosphere.sigma_m *= scale;
    budget.troposphere.sigma_m *= scale;
    budget.multipath.sigma_m = decades(rng, 1e-3, 1.0);
    budget.multipath.tau_s = decades(rng, 5.0, 500.0);
    budget.noise_m = decades(rng, 1e-3, 0.5);
    if uniform(rng) < 0.2 {
        budget.selective_availability.sigma_m = 24.0;
    }
    let corrections = corrections.then(|| {
        let mut c = RangeCorrections::on_airport();
        c.reference.sigma_m = decades(rng, 1e-3, 0.5);
        c.iono_gradient = decades(rng, 1e-7, 1e-3);
        c.latency_s = pick(rng, &[0.2, 0.5, 5.0]);
        c.period_s = pick(rng, &[0.5, 1.0, 10.0]);
        c
    });
    RangingConfig { sky, budget, weighted: uniform(rng) < 0.5, corrections }
}

/// A configuration by the keys of the kind that has the model, each given or not, within its limits.
fn by_keys(model: &Modelled, rng: &mut ChaCha8Rng, equipped: &Equipage) -> Arc<dyn Settings> {
    let has = |d: &&&Declared| d.models.iter().any(|m| m.model == model.model);
    let declared = KINDS.iter().find(has).expect("a model is of a kind");
    let make = declared.read.expect("a planned model has keys");
    let read = |values: &BTreeMap<String, Value>| {
        let given = Given {
            id: ID,
            preset: declared.kind.presets.first().map_or("", |p| p.0),
            values,
            site_m: Some(Point3::origin()),
            equipped: equipped.clone(),
            reference: Geodetic::from_degrees(47.45, 8.55, 432.0),
            start_utc_ns: 0,
            buildings: &[],
            asked: RefCell::default(),
        };
        make(&given).and_then(|settings| settings.validate().map(|()| settings))
    };
    for _ in 0..100 {
        let mut values = BTreeMap::new();
        for key in declared.kind.keys.iter().flat_map(|group| group.iter()) {
            if !key.needed && uniform(rng) < 0.5 {
                continue;
            }
            let value = match key.holds {
                Holds::Number { least, most } if least > 0.0 => decades(rng, least, most),
                Holds::Number { least, most } => between(rng, least, most),
                Holds::Whole { least, most } => between(rng, least as f64, most as f64).round(),
                _ => continue,
            };
            values.insert(key.word.to_owned(), Value::Number(value));
        }
        if let Ok(settings) = read(&values) {
            return settings;
        }
    }
    read(&BTreeMap::new()).expect("a parameter set is sound")
}

impl PositioningStudy {
    /// Scene number `n` of a model.
    fn random(model: &Modelled, seed: u64, n: u64) -> Self {
        let place = models().position(|m| m.model == model.model).unwrap_or(0) as u32;
        let key = DrawKey { run_seed: seed, sensor: 100 + place, entity: n, scan: 0 };
        let rng = &mut key.rng(Purpose::Study);
        let truth = match model.model.name {
            "loop" => Traffic::over_the_loop(rng),
            _ => {
                let reach_m = pick(rng, &[500.0, 2000.0, 6000.0]);
                Traffic::random(rng, reach_m)
            }
        };
        let share = pick(rng, &[1.0, 1.0, 0.5]);
        let equipped = Equipage { who: Equipped::Share(share), ..Equipage::all() };
        let report_s = pick(rng, &[0.5, 1.0, 2.0]);
        let config = Self::config(model, rng, equipped, report_s);
        Self { config, truth, scans: 40 }
    }

    fn config(
        model: &Modelled,
        rng: &mut ChaCha8Rng,
        equipped: Equipage,
        report_s: f64,
    ) -> Arc<dyn Settings> {
        let gps = |equipped, model| -> Arc<dyn Settings> {
            Arc::new(GpsConfig { equipped, report_s, ..GpsConfig::of(ID, model) })
        };
        match model.model.name {
            "GPS, statistical" => gps(equipped, GpsModel::Statistical(statistical(rng))),
            "GPS, constellation" => {
                let ranges = ranges(rng, false);
                let diluted = Diluted {
                    uere_m: decades(rng, 1e-3, 5.0),
                    correlated_share: pick(rng, &[0.0, 0.5, 0.95, 1.0]),
                    tau_s: decades(rng, 5.0, 500.0),
                    ..Diluted::reference(ranges.sky)
                };
                gps(equipped, GpsModel::Constellation(diluted))
            }
            "GPS, per satellite" => gps(equipped, GpsModel::PerSatellite(ranges(rng, false))),
            "DGPS, budget" | "DGPS, per satellite" => {
                let model = if model.model.name == "DGPS, budget" {
                    let gps = statistical(rng);
                    let mut budgeted = Budgeted { service: gps.service, ..Budgeted::on_airport() };
                    budgeted.budget.sigma_user_m = decades(rng, 0.003, 1.0);
                    budgeted.budget.sigma_ref_m = decades(rng, 0.003, 0.5);
                    budgeted.budget.iono_gradient = decades(rng, 1e-7, 4e-4);
                    budgeted.budget.correction_acceleration_ms2 = pick(rng, &[0.0, 0.0, 0.019]);
                    budgeted.correction_s = pick(rng, &[0.5, 1.0, 10.0]);
                    budgeted.correlated_share = gps.error.correlated_share;
                    budgeted.tau_s = gps.error.tau_s;
                    DgpsModel::Budget(budgeted)
                } else {
                    DgpsModel::PerSatellite(ranges(rng, true))
                };
                let far_m = pick(rng, &[0.0, 3000.0, 80_000.0]);
                let alone = Statistical::sps_2001().error;
                let on_reference_loss =
                    pick(rng, &[ReferenceLoss::NoReport, ReferenceLoss::StandAlone(alone)]);
                Arc::new(DgpsConfig {
                    equipped,
                    report_s,
                    reference: service(rng),
                    on_reference_loss,
                    model,
                    ..DgpsConfig::on_airport(ID, Point2::new(far_m, 0.0))
                })
            }
            "ADS-B" => Arc::new(AdsbConfig {
                equipped,
                nacp: pick(rng, &[9, 10, 11]),
                moving_s: report_s,
                reception: pick(rng, &[0.9, 0.995, 0.9999, 1.0]),
                latency_min_s: pick(rng, &[0.0, 0.1]),
                latency_max_s: pick(rng, &[0.1, 0.11, 0.6]),
                correlated_share: pick(rng, &[0.0, 0.95, 1.0]),
                ..AdsbConfig::surface(ID, between(rng, -70.0, 70.0))
            }),
            "multilateration" => {
                let count = 4 + (uniform(rng) * 5.0) as usize;
                let place = |rng: &mut ChaCha8Rng| {
                    Point2::new(between(rng, -7000.0, 7000.0), between(rng, -7000.0, 7000.0))
                };
                let stations: Vec<_> = (0..count).map(|_| place(rng)).collect();
                let mut config = MlatConfig {
                    equipped,
                    report_s,
                    sigma_t_s: decades(rng, 1e-12, 1e-8),
                    multipath: pick(rng, &[0.0, 1e-4, 0.02]),
                    reception: pick(rng, &[0.9, 0.9999, 1.0]),
                    ..MlatConfig::with_stations(ID, &stations)
                };
                let range_m = pick(rng, &[6000.0, 50_000.0]);
                config.stations.iter_mut().for_each(|s| s.range_m = range_m);
                if uniform(rng) < 0.4 {
                    let (east, north) = (between(rng, -1e3, 1e3), between(rng, -1e3, 1e3));
                    config.buildings = Arc::new([box_building(east, north, 200.0, 60.0, 25.0)]);
                }
                Arc::new(config)
            }
            "loop" => {
                let mut config = LoopConfig::pair_at(ID, Point2::origin(), 90.0);
                if uniform(rng) < 0.5 {
                    config.pair = None;
                }
                config.delay_s = pick(rng, &[0.0, 0.001, 0.05]);
                config.pd = pick(rng, &[0.9, 0.998, 1.0]);
                config.sigma_edge_m = decades(rng, 1e-3, 1.0);
                config.false_per_h = pick(rng, &[0.0, 1e-3, 100.0]);
                Arc::new(config)
            }
            "odometer" => {
                let mut config =
                    DynamicConfig { equipped, report_s, ..DynamicConfig::odometer(ID) };
                config.sigma_scale = decades(rng, 1e-7, 0.01);
                config.sigma_heading_deg = decades(rng, 1e-4, 1.0);
                config.heading_walk_deg_per_sqrt_h = decades(rng, 1e-4, 5.0);
                config.sigma_start_m = decades(rng, 1e-3, 2.0);
                config.sigma_white_m = decades(rng, 1e-3, 1.0);
                config.resets_m = vec![Point2::origin()];
                config.reset_radius_m = 50.0;
                Arc::new(config)
            }
            "off-line figures" => {
                let error = statistical(rng).error;
                let figures = OfflineFit {
                    axes: [error.sigma_north_m, error.sigma_east_m]
                        .map(|sigma_m| AxisFigures { mean_m: 0.1, sigma_m }),
                    correlated_share: error.correlated_share,
                    tau_s: error.tau_s,
                    pd: pick(rng, &[0.8, 0.995, 0.9999, 1.0]),
                    outage_reports: pick(rng, &[1.0, 10.0]),
                    ..OfflineFit::white(error.sigma_north_m, report_s)
                };
                let config = OfflineConfig::of(ID, SensorKind::Gps, figures);
                Arc::new(OfflineConfig { equipped, ..config })
            }
            // A kind that nobody has written a law for: anything that its keys allow.
            _ => by_keys(model, rng, &equipped),
        }
    }
}

/// What a comparison found.
#[derive(Clone, Debug, Default)]
struct Compared {
    /// Reports expected.
    looks: u64,
    /// Reports of both runs that are no farther apart than the tolerance.
    both: u64,
    /// Reports of one run only, or farther apart where something rare that was left out moved one.
    differ: u64,
    /// Largest distance of the others, m.
    worst_m: f64,
    /// Farther apart with nothing left out that could: has to be none.
    broken: Vec<String>,
    /// Rows of the plans, and those skipped.
    rows: u64,
    skipped: u64,
    /// Evaluations of skipped effects: has to be zero.
    evaluated_though_skipped: u64,
    /// Time of either run, ns.
    planned_ns: f64,
    exact_ns: f64,
}

impl Compared {
    fn add(&mut self, other: Self) {
        self.looks += other.looks;
        self.both += other.both;
        self.differ += other.differ;
        self.worst_m = self.worst_m.max(other.worst_m);
        self.broken.extend(other.broken);
        self.rows += other.rows;
        self.skipped += other.skipped;
        self.evaluated_though_skipped += other.evaluated_though_skipped;
        self.planned_ns += other.planned_ns;
        self.exact_ns += other.exact_ns;
    }
}

type Seen = Vec<(Option<u64>, SimTime, Point2<f64>)>;

fn seen(sink: &PlotSink) -> Seen {
    let pairs = sink.plots.iter().zip(&sink.causes);
    pairs.map(|(plot, cause)| (cause.key, plot.time, plot.position_m)).collect()
}

/// Effects that move a report where they happen, and seldom happen.
const RARE: [PositioningEffect; 7] = [
    PositioningEffect::HardFailures,
    PositioningEffect::SoftFailures,
    PositioningEffect::ReferenceOutage,
    PositioningEffect::CorrectionAge,
    PositioningEffect::Multipath,
    PositioningEffect::Reception,
    PositioningEffect::Sight,
];

impl PositioningStudy {
    /// Plays the scene planned and with everything exact, on the same draws.
    fn compare(&self, tolerance: Tolerance) -> Result<Compared, ConfigError> {
        let mut planned = self.config.sensor(tolerance, self.scans as f64)?;
        let mut exact = self.config.model()?;
        exact.planning_mut().fix(PositioningLevels::EXACT);
        let mut found = Compared::default();
        let mut counted: Vec<(&'static str, u64)> = Vec::new();
        let (mut planned_for, mut pending) = (Vec::new(), 0);
        // A delay that is left out puts the report of a loop earlier.
        let slack_ns = SimTime::from_s(self.config.shifts_s()).0;
        for scan in 1..=self.scans {
            let time = |n: u64| SimTime::from_s(n as f64);
            let interval =
                ScanInterval { run_seed: 77, scan, from: time(scan - 1), to: time(scan) };
            let (mut a, mut b) = (PlotSink::default(), PlotSink::default());
            let start = thread_ns();
            planned.scan(&interval, &self.truth, &Weather::default(), &mut a);
            let between = thread_ns();
            exact.scan(&interval, &self.truth, &Weather::default(), &mut b);
            if scan > 1 {
                found.planned_ns += (between - start) as f64;
                found.exact_ns += (thread_ns() - between) as f64;
            }
            found.looks += b.looks;
            let rare = planned.plan().iter().any(|row| {
                row.is_skipped()
                    && row.loss.odds > 0.0
                    && RARE.iter().any(|e| e.name() == row.effect)
            });
            let (a, mut b) = (seen(&a), seen(&b));
            for (key, time, place) in a {
                let near = |other: &(Option<u64>, SimTime, Point2<f64>)| {
                    other.0 == key && (other.1.0 - time.0).abs() <= slack_ns
                };
                let Some(index) = b.iter().position(near) else {
                    found.differ += 1;
                    continue;
                };
                let (_, exact_time, exact_place) = b.swap_remove(index);
                let speed_mps = key.map_or(0.0, |k| self.truth.targets[k as usize - 1].1.norm());
                let late_m = speed_mps * (exact_time.s() - time.s()).abs();
                let apart_m = (place - exact_place).norm() + late_m;
                if apart_m <= tolerance.position_m + 1e-9 {
                    found.both += 1;
                    found.worst_m = found.worst_m.max(apart_m);
                } else if rare {
                    found.differ += 1;
                } else {
                    let rows = planned.plan();
                    found.broken.push(format!("{apart_m} m apart: {:?} {rows:#?}", self.config));
                }
            }
            // Loops report late: what is missing in this scan may have come in the last one.
            found.differ += if slack_ns == 0 { b.len() as u64 } else { 0 };
            // A report that the plan did not reckon with is simulated exactly, and the next scan planned
            // for it: such scans do not count.
            let texts: Vec<_> = planned.plan().iter().map(|row| row.called_for.clone()).collect();
            if texts == planned_for {
                found.evaluated_though_skipped += pending;
            }
            let now = planned.evaluations();
            pending = 0;
            for (row, (effect, times)) in planned.plan().iter().zip(&now) {
                let before = counted.iter().find(|c| c.0 == *effect).map_or(0, |c| c.1);
                pending += if row.is_skipped() { times - before } else { 0 };
            }
            (counted, planned_for) = (now, texts);
        }
        found.rows = planned.plan().len() as u64;
        found.skipped = planned.plan().iter().filter(|row| row.is_skipped()).count() as u64;
        Ok(found)
    }
}

/// Random scenes of every model, planned for a tolerance, against everything exact.
pub(crate) fn measure(
    scenes: u64,
    seed: u64,
    tolerance: Tolerance,
    out: &mut Vec<Row>,
    step: &mut dyn FnMut(&str),
) {
    for model in models() {
        let mut sum = Compared::default();
        let mut failed = Vec::new();
        for n in 0..scenes {
            match PositioningStudy::random(model, seed, n).compare(tolerance) {
                Ok(one) => sum.add(one),
                Err(reason) => failed.push(reason.to_string()),
            }
        }
        failed.append(&mut sum.broken.split_off(0));
        report(
            &format!("{}, {scenes} random scenes", model.model.name),
            &sum,
            tolerance,
            failed,
            out,
        );
        step(model.model.name);
    }
}

fn report(
    scene: &str,
    found: &Compared,
    tolerance: Tolerance,
    mut failed: Vec<String>,
    out: &mut Vec<Row>,
) {
    let rung = format!("planned, {} m, {}", tolerance.position_m, tolerance.detection);
    let row = |what: &str| row(scene, format!("{rung}: {what}"));
    if found.evaluated_though_skipped > 0 {
        failed.push(format!("{} evaluations of skipped effects", found.evaluated_though_skipped));
    }
    if found.both == 0 || found.skipped == 0 {
        failed.push(format!("{} reports, {} effects skipped", found.both, found.skipped));
    }
    let per_look = |ns: f64| (found.looks > 0).then(|| ns / found.looks as f64);
    let what = format!("position ({} of {} effects skipped)", found.skipped, found.rows);
    out.push(Row {
        error: Some(found.worst_m),
        error_unit: Some("m, largest difference of a report".into()),
        ns_per_update: per_look(found.planned_ns),
        failed,
        ..row(&what)
    });
    let share = found.differ as f64 / found.looks.max(1) as f64;
    let over = share > tolerance.detection;
    out.push(Row {
        error: Some(share),
        error_unit: Some("share of reports of one run only, or moved by what is rare".into()),
        failed: if over { vec![format!("{} of {}", found.differ, found.looks)] } else { vec![] },
        ..row("availability")
    });
    out.push(Row {
        error_unit: Some("m, largest difference of a report".into()),
        ..exact_row(scene, per_look(found.exact_ns), found.planned_ns / found.exact_ns.max(1.0))
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planned_and_exact_reports_agree_within_the_tolerance() {
        for tolerance in [
            Tolerance::default(),
            Tolerance { position_m: 5.0, detection: 0.05, ..Tolerance::default() },
            Tolerance { position_m: 0.05, detection: 0.001, ..Tolerance::default() },
        ] {
            let mut rows = Vec::new();
            measure(120, 5, tolerance, &mut rows, &mut |_| ());
            assert_eq!(rows.len(), 3 * models().count());
            for row in &rows {
                let time = row.ns_per_update.unwrap_or(f64::NAN);
                println!("{} | {} | {:?} | {time:.0} ns", row.scene, row.rung, row.error);
            }
            for row in &rows {
                assert!(row.failed.is_empty(), "{} {}: {}", row.scene, row.rung, row.failed[0]);
            }
        }
    }
}
