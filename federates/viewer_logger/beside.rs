//! The dial: what every rung of the filter ladder would give for the running scene, on request.
//!
//! The viewer-logger hears every plot, so it can run other trackers on the same plots without asking the
//! SMDFM for anything: no digest and no pace depends on who watches. The chosen rung runs along from the
//! same scan on, so that all rows have seen the same. Where all rungs together would take more than 40 % of a
//! core, only the neighbours of the chosen one go on, and that is said.

use crate::runtime::clock::monotonic_ns;
use crate::runtime::messages::{PlotMessage, ScanReport};
use models::filter::Rung;
use models::flight_list::FlightList;
use models::frames::Vector2;
use models::fusion::{Outcome, Shadow, Shadows, Tracker, TrackingConfig};
use models::plot::{Callsign, Identity, Plot, Polar, SensorId};
use models::time::SimTime;
use models::track::{SystemTrack, TrackStatus};
use serde::Serialize;
use std::collections::{BTreeMap, VecDeque};

/// One rung: what it has shown since the comparison began.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RungRow {
    /// Name of the filter, as scenes name it.
    pub rung: String,
    /// What it does, for people.
    pub about: &'static str,
    /// Whether the run's tracks come from this one.
    pub chosen: bool,
    /// Root mean square error just after each update by a radar plot of a moving target, m; none yet without one.
    pub rmse_m: Option<f64>,
    /// The same of the last scan.
    pub rmse_now_m: Option<f64>,
    /// The same over the last 60 s.
    pub rmse_60s_m: Option<f64>,
    /// Plots behind [`Self::rmse_m`].
    pub plots: u32,
    /// The same plots themselves, m.
    pub raw_rmse_m: Option<f64>,
    /// The plots of the last 60 s, m.
    pub raw_rmse_60s_m: Option<f64>,
    /// Mean wall time of a scan (gates, association, update, life of tracks), µs.
    pub scan_us: f64,
    /// The same a track of the scan, µs; none before there was a track.
    pub us_per_track: Option<f64>,
    /// Confirmed tracks now.
    pub tracks: usize,
    /// Simulated time since when, s.
    pub since_s: f64,
}

/// Squares and plots of one scan.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    at: SimTime,
    track2: f64,
    plot2: f64,
    plots: u32,
}

#[derive(Debug, Default)]
struct Score {
    all: Sums,
    last: VecDeque<Sums>,
    took_ns: u64,
    scans: u32,
    track_scans: u64,
    tracks: usize,
    tracks_m: Vec<[f64; 2]>,
}

/// The chosen tracker again, and the others.
#[derive(Debug)]
pub struct Beside {
    config: TrackingConfig,
    since: Option<SimTime>,
    chosen: Tracker,
    shadows: Vec<Shadow>,
    scores: Vec<Score>, // chosen first
    /// Whether only the neighbours go on.
    few: bool,
    /// Whether scans come as time passes, so that all rungs together have a share of a core and no more.
    paced: bool,
    /// The rung whose tracks are drawn.
    ghost: Option<Rung>,
}

/// Slower targets do not count as moving, m/s; as in the measures of the run.
const MOVING_MPS: f64 = 1.0;
/// "Now" and "the last minute", ns.
const MINUTE_NS: i64 = 60_000_000_000;
/// Share of a core that all rungs may take, and scans before that is judged.
const SHARE: f64 = 0.4;
const JUDGED_AFTER: u32 = 5;
/// Ghosts that are drawn, at most.
const MOST_GHOSTS: usize = 4096;

impl Beside {
    /// Trackers of every rung that know nothing yet, for scans that come as time passes.
    #[must_use]
    pub fn new(config: &TrackingConfig) -> Self {
        let mapped = config.filter.map.is_some();
        let others = Rung::ALL.map(|(rung, _)| rung).into_iter().filter(|rung| {
            // Without a map that rung is another one.
            *rung != config.filter.rung && (mapped || *rung != Rung::Mh9Map)
        });
        let shadows = others.map(|rung| Shadow::new(config, rung)).collect();
        Self::of(config, shadows, false)
    }

