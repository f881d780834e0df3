//! Scoring of a whole run: reports against the truth, area by area.
//!
//! Each scan pairs reports with targets: a pair of the scan before stays while it is nearer than the
//! cut-off, the rest is paired at the least sum of squared distances (Bernardin and Stiefelhagen,
//! EURASIP J. on Image and Video Processing 2008, for the order). So two targets that pass each
//! other are a swap only if the tracks really change places.

use super::areas::{Area, AreaMap};
use super::recording::{Recording, Report, TruthPoint};
use super::sets::{Gospa, gospa};
use crate::frames::{Point2, Vector2, wrap_pi};
use crate::time::SimTime;
use std::collections::BTreeMap;

/// How a run is scored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Time between two scans, s.
    pub scan_s: f64,
    /// Cut-off of GOSPA and of pairs that stay, m.
    pub cut_off_m: f64,
    /// Farther off a report belongs to no target, m.
    pub pair_m: f64,
    /// Slower targets have no course, m/s.
    pub course_from_mps: f64,
    /// Truth is interpolated over holes of at most this, s.
    pub hole_s: f64,
    /// For so long after the truth of its target has ended a report is counted by itself as well, s: a track coasts, as
    /// continuity asks, and cannot know that the recording of its target is over. No requirement is judged by that.
    pub after_end_s: f64,
}

impl Default for Rules {
    /// One scan a second, 20 m, 60 m (beyond which ED-117A calls a report false), 3 m/s, 2.5 s, 15 s (the
    /// longest gap that ED-117A speaks of).
    fn default() -> Self {
        Self {
            scan_s: 1.0,
            cut_off_m: 20.0,
            pair_m: 60.0,
            course_from_mps: 3.0,
            hole_s: 2.5,
            after_end_s: 15.0,
        }
    }
}

/// One stay of a target in an area: which of its scans had a report. A hole over a border is one in each of both stays.
#[derive(Clone, Debug, Default, PartialEq)]
struct Stay {
    scans: u32,
    /// Lengths of the runs of scans without a report.
    holes: Vec<u32>,
}

/// What was found in one area.
#[derive(Clone, Debug, PartialEq)]
pub struct AreaScore {
    /// The area.
    pub area: Area,
    /// Position errors, m, sorted.
    pub position_m: Vec<f64>,
    /// Errors of the speed and true speeds, m/s.
    pub speed: Vec<(f64, f64)>,
    /// Course errors, rad, sorted.
    pub course_rad: Vec<f64>,
    /// Distances of all reports to the nearest target, m, sorted.
    pub nearest_target_m: Vec<f64>,
    /// Of these those of tracks whose target has just ended (see [`Rules::after_end_s`]), m, sorted.
    pub after_end_m: Vec<f64>,
    /// Scans of targets before their first report anywhere.
    pub before_first: u64,
    /// Scans of targets without a report.
    pub unreported: u64,
    /// How far reports are behind along the path, s, each.
    pub behind_s: Vec<f64>,
    /// Paired reports of targets with a name.
    pub labels_due: u64,
    /// Of these with the right label.
    pub right_labels: u64,
    /// Of these with a wrong label.
    pub wrong_labels: u64,
    scan_s: f64,
    stays: Vec<Stay>,
    /// Gaps that began here, scans: between two reports, or between one and the begin or end of the target.
    gap_scans: Vec<u32>,
}

impl AreaScore {
    /// Nothing found yet.
    #[must_use]
    pub fn of(area: Area) -> Self {
        Self {
            area,
            position_m: Vec::new(),
            speed: Vec::new(),
            course_rad: Vec::new(),
            nearest_target_m: Vec::new(),
            after_end_m: Vec::new(),
            before_first: 0,
            unreported: 0,
            behind_s: Vec::new(),
            labels_due: 0,
            right_labels: 0,
            wrong_labels: 0,
            scan_s: 1.0,
            stays: Vec::new(),
            gap_scans: Vec::new(),
        }
    }

