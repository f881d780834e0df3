use super::clock::Follows;
use super::*;
use crate::Envelope;
use crate::enumerations::DeadReckoningAlgorithm;
use crate::management::RemoveEntity;
use crate::publishing::Thresholds;
use crate::records::{EntityType, Location, Marking, Vector32};
use proptest::prelude::*;

const ID: EntityId = EntityId { site: 7, application: 3, entity: 42 };
/// 2023-11-14 22:13:20 UTC: twenty minutes before an hour is full.
const START_NS: i64 = 1_700_000_000_000_000_000;
const SECOND: i64 = 1_000_000_000;

fn moving(x_m: f64, speed_mps: f64, appearance: u32) -> EntityState<'static> {
    EntityState {
        entity_id: ID,
        entity_type: EntityType::new(1, 1, 225, 81, 0, 0, 0),
        location: Location { x_m, y_m: 0.0, z_m: 0.0 },
        linear_velocity_mps: Vector32::from_f64([speed_mps, 0.0, 0.0]),
        dead_reckoning_algorithm: DeadReckoningAlgorithm::FPW,
        marking: Marking::new("GUEST1").expect("short"),
        appearance,
        ..EntityState::default()
    }
}

fn datagram(stamp: DisTime, body: &impl crate::EncodeBody) -> Vec<u8> {
    let mut octets = Vec::new();
    Envelope::new(1, stamp).append(body, &mut octets).expect("fits");
    octets
}

fn x_at(exercise: &Exercise, time_ns: i64) -> Option<f64> {
    Some(exercise.entity(ID)?.at(time_ns)?.estimate.location.x_m)
}

/// A well-mixed share of one, the same in every run.
fn share(n: i64) -> f64 {
    let mut z = (n as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ z >> 31) >> 11) as f64 / (1_u64 << 53) as f64
}

/// A sender and the way to its receiver.
#[derive(Clone, Copy, Debug)]
struct Way {
    /// Exercise seconds of the receiver in a second of wall time.
    rate: f64,
    /// Seconds of the sender in a second of wall time.
    sender_rate: f64,
    /// The sender's clock minus UTC (or minus exercise time, if it follows that), s.
    ahead_s: f64,
    absolute: bool,
    delay_s: f64,
    jitter_s: f64,
    every_s: f64,
}

/// 70 m/s for a minute of wall time; the largest error of its place in the last 40 s, m. The place that is right is
/// where the sender has it at that moment of wall time.
fn worst_m(way: &Way) -> f64 {
    const SPEED_MPS: f64 = 70.0;
    // Exercise time began elsewhere than the wall clock: a scene of another day.
    let exercise_start = START_NS - 123_456_789_000_000_000 / 1000 * 7;
    let time_ns = |wall_s: f64| exercise_start + (wall_s * way.rate * 1e9) as i64;
    let follows = (way.sender_rate - way.rate).abs() < 1e-9 && way.rate != 1.0;
    let sender_s = |wall_s: f64| wall_s * way.sender_rate + way.ahead_s;
    let stamp = |wall_s: f64| {
        let base = if follows { exercise_start } else { START_NS };
        let ns = (base + (sender_s(wall_s) * 1e9) as i64) as u64;
        if way.absolute { DisTime::absolute(ns) } else { DisTime::relative(ns) }
    };
    let mut on_the_way: Vec<(f64, Vec<u8>)> = (0..(60.0 / way.every_s) as i64)
        .map(|n| {
            let sent_s = n as f64 * way.every_s;
            let delay_s = way.delay_s + way.jitter_s * (2.0 * share(n) - 1.0);
            let state = moving(SPEED_MPS * sender_s(sent_s), SPEED_MPS, 0);
            (sent_s + delay_s, datagram(stamp(sent_s), &state))
        })
        .collect();
    on_the_way.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut exercise = Exercise::new(1);
    let mut next = 0;
    let mut worst = 0.0_f64;
    for frame in 0..1200 {
        let wall_s = f64::from(frame) * 0.05;
        while let Some((at_s, octets)) = on_the_way.get(next).filter(|(at_s, _)| *at_s <= wall_s) {
            let utc_ns = START_NS + (at_s * 1e9) as i64;
            let arrival = Arrival { time_ns: time_ns(*at_s), utc_ns, rate: way.rate };
            assert!(exercise.feed(&arrival, octets).refused.is_empty());
            next += 1;
        }
        if wall_s > 20.0 {
            let x_m = x_at(&exercise, time_ns(wall_s)).expect("it is there");
            worst = worst.max((x_m - SPEED_MPS * sender_s(wall_s)).abs());
        }
    }
    worst
}

