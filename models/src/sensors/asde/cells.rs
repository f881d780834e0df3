//! Echoes in radar cells: scatterers, noise, threshold and clusters instead of closed forms; in windows
//! around each target, or in all cells that the beam passes.

use super::Asde;
use super::echo::Return;
use super::looks::NEXT;
use super::measuring::{Draws, Seen};
use super::picture::{Clutter, EvenGround, Obstacle};
use crate::draw::DrawKey;
use crate::frames::{Azimuth, wrap_pi};
use crate::plot::Polar;
use crate::sensors::radar::detection::{Detector, to_db};
use crate::sensors::radar::effects::RadarEffect;
use crate::sensors::radar::effects::value::EchoPlace;
use crate::sensors::radar::equation::Air;
use crate::sensors::radar::extended::{self, ExtentLevel};
use crate::sensors::radar::levels::RadarLevels;
use crate::sensors::radar::video::{
    Blob, CellBox, CellWork, Fading, PointEcho, Threshold, point_echoes,
};
use crate::sensors::{ScanInterval, Truth};

/// Part of a range cell, and of a beam position, that the centre of a cluster is off on average over the
/// places of a point in its cell, however strong it is.
const CELL_SIGMA: f64 = 0.12;

/// Deviation of an echo's centre over that of its extent (assumed; between 0.1 and 0.3 for the lists of scatterers).
const GLINT_OF_EXTENT: f64 = 0.2;
/// Mean square of what a point leaves in the cells, in beam positions² and range cells² (measured over its places).
const POINT_BEAMS2: f64 = 0.29;
const POINT_CELLS2: f64 = 0.29;

/// Echoes of returns, one list after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Lists {
    echoes: Vec<PointEcho>,
    /// Place among the returns, and of the first and behind the last echo.
    of: Vec<(usize, usize, usize)>,
}

impl Lists {
    fn each(&self) -> impl Iterator<Item = (usize, &[PointEcho])> {
        self.of.iter().map(|&(i, from, to)| (i, &self.echoes[from..to]))
    }
}

/// Space used again from scan to scan.
#[derive(Clone, Debug, Default)]
pub(super) struct WindowWork {
    lists: Lists,
    boxes: Vec<(CellBox, u32)>,
    group_of: Vec<u32>,
    order: Vec<u32>,
    echoes: Vec<PointEcho>,
    cells: CellWork,
}

impl Asde {
    /// Appends the scatterers of one return, faded, with the ratio of the whole; nothing where its range
    /// is not displayed. `key` names sensor and scan.
    pub(super) fn add_scatterers(
        &self,
        levels: &RadarLevels,
        truth: &dyn Truth,
        r: &Return,
        key: DrawKey,
        out: &mut Vec<PointEcho>,
    ) {
        let offset = r.look.state.position_m.xy() - self.site_m;
        let (along_m, across_m) = r.budget.moved_m;
        let ground_m = offset.norm();
        let azimuth_rad = Azimuth::of(offset).rad() + across_m / ground_m.max(1.0);
        let range_m = r.budget.range_m + along_m * (ground_m / r.budget.range_m);
        // Beyond the unambiguous range the echo appears nearer, with all its scatterers.
        let Some(apparent_m) = self.apparent_m(levels, range_m) else { return };
        let (first, snr) = (out.len(), r.budget.snr());
        match levels.extent {
            ExtentLevel::Point => out.push(PointEcho { range_m, azimuth_rad, snr }),
            ExtentLevel::Table | ExtentLevel::Centroid => {
                let view = extended::view_rad(azimuth_rad, r.look.state.heading_rad);
                let scatterers = extended::echoes(truth.class(r.look.index), view);
                out.extend(point_echoes(&scatterers, range_m, azimuth_rad, ground_m, snr));
            }
        }
        let own = &mut out[first..];
        own.iter_mut().for_each(|e| e.range_m -= range_m - apparent_m);
        let key = DrawKey { entity: truth.key(r.look.index), ..key };
        Fading::of(self.parameters.swerling, self.grid.pulses).fade(own, key);
    }

    fn lists(
        &self,
        levels: &RadarLevels,
        truth: &dyn Truth,
        interval: &ScanInterval,
        returns: &[Return],
        lists: &mut Lists,
    ) {
        lists.echoes.clear();
        lists.of.clear();
        for (i, r) in returns.iter().enumerate() {
            let from = lists.echoes.len();
            let mut key = self.key(interval, 0);
            // A second look within the scan is keyed by its number; that of the next one is the first.
            let number = if r.look.number == NEXT { 0 } else { r.look.number };
            key.sensor |= u32::from(number) << 16;
            self.add_scatterers(levels, truth, r, key, &mut lists.echoes);
            if lists.echoes.len() > from {
                lists.of.push((i, from, lists.echoes.len()));
            }
        }
    }

