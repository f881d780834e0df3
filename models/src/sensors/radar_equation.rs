//! The single-pulse budget of a surface movement radar, in watts throughout.

use super::antenna::Pattern;
use super::detection::from_db;
use super::geometry::{RoundEarth, TwoPaths};
use super::propagation;
use crate::environment::fog::{self, FogLaw};
use crate::environment::rain::{self, RainLaw};
use crate::environment::surface::{self, Fresnel, Material, Roughness};
use crate::environment::{SPEED_OF_LIGHT, Weather, gas, wavelength_m};
use crate::frames::Vector2;
use nalgebra::Complex;
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
    /// ITU-R P.838, the heaviest rain everywhere: an upper bound for cells, exact for uniform rain.
    Uniform,
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
    /// Fog attenuation.
    pub fog: bool,
    /// Gases: none, constant, or line by line.
    pub gas: GasLevel,
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

/// How gaseous attenuation is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GasLevel {
    /// None.
    None,
    /// A constant of the carrier for the standard atmosphere.
    Constant,
    /// ITU-R P.676 line by line for the scene's air.
    Lines,
}

impl BudgetLevels {
    /// The middle level of everything: what the reference budgets use.
    pub const MIDDLE: Self = Self {
        rain: RainPath::Cells,
        fog: true,
        gas: GasLevel::Lines,
        rain_echo: RainEcho::Closed,
        ground_echo: true,
        reflection: Reflection::Incoherent,
        reflected: ReflectedPolarisation::Own,
        roughness: Roughness::MillerBrownVegh,
        film: true,
        round_earth: false,
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
    /// Rain attenuation at this carrier and polarisation.
    pub rain_law: RainLaw,
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
    /// Fog, dB/km one way.
    pub fog_db_per_km: f64,
    /// Gases line by line, dB/km one way.
    pub gas_db_per_km: f64,
    /// Gases as a constant.
    pub gas_constant_db_per_km: f64,
    /// Permittivity of the surface.
    pub surface: Complex<f64>,
    /// Permittivity of the water film.
    pub film: Complex<f64>,
    /// Uniform rain.
    pub uniform: RainAir,
    /// The heaviest rain anywhere.
    pub heaviest: RainAir,
}

/// What one rain rate does at this radar's carrier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RainAir {
    /// Rain rate, mm/h.
    pub rain_mm_per_h: f64,
    /// Attenuation, dB/km one way.
    pub db_per_km: f64,
    /// Reflectivity, m²/m³, times what the polarisation lets through.
    pub echo: f64,
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
        self.signal_w / (self.noise_w + self.rain_w + self.ground_w)
    }
}

impl Radar {
    /// Everything of `weather` that is the same for all targets.
    #[must_use]
    pub fn air(&self, weather: &Weather) -> Air {
        let heaviest = weather.heaviest_mm_per_h();
        let (oxygen, vapour) = gas::specific_db_per_km(
            self.carrier_ghz,
            weather.pressure_hpa,
            weather.vapour_g_per_m3,
            weather.temperature_k,
        );
        Air {
            fog_db_per_km: fog::specific_db_per_km(
                self.carrier_ghz,
                weather.temperature_k,
                weather.visibility_m,
                self.fog_law,
            ),
            gas_db_per_km: oxygen + vapour,
            gas_constant_db_per_km: gas::constant_db_per_km(self.carrier_ghz),
            surface: self.surface.permittivity(self.carrier_ghz),
            film: fog::water_permittivity(self.carrier_ghz, weather.temperature_k),
            uniform: self.rain_air(weather.rain_mm_per_h),
            heaviest: self.rain_air(heaviest),
            weather: weather.clone(),
        }
    }

    fn rain_air(&self, rain_mm_per_h: f64) -> RainAir {
        RainAir {
            rain_mm_per_h,
            db_per_km: self.rain_law.specific_db_per_km(rain_mm_per_h),
            echo: rain::reflectivity(self.carrier_ghz, rain_mm_per_h)
                * self.polarisation_fraction(rain_mm_per_h),
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
        site_m: Vector2<f64>,
        target_m: Vector2<f64>,
    ) -> Budget {
        let paths = TwoPaths::flat(echo.ground_m, self.antenna_m, echo.height_m);
        let range_m = paths.direct_m;
        let elevation = self.pattern.elevation(paths.depression_rad);
        let (db_per_km, rain_here) = self.attenuation(air, levels, site_m, target_m);
        let attenuation =
            if db_per_km == 0.0 { 1.0 } else { from_db(-2.0 * db_per_km * range_m / 1000.0) };
        let reflection = self.reflection(air, levels, echo, &paths, elevation);
        let spread = self.constant * attenuation / (range_m * range_m * range_m * range_m);
        let signal_w = spread
            * echo.rcs_m2
            * self.circular_factor
            * elevation
            * elevation
            * reflection.propagation;
        let rain_m2 = self.rain_m2(levels, rain_here, air, range_m);
        let ground_m2 = if levels.ground_echo { self.ground_m2(range_m) } else { 0.0 };
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
        }
    }

