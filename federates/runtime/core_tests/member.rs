//! The member by hand: orders, beats, repairs, and what is settled.

use super::{MS, S, SMDFM, WORLD};
use crate::runtime::federate::{Aside, Federate, FrameInputs, FrameOut, Octets};
use crate::runtime::member::{CONDUCTOR, Effect as Act, Member};
use crate::runtime::messages::{
    Accepted, Beat, Fetched, FinalReport, Frame, FrameEnds, Joined, Kind, Notice, Numbered, Order,
    Repair, Repaired, Report, RunConfig, Standing, Used,
};
use std::sync::{Arc, Mutex};

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

/// A producer to which there is no connection any more is not heard itself: the conductor says how far that has told.
#[test]
fn the_conductors_beat_tells_of_the_reports_of_a_producer_that_is_not_heard() {
    let mut member = member(true);
    let seen = |of: &str, inc, seq| Beat {
        fed: 7,
        last_seq: 1,
        seen: vec![(of.to_owned(), inc, seq)],
        ..Beat::default()
    };
    let asked = |member: &mut Member, now| {
        let mut effects = Vec::new();
        (0..5).for_each(|n| member.tick(now + n * 100 * MS, &mut effects));
        let asked = effects.into_iter().filter_map(|effect| match effect {
            Act::Fetch { holder, ask } if ask.of == WORLD => Some((holder, ask.fetch.inc)),
            _ => None,
        });
        asked.collect::<Vec<_>>()
    };
    member.hear_beat(S, CONDUCTOR, &seen("a spectator", 1, 4));
    member.hear_beat(S, CONDUCTOR, &seen(WORLD, 1, 0));
    assert!(asked(&mut member, 2 * S).is_empty(), "nothing of it is missing");
    member.hear_beat(3 * S, CONDUCTOR, &seen(WORLD, 1, 2));
    let holders = asked(&mut member, 4 * S);
    assert!(holders.contains(&(CONDUCTOR.to_owned(), 1)), "{holders:?}");
    // Another incarnation has taken its place.
    member.hear_beat(5 * S, CONDUCTOR, &seen(WORLD, 6, 1));
    let holders = asked(&mut member, 6 * S);
    assert!(holders.contains(&(CONDUCTOR.to_owned(), 6)), "{holders:?}");
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
    assert!(asked.len() > 8 && asked[..2] == [WORLD, CONDUCTOR], "{asked:?}");
    assert!(asked[3..].iter().any(|holder| holder == WORLD), "and itself again: {asked:?}");
}

/// Once it did not answer others are asked first, until a word of it comes by itself; what others tell again of it is none.
#[test]
fn a_producer_that_did_not_answer_is_asked_first_again_once_it_is_heard() {
    let mut member = member(true);
    let beat = |last_seq| Beat { fed: 7, inc: 1, last_seq, ..Beat::default() };
    let first_asked = |member: &mut Member, now: u64| {
        (0..6).find_map(|n| {
            let mut effects = Vec::new();
            member.tick(now + n * MS, &mut effects);
            effects.into_iter().find_map(|effect| match effect {
                Act::Fetch { holder, ask } if ask.of == WORLD => Some(holder),
                _ => None,
            })
        })
    };
    let told = |seq| {
        let items = vec![ends_of(1, seq, seq - 1, seq - 1, None)];
        Fetched { of: WORLD.into(), items, gone_before: 0 }
    };
    let mut now = S;
    let seen =
        |seq| Beat { fed: 7, last_seq: 1, seen: vec![(WORLD.into(), 1, seq)], ..Beat::default() };
    member.hear_beat(now, CONDUCTOR, &seen(1));
    assert_eq!(first_asked(&mut member, now).as_deref(), Some(WORLD));
    assert_eq!(first_asked(&mut member, now + 100 * MS).as_deref(), Some(CONDUCTOR));
    for seq in 1..=14 {
        assert_eq!(member.unheard().count(), usize::from(seq > 11), "told by others alone: {seq}");
        now = S + seq * 100 * MS;
        member.fetched(now, CONDUCTOR, told(seq), &mut Vec::new());
        member.hear_beat(now, CONDUCTOR, &seen(seq + 1));
        assert_eq!(first_asked(&mut member, now).as_deref(), Some(CONDUCTOR), "{seq}");
    }
    let said: Vec<_> = member.unheard().map(str::to_owned).collect();
    assert!(
        said.len() == 1 && said[0].contains(WORLD) && said[0].contains("by the station"),
        "{said:?}"
    );
    member.fetched(now, CONDUCTOR, told(15), &mut Vec::new());
    member.hear_beat(now, WORLD, &beat(16));
    assert_eq!(member.unheard().count(), 0, "heard again");
    assert_eq!(first_asked(&mut member, now).as_deref(), Some(WORLD));
    // An answer of its own is a word of it, too.
    for (by, then) in [(WORLD, WORLD), (CONDUCTOR, CONDUCTOR)] {
        now += 100 * MS;
        assert_eq!(first_asked(&mut member, now).as_deref(), Some(CONDUCTOR));
        let seq = if by == WORLD { 16 } else { 17 };
        member.fetched(now, by, told(seq), &mut Vec::new());
        member.hear_beat(now, CONDUCTOR, &seen(seq + 1));
        assert_eq!(first_asked(&mut member, now).as_deref(), Some(then), "answered by {by}");
    }
}

