//! Induction loops in the pavement ("magnetic" sensors): a passage gives a time at a known place.
//!
//! One loop reports when it becomes occupied; two in a row give speed and length too, and report the
//! centre of the target when the second one falls free. Neither says who passes. A loop measures
//! along the taxiway only: the variance across is infinite.
//!
//! Source: speed and length from the traffic detector literature (Klein, Mills & Gibson, *Traffic
//! Detector Handbook*, FHWA 2006); delays, detection and false rates are assumptions.

mod config;

pub use config::{LoopConfig, LoopPair, occupancy_s, sigma_passage_m};

use crate::draw::{DrawKey, Purpose, exponential, normal_pair, uniform};
use crate::effects::positioning::{
    Ladders, Model, Planning, PositioningEffect as E, PositioningScene,
};
use crate::effects::{Level, Loss, PlanRow};
use crate::environment::Weather;
use crate::frames::{Azimuth, Point2, Vector2};
use crate::kind::{Assumed, Kind, Symbol};
use crate::plot::{Plot, SensorId, SensorKind};
use crate::sensors::config::ConfigError;
use crate::sensors::declared::{Declared, Modelled, Settings};
use crate::sensors::planned::Planned;
use crate::sensors::reporting::bounds::{SIGMAS, duration, percent, two};
use crate::sensors::reporting::cooperative::shown;
use crate::sensors::{Cause, Contribution, PlotSink, ScanInterval, Sensor, Truth};
use crate::time::SimTime;
use config::KEYS;
use std::sync::Arc;

/// A loop, or a pair of them.
#[derive(Clone, Debug)]
pub struct InductionLoop {
    config: LoopConfig,
    along: Vector2<f64>,
    /// Passages under way, sorted by key.
    passages: Vec<Passage>,
    /// Number and time of the next false passage.
    next_false: Option<(u64, SimTime)>,
    /// Beginning of the first scan, from which false passages come.
    begins: Option<SimTime>,
    planning: Planning,
}

/// A target over the loops.
#[derive(Clone, Copy, Debug)]
struct Passage {
    key: u64,
    /// When it came over the first loop and over the second (in its own direction), s.
    on: [Option<SimTime>; 2],
    /// Which loops it covers at the last look.
    over: [bool; 2],
}

/// Looks at a target near the loop are this far apart, on whole multiples since the start.
const LOOK_NS: i64 = 50_000_000;
/// Higher than this one is felt by no loop, m (assumed: metal a few metres up leaves it as it is).
const OVER_M: f64 = 3.0;
/// Nearest to the loop that a target is looked at so often, m and s of its speed.
const NEAR_M: f64 = 150.0;

impl InductionLoop {
    /// A sensor with these parameters.
    ///
    /// # Errors
    /// [`ConfigError`] if a parameter is outside its limits.
    pub fn new(config: LoopConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let along = Azimuth::from_rad(config.direction_deg.to_radians()).unit();
        let planning = Planning::new(config.id, &MODEL).always();
        Ok(Self { config, along, passages: Vec::new(), next_false: None, begins: None, planning })
    }

    /// Which loops a target covers at `time`; `None` while it does not exist.
    fn over(&self, truth: &dyn Truth, index: usize, time: SimTime) -> Option<[bool; 2]> {
        let config = &self.config;
        let state = truth.at(index, time)?;
        let offset_m = state.position_m.xy() - config.site_m;
        let across_m = offset_m.x * self.along.y - offset_m.y * self.along.x;
        if across_m.abs() > config.half_width_m || state.position_m.z > OVER_M {
            return Some([false, false]);
        }
        let nose = Azimuth::from_rad(state.heading_rad).unit();
        let reach_m =
            0.5 * truth.class(index).length_m * nose.dot(&self.along).abs() + 0.5 * config.length_m;
        let along_m = offset_m.dot(&self.along);
        let second = config.pair.is_some_and(|p| (along_m - p.spacing_m).abs() <= reach_m);
        Some([along_m.abs() <= reach_m, second])
    }

