//! The single-pulse budget of a surface movement radar, in watts throughout.

use crate::effects::Level;
use crate::environment::fog::{self, FogLaw};
use crate::environment::mie::{MieDrops, MieRain};
use crate::environment::rain::{self, RainLaw};
use crate::environment::surface::{self, Material, Roughness};
use crate::environment::{SPEED_OF_LIGHT, Weather, wavelength_m};
use crate::frames::Point2;
use crate::sensors::radar::antenna::{Pattern, SinePattern};
use crate::sensors::radar::detection::from_db;
use crate::sensors::radar::effects::value::{Change, EchoPlace, OwnKeys, Setting};
use crate::sensors::radar::effects::{Evaluated, RadarEffect, VALUES};
use crate::sensors::radar::geometry::{LeanPaths, RoundEarth};
use crate::sensors::radar::propagation;
use nalgebra::Complex;
use std::cell::OnceCell;
use std::f64::consts::{FRAC_PI_4, PI};

/// Boltzmann's constant, J/K.
pub const BOLTZMANN: f64 = 1.380_649e-23;
/// Reference noise temperature, K.
pub const T0_K: f64 = 290.0;

/// Polarisation of the antenna.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Polarisation {
    /// Linear, horizontal.
    Horizontal,
    /// Linear, vertical.
    Vertical,
    /// Circular, same sense received.
    #[default]
    Circular,
}

impl Polarisation {
    /// Tilt of the polarisation in ITU-R P.838, rad.
    #[must_use]
    pub fn tilt_rad(self) -> f64 {
        match self {
            Self::Horizontal => 0.0,
            Self::Circular => FRAC_PI_4,
            Self::Vertical => 2.0 * FRAC_PI_4,
        }
    }
}

/// How the surface reflection enters the budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reflection {
    /// Not at all.
    None,
    /// Mean over the phase: `1 + 4q² + q⁴`.
    Incoherent,
    /// A point scatterer with its phase.
    Coherent,
    /// A vertical extent with its phase, in closed form.
    Extended,
}

/// How the surface reflects each polarisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReflectedPolarisation {
    /// `|Γ_H|` for every polarisation: the cheap form.
    Horizontal,
    /// The coefficient of the radar's own polarisation.
    Own,
}

/// How rain attenuation is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RainPath {
    /// None.
    None,
    /// Proportional to the rain rate, the heaviest rain everywhere.
    Linear,
    /// ITU-R P.838 along the path through the cells.
    Cells,
    /// Mie extinction of the drop spectrum along the path through the cells.
    Mie,
}

/// How rain clutter is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RainEcho {
    /// None.
    None,
    /// The whole beam filled: no ground, no rain top.
    FullBeam,
    /// Closed integral of the beam above ground, Rayleigh drops.
    Closed,
    /// Quadrature of the whole pattern, Mie drops.
    Mie,
}

/// Which level of each effect a budget is computed with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BudgetLevels {
    /// Rain attenuation.
    pub rain: RainPath,
    /// Effects that are values, in the order of [`VALUES`].
    pub values: [Level; VALUES.len()],
    /// Rain clutter.
    pub rain_echo: RainEcho,
    /// Ground clutter.
    pub ground_echo: bool,
    /// Surface reflection.
    pub reflection: Reflection,
    /// Its polarisation.
    pub reflected: ReflectedPolarisation,
    /// Roughness of the surface.
    pub roughness: Roughness,
    /// Water film on the surface in rain.
    pub film: bool,
    /// Round earth in the reflection (phase and divergence).
    pub round_earth: bool,
}

impl BudgetLevels {
    /// The middle level of everything: what the reference budgets use.
    pub const MIDDLE: Self = Self {
        rain: RainPath::Cells,
        values: [Level::Exact; VALUES.len()],
        rain_echo: RainEcho::Closed,
        ground_echo: true,
        reflection: Reflection::Incoherent,
        reflected: ReflectedPolarisation::Own,
        roughness: Roughness::MillerBrownVegh,
        film: true,
        round_earth: false,
    };

