//! The ladder of filters: one target, one radar, one plot a second.
//!
//! Every rung gets the same plots. Errors count from the third second on; tracks that end more than
//! 50 m off are lost, have their own column and are left out of the others.

use crate::bounds::{self, Bounds};
use crate::measure::{BLOCK, median_and_p99, quantile};
use crate::scenes::{self, Noise, NoiseLevel, Scene};
use crate::{Bound, Ladder, Options, Outcome, Progress, Row, SceneAbout, clock, unseen, zurich};
use models::filter::consistency::{mean_bounds_95, position_nees};
use models::filter::map::MapKnowledge;
use models::filter::modes::ca;
use models::filter::route::Network;
use models::filter::smoother::smooth;
use models::filter::{Estimate, Estimator, FilterConfig, Rung, Start, StateEstimator};
use models::frames::{Point2, Vector2};
use models::plot::Plot;
use models::time::SimTime;
use std::hint::black_box;
use std::sync::Arc;

/// Scans left out at the start of a track.
const ACQUISITION: usize = 3;
/// A track that ends farther off than this is lost, m.
const LOST_M: f64 = 50.0;
/// Scans without a plot in the scene `outage`: first and last.
const OUTAGE: (usize, usize) = (26, 33);
/// Seconds of each stretch of the recorded movements.
const STRETCH: usize = 60;
/// Position error that 95 % of the reports of a surface movement radar must not exceed, m (EUROCAE ED-116).
pub const REQUIRED_95_M: f64 = 7.5;
/// Scenes that modes and densities were chosen on, at the headline noise.
const CHOSEN_ON: [&str; 3] = ["landing", "landing_arc", "takeoff"];
/// A coast goes on at constant velocity after so many seconds, with this density of the acceleration, m²/s³: as the tracker's.
const COAST_S: usize = 2;
const COAST_Q: f64 = 1.0;
/// Jerk density of the off-line smoother, m²/s⁵.
const SMOOTHER_Q: f64 = 1.0;

/// A filter of the ladder, or the smoother.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Method {
    Filter(Rung),
    Smoother,
}

impl Method {
    fn all() -> impl Iterator<Item = Self> {
        Rung::ALL.iter().map(|(rung, _)| Self::Filter(*rung)).chain([Self::Smoother])
    }
    fn name(self) -> &'static str {
        match self {
            Self::Filter(rung) => rung.name(),
            Self::Smoother => "rts",
        }
    }
    fn needs(self) -> Option<&'static str> {
        match self {
            Self::Filter(Rung::Mh9Lag1) => Some("one second more"),
            Self::Filter(Rung::Mh9Map) => Some("a map"),
            Self::Smoother => Some("all plots"),
            Self::Filter(_) => None,
        }
    }
    fn config(self, subject: &Subject) -> FilterConfig {
        let Self::Filter(rung) = self else { return FilterConfig::new(Rung::Ca6) };
        let mut config = FilterConfig::new(rung);
        if rung == Rung::Mh9Map {
            config.map.clone_from(&subject.map);
        }
        config
    }
    /// Estimates with the number of their scan; scans without a plot are predicted, where a filter can.
    fn track(
        self,
        config: &FilterConfig,
        plots: &[Plot],
    ) -> Result<Vec<(usize, Estimate)>, String> {
        let said = |e: models::filter::UpdateError| e.to_string();
        if self == Self::Smoother {
            let states = smooth(plots, ca(SMOOTHER_Q), Start::default()).map_err(said)?;
            return Ok(states.into_iter().zip(plots).map(|(e, p)| (scan_of(p), e)).collect());
        }
        let mut filter = Estimator::from_plot(config, &plots[0]).map_err(said)?;
        let lagging = self == Self::Filter(Rung::Mh9Lag1);
        let mut track = Vec::with_capacity(plots.len());
        let mut before = scan_of(&plots[0]);
        for plot in &plots[1..] {
            let now = scan_of(plot);
            let coasts = now > before + COAST_S && self != Self::Filter(Rung::Mh9Map);
            let coast = |filter: &Estimator, k: usize| {
                let at = SimTime(k as i64 * SECOND_NS);
                if !coasts || k <= before + COAST_S {
                    return filter.predicted(at);
                }
                let last = SimTime((before + COAST_S) as i64 * SECOND_NS);
                filter.predicted(last)?.coasted(at, COAST_Q)
            };
            for k in before + 1..now {
                track.push((k, coast(&filter, k).map_err(said)?));
            }
            if coasts {
                let carried = coast(&filter, now).map_err(said)?;
                filter.replace(carried.time, &carried.state);
            }
            filter.update(plot).map_err(said)?;
            if !lagging {
                track.push((now, filter.estimate()));
            } else if let Some(late) = filter.lagged() {
                track.push((before, late));
            }
            before = now;
        }
        Ok(track)
    }
}

