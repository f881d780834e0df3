//! `seeds replay FILE`: a recording sent again, as it was, faster, slower, or from any time on.
//!
//! The schedule is [`capture::Player`]'s; here are the clock, the socket and the commands.

use super::dis::RewriteArgs;
use super::link_args::LinkArgs;
use crate::runtime::cli::{BAD_INPUT, fail};
use crate::runtime::clock::{monotonic_ns, utc_ns};
use anyhow::Context;
use capture::tools::json;
use capture::{Pace, Phase, Player, Recording, Rewrite, When};
use clap::{Args, ValueEnum};
use crossbeam_channel::{Receiver, Sender, unbounded};
use pdu::{Body, DisTime};
use std::io::{self, BufRead, IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Send a recording again: at its own pace, faster or slower, from any time, in a loop
#[derive(Args, Clone, Debug)]
pub struct PlayerArgs {
    /// Recording: pcapng, pcap or bare PDUs
    pub file: PathBuf,

    #[command(flatten)]
    pub(crate) link: LinkArgs,

    /// Recorded seconds per second, 0.1 to 100
    #[arg(long, value_name = "X", default_value = "1", value_parser = pace)]
    pub rate: Pace,

    /// As fast as possible
    #[arg(long, conflicts_with = "rate")]
    pub fast: bool,

    /// What the schedule follows; --from, --to and `seek` count by it
    #[arg(long, value_enum, default_value_t = Schedule::Auto)]
    pub schedule: Schedule,

    /// Start here, with the states of all entities alive then: seconds from the start, or UTC (2026-11-20T23:30:00Z) [default: the start]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub from: Option<When>,

    /// End here: seconds from the start, or UTC [default: the end]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub to: Option<When>,

    /// Again and again, until Ctrl-C
    #[arg(long = "loop")]
    pub looping: bool,

    /// Wait for a Start/Resume PDU; Stop/Freeze PDUs then pause
    #[arg(long)]
    pub start_on_resume: bool,

    #[command(flatten)]
    pub(crate) rewrite: RewriteArgs,

    /// Time stamps of the PDUs: as recorded, or of the moment they are sent
    #[arg(long, value_enum, default_value_t = Stamps::Keep)]
    pub stamps: Stamps,

    /// A state that was not told for so long is not sent again when seeking
    #[arg(long, value_name = "S", default_value_t = 12.0, value_parser = super::dis::positive)]
    pub lasting: f64,

    /// Take commands from stdin, one a line: pause, resume, seek TIME, rate X, fast, step, back, quit
    #[arg(long)]
    pub control: bool,

    /// No progress on stderr
    #[arg(long)]
    pub quiet: bool,
}

/// When a datagram is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Schedule {
    /// As it arrived; by the PDUs' time stamps if these tell of more than twice the time (a run as fast as possible)
    Auto,
    /// As it arrived
    Arrival,
    /// By the time stamps of the PDUs
    Stamps,
}

/// What becomes of time stamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Stamps {
    /// As recorded.
    Keep,
    /// Of the moment they are sent.
    Now,
}

/// What a player is told.
#[derive(Debug, PartialEq)]
enum Command {
    Pause,
    Resume,
    Seek(When),
    SetPace(Pace),
    Step,
    Back,
    Quit,
    /// No more commands will come.
    NoMore,
}

impl std::str::FromStr for Command {
    type Err = String;

    fn from_str(line: &str) -> Result<Self, String> {
        let (word, rest) = line.trim().split_once(' ').unwrap_or((line.trim(), ""));
        let rest = rest.trim();
        match (word, rest) {
            ("pause", "") => Ok(Self::Pause),
            ("resume" | "play", "") => Ok(Self::Resume),
            ("seek", time) => time.parse().map(Self::Seek).map_err(|e| format!("{e}")),
            ("rate", rate) => pace(rate).map(Self::SetPace),
            ("fast", "") => Ok(Self::SetPace(Pace::AsFastAsPossible)),
            ("step", "") => Ok(Self::Step),
            ("back", "") => Ok(Self::Back),
            ("quit", "") => Ok(Self::Quit),
            _ => Err(format!(
                "`{line}`: commands are pause, resume, seek TIME, rate X, fast, step, back, quit"
            )),
        }
    }
}

/// How often progress is shown.
const PROGRESS_NS: i64 = 1_000_000_000;
/// Datagrams sent in one go.
const BATCH: usize = 64;

