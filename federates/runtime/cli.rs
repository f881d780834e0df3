//! What every executable takes on its command line, logging, exit codes.

use super::certs::Certs;
use clap::{Args, ValueEnum};
use scenarios::losses::{
    ByMember, Losses, OnLoss, ReturnWithin, on_loss_flag, return_flag, stall_flag, step_flag,
};
use scenarios::network::AddressRange;
use std::ffi::OsString;
use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// Default address of the page.
pub const DEFAULT_PAGE: &str = "127.0.0.1:8600";

/// Shown at the end of every `--help`.
pub const EXIT_CODES: &str =
    "Exit codes: 0 complete, 1 failed, 2 bad arguments or scene, 3 complete but data lost.";

/// The run went well.
pub const COMPLETE: u8 = 0;
/// The run failed.
pub const FAILED: u8 = 1;
/// The command line or the scene is wrong.
pub const BAD_INPUT: u8 = 2;
/// The run went well, but a recording or log misses data.
pub const DATA_LOST: u8 = 3;

/// Default endpoint of the administration station.
pub const DEFAULT_ENDPOINT: &str = "tcp/127.0.0.1:7447";

/// The scene that is played when none is named.
pub const DEFAULT_SCENE: &str = "zurich";

/// Arguments of every federate.
#[derive(Args, Clone, Debug)]
pub struct CommonArgs {
    /// Scene: a TOML file, or the name of a scene that comes with SEEDS
    #[arg(long, value_name = "FILE", default_value = DEFAULT_SCENE)]
    pub scene: String,

    /// DIS exercise identifier, 0 to 255; separates federations on one network [default: the scene's]
    #[arg(long, value_name = "N")]
    pub exercise: Option<u8>,

    #[command(flatten)]
    pub(crate) network: NetworkArgs,

    /// Share of truth datagrams that this receiver drops on purpose, 0 to below 1 (they are repaired by request)
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = share)]
    pub inject_loss: f64,

    /// Log lines on stderr: text for people, json for programs
    #[arg(long, value_enum, default_value_t = LogFormat::Text)]
    pub log_format: LogFormat,
}

/// Where DIS and the synchronisation plane are.
#[derive(Args, Clone, Debug, Default)]
pub struct NetworkArgs {
    /// Where DIS goes: multicast group, broadcast address, or a comma-separated list of hosts [default: the scene's, else 127.255.255.255:3000, which cannot leave this host]
    #[arg(long, value_name = "ADDR:PORT")]
    pub dis: Option<String>,

    /// Address of the network interface for DIS [default: chosen by the system; loopback for 127.x]
    #[arg(long, value_name = "IP")]
    pub interface: Option<IpAddr>,

    /// Time to live of DIS datagrams: routers that they may pass, plus one; 0 keeps multicast on this host [default: the scene's, else 1]
    #[arg(long, value_name = "N")]
    pub ttl: Option<u8>,

    /// Take DIS of these senders only, and of this host: addresses, or networks like 10.0.0.0/24, with commas between [default: the scene's, else everybody's]
    #[arg(long, value_name = "IP[/N]", value_delimiter = ',')]
    pub dis_from: Vec<AddressRange>,

    /// Take entities of these DIS sites only, and of the scene's own, with commas between [default: the scene's, else all]
    #[arg(long, value_name = "N", value_delimiter = ',')]
    pub dis_sites: Vec<u16>,

    /// Obey simulation management of these hosts beside this one: addresses, or networks, with commas between [default: the scene's, else none]
    #[arg(long, value_name = "IP[/N]", value_delimiter = ',')]
    pub dis_managers: Vec<AddressRange>,

    /// Endpoint of the synchronisation plane to listen on, like tcp/10.0.0.1:7447 [default: administration station tcp/127.0.0.1:7447, others any free port]
    #[arg(long, value_name = "ENDPOINT", value_parser = endpoint)]
    pub sync_listen: Option<String>,

    /// Endpoint of the administration station to connect to [default: tcp/127.0.0.1:7447]
    #[arg(long, value_name = "ENDPOINT", value_parser = endpoint_of_another)]
    pub sync_connect: Option<String>,

    /// Endpoint of a `seeds router` through which all federates of the run speak, where hosts cannot reach each other
    #[arg(long, value_name = "ENDPOINT", value_parser = endpoint_of_another, conflicts_with_all = ["sync_listen", "sync_connect"])]
    pub sync_router: Option<String>,

