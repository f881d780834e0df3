//! PDUs out.

use crate::bundle::{Packing, Queue};
use crate::config::LinkConfig;
use crate::error::{LinkError, Warning};
use crate::socket::sending_socket;
use nix::errno::Errno;
use nix::sys::socket::{
    ControlMessage, MsgFlags, MultiHeaders, SockaddrStorage, sendmmsg, sendmsg,
};
use socket2::Socket;
use std::io::IoSlice;
use std::net::SocketAddr;
use std::os::fd::AsRawFd;
use std::time::Instant;

/// Datagrams given to the system in one call.
const BATCH: usize = 64;
/// Segments that the system cuts out of one piece at most (`UDP_MAX_SEGMENTS` of older kernels).
const SEGMENTS: usize = 64;
/// Octets of one piece at most, below the largest IP packet.
const PIECE: usize = 65_000;

/// What was sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sent {
    /// PDUs handed over.
    pub pdus: u64,
    /// Datagrams that left, counted once per destination.
    pub datagrams: u64,
    /// Datagrams that an unreachable host refused (unicast only).
    pub refused: u64,
}

/// Sends PDUs to every destination of a link.
pub struct Sender {
    socket: Socket,
    to: Vec<SocketAddr>,
    packing: Packing,
    queue: Queue,
    /// Set once the system has refused to cut segments.
    offload_refused: bool,
    sent: Sent,
}

impl std::fmt::Debug for Sender {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Sender")
            .field("to", &self.to)
            .field("packing", &self.packing)
            .finish_non_exhaustive()
    }
}

impl Sender {
    /// Opens the sending direction alone.
    ///
    /// # Errors
    /// [`LinkError`]: what, where, what to do.
    pub fn open(config: &LinkConfig) -> Result<Self, LinkError> {
        Ok(Self {
            socket: sending_socket(config)?,
            to: config.to.list().iter().map(|d| d.address()).collect(),
            packing: config.packing,
            queue: Queue::default(),
            offload_refused: false,
            sent: Sent::default(),
        })
    }

    /// Where receivers see datagrams of this sender come from. The address is unspecified where the
    /// system chooses it for each datagram (several destinations and no interface named).
    ///
    /// # Errors
    /// If the system does not tell.
    pub fn address(&self) -> Result<SocketAddr, LinkError> {
        let failed = |e| LinkError::system("asking for the address that sends to", self.to[0], e);
        let address = self.socket.local_addr().map_err(failed)?;
        address.as_socket().ok_or_else(|| failed(std::io::ErrorKind::Unsupported.into()))
    }

    /// How PDUs are put into datagrams from now on.
    pub fn set_packing(&mut self, packing: Packing) {
        self.packing = packing;
    }

    /// Sends one PDU: at once, or with bundling when its datagram is full or due (call
    /// [`Sender::flush_due`] in time).
    ///
    /// # Errors
    /// [`LinkError`]; what was collected up to the error is thrown away.
    pub fn send(&mut self, pdu: &[u8]) -> Result<(), LinkError> {
        self.collect(pdu)?;
        if self.packing.bundle.is_none() {
            return self.flush();
        }
        Ok(())
    }

