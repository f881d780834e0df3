//! `life = "existence"`: whether each track has a target, by what its sensors could see where it is.
//!
//! Plots and looks without one carry the probability on ([`crate::association::existence`]); it confirms tracks, weighs them in
//! clusters, and ends them. The detection is that of the place ([`crate::fusion::places`]), false plots are as rare as the
//! radar's cells are large there.

use super::updated::How;
use crate::association::existence::Existence;
use crate::filter::{Measurement, Nis};
use crate::fusion::config::SensorModel;
use crate::fusion::doubt::false_m2;
use crate::fusion::places::place_of;
use crate::fusion::state::{Tracker, Work};
use crate::fusion::track_file::Stage;
use crate::plot::Plot;

/// ln of the density (1/m²) of a plot that nothing foresaw: as likely anywhere within 50 m.
const UNFORESEEN: f64 = -8.97;

/// ln 2π.
const LN_TAU: f64 = 1.837_877_066_409_345_3;

impl Tracker {
    /// What a plot, with others or alone, says of whether its track has a target; before the track takes it.
    pub(in crate::fusion) fn believe(
        &mut self,
        index: usize,
        how: &How<'_>,
        plot: &Plot,
        model: &SensorModel,
    ) {
        let Some(rules) = self.config.life.existence else { return };
        let track = &self.tracks[index];
        let Some(doubt) = &track.doubt else { return };
        let place = place_of(plot.sensor, plot.position_m);
        let detection = self.places.detection(&place, model.detection);
        let strength = self.config.log_strength(plot, model);
        let missed = match how {
            How::Weighted { plots, .. } => 1.0 - plots.iter().map(|(_, beta)| beta).sum::<f64>(),
            How::Manoeuvre | How::Restart(_) => {
                missed(doubt.existence, detection, UNFORESEEN + strength, false_m2(plot, model))
            }
            How::Plot => {
                let measured = Measurement::of(plot).ok();
                let nis = measured.and_then(|m| self.distance(track, plot.time, plot, &m));
                let density = nis.map_or(UNFORESEEN, |nis| log_density(&nis));
                missed(doubt.existence, detection, density + strength, false_m2(plot, model))
            }
        };
        let track = &mut self.tracks[index];
        let leaving = track.evidence.took_off.is_some();
        let Some(doubt) = &mut track.doubt else { return };
        doubt.survive(plot.time, leaving, &rules);
        doubt.look((plot.sensor, model.detection), missed, detection);
    }

    /// How much more (ln) a plot speaks for each confirmed track than if it were certain to be there and seen as the sensor
    /// states; of all tracks by index, empty where lives go by counts.
    pub(in crate::fusion) fn weigh_existence(&self, model: &SensorModel, work: &mut Work) {
        work.shifts.clear();
        if self.config.life.existence.is_none() {
            return;
        }
        let stated = model.detection.clamp(1e-6, 1.0 - 1e-6);
        let gate = self.config.gates.probability.clamp(0.0, 1.0);
        let usual = libm::log(stated) - libm::log1p(-stated * gate);
        work.shifts.tracks.extend(self.tracks.iter().map(|track| match &track.doubt {
            Some(doubt) if track.stage == Stage::Confirmed => {
                let place = place_of(model.id, track.filter().motion().0);
                let seen = self.places.detection(&place, model.detection) * gate;
                let there = libm::log((doubt.existence.there() * seen).max(1e-12));
                there - doubt.existence.log_miss(seen) - usual
            }
            _ => 0.0,
        }));
    }

    /// The same by the strength of each plot of the batch `from..to`; empty where that is not asked for.
    pub(in crate::fusion) fn weigh_strength(
        &self,
        from: usize,
        to: usize,
        model: &SensorModel,
        work: &mut Work,
    ) {
        let Work { shifts, candidates, .. } = work;
        shifts.plots.clear();
        if self.config.amplitude && model.strength.is_some() {
            let plots = candidates[from..to].iter().map(|c| &c.plot);
            shifts.plots.extend(plots.map(|plot| self.config.log_strength(plot, model)));
        }
    }
}

/// Probability that the only plot of a track is not its own.
fn missed(existence: Existence, detection: f64, log_density: f64, false_m2: f64) -> f64 {
    let pair = existence.log_pair(detection, log_density, false_m2);
    1.0 / (1.0 + libm::exp(pair - existence.log_miss(detection)))
}

