//! This process: what it uses, what it is called, how it ends with its launcher.

/// Processor and memory use.
#[derive(Clone, Copy, Debug, Default)]
pub struct Usage {
    /// Processor seconds since the start of the process.
    pub cpu_s: f64,
    /// Share of one core since the last sample, %.
    pub cpu_pct: f64,
    /// Resident memory, bytes.
    pub rss_bytes: u64,
    last: Option<(u64, f64)>,
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
    }
}

/// Name of this host, for messages to people.
#[must_use]
pub fn host_name() -> String {
    std::fs::read_to_string("/proc/sys/kernel/hostname")
        .map(|name| name.trim().to_owned())
        .unwrap_or_else(|_| "unknown host".to_owned())
}

/// Environment variable that a launcher sets, to its process identifier, for the processes that it starts.
pub const LAUNCHED: &str = "SEEDS_LAUNCHED";

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
