//! `seeds agent`: starts and stops federates on this host for the administration station of another one.

pub mod client;
pub mod places;
mod sessions;
mod words;

use crate::runtime::bus::{Bus, Request};
use crate::runtime::certs::{allowed, is_loopback};
use crate::runtime::cli::{self, BAD_INPUT, COMPLETE, FAILED, LogFormat, NetworkArgs, fail};
use crate::runtime::clock::monotonic_ns;
use crate::runtime::codec::{decode, encode};
use crate::runtime::process::on_interrupt;
use crate::runtime::zenoh_bus::{Part, ZenohBus, ZenohConfig};
use clap::Args;
use crossbeam_channel::{RecvTimeoutError, unbounded};
use sessions::Sessions;
use std::net::IpAddr;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;
use words::{Answer, Ask, EXERCISE, KEY};

/// Default endpoint of an agent.
const DEFAULT_ENDPOINT: &str = "tcp/127.0.0.1:7450";

/// Start and stop federates on this host for the administration station (`seeds run`) of another one
#[derive(Args, Clone, Debug)]
pub struct AgentArgs {
    /// Endpoint to listen on, like tls/10.0.0.2:7450 [default: tcp/127.0.0.1:7450, with --certs tls/127.0.0.1:7450]
    #[arg(long, value_name = "ENDPOINT", value_parser = cli::endpoint)]
    listen: Option<String>,

    /// Folder with the certificates of the federation, made by `seeds certs`: the agent's own, and those of the federates that it starts
    #[arg(long, value_name = "DIR")]
    certs: Option<PathBuf>,

    /// Address of this host's network interface for DIS, for all that it starts
    #[arg(long, value_name = "IP")]
    interface: Option<IpAddr>,

    /// Log lines on stderr: text for people, json for programs
    #[arg(long, value_enum, default_value_t = LogFormat::Text)]
    log_format: LogFormat,
}

enum Event {
    Asked(Request),
    Interrupted,
}

/// An agent, until it is interrupted; it ends what it started.
#[must_use]
pub fn run(args: &AgentArgs) -> ExitCode {
    crate::runtime::process::end_with_launcher();
    cli::log_to_stderr(args.log_format, "info");
    if let Err(e) = crate::runtime::process::enough_files() {
        return fail(FAILED, e);
    }
    let default = match args.certs {
        Some(_) => DEFAULT_ENDPOINT.replacen("tcp/", "tls/", 1),
        None => DEFAULT_ENDPOINT.to_owned(),
    };
    let listen = args.listen.clone().unwrap_or(default);
    if args.certs.is_none() && !is_loopback(&listen) {
        return fail(
            BAD_INPUT,
            format!(
                "--listen {listen}: an agent starts processes for whoever reaches it: beyond this host it needs --certs DIR and a tls/ endpoint (`seeds certs DIR` makes certificates)"
            ),
        );
    }
    if let Err(e) = allowed(&listen, args.certs.is_some(), false) {
        return fail(BAD_INPUT, e);
    }
    match serve(args, &listen) {
        Ok(()) => ExitCode::from(COMPLETE),
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

fn serve(args: &AgentArgs, listen: &str) -> anyhow::Result<()> {
    let network = NetworkArgs { certs: args.certs.clone(), ..NetworkArgs::default() };
    let bus = ZenohBus::open(&ZenohConfig {
        part: Part::Peer,
        listen: vec![listen.to_owned()],
        connect: Vec::new(),
        exercise: EXERCISE,
        connect_timeout: Duration::from_secs(1),
        certs: network.certs_of("agent")?,
    })?;
    let (send, events) = unbounded();
    let stop = send.clone();
    on_interrupt(move || {
        let _ = stop.send(Event::Interrupted);
    })?;
    bus.serve(
        KEY,
        Box::new(move |request| {
            let _ = send.send(Event::Asked(request));
        }),
    )?;
    tracing::info!("agent at {listen}: starts federates for an administration station");
    let mut own = Vec::new();
    if let Some(folder) = &args.certs {
        own.extend(["--certs".to_owned(), folder.display().to_string()]);
    }
    if let Some(interface) = args.interface {
        own.extend(["--interface".to_owned(), interface.to_string()]);
    }
    // Children end with the thread that started them: all are started by this one.
    let mut sessions = Sessions::of(own);
    loop {
        match events.recv_timeout(Duration::from_millis(200)) {
            Ok(Event::Asked(request)) => {
                let answer = match decode::<Ask>(&request.body) {
                    Ok(ask) => sessions.answer(monotonic_ns(), ask),
                    Err(e) => Answer::Refused(e.to_string()),
                };
                request.answer(encode(&answer));
            }
            Ok(Event::Interrupted) | Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => {}
        }
        sessions.tick(monotonic_ns());
    }
    sessions.end();
    bus.close();
    Ok(())
}
