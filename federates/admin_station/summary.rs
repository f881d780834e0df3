//! The JSON line with which a run ends.

use crate::exchange::{ASSOCIATION, TRACKER};
use crate::federation::is_front_end;
use crate::runtime::conductor::ClosedRun;
use crate::runtime::digest::combine;
use crate::runtime::messages::{FAULT, MEASURE};
use serde::Serialize;
use std::collections::BTreeMap;

/// One run in one line; `None` (null) where a figure could not be measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RunSummary {
    /// Scene name (the file's stem).
    pub scene: String,
    /// Seed.
    pub seed: u64,
    /// Frames executed.
    pub frames: u64,
    /// Simulated time, s.
    pub sim_s: f64,
    /// Wall time in phase RUNNING, s.
    pub wall_s: f64,
    /// Simulated seconds per wall second.
    pub rate: f64,
    /// Names of the federates that took part.
    pub federates: Vec<String>,
    /// Ground truth.
    pub truth: TruthSummary,
    /// Plots by sensor kind.
    pub plots: PlotSummary,
    /// System tracks.
    pub tracks: TrackSummary,
    /// Digest of truth, weather, plots and tracks, 16 hexadecimal digits.
    pub digest: String,
    /// Digest of plots and tracks alone.
    pub track_digest: String,
    /// Controllers' seats by name: seconds on the air in a quarter of an hour, share of the busiest minute in which it
    /// worked, longest queue; absent where the plan clears.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub seats: BTreeMap<String, BTreeMap<String, f64>>,
    /// Control alerts that were raised, by kind; absent where nobody looks for any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alerts: Option<BTreeMap<String, u64>>,
    /// Flights that behave; absent where none does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub movements: Option<MovementSummary>,
    /// Measures of traffic that behaves, from truth, by name and unit; absent where none does.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub measures: BTreeMap<String, f64>,
    /// Reports of tracks with a call sign that is not that of the target they follow; absent where no track had any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wrong_labels: Option<u64>,
    /// Clusters that were too large for exact joint association: how many, tracks of the largest, sweeps of belief propagation over all,
    /// their tracks, of how many of these the marginals have bounds, and for how many these make one pair certain; absent where none was.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub association: BTreeMap<String, u64>,
    /// What the tracker did instead of its plain work, or refused: plots that were copies, too late or unsound, starts and
    /// confirmations without room, names on two tracks, labels taken back, what its budget cut; absent where nothing was.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub tracker: BTreeMap<String, u64>,
    /// Faults; empty when all went well.
    pub faults: Vec<String>,
    /// True if a datagram from outside the federation took effect; absent if none did, as what follows.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub external: bool,
    /// Entities of outsiders that were let in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub visitors: Option<u64>,
    /// Plots of somebody else's sensors that went into the tracker; absent where the scene has no such sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub foreign_plots: Option<u64>,
    /// Tracks that took plots of ours and of visitors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub touched: Option<u64>,
    /// Digest of visitors' plots and of tracks from the scan on in which they took one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub foreign: Option<String>,
}

/// Flights that behave in a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct MovementSummary {
    /// Flights that took off or are in block.
    pub served: u64,
    /// Flights that did neither within half an hour of the time at which they were due.
    pub failed: u64,
}

/// Ground truth of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TruthSummary {
    /// Entities.
    pub entities: u64,
    /// PDUs sent by traffic generators and external world.
    pub pdus_sent: u64,
    /// PDUs that arrived at the SMDFM by themselves.
    pub pdus_received: u64,
    /// PDUs that did not.
    pub lost: u64,
    /// PDUs fetched by request.
    pub repaired: u64,
}

/// Plots of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PlotSummary {
    /// Surface movement radar.
    pub asde: u64,
    /// Satellite positioning.
    pub gps: u64,
    /// Differential satellite positioning.
    pub dgps: u64,
    /// Other sensors.
    pub other: u64,
}

/// Tracks of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TrackSummary {
    /// Tracks that were ever confirmed.
    pub confirmed: u64,
    /// Root mean square position error of tracks just after the update by an ASDE plot of a moving target, m.
    pub rmse_m: Option<f64>,
    /// The same of those plots, m.
    pub raw_rmse_m: Option<f64>,
    /// Error of the published (predicted) tracks at publication time, m.
    pub published_rmse_m: Option<f64>,
    /// The same without the first three reports and the last of each stretch of one track on one target, m.
    pub settled_rmse_m: Option<f64>,
    /// Squared errors of these reports over the covariance that they state, mean; 2 where it is right.
    pub settled_nees: Option<f64>,
    /// Error of the same tracks one scan earlier, as the next scan's plots revise them, m.
    pub second_ago_rmse_m: Option<f64>,
    /// The two first figures on straight legs only, m.
    pub straight_rmse_m: Option<f64>,
    /// Raw plots on straight legs, m.
    pub straight_raw_rmse_m: Option<f64>,
    /// Plots of those too far off to be an error of measurement (echoes of a pulse before the last): in no figure.
    pub gross_plots: u64,
    /// Reports more than 60 m from the target that their plots came from: false ones, in no figure.
    pub far_reports: u64,
}

