//! `[external]`: what goes out to other people's software and what is heard of it, unless the command line says otherwise.

use crate::document::{Section, within};
use crate::error::{Problem, ScenarioError};
use crate::keys::{self, words};
use std::net::{IpAddr, SocketAddr};

/// `[external]` of a scene. Not part of the scene's hash: a gateway changes nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct External {
    /// Where ASTERIX goes.
    pub asterix: Vec<AsterixOut>,
    /// What of it; all where it is empty.
    pub send: Vec<&'static str>,
    /// Only these categories; all where it is empty.
    pub categories: Vec<u8>,
    /// System area code of all that is sent.
    pub sac: Option<u8>,
    /// Times of day: shifted to the host's clock, or the scene's.
    pub wall: Option<bool>,
    /// Where tracks of others are heard.
    pub asterix_in: Vec<AsterixIn>,
    /// Where Beast frames are served.
    pub beast: Option<SocketAddr>,
    /// Where SBS lines are served.
    pub sbs: Option<SocketAddr>,
    /// Whether squitters have what ADS-B sensors were told, and not truth.
    pub reports: Option<bool>,
    /// Where HTTP is served.
    pub http: Option<SocketAddr>,
    /// Endpoint of the public interface.
    pub public: Option<String>,
}

/// A receiver of ASTERIX.
#[derive(Clone, Debug, PartialEq)]
pub struct AsterixOut {
    /// Host, multicast group or broadcast address.
    pub to: SocketAddr,
    /// Interface that it leaves by; `None` leaves that to the command line or the system.
    pub interface: Option<IpAddr>,
    /// Routers that it may pass; as the command line says, or one.
    pub ttl: Option<u8>,
}

/// Where tracks of others come in.
#[derive(Clone, Debug, PartialEq)]
pub struct AsterixIn {
    /// Own address, multicast group or broadcast address.
    pub listen: SocketAddr,
    /// Interface of the group.
    pub interface: Option<IpAddr>,
    /// Only these senders; all where it is empty.
    pub from: Vec<IpAddr>,
    /// What positions in metres are about, degrees and metres above the ellipsoid; the scene's reference without it.
    pub reference: Option<[f64; 3]>,
}

/// What can be sent.
pub const SENDS: [&str; 3] = ["sensors", "tracks", "status"];
/// Categories that a run is sent in.
pub const CATEGORIES: [u8; 9] = [4, 10, 11, 19, 20, 21, 62, 65, 247];

/// Reads `[external]`.
pub(crate) fn read(root: &Section) -> Result<External, ScenarioError> {
    let Some(section) = root.section("external", &words(keys::EXTERNAL))? else {
        return Ok(External::default());
    };
    let mut external = External {
        http: address(&section, "http")?,
        public: section.text("public")?.map(str::to_owned),
        wall: section.choice("time", &[("scene", false), ("wall", true)])?,
        ..External::default()
    };
    for (text, _) in section.texts("send")? {
        let Some(known) = SENDS.iter().find(|word| **word == text) else {
            let allowed = SENDS.join(", ");
            return Err(section.refuse("send", Problem::NotAllowed { found: text, allowed }));
        };
        external.send.push(known);
    }
    if section.has("categories") {
        for number in section.numbers("categories", within(0.0, 255.0, ""))? {
            let Some(known) = CATEGORIES.iter().find(|c| f64::from(**c) == number) else {
                let allowed = CATEGORIES.map(|c| c.to_string()).join(", ");
                let found = number.to_string();
                return Err(section.refuse("categories", Problem::NotAllowed { found, allowed }));
            };
            external.categories.push(*known);
        }
    }
    external.sac = section.integer("sac", 0, 255)?.map(|code| code as u8);
    for out in section.sections("asterix", &words(keys::ASTERIX_OUT))? {
        external.asterix.push(AsterixOut {
            to: needed(&out, "to")?,
            interface: interface(&out)?,
            ttl: out.integer("ttl", 0, 255)?.map(|n| n as u8),
        });
    }
    for heard in section.sections("asterix_in", &words(keys::ASTERIX_IN))? {
        let mut from = Vec::new();
        for (text, line) in heard.texts("from")? {
            from.push(text.parse().map_err(|_| {
                let needed = "a list of addresses like \"10.0.0.7\"".into();
                let problem = Problem::WrongKind { found: format!("the text {text:?}"), needed };
                ScenarioError::new(heard.file(), line, "external.asterix_in.from", problem)
            })?);
        }
        let place = heard.section("reference", &words(keys::REFERENCE))?;
        let reference = match place {
            Some(place) => Some([
                place.need_number("lat_deg", within(-90.0, 90.0, "degrees"))?,
                place.need_number("lon_deg", within(-180.0, 180.0, "degrees"))?,
                place.need_number("height_m", within(-500.0, 9000.0, "m"))?,
            ]),
            None => None,
        };
        external.asterix_in.push(AsterixIn {
            listen: needed(&heard, "listen")?,
            interface: interface(&heard)?,
            from,
            reference,
        });
    }
    if let Some(adsb) = section.section("adsb", &words(keys::ADSB_FEED))? {
        external.beast = address(&adsb, "beast")?;
        external.sbs = address(&adsb, "sbs")?;
        external.reports = adsb.choice("from", &[("truth", false), ("reports", true)])?;
    }
    Ok(external)
}

