//! What is said beside the scans: how traffic that behaves stands, the stop bars, and the alerts, each at every time
//! that can be looked back to.
//!
//! Traffic and lights travel as JSON and are shown as they came ([`Topic`]). Alerts are kept as they were raised,
//! changed and ended, so that the list of any moment can be made of them ([`Said::alerts_at`]).

use super::source::Event;
use crate::runtime::messages::words;
use crate::runtime::messages::{AlertMessage, Operation};
use models::control::alert::{AlertKind, Change, Stage};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// What is kept as it was said.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Topic {
    /// Flights that behave (`obs/traffic`).
    Traffic,
    /// Stop bars (`control/1/lights`).
    Lights,
    /// Controllers' seats (`control/1/positions`).
    Seats,
    /// What people drive (`obs/driven`).
    Driven,
}

impl Topic {
    /// All.
    pub const ALL: [Self; 4] = [Self::Traffic, Self::Lights, Self::Seats, Self::Driven];

    /// Its word in the database and for the page.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Traffic => "traffic",
            Self::Lights => "lights",
            Self::Seats => "seats",
            Self::Driven => "driven",
        }
    }

    /// Whether what is said as of a time is kept, to be looked back to: of what people drive that of whole seconds.
    #[must_use]
    pub fn is_kept(self, time_ns: i64) -> bool {
        self != Self::Driven || time_ns % 1_000_000_000 == 0
    }

    /// How long it holds after it was said, ns: traffic is said every scan, the others when they change.
    #[must_use]
    pub fn holds_ns(self) -> i64 {
        match self {
            Self::Traffic => 10_000_000_000,
            Self::Driven => 2_000_000_000,
            Self::Lights | Self::Seats => i64::MAX,
        }
    }
}

/// Lights of runways of what is said of lights: stop bars by their runway and which of its bars each is, entry lights likewise,
/// take-off hold lights by the end at which they are; and whether each is lit.
#[must_use]
pub fn lights_of(text: &str) -> Vec<(String, &'static str)> {
    #[derive(Deserialize)]
    struct Light {
        runway: String,
        lit: bool,
    }
    #[derive(Deserialize)]
    struct Lights {
        bars: Vec<Light>,
        #[serde(default)]
        entries: Vec<Light>,
        #[serde(default)]
        holds: Vec<Light>,
    }
    let Ok(lights) = serde_json::from_str::<Lights>(text) else { return Vec::new() };
    let state = |light: &Light| if light.lit { "lit" } else { "dark" };
    let mut all = Vec::new();
    for (list, word) in [(&lights.bars, ""), (&lights.entries, "entry ")] {
        let mut of: BTreeMap<&str, u32> = BTreeMap::new();
        for light in list {
            let n = of.entry(&light.runway).or_default();
            *n += 1;
            all.push((format!("{} {word}{n}", light.runway), state(light)));
        }
    }
    all.extend(lights.holds.iter().map(|light| (format!("{} hold", light.runway), state(light))));
    all
}

/// Segments of taxiways that are lit for somebody, of what is said of traffic; `None` where no lamps lead.
#[must_use]
pub fn greens_of(text: &str) -> Option<BTreeSet<u32>> {
    #[derive(Deserialize)]
    struct Led {
        segments: Vec<u32>,
    }
    #[derive(Deserialize)]
    struct Traffic {
        greens: Vec<Led>,
    }
    // Of a scene without lamps the whole is not read.
    let led = text.contains("\"greens\"").then(|| serde_json::from_str::<Traffic>(text).ok());
    led.flatten().map(|t| t.greens.into_iter().flat_map(|g| g.segments).collect())
}

/// An alert over its life.
#[derive(Clone, Debug, PartialEq)]
pub struct AlertRow {
    /// What it is about.
    pub kind: AlertKind,
    /// Call signs, else track numbers, separated by blanks: as they were called last.
    pub subjects: String,
    /// Since when it had which stage, in the order of time.
    pub stages: Vec<(i64, Stage)>,
    /// Ended at, ns.
    pub end_ns: Option<i64>,
    /// Where, m east and north.
    pub place_m: [f64; 2],
    /// Who acknowledged it.
    pub acknowledged: Option<String>,
}

