//! The off-line approach against the on-line chain: figures fitted from a scene's own sensors and
//! tracker, then the same scene with either, on other seeds.

use crate::profiles::{Seen, report_of, see_with, targets, track};
use crate::report::{STYLE, percent};
use crate::{chart, clock, zurich};
use models::environment::Weather;
use models::fusion::Tracker;
use models::fusion::offline::{
    self, Figures, Motion, OfflineTracker, Sample as TrackSample, TrueState, axes,
};
use models::plot::{Callsign, SensorKind};
use models::score::areas::{AreaMap, AreaRules};
use models::score::recording::{Recording, Report, Target};
use models::score::robust::quantile;
use models::score::run::{Rules, Score, score};
use models::sensors::offline::{Observation, Offline, OfflineAxes, OfflineConfig, OfflineFit, fit};
use models::sensors::reporting::cooperative::{Equipage, Equipped};
use models::sensors::{PlotSink, ScanInterval, Sensor, Truth};
use models::time::SimTime;
use scenarios::{Scene, SensorScene};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// Figures of one sensor.
#[derive(Clone, Debug)]
pub struct SensorFit {
    /// Its name in the scene.
    pub name: String,
    /// Its kind.
    pub kind: SensorKind,
    /// The figures, or why there are none.
    pub figures: Result<OfflineFit, String>,
    /// Whom it saw.
    pub seen: BTreeSet<Callsign>,
    /// Farthest report from its site, m; beyond that it sees nothing.
    pub reach_m: f64,
}

/// One way of running the scene.
#[derive(Clone, Debug)]
pub struct Way {
    /// What it is.
    pub name: &'static str,
    /// The score, summed over the seeds by its errors.
    pub score: Score,
    /// Processor time of the sensors for one scan, µs.
    pub sensors_us: f64,
    /// Processor time of the tracking for one scan, µs.
    pub tracking_us: f64,
}

/// Everything that `seeds fit` tells.
#[derive(Clone, Debug)]
pub struct FitReport {
    /// The scene.
    pub scene: String,
    /// Its hash.
    pub scene_hash: u64,
    /// Seeds that the figures were fitted on.
    pub fitted_on: Vec<u64>,
    /// Seeds of the comparison.
    pub compared_on: Vec<u64>,
    /// The version of the program.
    pub version: String,
    /// Sensor by sensor.
    pub sensors: Vec<SensorFit>,
    /// The tracker, or why there are no figures.
    pub tracker: Result<Figures, String>,
    /// The ways, on-line first.
    pub ways: Vec<Way>,
}

/// Makes the sensors of a scene.
pub type Make<'a> = &'a dyn Fn() -> Result<Vec<Box<dyn Sensor>>, String>;

/// Whether the scene has movements that can be fitted on in its first `seconds`.
///
/// # Errors
/// One sentence if it has none: traffic that behaves is stepped in a run, and not known here.
pub fn has_movements(scene: &Scene, seconds: f64) -> Result<(), String> {
    if targets(scene, seconds).iter().all(|target| target.path.is_empty()) {
        return Err(format!(
            "scene {}: nobody moves in its first {seconds} s by a recording or a route, and figures are fitted on \
             these alone: traffic that behaves (a schedule, generated flights) only moves in a run",
            scene.name
        ));
    }
    Ok(())
}

