//! A surface movement radar (ASDE, SMR): truth and weather in, plots out.
//!
//! A scan has three passes: where each target is when the beam points at it; what each echo is worth
//! in watts, with shadows; which echoes share a cell. Then every echo is detected and measured with
//! the draws of its own target and scan.

mod assign;
mod cells;
mod declared;
mod echo;
mod explain;
mod ghosts;
mod looks;
mod measuring;
mod merging;
mod pairs;
pub mod picture;
pub mod plan;
pub mod survey;

pub use declared::{ALL_KEYS, DECLARED};

use crate::effects::{PlanRow, Tolerance};
use crate::environment::Weather;
use crate::frames::{Azimuth, Point2, wrap_pi};
use crate::plot::{Plot, SensorId, SensorKind};
use crate::sensors::config::ConfigError;
use crate::sensors::radar::aspect::AspectTables;
use crate::sensors::radar::detection::{Detector, PdTable, Swerling};
use crate::sensors::radar::effects::{RadarEffect, Tally};
use crate::sensors::radar::equation::{Air, Radar};
use crate::sensors::radar::ghost::{Facade, facades};
use crate::sensors::radar::levels::{Processing, RadarLevels, ShadowLevel};
pub use crate::sensors::radar::parameters::{
    AsdeParameters, DetectionRule, Energy, GLINT_SIGMA_M, ParameterWarning,
};
use crate::sensors::radar::shadow::{Building, Skyline, Traffic};
use crate::sensors::radar::video::CellRadar;
use crate::sensors::{Cause, PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use crate::time::SimTime;
pub use assign::Placed;
use assign::{Assignment, Mirrored};
use cells::WindowWork;
use echo::Return;
use looks::{End, Look, NEXT, Occluding};
use measuring::Seen;
use merging::Place;
use plan::Planner;
use std::sync::Arc;

/// A surface movement radar at its place.
#[derive(Clone, Debug)]
pub struct Asde {
    id: SensorId,
    site_m: Point2<f64>,
    parameters: AsdeParameters,
    radar: Radar,
    detector: Detector,
    grid: CellRadar,
    table: PdTable,
    /// Ratio at which a plot is declared (rule `threshold`).
    required: f64,
    /// Least ratio in the accuracy formulas: a detected echo has at least this.
    least_ratio: f64,
    buildings: Arc<[Building]>,
    skyline: Skyline,
    facades: Vec<Facade>,
    tolerance: Tolerance,
    /// A fault planted in its plan.
    fault: Option<plan::Fault>,
    /// Levels that no plan changes, for comparisons.
    fixed: Option<RadarLevels>,
    /// How echoes become plots; `None` where the plan chooses.
    processing: Option<Processing>,
    planner: Planner,
    /// Centroids of the classes met, by aspect.
    aspects: AspectTables,
    /// The plan for people, and what it shows: version of the planner, processing, facts of the scan.
    rows: (Option<(u64, Processing, ScanFacts)>, Vec<PlanRow>),
    /// Which rings and sectors the facades may mirror.
    mirrored: Mirrored,
    air: Option<Air>,
    tally: Tally,
    work: Work,
    /// Factor on rain clutter in front of the detector.
    rain_correlation: f64,
    /// Echoes just behind the end of the last interval that its last plots have taken in.
    taken: Taken,
}

/// Targets whose echo the beam had begun to paint when an interval ended.
#[derive(Clone, Debug, Default)]
struct Taken {
    /// The end of that interval.
    at: SimTime,
    /// Their keys.
    keys: Vec<u64>,
}

/// What a scan found that concerns the plan as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct ScanFacts {
    /// Whether some target was simulated exactly because it is in no planned box.
    exactly: bool,
    /// Whether some may share a cell.
    pairs: bool,
    /// Whether an aircraft stands before another target.
    shadows: bool,
    /// Whether a target is beyond the unambiguous range.
    beyond: bool,
}

/// Space that is used again from scan to scan.
#[derive(Clone, Debug, Default)]
struct Work {
    looks: Vec<Look>,
    /// Where each target is at the end of the scan.
    ends: Vec<Option<End>>,
    returns: Vec<Return>,
    traffic: Traffic,
    order: Vec<Place>,
    seen: Vec<Seen>,
    windows: WindowWork,
    occluding: Occluding,
    assignment: Assignment,
}

impl Asde {
    /// A radar with its antenna over `site_m` (east, north of the reference point), in the open, at
    /// the default tolerance.
    ///
    /// # Errors
    /// A parameter outside its limits.
    pub fn new(
        id: SensorId,
        site_m: Point2<f64>,
        parameters: AsdeParameters,
    ) -> Result<Self, ConfigError> {
        parameters.validate()?;
        let detector = Detector::new(parameters.pulses_summed(), parameters.pfa);
        let least_ratio = detector.required_snr(0.1f64.max(2.0 * parameters.pfa), Swerling::Steady);
        Ok(Self {
            id,
            site_m,
            radar: parameters.radar(),
            required: detector.required_snr(parameters.pd, parameters.swerling),
            least_ratio,
            grid: CellRadar::of(&parameters),
            table: PdTable::new(&detector, parameters.swerling),
            detector,
            buildings: Arc::new([]),
            skyline: Skyline::default(),
            facades: Vec::new(),
            tolerance: Tolerance::default(),
            fault: None,
            fixed: None,
            processing: None,
            planner: Planner::default(),
            aspects: AspectTables::default(),
            rows: (None, Vec::new()),
            mirrored: Mirrored::default(),
            air: None,
            tally: Tally::default(),
            work: Work::default(),
            rain_correlation: parameters.rain_correlation(),
            taken: Taken::default(),
            parameters,
        })
    }

