//! What the surface reflection and each of its refinements can change over a piece of a box.
//!
//! Everything is enclosed: angles are monotone in distance and height, the surface's coefficients lie in
//! discs (`Coefficients`), gains follow from the slopes of their logarithms (mean value form). Differences
//! of two levels are never differences of two enclosures, but the enclosed difference through the derivative
//! of the propagation factor, which holds the moduli and the phases of the two apart.

use super::coefficient::Coefficients;
use super::disc::Disc;
use crate::environment::surface::{Roughness, modulus};
use crate::sensors::radar::detection::to_db;
use crate::sensors::radar::equation::{Air, Polarisation, Radar};
use crate::sensors::radar::geometry::EFFECTIVE_EARTH_RADIUS_M;
use crate::sensors::radar::propagation;
use crate::sensors::radar::span::Span;
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

/// A piece of a box: between two ground distances and two heights, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Nearest and farthest ground distance.
    pub ground_m: (f64, f64),
    /// Lowest and highest middle of the echo.
    pub height_m: (f64, f64),
}

/// What the curvature of the earth changes over a piece, at most.
#[derive(Clone, Copy, Debug)]
struct Bent {
    /// Sine of the grazing angle: it only falls.
    sine: f64,
    /// Divergence, at least.
    divergence: f64,
    /// Phase of the path, rad.
    turn: f64,
    /// Factor of the roughness.
    rough: f64,
    /// Logarithm of the amplitude by the antenna's gain.
    gain: f64,
}

/// The reflected ray over a piece, enclosed.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// Where it is.
    pub reach: Reach,
    /// One-way elevation gain towards the targets.
    pub gain: Span,
    gamma: Coefficients,
    /// Factor of the roughness.
    rough: Span,
    /// Amplitude of the antenna's gain along the reflected ray over that along the direct one.
    up: Span,
    bent: Bent,
    wet: bool,
    other: bool,
}

