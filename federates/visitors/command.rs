//! The command line of the member `visitors`, and its process.

use super::seats::read_inputs;
use super::{SharedPlots, SharedSeats, Visitors, plots};
use crate::runtime::bus::Request;
use crate::runtime::cli::{self, BAD_INPUT, CommonArgs, FAILED, fail, load_scene_without_truth};
use crate::runtime::clock::utc_ns;
use crate::runtime::codec::{decode, encode};
use crate::runtime::dis_socket;
use crate::runtime::member_driver::Event;
use crate::runtime::member_process::{Handler, Makes, end_on_interrupt, run_federate};
use crate::runtime::messages::{SeatAnswer, SeatOrder, seat_key};
use crate::runtime::senders::Senders;
use crate::runtime::threads::spawn_watched;
use anyhow::Context;
use clap::Args;
use crossbeam_channel::{Sender, unbounded};
use scenarios::Scene;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// Visitors: lets the entities of other simulators in, stamped into frames
#[derive(Args, Clone, Debug)]
pub struct VisitorsArgs {
    #[command(flatten)]
    common: CommonArgs,

    /// Say again what people at controllers' seats said in another run: its database (.sqlite), or a line of JSON each
    #[arg(long, value_name = "FILE")]
    inputs: Option<PathBuf>,
}

/// The process of the member `visitors`.
#[must_use]
pub fn run(args: &VisitorsArgs) -> ExitCode {
    let inputs = args.inputs.as_deref();
    let args = &args.common;
    crate::runtime::process::end_with_launcher();
    cli::log_to_stderr(args.log_format, "warn");
    let scene = match load_scene_without_truth(&args.scene) {
        Ok(scene) => Arc::new(scene),
        Err(code) => return code,
    };
    let exercise = args.exercise.unwrap_or(scene.run.exercise);
    let visitors = Visitors::new(Arc::clone(&scene), exercise);
    match inputs.map(|file| read_inputs(file, &scene)).transpose() {
        Ok(script) => visitors.seats().lock().follow(script.unwrap_or_default()),
        Err(e) => return fail(BAD_INPUT, format!("--inputs {e:#}")),
    }
    match dis_socket::link_config(&args.network, &scene.network) {
        Ok(link) => {
            let senders = Senders::of(&args.network, &scene.network, &link);
            visitors.door().lock().take_only(senders);
        }
        Err(e) => return fail(BAD_INPUT, format!("{e:#}")),
    }
    let serves = serves(&visitors.seats());
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
        run_federate(
            args,
            "visitors",
            &scene,
            Box::new(visitors),
            events,
            Makes { serves, ..Makes::default() },
        )
    });
    match ended {
        Ok(code) => ExitCode::from(code),
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

/// Hears people at the seats of controllers.
fn serves(door: &SharedSeats) -> Vec<(String, Handler)> {
    let names = door.lock().seats().to_vec();
    let serve = |name: String| {
        let door = door.clone();
        let handler: Handler = Box::new(move |request: Request| {
            let answer = match decode::<SeatOrder>(&request.body) {
                Ok(order) => door.lock().ask(order, utc_ns()),
                Err(e) => SeatAnswer { text: e.to_string(), ..SeatAnswer::default() },
            };
            request.answer(encode(&answer));
        });
        (seat_key(&name), handler)
    };
    // Where there is no such seat, whoever asks for the ground hears which there are.
    let ground = (!names.iter().any(|name| name == "ground")).then(|| "ground".to_owned());
    names.into_iter().chain(ground).map(serve).collect()
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
