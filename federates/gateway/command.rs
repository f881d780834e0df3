//! `seeds gateway`, and the flags of `seeds run` that start one.

use crate::exchange::operator;
use crate::federation::GATEWAY as NAME;
use crate::gateway::adsb::Origin;
use crate::gateway::commands::{Rights, Wish};
use crate::gateway::listen::HeardLink;
use crate::gateway::ports::Feeds;
use crate::gateway::process::{Inbox, NotAtWallRate, Task, run as run_gateway};
use crate::gateway::public_bus::{DEFAULT_ENDPOINT, PublicConfig};
use crate::gateway::{CATEGORIES, Choice};
use crate::runtime::bus::Bus;
use crate::runtime::cli::print_line;
use crate::runtime::cli::{
    self, BAD_INPUT, COMPLETE, CommonArgs, DATA_LOST, FAILED, NetworkArgs, fail,
    load_scene_without_truth,
};
use crate::runtime::member_process::{open_bus, patience};
use crate::runtime::messages::{HANDOVER_SEAT, SeatAction, SeatOrder};
use crate::runtime::process::{launched, on_interrupt};
use anyhow::{Context, ensure};
use clap::{Args, ValueEnum};
use datalink::{Destinations, LinkConfig};
use geodesy::Geodetic;
use scenarios::external::{AsterixIn, AsterixOut};
use scenarios::{External, Scene};
use std::net::{IpAddr, SocketAddr, ToSocketAddrs};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// Gateway: plots and tracks in ASTERIX for other people's trackers, safety nets and displays
#[derive(Args, Clone, Debug)]
pub struct GatewayArgs {
    #[command(flatten)]
    common: CommonArgs,

    #[command(flatten)]
    asterix: AsterixArgs,
}

/// What is sent in ASTERIX, and where
#[derive(Args, Clone, Debug, Default)]
pub struct AsterixArgs {
    /// Send what sensors and data fusion find, in ASTERIX: host, multicast group or broadcast address; may be said several times
    #[arg(long = "asterix", value_name = "ADDR:PORT")]
    asterix: Vec<Destinations>,

    /// What to send, with commas between: plots and starts of cycle, system tracks, periodic status [default: all]
    #[arg(long = "asterix-send", value_name = "WHAT", value_enum, value_delimiter = ',')]
    asterix_send: Vec<What>,

    /// Only these categories, with commas between, of 4, 10, 11, 19, 20, 21, 62, 65, 247; ADS-B goes out in 10 where 21 is not among them
    #[arg(long = "asterix-cat", value_name = "N", value_delimiter = ',', value_parser = category)]
    asterix_cat: Vec<u8>,

    /// System area code of all that is sent, 0 to 255 [default: 0]
    #[arg(long = "asterix-sac", value_name = "N")]
    asterix_sac: Option<u8>,

    /// Time of day in ASTERIX, SBS lines and JSON: that of the scene, or shifted once so that the first message carries now [default: scene]
    #[arg(long = "asterix-time", value_name = "CLOCK", value_enum)]
    asterix_time: Option<Clock>,

    /// Record every datagram sent into this pcapng file
    #[arg(long = "asterix-record", value_name = "FILE")]
    asterix_record: Option<PathBuf>,

    /// Hear tracks of somebody's tracker in ASTERIX (062, 011, 010, 020, 021) and keep them in the log beside ours: own address, multicast group or broadcast address; may be said several times
    #[arg(long = "asterix-in", value_name = "ADDR:PORT")]
    asterix_in: Vec<Destinations>,

    /// Hear only these senders, with commas between
    #[arg(long = "asterix-from", value_name = "IP", value_delimiter = ',')]
    asterix_from: Vec<IpAddr>,

    /// Point that positions in metres of those tracks are about, degrees and metres above the ellipsoid [default: the scene's reference]
    #[arg(long, value_name = "LAT,LON[,M]", value_parser = reference, allow_hyphen_values = true)]
    asterix_reference: Option<Reference>,

    #[command(flatten)]
    feeds: FeedArgs,

    /// Receivers of the scene, where no flag says one.
    #[arg(skip)]
    streams: Vec<AsterixOut>,

    /// Streams of others that the scene hears, where no flag says one.
    #[arg(skip)]
    heard_streams: Vec<AsterixIn>,
}

/// Latitude and longitude, degrees, and height above the ellipsoid, m.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Reference([f64; 3]);

