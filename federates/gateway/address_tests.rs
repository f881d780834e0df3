//! Whose address goes out: of visitors, of who has none, of call signs that look like one.

use super::adsb::Origin;
use super::board::Board;
use super::tests::{plot, read, report, scene, track};
use super::*;
use crate::runtime::messages::{PlotMessage, TruthMessage};
use asterix::{cat011, cat020, cat021, cat062};
use models::frames::Point3;
use std::sync::Arc;

/// A gateway with a multilateration and an ADS-B sensor beside those of the scene.
fn gateway() -> Gateway {
    let mut gateway = Gateway::new(&scene(), Choice::default());
    gateway.sources.push(Source { sic: 8, kind: SensorKind::Mlat });
    gateway.sources.push(Source { sic: 9, kind: SensorKind::Adsb });
    gateway
}

/// What a sensor was told: who, and his address.
fn told(sensor: u16, identity: &str, address: Option<u32>) -> PlotMessage {
    let kind = if sensor == 8 { SensorKind::Mlat } else { SensorKind::Adsb };
    PlotMessage { kind, identity: identity.into(), address, ..plot(sensor, 500_000_000) }
}

/// Kind of address, address and call sign of each report of category 021.
fn said_021(sent: &[Vec<u8>]) -> Vec<(f64, f64, String)> {
    read(sent, |r| {
        let address = r.number(&cat021::I080)?;
        let name = r.get(&cat021::I170).and_then(|v| v.text()).unwrap_or_default();
        Some((r.number(&cat021::I040)?, address, name.as_str().to_owned()))
    })
}

#[test]
fn visitors_have_their_own_addresses_and_call_signs_in_every_report() {
    let mut gateway = gateway();
    let both = [("SWR99Z", 0x4b_1234), ("FDB123", 0x89_6001)];
    let plots = [8, 9]
        .into_iter()
        .flat_map(|sensor| both.map(|(name, address)| told(sensor, name, Some(address))));
    let sent = gateway.on_scan(&report(1, vec![], plots.collect()));
    let expected = both.map(|(name, address)| (0.0, f64::from(address), name.to_owned()));
    assert_eq!(said_021(&sent), expected);
    let of_020 = read(&sent, |r| {
        let name = r.get(&cat020::I245)?.text()?;
        Some((0.0, r.number(&cat020::I220)?, name.as_str().to_owned()))
    });
    assert_eq!(of_020, expected);
    // Who says his address alone has no call sign.
    let alone = told(9, "4B1234", Some(0x4b_1234));
    let sent = gateway.on_scan(&report(2, vec![], vec![alone]));
    assert_eq!(said_021(&sent), [(0.0, f64::from(0x4b_1234), String::new())]);
    assert!(gateway.refused().is_empty(), "{:?}", gateway.refused());
}

#[test]
fn a_call_sign_of_six_digits_is_no_address_and_nobody_has_address_zero() {
    let mut gateway = gateway();
    // The address of a flight as somebody's call sign makes him no such flight.
    gateway.on_flights(vec![super::tests::flight(
        "SWR1",
        Some(0xfd_b123),
        models::flight_list::MovementKind::Arrival,
    )]);
    let names = ["FDB123", "N172SP", "ABCDEF"];
    let scan = |n| report(n, vec![], names.map(|name| told(9, name, None)).to_vec());
    let (first, second) = (gateway.on_scan(&scan(1)), gateway.on_scan(&scan(2)));
    let said = said_021(&first);
    assert_eq!(said, said_021(&second), "an address stays with who was given it");
    let addresses: BTreeSet<u32> = said.iter().map(|(_, address, _)| *address as u32).collect();
    assert_eq!(addresses.len(), 3, "{said:?}");
    for ((kind, address, name), wanted) in said.iter().zip(names) {
        assert_eq!((*kind, name.as_str()), (3.0, wanted), "anonymous");
        assert!(*address >= f64::from(0xf0_0000), "{address}");
    }
    // Who says nothing at all of himself is not an aircraft of ICAO's list either.
    let sent = gateway.on_scan(&report(3, vec![], vec![told(9, "", None)]));
    assert_eq!(said_021(&sent), [(3.0, 0.0, String::new())]);
}

