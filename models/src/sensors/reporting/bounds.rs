//! What leaving out an effect of a sensor can change at most, from its parameters alone: what the bounds of all reporting
//! sensors share. Each sensor's own stand in its file, those of satellite positioning in [`super::satellite_bounds`].
//!
//! A two-dimensional normal error exceeds [`SIGMAS`] of its larger deviation once in 3.7 million draws,
//! `exp(−5.5²/2)`. What is rare counts with the probability that it happens to a target within the run.

use crate::effects::positioning::{PlannedEffect, PositioningEffect as E, PositioningScene, rung};
use crate::effects::{Ladder, Level, Loss, Rung, Tolerance};
use crate::sensors::reporting::service::{Alternating, Service};
use crate::sensors::reporting::statistical::{NorthEast, SoftFailure};

/// Deviations that a drawn error may reach.
pub const SIGMAS: f64 = 5.5;

/// Horizontal deviations move by so much of their root mean square over a day where the geometry is
/// taken as constant: −29 to +90 % at five places with the reference constellation.
pub(crate) const GEOMETRY_SHARE: f64 = 0.9;

/// Probability that a process is or goes down within `horizon_s`: (1 − A) − A expm1(−T/U).
#[must_use]
pub fn outage_probability(process: &Alternating, horizon_s: f64) -> f64 {
    if process.mean_up_s == f64::INFINITY {
        return 0.0;
    }
    process.down_share() - process.up_share() * libm::expm1(-horizon_s / process.mean_up_s)
}

pub(crate) fn planned(effect: E, called_for: String, rungs: Vec<Rung>) -> PlannedEffect {
    PlannedEffect {
        effect,
        ladder: Ladder { effect: effect.name(), called_for, rungs },
        given: false,
    }
}

/// Left out or simulated.
pub(crate) fn two(effect: E, called_for: String, loss: Loss) -> PlannedEffect {
    let rungs = vec![rung(Level::Skipped, loss), rung(Level::Exact, Loss::NONE)];
    planned(effect, called_for, rungs)
}

/// A level that the scene gives; `moves_m` is what it may lose against the most exact one.
pub(crate) fn given(effect: E, level: Level, called_for: String, moves_m: f64) -> PlannedEffect {
    let rungs = vec![rung(level, Loss::moves(moves_m))];
    PlannedEffect { given: true, ..planned(effect, called_for, rungs) }
}

/// Something that happens with a probability and then moves a report: bounded by whichever takes less
/// of the tolerance.
pub(crate) fn rarely(probability: f64, metres: f64, tolerance: &Tolerance) -> Loss {
    if probability == 0.0 || metres == 0.0 {
        return Loss::NONE;
    }
    let by_metres = metres / tolerance.position_m < probability / tolerance.detection;
    if by_metres { Loss::moves(metres) } else { Loss::odds(probability) }
}

pub(crate) fn duration(horizon_s: f64) -> String {
    if horizon_s.is_finite() { format!("{horizon_s:.0} s") } else { "a run of any length".into() }
}

pub(crate) fn percent(share: f64) -> String {
    format!("{} %", (1e6 * share).round() / 1e4)
}

/// Coverage and availability.
pub(crate) fn services(service: &Service, horizon_s: f64) -> PlannedEffect {
    let p = outage_probability(&service.coverage, horizon_s)
        + outage_probability(&service.availability, horizon_s);
    let called = format!(
        "coverage {}, availability {}, {}",
        percent(service.coverage.up_share()),
        percent(service.availability.up_share()),
        duration(horizon_s)
    );
    two(E::HardFailures, called, Loss::odds(p.min(1.0)))
}

pub(crate) fn unreliable(
    service: &Service,
    soft: &SoftFailure,
    scene: &PositioningScene,
) -> PlannedEffect {
    let p = outage_probability(&service.reliability, scene.horizon_s).min(1.0);
    let share = percent(service.reliability.up_share());
    let called = format!("reliability {share}, shifts to {} m", soft.limit_m);
    two(E::SoftFailures, called, rarely(p, soft.limit_m, &scene.tolerance))
}

/// The correlated and the white part of an error of deviation `sigma_m` along its larger axis.
///
/// Without the correlated part the white one has the whole variance. At any time, and after the
/// correlated part is taken up again, the two runs differ by at most two independent correlated parts.
pub(crate) fn noise(sigma_m: f64, share: f64, tau_s: f64) -> [PlannedEffect; 2] {
    let correlated = SIGMAS * sigma_m * (2.0 * share).sqrt();
    let white = SIGMAS * sigma_m * (1.0 - share).sqrt();
    let (share, tau_s) = (100.0 * share, (10.0 * tau_s).round() / 10.0);
    let called = format!("{share:.0} % of the variance over {tau_s} s, σ to {sigma_m:.2} m");
    [
        two(E::Correlation, called, Loss::moves(correlated)),
        two(E::White, format!("σ to {:.2} m", white / SIGMAS), Loss::moves(white)),
    ]
}

pub(crate) fn larger(error: &NorthEast) -> f64 {
    error.sigma_north_m.max(error.sigma_east_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_of_a_noise_is_told_in_the_digits_that_count() {
        let [correlated, white] = noise(2.0, 0.25, 12.34);
        assert_eq!(correlated.ladder.called_for, "25 % of the variance over 12.3 s, σ to 2.00 m");
        assert_eq!(white.ladder.called_for, "σ to 1.73 m");
        // Two independent parts of 1 m apart, and three quarters of the variance.
        let moves = |effect: &PlannedEffect| effect.ladder.rungs[0].loss.fixed_m;
        assert!((moves(&correlated) - SIGMAS * 2.0f64.sqrt()).abs() < 1e-12);
        assert!((moves(&white) - SIGMAS * 3.0f64.sqrt()).abs() < 1e-12);
    }
}