    /// The most exact level of everything.
    pub const EXACT: Self = Self {
        rain: RainPath::Mie,
        rain_echo: RainEcho::Mie,
        reflection: Reflection::Extended,
        round_earth: true,
        ..Self::MIDDLE
    };
}

/// What the budget needs of a radar and its surroundings, ready for use.
#[derive(Clone, Debug, PartialEq)]
pub struct Radar {
    /// Carrier, GHz.
    pub carrier_ghz: f64,
    /// Wavelength, m.
    pub wavelength_m: f64,
    /// `P_t·G²·λ²/((4π)³·L_sys)`, W·m².
    pub constant: f64,
    /// Thermal noise, W.
    pub noise_w: f64,
    /// Range cell `cτ/2`, m.
    pub cell_m: f64,
    /// Antenna pattern.
    pub pattern: Pattern,
    /// Antenna height above the surface, m.
    pub antenna_m: f64,
    /// Polarisation.
    pub polarisation: Polarisation,
    /// Axial ratio, dB (circular only).
    pub axial_ratio_db: f64,
    /// Factor on the echo of complex targets and of the ground: 1 for linear, `1/L_cp` for circular.
    pub circular_factor: f64,
    /// Ground clutter parameter γ, power ratio.
    pub ground_gamma: f64,
    /// What the surface is made of.
    pub surface: &'static Material,
    /// Its rms height, m.
    pub roughness_m: f64,
    /// Top of the rain, m above the surface.
    pub rain_top_m: f64,
    /// Law by which fog holds water.
    pub fog_law: FogLaw,
    /// Keys of effects that are values.
    pub own: OwnKeys,
    /// Rain attenuation at this carrier and polarisation.
    pub rain_law: RainLaw,
    /// The elevation pattern by sines.
    pub by_sine: SinePattern,
    /// Exact integral of the beam above ground, made when it is first asked for.
    pub beam: OnceCell<BeamTable>,
    /// What drops of every size do at this carrier, made when it first rains.
    pub drops: OnceCell<MieDrops>,
}

/// A function of the range on logarithmic steps, interpolated linearly: within 0.01 dB.
#[derive(Clone, Debug, PartialEq)]
pub struct BeamTable(Vec<f64>);

/// Least range of the table, m.
const BEAM_FROM_M: f64 = 15.0;
/// Steps per factor e of range.
const BEAM_STEPS: f64 = 24.0;

impl BeamTable {
    fn new(f: impl Fn(f64) -> f64) -> Self {
        // To 60 km: e^8.3 · 15 m.
        let count = (8.3 * BEAM_STEPS) as u32;
        let at = |i: u32| BEAM_FROM_M * libm::exp(f64::from(i) / BEAM_STEPS);
        Self((0..=count).map(|i| f(at(i))).collect())
    }

    fn at(&self, range_m: f64) -> f64 {
        let last = self.0.len() - 2;
        let place = (libm::log(range_m / BEAM_FROM_M) * BEAM_STEPS).max(0.0);
        let index = (place as usize).min(last);
        let share = (place - index as f64).clamp(0.0, 1.0);
        self.0[index] + share * (self.0[index + 1] - self.0[index])
    }
}

/// Plain numbers from which a [`Radar`] is made; validated elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadarNumbers {
    /// Carrier, GHz.
    pub carrier_ghz: f64,
    /// Peak power, W.
    pub peak_power_w: f64,
    /// Gain, dBi.
    pub gain_dbi: f64,
    /// System losses, dB.
    pub system_loss_db: f64,
    /// Noise figure, dB.
    pub noise_figure_db: f64,
    /// Bandwidth, Hz.
    pub bandwidth_hz: f64,
    /// Pulse length, s.
    pub pulse_s: f64,
}

