//! Two rungs, one at a time: modes that are mixed, and events only where the innovations of the modes call for them.
//!
//! The modes always run. Events begin with a track and when the discounted mean of the modes' squared normalised innovations is not what
//! it should be: more, as something moves that they do not know, or less, as they allow for more than the sensor's errors need. Both
//! then run; published is the one that the likelihoods of their plots justify ([`super::choice`]): to the events when these lead by
//! [`SWITCH_UP`], back as soon as the modes are as good. Events that have not led, with innovations as they should be, for
//! [`CALM_S`] end. Innovations leave the band by chance too, and each time call for the events for [`CALM_S`]: where all is calm
//! they run less, not never. Plots that are shared by several tracks say nothing of the choice; what was known of it fades.

use super::choice::Choice;
use super::events::{EventModel, Events};
use super::gaussian::{Gaussian, Nis};
use super::imm::Imm;
use super::modes::Modes;
use super::{Declared, Estimate, Estimator, Start, StateEstimator, UpdateError, interval};
use crate::plot::Plot;
use crate::time::SimTime;
use std::sync::Arc;

/// What a plot said counts so much a second later.
const KEPT_PER_S: f64 = 0.9;

/// By how much the events have to lead, in ln of the likelihood, to be taken: 7.4 to one.
pub const SWITCH_UP: f64 = 2.0;

/// Mean squared normalised innovations, per two degrees of freedom, between which the modes are alone: 2 is right, and a mean of what the
/// discount leaves of so many plots has a deviation of 0.46.
const LIKE: std::ops::RangeInclusive<f64> = 1.4..=2.6;

/// Events that are not called for go on so long, s.
pub const CALM_S: f64 = 10.0;

/// See the module's text.
#[derive(Clone, Debug)]
pub struct Chosen {
    modes: Imm<3>,
    events: Option<Events<27>>,
    choice: Choice,
    /// 0: the modes are published, 1: the events.
    now: usize,
    /// Discounted sums of squared innovations, per two degrees of freedom, and of plots.
    squares: f64,
    plots: f64,
    /// When the events were called for last.
    called: SimTime,
}

impl Chosen {
    /// Both from one plot.
    ///
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    pub fn from_plot(plot: &Plot, modes: Arc<Modes>, start: Start) -> Result<Self, UpdateError> {
        Ok(Self {
            modes: Imm::from_plot(plot, modes, start)?,
            events: Some(Events::from_plot(plot, EventModel::default(), start)?),
            choice: Choice::new(2),
            now: 0,
            squares: 0.0,
            plots: 0.0,
            called: plot.time,
        })
    }

    /// Whether the events run beside the modes, and whether they are what is published.
    #[must_use]
    pub fn events(&self) -> (bool, bool) {
        (self.events.is_some(), self.now == 1)
    }

    fn take(
        &mut self,
        plot: &Plot,
        modes: impl FnOnce(&mut Imm<3>) -> Result<Nis, UpdateError>,
        events: impl FnOnce(&mut Events<27>) -> Result<Nis, UpdateError>,
    ) -> Result<Nis, UpdateError> {
        let kept = libm::pow(KEPT_PER_S, interval(self.time(), plot.time)?);
        let mut next = self.clone();
        let found = modes(&mut next.modes)?;
        if let Some(own) = &mut next.events {
            let log = match events(own) {
                Ok(_) => own.log_density(),
                // They begin again from what the modes know.
                Err(_) => {
                    own.replace(plot.time, &next.modes.estimate().state);
                    f64::NEG_INFINITY
                }
            };
            next.choice.add(kept, &[next.modes.log_density(), log]);
            next.now = next.choice.choose(next.now, SWITCH_UP);
        }
        next.squares = kept * next.squares + found.d2 * 2.0 / f64::from(found.dof);
        next.plots = kept * next.plots + 1.0;
        next.call(plot);
        *self = next;
        Ok(found)
    }

    /// Begins or ends the events as the innovations have it.
    fn call(&mut self, plot: &Plot) {
        if self.now == 1 || !LIKE.contains(&(self.squares / self.plots)) {
            self.called = plot.time;
            if self.events.is_none() {
                let state = self.modes.estimate().state;
                self.events =
                    Some(Events::at(plot.time, &state, EventModel::default(), self.start()));
                self.choice = Choice::new(2);
            }
        } else if plot.time.since_s(self.called) > CALM_S {
            self.events = None;
        }
    }
}

