//! Final approach, landing roll, choice of the exit, and take-off run.
//!
//! Source: `docs/traffic.md`; thrust less drag as `a = A − B u²` (u airspeed) is the textbook form of the
//! take-off run, its integrals are closed.

/// Standard acceleration of gravity, m/s² (ISO 80000-3).
const GRAVITY_MPS2: f64 = 9.806_65;
/// International nautical mile, m, and knot, m/s.
pub const NAUTICAL_MILE_M: f64 = 1852.0;
const KNOT_MPS: f64 = NAUTICAL_MILE_M / 3600.0;

/// What the table says of a type's take-off, and the day.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TakeOff {
    /// Lift-off airspeed at sea level, m/s.
    pub liftoff_mps: f64,
    /// Run to it without wind at sea level, m.
    pub distance_m: f64,
    /// Air density over that of sea level.
    pub density_ratio: f64,
    /// Head wind, m/s; negative: tail wind.
    pub headwind_mps: f64,
    /// Acceleration at lift-off over that at rest (0.75 assumed).
    pub end_ratio: f64,
    /// Exponent of thrust by density (0.7 assumed).
    pub thrust_exponent: f64,
    /// Coefficient of rolling friction (0.02 assumed).
    pub rolling_friction: f64,
}

/// A take-off run from rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// `A`, m/s²: acceleration at no airspeed.
    pub a_mps2: f64,
    /// `B`, 1/m.
    pub b_per_m: f64,
    /// Ground speed at lift-off, m/s.
    pub liftoff_ground_mps: f64,
    /// Distance to lift-off, m.
    pub distance_m: f64,
    /// Time to lift-off, s.
    pub time_s: f64,
}

/// The run to lift-off, or `None` where the type cannot lift off on this day (`B V² ≥ A`) or the wind
/// is stronger than the lift-off speed.
///
/// `A₀ = V² ln(1/r)/(2S(1−r))`, `B₀ = A₀(1−r)/V²`; `A = (A₀ + μg)σ^n − μg`, `B = B₀σ`, `V_σ = V/√σ`;
/// `t = [atanh(V_σ q) − atanh(w q)]/√(AB)`, `d = ln[(A − Bw²)/(A − BV_σ²)]/(2B) − wt`, `q = √(B/A)`.
#[must_use]
pub fn take_off_run(t: &TakeOff) -> Option<Run> {
    let (v, r, w) = (t.liftoff_mps, t.end_ratio, t.headwind_mps);
    let friction = t.rolling_friction * GRAVITY_MPS2;
    let a0 = v * v * -libm::log(r) / (2.0 * t.distance_m * (1.0 - r));
    let a_mps2 = (a0 + friction) * libm::pow(t.density_ratio, t.thrust_exponent) - friction;
    let b_per_m = a0 * (1.0 - r) / (v * v) * t.density_ratio;
    let at_liftoff = v / t.density_ratio.sqrt();
    let sound = a_mps2 > 0.0 && b_per_m > 0.0 && b_per_m * at_liftoff * at_liftoff < a_mps2;
    if !(sound && w.abs() < at_liftoff) {
        return None;
    }
    let q = (b_per_m / a_mps2).sqrt();
    let time_s = (libm::atanh(at_liftoff * q) - libm::atanh(w * q)) / (a_mps2 * b_per_m).sqrt();
    let gained = (a_mps2 - b_per_m * w * w) / (a_mps2 - b_per_m * at_liftoff * at_liftoff);
    let distance_m = libm::log(gained) / (2.0 * b_per_m) - w * time_s;
    let run = Run { a_mps2, b_per_m, liftoff_ground_mps: at_liftoff - w, distance_m, time_s };
    (run.distance_m.is_finite() && run.time_s.is_finite()).then_some(run)
}

/// Where aircraft touch down behind a threshold, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchdownZone {
    /// Mean and spread of a normal distribution.
    pub mean_m: f64,
    /// Standard deviation.
    pub sigma_m: f64,
    /// Nobody is outside of these.
    pub within_m: (f64, f64),
}

/// The zone of a runway of a length, m: beyond the aiming point, which Annex 14 puts nearer to the threshold of a runway under
/// 1 200 m (250 m) and under 800 m (150 m); spreads of those are assumed in proportion.
#[must_use]
pub fn touchdown_zone(length_m: f64) -> TouchdownZone {
    let zone = |mean_m, sigma_m, within_m| TouchdownZone { mean_m, sigma_m, within_m };
    match length_m {
        l if l < 800.0 => zone(150.0, 35.0, (60.0, 260.0)),
        l if l < 1200.0 => zone(250.0, 60.0, (100.0, 430.0)),
        _ => zone(420.0, 110.0, (150.0, 900.0)),
    }
}

/// Airspeed up to 4 NM from the threshold, m/s: 160 kt, or the approach speed where that is more; what touches down slower
/// than 73 kt does not fly as fast: 2.2 times its touchdown (assumed; a light single 120 kt).
fn first_airspeed_mps(touchdown_mps: f64) -> f64 {
    (1.03 * touchdown_mps).max((160.0 * KNOT_MPS).min(2.2 * touchdown_mps))
}