impl RadarNumbers {
    /// `K = P_t·G²·λ²/((4π)³·L_sys)`.
    #[must_use]
    pub fn constant(&self) -> f64 {
        let lambda = wavelength_m(self.carrier_ghz);
        let four_pi = 4.0 * PI;
        self.peak_power_w * from_db(2.0 * self.gain_dbi - self.system_loss_db) * lambda * lambda
            / (four_pi * four_pi * four_pi)
    }

    /// `N = k_B·T₀·NF·B`.
    #[must_use]
    pub fn noise_w(&self) -> f64 {
        BOLTZMANN * T0_K * from_db(self.noise_figure_db) * self.bandwidth_hz
    }

    /// `cτ/2`.
    #[must_use]
    pub fn cell_m(&self) -> f64 {
        0.5 * SPEED_OF_LIGHT * self.pulse_s
    }
}

/// The air of one weather notice, with everything that does not depend on the target.
#[derive(Clone, Debug, PartialEq)]
pub struct Air {
    /// The weather.
    pub weather: Weather,
    /// Effects that are values, at every level: dB/km one way.
    pub values_db_per_km: [[f64; 4]; VALUES.len()],
    /// Permittivity of the surface.
    pub surface: Complex<f64>,
    /// Permittivity of the water film.
    pub film: Complex<f64>,
    /// Every rain rate of the weather once: the uniform one first, cells with heavier rain after it.
    rains: Vec<RainAir>,
    /// Attenuation of the heaviest rain by the straight line.
    linear_db_per_km: f64,
}

/// What one rain rate does at this radar's carrier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RainAir {
    /// Rain rate, mm/h.
    pub rain_mm_per_h: f64,
    /// Attenuation by the power law, dB/km one way.
    pub db_per_km: f64,
    /// Attenuation by Mie's theory, dB/km one way.
    pub mie_db_per_km: f64,
    /// Reflectivity of Rayleigh drops, m²/m³, times what the polarisation lets through.
    pub echo: f64,
    /// Reflectivity by Mie's theory, likewise.
    pub mie_echo: f64,
}

impl Air {
    /// The uniform rain.
    #[must_use]
    pub fn uniform(&self) -> &RainAir {
        &self.rains[0]
    }

    /// The heaviest rain anywhere.
    #[must_use]
    pub fn heaviest(&self) -> &RainAir {
        let heavier = |a: &&RainAir, b: &&RainAir| a.rain_mm_per_h.total_cmp(&b.rain_mm_per_h);
        self.rains.iter().max_by(heavier).unwrap_or(&self.rains[0])
    }

    /// A rain rate of this weather.
    pub(crate) fn rain(&self, rain_mm_per_h: f64) -> &RainAir {
        let same = |r: &&RainAir| r.rain_mm_per_h == rain_mm_per_h;
        self.rains.iter().find(same).unwrap_or(&self.rains[0])
    }

    /// Attenuation of a rain at a level, dB/km one way.
    pub(crate) fn rain_db_per_km(&self, level: RainPath, rain: &RainAir) -> f64 {
        match level {
            RainPath::None => 0.0,
            RainPath::Linear => self.linear_db_per_km,
            RainPath::Cells => rain.db_per_km,
            RainPath::Mie => rain.mie_db_per_km,
        }
    }

    /// Attenuation of everything but rain at the levels, dB/km one way.
    pub(crate) fn without_rain_db_per_km(&self, levels: &BudgetLevels) -> f64 {
        self.values_db_per_km(levels, 0.0)
    }

    /// `from` and the attenuation of all effects that are values, one after the other, dB/km one way.
    fn values_db_per_km(&self, levels: &BudgetLevels, from: f64) -> f64 {
        let own = self.values_db_per_km.iter().zip(&levels.values);
        own.fold(from, |sum, (of, level)| sum + of[*level as usize])
    }

