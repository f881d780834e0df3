//! Conductor, member, views and streams by hand: one message at a time, also those that no member of ours would send.

use super::conductor::{Conductor, ConductorConfig, Effect};
use super::federate::{Aside, Federate, FrameInputs, FrameOut, Octets};
use super::life_cycle::Phase;
use super::member::{CONDUCTOR, Effect as Act, Member};
use super::messages::Weight;
use super::messages::{
    Accepted, Beat, FetchOf, FinalReport, Frame, FrameEnds, Hello, Joined, Kind, Notice, Numbered,
    Order, Repair, Repaired, Report, RunConfig, Standing, Was, Welcome,
};
use super::stream::{Inbox, Outbox};
use super::views::Views;
use scenarios::losses::{Losses, stall_flag};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

mod returns;

const MS: u64 = 1_000_000;
const S: u64 = 1_000 * MS;
const WORLD: &str = "external-world";
const SMDFM: &str = "smdfm";

/// A conductor and what its two members say.
struct Hand {
    conductor: Conductor,
    now: u64,
    incs: BTreeMap<&'static str, u64>,
    seqs: BTreeMap<&'static str, u64>,
    orders: Vec<Order>,
    reached: Vec<Phase>,
}

fn hello(name: &str, instance: u128) -> Hello {
    Hello {
        name: name.into(),
        kind: if name == SMDFM { Kind::Smdfm } else { Kind::ExternalWorld },
        pid: 1,
        host: "here".into(),
        version: "v".into(),
        scene_hash: 1,
        instance,
        was: None,
    }
}

impl Hand {
    /// Both have joined and are ready, and the run has been granted frame 3.
    fn running(losses: Losses) -> Self {
        Self::with(losses, 8, false)
    }

    fn with(losses: Losses, window: Frame, through_router: bool) -> Self {
        let conductor = Conductor::new(ConductorConfig {
            scene: "toy".into(),
            scene_hash: 1,
            version: "v".into(),
            expected: vec![WORLD.into(), SMDFM.into()],
            producers: vec![WORLD.into()],
            optional: Vec::new(),
            generators: 1,
            seed: 7,
            step_ns: 50 * MS as i64,
            start_utc_ns: 0,
            last_frame: 1_000,
            rate: 1.0,
            autostart: true,
            batch: false,
            await_spectators: Vec::new(),
            await_spectators_ns: 0,
            window,
            closes: None,
            front_ends: BTreeMap::new(),
            through_router,
            fed: 7,
            losses,
        });
        let (incs, seqs) = (BTreeMap::new(), BTreeMap::new());
        let (orders, reached) = (Vec::new(), Vec::new());
        let mut hand = Self { conductor, now: S, incs, seqs, orders, reached };
        for (name, hears) in [(WORLD, vec![]), (SMDFM, vec![WORLD.to_owned()])] {
            hand.accept(hello(name, 1), name);
            let present = Report::Present { hears, consumes: name == SMDFM };
            let present = Numbered { fed: 7, inc: hand.incs[name], seq: 0, body: present };
            hand.report(name, present);
        }
        hand.pass(30 * MS);
        for name in [WORLD, SMDFM] {
            hand.say(name, Report::Ready { run: 1, at: None });
        }
        assert_eq!(hand.conductor.phase(), Phase::Running);
        hand.pass(160 * MS);
        assert_eq!(hand.conductor.granted(), 3);
        hand
    }

    fn ask(&mut self, hello: Hello) -> Welcome {
        let mut effects = Vec::new();
        self.conductor.hello(self.now, hello, 9, &mut effects);
        let told = effects.iter().find_map(|effect| match effect {
            Effect::Welcome(9, welcome) => Some(welcome.clone()),
            _ => None,
        });
        self.take(effects);
        told.expect("an answer")
    }

    fn accept(&mut self, hello: Hello, name: &'static str) -> Accepted {
        match self.ask(hello) {
            Welcome::Accepted(accepted) => {
                self.incs.insert(name, accepted.inc);
                self.seqs.insert(name, 0);
                *accepted
            }
            other => panic!("{other:?}"),
        }
    }

    fn refused(&mut self, hello: Hello) -> String {
        match self.ask(hello) {
            Welcome::Refused(why) | Welcome::Later(why) => why,
            other => panic!("{other:?}"),
        }
    }

    fn take(&mut self, effects: Vec<Effect>) {
        for effect in effects {
            match effect {
                Effect::Order(order) => self.orders.push(order.body),
                Effect::Reached { phase, .. } => self.reached.push(phase),
                _ => {}
            }
        }
    }

    fn report(&mut self, name: &str, report: Numbered<Report>) {
        let mut effects = Vec::new();
        self.conductor.report(self.now, name, report, &mut effects);
        self.take(effects);
    }

    fn say(&mut self, name: &'static str, body: Report) {
        let seq = self.seqs.entry(name).or_default();
        *seq += 1;
        let report = Numbered { fed: 7, inc: self.incs[name], seq: *seq, body };
        self.report(name, report);
    }

    fn ends(&mut self, name: &'static str, first: Frame, last: Frame) {
        let state = (name == SMDFM).then_some(last * 11);
        self.say(
            name,
            Report::Ends(FrameEnds { run: 1, first, last, state, ..Default::default() }),
        );
    }

    /// Time passes, and nobody says anything.
    fn pass(&mut self, ns: u64) {
        let until = self.now + ns;
        while self.now < until {
            self.now += 10 * MS;
            let mut effects = Vec::new();
            self.conductor.tick(self.now, &mut effects);
            self.take(effects);
        }
    }

    fn beat(&mut self, name: &str, fed: u128, inc: u64) {
        self.conductor.beat(self.now, name, &Beat { fed, inc, run: 1, ..Beat::default() });
    }

