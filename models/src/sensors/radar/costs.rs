//! What each level of each effect costs.
//!
//! `cargo bench -p models --bench costs` measures it again and says what changed;
//! `cargo bench -p models --bench costs -- --write` writes the table of this file.
//!
//! Each number is the processor time per target and scan that the level adds to a scan in which only
//! what it needs is simulated: the least of many scans with it less the least of as many without, on a
//! standard scene of 2000 targets (half aircraft, half vehicles) 300 to 3000 m from a Ku band radar
//! among ten low metal buildings, in rain of 4 mm/h with three heavier cells on a wet surface. What
//! depends on pairs (shadows, ghosts, merging) depends on how dense the scene is; the whole video costs
//! the same for any number of targets.

use crate::effects::Level;
use crate::sensors::radar::effects::RadarEffect;

/// Time of one level of an effect per target and scan, ns; 0 for what is skipped. Effects that are values say it themselves.
#[must_use]
pub fn of(effect: RadarEffect, level: Level) -> f64 {
    if let Some(value) = effect.value() {
        return value.cost_ns(level);
    }
    let here = |row: &&(RadarEffect, Level, u32)| row.0 == effect && row.1 == level;
    COSTS_NS.iter().find(here).map_or(0.0, |row| f64::from(row.2))
}

/// Rain attenuation of a level in rain without cells: a product, not a walk through cells. Measured as the table.
pub const RAIN_WITHOUT_CELLS_NS: f64 = 3.0;

/// The same in weather with or without rain cells.
#[must_use]
pub fn of_weather(effect: RadarEffect, level: Level, cells: bool) -> f64 {
    match of(effect, level) {
        dear if effect == RadarEffect::RainAttenuation && !cells => dear.min(RAIN_WITHOUT_CELLS_NS),
        ns => ns,
    }
}

// Written by the bench `costs`.

/// When and on what the table was measured.
pub const MEASURED: &str = "2026-11-21, one core of a shared x86-64 server, release build";

/// Effect, level, ns.
#[rustfmt::skip]
pub const COSTS_NS: &[(RadarEffect, Level, u32)] = &[
    (RadarEffect::RainAttenuation, Level::Cheap, 14),
    (RadarEffect::RainAttenuation, Level::Middle, 85),
    (RadarEffect::RainAttenuation, Level::Exact, 91),
    (RadarEffect::RainClutter, Level::Cheap, 13),
    (RadarEffect::RainClutter, Level::Middle, 43),
    (RadarEffect::RainClutter, Level::Exact, 23),
    (RadarEffect::GroundClutter, Level::Exact, 12),
    (RadarEffect::SurfaceReflection, Level::Exact, 46),
    (RadarEffect::Lobing, Level::Exact, 36),
    (RadarEffect::Roughness, Level::Cheap, 13),
    (RadarEffect::Roughness, Level::Exact, 16),
    (RadarEffect::WaterFilm, Level::Exact, 63),
    (RadarEffect::ReflectedPolarisation, Level::Cheap, 1),
    (RadarEffect::ReflectedPolarisation, Level::Exact, 7),
    (RadarEffect::RoundEarth, Level::Exact, 84),
    (RadarEffect::Detection, Level::Cheap, 101),
    (RadarEffect::Detection, Level::Middle, 20),
    (RadarEffect::Detection, Level::Exact, 1054),
    (RadarEffect::Extent, Level::Middle, 22),
    (RadarEffect::Extent, Level::Exact, 177),
    (RadarEffect::Glint, Level::Exact, 47),
    (RadarEffect::ThermalRange, Level::Exact, 5),
    (RadarEffect::ThermalAzimuth, Level::Exact, 7),
    (RadarEffect::Quantisation, Level::Exact, 13),
    (RadarEffect::FalseAlarms, Level::Exact, 1),
    (RadarEffect::BuildingShadow, Level::Cheap, 26),
    (RadarEffect::BuildingShadow, Level::Exact, 24),
    (RadarEffect::AircraftShadow, Level::Cheap, 106),
    (RadarEffect::AircraftShadow, Level::Exact, 111),
    (RadarEffect::Ghosts, Level::Exact, 240),
    (RadarEffect::Merging, Level::Exact, 41),
    (RadarEffect::SecondTrace, Level::Exact, 0),
    (RadarEffect::Processing, Level::Cheap, 0),
    (RadarEffect::Processing, Level::Middle, 12523),
    (RadarEffect::Processing, Level::Exact, 340837),
];
