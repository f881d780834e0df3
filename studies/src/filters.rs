//! The ladder of filters: one target, one radar, one plot a second.
//!
//! Every rung gets the same plots. Errors count from the third second on; tracks that end more than
//! 50 m off are lost, have their own column and are left out of the others.

use crate::bounds::{self, Bounds};
use crate::clock;
use crate::scenes::{Noise, NoiseLevel, Scene, plots};
use crate::{Bound, Ladder, Options, Outcome, Progress, Row, SceneAbout};
use models::filter::consistency::{mean_bounds_95, position_nees};
use models::filter::map::MapKnowledge;
use models::filter::modes::ca;
use models::filter::route::Network;
use models::filter::smoother::smooth;
use models::filter::{Estimate, Estimator, FilterConfig, Rung, Start, StateEstimator};
use models::plot::Plot;
use std::hint::black_box;
use std::sync::Arc;

/// Scans left out at the start of a track.
const ACQUISITION: usize = 3;
/// A track that ends farther off than this is lost, m.
const LOST_M: f64 = 50.0;
/// Updates in a timed block.
const BLOCK: usize = 1000;
/// Position error that 95 % of the reports of a surface movement radar must not exceed, m (EUROCAE ED-116).
pub const REQUIRED_95_M: f64 = 7.5;
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
    fn config(self, scene: &Scene) -> FilterConfig {
        let Self::Filter(rung) = self else { return FilterConfig::new(Rung::Ca6) };
        let mut config = FilterConfig::new(rung);
        if rung == Rung::Mh9Map {
            config.map = Some(Arc::new(MapKnowledge::of(Network::single(scene.route()))));
        }
        config
    }
    /// Estimates with the number of their scan.
    fn track(
        self,
        config: &FilterConfig,
        plots: &[Plot],
    ) -> Result<Vec<(usize, Estimate)>, String> {
        let said = |e: models::filter::UpdateError| e.to_string();
        if self == Self::Smoother {
            let states = smooth(plots, ca(SMOOTHER_Q), Start::default()).map_err(said)?;
            return Ok(states.into_iter().enumerate().collect());
        }
        let mut filter = Estimator::from_plot(config, &plots[0]).map_err(said)?;
        let lagging = self == Self::Filter(Rung::Mh9Lag1);
        let mut track = Vec::with_capacity(plots.len());
        for (k, plot) in plots.iter().enumerate().skip(1) {
            filter.update(plot).map_err(said)?;
            if !lagging {
                track.push((k, filter.estimate()));
            } else if let Some(before) = filter.lagged() {
                track.push((k - 1, before));
            }
        }
        Ok(track)
    }
}

/// Measures the ladder.
pub(crate) fn run(options: &Options, progress: &mut dyn FnMut(Progress)) -> Outcome {
    let (runs, blocks) = if options.quick { (200, 30) } else { (400, 120) };
    let noises = NoiseLevel::all();
    let levels = if options.quick { &noises[..1] } else { &noises[..] };
    let scenes = Scene::reported();
    let total = levels.len() * scenes.len() * Method::all().count();
    let (mut done, mut rows, mut lines, mut about) = (0, Vec::new(), Vec::new(), Vec::new());
    for level in levels {
        for scene in &scenes {
            let name = scene_name(scene, level);
            about.push(SceneAbout {
                name: name.clone(),
                about: format!("{}; radar {}", scene.about, level.about),
            });
            let draws: Vec<Vec<Plot>> =
                (0..runs).map(|run| plots(scene, &level.noise, options.seed, run)).collect();
            let reference = reference(scene, &draws);
            lines.extend(bound_lines(scene, level, &name, &draws));
            for method in Method::all() {
                let mut row = errors(method, scene, &name, &draws, &reference);
                let config = method.config(scene);
                (row.ns_per_update, row.ns_p99) = timed(method, &config, &draws, blocks);
                rows.push(row);
                done += 1;
                progress(Progress {
                    group: "filters",
                    what: format!("{name} {}", method.name()),
                    done,
                    total,
                });
            }
        }
    }
    let ladder = Ladder {
        group: "filters".to_owned(),
        title: "Filters: one target, one radar".to_owned(),
        about: format!(
            "Root mean square position error of one track, {runs} runs a scene with the same plots for \
             every rung, from the third second on. Time is one update of both axes with position and \
             covariance read out, as processor time of the thread. Modes, noise densities and transition \
             probabilities were chosen on the first three scenes and on three more that are not reported \
             (an exit, taxiing, a line-up), with other seeds; the queue and the other noise levels had no \
             part in it. On the map rung the target keeps exactly to its centreline."
        ),
        error_label: "position error, m (rms)".to_owned(),
        scenes: about,
    };
    Outcome { ladder, rows, bounds: lines, pictures: Vec::new() }
}

fn scene_name(scene: &Scene, level: &NoiseLevel) -> String {
    if level.name.is_empty() {
        scene.name.to_owned()
    } else {
        format!("{}/{}", scene.name, level.name)
    }
}

/// The smoother's states: the most exact rung, which the others are held against too.
fn reference(scene: &Scene, draws: &[Vec<Plot>]) -> Vec<Vec<Estimate>> {
    let config = Method::Smoother.config(scene);
    let tracks =
        draws.iter().map(|plots| Method::Smoother.track(&config, plots).unwrap_or_default());
    tracks.map(|track| track.into_iter().map(|(_, e)| e).collect()).collect()
}

