//! What all reporting targets share: who is equipped, when each reports, what the sensor remembers.
//!
//! Reports come at whole multiples of the period after a phase of the target's own, so they do not
//! depend on how long a scan interval is. What is remembered of a target is found by its key and
//! depends on nothing but that target: another one coming or going changes no report.

use std::collections::BTreeSet;

use crate::draw::{DrawKey, Purpose, uniform};
use crate::effects::positioning::{PositioningEffect, PositioningLevels};
use crate::frames::{Point2, Vector2};
use crate::keys::Key;
use crate::plot::{Callsign, Identity, Plot, SensorId, SensorKind};
use crate::sensors::config::{ConfigError, check, number};
use crate::sensors::{Cause, PlotSink, ScanInterval, TargetState, Truth};
use crate::time::SimTime;

/// Which targets carry the equipment.
#[derive(Clone, Debug, PartialEq)]
pub struct Equipage {
    /// Aircraft may be equipped.
    pub aircraft: bool,
    /// Vehicles may be equipped.
    pub vehicles: bool,
    /// Who of these is.
    pub who: Equipped,
}

/// Who of the admitted kinds is equipped.
#[derive(Clone, Debug, PartialEq)]
pub enum Equipped {
    /// Every one.
    All,
    /// A share of them, 0 to 1, decided by each target's key.
    Share(f64),
    /// Those with these names.
    Callsigns(BTreeSet<Callsign>),
}

impl Equipage {
    /// Aircraft and vehicles, every one.
    #[must_use]
    pub fn all() -> Self {
        Self { aircraft: true, vehicles: true, who: Equipped::All }
    }

    /// Refuses a share outside 0 to 1.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        match self.who {
            Equipped::Share(share) => number("equipped_share", share, 0.0, 1.0),
            Equipped::All | Equipped::Callsigns(_) => Ok(()),
        }
    }

    fn holds(&self, aircraft: bool, callsign: Callsign, draw: f64) -> bool {
        let kind = if aircraft { self.aircraft } else { self.vehicles };
        kind && match &self.who {
            Equipped::All => true,
            Equipped::Share(share) => draw < *share,
            Equipped::Callsigns(names) => names.contains(&callsign),
        }
    }
}

/// Keys that all reporting sensors have.
pub(crate) const KEYS: &[Key] = &[
    Key::number("report_s", "s", 0.01, 3600.0, "Time between two reports of a target"),
    Key::flag("aircraft", "Whether aircraft may be equipped"),
    Key::flag("vehicles", "Whether vehicles may be equipped"),
];

/// Who reports and how often.
#[derive(Clone, Debug, PartialEq)]
pub struct Reporting {
    /// Number of the sensor in the scene.
    pub id: SensorId,
    /// What kind of sensor.
    pub kind: SensorKind,
    /// Who is equipped.
    pub equipped: Equipage,
    /// Time between two reports of a target, s, 0.01 to 3 600.
    pub period_s: f64,
    /// Whether a report needs the target's transponder: one that is silent is not seen.
    pub transponder: bool,
}

impl Reporting {
    /// Refuses periods and shares outside their limits.
    ///
    /// # Errors
    /// [`ConfigError`] with key, value and limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        check(KEYS, "report_s", self.period_s)?;
        self.equipped.validate()
    }

    /// Names the draws of one report.
    pub(crate) fn key(&self, interval: &ScanInterval, due: &Due) -> DrawKey {
        DrawKey {
            run_seed: interval.run_seed,
            sensor: u32::from(self.id.0),
            entity: due.key,
            scan: due.number,
        }
    }
}

/// One report that is due.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Due {
    /// Index of the target in this scan's truth.
    pub(crate) index: usize,
    /// Key of the target.
    pub(crate) key: u64,
    /// Number of the report since the start of the run, for draw keys.
    pub(crate) number: u64,
    /// When.
    pub(crate) time: SimTime,
    /// Where the target is then.
    pub(crate) state: TargetState,
}

/// A target that the sensor knows.
#[derive(Clone, Debug)]
struct Member<S> {
    key: u64,
    equipped: bool,
    phase_ns: i64,
    /// Made at the first report.
    memory: Option<S>,
}

/// What a sensor remembers of its targets, sorted by key.
#[derive(Clone, Debug)]
pub(crate) struct Fleet<S> {
    members: Vec<Member<S>>,
}

impl<S> Default for Fleet<S> {
    fn default() -> Self {
        Self { members: Vec::new() }
    }
}

