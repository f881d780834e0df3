//! The command lines of the five federates, as subcommands and as executables of their own.

use crate::admin_station::{self, AdminContext, summary::RunSummary};
use crate::control::Control;
use crate::exchange::operator;
use crate::external_world::ExternalWorld;
use crate::federation::{RunOptions, conductor_config, generator_name};
use crate::runtime::bus::Bus;
use crate::runtime::certs::is_loopback;
use crate::runtime::cli::out;
use crate::runtime::cli::{
    self, BAD_INPUT, CommonArgs, FAILED, NetworkArgs, fail, load_scene_without_truth,
};
use crate::runtime::dis_socket::{self, Receiving};
use crate::runtime::federate::Federate;
use crate::runtime::member::{Makers, Remake};
use crate::runtime::member_driver::{self, Event, Host, MemberContext};
use crate::runtime::messages::{Command, RunConfig};
use crate::runtime::process::{on_interrupt, while_connecting};
use crate::runtime::zenoh_bus::{ZenohBus, ZenohConfig};
use crate::smdfm::Smdfm;
use crate::traffic_generator::TrafficGenerator;
use crate::visitors::Visitors;
use clap::{Args, Subcommand};
use crossbeam_channel::{Receiver, Sender, unbounded};
use scenarios::Scene;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

/// How long a federate looks for its federation before it says what is wrong. A launcher watches the
/// processes that it started; those may take their time on a loaded host.
#[must_use]
pub fn patience() -> Duration {
    Duration::from_secs(if crate::runtime::process::launched() { 120 } else { 9 })
}

/// Traffic generator: ground truth as Entity State PDUs
#[derive(Args, Clone, Debug)]
pub struct TrafficArgs {
    #[command(flatten)]
    common: CommonArgs,

    /// Which share of the traffic, of how many generators: 2/3
    #[arg(long, value_name = "I/N", default_value = "1/1", value_parser = share_of)]
    share: (u32, u32),
}

/// External world: weather and flight data
#[derive(Args, Clone, Debug)]
pub struct WorldArgs {
    #[command(flatten)]
    common: CommonArgs,
}

/// Control: system tracks and clearances in, control alerts out, once a second
#[derive(Args, Clone, Debug)]
pub struct ControlArgs {
    #[command(flatten)]
    common: CommonArgs,
}

/// Visitors: lets the entities of other simulators in, stamped into frames
#[derive(Args, Clone, Debug)]
pub struct VisitorsArgs {
    #[command(flatten)]
    common: CommonArgs,
}

/// Sensor model and data fusion: truth and weather in, plots and system tracks out, once a second
#[derive(Args, Clone, Debug)]
pub struct SmdfmArgs {
    #[command(flatten)]
    common: CommonArgs,

    /// Say of every plot what each simulated effect did to it, on the page and in the database
    #[arg(long)]
    explain: bool,
}

/// Viewer and logger: the page, the recording, the database
#[derive(Args, Clone, Debug)]
pub struct ViewerArgs {
    #[command(flatten)]
    pub(crate) common: CommonArgs,

    /// Address and port of the page; port 0: any free one
    #[arg(long, value_name = "ADDR:PORT", default_value = super::run::DEFAULT_PAGE, value_parser = cli::page)]
    pub page: SocketAddr,

    /// Log only, no page
    #[arg(long, conflicts_with = "page")]
    pub no_page: bool,

    /// Record every datagram into this pcapng file, with the database (.sqlite) beside it [default: runs/START/run.pcapng, named by the time of the start]
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,

    /// Write a report of the run (HTML, CSV, JSON) into this folder
    #[arg(long, value_name = "DIR", value_parser = cli::report_folder)]
    pub report: Option<PathBuf>,
}

/// Administration station: configure, start, freeze, step, stop, restart, measure
#[derive(Args, Clone, Debug)]
pub struct AdminArgs {
    #[command(flatten)]
    common: CommonArgs,

    /// What to ask of a run that is going on; without it, this process is the run's administration station
    #[command(subcommand)]
    operate: Option<Operate>,

    /// Simulated seconds per wall second, 0.001 to 1000 [default: 1]
    #[arg(long, value_name = "X", value_parser = cli::rate, conflicts_with = "fast")]
    rate: Option<f64>,

    /// As fast as the slowest federate
    #[arg(long)]
    fast: bool,

    /// Simulated duration, s [default: the scene's]
    #[arg(long, value_name = "S", value_parser = cli::seconds)]
    duration: Option<f64>,