    /// Folder with the certificates of the federation, made by `seeds certs`; endpoints are tls/ADDRESS:PORT then
    #[arg(long, value_name = "DIR")]
    pub certs: Option<PathBuf>,

    /// Listen beyond this host without certificates: everybody who reaches the endpoint can command the run
    #[arg(long, conflicts_with = "certs")]
    pub open: bool,
}

/// When a federate is given up, and what becomes of the run then
#[derive(Args, Clone, Debug, Default)]
pub struct LossArgs {
    /// A federate of which nothing is heard for MS is lost: for all, or by name as 2000,smdfm=5000 [default: the scene's, else 2000]
    #[arg(long, value_name = "MS", value_parser = stall_flag)]
    stall_ms: Option<ByMember<u64>>,

    /// A federate that is heard of but stays at one frame for MS is lost, as --stall-ms [default: the scene's, else 60000]
    #[arg(long, value_name = "MS", value_parser = step_flag)]
    step_ms: Option<ByMember<u64>>,

    /// What becomes of a run that loses a federate, for all or by name as takeover,smdfm=abort: freeze (time stands until it is back), takeover (another process takes its place), degrade (it goes on without), abort [default: the scene's, else freeze]
    #[arg(long, value_name = "WORD", value_parser = on_loss_flag)]
    on_loss: Option<ByMember<OnLoss>>,

    /// How long a run waits for a lost federate: MS, or none for no end [default: the scene's, else none; of a run that ends by itself 0, with takeover 10000]
    #[arg(long, value_name = "MS", value_parser = return_flag)]
    return_ms: Option<ReturnWithin>,

    /// Let places of generators and of the external world go from a host whose processors are busy to 90 % for 10 s to one that is at most
    /// 70 % busy with them, one in half a minute (as `admin-station move` does by hand); needs --on-loss takeover
    #[arg(long)]
    pub(crate) balance: bool,
}

impl LossArgs {
    /// As the conductor takes them.
    #[must_use]
    pub fn losses(&self) -> Losses {
        Losses {
            stall_ms: self.stall_ms.clone().unwrap_or_default(),
            step_ms: self.step_ms.clone().unwrap_or_default(),
            on_loss: self.on_loss.clone().unwrap_or_default(),
            return_ms: self.return_ms,
        }
    }

    /// Whether --balance can do anything, with what becomes of losses in this run.
    ///
    /// # Errors
    /// What is missing.
    pub(crate) fn check_balance(&self, losses: &Losses) -> Result<(), String> {
        let taken = |name| losses.on_loss.of(name) == Some(OnLoss::TakeOver);
        if self.balance && !taken("traffic-generator") && !taken("external-world") {
            return Err("--balance moves places of federates to other processes, which takes --on-loss takeover: add it, or leave out --balance".to_owned());
        }
        Ok(())
    }

    /// The same as a command line.
    #[must_use]
    pub fn arguments(&self) -> Vec<String> {
        let flags = [
            ("--stall-ms", self.stall_ms.as_ref().map(ToString::to_string)),
            ("--step-ms", self.step_ms.as_ref().map(ToString::to_string)),
            ("--on-loss", self.on_loss.as_ref().map(ToString::to_string)),
            ("--return-ms", self.return_ms.map(|within| within.to_string())),
        ];
        let given = flags.into_iter().filter_map(|(flag, value)| Some([flag.to_owned(), value?]));
        given.flatten().chain(self.balance.then(|| "--balance".to_owned())).collect()
    }

    /// A flag that was given.
    #[must_use]
    pub fn given(&self) -> Option<&'static str> {
        [
            (self.stall_ms.is_some(), "--stall-ms"),
            (self.step_ms.is_some(), "--step-ms"),
            (self.on_loss.is_some(), "--on-loss"),
            (self.return_ms.is_some(), "--return-ms"),
            (self.balance, "--balance"),
        ]
        .into_iter()
        .find_map(|(given, flag)| given.then_some(flag))
    }
}

impl NetworkArgs {
    /// The default endpoint of an administration station.
    #[must_use]
    pub fn default_endpoint(&self) -> String {
        default_endpoint(self.certs.is_some())
    }

