//! The command line of the member `visitors`, and its process.

use super::Visitors;
use crate::runtime::cli::{self, CommonArgs, FAILED, fail, load_scene_without_truth};
use crate::runtime::dis_socket;
use crate::runtime::member_driver::Event;
use crate::runtime::member_process::{Makes, end_on_interrupt, run_federate};
use clap::Args;
use crossbeam_channel::unbounded;
use std::process::ExitCode;
use std::sync::Arc;

/// Visitors: lets the entities of other simulators in, stamped into frames
#[derive(Args, Clone, Debug)]
pub struct VisitorsArgs {
    #[command(flatten)]
    common: CommonArgs,
}

/// The process of the member `visitors`.
#[must_use]
pub fn run(args: &VisitorsArgs) -> ExitCode {
    let args = &args.common;
    crate::runtime::process::end_with_launcher();
    cli::log_to_stderr(args.log_format, "warn");
    let scene = match load_scene_without_truth(&args.scene) {
        Ok(scene) => Arc::new(scene),
        Err(code) => return code,
    };
    let exercise = args.exercise.unwrap_or(scene.run.exercise);
    let visitors = Visitors::new(Arc::clone(&scene), exercise);
    let events = unbounded();
    let (door, failed) = (visitors.door(), events.0.clone());
    let ended = dis_socket::listen(
        &args.network,
        &scene.network,
        move |why| drop(failed.send(Event::Failed(why))),
        move |arrival| door.lock().knock(arrival.utc_ns, arrival.from, arrival.payload),
    )
    .and_then(|()| {
        end_on_interrupt(events.0.clone())?;
        run_federate(args, "visitors", &scene, Box::new(visitors), events, Makes::default())
    });
    match ended {
        Ok(code) => ExitCode::from(code),
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}
