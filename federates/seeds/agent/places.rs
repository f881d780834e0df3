//! Who of a run is started where.

use super::client::Agent;
use crate::runtime::certs::is_loopback;
use crate::runtime::cli::{NetworkArgs, endpoint_of_another};
use crate::runtime::process::random_id;
use crate::seeds::launch::Launched;
use anyhow::{anyhow, ensure};
use scenarios::losses::ByMember;
use std::collections::BTreeMap;

/// Whether what names agents can be meant, before anything is started; `sync` is where the station will listen.
///
/// # Errors
/// What is wrong, and what to do.
pub fn check(agents: &ByMember<String>, network: &NetworkArgs, sync: &str) -> anyhow::Result<()> {
    for endpoint in agents.named.values().chain(&agents.all) {
        let checked = endpoint_of_another(endpoint).map_err(|e| anyhow!("agents: {e}"))?;
        network.check_connecting(&checked).map_err(|e| anyhow!("agents: {e}"))?;
        let place = sync.split_once('/').map_or(sync, |(_, place)| place);
        let anywhere = place.starts_with("0.0.0.0:") || place.starts_with("[::]:");
        ensure!(
            is_loopback(endpoint) || !is_loopback(sync) && !anywhere,
            "what the agent at {endpoint} starts cannot reach the station at {sync}: --sync-listen {}/ADDRESS:PORT with an address of this host that the other one reaches (or sync_listen in the scene)",
            sync.split_once('/').map_or("tcp", |(transport, _)| transport)
        );
    }
    Ok(())
}

/// Connects to the agents of those of `names` that have one.
///
/// # Errors
/// If an agent does not answer.
pub fn place(
    launched: &mut Launched,
    agents: &ByMember<String>,
    names: &[String],
    network: &NetworkArgs,
) -> anyhow::Result<()> {
    let mut by_agent: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for name in names {
        if let Some(endpoint) = agents.of(name) {
            by_agent.entry(endpoint).or_default().push(name.clone());
        }
    }
    let session = random_id();
    for (endpoint, names) in by_agent {
        let certs = network.certs_of("admin-station")?;
        let agent = Agent::connect(&endpoint, certs, session).map_err(|e| anyhow!(e))?;
        launched.place(names, agent);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agents_that_cannot_reach_the_station_are_refused_before_anything_is_started() {
        let open = NetworkArgs::default();
        let certs = NetworkArgs { certs: Some("/c".into()), ..NetworkArgs::default() };
        let (here, there) = ("tls/10.0.0.1:7447", "tls/10.0.0.2:7450");
        for (agent, network, sync, words) in [
            (there, &certs, here, None),
            ("tcp/127.0.0.1:7450", &open, "tcp/127.0.0.1:7447", None),
            (there, &certs, "tls/127.0.0.1:7447", Some("--sync-listen tls/ADDRESS:PORT")),
            (there, &certs, "tls/0.0.0.0:7447", Some("cannot reach the station")),
            (there, &open, here, Some("needs certificates")),
            ("tcp/10.0.0.2:7450", &certs, here, Some("the endpoint is tls/10.0.0.2:7450")),
            ("10.0.0.2:7450", &certs, here, Some("not an endpoint")),
            ("tls/10.0.0.2:0", &certs, here, Some("port 0")),
        ] {
            let named = BTreeMap::from([("smdfm".to_owned(), agent.to_owned())]);
            let said = check(&ByMember { all: None, named }, network, sync);
            let said = said.err().map(|e| e.to_string());
            match (words, said) {
                (None, None) => {}
                (Some(words), Some(said)) if said.contains(words) => {}
                (_, said) => panic!("{agent} {sync}: {said:?}"),
            }
        }
    }
}
