//! Neighbouring rungs beside the chosen one: the same plots, another filter, nothing published.
//!
//! What would a cheaper filter give for this scene, and what a dearer one? Each shadow is a whole tracker of
//! its own with one rung changed, so that it sees what that choice would really lead to (its own gates, its
//! own associations). The chosen tracker is neither asked nor touched: its bits cannot depend on who watches.
//! One call runs one rung, so that the caller can measure the time of each.

use super::config::TrackingConfig;
use super::state::{Outcome, Statistics, Tracker};
use crate::filter::{FilterConfig, Rung};
use crate::flight_list::FlightList;
use crate::plot::Plot;
use crate::time::SimTime;
use crate::track::SystemTrack;

/// One rung beside the chosen one.
#[derive(Clone, Debug)]
pub struct Shadow {
    rung: Rung,
    tracker: Tracker,
}

/// The neighbours of the chosen rung on the ladder of filters.
#[derive(Clone, Debug)]
pub struct Shadows {
    rungs: Vec<Shadow>,
}

impl Shadow {
    /// The tracker of `config` with another filter; its noise density, start and map stay, modes and gains are
    /// those of the rung.
    #[must_use]
    pub fn new(config: &TrackingConfig, rung: Rung) -> Self {
        let mut config = config.clone();
        let chosen = config.filter;
        config.filter = FilterConfig {
            q: chosen.q,
            start: chosen.start,
            map: chosen.map,
            ..FilterConfig::new(rung)
        };
        Self { rung, tracker: Tracker::new(config) }
    }

    /// Which rung.
    #[must_use]
    pub fn rung(&self) -> Rung {
        self.rung
    }

    /// Its name in scenes and reports.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.rung.name()
    }

    /// [`Tracker::scan`] for this rung: the tracks that it would have published.
    pub fn scan(
        &mut self,
        t_out: SimTime,
        plots: &[Plot],
        flights: &FlightList,
    ) -> Vec<SystemTrack> {
        self.tracker.scan(t_out, plots, flights)
    }

    /// [`Tracker::outcomes`]: index by index what became of the plots, with the state just after each. Held
    /// against the truth at the plot's time, or against the chosen rung's state at the same index.
    #[must_use]
    pub fn outcomes(&self) -> &[Outcome] {
        self.tracker.outcomes()
    }

    /// Counters since this shadow was made.
    #[must_use]
    pub fn statistics(&self) -> &Statistics {
        self.tracker.statistics()
    }
}

impl Shadows {
    /// The filter one step cheaper and the one a step dearer than that of `config`, where there is one. They know
    /// nothing yet: made in the middle of a run, they need some scans to confirm their tracks.
    #[must_use]
    pub fn around(config: &TrackingConfig) -> Self {
        let mapped = config.filter.map.is_some();
        let ladder = Rung::ALL.map(|(rung, _)| rung);
        let place = ladder.iter().position(|rung| *rung == config.filter.rung).unwrap_or(0);
        // Without a map that rung is another one.
        let usable = |rung: &&Rung| mapped || **rung != Rung::Mh9Map;
        let cheaper = ladder[..place].iter().rev().find(usable);
        let dearer = ladder[place + 1..].iter().find(usable);
        let both = cheaper.into_iter().chain(dearer);
        Self { rungs: both.map(|&rung| Shadow::new(config, rung)).collect() }
    }

    /// The shadows, the cheaper one first; [`Shadow::scan`] each with the plots that the chosen rung gets.
    pub fn rungs(&mut self) -> &mut [Shadow] {
        &mut self.rungs
    }
}
