//! Alerts of the safety net in category 004, marks of alert in the tracks of 011, and stop bars as hold bars of 011.
//!
//! Each is said when it changes and again in every cycle while it lasts; the end of an alert is an end of conflict (message 17).

use super::items::{ascii, ident};
use super::{CONTROL_SIC, Gateway, SMDFM_SIC};
use crate::runtime::messages::{AlertMessage, ScanReport};
use asterix::{EncodeError, Packer, cat004, cat011};
use models::control::alert::{Change, Stage};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Message type of category 004: end of conflict.
const END_OF_CONFLICT: u8 = 17;
/// Indicators of a bank of hold bars.
const BANK: usize = 12;
/// Banks that four bits can name.
const BANKS: usize = 16;

/// What is known of alerts and stop bars.
#[derive(Clone, Debug, Default)]
pub(crate) struct Alerts {
    run: u32,
    /// Number of the newest message that was taken.
    told: u64,
    /// Those that last, and those whose end is to be said, by their number.
    all: BTreeMap<u32, AlertMessage>,
    /// Whether each stop bar is lit.
    lit: Vec<bool>,
    /// Some bar changed since the last cycle.
    changed: bool,
}

/// Of what was told of alerts what is still so: whoever joins begins with no alert that has ended.
#[must_use]
pub fn still_standing(mut told: Vec<AlertMessage>) -> Vec<AlertMessage> {
    let over = |message: &&AlertMessage| message.change == Change::Ended;
    let over: BTreeSet<u32> = told.iter().filter(over).map(|message| message.id).collect();
    told.retain(|message| !over.contains(&message.id));
    told
}

/// What a track's record says of the alert that it is in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mark {
    /// 0 end of alert, 1 to be known, 2 to act upon.
    pub severity: u8,
    /// As message type of category 004.
    pub kind: u8,
    /// Low octet of its number.
    pub number: u8,
    /// Tracks in it, those of twelve bits.
    pub tracks: Vec<u16>,
}

impl Alerts {
    /// A run goes on, or is another one: alerts of those before are nobody's any more.
    pub(crate) fn come_to(&mut self, run: u32) {
        if run > self.run {
            let (lit, changed) = (std::mem::take(&mut self.lit), self.changed);
            *self = Self { run, lit, changed, ..Self::default() };
        }
    }

    /// Changes of alerts, each of which is told several times.
    pub(crate) fn take(&mut self, messages: Vec<AlertMessage>) {
        for message in messages {
            self.come_to(message.run);
            if message.run < self.run || message.number <= self.told {
                continue;
            }
            self.told = message.number;
            self.all.insert(message.id, message);
        }
    }

    /// Stop bars, as control tells them.
    pub(crate) fn take_lights(&mut self, text: &str) {
        let Ok(value) = serde_json::from_str::<Value>(text) else { return };
        let Some(bars) = value["bars"].as_array() else { return };
        let lit: Vec<bool> = bars.iter().map(|bar| bar["lit"] == true).collect();
        self.changed |= lit != self.lit;
        self.lit = lit;
    }

    /// What had ended by this cycle has been said.
    pub(crate) fn end_cycle(&mut self) {
        self.all.retain(|_, alert| alert.change != Change::Ended);
        self.changed = false;
    }

    /// The gravest alert, the newest of equals, of each track of a scan.
    pub(crate) fn marks(&self, scan: &ScanReport) -> BTreeMap<u16, Mark> {
        let mut marks: BTreeMap<u16, Mark> = BTreeMap::new();
        for alert in self.all.values() {
            let tracks: Vec<u16> =
                subjects(alert, scan).into_iter().filter_map(|s| s.track).collect();
            let mark = Mark {
                severity: match (alert.change, alert.stage) {
                    (Change::Ended, _) => 0,
                    (_, Stage::Information) => 1,
                    (_, Stage::Alarm) => 2,
                },
                kind: alert.asterix,
                number: alert.id as u8,
                tracks: tracks.iter().copied().filter(|number| *number < 4096).collect(),
            };
            for track in tracks {
                if marks.get(&track).is_none_or(|known| known.severity <= mark.severity) {
                    marks.insert(track, mark.clone());
                }
            }
        }
        marks
    }

    /// Those of category 004.
    pub(crate) fn of_004(&self) -> impl Iterator<Item = &AlertMessage> {
        self.all.values()
    }

