//! Echoes become plots: detected, measured with the draws of their target and scan, stated on the ground; and the false
//! alarms between them.

use super::Asde;
use super::echo::Return;
use super::looks::NEXT;
use crate::draw::{DrawKey, Purpose, exponential, normal_pair, normal_pair_of, uniform};
use crate::frames::wrap_pi;
use crate::plot::{Plot, Polar, SensorKind};
use crate::sensors::measurement::{quantised, to_cartesian};
use crate::sensors::radar::detection::to_db;
use crate::sensors::radar::effects::RadarEffect;
use crate::sensors::radar::equation::Budget;
use crate::sensors::radar::extended::ExtentLevel;
use crate::sensors::radar::levels::{PdLevel, RadarLevels};
use crate::sensors::radar::parameters::DetectionRule;
use crate::sensors::{ScanInterval, Truth};
use crate::time::SimTime;
use rand::rngs::ChaCha8Rng;

/// A plot and what caused it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) plot: Plot,
    /// Place of the echo among the returns; `None` where noise alone crossed the threshold.
    pub(super) cause: Option<usize>,
    pub(super) draws: Draws,
}

/// What was drawn for one plot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Draws {
    pub(super) range_m: f64,
    pub(super) azimuth_rad: f64,
    pub(super) glint_along_m: f64,
    pub(super) glint_across_m: f64,
}

impl Asde {
    /// Detects and measures each group of echoes in one cell by its first.
    pub(super) fn measure_returns(
        &mut self,
        truth: &dyn Truth,
        interval: &ScanInterval,
        returns: &[Return],
        mut seen: Vec<Seen>,
    ) -> Vec<Seen> {
        seen.clear();
        for (i, r) in (0..).zip(returns) {
            if r.cell != i || r.look.number == NEXT {
                continue;
            }
            // One stream per target and scan; a second look within the scan is keyed by its number.
            let mut key = self.key(interval, truth.key(r.look.index));
            key.sensor |= u32::from(r.look.number) << 16;
            let found = self.measure(r, &mut key.rng(Purpose::RadarReturn));
            seen.extend(found.map(|(plot, draws)| Seen { plot, cause: Some(i as usize), draws }));
        }
        seen
    }

    /// Whether an echo is detected, and if so how strong this one look at it is: what the radar measures of it, per
    /// pulse. The same draw says both: an echo that is just detected just crosses the threshold.
    pub(super) fn detected(
        &mut self,
        levels: &RadarLevels,
        budget: &Budget,
        chance: f64,
    ) -> Option<f64> {
        let rain_w = budget.rain_w * self.rain_correlation;
        let background_w = budget.noise_w + rain_w + budget.ground_w + budget.other_w;
        let ratio = budget.signal_w / background_w;
        self.tally.count(RadarEffect::Detection);
        match self.parameters.detection {
            // The rule of the paper knows of no fluctuation.
            DetectionRule::Threshold => (ratio >= self.required).then(|| budget.scnr()),
            DetectionRule::Bernoulli => {
                let swerling = self.parameters.swerling;
                let pd = match levels.pd {
                    PdLevel::Exact => self.detector.probability(ratio, swerling),
                    PdLevel::Table => self.table.at(ratio),
                    PdLevel::Albersheim => self.detector.albersheim(ratio),
                };
                (chance < pd).then(|| {
                    // Clutter that the detector averages away still stands in the echo.
                    let whole = budget.signal_w / budget.scnr();
                    let share = (chance / pd).max(f64::MIN_POSITIVE);
                    let clutter = if whole > 0.0 { background_w / whole } else { 1.0 };
                    clutter * self.detector.measured_snr(ratio, swerling, share)
                })
            }
        }
    }

    /// Glint that is stated of every echo, m per axis; 0 where no target has an extent.
    pub(super) fn stated_glint_m(&self, levels: &RadarLevels) -> f64 {
        let extended = levels.glint && levels.extent != ExtentLevel::Point;
        if extended { self.parameters.glint_sigma_m } else { 0.0 }
    }

    /// Thermal standard deviations of range (m) and azimuth (rad).
    pub(super) fn sigmas(&self, scnr: f64, reflected: f64) -> (f64, f64) {
        let p = &self.parameters;
        let (range_m, azimuth_rad) = p.thermal_sigmas(scnr.max(self.least_ratio));
        let coupled = p.reflection_coupling * reflected * self.radar.pattern.azimuth_rad;
        (range_m, if coupled == 0.0 { azimuth_rad } else { libm::hypot(azimuth_rad, coupled) })
    }

    /// The plot of a measured slant range and azimuth: quantised, on the ground, with its covariance.
    pub(super) fn plot(
        &mut self,
        levels: &RadarLevels,
        time: SimTime,
        measured: Polar,
        scnr_db: f64,
    ) -> Plot {
        let p = &self.parameters;
        let (range_step, azimuth_step) = if levels.quantisation {
            self.tally.count(RadarEffect::Quantisation);
            (p.range_step_m, p.azimuth_step_deg.to_radians())
        } else {
            (0.0, 0.0)
        };
        let with_step = |sigma: f64, step: f64| {
            if step == 0.0 { sigma } else { (sigma * sigma + step * step / 12.0).sqrt() }
        };
        let polar = Polar {
            range_m: quantised(measured.range_m, range_step),
            azimuth_rad: wrap_pi(quantised(measured.azimuth_rad, azimuth_step)),
            sigma_range_m: with_step(measured.sigma_range_m, range_step),
            sigma_azimuth_rad: with_step(measured.sigma_azimuth_rad, azimuth_step),
            extent_m2: measured.extent_m2,
        };
        let down = p.antenna_height_m - p.assumed_height_m;
        // A range shorter than the height is reported below the antenna; its error is then all range.
        let ground_m = (polar.range_m * polar.range_m - down * down).max(0.0).sqrt();
        let slope = polar.range_m / ground_m.max(0.1 * polar.range_m);
        let cartesian = to_cartesian(
            ground_m,
            polar.azimuth_rad,
            polar.sigma_range_m * slope,
            polar.sigma_azimuth_rad,
        );
        Plot {
            sensor: self.id,
            kind: SensorKind::Asde,
            time,
            sequence: 0,
            position_m: self.site_m + cartesian.offset_m,
            axis: cartesian.axis,
            along_m2: cartesian.along_m2,
            across_m2: cartesian.across_m2,
            altitude_m: None,
            polar: Some(polar),
            identity: None,
            scnr_db: Some(scnr_db),
        }
    }

