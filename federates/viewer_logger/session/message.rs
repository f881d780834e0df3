//! Messages of a browser, as they are read.

use crate::runtime::messages::Command;
use serde::Deserialize;

/// What a browser says.
#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum FromPage {
    /// A scan of the past, or the newest.
    Show {
        scan: Option<u64>,
    },
    Select {
        track: Option<u16>,
    },
    Compare {
        on: bool,
        #[serde(default)]
        ghost: Option<String>,
    },
    Tolerances {
        on: bool,
        #[serde(default)]
        ghost_m: Option<f64>,
    },
    Ack {
        id: u32,
    },
    Person {
        person: String,
    },
    Open {
        runs: Vec<String>,
    },
    Strip {
        from_s: f64,
        to_s: f64,
        columns: usize,
    },
    Fork {
        id: u32,
        run: String,
        at_s: f64,
        changes: Vec<(String, String)>,
    },
    /// The fork that is being made is to end.
    Cancel {},
    /// Shown where none is needed; looked at before the session begins where one is.
    Token {
        #[serde(rename = "token")]
        _token: String,
    },
    /// Its number `id`, and `SeatWords`.
    Seat(serde_json::Map<String, serde_json::Value>),
    Command(Operated),
}

/// What an operator asks of the run.
#[derive(Debug, Deserialize)]
pub(super) struct Operated {
    pub(super) id: f64,
    pub(super) command: String,
    frames: Option<u64>,
    rate: Option<f64>,
    /// Of `move`: whose place, and whose process takes it.
    name: Option<String>,
    to: Option<String>,
}

/// The command and its words for the log.
pub(super) fn command_of(asked: &Operated) -> Result<(String, Command), String> {
    let Operated { frames, rate, .. } = *asked;
    let word = asked.command.as_str();
    let command = match word {
        "start" | "resume" => Command::Start,
        "freeze" => Command::Freeze,
        "step" => match frames.unwrap_or(1) {
            n @ 1..=MAX_STEP => return Ok((format!("step {n}"), Command::Step { n })),
            n => return Err(format!("step: {n} frames is outside 1 ..= {MAX_STEP}")),
        },
        "move" => match (&asked.name, &asked.to) {
            (Some(name), Some(to)) => {
                let command = Command::Move { name: name.clone(), to: to.clone() };
                return Ok((format!("move {name} {to}"), command));
            }
            _ => return Err("move: give name, whose place, and to, whose process takes it".into()),
        },
        "stop" => Command::Stop,
        "restart" => Command::Restart,
        "fast" => Command::Rate { rate: f64::INFINITY },
        "rate" => match rate {
            Some(rate) if (MIN_RATE..=MAX_RATE).contains(&rate) => {
                return Ok((format!("rate {rate}"), Command::Rate { rate }));
            }
            Some(rate) => return Err(format!("rate: {rate} is outside {MIN_RATE} ..= {MAX_RATE}")),
            None => return Err("rate: no figure given".to_owned()),
        },
        other => return Err(format!("{other:?} is not a valid command")),
    };
    Ok((word.to_owned(), command))
}

/// Most frames in one step command: an hour of 50 ms frames.
const MAX_STEP: u64 = 72_000;
const MIN_RATE: f64 = 0.01;
const MAX_RATE: f64 = 1000.0;