    /// Attenuation of an effect that is a value, by its place, at its exact level, dB/km one way.
    #[must_use]
    pub fn exact_db_per_km(&self, place: usize) -> f64 {
        self.values_db_per_km[place][Level::Exact as usize]
    }

    /// Reflectivity of a rain at a level, polarisation included, m²/m³.
    pub(crate) fn rain_echo(&self, level: RainEcho, rain: &RainAir) -> f64 {
        match level {
            RainEcho::None => 0.0,
            RainEcho::FullBeam => self.heaviest().echo,
            RainEcho::Closed => rain.echo,
            RainEcho::Mie => rain.mie_echo,
        }
    }

    /// Attenuation of the heaviest rain by the straight line of the cheap level, dB/km.
    #[must_use]
    pub fn linear_db_per_km(&self) -> f64 {
        self.linear_db_per_km
    }

    /// Most that rain attenuates anywhere by any form, dB/km.
    #[must_use]
    pub fn worst_rain_db_per_km(&self) -> f64 {
        self.rains.iter().fold(0.0, |m, r| f64::max(m, r.db_per_km.max(r.mie_db_per_km)))
    }

    /// Least that rain attenuates anywhere by any form, dB/km.
    #[must_use]
    pub fn least_rain_db_per_km(&self) -> f64 {
        let least = |m, r: &RainAir| f64::min(m, r.db_per_km.min(r.mie_db_per_km));
        self.rains.iter().fold(f64::INFINITY, least)
    }

    /// Most that rain attenuates one way over `way_m`, by any form, wherever its cells are, dB: a cell
    /// counts with its diameter at most. `slope` is the way over its ground distance.
    #[must_use]
    pub fn most_rain_db(&self, way_m: f64, slope: f64) -> f64 {
        let most = |r: &RainAir| r.db_per_km.max(r.mie_db_per_km);
        let uniform = most(self.uniform());
        let cells = self.weather.cells.iter().map(|cell| {
            let through_m = (2.0 * cell.radius_m * slope).min(way_m);
            (most(self.rain(cell.rain_mm_per_h)) - uniform).max(0.0) * through_m
        });
        let sum = (uniform * way_m + cells.sum::<f64>()) / 1000.0;
        sum.min(self.worst_rain_db_per_km() * way_m / 1000.0)
    }

    /// Most that any rain returns by any form, m²/m³.
    #[must_use]
    pub fn worst_rain_echo(&self) -> f64 {
        self.rains.iter().fold(0.0, |m, r| f64::max(m, r.echo.max(r.mie_echo)))
    }
}

/// One target for the budget.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Echo {
    /// Ground distance, m.
    pub ground_m: f64,
    /// Height of the scatterer above the surface, m.
    pub height_m: f64,
    /// Vertical extent, m (for [`Reflection::Extended`]).
    pub extent_m: f64,
    /// Radar cross section, m².
    pub rcs_m2: f64,
}

/// The budget of one echo. Powers in watts, at the receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Slant range, m.
    pub range_m: f64,
    /// Specific attenuation of everything, dB/km one way, mean over the path.
    pub db_per_km: f64,
    /// Two-way attenuation as a power factor, at most 1.
    pub attenuation: f64,
    /// Two-way propagation factor `F⁴`.
    pub propagation: f64,
    /// One-way elevation gain towards the target.
    pub elevation: f64,
    /// Amplitude of the reflected ray against the direct one.
    pub reflected: f64,
    /// Signal.
    pub signal_w: f64,
    /// Thermal noise.
    pub noise_w: f64,
    /// Cross section of the rain cell, m².
    pub rain_m2: f64,
    /// Cross section of the ground patch, m².
    pub ground_m2: f64,
    /// Rain clutter.
    pub rain_w: f64,
    /// Ground clutter.
    pub ground_w: f64,
    /// Cross section of what effects that are values add, m².
    pub other_m2: f64,
    /// Their clutter.
    pub other_w: f64,
    /// Where these let the echo be seen: farther, and clockwise, m on the ground.
    pub moved_m: (f64, f64),
    /// The effects that were evaluated for it.
    pub evaluated: Evaluated,
}

