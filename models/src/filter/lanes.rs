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
    /// Magnitudes.
    #[inline]
    #[must_use]
    pub(super) fn abs(self) -> Self {
        Self(self.0.abs())
    }
    /// The lanes swapped.
    #[inline]
    #[must_use]
    pub(super) fn swapped(self) -> Self {
        let [east, north] = self.array();
        Self::new(north, east)
    }
    /// Where `self < limit` is not so, as where one of them is NaN.
    #[inline]
    pub(super) fn not_below(self, limit: Self) -> Where {
        Where(!self.0.simd_lt(limit.0))
    }
    /// Where it is not finite and greater than zero.
    #[inline]
    pub(super) fn not_positive(self) -> Where {
        let (zero, infinity) = (Self(f64x2::ZERO), Self(f64x2::splat(f64::INFINITY)));
        zero.not_below(self) | self.not_below(infinity)
    }
    /// Itself where `which` holds, else zero.
    #[inline]
    #[must_use]
    pub(super) fn only(self, which: Where) -> Self {
        Self(which.0 & self.0)
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
        !self.not_positive().anywhere()
    }
    #[inline]
    fn sum(self) -> f64 {
        self.0.reduce_add()
    }
}

/// In which lanes something holds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Where(f64x2);

impl Where {
    /// True if it holds in one of them.
    #[inline]
    pub(super) fn anywhere(self) -> bool {
        self.0.any()
    }
}

impl std::ops::BitOr for Where {
    type Output = Self;
    #[inline]
    fn bitor(self, o: Self) -> Self {
        Self(self.0 | o.0)
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
