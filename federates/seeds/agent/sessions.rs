//! What an agent has started, by the launcher that asked for it.

use super::words::{Answer, Ask, Process, What};
use crate::federation::MOST_SMDFMS;
use crate::runtime::build;
use crate::runtime::clock::WallNs;
use crate::seeds::launch::{Launched, News};
use std::collections::BTreeMap;
use std::time::Duration;

/// What agents start: members of a federation. Those write no files and open no page.
const FEDERATES: [&str; 5] =
    ["traffic-generator", "external-world", "smdfm", "control", "visitors"];

/// Flags that a launcher may give them, each with a value or without. What is the host's own (certificates, interface) is the agent's.
const FLAGS: [(&str, bool); 13] = [
    ("--scene", true),
    ("--exercise", true),
    ("--dis", true),
    ("--ttl", true),
    ("--dis-from", true),
    ("--dis-sites", true),
    ("--sync-connect", true),
    ("--log-format", true),
    ("--share", true),
    ("--inject-loss", true),
    ("--inputs", true),
    ("--explain", false),
    ("--open", false),
];

/// Launchers at once.
const SESSIONS: usize = 16;
/// Names of a session: sixteen traffic generators, every SMDFM, and one each of the three others.
const NAMES: usize = 16 + MOST_SMDFMS as usize + 3;
/// A launcher that has not asked for so long is gone, and so is its station: federates give a station up after two minutes.
const GONE_NS: WallNs = 180_000_000_000;
/// A session of which nothing runs any more is forgotten after this.
const OVER_NS: WallNs = 30_000_000_000;
/// How long a federate that is to end may take.
const END_WITHIN: Duration = Duration::from_secs(2);

/// All of them.
pub(super) struct Sessions {
    /// Arguments that every federate gets here.
    own: Vec<String>,
    of: BTreeMap<u128, Session>,
}

#[derive(Default)]
struct Session {
    launched: Launched,
    processes: BTreeMap<String, Process>,
    /// Endpoint of its station.
    station: String,
    asked_at: WallNs,
}

impl Sessions {
    pub(super) fn of(own: Vec<String>) -> Self {
        Self { own, of: BTreeMap::new() }
    }

    /// Does what a launcher asks.
    pub(super) fn answer(&mut self, now: WallNs, ask: Ask) -> Answer {
        if ask.build != build::IDENTITY {
            let (own, other) = (build::IDENTITY, &ask.build);
            return Answer::Refused(format!(
                "it is build {own}, the launcher is {other}: use the same build on all hosts"
            ));
        }
        self.tick(now);
        match ask.what {
            What::Look => {
                let Some(session) = self.of.get_mut(&ask.session) else {
                    return Answer::Processes(Vec::new());
                };
                session.asked_at = now;
                Answer::Processes(session.processes.values().cloned().collect())
            }
            What::End { name, at_once } => {
                if let Some(session) = self.of.get_mut(&ask.session) {
                    session.asked_at = now;
                    if at_once {
                        session.launched.kill(&name);
                    } else {
                        session.launched.interrupt(&name);
                    }
                }
                Answer::Done
            }
            What::Start { start, name, arguments } => {
                match self.start(now, ask.session, start, &name, &arguments) {
                    Ok(()) => Answer::Done,
                    Err(why) => Answer::Refused(why),
                }
            }
        }
    }

    fn start(
        &mut self,
        now: WallNs,
        of: u128,
        start: u32,
        name: &str,
        arguments: &[String],
    ) -> Result<(), String> {
        let station = checked(name, arguments)?;
        // Whoever starts a run at an endpoint has ended the one before.
        for (other, session) in &mut self.of {
            if *other != of && session.station == station && !session.launched.running().is_empty()
            {
                tracing::warn!(
                    "another run begins at {station}: the federates of the one before are ended"
                );
                session.launched.end_all(END_WITHIN);
                session.hear();
            }
        }
        if !self.of.contains_key(&of) && self.of.len() >= SESSIONS {
            return Err(format!("{SESSIONS} runs have federates here: end one first"));
        }
        let session = self.of.entry(of).or_default();
        (session.station, session.asked_at) = (station, now);
        if let Some(process) = session.processes.get(name) {
            if process.start == start {
                return Ok(());
            }
            if process.ended.is_none() {
                return Err(format!("{name} runs here already"));
            }
        } else if session.processes.len() >= NAMES {
            return Err(format!("{NAMES} federates of this run have run here"));
        }
        let line = [arguments, &self.own].concat();
        session.launched.start(name, &line).map_err(|e| format!("{e:#}"))?;
        tracing::info!("{name} is started for the station at {}", session.station);
        let process = Process { name: name.to_owned(), start, ended: None };
        session.processes.insert(name.to_owned(), process);
        Ok(())
    }

    /// Hears of what ended, and forgets whom nobody asks for.
    pub(super) fn tick(&mut self, now: WallNs) {
        for session in self.of.values_mut() {
            session.hear();
            let gone = now.saturating_sub(session.asked_at) > GONE_NS;
            if gone && !session.launched.running().is_empty() {
                tracing::warn!(
                    "nothing was heard of the station at {} for {} s: its federates here are ended",
                    session.station,
                    GONE_NS / 1_000_000_000
                );
                session.launched.end_all(END_WITHIN);
                session.hear();
            }
        }
        self.of.retain(|_, session| {
            let over = now.saturating_sub(session.asked_at) > OVER_NS;
            !over || !session.launched.running().is_empty()
        });
    }

