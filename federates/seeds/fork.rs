//! `seeds fork`: what if, from here. A recorded run again up to a time, bit by bit, and then with something changed.

use super::open::RUNS;
use super::replay;
use crate::exchange::flights::flight_notice;
use crate::runtime::cli::out;
use crate::runtime::cli::{self, BAD_INPUT, FAILED, fail};
use crate::runtime::codec::decode;
use crate::runtime::federate::{Federate, FrameInputs, FrameOut};
use crate::runtime::messages::{Notice, RunConfig, ScanReport};
use crate::smdfm::Smdfm;
use crate::smdfm::change::{Amend, Anew};
use crate::viewer_logger::archive::Archive;
use crate::viewer_logger::log::Log;
use crate::viewer_logger::picture::{AirportMap, RunInfo};
use crate::viewer_logger::source::Event;
use crate::viewer_logger::{kept_scene, opened};
use anyhow::{Context, bail, ensure};
use clap::Args;
use scenarios::{Scene, change};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

/// What if, from here: a recorded run again with something changed from a time on
#[derive(Args, Clone, Debug)]
pub struct ForkArgs {
    /// The run: a folder of runs/ or its name there, its database, or `last`
    #[arg(value_name = "RUN")]
    run: String,

    /// Simulated time from which on the changes hold, s [default: the start]
    #[arg(long, value_name = "T", default_value_t = 0.0)]
    at: f64,

    /// A change: a key of the scene (tracking.filter, sensor[NAME].range_max_m, …), sensor[NAME].enabled=false, weather.rain_factor, weather.visibility_m, run.sensor_seed
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
    let found = match opened::databases(&args.run, Path::new(RUNS)) {
        Ok(found) => found,
        Err(error) => return fail(BAD_INPUT, error),
    };
    let Some(database) = found.first() else { return fail(BAD_INPUT, "no run was named") };
    match prepare(database, args) {
        Err(error) => fail(BAD_INPUT, format!("{error:#}")),
        Ok(fork) => match fork.make() {
            Ok(folder) => {
                out!("seeds open {} {}", args.run, folder.display());
                ExitCode::SUCCESS
            }
            Err(error) => {
                std::fs::remove_dir_all(&fork.folder).ok(); // half a fork is none; the parent is untouched
                fail(FAILED, format!("{error:#}"))
            }
        },
    }
}

/// A fork that can be made: everything that a person may have said wrongly has been checked.
struct Fork {
    parent: Archive,
    parent_id: String,
    recording: PathBuf,
    folder: PathBuf,
    name: String,
    before: Arc<Scene>,
    after: Arc<Scene>,
    anew: Anew,
    amend: Amend,
    changes: Vec<(String, String, Option<String>)>,
    at_s: f64,
    until_s: Option<f64>,
}

fn prepare(database: &Path, args: &ForkArgs) -> anyhow::Result<Fork> {
    let parent = Archive::open(database)?;
    let recording = database.with_extension("pcapng");
    ensure!(
        recording.is_file(),
        "{}: there is no recording beside this database, and a fork is made of one",
        database.display()
    );
    let end_s = parent.sums_end_s().unwrap_or(0.0);
    ensure!(
        (0.0..=end_s).contains(&args.at),
        "--at {}: the run lasts from 0 to {end_s} s",
        args.at
    );
    let name = args.name.clone().unwrap_or_else(|| default_name(&args.changes));
    let forks = database.parent().unwrap_or(Path::new(".")).join("forks");
    let folder = free(&forks, &name);
    let (text, path) = kept_scene::write(&parent, &folder)?;
    let result = read_scenes(&parent, args, &text, &path);
    let (before, after, amend, anew, changes) = match result {
        Ok(read) => read,
        Err(error) => {
            std::fs::remove_dir_all(&folder).ok();
            return Err(error);
        }
    };
    Ok(Fork {
        parent_id: opened::id_of(database),
        parent,
        recording,
        name: folder.file_name().map_or(name, |n| n.to_string_lossy().into_owned()),
        folder,
        before,
        after,
        anew,
        amend,
        changes,
        at_s: args.at,
        until_s: args.until,
    })
}