/// Plays a recording to its end, to `quit` or to Ctrl-C; the last line on stdout is a JSON summary.
/// Exit code 3 if the file has damaged places.
///
/// # Errors
/// If the file cannot be read or the link not be opened.
pub fn run(args: PlayerArgs) -> anyhow::Result<ExitCode> {
    let recording = open(&args)?;
    anyhow::ensure!(!recording.is_empty(), "{}: no datagram in it", args.file.display());
    let (from, to) = span(&args, recording.time_ns(0));
    let last = recording.time_ns(recording.len() - 1);
    if from > to {
        return Ok(fail(BAD_INPUT, "--from is after --to: nothing lies between them"));
    }
    if from > last || to < recording.time_ns(0) {
        let lasts_s = (last - recording.time_ns(0)) as f64 * 1e-9;
        let name = args.file.display();
        let words = format!(
            "{name}: nothing between --from and --to; its datagrams are from 0 to {lasts_s:.3} s"
        );
        return Ok(fail(BAD_INPUT, words));
    }
    let config = args.link.config()?;
    let sender = datalink::Sender::open(&config)?;
    let (commands_in, commands) = unbounded();
    let quit = commands_in.clone();
    ctrlc::set_handler(move || {
        let _ = quit.send(Command::Quit);
    })
    .context("listening for Ctrl-C")?;
    if args.control {
        let commands = commands_in.clone();
        std::thread::spawn(move || read_commands(&commands));
    }
    let listening =
        args.start_on_resume.then(|| listen(&config, &sender, commands_in)).transpose()?;
    let mut playing = Playing::new(&args, &recording, sender);
    let result = playing.play(&commands);
    drop(listening);
    if result.is_ok() || playing.datagrams > 0 {
        playing.end_line()?;
    }
    result?;
    let damaged = recording.problems().1 > 0;
    Ok(if damaged { ExitCode::from(3) } else { ExitCode::SUCCESS })
}

fn open(args: &PlayerArgs) -> anyhow::Result<Recording> {
    let octets = std::fs::metadata(&args.file).map_or(0, |m| m.len());
    let show = !args.quiet && io::stderr().is_terminal() && octets > 64 << 20;
    let recording = Recording::open_with(&args.file, |read| {
        if show && octets > 0 {
            let percent = read * 100 / octets;
            let _ = write!(io::stderr(), "\rindexing {percent} %   ");
        }
    })?;
    if show {
        let _ = writeln!(io::stderr());
    }
    for remark in recording.problems().0 {
        let _ = writeln!(io::stderr(), "{}: {remark}", args.file.display());
    }
    Ok(scheduled(recording, args))
}

/// The recording on the schedule that was asked for.
fn scheduled(recording: Recording, args: &PlayerArgs) -> Recording {
    match args.schedule {
        Schedule::Arrival => recording,
        Schedule::Stamps => recording.by_stamps(),
        Schedule::Auto => {
            let (arrival_ns, stamps_ns) = recording.lasts_ns();
            if stamps_ns / 2 <= arrival_ns.max(NOT_WORTH_A_SCHEDULE_NS) {
                return recording;
            }
            if !args.quiet {
                let _ = writeln!(
                    io::stderr(),
                    "{}: {} s by its PDUs' time stamps arrived within {} s: played by the stamps (--schedule arrival: as it arrived)",
                    args.file.display(),
                    seconds(stamps_ns),
                    seconds(arrival_ns)
                );
            }
            recording.by_stamps()
        }
    }
}

/// A recording this short is played as it arrived.
const NOT_WORTH_A_SCHEDULE_NS: i64 = 1_000_000_000;

fn read_commands(commands: &Sender<Command>) {
    for line in io::stdin().lock().lines().map_while(Result::ok) {
        if line.trim().is_empty() {
            continue;
        }
        let delivered = match line.parse() {
            Ok(command) => commands.send(command).is_ok(),
            Err(reason) => writeln!(io::stderr(), "{reason}").is_ok(),
        };
        if !delivered {
            return;
        }
    }
    let _ = commands.send(Command::NoMore);
}

/// Ends the listening thread when dropped.
struct Listening(datalink::Waker, std::sync::Arc<std::sync::atomic::AtomicBool>);

impl Drop for Listening {
    fn drop(&mut self) {
        self.1.store(true, std::sync::atomic::Ordering::SeqCst);
        self.0.wake();
    }
}