/// ln of the density of a plot at this distance, 1/m²; of one that measures one direction, as of a strip of 20 m.
fn log_density(nis: &Nis) -> f64 {
    let strip = if nis.dof == 1 { -libm::log(20.0) } else { 0.0 };
    -0.5 * (nis.d2 + nis.ln_det() + f64::from(nis.dof) * LN_TAU) + strip
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::association::amplitude::AmplitudeLaw;
    use crate::filter::testing::plot_at;
    use crate::flight_list::FlightList;
    use crate::fusion::buffers::Candidate;
    use crate::fusion::config::{ExistenceRules, TrackingConfig};
    use crate::fusion::track_file::Track;
    use crate::fusion::weights::Shifts;
    use crate::plot::{SensorId, SensorKind};
    use crate::time::SimTime;

    #[test]
    fn a_plot_is_missed_as_the_other_plots_of_the_field_are_likelier() {
        // Half sure, seen in 0.8 of looks: 0.4 · density against 0.6 · false plots.
        let existence = Existence::of(0.5);
        for (density, false_m2) in [(1e-3, 1e-5), (1e-5, 1e-5), (1e-7, 1e-3)] {
            let found = missed(existence, 0.8, libm::log(density), false_m2);
            let expected = 0.6 * false_m2 / (0.6 * false_m2 + 0.4 * density);
            assert!((found - expected).abs() < 1e-12, "{density} {false_m2}: {found}");
        }
        let both = Nis { d2: 3.0, det: 16.0, dof: 2 };
        let density = libm::exp(-1.5) / (std::f64::consts::TAU * 4.0);
        assert!((log_density(&both) - libm::log(density)).abs() < 1e-12);
        let line = Nis { dof: 1, ..both };
        let density = libm::exp(-1.5) / (std::f64::consts::TAU.sqrt() * 4.0 * 20.0);
        assert!((log_density(&line) - libm::log(density)).abs() < 1e-12);
        assert!((UNFORESEEN + libm::log(std::f64::consts::PI * 2_500.0)).abs() < 0.01);
    }

    #[test]
    fn plots_speak_for_a_track_as_it_exists_and_is_seen() {
        let mut config = TrackingConfig::paper();
        let mut tracker = Tracker::new(config.clone());
        let model = tracker.config.sensor(SensorId(1), SensorKind::Asde);
        let shifts = Shifts { tracks: vec![7.0], plots: vec![] };
        let mut work = Work { shifts, ..Work::default() };
        tracker.weigh_existence(&model, &mut work);
        assert!(work.shifts.tracks.is_empty(), "lives go by counts");
        config.life.existence = Some(ExistenceRules::default());
        tracker = Tracker::new(config);
        for k in 1..=20 {
            let t = f64::from(k);
            let plots = [
                plot_at(t - 0.5, 8.0 * t, 0.0, 1.0),
                Plot { sequence: 1, ..plot_at(t - 0.5, 8.0 * t, 900.0, 1.0) },
            ];
            let plots = if k < 20 { &plots[..1] } else { &plots[..] };
            tracker.scan(SimTime::from_s(t), plots, &FlightList::default());
        }
        assert_eq!(
            tracker.tracks.iter().map(|t| t.stage).collect::<Vec<_>>(),
            [Stage::Confirmed, Stage::Tentative]
        );
        let gate = tracker.config.gates.probability;
        let place = place_of(model.id, tracker.tracks[0].filter().motion().0);
        for there in [1.0, 0.5, 1e-3] {
            tracker.tracks[0].doubt.as_mut().expect("by existence").existence =
                Existence::of(there);
            tracker.weigh_existence(&model, &mut work);
            let seen = tracker.places.detection(&place, model.detection) * gate;
            let pair = there * seen / (1.0 - there * seen);
            let usual = model.detection / (1.0 - model.detection * gate);
            let expected = libm::log(pair / usual);
            assert!(
                (work.shifts.tracks[0] - expected).abs() < 1e-9,
                "{there}: {} for {expected}",
                work.shifts.tracks[0]
            );
            assert_eq!(work.shifts.tracks[1], 0.0, "on trial");
        }
    }

    /// Two tracks that differ in the strength of their echoes alone: the strong one is there sooner, the weak one later, and the shift
    /// of each plot in association is what the law says; without the switch nothing is.
    #[test]
    fn strong_echoes_speak_for_a_target_and_weak_ones_against_it() {
        let law = AmplitudeLaw { threshold: 18.0, noise: 1.0 };
        let mut config = TrackingConfig::paper();
        config.life.existence = Some(ExistenceRules::default());
        let kind = SensorKind::Asde;
        let told =
            SensorModel { strength: Some(law), ..SensorModel::default_of(SensorId(1), kind) };
        config.sensors = vec![told];
        let doubts = |amplitude: bool, scans: u32| {
            let mut tracker = Tracker::new(TrackingConfig { amplitude, ..config.clone() });
            for k in 1..=scans {
                let t = f64::from(k);
                let plot = |sequence: u32, db: f64| Plot {
                    sensor: SensorId(1),
                    sequence,
                    scnr_db: Some(db),
                    ..plot_at(t - 0.5, 8.0 * t, 900.0 * f64::from(sequence), 1.0)
                };
                let plots = [plot(0, 12.6), plot(1, 25.0)];
                tracker.scan(SimTime::from_s(t), &plots, &FlightList::default());
            }
            let there = |t: &Track| t.doubt.as_ref().expect("by existence").existence.there();
            tracker.tracks.iter().map(there).collect::<Vec<_>>()
        };
        for scans in [1, 2] {
            let (alike, apart) = (doubts(false, scans), doubts(true, scans));
            assert!(alike.len() == 2 && (alike[0] - alike[1]).abs() < 1e-9, "{alike:?}");
            assert!(apart[0] < alike[0] && apart[1] > alike[1], "{apart:?} {alike:?}");
        }
        // One false plot in so many is as strong: births are 30 times and 0.3 times as many.
        let (born, all) = (doubts(true, 1), doubts(false, 1)[0]);
        let odds = |r: f64| r / (1.0 - r);
        assert!((odds(born[1]) / odds(all) - 30.0).abs() < 1e-6, "{born:?} {all}");
        assert!((odds(born[0]) / odds(all) - 0.3).abs() < 1e-6, "{born:?} {all}");

        let candidates = [12.6, 25.0].map(|db| {
            let plot =
                Plot { sensor: SensorId(1), scnr_db: Some(db), ..plot_at(0.5, 0.0, 0.0, 1.0) };
            Candidate { plot, index: 0 }
        });
        let mut work = Work { candidates: candidates.to_vec(), ..Work::default() };
        for (amplitude, model, shifts) in [
            (true, told, vec![libm::log(30.0)]),
            (false, told, vec![]),
            (true, SensorModel { strength: None, ..told }, vec![]),
        ] {
            let tracker = Tracker::new(TrackingConfig { amplitude, ..config.clone() });
            tracker.weigh_strength(1, 2, &model, &mut work);
            assert_eq!(work.shifts.plots, shifts);
        }
    }
}
