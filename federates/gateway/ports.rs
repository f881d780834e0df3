//! All ports of the gateway beside ASTERIX: Beast, SBS, HTTP, the public plane, FlightGear.

use super::adsb::{Origin, Piece};
use super::board::Board;
use super::clients::{Clients, Served};
use super::flightgear;
use super::http::Http;
use super::public_bus::{PublicConfig, PublicPlane};
use crate::runtime::clock::monotonic_ns;
use crate::runtime::messages::{
    FederateStatus, FlightNotice, Operation, RunState, ScanReport, SeatMessage, WeatherNotice,
};
use anyhow::Context;
use std::collections::VecDeque;
use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::time::Duration;

/// What is to be opened.
#[derive(Clone, Debug, Default)]
pub struct Feeds {
    /// Beast frames to whoever connects.
    pub beast: Option<SocketAddr>,
    /// SBS lines to whoever connects.
    pub sbs: Option<SocketAddr>,
    /// HTTP.
    pub http: Option<SocketAddr>,
    /// The public plane.
    pub public: Option<PublicConfig>,
    /// Targets without address get one.
    pub invent: bool,
    /// Whose positions squitters have.
    pub adsb_from: Origin,
    /// FlightGear multiplayer packets go there.
    pub flightgear: Vec<SocketAddr>,
    /// GDL 90 messages go there.
    pub gdl90: Vec<SocketAddr>,
}

impl Feeds {
    /// Whether anything is to be opened.
    #[must_use]
    pub fn asked(&self) -> bool {
        self.beast.is_some()
            || self.sbs.is_some()
            || self.http.is_some()
            || self.public.is_some()
            || !self.flightgear.is_empty()
            || !self.gdl90.is_empty()
    }
}

/// Open ports.
pub struct Ports {
    board: Arc<Board>,
    notes: Vec<String>,
    motions: flightgear::Motions,
    beast: Option<Clients>,
    sbs: Option<Clients>,
    http: Option<Http>,
    public: Option<PublicPlane>,
    flightgear: Option<(UdpSocket, Vec<SocketAddr>)>,
    gdl90: Option<(UdpSocket, Vec<SocketAddr>)>,
    gdl90_datagrams: u64,
    pending: VecDeque<(u64, Piece)>,
    rate: f64,
    packets: u64,
}

impl Ports {
    /// Opens all that is asked for.
    ///
    /// # Errors
    /// If one cannot be opened: which, why, and what to do.
    pub fn open(feeds: &Feeds, board: Board) -> anyhow::Result<Self> {
        let board = Arc::new(board);
        let listen = |address: Option<SocketAddr>, flag: &str| {
            let open = |a| Clients::listen(a).with_context(|| taken(flag, a));
            address.map(open).transpose()
        };
        let beast = listen(feeds.beast, "--beast")?;
        let sbs = listen(feeds.sbs, "--sbs")?;
        let serve = |address| {
            Http::serve(address, Arc::clone(&board)).with_context(|| taken("--http", address))
        };
        let http = feeds.http.map(serve).transpose()?;
        let mut notes = Vec::new();
        let public = match feeds
            .public
            .as_ref()
            .map(|c| (c, PublicPlane::open(c, Arc::clone(&board))))
        {
            Some((config, Ok(plane))) => {
                notes.push(format!("the public interface is at {}", config.endpoint));
                Some(plane)
            }
            Some((config, Err(_))) if !config.asked => {
                notes.push(format!(
                    "{} is taken: no public interface (--public tcp/127.0.0.1:PORT gives it another place)",
                    config.endpoint
                ));
                None
            }
            Some((_, Err(error))) => return Err(error.into()),
            None => None,
        };
        let (flightgear, gdl90) = (sender(&feeds.flightgear)?, sender(&feeds.gdl90)?);
        Ok(Self {
            board,
            notes,
            motions: flightgear::Motions::default(),
            beast,
            sbs,
            http,
            public,
            flightgear,
            gdl90,
            gdl90_datagrams: 0,
            pending: VecDeque::new(),
            rate: 1.0,
            packets: 0,
        })
    }

