//! What has to hold for any octets whatever: one body for the property tests, the fuzz targets and the
//! saved findings.

use pdu::dead_reckoning::Motion;
use pdu::exercise::{Arrival, Exercise, Limits, Transponder};
use pdu::records::ClockTime;
use pdu::{Body, DisTime, Filter, Pdu, frames, pdus};
use std::fmt::Write;

/// Takes text and forgets it: formatting reads every field and every element of every list.
struct Sink;

impl Write for Sink {
    fn write_str(&mut self, _: &str) -> std::fmt::Result {
        Ok(())
    }
}

/// Walks, decodes, reads every field, filters, dead-reckons and encodes again. Returns how many PDUs
/// were sound.
pub(crate) fn check_any_bytes(octets: &[u8]) -> usize {
    let mut sound = 0;
    let mut walked = 0;
    for received in pdus(octets) {
        match received {
            Ok(received) => {
                sound += 1;
                assert_eq!(received.offset, walked, "PDUs stand one behind the other");
                walked += received.octets.len();
                check_sound(&received.pdu, received.octets);
            }
            Err(damaged) => {
                write!(Sink, "{damaged} {damaged:?}").expect("a sink takes everything");
                assert!(damaged.pdu_offset >= walked && damaged.pdu_offset < octets.len());
                // The walk goes on behind it, if its length could be trusted.
                if let Some(frame) =
                    frames(octets).flatten().find(|f| f.offset == damaged.pdu_offset)
                {
                    assert!(damaged.offset <= frame.octets.len());
                    walked = frame.offset + frame.octets.len();
                }
            }
        }
    }
    check_exercise(octets);
    let mut walk = frames(octets);
    let filter = Filter::default().site(1).application(2);
    let cut: usize = walk
        .by_ref()
        .flatten()
        .map(|frame| {
            let _ = filter.wants(&frame);
            frame.octets.len()
        })
        .sum();
    assert_eq!(cut + walk.rest().len(), octets.len(), "every octet is in a PDU or in the rest");
    sound
}

/// Real and simulated times of simulation management.
fn clocks(body: &Body<'_>) -> Vec<ClockTime> {
    match body {
        Body::StartResume(s) => vec![s.real_world_time, s.simulation_time],
        Body::StartResumeR(s) => vec![s.real_world_time, s.simulation_time],
        Body::StopFreeze(s) => vec![s.real_world_time],
        Body::StopFreezeR(s) => vec![s.real_world_time],
        _ => Vec::new(),
    }
}

/// What an exercise makes of a datagram, at times that no clock has as well.
fn check_exercise(octets: &[u8]) {
    let Some(id) = octets.get(1) else { return };
    let mut exercise = Exercise::with_limits(*id, Limits { entities: 2, ..Limits::default() });
    for (time_ns, utc_ns, rate) in
        [(0, 0, 1.0), (i64::MAX, i64::MIN, 0.0), (i64::MIN, i64::MAX, f64::NAN), (1, 2, 1e300)]
    {
        exercise.feed(&Arrival { time_ns, utc_ns, rate }, octets);
        for at_ns in [0, 1_000_000_000, i64::MIN, i64::MAX] {
            for (entity, placed) in exercise.at(at_ns) {
                let _ = (entity.marking(), placed.estimate.orientation());
            }
        }
    }
    exercise.forget_before(0);
    assert!(exercise.entities().count() <= 2);
}

fn check_sound(pdu: &Pdu<'_>, octets: &[u8]) {
    write!(Sink, "{pdu:?}").expect("a sink takes everything");
    let mut again = [0xa5; 2048];
    if let Some(again) = again.get_mut(..octets.len()) {
        assert_eq!(pdu.encode(again), Ok(octets.len()));
        assert_eq!(again, octets, "decoded and encoded octets differ");
    } else {
        assert_eq!(pdu.encode_to_vec().as_deref(), Ok(octets));
    }
    let stamp = pdu.header().timestamp;
    for reference_ns in [0, i64::MIN, i64::MAX, 1_700_000_000_000_000_000] {
        let _ = stamp.near(reference_ns);
    }
    let _ =
        (stamp.nanos_past_hour(), stamp.nanos_since(DisTime(1)), stamp.seconds_since(DisTime(2)));
    for clock in clocks(pdu.body()) {
        let nanos = clock.unix_nanos();
        if nanos != i64::MAX && nanos != i64::MIN {
            let again = ClockTime::from_unix_nanos(nanos).unix_nanos();
            assert!(nanos.abs_diff(again) < 2000, "{nanos} {again}");
        }
    }
    if let Body::Iff(iff) = pdu.body() {
        let _ = (iff.mode_3a(), iff.mode_c_feet());
        if let Some(transponder) = Transponder::of(iff) {
            let _ = transponder.identification_text();
            assert_eq!(
                Transponder::of(&transponder.iff(iff.basic.emitting_entity)),
                Some(transponder)
            );
        }
    }
    if let Body::EntityState(state) = pdu.body() {
        for dt_s in [0.0, 1e-3, -5.0, 1e9] {
            let there = Motion::from(state).after(dt_s);
            let _ = (there.orientation(), there.location.to_geodetic());
        }
        let _ = state.marking.text();
    }
}
