//! The executable `external-world`: the same as `seeds external-world`, for hosts that need just one federate.

use clap::Parser;
use federates::external_world::command::{self, WorldArgs};
use federates::runtime::cli::{self, EXIT_CODES};
use std::process::ExitCode;

/// External world: weather and flight data
#[derive(Parser)]
#[command(name = "external-world", version = federates::runtime::build::VERSION, after_help = EXIT_CODES)]
struct Args {
    #[command(flatten)]
    args: WorldArgs,
}

fn main() -> ExitCode {
    command::run(&cli::parse::<Args>().args)
}