    /// Scans in which a target was here.
    #[must_use]
    pub fn target_scans(&self) -> u64 {
        self.stays.iter().map(|s| u64::from(s.scans)).sum()
    }

    /// Update intervals with a report, and expected ones; a hole of g seconds misses as many as fit in.
    #[must_use]
    pub fn reports_due(&self, interval_s: f64) -> (u64, u64) {
        let interval = interval_s.max(self.scan_s);
        let (mut missed, mut due) = (0.0, 0.0);
        for stay in &self.stays {
            let expected = (f64::from(stay.scans) * self.scan_s / interval).floor();
            let lost: f64 = stay
                .holes
                .iter()
                .map(|h| (f64::from(*h) * self.scan_s / interval + 1e-9).floor())
                .sum();
            due += expected;
            missed += lost.min(expected);
        }
        ((due - missed) as u64, due as u64)
    }

    /// Gaps of at least `gap_s` between two reports that began here, and expected intervals of `interval_s`.
    /// Before a target's first report and after its last one the gap is as long as the target was there.
    #[must_use]
    pub fn gaps(&self, gap_s: f64, interval_s: f64) -> (u64, u64) {
        let interval = interval_s.max(self.scan_s);
        let long = |g: &&u32| f64::from(**g) * self.scan_s >= gap_s - 1e-9;
        let count = self.gap_scans.iter().filter(long).count();
        let due: f64 =
            self.stays.iter().map(|s| (f64::from(s.scans) * self.scan_s / interval).floor()).sum();
        (count as u64, due as u64)
    }

    /// Root mean square of the position errors, m.
    #[must_use]
    pub fn rmse_m(&self) -> Option<f64> {
        let sum: f64 = self.position_m.iter().map(|e| e * e).sum();
        (!self.position_m.is_empty()).then(|| (sum / self.position_m.len() as f64).sqrt())
    }

    /// Reports farther than `limit_m` from every target: all of them, and without those of tracks whose target has
    /// just ended.
    #[must_use]
    pub fn false_reports(&self, limit_m: f64) -> (u64, u64) {
        let far =
            |sorted: &[f64]| (sorted.len() - sorted.partition_point(|d| *d <= limit_m)) as u64;
        let all = far(&self.nearest_target_m);
        (all, all - far(&self.after_end_m))
    }

    /// Joins what another run found in the same area.
    pub fn join(&mut self, other: &Self) {
        self.position_m.extend(&other.position_m);
        self.speed.extend(&other.speed);
        self.course_rad.extend(&other.course_rad);
        self.nearest_target_m.extend(&other.nearest_target_m);
        self.after_end_m.extend(&other.after_end_m);
        self.behind_s.extend(&other.behind_s);
        self.before_first += other.before_first;
        self.unreported += other.unreported;
        self.labels_due += other.labels_due;
        self.right_labels += other.right_labels;
        self.wrong_labels += other.wrong_labels;
        self.stays.extend(other.stays.iter().cloned());
        self.gap_scans.extend(&other.gap_scans);
        self.finish();
    }

    fn finish(&mut self) {
        for errors in [
            &mut self.position_m,
            &mut self.course_rad,
            &mut self.nearest_target_m,
            &mut self.after_end_m,
        ] {
            errors.sort_by(f64::total_cmp);
        }
        self.speed.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
}

/// What became of one target.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TargetScore {
    /// Its name.
    pub name: String,
    /// Scans in which it was there.
    pub scans: u64,
    /// Of these with a report.
    pub reported: u64,
    /// From its first scan to the first report, s; none if it was never reported.
    pub delay_s: Option<f64>,
    /// Tracks that followed it, in order, each time anew.
    pub tracks: Vec<u64>,
    /// Root mean square position error, m.
    pub rmse_m: Option<f64>,
}