const SECOND_NS: i64 = 1_000_000_000;

/// Number of the scan of a plot: one a second.
fn scan_of(plot: &Plot) -> usize {
    (plot.time.0 / SECOND_NS) as usize
}

/// What is tracked: the same plots for every rung, and the truth.
struct Subject {
    name: String,
    about: String,
    /// Truth second by second; run k has path k modulo their number.
    paths: Vec<Vec<Point2<f64>>>,
    draws: Vec<Vec<Plot>>,
    /// Plots that nobody is given, run by run: what a coast is held against.
    hidden: Vec<Vec<Plot>>,
    map: Option<Arc<MapKnowledge>>,
    bounds: Vec<Bound>,
}

impl Subject {
    /// A scene of straight lines and arcs at one noise level.
    fn of(scene: &Scene, level: &NoiseLevel, seed: u64, runs: u64) -> Self {
        let name = scene_name(scene, level);
        let truth = (0..scene.samples).map(|k| scene.at(k as f64).position_m).collect();
        let draws: Vec<Vec<Plot>> =
            (0..runs).map(|run| scenes::plots(scene, &level.noise, seed, run)).collect();
        Self {
            about: format!("{}; radar {}", scene.about, level.about),
            paths: vec![truth],
            bounds: bound_lines(scene, level, &name, &draws),
            hidden: vec![Vec::new(); draws.len()],
            draws,
            map: Some(Arc::new(MapKnowledge::of(Network::single(scene.route())))),
            name,
        }
    }

    /// A taxi movement through a turn of which eight seconds are not seen.
    fn outage(level: &NoiseLevel, seed: u64, runs: u64) -> Self {
        let scene = Scene::outage();
        let mut subject = Self::of(&scene, level, seed, runs);
        let seen = |plot: &Plot| !(OUTAGE.0..=OUTAGE.1).contains(&scan_of(plot));
        for (plots, hidden) in subject.draws.iter_mut().zip(&mut subject.hidden) {
            hidden.extend(plots.iter().copied().filter(|plot| !seen(plot)));
            plots.retain(seen);
        }
        // The bounds are of a scene that is seen throughout.
        subject.bounds.retain(|b| b.label == "raw plots");
        subject
    }

    /// Stretches of the recorded movements at Zurich, each once a turn, seen from the tower.
    fn zurich(level: &NoiseLevel, seed: u64, runs: u64) -> Result<Self, String> {
        let scene = zurich::scene().map_err(|e| e.to_string())?;
        let site = scene.sensors.iter().find_map(|s| s.asde.as_ref().and(s.site_m));
        let noise = match (level.noise, site) {
            (Noise::Radar { range_m, azimuth_rad, .. }, Some(site)) => {
                Noise::Radar { range_m, azimuth_rad, radar_m: site.xy() }
            }
            (noise, _) => noise,
        };
        let paths: Vec<_> =
            zurich::stretches(&scene, STRETCH).into_iter().map(|(_, path)| path).collect();
        if paths.is_empty() {
            return Err("no recorded movement at Zurich".to_owned());
        }
        let draws: Vec<Vec<Plot>> = (0..runs)
            .map(|run| scenes::plots_along(&paths[run as usize % paths.len()], &noise, seed, run))
            .collect();
        let name = "zurich".to_owned();
        let raw = raw_mse(&draws, &paths);
        let bounds = vec![Bound {
            group: "filters".to_owned(),
            scene: name.clone(),
            label: "raw plots".to_owned(),
            error: raw.sqrt(),
            mse_reduction_pct: Some(0.0),
        }];
        let about = format!(
            "{} stretches of a minute of recorded aircraft and driven vehicles at Zurich, radar on the tower",
            paths.len()
        );
        let network = Network::of_airport(&scene.airport.layout);
        Ok(Self {
            name,
            about,
            paths,
            hidden: vec![Vec::new(); draws.len()],
            draws,
            map: Some(Arc::new(MapKnowledge::of(network))),
            bounds,
        })
    }

