//! From where somebody is to the line that he is to be on, without a jump of place or velocity.

/// Greatest acceleration sideways and up on the way to the final, m/s² (assumed: 9° of bank; 0.05 g).
const ASIDE_MPS2: f64 = 1.5;
const UP_MPS2: f64 = 0.5;
/// Shortest way to it, s.
const SHORTEST_S: f64 = 10.0;
/// Largest second derivatives of the two polynomials, for the offset and for the rate.
const OF_OFFSET: f64 = 5.7736;
const OF_RATE: f64 = 3.942;

/// Offsets that end: `y(x) = y₀ h₀(x) + ẏ₀ T h₁(x)`, `x = (t − t₀)/T`, with `h₀ = 1 − 10x³ + 15x⁴ − 6x⁵` and `h₁ = x − 6x³ + 8x⁴ − 3x⁵`:
/// place, rate and their end fit, accelerations begin and end with zero.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::traffic::core) struct Join {
    from_s: f64,
    takes_s: f64,
    /// To the right and up: m, m/s.
    beside: (f64, f64),
    above: (f64, f64),
}

impl Join {
    /// From a time on, from so far beside and above, m, at such rates, m/s.
    pub(super) fn new(from_s: f64, beside: (f64, f64), above: (f64, f64)) -> Self {
        let takes_s = time_s(beside, ASIDE_MPS2).max(time_s(above, UP_MPS2)).max(SHORTEST_S);
        Self { from_s, takes_s, beside, above }
    }

    /// How long it takes, s.
    pub(super) fn takes_s(&self) -> f64 {
        self.takes_s
    }

    /// When it has ended, s.
    pub(in crate::traffic::core) fn ends_s(&self) -> f64 {
        self.from_s + self.takes_s
    }

    /// To the right, m and m/s, and up, likewise, at a time.
    pub(in crate::traffic::core) fn at(&self, time_s: f64) -> ((f64, f64), (f64, f64)) {
        let x = ((time_s - self.from_s) / self.takes_s).clamp(0.0, 1.0);
        let (x2, x3) = (x * x, x * x * x);
        let offset = 1.0 - x3 * (10.0 - 15.0 * x + 6.0 * x2);
        let rate = x - x3 * (6.0 - 8.0 * x + 3.0 * x2);
        let offset_rate = -30.0 * x2 * (1.0 - x) * (1.0 - x) / self.takes_s;
        let rate_rate = 1.0 - x2 * (18.0 - 32.0 * x + 15.0 * x2);
        let of = |(y, v): (f64, f64)| {
            (y * offset + v * self.takes_s * rate, y * offset_rate + v * rate_rate)
        };
        (of(self.beside), of(self.above))
    }

    pub(super) fn feed(&self, feed: &mut impl FnMut(u64)) {
        [self.from_s, self.takes_s, self.beside.0, self.beside.1, self.above.0, self.above.1]
            .iter()
            .for_each(|x| feed(x.to_bits()));
    }
}

/// Least time in which an offset and a rate end within an acceleration: `T² a ≥ c₀ |y| + c₁ |ẏ| T`.
fn time_s((y, v): (f64, f64), most_mps2: f64) -> f64 {
    let (b, c) = (OF_RATE * v.abs() / most_mps2, OF_OFFSET * y.abs() / most_mps2);
    0.5 * (b + (b * b + 4.0 * c).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// It begins where and as it is, ends with nothing, its rate is that of its place, and it presses nobody more than said.
        #[test]
        fn an_offset_ends_as_softly_as_it_says(
            beside in (-900.0..900.0_f64, -25.0..25.0_f64),
            above in (-200.0..200.0_f64, -10.0..10.0_f64),
        ) {
            let join = Join::new(7.0, beside, above);
            prop_assert_eq!(join.at(7.0), (beside, above));
            let end = join.at(7.0 + join.takes_s());
            for x in [end.0.0, end.0.1, end.1.0, end.1.1] {
                prop_assert!(x.abs() < 1e-9, "{end:?}");
            }
            let dt = join.takes_s() / 500.0;
            for k in 1..500 {
                let t = 7.0 + f64::from(k) * dt;
                let (before, now, after) = (join.at(t - dt), join.at(t), join.at(t + dt));
                for (b, n, a, most) in [
                    (before.0, now.0, after.0, ASIDE_MPS2),
                    (before.1, now.1, after.1, UP_MPS2),
                ] {
                    let rate = (a.0 - b.0) / (2.0 * dt);
                    prop_assert!((rate - n.1).abs() < 0.01 + 1e-3 * n.1.abs(), "{rate} {}", n.1);
                    let acceleration = (a.1 - b.1) / (2.0 * dt);
                    prop_assert!(acceleration.abs() <= most * 1.001, "{acceleration} m/s2");
                }
            }
        }
    }
}
