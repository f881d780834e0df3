//! Since when a station waits for members.

use crate::runtime::clock::WallNs;
use crate::runtime::life_cycle::Phase;
use std::time::Duration;

/// The present INIT of a run.
#[derive(Debug)]
pub(super) struct Awaiting {
    since: WallNs,
    /// A person was told for whom it waits.
    pub(super) said: bool,
}

impl Awaiting {
    /// From `now` on.
    pub(super) fn new(now: WallNs) -> Self {
        Self { since: now, said: false }
    }

    /// How long members are awaited; nothing where the run is beyond INIT.
    pub(super) fn waited(&mut self, now: WallNs, phase: Phase) -> Duration {
        if phase != Phase::Init {
            *self = Self::new(now);
        }
        Duration::from_nanos(now.saturating_sub(self.since))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loss_before_the_run_is_waited_for_however_old_the_station_is() {
        const S: WallNs = 1_000_000_000;
        let mut awaiting = Awaiting::new(5 * S);
        assert_eq!(awaiting.waited(8 * S, Phase::Init), Duration::from_secs(3));
        awaiting.said = true;
        for s in 8..400 {
            assert_eq!(awaiting.waited(s * S, Phase::Configured), Duration::ZERO);
        }
        assert_eq!(awaiting.waited(402 * S, Phase::Init), Duration::from_secs(3), "INIT anew");
        assert!(!awaiting.said);
    }
}
