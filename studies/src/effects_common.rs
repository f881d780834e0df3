//! Draws and rows that the studies of effects share.

use crate::Row;
use models::draw::uniform;
use models::environment::surface::Material;
use models::frames::{Point2, Vector2};
use models::sensors::radar::shadow::Building;
use rand::rngs::ChaCha8Rng;

pub(crate) fn between(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * uniform(rng)
}

pub(crate) fn pick<T: Copy>(rng: &mut ChaCha8Rng, from: &[T]) -> T {
    from[((uniform(rng) * from.len() as f64) as usize).min(from.len() - 1)]
}

/// A building of metal whose south-west corner is at (`east`, `north`).
pub(crate) fn box_building(
    east: f64,
    north: f64,
    along: f64,
    across: f64,
    height_m: f64,
) -> Building {
    let corner = Point2::new(east, north);
    Building {
        name: "terminal".into(),
        footprint_m: [(0.0, 0.0), (along, 0.0), (along, across), (0.0, across)]
            .map(|(x, y)| corner + Vector2::new(x, y))
            .to_vec(),
        height_m,
        facade: Material::named("metal").expect("metal is a material"),
    }
}

/// A row of this group.
pub(crate) fn row(scene: &str, rung: String) -> Row {
    Row { group: "effects".into(), scene: scene.into(), rung, ..Row::default() }
}

/// The row that the planned ones are measured against; the plan takes `share` of its time.
pub(crate) fn exact_row(scene: &str, ns_per_look: Option<f64>, share: f64) -> Row {
    let saved = 100.0 * (1.0 - share);
    let rung = format!("everything exact (the plan saves {saved:.0} % of its time)");
    Row { error: Some(0.0), ns_per_update: ns_per_look, ..row(scene, rung) }
}