#[test]
fn a_track_has_the_address_that_its_target_told() {
    let mut gateway = gateway();
    let named = |number, callsign: &str, address| TrackMessage {
        callsign: callsign.into(),
        address,
        ..track(number, 1_000_000_000)
    };
    // One told call sign and address, one its address alone, one neither.
    let tracks =
        vec![named(1, "SWR99Z", None), named(2, "", Some(0x89_6001)), named(3, "SWR8", None)];
    let addresses = |sent: &[Vec<u8>]| -> [Vec<(f64, Option<f64>)>; 2] {
        let of = |number, item, sub| {
            read(sent, |r| {
                let address = r.get(item).and_then(|v| v.sub(sub)?.data().next()?.number());
                Some((r.number(number)?, address))
            })
        };
        [
            of(&cat062::I040, &cat062::I380, &cat062::I380_ADR),
            of(&cat011::I161, &cat011::I380, &cat011::I380_ADR),
        ]
    };
    let expected =
        vec![(1.0, Some(f64::from(0x4b_1234))), (2.0, Some(f64::from(0x89_6001))), (3.0, None)];
    let plots = vec![told(8, "SWR99Z", Some(0x4b_1234))];
    let sent = gateway.on_scan(&report(1, tracks.clone(), plots));
    assert_eq!(addresses(&sent), [expected.clone(), expected.clone()]);
    // Also in scans in which nothing was heard of it; not in another run.
    let sent = gateway.on_scan(&report(2, tracks.clone(), vec![]));
    assert_eq!(addresses(&sent)[0], expected);
    let sent = gateway.on_scan(&ScanReport { run: 2, ..report(1, tracks, vec![]) });
    assert_eq!(addresses(&sent)[0][0], (1.0, None));
}

/// An entity of somebody.
fn guest(id: [u16; 3], callsign: &str, address: Option<u32>) -> TruthMessage {
    TruthMessage {
        id,
        callsign: callsign.into(),
        address,
        type_designator: "A320".into(),
        aircraft: true,
        size_m: [37.6, 34.1],
        position_m: Point3::new(100.0 * f64::from(id[1] % 10), 0.0, 0.0),
        velocity_mps: [10.0, 0.0, 0.0],
        heading_rad: 1.57,
        ours: false,
        track: None,
    }
}

/// Address and call sign of everybody in `aircraft.json`.
fn aircraft(board: &Board, number: u64, truth: &[TruthMessage]) -> Vec<(String, String)> {
    let scan = ScanReport { truth: truth.to_vec(), ..report(number, vec![], vec![]) };
    board.on_scan(&Arc::new(scan));
    let json = board.value("aircraft.json").expect("there");
    let list = json["aircraft"].as_array().expect("a list");
    let text =
        |entry: &serde_json::Value, key: &str| entry[key].as_str().expect(key).trim().to_owned();
    list.iter().map(|entry| (text(entry, "hex"), text(entry, "flight"))).collect()
}

#[test]
fn squitters_of_a_visitor_carry_its_own_address() {
    let guests = [
        guest([300, 300, 1], "SWR99Z", Some(0x4b_1234)),
        guest([301, 1, 1], "FDB123", Some(0x89_6001)),
        guest([301, 1, 2], "N172SP", None),
    ];
    let board = Board::new(&scene(), 1, false);
    let own = [("4b1234", "SWR99Z"), ("896001", "FDB123")].map(|(a, b)| (a.into(), b.into()));
    assert_eq!(aircraft(&board, 1, &guests), own);
    // By what ADS-B sensors were told, the same.
    let board = Board::new(&scene(), 1, false).sending(Origin::Reports);
    let heard = guests.iter().map(|g| told(9, &g.callsign, g.address)).collect();
    board.on_scan(&Arc::new(report(1, vec![], heard)));
    let json = board.value("aircraft.json").expect("there");
    let list = json["aircraft"].as_array().expect("a list");
    let heard: Vec<(String, String)> = list
        .iter()
        .map(|a| {
            let text = |key: &str| a[key].as_str().expect(key).trim().to_owned();
            (text("hex"), text("flight"))
        })
        .collect();
    assert_eq!(heard, own);
}

#[test]
fn invented_addresses_are_of_one_target_each_and_stay_his() {
    let board = Board::new(&scene(), 1, true);
    // Two of the same entity number, one whose wish the second would take next.
    let guests =
        [[300, 300, 1], [301, 1, 1], [301, 1, 2]].map(|id| guest(id, &format!("G{}", id[1]), None));
    let first = aircraft(&board, 1, &guests);
    let addresses: BTreeSet<&String> = first.iter().map(|(hex, _)| hex).collect();
    assert_eq!((first.len(), addresses.len()), (3, 3), "{first:?}");
    assert!(first.iter().all(|(hex, _)| hex.starts_with("~f0000")), "{first:?}");
    // The first leaves and comes back: nobody's address changes.
    assert_eq!(aircraft(&board, 2, &guests[1..]), first[1..]);
    assert_eq!(aircraft(&board, 3, &guests), first);
}

