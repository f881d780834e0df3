//! The executable `admin-station`: the same as `seeds admin-station`, for hosts that need just one federate.

use clap::Parser;
use federates::runtime::cli::{self, EXIT_CODES};
use federates::seeds::federate_commands::{self, AdminArgs};
use std::process::ExitCode;

/// Administration station: configure, start, freeze, step, stop, restart, measure
#[derive(Parser)]
#[command(name = "admin-station", version = federates::runtime::build::VERSION, after_help = EXIT_CODES)]
struct Args {
    #[command(flatten)]
    args: AdminArgs,
}

fn main() -> ExitCode {
    cli::ended(federate_commands::admin_station(&cli::parse::<Args>().args))
}
