//! The outcome test of a box: what a sum of losses does to plots, detection and false plots there.

use super::bounds::BoxBounds;
use super::class::ClassFacts;
use crate::effects::choice::Sum;
use crate::effects::outcome::{
    AxisShift, MEAN_ABS, StepTable, TrackGain, detection_change, shift_by_ratio, tail,
};
use crate::effects::{Loss, Tolerance};
use crate::sensors::radar::detection::{PdTable, from_db, to_db};
use crate::sensors::radar::parameters::{AsdeParameters, DetectionRule};

/// What of a plot's own draws is left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// Glint.
    pub glint: bool,
    /// Thermal error of the range.
    pub range: bool,
    /// Thermal error of the azimuth.
    pub azimuth: bool,
    /// Steps of the extractor.
    pub steps: bool,
}

/// The losses of a choice in one box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BoxLoss {
    /// In numbers.
    pub loss: Loss,
    /// What is left out of the draws.
    pub out: LeftOut,
}

impl Sum for BoxLoss {
    const NONE: Self = Self {
        loss: Loss::NONE,
        out: LeftOut { glint: false, range: false, azimuth: false, steps: false },
    };

    fn is_none(&self) -> bool {
        *self == Self::NONE
    }

    fn plus(&self, other: &Self) -> Self {
        Self {
            loss: self.loss.plus(other.loss),
            out: LeftOut {
                glint: self.out.glint || other.out.glint,
                range: self.out.range || other.out.range,
                azimuth: self.out.azimuth || other.out.azimuth,
                steps: self.out.steps || other.out.steps,
            },
        }
    }
}

/// What a sum of losses may do at most.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effect {
    /// Rms shift of a plot, m.
    pub rms_m: f64,
    /// Share of plots shifted by more than five times the tolerated rms.
    pub tail: f64,
    /// Share of scans with the plot in one run only.
    pub detection: f64,
    /// False plots and ghosts of one run only, per scan.
    pub false_plots: f64,
    /// Rms shift of a track, where asked for, m.
    pub track_m: Option<f64>,
}

impl Effect {
    /// The largest share of a tolerance; infinite where something moves that may not.
    #[must_use]
    pub fn share(&self, tolerance: &Tolerance, false_plots: f64) -> f64 {
        let share = |value: f64, limit: f64| match () {
            () if value == 0.0 => 0.0,
            () if value.is_nan() || limit <= 0.0 => f64::INFINITY,
            () => value / limit,
        };
        let track = self.track_m.zip(tolerance.track_m).map_or(0.0, |(m, limit)| share(m, limit));
        share(self.rms_m, tolerance.position_m)
            .max(share(self.tail, tolerance.tail))
            .max(share(self.detection, tolerance.detection))
            .max(share(self.false_plots, false_plots))
            .max(track)
    }
}

/// One axis of a plot in a box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Axis {
    /// Thermal deviation at ratio 1, in the axis' own unit.
    sigma_1: f64,
    /// Metres on the ground per unit, at most.
    per_unit_m: f64,
    /// Step, in the unit.
    step: f64,
    /// Least glint, in the unit.
    least_glint: f64,
    /// Largest glint on the ground, m.
    most_glint_m: f64,
}

/// The test of one box.
#[derive(Clone, Debug)]
pub struct BoxOutcome<'a> {
    parameters: &'a AsdeParameters,
    table: &'a PdTable,
    steps: &'a StepTable,
    required_db: f64,
    least_ratio: f64,
    ratio: (f64, f64),
    ratio_db: (f64, f64),
    axes: [Axis; 2],
    /// Largest range on the ground, m.
    lever_m: f64,
    /// Largest amplitude of the reflection, and what couples it into the azimuth, rad.
    coupling_rad: (f64, f64),
    gain: Option<TrackGain>,
    /// Whether nothing can be said: near the foot of the tower.
    blind: bool,
    /// Nearest slant range, m.
    nearest_m: f64,
    /// Whether steps carry plots: always, but for a planted fault.
    flips: bool,
}

/// What an outcome test needs beside a box.
#[derive(Clone, Copy, Debug)]
pub struct Detection<'a> {
    /// Parameters of the radar.
    pub parameters: &'a AsdeParameters,
    /// Its detection, in a table.
    pub table: &'a PdTable,
    /// Factors of the steps.
    pub steps: &'a StepTable,
    /// Ratio of the threshold rule.
    pub required: f64,
    /// Least ratio of the accuracy formulas.
    pub least_ratio: f64,
}

