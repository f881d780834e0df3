//! Bounds of every effect over one box, for the effect left out while all others are at any level.
//!
//! A box is cut into pieces of equal ratio of distance and of equal height, and everything is enclosed over
//! each: what grows or falls with distance or height alone by the end where it is worst, the rest by its
//! value in the middle and the largest slope of its logarithm. A test holds the bounds against random places
//! of random boxes.

use super::class::ClassFacts;
use super::reflection::{Piece, Reach, ReflectionBounds};
use crate::effects::{Level, Loss};
use crate::sensors::radar::detection::{from_db, to_db};
use crate::sensors::radar::effects::VALUES;
use crate::sensors::radar::effects::value::{ChangeSpan, EchoPlaces, EffectValue};
use crate::sensors::radar::equation::{Air, Radar, RainEcho};
use crate::sensors::radar::span::Span;

/// What a box is, for its bounds.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Nearest and farthest ground distance, m.
    pub ground_m: (f64, f64),
    /// Lowest and highest middle of the echo above the surface, m.
    pub height_m: (f64, f64),
    /// Whether rain cells touch the way.
    pub rain_on_way: bool,
    /// Whether rain cells touch the box.
    pub rain_here: bool,
}

/// The bounds of one box. Decibels are of the ratio of signal to clutter and noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BoxBounds {
    /// Slant range, m.
    pub range_m: Span,
    /// Ratio of everything exact, all aspects and phases of the reflection.
    pub ratio: Span,
    /// Rain attenuation left out: too high, dB.
    pub rain_db: f64,
    /// Rain attenuation by the straight line: too high, too low, dB.
    pub linear_db: (f64, f64),
    /// What every level of the effects that are values loses, in their order.
    pub values: [[Loss; 4]; VALUES.len()],
    /// Ground clutter left out beside that of the rain, dB.
    pub ground_db: f64,
    /// Rain clutter left out beside that of the ground, dB.
    pub rain_clutter_db: f64,
    /// Both left out, dB.
    pub clutter_db: f64,
    /// The reflection.
    pub reflection: ReflectionBounds,
    /// Largest clutter over noise of ground and rain, for people.
    pub clutter: (f64, f64),
}

/// Pieces of a box in distance.
const PIECES: usize = 6;
/// Largest height of a piece, as a share of the antenna's and the target's heights together.
const PIECE_HEIGHT: f64 = 0.08;
/// Most pieces of a box in height.
const MOST_HIGH: f64 = 4.0;

/// A box with the reflection over its pieces: what its bounds are made from.
#[derive(Debug)]
pub struct BoxGrid<'a> {
    radar: &'a Radar,
    air: &'a Air,
    correlation: f64,
    facts: &'a ClassFacts,
    place: Place,
    /// From near to far, and of each distance from low to high.
    pieces: Vec<Piece>,
}

impl<'a> BoxGrid<'a> {
    /// The grid of a class in a box. `correlation` is the factor on rain clutter before the detector.
    #[must_use]
    pub fn new(
        radar: &'a Radar,
        air: &'a Air,
        correlation: f64,
        facts: &'a ClassFacts,
        place: Place,
    ) -> Self {
        let (near, far) = place.ground_m;
        let (low, high) = place.height_m;
        let ratio = libm::log(far / near) / PIECES as f64;
        let at = |piece: usize| match piece {
            PIECES => far,
            _ => near * libm::exp(ratio * piece as f64),
        };
        let storeys = ((high - low) / (PIECE_HEIGHT * (radar.antenna_m + low)).max(1e-9)).ceil();
        let storeys = storeys.clamp(1.0, MOST_HIGH);
        let step = (high - low) / storeys;
        let pieces = (0..PIECES).flat_map(|i| {
            let ground_m = (at(i), at(i + 1));
            (0..storeys as u32).map(move |k| {
                let height_m = (low + step * f64::from(k), low + step * f64::from(k + 1));
                Piece::new(radar, air, Reach { ground_m, height_m })
            })
        });
        Self { radar, air, correlation, facts, place, pieces: pieces.collect() }
    }

    /// The bounds, while any of the refinements in `open` may be left out.
    #[must_use]
    pub fn bounds(&self, open: usize) -> BoxBounds {
        let &Self { radar, air, correlation, facts, ref place, .. } = self;
        let over = Over { radar, air, correlation, facts, place, open };
        let pieces = self.pieces.iter().map(|piece| over.bounds(piece));
        pieces.reduce(|sum, one| sum.and(&one)).unwrap_or_default()
    }