/// Averages of GOSPA over the scans.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanGospa {
    /// The metric, m.
    pub total_m: f64,
    /// Per root of the number of targets, m.
    pub per_root_m: f64,
    /// Localisation part, m².
    pub localisation_m2: f64,
    /// Part of missed targets, m².
    pub missed_m2: f64,
    /// Part of false tracks, m².
    pub false_m2: f64,
}

/// Everything that was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Score {
    /// Areas in which something was, in the order of [`Area::ALL`].
    pub areas: Vec<AreaScore>,
    /// Target by target.
    pub targets: Vec<TargetScore>,
    /// Scans.
    pub scans: u64,
    /// Set distance.
    pub gospa: MeanGospa,
    /// Times that a track went over to another target while both lived.
    pub swaps: u64,
    /// Times that a target's track was followed by another track.
    pub breaks: u64,
    /// Tracks in all.
    pub tracks: u64,
    /// Tracks that never followed a target.
    pub false_tracks: u64,
    /// Mean time from validity to publication, s.
    pub latency_s: Option<f64>,
    /// Root mean square error of the plots, m; without those far off (see [`super::recording::PlotSum::of`]).
    pub plot_rmse_m: Option<f64>,
}

impl Score {
    /// All areas on the ground together, and the air.
    #[must_use]
    pub fn position_errors_m(&self, airborne: bool) -> Vec<f64> {
        let areas = self.areas.iter().filter(|a| airborne || a.area != Area::Airborne);
        let mut all: Vec<f64> = areas.flat_map(|a| a.position_m.iter().copied()).collect();
        all.sort_by(f64::total_cmp);
        all
    }

    /// Root mean square position error of all paired reports, m.
    #[must_use]
    pub fn rmse_m(&self) -> Option<f64> {
        let all = self.position_errors_m(true);
        let sum: f64 = all.iter().map(|e| e * e).sum();
        (!all.is_empty()).then(|| (sum / all.len() as f64).sqrt())
    }

    /// Reduction of the mean squared error against the plots, %.
    #[must_use]
    pub fn mse_reduction_pct(&self) -> Option<f64> {
        let (track, plot) = (self.rmse_m()?, self.plot_rmse_m?);
        (plot > 0.0).then(|| 100.0 * (1.0 - (track * track) / (plot * plot)))
    }

    /// Targets that were never reported.
    #[must_use]
    pub fn missed_targets(&self) -> usize {
        self.targets.iter().filter(|t| t.reported == 0).count()
    }
}

/// What is kept of a target while scanning.
#[derive(Clone, Debug, Default)]
struct Follow {
    track: Option<u64>,
    /// The last track, also after it was lost.
    last: Option<u64>,
    area: Option<Area>,
    stay: Stay,
    hole: u32,
    /// Scans since the last report, also over borders of areas, and where they began.
    gap: u32,
    gap_from: Option<Area>,
    first: Option<SimTime>,
    squares: f64,
    found: TargetScore,
}

/// Scores a recording in order (see [`Recording::put_in_order`]).
#[must_use]
pub fn score(recording: &Recording, areas: &AreaMap, rules: &Rules) -> Score {
    let mut run = Run::new(recording, areas, rules);
    let step = SimTime::from_s(rules.scan_s.max(1e-3)).0;
    let times = || {
        let paths = recording.targets.iter().flat_map(|t| [t.path.first(), t.path.last()]);
        let reports = [recording.reports.first(), recording.reports.last()];
        let reports = reports.into_iter().flatten().map(|r| r.time);
        paths.flatten().map(|p| p.time).chain(reports)
    };
    let (Some(first), Some(last)) = (times().min(), times().max()) else { return run.end() };
    // Reports belong to the scan whose middle is nearest.
    let scan_of = |time: SimTime| (time.0 + step / 2).div_euclid(step);
    let mut next = 0;
    for scan in scan_of(first)..=scan_of(last) {
        let begin = next;
        while recording.reports.get(next).is_some_and(|r| scan_of(r.time) <= scan) {
            next += 1;
        }
        run.scan(SimTime(scan * step), &recording.reports[begin..next]);
    }
    run.end()
}