    fn rename(&mut self, name: String) {
        self.bounds.iter_mut().for_each(|b| b.scene.clone_from(&name));
        self.name = name;
    }

    /// The methods that it can be tracked with.
    fn methods(&self) -> impl Iterator<Item = Method> {
        let mapped = self.map.is_some();
        Method::all().filter(move |m| mapped || *m != Method::Filter(Rung::Mh9Map))
    }
}

/// Mean squared error of the plots from the third second on, m².
fn raw_mse(draws: &[Vec<Plot>], paths: &[Vec<Point2<f64>>]) -> f64 {
    let (mut sum, mut n) = (0.0, 0usize);
    for (run, plots) in draws.iter().enumerate() {
        for plot in plots.iter().filter(|p| scan_of(p) >= ACQUISITION) {
            sum += (plot.position_m - paths[run % paths.len()][scan_of(plot)]).norm_squared();
            n += 1;
        }
    }
    sum / n.max(1) as f64
}

/// Measures the ladder.
pub(crate) fn run(options: &Options, progress: &mut dyn FnMut(Progress)) -> Outcome {
    let (runs, blocks) = if options.quick { (200, 30) } else { (400, 120) };
    let noises = NoiseLevel::all();
    let levels = if options.quick { &noises[..1] } else { &noises[..] };
    let scenes = Scene::reported();
    let mut subjects: Vec<Result<Subject, String>> = Vec::new();
    for level in levels {
        let of = |scene| Ok(Subject::of(scene, level, options.seed, runs));
        subjects.extend(scenes.iter().map(of));
        if level.name.is_empty() {
            subjects.push(Ok(Subject::outage(level, options.seed, runs)));
            subjects.push(Subject::zurich(level, options.seed, runs));
        }
    }
    let unseen = options.unseen.unwrap_or(if options.quick { 2 } else { 8 });
    for (n, mut scene) in unseen::generated(options.seed, unseen).into_iter().enumerate() {
        let (noise_name, noise) = unseen::noises()[n % 5];
        scene.name = "unseen";
        let level = NoiseLevel { name: "", about: noise_name, noise };
        let mut subject = Subject::of(&scene, &level, options.seed, runs);
        subject.rename(format!("unseen {}", n + 1));
        subject.about =
            format!("drawn from the seed, nobody chose anything on it; radar {noise_name}");
        subjects.push(Ok(subject));
    }
    let total = subjects.len() * Method::all().count();
    let (mut done, mut rows, mut lines, mut about) = (0, Vec::new(), Vec::new(), Vec::new());
    for subject in subjects {
        let subject = match subject {
            Ok(subject) => subject,
            Err(reason) => {
                let (group, scene) = ("filters".to_owned(), "zurich".to_owned());
                rows.push(Row { group, scene, failed: vec![reason], ..Row::default() });
                continue;
            }
        };
        about.push(SceneAbout { name: subject.name.clone(), about: subject.about.clone() });
        lines.extend(subject.bounds.iter().cloned());
        let reference = reference(&subject);
        for method in subject.methods() {
            let mut row = errors(method, &subject, &reference);
            (row.ns_per_update, row.ns_p99) =
                timed(method, &method.config(&subject), &subject.draws, blocks);
            rows.push(row);
            done += 1;
            let what = format!("{} {}", subject.name, method.name());
            progress(Progress { group: "filters", what, done, total });
        }
    }
    let ladder = Ladder {
        group: "filters".to_owned(),
        title: "Filters: one target, one radar".to_owned(),
        about: format!(
            "Root mean square position error of one track, {runs} runs a scene with the same plots for \
             every rung, from the third second on. Time is one update of both axes with the position \
             read out, as processor time of the thread, tracks side by side as in a tracker. Modes, noise densities and transition \
             probabilities were chosen on the first three scenes and on three more that are not reported \
             (an exit, taxiing, a line-up), with other seeds; the queue, the outage, the recorded movements and the \
             other noise levels had no part in it. On the map rung the target keeps exactly to its centreline; \
             the recorded movements keep to the airport's published taxiways, which is all that the rung knows of \
             them, as aircraft do. In the outage the errors of the \
             predictions count too, and the plots that were kept from the filters are what they are held against; \
             after two seconds all coast at constant velocity, as in the tracker, but for the map rung. Rungs: abg, fixed gains; ca3, a Kalman filter for one axis at a time; ca6, for both \
             together; -ud, the same with a factored covariance; imm3, three kinds of motion weighted; mh3 to mh27, so many \
             histories of motion kept; -lag1, told a second later; -map, with the taxiways known; rts, smoothed over all plots."
        ),
        error_label: "position error, m (rms)".to_owned(),
        held_out: about
            .iter()
            .map(|s| s.name.clone())
            .filter(|s| !CHOSEN_ON.contains(&s.as_str()))
            .collect(),
        scenes: about,
        ..Ladder::default()
    };
    Outcome { ladder, rows, bounds: lines, ..Outcome::default() }
}