    /// Sentences for the person who started it: where each port is.
    #[must_use]
    pub fn places(&self) -> Vec<String> {
        let mut places = Vec::new();
        if let Some(port) = &self.beast {
            let address = port.address();
            let command = self.board.decoder_command(address);
            places.push(format!(
                "Beast at {address}; a decoder needs the place of its receiver: {command}"
            ));
        }
        if let Some(port) = &self.sbs {
            places.push(format!("SBS lines at {}", port.address()));
        }
        if let Some(http) = &self.http {
            places.push(format!("HTTP at http://{}/api/v1/state{}", http.address(), http.key()));
        }
        places.extend(self.notes.iter().cloned());
        places
    }

    /// A scan: published, and the next second of squitters planned.
    pub fn on_scan(&mut self, scan: &Arc<ScanReport>) {
        let now_ns = monotonic_ns();
        self.send_until(u64::MAX); // what the scan before still had
        for piece in self.board.on_scan(scan) {
            let later_s = (piece.time_ns - scan.time_ns) as f64 * 1e-9 / self.rate;
            self.pending.push_back((now_ns + (later_s * 1e9) as u64, piece));
        }
        self.send_until(now_ns);
        if let Some((socket, to)) = &self.flightgear {
            for packet in flightgear::packets(scan, &self.board, &mut self.motions) {
                for address in to {
                    self.packets += u64::from(socket.send_to(&packet, address).is_ok());
                }
            }
        }
        if let Some((socket, to)) = &self.gdl90 {
            for datagram in self.board.gdl90() {
                for address in to {
                    self.gdl90_datagrams += u64::from(socket.send_to(&datagram, address).is_ok());
                }
            }
        }
        self.publish(&["scan", "tracks", "plots", "truth"]);
    }

    fn publish(&mut self, keys: &[&str]) {
        if let Some(public) = &mut self.public {
            keys.iter().for_each(|key| public.publish(key));
        }
    }

    /// Sends what is due.
    pub fn send_until(&mut self, now_ns: u64) {
        while self.pending.front().is_some_and(|(due_ns, _)| *due_ns <= now_ns) {
            let Some((_, piece)) = self.pending.pop_front() else { return };
            if let Some(port) = &self.beast {
                port.send(&piece.beast);
            }
            if let Some(port) = &self.sbs {
                port.send(piece.sbs.as_bytes());
            }
        }
    }

    /// How long until something is due, at most `most`.
    #[must_use]
    pub fn next_due(&self, most: Duration) -> Duration {
        let due = self.pending.front().map(|(due_ns, _)| due_ns.saturating_sub(monotonic_ns()));
        due.map_or(most, |ns| most.min(Duration::from_nanos(ns)))
    }

    /// How the run stands.
    pub fn on_state(&mut self, state: &RunState) {
        self.rate = if state.rate > 0.0 { state.rate } else { 1.0 };
        self.board.on_state(state.clone());
        self.publish(&["state"]);
    }

    /// The state again, so that clients know that somebody is there.
    pub fn say_state(&mut self) {
        self.publish(&["state"]);
    }

    /// The flight list.
    pub fn on_flights(&mut self, entries: &[FlightNotice]) {
        self.board.on_flights(entries.to_vec());
        self.publish(&["flights"]);
    }

    /// Weather from a time on.
    pub fn on_weather(&mut self, notice: &WeatherNotice) {
        self.board.on_weather(notice.clone());
        self.publish(&["weather"]);
    }

    /// An operator's command.
    pub fn on_operation(&mut self, operation: Operation) {
        self.board.on_operation(operation);
        self.publish(&["operation"]);
    }

    /// What was asked of the traffic.
    pub fn on_inputs(&mut self, told: &[SeatMessage]) {
        if self.board.on_inputs(told) {
            self.publish(&["handovers"]);
        }
    }

    /// Load and counters of a federate.
    pub fn on_federate(&mut self, status: FederateStatus) {
        let key = format!("federate/{}", status.name);
        self.board.on_federate(status);
        self.publish(&[&key]);
    }

