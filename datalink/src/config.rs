//! What a link is to be.

use crate::address::Destinations;
use crate::bundle::Packing;
use std::net::{IpAddr, SocketAddr};

/// What a link is to be. `LinkConfig::default()` is broadcast that cannot leave the host.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkConfig {
    /// Where datagrams go: a group, a broadcast address, or a list of hosts.
    pub to: Destinations,
    /// Address and port to listen on; by default what suits `to` (its group or broadcast address
    /// and its port).
    pub listen: Option<SocketAddr>,
    /// Groups to join besides those in `to`, same port.
    pub groups: Vec<IpAddr>,
    /// Address of the network interface to use; by default the system's choice.
    pub interface: Option<IpAddr>,
    /// Routers that multicast and broadcast may pass, plus one; 0 keeps multicast on this host. Unicast keeps the system's value.
    pub ttl: u8,
    /// Octets of receive buffer asked for.
    pub receive_buffer: usize,
    /// How PDUs are put into datagrams.
    pub packing: Packing,
}

impl Default for LinkConfig {
    fn default() -> Self {
        Self {
            to: Destinations::default(),
            listen: None,
            groups: Vec::new(),
            interface: None,
            ttl: 1,
            receive_buffer: 4 << 20,
            packing: Packing::default(),
        }
    }
}
