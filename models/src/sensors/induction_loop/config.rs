//! What a loop, or a pair of them, is: its parameters, the keys of a scene that give them, and the formulas of a passage.

use crate::frames::Point2;
use crate::keys::Key;
use crate::plot::SensorId;
use crate::sensors::config::{ConfigError, check, number};
use crate::sensors::declared::Given;

/// Two loops in a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopPair {
    /// Distance from the first to the second, m.
    pub spacing_m: f64,
    /// Its uncertainty, m.
    pub sigma_spacing_m: f64,
}

impl LoopPair {
    /// Time from the first loop to the second at `speed_mps`, s.
    #[must_use]
    pub fn passage_s(&self, speed_mps: f64) -> f64 {
        self.spacing_m / speed_mps
    }

    /// Deviation of the speed v = s/Δt: v √((σ_s/s)² + 2(σ_t v/s)²), m/s.
    #[must_use]
    pub fn sigma_speed_mps(&self, speed_mps: f64, sigma_t_s: f64) -> f64 {
        let place = self.sigma_spacing_m / self.spacing_m;
        let time = sigma_t_s * speed_mps / self.spacing_m;
        speed_mps * (place * place + 2.0 * time * time).sqrt()
    }
}

/// How long a target occupies a loop, s: (L_target + L_loop)/v.
#[must_use]
pub fn occupancy_s(target_m: f64, loop_m: f64, speed_mps: f64) -> f64 {
    (target_m + loop_m) / speed_mps
}

/// Deviation of the position of a passage: √(σ_edge² + (v σ_t)²), m.
#[must_use]
pub fn sigma_passage_m(sigma_edge_m: f64, speed_mps: f64, sigma_t_s: f64) -> f64 {
    libm::hypot(sigma_edge_m, speed_mps * sigma_t_s)
}

/// Parameters of an [`InductionLoop`](super::InductionLoop).
#[derive(Clone, Debug, PartialEq)]
pub struct LoopConfig {
    /// Number of the sensor in the scene.
    pub id: SensorId,
    /// Centre of the (first) loop, airport frame, m.
    pub site_m: Point2<f64>,
    /// Direction of the taxiway, degrees clockwise from north; traffic may come from both sides.
    pub direction_deg: f64,
    /// Length of a loop along the taxiway, m.
    pub length_m: f64,
    /// Half the width of the strip it covers, m.
    pub half_width_m: f64,
    /// The second loop, where there is one: further along `direction_deg`.
    pub pair: Option<LoopPair>,
    /// Uncertainty of the edge of a target over a loop, m.
    pub sigma_edge_m: f64,
    /// Longest delay of a detection, s; each is uniform up to it.
    pub delay_s: f64,
    /// Probability that a passage is detected.
    pub pd: f64,
    /// False passages per hour.
    pub false_per_h: f64,
    /// Half the length that a single loop assumes of a target, m.
    pub assumed_half_length_m: f64,
    /// Uncertainty of that, m.
    pub sigma_half_length_m: f64,
    /// Speed that a single loop assumes of a target in its variance, m/s.
    pub assumed_speed_mps: f64,
}

impl LoopConfig {
    /// Two loops of 2 m, 5 m apart, across a taxiway 23 m wide.
    #[must_use]
    pub fn pair_at(id: SensorId, site_m: Point2<f64>, direction_deg: f64) -> Self {
        Self {
            id,
            site_m,
            direction_deg,
            length_m: 2.0,
            half_width_m: 11.5,
            pair: Some(LoopPair { spacing_m: 5.0, sigma_spacing_m: 0.02 }),
            sigma_edge_m: 0.3,
            delay_s: 0.05,
            pd: 0.99,
            false_per_h: 1e-3,
            assumed_half_length_m: 15.0,
            sigma_half_length_m: 10.0,
            assumed_speed_mps: 10.0,
        }
    }

