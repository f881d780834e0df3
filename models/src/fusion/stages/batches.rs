//! The plots of a scan in their order, corrected by what is known of their sensors, in batches of one sensor and interval.

use crate::filter::Measurement;
use crate::fusion::buffers::{Batch, Candidate};
use crate::fusion::numbers::Numbers;
use crate::fusion::places::Places;
use crate::fusion::resting::Resting;
use crate::fusion::state::{Outcome, Tracker, Work};
use crate::fusion::track_file::Stage;
use crate::plot::Plot;
use crate::time::SimTime;

impl Tracker {
    pub(in crate::fusion) fn begin(&mut self, t_out: SimTime) {
        self.statistics.scans += 1;
        if self.last_scan.is_some_and(|last| t_out < last) {
            self.statistics.clock_resets += 1;
            self.tracks.clear();
            self.ring.clear();
            self.labels = Resting::default();
            self.places = Places::default();
            self.seen.clear();
            self.numbers = Numbers::new(self.config.life.numbers, self.config.life.number_rest_s);
            self.last_scan = None;
        }
        if self.config.register_sites {
            self.registration.begin(t_out);
        }
        // A plot of this scan is never late, however long the scan is.
        let ring = t_out.plus_s(-self.config.ring_s);
        self.oldest = self.last_scan.map_or(ring, |last| ring.min(last));
        while self.seen.front().is_some_and(|(latest, _)| *latest < self.oldest) {
            self.seen.pop_front();
        }
    }

    /// Sorts the plots by (sensor, time, sequence), refuses what cannot be taken, and cuts batches.
    pub(in crate::fusion) fn take_in(&mut self, t_out: SimTime, plots: &[Plot], work: &mut Work) {
        self.outcomes.clear();
        self.outcomes.resize(plots.len(), Outcome::Unused);
        self.statistics.plots += plots.len() as u64;
        let order = Order::new(self.oldest, t_out, plots.len());
        work.keys.clear();
        for (index, plot) in plots.iter().enumerate() {
            if !sound(plot) || plot.time > t_out {
                self.outcomes[index] = Outcome::Unsound;
                self.statistics.unsound += 1;
            } else if plot.time < self.oldest {
                self.outcomes[index] = Outcome::TooLate;
                self.statistics.too_late += 1;
            } else {
                work.keys.push(order.key(plot, index));
            }
        }
        order.sort(&mut work.keys, plots);
        work.candidates.clear();
        work.batches.clear();
        let last_scan = self.last_scan;
        let start = last_scan.unwrap_or_else(|| {
            let times = work.keys.iter().map(|&key| plots[order.place(key)].time);
            SimTime(times.min().unwrap_or(t_out).0.saturating_sub(1))
        });
        (self.previous, self.last_scan) = (self.last_scan, Some(t_out));
        let mut names: Vec<u128> = Vec::with_capacity(work.keys.len());
        let mut latest = SimTime(i64::MIN);
        // Batches: one sensor, one of its intervals, counted from the end of the last scan.
        let (mut sensor, mut end, mut interval) = (None, i64::MIN, 1);
        let (mut extra_m2, mut latency_ns) = (0.0, 0);
        for &key in &work.keys {
            let index = order.place(key);
            let plot = &plots[index];
            let name = name_of(plot);
            let before = |scan: &Vec<u128>| scan.binary_search(&name).is_ok();
            if names.last() == Some(&name)
                || (last_scan.is_some_and(|last| plot.time <= last)
                    && self.seen.iter().any(|(_, scan)| before(scan)))
            {
                self.outcomes[index] = Outcome::Duplicate;
                self.statistics.duplicates += 1;
                continue;
            }
            names.push(name);
            latest = latest.max(plot.time);
            let k = work.candidates.len();
            let same = sensor == Some((plot.sensor, plot.kind));
            if !same {
                let model = self.config.sensor(plot.sensor, plot.kind);
                let spread = t_out.0.saturating_sub(start.0) / BATCHES;
                interval = SimTime::from_s(model.interval_s.clamp(1e-3, 1e6)).0.max(spread);
                extra_m2 = model.extra_sigma_m * model.extra_sigma_m;
                latency_ns = SimTime::from_s(model.latency_s.clamp(0.0, 60.0)).0;
            }
            let other = sensor.is_none_or(|(id, _)| id != plot.sensor);
            if other || plot.time.0 >= end {
                let since = plot.time.0.saturating_sub(start.0).saturating_sub(1);
                let number = since.div_euclid(interval);
                let length = interval.saturating_mul(number.saturating_add(1));
                end = start.0.saturating_add(1).saturating_add(length);
                work.batches.push(Batch { from: k, to: k });
            }
            sensor = Some((plot.sensor, plot.kind));
            work.candidates.push(Candidate { plot: *plot, index });
            let plot = &mut work.candidates[k].plot;
            if plot.polar.is_some() {
                // The site's errors, and the near side of a target of which nothing is known; its track knows more.
                plot.position_m -= self.registration.correction_m(plot);
                plot.position_m += plot.axis * self.registration.law().unknown_m.0;
            }
            plot.time = SimTime(plot.time.0.saturating_sub(latency_ns));
            // What the sensor's model adds to the stated variance.
            plot.along_m2 += extra_m2;
            plot.across_m2 += extra_m2;
        }
        self.seen.push_back((latest, names));
        let candidates = &work.candidates;
        let mut to = candidates.len();
        for batch in work.batches.iter_mut().rev() {
            batch.to = to;
            to = batch.from;
        }
        work.batches
            .sort_by_key(|b| (candidates[b.from].plot.time, candidates[b.from].plot.sensor));
        for flags in [&mut work.used, &mut work.gated, &mut work.held] {
            flags.clear();
            flags.resize(candidates.len(), false);
        }
    }

