//! Flights of a demand as they are drawn, and the mix of types that they are drawn from.

use models::traffic::core::Direction;

/// Types with weights.
pub(super) type Mix = Vec<(String, f64)>;

/// The type of a mix at a draw within 0 to 1; `None` of none.
pub(super) fn of_mix(mix: &[(String, f64)], draw: f64) -> Option<&str> {
    let total: f64 = mix.iter().map(|m| m.1).sum();
    let mut left = draw * total;
    let at = mix.iter().find(|m| {
        left -= m.1;
        left <= 0.0
    });
    at.map(|m| m.0.as_str())
}

/// A flight by rates, before it has a stand.
#[derive(Clone)]
pub(super) struct Drawn {
    pub(super) number: u64,
    pub(super) direction: Direction,
    pub(super) time_s: f64,
    pub(super) designator: String,
    pub(super) runway: String,
    /// Draw for its stand.
    pub(super) place: f64,
    /// Of an arrival: from its landing to its earliest off-block, s.
    pub(super) turn_round_s: f64,
    /// Draw for its type where no stand is free for the first one.
    pub(super) other: f64,
}
