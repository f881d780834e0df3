//! A system track in categories 062 and 011.

use super::alerts::Mark;
use super::items::{FOOT_M, ascii, fleet, fleet_011, ident, pressure_altitude_m, signed_root};
use super::plots::Mixed;
use super::{Gateway, Memory, SMDFM_SIC};
use crate::runtime::messages::TrackMessage;
use asterix::{EncodeError, ItemWriter, Packer, cat011, cat062};
use models::flight_list::{MovementKind, WakeCategory};
use models::plot::ON_GROUND_M;
use models::score::areas::Area;
use models::track::{TrackStatus, TrackType};

/// Age after which a kind of sensor counts as never seen: the largest that eight bits of ¼ s hold, s.
const OLDEST_S: f64 = 63.75;
/// Hundred feet, m: the unit of flight levels.
const LEVEL_M: f64 = 100.0 * FOOT_M;

struct System<'a> {
    gateway: &'a Gateway,
    track: &'a TrackMessage,
    memory: Memory,
}

impl<'a> System<'a> {
    fn of(gateway: &'a Gateway, track: &'a TrackMessage) -> Self {
        let memory = gateway.memory.get(&track.number).cloned().unwrap_or_default();
        Self { gateway, track, memory }
    }

    fn bits(&self) -> Bits {
        let track = self.track;
        let [now, before] = &self.memory.fed;
        Bits {
            mono: u8::from(now.union(before).count() == 1),
            tentative: u8::from(track.status == TrackStatus::Tentative),
            coasting: u8::from(track.status == TrackStatus::Coasting),
            last: u8::from(track.status == TrackStatus::Last),
            first: u8::from(track.first),
            flight_plan: u8::from(track.track_type != TrackType::NotAssociated),
            ground: u8::from(track.altitude_m.is_none_or(|height_m| height_m < ON_GROUND_M)),
        }
    }

    fn vehicle(&self) -> bool {
        self.track.track_type == TrackType::Vehicle
    }

    /// Height above the sea, m.
    fn height_m(&self) -> Option<f64> {
        self.track.altitude_m.map(|height_m| height_m + self.gateway.elevation_m)
    }

    fn pressure_altitude_m(&self) -> Option<f64> {
        let pressure_hpa = self.gateway.pressure_hpa(self.track.time_ns)?;
        Some(pressure_altitude_m(self.height_m()?, pressure_hpa))
    }

    /// Seconds since the last plot of a kind, if it is not too long ago.
    fn age_s(&self, kind: &str) -> Option<f64> {
        let age_s = (self.track.time_ns - self.memory.plots.get(kind)?) as f64 / 1e9;
        (age_s <= OLDEST_S).then_some(age_s.max(0.0))
    }

    fn track_age_s(&self) -> f64 {
        (self.track.time_ns - self.memory.first_ns) as f64 / 1e9
    }

    /// Runway (three characters) and stand (six).
    fn runway_and_stand(&self) -> (String, String) {
        let text = &self.track.runway_stand;
        let (runway, stand) = text.split_once('/').unwrap_or((text, ""));
        (ascii(runway, 3), ascii(&stand.replace(['_', ' '], ""), 6))
    }

    /// Type, day, hour, minute, seconds are there (0: yes), second of the label's time.
    fn time_of_movement(&self) -> Option<[u8; 6]> {
        let at_ns = self.track.ctd_eta_ns?;
        let kind = match self.track.movement {
            Some(MovementKind::Departure) => 2,
            Some(MovementKind::Arrival) => 8,
            _ => return None,
        };
        let s = self.gateway.of_day_s(at_ns) as u32;
        let day = self.gateway.day(at_ns, self.track.time_ns);
        Some([kind, day, (s / 3600) as u8, (s / 60 % 60) as u8, 0, (s % 60) as u8])
    }

    /// From and to, where this airport is one of them.
    fn airports(&self) -> [Option<&str>; 2] {
        let here = Some(self.gateway.icao.as_str()).filter(|icao| icao.len() == 4);
        match self.track.movement {
            Some(MovementKind::Departure) => [here, None],
            Some(MovementKind::Arrival) => [None, here],
            _ => [None, None],
        }
    }

    /// Item 430.
    fn phase(&self) -> u8 {
        let area = self.gateway.areas.at(self.track.position_m, self.track.altitude_m);
        use MovementKind::{Arrival, Departure};
        match (self.track.movement, area) {
            (Some(Departure), Area::Stand) | (Some(Arrival), Area::Stand) => 1,
            (Some(Departure), Area::Runway | Area::Airborne) => 4,
            (Some(Departure), _) => 2,
            (Some(Arrival), Area::Airborne) => 9,
            (Some(Arrival), Area::Runway) => 5,
            (Some(Arrival), _) => 3,
            _ => 0,
        }
    }
}

struct Bits {
    mono: u8,
    tentative: u8,
    coasting: u8,
    last: u8,
    first: u8,
    flight_plan: u8,
    ground: u8,
}

