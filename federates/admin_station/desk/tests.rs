//! PDUs made by hand, octet by octet, at the desk.

use super::*;
use crate::runtime::messages::MemberState;
use pdu::DisTime;
use pdu::enumerations::AirAppearance;
use std::collections::BTreeSet;

const STEP_NS: i64 = 50_000_000;
const SECOND: u64 = 1_000_000_000;

fn octets(hex: &str) -> Vec<u8> {
    let digits: Vec<u8> = hex.bytes().filter(u8::is_ascii_hexdigit).collect();
    let octet = |two: &[u8]| u8::from_str_radix(std::str::from_utf8(two).expect("digits"), 16);
    digits.chunks(2).map(|two| octet(two).expect("hexadecimal")).collect()
}

fn state(phase: Phase, frame: Frame) -> RunState {
    let member = MemberState { name: "visitors".into(), alive: true, ..MemberState::default() };
    RunState {
        phase,
        frame,
        run: 1,
        step_ns: STEP_NS,
        rate: 1.0,
        members: vec![member],
        ..RunState::default()
    }
}

/// The desk of station 1:65000:0, in a scene that has an entity 1:3:5, and what it has answered.
fn desk(phase: Phase) -> (Desk, Answered) {
    let envelope: Enveloper =
        Arc::new(|frame| Envelope::new(1, DisTime::absolute(frame * STEP_NS as u64)));
    let created = Created::new(1, BTreeSet::from([(3, 5)]));
    let mut desk = Desk::new(EntityId::new(1, 65_000, 0), envelope, created);
    assert!(desk.stated(0, &state(phase, 0)).expect("encodes").is_empty());
    (desk, Answered::default())
}

/// What the desk answers to a datagram; none if that is for somebody else.
fn ask(desk: &mut Desk, answered: &Answered, hex: &str) -> Option<Out> {
    let octets = octets(hex);
    let received = pdu::pdus(&octets).next().expect("a PDU").expect("a sound one");
    let out = desk.consider(0, received.body(), answered)?;
    Some(out.expect("encodes"))
}

/// Body of the only answer, as hexadecimal digits.
fn body(out: Option<Out>) -> String {
    let out = out.expect("it is for the desk");
    assert_eq!(out.len(), 1, "{out:02x?}");
    out[0][12..].iter().map(|octet| format!("{octet:02x}")).collect()
}

fn text(octets: &[u8]) -> String {
    let received = pdu::pdus(octets).next().expect("a PDU").expect("a sound one");
    let Body::EventReport(report) = received.body() else { panic!("{received:?}") };
    assert_eq!(report.receiving_id, EntityId::ALL);
    let datum = report.variable_datums.iter().next().expect("a text");
    String::from_utf8(datum.value.to_vec()).expect("a text")
}

// Create Entity (11) and its -R form (51), Remove Entity (12) and (52): from 77:1:0, about 1:3:3000.
const CREATE: &str = "07010b05 00000000 001c0000 004d00010000 000100030bb8 00000007";
const CREATE_R: &str = "0701330a 00000000 00200000 004d00010000 000100030bb9 00000000 00000008";
const REMOVE: &str = "07010c05 00000000 001c0000 004d00010000 000100030bb8 00000009";
// Set Data (19): location (240142) 4279000, 640000, 4672000 m; velocity (240143) 10, 0, 0 m/s; marking (240035) "TUG 1";
// country (240005) 225; a datum that nobody knows.
const SET: &str = "07011305 00000000 00880000 004d00010000 000100030bb8 0000000a 00000000 00000002 00000003 \
    0003a985000000e1 0000000100000001 \
    0003aa0e000000c0 415052b600000000 4123880000000000 4151d28000000000 \
    0003aa0f00000060 41200000 00000000 00000000 00000000 \
    0003a9a300000058 5455472031000000 0000000000000000";

