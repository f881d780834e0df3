//! The command line of the administration station, and its process.

use super::operate::{Operate, operate_run};
use super::simman::Gateway;
use super::{
    AdminContext, Event, PhaseHook, STANDBY, STATION, Succeeds, standby, summary::RunSummary,
};
use crate::federation::{GATEWAY, MOST_SMDFMS, RunOptions, conductor_config};
use crate::runtime::bus::Bus;
use crate::runtime::certs::is_loopback;
use crate::runtime::cli::{
    self, BAD_INPUT, CommonArgs, FAILED, fail, load_scene_without_truth, print_line,
};
use crate::runtime::conductor::ConductorConfig;
use crate::runtime::member_process::{open_bus, patience};
use crate::runtime::process::{NO_LOGGER, REACHED, launched, on_interrupt, on_termination};
use crate::runtime::zenoh_bus::{Part, ZenohBus, ZenohConfig};
use clap::{Args, CommandFactory, Subcommand};
use crossbeam_channel::{Receiver, Sender, unbounded};
use scenarios::Scene;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

/// Administration station: configure, start, freeze, step, stop, restart, measure
#[derive(Args, Clone, Debug)]
pub struct AdminArgs {
    #[command(flatten)]
    common: CommonArgs,

    /// What to ask of a run that is going on; without it, this process is the run's administration station
    #[command(subcommand)]
    operate: Option<AdminCommand>,

    /// Simulated seconds per wall second, 0.001 to 1000 [default: 1]
    #[arg(long, value_name = "X", value_parser = cli::rate, conflicts_with = "fast")]
    rate: Option<f64>,

    /// As fast as the slowest federate
    #[arg(long)]
    fast: bool,

    /// Simulated duration, s [default: the scene's]
    #[arg(long, value_name = "S", value_parser = cli::seconds)]
    duration: Option<f64>,

    /// Seed of all random draws but the flights of a generated demand, which the scene's seeds draw [default: the scene's]
    #[arg(long, value_name = "N", value_parser = cli::seed)]
    seed: Option<u64>,

    /// Traffic generators that share the truth, 1 to 16 [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16))]
    generators: Option<u32>,

    /// SMDFMs that share the sensors, 1 to 8: the first fuses the plots of all [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SMDFMS)))]
    smdfms: Option<u32>,

    /// End the federation with the run
    #[arg(long)]
    batch: bool,

    /// Do not start by itself: wait CONFIGURED for a start command
    #[arg(long)]
    wait: bool,

    /// Wait up to S seconds for a viewer-logger when all others are ready, so that its log is complete
    #[arg(long, value_name = "S", num_args = 0..=1, require_equals = true, default_missing_value = "2", value_parser = cli::seconds)]
    expect_logger: Option<f64>,

    /// Let outsiders' entities in: the federation has a member `visitors`
    #[arg(long)]
    visitors: bool,

    /// Wait up to 10 s for a gateway before the run begins, so that what it sends is complete
    #[arg(long)]
    expect_gateway: bool,

    /// Keep what this station is told in FILE: started again by the same command line after its process died, it goes on with the run.
    /// The file is removed when the run is over. In a folder each run has a file of its own
    #[arg(long, value_name = "FILE|DIR")]
    journal: Option<PathBuf>,

    /// Be the standby of the administration station at --sync-connect, which runs with --journal: hold its journal (in the file of this
    /// one's --journal) and lead its run on if it is lost. Scene, seed and flags are to be the same
    #[arg(long, requires = "journal", conflicts_with = "progress")]
    standby: bool,

    /// Leave the run to the next station with this journal when a launcher that dies ends this process
    #[arg(long, hide = true, requires = "journal")]
    leave: bool,

    #[command(flatten)]
    losses: cli::LossArgs,

    /// Write "progress FRAME/LAST" lines to stdout
    #[arg(long, hide = true)]
    progress: bool,
}

