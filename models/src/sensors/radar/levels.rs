//! The effects of a surface movement radar, and the level at which each is simulated.
//!
//! What an effect does stands with its physics; what leaving it out loses, in [`super::asde::plan`].

use super::extended::ExtentLevel;
use super::radar_equation::{
    BudgetLevels, GasLevel, RainEcho, RainPath, ReflectedPolarisation, Reflection,
};
use crate::effects::Level;
use crate::environment::surface::Roughness;

macro_rules! effects {
    ($($(#[$doc:meta])* $variant:ident = $name:literal,)+) => {
        /// An effect of the radar.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        #[repr(usize)]
        pub enum RadarEffect { $($(#[$doc])* $variant,)+ }

        impl RadarEffect {
            /// All of them, in the order of the plan.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)+];

            /// Name in plans, reports and explanations.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)+ }
            }
        }
    };
}

effects! {
    /// Attenuation by rain.
    RainAttenuation = "rain attenuation",
    /// Attenuation by fog.
    Fog = "fog",
    /// Attenuation by oxygen and water vapour.
    Gases = "gases",
    /// Echo of the rain.
    RainClutter = "rain clutter",
    /// Echo of the ground.
    GroundClutter = "ground clutter",
    /// Reflection at the surface, mean over its phase.
    SurfaceReflection = "surface reflection",
    /// Its phase: lobes.
    Lobing = "lobing",
    /// Roughness of the surface.
    Roughness = "roughness",
    /// Water film on the surface.
    WaterFilm = "water film",
    /// Polarisation of the reflection.
    ReflectedPolarisation = "reflected polarisation",
    /// Curvature of the earth in the reflection.
    RoundEarth = "earth curvature",
    /// Probability of detection.
    Detection = "detection probability",
    /// Centre of the echo of an extended target, and its echo by aspect.
    Extent = "target extent",
    /// Wander of that centre.
    Glint = "glint",
    /// Thermal error of the range.
    ThermalRange = "thermal range error",
    /// Thermal error of the azimuth.
    ThermalAzimuth = "thermal azimuth error",
    /// Steps of the extractor.
    Quantisation = "quantisation",
    /// False alarms.
    FalseAlarms = "false alarms",
    /// Shadows of buildings, with diffraction at their edges.
    BuildingShadow = "building shadow",
    /// Shadows of other aircraft.
    AircraftShadow = "aircraft shadow",
    /// Reflections at facades.
    Ghosts = "facade ghosts",
    /// Two targets in one cell.
    Merging = "merging",
    /// Echoes from beyond the unambiguous range.
    SecondTrace = "second trace",
    /// What is simulated between the echo and the plot: closed forms, windows of cells, all cells.
    Processing = "signal processing",
}

/// How often each effect was evaluated.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally([u64; RadarEffect::ALL.len()]);

impl Tally {
    /// Counts one evaluation.
    pub fn count(&mut self, effect: RadarEffect) {
        self.0[effect as usize] += 1;
    }

    /// Counts several.
    pub fn add(&mut self, effect: RadarEffect, times: u64) {
        self.0[effect as usize] += times;
    }

    /// Counts what one budget has evaluated.
    pub fn note(&mut self, evaluated: Evaluated) {
        let mut left = evaluated.0;
        while left != 0 {
            self.0[left.trailing_zeros() as usize] += 1;
            left &= left - 1;
        }
    }

    /// Evaluations of one effect.
    #[must_use]
    pub fn of(&self, effect: RadarEffect) -> u64 {
        self.0[effect as usize]
    }
}

/// Effects that a piece of physics has evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Evaluated(u32);

impl Evaluated {
    /// Adds one.
    pub fn add(&mut self, effect: RadarEffect) {
        self.0 |= 1 << effect as u32;
    }

    /// Whether an effect is among them.
    #[must_use]
    pub fn has(self, effect: RadarEffect) -> bool {
        self.0 >> effect as u32 & 1 == 1
    }
}

/// How shadows are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShadowLevel {
    /// None.
    None,
    /// In sight or not.
    Binary,
    /// Knife edge at roof and corners.
    KnifeEdge,
}

/// How the probability of detection is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PdLevel {
    /// Albersheim's equation (steady targets).
    Albersheim,
    /// Table of the exact form.
    Table,
    /// The mixture sum.
    Exact,
}

/// What a radar simulates between the echoes of its targets and its plots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Processing {
    /// Each echo at once: probability of detection, closed centroid, formulas of the errors.
    Plot,
    /// The cells around each target: scatterers, noise, threshold, clusters.
    Cells,
    /// Every cell that the beam passes; noise makes the false alarms.
    Video,
}

impl Processing {
    /// Its name in scenes and plans.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Plot => "plot",
            Self::Cells => "cells",
            Self::Video => "video",
        }
    }

    /// Its place among the levels of [`RadarEffect::Processing`].
    #[must_use]
    pub fn level(self) -> Level {
        match self {
            Self::Plot => Level::Cheap,
            Self::Cells => Level::Middle,
            Self::Video => Level::Exact,
        }
    }
}

