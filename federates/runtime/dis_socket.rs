//! The data plane over UDP: sound PDUs of this exercise in, PDUs out.

use super::cli::NetworkArgs;
use super::data_plane::DataPlane;
use super::digest::pdu_hash;
use super::federate::Octets;
use super::hearing::Plane;
use super::member_driver::Event;
use super::senders::{NO_SENDER, NO_SITE, Senders};
use super::threads::spawn_watched;
use crate::exchange::stamp::is_stamped;
use crossbeam_channel::Sender;
use datalink::{Bundle, Destination, Destinations, LinkConfig, Packing};
use pdu::enumerations::{DatumId, PduType};
use pdu::management::EventReport;
use pdu::records::{EntityId, VariableDatum};
use pdu::{Body, DisTime, Envelope};
use std::collections::{BTreeMap, BTreeSet};
use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// What a federate wants of the datagrams that arrive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiving {
    /// DIS exercise.
    pub exercise: u8,
    /// DIS site of the federation.
    pub site: u16,
    /// Whether it reads PDUs at all; producers do not.
    pub consumes: bool,
    /// Share of truth datagrams dropped on purpose.
    pub loss: f64,
}

/// Where DIS goes: the command line, else the scene.
///
/// # Errors
/// If `--dis` is no list of addresses.
pub fn link_config(args: &NetworkArgs, scene: &scenarios::Network) -> anyhow::Result<LinkConfig> {
    let to = match &args.dis {
        Some(text) => {
            text.parse::<Destinations>().map_err(|e| anyhow::anyhow!("--dis {text}: {e}"))?
        }
        None => Destinations::new(scene.dis.iter().map(|a| Destination::of(*a)).collect())
            .map_err(|e| anyhow::anyhow!("network.dis: {e}"))?,
    };
    let first = to.first().ip();
    // Traffic of 127.x belongs on the loopback interface.
    let loopback = matches!(first, IpAddr::V4(ip) if ip.is_loopback());
    let interface =
        args.interface.or(scene.interface).or(loopback.then_some(IpAddr::from([127, 0, 0, 1])));
    Ok(LinkConfig { to, interface, ttl: args.ttl.unwrap_or(scene.ttl), ..LinkConfig::default() })
}

/// Opens the data plane of a member; what arrives goes to `events`.
///
/// # Errors
/// What is wrong with address, interface or port, in one sentence.
pub fn open(
    args: &NetworkArgs,
    scene: &scenarios::Network,
    receiving: Receiving,
    events: Sender<Event>,
) -> anyhow::Result<Box<dyn DataPlane>> {
    let config = link_config(args, scene)?;
    let drops = Arc::new(AtomicU64::new(0));
    let mut buffer = (0, 0);
    let sender = if receiving.consumes {
        let (sender, mut receiver) = datalink::Link::open(&config)?;
        buffer = receiver.buffer_octets();
        for warning in receiver.warnings() {
            tracing::warn!("{warning}");
        }
        let told = Arc::clone(&drops);
        let dead = events.clone();
        let failed = move |why| drop(dead.send(Event::Failed(why)));
        let senders = Senders::of(args, scene, &config);
        spawn_watched("the receiver of DIS", failed, move || {
            let mut sorter = Sorter::new(receiving).with_senders(senders);
            loop {
                let mut pdus = Vec::new();
                let got = receiver.receive(None, |arrival| {
                    sorter.sort_of(arrival.from.ip(), arrival.payload, &mut pdus);
                });
                told.store(receiver.dropped(), Ordering::Relaxed);
                if let Err(e) = got {
                    let _ = events.send(Event::Failed(format!("receiving DIS: {e}")));
                    return;
                }
                let sent = pdus.is_empty() || events.send(Event::Pdus(pdus)).is_ok();
                let told =
                    sorter.take_drops().all(|(r, n)| events.send(Event::Dropped(r, n)).is_ok());
                let mut probed = sorter.take_probes();
                let probed = probed.all(|(p, long)| events.send(Event::Probe(p, long)).is_ok());
                if !sent || !told || !probed {
                    return;
                }
            }
        })?;
        sender
    } else {
        datalink::Sender::open(&config)?
    };
    let interface = config.interface.map(|i| i.to_string());
    let plane = Plane {
        group: config.to.to_string(),
        interface: interface.unwrap_or_else(|| "the interface that the system chose".to_owned()),
        loss: receiving.loss,
    };
    let bundle = scene.bundle;
    Ok(Box::new(UdpPlane { sender, bundle, refused: 0, drops, buffer, receiving, plane }))
}