    /// The same for scans of a finished run: they wait, so that no rung is left out.
    #[must_use]
    pub fn unhurried(config: &TrackingConfig) -> Self {
        Self { paced: false, ..Self::new(config) }
    }

    fn of(config: &TrackingConfig, shadows: Vec<Shadow>, few: bool) -> Self {
        Self {
            scores: (0..=shadows.len()).map(|_| Score::default()).collect(),
            chosen: Tracker::new(config.clone()),
            config: config.clone(),
            since: None,
            shadows,
            few,
            paced: true,
            ghost: None,
        }
    }

    /// Whose tracks are wanted as a ghost, by name; none for an unknown one.
    pub fn ghost(&mut self, rung: Option<&str>) {
        self.ghost = rung.and_then(Rung::of);
    }

    /// Where the ghost's confirmed tracks are, m east and north.
    #[must_use]
    pub fn ghosts_m(&self) -> &[[f64; 2]] {
        let at = self.rungs().position(|rung| self.ghost == Some(rung));
        at.map_or(&[], |at| &self.scores[at].tracks_m)
    }

    /// The chosen rung, and the others in the order of their trackers.
    fn rungs(&self) -> impl Iterator<Item = Rung> {
        std::iter::once(self.config.filter.rung).chain(self.shadows.iter().map(Shadow::rung))
    }

    /// Whether only the neighbours of the chosen rung go on, because all of them take too much.
    #[must_use]
    pub fn few(&self) -> bool {
        self.few
    }

    /// Runs every rung on the plots of a scan.
    pub fn scan(&mut self, report: &ScanReport, flights: &FlightList) {
        let to = SimTime(report.time_ns);
        let since = *self.since.get_or_insert(to);
        let plots: Vec<Plot> = report.plots.iter().filter_map(plot_of).collect();
        if plots.len() != report.plots.len() {
            return; // of a version that names other sensors
        }
        let speed: BTreeMap<&str, f64> = report
            .truth
            .iter()
            .map(|t| (t.callsign.as_str(), libm::hypot(t.velocity_mps[0], t.velocity_mps[1])))
            .collect();
        let counts = |p: &PlotMessage| {
            p.kind.radar && speed.get(p.cause.as_str()).is_some_and(|v| *v >= MOVING_MPS)
        };
        let judge =
            |score: &mut Score, took_ns: u64, tracks: &[SystemTrack], outcomes: &[Outcome]| {
                score.took_ns += took_ns;
                score.scans += 1;
                let place = |t: &SystemTrack| [t.position_m.x, t.position_m.y];
                score.tracks = confirmed(tracks).count();
                score.tracks_m = confirmed(tracks).map(place).take(MOST_GHOSTS).collect();
                score.track_scans += tracks.len() as u64;
                let mut sums = Sums { at: to, ..Sums::default() };
                for (plot, outcome) in report.plots.iter().zip(outcomes).filter(|(p, _)| counts(p))
                {
                    let (Some(truth), Outcome::Used { number: Some(_), position_m, .. }) =
                        (plot.truth_m, outcome)
                    else {
                        continue;
                    };
                    sums.track2 += (position_m - truth).norm_squared();
                    sums.plot2 += (plot.position_m - truth).norm_squared();
                    sums.plots += 1;
                }
                score.take(sums);
            };
        // Who comes first brings the plots into the caches: each rung in its turn, so that none pays for all.
        let rungs = self.scores.len();
        let first = self.scores[0].scans as usize;
        for turn in 0..rungs {
            let which = (first + turn) % rungs;
            let began = monotonic_ns();
            let (tracks, outcomes) = match which.checked_sub(1) {
                None => (self.chosen.scan(to, &plots, flights), self.chosen.outcomes()),
                Some(at) => {
                    let shadow = &mut self.shadows[at];
                    (shadow.scan(to, &plots, flights), shadow.outcomes())
                }
            };
            let took_ns = monotonic_ns() - began;
            judge(&mut self.scores[which], took_ns, &tracks, outcomes);
        }
        self.judge_cost(to.since_s(since));
    }