fn scene_name(scene: &Scene, level: &NoiseLevel) -> String {
    if level.name.is_empty() {
        scene.name.to_owned()
    } else {
        format!("{}/{}", scene.name, level.name)
    }
}

/// The smoother's states scan by scan: the most exact rung, which the others are held against too.
fn reference(subject: &Subject) -> Vec<Vec<Option<Estimate>>> {
    let config = Method::Smoother.config(subject);
    let scans = subject.paths.iter().map(Vec::len).max().unwrap_or(0);
    let of = |plots: &Vec<Plot>| {
        let mut states = vec![None; scans];
        for (k, state) in Method::Smoother.track(&config, plots).unwrap_or_default() {
            states[k] = Some(state);
        }
        states
    };
    subject.draws.iter().map(of).collect()
}

/// Everything but the times.
fn errors(method: Method, subject: &Subject, reference: &[Vec<Option<Estimate>>]) -> Row {
    let config = method.config(subject);
    let mut row = Row {
        group: "filters".to_owned(),
        scene: subject.name.clone(),
        rung: method.name().to_owned(),
        needs: method.needs().map(str::to_owned),
        ..Row::default()
    };
    let (mut lost, mut radii, mut to_reference) = (0usize, Vec::new(), (0.0, 0usize));
    let mut ratio = Vec::new();
    let (mut raw_sum, mut sum) = (0.0, 0.0);
    let mut nees = vec![(0.0, 0usize); subject.paths.iter().map(Vec::len).max().unwrap_or(0)];
    for (run, (plots, reference)) in subject.draws.iter().zip(reference).enumerate() {
        let hidden = &subject.hidden[run];
        let truth = &subject.paths[run % subject.paths.len()];
        let track = match method.track(&config, plots) {
            Ok(track) => track,
            Err(reason) => {
                lost += 1;
                if !row.failed.contains(&reason) {
                    row.failed.push(reason);
                }
                continue;
            }
        };
        let last = track.last().map_or(f64::INFINITY, |(k, e)| (e.position_m() - truth[*k]).norm());
        if last.is_nan() || last > LOST_M {
            lost += 1;
            continue;
        }
        let mut plot_of = vec![None; truth.len()];
        // A coast is held against the plots that were kept from the filter: else the rung that coasts worst, and so has the
        // widest gate for what comes after, stands best.
        plots.iter().chain(hidden).for_each(|p| plot_of[scan_of(p)] = Some(p));
        let (mut raw, mut own) = (0.0, 0.0);
        for (k, estimate) in track.iter().filter(|(k, _)| *k >= ACQUISITION) {
            let error = (estimate.position_m() - truth[*k]).norm_squared();
            radii.push(error.sqrt());
            if let Some(plot) = plot_of[*k] {
                own += error;
                raw += (plot.position_m - truth[*k]).norm_squared();
            }
            nees[*k].0 += position_nees(estimate, truth[*k]);
            nees[*k].1 += 1;
            if let Some(reference) = &reference[*k] {
                to_reference.0 += (estimate.position_m() - reference.position_m()).norm_squared();
                to_reference.1 += 1;
            }
        }
        raw_sum += raw;
        sum += own;
        ratio.push((own, raw));
    }
    row.lost_pct = Some(100.0 * lost as f64 / subject.draws.len() as f64);
    if radii.is_empty() {
        return row;
    }
    let reduction = 100.0 * (1.0 - sum / raw_sum);
    row.mse_reduction_pct = Some(reduction);
    row.reduction_se_pct = Some(standard_error(&ratio, sum / raw_sum));
    let squares: f64 = radii.iter().map(|r| r * r).sum();
    row.rmse_m = Some((squares / radii.len() as f64).sqrt());
    row.p95_m = quantile(&mut radii, 0.95);
    row.error = Some((to_reference.0 / to_reference.1.max(1) as f64).sqrt());
    row.error_unit = Some("m from rts".to_owned());
    let counted: Vec<_> = nees.iter().filter(|(_, n)| *n > 0).collect();
    let all: (f64, usize) = counted.iter().fold((0.0, 0), |s, x| (s.0 + x.0, s.1 + x.1));
    row.nees = Some(all.0 / all.1 as f64);
    let within = counted.iter().filter(|(sum, n)| {
        let (low, high) = mean_bounds_95(*n, 2);
        (low..=high).contains(&(sum / *n as f64))
    });
    row.nees_in_bounds_pct = Some(100.0 * within.count() as f64 / counted.len() as f64);
    row.required = Some(row.p95_m.is_some_and(|p| p <= REQUIRED_95_M));
    row
}