type Read = (Arc<Scene>, Arc<Scene>, Amend, Anew, Vec<(String, String, Option<String>)>);

fn read_scenes(parent: &Archive, args: &ForkArgs, text: &str, path: &Path) -> anyhow::Result<Read> {
    let before = change::load_changed(path, text, &[])?;
    let digest = parent.fact("scene_digest").unwrap_or_default();
    let found = format!("{:016x}", before.hash);
    ensure!(
        digest == found,
        "the scene in the log has digest {found}, the run was made with {digest}: it cannot be forked"
    );
    let (amend, of_scene) = amend_of(&args.changes, &before)?;
    let changed: Vec<_> = of_scene.iter().map(|(k, v)| (k.clone(), v.clone())).collect();
    let after = change::load_changed(path, text, &changed)?;
    let sensor = |key: &str| {
        let inside = key.strip_prefix("sensor[")?;
        Some(inside.split_once(']')?.0.to_owned())
    };
    let shared = changed.iter().any(|(k, _)| sensor(k).is_none() && !k.starts_with("tracking."));
    let anew = if shared {
        Anew::All
    } else {
        Anew::Named(changed.iter().filter_map(|(k, _)| sensor(k)).collect())
    };
    let was = |key: &str| change::value_at(text, key);
    let changes =
        args.changes.iter().map(|(k, v)| (k.clone(), v.clone(), was(k))).collect::<Vec<_>>();
    Ok((Arc::new(before), Arc::new(after), amend, anew, changes))
}

