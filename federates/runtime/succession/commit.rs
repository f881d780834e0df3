//! The station's end: what it may say, and how it goes on when its standby is silent.

use super::{Candidate, Led, Question, SILENT_NS, Voted, Wants};
use crate::runtime::clock::WallNs;

/// The standby, as the station knows it.
#[derive(Clone, Debug)]
struct Held {
    who: u64,
    /// It holds so many octets of the journal.
    octets: u64,
    heard_at: WallNs,
}

/// What a station may say: what its standby holds.
#[derive(Clone, Debug)]
pub struct Commit {
    candidate: Candidate,
    led: Led,
    /// Who reads the journal; it is in where `led` says so.
    standby: Option<Held>,
    since: WallNs,
    asked_for: bool,
}

impl Commit {
    /// The end of a station with a journal that ends with `led`. Where a standby was in, it may lead by now: the
    /// voters are asked first.
    #[must_use]
    pub fn new(now: WallNs, candidate: Candidate, led: Led) -> Self {
        Self { candidate, led, standby: None, since: now, asked_for: false }
    }

    /// Who may lead, as far as this one knows.
    #[must_use]
    pub fn led(&self) -> Led {
        self.led
    }

    /// Whether what led to the journal's first `octets` octets may be acted upon.
    #[must_use]
    pub fn may_say(&self, octets: u64) -> bool {
        !self.led.standby || self.standby.as_ref().is_some_and(|s| s.octets >= octets)
    }

    /// Whether another standby than `who` reads the journal.
    #[must_use]
    pub fn has_another(&self, now: WallNs, who: u64) -> bool {
        let other = self.standby.as_ref().filter(|standby| standby.who != who);
        other.is_some_and(|s| self.led.standby || now.saturating_sub(s.heard_at) < SILENT_NS)
    }

    /// Whether one that holds so many octets cannot be the standby that is in: that held more, or at least those up to `led_at`, where
    /// the journal says that it is in.
    #[must_use]
    pub fn held_more(&self, octets: u64, led_at: u64) -> bool {
        let held = self.standby.as_ref().map_or(led_at, |standby| standby.octets);
        self.led.standby && octets < held
    }

    /// The standby says that it holds so many octets.
    pub fn holds(&mut self, now: WallNs, who: u64, octets: u64) {
        self.candidate.withdraw(now);
        self.standby = Some(Held { who, octets, heard_at: now });
    }

    /// The standby that reads the journal is in from now on: to be written to the journal.
    pub fn admit(&mut self) -> Led {
        self.led.standby = true;
        self.led
    }

    /// Nothing more is written that a standby could hold: it cannot be one any more.
    pub fn dismiss(&mut self, now: WallNs) {
        if let Some(standby) = &mut self.standby {
            (standby.octets, standby.heard_at) = (0, now.saturating_sub(SILENT_NS));
        }
    }

    /// The questions that are due to `voters`, once the standby is silent.
    pub fn tick(&mut self, now: WallNs, voters: &[String]) -> Vec<Question> {
        let heard_at = self.standby.as_ref().map_or(self.since, |standby| standby.heard_at);
        let silent = now.saturating_sub(heard_at) >= SILENT_NS;
        if self.led.standby && silent {
            self.candidate.contend(now, self.led.epoch, Wants::GoOn, voters);
        }
        self.candidate.tick(now)
    }

    /// When the next questions are due.
    #[must_use]
    pub fn deadline(&self) -> WallNs {
        let heard_at = self.standby.as_ref().map_or(self.since, |standby| standby.heard_at);
        let silent = heard_at + SILENT_NS;
        let contends = self.candidate.contends() || !self.led.standby;
        self.candidate.deadline().min(if contends { WallNs::MAX } else { silent })
    }

    /// A voter answered; `inc` is the incarnation that it has by the journal. If the voters have decided: the station leads and has no
    /// standby, which is to be written to the journal.
    pub fn voted(&mut self, name: &str, voted: &Voted, inc: Option<u64>) -> Option<Led> {
        self.candidate.voted(name, voted, inc);
        let epoch = self.candidate.win()?;
        self.led = Led { epoch, standby: false };
        self.standby = None;
        Some(self.led)
    }

    /// Whether a station of `epoch` leads in place of this one.
    #[must_use]
    pub fn deposed_by(&self, epoch: u32) -> bool {
        epoch > self.led.epoch
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
        let said = std::mem::replace(&mut self.asked_for, stands);
        (stands && !said).then(|| self.candidate.standing())
    }
}