#[derive(Subcommand, Clone, Debug)]
enum AdminCommand {
    #[command(flatten)]
    Operate(Operate),
    /// Print a completion script for a shell
    Completions {
        /// Shell
        shell: clap_complete::Shell,
    },
}

/// The whole command line, for completions.
#[derive(clap::Parser)]
#[command(name = "admin-station")]
struct Admin {
    #[command(flatten)]
    args: AdminArgs,
}

impl AdminArgs {
    /// Refuses flags that have no meaning for a command to a run that is going on.
    fn only_operates(&self) -> Result<(), String> {
        match self.of_a_station() {
            None => Ok(()),
            Some(flag) => Err(format!(
                "{flag} is for starting an administration station; a command to one takes --at ENDPOINT and --exercise N"
            )),
        }
    }

    /// A flag that was given and has no meaning for a command to a run that is going on.
    fn of_a_station(&self) -> Option<&'static str> {
        let (common, network) = (&self.common, &self.common.network);
        [
            (common.scene != cli::DEFAULT_SCENE, "--scene"),
            (common.inject_loss != 0.0, "--inject-loss"),
            (network.dis.is_some(), "--dis"),
            (network.interface.is_some(), "--interface"),
            (network.ttl.is_some(), "--ttl"),
            (!network.dis_from.is_empty(), "--dis-from"),
            (!network.dis_sites.is_empty(), "--dis-sites"),
            (!network.dis_managers.is_empty(), "--dis-managers"),
            (network.sync_listen.is_some(), "--sync-listen"),
            (network.sync_router.is_some(), "--sync-router"),
            (self.rate.is_some(), "--rate"),
            (self.fast, "--fast"),
            (self.duration.is_some(), "--duration"),
            (self.seed.is_some(), "--seed"),
            (self.generators.is_some(), "--generators"),
            (self.smdfms.is_some(), "--smdfms"),
            (self.batch, "--batch"),
            (self.wait, "--wait"),
            (self.expect_logger.is_some(), "--expect-logger"),
            (self.expect_gateway, "--expect-gateway"),
            (self.journal.is_some(), "--journal"),
            (self.standby, "--standby"),
        ]
        .into_iter()
        .find_map(|(given, flag)| given.then_some(flag))
        .or_else(|| self.losses.given())
    }
}

