//! What the surface reflection and each of its refinements can change over a piece of a box.
//!
//! Amplitudes of the reflected ray, without the phase of its path, are smooth functions of distance and
//! height: they are enclosed by their values at the corners of a piece and a part of what they differ there.
//! Differences of two levels are never differences of two enclosures, but the enclosed difference through
//! the derivative of the propagation factor (mean value form).

use super::bounds::{Enclosed, Span};
use crate::environment::surface::{self, Complex, Roughness};
use crate::sensors::detection::to_db;
use crate::sensors::geometry::{LeanPaths, RoundEarth};
use crate::sensors::propagation;
use crate::sensors::radar_equation::{
    Air, BudgetLevels, Polarisation, Radar, ReflectedPolarisation,
};
use std::f64::consts::{LN_10, TAU};

/// A refinement of the reflection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refinement {
    /// Roughness of the surface.
    Roughness,
    /// Water film.
    Film,
    /// The coefficient of the radar's own polarisation.
    Polarisation,
    /// Curvature of the earth.
    Curvature,
}

impl Refinement {
    /// The bits of all of them.
    pub const ANY: usize = 15;
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Roughness, Self::Film, Self::Polarisation, Self::Curvature];
}

/// Amplitudes of the reflected ray at one place for every combination of refinements: bit n of the
/// index is set where refinement n is left out.
#[derive(Clone, Copy, Debug)]
struct Amplitudes {
    z: [Complex<f64>; 16],
    /// By how much the curvature turns the phase of the path, rad.
    turn_rad: f64,
    /// One-way elevation gain towards the target.
    gain: f64,
}

impl Amplitudes {
    fn at(radar: &Radar, air: &Air, d_m: f64, height_m: f64) -> Self {
        let flat = LeanPaths::flat(d_m, radar.antenna_m, height_m);
        let (round, divergence) = RoundEarth::lean(d_m, radar.antenna_m, height_m);
        let gain = radar.by_sine.elevation(flat.sin_depression);
        let mut z = [Complex::new(0.0, 0.0); 16];
        let wet = air.weather.film_mm > 0.0;
        let own_is_other = radar.polarisation != Polarisation::Horizontal;
        for (curvature, paths, divergence) in [(0, &round, divergence), (8, &flat, 1.0)] {
            let up = (radar.by_sine.elevation(paths.sin_grazing) / gain).sqrt() * divergence;
            let rough = if radar.roughness_m == 0.0 {
                1.0
            } else {
                let form = Roughness::MillerBrownVegh;
                form.factor_sin(radar.roughness_m, radar.wavelength_m, paths.sin_grazing)
            };
            for film in 0..2 {
                for polarisation in 0..2 {
                    let index = curvature + 2 * film + 4 * polarisation;
                    let smooth = if film == 1 && !wet {
                        z[curvature + 4 * polarisation + 1]
                    } else if polarisation == 1 && !own_is_other {
                        z[curvature + 2 * film + 1]
                    } else {
                        let levels = BudgetLevels {
                            film: film == 0,
                            reflected: if polarisation == 0 {
                                ReflectedPolarisation::Own
                            } else {
                                ReflectedPolarisation::Horizontal
                            },
                            ..BudgetLevels::EXACT
                        };
                        let (sin, cos) = (paths.sin_grazing, paths.cos_grazing);
                        radar.surface_coefficient_at(air, &levels, sin, cos) * up
                    };
                    z[index] = smooth * rough;
                    z[index + 1] = smooth;
                }
            }
        }
        let turn_rad = TAU / radar.wavelength_m * (flat.difference_m - round.difference_m).abs();
        Self { z, turn_rad, gain }
    }

    /// Largest change of the amplitude by a refinement, whichever of `open` the others leave out.
    fn change(&self, refinement: Refinement, open: usize) -> f64 {
        let bit = 1 << refinement as usize;
        (0..16)
            .filter(|i| i & bit == 0 && i & !open == 0)
            .map(|i| surface::modulus(self.z[i] - self.z[i | bit]))
            .fold(0.0, f64::max)
    }

    /// Least and largest amplitude, whichever of `open` are left out.
    fn modulus(&self, open: usize) -> (f64, f64) {
        let sizes = (0..16).filter(|i| i & !open == 0).map(|i| surface::modulus(self.z[i]));
        sizes.fold((f64::INFINITY, 0.0), |(low, high), q| (f64::min(low, q), f64::max(high, q)))
    }
}

/// What one column of a grid over a box holds: all heights at one distance.
#[derive(Clone, Debug)]
pub struct Column {
    /// Ground distance, m.
    pub d_m: f64,
    at: Vec<Amplitudes>,
}

impl Column {
    /// The amplitudes at some heights.
    #[must_use]
    pub fn new(radar: &Radar, air: &Air, d_m: f64, heights_m: &[f64]) -> Self {
        Self { d_m, at: heights_m.iter().map(|&h| Amplitudes::at(radar, air, d_m, h)).collect() }
    }