/// Digests of a closed run, 16 hexadecimal digits each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunDigests {
    /// Of truth, weather, plots and tracks.
    pub digest: String,
    /// Of plots and tracks alone.
    pub track_digest: String,
    /// Of what visitors had a part in; none where nothing came from outside.
    pub foreign: Option<String>,
}

impl RunDigests {
    /// From the reports of the members.
    #[must_use]
    pub fn of(run: &ClosedRun) -> Self {
        let sum = |name_starts: &str, key: &str| -> u64 {
            run.reports
                .iter()
                .filter(|r| r.name.starts_with(name_starts))
                .flat_map(|r| &r.digests)
                .filter(|(k, _)| k == key)
                .fold(0, |sum, (_, d)| sum.wrapping_add(*d))
        };
        let (plots, tracks) = (sum("smdfm", "plots"), sum("smdfm", "tracks"));
        let (truth, weather) = (sum("traffic-generator", "pdus"), sum("external-world", "pdus"));
        let mut all = run.reports.iter().flat_map(|r| &r.digests);
        let foreign = all.find(|(key, _)| key == "foreign").map(|(_, digest)| *digest);
        Self {
            digest: format!("{:016x}", combine(&[truth, weather, plots, tracks])),
            track_digest: format!("{:016x}", combine(&[plots, tracks])),
            foreign: foreign.map(|digest| format!("{digest:016x}")),
        }
    }

    /// As facts of a log.
    #[must_use]
    pub fn facts(&self) -> Vec<(String, String)> {
        let own = [("digest", &self.digest), ("track_digest", &self.track_digest)];
        let all = own.into_iter().chain(self.foreign.as_ref().map(|f| ("foreign", f)));
        all.map(|(name, value)| (name.to_owned(), value.clone())).collect()
    }
}

/// What the reports say of seats: "seat ground busiest_minute".
fn seats_of(run: &ClosedRun) -> BTreeMap<String, BTreeMap<String, f64>> {
    let mut seats: BTreeMap<String, BTreeMap<String, f64>> = BTreeMap::new();
    for (key, value) in run.reports.iter().flat_map(|r| &r.values) {
        if let Some((seat, figure)) = key.strip_prefix("seat ").and_then(|k| k.rsplit_once(' ')) {
            seats.entry(seat.to_owned()).or_default().insert(figure.to_owned(), *value);
        }
    }
    seats
}

/// What the member `control` raised, by kind of alert; `None` where there is no such member.
fn alerts_of(run: &ClosedRun) -> Option<BTreeMap<String, u64>> {
    let mut all = run.reports.iter().filter(|r| r.name == "control").peekable();
    all.peek()?;
    let values = all.flat_map(|r| &r.values);
    let kind = |(key, value): &(String, f64)| {
        Some((key.strip_prefix("alerts ")?.to_owned(), *value as u64))
    };
    Some(values.filter_map(kind).collect())
}

/// Measures of the traffic; a value that is not a number is left out.
fn measures_of(run: &ClosedRun) -> BTreeMap<String, f64> {
    let values = run.reports.iter().flat_map(|r| &r.values).filter(|(_, x)| x.is_finite());
    values.filter_map(|(key, x)| Some((key.strip_prefix(MEASURE)?.to_owned(), *x))).collect()
}

/// Counts whose names begin so, by the rest of their names.
fn counts_of(run: &ClosedRun, begin: &str) -> BTreeMap<String, u64> {
    let values = run.reports.iter().flat_map(|r| &r.values);
    values.filter_map(|(k, n)| Some((k.strip_prefix(begin)?.to_owned(), *n as u64))).collect()
}

/// What members found wrong in what is simulated: a ring of movers that wait for each other, with its time.
fn faults_of(run: &ClosedRun) -> Vec<String> {
    let values = run.reports.iter().flat_map(|r| &r.values);
    let fault = |(key, since_s): &(String, f64)| {
        Some(format!("{}, since {since_s:.0} s", key.strip_prefix(FAULT)?))
    };
    values.filter_map(fault).collect()
}

