//! The executable `traffic-generator`: the same as `seeds traffic-generator`, for hosts that need just one federate.

use clap::Parser;
use federates::runtime::cli::{self, EXIT_CODES};
use federates::traffic_generator::command::{self, TrafficArgs};
use std::process::ExitCode;

/// Traffic generator: ground truth as Entity State PDUs
#[derive(Parser)]
#[command(name = "traffic-generator", version = federates::runtime::build::VERSION, after_help = EXIT_CODES)]
struct Args {
    #[command(flatten)]
    args: TrafficArgs,
}

fn main() -> ExitCode {
    command::run(&cli::parse::<Args>().args)
}