#[test]
fn a_synchronised_visitor_stands_where_it_is_whatever_its_delay_and_our_rate() {
    for rate in [0.5, 1.0, 4.0, 20.0] {
        for (delay_s, jitter_s) in [(0.0, 0.0), (0.2, 0.05), (0.6, 0.3), (0.001, 0.001)] {
            for every_s in [0.2, 1.0, 3.3] {
                for sender_rate in [1.0, rate] {
                    // Delays in the exercise's own seconds beyond a second cannot be told from an offset.
                    // And who is silent for 12 s of his own is gone.
                    if sender_rate * (delay_s + jitter_s) > 1.0 || sender_rate * every_s > 10.0 {
                        continue;
                    }
                    let way = Way {
                        rate,
                        sender_rate,
                        ahead_s: 0.0,
                        absolute: true,
                        delay_s,
                        jitter_s,
                        every_s,
                    };
                    let worst = worst_m(&way);
                    assert!(worst < 0.5, "{way:?}: {worst} m");
                }
            }
        }
    }
}

#[test]
fn a_visitor_with_a_clock_of_its_own_is_placed_as_if_its_fastest_pdu_came_at_once() {
    for rate in [0.5, 1.0, 4.0, 20.0] {
        for absolute in [true, false] {
            for ahead_s in [3.0, -3.0, 700.0, -1234.5, 0.2] {
                for jitter_s in [0.0, 0.05] {
                    let way = Way {
                        rate,
                        sender_rate: 1.0,
                        ahead_s,
                        absolute,
                        delay_s: jitter_s,
                        jitter_s,
                        every_s: 0.2,
                    };
                    let worst = worst_m(&way);
                    // Of a hundred delays from 0 to 100 ms the smallest is within 3 ms of none.
                    let limit = if jitter_s > 0.0 { 0.5 } else { 0.01 };
                    assert!(worst < limit, "{way:?}: {worst} m");
                }
            }
        }
    }
}

#[test]
fn a_clock_that_is_set_during_the_run_is_followed() {
    let mut exercise = Exercise::new(1);
    let mut worst = 0.0_f64;
    for n in 0..600_i64 {
        let utc_ns = START_NS + n * SECOND / 10;
        // After 20 s the sender stands still for 5 s of its own time, and goes on.
        let sender_ns = utc_ns - if n > 200 { 5 * SECOND } else { 0 } + 40 * SECOND;
        let sender_s = (sender_ns - START_NS) as f64 * 1e-9;
        let octets =
            datagram(DisTime::relative(sender_ns as u64), &moving(20.0 * sender_s, 20.0, 0));
        exercise.feed(&Arrival::in_real_time(utc_ns), &octets);
        if n > 210 {
            worst = worst.max((x_at(&exercise, utc_ns).expect("there") - 20.0 * sender_s).abs());
        }
    }
    assert!(worst < 0.1, "{worst} m");
    let (sender, clock) = exercise.senders().next().expect("one sender");
    assert_eq!((sender, clock.follows, clock.synchronised), ((7, 3), Follows::Host, false));
    assert!((clock.offset_s + 35.0).abs() < 1e-3, "{clock:?}");
}

#[test]
fn a_frozen_entity_stays_where_it_is() {
    let mut exercise = Exercise::new(1);
    let at = |s: i64| START_NS + s * SECOND;
    let frozen = AirAppearance(0).with_frozen(true).0;
    let feed = |exercise: &mut Exercise, s: i64, x_m: f64, appearance: u32| {
        let octets = datagram(DisTime::absolute(at(s) as u64), &moving(x_m, 20.0, appearance));
        exercise.feed(&Arrival::in_real_time(at(s)), &octets)
    };
    assert_eq!(feed(&mut exercise, 0, 0.0, 0).changes, [Change::Appeared(ID)]);
    feed(&mut exercise, 3, 60.0, frozen);
    for s in 3..15 {
        assert!((x_at(&exercise, at(s)).expect("there") - 60.0).abs() < 1e-3, "{s} s");
    }
    assert!(exercise.entity(ID).and_then(|e| e.at(at(4))).expect("there").frozen);
    assert_eq!(x_at(&exercise, at(16)), None, "silent for more than 12 s");
    feed(&mut exercise, 17, 60.0, 0);
    assert!((x_at(&exercise, at(18)).expect("there") - 80.0).abs() < 1e-3, "it goes on");
}

