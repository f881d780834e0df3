//! Ports of this host for whoever has to name one before it listens.

use std::io;
use std::net::{Ipv4Addr, TcpListener, UdpSocket};
use std::ops::Range;
use std::sync::Mutex;

/// Ports that one process takes at a time.
const BLOCK: u16 = 32;
/// Below it stand the ports of well-known services.
const FIRST: u16 = 10_000;

/// A port (TCP and UDP) that nobody listens at, and that this function gives to no other caller on this host while
/// the process lives.
///
/// Binding port 0 and letting it go gives a port of the range from which the system serves whoever connects: between
/// that and the listening, any connection of any process may take it. These lie below that range.
///
/// # Errors
///
/// None is left, or the system refuses sockets.
pub fn free_port() -> io::Result<u16> {
    static TAKEN: Mutex<Taken> = Mutex::new(Taken { ports: 0..0, blocks: Vec::new() });
    let mut taken = TAKEN.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    loop {
        let Some(port) = taken.ports.next() else {
            taken.take_a_block()?;
            continue;
        };
        if nobody_listens(port) {
            return Ok(port);
        }
    }
}

struct Taken {
    ports: Range<u16>,
    /// What says to other processes that a block is taken; the system lets go of it with the process.
    blocks: Vec<held::Block>,
}

impl Taken {
    fn take_a_block(&mut self) -> io::Result<()> {
        let blocks = u32::from((connecting_from() - FIRST) / BLOCK);
        // Neighbours in process number begin far from each other.
        let begin = std::process::id().wrapping_mul(7919) % blocks;
        for block in (0..blocks).map(|i| (begin + i) % blocks) {
            let first = FIRST + BLOCK * u16::try_from(block).unwrap_or(0);
            if let Some(held) = held::Block::take(first)? {
                self.blocks.push(held);
                self.ports = first..first + BLOCK;
                return Ok(());
            }
        }
        Err(io::Error::new(io::ErrorKind::AddrInUse, "every port below the system's own is taken"))
    }
}

/// The lowest port that the system gives to whoever connects.
fn connecting_from() -> u16 {
    let said = std::fs::read_to_string("/proc/sys/net/ipv4/ip_local_port_range").ok();
    let from = said.and_then(|s| s.split_whitespace().next()?.parse().ok()).unwrap_or(32_768);
    // Where the system takes nearly all, they are shared with it.
    if from < FIRST + 100 * BLOCK { 32_768 } else { from }
}

fn nobody_listens(port: u16) -> bool {
    let at = (Ipv4Addr::UNSPECIFIED, port);
    TcpListener::bind(at).is_ok() && UdpSocket::bind(at).is_ok()
}

#[cfg(target_os = "linux")]
mod held {
    use std::io;
    use std::os::linux::net::SocketAddrExt;
    use std::os::unix::net::{SocketAddr, UnixDatagram};

    /// A name in the network namespace, as ports are.
    #[derive(Debug)]
    pub(super) struct Block(#[expect(dead_code, reason = "held, never read")] UnixDatagram);

    impl Block {
        pub(super) fn take(first: u16) -> io::Result<Option<Self>> {
            let name = SocketAddr::from_abstract_name(format!("seeds-ports-{first}"))?;
            match UnixDatagram::bind_addr(&name) {
                Ok(socket) => Ok(Some(Self(socket))),
                Err(e) if e.kind() == io::ErrorKind::AddrInUse => Ok(None),
                Err(e) => Err(e),
            }
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod held {
    /// Other systems have no names that end with the process: blocks differ by the number of the process.
    #[derive(Debug)]
    pub(super) struct Block;

    impl Block {
        #[expect(clippy::unnecessary_wraps, reason = "as where it can fail")]
        pub(super) fn take(_first: u16) -> std::io::Result<Option<Self>> {
            Ok(Some(Self))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn ports_are_given_once_below_those_of_whoever_connects_and_can_be_listened_at() {
        let ports: Vec<u16> =
            (0..3 * BLOCK).map(|_| free_port().expect("there are ports")).collect();
        let distinct: BTreeSet<u16> = ports.iter().copied().collect();
        assert_eq!(distinct.len(), ports.len(), "a port twice: {ports:?}");
        for port in ports {
            assert!((FIRST..connecting_from()).contains(&port), "{port}");
            TcpListener::bind(("127.0.0.1", port)).expect("nobody listens there");
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_block_is_of_one_process_until_it_lets_go() {
        let first = 3; // no block begins there
        let held = held::Block::take(first).expect("asked").expect("free");
        assert!(held::Block::take(first).expect("asked").is_none(), "taken twice");
        drop(held);
        assert!(held::Block::take(first).expect("asked").is_some(), "let go of");
    }

    #[test]
    fn a_port_at_which_somebody_listens_is_passed_over() {
        let tcp = TcpListener::bind("127.0.0.1:0").expect("a port");
        assert!(!nobody_listens(tcp.local_addr().expect("its address").port()));
        let udp = UdpSocket::bind("127.0.0.1:0").expect("a port");
        assert!(!nobody_listens(udp.local_addr().expect("its address").port()));
    }
}
