//! What the models at their seats do when the safety net alerts: who is on final goes around, who rolls stops where he still can, who is on
//! a runway without a clearance holds until that is over.
//!
//! Said once an alert, over the frequency like everything else, before all that is wanted. A person at the seat says it himself.

use super::Wanted;
use crate::control::alert::{Alert, AlertKind, Subject};
use crate::control::clearance::{Board, ClearanceKind};
use crate::control::safety_net::SafetyNet;
use crate::control::situation::Situation;
use crate::plot::Callsign;
use std::collections::{BTreeMap, BTreeSet};

/// Nearer to his threshold nobody is sent around any more, m (assumed: he looks himself).
const LEAST_M: f64 = 1000.0;
/// Who was told to hold is told to go on after so long at the latest, s (assumed).
const HOLDS_S: f64 = 60.0;

/// The memory of what was said because of alerts.
#[derive(Clone, Debug, Default)]
pub struct Reacts {
    /// Alert and flight.
    told: BTreeSet<(u32, u32)>,
    /// Flights that hold by the model's word: since, s.
    held: BTreeMap<u32, f64>,
}

impl Reacts {
    /// What is to be said now because of alerts, by flight; each flight once. `flight` and `group`: of a call sign, and of a runway of
    /// the layout.
    pub fn look(
        &mut self,
        now_s: f64,
        net: &SafetyNet,
        board: &Board,
        flight: &dyn Fn(Callsign) -> Option<u32>,
        group: &dyn Fn(usize) -> u8,
    ) -> Vec<Wanted> {
        let mut says: BTreeMap<u32, Wanted> = BTreeMap::new();
        let mut about: BTreeSet<u32> = BTreeSet::new();
        for alert in net.standing() {
            let subjects = [Some(alert.condition.subjects.0), alert.condition.subjects.1];
            for subject in subjects.into_iter().flatten() {
                let situation = match subject {
                    Subject::Track(number) => net.surveillance().of_track(number),
                    Subject::Strip(index) => net.surveillance().of_strip(index),
                };
                let Some(s) = situation else { continue };
                let Some(m) = s.target.callsign.and_then(flight) else { continue };
                let strip = s.strip.and_then(|i| board.strips().get(i as usize));
                let sent_around = strip.is_some_and(|s| s.kinds.has(ClearanceKind::GoAround));
                let Some(kind) = does(alert, s).filter(|_| !sent_around) else { continue };
                about.insert(m);
                if self.told.contains(&(alert.id, m)) {
                    continue;
                }
                let runway = alert.condition.runway.or(s.on_final.map(|f| f.runway)).or(s.fast);
                let wanted = Wanted { flight: m, kind, group: group(runway.unwrap_or(0)) };
                says.entry(m).or_insert(wanted);
            }
        }
        for (m, since_s) in &self.held {
            if !about.contains(m) || now_s - since_s > HOLDS_S {
                let wanted = Wanted { flight: *m, kind: ClearanceKind::Taxi, group: 0 };
                says.entry(*m).or_insert(wanted);
            }
        }
        says.into_values().collect()
    }

    /// Something was said to a flight: what it was told because of standing alerts it is not told again.
    pub fn given(&mut self, now_s: f64, flight: u32, kind: ClearanceKind, net: &SafetyNet) {
        match kind {
            ClearanceKind::Hold => drop(self.held.insert(flight, now_s)),
            ClearanceKind::Taxi => drop(self.held.remove(&flight)),
            ClearanceKind::GoAround | ClearanceKind::Revoke => {}
            _ => return,
        }
        if kind != ClearanceKind::Taxi {
            self.told.extend(net.standing().map(|alert| (alert.id, flight)));
        }
    }
}

