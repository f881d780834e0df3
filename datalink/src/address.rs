//! Where datagrams go: `ADDR:PORT`, or several of them with commas between.

use std::fmt;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::str::FromStr;

/// One place where datagrams go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Destination {
    /// A multicast group.
    Group(SocketAddr),
    /// A broadcast address: all hosts of a network, or all programs of this host.
    Broadcast(SocketAddr),
    /// One host.
    Host(SocketAddr),
}

impl Destination {
    /// What kind of address it is: multicast by its range; broadcast where the last octet is 255
    /// (networks with other masks need `Destination::Broadcast` by hand); a host otherwise.
    #[must_use]
    pub fn of(address: SocketAddr) -> Self {
        match address.ip() {
            ip if ip.is_multicast() => Self::Group(address),
            IpAddr::V4(v4) if v4.octets()[3] == 255 => Self::Broadcast(address),
            _ => Self::Host(address),
        }
    }

    /// The address.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        let (Self::Group(a) | Self::Broadcast(a) | Self::Host(a)) = self;
        *a
    }
}

/// All places where datagrams go. At least one; all IPv4 or all IPv6.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Destinations(Vec<Destination>);

/// Why a list of addresses was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AddressError {
    /// Not an address with a port.
    #[error(
        "`{0}` is not ADDR:PORT (such as 127.255.255.255:3000, 239.1.2.3:3000 or [ff02::1:3]:3000)"
    )]
    NotAnAddress(String),
    /// Port 0 cannot be sent to.
    #[error("`{0}`: port 0 cannot be sent to; DIS uses 3000")]
    NoPort(String),
    /// Nothing in the list.
    #[error("no address given")]
    Nothing,
    /// IPv4 and IPv6 in one list.
    #[error("{0} and {1} in one list: use either IPv4 or IPv6")]
    Mixed(IpAddr, IpAddr),
}

impl Destinations {
    /// Broadcast that cannot leave the host, port 3000: the default.
    #[must_use]
    pub fn this_host() -> Self {
        let all = SocketAddr::new(Ipv4Addr::new(127, 255, 255, 255).into(), 3000);
        Self(vec![Destination::Broadcast(all)])
    }

    /// A list checked.
    ///
    /// # Errors
    /// [`AddressError`] for an empty or mixed list, or port 0.
    pub fn new(list: Vec<Destination>) -> Result<Self, AddressError> {
        let first = list.first().ok_or(AddressError::Nothing)?.address();
        for d in &list {
            let address = d.address();
            if address.port() == 0 {
                return Err(AddressError::NoPort(address.to_string()));
            }
            if address.is_ipv4() != first.is_ipv4() {
                return Err(AddressError::Mixed(first.ip(), address.ip()));
            }
        }
        Ok(Self(list))
    }

    /// The list.
    #[must_use]
    pub fn list(&self) -> &[Destination] {
        &self.0
    }

    /// The first address.
    #[must_use]
    pub fn first(&self) -> SocketAddr {
        self.0[0].address()
    }

    /// Whether what is sent can leave this host.
    #[must_use]
    pub fn leave_host(&self) -> bool {
        !self.0.iter().all(|d| d.address().ip().is_loopback())
    }
}

impl Default for Destinations {
    fn default() -> Self {
        Self::this_host()
    }
}

impl FromStr for Destinations {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, AddressError> {
        let parse = |part: &str| {
            let address = part.trim().parse::<SocketAddr>();
            address.map(Destination::of).map_err(|_| AddressError::NotAnAddress(part.to_owned()))
        };
        if text.trim().is_empty() {
            return Err(AddressError::Nothing);
        }
        Self::new(text.split(',').map(parse).collect::<Result<_, _>>()?)
    }
}

impl fmt::Display for Destinations {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, d) in self.0.iter().enumerate() {
            write!(f, "{}{}", if i > 0 { "," } else { "" }, d.address())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kind_follows_from_the_address() {
        for (text, kind, leaves) in [
            ("127.255.255.255:3000", "Broadcast", false),
            ("255.255.255.255:3000", "Broadcast", true),
            ("192.168.4.255:3000", "Broadcast", true),
            ("239.1.2.3:3000", "Group", true),
            ("[ff02::1:3]:3000", "Group", true),
            ("127.0.0.1:3000,127.0.0.1:3001", "Host", false),
            ("10.0.0.4:3000, 10.0.0.5:3000", "Host", true),
            ("[::1]:3000", "Host", false),
        ] {
            let d: Destinations = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
            assert!(format!("{:?}", d.list()[0]).starts_with(kind), "{text}");
            assert_eq!(d.leave_host(), leaves, "{text}");
            assert_eq!(d.to_string().parse::<Destinations>().as_ref(), Ok(&d), "{text}");
        }
        assert_eq!(Destinations::default().to_string(), "127.255.255.255:3000");
    }

    #[test]
    fn what_cannot_be_sent_to_is_refused_with_a_reason() {
        for (text, reason) in [
            ("", "no address"),
            ("127.0.0.1", "is not ADDR:PORT"),
            ("localhost:3000", "is not ADDR:PORT"),
            ("1.2.3.4:99999", "is not ADDR:PORT"),
            ("1.2.3.4:3000,", "is not ADDR:PORT"),
            ("1.2.3.4:0", "port 0"),
            ("1.2.3.4:3000,[::1]:3000", "either IPv4 or IPv6"),
        ] {
            let error = text.parse::<Destinations>().expect_err(text).to_string();
            assert!(error.contains(reason), "{text}: {error}");
        }
    }
}