impl<'a> BoxOutcome<'a> {
    /// The test of a class in a box whose nearest ground distance is `nearest_m`.
    #[must_use]
    pub fn new(
        radar: &Detection<'a>,
        facts: &ClassFacts,
        bounds: &BoxBounds,
        nearest_m: f64,
        tolerance: &Tolerance,
    ) -> Self {
        let p = radar.parameters;
        let (sigma_range, sigma_azimuth) = p.thermal_sigmas(1.0);
        let sigma = |sigma_1: f64, ratio: f64| sigma_1 / ratio.max(radar.least_ratio).sqrt();
        // Plots may lie nearer than their target by its errors.
        let below = p.antenna_height_m - p.assumed_height_m;
        let shift = facts.bias_m + 6.0 * (facts.along_m.1 + sigma(sigma_range, bounds.ratio.low));
        let plot_m = bounds.range_m.low.max(p.range_min_m) - shift;
        let blind = plot_m <= 1.05 * below.abs() || !(bounds.ratio.low >= 0.0);
        let slope =
            if blind { f64::INFINITY } else { plot_m / (plot_m * plot_m - below * below).sqrt() };
        let far_m = bounds.range_m.high + shift;
        let lever_m = (far_m * far_m - below * below).max(0.0).sqrt();
        let projection = (nearest_m / bounds.range_m.low.max(1.0)).min(1.0);
        let axes = [
            Axis {
                sigma_1: sigma_range,
                per_unit_m: slope,
                step: p.range_step_m,
                least_glint: facts.along_m.0 * projection,
                most_glint_m: facts.along_m.1 * slope,
            },
            Axis {
                sigma_1: sigma_azimuth,
                per_unit_m: lever_m,
                step: p.azimuth_step_deg.to_radians(),
                least_glint: facts.across_m.0 / far_m,
                most_glint_m: facts.across_m.1 * 1.02,
            },
        ];
        let coupling = p.reflection_coupling * p.azimuth_beamwidth_deg.to_radians();
        let gain = tolerance.track_m.map(|_| {
            let own = |axis: &Axis| sigma(axis.sigma_1, bounds.ratio.high) * axis.per_unit_m;
            let [range_m, azimuth_m] = [own(&axes[0]), own(&axes[1])];
            let least = range_m.min(azimuth_m).max(0.01);
            let period_s = 1.0 / p.turns_per_s();
            let whole = TrackGain { gain: 1.0, noise_gain: 1.0 };
            TrackGain::steady(period_s, tolerance.jerk_m2_s5, least * least).unwrap_or(whole)
        });
        Self {
            parameters: p,
            table: radar.table,
            steps: radar.steps,
            required_db: to_db(radar.required),
            least_ratio: radar.least_ratio,
            ratio: (bounds.ratio.low, bounds.ratio.high),
            ratio_db: (to_db(bounds.ratio.low), to_db(bounds.ratio.high)),
            axes,
            lever_m,
            coupling_rad: (coupling * bounds.reflection.most, coupling),
            gain,
            blind,
            nearest_m: bounds.range_m.low.max(1.0),
            flips: true,
        }
    }

    fn sigma(&self, axis: &Axis, ratio: f64) -> f64 {
        axis.sigma_1 / ratio.max(self.least_ratio).sqrt()
    }

