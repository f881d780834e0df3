//! Targets as the state vectors of the OpenSky Network's REST interface (`/states/all`): an array a target, without names.
//!
//! Source: OpenSky REST API, "All State Vectors". What is not known is null, as there.

use super::Gateway;
use super::adsb::Addressed;
use crate::runtime::messages::{ScanReport, TruthMessage};
use geodesy::Enu;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// All of them at the end of a scan: `time`, s of UTC, and `states`, each `[icao24, callsign, origin_country, time_position, last_contact,
/// longitude, latitude, baro_altitude, on_ground, velocity, true_track, vertical_rate, sensors, geo_altitude, squawk, spi, position_source,
/// category]`; metres, m/s, degrees.
#[must_use]
pub fn states(gateway: &Gateway, scan: &ScanReport, targets: &[Addressed]) -> Value {
    let time = gateway.utc_ns(scan.time_ns).div_euclid(1_000_000_000);
    let height = |truth: &TruthMessage| {
        let [east_m, north_m, up_m]: [f64; 3] = truth.position_m.into();
        gateway.frame.to_ecef(Enu { east_m, north_m, up_m }).to_geodetic().height_m
    };
    let heights: BTreeMap<_, _> = scan.truth.iter().map(|t| (t.id, height(t))).collect();
    let state = |of: &Addressed| state(of, heights.get(&of.id).copied(), time);
    json!({ "time": time, "states": targets.iter().map(state).collect::<Vec<_>>() })
}

fn state(of: &Addressed, height_m: Option<f64>, time: i64) -> Value {
    let round = |x: f64, scale: f64| libm::round(x * scale) / scale;
    let target = &of.target;
    let [east, north, up] = target.velocity_mps;
    let in_air = |value: f64| (!target.on_ground).then(|| round(value, 100.0));
    json!([
        format!("{:06x}", target.emitter.address),
        format!("{:<8}", super::items::ident(&target.callsign)),
        // Which country an address is of is not known here.
        "",
        time,
        time,
        round(target.lon_deg, 1e6),
        round(target.lat_deg, 1e6),
        in_air(target.pressure_altitude_m),
        target.on_ground,
        round(libm::hypot(east, north), 100.0),
        round(target.track_deg(), 100.0).rem_euclid(360.0),
        in_air(up),
        Value::Null,
        height_m.map(|height_m| round(height_m, 100.0)),
        Value::Null,
        false,
        0, // ADS-B
        category(target.category),
    ])
}

/// The emitter category of a squitter as OpenSky counts: A0 1, A1 2, …, surface emergency vehicle 16, service vehicle 17.
fn category(squitter: u8) -> u8 {
    match (squitter >> 4, squitter & 7) {
        (0xa, n) => n + 1,
        (0xc, 1) => 16,
        (0xc, 2) => 17,
        _ => 0,
    }
}
