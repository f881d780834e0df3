//! What people at seats see of a run: a controller what sensors and tracker give, never the truth, and out of the window whom he can see
//! from the tower; who is aboard something, itself and whom he can see from there. All of it is taken out here, so that a page cannot show what it was not sent.
//!
//! Sight: nearer than the range at which 5 % of the contrast is left, `ln 20 / β` with the extinction of the eye's view
//! (`web/eye_light.js`: `β = 2.9957/V + 0.248·10⁻³ R^0.67` per metre), and no building of the scene between the eye and the middle of
//! the other. All around: heads turn.

use super::frame::{self, Entity, Keeps};
use super::picture::Block;
use crate::runtime::messages::{SeatAction, SeatOrder, WeatherNotice};
use models::time::SimTime;
use serde_json::Value;
use std::collections::BTreeSet;
use std::sync::Arc;

/// The seats that a browser sees from: its own, and those that its person has on other pages. Without one it sees everything.
#[derive(Debug, Default)]
pub(super) struct SeatView {
    own: BTreeSet<String>,
    seats: BTreeSet<String>, // its own among them
    window: bool,
}

/// What sight depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Air<'a> {
    /// Notices of the weather in the order of time.
    pub weather: &'a [WeatherNotice],
    /// Buildings.
    pub blocks: &'a [Block],
    /// Where a controller looks out from, m east, north and up.
    pub cab_m: [f64; 3],
}

impl SeatView {
    /// What was done at a seat from here, and accepted; whether something else is seen now.
    pub(super) fn note(&mut self, order: &SeatOrder) -> bool {
        match order.action {
            SeatAction::Take => {
                self.own.insert(order.seat.clone());
                self.seats.insert(order.seat.clone())
            }
            SeatAction::Leave => {
                self.own.remove(&order.seat);
                self.seats.remove(&order.seat)
            }
            _ => false,
        }
    }

    /// The seats that the person of this browser has now, on whatever page; whether something else is seen now.
    pub(super) fn is_of(&mut self, mut seats: BTreeSet<String>) -> bool {
        seats.extend(self.own.iter().cloned());
        let other = self.seats != seats;
        self.seats = seats;
        other
    }

    /// It is a look out of the window, not a position's screen.
    pub(super) fn looks_out(&mut self) {
        self.window = true;
    }

    /// Whether its person sits nowhere.
    pub(super) fn is_free(&self) -> bool {
        self.seats.is_empty()
    }

    /// Whether only movers are sat in.
    pub(super) fn only_aboard(&self) -> bool {
        !self.is_free() && self.seats.iter().all(|seat| aboard_of(seat).is_some())
    }

    /// What is told on a topic, as it is heard at the seats; none where it is not for them.
    pub(super) fn topic(&self, word: &str, told: &Arc<str>) -> Option<Arc<str>> {
        match word {
            _ if self.is_free() => Some(Arc::clone(told)),
            // How well the run is doing is for who judges it.
            "timeline" => {
                let mut line: Value = serde_json::from_str(told).ok()?;
                line["measures"] = Value::Array(Vec::new());
                Some(line.to_string().into())
            }
            "rungs" | "tolerances" => None,
            word if self.only_aboard() && !ABOARD.contains(&word) => None,
            _ => Some(Arc::clone(told)),
        }
    }

    /// For the page: where one sits.
    pub(super) fn seats(&self) -> impl Iterator<Item = &str> {
        self.seats.iter().map(String::as_str)
    }

    /// A scan as it is seen from the seats.
    pub(super) fn frame(&self, message: Vec<u8>, air: Air<'_>) -> Vec<u8> {
        if self.is_free() {
            return message;
        }
        let entities = frame::entities(&message);
        let time = frame::number_and_time(&message).map_or(SimTime(0), |(_, time)| time);
        let weather = air.weather.iter().rfind(|w| w.from_ns <= time.0);
        let mut truth = vec![false; entities.len()];
        let controls = !self.only_aboard();
        let mut look = |eye: [f64; 3]| {
            for (keep, other) in truth.iter_mut().zip(&entities) {
                let to = middle_of(other);
                *keep |= in_sight(eye, to, sight_m(weather, eye, to), air.blocks);
            }
        };
        let aboard = |callsign: &str| entities.iter().position(|e| e.callsign == callsign);
        let own: Vec<usize> =
            self.seats.iter().filter_map(|seat| aboard_of(seat)).filter_map(aboard).collect();
        own.iter().for_each(|at| look(eye_of(&entities[*at])));
        if controls && self.window {
            look(air.cab_m);
        }
        own.iter().for_each(|at| truth[*at] = true);
        // What cannot be read is not sent on.
        frame::reduced(&message, &Keeps { tracks: controls, plots: controls, truth })
            .unwrap_or_default()
    }

