//! Targets as their own extended squitters: Beast frames, SBS lines, `aircraft.json` as receivers write it.
//!
//! What is sent is truth at the end of each scan, and half a second later in a straight line; targets without an address, of their
//! flight or of their transponder, send nothing, unless addresses are to be invented. Or it is what ADS-B sensors were told ([`Reported`]): positions with their errors, as
//! often as the sensor has them, and in a straight line between.

use super::invented::Invented;
use super::items::{nac_p, pressure_altitude_m};
use super::{Gateway, in_order};
use crate::runtime::messages::{PlotMessage, ScanReport, TruthMessage};
use geodesy::Enu;
use mode_s::sbs::{self, Line, Says};
use mode_s::{Due, Emitter, FOOT_M, Reading, Schedule, Target, beast, read};
use models::flight_list::{MovementKind, WakeCategory};
use models::plot::ON_GROUND_M;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Pressure at sea level in the standard atmosphere, hPa.
const STANDARD_HPA: f64 = 1013.25;

/// A target with its name in the exercise.
#[derive(Clone, Debug, PartialEq)]
pub struct Addressed {
    /// DIS identifier.
    pub id: [u16; 3],
    /// What it sends.
    pub target: Target,
    /// Type designator; empty if not known.
    pub type_designator: String,
}

/// Whose positions are sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Origin {
    /// True ones.
    #[default]
    Truth,
    /// Those of plots of ADS-B sensors.
    Reports,
}

/// The last report of each target that an ADS-B sensor has heard, by address.
#[derive(Clone, Debug, Default)]
pub struct Reported {
    run: u32,
    last: BTreeMap<u32, PlotMessage>,
}

impl Reported {
    /// Everybody who was heard lately, where he is at the end of the scan by what he reported. Who said his name and no address is there
    /// where `invent`, with the address that his reports in category 021 have.
    pub fn targets(
        &mut self,
        gateway: &mut Gateway,
        scan: &ScanReport,
        invent: bool,
    ) -> Vec<Addressed> {
        if self.run != scan.run {
            *self = Self { run: scan.run, last: BTreeMap::new() };
            gateway.anonymous = Invented::default();
        }
        if invent {
            gateway.invent_for(&in_order(scan));
        }
        let gateway = &*gateway;
        for plot in scan.plots.iter().filter(|p| p.kind.word == "adsb") {
            let invented = || gateway.anonymous.given(&plot.identity);
            let Some(address) = gateway.address_of(plot).or_else(invented) else { continue };
            if self.last.get(&address).is_none_or(|last| last.time_ns <= plot.time_ns) {
                self.last.insert(address, plot.clone());
            }
        }
        self.last.retain(|_, plot| scan.time_ns - plot.time_ns <= HEARD_NS);
        let target =
            |(address, plot): (&u32, &PlotMessage)| reported(gateway, *address, plot, scan.time_ns);
        self.last.iter().map(target).collect()
    }
}

/// Two reports of a target that stands, and a little: whoever is silent for longer is not there, ns.
const HEARD_NS: i64 = 11_000_000_000;

fn reported(gateway: &Gateway, address: u32, plot: &PlotMessage, time_ns: i64) -> Addressed {
    let flight = gateway.flight_of(plot);
    let aircraft = flight.is_none_or(|f| f.movement != MovementKind::Vehicle);
    let type_designator = flight.map_or(String::new(), |f| f.type_designator.clone());
    let velocity_mps = plot.velocity_mps.unwrap_or_default();
    let later_s = (time_ns - plot.time_ns) as f64 * 1e-9;
    let [east_m, north_m]: [f64; 2] =
        [0, 1].map(|i| plot.position_m[i] + velocity_mps[i] * later_s);
    let up_m = plot.altitude_m.unwrap_or(0.0);
    let place = gateway.frame.to_ecef(Enu { east_m, north_m, up_m }).to_geodetic();
    let heading_rad = libm::atan2(velocity_mps[0], velocity_mps[1]);
    Addressed {
        // None of the exercise: only the address is known of it.
        id: [u16::MAX, (address >> 16) as u16, address as u16],
        target: Target {
            emitter: match (gateway.address_of(plot), aircraft) {
                (None, _) => Emitter::anonymous(address),
                (Some(_), true) => Emitter::aircraft(address, true),
                (Some(_), false) => Emitter::vehicle(address),
            },
            callsign: flight.map_or(plot.callsign(), |f| &f.callsign).to_owned(),
            category: category(aircraft, flight.and_then(|f| f.wake), &type_designator),
            lat_deg: place.lat_deg(),
            lon_deg: place.lon_deg(),
            pressure_altitude_m: pressure_altitude_m(
                up_m + gateway.elevation_m,
                gateway.pressure_hpa(time_ns).unwrap_or(STANDARD_HPA),
            ),
            velocity_mps: [velocity_mps[0], velocity_mps[1], 0.0],
            heading_deg: heading_rad.to_degrees().rem_euclid(360.0),
            on_ground: up_m < ON_GROUND_M,
            size_m: [0.0; 2],
            nac_p: nac_p(plot.cov_m2),
        },
        type_designator,
    }
}

