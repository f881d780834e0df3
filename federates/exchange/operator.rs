//! Operating a run from outside its processes: a second terminal, the page.

use crate::runtime::bus::{Bus, BusError, ask};
use crate::runtime::codec::{CodecError, decode, encode};
use crate::runtime::messages::{
    Answer, Command, HANDOVER_SEAT, OperatorCommand, SeatAnswer, SeatOrder, seat_key,
};
use std::time::Duration;

/// Why a command got no answer.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The bus failed.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Nobody there.
    #[error(
        "no administration station answered at {0}: is a run going on there? Check --sync-connect and --exercise"
    )]
    Nobody(String),
    /// Another version.
    #[error(transparent)]
    Codec(#[from] CodecError),
}

/// How long a state may take to be reached before the operator is told that it takes longer.
const REACH_WITHIN: Duration = Duration::from_secs(10);
/// How long a station may take to say how the run stands.
const SAY_WITHIN: Duration = Duration::from_secs(1);

/// Whether a letter may be in the name by which a person at a seat, or a client, says who he is.
#[must_use]
pub fn may_name(letter: char) -> bool {
    letter.is_ascii_alphanumeric() || "-_.@ ".contains(letter)
}

/// Sends a command and waits until its state is reached; `source` (`terminal`, `page`) goes into the
/// log of operations. What takes longer than ten seconds goes on, and the answer says so: it is not `ok`.
///
/// # Errors
/// [`ClientError`], one sentence each.
pub fn command(
    bus: &dyn Bus,
    endpoint: &str,
    source: &str,
    command: Command,
) -> Result<Answer, ClientError> {
    command_within(bus, (endpoint, source), command, REACH_WITHIN)
}

fn command_within(
    bus: &dyn Bus,
    (endpoint, source): (&str, &str),
    command: Command,
    within: Duration,
) -> Result<Answer, ClientError> {
    let asked = |command, within| -> Result<Option<Answer>, ClientError> {
        let order = OperatorCommand { source: source.to_owned(), command };
        let answer = ask(bus, "ctl/command", encode(&order), within)?;
        Ok(answer.as_deref().map(decode).transpose()?)
    };
    if let Some(answer) = asked(command, within)? {
        return Ok(answer);
    }
    let stands = asked(Command::Status, SAY_WITHIN)?;
    let stands = stands.ok_or_else(|| ClientError::Nobody(endpoint.to_owned()))?;
    let text = format!("not reached within {} s; it goes on: {}", within.as_secs(), stands.text);
    Ok(Answer { ok: false, text, ..stands })
}

/// Does something at a controller's seat, through the member `visitors`.
///
/// # Errors
/// Why it is not done, in a sentence.
pub fn at_seat(bus: &dyn Bus, order: &SeatOrder) -> Result<SeatAnswer, String> {
    let name: String = order.seat.chars().take(32).collect();
    let sound = |c: char| c.is_ascii_alphanumeric() || c == ' ';
    if name.is_empty() || !name.chars().all(sound) {
        return Err(format!(
            "there is no seat {name:?}: apron, ground, tower with its number, or driver or pilot with what he drives"
        ));
    }
    let asked = |name: &str| ask(bus, &seat_key(name), encode(order), SEAT_WITHIN);
    // Whoever sits at the door says which seats there are.
    let answer = match asked(&name).map_err(|e| e.to_string())? {
        Some(answer) => Some(answer),
        None if name == "ground" => None,
        None => asked("ground").map_err(|e| e.to_string())?,
    };
    let answer = answer.ok_or(
        "nobody lets people in: the member 'visitors' takes no part in this run (leave out --no-visitors, or give --visitors)",
    )?;
    let answer: SeatAnswer = decode(&answer).map_err(|e| e.to_string())?;
    if answer.accepted { Ok(answer) } else { Err(answer.text) }
}

/// Asks for an aircraft to be taken or let go, through the member `visitors`.
///
/// # Errors
/// Why it is not asked, in a sentence.
pub fn hand_over(bus: &dyn Bus, order: &SeatOrder) -> Result<SeatAnswer, String> {
    let answer = ask(bus, &seat_key(HANDOVER_SEAT), encode(order), SEAT_WITHIN)
        .map_err(|e| e.to_string())?
        .ok_or("nobody takes or lets go of aircraft: it needs a [[traffic]] of kind \"handover\" and the member 'visitors' (--visitors)")?;
    let answer: SeatAnswer = decode(&answer).map_err(|e| e.to_string())?;
    if answer.accepted { Ok(answer) } else { Err(answer.text) }
}

/// How long the member `visitors` is asked.
const SEAT_WITHIN: Duration = Duration::from_secs(5);

/// The federation's statistics as JSON.
///
/// # Errors
/// [`ClientError`], one sentence each.
pub fn statistics(bus: &dyn Bus, endpoint: &str) -> Result<serde_json::Value, ClientError> {
    let body = ask(bus, "ctl/statistics", Vec::new(), Duration::from_secs(3))?
        .ok_or_else(|| ClientError::Nobody(endpoint.to_owned()))?;
    serde_json::from_slice(&body).map_err(|_| ClientError::Nobody(endpoint.to_owned()))
}