    /// Detects and measures one echo; all draws in a fixed order, whatever is switched on.
    fn measure(&mut self, r: &Return, rng: &mut ChaCha8Rng) -> Option<(Plot, Draws)> {
        let levels = &r.levels;
        let (chance, first, second) = (uniform(rng), uniform(rng), uniform(rng));
        // The glint's draws belong to the detected only: they are the last of a look, and a second look within
        // one scan has its own key.
        let strength = self.detected(levels, &r.budget, chance)?;
        let normal = normal_pair_of(first, second);
        let glint = if levels.glint && r.glint_along_m + r.glint_across_m > 0.0 {
            self.tally.count(RadarEffect::Glint);
            normal_pair(rng)
        } else {
            (0.0, 0.0)
        };
        let scnr = r.budget.scnr();
        let (thermal_range_m, thermal_azimuth_rad) = self.sigmas(scnr, r.budget.reflected);
        let mut draws = Draws {
            range_m: 0.0,
            azimuth_rad: 0.0,
            glint_along_m: r.glint_along_m * glint.0,
            glint_across_m: r.glint_across_m * glint.1,
        };
        if levels.thermal_range {
            self.tally.count(RadarEffect::ThermalRange);
            draws.range_m = thermal_range_m * normal.0;
        }
        if levels.thermal_azimuth {
            self.tally.count(RadarEffect::ThermalAzimuth);
            draws.azimuth_rad = thermal_azimuth_rad * normal.1;
        }
        let slant_m = r.range_m + draws.range_m + draws.glint_along_m;
        let ground_m = r.budget.range_m.max(1.0);
        // What is stated follows from what was measured: the strength of this look, and a glint for all alike.
        let (stated_range_m, stated_azimuth_rad) = self.sigmas(strength, r.budget.reflected);
        let glint_m = self.stated_glint_m(levels);
        // Whose middle is displayed has part of its echo in the display: there the extractor measures it.
        let shown_m = slant_m - self.folded_m(levels, r.budget.range_m);
        let shown = self.shown();
        let measured = Polar {
            range_m: shown_m.clamp(shown.low, shown.high),
            azimuth_rad: r.azimuth_rad + draws.azimuth_rad + draws.glint_across_m / ground_m,
            sigma_range_m: libm::hypot(stated_range_m, glint_m),
            sigma_azimuth_rad: libm::hypot(stated_azimuth_rad, glint_m / ground_m),
            extent_m2: None,
        };
        Some((self.plot(levels, r.look.time, measured, to_db(strength)), draws))
    }

    /// Expected false alarms of an interval: cells within the display range times their probability.
    #[must_use]
    pub fn false_alarms_per(&self, duration_s: f64) -> f64 {
        self.parameters.false_alarms_per_s() * duration_s
    }

    pub(super) fn false_alarms(
        &mut self,
        levels: &RadarLevels,
        interval: &ScanInterval,
        out: &mut Vec<Plot>,
    ) {
        let mut rng = self.key(interval, 0).rng(Purpose::FalseAlarms);
        let duration_s = interval.to.since_s(interval.from);
        let glint_m = self.stated_glint_m(levels);
        // A Poisson process: gaps are exponential, so the alarms come in time order.
        let rate = self.false_alarms_per(1.0);
        let mut late_s = 0.0;
        self.tally.count(RadarEffect::FalseAlarms);
        loop {
            late_s += exponential(&mut rng) / rate;
            if late_s > duration_s {
                return;
            }
            let along = uniform(&mut rng);
            let strength = self.detector.noise_snr(1.0 - uniform(&mut rng));
            let (sigma_range_m, sigma_azimuth_rad) = self.sigmas(strength, 0.0);
            let time =
                interval.from.plus_s(late_s).clamp(SimTime(interval.from.0 + 1), interval.to);
            let (near, far) = (self.parameters.range_min_m, self.parameters.range_max_m);
            let range_m = near + along * (far - near);
            let measured = Polar {
                range_m,
                azimuth_rad: self.beam_rad(time),
                sigma_range_m: libm::hypot(sigma_range_m, glint_m),
                sigma_azimuth_rad: libm::hypot(sigma_azimuth_rad, glint_m / range_m),
                extent_m2: None,
            };
            out.push(self.plot(levels, time, measured, to_db(strength)));
        }
    }

    pub(super) fn key(&self, interval: &ScanInterval, entity: u64) -> DrawKey {
        DrawKey {
            run_seed: interval.run_seed,
            sensor: u32::from(self.id.0),
            entity,
            scan: interval.scan,
        }
    }
}
