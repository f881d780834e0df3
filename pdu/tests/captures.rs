//! Real traffic: every PDU is sound, is read with typed fields, and comes back octet by octet.

mod common;

use pdu::{Body, pdus};
use std::collections::BTreeMap;

fn check(name: &str, expected: &[(u8, usize)]) {
    let mut counts = BTreeMap::new();
    for (number, datagram) in common::datagrams(name).iter().enumerate() {
        let mut walked = 0;
        for received in pdus(datagram) {
            let received = received.unwrap_or_else(|e| panic!("{name}, datagram {number}: {e}"));
            assert!(
                !matches!(received.body(), Body::Raw(_))
                    || [2, 3, 25, 72].contains(&received.header().pdu_type.0),
                "{name}, datagram {number}: raw {}",
                received.header().pdu_type
            );
            assert_eq!(
                received.encode_to_vec().as_deref(),
                Ok(received.octets),
                "{name}, datagram {number}, PDU {}",
                received.index
            );
            *counts.entry(received.header().pdu_type.0).or_insert(0) += 1;
            walked += received.octets.len();
        }
        assert_eq!(walked, datagram.len(), "{name}, datagram {number}");
    }
    assert_eq!(counts.into_iter().collect::<Vec<_>>(), expected, "{name}: PDUs by type");
}

#[test]
fn vr_forces_of_2007_speaks_dis_5() {
    check("kdis-log1.pcap", &[(1, 60), (2, 1), (3, 1), (20, 20), (41, 6)]);
}

#[test]
fn vr_forces_bundles_dis_7() {
    check("opendis7-gaz69-straight.pcap", &[(1, 116), (20, 16), (25, 13), (41, 29), (72, 126)]);
}
