//! The executable `smdfm`: the same as `seeds smdfm`, for hosts that need just one federate.

use clap::Parser;
use federates::runtime::cli::{self, EXIT_CODES};
use federates::seeds::federate_commands::{self, SmdfmArgs};
use std::process::ExitCode;

/// Sensor model and data fusion: truth and weather in, plots and system tracks out, once a second
#[derive(Parser)]
#[command(name = "smdfm", version = federates::runtime::build::VERSION, after_help = EXIT_CODES)]
struct Args {
    #[command(flatten)]
    args: SmdfmArgs,
}

fn main() -> ExitCode {
    federate_commands::smdfm(&cli::parse::<Args>().args)
}