    /// The files that prove that this process is federate `name`; none where nothing is to be proved.
    ///
    /// # Errors
    /// If one of them is not there.
    pub fn certs_of(&self, name: &str) -> anyhow::Result<Option<Certs>> {
        let certs = self.certs.as_deref().map(|folder| Certs::of(folder, name));
        certs.transpose().map_err(|e| anyhow::anyhow!(e))
    }

    /// Checks endpoints that this process is to listen on.
    ///
    /// # Errors
    /// If one does not fit the certificates, or could be reached by everybody and that was not said.
    pub fn check_listening(&self, endpoint: &str) -> anyhow::Result<()> {
        let checked = super::certs::allowed(endpoint, self.certs.is_some(), self.open);
        checked.map_err(|e| anyhow::anyhow!(e))
    }

    /// Checks an endpoint that this process is to connect to.
    ///
    /// # Errors
    /// If it does not fit the certificates.
    pub fn check_connecting(&self, endpoint: &str) -> anyhow::Result<()> {
        let checked = super::certs::allowed(endpoint, self.certs.is_some(), true);
        checked.map_err(|e| anyhow::anyhow!(e))
    }
}

/// The default endpoint of an administration station, with certificates or without.
#[must_use]
pub fn default_endpoint(certs: bool) -> String {
    if certs { DEFAULT_ENDPOINT.replacen("tcp/", "tls/", 1) } else { DEFAULT_ENDPOINT.to_owned() }
}

/// How log lines look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// One readable line an event.
    #[default]
    Text,
    /// One JSON object an event.
    Json,
}

impl LogFormat {
    /// The word on the command line.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Text => "text",
            Self::Json => "json",
        }
    }
}

/// A share of what there is, as `--inject-loss` takes it.
///
/// # Errors
/// If it is not from 0 to below 1.
pub fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..1.0).contains(&value) => Ok(value),
        _ => Err(format!("'{text}' is not a share from 0 to below 1")),
    }
}

/// The command line of this process. `--rate -1` is a value that the flag refuses, not an unknown flag `-1`.
#[must_use]
pub fn parse<P: clap::Parser>() -> P {
    let line = with_endpoints(std::env::args_os());
    let matches = with_negative_numbers(P::command()).get_matches_from(line);
    super::process::one_thread_for_tls();
    P::from_arg_matches(&matches).unwrap_or_else(|e| e.format(&mut P::command()).exit())
}

/// `--public ENDPOINT` as `--public=ENDPOINT`: the flag goes without a value too, so that what stands behind it is its value only
/// where it is an endpoint (`tcp/127.0.0.1:7448`) and no scene.
fn with_endpoints(line: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let is_endpoint = |word: &OsString| {
        let parts = word.to_str().and_then(|text| text.split_once('/'));
        parts.is_some_and(|(transport, place)| {
            let port = place.rsplit_once(':').map_or("", |(_, port)| port);
            let word = transport.bytes().all(|b| b.is_ascii_lowercase()) && !transport.is_empty();
            word && port.parse::<u16>().is_ok()
        })
    };
    let mut joined: Vec<OsString> = Vec::new();
    for word in line {
        match joined.last_mut() {
            Some(flag) if *flag == "--public" && is_endpoint(&word) => {
                flag.push("=");
                flag.push(word);
            }
            _ => joined.push(word),
        }
    }
    joined
}

fn with_negative_numbers(command: clap::Command) -> clap::Command {
    command
        .mut_args(|arg| {
            let valued = !arg.is_positional() && arg.get_action().takes_values();
            if valued { arg.allow_negative_numbers(true) } else { arg }
        })
        .mut_subcommands(with_negative_numbers)
}

/// A factor of real time. Slower than a thousandth, a frame would take minutes and nobody could tell the run from a hung one.
///
/// # Errors
/// If it is not from 0.001 to 1000.
pub fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.001..=1000.0).contains(&value) => Ok(value),
        _ => Err(format!("'{text}' is not a rate from 0.001 to 1000")),
    }
}

