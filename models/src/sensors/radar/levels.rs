//! The level at which each effect of a surface movement radar is simulated.
//!
//! What an effect does stands with its physics; what leaving it out loses, in [`crate::sensors::asde::plan`].

use crate::effects::Level;
use crate::environment::surface::Roughness;
use crate::sensors::radar::effects::{self, RadarEffect};
use crate::sensors::radar::equation::{
    BudgetLevels, RainEcho, RainPath, ReflectedPolarisation, Reflection,
};
use crate::sensors::radar::extended::ExtentLevel;

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
        if let (Some(value), Some(place)) = (effect.value(), effects::place(effect)) {
            b.values[place] = value.at_least(level);
            return self;
        }
        match effect {
            E::RainAttenuation => {
                b.rain = match level {
                    Level::Skipped => RainPath::None,
                    Level::Cheap => RainPath::Linear,
                    Level::Middle => RainPath::Cells,
                    Level::Exact => RainPath::Mie,
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
            E::SurfaceReflection if !on => b.reflection = Reflection::None,
            E::Lobing if b.reflection != Reflection::None => {
                b.reflection = if on { Reflection::Extended } else { Reflection::Incoherent };
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
            E::Extent => {
                self.extent = match level {
                    Level::Skipped => ExtentLevel::Point,
                    Level::Cheap | Level::Middle => ExtentLevel::Table,
                    Level::Exact => ExtentLevel::Centroid,
                }
            }
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
            // The reflection where it stays as it is. Values are done, and a law holds that no other effect comes here.
            _ => {}
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_can_be_switched_off() {
        for &effect in RadarEffect::ALL {
            let exact = RadarLevels::EXACT.with(effect, Level::Exact);
            assert_ne!(RadarLevels::EXACT.with(effect, Level::Skipped), exact, "{}", effect.name());
        }
    }
}
