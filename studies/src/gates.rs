//! The ladder of gates: covariance gate, reachable-set gate, restart; tracks lost and time.
//!
//! The whole tracker follows one target; the filter is a tight one on purpose (q = 0.1), so that
//! the gates have something to do. No second track is made: what is lost stays lost.

use crate::measure::{Errors, median_and_p99, round_plot};
use crate::scenes::{self, NoiseLevel, Scene};
use crate::{Ladder, Options, Outcome, Progress, Row, SceneAbout, clock};
use models::draw::{DrawKey, Purpose, uniform};
use models::flight_list::FlightList;
use models::frames::Vector2;
use models::fusion::config::{AssociationMethod, Gates, SensorModel};
use models::fusion::{Tracker, TrackingConfig};
use models::plot::{SensorId, SensorKind};
use models::time::SimTime;

/// Jerk density of the filter, m²/s⁵.
const Q: f64 = 0.1;
/// A track that ends farther off than this is lost, m.
const LOST_M: f64 = 50.0;
/// Scans left out at the start of a track.
const ACQUISITION: usize = 4;

/// Probability of the covariance gate, reachable-set gate, restart.
const RUNGS: [(&str, f64, bool, bool); 5] = [
    ("covariance 99 %", 0.99, false, false),
    ("covariance 99.9 %", 0.999, false, false),
    ("covariance 99.99 %", 0.9999, false, false),
    ("+ reachable set", 0.999, true, false),
    ("+ restart", 0.999, true, true),
];

/// A scene with false plots in 200 × 200 m about the target.
struct Case {
    name: &'static str,
    about: &'static str,
    scene: Scene,
    false_plots: u32,
}

fn cases() -> Vec<Case> {
    let case = |scene: Scene, name, about, false_plots| Case { name, about, scene, false_plots };
    let (landing, arc, takeoff) = (Scene::landing(), Scene::landing_arc(), Scene::takeoff());
    vec![
        case(landing.clone(), "landing", landing.about, 0),
        case(arc.clone(), "landing_arc", arc.about, 0),
        case(takeoff.clone(), "takeoff", takeoff.about, 0),
        case(
            arc,
            "landing_arc_clutter",
            "the arc with 8 false plots a second in 200 × 200 m about the target",
            8,
        ),
    ]
}

fn config(rung: &(&str, f64, bool, bool), case: &Case) -> TrackingConfig {
    let mut config = TrackingConfig::paper();
    config.filter.q = Q;
    config.association = AssociationMethod::Global;
    let &(_, probability, kinematic, restart) = rung;
    config.gates = Gates { probability, kinematic, restart, ..config.gates };
    (config.life.delete_moving_s, config.life.delete_standing_s) = (600.0, 600.0);
    config.life.delete_radius_m = 1e6;
    config.life.most_tracks = 1;
    let mut sensor = SensorModel::default_of(SensorId(1), SensorKind::Asde);
    sensor.detection = 0.999;
    sensor.false_density_m2 = (f64::from(case.false_plots) / 4e4).max(1e-8);
    sensor.extra_sigma_m = 0.0;
    config.sensors.push(sensor);
    config
}