/// An endpoint of the synchronisation plane: `tcp/ADDRESS:PORT` or `tls/ADDRESS:PORT`.
///
/// # Errors
/// If it has no transport, address or port.
pub fn endpoint(text: &str) -> Result<String, String> {
    if let Some(("udp" | "quic" | "ws", _)) = text.split_once('/') {
        return Err(format!(
            "'{text}': the synchronisation plane goes over tcp/ADDRESS:PORT or tls/ADDRESS:PORT only"
        ));
    }
    let place = text.split_once('/').filter(|(transport, _)| TRANSPORTS.contains(transport));
    let sound = place.is_some_and(|(_, place)| {
        place.rsplit_once(':').is_some_and(|(host, port)| {
            !host.is_empty() && !host.contains(char::is_whitespace) && port.parse::<u16>().is_ok()
        })
    });
    if sound {
        return Ok(text.to_owned());
    }
    Err(format!(
        "'{text}' is not an endpoint like tcp/127.0.0.1:7447 or tls/10.0.0.1:7447 (TRANSPORT/ADDRESS:PORT)"
    ))
}

/// An endpoint that can be connected to.
///
/// # Errors
/// If it is none, or its port is 0.
pub fn endpoint_of_another(text: &str) -> Result<String, String> {
    let endpoint = endpoint(text)?;
    if endpoint.ends_with(":0") {
        return Err(format!("port 0 cannot be connected to: '{text}'"));
    }
    Ok(endpoint)
}

/// What may stand before the slash of an endpoint.
const TRANSPORTS: [&str; 2] = ["tcp", "tls"];

/// The address of a page: `ADDRESS:PORT`, or `localhost:PORT`.
///
/// # Errors
/// If it is neither.
pub fn page(text: &str) -> Result<SocketAddr, String> {
    let numeric = match text.rsplit_once(':') {
        Some((name, port)) if name.eq_ignore_ascii_case("localhost") => format!("127.0.0.1:{port}"),
        _ => text.to_owned(),
    };
    numeric.parse().map_err(|_| {
        format!("'{text}' is not ADDRESS:PORT like 127.0.0.1:8600, [::1]:8600 or localhost:8600")
    })
}

/// The seed of a run.
///
/// # Errors
/// If it is not a whole number from 0 to 2⁶⁴ − 1.
pub fn seed(text: &str) -> Result<u64, String> {
    text.parse()
        .map_err(|_| format!("'{text}' is not a seed: a whole number from 0 to {}", u64::MAX))
}

/// Where a report goes: a folder, there already or yet to be made.
///
/// # Errors
/// If something else stands there.
pub fn report_folder(text: &str) -> Result<PathBuf, String> {
    let folder = PathBuf::from(text);
    match std::fs::metadata(&folder) {
        Ok(there) if !there.is_dir() => {
            Err(format!("'{text}' is a file: a report needs a folder of its own"))
        }
        _ => Ok(folder),
    }
}

/// A duration in seconds.
///
/// # Errors
/// If it is not above 0 and at most a day.
pub fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 86_400.0 => Ok(value),
        _ => Err(format!("'{text}' is not a duration above 0 and up to 86400 seconds")),
    }
}

/// A time of a run in seconds: 0 is one.
///
/// # Errors
/// If it is not 0 to a day.
pub fn time(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..=86_400.0).contains(&value) => Ok(value + 0.0),
        _ => Err(format!("'{text}' is not a time from 0 to 86400 seconds")),
    }
}

/// Log lines to stderr, at `level` ("info") unless `RUST_LOG` says otherwise.
pub fn log_to_stderr(format: LogFormat, level: &str) {
    use tracing_subscriber::{EnvFilter, fmt};
    // What the synchronisation library logs names its own insides, and can be provoked by anybody who
    // connects; what goes wrong there for the run is said by the runtime.
    let ours = format!("{level},zenoh=off");
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(ours));
    let builder = fmt().with_env_filter(filter).with_writer(std::io::stderr).with_target(false);
    // A second call (tests, one process for all) leaves the first in place.
    let _ = match format {
        LogFormat::Text => builder.compact().with_ansi(false).try_init(),
        LogFormat::Json => builder.json().try_init(),
    };
}

/// Whether `file` can be written, before the work that it is to hold is done. Leaves nothing behind.
///
/// # Errors
/// What the system says, with the file.
pub fn writable(file: &Path) -> anyhow::Result<()> {
    use anyhow::Context;
    let there = file.exists();
    std::fs::OpenOptions::new()
        .append(true)
        .create(true)
        .open(file)
        .with_context(|| format!("writing {}", file.display()))?;
    if !there {
        let _ = std::fs::remove_file(file);
    }
    Ok(())
}