    /// The instant in (`before`, `after`] at which loop `which` changed, to a microsecond.
    fn change(
        &self,
        truth: &dyn Truth,
        index: usize,
        which: usize,
        mut before: SimTime,
        mut after: SimTime,
    ) -> SimTime {
        let end = self.over(truth, index, after).map(|o| o[which]);
        while after.0 - before.0 > 1000 {
            let middle = SimTime(before.0 + (after.0 - before.0) / 2);
            if self.over(truth, index, middle).map(|o| o[which]) == end {
                after = middle;
            } else {
                before = middle;
            }
        }
        after
    }

    /// Follows one target from `from` to `to`; gives what is reported of it.
    fn follow(
        &mut self,
        interval: &ScanInterval,
        truth: &dyn Truth,
        index: usize,
        found: &mut Vec<(Plot, Cause)>,
    ) -> u64 {
        let key = truth.key(index);
        let at = self.passages.partition_point(|p| p.key < key);
        let known = self.passages.get(at).is_some_and(|p| p.key == key);
        let site_m = self.config.site_m;
        let near = |time: SimTime| {
            truth.at(index, time).is_some_and(|s| {
                let reach_m = NEAR_M + s.velocity_mps.norm() * interval.to.since_s(interval.from);
                (s.position_m.xy() - site_m).norm() < reach_m
            })
        };
        if !known && !near(interval.to) && !near(interval.from) {
            return 0;
        }
        if !known {
            let over = self.over(truth, index, interval.from).unwrap_or_default();
            // Whoever stands on a loop from the beginning came on at no known time.
            self.passages.insert(at, Passage { key, on: [None; 2], over });
        }
        let mut looks = 0;
        let mut before = interval.from;
        while before < interval.to {
            let next = SimTime((before.0.div_euclid(LOOK_NS) + 1) * LOOK_NS).min(interval.to);
            let over = self.over(truth, index, next).unwrap_or_default();
            let was = self.passages[at];
            for (which, now) in over.into_iter().enumerate() {
                if now != was.over[which] {
                    let instant = self.change(truth, index, which, before, next);
                    looks += self.changed(interval, truth, index, at, which, instant, found);
                }
            }
            self.passages[at].over = over;
            before = next;
        }
        let idle = self.passages[at].over == [false; 2] && !near(interval.to);
        if idle {
            self.passages.remove(at);
        }
        looks
    }