    /// Least and largest elevation gain of the column.
    #[must_use]
    pub fn gain(&self) -> Span {
        Span::around(self.at.iter().map(|a| a.gain))
    }
}

/// The reflection over a piece of a box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReflectionBounds {
    /// Least and largest propagation factor of everything exact.
    pub factor: Span,
    /// Left out altogether: too high, too low, dB.
    pub reflection_db: (f64, f64),
    /// Its phase left out.
    pub lobing_db: (f64, f64),
    /// Each refinement left out, either way, dB.
    pub refined_db: [f64; 4],
    /// Change of the amplitude by each refinement.
    pub change: [f64; 4],
    /// Largest amplitude.
    pub most: f64,
}

/// What a change of the amplitude was seen to have between corners that are alike: up to 2e-4 over random boxes.
const BETWEEN_CORNERS: f64 = 2.5e-4;

/// Swing of the propagation factor by its phase, by amplitude and factors of the extent.
fn swing(q: f64, a: f64, b: f64) -> f64 {
    4.0 * q * (1.0 + q * q) * a + 2.0 * q * q * b
}

impl ReflectionBounds {
    /// Over the piece between two columns, for a body of vertical extent `extent_m`, while the others of
    /// the refinements in `open` (bit n for refinement n) may be left out too.
    #[must_use]
    pub fn between(radar: &Radar, near: &Column, far: &Column, extent_m: f64, open: usize) -> Self {
        let corners = || near.at.iter().chain(&far.at);
        let q = Enclosed::of(corners().map(|a| a.modulus(open).0))
            .span
            .and(Enclosed::of(corners().map(|a| a.modulus(open).1)).span);
        let (low, high) = (q.low.max(0.0), q.high);
        let spread = propagation::phase_spread_rad(
            radar.antenna_m,
            extent_m,
            radar.wavelength_m,
            far.d_m.max(1.0),
        );
        let (a, b) = ((2.0 / spread).min(1.0), (1.0 / spread).min(1.0));
        // The share of the swing grows to amplitude 1 and falls beyond, alike for q and 1/q.
        let worst = if low > 1.0 { low } else { high.min(1.0) };
        let share = swing(worst, a, b) / propagation::incoherent(worst);
        let least = propagation::incoherent(low) * (1.0 - share).max(0.0);
        let most = propagation::incoherent(high) * (1.0 + share);
        // The factor itself, for its least value over the piece.
        let f = |q: f64| propagation::incoherent(q) - swing(q, a, b);
        let samples =
            [0, 1, 2, 3, 4, 5, 6, 7, 8].map(|i| f(low + (high - low) * f64::from(i) / 8.0));
        let jump = samples.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
        let lowest = (Span::around(samples.into_iter()).low - 0.5 * jump).max(least);
        let db_above = |factor: f64| if factor > 0.0 { -to_db(factor) } else { f64::INFINITY };
        let q2 = high * high;
        let by_z = 8.0 * high + 4.0 * high * q2 + a * (4.0 + 12.0 * q2) + 4.0 * high * b;
        let by_phase = 4.0 * high * (1.0 + q2) * a + 4.0 * q2 * b;
        let turn = Enclosed::of(corners().map(|a| a.turn_rad)).span.high.min(2.0);
        // A largest value of several combinations has corners of its own between those of the piece.
        let change = Refinement::ALL.map(|r| {
            let seen = Span::around(corners().map(|a| a.change(r, open)));
            let margin = if seen.high > 0.0 { BETWEEN_CORNERS } else { 0.0 };
            2.0 * seen.high - seen.low + margin
        });
        let refined_db = [0, 1, 2, 3].map(|i| {
            if open >> i & 1 == 0 {
                return f64::INFINITY;
            }
            let turned = if i == Refinement::Curvature as usize { by_phase * turn } else { 0.0 };
            let moved = by_z * change[i] + turned;
            if moved == 0.0 {
                0.0
            } else if lowest > 0.0 {
                10.0 / LN_10 * moved / lowest
            } else {
                f64::INFINITY
            }
        });
        Self {
            factor: Span { low: lowest, high: most },
            reflection_db: (db_above(lowest).max(0.0), to_db(most).max(0.0)),
            lobing_db: (db_above(1.0 - share), to_db(1.0 + share)),
            refined_db,
            change,
            most: high,
        }
    }

    /// Both together: the worse of everything.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        let pair = |a: (f64, f64), b: (f64, f64)| (a.0.max(b.0), a.1.max(b.1));
        Self {
            factor: self.factor.and(other.factor),
            reflection_db: pair(self.reflection_db, other.reflection_db),
            lobing_db: pair(self.lobing_db, other.lobing_db),
            refined_db: [0, 1, 2, 3].map(|i| self.refined_db[i].max(other.refined_db[i])),
            change: [0, 1, 2, 3].map(|i| self.change[i].max(other.change[i])),
            most: self.most.max(other.most),
        }
    }
}