/// The changes that are not values of the scene, and the rest.
fn amend_of(
    changes: &[(String, String)],
    scene: &Scene,
) -> anyhow::Result<(Amend, Vec<(String, String)>)> {
    let (mut amend, mut rest) = (Amend::default(), Vec::new());
    let number = |key: &str, value: &str, low: f64, high: f64| -> anyhow::Result<f64> {
        let found: f64 = value.parse().with_context(|| format!("{key}: '{value}' is no number"))?;
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
        let exercise: u8 = self.parent.fact("exercise").and_then(|e| e.parse().ok()).unwrap_or(1);
        let recorded = replay::read(&self.recording, &self.before, exercise)?;
        let mut smdfm = Smdfm::new(Arc::clone(&self.before), exercise).explaining(true);
        let period = smdfm.period();
        let step_s = self.before.run.frame.s();
        let frame_at = |s: f64| (s / step_s).round() as u64;
        let mut last = recorded.end.unwrap_or(recorded.last.next_multiple_of(period));
        if let Some(until_s) = self.until_s {
            last = last.min(frame_at(until_s));
        }
        let at = frame_at(self.at_s).div_ceil(period) * period;
        let warm_at = frame_at((self.at_s - WARM_S).max(0.0)).div_ceil(period) * period;
        let other_tracker = self.changes.iter().any(|c| c.0.starts_with("tracking."));
        let seed = self.parent.fact("seed").and_then(|s| s.parse().ok()).or(recorded.seed);
        let seed = seed.unwrap_or(self.before.run.seed);
        let config =
            RunConfig { run: 1, seed, generators: 1, last_frame: last, ..RunConfig::default() };
        smdfm.configure(&config, &mut FrameOut::default()).map_err(anyhow::Error::msg)?;
        let mut info = RunInfo::of(&self.after, self.amend.seed.unwrap_or(seed));
        info.fork = Some(self.parent_id.clone());
        info.title = format!("{} – {}", self.name, info.title);
        info.scene_digest = self.parent.fact("scene_digest").unwrap_or_default();
        let mut log =
            Log::create(&self.folder.join("run.sqlite"), &info, &AirportMap::of(&self.after))?;
        self.keep_about(&mut log, at as f64 * step_s)?;
        let flights = self.before.flight_list.entries.iter().map(flight_notice).collect();
        let mut notices = vec![(0, Notice::Flights(flights))];
        for scan in 1..=last / period {
            let frame = scan * period;
            if other_tracker && frame == warm_at + period {
                smdfm.warm_up(&self.after);
            }
            if frame == at + period && !self.changes.is_empty() {
                let amend = self.amend.clone();
                smdfm.change(&self.after, &self.anew, amend).map_err(anyhow::Error::msg)?;
            }
            let inputs = FrameInputs {
                notices: std::mem::take(&mut notices),
                pdus: recorded.pdus(frame - period + u64::from(scan > 1)..=frame),
                ..FrameInputs::default()
            };
            let mut made = FrameOut::default();
            smdfm.step(frame, &inputs, &mut made);
            for publication in &made.publish {
                if publication.key == "tracks/1/scan" {
                    let report: ScanReport = decode(&publication.body)?;
                    log.scan(&report)?;
                }
            }
        }
        log.close()?;
        std::fs::write(self.folder.join("fork.toml"), self.told(at, last))?;
        Ok(self.folder.clone())
    }

    /// What the log says beside scans: weather, flights, the fork itself.
    fn keep_about(&self, log: &mut Log, at_s: f64) -> anyhow::Result<()> {
        for mut weather in self.parent.weather()? {
            if weather.from_ns as f64 * 1e-9 >= at_s {
                weather.rain_mm_per_h *= self.amend.rain_factor;
                weather.visibility_m = self.amend.visibility_m.unwrap_or(weather.visibility_m);
            }
            log.weather(&weather)?;
        }
        log.flights(&self.parent.flights()?)?;
        let changes: Vec<String> =
            self.changes.iter().map(|c| format!("{} = {}", c.0, c.1)).collect();
        let text = if changes.is_empty() { "nothing changed".into() } else { changes.join(", ") };
        log.event(&Event {
            time_ns: (at_s * 1e9) as i64,
            kind: "fork".into(),
            subject: self.parent_id.clone(),
            text: format!("from {} on: {text}", self.parent_id),
        })?;
        for (name, octets) in self.parent.files()? {
            log.file(&name, &octets)?;
        }
        log.fact("scene_file", &self.parent.fact("scene_file").unwrap_or_default())?;
        let changes: Vec<_> = self.changes.iter().map(|c| (&c.0, &c.1)).collect();
        log.fact(kept_scene::CHANGES, &serde_json::to_string(&changes)?)?;
        Ok(())
    }

    fn told(&self, at: u64, until: u64) -> String {
        let text = |s: &str| serde_json::Value::from(s).to_string(); // a JSON text is a TOML text
        let mut out = format!(
            "[fork]\nversion = 1\nparent = {}\nparent_digest = {}\nscene_digest = {}\nat_frame = {at}\nuntil_frame = {until}\nname = {}\nwarm = true\nversion_of_seeds = {}\n",
            text(&self.parent_id),
            text(&self.parent.fact("digest").unwrap_or_default()),
            text(&format!("{:016x}", self.before.hash)),
            text(&self.name),
            text(env!("CARGO_PKG_VERSION")),
        );
        for (key, value, was) in &self.changes {
            let _ = write!(out, "\n[[change]]\nkey = {}\nvalue = {}\n", text(key), text(value));
            if let Some(was) = was {
                let _ = writeln!(out, "was = {}", text(was));
            }
        }
        out
    }
}

/// How long another tracker runs along before it takes over, s.
const WARM_S: f64 = 60.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fork_has_a_name_that_says_what_changed() {
        let of = |key: &str, value: &str| default_name(&[(key.to_owned(), value.to_owned())]);
        assert_eq!(of("tracking.filter", "abg"), "filter-abg");
        assert_eq!(of("sensor[ASDE tower].enabled", "false"), "asde-tower-enabled-false");
        assert_eq!(of("a.ö", "ß"), "fork");
        assert_eq!(default_name(&[]), "again");
        assert!(name_of(&of("weather.rain_factor", &"9".repeat(99))).is_ok());
        for bad in ["", "A", "a b", "../x", &"a".repeat(41)] {
            assert!(name_of(bad).is_err(), "{bad}");
        }
        for bad in ["", "a", "=1", "a="] {
            assert!(change_of(bad).is_err(), "{bad}");
        }
    }
}
