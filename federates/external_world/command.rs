//! The command line of the external world, and its process.

use super::ExternalWorld;
use crate::runtime::cli::{CommonArgs, load_scene_without_truth};
use crate::runtime::member_process::member;
use crate::take_over::hosting;
use clap::Args;
use std::process::ExitCode;

/// External world: weather and flight data
#[derive(Args, Clone, Debug)]
pub struct WorldArgs {
    #[command(flatten)]
    common: CommonArgs,
}

/// The external world's process.
#[must_use]
pub fn run(args: &WorldArgs) -> ExitCode {
    let makes = hosting(&args.common);
    member(&args.common, "external-world", load_scene_without_truth, makes, |scene, exercise| {
        Box::new(ExternalWorld::new(scene, exercise))
    })
}