#[test]
fn entities_are_updated_deactivated_removed_and_come_back() {
    let mut exercise = Exercise::new(1);
    let at = |s: i64| START_NS + s * SECOND;
    let stamp = |s: i64| DisTime::absolute(at(s) as u64);
    let now = |s: i64| Arrival::in_real_time(at(s));
    let update = EntityStateUpdate {
        entity_id: ID,
        location: Location { x_m: 500.0, y_m: 0.0, z_m: 0.0 },
        linear_velocity_mps: Vector32::from_f64([10.0, 0.0, 0.0]),
        ..EntityStateUpdate::default()
    };
    let early = exercise.feed(&now(0), &datagram(stamp(0), &update));
    assert_eq!(early.refused, [Refusal::Unknown]);
    exercise.feed(&now(0), &datagram(stamp(0), &moving(0.0, 20.0, 0)));
    exercise.feed(&now(1), &datagram(stamp(1), &update));
    // The model of dead reckoning is that of the Entity State.
    assert!((x_at(&exercise, at(3)).expect("there") - 520.0).abs() < 1e-3);
    assert_eq!(exercise.entity(ID).expect("known").marking(), "GUEST1");

    let gone = AirAppearance(0).with_deactivated(true).0;
    let left = exercise.feed(&now(4), &datagram(stamp(4), &moving(530.0, 0.0, gone)));
    assert_eq!(left.changes, [Change::Left(ID)]);
    assert_eq!(x_at(&exercise, at(4)), None);
    assert!(x_at(&exercise, at(3)).is_some(), "it was there before");
    // Overtaken on the way: from before it left.
    exercise.feed(&now(5), &datagram(stamp(3), &moving(520.0, 10.0, 0)));
    assert_eq!(x_at(&exercise, at(5)), None);
    exercise.feed(&now(6), &datagram(stamp(6), &moving(0.0, 0.0, 0)));
    assert_eq!(x_at(&exercise, at(7)), Some(0.0), "it is back");

    let remove = |receiving_id| RemoveEntity { receiving_id, ..RemoveEntity::default() };
    let other = remove(EntityId::new(7, 3, 43));
    let done = exercise.feed(&now(8), &datagram(stamp(8), &other));
    assert_eq!(done.changes, [Change::Removed(0)]);
    let all = remove(EntityId::new(7, 3, 0xffff));
    assert_eq!(exercise.feed(&now(8), &datagram(stamp(8), &all)).changes, [Change::Removed(1)]);
    assert_eq!(x_at(&exercise, at(9)), None);
    exercise.forget_before(at(9));
    assert_eq!(exercise.entities().count(), 0);
}

#[test]
fn a_transponder_belongs_to_its_entity_whichever_came_first() {
    let transponder = Transponder {
        on: true,
        mode_3a: Some(0o4721),
        mode_c_feet: Some(-300),
        address: Some(0x4b_1812),
        identification: Some(Transponder::identification_of("swr8x")),
        on_ground: Some(true),
    };
    let now = Arrival::in_real_time(START_NS);
    let iff = datagram(DisTime(1), &transponder.iff(ID));
    let state = datagram(DisTime(1), &moving(0.0, 0.0, 0));
    for order in [[&iff, &state], [&state, &iff]] {
        let mut exercise = Exercise::new(1);
        order.iter().for_each(|octets| drop(exercise.feed(&now, octets)));
        let entity = exercise.entity(ID).expect("known");
        assert_eq!(entity.transponder(), Some(&transponder));
        assert_eq!(transponder.identification_text().as_deref(), Some("SWR8X"));
    }
    let mut exercise = Exercise::new(1);
    exercise.feed(&now, &state);
    exercise.feed(&now, &iff);
    let off = Transponder { on: false, ..transponder };
    exercise.feed(&now, &datagram(DisTime(1), &off.iff(ID)));
    let entity = exercise.entity(ID).expect("known");
    assert_eq!((entity.transponder(), entity.answers()), (None, false));
}