struct Run<'a> {
    recording: &'a Recording,
    map: &'a AreaMap,
    rules: &'a Rules,
    follows: Vec<Follow>,
    areas: BTreeMap<Area, AreaScore>,
    /// Track → the target that it followed last.
    owners: BTreeMap<u64, Option<usize>>,
    latency: (f64, u64),
    score: Score,
}

impl<'a> Run<'a> {
    fn new(recording: &'a Recording, map: &'a AreaMap, rules: &'a Rules) -> Self {
        let follow = |name: &str| Follow {
            found: TargetScore { name: name.to_owned(), ..TargetScore::default() },
            ..Follow::default()
        };
        Self {
            recording,
            map,
            rules,
            follows: recording.targets.iter().map(|t| follow(&t.name)).collect(),
            areas: BTreeMap::new(),
            owners: BTreeMap::new(),
            latency: (0.0, 0),
            score: Score::default(),
        }
    }

    fn area(&mut self, area: Area) -> &mut AreaScore {
        let scan_s = self.rules.scan_s;
        self.areas.entry(area).or_insert_with(|| AreaScore { scan_s, ..AreaScore::of(area) })
    }

    fn scan(&mut self, at: SimTime, reports: &[Report]) {
        let hole_s = self.rules.hole_s;
        let targets = &self.recording.targets;
        let truth: Vec<(usize, TruthPoint)> = targets
            .iter()
            .enumerate()
            .filter_map(|(index, target)| Some((index, target.at(at, hole_s)?)))
            .collect();
        if truth.is_empty() && reports.is_empty() {
            return;
        }
        self.score.scans += 1;
        for report in reports {
            self.owners.entry(report.track).or_insert(None);
            if let Some(published) = report.published {
                self.latency.0 += published.since_s(report.time);
                self.latency.1 += 1;
            }
        }
        let places: Vec<Point2<f64>> = truth.iter().map(|t| t.1.position_m).collect();
        // Reports of other moments of the scan, moved to its middle by their own velocity.
        let moved: Vec<Point2<f64>> = reports
            .iter()
            .map(|r| r.position_m + r.velocity_mps.unwrap_or_default() * at.since_s(r.time))
            .collect();
        // A track is in one place: of several reports in a scan the one nearest its middle is paired.
        let chosen = one_a_track(reports, at);
        let chosen_m: Vec<Point2<f64>> = chosen.iter().map(|&r| moved[r]).collect();
        self.add_gospa(&gospa(&places, &chosen_m, self.rules.cut_off_m, 2.0), truth.len());
        let pairs = self.pairs(&truth, &places, reports, &moved, &chosen);
        let mut taken = vec![None; truth.len()];
        for &(t, r) in &pairs {
            taken[t] = Some(r);
        }
        for ((index, point), report) in truth.iter().zip(&taken) {
            self.target(*index, point, report.map(|r| &reports[r]), at);
        }
        for (report, place) in reports.iter().zip(&moved) {
            let ended = self.has_just_ended(report.track, at);
            let distances = places.iter().map(|p| distance(*p, *place));
            let (nearest, near) =
                distances.enumerate().fold((f64::INFINITY, None), |best, (k, d)| {
                    if d < best.0 { (d, Some(k)) } else { best }
                });
            // A report has no height of its own: beside a target it is where the target is.
            let height = near.filter(|_| nearest <= self.rules.pair_m);
            let area = self.map.at(report.position_m, height.and_then(|k| truth[k].1.height_m));
            let found = self.area(area);
            found.nearest_target_m.push(nearest);
            if ended {
                found.after_end_m.push(nearest);
            }
        }
    }

    /// Whether the target that a track followed last has ended so lately that the track may still coast.
    fn has_just_ended(&self, track: u64, at: SimTime) -> bool {
        let target = self.owners.get(&track).copied().flatten();
        let end = target.and_then(|index| self.recording.targets[index].path.last());
        end.map(|last| at.since_s(last.time))
            .is_some_and(|s| s > 0.0 && s <= self.rules.after_end_s + 1e-9)
    }