impl StateEstimator for Chosen {
    fn time(&self) -> SimTime {
        self.modes.time()
    }
    fn estimate(&self) -> Estimate {
        match &self.events {
            Some(events) if self.now == 1 => events.estimate(),
            _ => self.modes.estimate(),
        }
    }
    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        match &self.events {
            Some(events) if self.now == 1 => events.predicted(time),
            _ => self.modes.predicted(time),
        }
    }
    fn update(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        self.take(plot, |f| f.update(plot), |f| f.update(plot))
    }
    fn update_manoeuvre(&mut self, plot: &Plot) -> Result<Nis, UpdateError> {
        self.take(plot, |f| f.update_manoeuvre(plot), |f| f.update_manoeuvre(plot))
    }
    fn update_weighted(&mut self, plots: &[(&Plot, f64)]) -> Result<(), UpdateError> {
        if let Some((certain, _)) = plots.iter().find(|(_, beta)| *beta >= 1.0) {
            return self.update(certain).map(|_| ());
        }
        let kept = match plots.first() {
            Some((plot, _)) => libm::pow(KEPT_PER_S, interval(self.time(), plot.time)?),
            None => 1.0,
        };
        let mut modes = self.modes.clone();
        modes.update_weighted(plots)?;
        self.modes = modes;
        (self.squares, self.plots) = (kept * self.squares, kept * self.plots);
        self.choice.add(kept, &[0.0, 0.0]);
        if self.now == 1 {
            self.called = self.modes.time();
        } else if self.modes.time().since_s(self.called) > CALM_S {
            self.events = None;
        }
        if let Some(events) = &mut self.events
            && events.update_weighted(plots).is_err()
        {
            events.replace(self.modes.time(), &self.modes.estimate().state);
        }
        Ok(())
    }
    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        self.modes.replace(time, state);
        if let Some(events) = &mut self.events {
            events.replace(time, state);
        }
        (self.choice, self.now) = (Choice::new(2), 0);
        (self.squares, self.plots) = (0.0, 0.0);
    }
    fn start(&self) -> Start {
        self.modes.start()
    }
}

