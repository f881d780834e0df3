//! Gateway: a spectator that says in ASTERIX what sensors and data fusion found.
//!
//! ```text
//! scans, weather, flights, alerts ──► Gateway ──► datagrams: starts of cycle, plots, 062, 011, 065, 004, 247
//! ```
//!
//! [`Gateway`] is a state machine without I/O; [`process`] carries it on a bus and over UDP. Truth never enters: of
//! a plot only what its sensor reported is sent. Beside ASTERIX: targets as their own extended squitters ([`adsb`]), the public
//! messages ([`public`]) over HTTP and a Zenoh session of its own, FlightGear packets; [`ports`] holds them.

pub mod adsb;
pub mod alerts;
pub mod board;
pub mod clients;
pub mod command;
pub mod commands;
pub mod flightgear;
pub mod foreign;
pub mod http;
pub mod invented;
pub mod items;
pub mod listen;
pub mod opensky;
pub mod plots;
pub mod ports;
pub mod process;
pub mod public;
pub mod public_bus;
pub mod tracks;

use crate::runtime::messages::{
    AlertMessage, FlightNotice, PlotMessage, ScanReport, TrackMessage, WeatherNotice,
};
use alerts::Alerts;
use asterix::{DATAGRAM_LIMIT, EncodeError, Packer, cat010, cat019, cat065, cat247};
use geodesy::{Enu, LocalFrame};
use invented::Invented;
use models::plot::SensorKind;
use models::score::areas::{AreaMap, AreaRules};
use models::track::TrackStatus;
use scenarios::Scene;
use std::collections::{BTreeMap, BTreeSet};

/// SIC of the SMDFM's own reports.
pub const SMDFM_SIC: u8 = 200;
/// SIC of the control function: alerts and stop bars.
pub const CONTROL_SIC: u8 = 201;
/// Largest number of a sensor that is its SIC as well.
pub const MOST_SENSORS: u16 = 199;
/// Why plots of the others are not written.
const NO_SIC: &str = "sensor number above 199 has no SIC";
/// Categories that a run can be sent in.
pub const CATEGORIES: [u8; 9] = [4, 10, 11, 19, 20, 21, 62, 65, 247];

/// Most call signs whose addresses are kept.
const MOST_HEARD: usize = 8192;

const DAY_NS: i64 = 86_400_000_000_000;
/// Scans between two status messages, and between two messages of the versions, s.
const STATUS_S: i64 = 10;
const VERSIONS_S: i64 = 60;

/// What is to be sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Plots and starts of cycle.
    pub sensors: bool,
    /// System tracks and ends of batch.
    pub tracks: bool,
    /// Periodic status.
    pub status: bool,
    /// Only these categories; `None` for all.
    pub categories: Option<BTreeSet<u8>>,
    /// System area code of all sources.
    pub sac: u8,
}

impl Default for Choice {
    fn default() -> Self {
        Self { sensors: true, tracks: true, status: true, categories: None, sac: 0 }
    }
}

impl Choice {
    fn has(&self, category: u8) -> bool {
        self.categories.as_ref().is_none_or(|list| list.contains(&category))
    }
}

/// A sensor as a source of datagrams.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source {
    /// Its number, which is its SIC.
    pub sic: u8,
    /// Its kind.
    pub kind: SensorKind,
}

impl Source {
    /// The category of its reports.
    #[must_use]
    pub fn category(&self, choice: &Choice) -> u8 {
        match self.kind.word {
            "mlat" => 20,
            "adsb" if choice.has(21) => 21,
            _ => 10,
        }
    }
}

/// What the gateway knows of a track beyond its message.
#[derive(Clone, Debug, Default)]
pub(crate) struct Memory {
    /// Time of the first message, ns.
    pub(crate) first_ns: i64,
    /// Time of the last plot of each kind, ns.
    pub(crate) plots: BTreeMap<&'static str, i64>,
    /// Sensors that fed it in this scan and in the one before.
    pub(crate) fed: [BTreeSet<u16>; 2],
}