/// The statistics as a table for a person.
#[must_use]
pub fn table(statistics: &serde_json::Value) -> String {
    use std::fmt::Write;
    let state = &statistics["state"];
    let text = |v: &serde_json::Value| v.as_str().unwrap_or("").to_owned();
    let number = |v: &serde_json::Value| v.as_f64().unwrap_or(0.0);
    let mut out = format!(
        "{}  run {}  {}  frame {} of {}  {:.1} s of {:.1} s  rate {}x (achieved {:.1}x)  seed {}\n",
        text(&state["scene"]),
        state["run"],
        text(&state["phase"]),
        state["frame"],
        state["last_frame"],
        number(&state["frame"]) * number(&state["step_ns"]) * 1e-9,
        number(&state["last_frame"]) * number(&state["step_ns"]) * 1e-9,
        state["rate"].as_f64().map_or_else(|| "fast ".to_owned(), |r| r.to_string()),
        number(&state["achieved_rate"]),
        state["seed"],
    );
    for reason in state["reasons"].as_array().into_iter().flatten() {
        let _ = writeln!(out, "! {}", text(reason));
    }
    let _ = writeln!(
        out,
        "\n{:<22}{:>11}{:>11}{:>8}{:>12}",
        "federate", "health", "heard ms", "behind", "latency us"
    );
    for member in state["members"].as_array().into_iter().flatten() {
        let heard_ms =
            member["heard_ms"].as_u64().map_or_else(|| "-".to_owned(), |n| n.to_string());
        let _ = writeln!(
            out,
            "{:<22}{:>11}{heard_ms:>11}{:>8}{:>12.0}",
            text(&member["name"]),
            text(&member["health"]),
            member["behind"].to_string(),
            number(&member["latency_us"]),
        );
    }
    let _ = writeln!(
        out,
        "\n{:<22}{:>8}{:>9}{:>8}{:>9}{:>9}{:>9}{:>6}{:>9}{:>11}{:>11}",
        "federate",
        "pid",
        "frame",
        "CPU %",
        "CPU s",
        "MB",
        "PDU in",
        "out",
        "lost",
        "repaired",
        "step us"
    );
    for (name, f) in statistics["federates"].as_object().into_iter().flatten() {
        let _ = writeln!(
            out,
            "{name:<22}{:>8}{:>9}{:>8.1}{:>9.1}{:>9.1}{:>9}{:>6}{:>9}{:>11}{:>11.0}",
            f["pid"].to_string(),
            f["frame"].to_string(),
            number(&f["cpu_pct"]),
            number(&f["cpu_s"]),
            number(&f["rss_bytes"]) / 1e6,
            f["pdus_in"].to_string(),
            f["pdus_out"].to_string(),
            f["lost"].to_string(),
            f["repaired"].to_string(),
            number(&f["exec_us"]),
        );
        for alarm in f["alarms"].as_array().into_iter().flatten() {
            let _ = writeln!(out, "! {name} {}", text(alarm));
        }
        for drop in f["dropped"].as_array().into_iter().flatten() {
            let _ = writeln!(out, "  dropped {}: {}", drop[1], text(&drop[0]));
        }
    }
    let _ = writeln!(out);
    // Of sensors and tracker, then of traffic that behaves, where there is any.
    let measures = ["measures", "traffic"].into_iter().filter_map(|of| statistics[of].as_object());
    for (name, value) in measures.flatten() {
        let _ = writeln!(out, "{name:<24}{:>12.3}", number(value));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runtime::bus::Request;
    use crate::runtime::local_bus::LocalHub;
    use crate::runtime::messages::RunState;
    use serde_json::json;
    use std::sync::Mutex;

    /// A station that is there and has not got where it was told to, and none.
    #[test]
    fn a_command_that_takes_long_is_told_from_a_station_that_is_not_there() {
        let hub = LocalHub::default();
        let member = hub.join();
        let give = |within| {
            let whom = ("tcp/127.0.0.1:7447", "terminal");
            command_within(&member, whom, Command::Step { n: 1000 }, within)
        };
        let within = Duration::from_millis(20);
        assert!(matches!(give(within), Err(ClientError::Nobody(_))));
        let station = hub.join();
        let waits = Mutex::new(Vec::new());
        let serve = move |request: Request| {
            let order: OperatorCommand = decode(&request.body).expect("an order");
            if order.command == Command::Status {
                let text = "RUNNING at frame 340 of 18000".to_owned();
                let state = RunState { frame: 340, ..RunState::default() };
                request.answer(encode(&Answer { ok: true, text, state }));
            } else {
                waits.lock().expect("unbroken").push(request);
            }
        };
        station.serve("ctl/command", Box::new(serve)).expect("served");
        let answer = give(within).expect("a station");
        let text = "not reached within 0 s; it goes on: RUNNING at frame 340 of 18000";
        assert_eq!((answer.ok, &answer.text[..], answer.state.frame), (false, text, 340));
    }

    #[test]
    fn the_status_lists_measures_of_tracks_and_then_those_of_the_traffic() {
        let without = json!({"measures": {"pd_asde": 0.98}, "state": {}});
        let mut with = without.clone();
        with["traffic"] = json!({"fuel, kg": 812.5});
        let last = |statistics| table(&statistics).lines().last().map(str::to_owned);
        assert_eq!(last(without).as_deref(), Some("pd_asde                        0.980"));
        assert_eq!(last(with).as_deref(), Some("fuel, kg                     812.500"));
    }
}
