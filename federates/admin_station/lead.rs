//! The conductor of this station, with its journal: what it is told is on disk before anybody hears what it decided, and with the standby,
//! where there is one.

use crate::runtime::clock::{WallNs, monotonic_ns};
use crate::runtime::conductor::{Again, Conductor, ConductorConfig, Effect, Input, Replay, Step};
use crate::runtime::digest::pdu_hash;
use crate::runtime::journal::{Journal, JournalError, run_of};
use crate::runtime::messages::{Beat, FetchOf, Fetched, Order};
use crate::runtime::process::{host_name, random_id};
use crate::runtime::run_log::RunLog;
use crate::runtime::succession::{Candidate, Commit, Led, Question, Steps, StepsAsk, Voted};
use std::collections::VecDeque;
use std::path::Path;

/// Octets of one answer to a standby.
const CHUNK: u64 = 512 << 10;

/// A conductor that can be made again.
pub(super) struct Lead {
    conductor: Conductor,
    journal: Option<Journal>,
    /// Of which run the journal is.
    of: String,
    /// Its steps since the last tick, for the journal.
    steps: Vec<Step>,
    effects: Vec<Effect>,
    /// It was told something since the last tick, and when that was.
    told: bool,
    ticked: WallNs,
    /// Its time at the begin of this process.
    since: WallNs,
    /// Another process of this station led the run before.
    again: bool,
    /// What may be acted upon.
    commit: Commit,
    /// What was decided and may not be heard yet: the octets of the journal that led to it, and what members may know then.
    held: VecDeque<(u64, Vec<Effect>, Beat)>,
    /// What members may know of the conductor, where not all that it knows.
    said: Option<Beat>,
}

/// Who a station or standby with that journal is to the voters, whichever process of it; this one drew `by`.
pub(super) fn candidate(fed: u128, journal: &Path, by: u128) -> Candidate {
    let path = std::fs::canonicalize(journal).unwrap_or_else(|_| journal.to_owned());
    let who = pdu_hash(format!("{} {}", host_name(), path.display()).as_bytes());
    Candidate::new(fed, who, by)
}

impl Lead {
    /// The conductor of `config`; made again from the journal at `path`, where a station left one, with the log of its run.
    ///
    /// # Errors
    /// If the journal cannot be used, or is of another run.
    pub(super) fn open(
        path: Option<&Path>,
        config: ConductorConfig,
        log: &mut RunLog,
    ) -> Result<Self, JournalError> {
        let opened = path.map(|path| Journal::open(path, &config)).transpose()?;
        let Some((mut journal, past)) = opened else {
            let commit = Commit::new(0, Candidate::new(config.fed, 0, random_id()), Led::default());
            return Ok(Self::of(config, None, commit));
        };
        let Some(mut past) = past else {
            let commit =
                Commit::new(0, candidate(config.fed, journal.path(), random_id()), Led::default());
            return Ok(Self::of(config, Some(journal), commit));
        };
        let config = ConductorConfig { fed: past.fed, ..config };
        let mut replay = Replay::new(config.clone());
        for step in journal.steps(&mut past) {
            replay.step(step, |run, record| log.append(run, record));
        }
        let again = replay.done();
        let commit = Commit::new(
            again.now,
            candidate(config.fed, journal.path(), random_id()),
            journal.led(),
        );
        Ok(Self::of(config, Some(journal), commit).goes_on(again))
    }

    /// The conductor of a station that is no more, of which this one was the standby.
    ///
    /// # Errors
    /// If that cannot be written to the journal.
    pub(super) fn succeed(
        config: ConductorConfig,
        replay: Replay,
        mut journal: Journal,
        (candidate, led): (Candidate, Led),
    ) -> std::io::Result<Self> {
        journal.append_led(led)?;
        let again = replay.done();
        let commit = Commit::new(again.now, candidate, led);
        Ok(Self::of(config, Some(journal), commit).goes_on(again))
    }

    fn of(config: ConductorConfig, journal: Option<Journal>, commit: Commit) -> Self {
        Self {
            of: run_of(&config),
            conductor: Conductor::new(config),
            journal,
            steps: Vec::new(),
            effects: Vec::new(),
            told: true,
            ticked: 0,
            since: 0,
            again: false,
            commit,
            held: VecDeque::new(),
            said: None,
        }
    }