/// A value of a text item, left out where it is empty.
fn text(
    items: &mut ItemWriter<'_>,
    item: &'static asterix::table::Item,
    value: &str,
) -> Result<(), EncodeError> {
    if value.is_empty() { Ok(()) } else { items.put(item, &[value]) }
}

/// Adds a track in category 062.
///
/// # Errors
/// If a value does not fit its field; nothing is added then.
pub fn record_062(
    packer: &mut Packer,
    gateway: &Gateway,
    track: &TrackMessage,
) -> Result<(), EncodeError> {
    let system = System::of(gateway, track);
    let bits = system.bits();
    let mut status = [0; cat062::I080.fields()];
    status[const { cat062::I080.field("MON") }] = bits.mono;
    status[const { cat062::I080.field("CNF") }] = bits.tentative;
    status[const { cat062::I080.field("SIM") }] = 1;
    status[const { cat062::I080.field("TSE") }] = bits.last;
    status[const { cat062::I080.field("TSB") }] = bits.first;
    status[const { cat062::I080.field("FPC") }] = bits.flight_plan;
    status[const { cat062::I080.field("CST") }] = bits.coasting;
    status[const { cat062::I080.field("SFC") }] = bits.ground;
    let callsign = ident(&track.callsign);
    packer.record(&cat062::CATEGORY, |items| {
        items.put(&cat062::I010, &gateway.identity(SMDFM_SIC))?;
        items.put(&cat062::I015, &[1])?;
        items.put(&cat062::I070, &[gateway.of_day_s(track.time_ns)])?;
        items.put(&cat062::I105, &gateway.place(track.position_m.into()))?;
        items.put(&cat062::I100, track.position_m.coords.as_slice())?;
        items.put(&cat062::I185, &track.velocity_mps)?;
        items.put(&cat062::I210, &track.acceleration_ms2)?;
        items.compound(&cat062::I380, |sub| {
            if let Some(address) = gateway.address_of_track(track) {
                sub.put(&cat062::I380_ADR, &[address])?;
            }
            text(sub, &cat062::I380_ID, &callsign)
        })?;
        items.put(&cat062::I040, &[track.number])?;
        items.put(&cat062::I080, &status)?;
        items.compound(&cat062::I290, |sub| {
            sub.put(&cat062::I290_TRK, &[system.track_age_s()])?;
            for (item, kind) in [
                (&cat062::I290_PSR, "asde"),
                (&cat062::I290_ADS, "adsb"),
                (&cat062::I290_LOP, "loop"),
                (&cat062::I290_MLT, "mlat"),
            ] {
                if let Some(age_s) = system.age_s(kind) {
                    sub.put(item, &[age_s])?;
                }
            }
            Ok(())
        })?;
        if let Some(altitude_m) = system.pressure_altitude_m() {
            items.put(&cat062::I136, &[altitude_m / LEVEL_M])?;
        }
        if let Some(height_m) = system.height_m() {
            items.put(&cat062::I130, &[height_m / FOOT_M])?;
            items.put(&cat062::I135, &[1.0, height_m / LEVEL_M])?;
        }
        items.compound(&cat062::I390, |sub| {
            if track.callsign.is_empty() {
                return Ok(());
            }
            let (runway, stand) = system.runway_and_stand();
            let [from, to] = system.airports();
            sub.put(&cat062::I390_TAG, &gateway.identity(SMDFM_SIC))?;
            text(sub, &cat062::I390_CS, &ascii(&track.callsign, 7))?;
            text(sub, &cat062::I390_TAC, &ascii(&track.type_designator, 4))?;
            text(sub, &cat062::I390_WTC, track.wake.map_or("", WakeCategory::word))?;
            text(sub, &cat062::I390_DEP, from.unwrap_or(""))?;
            text(sub, &cat062::I390_DST, to.unwrap_or(""))?;
            text(sub, &cat062::I390_RDS, &runway)?;
            if let Some(time) = system.time_of_movement() {
                sub.put(&cat062::I390_TOD, &time)?;
            }
            text(sub, &cat062::I390_AST, &stand)
        })?;
        if system.vehicle() {
            items.put(&cat062::I300, &[fleet(&track.type_designator)])?;
        }
        let [ee_m2, en_m2, nn_m2] = track.cov_m2;
        let [vee, _, vnn] = track.velocity_cov_m2s2;
        items.compound(&cat062::I500, |sub| {
            sub.put(&cat062::I500_APC, &[ee_m2.max(0.0).sqrt(), nn_m2.max(0.0).sqrt()])?;
            sub.put(&cat062::I500_COV, &[signed_root(en_m2)])?;
            sub.put(&cat062::I500_ATV, &[vee.max(0.0).sqrt(), vnn.max(0.0).sqrt()])
        })
    })
}

