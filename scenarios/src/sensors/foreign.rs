//! `kind = "asterix"`: somebody's real sensor, whose plots come in ASTERIX from the network or from a recording.

use crate::document::{Section, within};
use crate::error::{Problem, ScenarioError};
use crate::run::Run;
use models::plot::SensorKind;
use models::sensors::KINDS;
use std::fmt;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;

/// Categories whose reports can be plots.
pub const CATEGORIES: [u8; 5] = [10, 20, 21, 48, 62];

/// Keys that only this kind has.
pub(crate) const KEYS: [&str; 10] = [
    "listen",
    "interface",
    "from",
    "file",
    "sac",
    "sic",
    "categories",
    "sigma_m",
    "interval_s",
    "clock",
];

/// A sensor of somebody else.
#[derive(Clone, Debug, PartialEq)]
pub struct ForeignScene {
    /// Where its plots come from.
    pub source: ForeignSource,
    /// System area code of its reports; any where it is not given.
    pub sac: Option<u8>,
    /// System identification code of its reports; any where it is not given.
    pub sic: Option<u8>,
    /// Categories taken, of [`CATEGORIES`].
    pub categories: Vec<u8>,
    /// Standard deviation of a position east and north whose report says none, m.
    pub sigma_m: f64,
    /// Seconds between two reports of a target.
    pub interval_s: f64,
    /// Whether its clock is another than the scene's: its first plot counts as measured when it arrived (at the start of
    /// the run, of a recording), all others relative to it.
    pub first: bool,
}

/// Where the plots of a sensor of somebody else come from.
#[derive(Clone, Debug, PartialEq)]
pub enum ForeignSource {
    /// From the network, by way of the member `visitors`: such a run is external.
    Live {
        /// Own address, multicast group or broadcast address, with the port.
        listen: SocketAddr,
        /// Interface of the group.
        interface: Option<IpAddr>,
        /// Only these senders; all where it is empty.
        from: Vec<IpAddr>,
    },
    /// From a recording: part of the scene, equal in every run.
    Recording {
        /// The file.
        path: PathBuf,
        /// What it holds: pcap, pcapng, bare blocks, IOSS final or RFF.
        octets: Octets,
    },
}

/// The octets of a file, shared; shown by their number.
#[derive(Clone, PartialEq, Eq)]
pub struct Octets(pub Arc<[u8]>);

impl fmt::Debug for Octets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} octets", self.0.len())
    }
}

impl ForeignScene {
    /// Whether its plots come from the network.
    #[must_use]
    pub fn is_live(&self) -> bool {
        matches!(self.source, ForeignSource::Live { .. })
    }

    /// Whether reports of this sender and category are its own.
    #[must_use]
    pub fn is_of(&self, (sac, sic): (u8, u8), category: u8) -> bool {
        self.sac.is_none_or(|own| own == sac)
            && self.sic.is_none_or(|own| own == sic)
            && self.categories.contains(&category)
    }
}

/// Reads such a sensor: what it is, the kind of sensor that it stands for, and the file if it is a recording.
pub(super) fn read(
    section: &Section,
    run: &Run,
) -> Result<(ForeignScene, SensorKind, Option<PathBuf>), ScenarioError> {
    for key in ["parameters", "overrides", "equipped", "figures"] {
        if section.has(key) {
            let allowed = "none: somebody's sensor is as it is".into();
            return Err(section.refuse(key, Problem::NotAllowed { found: key.into(), allowed }));
        }
    }
    let kinds: Vec<_> = KINDS.iter().map(|d| (d.kind.word, SensorKind(&d.kind))).collect();
    let kind = section.choice("of", &kinds)?.unwrap_or(SensorKind::Asde);
    let code = |key| Ok(section.integer(key, 0, 255)?.map(|n| n as u8));
    let mut categories = Vec::new();
    if section.has("categories") {
        for number in section.numbers("categories", within(0.0, 255.0, ""))? {
            let known = CATEGORIES.iter().find(|c| f64::from(**c) == number);
            let Some(category) = known else {
                let allowed = CATEGORIES.map(|c| c.to_string()).join(", ");
                let problem = Problem::NotAllowed { found: number.to_string(), allowed };
                return Err(section.refuse("categories", problem));
            };
            categories.push(*category);
        }
    } else {
        categories.extend(CATEGORIES);
    }
    let clocks = [("utc", false), ("first", true)];
    let (source, file) = source(section)?;
    let scene = ForeignScene {
        source,
        sac: code("sac")?,
        sic: code("sic")?,
        categories,
        sigma_m: section.number_or("sigma_m", 5.0, within(0.01, 1000.0, "m"))?,
        interval_s: section.number_or("interval_s", run.scan().s(), within(0.05, 60.0, "s"))?,
        first: section.choice("clock", &clocks)?.unwrap_or(false),
    };
    Ok((scene, kind, file))
}