/// An alert as the page lists it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AlertLine<'a> {
    /// Number.
    pub id: u32,
    /// What it is about.
    #[serde(serialize_with = "words::serialize")]
    pub kind: AlertKind,
    /// How grave it is.
    #[serde(serialize_with = "words::serialize")]
    pub stage: Stage,
    /// Who.
    pub subjects: Vec<&'a str>,
    /// Raised at, s.
    pub since_s: f64,
    /// Ended at, s.
    pub end_s: Option<f64>,
    /// Where, m east and north.
    pub place_m: [f64; 2],
    /// Who acknowledged it.
    pub acknowledged: Option<&'a str>,
}

/// Everything that was said, by time. Bounded: of texts and ended alerts the oldest go.
#[derive(Debug, Default)]
pub struct Said {
    texts: BTreeMap<(Topic, i64), Arc<str>>,
    octets: usize,
    alerts: BTreeMap<u32, AlertRow>,
    /// What people did, to be written down by whoever keeps the log.
    done: Vec<Operation>,
}

/// Texts kept, octets.
const MOST_OCTETS: usize = 64 << 20;
/// Alerts kept.
const MOST_ALERTS: usize = 10_000;
/// Alerts that ended, as listed.
const ENDED_SHOWN: usize = 20;
/// What a person did that nobody has written down, at most.
const MOST_DONE: usize = 1000;

#[derive(Deserialize)]
struct When {
    time_s: f64,
}

/// Simulated time of a text, ns; none where it does not say one.
#[must_use]
pub fn time_of(text: &str) -> Option<i64> {
    let when: When = serde_json::from_str(text).ok()?;
    when.time_s.is_finite().then(|| (when.time_s * 1e9).round() as i64)
}

impl Said {
    /// Takes a text in; false if it does not say its time.
    pub fn tell(&mut self, topic: Topic, text: &str) -> bool {
        let Some(time_ns) = time_of(text) else { return false };
        // What is said ten times a second is kept once.
        if let Some((&(_, before_ns), _)) =
            self.texts.range((topic, i64::MIN)..(topic, time_ns)).next_back()
            && !topic.is_kept(before_ns)
            && let Some(before) = self.texts.remove(&(topic, before_ns))
        {
            self.octets -= before.len();
        }
        let text: Arc<str> = text.into();
        self.octets += text.len();
        if let Some(before) = self.texts.insert((topic, time_ns), text) {
            self.octets -= before.len();
        }
        while self.octets > MOST_OCTETS {
            // The oldest of traffic, which is by far the most.
            let Some((_, old)) = self.texts.pop_first() else { break };
            self.octets -= old.len();
        }
        true
    }

    /// The newest text that is not later than a time and still holds then.
    #[must_use]
    pub fn at(&self, topic: Topic, time_ns: i64) -> Option<Arc<str>> {
        let ((_, said_ns), text) =
            self.texts.range((topic, i64::MIN)..=(topic, time_ns)).next_back()?;
        let holds = time_ns == i64::MAX || time_ns.saturating_sub(*said_ns) <= topic.holds_ns();
        holds.then(|| Arc::clone(text))
    }

    /// Takes in what changed of an alert.
    pub fn alert(&mut self, a: &AlertMessage) {
        if a.change == Change::Ended {
            if let Some(row) = self.alerts.get_mut(&a.id) {
                row.end_ns = Some(a.time_ns);
            }
            return;
        }
        self.row(
            a.id,
            AlertRow {
                kind: a.kind,
                subjects: a.subjects.clone(),
                stages: vec![(a.time_ns, a.stage)],
                end_ns: None,
                place_m: a.place_m.into(),
                acknowledged: None,
            },
        );
    }