    /// Time passes, and these beat as they should.
    fn pass_with(&mut self, ns: u64, names: &[&'static str]) {
        for _ in 0..ns / (100 * MS) {
            for name in names {
                self.beat(name, 7, self.incs[name]);
            }
            self.pass(100 * MS);
        }
    }

    fn frame(&self, name: &str) -> Frame {
        let state = self.conductor.state();
        state.members.iter().find(|m| m.name == name).map_or(0, |m| m.frame)
    }

    fn lost(&self) -> String {
        self.conductor.state().reasons.join("; ")
    }

    fn token(&mut self, name: &str, inc: u64, alive: bool) {
        let mut effects = Vec::new();
        self.conductor.alive(self.now, name, inc, alive, &mut effects);
        self.take(effects);
    }

    /// The SMDFM is lost at the frame that it told last, and the world answers what it is asked.
    fn lose_smdfm(&mut self) {
        self.token(SMDFM, self.incs[SMDFM], false);
        while !self.lost().contains(SMDFM) {
            self.pass_with(100 * MS, &[WORLD]);
        }
        let granted = self.conductor.granted();
        self.pass_with(500 * MS, &[WORLD]);
        assert_eq!(self.conductor.granted(), granted, "no time is granted while a loss is settled");
        let view = self.orders.iter().rev().find_map(|order| match order {
            Order::Seal { view, .. } => Some(*view),
            _ => None,
        });
        let view = view.expect("a seal");
        self.say(WORLD, Report::Sealed { run: 1, view, holds: Vec::new() });
        self.say(WORLD, Report::Held { run: 1, view });
        assert_eq!(self.conductor.phase(), Phase::Frozen, "{}", self.lost());
    }
}

#[test]
fn frame_ends_with_a_gap_or_beyond_the_grant_are_not_taken() {
    let mut hand = Hand::running(Losses::default());
    hand.ends(WORLD, 1, 2);
    assert_eq!(hand.frame(WORLD), 0);
    hand.ends(WORLD, 0, 1);
    assert_eq!(hand.frame(WORLD), 1);
    hand.ends(WORLD, 2, 9);
    assert_eq!(hand.frame(WORLD), 1);
    hand.ends(WORLD, 3, 3);
    assert_eq!(hand.frame(WORLD), 1);
    hand.ends(WORLD, 2, 3);
    assert_eq!(hand.frame(WORLD), 3);
}

#[test]
fn words_of_others_do_not_keep_a_silent_member_alive() {
    for (fed, more) in [(7, 1), (8, 0)] {
        let mut hand = Hand::running(Losses::default());
        for _ in 0..25 {
            hand.beat(SMDFM, fed, hand.incs[SMDFM] + more);
            hand.pass_with(100 * MS, &[WORLD]);
        }
        assert!(hand.lost().contains("smdfm"), "{fed} {more}: {}", hand.lost());
    }
}

#[test]
fn a_connection_that_is_gone_is_a_hint_about_its_own_incarnation_only() {
    let mut hand = Hand::running(Losses::default());
    hand.token(SMDFM, hand.incs[SMDFM] + 1, false);
    hand.pass_with(600 * MS, &[WORLD]);
    assert!(hand.lost().is_empty(), "of another incarnation: {}", hand.lost());
    let mut hand = Hand::running(Losses::default());
    hand.token(SMDFM, hand.incs[SMDFM], false);
    hand.pass_with(3 * S, &[WORLD, SMDFM]);
    assert!(hand.lost().is_empty(), "it beats all the same: {}", hand.lost());
    hand.pass_with(500 * MS, &[WORLD]);
    assert!(hand.lost().contains("its process or connection is gone"), "{}", hand.lost());
}

/// A connection is closed after 2 s of silence: that may not shorten a longer `stall_ms`, nor lengthen what becomes of a process
/// that is killed when it is back.
#[test]
fn a_connection_that_ran_out_leaves_a_longer_stall_as_it_is() {
    let stall_ms = stall_flag("20000").expect("a clock");
    let mut hand = Hand::running(Losses { stall_ms, ..Losses::default() });
    hand.pass_with(2 * S, &[WORLD]);
    hand.token(SMDFM, hand.incs[SMDFM], false);
    hand.pass_with(17 * S, &[WORLD]);
    assert!(hand.lost().is_empty(), "{}", hand.lost());
    // Heard again, over another connection; then its process ends.
    hand.token(SMDFM, hand.incs[SMDFM], true);
    hand.pass_with(S, &[WORLD, SMDFM]);
    hand.token(SMDFM, hand.incs[SMDFM], false);
    hand.pass_with(S / 2, &[WORLD]);
    assert!(hand.lost().contains("its process or connection is gone"), "{}", hand.lost());

    let stall_ms = stall_flag("20000").expect("a clock");
    let mut hand = Hand::running(Losses { stall_ms, ..Losses::default() });
    hand.pass_with(2 * S, &[WORLD]);
    hand.token(SMDFM, hand.incs[SMDFM], false);
    hand.pass_with(19 * S, &[WORLD]);
    assert!(hand.lost().contains("nothing was heard of it for 20 s"), "{}", hand.lost());
}

/// Through a router the station has one connection: where that breaks, all are gone at once, and nothing is said of any process. One
/// that goes alone has ended.
#[test]
fn all_gone_at_once_behind_a_router_is_the_stations_own_connection() {
    for (through_router, both, lost) in
        [(true, true, false), (true, false, true), (false, true, true)]
    {
        let stall_ms = stall_flag("20000").expect("a clock");
        let losses = Losses { stall_ms, ..Losses::default() };
        let mut hand = Hand::with(losses, 8, through_router);
        hand.pass_with(S, &[WORLD, SMDFM]);
        hand.token(SMDFM, hand.incs[SMDFM], false);
        if both {
            hand.token(WORLD, hand.incs[WORLD], false);
        }
        let heard = [WORLD];
        hand.pass_with(S, if both { &[] } else { &heard });
        assert_eq!(!hand.lost().is_empty(), lost, "{through_router} {both}: {}", hand.lost());
        if !lost {
            for name in [WORLD, SMDFM] {
                hand.token(name, hand.incs[name], true);
            }
            hand.pass_with(S, &[WORLD, SMDFM]);
            assert_eq!(hand.conductor.phase(), Phase::Running);
            // Afterwards a process that ends is missed at once.
            hand.token(SMDFM, hand.incs[SMDFM], false);
            hand.pass_with(S / 2, &[WORLD]);
            assert!(hand.lost().contains("its process or connection is gone"), "{}", hand.lost());
        }
    }
}

#[test]
fn what_the_conductor_did_not_hear_while_it_stood_still_is_nobodys_fault() {
    let mut hand = Hand::running(Losses::default());
    hand.now += 30 * S;
    hand.pass(100 * MS);
    assert!(hand.lost().is_empty(), "{}", hand.lost());
    hand.pass_with(2 * S, &[WORLD]);
    assert!(hand.lost().contains("smdfm"), "silent after it as well: {}", hand.lost());
}

#[test]
fn who_does_not_belong_is_refused_with_the_reason() {
    let mut hand = Hand::running(Losses::default());
    for (hello, words) in [
        (Hello { version: "w".into(), ..hello(SMDFM, 2) }, "use the same build everywhere"),
        (Hello { scene_hash: 2, ..hello(SMDFM, 2) }, "another scene"),
        (hello("external-world-2", 2), "is not expected"),
        (hello(SMDFM, 2), "already running"),
    ] {
        let why = hand.refused(hello);
        assert!(why.contains(words), "{words}: {why}");
    }
    let again = hand.ask(hello(SMDFM, 1));
    assert!(matches!(again, Welcome::Accepted(a) if a.inc == hand.incs[SMDFM]));
}

#[test]
fn who_returns_is_admitted_if_it_stands_as_the_lost_one_stood() {
    let right = Standing { frame: Some(3), made: 0, state: Some(33) };
    for (at, admitted) in [
        (right, true),
        (Standing { frame: Some(2), ..right }, false),
        (Standing { frame: None, ..right }, false),
        (Standing { made: 1, ..right }, false),
        (Standing { state: Some(34), ..right }, false),
        (Standing { state: None, ..right }, false),
    ] {
        let mut hand = Hand::running(Losses::default());
        hand.ends(WORLD, 0, 3);
        hand.ends(SMDFM, 0, 3);
        hand.lose_smdfm();
        let accepted = hand.accept(hello(SMDFM, 2), SMDFM);
        let enter = accepted.enter.expect("a run under way");
        assert_eq!((enter.upto, enter.keep), (Some(3), false));
        assert_eq!(enter.producers[0].made, Some(3));
        hand.orders.clear();
        hand.say(SMDFM, Report::Ready { run: 1, at: Some(at) });
        let admit = Order::Admit { run: 1, name: SMDFM.into(), inc: hand.incs[SMDFM], from: 4 };
        assert_eq!(hand.orders.contains(&admit), admitted, "{at:?}: {:?}", hand.orders);
        let dismissed = hand.orders.iter().any(|o| matches!(o, Order::Dismiss { .. }));
        assert_eq!(dismissed, !admitted, "{at:?}");
        let phase = if admitted { Phase::Running } else { Phase::Frozen };
        assert_eq!(hand.conductor.phase(), phase, "{at:?}");
    }
}

#[test]
fn a_process_keeps_its_state_only_if_it_is_the_one_that_was_lost() {
    let was = |inc, run| Some(Was { fed: 7, inc, run });
    for (instance, more, run, keep) in
        [(1, 0, 1, true), (2, 0, 1, false), (1, 1, 1, false), (1, 0, 2, false)]
    {
        let mut hand = Hand::running(Losses::default());
        hand.ends(WORLD, 0, 3);
        hand.ends(SMDFM, 0, 3);
        let inc = hand.incs[SMDFM];
        hand.lose_smdfm();
        let hello = Hello { was: was(inc + more, run), ..hello(SMDFM, instance) };
        let enter = hand.accept(hello, SMDFM).enter.expect("a run under way");
        assert_eq!(enter.keep, keep, "instance {instance}, incarnation + {more}, run {run}");
    }
}

#[test]
fn one_that_dies_at_the_same_frame_again_is_not_taken_back_for_ever() {
    let mut hand = Hand::running(Losses::default());
    hand.ends(WORLD, 0, 3);
    hand.ends(SMDFM, 0, 3);
    for instance in 2..5 {
        hand.lose_smdfm();
        hand.accept(hello(SMDFM, instance), SMDFM);
        let at = Standing { frame: Some(3), made: 0, state: Some(33) };
        hand.say(SMDFM, Report::Ready { run: 1, at: Some(at) });
        assert_eq!(hand.conductor.phase(), Phase::Running);
    }
    hand.lose_smdfm();
    let why = hand.refused(hello(SMDFM, 5));
    assert!(why.contains("dies at frame 4 again and again"), "{why}");
}

/// Slow members hold time up, and nobody catches up in a burst.
#[test]
fn time_waits_for_the_slowest_and_slips() {
    let mut hand = Hand::running(Losses::default());
    hand.pass_with(1_500 * MS, &[WORLD, SMDFM]);
    assert_eq!(hand.conductor.granted(), 5, "five frames ahead of the slowest");
    hand.ends(WORLD, 0, 5);
    hand.ends(SMDFM, 0, 5);
    hand.pass_with(100 * MS, &[WORLD, SMDFM]);
    let granted = hand.conductor.granted();
    assert!((6..=8).contains(&granted), "two frames later, not thirty: {granted}");
}

/// A scan of the SMDFM that takes most of its second holds nobody up; one that takes longer does.
#[test]
fn a_long_scan_does_not_hold_time_up() {
    let mut hand = Hand::with(Losses::default(), 40, false);
    let mut made = 0;
    hand.ends(WORLD, 0, 3);
    for _ in 0..14 {
        made = hand.conductor.granted().max(made);
        hand.ends(WORLD, hand.frame(WORLD) + 1, made);
        hand.pass_with(100 * MS, &[WORLD, SMDFM]);
    }
    assert_eq!(hand.conductor.granted(), 20, "a scan ahead of the SMDFM");
    // A producer that is late is waited for as before.
    hand.ends(SMDFM, 0, 20);
    hand.pass_with(1_500 * MS, &[WORLD, SMDFM]);
    assert_eq!(hand.conductor.granted(), made + 5);
}

/// Each frame has its own clock, though frames are reported together.
#[test]
fn a_member_that_goes_on_is_not_lost_however_slow_it_is() {
    let losses =
        Losses { step_ms: stall_flag("smdfm=2000").expect("a clock"), ..Losses::default() };
    let mut hand = Hand::running(losses);
    hand.ends(WORLD, 0, 3);
    for frame in 1..4 {
        for _ in 0..15 {
            let beat = Beat {
                fed: 7,
                inc: hand.incs[SMDFM],
                run: 1,
                working: Some((frame, 1)),
                ..Beat::default()
            };
            hand.conductor.beat(hand.now, SMDFM, &beat);
            hand.pass_with(100 * MS, &[WORLD]);
        }
        assert!(!hand.lost().contains("is lost"), "at frame {frame}: {}", hand.lost());
    }
    for _ in 0..15 {
        let beat = Beat {
            fed: 7,
            inc: hand.incs[SMDFM],
            run: 1,
            working: Some((3, 1)),
            ..Beat::default()
        };
        hand.conductor.beat(hand.now, SMDFM, &beat);
        hand.pass_with(100 * MS, &[WORLD]);
    }
    assert!(hand.lost().contains("hangs for 2 s"), "{}", hand.lost());
}

/// While a loss is settled nobody is due, but who is heard and does not answer is lost in the end.
#[test]
fn one_that_owes_an_answer_is_lost_in_the_end() {
    let losses = Losses { step_ms: stall_flag("2000").expect("a clock"), ..Losses::default() };
    let mut hand = Hand::running(losses);
    hand.ends(WORLD, 0, 3);
    hand.ends(SMDFM, 0, 3);
    hand.token(SMDFM, hand.incs[SMDFM], false);
    hand.pass_with(1_500 * MS, &[WORLD]);
    assert!(!hand.lost().contains(WORLD), "{}", hand.lost());
    hand.pass_with(2_000 * MS, &[WORLD]);
    assert!(hand.lost().contains("it does not answer"), "{}", hand.lost());
}

#[test]
fn a_view_is_closed_when_all_hold_what_the_best_of_them_held() {
    let survivors = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
    let mut views = Views::default();
    views.reset(1);
    let seal = views.lose(1, "a", 5, false, &survivors(&["b", "c", "d"]));
    assert_eq!(seal, Order::Seal { run: 1, view: 1, lost: vec![("a".into(), 5)] });
    views.sealed("b", 1, vec![("a".into(), Some(4))]);
    assert_eq!(views.next_order(2, |_| None), None, "not all have answered");
    // Another one goes: both are sealed again, and what was said before is of no use.
    let seal = views.lose(3, "b", 6, false, &survivors(&["c", "d"]));
    let both = vec![("a".into(), 5), ("b".into(), 6)];
    assert_eq!(seal, Order::Seal { run: 1, view: 2, lost: both });
    views.sealed("c", 1, vec![("a".into(), Some(9))]);
    views.sealed("d", 2, vec![("a".into(), Some(7)), ("b".into(), None)]);
    assert_eq!(views.next_order(4, |_| None), None, "an answer to the view before");
    views.sealed("c", 2, vec![("a".into(), Some(6))]);
    let cuts = vec![("a".to_owned(), Some(7)), ("b".to_owned(), None)];
    let cut = views.next_order(5, |_| Some(99));
    assert_eq!(cut, Some(Order::Cut { run: 1, view: 2, cuts: cuts.clone() }));
    views.held("c", 1);
    views.held("d", 2);
    assert_eq!(views.next_order(6, |_| None), None, "one does not hold it yet");
    assert_eq!((views.cut("a"), views.awaited()), (None, (5, vec!["c".to_owned()])));
    views.held("c", 2);
    let view = Order::View { run: 1, view: 2, cuts, absent: Vec::new() };
    assert_eq!(views.next_order(7, |_| None), Some(view));
    assert_eq!((views.cut("a"), views.cut("b")), (Some(Some(7)), Some(None)));
    // A third one, later: what is settled stays.
    let seal = views.lose(8, "c", 7, true, &survivors(&["d"]));
    assert_eq!(seal, Order::Seal { run: 1, view: 3, lost: vec![("c".into(), 7)] });
}

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
    assert_eq!(inbox.due(S), None);
    inbox.told(S, 4);
    inbox.take(S, numbered(3, 3, 1));
    let (mut now, mut asked) = (S, Vec::new());
    while asked.len() < 8 {
        now += MS;
        if let Some((fetch, tries)) = inbox.due(now) {
            assert_eq!((fetch.from, fetch.to, tries), (1, 2, asked.len() as u32));
            asked.push(now);
        }
        assert!(now < 10 * S, "asked {asked:?}");
    }
    assert!(asked.windows(2).all(|w| w[1] - w[0] <= 501 * MS));
    inbox.take(now, numbered(3, 1, 1));
    inbox.take(now, numbered(3, 2, 1));
    assert_eq!(inbox.due(now + S).map(|(f, _)| f.from), Some(4), "the last of a burst");
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
        fetch: super::messages::Fetch { fed: 7, inc: 3, from: 1, to: u64::MAX },
    };
    assert_eq!(outbox.fetch("x", &all.fetch).gone_before, 1, "somebody lacks it");
    outbox.forget("slow");
    outbox.push(Heavy(1));
    assert_eq!(outbox.fetch("x", &all.fetch).gone_before, 3_001 - 1_024 + 1);
    outbox.confirm("slow", 0);
    for _ in 0..200 {
        outbox.push(Heavy(1 << 20));
    }
    let fetched = outbox.fetch("x", &all.fetch);
    assert!(fetched.gone_before > 3_001 + 130, "64 MiB are kept, whoever lacks more");
    assert_eq!(fetched.items.len(), 1, "one answer has half a megabyte, and one message at least");
}