/// What a subject of an alert is told.
fn does(alert: &Alert, s: &Situation) -> Option<ClearanceKind> {
    use AlertKind::{
        NoRunwayClearance, NoTakeOffClearance, RunwayArrival, RunwayClosed, RunwayCrossing,
        RunwayOpposite, RunwayRoll, StopBar,
    };
    let far = s.on_final.is_some_and(|f| f.distance_m >= LEAST_M);
    let rolls = s.fast.is_some() && !s.target.arriving && s.last_final.is_none();
    match alert.condition.kind {
        RunwayArrival | RunwayOpposite | RunwayClosed | RunwayCrossing if far => {
            Some(ClearanceKind::GoAround)
        }
        RunwayRoll | RunwayOpposite | RunwayClosed | RunwayCrossing | NoTakeOffClearance
            if rolls =>
        {
            Some(ClearanceKind::Revoke)
        }
        NoRunwayClearance | StopBar if s.fast.is_none() && s.on_final.is_none() && !s.airborne => {
            Some(ClearanceKind::Hold)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::layout::{Layout, RunwayAxis};
    use crate::control::parameters::Parameters;
    use crate::control::safety_net::Scan;
    use crate::control::situation::{Target, TargetClass};
    use crate::frames::{Point2, Vector2};
    use crate::time::SimTime;

    fn net() -> SafetyNet {
        let ends = [Point2::new(0.0, 0.0), Point2::new(3000.0, 0.0)];
        let names = ["09".into(), "27".into()];
        let axis = RunwayAxis::new(names, ends, 45.0, 90.0).expect("an axis");
        let layout = Layout { runways: vec![axis], ..Layout::default() };
        SafetyNet::new(layout, Parameters::default())
    }

    fn target(number: u16, name: &str, at: [f64; 2], v: f64, now: SimTime) -> Target {
        Target {
            number,
            callsign: Some(Callsign::new(name)),
            class: TargetClass::Aircraft,
            arriving: v > 0.0,
            length_m: 38.0,
            position_m: Point2::new(at[0], at[1]),
            velocity_mps: Vector2::new(v, 0.0),
            altitude_m: Some(if at[0] < 0.0 { -0.05 * at[0] } else { 0.0 }),
            last_plot: now,
            first: false,
        }
    }

    /// What is told at each second, of a scene of tracks; each is said as soon as it is wanted.
    fn told(tracks: &dyn Fn(f64, SimTime) -> Vec<Target>) -> Vec<(u32, u32, ClearanceKind)> {
        let (mut net, board, mut reacts) = (net(), Board::default(), Reacts::default());
        let flight = |c: Callsign| ["ARR1", "DEP1"].iter().position(|n| Callsign::new(n) == c);
        let flight = |c: Callsign| flight(c).map(|at| at as u32);
        let mut all = Vec::new();
        for second in 0..200 {
            let now = SimTime::from_s(f64::from(second));
            let targets = tracks(f64::from(second), now);
            let bars = [];
            net.scan(&Scan {
                now,
                targets: &targets,
                board: &board,
                bars: &bars,
                areas: &[],
                low_visibility: false,
            });
            for w in reacts.look(f64::from(second), &net, &board, &flight, &|_| 3) {
                assert_eq!(w.group, if w.kind == ClearanceKind::Taxi { 0 } else { 3 });
                reacts.given(f64::from(second), w.flight, w.kind, &net);
                all.push((second, w.flight, w.kind));
            }
        }
        all
    }

    #[test]
    fn an_arrival_to_an_occupied_runway_is_sent_around_once_while_it_is_far_enough() {
        let come = |from_m: f64| {
            move |s: f64, now| {
                let mut all = vec![target(1, "ARR1", [from_m + 70.0 * s, 0.0], 70.0, now)];
                all.extend((s > 5.0).then_some(target(2, "CAR", [1500.0, 0.0], 0.0, now)));
                all
            }
        };
        let all = told(&come(-5000.0));
        let around: Vec<_> = all.iter().filter(|t| t.2 == ClearanceKind::GoAround).collect();
        // Thirty seconds before the threshold.
        assert!(matches!(around[..], [(41..=43, 0, _)]), "{all:?}");
        // Too late for words.
        let late = told(&come(-1000.0));
        assert!(late.iter().all(|t| t.2 != ClearanceKind::GoAround), "{late:?}");
    }

    #[test]
    fn who_is_on_a_runway_uncleared_holds_and_goes_on_when_it_is_over_or_a_minute_later() {
        use ClearanceKind::{Hold, Taxi};
        let enters = |leaves_s: f64| {
            move |s: f64, now| {
                let inside = (10.0..leaves_s).contains(&s);
                vec![target(2, "DEP1", [900.0, if inside { 40.0 } else { 200.0 }], 0.0, now)]
            }
        };
        let short = told(&enters(30.0));
        assert!(matches!(short[..], [(10, 1, Hold), (32..=34, 1, Taxi)]), "{short:?}");
        let long = told(&enters(500.0));
        assert!(matches!(long[..], [(10, 1, Hold), (70..=72, 1, Taxi)]), "{long:?}");
        assert!(told(&|_, now| vec![target(2, "DEP1", [900.0, 200.0], 0.0, now)]).is_empty());
    }

    #[test]
    fn who_rolls_towards_somebody_stops_and_whom_nobody_knows_is_told_nothing() {
        let rolls = |name: &'static str| {
            move |s: f64, now| {
                let v = (2.0 * s).min(60.0);
                let mut own = target(2, name, [100.0 + s * s, 0.0], v, now);
                own.arriving = false;
                vec![own, target(3, "CAR", [2500.0, 5.0], 0.0, now)]
            }
        };
        let all = told(&rolls("DEP1"));
        assert!(all.iter().any(|t| t.1 == 1 && t.2 == ClearanceKind::Revoke), "{all:?}");
        assert!(told(&rolls("XYZ1")).is_empty());
    }
}