    /// The bounds of the reflection at the far end alone: for a fault that is planted.
    pub(super) fn far_end(&self, open: usize) -> ReflectionBounds {
        let extent_m = self.facts.class.height_m;
        self.pieces.last().map(|p| p.bounds(self.radar, extent_m, open)).unwrap_or_default()
    }
}

impl BoxBounds {
    /// The worse of everything.
    fn and(&self, other: &Self) -> Self {
        Self {
            range_m: self.range_m.and(other.range_m),
            ratio: self.ratio.and(other.ratio),
            rain_db: self.rain_db.max(other.rain_db),
            linear_db: (
                self.linear_db.0.max(other.linear_db.0),
                self.linear_db.1.max(other.linear_db.1),
            ),
            values: std::array::from_fn(|value| {
                let at = |level: usize| (&self.values[value][level], &other.values[value][level]);
                std::array::from_fn(|level| Loss::worse(at(level).0, at(level).1))
            }),
            ground_db: self.ground_db.max(other.ground_db),
            rain_clutter_db: self.rain_clutter_db.max(other.rain_clutter_db),
            clutter_db: self.clutter_db.max(other.clutter_db),
            reflection: self.reflection.and(&other.reflection),
            clutter: (self.clutter.0.max(other.clutter.0), self.clutter.1.max(other.clutter.1)),
        }
    }
}

/// Attenuation of `two_way_db` left out where clutter of `clutter` over noise, before attenuation, stays,
/// and everything together attenuates by `all_db`: too high by at most so much, dB.
#[must_use]
pub fn attenuation_raises_db(two_way_db: f64, all_db: f64, clutter: f64) -> f64 {
    two_way_db / (1.0 + clutter * from_db(-all_db))
}

/// Clutter of `skipped` over noise left out beside `kept`: too high by so much, dB.
#[must_use]
pub fn clutter_raises_db(skipped: f64, kept: f64) -> f64 {
    to_db(1.0 + skipped / (1.0 + kept))
}

/// Steps of the enclosure of a product of rounded factors.
const ROUNDING: f64 = 1e-9;

/// What the bounds of every piece are made with.
struct Over<'a> {
    radar: &'a Radar,
    air: &'a Air,
    correlation: f64,
    facts: &'a ClassFacts,
    place: &'a Place,
    open: usize,
}

/// What the losses of effects that are values are reckoned with.
struct Losses<'a> {
    /// Two-way attenuation by everything, at most, dB.
    all_db: f64,
    /// Clutter over noise before attenuation, at least.
    least_clutter: f64,
    /// Longest way, there and back, km.
    km2: f64,
    /// Over noise for a square metre, at most.
    most_of: f64,
    places: &'a EchoPlaces,
}

