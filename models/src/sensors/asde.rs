//! A surface movement radar (ASDE, SMR): truth and weather in, plots out.
//!
//! A scan has three passes: where each target is when the beam points at it; what each echo is worth
//! in watts, with shadows; which echoes share a cell. Then every echo is detected and measured with
//! the draws of its own target and scan.

mod assign;
mod cells;
mod declared;
mod explain;
mod looks;
mod pairs;
pub mod picture;
pub mod plan;
pub mod survey;

pub use declared::{ALL_KEYS, DECLARED};

use crate::draw::{DrawKey, Purpose, exponential, normal_pair, normal_pair_of, uniform};
use crate::effects::{PlanRow, Tolerance};
use crate::environment::Weather;
use crate::frames::{Azimuth, Vector2, wrap_pi};
use crate::plot::{Plot, Polar, SensorId, SensorKind};
use crate::sensors::config::ConfigError;
use crate::sensors::measurement::{quantised, to_cartesian};
use crate::sensors::radar::aspect::AspectTables;
use crate::sensors::radar::detection::{Detector, PdTable, Swerling, from_db, to_db};
use crate::sensors::radar::effects::{RadarEffect, Tally};
use crate::sensors::radar::equation::{Air, Budget, Echo, Radar};
use crate::sensors::radar::extended::{self, Centroid, ExtentLevel};
use crate::sensors::radar::ghost::{Facade, facades, ghost_power};
use crate::sensors::radar::levels::{PdLevel, Processing, RadarLevels, ShadowLevel};
pub use crate::sensors::radar::parameters::{
    AsdeParameters, DetectionRule, Energy, GLINT_SIGMA_M, ParameterWarning,
};
use crate::sensors::radar::shadow::{
    Building, SightLine, Skyline, Traffic, aircraft_obstacles, edge_reach_m,
};
use crate::sensors::radar::span::Span;
use crate::sensors::radar::video::CellRadar;
use crate::sensors::{Cause, PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use crate::time::SimTime;
pub use assign::Placed;
use assign::{Assignment, Mirrored};
use cells::WindowWork;
use looks::{End, Look, NEXT, Occluding};
use plan::Planner;
use std::f64::consts::TAU;
use std::sync::Arc;

/// A surface movement radar at its place.
#[derive(Clone, Debug)]
pub struct Asde {
    id: SensorId,
    site_m: Vector2<f64>,
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

/// A plot and what caused it.
#[derive(Clone, Copy, Debug)]
struct Seen {
    plot: Plot,
    /// Place of the echo among the returns; `None` where noise alone crossed the threshold.
    cause: Option<usize>,
    draws: Draws,
}

/// Two-way losses on one sight line, dB, by what stands in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Shadows {
    buildings_db: f64,
    aircraft_db: f64,
}

impl Shadows {
    fn db(&self) -> f64 {
        self.buildings_db + self.aircraft_db
    }
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

/// Where an echo is, for finding those beside it: sector, range step and place in the list in one
/// number that sorts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Place(u64);

/// Length of a range step of [`Place`], m.
const PLACE_STEP_M: f64 = 0.1;
/// Range steps: to 1600 km.
const PLACE_STEPS: u64 = 1 << 24;

impl Place {
    fn new(sector: u32, range_m: f64, index: u32) -> Self {
        let step = ((range_m / PLACE_STEP_M).max(0.0) as u64).min(PLACE_STEPS - 1);
        Self(u64::from(sector) << 48 | step << 24 | u64::from(index))
    }

    fn sector(self) -> u64 {
        self.0 >> 48
    }

    fn step(self) -> u64 {
        self.0 >> 24 & (PLACE_STEPS - 1)
    }

    fn index(self) -> u32 {
        (self.0 & 0xff_ffff) as u32
    }
}

/// One echo before detection.
#[derive(Clone, Copy, Debug)]
struct Return {
    look: Look,
    /// At which levels it is simulated.
    levels: RadarLevels,
    budget: Budget,
    /// Slant range and azimuth of the centre of the echo.
    range_m: f64,
    azimuth_rad: f64,
    /// Where the reference point is seen.
    bias_along_m: f64,
    bias_across_m: f64,
    glint_along_m: f64,
    glint_across_m: f64,
    /// Two-way loss by shadows.
    shadow: Shadows,
    /// First of the echoes in the same cell, by place in the list; itself if it stands alone.
    cell: u32,
}

impl Asde {
    /// A radar with its antenna over `site_m` (east, north of the reference point), in the open, at
    /// the default tolerance.
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
            self.assign(&air, truth, &work.looks, &work.ends, &mut work.assignment);
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

    /// The budget of one look at one target, with shadows, and where its echo is centred. `None`
    /// outside the display range, and where nothing of the target returns an echo.
    fn echo(
        &mut self,
        air: &Air,
        levels: &RadarLevels,
        truth: &dyn Truth,
        traffic: &Traffic,
        look: &Look,
    ) -> Option<Return> {
        let class = truth.class(look.index);
        let state = &look.state;
        let offset = state.position_m.xy() - self.site_m;
        let ground_m = offset.norm();
        let azimuth_rad = look.azimuth_rad;
        // The echo comes from the middle of the body; a body on the surface stands half its height above it.
        let height_m = state.position_m.z.max(0.5 * class.height_m);
        let down_m = self.radar.antenna_m - height_m;
        let slant_m = (ground_m * ground_m + down_m * down_m).sqrt();
        self.apparent_m(levels, slant_m)?;
        let shadow = self.shadows(levels, truth, traffic, look, azimuth_rad, ground_m, height_m)?;
        // In a shadow the ratio is none that the plan reckons with: everything exact.
        let exact = self.base_levels();
        let levels = if shadow.db() > 0.0 && self.fixed.is_none() { &exact } else { levels };
        let centroid = self.centroid(levels.extent, class, look)?;
        let echo = Echo { ground_m, height_m, extent_m: class.height_m, rcs_m2: centroid.rcs_m2 };
        let mut budget =
            self.radar.budget(air, &levels.budget, &echo, self.site_m, state.position_m.xy());
        self.tally.note(budget.evaluated);
        if shadow.db() > 0.0 {
            budget.signal_w *= from_db(-shadow.db());
        }
        // Along and across are on the ground; the range grows by the projection.
        let slope = ground_m / budget.range_m;
        let (along_m, across_m) = budget.moved_m;
        Some(Return {
            look: *look,
            levels: *levels,
            range_m: budget.range_m + (centroid.bias_along_m + along_m) * slope,
            azimuth_rad: azimuth_rad + (centroid.bias_across_m + across_m) / ground_m.max(1.0),
            budget,
            bias_along_m: centroid.bias_along_m,
            bias_across_m: centroid.bias_across_m,
            glint_along_m: centroid.glint_along_m * slope,
            glint_across_m: centroid.glint_across_m,
            shadow,
            cell: 0,
        })
    }

    fn centroid(
        &mut self,
        level: ExtentLevel,
        class: &TargetClass,
        look: &Look,
    ) -> Option<Centroid> {
        if level != ExtentLevel::Point {
            self.tally.count(RadarEffect::Extent);
        }
        let view_rad = extended::view_rad(look.azimuth_rad, look.state.heading_rad);
        match level {
            ExtentLevel::Table => self.aspects.centroid(look.index, class, view_rad),
            ExtentLevel::Point | ExtentLevel::Centroid => {
                extended::centroid(level, class, view_rad)
            }
        }
    }

    /// The range at which an echo from `slant_m` appears, if that is displayed.
    fn apparent_m(&self, levels: &RadarLevels, slant_m: f64) -> Option<f64> {
        let range_m = slant_m - self.folded_m(levels, slant_m);
        self.shown().contains(range_m).then_some(range_m)
    }

    /// By how much an echo from `slant_m` appears nearer than it is: whole unambiguous ranges.
    fn folded_m(&self, levels: &RadarLevels, slant_m: f64) -> f64 {
        let unambiguous = self.parameters.unambiguous_m();
        if levels.second_trace && slant_m > unambiguous {
            (slant_m / unambiguous).floor() * unambiguous
        } else {
            0.0
        }
    }

    /// Slant ranges that are displayed.
    fn shown(&self) -> Span {
        Span { low: self.parameters.range_min_m, high: self.parameters.range_max_m }
    }

    /// Two-way loss by buildings and aircraft on the sight line; `None` where it is cut and the level
    /// knows only in sight or not.
    #[expect(clippy::too_many_arguments, reason = "all parts of one look, already computed")]
    fn shadows(
        &mut self,
        levels: &RadarLevels,
        truth: &dyn Truth,
        traffic: &Traffic,
        look: &Look,
        azimuth_rad: f64,
        ground_m: f64,
        height_m: f64,
    ) -> Option<Shadows> {
        let line = SightLine {
            site_m: self.site_m,
            antenna_m: self.radar.antenna_m,
            target_m: look.state.position_m.xy(),
            height_m,
            wavelength_m: self.radar.wavelength_m,
        };
        let mut found_db = Shadows::default();
        if levels.buildings != ShadowLevel::None {
            for index in self.skyline.before(azimuth_rad, ground_m) {
                self.tally.count(RadarEffect::BuildingShadow);
                let building = &self.buildings[index];
                let found = line.behind(&building.footprint_m, building.height_m);
                match levels.buildings {
                    ShadowLevel::Binary if found.blocked => return None,
                    ShadowLevel::KnifeEdge => found_db.buildings_db += 2.0 * found.loss_db,
                    _ => {}
                }
            }
        }
        if levels.aircraft != ShadowLevel::None {
            for index in traffic.before(&line, azimuth_rad, ground_m) {
                if index == look.index {
                    continue;
                }
                let Some(state) = truth.at(index, look.time) else { continue };
                let class = truth.class(index);
                let place_m = state.position_m.xy();
                // An aircraft as near as its own size stands beside the target, not before it.
                let before = (place_m - self.site_m).norm();
                if before + 0.5 * class.length_m >= ground_m || state.position_m.z > class.height_m
                {
                    continue;
                }
                let along = line.target_m - self.site_m;
                let aside_m = (along.perp(&(place_m - self.site_m)) / ground_m).abs();
                let reach_m = edge_reach_m(self.radar.wavelength_m, ground_m);
                // Half the diagonal of the fuselage.
                if aside_m > 0.503 * class.length_m + reach_m {
                    continue;
                }
                self.tally.count(RadarEffect::AircraftShadow);
                let obstacles =
                    aircraft_obstacles(place_m, state.heading_rad, class.length_m, class.height_m);
                let mut least = 0.0f64;
                for (corners, top_m) in &obstacles {
                    let found = line.behind(corners, *top_m);
                    match levels.aircraft {
                        ShadowLevel::Binary if found.blocked => return None,
                        ShadowLevel::KnifeEdge => least = least.max(found.loss_db),
                        _ => {}
                    }
                }
                found_db.aircraft_db += 2.0 * least;
            }
        }
        Some(found_db)
    }

    /// Echoes in one range and azimuth cell become one: signals add, the centre is that of the power.
    /// The first by target key keeps the echo and its draws.
    fn merge(&mut self, returns: &mut [Return], order: &mut Vec<Place>) {
        for (i, r) in returns.iter_mut().enumerate() {
            r.cell = i as u32;
        }
        let (cell_m, beam) = (self.radar.cell_m, self.radar.pattern.azimuth_rad);
        // Sectors not narrower than the beam: echoes in one cell are in one sector or the next.
        let sectors = ((TAU / beam).floor() as u32).max(1);
        let sector = |azimuth_rad: f64| {
            let turn = azimuth_rad / TAU;
            (((turn - turn.floor()) * f64::from(sectors)) as u32).min(sectors - 1)
        };
        order.clear();
        order.extend(
            (0..)
                .zip(&*returns)
                .filter(|(_, r)| r.levels.merging)
                .map(|(i, r)| Place::new(sector(r.azimuth_rad), r.range_m, i)),
        );
        order.sort_unstable();
        // Echoes in one cell are at most so many range steps apart.
        let reach = (cell_m / PLACE_STEP_M) as u64 + 1;
        let turns_per_s = self.parameters.turns_per_s();
        let mut tested = 0;
        let mut test = |returns: &mut [Return], first: Place, second: Place| {
            let (a, b) = (&returns[first.index() as usize], &returns[second.index() as usize]);
            if (a.range_m - b.range_m).abs() >= cell_m {
                return;
            }
            tested += 1;
            let turns = a.look.time.since_s(b.look.time) * turns_per_s;
            let apart = wrap_pi(a.azimuth_rad - b.azimuth_rad).abs();
            if turns.abs() < 0.5 && apart < beam && a.look.index != b.look.index {
                let (root_a, root_b) =
                    (root(returns, first.index()), root(returns, second.index()));
                // An echo of the next interval leads only among its like.
                let rank = |i: u32| (returns[i as usize].look.number == NEXT, i);
                let (low, high) =
                    if rank(root_a) < rank(root_b) { (root_a, root_b) } else { (root_b, root_a) };
                returns[high as usize].cell = low;
            }
        };
        // The first echo of the next sector that may be near, moving on with the echoes of this one.
        let mut from = 0;
        let mut last_sector = u64::MAX;
        for place in 0..order.len() {
            let first = order[place];
            for &second in &order[place + 1..] {
                if second.sector() != first.sector() || second.step() > first.step() + reach {
                    break;
                }
                test(returns, first, second);
            }
            let next = (first.sector() + 1) % u64::from(sectors);
            if first.sector() != last_sector {
                last_sector = first.sector();
                from = order.partition_point(|p| p.sector() < next);
            }
            while from < order.len()
                && order[from].sector() == next
                && order[from].step() + reach < first.step()
            {
                from += 1;
            }
            for &second in &order[from..] {
                if second.sector() != next || second.step() > first.step() + reach {
                    break;
                }
                test(returns, first, second);
            }
        }
        self.tally.add(RadarEffect::Merging, tested);
        for i in 0..returns.len() as u32 {
            let head = root(returns, i);
            returns[i as usize].cell = head;
            if head != i {
                let member = returns[i as usize];
                let r = &mut returns[head as usize];
                let total = r.budget.signal_w + member.budget.signal_w;
                if total > 0.0 {
                    let share = member.budget.signal_w / total;
                    r.range_m += share * (member.range_m - r.range_m);
                    r.azimuth_rad += share * wrap_pi(member.azimuth_rad - r.azimuth_rad);
                }
                r.budget.signal_w = total;
            }
        }
    }

    /// Detects and measures each group of echoes in one cell by its first.
    fn measure_returns(
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
    fn detected(&mut self, levels: &RadarLevels, budget: &Budget, chance: f64) -> Option<f64> {
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
    fn stated_glint_m(&self, levels: &RadarLevels) -> f64 {
        let extended = levels.glint && levels.extent != ExtentLevel::Point;
        if extended { self.parameters.glint_sigma_m } else { 0.0 }
    }

    /// Thermal standard deviations of range (m) and azimuth (rad).
    fn sigmas(&self, scnr: f64, reflected: f64) -> (f64, f64) {
        let p = &self.parameters;
        let (range_m, azimuth_rad) = p.thermal_sigmas(scnr.max(self.least_ratio));
        let coupled = p.reflection_coupling * reflected * self.radar.pattern.azimuth_rad;
        (range_m, if coupled == 0.0 { azimuth_rad } else { libm::hypot(azimuth_rad, coupled) })
    }

    /// The plot of a measured slant range and azimuth: quantised, on the ground, with its covariance.
    fn plot(&mut self, levels: &RadarLevels, time: SimTime, measured: Polar, scnr_db: f64) -> Plot {
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
    fn measure(&mut self, r: &Return, rng: &mut rand::rngs::ChaCha8Rng) -> Option<(Plot, Draws)> {
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

    fn false_alarms(&mut self, levels: &RadarLevels, interval: &ScanInterval, out: &mut Vec<Plot>) {
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

    fn key(&self, interval: &ScanInterval, entity: u64) -> DrawKey {
        DrawKey {
            run_seed: interval.run_seed,
            sensor: u32::from(self.id.0),
            entity,
            scan: interval.scan,
        }
    }

    /// Ghosts of one target in all facades: the double bounce in the direction of the facade, and the
    /// mixed path in both directions.
    fn ghosts(
        &mut self,
        air: &Air,
        levels: &RadarLevels,
        interval: &ScanInterval,
        truth: &dyn Truth,
        index: usize,
        out: &mut Vec<(Plot, f64)>,
    ) {
        let Some(state) = truth.at(index, interval.to) else { return };
        let class = truth.class(index);
        let mut rng = None;
        for f in 0..self.facades.len() {
            let facade = self.facades[f];
            let height = |state: &TargetState| state.position_m.z.max(0.5 * class.height_m);
            let antenna_m = self.radar.antenna_m;
            let wavelength_m = self.radar.wavelength_m;
            let mirror = |state: &TargetState| {
                facade.ghost(antenna_m, state.position_m.xy(), height(state), wavelength_m)
            };
            let Some(at_end) = mirror(&state) else { continue };
            let key = self.key(interval, truth.key(index));
            let rng = rng.get_or_insert_with(|| key.rng(Purpose::Ghosts));
            let to_facade = Azimuth::of(at_end.point_m - self.site_m);
            let to_target = Azimuth::of(state.position_m.xy() - self.site_m);
            for (azimuth, direct) in [(to_facade, false), (to_target, true)] {
                let Some(time) = self.pass(interval, azimuth.rad()) else { continue };
                let Some(now) = truth.at(index, time) else { continue };
                let Some(ghost) = mirror(&now) else { continue };
                self.tally.count(RadarEffect::Ghosts);
                let offset = now.position_m.xy() - self.site_m;
                let down_m = antenna_m - height(&now);
                let direct_m = libm::hypot(offset.norm(), down_m);
                let apart = Azimuth::of(offset).minus(Azimuth::of(ghost.point_m - self.site_m));
                let off_beam = self.radar.pattern.azimuth(apart);
                let (mixed, double) =
                    ghost_power(ghost.reflection, direct_m, ghost.path_m, off_beam);
                let beam = if direct {
                    Azimuth::of(offset)
                } else {
                    Azimuth::of(ghost.point_m - self.site_m)
                };
                let mut ways = vec![(0.5 * (direct_m + ghost.path_m), mixed)];
                if !direct {
                    ways.push((ghost.path_m, double));
                }
                for (range_m, power) in ways {
                    let chance = uniform(rng);
                    let normal = normal_pair(rng);
                    let Some(range_m) = self.apparent_m(levels, range_m) else { continue };
                    let ground_m = (range_m * range_m - down_m * down_m).max(1.0).sqrt();
                    let echo = Echo {
                        ground_m,
                        height_m: height(&now),
                        extent_m: class.height_m,
                        rcs_m2: class.rcs_m2,
                    };
                    let place_m = self.site_m + beam.unit() * ground_m;
                    let b = levels.budget;
                    let mut budget = self.radar.budget(air, &b, &echo, self.site_m, place_m);
                    self.tally.note(budget.evaluated);
                    // The budget at the ghost's range already has its spreading loss.
                    let again = range_m / direct_m;
                    budget.signal_w *= power * again * again * again * again;
                    let Some(strength) = self.detected(levels, &budget, chance) else { continue };
                    let (range_sigma_m, azimuth_sigma_rad) =
                        self.sigmas(budget.scnr(), budget.reflected);
                    let stated = self.sigmas(strength, budget.reflected);
                    let glint_m = self.stated_glint_m(levels);
                    let measured = Polar {
                        range_m: range_m + range_sigma_m * normal.0,
                        azimuth_rad: beam.rad() + azimuth_sigma_rad * normal.1,
                        sigma_range_m: libm::hypot(stated.0, glint_m),
                        sigma_azimuth_rad: libm::hypot(stated.1, glint_m / ground_m),
                        extent_m2: None,
                    };
                    out.push((self.plot(levels, time, measured, to_db(strength)), to_db(power)));
                }
            }
        }
    }
}

/// What was drawn for one plot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Draws {
    range_m: f64,
    azimuth_rad: f64,
    glint_along_m: f64,
    glint_across_m: f64,
}

fn root(returns: &[Return], mut i: u32) -> u32 {
    while returns[i as usize].cell != i {
        i = returns[i as usize].cell;
    }
    i
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
        if planned {
            self.assign(&air, truth, &work.looks, &work.ends, &mut work.assignment);
        }
        let shadows = levels.aircraft != ShadowLevel::None
            && work.looks.iter().any(|look| work.occluding.may_shadow(look, self.site_m));
        if shadows {
            work.traffic.clear();
            work.occluding.fill(&mut work.traffic);
            work.traffic.finish();
        }
        let far_m = self.parameters.unambiguous_m();
        let firsts = work.looks.iter().filter(|look| look.number == 0);
        for (placed, look) in work.assignment.placed.iter_mut().zip(firsts) {
            placed.shadowed = shadows && work.occluding.may_shadow(look, self.site_m);
        }
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
