//! Who a visitor is, from its IFF to the reports of sensors in ASTERIX.

use super::visitor_tests::{drive, guest, stamped};
use crate::exchange::stamp;
use crate::gateway::{Choice, Gateway};
use crate::runtime::codec::decode;
use crate::runtime::frame_time::FrameTime;
use crate::runtime::messages::ScanReport;
use asterix::{cat020, cat021};
use pdu::exercise::Transponder;
use pdu::records::EntityId;
use pdu::{EntityState, Envelope};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Two visitors, one with a call sign of six hexadecimal digits: in each report of multilateration and ADS-B both have the address
/// and the call sign that their transponders say, and truth says the addresses.
#[test]
fn a_visitor_is_reported_with_the_address_and_the_call_sign_of_its_transponder() {
    let path = scenarios::locate("asmgcs");
    let text = scenarios::text_of(&path).expect("the scene");
    let named = text.lines().position(|l| l == "name = \"ADS-B\"").expect("an ADS-B sensor");
    let lines = text.lines().enumerate().filter(|(n, _)| *n != named + 1).map(|(_, line)| line);
    let text: String = lines.flat_map(|line| [line, "\n"]).collect();
    let scene = Arc::new(scenarios::load_text(&path, &text).expect("everybody has ADS-B"));
    let guests = [(1, "SWR99Z", 0x4b_1234), (2, "FDB123", 0x89_6001)];
    let time = FrameTime::of(&scene.run);
    let visits = |frame: u64| {
        let envelope = Envelope::new(1, time.stamp(frame));
        let due = guests.iter().filter(|_| frame >= 40 && frame.is_multiple_of(20));
        let pdus = due.flat_map(|(entity, name, address)| {
            let id = EntityId::new(900, 9, *entity);
            let place_m = [-900.0 + 300.0 * f64::from(*entity), -2600.0, 0.0];
            let state = EntityState { entity_id: id, ..guest(&scene, place_m, [0.0; 3], true) };
            let transponder = Transponder {
                on: true,
                address: Some(*address),
                identification: Some(Transponder::identification_of(name)),
                ..Transponder::default()
            };
            let at_s = frame as f64 * 0.05;
            [stamped(&scene, at_s, 0.0, &state), stamped(&scene, at_s, 0.0, &transponder.iff(id))]
        });
        pdus.map(|s| stamp::encode(scene.run.site, &envelope, &s).expect("fits")).collect()
    };
    let mut reports: Vec<ScanReport> = Vec::new();
    drive(&scene, 15, visits, |out| {
        let scan = out.publish.iter().find(|p| p.key == "tracks/1/scan").expect("published");
        reports.push(decode(&scan.body).expect("sound"));
    });
    let truth = reports.iter().flat_map(|r| &r.truth).filter(|t| !t.ours);
    let truth: BTreeSet<(&str, Option<u32>)> =
        truth.map(|t| (t.callsign.as_str(), t.address)).collect();
    assert!(truth.contains(&("SWR99Z", Some(0x4b_1234))), "{truth:?}");
    assert!(truth.contains(&("FDB123", Some(0x89_6001))), "{truth:?}");
    let mut gateway = Gateway::new(&scene, Choice::default());
    let mut said: BTreeMap<(u8, String), BTreeSet<Option<u32>>> = BTreeMap::new();
    for report in &reports {
        for datagram in gateway.on_scan(report) {
            let blocks = asterix::blocks(&datagram).map(|b| b.expect("sound"));
            for record in blocks.flat_map(|b| b.records()).map(|r| r.expect("sound")) {
                let (name, address) = match record.category.number {
                    20 => (record.get(&cat020::I245), record.number(&cat020::I220)),
                    21 => (record.get(&cat021::I170), record.number(&cat021::I080)),
                    _ => continue,
                };
                let Some(name) = name.and_then(|view| view.text()) else { continue };
                let of = (record.category.number, name.as_str().to_owned());
                said.entry(of).or_default().insert(address.map(|a| a as u32));
            }
        }
    }
    for category in [20, 21] {
        for (_, name, address) in guests {
            let found = said.get(&(category, name.to_owned()));
            let expected = BTreeSet::from([Some(address)]);
            assert_eq!(found, Some(&expected), "{category} {name}: {said:?}");
        }
    }
}
