//! What people drive, for pages: `obs/driven`, JSON, by the generator of share 1, ten times a second while somebody drives, else once.
//!
//! ```json
//! {"time_s": 61.1,
//!  "movers": [{"callsign": "FOLLOW1", "seat": "driver FOLLOW1", "taken": true, "at_m": [e, n], "heading_rad": 1.2,
//!              "speed_mps": 4.1, "acceleration_mps2": 0.3, "steer_rad": 0.05, "length_m": 4.6, "width_m": 1.9, "aircraft": false,
//!              "wheelbase_m": 2.7, "most_mps": 27.8, "off_pavement": false, "silent": false, "contacts": 0}],
//!  "flights": ["pilot SWR1A"]}
//! ```
//!
//! `movers`: what is there to be driven, and flights that people have (`"flight": true`); `at_m`: the middle, m east and north; `speed_mps` is
//! negative backwards; `silent`: nothing was heard of its driver for a second, so it brakes; `contacts`: whom it touched so far. `flights`, in
//! whole seconds: seats of those that could be taken. A page reckons its own mover on with these until the next one comes.

use models::traffic::core::{AtWheel, Core};
use models::traffic::outline::Size;
use scenarios::driven::{seat_of, seat_of_flight};
use scenarios::schedule::Behaving;
use serde_json::{Value, json};

/// Flights that people have, with how they are.
fn flights(core: &Core) -> impl Iterator<Item = (usize, AtWheel)> {
    (0..core.flights().len()).filter_map(|f| Some((f, core.flight_at_wheel(f)?)))
}

/// Whether somebody drives, or what he left still rolls.
#[must_use]
pub fn moves(core: &Core, behaving: &Behaving) -> bool {
    let used = |hand: AtWheel| hand.taken || hand.speed_mps != 0.0;
    (0..behaving.driven.len()).any(|n| core.at_wheel(n).is_some_and(used))
        || behaving.by_hand && flights(core).next().is_some()
}

/// What is driven: its name, seat and size, wheelbase and largest speed.
struct Of<'a>(&'a str, String, Size, f64, f64);

fn mover(Of(callsign, seat, size, wheelbase_m, most_mps): Of<'_>, h: &AtWheel) -> Value {
    let round = |x: f64| (1e4 * x).round() / 1e4;
    json!({
        "callsign": callsign, "seat": seat, "taken": h.taken,
        "at_m": [round(h.at_m.x), round(h.at_m.y)], "heading_rad": round(h.heading_rad),
        "speed_mps": round(h.speed_mps), "acceleration_mps2": round(h.acceleration_mps2),
        "steer_rad": round(h.steer_rad), "length_m": size.length_m, "width_m": size.span_m,
        "aircraft": size.aircraft, "wheelbase_m": wheelbase_m, "most_mps": most_mps,
        "off_pavement": h.off_pavement, "silent": h.silent, "contacts": h.contacts,
    })
}

/// How driven movers are; `whole`: also which flights could be taken.
#[must_use]
pub fn json(core: &Core, behaving: &Behaving, time_s: f64, whole: bool) -> String {
    let driven = behaving.driven.iter().enumerate().filter_map(|(n, d)| {
        let of = Of(&d.callsign, seat_of(d), d.size, d.wheelbase_m, d.most_mps);
        Some(mover(of, &core.at_wheel(n)?))
    });
    let taken = flights(core).map(|(f, h)| {
        let f = &core.flights()[f];
        let seat = seat_of_flight(&f.callsign);
        let mut told = mover(Of(&f.callsign, seat, f.size, f.wheelbase_m, f.taxi_mps.0), &h);
        told["flight"] = true.into();
        told
    });
    let movers: Vec<Value> = driven.chain(taken).collect();
    let mut all = json!({"time_s": (1e3 * time_s).round() / 1e3, "movers": movers});
    if whole && behaving.by_hand {
        let free = (0..core.flights().len()).filter(|f| core.may_be_taken(*f));
        all["flights"] = free.map(|f| seat_of_flight(&core.flights()[f].callsign)).collect();
    }
    all.to_string()
}