    /// Moves all times.
    pub fn shift_to(&self, time_ns: i64, utc_ns: i64) {
        self.board.shift_to(time_ns, utc_ns);
    }

    /// Clients that were dropped or turned away, by port, with their addresses as alarms.
    #[must_use]
    pub fn told(&self) -> (Vec<(String, u64)>, Vec<String>) {
        let (mut counts, mut alarms) = (Vec::new(), Vec::new());
        for (name, port) in [("beast", &self.beast), ("sbs", &self.sbs)] {
            let Some(port) = port else { continue };
            let Served { dropped, turned_away, dropped_names, .. } = port.served();
            counts.push((format!("{name} clients that did not read"), dropped));
            counts.push((format!("{name} clients without a place"), turned_away));
            let alarm = |who| format!("{name}: the client at {who} did not read and was dropped");
            alarms.extend(dropped_names.into_iter().map(alarm));
        }
        let (_, refused) = self.board.squitters();
        counts.push(("targets that no squitter can say".to_owned(), refused));
        counts.retain(|(_, count)| *count > 0);
        (counts, alarms)
    }

    /// Figures for the last line of the gateway.
    #[must_use]
    pub fn figures(&self) -> serde_json::Value {
        let served = |port: &Option<Clients>| {
            port.as_ref().map(|p| {
                let served = p.served();
                serde_json::json!({"clients": served.in_all, "octets": served.octets, "dropped": served.dropped})
            })
        };
        serde_json::json!({
            "squitters": self.board.squitters().0,
            "beast": served(&self.beast),
            "sbs": served(&self.sbs),
            "published": self.public.as_ref().map(|p| p.published),
            "flightgear_packets": self.flightgear.as_ref().map(|_| self.packets),
            "gdl90_datagrams": self.gdl90.as_ref().map(|_| self.gdl90_datagrams),
        })
    }

    /// Says that the run is over, flushes and closes every port.
    pub fn close(&mut self) {
        self.board.on_end();
        self.publish(&["state"]);
        self.send_until(u64::MAX);
        for port in [&self.beast, &self.sbs].into_iter().flatten() {
            port.close(Duration::from_secs(1));
        }
        if let Some(http) = self.http.take() {
            http.stop();
        }
        if let Some(public) = self.public.take() {
            public.close();
        }
    }
}

/// A socket that sends to these, by the family of the first; none where there is nobody.
fn sender(to: &[SocketAddr]) -> std::io::Result<Option<(UdpSocket, Vec<SocketAddr>)>> {
    let Some(first) = to.first() else { return Ok(None) };
    let socket = UdpSocket::bind(if first.is_ipv4() { "0.0.0.0:0" } else { "[::]:0" })?;
    socket.set_broadcast(true)?;
    Ok(Some((socket, to.to_vec())))
}

fn taken(flag: &str, address: SocketAddr) -> String {
    format!("{flag} {address}: end the program that uses it, or choose another address")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gateway::commands::Rights;

    /// The place that a gateway has for clients by itself may be another run's: said, and no failure. One that was asked for is.
    #[test]
    fn a_public_port_that_is_taken_fails_only_who_asked_for_it() {
        let scene = scenarios::load_without_truth(&scenarios::locate("zurich")).expect("the scene");
        let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
        let place = taken.local_addr().expect("its address");
        let open = |asked| {
            let public = PublicConfig {
                endpoint: format!("tcp/{place}"),
                asked,
                exercise: 1,
                certs: None,
                rights: Rights::ReadOnly(String::new()),
            };
            let feeds = Feeds { public: Some(public), ..Feeds::default() };
            Ports::open(&feeds, Board::new(&scene, 1, false))
        };
        assert!(open(true).is_err(), "asked for");
        let ports = open(false).expect("goes on without");
        let said = ports.places();
        assert!(ports.public.is_none() && said.len() == 1, "{said:?}");
        assert!(said[0].contains(&place.to_string()) && said[0].contains("is taken"), "{said:?}");
        drop(taken);
        let mut ports = open(false).expect("free now");
        assert!(
            ports.public.is_some() && ports.places()[0].contains("is at"),
            "{:?}",
            ports.places()
        );
        ports.close();
    }
}
