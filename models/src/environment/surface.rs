//! The reflecting surface: permittivity, Fresnel coefficients, water film, roughness.

pub use nalgebra::Complex;
use std::f64::consts::PI;

/// Electric constant, F/m.
pub const EPSILON_0: f64 = 8.854_187_812_8e-12;

/// What a surface is made of: `ε' = a·f^b`, `σ = c·f^d` S/m, f in GHz. Source: ITU-R P.2040-3, Table 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Name in scene files.
    pub name: &'static str,
    /// Factor of the permittivity.
    pub a: f64,
    /// Its exponent.
    pub b: f64,
    /// Factor of the conductivity, S/m.
    pub c: f64,
    /// Its exponent.
    pub d: f64,
    /// Carriers, GHz, for which the fit was published.
    pub published_ghz: (f64, f64),
    /// Carrier to which the fit is extrapolated here, GHz (with a warning beyond the published range).
    pub extrapolated_ghz: f64,
}

/// The materials by name.
#[rustfmt::skip]
pub const MATERIALS: [Material; 6] = [
    Material { name: "concrete", a: 5.24, b: 0.0, c: 0.0462, d: 0.7822, published_ghz: (1.0, 100.0), extrapolated_ghz: 100.0 },
    Material { name: "asphalt", a: 4.83, b: 0.0, c: 0.0108, d: 1.3969, published_ghz: (1.0, 40.0), extrapolated_ghz: 40.0 },
    Material { name: "very_dry_ground", a: 3.0, b: 0.0, c: 0.00015, d: 2.52, published_ghz: (1.0, 10.0), extrapolated_ghz: 18.0 },
    Material { name: "medium_dry_ground", a: 15.0, b: -0.1, c: 0.035, d: 1.63, published_ghz: (1.0, 10.0), extrapolated_ghz: 18.0 },
    Material { name: "wet_ground", a: 30.0, b: -0.4, c: 0.15, d: 1.30, published_ghz: (1.0, 10.0), extrapolated_ghz: 18.0 },
    Material { name: "metal", a: 1.0, b: 0.0, c: 1e7, d: 0.0, published_ghz: (1.0, 100.0), extrapolated_ghz: 100.0 },
];

impl Material {
    /// The material of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        MATERIALS.iter().find(|m| m.name == name)
    }

    /// Complex relative permittivity `ε' − jσ/(2πε₀f)`.
    #[must_use]
    pub fn permittivity(&self, carrier_ghz: f64) -> Complex<f64> {
        let conductivity = self.c * libm::pow(carrier_ghz, self.d);
        let im = conductivity / (2.0 * PI * EPSILON_0 * carrier_ghz * 1e9);
        Complex::new(self.a * libm::pow(carrier_ghz, self.b), -im)
    }
}

/// Reflection coefficients of the two linear polarisations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fresnel {
    /// Horizontal polarisation.
    pub horizontal: Complex<f64>,
    /// Vertical polarisation.
    pub vertical: Complex<f64>,
    /// `1 + horizontal`, computed without cancelling: small at small grazing angles.
    pub one_plus_horizontal: Complex<f64>,
    /// `1 + vertical`, likewise.
    pub one_plus_vertical: Complex<f64>,
}

impl Fresnel {
    /// Half space of `permittivity` seen at grazing angle `grazing_rad`, 0 to π/2.
    ///
    /// `Γ_H = (s − q)/(s + q)`, `Γ_V = (εs − q)/(εs + q)`, `s = sin ψ`, `q = √(ε − cos²ψ)` with a
    /// non-positive imaginary part (waves decay downwards).
    #[must_use]
    pub fn half_space(permittivity: Complex<f64>, grazing_rad: f64) -> Self {
        let (s, cos) = libm::sincos(grazing_rad);
        let q = root(permittivity - cos * cos);
        let es = permittivity * s;
        let (horizontal, vertical) = half_space_pair(permittivity, s, cos);
        Self {
            horizontal,
            vertical,
            one_plus_horizontal: Complex::new(2.0 * s, 0.0) / (q + s),
            one_plus_vertical: es * 2.0 / (es + q),
        }
    }

