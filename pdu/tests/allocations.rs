//! Encoding and decoding do not allocate in steady state, and damaged input does not make them.

mod common;

use common::samples;
use pdu::dead_reckoning::Motion;
use pdu::{Body, DisTime, Envelope, Filter, frames, pdus};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static COUNTER: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Without the test harness: its threads allocate, and the counter counts the whole process.
fn main() {
    let samples = samples::pdus();
    let octets: Vec<Vec<u8>> =
        samples.iter().map(|pdu| pdu.encode_to_vec().expect("fits")).collect();
    let bundle = octets.concat();
    let mut buffer = vec![0; 65536];
    let mut stream = Vec::with_capacity(2 * bundle.len());
    let state = samples::entity_state(2);
    let filter = Filter::default().exercise(7).site(0x0102);

    let region = Region::new(COUNTER);
    for pdu in &samples {
        pdu.encode(&mut buffer).expect("fits");
    }
    stream.clear();
    for pdu in &samples {
        pdu.append(&mut stream).expect("fits");
    }
    for frame in 0..1000 {
        let envelope = Envelope::new(7, DisTime::absolute(frame * 50_000_000));
        envelope.encode(&state, &mut buffer).expect("fits");
    }
    let mut sound = 0;
    let mut elements = 0;
    let mut wanted = 0;
    for _ in 0..100 {
        for received in pdus(&bundle) {
            let received = received.expect("sound");
            sound += 1;
            match received.body() {
                Body::EntityState(state) => {
                    elements += state.variable_parameters.iter().count();
                    let there = Motion::from(state).after(0.5);
                    elements += usize::from(there.location.x_m > 0.0);
                }
                Body::SetData(data) => elements += data.variable_datums.iter().count(),
                Body::ElectromagneticEmission(e) => {
                    elements += e.systems.iter().map(|s| s.beams.iter().count()).sum::<usize>();
                }
                _ => {}
            }
            received.encode(&mut buffer).expect("fits");
        }
        wanted += frames(&bundle).flatten().filter(|f| filter.wants(f)).count();
    }
    // Cut and damaged input: errors are values.
    for octets in &octets {
        for cut in 0..octets.len() {
            sound += pdus(&octets[..cut]).flatten().count();
        }
    }
    let change = region.change();
    assert!(sound >= 100 * samples.len() && elements > 0 && wanted > 0);
    assert_eq!((change.allocations, change.reallocations), (0, 0), "{change:?}");
}
