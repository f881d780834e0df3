//! The departure manager: when each departure is to leave its stand, by the best sequence of take-offs within a shift.
//!
//! It knows flight plans, who asks to be pushed, who was, who has come to his line and who took off: milestones, nothing of
//! places. Of each runway it keeps the take-offs of those under way and puts the others behind them ([`best`]); who would wait
//! at the line behind more than a queue is not pushed yet.

use super::departure_sequence::{Departure, Rules, best, first_come, in_order};
use crate::wake::{Recat, Wake};
use std::collections::BTreeMap;

/// A departure as the flight plan has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Departing {
    /// Flight, by index.
    pub flight: u32,
    /// Runway, by index.
    pub runway: usize,
    /// Wake category.
    pub wake: Wake,
    /// Off-block time of the plan, s.
    pub tobt_s: f64,
    /// Expected time from the clearance to push to the runway, s.
    pub exot_s: f64,
    /// An arrival is planned to land at this time for the same stand, s: nobody is held who stands in its way.
    pub stand_wanted_s: Option<f64>,
    /// Slot: calculated take-off time, s.
    pub ctot_s: Option<f64>,
}

/// Figures of the manager; all assumed but the shift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Habits {
    /// Nobody goes more than so many places before or behind his place by when he is ready.
    pub shift: usize,
    /// Wake as ICAO separates it; else RECAT-EU.
    pub icao: bool,
    /// Departures that wait at the line on purpose, so that the runway never waits.
    pub queue: usize,
    /// Nobody is held longer after he asked, s, but for a slot that he would be too early for.
    pub most_s: f64,
    /// A stand is free so long before the landing of who wants it, s.
    pub stand_before_s: f64,
    /// Sequences are made anew so often, s.
    pub again_s: f64,
    /// Those of the plan who leave within this have a place in the sequence, s.
    pub ahead_s: f64,
}

impl Default for Habits {
    fn default() -> Self {
        Self {
            shift: 2,
            icao: true,
            queue: 6,
            most_s: 600.0,
            stand_before_s: 180.0,
            again_s: 60.0,
            ahead_s: 900.0,
        }
    }
}

/// Target times of a departure, s of the run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Milestones {
    /// Off-block, as the airline has it.
    pub tobt_s: f64,
    /// Start-up approval.
    pub tsat_s: f64,
    /// Take-off.
    pub ttot_s: f64,
}

/// Where a departure is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    Stand,
    /// Asks to be pushed since, s.
    Asks(f64),
    /// Pushed at, s.
    UnderWay(f64),
    /// At its line or on the runway.
    AtLine,
    Away,
}

/// What is observed of a runway.
#[derive(Clone, Debug, Default)]
struct Runway {
    /// The last take-off, s, and by whom.
    last: Option<(f64, usize)>,
    /// How many times as long as expected the last ones took to the line.
    factors: Vec<f64>,
}

/// Nobody waits longer at the line on purpose, s for each in the queue; who has a slot waits on his stand but for so long (assumed).
const QUEUES_S: f64 = 90.0;
const BEFORE_SLOT_S: f64 = 180.0;

/// Who has asked is in a plan within so long, s (every five seconds when somebody new asks).
const UNPLANNED_S: f64 = 10.0;

/// Ways to the line that are averaged.
const AVERAGED: usize = 5;

/// The mean of the last ones; `usual` before two were seen.
fn mean_or(list: &[f64], usual: f64) -> f64 {
    if list.len() < 2 { usual } else { list.iter().sum::<f64>() / list.len() as f64 }
}

fn keep_last(list: &mut Vec<f64>, value: f64) {
    if list.len() >= AVERAGED {
        list.remove(0);
    }
    list.push(value);
}