    /// Banks of hold bars, where there is something to be said of them: number and twelve indicators (0 lit, 1 off or none).
    pub(crate) fn banks(&self) -> Vec<u16> {
        if !self.changed && !self.lit.contains(&true) {
            return Vec::new();
        }
        let bank = |(number, bars): (usize, &[bool])| {
            let off = (0..BANK).filter(|i| bars.get(*i) != Some(&true));
            let indicators = off.fold(0, |bits, i| bits | 1 << (BANK - 1 - i));
            [number as u16, indicators]
        };
        self.lit.chunks(BANK).take(BANKS).enumerate().flat_map(bank).collect()
    }
}

/// Who is in an alert.
struct Subject {
    callsign: String,
    /// None: not tracked, or a strip only.
    track: Option<u16>,
}

/// Call signs or track numbers, as the alert names them.
fn subjects(alert: &AlertMessage, scan: &ScanReport) -> Vec<Subject> {
    let mut words = alert.subjects.split_whitespace();
    let mut subjects = Vec::new();
    while let Some(word) = words.next() {
        // A strip without a call sign: nobody whom a track could be of.
        if word == "strip" {
            words.next();
            continue;
        }
        let named = scan.tracks.iter().find(|t| t.callsign == word);
        let numbered = || scan.tracks.iter().find(|t| word.parse() == Ok(t.number));
        subjects.push(match named.or_else(numbered) {
            Some(track) => Subject { callsign: track.callsign.clone(), track: Some(track.number) },
            None => Subject { callsign: word.to_owned(), track: None },
        });
    }
    subjects
}

/// Adds an alert in category 004.
///
/// # Errors
/// If a value does not fit its field; nothing is added then.
pub(crate) fn record_004(
    packer: &mut Packer,
    gateway: &Gateway,
    alert: &AlertMessage,
    scan: &ScanReport,
) -> Result<(), EncodeError> {
    let ended = alert.change == Change::Ended;
    let subjects = subjects(alert, scan);
    let (first, second) = (subjects.first(), subjects.get(1));
    let mut function = [0; const { cat004::I060.field("OL") + 1 }];
    function[const { cat004::I060.field("RIMCA") }] = 1;
    packer.record(&cat004::CATEGORY, |items| {
        items.put(&cat004::I010, &gateway.identity(CONTROL_SIC))?;
        items.put(&cat004::I000, &[if ended { END_OF_CONFLICT } else { alert.asterix }])?;
        items.put(&cat004::I015, &gateway.identity(SMDFM_SIC))?;
        items.put(&cat004::I020, &[gateway.of_day_s(scan.time_ns)])?;
        items.put(&cat004::I040, &[alert.id as u16])?;
        if !ended {
            items.put(&cat004::I060, &function)?;
        }
        if let Some(number) = first.and_then(|s| s.track) {
            items.put(&cat004::I030, &[number])?;
        }
        items.compound(&cat004::I170, |sub| {
            let Some(first) = first.filter(|s| !s.callsign.is_empty()) else { return Ok(()) };
            sub.put(&cat004::I170_AI1, &[ascii(&first.callsign, 7).as_str()])?;
            if !ended {
                let [east_m, north_m]: [f64; 2] = alert.place_m.into();
                sub.put(&cat004::I170_CPC, &[east_m, north_m, 0.0])?;
            }
            sub.put(&cat004::I170_MS1, &[ident(&first.callsign).as_str()])
        })?;
        if let Some(number) = second.and_then(|s| s.track) {
            items.put(&cat004::I035, &[number])?;
        }
        items.compound(&cat004::I171, |sub| {
            let Some(second) = second.filter(|s| !s.callsign.is_empty()) else { return Ok(()) };
            sub.put(&cat004::I171_AI2, &[ascii(&second.callsign, 7).as_str()])?;
            sub.put(&cat004::I171_MS2, &[ident(&second.callsign).as_str()])
        })
    })
}

/// Adds the hold bars in category 011.
///
/// # Errors
/// If a value does not fit its field; nothing is added then.
pub(crate) fn record_bars(
    packer: &mut Packer,
    gateway: &Gateway,
    banks: &[u16],
    time_ns: i64,
) -> Result<(), EncodeError> {
    packer.record(&cat011::CATEGORY, |items| {
        items.put(&cat011::I010, &gateway.identity(CONTROL_SIC))?;
        items.put(&cat011::I000, &[7])?;
        items.put(&cat011::I015, &[1])?;
        items.put(&cat011::I140, &[gateway.of_day_s(time_ns)])?;
        items.put(&cat011::I610, banks)
    })
}