    fn goes_on(mut self, again: Again) -> Self {
        let Again { conductor, now, effects } = again;
        // For the conductor no time passed between the two processes.
        self.since = now.saturating_sub(monotonic_ns());
        (self.conductor, self.effects, self.again) = (conductor, effects, true);
        if self.commit.led().standby {
            // What was heard of its last words is not known yet.
            self.said = Some(Beat { fed: self.conductor.fed(), ..Beat::default() });
        }
        self.tell(self.now(), Input::Resumed);
        self
    }

    /// The conductor's time, ns: it goes on where the process before was.
    #[must_use]
    pub(super) fn now(&self) -> WallNs {
        self.since + monotonic_ns()
    }

    /// Whether another process of this station led the run before.
    #[must_use]
    pub(super) fn again(&self) -> bool {
        self.again
    }

    /// How the run stands.
    #[must_use]
    pub(super) fn conductor(&self) -> &Conductor {
        &self.conductor
    }

    /// Who may lead, as far as is known here.
    #[must_use]
    pub(super) fn led(&self) -> Led {
        self.commit.led()
    }

    /// What members may know of the conductor.
    #[must_use]
    pub(super) fn beat(&self) -> Beat {
        self.said.clone().unwrap_or_else(|| self.conductor.own_beat())
    }

    /// Answers a member that lacks orders: those that may be heard.
    #[must_use]
    pub(super) fn fetch_orders(&self, ask: &FetchOf) -> Fetched<Order> {
        let mut fetched = self.conductor.fetch_orders(ask);
        if let Some(said) = &self.said {
            fetched.items.retain(|order| order.seq <= said.last_seq);
            fetched.gone_before = fetched.gone_before.min(said.last_seq + 1);
        }
        fetched
    }

    /// Tells the conductor.
    pub(super) fn tell(&mut self, now: WallNs, input: Input) {
        if self.journal.is_some() {
            self.steps.push(Step::Told(now, input.clone()));
        }
        self.told = true;
        self.conductor.take(now, input, &mut self.effects);
    }

    /// Time passed: what is to be done, once it is in the journal what led to it, and with the standby, where there is one. Where nothing
    /// was told and nothing is due nothing is written: a standby's question is no event of the run.
    pub(super) fn tick(&mut self, now: WallNs) -> Vec<Effect> {
        if !self.told && now < self.conductor.deadline(self.ticked) {
            return self.may_be_heard();
        }
        (self.told, self.ticked) = (false, now);
        self.conductor.tick(now, &mut self.effects);
        self.steps.push(Step::Tick(now));
        if let Some(journal) = &mut self.journal
            && let Err(e) = journal.append(&self.steps)
        {
            self.cannot_write(now, &e);
        }
        self.steps.clear();
        let effects = std::mem::take(&mut self.effects);
        if self.said.is_none() {
            return effects;
        }
        let octets = self.journal.as_ref().map_or(u64::MAX, Journal::end);
        self.held.push_back((octets, effects, self.conductor.own_beat()));
        self.may_be_heard()
    }

    fn may_be_heard(&mut self) -> Vec<Effect> {
        let mut effects = Vec::new();
        while self.held.front().is_some_and(|(octets, ..)| self.commit.may_say(*octets))
            && let Some((_, these, said)) = self.held.pop_front()
        {
            effects.extend(these);
            self.said = Some(said);
        }
        if !self.commit.led().standby && self.held.is_empty() {
            self.said = None;
        }
        effects
    }

    fn cannot_write(&mut self, now: WallNs, e: &std::io::Error) {
        tracing::warn!(
            "the journal cannot be written: {e}; the run goes on without: if this process dies, the run is lost"
        );
        // What it holds is behind the run from now on: nobody may go on from there.
        self.over();
        self.commit.dismiss(now);
    }

    /// A standby asks for the journal; none while there is no more.
    pub(super) fn steps(&mut self, now: WallNs, ask: &StepsAsk) -> Option<Steps> {
        let Some(journal) = &mut self.journal else {
            return Some(Steps::Refused(
                "the administration station keeps no journal, which a standby reads: start it with --journal FILE".into(),
            ));
        };
        if ask.run != self.of {
            return Some(Steps::Refused(
                "the administration station leads another run: give the standby the same scene, seed, flags and build".into(),
            ));
        }
        if self.commit.has_another(now, ask.who) {
            return Some(Steps::Later("it has another standby".into()));
        }
        if self.commit.held_more(ask.from, journal.led_at()) {
            return Some(Steps::Later("the voters are asked whether another standby leads".into()));
        }
        match journal.sum(ask.from) {
            Ok(sum) if sum == Some(ask.sum) => {}
            Ok(_) => return Some(Steps::Anew),
            Err(e) => return Some(Steps::Later(format!("its journal cannot be read: {e}"))),
        }
        self.commit.holds(now, ask.who, ask.from);
        // Not before there are members: their voices decide when one of the two is lost.
        let there = self.conductor.awaited().is_empty();
        let near = journal.end() - ask.from < CHUNK / 8;
        if near && there && !self.commit.led().standby {
            self.said = Some(self.conductor.own_beat());
            let led = self.commit.admit();
            if let Err(e) = journal.append_led(led) {
                self.cannot_write(now, &e);
                return None;
            }
            tracing::info!("a standby holds the journal and leads on if this station is lost");
        }
        match journal.octets(ask.from, CHUNK) {
            Ok(octets) if octets.is_empty() => None,
            Ok(octets) => Some(Steps::Octets(octets)),
            Err(e) => Some(Steps::Later(format!("its journal cannot be read: {e}"))),
        }
    }