/// Start/Resume and Stop/Freeze of others become commands; what this process sends itself does not.
fn listen(
    config: &datalink::LinkConfig,
    sender: &datalink::Sender,
    commands: Sender<Command>,
) -> anyhow::Result<Listening> {
    let mut receiver = datalink::Receiver::open(config)?;
    let own = sender.address()?;
    let stop = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
    let listening = Listening(receiver.waker(), std::sync::Arc::clone(&stop));
    std::thread::spawn(move || {
        while !stop.load(std::sync::atomic::Ordering::SeqCst) {
            let received = receiver.receive(None, |arrival| {
                if arrival.from.port() == own.port()
                    && (own.ip().is_unspecified() || arrival.from.ip() == own.ip())
                {
                    return;
                }
                for received in pdu::pdus(arrival.payload).flatten() {
                    let command = match received.body() {
                        Body::StartResume(_) => Command::Resume,
                        Body::StopFreeze(_) => Command::Pause,
                        _ => continue,
                    };
                    let _ = commands.send(command);
                }
            });
            if let Err(e) = received {
                let _ = writeln!(io::stderr(), "{e}");
                return;
            }
        }
    });
    Ok(listening)
}

/// A recording being played.
struct Playing<'a> {
    recording: &'a Recording,
    player: Player,
    sender: datalink::Sender,
    rewrite: Rewrite,
    stamps: Stamps,
    lasting_ns: i64,
    start_ns: i64,
    name: String,
    /// Answers to commands go to stdout.
    answers: bool,
    show: bool,
    shown_at: i64,
    payloads: Vec<Vec<u8>>,
    datagrams: u64,
    states: u64,
    worst_late_ns: i64,
    began: i64,
}

/// UTC of `--from` and `--to`, ns.
fn span(args: &PlayerArgs, start_ns: i64) -> (i64, i64) {
    let time = |when: Option<When>, default| when.map_or(default, |w| w.utc_ns(start_ns));
    (time(args.from, i64::MIN), time(args.to, i64::MAX))
}

impl<'a> Playing<'a> {
    fn new(args: &PlayerArgs, recording: &'a Recording, sender: datalink::Sender) -> Self {
        let start_ns = recording.time_ns(0);
        let (from, to) = span(args, start_ns);
        let pace = if args.fast { Pace::AsFastAsPossible } else { args.rate };
        let now = now_ns();
        let (looping, wait) = (args.looping, args.start_on_resume);
        Self {
            recording,
            player: Player::new(recording, from, to, pace, looping, wait, now),
            sender,
            rewrite: args.rewrite.rewrite(),
            stamps: args.stamps,
            lasting_ns: (args.lasting.clamp(0.0, 1e9) * 1e9) as i64,
            start_ns,
            name: args.file.display().to_string(),
            answers: args.control,
            show: !args.quiet && io::stderr().is_terminal(),
            shown_at: now,
            payloads: Vec::new(),
            datagrams: 0,
            states: 0,
            worst_late_ns: 0,
            began: now,
        }
    }

    /// Until the end, `quit`, or Ctrl-C.
    fn play(&mut self, commands: &Receiver<Command>) -> anyhow::Result<()> {
        if self.player.phase() == Phase::Ended {
            let last = self.recording.len().saturating_sub(1);
            let lasts_s = (self.recording.time_ns(last) - self.start_ns) as f64 * 1e-9;
            anyhow::bail!(
                "{}: nothing between --from and --to; its datagrams are from 0 to {lasts_s:.3} s",
                self.name
            );
        }
        if self.player.window().start > 0 && self.player.phase() == Phase::Playing {
            self.send_states(self.player.position_ns(now_ns()))?;
        }
        loop {
            match self.next_command(commands) {
                Some(Command::Quit) => return Ok(()),
                Some(Command::NoMore) => self.answers = false,
                Some(command) => self.obey(command)?,
                None if self.player.phase() == Phase::Ended && !self.answers => return Ok(()),
                None => self.send_due()?,
            }
            self.progress();
        }
    }

    /// A command, or `None` when something is due.
    fn next_command(&self, commands: &Receiver<Command>) -> Option<Command> {
        let wait_ns = match self.player.wake_at(self.recording) {
            Some(at) => at - now_ns(),
            None if self.player.phase() == Phase::Ended && !self.answers => 0,
            None => PROGRESS_NS,
        };
        if wait_ns <= 0 {
            return commands.try_recv().ok();
        }
        commands.recv_timeout(Duration::from_nanos(wait_ns.min(PROGRESS_NS) as u64)).ok()
    }

    fn obey(&mut self, command: Command) -> anyhow::Result<()> {
        let now = now_ns();
        match command {
            Command::Pause => self.player.pause(now),
            Command::Resume => {
                let first = self.player.phase() == Phase::Waiting;
                self.player.resume(now);
                if first && self.player.window().start > 0 {
                    self.send_states(self.player.position_ns(now))?;
                }
            }
            Command::SetPace(pace) => self.player.set_pace(pace, now),
            Command::Seek(when) => {
                self.player.seek(self.recording, when.utc_ns(self.start_ns), now);
                self.send_states(self.player.position_ns(now))?;
            }
            Command::Step => {
                if let Some(number) = self.player.step(self.recording, now) {
                    self.send(number..number + 1)?;
                }
            }
            Command::Back => {
                if let Some(time_ns) = self.player.step_back(self.recording, now) {
                    self.send_states(time_ns)?;
                }
            }
            Command::Quit | Command::NoMore => {}
        }
        if self.answers {
            let line = json::Object::default()
                .text("phase", format_args!("{:?}", self.player.phase()))
                .raw("at_s", seconds(self.player.position_ns(now_ns()) - self.start_ns))
                .raw("next", self.player.next())
                .end();
            writeln!(io::stdout(), "{line}")?;
        }
        Ok(())
    }

