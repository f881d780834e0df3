//! What a launcher knows of the run of its station, and whom it starts again.

use crate::runtime::life_cycle::Phase;
use crate::runtime::messages::Kind;

/// The run as its station tells of it, line by line.
#[derive(Debug, Default)]
pub struct Known {
    /// It runs, stands or awaits its results: other processes are asked to take the places of lost producers.
    begun: bool,
    closed: bool,
}

impl Known {
    /// The station says which phase was reached.
    pub fn reached(&mut self, phase: &str) {
        let is = |of: Phase| phase == of.to_string();
        let begins = is(Phase::Init) || is(Phase::Configured);
        let goes_on = is(Phase::Running) || is(Phase::Frozen);
        if begins || goes_on {
            (self.begun, self.closed) = (goes_on, false);
        }
    }

    /// The station has told its summary.
    pub fn closed(&mut self) {
        (self.begun, self.closed) = (false, true);
    }

    /// Whether the present run is closed, and no other one has begun.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Whether this launcher starts `name` again, which ended with this code, beside those that are `running`. One that ended in order
    /// while its run is not closed is missing all the same; a producer whose place was given away ends so too, and only while
    /// another one is there.
    #[must_use]
    pub fn starts_again(&self, name: &str, code: i32, running: &[String]) -> bool {
        let produces = |name: &str| {
            name == Kind::ExternalWorld.name() || name.starts_with(Kind::TrafficGenerator.name())
        };
        // The conductor asks another producer of this run to take its place.
        let taken = self.begun && produces(name) && running.iter().any(|other| produces(other));
        !taken && (code != 0 || !self.closed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORLD: &str = "external-world";

    fn after(phases: &[&str]) -> Known {
        let mut known = Known::default();
        for phase in phases {
            match *phase {
                "closed" => known.closed(),
                phase => known.reached(phase),
            }
        }
        known
    }

    #[test]
    fn a_restart_begins_a_run_that_is_not_closed() {
        let first = ["CONFIGURED", "RUNNING", "STOPPED", "closed"];
        assert!(after(&first).is_closed());
        for next in ["INIT", "CONFIGURED", "RUNNING"] {
            assert!(!after(&[&first[..], &[next]].concat()).is_closed(), "{next}");
        }
    }

    #[test]
    fn a_producer_is_left_to_others_only_while_the_run_goes_on() {
        let others = ["admin-station".to_owned(), "traffic-generator".to_owned()];
        for (phases, again) in [
            (&[][..], true),
            (&["CONFIGURED"], true),
            (&["CONFIGURED", "RUNNING"], false),
            (&["CONFIGURED", "RUNNING", "FROZEN"], false),
            // Goes on from a journal.
            (&["FROZEN"], false),
            (&["CONFIGURED", "RUNNING", "STOPPED"], false),
            (&["CONFIGURED", "RUNNING", "STOPPED", "closed"], true),
            (&["CONFIGURED", "RUNNING", "STOPPED", "closed", "INIT"], true),
        ] {
            assert_eq!(after(phases).starts_again(WORLD, -9, &others), again, "{phases:?}");
            assert!(after(phases).starts_again(WORLD, -9, &others[..1]), "no other: {phases:?}");
            assert!(after(phases).starts_again("smdfm", -9, &others), "{phases:?}");
        }
    }

    /// Ended by SIGTERM, it ended in order (0), and the run lacked it.
    #[test]
    fn who_ends_in_order_is_started_again_until_the_run_is_closed() {
        let others = ["external-world".to_owned()];
        let run = ["CONFIGURED", "RUNNING", "STOPPED"];
        for known in 0..=run.len() {
            assert!(after(&run[..known]).starts_again("smdfm", 0, &others), "{known}");
        }
        assert!(!after(&[&run[..], &["closed"]].concat()).starts_again("smdfm", 0, &others));
        let given = after(&run[..2]).starts_again("traffic-generator-1", 0, &others);
        assert!(!given, "its place is another one's");
    }
}
