//! Recordings opened for playing: index, sidecar, states at a time.

#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod common;

use capture::{AlivePdu, Recorder, Recording};
use common::Folder;
use pdu::records::EntityId;
use pdu::{Body, DisTime, EntityState, Envelope, management};
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::Path;

const MS: i64 = 1_000_000;
const START: i64 = 1_700_000_000_000 * MS;

fn state(entity: u16, step: u32) -> EntityState<'static> {
    EntityState {
        entity_id: EntityId::new(1, 2, entity),
        capabilities: step,
        ..EntityState::default()
    }
}

/// `n` datagrams of 20 ms each, entities in turn, every fifth datagram a bundle of two; entity 3 is
/// removed in the middle, entity 4 deactivated, entity 5 falls silent.
fn write(path: &Path, n: u32, entities: u16) -> BTreeMap<(u32, u32), u32> {
    let mut recorder = Recorder::create(path).unwrap();
    let from: SocketAddr = "10.0.0.7:4001".parse().unwrap();
    let to: SocketAddr = "239.1.2.3:3000".parse().unwrap();
    let mut sent = BTreeMap::new();
    for i in 0..n {
        let envelope = Envelope::new(1, DisTime::absolute(u64::from(i) * 20_000_000));
        let mut payload = Vec::new();
        let mut entity = (i % u32::from(entities)) as u16 + 1;
        let late = i > n / 2;
        if i == n / 2 {
            let remove = management::RemoveEntity {
                originating_id: EntityId::new(9, 9, 9),
                receiving_id: EntityId::new(1, 2, 3),
                request_id: 1,
            };
            envelope.append(&remove, &mut payload).unwrap();
        }
        if late && [3, 5].contains(&entity) {
            entity = 1;
        }
        let mut es = state(entity, i);
        if late && entity == 4 {
            es.appearance = 1 << 23;
        }
        sent.insert((i, payload.len() as u32), i);
        envelope.append(&es, &mut payload).unwrap();
        if i % 5 == 0 {
            sent.insert((i, payload.len() as u32), i + 1_000_000);
            envelope.append(&state(100, i + 1_000_000), &mut payload).unwrap();
        }
        recorder.record(START + i64::from(i) * 20 * MS, from, to, &payload).unwrap();
    }
    recorder.close(0).unwrap();
    sent
}