/// Fits a scene's sensors and tracker on one seed and compares on-line with off-line on others.
///
/// # Errors
/// One sentence if a sensor cannot be made, or nobody moves (see [`has_movements`]).
pub fn run(
    scene: &Scene,
    make: Make<'_>,
    seeds: (u64, u64),
    seconds: f64,
    version: &str,
    progress: &mut dyn FnMut(&str),
) -> Result<FitReport, String> {
    let (first, count) = seeds;
    let fitted_on: Vec<u64> = (first..first + count).collect();
    let compared_on: Vec<u64> = (first + count..first + 2 * count).collect();
    let seconds = seconds.min(scene.run.duration.s());
    has_movements(scene, seconds)?;
    let paths = targets(scene, seconds);
    let mut sensors = Vec::new();
    for (index, about) in scene.sensors.iter().enumerate() {
        progress(&format!("fitting sensor {}", about.name));
        sensors.push(sensor_fit(scene, about, index, make, &fitted_on, seconds)?);
    }
    progress("fitting the tracker");
    let mut samples = Vec::new();
    for (run, &seed) in fitted_on.iter().enumerate() {
        let seen = see_with(scene, make()?, seed, seconds);
        samples.extend(track_samples(scene, &seen, &paths, run as u64));
    }
    samples.sort_by_key(|s| (s.key, s.scan));
    let tracker = offline::fit(&samples).map_err(|e| e.to_string());
    let mut ways = Vec::new();
    progress("on-line sensors, on-line tracker");
    ways.push(compare("on-line sensors and tracker", scene, &paths, &compared_on, |seed| {
        let seen = see_with(scene, make()?, seed, seconds);
        let (reports, times) = track_scans(&seen, scene);
        Ok(Run { reports, plots: seen.radar, sensors_ns: seen.sensors_ns, tracking_ns: times })
    })?);
    progress("off-line sensors, on-line tracker");
    ways.push(compare("off-line sensors, on-line tracker", scene, &paths, &compared_on, |seed| {
        let seen = see_with(scene, substitutes(scene, &sensors), seed, seconds);
        let (reports, times) = track_scans(&seen, scene);
        Ok(Run { reports, plots: seen.radar, sensors_ns: seen.sensors_ns, tracking_ns: times })
    })?);
    if let Ok(figures) = &tracker {
        progress("off-line tracking");
        ways.push(compare("off-line tracking, no sensors", scene, &paths, &compared_on, |seed| {
            Ok(drawn(scene, figures, seed, seconds))
        })?);
    }
    Ok(FitReport {
        scene: scene.name.clone(),
        scene_hash: scene.hash,
        fitted_on,
        compared_on,
        version: version.to_owned(),
        sensors,
        tracker,
        ways,
    })
}

/// What one sensor does over the scene, with the scene's own weather.
fn sensor_fit(
    scene: &Scene,
    about: &SensorScene,
    index: usize,
    make: Make<'_>,
    seeds: &[u64],
    seconds: f64,
) -> Result<SensorFit, String> {
    let truth = zurich::Traffic(scene);
    let axes = axes_of(about);
    let site = about.site_m.map(|s| s.xy());
    let scan_ns = scene.run.scan().0;
    let scans = (seconds * 1e9) as i64 / scan_ns;
    let mut seen = Observation::default();
    let (mut names, mut reach_m) = (BTreeSet::new(), 0.0f64);
    for (run, &run_seed) in seeds.iter().enumerate() {
        let mut all = make()?;
        if index >= all.len() {
            return Err(format!("sensor '{}' was not made", about.name));
        }
        let mut sensor = all.swap_remove(index);
        for scan in 1..=scans {
            let (from, to) = (SimTime((scan - 1) * scan_ns), SimTime(scan * scan_ns));
            let notice = scene.weather.iter().rev().find(|n| n.time <= from);
            let weather = notice
                .map_or_else(Weather::default, |n| n.weather.after(from.since_s(n.time).max(0.0)));
            let interval = ScanInterval { run_seed, scan: scan as u64, from, to };
            let mut sink = PlotSink::default();
            sensor.scan(&interval, &truth, &weather, &mut sink);
            // Another run is another target.
            seen.add(&sink, axes, |key| key + 1_000_000 * run as u64);
            for cause in &sink.causes {
                let (Some(key), Some(truth_m)) = (cause.key, cause.truth_m) else { continue };
                names.insert(truth.callsign(key as usize));
                reach_m = site.map_or(f64::INFINITY, |s| reach_m.max((truth_m - s).norm()));
            }
        }
        seen.duration_s += seconds;
    }
    seen.samples.sort_by_key(|s| (s.key, s.time));
    let figures = fit(&seen, period_s(&seen)).map_err(|e| e.to_string());
    Ok(SensorFit { name: about.name.clone(), kind: about.kind, figures, seen: names, reach_m })
}

