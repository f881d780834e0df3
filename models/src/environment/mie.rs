//! Rain drop by drop: Mie scattering over a drop-size spectrum, the exact level of rain echo and attenuation.

use super::fog::water_permittivity;
use super::wavelength_m;
use nalgebra::Complex;
use std::f64::consts::PI;

/// Temperature of the drops, K.
const DROP_K: f64 = 283.15;
/// Decibels per kilometre of an extinction of one per metre: `10⁴·log₁₀ e` in the five figures that
/// published tables of extinction use.
const DB_PER_NEPER_KM: f64 = 4342.9;
/// Drop diameters, mm.
const DIAMETERS_MM: (f64, f64) = (0.05, 6.5);

/// What a rain does by its drops.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MieRain {
    /// Volume reflectivity, m²/m³.
    pub reflectivity: f64,
    /// Extinction, dB/km one way.
    pub db_per_km: f64,
    /// Rejection of the echo by circular polarisation because drops are oblate, dB.
    pub drop_rejection_db: f64,
}

impl MieRain {
    /// Spheres of water at 10 °C over the spectrum of Marshall & Palmer (1948),
    /// `N(D) = 8000·exp(−4.1·R^−0.21·D)` per m³ and mm; the rejection from oblate Rayleigh spheroids of
    /// axis ratio `min(1, 1.03 − 0.062·D)`.
    ///
    /// Source: Bohren & Huffman, *Absorption and Scattering of Light by Small Particles*, ch. 4 and 5.
    /// No rain has neither echo nor loss.
    #[must_use]
    pub fn new(carrier_ghz: f64, rain_mm_per_h: f64) -> Self {
        if rain_mm_per_h == 0.0 {
            return Self::default();
        }
        MieDrops::new(carrier_ghz).rain(rain_mm_per_h)
    }
}

/// What drops of every size do at one carrier; a rain is their sum over its spectrum.
#[derive(Clone, Debug, PartialEq)]
pub struct MieDrops {
    spheres: Vec<Sphere>,
    spheroids: Vec<Spheroid>,
}

/// Cross sections of a spherical drop, weighted by the step of the sum.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sphere {
    d_mm: f64,
    step: f64,
    back: f64,
    extinction: f64,
}

/// Powers that an oblate drop returns in the sense sent and in the other.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Spheroid {
    d_mm: f64,
    step: f64,
    whole: f64,
    leaked: f64,
}

impl MieDrops {
    /// The drops' table at a carrier: about 0.2 ms, once per radar.
    #[must_use]
    pub fn new(carrier_ghz: f64) -> Self {
        let permittivity = water_permittivity(carrier_ghz, DROP_K);
        let lambda_m = wavelength_m(carrier_ghz);
        let mut spheres = Vec::with_capacity(160);
        trapezoid(160, |d_mm, step| {
            let (back, extinction) = sphere(permittivity, d_mm * 1e-3, lambda_m);
            spheres.push(Sphere { d_mm, step, back, extinction });
        });
        let mut spheroids = Vec::with_capacity(400);
        trapezoid(400, |d_mm, step| {
            let (horizontal, vertical) = spheroid(permittivity, d_mm);
            let power = |z: Complex<f64>| z.re * z.re + z.im * z.im;
            let volume = d_mm * d_mm * d_mm;
            spheroids.push(Spheroid {
                d_mm,
                step,
                whole: volume * volume * power(horizontal),
                leaked: volume * volume * 0.25 * power(horizontal - vertical),
            });
        });
        Self { spheres, spheroids }
    }

    /// A rain of more than 0 mm/h of these drops: some microseconds.
    #[must_use]
    pub fn rain(&self, rain_mm_per_h: f64) -> MieRain {
        let slope = 4.1 * libm::pow(rain_mm_per_h, -0.21);
        let mut drops = Spectrum::new(slope, self.spheres.len());
        let (mut reflectivity, mut extinction) = (0.0, 0.0);
        for sphere in &self.spheres {
            let count = sphere.step * drops.next(sphere.d_mm);
            reflectivity += count * sphere.back;
            extinction += count * sphere.extinction;
        }
        let mut drops = Spectrum::new(slope, self.spheroids.len());
        let (mut whole, mut leaked) = (0.0, 0.0);
        for spheroid in &self.spheroids {
            let count = spheroid.step * drops.next(spheroid.d_mm);
            whole += count * spheroid.whole;
            leaked += count * spheroid.leaked;
        }
        MieRain {
            reflectivity,
            db_per_km: DB_PER_NEPER_KM * extinction,
            drop_rejection_db: 10.0 * libm::log10(whole / leaked),
        }
    }
}

/// `8000·exp(−slope·D)` at equally spaced diameters: every sixteenth by itself, those between by the
/// ratio of neighbours, to 14 digits.
struct Spectrum {
    slope: f64,
    ratio: f64,
    last: f64,
    index: usize,
}

impl Spectrum {
    fn new(slope: f64, diameters: usize) -> Self {
        let (low, high) = DIAMETERS_MM;
        let spacing = (high - low) / (diameters - 1) as f64;
        Self { slope, ratio: libm::exp(-slope * spacing), last: 0.0, index: 0 }
    }

    fn next(&mut self, d_mm: f64) -> f64 {
        self.last = if self.index.is_multiple_of(16) {
            8000.0 * libm::exp(-self.slope * d_mm)
        } else {
            self.last * self.ratio
        };
        self.index += 1;
        self.last
    }
}

