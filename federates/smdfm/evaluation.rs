//! Measures of plots and tracks against the truth that the sensors received.
//!
//! `raw_rmse_m`: ASDE plots of moving targets, at the plot's own time, that updated a confirmed track, without the gross ones.
//! `gross_plots` counts those: farther than [`Rules::pair_m`] from their target, as a report must not be either, however many
//! they are (echoes of a pulse before the last make tracks of their own), or far beyond the others ([`models::score::robust`]);
//! `rmse_m`: that track's state just after the update, same plots; `published_rmse_m`: the published
//! (predicted) tracks at publication time against the entity that most of their plots came from;
//! `settled_rmse_m`: the same without the first three reports of each stretch of one track on one entity, and the last;
//! `settled_nees`: squared error over the covariance stated, two degrees of freedom, same reports.
//! `second_ago_rmse_m`: the same tracks one scan earlier, as the next scan's plots revise them.
//! A report farther than [`Rules::pair_m`] from the entity that its plots came from is false, as for `seeds score`:
//! `far_reports` counts them, no error holds them.

use super::received_truth::View;
use models::frames::{Vector2, wrap_pi};
use models::fusion::Outcome;
use models::plot::{SensorId, SensorKind};
use models::score::robust::Robust;
use models::score::run::Rules;
use models::sensors::{PlotSink, Truth};
use models::time::SimTime;
use models::track::{SystemTrack, TrackStatus};
use std::collections::{BTreeMap, BTreeSet};

/// Slower targets are standing, m/s.
const MOVING_MPS: f64 = 1.0;

/// A leg is straight while the target turns less than this, rad/s, and moves faster than [`STRAIGHT_MPS`].
const STRAIGHT_RAD_PER_S: f64 = 0.01;
const STRAIGHT_MPS: f64 = 3.0;

/// Sum of squares.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct MeanSquare {
    sum: f64,
    count: u64,
}

impl MeanSquare {
    fn add(&mut self, squared: f64) {
        self.sum += squared;
        self.count += 1;
    }
    fn mean(&self) -> f64 {
        if self.count == 0 { f64::NAN } else { self.sum / self.count as f64 }
    }
    fn root(&self) -> f64 {
        if self.count == 0 { f64::NAN } else { (self.sum / self.count as f64).sqrt() }
    }
}

/// Reports at the beginning of a stretch that are not settled yet.
const ACQUISITION: u32 = 3;

/// Reports of one track on one entity, without a gap.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    key: u64,
    reports: u32,
    /// Squared error, m², and normalised, of the latest report: it counts if another one follows.
    latest: (f64, f64),
}

/// Running measures of a run.
#[derive(Clone, Debug, Default)]
pub struct Evaluation {
    /// Of plots and of the tracks just after them: sums of squares, and the same on straight legs with their count.
    updates: Robust<5>,
    /// Plots too far from their target to be of its position.
    far_plots: u64,
    /// Reports that are none of their entity.
    far_reports: u64,
    published: MeanSquare,
    settled: MeanSquare,
    settled_nees: MeanSquare,
    /// Stretches that are going on, by track number.
    stretches: BTreeMap<u16, Stretch>,
    second_ago: MeanSquare,
    looks: BTreeMap<SensorKind, (u64, u64)>,
    plots: BTreeMap<SensorKind, u64>,
    confirmed: u64,
    now_confirmed: u64,
    false_plots: u64,
    /// Reports with a label, and those with that of another.
    labels: u64,
    wrong_labels: u64,
    outsiders_now: u64,
    /// Track number → key of the entity whose plots it takes.
    follows: BTreeMap<u16, u64>,
    /// Sensors of somebody else: nobody knows what caused their plots.
    strangers: BTreeSet<SensorId>,
}

impl Evaluation {
    /// Nothing measured yet, where the plots of `strangers` come from outside.
    #[must_use]
    pub fn beside(strangers: BTreeSet<SensorId>) -> Self {
        Self { strangers, ..Self::default() }
    }

