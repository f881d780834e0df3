//! The command line of the member `visitors`, and its process.

use super::{SharedPlots, Visitors, plots};
use crate::runtime::cli::{self, CommonArgs, FAILED, fail, load_scene_without_truth};
use crate::runtime::dis_socket;
use crate::runtime::member_driver::Event;
use crate::runtime::member_process::{Makes, end_on_interrupt, run_federate};
use crate::runtime::threads::spawn_watched;
use anyhow::Context;
use clap::Args;
use crossbeam_channel::{Sender, unbounded};
use scenarios::Scene;
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
    let (plots, deaf) = (visitors.plots(), events.0.clone());
    let ended = dis_socket::listen(
        &args.network,
        &scene.network,
        move |why| drop(failed.send(Event::Failed(why))),
        move |arrival| door.lock().knock(arrival.utc_ns, arrival.from, arrival.payload),
    )
    .and_then(|()| hear_plots(&scene, &plots, &deaf))
    .and_then(|()| {
        end_on_interrupt(events.0.clone())?;
        run_federate(args, "visitors", &scene, Box::new(visitors), events, Makes::default())
    });
    match ended {
        Ok(code) => ExitCode::from(code),
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

/// Hears the real sensors of a scene, each place on a thread of its own, until the process ends.
fn hear_plots(scene: &Scene, door: &SharedPlots, failed: &Sender<Event>) -> anyhow::Result<()> {
    for (listen, config) in plots::links(scene) {
        let mut receiver = datalink::Receiver::open(&config)
            .with_context(|| format!("sensors of somebody else at {listen}"))?;
        let (door, failed) = (door.clone(), failed.clone());
        let dead = failed.clone();
        let died = move |why| drop(dead.send(Event::Failed(why)));
        spawn_watched("the receiver of plots", died, move || {
            loop {
                let heard = receiver.receive(None, |arrival| {
                    door.lock().knock(arrival.utc_ns, listen, arrival.from, arrival.payload);
                });
                if let Err(e) = heard {
                    drop(failed.send(Event::Failed(format!("receiving plots: {e}"))));
                    return;
                }
            }
        })?;
    }
    Ok(())
}

/// Whether the real sensors of a scene can be listened for, before a run begins.
///
/// # Errors
/// Where not, and why.
pub fn check_plots(scene: &Scene) -> anyhow::Result<()> {
    for (listen, config) in plots::links(scene) {
        datalink::Receiver::open(&config)
            .with_context(|| format!("sensors of somebody else at {listen}"))?;
    }
    Ok(())
}