    fn send_due(&mut self) -> anyhow::Result<()> {
        let at = self.player.wake_at(self.recording);
        let now = now_ns();
        let due = self.player.due(self.recording, now);
        if due.is_empty() {
            return Ok(());
        }
        if let Some(at) = at {
            self.worst_late_ns = self.worst_late_ns.max(now - at);
        }
        self.send(due)
    }

    fn send(&mut self, numbers: std::ops::Range<usize>) -> anyhow::Result<()> {
        let mut start = numbers.start;
        while start < numbers.end {
            let end = numbers.end.min(start + BATCH);
            self.payloads.resize(self.payloads.len().max(end - start), Vec::new());
            let stamp = self.stamp();
            for (number, payload) in (start..end).zip(&mut self.payloads) {
                self.recording
                    .payload(number, payload)
                    .with_context(|| format!("reading {}", self.name))?;
                self.rewrite.apply_at(payload, stamp);
            }
            self.sender.send_all(self.payloads[..end - start].iter().map(Vec::as_slice))?;
            self.datagrams += (end - start) as u64;
            start = end;
        }
        Ok(())
    }

    /// Sends the states that hold at a time of the recording.
    fn send_states(&mut self, time_ns: i64) -> anyhow::Result<()> {
        let stamp = self.stamp();
        let alive = self.recording.alive_at(time_ns, self.lasting_ns);
        let mut octets = Vec::new();
        for pdu in &alive {
            self.recording
                .pdu(*pdu, &mut octets)
                .with_context(|| format!("reading {}", self.name))?;
            self.rewrite.apply_at(&mut octets, stamp);
            self.sender.send(&octets)?;
        }
        self.states += alive.len() as u64;
        Ok(())
    }

    fn stamp(&self) -> Option<DisTime> {
        (self.stamps == Stamps::Now).then(|| DisTime::absolute(utc_ns().max(0) as u64))
    }

    fn progress(&mut self) {
        let now = now_ns();
        if !self.show || now - self.shown_at < PROGRESS_NS {
            return;
        }
        self.shown_at = now;
        let at = seconds(self.player.position_ns(now) - self.start_ns);
        let last = self.player.window().end.saturating_sub(1);
        let all = seconds(self.recording.time_ns(last) - self.start_ns);
        let (phase, n) = (self.player.phase(), self.datagrams);
        let _ = write!(io::stderr(), "\r{phase:?} at {at} of {all} s, {n} datagrams sent   ");
    }

    fn end_line(&self) -> anyhow::Result<()> {
        if self.show {
            let _ = writeln!(io::stderr());
        }
        let now = now_ns();
        let line = json::Object::default()
            .text("file", &self.name)
            .raw("datagrams", self.datagrams)
            .raw("states", self.states)
            .raw("rounds", self.player.rounds())
            .raw("at_s", seconds(self.player.position_ns(now) - self.start_ns))
            .raw("wall_s", seconds(now - self.began))
            .raw("worst_late_ms", format_args!("{:.3}", self.worst_late_ns as f64 * 1e-6))
            .end();
        writeln!(io::stdout(), "{line}")?;
        Ok(())
    }
}

fn now_ns() -> i64 {
    monotonic_ns() as i64
}

fn seconds(ns: i64) -> String {
    format!("{:.3}", ns as f64 * 1e-9)
}

fn pace(text: &str) -> Result<Pace, String> {
    let rate = text.parse::<f64>().map_err(|e| format!("`{text}`: {e}"))?;
    Pace::times(rate).map_err(|e| format!("{e}; as fast as possible: --fast"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_words() {
        assert_eq!("pause".parse(), Ok(Command::Pause));
        assert_eq!(" seek 12.5 ".parse(), Ok(Command::Seek(When::FromStart(12_500_000_000))));
        assert_eq!("rate 2".parse(), Ok(Command::SetPace(Pace::Millionths(2_000_000))));
        for bad in ["rate 1000", "seek", "stop", "pause now", "rate NaN"] {
            assert!(bad.parse::<Command>().is_err(), "{bad}");
        }
    }
}