    /// The shift along one axis.
    fn axis(&self, index: usize, sum: &BoxLoss) -> AxisShift {
        let (axis, loss, out) = (&self.axes[index], &sum.loss, &sum.out);
        let thermal_out = if index == 0 { out.range } else { out.azimuth };
        let weakest = self.ratio.0 * from_db(-loss.lowers_db);
        let most = self.sigma(axis, weakest);
        let least = self.sigma(axis, self.ratio.1);
        let mut drawn = if thermal_out {
            most
        } else {
            let lowest = self.ratio.0;
            shift_by_ratio(axis.sigma_1, self.least_ratio, lowest, loss.raises_db, loss.lowers_db)
        };
        if index == 1 {
            drawn += if thermal_out { self.coupling_rad.0 } else { loss.coupled_rad };
        }
        let per_unit = axis.per_unit_m;
        let to_ground = if index == 0 { per_unit } else { 1.02 };
        let mut shift = AxisShift {
            drawn_m: drawn * per_unit,
            fixed_m: if loss.fixed_m > 0.0 { loss.fixed_m * to_ground } else { 0.0 },
            own_m: if out.glint { axis.most_glint_m } else { loss.own_m2.sqrt() * to_ground },
            step_m: if out.steps || !self.flips { 0.0 } else { axis.step * per_unit },
            factors: (MEAN_ABS, 1.0),
            ..AxisShift::default()
        };
        if index == 0 {
            shift.fixed_m += self.bent_m(sum);
        }
        if axis.step == 0.0 {
            shift.step_m = 0.0;
            return shift;
        }
        let by_glint = !out.glint && axis.least_glint >= 0.4 * axis.step;
        if out.steps {
            let spread = by_glint || (!thermal_out && least >= 0.4 * axis.step);
            let step_m = axis.step * per_unit;
            if spread {
                shift.own_m = (shift.own_m * shift.own_m + step_m * step_m / 12.0).sqrt();
            } else {
                shift.bounded_m = 0.5 * step_m;
            }
        } else if !(by_glint || (!thermal_out && least >= axis.step)) {
            shift.on_edge = thermal_out;
            // The edge factor times the deviation grows with the deviation; the density falls with it.
            shift.factors.0 = self.steps.at(axis.step / most).0;
            shift.factors.1 = self.steps.at(axis.step / least).1;
        }
        shift
    }

    /// Change of the range by the unbiased conversion, which reckons with the stated error of the azimuth.
    fn bent_m(&self, sum: &BoxLoss) -> f64 {
        let (loss, out, axis) = (&sum.loss, &sum.out, &self.axes[1]);
        let changed = loss.raises_db > 0.0
            || loss.lowers_db > 0.0
            || loss.coupled_rad > 0.0
            || out.glint
            || out.steps;
        if !changed {
            return 0.0;
        }
        let coupled = self.coupling_rad.0;
        // What is stated: the thermal error of the look, by its strength, and a glint for all alike.
        let stated_m = self.parameters.glint_sigma_m;
        let glint = stated_m / self.nearest_m;
        let step2 = axis.step * axis.step / 12.0;
        let range_step2 = self.axes[0].step * self.axes[0].step / 12.0;
        if self.is_never_bent(stated_m, (step2, range_step2)) {
            let planned_m = if out.glint { 0.0 } else { stated_m };
            let steps = if out.steps { (0.0, 0.0) } else { (step2, range_step2) };
            if self.is_never_bent(planned_m, steps) {
                return 0.0;
            }
        }
        let weakest = self.ratio.0 * from_db(-loss.lowers_db);
        let thermal = self.sigma(axis, weakest);
        let square = thermal * thermal + coupled * coupled + glint * glint + step2;
        let share =
            -libm::expm1(-(loss.raises_db + loss.lowers_db) * std::f64::consts::LN_10 / 10.0);
        let moved = thermal * thermal * share
            + if loss.coupled_rad > 0.0 { 2.0 * coupled * loss.coupled_rad } else { 0.0 }
            + if out.glint { glint * glint } else { 0.0 }
            + if out.steps { step2 } else { 0.0 };
        let jump = (0.5 * self.lever_m * square)
            .min(0.05 * libm::hypot(self.sigma(&self.axes[0], weakest), stated_m));
        (0.5 * self.lever_m * moved + jump) * self.axes[0].per_unit_m
    }

    /// Whether the arc is never bent by more than a tenth of the range error, however strong a look: the bend
    /// grows in proportion to 1 over the strength, the error with its root, so both ends decide. `glint_m` is
    /// the stated glint, `steps2` the variances of the steps in azimuth and range.
    fn is_never_bent(&self, glint_m: f64, steps2: (f64, f64)) -> bool {
        let (range, azimuth) = (&self.axes[0], &self.axes[1]);
        let (coupled, glint) = (self.coupling_rad.0, glint_m / self.nearest_m);
        let straight = |range2: f64, azimuth2: f64| {
            let bend = azimuth2 + coupled * coupled + glint * glint + steps2.0;
            self.lever_m * bend <= 0.1 * (range2 + glint_m * glint_m + steps2.1).sqrt()
        };
        let square = |axis: &Axis| {
            let weakest = self.sigma(axis, 0.0);
            weakest * weakest
        };
        straight(0.0, 0.0) && straight(square(range), square(azimuth))
    }