/// Everything but the times.
fn errors(
    method: Method,
    scene: &Scene,
    scene_name: &str,
    draws: &[Vec<Plot>],
    reference: &[Vec<Estimate>],
) -> Row {
    let config = method.config(scene);
    let truth: Vec<_> = (0..scene.samples).map(|k| scene.at(k as f64).position_m).collect();
    let mut row = Row {
        group: "filters".to_owned(),
        scene: scene_name.to_owned(),
        rung: method.name().to_owned(),
        needs: method.needs().map(str::to_owned),
        ..Row::default()
    };
    let (mut lost, mut radii, mut to_reference) = (0usize, Vec::new(), (0.0, 0usize));
    let mut ratio = Vec::new();
    let (mut raw_sum, mut sum) = (0.0, 0.0);
    let mut nees = vec![(0.0, 0usize); scene.samples];
    for (plots, reference) in draws.iter().zip(reference) {
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
        let (mut raw, mut own) = (0.0, 0.0);
        for (k, estimate) in track.iter().filter(|(k, _)| *k >= ACQUISITION) {
            let error = (estimate.position_m() - truth[*k]).norm_squared();
            own += error;
            raw += (plots[*k].position_m - truth[*k]).norm_squared();
            radii.push(error.sqrt());
            nees[*k].0 += position_nees(estimate, truth[*k]);
            nees[*k].1 += 1;
            if let Some(reference) = reference.get(*k) {
                to_reference.0 += (estimate.position_m() - reference.position_m()).norm_squared();
                to_reference.1 += 1;
            }
        }
        raw_sum += raw;
        sum += own;
        ratio.push((own, raw));
    }
    row.lost_pct = Some(100.0 * lost as f64 / draws.len() as f64);
    if radii.is_empty() {
        return row;
    }
    let reduction = 100.0 * (1.0 - sum / raw_sum);
    row.mse_reduction_pct = Some(reduction);
    row.reduction_se_pct = Some(standard_error(&ratio, sum / raw_sum));
    row.rmse_m = Some((sum / radii.len() as f64).sqrt());
    row.p95_m = Some(quantile(&mut radii, 0.95));
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

/// The value below which a share `p` lies (nearest rank).
fn quantile(values: &mut [f64], p: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let rank = (p * values.len() as f64).ceil() as usize;
    values[rank.clamp(1, values.len()) - 1]
}

/// Median and 99 % quantile of the time per update over blocks of 1000, ns.
fn timed(
    method: Method,
    config: &FilterConfig,
    draws: &[Vec<Plot>],
    blocks: usize,
) -> (Option<f64>, Option<f64>) {
    let mut times = Vec::with_capacity(blocks);
    let mut next = draws.iter().cycle();
    // The first two blocks warm caches and branch predictors.
    for block in 0..blocks + 2 {
        let mut chosen: Vec<&Vec<Plot>> = Vec::new();
        let mut updates = 0;
        while updates < BLOCK {
            let Some(plots) = next.next() else { return (None, None) };
            updates += plots.len() - 1;
            chosen.push(plots);
        }
        let started: Result<Vec<_>, _> =
            chosen.iter().map(|plots| Estimator::from_plot(config, &plots[0])).collect();
        let Ok(mut started) = started else { return (None, None) };
        let mut left = BLOCK;
        let mut counted = 0;
        let begin = clock::thread_ns();
        for (filter, plots) in started.iter_mut().zip(&chosen) {
            let take = (plots.len() - 1).min(left);
            left -= take;
            counted += take;
            if method == Method::Smoother {
                let _ = black_box(smooth(&plots[..=take], ca(SMOOTHER_Q), Start::default()));
                continue;
            }
            for plot in &plots[1..=take] {
                let _ = black_box(filter.update(plot));
                let estimate = filter.estimate();
                black_box((estimate.position_m(), estimate.position_cov_m2()));
            }
        }
        let ns = (clock::thread_ns() - begin) as f64 / counted as f64;
        if block >= 2 {
            times.push(ns);
        }
    }
    let median = quantile(&mut times, 0.5);
    (Some(median), Some(quantile(&mut times, 0.99)))
}

/// The lines that no filter with the same knowledge can pass, from the same scans.
fn bound_lines(scene: &Scene, level: &NoiseLevel, name: &str, draws: &[Vec<Plot>]) -> Vec<Bound> {
    let truth: Vec<_> = (0..scene.samples).map(|k| scene.at(k as f64).position_m).collect();
    let (mut sum, mut n) = (0.0, 0usize);
    for plots in draws {
        for (plot, truth) in plots.iter().zip(&truth).skip(ACQUISITION) {
            sum += (plot.position_m - truth).norm_squared();
            n += 1;
        }
    }
    let raw = sum / n as f64;
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
    for scene in Scene::reported() {
        let noise: Noise = level.noise;
        let draws: Vec<Vec<Plot>> = (0..runs).map(|run| plots(&scene, &noise, seed, run)).collect();
        let reference = reference(&scene, &draws);
        for method in Method::all() {
            let row = errors(method, &scene, scene.name, &draws, &reference);
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

    #[test]
    fn every_step_up_is_better_on_the_scene_it_is_for() {
        let level = NoiseLevel::all()[0];
        let scene = Scene::landing_arc();
        let draws: Vec<Vec<Plot>> =
            (0..60).map(|run| plots(&scene, &level.noise, 77, run)).collect();
        let reference = reference(&scene, &draws);
        let mse = |rung| {
            let row = errors(Method::Filter(rung), &scene, "arc", &draws, &reference);
            assert_eq!(row.lost_pct, Some(0.0));
            row.mse_reduction_pct.unwrap()
        };
        let ladder = [Rung::Ca3, Rung::Imm3, Rung::Mh27, Rung::Mh9Lag1, Rung::Mh9Map].map(mse);
        assert!(ladder.windows(2).all(|w| w[0] < w[1]), "{ladder:?}");
        assert!(ladder[0] > 25.0 && ladder[2] > 42.0 && ladder[3] > 68.0, "{ladder:?}");
    }
}
