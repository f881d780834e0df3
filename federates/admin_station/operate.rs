//! Operating a run that goes on from a terminal: one command, or how it stands.

use super::command::{AdminArgs, print_line};
use crate::exchange::operator;
use crate::runtime::bus::Bus;
use crate::runtime::cli::{self, BAD_INPUT, FAILED, NetworkArgs, fail};
use crate::runtime::messages::Command;
use crate::runtime::zenoh_bus::{ZenohBus, ZenohConfig};
use clap::{Args, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;
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
    /// Simulated seconds per wall second
    Rate {
        /// Factor, 0.001 to 1000, or "fast"
        #[arg(value_name = "X")]
        rate: String,
        #[command(flatten)]
        at: AtArgs,
    },
    /// Print a completion script for a shell
    Completions {
        /// Shell
        shell: clap_complete::Shell,
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
struct Place {
    endpoint: String,
    exercise: u8,
    /// Certificates only.
    network: NetworkArgs,
}

impl Place {
    /// What stands before and after the command's word: either names the run, both must name the same one.
    fn of(args: &AdminArgs, at: &AtArgs) -> Result<Self, String> {
        if let Some(flag) = args.of_a_station() {
            return Err(format!(
                "{flag} is for starting an administration station; a command to one takes --at ENDPOINT and --exercise N"
            ));
        }
        let before = &args.common.network;
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
                args.common.exercise.as_ref(),
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

/// Asks the run that the arguments name.
pub(super) fn operate_run(args: &AdminArgs, operate: &Operate) -> ExitCode {
    let (command, at) = match operate {
        Operate::Completions { shell } => {
            use clap::CommandFactory;
            #[derive(clap::Parser)]
            #[command(name = "admin-station")]
            struct Admin {
                #[command(flatten)]
                args: AdminArgs,
            }
            clap_complete::generate(
                *shell,
                &mut Admin::command(),
                "admin-station",
                &mut std::io::stdout(),
            );
            return ExitCode::SUCCESS;
        }
        Operate::Status { at, json } => {
            return match Place::of(args, at) {
                Ok(place) => status(&place, *json),
                Err(e) => fail(BAD_INPUT, e),
            };
        }
        Operate::Start { at } | Operate::Resume { at } => (Command::Start, at),
        Operate::Freeze { at } => (Command::Freeze, at),
        Operate::Step { n, at } => (Command::Step { n: *n }, at),
        Operate::Stop { at } => (Command::Stop, at),
        Operate::Restart { at } => (Command::Restart, at),
        Operate::Rate { rate, at } => {
            let rate = if rate == "fast" { Ok(f64::INFINITY) } else { cli::rate(rate) };
            match rate {
                Ok(rate) => (Command::Rate { rate }, at),
                Err(e) => return fail(BAD_INPUT, format!("{e}, nor \"fast\"")),
            }
        }
    };
    let place = match Place::of(args, at) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Admin {
        #[command(flatten)]
        args: AdminArgs,
    }

    fn place(line: &str) -> Result<Place, String> {
        let words = ["admin-station"].into_iter().chain(line.split_whitespace());
        let args = Admin::try_parse_from(words).map_err(|e| e.to_string())?.args;
        match args.operate.as_ref().expect("a command") {
            Operate::Freeze { at } | Operate::Status { at, .. } => Place::of(&args, at),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_command_goes_to_the_run_that_was_named_wherever_it_was_named() {
        for (line, endpoint, exercise) in [
            ("freeze", "tcp/127.0.0.1:7447", 1),
            ("--certs /c freeze", "tls/127.0.0.1:7447", 1),
            ("freeze --at tls/10.0.0.1:9 --certs /c", "tls/10.0.0.1:9", 1),
            ("--sync-connect tcp/10.0.0.1:9 freeze", "tcp/10.0.0.1:9", 1),
            ("freeze --at tcp/10.0.0.1:9", "tcp/10.0.0.1:9", 1),
            ("freeze --sync-connect tcp/10.0.0.1:9 --exercise 4", "tcp/10.0.0.1:9", 4),
            ("--exercise 4 status --at tcp/10.0.0.1:9", "tcp/10.0.0.1:9", 4),
            ("--sync-connect tcp/10.0.0.1:9 freeze --at tcp/10.0.0.1:9", "tcp/10.0.0.1:9", 1),
        ] {
            let place = place(line).unwrap_or_else(|e| panic!("{line}: {e}"));
            assert_eq!((&place.endpoint[..], place.exercise), (endpoint, exercise), "{line}");
        }
    }

    #[test]
    fn two_runs_or_a_flag_without_meaning_are_refused() {
        for (line, words) in [
            ("--sync-connect tcp/10.0.0.1:9 freeze --at tcp/10.0.0.1:8", "name different runs"),
            ("--exercise 3 freeze --exercise 4", "name different runs"),
            ("--rate 2 freeze", "--rate is for starting"),
            ("--sync-listen tcp/127.0.0.1:9 freeze", "--sync-listen is for starting"),
            ("--scene x.toml --fast status", "--scene is for starting"),
            ("freeze --at tcp/127.0.0.1:0", "port 0"),
            ("freeze --at tls/127.0.0.1:9", "needs certificates"),
            ("freeze --at tcp/127.0.0.1:9 --certs /c", "the endpoint is tls/127.0.0.1:9"),
            ("freeze --at udp/127.0.0.1:9", "tls/ADDRESS:PORT only"),
        ] {
            let refused = place(line).expect_err(line);
            assert!(refused.contains(words), "{line}: {refused}");
        }
    }
}
