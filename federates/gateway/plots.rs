//! A plot as the report of its sensor: categories 010, 020 and 021.

use super::items::{FOOT_M, emitter, fleet, ident, nac_p};
use super::{Gateway, Source};
use crate::runtime::messages::{FlightNotice, PlotMessage, ScanReport};
use asterix::{EncodeError, Packer, cat010, cat020, cat021};
use models::flight_list::MovementKind;
use models::plot::ON_GROUND_M;

/// Nautical mile, m.
const NM_M: f64 = 1852.0;

/// Adds the record of a plot.
///
/// # Errors
/// If a value does not fit its field; nothing is added then.
pub fn record(
    packer: &mut Packer,
    gateway: &Gateway,
    source: &Source,
    category: u8,
    plot: &PlotMessage,
    scan: &ScanReport,
) -> Result<(), EncodeError> {
    let report = Report { gateway, source, plot, flight: gateway.flight_of(plot) };
    match category {
        20 => report.record_020(packer),
        21 => report.record_021(packer, scan.time_ns),
        _ => report.record_010(packer),
    }
}

struct Report<'a> {
    gateway: &'a Gateway,
    source: &'a Source,
    plot: &'a PlotMessage,
    flight: Option<&'a FlightNotice>,
}

impl Report<'_> {
    fn cooperative(&self) -> bool {
        matches!(self.source.kind.word, "adsb" | "mlat" | "gps" | "dgps")
    }

    fn on_ground(&self) -> u8 {
        let low = self.plot.altitude_m.is_none_or(|height_m| height_m < ON_GROUND_M);
        u8::from(self.cooperative() && low)
    }

    /// 1 aircraft, 2 vehicle, 0 unknown.
    fn target(&self) -> u8 {
        match self.flight.map(|f| f.movement) {
            None => 0,
            Some(MovementKind::Vehicle) => 2,
            Some(_) => 1,
        }
    }

    fn address(&self) -> Option<u32> {
        self.gateway.address_of(self.plot)
    }

    /// What kind of address category 021 says, and the address: 0 of ICAO, 2 of a vehicle, 3 of somebody who said none.
    fn addressed(&self) -> (u32, u32) {
        match self.address() {
            Some(address) if self.target() == 2 => (2, address),
            Some(address) => (0, address),
            None => (3, self.gateway.anonymous.given(&self.plot.identity).unwrap_or(0)),
        }
    }

    /// The call sign that was reported, else that of the flight with the address that was.
    fn callsign(&self) -> Option<String> {
        let name = self.flight.map_or(self.plot.callsign(), |flight| &flight.callsign);
        Some(ident(name)).filter(|name| !name.is_empty())
    }

    fn fleet(&self) -> Option<u8> {
        self.flight
            .filter(|f| f.movement == MovementKind::Vehicle)
            .map(|f| fleet(&f.type_designator))
    }

    /// Speed over ground, m/s, and track, degrees, as the target told them.
    fn vector(&self) -> Option<[f64; 2]> {
        let [east_mps, north_mps] = self.plot.velocity_mps?;
        let track_deg = libm::atan2(east_mps, north_mps).to_degrees().rem_euclid(360.0);
        Some([libm::hypot(east_mps, north_mps), track_deg])
    }

    fn time_s(&self) -> f64 {
        self.gateway.of_day_s(self.plot.time_ns)
    }

    fn record_010(&self, packer: &mut Packer) -> Result<(), EncodeError> {
        let plot = self.plot;
        let (kind, corrected) = match self.source.kind.word {
            "asde" => (3, 0),
            "mlat" => (1, 0),
            "dgps" => (2, 1),
            "gps" | "adsb" => (2, 0),
            "loop" => (4, 0),
            _ => (7, 0),
        };
        let [ee_m2, en_m2, nn_m2] = plot.cov_m2;
        packer.record(&cat010::CATEGORY, |items| {
            items.put(&cat010::I010, &self.gateway.identity(self.source.sic))?;
            items.put(&cat010::I000, &[1])?;
            let loop_passed = u8::from(kind == 4);
            let descriptor =
                [kind, corrected, 0, self.on_ground(), 0, 1, 0, 0, loop_passed, self.target()];
            items.put(&cat010::I020, &descriptor)?;
            items.put(&cat010::I140, &[self.time_s()])?;
            items.put(&cat010::I041, &self.gateway.place(plot.position_m.into()))?;
            if let Some([range_m, azimuth_rad, ..]) = plot.polar {
                items.put(&cat010::I040, &[range_m, azimuth_rad.to_degrees()])?;
            }
            items.put(&cat010::I042, plot.position_m.coords.as_slice())?;
            if let Some(address) = self.address() {
                items.put(&cat010::I220, &[address])?;
            }
            if let Some(callsign) = self.callsign() {
                items.put(&cat010::I245, &[Mixed::Code(0), Mixed::Text(&callsign)])?;
            }
            if let Some(fleet) = self.fleet() {
                items.put(&cat010::I300, &[fleet])?;
            }
            if let Some(height_m) = plot.altitude_m {
                items.put(&cat010::I091, &[height_m / FOOT_M])?;
            }
            items.put(&cat010::I500, &[ee_m2.max(0.0).sqrt(), nn_m2.max(0.0).sqrt(), en_m2])?;
            if let Some(scnr_db) = plot.scnr_db.filter(|s| s.is_finite()) {
                items.put(&cat010::I131, &[(2.0 * scnr_db).round().clamp(0.0, 255.0)])?;
            }
            Ok(())
        })
    }

    fn record_020(&self, packer: &mut Packer) -> Result<(), EncodeError> {
        let plot = self.plot;
        let [ee_m2, en_m2, nn_m2] = plot.cov_m2;
        let (east_m, north_m) = (ee_m2.max(0.0).sqrt(), nn_m2.max(0.0).sqrt());
        packer.record(&cat020::CATEGORY, |items| {
            items.put(&cat020::I010, &self.gateway.identity(self.source.sic))?;
            // The first seven bits are inverted: Mode S was used.
            items.put(&cat020::I020, &[1, 0, 1, 1, 1, 1, 1, 0, 0, 0, self.on_ground(), 0, 1, 0])?;
            items.put(&cat020::I140, &[self.time_s()])?;
            items.put(&cat020::I041, &self.gateway.place(plot.position_m.into()))?;
            items.put(&cat020::I042, plot.position_m.coords.as_slice())?;
            if let Some(address) = self.address() {
                items.put(&cat020::I220, &[address])?;
            }
            if let Some(callsign) = self.callsign() {
                items.put(&cat020::I245, &[Mixed::Code(2), Mixed::Text(&callsign)])?;
            }
            if let Some(height_m) = plot.altitude_m {
                items.put(&cat020::I105, &[(height_m + self.gateway.elevation_m) / FOOT_M])?;
            }
            if let Some(fleet) = self.fleet() {
                items.put(&cat020::I300, &[fleet])?;
            }
            items.compound(&cat020::I500, |sub| {
                let correlation = en_m2 / (east_m * north_m);
                let correlation = if correlation.is_finite() { correlation } else { 0.0 };
                sub.put(&cat020::I500_SDP, &[east_m, north_m, correlation])
            })
        })
    }

    fn record_021(&self, packer: &mut Packer, scan_end_ns: i64) -> Result<(), EncodeError> {
        let plot = self.plot;
        let vehicle = u8::from(self.target() == 2);
        let (kind, address) = self.addressed();
        packer.record(&cat021::CATEGORY, |items| {
            items.put(&cat021::I010, &self.gateway.identity(self.source.sic))?;
            let descriptor = [kind, 0, 0, 0, 0, u32::from(self.on_ground()), 1];
            items.put(&cat021::I040, &descriptor)?;
            items.put(&cat021::I071, &[self.time_s()])?;
            items.put(&cat021::I131, &self.gateway.place(plot.position_m.into()))?;
            items.put(&cat021::I080, &[address])?;
            // A report has the time at which it was sent; what it is late by lies in its position. It is received then.
            items.put(&cat021::I073, &[self.time_s()])?;
            if let Some(height_m) = plot.altitude_m {
                items.put(&cat021::I140, &[(height_m + self.gateway.elevation_m) / FOOT_M])?;
            }
            items.put(&cat021::I090, &[0, 0, 0, 0, nac_p(plot.cov_m2)])?;
            items.put(&cat021::I210, &[0, 2, 2])?;
            if let Some([speed_mps, track_deg]) = self.vector().filter(|_| self.on_ground() == 0) {
                items.put(&cat021::I160, &[0.0, speed_mps / NM_M, track_deg])?;
            }
            items.put(&cat021::I077, &[self.gateway.of_day_s(scan_end_ns)])?;
            if let Some(callsign) = self.callsign() {
                items.put(&cat021::I170, &[callsign.as_str()])?;
            }
            if let Some(flight) = self.flight {
                let aircraft = vehicle == 0;
                let category = emitter(aircraft, flight.wake, &flight.type_designator);
                items.put(&cat021::I020, &[category])?;
            }
            // Speed and track on the ground have no item of their own: surface ground vector of the reserved expansion field.
            if let Some([speed_mps, track_deg]) = self.vector().filter(|_| self.on_ground() == 1) {
                let speed_kt = speed_mps / mode_s::KNOT_MPS;
                let (stopped, moves) = (f64::from(u8::from(speed_kt == 0.0)), speed_kt > 0.0);
                items.compound(&cat021::RE, |sub| {
                    // Valid, a track, from true north.
                    let vector = [stopped, 1.0, 1.0, 0.0, speed_kt, track_deg];
                    let vector = if moves { &vector[..] } else { &[stopped, 0.0, 0.0, 0.0, 0.0] };
                    sub.put(&cat021::RE_SGV, vector)
                })?;
            }
            Ok(())
        })
    }
}

/// A code or a text, for items that have both.
#[derive(Clone, Copy)]
pub(crate) enum Mixed<'a> {
    Code(u32),
    Text(&'a str),
}

impl asterix::FieldValue for Mixed<'_> {
    fn raw(self, field: &asterix::table::Field) -> Result<u64, asterix::ValueError> {
        match self {
            Self::Code(code) => code.raw(field),
            Self::Text(text) => text.raw(field),
        }
    }
}
