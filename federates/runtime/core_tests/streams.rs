//! Numbered messages: handed on once and in order, asked for again, bounded.

use super::{MS, S};
use crate::runtime::messages::{FetchOf, Numbered, Weight};
use crate::runtime::stream::{Inbox, Outbox};

/// A message that weighs what it says.
#[derive(Clone, Debug, PartialEq)]
struct Heavy(usize);

impl Weight for Heavy {
    fn octets(&self) -> usize {
        self.0
    }
}

fn numbered(inc: u64, seq: u64, octets: usize) -> Numbered<Heavy> {
    Numbered { fed: 7, inc, seq, body: Heavy(octets) }
}

#[test]
fn a_stream_hands_on_each_message_once_and_in_order() {
    let mut inbox = Inbox::new(7, 3, 1);
    assert_eq!(inbox.take(0, numbered(3, 2, 2)), []);
    assert_eq!(inbox.take(0, numbered(2, 1, 1)), [], "of another incarnation");
    assert_eq!(
        inbox.take(0, Numbered { fed: 8, ..numbered(3, 1, 1) }),
        [],
        "of another federation"
    );
    assert_eq!(inbox.take(0, numbered(3, 1, 1)), [Heavy(1), Heavy(2)]);
    for seq in [1, 2] {
        assert_eq!(inbox.take(0, numbered(3, seq, 9)), [], "again");
    }
    assert_eq!(inbox.seen(), 2);
}

#[test]
fn what_is_missing_is_asked_for_until_it_comes() {
    let mut inbox: Inbox<Heavy> = Inbox::new(7, 3, 1);
    assert_eq!(inbox.due(S, false), None);
    inbox.told(S, 4);
    inbox.take(S, numbered(3, 3, 1));
    let (mut now, mut asked) = (S, Vec::new());
    while asked.len() < 8 {
        now += MS;
        if let Some((fetch, tries)) = inbox.due(now, false) {
            assert_eq!((fetch.from, fetch.to, tries), (1, 2, asked.len() as u32));
            asked.push(now);
        }
        assert!(now < 10 * S, "asked {asked:?}");
    }
    assert!(asked.windows(2).all(|w| w[1] - w[0] <= 501 * MS));
    inbox.take(now, numbered(3, 1, 1));
    inbox.take(now, numbered(3, 2, 1));
    assert_eq!(inbox.due(now + S, false).map(|(f, _)| f.from), Some(4), "the last of a burst");
}

#[test]
fn streams_are_bounded_on_both_ends() {
    let mut inbox = Inbox::new(7, 3, 1);
    for seq in 2..2_000 {
        inbox.take(0, numbered(3, seq, 64));
    }
    assert_eq!(inbox.take(0, numbered(3, 1, 1)).len(), 257, "256 had waited");
    let mut inbox = Inbox::new(7, 3, 1);
    for seq in 2..200 {
        inbox.take(0, numbered(3, seq, 1 << 20));
    }
    assert_eq!(inbox.take(0, numbered(3, 1, 1)).len(), 5, "4 MiB had waited");

    let mut outbox = Outbox::new(7, 3);
    outbox.confirm("slow", 0);
    for _ in 0..3_000 {
        outbox.push(Heavy(1));
    }
    let all = FetchOf {
        of: "x".into(),
        fetch: crate::runtime::messages::Fetch { fed: 7, inc: 3, from: 1, to: u64::MAX },
    };
    assert_eq!(outbox.fetch("x", &all.fetch).gone_before, 1, "somebody lacks it");
    (0..2_000).for_each(|_| {
        outbox.push(Heavy(1));
    });
    let kept = outbox.fetch("x", &all.fetch).gone_before;
    assert_eq!(
        kept,
        5_001 - 4_096,
        "a reader that confirms nothing: its own beat may have no way here"
    );
    outbox.forget("slow");
    outbox.push(Heavy(1));
    assert_eq!(outbox.fetch("x", &all.fetch).gone_before, 5_001 - 1_024 + 1);
    outbox.confirm("slow", 0);
    for _ in 0..200 {
        outbox.push(Heavy(1 << 20));
    }
    let fetched = outbox.fetch("x", &all.fetch);
    assert!(fetched.gone_before > 5_001 + 130, "64 MiB are kept, whoever lacks more");
    assert_eq!(fetched.items.len(), 1, "one answer has half a megabyte, and one message at least");
}
