//! The command line of the viewer-logger, and its process: sockets, files and the end of the run.

use super::keeper::Files;
use super::process::{self, Datagram, Inbox, Task};
use super::server::Server;
use crate::runtime::cli::{
    self, COMPLETE, CommonArgs, DATA_LOST, DEFAULT_PAGE, FAILED, fail, load_scene_without_truth,
    print_line,
};
use crate::runtime::clock::utc_ns;
use crate::runtime::dis_socket::link_config;
use crate::runtime::member_process::{open_bus, patience};
use crate::runtime::process::{
    COMMAND_LINE, KEPT, LOGGING, command_line, launched, machine, on_interrupt,
};
use clap::Args;
use scenarios::Scene;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

/// Viewer and logger: the page, the recording, the database
#[derive(Args, Clone, Debug)]
pub struct ViewerArgs {
    #[command(flatten)]
    pub(crate) common: CommonArgs,

    /// Address and port of the page; port 0: any free one
    #[arg(long, value_name = "ADDR:PORT", default_value = DEFAULT_PAGE, value_parser = cli::page)]
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

/// The viewer-logger's process.
#[must_use]
pub fn run(args: &ViewerArgs) -> ExitCode {
    crate::runtime::process::end_with_launcher();
    cli::log_to_stderr(args.common.log_format, "warn");
    if let Err(e) = crate::runtime::process::enough_files() {
        return fail(FAILED, e);
    }
    let scene = match load_scene_without_truth(&args.common.scene) {
        Ok(scene) => Arc::new(scene),
        Err(code) => return code,
    };
    match view(args, scene) {
        Ok(code) => ExitCode::from(code),
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

/// Runs the viewer-logger; the address of the page goes to standard output, on a line of its own.
///
/// # Errors
/// If the page, a file or a network plane cannot be opened: which, why, and what to do.
fn view(args: &ViewerArgs, scene: Arc<Scene>) -> anyhow::Result<u8> {
    let exercise = args.common.exercise.unwrap_or(scene.run.exercise);
    let inbox = Inbox::default();
    let stop = inbox.clone();
    on_interrupt(move || stop.stop())?;
    // Listening before joining: the first datagram of the run is in the recording.
    listen(args, &scene, &inbox)?;
    let (bus, endpoint) =
        open_bus(&args.common.network, &scene.network, exercise, "viewer-logger")?;
    let files = match (&args.record, &args.report) {
        (Some(file), _) => Files::beside(file),
        (None, Some(folder)) => Files::beside(&folder.join("run.pcapng")),
        (None, None) => Files::in_folder(Path::new("runs"), utc_ns()),
    };
    let database = files.database.clone();
    let task = Task {
        name: "viewer-logger".to_owned(),
        page: (!args.no_page).then_some(args.page),
        files,
        patience: patience(),
        endpoint,
    };
    let facts = [
        ("command_line", std::env::var(COMMAND_LINE).unwrap_or_else(|_| command_line())),
        ("machine", machine()),
    ];
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
                let folder = folder.filter(|folder| !folder.as_os_str().is_empty());
                print_line(&format!("{KEPT} {}", folder.unwrap_or(database).display()));
            }
            print_line(LOGGING);
        }
    });
    bus.close();
    if let (Err(_), None, None, Some(folder)) =
        (&kept, &args.record, &args.report, database.as_deref().and_then(Path::parent))
    {
        std::fs::remove_dir(folder).ok(); // made for this run; it stays where something is in it
    }
    let Some(kept) = kept? else { return Ok(COMPLETE) };
    for database in &kept.databases {
        if let Err(error) = note(database, &facts) {
            tracing::warn!("how the run was started is not in the log: {error}");
        }
    }
    if let Some(folder) = &args.report {
        report(folder, &kept.databases)?;
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

/// Notes how the run was started, for its report.
fn note(database: &Path, facts: &[(&str, String)]) -> rusqlite::Result<()> {
    let database = rusqlite::Connection::open(database)?;
    for (name, value) in facts {
        database.execute("INSERT OR REPLACE INTO run VALUES (?1, ?2)", [name, &value[..]])?;
    }
    Ok(())
}

/// Reports of the runs of this process: of the last one into the folder, of those that it replaced into `run-1`, `run-2` … there.
fn report(folder: &Path, databases: &[PathBuf]) -> anyhow::Result<()> {
    let Some((last, before)) = databases.split_last() else { return Ok(()) };
    for (number, database) in (1..).zip(before) {
        crate::seeds::report::write(&folder.join(format!("run-{number}")), database)?;
    }
    crate::seeds::report::write(folder, last)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer_logger::log::Log;
    use crate::viewer_logger::log::tests::Folder;
    use crate::viewer_logger::picture::{AirportMap, RunInfo};

    #[test]
    fn the_report_is_of_the_last_run_and_those_before_have_their_own() {
        let folder = Folder::new();
        let run = |name: &str, title: &str| {
            let file = folder.0.join(name);
            let info = RunInfo { title: title.to_owned(), ..RunInfo::default() };
            let log = Log::create(&file, &info, &AirportMap::default()).expect("a log");
            log.close().expect("closed");
            file
        };
        let databases = [run("run.sqlite", "given up"), run("run-2.sqlite", "whole")];
        report(&folder.0, &databases).expect("written");
        let page = |name: &str| std::fs::read_to_string(folder.0.join(name)).expect("a page");
        assert!(page("report.html").contains("<h1>whole</h1>"));
        assert!(page("run-1/report.html").contains("<h1>given up</h1>"));
        report(&folder.0.join("none"), &[]).expect("nothing to report");
    }
}