fn source(section: &Section) -> Result<(ForeignSource, Option<PathBuf>), ScenarioError> {
    if section.has("file") {
        for key in ["listen", "interface", "from"] {
            if section.has(key) {
                let allowed = "either the network (`listen`) or a recording (`file`)".into();
                let found = key.into();
                return Err(section.refuse(key, Problem::NotAllowed { found, allowed }));
            }
        }
    }
    if let Some(path) = section.file_path("file")? {
        let octets = crate::files::read(&path, crate::LARGEST_DATA).map_err(|error| {
            let reason = error.to_string();
            section.refuse("file", Problem::File { path: path.clone(), reason })
        })?;
        let octets = Octets(octets.into());
        return Ok((ForeignSource::Recording { path: path.clone(), octets }, Some(path)));
    }
    let Some(text) = section.text("listen")? else {
        let needed = "where its plots come from: an address with a port, like \"239.9.1.1:8600\", \
                      or a recording as `file`";
        return Err(section.missing("listen", needed.into()));
    };
    let wrong = |key: &str, found: &str, needed: &str| {
        let (found, needed) = (format!("\"{found}\""), needed.to_owned());
        section.refuse(key, Problem::WrongKind { found, needed })
    };
    let listen = text
        .parse()
        .map_err(|_| wrong("listen", text, "an address with a port, like \"239.9.1.1:8600\""))?;
    let ip = |key: &str, text: &str| {
        text.parse::<IpAddr>().map_err(|_| wrong(key, text, "an address, like \"10.0.0.7\""))
    };
    let interface = section.text("interface")?.map(|text| ip("interface", text)).transpose()?;
    let from = if section.has("from") { section.texts("from")? } else { Vec::new() };
    let from = from.iter().map(|(text, _)| ip("from", text)).collect::<Result<_, _>>()?;
    Ok((ForeignSource::Live { listen, interface, from }, None))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn sensor(text: &str) -> Result<(ForeignScene, SensorKind, Option<PathBuf>), String> {
        let scene = crate::load_without_truth(&crate::locate("zurich")).expect("zurich");
        let section = Section::parse(Path::new("scene.toml"), text).expect("TOML");
        read(&section, &scene.run).map_err(|e| e.to_string())
    }

    #[test]
    fn a_sensor_of_somebody_is_read() {
        let (scene, kind, file) = sensor(
            "listen = \"239.9.1.1:8600\"\nof = \"mlat\"\nsac = 1\nsic = 2\ncategories = [20]\n\
             sigma_m = 3.5\nfrom = [\"10.0.0.7\"]\ninterface = \"127.0.0.1\"\nclock = \"first\"",
        )
        .expect("sound");
        assert_eq!((kind, file), (SensorKind::Mlat, None));
        assert!(scene.is_live() && scene.first && scene.sigma_m == 3.5 && scene.interval_s == 1.0);
        assert!(scene.is_of((1, 2), 20) && !scene.is_of((1, 3), 20) && !scene.is_of((1, 2), 21));
        let all = sensor("listen = \"127.0.0.1:8600\"").expect("the least").0;
        assert!(CATEGORIES.iter().all(|c| all.is_of((7, 9), *c)) && !all.is_of((7, 9), 11));
    }

    #[test]
    fn what_it_cannot_be_is_refused_with_its_line() {
        for (text, needle) in [
            ("name = 1", "listen"),
            ("listen = \"here\"", "an address with a port"),
            ("listen = \"1.1.1.1:9\"\ncategories = [10, 34]", "10, 20, 21, 48, 62"),
            ("listen = \"1.1.1.1:9\"\nfrom = [\"x\"]", "an address"),
            ("listen = \"1.1.1.1:9\"\nsac = 256", "sac"),
            ("listen = \"1.1.1.1:9\"\nof = \"eye\"", "eye"),
            ("listen = \"1.1.1.1:9\"\nequipped = 0.5", "equipped"),
            ("file = \"no-such.pcapng\"", "no-such.pcapng"),
            ("file = \"a.pcapng\"\nlisten = \"1.1.1.1:9\"", "either the network"),
        ] {
            let error = sensor(text).expect_err(text);
            assert!(error.contains(needle), "{text}: {error}");
        }
    }
}