    fn add_gospa(&mut self, found: &Gospa, targets: usize) {
        let mean = &mut self.score.gospa;
        mean.total_m += found.total;
        mean.per_root_m += found.total / (targets.max(1) as f64).sqrt();
        mean.localisation_m2 += found.localisation;
        mean.missed_m2 += found.missed;
        mean.false_m2 += found.false_tracks;
    }

    /// Pairs (truth, report) of the scan.
    fn pairs(
        &self,
        truth: &[(usize, TruthPoint)],
        places: &[Point2<f64>],
        reports: &[Report],
        moved: &[Point2<f64>],
        chosen: &[usize],
    ) -> Vec<(usize, usize)> {
        let mut pairs = Vec::new();
        let by_track: BTreeMap<u64, usize> =
            chosen.iter().map(|&r| (reports[r].track, r)).collect();
        let (mut free_truth, mut used) = (Vec::new(), vec![false; reports.len()]);
        for (t, (index, _)) in truth.iter().enumerate() {
            let kept = self.follows[*index].track.and_then(|n| by_track.get(&n).copied());
            match kept.filter(|&r| distance(places[t], moved[r]) < self.rules.cut_off_m) {
                Some(r) => {
                    pairs.push((t, r));
                    used[r] = true;
                }
                None => free_truth.push(t),
            }
        }
        let free: Vec<usize> = chosen.iter().copied().filter(|r| !used[*r]).collect();
        let truth_m: Vec<_> = free_truth.iter().map(|&t| places[t]).collect();
        let tracks_m: Vec<_> = free.iter().map(|&r| moved[r]).collect();
        let rest = gospa(&truth_m, &tracks_m, self.rules.pair_m, 2.0).pairs;
        pairs.extend(rest.into_iter().map(|(t, r)| (free_truth[t], free[r])));
        pairs
    }

    /// Books a target's scan with the report that it got.
    fn target(&mut self, index: usize, point: &TruthPoint, report: Option<&Report>, at: SimTime) {
        let area = self.map.at(point.position_m, point.height_m);
        let follow = &mut self.follows[index];
        if follow.area != Some(area) {
            let stay = close(follow);
            if let Some(before) = follow.area.replace(area) {
                self.area(before).stays.push(stay);
            }
        }
        let follow = &mut self.follows[index];
        follow.stay.scans += 1;
        follow.found.scans += 1;
        follow.first.get_or_insert(at);
        let Some(report) = report else {
            follow.hole += 1;
            if follow.gap == 0 {
                follow.gap_from = Some(area);
            }
            follow.gap += 1;
            follow.track = None;
            let never = follow.found.delay_s.is_none();
            let found = self.area(area);
            found.unreported += 1;
            found.before_first += u64::from(never);
            return;
        };
        if follow.hole > 0 {
            let hole = std::mem::take(&mut follow.hole);
            follow.stay.holes.push(hole);
        }
        if follow.gap > 0 {
            let scans = std::mem::take(&mut follow.gap) + u32::from(follow.found.reported > 0);
            let from = follow.gap_from.unwrap_or(area);
            self.area(from).gap_scans.push(scans);
        }
        let follow = &mut self.follows[index];
        follow.found.reported += 1;
        if follow.found.delay_s.is_none() {
            follow.found.delay_s = follow.first.map(|first| at.since_s(first));
        }
        if follow.track != Some(report.track) {
            follow.track = Some(report.track);
            if follow.last != Some(report.track) {
                self.score.breaks += u64::from(follow.last.is_some());
                follow.found.tracks.push(report.track);
                follow.last = Some(report.track);
            }
            let owner = self.owners.insert(report.track, Some(index)).flatten();
            let lives = |other: usize| {
                self.recording.targets[other].path.last().is_some_and(|end| at <= end.time)
            };
            self.score.swaps +=
                u64::from(owner.is_some_and(|other| other != index && lives(other)));
        }
        // The truth of the report's own time, where the path has it.
        let exact = self.recording.targets[index].at(report.time, self.rules.hole_s);
        self.errors(area, index, &exact.unwrap_or(*point), report);
    }