/// An identifier that another entity uses after it was left is not who had it before: neither transponder nor place of that one are his.
#[test]
fn who_takes_over_an_identifier_takes_over_nothing_else() {
    let at = |s: i64| START_NS + s * SECOND;
    let stamp = |s: i64| DisTime::absolute(at(s) as u64);
    let now = |s: i64| Arrival::in_real_time(at(s));
    let said = |callsign: &str| Transponder {
        on: true,
        address: Some(0x4b_1812),
        identification: Some(Transponder::identification_of(callsign)),
        ..Transponder::default()
    };
    let gone = AirAppearance(0).with_deactivated(true).0;
    let other = EntityState {
        marking: Marking::new("TRUCK1").expect("short"),
        entity_type: EntityType::new(1, 1, 225, 81, 0, 0, 0),
        ..moving(500.0, 0.0, 0)
    };
    let remove = RemoveEntity { receiving_id: ID, ..RemoveEntity::default() };
    for removed in [false, true] {
        let mut exercise = Exercise::new(1);
        exercise.feed(&now(0), &datagram(stamp(0), &moving(0.0, 20.0, 0)));
        exercise.feed(&now(0), &datagram(stamp(0), &said("SWR8X").iff(ID)));
        let leave = match removed {
            true => datagram(stamp(2), &remove),
            false => datagram(stamp(2), &moving(40.0, 20.0, gone)),
        };
        exercise.feed(&now(2), &leave);
        // Within the same scan, so nobody has forgotten the first.
        exercise.feed(&now(4), &datagram(stamp(4), &other));
        let entity = exercise.entity(ID).expect("known");
        assert_eq!((entity.transponder(), entity.marking()), (None, "TRUCK1".to_owned()));
        assert_eq!(x_at(&exercise, at(3)), None, "between the two nobody was there");
        assert_eq!(x_at(&exercise, at(4)), Some(500.0));
        // Its own transponder is its own, also where it spoke before the first state.
        exercise.feed(&now(5), &leave_at(5));
        exercise.feed(&now(6), &datagram(stamp(6), &said("GUEST2").iff(ID)));
        exercise.feed(&now(6), &datagram(stamp(6), &moving(0.0, 0.0, 0)));
        let entity = exercise.entity(ID).expect("known");
        assert_eq!(entity.transponder(), Some(&said("GUEST2")));
    }

    fn leave_at(s: i64) -> Vec<u8> {
        let gone = AirAppearance(0).with_deactivated(true).0;
        datagram(DisTime::absolute((START_NS + s * SECOND) as u64), &moving(500.0, 0.0, gone))
    }
}

/// What a transponder says while its entity is not there waits for it as long as one is heard, and no longer: an old "off" made the next
/// user of the identifier deaf for good, and leftovers filled the room of all.
#[test]
fn what_waits_for_an_entity_does_not_wait_for_ever() {
    let now = |s: i64| Arrival::in_real_time(START_NS + s * SECOND);
    let stamp = |s: i64| DisTime::absolute((START_NS + s * SECOND) as u64);
    let off = Transponder { on: false, address: Some(0x4b_1812), ..Transponder::default() };
    for (later_s, answers) in [(5, false), (3600, true)] {
        let mut exercise = Exercise::new(1);
        exercise.feed(&now(0), &datagram(stamp(0), &off.iff(ID)));
        let state = datagram(stamp(later_s), &moving(0.0, 0.0, 0));
        exercise.feed(&now(later_s), &state);
        assert_eq!(exercise.entity(ID).expect("known").answers(), answers, "{later_s} s later");
    }
    let mut exercise = Exercise::new(1);
    let waits = |exercise: &mut Exercise, s: i64, entity: usize| {
        let id = EntityId { entity: entity as u16, ..ID };
        exercise.feed(&now(s), &datagram(stamp(s), &off.iff(id))).refused
    };
    let most = exercise.limits.entities;
    (0..most).for_each(|k| assert!(waits(&mut exercise, 0, k).is_empty()));
    assert_eq!(waits(&mut exercise, 1, most), [Refusal::TooMany]);
    assert!(waits(&mut exercise, 60, most).is_empty(), "the others have gone");
}