/// Turns scans into datagrams.
#[derive(Debug)]
pub struct Gateway {
    choice: Choice,
    sources: Vec<Source>,
    pub(crate) frame: LocalFrame,
    /// Sites of the sensors that have one, by SIC, m east, north and up.
    pub(crate) sites: BTreeMap<u8, [f64; 3]>,
    pub(crate) elevation_m: f64,
    pub(crate) icao: String,
    pub(crate) areas: AreaMap,
    start_utc_ns: i64,
    scan_ns: i64,
    frame_ns: i64,
    shift_ns: i64,
    pub(crate) flights: Vec<FlightNotice>,
    /// Places in the list by call sign and by address; of several the first.
    by_callsign: BTreeMap<String, usize>,
    by_address: BTreeMap<u32, usize>,
    /// By call sign, who reports by ADS-B and says no address.
    pub(crate) anonymous: Invented<String>,
    pub(crate) weather: Vec<WeatherNotice>,
    pub(crate) memory: BTreeMap<u16, Memory>,
    /// Addresses of this run by the call signs that were reported with them.
    heard: BTreeMap<String, u32>,
    alerts: Alerts,
    last: Option<(u32, u64)>,
    /// End of the last scan, ns.
    pub(crate) last_ns: i64,
    /// It was started with the run: what it does not hear of its begin is lost.
    from_begin: bool,
    scans_lost: u64,
    refused: BTreeMap<String, u64>,
}

impl Gateway {
    /// Source identifier of a source: area code and identification code.
    pub(crate) fn identity(&self, sic: u8) -> [u8; 2] {
        [self.choice.sac, sic]
    }

    /// A gateway of a scene.
    #[must_use]
    pub fn new(scene: &Scene, choice: Choice) -> Self {
        let sources = scene.sensors.iter().filter_map(|sensor| {
            let sic = u8::try_from(sensor.id.0).ok().filter(|n| u16::from(*n) <= MOST_SENSORS)?;
            Some(Source { sic, kind: sensor.kind })
        });
        Self {
            choice,
            sources: sources.collect(),
            sites: scene
                .sensors
                .iter()
                .filter_map(|s| Some((u8::try_from(s.id.0).ok()?, s.site_m?.into())))
                .collect(),
            frame: scene.airport.frame,
            elevation_m: scene.airport.reference.height_m,
            icao: scene.airport.layout.icao.clone(),
            areas: AreaMap::of(&scene.airport.layout, AreaRules::default()),
            start_utc_ns: scene.run.start_utc_ns,
            scan_ns: scene.run.scan().0,
            frame_ns: scene.run.frame.0,
            shift_ns: 0,
            flights: Vec::new(),
            by_callsign: BTreeMap::new(),
            by_address: BTreeMap::new(),
            anonymous: Invented::default(),
            weather: Vec::new(),
            memory: BTreeMap::new(),
            heard: BTreeMap::new(),
            alerts: Alerts::default(),
            last: None,
            last_ns: 0,
            from_begin: false,
            scans_lost: 0,
            refused: BTreeMap::new(),
        }
    }

    /// The same, started with the run: scans before the first that it hears are lost. Of one that joins later they are not.
    #[must_use]
    pub fn from_begin(self, is: bool) -> Self {
        Self { from_begin: is, ..self }
    }

    /// Moves all times of day by a constant, so that `time_ns` of the run is `utc_ns`.
    pub fn shift_to(&mut self, time_ns: i64, utc_ns: i64) -> i64 {
        self.shift_ns = utc_ns - (self.start_utc_ns + time_ns);
        self.shift_ns
    }

    /// The flight list: addresses, types, wake categories by call sign.
    pub fn on_flights(&mut self, entries: Vec<FlightNotice>) {
        self.by_callsign.clear();
        self.by_address.clear();
        for (place, flight) in entries.iter().enumerate() {
            self.by_callsign.entry(flight.callsign.clone()).or_insert(place);
            if let Some(address) = flight.address {
                self.by_address.entry(address).or_insert(place);
            }
        }
        self.flights = entries;
    }

    /// Weather from a time on; what a restart says again takes the place of what was later.
    pub fn on_weather(&mut self, notice: WeatherNotice) {
        self.weather.retain(|w| w.from_ns < notice.from_ns);
        self.weather.push(notice);
        if self.weather.len() > 1000 {
            self.weather.remove(0);
        }
    }

    /// Changes of alerts; each may be told several times.
    pub fn on_alerts(&mut self, messages: Vec<AlertMessage>) {
        self.alerts.take(messages);
    }

    /// Stop bars, as control tells them (JSON).
    pub fn on_lights(&mut self, text: &str) {
        self.alerts.take_lights(text);
    }

    /// The run stands at a frame: that is the time, before a scan is heard.
    pub(crate) fn stands_at(&mut self, frame: u64) {
        if self.last.is_none() {
            self.last_ns = (frame as i64).saturating_mul(self.frame_ns);
        }
    }

    /// Scans that never arrived.
    #[must_use]
    pub fn scans_lost(&self) -> u64 {
        self.scans_lost
    }

