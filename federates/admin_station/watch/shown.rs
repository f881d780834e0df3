//! What the screen of `watch` shows: values out of the station's answers, and what became of them over time. No terminal, no clock.

use crate::runtime::messages::{Answer, Health};
use serde_json::Value;
use std::collections::{BTreeMap, VecDeque};

/// Samples of a curve that are kept: more than any terminal is wide.
const KEPT: usize = 400;
/// Rates are taken over so many answers: a federate tells its figures once a second, as often as they are asked for.
const OVER: usize = 4;

/// Everything on the screen.
#[derive(Clone, Debug, Default)]
pub(super) struct Shown {
    /// Endpoint of the station.
    pub(super) endpoint: String,
    pub(super) run: Run,
    pub(super) rows: Vec<Row>,
    /// What a person should look after, each with who says so.
    pub(super) alarms: Vec<String>,
    pub(super) curves: Curves,
    /// For how many seconds the station has not answered; none while it does.
    pub(super) silent_s: Option<u64>,
    /// The person is asked whether the run is to be stopped.
    pub(super) confirming: bool,
    /// The command that is on its way.
    pub(super) under_way: Option<String>,
    /// What the last command came to: whether it was carried out, and the words.
    pub(super) said: Option<(bool, String)>,
    /// The first row that is shown, where not all fit.
    pub(super) first: usize,
}

/// How the run stands.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Run {
    pub(super) scene: String,
    pub(super) run: u64,
    pub(super) phase: String,
    pub(super) frame: u64,
    pub(super) last_frame: u64,
    pub(super) step_s: f64,
    /// Rate asked for; none: as fast as possible.
    pub(super) rate: Option<f64>,
    pub(super) reached: f64,
}

/// One federate.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Row {
    pub(super) name: String,
    /// How it does; none of the station, which answers.
    pub(super) health: Option<Health>,
    pub(super) heard_ms: Option<u64>,
    /// Frames that it may execute and has not.
    pub(super) queue: Option<u64>,
    /// How far the clock of its host is ahead of the station's, s.
    pub(super) clock_s: Option<f64>,
    pub(super) cpu_pct: Option<f64>,
    pub(super) memory_mb: Option<f64>,
    /// PDUs that did not arrive by themselves.
    pub(super) lost: Option<u64>,
}

/// Figures over time, the newest last.
#[derive(Clone, Debug, Default)]
pub(super) struct Curves {
    /// Frames a second of wall time.
    pub(super) frames_per_s: VecDeque<f64>,
    /// PDUs sent by all federates, a second of wall time.
    pub(super) pdus_per_s: VecDeque<f64>,
    /// Frames by which the slowest member is behind what it may execute.
    pub(super) behind: VecDeque<f64>,
    last: Option<Sample>,
    steps: VecDeque<Step>,
}

#[derive(Clone, Debug)]
struct Sample {
    at_ns: u64,
    run: u64,
    frame: u64,
    sent: BTreeMap<String, u64>,
}

/// From one answer to the next.
#[derive(Clone, Copy, Debug)]
struct Step {
    wall_s: f64,
    frames: u64,
    pdus: u64,
}

impl Shown {
    /// Nothing yet.
    pub(super) fn of(endpoint: &str) -> Self {
        Self { endpoint: endpoint.to_owned(), ..Self::default() }
    }

    /// Takes the station's statistics, which came at `at_ns` of a clock of this process.
    pub(super) fn take(&mut self, at_ns: u64, statistics: &Value) {
        self.run = Run::of(&statistics["state"]);
        self.rows = rows(statistics);
        self.alarms = alarms(statistics);
        self.curves.take(at_ns, statistics, &self.run);
        self.silent_s = None;
    }