    /// A loop became occupied or free at `instant`; gives how many reports were due.
    #[expect(clippy::too_many_arguments, reason = "one event with all that it needs")]
    fn changed(
        &mut self,
        interval: &ScanInterval,
        truth: &dyn Truth,
        index: usize,
        at: usize,
        which: usize,
        instant: SimTime,
        found: &mut Vec<(Plot, Cause)>,
    ) -> u64 {
        let passage = &mut self.passages[at];
        let occupied = !passage.over[which];
        if occupied {
            passage.on[which] = Some(instant);
        }
        let passage = *passage;
        let Some(state) = truth.at(index, instant) else { return 0 };
        // Named by its beginning: one passage, one set of draws.
        let begin = passage.on[0].or(passage.on[1]).unwrap_or(instant);
        let draw = DrawKey {
            run_seed: interval.run_seed,
            sensor: u32::from(self.config.id.0),
            entity: passage.key,
            scan: begin.0 as u64,
        };
        let mut rng = draw.rng(DRAWS);
        let detected = uniform(&mut rng) < self.config.pd;
        let mut delays = [uniform(&mut rng), uniform(&mut rng), uniform(&mut rng)]
            .map(|u| u * self.config.delay_s);
        let (mut edge, mut spacing) = normal_pair(&mut rng);
        let levels = self.planning.levels_for(&state.velocity_mps, || 0.0);
        let [reception, delay, at_edge, apart] =
            [E::Reception, E::Delay, E::Edge, E::Spacing].map(|e| levels.on(e));
        let detected = detected || !reception;
        if !delay {
            delays = [0.0; 3];
        }
        edge = if at_edge { edge } else { 0.0 };
        spacing = if apart { spacing } else { 0.0 };
        let forward = state.velocity_mps.xy().dot(&self.along) >= 0.0;
        let report = match (self.config.pair, occupied) {
            (None, true) => Some(self.single(forward, edge, delays[0], instant)),
            (Some(pair), false) => {
                let last = if forward { 1 } else { 0 };
                match (which == last, passage.on[1 - last], passage.on[last]) {
                    (true, Some(first), Some(second)) => self.double(
                        pair,
                        forward,
                        [edge, spacing],
                        delays,
                        [first, second, instant],
                    ),
                    _ => None,
                }
            }
            _ => None,
        };
        let Some((time, along_m, variance_m2)) = report else { return 0 };
        let pair = self.config.pair;
        for (on, effect) in [
            (reception, E::Reception),
            (delay, E::Delay),
            (at_edge, E::Edge),
            (apart && pair.is_some(), E::Spacing),
        ] {
            self.planning.add(effect, u64::from(on));
        }
        if !occupied {
            self.passages[at].on = [None; 2];
        }
        if detected {
            let position_m = self.config.site_m + self.along * along_m;
            let truth_m = truth.at(index, time).unwrap_or(state).position_m.xy();
            let spacing_m = pair.map_or(0.0, |p| p.sigma_spacing_m * spacing);
            let shown = [
                shown(&levels, E::Delay, time.since_s(instant), "s"),
                shown(&levels, E::Edge, self.config.sigma_edge_m * edge, "m"),
                pair.and_then(|_| shown(&levels, E::Spacing, spacing_m, "m")),
            ];
            let of = |(effect, value, unit)| Contribution { effect, value, unit };
            let effects = shown.into_iter().flatten().map(of).collect();
            let cause = Cause { key: Some(passage.key), truth_m: Some(truth_m), effects };
            found.push((self.plot(time, position_m, variance_m2), cause));
        }
        1
    }

    /// One loop: the front edge is at the near edge of the loop, the centre half an assumed length back.
    fn single(&self, forward: bool, edge: f64, delay_s: f64, on: SimTime) -> (SimTime, f64, f64) {
        let config = &self.config;
        let sign = if forward { 1.0 } else { -1.0 };
        let sigma_m =
            sigma_passage_m(config.sigma_edge_m, config.assumed_speed_mps, config.sigma_t_s());
        let centre_m = -sign * (0.5 * config.length_m + config.assumed_half_length_m)
            + config.sigma_edge_m * edge;
        let variance_m2 =
            sigma_m * sigma_m + config.sigma_half_length_m * config.sigma_half_length_m;
        (on.plus_s(delay_s), centre_m, variance_m2)
    }

    /// Two loops: speed from the two beginnings, centre half an occupation behind the last loop's
    /// centre moment. `None` where the delays leave no sensible speed.
    fn double(
        &self,
        pair: LoopPair,
        forward: bool,
        [edge, spacing]: [f64; 2],
        delays_s: [f64; 3],
        [first, second, off]: [SimTime; 3],
    ) -> Option<(SimTime, f64, f64)> {
        let config = &self.config;
        let (t0, t1, t2) =
            (first.plus_s(delays_s[0]), second.plus_s(delays_s[1]), off.plus_s(delays_s[2]));
        let passage_s = t1.since_s(t0);
        // Above 100 m/s no target taxies: the delays have eaten the passage.
        if passage_s <= pair.spacing_m / 100.0 {
            return None;
        }
        let speed_mps = (pair.spacing_m + pair.sigma_spacing_m * spacing) / passage_s;
        let occupied_s = t2.since_s(t1);
        let sign = if forward { 1.0 } else { -1.0 };
        let last_m = if forward { pair.spacing_m } else { 0.0 };
        let centre_m = last_m + sign * 0.5 * speed_mps * occupied_s + config.sigma_edge_m * edge;
        let sigma_t_s = config.sigma_t_s();
        let passage_m = sigma_passage_m(config.sigma_edge_m, speed_mps, sigma_t_s);
        let stretch_m = 0.5 * occupied_s * pair.sigma_speed_mps(speed_mps, sigma_t_s);
        Some((t2, centre_m, passage_m * passage_m + stretch_m * stretch_m))
    }

