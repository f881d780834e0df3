//! What each level of each effect costs.
//!
//! `cargo bench -p models --bench costs` measures it again and says what changed;
//! `cargo bench -p models --bench costs -- --write` writes the table of this file.
//!
//! Each number is the processor time per target and scan that the level adds to a scan in which only
//! what it needs is simulated: the least of many scans with it less the least of as many without, on a
//! standard scene of 2000 targets (half aircraft, half vehicles) 300 to 3000 m from a Ku band radar
//! among ten low metal buildings, in rain of 4 mm/h with three heavier cells on a wet surface. What
//! depends on pairs (shadows, ghosts, merging) depends on how dense the scene is.

use super::Level;
use super::radar::RadarEffect;

/// Time of one level of an effect per target and scan, ns; 0 for what is skipped.
#[must_use]
pub fn of(effect: RadarEffect, level: Level) -> f64 {
    let here = |row: &&(RadarEffect, Level, u32)| row.0 == effect && row.1 == level;
    COSTS_NS.iter().find(here).map_or(0.0, |row| f64::from(row.2))
}

// Written by the bench `costs`.

/// When and on what the table was measured.
pub const MEASURED: &str = "2026-11-21, one core of a shared x86-64 server, release build";

/// Effect, level, ns.
#[rustfmt::skip]
pub const COSTS_NS: &[(RadarEffect, Level, u32)] = &[
    (RadarEffect::RainAttenuation, Level::Cheap, 12),
    (RadarEffect::RainAttenuation, Level::Middle, 97),
    (RadarEffect::RainAttenuation, Level::Exact, 87),
    (RadarEffect::Fog, Level::Exact, 1),
    (RadarEffect::Gases, Level::Cheap, 7),
    (RadarEffect::Gases, Level::Exact, 6),
    (RadarEffect::RainClutter, Level::Cheap, 10),
    (RadarEffect::RainClutter, Level::Middle, 41),
    (RadarEffect::RainClutter, Level::Exact, 20),
    (RadarEffect::GroundClutter, Level::Exact, 8),
    (RadarEffect::SurfaceReflection, Level::Exact, 46),
    (RadarEffect::Lobing, Level::Exact, 29),
    (RadarEffect::Roughness, Level::Cheap, 13),
    (RadarEffect::Roughness, Level::Exact, 14),
    (RadarEffect::WaterFilm, Level::Exact, 65),
    (RadarEffect::ReflectedPolarisation, Level::Cheap, 3),
    (RadarEffect::ReflectedPolarisation, Level::Exact, 7),
    (RadarEffect::RoundEarth, Level::Exact, 97),
    (RadarEffect::Detection, Level::Cheap, 96),
    (RadarEffect::Detection, Level::Middle, 22),
    (RadarEffect::Detection, Level::Exact, 0),
    (RadarEffect::Extent, Level::Exact, 176),
    (RadarEffect::Glint, Level::Exact, 54),
    (RadarEffect::ThermalRange, Level::Exact, 0),
    (RadarEffect::ThermalAzimuth, Level::Exact, 0),
    (RadarEffect::Quantisation, Level::Exact, 17),
    (RadarEffect::FalseAlarms, Level::Exact, 4),
    (RadarEffect::BuildingShadow, Level::Cheap, 30),
    (RadarEffect::BuildingShadow, Level::Exact, 35),
    (RadarEffect::AircraftShadow, Level::Cheap, 84),
    (RadarEffect::AircraftShadow, Level::Exact, 103),
    (RadarEffect::Ghosts, Level::Exact, 247),
    (RadarEffect::Merging, Level::Exact, 41),
    (RadarEffect::SecondTrace, Level::Exact, 1),
];
