//! What has to hold for any octets whatever: one body for the property tests, the fuzz targets and the
//! saved findings.

use pdu::dead_reckoning::Motion;
use pdu::{Body, Filter, Pdu, frames, pdus};
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

fn check_sound(pdu: &Pdu<'_>, octets: &[u8]) {
    write!(Sink, "{pdu:?}").expect("a sink takes everything");
    let mut again = [0xa5; 2048];
    if let Some(again) = again.get_mut(..octets.len()) {
        assert_eq!(pdu.encode(again), Ok(octets.len()));
        assert_eq!(again, octets, "decoded and encoded octets differ");
    } else {
        assert_eq!(pdu.encode_to_vec().as_deref(), Ok(octets));
    }
    if let Body::EntityState(state) = pdu.body() {
        for dt_s in [0.0, 1e-3, -5.0, 1e9] {
            let there = Motion::from(state).after(dt_s);
            let _ = (there.orientation(), there.location.to_geodetic());
        }
        let _ = state.marking.text();
    }
}
