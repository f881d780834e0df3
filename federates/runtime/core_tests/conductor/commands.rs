//! What operators are answered, and what else a command makes known.

use super::*;
use scenarios::losses::on_loss_flag;

impl Hand {
    /// A run under this policy whose operator has asked for `command`; the world has made all that was granted, and the SMDFM is lost.
    fn loses_smdfm_after(policy: &str, command: Command) -> Self {
        let on_loss = on_loss_flag(policy).expect("a policy");
        let mut hand = Self::running(Losses { on_loss, ..Losses::default() });
        hand.ends(WORLD, 0, 3);
        hand.command(command);
        hand.token(SMDFM, hand.incs[SMDFM], false);
        hand.pass_with(S / 2, &[WORLD]);
        hand.answers_seal(WORLD, Vec::new());
        hand
    }
}

/// It made its journal of them, too.
#[test]
fn a_station_without_members_does_not_spin() {
    let mut conductor = Conductor::new(config(Losses::default(), 8, false));
    let (mut now, mut turns) = (S, 0);
    while now < 2 * S {
        now = conductor.deadline(now);
        conductor.tick(now, &mut Vec::new());
        turns += 1;
    }
    assert!(turns <= 100, "{turns} in a second");
}

#[test]
fn a_freeze_that_meets_a_loss_is_answered_as_it_ends() {
    let hand = Hand::loses_smdfm_after("degrade", Command::Freeze);
    assert_eq!(hand.conductor.phase(), Phase::Frozen, "{}", hand.lost());
    assert_eq!(hand.answers, [(true, "frozen at frame 3".to_owned())]);
    let hand = Hand::loses_smdfm_after("freeze", Command::Freeze);
    assert_eq!(hand.conductor.phase(), Phase::Frozen, "{}", hand.lost());
    assert!(!hand.answers[0].0 && hand.answers[0].1.contains(SMDFM), "{:?}", hand.answers);
}

#[test]
fn a_stop_that_meets_a_loss_stops() {
    for policy in ["degrade", "freeze"] {
        let mut hand = Hand::loses_smdfm_after(policy, Command::Stop);
        assert_eq!(hand.conductor.phase(), Phase::Stopped, "{policy}: {}", hand.lost());
        hand.results(WORLD);
        assert_eq!(hand.closed.len(), 1, "{policy}");
        assert_eq!(hand.answers, [(true, "stopped".to_owned())], "{policy}");
    }
}

/// A recording has its scene and seed from what is told when a run begins.
#[test]
fn a_run_that_begins_with_a_step_is_told_as_one_that_is_started() {
    let mut hand = Hand::stopped(Losses::default());
    for name in [WORLD, SMDFM] {
        hand.results(name);
    }
    hand.command(Command::Restart);
    for name in [WORLD, SMDFM] {
        hand.say(name, Report::Ready { run: 2, at: None });
    }
    assert_eq!(hand.conductor.phase(), Phase::Configured);
    let before = hand.reached.len();
    hand.command(Command::Step { n: 2 });
    assert_eq!(hand.reached[before..], [Phase::Running]);
}

#[test]
fn no_command_is_named_that_is_refused() {
    let mut hand = Hand::running(Losses::default());
    hand.ends(WORLD, 0, 3);
    hand.lose_smdfm();
    hand.answers.clear();
    for command in [Command::Freeze, Command::Step { n: 1 }, Command::Start] {
        hand.command(command);
    }
    let [freeze, step, start] = &hand.answers[..] else { panic!("{:?}", hand.answers) };
    assert!(freeze == step && step == start, "{:?}", hand.answers);
    assert!(freeze.1.contains("possible now: start smdfm again"), "{}", freeze.1);
}