/// A transponder whose IFF stops is not heard any more after 2.4 of its heartbeats of ten seconds; one of a sender whose time stands is, and
/// one that was switched off stays off. At another rate than ours both clocks have to say so.
#[test]
fn a_transponder_that_falls_silent_is_forgotten() {
    let on = Transponder { on: true, address: Some(0x4b_1812), ..Transponder::default() };
    let frozen = AirAppearance(0).with_frozen(true).0;
    // (transponder, rate, appearance while it is silent) → (there after 20 s, after 30 s of the wall clock)
    for (transponder, rate, appearance, expected) in [
        (on, 1.0, 0, [true, false]),
        (on, 1.0, frozen, [true, true]),
        (on, 4.0, 0, [true, false]),
        (on, 0.25, 0, [true, true]),
        (Transponder { on: false, ..on }, 1.0, 0, [false, false]),
    ] {
        let mut exercise = Exercise::new(1);
        let now = |wall_s: i64| Arrival {
            time_ns: START_NS + (wall_s as f64 * rate * 1e9) as i64,
            utc_ns: START_NS + wall_s * SECOND,
            rate,
        };
        let stamp = |wall_s: i64| DisTime::absolute((START_NS + wall_s * SECOND) as u64);
        exercise.feed(&now(0), &datagram(stamp(0), &moving(0.0, 0.0, 0)));
        exercise.feed(&now(0), &datagram(stamp(0), &transponder.iff(ID)));
        let mut there = Vec::new();
        for wall_s in 1..=30 {
            exercise.feed(&now(wall_s), &datagram(stamp(wall_s), &moving(0.0, 0.0, appearance)));
            let entity = exercise.entity(ID).expect("known");
            assert_eq!(entity.answers(), transponder.on, "{wall_s} s");
            if wall_s == 20 || wall_s == 30 {
                there.push(entity.transponder().is_some());
            }
        }
        assert_eq!(there, expected, "{transponder:?}, rate {rate}, appearance {appearance}");
    }
}

#[test]
fn a_flood_finds_its_bound() {
    let mut exercise = Exercise::new(1);
    let now = Arrival::in_real_time(START_NS);
    for n in 0..10_000_u32 {
        let entity_id = EntityId::new((n >> 8) as u16, (n & 0xff) as u16, 1);
        let state = EntityState { entity_id, ..moving(0.0, 0.0, 0) };
        let fed = exercise.feed(&now, &datagram(DisTime(1), &state));
        assert_eq!(fed.refused.is_empty(), n < 4096, "{n}");
        let iff =
            Transponder { on: true, ..Transponder::default() }.iff(EntityId::new(9, 9, n as u16));
        exercise.feed(&now, &datagram(DisTime(1), &iff));
    }
    for n in 0..1000 {
        let later = Arrival::in_real_time(START_NS + n);
        let state = EntityState { entity_id: EntityId::new(0, 0, 1), ..moving(0.0, 0.0, 0) };
        exercise.feed(&later, &datagram(DisTime(1), &state));
    }
    assert_eq!((exercise.entities.len(), exercise.transponders.len()), (4096, 4096));
    assert!(exercise.senders.len() <= 4096);
    assert!(exercise.entities.values().all(|e| e.states() <= 64));
    // Who is gone makes room.
    exercise.forget_before(START_NS + 13 * SECOND);
    assert_eq!(exercise.entities.len(), 0);
}

/// Whoever asks at the end of a scan asks for all of it. A sender that says more states than are kept is found at every time of it, and
/// what dead reckoning is wrong by follows from the time between those that are kept: at most 2 s / 63 in a second.
#[test]
fn more_states_than_are_kept_leave_the_whole_scan() {
    const TURN_RAD_S: f64 = 0.5;
    const SPEED_MPS: f64 = 20.0;
    let motion = |t_s: f64| {
        let (sin, cos) = libm::sincos(TURN_RAD_S * t_s);
        [SPEED_MPS / TURN_RAD_S * sin, SPEED_MPS * cos]
    };
    for (scan_s, rate_hz, late) in [
        (1, 20, false),
        (1, 100, false),
        (1, 200, true),
        (1, 1000, false),
        (4, 20, false),
        (4, 250, true),
    ] {
        let mut exercise = Exercise::new(1);
        let count = i64::from(scan_s * rate_hz);
        let ns = |n: i64| n * SECOND / i64::from(rate_hz);
        for n in 0..=count {
            // Every second one is overtaken by the next.
            let sent = if late && n < count { n ^ 1 } else { n };
            let [x_m, speed_mps] = motion(ns(sent) as f64 * 1e-9);
            let stamp = DisTime::absolute((START_NS + ns(sent)) as u64);
            let arrival = Arrival::in_real_time(START_NS + ns(n.max(sent)));
            exercise.feed(&arrival, &datagram(stamp, &moving(x_m, speed_mps, 0)));
        }
        assert!(exercise.entity(ID).expect("known").states() <= 64);
        let between_s = f64::from(scan_s) * 2.0 / 63.0 + 1.0 / f64::from(rate_hz);
        let bound_m = SPEED_MPS * TURN_RAD_S * between_s * between_s / 2.0 + 0.001;
        for n in 0..=500 {
            // Times of the clock of DIS are whole to 1.7 µs.
            let at_ns = i64::from(scan_s) * SECOND * n / 500 + 2_000;
            let x_m = x_at(&exercise, START_NS + at_ns);
            let case = format!("{scan_s} s, {rate_hz} Hz, at {at_ns} ns");
            let off_m = x_m.map(|x_m| (x_m - motion(at_ns as f64 * 1e-9)[0]).abs());
            assert!(off_m.is_some_and(|off_m| off_m <= bound_m), "{case}: {off_m:?}, {bound_m}");
        }
    }
}

