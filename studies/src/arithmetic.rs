//! Two small ladders: from polar plots to Cartesian ones, and single against double precision.

use crate::filters::REQUIRED_95_M;
use crate::measure::{BLOCK, Errors, median_and_p99, timed};
use crate::scenes::{self, NoiseLevel, Scene};
use crate::{Ladder, Options, Outcome, Progress, Row, SceneAbout, clock};
use models::draw::{DrawKey, Purpose, normal_pair};
use models::filter::bulk::Bulk;
use models::filter::three_state::ThreeState;
use models::filter::{FilterConfig, Rung, Start, StateEstimator};
use models::frames::{Azimuth, Point2, Vector2};
use models::plot::{Plot, polar_to_cartesian};
use std::hint::black_box;

/// A way from range and azimuth to a position with variances along and across.
type Convert = fn(Azimuth, f64, f64, f64) -> (Vector2<f64>, f64, f64);

fn naive(azimuth: Azimuth, range: f64, sigma_range: f64, sigma: f64) -> (Vector2<f64>, f64, f64) {
    let across = range * sigma;
    (azimuth.unit() * range, sigma_range * sigma_range, across * across)
}

fn unbiased(
    azimuth: Azimuth,
    range: f64,
    sigma_range: f64,
    sigma: f64,
) -> (Vector2<f64>, f64, f64) {
    polar_to_cartesian(azimuth.unit(), range, sigma_range, sigma)
}

/// The unbiased conversion by the sums of the textbook, in single precision.
fn textbook_f32(azimuth: Azimuth, range: f64, sr: f64, sigma: f64) -> (Vector2<f64>, f64, f64) {
    let (r, sr, s) = (range as f32, sr as f32, (sigma * sigma) as f32);
    let (e1, m2) = (libm::expf(s), libm::expf(-2.0 * s));
    let along = r * r * (e1 - 1.5 + 0.5 * m2) + 0.5 * sr * sr * (1.0 + m2);
    let across = 0.5 * (r * r + sr * sr) * (1.0 - m2);
    let scale = libm::expf(0.5 * s) * r;
    (azimuth.unit() * f64::from(scale), f64::from(along), f64::from(across))
}

/// The ladder of polar conversions.
pub(crate) fn polar(options: &Options, progress: &mut dyn FnMut(Progress)) -> Outcome {
    let n = if options.quick { 40_000u64 } else { 400_000 };
    let blocks = if options.quick { 30 } else { 200 };
    let cases: [(&str, &str, f64, f64, f64); 3] = [
        ("asde", "1.5 km, 1.56 m, 0.072°", 1500.0, 1.56, 0.00126),
        ("approach", "60 km, 60 m, 1 mrad", 60_000.0, 60.0, 0.001),
        ("wide", "20 km, 30 m, 3°", 20_000.0, 30.0, 0.052_36),
    ];
    let rungs: [(&str, Convert); 3] =
        [("naive", naive), ("unbiased, f32 sums", textbook_f32), ("unbiased", unbiased)];
    let mut rows = Vec::new();
    for (scene, _, range_m, sigma_range_m, sigma_rad) in cases {
        for (rung, convert) in rungs {
            let (mut bias, mut nees, mut errors) = (Vector2::zeros(), 0.0, Errors::default());
            for k in 0..n {
                let key = DrawKey { run_seed: options.seed, sensor: 9, entity: 0, scan: k };
                let (a, b) = normal_pair(&mut key.rng(Purpose::Study));
                // One direction is enough: the conversion turns with the azimuth.
                let truth = Azimuth::from_rad(0.6);
                let seen = Azimuth::from_rad(0.6 + b * sigma_rad);
                let (z, along, across) =
                    convert(seen, range_m + a * sigma_range_m, sigma_range_m, sigma_rad);
                let error = z - truth.unit() * range_m;
                bias += error;
                errors.add(error.norm());
                let (u, v) = (seen.unit(), Vector2::new(seen.unit().y, -seen.unit().x));
                nees += error.dot(&u).powi(2) / along + error.dot(&v).powi(2) / across;
            }
            let (ns_per_update, ns_p99) = timed(blocks, |k| {
                let azimuth = Azimuth::from_rad(0.001 * k as f64);
                black_box(convert(azimuth, range_m, sigma_range_m, sigma_rad));
            });
            let bias_m = (bias / n as f64).norm();
            rows.push(Row {
                group: "polar".into(),
                scene: scene.into(),
                rung: rung.into(),
                rmse_m: errors.rms(),
                p95_m: errors.p95(),
                nees: Some(nees / n as f64),
                ns_per_update,
                ns_p99,
                error: Some(bias_m),
                error_unit: Some("m of mean error".into()),
                ..Row::default()
            });
        }
        progress(Progress {
            group: "polar",
            what: scene.into(),
            done: rows.len() / rungs.len(),
            total: cases.len(),
        });
    }
    let ladder = Ladder {
        group: "polar".into(),
        title: "From polar to Cartesian plots".into(),
        about: format!(
            "{n} plots with Gaussian errors of range and azimuth. The mean error is what no filter averages \
             away; NEES holds the error against the stated variances (2 is right). At the ranges of a surface \
             radar the bias is a millimetre: the correction is free, and not needed. The same sums in f32 \
             show why the stable form is used. Drawn is the root mean square of mean error and spread \
             together."
        ),
        error_label: "position error, m (rms)".into(),
        scenes: cases.iter().map(|c| SceneAbout { name: c.0.into(), about: c.1.into() }).collect(),
        ..Ladder::default()
    };
    Outcome { ladder, rows, ..Outcome::default() }
}

