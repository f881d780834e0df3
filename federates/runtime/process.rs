//! This process: what it uses, what it is called, how it ends with its launcher.

use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

/// Processor and memory use.
#[derive(Clone, Copy, Debug, Default)]
pub struct Usage {
    /// Processor seconds since the start of the process.
    pub cpu_s: f64,
    /// Share of one core since the last sample, %.
    pub cpu_pct: f64,
    /// Resident memory, bytes.
    pub rss_bytes: u64,
    /// Share of all processors of this host since the last sample, by whoever uses them, %.
    pub host_busy_pct: f64,
    /// Processors of this host; 0 where the system does not tell.
    pub host_cores: u32,
    last: Option<(u64, f64)>,
    host_last: Option<HostTimes>,
}

/// What the processors of a host have done since it was started, ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct HostTimes {
    busy: u64,
    all: u64,
    cores: u32,
}

impl HostTimes {
    /// Of the text of `/proc/stat`: user, nice, system, idle, iowait, irq, softirq, steal.
    fn of(text: &str) -> Option<Self> {
        let ticks = text.lines().next()?.strip_prefix("cpu ")?;
        let ticks: Vec<u64> =
            ticks.split_whitespace().take(8).map_while(|t| t.parse().ok()).collect();
        let all: u64 = ticks.iter().sum();
        let idle = ticks.get(3)? + ticks.get(4).unwrap_or(&0);
        let is_core = |line: &&str| line.starts_with("cpu") && !line.starts_with("cpu ");
        let cores = u32::try_from(text.lines().filter(is_core).count()).ok()?;
        Some(Self { busy: all.saturating_sub(idle), all, cores })
    }
}

impl Usage {
    /// Reads what the kernel knows; `now` is a monotonic clock in ns.
    pub fn sample(&mut self, now: u64) {
        use nix::sys::resource::{UsageWho, getrusage};
        use nix::sys::time::TimeValLike;
        if let Ok(usage) = getrusage(UsageWho::RUSAGE_SELF) {
            let us = usage.user_time().num_microseconds() + usage.system_time().num_microseconds();
            self.cpu_s = us as f64 * 1e-6;
        }
        if let Some((at, cpu_s)) = self.last
            && now > at
        {
            self.cpu_pct = (self.cpu_s - cpu_s) / ((now - at) as f64 * 1e-9) * 100.0;
        }
        self.last = Some((now, self.cpu_s));
        // Second field of statm: resident pages.
        self.rss_bytes = std::fs::read_to_string("/proc/self/statm")
            .ok()
            .and_then(|text| text.split_whitespace().nth(1)?.parse::<u64>().ok())
            .unwrap_or(0)
            * 4096;
        let host = std::fs::read_to_string("/proc/stat").ok();
        if let Some(host) = host.and_then(|text| HostTimes::of(&text)) {
            if let Some(last) = self.host_last
                && host.all > last.all
            {
                let busy = host.busy.saturating_sub(last.busy) as f64;
                self.host_busy_pct = busy / (host.all - last.all) as f64 * 100.0;
                self.host_cores = host.cores;
            }
            self.host_last = Some(host);
        }
    }
}

/// Name of this host, for messages to people.
#[must_use]
pub fn host_name() -> String {
    std::fs::read_to_string("/proc/sys/kernel/hostname")
        .map(|name| name.trim().to_owned())
        .unwrap_or_else(|_| "unknown host".to_owned())
}

/// A number that nobody else draws.
#[must_use]
pub fn random_id() -> u128 {
    use std::io::Read as _;
    let mut octets = [0; 16];
    let drawn = std::fs::File::open("/dev/urandom").and_then(|mut f| f.read_exact(&mut octets));
    if drawn.is_err() {
        let now = super::clock::utc_ns() as u128;
        return now << 32 | u128::from(std::process::id());
    }
    u128::from_le_bytes(octets)
}

/// Whether somebody has stopped the process `pid` (SIGSTOP). False where the system does not tell.
#[must_use]
pub fn is_stopped(pid: u32) -> bool {
    stat(pid).is_some_and(|fields| fields.first().is_some_and(|state| state == "T"))
}

