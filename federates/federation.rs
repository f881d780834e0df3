//! Which federates a scene needs, how they are called, and how the conductor is set up for them.

use crate::runtime::conductor::ConductorConfig;
use crate::runtime::messages::{Frame, Kind};
use scenarios::Scene;
use scenarios::control::Sees;
use scenarios::losses::Losses;
use std::collections::BTreeMap;

/// The name of the gateway among spectators.
pub const GATEWAY: &str = "gateway";

/// What a run may override of its scene.
#[derive(Clone, Debug, PartialEq)]
pub struct RunOptions {
    /// Seed; the scene's if none.
    pub seed: Option<u64>,
    /// Simulated duration, s; the scene's if none.
    pub duration_s: Option<f64>,
    /// Simulated seconds per wall second; infinite = as fast as possible.
    pub rate: f64,
    /// Traffic generators that share the traffic.
    pub generators: u32,
    /// SMDFMs that share the sensors.
    pub smdfms: u32,
    /// Start as soon as all are ready.
    pub autostart: bool,
    /// End with the run.
    pub batch: bool,
    /// Whether the member `visitors` takes part.
    pub visitors: bool,
    /// What becomes of a run that loses a federate; what it does not say is as the scene has it.
    pub losses: Losses,
}

impl Default for RunOptions {
    fn default() -> Self {
        Self {
            seed: None,
            duration_s: None,
            rate: 1.0,
            generators: 1,
            smdfms: 1,
            autostart: true,
            batch: true,
            visitors: false,
            losses: Losses::default(),
        }
    }
}

/// Frames granted ahead of the slowest member when as fast as possible: two scans.
const WINDOW_SCANS: u64 = 2;

/// Name of traffic generator `share` (from 1) of `of`.
#[must_use]
pub fn generator_name(share: u32, of: u32) -> String {
    if of <= 1 {
        Kind::TrafficGenerator.name().to_owned()
    } else {
        format!("{}-{share}", Kind::TrafficGenerator.name())
    }
}

/// Most SMDFMs of a federation.
pub const MOST_SMDFMS: u32 = 8;

/// Name of SMDFM `share` (from 1): the first fuses the plots of all and is the one that others know.
#[must_use]
pub fn smdfm_name(share: u32) -> String {
    if share <= 1 {
        Kind::Smdfm.name().to_owned()
    } else {
        format!("{}-{share}", Kind::Smdfm.name())
    }
}

/// Whether a member is an SMDFM that tells its plots to the first.
#[must_use]
pub fn is_front_end(name: &str) -> bool {
    let number = name.strip_prefix(Kind::Smdfm.name()).and_then(|n| n.strip_prefix('-'));
    number.is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
}

/// Which SMDFM (from 1) of `of` a sensor is of, by its place in the scene: radars, which cost most, are dealt first, and the first
/// SMDFM, which has the tracker too, comes last.
#[must_use]
pub fn smdfm_of(scene: &Scene, sensor: usize, of: u32) -> u32 {
    let order = |at: usize| (!scene.sensors[at].kind.radar, at);
    let before = (0..scene.sensors.len()).filter(|at| order(*at) < order(sensor)).count();
    of.max(1) - before as u32 % of.max(1)
}

/// Whether controllers clear at seats, which people may take, so that control tells the traffic what it tells control.
#[must_use]
pub fn closes_loop(scene: &Scene) -> bool {
    scene.control.controllers && scene.traffic.behaving.is_some()
}

/// Whether there is a member `control`: for alerts on tracks, for controllers at seats, or for both.
#[must_use]
pub fn has_control(scene: &Scene) -> bool {
    on_tracks(scene) || closes_loop(scene)
}

/// Whether control is told the tracks.
#[must_use]
pub fn on_tracks(scene: &Scene) -> bool {
    scene.control.sees == Sees::Tracks
}

/// Frames from a scan to the first in which something takes effect that controllers say then: one scan.
#[must_use]
pub fn loop_frames(scene: &Scene) -> Frame {
    u64::from(scene.run.frames_per_scan)
}