    /// The same radar among buildings.
    #[must_use]
    pub fn among(mut self, buildings: Arc<[Building]>) -> Self {
        self.skyline = Skyline::new(&buildings, self.site_m);
        self.facades = facades(&buildings, self.site_m, self.radar.carrier_ghz);
        self.buildings = buildings;
        self.mirrored = Mirrored::of(&self);
        self.planner.clear();
        self
    }

    /// The same radar planned for another tolerance.
    #[must_use]
    pub fn tolerating(mut self, tolerance: Tolerance) -> Self {
        self.tolerance = tolerance;
        self.planner.clear();
        self
    }

    /// The same radar with a fault planted in its plan: for proofs of the proof.
    #[must_use]
    pub fn planting(mut self, fault: plan::Fault) -> Self {
        self.fault = Some(fault);
        self.planner.clear();
        self
    }

    /// The same radar with the level of every effect given and nothing planned.
    #[must_use]
    pub fn at_levels(mut self, levels: RadarLevels) -> Self {
        self.fixed = Some(levels);
        self
    }

    /// The same radar with its signal processing given, whatever the plan would choose.
    ///
    /// At video level a scan interval is a turn or a part of one; of a longer one only the first look
    /// at each target counts.
    #[must_use]
    pub fn processing(mut self, processing: Processing) -> Self {
        self.processing = Some(processing);
        self
    }

    /// Its parameters.
    #[must_use]
    pub fn parameters(&self) -> &AsdeParameters {
        &self.parameters
    }

    /// How often each effect was evaluated since the radar was made.
    #[must_use]
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Its planner: the boxes met since the last weather notice, and their plans.
    #[must_use]
    pub fn planner(&self) -> &Planner {
        &self.planner
    }

    /// The tolerance that it is planned for.
    #[must_use]
    pub fn tolerance(&self) -> &Tolerance {
        &self.tolerance
    }

    /// Everything of the weather that a plan and a scan read.
    #[must_use]
    pub fn air(&self, weather: &Weather) -> Air {
        self.radar.air(weather)
    }

    /// The part of a scan before any physics: when the beam points at which target and, with `planning`,
    /// which level each look gets.
    pub fn plan_scan(
        &mut self,
        interval: &ScanInterval,
        truth: &dyn Truth,
        weather: &Weather,
        planning: bool,
    ) {
        let air = self.air_of(weather);
        let mut work = std::mem::take(&mut self.work);
        self.find_looks(interval, truth, &mut work.looks, &mut work.ends, &mut work.occluding);
        if planning {
            let work = &mut work;
            self.assign(&air, truth, &work.looks, &work.ends, &|_| false, &mut work.assignment);
        }
        self.work = work;
        self.air = Some(air);
    }

    /// The air of a scan's weather: kept from the scan before where it is the same; a new one makes the
    /// planner forget its boxes.
    fn air_of(&mut self, weather: &Weather) -> Air {
        match self.air.take() {
            Some(air) if air.weather == *weather => air,
            // Bounds reckon with the heaviest rain everywhere: a plan holds while cells drift.
            Some(mut air) if air.weather.is_moved(weather) => {
                air.weather = weather.clone();
                air
            }
            _ => {
                self.planner.clear();
                self.radar.air(weather)
            }
        }
    }
}

impl Sensor for Asde {
    fn id(&self) -> SensorId {
        self.id
    }

    fn kind(&self) -> SensorKind {
        SensorKind::Asde
    }

    fn plan(&self) -> &[PlanRow] {
        &self.rows.1
    }

    fn boxes(&self) -> &[plan::PlannedBox] {
        self.planner.boxes()
    }

    fn fitted(&self) -> Option<plan::Fitted> {
        self.planner.fitted()
    }

    fn placed(&self) -> &[Placed] {
        &self.work.assignment.placed
    }

    fn evaluations(&self) -> Vec<(&'static str, u64)> {
        RadarEffect::ALL.iter().map(|&e| (e.name(), self.tally.of(e))).collect()
    }