/// The administration station's process, or a command to one.
#[must_use]
pub fn run(args: &AdminArgs) -> ExitCode {
    if let Some(operate) = &args.operate {
        return match operate {
            AdminCommand::Completions { shell } => {
                clap_complete::generate(
                    *shell,
                    &mut Admin::command(),
                    "admin-station",
                    &mut std::io::stdout(),
                );
                ExitCode::SUCCESS
            }
            AdminCommand::Operate(operate) => match args.only_operates() {
                Ok(()) => operate_run(&args.common, operate),
                Err(e) => fail(BAD_INPUT, e),
            },
        };
    }
    crate::runtime::process::end_with_launcher();
    cli::log_to_stderr(args.common.log_format, "info");
    if let Err(e) = crate::runtime::process::enough_files() {
        return fail(FAILED, e);
    }
    let scene = match load_scene_without_truth(&args.common.scene) {
        Ok(scene) => Arc::new(scene),
        Err(code) => return code,
    };
    match run_admin(args, &scene) {
        Ok(code) => ExitCode::from(code),
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

/// A launcher says on standard input when the viewer-logger that it started will not come.
fn listen_to_launcher(events: Sender<Event>) {
    if !launched() {
        return;
    }
    std::thread::spawn(move || {
        for line in std::io::stdin().lines().map_while(Result::ok) {
            if line == NO_LOGGER {
                let _ = events.send(Event::NoSpectators);
            }
        }
    });
}

fn run_admin(args: &AdminArgs, scene: &Arc<Scene>) -> anyhow::Result<u8> {
    let exercise = args.common.exercise.unwrap_or(scene.run.exercise);
    let options = RunOptions {
        seed: args.seed,
        duration_s: args.duration,
        rate: if args.fast { f64::INFINITY } else { args.rate.unwrap_or(1.0) },
        generators: args.generators.unwrap_or(1),
        smdfms: args.smdfms.unwrap_or(1),
        autostart: !args.wait,
        batch: args.batch,
        visitors: args.visitors,
        losses: args.losses.losses(),
    };
    let mut config = conductor_config(scene, &options);
    config.through_router = args.common.network.sync_router.is_some();
    args.losses.check_balance(&config.losses).map_err(anyhow::Error::msg)?;
    let events = unbounded();
    if let Some(within_s) = args.expect_logger {
        config.await_spectators.push("viewer-logger".to_owned());
        let within_ns = (within_s * 1e9) as u64;
        config.await_spectators_ns = match args.visitors {
            true => config.await_spectators_ns.max(within_ns),
            false => within_ns,
        };
        listen_to_launcher(events.0.clone());
    }
    if args.expect_gateway {
        config.await_spectators.push(GATEWAY.to_owned());
        config.await_spectators_ns = config.await_spectators_ns.max(10_000_000_000);
    }
    if args.journal.is_some() && (args.leave || !launched()) {
        // Who ends a process of a host, not a run: the next one with this journal goes on.
        let leave = events.0.clone();
        on_termination(move || {
            let _ = leave.send(Event::Leave);
        })?;
    }
    let stop = events.0.clone();
    on_interrupt(move || {
        let _ = stop.send(Event::Stop);
    })?;
    let network = &args.common.network;
    if let Some(journal) = args.journal.as_ref().filter(|_| args.standby) {
        let (bus, endpoint) = open_bus(network, &scene.network, exercise, STANDBY)?;
        let at = (&**journal, &endpoint[..]);
        let Some(succeeds) = standby::follow(&*bus, &config, at, &events.1)? else { return Ok(0) };
        let lead = Leading { bus, name: STANDBY, succeeds: Some(succeeds) };
        return lead_run(args, scene, exercise, config, events, lead);
    }
    let (mut listen, mut connect) = (Vec::new(), Vec::new());
    if let Some(router) = &network.sync_router {
        network.check_connecting(router)?;
        connect.push(router.clone());
    } else {
        let endpoint = match (&network.sync_listen, scene.network.sync_listen.first()) {
            (Some(endpoint), _) | (None, Some(endpoint)) => endpoint.clone(),
            (None, None) => network.default_endpoint(),
        };
        network.check_listening(&endpoint)?;
        if network.open && !is_loopback(&endpoint) {
            tracing::warn!("{endpoint} is open: everybody who reaches it can command this run");
        }
        listen.push(endpoint);
    }
    let bus = ZenohBus::open(&ZenohConfig {
        part: if connect.is_empty() { Part::Peer } else { Part::Client },
        listen,
        connect,
        exercise,
        connect_timeout: patience(),
        certs: network.certs_of("admin-station")?,
    })?;
    let lead = Leading { bus: Arc::new(bus), name: STATION, succeeds: None };
    lead_run(args, scene, exercise, config, events, lead)
}

/// A station that leads.
struct Leading {
    bus: Arc<dyn Bus>,
    name: &'static str,
    succeeds: Option<Box<Succeeds>>,
}

fn lead_run(
    args: &AdminArgs,
    scene: &Arc<Scene>,
    exercise: u8,
    config: ConductorConfig,
    events: (Sender<Event>, Receiver<Event>),
    lead: Leading,
) -> anyhow::Result<u8> {
    let network = &args.common.network;
    let gateway = Gateway::open(network, scene, exercise, config.seed, events.0.clone())?;
    let (name, step_ns) = (scene.name.clone(), scene.run.frame.0);
    let (stated, refused) = (gateway.listener(), gateway.refused());
    Ok(super::run(AdminContext {
        bus: lead.bus,
        name: lead.name,
        succeeds: lead.succeeds,
        config,
        events,
        reached: told_to_launcher(gateway.announcer()),
        stated,
        closed: Box::new(move |run| print_line(&RunSummary::of(run, &name, step_ns).line())),
        progress: args.progress.then(|| {
            Box::new(|frame, last| print_line(&format!("progress frame {frame} of {last}")))
                as Box<dyn FnMut(u64, u64) + Send>
        }),
        // It says after ten seconds whom it awaits, and gives them time to be started.
        patience: Duration::from_secs(120),
        journal: args.journal.clone(),
        balance: args.losses.balance,
        refused,
    })?)
}

/// A launcher is told of each phase that is reached: it starts a process again by where the run stands.
fn told_to_launcher(mut announce: PhaseHook) -> PhaseHook {
    if !launched() {
        return announce;
    }
    Box::new(move |phase, frame, why| {
        print_line(&format!("{REACHED} {phase}"));
        announce(phase, frame, why);
    })
}

#[cfg(test)]
mod tests {
    use super::super::operate::Place;
    use super::*;
    use clap::Parser;

    fn place(line: &str) -> Result<Place, String> {
        let words = ["admin-station"].into_iter().chain(line.split_whitespace());
        let args = Admin::try_parse_from(words).map_err(|e| e.to_string())?.args;
        args.only_operates()?;
        match args.operate.as_ref().expect("a command") {
            AdminCommand::Operate(Operate::Freeze { at } | Operate::Status { at, .. }) => {
                Place::of(&args.common, at)
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_command_goes_to_the_run_that_was_named_wherever_it_was_named() {
        for (line, endpoint, exercise) in [
            ("freeze", "tcp/127.0.0.1:7447", 1),
            ("--certs /c freeze", "tls/127.0.0.1:7447", 1),
            ("freeze --at tls/10.0.0.1:9 --certs /c", "tls/10.0.0.1:9", 1),
            ("--sync-connect tcp/10.0.0.1:9 freeze", "tcp/10.0.0.1:9", 1),
            ("freeze --at tcp/10.0.0.1:9", "tcp/10.0.0.1:9", 1),
            ("freeze --sync-connect tcp/10.0.0.1:9 --exercise 4", "tcp/10.0.0.1:9", 4),
            ("--exercise 4 status --at tcp/10.0.0.1:9", "tcp/10.0.0.1:9", 4),
            ("--sync-connect tcp/10.0.0.1:9 freeze --at tcp/10.0.0.1:9", "tcp/10.0.0.1:9", 1),
        ] {
            let place = place(line).unwrap_or_else(|e| panic!("{line}: {e}"));
            assert_eq!((&place.endpoint[..], place.exercise), (endpoint, exercise), "{line}");
        }
    }

    #[test]
    fn two_runs_or_a_flag_without_meaning_are_refused() {
        for (line, words) in [
            ("--sync-connect tcp/10.0.0.1:9 freeze --at tcp/10.0.0.1:8", "name different runs"),
            ("--exercise 3 freeze --exercise 4", "name different runs"),
            ("--rate 2 freeze", "--rate is for starting"),
            ("--sync-listen tcp/127.0.0.1:9 freeze", "--sync-listen is for starting"),
            ("--scene x.toml --fast status", "--scene is for starting"),
            ("freeze --at tcp/127.0.0.1:0", "port 0"),
            ("freeze --at tls/127.0.0.1:9", "needs certificates"),
            ("freeze --at tcp/127.0.0.1:9 --certs /c", "the endpoint is tls/127.0.0.1:9"),
            ("freeze --at udp/127.0.0.1:9", "tls/ADDRESS:PORT only"),
        ] {
            let refused = place(line).expect_err(line);
            assert!(refused.contains(words), "{line}: {refused}");
        }
    }
}
