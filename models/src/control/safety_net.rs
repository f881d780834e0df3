//! The safety net: tracks, clearances and stop bars of a scan in, alerts raised, changed and ended out.
//!
//! A function of its inputs and its memory. A condition raises its alert after `confirm_scans` scans in a row,
//! in the scan of the last of them; a graver stage counts at once; the alert ends after `end_scans` scans without it.

use super::alert::{Alert, AlertKind, Change, Condition, Stage, Subject};
use super::clearance::Board;
use super::conformance::{Monitor, Rules};
use super::layout::{Area, Layout, StopBar};
use super::parameters::Parameters;
use super::situation::{Doubted, Surveillance, Target};
use super::{clearance_alerts, runway_alerts};
use crate::plot::Callsign;
use crate::time::SimTime;

/// Everything of one scan.
#[derive(Clone, Copy, Debug)]
pub struct Scan<'a> {
    /// Time of the tracks.
    pub now: SimTime,
    /// Tracks.
    pub targets: &'a [Target],
    /// Clearances, brought to this time.
    pub board: &'a Board,
    /// Stop bars.
    pub bars: &'a [StopBar],
    /// Protected areas.
    pub areas: &'a [Area],
    /// Low visibility procedures.
    pub low_visibility: bool,
}

#[derive(Clone, Debug)]
struct Open {
    alert: Alert,
    raised: bool,
    /// Scans in a row with the condition, and without it.
    with: u32,
    without: u32,
    /// Scans in a row in a lower stage.
    lower: u32,
}

/// The safety net of one airport.
#[derive(Clone, Debug)]
pub struct SafetyNet {
    layout: Layout,
    parameters: Parameters,
    surveillance: Surveillance,
    monitor: Monitor,
    /// Sorted by key.
    open: Vec<Open>,
    spare: Vec<Open>,
    conditions: Vec<Condition>,
    changes: Vec<(Change, Alert)>,
    last_id: u32,
}

impl SafetyNet {
    /// A safety net without memory.
    #[must_use]
    pub fn new(layout: Layout, parameters: Parameters) -> Self {
        Self {
            layout,
            parameters,
            surveillance: Surveillance::default(),
            monitor: Monitor::default(),
            open: Vec::new(),
            spare: Vec::new(),
            conditions: Vec::new(),
            changes: Vec::new(),
            last_id: 0,
        }
    }

    /// What it looks at.
    #[must_use]
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Its thresholds.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The situations of the last scan.
    #[must_use]
    pub fn surveillance(&self) -> &Surveillance {
        &self.surveillance
    }

    /// Alerts that stand, by kind and subjects.
    pub fn standing(&self) -> impl Iterator<Item = &Alert> {
        self.open.iter().filter(|o| o.raised).map(|o| &o.alert)
    }

    /// Judges a scan; what changed, by kind and subjects.
    pub fn scan(&mut self, scan: &Scan<'_>) -> &[(Change, Alert)] {
        let Self { layout, parameters, surveillance, monitor, conditions, .. } = self;
        surveillance.scan(scan.now, layout, parameters, scan.board, scan.targets);
        conditions.clear();
        runway_alerts::conditions(
            layout,
            parameters,
            (scan.now, scan.low_visibility),
            surveillance,
            conditions,
        );
        clearance_alerts::conditions(layout, parameters, scan.board, surveillance, conditions);
        let rules = Rules {
            now: scan.now,
            layout,
            parameters,
            board: scan.board,
            bars: scan.bars,
            areas: scan.areas,
        };
        monitor.conditions(&rules, surveillance, conditions);
        conditions.sort_by(|a, b| a.key().cmp(&b.key()).then(b.stage.cmp(&a.stage)));
        conditions.dedup_by_key(|c| c.key());
        self.merge(scan);
        &self.changes
    }

    /// Scans in a row that raise an alert of a kind.
    fn scans_for(&self, kind: AlertKind) -> u32 {
        let moves = match &self.parameters.doubt {
            Some(doubt) if of_movement(kind) || of_a_line(kind) => doubt.move_scans,
            _ => 1,
        };
        self.parameters.confirm_scans.max(moves)
    }

    /// Whether a condition is one of a track that raises nothing by itself.
    fn doubted(&self, condition: &Condition) -> bool {
        if self.parameters.doubt.is_none() {
            return false;
        }
        let (first, second) = condition.subjects;
        [Some(first), second].into_iter().flatten().any(|subject| {
            let of = match subject {
                Subject::Track(number) => self.surveillance.of_track(number),
                // Where the holder of a clearance is decides whether it excludes another.
                Subject::Strip(index) => self.surveillance.of_strip(index),
            };
            match of.and_then(|s| s.doubt) {
                Some(Doubted::Weak) => true,
                Some(Doubted::Jumps) => of_movement(condition.kind),
                Some(Doubted::Restless) => of_moving(condition.kind),
                None => false,
            }
        })
    }

