//! What leaving out an effect of a sensor can change at most, from its parameters alone.
//!
//! A two-dimensional normal error exceeds [`SIGMAS`] of its larger deviation once in 3.7 million draws,
//! `exp(−5.5²/2)`. What is rare counts with the probability that it happens to a target within the run.

use super::{
    Ladders, PlannedEffect, PositioningEffect as E, PositioningModel, PositioningScene, rung,
};
use crate::effects::{Ladder, Level, Loss, Tolerance};
use crate::sensors::adsb::AdsbConfig;
use crate::sensors::constellation::{SatelliteFailures, SkyConfig};
use crate::sensors::dgps::{Budgeted, DgpsConfig, ReferenceLoss};
use crate::sensors::dynamic::DynamicConfig;
use crate::sensors::gps::{Diluted, NorthEast, SoftFailure, Statistical};
use crate::sensors::induction_loop::LoopConfig;
use crate::sensors::mlat::MlatConfig;
use crate::sensors::offline::OfflineConfig;
use crate::sensors::ranging::{
    RangeBudget, RangeCorrections, RangingConfig, multipath_growth, obliquity, tropospheric_mapping,
};
use crate::sensors::service::{Alternating, Service};

/// Deviations that a drawn error may reach.
pub const SIGMAS: f64 = 5.5;

/// Horizontal deviations move by so much of their root mean square over a day where the geometry is
/// taken as constant: −29 to +90 % at five places with the reference constellation.
const GEOMETRY_SHARE: f64 = 0.9;

/// Probability that a process is or goes down within `horizon_s`: (1 − A) − A expm1(−T/U).
#[must_use]
pub fn outage_probability(process: &Alternating, horizon_s: f64) -> f64 {
    if process.mean_up_s == f64::INFINITY {
        return 0.0;
    }
    process.down_share() - process.up_share() * libm::expm1(-horizon_s / process.mean_up_s)
}

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

fn planned(effect: E, called_for: String, rungs: Vec<super::Rung>) -> PlannedEffect {
    PlannedEffect {
        effect,
        ladder: Ladder { effect: effect.name(), called_for, rungs },
        given: false,
    }
}

/// Left out or simulated.
fn two(effect: E, called_for: String, loss: Loss) -> PlannedEffect {
    let rungs = vec![rung(Level::Skipped, loss), rung(Level::Exact, Loss::NONE)];
    planned(effect, called_for, rungs)
}

/// A level that the scene gives; `moves_m` is what it may lose against the most exact one.
fn given(effect: E, level: Level, called_for: String, moves_m: f64) -> PlannedEffect {
    let rungs = vec![rung(level, Loss::moves(moves_m))];
    PlannedEffect { given: true, ..planned(effect, called_for, rungs) }
}

/// Something that happens with a probability and then moves a report: bounded by whichever takes less
/// of the tolerance.
fn rarely(probability: f64, metres: f64, tolerance: &Tolerance) -> Loss {
    if probability == 0.0 || metres == 0.0 {
        return Loss::NONE;
    }
    let by_metres = metres / tolerance.position_m < probability / tolerance.detection;
    if by_metres { Loss::moves(metres) } else { Loss::odds(probability) }
}

fn duration(horizon_s: f64) -> String {
    if horizon_s.is_finite() { format!("{horizon_s:.0} s") } else { "a run of any length".into() }
}

fn percent(share: f64) -> String {
    format!("{} %", (1e6 * share).round() / 1e4)
}

