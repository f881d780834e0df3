//! The filter of a track and its updates of the last seconds: a late plot goes to its place among them, and what came after it
//! is done again.

use super::config::TrackingConfig;
use super::consider::Consider;
use super::filter::{Gaps, TrackFilter, predict, slow_error};
use super::lag::Lag;
use super::ring::{Past, RingOf, Slotted};
use super::updates::{After, Record, Taken, Update, again, likeliest, step, whole};
use crate::filter::{Gaussian, UpdateError};
use crate::frames::{Matrix2, Point2, Vector2};
use crate::plot::Plot;
use crate::time::SimTime;

/// One update and the filter before it.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    before: TrackFilter,
    update: Record,
}

/// The updates of the last seconds, of all tracks.
pub(super) type Ring = RingOf<Entry>;

impl Entry {
    /// An update that became a beginning is one when it is done again.
    fn note_beginning(&mut self, after: After, update: Update<'_>) {
        if after.reborn {
            self.update = Record::Plot(Taken::of(update.plot()));
        }
    }
}

/// How an update went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Applied {
    /// The plot was taken; position and velocity just after it.
    Taken { position_m: Point2<f64>, velocity_mps: Vector2<f64> },
    /// The filter could not go on: the track was started again from this plot.
    Reborn { position_m: Point2<f64>, velocity_mps: Vector2<f64> },
    /// The plot was refused by the filter and left no trace.
    Refused,
}

/// See the module's text.
#[derive(Clone, Debug)]
pub(super) struct Way {
    /// The filter after the last plot.
    now: TrackFilter,
    /// Where the updates of the last seconds are, each with the filter before it.
    past: Past,
    /// How often its plots come, s.
    interval_s: f64,
}

impl Way {
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    pub(super) fn from_plot(plot: &Plot, config: &TrackingConfig) -> Result<Self, UpdateError> {
        let now = TrackFilter::from_plot(config, plot)?;
        Ok(Self { now, past: Past::default(), interval_s: 0.0 })
    }

    /// Its plots come as often as this, s.
    pub(super) fn expect(&mut self, interval_s: f64) {
        self.interval_s = interval_s;
    }

    /// What is a long gap between them.
    #[inline]
    pub(super) fn gaps(&self, config: &TrackingConfig) -> Gaps {
        config.life.gaps(self.interval_s)
    }

    /// This state, which is all that is known.
    pub(super) fn replace(&mut self, time: SimTime, state: &Gaussian) {
        self.now.replace(time, state);
    }

    /// The filter after the last plot.
    #[inline]
    pub(super) fn filter(&self) -> &TrackFilter {
        &self.now
    }

