//! The parameters of a surface movement radar and their limits.

use crate::environment::fog::FogLaw;
use crate::environment::rain::RainLaw;
use crate::environment::surface::{MATERIALS, Material};
use crate::environment::{SPEED_OF_LIGHT, wavelength_m};
use crate::keys::Key;
use crate::sensors::config::{ConfigError, check, number};
use crate::sensors::measurement::{angle_sigma, energy_ratio, range_sigma_m};
use crate::sensors::radar::antenna::Pattern;
use crate::sensors::radar::detection::{Swerling, from_db};
use crate::sensors::radar::effects::VALUE_KEYS;
use crate::sensors::radar::effects::value::OwnKeys;
use crate::sensors::radar::equation::{Polarisation, Radar, RadarNumbers};

/// How a target is declared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum DetectionRule {
    /// Wherever the signal to clutter and noise ratio reaches the required one.
    Threshold,
    /// By a draw against the probability of detection.
    #[default]
    Bernoulli,
}

/// Glint that an extractor states if nobody says more, m per axis (assumed: that of a medium jet).
pub const GLINT_SIGMA_M: f64 = 2.5;

/// Which energy the accuracy formulas use.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Energy {
    /// One pulse: pessimistic for the angle.
    #[default]
    SinglePulse,
    /// All pulses of the dwell, with the loss factor (at least 1) of a real extractor.
    Dwell {
        /// Factor on the standard deviations: 1.2 for the best correlator, 1.5 to 1.8 for a thresholded centroid.
        factor: f64,
    },
}

/// Everything that describes one surface movement radar except where it stands. Data, not code: the
/// named sets live in scene files.
#[derive(Clone, Debug, PartialEq)]
pub struct AsdeParameters {
    /// Carrier, GHz.
    pub carrier_ghz: f64,
    /// Peak power, W.
    pub peak_power_w: f64,
    /// Pulse length, s.
    pub pulse_s: f64,
    /// Intermediate frequency bandwidth, Hz.
    pub bandwidth_hz: f64,
    /// Noise figure, dB.
    pub noise_figure_db: f64,
    /// System losses, dB.
    pub system_loss_db: f64,
    /// Azimuth beamwidth at −3 dB, degrees.
    pub azimuth_beamwidth_deg: f64,
    /// Elevation beamwidth at −3 dB, degrees.
    pub elevation_beamwidth_deg: f64,
    /// Depression of the beam axis, degrees.
    pub tilt_deg: f64,
    /// Lower edge of a cosecant-squared coverage, degrees of depression; `None` without.
    pub csc2_limit_deg: Option<f64>,
    /// Gain, dBi.
    pub gain_dbi: f64,
    /// Height of the antenna above the surface, m.
    pub antenna_height_m: f64,
    /// Pulse repetition frequency, Hz.
    pub prf_hz: f64,
    /// Rotation, turns per minute, clockwise.
    pub rotation_rpm: f64,
    /// Where the beam points at time zero, degrees clockwise from north.
    pub start_azimuth_deg: f64,
    /// Polarisation.
    pub polarisation: Polarisation,
    /// Axial ratio of circular polarisation, dB.
    pub axial_ratio_db: f64,
    /// Loss of a complex target in circular against linear polarisation, dB.
    pub circular_target_loss_db: f64,
    /// One-way side lobe floor, dB.
    pub sidelobe_floor_db: f64,
    /// Recovery time after the pulse, s: nothing nearer than `c·(τ + recovery)/2` is seen.
    pub recovery_s: f64,
    /// Nearest slant range displayed, m.
    pub range_min_m: f64,
    /// Farthest slant range displayed, m.
    pub range_max_m: f64,
    /// False alarm probability per cell.
    pub pfa: f64,
    /// Detection probability that defines the required ratio of [`DetectionRule::Threshold`].
    pub pd: f64,
    /// Rule of detection.
    pub detection: DetectionRule,
    /// Fluctuation of the targets.
    pub swerling: Swerling,
    /// Energy in the accuracy formulas.
    pub energy: Energy,
    /// Range step of the extractor, m; 0 for none.
    pub range_step_m: f64,
    /// Azimuth step of the extractor, degrees; 0 for none.
    pub azimuth_step_deg: f64,
    /// Height above the surface that the extractor assumes when it turns slant into ground range, m.
    pub assumed_height_m: f64,
    /// Whether the carrier hops from pulse to pulse, so that rain clutter averages like noise and echoes of the pulse before, at
    /// another carrier than the receiver's, are not heard.
    pub frequency_agile: bool,
    /// Velocity spread of the rain, m/s (decorrelation without hopping).
    pub rain_spread_mps: f64,
    /// White error of an echo's centre that the extractor states for every target alike, standard deviation per axis, m:
    /// one plot does not tell how its target glints. In cells the extent of the echo itself says it.
    pub glint_sigma_m: f64,
    /// Coupling of the surface reflection into the azimuth error (κ).
    pub reflection_coupling: f64,
    /// Ground clutter: γ of the constant-γ model, dB.
    pub ground_gamma_db: f64,
    /// What the surface between radar and targets is made of.
    pub surface: &'static Material,
    /// Its rms height, m.
    pub roughness_m: f64,
    /// Top of the rain above the surface, m.
    pub rain_top_m: f64,
    /// Liquid water of fog from visibility.
    pub fog_law: FogLaw,
    /// Keys of effects that are values ([`VALUE_KEYS`]), as far as they are given.
    pub own: OwnKeys,
}

