//! What is said of a track beside the report of the SMDFM, as octets of its picture: what it does, the stage of its alert, what it
//! was cleared for last.
//!
//! A report may come before or after what is said of its own scan: a picture has what was said as of earlier times only, so that it does
//! not depend on which came first. The log keeps these octets with the scan (`track_notes`), and a picture made out of it is the same.

use super::frame::{CLEARED, DOING, Note, Noted};
use super::picture::{AirportMap, RunwayShape};
use super::said;
use crate::runtime::messages::{AlertMessage, ScanReport, TrackMessage};
use models::control::alert::{Change, Stage};
use models::flight_list::MovementKind;
use models::track::TrackType;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Number of what is done, by its word; 0 for a word that is not known.
fn doing(word: &str) -> u8 {
    DOING.iter().position(|known| *known == word).map_or(0, |at| at as u8)
}

/// Number of a clearance, by its word; 0 for a word that is not known.
fn cleared(word: &str) -> u8 {
    CLEARED.iter().position(|known| *known == word).map_or(0, |at| at as u8 + 1)
}

/// Below it a target stands, m/s; the page's own.
const STILL_MPS: f64 = 0.5;
/// On a runway faster than this it rolls or lands, m/s (assumed: above any taxi speed).
const ROLLS_MPS: f64 = 25.0;
/// Higher than this it is airborne, m.
const AIRBORNE_M: f64 = 15.0;
/// Nearer to a stand than this a target that stands is parked, m.
const STAND_M: f64 = 45.0;
/// What is done by map and speed is another thing only when it has been for so long, ns.
const SETTLES_NS: i64 = 5_000_000_000;
/// Movers that are not said again are forgotten, ns.
const HOLDS_NS: i64 = 10_000_000_000;
/// What waits for its scan, at most.
const MOST_WAITING: usize = 4_096;

#[derive(Deserialize)]
struct Traffic {
    time_s: f64,
    movers: Vec<Mover>,
}

#[derive(Deserialize)]
struct Mover {
    callsign: String,
    phase: String,
    #[serde(default)]
    cleared: Vec<Cleared>,
    waits: Option<serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
struct Cleared {
    kind: String,
}

/// Of a mover: number of its phase, whether it waits, number of its clearance.
#[derive(Clone, Copy, Debug, Default)]
struct Says {
    phase: u8,
    waits: bool,
    cleared: u8,
}

/// What a track did by map and speed: what is shown, what it seems to do since when.
#[derive(Clone, Copy, Debug)]
struct Seems {
    shown: u8,
    now: u8,
    since_ns: i64,
}

/// What was said so far, for the scans to come.
#[derive(Debug, Default)]
pub struct Notes {
    runways: Vec<RunwayShape>,
    stands_m: Vec<[f64; 2]>,
    told: Vec<(i64, BTreeMap<String, Says>)>,
    alerts: Vec<AlertMessage>,
    movers: BTreeMap<String, Says>,
    said_ns: i64,
    open: BTreeMap<u32, (Stage, String)>,
    seems: BTreeMap<u16, Seems>,
}

impl Notes {
    /// Of an airport.
    #[must_use]
    pub fn of(map: &AirportMap) -> Self {
        Self {
            runways: map.runways.clone(),
            stands_m: map.stands.iter().map(|s| s.position_m).collect(),
            ..Self::default()
        }
    }

    /// Takes in what is said of traffic that behaves (`obs/traffic`); what is no such text is left out.
    pub fn traffic(&mut self, text: &str) {
        let (Some(time_ns), Ok(told)) = (said::time_of(text), serde_json::from_str(text)) else {
            return;
        };
        let Traffic { time_s, movers } = told;
        if !time_s.is_finite() || self.told.len() >= MOST_WAITING {
            return;
        }
        let says = |m: Mover| {
            let phase = match m.phase.as_str() {
                "starting" => doing("ready"),
                "going around" => doing("airborne"),
                "docked" => doing("docking"),
                word => doing(word),
            };
            let cleared = m.cleared.last().map_or(0, |c| cleared(&c.kind));
            (m.callsign, Says { phase, waits: m.waits.is_some(), cleared })
        };
        self.told.push((time_ns, movers.into_iter().map(says).collect()));
    }

    /// Takes in what changed of alerts.
    pub fn alerts(&mut self, changed: &[AlertMessage]) {
        let room = MOST_WAITING.saturating_sub(self.alerts.len());
        self.alerts.extend(changed.iter().take(room).cloned());
    }