/// Standard error of 100·(1 − Σa/Σb) from its runs (ratio estimator).
fn standard_error(ratio: &[(f64, f64)], mean: f64) -> f64 {
    let n = ratio.len() as f64;
    let b: f64 = ratio.iter().map(|r| r.1).sum::<f64>() / n;
    let residual: f64 = ratio.iter().map(|r| (r.0 - mean * r.1) * (r.0 - mean * r.1)).sum();
    100.0 * (residual / (n * (n - 1.0).max(1.0))).sqrt() / b
}

/// Median and 99 % quantile of the time per update over blocks of 1000, ns. A block is scan after scan of
/// a few tracks side by side, as a tracker sees them.
fn timed(
    method: Method,
    config: &FilterConfig,
    draws: &[Vec<Plot>],
    blocks: usize,
) -> (Option<f64>, Option<f64>) {
    let scans = draws.iter().map(Vec::len).min().unwrap_or(0);
    if scans < 2 {
        return (None, None);
    }
    let tracks = &draws[..BLOCK.div_ceil(scans - 1).min(draws.len())];
    let started: Result<Vec<_>, _> =
        tracks.iter().map(|plots| Estimator::from_plot(config, &plots[0])).collect();
    let Ok(started) = started else { return (None, None) };
    // Scan after scan, as a tracker is given them.
    let by_scan: Vec<Plot> =
        (1..scans).flat_map(|scan| tracks.iter().map(move |plots| plots[scan])).collect();
    if method == Method::Smoother {
        return blocks_of(blocks, by_scan.len(), &(), |_| {
            for plots in tracks {
                let _ = black_box(smooth(plots, ca(SMOOTHER_Q), Start::default()));
            }
        });
    }
    // Each filter as the type that it is: which one it is, is asked once.
    macro_rules! as_it_is {
        ($($variant:ident)*) => {
            match started.first() {
                $(Some(Estimator::$variant(_)) => {
                    let own = |filter| match filter {
                        Estimator::$variant(filter) => Some(filter),
                        _ => None,
                    };
                    let filters: Vec<_> = started.into_iter().filter_map(own).collect();
                    blocks_of(blocks, by_scan.len(), &filters, |filters| {
                        for plots in by_scan.chunks_exact(filters.len()) {
                            let (mut taken, mut sum) = (0, Vector2::zeros());
                            for (filter, plot) in filters.iter_mut().zip(plots) {
                                taken += u32::from(filter.take(plot).is_ok());
                                sum += filter.motion().0.coords;
                            }
                            black_box((taken, sum));
                        }
                    })
                })*
                None => (None, None),
            }
        };
    }
    as_it_is!(SteadyGain ThreeState TwoState ThreeStateUd SixState SixStateUd Imm3 Histories3 Histories9
        Histories27 Histories9Lag Map9 Events9 Events27 Pair Own)
}

/// Median and 99 % quantile of the time of one of `updates` that a block does with its own copy of `started`, ns. The
/// first two blocks warm caches and branch predictors.
fn blocks_of<T: Clone>(
    blocks: usize,
    updates: usize,
    started: &T,
    mut block: impl FnMut(&mut T),
) -> (Option<f64>, Option<f64>) {
    let mut times = Vec::with_capacity(blocks);
    for k in 0..blocks + 2 {
        let mut copy = started.clone();
        let begin = clock::thread_ns();
        block(&mut copy);
        if k >= 2 {
            times.push((clock::thread_ns() - begin) as f64 / updates as f64);
        }
    }
    median_and_p99(&mut times)
}