    /// Specific attenuation over the path, dB/km one way, and the rain over the target.
    fn attenuation(
        &self,
        air: &Air,
        levels: &BudgetLevels,
        site_m: Vector2<f64>,
        target_m: Vector2<f64>,
    ) -> (f64, RainAir) {
        let cells = !air.weather.cells.is_empty();
        let rain_here = if cells && levels.rain_echo != RainEcho::None {
            let rate = air.weather.rain_at(target_m);
            if rate == air.uniform.rain_mm_per_h { air.uniform } else { self.rain_air(rate) }
        } else {
            air.uniform
        };
        let law = &self.rain_law;
        let rain = match levels.rain {
            RainPath::None => 0.0,
            RainPath::Linear => law.linear_db_per_km(air.heaviest.rain_mm_per_h),
            RainPath::Uniform => air.heaviest.db_per_km,
            RainPath::Cells | RainPath::Mie if !cells => air.uniform.db_per_km,
            RainPath::Cells | RainPath::Mie => {
                rain::path_mean(&air.weather, site_m, target_m, |r| law.specific_db_per_km(r))
            }
        };
        let fog = if levels.fog { air.fog_db_per_km } else { 0.0 };
        let gas = match levels.gas {
            GasLevel::None => 0.0,
            GasLevel::Constant => air.gas_constant_db_per_km,
            GasLevel::Lines => air.gas_db_per_km,
        };
        (rain + fog + gas, rain_here)
    }

    fn rain_m2(&self, levels: &BudgetLevels, rain: RainAir, air: &Air, range_m: f64) -> f64 {
        if rain.rain_mm_per_h == 0.0 && air.heaviest.rain_mm_per_h == 0.0 {
            return 0.0;
        }
        let (echo, integral) = match levels.rain_echo {
            RainEcho::None => return 0.0,
            RainEcho::FullBeam => (air.heaviest.echo, self.pattern.rain_integral_bound()),
            RainEcho::Closed | RainEcho::Mie if rain.rain_mm_per_h == 0.0 => return 0.0,
            RainEcho::Closed => {
                (rain.echo, self.pattern.rain_integral(range_m, self.antenna_m, self.rain_top_m))
            }
            RainEcho::Mie => (
                rain.echo,
                self.pattern.rain_integral_exact(range_m, self.antenna_m, self.rain_top_m),
            ),
        };
        echo * self.cell_m * range_m * range_m * self.pattern.two_way_azimuth_rad() * integral
    }

    /// Cross section of the ground in one cell, m²: `σ⁰ = γ·sin ψ` over the patch.
    ///
    /// `sin ψ = h_a/R`, the angle at most 89.9°.
    fn ground_m2(&self, range_m: f64) -> f64 {
        let sin = (self.antenna_m / range_m).min(1.0);
        let grazing = libm::asin(sin).min(89.9f64.to_radians());
        let (sin, cos) = libm::sincos(grazing);
        let g = self.pattern.elevation(grazing);
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
        paths: &TwoPaths,
        elevation: f64,
    ) -> Reflected {
        if levels.reflection == Reflection::None {
            return Reflected { propagation: 1.0, strength: 0.0 };
        }
        let (mut grazing, mut difference, mut divergence) =
            (paths.grazing_rad, paths.difference_m, 1.0);
        if levels.round_earth {
            let round = RoundEarth::new(echo.ground_m, self.antenna_m, echo.height_m);
            (grazing, difference, divergence) =
                (round.grazing_rad, round.difference_m, round.divergence);
        }
        let gamma = self.surface_coefficient(air, levels, grazing);
        let rough = if self.roughness_m == 0.0 {
            1.0
        } else {
            levels.roughness.factor(self.roughness_m, self.wavelength_m, grazing)
        };
        let gain = (self.pattern.elevation(grazing) / elevation).sqrt();
        let strength = surface::modulus(gamma) * rough * divergence * gain;
        let phase = || {
            surface::argument(gamma) - propagation::path_phase_rad(difference, self.wavelength_m)
        };
        let propagation = match levels.reflection {
            Reflection::None => 1.0,
            Reflection::Incoherent => propagation::incoherent(strength),
            Reflection::Coherent => propagation::coherent(strength, phase()),
            Reflection::Extended => {
                let spread = propagation::phase_spread_rad(
                    self.antenna_m,
                    echo.extent_m,
                    self.wavelength_m,
                    echo.ground_m,
                );
                propagation::extended(strength, phase(), spread)
            }
        };
        Reflected { propagation, strength }
    }

    /// Reflection coefficient of the surface for this radar's polarisation.
    #[must_use]
    pub fn surface_coefficient(
        &self,
        air: &Air,
        levels: &BudgetLevels,
        grazing_rad: f64,
    ) -> Complex<f64> {
        let fresnel = if levels.film && air.weather.film_mm > 0.0 {
            let thickness = air.weather.film_mm / 1000.0;
            Fresnel::film(air.film, air.surface, thickness, self.wavelength_m, grazing_rad)
        } else {
            Fresnel::half_space(air.surface, grazing_rad)
        };
        match (levels.reflected, self.polarisation) {
            (ReflectedPolarisation::Horizontal, _) | (_, Polarisation::Horizontal) => {
                fresnel.horizontal
            }
            (_, Polarisation::Vertical) => fresnel.vertical,
            (_, Polarisation::Circular) => fresnel.circular_same(),
        }
    }
}

struct Reflected {
    propagation: f64,
    strength: f64,
}
