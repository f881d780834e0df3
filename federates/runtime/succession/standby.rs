//! The standby's end: when it asks to lead.

use super::{Candidate, Led, PAUSED_NS, Question, SILENT_NS, Voted, Wants};
use crate::runtime::clock::WallNs;

/// After it was told that the station is heard elsewhere it asks again so much later, ns.
const REST_NS: WallNs = 500_000_000;

/// A standby that follows the journal of a station.
#[derive(Clone, Debug)]
pub struct Standby {
    candidate: Candidate,
    led: Led,
    heard_at: WallNs,
    connected: bool,
    rest_until: WallNs,
    said: bool,
}

impl Standby {
    /// One that holds a journal which ends with `led`.
    #[must_use]
    pub fn new(now: WallNs, candidate: Candidate, led: Led) -> Self {
        let connected = true;
        Self { candidate, led, heard_at: now, connected, rest_until: 0, said: false }
    }

    /// What the journal says of who may lead.
    pub fn led(&mut self, led: Led) {
        self.led = led;
    }

    /// Whether the station says nothing without it.
    #[must_use]
    pub fn is_in(&self) -> bool {
        self.led.standby
    }

    /// The station was heard: nobody else is asked.
    pub fn heard(&mut self, now: WallNs) {
        self.heard_at = now;
        self.candidate.withdraw(now);
    }

    /// The connection of the station is there, or gone.
    pub fn connected(&mut self, connected: bool) {
        self.connected = connected;
    }

    /// Whether it goes on reading the journal: not while it asks to lead, as it then would give its word for more.
    #[must_use]
    pub fn follows(&self) -> bool {
        !self.candidate.contends()
    }

    /// Whether nothing is heard of the station.
    #[must_use]
    pub fn misses(&self, now: WallNs) -> bool {
        let silent = now.saturating_sub(self.heard_at);
        silent >= PAUSED_NS || !self.connected && silent >= SILENT_NS
    }

    /// The questions that are due to `voters`.
    pub fn tick(&mut self, now: WallNs, voters: &[String]) -> Vec<Question> {
        if self.led.standby && self.misses(now) && now >= self.rest_until {
            self.candidate.contend(now, self.led.epoch, Wants::Lead, voters);
        }
        self.candidate.tick(now)
    }

    /// A voter answered; the epoch in which this one leads from now on, alone.
    pub fn voted(
        &mut self,
        now: WallNs,
        name: &str,
        voted: &Voted,
        inc: Option<u64>,
    ) -> Option<Led> {
        self.candidate.voted(name, voted, inc);
        if let Some(epoch) = self.candidate.win() {
            return Some(Led { epoch, standby: false });
        }
        if self.candidate.beating() || self.candidate.lost() {
            self.candidate.withdraw(now);
            self.rest_until = now + REST_NS;
        }
        None
    }

    /// How many voices it has, of how many, where it asks for them.
    #[must_use]
    pub fn standing(&self) -> Option<(usize, usize)> {
        let (here, all, _) = self.candidate.standing();
        self.candidate.contends().then_some((here, all))
    }

    /// That it stands for want of voices, once for each time: how many it has, of how many, who is silent.
    pub fn stands(&mut self) -> Option<(usize, usize, Vec<&str>)> {
        let stands = self.candidate.contends();
        let said = std::mem::replace(&mut self.said, stands);
        (stands && !said).then(|| self.candidate.standing())
    }
}