fn measured(case: &Case, rung: &(&str, f64, bool, bool), seed: u64, runs: u64) -> Row {
    let noise = NoiseLevel::all()[0].noise;
    let flights = FlightList::default();
    let (mut lost, mut errors, mut times) = (0u64, Errors::default(), Vec::new());
    let (mut second, mut restarts, mut refused) = (0, 0, 0);
    for run in 0..runs {
        let mut tracker = Tracker::new(config(rung, case));
        let plots = scenes::plots(&case.scene, &noise, seed, run);
        let mut last = f64::INFINITY;
        for (k, plot) in plots.iter().enumerate() {
            let mut scan = vec![*plot];
            let truth = case.scene.at(k as f64).position_m;
            // The first scans are clean, so that every rung begins with the same track.
            if k > ACQUISITION {
                let key = DrawKey { run_seed: seed, sensor: 2, entity: run, scan: k as u64 };
                let mut rng = key.rng(Purpose::Study);
                for n in 0..case.false_plots {
                    let (u, v) = (uniform(&mut rng) - 0.5, uniform(&mut rng) - 0.5);
                    let place = truth + Vector2::new(u, v) * 200.0;
                    let sigma = plot.along_m2.sqrt();
                    scan.push(round_plot(plot.time, n + 1, place, sigma));
                }
            }
            let begin = clock::thread_ns();
            let tracks = tracker.scan(SimTime::from_s(k as f64), &scan, &flights);
            times.push((clock::thread_ns() - begin) as f64);
            last = tracks.first().map_or(f64::INFINITY, |t| (t.position_m - truth).norm());
            if k >= ACQUISITION {
                errors.add(if last < LOST_M { last } else { LOST_M });
            }
        }
        lost += u64::from(last.is_nan() || last > LOST_M);
        let statistics = tracker.statistics();
        second += statistics.gate_2;
        restarts += statistics.restarts;
        refused += statistics.refused;
    }
    let (ns_per_update, ns_p99) = median_and_p99(&mut times);
    Row {
        group: "gates".into(),
        scene: case.name.into(),
        rung: rung.0.into(),
        rmse_m: errors.rms(),
        p95_m: errors.p95(),
        lost_pct: Some(100.0 * lost as f64 / runs as f64),
        ns_per_update,
        ns_p99,
        error: Some(100.0 * lost as f64 / runs as f64),
        error_unit: Some(format!(
            "% of tracks lost; a run: {:.1} by the second gate, {:.2} restarts, {:.1} refused",
            second as f64 / runs as f64,
            restarts as f64 / runs as f64,
            refused as f64 / runs as f64
        )),
        ..Row::default()
    }
}

/// Measures the ladder.
pub(crate) fn run(options: &Options, progress: &mut dyn FnMut(Progress)) -> Outcome {
    let runs = if options.quick { 100 } else { 500 };
    let cases = cases();
    let mut rows = Vec::new();
    for case in &cases {
        for rung in &RUNGS {
            rows.push(measured(case, rung, options.seed, runs));
            progress(Progress {
                group: "gates",
                what: format!("{} {}", case.name, rung.0),
                done: rows.len(),
                total: cases.len() * RUNGS.len(),
            });
        }
    }
    let ladder = Ladder {
        group: "gates".into(),
        title: "Gates: which plots may belong to a track".into(),
        about: format!(
            "One target followed by the whole tracker, {runs} runs a scene with the same plots for every rung, \
             the paper's three-state filter with a tight q = {Q} m²/s⁵, so that turns are surprises. A plot \
             outside the covariance gate is offered to the second gate, which asks what the mover can reach; two \
             successive plots outside both start the state anew (all at 99.9 %). Errors are those of all runs, each at \
             most {LOST_M} m: beyond that the track is lost."
        ),
        error_label: format!("position error, m (rms, each at most {LOST_M})"),
        scenes: cases
            .iter()
            .map(|c| SceneAbout { name: c.name.into(), about: c.about.into() })
            .collect(),
        ..Ladder::default()
    };
    Outcome { ladder, rows, ..Outcome::default() }
}

/// Error columns for a snapshot.
#[must_use]
pub fn error_table(seed: u64, runs: u64) -> String {
    let mut out = String::from("scene rung lost_pct rmse_m\n");
    for case in &cases() {
        for rung in &RUNGS {
            let row = measured(case, rung, seed, runs);
            out += &format!(
                "{} \"{}\" {:.0} {}\n",
                row.scene,
                row.rung,
                row.lost_pct.unwrap_or(f64::NAN),
                row.rmse_m.map_or_else(|| "-".to_owned(), |v| format!("{v:.2}")),
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
        insta::assert_snapshot!(error_table(3, 20));
    }

    #[test]
    fn the_restart_keeps_what_the_gates_alone_lose() {
        let cases = cases();
        let landing = cases.iter().find(|c| c.name == "landing").expect("there");
        let lost = |rung: usize| measured(landing, &RUNGS[rung], 11, 40).lost_pct.expect("counted");
        assert!(lost(1) > 50.0, "the corner is no turn that a gate forgives: {}", lost(1));
        assert!(lost(4) < 3.0, "{}", lost(4));
    }
}
