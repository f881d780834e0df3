//! The executable `visitors`: the same as `seeds visitors`, for hosts that need just one federate.

use clap::Parser;
use federates::runtime::cli::{self, EXIT_CODES};
use federates::visitors::command::{self, VisitorsArgs};
use std::process::ExitCode;

/// Visitors: lets the entities of other simulators in, stamped into frames
#[derive(Parser)]
#[command(name = "visitors", version, after_help = EXIT_CODES)]
struct Args {
    #[command(flatten)]
    args: VisitorsArgs,
}

fn main() -> ExitCode {
    command::run(&cli::parse::<Args>().args)
}