impl Budget {
    /// Signal over thermal noise.
    #[must_use]
    pub fn snr(&self) -> f64 {
        self.signal_w / self.noise_w
    }

    /// Signal over noise and clutter.
    #[must_use]
    pub fn scnr(&self) -> f64 {
        self.signal_w / (self.noise_w + self.rain_w + self.ground_w + self.other_w)
    }
}

impl Radar {
    /// Everything of `weather` that is the same for all targets. The first rain of a radar costs about
    /// 0.2 ms (the drops' table), every further rain rate some microseconds.
    #[must_use]
    pub fn air(&self, weather: &Weather) -> Air {
        let setting = self.setting(weather);
        let values_db_per_km = std::array::from_fn(|place| {
            let value = VALUES[place].1;
            let at = |level| match value.at_least(level) {
                Level::Skipped => 0.0,
                level => (value.attenuation_db_per_km)(level, &setting),
            };
            [Level::Skipped, Level::Cheap, Level::Middle, Level::Exact].map(at)
        });
        let mut rates = vec![weather.rain_mm_per_h];
        for cell in &weather.cells {
            if cell.rain_mm_per_h > rates[0] && !rates.contains(&cell.rain_mm_per_h) {
                rates.push(cell.rain_mm_per_h);
            }
        }
        Air {
            values_db_per_km,
            surface: self.surface.permittivity(self.carrier_ghz),
            film: fog::water_permittivity(self.carrier_ghz, weather.temperature_k),
            linear_db_per_km: self.rain_law.linear_db_per_km(weather.heaviest_mm_per_h()),
            rains: rates.into_iter().map(|rate| self.rain_air(rate)).collect(),
            weather: weather.clone(),
        }
    }

    /// What effects that are values may read.
    #[must_use]
    pub fn setting<'a>(&'a self, weather: &'a Weather) -> Setting<'a> {
        Setting {
            weather,
            carrier_ghz: self.carrier_ghz,
            wavelength_m: self.wavelength_m,
            antenna_m: self.antenna_m,
            cell_m: self.cell_m,
            azimuth_rad: self.pattern.two_way_azimuth_rad(),
            fog_law: self.fog_law,
            surface: self.surface,
            roughness_m: self.roughness_m,
            own: &self.own,
        }
    }

    /// What the effects that are values do to an echo from one place, beside attenuating its way.
    pub(crate) fn change_at(&self, air: &Air, levels: &BudgetLevels, place: &EchoPlace) -> Change {
        let mut sum = Change::default();
        for ((_, value), level) in VALUES.iter().zip(levels.values) {
            if let (Some(own), true) = (&value.at_place, level != Level::Skipped) {
                sum = sum.plus((own.at)(level, &self.setting(&air.weather), place));
            }
        }
        sum
    }

    fn rain_air(&self, rain_mm_per_h: f64) -> RainAir {
        let drops = || self.drops.get_or_init(|| MieDrops::new(self.carrier_ghz));
        let mie =
            if rain_mm_per_h > 0.0 { drops().rain(rain_mm_per_h) } else { MieRain::default() };
        let fraction = self.polarisation_fraction(rain_mm_per_h);
        let mie_fraction = match self.polarisation {
            Polarisation::Circular => {
                rain::leaked_fraction(self.axial_ratio_db, mie.drop_rejection_db)
            }
            Polarisation::Horizontal | Polarisation::Vertical => 1.0,
        };
        RainAir {
            rain_mm_per_h,
            db_per_km: self.rain_law.specific_db_per_km(rain_mm_per_h),
            mie_db_per_km: mie.db_per_km,
            echo: rain::reflectivity(self.carrier_ghz, rain_mm_per_h) * fraction,
            mie_echo: mie.reflectivity * mie_fraction,
        }
    }