/// Every record of every category says the area code that was asked for, beside the code of its own source.
#[test]
fn all_that_is_sent_says_the_area_code() {
    for sac in [0, 25, 255] {
        let mut gateway = Gateway::new(&scene(), Choice { sac, ..Choice::default() });
        gateway.sources.push(Source { sic: 8, kind: SensorKind::Mlat });
        gateway.sources.push(Source { sic: 9, kind: SensorKind::Adsb });
        let plots = vec![told(8, "SWR99Z", None), told(9, "SWR99Z", None), plot(1, 500_000_000)];
        let sent = gateway.on_scan(&report(1, vec![track(7, 900_000_000)], plots));
        let said = read(&sent, |r| Some((r.category.number, r.source()?)));
        let categories: std::collections::BTreeSet<u8> = said.iter().map(|s| s.0).collect();
        assert!([10, 11, 19, 20, 21, 62, 65].iter().all(|c| categories.contains(c)), "{said:?}");
        assert!(said.iter().all(|(_, source)| source.0 == sac), "{sac}: {said:?}");
        assert!(said.iter().any(|(category, source)| *category == 62 && source.1 == SMDFM_SIC));
    }
}

/// An ADS-B sensor is not told of sizes: nothing is said of them, instead of the least. Of truth the class is that of the size.
#[test]
fn a_size_that_is_not_known_is_not_said() {
    use mode_s::{Message, Reading, beast, read as heard};
    let guests = [guest([301, 1, 1], "SWR99Z", Some(0x4b_1234))];
    let codes = |origin, scan: ScanReport| -> BTreeSet<Option<u8>> {
        let pieces = Board::new(&scene(), 1, false).sending(origin).on_scan(&Arc::new(scan));
        let mut octets: Vec<u8> = pieces.iter().flat_map(|piece| piece.beast.clone()).collect();
        let messages = beast::take(&mut octets).into_iter();
        let messages = messages.map(|(_, _, octets)| heard(&Message(octets)).expect("sound").1);
        let code = |said| match said {
            Reading::Status { length_width_code, .. } => Some(length_width_code),
            _ => None,
        };
        messages.filter_map(code).collect()
    };
    let truth = ScanReport { truth: guests.to_vec(), ..report(1, vec![], vec![]) };
    // 37.6 m by 34.1 m.
    assert_eq!(codes(Origin::Truth, truth), [Some(6)].into());
    let told = report(1, vec![], vec![told(9, "SWR99Z", Some(0x4b_1234))]);
    assert_eq!(codes(Origin::Reports, told), [Some(0)].into());
}

/// Who told a sensor his call sign and no address has the invented one that his reports in category 021 have, for as long as the run.
#[test]
fn reports_without_an_address_have_an_invented_one_where_that_is_asked_for() {
    let plots = ["SWR1", "N172SP"].map(|name| told(9, name, None)).to_vec();
    let known = told(9, "SWR99Z", Some(0x4b_1234));
    let shown = |invent| {
        let board = Board::new(&scene(), 1, invent).sending(Origin::Reports);
        [(1, 1, 2), (1, 2, 2), (1, 3, 0), (2, 1, 1)].map(|(run, number, count)| {
            let plots = plots.iter().rev().take(count).chain([&known]).cloned().collect();
            let scan = ScanReport { run, ..report(number, vec![], plots) };
            board.on_scan(&Arc::new(scan));
            let json = board.value("aircraft.json").expect("there");
            let text = |entry: &serde_json::Value, key: &str| {
                entry[key].as_str().expect(key).trim().to_owned()
            };
            let list = json["aircraft"].as_array().expect("a list");
            list.iter().map(|a| (text(a, "hex"), text(a, "flight"))).collect::<Vec<_>>()
        })
    };
    let own = vec![("4b1234".to_owned(), "SWR99Z".to_owned())];
    assert_eq!(shown(false), [(); 4].map(|()| own.clone()));
    let [first, second, third, other] = shown(true);
    let mut gateway = gateway();
    let sent = gateway.on_scan(&report(1, vec![], plots.iter().rev().cloned().collect()));
    let of_021 = said_021(&sent);
    let mut expected = own;
    let hex = |address: f64| format!("~{:06x}", address as u32);
    expected.extend(of_021.iter().map(|(_, address, name)| (hex(*address), name.clone())));
    assert_eq!(first, expected);
    assert_eq!((&second, &third), (&first, &first), "his for the run, also while nothing is heard");
    assert_eq!(other.len(), 2, "another run knows nothing of this one: {other:?}");
}
