//! Operating a run that goes on from a terminal: one command, or how it stands.

use super::watch;
use crate::exchange::operator;
use crate::runtime::bus::Bus;
use crate::runtime::cli::{self, BAD_INPUT, CommonArgs, FAILED, NetworkArgs, fail, print_line};
use crate::runtime::messages::Command;
use crate::runtime::zenoh_bus::{Part, ZenohBus, ZenohConfig};
use clap::{Args, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

/// Operating a run.
#[derive(Subcommand, Clone, Debug)]
pub(super) enum Operate {
    /// How the run stands, with application and system statistics
    Status {
        /// As one JSON object
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        at: AtArgs,
    },
    /// How the run stands, again and again: in a terminal a screen whose keys operate the run, else tables or rows of figures until it is over
    Watch {
        /// Pause, s, 0.1 to 3600
        #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = pause)]
        every: f64,
        /// Write a row for each federate and time into this file; - for the output instead of tables
        #[arg(long, value_name = "FILE")]
        csv: Option<PathBuf>,
        /// Tables in a terminal, too, and no keys
        #[arg(long)]
        plain: bool,
        #[command(flatten)]
        at: AtArgs,
    },
    /// Start a configured run
    Start {
        #[command(flatten)]
        at: AtArgs,
    },
    /// Stop all federates at one common frame
    Freeze {
        #[command(flatten)]
        at: AtArgs,
    },
    /// Go on after a freeze
    Resume {
        #[command(flatten)]
        at: AtArgs,
    },
    /// Execute some frames, then freeze again
    Step {
        /// Frames
        #[arg(value_name = "FRAMES", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
        n: u64,
        #[command(flatten)]
        at: AtArgs,
    },
    /// Close the run
    Stop {
        #[command(flatten)]
        at: AtArgs,
    },
    /// Back to frame 0 of the same scene
    Restart {
        #[command(flatten)]
        at: AtArgs,
    },
    /// Let another process take the place of a traffic generator or of the external world, to the same bits: away from a busy host, or from
    /// one that is to be shut down. Needs --on-loss takeover
    Move {
        /// Whose place, like traffic-generator-2
        #[arg(value_name = "NAME")]
        name: String,
        /// Whose process takes it, like external-world; the process that had it ends when it has no other place
        #[arg(value_name = "TO")]
        to: String,
        #[command(flatten)]
        at: AtArgs,
    },
    /// Go on without a federate that is lost and that time stands for: from its last frame on nothing comes of it, and the run is another
    /// one, degraded since a stated frame, until a restart
    Without {
        /// Who is lost, like traffic-generator-2
        #[arg(value_name = "NAME")]
        name: String,
        #[command(flatten)]
        at: AtArgs,
    },
    /// Simulated seconds per wall second
    Rate {
        /// Factor, 0.001 to 1000, or "fast"
        #[arg(value_name = "X")]
        rate: String,
        #[command(flatten)]
        at: AtArgs,
    },
}

/// Which run to operate.
#[derive(Args, Clone, Debug)]
pub(super) struct AtArgs {
    /// Endpoint of the run's administration station [default: tcp/127.0.0.1:7447]
    #[arg(long = "at", visible_alias = "sync-connect", id = "at-endpoint", value_name = "ENDPOINT", value_parser = cli::endpoint_of_another)]
    endpoint: Option<String>,
    /// DIS exercise identifier of the run, 0 to 255 [default: 1]
    #[arg(long = "exercise", id = "at-exercise", value_name = "N")]
    exercise: Option<u8>,
    /// Folder with the certificates of the federation
    #[arg(long = "certs", id = "at-certs", value_name = "DIR")]
    certs: Option<PathBuf>,
}

/// The run that a command goes to.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub(super) endpoint: String,
    pub(super) exercise: u8,
    /// Certificates only.
    network: NetworkArgs,
}

impl Place {
    /// What stands before and after the command's word: either names the run, both must name the same one.
    pub(super) fn of(common: &CommonArgs, at: &AtArgs) -> Result<Self, String> {
        let before = &common.network;
        let certs = at.certs.clone().or_else(|| before.certs.clone());
        let network = NetworkArgs { certs, ..NetworkArgs::default() };
        let named =
            one_of("--sync-connect", before.sync_connect.as_ref(), "--at", at.endpoint.as_ref())?;
        let endpoint = named.cloned().unwrap_or_else(|| network.default_endpoint());
        network.check_connecting(&endpoint).map_err(|e| e.to_string())?;
        Ok(Self {
            endpoint,
            network,
            exercise: *one_of(
                "--exercise",
                common.exercise.as_ref(),
                "--exercise",
                at.exercise.as_ref(),
            )?
            .unwrap_or(&1),
        })
    }
}

