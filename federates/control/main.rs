//! The executable `control`: the same as `seeds control`, for hosts that need just one federate.

use clap::Parser;
use federates::control::command::{self, ControlArgs};
use federates::runtime::cli::{self, EXIT_CODES};
use std::process::ExitCode;

/// Control: system tracks and clearances in, control alerts out, once a second
#[derive(Parser)]
#[command(name = "control", version = federates::runtime::build::VERSION, after_help = EXIT_CODES)]
struct Args {
    #[command(flatten)]
    args: ControlArgs,
}

fn main() -> ExitCode {
    command::run(&cli::parse::<Args>().args)
}