    /// Seed of all random draws [default: the scene's]
    #[arg(long, value_name = "N", value_parser = cli::seed)]
    seed: Option<u64>,

    /// Traffic generators that share the truth, 1 to 16 [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16))]
    generators: Option<u32>,

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

    #[command(flatten)]
    losses: cli::LossArgs,

    /// Write "progress FRAME/LAST" lines to stdout
    #[arg(long, hide = true)]
    progress: bool,
}

/// Operating a run.
#[derive(Subcommand, Clone, Debug)]
enum Operate {
    /// How the run stands, with application and system statistics
    Status {
        /// As one JSON object
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        at: AtArgs,
    },
    /// Start a configured run
    Start {
        #[command(flatten)]
        at: AtArgs,
    },
    /// Stop all federates at one common frame
    Freeze {
        #[command(flatten)]
        at: AtArgs,
    },
    /// Go on after a freeze
    Resume {
        #[command(flatten)]
        at: AtArgs,
    },
    /// Execute some frames, then freeze again
    Step {
        /// Frames
        #[arg(value_name = "FRAMES", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
        n: u64,
        #[command(flatten)]
        at: AtArgs,
    },
    /// Close the run
    Stop {
        #[command(flatten)]
        at: AtArgs,
    },
    /// Back to frame 0 of the same scene
    Restart {
        #[command(flatten)]
        at: AtArgs,
    },
    /// Simulated seconds per wall second
    Rate {
        /// Factor, 0.001 to 1000, or "fast"
        #[arg(value_name = "X")]
        rate: String,
        #[command(flatten)]
        at: AtArgs,
    },
    /// Print a completion script for a shell
    Completions {
        /// Shell
        shell: clap_complete::Shell,
    },
}

/// Which run to operate.
#[derive(Args, Clone, Debug)]
struct AtArgs {
    /// Endpoint of the run's administration station [default: tcp/127.0.0.1:7447]
    #[arg(long = "at", visible_alias = "sync-connect", id = "at-endpoint", value_name = "ENDPOINT", value_parser = cli::endpoint_of_another)]
    endpoint: Option<String>,
    /// DIS exercise identifier of the run, 0 to 255 [default: 1]
    #[arg(long = "exercise", id = "at-exercise", value_name = "N")]
    exercise: Option<u8>,
    /// Folder with the certificates of the federation
    #[arg(long = "certs", id = "at-certs", value_name = "DIR")]
    certs: Option<PathBuf>,
}

/// The run that a command goes to.
#[derive(Clone, Debug)]
struct Place {
    endpoint: String,
    exercise: u8,
    /// Certificates only.
    network: NetworkArgs,
}

impl Place {
    /// What stands before and after the command's word: either names the run, both must name the same one.
    fn of(args: &AdminArgs, at: &AtArgs) -> Result<Self, String> {
        if let Some(flag) = args.of_a_station() {
            return Err(format!(
                "{flag} is for starting an administration station; a command to one takes --at ENDPOINT and --exercise N"
            ));
        }
        let before = &args.common.network;
        let certs = at.certs.clone().or_else(|| before.certs.clone());
        let network = NetworkArgs { certs, ..NetworkArgs::default() };
        let named =
            one_of("--sync-connect", before.sync_connect.as_ref(), "--at", at.endpoint.as_ref())?;
        let endpoint = named.cloned().unwrap_or_else(|| network.default_endpoint());
        network.check_connecting(&endpoint).map_err(|e| e.to_string())?;
        Ok(Self {
            endpoint,
            network,
            exercise: *one_of(
                "--exercise",
                args.common.exercise.as_ref(),
                "--exercise",
                at.exercise.as_ref(),
            )?
            .unwrap_or(&1),
        })
    }
}

/// What was given before or after the command's word.
fn one_of<'a, T: PartialEq + std::fmt::Display>(
    first_flag: &str,
    first: Option<&'a T>,
    second_flag: &str,
    second: Option<&'a T>,
) -> Result<Option<&'a T>, String> {
    match (first, second) {
        (Some(a), Some(b)) if a != b => {
            Err(format!("{first_flag} {a} and {second_flag} {b} name different runs: give one"))
        }
        (a, b) => Ok(b.or(a)),
    }
}

