//! Who returns where, after losses that overlap.

use super::*;
use crate::runtime::digest::content;

impl Hand {
    /// Members whose connections are gone and who say nothing more are lost; the others beat.
    fn lose(&mut self, gone: &[&'static str], alive: &[&'static str]) {
        for name in gone {
            self.token(name, self.incs[name], false);
        }
        let mut looks = 0;
        while !gone.iter().all(|name| self.lost().contains(&format!("{name} (process"))) {
            self.pass_with(100 * MS, alive);
            looks += 1;
            assert!(looks < 10, "{}", self.lost());
        }
    }

    /// The SMDFM answers the latest seal: it holds the world's frames up to here.
    fn settled_by_smdfm(&mut self, holds: Option<Frame>) {
        self.answers_seal(SMDFM, vec![(WORLD.into(), holds)]);
    }

    /// The world tells frames with a PDU each, named by its frame.
    fn world_makes(&mut self, first: Frame, last: Frame) {
        let pdus = (first..=last).map(|frame| (frame, vec![100 + frame])).collect();
        let ends = FrameEnds { run: 1, first, last, pdus, state: Some(0), ..FrameEnds::default() };
        self.say(WORLD, Report::Ends(ends));
    }

    /// A new process of the world says how it stands; whether it is admitted.
    fn world_returns(&mut self, instance: u128, frame: Frame) -> bool {
        let accepted = self.accept(hello(WORLD, instance), WORLD);
        assert_eq!(accepted.enter.expect("a run under way").upto, Some(frame));
        let made = (0..=frame).map(|f| content(f, [100 + f].into_iter(), std::iter::empty()));
        let made = made.fold(0, u64::wrapping_add);
        let at = Standing { frame: Some(frame), made, state: Some(0) };
        self.orders.clear();
        self.say(WORLD, Report::Ready { run: 1, at: Some(at) });
        self.orders.iter().any(|o| matches!(o, Order::Admit { name, .. } if name == WORLD))
    }
}

/// One that waits for its inputs is nobody's fault, however long that takes; who does not make them is named.
#[test]
fn a_consumer_is_not_blamed_before_its_producer() {
    let losses = Losses { step_ms: stall_flag("2000").expect("a clock"), ..Losses::default() };
    let mut hand = Hand::running(losses);
    hand.ends(WORLD, 0, 0);
    hand.ends(SMDFM, 0, 0);
    while !hand.lost().contains("is lost") {
        hand.pass_with(100 * MS, &[WORLD, SMDFM]);
        assert!(hand.now < 20 * S, "{}", hand.lost());
    }
    assert!(hand.lost().contains("its frame 1 hangs for 2 s"), "{}", hand.lost());
    assert!(!hand.lost().contains("smdfm (process"), "{}", hand.lost());
}

/// Both are lost, and the SMDFM had used frames of the world that nobody else knows of: they are made again with it.
#[test]
fn what_a_lost_consumer_used_is_made_again_though_nobody_else_knows_of_it() {
    for (told, empty) in [(1, false), (3, true)] {
        let mut hand = Hand::running(Losses::default());
        hand.ends(WORLD, 0, told);
        hand.ends(SMDFM, 0, 3);
        hand.lose(&[WORLD, SMDFM], &[]);
        hand.pass(100 * MS);
        assert_eq!(hand.conductor.phase(), Phase::Frozen, "{}", hand.lost());
        let enter = hand.accept(hello(SMDFM, 2), SMDFM).enter.expect("a run under way");
        assert_eq!(enter.upto, Some(3));
        let world = &enter.producers[0];
        assert_eq!(world.made, Some(3), "the world told of frames up to {told}");
        assert_eq!(world.empty, empty, "nothing was made only if that is known: told of {told}");
    }
}

/// The world has returned at frame 3; the SMDFM, which is at frame 1, is lost after it. Its successor is not told frames 2
/// and 3 by the new incarnation of the world, which never made them: they are made again.
#[test]
fn frames_of_an_incarnation_before_are_made_again() {
    let mut hand = Hand::running(Losses::default());
    hand.world_makes(0, 3);
    hand.ends(SMDFM, 0, 1);
    hand.lose(&[WORLD], &[SMDFM]);
    hand.settled_by_smdfm(Some(3));
    assert!(hand.world_returns(2, 3));
    hand.lose(&[SMDFM], &[WORLD]);
    hand.answers_seal(WORLD, Vec::new());
    let enter = hand.accept(hello(SMDFM, 2), SMDFM).enter.expect("a run under way");
    assert_eq!(enter.upto, Some(1));
    assert_eq!(enter.producers[0].made, Some(3));
    assert!(!enter.producers[0].empty);
    assert!(enter.producers[0].stream.is_some_and(|(inc, _)| inc == hand.incs[WORLD]));
}

/// What the world made beyond its cut does not count: its successor makes it again, and is held to that.
#[test]
fn what_was_made_beyond_a_cut_is_in_no_later_comparison() {
    let mut hand = Hand::running(Losses::default());
    hand.world_makes(0, 3);
    hand.ends(SMDFM, 0, 1);
    hand.lose(&[WORLD], &[SMDFM]);
    hand.settled_by_smdfm(Some(1));
    assert!(hand.world_returns(2, 1));
    // Beyond what the first one had made: its sum is not begun with frames that were cut off.
    let mut looks = 0;
    while hand.conductor.granted() < 5 {
        hand.pass_with(100 * MS, &[WORLD, SMDFM]);
        looks += 1;
        assert!(looks < 50, "granted up to {}", hand.conductor.granted());
    }
    hand.world_makes(2, 5);
    hand.ends(SMDFM, 2, 5);
    hand.lose(&[WORLD], &[SMDFM]);
    hand.settled_by_smdfm(Some(5));
    assert!(hand.world_returns(3, 5), "{:?}", hand.conductor.state().reasons);
}

/// Survivors may finish what was granted; nothing more is granted until the lost one is back.
#[test]
fn no_time_is_granted_while_a_loss_is_settled_or_waited_for() {
    let mut hand = Hand::running(Losses::default());
    hand.ends(WORLD, 0, 3);
    hand.pass_with(400 * MS, &[WORLD, SMDFM]);
    let granted = hand.conductor.granted();
    hand.ends(WORLD, 4, granted);
    hand.lose(&[WORLD], &[SMDFM]);
    hand.ends(SMDFM, 0, granted);
    hand.pass_with(500 * MS, &[SMDFM]);
    assert_eq!(hand.conductor.granted(), granted, "while it is settled");
    hand.settled_by_smdfm(Some(granted));
    hand.pass_with(500 * MS, &[SMDFM]);
    assert_eq!(hand.conductor.granted(), granted, "while the world is waited for");
    assert_eq!(hand.conductor.phase(), Phase::Frozen);
}
