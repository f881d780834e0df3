//! `seeds open`: the page on runs that are finished, or that another process keeps.

use super::recorded::{Made, recording_alone};
use crate::runtime::cli::out;
use crate::runtime::cli::{self, BAD_INPUT, FAILED, fail};
use crate::runtime::clock::monotonic_ns;
use crate::viewer_logger::forks::{Forks, Wanted};
use crate::viewer_logger::opened;
use crate::viewer_logger::server::{Operate, Page, PageError, Server, serve};
use clap::Args;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::time::Duration;

/// Show the page on finished runs, any of up to 8 side by side
#[derive(Args, Clone, Debug)]
pub struct OpenArgs {
    /// A folder of runs/ or its name there, a database (run.sqlite), a fork.toml, a recording (pcapng, pcap), or `last` for the newest
    #[arg(value_name = "RUN", required = true)]
    runs: Vec<String>,

    /// Address and port of the page; port 0: any free one [default: 127.0.0.1:8600, or the next free port]
    #[arg(long, value_name = "ADDR:PORT", value_parser = cli::page)]
    page: Option<SocketAddr>,

    /// Scene of recordings that have no database beside them: an SMDFM runs over them first; without it they show truth alone
    #[arg(long, value_name = "FILE")]
    scene: Option<String>,

    /// Open a browser on it
    #[arg(long)]
    browser: bool,
}

/// Serves until it is interrupted.
#[must_use]
pub fn run(args: &OpenArgs) -> ExitCode {
    cli::log_to_stderr(cli::LogFormat::Text, "warn");
    // From here on Ctrl-C ends it in order: databases that are made for it go with it.
    let (stop, stopped) = std::sync::mpsc::channel();
    let interrupted = Arc::new(AtomicBool::new(false));
    let heard = Arc::clone(&interrupted);
    let set = ctrlc::set_handler(move || {
        heard.store(true, Ordering::Relaxed);
        stop.send(()).ok();
    });
    if let Err(error) = set {
        return fail(FAILED, error);
    }
    let (mut viewers, mut made) = (Vec::new(), Made::until(interrupted));
    let recordings = args.runs.iter().filter_map(|word| recording_alone(word)).count();
    if args.scene.is_some() && recordings == 0 {
        return fail(BAD_INPUT, "--scene is for recordings without a database, and none is named");
    }
    for word in &args.runs {
        if let Some(recording) = recording_alone(word) {
            let database = made.of(&recording, args.scene.as_deref());
            match database.and_then(|file| Ok(opened::viewer(&file)?)) {
                Ok(viewer) => viewers.push(viewer),
                Err(error) => return fail(BAD_INPUT, format!("{error:#}")),
            }
            continue;
        }
        let found = match opened::databases(word, Path::new(RUNS)) {
            Ok(found) => found,
            Err(error) => return fail(BAD_INPUT, error),
        };
        for database in found {
            match opened::viewer(&database) {
                Ok(viewer) => viewers.push(viewer),
                Err(error) => return fail(BAD_INPUT, error),
            }
        }
    }
    if viewers.len() > MOST_RUNS {
        return fail(BAD_INPUT, format!("{} runs: at most {MOST_RUNS} at once", viewers.len()));
    }
    let mut viewers = viewers.into_iter();
    let Some(first) = viewers.next() else { return fail(BAD_INPUT, "no run was named") };
    let page = Page::new(first);
    viewers.for_each(|viewer| drop(page.add(viewer)));
    page.make_forks(Forks::new(Box::new(fork_beside)));
    let operate = || -> Operate {
        Box::new(|_, _| (false, "this run is finished: it takes no commands".to_owned()))
    };
    let server = match serve_at(args.page, &page, operate) {
        Ok(server) => server,
        Err(code) => return code,
    };
    let url = server.access().url();
    print_line(&url);
    if args.browser && std::process::Command::new("xdg-open").arg(&url).spawn().is_err() {
        tracing::warn!("no browser could be started (xdg-open): open {url}");
    }
    until_told(server, &stopped, || page.follow())
}

