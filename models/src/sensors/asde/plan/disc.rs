//! Arithmetic of discs of the complex plane, and of discs with their slope: what encloses an analytic
//! function of one real number over a range of it.
//!
//! Every operation gives a disc that holds the result for every member of its operands. Over a range, a
//! function lies in the disc about its value in the middle whose radius is half the range times its
//! largest slope (mean value form): of second order in the range, where values alone are of first.

use crate::environment::surface::{Complex, modulus};
use std::ops::{Add, Div, Mul, Sub};

/// All numbers within a radius of a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Centre.
    pub centre: Complex<f64>,
    /// Radius; infinite where nothing is known.
    pub radius: f64,
}

impl Disc {
    /// One number.
    #[must_use]
    pub fn point(z: Complex<f64>) -> Self {
        Self { centre: z, radius: 0.0 }
    }

    /// Real numbers about one.
    #[must_use]
    pub fn about(middle: f64, half: f64) -> Self {
        Self { centre: Complex::new(middle, 0.0), radius: half }
    }

    /// Largest modulus.
    #[must_use]
    pub fn most(&self) -> f64 {
        modulus(self.centre) + self.radius
    }

    /// Least modulus.
    #[must_use]
    pub fn least(&self) -> f64 {
        (modulus(self.centre) - self.radius).max(0.0)
    }

    /// Largest angle between a member and one of another disc, rad; at most π.
    #[must_use]
    pub fn turn(&self, other: &Self) -> f64 {
        let (a, b) = (modulus(self.centre), modulus(other.centre));
        if self.radius >= a || other.radius >= b {
            return std::f64::consts::PI;
        }
        let between = (self.centre * other.centre.conj()) / (a * b);
        let centres = libm::atan2(between.im, between.re).abs();
        let wide = libm::asin(self.radius / a) + libm::asin(other.radius / b);
        (centres + wide).min(std::f64::consts::PI)
    }

    /// The root whose real part is not negative.
    #[must_use]
    pub fn root(self) -> Self {
        let size = modulus(self.centre);
        // Of the two parts, the larger from the sum: the smaller without cancelling.
        let re = (0.5 * (size + self.centre.re)).max(0.0).sqrt();
        let im = (0.5 * (size - self.centre.re)).max(0.0).sqrt().copysign(self.centre.im);
        let centre = if self.centre.re >= 0.0 {
            Complex::new(re, if re > 0.0 { 0.5 * self.centre.im / re } else { 0.0 })
        } else {
            Complex::new(0.5 * self.centre.im.abs() / im.abs(), im)
        };
        // |√z − √c| = |z − c|/|√z + √c|: two roots are less than a quarter of a turn apart.
        let radius = match () {
            () if self.radius == 0.0 => 0.0,
            () if self.radius < size => {
                self.radius / (size.sqrt() * (1.0 + (1.0 - self.radius / size).sqrt()))
            }
            () => f64::INFINITY,
        };
        Self { centre, radius }
    }

    /// The exponential.
    #[must_use]
    pub fn exp(self) -> Self {
        let (sin, cos) = libm::sincos(self.centre.im);
        let size = libm::exp(self.centre.re);
        Self { centre: Complex::new(cos, sin) * size, radius: size * libm::expm1(self.radius) }
    }
}

impl Add for Disc {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { centre: self.centre + other.centre, radius: self.radius + other.radius }
    }
}

impl Sub for Disc {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { centre: self.centre - other.centre, radius: self.radius + other.radius }
    }
}

impl Mul for Disc {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let radius = if self.radius == 0.0 && other.radius == 0.0 {
            0.0
        } else {
            modulus(self.centre) * other.radius
                + modulus(other.centre) * self.radius
                + self.radius * other.radius
        };
        Self { centre: self.centre * other.centre, radius }
    }
}

impl Div for Disc {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        // 1/z maps a disc without 0 to a disc.
        let b = other.centre;
        let norm = b.re * b.re + b.im * b.im;
        let left = norm - other.radius * other.radius;
        if !(left > 0.0) {
            return Self { centre: Complex::new(0.0, 0.0), radius: f64::INFINITY };
        }
        self * Self { centre: b.conj() / left, radius: other.radius / left }
    }
}

