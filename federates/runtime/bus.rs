//! The synchronisation plane as federates see it: notify, request, liveliness. No message is known here.
//!
//! Keys are relative ("ctl/order"); an implementation puts `seeds/{exercise}/` before them. In patterns
//! `*` is one part between slashes and `**` any number of parts at the end. Callbacks run on threads of
//! the bus and must only hand the octets on.

use super::codec::Parts;
use super::succession::STATIONS;
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Whether a message may be lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Must arrive; a slow receiver holds the sender back (for at most half a second).
    Must,
    /// Dropped for receivers that do not keep up; never blocks. All that spectators read.
    Lossy,
}

/// Receives (key, octets).
pub type Sink = Box<dyn Fn(&str, &[u8]) + Send + Sync>;

/// Receives each reply, then `None` once: no more will come.
pub type Replies = Box<dyn FnMut(Option<Vec<u8>>) + Send>;

/// Receives (key, alive).
pub type AliveSink = Box<dyn Fn(&str, bool) + Send + Sync>;

/// A question that wants one answer.
pub struct Request {
    /// What was asked.
    pub body: Vec<u8>,
    reply: Box<dyn FnOnce(Vec<u8>) + Send>,
}

impl Request {
    /// A request whose answer goes to `reply`.
    pub fn new(body: Vec<u8>, reply: impl FnOnce(Vec<u8>) + Send + 'static) -> Self {
        Self { body, reply: Box::new(reply) }
    }
    /// Answers. A request dropped without an answer ends at its deadline.
    pub fn answer(self, body: Vec<u8>) {
        (self.reply)(body);
    }
}

impl std::fmt::Debug for Request {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Request({} octets)", self.body.len())
    }
}

/// Why the bus failed, with what a person can do.
#[derive(Debug, thiserror::Error)]
pub enum BusError {
    /// Opening, listening or connecting failed.
    #[error("synchronisation plane: {doing}: {reason}")]
    Open {
        /// What was attempted.
        doing: String,
        /// Why it failed.
        reason: String,
    },
    /// An open session failed to do something.
    #[error("synchronisation plane: {doing} '{key}': {reason}")]
    Use {
        /// What was attempted.
        doing: &'static str,
        /// Key concerned.
        key: String,
        /// Why it failed.
        reason: String,
    },
}

/// Notify, request/reply and liveliness. Everything declared lives as long as the bus.
pub trait Bus: Send + Sync {
    /// Sends `body` to all present subscribers of `key`.
    ///
    /// # Errors
    /// If the session is closed.
    fn publish(&self, key: &str, class: Class, body: Vec<u8>) -> Result<(), BusError>;
    /// Calls `sink` for every message whose key matches `pattern`, in the order of each sender.
    ///
    /// # Errors
    /// If the session is closed.
    fn subscribe(&self, pattern: &str, sink: Sink) -> Result<(), BusError>;
    /// Answers requests for `key`.
    ///
    /// # Errors
    /// If the session is closed.
    fn serve(&self, key: &str, handler: Box<dyn Fn(Request) + Send + Sync>)
    -> Result<(), BusError>;
    /// Asks whoever serves `key`; `replies` gets every answer and then `None`.
    ///
    /// # Errors
    /// If the session is closed.
    fn request(
        &self,
        key: &str,
        body: Vec<u8>,
        deadline: Duration,
        replies: Replies,
    ) -> Result<(), BusError>;
    /// Shows `key` as alive until the bus is closed or the process dies.
    ///
    /// # Errors
    /// If the session is closed.
    fn announce(&self, key: &str) -> Result<(), BusError>;
    /// Calls `sink` when a key that matches `pattern` comes to life or dies; those alive now first.
    ///
    /// # Errors
    /// If the session is closed.
    fn watch(&self, pattern: &str, sink: AliveSink) -> Result<(), BusError>;
    /// Leaves; nothing is sent or received afterwards.
    fn close(&self);
}

/// Calls `heard` for every message whose key matches `pattern`, of those that may come in parts.
///
/// # Errors
/// If the session is closed.
pub fn hear_parts<T: DeserializeOwned>(
    bus: &dyn Bus,
    pattern: &str,
    heard: impl Fn(T) + Send + Sync + 'static,
) -> Result<(), BusError> {
    let parts = Mutex::new(Parts::default());
    let sink = move |key: &str, octets: &[u8]| {
        let taken = parts.lock().unwrap_or_else(PoisonError::into_inner).take(octets);
        match taken {
            Ok(Some(message)) => heard(message),
            Ok(None) => {}
            Err(error) => tracing::warn!(key, %error, "a message was dropped"),
        }
    };
    bus.subscribe(pattern, Box::new(sink))
}

