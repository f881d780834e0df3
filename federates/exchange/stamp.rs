//! An outsider's PDU as it is let into a frame: an Event Report of the member `visitors`.
//!
//! It travels as every PDU of the federation does: named in a frame end, repaired by request, recorded
//! by anybody who listens. So a recording carries the stamps, and a replay of it is the run.
//!
//! The report comes from `site:65000:2`, goes to all, and has one variable datum, [`STAMPED`]:
//! exercise time and host's UTC of the arrival (signed 64 bits, ns since 1970), exercise seconds in a
//! second of UTC (64-bit float), sender's address (IPv6, 16 octets; IPv4 mapped) and port (16 bits),
//! then the PDU as it came; all big-endian. What a real sensor of somebody sent ([`PLOTS`]) travels alike: behind the
//! head its number in the scene (16 bits) and data blocks of ASTERIX.

use super::weather_pdu::WORLD_APPLICATION;
use pdu::enumerations::DatumId;
use pdu::exercise::Arrival;
use pdu::management::EventReport;
use pdu::records::{EntityId, VariableDatum};
use pdu::{EncodeError, Envelope};
use std::net::{IpAddr, Ipv6Addr, SocketAddr};

/// Identifiers of outsiders that may ever be used in a run: sensors remember each of them.
pub const EVER: usize = 65_536;

/// Identifier of the datum: "SEEV".
pub const STAMPED: u32 = 0x5345_4556;

/// Identifier of the datum with plots: "SEEA".
pub const PLOTS: u32 = 0x5345_4541;

/// Entity number of the member at application 65000.
const NUMBER: u16 = 2;

/// Octets before the PDU.
const HEAD: usize = 8 + 8 + 8 + 16 + 2;

/// A PDU of an outsider with the time of its arrival.
#[derive(Clone, Debug, PartialEq)]
pub struct Stamped {
    /// When it arrived.
    pub arrival: Arrival,
    /// Who sent it.
    pub from: SocketAddr,
    /// The PDU.
    pub octets: Vec<u8>,
}

/// Plots of a real sensor with the time of their arrival.
#[derive(Clone, Debug, PartialEq)]
pub struct StampedPlots {
    /// Number of the sensor in the scene.
    pub sensor: u16,
    /// When they arrived.
    pub arrival: Arrival,
    /// Who sent them.
    pub from: SocketAddr,
    /// Data blocks of ASTERIX.
    pub octets: Vec<u8>,
}

/// DIS identifier of the member.
#[must_use]
pub fn member_id(site: u16) -> EntityId {
    EntityId::new(site, WORLD_APPLICATION, NUMBER)
}

/// Whether these octets of a PDU are such a report, by their header and first datum alone.
#[must_use]
pub fn is_stamped(pdu: &[u8]) -> bool {
    const DATUM_AT: usize = 40;
    pdu.get(2) == Some(&pdu::enumerations::PduType::EVENT_REPORT.0)
        && [STAMPED, PLOTS]
            .iter()
            .any(|id| pdu.get(DATUM_AT..DATUM_AT + 4) == Some(&id.to_be_bytes()[..]))
}

/// The report.
///
/// # Errors
/// If the PDU is too long for it.
pub fn encode(site: u16, envelope: &Envelope, stamped: &Stamped) -> Result<Vec<u8>, EncodeError> {
    let value = head(&stamped.arrival, stamped.from, &[&stamped.octets]);
    report(site, envelope, STAMPED, &value)
}

/// The report of plots.
///
/// # Errors
/// If they are too long for it.
pub fn encode_plots(
    site: u16,
    envelope: &Envelope,
    stamped: &StampedPlots,
) -> Result<Vec<u8>, EncodeError> {
    let sensor = stamped.sensor.to_be_bytes();
    let value = head(&stamped.arrival, stamped.from, &[&sensor, &stamped.octets]);
    report(site, envelope, PLOTS, &value)
}

fn head(arrival: &Arrival, from: SocketAddr, rest: &[&[u8]]) -> Vec<u8> {
    let ip = match from.ip() {
        IpAddr::V4(ip) => ip.to_ipv6_mapped(),
        IpAddr::V6(ip) => ip,
    };
    let mut value = Vec::with_capacity(HEAD + rest.iter().map(|r| r.len()).sum::<usize>());
    value.extend_from_slice(&arrival.time_ns.to_be_bytes());
    value.extend_from_slice(&arrival.utc_ns.to_be_bytes());
    value.extend_from_slice(&arrival.rate.to_be_bytes());
    value.extend_from_slice(&ip.octets());
    value.extend_from_slice(&from.port().to_be_bytes());
    rest.iter().for_each(|octets| value.extend_from_slice(octets));
    value
}

