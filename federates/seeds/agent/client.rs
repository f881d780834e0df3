//! The launcher's end: federates that run on another host, through the agent there.

use super::words::{Answer, Ask, EXERCISE, KEY, Process, What};
use crate::runtime::build;
use crate::runtime::bus::ask;
use crate::runtime::certs::Certs;
use crate::runtime::cli::FAILED;
use crate::runtime::clock::monotonic_ns;
use crate::runtime::codec::{decode, encode};
use crate::runtime::zenoh_bus::{Part, ZenohBus, ZenohConfig};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// How often an agent is asked how its processes do.
const LOOK_EVERY: Duration = Duration::from_millis(300);
/// How long an answer may take, and how often a question is asked again.
const WITHIN: Duration = Duration::from_millis(1_000);
const TRIES: u32 = 3;
/// An agent that has not answered for so long is gone, with all that it started.
const GONE_NS: u64 = 30_000_000_000;

/// An agent as a launcher sees it.
pub struct Agent {
    bus: ZenohBus,
    endpoint: String,
    session: u128,
    /// What was started there, by name.
    started: Mutex<BTreeMap<String, Started>>,
}

/// The latest start of a name.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Started {
    start: u32,
    /// The agent has said that it runs.
    runs: bool,
    /// How often the agent did not know of it since: it is another one then. An answer may be older than the start.
    unknown: u32,
    over: bool,
}

/// So many answers without it are no old ones.
const UNKNOWN: u32 = 3;

impl Agent {
    /// Connects to the agent at `endpoint`.
    ///
    /// # Errors
    /// If none answers there, or it is one of another build.
    pub fn connect(endpoint: &str, certs: Option<Certs>, session: u128) -> Result<Self, String> {
        let config = ZenohConfig {
            part: Part::Peer,
            listen: Vec::new(),
            connect: vec![endpoint.to_owned()],
            exercise: EXERCISE,
            connect_timeout: Duration::from_secs(5),
            certs,
        };
        let (with, or) = match config.certs {
            Some(_) => (
                " --certs DIR",
                ", or one of the two certificates is not of this federation: `seeds certs check DIR`",
            ),
            None => ("", ""),
        };
        let help = |why: &str| {
            format!(
                "no agent answers at {endpoint} ({why}): start one there (seeds agent --listen {endpoint}{with}){or}"
            )
        };
        let bus = ZenohBus::open(&config).map_err(|_| help("5 s tried"))?;
        let started = Mutex::default();
        let agent = Self { bus, endpoint: endpoint.to_owned(), session, started };
        match agent.ask(What::Look) {
            Ok(Answer::Refused(why)) => Err(format!("the agent at {endpoint} refuses: {why}")),
            Ok(_) => Ok(agent),
            Err(e) => Err(help(&e)),
        }
    }

    /// Where it is, for messages.
    #[must_use]
    pub fn endpoint(&self) -> &str {
        &self.endpoint
    }

    fn ask(&self, what: What) -> Result<Answer, String> {
        let build = build::IDENTITY.to_owned();
        let question = encode(&Ask { session: self.session, build, what });
        for _ in 0..TRIES {
            let answer =
                ask(&self.bus, KEY, question.clone(), WITHIN).map_err(|e| e.to_string())?;
            if let Some(octets) = answer {
                return decode(&octets).map_err(|e| e.to_string());
            }
        }
        Err("it does not answer".to_owned())
    }

    /// Starts a federate there; `arguments` are those for this host.
    ///
    /// # Errors
    /// If it does not answer, or refuses.
    pub fn start(&self, name: &str, arguments: &[String]) -> Result<(), String> {
        let start = self.change(name, |of| {
            *of = Started { start: of.start + 1, ..Started::default() };
            of.start
        });
        let arguments = elsewhere(arguments);
        let answer = self.ask(What::Start { start, name: name.to_owned(), arguments });
        let why = match answer {
            Ok(Answer::Refused(why)) | Err(why) => why,
            Ok(_) => {
                self.change(name, |of| of.runs = true);
                return Ok(());
            }
        };
        self.change(name, |of| of.over = true);
        Err(why)
    }

