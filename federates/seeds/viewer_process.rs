//! The viewer-logger's process: sockets, files and the end of the run.

use super::federate_commands::{ViewerArgs, open_bus, patience};
use super::run::{KEPT, LOGGING};
use crate::runtime::cli::out;
use crate::runtime::cli::{COMPLETE, DATA_LOST};
use crate::runtime::clock::utc_ns;
use crate::runtime::dis_socket::link_config;
use crate::runtime::process::{launched, on_interrupt};
use crate::viewer_logger::keeper::Files;
use crate::viewer_logger::process::{self, Datagram, Inbox, Task};
use crate::viewer_logger::server::Server;
use scenarios::Scene;
use std::path::Path;
use std::sync::Arc;

/// Runs the viewer-logger; the address of the page goes to standard output, on a line of its own.
///
/// # Errors
/// If the page, a file or a network plane cannot be opened: which, why, and what to do.
pub fn run(args: &ViewerArgs, scene: Arc<Scene>) -> anyhow::Result<u8> {
    let exercise = args.common.exercise.unwrap_or(scene.run.exercise);
    let inbox = Inbox::default();
    let stop = inbox.clone();
    on_interrupt(move || stop.stop())?;
    let files = match (&args.record, &args.report) {
        (Some(file), _) => Files::beside(file),
        (None, Some(folder)) => Files::beside(&folder.join("run.pcapng")),
        (None, None) => Files::in_folder(Path::new("runs"), utc_ns()),
    };
    let database = files.database.clone();
    // Listening before joining: the first datagram of the run is in the recording.
    listen(args, &scene, &inbox)?;
    let (bus, endpoint) =
        open_bus(&args.common.network, &scene.network, exercise, "viewer-logger")?;
    let task = Task {
        name: "viewer-logger".to_owned(),
        page: (!args.no_page).then_some(args.page),
        files,
        patience: patience(),
        endpoint,
    };
    let kept = process::run(&task, scene, Arc::clone(&bus), inbox, |server| {
        if let Some(access) = server.map(Server::access) {
            print_line(&format!("page {}", access.url()));
            if let Some(url) = access.url_to_look() {
                print_line(&format!("page-to-look {url}"));
            }
        }
        if launched() {
            if let Some(database) = &database {
                let folder = database.parent().filter(|_| database.ends_with("run.sqlite"));
                print_line(&format!("{KEPT} {}", folder.unwrap_or(database).display()));
            }
            print_line(LOGGING);
        }
    });
    bus.close();
    let Some(kept) = kept? else { return Ok(COMPLETE) };
    if let (Some(folder), Some(database)) = (&args.report, &database) {
        super::report::write(folder, database)?;
    }
    if kept.complete() {
        return Ok(COMPLETE);
    }
    tracing::error!(
        scans = kept.scans_lost,
        datagrams = kept.datagrams_lost,
        "the log is not complete"
    );
    Ok(DATA_LOST)
}

fn listen(args: &ViewerArgs, scene: &Scene, inbox: &Inbox) -> anyhow::Result<()> {
    let mut receiver =
        datalink::Receiver::open(&link_config(&args.common.network, &scene.network)?)?;
    for warning in receiver.warnings() {
        tracing::warn!("{warning}");
    }
    let inbox = inbox.clone();
    std::thread::spawn(move || {
        let mut dropped = 0;
        loop {
            let mut datagrams = Vec::new();
            let got = receiver.receive(None, |arrival| {
                datagrams.push(Datagram {
                    utc_ns: arrival.utc_ns,
                    from: arrival.from,
                    to: arrival.to,
                    octets: arrival.payload.into(),
                });
            });
            if let Err(error) = got {
                tracing::error!("receiving DIS: {error}");
                return;
            }
            inbox.dropped(dropped, receiver.dropped());
            dropped = receiver.dropped();
            inbox.datagrams(datagrams);
        }
    });
    Ok(())
}

fn print_line(line: &str) {
    out!("{line}");
}
