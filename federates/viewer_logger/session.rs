//! One browser: what it was sent, what it looks at, and what it asks for. No I/O here.

mod message;

use super::Viewer;
use super::forks::Wanted;
use super::frame;
use super::said::Topic;
use super::seat_view::SeatView;
use super::source::{Event, Strip};
use crate::runtime::messages::{Command, SeatOrder, SeatWords};
use message::{FromPage, command_of};
use models::time::SimTime;
use serde_json::json;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

/// One browser: what it was sent and what it looks at.
#[derive(Debug, Default)]
pub struct Session {
    /// Runs shown, by their place in the list; the first one tells the time. Empty is the first of the list.
    runs: Vec<usize>,
    seen: u64,
    generation: u64,
    shown: Option<u64>, // a scan of the past; none is the newest
    selected: Option<u16>,
    sent_scan: Option<u64>,
    sent_beside: Vec<Option<Option<u64>>>, // by place among the runs shown: what was sent, none being "no picture"
    sent_list: String,
    sent_said: [Option<Option<Arc<str>>>; Topic::ALL.len()],
    sent_alerts: String,
    explained: Option<(u64, u16)>, // scan and track
    curve_from: u64,
    seat: SeatView,
    sees_else: bool, // since the last poll: from another seat
}

/// A message to the browser.
#[derive(Clone, Debug, PartialEq)]
pub enum Outgoing {
    /// JSON.
    Text(Arc<str>),
    /// A scan, see [`frame`].
    Binary(Vec<u8>),
}

impl Outgoing {
    pub(super) fn json(message: &serde_json::Value) -> Self {
        Self::Text(message.to_string().into())
    }
}

/// What a message from the browser asks for beyond the session itself.
#[derive(Clone, Debug, PartialEq)]
pub enum Asked {
    /// Nothing more: the session changed, poll it.
    Nothing,
    /// A command to the run, with its number and words; answer with [`reply`].
    Command(f64, String, Command),
    /// What the other rungs would give, from now on or no more, and whose tracks as a ghost: [`Viewer::compare`].
    Compare(bool, Option<String>),
    /// What other tolerances would give, from now on or no more, and whose tracks as a ghost, m: [`Viewer::compare_tolerances`].
    Tolerances(bool, Option<f64>),
    /// These runs side by side: [`Session::open`].
    Open(Vec<String>),
    /// The time line of the run shown: [`Session::strip`].
    Strip(f64, f64, usize),
    /// A fork, or none: the one that is being made is cancelled.
    Fork(Option<Wanted>),
    /// An alert was seen: [`Viewer::acknowledge`].
    Acknowledge(u32),
    /// Whose page this is.
    Person(String),
    /// Something at a controller's seat, with its number; answer with [`reply`].
    Seat(f64, SeatOrder),
    /// The message was not understood; send this.
    Refused(Outgoing),
}

impl Session {
    /// Everything that the browser lacks of the only run there is, see [`Self::poll_runs`].
    pub fn poll(&mut self, viewer: &Viewer) -> Vec<Outgoing> {
        self.poll_runs(&[viewer])
    }