/// The parameters are usable, but one reaches beyond what its source covers, or says nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterWarning {
    /// Which parameter.
    pub key: &'static str,
    /// What about it, as a sentence that begins with the key.
    pub text: String,
}

impl AsdeParameters {
    /// Checks every parameter against its limits.
    ///
    /// # Errors
    /// The first parameter outside its limits, with its value and the limits.
    pub fn validate(&self) -> Result<Vec<ParameterWarning>, ConfigError> {
        check(KEYS, "carrier_ghz", self.carrier_ghz)?;
        check(KEYS, "peak_power_w", self.peak_power_w)?;
        check(KEYS, "pulse_s", self.pulse_s)?;
        check(KEYS, "bandwidth_hz", self.bandwidth_hz)?;
        check(KEYS, "noise_figure_db", self.noise_figure_db)?;
        check(KEYS, "system_loss_db", self.system_loss_db)?;
        check(KEYS, "azimuth_beamwidth_deg", self.azimuth_beamwidth_deg)?;
        check(KEYS, "elevation_beamwidth_deg", self.elevation_beamwidth_deg)?;
        check(KEYS, "tilt_deg", self.tilt_deg)?;
        if let Some(limit) = self.csc2_limit_deg {
            check(KEYS, "csc2_limit_deg", limit)?;
        }
        check(KEYS, "gain_dbi", self.gain_dbi)?;
        check(KEYS, "antenna_height_m", self.antenna_height_m)?;
        check(KEYS, "prf_hz", self.prf_hz)?;
        check(KEYS, "rotation_rpm", self.rotation_rpm)?;
        check(KEYS, "start_azimuth_deg", self.start_azimuth_deg)?;
        check(KEYS, "axial_ratio_db", self.axial_ratio_db)?;
        check(KEYS, "circular_target_loss_db", self.circular_target_loss_db)?;
        check(KEYS, "sidelobe_floor_db", self.sidelobe_floor_db)?;
        check(KEYS, "recovery_s", self.recovery_s)?;
        let ambiguous = 0.5 * SPEED_OF_LIGHT / self.prf_hz;
        number("range_max_m", self.range_max_m, 100.0, ambiguous.min(60_000.0))?;
        number("range_min_m", self.range_min_m, self.blind_m(), self.range_max_m)?;
        check(KEYS, "pfa", self.pfa)?;
        check(KEYS, "pd", self.pd)?;
        if let Energy::Dwell { factor } = self.energy {
            check(KEYS, "dwell_factor", factor)?;
        }
        check(KEYS, "range_step_m", self.range_step_m)?;
        check(KEYS, "azimuth_step_deg", self.azimuth_step_deg)?;
        number("assumed_height_m", self.assumed_height_m, 0.0, self.antenna_height_m)?;
        check(KEYS, "rain_spread_mps", self.rain_spread_mps)?;
        check(KEYS, "glint_sigma_m", self.glint_sigma_m)?;
        check(KEYS, "reflection_coupling", self.reflection_coupling)?;
        check(KEYS, "ground_gamma_db", self.ground_gamma_db)?;
        check(KEYS, "roughness_m", self.roughness_m)?;
        number("rain_top_m", self.rain_top_m, self.antenna_height_m, 20_000.0)?;
        for (&word, &value) in &self.own {
            let table = VALUE_KEYS.iter().find(|keys| keys.iter().any(|key| key.word == word));
            check(table.copied().unwrap_or_default(), word, value)?;
        }
        // Pulses on the target: the detector sums at least one and at most 512.
        number("pulses on target (prf, beamwidth, rotation)", self.pulses(), 0.5, 512.0)?;
        let (low, high) = self.surface.published_ghz;
        let limit = self.surface.extrapolated_ghz;
        number("carrier_ghz (for this surface)", self.carrier_ghz, low, limit)?;
        let mut warnings = Vec::new();
        if self.carrier_ghz > high {
            let text = format!(
                "surface = \"{}\": permittivity is published for {low} to {high} GHz and \
                 extrapolated to {} GHz",
                self.surface.name, self.carrier_ghz
            );
            warnings.push(ParameterWarning { key: "surface", text });
        }
        let pattern = self.radar().pattern;
        let most_dbi = 10.0 * libm::log10(pattern.directivity());
        if self.gain_dbi > most_dbi {
            let text = format!(
                "gain_dbi = {}: beams of {} by {} degrees{} have at most {most_dbi:.1} dBi",
                self.gain_dbi,
                self.azimuth_beamwidth_deg,
                self.elevation_beamwidth_deg,
                if self.csc2_limit_deg.is_some() { " and what is below them" } else { "" },
            );
            warnings.push(ParameterWarning { key: "gain_dbi", text });
        }
        let start_deg = pattern.skirt_start_rad().to_degrees();
        if let Some(limit) = self.csc2_limit_deg
            && !pattern.has_skirt()
        {
            let text = format!(
                "csc2_limit_deg = {limit}: the beam has half its power at {start_deg:.2} degrees of \
                 depression, so no cosecant-squared coverage begins above the limit, or below the horizon"
            );
            warnings.push(ParameterWarning { key: "csc2_limit_deg", text });
        }
        Ok(warnings)
    }

