//! The doubt in a track: whether it has a target, from its first plot to its end, and where targets come into view.

use super::config::{ExistenceRules, SensorModel};
use super::own::Trial;
use super::places::{Place, Places, place_of};
use crate::association::existence::Existence;
use crate::flight_list::FlightList;
use crate::frames::{Point2, Vector2};
use crate::plot::{Plot, SensorId};
use crate::time::SimTime;

/// What is kept of the doubt in a track.
#[derive(Clone, Debug)]
pub(super) struct Doubt {
    /// Whether it has a target.
    pub(super) existence: Existence,
    /// Until when its survival has been counted.
    at: SimTime,
    /// The sensor that saw it last, and what that states of its detection.
    sensor: (SensorId, f64),
    /// Looks without a plot since the last one with: counted when it is seen again, so that what has ended blinds no place.
    unseen: Vec<Place>,
    /// The scan's look has been counted already, by plots that are hardly its own.
    weighed: bool,
}

/// Looks without a plot that are remembered.
const MOST_UNSEEN: usize = 64;

/// False plots of a radar lie as densely as assumed at this distance, m; its cells grow with it.
const MEAN_RANGE_M: f64 = 2_500.0;

/// False plots where this one lies, 1/m² and look.
pub(super) fn false_m2(plot: &Plot, model: &SensorModel) -> f64 {
    let nearer = plot.polar.map_or(1.0, |polar| MEAN_RANGE_M / polar.range_m.max(1.0));
    model.false_density_m2 * nearer.clamp(0.25, 10.0)
}

/// Places where targets come into view, of this scan.
#[derive(Clone, Debug, Default)]
pub(super) struct Entrances {
    stands_m: Vec<Point2<f64>>,
    /// Thresholds with the direction of the final and its length, m.
    finals: Vec<(Point2<f64>, Vector2<f64>, f64)>,
}

impl Entrances {
    /// As the flight list has them.
    pub(super) fn fill(&mut self, flights: &FlightList, length_m: f64) {
        self.stands_m.clear();
        self.stands_m.extend(flights.entries.iter().filter_map(|e| e.stand_m));
        self.finals.clear();
        for (_, [threshold, end]) in &flights.runways {
            let back = threshold - end;
            if back.norm() > 1.0 {
                self.finals.push((*threshold, back.normalize(), length_m));
            }
        }
    }

    fn hold(&self, place: Point2<f64>, radius_m: f64) -> bool {
        let on_final = |(threshold, back, length): &(Point2<f64>, Vector2<f64>, f64)| {
            let from = place - threshold;
            let way = from.dot(back);
            (0.0..=*length).contains(&way) && from.perp(back).abs() <= 1.5 * radius_m
        };
        self.stands_m.iter().any(|stand| (stand - place).norm() <= radius_m)
            || self.finals.iter().any(on_final)
    }
}

impl Doubt {
    /// Of a track that this plot begins; `log_strength`: ln of how much likelier it is of a target than of noise.
    pub(super) fn born(
        plot: &Plot,
        model: &SensorModel,
        rules: &ExistenceRules,
        entrances: &Entrances,
        log_strength: f64,
    ) -> Self {
        let likely = entrances.hold(plot.position_m, rules.entrance_radius_m);
        let births = rules.births_m2 * if likely { rules.at_entrances } else { 1.0 };
        let births = births * libm::exp(log_strength);
        Self {
            existence: Existence::born(1.0, births, false_m2(plot, model)),
            at: plot.time,
            sensor: (plot.sensor, model.detection),
            unseen: Vec::new(),
            weighed: false,
        }
    }

    /// Of a track that is taken over as sure.
    pub(super) fn sure(plot: &Plot, model: &SensorModel) -> Self {
        Self {
            existence: Existence::of(1.0),
            at: plot.time,
            sensor: (plot.sensor, model.detection),
            unseen: Vec::new(),
            weighed: false,
        }
    }

    /// Time has gone by; `leaving`: it goes where nothing is seen.
    pub(super) fn survive(&mut self, now: SimTime, leaving: bool, rules: &ExistenceRules) {
        let lasts_s = if leaving { rules.leaving_s } else { rules.survival_s };
        let gone_s = now.since_s(self.at);
        if gone_s > 0.0 {
            self.existence = self.existence.survived(libm::exp(-gone_s / lasts_s));
            self.at = now;
        }
    }

