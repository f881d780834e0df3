//! What is read out of what is said beside the scans: marks of the time line (clearances as they begin to stand, ▲; faults, !), and stands
//! that were given instead of the planned ones.

use super::source::Event;
use crate::exchange::stands::Stands;
use crate::runtime::messages::{FlightNotice, RunState};
use models::frames::Point2;
use serde::Deserialize;
use std::collections::BTreeSet;

/// Finds them in what is said of the traffic and of the run.
#[derive(Debug, Default)]
pub struct Marks {
    /// Clearances that stood when traffic was heard of last: call sign, kind, runway, since when (ms).
    standing: BTreeSet<(String, String, String, i64)>,
    /// The stand that each flight has now.
    stands: Stands,
    /// Faults that stand, without their figures.
    faults: BTreeSet<String>,
}

#[derive(Deserialize)]
struct Traffic {
    #[serde(default)]
    movers: Vec<Mover>,
}

#[derive(Deserialize)]
struct Mover {
    callsign: String,
    #[serde(default)]
    stand: String,
    #[serde(default)]
    cleared: Vec<Cleared>,
}

#[derive(Deserialize)]
struct Cleared {
    kind: String,
    #[serde(default)]
    runway: String,
    since_s: f64,
}

impl Marks {
    /// Clearances of `obs/traffic` (JSON) that did not stand when it was heard last, at the times from which they stand.
    pub fn traffic(&mut self, text: &str) -> Vec<Event> {
        let Ok(traffic) = serde_json::from_str::<Traffic>(text) else { return Vec::new() };
        let key = |callsign: &str, c: Cleared| {
            (callsign.to_owned(), c.kind, c.runway, (c.since_s * 1e3).round() as i64)
        };
        let has = traffic.movers.iter().filter(|m| !m.stand.is_empty());
        has.for_each(|m| self.stands.put(m.callsign.clone(), m.stand.clone()));
        let now: BTreeSet<_> = traffic
            .movers
            .into_iter()
            .flat_map(|m| m.cleared.into_iter().map(move |c| key(&m.callsign, c)))
            .collect();
        let new = now.difference(&self.standing).map(|(callsign, kind, runway, since_ms)| {
            let text = format!("{callsign} {kind} {runway}").trim_end().to_owned();
            event(since_ms * 1_000_000, "clearance", callsign, text)
        });
        let mut events: Vec<Event> = new.collect();
        events.sort_by_key(|e| e.time_ns);
        self.standing = now;
        events
    }

    /// Puts into a flight list the stands that flights have now, as traffic was heard of last; `at_m` knows where a stand is. Whether
    /// anything changed: control or a stand that was not free gave somebody another one than planned.
    pub fn correct(
        &self,
        flights: &mut [FlightNotice],
        at_m: impl Fn(&str) -> Option<Point2<f64>>,
    ) -> bool {
        self.stands.correct(flights, at_m)
    }

    /// Reasons of the run's state that were not there before: members lost, frozen by a fault, degraded. One whose figures alone
    /// change is not told again while it stands.
    pub fn state(&mut self, state: &RunState) -> Vec<Event> {
        let kind = |reason: &str| reason.chars().filter(|c| !c.is_ascii_digit()).collect();
        let time_ns = state.frame as i64 * state.step_ns;
        let new = |reason: &&String| !self.faults.contains(&kind(reason));
        let events = state
            .reasons
            .iter()
            .filter(new)
            .map(|reason| event(time_ns, "fault", "", reason.clone()))
            .collect();
        self.faults = state.reasons.iter().map(|reason| kind(reason)).collect();
        events
    }
}

/// A fault of a mover or of the traffic, as the log marks it at the end.
pub(super) fn fault(time_ns: i64, subject: &str, text: String) -> Event {
    event(time_ns, "fault", subject, text)
}