/// Notices that a consumer was given, by the frame of their effect.
type Given = Arc<Mutex<Vec<Frame>>>;

/// A producer or consumer that does nothing.
struct Idle(bool, Given);

impl Federate for Idle {
    fn kind(&self) -> Kind {
        Kind::Smdfm
    }
    fn consumes(&self) -> bool {
        self.0
    }
    fn configure(&mut self, _: &RunConfig, _: &mut FrameOut) -> Result<(), String> {
        Ok(())
    }
    fn step(&mut self, _: Frame, inputs: &FrameInputs, out: &mut FrameOut) {
        self.1.lock().expect("one thread").extend(inputs.notices.iter().map(|(frame, _)| *frame));
        if !self.0 {
            out.pdus = (0..20_000_u32).map(|n| n.to_le_bytes().repeat(25).into()).collect();
        }
    }
    fn finish(&mut self, _: &mut FinalReport) {}
    fn aside(&mut self, what: Aside) -> Vec<Octets> {
        if self.0 { Vec::new() } else { vec![vec![what as u8].into()] }
    }
}

/// A configured member of federation 7, with inc 2, whose producer is the world of inc 1.
fn member(consumes: bool) -> Member {
    member_with(consumes, Given::default())
}

fn member_with(consumes: bool, given: Given) -> Member {
    let accepted = Accepted { fed: 7, inc: 2, orders: 0, enter: None, epoch: 0 };
    let name = if consumes { SMDFM } else { "traffic-generator" };
    let mut member = Member::new(Box::new(Idle(consumes, given)), name, &accepted, || 0);
    let config = RunConfig {
        run: 1,
        producers: vec![WORLD.into()],
        incs: vec![(WORLD.into(), 1)],
        ..RunConfig::default()
    };
    order(&mut member, 1, Order::Configure(config));
    member
}