    /// A look of `sensor` brought plots of which none is its own with probability `missed`.
    pub(super) fn look(&mut self, sensor: (SensorId, f64), missed: f64, detection: f64) {
        self.existence = self.existence.after(missed, detection);
        if missed < 0.5 {
            self.sensor = sensor;
        } else {
            self.weighed = true;
        }
    }

    /// A look at `position_m` was due and brought nothing.
    pub(super) fn miss(&mut self, position_m: Point2<f64>, places: &Places) {
        if std::mem::take(&mut self.weighed) {
            return;
        }
        let place = place_of(self.sensor.0, position_m);
        self.existence = self.existence.after(1.0, places.detection(&place, self.sensor.1));
        if self.unseen.len() < MOST_UNSEEN {
            self.unseen.push(place);
        }
    }

    /// It was seen in this scan: what was not seen before counts now.
    pub(super) fn seen(&mut self, position_m: Point2<f64>, places: &mut Places) {
        self.weighed = false;
        self.unseen.drain(..).for_each(|place| places.learn(place, false));
        places.learn(place_of(self.sensor.0, position_m), true);
    }

    /// Whether there is hardly a target any more.
    pub(super) fn is_over(&self, rules: &ExistenceRules) -> bool {
        self.existence.there() < rules.end
    }

