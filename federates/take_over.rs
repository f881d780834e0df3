//! Producers made in the process of another member: for an SMDFM that returns, in the place of one that is lost.

use crate::external_world::ExternalWorld;
use crate::federation::generator_name;
use crate::runtime::cli::CommonArgs;
use crate::runtime::federate::Federate;
use crate::runtime::member::Makers;
use crate::runtime::member_driver::{Host, MemberError};
use crate::runtime::member_process::{Hosted, Makes, run_federate};
use crate::runtime::messages::{Kind, RunConfig};
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

/// Whether a lost member is made in another's process: generators and the external world, who need nothing but the scene.
fn is_hosted(name: &str, generators: u32) -> bool {
    name == Kind::ExternalWorld.name()
        || (1..=generators).any(|share| generator_name(share, generators) == name)
}

/// Takes the place of lost producers: each on a thread of its own, with connections of its own, as a process has. Not of others:
/// control is started again by whoever started it.
pub(crate) fn hosting(args: &CommonArgs) -> Makes {
    let (args, hosted) = (args.clone(), Hosted::default());
    let threads = hosted.clone();
    let host: Host = Box::new(move |name, generators| {
        if !is_hosted(name, generators) {
            return false;
        }
        let (args, name) = (args.clone(), name.to_owned());
        threads.start(move || match take_over(&args, &name, generators) {
            Err(e) if matches!(e.downcast_ref(), Some(MemberError::Yielded { .. })) => {
                tracing::warn!("{e}");
            }
            Err(e) => tracing::warn!("{name} was not taken over: {e:#}"),
            Ok(_) => {}
        });
        true
    });
    Makes { host: Some(host), hosted, ..Makes::default() }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Control produces notices, too, and an external world was made under its name: refused by its digest, after a warning
    /// that named another build, scene or input.
    #[test]
    fn only_generators_and_the_external_world_are_made_in_another_process() {
        for (name, generators, hosted) in [
            ("external-world", 1, true),
            (&generator_name(1, 1), 1, true),
            (&generator_name(3, 4), 4, true),
            ("control", 1, false),
            ("visitors", 2, false),
            ("smdfm", 1, false),
        ] {
            assert_eq!(is_hosted(name, generators), hosted, "{name}");
        }
    }
}