    fn polarisation_fraction(&self, rain_mm_per_h: f64) -> f64 {
        match self.polarisation {
            Polarisation::Circular => rain::circular_fraction(self.axial_ratio_db, rain_mm_per_h),
            Polarisation::Horizontal | Polarisation::Vertical => 1.0,
        }
    }

    /// The budget of an echo seen with the beam's azimuth on it, from `site_m` to `target_m` in the
    /// airport frame (only rain cells ask where).
    #[must_use]
    pub fn budget(
        &self,
        air: &Air,
        levels: &BudgetLevels,
        echo: &Echo,
        site_m: Point2<f64>,
        target_m: Point2<f64>,
    ) -> Budget {
        let mut evaluated = Evaluated::default();

        let paths = LeanPaths::flat(echo.ground_m, self.antenna_m, echo.height_m);
        let range_m = paths.direct_m;
        let elevation = self.by_sine.elevation(paths.sin_depression);
        let (db_per_km, rain_here) =
            self.attenuation(air, levels, site_m, target_m, &mut evaluated);
        let attenuation =
            if db_per_km == 0.0 { 1.0 } else { from_db(-2.0 * db_per_km * range_m / 1000.0) };
        let reflection = self.reflection(air, levels, echo, &paths, elevation, &mut evaluated);
        let spread = self.constant * attenuation / (range_m * range_m * range_m * range_m);
        let signal_w = spread
            * echo.rcs_m2
            * self.circular_factor
            * elevation
            * elevation
            * reflection.propagation;
        let rain_m2 = self.rain_m2(levels, &rain_here, air, range_m, &mut evaluated);
        let ground_m2 = if levels.ground_echo {
            evaluated.add(RadarEffect::GroundClutter);
            self.ground_m2(range_m)
        } else {
            0.0
        };
        let place = EchoPlace { range_m, ground_m: echo.ground_m, height_m: echo.height_m };
        let change = self.change_at(air, levels, &place);
        let signal_w =
            if change.loss_db == 0.0 { signal_w } else { signal_w * from_db(-change.loss_db) };
        Budget {
            range_m,
            db_per_km,
            attenuation,
            propagation: reflection.propagation,
            elevation,
            reflected: reflection.strength,
            signal_w,
            noise_w: self.noise_w,
            rain_m2,
            ground_m2,
            rain_w: spread * rain_m2,
            ground_w: spread * ground_m2,
            other_m2: change.clutter_m2,
            other_w: spread * change.clutter_m2,
            moved_m: (change.along_m, change.across_m),
            evaluated,
        }
    }

    /// Specific attenuation over the path, dB/km one way, and the rain over the target.
    fn attenuation(
        &self,
        air: &Air,
        levels: &BudgetLevels,
        site_m: Point2<f64>,
        target_m: Point2<f64>,
        evaluated: &mut Evaluated,
    ) -> (f64, RainAir) {
        let cells = !air.weather.cells.is_empty();
        let rain_here = if cells && levels.rain_echo != RainEcho::None {
            *air.rain(air.weather.rain_at(target_m))
        } else {
            *air.uniform()
        };
        if levels.rain != RainPath::None {
            evaluated.add(RadarEffect::RainAttenuation);
        }
        let rain = match levels.rain {
            RainPath::None => 0.0,
            RainPath::Linear => air.linear_db_per_km,
            RainPath::Cells if !cells => air.uniform().db_per_km,
            RainPath::Cells => {
                rain::path_mean(&air.weather, site_m, target_m, |r| air.rain(r).db_per_km)
            }
            RainPath::Mie if !cells => air.uniform().mie_db_per_km,
            RainPath::Mie => {
                rain::path_mean(&air.weather, site_m, target_m, |r| air.rain(r).mie_db_per_km)
            }
        };
        for ((effect, _), level) in VALUES.iter().zip(levels.values) {
            if level != Level::Skipped {
                evaluated.add(*effect);
            }
        }
        (air.values_db_per_km(levels, rain), rain_here)
    }