fn reference(text: &str) -> Result<Reference, String> {
    let numbers: Option<Vec<f64>> = text
        .split(',')
        .map(|part| part.trim().parse().ok().filter(|x: &f64| x.is_finite()))
        .collect();
    let reference = match numbers.as_deref() {
        Some(&[lat, lon]) => Some([lat, lon, 0.0]),
        Some(&[lat, lon, height_m]) => Some([lat, lon, height_m]),
        _ => None,
    };
    let sound = |[lat, lon, height_m]: &[f64; 3]| {
        lat.abs() <= 90.0 && lon.abs() <= 180.0 && (-500.0..=9000.0).contains(height_m)
    };
    reference.filter(sound).map(Reference).ok_or_else(|| {
        format!(
            "'{text}' is not a place: give LAT,LON in degrees or LAT,LON,HEIGHT, like 47.458,8.548,432"
        )
    })
}

/// Ports that others connect to
#[derive(Args, Clone, Debug, Default)]
pub struct FeedArgs {
    /// Extended squitters (ADS-B) of all targets as Beast frames, to whoever connects: readsb, dump1090, tar1090
    #[arg(long, value_name = "ADDR:PORT")]
    beast: Option<SocketAddr>,

    /// The same as BaseStation lines (SBS-1)
    #[arg(long, value_name = "ADDR:PORT")]
    sbs: Option<SocketAddr>,

    /// Targets without 24-bit address get one from F00000 on
    #[arg(long)]
    adsb_invent: bool,

    /// Positions of squitters: true ones of all who have an address, or those that ADS-B sensors were told (with their errors, and of those they heard) [default: truth]
    #[arg(long, value_name = "WHAT", value_enum)]
    adsb_from: Option<AdsbFrom>,

    /// JSON, GeoJSON, a stream of scans, and aircraft.json over HTTP
    #[arg(long, value_name = "ADDR:PORT")]
    http: Option<SocketAddr>,

    /// Public interface: a Zenoh endpoint of its own for clients (Python: seeds_client) [default: tcp/127.0.0.1:7448 where a gateway runs and that is free]
    #[arg(long, value_name = "ENDPOINT", num_args = 0..=1, require_equals = true, default_missing_value = DEFAULT_ENDPOINT)]
    public: Option<String>,

    /// Clients of the public interface may look and not command
    #[arg(long)]
    public_read_only: bool,

    /// No public interface
    #[arg(long, conflicts_with_all = ["public", "public_read_only"])]
    no_public: bool,

    /// FlightGear multiplayer packets of all entities, to an address or the name of a host
    #[arg(long, value_name = "HOST:PORT", value_parser = host_and_port)]
    flightgear: Vec<SocketAddr>,

    /// Traffic reports (GDL 90) of all targets with an address each scan, for displays in cockpits: to an address or the name of a host, port 4000 by custom
    #[arg(long, value_name = "HOST:PORT", value_parser = host_and_port)]
    gdl90: Vec<SocketAddr>,
}

impl FeedArgs {
    /// Flags that ask for a gateway.
    fn given(&self) -> impl Iterator<Item = &'static str> {
        [
            (self.beast.is_some(), "--beast"),
            (self.sbs.is_some(), "--sbs"),
            (self.http.is_some(), "--http"),
            (self.public.is_some(), "--public"),
            (self.public_read_only, "--public-read-only"),
            (!self.flightgear.is_empty(), "--flightgear"),
            (!self.gdl90.is_empty(), "--gdl90"),
        ]
        .into_iter()
        .filter_map(|(given, flag)| given.then_some(flag))
    }

    /// Where clients connect: what was asked for, else (`false`) the place that a gateway has by itself.
    fn public(&self) -> Option<(&str, bool)> {
        match &self.public {
            Some(endpoint) => Some((endpoint, true)),
            None => (!self.no_public).then_some((DEFAULT_ENDPOINT, false)),
        }
    }

    /// What can be told before anything is started.
    fn check(&self, network: &NetworkArgs) -> anyhow::Result<()> {
        for (flag, address) in [("--beast", self.beast), ("--sbs", self.sbs), ("--http", self.http)]
        {
            if let Some(address) = address {
                port_is_free(flag, address)?;
            }
        }
        if let Some(endpoint) = &self.public {
            PublicConfig::check(endpoint, network.certs.is_some()).map_err(anyhow::Error::msg)?;
            let place = endpoint.split_once('/').and_then(|(_, place)| place.parse().ok());
            if let Some(address) = place {
                port_is_free("--public", address)?;
            }
        }
        Ok(())
    }

    fn arguments(&self) -> Vec<String> {
        let mut line = Vec::new();
        let addresses = [("--beast", self.beast), ("--sbs", self.sbs), ("--http", self.http)];
        for (flag, address) in addresses {
            line.extend(address.into_iter().flat_map(|a| [flag.to_owned(), a.to_string()]));
        }
        // The default, too, where it was said: the scene may say otherwise.
        line.extend(self.adsb_from.iter().flat_map(|from| ["--adsb-from".to_owned(), word(from)]));
        for address in &self.flightgear {
            line.extend(["--flightgear".to_owned(), address.to_string()]);
        }
        for address in &self.gdl90 {
            line.extend(["--gdl90".to_owned(), address.to_string()]);
        }
        line.extend(self.public.iter().map(|endpoint| format!("--public={endpoint}")));
        for (flag, is) in [
            ("--public-read-only", self.public_read_only),
            ("--no-public", self.no_public),
            ("--adsb-invent", self.adsb_invent),
        ] {
            if is {
                line.push(flag.to_owned());
            }
        }
        line
    }
}