    /// Puts an alert in, or what is new of it: a stage, a name, its end.
    pub fn row(&mut self, id: u32, new: AlertRow) {
        if let Some(row) = self.alerts.get_mut(&id) {
            row.subjects = new.subjects;
            row.end_ns = new.end_ns.or(row.end_ns);
            for stage in new.stages {
                if row.stages.last().is_none_or(|last| last.1 != stage.1 && last.0 <= stage.0) {
                    row.stages.push(stage);
                }
            }
            return;
        }
        if self.alerts.len() >= MOST_ALERTS {
            self.alerts.pop_first();
        }
        self.alerts.insert(id, new);
    }

    /// Somebody has seen an alert. What is said in answer.
    ///
    /// # Errors
    /// If there is none of that number, or it was acknowledged before.
    pub fn acknowledge(&mut self, id: u32, by: &str, time_ns: i64) -> Result<String, String> {
        let row = self.alerts.get_mut(&id).ok_or(format!("there is no alert {id}"))?;
        if let Some(before) = &row.acknowledged {
            return Err(format!("alert {id} was acknowledged by {before}"));
        }
        row.acknowledged = Some(by.to_owned());
        let text = format!("{} {}", row.kind.word(), row.subjects);
        if self.done.len() < MOST_DONE {
            self.done.push(Operation {
                time_ns,
                source: by.to_owned(),
                command: format!("{ACKNOWLEDGE} {id}"),
                ok: true,
                text: text.clone(),
                ..Operation::default()
            });
        }
        Ok(text)
    }

    /// Takes in what a log says was done.
    pub fn operation(&mut self, o: &Operation) {
        let id = o.command.strip_prefix(ACKNOWLEDGE).and_then(|rest| rest.trim().parse().ok());
        if let Some(row) = id.and_then(|id: u32| self.alerts.get_mut(&id)) {
            row.acknowledged.get_or_insert_with(|| o.source.clone());
        }
    }

    /// What people did since this was asked last.
    pub fn take_done(&mut self) -> Vec<Operation> {
        std::mem::take(&mut self.done)
    }

    /// Alerts that stand at a time, the gravest and newest first, and those that ended before it, the last first.
    #[must_use]
    pub fn alerts_at(&self, time_ns: i64) -> (Vec<AlertLine<'_>>, Vec<AlertLine<'_>>) {
        let (mut open, mut ended) = (Vec::new(), Vec::new());
        for (id, row) in &self.alerts {
            let Some((_, stage)) = row.stages.iter().rev().find(|s| s.0 <= time_ns) else {
                continue;
            };
            let end_ns = row.end_ns.filter(|end| *end <= time_ns);
            let line = AlertLine {
                id: *id,
                kind: row.kind,
                stage: *stage,
                subjects: row.subjects.split(' ').filter(|s| !s.is_empty()).collect(),
                since_s: row.stages.first().map_or(0.0, |s| s.0 as f64 * 1e-9),
                end_s: end_ns.map(|ns| ns as f64 * 1e-9),
                place_m: row.place_m,
                acknowledged: row.acknowledged.as_deref(),
            };
            if end_ns.is_some() { &mut ended } else { &mut open }.push(line);
        }
        open.sort_by(|a, b| b.stage.cmp(&a.stage).then(b.since_s.total_cmp(&a.since_s)));
        ended.sort_by(|a, b| b.end_s.partial_cmp(&a.end_s).unwrap_or(std::cmp::Ordering::Equal));
        ended.truncate(ENDED_SHOWN);
        (open, ended)
    }

    /// What the time line marks of the alerts.
    #[must_use]
    pub fn events(&self) -> Vec<Event> {
        let first = |row: &AlertRow| {
            let (time_ns, stage) = row.stages.first()?;
            Some(alert_event(*time_ns, *stage, row.kind, &row.subjects))
        };
        self.alerts.values().filter_map(first).collect()
    }