/// The conductor's configuration for a scene.
#[must_use]
pub fn conductor_config(scene: &Scene, options: &RunOptions) -> ConductorConfig {
    let mut producers: Vec<String> =
        (1..=options.generators).map(|share| generator_name(share, options.generators)).collect();
    producers.push(Kind::ExternalWorld.name().to_owned());
    producers.sort();
    let mut expected = producers.clone();
    expected.extend((1..=options.smdfms).map(smdfm_name));
    expected.sort();
    let front_ends: BTreeMap<String, String> =
        (2..=options.smdfms).map(|share| (smdfm_name(share), smdfm_name(1))).collect();
    producers.extend(front_ends.keys().cloned());
    producers.sort();
    if has_control(scene) {
        expected.insert(0, Kind::Control.name().to_owned());
    }
    if on_tracks(scene) {
        // Control waits for the tracks of each scan, which travel in the frame ends of the SMDFM.
        producers.push(Kind::Smdfm.name().to_owned());
        producers.sort();
    }
    let closes = closes_loop(scene);
    if closes {
        // What its controllers clear, the traffic does a scan later at the earliest.
        producers.push(Kind::Control.name().to_owned());
        producers.sort();
    }
    let last_frame = match options.duration_s {
        Some(seconds) => (seconds * 1e9 / scene.run.frame.0 as f64).round().max(1.0) as u64,
        None => scene.run.frames(),
    };
    ConductorConfig {
        scene: scene.name.clone(),
        scene_hash: scene.hash,
        version: crate::runtime::build::IDENTITY.to_owned(),
        expected,
        producers,
        optional: vec![Kind::Visitors.name().to_owned()],
        generators: options.generators,
        seed: options.seed.unwrap_or(scene.run.seed),
        step_ns: scene.run.frame.0,
        start_utc_ns: scene.run.start_utc_ns,
        last_frame,
        rate: options.rate,
        autostart: options.autostart,
        batch: options.batch,
        await_spectators: match options.visitors {
            true => vec![Kind::Visitors.name().to_owned()],
            false => Vec::new(),
        },
        // The door of visitors is a process that a loaded host may be slow to start.
        await_spectators_ns: if options.visitors { 15_000_000_000 } else { 2_000_000_000 },
        window: WINDOW_SCANS * u64::from(scene.run.frames_per_scan),
        closes: closes.then(|| (Kind::Control.name().to_owned(), loop_frames(scene))),
        front_ends,
        through_router: false,
        fed: crate::runtime::process::random_id(),
        losses: options.losses.over(&scene.network.losses),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Radars first, away from the one that fuses; a GPS before a radar in the scene waits.
    #[test]
    fn sensors_are_dealt_radars_first_and_the_first_smdfm_last() {
        let mut scene = scenarios::load_without_truth(&scenarios::locate("zurich")).expect("it");
        let dealt = |scene: &Scene, of| -> Vec<u32> {
            (0..scene.sensors.len()).map(|at| smdfm_of(scene, at, of)).collect()
        };
        let kinds: Vec<bool> = scene.sensors.iter().map(|s| s.kind.radar).collect();
        assert_eq!(kinds, [true, false, false]);
        assert_eq!(dealt(&scene, 1), [1, 1, 1]);
        assert_eq!(dealt(&scene, 2), [2, 1, 2]);
        assert_eq!(dealt(&scene, 8), [8, 7, 6]);
        scene.sensors.swap(0, 1);
        assert_eq!(dealt(&scene, 3), [2, 3, 1]);
    }

    #[test]
    fn front_ends_are_told_by_their_names() {
        for share in 2..=MOST_SMDFMS {
            assert!(is_front_end(&smdfm_name(share)));
        }
        let others = ["smdfm", "smdfm-", "smdfm-2b", "traffic-generator-2", "control"];
        assert!(!others.iter().any(|name| is_front_end(name)));
    }
}