/// What the process `pid` has done since its start, as a number that grows while it computes or writes.
#[must_use]
pub fn work_of(pid: u32) -> u64 {
    let number = |text: &str| text.parse::<u64>().unwrap_or(0);
    // Fields 14 and 15 of stat, counted from the state as the third: ticks in user and system mode.
    let ticks = stat(pid).map_or(0, |f| {
        f.iter().skip(11).take(2).map(|text| number(text)).fold(0, u64::wrapping_add)
    });
    let io = std::fs::read_to_string(format!("/proc/{pid}/io")).unwrap_or_default();
    let written = io.lines().find_map(|line| line.strip_prefix("wchar: ")).map_or(0, number);
    ticks.wrapping_add(written)
}

/// The fields of `/proc/PID/stat` from the state on; the name before it may hold anything.
fn stat(pid: u32) -> Option<Vec<String>> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let (_, fields) = text.rsplit_once(") ")?;
    Some(fields.split_whitespace().map(str::to_owned).collect())
}

/// Files that a federate may need at once: sockets of both planes, a page with its browsers, a database.
const FILES: u64 = 1024;
/// Below this not even a federate without a page starts.
const FILES_NEEDED: u64 = 64;

/// Makes sure that this process may open the files that a federate needs.
///
/// # Errors
/// If the system allows too few: how many, and what to do.
pub fn enough_files() -> Result<(), String> {
    use nix::sys::resource::{Resource, getrlimit, setrlimit};
    let Ok((soft, hard)) = getrlimit(Resource::RLIMIT_NOFILE) else { return Ok(()) };
    if soft < FILES {
        let _ = setrlimit(Resource::RLIMIT_NOFILE, hard.min(FILES), hard);
    }
    let allowed = getrlimit(Resource::RLIMIT_NOFILE).map_or(soft, |limits| limits.0);
    if allowed >= FILES_NEEDED {
        return Ok(());
    }
    Err(format!(
        "this process may open {allowed} files only; it needs {FILES_NEEDED}, with a page {FILES}: raise the limit first (ulimit -n {FILES})"
    ))
}

/// Environment variable that a launcher sets, to its process identifier, for the processes that it starts.
pub const LAUNCHED: &str = "SEEDS_LAUNCHED";

/// What a launcher tells the administration station on its standard input.
pub const NO_LOGGER: &str = "no viewer-logger";

/// What a launched viewer-logger says when it has made its files and joined.
pub const LOGGING: &str = "logging";

/// What it says before that, where it keeps a database: this word and the folder or file.
pub const KEPT: &str = "kept";

/// The begin of a line of the administration station to its launcher: which phase was reached.
pub const REACHED: &str = "phase";

/// The host, as far as it says: processor, cores, system.
#[must_use]
pub fn machine() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|l| l.strip_prefix("model name")?.split_once(':'));
    let model = model.map_or("processor not named", |m| m.1.trim());
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    format!("{model}, {cores} cores, {} {}", std::env::consts::OS, std::env::consts::ARCH)
}

/// Variable by which a launcher tells its children the command line that a person typed, for reports.
pub const COMMAND_LINE: &str = "SEEDS_COMMAND_LINE";

/// The command line of this process.
#[must_use]
pub fn command_line() -> String {
    let words = std::env::args_os().map(|a| a.to_string_lossy().into_owned());
    words.collect::<Vec<_>>().join(" ")
}

/// Whether a launcher of this host started this process and watches it.
#[must_use]
pub fn launched() -> bool {
    std::env::var_os(LAUNCHED).is_some()
}

/// A federate that a launcher started ends when the launcher dies, however it dies and however early.
pub fn end_with_launcher() {
    let Some(launcher) = std::env::var_os(LAUNCHED) else { return };
    let _ = nix::sys::prctl::set_pdeathsig(nix::sys::signal::Signal::SIGTERM);
    // It may have died before the kernel was asked to tell.
    if launcher != *nix::unistd::getppid().to_string() {
        let _ = nix::sys::signal::raise(nix::sys::signal::Signal::SIGTERM);
    }
}

/// Variable by which the engine is told which of its tasks share threads; it reads it once, at its first use.
const ENGINE_THREADS: &str = "ZENOH_RUNTIME";

/// All tasks of the engine on one thread.
const ONE_THREAD: &str = "(app: (worker_threads: 1), rx: (handover: app), tx: (handover: app), acc: (handover: app), net: (handover: app))";

