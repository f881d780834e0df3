//! Two rungs side by side: modes that are mixed, and events, averaged by the discounted likelihood of their plots.
//!
//! Neither is the best everywhere: accelerations of recorded traffic drift, those of machines that are driven begin and end.

use super::choice::Choice;
use super::events::{EventModel, Events};
use super::gaussian::{Gaussian, Nis};
use super::imm::Imm;
use super::modes::Modes;
use super::{Declared, Estimate, Estimator, Start, StateEstimator, UpdateError, interval};
use crate::plot::Plot;
use crate::time::SimTime;
use std::sync::Arc;

/// See the module's text.
#[derive(Clone, Debug)]
pub struct Averaged {
    modes: Imm<3>,
    events: Events<27>,
    choice: Choice,
}

/// A rung that weighs less is left out.
const LEAST_SHARE: f64 = 1e-9;

/// What a plot said counts so much a second later.
const KEPT_PER_S: f64 = 0.9;

impl Averaged {
    /// Both from one plot.
    ///
    /// # Errors
    /// If the plot is unsound or measures one direction only.
    pub fn from_plot(plot: &Plot, modes: Arc<Modes>, start: Start) -> Result<Self, UpdateError> {
        Ok(Self {
            modes: Imm::from_plot(plot, modes, start)?,
            events: Events::from_plot(plot, EventModel::default(), start)?,
            choice: Choice::new(2),
        })
    }

    /// Weight of the modes and of the events.
    #[must_use]
    pub fn weights(&self) -> [f64; 2] {
        let weights = self.choice.weights();
        [weights[0], weights[1]]
    }

    fn both(&self, modes: &Gaussian, events: &Gaussian) -> Gaussian {
        let [of_modes, of_events] = self.weights();
        // What weighs nothing leaves no trace of rounding either.
        if of_events < LEAST_SHARE {
            return *modes;
        }
        if of_modes < LEAST_SHARE {
            return *events;
        }
        Gaussian::mixture(&[of_modes, of_events], &[*modes, *events])
    }

    fn take(
        &mut self,
        plot: &Plot,
        modes: impl FnOnce(&mut Imm<3>) -> Result<Nis, UpdateError>,
        events: impl FnOnce(&mut Events<27>) -> Result<Nis, UpdateError>,
    ) -> Result<Nis, UpdateError> {
        let t = interval(self.time(), plot.time)?;
        let mut next = self.clone();
        let found = modes(&mut next.modes)?;
        let log = match events(&mut next.events) {
            Ok(_) => next.events.log_density(),
            // It begins again from what the other one knows.
            Err(_) => {
                next.events.replace(plot.time, &next.modes.estimate().state);
                f64::NEG_INFINITY
            }
        };
        next.choice.add(libm::pow(KEPT_PER_S, t), &[next.modes.log_density(), log]);
        *self = next;
        Ok(found)
    }
}

impl StateEstimator for Averaged {
    fn time(&self) -> SimTime {
        self.modes.time()
    }
    fn estimate(&self) -> Estimate {
        let state = self.both(&self.modes.estimate().state, &self.events.estimate().state);
        Estimate::new(self.time(), state)
    }
    fn predicted(&self, time: SimTime) -> Result<Estimate, UpdateError> {
        let (modes, events) = (self.modes.predicted(time)?, self.events.predicted(time)?);
        Ok(Estimate::new(time, self.both(&modes.state, &events.state)))
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
        let mut next = self.clone();
        next.modes.update_weighted(plots)?;
        if next.events.update_weighted(plots).is_err() {
            next.events.replace(next.modes.time(), &next.modes.estimate().state);
        }
        *self = next;
        Ok(())
    }
    fn replace(&mut self, time: SimTime, state: &Gaussian) {
        self.modes.replace(time, state);
        self.events.replace(time, state);
        self.choice = Choice::new(2);
    }
    fn start(&self) -> Start {
        self.modes.start()
    }
}