#[test]
fn an_entity_is_created_placed_moved_frozen_asked_and_removed() {
    let (mut desk, answered) = desk(Phase::Running);
    let able = "0001fde80000004d00010000000100010000000";
    assert_eq!(body(ask(&mut desk, &answered, CREATE)), format!("{able}7"));
    assert_eq!(body(ask(&mut desk, &answered, CREATE)), format!("{able}7"), "the same again");
    let other = CREATE.replace("00000007", "00000001");
    let unable = "0001fde80000004d000100000001000200000001";
    assert_eq!(body(ask(&mut desk, &answered, &other)), unable, "it is there already");
    let other = other.replace("00030bb8", "00030005").replace("00000001", "00000002");
    let words = body(ask(&mut desk, &answered, &other));
    assert!(words.ends_with("0001000200000002"), "an entity of the scene: {words}");
    for (about, request) in [("0001fde80001", "3"), ("000100030000", "4"), ("00010003ffff", "5")] {
        let hex =
            CREATE.replace("000100030bb8", about).replace("00000007", &format!("0000000{request}"));
        let answer = ask(&mut desk, &answered, &hex);
        assert!(answer.is_none_or(|out| out[0][26..28] == [0, 2]), "{about}");
    }
    let elsewhere = CREATE.replace("000100030bb8", "000200030bb8");
    assert!(ask(&mut desk, &answered, &elsewhere).is_none(), "another site's to create");
    assert!(desk.due(0).expect("encodes").is_empty(), "pending: nothing is told of it");

    let out = ask(&mut desk, &answered, SET).expect("it is for the desk");
    let received = pdu::pdus(&out[0]).next().expect("one").expect("sound");
    let Body::Data(data) = received.body() else { panic!("{received:?}") };
    assert_eq!(
        (data.request_id, data.fixed_datums.len()),
        (10, 1),
        "the unknown one is not echoed"
    );
    let ids: Vec<u32> = data.variable_datums.iter().map(|datum| datum.id.0).collect();
    assert_eq!(ids, [240_142, 240_143, 240_035, 0]);
    let told = |desk: &mut Desk, at_s: u64| {
        let out = desk.due(at_s * SECOND).expect("encodes");
        assert_eq!(out.len(), 1);
        let received = pdu::pdus(&out[0]).next().expect("one").expect("sound");
        let Body::EntityState(state) = received.body() else { panic!("{received:?}") };
        state.clone().into_owned()
    };
    let state_pdu = told(&mut desk, 0);
    assert_eq!(state_pdu.entity_id, EntityId::new(1, 3, 3000));
    assert_eq!(
        (state_pdu.marking.text().as_str(), state_pdu.entity_type.country.0),
        ("TUG 1", 225)
    );
    assert_eq!(state_pdu.location.x_m, 4_279_000.0);
    assert!(desk.due(3 * SECOND).expect("encodes").is_empty(), "told of every four seconds");
    // Two seconds of simulated time later; a repeated Set Data does not put it back.
    desk.stated(0, &state(Phase::Running, 40)).expect("encodes");
    assert_eq!(ask(&mut desk, &answered, SET).expect("the same").first(), out.first());
    assert_eq!(told(&mut desk, 4).location.x_m, 4_279_020.0);

    // Stop/Freeze (14) to it alone, request 11; it stands and says so.
    let stop = "07010e05 00000000 00280000 004d00010000 000100030bb8 00000000 00000000 01 00 0000 0000000b";
    assert_eq!(body(ask(&mut desk, &answered, stop)), "0001fde80000004d00010000000400010000000b");
    desk.stated(0, &state(Phase::Running, 80)).expect("encodes");
    let frozen = told(&mut desk, 5);
    assert!(AirAppearance(frozen.appearance).frozen() && frozen.location.x_m == 4_279_020.0);
    assert_eq!(frozen.linear_velocity_mps.x, 0.0);
    let own = stop.replace("00030bb8", "00030005").replace("0000000b", "0000000c");
    assert!(
        body(ask(&mut desk, &answered, &own)).ends_with("000400020000000c"),
        "not of the scene"
    );
    // Start/Resume (13) to it, request 13.
    let start = "07010d05 00000000 002c0000 004d00010000 000100030bb8 0000000000000000 0000000000000000 0000000d";
    assert!(body(ask(&mut desk, &answered, start)).ends_with("000300010000000d"));
    desk.stated(0, &state(Phase::Running, 100)).expect("encodes");
    assert_eq!(told(&mut desk, 6).location.x_m, 4_279_030.0);

    // Data Query (18) for its location.
    let query =
        "07011205 00000000 00280000 004d00010000 000100030bb8 0000000e 00000000 00000000 00000000";
    let out = ask(&mut desk, &answered, query).expect("it is for the desk");
    let received = pdu::pdus(&out[0]).next().expect("one").expect("sound");
    let Body::Data(data) = received.body() else { panic!("{received:?}") };
    let place = data.variable_datums.iter().next().expect("a location");
    assert_eq!(place.id, DatumId::ENTITY_LOCATION);
    assert_eq!(place.value[..8], 4_279_030.0_f64.to_be_bytes());

    let out = ask(&mut desk, &answered, REMOVE).expect("it is for the desk");
    let received = pdu::pdus(&out[0]).next().expect("one").expect("sound");
    let Body::EntityState(last) = received.body() else { panic!("{received:?}") };
    assert!(AirAppearance(last.appearance).deactivated());
    assert_eq!(out[1][12..], octets("0001fde80000 004d00010000 0002 0001 00000009")[..]);
    assert!(
        body(ask(&mut desk, &answered, REMOVE)).ends_with("0002000100000009"),
        "the same again"
    );
    assert!(desk.due(60 * SECOND).expect("encodes").is_empty());
}

