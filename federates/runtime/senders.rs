//! Whose DIS is taken, where a scene or a flag says so: DIS has no authentication, but a network that drops forged
//! source addresses makes addresses worth something.
//!
//! This host's own are always taken: without them a federation would refuse itself.

use super::cli::NetworkArgs;
use datalink::LinkConfig;
use scenarios::network::AddressRange;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// What is counted where a sender's address is not in the list.
pub const NO_SENDER: &str = "sender not in the list (dis_from)";
/// What is counted where an entity's site is not in the list.
pub const NO_SITE: &str = "site not in the list (dis_sites)";
/// What is counted where a host asks something of the run that may not drive it.
pub const NO_MANAGER: &str =
    "simulation management of a host that may not drive the run (dis_managers)";

/// Addresses of which a refusal is said; the rest is counted.
const NAMED: usize = 16;

/// The lists.
#[derive(Clone, Debug, Default)]
pub struct Senders {
    from: Vec<AddressRange>,
    own: Vec<IpAddr>,
    sites: BTreeSet<u16>,
    named: BTreeSet<IpAddr>,
}

impl Senders {
    /// The lists of the command line, else of the scene, in a federation that sends by `config`.
    #[must_use]
    pub fn of(args: &NetworkArgs, scene: &scenarios::Network, config: &LinkConfig) -> Self {
        let from = if args.dis_from.is_empty() { &scene.dis_from } else { &args.dis_from };
        let sites = if args.dis_sites.is_empty() {
            scene.dis_sites.clone()
        } else {
            args.dis_sites.iter().copied().collect()
        };
        let own = if from.is_empty() { Vec::new() } else { own_addresses(config) };
        Self::new(from.clone(), own, sites)
    }

    /// Lists; `own` are the addresses that this host sends from. An empty one is no bound.
    #[must_use]
    pub fn new(from: Vec<AddressRange>, own: Vec<IpAddr>, sites: BTreeSet<u16>) -> Self {
        Self { from, own, sites, named: BTreeSet::new() }
    }

    /// Whether datagrams of this address are taken. The first refusal of each is said.
    pub fn takes(&mut self, from: IpAddr) -> bool {
        let from = from.to_canonical();
        let taken = self.from.is_empty()
            || self.own.contains(&from)
            || self.from.iter().any(|range| range.holds(from));
        if !taken && self.named.len() < NAMED && self.named.insert(from) {
            let mut list = String::new();
            for range in &self.from {
                write!(list, " {range}").ok();
            }
            tracing::warn!(
                "DIS of {from} is not taken: not in the list of senders ({})",
                list.trim()
            );
        }
        taken
    }

    /// Whether entities of a site are taken, in a federation of site `own`.
    #[must_use]
    pub fn takes_site(&self, site: u16, own: u16) -> bool {
        self.sites.is_empty() || site == own || self.sites.contains(&site)
    }
}

/// Hosts whose simulation management is obeyed beside this one.
#[derive(Clone, Debug, Default)]
pub struct Managers {
    from: Vec<AddressRange>,
    own: Vec<IpAddr>,
    named: BTreeSet<IpAddr>,
    refused: Arc<AtomicU64>,
}

impl Managers {
    /// Those of the command line, else of the scene, in a federation that sends by `config`.
    #[must_use]
    pub fn of(args: &NetworkArgs, scene: &scenarios::Network, config: &LinkConfig) -> Self {
        let told = &args.dis_managers;
        let from = if told.is_empty() { scene.dis_managers.clone() } else { told.clone() };
        Self::new(from, own_addresses(config))
    }

    /// A list; `own` are the addresses that this host sends from.
    #[must_use]
    pub fn new(from: Vec<AddressRange>, own: Vec<IpAddr>) -> Self {
        Self { from, own, ..Self::default() }
    }

    /// Whether a host may command the run.
    #[must_use]
    pub fn may_command(&self, from: IpAddr) -> bool {
        let from = from.to_canonical();
        from.is_loopback()
            || self.own.contains(&from)
            || self.from.iter().any(|range| range.holds(from))
    }

    /// Counts a request of a host that may not. The first of each is said.
    pub fn refuse(&mut self, from: IpAddr) {
        let from = from.to_canonical();
        self.refused.fetch_add(1, Ordering::Relaxed);
        if self.named.len() < NAMED && self.named.insert(from) {
            tracing::warn!(
                "simulation management of {from} is not obeyed: it is neither this host nor named (--dis-managers, dis_managers)"
            );
        }
    }

    /// Requests that were refused so far.
    #[must_use]
    pub fn refused(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.refused)
    }
}