    /// Refuses what is outside the limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        number("site_east_m", self.site_m.x, -1e6, 1e6)?;
        number("site_north_m", self.site_m.y, -1e6, 1e6)?;
        check(KEYS, "direction_deg", self.direction_deg)?;
        check(KEYS, "length_m", self.length_m)?;
        check(KEYS, "half_width_m", self.half_width_m)?;
        if let Some(pair) = &self.pair {
            check(KEYS, "spacing_m", pair.spacing_m)?;
            check(KEYS, "sigma_spacing_m", pair.sigma_spacing_m)?;
        }
        check(KEYS, "sigma_edge_m", self.sigma_edge_m)?;
        check(KEYS, "delay_s", self.delay_s)?;
        check(KEYS, "pd", self.pd)?;
        check(KEYS, "false_per_h", self.false_per_h)?;
        check(KEYS, "assumed_half_length_m", self.assumed_half_length_m)?;
        check(KEYS, "sigma_half_length_m", self.sigma_half_length_m)?;
        check(KEYS, "assumed_speed_mps", self.assumed_speed_mps)
    }

    /// Deviation of a uniform delay, s.
    #[must_use]
    pub fn sigma_t_s(&self) -> f64 {
        self.delay_s / 12_f64.sqrt()
    }
}

impl LoopConfig {
    pub(super) fn read(given: &Given<'_>) -> Result<Self, ConfigError> {
        let mut pair = Self::pair_at(given.id, given.place_m(), 0.0);
        if given.preset == "single" {
            pair.pair = None;
        }
        let needed = "the direction of the taxiway, degrees clockwise from north";
        pair.direction_deg = given.need_number("direction_deg", needed)?;
        given.number("length_m", &mut pair.length_m);
        given.number("half_width_m", &mut pair.half_width_m);
        if let Some(loops) = &mut pair.pair {
            given.number("spacing_m", &mut loops.spacing_m);
            given.number("sigma_spacing_m", &mut loops.sigma_spacing_m);
        }
        given.number("sigma_edge_m", &mut pair.sigma_edge_m);
        given.number("delay_s", &mut pair.delay_s);
        given.number("pd", &mut pair.pd);
        given.number("false_per_h", &mut pair.false_per_h);
        given.number("assumed_half_length_m", &mut pair.assumed_half_length_m);
        given.number("sigma_half_length_m", &mut pair.sigma_half_length_m);
        given.number("assumed_speed_mps", &mut pair.assumed_speed_mps);
        Ok(pair)
    }
}

pub(super) const KEYS: &[Key] = &[
    Key::number(
        "direction_deg",
        "°",
        -360.0,
        360.0,
        "Direction of the taxiway, clockwise from north; traffic may come from both sides",
    )
    .needed(),
    Key::number("length_m", "m", 0.1, 100.0, "Length of a loop along the taxiway"),
    Key::number("half_width_m", "m", 0.1, 100.0, "Half the width of the strip that it covers"),
    Key::number("spacing_m", "m", 0.5, 100.0, "Distance between the two loops of a pair"),
    Key::number("sigma_spacing_m", "m", 0.0, 1.0, "Uncertainty of that distance"),
    Key::number(
        "sigma_edge_m",
        "m",
        1e-3,
        100.0,
        "Uncertainty of the edge of a target over a loop",
    ),
    Key::number(
        "delay_s",
        "s",
        0.0,
        10.0,
        "Longest delay of a detection; each is uniform up to it",
    ),
    Key::number("pd", "", 0.0, 1.0, "Probability that a passage is detected"),
    Key::number("false_per_h", "1/h", 0.0, 1e5, "False passages"),
    Key::number(
        "assumed_half_length_m",
        "m",
        0.0,
        50.0,
        "Half the length that a single loop assumes of a target",
    ),
    Key::number("sigma_half_length_m", "m", 0.0, 50.0, "Uncertainty of that half length"),
    Key::number(
        "assumed_speed_mps",
        "m/s",
        0.0,
        100.0,
        "Speed that a single loop assumes of a target in its variance",
    ),
];
