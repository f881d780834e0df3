//! The executable `admin-station`: the same as `seeds admin-station`, for hosts that need just one federate.

use clap::Parser;
use federates::admin_station::command::{self, AdminArgs};
use federates::runtime::cli::{self, EXIT_CODES};
use std::process::ExitCode;

/// Administration station: configure, start, freeze, step, stop, restart, measure
#[derive(Parser)]
#[command(name = "admin-station", version = federates::runtime::build::VERSION, after_help = EXIT_CODES)]
struct Args {
    #[command(flatten)]
    args: AdminArgs,
}

fn main() -> ExitCode {
    cli::ended(command::run(&cli::parse::<Args>().args))
}