/// Writes a file: whole, or not at all; what was there before stays until then. A device or a pipe is
/// written to, never replaced.
///
/// # Errors
/// What the system says, with the file.
pub fn save(file: &Path, octets: impl AsRef<[u8]>) -> anyhow::Result<()> {
    use anyhow::Context;
    let doing = || format!("writing {}", file.display());
    let place = std::fs::canonicalize(file).unwrap_or_else(|_| file.to_path_buf());
    if std::fs::metadata(&place).is_ok_and(|m| !m.is_file()) {
        return std::fs::write(&place, octets).with_context(doing);
    }
    let mut part = place.clone().into_os_string();
    part.push(".part");
    let part = PathBuf::from(part);
    let written = std::fs::write(&part, octets).and_then(|()| std::fs::rename(&part, &place));
    if written.is_err() {
        let _ = std::fs::remove_file(&part);
    }
    written.with_context(doing)
}

/// Prints one line for a person and gives the exit code.
#[expect(clippy::print_stderr, reason = "the last word of an executable, whatever the log filter")]
pub fn fail(code: u8, error: impl std::fmt::Display) -> ExitCode {
    eprintln!("error: {error}");
    ExitCode::from(code)
}

/// Loads the scene that a user named.
///
/// # Errors
/// The exit code, after the error was printed.
pub fn load_scene(typed: &str) -> Result<scenarios::Scene, ExitCode> {
    let path: PathBuf = scenarios::locate(typed);
    let scene = scenarios::load(&path).map_err(|e| fail(BAD_INPUT, e))?;
    warn_of(&scene);
    Ok(scene)
}

/// Shows what a scene says to no effect; only who plays or plans it says so, not every federate again.
fn warn_of(scene: &scenarios::Scene) {
    scene.warnings.iter().for_each(|warning| warn(warning));
}

/// Says on stderr what is not as whoever asks may think.
#[expect(clippy::print_stderr, reason = "a warning for the author of the scene")]
pub fn warn(text: &dyn std::fmt::Display) {
    eprintln!("warning: {text}");
}

/// [`load_scene`] with the movements of one share of the traffic only.
///
/// # Errors
/// As [`load_scene`].
pub fn load_scene_share(typed: &str, share: u32, of: u32) -> Result<scenarios::Scene, ExitCode> {
    let path: PathBuf = scenarios::locate(typed);
    scenarios::load_share(&path, share, of).map_err(|e| fail(BAD_INPUT, e))
}

/// [`load_scene`] for those that do not play the truth: no movement is made of recordings and routes.
///
/// # Errors
/// As [`load_scene`].
pub fn load_scene_without_truth(typed: &str) -> Result<scenarios::Scene, ExitCode> {
    let path: PathBuf = scenarios::locate(typed);
    scenarios::load_without_truth(&path).map_err(|e| fail(BAD_INPUT, e))
}

/// Whether a line of results was lost, because standard output took no more.
static RESULTS_LOST: AtomicBool = AtomicBool::new(false);

/// Writes a line of results. A reader who has seen enough (`| head`) is no fault; a full disk is one.
pub fn print_result(text: std::fmt::Arguments<'_>) {
    use std::io::Write as _;
    let written = writeln!(std::io::stdout(), "{text}");
    if written.is_err_and(|e| e.kind() != std::io::ErrorKind::BrokenPipe) {
        RESULTS_LOST.store(true, Ordering::Relaxed);
    }
}

/// The exit code of a process that ends with `code`, unless its results were lost.
#[must_use]
pub fn ended(code: ExitCode) -> ExitCode {
    if !RESULTS_LOST.load(Ordering::Relaxed) {
        return code;
    }
    fail(FAILED, "standard output took no more: results are missing")
}

/// A line on standard output.
pub fn print_line(line: &str) {
    print_result(format_args!("{line}"));
}

