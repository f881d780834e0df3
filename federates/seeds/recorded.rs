//! `seeds open RECORDING`: a database is made first of a recording that has none beside it.
//!
//! With its scene an SMDFM runs over it; without one there is truth alone, as its PDUs say it, on a map of its own bounds.

use super::replay;
use super::rerun::Rerun;
use crate::exchange::flights::flight_notice;
use crate::exchange::weather_notice::notice_of;
use crate::runtime::messages::{ScanReport, TruthMessage};
use crate::viewer_logger::kept_scene;
use crate::viewer_logger::log::Log;
use crate::viewer_logger::named;
use crate::viewer_logger::picture::{AirportMap, NamedPoint, RunInfo};
use anyhow::{Context, bail, ensure};
use geodesy::{Ecef, LocalFrame};
use models::frames::Point3;
use pdu::Body;
use pdu::exercise::{Arrival, Exercise, Limits};
use std::collections::BTreeMap;
use std::io::{IsTerminal as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Databases made for one process, which go with it.
#[derive(Debug, Default)]
pub(super) struct Made {
    folder: Option<PathBuf>,
    stop: Arc<AtomicBool>,
}

impl Drop for Made {
    fn drop(&mut self) {
        if let Some(folder) = &self.folder {
            std::fs::remove_dir_all(folder).ok();
        }
    }
}

/// Ends what is made for somebody who does not want it any more.
fn go_on(stop: &AtomicBool) -> anyhow::Result<()> {
    ensure!(!stop.load(Ordering::Relaxed), "interrupted before the recording was read to its end");
    Ok(())
}

impl Made {
    /// Makes none any more as soon as that is set.
    pub(super) fn until(stop: Arc<AtomicBool>) -> Self {
        Self { folder: None, stop }
    }

    /// The database of a recording.
    ///
    /// # Errors
    /// If the recording cannot be read, or holds nothing that could be shown.
    pub(super) fn of(&mut self, recording: &Path, scene: Option<&str>) -> anyhow::Result<PathBuf> {
        let folder = match &self.folder {
            Some(folder) => folder.clone(),
            None => {
                let own = format!("seeds-open-{}", std::process::id());
                let folder = std::env::temp_dir().join(own);
                std::fs::create_dir_all(&folder)
                    .with_context(|| format!("making {}", folder.display()))?;
                self.folder = Some(folder.clone());
                folder
            }
        };
        let stem = recording.file_stem().map(|s| s.to_string_lossy().into_owned());
        let stem = stem.unwrap_or_default();
        let file = (1..).map(|n| match n {
            1 => folder.join(format!("{stem}.sqlite")),
            n => folder.join(format!("{stem}_{n}.sqlite")),
        });
        let file = file.into_iter().find(|f| !f.exists()).context("no name is free")?;
        match scene {
            Some(scene) => with_smdfm(recording, scene, &file, &self.stop)?,
            None => truth_alone(recording, &file, &self.stop)?,
        }
        Ok(file)
    }
}

fn with_smdfm(recording: &Path, scene: &str, file: &Path, stop: &AtomicBool) -> anyhow::Result<()> {
    let scene = Arc::new(scenarios::load_without_truth(&scenarios::locate(scene))?);
    let exercise = scene.run.exercise;
    let recorded = replay::read(recording, &scene, exercise)?;
    ensure!(
        !recorded.frames.is_empty(),
        "{}: no PDU of scene '{}' (site {}, exercise {exercise}) in this recording: check --scene",
        recording.display(),
        scene.name,
        scene.run.site
    );
    let period = u64::from(scene.run.frames_per_scan);
    let last = recorded.end.unwrap_or(recorded.last.next_multiple_of(period));
    let seed = recorded.seed.unwrap_or(scene.run.seed);
    let mut log = Log::create(file, &RunInfo::of(&scene, seed), &AirportMap::of(&scene))?;
    kept_scene::keep(&mut log, &scene);
    for weather in &scene.weather {
        log.weather(&notice_of(&weather.weather, weather.time))?;
    }
    let flights: Vec<_> = scene.flight_list.entries.iter().map(flight_notice).collect();
    log.flights(&flights)?;
    let rerun = Rerun { recorded: &recorded, scene: &scene, exercise, seed, last };
    let shows = std::io::stderr().is_terminal();
    let mut told = 0;
    let digests = rerun.write_log(
        &[],
        &mut log,
        |_| None,
        |frame, last| {
            let percent = 100 * frame / last.max(1);
            if shows && percent > told {
                told = percent;
                let _ = write!(std::io::stderr(), "\r{percent} % of {}", recording.display());
            }
            go_on(stop)
        },
    )?;
    if shows {
        let _ = writeln!(std::io::stderr());
    }
    for (name, value) in digests.facts() {
        log.fact(&name, &value)?;
    }
    Ok(log.close()?)
}

/// Scans of a recording of unknown length that are made at most: more than a day.
const MOST_SCANS: u64 = 100_000;
const SECOND_NS: i64 = 1_000_000_000;
const HOUR_NS: i64 = 3600 * SECOND_NS;
/// Nothing stands so long behind its place in a recording.
const LATEST_NS: i64 = 10 * SECOND_NS;
/// Heartbeats of what is parked are a minute long with us, s.
const SILENCE_S: f64 = 150.0;

/// What is heard, second by second.
struct Truth {
    log: Log,
    exercise: Exercise,
    frame: LocalFrame,
    begin_ns: i64,
    scans: u64,
    /// Least and largest place, m east and north.
    bounds_m: Option<[f64; 4]>,
}

fn truth_alone(recording: &Path, file: &Path, stop: &AtomicBool) -> anyhow::Result<()> {
    let doing = || format!("opening {}", recording.display());
    let mut reader = capture::Reader::open(recording).with_context(doing)?;
    let mut datagram = capture::Datagram::empty();
    let (mut truth, mut now_ns) = (None::<Truth>, None::<i64>);
    // What was lost and asked for again stands behind what came after it.
    let mut waiting: BTreeMap<(i64, u64), Vec<u8>> = BTreeMap::new();
    let mut number = 0;
    while let Some(read) = reader.read(&mut datagram) {
        go_on(stop)?;
        if let Err(problem) = read {
            tracing::warn!("{}: {problem}", recording.display());
            continue;
        }
        for received in pdu::pdus(&datagram.payload).flatten() {
            let stamp = received.header().timestamp;
            // A run that went faster than time says by its stamps when things were.
            let at_ns = match now_ns {
                _ if !stamp.is_absolute() => datagram.utc_ns,
                near => {
                    let near_ns = near.unwrap_or(datagram.utc_ns);
                    let ahead = stamp.nanos_past_hour() as i64 - near_ns;
                    let ahead = ahead.rem_euclid(HOUR_NS);
                    near_ns + if ahead > HOUR_NS / 2 { ahead - HOUR_NS } else { ahead }
                }
            };
            if truth.is_none() {
                let Body::EntityState(state) = received.body() else { continue };
                let [x_m, y_m, z_m] = [state.location.x_m, state.location.y_m, state.location.z_m];
                if ![x_m, y_m, z_m].iter().all(|m| m.is_finite()) {
                    continue;
                }
                let origin = Ecef { x_m, y_m, z_m }.to_geodetic();
                let id = received.header().exercise_id;
                truth = Some(Truth::begin(recording, file, (id, at_ns), LocalFrame::at(origin))?);
            }
            let Some(truth) = &mut truth else { continue };
            now_ns = Some(at_ns.max(now_ns.unwrap_or(at_ns)));
            number += 1;
            waiting.insert((at_ns, number), received.octets.to_vec());
            let until_ns = now_ns.map_or(at_ns, |now| now - LATEST_NS);
            while let Some(first) = waiting.first_entry().filter(|w| w.key().0 <= until_ns) {
                let (at, octets) = first.remove_entry();
                truth.hears(at.0, &octets)?;
            }
        }
    }
    if let Some(truth) = &mut truth {
        for ((at_ns, _), octets) in waiting {
            truth.hears(at_ns, &octets)?;
        }
    }
    let (Some(mut truth), Some(last_ns)) = (truth, now_ns) else {
        bail!(
            "{}: there is no Entity State PDU in it, so there is nothing to show",
            recording.display()
        );
    };
    truth.up_to(last_ns + SECOND_NS)?;
    truth.end()
}

impl Truth {
    fn begin(
        recording: &Path,
        file: &Path,
        (id, at_ns): (u8, i64),
        frame: LocalFrame,
    ) -> anyhow::Result<Self> {
        let begin_ns = at_ns.div_euclid(SECOND_NS) * SECOND_NS;
        let name = recording.file_stem().map(|s| s.to_string_lossy().into_owned());
        let name = name.unwrap_or_default();
        let info = RunInfo {
            title: format!("{name}: recorded truth"),
            scene: name,
            exercise: id,
            start_utc_ns: begin_ns,
            scan_s: 1.0,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            ..RunInfo::default()
        };
        let place = frame.origin_geodetic();
        let reference_deg = [place.lat_deg(), place.lon_deg()];
        let map = AirportMap { reference_deg, ..AirportMap::default() };
        let log = Log::create(file, &info, &map)?;
        let limits = Limits { silence_s: SILENCE_S, ..Limits::default() };
        let exercise = Exercise::with_limits(id, limits);
        Ok(Self { log, exercise, frame, begin_ns, scans: 0, bounds_m: None })
    }

    /// A PDU of a time, in the order of times.
    fn hears(&mut self, at_ns: i64, octets: &[u8]) -> anyhow::Result<()> {
        self.up_to(at_ns)?;
        self.exercise.feed(&Arrival::in_real_time(at_ns), octets);
        Ok(())
    }

    /// Writes every whole second before a time.
    fn up_to(&mut self, now_ns: i64) -> anyhow::Result<()> {
        loop {
            let time_ns = (self.scans as i64 + 1) * SECOND_NS;
            let at_ns = self.begin_ns + time_ns;
            if at_ns >= now_ns || self.scans >= MOST_SCANS {
                return Ok(());
            }
            self.scans += 1;
            let truth = self.exercise.at(at_ns).map(|(entity, placed)| {
                let state =
                    crate::exchange::entity_state::target_state(&placed.estimate, &self.frame);
                let (id, kind) = (entity.id(), entity.entity_type());
                TruthMessage {
                    id: [id.site, id.application, id.entity],
                    callsign: entity.marking(),
                    address: None,
                    type_designator: String::new(),
                    aircraft: kind.domain == AIR,
                    size_m: [0.0; 2],
                    position_m: Point3::from(state.position_m.coords),
                    velocity_mps: (state.velocity_mps * placed.pace).into(),
                    heading_rad: state.heading_rad,
                    ours: true,
                    track: None,
                }
            });
            let truth: Vec<TruthMessage> = truth.collect();
            for [x, y, _] in truth.iter().map(|t| <[f64; 3]>::from(t.position_m.coords)) {
                let [x0, y0, x1, y1] = self.bounds_m.unwrap_or([x, y, x, y]);
                self.bounds_m = Some([x0.min(x), y0.min(y), x1.max(x), y1.max(y)]);
            }
            let scan = self.scans;
            self.log.scan(&ScanReport { run: 1, scan, time_ns, truth, ..ScanReport::default() })?;
        }
    }

    fn end(mut self) -> anyhow::Result<()> {
        let place = self.frame.origin_geodetic();
        let corner = |x: f64, y: f64| NamedPoint { name: String::new(), position_m: [x, y] };
        let map = AirportMap {
            reference_deg: [place.lat_deg(), place.lon_deg()],
            // So that the page knows where to look.
            stands: self
                .bounds_m
                .map_or_else(Vec::new, |[x0, y0, x1, y1]| vec![corner(x0, y0), corner(x1, y1)]),
            ..AirportMap::default()
        };
        self.log.fact("map_json", &serde_json::to_string(&map)?)?;
        self.log.fact("duration_s", &self.scans.to_string())?;
        Ok(self.log.close()?)
    }
}

/// Domain of entity types that fly (SISO-REF-010).
const AIR: u8 = 2;

/// The recording that a person named where its database is not beside it.
pub(super) fn recording_alone(word: &str) -> Option<PathBuf> {
    let path = PathBuf::from(word);
    let alone =
        path.is_file() && named::is_recording(&path) && !named::database_of(&path).is_file();
    alone.then_some(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::SocketAddr;

    #[test]
    fn who_is_interrupted_leaves_no_database_behind() {
        let name = format!("seeds-cut-short-{}.pcapng", std::process::id());
        let recording = std::env::temp_dir().join(name);
        let mut recorder = capture::Recorder::create(&recording).expect("a recording");
        let port = SocketAddr::from(([127, 0, 0, 1], 3000));
        recorder.record(1, port, port, &[7; 144]).expect("written");
        recorder.close(0).expect("closed");
        let mut made = Made::until(Arc::new(AtomicBool::new(true)));
        let error = made.of(&recording, None).expect_err("ended").to_string();
        let folder = made.folder.clone().expect("a folder");
        assert!(error.contains("interrupted") && folder.exists(), "{error}");
        drop(made);
        assert!(!folder.exists());
        std::fs::remove_file(&recording).expect("removed");
    }
}
