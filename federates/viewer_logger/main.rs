//! The executable `viewer-logger`: the same as `seeds viewer-logger`, for hosts that need just one federate.

use clap::Parser;
use federates::runtime::cli::{self, EXIT_CODES};
use federates::viewer_logger::command::{self, ViewerArgs};
use std::process::ExitCode;

/// Viewer and logger: the page, the recording, the database
#[derive(Parser)]
#[command(name = "viewer-logger", version = federates::runtime::build::VERSION, after_help = EXIT_CODES)]
struct Args {
    #[command(flatten)]
    args: ViewerArgs,
}

fn main() -> ExitCode {
    command::run(&cli::parse::<Args>().args)
}
