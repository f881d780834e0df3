//! Speed along a way: legs with limited acceleration and jerk, and how far it takes to stop.
//!
//! Source: `docs/traffic.md`, movers along the way; closed forms of the constant-jerk ramp.

/// Distance and time of a change of speed from `from_mps` to `to_mps`.
///
/// `T = |Δv|/a + a/j` where the acceleration is reached (`|Δv| ≥ a²/j`), else `T = 2 √(|Δv|/j)`; the
/// distance is `(u + w)/2 · T` because the ramp is symmetric. Without a jerk limit `T = |Δv|/a`.
#[must_use]
pub fn ramp(from_mps: f64, to_mps: f64, acc_mps2: f64, jerk_mps3: Option<f64>) -> (f64, f64) {
    let change = (to_mps - from_mps).abs();
    let time_s = match jerk_mps3 {
        None => change / acc_mps2,
        Some(j) if change >= acc_mps2 * acc_mps2 / j => change / acc_mps2 + acc_mps2 / j,
        Some(j) => 2.0 * (change / j).sqrt(),
    };
    (0.5 * (from_mps + to_mps) * time_s, time_s)
}

/// What a leg is driven with; SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Length, m.
    pub length_m: f64,
    /// Speed at its begin, reached with acceleration 0.
    pub v0_mps: f64,
    /// Speed at its end, reached with acceleration 0.
    pub v1_mps: f64,
    /// Speed limit.
    pub vmax_mps: f64,
    /// Greatest acceleration.
    pub acc_mps2: f64,
    /// Greatest braking, positive.
    pub dec_mps2: f64,
    /// Greatest change of acceleration, m/s³; `None`: unlimited.
    pub jerk_mps3: Option<f64>,
}

/// The fastest progress over a [`Leg`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LegProfile {
    /// Highest speed.
    pub peak_mps: f64,
    /// Duration.
    pub time_s: f64,
    /// Distance from the begin to the peak.
    pub acc_distance_m: f64,
    /// Distance at the speed limit; 0 if it is not reached.
    pub cruise_distance_m: f64,
}

/// The fastest progress over a leg, or `None` where the change of speed alone is longer than the leg or
/// a limit is not positive.
///
/// Peak speed: the limit if both ramps fit, else the root of `ramp(v0 → v) + ramp(v → v1) = length`,
/// which is monotone (bisection to 1e-12 relative).
#[must_use]
pub fn leg_profile(leg: &Leg) -> Option<LegProfile> {
    let Leg { length_m, v0_mps, v1_mps, vmax_mps, acc_mps2, dec_mps2, jerk_mps3 } = *leg;
    let positive = acc_mps2 > 0.0 && dec_mps2 > 0.0 && jerk_mps3.is_none_or(|j| j > 0.0);
    let least = v0_mps.max(v1_mps);
    if !(positive && length_m >= 0.0 && v0_mps.min(v1_mps) >= 0.0 && vmax_mps >= least) {
        return None;
    }
    let up = |peak: f64| ramp(v0_mps, peak, acc_mps2, jerk_mps3);
    let down = |peak: f64| ramp(peak, v1_mps, dec_mps2, jerk_mps3);
    let needed = |peak: f64| up(peak).0 + down(peak).0;
    if needed(least) > length_m * (1.0 + 1e-12) {
        return None;
    }
    let peak_mps = if needed(vmax_mps) <= length_m {
        vmax_mps
    } else {
        let (mut low, mut high) = (least, vmax_mps);
        while high - low > 1e-13 * high {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if needed(middle) <= length_m { low = middle } else { high = middle }
        }
        low
    };
    let ((acc_distance_m, up_s), (dec_distance_m, down_s)) = (up(peak_mps), down(peak_mps));
    let rest_m = (length_m - acc_distance_m - dec_distance_m).max(0.0);
    let cruise_distance_m = if peak_mps == vmax_mps { rest_m } else { 0.0 };
    let cruise_s = if cruise_distance_m > 0.0 { cruise_distance_m / peak_mps } else { 0.0 };
    Some(LegProfile {
        peak_mps,
        time_s: up_s + down_s + cruise_s,
        acc_distance_m,
        cruise_distance_m,
    })
}

