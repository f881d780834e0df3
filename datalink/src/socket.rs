//! Sockets made as a configuration asks.

use crate::address::Destination;
use crate::config::LinkConfig;
use crate::error::LinkError;
use socket2::{Domain, Protocol, Socket, Type};
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, SocketAddrV6};

/// Addresses of this host's interfaces, with the interface's name.
fn local_addresses() -> Vec<(IpAddr, String)> {
    let Ok(all) = nix::ifaddrs::getifaddrs() else { return Vec::new() };
    let ip = |i: nix::ifaddrs::InterfaceAddress| {
        let address = i.address?;
        let ip = match (address.as_sockaddr_in(), address.as_sockaddr_in6()) {
            (Some(v4), _) => IpAddr::V4(v4.ip()),
            (_, Some(v6)) => IpAddr::V6(v6.ip()),
            _ => return None,
        };
        Some((ip, i.interface_name))
    };
    all.filter_map(ip).collect()
}

/// Checks the interface asked for; gives its index for IPv6 (0: the system's choice).
pub(crate) fn interface_index(config: &LinkConfig) -> Result<u32, LinkError> {
    let Some(wanted) = config.interface else { return Ok(0) };
    let destination = config.to.first().ip();
    if wanted.is_ipv4() != destination.is_ipv4() {
        return Err(LinkError::Family { interface: wanted, destination });
    }
    let local = local_addresses();
    // Every address of 127.0.0.0/8 is this host's although only one is listed.
    let found = local.iter().find(|(ip, _)| *ip == wanted);
    match found {
        Some((_, name)) => Ok(nix::net::if_::if_nametoindex(name.as_str()).unwrap_or(0)),
        None if wanted.is_loopback() => Ok(0),
        None => {
            let have = local.into_iter().map(|(ip, _)| ip).collect();
            Err(LinkError::NoSuchInterface { wanted, have })
        }
    }
}

pub(crate) fn new_socket(address: SocketAddr) -> Result<Socket, LinkError> {
    let failed = |e| LinkError::system("opening a socket for", address, e);
    let socket = Socket::new(Domain::for_address(address), Type::DGRAM, Some(Protocol::UDP))
        .map_err(failed)?;
    if address.is_ipv6() {
        socket.set_only_v6(true).map_err(failed)?;
    }
    Ok(socket)
}

/// The groups to join: those sent to and those named.
fn groups(config: &LinkConfig) -> Vec<IpAddr> {
    let sent_to = config.to.list().iter().filter_map(|d| match d {
        Destination::Group(a) => Some(a.ip()),
        _ => None,
    });
    let mut all: Vec<IpAddr> = Vec::new();
    for group in sent_to.chain(config.groups.iter().copied()) {
        if !all.contains(&group) {
            all.push(group);
        }
    }
    all
}

/// Where a receiver listens if nothing else is said.
fn listening_address(config: &LinkConfig, groups: &[IpAddr], index: u32) -> SocketAddr {
    if let Some(listen) = config.listen {
        return listen;
    }
    let first = config.to.first();
    let any: IpAddr = match first {
        SocketAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
        SocketAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
    };
    let only_one = config.to.list().len() == 1;
    let ip = match config.to.list()[0] {
        // Bound to the group, a socket hears nothing else.
        Destination::Group(_) if only_one && groups.len() == 1 => first.ip(),
        // Bound to it, a socket hears nothing from outside the host.
        Destination::Broadcast(a) if only_one && groups.is_empty() && a.ip().is_loopback() => {
            a.ip()
        }
        Destination::Host(_) if groups.is_empty() && !config.to.leave_host() => match first {
            SocketAddr::V4(_) => Ipv4Addr::LOCALHOST.into(),
            SocketAddr::V6(_) => Ipv6Addr::LOCALHOST.into(),
        },
        Destination::Host(_) if groups.is_empty() => config.interface.unwrap_or(any),
        _ => any,
    };
    match ip {
        IpAddr::V6(v6) => SocketAddrV6::new(v6, first.port(), 0, scope(first, index)).into(),
        v4 => SocketAddr::new(v4, first.port()),
    }
}

/// The scope written in the address, else the interface's index.
fn scope(address: SocketAddr, index: u32) -> u32 {
    match address {
        SocketAddr::V6(v6) if v6.scope_id() != 0 => v6.scope_id(),
        _ => index,
    }
}

