//! The other half of the dial: what other tolerances of the effect plan would give and cost for the running scene, on request.
//!
//! For each tolerance a chain of its own, sensors and tracker, on the same truth and the same draws; one of them simulates everything
//! exactly, so that what leaving effects out moves is measured and not only bounded. The truth is that of the scans: a state at
//! the end of each, and a cubic between two of them (what a transponder answers is not in it). Nothing is asked of the SMDFM,
//! and no digest or pace depends on it. A thread makes the chains; it takes 40 % of a core at most and leaves scans out beyond that.

mod between;

use crate::runtime::clock::monotonic_ns;
use crate::runtime::messages::{ScanReport, TruthMessage};
use between::Between;
use crossbeam_channel::{Sender, bounded};
use models::effects::{PlanRow, Tolerance, changes};
use models::environment::Weather;
use models::flight_list::FlightList;
use models::frames::Point2;
use models::fusion::{Outcome, Tracker};
use models::sensors::{PlotSink, ScanInterval, Sensor, Truth};
use models::time::SimTime;
use models::track::TrackStatus;
use scenarios::Scene;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// One tolerance: what it has shown in the last minute, and what it leaves out now.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ToleranceRow {
    /// Tolerated rms distance of plots from those of everything exact, m; the other criteria in proportion to the scene's.
    pub tolerance_m: f64,
    /// Whether it is the run's own.
    pub run: bool,
    /// Root mean square error of the tracks just after each radar plot of a moving target in the last scan, m.
    pub rmse_now_m: Option<f64>,
    /// The same over the last 60 s.
    pub rmse_60s_m: Option<f64>,
    /// Plots behind that.
    pub plots: u32,
    /// Rms distance of its plots from the exact ones of the same targets over the last 60 s, m.
    pub apart_60s_m: Option<f64>,
    /// Share of the plots of targets over the last 60 s that only it or only the exact one has.
    pub alone_60s: Option<f64>,
    /// Mean wall time of the sensors, ns a target and scan.
    pub ns_per_target: Option<f64>,
    /// The same of all targets, µs a scan.
    pub scan_us: f64,
    /// Confirmed tracks now.
    pub tracks: usize,
    /// Effects left out now that would change something: sensor, effect, what it would change at most.
    pub skipped: Vec<[String; 3]>,
    /// Effects in a cheaper form than the one that is exact here.
    pub cheaper: usize,
}

/// What a page is told once a scan.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Told {
    /// The tolerances, exact first.
    pub rows: Vec<ToleranceRow>,
    /// Where the confirmed tracks of the tolerance asked for are, m east and north.
    pub ghosts_m: Vec<[f64; 2]>,
    /// Simulated time since when, s.
    pub since_s: f64,
    /// Share of the scans that was taken; the rest would have been too much.
    pub taken: f64,
    /// Why there is nothing; empty else.
    pub why_not: String,
}

/// Tolerances on the slider, m.
const LADDER_M: [f64; 7] = [0.0, 0.05, 0.1, 0.25, 0.5, 1.0, 2.0];
/// Share of a core that all chains may take.
const SHARE: f64 = 0.4;
/// Slower targets do not count as moving, m/s; as in the measures of the run.
const MOVING_MPS: f64 = 1.0;
const MINUTE_NS: i64 = 60_000_000_000;
/// Ghosts that are drawn, at most.
const MOST_GHOSTS: usize = 4096;

/// Sums of one scan.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    at: SimTime,
    track2: f64,
    plots: u32,
    apart2: f64,
    pairs: u32,
    alone: u32,
}

/// Sensors and a tracker of one tolerance.
struct Chain {
    tolerance: Tolerance,
    run: bool,
    sensors: Vec<Box<dyn Sensor>>,
    tracker: Tracker,
    last: VecDeque<Sums>,
    took_ns: u64,
    targets: u64,
    scans: u32,
    tracks_m: Vec<[f64; 2]>,
}

/// All chains; the first is exact.
pub(super) struct Chains {
    scene: Arc<Scene>,
    seed: u64,
    chains: Vec<Chain>,
    since: Option<SimTime>,
    turn: usize,
}

/// One scan, with the truth at the end of the one before.
pub(super) struct Work {
    scan: u64,
    to: SimTime,
    truth: Vec<TruthMessage>,
    before: Option<(SimTime, Vec<TruthMessage>)>,
    flights: FlightList,
    ghost_m: Option<f64>,
}

