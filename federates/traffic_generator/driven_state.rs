//! What people drive, for pages: `obs/driven`, JSON, by the generator of share 1.
//!
//! ```json
//! {"time_s": 61.1,
//!  "movers": [{"callsign": "FOLLOW1", "seat": "driver FOLLOW1", "taken": true, "at_m": [e, n], "heading_rad": 1.2,
//!              "speed_mps": 4.1, "acceleration_mps2": 0.3, "steer_rad": 0.05, "length_m": 4.6, "width_m": 1.9, "aircraft": false,
//!              "wheelbase_m": 2.7, "off_pavement": false, "silent": false, "contacts": 0}]}
//! ```
//!
//! `at_m`: the middle, m east and north; `speed_mps` is negative backwards; `silent`: nothing was heard of its driver for a second, so it
//! brakes; `contacts`: whom it touched so far. A page reckons its own mover on with these until the next one comes.

use models::traffic::core::{AtWheel, Driven};
use scenarios::driven::seat_of;
use serde_json::{Value, json};

/// How driven movers are.
#[must_use]
pub fn json(driven: &[Driven], now: &[AtWheel], time_s: f64) -> String {
    let round = |x: f64| (1e4 * x).round() / 1e4;
    let mover = |(d, h): (&Driven, &AtWheel)| {
        json!({
            "callsign": d.callsign, "seat": seat_of(d), "taken": h.taken,
            "at_m": [round(h.at_m.x), round(h.at_m.y)], "heading_rad": round(h.heading_rad),
            "speed_mps": round(h.speed_mps), "acceleration_mps2": round(h.acceleration_mps2),
            "steer_rad": round(h.steer_rad), "length_m": d.size.length_m, "width_m": d.size.span_m,
            "aircraft": d.size.aircraft, "wheelbase_m": d.wheelbase_m, "most_mps": d.most_mps,
            "off_pavement": h.off_pavement, "silent": h.silent, "contacts": h.contacts,
        })
    };
    let movers: Vec<Value> = driven.iter().zip(now).map(mover).collect();
    json!({"time_s": round(time_s), "movers": movers}).to_string()
}