/// Adds a track in category 011, marked with the alert that it is in.
///
/// # Errors
/// If a value does not fit its field; nothing is added then.
pub fn record_011(
    packer: &mut Packer,
    gateway: &Gateway,
    track: &TrackMessage,
    mark: Option<&Mark>,
) -> Result<(), EncodeError> {
    let system = System::of(gateway, track);
    let bits = system.bits();
    // Up to the third part, which has CST and FPC.
    let mut status = [0; const { cat011::I170.field("AFF") + 1 }];
    status[const { cat011::I170.field("MON") }] = bits.mono;
    status[const { cat011::I170.field("GBS") }] = bits.ground;
    status[const { cat011::I170.field("CNF") }] = bits.tentative;
    status[const { cat011::I170.field("SIM") }] = 1;
    status[const { cat011::I170.field("TSE") }] = bits.last;
    status[const { cat011::I170.field("TSB") }] = bits.first;
    status[const { cat011::I170.field("CST") }] = bits.coasting;
    status[const { cat011::I170.field("FPC") }] = bits.flight_plan;
    let callsign = ident(&track.callsign);
    packer.record(&cat011::CATEGORY, |items| {
        items.put(&cat011::I010, &gateway.identity(SMDFM_SIC))?;
        items.put(&cat011::I000, &[1])?;
        items.put(&cat011::I015, &[1])?;
        items.put(&cat011::I140, &[gateway.of_day_s(track.time_ns)])?;
        items.put(&cat011::I041, &gateway.place(track.position_m.into()))?;
        items.put(&cat011::I042, track.position_m.coords.as_slice())?;
        items.put(&cat011::I202, &track.velocity_mps)?;
        items.put(&cat011::I210, &track.acceleration_ms2)?;
        if !callsign.is_empty() {
            items.put(&cat011::I245, &[Mixed::Code(0), Mixed::Text(&callsign)])?;
        }
        items.compound(&cat011::I380, |sub| match gateway.address_of_track(track) {
            Some(address) => sub.put(&cat011::I380_ADR, &[address]),
            None => Ok(()),
        })?;
        items.put(&cat011::I161, &[track.number])?;
        items.put(&cat011::I170, &status)?;
        items.compound(&cat011::I290, |sub| {
            for (item, kind) in [
                (&cat011::I290_PSR, "asde"),
                (&cat011::I290_ADS, "adsb"),
                (&cat011::I290_LOP, "loop"),
            ] {
                if let Some(age_s) = system.age_s(kind) {
                    sub.put(item, &[age_s])?;
                }
            }
            sub.put(&cat011::I290_TRK, &[system.track_age_s()])?;
            match system.age_s("mlat") {
                Some(age_s) => sub.put(&cat011::I290_MUL, &[age_s]),
                None => Ok(()),
            }
        })?;
        items.put(&cat011::I430, &[system.phase()])?;
        if let Some(altitude_m) = system.pressure_altitude_m() {
            items.put(&cat011::I090, &[altitude_m / LEVEL_M])?;
        }
        if let Some(height_m) = system.height_m() {
            items.put(&cat011::I093, &[1.0, height_m / LEVEL_M])?;
            items.put(&cat011::I092, &[height_m / FOOT_M])?;
        }
        items.compound(&cat011::I390, |sub| {
            if track.callsign.is_empty() {
                return Ok(());
            }
            let (runway, stand) = system.runway_and_stand();
            let [from, to] = system.airports();
            text(sub, &cat011::I390_CSN, &ascii(&track.callsign, 7))?;
            text(sub, &cat011::I390_TOA, &ascii(&track.type_designator, 4))?;
            text(sub, &cat011::I390_WTC, track.wake.map_or("", WakeCategory::word))?;
            text(sub, &cat011::I390_ADEP, from.unwrap_or(""))?;
            text(sub, &cat011::I390_ADES, to.unwrap_or(""))?;
            text(sub, &cat011::I390_RWY, &runway)?;
            if let Some(time) = system.time_of_movement() {
                sub.put(&cat011::I390_TOD, &time)?;
            }
            text(sub, &cat011::I390_AST, &stand)
        })?;
        if system.vehicle() {
            items.put(&cat011::I300, &[fleet_011(&track.type_designator)])?;
        }
        let [ee_m2, _, nn_m2] = track.cov_m2;
        let [vee, _, vnn] = track.velocity_cov_m2s2;
        items.compound(&cat011::I500, |sub| {
            sub.put(&cat011::I500_APC, &[ee_m2.max(0.0).sqrt(), nn_m2.max(0.0).sqrt()])?;
            sub.put(&cat011::I500_AVC, &[vee.max(0.0).sqrt(), vnn.max(0.0).sqrt()])
        })?;
        if let Some(Mark { severity, kind, number, tracks }) = mark {
            // The first bit is inverted: nobody has acknowledged it.
            items.put(&cat011::I600, &[1, *severity, *kind, *number])?;
            if !tracks.is_empty() {
                items.put(&cat011::I605, tracks)?;
            }
        }
        Ok(())
    })
}
