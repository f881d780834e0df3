//! The only place where a federate reads a clock: pacing, time-outs, stamps of arrival, statistics.

use std::sync::OnceLock;
use std::time::{Instant, SystemTime};

/// Nanoseconds of wall time since any fixed point; the core only compares them.
pub type WallNs = u64;

/// Nanoseconds of a monotonic clock since this process first asked.
#[must_use]
#[expect(clippy::disallowed_methods, reason = "the one monotonic clock of the process")]
pub fn monotonic_ns() -> u64 {
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_nanos() as u64
}

/// Microseconds of the same clock.
#[must_use]
pub fn monotonic_us() -> u64 {
    monotonic_ns() / 1000
}

/// UTC, nanoseconds since 1970.
#[must_use]
#[expect(clippy::disallowed_methods, reason = "stamps of arrival and names of run folders")]
pub fn utc_ns() -> i64 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    since.as_nanos() as i64
}