    fn rain_m2(
        &self,
        levels: &BudgetLevels,
        rain: &RainAir,
        air: &Air,
        range_m: f64,
        evaluated: &mut Evaluated,
    ) -> f64 {
        if levels.rain_echo == RainEcho::None {
            return 0.0;
        }
        evaluated.add(RadarEffect::RainClutter);
        let (echo, integral) = match levels.rain_echo {
            RainEcho::FullBeam => (air.heaviest().echo, self.pattern.rain_integral_bound()),
            _ if rain.rain_mm_per_h == 0.0 => return 0.0,
            RainEcho::Mie => (rain.mie_echo, self.exact_rain_integral(range_m)),
            RainEcho::None | RainEcho::Closed => {
                (rain.echo, self.pattern.rain_integral(range_m, self.antenna_m, self.rain_top_m))
            }
        };
        echo * self.cell_m * range_m * range_m * self.pattern.two_way_azimuth_rad() * integral
    }

    /// Volume of rain that a cell at `range_m` returns, weighted by the two-way beam: m³ on the beam axis.
    pub(crate) fn rain_volume_m3(&self, level: RainEcho, range_m: f64) -> f64 {
        let integral = match level {
            RainEcho::None => return 0.0,
            RainEcho::FullBeam => self.pattern.rain_integral_bound(),
            RainEcho::Closed => {
                self.pattern.rain_integral(range_m, self.antenna_m, self.rain_top_m)
            }
            RainEcho::Mie => self.exact_rain_integral(range_m),
        };
        self.cell_m * range_m * range_m * self.pattern.two_way_azimuth_rad() * integral
    }

    /// The exact integral of the beam above ground, from the table where the radar has one.
    fn exact_rain_integral(&self, range_m: f64) -> f64 {
        let quadrature =
            |r: f64| self.pattern.rain_integral_exact(r, self.antenna_m, self.rain_top_m);
        self.beam.get_or_init(|| BeamTable::new(quadrature)).at(range_m)
    }

    /// Upper bound of the beam's integral over every range, side lobes included, rad.
    #[must_use]
    pub fn rain_integral_bound(&self) -> f64 {
        self.pattern.rain_integral_bound() * 1.01 + self.pattern.floor * self.pattern.floor * PI
    }

    /// What the side lobes add to the rain's echo at most, up to `far_m`, dB.
    #[must_use]
    pub fn floor_db(&self, far_m: f64) -> f64 {
        let beam = self.pattern.rain_integral(far_m, self.antenna_m, self.rain_top_m);
        10.0 * libm::log10(1.0 + self.pattern.floor * self.pattern.floor * PI / beam)
    }

    /// Upper bound of the ground's cross section at `near_m` and beyond, m².
    #[must_use]
    pub fn ground_m2_bound(&self, near_m: f64) -> f64 {
        let sin = (self.antenna_m / near_m).min(1.0);
        let cos = (1.0 - sin * sin).sqrt().max(libm::cos(89.9f64.to_radians()));
        let patch = self.antenna_m * self.pattern.two_way_azimuth_rad() * self.cell_m / cos;
        self.ground_gamma * patch * self.circular_factor
    }

    /// Cross section of the ground in one cell, m²: `σ⁰ = γ·sin ψ` over the patch.
    ///
    /// `sin ψ = h_a/R`, the angle at most 89.9°.
    pub(crate) fn ground_m2(&self, range_m: f64) -> f64 {
        let steep = STEEPEST_RAD;
        let mut sin = self.antenna_m / range_m;
        let mut cos2 = 1.0 - sin * sin;
        if cos2 < steep * steep {
            // cos 89.9° is the sine of a tenth of a degree, to 12 digits.
            (sin, cos2) = (1.0 - 0.5 * steep * steep, steep * steep);
        }
        let (cos, g) = (cos2.sqrt(), self.by_sine.elevation(sin));
        self.ground_gamma
            * sin
            * range_m
            * self.pattern.two_way_azimuth_rad()
            * (self.cell_m / cos)
            * g
            * g
            * self.circular_factor
    }