/// A bound socket with its groups joined, and the address that stands for "to us" in what arrives.
pub(crate) fn receiving_socket(config: &LinkConfig) -> Result<(Socket, SocketAddr), LinkError> {
    let index = interface_index(config)?;
    let groups = groups(config);
    let shared = !groups.is_empty()
        || config.to.list().iter().any(|d| matches!(d, Destination::Broadcast(_)));
    let mut address = listening_address(config, &groups, index);
    let mut bound = bound_socket(address, shared);
    if !shared && config.listen.is_none() {
        // A list may name this host several times, with a port for each of its processes.
        for other in config.to.list().iter().map(Destination::address) {
            if matches!(bound, Err(LinkError::InUse { .. })) && is_ours(other, address) {
                address = SocketAddr::new(address.ip(), other.port());
                bound = bound_socket(address, shared);
            }
        }
    }
    let socket = bound?;
    let failed = |e| LinkError::system("preparing to listen on", address, e);
    for (joined, group) in groups.iter().enumerate() {
        join(&socket, *group, config, index).map_err(|e| match e.raw_os_error() {
            Some(nix::libc::ENODEV) => {
                LinkError::NoRoute { to: SocketAddr::new(*group, address.port()) }
            }
            Some(nix::libc::ENOBUFS) => LinkError::TooManyGroups { group: *group, joined },
            _ => LinkError::system("joining", SocketAddr::new(*group, address.port()), e),
        })?;
    }
    socket.set_nonblocking(true).map_err(failed)?;
    let to_us = match config.to.list() {
        [one] if config.listen.is_none() && groups.len() < 2 => match one {
            Destination::Host(_) => address,
            other => other.address(),
        },
        _ => address,
    };
    Ok((socket, to_us))
}

/// Whether datagrams to an entry of the list arrive at this host, for a socket that listens at `address`.
fn is_ours(entry: SocketAddr, address: SocketAddr) -> bool {
    entry.port() != address.port()
        && if address.ip().is_unspecified() {
            local_addresses().iter().any(|(ip, _)| *ip == entry.ip())
        } else {
            entry.ip() == address.ip()
        }
}

fn bound_socket(address: SocketAddr, shared: bool) -> Result<Socket, LinkError> {
    let socket = new_socket(address)?;
    let failed = |e| LinkError::system("preparing to listen on", address, e);
    if shared {
        // Every process gets every broadcast and multicast datagram. A unicast port is not shared:
        // the last to open it would silently take it from the others.
        socket.set_reuse_address(true).map_err(failed)?;
    }
    // Groups that other processes of this host joined are none of our business.
    match address {
        SocketAddr::V4(_) => socket.set_multicast_all_v4(false),
        SocketAddr::V6(_) => socket.set_multicast_all_v6(false),
    }
    .map_err(failed)?;
    socket.bind(&address.into()).map_err(|e| match e.kind() {
        io::ErrorKind::AddrInUse => LinkError::InUse { address, shared },
        io::ErrorKind::AddrNotAvailable => LinkError::NoSuchInterface {
            wanted: address.ip(),
            have: local_addresses().into_iter().map(|(ip, _)| ip).collect(),
        },
        _ => LinkError::system("listening on", address, e),
    })?;
    Ok(socket)
}

fn join(socket: &Socket, group: IpAddr, config: &LinkConfig, index: u32) -> io::Result<()> {
    match (group, config.interface) {
        (IpAddr::V4(group), Some(IpAddr::V4(interface))) => {
            socket.join_multicast_v4(&group, &interface)
        }
        (IpAddr::V4(group), _) => socket.join_multicast_v4(&group, &Ipv4Addr::UNSPECIFIED),
        (IpAddr::V6(group), _) => socket.join_multicast_v6(&group, scope(config.to.first(), index)),
    }
}

/// A socket to send from, connected where there is one destination only.
pub(crate) fn sending_socket(config: &LinkConfig) -> Result<Socket, LinkError> {
    let index = interface_index(config)?;
    let first = config.to.first();
    let socket = new_socket(first)?;
    let failed = |e| LinkError::system("preparing to send to", first, e);
    // A burst must not wait for the network card.
    socket.set_send_buffer_size(1 << 20).map_err(failed)?;
    let ttl = u32::from(config.ttl);
    match first {
        SocketAddr::V4(_) => {
            socket.set_broadcast(true).map_err(failed)?;
            socket.set_multicast_loop_v4(true).map_err(failed)?;
            socket.set_multicast_ttl_v4(ttl).map_err(failed)?;
            if config.to.list().iter().all(|d| matches!(d, Destination::Broadcast(_))) {
                socket.set_ttl_v4(ttl.max(1)).map_err(failed)?;
            }
            if let Some(IpAddr::V4(interface)) = config.interface {
                socket.set_multicast_if_v4(&interface).map_err(failed)?;
            }
        }
        SocketAddr::V6(_) => {
            socket.set_multicast_loop_v6(true).map_err(failed)?;
            socket.set_multicast_hops_v6(ttl).map_err(failed)?;
            socket.set_multicast_if_v6(scope(first, index)).map_err(failed)?;
        }
    }
    if let Some(interface) = config.interface {
        let address = match interface {
            IpAddr::V6(v6) => SocketAddrV6::new(v6, 0, 0, index).into(),
            v4 => SocketAddr::new(v4, 0),
        };
        socket.bind(&address.into()).map_err(|e| LinkError::system("sending from", address, e))?;
    }
    if config.to.list().len() == 1 {
        let to = match first {
            SocketAddr::V6(v6) => {
                SocketAddrV6::new(*v6.ip(), v6.port(), v6.flowinfo(), scope(first, index)).into()
            }
            v4 => v4,
        };
        socket.connect(&to.into()).map_err(|e| LinkError::system("sending to", first, e))?;
    }
    Ok(socket)
}
