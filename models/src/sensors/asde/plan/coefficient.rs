//! The surface's reflection coefficients over a range of grazing angles, enclosed.

use super::disc::{Disc, Sloped};
use crate::environment::surface::{self, Complex};
use crate::sensors::radar::equation::{Air, Polarisation, Radar};
use std::f64::consts::PI;

/// The coefficients over a range of the sine of the grazing angle: index 0 as they are, 1 with the film
/// (first index), the polarisation (second index) left out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coefficients {
    /// Where each is.
    pub of: [[Disc; 2]; 2],
    /// Largest modulus of each one's slope by the sine.
    pub slope: [[f64; 2]; 2],
    /// What leaving the film out changes, by polarisation.
    pub by_film: [Disc; 2],
    /// What leaving the polarisation out changes, by film.
    pub by_polarisation: [Disc; 2],
}

/// A coefficient: in the middle of the range, and its slope over the range.
#[derive(Clone, Copy)]
struct One {
    middle: Complex<f64>,
    slope: Disc,
}

impl One {
    fn mean(self, other: Self) -> Self {
        let half = Disc::about(0.5, 0.0);
        Self {
            middle: (self.middle + other.middle) * 0.5,
            slope: (self.slope + other.slope) * half,
        }
    }

    fn disc(self, half: f64) -> Disc {
        Disc { centre: self.middle, radius: self.slope.most() * half }
    }

    fn less(self, other: Self, half: f64) -> Disc {
        let slope = self.slope - other.slope;
        Disc { centre: self.middle - other.middle, radius: slope.most() * half }
    }
}

impl Coefficients {
    /// Between two sines.
    pub(super) fn over(radar: &Radar, air: &Air, low: f64, high: f64) -> Self {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let cos = (1.0 - middle * middle).max(0.0).sqrt();
        let s = Sloped::number(middle, half);
        let own = |(h, v): (One, One)| match radar.polarisation {
            Polarisation::Horizontal => [h, h],
            Polarisation::Vertical => [v, h],
            Polarisation::Circular => [h.mean(v), h],
        };
        let pair = |values: (Complex<f64>, Complex<f64>), (h, v): (Sloped, Sloped)| {
            let one = |middle, of: Sloped| One { middle, slope: of.slope };
            own((one(values.0, h), one(values.1, v)))
        };
        let bare =
            pair(surface::half_space_pair(air.surface, middle, cos), half_space(air.surface, s));
        let film_m = air.weather.film_mm / 1000.0;
        let wet = if film_m > 0.0 {
            let values =
                surface::film_pair(air.film, air.surface, film_m, radar.wavelength_m, middle, cos);
            pair(values, film(air.film, air.surface, 4.0 * PI / radar.wavelength_m * film_m, s))
        } else {
            bare
        };
        let both = [wet, bare];
        Self {
            of: both.map(|of| of.map(|one| one.disc(half))),
            slope: both.map(|of| of.map(|one| one.slope.most())),
            by_film: [0, 1].map(|p| if film_m > 0.0 { wet[p].less(bare[p], half) } else { NONE }),
            by_polarisation: both.map(|of| {
                let differ = radar.polarisation != Polarisation::Horizontal;
                if differ { of[0].less(of[1], half) } else { NONE }
            }),
        }
    }
}

const NONE: Disc = Disc { centre: Complex::new(0.0, 0.0), radius: 0.0 };

/// `√(ε − cos²ψ)`.
fn below(permittivity: Complex<f64>, s: Sloped) -> Sloped {
    (Sloped::fixed(permittivity - 1.0) + s * s).root()
}

fn half_space(permittivity: Complex<f64>, s: Sloped) -> (Sloped, Sloped) {
    let q = below(permittivity, s);
    let es = Sloped::fixed(permittivity) * s;
    ((s - q) / (s + q), (es - q) / (es + q))
}

/// Airy's formula; `turns` is twice the wave number times the thickness.
fn film(film: Complex<f64>, base: Complex<f64>, turns: f64, s: Sloped) -> (Sloped, Sloped) {
    let (q1, q2) = (below(film, s), below(base, s));
    let turn = (Sloped::fixed(Complex::new(0.0, -turns)) * q1).exp();
    let (film, base) = (Sloped::fixed(film), Sloped::fixed(base));
    let airy = |top: Sloped, bottom: Sloped| {
        let turned = bottom * turn;
        (top + turned) / (Sloped::fixed(Complex::new(1.0, 0.0)) + top * turned)
    };
    let fs = film * s;
    (
        airy((s - q1) / (s + q1), (q1 - q2) / (q1 + q2)),
        airy((fs - q1) / (fs + q1), (base * q1 - film * q2) / (base * q1 + film * q2)),
    )
}