/// Speed from which a mover with acceleration 0 stops within `gap_m`.
///
/// `v = √(b² + 2 a g) − b`, `b = a²/(2j)` (0 without a jerk limit), written as `2ag/(√(b² + 2ag) + b)`:
/// the difference cancels for small gaps.
#[must_use]
pub fn stopping_speed_mps(gap_m: f64, dec_mps2: f64, jerk_mps3: Option<f64>) -> f64 {
    if gap_m <= 0.0 {
        return 0.0;
    }
    let b = jerk_mps3.map_or(0.0, |j| dec_mps2 * dec_mps2 / (2.0 * j));
    let twice = 2.0 * dec_mps2 * gap_m;
    twice / ((b * b + twice).sqrt() + b)
}

/// Distance (m) and time (s) to standstill: the acceleration `a_mps2` is held for `reaction_s`, then
/// falls with the jerk limit to `−dec_mps2`, which is held.
///
/// `d = v t_r + ½ a t_r² + v' t_j + ½ a t_j² − j t_j³/6 + v_j²/(2 dec)` with `t_j = (a + dec)/j`,
/// `v' = v + a t_r`, `v_j = v' + a t_j − ½ j t_j²`; if `v_j < 0` it stands before the braking is
/// reached, at the root of `v' + a t − ½ j t² = 0`.
#[must_use]
pub fn stopping(
    v_mps: f64,
    a_mps2: f64,
    dec_mps2: f64,
    jerk_mps3: f64,
    reaction_s: f64,
) -> (f64, f64) {
    let (v, a, j) = (v_mps, a_mps2, jerk_mps3);
    // Somebody who brakes already may stand before the reaction is over.
    if a < 0.0 && v + a * reaction_s <= 0.0 {
        return (v * v / (-2.0 * a), v / -a);
    }
    let reacted_m = v * reaction_s + 0.5 * a * reaction_s * reaction_s;
    let after = v + a * reaction_s;
    let t_j = ((a + dec_mps2) / j).max(0.0);
    let v_j = after + a * t_j - 0.5 * j * t_j * t_j;
    if v_j < 0.0 {
        let t = (a + (a * a + 2.0 * j * after).sqrt()) / j;
        return (reacted_m + after * t + 0.5 * a * t * t - j * t * t * t / 6.0, reaction_s + t);
    }
    let ramped_m = after * t_j + 0.5 * a * t_j * t_j - j * t_j * t_j * t_j / 6.0;
    let dec = dec_mps2.max(-a);
    (reacted_m + ramped_m + v_j * v_j / (2.0 * dec), reaction_s + t_j + v_j / dec)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_speed_near_a_stop_does_not_cancel() {
        let b = 0.7 * 0.7 / (2.0 * 0.6);
        for gap_m in [1e-17, 1e-9, 1e-3] {
            // Second order: a g / b (1 − a g / 2b²); the naive difference is wrong by more than the value at 1e-17.
            let expected = 0.7 * gap_m / b * (1.0 - 0.7 * gap_m / (2.0 * b * b));
            let found = stopping_speed_mps(gap_m, 0.7, Some(0.6));
            assert!((found / expected - 1.0).abs() < 1e-5, "{gap_m:e}: {found:e}");
            let naive = (b * b + 2.0 * 0.7 * gap_m).sqrt() - b;
            let wrong = (naive / expected - 1.0).abs();
            assert!(gap_m > 1e-16 || wrong > 0.9, "the naive form gives {naive:e}");
        }
        assert_eq!(stopping_speed_mps(-1.0, 0.7, None), 0.0);
    }

    #[test]
    fn a_leg_takes_at_least_its_length_over_the_limit() {
        for (length_m, v0_mps, v1_mps) in [(1.0, 0.0, 0.0), (300.0, 3.0, 0.0), (40.0, 0.0, 5.0)] {
            let (vmax_mps, acc_mps2, dec_mps2) = (10.0, 0.7, 0.7);
            let leg = Leg {
                length_m,
                v0_mps,
                v1_mps,
                vmax_mps,
                acc_mps2,
                dec_mps2,
                jerk_mps3: Some(0.6),
            };
            let with = leg_profile(&leg).expect("fits");
            let without = leg_profile(&Leg { jerk_mps3: None, ..leg }).expect("fits");
            assert!(with.time_s >= without.time_s && without.time_s >= length_m / vmax_mps);
        }
        let leg = Leg {
            length_m: 1.0,
            v0_mps: 10.0,
            v1_mps: 0.0,
            vmax_mps: 12.0,
            acc_mps2: 0.7,
            dec_mps2: 0.7,
            jerk_mps3: None,
        };
        assert_eq!(leg_profile(&leg), None, "cannot stop within a metre");
    }
}
