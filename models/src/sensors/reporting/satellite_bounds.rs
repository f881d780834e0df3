//! What leaving out satellites, ranges and receivers can change at most; shared by sensors that use satellites.

use crate::effects::Loss;
use crate::effects::positioning::{PlannedEffect, PositioningEffect as E, PositioningScene};
use crate::sensors::reporting::bounds::{SIGMAS, duration, rarely, two};
use crate::sensors::reporting::constellation::{SatelliteFailures, SkyConfig};
use crate::sensors::reporting::ranging::{
    RangeBudget, RangingConfig, aged_m2, multipath_growth, obliquity, tropospheric_mapping,
};

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

/// Satellites off and false.
pub(crate) fn satellites(sky: &SkyConfig, scene: &PositioningScene) -> [PlannedEffect; 2] {
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

/// Largest position deviation per deviation of a range, at the least elevation, with the weights in use.
pub(crate) fn dilution(ranging: &RangingConfig, scene: &PositioningScene) -> f64 {
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
pub(crate) fn common_sigma_m(b: &RangeBudget, mask_rad: f64) -> f64 {
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

/// Deviation of what they change by within `age_s`, m.
pub(crate) fn aged_sigma_m(b: &RangeBudget, mask_rad: f64, age_s: f64) -> f64 {
    let mapping = [1.0, obliquity(mask_rad), tropospheric_mapping(mask_rad)];
    let parts = aged_m2(b, age_s);
    parts.iter().zip(mapping).map(|(part, mapping)| part * mapping * mapping).sum::<f64>().sqrt()
}

/// What a receiver adds to each range: multipath and noise.
pub(crate) fn receiver(ranging: &RangingConfig, scene: &PositioningScene) -> [PlannedEffect; 2] {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::reporting::ranging::Source;

    #[test]
    fn errors_age_by_their_own_orders() {
        let none = Source { sigma_m: 0.0, tau_s: 100.0 };
        let quiet = RangeBudget {
            selective_availability: none,
            clock_ephemeris: none,
            ionosphere: none,
            troposphere: none,
            ..RangeBudget::modern()
        };
        let two_m = Source { sigma_m: 2.0, tau_s: 100.0 };
        // Second order, ρ(τ) = 2/e: √(8·(1 − 2/e)); first order, ρ(τ) = 1/e: √(8·(1 − 1/e)).
        let second = RangeBudget { selective_availability: two_m, ..quiet };
        assert!((aged_sigma_m(&second, 0.1, 100.0) - 1.453_936).abs() < 1e-6);
        let first = RangeBudget { clock_ephemeris: two_m, ..quiet };
        assert!((aged_sigma_m(&first, 0.1, 100.0) - 2.248_770).abs() < 1e-6);
        for age_s in [0.0, 1e5] {
            let whole = if age_s == 0.0 { 0.0 } else { 8.0f64.sqrt() };
            assert!((aged_sigma_m(&second, 0.1, age_s) - whole).abs() < 1e-9, "{age_s}");
        }
    }
}