impl AdminArgs {
    /// A flag that was given and has no meaning for a command to a run that is going on.
    fn of_a_station(&self) -> Option<&'static str> {
        let (common, network) = (&self.common, &self.common.network);
        [
            (common.scene != cli::DEFAULT_SCENE, "--scene"),
            (common.inject_loss != 0.0, "--inject-loss"),
            (network.dis.is_some(), "--dis"),
            (network.interface.is_some(), "--interface"),
            (network.ttl.is_some(), "--ttl"),
            (network.sync_listen.is_some(), "--sync-listen"),
            (self.rate.is_some(), "--rate"),
            (self.fast, "--fast"),
            (self.duration.is_some(), "--duration"),
            (self.seed.is_some(), "--seed"),
            (self.generators.is_some(), "--generators"),
            (self.batch, "--batch"),
            (self.wait, "--wait"),
            (self.expect_logger.is_some(), "--expect-logger"),
            (self.expect_gateway, "--expect-gateway"),
        ]
        .into_iter()
        .find_map(|(given, flag)| given.then_some(flag))
        .or_else(|| self.losses.given())
    }
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
pub fn traffic_generator(args: &TrafficArgs) -> ExitCode {
    let (share, of) = args.share;
    let load = |typed: &str| cli::load_scene_share(typed, share, of);
    let makes = Makes { host: Some(hosting(&args.common)), ..Makes::default() };
    member(&args.common, &generator_name(share, of), load, makes, |scene, exercise| {
        Box::new(TrafficGenerator::new(scene, exercise, share, of))
    })
}

/// The external world's process.
#[must_use]
pub fn external_world(args: &WorldArgs) -> ExitCode {
    let makes = Makes { host: Some(hosting(&args.common)), ..Makes::default() };
    member(&args.common, "external-world", load_scene_without_truth, makes, |scene, exercise| {
        Box::new(ExternalWorld::new(scene, exercise))
    })
}

/// The sensor model and data fusion module's process.
#[must_use]
pub fn smdfm(args: &SmdfmArgs) -> ExitCode {
    let (typed, exercise) = (args.common.scene.clone(), args.common.exercise);
    let remake: Remake = Box::new(move |config| make_producers(&typed, exercise, config));
    let makes = Makes { remake: Some(remake), ..Makes::default() };
    member(&args.common, "smdfm", load_scene_without_truth, makes, |scene, exercise| {
        Box::new(Smdfm::new(scene, exercise).explaining(args.explain))
    })
}

/// The process of the member `control`.
#[must_use]
pub fn control(args: &ControlArgs) -> ExitCode {
    member(&args.common, "control", load_scene_without_truth, Makes::default(), |scene, _| {
        Box::new(Control::new(scene))
    })
}