    /// Forgets everything but what is to be written down.
    pub fn clear(&mut self) {
        *self = Self { done: std::mem::take(&mut self.done), ..Self::default() };
    }
}

/// An alert as the time line marks it.
#[must_use]
pub fn alert_event(time_ns: i64, stage: Stage, kind: AlertKind, subjects: &str) -> Event {
    Event {
        time_ns,
        kind: "alert".into(),
        subject: subjects.to_owned(),
        text: format!("{} {}: {subjects}", stage.word(), kind.word()),
    }
}

/// Word of the operation by which a person says that an alert was seen.
const ACKNOWLEDGE: &str = "acknowledge";

#[cfg(test)]
mod tests {
    use super::*;
    use models::frames::Point2;

    #[test]
    fn lights_are_named_by_their_runway_and_kind() {
        let text = r#"{"time_s": 1, "bars": [{"runway": "16/34", "lit": true}, {"runway": "16/34", "lit": false}],
            "entries": [{"runway": "16/34", "lit": false}], "holds": [{"runway": "34", "lit": true}]}"#;
        let named: Vec<String> =
            lights_of(text).iter().map(|(id, s)| format!("{id}: {s}")).collect();
        assert_eq!(named, ["16/34 1: lit", "16/34 2: dark", "16/34 entry 1: dark", "34 hold: lit"]);
        assert_eq!(lights_of(r#"{"bars": []}"#), []);
        let led = r#"{"time_s": 1, "greens": [{"callsign": "A", "segments": [7, 8]}, {"segments": [3]}]}"#;
        assert_eq!(greens_of(led), Some([3, 7, 8].into()));
        assert_eq!(greens_of(r#"{"time_s": 1, "movers": []}"#), None);
    }

    fn told(id: u32, change: Change, stage: Stage, s: i64) -> AlertMessage {
        AlertMessage {
            run: 1,
            time_ns: s * 1_000_000_000,
            change,
            id,
            kind: AlertKind::RunwayArrival,
            stage,
            subjects: "CAR1 SWR1".into(),
            since_ns: 0,
            asterix: 9,
            place_m: Point2::new(1.0, 2.0),
            number: 0,
        }
    }

    fn s(time_s: i64) -> i64 {
        time_s * 1_000_000_000
    }

    /// An hour at ten times a second: the newest is there at once, each second can be looked back to, and no more is kept.
    #[test]
    fn of_what_is_driven_each_second_is_kept() {
        let mut said = Said::default();
        for tenth in 0..36_000_i64 {
            let text = format!("{{\"time_s\":{}.{}}}", tenth / 10, tenth % 10);
            assert!(said.tell(Topic::Driven, &text));
            assert_eq!(said.at(Topic::Driven, i64::MAX).as_deref(), Some(text.as_str()));
        }
        assert_eq!(said.texts.len(), 3_601);
        assert_eq!(said.octets, said.texts.values().map(|text| text.len()).sum::<usize>());
        let at = |time_s: i64| said.at(Topic::Driven, s(time_s));
        assert_eq!(at(1234).as_deref(), Some("{\"time_s\":1234.0}"));
        assert_eq!(at(3602), None, "it holds two seconds");
    }

    #[test]
    fn the_list_of_any_moment_is_that_moments_list() {
        let mut said = Said::default();
        for message in [
            told(1, Change::Raised, Stage::Information, 10),
            told(2, Change::Raised, Stage::Alarm, 12),
            told(1, Change::Changed, Stage::Alarm, 15),
            told(3, Change::Raised, Stage::Alarm, 16),
            told(2, Change::Ended, Stage::Alarm, 20),
        ] {
            said.alert(&message);
        }
        let at = |time_ns: i64| {
            let (open, ended) = said.alerts_at(time_ns);
            let line = |a: &AlertLine<'_>| format!("{}{}", a.id, &a.stage.word()[..1]);
            let list =
                |lines: &[AlertLine<'_>]| lines.iter().map(line).collect::<Vec<_>>().join(" ");
            format!("{}|{}", list(&open), list(&ended))
        };
        assert_eq!(at(s(9)), "|");
        assert_eq!(at(s(10)), "1i|");
        assert_eq!(at(s(14)), "2a 1i|", "the graver first");
        assert_eq!(at(s(16)), "3a 2a 1a|", "of one stage the newest first");
        assert_eq!(at(s(20)), "3a 1a|2a", "ended in that very scan");
        assert_eq!(at(s(15)), "2a 1a|", "looked back at, it still stands");
        assert_eq!(at(i64::MAX), "3a 1a|2a");
        assert_eq!(said.events().len(), 3);
    }

    #[test]
    fn an_alert_is_acknowledged_once_and_that_is_written_down() {
        let mut said = Said::default();
        said.alert(&told(7, Change::Raised, Stage::Alarm, 1));
        assert!(said.acknowledge(8, "page", 0).is_err());
        assert_eq!(said.acknowledge(7, "page", s(3)), Ok("RMCA_ARR CAR1 SWR1".into()));
        assert!(said.acknowledge(7, "else", 0).expect_err("twice").contains("by page"));
        let done = said.take_done();
        assert_eq!((done.len(), &done[0].command[..], done[0].time_ns), (1, "acknowledge 7", s(3)));
        assert!(said.take_done().is_empty());
        // Read again out of a log.
        let mut read = Said::default();
        read.alert(&told(7, Change::Raised, Stage::Alarm, 1));
        read.operation(&done[0]);
        assert_eq!(read.alerts_at(s(1)).0[0].acknowledged, Some("page"));
        // A name that comes later, and an end before anything was raised.
        let mut named = told(7, Change::Changed, Stage::Alarm, 4);
        named.subjects = "FOLLOW1 SWR1".into();
        read.alert(&named);
        read.alert(&told(99, Change::Ended, Stage::Alarm, 4));
        assert_eq!(read.alerts_at(s(9)).0[0].subjects, ["FOLLOW1", "SWR1"]);
        assert_eq!(read.alerts_at(s(9)).0[0].since_s, 1.0, "raised once");
    }

    #[test]
    fn a_text_holds_from_its_time_on_and_not_for_ever() {
        let mut said = Said::default();
        assert!(!said.tell(Topic::Traffic, "{}") && !said.tell(Topic::Traffic, "no JSON"));
        for n in [5, 6, 7] {
            assert!(said.tell(Topic::Traffic, &format!("{{\"time_s\": {n}.0}}")));
        }
        assert!(said.tell(Topic::Lights, "{\"time_s\": 2}"));
        let at = |time_s: i64| said.at(Topic::Traffic, s(time_s)).map(|t| t.to_string());
        assert_eq!((at(4), at(6)), (None, Some("{\"time_s\": 6.0}".into())));
        assert!(at(17).is_some() && at(18).is_none(), "nothing was heard for ten seconds");
        assert!(said.at(Topic::Lights, s(100_000)).is_some(), "said when they change");
        assert!(said.at(Topic::Lights, s(1)).is_none());
    }

    #[test]
    fn what_outsiders_can_fill_is_bounded() {
        let mut said = Said::default();
        for id in 0..MOST_ALERTS as u32 + 5 {
            said.alert(&told(id, Change::Raised, Stage::Alarm, i64::from(id)));
        }
        assert_eq!(said.alerts.len(), MOST_ALERTS);
        assert!(said.alerts_at(i64::MAX).0.iter().all(|a| a.id >= 5), "the oldest went");
        let long = "x".repeat(MOST_OCTETS / 4);
        for n in 0..6 {
            said.tell(Topic::Traffic, &format!("{{\"time_s\": {n}, \"text\": \"{long}\"}}"));
        }
        assert!(said.octets <= MOST_OCTETS);
        assert!(said.at(Topic::Traffic, s(5)).is_some() && said.at(Topic::Traffic, s(0)).is_none());
    }
}
