//! The two axes of the airport frame side by side: east in lane 0, north in lane 1.
//!
//! The per-axis filters do the same arithmetic on both axes. Written on pairs, one packed
//! instruction of any 64-bit x86 or ARM does both, and no axis can be treated differently by mistake.

use std::ops::{Add, Mul, Sub};

/// A number that the square-root-free filter can run on: one axis (`f64`) or both ([`Pair`]).
pub trait Lane:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + std::fmt::Debug
{
    /// The same value in every lane.
    fn splat(value: f64) -> Self;
    /// `self / divisor`, and `otherwise` in each lane whose divisor is zero.
    #[must_use]
    fn div_or(self, divisor: Self, otherwise: f64) -> Self;
    /// True if every lane is finite and greater than zero.
    fn all_positive(self) -> bool;
    /// Sum over the lanes.
    fn sum(self) -> f64;
}

impl Lane for f64 {
    fn splat(value: f64) -> Self {
        value
    }
    fn div_or(self, divisor: Self, otherwise: f64) -> Self {
        if divisor == 0.0 { otherwise } else { self / divisor }
    }
    fn all_positive(self) -> bool {
        self > 0.0 && self < Self::INFINITY
    }
    fn sum(self) -> f64 {
        self
    }
}

/// East and north component of one quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pair(pub [f64; 2]);

impl Pair {
    /// East and north.
    #[must_use]
    pub fn new(east: f64, north: f64) -> Self {
        Self([east, north])
    }
    /// East component.
    #[must_use]
    pub fn east(self) -> f64 {
        self.0[0]
    }
    /// North component.
    #[must_use]
    pub fn north(self) -> f64 {
        self.0[1]
    }
    /// `1 / self`, lane by lane.
    #[must_use]
    pub fn recip(self) -> Self {
        Self([1.0 / self.0[0], 1.0 / self.0[1]])
    }
}

impl Lane for Pair {
    fn splat(value: f64) -> Self {
        Self([value, value])
    }
    fn div_or(self, divisor: Self, otherwise: f64) -> Self {
        Self([self.0[0].div_or(divisor.0[0], otherwise), self.0[1].div_or(divisor.0[1], otherwise)])
    }
    fn all_positive(self) -> bool {
        self.0[0].all_positive() & self.0[1].all_positive()
    }
    fn sum(self) -> f64 {
        self.0[0] + self.0[1]
    }
}

impl Add for Pair {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self([self.0[0] + o.0[0], self.0[1] + o.0[1]])
    }
}

impl Sub for Pair {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self([self.0[0] - o.0[0], self.0[1] - o.0[1]])
    }
}

impl Mul for Pair {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self([self.0[0] * o.0[0], self.0[1] * o.0[1]])
    }
}

impl Mul<f64> for Pair {
    type Output = Self;
    fn mul(self, k: f64) -> Self {
        Self([self.0[0] * k, self.0[1] * k])
    }
}