impl<S> Fleet<S> {
    /// Calls `report` for every report due in `interval`, in the order of keys, then of time; `start`
    /// makes the memory of a target when it first reports.
    pub(crate) fn for_each_due(
        &mut self,
        reporting: &Reporting,
        interval: &ScanInterval,
        truth: &dyn Truth,
        mut start: impl FnMut(&Due) -> S,
        mut report: impl FnMut(&mut S, &Due),
    ) {
        let period_ns = SimTime::from_s(reporting.period_s).0;
        let mut at = 0;
        for index in 0..truth.len() {
            let key = truth.key(index);
            self.find(reporting, interval, truth, index, &mut at);
            let member = &mut self.members[at];
            if !member.equipped {
                continue;
            }
            let mut number = (interval.from.0 - member.phase_ns).div_euclid(period_ns) + 1;
            loop {
                let time = SimTime(member.phase_ns + number * period_ns);
                if time > interval.to {
                    break;
                }
                let heard = !reporting.transponder || truth.answers(index, time);
                if let Some(state) = truth.at(index, time).filter(|_| heard) {
                    let due = Due { index, key, number: number as u64, time, state };
                    report(member.memory.get_or_insert_with(|| start(&due)), &due);
                }
                number += 1;
            }
        }
    }

    /// Calls `visit` for every equipped target that exists at the end or the beginning of `interval`.
    pub(crate) fn survey(
        &mut self,
        reporting: &Reporting,
        interval: &ScanInterval,
        truth: &dyn Truth,
        mut visit: impl FnMut(&TargetState),
    ) {
        let mut at = 0;
        for index in 0..truth.len() {
            self.find(reporting, interval, truth, index, &mut at);
            if self.members[at].equipped {
                let state = truth.at(index, interval.to).or_else(|| truth.at(index, interval.from));
                if let Some(state) = state {
                    visit(&state);
                }
            }
        }
    }

    /// Moves `at` on to the member of target `index`, who is welcomed if new.
    fn find(
        &mut self,
        reporting: &Reporting,
        interval: &ScanInterval,
        truth: &dyn Truth,
        index: usize,
        at: &mut usize,
    ) {
        let key = truth.key(index);
        while self.members.get(*at).is_some_and(|m| m.key < key) {
            *at += 1;
        }
        if self.members.get(*at).is_none_or(|m| m.key != key) {
            let period_ns = SimTime::from_s(reporting.period_s).0;
            let member = Self::welcome(reporting, interval.run_seed, truth, index, period_ns);
            self.members.insert(*at, member);
        }
    }

    fn welcome(
        reporting: &Reporting,
        run_seed: u64,
        truth: &dyn Truth,
        index: usize,
        period_ns: i64,
    ) -> Member<S> {
        let key = truth.key(index);
        let sensor = u32::from(reporting.id.0);
        let draw = DrawKey { run_seed, sensor, entity: key, scan: u64::MAX };
        let mut rng = draw.rng(Purpose::GnssWhite);
        let (phase, share) = (uniform(&mut rng), uniform(&mut rng));
        Member {
            key,
            equipped: reporting.equipped.holds(
                truth.class(index).aircraft,
                truth.callsign(index),
                share,
            ),
            phase_ns: (phase * period_ns as f64) as i64,
            memory: None,
        }
    }
}

/// A position report before it is numbered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fix {
    /// Time of validity.
    pub(crate) time: SimTime,
    /// Reported position, airport frame, m.
    pub(crate) position_m: Point2<f64>,
    /// First axis of the error ellipse.
    pub(crate) axis: Vector2<f64>,
    /// Variances along and across it, m².
    pub(crate) variance_m2: [f64; 2],
    /// Height, m, where reported.
    pub(crate) altitude_m: Option<f64>,
}

/// Step of a height in Mode S and ADS-B, m: 25 ft.
///
/// Source: ICAO Annex 10, Vol. IV, 3.1.2.6.5.4 (Q bit set).
const HEIGHT_STEP_M: f64 = 25.0 * 0.3048;

/// What an effect did: its name, value and unit; `None` where it was not simulated.
pub(crate) type Shown = Option<(&'static str, f64, &'static str)>;

/// What `effect` did, where `levels` simulate it.
pub(crate) fn shown(
    levels: &PositioningLevels,
    effect: PositioningEffect,
    value: f64,
    unit: &'static str,
) -> Shown {
    levels.on(effect).then_some((effect.name(), value, unit))
}

/// Appends plots and causes of one sensor and scan, numbering them.
pub(crate) struct Reports<'a> {
    sensor: SensorId,
    kind: SensorKind,
    sequence: u32,
    truth: &'a dyn Truth,
    out: &'a mut PlotSink,
}

impl<'a> Reports<'a> {
    pub(crate) fn new(reporting: &Reporting, truth: &'a dyn Truth, out: &'a mut PlotSink) -> Self {
        Self { sensor: reporting.id, kind: reporting.kind, sequence: 0, truth, out }
    }

    /// Whether effects are to be told.
    pub(crate) fn explains(&self) -> bool {
        self.out.explain
    }

    /// Counts a report that was expected, whether it comes or not.
    pub(crate) fn expected(&mut self) {
        self.out.looks += 1;
    }