fn order(member: &mut Member, seq: u64, body: Order) -> Vec<Act> {
    let mut effects = Vec::new();
    member.order(S, Numbered { fed: 7, inc: 0, seq, body }, &mut effects);
    effects
}

#[test]
fn orders_of_others_are_not_obeyed() {
    let mut member = member(false);
    let grant = Order::Grant { run: 1, upto: 1 };
    for (fed, inc, seq) in [(8, 0, 2), (7, 1, 2), (8, 0, 0), (7, 1, 0)] {
        member.order(S, Numbered { fed, inc, seq, body: grant.clone() }, &mut Vec::new());
        assert_eq!(member.executed(), 0, "federation {fed}, incarnation {inc}");
    }
    order(&mut member, 2, Order::Grant { run: 2, upto: 1 });
    assert_eq!(member.executed(), 0, "of another run");
    order(&mut member, 3, grant);
    assert_eq!(member.executed(), 1);
}

#[test]
fn a_beat_tells_of_orders_and_reports_that_were_lost() {
    let mut member = member(true);
    let beat = |fed, inc, last_seq| Beat { fed, inc, last_seq, ..Beat::default() };
    let asked = |member: &mut Member, now| {
        let mut effects = Vec::new();
        member.tick(now, &mut effects);
        let asked = effects.iter().filter_map(|effect| match effect {
            Act::Fetch { ask, .. } => Some(ask.of.clone()),
            _ => None,
        });
        asked.collect::<Vec<_>>()
    };
    member.hear_beat(S, CONDUCTOR, &beat(8, 0, 9));
    member.hear_beat(S, CONDUCTOR, &beat(7, 0, 1));
    assert!(asked(&mut member, 2 * S).is_empty(), "of another federation, and nothing is missing");
    member.hear_beat(2 * S, CONDUCTOR, &beat(7, 0, 2));
    assert_eq!(asked(&mut member, 3 * S), [CONDUCTOR]);
    member.hear_beat(3 * S, WORLD, &beat(7, 1, 1));
    assert_eq!(asked(&mut member, 3 * S + 10 * MS), [WORLD]);
    let mut known = member;
    let ready = Report::Ready { run: 1, at: None };
    let ready = Numbered { fed: 7, inc: 1, seq: 1, body: ready };
    known.report(4 * S, WORLD, ready, &mut Vec::new());
    known.hear_beat(4 * S, WORLD, &beat(7, 1, 1));
    assert!(!asked(&mut known, 5 * S).contains(&WORLD.to_owned()));
    known.hear_beat(6 * S, WORLD, &beat(7, 1, 2));
    assert!(asked(&mut known, 7 * S).contains(&WORLD.to_owned()), "its last report");
}

