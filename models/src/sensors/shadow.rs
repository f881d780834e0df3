//! What stands between radar and target: knife-edge diffraction, buildings, other aircraft.

use crate::special::fresnel_tail;

/// Parameter of a knife edge: `ν = h·√(2(d₁+d₂)/(λ·d₁·d₂))`.
///
/// `height_m` of the edge above the line of sight (negative: clear of it), `d1_m` and `d2_m` to the
/// two ends; both are taken as at least one wavelength. Source: ITU-R P.526-15, eq. (26).
#[must_use]
pub fn knife_edge_parameter(height_m: f64, d1_m: f64, d2_m: f64, wavelength_m: f64) -> f64 {
    let (d1, d2) = (d1_m.max(wavelength_m), d2_m.max(wavelength_m));
    height_m * (2.0 * (d1 + d2) / (wavelength_m * d1 * d2)).sqrt()
}

/// One-way loss behind a knife edge, dB: `6.9 + 20·log₁₀(√((ν−0.1)²+1) + ν − 0.1)`, 0 below ν = −0.78.
///
/// Source: ITU-R P.526-15, eq. (31); within 0.13 dB of the Fresnel integral up to ν = 5.
#[must_use]
pub fn knife_edge_db(v: f64) -> f64 {
    if v <= -0.78 {
        return 0.0;
    }
    let x = v - 0.1;
    6.9 + 20.0 * libm::log10((x * x + 1.0).sqrt() + x)
}

/// The same by the Fresnel integral: exact, with the ripple (gain) on the clear side.
#[must_use]
pub fn knife_edge_exact_db(v: f64) -> f64 {
    if v >= 0.0 {
        return -20.0 * libm::log10(fresnel_tail(v));
    }
    let (c, s) = crate::special::fresnel(v);
    -20.0 * libm::log10(0.5 * libm::hypot(1.0 - c - s, c - s))
}

/// Width of the transition at a knife edge, m: `√(λ·d₁·d₂/(d₁+d₂))`, the first Fresnel zone.
#[must_use]
pub fn transition_width_m(d1_m: f64, d2_m: f64, wavelength_m: f64) -> f64 {
    let (d1, d2) = (d1_m.max(wavelength_m), d2_m.max(wavelength_m));
    (wavelength_m * d1 * d2 / (d1 + d2)).sqrt()
}
