//! Starts federates as processes of this host, relays the summary, and ends them all.

use super::agent::client::Agent;
use crate::runtime::cli::{CommonArgs, FAILED};
use crate::runtime::clock::monotonic_ns;
use crate::runtime::process::{self, COMMAND_LINE, LAUNCHED, command_line};
use anyhow::Context;
use crossbeam_channel::{Receiver, Sender, unbounded};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::CommandExt;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::Arc;
use std::time::Duration;

/// What a launched process tells the launcher.
pub enum News {
    /// A line on its standard output.
    Line(String),
    /// It ended: name, exit code (negative: ended by that signal).
    Ended(String, i32),
    /// Ctrl-C at the launcher.
    Interrupted,
}

/// The processes of one federation: on this host, and through agents on others.
pub struct Launched {
    children: Vec<Started>,
    /// What each was started with, and when the latest of that name was.
    arguments: BTreeMap<String, (Vec<String>, Vec<u64>)>,
    /// Who runs on another host, by name.
    elsewhere: BTreeMap<String, Arc<Agent>>,
    news: (Sender<News>, Receiver<News>),
}

struct Started {
    name: String,
    /// None of a process on another host.
    pid: Option<u32>,
    /// Its standard input, where it listens to its launcher.
    input: Option<ChildStdin>,
    progress: Progress,
}

/// What a process that is to end has done lately.
#[derive(Default)]
struct Progress {
    work: u64,
    at_ns: u64,
    /// Since when somebody has stopped it (SIGSTOP).
    stopped_ns: Option<u64>,
}

/// A process is started again at most so often in a minute.
pub const STARTS_A_MINUTE: usize = 3;
const MINUTE_NS: u64 = 60_000_000_000;

/// A process that stands stopped for so long is not waited for.
const STOPPED_NS: u64 = 1_000_000_000;
/// Nor one that neither computes nor writes for so long.
const IDLE_NS: u64 = 10_000_000_000;

impl Progress {
    /// Whether the process `pid` is worth waiting for.
    fn goes_on(&mut self, pid: u32, now_ns: u64) -> bool {
        let stopped = process::is_stopped(pid);
        self.stopped_ns = stopped.then(|| self.stopped_ns.unwrap_or(now_ns));
        let work = process::work_of(pid);
        if work != self.work || self.at_ns == 0 {
            (self.work, self.at_ns) = (work, now_ns);
        }
        let stands = self.stopped_ns.is_some_and(|since| now_ns - since >= STOPPED_NS);
        !stands && now_ns - self.at_ns < IDLE_NS
    }
}

impl Default for Launched {
    fn default() -> Self {
        Self {
            children: Vec::new(),
            arguments: BTreeMap::new(),
            elsewhere: BTreeMap::new(),
            news: unbounded(),
        }
    }
}

impl Launched {
    /// Where Ctrl-C is reported.
    #[must_use]
    pub fn sender(&self) -> Sender<News> {
        self.news.0.clone()
    }

    /// What happens.
    #[must_use]
    pub fn news(&self) -> &Receiver<News> {
        &self.news.1
    }

    /// Lets those of `names` run where `agent` is.
    pub fn place(&mut self, names: Vec<String>, agent: Agent) {
        let agent = Arc::new(agent);
        let (watched, tell) = (Arc::clone(&agent), self.news.0.clone());
        std::thread::spawn(move || {
            watched.watch(|name, code| tell.send(News::Ended(name, code)).is_ok());
        });
        self.elsewhere.extend(names.into_iter().map(|name| (name, Arc::clone(&agent))));
    }