/// What a producer does not tell again, whoever else may hold it is asked for, in turn.
#[test]
fn others_are_asked_for_what_a_producer_does_not_tell_again() {
    let mut member = member(true);
    member.hear_beat(S, WORLD, &Beat { fed: 7, inc: 1, last_seq: 1, ..Beat::default() });
    let mut asked = Vec::new();
    for n in 0..100 {
        let mut effects = Vec::new();
        member.tick(S + n * 50 * MS, &mut effects);
        asked.extend(effects.into_iter().filter_map(|effect| match effect {
            Act::Fetch { holder, ask } if ask.of == WORLD => Some(holder),
            _ => None,
        }));
    }
    assert!(asked.len() > 4 && asked[..2] == [WORLD, WORLD], "{asked:?}");
    assert!(asked[2..].iter().any(|holder| holder != WORLD), "{asked:?}");
    assert!(asked[3..].iter().any(|holder| holder == WORLD), "and itself again: {asked:?}");
}

/// Who is ready before a run sends probes until it begins; who returns to one sends none, and may have nothing to send for long.
#[test]
fn a_producer_that_returns_is_not_missed_on_the_data_plane_at_once() {
    let stands = Standing { frame: Some(0), made: 0, state: Some(0) };
    for (at, told) in [(None, true), (Some(stands), false)] {
        let mut member = member(true);
        let (group, interface) = ("239.1.2.3:3000".to_owned(), "10.0.0.1".to_owned());
        member.hearing().on(super::hearing::Plane { group, interface, loss: 0.0 });
        let ready = Numbered { fed: 7, inc: 1, seq: 1, body: Report::Ready { run: 1, at } };
        member.report(S, WORLD, ready, &mut Vec::new());
        let said = (10..60).any(|n| !member.hearing().tick(n * 100 * MS).is_empty());
        assert_eq!(said, told, "{at:?}");
    }
}