    fn reflection(
        &self,
        air: &Air,
        levels: &BudgetLevels,
        echo: &Echo,
        paths: &LeanPaths,
        elevation: f64,
        evaluated: &mut Evaluated,
    ) -> Reflected {
        if levels.reflection == Reflection::None {
            return Reflected { propagation: 1.0, strength: 0.0 };
        }
        evaluated.add(RadarEffect::SurfaceReflection);
        let (paths, divergence) = if levels.round_earth {
            evaluated.add(RadarEffect::RoundEarth);
            RoundEarth::lean(echo.ground_m, self.antenna_m, echo.height_m)
        } else {
            (*paths, 1.0)
        };
        if levels.film && air.weather.film_mm > 0.0 {
            evaluated.add(RadarEffect::WaterFilm);
        }
        if levels.reflected == ReflectedPolarisation::Own {
            evaluated.add(RadarEffect::ReflectedPolarisation);
        }
        let gamma = self.surface_coefficient_at(air, levels, paths.sin_grazing, paths.cos_grazing);
        let rough = if self.roughness_m == 0.0 || levels.roughness == Roughness::Smooth {
            1.0
        } else {
            evaluated.add(RadarEffect::Roughness);
            levels.roughness.factor_sin(self.roughness_m, self.wavelength_m, paths.sin_grazing)
        };
        let gain = (self.by_sine.elevation(paths.sin_grazing) / elevation).sqrt();
        let modulus = surface::modulus(gamma);
        let strength = modulus * rough * divergence * gain;
        if matches!(levels.reflection, Reflection::Coherent | Reflection::Extended) {
            evaluated.add(RadarEffect::Lobing);
        }
        let path = || propagation::path_phase_rad(paths.difference_m, self.wavelength_m);
        let propagation = match levels.reflection {
            Reflection::None => 1.0,
            Reflection::Incoherent => propagation::incoherent(strength),
            Reflection::Coherent => {
                propagation::coherent(strength, surface::argument(gamma) - path())
            }
            Reflection::Extended => {
                let spread = propagation::phase_spread_rad(
                    self.antenna_m,
                    echo.extent_m,
                    self.wavelength_m,
                    echo.ground_m,
                );
                // cos(arg Γ − x) without the argument.
                let (sin, cos) = libm::sincos(path());
                let turned = gamma.re * cos + gamma.im * sin;
                let cos_phase = if modulus > 0.0 { turned / modulus } else { 1.0 };
                propagation::extended_cos(strength, cos_phase.clamp(-1.0, 1.0), spread)
            }
        };
        Reflected { propagation, strength }
    }

    pub(crate) fn surface_coefficient_at(
        &self,
        air: &Air,
        levels: &BudgetLevels,
        sin: f64,
        cos: f64,
    ) -> Complex<f64> {
        let (horizontal, vertical) = if levels.film && air.weather.film_mm > 0.0 {
            let thickness = air.weather.film_mm / 1000.0;
            surface::film_pair(air.film, air.surface, thickness, self.wavelength_m, sin, cos)
        } else {
            surface::half_space_pair(air.surface, sin, cos)
        };
        match (levels.reflected, self.polarisation) {
            (ReflectedPolarisation::Horizontal, _) | (_, Polarisation::Horizontal) => horizontal,
            (_, Polarisation::Vertical) => vertical,
            (_, Polarisation::Circular) => (horizontal + vertical) * 0.5,
        }
    }
}

/// How much the steepest grazing angle of ground clutter, 89.9°, is short of the vertical, rad.
const STEEPEST_RAD: f64 = 0.1 * PI / 180.0;

struct Reflected {
    propagation: f64,
    strength: f64,
}