    /// Detects and measures every return in the window of cells around it, together with those whose
    /// windows touch. A cluster belongs to the return that puts most power into it; the clusters of one
    /// return are one plot, as of an extractor that knows the extent of its targets.
    ///
    /// The second value: the returns of the next interval that reported clusters have taken in.
    pub(super) fn measure_windows(
        &mut self,
        air: &Air,
        levels: &RadarLevels,
        truth: &dyn Truth,
        interval: &ScanInterval,
        returns: &[Return],
        work: &mut WindowWork,
    ) -> (Vec<Seen>, Vec<usize>) {
        self.lists(levels, truth, interval, returns, &mut work.lists);
        self.group(levels, returns, work);
        let WindowWork { lists, group_of, order, echoes, cells, .. } = work;
        let (mut seen, mut taken) = (Vec::with_capacity(returns.len()), Vec::new());
        order.clear();
        order.extend(0..lists.of.len() as u32);
        order.sort_unstable_by_key(|&l| (group_of[l as usize], l));
        let same = |a: &u32, b: &u32| group_of[*a as usize] == group_of[*b as usize];
        for members in order.chunk_by(same) {
            let head = &returns[lists.of[group_of[members[0] as usize] as usize].0];
            if head.look.number == NEXT {
                continue;
            }
            self.tally.count(RadarEffect::Detection);
            self.tally.count(RadarEffect::Processing);
            let list = |l: &u32| {
                let (i, from, to) = lists.of[*l as usize];
                (i, &lists.echoes[from..to])
            };
            echoes.clear();
            members.iter().for_each(|l| echoes.extend_from_slice(list(l).1));
            let mut key = self.key(interval, 0);
            key.sensor |= u32::from(head.look.number) << 16;
            let mut found = Vec::new();
            for blob in self.grid.window(echoes, |c| self.background(air, head, c), key, cells) {
                let inside = self.inside(&blob, members.iter().map(list));
                if let Some(cause) = strongest(returns, &inside) {
                    taken.extend(later(returns, &inside));
                    found.push((cause, blob));
                }
            }
            let plots = self.joined(found).into_iter();
            seen.extend(plots.filter_map(|(i, b)| self.cluster(levels, &returns[i], i, &b)));
        }
        (seen, taken)
    }

    /// Noise and clutter over noise in a cell near a return, with the weather at the return.
    fn background(&self, air: &Air, r: &Return, cell: i64) -> f64 {
        let b = &r.budget;
        let range_m = self.grid.cell_centre_m(cell).max(1.0);
        let nearer = b.range_m / range_m;
        let spread = nearer * nearer;
        let mut clutter_w = b.rain_w * self.rain_correlation * spread;
        if b.ground_m2 > 0.0 {
            let patch = self.radar.ground_m2(range_m) / b.ground_m2;
            clutter_w += b.ground_w * patch * spread * spread;
        }
        if b.other_m2 > 0.0 {
            let below_m2 = range_m * range_m - self.radar.antenna_m * self.radar.antenna_m;
            let place = EchoPlace { range_m, ground_m: below_m2.max(0.0).sqrt(), height_m: 0.0 };
            let cell_m2 = self.radar.change_at(air, &r.levels.budget, &place).clutter_m2;
            clutter_w += b.other_w * (cell_m2 / b.other_m2) * spread * spread;
        }
        1.0 + clutter_w / b.noise_w
    }