    /// Adds one scan. `looks`: per sensor its kind, looks and plots.
    pub fn scan(
        &mut self,
        view: &View<'_>,
        to: SimTime,
        sink: &PlotSink,
        outcomes: &[Outcome],
        tracks: &[SystemTrack],
        looks: &[(SensorKind, u64, usize)],
    ) {
        for (kind, looked, plots) in looks {
            let sum = self.looks.entry(*kind).or_default();
            sum.0 += looked;
            *self.plots.entry(*kind).or_default() += *plots as u64;
        }
        for ((plot, cause), outcome) in sink.plots.iter().zip(&sink.causes).zip(outcomes) {
            let Some(key) = cause.key else {
                self.false_plots += u64::from(!self.strangers.contains(&plot.sensor));
                continue;
            };
            self.looks.entry(plot.kind).or_default().1 += 1;
            let Outcome::Used { number: Some(number), position_m, .. } = outcome else { continue };
            self.follows.insert(*number, key);
            if !plot.kind.radar {
                continue;
            }
            let Some(index) = view.index_of(key) else { continue };
            let Some(truth) = view.at(index, plot.time) else { continue };
            if truth.velocity_mps.xy().norm() < MOVING_MPS {
                continue;
            }
            let raw = (plot.position_m - truth.position_m.xy()).norm_squared();
            let tracked = (position_m - truth.position_m.xy()).norm_squared();
            if !(raw.sqrt() <= Rules::default().pair_m) {
                self.far_plots += 1;
                continue;
            }
            let straight = f64::from(u8::from(is_straight(view, index, plot.time)));
            let sums = [raw, tracked, straight * raw, straight * tracked, straight];
            self.updates.add(raw.sqrt(), sums);
        }
        self.now_confirmed = 0;
        self.outsiders_now = (0..view.len()).filter(|i| !view.is_ours(*i)).count() as u64;
        for track in tracks {
            if track.first {
                self.confirmed += 1;
            }
            if track.status == TrackStatus::Last {
                self.follows.remove(&track.number);
                self.stretches.remove(&track.number);
                continue;
            }
            self.now_confirmed += 1;
            let Some((index, distance_m)) = self.truth_of(view, track, to) else {
                self.stretches.remove(&track.number);
                continue;
            };
            if !(distance_m <= Rules::default().pair_m) {
                self.far_reports += 1;
                self.stretches.remove(&track.number);
                continue;
            }
            self.published.add(distance_m * distance_m);
            if let Some(truth) = view.at(index, to) {
                self.settle(view.key(index), track, track.position_m - truth.position_m.xy());
            }
            if let Some(callsign) = track.callsign() {
                self.labels += 1;
                self.wrong_labels += u64::from(callsign != view.callsign(index));
            }
            let near = |error_m: &f64| *error_m <= Rules::default().pair_m;
            if let Some(error_m) = self.lag_error_m(view, track).filter(near) {
                self.second_ago.add(error_m * error_m);
            }
        }
    }

    /// One more report of a track on the entity of this key, with its error.
    fn settle(&mut self, key: u64, track: &SystemTrack, error_m: Vector2<f64>) {
        let p = track.position_cov_m2;
        let det = p[(0, 0)] * p[(1, 1)] - p[(0, 1)] * p[(1, 0)];
        let nees = (p[(1, 1)] * error_m.x * error_m.x + p[(0, 0)] * error_m.y * error_m.y
            - (p[(0, 1)] + p[(1, 0)]) * error_m.x * error_m.y)
            / det;
        let latest = (error_m.norm_squared(), nees);
        let before = self.stretches.get(&track.number).filter(|s| s.key == key).copied();
        if let Some(before) = before.filter(|s| s.reports > ACQUISITION) {
            self.settled.add(before.latest.0);
            self.settled_nees.add(before.latest.1);
        }
        let reports = before.map_or(1, |s| s.reports + 1);
        self.stretches.insert(track.number, Stretch { key, reports, latest });
    }