    fn merge(&mut self, scan: &Scan<'_>) {
        self.changes.clear();
        let mut next = std::mem::take(&mut self.spare);
        next.clear();
        let mut open = std::mem::take(&mut self.open);
        let names = |c: &Condition| {
            let strip = |i: u32| scan.board.strips().get(i as usize).map(|s| s.callsign);
            let track = |n: u16| self.surveillance.of_track(n).and_then(|s| s.target.callsign);
            let of = |s: Subject| match s {
                Subject::Track(number) => track(number),
                Subject::Strip(index) => strip(index),
            };
            (of(c.subjects.0), c.subjects.1.and_then(of))
        };
        let mut conditions = self.conditions.iter().peekable();
        let mut told = open.drain(..).peekable();
        loop {
            let order = match (told.peek(), conditions.peek()) {
                (None, None) => break,
                (Some(_), None) => std::cmp::Ordering::Less,
                (None, Some(_)) => std::cmp::Ordering::Greater,
                (Some(o), Some(c)) => o.alert.condition.key().cmp(&c.key()),
            };
            let before = if order.is_le() { told.next() } else { None };
            let holds = if order.is_ge() { conditions.next() } else { None };
            let mut entry = match (before, holds) {
                (Some(mut entry), Some(condition)) => {
                    entry.hold(
                        condition,
                        names(condition),
                        &self.parameters,
                        scan.now,
                        &mut self.changes,
                    );
                    entry
                }
                (Some(mut entry), None) => {
                    if !entry.miss(&self.parameters, &mut self.changes) {
                        continue;
                    }
                    entry
                }
                (None, Some(condition)) => Open {
                    alert: Alert {
                        id: 0,
                        condition: *condition,
                        names: names(condition),
                        since: scan.now,
                        stage_since: scan.now,
                    },
                    raised: false,
                    with: 1,
                    without: 0,
                    lower: 0,
                },
                (None, None) => break,
            };
            let condition = &entry.alert.condition;
            let enough = entry.with >= self.scans_for(condition.kind);
            if !entry.raised && enough && !self.doubted(condition) {
                entry.raised = true;
                self.last_id += 1;
                entry.alert.id = self.last_id;
                (entry.alert.since, entry.alert.stage_since) = (scan.now, scan.now);
                self.changes.push((Change::Raised, entry.alert.clone()));
            }
            next.push(entry);
        }
        drop(told);
        (self.open, self.spare) = (next, open);
    }
}

impl Open {
    fn hold(
        &mut self,
        condition: &Condition,
        names: (Option<Callsign>, Option<Callsign>),
        parameters: &Parameters,
        now: SimTime,
        changes: &mut Vec<(Change, Alert)>,
    ) {
        (self.with, self.without) = (self.with + 1, 0);
        let before = self.alert.condition.stage;
        let mut stage = condition.stage;
        if stage < before && self.raised {
            self.lower += 1;
            if self.lower < parameters.end_scans {
                stage = Stage::max(stage, before);
            }
        } else {
            self.lower = 0;
        }
        let known = (names.0.or(self.alert.names.0), names.1.or(self.alert.names.1));
        let changed = stage != before || known != self.alert.names;
        self.alert.condition = Condition { stage, ..*condition };
        self.alert.names = known;
        if stage != before {
            self.lower = 0;
            self.alert.stage_since = now;
        }
        if changed && self.raised {
            changes.push((Change::Changed, self.alert.clone()));
        }
    }

    /// False if the entry is over.
    fn miss(&mut self, parameters: &Parameters, changes: &mut Vec<(Change, Alert)>) -> bool {
        if !self.raised {
            return false;
        }
        (self.with, self.without) = (0, self.without + 1);
        if self.without >= parameters.end_scans {
            changes.push((Change::Ended, self.alert.clone()));
            return false;
        }
        true
    }
}

/// Kinds about movements off the runways.
fn of_movement(kind: AlertKind) -> bool {
    use AlertKind::{HighSpeed, NoPushClearance, NoTaxiClearance, OffWay, StandOccupied};
    matches!(kind, NoPushClearance | NoTaxiClearance | HighSpeed | OffWay | StandOccupied)
}

/// Kinds about moving at all.
fn of_moving(kind: AlertKind) -> bool {
    matches!(kind, AlertKind::NoPushClearance | AlertKind::NoTaxiClearance)
}

/// Kinds that begin at a line or a time that noise alone passes for one scan.
fn of_a_line(kind: AlertKind) -> bool {
    matches!(kind, AlertKind::StopBar | AlertKind::NoLandingClearance | AlertKind::Area)
}

#[cfg(test)]
mod tests;