    /// Goes on with the neighbours alone where all rungs take more than their share of a core.
    fn judge_cost(&mut self, simulated_s: f64) {
        let scans = self.scores[0].scans;
        let took_s = self.scores.iter().map(|s| s.took_ns).sum::<u64>() as f64 * 1e-9;
        if self.paced && !self.few && scans >= JUDGED_AFTER && took_s > SHARE * simulated_s {
            let mut around = Shadows::around(&self.config);
            let ghost = self.ghost;
            *self = Self::of(&self.config, around.rungs().to_vec(), true);
            self.ghost = ghost.filter(|g| self.shadows.iter().any(|s| s.rung() == *g));
        }
    }

    /// The rungs, cheapest first.
    #[must_use]
    pub fn rows(&self) -> Vec<RungRow> {
        let since_s = self.since.map_or(0.0, SimTime::s);
        let mut rows: Vec<_> = self
            .rungs()
            .zip(&self.scores)
            .enumerate()
            .map(|(at, (rung, score))| (rung, score.row(rung, at == 0, since_s)))
            .collect();
        rows.sort_by_key(|(rung, _)| *rung);
        rows.into_iter().map(|(_, row)| row).collect()
    }
}

fn confirmed(tracks: &[SystemTrack]) -> impl Iterator<Item = &SystemTrack> {
    tracks.iter().filter(|t| t.status == TrackStatus::Confirmed)
}

impl Score {
    fn take(&mut self, sums: Sums) {
        self.all.track2 += sums.track2;
        self.all.plot2 += sums.plot2;
        self.all.plots += sums.plots;
        self.last.push_back(sums);
        while self.last.front().is_some_and(|s| sums.at.0 - s.at.0 >= MINUTE_NS) {
            self.last.pop_front();
        }
    }

    fn row(&self, rung: Rung, chosen: bool, since_s: f64) -> RungRow {
        let rms = |sum: f64, plots: u32| (plots > 0).then(|| (sum / f64::from(plots)).sqrt());
        let now = self.last.back().copied().unwrap_or_default();
        let minute = self.last.iter().fold(Sums::default(), |sum, s| Sums {
            at: s.at,
            track2: sum.track2 + s.track2,
            plot2: sum.plot2 + s.plot2,
            plots: sum.plots + s.plots,
        });
        let took_us = self.took_ns as f64 * 1e-3;
        RungRow {
            rung: rung.name().to_owned(),
            about: rung.declared().about,
            chosen,
            rmse_m: rms(self.all.track2, self.all.plots),
            rmse_now_m: rms(now.track2, now.plots),
            rmse_60s_m: rms(minute.track2, minute.plots),
            plots: self.all.plots,
            raw_rmse_m: rms(self.all.plot2, self.all.plots),
            raw_rmse_60s_m: rms(minute.plot2, minute.plots),
            scan_us: took_us / f64::from(self.scans.max(1)),
            us_per_track: (self.track_scans > 0).then(|| took_us / self.track_scans as f64),
            tracks: self.tracks,
            since_s,
        }
    }
}

/// The plot as the tracker had it, but for the cells of its echo; none of an unknown kind of sensor.
#[must_use]
pub fn plot_of(message: &PlotMessage) -> Option<Plot> {
    let identity = match message.identity.as_str() {
        "" => None,
        // Only who has no call sign reports an address.
        text if message.cause.is_empty() => {
            u32::from_str_radix(text, 16).ok().map(Identity::Address)
        }
        text => Some(Identity::Callsign(Callsign::new(text))),
    };
    let [east, north, along_m2, across_m2] = message.ellipse;
    Some(Plot {
        sensor: SensorId(message.sensor),
        kind: message.kind,
        time: SimTime(message.time_ns),
        sequence: message.sequence,
        position_m: message.position_m,
        axis: Vector2::new(east, north),
        along_m2,
        across_m2,
        altitude_m: message.altitude_m,
        polar: message.polar.map(|[range_m, azimuth_rad, sigma_range_m, sigma_azimuth_rad]| {
            Polar { range_m, azimuth_rad, sigma_range_m, sigma_azimuth_rad, extent_m2: None }
        }),
        identity,
        scnr_db: message.scnr_db,
    })
}