    /// Records that could not be written, by reason.
    #[must_use]
    pub fn refused(&self) -> &BTreeMap<String, u64> {
        &self.refused
    }

    /// Time of day of an instant of the run, s.
    pub(crate) fn of_day_s(&self, time_ns: i64) -> f64 {
        asterix::time::of_day_s(self.utc_ns(time_ns))
    }

    pub(crate) fn utc_ns(&self, time_ns: i64) -> i64 {
        self.start_utc_ns + self.shift_ns + time_ns
    }

    /// Pressure at the reference point with that of the vapour, hPa; none before any weather is known.
    pub(crate) fn pressure_hpa(&self, time_ns: i64) -> Option<f64> {
        let weather = self.weather.iter().rev().find(|w| w.from_ns <= time_ns)?;
        // Density of vapour to its pressure: e = ρ · R_v · T.
        let vapour_hpa = weather.vapour_g_per_m3 * 1e-3 * 461.5 * weather.temperature_k / 100.0;
        Some(weather.pressure_hpa + vapour_hpa)
    }

    /// Day of `then_ns` as seen from `now_ns`: 0 today, 1 yesterday, 2 tomorrow.
    pub(crate) fn day(&self, then_ns: i64, now_ns: i64) -> u8 {
        let day = |ns| self.utc_ns(ns).div_euclid(DAY_NS);
        match day(then_ns) - day(now_ns) {
            ..0 => 1,
            0 => 0,
            _ => 2,
        }
    }

    /// Latitude and longitude in degrees of a point of the airport's plane, m east and north.
    pub(crate) fn place(&self, [east_m, north_m]: [f64; 2]) -> [f64; 2] {
        let point = self.frame.to_ecef(Enu { east_m, north_m, up_m: 0.0 });
        let place = point.to_geodetic();
        [place.lat_deg(), place.lon_deg()]
    }

    /// The flight with a call sign.
    pub(crate) fn flight(&self, callsign: &str) -> Option<&FlightNotice> {
        self.flights.get(*self.by_callsign.get(callsign).filter(|_| !callsign.is_empty())?)
    }

    /// The flight of who says no call sign, by the address that he says.
    pub(crate) fn flight_at(&self, address: Option<u32>) -> Option<&FlightNotice> {
        self.flights.get(*self.by_address.get(&address?)?)
    }

    /// The flight of who reported himself.
    pub(crate) fn flight_of(&self, plot: &PlotMessage) -> Option<&FlightNotice> {
        match plot.callsign() {
            "" => self.flight_at(plot.address),
            callsign => self.flight(callsign),
        }
    }

    /// The flight of a track: by its call sign, where it has none by the address that its target reports.
    pub(crate) fn flight_of_track(&self, track: &TrackMessage) -> Option<&FlightNotice> {
        match track.callsign.as_str() {
            "" => self.flight_at(track.address),
            callsign => self.flight(callsign),
        }
    }

    /// The address of a track: that of its flight, else what its target reports, else what came with its call sign.
    pub(crate) fn address_of_track(&self, track: &TrackMessage) -> Option<u32> {
        let of_flight = self.flight_of_track(track).and_then(|f| f.address);
        let heard = || self.heard.get(&track.callsign).copied();
        of_flight.or(track.address).or_else(heard)
    }

    /// The address of who reported himself: what he said, else that of his flight.
    pub(crate) fn address_of(&self, plot: &PlotMessage) -> Option<u32> {
        plot.address.or_else(|| self.flight_of(plot)?.address)
    }

    /// Gives an address to everybody who reports by ADS-B who he is and has none.
    pub(crate) fn invent_for(&mut self, plots: &[&PlotMessage]) {
        for plot in plots.iter().filter(|p| p.kind == SensorKind::Adsb) {
            if !plot.identity.is_empty() && self.address_of(plot).is_none() {
                self.anonymous.of(plot.identity.clone(), 0);
            }
        }
    }

    /// Whether a scan was sent already: an SMDFM that returned tells those again that it made meanwhile.
    pub(crate) fn knows(&self, scan: &ScanReport) -> bool {
        self.last.is_some_and(|(run, last)| run == scan.run && scan.scan <= last)
    }

