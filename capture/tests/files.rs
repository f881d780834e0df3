//! Files in every form that is read, sound and damaged.

#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use capture::{
    BlockFault, Datagram, FrameFault, Kind, Problem, Reader, RecordError, Recorder, Sink,
};
use std::io::{self, Cursor, Write};
use std::net::SocketAddr;
use std::path::PathBuf;

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/dis").join(name)
}

fn read_all(octets: &[u8]) -> (Vec<Datagram>, Vec<Problem>) {
    let reader = Reader::new(Cursor::new(octets), "test", false).expect("opens");
    let (mut good, mut bad) = (Vec::new(), Vec::new());
    for item in reader {
        match item {
            Ok(d) => good.push(d),
            Err(p) => bad.push(p),
        }
    }
    (good, bad)
}

/// A file in memory that a recorder can write.
#[derive(Clone, Debug, Default)]
struct Memory {
    octets: std::sync::Arc<std::sync::Mutex<Vec<u8>>>,
    /// Octets that fit; beyond, the "disk" is full.
    room: std::sync::Arc<std::sync::atomic::AtomicUsize>,
}

impl Memory {
    fn new(room: usize) -> Self {
        let memory = Self::default();
        memory.room.store(room, std::sync::atomic::Ordering::Relaxed);
        memory
    }
    fn octets(&self) -> Vec<u8> {
        self.octets.lock().unwrap().clone()
    }
}