impl Work {
    /// A scan, with the truth at the end of the one before where that is known.
    pub(super) fn of(
        report: &ScanReport,
        before: Option<(SimTime, Vec<TruthMessage>)>,
        flights: &FlightList,
        ghost_m: Option<f64>,
    ) -> Self {
        let (scan, to) = (report.scan, SimTime(report.time_ns));
        let (truth, flights) = (report.truth.clone(), flights.clone());
        Self { scan, to, truth, before, flights, ghost_m }
    }
}

/// The tolerances to compare: the ladder in proportion to the scene's, with the scene's own.
fn ladder(own: Tolerance) -> Vec<(Tolerance, bool)> {
    let base = if own.position_m > 0.0 { own } else { Tolerance::default() };
    let of = |metres: f64| match metres {
        0.0 => Tolerance { jerk_m2_s5: own.jerk_m2_s5, ..Tolerance::EXACT },
        metres => Tolerance { time_budget_us: None, ..base.times(metres / base.position_m) },
    };
    let same = |metres: f64| (metres - own.position_m).abs() < 1e-9 && own.time_budget_us.is_none();
    // A scene may tolerate no distance and still something else: then its row is not the exact one.
    let exact = |metres: f64| metres == 0.0;
    let mut rows: Vec<_> = LADDER_M
        .iter()
        .filter(|m| exact(**m) || !same(**m))
        .map(|m| (of(*m), exact(*m) && own == of(*m)))
        .collect();
    if !rows.iter().any(|row| row.1) {
        rows.push((own, true));
    }
    rows[1..].sort_by(|a, b| a.0.position_m.total_cmp(&b.0.position_m));
    rows
}

impl Chains {
    /// Chains that have seen nothing yet.
    ///
    /// # Errors
    /// One sentence if a sensor cannot be made, or the scene has none to plan.
    pub(super) fn new(scene: Arc<Scene>, seed: u64) -> Result<Self, String> {
        let mut chains = Vec::new();
        for (tolerance, run) in ladder(scene.tolerance()) {
            let made: Result<Vec<_>, String> =
                scene.sensors.iter().map(|s| s.made(&scene, tolerance)).collect();
            let sensors: Vec<_> = made?.into_iter().flatten().collect();
            if sensors.is_empty() {
                return Err("the scene has no sensor that is simulated".to_owned());
            }
            chains.push(Chain {
                tolerance,
                run,
                sensors,
                tracker: Tracker::new(scene.tracking_config()),
                last: VecDeque::new(),
                took_ns: 0,
                targets: 0,
                scans: 0,
                tracks_m: Vec::new(),
            });
        }
        Ok(Self { scene, seed, chains, since: None, turn: 0 })
    }

    /// Runs every chain on one scan.
    pub(super) fn scan(&mut self, work: &Work) {
        self.since.get_or_insert(work.to);
        let scan = self.scene.run.scan();
        let from = SimTime(work.to.0 - scan.0);
        let interval = ScanInterval { run_seed: self.seed, scan: work.scan, from, to: work.to };
        let notice = self.scene.weather.iter().rev().find(|n| n.time <= from);
        let weather =
            notice.map_or_else(Weather::default, |n| n.weather.after(from.since_s(n.time)));
        let truth = Between::of(&self.scene, work, scan);
        let count = self.chains.len();
        let mut sinks = vec![PlotSink::default(); count];
        // Who comes first brings the targets into the caches: each in its turn, so that none pays for all.
        for turn in 0..count {
            let which = (self.turn + turn) % count;
            let chain = &mut self.chains[which];
            let began = monotonic_ns();
            for sensor in &mut chain.sensors {
                sensor.scan(&interval, &truth, &weather, &mut sinks[which]);
            }
            chain.took_ns += monotonic_ns().saturating_sub(began);
            chain.targets += truth.len() as u64;
            chain.scans += 1;
        }
        self.turn = (self.turn + 1) % count;
        let exact = by_target(&sinks[0]);
        for (chain, sink) in self.chains.iter_mut().zip(&sinks) {
            chain.judge(&truth, work, sink, &exact);
        }
    }