    /// The datagrams of a scan, in the order in which a cycle is sent: starts of cycle, sensors' status, plots, 062, 011,
    /// end of batch, alerts and stop bars, fusion's status, versions. None of a scan that was sent already.
    pub fn on_scan(&mut self, scan: &ScanReport) -> Vec<Vec<u8>> {
        if self.knows(scan) {
            return Vec::new();
        }
        self.count_gap(scan);
        self.remember(scan);
        let mut out = Out { packer: Packer::new(DATAGRAM_LIMIT), refused: BTreeMap::new() };
        let begin_ns = scan.time_ns - self.scan_ns;
        let before_ns = begin_ns - self.scan_ns;
        let due = |every_s: i64| {
            let every_ns = every_s * 1_000_000_000;
            scan.scan == 1 || begin_ns.div_euclid(every_ns) != before_ns.div_euclid(every_ns)
        };
        self.cycle(&mut out, begin_ns, due(STATUS_S));
        if self.choice.sensors {
            let plots = in_order(scan);
            self.invent_for(&plots);
            for plot in plots {
                if plot.sensor > MOST_SENSORS {
                    *out.refused.entry(NO_SIC.to_owned()).or_default() += 1;
                }
                let source = self.sources.iter().find(|s| u16::from(s.sic) == plot.sensor);
                if let Some(source) = source
                    && self.choice.has(source.category(&self.choice))
                {
                    let category = source.category(&self.choice);
                    out.add(|packer| plots::record(packer, self, source, category, plot, scan));
                }
            }
        }
        if self.choice.tracks {
            self.tracks(&mut out, scan);
        }
        self.alerts.end_cycle();
        if self.choice.status && self.choice.has(65) && due(STATUS_S) {
            let time_s = self.of_day_s(scan.time_ns);
            out.add(|packer| {
                packer.record(&cat065::CATEGORY, |items| {
                    items.put(&cat065::I010, &self.identity(SMDFM_SIC))?;
                    items.put(&cat065::I000, &[1])?;
                    items.put(&cat065::I015, &[1])?;
                    items.put(&cat065::I030, &[time_s])?;
                    items.put(&cat065::I040, &[0, 0, 0, 0, 0])
                })
            });
        }
        if due(VERSIONS_S) {
            self.versions(&mut out, scan.time_ns);
        }
        for (reason, count) in out.refused {
            *self.refused.entry(reason).or_default() += count;
        }
        let ended: Vec<u16> = scan
            .tracks
            .iter()
            .filter(|t| t.status == TrackStatus::Last)
            .map(|t| t.number)
            .collect();
        ended.iter().for_each(|number| drop(self.memory.remove(number)));
        out.packer.take()
    }

    fn count_gap(&mut self, scan: &ScanReport) {
        match self.last {
            Some((run, last)) if run == scan.run => {
                self.scans_lost += scan.scan.saturating_sub(last + 1);
            }
            before => {
                if before.is_some() || self.from_begin {
                    self.scans_lost += scan.scan.saturating_sub(1);
                }
                self.memory.clear();
                self.heard.clear();
                self.anonymous = Invented::default();
                self.alerts.come_to(scan.run);
            }
        }
        self.last = Some((scan.run, scan.scan));
        self.last_ns = scan.time_ns;
    }

    /// Which plots fed which track, and when.
    fn remember(&mut self, scan: &ScanReport) {
        let alive: BTreeSet<u16> = scan.tracks.iter().map(|t| t.number).collect();
        self.memory.retain(|number, _| alive.contains(number));
        for TrackMessage { number, first, time_ns, .. } in &scan.tracks {
            let memory = self.memory.entry(*number).or_default();
            if *first || memory.first_ns == 0 {
                *memory = Memory { first_ns: *time_ns, ..Memory::default() };
            }
            let [now, before] = &mut memory.fed;
            *before = std::mem::take(now);
        }
        for plot in &scan.plots {
            let callsign = plot.callsign();
            if let Some(address) = plot.address.filter(|_| !callsign.is_empty())
                && (self.heard.len() < MOST_HEARD || self.heard.contains_key(callsign))
            {
                self.heard.insert(callsign.to_owned(), address);
            }
            let Some(memory) = plot.track.and_then(|n| self.memory.get_mut(&n)) else { continue };
            let newest = memory.plots.entry(plot.kind.word).or_insert(plot.time_ns);
            *newest = plot.time_ns.max(*newest);
            memory.fed[0].insert(plot.sensor);
        }
    }