    /// The notes of a scan, by what was said as of earlier times.
    pub fn scan(&mut self, scan: &ScanReport) -> Noted {
        let now_ns = scan.time_ns;
        self.come_to(now_ns);
        let mut stage_of: BTreeMap<&str, u8> = BTreeMap::new();
        for (stage, subjects) in self.open.values() {
            let stage = if *stage == Stage::Alarm { 2 } else { 1 };
            for subject in subjects.split_ascii_whitespace() {
                let most = stage_of.entry(subject).or_default();
                *most = stage.max(*most);
            }
        }
        let holds = now_ns.saturating_sub(self.said_ns) <= HOLDS_NS;
        let mut noted = Noted::new();
        let mut seems = BTreeMap::new();
        for track in &scan.tracks {
            let now = self.doing_of(track);
            let before = self.seems.get(&track.number).copied();
            let mut own = before.unwrap_or(Seems { shown: now, now, since_ns: now_ns });
            if own.now != now {
                (own.now, own.since_ns) = (now, now_ns);
            }
            if own.shown != own.now && now_ns - own.since_ns >= SETTLES_NS {
                own.shown = own.now;
            }
            seems.insert(track.number, own);
            let says = self.movers.get(&track.callsign).filter(|_| holds);
            let says = says.filter(|_| !track.callsign.is_empty());
            let number = track.number.to_string();
            let name = if track.callsign.is_empty() { &number } else { &track.callsign };
            let phase = says.map_or(0, |s| phase_of(s, is_vehicle(track), now));
            noted.insert(
                track.number,
                Note {
                    doing: if phase == 0 { own.shown } else { phase },
                    derived: phase == 0,
                    alert: stage_of.get(name.as_str()).copied().unwrap_or(0),
                    cleared: says.map_or(0, |s| s.cleared),
                },
            );
        }
        self.seems = seems;
        noted
    }

    /// What was said as of times before this one counts from now on.
    fn come_to(&mut self, now_ns: i64) {
        for (time_ns, movers) in self.told.extract_if(.., |told| told.0 < now_ns) {
            if time_ns >= self.said_ns {
                (self.said_ns, self.movers) = (time_ns, movers);
            }
        }
        for a in self.alerts.extract_if(.., |a| a.time_ns < now_ns) {
            if a.change == Change::Ended {
                self.open.remove(&a.id);
            } else {
                self.open.insert(a.id, (a.stage, a.subjects));
            }
        }
    }

    /// What a track does by map and speed.
    fn doing_of(&self, track: &TrackMessage) -> u8 {
        let at_m: [f64; 2] = track.position_m.into();
        let mps = libm::hypot(track.velocity_mps[0], track.velocity_mps[1]);
        let still = !(mps >= STILL_MPS);
        if track.altitude_m.is_some_and(|m| m > AIRBORNE_M) {
            return doing("airborne");
        }
        if is_vehicle(track) {
            return doing(if still { "standing" } else { "driving" });
        }
        if self.runways.iter().any(|r| is_on(r, at_m)) {
            let arrives = track.movement == Some(MovementKind::Arrival);
            return doing(match (still, mps > ROLLS_MPS, arrives) {
                (true, _, _) => "lined up",
                (_, true, true) => "landing",
                (_, true, false) => "rolling",
                _ => "crossing",
            });
        }
        if !still {
            return doing("taxiing");
        }
        let near = |s: &[f64; 2]| libm::hypot(s[0] - at_m[0], s[1] - at_m[1]) <= STAND_M;
        doing(if self.stands_m.iter().any(near) { "parked" } else { "holding" })
    }
}

/// What a mover does that says what it does; `seems`: by map and speed.
fn phase_of(says: &Says, vehicle: bool, seems: u8) -> u8 {
    let taxis = says.phase == doing("taxiing");
    match (taxis, vehicle) {
        (true, true) => seems,
        (true, false) if seems == doing("crossing") => seems,
        (true, false) if says.waits => doing("holding"),
        _ => says.phase,
    }
}

fn is_vehicle(track: &TrackMessage) -> bool {
    track.track_type == TrackType::Vehicle || track.movement == Some(MovementKind::Vehicle)
}

/// Whether a place is on a runway.
fn is_on(runway: &RunwayShape, at_m: [f64; 2]) -> bool {
    let [a, b] = runway.ends;
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length = libm::hypot(dx, dy).max(1e-9);
    let (x, y) = (at_m[0] - a[0], at_m[1] - a[1]);
    let (along, across) = ((x * dx + y * dy) / length, (x * dy - y * dx) / length);
    (0.0..=length).contains(&along) && across.abs() <= 0.5 * runway.width_m
}

#[cfg(test)]
mod tests;