    /// What has been seen so far.
    pub(super) fn told(&self, ghost_m: Option<f64>) -> Told {
        let name = |row: &PlanRow| {
            let sensor = self.scene.sensors.iter().find(|s| s.id == row.sensor);
            sensor.map_or_else(String::new, |s| s.name.clone())
        };
        let exact: Vec<PlanRow> =
            self.chains[0].sensors.iter().flat_map(|s| s.plan()).cloned().collect();
        let wanted = |chain: &&Chain| ghost_m.is_some_and(|m| (chain.metres() - m).abs() < 1e-9);
        let ghost = self.chains.iter().find(wanted);
        Told {
            rows: self.chains.iter().map(|chain| chain.row(&exact, &name)).collect(),
            ghosts_m: ghost.map_or_else(Vec::new, |chain| chain.tracks_m.clone()),
            since_s: self.since.map_or(0.0, SimTime::s),
            taken: 1.0,
            why_not: String::new(),
        }
    }
}

/// Plots of targets in the order of time: of which sensor and target, when, and where.
type ByTarget = BTreeMap<(u16, u64), Vec<(SimTime, Point2<f64>)>>;

fn by_target(sink: &PlotSink) -> ByTarget {
    let mut found = ByTarget::new();
    for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
        if let Some(key) = cause.key {
            let row = found.entry((plot.sensor.0, key)).or_default();
            row.push((plot.time, plot.position_m));
        }
    }
    found.values_mut().for_each(|row| row.sort_by_key(|p| p.0));
    found
}

/// Sum of squared distances of the plots that both have, how many these are, and how many only one has.
fn apart(exact: &ByTarget, own: &ByTarget) -> (f64, u32, u32) {
    let (mut apart2, mut pairs, mut alone) = (0.0, 0, 0);
    let none = Vec::new();
    let keys: BTreeSet<_> = exact.keys().chain(own.keys()).collect();
    for key in keys {
        let (mut a, mut b) = (
            exact.get(key).unwrap_or(&none).iter().peekable(),
            own.get(key).unwrap_or(&none).iter().peekable(),
        );
        // Both in the order of time: the earlier of two that are not of one moment stands alone.
        while let (Some(x), Some(y)) = (a.peek(), b.peek()) {
            let later_ns = x.0.0 - y.0.0;
            if later_ns.abs() <= ONE_LOOK_NS {
                apart2 += (x.1 - y.1).norm_squared();
                pairs += 1;
                a.next();
                b.next();
                continue;
            }
            alone += 1;
            if later_ns < 0 {
                a.next()
            } else {
                b.next()
            };
        }
        alone += (a.count() + b.count()) as u32;
    }
    (apart2, pairs, alone)
}

/// Plots of one look at a target lie no farther apart in time: a radar's beam passes it sooner or later by what its azimuth errs.
const ONE_LOOK_NS: i64 = 100_000_000;

impl Chain {
    fn metres(&self) -> f64 {
        self.tolerance.position_m
    }

    fn judge(&mut self, truth: &Between<'_>, work: &Work, sink: &PlotSink, exact: &ByTarget) {
        let tracks = self.tracker.scan(work.to, &sink.plots, &work.flights);
        let confirmed = tracks.iter().filter(|t| t.status == TrackStatus::Confirmed);
        self.tracks_m =
            confirmed.map(|t| [t.position_m.x, t.position_m.y]).take(MOST_GHOSTS).collect();
        let (apart2, pairs, alone) = apart(exact, &by_target(sink));
        let mut sums = Sums { at: work.to, apart2, pairs, alone, ..Sums::default() };
        for ((plot, cause), outcome) in
            sink.plots.iter().zip(&sink.causes).zip(self.tracker.outcomes())
        {
            let (true, Some(key), Some(at_m)) = (plot.kind.radar, cause.key, cause.truth_m) else {
                continue;
            };
            if let Outcome::Used { number: Some(_), position_m, .. } = outcome
                && truth.moves(key)
            {
                sums.track2 += (position_m - at_m).norm_squared();
                sums.plots += 1;
            }
        }
        self.last.push_back(sums);
        while self.last.front().is_some_and(|s| work.to.0 - s.at.0 >= MINUTE_NS) {
            self.last.pop_front();
        }
    }