/// The lines that no filter with the same knowledge can pass, from the same scans.
fn bound_lines(scene: &Scene, level: &NoiseLevel, name: &str, draws: &[Vec<Plot>]) -> Vec<Bound> {
    let truth: Vec<_> = (0..scene.samples).map(|k| scene.at(k as f64).position_m).collect();
    let raw = raw_mse(draws, &[truth]);
    let Bounds { switches, legs, legs_lag, map, smoother } =
        bounds::of(scene, &level.noise, ACQUISITION);
    let line = |label: &str, mse: f64| Bound {
        group: "filters".to_owned(),
        scene: name.to_owned(),
        label: label.to_owned(),
        error: mse.sqrt(),
        mse_reduction_pct: Some(100.0 * (1.0 - mse / raw)),
    };
    vec![
        line("raw plots", raw),
        line("bound: switch times told", switches),
        line("bound: + which legs are steady", legs),
        line("bound: + one second of lag", legs_lag),
        line("bound: centreline, switch times, steady legs told", map),
        line("bound: all plots, switch times told", smoother),
    ]
}

/// Error columns of the headline scenes, for a snapshot: `runs` runs of every rung.
#[must_use]
pub fn error_table(seed: u64, runs: u64) -> String {
    let level: NoiseLevel = NoiseLevel::all()[0];
    let mut out = String::from("scene rung reduction_pct rmse_m p95_m nees lost_pct\n");
    let mut subjects: Vec<Subject> =
        Scene::reported().iter().map(|scene| Subject::of(scene, &level, seed, runs)).collect();
    subjects.push(Subject::outage(&level, seed, runs));
    subjects.extend(Subject::zurich(&level, seed, runs));
    for subject in &subjects {
        let reference = reference(subject);
        for method in subject.methods() {
            let row = errors(method, subject, &reference);
            let number = |v: Option<f64>| v.map_or_else(|| "-".to_owned(), |v| format!("{v:.1}"));
            out += &format!(
                "{} {} {} {} {} {} {}\n",
                row.scene,
                row.rung,
                row.mse_reduction_pct.map_or_else(|| "-".to_owned(), |v| format!("{v:.0}")),
                number(row.rmse_m),
                number(row.p95_m),
                number(row.nees),
                number(row.lost_pct),
            );
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_columns_are_those_of_the_snapshot() {
        insta::assert_snapshot!(error_table(3, 40));
    }

    /// The reduction counted plots only, and so praised the rung that coasts worst: it takes the first plot after the gap
    /// nearly whole.
    #[test]
    fn in_the_outage_the_order_is_that_of_the_errors_coasts_included() {
        let level = NoiseLevel::all()[0];
        let subject = Subject::outage(&level, 41, 40);
        let reference = reference(&subject);
        let rungs = [Rung::Abg, Rung::Ca3, Rung::Imm3, Rung::Mh9, Rung::Mh27, Rung::Pair];
        let mut rows = rungs.map(|rung| errors(Method::Filter(rung), &subject, &reference));
        rows.sort_by(|a, b| a.rmse_m.unwrap().total_cmp(&b.rmse_m.unwrap()));
        for row in &rows {
            println!("{} {:?} m {:?} %", row.rung, row.rmse_m, row.mse_reduction_pct);
        }
        let of = |row: &Row| row.mse_reduction_pct.unwrap();
        assert!(rows.windows(2).all(|w| of(&w[0]) >= of(&w[1])), "one order by both columns");
        assert!(of(&rows[5]) < 0.0, "eight seconds in a turn without a plot are no gain");
    }

    #[test]
    fn every_step_up_is_better_on_the_scene_it_is_for() {
        let level = NoiseLevel::all()[0];
        let subject = Subject::of(&Scene::landing_arc(), &level, 77, 60);
        let reference = reference(&subject);
        let mse = |rung| {
            let row = errors(Method::Filter(rung), &subject, &reference);
            assert_eq!(row.lost_pct, Some(0.0));
            row.mse_reduction_pct.unwrap()
        };
        let ladder = [Rung::Ca3, Rung::Imm3, Rung::Mh27, Rung::Mh9Lag1, Rung::Mh9Map].map(mse);
        assert!(ladder.windows(2).all(|w| w[0] < w[1]), "{ladder:?}");
        assert!(ladder[0] > 25.0 && ladder[2] > 42.0 && ladder[3] > 68.0, "{ladder:?}");
    }
}