const ADDRESS: &str = "ADDRESS:PORT like \"127.0.0.1:8600\"";

fn address(section: &Section, key: &str) -> Result<Option<SocketAddr>, ScenarioError> {
    let parse = |text: &str| {
        text.parse().map_err(|_| {
            let found = format!("the text {text:?}");
            section.refuse(key, Problem::WrongKind { found, needed: ADDRESS.into() })
        })
    };
    section.text(key)?.map(parse).transpose()
}

fn needed(section: &Section, key: &str) -> Result<SocketAddr, ScenarioError> {
    address(section, key)?.ok_or_else(|| section.missing(key, ADDRESS.into()))
}

fn interface(section: &Section) -> Result<Option<IpAddr>, ScenarioError> {
    let parse = |text: &str| {
        text.parse().map_err(|_| {
            let needed = "an address of this host like \"127.0.0.1\"".into();
            let found = format!("the text {text:?}");
            section.refuse("interface", Problem::WrongKind { found, needed })
        })
    };
    section.text("interface")?.map(parse).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn external(text: &str) -> Result<External, String> {
        read(&Section::parse(Path::new("x.toml"), text).expect("TOML")).map_err(|e| e.to_string())
    }

    #[test]
    fn every_key_of_external_is_read_and_what_is_wrong_is_said() {
        assert_eq!(external("[run]"), Ok(External::default()));
        let all = external(
            "[external]\nsend = [\"tracks\"]\ncategories = [62, 4]\nsac = 25\ntime = \"wall\"\nhttp = \"127.0.0.1:8601\"\npublic = \"tcp/127.0.0.1:1\"\n\
             adsb = { beast = \"127.0.0.1:30005\", sbs = \"127.0.0.1:30003\", from = \"reports\" }\n\
             [[external.asterix]]\nto = \"239.9.1.1:8600\"\ninterface = \"127.0.0.1\"\nttl = 3\n[[external.asterix]]\nto = \"10.0.0.7:8600\"\n\
             [[external.asterix_in]]\nlisten = \"239.9.1.2:8601\"\ninterface = \"127.0.0.1\"\nfrom = [\"10.0.0.8\"]\nreference = { lat_deg = 47, lon_deg = 8.5, height_m = 0 }\n",
        );
        let at = |text: &str| text.parse().expect("an address");
        let own: IpAddr = "127.0.0.1".parse().expect("an address");
        let expected = External {
            asterix: vec![
                AsterixOut { to: at("239.9.1.1:8600"), interface: Some(own), ttl: Some(3) },
                AsterixOut { to: at("10.0.0.7:8600"), interface: None, ttl: None },
            ],
            send: vec!["tracks"],
            categories: vec![62, 4],
            sac: Some(25),
            wall: Some(true),
            asterix_in: vec![AsterixIn {
                listen: at("239.9.1.2:8601"),
                interface: Some(own),
                from: vec!["10.0.0.8".parse().expect("an address")],
                reference: Some([47.0, 8.5, 0.0]),
            }],
            beast: Some(at("127.0.0.1:30005")),
            sbs: Some(at("127.0.0.1:30003")),
            reports: Some(true),
            http: Some(at("127.0.0.1:8601")),
            public: Some("tcp/127.0.0.1:1".into()),
        };
        assert_eq!(all, Ok(expected));
        for (text, said) in [
            ("send = [\"all\"]", "sensors, tracks, status"),
            ("categories = [48]", "4, 10, 11"),
            ("time = \"now\"", "\"scene\", \"wall\""),
            ("http = \"8601\"", "ADDRESS:PORT"),
            ("adsb = { beast = \"x\" }", "ADDRESS:PORT"),
            ("adsb = { from = \"x\" }", "\"truth\", \"reports\""),
            ("asterix = [{ ttl = 1 }]", "ADDRESS:PORT"),
            ("asterix = [{ to = \"1.2.3.4:5\", ttl = 256 }]", "255"),
            ("asterix = [{ to = \"1.2.3.4:5\", interface = \"lo\" }]", "an address of this host"),
            ("asterix_in = [{ listen = \"1.2.3.4\" }]", "ADDRESS:PORT"),
            ("asterix_in = [{ listen = \"1.2.3.4:5\", from = [\"x\"] }]", "a list of addresses"),
            (
                "asterix_in = [{ listen = \"1.2.3.4:5\", reference = { lat_deg = 91, lon_deg = 0, height_m = 0 } }]",
                "90",
            ),
            ("htp = \"127.0.0.1:1\"", "did you mean `http`"),
        ] {
            let error = external(&format!("[external]\n{text}\n")).expect_err(text);
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
