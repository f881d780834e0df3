//! What stands between radar and target: knife-edge diffraction, buildings, other aircraft.

use crate::environment::surface::Material;
use crate::frames::Vector2;
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

/// Something that stands on the airport: a footprint with vertical walls.
#[derive(Clone, Debug, PartialEq)]
pub struct Building {
    /// Name for people.
    pub name: String,
    /// Corners in order, airport frame, m; the last joins the first.
    pub footprint_m: Vec<Vector2<f64>>,
    /// Height above the surface, m.
    pub height_m: f64,
    /// What its walls are made of.
    pub facade: &'static Material,
}

impl Building {
    /// Walls as pairs of corners.
    pub fn walls(&self) -> impl Iterator<Item = (Vector2<f64>, Vector2<f64>)> + '_ {
        let n = self.footprint_m.len();
        (0..n).map(move |i| (self.footprint_m[i], self.footprint_m[(i + 1) % n]))
    }

    /// Area of the footprint, m².
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        0.5 * self.walls().map(|(a, b)| a.perp(&b)).sum::<f64>().abs()
    }

    /// Whether a place is inside the footprint.
    #[must_use]
    pub fn contains(&self, place_m: Vector2<f64>) -> bool {
        let crossings = self.walls().filter(|(a, b)| {
            (a.y > place_m.y) != (b.y > place_m.y)
                && place_m.x < a.x + (place_m.y - a.y) / (b.y - a.y) * (b.x - a.x)
        });
        crossings.count() % 2 == 1
    }
}
