//! What the neighbouring rungs of the filter ladder would give for the running scene, on request.
//!
//! The viewer-logger hears every plot, so it can run other trackers on the same plots without asking the
//! SMDFM for anything: no digest and no pace depends on who watches. The chosen rung runs along from the
//! same scan on, so that all rows have seen the same.

use crate::runtime::clock::monotonic_ns;
use crate::runtime::messages::{PlotMessage, ScanReport};
use models::filter::Rung;
use models::flight_list::FlightList;
use models::frames::Vector2;
use models::fusion::{Outcome, Shadows, Tracker, TrackingConfig};
use models::plot::{Callsign, Identity, Plot, Polar, SensorId};
use models::time::SimTime;
use models::track::TrackStatus;
use serde::Serialize;
use std::collections::BTreeMap;

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
    /// The same plots themselves, m.
    pub raw_rmse_m: Option<f64>,
    /// Mean wall time of a scan (gates, association, update, life of tracks), µs.
    pub scan_us: f64,
    /// Confirmed tracks now.
    pub tracks: usize,
    /// Simulated time since when, s.
    pub since_s: f64,
}

#[derive(Debug, Default)]
struct Score {
    track2: f64,
    plot2: f64,
    plots: u32,
    took_ns: u64,
    scans: u32,
    tracks: usize,
}

/// The chosen tracker again, and its neighbours.
#[derive(Debug)]
pub struct Beside {
    since: Option<SimTime>,
    chosen: (&'static str, Tracker),
    shadows: Shadows,
    scores: Vec<Score>, // chosen first
}

/// Slower targets do not count as moving, m/s; as in the measures of the run.
const MOVING_MPS: f64 = 1.0;

impl Beside {
    /// Trackers that know nothing yet.
    #[must_use]
    pub fn new(config: &TrackingConfig) -> Self {
        let mut shadows = Shadows::around(config);
        let scores = (0..=shadows.rungs().len()).map(|_| Score::default()).collect();
        let chosen = (config.filter.rung.name(), Tracker::new(config.clone()));
        Self { since: None, chosen, shadows, scores }
    }

    /// Runs every rung on the plots of a scan.
    pub fn scan(&mut self, report: &ScanReport, flights: &FlightList) {
        let to = SimTime(report.time_ns);
        self.since.get_or_insert(to);
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
            p.kind == "asde" && speed.get(p.cause.as_str()).is_some_and(|v| *v >= MOVING_MPS)
        };
        let judge = |score: &mut Score, took_ns: u64, tracks: usize, outcomes: &[Outcome]| {
            score.took_ns += took_ns;
            score.scans += 1;
            score.tracks = tracks;
            for (plot, outcome) in report.plots.iter().zip(outcomes).filter(|(p, _)| counts(p)) {
                let (Some([x, y]), Outcome::Used { number: Some(_), position_m, .. }) =
                    (plot.truth_m, outcome)
                else {
                    continue;
                };
                let truth = Vector2::new(x, y);
                score.track2 += (position_m - truth).norm_squared();
                score.plot2 += (Vector2::from(plot.position_m) - truth).norm_squared();
                score.plots += 1;
            }
        };
        let confirmed = |tracks: &[models::track::SystemTrack]| {
            tracks.iter().filter(|t| t.status == TrackStatus::Confirmed).count()
        };
        // Who comes first brings the plots into the caches: each rung in its turn, so that none pays for all.
        let rungs = self.scores.len();
        let first = self.scores[0].scans as usize;
        for turn in 0..rungs {
            let which = (first + turn) % rungs;
            let began = monotonic_ns();
            let (tracks, outcomes) = match which.checked_sub(1) {
                None => (self.chosen.1.scan(to, &plots, flights), self.chosen.1.outcomes()),
                Some(at) => {
                    let shadow = &mut self.shadows.rungs()[at];
                    (shadow.scan(to, &plots, flights), shadow.outcomes())
                }
            };
            let took_ns = monotonic_ns() - began;
            judge(&mut self.scores[which], took_ns, confirmed(&tracks), outcomes);
        }
    }

    /// The rungs, cheapest first.
    pub fn rows(&mut self) -> Vec<RungRow> {
        let since_s = self.since.map_or(0.0, SimTime::s);
        let row = |rung: Rung, name: &str, chosen: bool, score: &Score| {
            let rms = |sum: f64| (score.plots > 0).then(|| (sum / f64::from(score.plots)).sqrt());
            RungRow {
                rung: name.to_owned(),
                about: rung.declared().about,
                chosen,
                rmse_m: rms(score.track2),
                raw_rmse_m: rms(score.plot2),
                scan_us: score.took_ns as f64 * 1e-3 / f64::from(score.scans.max(1)),
                tracks: score.tracks,
                since_s,
            }
        };
        let shadows = self.shadows.rungs();
        let mut rows: Vec<_> = shadows
            .iter()
            .zip(&self.scores[1..])
            .map(|(shadow, score)| (shadow.rung(), row(shadow.rung(), shadow.name(), false, score)))
            .collect();
        let (name, tracker) = &self.chosen;
        let rung = tracker.config().filter.rung;
        rows.push((rung, row(rung, name, true, &self.scores[0])));
        rows.sort_by_key(|(rung, _)| *rung);
        rows.into_iter().map(|(_, row)| row).collect()
    }
}

/// The plot as the tracker had it.
fn plot_of(message: &PlotMessage) -> Option<Plot> {
    let kind = models::plot::SensorKind::of(&message.kind)?;
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
        kind,
        time: SimTime(message.time_ns),
        sequence: message.sequence,
        position_m: message.position_m.into(),
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