/// The only consumer: whoever else there is to ask for PDUs is the station.
#[test]
fn pdus_of_a_producer_that_does_not_answer_are_asked_for_by_way_of_the_station() {
    let mut member = member(true);
    member.report(S, WORLD, ends_of(1, 1, 0, 0, Some(5)), &mut Vec::new());
    let mut asked = Vec::new();
    for n in 0..30 {
        let mut effects = Vec::new();
        member.tick(S + n * 100 * MS, &mut effects);
        asked.extend(effects.into_iter().filter_map(|effect| match effect {
            Act::Repair { holder, of, .. } => Some((holder, of)),
            _ => None,
        }));
    }
    assert!(asked.iter().all(|(_, of)| of == WORLD), "{asked:?}");
    let [first, second, ..] = &asked[..] else { panic!("asked twice: {asked:?}") };
    assert_eq!((first.0.as_str(), second.0.as_str()), (WORLD, CONDUCTOR));
}

/// Who is ready before a run sends probes until it begins; who returns to one sends none, and may have nothing to send for long.
#[test]
fn a_producer_that_returns_is_not_missed_on_the_data_plane_at_once() {
    let stands = Standing { frame: Some(0), made: 0, state: Some(0) };
    for (at, told) in [(None, true), (Some(stands), false)] {
        let mut member = member(true);
        let (group, interface) = ("239.1.2.3:3000".to_owned(), "10.0.0.1".to_owned());
        member.hearing().on(crate::runtime::hearing::Plane { group, interface, loss: 0.0 });
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
    let gone = crate::runtime::messages::Fetched {
        of: CONDUCTOR.into(),
        items: Vec::new(),
        gone_before: 9,
    };
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
    let gone = |of: &str| crate::runtime::messages::Fetched {
        of: of.into(),
        items: Vec::new(),
        gone_before: 5_009,
    };
    let rejoins = |effects: &[Act]| effects.iter().any(|e| matches!(e, Act::Rejoin(_)));
    let mut effects = Vec::new();
    member.fetched(3 * S, CONDUCTOR, gone("control"), &mut effects);
    assert!(!rejoins(&effects));
    member.report(4 * S, "control", report(5_009), &mut Vec::new());
    assert!(!fetches(&mut member, 5 * S), "it has all that there is");
    // Of a producer nothing is skipped.
    let world = Numbered { inc: 1, ..report(1) };
    member.report(5 * S, WORLD, world, &mut Vec::new());
    member.fetched(6 * S, CONDUCTOR, gone(WORLD), &mut effects);
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
    let hash = |n: u32| crate::runtime::digest::pdu_hash(&n.to_le_bytes());
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
    let hash = crate::runtime::digest::pdu_hash(&[5]);
    let body =
        Report::Ends(FrameEnds { run: 1, pdus: vec![(0, vec![hash, hash])], ..Default::default() });
    let report = Numbered { fed: 7, inc: 1, seq: 1, body };
    consumer.report(S, WORLD, report, &mut Vec::new());
    for (pdus, repaired) in [(1, 1), (2, 2)] {
        let pdus = vec![(0, vec![5]); pdus];
        consumer.repaired(S, WORLD, Repaired { run: 1, pdus }, &mut Vec::new());
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
            consumer.repaired(now, WORLD, repaired, &mut Vec::new());
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
    let hashes = pdu.map(|octet| (last, vec![crate::runtime::digest::pdu_hash(&[octet])]));
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

/// Each step says what it used of whom, by the PDUs that were handed over, not by those that were named.
#[test]
fn a_consumer_tells_what_its_steps_used() {
    let mut consumer = member(true);
    let hash = |n: u8| crate::runtime::digest::pdu_hash(&[n]);
    let mut used = Vec::new();
    let mut take = |effects: Vec<Act>| {
        for effect in effects {
            if let Act::Report(Numbered { body: Report::Ends(ends), .. }) = effect {
                used.extend(ends.used);
            }
        }
    };
    take(order(&mut consumer, 2, Order::Grant { run: 1, upto: 3 }));
    let frames = [vec![1], vec![2, 2], vec![], vec![3, 4]];
    for (frame, pdus) in (0..).zip(&frames) {
        let mut hashes: Vec<u64> = pdus.iter().map(|n| hash(*n)).collect();
        hashes.sort_unstable();
        let pdus_named = vec![(frame, hashes)];
        let ends =
            FrameEnds { run: 1, first: frame, last: frame, pdus: pdus_named, ..Default::default() };
        let report = Numbered { fed: 7, inc: 1, seq: frame + 1, body: Report::Ends(ends) };
        let mut effects = Vec::new();
        consumer.report(S, WORLD, report, &mut effects);
        let octets = pdus.iter().map(|n| (frame, vec![*n])).collect();
        consumer.repaired(S, WORLD, Repaired { run: 1, pdus: octets }, &mut effects);
        take(effects);
    }
    let of = |first, last, pdus: &[u8]| {
        let sum = pdus.iter().fold(0_u64, |sum, n| sum.wrapping_add(hash(*n)));
        Used { of: WORLD.into(), first, last, sum }
    };
    // Frame 0 has no step of its own.
    assert_eq!(used, [of(0, 1, &[1, 2, 2]), of(2, 2, &[]), of(3, 3, &[3, 4])]);
}