/// The addresses that datagrams of this host come from: the interface asked for, or what the system chooses for each destination.
fn own_addresses(config: &LinkConfig) -> Vec<IpAddr> {
    if let Some(interface) = config.interface {
        return vec![interface.to_canonical()];
    }
    let chosen = |to: SocketAddr| {
        let any: IpAddr = match to {
            SocketAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
            SocketAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
        };
        let socket = UdpSocket::bind((any, 0)).ok()?;
        socket.set_broadcast(true).ok();
        socket.connect(to).ok()?; // sends nothing
        Some(socket.local_addr().ok()?.ip().to_canonical())
    };
    config.to.list().iter().filter_map(|d| chosen(d.address())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranges(texts: &[&str]) -> Vec<AddressRange> {
        texts.iter().map(|text| text.parse().expect("a range")).collect()
    }

    fn ip(text: &str) -> IpAddr {
        text.parse().expect("an address")
    }

    #[test]
    fn a_list_of_senders_takes_whom_it_names_and_this_host() {
        let mut senders =
            Senders::new(ranges(&["10.0.0.0/24"]), vec![ip("10.9.9.9")], BTreeSet::new());
        for (from, taken) in [
            ("10.0.0.7", true),
            ("::ffff:10.0.0.7", true),
            ("10.9.9.9", true),
            ("10.0.1.7", false),
            ("127.0.0.1", false),
        ] {
            assert_eq!(senders.takes(ip(from)), taken, "{from}");
        }
        assert!(Senders::default().takes(ip("10.0.1.7")), "no list, no bound");
        for n in 0..=255 {
            senders.takes(IpAddr::from([11, 0, 0, n]));
        }
        assert!(senders.named.len() <= NAMED, "a flood of addresses fills no memory");
    }

    #[test]
    fn a_list_of_sites_takes_whom_it_names_and_the_scenes_own() {
        let senders = Senders::new(Vec::new(), Vec::new(), BTreeSet::from([9]));
        for (site, taken) in [(9, true), (417, true), (10, false), (0, false)] {
            assert_eq!(senders.takes_site(site, 417), taken, "{site}");
        }
        assert!(Senders::default().takes_site(10, 417));
    }

    #[test]
    fn a_federation_takes_its_own_datagrams_whatever_the_list_says() {
        let mut scene =
            scenarios::Network { dis_from: ranges(&["10.0.0.7"]), ..Default::default() };
        let args = NetworkArgs::default();
        for (dis, interface) in [
            ("127.255.255.255:3000", None),
            ("127.0.0.1:3000", None),
            ("127.0.0.1:3000", Some("127.0.0.5")),
        ] {
            scene.dis = vec![dis.parse().expect("an address")];
            scene.interface = interface.map(ip);
            let config = super::super::dis_socket::link_config(&args, &scene).expect("sound");
            let mut senders = Senders::of(&args, &scene, &config);
            assert!(senders.takes(ip(interface.unwrap_or("127.0.0.1"))), "{dis} {interface:?}");
            assert!(!senders.takes(ip("127.0.0.9")), "{dis} {interface:?}");
        }
        let bare =
            LinkConfig { to: "127.0.0.1:3000".parse().expect("one"), ..LinkConfig::default() };
        assert_eq!(own_addresses(&bare), [ip("127.0.0.1")], "as the system chooses");
    }

    #[test]
    fn a_flag_goes_before_the_scene() {
        let scene = scenarios::Network {
            dis_from: ranges(&["10.0.0.7"]),
            dis_sites: BTreeSet::from([9]),
            ..Default::default()
        };
        let args = NetworkArgs {
            dis_from: ranges(&["10.0.0.8"]),
            dis_sites: vec![8],
            ..NetworkArgs::default()
        };
        let config = LinkConfig::default();
        let mut told = Senders::of(&args, &scene, &config);
        assert!(told.takes(ip("10.0.0.8")) && !told.takes(ip("10.0.0.7")));
        assert!(told.takes_site(8, 1) && !told.takes_site(9, 1));
        let mut kept = Senders::of(&NetworkArgs::default(), &scene, &config);
        assert!(kept.takes(ip("10.0.0.7")) && !kept.takes(ip("10.0.0.8")));
        assert!(kept.takes_site(9, 1) && !kept.takes_site(8, 1));
    }

    #[test]
    fn hosts_that_are_named_drive_the_run_and_others_do_not() {
        let scene =
            scenarios::Network { dis_managers: ranges(&["10.0.0.9"]), ..Default::default() };
        let flag = NetworkArgs { dis_managers: ranges(&["10.1.0.0/16"]), ..Default::default() };
        let none = NetworkArgs::default();
        for (args, scene, far) in [
            (&none, &scenarios::Network::default(), [false, false]),
            (&none, &scene, [true, false]),
            (&flag, &scene, [false, true]),
        ] {
            let managers = Managers::of(args, scene, &LinkConfig::default());
            let may = |from| managers.may_command(ip(from));
            assert_eq!([may("10.0.0.9"), may("10.1.2.3")], far);
            assert!(may("127.0.0.1") && may("::1") && may("::ffff:127.0.0.1") && !may("10.0.0.8"));
        }
    }

    #[test]
    fn this_host_drives_the_run_also_from_the_interface_that_was_asked_for() {
        let config = LinkConfig {
            to: "239.9.1.1:3000".parse().expect("a group"),
            interface: Some(ip("10.0.0.1")),
            ..LinkConfig::default()
        };
        let (args, scene) = (NetworkArgs::default(), scenarios::Network::default());
        let mut managers = Managers::of(&args, &scene, &config);
        assert!(managers.may_command(ip("10.0.0.1")) && managers.may_command(ip("127.0.0.1")));
        assert!(
            managers.may_command(ip("::ffff:10.0.0.1")) && !managers.may_command(ip("10.0.0.2"))
        );
        let refused = managers.refused();
        (0..3).for_each(|_| managers.refuse(ip("10.0.0.2")));
        assert_eq!(refused.load(Ordering::Relaxed), 3);
    }
}
