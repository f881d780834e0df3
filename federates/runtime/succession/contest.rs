//! Asking the voters, counting their voices, giving promises back.

use super::{Candidacy, Voice, Voted, Wants};
use crate::runtime::clock::WallNs;
use std::collections::BTreeMap;

/// Who has not promised is asked again so often, ns.
const AGAIN_NS: WallNs = 250_000_000;

/// A question to a voter of that name.
pub type Question = (String, Candidacy);

#[derive(Clone, Debug)]
struct Contest {
    since: u32,
    wants: Wants,
    /// What each voter said last in this attempt; none yet.
    voices: BTreeMap<String, Option<Voice>>,
    ask_at: WallNs,
}

/// One who may ask for promises.
#[derive(Clone, Debug)]
pub struct Candidate {
    fed: u128,
    who: u64,
    by: u128,
    attempt: u32,
    contest: Option<Contest>,
    /// Voters that may still hold a promise to this one that was given up: of which epoch, which attempt.
    owed: BTreeMap<String, (u32, u32)>,
    owed_at: WallNs,
}

impl Candidate {
    /// `who` of that federation, whose process drew `by`.
    #[must_use]
    pub fn new(fed: u128, who: u64, by: u128) -> Self {
        Self { fed, who, by, attempt: 0, contest: None, owed: BTreeMap::new(), owed_at: 0 }
    }

    /// Who it is, whichever process of it.
    #[must_use]
    pub fn who(&self) -> u64 {
        self.who
    }

    /// Its process.
    #[must_use]
    pub fn by(&self) -> u128 {
        self.by
    }

    /// Whether it asks for promises now.
    #[must_use]
    pub fn contends(&self) -> bool {
        self.contest.is_some()
    }

    /// Begins to ask `voters` for the epoch after `since`, unless it does so already.
    pub fn contend(&mut self, now: WallNs, since: u32, wants: Wants, voters: &[String]) {
        if self.contest.is_none() {
            self.attempt += 1;
            let voices = voters.iter().map(|name| (name.clone(), None)).collect();
            self.contest = Some(Contest { since, wants, voices, ask_at: now });
        }
    }

    /// Asks no more; promises are given back.
    pub fn withdraw(&mut self, now: WallNs) {
        if let Some(contest) = self.contest.take() {
            let owed = (contest.since, self.attempt);
            self.owed.extend(contest.voices.into_keys().map(|name| (name, owed)));
            self.owed_at = now;
        }
    }

    fn candidacy(&self, since: u32, wants: Wants) -> Candidacy {
        let Self { fed, who, by, attempt, .. } = *self;
        Candidacy { fed, who, by, since, attempt, wants }
    }

    /// The questions that are due.
    pub fn tick(&mut self, now: WallNs) -> Vec<Question> {
        let mut questions = Vec::new();
        if now >= self.owed_at && !self.owed.is_empty() {
            self.owed_at = now + AGAIN_NS;
            for (name, (since, attempt)) in &self.owed {
                let (since, attempt, wants) = (*since, *attempt, Wants::Nothing);
                let ask = Candidacy { attempt, ..self.candidacy(since, wants) };
                questions.push((name.clone(), ask));
            }
        }
        let due = self.contest.as_ref().filter(|contest| now >= contest.ask_at);
        let ask = due.map(|contest| self.candidacy(contest.since, contest.wants));
        if let Some((contest, ask)) = self.contest.as_mut().zip(ask) {
            contest.ask_at = now + AGAIN_NS;
            let open = contest.voices.iter().filter(|(_, v)| **v != Some(Voice::Promised));
            questions.extend(open.map(|(name, _)| (name.clone(), ask.clone())));
        }
        questions
    }

    /// When the next questions are due.
    #[must_use]
    pub fn deadline(&self) -> WallNs {
        let owed = if self.owed.is_empty() { WallNs::MAX } else { self.owed_at };
        self.contest.as_ref().map_or(owed, |contest| contest.ask_at.min(owed))
    }

    /// A voter answered; `inc` is the incarnation that it has by the journal.
    pub fn voted(&mut self, name: &str, voted: &Voted, inc: Option<u64>) {
        if voted.by != self.by {
            return;
        }
        if voted.voice == Voice::Free {
            self.owed.retain(|owed, (_, attempt)| owed != name || *attempt > voted.attempt);
            return;
        }
        let Some(contest) = &mut self.contest else { return };
        // A promise counts of who is a voter; that another has it is worth knowing from anybody.
        let counts = inc == Some(voted.inc) || matches!(voted.voice, Voice::Another(_));
        if voted.attempt == self.attempt
            && counts
            && let Some(voice) = contest.voices.get_mut(name)
            && *voice != Some(Voice::Promised)
        {
            *voice = Some(voted.voice);
        }
    }

    fn count(&self, what: impl Fn(Option<Voice>) -> bool) -> usize {
        let voices = self.contest.iter().flat_map(|contest| contest.voices.values());
        voices.filter(|voice| what(**voice)).count()
    }

    /// More than half of the voters: those asked, this one and the other station.
    fn majority(&self) -> usize {
        (self.count(|_| true) + 2) / 2 + 1
    }

    /// The epoch is its own: ends the contest.
    pub fn win(&mut self) -> Option<u32> {
        let won = 1 + self.count(|v| v == Some(Voice::Promised)) >= self.majority();
        let contest = self.contest.take_if(|_| won)?;
        Some(contest.since + 1)
    }

    /// More than half have promised the epoch to the other one, which is one of them.
    #[must_use]
    pub fn lost(&self) -> bool {
        let another = |voice| matches!(voice, Some(Voice::Another(_)));
        self.contends() && 1 + self.count(another) >= self.majority()
    }

    /// Somebody hears a station.
    #[must_use]
    pub fn beating(&self) -> bool {
        self.count(|voice| voice == Some(Voice::Beating)) > 0
    }

    /// How many voices it has, its own among them, of how many, and who was not heard.
    #[must_use]
    pub fn standing(&self) -> (usize, usize, Vec<&str>) {
        let promised = 1 + self.count(|voice| voice == Some(Voice::Promised));
        let voices = self.contest.iter().flat_map(|contest| &contest.voices);
        let silent = voices.filter(|(_, voice)| voice.is_none()).map(|(name, _)| &name[..]);
        (promised, self.count(|_| true) + 2, silent.collect())
    }
}
