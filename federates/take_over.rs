//! Producers made in the process of another member: for an SMDFM that returns, in the place of one that is lost.

use crate::external_world::ExternalWorld;
use crate::federation::generator_name;
use crate::runtime::cli::CommonArgs;
use crate::runtime::federate::Federate;
use crate::runtime::member::Makers;
use crate::runtime::member_driver::Host;
use crate::runtime::member_process::{Makes, run_federate};
use crate::runtime::messages::RunConfig;
use crate::traffic_generator::TrafficGenerator;
use crossbeam_channel::unbounded;
use std::sync::Arc;

/// The producers of a run, made in this process: an SMDFM that returns makes its inputs again.
pub(crate) fn make_producers(
    scene: &str,
    exercise: Option<u8>,
    config: &RunConfig,
) -> Result<Makers, String> {
    let scene = scenarios::load(&scenarios::locate(scene)).map_err(|e| e.to_string())?;
    let (scene, of) = (Arc::new(scene), config.generators);
    let exercise = exercise.unwrap_or(scene.run.exercise);
    let mut makers = Makers::new();
    for share in 1..=of {
        let generator = TrafficGenerator::new(Arc::clone(&scene), exercise, share, of);
        makers.insert(generator_name(share, of), Box::new(generator));
    }
    makers.insert("external-world".into(), Box::new(ExternalWorld::new(scene, exercise)));
    Ok(makers)
}

/// Takes the place of lost producers: each on a thread of its own, with connections of its own, as a process has.
pub(crate) fn hosting(args: &CommonArgs) -> Host {
    let args = args.clone();
    Box::new(move |name, generators| {
        let (args, name) = (args.clone(), name.to_owned());
        std::thread::spawn(move || {
            if let Err(e) = take_over(&args, &name, generators) {
                tracing::warn!("{name} was not taken over: {e:#}");
            }
        });
    })
}

fn take_over(args: &CommonArgs, name: &str, generators: u32) -> anyhow::Result<u8> {
    let path = scenarios::locate(&args.scene);
    let share = (1..=generators).find(|share| generator_name(*share, generators) == name);
    let scene = Arc::new(match share {
        Some(share) => scenarios::load_share(&path, share, generators)?,
        None => scenarios::load_without_truth(&path)?,
    });
    let exercise = args.exercise.unwrap_or(scene.run.exercise);
    let federate: Box<dyn Federate> = match share {
        Some(share) => {
            Box::new(TrafficGenerator::new(Arc::clone(&scene), exercise, share, generators))
        }
        None => Box::new(ExternalWorld::new(Arc::clone(&scene), exercise)),
    };
    run_federate(args, name, &scene, federate, unbounded(), Makes::default())
}
