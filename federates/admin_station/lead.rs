//! The conductor of this station, with its journal: what it is told is on disk before anybody hears what it decided.

use crate::runtime::clock::{WallNs, monotonic_ns};
use crate::runtime::conductor::{Again, Conductor, ConductorConfig, Effect, Input, Step};
use crate::runtime::journal::{Journal, JournalError};
use crate::runtime::run_log::RunLog;
use std::path::Path;

/// A conductor that can be made again.
pub(super) struct Lead {
    conductor: Conductor,
    journal: Option<Journal>,
    /// Its steps since the last tick, for the journal.
    steps: Vec<Step>,
    effects: Vec<Effect>,
    /// Its time at the begin of this process.
    since: WallNs,
    /// Another process of this station led the run before.
    again: bool,
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
        let (steps, effects) = (Vec::new(), Vec::new());
        let opened = path.map(|path| Journal::open(path, &config)).transpose()?;
        let Some((mut journal, past)) = opened else {
            let conductor = Conductor::new(config);
            return Ok(Self { conductor, journal: None, steps, effects, since: 0, again: false });
        };
        let Some(mut past) = past else {
            let (conductor, journal) = (Conductor::new(config), Some(journal));
            return Ok(Self { conductor, journal, steps, effects, since: 0, again: false });
        };
        let config = ConductorConfig { fed: past.fed, ..config };
        let taken = journal.steps(&mut past);
        let Again { conductor, now, effects } =
            Conductor::again(config, taken, |run, record| log.append(run, record));
        // For the conductor no time passed between the two processes.
        let since = now.saturating_sub(monotonic_ns());
        let (journal, again) = (Some(journal), true);
        let mut lead = Self { conductor, journal, steps, effects, since, again };
        lead.tell(lead.now(), Input::Resumed);
        Ok(lead)
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

    /// Tells the conductor.
    pub(super) fn tell(&mut self, now: WallNs, input: Input) {
        if self.journal.is_some() {
            self.steps.push(Step::Told(now, input.clone()));
        }
        self.conductor.take(now, input, &mut self.effects);
    }

    /// Time passed: what is to be done, once it is in the journal what led to it.
    pub(super) fn tick(&mut self, now: WallNs) -> Vec<Effect> {
        self.conductor.tick(now, &mut self.effects);
        self.steps.push(Step::Tick(now));
        if let Some(journal) = &mut self.journal
            && let Err(e) = journal.append(&self.steps)
        {
            tracing::warn!(
                "the journal cannot be written: {e}; the run goes on without: if this process dies, the run is lost"
            );
            // What it holds is behind the run from now on: nobody may go on from there.
            self.over();
        }
        self.steps.clear();
        std::mem::take(&mut self.effects)
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
    use crate::runtime::messages::{Hello, Kind};
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
}
