//! `seeds router`: passes the synchronisation plane on between hosts that cannot reach each other.

use crate::runtime::bus::Bus as _;
use crate::runtime::cli::{self, BAD_INPUT, COMPLETE, FAILED, LogFormat, NetworkArgs, fail};
use crate::runtime::process::on_interrupt;
use crate::runtime::zenoh_bus::{Part, ZenohBus, ZenohConfig};
use clap::Args;
use crossbeam_channel::bounded;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Pass the synchronisation plane on between hosts that cannot reach each other; federates take it by --sync-router
#[derive(Args, Clone, Debug)]
pub struct RouterArgs {
    /// Endpoint to listen on, like tls/10.0.0.9:7447 [default: tcp/127.0.0.1:7447, with --certs tls/127.0.0.1:7447]
    #[arg(long, value_name = "ENDPOINT", value_parser = cli::endpoint)]
    listen: Option<String>,

    /// Folder with the certificates of the federation, made by `seeds certs`
    #[arg(long, value_name = "DIR")]
    certs: Option<PathBuf>,

    /// Listen beyond this host without certificates: everybody who reaches the endpoint can command the run
    #[arg(long, conflicts_with = "certs")]
    open: bool,

    /// DIS exercise identifier of the federation, 0 to 255
    #[arg(long, value_name = "N", default_value_t = 1)]
    exercise: u8,

    /// Log lines on stderr: text for people, json for programs
    #[arg(long, value_enum, default_value_t = LogFormat::Text)]
    log_format: LogFormat,
}

/// A router, until it is interrupted.
#[must_use]
pub fn run(args: &RouterArgs) -> ExitCode {
    cli::log_to_stderr(args.log_format, "info");
    if let Err(e) = crate::runtime::process::enough_files() {
        return fail(FAILED, e);
    }
    let (certs, open) = (args.certs.clone(), args.open);
    let network = NetworkArgs { certs, open, ..NetworkArgs::default() };
    let listen = args.listen.clone().unwrap_or_else(|| network.default_endpoint());
    if let Err(e) = network.check_listening(&listen) {
        return fail(BAD_INPUT, format!("{e:#}"));
    }
    match serve(&network, &listen, args.exercise) {
        Ok(()) => ExitCode::from(COMPLETE),
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

fn serve(network: &NetworkArgs, listen: &str, exercise: u8) -> anyhow::Result<()> {
    let (send, interrupted) = bounded(1);
    on_interrupt(move || {
        let _ = send.try_send(());
    })?;
    let bus = ZenohBus::open(&ZenohConfig {
        listen: vec![listen.to_owned()],
        connect: Vec::new(),
        exercise,
        connect_timeout: Duration::from_secs(1),
        certs: network.certs_of("router")?,
        part: Part::Router,
    })?;
    tracing::info!("router at {listen}: federates take it by --sync-router {listen}");
    let _ = interrupted.recv();
    bus.close();
    Ok(())
}