/// An address, or the first that a name has (of IPv4 if there is one).
fn host_and_port(text: &str) -> Result<SocketAddr, String> {
    let help = "give HOST:PORT, like localhost:5000";
    let found = text.to_socket_addrs().map_err(|e| format!("'{text}': {e}; {help}"))?;
    let mut found: Vec<SocketAddr> = found.collect();
    found.sort_by_key(|address| !address.is_ipv4());
    found.first().copied().ok_or_else(|| format!("'{text}' has no address; {help}"))
}

/// A taken port is better said once, before anything is started.
fn port_is_free(flag: &str, address: SocketAddr) -> anyhow::Result<()> {
    let help = "end the program that uses it, or choose another";
    let bound = std::net::TcpListener::bind(address).map(drop);
    bound.with_context(|| format!("{flag} {address}: {help}"))
}

/// What can be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum What {
    /// Plots and starts of cycle (010, 019, 020, 021)
    Sensors,
    /// System tracks, ends of batch, alerts and stop bars (062, 011, 065, 004)
    Tracks,
    /// Periodic status (010, 019, 065)
    Status,
}

/// Where positions of squitters are from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum AdsbFrom {
    /// Truth
    #[default]
    Truth,
    /// Plots of ADS-B sensors
    Reports,
}

/// Which clock the time of day is of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Clock {
    /// UTC of the scene
    #[default]
    Scene,
    /// The first message carries the host's time, the others follow
    Wall,
}

/// A value as it is said on the command line.
fn word(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned())
}

fn category(text: &str) -> Result<u8, String> {
    let number = text.parse().ok().filter(|number| CATEGORIES.contains(number));
    number.ok_or_else(|| {
        format!("category {text} is not written; there are {CATEGORIES:?}").replace(['[', ']'], "")
    })
}

impl AsterixArgs {
    /// Whether a gateway is asked for.
    #[must_use]
    pub fn asked(&self) -> bool {
        self.sends() || self.hears() || self.given().next().is_some()
    }