    /// What was said of movers (`said`: an object with `movers`, each with its `callsign`) as it is heard aboard: of oneself.
    pub(super) fn movers(&self, said: &str) -> Option<String> {
        if !self.only_aboard() {
            return Some(said.to_owned());
        }
        let mut said: Value = serde_json::from_str(said).ok()?;
        let own: BTreeSet<&str> = self.seats.iter().filter_map(|seat| aboard_of(seat)).collect();
        if let Some(movers) = said.get_mut("movers").and_then(Value::as_array_mut) {
            movers.retain(|m| m["callsign"].as_str().is_some_and(|c| own.contains(c)));
        }
        Some(said.to_string())
    }
}

/// Whom a seat is aboard, by the names that `scenarios::driven` gives seats; none: a controller's.
fn aboard_of(seat: &str) -> Option<&str> {
    seat.strip_prefix("driver ").or_else(|| seat.strip_prefix("pilot "))
}

/// Eye above the middle of a mover, m: of a cockpit by the length, of a car or a lorry.
fn eye_of(own: &Entity) -> [f64; 3] {
    let height_m = match own.aircraft {
        true => (0.13 * own.length_m).clamp(1.5, 7.0),
        false if own.length_m > 6.0 => 2.8,
        false => 1.6,
    };
    let [x, y, up] = own.position_m;
    [x, y, up.max(0.0) + height_m]
}

/// Half as high as it is, as the eye's view takes it.
fn middle_of(other: &Entity) -> [f64; 3] {
    let height_m = if other.aircraft { (0.3 * other.length_m).clamp(1.0, 20.0) } else { 2.0 };
    let [x, y, up] = other.position_m;
    [x, y, up.max(0.0) + 0.5 * height_m]
}

/// How far one sees from `eye` towards a place, m: in the rain halfway there; infinite where the air is clear.
fn sight_m(weather: Option<&WeatherNotice>, eye: [f64; 3], to: [f64; 3]) -> f64 {
    let Some(w) = weather else { return f64::INFINITY };
    let [x, y] = [0, 1].map(|i| 0.5 * (eye[i] + to[i]));
    let over = |c: &&[f64; 4]| libm::hypot(x - c[0], y - c[1]) <= c[2];
    let rain = w.cells.iter().filter(over).map(|c| c[3]).fold(w.rain_mm_per_h, f64::max);
    let fog = if w.visibility_m.is_finite() { FIVE_PERCENT / w.visibility_m.max(1.0) } else { 0.0 };
    FIVE_PERCENT / (fog + 0.248e-3 * libm::pow(rain.max(0.0), 0.67))
}

fn in_sight(eye: [f64; 3], to: [f64; 3], far_m: f64, blocks: &[Block]) -> bool {
    let away = [to[0] - eye[0], to[1] - eye[1], to[2] - eye[2]];
    let distance_m = away.iter().map(|d| d * d).sum::<f64>().sqrt();
    distance_m < far_m && !blocks.iter().any(|block| hides(eye, to, block))
}

/// Whether the line between two points is below the top of a building somewhere over its footprint.
fn hides(from: [f64; 3], to: [f64; 3], block: &Block) -> bool {
    let [dx, dy, dz] = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
    let corners = block.ring.len();
    let cuts = (0..corners).filter_map(|i| {
        let ([ax, ay], [bx, by]) = (block.ring[i], block.ring[(i + 1) % corners]);
        let (ex, ey) = (bx - ax, by - ay);
        let across = dx * ey - dy * ex;
        let t = ((ax - from[0]) * ey - (ay - from[1]) * ex) / across;
        let s = ((ax - from[0]) * dy - (ay - from[1]) * dx) / across;
        (across.abs() > 1e-12 && t > 0.0 && t < 1.0 && (0.0..=1.0).contains(&s)).then_some(t)
    });
    cuts.map(|t| from[2] + t * dz).any(|height_m| height_m < block.height_m)
}

/// Topics that are sent aboard beside the time line, which is without its measures there; no other, whatever comes to be told.
const ABOARD: [&str; 5] = ["scene", "state", "weather", "flights", "federates"];

/// −ln 0.05.
const FIVE_PERCENT: f64 = 2.9957;

#[cfg(test)]
mod tests;
