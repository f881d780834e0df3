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
            let typed = !matches!(received.body(), Body::Raw(_));
            assert!(typed, "{name}, datagram {number}: {}", received.header().pdu_type);
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

#[test]
fn single_pdus_of_open_dis() {
    for (file, pdu_type) in [
        ("ElectromagneticEmissionPdu-single-system.raw", 23),
        ("EntityStatePdu-26.raw", 1),
        ("SetDataPdu-multi-variable-datums.raw", 19),
        ("SetDataPdu-vbs-script-cmd.raw", 19),
        ("SignalPdu.raw", 26),
        ("TransmitterPdu.raw", 25),
    ] {
        let octets = std::fs::read(common::data("open-dis-python").join(file)).expect(file);
        let mut walk = pdus(&octets);
        let received = walk.next().expect(file).unwrap_or_else(|e| panic!("{file}: {e}"));
        assert!(!matches!(received.body(), Body::Raw(_)), "{file}");
        assert_eq!(received.header().pdu_type.0, pdu_type, "{file}");
        assert_eq!(received.encode_to_vec().as_ref(), Ok(&octets), "{file}");
        assert!(walk.next().is_none(), "{file}");
    }
}

/// The values of a row; several in one cell stand in one string.
fn cells(row: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut quoted = false;
    for c in row.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            c => cells.last_mut().expect("one at least").push(c),
        }
    }
    cells
}

#[test]
fn fields_are_those_that_tshark_prints() {
    let table = std::fs::read_to_string(common::data("kdis-log1.csv")).expect("kdis-log1.csv");
    let mut rows = table.lines();
    let columns = cells(rows.next().expect("names"));
    let column = |name: &str| columns.iter().position(|c| c == name).expect("column");
    let mut entity_states = 0;
    for (row, datagram) in rows.zip(common::datagrams("kdis-log1.pcap")) {
        let row = cells(row);
        let close = |name: &str, ours: f64, tolerance: f64| {
            let theirs: f64 = row[column(name)].parse().expect(name);
            assert!((ours - theirs).abs() <= tolerance, "{name}: {ours} for {theirs}");
        };
        let received = pdus(&datagram).next().expect("a PDU").expect("sound");
        let header = received.header();
        close("dis.proto_ver", header.version.0.into(), 0.0);
        close("dis.exer_id", header.exercise_id.into(), 0.0);
        close("dis.pdu_type", header.pdu_type.0.into(), 0.0);
        close("dis.proto_fam", header.family.0.into(), 0.0);
        close("dis.pdu_length", header.length.into(), 0.0);
        close("dis.timestamp", header.timestamp.nanos_past_hour() as f64 * 1e-9, 2e-6);
        if let Body::EntityState(state) = received.body() {
            entity_states += 1;
            close("dis.entity_id_site", state.entity_id.site.into(), 0.0);
            close("dis.entity_id_application", state.entity_id.application.into(), 0.0);
            close("dis.entity_id_entity", state.entity_id.entity.into(), 0.0);
            close("dis.force_id", state.force_id.0.into(), 0.0);
            let printed = |v: f64| 1e-5 * v.abs().max(1.0);
            let v = state.linear_velocity_mps.to_f64();
            close("dis.entity_linear_velocity.x", v[0], printed(v[0]));
            close("dis.entity_linear_velocity.y", v[1], printed(v[1]));
            close("dis.entity_linear_velocity.z", v[2], printed(v[2]));
            close("dis.entity_location.x", state.location.x_m, 1e-3);
            close("dis.entity_location.y", state.location.y_m, 1e-3);
            close("dis.entity_location.z", state.location.z_m, 1e-3);
            let o = state.orientation;
            close("dis.entity_orientation.psi", o.psi_rad.into(), 1e-5);
            close("dis.entity_orientation.theta", o.theta_rad.into(), 1e-5);
            close("dis.entity_orientation.phi", o.phi_rad.into(), 1e-5);
        }
    }
    assert_eq!(entity_states, 60);
}
