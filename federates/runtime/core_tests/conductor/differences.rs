//! What a consumer used is held against what its producers named.

use super::*;
use crate::runtime::messages::Used;

/// Frames of the world with a PDU each, whose hash is ten times the frame and one.
fn named(first: Frame, last: Frame) -> Report {
    let pdus = (first..=last).map(|frame| (frame, vec![10 * frame + 1])).collect();
    Report::Ends(FrameEnds { run: 1, first, last, pdus, ..FrameEnds::default() })
}

/// A step of the SMDFM that used PDUs of this sum in these frames.
fn used(first: Frame, last: Frame, sum: u64) -> Report {
    let used = vec![Used { of: WORLD.into(), first, last, sum }];
    Report::Ends(FrameEnds { run: 1, first, last, used, state: Some(0), ..FrameEnds::default() })
}

#[test]
fn a_consumer_that_used_other_pdus_than_were_named_ends_the_run_and_is_named() {
    let told = |mut reports: Vec<(&'static str, Report)>| {
        let mut hand = Hand::running(Losses::default());
        reports.drain(..).for_each(|(name, report)| hand.say(name, report));
        hand.lost()
    };
    let (first, right) = ((WORLD, named(0, 1)), (SMDFM, used(0, 1, 1 + 11)));
    assert_eq!(told(vec![first.clone(), right.clone()]), "");
    assert_eq!(told(vec![right.clone(), first.clone()]), "", "whoever is heard first");
    let second = [(WORLD, named(2, 3)), (SMDFM, used(2, 3, 21 + 31))];
    assert_eq!(told([vec![first.clone(), right.clone()], second.to_vec()].concat()), "");
    let whose = "smdfm did not use the PDUs that external-world named in frames";
    // One left out, one too many, none, and those of the frame before.
    for sum in [1, 1 + 11 + 21, 0, 11 + 21] {
        for reports in
            [[first.clone(), (SMDFM, used(0, 1, sum))], [(SMDFM, used(0, 1, sum)), first.clone()]]
        {
            let words = told(reports.to_vec());
            assert!(words.contains(&format!("{whose} 0 to 1")), "{sum}: {words}");
        }
    }
    let late = [right, first, (SMDFM, used(2, 3, 21)), (WORLD, named(2, 3))];
    assert!(told(late.to_vec()).contains(&format!("{whose} 2 to 3")));
    // Of somebody who is no member, or whose frames are not remembered, nothing is known.
    let mut other = used(0, 1, 5);
    if let Report::Ends(ends) = &mut other {
        ends.used[0].of = "nobody".into();
    }
    assert_eq!(told(vec![(WORLD, named(0, 1)), (SMDFM, other)]), "");
}

/// Beyond its cut nothing of one that the run goes on without counts, though more may be known of it.
#[test]
fn frames_of_one_that_the_run_goes_on_without_are_not_compared() {
    let mut hand = Hand::running(Losses::default());
    hand.say(WORLD, named(0, 3));
    hand.say(SMDFM, used(0, 0, 1));
    hand.token(WORLD, hand.incs[WORLD], false);
    while !hand.lost().contains("external-world (process") {
        hand.pass_with(100 * MS, &[SMDFM]);
    }
    hand.pass_with(500 * MS, &[SMDFM]);
    hand.answers_seal(SMDFM, vec![(WORLD.into(), Some(1))]);
    hand.command(Command::Without { name: WORLD.into() });
    hand.say(SMDFM, used(1, 3, 11));
    assert!(!hand.lost().contains("did not use"), "{}", hand.lost());
}