impl Over<'_> {
    fn bounds(&self, piece: &Piece) -> BoxBounds {
        let (radar, air, place) = (self.radar, self.air, self.place);
        let antenna_m = radar.antenna_m;
        let ((near_m, far_m), (low, high)) = (piece.reach.ground_m, piece.reach.height_m);
        // The line of sight falls least to the highest, most to the lowest.
        let (least_down, most_down) = (antenna_m - high, antenna_m - low);
        let down_near = if least_down <= 0.0 && most_down >= 0.0 {
            0.0
        } else {
            least_down.abs().min(most_down.abs())
        };
        let down_far = least_down.abs().max(most_down.abs());
        let range_m = Span { low: slant(near_m, down_near), high: slant(far_m, down_far) };
        let (r_near, r_far) = (range_m.low.max(1.0), range_m.high);
        let gain = piece.gain;
        let reflection = piece.bounds(radar, self.facts.class.height_m, self.open);

        // Attenuation, two-way, dB.
        let km2 = 2.0 * r_far / 1000.0;
        let uniform = air.uniform();
        let cells = place.rain_on_way && !air.weather.cells.is_empty();
        let (rain_db, least_rain) = if cells {
            // The steepest way of the piece is its nearest, at the greatest distance in height.
            let slope = slant(near_m.max(1.0), down_far) / near_m.max(1.0);
            let most = 2.0 * air.most_rain_db(r_far, slope);
            (most, uniform.mie_db_per_km.min(air.least_rain_db_per_km()))
        } else {
            (uniform.mie_db_per_km * km2, uniform.mie_db_per_km)
        };
        let line_db = air.linear_db_per_km() * km2;
        let nearest_line_db = match cells {
            true => air.linear_db_per_km() * 2.0 * r_near / 1000.0,
            false => line_db,
        };
        let all_db = (0..VALUES.len())
            .fold(rain_db.max(line_db), |sum, value| sum + self.most_db_per_km(value) * km2);
        let least_db_per_km =
            (0..VALUES.len()).fold(least_rain, |sum, value| sum + air.exact_db_per_km(value));
        let least_db = least_db_per_km * 2.0 * r_near / 1000.0;
        let span = |low: f64, high: f64| Span { low, high };
        let places = EchoPlaces {
            range_m: span(r_near, r_far),
            ground_m: span(near_m, far_m),
            height_m: span(low, high),
        };
        let exact = self.exact_spans(&places);
        // Clutter of a cross section over noise, before attenuation, at most and at least.
        let per_m2 = radar.constant / radar.noise_w;
        let fourth = |r: f64| (r * r) * (r * r);
        let (most_of, least_of) = (per_m2 / fourth(r_near), per_m2 / fourth(r_far));
        let other = exact.iter().fold(Span::default(), |sum, of| Span {
            low: sum.low + of.clutter_m2.low * least_of,
            high: sum.high + of.clutter_m2.high * most_of,
        });
        let lost_db = exact.iter().fold(Span::default(), |sum, of| sum.plus(of.loss_db));

        // Clutter over noise before attenuation: without the correlation in the errors, with it in detection.
        let ground = self.ground(r_near, r_far);
        let rain = self.rain(r_near, r_far);
        let rain_most = rain.high * self.correlation.max(1.0);
        let kept = from_db(-all_db);
        let least_clutter = ground.low + rain.low + other.low;
        let without = |db: f64| attenuation_raises_db(db, all_db, least_clutter);

        let k = radar.constant * radar.circular_factor * self.facts.class.rcs_m2 / radar.noise_w;
        let (aspect_low, aspect_high) = self.facts.aspect;
        let least = k * aspect_low * gain.low * gain.low * reflection.factor.low * kept
            / fourth(r_far)
            / (1.0 + (ground.high + rain_most + other.high) * from_db(-least_db));
        let most =
            k * aspect_high * gain.high * gain.high * reflection.factor.high * from_db(-least_db)
                / fourth(r_near)
                / (1.0 + least_clutter * kept);
        let (least, most) = (least * from_db(-lost_db.high), most * from_db(-lost_db.low));
        let values = std::array::from_fn(|value| {
            let losses = Losses { all_db, least_clutter, km2, most_of, places: &places };
            [Level::Skipped, Level::Cheap, Level::Middle, Level::Exact]
                .map(|level| self.value_loss(value, level, &exact[value], &losses))
        });
        BoxBounds {
            range_m,
            ratio: Span { low: least * (1.0 - ROUNDING), high: most * (1.0 + ROUNDING) },
            rain_db: without(rain_db),
            // Of a cell before the target rain grows no more behind it, the line does.
            linear_db: (
                (rain_db - nearest_line_db).max(0.0),
                (line_db - least_rain * km2).max(0.0),
            ),
            values,
            ground_db: clutter_raises_db(ground.high, rain.low * kept),
            rain_clutter_db: clutter_raises_db(rain_most, ground.low * kept),
            clutter_db: to_db(1.0 + ground.high + rain_most),
            reflection,
            clutter: (ground.high, rain_most),
        }
    }

    /// Most that an effect that is a value attenuates at any level worth taking, dB/km one way.
    fn most_db_per_km(&self, value: usize) -> f64 {
        let at = &self.air.values_db_per_km[value];
        VALUES[value].1.worth().fold(0.0, |most: f64, level| most.max(at[level as usize]))
    }

    /// What every effect that is a value does exactly, beside attenuating.
    fn exact_spans(&self, places: &EchoPlaces) -> [ChangeSpan; VALUES.len()] {
        std::array::from_fn(|value| self.span(VALUES[value].1, Level::Exact, places))
    }

    fn span(&self, value: &EffectValue, level: Level, places: &EchoPlaces) -> ChangeSpan {
        match (&value.at_place, value.at_least(level)) {
            (Some(own), level) if level != Level::Skipped => {
                (own.over)(level, &self.radar.setting(&self.air.weather), places)
            }
            _ => ChangeSpan::default(),
        }
    }

    /// What a level of an effect that is a value loses.
    fn value_loss(
        &self,
        value: usize,
        level: Level,
        exact: &ChangeSpan,
        over: &Losses<'_>,
    ) -> Loss {
        let own = VALUES[value].1;
        if own.at_least(level) == Level::Exact {
            return Loss::NONE;
        }
        let at = &self.air.values_db_per_km[value];
        let less_db = (at[Level::Exact as usize] - at[level as usize]) * over.km2;
        let raises = |db: f64| attenuation_raises_db(db.max(0.0), over.all_db, over.least_clutter);
        let mut loss =
            Loss { raises_db: raises(less_db), lowers_db: (-less_db).max(0.0), ..Loss::NONE };
        if own.at_place.is_some() {
            let here = self.span(own, level, over.places);
            let lost = exact.loss_db.minus(here.loss_db);
            let clutter = exact.clutter_m2.minus(here.clutter_m2);
            let over_noise = |m2: f64| clutter_raises_db(m2.max(0.0) * over.most_of, 0.0);
            loss.raises_db += lost.high.max(0.0) + over_noise(clutter.high);
            loss.lowers_db += (-lost.low).max(0.0) + over_noise(-clutter.low);
            let most = |span: Span| span.low.abs().max(span.high.abs());
            let along_m = most(exact.along_m.minus(here.along_m));
            loss.fixed_m = libm::hypot(along_m, most(exact.across_m.minus(here.across_m)));
        }
        loss
    }

    /// Ground clutter over noise, before attenuation.
    fn ground(&self, near_m: f64, far_m: f64) -> Span {
        let radar = self.radar;
        let at = |r: f64| radar.constant * radar.ground_m2(r) / (r * r * r * r) / radar.noise_w;
        let sine = |r: f64| radar.antenna_m / r;
        let (steep, shallow) = (sine(near_m), sine(far_m));
        if steep > 0.999 {
            // At the foot of the tower the patch grows without bound.
            let most = radar.ground_m2_bound(near_m) / (near_m * near_m * near_m * near_m);
            return Span { low: 0.0, high: radar.constant * most / radar.noise_w };
        }
        // Slope of the logarithm by that of the range: −4 of the way, the patch by 1/cos ψ, and the gain
        // twice.
        let (least, most) = radar.by_sine.log_slope(shallow, steep);
        let patch = |s: f64| s * s / (1.0 - s * s);
        let gains = [least * shallow, least * steep, most * shallow, most * steep];
        let gains = Span::around(gains.into_iter());
        let from = -4.0 - patch(steep) - 2.0 * gains.high;
        let to = -4.0 - patch(shallow) - 2.0 * gains.low;
        let half = 0.5 * libm::log(far_m / near_m);
        let beside = libm::exp(half * from.abs().max(to.abs()));
        let middle = at((near_m * far_m).sqrt());
        let span = Span { low: middle / beside, high: middle * beside };
        // Where it falls or grows throughout, its ends are the least and the largest.
        if to <= 0.0 || from >= 0.0 {
            Span::around([at(near_m), at(far_m)].into_iter())
        } else {
            span
        }
    }

    /// Rain clutter over noise, before attenuation, without correlation.
    fn rain(&self, near_m: f64, far_m: f64) -> Span {
        let (radar, air, place) = (self.radar, self.air, self.place);
        let least = air.uniform().mie_echo;
        let most = if place.rain_here { air.worst_rain_echo() } else { least };
        if most == 0.0 {
            return Span::default();
        }
        let at = |r: f64| {
            radar.constant * radar.rain_volume_m3(RainEcho::Mie, r)
                / (r * r * r * r)
                / radar.noise_w
        };
        // Falls with the range; the table of the beam holds a hundredth of a decibel.
        Span { low: at(far_m) * least * 0.99, high: at(near_m) * most * 1.01 }
    }
}

fn slant(ground_m: f64, down_m: f64) -> f64 {
    (ground_m * ground_m + down_m * down_m).sqrt()
}
