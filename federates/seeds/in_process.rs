//! `seeds run --in-process`: the same federates on threads, over a bus and an ether in memory.

use super::run_args::RunArgs;
use crate::admin_station::{self, AdminContext, summary::RunSummary};
use crate::control::Control;
use crate::external_world::ExternalWorld;
use crate::federation::{conductor_config, generator_name, has_control, smdfm_name};
use crate::runtime::cli::print_line;
use crate::runtime::data_plane::LocalEther;
use crate::runtime::dis_socket::{Receiving, Sorter};
use crate::runtime::federate::Federate;
use crate::runtime::local_bus::LocalHub;
use crate::runtime::member_driver::{self, Event, MemberContext};
use crate::smdfm::Smdfm;
use crate::smdfm::front_end::FrontEnd;
use crate::traffic_generator::TrafficGenerator;
use crate::visitors::Visitors;
use crate::visitors::seats::read_inputs;
use crossbeam_channel::{Sender, unbounded};
use scenarios::Scene;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Refuses what only processes can do.
///
/// # Errors
/// If a recording, a report or the gateway was asked for.
pub fn check(args: &RunArgs) -> anyhow::Result<()> {
    anyhow::ensure!(
        args.record.is_none() && args.report.is_none(),
        "--in-process has no data plane that could be recorded: leave out --record and --report, or --in-process"
    );
    let given: Vec<&str> = args.asterix.given().collect();
    anyhow::ensure!(
        given.is_empty(),
        "--in-process has no gateway: leave out {}, or --in-process",
        given.join(" and ")
    );
    Ok(())
}

/// Runs the federation in this process; prints the summary line; returns the exit code.
///
/// # Errors
/// If the run fails.
pub fn run(args: &RunArgs, scene: &Scene) -> anyhow::Result<u8> {
    let (scene, mut line) = (Arc::new(scene.clone()), None);
    let interrupt = Interrupt::heard();
    let code = federation(args, &scene, &interrupt, |summary| line = Some(summary.line()))?;
    if let Some(line) = line {
        print_line(&line);
    }
    Ok(code)
}

/// Whether somebody wants an end, for all runs of this process: a process has one handler, and a run after another hears it, too.
#[derive(Clone, Debug, Default)]
pub struct Interrupt {
    asked: Arc<AtomicBool>,
    /// The run that goes on.
    run: Arc<Mutex<Option<Sender<admin_station::Event>>>>,
}

impl Interrupt {
    /// Hears Ctrl-C from now on. Where the process has a handler already (tests), that one is kept.
    #[must_use]
    pub fn heard() -> Self {
        let interrupt = Self::default();
        let own = interrupt.clone();
        let _ = ctrlc::set_handler(move || own.ask());
        interrupt
    }

    /// Ends the run that goes on.
    pub fn ask(&self) {
        self.asked.store(true, Ordering::SeqCst);
        let run = self.run.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(stop) = &*run {
            let _ = stop.send(admin_station::Event::Stop);
        }
    }

    /// Whether an end was asked for.
    #[must_use]
    pub fn asked(&self) -> bool {
        self.asked.load(Ordering::SeqCst)
    }

    /// From now on this is the run that goes on.
    fn reaches(&self, stop: Sender<admin_station::Event>) {
        *self.run.lock().unwrap_or_else(PoisonError::into_inner) = Some(stop);
        if self.asked() {
            self.ask(); // between the last run and this one
        }
    }
}