    /// Flags that ask for a gateway.
    pub fn given(&self) -> impl Iterator<Item = &'static str> {
        let own = [
            (!self.asterix.is_empty(), "--asterix"),
            (!self.asterix_in.is_empty(), "--asterix-in"),
            (self.asterix_record.is_some(), "--asterix-record"),
        ];
        let own = own.into_iter().filter_map(|(given, flag)| given.then_some(flag));
        own.chain(self.feeds.given())
    }

    fn sends(&self) -> bool {
        !self.asterix.is_empty() || !self.streams.is_empty()
    }

    fn hears(&self) -> bool {
        !self.asterix_in.is_empty() || !self.heard_streams.is_empty()
    }

    /// The same with what a scene says wherever no flag does.
    #[must_use]
    pub fn over(&self, scene: &External) -> Self {
        let mut all = self.clone();
        if all.asterix.is_empty() {
            all.streams.clone_from(&scene.asterix);
        }
        if all.asterix_send.is_empty() {
            let word = |word: &&str| What::from_str(word, false).ok();
            all.asterix_send = scene.send.iter().filter_map(word).collect();
        }
        if all.asterix_cat.is_empty() {
            all.asterix_cat.clone_from(&scene.categories);
        }
        all.asterix_sac = all.asterix_sac.or(scene.sac);
        let clock = |wall| if wall { Clock::Wall } else { Clock::Scene };
        all.asterix_time = all.asterix_time.or(scene.wall.map(clock));
        if all.asterix_in.is_empty() {
            all.heard_streams.clone_from(&scene.asterix_in);
        }
        let feeds = &mut all.feeds;
        feeds.beast = feeds.beast.or(scene.beast);
        feeds.sbs = feeds.sbs.or(scene.sbs);
        feeds.http = feeds.http.or(scene.http);
        let origin = |reports| if reports { AdsbFrom::Reports } else { AdsbFrom::Truth };
        feeds.adsb_from = feeds.adsb_from.or(scene.reports.map(origin));
        if !feeds.no_public && feeds.public.is_none() {
            feeds.public.clone_from(&scene.public);
        }
        all
    }

    /// Looks at what can be told before anything is started.
    ///
    /// # Errors
    /// If a port cannot be opened, or the wall clock is asked for at another rate than 1.
    pub fn check(&self, network: &NetworkArgs, rate: f64) -> anyhow::Result<()> {
        ensure!(
            self.asterix_time != Some(Clock::Wall) || rate == 1.0,
            "--asterix-time wall: times of day follow the wall clock at rate 1 only; leave out --rate and --fast, or take --asterix-time scene"
        );
        ensure!(
            self.asterix_send.is_empty() || self.sends(),
            "--asterix-send: say where to: --asterix <ADDR:PORT>, or [[external.asterix]] of the scene"
        );
        ensure!(
            (self.asterix_from.is_empty() && self.asterix_reference.is_none()) || self.hears(),
            "--asterix-from, --asterix-reference: say where to listen: --asterix-in <ADDR:PORT>, or [[external.asterix_in]] of the scene"
        );
        for link in self.links(network)? {
            datalink::Sender::open(&link)
                .with_context(|| format!("--asterix {}", link.to.first()))?;
        }
        for HeardLink { link, .. } in self.heard(network)? {
            datalink::Receiver::open(&link)
                .with_context(|| format!("--asterix-in {}", link.to.first()))?;
        }
        if let Some(file) = &self.asterix_record {
            cli::writable(file).context("--asterix-record")?;
        }
        self.feeds.check(network)
    }

    fn links(&self, network: &NetworkArgs) -> anyhow::Result<Vec<LinkConfig>> {
        let link = |to: Destinations, interface: Option<IpAddr>, ttl: Option<u8>| LinkConfig {
            to,
            interface: network.interface.or(interface),
            ttl: network.ttl.or(ttl).unwrap_or(1),
            ..LinkConfig::default()
        };
        let flags = self.asterix.iter().map(|to| Ok(link(to.clone(), None, None)));
        let scene = self.streams.iter().map(|out| {
            Ok(link(
                out.to.to_string().parse().context("external.asterix")?,
                out.interface,
                out.ttl,
            ))
        });
        flags.chain(scene).collect()
    }

    fn heard(&self, network: &NetworkArgs) -> anyhow::Result<Vec<HeardLink>> {
        let link = |to: Destinations, interface: Option<IpAddr>| {
            let own = to.first();
            // One host is listened for at its own address and port.
            let host = matches!(datalink::Destination::of(own), datalink::Destination::Host(_));
            LinkConfig {
                to,
                interface: network.interface.or(interface),
                listen: (own.is_ipv4() && host).then_some(own),
                ..LinkConfig::default()
            }
        };
        let place = |[lat, lon, height_m]: [f64; 3]| Geodetic::from_degrees(lat, lon, height_m);
        let about = self.asterix_reference.map(|Reference(place_of)| place(place_of));
        let flags = self.asterix_in.iter().map(|to| {
            Ok(HeardLink { link: link(to.clone(), None), from: self.asterix_from.clone(), about })
        });
        let scene = self.heard_streams.iter().map(|heard| {
            let to = heard.listen.to_string().parse().context("external.asterix_in")?;
            let from = match self.asterix_from.is_empty() {
                true => heard.from.clone(),
                false => self.asterix_from.clone(),
            };
            let about = about.or(heard.reference.map(place));
            Ok(HeardLink { link: link(to, heard.interface), from, about })
        });
        flags.chain(scene).collect()
    }

    fn choice(&self) -> Choice {
        let has = |what| self.asterix_send.is_empty() || self.asterix_send.contains(&what);
        let categories = self.asterix_cat.iter().copied().collect();
        Choice {
            sensors: has(What::Sensors),
            tracks: has(What::Tracks),
            status: has(What::Status),
            categories: (!self.asterix_cat.is_empty()).then_some(categories),
            sac: self.asterix_sac.unwrap_or(0),
        }
    }

    /// The same flags as a command line, for the process that `seeds run` starts.
    #[must_use]
    pub fn arguments(&self) -> Vec<String> {
        let mut line = Vec::new();
        for to in &self.asterix {
            let list: Vec<String> = to.list().iter().map(|d| d.address().to_string()).collect();
            line.extend(["--asterix".to_owned(), list.join(",")]);
        }
        for what in &self.asterix_send {
            line.extend(["--asterix-send".to_owned(), word(what)]);
        }
        for number in &self.asterix_cat {
            line.extend(["--asterix-cat".to_owned(), number.to_string()]);
        }
        line.extend(
            self.asterix_sac.iter().flat_map(|n| ["--asterix-sac".to_owned(), n.to_string()]),
        );
        line.extend(self.asterix_time.iter().flat_map(|c| ["--asterix-time".to_owned(), word(c)]));
        if let Some(file) = &self.asterix_record {
            line.extend(["--asterix-record".to_owned(), file.display().to_string()]);
        }
        for to in &self.asterix_in {
            let list: Vec<String> = to.list().iter().map(|d| d.address().to_string()).collect();
            line.extend(["--asterix-in".to_owned(), list.join(",")]);
        }
        if let Some(Reference([lat, lon, height_m])) = self.asterix_reference {
            line.push(format!("--asterix-reference={lat},{lon},{height_m}"));
        }
        for ip in &self.asterix_from {
            line.extend(["--asterix-from".to_owned(), ip.to_string()]);
        }
        line.extend(self.feeds.arguments());
        line
    }
}

