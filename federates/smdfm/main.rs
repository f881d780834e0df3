//! The executable `smdfm`: the same as `seeds smdfm`, for hosts that need just one federate.

use clap::Parser;
use federates::runtime::cli::{self, EXIT_CODES};
use federates::smdfm::command::{self, SmdfmArgs};
use std::process::ExitCode;

/// Sensor model and data fusion: truth and weather in, plots and system tracks out, once a second
#[derive(Parser)]
#[command(name = "smdfm", version = federates::runtime::build::VERSION, after_help = EXIT_CODES)]
struct Args {
    #[command(flatten)]
    args: SmdfmArgs,
}

fn main() -> ExitCode {
    command::run(&cli::parse::<Args>().args)
}
