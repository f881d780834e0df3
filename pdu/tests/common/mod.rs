//! What several tests need: recorded traffic, samples of every type, the law for any octets.

#![allow(dead_code, reason = "each test uses a part")]

pub(crate) mod any_bytes;
pub(crate) mod samples;

use std::path::PathBuf;

/// A file of `tests/data`.
pub(crate) fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// The UDP payloads of a little-endian pcap file of Ethernet, IPv4 without options.
pub(crate) fn datagrams(name: &str) -> Vec<Vec<u8>> {
    let file = std::fs::read(data(name)).expect(name);
    assert_eq!(file[..4], [0xd4, 0xc3, 0xb2, 0xa1], "{name}: pcap, little-endian, microseconds");
    let mut found = Vec::new();
    let mut at = 24;
    while at < file.len() {
        let captured =
            u32::from_le_bytes(file[at + 8..at + 12].try_into().expect("four octets")) as usize;
        let packet = &file[at + 16..at + 16 + captured];
        at += 16 + captured;
        assert_eq!((packet[12..14].to_vec(), packet[14], packet[23]), (vec![8, 0], 0x45, 17));
        let udp_len = usize::from(u16::from_be_bytes([packet[38], packet[39]]));
        found.push(packet[42..42 + udp_len - 8].to_vec());
    }
    found
}
