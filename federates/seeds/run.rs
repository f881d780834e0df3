//! `seeds run`: a whole federation on this host, one process a federate, or all in one.

use super::agent::places;
use super::known::Known;
use super::launch::{Launched, News, STARTS_A_MINUTE, common_arguments, listed};
use super::run_args::RunArgs;
use crate::federation::{GATEWAY, generator_name, has_control, smdfm_name};
use crate::runtime::cli::print_line;
use crate::runtime::cli::{
    self, BAD_INPUT, COMPLETE, DATA_LOST, FAILED, fail, load_scene, load_scene_without_truth,
};
use crate::runtime::clock::monotonic_ns;
use crate::runtime::dis_socket::link_config;
use crate::runtime::process::{KEPT, LOGGING, NO_LOGGER, REACHED, random_id};
use crate::visitors::command::check_plots;
use crate::visitors::seats::read_inputs;
use anyhow::Context as _;
use scenarios::losses::{ByMember, Losses, OnLoss};
use scenarios::{External, ForeignScene, Scene, SensorScene};
use std::io::ErrorKind;
use std::net::{SocketAddr, TcpListener};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// From the end of a process to its next start: a connection that is gone counts as a loss after 0.3 s.
const RESTART_NS: u64 = 500_000_000;

/// Runs the federation and ends with its summary as the last line on stdout.
#[must_use]
pub fn run(args: &RunArgs) -> ExitCode {
    cli::log_to_stderr(args.log_format, "warn");
    if let Err(e) = crate::runtime::process::enough_files() {
        return fail(FAILED, e);
    }
    // Processes make the movements of their shares themselves; this one only looks at what there is.
    let load = if args.in_process { load_scene } else { load_scene_without_truth };
    let scene = match load(&args.scene) {
        Ok(scene) => scene,
        Err(code) => return code,
    };
    if args.generators as usize > scene.traffic.entities.len().max(1) {
        return fail(
            BAD_INPUT,
            format!(
                "--generators {}: the scene has only {} entities to share",
                args.generators,
                scene.traffic.entities.len()
            ),
        );
    }
    if args.network.sync_connect.is_some() {
        let help = "a run listens for its federates: --sync-listen ENDPOINT";
        return fail(BAD_INPUT, format!("--sync-connect: {help}"));
    }
    if args.network.sync_router.is_some() {
        let help = "the federates of one host need no router: start each by itself on its host (docs/hosts.md)";
        return fail(BAD_INPUT, format!("--sync-router: {help}"));
    }
    if args.network.sync_listen.as_ref().is_some_and(|e| e.ends_with(":0")) {
        let help = "the federates of a run must know its port: choose one, not 0";
        return fail(BAD_INPUT, format!("--sync-listen: {help}"));
    }
    // A federation in one process has no gateway, whatever its scene says of one.
    let external = if args.in_process { External::default() } else { scene.external.clone() };
    let mut own = args.clone();
    own.asterix = args.asterix.over(&external);
    let args = &own;
    if let Err(e) = args.asterix.check(&args.network, args.options().rate) {
        return fail(BAD_INPUT, format!("{e:#}"));
    }
    if let Err(e) = args.protection() {
        return fail(BAD_INPUT, format!("{e:#}"));
    }
    if let Err(e) = args.inputs.as_deref().map(|file| read_inputs(file, &scene)).transpose() {
        return fail(BAD_INPUT, format!("--inputs {e:#}"));
    }
    if let Err(e) = real_sensors(args, &scene) {
        return fail(BAD_INPUT, format!("{e:#}"));
    }
    if args.in_process {
        if args.losses.balance {
            let help = "--balance moves places from process to process, and --in-process is one: leave out one of them";
            return fail(BAD_INPUT, help);
        }
        if let Err(e) = super::in_process::check(args) {
            return fail(BAD_INPUT, format!("{e:#}"));
        }
        return match super::in_process::run(args, &scene) {
            Ok(code) => ExitCode::from(code),
            Err(e) => fail(FAILED, format!("{e:#}")),
        };
    }
    // Said once and before anything is started, not by every federate for itself.
    let link = link_config(&args.network, &scene.network)
        .and_then(|link| Ok(datalink::Sender::open(&link).map(drop)?));
    if let Err(e) = link {
        return fail(BAD_INPUT, format!("{e:#}"));
    }
    let control = has_control(&scene);
    let agents = args.agents(&scene);
    let endpoint = args.sync_endpoint(&scene);
    let reach = args.network.check_listening(&endpoint);
    if let Err(e) = reach.and_then(|()| places::check(&agents, &args.network, &endpoint)) {
        return fail(BAD_INPUT, format!("{e:#}"));
    }
    let losses = args.losses.losses().over(&scene.network.losses);
    if let Err(e) = args.losses.check_balance(&losses) {
        return fail(BAD_INPUT, e);
    }
    if let Err(e) = Journaled::check(args) {
        return fail(BAD_INPUT, format!("{e:#}"));
    }
    // As of `seeds open`: an address that is not to be had is one that was chosen wrongly.
    if let Some(Err(e)) =
        (!args.no_viewer).then(|| port_is_free(args.page, "page", "--page ADDR:PORT"))
    {
        return fail(BAD_INPUT, format!("{e:#}"));
    }
    match processes(args, control, &losses, &endpoint, &agents) {
        Ok(code) => ExitCode::from(code),
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

/// Sensors that really are somewhere send in real time, through the member `visitors`.
fn real_sensors(args: &RunArgs, scene: &Scene) -> anyhow::Result<()> {
    let is_live = |s: &&SensorScene| s.foreign.as_ref().is_some_and(ForeignScene::is_live);
    let Some(sensor) = scene.sensors.iter().find(is_live) else { return Ok(()) };
    anyhow::ensure!(
        args.with_visitors() && !args.fast,
        "sensor '{}' is listened for on the network: leave out --fast, --in-process and --no-visitors, or give the sensor a recording (file = \"….pcapng\") in place of `listen`",
        sensor.name
    );
    check_plots(scene)
}

/// A taken port is better said once, before anything is started.
fn port_is_free(address: SocketAddr, what: &str, flag: &str) -> anyhow::Result<()> {
    TcpListener::bind(address).map(drop).map_err(|e| {
        let help = match e.kind() {
            ErrorKind::AddrNotAvailable => "this host has no such address; choose one with",
            ErrorKind::PermissionDenied => "choose a port above 1023 with",
            _ => "end the program that uses it, or choose another with",
        };
        anyhow::anyhow!("{what} at {address}: {e}: {help} {flag}")
    })
}

fn processes(
    args: &RunArgs,
    control: bool,
    losses: &Losses,
    endpoint: &str,
    agents: &ByMember<String>,
) -> anyhow::Result<u8> {
    let place = endpoint.split_once('/').map(|(_, place)| place);
    if let Some(address) = place.and_then(|a| a.parse().ok()) {
        port_is_free(address, "synchronisation plane", "--sync-listen tcp/127.0.0.1:PORT")?;
    }
    let mut launched = Launched::default();
    let interrupted = launched.sender();
    ctrlc::set_handler(move || {
        let _ = interrupted.send(News::Interrupted);
    })?;
    let mut names: Vec<String> =
        (1..=args.generators).map(|share| generator_name(share, args.generators)).collect();
    names.extend((1..=args.smdfms).map(smdfm_name));
    names.extend(["external-world", "control", "visitors"].map(str::to_owned));
    places::place(&mut launched, agents, &names, &args.network)?;
    let journal = Journaled::of(args, losses)?;
    start_all(args, control, endpoint, journal.as_ref(), &mut launched)?;

    let mut summary = None;
    let mut known = Known::default();
    let mut code = None;
    let mut database: Option<String> = None;
    let mut interrupts = 0;
    let (mut logging, mut lost, mut told) = (false, false, false);
    let progress = args.fast && std::io::IsTerminal::is_terminal(&std::io::stderr());
    // Who is started again, and when: the station has to know first that the one before is gone.
    let mut again: Vec<(u64, String)> = Vec::new();
    while !launched.running().is_empty() {
        let patience = if again.is_empty() { 500 } else { 50 };
        let news = launched.news().recv_timeout(Duration::from_millis(patience));
        while let Some(due) = again.iter().position(|(at, _)| *at <= monotonic_ns()) {
            let (_, name) = again.swap_remove(due);
            if code.is_some() || interrupts > 0 {
                continue;
            }
            if launched.start_again(&name)? {
                say(&format!("{name} is started again in its place"));
            } else {
                say(&format!("{name} ended {STARTS_A_MINUTE} times within a minute"));
                if name == STATION {
                    code = Some(i32::from(FAILED));
                    launched.end_after(Duration::from_secs(10), LOGGER);
                    launched.interrupt_all();
                }
            }
        }
        if code.is_some() {
            launched.end_if_idle(LOGGER);
        } else if !logging && args.with_logger() && !told && launched.stands(LOGGER) {
            told = true;
            launched.tell("admin-station", NO_LOGGER);
        }
        let Ok(news) = news else { continue };
        match news {
            News::Line(line) => {
                if let Some(page) = line.strip_prefix("page ") {
                    say(&format!("SEEDS: page at {page}  (Ctrl-C ends)"));
                } else if let Some(page) = line.strip_prefix("page-to-look ") {
                    say(&format!("SEEDS: for those who may look and not command: {page}"));
                } else if let Some(kept) = line.strip_prefix(KEPT) {
                    database = Some(kept.trim().to_owned());
                } else if let Some(phase) = line.strip_prefix(REACHED) {
                    known.reached(phase.trim());
                } else if line == LOGGING {
                    logging = true;
                } else if let Some(done) = line.strip_prefix("progress ") {
                    if progress {
                        show_progress(done);
                    }
                } else {
                    print_line(&line);
                    summary = Some(line);
                    known.closed();
                }
            }
            News::Interrupted => {
                interrupts += 1;
                if interrupts == 1 {
                    launched.interrupt("admin-station");
                } else {
                    launched.end_all(Duration::from_millis(200));
                    return Ok(FAILED);
                }
            }
            News::Ended(name, ended_with) => {
                launched.ended(&name);
                // What ends by itself after the run is closed ends in order.
                let over = known.is_closed() && args.options().batch && ended_with >= 0;
                if name == STATION
                    && ended_with < 0
                    && interrupts == 0
                    && !known.is_closed()
                    && journal.as_ref().is_some_and(|journal| journal.again)
                {
                    say(&format!("admin-station ended ({}); time stands", ending(ended_with)));
                    again.push((monotonic_ns() + STATION_AGAIN_NS, name));
                    continue;
                }
                if name == STATION {
                    code = Some(ended_with);
                    if ended_with < 0 {
                        say(&format!(
                            "admin-station ended ({}); without it the run is over",
                            ending(ended_with)
                        ));
                    }
                    // Spectators close their files and leave on the conductor's order, or on this one.
                    launched.end_after(Duration::from_secs(10), LOGGER);
                    // Members that were joining when a person ended it wait for orders that never come.
                    if ended_with < 0 || (interrupts > 0 && !known.is_closed()) {
                        launched.interrupt_all();
                    }
                } else if name == LOGGER && !logging && ended_with > 0 {
                    // It has said why. What was asked for is not to be had: better to know it now.
                    launched.end_all(Duration::from_secs(2));
                    return Ok(u8::try_from(ended_with).unwrap_or(FAILED));
                } else if name == LOGGER {
                    launched.tell("admin-station", NO_LOGGER);
                    if code.is_none() && interrupts == 0 {
                        say(&format!(
                            "the viewer-logger ended ({}); the run goes on without it. Another one: {}",
                            ending(ended_with),
                            another_logger(args, endpoint)
                        ));
                    }
                    lost |= ended_with != 0 && (args.record.is_some() || args.report.is_some())
                        || ended_with == i32::from(DATA_LOST);
                } else if name == GATEWAY {
                    if code.is_none() && interrupts == 0 && !over {
                        say(&format!(
                            "the gateway ended ({}); the run goes on without it",
                            ending(ended_with)
                        ));
                    }
                    lost |= ended_with != 0;
                } else if code.is_none() && ended_with == i32::from(BAD_INPUT) {
                    // A movement that none can be made of: it has said which.
                    launched.end_all(Duration::from_secs(2));
                    return Ok(BAD_INPUT);
                } else if name == "visitors" {
                    if code.is_none() && interrupts == 0 && !over {
                        let how = ending(ended_with);
                        say(&format!("visitors ended ({how}); the run goes on without outsiders"));
                    }
                } else if code.is_none() && !over {
                    if ended_with != 0 {
                        tracing::warn!("{name} ended ({})", ending(ended_with));
                    }
                    let policy = losses.on_loss.of(&name).unwrap_or_default();
                    if interrupts == 0
                        && policy == OnLoss::TakeOver
                        && known.starts_again(&name, ended_with, &launched.running())
                    {
                        again.push((monotonic_ns() + RESTART_NS, name));
                        continue;
                    }
                    // The conductor says why and ends the run, unless that one had not joined yet.
                    let ends = ended_with != 0 && matches!(policy, OnLoss::Freeze | OnLoss::Abort);
                    if args.options().batch && ends && losses.return_ms.is_none() {
                        launched.end_after(Duration::from_secs(3), "");
                    }
                }
                let comes = again.iter().any(|(_, name)| name == STATION);
                let needed = comes || launched.running().iter().any(|n| n == STATION);
                if !needed && code.is_none() {
                    code = Some(i32::from(FAILED));
                }
            }
        }
    }
    if args.fast
        && let Some(database) = &database
    {
        let word = if database.contains(' ') { format!("'{database}'") } else { database.clone() };
        say(&format!("seeds open {word}"));
    }
    let code = code.unwrap_or(i32::from(FAILED));
    if summary.is_none() && code == 0 {
        if interrupts > 0 {
            say("interrupted before the run began");
        }
        return Ok(FAILED);
    }
    Ok(match code {
        0 if lost => DATA_LOST,
        0 => COMPLETE,
        c if c > 0 && c < 256 => c as u8,
        _ => FAILED,
    })
}

/// The journal of a station that is started again where it dies: a file for as long as this launcher runs, or one that outlives it.
struct Journaled {
    file: PathBuf,
    /// A person named it: only the station removes it, at the end of its run.
    named: bool,
    /// A station that dies is started again with it.
    again: bool,
}

impl Journaled {
    /// Where a file is named, or `losses` say that another process takes the place of the station.
    fn of(args: &RunArgs, losses: &Losses) -> anyhow::Result<Option<Self>> {
        let again = losses.on_loss.of(STATION) == Some(OnLoss::TakeOver);
        if let Some(file) = args.continues.as_ref().or(args.journal.as_ref()) {
            return Ok(Some(Self { file: file.clone(), named: true, again }));
        }
        if !again {
            return Ok(None);
        }
        let name = format!("seeds-{:032x}.journal", random_id());
        let file = std::env::temp_dir().join(name);
        std::fs::File::create_new(&file).with_context(|| {
            let (file, help) = (file.display(), "set TMPDIR to a folder where this user may write");
            format!("the journal of the station, {file}: {help}")
        })?;
        Ok(Some(Self { file, named: false, again }))
    }

    /// What the command line says of it can be used, before anything is started.
    fn check(args: &RunArgs) -> anyhow::Result<()> {
        if let Some(file) = &args.continues {
            let length = std::fs::metadata(file).map(|m| if m.is_file() { m.len() } else { 0 });
            let length = length.with_context(|| {
                format!("--continue {}: the file that a run was given as --journal", file.display())
            })?;
            anyhow::ensure!(
                length > 0,
                "--continue {}: no journal of a run; it is the file that a run was given as --journal",
                file.display()
            );
        }
        if let Some(file) = &args.journal {
            anyhow::ensure!(
                !file.exists(),
                "--journal {}: the file is there already: --continue FILE goes on with its run; remove it, or name another, to begin one",
                file.display()
            );
            cli::writable(file).context("--journal")?;
        }
        Ok(())
    }
}

impl Drop for Journaled {
    fn drop(&mut self) {
        // The station has removed it at the end of its run.
        if !self.named {
            let _ = std::fs::remove_file(&self.file);
        }
    }
}

/// The administration station that this launcher starts.
const STATION: &str = "admin-station";

/// From the end of its process to the next: there is nothing to wait for.
const STATION_AGAIN_NS: u64 = 50_000_000;

/// The viewer-logger that this launcher starts.
const LOGGER: &str = "viewer-logger";

/// The command that starts another viewer-logger beside a run.
fn another_logger(args: &RunArgs, endpoint: &str) -> String {
    let mut words = vec!["seeds".to_owned(), LOGGER.to_owned()];
    words.extend(common_arguments(&args.common(), endpoint));
    words.extend(viewer_arguments(args).into_iter().take_while(|word| word != "--record"));
    words.join(" ")
}

fn ending(code: i32) -> String {
    if code < 0 { format!("killed by signal {}", -code) } else { format!("exit code {code}") }
}

fn start_all(
    args: &RunArgs,
    control: bool,
    endpoint: &str,
    journal: Option<&Journaled>,
    launched: &mut Launched,
) -> anyhow::Result<()> {
    let common = common_arguments(&args.common(), endpoint);
    let with = |name: &str, more: &[String]| -> Vec<String> {
        [&[name.to_owned()], &common[..], more].concat()
    };
    let options = args.options();
    let admin = station_arguments(args, endpoint, journal);
    launched.start("admin-station", &with("admin-station", &admin))?;
    if args.asterix.asked() {
        launched.start(GATEWAY, &with(GATEWAY, &args.asterix.arguments()))?;
    }
    for share in 1..=args.generators {
        let more = ["--share".to_owned(), format!("{share}/{}", args.generators)];
        launched
            .start(&generator_name(share, args.generators), &with("traffic-generator", &more))?;
    }
    launched.start("external-world", &with("external-world", &[]))?;
    if options.visitors {
        let inputs = args.inputs.iter();
        let inputs: Vec<String> =
            inputs.flat_map(|f| ["--inputs".to_owned(), f.display().to_string()]).collect();
        launched.start("visitors", &with("visitors", &inputs))?;
    }
    let loss = ["--inject-loss".to_owned(), args.inject_loss.to_string()];
    let mut smdfm = loss.to_vec();
    if args.with_logger() {
        smdfm.push("--explain".to_owned());
    }
    launched.start(&smdfm_name(1), &with("smdfm", &smdfm))?;
    for share in 2..=args.smdfms {
        let more = ["--share".to_owned(), format!("{share}/{}", args.smdfms)];
        launched.start(&smdfm_name(share), &with("smdfm", &[&smdfm[..], &more].concat()))?;
    }
    if control {
        launched.start("control", &with("control", &[]))?;
    }
    if args.with_logger() {
        launched.start("viewer-logger", &with("viewer-logger", &viewer_arguments(args)))?;
    }
    Ok(())
}

/// What the administration station is told beside the common arguments.
fn station_arguments(args: &RunArgs, endpoint: &str, journal: Option<&Journaled>) -> Vec<String> {
    let options = args.options();
    let mut admin = vec!["--sync-listen".to_owned(), endpoint.to_owned()];
    if args.fast {
        admin.push("--fast".into());
        admin.push("--progress".into());
    } else {
        admin.extend(["--rate".to_owned(), args.rate.to_string()]);
    }
    if let Some(seconds) = args.duration {
        admin.extend(["--duration".to_owned(), seconds.to_string()]);
    }
    if let Some(seed) = args.seed {
        admin.extend(["--seed".to_owned(), seed.to_string()]);
    }
    if options.batch {
        admin.push("--batch".into());
    }
    if !options.autostart {
        admin.push("--wait".into());
    }
    admin.extend(["--generators".to_owned(), args.generators.to_string()]);
    if args.smdfms > 1 {
        admin.extend(["--smdfms".to_owned(), args.smdfms.to_string()]);
    }
    admin.extend(args.losses.arguments());
    if let Some(Journaled { file, named, .. }) = journal {
        admin.extend(["--journal".to_owned(), file.display().to_string()]);
        if *named {
            admin.push("--leave".to_owned());
        }
    }
    if options.visitors {
        admin.push("--visitors".to_owned());
    }
    if let Some(managers) = listed(&args.network.dis_managers) {
        admin.extend(["--dis-managers".to_owned(), managers]);
    }
    if args.with_logger() {
        // A log that was asked for is worth a longer wait on a busy host.
        let asked = args.record.is_some() || args.report.is_some();
        admin.push(format!("--expect-logger={}", if asked { 10 } else { 2 }));
    }
    if args.asterix.asked() {
        admin.push("--expect-gateway".to_owned());
    }
    admin
}

fn viewer_arguments(args: &RunArgs) -> Vec<String> {
    let mut more = Vec::new();
    if args.no_viewer {
        more.push("--no-page".to_owned());
    } else {
        more.extend(["--page".to_owned(), args.page.to_string()]);
    }
    if let Some(file) = &args.record {
        more.extend(["--record".to_owned(), file.display().to_string()]);
    }
    if let Some(folder) = &args.report {
        more.extend(["--report".to_owned(), folder.display().to_string()]);
    }
    more
}

#[expect(clippy::print_stderr, reason = "a word to the person at the terminal")]
fn say(text: &str) {
    eprintln!("{text}");
}

#[expect(clippy::print_stderr, reason = "a progress line on a terminal")]
fn show_progress(done: &str) {
    eprint!("\r{done}   ");
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        run: RunArgs,
    }

    #[test]
    fn the_station_is_told_whose_simulation_management_drives_the_run() {
        let of = |flags: &[&str]| {
            let Line { run } = Line::try_parse_from([&["run"], flags].concat()).expect("sound");
            let line = station_arguments(&run, "tcp/127.0.0.1:7447", None);
            let at = line.iter().position(|word| word == "--dis-managers");
            at.map(|at| line[at + 1].clone())
        };
        assert_eq!(of(&[]), None);
        let managers = "10.0.0.9,10.1.0.0/16";
        assert_eq!(of(&["--dis-managers", managers]).as_deref(), Some(managers));
    }
}