    /// The questions that are due to voters, where the standby is silent.
    pub(super) fn questions(&mut self, now: WallNs) -> Vec<Question> {
        let questions = self.commit.tick(now, self.conductor.voters());
        if let Some((here, all, silent)) = self.commit.stands() {
            tracing::warn!(
                "nothing is heard of the standby, without which nothing is said: {here} of {all} voters here, asking {}",
                silent.join(", ")
            );
        }
        questions
    }

    /// When the next questions are due.
    #[must_use]
    pub(super) fn questions_due(&self) -> WallNs {
        self.commit.deadline()
    }

    /// A voter answered.
    pub(super) fn voted(&mut self, now: WallNs, name: &str, voted: &Voted) {
        let inc = self.conductor.inc_of(name);
        let Some(led) = self.commit.voted(name, voted, inc) else { return };
        tracing::warn!("the run goes on without the standby, of which nothing is heard");
        if let Some(journal) = &mut self.journal
            && let Err(e) = journal.append_led(led)
        {
            self.cannot_write(now, &e);
        }
    }

    /// Whether a station of `epoch` leads in place of this one.
    #[must_use]
    pub(super) fn deposed_by(&self, epoch: u32) -> bool {
        self.commit.deposed_by(epoch)
    }

    /// Nobody is to go on from here.
    pub(super) fn over(&mut self) {
        if let Some(journal) = self.journal.take() {
            journal.remove();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::admin_station::clock_tests::config;
    use crate::runtime::messages::{Fetch, Hello, Kind, Numbered, Report};
    use crate::runtime::process::random_id;

    fn hello(name: &str) -> Hello {
        let (kind, pid, instance) = (Kind::TrafficGenerator, 1, 5);
        let (host, version) = ("h".into(), config().version);
        let scene_hash = config().scene_hash;
        Hello { name: name.into(), kind, pid, host, version, scene_hash, instance, was: None }
    }

    /// Whatever is to be done, the file knows already why: a copy of it, taken then, makes the same conductor.
    #[test]
    fn what_is_to_be_done_is_in_the_journal_before() {
        let folder = std::env::temp_dir().join(format!("seeds-lead-{:032x}", random_id()));
        std::fs::create_dir(&folder).expect("a folder");
        let (path, copy) = (folder.join("journal"), folder.join("copy"));
        let mut log = RunLog::default();
        let mut lead = Lead::open(Some(&path), config(), &mut log).expect("a journal");
        assert!(!lead.again());
        let mut welcomed = 0;
        for (n, name) in ["traffic-generator", "external-world", "smdfm"].iter().enumerate() {
            lead.tell(n as u64 * 1_000, Input::Hello(hello(name), n as u64));
            let effects = lead.tick(n as u64 * 1_000 + 500);
            welcomed += effects.iter().filter(|e| matches!(e, Effect::Welcome(..))).count();
            std::fs::copy(&path, &copy).expect("a copy");
            let (mut journal, past) = Journal::open(&copy, &config()).expect("a journal");
            let mut past = past.expect("a past");
            let config = ConductorConfig { fed: past.fed, ..config() };
            let again = Conductor::again(config, journal.steps(&mut past), |_, _| {});
            assert_eq!(format!("{:?}", again.conductor), format!("{:?}", lead.conductor()));
            assert_eq!(again.effects, effects, "carried out again, as nobody knows");
        }
        assert!(welcomed > 0);
        // A process that dies now is followed by one that leads the same federation, later by its own clock.
        let fed = lead.conductor().fed();
        drop(lead);
        let lead = Lead::open(Some(&path), ConductorConfig { fed: 99, ..config() }, &mut log);
        let mut lead = lead.expect("the same run");
        assert!(lead.again() && lead.conductor().fed() == fed && lead.now() >= 2_500);
        lead.over();
        assert!(!path.exists(), "over");
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    /// With a standby, a decision is heard once that holds what led to it; orders and beats say no more than was heard. Where the
    /// standby is silent, the members and the station decide to go on.
    #[test]
    fn nothing_is_heard_that_the_standby_does_not_hold() {
        let folder = std::env::temp_dir().join(format!("seeds-held-{:032x}", random_id()));
        std::fs::create_dir(&folder).expect("a folder");
        let mut lead = Lead::open(Some(&folder.join("journal")), config(), &mut RunLog::default())
            .expect("a journal");
        let ask = |from, sum| StepsAsk { run: run_of(&config()), who: 7, from, sum };
        let mut copy = Vec::new();
        let mut read = |lead: &mut Lead, now| loop {
            let tail = &copy[copy.len().saturating_sub(4096)..];
            match lead.steps(now, &ask(copy.len() as u64, pdu_hash(tail))) {
                Some(Steps::Octets(octets)) => copy.extend(octets),
                None => return copy.len(),
                other => panic!("{other:?}"),
            }
        };
        read(&mut lead, 0);
        assert!(!lead.led().standby, "members decide who leads: not without them");
        for (n, name) in ["external-world", "smdfm"].iter().enumerate() {
            lead.tell(n as u64, Input::Hello(hello(name), n as u64));
            assert_eq!(
                lead.tick(n as u64).iter().filter(|e| matches!(e, Effect::Welcome(..))).count(),
                1
            );
        }
        let held = read(&mut lead, 10);
        assert!(lead.led().standby && held > 0);
        let said = lead.beat();
        let command = |token| Input::Command(crate::runtime::messages::Command::Status, token);
        let answers = |effects: Vec<Effect>| -> Vec<u64> {
            let answered = |e: &Effect| match e {
                Effect::Answer(token, _) => Some(*token),
                _ => None,
            };
            effects.iter().filter_map(answered).collect()
        };
        lead.tell(1_000, command(40));
        assert!(answers(lead.tick(1_000)).is_empty());
        lead.tell(2_000, command(41));
        assert!(answers(lead.tick(2_000)).is_empty());
        assert_eq!(lead.beat(), said);
        assert!(
            matches!(lead.steps(2_500, &ask(held as u64, 1)), Some(Steps::Anew)),
            "of another journal"
        );
        assert!(read(&mut lead, 3_000) > held);
        assert_eq!(answers(lead.tick(4_000)), [40, 41], "in their order");

        // Nor is an order told to a member that asks for what it lacks.
        let lacking = |lead: &Lead| {
            let fetch = Fetch { fed: lead.conductor().fed(), inc: 0, from: 1, to: u64::MAX };
            lead.fetch_orders(&FetchOf { of: "conductor".into(), fetch }).items.len()
        };
        for name in ["external-world", "smdfm"] {
            let fed = lead.conductor().fed();
            let inc = lead.conductor().inc_of(name).expect("a member");
            let hears = vec!["external-world".to_owned()];
            let body = Report::Present { hears, consumes: name == "smdfm" };
            lead.tell(5_000, Input::Report(name.into(), Numbered { fed, inc, seq: 0, body }));
        }
        let decided = lead.tick(5_000);
        assert_eq!((decided.len(), lacking(&lead)), (0, 0));
        assert!(lead.conductor().own_beat().last_seq > 0, "to configure");
        read(&mut lead, 6_000);
        let ordered = |e: &Effect| matches!(e, Effect::Order(o) if o.seq > 0);
        let heard = lead.tick(6_500).iter().filter(|e| ordered(e)).count();
        assert_eq!((heard, lacking(&lead)), (1, 1));

        let silent = 5_000_000_000;
        lead.tell(silent, command(42));
        assert!(answers(lead.tick(silent)).is_empty());
        let questions = lead.questions(silent);
        assert_eq!(questions.len(), 2);
        for (n, (name, question)) in questions.iter().enumerate() {
            assert!(answers(lead.tick(silent + n as u64)).is_empty(), "{n} voices are too few");
            let inc = lead.conductor().inc_of(name).expect("a member");
            let voice = crate::runtime::succession::Voice::Promised;
            let (by, attempt) = (question.by, question.attempt);
            lead.voted(silent, name, &Voted { by, attempt, inc, voice });
        }
        assert_eq!(answers(lead.tick(silent + 9)), [42]);
        assert_eq!(lead.led(), Led { epoch: 1, standby: false });
        assert_eq!(lead.beat(), lead.conductor().own_beat());
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