impl Write for Memory {
    fn write(&mut self, part: &[u8]) -> io::Result<usize> {
        let mut octets = self.octets.lock().unwrap();
        let room = self.room.load(std::sync::atomic::Ordering::Relaxed) - octets.len();
        if room == 0 && !part.is_empty() {
            return Err(io::ErrorKind::StorageFull.into());
        }
        let n = part.len().min(room);
        octets.extend_from_slice(&part[..n]);
        Ok(n)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Sink for Memory {
    fn cut_to(&mut self, len: u64) -> io::Result<()> {
        self.octets.lock().unwrap().truncate(len as usize);
        Ok(())
    }
}

fn addr(text: &str) -> SocketAddr {
    text.parse().unwrap()
}

/// A recording of `n` datagrams of different lengths, closed.
fn recording(n: usize) -> Vec<u8> {
    let memory = Memory::new(usize::MAX);
    let mut recorder = Recorder::new(memory.clone(), "memory").unwrap();
    for i in 0..n {
        let payload = vec![i as u8; 12 + i % 7];
        let (from, to) = if i % 3 == 0 {
            (addr("[fe80::7]:4001"), addr("[ff02::1:3]:3000"))
        } else {
            (addr("10.0.0.7:4001"), addr("239.1.2.3:3000"))
        };
        let comment = (i == 4).then_some("the fifth");
        recorder
            .record_with(1_700_000_000_123_456_789 + i as i64, from, to, &payload, comment)
            .unwrap();
    }
    recorder.close(0).unwrap();
    memory.octets()
}

#[test]
fn captures_of_other_people_come_out_whole() {
    let sizes = |name: &str| -> (Kind, usize, usize) {
        let reader = Reader::open(data(name)).expect(name);
        let kind = reader.kind();
        let all: Vec<Datagram> = reader.map(|d| d.expect(name)).collect();
        assert!(all.iter().all(|d| d.missing == 0));
        (kind, all.len(), all.iter().map(|d| d.payload.len()).sum())
    };
    assert_eq!(sizes("kdis-log1.pcap").0, Kind::Pcap);
    assert_eq!(sizes("kdis-log1.pcap").1, 88);
    assert_eq!(sizes("opendis7-gaz69-straight.pcap").1, 174);
    assert_eq!(sizes("open-dis-python/SignalPdu.raw"), (Kind::Bare, 1, 1056));
    assert_eq!(sizes("open-dis-python/EntityStatePdu-26.raw"), (Kind::Bare, 1, 144));
}

#[test]
fn what_is_recorded_is_read_to_the_nanosecond() {
    let (good, bad) = read_all(&recording(1000));
    assert!(bad.is_empty(), "{bad:?}");
    assert_eq!(good.len(), 1000);
    for (i, d) in good.iter().enumerate() {
        assert_eq!(d.utc_ns, 1_700_000_000_123_456_789 + i as i64);
        assert_eq!(d.payload, vec![i as u8; 12 + i % 7]);
        assert_eq!(d.from.port(), 4001);
        assert_eq!(d.to.port(), 3000);
        assert_eq!(d.to.is_ipv6(), i % 3 == 0);
        assert_eq!(d.comment.as_deref(), (i == 4).then_some("the fifth"));
    }
}

#[test]
fn a_recording_cut_anywhere_gives_all_before_the_cut_and_says_so() {
    let whole = recording(40);
    let mut ends: Vec<(usize, usize)> = Vec::new();
    for len in (0..whole.len()).step_by(3) {
        let Ok(reader) = Reader::new(Cursor::new(&whole[..len]), "cut", false) else {
            assert!(len < 4, "{len} octets");
            continue;
        };
        let (good, bad): (Vec<_>, Vec<_>) = reader.partition(|d| d.is_ok());
        // Exactly one remark, unless the cut fell between the first blocks.
        assert!(bad.len() <= 1 && (bad.len() == 1 || len < 80), "{len}: {bad:?}");
        if let Some(Err(problem)) = bad.first() {
            assert!(
                matches!(problem, Problem::Cut { .. } | Problem::NotClosed { .. }),
                "{len}: {problem}"
            );
        }
        ends.push((len, good.len()));
    }
    assert!(ends.is_sorted_by_key(|(_, n)| *n), "a longer file never gives less");
    assert_eq!(ends.last().unwrap().1, 40);
}

#[test]
fn a_full_disk_is_told_once_and_the_recording_goes_on_when_there_is_room() {
    let memory = Memory::new(4000);
    let mut recorder = Recorder::new(memory.clone(), "memory").unwrap();
    let mut told = Vec::new();
    for i in 0..100u8 {
        if i == 60 {
            memory.room.store(100_000, std::sync::atomic::Ordering::Relaxed);
        }
        if let Err(e) =
            recorder.record(i64::from(i), addr("10.0.0.7:1"), addr("10.0.0.8:3000"), &[i; 144])
        {
            told.push(e);
        }
        if let Err(e) = recorder.flush() {
            told.push(e);
        }
    }
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(matches!(told[0], RecordError::Write { .. }));
    let (recorded, lost) = (recorder.recorded(), recorder.lost());
    assert_eq!(recorded + lost, 100);
    assert!(lost > 10, "{lost}");
    recorder.close(0).unwrap();
    let (good, bad) = read_all(&memory.octets());
    assert!(bad.is_empty(), "{bad:?}");
    assert_eq!(good.len() as u64, recorded);
    let comments: Vec<_> = good.iter().filter_map(|d| d.comment.as_deref()).collect();
    assert_eq!(comments, [format!("{lost} datagrams before this one could not be written")]);
}

/// Little helpers that write capture files by hand, from the formats' descriptions.
mod by_hand {
    pub(super) fn pcap(
        magic: &[u8; 4],
        big: bool,
        link: u32,
        frames: &[(u32, u32, Vec<u8>)],
    ) -> Vec<u8> {
        let u32o = |v: u32| if big { v.to_be_bytes() } else { v.to_le_bytes() };
        let mut out = magic.to_vec();
        out.extend(if big { [0, 2, 0, 4] } else { [2, 0, 4, 0] });
        for v in [0, 0, 65535, link] {
            out.extend(u32o(v));
        }
        for (s, fraction, frame) in frames {
            for v in [*s, *fraction, frame.len() as u32, frame.len() as u32] {
                out.extend(u32o(v));
            }
            out.extend(frame);
        }
        out
    }

    pub(super) fn udp(payload: &[u8]) -> Vec<u8> {
        let mut out = vec![0x0f, 0xa0, 0x0b, 0xb8];
        out.extend((payload.len() as u16 + 8).to_be_bytes());
        out.extend([0, 0]);
        out.extend(payload);
        out
    }

    pub(super) fn ipv4(body: &[u8], id: u16, place: u16) -> Vec<u8> {
        let mut out = vec![0x45, 0];
        out.extend((body.len() as u16 + 20).to_be_bytes());
        out.extend(id.to_be_bytes());
        out.extend(place.to_be_bytes());
        out.extend([64, 17, 0, 0, 10, 0, 0, 1, 10, 0, 0, 255]);
        out.extend(body);
        out
    }

    pub(super) fn ipv6(body: &[u8], next: u8) -> Vec<u8> {
        let mut out = vec![0x60, 0, 0, 0];
        out.extend((body.len() as u16).to_be_bytes());
        out.extend([next, 64]);
        out.extend([0xfe, 0x80, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]);
        out.extend([0xff, 0x02, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 9]);
        out.extend(body);
        out
    }

    pub(super) fn ethernet(tags: &[u8], ether_type: u16, body: &[u8]) -> Vec<u8> {
        let mut out = vec![0xff; 12];
        out.extend(tags);
        out.extend(ether_type.to_be_bytes());
        out.extend(body);
        out
    }

    pub(super) fn block(big: bool, kind: u32, body: &[u8]) -> Vec<u8> {
        let u32o = |v: u32| if big { v.to_be_bytes() } else { v.to_le_bytes() };
        let mut padded = body.to_vec();
        padded.resize(body.len().next_multiple_of(4), 0);
        let length = u32o(padded.len() as u32 + 12);
        [&u32o(kind)[..], &length, &padded, &length].concat()
    }
}
use by_hand::*;

#[test]
fn every_link_layer_gives_the_same_payload() {
    let payload = b"\x07\x01\x01\x01 a pdu of a kind";
    let v4 = ipv4(&udp(payload), 1, 0);
    let v6 = ipv6(&udp(payload), 17);
    // Options before UDP: hop-by-hop with eight octets.
    let v6_options = ipv6(&[&[17, 0, 1, 4, 0, 0, 0, 0][..], &udp(payload)].concat(), 0);
    let padded = [&ethernet(&[], 0x0800, &v4)[..], &[0; 9]].concat();
    let with = |head: &[u8], body: &[u8]| [head, body].concat();
    let mut sll = vec![0; 14];
    sll.extend([0x08, 0x00]);
    let mut sll_vlan = vec![0; 14];
    sll_vlan.extend([0x81, 0x00, 0, 5, 0x86, 0xdd]);
    let mut sll2 = vec![0x08, 0x00];
    sll2.resize(20, 0);
    let mut sll2_v6 = vec![0x86, 0xdd];
    sll2_v6.resize(20, 0);
    for (name, link, frame) in [
        ("Ethernet", 1, ethernet(&[], 0x0800, &v4)),
        ("Ethernet, padded", 1, padded),
        ("Ethernet, IPv6", 1, ethernet(&[], 0x86dd, &v6)),
        ("Ethernet, IPv6 options", 1, ethernet(&[], 0x86dd, &v6_options)),
        ("VLAN", 1, ethernet(&[0x81, 0x00, 0, 7], 0x0800, &v4)),
        ("VLAN in VLAN", 1, ethernet(&[0x88, 0xa8, 0, 7, 0x81, 0, 0, 9], 0x86dd, &v6)),
        ("Linux cooked", 113, with(&sll, &v4)),
        ("Linux cooked, VLAN, IPv6", 113, with(&sll_vlan, &v6)),
        ("Linux cooked v2", 276, with(&sll2, &v4)),
        ("Linux cooked v2, IPv6", 276, with(&sll2_v6, &v6)),
        ("raw", 101, v4.clone()),
        ("raw of old, IPv6", 12, v6.clone()),
        ("IPv4 only", 228, v4.clone()),
        ("IPv6 only", 229, v6.clone()),
        ("null, little", 0, with(&[2, 0, 0, 0], &v4)),
        ("null, big, IPv6", 0, with(&[0, 0, 0, 30], &v6)),
        ("loop", 108, with(&[0, 0, 0, 2], &v4)),
    ] {
        let file = pcap(&[0xd4, 0xc3, 0xb2, 0xa1], false, link, &[(5, 6, frame)]);
        let (good, bad) = read_all(&file);
        assert!(bad.is_empty(), "{name}: {bad:?}");
        assert_eq!(good.len(), 1, "{name}");
        assert_eq!(good[0].payload, payload, "{name}");
        assert_eq!((good[0].from.port(), good[0].to.port()), (4000, 3000), "{name}");
        let place = good[0].place.expect(name) as usize;
        assert_eq!(&file[place..place + payload.len()], payload, "{name}: place in the file");
    }
}

#[test]
fn stamps_are_right_in_every_order_and_resolution() {
    let frame = ethernet(&[], 0x0800, &ipv4(&udp(b"x"), 1, 0));
    for (name, magic, big, expected) in [
        ("us little", [0xd4, 0xc3, 0xb2, 0xa1], false, 5_000_006_000),
        ("us big", [0xa1, 0xb2, 0xc3, 0xd4], true, 5_000_006_000i64),
        ("ns little", [0x4d, 0x3c, 0xb2, 0xa1], false, 5_000_000_006),
        ("ns big", [0xa1, 0xb2, 0x3c, 0x4d], true, 5_000_000_006),
    ] {
        let (good, _) = read_all(&pcap(&magic, big, 1, &[(5, 6, frame.clone())]));
        assert_eq!(good[0].utc_ns, expected, "{name}");
    }
}

/// A pcapng file with three interfaces: microseconds by default, 2⁻²⁰ s, nanoseconds with an offset.
fn pcapng_by_hand(big: bool) -> Vec<u8> {
    let u16o = |v: u16| if big { v.to_be_bytes() } else { v.to_le_bytes() };
    let u32o = |v: u32| if big { v.to_be_bytes() } else { v.to_le_bytes() };
    let i64o = |v: i64| if big { v.to_be_bytes() } else { v.to_le_bytes() };
    let frame = ethernet(&[], 0x0800, &ipv4(&udp(b"payload"), 1, 0));
    let interface =
        |link: u16, options: &[u8]| [&u16o(link)[..], &[0, 0], &u32o(0), options].concat();
    let packet = |number: u32, ticks: u64, frame: &[u8]| {
        let mut body = Vec::new();
        for v in
            [number, (ticks >> 32) as u32, ticks as u32, frame.len() as u32, frame.len() as u32]
        {
            body.extend(u32o(v));
        }
        body.extend(frame);
        body
    };
    let mut out = Vec::new();
    let section = [&u32o(0x1a2b_3c4d)[..], &u16o(1), &u16o(0), &i64o(-1)].concat();
    out.extend(block(big, 0x0a0d_0d0a, &section));
    out.extend(block(big, 1, &interface(1, &[])));
    let two = [&u16o(9)[..], &u16o(1), &[0x80 | 20, 0, 0, 0], &[0; 4]].concat();
    out.extend(block(big, 1, &interface(101, &two)));
    let ns =
        [&u16o(9)[..], &u16o(1), &[9, 0, 0, 0], &u16o(14), &u16o(8), &i64o(1000), &[0; 4]].concat();
    out.extend(block(big, 1, &interface(1, &ns)));
    out.extend(block(big, 4, &[0; 8]));
    out.extend(block(big, 6, &packet(0, 7_000_001, &frame)));
    out.extend(block(big, 6, &packet(1, 3 << 19, &frame[14..])));
    out.extend(block(big, 0x0bad, &[1, 2, 3, 4]));
    out.extend(block(big, 6, &packet(2, 12, &frame)));
    let simple = [&u32o(frame.len() as u32)[..], &frame].concat();
    out.extend(block(big, 3, &simple));
    out
}

#[test]
fn pcapng_with_several_interfaces_and_unknown_blocks() {
    for big in [false, true] {
        let (good, bad) = read_all(&pcapng_by_hand(big));
        assert!(bad.is_empty(), "{bad:?}");
        let stamps: Vec<_> = good.iter().map(|d| (d.interface, d.utc_ns)).collect();
        assert_eq!(
            stamps,
            [(0, 7_000_001_000), (1, 1_500_000_000), (2, 1_000_000_000_012), (0, 0)],
            "big {big}"
        );
        assert!(good.iter().all(|d| d.payload == b"payload"));
        // A second section in the other order is a file of its own behind the first.
        let both = [pcapng_by_hand(big), pcapng_by_hand(!big)].concat();
        assert_eq!(read_all(&both).0.len(), 8);
    }
}

#[test]
fn fragments_become_the_datagram_or_a_remark() {
    let payload: Vec<u8> = (0..3000u32).map(|i| i as u8).collect();
    let whole = udp(&payload);
    let pieces = [
        (1, 1, ipv4(&whole[..1480], 9, 0x2000)),
        (2, 2, ipv4(&whole[2960..], 9, 2960 / 8)),
        (3, 3, ipv4(&udp(b"between"), 10, 0)),
        (4, 4, ipv4(&whole[1480..2960], 9, 0x2000 | (1480 / 8))),
        (5, 5, ipv4(&whole[..1480], 11, 0x2000)),
    ];
    let (good, bad) = read_all(&pcap(&[0xd4, 0xc3, 0xb2, 0xa1], false, 101, &pieces));
    assert_eq!(good.len(), 2);
    assert_eq!(good[0].payload, b"between");
    assert_eq!(good[1].payload, payload);
    assert_eq!((good[1].frame, good[1].place), (1, None));
    assert_eq!(bad.len(), 1);
    assert!(
        matches!(
            bad[0],
            Problem::Frame { frame: 5, fault: FrameFault::Unfinished { id: 11, have: 1480 }, .. }
        ),
        "{bad:?}"
    );
    // The same over IPv6.
    let piece = |place: u16, part: &[u8]| {
        let head = [&[17, 0][..], &place.to_be_bytes(), &[0, 0, 0, 77]].concat();
        ipv6(&[&head[..], part].concat(), 44)
    };
    let pieces = [(1, 1, piece(1, &whole[..1480])), (2, 2, piece(1480, &whole[1480..]))];
    let (good, bad) = read_all(&pcap(&[0xd4, 0xc3, 0xb2, 0xa1], false, 101, &pieces));
    assert!(bad.is_empty());
    assert_eq!(good[0].payload, payload);
}

#[test]
fn damage_in_the_middle_is_told_and_passed_over() {
    let whole = recording(30);
    let (all, _) = read_all(&whole);
    let at = all[10].place.unwrap() as usize - 42 - 28;
    for octet in 4..8 {
        let mut damaged = whole.clone();
        damaged[at + octet] ^= 0x55;
        let (good, bad) = read_all(&damaged);
        assert_eq!((good.len(), bad.len()), (29, 1), "octet {octet} of the length: {bad:?}");
        assert!(matches!(bad[0], Problem::Block { .. }), "{bad:?}");
    }
    let mut damaged = whole.clone();
    damaged[at - 4] ^= 0x55;
    let (good, bad) = read_all(&damaged);
    assert_eq!((good.len(), bad.len()), (29, 1), "trailing length: {bad:?}");
    assert!(matches!(bad[0], Problem::Block { fault: BlockFault::Lengths { .. }, .. }), "{bad:?}");
    // Octets put in between: found again although nothing is aligned any more.
    let mut damaged = whole.clone();
    damaged.splice(at..at, [0xaa; 7]);
    let (good, bad) = read_all(&damaged);
    assert_eq!((good.len(), bad.len()), (30, 1), "{bad:?}");
}

#[test]
fn frames_cut_by_the_capture_and_foreign_frames() {
    let frame = ethernet(&[], 0x0800, &ipv4(&udp(&[7; 100]), 1, 0));
    let mut file = pcap(&[0xd4, 0xc3, 0xb2, 0xa1], false, 1, &[(1, 1, frame[..92].to_vec())]);
    let at = 24 + 12;
    file[at..at + 4].copy_from_slice(&(frame.len() as u32).to_le_bytes());
    let (good, bad) = read_all(&file);
    assert!(bad.is_empty());
    assert_eq!((good[0].payload.len(), good[0].missing), (50, 50));
    for (name, frame, problems) in [
        ("ARP", ethernet(&[], 0x0806, &[0; 28]), 0),
        (
            "TCP",
            ethernet(&[], 0x0800, &[&[0x45, 0, 0, 40, 0, 0, 0, 0, 64, 6][..], &[0; 30]].concat()),
            0,
        ),
        ("IPv4 cut", ethernet(&[], 0x0800, &[0x45, 0, 0]), 1),
        ("IP version 9", ethernet(&[], 0x0800, &[0x95; 40]), 1),
        ("no Ethernet header", vec![1, 2, 3], 1),
        ("empty", vec![], 1),
    ] {
        let (good, bad) = read_all(&pcap(&[0xd4, 0xc3, 0xb2, 0xa1], false, 1, &[(1, 1, frame)]));
        assert_eq!((good.len(), bad.len()), (0, problems), "{name}: {bad:?}");
    }
}

#[test]
fn bare_pdus_are_cut_by_their_length() {
    let one = std::fs::read(data("open-dis-python/EntityStatePdu-26.raw")).unwrap();
    let two = std::fs::read(data("open-dis-python/SetDataPdu-vbs-script-cmd.raw")).unwrap();
    let (good, bad) = read_all(&[&one[..], &two, &one[..100]].concat());
    assert!(bad.is_empty());
    let sizes: Vec<_> = good.iter().map(|d| (d.payload.len(), d.missing)).collect();
    assert_eq!(sizes, [(144, 0), (56, 0), (100, 44)]);
}

#[test]
fn files_of_another_kind_are_refused_with_a_reason() {
    for (octets, expected) in [
        (&[][..], "the file is empty"),
        (&[0x1f, 0x8b, 8, 0], "compressed with gzip"),
        (b"PK\x03\x04", "no DIS header"),
        (b"{\"json\": true}", "no DIS header"),
    ] {
        let error = Reader::new(Cursor::new(octets), "f", false).map(|_| ()).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
    let error = Reader::open("/no/such/file.pcap").map(|_| ()).unwrap_err();
    assert!(error.to_string().starts_with("/no/such/file.pcap: "), "{error}");
}

proptest::proptest! {
    #[test]
    fn any_octets_end_without_a_panic(mut octets in proptest::collection::vec(0u8.., 0..2000), kind in 0..4) {
        let head: &[u8] = match kind {
            0 => &[0xd4, 0xc3, 0xb2, 0xa1, 2, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 1, 0, 0, 0],
            1 => &[0x0a, 0x0d, 0x0d, 0x0a, 28, 0, 0, 0, 0x4d, 0x3c, 0x2b, 0x1a],
            2 => &[7, 1, 1, 1],
            _ => &[],
        };
        octets.splice(0..0, head.iter().copied());
        if let Ok(reader) = Reader::new(Cursor::new(&octets), "any", true) {
            assert!(reader.count() <= octets.len() + 2);
        }
    }

    #[test]
    fn any_frame_of_any_link_type_ends_without_a_panic(
        frames in proptest::collection::vec(
            (0usize..8, proptest::collection::vec((0usize..90, 0u8..), 0..6), 0usize..120), 1..12),
        link in 0usize..9,
    ) {
        let payload = [7, 1, 1, 1, 0, 0, 0, 0, 0, 20, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8];
        let v4 = ipv4(&udp(&payload), 1, 0);
        let v6 = ipv6(&udp(&payload), 17);
        let frame = |kind: usize| match kind {
            0 => ethernet(&[], 0x0800, &v4),
            1 => ethernet(&[0x81, 0x00, 0, 7], 0x86dd, &v6),
            2 => ethernet(&[], 0x0800, &ipv4(&udp(&payload), 9, 0x2000)),
            3 => ethernet(&[], 0x0800, &ipv4(&payload, 9, 3)),
            4 => ethernet(&[], 0x86dd, &ipv6(&[17, 0, 1, 4, 0, 0, 0, 0], 0)),
            5 => ethernet(&[], 0x86dd, &ipv6(&[17, 0, 0, 1, 0, 0, 0, 7, 1, 2, 3], 44)),
            6 => v4.clone(),
            _ => v6.clone(),
        };
        let frames: Vec<_> = frames
            .into_iter()
            .map(|(kind, hits, len)| {
                let mut octets = frame(kind);
                for (at, value) in hits {
                    let len = octets.len();
                    octets[at % len] = value;
                }
                octets.truncate(len);
                (0, 0, octets)
            })
            .collect();
        let link = [1, 1, 1, 113, 276, 101, 0, 108, 228][link];
        let file = pcap(&[0xd4, 0xc3, 0xb2, 0xa1], false, link, &frames);
        let (good, bad) = read_all(&file);
        assert!(good.len() + bad.len() <= 2 * frames.len());
        for d in good {
            if let Some(place) = d.place {
                assert_eq!(&file[place as usize..place as usize + d.payload.len()], d.payload);
            }
        }
    }

    #[test]
    fn any_damage_to_a_recording_ends_without_a_panic(hits in proptest::collection::vec((0usize..4000, 0u8..), 1..20)) {
        let mut file = recording(30);
        let len = file.len();
        for (at, value) in hits {
            file[at % len] = value;
        }
        if let Ok(reader) = Reader::new(Cursor::new(&file), "any", true) {
            let found = reader.filter(|d| d.is_ok()).count();
            assert!(found <= 30);
        }
    }
}