    /// Lists of the tracks by what may happen to them in this scan.
    pub(in crate::fusion) fn sort_tracks(&mut self, work: &mut Work) {
        work.confirmed.clear();
        work.tentative.clear();
        work.bodied.clear();
        for (index, track) in self.tracks.iter_mut().enumerate() {
            track.unresolved = false;
            match track.stage {
                Stage::Confirmed => work.confirmed.push(index as u32),
                Stage::Tentative => work.tentative.push(index as u32),
                Stage::Ended => {}
            }
            if track.stage == Stage::Confirmed && track.size_m.is_some() {
                work.bodied.push(index as u32);
            }
        }
    }
}

/// The order in which plots are taken: by their names, and of one name by position. One short key each, sensor
/// before coarse time before place in the caller's list; with care where two keys differ in the place alone.
#[derive(Clone, Copy, Debug)]
struct Order {
    oldest: SimTime,
    time_bits: u32,
    place_bits: u32,
    shift: u32,
}

impl Order {
    /// For up to `plots` plots of times from `oldest` to `t_out`.
    pub(in crate::fusion) fn new(oldest: SimTime, t_out: SimTime, plots: usize) -> Self {
        let span = t_out.0.saturating_sub(oldest.0).max(0).cast_unsigned();
        let place_bits = usize::BITS - plots.leading_zeros();
        let time_bits = 48 - place_bits.min(32);
        let shift = (u64::BITS - span.leading_zeros()).saturating_sub(time_bits);
        Self { oldest, time_bits, place_bits, shift }
    }

    #[inline]
    pub(in crate::fusion) fn key(&self, plot: &Plot, place: usize) -> u64 {
        let time = plot.time.0.saturating_sub(self.oldest.0).cast_unsigned() >> self.shift;
        let coarse = (u64::from(plot.sensor.0) << self.time_bits) | time;
        (coarse << self.place_bits) | place as u64
    }

    #[inline]
    pub(in crate::fusion) fn place(&self, key: u64) -> usize {
        (key & ((1 << self.place_bits) - 1)) as usize
    }

    pub(in crate::fusion) fn sort(&self, keys: &mut [u64], plots: &[Plot]) {
        keys.sort_unstable();
        for alike in keys.chunk_by_mut(|a, b| a >> self.place_bits == b >> self.place_bits) {
            if alike.len() > 1 {
                alike.sort_unstable_by(|&a, &b| {
                    let [p, q] = [a, b].map(|key| &plots[self.place(key)]);
                    let place = |p: &Plot, q: &Plot| {
                        let (p, q) = (p.position_m, q.position_m);
                        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y))
                    };
                    name_of(p).cmp(&name_of(q)).then_with(|| place(p, q)).then(a.cmp(&b))
                });
            }
        }
    }
}

/// The name of a plot, in the order in which plots are taken: sensor, time, number within the scan.
fn name_of(plot: &Plot) -> u128 {
    let time = plot.time.0.cast_unsigned() ^ (1 << 63);
    (u128::from(plot.sensor.0) << 96) | (u128::from(time) << 32) | u128::from(plot.sequence)
}

pub(in crate::fusion) fn sound(plot: &Plot) -> bool {
    let near = plot.position_m.x.abs() <= FARTHEST_M && plot.position_m.y.abs() <= FARTHEST_M;
    near && plot.altitude_m.is_none_or(f64::is_finite) && Measurement::of(plot).is_ok()
}

/// Batches into which the plots of one sensor in one scan are cut at most.
const BATCHES: i64 = 64;

/// Positions farther from the reference point than this are no airport traffic, m.
const FARTHEST_M: f64 = 1e6;