fn entity_of(recording: &Recording, pdu: AlivePdu) -> (u16, u32) {
    let mut octets = Vec::new();
    recording.pdu(pdu, &mut octets).unwrap();
    let received = pdu::pdus(&octets).next().unwrap().unwrap();
    match received.body() {
        Body::EntityState(es) => (es.entity_id.entity, es.capabilities),
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_states_at_any_time_are_the_last_ones_before_it() {
    let folder = Folder::new("alive");
    let path = folder.file("a.pcapng");
    write(&path, 5000, 10);
    let recording = Recording::open(&path).unwrap();
    assert_eq!(recording.len(), 5000);
    assert_eq!(recording.problems().1, 0);
    let at = |i: i64| -> BTreeMap<u16, u32> {
        let found = recording.alive_at(START + i * 20 * MS, 12_000 * MS);
        found.into_iter().map(|p| entity_of(&recording, p)).collect()
    };
    assert_eq!(at(0), BTreeMap::new());
    let early = at(1001);
    let mut expected: BTreeMap<u16, u32> =
        (1..=10u16).map(|e| (e, 990 + u32::from(e) - 1)).collect();
    expected.insert(1, 1000);
    expected.insert(100, 1_001_000);
    assert_eq!(early, expected);
    let late = at(4000);
    let there: Vec<u16> = late.keys().copied().collect();
    // 3 removed, 4 deactivated, 5 silent since 30 s.
    assert_eq!(there, [1, 2, 6, 7, 8, 9, 10, 100]);
    assert_eq!(late[&10], 3999);
    let after = at(1_000_000);
    assert_eq!(after, BTreeMap::new(), "everything timed out");
}

#[test]
fn every_datagram_is_read_where_it_is() {
    let folder = Folder::new("places");
    let path = folder.file("a.pcapng");
    write(&path, 300, 7);
    let recording = Recording::open(&path).unwrap();
    let mut payload = Vec::new();
    for (i, datagram) in capture::Reader::open(&path).unwrap().enumerate() {
        let datagram = datagram.unwrap();
        recording.payload(i, &mut payload).unwrap();
        assert_eq!(payload, datagram.payload);
        assert_eq!(recording.from_to(i), (datagram.from, datagram.to));
        assert_eq!(recording.time_ns(i), datagram.utc_ns);
        assert_eq!(recording.first_at(datagram.utc_ns), i);
    }
}

#[test]
fn the_index_is_kept_used_and_made_anew_when_stale_or_damaged() {
    let folder = Folder::new("sidecar");
    let path = folder.file("a.pcapng");
    let sidecar = folder.file("a.pcapng.idx");
    write(&path, 100, 7);
    assert!(Recording::open(&path).unwrap().index_made());
    assert!(!sidecar.exists(), "a small file is read faster than its index is worth");
    write(&path, 40_000, 50);
    assert!(Recording::open(&path).unwrap().index_made());
    assert!(sidecar.exists());
    let kept = Recording::open(&path).unwrap();
    assert!(!kept.index_made());
    let alive = kept.alive_at(START + 700_000 * MS, 12_000 * MS);
    assert_eq!(alive.len(), 48);
    let mut octets = std::fs::read(&sidecar).unwrap();
    let middle = octets.len() / 2;
    octets[middle] ^= 1;
    std::fs::write(&sidecar, &octets).unwrap();
    let made = Recording::open(&path).unwrap();
    assert!(made.index_made(), "damaged");
    assert_eq!(made.alive_at(START + 700_000 * MS, 12_000 * MS), alive);
    assert!(!Recording::open(&path).unwrap().index_made(), "and mended");
    write(&path, 40_001, 50);
    let fresh = Recording::open(&path).unwrap();
    assert!(fresh.index_made(), "the recording was changed");
    assert_eq!(fresh.len(), 40_001);
}

#[test]
fn a_clock_set_back_does_not_turn_the_schedule() {
    let folder = Folder::new("clock");
    let path = folder.file("a.pcapng");
    let mut recorder = Recorder::create(&path).unwrap();
    let here: SocketAddr = "10.0.0.7:4001".parse().unwrap();
    for stamp in [10, 20, 5, 30] {
        recorder.record(stamp, here, here, &[0; 12]).unwrap();
    }
    recorder.close(0).unwrap();
    let recording = Recording::open(&path).unwrap();
    let times: Vec<i64> = (0..4).map(|i| recording.time_ns(i)).collect();
    assert_eq!(times, [10, 20, 20, 30]);
}

/// Writes datagrams that arrive 1 ms apart: (port of the sender, timestamp in seconds past some hour).
fn write_stamped(path: &Path, datagrams: &[(u16, f64)]) {
    let mut recorder = Recorder::create(path).unwrap();
    let to: SocketAddr = "239.1.2.3:3000".parse().unwrap();
    for (i, (port, stamp_s)) in (0..).zip(datagrams) {
        let from = SocketAddr::from(([10, 0, 0, 7], *port));
        let stamp = DisTime::absolute((stamp_s.rem_euclid(3600.0) * 1e9) as u64);
        let mut payload = Vec::new();
        Envelope::new(1, stamp).append(&state(1, 0), &mut payload).unwrap();
        recorder.record(START + i * MS, from, to, &payload).unwrap();
    }
    recorder.close(0).unwrap();
}

fn due_s(path: &Path) -> Vec<f64> {
    let recording = Recording::open(path).unwrap().by_stamps();
    let first = recording.time_ns(0);
    assert_eq!(first, START, "the first datagram stays where it is");
    (0..recording.len())
        .map(|i| ((recording.time_ns(i) - first) as f64 * 1e-6).round() * 1e-3)
        .collect()
}

#[test]
fn a_schedule_by_time_stamps_follows_the_senders_clocks() {
    let folder = Folder::new("stamps");
    let path = folder.file("a.pcapng");

    // Over the full hour; what comes late is due at once.
    write_stamped(&path, &[(1, 3598.0), (1, 3599.5), (2, 3599.0), (1, 1.0), (2, 2.5)]);
    assert_eq!(due_s(&path), [0.0, 1.5, 1.5, 3.0, 4.5]);
    let (arrival_ns, stamps_ns) = Recording::open(&path).unwrap().lasts_ns();
    assert_eq!(arrival_ns, 4 * MS);
    assert!((stamps_ns - 4_500 * MS).abs() < 2_000, "{stamps_ns}");

    // The second sender lives in another time; both go on with what they measure.
    write_stamped(&path, &[(1, 0.0), (2, 2000.0), (1, 1.0), (2, 2001.5), (1, 2.0)]);
    assert_eq!(due_s(&path), [0.0, 0.0, 1.0, 1.5, 2.0]);

    // Run again from the beginning: the second run follows on the first.
    write_stamped(&path, &[(1, 0.0), (1, 60.0), (1, 100.0), (1, 0.0), (1, 5.0)]);
    assert_eq!(due_s(&path), [0.0, 60.0, 100.0, 100.0, 105.0]);
}

#[test]
fn what_has_no_time_stamp_is_due_with_what_came_before() {
    let folder = Folder::new("unstamped");
    let path = folder.file("a.pcapng");
    let mut recorder = Recorder::create(&path).unwrap();
    let here: SocketAddr = "10.0.0.7:4001".parse().unwrap();
    for late in [0, 20, 5, 30] {
        recorder.record(START + late, here, here, b"not a PDU").unwrap();
    }
    recorder.close(0).unwrap();
    assert_eq!(due_s(&path), [0.0; 4]);
}
