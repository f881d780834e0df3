//! Failures of equipment: stop bars that stay dark or stay lit, transponders that fall silent.

use super::failures::{Failure, FailureKind};
use super::{Core, Direction, Flight, Phase};
use crate::control::lights::FailedBars;
use crate::draw::{DrawKey, Purpose, uniform};

/// Who goes onto a runway by a dark bar is cleared where he stands after so long, s (assumed).
pub(super) const SEEN_S: f64 = 60.0;

/// Of the wrong turns of others, those who are led by greens make this share (assumed).
const WRONG_TURNS_LED: f64 = 0.1;

/// Failures that are drawn, a movement (assumed): what, how often, whether by departures, arrivals or both, and for how
/// long, s.
const DRAWN: [(FailureKind, f64, Option<Direction>, f64); 7] = [
    (FailureKind::WrongTurn, 1e-3, Some(Direction::Arrival), 60.0),
    (FailureKind::PassHold, 1e-4, Some(Direction::Departure), 60.0),
    (FailureKind::WrongRunway, 1e-5, Some(Direction::Departure), 60.0),
    (FailureKind::TakeOffUncleared, 1e-5, Some(Direction::Departure), 60.0),
    (FailureKind::NoReply, 2e-3, Some(Direction::Departure), 60.0),
    (FailureKind::Transponder, 1e-3, None, 600.0),
    (FailureKind::StopBar, 1e-4, Some(Direction::Departure), 1800.0),
];

/// Failures drawn for each flight by its key: `factor` times as often as assumed. Stop bars fail only where they are in use;
/// equipment fails from the flight's time on; whom `greens` lead turns wrong more seldom.
#[must_use]
pub fn drawn_failures(
    flights: &[Flight],
    seed: u64,
    factor: f64,
    (stop_bars, greens): (bool, bool),
) -> Vec<Failure> {
    let mut failures = Vec::new();
    for (flight, f) in flights.iter().enumerate() {
        let key = DrawKey { run_seed: seed, sensor: 0, entity: f.key, scan: 900 };
        let mut rng = key.rng(Purpose::Mover);
        for (kind, rate, of, stay_s) in DRAWN {
            // Drawn for all, so that one more kind changes no other.
            let led = greens && kind == FailureKind::WrongTurn;
            let rate = if led { WRONG_TURNS_LED * rate } else { rate };
            let happens = uniform(&mut rng) < rate * factor;
            let there = kind != FailureKind::StopBar || stop_bars;
            if !happens || !there || of.is_some_and(|direction| direction != f.direction) {
                continue;
            }
            let equipment = matches!(kind, FailureKind::Transponder | FailureKind::StopBar);
            failures.push(Failure {
                id: format!("{}-{}", kind.word(), f.callsign),
                kind,
                flight,
                at_s: if equipment { f.time_s.max(0.0) } else { 0.0 },
                stay_s,
                lead_s: 45.0,
                clearance: "CRO",
                lamps_lit: false,
                vehicle: String::new(),
            });
        }
    }
    failures
}

impl Failure {
    /// The stop bars that fail by it: all of the runway of its flight; `runway`: a name of that.
    #[must_use]
    pub fn bars(&self, runway: &str) -> Option<FailedBars> {
        (self.kind == FailureKind::StopBar).then(|| FailedBars {
            runway: runway.to_owned(),
            from_s: self.at_s,
            until_s: self.at_s + self.stay_s,
            lit: self.lamps_lit,
        })
    }
}

impl Core {
    /// Stop bars that fail now.
    pub fn failed_bars(&self) -> impl Iterator<Item = FailedBars> {
        let of =
            |f: &super::failures::Failing| f.failure.bars(&self.net.runways[f.runway].names[0]);
        self.failing.iter().filter_map(of).filter(|bars| bars.at(self.time_s))
    }

    /// Whether the transponder of a flight or vehicle answers.
    #[must_use]
    pub fn answers(&self, flight: usize) -> bool {
        !self.failing.iter().any(|f| {
            f.failure.flight == flight
                && f.failure.kind == FailureKind::Transponder
                && f.shown_s.is_some()
                && !f.over
        })
    }

    /// Whether a bar of a runway is lit before one who was cleared to pass it: nobody passes a lit bar.
    pub(super) fn bar_sticks(&mut self, runway: usize) -> bool {
        let now = self.time_s;
        let sticks = self.failing.iter().position(|f| {
            let Failure { kind, at_s, stay_s, lamps_lit, .. } = f.failure;
            kind == FailureKind::StopBar
                && lamps_lit
                && (at_s..=at_s + stay_s).contains(&now)
                && f.runway == runway
        });
        if let Some(f) = sticks {
            self.show(f);
        }
        sticks.is_some()
    }

    /// Shows and ends failures of equipment.
    pub(super) fn watch_equipment(&mut self, f: usize) {
        let now = self.time_s;
        let failing = &self.failing[f];
        let (kind, m) = (failing.failure.kind, failing.failure.flight);
        let until_s = failing.failure.at_s + failing.failure.stay_s;
        if kind == FailureKind::Transponder {
            let there = !matches!(self.movers[m].phase, Phase::Absent | Phase::Gone);
            if there && failing.shown_s.is_none() {
                self.begin_failure(f);
                self.show(f);
            }
            self.failing[f].over = now >= until_s;
            return;
        }
        let mover = &self.movers[m];
        let line = (mover.threshold as usize).checked_sub(1).and_then(|i| mover.way.ends_m.get(i));
        let over = line.is_some_and(|line| mover.s + 0.1 * self.flights[m].size.length_m > *line);
        match (failing.begun_s.is_some(), failing.shown_s) {
            (true, None) if over => self.show(f),
            (true, Some(at)) if now >= at + SEEN_S => {
                self.failing[f].over = true;
                self.clear(m, "LUP", self.end_name(m));
            }
            (false, _) => self.failing[f].over = now > until_s,
            _ => {}
        }
    }
}
