//! What leaving out an effect of satellite positioning can change at most.

use super::{CONSTELLATION, Diluted, PER_SATELLITE, STATISTICAL, Statistical};
use crate::effects::positioning::{Ladders, PositioningEffect as E, PositioningScene};
use crate::effects::{Level, Loss};
use crate::sensors::reporting::bounds::{
    GEOMETRY_SHARE, SIGMAS, given, larger, noise, services, two, unreliable,
};
use crate::sensors::reporting::ranging::RangingConfig;
use crate::sensors::reporting::satellite_bounds::{common_sigma_m, dilution, receiver, satellites};

/// Satellite positioning by statistics.
#[must_use]
pub(super) fn statistical(model: &Statistical, scene: &PositioningScene) -> Ladders {
    let sigma_m = larger(&model.error);
    let called = "statistics of the scene, fixed by it (level statistical)".into();
    let geometry = given(E::Geometry, Level::Cheap, called, SIGMAS * GEOMETRY_SHARE * sigma_m);
    let [correlated, white] = noise(sigma_m, model.error.correlated_share, model.error.tau_s);
    Ladders {
        model: &STATISTICAL,
        effects: vec![
            geometry,
            services(&model.service, scene.horizon_s),
            unreliable(&model.service, &model.soft, scene),
            correlated,
            white,
        ],
        step_m: 0.0,
    }
}

/// Satellite positioning by the dilution of what is in view.
#[must_use]
pub(super) fn constellation(model: &Diluted, scene: &PositioningScene) -> Ladders {
    let sigma_m = model.uere_m * scene.conditions.dilution;
    let called = format!(
        "{} slots, fixed by the scene (level constellation)",
        model.sky.constellation.slots.len()
    );
    let [hard, soft] = satellites(&model.sky, scene);
    let [correlated, white] = noise(sigma_m, model.correlated_share, model.tau_s);
    Ladders {
        model: &CONSTELLATION,
        effects: vec![
            given(E::Geometry, Level::Middle, called, SIGMAS * GEOMETRY_SHARE * sigma_m),
            hard,
            soft,
            correlated,
            white,
        ],
        step_m: 0.0,
    }
}

/// Satellite positioning range by range.
#[must_use]
pub(crate) fn per_satellite(ranging: &RangingConfig, scene: &PositioningScene) -> Ladders {
    let mask_rad = ranging.sky.mask_deg.to_radians();
    let common_m = common_sigma_m(&ranging.budget, mask_rad);
    let per_range = SIGMAS * dilution(ranging, scene);
    let [hard, soft] = satellites(&ranging.sky, scene);
    let [multipath, white] = receiver(ranging, scene);
    let common = two(
        E::RangeErrors,
        format!("σ to {common_m:.2} m per range, dilution to {}", scene.conditions.dilution),
        Loss::moves(per_range * common_m),
    );
    let called = "least squares, fixed by the scene (level per_satellite)".into();
    Ladders {
        model: &PER_SATELLITE,
        effects: vec![
            given(E::Geometry, Level::Exact, called, 0.0),
            hard,
            soft,
            common,
            multipath,
            white,
        ],
        step_m: 0.0,
    }
}
