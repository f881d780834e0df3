//! The data plane over UDP: sound PDUs of this exercise in, PDUs out.

use super::cli::NetworkArgs;
use super::data_plane::DataPlane;
use super::digest::pdu_hash;
use super::federate::Octets;
use super::member_driver::Event;
use super::threads::spawn_watched;
use crossbeam_channel::Sender;
use datalink::{Destination, Destinations, LinkConfig};
use pdu::enumerations::PduType;
use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// What a federate wants of the datagrams that arrive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiving {
    /// DIS exercise.
    pub exercise: u8,
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
    let sender = if receiving.consumes {
        let (sender, mut receiver) = datalink::Link::open(&config)?;
        for warning in receiver.warnings() {
            tracing::warn!("{warning}");
        }
        let told = Arc::clone(&drops);
        let dead = events.clone();
        let failed = move |why| drop(dead.send(Event::Failed(why)));
        spawn_watched("the receiver of DIS", failed, move || {
            let mut sorter = Sorter::new(receiving);
            loop {
                let mut pdus = Vec::new();
                let got = receiver.receive(None, |arrival| sorter.sort(arrival.payload, &mut pdus));
                told.store(receiver.dropped(), Ordering::Relaxed);
                if let Err(e) = got {
                    let _ = events.send(Event::Failed(format!("receiving DIS: {e}")));
                    return;
                }
                let sent = pdus.is_empty() || events.send(Event::Pdus(pdus)).is_ok();
                let told =
                    sorter.take_drops().all(|(r, n)| events.send(Event::Dropped(r, n)).is_ok());
                if !sent || !told {
                    return;
                }
            }
        })?;
        sender
    } else {
        datalink::Sender::open(&config)?
    };
    Ok(Box::new(UdpPlane { sender, refused: 0, drops }))
}

/// Sorts datagrams: sound truth and weather of the exercise, anything else, unsound ones.
pub struct Sorter {
    receiving: Receiving,
    arrived: u64,
    drops: BTreeMap<&'static str, u64>,
}

impl Sorter {
    /// A sorter.
    #[must_use]
    pub fn new(receiving: Receiving) -> Self {
        Self { receiving, arrived: 0, drops: BTreeMap::new() }
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
            let pdu_type = received.header().pdu_type;
            if pdu_type == PduType::ENTITY_STATE && self.lose(received.octets) {
                continue;
            }
            if pdu_type == PduType::ENTITY_STATE || pdu_type == PduType::ENVIRONMENTAL_PROCESS {
                pdus.push(Arc::from(received.octets));
            }
        }
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

struct UdpPlane {
    sender: datalink::Sender,
    refused: u64,
    drops: Arc<AtomicU64>,
}

impl DataPlane for UdpPlane {
    fn send(&mut self, pdus: &[Octets]) {
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
}