    /// Starts this executable again as `name` with the arguments of the subcommand, here or where it belongs.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn start(&mut self, name: &str, arguments: &[String]) -> anyhow::Result<()> {
        let started = self.arguments.entry(name.to_owned()).or_default();
        started.0 = arguments.to_vec();
        started.1.push(monotonic_ns());
        if let Some(agent) = self.elsewhere.get(name) {
            let refused = |why| anyhow::anyhow!("starting {name} at {}: {why}", agent.endpoint());
            agent.start(name, arguments).map_err(refused)?;
            let (input, progress) = (None, Progress::default());
            self.children.push(Started { name: name.to_owned(), pid: None, input, progress });
            return Ok(());
        }
        let listens = name == "admin-station";
        let executable = std::env::current_exe().context("finding this executable")?;
        let mut child = Command::new(&executable)
            .args(arguments)
            .env(LAUNCHED, std::process::id().to_string())
            .env(COMMAND_LINE, command_line())
            .stdin(if listens { Stdio::piped() } else { Stdio::null() })
            .stdout(Stdio::piped())
            // A group of its own: Ctrl-C on the terminal reaches the launcher, which ends the run in order.
            .process_group(0)
            .spawn()
            .with_context(|| format!("starting {name} ({})", executable.display()))?;
        let lines = child.stdout.take();
        self.children.push(Started {
            name: name.to_owned(),
            pid: Some(child.id()),
            input: child.stdin.take(),
            progress: Progress::default(),
        });
        let (tell, called) = (self.news.0.clone(), name.to_owned());
        std::thread::spawn(move || watch(child, lines, &called, &tell));
        Ok(())
    }

    /// Starts a process that ended again, unless that happened too often: whether it was.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn start_again(&mut self, name: &str) -> anyhow::Result<bool> {
        let Some((arguments, starts)) = self.arguments.get_mut(name) else { return Ok(false) };
        let since = monotonic_ns().saturating_sub(MINUTE_NS);
        starts.retain(|at| *at >= since);
        if starts.len() > STARTS_A_MINUTE {
            return Ok(false);
        }
        let arguments = arguments.clone();
        let again = self.start(name, &arguments);
        if let (Err(why), true) = (&again, self.elsewhere.contains_key(name)) {
            // Its host may be back for the next start.
            tracing::warn!("{why:#}");
            let _ = self.news.0.send(News::Ended(name.to_owned(), i32::from(FAILED)));
            return Ok(true);
        }
        again.map(|()| true)
    }

    /// Says a line to the process called `name`, where it listens.
    pub fn tell(&mut self, name: &str, line: &str) {
        let started = self.children.iter_mut().find(|child| child.name == name);
        if let Some(input) = started.and_then(|child| child.input.as_mut()) {
            let _ = writeln!(input, "{line}");
        }
    }

    /// Whether the process called `name` was stopped (SIGSTOP) and stands so since a second.
    pub fn stands(&mut self, name: &str) -> bool {
        let now = monotonic_ns();
        let child = self.children.iter_mut().find(|child| child.name == name);
        child.is_some_and(|child| {
            let Some(pid) = child.pid else { return false };
            child.progress.goes_on(pid, now);
            child.progress.stopped_ns.is_some_and(|since| now - since >= STOPPED_NS)
        })
    }

    /// Kills the process called `name` if it stands stopped, or neither computes nor writes any more. To be called
    /// twice a second when the run is over: one that still writes is waited for.
    pub fn end_if_idle(&mut self, name: &str) {
        let now = monotonic_ns();
        for child in self.children.iter_mut().filter(|child| child.name == name) {
            let Some(pid) = child.pid else { continue };
            if !child.progress.goes_on(pid, now) {
                let _ = kill(Pid::from_raw(pid as i32), Signal::SIGKILL);
            }
        }
    }

    /// Asks the process called `name` to end in order.
    pub fn interrupt(&self, name: &str) {
        self.signal(name, Signal::SIGTERM);
    }

    /// Ends the process called `name` at once.
    pub fn kill(&self, name: &str) {
        self.signal(name, Signal::SIGKILL);
    }

    /// Asks all that still run to end in order.
    pub fn interrupt_all(&self) {
        for name in self.running() {
            self.interrupt(&name);
        }
    }

    fn signal(&self, name: &str, signal: Signal) {
        for child in self.children.iter().filter(|child| child.name == name) {
            match (child.pid, self.elsewhere.get(name)) {
                (Some(pid), _) => drop(kill(Pid::from_raw(pid as i32), signal)),
                (None, Some(agent)) => agent.end(name, signal == Signal::SIGKILL),
                (None, None) => {}
            }
        }
    }

    /// Kills what still runs after `within`, except the process called `except`; to be called when the run is over.
    pub fn end_after(&self, within: Duration, except: &str) {
        let others = self.children.iter().filter(|child| child.name != except);
        let place = |child: &Started| {
            (child.pid, child.name.clone(), self.elsewhere.get(&child.name).cloned())
        };
        let places: Vec<_> = others.map(place).collect();
        std::thread::spawn(move || {
            std::thread::sleep(within);
            for (pid, name, agent) in places {
                match (pid, agent) {
                    (Some(pid), _) => drop(kill(Pid::from_raw(pid as i32), Signal::SIGKILL)),
                    (None, Some(agent)) => agent.end(&name, true),
                    (None, None) => {}
                }
            }
        });
    }

    /// Names of the processes still running.
    #[must_use]
    pub fn running(&self) -> Vec<String> {
        self.children.iter().map(|child| child.name.clone()).collect()
    }

    /// Takes a process off the list.
    pub fn ended(&mut self, name: &str) {
        self.children.retain(|child| child.name != name);
    }

    /// Asks all that still run to end, waits a little, and kills what is left.
    pub fn end_all(&mut self, within: Duration) {
        self.interrupt_all();
        let deadline = monotonic_ns() + within.as_nanos() as u64;
        while !self.children.is_empty() {
            let left = deadline.saturating_sub(monotonic_ns());
            match self.news.1.recv_timeout(Duration::from_nanos(left)) {
                Ok(News::Ended(name, _)) => self.ended(&name),
                Ok(_) => {}
                Err(_) => break,
            }
        }
        for name in self.running() {
            self.signal(&name, Signal::SIGKILL);
        }
    }
}