    /// Takes what became of a command.
    pub(super) fn answered(&mut self, answer: Result<Answer, String>) {
        self.under_way = None;
        self.said = Some(match answer {
            Ok(answer) => {
                if let Ok(state) = serde_json::to_value(&answer.state) {
                    self.run = Run::of(&state);
                }
                (answer.ok, answer.text)
            }
            Err(why) => (false, why),
        });
    }
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

fn number(value: &Value) -> u64 {
    value.as_u64().unwrap_or(0)
}

impl Run {
    fn of(state: &Value) -> Self {
        Self {
            scene: text(&state["scene"]),
            run: number(&state["run"]),
            phase: text(&state["phase"]),
            frame: number(&state["frame"]),
            last_frame: number(&state["last_frame"]),
            step_s: state["step_ns"].as_f64().unwrap_or(0.0) * 1e-9,
            rate: state["rate"].as_f64().filter(|rate| rate.is_finite()),
            reached: state["achieved_rate"].as_f64().unwrap_or(0.0),
        }
    }
}

/// The members and spectators, then who else tells figures: the station.
fn rows(statistics: &Value) -> Vec<Row> {
    let own = |name: &str, row: Row| {
        let figures = &statistics["federates"][name];
        Row {
            name: name.to_owned(),
            cpu_pct: figures["cpu_pct"].as_f64(),
            memory_mb: figures["rss_bytes"].as_f64().map(|octets| octets / 1e6),
            lost: figures["lost"].as_u64(),
            ..row
        }
    };
    let members = statistics["state"]["members"].as_array().map_or(&[][..], Vec::as_slice);
    let mut rows: Vec<Row> = members
        .iter()
        .map(|member| {
            let word = text(&member["health"]);
            let host = text(&member["host"]);
            let row = Row {
                health: Health::ALL.into_iter().find(|health| health.word() == word),
                heard_ms: member["heard_ms"].as_u64(),
                queue: member["behind"].as_u64(),
                clock_s: statistics["clocks"][&host].as_f64(),
                ..Row::default()
            };
            own(&text(&member["name"]), row)
        })
        .collect();
    let others = statistics["federates"].as_object().into_iter().flatten();
    for (name, _) in others.filter(|(name, _)| !members.iter().any(|m| m["name"] == name[..])) {
        rows.push(own(name, Row::default()));
    }
    rows
}

fn alarms(statistics: &Value) -> Vec<String> {
    let sentences = |value: &Value| -> Vec<String> {
        value.as_array().into_iter().flatten().map(text).collect()
    };
    let mut alarms = sentences(&statistics["state"]["reasons"]);
    for (name, own) in statistics["federates"].as_object().into_iter().flatten() {
        alarms.extend(sentences(&own["alarms"]).into_iter().map(|text| format!("{name}: {text}")));
    }
    alarms
}

impl Curves {
    fn take(&mut self, at_ns: u64, statistics: &Value, run: &Run) {
        let federates = statistics["federates"].as_object();
        let sent: BTreeMap<String, u64> = federates
            .into_iter()
            .flatten()
            .map(|(name, own)| (name.clone(), number(&own["pdus_out"])))
            .collect();
        let members = statistics["state"]["members"].as_array();
        let essential = members.into_iter().flatten().filter(|m| m["essential"] == true);
        let behind = essential.map(|m| number(&m["behind"])).max().unwrap_or(0);
        push(&mut self.behind, behind as f64);
        let sample = Sample { at_ns, run: run.run, frame: run.frame, sent };
        if let Some(last) = self.last.replace(sample.clone()) {
            self.step(&last, &sample);
        }
    }

    fn step(&mut self, last: &Sample, now: &Sample) {
        let wall_s = now.at_ns.saturating_sub(last.at_ns) as f64 * 1e-9;
        if wall_s <= 0.0 {
            return;
        }
        // A run that began again counts from there; so does a federate that was started again.
        let before = if now.run == last.run { last.frame } else { 0 };
        let pdus = now.sent.iter().map(|(name, sent)| {
            let before = last.sent.get(name).copied().unwrap_or(*sent);
            sent.saturating_sub(before)
        });
        let step = Step { wall_s, frames: now.frame.saturating_sub(before), pdus: pdus.sum() };
        self.steps.push_back(step);
        while self.steps.len() > OVER {
            self.steps.pop_front();
        }
        let wall_s: f64 = self.steps.iter().map(|s| s.wall_s).sum();
        let frames: u64 = self.steps.iter().map(|s| s.frames).sum();
        let pdus: u64 = self.steps.iter().map(|s| s.pdus).sum();
        push(&mut self.frames_per_s, frames as f64 / wall_s);
        push(&mut self.pdus_per_s, pdus as f64 / wall_s);
    }
}

fn push(curve: &mut VecDeque<f64>, value: f64) {
    curve.push_back(value);
    while curve.len() > KEPT {
        curve.pop_front();
    }
}