    /// Nothing nearer than this is seen, m: the receiver is off while the pulse leaves and recovers.
    #[must_use]
    pub fn blind_m(&self) -> f64 {
        0.5 * SPEED_OF_LIGHT * (self.pulse_s + self.recovery_s)
    }

    /// Turns per second.
    #[must_use]
    pub fn turns_per_s(&self) -> f64 {
        self.rotation_rpm / 60.0
    }

    /// Pulses while the beamwidth passes a target, not rounded.
    #[must_use]
    pub fn pulses(&self) -> f64 {
        self.prf_hz * self.azimuth_beamwidth_deg / (360.0 * self.turns_per_s())
    }

    /// Pulses that the detector sums: the nearest whole number, at least one.
    #[must_use]
    pub fn pulses_summed(&self) -> u32 {
        self.pulses().round().max(1.0) as u32
    }

    /// Sum of the two-way azimuth pattern over the pulses of a dwell: the energy of the dwell in
    /// energies of the pulse on the beam axis.
    #[must_use]
    pub fn dwell_energy(&self) -> f64 {
        (self.pulses() * (std::f64::consts::PI / (8.0 * std::f64::consts::LN_2)).sqrt()).max(1.0)
    }

    /// Factor on rain clutter in front of the detector: `n/n_e`, where `n_e` of the `n` pulses see
    /// independent rain. Rain decorrelates in `λ/(4πσ_v)` unless the carrier hops.
    #[must_use]
    pub fn rain_correlation(&self) -> f64 {
        if self.frequency_agile {
            return 1.0;
        }
        let n = self.pulses().max(1.0);
        let decorrelation_s =
            wavelength_m(self.carrier_ghz) / (4.0 * std::f64::consts::PI * self.rain_spread_mps);
        n / (1.0 + (n - 1.0) * (1.0 / (self.prf_hz * decorrelation_s)).min(1.0))
    }