/// Serves at the address asked for, else at the first port from 8600 on that is free.
pub(super) fn serve_at(
    asked: Option<SocketAddr>,
    page: &Arc<Page>,
    operate: impl Fn() -> Operate,
) -> Result<Server, ExitCode> {
    let tries = match asked {
        Some(address) => vec![address],
        None => (0..TRIES).map(|n| SocketAddr::from(([127, 0, 0, 1], FIRST_PORT + n))).collect(),
    };
    let mut served = None;
    for address in &tries {
        match serve(*address, Arc::clone(page), operate()) {
            Ok(server) => {
                served = Some(server);
                break;
            }
            Err(error @ PageError::Listen { .. }) if *address == tries[tries.len() - 1] => {
                return Err(fail(BAD_INPUT, error));
            }
            Err(PageError::Listen { .. }) => {}
            Err(error) => return Err(fail(FAILED, error)),
        }
    }
    let Some(server) = served else { return Err(fail(FAILED, "the page cannot be served")) };
    if asked.is_none() && server.address().port() != FIRST_PORT {
        tracing::warn!("port {FIRST_PORT} is taken: the page is at {}", server.address());
    }
    Ok(server)
}

/// Serves until Ctrl-C, and does something twice a second meanwhile.
pub(super) fn until_interrupted(server: Server, each: impl Fn()) -> ExitCode {
    let (stop, stopped) = std::sync::mpsc::channel();
    let set = ctrlc::set_handler(move || {
        stop.send(()).ok();
    });
    if let Err(error) = set {
        return fail(FAILED, error);
    }
    until_told(server, &stopped, each)
}

/// The same until somebody says so.
fn until_told(server: Server, stopped: &Receiver<()>, each: impl Fn()) -> ExitCode {
    while stopped.recv_timeout(FOLLOW).is_err() {
        each();
    }
    server.stop();
    ExitCode::SUCCESS
}

/// Makes a fork by `seeds fork` in a process of its own, for ten minutes at most.
fn fork_beside(
    database: &Path,
    wanted: &Wanted,
    cancelled: &AtomicBool,
) -> Result<PathBuf, String> {
    let seeds = std::env::current_exe().map_err(|e| e.to_string())?;
    let mut command = Command::new(seeds);
    command.arg("fork").arg(database).arg(format!("--at={}", wanted.at_s));
    for (key, value) in &wanted.changes {
        command.arg(format!("--set={key}={value}"));
    }
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|e| format!("seeds fork cannot be started: {e}"))?;
    let (began_ns, longest_ns) = (monotonic_ns(), 1_000_000_000 * LONGEST_FORK.as_secs());
    let why = loop {
        match child.try_wait() {
            Ok(Some(_)) => break None,
            Ok(None) if cancelled.load(Ordering::Relaxed) => break Some("cancelled".to_owned()),
            Ok(None) if monotonic_ns().saturating_sub(began_ns) > longest_ns => {
                break Some(format!("not done after {} min: ended", LONGEST_FORK.as_secs() / 60));
            }
            Ok(None) => std::thread::sleep(Duration::from_millis(50)),
            Err(error) => break Some(error.to_string()),
        }
    };
    if why.is_some() {
        child.kill().ok();
    }
    let done = child.wait_with_output().map_err(|e| e.to_string())?;
    if let Some(why) = why {
        return Err(why);
    }
    let told = String::from_utf8_lossy(&done.stdout);
    let folder = told.trim_end().strip_prefix(&format!("seeds open {} ", database.display()));
    match folder.filter(|_| done.status.success()) {
        Some(folder) => Ok(PathBuf::from(folder)),
        None => {
            let why = String::from_utf8_lossy(&done.stderr);
            let why = why.lines().find(|line| !line.trim().is_empty()).unwrap_or("no reason given");
            Err(why.trim_start_matches("error: ").to_owned())
        }
    }
}

pub(super) fn print_line(line: &str) {
    use std::io::Write as _;
    out!("{line}");
    std::io::stdout().flush().ok();
}

/// Where runs are kept.
pub const RUNS: &str = "runs";
const MOST_RUNS: usize = 8;
const FIRST_PORT: u16 = 8600;
/// A fork that takes longer is ended.
const LONGEST_FORK: Duration = Duration::from_secs(600);
/// Ports tried, where none was asked for.
const TRIES: u16 = 40;
/// How often a run that somebody else keeps is looked at for more.
const FOLLOW: Duration = Duration::from_millis(500);
