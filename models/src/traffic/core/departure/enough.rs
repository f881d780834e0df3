//! Whether a departure's runway is long enough on this day: where it is not, it does not go.

use crate::traffic::core::flight::SPOOL_M;
use crate::traffic::core::{Core, Direction, Phase, Policy, RETRY_S, Timing};

/// On its stand it is looked again so often, s.
const AGAIN_S: f64 = 4.0 * RETRY_S;

impl Core {
    /// What a departure lacks of its runway on this day, in words, with what is there ahead of it, m; `None`: nothing.
    fn lacks_of(&self, m: usize, needs_m: Option<f64>, there_m: f64) -> Option<String> {
        let (name, end) = (&self.flights[m].callsign, self.end_name(m));
        match needs_m {
            Some(needs_m) if needs_m <= there_m => None,
            Some(needs_m) => Some(format!(
                "{name}: needs {:.0} m of runway {end} for its take-off, {:.0} m are there",
                needs_m.ceil(),
                there_m.floor()
            )),
            None => Some(format!(
                "{name}: cannot take off from runway {end} in this air and {:.0} m/s of head wind",
                self.head_mps(m)
            )),
        }
    }

    /// Before it leaves its stand: of all entries the one with most of the runway ahead counts. Without one it is another matter.
    fn lacks_runway(&self, m: usize) -> Option<String> {
        let f = &self.flights[m];
        let there_m = self.arcs.longest_run_m(&self.net, f.runway);
        let needs_m = f.needs_runway_m(self.day.density_ratio, self.head_mps(m));
        self.lacks_of(m, needs_m, there_m).filter(|_| there_m > 0.0)
    }

    /// On its way, lined up or rolling: the runway ahead of where it is to begin, or of where it is by now.
    pub(in crate::traffic::core) fn lacks_runway_ahead(&self, m: usize) -> Option<String> {
        let (f, mover) = (&self.flights[m], &self.movers[m]);
        let rolls = mover.phase == Phase::Rolling;
        let from_m = if rolls { mover.s } else { mover.way.stop_m };
        let there_m = mover.way.ends_m.last()? - from_m;
        // The run to a speed goes with its square.
        let gained = if rolls { (mover.v / self.lift_off_mps(m)).min(1.0) } else { 0.0 };
        let run_m = f.run_m(self.day.density_ratio, self.head_mps(m));
        self.lacks_of(m, run_m.map(|run_m| (run_m + SPOOL_M) * (1.0 - gained * gained)), there_m)
    }

    /// Whether its runway keeps a departure on its stand: it is too short in the weather of now. Nobody waits behind its plan.
    pub(super) fn kept_by_runway(&mut self, m: usize) -> bool {
        if self.flights[m].direction != Direction::Departure {
            return false;
        }
        let Some(why) = self.lacks_runway(m) else {
            // Where none is laid its way may say something else.
            self.movers[m].lacks_runway &= self.movers[m].way.pieces.is_empty();
            return false;
        };
        self.keep_on_stand(m, &why);
        true
    }

    /// The same of the way that has been laid for it, whose entry may turn it in later than entries do.
    pub(super) fn kept_by_its_way(&mut self, m: usize) -> bool {
        if self.flights[m].direction != Direction::Departure {
            return false;
        }
        match self.lacks_runway_ahead(m) {
            Some(why) => {
                self.keep_on_stand(m, &why);
                true
            }
            None => {
                self.movers[m].lacks_runway = false;
                false
            }
        }
    }

    /// Keeps it on its stand for a while, without a plan.
    fn keep_on_stand(&mut self, m: usize, why: &str) {
        if !self.movers[m].lacks_runway {
            self.remark(format!("{why}, it stays on its stand"));
        }
        let planned = self.movers[m].timing.planned;
        let mover = &mut self.movers[m];
        mover.lacks_runway = true;
        mover.next_try_s = self.time_s + AGAIN_S;
        (mover.push, mover.way) = Default::default();
        mover.timing = Timing::default();
        mover.waits_since_s = None;
        if planned && self.policy == Policy::Planned {
            self.book();
        }
    }

    /// Whether the weather has turned so that its runway is too short for who is at its line or lined up: it is towed to a stand, from
    /// which it goes when it can.
    pub(in crate::traffic::core) fn turned_back_by_runway(&mut self, m: usize) -> bool {
        let Some(why) = self.lacks_runway_ahead(m) else { return false };
        if !self.tow_off_runway(m, &why) && !self.movers[m].lacks_runway {
            self.movers[m].lacks_runway = true;
            self.remark(format!("{why}, it waits"));
        }
        true
    }

    /// The weather has turned: who rolls and cannot lift off before the end any more stops, while he still can.
    pub(in crate::traffic::core) fn rejects_for_weather(&mut self, m: usize) {
        if self.movers[m].phase == Phase::Rolling && self.lacks_runway_ahead(m).is_some() {
            self.cancel_take_off(m);
        }
    }

    /// Too little runway is ahead, and no way leads back: it is towed to a stand. Whether one is free.
    pub(in crate::traffic::core) fn tow_off_runway(&mut self, m: usize, why: &str) -> bool {
        let Some((stand, _)) = self.free_stands(m, 6).into_iter().next() else { return false };
        let to = self.net.stands[stand].name.clone();
        self.remark(format!("{why}, towed to stand {to}"));
        self.release_held(m);
        self.keep_for_roll(m, Vec::new());
        self.vacate(m);
        self.end_clearances(m);
        let mover = &mut self.movers[m];
        (mover.phase, mover.tow_to) = (Phase::Absent, Some(stand));
        (mover.push, mover.way) = Default::default();
        mover.timing = Timing::default();
        (mover.granted, mover.insisted) = Default::default();
        (mover.first_held, mover.next, mover.s, mover.slip) = (0, 0, 0.0, 0.0);
        (mover.v, mover.a) = (0.0, 0.0);
        mover.next_try_s = self.time_s + 120.0;
        mover.measures.on_runway_s = [None; 2];
        self.book();
        true
    }
}
