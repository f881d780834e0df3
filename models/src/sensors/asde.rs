//! A surface movement radar (ASDE, SMR): truth and weather in, plots out.

pub use super::asde_parameters::{AsdeParameters, DetectionRule, Energy, ParameterWarning};
use super::config::ConfigError;
use super::detection::{Detector, Swerling, to_db};
use super::measurement::{angle_sigma, energy_ratio, quantised, range_sigma_m, to_cartesian};
use super::radar_equation::{Air, Budget, BudgetLevels, Echo, Radar};
use super::{Cause, PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use crate::draw::{DrawKey, Purpose, exponential, normal_pair, uniform};
use crate::environment::Weather;
use crate::frames::{Azimuth, Vector2, wrap_pi};
use crate::plot::{Plot, Polar, SensorId, SensorKind};
use crate::time::SimTime;
use rand::rngs::ChaCha8Rng;
use std::f64::consts::TAU;

/// A surface movement radar at its place.
#[derive(Clone, Debug)]
pub struct Asde {
    id: SensorId,
    site_m: Vector2<f64>,
    parameters: AsdeParameters,
    radar: Radar,
    detector: Detector,
    /// Ratio at which a plot is declared (rule `threshold`).
    required: f64,
    /// Least ratio in the accuracy formulas: a detected echo has at least this.
    least_ratio: f64,
    levels: BudgetLevels,
    air: Option<Air>,
}

/// One look of the beam at one target.
#[derive(Clone, Copy, Debug)]
struct Look {
    time: SimTime,
    state: TargetState,
}

impl Asde {
    /// A radar with its antenna over `site_m` (east, north of the reference point).
    ///
    /// # Errors
    /// A parameter outside its limits.
    pub fn new(
        id: SensorId,
        site_m: Vector2<f64>,
        parameters: AsdeParameters,
    ) -> Result<Self, ConfigError> {
        parameters.validate()?;
        let detector = Detector::new(parameters.pulses_summed(), parameters.pfa);
        Ok(Self {
            id,
            site_m,
            radar: parameters.radar(),
            required: detector.required_snr(parameters.pd, parameters.swerling),
            least_ratio: detector.required_snr(0.1f64.max(2.0 * parameters.pfa), Swerling::Steady),
            detector,
            levels: BudgetLevels::MIDDLE,
            air: None,
            parameters,
        })
    }

    /// Where the beam points at `time`, radians clockwise from north, in [0, 2π).
    fn beam_rad(&self, time: SimTime) -> f64 {
        let start = self.parameters.start_azimuth_deg / 360.0;
        let turns = start + time.s() * self.parameters.turns_per_s();
        (turns - turns.floor()) * TAU
    }

    /// How far the beam has passed the target, in [0, 2π).
    fn passed_rad(&self, time: SimTime, azimuth_rad: f64) -> f64 {
        let passed = (self.beam_rad(time) - azimuth_rad).rem_euclid(TAU);
        // Rounding may give 2π itself.
        if passed >= TAU { 0.0 } else { passed }
    }

    fn azimuth_rad(&self, state: &TargetState) -> f64 {
        Azimuth::of(state.position_m.xy() - self.site_m).rad()
    }

    /// The looks at one target during the interval, in time order.
    ///
    /// The number of looks follows from the beam's angle past the target at both ends of the interval,
    /// and the end of one interval is the beginning of the next: no look is lost or seen twice,
    /// however the target moves across the beam's starting direction.
    fn looks(&self, interval: &ScanInterval, truth: &dyn Truth, index: usize, out: &mut Vec<Look>) {
        out.clear();
        let (first, last) = (truth.at(index, interval.from), truth.at(index, interval.to));
        let (Some(begin), Some(end)) = (first.or(last), last.or(first)) else { return };
        let far = self.parameters.range_max_m;
        let near = |state: &TargetState| {
            let reach = far + 1000.0;
            (state.position_m.xy() - self.site_m).norm_squared() < reach * reach
        };
        if !near(&begin) && !near(&end) {
            return;
        }
        let (azimuth_begin, azimuth_end) = (self.azimuth_rad(&begin), self.azimuth_rad(&end));
        let passed_begin = self.passed_rad(interval.from, azimuth_begin);
        let passed_end = self.passed_rad(interval.to, azimuth_end);
        let duration_s = interval.to.since_s(interval.from);
        let advance =
            duration_s * self.parameters.turns_per_s() * TAU - wrap_pi(azimuth_end - azimuth_begin);
        let looks = ((advance - (passed_end - passed_begin)) / TAU).round();
        if advance <= 0.0 {
            return;
        }
        for k in 1..=(looks.max(0.0) as u32) {
            let fraction = (TAU * f64::from(k) - passed_begin) / advance;
            let within = |time: SimTime| time.clamp(SimTime(interval.from.0 + 1), interval.to);
            let mut time = within(interval.from.plus_s(fraction * duration_s));
            let Some(mut state) = truth.at(index, time) else { continue };
            // The azimuth moved meanwhile: once more with the target where it is then.
            let miss = wrap_pi(self.azimuth_rad(&state) - self.beam_rad(time));
            let correction_s = miss / advance * duration_s;
            if correction_s.abs() > 1e-6 {
                time = within(time.plus_s(correction_s));
                let Some(moved) = truth.at(index, time) else { continue };
                state = moved;
            }
            out.push(Look { time, state });
        }
    }

    /// One look: budget, detection, measurement.
    fn observe(
        &self,
        air: &Air,
        look: &Look,
        class: &TargetClass,
        rng: &mut ChaCha8Rng,
    ) -> Option<Measured> {
        let offset = look.state.position_m.xy() - self.site_m;
        let ground_m = offset.norm();
        // The echo comes from the middle of the body; a body on the surface stands half its height above it.
        let height_m = look.state.position_m.z.max(0.5 * class.height_m);
        let echo = Echo { ground_m, height_m, extent_m: class.height_m, rcs_m2: class.rcs_m2 };
        let target_m = look.state.position_m.xy();
        let budget = self.radar.budget(air, &self.levels, &echo, self.site_m, target_m);
        // All draws of a look are taken in this order whether it is detected or not.
        let chance = uniform(rng);
        let (normal_range, normal_azimuth) = normal_pair(rng);
        if budget.range_m < self.parameters.range_min_m
            || budget.range_m > self.parameters.range_max_m
        {
            return None;
        }
        let ratio = self.detection_ratio(&budget);
        let detected = match self.parameters.detection {
            DetectionRule::Threshold => ratio >= self.required,
            DetectionRule::Bernoulli => {
                chance < self.detector.probability(ratio, self.parameters.swerling)
            }
        };
        let plot = detected.then(|| {
            let (sigma_range_m, sigma_azimuth_rad) = self.sigmas(budget.scnr(), budget.reflected);
            let azimuth = Azimuth::of(offset).rad();
            self.plot(
                look.time,
                budget.range_m + sigma_range_m * normal_range,
                azimuth + sigma_azimuth_rad * normal_azimuth,
                sigma_range_m,
                sigma_azimuth_rad,
                to_db(budget.scnr()),
            )
        });
        Some(Measured { plot })
    }

    /// Signal to clutter and noise in front of the detector.
    fn detection_ratio(&self, budget: &Budget) -> f64 {
        let correlation = self.parameters.rain_correlation();
        budget.signal_w / (budget.noise_w + budget.rain_w * correlation + budget.ground_w)
    }

    /// Thermal standard deviations of range (m) and azimuth (rad).
    fn sigmas(&self, scnr: f64, reflected: f64) -> (f64, f64) {
        let p = &self.parameters;
        let pulse = energy_ratio(scnr.max(self.least_ratio), p.bandwidth_hz, p.pulse_s);
        let (energy, factor) = match p.energy {
            Energy::SinglePulse => (pulse, 1.0),
            Energy::Dwell { factor } => (pulse * p.dwell_energy(), factor),
        };
        let beam = self.radar.pattern.azimuth_rad;
        let thermal = factor * angle_sigma(beam, energy);
        let coupled = p.reflection_coupling * reflected * beam;
        (
            factor * range_sigma_m(p.pulse_s, p.bandwidth_hz, energy),
            if coupled == 0.0 { thermal } else { libm::hypot(thermal, coupled) },
        )
    }

    /// The plot of a measured slant range and azimuth: quantised, on the ground, with its covariance.
    fn plot(
        &self,
        time: SimTime,
        range_m: f64,
        azimuth_rad: f64,
        sigma_range_m: f64,
        sigma_azimuth_rad: f64,
        scnr_db: f64,
    ) -> Plot {
        let p = &self.parameters;
        let azimuth_step = p.azimuth_step_deg.to_radians();
        let range_m = quantised(range_m, p.range_step_m);
        let azimuth_rad = wrap_pi(quantised(azimuth_rad, azimuth_step));
        let with_step = |sigma: f64, step: f64| {
            if step == 0.0 { sigma } else { (sigma * sigma + step * step / 12.0).sqrt() }
        };
        let sigma_range_m = with_step(sigma_range_m, p.range_step_m);
        let sigma_azimuth_rad = with_step(sigma_azimuth_rad, azimuth_step);
        let down = p.antenna_height_m - p.assumed_height_m;
        // A range shorter than the height is reported below the antenna; its error is then all range.
        let ground_m = (range_m * range_m - down * down).max(0.0).sqrt();
        let slope = range_m / ground_m.max(0.1 * range_m);
        let cartesian =
            to_cartesian(ground_m, azimuth_rad, sigma_range_m * slope, sigma_azimuth_rad);
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
            polar: Some(Polar { range_m, azimuth_rad, sigma_range_m, sigma_azimuth_rad }),
            identity: None,
            scnr_db: Some(scnr_db),
        }
    }

    /// Expected false alarms of an interval: cells within the display range times their probability.
    #[must_use]
    pub fn false_alarms_per(&self, duration_s: f64) -> f64 {
        let p = &self.parameters;
        let cells = TAU / self.radar.pattern.azimuth_rad
            * ((p.range_max_m - p.range_min_m) / self.radar.cell_m);
        p.pfa * cells * duration_s * p.turns_per_s()
    }

    fn false_alarms(&self, interval: &ScanInterval, out: &mut Vec<Plot>) {
        let key = DrawKey {
            run_seed: interval.run_seed,
            sensor: u32::from(self.id.0),
            entity: 0,
            scan: interval.scan,
        };
        let mut rng = key.rng(Purpose::FalseAlarms);
        let duration_s = interval.to.since_s(interval.from);
        let p = &self.parameters;
        let ratio = self.required;
        let (sigma_range_m, sigma_azimuth_rad) = self.sigmas(ratio, 0.0);
        // A Poisson process: gaps are exponential, so the alarms come in time order.
        let rate = self.false_alarms_per(1.0);
        let mut late_s = 0.0;
        loop {
            late_s += exponential(&mut rng) / rate;
            if late_s > duration_s {
                return;
            }
            let along = uniform(&mut rng);
            let time =
                interval.from.plus_s(late_s).clamp(SimTime(interval.from.0 + 1), interval.to);
            let range_m = p.range_min_m + along * (p.range_max_m - p.range_min_m);
            let azimuth = self.beam_rad(time);
            out.push(self.plot(
                time,
                range_m,
                azimuth,
                sigma_range_m,
                sigma_azimuth_rad,
                to_db(ratio),
            ));
        }
    }
}

