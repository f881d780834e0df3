//! The conductor by hand: what it takes from whom, and when somebody is lost.

use super::{MS, S, SMDFM, WORLD};
use crate::runtime::conductor::{ClosedRun, Conductor, ConductorConfig, Effect};
use crate::runtime::life_cycle::Phase;
use crate::runtime::messages::{
    Accepted, Beat, Command, Frame, FrameEnds, Hello, Kind, Numbered, Order, Report, Standing, Was,
    Welcome,
};
use crate::runtime::views::Views;
use scenarios::losses::{Losses, stall_flag};
use std::collections::BTreeMap;

mod commands;
mod differences;
mod ends;
mod returns;
mod steps;

/// A conductor and what its two members say.
struct Hand {
    conductor: Conductor,
    now: u64,
    incs: BTreeMap<&'static str, u64>,
    seqs: BTreeMap<&'static str, u64>,
    orders: Vec<Order>,
    reached: Vec<Phase>,
    closed: Vec<ClosedRun>,
    /// What operators were answered.
    answers: Vec<(bool, String)>,
    /// What was said of the run last.
    words: String,
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

fn config(losses: Losses, window: Frame, through_router: bool) -> ConductorConfig {
    ConductorConfig {
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
    }
}

impl Hand {
    /// Both have joined and are ready, and the run has been granted frame 3.
    fn running(losses: Losses) -> Self {
        Self::with(losses, 8, false)
    }

    fn with(losses: Losses, window: Frame, through_router: bool) -> Self {
        let conductor = Conductor::new(config(losses, window, through_router));
        let (incs, seqs) = (BTreeMap::new(), BTreeMap::new());
        let (orders, reached, closed) = (Vec::new(), Vec::new(), Vec::new());
        let (answers, words) = (Vec::new(), String::new());
        let mut hand =
            Self { conductor, now: S, incs, seqs, orders, reached, closed, answers, words };
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
                Effect::Closed(run) => self.closed.push(*run),
                Effect::Answer(_, answer) => self.answers.push((answer.ok, answer.text)),
                Effect::State(state) => self.words = state.reasons.join("; "),
                _ => {}
            }
        }
    }

    fn command(&mut self, command: Command) {
        let mut effects = Vec::new();
        self.conductor.command(self.now, command, 1, &mut effects);
        self.take(effects);
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

    /// Answers the latest seal for a member that holds so much of the others.
    fn answers_seal(&mut self, name: &'static str, holds: Vec<(String, Option<Frame>)>) {
        let view = self.orders.iter().rev().find_map(|order| match order {
            Order::Seal { view, .. } => Some(*view),
            _ => None,
        });
        let view = view.expect("a seal");
        self.say(name, Report::Sealed { run: 1, view, holds });
        self.say(name, Report::Held { run: 1, view });
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
        self.answers_seal(WORLD, Vec::new());
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

/// While a loss is settled others may still need what the lost one told; then its beat says nothing of it, so that nobody who returns
/// asks for the words of an incarnation that is gone.
#[test]
fn the_conductors_beat_names_nobody_whose_loss_is_settled() {
    let mut hand = Hand::running(Losses::default());
    let names = |hand: &Hand| -> Vec<String> {
        hand.conductor.own_beat().seen.into_iter().map(|(name, ..)| name).collect()
    };
    let all = names(&hand);
    assert!(all.contains(&SMDFM.to_owned()) && all.contains(&WORLD.to_owned()), "{all:?}");
    hand.lose_smdfm();
    let left = names(&hand);
    assert!(!left.contains(&SMDFM.to_owned()) && left.contains(&WORLD.to_owned()), "{left:?}");
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