/// The rung `choice`.
pub const CHOICE: Declared = Declared {
    word: "choice",
    about: "three kinds of motion, or 27 histories where the plots call for them",
    // With both; a scan's budget must bear that all targets manoeuvre at once.
    cost: 1_430,
    modes: Modes::mixed,
    histories: Some(0),
    start: |config, plot| {
        Ok(Estimator::own(Chosen::from_plot(plot, Arc::clone(&config.modes), config.start)?))
    },
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::{DrawKey, Purpose, normal_pair};
    use crate::filter::testing::plot_at;
    use crate::frames::Vector2;

    /// Plots of `sigma_m` per axis along a way, one a second.
    fn plots(seed: u64, count: u32, sigma_m: f64, way: impl Fn(f64) -> Vector2<f64>) -> Vec<Plot> {
        let plot = |k: u32| {
            let key = DrawKey { run_seed: seed, sensor: 1, entity: 0, scan: k.into() };
            let (a, b) = normal_pair(&mut key.rng(Purpose::Study));
            let at = way(f64::from(k)) + Vector2::new(a, b) * sigma_m;
            plot_at(f64::from(k), at.x, at.y, sigma_m * sigma_m)
        };
        (0..count).map(plot).collect()
    }

    fn of(plot: &Plot) -> (Chosen, Imm<3>) {
        let modes = Arc::new(Modes::mixed());
        let chosen = Chosen::from_plot(plot, Arc::clone(&modes), Start::default());
        let alone = Imm::from_plot(plot, modes, Start::default());
        (chosen.expect("sound"), alone.expect("sound"))
    }

    /// Straight on for a minute, braked at 3 m/s² for five seconds, straight on again.
    fn braked(t: f64) -> Vector2<f64> {
        let slowed = (t - 60.0).clamp(0.0, 5.0);
        let after = (t - 65.0).max(0.0);
        Vector2::new(
            20.0 * t.min(60.0) + (20.0 * slowed - 1.5 * slowed * slowed) + 5.0 * after,
            0.0,
        )
    }

    /// What is published is the modes' to the bit unless the events are chosen, whatever happens beside; where a machine brakes the
    /// events are called and chosen for some of it, and they end in the calm again.
    #[test]
    fn it_is_the_modes_unless_the_plots_justify_the_events() {
        let (mut braking, mut calm, mut chosen_ever) = (0, 0, 0);
        for seed in 1..=20 {
            let plots = plots(seed, 200, 1.5, braked);
            let (mut filter, mut alone) = of(&plots[0]);
            for plot in &plots[1..] {
                filter.update(plot).expect("sound");
                alone.update(plot).expect("sound");
                let (run, chosen) = filter.events();
                assert!(run || !chosen);
                let later = plot.time.plus_s(0.7);
                if chosen {
                    chosen_ever += 1;
                    assert_ne!(filter.estimate(), alone.estimate());
                } else {
                    assert_eq!(filter.estimate(), alone.estimate());
                    assert_eq!(filter.predicted(later), alone.predicted(later));
                }
                match plot.time.0 / 1_000_000_000 {
                    62..=70 => braking += u32::from(run),
                    120.. => calm += u32::from(run),
                    _ => {}
                }
            }
        }
        let shares = [f64::from(braking) / 180.0, f64::from(calm) / 1_600.0];
        println!("{shares:?}, chosen {chosen_ever}");
        assert!(
            shares[0] > 0.95 && shares[1] < 0.9 && chosen_ever > 20,
            "{shares:?} {chosen_ever}"
        );
    }

    /// Innovations that are too small call for the events as those do that are too large: modes of fixed noise allow for too much where
    /// the sensor is fine.
    #[test]
    fn a_fine_sensor_calls_for_events_as_a_manoeuvre_does() {
        let share = |sigma_m: f64| {
            let mut chosen = 0;
            for seed in 1..=10 {
                let plots = plots(seed, 100, sigma_m, |t| Vector2::new(12.0 * t, 3.0 * t));
                let (mut filter, _) = of(&plots[0]);
                for plot in &plots[1..] {
                    filter.update(plot).expect("sound");
                    chosen += u32::from(filter.events().1);
                }
            }
            f64::from(chosen) / 990.0
        };
        let (fine, coarse) = (share(0.1), share(4.0));
        println!("{fine} {coarse}");
        assert!(fine > 0.5 && coarse < fine, "{fine} {coarse}");
    }

    /// Plots that are shared with other tracks say nothing of the choice: what was known of it fades, and events that nothing calls for end.
    #[test]
    fn what_shared_plots_do_not_say_fades() {
        let plots = plots(5, 60, 2.0, |t| Vector2::new(8.0 * t, 0.0));
        let (mut filter, _) = of(&plots[0]);
        for plot in &plots[1..6] {
            filter.update(plot).expect("sound");
        }
        assert!(filter.events().0, "they begin with the track");
        let (known, published) = (filter.plots, filter.events().1);
        filter.now = 0;
        for plot in &plots[6..20] {
            filter.update_weighted(&[(plot, 0.5)]).expect("sound");
        }
        assert!(filter.plots < 0.3 * known, "{} of {known}", filter.plots);
        assert!(!filter.events().0, "published before: {published}");
    }

    /// A state that is no number: the events begin again where they fail, and the modes go on.
    #[test]
    fn events_that_fail_begin_again_from_the_modes() {
        let plots = plots(3, 30, 2.0, |t| Vector2::new(8.0 * t, 0.0));
        let (mut filter, mut alone) = of(&plots[0]);
        for plot in &plots[1..8] {
            filter.update(plot).expect("sound");
            alone.update(plot).expect("sound");
        }
        let mut broken = filter.modes.estimate().state;
        broken.x[0] = broken.x[0] * f64::NAN;
        for several in [false, true] {
            let (mut filter, mut alone) = (filter.clone(), alone.clone());
            filter
                .events
                .as_mut()
                .expect("they begin with the track")
                .replace(filter.modes.time(), &broken);
            if several {
                let both = [(&plots[8], 0.6), (&plots[9], 0.3)];
                let both = both.map(|(plot, beta)| (Plot { time: plots[8].time, ..*plot }, beta));
                let both = [(&both[0].0, both[0].1), (&both[1].0, both[1].1)];
                filter.update_weighted(&both).expect("the modes go on");
                alone.update_weighted(&both).expect("sound");
            } else {
                filter.update(&plots[8]).expect("the modes go on");
                alone.update(&plots[8]).expect("sound");
            }
            let begun = filter.events.as_ref().expect("they run").estimate();
            assert_eq!(begun.time, alone.time());
            assert!((begun.position_m() - alone.estimate().position_m()).norm() < 1e-9);
            assert_eq!(filter.modes.estimate(), alone.estimate());
        }
    }

    /// A state that is set is the state of both, and nothing is known of which is better.
    #[test]
    fn a_state_that_is_set_is_that_of_both() {
        let plots = plots(5, 90, 1.0, braked);
        let (mut filter, _) = of(&plots[0]);
        for plot in &plots[1..] {
            filter.update(plot).expect("sound");
        }
        let other = of(&plots[40]).0.estimate();
        filter.replace(plots[89].time, &other.state);
        assert_eq!((filter.now, filter.squares, filter.plots), (0, 0.0, 0.0));
        let set = filter.estimate();
        assert!((set.position_m() - other.position_m()).norm() < 1e-9);
        if let Some(events) = &filter.events {
            assert!((events.estimate().position_m() - other.position_m()).norm() < 1e-9);
        }
    }
}
