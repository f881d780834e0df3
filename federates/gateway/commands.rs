//! Commands of clients: read, carried out by whoever may, answered.

use super::public::CommandAnswered;
use crate::runtime::messages::{Command, RunState};
use serde::Deserialize;
use serde_json::Value;
use std::sync::Arc;

/// Octets of the longest command.
pub const LONGEST: usize = 64 << 10;

/// Whether a command was carried out, a sentence, and the state reached.
pub type Outcome = (bool, String, Option<RunState>);

/// Carries a command out (source, command) and waits for its answer.
pub type Operate = Arc<dyn Fn(&str, Command) -> Outcome + Send + Sync>;

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

const NAMES: [&str; 8] = ["freeze", "start", "resume", "stop", "restart", "step", "rate", "status"];
/// Frames of the longest step.
const LONGEST_STEP: u64 = 1_000_000;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    command: String,
    n: Option<u64>,
    rate: Option<f64>,
    client: Option<String>,
}

/// What a command's JSON asks for, and who says that he asks.
///
/// # Errors
/// What is wrong with it, and what would do.
pub fn read(octets: &[u8]) -> Result<(Command, String), String> {
    if octets.len() > LONGEST {
        return Err(format!("{} octets; a command has at most {LONGEST}", octets.len()));
    }
    let asked: Asked = serde_json::from_slice(octets).map_err(|e| {
        format!(r#"not a command: {e}; for example {{"command":"step","n":20,"client":"me"}}"#)
    })?;
    let command = match asked.command.as_str() {
        "start" | "resume" => Command::Start,
        "freeze" => Command::Freeze,
        "stop" => Command::Stop,
        "restart" => Command::Restart,
        "status" => Command::Status,
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
    let plain = |c: &char| c.is_ascii_alphanumeric() || "-_.@ ".contains(*c);
    let client: String = asked.client.unwrap_or_default().chars().filter(plain).take(32).collect();
    Ok((command, format!("client:{}", if client.is_empty() { "unnamed" } else { &client })))
}

/// Reads and carries out: what to answer, and the state reached.
#[must_use]
pub fn carry_out(octets: &[u8], rights: &Rights) -> (CommandAnswered, Option<RunState>) {
    let (ok, text, state) = match (read(octets), rights) {
        (Err(why), _) => (false, why, None),
        (Ok((Command::Status, _)), Rights::ReadOnly(_)) => (true, "read only".to_owned(), None),
        (Ok(_), Rights::ReadOnly(why)) => (false, why.clone(), None),
        (Ok((command, source)), Rights::Operate(operate)) => operate(&source, command),
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
            (r#"{"command":"step","n":20}"#, Ok((Command::Step { n: 20 }, "client:unnamed"))),
            (r#"{"command":"step"}"#, Ok((Command::Step { n: 1 }, "client:unnamed"))),
            (r#"{"command":"rate","rate":4}"#, Ok((Command::Rate { rate: 4.0 }, "client:unnamed"))),
            (
                r#"{"command":"rate"}"#,
                Ok((Command::Rate { rate: f64::INFINITY }, "client:unnamed")),
            ),
            (r#"{"command":"freez"}"#, Err("nearest is freeze")),
            (r#"{"command":"step","n":0}"#, Err("1 to 1000000")),
            (r#"{"command":"rate","rate":-1}"#, Err("0.001 to 1000")),
            (r#"{"command":"stop","x":1}"#, Err("unknown field")),
            ("\u{1}\u{6}\0\0\0\u{1}", Err("not a command")),
            ("", Err("not a command")),
        ] {
            match (read(json.as_bytes()), expected) {
                (Ok((command, source)), Ok(wanted)) => {
                    assert_eq!((command, source.as_str()), wanted)
                }
                (Err(why), Err(words)) => assert!(why.contains(words), "{why}"),
                (found, wanted) => panic!("{json}: {found:?}, expected {wanted:?}"),
            }
        }
        assert!(read(&vec![b' '; LONGEST + 1]).is_err());
    }

    #[test]
    fn without_the_right_only_the_state_is_told() {
        let done = Arc::new(Mutex::new(Vec::new()));
        let into = Arc::clone(&done);
        let operate: Operate = Arc::new(move |source, command| {
            into.lock().expect("unbroken").push((source.to_owned(), command));
            (true, "frozen".to_owned(), None)
        });
        let freeze = br#"{"command":"freeze","client":"a"}"#;
        let may_not = Rights::ReadOnly("not today".into());
        let (refused, _) = carry_out(freeze, &may_not);
        assert_eq!((refused.ok, refused.text.as_str()), (false, "not today"));
        assert!(carry_out(br#"{"command":"status"}"#, &may_not).0.ok);
        assert!(carry_out(freeze, &Rights::Operate(operate)).0.ok);
        assert_eq!(*done.lock().expect("unbroken"), [("client:a".to_owned(), Command::Freeze)]);
    }
}
