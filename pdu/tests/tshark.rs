//! tshark's dissector takes a PDU of every type that we write, without a word about malformed octets.
//! Runs where tshark is installed.

mod common;

use common::samples;
use pdu::{Body, Envelope, Header, List, Pdu};
use std::process::Command;

/// A pcap file of Ethernet, IPv4, UDP port 3000, one datagram a PDU.
fn pcap(datagrams: &[Vec<u8>]) -> Vec<u8> {
    let mut file = Vec::new();
    file.extend([0xd4, 0xc3, 0xb2, 0xa1, 2, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    file.extend([0xff, 0xff, 0, 0, 1, 0, 0, 0]);
    for (number, octets) in datagrams.iter().enumerate() {
        let udp = 8 + octets.len();
        let ip = 20 + udp;
        let mut packet = vec![0xff; 6];
        packet.extend([2, 0, 0, 0, 0, 1, 8, 0]);
        packet.extend([0x45, 0, (ip >> 8) as u8, ip as u8, 0, 0, 0, 0, 1, 17, 0, 0]);
        packet.extend([127, 0, 0, 1, 127, 255, 255, 255]);
        packet.extend([0x0b, 0xb8, 0x0b, 0xb8, (udp >> 8) as u8, udp as u8, 0, 0]);
        packet.extend(octets);
        file.extend(u32::to_le_bytes(number as u32));
        file.extend([0; 4]);
        file.extend(u32::to_le_bytes(packet.len() as u32));
        file.extend(u32::to_le_bytes(packet.len() as u32));
        file.extend(packet);
    }
    file
}

#[test]
fn nothing_that_we_write_is_malformed() {
    if Command::new("tshark").arg("--version").output().is_err() {
        println!("skipped: tshark is not installed");
        return;
    }
    let mut written = Vec::new();
    let mut types = Vec::new();
    for pdu in samples::pdus() {
        let long = matches!(pdu.body(), Body::ActionRequestR(a) if a.unused.is_some());
        if long {
            continue; // The longer form is only read, for those who write it.
        }
        let header = *pdu.header();
        let pdu = match pdu.into_body() {
            // tshark 4.0 counts the silent types but does not walk over them.
            Body::AggregateState(mut aggregate) => {
                aggregate.silent_aggregates = List::default();
                aggregate.silent_entities = List::default();
                Pdu::new(Envelope::new(header.exercise_id, header.timestamp), aggregate)
            }
            body => {
                let Header { version, exercise_id, timestamp, status, .. } = header;
                Pdu::new(Envelope { version, exercise_id, timestamp, status }, body)
            }
        };
        types.push(header.pdu_type);
        written.push(pdu.encode_to_vec().expect("a sample fits"));
    }
    let file = std::env::temp_dir().join(format!("pdu-tshark-{}.pcap", std::process::id()));
    std::fs::write(&file, pcap(&written)).expect("temporary file");
    let output = Command::new("tshark")
        .args(["-r", &file.display().to_string(), "-d", "udp.port==3000,dis", "-T", "fields"])
        .args(["-e", "dis.pdu_type", "-e", "_ws.malformed", "-e", "dis.pdu_length"])
        .output()
        .expect("tshark runs");
    std::fs::remove_file(&file).expect("temporary file");
    let text = String::from_utf8_lossy(&output.stdout);
    let rows: Vec<&str> = text.lines().collect();
    assert_eq!(rows.len(), written.len(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut malformed = Vec::new();
    for ((row, pdu_type), octets) in rows.iter().zip(&types).zip(&written) {
        let mut cells = row.split('\t');
        assert_eq!(cells.next(), Some(pdu_type.0.to_string().as_str()), "{row}");
        if cells.next().is_some_and(|cell| !cell.is_empty()) {
            malformed.push(pdu_type);
        }
        assert_eq!(cells.next(), Some(octets.len().to_string().as_str()), "{row}");
    }
    assert!(malformed.is_empty(), "tshark finds malformed: {malformed:?}");
}