/// Hears everything on the data plane, on a thread of its own, until the process ends.
///
/// # Errors
/// What is wrong with address, interface or port, in one sentence.
pub fn listen(
    args: &NetworkArgs,
    scene: &scenarios::Network,
    failed: impl Fn(String) + Clone + Send + 'static,
    mut heard: impl FnMut(&datalink::Arrival<'_>) + Send + 'static,
) -> anyhow::Result<()> {
    let mut receiver = datalink::Receiver::open(&link_config(args, scene)?)?;
    let died = failed.clone();
    spawn_watched("the receiver of DIS", died, move || {
        loop {
            if let Err(e) = receiver.receive(None, |arrival| heard(&arrival)) {
                return failed(format!("receiving DIS: {e}"));
            }
        }
    })?;
    Ok(())
}

/// Sorts datagrams: sound truth and weather of the exercise, anything else, unsound ones.
pub struct Sorter {
    receiving: Receiving,
    senders: Senders,
    arrived: u64,
    drops: BTreeMap<&'static str, u64>,
    probes: BTreeSet<(String, bool)>,
}

impl Sorter {
    /// A sorter.
    #[must_use]
    pub fn new(receiving: Receiving) -> Self {
        let (drops, probes) = (BTreeMap::new(), BTreeSet::new());
        Self { receiving, senders: Senders::default(), arrived: 0, drops, probes }
    }

    /// The same, which takes only what these lists allow.
    #[must_use]
    pub fn with_senders(self, senders: Senders) -> Self {
        Self { senders, ..self }
    }

    /// Appends the PDUs of a datagram of `from` that the federate reads.
    pub fn sort_of(&mut self, from: IpAddr, datagram: &[u8], pdus: &mut Vec<Octets>) {
        if self.senders.takes(from) {
            self.sort(datagram, pdus);
        } else {
            *self.drops.entry(NO_SENDER).or_default() += 1;
        }
    }

    /// Appends the PDUs of a datagram that the federate reads.
    pub fn sort(&mut self, datagram: &[u8], pdus: &mut Vec<Octets>) {
        self.arrived += 1;
        for received in pdu::pdus(datagram) {
            let received = match received {
                Ok(received) => received,
                Err(e) => {
                    let reason = if e.is_trailing() {
                        "octets after the last PDU of a datagram"
                    } else {
                        "not a sound PDU"
                    };
                    *self.drops.entry(reason).or_default() += 1;
                    tracing::debug!("a PDU was dropped: {e}");
                    continue;
                }
            };
            if received.header().exercise_id != self.receiving.exercise {
                *self.drops.entry("PDU of another exercise").or_default() += 1;
                continue;
            }
            let site = received.octets.get(12..14).map(|o| u16::from_be_bytes([o[0], o[1]]));
            if site.is_some_and(|site| !self.senders.takes_site(site, self.receiving.site)) {
                *self.drops.entry(NO_SITE).or_default() += 1;
                continue;
            }
            let pdu_type = received.header().pdu_type;
            if pdu_type == PduType::ENTITY_STATE && self.lose(received.octets) {
                continue;
            }
            let read = [PduType::ENTITY_STATE, PduType::ENVIRONMENTAL_PROCESS, PduType::IFF];
            if read.contains(&pdu_type) || is_stamped(received.octets) {
                pdus.push(Arc::from(received.octets));
            }
            if pdu_type == PduType::EVENT_REPORT && self.probes.len() < PROBES {
                self.probes.extend(probe_of(&received, self.receiving.site));
            }
        }
    }

    /// Producers whose probes came since the last call, and whether long ones did.
    pub fn take_probes(&mut self) -> impl Iterator<Item = (String, bool)> + use<> {
        std::mem::take(&mut self.probes).into_iter()
    }

    /// Loss on purpose: by a hash of the PDU and its number, so that it needs no generator.
    fn lose(&self, octets: &[u8]) -> bool {
        if self.receiving.loss <= 0.0 {
            return false;
        }
        let mixed = pdu_hash(octets) ^ self.arrived.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed >> 11) as f64 / (1u64 << 53) as f64 <= self.receiving.loss
    }

    /// What was dropped since the last call.
    pub fn take_drops(&mut self) -> impl Iterator<Item = (&'static str, u64)> + use<> {
        std::mem::take(&mut self.drops).into_iter()
    }
}