fn category(aircraft: bool, wake: Option<WakeCategory>, type_designator: &str) -> u8 {
    match (aircraft, wake) {
        (false, _) if type_designator == "FIRE" => 0xc1,
        (false, _) => 0xc2,
        (true, Some(WakeCategory::Light)) => 0xa1,
        (true, Some(WakeCategory::Medium)) => 0xa3,
        (true, Some(WakeCategory::Heavy | WakeCategory::Super)) => 0xa5,
        (true, None) => 0xa0,
    }
}

/// Addresses of a run that were invented, by DIS identifier.
#[derive(Clone, Debug, Default)]
pub struct OfRun {
    run: u32,
    given: Invented<[u16; 3]>,
}

/// Everybody who sends at the end of a scan, by identifier; who has no address where `invented` has one for him.
#[must_use]
pub fn targets(
    gateway: &Gateway,
    scan: &ScanReport,
    mut invented: Option<&mut OfRun>,
) -> Vec<Addressed> {
    if let Some(of_run) = invented.as_deref_mut().filter(|of_run| of_run.run != scan.run) {
        *of_run = OfRun { run: scan.run, ..OfRun::default() };
    }
    let mut list: Vec<Addressed> = Vec::new();
    for truth in &scan.truth {
        let invent = || invented.as_deref_mut()?.given.of(truth.id, u32::from(truth.id[2]));
        list.extend(addressed(gateway, truth, scan.time_ns, invent));
    }
    list.sort_by_key(|a| a.id);
    list.dedup_by_key(|a| a.id);
    list
}

fn addressed(
    gateway: &Gateway,
    truth: &TruthMessage,
    time_ns: i64,
    invent: impl FnOnce() -> Option<u32>,
) -> Option<Addressed> {
    let flight = gateway.flight(&truth.callsign);
    let own = flight.and_then(|f| f.address).or(truth.address);
    let emitter = match own {
        Some(address) if truth.aircraft => Emitter::aircraft(address, true),
        Some(address) => Emitter::vehicle(address),
        None => Emitter::anonymous(invent()?),
    };
    let [east_m, north_m, up_m]: [f64; 3] = truth.position_m.into();
    let place = gateway.frame.to_ecef(Enu { east_m, north_m, up_m }).to_geodetic();
    let above_m = place.height_m - gateway.elevation_m;
    Some(Addressed {
        id: truth.id,
        type_designator: truth.type_designator.clone(),
        target: Target {
            emitter,
            callsign: truth.callsign.clone(),
            category: category(truth.aircraft, flight.and_then(|f| f.wake), &truth.type_designator),
            lat_deg: place.lat_deg(),
            lon_deg: place.lon_deg(),
            pressure_altitude_m: pressure_altitude_m(
                place.height_m,
                gateway.pressure_hpa(time_ns).unwrap_or(STANDARD_HPA),
            ),
            velocity_mps: truth.velocity_mps,
            heading_deg: truth.heading_rad.to_degrees().rem_euclid(360.0),
            on_ground: above_m < ON_GROUND_M,
            size_m: truth.size_m,
            nac_p: NAC_P,
        },
    })
}

/// Accuracy that is said of the positions: 30 m. They are exact to the step of their code.
const NAC_P: u8 = 9;

/// Octets for the two ports, with the simulated time at which they are to be sent.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Piece {
    /// Simulated time, ns.
    pub time_ns: i64,
    /// Beast frames.
    pub beast: Vec<u8>,
    /// SBS lines.
    pub sbs: String,
    /// Squitters in it.
    pub messages: u64,
}

/// Keeps in mind what each target sent last.
#[derive(Debug, Default)]
pub struct Feed {
    schedules: BTreeMap<[u16; 3], (Schedule, u64)>,
    run: u32,
    messages: u64,
    refused: u64,
}

impl Feed {
    /// Targets that could not be written.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// Squitters so far.
    #[must_use]
    pub fn messages(&self) -> u64 {
        self.messages
    }

    /// What is sent from the end of this scan to the end of the next, by time.
    pub fn on_scan(
        &mut self,
        gateway: &Gateway,
        scan: &ScanReport,
        targets: &[Addressed],
    ) -> Vec<Piece> {
        if self.run != scan.run {
            self.run = scan.run;
            self.schedules.clear();
        }
        let alive = |id: &[u16; 3]| targets.binary_search_by_key(id, |a| a.id).is_ok();
        self.schedules.retain(|id, _| alive(id));
        let mut pieces: BTreeMap<i64, Piece> = BTreeMap::new();
        let until_ns = scan.time_ns + gateway.scan_ns;
        for Addressed { id, target, .. } in targets {
            let (schedule, count) = self.schedules.entry(*id).or_default();
            let Ok(due) = schedule.due(target, scan.time_ns, until_ns) else {
                self.refused += 1;
                continue;
            };
            *count += due.len() as u64;
            self.messages += due.len() as u64;
            for due in due {
                let piece = pieces.entry(due.time_ns).or_default();
                piece.time_ns = due.time_ns;
                piece.messages += 1;
                beast::frame(&mut piece.beast, &due.message, due.time_ns);
                let later = target.after((due.time_ns - scan.time_ns) as f64 * 1e-9);
                line(&mut piece.sbs, &later, &due, gateway.utc_ns(due.time_ns));
            }
        }
        pieces.into_values().collect()
    }

