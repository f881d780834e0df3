//! Where DIS datagrams go and come from, on the command line of the tools.

use anyhow::Context;
use clap::Args;
use datalink::{Destinations, LinkConfig};
use std::net::{IpAddr, SocketAddr};

/// Where DIS datagrams go and come from
#[derive(Args, Clone, Debug)]
pub struct LinkArgs {
    /// Multicast group, broadcast address, or comma-separated list of hosts
    #[arg(long, value_name = "ADDR:PORT", default_value = "127.255.255.255:3000")]
    pub dis: Destinations,

    /// Address of the network interface to use [default: the system's choice]
    #[arg(long, value_name = "IP")]
    pub interface: Option<IpAddr>,

    /// Routers that multicast and broadcast may pass, plus one; 0 keeps multicast on this host
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub ttl: u8,

    /// Listen here instead; port 0: any free one [default: what suits --dis]
    #[arg(long, value_name = "ADDR:PORT")]
    pub listen: Option<SocketAddr>,

    /// Further multicast groups to listen to, same port, with commas between
    #[arg(long, value_name = "IP", value_delimiter = ',')]
    pub group: Vec<IpAddr>,

    /// Receive buffer asked of the system, bytes
    #[arg(long, value_name = "BYTES", default_value_t = 4 << 20)]
    pub receive_buffer: usize,
}

impl LinkArgs {
    /// As a link takes it.
    ///
    /// # Errors
    /// If a further group is no multicast address.
    pub fn config(&self) -> anyhow::Result<LinkConfig> {
        for group in &self.group {
            let multicast = group.is_multicast().then_some(());
            multicast.with_context(|| format!("--group {group}: no multicast address"))?;
        }
        Ok(LinkConfig {
            to: self.dis.clone(),
            listen: self.listen,
            groups: self.group.clone(),
            interface: self.interface,
            ttl: self.ttl,
            receive_buffer: self.receive_buffer,
            ..LinkConfig::default()
        })
    }
}