#[test]
fn reliable_forms_are_acknowledged_where_that_is_wanted() {
    let (mut desk, answered) = desk(Phase::Running);
    let out = ask(&mut desk, &answered, CREATE_R).expect("it is for the desk");
    let want = "0701370a";
    assert_eq!(out[0][..4], octets(want)[..], "an Acknowledge-R (55)");
    assert_eq!(out[0][12..], octets("0001fde80000 004d00010000 0001 0001 00000008")[..]);
    let silent = CREATE_R.replace("0bb9 00000000", "0bba 01000000").replace("00000008", "00000006");
    assert_eq!(ask(&mut desk, &answered, &silent), Some(Vec::new()), "unacknowledged");
    assert!(desk.created.has(EntityId::new(1, 3, 0xbba)));
}

#[test]
fn nothing_is_created_where_nobody_would_let_it_in() {
    let unable = "0001fde80000004d000100000001000200000007";
    let (mut desk, answered) = desk(Phase::Running);
    desk.stated(0, &RunState { members: Vec::new(), ..state(Phase::Running, 1) }).expect("encodes");
    assert_eq!(body(ask(&mut desk, &answered, CREATE)), unable, "no member lets outsiders in");
    let (mut desk, answered) = super::tests::desk(Phase::Stopped);
    assert_eq!(body(ask(&mut desk, &answered, CREATE)), unable, "the run is over");
    // At most 256, and what is not sound changes nothing.
    let (mut desk, answered) = super::tests::desk(Phase::Running);
    for number in 1..=300_u32 {
        let hex = CREATE.replace("0bb8", &format!("{number:04x}"));
        let hex = hex.replace("00000007", &format!("{:08x}", 100 + number));
        ask(&mut desk, &answered, &hex);
    }
    assert!(
        desk.created.has(EntityId::new(1, 3, 257)) && !desk.created.has(EntityId::new(1, 3, 258))
    );
    for wrong in ["7ff8000000000000", "4000000000000000", "7ff0000000000000"] {
        let hex = SET.replace("0bb8", "0001").replace("415052b600000000", wrong);
        let hex = hex.replace("41200000", "7fc00000").replace("0000000a", &wrong[..8]);
        let out = ask(&mut desk, &answered, &hex).expect("it is for the desk");
        let received = pdu::pdus(&out[0]).next().expect("one").expect("sound");
        let Body::Data(data) = received.body() else { panic!("{received:?}") };
        let ids: Vec<u32> = data.variable_datums.iter().map(|datum| datum.id.0).collect();
        assert_eq!(ids, [240_035, 0], "{wrong}");
    }
    assert!(desk.due(0).expect("encodes").is_empty(), "none has a place");
    desk.stated(0, &RunState { run: 2, ..state(Phase::Configured, 0) }).expect("encodes");
    assert!(!desk.created.has(EntityId::new(1, 3, 1)), "a new run begins without them");
}

