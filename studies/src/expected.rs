//! What alerts a scene with a failure has to raise, as the `.expect.json` beside it says, held against what was raised.

use crate::watched::{Book, Frames, net_on_tracks, target};
use crate::zurich;
use models::control::scoring::Told;
use models::control::situation::Target;
use models::environment::Weather;
use models::fusion::Tracker;
use models::sensors::{PlotSink, ScanInterval};
use models::time::SimTime;
use models::traffic::core::Shown;
use scenarios::Scene;
use serde::Deserialize;

/// One alert that a failure has to raise.
#[derive(Clone, Debug, Deserialize)]
pub struct Alert {
    /// Word of its kind.
    pub kind: String,
    /// Name of the failure.
    pub failure: String,
    /// Raised at most so long after the failure shows, s.
    pub within_s: f64,
    /// Its subjects, where they are known before.
    pub subjects: Option<Vec<String>>,
    /// One of them.
    pub involves: Option<String>,
}

/// What a scene has to raise; other keys of the file are not read.
#[derive(Clone, Debug, Deserialize)]
pub struct Expected {
    /// These.
    pub expected: Vec<Alert>,
    /// Kinds that may come beside them; every other is one too many.
    pub also: Vec<String>,
}

/// An alert may be raised so long before its failure shows: a scan, s.
const BEFORE_S: f64 = 1.0;

impl Expected {
    /// What is missing, late, of somebody else or too much; nothing where all is as expected.
    #[must_use]
    pub fn complaints(&self, shown: &[Shown], raised: &[Told]) -> Vec<String> {
        let mut out = Vec::new();
        let mut meant = vec![false; raised.len()];
        for alert in &self.expected {
            let Some(failure) = shown.iter().find(|s| s.id == alert.failure) else {
                out.push(format!("failure '{}' does not show", alert.failure));
                continue;
            };
            let of = |told: &Told| {
                let same = alert.subjects.as_ref().is_none_or(|s| *s == told.subjects);
                let in_it = |who: &String| told.subjects.contains(who);
                told.kind == alert.kind && same && alert.involves.as_ref().is_none_or(in_it)
            };
            let window = failure.time_s - BEFORE_S..=failure.time_s + alert.within_s;
            let found = raised.iter().position(|told| of(told) && window.contains(&told.on_s));
            match found {
                Some(found) => meant[found] = true,
                None => out.push(format!(
                    "no {} within {} s of '{}' at {:.1} s",
                    alert.kind, alert.within_s, failure.id, failure.time_s
                )),
            }
        }
        for (told, _) in raised.iter().zip(&meant).filter(|(_, meant)| !**meant) {
            if !self.also.contains(&told.kind) {
                out.push(format!(
                    "{} {} at {:.1} s",
                    told.kind,
                    told.subjects.join(" "),
                    told.on_s
                ));
            }
        }
        out
    }
}

/// So long after it shows a failure may cause an alert, s (assumed: longer than most stay).
const CAUSES_S: f64 = 300.0;

/// The failure that an alert is about: one of its subjects has failed.
#[must_use]
pub fn cause<'a>(shown: &'a [Shown], told: &Told) -> Option<&'a Shown> {
    shown.iter().find(|s| {
        let then = told.on_s - CAUSES_S..=told.end_s;
        told.subjects.contains(&s.callsign) && then.contains(&s.time_s)
    })
}

/// Flies the traffic of a scene, watched by those of its sensors that are named: which failures showed, and what was raised on
/// tracks.
///
/// # Errors
/// One sentence if nothing behaves in the scene, or a sensor cannot be made.
pub fn on_tracks(scene: &Scene, sensors: &[&str]) -> Result<(Vec<Shown>, Vec<Told>), String> {
    let behaving = scene.traffic.behaving.as_ref().ok_or("nothing behaves in this scene")?;
    let seed = scene.run.seed;
    let mut core = behaving.core(&scene.run, seed).ok_or("no truth")?;
    let named = |id| scene.sensors.iter().any(|s| s.id == id && sensors.contains(&&*s.name));
    let mut config = scene.tracking_config();
    config.sensors.retain(|model| named(model.id));
    let mut tracker = Tracker::new(config);
    let mut sensors = zurich::sensors(scene)?;
    sensors.retain(|sensor| named(sensor.id()));
    let mut net = net_on_tracks(scene, scene.control.confirm_scans);
    let mut frames = Frames::of(scene, behaving.first_entity);
    let (mut book, weather) = (Book::default(), Weather::default());
    let per_scan = u64::from(scene.run.frames_per_scan);
    for frame in 1..=scene.run.frames() {
        core.step(frame as i64);
        let now = SimTime(frame as i64 * scene.run.frame.0);
        frames.take(&core, now);
        if !frame.is_multiple_of(per_scan) {
            continue;
        }
        let from = SimTime(now.0 - per_scan as i64 * scene.run.frame.0);
        let interval = ScanInterval { run_seed: seed, scan: frame / per_scan, from, to: now };
        let mut sink = PlotSink::default();
        sensors.iter_mut().for_each(|s| s.scan(&interval, &frames, &weather, &mut sink));
        let tracks = tracker.scan(now, &sink.plots, &scene.flight_list);
        let mut targets: Vec<Target> = tracks.iter().map(|t| target(scene, t)).collect();
        targets.sort_by_key(|t| t.number);
        for (change, alert) in net.scan_targets(&core, now, &targets) {
            book.enter(now, *change, alert);
        }
        frames.clear();
    }
    Ok((core.shown().to_vec(), book.list()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::traffic::core::FailureKind;

    #[test]
    fn what_is_late_of_somebody_else_or_too_much_is_told() {
        let text = r#"{"scenario": "x", "also": ["ROUTE_DEV"], "expected": [
            {"kind": "NOCLR_RWY", "failure": "f", "within_s": 6, "subjects": ["A"], "involves": null, "stage": null},
            {"kind": "RMCA_ARR", "failure": "f", "within_s": 20, "subjects": null, "involves": "B"}]}"#;
        let expected: Expected = serde_json::from_str(text).expect("read");
        let shown = [Shown {
            id: "f".into(),
            callsign: "A".into(),
            kind: FailureKind::PassHold,
            time_s: 100.0,
        }];
        let told = |kind: &str, subjects: &str, on_s: f64| Told {
            kind: kind.into(),
            subjects: subjects.split(' ').map(str::to_owned).collect(),
            on_s,
            end_s: on_s + 5.0,
            nearest_m: None,
        };
        let route = told("ROUTE_DEV", "C", 50.0);
        let right = [told("NOCLR_RWY", "A", 99.5), told("RMCA_ARR", "A B", 119.0), route];
        assert_eq!(expected.complaints(&shown, &right), Vec::<String>::new());
        let wrong =
            [told("NOCLR_RWY", "A", 107.0), told("RMCA_ARR", "A C", 119.0), right[2].clone()];
        assert_eq!(expected.complaints(&shown, &wrong).len(), 4, "two missing, two too many");
        assert_eq!(expected.complaints(&[], &[]).len(), 2);
        assert!(cause(&shown, &right[1]).is_some(), "A failed 19 s before");
        for other in [told("RMCA_ARR", "B C", 119.0), told("RMCA_ARR", "A B", 401.0)] {
            assert!(cause(&shown, &other).is_none(), "{other:?}");
        }
        assert!(cause(&shown, &told("RMCA_ARR", "A B", 90.0)).is_none(), "it ended before");
    }
}