    fn plot(&self, time: SimTime, position_m: Point2<f64>, variance_m2: f64) -> Plot {
        Plot {
            sensor: self.config.id,
            kind: SensorKind::Loop,
            time,
            sequence: 0,
            position_m,
            axis: self.along,
            along_m2: variance_m2,
            across_m2: f64::INFINITY,
            altitude_m: None,
            polar: None,
            identity: None,
            scnr_db: None,
        }
    }

    /// False passages until the end of the interval: a Poisson process drawn event by event.
    fn false_passages(&mut self, interval: &ScanInterval, found: &mut Vec<(Plot, Cause)>) {
        let begins = *self.begins.get_or_insert(interval.from);
        if self.config.false_per_h <= 0.0 || !self.planning.levels().on(E::FalsePassages) {
            return;
        }
        self.planning.count(E::FalsePassages);
        let gap_s = 3600.0 / self.config.false_per_h;
        let sensor = u32::from(self.config.id.0);
        let draw = |number| DrawKey {
            run_seed: interval.run_seed,
            sensor,
            entity: u64::MAX,
            scan: number,
        };
        let after = |number, time: SimTime| {
            let wait_s = gap_s * exponential(&mut draw(number).rng(DRAWS));
            if wait_s < 3e9 {
                SimTime(time.0.saturating_add(SimTime::from_s(wait_s).0))
            } else {
                SimTime(i64::MAX)
            }
        };
        let (mut number, mut time) = self.next_false.unwrap_or_else(|| (0, after(0, begins)));
        while time <= interval.from {
            // From a time in which they were left out.
            number += 1;
            time = after(number, time);
        }
        while time <= interval.to {
            let sigma_m = libm::hypot(self.config.sigma_edge_m, self.config.sigma_half_length_m);
            found.push((self.plot(time, self.config.site_m, sigma_m * sigma_m), Cause::default()));
            number += 1;
            time = after(number, time);
        }
        self.next_false = Some((number, time));
    }
}

impl Planned for InductionLoop {
    fn planning(&self) -> &Planning {
        &self.planning
    }

    fn planning_mut(&mut self) -> &mut Planning {
        &mut self.planning
    }
}

impl Sensor for InductionLoop {
    fn id(&self) -> SensorId {
        self.config.id
    }

    fn kind(&self) -> SensorKind {
        SensorKind::Loop
    }

    fn plan(&self) -> &[PlanRow] {
        self.planning.rows()
    }

    fn evaluations(&self) -> Vec<(&'static str, u64)> {
        self.planning.evaluations()
    }

    fn scan(
        &mut self,
        interval: &ScanInterval,
        truth: &dyn Truth,
        _weather: &Weather,
        out: &mut PlotSink,
    ) {
        let mut found = Vec::new();
        if self.planning.wants_survey(truth.len()) {
            for index in 0..truth.len() {
                let state = truth.at(index, interval.to).or_else(|| truth.at(index, interval.from));
                if let Some(state) = state {
                    self.planning.see(&state.velocity_mps, 0.0);
                }
            }
        }
        self.planning.prepare(|scene| ladders(&self.config, scene));
        for index in 0..truth.len() {
            out.looks += self.follow(interval, truth, index, &mut found);
        }
        self.false_passages(interval, &mut found);
        for (sequence, (mut plot, mut cause)) in found.into_iter().enumerate() {
            plot.sequence = sequence as u32;
            if !out.explain {
                cause.effects = Vec::new();
            }
            out.plots.push(plot);
            out.causes.push(cause);
        }
    }
}