    /// Range at which the next pulse leaves, m: echoes from beyond appear nearer by this.
    #[must_use]
    pub fn unambiguous_m(&self) -> f64 {
        0.5 * SPEED_OF_LIGHT / self.prf_hz
    }

    /// Slant range beyond which echoes are heard as those of the next pulse, m; infinite where that pulse has another carrier
    /// (Skolnik: pulse-to-pulse agility removes second-time-around echoes).
    #[must_use]
    pub fn second_trace_from_m(&self) -> f64 {
        if self.frequency_agile { f64::INFINITY } else { self.unambiguous_m() }
    }

    /// Expected false alarms per second: cells within the display range times their probability.
    #[must_use]
    pub fn false_alarms_per_s(&self) -> f64 {
        let cells = 360.0 / self.azimuth_beamwidth_deg
            * ((self.range_max_m - self.range_min_m) / (0.5 * SPEED_OF_LIGHT * self.pulse_s));
        self.pfa * cells * self.turns_per_s()
    }

    /// Thermal standard deviations of range (m) and azimuth (rad) at a signal to clutter and noise ratio.
    #[must_use]
    pub fn thermal_sigmas(&self, scnr: f64) -> (f64, f64) {
        let pulse = energy_ratio(scnr, self.bandwidth_hz, self.pulse_s);
        let (energy, factor) = match self.energy {
            Energy::SinglePulse => (pulse, 1.0),
            Energy::Dwell { factor } => (pulse * self.dwell_energy(), factor),
        };
        (
            factor * range_sigma_m(self.pulse_s, self.bandwidth_hz, energy),
            factor * angle_sigma(self.azimuth_beamwidth_deg.to_radians(), energy),
        )
    }

    /// The numbers as the budget wants them.
    #[must_use]
    pub fn radar(&self) -> Radar {
        let numbers = RadarNumbers {
            carrier_ghz: self.carrier_ghz,
            peak_power_w: self.peak_power_w,
            gain_dbi: self.gain_dbi,
            system_loss_db: self.system_loss_db,
            noise_figure_db: self.noise_figure_db,
            bandwidth_hz: self.bandwidth_hz,
            pulse_s: self.pulse_s,
        };
        let circular = self.polarisation == Polarisation::Circular;
        let pattern = Pattern {
            azimuth_rad: self.azimuth_beamwidth_deg.to_radians(),
            elevation_rad: self.elevation_beamwidth_deg.to_radians(),
            axis_rad: self.tilt_deg.to_radians(),
            skirt_end_rad: self.csc2_limit_deg.map(f64::to_radians),
            floor: from_db(self.sidelobe_floor_db),
        };
        Radar {
            carrier_ghz: self.carrier_ghz,
            wavelength_m: wavelength_m(self.carrier_ghz),
            constant: numbers.constant(),
            noise_w: numbers.noise_w(),
            cell_m: numbers.cell_m(),
            pattern,
            by_sine: pattern.by_sine(),
            antenna_m: self.antenna_height_m,
            polarisation: self.polarisation,
            axial_ratio_db: self.axial_ratio_db,
            circular_factor: if circular { from_db(-self.circular_target_loss_db) } else { 1.0 },
            ground_gamma: from_db(self.ground_gamma_db),
            surface: self.surface,
            roughness_m: self.roughness_m,
            rain_top_m: self.rain_top_m,
            fog_law: self.fog_law,
            own: self.own.clone(),
            beam: std::cell::OnceCell::new(),
            drops: std::cell::OnceCell::new(),
            rain_law: RainLaw::new(self.carrier_ghz, 0.0, self.polarisation.tilt_rad()),
        }
    }