    /// Index of the entity that a track follows, and its distance to it at `to`, m.
    #[must_use]
    pub fn truth_of(
        &self,
        view: &View<'_>,
        track: &SystemTrack,
        to: SimTime,
    ) -> Option<(usize, f64)> {
        let index = view.index_of(*self.follows.get(&track.number)?)?;
        let truth = view.at(index, to)?;
        Some((index, (track.position_m - truth.position_m.xy()).norm()))
    }

    /// Distance of a track one scan ago, as it is known now, from the entity that it follows, m.
    #[must_use]
    pub fn lag_error_m(&self, view: &View<'_>, track: &SystemTrack) -> Option<f64> {
        let lag = track.second_ago.as_ref()?;
        let index = view.index_of(*self.follows.get(&track.number)?)?;
        let truth = view.at(index, lag.time)?;
        Some((lag.position_m - truth.position_m.xy()).norm())
    }

    /// Named measures: "rmse_m", "pd_asde", "plots_gps", …; NaN where there is nothing to measure.
    #[must_use]
    pub fn values(&self) -> Vec<(String, f64)> {
        let updates = self.updates.kept();
        let [raw, tracked, straight_raw, straight_tracked, straight] = updates.sums;
        // NaN where there is nothing.
        let root = |sum: f64, count: f64| (sum / count).sqrt();
        let count = updates.count as f64;
        let mut values = vec![
            ("tracks_confirmed".to_owned(), self.confirmed as f64),
            ("tracks_now".to_owned(), self.now_confirmed as f64),
            ("raw_rmse_m".to_owned(), root(raw, count)),
            ("rmse_m".to_owned(), root(tracked, count)),
            ("straight_raw_rmse_m".to_owned(), root(straight_raw, straight)),
            ("straight_rmse_m".to_owned(), root(straight_tracked, straight)),
            ("gross_plots".to_owned(), (self.far_plots + updates.left_out) as f64),
            ("far_reports".to_owned(), self.far_reports as f64),
            ("published_rmse_m".to_owned(), self.published.root()),
            ("settled_rmse_m".to_owned(), self.settled.root()),
            ("settled_nees".to_owned(), self.settled_nees.mean()),
            ("second_ago_rmse_m".to_owned(), self.second_ago.root()),
            ("false_plots".to_owned(), self.false_plots as f64),
            ("labels".to_owned(), self.labels as f64),
            ("wrong_labels".to_owned(), self.wrong_labels as f64),
            ("outsiders_now".to_owned(), self.outsiders_now as f64),
        ];
        let other = |kind: SensorKind| {
            ![SensorKind::Asde, SensorKind::Gps, SensorKind::Dgps].contains(&kind)
        };
        for (kind, plots) in &self.plots {
            values.push((format!("plots_{}", kind.word), *plots as f64));
        }
        let others = self.plots.iter().filter(|(k, _)| other(**k)).map(|(_, n)| *n).sum::<u64>();
        values.push(("plots_other".to_owned(), others as f64));
        for (kind, (looks, reports)) in &self.looks {
            if *looks > 0 {
                let pd = *reports as f64 / *looks as f64;
                values.push((format!("pd_{}", kind.word), pd));
            }
        }
        values
    }
}

/// Whether a target moves straight on around `time`.
fn is_straight(view: &View<'_>, index: usize, time: SimTime) -> bool {
    let (Some(now), Some(before)) = (view.at(index, time), view.at(index, time.plus_s(-0.5)))
    else {
        return false;
    };
    let course = |v: &models::sensors::TargetState| libm::atan2(v.velocity_mps.x, v.velocity_mps.y);
    now.velocity_mps.xy().norm() > STRAIGHT_MPS
        && before.velocity_mps.xy().norm() > STRAIGHT_MPS
        && wrap_pi(course(&now) - course(&before)).abs() < STRAIGHT_RAD_PER_S * 0.5
}