/// `√(x² + y²)` of ordinary numbers.
fn hypotenuse(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

fn product(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    let all = Span::around([a.0 * b.0, a.0 * b.1, a.1 * b.0, a.1 * b.1].into_iter());
    (all.low, all.high)
}

impl Piece {
    /// Encloses everything over a piece.
    #[must_use]
    pub fn new(radar: &Radar, air: &Air, reach: Reach) -> Self {
        let ((near, far), (low, high)) = (reach.ground_m, reach.height_m);
        let antenna = radar.antenna_m;
        let sine = |up: f64, d: f64| up / hypotenuse(up, d).max(1e-9);
        // The grazing angle falls with the distance and grows with the height.
        let (up_low, up_high) = (antenna + low, antenna + high);
        let flat = Span { low: sine(up_low, far), high: sine(up_high, near) };
        // The depression falls with the height, its size with the distance.
        let (down_low, down_high) = (antenna - high, antenna - low);
        let down = Span::around(
            [
                sine(down_low, near),
                sine(down_low, far),
                sine(down_high, near),
                sine(down_high, far),
            ]
            .into_iter(),
        );
        let towards = |s: f64| radar.by_sine.elevation(s);
        let ends = Span::around([towards(down.low), towards(down.high)].into_iter());
        let axis = libm::sin(radar.pattern.axis_rad);
        let over_axis = down.low <= axis && axis <= down.high;
        let gain = Span { low: ends.low, high: if over_axis { 1.0 } else { ends.high } };

        let (lowered, sine_fall) = lowered(antenna, reach);
        let rise = up_low - lowered;
        let grazing = Span { low: sine(rise.max(0.0), far), high: flat.high };
        let gamma = Coefficients::over(radar, air, grazing.low, grazing.high);

        let rough_at = |s: f64| {
            let form = Roughness::MillerBrownVegh;
            form.factor_sin(radar.roughness_m, radar.wavelength_m, s)
        };
        let rough = match radar.roughness_m {
            0.0 => Span { low: 1.0, high: 1.0 },
            _ => Span { low: rough_at(grazing.high), high: rough_at(grazing.low) },
        };
        // Convex and falling in the square of the sine: it changes most where that is least.
        let rough_bent = match radar.roughness_m {
            0.0 => 0.0,
            _ => {
                let square = grazing.low * grazing.low;
                let more = square + sine_fall * (2.0 * flat.high + sine_fall);
                rough_at(grazing.low) - rough_at(more.sqrt())
            }
        };

        // Logarithm of the amplitude by gains: its value in the middle and its slopes.
        let (d, h) = ((near * far).sqrt(), 0.5 * (low + high));
        let middle = 0.5 * libm::log(towards(sine(antenna + h, d)) / towards(sine(antenna - h, d)));
        let (up_slope, down_slope) = (
            radar.by_sine.log_slope(grazing.low, flat.high),
            radar.by_sine.log_slope(down.low, down.high),
        );
        let cos2 = |s: Span| {
            let most =
                if s.low <= 0.0 && s.high >= 0.0 { 0.0 } else { s.low.abs().min(s.high.abs()) };
            let least = s.low.abs().max(s.high.abs());
            (1.0 - least * least, 1.0 - most * most)
        };
        let along = |slope: (f64, f64), s: Span| product(product(slope, (s.low, s.high)), cos2(s));
        let (a, b) = (along(up_slope, flat), along(down_slope, down));
        let by_distance = (a.1 - b.0).abs().max((a.0 - b.1).abs());
        let least_down = if down_low <= 0.0 && down_high >= 0.0 {
            0.0
        } else {
            down_low.abs().min(down_high.abs())
        };
        let raised = |slope: (f64, f64), s: Span, up: f64| {
            let of = product(slope, cos2(s));
            of.0.abs().max(of.1.abs()) / hypotenuse(near, up).max(1e-9)
        };
        let by_height = raised(up_slope, flat, up_low) + raised(down_slope, down, least_down);
        let beside = 0.25 * (libm::log(far / near) * by_distance + (high - low) * by_height);
        let up = Span { low: libm::exp(middle - beside), high: libm::exp(middle + beside) };
        let steepest = up_slope.0.abs().max(up_slope.1.abs());

        let bent = if rise > 0.0 {
            let (long, short) = (antenna.max(low), high.min(antenna));
            let (big, small) = if antenna >= high { (antenna, high) } else { (long, short) };
            let over = far * far / (2.0 * EFFECTIVE_EARTH_RADIUS_M);
            // Over a round earth the smaller height counts for more, by at most the fall of the larger.
            let more = if big > over { big / (big - over) } else { f64::INFINITY };
            let share = (small / big.max(1e-9) * more).min(1.0);
            let parts = share / ((1.0 + share) * (1.0 + share));
            let apart = 2.0 * far * parts / (EFFECTIVE_EARTH_RADIUS_M * grazing.low.max(1e-12));
            let bent_m =
                far * antenna * high / (EFFECTIVE_EARTH_RADIUS_M * (antenna + high).max(1e-9));
            let whole_m = 2.0 * antenna * high / near.max(1e-9);
            Bent {
                sine: sine_fall,
                divergence: 1.0 / (1.0 + apart).sqrt(),
                turn: TAU / radar.wavelength_m * (1.02 * bent_m).min(whole_m),
                rough: rough_bent,
                gain: 0.5 * steepest * sine_fall,
            }
        } else {
            // At the horizon, and beyond it, nothing is said.
            let all = f64::INFINITY;
            Bent { sine: all, divergence: 0.0, turn: all, rough: 1.0, gain: all }
        };
        Self {
            reach,
            gain,
            gamma,
            rough,
            up,
            bent,
            wet: air.weather.film_mm > 0.0,
            other: radar.polarisation != Polarisation::Horizontal,
        }
    }
}

/// By how much both heights together are less over a round earth than over a flat one, and by how much
/// the sine of the grazing angle falls, at most.
fn lowered(antenna_m: f64, reach: Reach) -> (f64, f64) {
    let ((_, far), (low, high)) = (reach.ground_m, reach.height_m);
    // The point of reflection lies between that over a flat earth and the middle.
    let squares = |h: f64| {
        let t = antenna_m / (antenna_m + h).max(1e-9);
        t * t + (1.0 - t) * (1.0 - t)
    };
    let share = squares(low).max(squares(high));
    let lowered = far * far * share / (2.0 * EFFECTIVE_EARTH_RADIUS_M);
    (lowered, far * share / (2.0 * EFFECTIVE_EARTH_RADIUS_M))
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

/// Swing of the propagation factor by its phase, by amplitude and factors of the extent.
fn swing(q: f64, a: f64, b: f64) -> f64 {
    4.0 * q * (1.0 + q * q) * a + 2.0 * q * q * b
}

/// Parts into which a range of amplitudes is cut for the least factor over it.
const PARTS: u32 = 8;

/// Least value of `1 + 4q² + q⁴` less its swing between two amplitudes: in each part the value in the
/// middle less half the part times the largest slope.
fn least_factor(low: f64, high: f64, a: f64, b: f64) -> f64 {
    let half = 0.5 * (high - low) / f64::from(PARTS);
    let part = |i: u32| {
        let q = low + half * f64::from(2 * i + 1);
        let (from, to) = (q - half, q + half);
        let grows = |q: f64| 8.0 * q + 4.0 * q * q * q;
        let falls = |q: f64| 4.0 * a * (1.0 + 3.0 * q * q) + 4.0 * b * q;
        let slope = (grows(to) - falls(from)).abs().max((grows(from) - falls(to)).abs());
        propagation::incoherent(q) - swing(q, a, b) - slope * half
    };
    (0..PARTS).map(part).fold(f64::INFINITY, f64::min)
}

impl Piece {
    /// The bounds for a body of vertical extent `extent_m`, while the others of the refinements in `open`
    /// (bit n for refinement n) may be left out too.
    #[must_use]
    pub fn bounds(&self, radar: &Radar, extent_m: f64, open: usize) -> ReflectionBounds {
        let is_open = |r: Refinement| open >> r as usize & 1 == 1;
        let films = if is_open(Refinement::Film) && self.wet { 2 } else { 1 };
        let polarisations = if is_open(Refinement::Polarisation) && self.other { 2 } else { 1 };
        let (gamma, bent) = (&self.gamma, &self.bent);
        let states = || (0..films).flat_map(move |f| (0..polarisations).map(move |p| (f, p)));
        let sizes = Span {
            low: states().map(|(f, p)| gamma.of[f][p].least()).fold(f64::INFINITY, f64::min),
            high: states().map(|(f, p)| gamma.of[f][p].most()).fold(0.0, f64::max),
        };
        let turned = libm::exp(bent.gain);
        let up = Span { low: self.up.low / turned, high: self.up.high * turned };
        let roughest = if is_open(Refinement::Roughness) { 1.0 } else { self.rough.high };
        let weight = up.high * roughest;
        let low = sizes.low * self.rough.low * up.low * bent.divergence;
        // A coefficient of a body that returns no more than it receives.
        let high = sizes.high.min(1.0) * weight;

        let far = self.reach.ground_m.1.max(1.0);
        let spread =
            propagation::phase_spread_rad(radar.antenna_m, extent_m, radar.wavelength_m, far);
        let (a, b) = ((2.0 / spread).min(1.0), (1.0 / spread).min(1.0));
        // The share of the swing grows to amplitude 1 and falls beyond, alike for q and 1/q.
        let worst = if low > 1.0 { low } else { high.min(1.0) };
        let share = swing(worst, a, b) / propagation::incoherent(worst);
        let least = propagation::incoherent(low) * (1.0 - share).max(0.0);
        let most = propagation::incoherent(high) * (1.0 + share);
        let lowest = least_factor(low, high, a, b).max(least);
        let db_above = |factor: f64| if factor > 0.0 { -to_db(factor) } else { f64::INFINITY };

        let q2 = high * high;
        let by_change = 8.0 * high + 4.0 * high * q2 + a * (4.0 + 12.0 * q2) + 4.0 * high * b;
        let by_phase = 4.0 * high * (1.0 + q2) * a + 4.0 * q2 * b;
        // Change of the amplitude, and of the factor: by the whole change, or by amplitude and phase apart.
        let differ = |one: Apart, weight: f64| {
            let moved =
                (by_change * one.apart).min(by_change * one.sizes + by_phase * one.turn / weight);
            (one.sizes * weight, moved * weight)
        };
        let worse = |a: (f64, f64), b: (f64, f64)| (a.0.max(b.0), a.1.max(b.1));
        let mut found = [(0.0, 0.0); 4];
        let rough = sizes.high * up.high * (1.0 - self.rough.low);
        found[Refinement::Roughness as usize] = (rough, by_change * rough);
        if self.wet && is_open(Refinement::Film) {
            found[Refinement::Film as usize] = (0..polarisations)
                .map(|p| {
                    differ(
                        Apart::of(&gamma.of[0][p], &gamma.of[1][p], gamma.by_film[p].most()),
                        weight,
                    )
                })
                .fold((0.0, 0.0), worse);
        }
        if self.other && is_open(Refinement::Polarisation) {
            found[Refinement::Polarisation as usize] = (0..films)
                .map(|f| {
                    let apart = gamma.by_polarisation[f].most();
                    differ(Apart::of(&gamma.of[f][0], &gamma.of[f][1], apart), weight)
                })
                .fold((0.0, 0.0), worse);
        }
        if is_open(Refinement::Curvature) {
            let by = |(f, p): (usize, usize)| {
                let size = gamma.of[f][p].most().min(1.0);
                let change = gamma.slope[f][p] * bent.sine * weight
                    + size * bent.rough * up.high
                    + size * weight * ((turned - 1.0) + (1.0 - bent.divergence));
                (change, by_change * change + by_phase * bent.turn.min(2.0))
            };
            found[Refinement::Curvature as usize] = states().map(by).fold((0.0, 0.0), worse);
        }
        let refined_db = Refinement::ALL.map(|r| {
            let moved = found[r as usize].1;
            match () {
                () if !is_open(r) => f64::INFINITY,
                () if moved == 0.0 => 0.0,
                () if lowest > 0.0 => 10.0 / LN_10 * moved / lowest,
                () => f64::INFINITY,
            }
        });
        ReflectionBounds {
            factor: Span { low: lowest.max(0.0), high: most },
            reflection_db: (db_above(lowest).max(0.0), to_db(most).max(0.0)),
            lobing_db: (db_above(1.0 - share), to_db(1.0 + share)),
            refined_db,
            change: found.map(|f| f.0),
            most: high,
        }
    }
}

/// How far two coefficients are apart.
#[derive(Clone, Copy, Debug)]
struct Apart {
    /// In the plane.
    apart: f64,
    /// In modulus.
    sizes: f64,
    /// In angle, rad, as far as it counts: two cosines differ by at most 2.
    turn: f64,
}

impl Apart {
    fn of(a: &Disc, b: &Disc, apart: f64) -> Self {
        let centres = (modulus(a.centre) - modulus(b.centre)).abs();
        let sizes = (centres + a.radius + b.radius).min(apart);
        Self { apart, sizes, turn: a.turn(b).min(2.0) }
    }
}

impl ReflectionBounds {
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
