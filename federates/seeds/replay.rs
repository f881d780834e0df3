//! `seeds replay FILE --with-smdfm`: an SMDFM on a recording instead of on live traffic.
//!
//! The player makes the frame ends from the timestamps of the PDUs; the flight list comes from the
//! scene. For a recording without loss the digests equal the run's.

use super::player::{self, PlayerArgs};
use crate::admin_station::summary::RunSummary;
use crate::exchange::control_records;
use crate::exchange::entity_state::is_frozen;
use crate::exchange::stamp;
use crate::exchange::{flights::flight_notice, weather_pdu::WORLD_APPLICATION};
use crate::runtime::cli::print_line;
use crate::runtime::cli::{self, COMPLETE, DATA_LOST, load_scene_without_truth};
use crate::runtime::conductor::ClosedRun;
use crate::runtime::digest::{Digest, pdu_hash};
use crate::runtime::federate::{Federate, FrameInputs, FrameOut, Octets};
use crate::runtime::frame_time::FrameTime;
use crate::runtime::messages::{FinalReport, Frame, Notice, RunConfig};
use crate::smdfm::Smdfm;
use anyhow::Context;
use clap::Args;
use pdu::Body;
use pdu::enumerations::StopReason;
use pdu::records::EntityId;
use scenarios::Scene;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

/// Send a recording again, or run an SMDFM on it
#[derive(Args, Clone, Debug)]
pub struct ReplayArgs {
    #[command(flatten)]
    player: PlayerArgs,

    /// Run an SMDFM on the whole recording, as fast as possible; nothing is sent, so every option of sending (--rate, --from, --to, --loop, --dis …) is refused
    #[arg(long, conflicts_with_all = OF_SENDING)]
    with_smdfm: bool,

    /// Scene of the recording (with --with-smdfm): a TOML file, or the name of a scene
    #[arg(long, value_name = "SCENE", default_value = "zurich", requires = "with_smdfm")]
    scene: String,

    /// DIS exercise of the recording (with --with-smdfm), 0 to 255 [default: the scene's]
    #[arg(long = "of-exercise", value_name = "N", requires = "with_smdfm")]
    of_exercise: Option<u8>,

    /// Seed of the sensors' draws (with --with-smdfm) [default: the recorded run's, else the scene's]
    #[arg(long, value_name = "N", requires = "with_smdfm", value_parser = cli::seed)]
    seed: Option<u64>,
}

/// Options (and groups of them) that say how a recording is sent.
const OF_SENDING: [&str; 12] = [
    "rate",
    "fast",
    "schedule",
    "from",
    "to",
    "looping",
    "start_on_resume",
    "stamps",
    "lasting",
    "control",
    "LinkArgs",
    "RewriteArgs",
];

/// Replays.
#[must_use]
pub fn run(args: ReplayArgs) -> ExitCode {
    if !args.with_smdfm {
        return super::finished(player::run(args.player));
    }
    cli::log_to_stderr(cli::LogFormat::Text, "warn");
    let scene = match load_scene_without_truth(&args.scene) {
        Ok(scene) => Arc::new(scene),
        Err(code) => return code,
    };
    let exercise = args.of_exercise.unwrap_or(scene.run.exercise);
    match with_smdfm(&args.player.file, &scene, exercise, args.seed, |_, _| {}) {
        Ok(replayed) => {
            print_line(&replayed.summary.line());
            ExitCode::from(if replayed.damaged > 0 { DATA_LOST } else { COMPLETE })
        }
        Err(e) => super::finished(Err(e)),
    }
}

/// What a recording holds of a run.
#[derive(Default)]
pub(super) struct Recorded {
    pub(super) frames: BTreeMap<Frame, Vec<Octets>>,
    /// PDUs of outsiders that no frame let in.
    outsiders: u64,
    seen: BTreeSet<(Frame, u64)>,
    pub(super) last: Frame,
    pub(super) end: Option<Frame>,
    pub(super) seed: Option<u64>,
    unsound: u64,
    damaged: u64,
    /// The frame in which an entity was last said to stand.
    stood: BTreeMap<EntityId, Frame>,
}

