//! The data plane as federates see it: PDUs out to everybody, PDUs in from everybody.

use super::federate::Octets;
use super::hearing::Plane;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};

/// A datagram as it arrived.
#[derive(Clone, Debug)]
pub struct Arrival {
    /// UTC of arrival, ns since 1970.
    pub utc_ns: i64,
    /// Sender.
    pub from: SocketAddr,
    /// The whole datagram.
    pub octets: Octets,
}

/// Receives datagrams as they arrive; runs on a thread of the data plane.
pub type ArrivalSink = Box<dyn FnMut(Vec<Arrival>) + Send>;

/// Sends PDUs, one datagram each.
pub trait DataPlane: Send {
    /// Sends; what the kernel refuses is reported once and counted, the run repairs it by request.
    fn send(&mut self, pdus: &[Octets]);
    /// Datagrams that could not be sent.
    fn refused(&self) -> u64;
    /// Datagrams that the kernel dropped on receipt, where it tells.
    fn kernel_drops(&self) -> u64 {
        0
    }
    /// Octets of receive buffer: asked for, obtained.
    fn buffer_octets(&self) -> (usize, usize) {
        (0, 0)
    }
    /// What it is called, where it can fail without the synchronisation plane failing.
    fn plane(&self) -> Option<Plane> {
        None
    }
    /// Sends probes of the federate called `name`, a short one and one as long as the longest datagram, so that others hear it before there is
    /// anything to send.
    fn probe(&mut self, _name: &str) {}
}

/// The data plane inside one process: every datagram goes to every sink, the sender's own too.
#[derive(Clone, Default)]
pub struct LocalEther(Arc<Mutex<Vec<ArrivalSink>>>);

impl LocalEther {
    /// Adds a receiver.
    pub fn listen(&self, sink: ArrivalSink) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(sink);
    }
}

impl DataPlane for LocalEther {
    fn send(&mut self, pdus: &[Octets]) {
        let from = SocketAddr::from(([127, 0, 0, 1], 0));
        let utc_ns = super::clock::utc_ns();
        let mut sinks = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        for sink in sinks.iter_mut() {
            sink(
                pdus.iter()
                    .map(|octets| Arrival { utc_ns, from, octets: Arc::clone(octets) })
                    .collect(),
            );
        }
    }
    fn refused(&self) -> u64 {
        0
    }
}