    /// The filter as it was at `time`: after the last update that is not later.
    #[inline]
    pub(super) fn filter_before<'a>(
        &'a self,
        time: SimTime,
        ring: &'a Ring,
    ) -> Option<&'a TrackFilter> {
        if self.now.time() <= time {
            return Some(&self.now);
        }
        let place = self.past.place_at(time)?;
        Some(&ring[self.past[place].slot].before)
    }

    /// How many updates a plot of this time would have done again.
    pub(super) fn later_than(&self, time: SimTime) -> usize {
        self.past.iter().rev().take_while(|at| at.before > time).count()
    }

    /// Gives back what the ring holds for the track, which has ended.
    pub(super) fn leave(&mut self, ring: &mut Ring) {
        self.past.drain(..).for_each(|at| ring.free(at.slot));
    }

    /// Takes an update at its own time. A late one goes to its place, and all later ones are done
    /// again: the result is that of processing in order. With `merge` the filter goes on as one Gaussian first. What is
    /// older than `oldest` is forgotten.
    pub(super) fn apply(
        &mut self,
        update: Update<'_>,
        merge: bool,
        config: &TrackingConfig,
        oldest: SimTime,
        ring: &mut Ring,
    ) -> Applied {
        let (time, gaps) = (update.plot().time, self.gaps(config));
        let after = if self.now.time() <= time {
            let before = self.now.time();
            let update_again = update.record(merge);
            let slot = ring.put(Entry { before: self.now.clone(), update: update_again });
            match step(&mut self.now, update, merge, (config, gaps)) {
                Ok(after) => {
                    ring[slot].note_beginning(after, update);
                    self.past.push(Slotted { before, slot });
                    after
                }
                Err(_) => {
                    std::mem::swap(&mut self.now, &mut ring[slot].before);
                    ring.free(slot);
                    return Applied::Refused;
                }
            }
        } else {
            // The state that the update starts from: `before` of the entry at `place`.
            let place = match self.past.place_at(time) {
                Some(place) => place,
                None if matches!(update, Update::Restart(..)) && !self.past.is_empty() => 0,
                None => return Applied::Refused, // before the oldest state that is kept
            };
            let before = ring[self.past[place].slot].before.clone();
            let mut filter = before.clone();
            let Ok(mut after) = step(&mut filter, update, merge, (config, gaps)) else {
                return Applied::Refused;
            };
            let mut entry = Entry { before, update: update.record(merge) };
            entry.note_beginning(after, update);
            let at = Slotted { slot: ring.put(entry), ..self.past[place] };
            self.past.insert(place, at);
            for at in &mut self.past[place + 1..] {
                let later = &mut ring[at.slot];
                later.before.clone_from(&filter);
                at.before = filter.time();
                // What cannot be done again leaves the state of the update before it.
                match again(&mut filter, &later.update, (config, gaps)) {
                    Ok(done) => after.reborn |= done.reborn,
                    Err(_) => filter.clone_from(&later.before),
                }
            }
            self.now = filter;
            after
        };
        self.forget_before(oldest, ring);
        let After { position_m, velocity_mps, reborn } = after;
        if reborn {
            Applied::Reborn { position_m, velocity_mps }
        } else {
            Applied::Taken { position_m, velocity_mps }
        }
    }

    /// Where the track was at `then`, when it was there already, by all plots it has had by now; nothing if its state then is
    /// not kept any more.
    pub(super) fn second_ago(
        &self,
        then: SimTime,
        config: &TrackingConfig,
        ring: &Ring,
    ) -> Option<(Point2<f64>, Matrix2<f64>)> {
        let gaps = self.gaps(config);
        if self.now.time() <= then {
            return Lag::of(&self.now, then, gaps).ok().map(|lag| lag.copy());
        }
        let first = self.past.iter().position(|at| {
            // The update that it leads to came after.
            ring[at.slot].update.time() > then
        })?;
        let before = &ring[self.past[first].slot].before;
        if let TrackFilter::Considering(filter) = before {
            let mut filter = filter.clone();
            if then.since_s(filter.time()) > gaps.after_s {
                // After a long gap as its next update will find it, slow errors and all.
                filter.replace(then, &predict(before, then, gaps).ok()?.state);
            }
            return self.revised(filter.copied(then).ok()?, first, config, ring);
        }
        let mut lag = Lag::of(before, then, gaps).ok()?;
        for at in &self.past[first..] {
            let Entry { before, update } = &ring[at.slot];
            let done = match update {
                // What no prediction foresaw says little of what was before it.
                Record::Plot(taken) if taken.manoeuvre => Err(UpdateError::UnsoundPlot),
                Record::Plot(taken) => lag.update(before, &[(taken.plot(), 1.0)], gaps),
                Record::Weighted(plots) => lag.update(before, &whole(plots), gaps),
                Record::Restart(_) => Err(UpdateError::UnsoundPlot),
            };
            if done.is_err() {
                lag.forget();
            }
        }
        Some(lag.copy())
    }

    /// The copied position of `filter` after the updates from the one at place `first` of the past.
    fn revised(
        &self,
        mut filter: Consider,
        first: usize,
        config: &TrackingConfig,
        ring: &Ring,
    ) -> Option<(Point2<f64>, Matrix2<f64>)> {
        let mut found = filter.copy()?;
        for at in &self.past[first..] {
            let update = &ring[at.slot].update;
            if update.time().since_s(filter.time()) > self.gaps(config).after_s {
                break;
            }
            // What no prediction foresaw says little of what was before it.
            let done = match update {
                Record::Plot(taken) if taken.manoeuvre => break,
                Record::Restart(_) => break,
                Record::Plot(taken) => {
                    let plot = taken.plot();
                    filter.update(&plot, slow_error(&plot, config), false)
                }
                Record::Weighted(plots) => {
                    let plots = whole(plots);
                    let Some((plot, _)) = plots.first() else { break };
                    filter.update_weighted(&plots, slow_error(plot, config))
                }
            };
            let Some(copy) = done.ok().and_then(|()| filter.copy()) else { break };
            found = copy;
        }
        Some(found)
    }

    /// Begins again from the last plot; false if there is none that can begin a track.
    pub(super) fn begin_again(&mut self, config: &TrackingConfig, ring: &Ring) -> bool {
        let plot = match self.past.last().map(|at| &ring[at.slot].update) {
            Some(Record::Plot(taken)) => taken.plot(),
            Some(Record::Restart(both)) => both[1].plot(),
            Some(Record::Weighted(plots)) => *likeliest(&whole(plots)),
            None => return false,
        };
        let Ok(fresh) = TrackFilter::from_plot(config, &plot) else { return false };
        self.now = fresh;
        true
    }

    /// Forgets updates that no plot may come before any more, all but the last.
    fn forget_before(&mut self, oldest: SimTime, ring: &mut Ring) {
        let kept = self.past.iter().skip(1).take_while(|at| at.before < oldest).count();
        self.past.drain(..kept).for_each(|at| ring.free(at.slot));
    }
}
