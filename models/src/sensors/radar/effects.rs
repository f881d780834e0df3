//! The effects of a surface movement radar, and which of them a piece of physics has evaluated.

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