/// Radars and loops err along and across their sight, reports north and east.
fn axes_of(about: &SensorScene) -> OfflineAxes {
    match (about.kind.radar, about.site_m) {
        (true, Some(site)) => OfflineAxes::Radial(site.xy()),
        _ => OfflineAxes::NorthEast,
    }
}

/// The usual time between two reports of a target, to the millisecond.
fn period_s(seen: &Observation) -> f64 {
    let mut steps: Vec<f64> = Vec::new();
    for target in seen.samples.chunk_by(|a, b| a.key == b.key) {
        steps.extend(target.windows(2).map(|w| w[1].time.since_s(w[0].time)));
    }
    steps.sort_by(f64::total_cmp);
    let middle = quantile(&steps, 0.5).unwrap_or(1.0);
    ((middle * 1000.0).round() / 1000.0).max(0.05)
}

/// The sensors of the scene by their figures; those without figures are left out.
fn substitutes(scene: &Scene, fits: &[SensorFit]) -> Vec<Box<dyn Sensor>> {
    let make = |(about, fit): (&SensorScene, &SensorFit)| -> Option<Box<dyn Sensor>> {
        let figures = *fit.figures.as_ref().ok()?;
        let who = Equipped::Callsigns(fit.seen.clone());
        let config = OfflineConfig {
            equipped: Equipage { who, ..Equipage::all() },
            axes: axes_of(about),
            reach: about.site_m.map(|s| (s.xy(), fit.reach_m)).filter(|r| r.1.is_finite()),
            ..OfflineConfig::of(about.id, about.kind, figures)
        };
        Some(Box::new(Offline::new(config).ok()?))
    };
    scene.sensors.iter().zip(fits).filter_map(make).collect()
}

/// Errors of the published tracks against the target that most of their plots came from: the nearest
/// one within the score's limit.
fn track_samples(scene: &Scene, seen: &Seen, paths: &[Target], run: u64) -> Vec<TrackSample> {
    let mut tracker = Tracker::new(scene.tracking_config());
    let limit_m = Rules::default().pair_m;
    let mut samples = Vec::new();
    let mut before: BTreeMap<usize, models::frames::Vector2<f64>> = BTreeMap::new();
    for (scan, (to, plots)) in seen.scans.iter().enumerate() {
        let tracks = tracker.scan(*to, plots, &scene.flight_list);
        let reports: Vec<Report> = tracks.iter().filter_map(|t| report_of(t, *to)).collect();
        let here: Vec<_> =
            paths.iter().enumerate().filter_map(|(k, p)| Some((k, p.at(*to, 2.5)?))).collect();
        let places: Vec<_> = here.iter().map(|h| h.1.position_m).collect();
        let found: Vec<_> = reports.iter().map(|r| r.position_m).collect();
        let pairs = models::score::gospa(&places, &found, limit_m, 2.0).pairs;
        for (h, (target, truth)) in here.iter().enumerate() {
            let old = before.insert(*target, truth.velocity_mps).unwrap_or(truth.velocity_mps);
            let motion = Motion::of(old, truth.velocity_mps, scene.run.scan().s());
            let error = pairs.iter().find(|p| p.0 == h).map(|p| {
                let report = &reports[p.1];
                let (ahead, right) = axes(truth.velocity_mps);
                let e = report.position_m - truth.position_m;
                let v = report.velocity_mps.unwrap_or(truth.velocity_mps) - truth.velocity_mps;
                [e.dot(&ahead), e.dot(&right), v.dot(&ahead), v.dot(&right)]
            });
            let key = run * 1_000_000 + *target as u64;
            samples.push(TrackSample { key, scan: scan as u64, motion, error });
        }
    }
    samples
}

