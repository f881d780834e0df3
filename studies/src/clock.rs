//! Time that this thread has computed. On a busy machine it is what an update costs; the wall clock
//! would also show who else was running.

use nix::time::{ClockId, clock_gettime};

/// Processor time of this thread, ns; 0 where the system does not tell.
pub(crate) fn thread_ns() -> i64 {
    clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID)
        .map_or(0, |t| t.tv_sec() * 1_000_000_000 + t.tv_nsec())
}