/// Calls `f(diameter, weight)` for `n` equally spaced diameters.
fn trapezoid(n: u32, mut f: impl FnMut(f64, f64)) {
    let (low, high) = DIAMETERS_MM;
    let step = (high - low) / f64::from(n - 1);
    for i in 0..n {
        let edge = if i == 0 || i == n - 1 { 0.5 } else { 1.0 };
        f(low + step * f64::from(i), step * edge);
    }
}

/// Polarisabilities per volume of an oblate drop along its horizontal and vertical axis.
fn spheroid(permittivity: Complex<f64>, d_mm: f64) -> (Complex<f64>, Complex<f64>) {
    let ratio = (1.03 - 0.062 * d_mm).min(1.0);
    let vertical = if ratio < 1.0 {
        let f2 = 1.0 / (ratio * ratio) - 1.0;
        let f = f2.sqrt();
        (1.0 + f2) / f2 * (1.0 - libm::atan(f) / f)
    } else {
        1.0 / 3.0
    };
    let horizontal = 0.5 * (1.0 - vertical);
    let contrast = permittivity - 1.0;
    (contrast / (contrast * horizontal + 1.0), contrast / (contrast * vertical + 1.0))
}

/// Backscatter and extinction cross sections of a sphere, m².
fn sphere(permittivity: Complex<f64>, diameter_m: f64, lambda_m: f64) -> (f64, f64) {
    const MOST: usize = 64;
    let k = 2.0 * PI / lambda_m;
    let x = 0.5 * k * diameter_m;
    // The textbook's time factor is exp(−iωt): the index has a positive imaginary part.
    let index = sqrt_upper(permittivity.conj());
    let y = index * x;
    let terms = ((x + 4.0 * libm::cbrt(x) + 2.0).ceil() as usize).min(MOST - 20);
    let start = (terms.max(y.norm_sqr().sqrt() as usize) + 16).min(MOST - 1);
    // Logarithmic derivatives by downward recurrence, of the inside and the outside argument.
    let mut inside = [Complex::new(0.0, 0.0); MOST];
    let mut outside = [0.0; MOST];
    for n in (1..=start).rev() {
        let ratio = y.inv() * n as f64;
        inside[n - 1] = ratio - (inside[n] + ratio).inv();
        let ratio = n as f64 / x;
        outside[n - 1] = ratio - 1.0 / (outside[n] + ratio);
    }
    let (sin, cos) = libm::sincos(x);
    let (mut psi, mut chi, mut chi_before) = (sin, cos, -sin);
    let (mut extinction, mut back) = (0.0, Complex::new(0.0, 0.0));
    let mut sign = -1.0;
    for n in 1..=terms {
        let order = n as f64;
        let psi_before = psi;
        psi = psi_before / (outside[n] + order / x);
        let chi_next = (2.0 * order - 1.0) / x * chi - chi_before;
        let (xi, xi_before) = (Complex::new(psi, -chi_next), Complex::new(psi_before, -chi));
        (chi_before, chi) = (chi, chi_next);
        let electric = inside[n] / index + order / x;
        let magnetic = inside[n] * index + order / x;
        let a = (electric * psi - psi_before) / (electric * xi - xi_before);
        let b = (magnetic * psi - psi_before) / (magnetic * xi - xi_before);
        let weight = 2.0 * order + 1.0;
        extinction += weight * (a.re + b.re);
        back += (a - b) * (weight * sign);
        sign = -sign;
    }
    let area = PI / (k * k);
    (area * (back.re * back.re + back.im * back.im), 2.0 * area * extinction)
}

/// Square root in the upper half plane, on `libm`.
fn sqrt_upper(z: Complex<f64>) -> Complex<f64> {
    let modulus = libm::hypot(z.re, z.im);
    let im = (0.5 * (modulus - z.re).max(0.0)).sqrt();
    let re = (0.5 * (modulus + z.re).max(0.0)).sqrt();
    Complex::new(re, im)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_spheres_follow_rayleigh() {
        let water = water_permittivity(9.0, DROP_K);
        let (lambda, d) = (wavelength_m(9.0), 0.1e-3_f64);
        let k = (water - 1.0) / (water + 2.0);
        let rayleigh = PI.powi(5) * k.norm_sqr() * d.powi(6) / lambda.powi(4);
        let (back, ext) = sphere(water, d, lambda);
        assert!((back / rayleigh - 1.0).abs() < 1e-2, "{}", back / rayleigh);
        let absorbed = PI * PI * d.powi(3) / lambda * -k.im;
        assert!((ext / absorbed - 1.0).abs() < 2e-2, "{}", ext / absorbed);
    }

    #[test]
    fn every_rain_has_a_finite_echo() {
        for rain in [0.0, 1e-3, 0.25, 16.0, 250.0, 1000.0] {
            for carrier in [1.0, 9.0, 16.0, 35.0, 100.0] {
                let r = MieRain::new(carrier, rain);
                assert!(r.reflectivity.is_finite() && r.reflectivity >= 0.0, "{carrier} {rain}");
                assert!(r.db_per_km.is_finite() && r.db_per_km >= 0.0, "{carrier} {rain}");
                assert!(r.drop_rejection_db.is_finite());
            }
        }
    }
}
