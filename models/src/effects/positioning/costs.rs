//! What each level of each effect of a sensor costs.
//!
//! `cargo bench -p models --bench positioning_costs` measures it again and says what changed;
//! `… -- --write` writes the table of this file.
//!
//! Each number is the processor time per report that the level adds to a scan in which everything else
//! is left out: the least of many scans with it less the least of as many without, 1000 targets, a
//! report of each in a scan. What is made once for all targets (the sky) is shared among them.

use super::{PositioningEffect, PositioningModel};
use crate::effects::Level;

/// Time of one level of an effect per report, ns; 0 for what is skipped.
#[must_use]
pub fn of(model: PositioningModel, effect: PositioningEffect, level: Level) -> f64 {
    let here = |row: &&(PositioningModel, PositioningEffect, Level, u32)| {
        (row.0, row.1, row.2) == (model, effect, level)
    };
    COSTS_NS.iter().find(here).map_or(0.0, |row| f64::from(row.3))
}

// Written by the bench `positioning_costs`.

/// When and on what the table was measured.
pub const MEASURED: &str = "2026-11-21, one core of a shared x86-64 server, release build";

/// Model, effect, level, ns.
#[rustfmt::skip]
pub const COSTS_NS: &[(PositioningModel, PositioningEffect, Level, u32)] = &[
    (PositioningModel::GpsStatistical, PositioningEffect::Geometry, Level::Cheap, 0),
    (PositioningModel::GpsStatistical, PositioningEffect::HardFailures, Level::Exact, 11),
    (PositioningModel::GpsStatistical, PositioningEffect::SoftFailures, Level::Exact, 7),
    (PositioningModel::GpsStatistical, PositioningEffect::Correlation, Level::Exact, 137),
    (PositioningModel::GpsStatistical, PositioningEffect::White, Level::Exact, 130),
    (PositioningModel::GpsConstellation, PositioningEffect::Geometry, Level::Middle, 16),
    (PositioningModel::GpsConstellation, PositioningEffect::HardFailures, Level::Exact, 0),
    (PositioningModel::GpsConstellation, PositioningEffect::SoftFailures, Level::Exact, 0),
    (PositioningModel::GpsConstellation, PositioningEffect::Correlation, Level::Exact, 124),
    (PositioningModel::GpsConstellation, PositioningEffect::White, Level::Exact, 116),
    (PositioningModel::GpsPerSatellite, PositioningEffect::Geometry, Level::Exact, 92),
    (PositioningModel::GpsPerSatellite, PositioningEffect::HardFailures, Level::Exact, 0),
    (PositioningModel::GpsPerSatellite, PositioningEffect::SoftFailures, Level::Exact, 0),
    (PositioningModel::GpsPerSatellite, PositioningEffect::RangeErrors, Level::Exact, 2),
    (PositioningModel::GpsPerSatellite, PositioningEffect::Multipath, Level::Exact, 456),
    (PositioningModel::GpsPerSatellite, PositioningEffect::White, Level::Exact, 398),
    (PositioningModel::DgpsBudget, PositioningEffect::Geometry, Level::Cheap, 0),
    (PositioningModel::DgpsBudget, PositioningEffect::HardFailures, Level::Exact, 11),
    (PositioningModel::DgpsBudget, PositioningEffect::SoftFailures, Level::Exact, 7),
    (PositioningModel::DgpsBudget, PositioningEffect::ReferenceOutage, Level::Exact, 6),
    (PositioningModel::DgpsBudget, PositioningEffect::CorrectionDistance, Level::Exact, 16),
    (PositioningModel::DgpsBudget, PositioningEffect::CorrectionAge, Level::Exact, 10),
    (PositioningModel::DgpsBudget, PositioningEffect::Correlation, Level::Exact, 132),
    (PositioningModel::DgpsBudget, PositioningEffect::White, Level::Exact, 126),
    (PositioningModel::DgpsPerSatellite, PositioningEffect::Geometry, Level::Exact, 135),
    (PositioningModel::DgpsPerSatellite, PositioningEffect::HardFailures, Level::Exact, 0),
    (PositioningModel::DgpsPerSatellite, PositioningEffect::SoftFailures, Level::Exact, 0),
    (PositioningModel::DgpsPerSatellite, PositioningEffect::ReferenceOutage, Level::Exact, 0),
    (PositioningModel::DgpsPerSatellite, PositioningEffect::CorrectionDistance, Level::Exact, 6),
    (PositioningModel::DgpsPerSatellite, PositioningEffect::CorrectionAge, Level::Exact, 23),
    (PositioningModel::DgpsPerSatellite, PositioningEffect::ReferenceErrors, Level::Exact, 4),
    (PositioningModel::DgpsPerSatellite, PositioningEffect::Multipath, Level::Exact, 467),
    (PositioningModel::DgpsPerSatellite, PositioningEffect::White, Level::Exact, 415),
    (PositioningModel::Adsb, PositioningEffect::Geometry, Level::Cheap, 0),
    (PositioningModel::Adsb, PositioningEffect::Reception, Level::Exact, 61),
    (PositioningModel::Adsb, PositioningEffect::Latency, Level::Cheap, 0),
    (PositioningModel::Adsb, PositioningEffect::Latency, Level::Exact, 0),
    (PositioningModel::Adsb, PositioningEffect::Rounding, Level::Exact, 13),
    (PositioningModel::Adsb, PositioningEffect::Correlation, Level::Exact, 126),
    (PositioningModel::Adsb, PositioningEffect::White, Level::Exact, 121),
    (PositioningModel::Mlat, PositioningEffect::Geometry, Level::Exact, 369),
    (PositioningModel::Mlat, PositioningEffect::Reception, Level::Exact, 0),
    (PositioningModel::Mlat, PositioningEffect::StationRange, Level::Exact, 7),
    (PositioningModel::Mlat, PositioningEffect::Sight, Level::Exact, 836),
    (PositioningModel::Mlat, PositioningEffect::Timing, Level::Exact, 177),
    (PositioningModel::Mlat, PositioningEffect::Multipath, Level::Exact, 5),
    (PositioningModel::Loop, PositioningEffect::Reception, Level::Exact, 21),
    (PositioningModel::Loop, PositioningEffect::Delay, Level::Exact, 89),
    (PositioningModel::Loop, PositioningEffect::Edge, Level::Exact, 56),
    (PositioningModel::Loop, PositioningEffect::Spacing, Level::Exact, 61),
    (PositioningModel::Loop, PositioningEffect::FalsePassages, Level::Exact, 0),
    (PositioningModel::Dynamic, PositioningEffect::Scale, Level::Exact, 1),
    (PositioningModel::Dynamic, PositioningEffect::Heading, Level::Exact, 124),
    (PositioningModel::Dynamic, PositioningEffect::Start, Level::Exact, 0),
    (PositioningModel::Dynamic, PositioningEffect::White, Level::Exact, 123),
    (PositioningModel::Offline, PositioningEffect::Geometry, Level::Cheap, 0),
    (PositioningModel::Offline, PositioningEffect::HardFailures, Level::Exact, 75),
    (PositioningModel::Offline, PositioningEffect::Correlation, Level::Exact, 135),
    (PositioningModel::Offline, PositioningEffect::White, Level::Exact, 129),
];
