//! Commands of clients: read, carried out by whoever may, answered.

use super::public::CommandAnswered;
use crate::exchange::handover::{When, Words};
use crate::exchange::operator::may_name;
use crate::runtime::messages::{Command, RunState, SeatAction};
use geodesy::{Geodetic, LocalFrame};
use serde::Deserialize;
use serde_json::Value;
use std::sync::Arc;

/// Octets of the longest command.
pub const LONGEST: usize = 64 << 10;

/// Whether a command was carried out, a sentence, and the state reached.
pub type Outcome = (bool, String, Option<RunState>);

/// Carries out what is asked (source, what) and waits for its answer.
pub type Operate = Arc<dyn Fn(&str, Wish) -> Outcome + Send + Sync>;

/// What a client wants.
#[derive(Clone, Debug, PartialEq)]
pub enum Wish {
    /// Of the run.
    Run(Command),
    /// That this aircraft is taken.
    Give(Box<Given>),
    /// That the flight of this call sign is let go.
    Release(String),
}

/// An aircraft as a client gives it: WGS 84, height above the ellipsoid, velocity east, north and up where it is.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Given {
    callsign: String,
    r#type: String,
    address: Option<String>,
    lat_deg: f64,
    lon_deg: f64,
    height_m: f64,
    vx_ms: f64,
    vy_ms: f64,
    vz_ms: f64,
    #[serde(default)]
    age_s: f64,
    time_s: Option<f64>,
    runway: Option<String>,
    stand: Option<String>,
}

impl Given {
    /// What is asked at the seat of handovers.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn action(&self, frame: &LocalFrame) -> Result<SeatAction, String> {
        let place = Geodetic::from_degrees(self.lat_deg, self.lon_deg, self.height_m);
        let velocity = [self.vx_ms, self.vy_ms, self.vz_ms];
        let sound =
            self.lat_deg.abs() <= 90.0 && self.lon_deg.abs() <= 360.0 && self.age_s.abs() <= 3600.0;
        let nanos = |s: f64| (1e9 * s).round() as i64;
        // What an ask takes on its way is in neither place nor age: the time of the run says it exactly.
        let when = match self.time_s {
            None => When::Age(nanos(self.age_s)),
            Some(s) if (0.0..=1e7).contains(&s) && self.age_s == 0.0 => When::Run(nanos(s)),
            Some(_) => return Err("give: time_s is a time of the run, without age_s".into()),
        };
        let (at_mm, velocity_mmps) = Words::placed(frame, place, velocity)
            .filter(|_| sound)
            .ok_or("give: farther than 100 km from the airport, or above 1000 m/s")?;
        let address = self.address.as_deref().map(|a| u32::from_str_radix(a, 16)).transpose();
        let word = |t: &Option<String>| t.as_ref().map(|t| t.trim().replace(' ', "_"));
        let words = Words {
            designator: self.r#type.clone(),
            address: address.map_err(|_| "address: six hexadecimal digits, like \"4b1805\"")?,
            runway: word(&self.runway).filter(|t| !t.is_empty()),
            stand: word(&self.stand).filter(|t| !t.is_empty()),
            at_mm,
            velocity_mmps,
            when,
        };
        Ok(SeatAction::Give { callsign: self.callsign.clone(), state: words.to_string() })
    }
}

/// Who may command.
#[derive(Clone)]
pub enum Rights {
    /// Clients may, through this.
    Operate(Operate),
    /// Nobody may; why.
    ReadOnly(String),
}

impl std::fmt::Debug for Rights {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Operate(_) => "Operate",
            Self::ReadOnly(_) => "ReadOnly",
        })
    }
}

const NAMES: [&str; 12] = [
    "freeze", "start", "resume", "stop", "restart", "step", "rate", "status", "move", "give",
    "release", "without",
];
/// Frames of the longest step.
const LONGEST_STEP: u64 = 1_000_000;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    command: String,
    n: Option<u64>,
    rate: Option<f64>,
    client: Option<String>,
    callsign: Option<String>,
    name: Option<String>,
    to: Option<String>,
}