impl RunSummary {
    /// From a closed run; `scene` is the scene's name, `step_ns` the frame length.
    #[must_use]
    pub fn of(run: &ClosedRun, scene: &str, step_ns: i64) -> Self {
        let sum = |key: &str| -> f64 {
            let values = run.reports.iter().flat_map(|r| &r.values);
            values.filter(|(k, _)| k == key).map(|(_, v)| v).sum()
        };
        let one = |key: &str| -> Option<f64> {
            let mut values = run.reports.iter().flat_map(|r| &r.values);
            values.find(|(k, _)| k == key).map(|(_, v)| *v).filter(|v| v.is_finite())
        };
        let of_members = |key: &str| -> u64 {
            let members = run.reports.iter().filter(|r| r.name != "visitors");
            let values = members.flat_map(|r| &r.values).filter(|(k, _)| k == key);
            values.map(|(_, v)| *v).sum::<f64>() as u64
        };
        // Each SMDFM has all of it.
        let received = run.reports.iter().filter(|r| !is_front_end(&r.name));
        let received = received.flat_map(|r| &r.values).filter(|(k, _)| k == "pdus_received");
        let received = received.map(|(_, v)| *v).sum::<f64>() as u64;
        let RunDigests { digest, track_digest, foreign } = RunDigests::of(run);
        let sim_s = (run.frame as f64 * step_ns as f64) / 1e9;
        let wall_s = run.wall_ns as f64 * 1e-9;
        Self {
            scene: scene.to_owned(),
            seed: run.seed,
            frames: run.frame,
            sim_s,
            wall_s,
            rate: if wall_s > 0.0 { sim_s / wall_s } else { 0.0 },
            federates: run.reports.iter().map(|r| r.name.clone()).collect(),
            truth: TruthSummary {
                entities: sum("entities") as u64,
                pdus_sent: of_members("pdus_sent"),
                pdus_received: received,
                lost: sum("pdus_lost") as u64,
                repaired: sum("pdus_repaired") as u64,
            },
            plots: PlotSummary {
                asde: sum("plots_asde") as u64,
                gps: sum("plots_gps") as u64,
                dgps: sum("plots_dgps") as u64,
                other: sum("plots_other") as u64,
            },
            tracks: TrackSummary {
                confirmed: sum("tracks_confirmed") as u64,
                rmse_m: one("rmse_m"),
                raw_rmse_m: one("raw_rmse_m"),
                published_rmse_m: one("published_rmse_m"),
                settled_rmse_m: one("settled_rmse_m"),
                settled_nees: one("settled_nees"),
                second_ago_rmse_m: one("second_ago_rmse_m"),
                straight_rmse_m: one("straight_rmse_m"),
                straight_raw_rmse_m: one("straight_raw_rmse_m"),
                gross_plots: sum("gross_plots") as u64,
                far_reports: sum("far_reports") as u64,
            },
            digest,
            track_digest,
            seats: seats_of(run),
            alerts: alerts_of(run),
            movements: one("movements_served").map(|served| MovementSummary {
                served: served as u64,
                failed: one("movements_failed").unwrap_or(0.0) as u64,
            }),
            measures: measures_of(run),
            wrong_labels: one("labels")
                .filter(|labels| *labels > 0.0)
                .and_then(|_| one("wrong_labels"))
                .map(|n| n as u64),
            association: counts_of(run, ASSOCIATION),
            tracker: counts_of(run, TRACKER),
            faults: [run.reasons.clone(), faults_of(run)].concat(),
            external: foreign.is_some(),
            visitors: foreign.as_ref().map(|_| sum("visitors") as u64),
            foreign_plots: one("foreign_plots").map(|n| n as u64),
            touched: foreign.as_ref().map(|_| sum("touched") as u64),
            foreign,
        }
    }

    /// The line.
    #[must_use]
    pub fn line(&self) -> String {
        serde_json::to_string(self).expect("plain numbers and strings")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runtime::messages::FinalReport;

    #[test]
    fn a_ring_of_movers_that_wait_for_each_other_is_a_fault_of_the_last_line() {
        let report = |name: &str, values: &[(&str, f64)]| FinalReport {
            name: name.into(),
            values: values.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect(),
            ..FinalReport::default()
        };
        let ring = "fault deadlock: SWR1, SWR2 wait for each other";
        let generators = [
            report(
                "traffic-generator-1",
                &[("movements_served", 3.0), (ring, 431.5), ("measure fuel, kg", 812.5)],
            ),
            report("traffic-generator-2", &[("entities", 4.0)]),
        ];
        let mut run = ClosedRun { reports: generators.into(), ..ClosedRun::default() };
        run.reasons = vec!["gateway is lost".into()];
        let summary = RunSummary::of(&run, "zurich", 50_000_000);
        let told = "deadlock: SWR1, SWR2 wait for each other, since 432 s";
        assert_eq!(summary.faults, ["gateway is lost", told]);
        assert!(summary.line().contains(told));
        assert_eq!(summary.measures.get("fuel, kg"), Some(&812.5));
        assert!(!summary.line().contains("association") && !summary.line().contains("tracker"));
        let smdfm = [
            ("association_tracks", 40.0),
            ("association_certain", 31.0),
            ("tracker_too_late", 3.0),
        ];
        run.reports.push(report("smdfm", &smdfm));
        let line = RunSummary::of(&run, "zurich", 50_000_000).line();
        assert!(line.contains(r#""association":{"certain":31,"tracks":40}"#), "{line}");
        assert!(line.contains(r#""tracker":{"too_late":3}"#), "{line}");
        run.reports.truncate(0);
        assert_eq!(RunSummary::of(&run, "zurich", 50_000_000).faults, ["gateway is lost"]);
    }
}