/// The process of the member `visitors`.
#[must_use]
pub fn visitors(args: &VisitorsArgs) -> ExitCode {
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

/// The producers of a run, made in this process: an SMDFM that returns makes its inputs again.
fn make_producers(scene: &str, exercise: Option<u8>, config: &RunConfig) -> Result<Makers, String> {
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

/// What a member's process can make beside its own federate.
#[derive(Default)]
struct Makes {
    remake: Option<Remake>,
    host: Option<Host>,
}

/// Takes the place of lost producers: each on a thread of its own, with connections of its own, as a process has.
fn hosting(args: &CommonArgs) -> Host {
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

/// Ctrl-C ends this process in order.
fn end_on_interrupt(events: Sender<Event>) -> anyhow::Result<()> {
    Ok(on_interrupt(move || {
        let _ = events.send(Event::Stop);
    })?)
}

fn member(
    args: &CommonArgs,
    name: &str,
    load: impl FnOnce(&str) -> Result<Scene, ExitCode>,
    makes: Makes,
    make: impl FnOnce(Arc<Scene>, u8) -> Box<dyn Federate>,
) -> ExitCode {
    crate::runtime::process::end_with_launcher();
    cli::log_to_stderr(args.log_format, "warn");
    if let Err(e) = crate::runtime::process::enough_files() {
        return fail(FAILED, e);
    }
    let scene = match load(&args.scene) {
        Ok(scene) => Arc::new(scene),
        Err(code) => return code,
    };
    match run_member(args, name, scene, makes, make) {
        Ok(code) => ExitCode::from(code),
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

fn run_member(
    args: &CommonArgs,
    name: &str,
    scene: Arc<Scene>,
    makes: Makes,
    make: impl FnOnce(Arc<Scene>, u8) -> Box<dyn Federate>,
) -> anyhow::Result<u8> {
    let exercise = args.exercise.unwrap_or(scene.run.exercise);
    let federate = make(Arc::clone(&scene), exercise);
    let events = unbounded();
    end_on_interrupt(events.0.clone())?;
    run_federate(args, name, &scene, federate, events, makes)
}

fn run_federate(
    args: &CommonArgs,
    name: &str,
    scene: &Scene,
    federate: Box<dyn Federate>,
    events: (Sender<Event>, Receiver<Event>),
    makes: Makes,
) -> anyhow::Result<u8> {
    let exercise = args.exercise.unwrap_or(scene.run.exercise);
    let receiving = Receiving {
        exercise,
        site: scene.run.site,
        consumes: federate.reads_pdus(),
        loss: args.inject_loss,
    };
    let data = dis_socket::open(&args.network, &scene.network, receiving, events.0.clone())?;
    let (bus, endpoint) = open_bus(&args.network, &scene.network, exercise, name)?;
    let context = MemberContext {
        name: name.to_owned(),
        scene_hash: scene.hash,
        bus,
        data,
        events,
        endpoint,
        patience: patience(),
        remake: makes.remake,
        host: makes.host,
    };
    Ok(member_driver::run(context, federate)?)
}

/// A member's end of the synchronisation plane, and the endpoint that it connects to.
///
/// # Errors
/// If the administration station cannot be reached within the patience.
pub fn open_bus(
    args: &NetworkArgs,
    scene: &scenarios::Network,
    exercise: u8,
    name: &str,
) -> anyhow::Result<(Arc<dyn Bus>, String)> {
    let connect = match (&args.sync_connect, scene.sync_connect.first()) {
        (Some(endpoint), _) | (None, Some(endpoint)) => endpoint.clone(),
        (None, None) => args.default_endpoint(),
    };
    args.check_connecting(&connect)?;
    let transport = if args.certs.is_some() { "tls" } else { "tcp" };
    let listen = match (&args.sync_listen, is_loopback(&connect)) {
        (Some(endpoint), _) => endpoint.clone(),
        (None, true) => format!("{transport}/127.0.0.1:0"),
        (None, false) => match args.interface {
            Some(ip) => format!("{transport}/{}", SocketAddr::new(ip, 0)),
            None => format!("{transport}/0.0.0.0:0"),
        },
    };
    args.check_listening(&listen)?;
    let config = ZenohConfig {
        listen: vec![listen],
        connect: vec![connect.clone()],
        exercise,
        connect_timeout: patience(),
        certs: args.certs_of(name)?,
    };
    Ok((Arc::new(while_connecting(|| ZenohBus::open(&config))?), connect))
}

/// The viewer-logger's process.
#[must_use]
pub fn viewer_logger(args: &ViewerArgs) -> ExitCode {
    crate::runtime::process::end_with_launcher();
    cli::log_to_stderr(args.common.log_format, "warn");
    if let Err(e) = crate::runtime::process::enough_files() {
        return fail(FAILED, e);
    }
    let scene = match load_scene_without_truth(&args.common.scene) {
        Ok(scene) => Arc::new(scene),
        Err(code) => return code,
    };
    match super::viewer_process::run(args, scene) {
        Ok(code) => ExitCode::from(code),
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

/// The administration station's process, or a command to one.
#[must_use]
pub fn admin_station(args: &AdminArgs) -> ExitCode {
    if let Some(operate) = &args.operate {
        return operate_run(args, operate);
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
fn listen_to_launcher(events: Sender<admin_station::Event>) {
    if !crate::runtime::process::launched() {
        return;
    }
    std::thread::spawn(move || {
        for line in std::io::stdin().lines().map_while(Result::ok) {
            if line == NO_LOGGER {
                let _ = events.send(admin_station::Event::NoSpectators);
            }
        }
    });
}

/// What a launcher tells the administration station on its standard input.
pub const NO_LOGGER: &str = "no viewer-logger";

fn run_admin(args: &AdminArgs, scene: &Arc<Scene>) -> anyhow::Result<u8> {
    let exercise = args.common.exercise.unwrap_or(scene.run.exercise);
    let options = RunOptions {
        seed: args.seed,
        duration_s: args.duration,
        rate: if args.fast { f64::INFINITY } else { args.rate.unwrap_or(1.0) },
        generators: args.generators.unwrap_or(1),
        autostart: !args.wait,
        batch: args.batch,
        visitors: args.visitors,
        losses: args.losses.losses(),
    };
    let mut config = conductor_config(scene, &options);
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
        config.await_spectators.push(crate::gateway::process::NAME.to_owned());
        config.await_spectators_ns = config.await_spectators_ns.max(10_000_000_000);
    }
    let stop = events.0.clone();
    on_interrupt(move || {
        let _ = stop.send(admin_station::Event::Stop);
    })?;
    let network = &args.common.network;
    let listen = match (&network.sync_listen, scene.network.sync_listen.first()) {
        (Some(endpoint), _) | (None, Some(endpoint)) => endpoint.clone(),
        (None, None) => network.default_endpoint(),
    };
    network.check_listening(&listen)?;
    if network.open && !is_loopback(&listen) {
        tracing::warn!("{listen} is open: everybody who reaches it can command this run");
    }
    let bus = ZenohBus::open(&ZenohConfig {
        listen: vec![listen],
        connect: vec![],
        exercise,
        connect_timeout: patience(),
        certs: network.certs_of("admin-station")?,
    })?;
    let gateway = admin_station::simman::Gateway::open(
        network,
        scene,
        exercise,
        config.seed,
        events.0.clone(),
    )?;
    let (name, step_ns) = (scene.name.clone(), scene.run.frame.0);
    Ok(admin_station::run(AdminContext {
        bus: Arc::new(bus),
        config,
        events,
        reached: gateway.announcer(),
        closed: Box::new(move |run| print_line(&RunSummary::of(run, &name, step_ns).line())),
        progress: args.progress.then(|| {
            Box::new(|frame, last| print_line(&format!("progress frame {frame} of {last}")))
                as Box<dyn FnMut(u64, u64) + Send>
        }),
        // It says after ten seconds whom it awaits, and gives them time to be started.
        patience: Duration::from_secs(120),
    })?)
}

fn print_line(line: &str) {
    out!("{line}");
}

fn operate_run(args: &AdminArgs, operate: &Operate) -> ExitCode {
    let (command, at) = match operate {
        Operate::Completions { shell } => {
            use clap::CommandFactory;
            #[derive(clap::Parser)]
            #[command(name = "admin-station")]
            struct Admin {
                #[command(flatten)]
                args: AdminArgs,
            }
            clap_complete::generate(
                *shell,
                &mut Admin::command(),
                "admin-station",
                &mut std::io::stdout(),
            );
            return ExitCode::SUCCESS;
        }
        Operate::Status { at, json } => {
            return match Place::of(args, at) {
                Ok(place) => status(&place, *json),
                Err(e) => fail(BAD_INPUT, e),
            };
        }
        Operate::Start { at } | Operate::Resume { at } => (Command::Start, at),
        Operate::Freeze { at } => (Command::Freeze, at),
        Operate::Step { n, at } => (Command::Step { n: *n }, at),
        Operate::Stop { at } => (Command::Stop, at),
        Operate::Restart { at } => (Command::Restart, at),
        Operate::Rate { rate, at } => {
            let rate = if rate == "fast" { Ok(f64::INFINITY) } else { cli::rate(rate) };
            match rate {
                Ok(rate) => (Command::Rate { rate }, at),
                Err(e) => return fail(BAD_INPUT, format!("{e}, nor \"fast\"")),
            }
        }
    };
    let place = match Place::of(args, at) {
        Ok(place) => place,
        Err(e) => return fail(BAD_INPUT, e),
    };
    let answer = operator_bus(&place).and_then(|bus| {
        let answer = operator::command(&bus, &place.endpoint, "terminal", command);
        bus.close();
        Ok(answer?)
    });
    match answer {
        Ok(answer) if answer.ok => {
            print_line(&answer.text);
            ExitCode::SUCCESS
        }
        Ok(answer) => fail(FAILED, answer.text),
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

fn operator_bus(at: &Place) -> anyhow::Result<ZenohBus> {
    Ok(ZenohBus::open(&ZenohConfig {
        listen: vec![],
        connect: vec![at.endpoint.clone()],
        exercise: at.exercise,
        connect_timeout: Duration::from_secs(3),
        certs: at.network.certs_of("operator")?,
    })?)
}

fn status(at: &Place, json: bool) -> ExitCode {
    let statistics = operator_bus(at).and_then(|bus| {
        let statistics = operator::statistics(&bus, &at.endpoint);
        bus.close();
        Ok(statistics?)
    });
    match statistics {
        Ok(statistics) if json => print_line(&statistics.to_string()),
        Ok(statistics) => print_line(&operator::table(&statistics)),
        Err(e) => return fail(FAILED, format!("{e:#}")),
    }
    ExitCode::SUCCESS
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Admin {
        #[command(flatten)]
        args: AdminArgs,
    }

    fn place(line: &str) -> Result<Place, String> {
        let words = ["admin-station"].into_iter().chain(line.split_whitespace());
        let args = Admin::try_parse_from(words).map_err(|e| e.to_string())?.args;
        match args.operate.as_ref().expect("a command") {
            Operate::Freeze { at } | Operate::Status { at, .. } => Place::of(&args, at),
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