    /// What becomes of a track on trial.
    pub(super) fn judge(&self, rules: &ExistenceRules) -> Trial {
        let there = self.existence.there();
        if there >= rules.confirm {
            Trial::Confirmed
        } else if there < rules.drop {
            Trial::Dropped
        } else {
            Trial::Goes
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::testing::plot_at;
    use crate::plot::{Polar, SensorKind};

    fn plot(range_m: f64) -> Plot {
        let polar = Some(Polar {
            range_m,
            azimuth_rad: 0.0,
            sigma_range_m: 1.0,
            sigma_azimuth_rad: 1e-3,
            extent_m2: None,
        });
        Plot { polar, ..plot_at(0.0, range_m, 0.0, 2.0) }
    }

    /// Cells are as wide as they are far: as many false plots in each are rarer per square metre out there.
    #[test]
    fn false_plots_are_as_dense_as_cells_are() {
        let model = SensorModel::default_of(SensorId(1), SensorKind::Asde);
        let at = |range_m: f64| false_m2(&plot(range_m), &model);
        assert!((at(2_500.0) / model.false_density_m2 - 1.0).abs() < 1e-12);
        assert!((at(1_250.0) / at(5_000.0) - 4.0).abs() < 1e-9);
        let unseen = Plot { polar: None, ..plot(100.0) };
        assert!((false_m2(&unseen, &model) / model.false_density_m2 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn false_plots_are_ten_times_as_dense_at_most_and_a_quarter_at_least() {
        let model = SensorModel::default_of(SensorId(1), SensorKind::Asde);
        for (range_m, ratio) in
            [(1.0, 10.0), (200.0, 10.0), (0.0, 10.0), (500.0, 5.0), (10_000.0, 0.25), (9e5, 0.25)]
        {
            let found = false_m2(&plot(range_m), &model) / model.false_density_m2;
            assert!((found - ratio).abs() < 1e-9, "{range_m}: {found}");
        }
    }

    #[test]
    fn targets_come_into_view_at_stands_and_on_final() {
        let mut flights = FlightList::default();
        let (threshold, end) = (Point2::new(100.0, 0.0), Point2::new(2_100.0, 0.0));
        flights.runways.push(("09".into(), [threshold, end]));
        flights.runways.push(("none".into(), [end, end]));
        let mut entrances = Entrances::default();
        entrances.fill(&flights, 3_000.0);
        entrances.stands_m.push(Point2::new(0.0, 500.0));
        for (x, y, held) in [
            (0.0, 540.0, true),
            (0.0, 540.1, false),
            (28.0, 472.0, true),
            (100.0, 60.0, true),
            (100.0, -60.1, false),
            (-2_900.0, -60.0, true),
            (-2_901.0, 0.0, false),
            (101.0, 0.0, false),
            (2_150.0, 0.0, false),
        ] {
            assert_eq!(entrances.hold(Point2::new(x, y), 40.0), held, "{x} {y}");
        }
        entrances.fill(&FlightList::default(), 3_000.0);
        assert!(!entrances.hold(Point2::new(0.0, 0.0), 40.0));
    }

    #[test]
    fn a_track_lasts_as_long_as_targets_do_and_is_judged_by_what_is_left() {
        let model = SensorModel::default_of(SensorId(1), SensorKind::Asde);
        let rules = ExistenceRules::default();
        let mut doubt = Doubt::sure(&plot(1_000.0), &model);
        assert_eq!((doubt.judge(&rules), doubt.is_over(&rules)), (Trial::Confirmed, false));
        doubt.survive(SimTime::from_s(60.0), false, &rules);
        let there = libm::exp(-0.1);
        assert!((doubt.existence.there() - there).abs() < 1e-12);
        assert_eq!(doubt.judge(&rules), Trial::Goes);
        // Nothing more in the same time, nor before it; who leaves, leaves soon.
        doubt.survive(SimTime::from_s(60.0), false, &rules);
        doubt.survive(SimTime::from_s(10.0), true, &rules);
        assert!((doubt.existence.there() - there).abs() < 1e-12);
        doubt.survive(SimTime::from_s(100.0), true, &rules);
        assert!((doubt.existence.there() - there * libm::exp(-2.0)).abs() < 1e-12);
        for (there, trial, over) in [
            (0.999, Trial::Confirmed, false),
            (0.998_9, Trial::Goes, false),
            (1e-3, Trial::Goes, false),
            (9.9e-4, Trial::Goes, true),
            (1e-4, Trial::Goes, true),
            (9.9e-5, Trial::Dropped, true),
        ] {
            doubt.existence = Existence::of(there);
            assert_eq!((doubt.judge(&rules), doubt.is_over(&rules)), (trial, over), "{there}");
        }
    }

    #[test]
    fn a_look_that_was_weighed_is_not_missed_again() {
        let model = SensorModel::default_of(SensorId(1), SensorKind::Asde);
        let places = Places::default();
        let mut doubt = Doubt::sure(&plot(1_000.0), &model);
        doubt.existence = Existence::of(0.9);
        let expected = doubt.existence.after(0.6, 0.8);
        // A plot that is hardly its own: this scan's look is counted, the next is due again.
        doubt.look((SensorId(7), 0.5), 0.6, 0.8);
        assert_eq!(doubt.existence, expected);
        doubt.miss(Point2::origin(), &places);
        assert_eq!(doubt.existence, expected);
        doubt.miss(Point2::origin(), &places);
        assert_eq!(doubt.existence, expected.after(1.0, model.detection.clamp(0.01, 0.999)));
        // By the sensor that saw it last, for what that states.
        doubt.look((SensorId(7), 0.5), 0.4, 0.8);
        let before = doubt.existence;
        doubt.miss(Point2::origin(), &places);
        assert_eq!(doubt.existence, before.after(1.0, 0.5));
        assert_eq!(doubt.unseen.last(), Some(&place_of(SensorId(7), Point2::origin())));
        for _ in 0..200 {
            doubt.miss(Point2::origin(), &places);
        }
        assert_eq!(doubt.unseen.len(), MOST_UNSEEN);
    }

    /// A place blinds where a target was that is seen again; of one that is not, nobody knows whether it was there.
    #[test]
    fn looks_without_a_plot_count_when_the_target_is_seen_again() {
        let model = SensorModel::default_of(SensorId(1), SensorKind::Asde);
        let (dark, light) = (Point2::new(50.0, 50.0), Point2::new(450.0, 50.0));
        let of = |seen_again: bool| {
            let mut places = Places::default();
            for _ in 0..20 {
                let mut doubt = Doubt::sure(&plot(1_000.0), &model);
                for _ in 0..4 {
                    doubt.miss(dark, &places);
                }
                if seen_again {
                    doubt.seen(light, &mut places);
                }
            }
            [dark, light].map(|at| places.detection(&place_of(SensorId(1), at), 0.9))
        };
        let [behind, before] = of(true);
        assert!(behind < 0.15 && before > 0.9, "{behind} {before}");
        assert_eq!(of(false), [0.9; 2]);
    }

    /// A new track is one of a target as new targets are to false plots, and where they come into view more likely.
    #[test]
    fn a_birth_is_as_likely_as_new_targets_are_to_false_plots() {
        let model = SensorModel::default_of(SensorId(1), SensorKind::Asde);
        let rules = ExistenceRules::default();
        let seen = plot(2_500.0);
        let mut entrances = Entrances::default();
        for more in [1.0, rules.at_entrances] {
            let born = Doubt::born(&seen, &model, &rules, &entrances, 0.0).existence.there();
            let births = more * rules.births_m2;
            let wanted = births / (births + model.false_density_m2.max(1e-12));
            assert!((born / wanted - 1.0).abs() < 1e-9, "{more}: {born} {wanted}");
            entrances.stands_m.push(seen.position_m);
        }
    }
}