/// Runs a federation on threads of this process and hands over the summary of each closed run.
///
/// # Errors
/// If a federate or the bus fails.
pub fn federation(
    args: &RunArgs,
    scene: &Arc<Scene>,
    interrupt: &Interrupt,
    mut closed: impl FnMut(RunSummary),
) -> anyhow::Result<u8> {
    let exercise = args.exercise.unwrap_or(scene.run.exercise);
    let (hub, ether) = (LocalHub::default(), LocalEther::default());
    let admin_events = unbounded();
    interrupt.reaches(admin_events.0.clone());
    let mut federates: Vec<(String, Box<dyn Federate>)> = (1..=args.generators)
        .map(|share| {
            let generator =
                TrafficGenerator::new(Arc::clone(scene), exercise, share, args.generators);
            (generator_name(share, args.generators), Box::new(generator) as Box<dyn Federate>)
        })
        .collect();
    federates
        .push(("external-world".into(), Box::new(ExternalWorld::new(Arc::clone(scene), exercise))));
    federates.push((smdfm_name(1), Box::new(Smdfm::new(Arc::clone(scene), exercise))));
    for share in 2..=args.smdfms {
        let front_end = FrontEnd::new(Arc::clone(scene), exercise, share, args.smdfms);
        federates.push((smdfm_name(share), Box::new(front_end)));
    }
    if has_control(scene) {
        federates.push(("control".into(), Box::new(Control::new(Arc::clone(scene), exercise))));
    }
    if let Some(file) = &args.inputs {
        let visitors = Visitors::new(Arc::clone(scene), exercise);
        visitors.seats().lock().follow(read_inputs(file, scene)?);
        federates.push(("visitors".into(), Box::new(visitors)));
    }
    let mut threads = Vec::new();
    for (name, federate) in federates {
        let events = unbounded();
        if federate.reads_pdus() {
            let to = events.0.clone();
            let mut sorter = Sorter::new(Receiving {
                exercise,
                site: scene.run.site,
                consumes: true,
                loss: args.inject_loss,
            });
            ether.listen(Box::new(move |arrivals| {
                let mut pdus = Vec::new();
                arrivals.iter().for_each(|a| sorter.sort(&a.octets, &mut pdus));
                let _ = to.send(Event::Pdus(pdus));
                for (reason, count) in sorter.take_drops() {
                    let _ = to.send(Event::Dropped(reason, count));
                }
            }));
        }
        let context = MemberContext {
            name: name.clone(),
            scene_hash: scene.hash,
            bus: Arc::new(hub.join()),
            data: Box::new(ether.clone()),
            events,
            endpoint: "this process".into(),
            patience: Duration::from_secs(5),
            // Threads of one process are lost together or not at all.
            remake: None,
            host: None,
        };
        let thread = std::thread::Builder::new().name(name);
        threads.push(thread.spawn(move || member_driver::run(context, federate))?);
    }
    let mut options = args.options();
    options.batch = true;
    let summaries = Arc::new(Mutex::new(Vec::new()));
    let (kept, name, step_ns) = (Arc::clone(&summaries), scene.name.clone(), scene.run.frame.0);
    let code = admin_station::run(AdminContext {
        name: admin_station::STATION,
        succeeds: None,
        journal: None,
        balance: false,
        refused: Arc::default(),
        bus: Arc::new(hub.join()),
        config: conductor_config(scene, &options),
        events: admin_events,
        reached: Box::new(|_, _, _| {}),
        stated: Box::new(|_| {}),
        closed: Box::new(move |run| {
            let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
            kept.push(RunSummary::of(run, &name, step_ns));
        }),
        progress: None,
        patience: Duration::from_secs(5),
    })?;
    for thread in threads {
        match thread.join() {
            Ok(Ok(_)) => {}
            Ok(Err(e)) => return Err(e.into()),
            Err(_) => anyhow::bail!("a federate's thread ended by a broken invariant"),
        }
    }
    for summary in summaries.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
        closed(summary);
    }
    Ok(code)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interrupt_reaches_the_run_that_goes_on_also_the_second_of_a_process() {
        let interrupt = Interrupt::default();
        let stopped = |events: &crossbeam_channel::Receiver<admin_station::Event>| {
            events.try_iter().filter(|e| matches!(e, admin_station::Event::Stop)).count()
        };
        let (first, second, third) = (unbounded(), unbounded(), unbounded());
        interrupt.reaches(first.0);
        interrupt.reaches(second.0);
        assert!(!interrupt.asked() && stopped(&second.1) == 0);
        interrupt.ask();
        assert!(interrupt.asked());
        assert_eq!((stopped(&first.1), stopped(&second.1)), (0, 1));
        interrupt.reaches(third.0);
        assert_eq!(stopped(&third.1), 1, "it was asked for before this one began");
    }
}
