//! A search for the scene whose plan is farthest beyond its tolerance.

use super::scene::{GENES, ProofScene, proof_scene};
use models::draw::{DrawKey, Purpose, uniform};
use rand::rngs::ChaCha8Rng;
use scenarios::ScenarioError;

/// The worst scene that a search found.
#[derive(Clone, Debug)]
pub struct Worst {
    /// Largest measured over allowed of any criterion.
    pub ratio: f64,
    /// The numbers that make it.
    pub genes: Vec<f64>,
    /// The scene.
    pub scene: ProofScene,
    /// What of it is beyond the tolerance with another seed and twenty times the scans.
    pub violations: Vec<String>,
}

/// Parents and children of a generation.
const PARENTS: usize = 4;
const CHILDREN: usize = 16;

/// A search for the worst scene: an evolution of the numbers that make one, from the worst of some random scenes on.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Seed of all its draws.
    pub seed: u64,
    /// Generations of each restart.
    pub generations: u64,
    /// Scans that a scene is played.
    pub scans: u64,
}

impl Search {
    /// One restart, by itself; `tell` hears after each generation how many there were and the largest measured over
    /// allowed so far.
    ///
    /// # Errors
    /// If a parameter set that ships is missing.
    pub fn restart(
        &self,
        restart: u64,
        tell: &mut dyn FnMut(u64, f64),
    ) -> Result<Worst, ScenarioError> {
        let Self { seed, generations, scans } = *self;
        let key = DrawKey { run_seed: seed, sensor: 10, entity: restart, scan: 0 };
        let rng = &mut key.rng(Purpose::Study);
        let number = 1_000_000 + restart;
        let ratio = |genes: &[f64]| -> Result<f64, ScenarioError> {
            let scene = proof_scene(seed, number, genes)?;
            Ok(scene.play(seed, scans).map_or(0.0, |r| r.surely(&scene.tolerance)))
        };
        let random =
            |rng: &mut ChaCha8Rng| -> Vec<f64> { (0..GENES).map(|_| uniform(rng)).collect() };
        let mut population = Vec::new();
        for _ in 0..2 * CHILDREN {
            let genes = random(rng);
            population.push((ratio(&genes)?, genes));
        }
        let worst_first = |p: &mut Vec<(f64, Vec<f64>)>| p.sort_by(|a, b| b.0.total_cmp(&a.0));
        worst_first(&mut population);
        population.truncate(PARENTS);
        let mut step = 0.2;
        for generation in 1..=generations {
            let before = population[0].0;
            let mut better = 0;
            for _ in 0..CHILDREN {
                let child: Vec<f64> = (0..GENES)
                    .map(|g| {
                        // Of one parent or another, moved a little; now and then somewhere else.
                        let parent =
                            &population[(uniform(rng) * population.len() as f64) as usize].1;
                        let moved = parent[g] + step * (2.0 * uniform(rng) - 1.0);
                        if uniform(rng) < 0.03 {
                            uniform(rng)
                        } else {
                            moved.clamp(0.0, 1.0 - 1e-12)
                        }
                    })
                    .collect();
                let of = ratio(&child)?;
                better += usize::from(of > before);
                population.push((of, child));
            }
            // The one-fifth rule.
            step *= if better * 5 > CHILDREN { 1.3 } else { 0.85 };
            step = f64::clamp(step, 0.01, 0.5);
            worst_first(&mut population);
            population.truncate(PARENTS);
            tell(generation, population[0].0);
        }
        let (ratio, genes) = population.swap_remove(0);
        let scene = proof_scene(seed, number, &genes)?;
        let judged = scene.beyond(seed + 77, 20 * scans, &|radar| radar);
        let violations = judged.unwrap_or_else(|e| vec![e]);
        Ok(Worst { ratio, genes, scene, violations })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_for_the_worst_scene_finds_none_beyond_its_tolerance() {
        let search = Search { seed: 3, generations: 6, scans: 60 };
        for restart in 0..2 {
            let mut told = Vec::new();
            let worst = search.restart(restart, &mut |n, ratio| told.push((n, ratio)));
            let worst = worst.expect("sets ship");
            assert!(told.iter().map(|t| t.0).eq(1..=6), "one after the other: {told:?}");
            assert!(told.is_sorted_by_key(|t| t.1), "a worse scene is never given up: {told:?}");
            assert_eq!(told.last().map(|t| t.1), Some(worst.ratio));
            println!("{:.2} of the tolerance in {}", worst.ratio, worst.scene.name);
            assert!(worst.violations.is_empty(), "{:#?} in {:#?}", worst.violations, worst.scene);
        }
    }
}