    /// Sends many PDUs with as few calls to the system as possible; nothing waits afterwards.
    ///
    /// # Errors
    /// As [`Sender::send`].
    pub fn send_all<'a>(
        &mut self,
        pdus: impl IntoIterator<Item = &'a [u8]>,
    ) -> Result<(), LinkError> {
        for pdu in pdus {
            self.collect(pdu)?;
        }
        self.flush()
    }

    /// Sends what waits.
    ///
    /// # Errors
    /// As [`Sender::send`].
    pub fn flush(&mut self) -> Result<(), LinkError> {
        self.queue.close();
        self.transmit()
    }

    /// When the bundle that is being filled has to go; `None` if nothing waits.
    #[must_use]
    pub fn deadline(&self) -> Option<Instant> {
        Some(self.queue.opened()? + self.packing.bundle?.most_wait)
    }

    /// Sends the waiting bundle if its time has come.
    ///
    /// # Errors
    /// As [`Sender::send`].
    #[expect(
        clippy::disallowed_methods,
        reason = "a deadline of the network, not of the simulation"
    )]
    pub fn flush_due(&mut self) -> Result<(), LinkError> {
        match self.deadline() {
            Some(deadline) if Instant::now() >= deadline => self.flush(),
            _ => Ok(()),
        }
    }

    /// What was sent so far.
    #[must_use]
    pub fn sent(&self) -> Sent {
        Sent { pdus: self.queue.pdus, ..self.sent }
    }

    /// What works less well than asked for.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        if self.offload_refused { vec![Warning::NoOffload] } else { Vec::new() }
    }

    #[expect(
        clippy::disallowed_methods,
        reason = "a deadline of the network, not of the simulation"
    )]
    fn collect(&mut self, pdu: &[u8]) -> Result<(), LinkError> {
        if pdu.len() > 65_507 {
            return Err(LinkError::TooLong(pdu.len()));
        }
        match &self.packing.bundle {
            None => self.queue.push_alone(pdu),
            Some(limits) => {
                let due = self.queue.opened().map(|at| at + limits.most_wait);
                self.queue.push_bundled(pdu, limits, Instant::now);
                // Looked at when PDUs come, so that a busy sender keeps its promise without a timer.
                if due.is_some_and(|due| Instant::now() >= due) {
                    return self.flush();
                }
            }
        }
        let full = self.queue.ends.len() >= BATCH || self.queue.octets.len() >= PIECE;
        if full { self.transmit() } else { Ok(()) }
    }

    /// Sends the datagrams that are ready; the open bundle stays.
    fn transmit(&mut self) -> Result<(), LinkError> {
        if self.queue.ends.is_empty() {
            return Ok(());
        }
        let mut outcome = Ok(());
        for i in 0..self.to.len() {
            let connected = self.to.len() == 1;
            let address = (!connected).then(|| SockaddrStorage::from(self.to[i]));
            let result = if self.packing.offload && !self.offload_refused {
                self.transmit_segments(address)
            } else {
                self.transmit_batch(address, 0, self.queue.ends.len())
            };
            if let Err(e) = result {
                outcome = Err(LinkError::system("sending to", self.to[i], e.into()));
            }
        }
        self.queue.sent();
        outcome
    }

    /// Sends datagrams `first..last` of the queue, many in one call.
    fn transmit_batch(
        &mut self,
        address: Option<SockaddrStorage>,
        mut first: usize,
        last: usize,
    ) -> nix::Result<()> {
        let fd = self.socket.as_raw_fd();
        while first < last {
            let until = last.min(first + BATCH);
            let slices: Vec<[IoSlice<'_>; 1]> =
                (first..until).map(|i| [IoSlice::new(datagram(&self.queue, i))]).collect();
            let result = if let [only] = slices.as_slice() {
                sendmsg(fd, only, &[], MsgFlags::empty(), address.as_ref()).map(|_| 1)
            } else {
                let addresses = vec![address; slices.len()];
                // Made for each call: headers hold raw pointers, and a sender moves between threads.
                let mut headers = MultiHeaders::<SockaddrStorage>::preallocate(slices.len(), None);
                sendmmsg(fd, &mut headers, &slices, addresses, [], MsgFlags::empty())
                    .map(Iterator::count)
            };
            match result {
                Ok(n) => {
                    first += n;
                    self.sent.datagrams += n as u64;
                }
                Err(Errno::EINTR) => {}
                // The answer to an earlier datagram: nobody listens there. This one was not sent;
                // for an unreachable host it makes no difference.
                Err(Errno::ECONNREFUSED) => {
                    first += 1;
                    self.sent.refused += 1;
                }
                Err(e) => return Err(e),
            }
        }
        Ok(())
    }

    /// Sends runs of datagrams of one length (the last of a run may be shorter) as one piece each.
    fn transmit_segments(&mut self, address: Option<SockaddrStorage>) -> nix::Result<()> {
        let mut first = 0;
        while first < self.queue.ends.len() {
            let last = end_of_run(&self.queue, first);
            if last - first < 2 || self.offload_refused {
                self.transmit_batch(address, first, last)?;
                first = last;
                continue;
            }
            let size = datagram(&self.queue, first).len() as u16;
            let start = if first == 0 { 0 } else { self.queue.ends[first - 1] };
            let piece = [IoSlice::new(&self.queue.octets[start..self.queue.ends[last - 1]])];
            let segments = [ControlMessage::UdpGsoSegments(&size)];
            let fd = self.socket.as_raw_fd();
            match sendmsg(fd, &piece, &segments, MsgFlags::empty(), address.as_ref()) {
                Ok(_) => {
                    self.sent.datagrams += (last - first) as u64;
                    first = last;
                }
                Err(Errno::EINTR) => {}
                Err(Errno::ECONNREFUSED) => {
                    self.sent.refused += (last - first) as u64;
                    first = last;
                }
                // Too long for the network card's packets: these only, not for ever.
                Err(Errno::EMSGSIZE | Errno::EINVAL) => {
                    self.transmit_batch(address, first, last)?;
                    first = last;
                }
                Err(Errno::EIO | Errno::ENOPROTOOPT | Errno::EOPNOTSUPP) => {
                    self.offload_refused = true;
                }
                Err(e) => return Err(e),
            }
        }
        Ok(())
    }
}

impl Drop for Sender {
    fn drop(&mut self) {
        let _ = self.flush();
    }
}

/// Datagram `i` of the queue.
fn datagram(queue: &Queue, i: usize) -> &[u8] {
    let start = if i == 0 { 0 } else { queue.ends[i - 1] };
    &queue.octets[start..queue.ends[i]]
}

/// Behind the last datagram that can go in one piece with datagram `first`.
fn end_of_run(queue: &Queue, first: usize) -> usize {
    let size = datagram(queue, first).len();
    let start = if first == 0 { 0 } else { queue.ends[first - 1] };
    let mut last = first + 1;
    while last < queue.ends.len() && last - first < SEGMENTS && queue.ends[last] - start <= PIECE {
        let len = datagram(queue, last).len();
        if len > size || len == 0 {
            break;
        }
        last += 1;
        if len < size {
            break;
        }
    }
    last
}
