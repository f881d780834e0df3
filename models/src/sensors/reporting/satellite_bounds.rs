//! What leaving out an effect of satellite positioning can change at most, alone or with corrections.

use super::bounds::{
    GEOMETRY_SHARE, SIGMAS, duration, given, larger, noise, outage_probability, rarely, services,
    two, unreliable,
};
use super::constellation::{SatelliteFailures, SkyConfig};
use super::dgps::{self, Budgeted, DgpsConfig, ReferenceLoss};
use super::gps::{self, Diluted, Statistical};
use super::ranging::{
    RangeBudget, RangeCorrections, RangingConfig, multipath_growth, obliquity, tropospheric_mapping,
};
use crate::effects::positioning::{
    Ladders, PlannedEffect, PositioningEffect as E, PositioningScene,
};
use crate::effects::{Level, Loss};

/// Probability that any satellite is, or goes, off (`hard`) or false within `horizon_s`, at most.
#[must_use]
pub fn satellite_probability(sky: &SkyConfig, hard: bool, horizon_s: f64) -> f64 {
    let failures = &sky.failures;
    let slots = sky.constellation.slots.len() as f64;
    let soft = [failures.soft];
    let modes = if hard { &failures.hard[..] } else { &soft[..] };
    // A mode that happens once in the age of the universe never happens, however long the run.
    let events = modes.iter().filter(|m| m.mtbf < 1e300);
    (slots * events.map(|m| m.load() + horizon_s / m.mtbf).sum::<f64>()).min(1.0)
}

/// Satellite positioning by statistics.
#[must_use]
pub fn gps_statistical(model: &Statistical, scene: &PositioningScene) -> Ladders {
    let sigma_m = larger(&model.error);
    let called = "statistics of the scene, fixed by it (level statistical)".into();
    let geometry = given(E::Geometry, Level::Cheap, called, SIGMAS * GEOMETRY_SHARE * sigma_m);
    let [correlated, white] = noise(sigma_m, model.error.correlated_share, model.error.tau_s);
    Ladders {
        model: &gps::STATISTICAL,
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

/// Satellites off and false.
fn satellites(sky: &SkyConfig, scene: &PositioningScene) -> [PlannedEffect; 2] {
    let SatelliteFailures { soft_limit_m, .. } = sky.failures;
    let horizon_s = scene.horizon_s;
    let slots = sky.constellation.slots.len();
    let never = sky.failures.hard.is_empty();
    let hard = if never {
        "satellites never fail".into()
    } else {
        format!("{slots} satellites over {}", duration(horizon_s))
    };
    let soft = satellite_probability(sky, false, horizon_s);
    // A range error moves a fix by at most its dilution.
    let shift_m = soft_limit_m * sky.pdop_limit;
    [
        two(E::HardFailures, hard, Loss::odds(satellite_probability(sky, true, horizon_s))),
        two(
            E::SoftFailures,
            format!("{slots} satellites, ranges to {soft_limit_m} m"),
            rarely(soft, shift_m, &scene.tolerance),
        ),
    ]
}

/// Satellite positioning by the dilution of what is in view.
#[must_use]
pub fn gps_constellation(model: &Diluted, scene: &PositioningScene) -> Ladders {
    let sigma_m = model.uere_m * scene.conditions.dilution;
    let called = format!(
        "{} slots, fixed by the scene (level constellation)",
        model.sky.constellation.slots.len()
    );
    let [hard, soft] = satellites(&model.sky, scene);
    let [correlated, white] = noise(sigma_m, model.correlated_share, model.tau_s);
    Ladders {
        model: &gps::CONSTELLATION,
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

/// Largest position deviation per deviation of a range, at the least elevation, with the weights in use.
fn dilution(ranging: &RangingConfig, scene: &PositioningScene) -> f64 {
    let weights = if ranging.weighted {
        let at = |elevation_rad: f64| ranging.budget.variance_m2(elevation_rad);
        let lowest = ranging.sky.mask_deg.to_radians();
        (at(lowest) / at(std::f64::consts::FRAC_PI_2)).sqrt()
    } else {
        1.0
    };
    weights * scene.conditions.dilution
}

/// Deviation of the errors that all receivers share, at the least elevation, m.
fn common_sigma_m(b: &RangeBudget, mask_rad: f64) -> f64 {
    [
        b.selective_availability.sigma_m,
        b.clock_ephemeris.sigma_m,
        b.ionosphere.sigma_m * obliquity(mask_rad),
        b.troposphere.sigma_m * tropospheric_mapping(mask_rad),
    ]
    .iter()
    .map(|s| s * s)
    .sum::<f64>()
    .sqrt()
}

/// Deviation of what they change by within `age_s`, m: `2σ²(1 − ρ(t))` of each source.
fn aged_sigma_m(b: &RangeBudget, mask_rad: f64, age_s: f64) -> f64 {
    let first = |sigma_m: f64, tau_s: f64| -2.0 * sigma_m * sigma_m * libm::expm1(-age_s / tau_s);
    let x = age_s / b.selective_availability.tau_s;
    let sigma_m = b.selective_availability.sigma_m;
    let second = 2.0 * sigma_m * sigma_m * (1.0 - (1.0 + x) * libm::exp(-x)).max(0.0);
    (second
        + first(b.clock_ephemeris.sigma_m, b.clock_ephemeris.tau_s)
        + first(b.ionosphere.sigma_m * obliquity(mask_rad), b.ionosphere.tau_s)
        + first(b.troposphere.sigma_m * tropospheric_mapping(mask_rad), b.troposphere.tau_s))
    .sqrt()
}

fn receiver(ranging: &RangingConfig, scene: &PositioningScene) -> [PlannedEffect; 2] {
    let (b, per_range) = (&ranging.budget, SIGMAS * dilution(ranging, scene));
    let multipath_m = b.multipath.sigma_m * multipath_growth(ranging.sky.mask_deg.to_radians());
    [
        two(
            E::Multipath,
            format!("σ to {multipath_m:.2} m per range over {} s", b.multipath.tau_s),
            // Two independent states, where it is taken up again.
            Loss::moves(std::f64::consts::SQRT_2 * per_range * multipath_m),
        ),
        two(
            E::White,
            format!("receiver noise of {} m per range", b.noise_m),
            Loss::moves(per_range * b.noise_m),
        ),
    ]
}

/// Satellite positioning range by range.
#[must_use]
pub fn gps_per_satellite(ranging: &RangingConfig, scene: &PositioningScene) -> Ladders {
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
        model: &gps::PER_SATELLITE,
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
pub fn dgps_budget(config: &DgpsConfig, model: &Budgeted, scene: &PositioningScene) -> Ladders {
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
        model: &dgps::BUDGET,
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
pub fn dgps_per_satellite(
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
        model: &dgps::PER_SATELLITE,
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
