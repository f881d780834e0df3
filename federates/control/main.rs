//! The executable `control`: the same as `seeds control`, for hosts that need just one federate.

use clap::Parser;
use federates::runtime::cli::{self, EXIT_CODES};
use federates::seeds::federate_commands::{self, ControlArgs};
use std::process::ExitCode;

/// Control: system tracks and clearances in, control alerts out, once a second
#[derive(Parser)]
#[command(name = "control", version = federates::runtime::build::VERSION, after_help = EXIT_CODES)]
struct Args {
    #[command(flatten)]
    args: ControlArgs,
}

fn main() -> ExitCode {
    federate_commands::control(&cli::parse::<Args>().args)
}