#[test]
fn an_outcast_does_nothing_more_and_asks_to_join_again() {
    let mut member = member(false);
    order(&mut member, 2, Order::Grant { run: 1, upto: 1 });
    let seal = |inc| Order::Seal { run: 1, view: 1, lost: vec![("traffic-generator".into(), inc)] };
    let rejoins = |effects: &[Act]| effects.iter().any(|e| matches!(e, Act::Rejoin(_)));
    assert!(!rejoins(&order(&mut member, 3, seal(1))), "another incarnation of it");
    assert!(rejoins(&order(&mut member, 4, seal(2))));
    order(&mut member, 5, Order::Grant { run: 1, upto: 9 });
    assert_eq!(member.executed(), 1);
}

#[test]
fn what_the_conductor_forgot_is_not_skipped() {
    let mut member = member(false);
    let mut effects = Vec::new();
    let gone = super::messages::Fetched { of: CONDUCTOR.into(), items: Vec::new(), gone_before: 9 };
    member.fetched_orders(S, gone, &mut effects);
    assert!(effects.iter().any(|e| matches!(e, Act::Rejoin(_))));
}

/// Who comes into an old run is told by nobody what members said long ago whom it does not read: it is no reason to begin anew.
#[test]
fn of_those_whom_it_does_not_read_a_member_hears_what_they_say_now() {
    let mut member = member(true);
    let report = |seq| Numbered { fed: 7, inc: 9, seq, body: Report::Ready { run: 1, at: None } };
    let fetches = |member: &mut Member, now| {
        let mut effects = Vec::new();
        member.tick(now, &mut effects);
        effects.iter().any(|e| matches!(e, Act::Fetch { ask, .. } if ask.of == "control"))
    };
    // What is lost is asked for, and let go where nobody has it.
    member.report(2 * S, "control", report(5_009), &mut Vec::new());
    assert!(fetches(&mut member, 3 * S));
    let gone = |of: &str| super::messages::Fetched {
        of: of.into(),
        items: Vec::new(),
        gone_before: 5_009,
    };
    let rejoins = |effects: &[Act]| effects.iter().any(|e| matches!(e, Act::Rejoin(_)));
    let mut effects = Vec::new();
    member.fetched(3 * S, gone("control"), &mut effects);
    assert!(!rejoins(&effects));
    member.report(4 * S, "control", report(5_009), &mut Vec::new());
    assert!(!fetches(&mut member, 5 * S), "it has all that there is");
    // Of a producer nothing is skipped.
    let world = Numbered { inc: 1, ..report(1) };
    member.report(5 * S, WORLD, world, &mut Vec::new());
    member.fetched(6 * S, gone(WORLD), &mut effects);
    assert!(rejoins(&effects));
}

/// What is told aside while time stands is of no frame, and comes again before others would forget an entity.
#[test]
fn a_producer_tells_aside_that_time_stands_goes_on_and_ends() {
    let mut member = member(false);
    let aside = |effects: &[Act]| -> Vec<u8> {
        let sent = effects.iter().filter_map(|effect| match effect {
            Act::Send(pdus) if pdus.len() == 1 => Some(pdus[0][0]),
            _ => None,
        });
        sent.collect()
    };
    let stand = Order::Stand { run: 1 };
    order(&mut member, 2, Order::Grant { run: 1, upto: 1 });
    let sent = member.counters().sent;
    assert!(aside(&order(&mut member, 3, Order::Stand { run: 2 })).is_empty(), "of another run");
    assert_eq!(aside(&order(&mut member, 4, stand.clone())), [Aside::Stands as u8]);
    let mut told = Vec::new();
    for tick in 0..120 {
        let mut effects = Vec::new();
        assert!(member.deadline().is_some_and(|due| due <= S + tick * 100 * MS + 4 * S));
        member.tick(S + tick * 100 * MS, &mut effects);
        told.extend(aside(&effects));
    }
    assert_eq!(told, [Aside::Stands as u8; 2], "every four seconds in twelve");
    let grant = |upto| Order::Grant { run: 1, upto };
    assert_eq!(aside(&order(&mut member, 5, grant(1))), [Aside::GoesOn as u8]);
    assert!(aside(&order(&mut member, 6, grant(1))).is_empty(), "once");
    order(&mut member, 7, stand);
    let over = order(&mut member, 8, Order::Finish { run: 1, frame: 1 });
    assert_eq!(aside(&over), [Aside::Over as u8]);
    let mut effects = Vec::new();
    member.tick(100 * S, &mut effects);
    assert!(aside(&effects).is_empty(), "over is over");
    assert_eq!(member.counters().sent, sent, "nothing of it counts");
}