    /// A Ku band radar in clear numbers, to which tests and benches compare. Scenes bring their own.
    #[must_use]
    pub fn ku_band() -> Self {
        Self {
            carrier_ghz: 16.0,
            peak_power_w: 3000.0,
            pulse_s: 36e-9,
            bandwidth_hz: 1.0 / 36e-9,
            noise_figure_db: 5.0,
            system_loss_db: 6.0,
            azimuth_beamwidth_deg: 0.25,
            elevation_beamwidth_deg: 1.6,
            tilt_deg: 1.0,
            csc2_limit_deg: Some(31.0),
            gain_dbi: 44.0,
            antenna_height_m: 60.0,
            prf_hz: 20_000.0,
            rotation_rpm: 60.0,
            start_azimuth_deg: 0.0,
            polarisation: Polarisation::Circular,
            axial_ratio_db: 1.0,
            circular_target_loss_db: 3.0,
            sidelobe_floor_db: -30.0,
            recovery_s: 100e-9,
            range_min_m: 100.0,
            range_max_m: 5500.0,
            pfa: 1e-6,
            pd: 0.9,
            detection: DetectionRule::Bernoulli,
            swerling: Swerling::Steady,
            energy: Energy::SinglePulse,
            range_step_m: 0.0,
            azimuth_step_deg: 0.0,
            assumed_height_m: 1.5,
            frequency_agile: true,
            rain_spread_mps: 1.5,
            glint_sigma_m: GLINT_SIGMA_M,
            reflection_coupling: 0.0,
            ground_gamma_db: -30.0,
            surface: &crate::environment::surface::MATERIALS[1],
            roughness_m: 0.003,
            rain_top_m: 3000.0,
            fog_law: FogLaw::TwoPoint,
            own: OwnKeys::new(),
        }
    }
}