    /// A smooth film of `film` permittivity and thickness `thickness_m` on `base` (Airy's formula).
    #[must_use]
    pub fn film(
        film: Complex<f64>,
        base: Complex<f64>,
        thickness_m: f64,
        wavelength_m: f64,
        grazing_rad: f64,
    ) -> Self {
        let (s, cos) = libm::sincos(grazing_rad);
        let layers = Layers::new(film, base, thickness_m, wavelength_m, s, cos);
        let (horizontal, vertical) = layers.pair();
        // 1 + Γ = (1 + Γ₁₂)(1 + Γ₂₃P)/(1 + Γ₁₂Γ₂₃P): no cancelling at small grazing angles.
        let one = Complex::new(1.0, 0.0);
        let one_plus = |top: Complex<f64>, (a, b): (Complex<f64>, Complex<f64>), g23| {
            let g23p: Complex<f64> = g23;
            top / b * (one + g23p) / (one + a / b * g23p)
        };
        let reflected = |(c, d): (Complex<f64>, Complex<f64>)| c / d * layers.turn;
        Self {
            horizontal,
            vertical,
            one_plus_horizontal: one_plus(
                Complex::new(2.0 * s, 0.0),
                layers.horizontal[0],
                reflected(layers.horizontal[1]),
            ),
            one_plus_vertical: one_plus(
                film * s * 2.0,
                layers.vertical[0],
                reflected(layers.vertical[1]),
            ),
        }
    }

    /// Same sense of circular polarisation, `(Γ_H + Γ_V)/2`.
    #[must_use]
    pub fn circular_same(&self) -> Complex<f64> {
        (self.horizontal + self.vertical) * 0.5
    }

    /// Opposite sense of circular polarisation, `(Γ_V − Γ_H)/2`.
    #[must_use]
    pub fn circular_opposite(&self) -> Complex<f64> {
        (self.one_plus_vertical - self.one_plus_horizontal) * 0.5
    }
}

/// Coefficients of both linear polarisations for a half space, from sine and cosine of the grazing
/// angle: what a budget asks for.
#[must_use]
pub fn half_space_pair(
    permittivity: Complex<f64>,
    sin: f64,
    cos: f64,
) -> (Complex<f64>, Complex<f64>) {
    let q = root(permittivity - cos * cos);
    let es = permittivity * sin;
    ((-q + sin) / (q + sin), (es - q) / (es + q))
}

/// The same for a film on a base.
#[must_use]
pub fn film_pair(
    film: Complex<f64>,
    base: Complex<f64>,
    thickness_m: f64,
    wavelength_m: f64,
    sin: f64,
    cos: f64,
) -> (Complex<f64>, Complex<f64>) {
    Layers::new(film, base, thickness_m, wavelength_m, sin, cos).pair()
}

type Fraction = (Complex<f64>, Complex<f64>);

/// Reflections at the two faces of a film as fractions, and the way through it and back.
struct Layers {
    horizontal: [Fraction; 2],
    vertical: [Fraction; 2],
    turn: Complex<f64>,
}

impl Layers {
    fn new(
        film: Complex<f64>,
        base: Complex<f64>,
        thickness_m: f64,
        wavelength_m: f64,
        sin: f64,
        cos: f64,
    ) -> Self {
        let (q1, q2) = (root(film - cos * cos), root(base - cos * cos));
        // exp(−2j·k·t·q₁), written out to stay on libm.
        let turn = q1 * (2.0 * 2.0 * PI / wavelength_m * thickness_m);
        let (sin_re, cos_re) = libm::sincos(-turn.re);
        let (fs, bq, fq) = (film * sin, base * q1, film * q2);
        Self {
            horizontal: [(-q1 + sin, q1 + sin), (q1 - q2, q1 + q2)],
            vertical: [(fs - q1, fs + q1), (bq - fq, bq + fq)],
            turn: Complex::new(cos_re, sin_re) * libm::exp(turn.im),
        }
    }