    fn errors(&mut self, area: Area, index: usize, point: &TruthPoint, report: &Report) {
        let error = report.position_m - point.position_m;
        let metres = libm::hypot(error.x, error.y);
        let follow = &mut self.follows[index];
        follow.squares += metres * metres;
        let name = follow.found.name.clone();
        let course_from_mps = self.rules.course_from_mps;
        let found = self.area(area);
        found.position_m.push(metres);
        if !name.is_empty() {
            found.labels_due += 1;
            found.right_labels += u64::from(report.label == name);
            found.wrong_labels += u64::from(!report.label.is_empty() && report.label != name);
        }
        let Some(velocity) = report.velocity_mps else { return };
        let speed = libm::hypot(point.velocity_mps.x, point.velocity_mps.y);
        found.speed.push(((libm::hypot(velocity.x, velocity.y) - speed).abs(), speed));
        if speed > course_from_mps {
            let course = |v: Vector2<f64>| libm::atan2(v.x, v.y);
            found.course_rad.push(wrap_pi(course(velocity) - course(point.velocity_mps)).abs());
            found.behind_s.push(-error.dot(&point.velocity_mps) / (speed * speed));
        }
    }

    fn end(mut self) -> Score {
        for index in 0..self.follows.len() {
            let stay = close(&mut self.follows[index]);
            if let Some(area) = self.follows[index].area {
                self.area(area).stays.push(stay);
            }
            let follow = &self.follows[index];
            if let (gap @ 1.., Some(from)) = (follow.gap, follow.gap_from) {
                self.area(from).gap_scans.push(gap);
            }
        }
        let mut score = self.score;
        score.targets = self
            .follows
            .into_iter()
            .filter(|f| f.found.scans > 0)
            .map(|f| {
                let n = f.found.reported as f64;
                TargetScore { rmse_m: (n > 0.0).then(|| (f.squares / n).sqrt()), ..f.found }
            })
            .collect();
        score.areas = self.areas.into_values().collect();
        score.areas.iter_mut().for_each(AreaScore::finish);
        score.tracks = self.owners.len() as u64;
        score.false_tracks = self.owners.values().filter(|o| o.is_none()).count() as u64;
        score.latency_s = (self.latency.1 > 0).then(|| self.latency.0 / self.latency.1 as f64);
        score.plot_rmse_m = self.recording.plots.rmse_m();
        let scans = score.scans.max(1) as f64;
        let g = &mut score.gospa;
        for part in [
            &mut g.total_m,
            &mut g.per_root_m,
            &mut g.localisation_m2,
            &mut g.missed_m2,
            &mut g.false_m2,
        ] {
            *part /= scans;
        }
        score
    }
}

/// Ends a target's stay in its area: the open hole belongs to it.
fn close(follow: &mut Follow) -> Stay {
    let hole = std::mem::take(&mut follow.hole);
    let mut stay = std::mem::take(&mut follow.stay);
    if hole > 0 {
        stay.holes.push(hole);
    }
    stay
}

/// Of each track the report whose time is nearest, in the order of the tracks.
fn one_a_track(reports: &[Report], at: SimTime) -> Vec<usize> {
    let off = |r: usize| at.since_s(reports[r].time).abs();
    let mut nearest: BTreeMap<u64, usize> = BTreeMap::new();
    for (r, report) in reports.iter().enumerate() {
        let kept = nearest.entry(report.track).or_insert(r);
        if off(r) < off(*kept) {
            *kept = r;
        }
    }
    nearest.into_values().collect()
}

fn distance(a: Point2<f64>, b: Point2<f64>) -> f64 {
    libm::hypot(a.x - b.x, a.y - b.y)
}

#[cfg(test)]
mod tests;
