//! `seeds fork`: what if, from here. A recorded run again up to a time, bit by bit, and then with something changed.

mod chain;

use super::open::RUNS;
use super::replay;
use super::rerun::{Rerun, Stage};
use crate::gateway::public::iso8601;
use crate::runtime::cli::out;
use crate::runtime::cli::{self, BAD_INPUT, FAILED, fail};
use crate::runtime::clock::utc_ns;
use crate::runtime::messages::{Frame, WeatherNotice};
use crate::smdfm::change::{Amend, Anew};
use crate::viewer_logger::archive::Archive;
use crate::viewer_logger::kept_scene::{self, is_of_scene, is_switch};
use crate::viewer_logger::log::Log;
use crate::viewer_logger::opened;
use crate::viewer_logger::picture::{AirportMap, RunInfo};
use crate::viewer_logger::source::Event;
use anyhow::{Context, bail, ensure};
use chain::{Chain, Fragment, Told};
use clap::Args;
use scenarios::{Scene, change};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What if, from here: a recorded run again with something changed from a time on
#[derive(Args, Clone, Debug)]
pub struct ForkArgs {
    /// The run, a fork too: a folder of runs/ or its name there, its database, or `last`. A fork.toml alone is made again
    #[arg(value_name = "RUN")]
    run: String,

    /// Simulated time from which on the changes hold, s [default: the start]
    #[arg(long, value_name = "T")]
    at: Option<f64>,

    /// A change: a key of the scene (tracking.filter, sensor[NAME].overrides.range_max_m, …), sensor[NAME].enabled=false, weather.rain_factor, weather.visibility_m, run.sensor_seed
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = change_of)]
    changes: Vec<(String, String)>,

    /// Simulated time of the end, s [default: the run's]
    #[arg(long, value_name = "T", value_parser = cli::seconds)]
    until: Option<f64>,

    /// Name: a-z, 0-9 and -, up to 40 [default: from the first change]
    #[arg(long, value_name = "N", value_parser = name_of)]
    name: Option<String>,
}

