//! The proof of the effect plan: planned against exact on the same draws, target by target, over the
//! whole space that a scene may state; nothing is pooled.

mod costs;
mod edges;
mod play;
mod result;
mod scene;
mod tails;
mod worst;

pub use edges::{Edge, edge_scene};
pub use play::judge_scene;
pub use result::{SceneResult, TargetResult};
pub use scene::{GENES, Genes, ProofScene, Target, Targets, named_cases, proof_scene};
pub use tails::{binomial_tail, poisson_tail};
pub use worst::{Search, Worst};

#[cfg(test)]
mod tests {
    use super::*;
    use models::effects::Tolerance;
    use models::sensors::asde::Asde;
    use models::sensors::asde::plan::Fault;
    use models::sensors::radar::levels::RadarLevels;
    use models::sensors::{PlotSink, ScanInterval, Sensor};
    use models::time::SimTime;
    use std::path::Path;
    use std::sync::Arc;

    #[test]
    fn no_scene_that_broke_a_plan_is_beyond_its_tolerance() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/effects-scenes");
        let mut tried = 0;
        for file in std::fs::read_dir(folder).expect("the folder is there").flatten() {
            let path = file.path();
            if path.extension().is_none_or(|e| e != "toml") {
                continue;
            }
            let scene = scenarios::load(&path).unwrap_or_else(|e| panic!("{e}"));
            for position_m in [0.05, 0.1, 0.5, 3.0] {
                let tolerance = Tolerance { position_m, ..Tolerance::default() };
                let (result, found) = judge_scene(&scene, tolerance, 0..67).expect("a radar");
                let [shift, detection, plots] = result.largest(&tolerance);
                println!(
                    "{} at {position_m} m: {shift:.2} of the shift, {detection:.2} of the detection, \
                     {plots:.2} of the false plots",
                    scene.name
                );
                assert!(found.is_empty(), "{} at {position_m} m: {found:#?}", scene.name);
                assert!(result.targets.iter().any(|t| t.both > 100), "{}: plots", scene.name);
                tried += 1;
            }
        }
        assert_eq!(tried, 32);
    }

    #[test]
    fn every_planted_fault_is_found_within_a_thousand_scenes() {
        for fault in Fault::ALL {
            let found = (0..1000).find(|&n| {
                let scene = proof_scene(5, n, &[]).expect("sets ship");
                // Nothing else than a wall can be missed.
                if fault == Fault::NoWalls && scene.buildings.is_empty() {
                    return false;
                }
                let judged = scene.judge(n, 100, &|radar| radar.planting(fault));
                !judged.expect("a sound scene").1.is_empty()
            });
            println!("{fault:?}: found in scene {found:?}");
            assert!(found.is_some(), "{fault:?} among 1000 scenes");
        }
    }

    #[test]
    fn walls_make_ghosts_and_a_plan_without_walls_loses_them() {
        let (mut ghosts, mut lost) = (0, 0);
        for n in 0..60 {
            let scene = proof_scene(5, n, &[]).expect("sets ship");
            if scene.buildings.is_empty() {
                continue;
            }
            let bare = ProofScene { buildings: Arc::new([]), ..scene.clone() };
            let mut with = scene.radar().expect("sound").at_levels(RadarLevels::EXACT);
            let mut without = bare.radar().expect("sound").at_levels(RadarLevels::EXACT);
            let count = |radar: &mut Asde| -> usize {
                let mut sink = PlotSink::default();
                for scan in 1..=10 {
                    let time = |n: u64| SimTime::from_s(n as f64);
                    let (from, to) = (time(scan - 1), time(scan));
                    let interval = ScanInterval { run_seed: 1, scan, from, to };
                    radar.scan(&interval, &scene.truth, &scene.weather, &mut sink);
                }
                sink.causes.iter().filter(|c| c.key.is_none()).count()
            };
            let extra = count(&mut with).saturating_sub(count(&mut without));
            let planned = scene.play_with(n, 50, &|r| r.planting(Fault::NoWalls)).expect("sound");
            println!("scene {n}: {extra} ghosts in 10 scans; {} lost in 50", planned.false_plots);
            ghosts += usize::from(extra > 0);
            lost += usize::from(planned.false_plots > 0);
        }
        assert!(ghosts >= 3 && lost >= 3, "{ghosts} scenes with ghosts, {lost} that lost them");
    }

    #[test]
    fn no_case_that_was_found_is_beyond_its_tolerance() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/effects-cases.csv");
        let text = std::fs::read_to_string(path).expect("the cases");
        let cases = named_cases(&text).unwrap_or_else(|e| panic!("{e}"));
        assert!(!cases.is_empty());
        for (scene, what) in cases {
            let (result, found) = scene.judge(11, 400, &|radar| radar).expect("a sound scene");
            println!("{}: {:.2?} ({what})", scene.name, result.largest(&scene.tolerance));
            assert!(found.is_empty(), "{} ({what}): {found:#?}", scene.name);
        }
        assert!(named_cases("5,x,,broken").expect_err("no number").contains("line 1"));
    }
}