/// Frozen before the first grant: frame 0 is still to come, and nobody has been told of anybody.
#[test]
fn a_run_frozen_before_its_first_grant_tells_nobody_that_time_stands() {
    let mut member = member(false);
    let sends = |effects: &[Act]| effects.iter().any(|effect| matches!(effect, Act::Send(_)));
    assert!(!sends(&order(&mut member, 2, Order::Stand { run: 1 })));
    let mut effects = Vec::new();
    (0..60).for_each(|tick| member.tick(S + tick * 100 * MS, &mut effects));
    assert!(!sends(&effects), "nor later");
    let goes_on = order(&mut member, 3, Order::Grant { run: 1, upto: 0 });
    let aside = |effect: &Act| matches!(effect, Act::Send(p) if p.len() == 1 && p[0][0] == Aside::GoesOn as u8);
    assert!(!goes_on.iter().any(aside), "nothing stood");
    assert!(sends(&order(&mut member, 4, Order::Stand { run: 1 })), "after frame 0 it does");
}

/// Frame ends and PDUs that nobody needs fill no memory, and what waits is used.
#[test]
fn what_waits_at_a_member_is_bounded() {
    let mut member = member(true);
    let pdus = (0..450_000_u32).map(|n| n.to_le_bytes().to_vec().into());
    member.pdus(S, pdus, &mut Vec::new());
    let ends = |seq: u64, hashes: Vec<u64>| {
        let ends = FrameEnds { run: 1, pdus: vec![(0, hashes)], ..FrameEnds::default() };
        Numbered { fed: 7, inc: 1, seq, body: Report::Ends(ends) }
    };
    let hash = |n: u32| super::digest::pdu_hash(&n.to_le_bytes());
    member.report(S, WORLD, ends(1, (0..450_000).map(hash).collect()), &mut Vec::new());
    assert_eq!(member.counters().received, 200_000, "the latest");
    // A successor that nobody admits.
    for seq in 1..=2_000 {
        let body = Report::Ends(FrameEnds { run: 1, first: seq, last: seq, ..Default::default() });
        member.report(S, WORLD, Numbered { fed: 7, inc: 5, seq, body }, &mut Vec::new());
    }
    order(&mut member, 2, Order::Grant { run: 1, upto: 5_000 });
    order(&mut member, 3, Order::Admit { run: 1, name: WORLD.into(), inc: 5, from: 1 });
    assert_eq!(member.waits_for().len(), 1);
    assert!(member.waits_for()[0].contains("ended Some(256)"), "{:?}", member.waits_for());
}

/// A producer that makes two equal PDUs in a frame has made two, also where both come by repair.
#[test]
fn a_pdu_that_is_made_twice_is_repaired_twice() {
    let mut consumer = member(true);
    let hash = super::digest::pdu_hash(&[5]);
    let body =
        Report::Ends(FrameEnds { run: 1, pdus: vec![(0, vec![hash, hash])], ..Default::default() });
    let report = Numbered { fed: 7, inc: 1, seq: 1, body };
    consumer.report(S, WORLD, report, &mut Vec::new());
    for (pdus, repaired) in [(1, 1), (2, 2)] {
        let pdus = vec![(0, vec![5]); pdus];
        consumer.repaired(S, Repaired { run: 1, pdus }, &mut Vec::new());
        assert_eq!(consumer.counters().repaired, repaired);
    }
}

#[test]
fn a_long_frame_is_repaired_page_by_page() {
    let (mut producer, mut consumer) = (member(false), member(true));
    let effects = order(&mut producer, 2, Order::Grant { run: 1, upto: 1 });
    let mut told = 0;
    for effect in effects {
        let Act::Report(mut report) = effect else { continue };
        told += 1;
        (report.inc, report.seq) = (1, told);
        consumer.report(S, WORLD, report, &mut Vec::new());
    }
    let (mut now, mut questions) = (S, 0);
    let mut lacking = 20_000;
    while lacking > 0 {
        now += 10 * MS;
        let mut effects = Vec::new();
        consumer.tick(now, &mut effects);
        for effect in effects {
            let Act::Repair { repair, .. } = effect else { continue };
            let Repair { wanted, .. } = &repair;
            assert!(wanted.iter().map(|(_, h)| h.len()).sum::<usize>() <= 4_096);
            let repaired: Repaired = producer.repair(&repair);
            let octets: usize = repaired.pdus.iter().map(|(_, o)| o.len()).sum();
            assert!(octets <= 512 << 10, "{octets} octets in one answer");
            lacking -= repaired.pdus.len();
            questions += 1;
            consumer.repaired(now, repaired, &mut Vec::new());
        }
        assert!(now < 10 * S, "{lacking} of 20 000 are not repaired after {questions} questions");
    }
    assert_eq!(consumer.counters().repaired, 20_000);
    assert!(now < 2 * S, "each page is asked for when the one before is here: {questions}");
}