struct Run {
    reports: Vec<Report>,
    plots: models::score::recording::PlotSum,
    sensors_ns: f64,
    tracking_ns: f64,
}

fn track_scans(seen: &Seen, scene: &Scene) -> (Vec<Report>, f64) {
    let begin = clock::thread_ns();
    let (reports, _) = track(seen, &scene.tracking_config(), &scene.flight_list);
    (reports, (clock::thread_ns() - begin) as f64)
}

/// Tracks drawn from figures.
fn drawn(scene: &Scene, figures: &Figures, seed: u64, seconds: f64) -> Run {
    let truth = zurich::Traffic(scene);
    let scan = scene.run.scan();
    let mut tracker = OfflineTracker::new(figures.clone(), scan.s());
    let mut reports = Vec::new();
    let mut tracking_ns = 0.0;
    for number in 1..=(seconds * 1e9) as i64 / scan.0 {
        let time = SimTime(number * scan.0);
        let states: Vec<TrueState> = (0..truth.len())
            .filter_map(|index| {
                let state = truth.at(index, time)?;
                Some(TrueState {
                    key: index as u64,
                    position_m: state.position_m.xy(),
                    velocity_mps: state.velocity_mps.xy(),
                })
            })
            .collect();
        let begin = clock::thread_ns();
        let tracks = tracker.scan(seed, number as u64, &states);
        tracking_ns += (clock::thread_ns() - begin) as f64;
        reports.extend(tracks.into_iter().map(|t| Report {
            track: t.key,
            time,
            published: Some(time),
            position_m: t.position_m,
            velocity_mps: Some(t.velocity_mps),
            label: truth.callsign(t.key as usize).as_str().to_owned(),
        }));
    }
    let plots = models::score::recording::PlotSum::default();
    Run { reports, plots, sensors_ns: 0.0, tracking_ns }
}

fn compare(
    name: &'static str,
    scene: &Scene,
    paths: &[Target],
    seeds: &[u64],
    mut play: impl FnMut(u64) -> Result<Run, String>,
) -> Result<Way, String> {
    let areas = AreaMap::of(&scene.airport.layout, AreaRules::default());
    let rules = Rules { scan_s: scene.run.scan().s(), ..Rules::default() };
    let mut way = Way { name, score: Score::default(), sensors_us: 0.0, tracking_us: 0.0 };
    for (number, &seed) in seeds.iter().enumerate() {
        let run = play(seed)?;
        let mut recording =
            Recording { targets: paths.to_vec(), reports: run.reports, plots: run.plots };
        recording.put_in_order();
        let found = score(&recording, &areas, &rules);
        let scans = (found.scans.max(1) * seeds.len() as u64) as f64;
        way.sensors_us += run.sensors_ns * 1e-3 / scans;
        way.tracking_us += run.tracking_ns * 1e-3 / scans;
        if number == 0 {
            way.score = found;
        } else {
            add(&mut way.score, found, number as f64);
        }
    }
    Ok(way)
}

/// Joins the score of one more run: errors together, averages over `runs` + 1.
fn add(sum: &mut Score, one: Score, runs: f64) {
    for area in one.areas {
        match sum.areas.iter_mut().find(|a| a.area == area.area) {
            Some(own) => own.join(&area),
            None => sum.areas.push(area),
        }
    }
    let mean = |a: &mut f64, b: f64| *a = (*a * runs + b) / (runs + 1.0);
    mean(&mut sum.gospa.total_m, one.gospa.total_m);
    mean(&mut sum.gospa.per_root_m, one.gospa.per_root_m);
    mean(&mut sum.gospa.localisation_m2, one.gospa.localisation_m2);
    mean(&mut sum.gospa.missed_m2, one.gospa.missed_m2);
    mean(&mut sum.gospa.false_m2, one.gospa.false_m2);
    sum.scans += one.scans;
    sum.swaps += one.swaps;
    sum.breaks += one.breaks;
    sum.false_tracks += one.false_tracks;
}

