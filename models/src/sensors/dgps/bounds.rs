//! What leaving out an effect of differential positioning can change at most.

use super::{BUDGET, Budgeted, DgpsConfig, PER_SATELLITE, ReferenceLoss};
use crate::effects::positioning::{
    Ladders, PlannedEffect, PositioningEffect as E, PositioningScene,
};
use crate::effects::{Level, Loss};
use crate::sensors::reporting::bounds::{
    GEOMETRY_SHARE, SIGMAS, duration, given, larger, noise, outage_probability, services, two,
    unreliable,
};
use crate::sensors::reporting::ranging::{
    RangeCorrections, RangingConfig, multipath_growth, obliquity,
};
use crate::sensors::reporting::satellite_bounds::{
    aged_sigma_m, dilution, receiver, satellite_probability, satellites,
};

/// Outages of the reference station.
fn reference(config: &DgpsConfig, horizon_s: f64) -> PlannedEffect {
    let p = outage_probability(&config.reference, horizon_s).min(1.0);
    let then = match config.on_reference_loss {
        ReferenceLoss::NoReport => "no report meanwhile",
        ReferenceLoss::StandAlone(_) => "stand-alone meanwhile",
    };
    let called = if config.reference.mean_up_s == f64::INFINITY {
        "the station never fails".into()
    } else {
        let hours = config.reference.mean_up_s / 3600.0;
        format!("MTBF {hours:.3} h over {}, {then}", duration(horizon_s))
    };
    two(E::ReferenceOutage, called, Loss::odds(p))
}

/// Differential positioning by its error budget.
#[must_use]
pub(super) fn budget(config: &DgpsConfig, model: &Budgeted, scene: &PositioningScene) -> Ladders {
    let factor = SIGMAS * model.north_factor.max(model.east_factor);
    let c = &scene.conditions;
    let b = &model.budget;
    let age_s = model.correction_latency_s + model.correction_s;
    let least = b.sigma_m(0.0, 0.0, 0.0);
    // A root of squares grows by less, the more is already in it: so these add up to a bound.
    let far = factor * (b.sigma_m(c.distance_m, c.speed_mps, 0.0) - least);
    let old = factor * (b.sigma_m(0.0, 0.0, age_s) - least);
    let largest = b.sigma_m(c.distance_m, c.speed_mps, age_s);
    let sigma_m = largest * model.north_factor.max(model.east_factor);
    let [mut correlated, mut white] = noise(sigma_m, model.correlated_share, model.tau_s);
    if let ReferenceLoss::StandAlone(alone) = &config.on_reference_loss
        && config.reference.mean_up_s < f64::INFINITY
    {
        // While the station is out, errors are the larger ones of stand-alone positions.
        let [other, new] = noise(larger(alone), alone.correlated_share, alone.tau_s);
        for (mine, other) in [(&mut correlated, other), (&mut white, new)] {
            if other.ladder.rungs[0].loss.fixed_m > mine.ladder.rungs[0].loss.fixed_m {
                *mine = other;
            }
        }
    }
    let called = "error budget, fixed by the scene (level budget)".into();
    Ladders {
        model: &BUDGET,
        effects: vec![
            given(E::Geometry, Level::Cheap, called, SIGMAS * GEOMETRY_SHARE * sigma_m),
            services(&model.service, scene.horizon_s),
            unreliable(&model.service, &model.soft, scene),
            reference(config, scene.horizon_s),
            two(
                E::CorrectionDistance,
                format!("targets to {} m at up to {} m/s", c.distance_m, c.speed_mps),
                Loss::moves(far),
            ),
            two(
                E::CorrectionAge,
                format!("up to {age_s} s at {} m/s²", b.correction_acceleration_ms2),
                Loss::moves(old),
            ),
            correlated,
            white,
        ],
        step_m: 0.0,
    }
}

/// Differential positioning range by range.
#[must_use]
pub(super) fn per_satellite(
    config: &DgpsConfig,
    ranging: &RangingConfig,
    corrections: &RangeCorrections,
    scene: &PositioningScene,
) -> Ladders {
    let mask_rad = ranging.sky.mask_deg.to_radians();
    let per_range = SIGMAS * dilution(ranging, scene);
    let c = &scene.conditions;
    let age_s = corrections.latency_s + corrections.period_s;
    let iono_m = corrections.iono_gradient
        * (c.distance_m + 2.0 * corrections.smoothing_s * c.speed_mps)
        * obliquity(mask_rad);
    let far_m = libm::hypot(iono_m, corrections.space_decorrelation * c.distance_m);
    let aged_m = aged_sigma_m(&ranging.budget, mask_rad, age_s);
    let reference_m = corrections.reference.sigma_m * multipath_growth(mask_rad);
    // A satellite that has risen since its correction was made, or fails softly meanwhile.
    let slots = ranging.sky.constellation.slots.len() as f64;
    let risen = (2.0 * slots * age_s / SIDEREAL_DAY_S).min(1.0);
    let false_ranges = satellite_probability(&ranging.sky, false, scene.horizon_s);
    let [hard, soft] = satellites(&ranging.sky, scene);
    let [multipath, white] = receiver(ranging, scene);
    let called = "least squares, fixed by the scene (level per_satellite)".into();
    let old = Loss { odds: (risen + false_ranges).min(1.0), ..Loss::moves(per_range * aged_m) };
    Ladders {
        model: &PER_SATELLITE,
        effects: vec![
            given(E::Geometry, Level::Exact, called, 0.0),
            hard,
            soft,
            reference(config, scene.horizon_s),
            two(
                E::CorrectionDistance,
                format!("targets to {} m at up to {} m/s", c.distance_m, c.speed_mps),
                Loss::moves(per_range * far_m),
            ),
            two(E::CorrectionAge, format!("up to {age_s} s, σ to {aged_m:.3} m"), old),
            two(
                E::ReferenceErrors,
                format!("σ to {reference_m:.2} m per range"),
                Loss::moves(per_range * reference_m),
            ),
            multipath,
            white,
        ],
        step_m: 0.0,
    }
}

/// Half of it passes between two rises of one satellite over one place.
const SIDEREAL_DAY_S: f64 = 86_164.1;