/// Detections, delays, edges, false passages.
const DRAWS: Purpose = Purpose::Own(22);

/// The kind `loop`.
pub static DECLARED: Declared = Declared {
    kind: Kind {
        word: "loop",
        title: "Induction loop",
        about: "Passages over one or two loops in the pavement: edges, delays, missed and false passages",
        colours: ["#d59a6a", "#8a4b16"],
        symbol: Symbol::HOURGLASS,
        radar: false,
        needs_site: true,
        carried: false,
        presets: &[("pair", "two loops of 2 m, 5 m apart"), ("single", "one loop of 2 m")],
        keys: &[KEYS],
        draws: &[DRAWS],
        assumed: Assumed::NOTHING,
    },
    read: Some(|given| Ok(Arc::new(LoopConfig::read(given)?))),
    models: &[Modelled {
        model: &MODEL,
        // Loops across fifty lanes.
        example: |id| {
            let site_m = Point2::new(0.0, 100.0);
            let config = LoopConfig {
                half_width_m: 100.0,
                false_per_h: 1.0,
                ..LoopConfig::pair_at(id, site_m, 90.0)
            };
            Ok(Box::new(InductionLoop::new(config)?))
        },
        file: file!(),
    }],
};

impl Settings for LoopConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        self.validate()
    }

    fn timing_s(&self) -> (f64, f64) {
        (1.0, 0.0)
    }

    fn model(&self) -> Result<Box<dyn Planned>, ConfigError> {
        Ok(Box::new(InductionLoop::new(self.clone())?))
    }

    fn shifts_s(&self) -> f64 {
        self.delay_s
    }
}

/// What is planned of it.
pub static MODEL: Model = Model {
    name: "loop",
    reads_speed: true,
    reads_distance: false,
    costs: &[
        (E::Reception, Level::Exact, 21),
        (E::Delay, Level::Exact, 89),
        (E::Edge, Level::Exact, 56),
        (E::Spacing, Level::Exact, 61),
        (E::FalsePassages, Level::Exact, 0),
    ],
};

/// Loops in the pavement.
fn ladders(config: &LoopConfig, scene: &PositioningScene) -> Ladders {
    let speed_mps = scene.conditions.speed_mps;
    // A pair's centre goes with the quotient of two times; a target may stop over it.
    let unless = |zero: bool| Loss::moves(if zero { 0.0 } else { f64::INFINITY });
    let delay = match config.pair {
        None => Loss::moves(speed_mps * config.delay_s),
        Some(_) => unless(config.delay_s == 0.0),
    };
    let mut effects = vec![
        two(
            E::Reception,
            format!("{} of passages detected", percent(config.pd)),
            Loss::odds(1.0 - config.pd),
        ),
        two(E::Delay, format!("up to {} s at up to {speed_mps} m/s", config.delay_s), delay),
        two(
            E::Edge,
            format!("σ {} m", config.sigma_edge_m),
            Loss::moves(SIGMAS * config.sigma_edge_m),
        ),
    ];
    if let Some(pair) = &config.pair {
        let called = format!("σ {} m of {} m", pair.sigma_spacing_m, pair.spacing_m);
        effects.push(two(E::Spacing, called, unless(pair.sigma_spacing_m == 0.0)));
    }
    let mean =
        if config.false_per_h > 0.0 { config.false_per_h * scene.horizon_s / 3600.0 } else { 0.0 };
    effects.push(two(
        E::FalsePassages,
        format!("{} in an hour, {}", config.false_per_h, duration(scene.horizon_s)),
        Loss::odds(-libm::expm1(-mean)),
    ));
    Ladders { model: &MODEL, effects, step_m: 0.0 }
}

#[cfg(test)]
mod tests;
