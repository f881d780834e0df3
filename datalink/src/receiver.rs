//! Datagrams in.

use crate::config::LinkConfig;
use crate::error::{LinkError, Warning};
use crate::socket::receiving_socket;
use nix::errno::Errno;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::sys::socket::sockopt::{
    Ipv4PacketInfo, Ipv6RecvPacketInfo, RcvBufForce, ReceiveTimestampns, RxqOvfl,
};
use nix::sys::socket::{
    ControlMessageOwned, MsgFlags, MultiHeaders, SockaddrStorage, recvmmsg, setsockopt,
};
use nix::sys::time::TimeSpec;
use socket2::Socket;
use std::io::{IoSliceMut, Read, Write};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::os::fd::{AsFd, AsRawFd};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Datagrams taken from the system in one call.
const BATCH: usize = 64;
/// The largest datagram there is.
const MOST_OCTETS: usize = 65_536;

/// One datagram as it arrived.
#[derive(Clone, Copy, Debug)]
pub struct Arrival<'a> {
    /// When the system received it, nanoseconds since 1970 UTC.
    pub utc_ns: i64,
    /// Who sent it.
    pub from: SocketAddr,
    /// Where it was sent to: group, broadcast address or this host.
    pub to: SocketAddr,
    /// What it carried.
    pub payload: &'a [u8],
}

/// What one call of [`Receiver::receive`] brought.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Received {
    /// Datagrams handed to the caller.
    pub datagrams: usize,
    /// Somebody called [`Waker::wake`].
    pub woken: bool,
}

/// Ends the wait of a receiver from another thread.
#[derive(Clone, Debug)]
pub struct Waker(Arc<UnixStream>);

impl Waker {
    /// Makes the current or the next wait return at once, with `woken` set.
    pub fn wake(&self) {
        // A full pipe has woken the receiver already.
        let _ = (&*self.0).write(&[1]);
    }
}

/// Receives datagrams in batches.
pub struct Receiver {
    socket: Socket,
    /// Stands for "to us" where the system does not say.
    to_us: SocketAddr,
    buffer: Vec<u8>,
    heads: Vec<Head>,
    wake: UnixStream,
    waker: Waker,
    buffer_asked: usize,
    buffer_obtained: usize,
    warnings: Vec<Warning>,
    /// Dropped by the system as of the last datagram.
    dropped: u64,
    dropped_raw: u32,
    tells_destination: bool,
}

impl std::fmt::Debug for Receiver {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Receiver").field("to_us", &self.to_us).finish_non_exhaustive()
    }
}

#[derive(Clone, Copy, Debug)]
struct Head {
    octets: usize,
    from: SocketAddr,
    to: SocketAddr,
    utc_ns: Option<i64>,
}

impl Receiver {
    /// Opens the receiving direction alone.
    ///
    /// # Errors
    /// [`LinkError`]: what, where, what to do.
    pub fn open(config: &LinkConfig) -> Result<Self, LinkError> {
        let (socket, to_us) = receiving_socket(config)?;
        let failed = |e| LinkError::system("preparing to listen on", to_us, e);
        let mut warnings = Vec::new();
        let buffer_obtained = grow_buffer(&socket, config.receive_buffer).map_err(failed)?;
        if buffer_obtained < config.receive_buffer {
            let (asked, obtained) = (config.receive_buffer, buffer_obtained);
            warnings.push(Warning::SmallBuffer { asked, obtained });
        }
        if setsockopt(&socket, ReceiveTimestampns, &true).is_err() {
            warnings.push(Warning::NoKernelStamps);
        }
        if setsockopt(&socket, RxqOvfl, &1).is_err() {
            warnings.push(Warning::NoDropCount);
        }
        let bound = socket.local_addr().map_err(failed)?.as_socket().unwrap_or(to_us);
        // Bound to one address, the destination is known without asking.
        let tells_destination = bound.ip().is_unspecified()
            && match to_us {
                SocketAddr::V4(_) => setsockopt(&socket, Ipv4PacketInfo, &true).is_ok(),
                SocketAddr::V6(_) => setsockopt(&socket, Ipv6RecvPacketInfo, &true).is_ok(),
            };
        let (wake, waker) = UnixStream::pair().map_err(failed)?;
        wake.set_nonblocking(true).map_err(failed)?;
        waker.set_nonblocking(true).map_err(failed)?;
        Ok(Self {
            socket,
            to_us: SocketAddr::new(to_us.ip(), bound.port()),
            buffer: vec![0; BATCH * MOST_OCTETS],
            heads: Vec::with_capacity(BATCH),
            wake,
            waker: Waker(Arc::new(waker)),
            buffer_asked: config.receive_buffer,
            buffer_obtained,
            warnings,
            dropped: 0,
            dropped_raw: 0,
            tells_destination,
        })
    }