    /// Groups of lists whose windows touch: the place of the first list of each one's group.
    fn group(&mut self, levels: &RadarLevels, returns: &[Return], work: &mut WindowWork) {
        let WindowWork { lists, boxes, group_of, .. } = work;
        group_of.clear();
        group_of.extend(0..lists.of.len() as u32);
        if !levels.merging {
            return;
        }
        boxes.clear();
        boxes.extend((0..).zip(lists.each()).map(|(l, (_, own))| (self.grid.around(own), l)));
        // Boxes that begin just behind the seam stand once more a turn later.
        let turn = self.grid.beams as i64;
        let widest = boxes.iter().map(|(b, _)| b.beams.1 - b.beams.0).max().unwrap_or(0);
        for n in 0..boxes.len() {
            let (mut again, l) = boxes[n];
            if again.beams.0 <= widest {
                again.beams = (again.beams.0 + turn, again.beams.1 + turn);
                boxes.push((again, l));
            }
        }
        boxes.sort_unstable_by_key(|(b, l)| (b.beams, *l));
        let turns_per_s = self.parameters.turns_per_s();
        let mut tested = 0;
        for (n, (a, first)) in boxes.iter().enumerate() {
            for (b, second) in &boxes[n + 1..] {
                if b.beams.0 > a.beams.1 {
                    break;
                }
                tested += 1;
                let of = |l: u32| &returns[lists.of[l as usize].0].look;
                let turns = of(*first).time.since_s(of(*second).time) * turns_per_s;
                let apart = a.cells.1 < b.cells.0 || b.cells.1 < a.cells.0;
                if apart || turns.abs() >= 0.5 || of(*first).index == of(*second).index {
                    continue;
                }
                let (x, y) = (group_root(group_of, *first), group_root(group_of, *second));
                // An echo of the next interval leads only among its like.
                let rank = |l: u32| (of(l).number == NEXT, l);
                let (low, high) = if rank(x) < rank(y) { (x, y) } else { (y, x) };
                group_of[high as usize] = low;
            }
        }
        self.tally.add(RadarEffect::Merging, tested);
        for l in 0..group_of.len() as u32 {
            group_of[l as usize] = group_root(group_of, l);
        }
    }

    /// The plot of a cluster that a return caused.
    fn cluster(
        &mut self,
        levels: &RadarLevels,
        r: &Return,
        cause: usize,
        blob: &Blob,
    ) -> Option<Seen> {
        let ground_m = r.budget.range_m.max(1.0);
        let shift_m = r.budget.range_m - self.apparent_m(levels, r.budget.range_m)?;
        let draws = Draws {
            range_m: 0.0,
            azimuth_rad: 0.0,
            glint_along_m: blob.range_m + shift_m - r.range_m,
            glint_across_m: wrap_pi(blob.azimuth_rad - r.azimuth_rad) * ground_m,
        };
        let (measured, strength) = self.stated(blob, r.budget.reflected);
        let plot = self.plot(levels, r.look.time, measured, to_db(strength));
        Some(Seen { plot, cause: Some(cause), draws })
    }

    /// What the radar can say of a cluster: its place, its strength (the strongest sum of pulses over the noise, per
    /// pulse), and deviations by that strength and by the extent that the echo itself shows.
    fn stated(&self, blob: &Blob, reflected: f64) -> (Polar, f64) {
        let Detector { n, threshold, .. } = self.detector;
        let strength = (blob.peak * threshold / f64::from(n) - 1.0).max(0.0);
        let (range_m, azimuth_rad) = self.cell_sigmas(self.sigmas(strength, reflected));
        // What a point leaves of itself in the cells is no extent.
        let glint = |spread: f64, point: f64, step: f64| {
            GLINT_OF_EXTENT * (spread - point).max(0.0).sqrt() * step
        };
        let (cell_m, beam_m) =
            (self.grid.cell_m, self.grid.beam_step_rad() * blob.range_m.max(1.0));
        let measured = Polar {
            range_m: blob.range_m,
            azimuth_rad: blob.azimuth_rad,
            sigma_range_m: libm::hypot(
                range_m,
                glint(blob.spread[1], POINT_CELLS2, self.grid.cell_m),
            ),
            sigma_azimuth_rad: libm::hypot(
                azimuth_rad,
                glint(blob.spread[0], POINT_BEAMS2, self.grid.beam_step_rad()),
            ),
            extent_m2: Some([
                (blob.spread[1] - POINT_CELLS2) * cell_m * cell_m,
                blob.slant * cell_m * beam_m,
                (blob.spread[0] - POINT_BEAMS2) * beam_m * beam_m,
            ]),
        };
        (measured, strength)
    }

    /// The clusters of each return as one, by return.
    fn joined(&self, mut found: Vec<(usize, Blob)>) -> Vec<(usize, Blob)> {
        found.sort_by_key(|(i, _)| *i);
        found.dedup_by(|(later, other), (first, blob)| {
            let same = later == first;
            if same {
                blob.join(other, self.grid.beam_step_rad(), self.grid.cell_m);
            }
            same
        });
        found
    }

    /// Deviations of range and azimuth with what the steps of the cells add.
    fn cell_sigmas(&self, (range_m, azimuth_rad): (f64, f64)) -> (f64, f64) {
        (
            libm::hypot(range_m, CELL_SIGMA * self.grid.cell_m),
            libm::hypot(azimuth_rad, CELL_SIGMA * self.grid.beam_step_rad()),
        )
    }