impl Way {
    /// rms, 95 %, speed 90 %, GOSPA per root, reported %, false tracks, swaps.
    fn figures(&self) -> [Option<f64>; 7] {
        let errors = self.score.position_errors_m(true);
        let mut speeds: Vec<f64> =
            self.score.areas.iter().flat_map(|a| a.speed.iter().map(|s| s.0)).collect();
        speeds.sort_by(f64::total_cmp);
        let (hits, due) = self.score.areas.iter().fold((0, 0), |(h, d), a| {
            let (x, y) = a.reports_due(1.0);
            (h + x, d + y)
        });
        [
            self.score.rmse_m(),
            quantile(&errors, 0.95),
            quantile(&speeds, 0.9),
            Some(self.score.gospa.per_root_m),
            (due > 0).then(|| 100.0 * hits as f64 / due as f64),
            Some(self.score.false_tracks as f64),
            Some(self.score.swaps as f64),
        ]
    }
}

const FIGURES: [(&str, &str); 7] = [
    ("rmse_m", "position rms, m"),
    ("p95_m", "95 %, m"),
    ("speed_p90_ms", "speed 90 %, m/s"),
    ("gospa_per_root_m", "GOSPA, m"),
    ("reported_pct", "reported, %"),
    ("false_tracks", "false tracks"),
    ("swaps", "swaps"),
];

impl FitReport {
    /// What the step down costs and saves, in a sentence.
    #[must_use]
    pub fn closing(&self) -> String {
        let Some(online) = self.ways.first() else { return String::new() };
        let total = |w: &Way| w.sensors_us + w.tracking_us;
        let off = |w: &Way, nobody: &str, text: fn(f64) -> String| {
            w.score.rmse_m().map_or_else(|| nobody.to_owned(), text)
        };
        let mut text = format!(
            "On-line, a scan of {} costs {:.1} µs and {}",
            self.scene,
            total(online),
            off(online, "no track follows anybody", |m| format!("its tracks are {m:.2} m off"))
        );
        for way in &self.ways[1..] {
            let _ = write!(
                text,
                "; {} takes {:.1} µs ({:.0} times less) and gives {}",
                way.name,
                total(way),
                total(online) / total(way).max(1e-9),
                off(way, "no such track", |m| format!("{m:.2} m"))
            );
        }
        text + "."
    }

