use super::*;
use proptest::prelude::*;

fn small() -> Index {
    let entry = |n: u64| Entry {
        utc_ns: n as i64 * 10,
        place: n * 100,
        len: 12,
        pair: 0,
        stamp: 2 * n as u32,
    };
    let here: SocketAddr = "10.0.0.1:3000".parse().unwrap();
    let there: SocketAddr = "[ff02::1]:3000".parse().unwrap();
    let key = |entity| StateKey {
        exercise: 1,
        pdu_type: 1,
        id: EntityId { site: 1, application: 2, entity },
        part: 0,
    };
    let at = |datagram, offset| State { datagram, offset };
    Index {
        entries: (0..100)
            .map(entry)
            .chain([Entry { utc_ns: 990, place: IN_BLOB | 4, len: 8, pair: 0, stamp: NO_STAMP }])
            .collect(),
        pairs: vec![(here, there)],
        blob: (0..12).collect(),
        states: BTreeMap::from([
            (key(7), vec![at(3, 0), at(10, 144), at(20, GONE)]),
            (key(8), vec![at(5, 0), at(90, 0)]),
        ]),
        remarks: vec!["a remark".to_owned()],
        problems: 3,
    }
}

const IDENTITY: Identity = Identity { octets: 1, modified_ns: 2, ends: 3 };

#[test]
fn an_index_comes_back_from_its_octets_and_only_for_its_recording() {
    let octets = small().to_octets(IDENTITY);
    assert_eq!(Index::from_octets(&octets, IDENTITY), Some(small()));
    assert_eq!(Index::from_octets(&octets, Identity { modified_ns: 9, ..IDENTITY }), None);
    for len in 0..octets.len() {
        assert_eq!(Index::from_octets(&octets[..len], IDENTITY), None, "cut to {len}");
    }
    for at in 0..octets.len() {
        let mut damaged = octets.clone();
        damaged[at] ^= 0x10;
        assert_eq!(Index::from_octets(&damaged, IDENTITY), None, "octet {at}");
    }
}

#[test]
fn alive_is_who_was_told_lately_and_not_removed() {
    let alive = |number: usize, utc_ns: i64, lasting_ns: i64| -> Vec<(u32, u32)> {
        small().alive(number, utc_ns, lasting_ns).iter().map(|s| (s.datagram, s.offset)).collect()
    };
    assert_eq!(alive(0, 0, 50), []);
    assert_eq!(alive(4, 40, 50), [(3, 0)]);
    assert_eq!(alive(15, 150, 200), [(5, 0), (10, 144)], "the latest of each");
    assert_eq!(alive(25, 250, 300), [(5, 0)], "one was removed");
    assert_eq!(alive(60, 600, 100), [(5, 0)], "a slow heartbeat: told again within 12 time-outs");
    assert_eq!(alive(60, 600, 50), [], "timed out: the next state is too far away");
}

proptest! {
    #[test]
    fn any_octets_are_an_index_or_none(octets in proptest::collection::vec(0u8.., 0..600)) {
        let mut whole = MAGIC.to_vec();
        whole.extend_from_slice(&octets);
        let mut sum = Checksum::default();
        sum.add(&whole);
        whole.extend_from_slice(&sum.0.to_le_bytes());
        prop_assert!(Index::from_octets(&whole, IDENTITY).is_none());
    }
}