/// A line on standard output, as `println!`, that may fail.
macro_rules! out {
    () => { $crate::runtime::cli::print_result(format_args!("")) };
    ($($text:tt)*) => { $crate::runtime::cli::print_result(format_args!($($text)*)) };
}
pub(crate) use out;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_endpoint_has_a_transport_an_address_and_a_port() {
        for sound in ["tcp/127.0.0.1:7447", "tcp/[::1]:0", "tls/host.example:7447"] {
            assert_eq!(endpoint(sound).as_deref(), Ok(sound));
        }
        let udp = endpoint("udp/127.0.0.1:7447").expect_err("not any more");
        assert!(udp.contains("tcp/ADDRESS:PORT or tls/ADDRESS:PORT only"), "{udp}");
        for wrong in
            ["", "foo", "tcp/1.2.3.4", "tcp/1.2.3.4:99999", "tcp/:1", "127.0.0.1:1", "ftp/h:1"]
        {
            assert!(endpoint(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn an_endpoint_behind_a_blank_is_the_flag_s_and_a_scene_is_not() {
        let line =
            |words: &[&str]| -> Vec<OsString> { with_endpoints(words.iter().map(OsString::from)) };
        for (words, joined) in [
            (
                &["run", "--public", "tcp/127.0.0.1:17448"][..],
                &["run", "--public=tcp/127.0.0.1:17448"][..],
            ),
            (&["--public", "tls/[::1]:7448", "zurich"], &["--public=tls/[::1]:7448", "zurich"]),
            (&["--public", "udp/1.2.3.4:5", "eham"], &["--public=udp/1.2.3.4:5", "eham"]),
            (&["--public", "zurich"], &["--public", "zurich"]),
            (&["--public", "scenes/zurich.toml"], &["--public", "scenes/zurich.toml"]),
            (&["--public", "/a/b:1"], &["--public", "/a/b:1"]),
            (&["--public=tcp/h:1", "tcp/h:2"], &["--public=tcp/h:1", "tcp/h:2"]),
            (&["--sync-listen", "tcp/h:2"], &["--sync-listen", "tcp/h:2"]),
        ] {
            assert_eq!(line(words), line(joined), "{words:?}");
            assert_eq!(line(words).len(), joined.len(), "{words:?}");
        }
    }

    #[test]
    fn a_rate_that_nobody_lives_to_see_is_refused() {
        for wrong in ["0", "-1", "1e-300", "nan", "inf", "1001", ""] {
            assert!(rate(wrong).is_err(), "{wrong}");
        }
        assert_eq!((rate("0.001"), rate("1000")), (Ok(0.001), Ok(1000.0)));
    }

    #[test]
    fn a_page_stands_at_an_address_or_at_localhost() {
        for (text, address) in [
            ("localhost:8600", "127.0.0.1:8600"),
            ("LocalHost:0", "127.0.0.1:0"),
            ("[::1]:8600", "[::1]:8600"),
            ("0.0.0.0:80", "0.0.0.0:80"),
        ] {
            assert_eq!(page(text).map(|a| a.to_string()).as_deref(), Ok(address), "{text}");
        }
        for wrong in ["", "8600", "localhost", "localhost:99999", "example.org:8600", "1.2.3.4"] {
            let said = page(wrong).expect_err(wrong);
            assert!(said.contains("localhost:8600"), "{said}");
        }
    }

    #[test]
    fn a_seed_that_is_none_is_told_what_one_is() {
        assert_eq!(seed("18446744073709551615"), Ok(u64::MAX));
        for wrong in ["-1", "1.5", "18446744073709551616", "x", ""] {
            assert!(seed(wrong).expect_err(wrong).contains("a whole number from 0 to"), "{wrong}");
        }
    }

    #[test]
    fn a_file_is_saved_whole_or_not_at_all() {
        let folder = std::env::temp_dir().join(format!("seeds-save-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let file = folder.join("report.html");
        save(&file, "before").expect("written");
        // A folder where the part would stand: nothing can be written.
        std::fs::create_dir(folder.join("report.html.part")).expect("a folder");
        assert!(save(&file, "after").is_err());
        assert_eq!(std::fs::read(&file).expect("still there"), b"before");
        std::fs::remove_dir(folder.join("report.html.part")).expect("removed");
        let link = folder.join("link.html");
        std::os::unix::fs::symlink(&file, &link).expect("a link");
        save(&link, "after").expect("written");
        assert_eq!(std::fs::read(&file).expect("there"), b"after");
        assert!(link.is_symlink(), "a link stays a link");
        save(Path::new("/dev/null"), "gone").expect("written");
        assert!(!Path::new("/dev/null").is_file(), "a device stays a device");
        std::fs::remove_dir_all(&folder).expect("cleaned up");
    }
}