/// Names kept from one arrival to the next, at most: anybody may send probes.
const PROBES: usize = 64;

/// DIS application of a probe: neither traffic nor world.
const PROBE_APPLICATION: u16 = 65_001;

/// A probe that is longer is a long one: filled up to the longest datagram that is sent.
const LONG_OCTETS: usize = 1024;

/// A probe: an Event Report PDU that names its federate; a long one says nothing more.
fn probe(receiving: Receiving, name: &str, long: bool) -> Option<Octets> {
    let text = format!("SEEDS probe {name}");
    let encoded = |filling: &[u8]| {
        // SISO-REF-010: datum identifiers of free text are the user's own; 0 says nothing.
        let mut datums = vec![VariableDatum::new(DatumId(0), text.as_bytes())];
        if !filling.is_empty() {
            datums.push(VariableDatum::new(DatumId(0), filling));
        }
        let report = EventReport {
            originating_id: EntityId::new(receiving.site, PROBE_APPLICATION, 0),
            receiving_id: EntityId::ALL,
            variable_datums: datums.into(),
            ..EventReport::default()
        };
        let mut octets = Vec::new();
        Envelope::new(receiving.exercise, DisTime::relative(0))
            .append(&report, &mut octets)
            .ok()?;
        Some(octets)
    };
    let mut octets = encoded(&[])?;
    if long {
        // The head of a datum takes 8 octets, and it ends on a multiple of 8.
        let left = Bundle::default().most_octets.saturating_sub(octets.len() + 8) & !7;
        octets = encoded(&vec![0; left])?;
    }
    Some(octets.into())
}

/// The name in a probe, and whether it is a long one.
fn probe_of(received: &pdu::Received<'_>, site: u16) -> Option<(String, bool)> {
    let Body::EventReport(report) = received.body() else { return None };
    if report.originating_id != EntityId::new(site, PROBE_APPLICATION, 0) {
        return None;
    }
    let text = std::str::from_utf8(report.variable_datums.iter().next()?.value).ok()?;
    let name = text.strip_prefix("SEEDS probe ")?.trim_end_matches('\0');
    let long = received.octets.len() > LONG_OCTETS;
    (name.len() <= 64).then(|| (name.to_owned(), long))
}

struct UdpPlane {
    sender: datalink::Sender,
    bundle: Option<bool>,
    refused: u64,
    drops: Arc<AtomicU64>,
    buffer: (usize, usize),
    receiving: Receiving,
    plane: Plane,
}

/// Of so many PDUs of one frame several travel in a datagram, if the scene does not say otherwise: a burst of single ones
/// overflows receivers.
const MANY_PDUS: usize = 64;