fn event(time_ns: i64, kind: &str, subject: &str, text: String) -> Event {
    Event { time_ns, kind: kind.to_owned(), subject: subject.to_owned(), text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn said(cleared: &[(&str, &str, &str, f64)]) -> String {
        let mover = |c: &(&str, &str, &str, f64)| {
            json!({"callsign": c.0, "phase": "taxiing",
                "cleared": [{"kind": c.1, "runway": c.2, "since_s": c.3}]})
        };
        let movers: Vec<_> = cleared.iter().map(mover).collect();
        json!({"time_s": 9.0, "movers": movers, "runways": []}).to_string()
    }

    fn told(events: &[Event]) -> Vec<(i64, &str)> {
        events.iter().map(|e| (e.time_ns / 1_000_000, e.text.as_str())).collect()
    }

    #[test]
    fn a_clearance_is_marked_once_at_the_time_from_which_it_stands() {
        let mut marks = Marks::default();
        let first = said(&[("SWR2", "LND", "28", 7.5), ("SWR1", "TAX", "", 5.0)]);
        let events = marks.traffic(&first);
        assert_eq!(told(&events), [(5000, "SWR1 TAX"), (7500, "SWR2 LND 28")]);
        assert!(events.iter().all(|e| e.kind == "clearance" && !e.subject.is_empty()));
        assert!(marks.traffic(&first).is_empty(), "it goes on standing");
        // Cleared again for the same, after it had ended.
        let again = said(&[("SWR2", "LND", "28", 7.5), ("SWR1", "TAX", "", 8.0)]);
        assert_eq!(told(&marks.traffic(&again)), [(8000, "SWR1 TAX")]);
        assert!(marks.traffic("{").is_empty() && marks.traffic("{}").is_empty());
    }

    #[test]
    fn a_flight_list_has_the_stands_that_were_given_instead_of_the_planned_ones() {
        let flight = |callsign: &str, stand: &str| FlightNotice {
            callsign: callsign.into(),
            stand: stand.into(),
            ..crate::viewer_logger::tests::flight()
        };
        let mut flights = [flight("SWR1", "A_14"), flight("SWR2", "B 3"), flight("SWR3", "C 1")];
        let at_m = |name: &str| (name == "B_9").then(|| Point2::new(1.0, 2.0));
        let mut marks = Marks::default();
        assert!(!marks.correct(&mut flights, at_m), "nothing was heard");
        let mover = |callsign: &str, stand: &str| json!({"callsign": callsign, "stand": stand});
        let movers = [mover("SWR1", "A 14"), mover("SWR2", "B_9"), mover("FOLLOW1", "")];
        marks.traffic(&json!({"time_s": 1.0, "movers": movers}).to_string());
        assert!(marks.correct(&mut flights, at_m));
        let stands: Vec<&str> = flights.iter().map(|f| &f.stand[..]).collect();
        assert_eq!(stands, ["A_14", "B_9", "C 1"], "written otherwise is no other stand");
        assert_eq!(flights[1].stand_m, Some(Point2::new(1.0, 2.0)));
        assert!(!marks.correct(&mut flights, at_m), "once");
        // Who is gone keeps what he had; the list may come again as it was planned.
        marks.traffic(&json!({"time_s": 2.0, "movers": []}).to_string());
        flights[1].stand = "B 3".into();
        assert!(marks.correct(&mut flights, at_m));
    }

    #[test]
    fn a_fault_is_marked_when_it_begins_and_again_after_it_was_over() {
        let mut marks = Marks::default();
        let mut state = RunState { frame: 100, step_ns: 50_000_000, ..RunState::default() };
        assert!(marks.state(&state).is_empty());
        state.reasons = vec!["smdfm is silent since 2 s".into()];
        assert_eq!(told(&marks.state(&state)), [(5000, "smdfm is silent since 2 s")]);
        state.reasons = vec!["smdfm is silent since 3 s".into(), "gateway is lost".into()];
        assert_eq!(told(&marks.state(&state)), [(5000, "gateway is lost")]);
        state.reasons.clear();
        assert!(marks.state(&state).is_empty());
        state.reasons = vec!["smdfm is silent since 2 s".into()];
        assert_eq!(marks.state(&state).len(), 1);
    }
}