/// The rung `pair`.
pub const PAIR: Declared = Declared {
    word: "pair",
    about: "three kinds of motion and 27 histories, weighted",
    cost: 1_430,
    modes: Modes::mixed,
    histories: Some(0),
    start: |config, plot| {
        let filter = Averaged::from_plot(plot, Arc::clone(&config.modes), config.start)?;
        Ok(Estimator::Pair(Box::new(filter)))
    },
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::{DrawKey, Purpose, normal_pair};
    use crate::filter::testing::plot_at;
    use crate::frames::Vector2;

    /// What plots said minutes ago counts no more: two that began otherwise weigh their rungs alike in the end.
    #[test]
    fn what_was_said_long_ago_is_forgotten() {
        let draw = |k: u32| {
            let key = DrawKey { run_seed: 8, sensor: 1, entity: 0, scan: k.into() };
            let (a, b) = normal_pair(&mut key.rng(Purpose::Study));
            Vector2::new(a, b) * 2.0
        };
        let follow = |weaves: bool| {
            let modes = Arc::new(Modes::mixed());
            let first = plot_at(0.0, draw(0).x, draw(0).y, 4.0);
            let mut filter = Averaged::from_plot(&first, modes, Start::default()).expect("sound");
            let mut early = [0.0; 2];
            for k in 1..=300u32 {
                let t = f64::from(k);
                let aside = if weaves && k <= 100 { 25.0 * libm::sin(t / 4.0) } else { 0.0 };
                let at = Vector2::new(9.0 * t, aside) + draw(k);
                filter.update(&plot_at(t, at.x, at.y, 4.0)).expect("sound");
                if k == 100 {
                    early = filter.weights();
                }
            }
            (early, filter.weights())
        };
        let ((weaving, then), (straight, later)) = (follow(true), follow(false));
        println!("{weaving:?} {straight:?}, in the end {then:?} {later:?}");
        assert!((weaving[0] - straight[0]).abs() > 0.05, "{weaving:?} {straight:?}");
        assert!((then[0] - later[0]).abs() < 1e-3, "{then:?} {later:?}");
    }

    /// Events whose histories have broken fail at a plot and at several: the modes go on alone, and the events begin again from
    /// what these know.
    #[test]
    fn what_fails_begins_again_from_the_other_one() {
        let plot = |k: u32| plot_at(f64::from(k), 8.0 * f64::from(k), 0.3 * f64::from(k % 4), 4.0);
        let modes = Arc::new(Modes::mixed());
        let first = plot(0);
        let mut alone = Imm::<3>::from_plot(&first, Arc::clone(&modes), Start::default());
        let mut pair = Averaged::from_plot(&first, modes, Start::default()).expect("sound");
        let alone = alone.as_mut().expect("sound");
        for k in 1..=12 {
            alone.update(&plot(k)).expect("sound");
            pair.update(&plot(k)).expect("sound");
        }
        let weighed = pair.weights();
        assert!(weighed[1] > 0.01, "{weighed:?}");
        let mut broken = pair.events.estimate().state;
        broken.x[0] = broken.x[0] * f64::NAN;
        for several in [false, true] {
            let (mut alone, mut pair) = (alone.clone(), pair.clone());
            pair.events.replace(pair.time(), &broken);
            assert!(pair.events.clone().update(&plot(13)).is_err());
            if several {
                let (at, other) = (plot(13), plot_at(13.0, 110.0, 4.0, 4.0));
                let both = [(&at, 0.6), (&other, 0.3)];
                alone.update_weighted(&both).expect("sound");
                pair.update_weighted(&both).expect("the modes go on");
                assert_eq!(pair.weights(), weighed, "which plot it was says nothing of the rungs");
            } else {
                alone.update(&plot(13)).expect("sound");
                pair.update(&plot(13)).expect("the modes go on");
                assert!(pair.weights()[1] < 1e-9, "{:?}", pair.weights());
                assert_eq!(pair.estimate(), alone.estimate());
            }
            assert_eq!(pair.modes.estimate(), alone.estimate());
            let begun = pair.events.estimate();
            assert_eq!(begun.time, alone.time());
            assert!((begun.position_m() - alone.estimate().position_m()).norm() < 1e-9);
            // And go on as others do.
            for k in 14..=20 {
                pair.update(&plot(k)).expect("sound");
            }
            let off_m = pair.events.estimate().position_m() - plot(20).position_m;
            assert!(off_m.norm() < 2.0, "{off_m}");
        }
    }

    /// Twelve plots of a straight drive.
    fn driven() -> Averaged {
        let plot = |k: u32| plot_at(f64::from(k), 8.0 * f64::from(k), 0.3 * f64::from(k % 4), 4.0);
        let modes = Arc::new(Modes::mixed());
        let mut pair = Averaged::from_plot(&plot(0), modes, Start::default()).expect("sound");
        for k in 1..=12 {
            pair.update(&plot(k)).expect("sound");
        }
        pair
    }

    /// Whatever stands beside it: what a plot that is certain says of the rungs counts.
    #[test]
    fn a_plot_that_is_certain_is_an_ordinary_one() {
        let before = driven();
        let (own, other) = (plot_at(13.0, 103.0, 5.0, 4.0), plot_at(13.0, 140.0, -9.0, 4.0));
        let mut alone = before.clone();
        alone.update(&own).expect("sound");
        assert_ne!(alone.weights(), before.weights());
        for plots in
            [vec![(&own, 1.0)], vec![(&own, 1.0), (&other, 0.0)], vec![(&other, 0.0), (&own, 1.0)]]
        {
            let mut several = before.clone();
            several.update_weighted(&plots).expect("sound");
            assert_eq!(several.estimate(), alone.estimate());
            assert_eq!(several.weights(), alone.weights());
        }
    }

    /// What weighs less than a billionth is left out, to the bit.
    #[test]
    fn a_rung_of_no_weight_leaves_no_trace() {
        let mut pair = driven();
        let later = SimTime::from_s(13.5);
        let both = [pair.modes.estimate(), pair.events.estimate()];
        let ahead = [pair.modes.predicted(later), pair.events.predicted(later)]
            .map(|rung| rung.expect("later"));
        assert_ne!(both[0], both[1]);
        for (rung, logs) in [[0.0, -22.0], [-22.0, 0.0]].into_iter().enumerate() {
            pair.choice = Choice::new(2);
            pair.choice.add(1.0, &logs);
            assert_eq!(pair.estimate(), both[rung]);
            assert_eq!(pair.predicted(later).expect("later"), ahead[rung]);
        }
    }
}
