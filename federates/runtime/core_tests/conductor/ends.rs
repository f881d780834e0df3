//! The end of a run: whose results are awaited, for how long, and what is said where they do not come.

use super::*;
use crate::runtime::messages::FinalReport;

impl Hand {
    /// A run that was stopped at frame 3, and of which nobody has told results.
    pub(super) fn stopped(losses: Losses) -> Self {
        let mut hand = Self::running(losses);
        hand.command(Command::Stop);
        for name in [WORLD, SMDFM] {
            hand.ends(name, 0, 3);
        }
        assert_eq!(hand.conductor.phase(), Phase::Stopped, "{}", hand.lost());
        hand
    }

    pub(super) fn results(&mut self, name: &'static str) {
        let report = FinalReport { run: 1, name: name.into(), frame: 3, ..Default::default() };
        self.say(name, Report::Final(Box::new(report)));
    }

    fn runs_configured(&self) -> Vec<u32> {
        let configured = self.orders.iter().filter_map(|order| match order {
            Order::Configure(config) => Some(config.run),
            _ => None,
        });
        configured.collect()
    }
}

/// Of 148 runs whose bus lost six words of ten 35 were closed after five seconds without results that were on their way.
#[test]
fn results_are_awaited_of_whoever_is_heard_of() {
    let mut hand = Hand::stopped(Losses::default());
    hand.results(WORLD);
    hand.pass_with(S, &[WORLD, SMDFM]);
    assert_eq!(hand.words, "");
    hand.pass_with(39 * S, &[WORLD, SMDFM]);
    assert_eq!((hand.closed.len(), &hand.words[..]), (0, "waiting for the results of smdfm"));
    hand.results(SMDFM);
    assert_eq!(hand.closed.len(), 1);
    assert_eq!((hand.closed[0].reports.len(), hand.closed[0].failed), (2, false));
    assert!(hand.closed[0].reasons.is_empty(), "{:?}", hand.closed[0].reasons);
}

#[test]
fn a_run_is_closed_without_the_results_of_one_that_hangs_and_says_so() {
    for (step_ms, within_s) in [(None, 60), (Some(9_000), 9), (Some(300), 5)] {
        let step_ms = step_ms.map_or_else(String::new, |ms: u64| ms.to_string());
        let mut losses = Losses::default();
        if !step_ms.is_empty() {
            losses.step_ms = stall_flag(&step_ms).expect("a clock");
        }
        let mut hand = Hand::stopped(losses);
        hand.results(WORLD);
        hand.pass_with((within_s - 1) * S, &[WORLD, SMDFM]);
        assert!(hand.closed.is_empty());
        hand.pass_with(2 * S, &[WORLD, SMDFM]);
        assert_eq!(hand.closed.len(), 1, "{within_s} s");
        let (reasons, failed) = (hand.closed[0].reasons.join("; "), hand.closed[0].failed);
        let said = format!("smdfm has not told its results within {within_s} s");
        assert_eq!((&reasons[..], failed), (&said[..], true));
        assert_eq!(hand.conductor.exit_code(), 1);
        assert_eq!(hand.closed[0].reports.len(), 1);
    }
}

#[test]
fn one_that_is_silent_at_the_end_is_not_waited_for_as_long_as_one_that_hangs() {
    let mut hand = Hand::stopped(Losses::default());
    hand.results(WORLD);
    hand.pass_with(3 * S, &[WORLD]);
    let reasons = hand.closed.first().map_or(String::new(), |run| run.reasons.join("; "));
    assert!(reasons.contains("smdfm (process 1 on here) is lost"), "{reasons}");
}

/// Before, a run that was begun again while results were on their way was never closed.
#[test]
fn a_run_that_is_begun_again_at_once_is_closed_first() {
    let mut hand = Hand::stopped(Losses::default());
    hand.results(WORLD);
    hand.command(Command::Restart);
    hand.pass_with(500 * MS, &[WORLD, SMDFM]);
    assert_eq!((hand.closed.len(), hand.runs_configured()), (0, vec![1]));
    hand.results(SMDFM);
    assert_eq!((hand.closed.len(), hand.runs_configured()), (1, vec![1, 2]));
    assert_eq!(hand.closed[0].reports.len(), 2);
}

/// One that was thought to be lost at the end, and is waited for without end, told its results all the same: the wait for others has an end again.
#[test]
fn results_that_came_after_all_leave_an_end_to_the_wait_for_those_of_others() {
    let mut hand = Hand::running(Losses::default());
    let mut told = None;
    while hand.conductor.phase() == Phase::Running {
        let granted = hand.conductor.granted();
        if told < Some(granted) {
            for name in [WORLD, SMDFM] {
                hand.ends(name, told.map_or(0, |told| told + 1), granted);
            }
            told = Some(granted);
        }
        hand.pass_with(100 * MS, &[WORLD, SMDFM]);
        assert!(hand.now < 100 * S, "{}", hand.lost());
    }
    hand.pass_with(3 * S, &[WORLD]);
    assert!(hand.conductor.awaits_results(), "{}", hand.lost());
    hand.answers_seal(WORLD, Vec::new());
    hand.results(SMDFM);
    assert!(!hand.conductor.awaits_results());
    hand.pass_with(61 * S, &[WORLD]);
    let reasons = hand.closed.first().map_or(String::new(), |run| run.reasons.join("; "));
    assert!(reasons.contains("external-world has not told its results within 60 s"), "{reasons}");
}