impl Drop for Launched {
    fn drop(&mut self) {
        if !self.children.is_empty() {
            self.end_all(Duration::from_secs(1));
        }
    }
}

fn watch(
    mut child: Child,
    lines: Option<std::process::ChildStdout>,
    name: &str,
    tell: &Sender<News>,
) {
    if let Some(lines) = lines {
        for line in BufReader::new(lines).lines().map_while(Result::ok) {
            let _ = tell.send(News::Line(line));
        }
    }
    let code = match child.wait() {
        Ok(status) => {
            use std::os::unix::process::ExitStatusExt;
            status.code().unwrap_or_else(|| -status.signal().unwrap_or(0))
        }
        Err(_) => i32::from(FAILED),
    };
    let _ = tell.send(News::Ended(name.to_owned(), code));
}

/// The value of a flag that takes several with commas between; none where there is none.
pub(super) fn listed<T: ToString>(values: &[T]) -> Option<String> {
    let texts: Vec<String> = values.iter().map(ToString::to_string).collect();
    (!texts.is_empty()).then(|| texts.join(","))
}

/// The common arguments as a command line.
#[must_use]
pub fn common_arguments(args: &CommonArgs, endpoint: &str) -> Vec<String> {
    let mut line = vec!["--scene".to_owned(), args.scene.clone()];
    let mut option = |flag: &str, value: Option<String>| {
        if let Some(value) = value {
            line.extend([flag.to_owned(), value]);
        }
    };
    option("--exercise", args.exercise.map(|e| e.to_string()));
    option("--dis", args.network.dis.clone());
    option("--interface", args.network.interface.map(|i| i.to_string()));
    option("--ttl", args.network.ttl.map(|t| t.to_string()));
    option("--dis-from", listed(&args.network.dis_from));
    option("--dis-sites", listed(&args.network.dis_sites));
    option("--sync-connect", Some(endpoint.to_owned()));
    option("--certs", args.network.certs.as_ref().map(|folder| folder.display().to_string()));
    option("--log-format", Some(args.log_format.word().to_owned()));
    if args.network.open {
        line.push("--open".to_owned());
    }
    line
}