    fn change<R>(&self, name: &str, how: impl FnOnce(&mut Started) -> R) -> R {
        let mut started = self.started.lock().unwrap_or_else(PoisonError::into_inner);
        how(started.entry(name.to_owned()).or_default())
    }

    /// Lets a federate end, in order or at once.
    pub fn end(&self, name: &str, at_once: bool) {
        if let Err(e) = self.ask(What::End { name: name.to_owned(), at_once }) {
            tracing::warn!("{name} at {}: {e}", self.endpoint);
        }
    }

    /// Tells of every process that ends there (its name and exit code), until nobody listens any more (`false`).
    pub fn watch(&self, tell: impl Fn(String, i32) -> bool) {
        let mut answered_at = monotonic_ns();
        loop {
            std::thread::sleep(LOOK_EVERY);
            let gone = match self.ask(What::Look) {
                Ok(Answer::Processes(processes)) => {
                    answered_at = monotonic_ns();
                    let mut started = self.started.lock().unwrap_or_else(PoisonError::into_inner);
                    ended(&mut started, &processes)
                }
                _ if monotonic_ns() - answered_at > GONE_NS => self.all_ended(),
                _ => Vec::new(),
            };
            for (name, code) in gone {
                if !tell(name, code) {
                    return;
                }
            }
        }
    }

    fn all_ended(&self) -> Vec<(String, i32)> {
        let mut started = self.started.lock().unwrap_or_else(PoisonError::into_inner);
        let running = started.iter_mut().filter(|(_, of)| of.runs && !of.over);
        let gone = running.map(|(name, of)| {
            of.over = true;
            (name.clone(), i32::from(FAILED))
        });
        gone.collect()
    }
}

/// Those whose end was not known yet, by what an agent tells. What it does not know its predecessor had started.
fn ended(started: &mut BTreeMap<String, Started>, told: &[Process]) -> Vec<(String, i32)> {
    let mut gone = Vec::new();
    for (name, of) in started.iter_mut().filter(|(_, of)| of.runs && !of.over) {
        let now = told.iter().find(|process| process.name == *name && process.start == of.start);
        of.unknown = if now.is_some() { 0 } else { of.unknown + 1 };
        let code = match now {
            Some(process) => process.ended,
            None => (of.unknown >= UNKNOWN).then_some(i32::from(FAILED)),
        };
        if let Some(code) = code {
            of.over = true;
            gone.push((name.clone(), code));
        }
    }
    gone
}

/// A command line without what is this host's own.
fn elsewhere(arguments: &[String]) -> Vec<String> {
    let mut rest = arguments.iter();
    let mut line = Vec::new();
    while let Some(word) = rest.next() {
        match word.as_str() {
            "--certs" | "--interface" => drop(rest.next()),
            _ => line.push(word.clone()),
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_is_told_once_and_an_agent_that_was_started_again_knows_of_nothing() {
        let runs = |start| Started { start, runs: true, ..Started::default() };
        let mut started = BTreeMap::from([("smdfm".to_owned(), runs(2))]);
        let process = |start, ended| Process { name: "smdfm".into(), start, ended };
        assert_eq!(ended(&mut started, &[process(2, None)]), []);
        // The answer to an older question.
        assert_eq!(ended(&mut started, &[process(1, Some(0))]), []);
        assert_eq!(ended(&mut started, &[process(2, Some(-9))]), [("smdfm".to_owned(), -9)]);
        assert_eq!(ended(&mut started, &[process(2, Some(-9))]), []);
        started.insert("smdfm".to_owned(), runs(3));
        assert_eq!(ended(&mut started, &[]), []);
        assert_eq!(ended(&mut started, &[]), []);
        assert_eq!(ended(&mut started, &[]), [("smdfm".to_owned(), 1)]);
        let starting = Started { start: 1, ..Started::default() };
        started.insert("smdfm".to_owned(), starting);
        for _ in 0..9 {
            assert_eq!(ended(&mut started, &[]), [], "it is not there yet");
        }
    }

    #[test]
    fn certificates_and_interface_are_those_of_the_other_host() {
        let line = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
        let own = "smdfm --scene x --interface 10.0.0.1 --sync-connect tls/a:1 --certs c --explain";
        assert_eq!(elsewhere(&line(own)), line("smdfm --scene x --sync-connect tls/a:1 --explain"));
    }
}
