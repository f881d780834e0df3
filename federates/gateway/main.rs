//! The gateway's process: see `gateway --help`.

use clap::Parser;
use federates::gateway::command::{self, GatewayArgs};
use federates::runtime::cli::{self, EXIT_CODES};
use std::process::ExitCode;

/// What sensors and data fusion found, in ASTERIX, to whoever is to have it
#[derive(Parser)]
#[command(name = "gateway", version = federates::runtime::build::VERSION, after_help = EXIT_CODES)]
struct Gateway {
    #[command(flatten)]
    args: GatewayArgs,
}

fn main() -> ExitCode {
    cli::ended(command::run(&cli::parse::<Gateway>().args))
}