/// What was given before or after the command's word.
fn one_of<'a, T: PartialEq + std::fmt::Display>(
    first_flag: &str,
    first: Option<&'a T>,
    second_flag: &str,
    second: Option<&'a T>,
) -> Result<Option<&'a T>, String> {
    match (first, second) {
        (Some(a), Some(b)) if a != b => {
            Err(format!("{first_flag} {a} and {second_flag} {b} name different runs: give one"))
        }
        (a, b) => Ok(b.or(a)),
    }
}

fn pause(text: &str) -> Result<f64, String> {
    let range = 0.1..=3600.0;
    text.parse()
        .ok()
        .filter(|s| range.contains(s))
        .ok_or_else(|| format!("'{text}' is not a number of seconds from 0.1 to 3600"))
}

/// Asks the run that the arguments name.
pub(super) fn operate_run(common: &CommonArgs, operate: &Operate) -> ExitCode {
    let (command, at) = match operate {
        Operate::Status { at, json } => {
            return match Place::of(common, at) {
                Ok(place) => status(&place, *json),
                Err(e) => fail(BAD_INPUT, e),
            };
        }
        Operate::Watch { every, csv, plain, at } => {
            let place = match Place::of(common, at) {
                Ok(place) => place,
                Err(e) => return fail(BAD_INPUT, e),
            };
            let every = Duration::from_secs_f64(*every);
            let watched = operator_bus(&place).and_then(|bus| {
                let bus: Arc<dyn Bus> = Arc::new(bus);
                let watched = watch::watch(&bus, &place.endpoint, every, csv.as_deref(), *plain);
                bus.close();
                watched
            });
            return match watched {
                Ok(()) => ExitCode::SUCCESS,
                Err(e) => fail(FAILED, format!("{e:#}")),
            };
        }
        Operate::Start { at } | Operate::Resume { at } => (Command::Start, at),
        Operate::Freeze { at } => (Command::Freeze, at),
        Operate::Step { n, at } => (Command::Step { n: *n }, at),
        Operate::Stop { at } => (Command::Stop, at),
        Operate::Restart { at } => (Command::Restart, at),
        Operate::Move { name, to, at } => {
            (Command::Move { name: name.clone(), to: to.clone() }, at)
        }
        Operate::Without { name, at } => (Command::Without { name: name.clone() }, at),
        Operate::Rate { rate, at } => {
            let rate = if rate == "fast" { Ok(f64::INFINITY) } else { cli::rate(rate) };
            match rate {
                Ok(rate) => (Command::Rate { rate }, at),
                Err(e) => return fail(BAD_INPUT, format!("{e}, nor \"fast\"")),
            }
        }
    };
    let place = match Place::of(common, at) {
        Ok(place) => place,
        Err(e) => return fail(BAD_INPUT, e),
    };
    let answer = operator_bus(&place).and_then(|bus| {
        let answer = operator::command(&bus, &place.endpoint, "terminal", command);
        bus.close();
        Ok(answer?)
    });
    match answer {
        Ok(answer) if answer.ok => {
            print_line(&answer.text);
            ExitCode::SUCCESS
        }
        Ok(answer) => fail(FAILED, answer.text),
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

fn operator_bus(at: &Place) -> anyhow::Result<ZenohBus> {
    Ok(ZenohBus::open(&ZenohConfig {
        part: Part::Peer,
        listen: vec![],
        connect: vec![at.endpoint.clone()],
        exercise: at.exercise,
        connect_timeout: Duration::from_secs(3),
        certs: at.network.certs_of("operator")?,
    })?)
}

fn status(at: &Place, json: bool) -> ExitCode {
    let statistics = operator_bus(at).and_then(|bus| {
        let statistics = operator::statistics(&bus, &at.endpoint);
        bus.close();
        Ok(statistics?)
    });
    match statistics {
        Ok(statistics) if json => print_line(&statistics.to_string()),
        Ok(statistics) => print_line(&operator::table(&statistics)),
        Err(e) => return fail(FAILED, format!("{e:#}")),
    }
    ExitCode::SUCCESS
}