    fn row(&self, exact: &[PlanRow], name: &dyn Fn(&PlanRow) -> String) -> ToleranceRow {
        let mean = |sum: f64, n: u32| (n > 0).then(|| sum / f64::from(n));
        let now = self.last.back().copied().unwrap_or_default();
        let minute = self.last.iter().fold(Sums::default(), |a, b| Sums {
            at: b.at,
            track2: a.track2 + b.track2,
            plots: a.plots + b.plots,
            apart2: a.apart2 + b.apart2,
            pairs: a.pairs + b.pairs,
            alone: a.alone + b.alone,
        });
        let rows = || self.sensors.iter().flat_map(|s| s.plan());
        // What is not there is left out everywhere and changes nothing.
        let there = |row: &&PlanRow| row.bound > 0.0 && !row.unit.is_empty();
        let skipped = rows().filter(there).filter(|row| row.is_skipped());
        let bound = |row: &PlanRow| format!("{:.2e} {}", row.bound, row.unit);
        let own: Vec<PlanRow> = rows().cloned().collect();
        let left_out = |effect: &str| rows().any(|r| r.effect == effect && r.is_skipped());
        let cheaper =
            changes(exact, &own).iter().filter(|c| c.to < c.from && !left_out(c.effect)).count();
        ToleranceRow {
            tolerance_m: self.metres(),
            run: self.run,
            rmse_now_m: mean(now.track2, now.plots).map(f64::sqrt),
            rmse_60s_m: mean(minute.track2, minute.plots).map(f64::sqrt),
            plots: minute.plots,
            apart_60s_m: mean(minute.apart2, minute.pairs).map(f64::sqrt),
            alone_60s: mean(f64::from(minute.alone), minute.pairs + minute.alone),
            ns_per_target: (self.targets > 0).then(|| self.took_ns as f64 / self.targets as f64),
            scan_us: self.took_ns as f64 * 1e-3 / f64::from(self.scans.max(1)),
            tracks: self.tracks_m.len(),
            skipped: skipped.map(|r| [name(r), r.effect.to_owned(), bound(r)]).collect(),
            cheaper,
        }
    }
}

/// The chains on a thread of their own. It ends when this is dropped.
#[derive(Debug)]
pub struct Tolerances {
    send: Sender<Box<Work>>,
    /// Monotonic time before which nothing is begun, ns.
    rest_ns: Arc<AtomicU64>,
    before: Option<(SimTime, Vec<TruthMessage>)>,
    seen: Arc<AtomicU64>,
}

impl std::fmt::Debug for Work {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "scan {}", self.scan)
    }
}

impl Tolerances {
    /// Begins; `tell` is called on that thread after each scan that was taken.
    #[must_use]
    pub fn begin(scene: Arc<Scene>, seed: u64, tell: impl Fn(Told) + Send + 'static) -> Self {
        let (send, receive) = bounded::<Box<Work>>(1);
        let (rest_ns, seen) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicU64::new(0)));
        let (rest, scans) = (Arc::clone(&rest_ns), Arc::clone(&seen));
        let work = move || {
            let mut chains = match Chains::new(scene, seed) {
                Ok(chains) => chains,
                Err(why_not) => return tell(Told { why_not, ..Told::default() }),
            };
            let mut taken = 0.0;
            for work in receive {
                let began = monotonic_ns();
                chains.scan(&work);
                taken += 1.0;
                let all = scans.load(Ordering::Relaxed).max(1) as f64;
                tell(Told { taken: (taken / all).min(1.0), ..chains.told(work.ghost_m) });
                let now = monotonic_ns();
                let pause_ns = now.saturating_sub(began) as f64 * (1.0 / SHARE - 1.0);
                rest.store(now.saturating_add(pause_ns as u64), Ordering::Relaxed);
            }
        };
        if let Err(error) = std::thread::Builder::new().name("tolerances".to_owned()).spawn(work) {
            tracing::warn!(%error, "other tolerances are not compared");
        }
        Self { send, rest_ns, before: None, seen }
    }

    /// Hands a scan over, unless the one before is still being worked on or it rests.
    pub fn scan(&mut self, report: &ScanReport, flights: &FlightList, ghost_m: Option<f64>) {
        let to = SimTime(report.time_ns);
        let before = self.before.replace((to, report.truth.clone()));
        self.seen.fetch_add(1, Ordering::Relaxed);
        if monotonic_ns() < self.rest_ns.load(Ordering::Relaxed) {
            return;
        }
        let work = Work::of(report, before, flights, ghost_m);
        self.send.try_send(Box::new(work)).ok(); // a full queue: the next scan
    }
}

#[cfg(test)]
mod tests;
