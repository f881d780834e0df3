//! A member as a process of its own: its end of both planes, its patience, how it ends.

use super::bus::{Bus, Request};
use super::certs::is_loopback;
use super::cli::{self, COMPLETE, CommonArgs, FAILED, NetworkArgs, fail};
use super::dis_socket::{self, Receiving};
use super::federate::Federate;
use super::member::Remake;
use super::member_driver::{self, Event, Host, MemberContext, MemberError};
use super::process::{on_interrupt, while_connecting};
use super::zenoh_bus::{Part, ZenohBus, ZenohConfig};
use crossbeam_channel::{Receiver, Sender, unbounded};
use scenarios::Scene;
use std::net::SocketAddr;
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// How long a federate looks for its federation before it says what is wrong. A launcher watches the
/// processes that it started; those may take their time on a loaded host.
#[must_use]
pub fn patience() -> Duration {
    Duration::from_secs(if crate::runtime::process::launched() { 120 } else { 9 })
}

/// Answers requests of others.
pub(crate) type Handler = Box<dyn Fn(Request) + Send + Sync>;

/// What a member's process can make beside its own federate.
#[derive(Default)]
pub(crate) struct Makes {
    /// Producers made here for one that returns.
    pub(crate) remake: Option<Remake>,
    /// Takes the place of lost producers.
    pub(crate) host: Option<Host>,
    /// Those that it has taken.
    pub(crate) hosted: Hosted,
    /// Requests that it answers beside those of every member, by key.
    pub(crate) serves: Vec<(String, Handler)>,
}

/// Members beside the one that a process was started for, each on its thread.
#[derive(Clone, Default)]
pub(crate) struct Hosted(Arc<Mutex<Vec<JoinHandle<()>>>>);

impl Hosted {
    /// Lets a member take part on a thread of its own.
    pub(crate) fn start(&self, member: impl FnOnce() + Send + 'static) {
        let thread = std::thread::spawn(member);
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(thread);
    }

    /// Whether one of them still takes part.
    fn go_on(&self) -> bool {
        let threads = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        threads.iter().any(|thread| !thread.is_finished())
    }
}

/// How often a process without a member of its own looks whether it has others.
const HOSTED_EVERY: Duration = Duration::from_millis(50);

/// Ctrl-C ends this process in order.
pub(crate) fn end_on_interrupt(events: Sender<Event>) -> anyhow::Result<()> {
    Ok(on_interrupt(move || {
        let _ = events.send(Event::Stop);
    })?)
}

/// The process of one member, from its arguments to its exit code.
pub(crate) fn member(
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
    let (hosted, interrupted) = (makes.hosted.clone(), events.1.clone());
    let ended = run_federate(args, name, &scene, federate, events, makes);
    let Err(Some(MemberError::Yielded { .. })) = ended.as_ref().map_err(|e| e.downcast_ref())
    else {
        return ended;
    };
    // Its place is another one's now. Those that it has taken stay here.
    while hosted.go_on() {
        if matches!(interrupted.recv_timeout(HOSTED_EVERY), Ok(Event::Stop)) {
            break;
        }
    }
    Ok(COMPLETE)
}

/// Opens both planes and takes part until the run is over.
pub(crate) fn run_federate(
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
    for (key, handler) in makes.serves {
        bus.serve(&key, handler)?;
    }
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
    if let Some(router) = &args.sync_router {
        args.check_connecting(router)?;
        let config = ZenohConfig {
            part: Part::Client,
            listen: Vec::new(),
            connect: vec![router.clone()],
            exercise,
            connect_timeout: patience(),
            certs: args.certs_of(name)?,
        };
        let bus = while_connecting(|| ZenohBus::open(&config))?;
        return Ok((Arc::new(bus), router.clone()));
    }
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
        part: Part::Peer,
        listen: vec![listen],
        connect: vec![connect.clone()],
        exercise,
        connect_timeout: patience(),
        certs: args.certs_of(name)?,
    };
    Ok((Arc::new(while_connecting(|| ZenohBus::open(&config))?), connect))
}