fn change_of(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() && !value.trim().is_empty() => {
            Ok((key.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err(format!("'{text}' is not KEY=VALUE like tracking.filter=abg")),
    }
}

fn name_of(text: &str) -> Result<String, String> {
    let sound = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if (1..=40).contains(&text.len()) && text.chars().all(sound) {
        Ok(text.to_owned())
    } else {
        Err(format!("'{text}' is not a name of a-z, 0-9 and -, up to 40"))
    }
}

/// Makes the fork and says how to open it.
#[must_use]
pub fn run(args: &ForkArgs) -> ExitCode {
    cli::log_to_stderr(cli::LogFormat::Text, "warn");
    if let Err(error) = ctrlc::set_handler(|| STOP.store(true, Ordering::Relaxed)) {
        return fail(FAILED, error);
    }
    let prepared = wanted(args).and_then(|(parent, wanted)| {
        let fork = prepare(&parent, &wanted)?;
        let named = if wanted.again { parent.display().to_string() } else { args.run.clone() };
        Ok((fork, named))
    });
    match prepared {
        Err(error) => fail(BAD_INPUT, format!("{error:#}")),
        Ok((fork, parent)) => match fork.make() {
            Ok(folder) => {
                let keys = fork.plan.changes.iter().map(|(_, key, ..)| key.as_str());
                if let Some(text) = without_effect(keys) {
                    tracing::warn!("{text}");
                }
                out!("seeds open {parent} {}", folder.display());
                ExitCode::SUCCESS
            }
            Err(error) => {
                forget(&fork.folder, fork.own); // half a fork is not one; the parent is untouched
                fail(FAILED, format!("{error:#}"))
            }
        },
    }
}

/// What is asked for: from which time or frame on what changes.
struct Wanted {
    at: At,
    until: At,
    name: String,
    fragments: Vec<Fragment>,
    /// By a file that said it before, and where that lies.
    again: bool,
    file: Option<PathBuf>,
}

/// A time as a person or a file says it.
#[derive(Clone, Copy)]
enum At {
    Seconds(f64),
    Frame(Frame),
    /// The end of the parent.
    End,
}

/// The database of the parent, and what shall become of it.
fn wanted(args: &ForkArgs) -> anyhow::Result<(PathBuf, Wanted)> {
    let file = Path::new(&args.run);
    let again = file.extension().is_some_and(|e| e == "toml") && file.is_file();
    let until = args.until.map(At::Seconds);
    if again && args.at.is_none() && args.changes.is_empty() {
        let told = Told::read(file)?;
        let wanted = Wanted {
            at: At::Frame(told.at),
            until: until.or(told.until.map(At::Frame)).unwrap_or(At::End),
            name: args.name.clone().unwrap_or_else(|| told.name.clone()),
            fragments: told.fragments.clone(),
            again: true,
            file: args.name.is_none().then(|| file.to_owned()),
        };
        return Ok((chain::parent_of(file, &told)?, wanted));
    }
    let found = opened::databases(&args.run, Path::new(RUNS))?;
    let database = found.into_iter().next().context("no run was named")?;
    let wanted = Wanted {
        at: At::Seconds(args.at.unwrap_or(0.0)),
        until: until.unwrap_or(At::End),
        name: args.name.clone().unwrap_or_else(|| default_name(&args.changes)),
        fragments: vec![Fragment { at: None, changes: args.changes.clone() }],
        again: false,
        file: None,
    };
    Ok((database, wanted))
}

/// A fork that can be made: everything that a person may have said wrongly has been checked.
struct Fork {
    /// The run that was recorded: the parent, or that of which it was forked.
    root: Archive,
    parent_id: String,
    parent_digest: String,
    recording: PathBuf,
    folder: PathBuf,
    /// The folder was made for this fork, and goes with it where it fails.
    own: bool,
    name: String,
    plan: Plan,
}

/// From which frame on which scene.
struct Plan {
    before: Arc<Scene>,
    stages: Vec<Stage>,
    /// All that changed since the recording, the last value of each key.
    all: Vec<Change>,
    /// What this fork changes, by frame: key, value, what it was.
    changes: Vec<(Frame, String, String, Option<String>)>,
    /// Forks for the time line: frame, parent, what changed.
    forks: Vec<(Frame, String, Vec<Change>)>,
    at: Frame,
    until: Option<Frame>,
}

/// A key of the scene and its value.
type Change = (String, String);

fn prepare(database: &Path, wanted: &Wanted) -> anyhow::Result<Fork> {
    let chain = Chain::of(database)?;
    let parent = Archive::open(database)?;
    let root = Archive::open(&chain.database)?;
    let recording = chain.recording.clone();
    let forks = database.parent().unwrap_or(Path::new(".")).join("forks");
    let beside = wanted.file.as_deref().and_then(Path::parent);
    // A file that lies where its fork belongs, without one, gets it.
    let beside = beside.filter(|f| f.parent().is_some_and(|p| p.ends_with("forks")));
    let beside = beside.filter(|f| !f.join("run.sqlite").exists());
    let folder = beside.map_or_else(|| free(&forks, &wanted.name), Path::to_owned);
    let own = !folder.exists();
    let planned = kept_scene::write(&root, &folder)
        .and_then(|(text, path)| plan(&root, &parent, chain, wanted, &text, &path));
    let plan = planned.inspect_err(|_| forget(&folder, own))?;
    Ok(Fork {
        parent_id: opened::id_of(database),
        parent_digest: parent.fact("digest").unwrap_or_default(),
        recording,
        root,
        name: folder.file_name().map_or(wanted.name.clone(), |n| n.to_string_lossy().into_owned()),
        folder,
        own,
        plan,
    })
}

/// Takes away what was written of a fork.
fn forget(folder: &Path, own: bool) {
    if own {
        std::fs::remove_dir_all(folder).ok();
        return;
    }
    std::fs::remove_dir_all(folder.join("scene")).ok();
    for ending in ["", "-wal", "-shm"] {
        std::fs::remove_file(folder.join(format!("run.sqlite{ending}"))).ok();
    }
}

/// Whether a fork may last from a frame to another; a warning where the run it is of ends before.
fn span(
    at: Frame,
    until: Frame,
    period: u64,
    end: Frame,
    step_s: f64,
) -> anyhow::Result<Option<String>> {
    let seconds = |frame: Frame| (frame as f64 * step_s * 1e3).round() / 1e3;
    let (from, to) = (seconds(at), seconds(until));
    ensure!(
        until >= at + period,
        "--until {to}: the fork begins at {from} s and lasts a scan at least, to {} s",
        seconds(at + period)
    );
    let beyond = until > end;
    Ok(beyond
        .then(|| format!("--until {to}: the run ends at {} s, and the fork with it", seconds(end))))
}

/// Whether a fork may begin at a frame of a run that ends at another: there is a scan left for it.
fn begins(at: Frame, period: u64, end: Frame, step_s: f64) -> anyhow::Result<()> {
    let seconds = |frame: Frame| (frame as f64 * step_s * 1e3).round() / 1e3;
    ensure!(
        at + period <= end,
        "--at {}: the run ends at {} s, and a fork lasts a scan at least, of {} s",
        seconds(at),
        seconds(end),
        seconds(period)
    );
    Ok(())
}

/// From which frame on which scene, if all of it can be so.
fn plan(
    root: &Archive,
    parent: &Archive,
    chain: Chain,
    wanted: &Wanted,
    text: &str,
    path: &Path,
) -> anyhow::Result<Plan> {
    let before = change::load_changed(path, text, &[])?;
    let digest = root.fact("scene_digest").unwrap_or_default();
    let found = format!("{:016x}", before.hash);
    ensure!(
        digest == found,
        "the scene in the log has digest {found}, the run was made with {digest}: it cannot be forked"
    );
    let (step_s, period) = (before.run.frame.s(), u64::from(before.run.frames_per_scan));
    let frame_at = |s: f64| (s / step_s).round() as u64;
    let scan_from = |frame: Frame| frame.div_ceil(period) * period;
    let end_s = parent.sums_end_s().unwrap_or(0.0);
    let at_s = match wanted.at {
        At::Seconds(s) => s,
        At::Frame(frame) => frame as f64 * step_s,
        At::End => end_s,
    };
    ensure!(
        (0.0..=end_s).contains(&at_s),
        "--at {at_s}: the run lasts from 0 to {} s",
        (end_s * 1e3).round() / 1e3
    );
    let at = scan_from(frame_at(at_s));
    begins(at, period, frame_at(end_s), step_s)?;
    let until = match wanted.until {
        At::Seconds(s) => Some(frame_at(s)),
        At::Frame(frame) => Some(frame),
        At::End => chain.until,
    };
    if let Some(until) = until {
        let text = span(at, until, period, frame_at(end_s), step_s)?;
        text.into_iter().for_each(|text| tracing::warn!("{text}"));
    }
    let parent_id = opened::id_of(parent.path());
    let whole = |(from, parent, changes)| (scan_from(from), parent, changes);
    let mut forks: Vec<_> = chain.forks.into_iter().map(whole).collect();
    let known = forks.len();
    for fragment in &wanted.fragments {
        let from = fragment.at.map_or(at, scan_from);
        ensure!(from >= at, "at_frame {from} of a change is before that of the fork, {at}");
        forks.push((from, parent_id.clone(), fragment.changes.clone()));
    }
    let mut order: Vec<(Frame, bool, &[Change])> =
        forks.iter().enumerate().map(|(n, f)| (f.0, n >= known, &f.2[..])).collect();
    order.sort_by_key(|(from, _, _)| *from);
    let (mut all, mut changes, mut stages) =
        (Vec::<Change>::new(), Vec::new(), Vec::<Stage>::new());
    // What changes in one frame is one change.
    for group in order.chunk_by(|a, b| a.0 == b.0) {
        let (from, mut keys) = (group[0].0, Vec::new());
        for (_, own, list) in group {
            for (key, value) in *list {
                let known = all.iter_mut().find(|c| c.0 == *key);
                let was = known.as_ref().map(|c| c.1.clone());
                match known {
                    Some(known) => known.1.clone_from(value),
                    None => all.push((key.clone(), value.clone())),
                }
                if *own {
                    let was = was.or_else(|| value_before(text, key));
                    changes.push((from, key.clone(), value.clone(), was));
                }
                keys.push(&key[..]);
            }
        }
        if keys.is_empty() {
            continue;
        }
        let (amend, of_scene) = amend_of(&all, &before)?;
        let after = Arc::new(change::load_changed(path, text, &of_scene)?);
        let since = stages.last().map_or(0, |last| last.at);
        let warm_from = scan_from(frame_at((from as f64 * step_s - WARM_S).max(0.0))).max(since);
        let other_tracker = keys.iter().any(|key| key.starts_with("tracking."));
        let warm_from = other_tracker.then_some(warm_from);
        stages.push(Stage { at: from, warm_from, anew: anew_of(&keys), after, amend });
    }
    Ok(Plan { before: Arc::new(before), stages, all, changes, forks, at, until })
}

/// The changes that are not values of the scene, and the rest.
fn amend_of(
    changes: &[(String, String)],
    scene: &Scene,
) -> anyhow::Result<(Amend, Vec<(String, String)>)> {
    let (mut amend, mut rest) = (Amend::default(), Vec::new());
    let number = |key: &str, value: &str, low: f64, high: f64| -> anyhow::Result<f64> {
        let found: f64 =
            value.parse().with_context(|| format!("{key}: '{value}' is not a number"))?;
        ensure!((low..=high).contains(&found), "{key}: {found} is outside {low} to {high}");
        Ok(found)
    };
    for (key, value) in changes {
        match key.as_str() {
            "weather.rain_factor" => amend.rain_factor = number(key, value, 0.0, 1000.0)?,
            "weather.visibility_m" => {
                amend.visibility_m = Some(number(key, value, 1.0, 1e6)?);
            }
            "run.sensor_seed" => amend.seed = Some(cli::seed(value).map_err(anyhow::Error::msg)?),
            _ => match key.strip_prefix("sensor[").and_then(|k| k.strip_suffix("].enabled")) {
                Some(name) => {
                    let known: Vec<&str> = scene.sensors.iter().map(|s| &s.name[..]).collect();
                    ensure!(
                        known.contains(&name),
                        "{key}: there is no sensor '{name}'; there are {}",
                        known.join(", ")
                    );
                    match value.as_str() {
                        "false" => amend.off.push(name.to_owned()),
                        "true" => {}
                        _ => bail!("{key}: '{value}' is neither true nor false"),
                    }
                }
                None => rest.push((key.clone(), value.clone())),
            },
        }
    }
    Ok((amend, rest))
}

fn default_name(changes: &[(String, String)]) -> String {
    let Some((key, value)) = changes.first() else { return "again".to_owned() };
    let last = key.rsplit('.').next().unwrap_or(key);
    let of = key.split_once('[').and_then(|(_, k)| k.split_once(']')).map_or("", |(name, _)| name);
    let words = format!("{of} {last} {value}").to_lowercase();
    let mut name = String::new();
    for c in words.chars() {
        let c = if c.is_ascii_lowercase() || c.is_ascii_digit() { c } else { '-' };
        if !(c == '-' && (name.is_empty() || name.ends_with('-'))) {
            name.push(c);
        }
    }
    name.truncate(40);
    let name = name.trim_end_matches('-');
    if name.is_empty() { "fork".to_owned() } else { name.to_owned() }
}

/// The folder of that name, or with -2, -3 … where it is taken.
fn free(forks: &Path, name: &str) -> PathBuf {
    let first = forks.join(name);
    if !first.exists() {
        return first;
    }
    let named = (2..).map(|n| forks.join(format!("{name}-{n}")));
    named.into_iter().find(|f| !f.exists()).unwrap_or(first)
}

impl Fork {
    fn make(&self) -> anyhow::Result<PathBuf> {
        let fact = |name: &str| self.root.fact(name);
        let exercise: u8 = fact("exercise").and_then(|e| e.parse().ok()).unwrap_or(1);
        let recorded = replay::read(&self.recording, &self.plan.before, exercise)?;
        let period = u64::from(self.plan.before.run.frames_per_scan);
        let mut last = recorded.end.unwrap_or(recorded.last.next_multiple_of(period));
        last = last.min(self.plan.until.unwrap_or(last));
        // Logs of earlier versions name the scene's seed where the run had another.
        let seed = recorded.seed.or_else(|| fact("seed").and_then(|s| s.parse().ok()));
        let seed = seed.unwrap_or(self.plan.before.run.seed);
        let end = self.plan.stages.last();
        let after = end.map_or(&self.plan.before, |stage| &stage.after);
        let mut info = RunInfo::of(after, end.and_then(|s| s.amend.seed).unwrap_or(seed));
        info.fork = Some(self.parent_id.clone());
        info.title = format!("{} – {}", self.name, info.title);
        info.scene_digest = fact("scene_digest").unwrap_or_default();
        let mut log = Log::create(&self.folder.join("run.sqlite"), &info, &AirportMap::of(after))?;
        self.keep_about(&mut log)?;
        let rerun = Rerun { recorded: &recorded, scene: &self.plan.before, exercise, seed, last };
        // Up to the first change all is as it was; from there on tracks may be others.
        let same_to = self.plan.stages.first().map_or(Frame::MAX, |stage| stage.at);
        let noted = |scan: u64| {
            let same = scan.saturating_mul(period) <= same_to;
            // Where nobody said anything it is by map and speed.
            same.then(|| self.root.noted(scan).ok()).flatten().filter(|notes| !notes.is_empty())
        };
        let digests = rerun.write_log(&self.plan.stages, &mut log, noted, |frame, last| {
            ensure!(
                !STOP.load(Ordering::Relaxed),
                "interrupted at frame {frame} of {last}: nothing of the fork is kept"
            );
            Ok(())
        })?;
        for (name, value) in digests.facts() {
            log.fact(&name, &value)?;
        }
        log.close()?;
        std::fs::write(self.folder.join("fork.toml"), self.told(last))?;
        Ok(self.folder.clone())
    }

    /// What the log says beside scans: weather, flights, the fork itself.
    fn keep_about(&self, log: &mut Log) -> anyhow::Result<()> {
        let ns_of = |frame: Frame| frame as i64 * self.plan.before.run.frame.0;
        let stages: Vec<_> = self.plan.stages.iter().map(|s| (ns_of(s.at), &s.amend)).collect();
        for weather in amended(self.root.weather()?, &stages) {
            log.weather(&weather)?;
        }
        log.flights(&self.root.flights()?)?;
        for (at, parent, changes) in &self.plan.forks {
            let changes: Vec<String> =
                changes.iter().map(|c| format!("{} = {}", c.0, c.1)).collect();
            let text =
                if changes.is_empty() { "nothing changed".into() } else { changes.join(", ") };
            log.event(&Event {
                time_ns: ns_of(*at),
                kind: "fork".into(),
                subject: parent.clone(),
                text: format!("from {parent} on: {text}"),
            })?;
        }
        for (name, octets) in self.root.files()? {
            log.file(&name, &octets)?;
        }
        log.fact("scene_file", &self.root.fact("scene_file").unwrap_or_default())?;
        log.fact(kept_scene::CHANGES, &serde_json::to_string(&self.plan.all)?)?;
        Ok(())
    }

    fn told(&self, until: Frame) -> String {
        let text = |s: &str| serde_json::Value::from(s).to_string(); // a JSON text is a TOML text
        let mut out = format!(
            "[fork]\nversion = 1\nparent = {}\nparent_digest = {}\nscene_digest = {}\nat_frame = {}\nuntil_frame = {until}\nname = {}\nwarm = true\nmade = {}\nversion_of_seeds = {}\n",
            text(&self.parent_id),
            text(&self.parent_digest),
            text(&format!("{:016x}", self.plan.before.hash)),
            self.plan.at,
            text(&self.name),
            iso8601(utc_ns()),
            text(env!("CARGO_PKG_VERSION")),
        );
        for (from, key, value, was) in &self.plan.changes {
            let _ = write!(out, "\n[[change]]\nkey = {}\nvalue = {}\n", text(key), plain(value));
            if let Some(was) = was {
                let _ = writeln!(out, "was = {}", plain(was));
            }
            if *from != self.plan.at {
                let _ = writeln!(out, "at_frame = {from}");
            }
        }
        out
    }
}

/// The weather of a run as stages amend it, each from a time on, ns: notices that come then, and the one that is in force as it begins.
fn amended(notices: Vec<WeatherNotice>, stages: &[(i64, &Amend)]) -> Vec<WeatherNotice> {
    let as_told = Amend::default();
    let at = |ns: i64| stages.iter().rev().find(|s| s.0 <= ns).map_or(&as_told, |s| s.1);
    let in_force = stages.iter().filter_map(|(from_ns, amend)| {
        let notice = notices.iter().rfind(|w| w.from_ns <= *from_ns)?;
        let news = at(from_ns - 1).notice(notice.clone()) != amend.notice(notice.clone());
        (notice.from_ns < *from_ns && news)
            .then(|| WeatherNotice { from_ns: *from_ns, ..notice.clone() })
    });
    let in_force: Vec<_> = in_force.collect();
    let mut all = notices;
    all.extend(in_force);
    all.sort_by_key(|w| w.from_ns);
    all.into_iter().map(|w| at(w.from_ns).notice(w)).collect()
}

/// Which sensors are made again where these keys change.
fn anew_of(keys: &[&str]) -> Anew {
    let sensor = |key: &str| {
        let inside = key.strip_prefix("sensor[")?;
        Some(inside.split_once(']')?.0.to_owned())
    };
    let of_scene = keys.iter().filter(|key| is_of_scene(key));
    let of_scene: Vec<&&str> = of_scene.collect();
    let shared = |k: &&&str| sensor(k).is_none() && !k.starts_with("tracking.");
    if of_scene.iter().any(shared) {
        Anew::All
    } else {
        Anew::Named(of_scene.iter().filter_map(|k| sensor(k)).collect())
    }
}

/// Which of these keys change nothing in a fork, as one sentence: its movers are those of the recording.
fn without_effect<'a>(keys: impl Iterator<Item = &'a str>) -> Option<String> {
    let of_movers = |key: &&str| ["control", "traffic"].contains(&section(key));
    let mut found: Vec<&str> = keys.filter(of_movers).collect();
    found.sort_unstable();
    found.dedup();
    let (keys, they) =
        (found.join(", "), if found.len() == 1 { "it changes" } else { "they change" });
    (!found.is_empty()).then(|| {
        format!("{keys}: the movers of a fork are those of the recording, and {they} none of them; seeds run makes others")
    })
}

/// The table of the scene in which a key stands.
fn section(key: &str) -> &str {
    key.split(['.', '[']).next().unwrap_or(key)
}

/// What a key was before anything changed it, as TOML; none where the scene leaves it to the default.
fn value_before(text: &str, key: &str) -> Option<String> {
    match key {
        key if is_switch(key) => Some("true".to_owned()),
        "weather.rain_factor" => Some("1.0".to_owned()),
        "weather.visibility_m" | "run.sensor_seed" => None,
        key => change::value_at(text, key),
    }
}

/// A value as TOML: truth values and numbers as they are, all else a text.
fn plain(value: &str) -> String {
    let parsed = format!("v = {value}").parse::<toml::Table>().ok().and_then(|mut t| t.remove("v"));
    match parsed {
        Some(toml::Value::Boolean(_) | toml::Value::Integer(_) | toml::Value::Float(_)) => {
            value.to_owned()
        }
        _ => serde_json::Value::from(value).to_string(),
    }
}

/// Whether it is interrupted: half a fork is not one.
static STOP: AtomicBool = AtomicBool::new(false);

/// How long another tracker runs along before it takes over, s.
const WARM_S: f64 = 60.0;

#[cfg(test)]
mod tests;
