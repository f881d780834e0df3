//! Opening and seeking in a recording of a million PDUs. `cargo bench -p capture`.

#![expect(clippy::print_stdout, reason = "a bench tells its result")]
#![expect(clippy::unwrap_used, reason = "a bench stops where it fails")]
#![expect(clippy::disallowed_methods, reason = "a bench reads the clock")]

use capture::{Recorder, Recording};
use pdu::records::EntityId;
use pdu::{DisTime, EntityState, Envelope};
use std::time::Instant;

const PDUS: u32 = 1_000_000;
const ENTITIES: u32 = 2_000;

fn main() {
    let folder = std::env::temp_dir().join(format!("capture-seek-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("million.pcapng");
    let (from, to) = ("10.0.0.7:4001".parse().unwrap(), "239.1.2.3:3000".parse().unwrap());
    let start = Instant::now();
    let mut recorder = Recorder::create(&path).unwrap();
    let mut payload = Vec::new();
    for i in 0..PDUS {
        // Each entity is told every 4 s: 500 PDUs a second.
        let ns = i64::from(i) * 2_000_000;
        let state = EntityState {
            entity_id: EntityId::new(1, 1, (i % ENTITIES) as u16),
            capabilities: i,
            ..EntityState::default()
        };
        payload.clear();
        Envelope::new(1, DisTime::absolute(ns as u64)).append(&state, &mut payload).unwrap();
        recorder.record(1_700_000_000_000_000_000 + ns, from, to, &payload).unwrap();
    }
    recorder.close(0).unwrap();
    let octets = std::fs::metadata(&path).unwrap().len();
    println!("recorded {PDUS} PDUs, {} MB, in {:.2?}", octets >> 20, start.elapsed());
    let start = Instant::now();
    let recording = Recording::open(&path).unwrap();
    assert!(recording.index_made());
    println!("opened and indexed in {:.2?}", start.elapsed());
    let start = Instant::now();
    let recording_again = Recording::open(&path).unwrap();
    assert!(!recording_again.index_made());
    println!("opened with the index beside it in {:.2?}", start.elapsed());
    let (first, last) = (recording.time_ns(0), recording.time_ns(recording.len() - 1));
    let mut times: Vec<_> = (1..=200)
        .map(|n| {
            let at = first + (last - first) / 200 * n;
            let start = Instant::now();
            let alive = recording.alive_at(at, 12_000_000_000);
            let mut octets = 0;
            for pdu in &alive {
                recording.pdu(*pdu, &mut payload).unwrap();
                octets += payload.len();
            }
            let took = start.elapsed();
            assert_eq!((alive.len(), octets), (ENTITIES as usize, ENTITIES as usize * 144));
            took
        })
        .collect();
    times.sort();
    println!(
        "200 seeks with the states of {ENTITIES} entities read: median {:.2?}, worst {:.2?}",
        times[100], times[199]
    );
    std::fs::remove_dir_all(&folder).unwrap();
}