/// Coverage and availability.
fn services(service: &Service, horizon_s: f64) -> PlannedEffect {
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

fn unreliable(service: &Service, soft: &SoftFailure, scene: &PositioningScene) -> PlannedEffect {
    let p = outage_probability(&service.reliability, scene.horizon_s).min(1.0);
    let share = percent(service.reliability.up_share());
    let called = format!("reliability {share}, shifts to {} m", soft.limit_m);
    two(E::SoftFailures, called, rarely(p, soft.limit_m, &scene.tolerance))
}

/// The correlated and the white part of an error of deviation `sigma_m` along its larger axis.
///
/// Without the correlated part the white one has the whole variance. At any time, and after the
/// correlated part is taken up again, the two runs differ by at most two independent correlated parts.
fn noise(sigma_m: f64, share: f64, tau_s: f64) -> [PlannedEffect; 2] {
    let correlated = SIGMAS * sigma_m * (2.0 * share).sqrt();
    let white = SIGMAS * sigma_m * (1.0 - share).sqrt();
    let (share, tau_s) = (100.0 * share, (10.0 * tau_s).round() / 10.0);
    let called = format!("{share:.0} % of the variance over {tau_s} s, σ to {sigma_m:.2} m");
    [
        two(E::Correlation, called, Loss::moves(correlated)),
        two(E::White, format!("σ to {:.2} m", white / SIGMAS), Loss::moves(white)),
    ]
}

fn larger(error: &NorthEast) -> f64 {
    error.sigma_north_m.max(error.sigma_east_m)
}

/// Satellite positioning by statistics.
#[must_use]
pub fn gps_statistical(model: &Statistical, scene: &PositioningScene) -> Ladders {
    let sigma_m = larger(&model.error);
    let called = "statistics of the scene, fixed by it (level statistical)".into();
    let geometry = given(E::Geometry, Level::Cheap, called, SIGMAS * GEOMETRY_SHARE * sigma_m);
    let [correlated, white] = noise(sigma_m, model.error.correlated_share, model.error.tau_s);
    Ladders {
        model: PositioningModel::GpsStatistical,
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
        model: PositioningModel::GpsConstellation,
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

/// Largest deviation of a fix range by range, m.
#[must_use]
pub fn ranging_sigma_m(ranging: &RangingConfig, scene: &PositioningScene) -> f64 {
    let mask_rad = ranging.sky.mask_deg.to_radians();
    dilution(ranging, scene) * ranging.budget.variance_m2(mask_rad).sqrt()
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
        model: PositioningModel::GpsPerSatellite,
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
        model: PositioningModel::DgpsBudget,
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
        model: PositioningModel::DgpsPerSatellite,
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

/// Position broadcasts with position deviation `sigma_m`, rounded to steps of up to `step_m` (the
/// diagonal of a step east and north).
#[must_use]
pub fn adsb(config: &AdsbConfig, sigma_m: f64, step_m: f64, scene: &PositioningScene) -> Ladders {
    let speed_mps = scene.conditions.speed_mps;
    let (least_s, most_s) = (config.latency_min_s, config.latency_max_s);
    let latency = planned(
        E::Latency,
        format!("{least_s} to {most_s} s at up to {speed_mps} m/s"),
        vec![
            rung(Level::Skipped, Loss::moves(speed_mps * most_s)),
            rung(Level::Cheap, Loss::moves(0.5 * speed_mps * (most_s - least_s))),
            rung(Level::Exact, Loss::NONE),
        ],
    );
    let [correlated, white] = noise(sigma_m, config.correlated_share, config.tau_s);
    let called = format!("accuracy category {}, fixed by the scene", config.nacp);
    Ladders {
        model: PositioningModel::Adsb,
        effects: vec![
            given(E::Geometry, Level::Cheap, called, SIGMAS * GEOMETRY_SHARE * sigma_m),
            two(
                E::Reception,
                format!("{} received", percent(config.reception)),
                Loss::odds(1.0 - config.reception),
            ),
            latency,
            two(E::Rounding, format!("steps of {step_m:.2} m"), Loss::moves(0.5 * step_m)),
            correlated,
            white,
        ],
        step_m,
    }
}

/// Multilateration; distances are from the middle of the stations.
#[must_use]
pub fn mlat(config: &MlatConfig, scene: &PositioningScene) -> Ladders {
    let stations = config.stations.len();
    let any_of = |p: f64| -libm::expm1(stations as f64 * libm::log1p(-p.min(1.0 - 1e-16)));
    let middle_m = config.middle_m();
    let far_m = scene.conditions.distance_m;
    let short = config
        .stations
        .iter()
        .filter(|s| !s.blind.is_empty() || (s.position_m - middle_m).norm() + far_m > s.range_m);
    let short = short.count();
    let sigma_m = crate::environment::SPEED_OF_LIGHT * config.sigma_t_s;
    let certain = |n: usize| Loss::odds(if n > 0 { 1.0 } else { 0.0 });
    let late = if config.multipath_m > 0.0 { any_of(config.multipath) } else { 0.0 };
    Ladders {
        model: PositioningModel::Mlat,
        effects: vec![
            given(
                E::Geometry,
                Level::Exact,
                format!("{stations} stations, dilution to {}", config.max_dilution),
                0.0,
            ),
            two(
                E::Reception,
                format!("{} decoded by each station", percent(config.reception)),
                Loss::odds(any_of(1.0 - config.reception)),
            ),
            two(
                E::StationRange,
                format!("{short} stations that may not hear all, targets to {far_m} m"),
                certain(short),
            ),
            two(
                E::Sight,
                format!("{} buildings", config.buildings.len()),
                certain(config.buildings.len()),
            ),
            two(
                E::Timing,
                format!("σ {sigma_m:.2} m per arrival"),
                Loss::moves(SIGMAS * sigma_m * config.max_dilution),
            ),
            two(
                E::Multipath,
                format!(
                    "{} late by {} m on average",
                    percent(config.multipath),
                    config.multipath_m
                ),
                Loss::odds(late),
            ),
        ],
        step_m: 0.0,
    }
}

/// Loops in the pavement.
#[must_use]
pub fn induction_loop(config: &LoopConfig, scene: &PositioningScene) -> Ladders {
    let speed_mps = scene.conditions.speed_mps;
    // A pair's centre goes with the quotient of two times; a target may stop over it.
    let unless = |zero: bool| Loss::moves(if zero { 0.0 } else { f64::INFINITY });
    let delay = match config.pair {
        None => Loss::moves(speed_mps * config.delay_s),
        Some(_) => unless(config.delay_s == 0.0),
    };
    let mut effects = vec![
        two(
            E::Reception,
            format!("{} of passages detected", percent(config.pd)),
            Loss::odds(1.0 - config.pd),
        ),
        two(E::Delay, format!("up to {} s at up to {speed_mps} m/s", config.delay_s), delay),
        two(
            E::Edge,
            format!("σ {} m", config.sigma_edge_m),
            Loss::moves(SIGMAS * config.sigma_edge_m),
        ),
    ];
    if let Some(pair) = &config.pair {
        let called = format!("σ {} m of {} m", pair.sigma_spacing_m, pair.spacing_m);
        effects.push(two(E::Spacing, called, unless(pair.sigma_spacing_m == 0.0)));
    }
    let mean =
        if config.false_per_h > 0.0 { config.false_per_h * scene.horizon_s / 3600.0 } else { 0.0 };
    effects.push(two(
        E::FalsePassages,
        format!("{} in an hour, {}", config.false_per_h, duration(scene.horizon_s)),
        Loss::odds(-libm::expm1(-mean)),
    ));
    Ladders { model: PositioningModel::Loop, effects, step_m: 0.0 }
}

/// On-board dead reckoning.
#[must_use]
pub fn dynamic(config: &DynamicConfig, scene: &PositioningScene) -> Ladders {
    let (speed_mps, horizon_s) = (scene.conditions.speed_mps, scene.horizon_s);
    let way_m = if speed_mps > 0.0 { speed_mps * horizon_s } else { 0.0 };
    let of = |sigma: f64| if sigma > 0.0 && way_m > 0.0 { SIGMAS * sigma * way_m } else { 0.0 };
    let walk_rad = config.heading_walk_deg_per_sqrt_h.to_radians() * (horizon_s / 3600.0).sqrt();
    let heading = of(config.sigma_heading_deg.to_radians()) + of(walk_rad);
    let called = if way_m > 0.0 { format!("ways to {way_m} m") } else { "nobody moves".into() };
    Ladders {
        model: PositioningModel::Dynamic,
        effects: vec![
            two(
                E::Scale,
                format!("{} of the way, {called}", percent(config.sigma_scale)),
                Loss::moves(of(config.sigma_scale)),
            ),
            two(
                E::Heading,
                format!(
                    "{}° and {}°/√h, {called}",
                    config.sigma_heading_deg, config.heading_walk_deg_per_sqrt_h
                ),
                Loss::moves(heading),
            ),
            two(
                E::Start,
                format!(
                    "σ {} m at the start, {} known places",
                    config.sigma_start_m,
                    config.resets_m.len()
                ),
                Loss::moves(std::f64::consts::SQRT_2 * SIGMAS * config.sigma_start_m),
            ),
            two(
                E::White,
                format!("σ {} m", config.sigma_white_m),
                Loss::moves(SIGMAS * config.sigma_white_m),
            ),
        ],
        step_m: 0.0,
    }
}

/// Fitted figures.
#[must_use]
pub fn offline(config: &OfflineConfig) -> Ladders {
    let f = &config.figures;
    let sigma_m = f.axes[0].sigma_m.max(f.axes[1].sigma_m);
    let [correlated, white] = noise(sigma_m, f.correlated_share, f.tau_s);
    let called = format!("figures of {} reports, fixed by the scene", f.samples);
    Ladders {
        model: PositioningModel::Offline,
        effects: vec![
            given(E::Geometry, Level::Cheap, called, SIGMAS * GEOMETRY_SHARE * sigma_m),
            two(
                E::HardFailures,
                format!("{} of reports come", percent(f.pd)),
                Loss::odds(1.0 - f.pd),
            ),
            correlated,
            white,
        ],
        step_m: 0.0,
    }
}
