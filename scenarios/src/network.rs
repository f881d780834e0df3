//! `[network]`: where the federates of the scene meet, unless the command line says otherwise.

use crate::document::{Section, within};
use crate::error::{Problem, ScenarioError};
use crate::keys::{self, words};
use crate::losses::{self, ByMember, Losses};
use std::collections::BTreeSet;
use std::fmt;
use std::net::{IpAddr, SocketAddr};
use std::str::FromStr;

/// `[network]` of a scene. Not part of the scene's hash.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    /// Where DIS datagrams go: a multicast group, a broadcast address, or a list of hosts.
    pub dis: Vec<SocketAddr>,
    /// Interface for DIS; `None` leaves it to the system.
    pub interface: Option<IpAddr>,
    /// Time to live of DIS datagrams.
    pub ttl: u8,
    /// Whether several PDUs share a datagram; none: where a frame has many.
    pub bundle: Option<bool>,
    /// Whose datagrams of DIS are taken; everybody's where it is empty.
    pub dis_from: Vec<AddressRange>,
    /// Sites whose entities are taken beside the scene's own; all where it is empty.
    pub dis_sites: BTreeSet<u16>,
    /// Hosts whose simulation management is obeyed beside this one.
    pub dis_managers: Vec<AddressRange>,
    /// Endpoints of the synchronisation plane to listen at.
    pub sync_listen: Vec<String>,
    /// Endpoints of the synchronisation plane to connect to.
    pub sync_connect: Vec<String>,
    /// What becomes of a run that loses a federate.
    pub losses: Losses,
    /// Endpoints of the agents that start federates on other hosts.
    pub agents: ByMember<String>,
}

impl Default for Network {
    /// Broadcast that cannot leave the host, on the registered port of DIS.
    fn default() -> Self {
        Self {
            dis: vec![SocketAddr::from(([127, 255, 255, 255], 3000))],
            interface: None,
            ttl: 1,
            bundle: None,
            dis_from: Vec::new(),
            dis_sites: BTreeSet::new(),
            dis_managers: Vec::new(),
            sync_listen: Vec::new(),
            sync_connect: Vec::new(),
            losses: Losses::default(),
            agents: ByMember::default(),
        }
    }
}

/// Reads `[network]`.
pub(crate) fn read(root: &Section) -> Result<Network, ScenarioError> {
    let mut network = Network::default();
    let Some(section) = root.section("network", &words(keys::NETWORK))? else { return Ok(network) };
    if section.has("dis") {
        network.dis = section
            .texts("dis")?
            .iter()
            .map(|(text, line)| {
                text.parse().map_err(|_| {
                    let needed = "a list of ADDRESS:PORT like \"127.255.255.255:3000\"".into();
                    let problem =
                        Problem::WrongKind { found: format!("the text {text:?}"), needed };
                    ScenarioError::new(section.file(), *line, "network.dis", problem)
                })
            })
            .collect::<Result<_, _>>()?;
    }
    if let Some(text) = section.text("interface")? {
        network.interface = Some(text.parse().map_err(|_| {
            let needed = "an address of this host like \"127.0.0.1\"".into();
            let found = format!("the text {text:?}");
            section.refuse("interface", Problem::WrongKind { found, needed })
        })?);
    }
    network.ttl = section.integer("ttl", 0, 255)?.unwrap_or(i64::from(network.ttl)) as u8;
    network.bundle = section.flag("bundle")?;
    network.dis_from = ranges(&section, "dis_from")?;
    network.dis_managers = ranges(&section, "dis_managers")?;
    if section.has("dis_sites") {
        let sites = section.numbers("dis_sites", within(0.0, 65_535.0, ""))?;
        if let Some(part) = sites.iter().find(|site| site.fract() != 0.0) {
            let (found, allowed) = (part.to_string(), "whole numbers, 0 to 65535".into());
            return Err(section.refuse("dis_sites", Problem::NotAllowed { found, allowed }));
        }
        network.dis_sites = sites.into_iter().map(|site| site as u16).collect();
    }
    let endpoints = |key| -> Result<Vec<String>, ScenarioError> {
        Ok(section.texts(key)?.into_iter().map(|(text, _)| text).collect())
    };
    network.sync_listen = endpoints("sync_listen")?;
    network.sync_connect = endpoints("sync_connect")?;
    network.losses = losses::read(&section)?;
    network.agents = losses::members(&section, "agents", |section, key| {
        Ok(section.text(key)?.map(str::to_owned))
    })?;
    Ok(network)
}

/// A list of addresses, or of networks of them.
fn ranges(section: &Section, key: &str) -> Result<Vec<AddressRange>, ScenarioError> {
    if !section.has(key) {
        return Ok(Vec::new());
    }
    let range = |(text, line): (String, usize)| {
        text.parse().map_err(|needed: String| {
            let problem = Problem::WrongKind { found: format!("the text {text:?}"), needed };
            ScenarioError::new(section.file(), line, format!("network.{key}"), problem)
        })
    };
    section.texts(key)?.into_iter().map(range).collect()
}

/// A host, or all hosts of a network: `10.0.0.7`, `10.0.0.0/24`, `fd00::/8`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AddressRange {
    ip: IpAddr,
    /// Bits from the left that an address has in common with it.
    bits: u32,
}

impl AddressRange {
    /// Whether an address is of it. An IPv4 address is the same inside IPv6 (`::ffff:10.0.0.7`).
    #[must_use]
    pub fn holds(&self, ip: IpAddr) -> bool {
        match (self.ip, ip.to_canonical()) {
            (IpAddr::V4(own), IpAddr::V4(ip)) => {
                (u32::from(own) ^ u32::from(ip)).leading_zeros() >= self.bits
            }
            (IpAddr::V6(own), IpAddr::V6(ip)) => {
                (u128::from(own) ^ u128::from(ip)).leading_zeros() >= self.bits
            }
            _ => false,
        }
    }
}