/// A function and its slope over a range of one real number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sloped {
    /// Where its values are.
    pub value: Disc,
    /// Where its slope is.
    pub slope: Disc,
}

impl Sloped {
    /// The number itself.
    #[must_use]
    pub fn number(middle: f64, half: f64) -> Self {
        Self { value: Disc::about(middle, half), slope: Disc::about(1.0, 0.0) }
    }

    /// What does not depend on it.
    #[must_use]
    pub fn fixed(z: Complex<f64>) -> Self {
        Self { value: Disc::point(z), slope: Disc::about(0.0, 0.0) }
    }

    /// The root whose real part is not negative.
    #[must_use]
    pub fn root(self) -> Self {
        let value = self.value.root();
        Self { value, slope: self.slope / (value + value) }
    }

    /// The exponential.
    #[must_use]
    pub fn exp(self) -> Self {
        let value = self.value.exp();
        Self { value, slope: self.slope * value }
    }
}

impl Add for Sloped {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, slope: self.slope + other.slope }
    }
}

impl Sub for Sloped {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { value: self.value - other.value, slope: self.slope - other.slope }
    }
}

impl Mul for Sloped {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let slope = self.slope * other.value + self.value * other.slope;
        Self { value: self.value * other.value, slope }
    }
}

impl Div for Sloped {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self { value, slope: (self.slope - value * other.slope) / other.value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn member(disc: &Disc, share: f64, angle: f64) -> Complex<f64> {
        let (sin, cos) = libm::sincos(angle);
        disc.centre + Complex::new(cos, sin) * (disc.radius * share)
    }

    fn holds(disc: &Disc, z: Complex<f64>) -> bool {
        modulus(z - disc.centre) <= disc.radius * (1.0 + 1e-9) + 1e-9 * (1.0 + modulus(z))
    }

    proptest! {
        #[test]
        fn results_hold_the_results_of_every_member(
            a in (-3.0..3.0f64, -3.0..3.0f64, 0.0..1.0f64),
            b in (-3.0..3.0f64, -3.0..3.0f64, 0.0..1.0f64),
            (share, angle, other) in (0.0..=1.0f64, -4.0..4.0f64, -4.0..4.0f64),
        ) {
            let disc = |(re, im, radius): (f64, f64, f64)| Disc { centre: Complex::new(re, im), radius };
            let (a, b) = (disc(a), disc(b));
            let (x, y) = (member(&a, share, angle), member(&b, share, other));
            prop_assert!(holds(&(a + b), x + y) && holds(&(a - b), x - y) && holds(&(a * b), x * y));
            if (a / b).radius.is_finite() {
                prop_assert!(holds(&(a / b), x / y));
            }
            let e = libm::exp(x.re);
            prop_assert!(holds(&a.exp(), Complex::new(e * libm::cos(x.im), e * libm::sin(x.im))));
            prop_assert!(modulus(x) <= a.most() * (1.0 + 1e-12) && modulus(x) >= a.least() * (1.0 - 1e-12));
            if modulus(x) > 1e-9 && modulus(y) > 1e-9 {
                let apart = x * y.conj();
                prop_assert!(libm::atan2(apart.im, apart.re).abs() <= a.turn(&b) + 1e-6);
            }
            // Of the right half plane only: elsewhere the root jumps.
            if a.centre.re > a.radius {
                let root = Disc::point(x).root().centre;
                prop_assert!(modulus(root * root - x) < 1e-12 * (1.0 + modulus(x)));
                prop_assert!(holds(&a.root(), root));
            }
        }

        #[test]
        fn slopes_hold_differences(middle in 0.05..0.9f64, half in 0.0..0.05f64, share in -1.0..1.0f64) {
            let of = |s: Sloped| {
                let e = Sloped::fixed(Complex::new(4.0, -0.3));
                let q = (e + s * s).root();
                (s - q) / (e * s + q) + (Sloped::fixed(Complex::new(0.0, -2.0)) * q).exp()
            };
            let over = of(Sloped::number(middle, half));
            let at = |x: f64| of(Sloped::number(x, 0.0)).value.centre;
            let x = middle + half * share;
            prop_assert!(modulus(at(x) - at(middle)) <= over.slope.most() * half + 1e-12);
            prop_assert!(holds(&over.value, at(x)));
        }
    }
}