/// Runs an SMDFM on a recording; the summary has the same keys as that of a run.
///
/// # Errors
/// If the recording cannot be read, or holds nothing of this scene.
pub fn with_smdfm(
    file: &Path,
    scene: &Arc<Scene>,
    exercise: u8,
    seed: Option<u64>,
    mut progress: impl FnMut(Frame, Frame),
) -> anyhow::Result<Replayed> {
    let recorded = read(file, scene, exercise)?;
    anyhow::ensure!(
        !recorded.frames.is_empty(),
        "{}: no PDU of scene '{}' (site {}, exercise {exercise}) in this recording: check --scene and --of-exercise",
        file.display(),
        scene.name,
        scene.run.site
    );
    let stamped = |pdus: &Vec<Octets>| pdus.iter().any(|octets| stamp::is_stamped(octets));
    if recorded.outsiders > 0 && !recorded.frames.values().any(stamped) {
        tracing::warn!(
            "{}: {} PDUs of outsiders without a frame are left out: no member 'visitors' took part in that run",
            file.display(),
            recorded.outsiders
        );
    }
    let started = crate::runtime::clock::monotonic_ns();
    let mut smdfm = Smdfm::new(Arc::clone(scene), exercise);
    let period = smdfm.period();
    // Without the run's own end mark: the last whole scan that has a PDU.
    let last_frame = recorded.end.unwrap_or(recorded.last.next_multiple_of(period));
    let seed = seed.or(recorded.seed).unwrap_or(scene.run.seed);
    let config = RunConfig { run: 1, seed, generators: 1, last_frame, ..RunConfig::default() };
    let mut out = FrameOut::default();
    smdfm.configure(&config, &mut out).map_err(|e| anyhow::anyhow!(e))?;

    let flights = scene.flight_list.entries.iter().map(flight_notice).collect();
    let mut notices = vec![(0, Notice::Flights(flights))];
    let mut next = 0;
    for scan in 1..=last_frame / period {
        let frame = scan * period;
        let inputs = FrameInputs {
            notices: std::mem::take(&mut notices),
            pdus: recorded.pdus(next..=frame),
            ..FrameInputs::default()
        };
        next = frame + 1;
        smdfm.step(frame, &inputs, &mut FrameOut::default());
        progress(frame, last_frame);
    }
    let mut report =
        FinalReport { run: 1, name: "smdfm".into(), frame: last_frame, ..Default::default() };
    let received: usize = recorded.frames.range(..=last_frame).map(|(_, pdus)| pdus.len()).sum();
    report.values.push(("pdus_received".into(), received as f64));
    smdfm.finish(&mut report);
    let [world, mut traffic] = recorded.producers(last_frame);
    traffic.values.push(("entities".into(), scene.traffic.entities.len() as f64));
    let run = ClosedRun {
        run: 1,
        seed,
        frame: last_frame,
        wall_ns: crate::runtime::clock::monotonic_ns() - started,
        reports: vec![world, report, traffic],
        failed: false,
        reasons: Vec::new(),
    };
    let mut summary = RunSummary::of(&run, &scene.name, scene.run.frame.0);
    summary.federates = vec!["replay".into(), "smdfm".into()];
    summary.truth.lost = recorded.unsound;
    Ok(Replayed { summary, damaged: recorded.damaged })
}

/// What an SMDFM made of a recording.
#[derive(Debug)]
pub struct Replayed {
    /// As of a run.
    pub summary: RunSummary,
    /// Places of the file that could not be read: datagrams may be missing.
    pub damaged: u64,
}

/// Which member made a PDU of the federation.
enum Maker {
    Traffic,
    World,
    Visitors,
}

fn maker(octets: &[u8]) -> Maker {
    use pdu::enumerations::PduType;
    match octets.get(2) {
        Some(&t) if t == PduType::ENVIRONMENTAL_PROCESS.0 => Maker::World,
        Some(&t) if t == PduType::EVENT_REPORT.0 => Maker::Visitors,
        _ => Maker::Traffic,
    }
}