    /// Start of cycle of every sensor that has cycles, and status where it is due.
    fn cycle(&self, out: &mut Out, begin_ns: i64, status: bool) {
        let time_s = self.of_day_s(begin_ns);
        for source in self.sources.iter().filter(|s| s.kind != SensorKind::Adsb) {
            let (sic, mlat) = (source.sic, source.category(&self.choice) == 20);
            if !self.choice.has(if mlat { 19 } else { 10 }) {
                continue;
            }
            let types: [Option<u8>; 2] = if mlat {
                [self.choice.sensors.then_some(1), (self.choice.status && status).then_some(2)]
            } else {
                [self.choice.sensors.then_some(2), (self.choice.status && status).then_some(3)]
            };
            for (message, is_status) in types.into_iter().zip([false, true]) {
                let Some(message) = message else { continue };
                out.add(|packer| {
                    if mlat {
                        packer.record(&cat019::CATEGORY, |items| {
                            items.put(&cat019::I010, &self.identity(sic))?;
                            items.put(&cat019::I000, &[message])?;
                            items.put(&cat019::I140, &[time_s])?;
                            if is_status {
                                items.put(&cat019::I550, &[0; 4])?;
                                items.put(&cat019::I600, &self.place([0.0, 0.0]))?;
                                items.put(&cat019::I610, &[self.elevation_m])?;
                                // The scene's heights are above the ellipsoid and above the sea alike.
                                items.put(&cat019::I620, &[0])?;
                            }
                            Ok(())
                        })
                    } else {
                        packer.record(&cat010::CATEGORY, |items| {
                            items.put(&cat010::I010, &self.identity(sic))?;
                            items.put(&cat010::I000, &[message])?;
                            items.put(&cat010::I140, &[time_s])?;
                            if is_status {
                                items.put(&cat010::I550, &[0; 5])?;
                            }
                            Ok(())
                        })
                    }
                });
            }
        }
    }

    fn tracks(&self, out: &mut Out, scan: &ScanReport) {
        let mut tracks: Vec<_> = scan.tracks.iter().collect();
        tracks.sort_by_key(|t| t.number);
        if self.choice.has(62) {
            for track in &tracks {
                out.add(|packer| tracks::record_062(packer, self, track));
            }
        }
        if self.choice.has(11) {
            let marks = self.alerts.marks(scan);
            for track in &tracks {
                let mark = marks.get(&track.number);
                out.add(|packer| tracks::record_011(packer, self, track, mark));
            }
        }
        if self.choice.has(65) {
            let time_s = self.of_day_s(scan.time_ns);
            out.add(|packer| {
                packer.record(&cat065::CATEGORY, |items| {
                    items.put(&cat065::I010, &self.identity(SMDFM_SIC))?;
                    items.put(&cat065::I000, &[2])?;
                    items.put(&cat065::I015, &[1])?;
                    items.put(&cat065::I030, &[time_s])?;
                    items.put(&cat065::I020, &[scan.scan as u8])
                })
            });
        }
        if self.choice.has(4) {
            for alert in self.alerts.of_004() {
                out.add(|packer| alerts::record_004(packer, self, alert, scan));
            }
        }
        let banks = self.alerts.banks();
        if self.choice.has(11) && !banks.is_empty() {
            out.add(|packer| alerts::record_bars(packer, self, &banks, scan.time_ns));
        }
    }

    /// Category 247: the editions in use.
    fn versions(&self, out: &mut Out, time_ns: i64) {
        if !self.choice.has(247) {
            return;
        }
        let used = CATEGORIES.iter().filter(|c| self.choice.has(**c));
        let known = used.filter_map(|number| asterix::category(*number));
        let editions: Vec<u8> = known.flat_map(|c| [c.number, c.edition.0, c.edition.1]).collect();
        let time_s = self.of_day_s(time_ns);
        out.add(|packer| {
            packer.record(&cat247::CATEGORY, |items| {
                items.put(&cat247::I010, &self.identity(SMDFM_SIC))?;
                items.put(&cat247::I015, &[1])?;
                items.put(&cat247::I140, &[time_s])?;
                items.put(&cat247::I550, &editions)
            })
        });
    }
}

/// The plots of a scan as they are sent.
pub(crate) fn in_order(scan: &ScanReport) -> Vec<&PlotMessage> {
    let mut plots: Vec<_> = scan.plots.iter().collect();
    plots.sort_by_key(|p| (p.sensor, p.sequence));
    plots
}

/// Datagrams being filled, and what could not be written into them.
struct Out {
    packer: Packer,
    refused: BTreeMap<String, u64>,
}

impl Out {
    fn add(&mut self, write: impl FnOnce(&mut Packer) -> Result<(), EncodeError>) {
        if let Err(e) = write(&mut self.packer) {
            *self.refused.entry(e.to_string()).or_default() += 1;
        }
    }
}

#[cfg(test)]
mod address_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod value_tests;
