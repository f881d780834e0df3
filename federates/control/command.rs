//! The command line of the member `control`, and its process.

use super::Control;
use crate::runtime::cli::{CommonArgs, load_scene_without_truth};
use crate::runtime::member_process::{Makes, member};
use clap::Args;
use std::process::ExitCode;

/// Control: system tracks and clearances in, control alerts out, once a second
#[derive(Args, Clone, Debug)]
pub struct ControlArgs {
    #[command(flatten)]
    common: CommonArgs,
}

/// The process of the member `control`.
#[must_use]
pub fn run(args: &ControlArgs) -> ExitCode {
    member(
        &args.common,
        "control",
        load_scene_without_truth,
        Makes::default(),
        |scene, exercise| Box::new(Control::new(scene, exercise)),
    )
}