    /// Ends everything.
    pub(super) fn end(&mut self) {
        for session in self.of.values_mut() {
            session.launched.end_all(END_WITHIN);
        }
    }
}

impl Session {
    fn hear(&mut self) {
        while let Ok(news) = self.launched.news().try_recv() {
            if let News::Ended(name, code) = news {
                self.launched.ended(&name);
                let how = if code < 0 {
                    format!("signal {}", -code)
                } else {
                    format!("exit code {code}")
                };
                tracing::info!("{name} ended ({how})");
                if let Some(process) = self.processes.get_mut(&name) {
                    process.ended = Some(code);
                }
            }
        }
        // What was ended by force is not told by the one that did it.
        let running = self.launched.running();
        for process in self.processes.values_mut() {
            if process.ended.is_none() && !running.contains(&process.name) {
                process.ended = Some(-9);
            }
        }
    }
}

/// Whether a launcher may ask for this: the endpoint of its station.
fn checked(name: &str, arguments: &[String]) -> Result<String, String> {
    let number = |c: char| c.is_ascii_digit() || c == '-';
    let federate = name.trim_end_matches(number);
    let (first, mut rest) = match arguments {
        [first, rest @ ..] => (first.as_str(), rest.iter()),
        [] => return Err(format!("{name}: no command line")),
    };
    if !FEDERATES.contains(&federate) || first != federate {
        return Err(format!("an agent starts {}, not '{name}'", FEDERATES.join(", ")));
    }
    let mut station = None;
    while let Some(flag) = rest.next() {
        let valued = FLAGS.iter().find(|(known, _)| known == flag).map(|(_, valued)| *valued);
        let Some(valued) = valued else {
            return Err(format!("an agent takes no '{flag}' for {name}"));
        };
        let value = if valued { rest.next() } else { None };
        if valued && value.is_none_or(|value| value.starts_with("--")) {
            return Err(format!("{name}: {flag} has no value"));
        }
        if flag == "--sync-connect" {
            station = value.cloned();
        }
    }
    station.ok_or_else(|| format!("{name}: no --sync-connect: where is the station?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    /// `seeds run --generators 16 --smdfms 8` was refused three of them.
    #[test]
    fn the_largest_federation_has_room() {
        let names = crate::runtime::access_list::names(16, MOST_SMDFMS);
        let started = |name: &&String| {
            // Sixteen generators are numbered, all of them.
            FEDERATES.iter().any(|f| name.starts_with(f)) && *name != "traffic-generator"
        };
        let needed = names.iter().filter(started).count();
        assert_eq!(needed, NAMES, "{names:?}");
    }

    #[test]
    fn an_agent_starts_members_with_the_flags_of_a_launcher_and_nothing_else() {
        let at = "--sync-connect tls/10.0.0.1:7447";
        for (name, text) in [
            ("smdfm", format!("smdfm --scene zurich {at} --explain --inject-loss 0.1")),
            ("traffic-generator-2", format!("traffic-generator {at} --share 2/2")),
        ] {
            assert_eq!(checked(name, &line(&text)).as_deref(), Ok("tls/10.0.0.1:7447"), "{text}");
        }
        for (name, text, words) in [
            ("smdfm", format!("viewer-logger {at}"), "starts traffic-generator"),
            ("viewer-logger", format!("viewer-logger {at}"), "not 'viewer-logger'"),
            ("run", format!("run {at}"), "not 'run'"),
            ("smdfm", format!("smdfm {at} --record /etc/x"), "takes no '--record'"),
            ("smdfm", format!("smdfm {at} --certs /tmp"), "takes no '--certs'"),
            ("smdfm", format!("smdfm {at} /etc/x"), "takes no '/etc/x'"),
            ("smdfm", "smdfm --sync-connect".to_owned(), "has no value"),
            ("smdfm", "smdfm --sync-connect --open".to_owned(), "has no value"),
            ("smdfm", "smdfm --scene zurich".to_owned(), "no --sync-connect"),
            ("smdfm", String::new(), "no command line"),
        ] {
            let refused = checked(name, &line(&text)).expect_err(&text);
            assert!(refused.contains(words), "{text}: {refused}");
        }
    }

    #[test]
    fn another_build_is_refused_and_the_words_of_no_run_start_nothing() {
        let mut sessions = Sessions::of(Vec::new());
        let ask = |build: &str, what| Ask { session: 1, build: build.to_owned(), what };
        let other = sessions.answer(0, ask("another", What::Look));
        assert!(matches!(other, Answer::Refused(why) if why.contains("same build")));
        let end = What::End { name: "smdfm".into(), at_once: true };
        assert_eq!(sessions.answer(0, ask(build::IDENTITY, end)), Answer::Done);
        let look = sessions.answer(0, ask(build::IDENTITY, What::Look));
        assert_eq!(look, Answer::Processes(Vec::new()));
        let start = What::Start { start: 1, name: "sh".into(), arguments: line("sh -c true") };
        assert!(matches!(sessions.answer(0, ask(build::IDENTITY, start)), Answer::Refused(_)));
        assert!(sessions.of.is_empty(), "who is refused fills no memory");
    }
}