pub(super) fn read(file: &Path, scene: &Scene, exercise: u8) -> anyhow::Result<Recorded> {
    let time = FrameTime::of(&scene.run);
    let mut reader =
        capture::Reader::open(file).with_context(|| format!("opening {}", file.display()))?;
    let mut datagram = capture::Datagram::empty();
    let mut recorded = Recorded::default();
    while let Some(read) = reader.read(&mut datagram) {
        if let Err(problem) = read {
            recorded.damaged += 1;
            recorded.unsound += 1;
            tracing::warn!("{}: {problem}", file.display());
            continue;
        }
        for received in pdu::pdus(&datagram.payload) {
            // Others may send what they like: that is no loss of ours.
            let Ok(received) = received else { continue };
            if received.header().exercise_id == exercise {
                recorded.take(&received, scene, time);
            }
        }
    }
    Ok(recorded)
}

impl Recorded {
    /// What those who made the PDUs up to a frame (those after the last whole scan, too) would report: external world, traffic.
    pub(super) fn producers(&self, last: Frame) -> [FinalReport; 2] {
        let (mut truth, mut weather) = (Digest::default(), Digest::default());
        for (of, pdus) in self.frames.range(..=last) {
            for octets in pdus {
                match maker(octets) {
                    Maker::World => weather.add(*of, octets),
                    Maker::Traffic => truth.add(*of, octets),
                    Maker::Visitors => {}
                }
            }
        }
        [("external-world", weather), ("traffic-generator", truth)].map(|(name, digest)| {
            let digests = vec![("pdus".into(), digest.0)];
            let name = name.into();
            FinalReport { run: 1, name, frame: last, digests, ..FinalReport::default() }
        })
    }

    /// The PDUs of some frames, as a step takes them.
    pub(super) fn pdus(&self, frames: std::ops::RangeInclusive<Frame>) -> Vec<(Frame, Octets)> {
        let sorted = |(of, pdus): (&Frame, &Vec<Octets>)| {
            let mut pdus = pdus.clone();
            pdus.sort();
            pdus.into_iter().map(|octets| (*of, octets)).collect::<Vec<_>>()
        };
        self.frames.range(frames).flat_map(sorted).collect()
    }

    fn take(&mut self, received: &pdu::Received<'_>, scene: &Scene, time: FrameTime) {
        let site = scene.run.site;
        // What control tells those who look on is made again by it.
        if control_records::is_of_control(received.body(), site) {
            return;
        }
        let station =
            |id: pdu::records::EntityId| id.site == site && id.application == WORLD_APPLICATION;
        let frame = time.frame_of(received.header().timestamp, self.last);
        let of_scene = |id: pdu::records::EntityId| {
            let known = |e: &scenarios::Entity| (e.application, e.number);
            let named = (id.application, id.entity);
            id.site == site && scene.traffic.entities.iter().any(|e| known(e) == named)
        };
        let ours = match received.body() {
            Body::EntityState(state) => {
                let ours = of_scene(state.entity_id);
                // What was told while time stood, and when it went on, is of no frame.
                if ours && is_frozen(state) {
                    self.stood.extend(frame.map(|frame| (state.entity_id, frame)));
                    return;
                }
                if ours && frame.is_some() && self.stood.get(&state.entity_id) == frame.as_ref() {
                    return;
                }
                ours
            }
            Body::Iff(iff) => of_scene(iff.basic.emitting_entity),
            Body::EnvironmentalProcess(process) => station(process.process_id),
            Body::EventReport(report) => {
                if stamp::decode(report, site).is_none()
                    && stamp::decode_plots(report, site).is_none()
                {
                    return;
                }
                true
            }
            Body::Comment(comment) if station(comment.originating_id) => {
                self.seed = self.seed.or(crate::admin_station::simman::seed_of(comment));
                return;
            }
            Body::StopFreeze(stop) => {
                if station(stop.originating_id) && stop.reason == StopReason::TERMINATION {
                    self.end = self.end.or(frame);
                }
                return;
            }
            _ => return,
        };
        // A second run in the same recording (restart) is not mixed into the first.
        if self.end.is_some() {
            return;
        }
        let octets: Octets = Arc::from(received.octets);
        match frame {
            Some(frame) if ours => {
                if self.seen.insert((frame, pdu_hash(&octets))) {
                    self.frames.entry(frame).or_default().push(octets);
                    self.last = self.last.max(frame);
                }
            }
            _ if !ours => self.outsiders += 1,
            _ => self.unsound += 1,
        }
    }
}