impl DataPlane for UdpPlane {
    fn send(&mut self, pdus: &[Octets]) {
        let several = self.bundle.unwrap_or(pdus.len() >= MANY_PDUS);
        let bundle = several.then(Bundle::default);
        self.sender.set_packing(Packing { bundle, ..Packing::default() });
        if let Err(e) = self.sender.send_all(pdus.iter().map(|p| &p[..])) {
            if self.refused == 0 {
                tracing::warn!("sending DIS: {e}; what does not arrive is repaired by request");
            }
            self.refused += pdus.len() as u64;
        }
    }
    fn refused(&self) -> u64 {
        self.refused
    }
    fn kernel_drops(&self) -> u64 {
        self.drops.load(Ordering::Relaxed)
    }
    fn buffer_octets(&self) -> (usize, usize) {
        self.buffer
    }
    fn plane(&self) -> Option<Plane> {
        Some(self.plane.clone())
    }
    fn probe(&mut self, name: &str) {
        for long in [false, true] {
            if let Some(octets) = probe(self.receiving, name, long) {
                self.send(&[octets]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_probe_is_heard_by_its_own_federation_only() {
        let receiving = Receiving { exercise: 3, site: 9, consumes: true, loss: 0.5 };
        let octets = [false, true]
            .map(|long| probe(receiving, "traffic-generator-2", long).expect("it encodes"));
        let lengths = octets.each_ref().map(|octets| octets.len());
        assert!(lengths[0] < 100 && (1393..=1400).contains(&lengths[1]), "{lengths:?}");
        for (other, heard) in [
            (receiving, true),
            (Receiving { exercise: 4, ..receiving }, false),
            (Receiving { site: 8, ..receiving }, false),
        ] {
            let (mut sorter, mut pdus) = (Sorter::new(other), Vec::new());
            for _ in 0..1000 {
                for octets in &octets {
                    sorter.sort(octets, &mut pdus);
                }
            }
            let probes: Vec<_> = sorter.take_probes().collect();
            let both = [false, true].map(|long| ("traffic-generator-2".to_owned(), long));
            assert_eq!(probes == both, heard, "{other:?}: {probes:?}");
            assert!(pdus.is_empty(), "a probe is no truth");
        }
    }

    #[test]
    fn what_the_lists_leave_out_is_dropped_and_counted() {
        let receiving = Receiving { exercise: 1, site: 417, consumes: true, loss: 0.0 };
        let state = |site| {
            let entity_id = EntityId::new(site, 1, 1);
            let mut octets = Vec::new();
            Envelope::new(1, DisTime::relative(0))
                .append(&pdu::EntityState { entity_id, ..Default::default() }, &mut octets)
                .expect("it encodes");
            octets
        };
        let from = vec!["10.0.0.0/24".parse().expect("a network")];
        let senders = Senders::new(from, Vec::new(), BTreeSet::from([9]));
        let mut sorter = Sorter::new(receiving).with_senders(senders);
        let mut pdus = Vec::new();
        for (host, site) in [([10, 0, 0, 7], 417), ([10, 0, 0, 7], 9), ([10, 0, 0, 7], 8)] {
            sorter.sort_of(host.into(), &state(site), &mut pdus);
        }
        sorter.sort_of([10, 0, 1, 7].into(), &state(417), &mut pdus);
        assert_eq!(pdus.len(), 2);
        let drops: Vec<_> = sorter.take_drops().collect();
        assert_eq!(drops, [(NO_SENDER, 1), (NO_SITE, 1)]);
    }

    #[test]
    fn forged_probes_fill_no_memory() {
        let receiving = Receiving { exercise: 3, site: 9, consumes: true, loss: 0.0 };
        let (mut sorter, mut pdus) = (Sorter::new(receiving), Vec::new());
        for n in 0..1000 {
            let octets = probe(receiving, &format!("forged-{n}"), false).expect("it encodes");
            sorter.sort(&octets, &mut pdus);
        }
        assert_eq!(sorter.take_probes().count(), PROBES);
        assert_eq!(sorter.take_probes().count(), 0);
    }
}