#[test]
fn what_an_announcer_sends_an_exercise_understands() {
    let mut ours = Announcer::new(1, Thresholds { distance_m: 0.5, ..Thresholds::default() });
    let mut theirs = Exercise::new(1);
    let truth_m = |t_s: f64| 100.0 * libm::sin(0.1 * t_s);
    let transponder = Transponder { on: true, address: Some(0xabc), ..Transponder::default() };
    let mut sent = 0;
    let mut deliver = |theirs: &mut Exercise, utc_ns: i64, datagrams: Vec<Vec<u8>>| {
        for octets in datagrams {
            sent += 1;
            assert!(theirs.feed(&Arrival::in_real_time(utc_ns), &octets).refused.is_empty());
        }
    };
    for n in 0..800_i64 {
        let (t_s, utc_ns) = (n as f64 * 0.05, START_NS + n * SECOND / 20);
        let state = moving(truth_m(t_s), 10.0 * libm::cos(0.1 * t_s), 0);
        let due = ours.present(utc_ns, &state, Some(&transponder)).expect("fits");
        deliver(&mut theirs, utc_ns, due);
        let off_m = (x_at(&theirs, utc_ns).expect("there") - truth_m(t_s)).abs();
        assert!(off_m <= 0.5 + 1e-3, "{t_s} s: {off_m} m");
    }
    let until = START_NS + 40 * SECOND;
    deliver(&mut theirs, until, ours.freeze(until).expect("fits"));
    let stands = x_at(&theirs, until).expect("there");
    assert_eq!(x_at(&theirs, until + 10 * SECOND), Some(stands), "frozen");
    assert!((stands - truth_m(40.0)).abs() < 1.0);
    ours.resume();
    let state = moving(stands, 0.0, 0);
    let due = ours.present(until + 11 * SECOND, &state, None).expect("fits");
    assert_eq!(due.len(), 1, "due again after a freeze");
    deliver(&mut theirs, until + 11 * SECOND, due);
    let last = ours.remove(until + 12 * SECOND, ID).expect("fits").expect("it was sent");
    deliver(&mut theirs, until + 12 * SECOND, vec![last]);
    assert_eq!(x_at(&theirs, until + 12 * SECOND), None);
    assert!(ours.remove(until + 13 * SECOND, ID).expect("fits").is_none());
    assert!(sent < 80, "{sent} datagrams for 800 steps");
}

proptest! {
    #[test]
    fn no_stamp_and_no_time_breaks_the_clock(
        arrivals in prop::collection::vec(
            (any::<i64>(), any::<i64>(), any::<f64>(), any::<u32>(), any::<u8>()), 1..60),
    ) {
        let mut exercise = Exercise::new(1);
        for (time_ns, utc_ns, rate, stamp, kind) in arrivals {
            let arrival = Arrival { time_ns, utc_ns, rate };
            let appearance = u32::from(kind & 7) << 21;
            let octets = datagram(DisTime(stamp), &moving(1.0, 2.0, appearance));
            exercise.feed(&arrival, &octets);
            for at in [time_ns, i64::MIN, i64::MAX, 0] {
                let _ = exercise.at(at).count();
            }
            if kind & 64 != 0 {
                exercise.forget_before(time_ns);
            }
        }
    }
}
