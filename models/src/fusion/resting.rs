//! What labels keep between the scans: lines whose track has just ended, and what it said of the list's times.

use super::identity::SIGMAS;
use crate::plot::Callsign;
use crate::time::SimTime;

/// The line of a track that ended is not given again for this long, s.
const REST_S: f64 = 10.0;

/// What the labels keep between the scans.
#[derive(Clone, Debug, Default)]
pub(super) struct Resting {
    /// When labels were first asked for.
    pub(super) began: Option<SimTime>,
    /// When odds are weighed next.
    pub(super) next: Option<SimTime>,
    pub(super) resting: Vec<(Callsign, SimTime)>,
    /// ln likelihood of each deviation of the list's times, by the events of tracks that have ended.
    pub(super) ended: [f64; SIGMAS],
}

impl Resting {
    /// What the events of a track that ended said of the list's times.
    pub(super) fn remember(&mut self, said: &[f64; SIGMAS]) {
        self.ended.iter_mut().zip(said).for_each(|(sum, l)| *sum += l);
    }

    /// A track with this line has ended.
    pub(super) fn rest(&mut self, entry: Callsign, now: SimTime) {
        self.resting.push((entry, now.plus_s(REST_S)));
    }
}