    /// What a sum of losses may do at most; `quick` takes the bound of the table's steepest slope for the
    /// detection, which is never less.
    #[must_use]
    pub fn effect(&self, sum: &BoxLoss, tolerance: &Tolerance, quick: bool) -> Effect {
        let loss = &sum.loss;
        let nothing = *sum == BoxLoss::NONE;
        if nothing {
            return Effect { track_m: tolerance.track_m.map(|_| 0.0), ..Effect::default() };
        }
        if self.blind || !loss.is_known() {
            let all = f64::INFINITY;
            return Effect {
                rms_m: all,
                tail: 1.0,
                detection: 1.0,
                false_plots: all,
                track_m: Some(all),
            };
        }
        let axes = [self.axis(0, sum), self.axis(1, sum)];
        let square = axes[0].square_m2() + axes[1].square_m2();
        Effect {
            rms_m: square.sqrt(),
            tail: tail(&axes, 5.0 * tolerance.position_m),
            detection: loss.odds + self.missed(loss, quick),
            false_plots: loss.false_plots,
            track_m: self.track_m(&axes, square),
        }
    }

    /// Rms shift of a track, where asked for, m.
    fn track_m(&self, axes: &[AxisShift; 2], square: f64) -> Option<f64> {
        let fixed2: f64 = axes.iter().map(|a| a.fixed_m * a.fixed_m).sum();
        self.gain.map(|gain| gain.shift_m((square - fixed2).max(0.0).sqrt(), fixed2.sqrt()))
    }

    /// Whether a sum of losses takes at most `limit` of each tolerance: what [`Self::effect`] says, without
    /// what need not be known for it.
    #[must_use]
    pub fn fits(&self, sum: &BoxLoss, tolerance: &Tolerance, false_plots: f64, limit: f64) -> bool {
        let loss = &sum.loss;
        if *sum == BoxLoss::NONE {
            return true;
        }
        if self.blind || !loss.is_known() {
            return false;
        }
        let within = |part: Effect| part.share(tolerance, false_plots) <= limit;
        let axes = [self.axis(0, sum), self.axis(1, sum)];
        let square = axes[0].square_m2() + axes[1].square_m2();
        let track_m = self.track_m(&axes, square);
        let moved = Effect { rms_m: square.sqrt(), track_m, ..Effect::default() };
        if !within(Effect { false_plots: loss.false_plots, ..moved }) {
            return false;
        }
        let detection = |missed: f64| Effect { detection: loss.odds + missed, ..Effect::default() };
        if !within(detection(0.0)) {
            return false;
        }
        let tail = tail(&axes, 5.0 * tolerance.position_m);
        within(Effect { tail, ..Effect::default() })
            && (within(detection(self.missed(loss, true)))
                || within(detection(self.missed(loss, false))))
    }

    fn missed(&self, loss: &Loss, quick: bool) -> f64 {
        let (raises, lowers) = (loss.raises_db, loss.lowers_db);
        if raises <= 0.0 && lowers <= 0.0 {
            return 0.0;
        }
        let (low, high) = self.ratio_db;
        match self.parameters.detection {
            DetectionRule::Threshold => {
                let within = low - lowers <= self.required_db && self.required_db <= high + raises;
                if within { 1.0 } else { 0.0 }
            }
            DetectionRule::Bernoulli if quick => {
                let (pd, slope) = self.table.from_db_up(low - lowers);
                (1.0 - pd).min(slope * raises.max(lowers))
            }
            DetectionRule::Bernoulli => {
                let pd = |db: f64| self.table.at_db(db);
                // Outside the window the table stands still: within its error nothing changes.
                let (from, to) = self.table.window_db();
                let clamp = |db: f64| db.clamp(from - raises, to + lowers).clamp(low, high);
                detection_change(pd, (clamp(low), clamp(high)), raises, lowers, 14)
            }
        }
    }
}

impl BoxOutcome<'_> {
    /// Plants a fault: steps carry nothing.
    pub(super) fn without_flips(&mut self) {
        self.flips = false;
    }

    /// Thermal deviations at the least ratio and half steps of both axes, on the ground, m.
    #[must_use]
    pub fn own_m(&self) -> (f64, f64, f64) {
        let sigma = |i: usize| self.sigma(&self.axes[i], self.ratio.0) * self.axes[i].per_unit_m;
        let step = |i: usize| match self.axes[i].step {
            0.0 => 0.0,
            step => 0.5 * step * self.axes[i].per_unit_m,
        };
        (sigma(0), sigma(1), libm::hypot(step(0), step(1)))
    }
}
