//! The command line of the traffic generator, and its process.

use super::TrafficGenerator;
use crate::federation::generator_name;
use crate::runtime::cli::{self, CommonArgs};
use crate::runtime::member_process::member;
use crate::take_over::hosting;
use clap::Args;
use std::process::ExitCode;

/// Traffic generator: ground truth as Entity State PDUs
#[derive(Args, Clone, Debug)]
pub struct TrafficArgs {
    #[command(flatten)]
    common: CommonArgs,

    /// Which share of the traffic, of how many generators: 2/3
    #[arg(long, value_name = "I/N", default_value = "1/1", value_parser = share_of)]
    share: (u32, u32),
}

fn share_of(text: &str) -> Result<(u32, u32), String> {
    let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    match parts {
        Some((i, n)) if 1 <= i && i <= n && n <= 16 => Ok((i, n)),
        _ => Err(format!("'{text}' is not a share like 2/3 (which, of 1 to 16 generators)")),
    }
}

/// The traffic generator's process.
#[must_use]
pub fn run(args: &TrafficArgs) -> ExitCode {
    let (share, of) = args.share;
    let load = |typed: &str| cli::load_scene_share(typed, share, of);
    let makes = hosting(&args.common);
    member(&args.common, &generator_name(share, of), load, makes, |scene, exercise| {
        Box::new(TrafficGenerator::new(scene, exercise, share, of))
    })
}
