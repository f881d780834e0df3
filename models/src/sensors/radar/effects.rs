//! The effects of a surface movement radar, and which of them a piece of physics has evaluated.
//!
//! An effect that is told by what it does to one echo is a value ([`EffectValue`]) in a file of its own and one line in the
//! list below; what is entangled with others is a bare name, planned by hand.

pub mod value;

use self::value::EffectValue;
use crate::keys::Key;

macro_rules! effects {
    // A line `Name in file,` belongs to an effect as a value, `Name = "words",` to one that is planned by hand.
    (@lines [$($done:tt)*] [$($values:ident $variants:ident)*] $(#[$doc:meta])* $variant:ident in $file:ident, $($rest:tt)*) => {
        effects! {
            @lines [$($done)* ($(#[$doc])* #[doc = concat!("What `", stringify!($file), "` says.")] $variant, $file::VALUE.name, Some(&$file::VALUE))]
            [$($values $variants)* $file $variant] $($rest)*
        }
    };
    (@lines [$($done:tt)*] [$($values:ident $variants:ident)*] $(#[$doc:meta])* $variant:ident = $name:literal, $($rest:tt)*) => {
        effects! {
            @lines [$($done)* ($(#[$doc])* $variant, $name, None)] [$($values $variants)*] $($rest)*
        }
    };
    (@lines [$(($(#[$doc:meta])* $variant:ident, $name:expr, $value:expr))*] [$($file:ident $of:ident)*]) => {
        $(pub mod $file;)*

        /// An effect of the radar.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        #[repr(usize)]
        pub enum RadarEffect { $($(#[$doc])* $variant,)* }

        impl RadarEffect {
            /// All of them, in the order of the plan.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// Name in plans, reports and explanations.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// What it does, if it is told by that.
            #[must_use]
            pub fn value(self) -> Option<&'static EffectValue> {
                match self { $(Self::$variant => $value,)* }
            }
        }

        /// The effects that are values, in the order of the plan.
        pub const VALUES: &[(RadarEffect, &EffectValue)] = &[$((RadarEffect::$of, &$file::VALUE),)*];

        /// Their keys in scenes.
        pub const VALUE_KEYS: &[&[Key]] = &[$($file::VALUE.keys,)*];
    };
    (@$($wrong:tt)*) => { compile_error!("neither `Name in file,` nor `Name = \"words\",`"); };
    ($($lines:tt)*) => { effects! { @lines [] [] $($lines)* } };
}

effects! {
    /// Attenuation by rain.
    RainAttenuation = "rain attenuation",
    Fog in fog,
    Gases in gases,
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

/// Place of an effect among [`VALUES`].
#[must_use]
pub fn place(effect: RadarEffect) -> Option<usize> {
    VALUES.iter().position(|(own, _)| *own == effect)
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
pub struct Evaluated(u64);

const _: () = assert!(RadarEffect::ALL.len() <= 64, "a bit for each effect");

impl Evaluated {
    /// Adds one.
    pub fn add(&mut self, effect: RadarEffect) {
        self.0 |= 1 << effect as u64;
    }

    /// Whether an effect is among them.
    #[must_use]
    pub fn has(self, effect: RadarEffect) -> bool {
        self.0 >> effect as u64 & 1 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_evaluated_is_what_was_added() {
        let mut evaluated = Evaluated::default();
        assert!(RadarEffect::ALL.iter().all(|e| !evaluated.has(*e)));
        evaluated.add(RadarEffect::RainClutter);
        evaluated.add(RadarEffect::Processing);
        let mut tally = Tally::default();
        tally.note(evaluated);
        tally.note(evaluated);
        for &effect in RadarEffect::ALL {
            let added = matches!(effect, RadarEffect::RainClutter | RadarEffect::Processing);
            assert_eq!((evaluated.has(effect), tally.of(effect)), (added, 2 * u64::from(added)));
        }
    }
}