    /// Everything that the browser lacks, oldest topic first. Scans that came since the last poll are passed over, the
    /// newest is sent; error curves lose nothing. A run beside the first is shown at the same time, or not at all.
    pub fn poll_runs(&mut self, all: &[&Viewer]) -> Vec<Outgoing> {
        let mut out = Vec::new();
        self.runs.retain(|at| *at < all.len());
        let Some(viewer) = all.get(self.runs.first().copied().unwrap_or(0)) else { return out };
        let source = viewer.source();
        if self.generation != viewer.generation {
            // Who sits somewhere sits there in the new run, too, and sees from there.
            let Self { runs, seat, seen, .. } = std::mem::take(self);
            *self = Self { seen, generation: viewer.generation, runs, seat, ..Self::default() };
            out.push(Outgoing::Text(r#"{"type":"new_run"}"#.into()));
        }
        self.list(all, &mut out);
        // Who sits somewhere else now was not sent all before, or is to see less of it.
        let again = std::mem::take(&mut self.sees_else);
        let mut news: Vec<_> = viewer.topics.iter().collect();
        news.retain(|(word, t)| t.0 > self.seen || (again && !WHOLE.contains(*word)));
        news.sort_by_key(|(_, t)| t.0);
        out.extend(news.into_iter().filter_map(|(word, t)| {
            let told = self.seat.topic(word, &t.1)?;
            Some(Outgoing::Text(told))
        }));
        self.seen = viewer.version;
        let newest = source.range().map(|r| r.1);
        if let Some(scan) = self.shown.or(newest).and_then(|scan| source.nearest(scan))
            && self.sent_scan != Some(scan)
            && let Some(message) = source.message(scan)
        {
            self.sent_scan = Some(scan);
            out.push(Outgoing::Binary(self.seat.frame(message, viewer.air())));
        }
        self.said(viewer, &mut out);
        if !self.seat.is_free() {
            return out; // other runs, effects and errors are for who judges a run, not for who is in it
        }
        self.beside(all, viewer, &mut out);
        if let (Some(number), Some(scan)) = (self.selected, self.sent_scan)
            && self.explained != Some((scan, number))
        {
            self.explained = Some((scan, number));
            let plots = source.effects(number, scan).join(",");
            out.push(Outgoing::Text(
                format!(r#"{{"type":"effects","scan":{scan},"track":{number},"plots":[{plots}]}}"#)
                    .into(),
            ));
        }
        if let (Some(number), Some(newest)) = (self.selected, newest)
            && self.curve_from <= newest
        {
            let points = source.curve(number, self.curve_from, newest);
            let reset = self.curve_from == 0;
            self.curve_from = newest + 1;
            if reset || !points.is_empty() {
                let curve =
                    json!({"type": "curve", "track": number, "reset": reset, "points": points});
                out.push(Outgoing::json(&curve));
            }
        }
        out
    }

    /// Traffic, stop bars and alerts of the time shown, where they are not those that were sent.
    fn said(&mut self, viewer: &Viewer, out: &mut Vec<Outgoing>) {
        let shown = |scan: u64| viewer.source().time_of(viewer.source().nearest(scan)?);
        let time_ns = match self.shown {
            Some(scan) => shown(scan).map_or(0, |t| t.0),
            // Now: what is said of a scan may come before it.
            None if viewer.is_live() => i64::MAX,
            None => viewer.source().times().map_or(0, |t| t.1.0),
        };
        for (topic, sent) in Topic::ALL.into_iter().zip(&mut self.sent_said) {
            let said = viewer.said_at(topic, time_ns);
            if sent.as_ref() != Some(&said) {
                let heard = match topic {
                    Topic::Traffic | Topic::Driven => {
                        said.as_deref().and_then(|said| self.seat.movers(said))
                    }
                    Topic::Lights | Topic::Seats => said.as_deref().map(str::to_owned),
                };
                let (word, text) = (topic.word(), heard.as_deref().unwrap_or("null"));
                if said.is_some() || sent.is_some() {
                    out.push(Outgoing::Text(
                        format!(r#"{{"type":"{word}","state":{text}}}"#).into(),
                    ));
                }
                *sent = Some(said);
            }
        }
        // Alerts are a controller's.
        let alerts = match self.seat.only_aboard() {
            true => NO_ALERTS.to_owned(),
            false => viewer.alerts_at(time_ns).to_string(),
        };
        if alerts != self.sent_alerts && (!self.sent_alerts.is_empty() || alerts.contains("kind")) {
            out.push(Outgoing::Text(alerts.as_str().into()));
            self.sent_alerts = alerts;
        }
    }

    /// The list of runs, where it changed.
    fn list(&mut self, all: &[&Viewer], out: &mut Vec<Outgoing>) {
        let row = |viewer: &&Viewer| {
            let info = viewer.info();
            json!({
                "id": viewer.id(), "title": info.title, "scene": info.scene, "seed": info.seed.to_string(),
                "start_utc_ns": info.start_utc_ns.to_string(), "live": viewer.is_live(), "fork": info.fork,
            })
        };
        let rows: Vec<_> = all.iter().map(row).collect();
        let shown: Vec<&str> = self.shown_runs().iter().map(|at| all[*at].id()).collect();
        let list = json!({"type": "runs", "runs": rows, "shown": shown}).to_string();
        if list != self.sent_list {
            out.push(Outgoing::Text(list.as_str().into()));
            self.sent_list = list;
        }
    }

    /// The scans of the other runs shown, at the time of the first.
    fn beside(&mut self, all: &[&Viewer], first: &Viewer, out: &mut Vec<Outgoing>) {
        let time = self.sent_scan.and_then(|scan| first.source().time_of(scan));
        self.sent_beside.resize(self.runs.len(), None);
        for (at, run) in self.runs.iter().enumerate().skip(1) {
            let other = all[*run];
            let scan = time.and_then(|t| other.source().at(SimTime(t.0 + offset_ns(first, other))));
            if self.sent_beside[at] == Some(scan) {
                continue;
            }
            self.sent_beside[at] = Some(scan);
            match scan.and_then(|scan| other.source().message(scan)) {
                Some(mut message) => {
                    frame::set_run(&mut message, at as u16);
                    out.push(Outgoing::Binary(message));
                }
                None => {
                    let ends = other.source().times();
                    let text = match (time, ends) {
                        (Some(t), Some((_, to))) if t > to => {
                            format!("ended at {:.0} s", to.s())
                        }
                        _ => "no picture at this time".to_owned(),
                    };
                    out.push(Outgoing::json(
                        &json!({"type": "no_picture", "run": at, "id": other.id(), "text": text}),
                    ));
                }
            }
        }
    }

    fn shown_runs(&self) -> Vec<usize> {
        if self.runs.is_empty() { vec![0] } else { self.runs.clone() }
    }

    /// The database of the run that is looked at, where that is a finished one, and the scan of it that was sent last.
    #[must_use]
    pub fn looks_back_at(&self, all: &[&Viewer]) -> Option<(PathBuf, Option<u64>)> {
        let viewer = all.get(self.shown_runs()[0])?;
        Some((viewer.database()?.to_owned(), self.sent_scan))
    }

    /// Shows the runs with these names, the first one with everything that belongs to it.
    ///
    /// # Errors
    /// A name that is not in the list, or too many: what to say.
    pub fn open(&mut self, all: &[&Viewer], ids: &[String]) -> Result<(), String> {
        if ids.is_empty() || ids.len() > MOST_RUNS {
            return Err(format!("open: name 1 to {MOST_RUNS} runs"));
        }
        let mut runs = Vec::new();
        for id in ids {
            let at = all.iter().position(|v| v.id() == id).ok_or_else(|| {
                let known: Vec<&str> = all.iter().map(|v| v.id()).collect();
                let id: String = id.chars().take(64).collect();
                format!("open: there is no run {id:?}; there are {}", known.join(", "))
            })?;
            if !runs.contains(&at) {
                runs.push(at);
            }
        }
        let first = all[runs[0]];
        if let Some(other) = runs.iter().map(|at| all[*at]).find(|v| {
            let (a, b) = (&v.info().airport, &first.info().airport);
            !a.is_empty() && !b.is_empty() && a != b
        }) {
            return Err(format!(
                "open: {} is of {}, not of {}: one map cannot show both",
                other.id(),
                other.info().airport,
                first.info().airport
            ));
        }
        let apart = |v: &&Viewer| match (v.reference_deg(), first.reference_deg()) {
            (Some(a), Some(b)) => a.iter().zip(b).any(|(a, b)| (a - b).abs() > SAME_PLACE_DEG),
            _ => false,
        };
        if let Some(other) = runs.iter().map(|at| all[*at]).find(apart) {
            return Err(format!(
                "open: {} and {} count metres from different places: one map cannot show both (recordings: name their --scene)",
                other.id(),
                first.id()
            ));
        }
        let generation = first.generation;
        let same = self.shown_runs()[0] == runs[0];
        let shown = self.time_in(all, first);
        let before = std::mem::take(self);
        *self = if same {
            Self { runs, sent_beside: Vec::new(), ..before }
        } else {
            Self { runs, generation, shown, seat: before.seat, ..Self::default() }
        };
        Ok(())
    }

    /// The scan of another run at the time that is looked back to, or at the end of it that is nearer; none: the newest is looked at.
    fn time_in(&self, all: &[&Viewer], other: &Viewer) -> Option<u64> {
        let first = all.get(self.shown_runs()[0])?;
        let time = first.source().time_of(first.source().nearest(self.shown?)?)?;
        let (from, to) = other.source().times()?;
        let time = SimTime(time.0 + offset_ns(first, other)).clamp(from, to);
        other.source().at(time).or_else(|| Some(other.source().range()?.1))
    }

    /// The time line of the run shown, in so many columns, with its events.
    #[must_use]
    pub fn strip(&self, all: &[&Viewer], from_s: f64, to_s: f64, columns: usize) -> Vec<Outgoing> {
        let Some(viewer) = all.get(self.shown_runs()[0]) else { return Vec::new() };
        let judged = if self.seat.is_free() { viewer.source().sums() } else { &[] };
        let strip = Strip::of(judged, from_s, to_s, columns);
        let mut message = json!(strip);
        message["type"] = "strip".into();
        let mut events = viewer.events();
        events.retain(|e| (from_s..=to_s).contains(&(e.time_ns as f64 * 1e-9)));
        if !self.seat.is_free() {
            events.retain(|e| e.kind != "swap" && !self.seat.only_aboard());
        }
        let more = events.len().saturating_sub(MOST_EVENTS);
        if more > 0 {
            // First of all what somebody is to look at, then the newest.
            let grave = |e: &Event| ["alert", "fault", "operator"].contains(&e.kind.as_str());
            events.sort_by_key(|e| std::cmp::Reverse((grave(e), e.time_ns)));
            events.truncate(MOST_EVENTS);
            events.sort_by_key(|e| e.time_ns);
        }
        let events = json!({"type": "events", "events": events, "more": more});
        vec![Outgoing::json(&message), Outgoing::json(&events)]
    }

    /// Something was done at a seat, and accepted: from now on this browser gets what is seen from where it sits, see
    /// `seat_view`; what to tell it at once.
    pub fn sits(&mut self, order: &SeatOrder) -> Vec<Outgoing> {
        if self.seat.note(order) { self.sees() } else { Vec::new() }
    }

    /// This browser shows the eye's view: a controller looks out of the window there.
    pub fn looks_out(&mut self) {
        self.seat.looks_out();
    }

    /// Where the person of this browser sits, on any page: all of them see alike. What to tell it at once.
    pub fn is_of(&mut self, seats: BTreeSet<String>) -> Vec<Outgoing> {
        if self.seat.is_of(seats) { self.sees() } else { Vec::new() }
    }

    fn sees(&mut self) -> Vec<Outgoing> {
        self.sent_scan = None;
        self.sent_said = Default::default();
        self.explained = None;
        self.curve_from = 0;
        self.sees_else = true;
        let seats: Vec<&str> = self.seat.seats().collect();
        let mut out = vec![Outgoing::json(&json!({"type": "sees", "seats": seats}))];
        if self.seat.only_aboard() {
            // What was known of them goes.
            for text in [NO_FOREIGN, NO_PLAN, NO_OPERATIONS] {
                out.push(Outgoing::Text(text.into()));
            }
        }
        if let Some(track) = self.selected.filter(|_| !self.seat.is_free()) {
            out.push(Outgoing::json(
                &json!({"type": "curve", "track": track, "reset": true, "points": []}),
            ));
        }
        out
    }

    /// Takes a message of the browser. Anything not understood is refused with its reason, nothing more.
    pub fn on_message(&mut self, text: &str) -> Asked {
        let message: FromPage = match serde_json::from_str(text) {
            Ok(message) => message,
            Err(error) => return Asked::Refused(refused(&error.to_string())),
        };
        match message {
            FromPage::Show { scan } => {
                self.shown = scan;
                self.sent_scan = None;
                Asked::Nothing
            }
            FromPage::Select { track } => {
                self.selected = track;
                self.curve_from = 0;
                Asked::Nothing
            }
            FromPage::Token { .. } => Asked::Nothing,
            FromPage::Compare { on, ghost } => {
                Asked::Compare(on, ghost.map(|g| g.chars().take(32).collect()))
            }
            FromPage::Tolerances { on, ghost_m } => {
                Asked::Tolerances(on, ghost_m.filter(|m| m.is_finite()))
            }
            FromPage::Person { person } => Asked::Person(person),
            FromPage::Ack { id } => Asked::Acknowledge(id),
            FromPage::Open { runs } => Asked::Open(runs),
            FromPage::Fork { changes, .. } if changes.len() > MOST_CHANGES => {
                Asked::Refused(refused(&format!("fork: at most {MOST_CHANGES} changes at once")))
            }
            FromPage::Fork { id, run, at_s, changes } => {
                Asked::Fork(Some(Wanted { id, run, at_s, changes }))
            }
            FromPage::Cancel {} => Asked::Fork(None),
            FromPage::Strip { from_s, to_s, columns } => Asked::Strip(from_s, to_s, columns),
            FromPage::Seat(mut fields) => {
                let Some(id) = fields.remove("id").and_then(|id| id.as_f64()) else {
                    return Asked::Refused(refused("seat: missing field `id`, a number"));
                };
                match SeatWords::of(fields).and_then(SeatWords::read) {
                    Ok(order) => Asked::Seat(id, order),
                    Err(reason) => Asked::Refused(reply(id, "seat", false, &reason)),
                }
            }
            FromPage::Command(asked) => match command_of(&asked) {
                Ok((words, order)) => Asked::Command(asked.id, words, order),
                Err(reason) => Asked::Refused(reply(asked.id, &asked.command, false, &reason)),
            },
        }
    }
}

/// What is added to a time of `first` to have it in `other`: nothing where both play one scene, else by UTC where
/// they overlap.
fn offset_ns(first: &Viewer, other: &Viewer) -> i64 {
    let (a, b) = (first.info(), other.info());
    // A recording without its scene is of none.
    let one_scene = !a.scene_digest.is_empty() && a.scene_digest == b.scene_digest;
    if one_scene || b.fork.is_some() || a.fork.is_some() {
        return 0;
    }
    let offset = a.start_utc_ns.saturating_sub(b.start_utc_ns);
    let overlap = match (first.source().times(), other.source().times()) {
        (Some((f0, f1)), Some((o0, o1))) => f0.0 + offset <= o1.0 && o0.0 <= f1.0 + offset,
        _ => false,
    };
    if overlap { offset } else { 0 }
}

/// The answer to command number `id`.
#[must_use]
pub fn reply(id: f64, command: &str, accepted: bool, text: &str) -> Outgoing {
    Outgoing::json(&json!({
        "type": "reply", "id": id, "command": command, "accepted": accepted, "text": text,
    }))
}

pub(super) fn refused(reason: &str) -> Outgoing {
    Outgoing::json(&json!({"type": "refused", "text": reason}))
}

const NO_ALERTS: &str = r#"{"type":"alerts","open":[],"ended":[]}"#;
const NO_FOREIGN: &str = r#"{"type":"foreign","tracks":[]}"#;
const NO_PLAN: &str = r#"{"type":"plan","rows":[]}"#;
const NO_OPERATIONS: &str = r#"{"type":"operations","operations":[]}"#;
/// Topics that everybody is sent alike.
const WHOLE: [&str; 5] = ["scene", "state", "weather", "flights", "federates"];
/// Runs on one clock, at most.
pub(super) const MOST_RUNS: usize = 8;
/// Reference points that differ by less are one: a metre.
const SAME_PLACE_DEG: f64 = 1e-5;
/// Changes of one fork, at most.
const MOST_CHANGES: usize = 16;
/// Events in one message, at most.
const MOST_EVENTS: usize = 2000;
