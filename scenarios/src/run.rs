//! `[run]`: what, when, how long, by which steps.

use crate::document::{Section, within};
use crate::error::{Problem, ScenarioError};
use crate::keys::{self, words};
use models::time::SimTime;

/// `[run]` of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// One line for people.
    pub title: String,
    /// Seed of all draws.
    pub seed: u64,
    /// UTC of frame 0, nanoseconds since 1970-01-01.
    pub start_utc_ns: i64,
    /// Simulated duration.
    pub duration: SimTime,
    /// DIS exercise identifier.
    pub exercise: u8,
    /// DIS site of all entities of the scene.
    pub site: u16,
    /// Targets at a time: the scene's own and, in what these leave, visitors; none: as many visitors as a run takes.
    pub targets_max: Option<usize>,
    /// Duration of a frame (step of the movers).
    pub frame: SimTime,
    /// Frames in a scan.
    pub frames_per_scan: u32,
    /// When an Entity State PDU is sent before its heartbeat.
    pub dead_reckoning: DeadReckoning,
    /// Interval of Entity State PDUs of an entity that moves.
    pub heartbeat_moving: SimTime,
    /// The same of one that is parked.
    pub heartbeat_parked: SimTime,
}

/// How receivers are expected to extrapolate, and how far off they may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeadReckoning {
    /// DIS dead-reckoning algorithm of moving entities: 2 to 5, world axes (IEEE 1278.1-2012, annex E).
    pub algorithm: u8,
    /// Largest distance between truth and extrapolation, m.
    pub position_m: f64,
    /// Largest angle between truth and extrapolation, rad.
    pub orientation_rad: f64,
}

impl Run {
    /// Number of frames of the whole run.
    #[must_use]
    pub fn frames(&self) -> u64 {
        (self.duration.0 / self.frame.0).max(0) as u64
    }

    /// Duration of a scan.
    #[must_use]
    pub fn scan(&self) -> SimTime {
        SimTime(self.frame.0 * i64::from(self.frames_per_scan))
    }
}

/// Reads `[run]`; a start that is not stated is the schedule's, which `scheduled` knows.
pub(crate) fn read(
    root: &Section,
    scheduled: impl FnOnce(&Section) -> Result<Option<i64>, ScenarioError>,
) -> Result<Run, ScenarioError> {
    let section = root
        .section("run", &words(keys::RUN))?
        .ok_or_else(|| root.missing("run", "a table [run]".into()))?;
    let frame = SimTime::from_s(section.number_or("frame_s", 0.05, within(0.001, 1.0, "s"))?);
    let scan = SimTime::from_s(section.number_or("scan_s", 1.0, within(0.01, 60.0, "s"))?);
    if scan.0 % frame.0 != 0 {
        let needed = "a whole number of frames (run.frame_s)";
        return Err(section.refuse("scan_s", Problem::Order { found: scan.s(), needed }));
    }
    let duration = SimTime::from_s(section.need_number("duration_s", within(1.0, 86_400.0, "s"))?);
    let small = |low, high| within(low, high, "s");
    let heartbeat = section
        .section("heartbeat", &words(keys::HEARTBEAT))?
        .unwrap_or_else(|| section.empty("heartbeat"));
    Ok(Run {
        title: section.need_text("title", "one line for people")?.into(),
        seed: section.integer("seed", 0, i64::MAX)?.unwrap_or(1) as u64,
        start_utc_ns: match section.time_utc_ns("start")? {
            Some(start) => start,
            None => scheduled(root)?.ok_or_else(|| {
                section.missing("start", "a UTC time like 2019-11-24T09:00:00Z".into())
            })?,
        },
        duration,
        exercise: section.integer("exercise", 0, 255)?.unwrap_or(1) as u8,
        site: section.integer("site", 1, 65_534)?.unwrap_or(1) as u16,
        targets_max: section.integer("targets_max", 1, 1_000_000)?.map(|most| most as usize),
        frame,
        frames_per_scan: (scan.0 / frame.0) as u32,
        dead_reckoning: dead_reckoning(&section)?,
        heartbeat_moving: SimTime::from_s(heartbeat.number_or(
            "moving_s",
            5.0,
            small(0.1, 60.0),
        )?),
        heartbeat_parked: SimTime::from_s(heartbeat.number_or(
            "parked_s",
            60.0,
            small(0.1, 600.0),
        )?),
    })
}

fn dead_reckoning(section: &Section) -> Result<DeadReckoning, ScenarioError> {
    let table = section
        .section("dead_reckoning", &words(keys::DEAD_RECKONING))?
        .unwrap_or_else(|| section.empty("dead_reckoning"));
    let algorithms = [("fpw", 2), ("rpw", 3), ("rvw", 4), ("fvw", 5)];
    let orientation_deg = table.number_or("orientation_deg", 3.0, within(0.01, 180.0, "deg"))?;
    Ok(DeadReckoning {
        algorithm: table.choice("algorithm", &algorithms)?.unwrap_or(4),
        position_m: table.number_or("position_m", 1.0, within(0.001, 1000.0, "m"))?,
        orientation_rad: orientation_deg.to_radians(),
    })
}