    /// The height that the transponder of an aircraft tells, m: barometric, of `age_s` before the report, in steps of 25 ft from the
    /// aerodrome's elevation (corrected for its pressure). What a vehicle carries has no altimeter.
    pub(crate) fn barometric_m(&self, due: &Due, age_s: f64) -> Option<f64> {
        let height_m = due.state.position_m.z - due.state.velocity_mps.z * age_s;
        // Adding zero takes the sign off a rounded height just below the ground.
        let told_m = (height_m / HEIGHT_STEP_M).round() * HEIGHT_STEP_M + 0.0;
        self.truth.class(due.index).aircraft.then_some(told_m)
    }

    /// Appends one report; what each effect did to it is worked out only where asked for.
    pub(crate) fn push<const N: usize>(
        &mut self,
        due: &Due,
        fix: Fix,
        identified: bool,
        effects: impl FnOnce() -> [Shown; N],
    ) {
        self.out.plots.push(Plot {
            sensor: self.sensor,
            kind: self.kind,
            time: fix.time,
            sequence: self.sequence,
            position_m: fix.position_m,
            axis: fix.axis,
            along_m2: fix.variance_m2[0],
            across_m2: fix.variance_m2[1],
            altitude_m: fix.altitude_m,
            polar: None,
            identity: if identified { self.identity(due.index) } else { None },
            scnr_db: None,
        });
        self.sequence += 1;
        let mut cause = Cause {
            key: Some(due.key),
            truth_m: Some(due.state.position_m.xy()),
            ..Cause::default()
        };
        if self.out.explain {
            let shown = effects().into_iter().flatten();
            cause.effects = shown
                .map(|(effect, value, unit)| crate::sensors::Contribution { effect, value, unit })
                .collect();
        }
        self.out.causes.push(cause);
    }

    /// Call sign where there is one, else the address.
    fn identity(&self, index: usize) -> Option<Identity> {
        let callsign = self.truth.callsign(index);
        if callsign == Callsign::default() {
            self.truth.address(index).map(Identity::Address)
        } else {
            Some(Identity::Callsign(callsign))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::testing::Parked;

    fn reporting(period_s: f64, who: Equipped) -> Reporting {
        let equipped = Equipage { aircraft: true, vehicles: false, who };
        Reporting { id: SensorId(3), kind: SensorKind::Gps, equipped, period_s, transponder: false }
    }

    fn times(
        reporting: &Reporting,
        truth: &Parked,
        scan_s: f64,
        scans: u64,
    ) -> Vec<(u64, i64, u64)> {
        let (mut fleet, mut seen) = (Fleet::<()>::default(), Vec::new());
        for scan in 1..=scans {
            let interval = ScanInterval {
                run_seed: 9,
                scan,
                from: SimTime::from_s((scan - 1) as f64 * scan_s),
                to: SimTime::from_s(scan as f64 * scan_s),
            };
            fleet.for_each_due(
                reporting,
                &interval,
                truth,
                |_| (),
                |(), due| {
                    assert!(due.time > interval.from && due.time <= interval.to);
                    seen.push((due.key, due.time.0, due.number));
                },
            );
        }
        seen.sort_unstable();
        seen
    }

    #[test]
    fn reports_do_not_depend_on_the_scan_interval_nor_on_other_targets() {
        let all = reporting(0.37, Equipped::All);
        let three = Parked::aircraft(&[2, 5, 9]);
        let coarse = times(&all, &three, 2.0, 10);
        assert_eq!(coarse, times(&all, &three, 0.1, 200));
        assert_eq!(coarse.len(), coarse.iter().map(|r| r.1).collect::<BTreeSet<_>>().len());
        let alone: Vec<_> = coarse.iter().copied().filter(|r| r.0 == 5).collect();
        assert_eq!(alone, times(&all, &Parked::aircraft(&[5]), 2.0, 10));
        assert!((53..=55).contains(&alone.len()), "20 s of reports every 0.37 s");
    }

    #[test]
    fn a_share_equips_that_share() {
        let keys: Vec<u64> = (0..4000).collect();
        let truth = Parked::aircraft(&keys);
        for share in [0.0, 0.3, 1.0] {
            let equipped = times(&reporting(1.0, Equipped::Share(share)), &truth, 1.0, 1).len();
            let expected = 4000.0 * share;
            let sigma = (expected * (1.0 - share)).sqrt();
            assert!((equipped as f64 - expected).abs() <= 4.0 * sigma, "{share}: {equipped}");
        }
        let vehicles = Equipage { aircraft: false, ..Equipage::all() };
        let reporting = Reporting { equipped: vehicles, ..reporting(1.0, Equipped::All) };
        assert!(times(&reporting, &truth, 1.0, 1).is_empty(), "an aircraft is no vehicle");
    }
}