    fn scan(
        &mut self,
        interval: &ScanInterval,
        truth: &dyn Truth,
        weather: &Weather,
        out: &mut PlotSink,
    ) {
        let air = self.air_of(weather);
        let mut work = std::mem::take(&mut self.work);
        self.find_looks(interval, truth, &mut work.looks, &mut work.ends, &mut work.occluding);
        let processing = self.processing.or(self.fixed.map(|f| f.processing));
        let processing = processing.unwrap_or(Processing::Plot);
        // In cells everything is exact: what could be left out is nothing beside them.
        let planned = self.fixed.is_none() && processing == Processing::Plot;
        let levels = RadarLevels { processing, ..self.fixed.unwrap_or(self.base_levels()) };
        let shadows = levels.aircraft != ShadowLevel::None
            && work.looks.iter().any(|look| work.occluding.may_shadow(look, self.site_m));
        if planned {
            let (site_m, work) = (self.site_m, &mut work);
            let shadowed = |look: &Look| shadows && work.occluding.may_shadow(look, site_m);
            self.assign(&air, truth, &work.looks, &work.ends, &shadowed, &mut work.assignment);
        }
        if shadows {
            work.traffic.clear();
            work.occluding.fill(&mut work.traffic);
            work.traffic.finish();
        }
        let far_m = self.parameters.second_trace_from_m();
        let facts = ScanFacts {
            exactly: planned && work.assignment.exactly,
            pairs: planned && work.assignment.any_pair || !planned && work.looks.len() > 1,
            shadows,
            beyond: work
                .looks
                .iter()
                .any(|l| (l.state.position_m.xy() - self.site_m).norm() > far_m),
        };
        let shown = Some((self.planner.version(), processing, facts));
        if self.rows.0 != shown {
            self.rows = (shown, plan::rows(self, &air, processing, facts));
        }
        work.returns.clear();
        for (i, look) in work.looks.iter().enumerate() {
            let paired = !planned || work.assignment.paired[i];
            // Only merging asks for echoes of the next interval.
            if look.number == NEXT && !(levels.merging && paired) {
                continue;
            }
            let mut own = if planned { self.planned_levels(&work.assignment, i) } else { levels };
            if planned {
                own.merging = paired;
                own.processing = processing;
            }
            if !work.occluding.may_shadow(look, self.site_m) {
                own.aircraft = ShadowLevel::None;
            }
            if let Some(found) = self.echo(&air, &own, truth, &work.traffic, look) {
                out.looks += u64::from(look.number != NEXT);
                work.returns.push(found);
            }
        }
        let before = std::mem::take(&mut self.taken);
        if before.at == interval.from && !before.keys.is_empty() {
            // Part of the last interval's last plots: seen, but reported already.
            let taken = |r: &Return| {
                r.look.number == 0
                    && r.look.time.since_s(interval.from) * self.parameters.turns_per_s() < 0.25
                    && before.keys.binary_search(&truth.key(r.look.index)).is_ok()
            };
            work.returns.retain(|r| !taken(r));
        }
        let returns = &mut work.returns;
        let (seen, next) = match levels.processing {
            Processing::Plot => {
                if levels.merging && (!planned || work.assignment.any_pair) {
                    self.merge(returns, &mut work.order);
                } else {
                    (0..).zip(&mut *returns).for_each(|(i, r)| r.cell = i);
                }
                let next = (0..returns.len()).filter(|i| {
                    let head = returns[*i].cell as usize;
                    returns[*i].look.number == NEXT && returns[head].look.number != NEXT
                });
                let next = next.collect();
                let seen = std::mem::take(&mut work.seen);
                (self.measure_returns(truth, interval, returns, seen), next)
            }
            Processing::Cells => {
                self.measure_windows(&air, &levels, truth, interval, returns, &mut work.windows)
            }
            Processing::Video => {
                self.measure_video(&air, &levels, truth, interval, returns, &mut work.windows)
            }
        };
        let mut keys: Vec<u64> = next.iter().map(|i| truth.key(returns[*i].look.index)).collect();
        keys.sort_unstable();
        self.taken = Taken { at: interval.to, keys };
        let mut sequence = 0;
        let mut add = |out: &mut PlotSink, mut plot: Plot, cause: Cause| {
            plot.sequence = sequence;
            sequence += 1;
            out.plots.push(plot);
            out.causes.push(cause);
        };
        for &Seen { plot, cause, draws } in &seen {
            let Some(cause) = cause else {
                add(out, plot, Cause::default());
                continue;
            };
            let r = &work.returns[cause];
            let effects = if out.explain {
                self.explain(&air, truth.class(r.look.index), r, &draws, &plot)
            } else {
                Vec::new()
            };
            let truth_m = Some(r.look.state.position_m.xy());
            let key = Some(truth.key(r.look.index));
            add(out, plot, Cause { key, truth_m, effects });
        }
        if levels.ghosts && !self.facades.is_empty() {
            let mut found = Vec::new();
            for index in 0..truth.len() {
                if !planned || work.assignment.ghosts[index] {
                    self.ghosts(&air, &levels, interval, truth, index, &mut found);
                }
            }
            for (plot, power_db) in found {
                add(
                    out,
                    plot,
                    Cause { key: None, truth_m: None, effects: explain::ghost(power_db) },
                );
            }
        }
        if levels.false_alarms && levels.processing != Processing::Video {
            let mut alarms = Vec::new();
            self.false_alarms(&levels, interval, &mut alarms);
            for plot in alarms {
                add(out, plot, Cause::default());
            }
        }
        work.seen = seen;
        self.work = work;
        self.air = Some(air);
    }
}

#[cfg(test)]
mod tests;