/// Calls `sink` when an administration station comes to life, or the last one is gone: the one, or its standby that leads in its place.
///
/// # Errors
/// If the session is closed.
pub fn watch_stations(
    bus: &dyn Bus,
    sink: impl Fn(bool) + Send + Sync + 'static,
) -> Result<(), BusError> {
    let (there, sink) = (Arc::new(Mutex::new(BTreeSet::new())), Arc::new(sink));
    for name in STATIONS {
        let (there, sink) = (Arc::clone(&there), Arc::clone(&sink));
        let told = move |key: &str, alive: bool| {
            let mut there = there.lock().unwrap_or_else(PoisonError::into_inner);
            let changed = if alive { there.insert(key.to_owned()) } else { there.remove(key) };
            if changed && (alive || there.is_empty()) {
                sink(alive);
            }
        };
        bus.watch(&format!("alive/{name}/*"), Box::new(told))?;
    }
    Ok(())
}

/// Asks and waits for the first answer; `None` if none came before `deadline`.
///
/// # Errors
/// If the session is closed.
pub fn ask(
    bus: &dyn Bus,
    key: &str,
    body: Vec<u8>,
    deadline: Duration,
) -> Result<Option<Vec<u8>>, BusError> {
    let (send, receive) = crossbeam_channel::unbounded();
    bus.request(
        key,
        body,
        deadline,
        Box::new(move |reply| {
            let _ = send.send(reply);
        }),
    )?;
    // One second beyond the deadline: the bus reports its end itself.
    Ok(receive.recv_timeout(deadline + Duration::from_secs(1)).ok().flatten())
}

/// Whether `key` matches `pattern`.
#[must_use]
pub fn matches(pattern: &str, key: &str) -> bool {
    let (mut parts, mut keys) = (pattern.split('/'), key.split('/'));
    loop {
        match (parts.next(), keys.next()) {
            (Some("**"), _) | (None, None) => return true,
            (Some("*"), Some(_)) => {}
            (Some(part), Some(key)) if part == key => {}
            _ => return false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::local_bus::LocalHub;
    use super::*;

    #[test]
    fn a_station_is_there_while_one_of_the_two_is() {
        let hub = LocalHub::default();
        let heard = Arc::new(Mutex::new(Vec::new()));
        let told = Arc::clone(&heard);
        let member = hub.join();
        watch_stations(&member, move |alive| told.lock().expect("heard").push(alive))
            .expect("watched");
        let (station, standby) = (hub.join(), hub.join());
        station.announce("alive/admin-station/1").expect("there");
        standby.announce("alive/admin-station-standby/1").expect("there");
        station.close();
        assert_eq!(*heard.lock().expect("heard"), [true, true]);
        standby.close();
        assert_eq!(*heard.lock().expect("heard"), [true, true, false]);
    }

    #[test]
    fn patterns() {
        assert!(matches("fed/*", "fed/smdfm"));
        assert!(!matches("fed/*", "fed/smdfm/x"));
        assert!(matches("obs/**", "obs/fed/smdfm"));
        assert!(matches("ctl/order", "ctl/order"));
        assert!(!matches("ctl/order", "ctl"));
        assert!(!matches("ctl", "ctl/order"));
    }
}

#[cfg(test)]
mod part_tests {
    use super::super::codec::{LIMIT, encode, encode_parts, encoded_size};
    use super::super::local_bus::LocalHub;
    use super::super::messages::{PlotMessage, ScanReport};
    use super::*;
    use models::frames::Point2;

    /// Four sensors' plots of 4096 targets, each with what 14 effects did to it: 14 MB.
    #[test]
    fn a_scan_of_four_thousand_explained_targets_arrives() {
        let effect = |n: u32| (format!("effect number {n}"), f64::from(n), "dB".to_owned());
        let plot = |n: u32| PlotMessage {
            sensor: (n % 4) as u16,
            kind: models::plot::SensorKind::Asde,
            time_ns: n.into(),
            position_m: Point2::origin(),
            cov_m2: [1.0; 3],
            ellipse: [1.0; 4],
            altitude_m: None,
            velocity_mps: None,
            polar: Some([1.0; 4]),
            scnr_db: Some(20.0),
            identity: format!("SWR{n}"),
            address: None,
            cause: format!("SWR{n}"),
            truth_m: Some(Point2::origin()),
            sequence: n,
            track: Some(n as u16),
            effects: (0..14).map(effect).collect(),
        };
        let report = ScanReport {
            scan: 7,
            plots: (0..4 * 4096).map(plot).collect(),
            ..ScanReport::default()
        };
        assert!(encoded_size(&report) as u64 > LIMIT, "{} octets", encoded_size(&report));
        let hub = LocalHub::default();
        let (smdfm, viewer) = (hub.join(), hub.join());
        let heard = Arc::new(Mutex::new(Vec::new()));
        let scans = Arc::clone(&heard);
        hear_parts(&viewer, "tracks/1/scan", move |scan: ScanReport| {
            scans.lock().unwrap_or_else(PoisonError::into_inner).push(scan);
        })
        .expect("heard");
        for part in encode_parts(&report) {
            assert!((part.len() as u64) < 1 << 20, "each within the bound of a message");
            smdfm.publish("tracks/1/scan", Class::Lossy, part).expect("said");
        }
        smdfm.publish("tracks/1/scan", Class::Lossy, encode(&ScanReport::default())).expect("said");
        let heard = heard.lock().unwrap_or_else(PoisonError::into_inner);
        assert_eq!(heard.len(), 2);
        assert!(heard[0] == report && heard[1] == ScanReport::default());
    }
}