fn report(site: u16, envelope: &Envelope, id: u32, value: &[u8]) -> Result<Vec<u8>, EncodeError> {
    let report = EventReport {
        originating_id: member_id(site),
        receiving_id: EntityId::ALL,
        variable_datums: vec![VariableDatum::new(DatumId(id), value)].into(),
        ..EventReport::default()
    };
    let mut octets = Vec::with_capacity(64 + value.len());
    envelope.append(&report, &mut octets)?;
    Ok(octets)
}

/// What such a report carries; `None` if it is something else.
#[must_use]
pub fn decode(report: &EventReport<'_>, site: u16) -> Option<Stamped> {
    let (arrival, from, octets) = opened(report, site, STAMPED)?;
    Some(Stamped { arrival, from, octets: octets.to_vec() })
}

/// The plots that such a report carries; `None` if it is something else.
#[must_use]
pub fn decode_plots(report: &EventReport<'_>, site: u16) -> Option<StampedPlots> {
    let (arrival, from, octets) = opened(report, site, PLOTS)?;
    let (sensor, octets) = octets.split_first_chunk::<2>()?;
    let sensor = u16::from_be_bytes(*sensor);
    Some(StampedPlots { sensor, arrival, from, octets: octets.to_vec() })
}

fn opened<'a>(
    report: &'a EventReport<'_>,
    site: u16,
    id: u32,
) -> Option<(Arrival, SocketAddr, &'a [u8])> {
    if report.originating_id != member_id(site) {
        return None;
    }
    let datum = report.variable_datums.iter().find(|d| d.id.0 == id)?;
    let (head, octets) = datum.value.split_at_checked(HEAD)?;
    let eight = |at: usize| -> Option<[u8; 8]> { head.get(at..at + 8)?.try_into().ok() };
    let ip: [u8; 16] = head.get(24..40)?.try_into().ok()?;
    let port = u16::from_be_bytes(head.get(40..42)?.try_into().ok()?);
    let arrival = Arrival {
        time_ns: i64::from_be_bytes(eight(0)?),
        utc_ns: i64::from_be_bytes(eight(8)?),
        rate: f64::from_be_bytes(eight(16)?),
    };
    Some((arrival, SocketAddr::new(Ipv6Addr::from(ip).to_canonical(), port), octets))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pdu::{Body, DisTime};

    #[test]
    fn what_is_stamped_comes_back_and_nothing_else_is_taken_for_it() {
        let stamped = Stamped {
            arrival: Arrival { time_ns: -5, utc_ns: 1_700_000_000_123_456_789, rate: 4.0 },
            from: "10.1.2.3:3000".parse().expect("an address"),
            octets: (0..=200).collect(),
        };
        let octets = encode(417, &Envelope::new(1, DisTime(1)), &stamped).expect("fits");
        assert!(is_stamped(&octets) && !is_stamped(&octets[..43]) && !is_stamped(&[]));
        let received = pdu::pdus(&octets).next().expect("one").expect("sound");
        let Body::EventReport(report) = received.body() else { panic!("an Event Report") };
        assert_eq!(decode(report, 417), Some(stamped));
        assert_eq!(decode(report, 418), None, "of another federation");
        assert_eq!(decode(&EventReport::default(), 0), None);
        assert_eq!(decode_plots(report, 417), None, "no plots");
    }

    #[test]
    fn plots_come_back_with_their_sensor() {
        let stamped = StampedPlots {
            sensor: 300,
            arrival: Arrival { time_ns: 7, utc_ns: 8, rate: 1.0 },
            from: "[2001:db8::1]:8600".parse().expect("an address"),
            octets: vec![10, 0, 4, 1],
        };
        let octets = encode_plots(417, &Envelope::new(1, DisTime(1)), &stamped).expect("fits");
        assert!(is_stamped(&octets));
        let received = pdu::pdus(&octets).next().expect("one").expect("sound");
        let Body::EventReport(report) = received.body() else { panic!("an Event Report") };
        assert_eq!((decode_plots(report, 417), decode(report, 417)), (Some(stamped), None));
    }
}
