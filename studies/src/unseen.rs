//! Scenes that nothing was chosen on, and what share of the bound a rung reaches there.
//!
//! The filters' numbers were chosen on a few scenes at one noise. Here are eight other ways of moving and five noises, and
//! as many more as anybody asks for from a seed, so that the order of the rungs can be checked.

use crate::bounds;
use crate::scenes::{self, Leg, Noise, Scene};
use models::draw::{DrawKey, Purpose, uniform};
use models::filter::{Estimator, FilterConfig, Rung, StateEstimator};
use models::frames::Point2;

/// Scans at the start that do not count.
const ACQUISITION: usize = 3;
/// A track this far off at the end is lost, m.
const LOST_M: f64 = 50.0;

fn scene(name: &'static str, speed_mps: f64, legs: Vec<Leg>, samples: usize) -> Scene {
    Scene { name, about: "", speed_mps, legs, samples }
}

/// A turn, degrees to the left.
fn turn(deg: f64, radius_m: f64, speed_mps: f64) -> Leg {
    Leg::turn(deg.to_radians(), radius_m, speed_mps)
}

/// Eight ways of moving on an airport, none of which the filters were chosen on.
#[must_use]
pub fn eight() -> Vec<Scene> {
    let go = Leg::straight;
    let corner = Leg { corner_rad: 90f64.to_radians(), ..go(1e9, 0.0) };
    vec![
        scene(
            "rapid exit",
            65.0,
            vec![go(15.0, -2.2), turn(30.0, 550.0, 32.0), go(12.0, -1.8), go(1e9, 0.0)],
            60,
        ),
        scene(
            "two taxi turns",
            9.0,
            vec![
                go(15.0, 0.0),
                turn(90.0, 45.0, 9.0),
                go(14.0, 0.0),
                turn(-90.0, 45.0, 9.0),
                go(1e9, 0.0),
            ],
            70,
        ),
        scene(
            "backtrack",
            12.0,
            vec![go(15.0, 0.0), go(8.0, -1.0), turn(180.0, 20.0, 4.0), go(8.0, 1.0), go(1e9, 0.0)],
            75,
        ),
        scene(
            "hard-braking vehicle",
            20.0,
            vec![go(15.0, 0.0), go(20.0 / 7.0, -7.0), go(1e9, 0.0)],
            45,
        ),
        scene(
            "rejected take-off",
            0.0,
            vec![go(12.0, 0.0), go(20.0, 2.3), go(46.0 / 3.5, -3.5), go(1e9, 0.0)],
            65,
        ),
        scene(
            "slalom",
            11.0,
            vec![
                go(10.0, 0.0),
                turn(40.0, 60.0, 11.0),
                turn(-80.0, 60.0, 11.0),
                turn(80.0, 60.0, 11.0),
                turn(-40.0, 60.0, 11.0),
                go(1e9, 0.0),
            ],
            60,
        ),
        scene("straight", 15.0, vec![go(1e9, 0.0)], 60),
        scene("corner of 90°", 10.0, vec![go(25.0, 0.0), corner], 60),
    ]
}