    /// Waits up to `timeout` for datagrams (`None`: without end) and hands what is there to `take`, at
    /// most one batch of 64. Returns at once when there is something, and when woken.
    ///
    /// # Errors
    /// [`LinkError::System`] if the system cannot wait or receive.
    pub fn receive(
        &mut self,
        timeout: Option<Duration>,
        mut take: impl FnMut(Arrival<'_>),
    ) -> Result<Received, LinkError> {
        let mut woken = false;
        if !self.fetch()? {
            woken = self.wait(timeout)?;
            self.fetch()?;
        }
        for (head, octets) in self.heads.iter().zip(self.buffer.chunks_exact(MOST_OCTETS)) {
            take(Arrival {
                utc_ns: head.utc_ns.unwrap_or_else(utc_ns),
                from: head.from,
                to: head.to,
                payload: &octets[..head.octets],
            });
        }
        Ok(Received { datagrams: self.heads.len(), woken })
    }

    /// For another thread, to end a wait.
    #[must_use]
    pub fn waker(&self) -> Waker {
        self.waker.clone()
    }

    /// Where this receiver listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.to_us
    }

    /// Octets of receive buffer: asked for, obtained.
    #[must_use]
    pub fn buffer_octets(&self) -> (usize, usize) {
        (self.buffer_asked, self.buffer_obtained)
    }

    /// What works less well than asked for.
    #[must_use]
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Datagrams that the system threw away because the buffer was full, as of the last datagram
    /// received. [`Receiver::dropped_now`] knows it without waiting for one.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// As [`Receiver::dropped`], read from the system's table of sockets (slow: for statistics).
    #[must_use]
    pub fn dropped_now(&self) -> u64 {
        drops_in_table(self.socket.as_raw_fd(), self.to_us.is_ipv6())
            .map_or(self.dropped, |now| self.dropped.max(now))
    }

