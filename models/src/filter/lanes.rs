//! The two axes of the airport frame side by side: east in lane 0, north in lane 1.
//!
//! The per-axis filters do the same arithmetic on both axes. Written on pairs, one packed
//! instruction of any 64-bit x86 or ARM does both, and no axis can be treated differently by mistake.

use std::ops::{Add, Mul, Sub};
use wide::f64x2;

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
    #[inline]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline]
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

/// East and north component of one quantity, in one register.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pair(f64x2);

impl Pair {
    /// East and north.
    #[inline]
    #[must_use]
    pub fn new(east: f64, north: f64) -> Self {
        Self(f64x2::new([east, north]))
    }
    /// East and north.
    #[inline]
    #[must_use]
    pub fn array(self) -> [f64; 2] {
        self.0.to_array()
    }
    /// East component.
    #[inline]
    #[must_use]
    pub fn east(self) -> f64 {
        self.array()[0]
    }
    /// North component.
    #[inline]
    #[must_use]
    pub fn north(self) -> f64 {
        self.array()[1]
    }
    /// `1 / self`, lane by lane.
    #[inline]
    #[must_use]
    pub fn recip(self) -> Self {
        Self(f64x2::splat(1.0) / self.0)
    }
}

impl Lane for Pair {
    #[inline]
    fn splat(value: f64) -> Self {
        Self(f64x2::splat(value))
    }
    #[inline]
    fn div_or(self, divisor: Self, otherwise: f64) -> Self {
        let zero = divisor.0.simd_eq(f64x2::ZERO);
        Self(zero.bitselect(f64x2::splat(otherwise), self.0 / divisor.0))
    }
    #[inline]
    fn all_positive(self) -> bool {
        let above = self.0.simd_gt(f64x2::ZERO);
        (above & f64x2::splat(f64::INFINITY).simd_gt(self.0)).all()
    }
    #[inline]
    fn sum(self) -> f64 {
        self.0.reduce_add()
    }
}

impl Add for Pair {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0)
    }
}

impl Sub for Pair {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        Self(self.0 - o.0)
    }
}

impl Mul for Pair {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        Self(self.0 * o.0)
    }
}

impl Mul<f64> for Pair {
    type Output = Self;
    #[inline]
    fn mul(self, k: f64) -> Self {
        Self(self.0 * f64x2::splat(k))
    }
}
