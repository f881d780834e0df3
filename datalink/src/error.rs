//! What goes wrong with sockets: what, where, what to do.

use std::fmt;
use std::io;
use std::net::{IpAddr, SocketAddr};

/// Why a link could not be opened, or stopped working.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// Another process has the port for itself.
    #[error("{address} is in use: {}", in_use_advice(.shared))]
    InUse {
        /// Address and port asked for.
        address: SocketAddr,
        /// Whether several processes could share it (broadcast and multicast).
        shared: bool,
    },
    /// No network interface of this host has the address.
    #[error("no interface of this host has the address {wanted}; it has {}", list(.have))]
    NoSuchInterface {
        /// The address asked for.
        wanted: IpAddr,
        /// The addresses of this host.
        have: Vec<IpAddr>,
    },
    /// The interface's address is of the other family.
    #[error("interface {interface} and destination {destination} are of different IP versions")]
    Family {
        /// The interface asked for.
        interface: IpAddr,
        /// Where datagrams go.
        destination: IpAddr,
    },
    /// The system knows no way to a group or host.
    #[error("no route to {to}: {}", route_advice(.to))]
    NoRoute {
        /// Where datagrams were to go.
        to: SocketAddr,
    },
    /// The system joins no more groups with one socket.
    #[error(
        "cannot join {group}: {joined} groups are joined already and the system allows no more (sysctl net.ipv4.igmp_max_memberships)"
    )]
    TooManyGroups {
        /// The group that was one too many.
        group: IpAddr,
        /// Groups joined before.
        joined: usize,
    },
    /// A port or address that this user may not use.
    #[error("{address}: permission denied (ports below 1024 need root; a firewall may refuse too)")]
    Denied {
        /// Address and port.
        address: SocketAddr,
    },
    /// A PDU that no datagram can hold.
    #[error("a PDU of {0} bytes does not fit a UDP datagram (65507)")]
    TooLong(usize),
    /// Anything else that the system refuses.
    #[error("{doing} {address}: {cause}")]
    System {
        /// What was being done.
        doing: &'static str,
        /// Where.
        address: SocketAddr,
        /// What the system said.
        cause: io::Error,
    },
}

impl LinkError {
    pub(crate) fn system(doing: &'static str, address: SocketAddr, cause: io::Error) -> Self {
        match cause.raw_os_error() {
            Some(e) if e == nix::libc::ENETUNREACH || e == nix::libc::EHOSTUNREACH => {
                Self::NoRoute { to: address }
            }
            Some(e) if e == nix::libc::EACCES || e == nix::libc::EPERM => Self::Denied { address },
            _ => Self::System { doing, address, cause },
        }
    }
}

fn in_use_advice(shared: &bool) -> &'static str {
    if *shared {
        "a process that does not share it holds it (ss -ulpn names it); stop it or choose another port"
    } else {
        "a unicast port belongs to one process (ss -ulpn names it); choose another port to listen on, or name this host again in the list with a port for each of its processes"
    }
}

fn route_advice(to: &SocketAddr) -> &'static str {
    if to.is_ipv4() {
        "name the interface to use (--interface 127.0.0.1 stays on this host)"
    } else {
        "name an interface with IPv6 multicast (--interface; the loopback has none, but groups \
         ff01::/16 stay on this host on any interface)"
    }
}

fn list(have: &[IpAddr]) -> String {
    have.iter().map(IpAddr::to_string).collect::<Vec<_>>().join(", ")
}

/// Something that works less well than asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Warning {
    /// The system gave a smaller receive buffer: bursts may be lost.
    SmallBuffer {
        /// Octets asked for.
        asked: usize,
        /// Octets obtained.
        obtained: usize,
    },
    /// The system does not stamp datagrams: stamps are taken when they are read.
    NoKernelStamps,
    /// The system does not count what it throws away.
    NoDropCount,
    /// The system does not cut datagrams into segments: they are sent one by one.
    NoOffload,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SmallBuffer { asked, obtained } => write!(
                f,
                "receive buffer of {obtained} bytes instead of {asked}: bursts may be lost; \
                 sysctl -w net.core.rmem_max={asked} allows more"
            ),
            Self::NoKernelStamps => {
                f.write_str("arrival stamps are taken by this process, not by the system")
            }
            Self::NoDropCount => {
                f.write_str("the system does not tell how many datagrams it drops")
            }
            Self::NoOffload => f.write_str(
                "the system refuses segmentation offload: datagrams are sent one by one",
            ),
        }
    }
}