/// What one look within the display range gave.
struct Measured {
    plot: Option<Plot>,
}

impl Sensor for Asde {
    fn id(&self) -> SensorId {
        self.id
    }

    fn kind(&self) -> SensorKind {
        SensorKind::Asde
    }

    fn scan(
        &mut self,
        interval: &ScanInterval,
        truth: &dyn Truth,
        weather: &Weather,
        out: &mut PlotSink,
    ) {
        let air = match self.air.take() {
            Some(air) if air.weather == *weather => air,
            _ => self.radar.air(weather),
        };
        let mut sequence = 0;
        let mut looks = Vec::with_capacity(2);
        for index in 0..truth.len() {
            self.looks(interval, truth, index, &mut looks);
            if looks.is_empty() {
                continue;
            }
            let key = DrawKey {
                run_seed: interval.run_seed,
                sensor: u32::from(self.id.0),
                entity: truth.key(index),
                scan: interval.scan,
            };
            // One stream per target and scan; a second look takes the numbers after the first.
            let mut rng = key.rng(Purpose::RadarReturn);
            for look in &looks {
                let measured = self.observe(&air, look, truth.class(index), &mut rng);
                out.looks += u64::from(measured.is_some());
                if let Some(mut plot) = measured.and_then(|m| m.plot) {
                    plot.sequence = sequence;
                    sequence += 1;
                    out.plots.push(plot);
                    out.causes.push(Cause {
                        key: Some(truth.key(index)),
                        truth_m: Some(look.state.position_m.xy()),
                        effects: Vec::new(),
                    });
                }
            }
        }
        let mut alarms = Vec::new();
        self.false_alarms(interval, &mut alarms);
        for mut plot in alarms {
            plot.sequence = sequence;
            sequence += 1;
            out.plots.push(plot);
            out.causes.push(Cause::default());
        }
        self.air = Some(air);
    }
}

#[cfg(test)]
mod tests;