/// What a command's JSON asks for, and who says that he asks.
///
/// # Errors
/// What is wrong with it, and what would do.
pub fn read(octets: &[u8]) -> Result<(Wish, String), String> {
    if octets.len() > LONGEST {
        return Err(format!("{} octets; a command has at most {LONGEST}", octets.len()));
    }
    let wrong = |e: serde_json::Error| {
        format!(r#"not a command: {e}; for example {{"command":"step","n":20,"client":"me"}}"#)
    };
    let mut fields: serde_json::Map<String, Value> =
        serde_json::from_slice(octets).map_err(wrong)?;
    if fields.get("command").and_then(Value::as_str) == Some("give") {
        fields.remove("command");
        let client = fields.remove("client").and_then(|c| c.as_str().map(str::to_owned));
        let given = serde_json::from_value(fields.into()).map_err(|e| format!("give: {e}"))?;
        return Ok((Wish::Give(Box::new(given)), source(client)));
    }
    let asked: Asked = serde_json::from_value(fields.into()).map_err(wrong)?;
    if asked.command == "release" {
        let callsign = asked.callsign.ok_or("release: name the callsign of the flight")?;
        return Ok((Wish::Release(callsign), source(asked.client)));
    }
    let command = match asked.command.as_str() {
        "start" | "resume" => Command::Start,
        "freeze" => Command::Freeze,
        "stop" => Command::Stop,
        "restart" => Command::Restart,
        "status" => Command::Status,
        "move" => match (asked.name, asked.to) {
            (Some(name), Some(to)) => Command::Move { name, to },
            _ => return Err("move: give name, whose place, and to, whose process takes it".into()),
        },
        "without" => match asked.name {
            Some(name) => Command::Without { name },
            None => {
                return Err(
                    "without: give name, which lost federate the run goes on without".into()
                );
            }
        },
        "step" => match asked.n.unwrap_or(1) {
            n @ 1..=LONGEST_STEP => Command::Step { n },
            n => return Err(format!("n is {n}; a step has 1 to {LONGEST_STEP} frames")),
        },
        "rate" => match asked.rate.unwrap_or(f64::INFINITY) {
            rate if rate == f64::INFINITY || (0.001..=1000.0).contains(&rate) => {
                Command::Rate { rate }
            }
            rate => {
                return Err(format!(
                    "rate is {rate}; it is 0.001 to 1000, or absent for as fast as possible"
                ));
            }
        },
        other => {
            let near = NAMES.iter().min_by_key(|name| distance(name, other));
            let name: String = other.chars().take(40).collect();
            return Err(format!("no command {name:?}; nearest is {}", near.unwrap_or(&"status")));
        }
    };
    Ok((Wish::Run(command), source(asked.client)))
}

/// Who says that he asks, for the logs.
fn source(client: Option<String>) -> String {
    let client = client.unwrap_or_default();
    let client: String = client.chars().filter(|letter| may_name(*letter)).take(32).collect();
    format!("client:{}", if client.is_empty() { "unnamed" } else { &client })
}

/// Reads and carries out: what to answer, and the state reached.
#[must_use]
pub fn carry_out(octets: &[u8], rights: &Rights) -> (CommandAnswered, Option<RunState>) {
    let (ok, text, state) = match (read(octets), rights) {
        (Err(why), _) => (false, why, None),
        (Ok((Wish::Run(Command::Status), _)), Rights::ReadOnly(_)) => {
            (true, "read only".to_owned(), None)
        }
        (Ok(_), Rights::ReadOnly(why)) => (false, why.clone(), None),
        (Ok((wish, source)), Rights::Operate(operate)) => operate(&source, wish),
    };
    let schema = format!("seeds.answer/{}", super::public::VERSION);
    (CommandAnswered { schema, ok, text }, state)
}

/// The answer with the state reached.
#[must_use]
pub fn answer(answered: &CommandAnswered, state: Option<Value>) -> Value {
    let mut all = serde_json::to_value(answered).unwrap_or_default();
    if let Some(state) = state {
        all["state"] = state;
    }
    all
}

/// Letters to change, add or take away.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().take(40).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut corner = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = corner + usize::from(x != *y);
            corner = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(corner + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn commands_are_read_or_refused_with_a_word() {
        for (json, expected) in [
            (r#"{"command":"freeze"}"#, Ok((Command::Freeze, "client:unnamed"))),
            (r#"{"command":"resume","client":"lab 1\n"}"#, Ok((Command::Start, "client:lab 1"))),
            (
                r#"{"command":"freeze","client":"<me>@lab_1.x"}"#,
                Ok((Command::Freeze, "client:me@lab_1.x")),
            ),
            (r#"{"command":"step","n":20}"#, Ok((Command::Step { n: 20 }, "client:unnamed"))),
            (r#"{"command":"step"}"#, Ok((Command::Step { n: 1 }, "client:unnamed"))),
            (r#"{"command":"rate","rate":4}"#, Ok((Command::Rate { rate: 4.0 }, "client:unnamed"))),
            (
                r#"{"command":"rate"}"#,
                Ok((Command::Rate { rate: f64::INFINITY }, "client:unnamed")),
            ),
            (
                r#"{"command":"move","name":"traffic-generator-2","to":"external-world"}"#,
                Ok((
                    Command::Move {
                        name: "traffic-generator-2".to_owned(),
                        to: "external-world".to_owned(),
                    },
                    "client:unnamed",
                )),
            ),
            (r#"{"command":"move","name":"external-world"}"#, Err("whose process takes it")),
            (r#"{"command":"freez"}"#, Err("nearest is freeze")),
            (r#"{"command":"witout"}"#, Err("nearest is without")),
            (r#"{"command":"step","n":0}"#, Err("1 to 1000000")),
            (r#"{"command":"rate","rate":-1}"#, Err("0.001 to 1000")),
            (r#"{"command":"stop","x":1}"#, Err("unknown field")),
            ("\u{1}\u{6}\0\0\0\u{1}", Err("not a command")),
            ("", Err("not a command")),
        ] {
            match (read(json.as_bytes()), expected) {
                (Ok((wish, source)), Ok((command, from))) => {
                    assert_eq!((wish, source.as_str()), (Wish::Run(command), from))
                }
                (Err(why), Err(words)) => assert!(why.contains(words), "{why}"),
                (found, wanted) => panic!("{json}: {found:?}, expected {wanted:?}"),
            }
        }
        assert!(read(&vec![b' '; LONGEST + 1]).is_err());
        let release = read(br#"{"command":"release","callsign":"SWR1","client":"b"}"#);
        assert_eq!(release, Ok((Wish::Release("SWR1".into()), "client:b".into())));
        let frame = LocalFrame::at(Geodetic::from_degrees(47.0, 8.0, 400.0));
        for (rest, expected) in [
            (
                r#""lat_deg":47,"lon_deg":8,"height_m":900,"vx_ms":0,"vy_ms":70,"vz_ms":-3.5,"address":"4b1805","stand":"A 17","age_s":0.1"#,
                Ok("A320 4b1805 - A_17 0 0 500000 0 70000 -3500 age 100000000"),
            ),
            (
                r#""lat_deg":47,"lon_deg":8,"height_m":900,"vx_ms":0,"vy_ms":70,"vz_ms":-3.5,"time_s":61.25"#,
                Ok("A320 - - - 0 0 500000 0 70000 -3500 run 61250000000"),
            ),
            (
                r#""lat_deg":47,"lon_deg":8,"height_m":900,"vx_ms":0,"vy_ms":70,"vz_ms":0,"time_s":9,"age_s":1"#,
                Err("time of the run"),
            ),
            (
                r#""lat_deg":47,"lon_deg":8,"height_m":900,"vx_ms":0,"vy_ms":70,"vz_ms":0,"time_s":-1"#,
                Err("time of the run"),
            ),
            (
                r#""lat_deg":50,"lon_deg":8,"height_m":900,"vx_ms":0,"vy_ms":70,"vz_ms":0"#,
                Err("100 km"),
            ),
            (
                r#""lat_deg":47,"lon_deg":8,"height_m":900,"vx_ms":0,"vy_ms":70,"vz_ms":0,"address":"zz""#,
                Err("hexadecimal"),
            ),
            (r#""lat_deg":47"#, Err("missing field")),
        ] {
            let json = format!(r#"{{"command":"give","callsign":"BSK1","type":"A320",{rest}}}"#);
            let action = read(json.as_bytes()).and_then(|(wish, _)| match wish {
                Wish::Give(given) => given.action(&frame),
                other => panic!("{other:?}"),
            });
            match (action, expected) {
                (Ok(action), Ok(words)) => assert_eq!(action.said(), ("BSK1", words.into())),
                (Err(why), Err(words)) => assert!(why.contains(words), "{why}"),
                (found, wanted) => panic!("{json}: {found:?}, expected {wanted:?}"),
            }
        }
    }

    #[test]
    fn without_the_right_only_the_state_is_told() {
        let done = Arc::new(Mutex::new(Vec::new()));
        let into = Arc::clone(&done);
        let operate: Operate = Arc::new(move |source, command| {
            into.lock().expect("unbroken").push((source.to_owned(), command));
            (true, "frozen".to_owned(), None)
        });
        let frozen = Wish::Run(Command::Freeze);
        let freeze = br#"{"command":"freeze","client":"a"}"#;
        let may_not = Rights::ReadOnly("not today".into());
        let (refused, _) = carry_out(freeze, &may_not);
        assert_eq!((refused.ok, refused.text.as_str()), (false, "not today"));
        assert!(carry_out(br#"{"command":"status"}"#, &may_not).0.ok);
        assert!(carry_out(freeze, &Rights::Operate(operate)).0.ok);
        assert_eq!(*done.lock().expect("unbroken"), [("client:a".to_owned(), frozen)]);
    }
}
