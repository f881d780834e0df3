//! Steps of a frozen run: like all time they are granted as far ahead as members remember what they made.

use super::*;

/// Members have ended all that was granted; how many frames that were.
fn end_granted(hand: &mut Hand, ended: &mut Frame) -> Frame {
    let (first, last) = (*ended + 1, hand.conductor.granted());
    for name in [WORLD, SMDFM] {
        hand.ends(name, first, last);
    }
    *ended = last;
    last + 1 - first
}

/// Two thousand frames were granted at once: what was lost of the first fifteen hundred nobody had any more.
#[test]
fn a_long_step_is_granted_window_by_window_and_ends_where_it_was_asked() {
    let mut hand = Hand::running(Losses::default());
    hand.command(Command::Freeze);
    for name in [WORLD, SMDFM] {
        hand.ends(name, 0, 3);
    }
    assert_eq!(hand.conductor.phase(), Phase::Frozen);
    let (mut ended, mut turns) = (3, 0);
    hand.command(Command::Step { n: 500 });
    while hand.conductor.phase() == Phase::Running {
        let frames = end_granted(&mut hand, &mut ended);
        turns += 1;
        assert!((1..=8).contains(&frames), "{frames} after {ended}");
    }
    assert_eq!(
        (ended, hand.conductor.granted(), hand.conductor.phase()),
        (503, 503, Phase::Frozen)
    );
    assert!(turns >= 63, "{turns}");
}

#[test]
fn a_freeze_or_stop_in_a_long_step_is_obeyed_within_a_window() {
    for (command, then) in [(Command::Freeze, Phase::Frozen), (Command::Stop, Phase::Stopped)] {
        let mut hand = Hand::running(Losses::default());
        hand.command(Command::Freeze);
        for name in [WORLD, SMDFM] {
            hand.ends(name, 0, 3);
        }
        let mut ended = 3;
        hand.command(Command::Step { n: 500 });
        for _ in 0..10 {
            end_granted(&mut hand, &mut ended);
        }
        let granted = hand.conductor.granted();
        hand.command(command.clone());
        end_granted(&mut hand, &mut ended);
        assert_eq!((hand.conductor.phase(), ended), (then, granted), "{command:?}");
        hand.pass_with(S, &[WORLD, SMDFM]);
        assert_eq!(hand.conductor.granted(), granted, "nothing more is granted");
    }
}