    /// Power that each list puts into a cluster, with its return; only those that put any.
    fn inside<'a>(
        &self,
        blob: &Blob,
        lists: impl Iterator<Item = (usize, &'a [PointEcho])>,
    ) -> Vec<(f64, usize)> {
        let power = |own: &[PointEcho]| -> f64 {
            own.iter().filter(|e| self.grid.covers(blob, e)).map(|e| e.snr).sum()
        };
        lists.map(|(i, own)| (power(own), i)).filter(|(power, _)| *power > 0.0).collect()
    }

    /// The same with all cells that the beam passes in an interval: those that noise alone lifts over the
    /// threshold are the false alarms.
    ///
    /// The second value as of [`Self::measure_windows`].
    pub(super) fn measure_video(
        &mut self,
        air: &Air,
        levels: &RadarLevels,
        truth: &dyn Truth,
        interval: &ScanInterval,
        returns: &[Return],
        work: &mut WindowWork,
    ) -> (Vec<Seen>, Vec<usize>) {
        let lists = &mut work.lists;
        self.lists(levels, truth, interval, returns, lists);
        let mut last = None;
        lists.of.retain(|(i, ..)| {
            let index = returns[*i].look.index;
            last.replace(index) != Some(index)
        });
        self.tally.add(RadarEffect::Detection, lists.of.len() as u64);
        self.tally.add(RadarEffect::Processing, self.grid.beams as u64);
        let video = self.painted(air, levels, truth, interval, returns, lists);
        let (mut found, mut taken, mut alarms) = (Vec::new(), Vec::new(), Vec::new());
        for blob in &video {
            let inside = self.inside(blob, lists.each());
            if let Some(cause) = strongest(returns, &inside) {
                taken.extend(later(returns, &inside));
                found.push((cause, *blob));
            } else if inside.is_empty()
                && levels.false_alarms
                && let Some(time) = self.pass(interval, blob.azimuth_rad)
            {
                self.tally.count(RadarEffect::FalseAlarms);
                let (measured, strength) = self.stated(blob, 0.0);
                let plot = self.plot(levels, time, measured, to_db(strength));
                alarms.push(Seen { plot, cause: None, draws: Draws::default() });
            }
        }
        let plots = self.joined(found).into_iter();
        let plots = plots.filter_map(|(i, b)| self.cluster(levels, &returns[i], i, &b));
        let mut seen: Vec<Seen> = plots.collect();
        seen.extend(alarms);
        (seen, taken)
    }

    /// Clusters of the cells that the beam passes.
    fn painted(
        &self,
        air: &Air,
        levels: &RadarLevels,
        truth: &dyn Truth,
        interval: &ScanInterval,
        returns: &[Return],
        lists: &Lists,
    ) -> Vec<Blob> {
        let obstacle =
            |r: &Return| Obstacle::of(truth.class(r.look.index), &r.look.state, self.site_m);
        let aircraft: Vec<Obstacle> = returns.iter().filter_map(obstacle).collect();
        let clutter = Clutter::new(self, air, levels, &EvenGround, false, aircraft);
        let (sweep, step) = (self.sweep(interval), self.grid.beam_step_rad());
        // Targets at the edge of the sector reach beyond it, and their clusters need neighbours.
        let reach = lists.each().flat_map(|(i, own)| {
            own.iter().map(move |e| wrap_pi(e.azimuth_rad - returns[i].look.azimuth_rad).abs())
        });
        let margin_rad = reach.fold(0.0, f64::max) + 4.0 * self.grid.width_rad;
        let fill = |beam: usize, row: &mut [f64]| {
            let painted = sweep.passes((beam as f64 + 0.5) * step, margin_rad);
            if painted {
                clutter.fill(beam, row);
            }
            painted
        };
        let echoes = lists.each().flat_map(|(_, own)| own.iter().copied());
        self.grid.video(echoes, fill, Threshold::Known, self.key(interval, 0)).blobs
    }
}

/// The return of this interval that puts most power into a cluster.
fn strongest(returns: &[Return], inside: &[(f64, usize)]) -> Option<usize> {
    let of = inside.iter().filter(|(_, i)| returns[*i].look.number != NEXT);
    of.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1))).map(|(_, i)| *i)
}

/// The returns of the next interval in a cluster.
fn later<'a>(
    returns: &'a [Return],
    inside: &'a [(f64, usize)],
) -> impl Iterator<Item = usize> + 'a {
    inside.iter().map(|(_, i)| *i).filter(|i| returns[*i].look.number == NEXT)
}

fn group_root(group_of: &[u32], mut l: u32) -> u32 {
    while group_of[l as usize] != l {
        l = group_of[l as usize];
    }
    l
}