/// The departure manager of an airport.
#[derive(Clone, Debug)]
pub struct Departures {
    habits: Habits,
    all: Vec<Departing>,
    /// By flight: place in `all`.
    places: BTreeMap<u32, usize>,
    stages: Vec<Stage>,
    targets: Vec<Option<Milestones>>,
    runways: BTreeMap<usize, Runway>,
    planned_s: f64,
    /// Somebody asks who did not when the sequences were made.
    new: bool,
}

impl Departures {
    /// The manager of a run: nothing has happened.
    #[must_use]
    pub fn new(habits: Habits, departures: Vec<Departing>) -> Self {
        Self {
            habits,
            places: departures.iter().enumerate().map(|(at, d)| (d.flight, at)).collect(),
            stages: vec![Stage::Stand; departures.len()],
            targets: vec![None; departures.len()],
            runways: departures.iter().map(|d| (d.runway, Runway::default())).collect(),
            all: departures,
            planned_s: f64::NEG_INFINITY,
            new: false,
        }
    }

    /// Flights that it knows, in their order.
    pub fn flights(&self) -> impl Iterator<Item = u32> {
        self.places.keys().copied()
    }

    /// A flight is ready and asks to be pushed back.
    pub fn asks(&mut self, flight: u32, now_s: f64) {
        if let Some(at) = self.places.get(&flight).copied()
            && self.stages[at] == Stage::Stand
        {
            self.stages[at] = Stage::Asks(now_s);
            self.new = true;
        }
    }

    /// A flight is pushed back.
    pub fn pushed(&mut self, flight: u32, at_s: f64) {
        if let Some(at) = self.places.get(&flight).copied()
            && matches!(self.stages[at], Stage::Stand | Stage::Asks(_))
        {
            self.stages[at] = Stage::UnderWay(at_s);
        }
    }

    /// A flight has come to the line of its runway.
    pub fn at_line(&mut self, flight: u32, at_s: f64) {
        let Some(at) = self.places.get(&flight).copied() else { return };
        let runway = self.runways.entry(self.all[at].runway).or_default();
        if let Stage::UnderWay(since_s) = self.stages[at] {
            let factor = (at_s - since_s) / self.all[at].exot_s.max(1.0);
            keep_last(&mut runway.factors, factor.clamp(0.7, 4.0));
            self.stages[at] = Stage::AtLine;
        }
    }

    /// A flight has taken off.
    pub fn took_off(&mut self, flight: u32, at_s: f64) {
        let Some(at) = self.places.get(&flight).copied() else { return };
        if std::mem::replace(&mut self.stages[at], Stage::Away) == Stage::Away {
            return;
        }
        let runway = self.runways.entry(self.all[at].runway).or_default();
        runway.last = Some((at_s, at));
    }

    /// Makes the sequences anew where it is time.
    pub fn scan(&mut self, now_s: f64) {
        let due_s = self.planned_s + if self.new { 5.0 } else { self.habits.again_s };
        if now_s < due_s {
            return;
        }
        (self.planned_s, self.new) = (now_s, false);
        let runways: Vec<usize> = self.runways.keys().copied().collect();
        for runway in runways {
            self.plan(now_s, runway);
        }
    }

    /// Whether a flight that asks is pushed now.
    #[must_use]
    pub fn may_push(&self, flight: u32, now_s: f64) -> bool {
        let Some(at) = self.places.get(&flight).copied() else { return true };
        let Stage::Asks(since_s) = self.stages[at] else { return true };
        let wanted_s =
            self.all[at].stand_wanted_s.map_or(f64::INFINITY, |s| s - self.habits.stand_before_s);
        // Who asks before the first plan waits for it: the runway may be full for an hour.
        let until_s = self.targets[at].map_or(since_s + UNPLANNED_S, |t| t.tsat_s);
        let d = &self.all[at];
        let factor = self.runways.get(&d.runway).map_or(1.0, |r| mean_or(&r.factors, 1.0));
        let opens_s = d.ctot_s.map_or(f64::NEG_INFINITY, |ctot_s| {
            ctot_s - Rules::default().slot_before_s - factor * d.exot_s
        });
        now_s >= until_s.min(opens_s.max(since_s + self.habits.most_s)).min(wanted_s)
    }