    /// `aircraft.json` at the end of a scan.
    #[must_use]
    pub fn aircraft_json(
        &self,
        gateway: &Gateway,
        scan: &ScanReport,
        targets: &[Addressed],
    ) -> Value {
        let round = |x: f64, digits: i32| {
            let scale = libm::pow(10.0, f64::from(digits));
            libm::round(x * scale) / scale
        };
        let aircraft: Vec<Value> = targets
            .iter()
            .map(|Addressed { id, target, type_designator }| {
                let vehicle = target.category >> 4 == 0xc;
                let invented = target.emitter.format == 18 && target.emitter.capability == 1;
                // A tilde says that the address is none of ICAO's, as receivers do.
                let hex = format!("{}{:06x}", if invented { "~" } else { "" }, target.emitter.address);
                let mut entry = json!({
                    "hex": hex,
                    "type": if vehicle { "adsb_icao_nt" } else if invented { "adsb_other" } else { "adsb_icao" },
                    "flight": format!("{:<8}", super::items::ident(&target.callsign)),
                    "gs": round(target.speed_kt(), 1),
                    "category": format!("{:02X}", target.category),
                    "lat": round(target.lat_deg, 6),
                    "lon": round(target.lon_deg, 6),
                    "nic": 8, "rc": 186, "nac_p": target.nac_p, "sil": 3, "sil_type": "perhour", "version": 2,
                    // Nothing of it is by multilateration or traffic information.
                    "mlat": [], "tisb": [],
                    "seen": 0.0, "seen_pos": 0.0,
                    "messages": self.schedules.get(id).map_or(0, |s| s.1),
                    "rssi": -6.0,
                    "t": type_designator, "r": "",
                });
                let track = if target.moves() { "track" } else { "true_heading" };
                entry[track] = json!(round(target.track_deg(), 2).rem_euclid(360.0));
                entry["alt_baro"] = if target.on_ground {
                    json!("ground")
                } else {
                    json!(libm::round(target.pressure_altitude_m / FOOT_M / 25.0) * 25.0)
                };
                if !target.on_ground {
                    let climb_fpm = target.velocity_mps[2] / FOOT_M * 60.0;
                    entry["baro_rate"] = json!(libm::round(climb_fpm / 64.0) * 64.0);
                }
                entry
            })
            .collect();
        json!({
            "now": gateway.utc_ns(scan.time_ns) as f64 * 1e-9,
            "messages": self.messages,
            "aircraft": aircraft,
        })
    }
}

/// `receiver.json`: where the receiver stands.
#[must_use]
pub fn receiver_json(gateway: &Gateway) -> Value {
    let [lat, lon] = gateway.place([0.0, 0.0]);
    let version = concat!("seeds ", env!("CARGO_PKG_VERSION"));
    json!({"version": version, "refresh": 1000, "history": 0, "lat": lat, "lon": lon})
}

/// The command line of a decoder beside a Beast port: without the receiver's place it shows nothing on the ground.
#[must_use]
pub fn decoder_command(gateway: &Gateway, port: std::net::SocketAddr) -> String {
    let [lat, lon] = gateway.place([0.0, 0.0]);
    format!(
        "readsb --net-only --net-connector {},{},beast_in --lat {lat:.4} --lon {lon:.4}",
        port.ip(),
        port.port()
    )
}

fn line(out: &mut String, target: &Target, due: &Due, utc_ns: i64) {
    let Ok((emitter, reading)) = read(&due.message) else { return };
    let (lat_deg, lon_deg) = (target.lat_deg, target.lon_deg);
    let (speed_kt, track_deg) = (target.speed_kt(), target.track_deg());
    let says = match &reading {
        Reading::Surface { .. } => Says::Surface { speed_kt, track_deg, lat_deg, lon_deg },
        Reading::Airborne { .. } => {
            let altitude_ft = target.pressure_altitude_m / FOOT_M;
            Says::Airborne { altitude_ft, lat_deg, lon_deg }
        }
        Reading::Velocity { .. } => {
            let climb_fpm = target.velocity_mps[2] / FOOT_M * 60.0;
            Says::Velocity { speed_kt, track_deg, climb_fpm }
        }
        Reading::Identification { callsign, .. } => Says::Identification(callsign),
        Reading::Status { .. } | Reading::Other(_) => return,
    };
    sbs::line(out, &Line { address: emitter.address, utc_ns, says });
}