#[test]
fn participants_are_told_until_they_acknowledge_and_all_hear_who_does_not() {
    let (mut desk, answered) = desk(Phase::Configured);
    let me = EntityId::new(77, 1, 0);
    assert!(desk.takes_part(me, ActionId::JOIN_EXERCISE));
    assert!(desk.takes_part(me, ActionId::JOIN_EXERCISE), "twice is once");
    for entity in 1..64 {
        assert!(desk.takes_part(EntityId::new(78, 1, entity), ActionId::JOIN_EXERCISE));
    }
    assert!(!desk.takes_part(EntityId::new(79, 1, 0), ActionId::JOIN_EXERCISE), "64 at most");
    for entity in 1..64 {
        desk.takes_part(EntityId::new(78, 1, entity), ActionId::RESIGN_EXERCISE);
    }
    let out = desk.reached((0, 0), (Phase::Running, 0), false).expect("encodes");
    // Start/Resume-R (53): acknowledgement required, request 80000000.
    assert_eq!(out.len(), 1);
    assert_eq!(out[0][..4], octets("0701350a")[..]);
    assert_eq!(out[0][12..24], octets("0001fde80000 004d00010000")[..]);
    assert_eq!(out[0][40..], octets("00 000000 80000000")[..]);
    // Acknowledge-R (55) of somebody else, then its own.
    let others = "0701370a 00000000 00200000 004e00010000 0001fde80000 0003 0001 80000000";
    assert_eq!(ask(&mut desk, &answered, others), Some(Vec::new()));
    assert_eq!(desk.due(SECOND).expect("encodes"), out, "once more after a second");
    let own = others.replace("004e", "004d");
    assert_eq!(ask(&mut desk, &answered, &own), Some(Vec::new()));
    assert!(desk.due(2 * SECOND).expect("encodes").is_empty());

    // Stop/Freeze-R (54) that nobody acknowledges: three times more, then an Event Report to all.
    let at = 10 * SECOND;
    let out = desk.reached((at, 0), (Phase::Frozen, 70), false).expect("encodes");
    assert_eq!(out[0][..4], octets("0701360a")[..]);
    assert_eq!(
        out[0][32..],
        octets("01 00 00 00 80000001")[..],
        "recess, acknowledgement required"
    );
    let sent: Vec<Out> = (1..=6).map(|s| desk.due(at + s * SECOND).expect("encodes")).collect();
    assert!(sent[..3].iter().all(|again| *again == out), "{sent:?}");
    assert_eq!(
        text(&sent[3][0]),
        "SEEDS FROZEN at frame 70: 77:1:0 did not acknowledge Stop/Freeze-R (request 2147483649)"
    );
    assert!(sent[4..].iter().all(Vec::is_empty), "and no more");

    // One that says that it cannot.
    desk.reached((at, 0), (Phase::Running, 70), false).expect("encodes");
    let unable = own.replace("0001 80000000", "0002 80000002");
    let out = ask(&mut desk, &answered, &unable).expect("it is for the desk");
    assert_eq!(
        text(&out[0]),
        "SEEDS RUNNING at frame 70: 77:1:0 is unable to comply with Start/Resume-R"
    );
}

#[test]
fn a_query_with_an_interval_is_answered_again_and_again_until_it_is_ended() {
    let (mut desk, answered) = desk(Phase::Running);
    desk.stated(0, &state(Phase::Frozen, 20)).expect("encodes");
    // Data Query (18) every second (0x123456 units) for state (40010), elapsed time (46000), and what nobody knows.
    let query = "07011205 00000000 00340000 004d00010000 0001fde80000 00000005 00123456 00000003 00000000 \
        00009c4a 0000b3b0 00000001";
    let first = ask(&mut desk, &answered, query).expect("it is for the desk");
    // Data (20): state 3, 1.0 s.
    let start = octets(
        "0001fde80000 004d00010000 00000005 00000000 00000002 00000001 00009c4a 00000003 0000b3b0 3f800000",
    );
    assert_eq!(first[0][12..12 + start.len()], start[..]);
    assert!(desk.due(SECOND / 2).expect("encodes").is_empty());
    for s in 1..4 {
        assert_eq!(desk.due(s * SECOND).expect("encodes"), first, "{s}");
    }
    let end = query.replace("00123456", "00000000");
    assert_eq!(ask(&mut desk, &answered, &end), Some(first));
    assert!(desk.due(9 * SECOND).expect("encodes").is_empty());
    // No more than sixteen, five times a second at most, and not for ever.
    for number in 0..40 {
        let hex = query.replace("00000005", &format!("000001{number:02x}"));
        ask(&mut desk, &answered, &hex.replace("00123456", "00000002"));
    }
    assert_eq!(desk.due(SECOND / 10).expect("encodes").len(), 0);
    assert_eq!(desk.due(SECOND / 5).expect("encodes").len(), 16);
    assert!(desk.due(601 * SECOND).expect("encodes").is_empty());
    // Without an interval and without names it is a question to the conductor.
    let plain =
        "07011205 00000000 00280000 004d00010000 0001fde80000 00000006 00000000 00000000 00000000";
    assert!(ask(&mut desk, &answered, plain).is_none());
}

