//! The command line of the sensor model and data fusion module, and its process.

use super::Smdfm;
use super::front_end::FrontEnd;
use crate::federation::{MOST_SMDFMS, smdfm_name};
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

    /// Which share of the sensors, of how many SMDFMs: 2/3. The first fuses the plots of all
    #[arg(long, value_name = "I/N", default_value = "1/1", value_parser = share_of)]
    share: (u32, u32),

    /// Say of every plot what each simulated effect did to it, on the page and in the database
    #[arg(long)]
    explain: bool,
}

fn share_of(text: &str) -> Result<(u32, u32), String> {
    let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    match parts {
        Some((i, n)) if (1..=MOST_SMDFMS).contains(&n) && (1..=n).contains(&i) => Ok((i, n)),
        _ => Err(format!("'{text}' is not a share like 2/3 (which, of 1 to {MOST_SMDFMS} SMDFMs)")),
    }
}

/// The sensor model and data fusion module's process.
#[must_use]
pub fn run(args: &SmdfmArgs) -> ExitCode {
    let (typed, exercise) = (args.common.scene.clone(), args.common.exercise);
    let remake: Remake = Box::new(move |config| make_producers(&typed, exercise, config));
    let makes = Makes { remake: Some(remake), ..Makes::default() };
    let (share, of) = args.share;
    member(&args.common, &smdfm_name(share), load_scene_without_truth, makes, |scene, exercise| {
        if share == 1 {
            Box::new(Smdfm::new(scene, exercise).explaining(args.explain))
        } else {
            Box::new(FrontEnd::new(scene, exercise, share, of).explaining(args.explain))
        }
    })
}