/// Airspeed on final, m/s: 160 kt (or the approach speed, where that is more; light ones less) to 4 NM from the threshold,
/// linear in distance to `1.03 V_td` at 3 NM, then that.
#[must_use]
pub fn approach_airspeed_mps(distance_m: f64, touchdown_mps: f64) -> f64 {
    let last = 1.03 * touchdown_mps;
    let first = first_airspeed_mps(touchdown_mps);
    let share = ((distance_m / NAUTICAL_MILE_M) - 3.0).clamp(0.0, 1.0);
    last + (first - last) * share
}

/// Time from `from_nm` (at least 4) to the threshold, s; `None` against a wind that cannot be flown.
#[must_use]
pub fn approach_time_s(touchdown_mps: f64, headwind_mps: f64, from_nm: f64) -> Option<f64> {
    let last = 1.03 * touchdown_mps - headwind_mps;
    let first = first_airspeed_mps(touchdown_mps) - headwind_mps;
    if !(last > 0.0 && from_nm >= 4.0) {
        return None;
    }
    // Mean slowness over the mile of braking: ln(first/last)/(first − last).
    let relative = (first - last) / last;
    let braking = if relative < 1e-9 { 1.0 / last } else { libm::log1p(relative) / (first - last) };
    Some(NAUTICAL_MILE_M * ((from_nm - 4.0) / first + braking + 3.0 / last))
}

/// A take-off from an intersection needs so much of its run ahead (assumed).
pub const INTERSECTION_SHARE: f64 = 1.15;

/// One exit of a runway in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exit {
    /// Distance behind the threshold, m.
    pub place_m: f64,
    /// Speed at which it can be entered, m/s.
    pub speed_mps: f64,
}

/// The landing roll of one aircraft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    /// Ground speed at touchdown, m/s.
    pub touchdown_mps: f64,
    /// Place of touchdown behind the threshold, m.
    pub touchdown_m: f64,
    /// From touchdown to the begin of braking, s.
    pub delay_s: f64,
    /// Usual braking, m/s².
    pub nominal_mps2: f64,
    /// Greatest braking, m/s².
    pub greatest_mps2: f64,
}

impl Landing {
    /// Braking that exit needs, m/s²; `None` where it is passed before braking begins.
    ///
    /// `a = (V² − v²)/(2 (x − x_td − t_d V))`.
    #[must_use]
    pub fn needed_mps2(&self, exit: Exit) -> Option<f64> {
        let v = self.touchdown_mps;
        let room_m = exit.place_m - self.touchdown_m - self.delay_s * v;
        (room_m > 0.0).then(|| (v * v - exit.speed_mps * exit.speed_mps) / (2.0 * room_m))
    }

    /// The farthest touchdown behind the threshold from which the greatest braking does for an exit, m.
    #[must_use]
    pub fn latest_m(&self, exit: Exit) -> f64 {
        let v = self.touchdown_mps;
        let braked_m = (v * v - exit.speed_mps * exit.speed_mps) / (2.0 * self.greatest_mps2);
        exit.place_m - self.delay_s * v - braked_m.max(0.0) - 1.0
    }

    /// Index of the exit taken: the first within the usual braking, else the first within the greatest;
    /// `None`: rolls to the end of the runway.
    #[must_use]
    pub fn exit(&self, exits: &[Exit]) -> Option<usize> {
        let within = |limit: f64| {
            exits.iter().position(|e| self.needed_mps2(*e).is_some_and(|a| a <= limit))
        };
        within(self.nominal_mps2).or_else(|| within(self.greatest_mps2))
    }

    /// Time from touchdown to an exit that can be reached, s.
    #[must_use]
    pub fn time_to_s(&self, exit: Exit) -> Option<f64> {
        let a = self.needed_mps2(exit)?;
        let v = self.touchdown_mps;
        // Not slower than the exit allows: no braking at all.
        let room_m = exit.place_m - self.touchdown_m - self.delay_s * v;
        let rolled_s = if a.abs() < 1e-12 { room_m / v } else { (v - exit.speed_mps) / a };
        Some(self.delay_s + rolled_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A320: TakeOff = TakeOff {
        liftoff_mps: 85.3,
        distance_m: 1650.0,
        density_ratio: 1.0,
        headwind_mps: 0.0,
        end_ratio: 0.75,
        thrust_exponent: 0.7,
        rolling_friction: 0.02,
    };

    #[test]
    fn a_type_that_cannot_lift_off_is_refused() {
        assert!(take_off_run(&A320).is_some_and(|r| (r.distance_m - 1650.0).abs() < 1e-9));
        let thin = TakeOff { density_ratio: 0.1, ..A320 };
        assert_eq!(take_off_run(&thin), None, "the naive form is atanh beyond 1");
        assert!(take_off_run(&TakeOff { headwind_mps: -10.0, ..A320 }).is_some());
        assert_eq!(take_off_run(&TakeOff { headwind_mps: 90.0, ..A320 }), None);
    }

    #[test]
    fn an_exit_before_touchdown_is_skipped() {
        let landing = Landing {
            touchdown_mps: 70.0,
            touchdown_m: 400.0,
            delay_s: 2.0,
            nominal_mps2: 1.2,
            greatest_mps2: 2.5,
        };
        let exits = [(300.0, 7.7), (535.0, 25.7), (2400.0, 7.7)];
        let exits = exits.map(|(place_m, speed_mps)| Exit { place_m, speed_mps });
        assert_eq!(landing.needed_mps2(exits[0]), None);
        assert_eq!(landing.exit(&exits), Some(2));
    }
}
