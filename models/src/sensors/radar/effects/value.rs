//! An effect on the echo of one target, as a value: what it does, at which levels, and what each of them may lose.
//!
//! What such a value says is all that the house needs: the budget applies it, the plan bounds it over boxes, levels,
//! costs, reports and explanations name it. Effects that are entangled with others (the reflection and what refines
//! it, detection, extent, shadows) are planned by hand in [`crate::sensors::asde::plan`].

use crate::effects::Level;
use crate::environment::Weather;
use crate::environment::fog::FogLaw;
use crate::environment::surface::Material;
use crate::keys::Key;
use crate::sensors::radar::span::Span;
use std::collections::BTreeMap;

/// Keys of effects that a scene gives a radar, by name; one that is not given has its effect's default.
pub type OwnKeys = BTreeMap<&'static str, f64>;

/// What an effect may read of a radar and the weather.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// The weather.
    pub weather: &'a Weather,
    /// Carrier, GHz.
    pub carrier_ghz: f64,
    /// Wavelength, m.
    pub wavelength_m: f64,
    /// Height of the antenna above the surface, m.
    pub antenna_m: f64,
    /// Length of a range cell, m.
    pub cell_m: f64,
    /// Equivalent two-way width of the beam in azimuth, rad.
    pub azimuth_rad: f64,
    /// Law by which fog holds water.
    pub fog_law: FogLaw,
    /// What the surface is made of.
    pub surface: &'static Material,
    /// Its rms height, m.
    pub roughness_m: f64,
    /// Keys of effects that the scene gives.
    pub own: &'a OwnKeys,
}

impl Setting<'_> {
    /// The value of an effect's own key, or what holds without it.
    #[must_use]
    pub fn own(&self, key: &str, default: f64) -> f64 {
        self.own.get(key).copied().unwrap_or(default)
    }
}

/// Where an echo comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EchoPlace {
    /// Slant range, m.
    pub range_m: f64,
    /// Distance on the ground, m.
    pub ground_m: f64,
    /// Height above the surface, m.
    pub height_m: f64,
}

/// Places from which echoes come, enclosed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EchoPlaces {
    /// Slant range, m.
    pub range_m: Span,
    /// Distance on the ground, m.
    pub ground_m: Span,
    /// Height above the surface, m.
    pub height_m: Span,
}

/// What an effect does to one echo.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// Two-way loss of the echo, dB; what strengthens it is negative.
    pub loss_db: f64,
    /// Cross section of what else returns from the same cell, m²; not negative.
    pub clutter_m2: f64,
    /// By how much its centre is seen farther, m on the ground.
    pub along_m: f64,
    /// By how much it is seen clockwise, m on the ground.
    pub across_m: f64,
}

impl Change {
    /// Both together.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            loss_db: self.loss_db + other.loss_db,
            clutter_m2: self.clutter_m2 + other.clutter_m2,
            along_m: self.along_m + other.along_m,
            across_m: self.across_m + other.across_m,
        }
    }
}

/// What an effect does at least and at most over a set of places: every part of [`Change`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChangeSpan {
    /// Loss, dB.
    pub loss_db: Span,
    /// Cross section of clutter, m².
    pub clutter_m2: Span,
    /// Shift along, m.
    pub along_m: Span,
    /// Shift across, m.
    pub across_m: Span,
}

/// What an effect does that depends on where the echo comes from.
#[derive(Clone, Copy, Debug)]
pub struct AtPlace {
    /// At a level that is not skipped, at one place.
    pub at: fn(Level, &Setting<'_>, &EchoPlace) -> Change,
    /// The same over a set of places, enclosed: nothing that `at` gives there lies outside.
    pub over: fn(Level, &Setting<'_>, &EchoPlaces) -> ChangeSpan,
}

/// An effect as a value. One file declares it, one line of the list in [`super`] puts it into the house.
#[derive(Clone, Copy, Debug)]
pub struct EffectValue {
    /// Name in plans, reports and explanations.
    pub name: &'static str,
    /// Keys of scenes that it reads, all of them numbers with a default.
    pub keys: &'static [Key],
    /// What in the scene calls for it, in words.
    pub called_for: fn(&Setting<'_>) -> String,
    /// The levels beside skipped, from the cheapest to the exact one, each with its time per target and scan, ns,
    /// as measured by the bench `costs`.
    pub levels: &'static [(Level, u32)],
    /// Attenuation along the whole way at a level that is not skipped, dB/km one way; not negative. Asked for once
    /// a weather notice.
    pub attenuation_db_per_km: fn(Level, &Setting<'_>) -> f64,
    /// What it does beside that, where it does.
    pub at_place: Option<AtPlace>,
}

impl EffectValue {
    /// An effect that does nothing: to be filled in.
    pub const NOTHING: Self = Self {
        name: "",
        keys: &[],
        called_for: |_| String::new(),
        levels: &[(Level::Exact, 0)],
        attenuation_db_per_km: |_, _| 0.0,
        at_place: None,
    };

    /// The level at which it is simulated where `level` is asked for: that or the next more exact one.
    #[must_use]
    pub fn at_least(&self, level: Level) -> Level {
        let next = self.levels.iter().find(|(own, _)| *own >= level);
        match (level, next) {
            (Level::Skipped, _) => Level::Skipped,
            (_, Some((own, _))) => *own,
            (_, None) => Level::Exact,
        }
    }

    /// The levels that a plan chooses from: none costs as much as a more exact one.
    pub fn worth(&self) -> impl Iterator<Item = Level> {
        let dearer = |of: &(Level, u32)| self.levels.iter().any(|m| m.0 > of.0 && m.1 <= of.1);
        self.levels.iter().filter(move |row| !dearer(row)).map(|row| row.0)
    }

    /// Time of a level per target and scan, ns.
    #[must_use]
    pub fn cost_ns(&self, level: Level) -> f64 {
        self.levels.iter().find(|row| row.0 == level).map_or(0.0, |row| f64::from(row.1))
    }
}