#[test]
fn what_happens_is_told_once_and_so_is_its_end() {
    let (mut desk, _) = desk(Phase::Running);
    let lost = "smdfm (process 1 on h) is lost: nothing was heard of it for 2 s".to_owned();
    let slow = "smdfm is working on frame 21 for 3 s".to_owned();
    let with = RunState { reasons: vec![slow, lost.clone()], ..state(Phase::Running, 20) };
    let out = desk.stated(0, &with).expect("encodes");
    assert_eq!(
        out.iter().map(|o| text(o)).collect::<Vec<_>>(),
        [format!("SEEDS RUNNING at frame 20: {lost}")]
    );
    assert!(desk.stated(SECOND, &with).expect("encodes").is_empty(), "once");
    let out = desk.stated(2 * SECOND, &state(Phase::Running, 21)).expect("encodes");
    assert_eq!(text(&out[0]), format!("SEEDS RUNNING at frame 21: over: {lost}"));
    // Late for more than three seconds, and in time again.
    let at = |achieved_rate| RunState { achieved_rate, ..state(Phase::Running, 30) };
    let mut told = Vec::new();
    for (s, achieved) in [
        (3, 0.5),
        (5, 0.5),
        (6, 1.0),
        (7, 0.8),
        (8, 0.8),
        (11, 0.8),
        (12, 0.8),
        (13, 0.95),
        (14, 0.98),
    ] {
        let out = desk.stated(s * SECOND, &at(achieved)).expect("encodes");
        told.extend(out.iter().map(|o| (s, text(o))));
    }
    assert_eq!(
        told,
        [
            (
                11,
                "SEEDS RUNNING at frame 30: late: 0.80 of 1 simulated seconds a second".to_owned()
            ),
            (14, "SEEDS RUNNING at frame 30: in time again".to_owned()),
        ]
    );
    let out = desk.reached((0, 0), (Phase::Configured, 0), false).expect("encodes");
    assert_eq!(text(&out[0]), "SEEDS CONFIGURED at frame 0: reached");
}

#[test]
fn a_start_at_another_simulated_time_is_refused_while_time_stands() {
    let (mut desk, _) = desk(Phase::Frozen);
    desk.stated(0, &RunState { start_utc_ns: 3_600_000_000_000, ..state(Phase::Frozen, 20) })
        .expect("encodes");
    let at = |ns: i64| ClockTime::from_unix_nanos(3_600_000_000_000 + ns);
    assert!(desk.starts_here(at(1_000_000_000)), "frame 20 is 1 s");
    assert!(desk.starts_here(ClockTime::default()), "nothing is said of it");
    assert!(!desk.starts_here(at(1_050_000_000)) && !desk.starts_here(at(0)));
    desk.stated(0, &RunState { start_utc_ns: 3_600_000_000_000, ..state(Phase::Configured, 0) })
        .expect("encodes");
    assert!(!desk.starts_here(at(1_050_000_000)), "a run begins with its scene's time");
    assert!(desk.starts_here(at(0)) && desk.starts_here(at(20_000_000)), "which is that");
}

/// A tool that begins again, or never counts, uses a number for another request.
#[test]
fn a_number_that_is_used_again_is_another_request() {
    let (mut desk, answered) = desk(Phase::Running);
    let able = "0001fde80000004d000100000001000100000007";
    for entity in ["0bb8", "0bba"] {
        let create = CREATE.replace("0bb8", entity);
        assert_eq!(body(ask(&mut desk, &answered, &create)), able, "{entity}");
        assert_eq!(body(ask(&mut desk, &answered, &create)), able, "{entity}: the same again");
        let id = u16::from_str_radix(entity, 16).expect("digits");
        assert!(desk.created.has(EntityId::new(1, 3, id)), "{entity} is there");
    }
    let mut tug =
        |marking: &str| body(ask(&mut desk, &answered, &SET.replace("5455472031", marking)));
    let told: Vec<String> = ["5455472031", "5455472032", "5455472031"].map(&mut tug).into();
    assert!(told[1].contains("5455472032") && told[0] == told[2], "{told:?}");
    // The third one is no echo of the first: it was set again.
    assert_eq!(desk.echoes.len(), 1);
}