/// So many scenes drawn from a seed: straight stretches, speeding up, braking and turns within what aircraft and vehicles do.
#[must_use]
pub fn generated(seed: u64, count: u32) -> Vec<Scene> {
    let one = |n: u32| {
        let key = DrawKey { run_seed: seed, sensor: 0, entity: n.into(), scan: 0 };
        let mut rng = key.rng(Purpose::Study);
        let mut between = |low: f64, high: f64| low + (high - low) * uniform(&mut rng);
        let mut speed = between(0.0, 1.0) * between(8.0, 70.0);
        let start = speed;
        let mut legs = vec![Leg::straight(between(5.0, 15.0), 0.0)];
        while legs.iter().map(|l| l.duration_s).sum::<f64>() < 55.0 {
            let kind = between(0.0, 1.0);
            legs.push(if kind < 0.3 {
                Leg::straight(between(4.0, 15.0), 0.0)
            } else if kind < 0.65 && speed > 3.0 {
                // At most 2.5 m/s² to the side.
                let radius = (speed * speed / between(0.8, 2.5)).max(12.0);
                let side = if between(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
                Leg::turn(side * between(20.0f64.to_radians(), 1.8), radius, speed)
            } else {
                let wanted = between(0.0, 1.0) * between(6.0, 60.0);
                let rate = between(0.6, 3.0) * if wanted < speed { -1.0 } else { 1.0 };
                let leg = Leg::straight((wanted - speed) / rate, rate);
                speed = wanted;
                leg
            });
        }
        legs.push(Leg::straight(1e9, 0.0));
        scene("generated", start, legs, 65)
    };
    (0..count).map(one).collect()
}

/// Five radars: fine, limited by noise, by cells, far away, and coarse.
#[must_use]
pub fn noises() -> [(&'static str, Noise); 5] {
    let radar = |range_m: f64, deg: f64, radar_m: Point2<f64>| Noise::Radar {
        range_m,
        azimuth_rad: deg.to_radians(),
        radar_m,
    };
    let near = Point2::new(900.0, -1400.0);
    [
        ("0.4 m", Noise::Circular(0.4)),
        ("thermal", radar(0.8348, 0.024_29, near)),
        ("cell", radar(1.5578, 0.072_17, near)),
        ("cell at 4 km", radar(1.5578, 0.072_17, Point2::new(900.0, -3900.0))),
        ("8 m", Noise::Circular(8.0)),
    ]
}

/// What a rung reaches on one scene at one noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The scene.
    pub scene: &'static str,
    /// The noise.
    pub noise: &'static str,
    /// Reduction of the mean squared error over that of the bound that is told when motion changes and which legs are
    /// steady.
    pub share: f64,
    /// Runs that ended far off.
    pub lost: u32,
}

/// All scenes at all noises with one rung, `runs` runs each.
#[must_use]
pub fn shares(scenes: &[Scene], rung: Rung, seed: u64, runs: u64) -> Vec<Cell> {
    let config = FilterConfig::new(rung);
    let mut cells = Vec::new();
    for scene in scenes {
        let truth: Vec<_> = (0..scene.samples).map(|k| scene.at(k as f64).position_m).collect();
        for (name, noise) in noises() {
            let (mut raw, mut own, mut lost, mut count) = (0.0, 0.0, 0, 0.0);
            for run in 0..runs {
                let plots = scenes::plots(scene, &noise, seed, run);
                let Ok(mut filter) = Estimator::from_plot(&config, &plots[0]) else { continue };
                let (mut of_run, mut off) = (0.0, 0.0);
                for (k, plot) in plots.iter().enumerate().skip(1) {
                    if filter.update(plot).is_err() {
                        lost += 1;
                        break;
                    }
                    off = (filter.estimate().position_m() - truth[k]).norm();
                    if k >= ACQUISITION {
                        of_run += off * off;
                        raw += (plot.position_m - truth[k]).norm_squared();
                        count += 1.0;
                    }
                }
                own += of_run;
                lost += u32::from(off.is_nan() || off > LOST_M);
            }
            let bound = bounds::of(scene, &noise, ACQUISITION).legs;
            let share = (1.0 - own / raw) / (1.0 - bound * count / raw);
            cells.push(Cell { scene: scene.name, noise: name, share, lost });
        }
    }
    cells
}

/// Reduction of the mean squared error against the plots, as a share, scene by scene and noise by noise.
#[must_use]
pub fn reductions(scenes: &[Scene], rung: Rung, seed: u64, runs: u64) -> Vec<(String, f64)> {
    let config = FilterConfig::new(rung);
    let mut cells = Vec::new();
    for (n, scene) in scenes.iter().enumerate() {
        let truth: Vec<_> = (0..scene.samples).map(|k| scene.at(k as f64).position_m).collect();
        for (name, noise) in noises() {
            let (mut raw, mut own) = (0.0, 0.0);
            for run in 0..runs {
                let plots = scenes::plots(scene, &noise, seed, run);
                let Ok(mut filter) = Estimator::from_plot(&config, &plots[0]) else { continue };
                for (k, plot) in plots.iter().enumerate().skip(1) {
                    let taken = filter.update(plot).is_ok();
                    if k >= ACQUISITION && taken {
                        own += (filter.estimate().position_m() - truth[k]).norm_squared();
                        raw += (plot.position_m - truth[k]).norm_squared();
                    }
                }
            }
            cells.push((format!("{} {n} / {name}", scene.name), 1.0 - own / raw));
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Absolute noise of the modes is right for one sensor: `mh27` was below 0.74 in 18 of the 40 cells.
    #[test]
    fn the_pair_reaches_three_quarters_of_the_bound_whatever_the_sensor() {
        let mut below = Vec::new();
        for rung in [Rung::Imm3, Rung::Mh27, Rung::Events27, Rung::Pair] {
            let cells = shares(&eight(), rung, 2027, 40);
            assert_eq!(cells.len(), 40);
            let mut sorted: Vec<f64> = cells.iter().map(|c| c.share).collect();
            sorted.sort_by(f64::total_cmp);
            let low: Vec<&Cell> = cells.iter().filter(|c| c.share < 0.74).collect();
            println!(
                "{}: least {:.2}, median {:.2}, below 0.74 in {}",
                rung.name(),
                sorted[0],
                sorted[20],
                low.len()
            );
            for c in &low {
                println!("    {} / {}: {:.2}", c.scene, c.noise, c.share);
            }
            assert!(cells.iter().all(|c| c.lost == 0), "{}", rung.name());
            below.push(low.len());
        }
        assert!(below[3] <= 4 && below[2] <= 4, "events27 and pair: {below:?}");
        assert!(below[3] < below[0] && below[3] < below[1], "{below:?}");
    }

    /// Ways of moving that nothing was chosen on, draw by draw, at five noises. With accelerations in any direction and turns held
    /// for weaker than they were, `events27` had 24 to 31 of 40 cells, the fewest at fine noise, where an echo says most of them.
    #[test]
    fn on_drawn_scenes_events_reach_three_quarters_of_the_bound() {
        let high = |rung, seed| {
            let cells = shares(&generated(seed, 8), rung, seed, 15);
            assert!(cells.iter().all(|c| c.lost == 0), "{} {seed}", rung.name());
            cells.iter().filter(|c| c.share >= 0.74).count()
        };
        let seeds = [301, 302, 303, 304, 305];
        let found = seeds.map(|seed| high(Rung::Events27, seed));
        let others = seeds.map(|seed| high(Rung::Mh27, seed));
        println!("of 40 cells: events27 {found:?}, mh27 {others:?}");
        assert!(found.iter().all(|n| *n >= 32), "{found:?}");
        assert!(found.iter().filter(|n| **n >= 36).count() >= 4, "{found:?}");
        assert!(found.iter().zip(&others).all(|(a, b)| a > b), "{found:?} {others:?}");
    }

    /// With one motion only and no word of a manoeuvre, `abg` had 64 % more mean squared error than the plots in hard braking,
    /// `ca3` 37 %.
    #[test]
    fn in_hard_braking_no_rung_is_worse_than_its_plots() {
        for scenes in [eight(), generated(11, 12)] {
            for rung in [Rung::Abg, Rung::Ca3, Rung::Ca3Ud, Rung::Ca6] {
                let cells = reductions(&scenes, rung, 2028, 40);
                let worst = cells.iter().min_by(|a, b| a.1.total_cmp(&b.1)).expect("cells");
                println!("{}: worst {:?}", rung.name(), worst);
                assert!(worst.1 > 0.0, "{}: {worst:?}", rung.name());
            }
        }
    }

    #[test]
    fn scenes_from_a_seed_are_movements_that_an_airport_sees() {
        let scenes = generated(5, 40);
        assert_eq!(scenes, generated(5, 40));
        for scene in &scenes {
            for k in 0..scene.samples {
                let (a, b) = (scene.at(k as f64), scene.at(k as f64 + 1.0));
                assert!(b.speed_mps >= -1e-9 && b.speed_mps <= 75.0, "{scene:?}");
                assert!((b.position_m - a.position_m).norm() <= 76.0);
            }
        }
        let below =
            |rung| shares(&scenes[..8], rung, 3, 15).iter().filter(|c| c.share < 0.74).count();
        let (modes, pair) = (below(Rung::Mh27), below(Rung::Pair));
        println!("of 40 drawn cells below 0.74: mh27 {modes}, pair {pair}");
        assert!(pair <= modes, "{pair} {modes}");
    }
}