impl FromStr for AddressRange {
    type Err = String;

    /// # Errors
    /// What is needed, for a person.
    fn from_str(text: &str) -> Result<Self, String> {
        let needed = "an address like \"10.0.0.7\", or a network like \"10.0.0.0/24\"";
        let (ip, bits) = text.split_once('/').map_or((text, None), |(ip, bits)| (ip, Some(bits)));
        let ip = ip.parse::<IpAddr>().map_err(|_| needed)?.to_canonical();
        let most = if ip.is_ipv4() { 32 } else { 128 };
        let bits = bits.map_or(Ok(most), |bits| bits.parse().map_err(|_| needed))?;
        if bits > most {
            return Err(needed.to_owned());
        }
        Ok(Self { ip, bits })
    }
}

impl fmt::Display for AddressRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.ip, self.bits) {
            (IpAddr::V4(ip), 32) => write!(f, "{ip}"),
            (IpAddr::V6(ip), 128) => write!(f, "{ip}"),
            (ip, bits) => write!(f, "{ip}/{bits}"),
        }
    }
}

/// The value of a flag for `agents`: `tls/10.0.0.2:7450`, `smdfm=tls/10.0.0.2:7450`, or several with commas between.
///
/// # Errors
/// What is wrong with it.
pub fn agents_flag(text: &str) -> Result<ByMember<String>, String> {
    losses::by_member(text, |endpoint| Ok(endpoint.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn a_range_holds_what_has_its_bits_and_is_written_as_it_is_read() {
        for (range, inside, outside) in [
            ("10.0.0.7", &["10.0.0.7", "::ffff:10.0.0.7"][..], &["10.0.0.6", "::a00:7"][..]),
            ("10.0.0.0/24", &["10.0.0.0", "10.0.0.255"], &["10.0.1.0", "11.0.0.1", "::1"]),
            ("10.1.2.3/9", &["10.0.0.0", "10.127.9.9"], &["10.128.0.0"]),
            ("0.0.0.0/0", &["0.0.0.0", "255.255.255.255"], &["::1"]),
            ("fd00::/8", &["fd00::1", "fdff::"], &["fe00::", "10.0.0.7"]),
            ("::1", &["::1"], &["::2", "127.0.0.1"]),
        ] {
            let read: AddressRange = range.parse().expect(range);
            assert_eq!(read.to_string(), range);
            let holds = |ip: &&str| read.holds(ip.parse().expect("an address"));
            assert!(inside.iter().all(holds), "{range}: {inside:?}");
            assert!(!outside.iter().any(holds), "{range}: {outside:?}");
        }
        for wrong in ["", "10.0.0", "10.0.0.0/33", "::/129", "10.0.0.0/", "10.0.0.0/-1", "host"] {
            let needed = wrong.parse::<AddressRange>().expect_err(wrong);
            assert!(needed.contains("10.0.0.0/24"), "{wrong}: {needed}");
        }
    }

    #[test]
    fn who_may_send_and_who_may_command_stands_in_the_scene() {
        let network = |text: &str| {
            read(&Section::parse(Path::new("x.toml"), text).expect("TOML"))
                .map_err(|e| e.to_string())
        };
        let read = network(
            "[network]\ndis_from = [\"10.0.0.0/24\", \"::1\"]\ndis_sites = [9, 65535]\ndis_managers = [\"10.0.0.9\"]",
        )
        .expect("sound");
        let texts = |ranges: &[AddressRange]| -> Vec<String> {
            ranges.iter().map(ToString::to_string).collect()
        };
        assert_eq!(texts(&read.dis_from), ["10.0.0.0/24", "::1"]);
        assert_eq!(texts(&read.dis_managers), ["10.0.0.9"]);
        assert_eq!(read.dis_sites, BTreeSet::from([9, 65_535]));
        for (wrong, said) in [
            ("dis_from = [\"10.0.0.0/33\"]", "network.dis_from"),
            ("dis_managers = [\"host\"]", "network.dis_managers"),
            ("dis_sites = [65536]", "network.dis_sites"),
            ("dis_sites = [1.5]", "network.dis_sites"),
        ] {
            let refused = network(&format!("[network]\n{wrong}")).expect_err(wrong);
            assert!(refused.contains(said) && refused.contains("x.toml:2"), "{refused}");
        }
    }

    #[test]
    fn agents_are_named_for_all_or_by_federate() {
        let network = |text: &str| {
            read(&Section::parse(Path::new("x.toml"), text).expect("TOML"))
                .map_err(|e| e.to_string())
        };
        let read =
            network("[network]\nagents = { smdfm = \"tls/b:1\", traffic-generator = \"tls/c:1\" }");
        let agents = read.expect("sound").agents;
        assert_eq!(agents.of("smdfm").as_deref(), Some("tls/b:1"));
        assert_eq!(agents.of("traffic-generator-2").as_deref(), Some("tls/c:1"));
        assert_eq!(agents.of("control"), None);
        let flag = agents_flag("tcp/d:1,smdfm=tls/b:1").expect("sound");
        assert_eq!(flag.of("control").as_deref(), Some("tcp/d:1"));
        assert_eq!(agents_flag(&flag.to_string()), Ok(flag));
        assert!(agents_flag("gateway=tcp/d:1").expect_err("here").contains("not a federate"));
        let wrong = network("[network]\nagents = { gateway = \"tcp/d:1\" }").expect_err("here");
        assert!(wrong.contains("gateway"), "{wrong}");
    }
}