/// Sees to it that the engine reads and writes its TLS connections on one thread, where this process has certificates.
///
/// `zenoh-link-tls` 1.10.2 hands one connection to a task that reads and one that writes, without a lock between them: on two
/// threads a process ends by a segmentation fault now and then. Its threads can be set by the environment only, and a process may not
/// change its own safely: it begins again, with the same number, command line and files, before it has done anything.
pub fn one_thread_for_tls() {
    use std::os::unix::process::CommandExt as _;
    let mut words = std::env::args_os();
    // `seeds certs check DIR --live` has them too.
    let certs =
        |word: &std::ffi::OsStr| word == "certs" || word.to_string_lossy().starts_with("--certs");
    let name = words.next().unwrap_or_default();
    let words: Vec<_> = words.collect();
    if std::env::var_os(ENGINE_THREADS).is_some() || !words.iter().any(|w| certs(w)) {
        return;
    }
    let Ok(executable) = std::env::current_exe() else { return };
    let again = std::process::Command::new(executable)
        .arg0(name)
        .args(words)
        .env(ENGINE_THREADS, ONE_THREAD)
        .exec();
    // It comes back only where that could not be done.
    tracing::warn!("the threads of the engine could not be set: {again}");
}

/// Somebody asked this process to end.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);
/// This process waits for a station and has nothing yet that could be lost.
static CONNECTING: AtomicBool = AtomicBool::new(false);

/// Calls `stop` when somebody interrupts or terminates this process; while it connects, it just ends.
///
/// # Errors
/// If the system refuses the handler.
pub fn on_interrupt(stop: impl Fn() + Send + 'static) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(move || {
        INTERRUPTED.store(true, SeqCst);
        if CONNECTING.load(SeqCst) {
            std::process::exit(0);
        }
        stop();
    })
}

/// Calls `leave` when somebody terminates this process (SIGTERM), which then is no interrupt. To be called before any other thread
/// is started: they inherit that the signal is not theirs.
///
/// # Errors
/// If the system refuses.
pub fn on_termination(leave: impl Fn() + Send + 'static) -> nix::Result<()> {
    use nix::sys::signal::{SigSet, Signal};
    let mut signals = SigSet::empty();
    signals.add(Signal::SIGTERM);
    signals.thread_block()?;
    std::thread::spawn(move || {
        while signals.wait().is_ok() {
            leave();
        }
    });
    Ok(())
}

/// Connects by `connect`, which may wait for minutes and looks at nothing else: an interrupt ends the process.
pub fn while_connecting<T>(connect: impl FnOnce() -> T) -> T {
    CONNECTING.store(true, SeqCst);
    if INTERRUPTED.load(SeqCst) {
        std::process::exit(0);
    }
    let connected = connect();
    CONNECTING.store(false, SeqCst);
    connected
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_host_is_busy_by_what_its_processors_did_and_not_by_waiting() {
        let told = "cpu  100 20 30 800 40 5 5 0 7 7\ncpu0 50 10 15 400 20 2 3 0 0 0\ncpu1 50 10 15 400 20 3 2 0 0 0\nintr 5\n";
        assert_eq!(HostTimes::of(told), Some(HostTimes { busy: 160, all: 1000, cores: 2 }));
        for none in ["", "cpu0 1 2 3 4", "cpu 1 2", "what"] {
            assert_eq!(HostTimes::of(none), None, "{none}");
        }
        let mut usage = Usage::default();
        usage.sample(1);
        assert_eq!(usage.host_cores, 0, "one look is no measure");
    }

    #[test]
    fn a_stopped_process_is_seen_and_one_that_works_makes_progress() {
        let mut child = std::process::Command::new("sleep").arg("60").spawn().expect("it starts");
        let pid = child.id();
        let signal = |s| nix::sys::signal::kill(nix::unistd::Pid::from_raw(pid as i32), s);
        let becomes = |stopped| {
            (0..1000).any(|_| {
                std::thread::sleep(std::time::Duration::from_millis(5));
                is_stopped(pid) == stopped
            })
        };
        assert!(!is_stopped(pid));
        signal(nix::sys::signal::Signal::SIGSTOP).expect("stopped");
        assert!(becomes(true));
        signal(nix::sys::signal::Signal::SIGCONT).expect("continued");
        assert!(becomes(false));
        child.kill().expect("killed");
        child.wait().expect("ended");
        assert!(!is_stopped(pid) && work_of(pid) == 0, "one that is gone");
        let own = std::process::id();
        let before = work_of(own);
        std::fs::write("/dev/null", [0; 4096]).expect("written");
        assert!(work_of(own) > before);
    }
}