    /// Target times of a flight that has a place in a sequence, or had one.
    #[must_use]
    pub fn milestones(&self, flight: u32) -> Option<Milestones> {
        self.targets[*self.places.get(&flight)?]
    }

    fn plan(&mut self, now_s: f64, runway: usize) {
        let habits = self.habits;
        let observed = &self.runways[&runway];
        // By wakes alone: with what lies between take-offs in fact, runways that starve would look slow, and starve more.
        let rules = Rules { icao: habits.icao, same_way_s: 0.0, ..Rules::default() };
        let factor = mean_or(&observed.factors, 1.0);
        let departure = |at: usize, ready_s: f64| {
            let d = &self.all[at];
            let recat = d.wake.recat.unwrap_or_else(|| Recat::like(d.wake.icao));
            Departure { ready_s, recat, way: Some(0), ctot_s: d.ctot_s }
        };
        // Those under way take off in the order in which they reach the line; the others when each would be there.
        let (mut line, mut waiting) = (Vec::new(), Vec::new());
        for (at, d) in self.all.iter().enumerate().filter(|(_, d)| d.runway == runway) {
            let exot_s = factor * d.exot_s;
            match self.stages[at] {
                Stage::UnderWay(since_s) => line.push(((since_s + exot_s).max(now_s), at)),
                Stage::AtLine => line.push((now_s, at)),
                Stage::Asks(since_s) => waiting.push((since_s + exot_s, at)),
                Stage::Stand if d.tobt_s < now_s + habits.ahead_s => {
                    waiting.push((d.tobt_s.max(now_s) + exot_s, at));
                }
                _ => {}
            }
        }
        for list in [&mut line, &mut waiting] {
            list.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        }
        let before = observed.last.map(|(s, at)| (s, departure(at, s)));
        let ahead: Vec<Departure> = line.iter().map(|(s, at)| departure(*at, *s)).collect();
        let order: Vec<usize> = (0..ahead.len()).collect();
        let frozen = in_order(&ahead, &order, before, &rules);
        let last = frozen.times_s.last().zip(ahead.last()).map(|(s, d)| (*s, *d)).or(before);
        // Nobody is there before he could be, but who has waited for long keeps his place by when he asked.
        let ready = |(since_s, at): &(f64, usize)| {
            departure(*at, since_s.max(now_s + factor * self.all[*at].exot_s))
        };
        // Who has to wait for his slot has not come first: nobody behind him waits with him.
        let asked: Vec<Departure> = waiting.iter().map(|(s, at)| departure(*at, *s)).collect();
        let order = first_come(&asked, &rules);
        let waiting: Vec<(f64, usize)> = order.iter().map(|i| waiting[*i]).collect();
        let departures: Vec<Departure> = waiting.iter().map(ready).collect();
        let Ok(sequence) = best(&departures, Some(habits.shift), last, &rules) else { return };
        let mut take_offs: Vec<(usize, f64)> =
            line.iter().map(|l| l.1).zip(frozen.times_s.iter().copied()).collect();
        take_offs.extend(sequence.order.iter().map(|i| waiting[*i].1).zip(sequence.times_s));
        for (place, (at, ttot_s)) in take_offs.iter().enumerate() {
            let d = &self.all[*at];
            // What the queue before it takes is waited for at the line.
            let slot = d.ctot_s.is_some();
            let most_s = if slot { BEFORE_SLOT_S } else { habits.queue as f64 * QUEUES_S };
            let wait_s = (ttot_s - take_offs[place.saturating_sub(habits.queue)].1).min(most_s);
            let known = self.targets[*at].map_or(d.tobt_s, |t| t.tsat_s);
            let tsat_s = match self.stages[*at] {
                Stage::Stand | Stage::Asks(_) => d.tobt_s.max(ttot_s - factor * d.exot_s - wait_s),
                _ => known,
            };
            self.targets[*at] = Some(Milestones { tobt_s: d.tobt_s, tsat_s, ttot_s: *ttot_s });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight_list::WakeCategory;
    use WakeCategory::{Heavy, Light, Medium};

    fn departing(flight: u32, wake: WakeCategory, tobt_s: f64) -> Departing {
        Departing {
            flight,
            runway: 0,
            wake: wake.into(),
            tobt_s,
            exot_s: 400.0,
            stand_wanted_s: None,
            ctot_s: None,
        }
    }

    fn manager(shift: usize, all: &[Departing]) -> Departures {
        // Take-offs one behind the other as their wakes let them.
        let habits = Habits { shift, ..Habits::default() };
        let mut manager = Departures::new(habits, all.to_vec());
        for d in all {
            manager.asks(d.flight, d.tobt_s);
        }
        manager.scan(all.iter().map(|d| d.tobt_s).fold(0.0, f64::max));
        manager
    }

    /// Heavies and lights in turn: a heavy one's wake costs 120 s before a light one, so the lights go together.
    #[test]
    fn a_shift_puts_lights_together_and_nobody_farther_than_it() {
        let wakes = [Heavy, Light, Heavy, Light, Heavy, Light];
        let all: Vec<Departing> =
            wakes.iter().zip(0..).map(|(w, f)| departing(f, *w, 0.1 * f64::from(f))).collect();
        let last = |shift| {
            let manager = manager(shift, &all);
            let ttot = |f| manager.milestones(f).expect("in the sequence").ttot_s;
            let mut order: Vec<u32> = (0..6).collect();
            order.sort_by(|a, b| ttot(*a).total_cmp(&ttot(*b)));
            for (place, f) in order.iter().enumerate() {
                assert!(place.abs_diff(*f as usize) <= shift, "{order:?}");
            }
            order.iter().map(|f| ttot(*f)).fold(0.0, f64::max)
        };
        assert_eq!(last(0), last(1).max(last(0)));
        // First come: three times 120 s behind a heavy, twice 60 s; in the best order only once.
        assert!((last(0) - (400.5 + 480.0)).abs() < 1.0, "{}", last(0));
        assert!(last(2) <= last(0) - 110.0, "{} {}", last(2), last(0));
    }

    #[test]
    fn who_would_wait_behind_the_queue_is_held_and_not_longer_than_he_may_be() {
        let all: Vec<Departing> = (0..20).map(|f| departing(f, Medium, 0.0)).collect();
        let mut manager = manager(2, &all);
        let held = |m: &Departures, now_s: f64| (0..20).filter(|f| !m.may_push(*f, now_s)).count();
        // The first and its queue of six go at once.
        assert_eq!(held(&manager, 0.0), 13);
        assert!(held(&manager, 300.0) < 13, "they go one after the other");
        assert_eq!(held(&manager, 600.0), 0, "nobody is held for ever");
        // One whose stand an arrival wants goes before that.
        let mut wanted = all.clone();
        wanted[19].stand_wanted_s = Some(400.0);
        manager = self::manager(2, &wanted);
        assert!(!manager.may_push(19, 200.0) && manager.may_push(19, 220.0));
        // Those who are due when the run begins ask before anything was planned.
        let mut early = Departures::new(Habits::default(), all.clone());
        all.iter().for_each(|d| early.asks(d.flight, 0.0));
        assert_eq!(held(&early, 0.0), 20);
        assert_eq!(held(&early, UNPLANNED_S), 0, "nobody plans");
        early.scan(5.0);
        assert_eq!(held(&early, 5.0), 13);
        // Whom it does not know it does not hold.
        assert!(manager.may_push(77, 0.0) && manager.milestones(77).is_none());
    }

    #[test]
    fn those_under_way_keep_their_take_offs_and_the_others_come_behind() {
        let all: Vec<Departing> = (0..4).map(|f| departing(f, Medium, 0.0)).collect();
        let mut manager = Departures::new(Habits::default(), all);
        manager.pushed(3, 0.0);
        manager.asks(0, 10.0);
        manager.scan(10.0);
        let ttot = |m: &Departures, f| m.milestones(f).map(|t| t.ttot_s);
        assert_eq!(ttot(&manager, 3), Some(400.0));
        assert_eq!(ttot(&manager, 0), Some(460.0));
        // It comes to its line late, and takes off later still: what is observed moves the others.
        manager.at_line(3, 600.0);
        manager.took_off(3, 640.0);
        manager.took_off(3, 900.0);
        manager.scan(650.0);
        assert!(ttot(&manager, 0).is_some_and(|s| s >= 700.0), "{:?}", ttot(&manager, 0));
        assert!(manager.runways[&0].last == Some((640.0, 3)), "once");
    }

    #[test]
    fn a_slot_that_opens_late_keeps_its_flight_on_its_stand() {
        let mut all: Vec<Departing> = (0..3).map(|f| departing(f, Medium, 0.0)).collect();
        all[0].ctot_s = Some(1500.0);
        let manager = manager(2, &all);
        let first = manager.milestones(0).expect("in the sequence");
        assert_eq!((first.tobt_s, first.ttot_s), (0.0, 1200.0), "not before its slot");
        assert!(!manager.may_push(0, 300.0) && manager.may_push(1, 0.0));
        // Also where that is longer than anybody else is held.
        all[0].ctot_s = Some(2500.0);
        let late = self::manager(2, &all);
        let tsat_s = late.milestones(0).expect("in the sequence").tsat_s;
        assert!(tsat_s > 1600.0 && !late.may_push(0, 1599.0), "TSAT {tsat_s} s");
        assert!(late.may_push(0, tsat_s) && !late.may_push(0, tsat_s - 1.0), "TSAT {tsat_s} s");
    }

    /// One with a slot in fifty minutes was first in the order for as long as it waited, and all but two waited with it.
    #[test]
    fn nobody_waits_for_the_slot_of_another() {
        let mut all: Vec<Departing> =
            (0..10).map(|f| departing(f, Medium, 30.0 * f64::from(f))).collect();
        for slotted in [0, 4, 9] {
            all.iter_mut().for_each(|d| d.ctot_s = None);
            all[slotted].ctot_s = Some(3000.0);
            let manager = manager(2, &all);
            let ttot = |f: usize| manager.milestones(f as u32).expect("in the sequence").ttot_s;
            let others = (0..10).filter(|f| *f != slotted);
            // Nine mediums, a minute apart, the first at the runway after 400 s.
            let last_s = others.map(ttot).fold(0.0, f64::max);
            assert!(last_s <= 270.0 + 400.0 + 9.0 * 60.0 + 1.0, "{slotted}: {last_s}");
            assert!(ttot(slotted) >= 2700.0, "{slotted}: {}", ttot(slotted));
        }
    }

    /// Who asked first goes first where nothing is gained by another order, however far his stand is from the runway.
    #[test]
    fn a_short_way_to_the_runway_overtakes_nobody_who_has_waited() {
        let mut all: Vec<Departing> = (0..22).map(|f| departing(f, Medium, 0.0)).collect();
        // Twenty are under way; then one from afar asks, and long after him one from beside the line.
        (all[20].exot_s, all[21].exot_s, all[21].tobt_s) = (600.0, 200.0, 700.0);
        let mut manager = Departures::new(Habits::default(), all);
        (0..20).for_each(|f| manager.pushed(f, 0.0));
        manager.asks(20, 0.0);
        manager.asks(21, 700.0);
        manager.scan(700.0);
        let ttot = |f| manager.milestones(f).expect("in the sequence").ttot_s;
        assert!(ttot(20) < ttot(21), "{} {}", ttot(20), ttot(21));
    }
}
