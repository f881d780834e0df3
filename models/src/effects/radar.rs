//! The plan of a surface movement radar: bounds from extents of the traffic, weather and buildings.

use super::{Ladder, Level, Loss, PlanRow, Rung, Tolerance, choose, costs};
use crate::environment::surface::{self, Fresnel, Roughness};
use crate::frames::Vector2;
use crate::plot::SensorId;
use crate::sensors::asde::{AsdeParameters, DetectionRule};
use crate::sensors::detection::{PdTable, Swerling, from_db, to_db};
use crate::sensors::extended::ExtentLevel;
use crate::sensors::propagation;
use crate::sensors::radar_equation::{
    Air, BudgetLevels, GasLevel, Radar, RainEcho, RainPath, ReflectedPolarisation, Reflection,
};
use crate::sensors::shadow::Building;
use crate::sensors::{ScanInterval, TargetClass, Truth};

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

    /// Evaluations of one effect.
    #[must_use]
    pub fn of(&self, effect: RadarEffect) -> u64 {
        self.0[effect as usize]
    }
}

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
        match effect {
            E::RainAttenuation => {
                b.rain = match level {
                    Level::Skipped => RainPath::None,
                    Level::Cheap => RainPath::Linear,
                    Level::Middle => RainPath::Cells,
                    Level::Exact => RainPath::Mie,
                }
            }
            E::Fog => b.fog = on,
            E::Gases => {
                b.gas = match level {
                    Level::Skipped => GasLevel::None,
                    Level::Cheap => GasLevel::Constant,
                    Level::Middle | Level::Exact => GasLevel::Lines,
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
            E::SurfaceReflection => {
                if !on {
                    b.reflection = Reflection::None;
                }
            }
            E::Lobing => {
                if b.reflection != Reflection::None {
                    b.reflection = if on { Reflection::Extended } else { Reflection::Incoherent };
                }
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
            E::Extent => self.extent = if on { ExtentLevel::Centroid } else { ExtentLevel::Point },
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

/// Height up to which a target counts as being on the surface, m; higher ones are simulated exactly.
pub const SURFACE_M: f64 = 30.0;

/// Where the targets on the surface are, seen from one radar, rounded outwards so that a plan holds
/// while they move a little; and what they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetArea {
    /// Nearest ground distance, m.
    pub nearest_m: f64,
    /// Farthest ground distance, m.
    pub farthest_m: f64,
    /// Farthest distance of any target, on the surface or not, m.
    pub beyond_m: f64,
    /// Lowest middle of an echo above the surface, m.
    pub lowest_m: f64,
    /// Highest middle of an echo, m.
    pub highest_m: f64,
    /// Least vertical extent, m.
    pub least_extent_m: f64,
    /// Largest half diagonal, m.
    pub half_extent_m: f64,
    /// Least cross section, m².
    pub least_rcs_m2: f64,
    /// Largest cross section, m².
    pub largest_rcs_m2: f64,
    /// Whether there are any aircraft.
    pub aircraft: bool,
    /// Whether there is more than one target.
    pub several: bool,
}

impl TargetArea {
    /// No targets.
    pub const EMPTY: Self = Self {
        nearest_m: f64::INFINITY,
        farthest_m: 0.0,
        beyond_m: 0.0,
        lowest_m: f64::INFINITY,
        highest_m: 0.0,
        least_extent_m: f64::INFINITY,
        half_extent_m: 0.0,
        least_rcs_m2: f64::INFINITY,
        largest_rcs_m2: 0.0,
        aircraft: false,
        several: false,
    };

    /// The area of all targets at the end of an interval, seen from `site_m`.
    #[must_use]
    pub fn of(site_m: Vector2<f64>, truth: &dyn Truth, interval: &ScanInterval) -> Self {
        let mut sum = AreaSum::default();
        for index in 0..truth.len() {
            let state = truth.at(index, interval.to).or_else(|| truth.at(index, interval.from));
            if let Some(state) = state {
                let ground_m2 = (state.position_m.xy() - site_m).norm_squared();
                sum.add(truth.class(index), ground_m2, state.position_m.z);
            }
        }
        sum.area()
    }

    /// Rounded outwards to 200 m of distance (40 m at least) and 5 m of height.
    #[must_use]
    pub fn rounded(mut self) -> Self {
        if self.farthest_m > 0.0 {
            // Targets are planned for where they are at the end of a scan and seen up to a turn earlier.
            let margin_m = 40.0;
            self.nearest_m = (((self.nearest_m - margin_m) / 200.0).floor() * 200.0).max(20.0);
            self.farthest_m = ((self.farthest_m + margin_m) / 200.0).ceil() * 200.0;
            self.lowest_m = self.lowest_m.min(self.lowest_m.floor());
            self.highest_m = (self.highest_m / 5.0).ceil() * 5.0;
        }
        self.beyond_m = (self.beyond_m / 1000.0).ceil() * 1000.0;
        self
    }

    /// Whether a target is where and what the plan reckoned with.
    #[must_use]
    pub fn covers(&self, ground_m: f64, middle_m: f64, rcs_m2: f64, extent_m: f64) -> bool {
        ground_m >= self.nearest_m
            && ground_m <= self.farthest_m
            && middle_m >= self.lowest_m
            && middle_m <= self.highest_m
            && rcs_m2 >= self.least_rcs_m2
            && extent_m >= self.least_extent_m
    }
}

/// Gathers a [`TargetArea`] target by target: distances in squares, and a class like the last one's is
/// not looked at again.
#[derive(Clone, Debug)]
pub struct AreaSum {
    area: TargetArea,
    count: usize,
    nearest_m2: f64,
    farthest_m2: f64,
    beyond_m2: f64,
    /// Diagonal of the largest target on the surface, m².
    diagonal_m2: f64,
    /// Height, length, span and cross section of the last class on the surface, and of any.
    last: [f64; 4],
    last_any: (bool, f64),
}

impl Default for AreaSum {
    fn default() -> Self {
        Self {
            area: TargetArea::EMPTY,
            count: 0,
            nearest_m2: f64::INFINITY,
            farthest_m2: 0.0,
            beyond_m2: 0.0,
            diagonal_m2: 0.0,
            last: [f64::NAN; 4],
            last_any: (false, f64::NAN),
        }
    }
}

impl AreaSum {
    /// Adds one target, by the square of its ground distance.
    pub fn add(&mut self, class: &TargetClass, ground_m2: f64, up_m: f64) {
        // Plain comparisons: positions and classes are numbers.
        let least = |a: f64, b: f64| if b < a { b } else { a };
        let most = |a: f64, b: f64| if b > a { b } else { a };
        self.count += 1;
        self.beyond_m2 = most(self.beyond_m2, ground_m2);
        let area = &mut self.area;
        if self.last_any != (class.aircraft, class.rcs_m2) {
            self.last_any = (class.aircraft, class.rcs_m2);
            area.aircraft |= class.aircraft;
            area.largest_rcs_m2 = most(area.largest_rcs_m2, class.rcs_m2);
        }
        if up_m > SURFACE_M {
            return;
        }
        let middle_m = most(up_m, 0.5 * class.height_m);
        self.nearest_m2 = least(self.nearest_m2, ground_m2);
        self.farthest_m2 = most(self.farthest_m2, ground_m2);
        area.lowest_m = least(area.lowest_m, middle_m);
        area.highest_m = most(area.highest_m, middle_m);
        let sizes = [class.height_m, class.length_m, class.span_m, class.rcs_m2];
        if self.last != sizes {
            self.last = sizes;
            area.least_extent_m = least(area.least_extent_m, class.height_m);
            let square = class.length_m * class.length_m + class.span_m * class.span_m;
            self.diagonal_m2 = most(self.diagonal_m2, square);
            area.least_rcs_m2 = least(area.least_rcs_m2, class.rcs_m2);
        }
    }

    /// The area, rounded outwards.
    #[must_use]
    pub fn area(&self) -> TargetArea {
        TargetArea {
            several: self.count > 1,
            nearest_m: self.nearest_m2.sqrt(),
            farthest_m: self.farthest_m2.sqrt(),
            beyond_m: self.beyond_m2.sqrt(),
            half_extent_m: 0.5 * self.diagonal_m2.sqrt(),
            ..self.area
        }
        .rounded()
    }
}

/// Everything the planner reads of one radar and its scene.
#[derive(Clone, Copy, Debug)]
pub struct RadarScene<'a> {
    /// The sensor.
    pub sensor: SensorId,
    /// Where it stands.
    pub site_m: Vector2<f64>,
    /// Its parameters.
    pub parameters: &'a AsdeParameters,
    /// Its budget's constants.
    pub radar: &'a Radar,
    /// Its detection, in a table.
    pub table: &'a PdTable,
    /// Ratio required by the threshold rule.
    pub required: f64,
    /// Least ratio of a detected echo.
    pub least_ratio: f64,
    /// The weather.
    pub air: &'a Air,
    /// Buildings.
    pub buildings: &'a [Building],
    /// Where the traffic is.
    pub area: &'a TargetArea,
    /// How echoes become plots; `None` where the plan chooses.
    pub processing: Option<Processing>,
}

/// The plan of one radar.
#[derive(Clone, Debug, PartialEq)]
pub struct RadarPlan {
    /// What is simulated, for targets in the area planned for.
    pub levels: RadarLevels,
    /// The area planned for.
    pub area: TargetArea,
    /// The plan for people.
    pub rows: Vec<PlanRow>,
    /// Sum of what the plan may lose.
    pub total: Loss,
}

/// Standard deviations that a drawn error may reach: beyond 5 once in two million draws.
const DRAWN_SIGMAS: f64 = 5.0;
/// Part of a range cell by which a target's echo may be off without a word on which echoes share a cell.
const SHARED_CELL: f64 = 0.1;
/// Ranges at which the outcome is tested.
const BINS: usize = 16;
/// Share of the median cross section that an aircraft keeps at its weakest aspect, and what it gains at
/// the broadside flash, dB.
const ASPECT_DB: (f64, f64) = (6.0, 13.6);

/// Plans one radar: every effect at the cheapest level such that, against everything exact and on the
/// same draws, neither Pd nor position differ by more than the tolerance.
#[must_use]
pub fn plan(scene: &RadarScene<'_>, tolerance: &Tolerance) -> RadarPlan {
    let bounds = Bounds::of(scene);
    let ladders = ladders(scene, &bounds);
    let outcome = Outcome::of(scene, &bounds);
    // The signal processing comes last and is no part of the sum.
    // The signal processing comes last and is no part of the sum.
    let (effects, of_cells) = ladders.split_at(ladders.len() - 1);
    let (mut chosen, total) = choose(effects, tolerance, |loss| outcome.allows(loss, tolerance));
    let plot_fits = of_cells[0].rungs[0].loss.metres <= tolerance.position_m;
    let processing = scene.processing.unwrap_or(match plot_fits {
        true => Processing::Plot,
        false => Processing::Cells,
    });
    chosen.push(processing as usize);
    let mut levels = RadarLevels::EXACT;
    let mut rows = Vec::with_capacity(ladders.len());
    for ((ladder, &rung), &effect) in ladders.into_iter().zip(&chosen).zip(RadarEffect::ALL) {
        let (chosen, skipped) = (ladder.rungs[rung], ladder.rungs[0]);
        let mut level = chosen.level;
        let reflected = matches!(
            effect,
            RadarEffect::Lobing
                | RadarEffect::Roughness
                | RadarEffect::WaterFilm
                | RadarEffect::ReflectedPolarisation
                | RadarEffect::RoundEarth
        );
        if reflected && levels.budget.reflection == Reflection::None {
            level = Level::Skipped;
        }
        let free = in_cells(effect, processing);
        if free {
            level = Level::Exact;
        }
        levels = levels.with(effect, level);
        let (bound, unit) = skipped.loss.shown();
        rows.push(PlanRow {
            sensor: scene.sensor,
            effect: ladder.effect,
            called_for: if free { "shown by the cells".into() } else { ladder.called_for },
            bound,
            unit,
            level,
            loss: if free { Loss::NONE } else { chosen.loss },
            cost_ns: if free || level == Level::Skipped { 0.0 } else { chosen.cost_ns },
        });
    }
    RadarPlan { levels, area: *scene.area, rows, total }
}

/// Numbers that several bounds share.
struct Bounds {
    near_m: f64,
    far_m: f64,
    bins: [Bin; BINS],
    grazing_max: f64,
    grazing_min: f64,
    /// Largest ratio of reflected to direct antenna amplitude.
    gain: f64,
    /// Largest share by which lobes move the propagation factor off its mean.
    lobing_share: f64,
    lobing_db: f64,
    /// Sine of the depression of the beam's axis.
    sin_axis: f64,
}

/// A piece of the target area: least signal, most noise and clutter.
#[derive(Clone, Copy, Debug, Default)]
struct Bin {
    far_m: f64,
    /// Ground distance by slant range, at most.
    slope: f64,
    /// Least ratio with everything on, dB.
    scnr_db: f64,
    /// Largest signal over thermal noise, dB.
    snr_max_db: f64,
}

impl Bounds {
    fn of(scene: &RadarScene<'_>) -> Self {
        let (radar, area) = (scene.radar, scene.area);
        let p = scene.parameters;
        let slant = |ground: f64, height: f64| {
            let down = radar.antenna_m - height;
            (ground * ground + down * down).sqrt()
        };
        let empty = area.farthest_m == 0.0;
        let (nearest, farthest) = if empty {
            (p.range_min_m, p.range_min_m)
        } else {
            (area.nearest_m, area.farthest_m.min(p.range_max_m).max(area.nearest_m))
        };
        let (low, high) = if empty { (1.0, 1.0) } else { (area.lowest_m, area.highest_m) };
        let nearest_down = (radar.antenna_m - high).max(0.0);
        let near_m = libm::hypot(nearest, nearest_down).max(p.range_min_m);
        let far_m = slant(farthest, low).max(slant(farthest, high)).max(near_m);
        let grazing = |ground: f64, height: f64| libm::atan2(radar.antenna_m + height, ground);
        let grazing_max = grazing(nearest, high);
        let grazing_min = grazing(farthest, low);
        let extent = if empty { 1.0 } else { area.least_extent_m };
        let spread = propagation::phase_spread_rad(
            radar.antenna_m,
            extent,
            radar.wavelength_m,
            farthest.max(1.0),
        );
        let lobing_db = propagation::lobing_bound_db(1.0, spread);
        let lobing_share = 1.0 - from_db(-lobing_db);
        let mut bounds = Self {
            near_m,
            far_m,
            bins: [Bin::default(); BINS],
            grazing_max,
            grazing_min,
            gain: 0.0,
            lobing_share,
            lobing_db,
            sin_axis: libm::sin(radar.pattern.axis_rad),
        };
        // Logarithmic steps of ground distance.
        let ratio = (farthest / nearest.max(1.0)).max(1.0);
        let step = libm::exp(libm::log(ratio) / BINS as f64);
        let mut from = nearest.max(1.0);
        for bin in 0..BINS {
            let to = from * step;
            bounds.bins[bin] = bounds.bin(scene, from, to, low, high);
            from = to;
        }
        bounds
    }

    fn bin(&mut self, scene: &RadarScene<'_>, from: f64, to: f64, low: f64, high: f64) -> Bin {
        let (radar, air) = (scene.radar, scene.air);
        let down = radar.antenna_m;
        let far_m = to.hypot_with(down.max(high));
        let near_m = from.hypot_with((down - high).max(0.0)).max(scene.parameters.range_min_m);
        // The pattern has one hump: its least value over an interval is at an end.
        let axis = self.sin_axis;
        let gains = |least_rise: f64, most_rise: f64| {
            // What lies above the antenna is seen steepest from near.
            let (least_at, most_at) =
                (if least_rise < 0.0 { from } else { to }, if most_rise < 0.0 { to } else { from });
            let sines = [
                least_rise / least_at.hypot_with(least_rise),
                most_rise / most_at.hypot_with(most_rise),
            ];
            let ends = sines.map(|sin| radar.by_sine.elevation(sin));
            let on_axis = sines[0] <= axis && axis <= sines[1];
            (ends[0].min(ends[1]), if on_axis { 1.0 } else { ends[0].max(ends[1]) })
        };
        let (g_min, g_max) = gains(down - high, down - low);
        let (_, graze_max) = gains(down + low, down + high);
        self.gain = self.gain.max((graze_max / g_min).sqrt());
        let clear_db_per_km = air.fog_db_per_km + air.gas_db_per_km;
        let worst_db = air.most_rain_db(far_m, near_m / from) + clear_db_per_km * far_m / 1000.0;
        let least_db_per_km = air.least_rain_db_per_km() + clear_db_per_km;
        let signal_left = from_db(-2.0 * worst_db);
        let clutter_left = from_db(-2.0 * least_db_per_km * near_m / 1000.0);
        let spread = |r: f64| radar.constant / (r * r * r * r);
        let area = scene.area;
        let aspect = if area.aircraft { from_db(-ASPECT_DB.0) } else { 0.98 };
        let least_rcs = if area.least_rcs_m2.is_finite() { area.least_rcs_m2 } else { 1.0 };
        let extent = if area.farthest_m == 0.0 { 1.0 } else { area.least_extent_m };
        let turns =
            propagation::phase_spread_rad(radar.antenna_m, extent, radar.wavelength_m, to.max(1.0));
        let least_lobe = (1.0 - propagation::lobing_share(1.0, turns)).max(0.0);
        let signal = spread(far_m)
            * least_rcs
            * aspect
            * radar.circular_factor
            * g_min
            * g_min
            * signal_left
            * least_lobe;
        // Clutter falls with range: the near edge has the most.
        let rain = spread(near_m)
            * air.worst_rain_echo()
            * radar.cell_m
            * near_m
            * near_m
            * radar.pattern.two_way_azimuth_rad()
            * radar.rain_integral_bound_from(near_m)
            * scene.parameters.rain_correlation();
        let ground = spread(near_m) * radar.ground_m2_bound(near_m);
        let noise = radar.noise_w + (rain + ground) * clutter_left;
        let most = spread(near_m)
            * area.largest_rcs_m2
            * from_db(ASPECT_DB.1 + 12.04)
            * radar.circular_factor
            * g_max
            * g_max;
        Bin {
            far_m,
            slope: near_m / from,
            scnr_db: to_db(signal / noise),
            snr_max_db: to_db(most / radar.noise_w),
        }
    }
}

/// Least ratio that the plan of a scene reckons with at a ground distance, dB.
#[cfg(test)]
pub(crate) fn least_scnr_db(scene: &RadarScene<'_>, ground_m: f64) -> f64 {
    let bounds = Bounds::of(scene);
    let edge = |i: usize| {
        let (near, far) = (scene.area.nearest_m.max(1.0), scene.area.farthest_m);
        near * libm::pow(far / near, i as f64 / BINS as f64)
    };
    let bin = (0..BINS).find(|i| ground_m <= edge(i + 1)).unwrap_or(BINS - 1);
    bounds.bins[bin].scnr_db
}

trait HypotWith {
    fn hypot_with(self, other: f64) -> f64;
}

impl HypotWith for f64 {
    fn hypot_with(self, other: f64) -> f64 {
        (self * self + other * other).sqrt()
    }
}

/// Range and azimuth parts of a place on the ground, m.
#[derive(Clone, Copy, Debug, Default)]
struct Axes {
    range_m: f64,
    azimuth_m: f64,
}

/// The outcome test: what a sum of losses does to Pd and position at the worst ratio of each bin.
struct Outcome<'a> {
    scene: &'a RadarScene<'a>,
    bins: [Bin; BINS],
    /// Thermal standard deviations at the worst ratio, per bin.
    sigma: [Axes; BINS],
    /// The same at the least ratio of a detected echo: there are no larger ones.
    sigma_most: [Axes; BINS],
    /// A step of the extractor, per bin: the least shift may carry a plot into the next one.
    step: [Axes; BINS],
}

impl<'a> Outcome<'a> {
    fn of(scene: &'a RadarScene<'a>, bounds: &Bounds) -> Self {
        let p = scene.parameters;
        let on_ground = |bin: &Bin, (range_m, azimuth_rad): (f64, f64)| Axes {
            range_m: range_m * bin.slope,
            azimuth_m: azimuth_rad * bin.far_m,
        };
        let sigma = |bin: Bin, ratio: f64| on_ground(&bin, p.thermal_sigmas(ratio));
        let step = (p.range_step_m, p.azimuth_step_deg.to_radians());
        Self {
            scene,
            bins: bounds.bins,
            step: bounds.bins.map(|bin| on_ground(&bin, step)),
            sigma: bounds.bins.map(|bin| sigma(bin, from_db(bin.scnr_db))),
            sigma_most: bounds.bins.map(|bin| sigma(bin, scene.least_ratio)),
        }
    }

    fn allows(&self, loss: &Loss, tolerance: &Tolerance) -> bool {
        if loss.probability > tolerance.detection || loss.metres > tolerance.position_m {
            return false;
        }
        if loss.raises_db <= 0.0 && loss.lowers_db <= 0.0 && loss.metres <= 0.0 {
            return true;
        }
        if loss.metres <= 0.0
            && tolerance.sum_db.is_some_and(|limit| loss.raises_db + loss.lowers_db <= limit)
        {
            return true;
        }
        // Deviations go with the square root of the ratio.
        let grown = from_db(0.5 * loss.lowers_db);
        let shrunk = from_db(-0.5 * loss.raises_db);
        // Far bins first: where one fails, it is most often the last.
        (0..BINS).rev().all(|i| {
            let missed = self.missed(self.bins[i].scnr_db - loss.lowers_db, loss);
            let (sigma, most) = (self.sigma[i], self.sigma_most[i]);
            // Of all ratios from the worst one up, the change is largest at the worst that is detected.
            let moved = |sigma_m: f64, most_m: f64| {
                let worst_m = sigma_m.min(most_m);
                let too_high = worst_m * (1.0 - shrunk);
                let too_low = worst_m.min(most_m / grown) * (grown - 1.0);
                DRAWN_SIGMAS * too_high.max(too_low)
            };
            let range_m = moved(sigma.range_m, most.range_m);
            let azimuth_m = moved(sigma.azimuth_m, most.azimuth_m);
            let step = self.step[i];
            let moved_m = range_m.hypot_with(azimuth_m);
            // Either the shift and a step beside it, or whole steps of each axis.
            let beside = loss.metres + moved_m + step.range_m.hypot_with(step.azimuth_m);
            let whole = whole_steps(range_m + loss.metres, step.range_m)
                .hypot_with(whole_steps(azimuth_m + loss.metres, step.azimuth_m));
            loss.probability + missed <= tolerance.detection
                && beside.min(whole) <= tolerance.position_m
        })
    }

    /// Largest change of Pd where the exact ratio is `low_db + lowers` or more.
    fn missed(&self, low_db: f64, loss: &Loss) -> f64 {
        match self.scene.parameters.detection {
            DetectionRule::Threshold => {
                if from_db(low_db) >= self.scene.required {
                    0.0
                } else {
                    1.0
                }
            }
            DetectionRule::Bernoulli if loss.db() <= 0.0 => 0.0,
            DetectionRule::Bernoulli => {
                let (pd, slope) = self.scene.table.from_db_up(low_db);
                (1.0 - pd).min(slope * loss.db())
            }
        }
    }
}

/// The most that a shift moves what is rounded to steps.
fn whole_steps(shift_m: f64, step_m: f64) -> f64 {
    if shift_m == 0.0 || step_m == 0.0 {
        return shift_m;
    }
    step_m * ((shift_m / step_m).floor() + 1.0)
}

/// A rung whose cost is filled in with its ladder's effect.
const fn rung(level: Level, loss: Loss) -> Rung {
    Rung { level, loss, cost_ns: 0.0 }
}

/// Every effect of a scene with all its levels, in the order of [`RadarEffect::ALL`].
#[must_use]
pub fn all_ladders(scene: &RadarScene<'_>) -> Vec<Ladder> {
    ladders(scene, &Bounds::of(scene))
}

/// The ladder of each effect, in the order of [`RadarEffect::ALL`].
fn ladders(scene: &RadarScene<'_>, bounds: &Bounds) -> Vec<Ladder> {
    RadarEffect::ALL.iter().map(|&effect| ladder(effect, scene, bounds)).collect()
}

/// Sum in decibels of a power and what comes on top of it.
fn above_db(share: f64) -> f64 {
    10.0 * libm::log10(1.0 + share)
}

fn ladder(effect: RadarEffect, scene: &RadarScene<'_>, bounds: &Bounds) -> Ladder {
    use RadarEffect as E;
    let exact = || rung(Level::Exact, Loss::NONE);
    let skip = |loss| rung(Level::Skipped, loss);
    let (air, p, area) = (scene.air, scene.parameters, scene.area);
    let weather = &air.weather;
    let km2 = 2.0 * bounds.far_m / 1000.0;
    let (called_for, rungs) = match effect {
        E::RainAttenuation => rain_attenuation(air, km2),
        E::Fog => (
            format!("visibility {} m", weather.visibility_m),
            vec![skip(Loss::raises(air.fog_db_per_km * km2)), exact()],
        ),
        E::Gases => {
            let off = (air.gas_constant_db_per_km - air.gas_db_per_km).abs() * km2;
            let cheap = rung(Level::Cheap, Loss::either_way(off));
            let called = format!("{:.1} g/m³ of vapour", weather.vapour_g_per_m3);
            (called, vec![skip(Loss::raises(air.gas_db_per_km * km2)), cheap, exact()])
        }
        E::RainClutter => rain_clutter(scene, bounds),
        E::GroundClutter => {
            let r = bounds.near_m;
            let power = scene.radar.constant / (r * r * r * r) * scene.radar.ground_m2_bound(r);
            let share = power / scene.radar.noise_w;
            let called = format!("γ {} dB", p.ground_gamma_db);
            (called, vec![skip(Loss::raises(above_db(share))), exact()])
        }
        E::SurfaceReflection
        | E::Lobing
        | E::Roughness
        | E::WaterFilm
        | E::ReflectedPolarisation
        | E::RoundEarth => reflection(effect, scene, bounds),
        E::Detection => {
            let albersheim = match p.swerling {
                Swerling::Steady if p.detection == DetectionRule::Bernoulli => 0.08,
                _ => f64::INFINITY,
            };
            let threshold = p.detection == DetectionRule::Threshold;
            let table = if threshold { 0.0 } else { PdTable::ERROR };
            let called = format!("Swerling {:?}, {} pulses", p.swerling, p.pulses_summed());
            let rungs = vec![
                skip(Loss::odds(f64::INFINITY)),
                rung(Level::Cheap, Loss::odds(albersheim)),
                rung(Level::Middle, Loss::odds(table)),
                exact(),
            ];
            (called, rungs)
        }
        E::Extent => {
            let mut loss = Loss::moves(area.half_extent_m);
            if area.aircraft {
                (loss.raises_db, loss.lowers_db) = (ASPECT_DB.0, ASPECT_DB.1);
            } else if area.farthest_m > 0.0 {
                (loss.raises_db, loss.lowers_db) = (0.1, 0.1);
            }
            // Where the centres of two echoes are decides whether they share a cell.
            if area.several && area.half_extent_m > SHARED_CELL * scene.radar.cell_m {
                loss.probability = 1.0;
            }
            (format!("targets up to {:.0} m", 2.0 * area.half_extent_m), vec![skip(loss), exact()])
        }
        E::Glint => (
            format!("targets up to {:.0} m", 2.0 * area.half_extent_m),
            vec![skip(Loss::moves(DRAWN_SIGMAS * area.half_extent_m)), exact()],
        ),
        E::ThermalRange => {
            let sigma = p.thermal_sigmas(scene.least_ratio).0;
            (
                format!("σ up to {sigma:.2} m"),
                vec![skip(Loss::moves(DRAWN_SIGMAS * sigma)), exact()],
            )
        }
        E::ThermalAzimuth => {
            let sigma = p.thermal_sigmas(scene.least_ratio).1 * bounds.far_m;
            (
                format!("σ up to {sigma:.2} m"),
                vec![skip(Loss::moves(DRAWN_SIGMAS * sigma)), exact()],
            )
        }
        E::Quantisation => {
            let steps = p.range_step_m + bounds.far_m * p.azimuth_step_deg.to_radians();
            let called = format!("steps {} m, {:.3}°", p.range_step_m, p.azimuth_step_deg);
            (called, vec![skip(Loss::moves(0.5 * steps)), exact()])
        }
        E::FalseAlarms => {
            let mean = p.false_alarms_per_s() / p.turns_per_s();
            (format!("Pfa {:e}", p.pfa), vec![skip(Loss::odds(mean)), exact()])
        }
        E::BuildingShadow => {
            let reach = area.beyond_m;
            let near = |b: &&Building| b.nearest_m(scene.site_m) < reach;
            let count = scene.buildings.iter().filter(near).count();
            let odds = if count > 0 { 1.0 } else { 0.0 };
            let called = format!("{count} buildings in reach");
            let binary = rung(Level::Cheap, Loss::odds(odds));
            (called, vec![skip(Loss::odds(odds)), binary, exact()])
        }
        E::AircraftShadow => {
            let odds = if area.aircraft && area.several { 1.0 } else { 0.0 };
            let called = if odds > 0.0 { "aircraft among several targets" } else { "no pair" };
            let binary = rung(Level::Cheap, Loss::odds(odds));
            (called.to_owned(), vec![skip(Loss::odds(odds)), binary, exact()])
        }
        E::Ghosts => ghosts(scene, bounds),
        E::Merging => {
            let odds = if area.several { 1.0 } else { 0.0 };
            let called = if area.several { "several targets" } else { "at most one target" };
            (called.to_owned(), vec![skip(Loss::odds(odds)), exact()])
        }
        E::SecondTrace => {
            let unambiguous = p.unambiguous_m();
            let odds = if area.beyond_m > unambiguous { 1.0 } else { 0.0 };
            let called = format!("targets to {:.0} m of {unambiguous:.0} m", area.beyond_m);
            (called, vec![skip(Loss::odds(odds)), exact()])
        }
        E::Processing => processing(scene),
    };
    let mut ladder = Ladder { effect: effect.name(), called_for, rungs };
    for rung in &mut ladder.rungs {
        rung.cost_ns = costs::of(effect, rung.level);
    }
    ladder
}

/// By how much the root mean square error of a plot, per axis, differs at plot level from that in cells:
/// the larger of a share of the range cell (the grid, for small targets) and of the target's half
/// diagonal (its centroid). An envelope of what
/// `plot_level_errs_like_the_cells_within_what_the_plan_says` measures.
const PLOT_LEVEL_ERROR: (f64, f64) = (0.065, 0.0078);

/// The levels of the signal processing. Not chosen with the effects: what two of them make of one echo
/// are different draws, so their difference is one of statistics and not of single plots.
fn processing(scene: &RadarScene<'_>) -> (String, Vec<Rung>) {
    let half_m = scene.area.half_extent_m;
    let called = match scene.processing {
        Some(asked) => format!("the scene asks for \"{}\"", asked.name()),
        None => {
            format!("cells of {:.1} m, targets up to {:.0} m", scene.radar.cell_m, 2.0 * half_m)
        }
    };
    let plot = (PLOT_LEVEL_ERROR.0 * scene.radar.cell_m).max(PLOT_LEVEL_ERROR.1 * half_m);
    let plot = if half_m > 0.0 { Loss::moves(plot) } else { Loss::NONE };
    let none = |level| rung(level, Loss::NONE);
    (called, vec![rung(Level::Cheap, plot), none(Level::Middle), none(Level::Exact)])
}

/// Whether cells show an effect by themselves: nothing is computed for it, and it is exact.
fn in_cells(effect: RadarEffect, processing: Processing) -> bool {
    use RadarEffect as E;
    match effect {
        E::Detection | E::Glint | E::ThermalRange | E::ThermalAzimuth => {
            processing != Processing::Plot
        }
        E::Merging | E::FalseAlarms => processing == Processing::Video,
        _ => false,
    }
}

fn rain_attenuation(air: &Air, km2: f64) -> (String, Vec<Rung>) {
    let called = match air.weather.cells.len() {
        0 => format!("rain {} mm/h", air.weather.rain_mm_per_h),
        n => format!("rain {} mm/h, {n} cells", air.weather.rain_mm_per_h),
    };
    let worst = air.worst_rain_db_per_km() * km2;
    let linear = air.linear_db_per_km();
    let cheap = Loss {
        raises_db: (worst - linear * km2).max(0.0),
        lowers_db: (linear - air.least_rain_db_per_km()).max(0.0) * km2,
        ..Loss::NONE
    };
    let middle = Loss::either_way(air.mie_difference_db_per_km() * km2);
    let rungs = vec![
        rung(Level::Skipped, Loss::raises(worst)),
        rung(Level::Cheap, cheap),
        rung(Level::Middle, middle),
        rung(Level::Exact, Loss::NONE),
    ];
    (called, rungs)
}

fn rain_clutter(scene: &RadarScene<'_>, bounds: &Bounds) -> (String, Vec<Rung>) {
    let (radar, air) = (scene.radar, scene.air);
    let r = bounds.near_m;
    let volume = radar.constant / (r * r)
        * radar.cell_m
        * radar.pattern.two_way_azimuth_rad()
        * radar.rain_integral_bound()
        * scene.parameters.rain_correlation()
        / radar.noise_w;
    let worst = above_db(volume * air.worst_rain_echo());
    let (up, down) = air.mie_echo_db();
    // The closed integral leaves out the side lobe floor and cos ε: within 0.06 dB of the quadrature.
    let form = if worst > 0.0 { 0.06 + radar.floor_db(bounds.far_m) } else { 0.0 };
    let middle = Loss {
        raises_db: (up + form).min(worst),
        lowers_db: (down + form).min(worst),
        ..Loss::NONE
    };
    let full = Loss { raises_db: (up + form).min(worst), lowers_db: worst, ..Loss::NONE };
    let called = format!("rain up to {} mm/h", air.heaviest().rain_mm_per_h);
    let rungs = vec![
        rung(Level::Skipped, Loss::raises(worst)),
        rung(Level::Cheap, full),
        rung(Level::Middle, middle),
        rung(Level::Exact, Loss::NONE),
    ];
    (called, rungs)
}

/// The surface reflection and what refines it. If it is skipped, so is everything that refines it.
fn reflection(effect: RadarEffect, scene: &RadarScene<'_>, bounds: &Bounds) -> (String, Vec<Rung>) {
    use RadarEffect as E;
    let radar = scene.radar;
    let air = scene.air;
    let inc = propagation::incoherent;
    // Where lobes are deep, a small change of the reflection moves the factor by any amount.
    let share = bounds.lobing_share;
    let deep = |db: f64| {
        if db == 0.0 {
            0.0
        } else if share < 0.5 {
            db * (1.0 + share) / (1.0 - share)
        } else {
            f64::INFINITY
        }
    };
    let ratio_db = |a: f64, b: f64| 10.0 * libm::log10(inc(a) / inc(b)).abs();
    let exact = || rung(Level::Exact, Loss::NONE);
    let skip = |loss| rung(Level::Skipped, loss);
    let rough = |r: Roughness| r.factor(radar.roughness_m, radar.wavelength_m, bounds.grazing_max);
    let gain = bounds.gain;
    match effect {
        E::SurfaceReflection => {
            let most = inc(gain) * (1.0 + share);
            let least = 1.0 - share;
            let loss = Loss {
                lowers_db: 10.0 * libm::log10(most),
                raises_db: if least > 0.0 { -10.0 * libm::log10(least) } else { f64::INFINITY },
                ..Loss::NONE
            };
            (format!("{} surface", radar.surface.name), vec![skip(loss), exact()])
        }
        E::Lobing => {
            let loss = Loss::either_way(bounds.lobing_db);
            let called = format!("targets of {:.1} m height", scene.area.least_extent_m);
            (called, vec![skip(loss), exact()])
        }
        E::Roughness => {
            let smooth = deep(ratio_db(gain, gain * rough(Roughness::Ament)));
            let ament = deep(ratio_db(
                gain * rough(Roughness::MillerBrownVegh),
                gain * rough(Roughness::Ament),
            ));
            let u = 2.0 * std::f64::consts::PI * radar.roughness_m * libm::sin(bounds.grazing_max)
                / radar.wavelength_m;
            // The two forms part most near u = 0.7; beyond, the difference to smooth bounds it.
            let ament = if u < 0.6 { ament } else { smooth };
            let rungs =
                vec![skip(Loss::raises(smooth)), rung(Level::Cheap, Loss::lowers(ament)), exact()];
            (format!("{} mm rms", radar.roughness_m * 1000.0), rungs)
        }
        E::WaterFilm => {
            let film_mm = air.weather.film_mm;
            let mut low: f64 = 1.0;
            let mut high: f64 = 0.0;
            if film_mm > 0.0 {
                let middle = 0.5 * (bounds.grazing_min + bounds.grazing_max);
                for grazing in [bounds.grazing_min, middle, bounds.grazing_max] {
                    for film in [false, true] {
                        let levels = BudgetLevels { film, ..BudgetLevels::MIDDLE };
                        let g = radar.surface_coefficient(air, &levels, grazing);
                        low = low.min(surface::modulus(g));
                        high = high.max(surface::modulus(g));
                    }
                }
            }
            let loss = if film_mm > 0.0 {
                Loss::either_way(deep(1.3 * ratio_db(gain * high, gain * low)))
            } else {
                Loss::NONE
            };
            (format!("film of {film_mm} mm"), vec![skip(loss), exact()])
        }
        E::ReflectedPolarisation => {
            let fresnel = Fresnel::half_space(air.surface, bounds.grazing_max);
            let own = surface::modulus(radar.surface_coefficient(
                air,
                &BudgetLevels::MIDDLE,
                bounds.grazing_max,
            ));
            let loss = Loss::either_way(deep(ratio_db(
                gain * surface::modulus(fresnel.horizontal),
                gain * own,
            )));
            (format!("{:?}", radar.polarisation), vec![rung(Level::Cheap, loss), exact()])
        }
        _ => {
            let far = bounds.far_m;
            let height =
                if scene.area.farthest_m > 0.0 { scene.area.lowest_m.max(0.1) } else { 1.0 };
            let round = crate::sensors::geometry::RoundEarth::new(far, radar.antenna_m, height);
            let flat = crate::sensors::geometry::TwoPaths::flat(far, radar.antenna_m, height);
            let g_flat = radar.pattern.elevation(flat.grazing_rad).sqrt();
            let g_round = radar.pattern.elevation(round.grazing_rad).sqrt();
            let change = ratio_db(gain, gain * round.divergence * (g_round / g_flat).min(1.0))
                + ratio_db(gain, gain * (g_flat / g_round).min(1.0));
            // The phase matters as much as lobes do, and at most fully.
            let turn = (std::f64::consts::TAU / radar.wavelength_m
                * (flat.difference_m - round.difference_m))
                .abs();
            let loss = Loss::either_way(deep(2.0 * change + bounds.lobing_db * turn.min(2.0)));
            (format!("to {far:.0} m"), vec![skip(loss), exact()])
        }
    }
}

fn ghosts(scene: &RadarScene<'_>, bounds: &Bounds) -> (String, Vec<Rung>) {
    let most = bounds.bins.iter().fold(f64::NEG_INFINITY, |m, b| m.max(b.snr_max_db));
    let required_db = to_db(scene.required) - 3.0;
    let visible = scene.buildings.iter().filter(|b| {
        let gamma = crate::sensors::ghost::facade_reflection(b.facade, scene.radar.carrier_ghz);
        // The mixed path loses one reflection and the side lobe floor; the double bounce two reflections.
        let mixed = 2.0 * to_db(gamma) + to_db(scene.radar.pattern.floor) + 6.02;
        let double = 4.0 * to_db(gamma);
        b.nearest_m(scene.site_m) < scene.area.beyond_m && most + mixed.max(double) >= required_db
    });
    let count = visible.count();
    let odds = if count > 0 { 1.0 } else { 0.0 };
    let called = format!("{count} reflecting buildings in reach");
    (called, vec![rung(Level::Skipped, Loss::odds(odds)), rung(Level::Exact, Loss::NONE)])
}