/// What the world of incarnation `inc` tells: frames `first` to `last`, in the last one a PDU and a notice each.
fn ends_of(inc: u64, seq: u64, first: Frame, last: Frame, pdu: Option<u8>) -> Numbered<Report> {
    let from = std::net::SocketAddr::from(([127, 0, 0, 1], 9));
    let notice = Notice::Outsider { received_ns: 0, from, octets: vec![1] };
    let hashes = pdu.map(|octet| (last, vec![super::digest::pdu_hash(&[octet])]));
    let body = Report::Ends(FrameEnds {
        run: 1,
        first,
        last,
        pdus: hashes.into_iter().collect(),
        notices: vec![(last, last, notice)],
        ..FrameEnds::default()
    });
    Numbered { fed: 7, inc, seq, body }
}

fn reports(effects: &[Act]) -> Vec<Report> {
    let report = |effect: &Act| match effect {
        Act::Report(report) => Some(report.body.clone()),
        _ => None,
    };
    effects.iter().filter_map(report).collect()
}

/// A consumer seals, holds and goes on: never more is used than it said, and what came after the cut never.
#[test]
fn a_consumer_uses_what_is_settled_and_nothing_else() {
    let given = Given::default();
    let mut consumer = member_with(true, Arc::clone(&given));
    consumer.report(S, WORLD, ends_of(1, 1, 0, 0, None), &mut Vec::new());
    consumer.report(S, WORLD, ends_of(1, 2, 1, 1, None), &mut Vec::new());
    let lost = || vec![(WORLD.to_owned(), 1)];
    let sealed = |view, holds: Option<Frame>| Report::Sealed {
        run: 1,
        view,
        holds: vec![(WORLD.to_owned(), holds)],
    };
    // It has frames 0 and 1 and was granted none: what nobody may use yet, nobody has used.
    let told = order(&mut consumer, 2, Order::Seal { run: 1, view: 1, lost: lost() });
    assert_eq!(reports(&told), [sealed(1, Some(0))]);
    // The frames that it did not tell of stay unused, though time is granted and their PDUs come.
    consumer.report(S, WORLD, ends_of(1, 3, 2, 2, Some(2)), &mut Vec::new());
    order(&mut consumer, 3, Order::Grant { run: 1, upto: 9 });
    assert_eq!(consumer.executed(), 0);
    // Somebody else had frame 2: it is held when its PDU is here.
    let cuts = || vec![(WORLD.to_owned(), Some(2))];
    let told = order(&mut consumer, 4, Order::Cut { run: 1, view: 1, cuts: cuts() });
    assert_eq!(reports(&told), [], "a PDU is missing");
    let mut told = Vec::new();
    consumer.pdus(S, [vec![2_u8].into()], &mut told);
    assert_eq!(reports(&told), [Report::Held { run: 1, view: 1 }]);
    assert_eq!(consumer.executed(), 0, "nobody acts before the view");
    order(&mut consumer, 5, Order::View { run: 1, view: 1, cuts: cuts(), absent: Vec::new() });
    assert_eq!(consumer.executed(), 2);
    // The successor begins where it is admitted and nowhere else.
    consumer.report(S, WORLD, ends_of(5, 1, 4, 4, None), &mut Vec::new());
    let admit = |from| Order::Admit { run: 1, name: WORLD.into(), inc: 5, from };
    order(&mut consumer, 6, admit(4));
    assert_eq!(consumer.executed(), 2, "frame 3 would be left out");
    order(&mut consumer, 7, admit(3));
    assert_eq!(consumer.executed(), 2, "its report has a gap");
    consumer.report(S, WORLD, ends_of(5, 2, 3, 3, None), &mut Vec::new());
    assert_eq!(consumer.executed(), 3);
    assert_eq!(*given.lock().expect("one thread"), [0, 1, 2, 3], "each notice once");
}

/// Notices of frames after the cut are forgotten with them.
#[test]
fn what_was_told_beyond_the_cut_counts_once_it_is_told_again() {
    let given = Given::default();
    let mut consumer = member_with(true, Arc::clone(&given));
    for (seq, frame) in (1..).zip(0..4) {
        consumer.report(S, WORLD, ends_of(1, seq, frame, frame, None), &mut Vec::new());
    }
    order(&mut consumer, 2, Order::Seal { run: 1, view: 1, lost: vec![(WORLD.into(), 1)] });
    let cuts = vec![(WORLD.to_owned(), Some(1))];
    order(&mut consumer, 3, Order::Cut { run: 1, view: 1, cuts: cuts.clone() });
    order(&mut consumer, 4, Order::View { run: 1, view: 1, cuts, absent: Vec::new() });
    order(&mut consumer, 5, Order::Admit { run: 1, name: WORLD.into(), inc: 5, from: 2 });
    for (seq, frame) in (1..).zip(2..4) {
        consumer.report(S, WORLD, ends_of(5, seq, frame, frame, None), &mut Vec::new());
    }
    order(&mut consumer, 6, Order::Grant { run: 1, upto: 3 });
    assert_eq!(consumer.executed(), 3);
    assert_eq!(*given.lock().expect("one thread"), [0, 1, 2, 3]);
}

#[test]
fn parts_of_a_frame_without_end_are_not_kept() {
    let mut joined = Joined::default();
    let part = |goes_on| FrameEnds {
        run: 1,
        pdus: vec![(0, vec![7; 16 << 10])],
        goes_on,
        ..FrameEnds::default()
    };
    for seq in 1..600 {
        assert_eq!(joined.take(seq, part(true)), None);
    }
    let (first, whole) = joined.take(600, part(false)).expect("the last");
    let hashes = whole.pdus[0].1.len();
    assert!(first > 1 && hashes < 600 << 14, "{hashes} hashes from part {first} on");
}
