//! Whose address goes out: of visitors, of who has none, of call signs that look like one.

use super::tests::{plot, read, report, scene, track};
use super::*;
use crate::runtime::messages::PlotMessage;
use asterix::{cat020, cat021};

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
    let plots = [8, 9].into_iter().flat_map(|sensor| {
        both.map(|(name, address)| told(sensor, name, Some(address)))
    });
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