/// Updates of the same plots by one filter; positions after each scan.
fn doubles(plots: &[Vec<Plot>]) -> (Vec<Vec<Point2<f64>>>, Vec<f64>) {
    // The bare update, as the single form has it: nothing is taken as a manoeuvre.
    let q = FilterConfig::new(Rung::Ca3).q;
    let mut times = Vec::new();
    let mut filters: Vec<ThreeState> = plots
        .iter()
        .filter_map(|p| ThreeState::from_plot(&p[0], q, Start::default()).ok())
        .collect();
    let mut tracks = vec![Vec::new(); plots.len()];
    for k in 1..plots[0].len() {
        let begin = clock::thread_ns();
        for (filter, plots) in filters.iter_mut().zip(plots) {
            let _ = black_box(filter.update(&plots[k]));
        }
        times.push((clock::thread_ns() - begin) as f64 / plots.len() as f64);
        for (track, filter) in tracks.iter_mut().zip(&filters) {
            track.push(filter.estimate().position_m());
        }
    }
    (tracks, times)
}

fn singles(plots: &[Vec<Plot>]) -> (Vec<Vec<Point2<f64>>>, Vec<f64>) {
    let mut bulk = Bulk::new(FilterConfig::new(Rung::Ca3).q as f32, Start::default());
    let mut times = Vec::new();
    for p in plots {
        let _ = bulk.push(&p[0]);
    }
    let mut tracks = vec![Vec::new(); plots.len()];
    for k in 1..plots[0].len() {
        let scan: Vec<Option<Plot>> = plots.iter().map(|p| Some(p[k])).collect();
        let begin = clock::thread_ns();
        black_box(bulk.update(&scan));
        times.push((clock::thread_ns() - begin) as f64 / plots.len() as f64);
        for (number, track) in tracks.iter_mut().enumerate() {
            track.push(bulk.estimate(number).position_m());
        }
    }
    (tracks, times)
}

/// The ladder of precisions.
pub(crate) fn precision(options: &Options, progress: &mut dyn FnMut(Progress)) -> Outcome {
    let runs = if options.quick { BLOCK as u64 } else { 4 * BLOCK as u64 };
    let level = NoiseLevel::all()[0];
    let base = [Scene::landing(), Scene::landing_arc(), Scene::takeoff()];
    let corners = [("", Vector2::zeros()), (" at 10 km", Vector2::new(9000.0, -9000.0))];
    let mut rows = Vec::new();
    let mut about = Vec::new();
    let total = base.len() * corners.len();
    for scene in &base {
        for (where_, offset) in corners {
            let name = format!("{}{where_}", scene.name);
            about.push(SceneAbout { name: name.clone(), about: scene.about.into() });
            let plots: Vec<Vec<Plot>> = (0..runs)
                .map(|run| {
                    let mut plots = scenes::plots(scene, &level.noise, options.seed, run);
                    plots.iter_mut().for_each(|p| p.position_m += offset);
                    plots
                })
                .collect();
            let (reference, times) = doubles(&plots);
            let (single, single_times) = singles(&plots);
            for (rung, tracks, mut times) in
                [("ca3 f32, eight at once", &single, single_times), ("ca3 f64", &reference, times)]
            {
                let (mut errors, mut apart) = (Errors::default(), Errors::default());
                for (track, exact) in tracks.iter().zip(&reference) {
                    for (k, (a, b)) in track.iter().zip(exact).enumerate().skip(2) {
                        let truth = scene.at((k + 1) as f64).position_m + offset;
                        errors.add((a - truth).norm());
                        apart.add((a - b).norm());
                    }
                }
                let (ns_per_update, ns_p99) = median_and_p99(&mut times);
                let p95_m = errors.p95();
                rows.push(Row {
                    group: "precision".into(),
                    scene: name.clone(),
                    rung: rung.into(),
                    rmse_m: errors.rms(),
                    p95_m,
                    ns_per_update,
                    ns_p99,
                    error: apart.most(),
                    error_unit: Some("m at most from f64".into()),
                    required: p95_m.map(|p| p <= REQUIRED_95_M),
                    ..Row::default()
                });
            }
            progress(Progress { group: "precision", what: name, done: rows.len() / 2, total });
        }
    }
    let ladder = Ladder {
        group: "precision".into(),
        title: "Single against double precision".into(),
        about: format!(
            "{runs} tracks at once with the three-state filter, in double precision one by one and in single \
             precision eight at a time, near the reference point and 12.7 km from it. The single form keeps \
             whole metres apart from the remainder, so distance costs nothing."
        ),
        error_label: "position error, m (rms)".into(),
        scenes: about,
        ..Ladder::default()
    };
    Outcome { ladder, rows, ..Outcome::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Progress;

    fn quick() -> Options {
        Options { quick: true, seed: 5, ..Options::default() }
    }

    #[test]
    fn the_unbiased_form_has_no_bias_where_the_naive_one_has() {
        let outcome = polar(&quick(), &mut |_: Progress| ());
        let of = |scene: &str, rung: &str| {
            outcome.rows.iter().find(|r| r.scene == scene && r.rung == rung).expect("measured")
        };
        // d σ²/2 = 27 m at 20 km and 3°; the mean of 40 000 draws is good to 5 m.
        assert!((of("wide", "naive").error.expect("bias") - 27.4).abs() < 6.0);
        assert!(of("wide", "unbiased").error.expect("bias") < 12.0);
        assert!((of("asde", "unbiased").nees.expect("nees") - 2.0).abs() < 0.05);
    }

    #[test]
    fn single_precision_stays_within_a_millimetre() {
        let outcome = precision(&quick(), &mut |_: Progress| ());
        assert_eq!(outcome.rows.len(), 12);
        for row in &outcome.rows {
            assert!(row.error.expect("measured") < 2e-3, "{row:?}");
        }
    }
}
