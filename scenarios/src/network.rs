//! `[network]`: where the federates of the scene meet, unless the command line says otherwise.

use crate::document::Section;
use crate::error::{Problem, ScenarioError};
use crate::keys::{self, words};
use crate::losses::{self, ByMember, Losses};
use std::net::{IpAddr, SocketAddr};

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