/// The gateway's process.
#[must_use]
pub fn run(args: &GatewayArgs) -> ExitCode {
    crate::runtime::process::end_with_launcher();
    cli::log_to_stderr(args.common.log_format, "warn");
    let scene = match load_scene_without_truth(&args.common.scene) {
        Ok(scene) => scene,
        Err(code) => return code,
    };
    let args = &GatewayArgs { asterix: args.asterix.over(&scene.external), ..args.clone() };
    if !args.asterix.asked() {
        return fail(
            BAD_INPUT,
            "nothing to do: say where to send (--asterix ADDR:PORT), or what to open (--beast, --sbs, --http, --public), here or in [external] of the scene",
        );
    }
    if let Err(e) = args.asterix.check(&args.common.network, 1.0) {
        return fail(BAD_INPUT, format!("{e:#}"));
    }
    match process(args, &scene) {
        Ok(code) => ExitCode::from(code),
        Err(e) if e.is::<NotAtWallRate>() => fail(BAD_INPUT, format!("{e:#}")),
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

fn process(args: &GatewayArgs, scene: &Scene) -> anyhow::Result<u8> {
    let exercise = args.common.exercise.unwrap_or(scene.run.exercise);
    let inbox = Inbox::default();
    let stop = inbox.clone();
    on_interrupt(move || stop.stop())?;
    let (bus, endpoint) = open_bus(&args.common.network, &scene.network, exercise, NAME)?;
    let feeds = &args.asterix.feeds;
    let public = match feeds.public() {
        Some((endpoint_of_clients, asked)) => Some(PublicConfig {
            endpoint: endpoint_of_clients.to_owned(),
            asked,
            exercise,
            certs: match endpoint_of_clients.starts_with("tls/") {
                true => args.common.network.certs_of(NAME)?,
                false => None,
            },
            rights: match asked || args.common.network.certs.is_none() {
                true => rights(args, scene, exercise, &bus, &endpoint)?,
                // What is protected by certificates is not opened to everybody on this host unasked.
                false => Rights::ReadOnly(format!(
                    "this interface is for looking: say --public {DEFAULT_ENDPOINT} where clients are to command"
                )),
            },
        }),
        None => None,
    };
    let task = Task {
        to: args.asterix.links(&args.common.network)?,
        choice: args.asterix.choice(),
        hear: args.asterix.heard(&args.common.network)?,
        wall: args.asterix.asterix_time == Some(Clock::Wall),
        recording: args.asterix.asterix_record.clone(),
        feeds: Feeds {
            beast: feeds.beast,
            sbs: feeds.sbs,
            http: feeds.http,
            public,
            invent: feeds.adsb_invent,
            adsb_from: match feeds.adsb_from {
                Some(AdsbFrom::Reports) => Origin::Reports,
                Some(AdsbFrom::Truth) | None => Origin::Truth,
            },
            flightgear: feeds.flightgear.clone(),
            gdl90: feeds.gdl90.clone(),
        },
        exercise,
        from_begin: launched(),
        patience: patience(),
        endpoint,
    };
    let sent =
        run_gateway(&task, scene, &*bus, &inbox, |places| places.iter().for_each(|p| say(p)));
    bus.close();
    let Some(sent) = sent? else { return Ok(COMPLETE) };
    let line = serde_json::json!({
        "federate": NAME, "scans": sent.scans, "scans_lost": sent.scans_lost, "datagrams": sent.datagrams,
        "datagrams_lost": sent.datagrams_lost, "records_refused": sent.records_refused,
        "asterix_shift_ns": sent.shift_ns, "ports": sent.ports,
    });
    // A launcher takes what its federates print for the summary of the run.
    if launched() {
        tracing::info!("{line}");
    } else {
        print_line(&line.to_string());
    }
    if sent.complete() {
        return Ok(COMPLETE);
    }
    tracing::error!("what was sent is not complete: {line}");
    Ok(DATA_LOST)
}

/// Who may command through the public interface: where certificates are asked for, only an operator's may.
fn rights(
    args: &GatewayArgs,
    scene: &Scene,
    exercise: u8,
    bus: &Arc<dyn Bus>,
    endpoint: &str,
) -> anyhow::Result<Rights> {
    if args.asterix.feeds.public_read_only {
        return Ok(Rights::ReadOnly(
            "this interface is for looking (--public-read-only)".to_owned(),
        ));
    }
    let network = &args.common.network;
    let bus = if network.certs.is_none() {
        Arc::clone(bus)
    } else if network.certs_of("operator").is_ok() {
        open_bus(network, &scene.network, exercise, "operator")?.0
    } else {
        let why = "this gateway holds no operator's certificate (operator.pem, operator.key): command with `seeds admin-station`";
        return Ok(Rights::ReadOnly(why.to_owned()));
    };
    let endpoint = endpoint.to_owned();
    let frame = scene.airport.frame;
    Ok(Rights::Operate(Arc::new(move |source, wish| {
        let action = match wish {
            Wish::Run(command) => match operator::command(&*bus, &endpoint, source, command) {
                Ok(answer) => return (answer.ok, answer.text, Some(answer.state)),
                Err(error) => return (false, error.to_string(), None),
            },
            Wish::Give(given) => given.action(&frame),
            Wish::Release(callsign) => Ok(SeatAction::Release { callsign }),
        };
        let person = source.strip_prefix("client:").unwrap_or(source).to_owned();
        let seat = HANDOVER_SEAT.to_owned();
        let order = action.map(|action| SeatOrder { seat, person, action });
        match order.and_then(|order| operator::hand_over(&*bus, &order)) {
            Ok(answer) => (true, format!("asked, number {}", answer.number), None),
            Err(why) => (false, why, None),
        }
    })))
}

#[expect(clippy::print_stderr, reason = "a word to the person at the terminal")]
fn say(text: &str) {
    eprintln!("SEEDS: {text}");
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        asterix: AsterixArgs,
        #[command(flatten)]
        network: NetworkArgs,
    }

    fn line(flags: &[&str]) -> Line {
        Line::try_parse_from([&["gateway"], flags].concat()).expect("sound")
    }

    /// A shipped scene with `[external]`.
    fn external(text: &str) -> External {
        let place = scenarios::locate("zurich");
        let text = format!("{}\n[external]\n{text}\n", scenarios::text_of(&place).expect("read"));
        scenarios::load_text(&place, &text).expect("a scene").external
    }

    /// What a gateway would do: where it sends, what, where it hears, and its ports.
    fn does(flags: &[&str], scene: &str) -> String {
        let Line { asterix, network } = line(flags);
        told(&asterix.over(&external(scene)), &network)
    }

    fn told(all: &AsterixArgs, network: &NetworkArgs) -> String {
        let feeds = &all.feeds;
        format!(
            "{:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?}",
            all.links(network).expect("addresses"),
            all.choice(),
            all.asterix_time == Some(Clock::Wall),
            all.heard(network).expect("addresses"),
            feeds.beast,
            feeds.sbs,
            feeds.http,
            feeds.public(),
            feeds.adsb_from == Some(AdsbFrom::Reports),
        )
    }

    /// Each key does what its flag does, alone and beside others, and nothing where the flag says something else.
    #[test]
    fn each_key_of_external_does_what_its_flag_does_and_the_flag_goes_before_it() {
        let to = "asterix = [{ to = \"239.9.1.1:8600\" }]";
        let heard = "asterix_in = [{ listen = \"239.9.1.2:8601\" }]";
        let (out, ear) = (["--asterix", "239.9.1.1:8600"], ["--asterix-in", "239.9.1.2:8601"]);
        let own = ["--interface", "127.0.0.1"];
        for (key, flags, others) in [
            (to, &out[..], &["--asterix", "10.0.0.1:1"][..]),
            (
                "asterix = [{ to = \"239.9.1.1:8600\", interface = \"127.0.0.1\" }]",
                &[&out[..], &own].concat(),
                &["--interface", "127.0.0.2"],
            ),
            (
                "asterix = [{ to = \"239.9.1.1:8600\", ttl = 7 }]",
                &[&out[..], &["--ttl", "7"]].concat(),
                &["--ttl", "3"],
            ),
            ("send = [\"tracks\"]", &["--asterix-send", "tracks"], &["--asterix-send", "status"]),
            ("categories = [62]", &["--asterix-cat", "62"], &["--asterix-cat", "11"]),
            ("sac = 25", &["--asterix-sac", "25"], &["--asterix-sac", "0"]),
            ("time = \"wall\"", &["--asterix-time", "wall"], &["--asterix-time", "scene"]),
            (heard, &ear, &["--asterix-in", "127.0.0.1:1"]),
            (
                "asterix_in = [{ listen = \"239.9.1.2:8601\", interface = \"127.0.0.1\" }]",
                &[&ear[..], &own].concat(),
                &["--interface", "127.0.0.2"],
            ),
            (
                "asterix_in = [{ listen = \"239.9.1.2:8601\", from = [\"10.0.0.8\"] }]",
                &[&ear[..], &["--asterix-from", "10.0.0.8"]].concat(),
                &["--asterix-from", "10.0.0.9"],
            ),
            (
                "asterix_in = [{ listen = \"239.9.1.2:8601\", reference = { lat_deg = 47, lon_deg = 8.5, height_m = 3 } }]",
                &[&ear[..], &["--asterix-reference", "47,8.5,3"]].concat(),
                &["--asterix-reference", "46,8,0"],
            ),
            (
                "adsb = { beast = \"127.0.0.1:5\" }",
                &["--beast", "127.0.0.1:5"],
                &["--beast", "127.0.0.1:6"],
            ),
            (
                "adsb = { sbs = \"127.0.0.1:5\" }",
                &["--sbs", "127.0.0.1:5"],
                &["--sbs", "127.0.0.1:6"],
            ),
            (
                "adsb = { from = \"reports\" }",
                &["--adsb-from", "reports"],
                &["--adsb-from", "truth"],
            ),
            ("http = \"127.0.0.1:5\"", &["--http", "127.0.0.1:5"], &["--http", "127.0.0.1:6"]),
            (
                "public = \"tcp/127.0.0.1:5\"",
                &["--public=tcp/127.0.0.1:5"],
                &["--public=tcp/127.0.0.1:6"],
            ),
        ] {
            assert_eq!(does(&[], key), does(flags, ""), "{key}");
            assert_ne!(does(&[], key), does(&[], ""), "{key}: it does something");
            let both = does(others, key);
            assert_ne!(both, does(&[], key), "{key}: {others:?} goes before it");
            let whole = [others, flags].concat();
            // Where the flag is about another one (an interface of a stream), both are said.
            if !whole.iter().any(|f| ["--asterix", "--asterix-in"].contains(f) && others[0] != *f) {
                assert_eq!(both, does(others, ""), "{key}: {others:?} alone");
            }
        }
        assert!(!line(&[]).asterix.over(&external("")).asked(), "a scene without it starts none");
        assert!(line(&[]).asterix.over(&external(to)).asked(), "one with it does");
        assert_eq!(
            does(&["--no-public"], "public = \"tcp/127.0.0.1:5\""),
            does(&["--no-public"], "")
        );
        // What is said of streams needs one.
        let Line { asterix, network } = line(&["--asterix-send", "tracks"]);
        assert!(asterix.over(&external("")).check(&network, 1.0).is_err());
        let Line { asterix, network } = line(&["--asterix-from", "10.0.0.8"]);
        assert!(asterix.over(&external(to)).check(&network, 1.0).is_err());
    }

    #[test]
    fn flags_that_ask_for_a_gateway_are_named() {
        for (flags, named) in [
            (&[][..], &[][..]),
            (&["--asterix-send", "tracks", "--adsb-invent", "--no-public"], &[]),
            (&["--http", "127.0.0.1:1", "--beast", "127.0.0.1:2"], &["--beast", "--http"]),
            (
                &["--gdl90", "127.0.0.1:1", "--asterix", "127.0.0.1:2", "--public-read-only"],
                &["--asterix", "--public-read-only", "--gdl90"],
            ),
        ] {
            let asterix = line(flags).asterix;
            assert!(asterix.given().eq(named.iter().copied()), "{flags:?}");
            assert_eq!(asterix.asked(), !named.is_empty(), "{flags:?}");
        }
    }

    /// `seeds run` reads flags and scene and starts a gateway, which reads the scene again.
    #[test]
    fn the_process_that_is_started_does_what_its_launcher_was_told() {
        let scene = "asterix = [{ to = \"239.9.1.1:8600\" }]\nasterix_in = [{ listen = \"239.9.1.2:8601\" }]\n\
            send = [\"tracks\"]\ncategories = [62]\ntime = \"wall\"\nhttp = \"127.0.0.1:5\"\n\
            adsb = { beast = \"127.0.0.1:6\", sbs = \"127.0.0.1:7\", from = \"reports\" }\npublic = \"tcp/127.0.0.1:8\"";
        let flags: [&[&str]; 12] = [
            &[],
            &["--asterix-time", "scene"],
            &["--asterix-time", "wall"],
            &["--adsb-from", "truth"],
            &["--adsb-from", "reports"],
            &["--asterix", "10.0.0.1:1,10.0.0.2:1", "--asterix-in", "127.0.0.1:1"],
            &["--asterix-send", "sensors,status", "--asterix-cat", "10,62"],
            &["--asterix-from", "10.0.0.8", "--asterix-reference", "-47,8.5,3"],
            &["--beast", "127.0.0.1:1", "--sbs", "127.0.0.1:2", "--http", "127.0.0.1:3"],
            &["--public=tcp/127.0.0.1:4", "--public-read-only"],
            &["--no-public"],
            &["--asterix-time", "scene", "--adsb-from", "truth", "--adsb-invent"],
        ];
        for (flags, scene) in flags.into_iter().flat_map(|f| [(f, ""), (f, scene)]) {
            let Line { asterix, network } = line(flags);
            let scene = external(scene);
            let launcher = asterix.over(&scene);
            let words = launcher.arguments();
            let started = line(&words.iter().map(String::as_str).collect::<Vec<_>>()).asterix;
            assert_eq!(
                told(&started.over(&scene), &network),
                told(&launcher, &network),
                "{words:?}"
            );
        }
    }

    #[test]
    fn names_of_hosts_and_places_are_read() {
        let local = host_and_port("localhost:5000").expect("this host");
        assert!(local.ip().is_loopback() && local.port() == 5000, "{local}");
        assert_eq!(host_and_port("10.0.0.7:5"), Ok(SocketAddr::from(([10, 0, 0, 7], 5))));
        for wrong in ["", "localhost", "localhost:x", "no.such.host.invalid:5"] {
            assert!(host_and_port(wrong).expect_err(wrong).contains("HOST:PORT"), "{wrong}");
        }
        assert_eq!(reference("-47.5, 8.5"), Ok(Reference([-47.5, 8.5, 0.0])));
        assert_eq!(reference("47.5,8.5,432"), Ok(Reference([47.5, 8.5, 432.0])));
        for wrong in ["", "47", "91,0", "0,181", "0,0,9001", "a,b", "nan,0", "1,2,3,4"] {
            assert!(reference(wrong).is_err(), "{wrong}");
        }
    }
}