    /// `(Γ₁₂ + Γ₂₃P)/(1 + Γ₁₂Γ₂₃P)` as one fraction.
    fn pair(&self) -> (Complex<f64>, Complex<f64>) {
        let airy = |[(a, b), (c, d)]: [Fraction; 2]| {
            let turned = c * self.turn;
            (a * d + b * turned) / (b * d + a * turned)
        };
        (airy(self.horizontal), airy(self.vertical))
    }
}

/// Square root with a non-positive imaginary part and, for positive real numbers, a positive real part.
fn root(z: Complex<f64>) -> Complex<f64> {
    let modulus = modulus(z);
    // The larger part from the sum, the smaller from the product: no cancelling on either axis.
    if z.re >= 0.0 {
        let re = (0.5 * (modulus + z.re)).sqrt();
        if re == 0.0 {
            return Complex::new(0.0, 0.0);
        }
        // With ε'' ≥ 0 the imaginary part is already not positive.
        Complex::new(re, 0.5 * z.im / re)
    } else {
        let im = (0.5 * (modulus - z.re)).sqrt();
        Complex::new(0.5 * z.im.abs() / im, -im)
    }
}

/// Modulus of a complex number, on `libm`.
#[must_use]
pub fn modulus(z: Complex<f64>) -> f64 {
    (z.re * z.re + z.im * z.im).sqrt()
}

/// Argument of a complex number, on `libm`.
#[must_use]
pub fn argument(z: Complex<f64>) -> f64 {
    libm::atan2(z.im, z.re)
}

/// How roughness weakens the specular reflection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Roughness {
    /// Perfectly smooth.
    Smooth,
    /// Ament (1953): `exp(−2u²)`.
    Ament,
    /// Miller, Brown & Vegh (1984): `exp(−2u²)·I₀(2u²)`.
    #[default]
    MillerBrownVegh,
}

impl Roughness {
    /// Factor on the reflected amplitude for rms height `height_m` at a grazing angle,
    /// `u = 2π·σ_h·sin ψ/λ`.
    #[must_use]
    pub fn factor(self, height_m: f64, wavelength_m: f64, grazing_rad: f64) -> f64 {
        self.factor_sin(height_m, wavelength_m, libm::sin(grazing_rad))
    }

    /// The same from `sin ψ`.
    #[must_use]
    pub fn factor_sin(self, height_m: f64, wavelength_m: f64, sin_grazing: f64) -> f64 {
        let u = 2.0 * PI * height_m * sin_grazing / wavelength_m;
        match self {
            Self::Smooth => 1.0,
            Self::Ament => libm::exp(-2.0 * u * u),
            Self::MillerBrownVegh => crate::special::i0e(2.0 * u * u),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_of_no_thickness_is_the_bare_base() {
        let base = MATERIALS[1].permittivity(16.0);
        let water = crate::environment::fog::water_permittivity(16.0, 288.15);
        for grazing in [1e-9, 0.001, 0.03, 0.5, 1.5] {
            let bare = Fresnel::half_space(base, grazing);
            let film = Fresnel::film(water, base, 0.0, 0.01874, grazing);
            assert!(modulus(bare.horizontal - film.horizontal) < 1e-14, "{grazing}");
            assert!(modulus(bare.vertical - film.vertical) < 1e-14, "{grazing}");
        }
    }

    #[test]
    fn nothing_reflects_more_than_it_receives() {
        for material in &MATERIALS {
            for carrier in [1.0, 9.0, 16.0] {
                for grazing in [0.0, 1e-12, 0.01, 0.4, std::f64::consts::FRAC_PI_2] {
                    let f = Fresnel::half_space(material.permittivity(carrier), grazing);
                    for g in [f.horizontal, f.vertical] {
                        assert!(modulus(g) <= 1.0 + 1e-15, "{} {grazing} {g}", material.name);
                    }
                }
            }
        }
    }
}