/// Level of every effect of a radar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadarLevels {
    /// Of the budget.
    pub budget: BudgetLevels,
    /// Of the detection.
    pub pd: PdLevel,
    /// Of the target's extent.
    pub extent: ExtentLevel,
    /// Whether the centre of the echo wanders.
    pub glint: bool,
    /// Whether ranges have thermal errors.
    pub thermal_range: bool,
    /// Whether azimuths have thermal errors.
    pub thermal_azimuth: bool,
    /// Whether plots are quantised.
    pub quantisation: bool,
    /// Whether there are false alarms.
    pub false_alarms: bool,
    /// Shadows of buildings.
    pub buildings: ShadowLevel,
    /// Shadows of aircraft.
    pub aircraft: ShadowLevel,
    /// Reflections at facades.
    pub ghosts: bool,
    /// Two targets in one cell.
    pub merging: bool,
    /// Echoes from beyond the unambiguous range.
    pub second_trace: bool,
    /// How echoes become plots.
    pub processing: Processing,
}

impl RadarLevels {
    /// The most exact level of every effect, at plot level.
    pub const EXACT: Self = Self {
        budget: BudgetLevels::EXACT,
        pd: PdLevel::Exact,
        extent: ExtentLevel::Centroid,
        glint: true,
        thermal_range: true,
        thermal_azimuth: true,
        quantisation: true,
        false_alarms: true,
        buildings: ShadowLevel::KnifeEdge,
        aircraft: ShadowLevel::KnifeEdge,
        ghosts: true,
        merging: true,
        second_trace: true,
        processing: Processing::Plot,
    };

    /// These levels with one effect at another level.
    #[must_use]
    pub fn with(mut self, effect: RadarEffect, level: Level) -> Self {
        use RadarEffect as E;
        let b = &mut self.budget;
        let on = level != Level::Skipped;
        match effect {
            E::RainAttenuation => {
                b.rain = match level {
                    Level::Skipped => RainPath::None,
                    Level::Cheap => RainPath::Linear,
                    Level::Middle => RainPath::Cells,
                    Level::Exact => RainPath::Mie,
                }
            }
            E::Fog => b.fog = on,
            E::Gases => {
                b.gas = match level {
                    Level::Skipped => GasLevel::None,
                    Level::Cheap => GasLevel::Constant,
                    Level::Middle | Level::Exact => GasLevel::Lines,
                }
            }
            E::RainClutter => {
                b.rain_echo = match level {
                    Level::Skipped => RainEcho::None,
                    Level::Cheap => RainEcho::FullBeam,
                    Level::Middle => RainEcho::Closed,
                    Level::Exact => RainEcho::Mie,
                }
            }
            E::GroundClutter => b.ground_echo = on,
            E::SurfaceReflection => {
                if !on {
                    b.reflection = Reflection::None;
                }
            }
            E::Lobing => {
                if b.reflection != Reflection::None {
                    b.reflection = if on { Reflection::Extended } else { Reflection::Incoherent };
                }
            }
            E::Roughness => {
                b.roughness = match level {
                    Level::Skipped => Roughness::Smooth,
                    Level::Cheap => Roughness::Ament,
                    Level::Middle | Level::Exact => Roughness::MillerBrownVegh,
                }
            }
            E::WaterFilm => b.film = on,
            E::ReflectedPolarisation => {
                b.reflected = if level >= Level::Middle {
                    ReflectedPolarisation::Own
                } else {
                    ReflectedPolarisation::Horizontal
                }
            }
            E::RoundEarth => b.round_earth = on,
            E::Detection => {
                self.pd = match level {
                    Level::Skipped | Level::Cheap => PdLevel::Albersheim,
                    Level::Middle => PdLevel::Table,
                    Level::Exact => PdLevel::Exact,
                }
            }
            E::Extent => self.extent = if on { ExtentLevel::Centroid } else { ExtentLevel::Point },
            E::Glint => self.glint = on,
            E::ThermalRange => self.thermal_range = on,
            E::ThermalAzimuth => self.thermal_azimuth = on,
            E::Quantisation => self.quantisation = on,
            E::FalseAlarms => self.false_alarms = on,
            E::BuildingShadow => self.buildings = shadow(level),
            E::AircraftShadow => self.aircraft = shadow(level),
            E::Ghosts => self.ghosts = on,
            E::Merging => self.merging = on,
            E::SecondTrace => self.second_trace = on,
            E::Processing => {
                self.processing = match level {
                    Level::Skipped | Level::Cheap => Processing::Plot,
                    Level::Middle => Processing::Cells,
                    Level::Exact => Processing::Video,
                }
            }
        }
        self
    }
}

fn shadow(level: Level) -> ShadowLevel {
    match level {
        Level::Skipped => ShadowLevel::None,
        Level::Cheap => ShadowLevel::Binary,
        Level::Middle | Level::Exact => ShadowLevel::KnifeEdge,
    }
}