    /// Takes one batch; false if nothing is there.
    fn fetch(&mut self) -> Result<bool, LinkError> {
        self.heads.clear();
        // Made anew each time: the system shortens the lengths in it to what it used.
        let space = nix::cmsg_space!(TimeSpec, u32, nix::libc::in6_pktinfo);
        let mut headers: MultiHeaders<SockaddrStorage> =
            MultiHeaders::preallocate(BATCH, Some(space));
        let mut slices: Vec<[IoSliceMut<'_>; 1]> =
            self.buffer.chunks_exact_mut(MOST_OCTETS).map(|b| [IoSliceMut::new(b)]).collect();
        let flags = MsgFlags::MSG_DONTWAIT;
        let messages =
            match recvmmsg(self.socket.as_raw_fd(), &mut headers, &mut slices, flags, None) {
                Ok(messages) => messages,
                // ECONNREFUSED: the answer to something sent earlier; no datagram.
                Err(Errno::EAGAIN | Errno::EINTR | Errno::ECONNREFUSED) => return Ok(false),
                Err(e) => return Err(LinkError::system("receiving on", self.to_us, e.into())),
            };
        for message in messages {
            let mut head = Head {
                octets: message.bytes,
                from: message.address.as_ref().map_or(UNKNOWN, socket_address),
                to: self.to_us,
                utc_ns: None,
            };
            for control in message.cmsgs().into_iter().flatten() {
                match control {
                    ControlMessageOwned::ScmTimestampns(stamp) => {
                        head.utc_ns = Some(stamp.tv_sec() * 1_000_000_000 + stamp.tv_nsec());
                    }
                    ControlMessageOwned::RxqOvfl(count) => {
                        // The count of the system has 32 bits and starts again at zero.
                        self.dropped += u64::from(count.wrapping_sub(self.dropped_raw));
                        self.dropped_raw = count;
                    }
                    ControlMessageOwned::Ipv4PacketInfo(info) if self.tells_destination => {
                        let ip = Ipv4Addr::from(u32::from_be(info.ipi_addr.s_addr));
                        head.to = SocketAddr::new(ip.into(), self.to_us.port());
                    }
                    ControlMessageOwned::Ipv6PacketInfo(info) if self.tells_destination => {
                        let ip = Ipv6Addr::from(info.ipi6_addr.s6_addr);
                        head.to = SocketAddr::new(ip.into(), self.to_us.port());
                    }
                    _ => {}
                }
            }
            self.heads.push(head);
        }
        Ok(!self.heads.is_empty())
    }

    /// Waits for a datagram or a wake-up; true if woken.
    fn wait(&mut self, timeout: Option<Duration>) -> Result<bool, LinkError> {
        let timeout = match timeout {
            None => PollTimeout::NONE,
            // Rounded up, so that a short wait is not a busy one.
            Some(t) => {
                PollTimeout::try_from(t.as_nanos().div_ceil(1_000_000).min(3_600_000) as i32)
                    .unwrap_or(PollTimeout::MAX)
            }
        };
        let mut fds = [
            PollFd::new(self.socket.as_fd(), PollFlags::POLLIN),
            PollFd::new(self.wake.as_fd(), PollFlags::POLLIN),
        ];
        match poll(&mut fds, timeout) {
            Ok(_) | Err(Errno::EINTR) => {}
            Err(e) => return Err(LinkError::system("waiting on", self.to_us, e.into())),
        }
        let woken = fds[1].any().unwrap_or(false);
        if woken {
            let mut sink = [0; 64];
            while matches!((&self.wake).read(&mut sink), Ok(n) if n == sink.len()) {}
        }
        Ok(woken)
    }
}

const UNKNOWN: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::UNSPECIFIED), 0);

fn socket_address(address: &SockaddrStorage) -> SocketAddr {
    match (address.as_sockaddr_in(), address.as_sockaddr_in6()) {
        (Some(v4), _) => SocketAddr::new(v4.ip().into(), v4.port()),
        (_, Some(v6)) => std::net::SocketAddrV6::from(*v6).into(),
        _ => UNKNOWN,
    }
}

/// Asks for `wanted` octets of buffer, beyond the usual limit where that is allowed; gives what it is.
fn grow_buffer(socket: &Socket, wanted: usize) -> std::io::Result<usize> {
    // The system doubles the number for its own bookkeeping and tells the doubled one.
    let obtained = |socket: &Socket| socket.recv_buffer_size().map(|n| n / 2);
    socket.set_recv_buffer_size(wanted)?;
    if obtained(socket)? < wanted {
        // Needs a privilege; without it the usual limit stays.
        let _ = setsockopt(socket, RcvBufForce, &wanted);
    }
    obtained(socket)
}

#[expect(clippy::disallowed_methods, reason = "the arrival stamp where the system gives none")]
fn utc_ns() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
}

/// The last column of this socket's line in the system's table of UDP sockets.
fn drops_in_table(fd: i32, v6: bool) -> Option<u64> {
    let link = std::fs::read_link(format!("/proc/self/fd/{fd}")).ok()?;
    let inode = link.to_str()?.strip_prefix("socket:[")?.strip_suffix(']')?.to_owned();
    let table = if v6 { "/proc/self/net/udp6" } else { "/proc/self/net/udp" };
    let text = std::fs::read_to_string(table).ok()?;
    text.lines().skip(1).find_map(|line| {
        let mut columns = line.split_ascii_whitespace();
        (columns.nth(9)? == inode).then(|| columns.last()?.parse().ok()).flatten()
    })
}