/// Keys of a parameter set and of `overrides`. Limits that depend on other parameters are narrower.
pub(crate) const KEYS: &[Key] = &[
    Key::number("carrier_ghz", "GHz", 1.0, 100.0, "Carrier frequency").needed(),
    Key::number("peak_power_w", "W", 1e-3, 1e8, "Peak power of a pulse").needed(),
    Key::number("pulse_s", "s", 1e-9, 1e-3, "Length of a pulse").needed(),
    Key::number("bandwidth_hz", "Hz", 1e3, 1e10, "Bandwidth of the receiver").or("1 / pulse_s"),
    Key::number("noise_figure_db", "dB", 0.0, 40.0, "Noise figure of the receiver").needed(),
    Key::number("system_loss_db", "dB", 0.0, 60.0, "Losses that nothing else names").needed(),
    Key::number(
        "azimuth_beamwidth_deg",
        "°",
        0.01,
        30.0,
        "Width of the beam in azimuth at half power",
    )
    .needed(),
    Key::number(
        "elevation_beamwidth_deg",
        "°",
        0.05,
        90.0,
        "Width of the beam in elevation at half power",
    )
    .needed(),
    Key::number("tilt_deg", "°", -30.0, 60.0, "Depression of the beam's axis").needed(),
    Key::number(
        "csc2_limit_deg",
        "°",
        -30.0,
        90.0,
        "Depression to which cosecant-squared coverage reaches",
    )
    .or("no such coverage"),
    Key::number("gain_dbi", "dBi", 0.0, 70.0, "Gain of the antenna").needed(),
    Key::number(
        "antenna_height_m",
        "m",
        1.0,
        500.0,
        "Height of the antenna; the height of `site` goes before it",
    )
    .needed(),
    Key::number("prf_hz", "Hz", 100.0, 1e6, "Pulse repetition frequency").needed(),
    Key::number("rotation_rpm", "1/min", 1.0, 600.0, "Turns of the antenna").needed(),
    Key::number(
        "start_azimuth_deg",
        "°",
        -360.0,
        360.0,
        "Where the antenna looks when the run begins",
    )
    .or("0"),
    Key::word(
        "polarisation",
        || vec!["circular", "horizontal", "vertical"],
        "Polarisation of the wave",
    )
    .needed(),
    Key::number("axial_ratio_db", "dB", 0.0, 30.0, "Axial ratio of circular polarisation").needed(),
    Key::number(
        "circular_target_loss_db",
        "dB",
        0.0,
        20.0,
        "What circular polarisation takes of a target's echo",
    )
    .needed(),
    Key::number(
        "sidelobe_floor_db",
        "dB",
        -80.0,
        -3.0,
        "Level of the sidelobes below the beam's axis",
    )
    .needed(),
    Key::number("recovery_s", "s", 0.0, 1e-5, "Time after a pulse until the receiver hears")
        .needed(),
    Key::number("range_min_m", "m", 0.0, 60_000.0, "Nearest range that is shown").needed(),
    Key::number(
        "range_max_m",
        "m",
        100.0,
        60_000.0,
        "Farthest range that is shown; below the unambiguous one",
    )
    .needed(),
    Key::number("pfa", "", 1e-12, 0.1, "Probability of a false alarm in a cell").needed(),
    Key::number("pd", "", 0.01, 0.9999, "Probability of detection at the detector's design point")
        .needed(),
    Key::word(
        "detection",
        || vec!["threshold", "bernoulli"],
        "Detection by a threshold, or drawn with its probability",
    )
    .needed(),
    Key::whole("swerling", 0, 4, "Case of fluctuation").needed(),
    Key::word(
        "energy",
        || vec!["single_pulse", "dwell"],
        "What a range and angle are measured with",
    )
    .needed(),
    Key::number(
        "dwell_factor",
        "",
        1.0,
        10.0,
        "With `dwell`: what falls short of the ideal deviation",
    )
    .or("1.5"),
    Key::number("range_step_m", "m", 0.0, 100.0, "Steps of the range; 0: none").needed(),
    Key::number("azimuth_step_deg", "°", 0.0, 5.0, "Steps of the azimuth; 0: none").needed(),
    Key::number(
        "assumed_height_m",
        "m",
        0.0,
        500.0,
        "Height of a target that is assumed for its ground range",
    )
    .needed(),
    Key::flag("frequency_agile", "Whether the carrier hops from pulse to pulse").needed(),
    Key::number("rain_spread_mps", "m/s", 0.01, 20.0, "Spread of the speeds of rain").needed(),
    Key::number(
        "glint_sigma_m",
        "m",
        0.0,
        100.0,
        "Wander of the echo's centre on a large target, deviation",
    )
    .or("that of the model"),
    Key::number(
        "reflection_coupling",
        "",
        0.0,
        10.0,
        "How reflections at the surface shift the azimuth",
    )
    .needed(),
    Key::number("ground_gamma_db", "dB", -60.0, 10.0, "Echo of the ground at normal incidence")
        .needed(),
    Key::word("surface", || MATERIALS.iter().map(|m| m.name).collect(), "What the ground is of")
        .needed(),
    Key::number("roughness_m", "m", 0.0, 10.0, "Roughness of the ground, deviation of its height")
        .needed(),
    Key::number("rain_top_m", "m", 1.0, 20_000.0, "Top of the rain, above the antenna").needed(),
    Key::word("fog_law", || vec!["two_point", "eldridge"], "Water of fog by its visibility")
        .needed(),
];
