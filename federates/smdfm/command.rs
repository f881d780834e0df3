//! The command line of the sensor model and data fusion module, and its process.

use super::Smdfm;
use crate::runtime::cli::{CommonArgs, load_scene_without_truth};
use crate::runtime::member::Remake;
use crate::runtime::member_process::{Makes, member};
use crate::take_over::make_producers;
use clap::Args;
use std::process::ExitCode;

/// Sensor model and data fusion: truth and weather in, plots and system tracks out, once a second
#[derive(Args, Clone, Debug)]
pub struct SmdfmArgs {
    #[command(flatten)]
    common: CommonArgs,

    /// Say of every plot what each simulated effect did to it, on the page and in the database
    #[arg(long)]
    explain: bool,
}

/// The sensor model and data fusion module's process.
#[must_use]
pub fn run(args: &SmdfmArgs) -> ExitCode {
    let (typed, exercise) = (args.common.scene.clone(), args.common.exercise);
    let remake: Remake = Box::new(move |config| make_producers(&typed, exercise, config));
    let makes = Makes { remake: Some(remake), ..Makes::default() };
    member(&args.common, "smdfm", load_scene_without_truth, makes, |scene, exercise| {
        Box::new(Smdfm::new(scene, exercise).explaining(args.explain))
    })
}