    /// Tables for a terminal.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut out = format!(
            "scene {} ({:016x}), fitted on seeds {:?}, compared on seeds {:?}\n\n",
            self.scene, self.scene_hash, self.fitted_on, self.compared_on
        );
        out.push_str("sensor                reports   mean m          sigma m         correlated    tau s  Pd %   outage  far %\n");
        for s in &self.sensors {
            match &s.figures {
                Ok(f) => {
                    let _ = writeln!(
                        out,
                        "{:20} {:8}  {:6.2} {:6.2}   {:6.2} {:6.2}   {:8.2}   {:8.1}  {:5.2}  {:5.1}  {:5.2}",
                        s.name,
                        f.samples,
                        f.axes[0].mean_m,
                        f.axes[1].mean_m,
                        f.axes[0].sigma_m,
                        f.axes[1].sigma_m,
                        f.correlated_share,
                        f.tau_s,
                        100.0 * f.pd,
                        f.outage_reports,
                        100.0 * f.far_share,
                    );
                }
                Err(reason) => {
                    let _ = writeln!(out, "{:20} {reason}", s.name);
                }
            }
        }
        out.push_str("(first axis: away from a radar, else north; second: across, else east)\n\n");
        match &self.tracker {
            Ok(figures) => {
                out.push_str("tracks of targets that are   reports   mean along, across m   sigma m          cross    rho\n");
                for (motion, f) in Motion::ALL.iter().zip(&figures.motions) {
                    let _ = writeln!(
                        out,
                        "{:28} {:7}   {:8.2} {:8.2}   {:8.2} {:8.2}   {:6.2} {:6.2}",
                        motion.name(),
                        f.samples,
                        f.mean[0],
                        f.mean[1],
                        f.sigma[0],
                        f.sigma[1],
                        f.cross,
                        f.rho
                    );
                }
                let _ = writeln!(
                    out,
                    "reported {}, gaps of {:.1} scans, first report after {:.1} scans\n",
                    percent(figures.reported),
                    figures.gap_scans,
                    figures.delay_scans
                );
            }
            Err(reason) => {
                let _ = writeln!(out, "no figures of the tracker: {reason}\n");
            }
        }
        let _ = write!(out, "{:36}", "");
        for (_, head) in FIGURES {
            let _ = write!(out, " {head:>16}");
        }
        out.push_str("   sensors µs   tracking µs\n");
        for way in &self.ways {
            let _ = write!(out, "{:36}", way.name);
            for value in way.figures() {
                let _ = write!(out, " {:>16}", value.map_or("-".into(), |v| format!("{v:.2}")));
            }
            let _ = writeln!(out, " {:12.1} {:13.1}", way.sensors_us, way.tracking_us);
        }
        let _ = writeln!(out, "\n{}", self.closing());
        out
    }

    /// The figures and the comparison as one JSON object.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let sensors: Vec<Value> = self
            .sensors
            .iter()
            .map(|s| match &s.figures {
                Ok(f) => json!({
                    "name": s.name, "kind": format!("{:?}", s.kind).to_lowercase(),
                    "mean_m": f.axes.map(|a| a.mean_m), "sigma_m": f.axes.map(|a| a.sigma_m),
                    "correlated_share": f.correlated_share, "tau_s": f.tau_s, "pd": f.pd,
                    "outage_reports": f.outage_reports, "period_s": f.period_s,
                    "far_share": f.far_share, "samples": f.samples,
                    "reach_m": Some(s.reach_m).filter(|r| r.is_finite()),
                }),
                Err(reason) => json!({ "name": s.name, "refused": reason }),
            })
            .collect();
        let tracker = match &self.tracker {
            Ok(f) => json!({
                "reported": f.reported, "gap_scans": f.gap_scans, "delay_scans": f.delay_scans,
                "motions": Motion::ALL.iter().zip(&f.motions).map(|(m, f)| json!({
                    "motion": m.name(), "mean": f.mean, "sigma": f.sigma, "cross": f.cross,
                    "rho": f.rho, "samples": f.samples,
                })).collect::<Vec<_>>(),
            }),
            Err(reason) => json!({ "refused": reason }),
        };
        let ways: Vec<Value> = self
            .ways
            .iter()
            .map(|w| {
                let mut object = serde_json::Map::new();
                object.insert("name".into(), json!(w.name));
                for (value, (key, _)) in w.figures().into_iter().zip(FIGURES) {
                    object.insert(key.into(), json!(value));
                }
                object.insert("sensors_us_per_scan".into(), json!(w.sensors_us));
                object.insert("tracking_us_per_scan".into(), json!(w.tracking_us));
                Value::Object(object)
            })
            .collect();
        json!({
            "scene": self.scene, "scene_hash": format!("{:016x}", self.scene_hash),
            "fitted_on": self.fitted_on, "compared_on": self.compared_on, "version": self.version,
            "sensors": sensors, "tracker": tracker, "comparison": ways, "closing": self.closing(),
        })
    }

    /// A page without anything from elsewhere.
    #[must_use]
    pub fn to_html(&self) -> String {
        format!(
            "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>Off-line figures</title>\
             <style>{STYLE}</style></head><body><h1>Off-line figures of scene {}</h1>\
             <p class=\"closing\">{}</p><pre>{}</pre></body></html>\n",
            chart::escaped(&self.scene),
            chart::escaped(&self.closing()),
            chart::escaped(&self.to_text()),
        )
    }
}

#[cfg(test)]
mod tests;
