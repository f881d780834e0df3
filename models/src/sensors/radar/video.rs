//! Radar cells: windows of them around targets, and the whole picture of one scan.
//!
//! Each beam position sums n square-law pulses per range cell. A scatterer spreads over range cells
//! by the matched filter of a rectangular pulse and over beams by the two-way pattern, averaged over
//! the dwell. What the beam's shape and the straddling of cells take is part of the budget's system
//! losses; the cells show it themselves, so an echo enters them without that part. One draw per
//! *integrated* cell keeps the statistics: noise alone is a gamma variate of order n, with a steady
//! signal S per pulse it is ½[(z₁ + √(2nS))² + z₂²] plus a gamma variate of order n − 1.
//!
//! The echo of a target fluctuates from scan to scan as its Swerling case says; its scatterers fade
//! independently within that total, which makes the centre of the echo wander, and add in power.
//!
//! Thresholds: known background, or cell-averaging CFAR along range. Cells above it are joined to
//! clusters; a plot is the centroid of a cluster, weighted with the power above the threshold, so that
//! a cell which just passes it moves nothing. Two targets in neighbouring cells become one plot by
//! themselves.
//!
//! Levels: [`CellRadar::window`] computes only the cells within the extent of a target (or of a group
//! of targets that may merge) plus a margin; [`CellRadar::video`] computes all cells of a scan and
//! keeps the picture. A cell has the same draw in both, named by beam, cell and scan. Not modelled:
//! range side lobes, azimuth side lobes, phase between scatterers.
//!
//! Source: Skolnik, *Introduction to Radar Systems*, ch. 2 and 7; CFAR: Gandhi & Kassam, "Analysis of
//! CFAR processors", IEEE Trans. AES-24 (1988); the non-central form is the definition of the
//! non-central χ² distribution with 2n degrees of freedom.

pub mod ppi;

use rand::Rng;
use rand::rngs::ChaCha8Rng;
use std::f64::consts::{LN_2, PI, TAU};

use crate::draw::{DrawKey, Purpose, exponential};
use crate::frames::wrap_pi;
use crate::sensors::radar::detection::{Detector, Swerling};
use crate::sensors::radar::parameters::AsdeParameters;
use crate::sensors::radar::shape::Echo;

/// One point echo in radar coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointEcho {
    /// Slant range, m.
    pub range_m: f64,
    /// Azimuth, rad clockwise from north.
    pub azimuth_rad: f64,
    /// Mean signal to thermal noise of one pulse at the centre of the beam.
    pub snr: f64,
}

/// Spreads the echo of a whole target, of ratio `snr`, over its scatterers.
///
/// The reference point is seen at `range_m` (slant) and `azimuth_rad`, `ground_m` away on the ground.
pub fn point_echoes<'a>(
    scatterers: &'a [Echo],
    range_m: f64,
    azimuth_rad: f64,
    ground_m: f64,
    snr: f64,
) -> impl Iterator<Item = PointEcho> + 'a {
    let total: f64 = scatterers.iter().map(|e| e.rcs_m2).sum();
    let slope = ground_m / range_m;
    scatterers.iter().map(move |e| PointEcho {
        range_m: range_m + e.along_m * slope,
        azimuth_rad: azimuth_rad + e.across_m / ground_m.max(1.0),
        snr: if total > 0.0 { snr * e.rcs_m2 / total } else { 0.0 },
    })
}

/// How the whole echo of a target fluctuates from scan to scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fading {
    /// Not at all.
    Steady,
    /// As a gamma variate of this order with mean 1: 1, n, 2 and 2n for Swerling's cases 1 to 4 of n
    /// pulses. Cases 2 and 4 change from pulse to pulse, but only the energy of the dwell counts.
    Gamma(u32),
}

impl Fading {
    /// The fluctuation of a Swerling case over `pulses` summed pulses.
    #[must_use]
    pub fn of(swerling: Swerling, pulses: u32) -> Self {
        match swerling {
            Swerling::Steady => Self::Steady,
            Swerling::One => Self::Gamma(1),
            Swerling::Two => Self::Gamma(pulses),
            Swerling::Three => Self::Gamma(2),
            Swerling::Four => Self::Gamma(2 * pulses),
        }
    }

    /// Fades the scatterers of one target for one scan; `key` names the target and the scan. The total
    /// is drawn first, then, where there are several, each one's share of it.
    pub fn fade(self, echoes: &mut [PointEcho], key: DrawKey) {
        let mut rng = key.rng(Purpose::Fluctuation);
        let mut factor = match self {
            Self::Steady => 1.0,
            Self::Gamma(order) => gamma_order(order, &mut rng) / f64::from(order),
        };
        if echoes.len() > 1 {
            let mean: f64 = echoes.iter().map(|e| e.snr).sum();
            let mut drawn = 0.0;
            for echo in echoes.iter_mut() {
                echo.snr *= exponential(&mut rng);
                drawn += echo.snr;
            }
            factor *= if drawn > 0.0 { mean / drawn } else { 0.0 };
        }
        echoes.iter_mut().for_each(|e| e.snr *= factor);
    }
}

/// How the threshold of a cell is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Threshold {
    /// From the known mean of noise and clutter.
    Known,
    /// From the mean of `reference` cells on each side, beyond `guard` cells.
    CellAveraging {
        /// Cells left out on each side.
        guard: usize,
        /// Cells averaged on each side.
        reference: usize,
    },
}

/// The cells of a radar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellRadar {
    /// Length of a range cell, m.
    pub cell_m: f64,
    /// Start of the first range cell, m.
    pub range_min_m: f64,
    /// Range cells.
    pub cells: usize,
    /// Beam positions of a turn.
    pub beams: usize,
    /// One-way −3 dB width of the beam, rad.
    pub width_rad: f64,
    /// Pulses summed per beam position.
    pub pulses: u32,
    /// Probability of a false alarm per cell.
    pub pfa: f64,
    /// Threshold on the sum, in units of the background of one pulse.
    pub threshold: f64,
    /// Factor on every echo: what the budget's losses count for beam shape and straddling.
    pub recovered: f64,
}

/// A cluster of cells above the threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blob {
    /// Power centroid in range, m.
    pub range_m: f64,
    /// Power centroid in azimuth, rad in [−π, π).
    pub azimuth_rad: f64,
    /// Cells in it.
    pub cells: u32,
    /// Largest sum over its threshold.
    pub peak: f64,
    /// Power above the background, summed, in units of the background of one pulse.
    pub excess: f64,
    /// Power above the threshold, which weighs the cells of the centroid, in units of the thermal noise.
    pub weight: f64,
    /// Mean squares of the distances of its cells from the centroid, weighed as that is: in beam positions and in range
    /// cells. What the echo itself shows of the target's extent.
    pub spread: [f64; 2],
    /// Mean product of the two, so weighed.
    pub slant: f64,
    /// The cells that it lies in.
    pub span: CellBox,
}

/// Beam positions and range cells, first and last; beams may be beyond the turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellBox {
    /// Beam positions.
    pub beams: (i64, i64),
    /// Range cells.
    pub cells: (i64, i64),
}

/// Space used again from window to window.
#[derive(Clone, Debug, Default)]
pub struct CellWork {
    signal: Vec<f64>,
    hits: Vec<Hit>,
    level: Vec<f64>,
}

/// A cell above its threshold; beams may be beyond the turn in a window across north.
#[derive(Clone, Copy, Debug)]
struct Hit {
    beam: i64,
    cell: i64,
    excess: f64,
    /// Power above the threshold.
    weight: f64,
    peak: f64,
    cluster: u32,
}

/// The picture of one scan.
#[derive(Clone, Debug, PartialEq)]
pub struct Video {
    /// Beam positions.
    pub beams: usize,
    /// Range cells.
    pub cells: usize,
    /// Sum of the pulses over its mean without signal or clutter, beam by beam.
    pub power: Vec<f32>,
    /// Clusters above the threshold, in the order of their first beam and cell.
    pub blobs: Vec<Blob>,
}

/// Cells of a whole video at most: about 240 MB of them.
pub const MOST_CELLS: usize = 20_000_000;
/// Cells around a target that are computed beyond its scatterers, and beams.
const MARGIN: i64 = 3;
/// Cells of one cluster are at most this many range cells apart.
const JOIN: i64 = 2;

impl Blob {
    /// Takes in another cluster of the same target, in cells of this size.
    pub fn join(&mut self, other: &Self, beam_step_rad: f64, cell_m: f64) {
        let total = self.weight + other.weight;
        let share = if total > 0.0 { other.weight / total } else { 0.5 };
        let turn = wrap_pi(other.azimuth_rad - self.azimuth_rad);
        let apart = [turn / beam_step_rad, (other.range_m - self.range_m) / cell_m];
        let between = share * (1.0 - share) * apart[0] * apart[1];
        self.slant += share * (other.slant - self.slant) + between;
        for (k, apart) in apart.into_iter().enumerate() {
            let (own, its) = (self.spread[k], other.spread[k]);
            self.spread[k] = own + share * (its - own) + share * (1.0 - share) * apart * apart;
        }
        self.range_m += share * (other.range_m - self.range_m);
        self.azimuth_rad = wrap_pi(self.azimuth_rad + share * turn);
        self.cells += other.cells;
        self.peak = self.peak.max(other.peak);
        self.excess += other.excess;
        self.weight = total;
    }
}

impl CellRadar {
    /// The cells of a radar with these parameters.
    #[must_use]
    pub fn of(parameters: &AsdeParameters) -> Self {
        let width_rad = parameters.azimuth_beamwidth_deg.to_radians();
        let cell_m = parameters.radar().cell_m;
        let pulses = parameters.pulses_summed();
        let bare = Self {
            cell_m,
            range_min_m: parameters.range_min_m,
            cells: ((parameters.range_max_m - parameters.range_min_m) / cell_m).ceil() as usize,
            beams: (TAU / width_rad).round().max(1.0) as usize,
            width_rad,
            pulses,
            pfa: parameters.pfa,
            threshold: Detector::new(pulses, parameters.pfa).threshold,
            recovered: 1.0,
        };
        Self { recovered: 1.0 / bare.straddling_share(), ..bare }
    }

    /// Cells of a whole turn.
    #[must_use]
    pub fn turn_cells(&self) -> usize {
        self.beams.saturating_mul(self.cells)
    }

    /// Angle from one beam position to the next, rad.
    #[must_use]
    pub fn beam_step_rad(&self) -> f64 {
        TAU / self.beams as f64
    }

    /// Share of a scatterer's power in a beam position, `off_rad` from its centre: the two-way
    /// Gaussian pattern averaged over the dwell.
    #[must_use]
    pub fn beam_share(&self, off_rad: f64) -> f64 {
        let step = self.beam_step_rad();
        let k = (8.0 * LN_2).sqrt() / self.width_rad;
        let half = 0.5 * step;
        let area = 0.5 * PI.sqrt() / k;
        area / step * (libm::erf(k * (off_rad + half)) - libm::erf(k * (off_rad - half)))
    }

    /// Share of a scatterer's power in a range cell, `off_m` from its centre: (1 − |x|)², the matched
    /// filter of a rectangular pulse as long as the cell.
    #[must_use]
    pub fn range_share(&self, off_m: f64) -> f64 {
        let rest = (1.0 - (off_m / self.cell_m).abs()).max(0.0);
        rest * rest
    }

    /// Share of the power that the cells of a scatterer at a random place see at best, on average:
    /// what straddling of cells and the turning beam take from the value at the beam's centre.
    #[must_use]
    pub fn straddling_share(&self) -> f64 {
        let n = 64;
        let mean = |share: &dyn Fn(f64) -> f64| {
            (0..n).map(|i| share((f64::from(i) + 0.5) / f64::from(n) - 0.5)).sum::<f64>()
                / f64::from(n)
        };
        mean(&|x| self.range_share(x * self.cell_m))
            * mean(&|x| self.beam_share(x * self.beam_step_rad()))
    }

    fn beam_of(&self, azimuth_rad: f64) -> i64 {
        (azimuth_rad / self.beam_step_rad()).floor() as i64
    }

    fn cell_of(&self, range_m: f64) -> i64 {
        ((range_m - self.range_min_m) / self.cell_m).floor() as i64
    }

    /// Slant range of the middle of a cell, m.
    #[must_use]
    pub fn cell_centre_m(&self, cell: i64) -> f64 {
        self.range_min_m + (cell as f64 + 0.5) * self.cell_m
    }

    /// Adds an echo to a grid of mean signal; azimuths count from `azimuth_rad` 0 without wrapping.
    fn add(&self, echo: &PointEcho, first: (i64, i64), size: (usize, usize), signal: &mut [f64]) {
        let step = self.beam_step_rad();
        let reach = (1.5 * self.width_rad / step).ceil() as i64;
        let (beam, cell) = (self.beam_of(echo.azimuth_rad), self.cell_of(echo.range_m));
        for b in beam - reach..=beam + reach {
            let row = b - first.0;
            if row < 0 || row >= size.0 as i64 {
                continue;
            }
            let share = echo.snr
                * self.recovered
                * self.beam_share((b as f64 + 0.5) * step - echo.azimuth_rad);
            for c in cell - 1..=cell + 1 {
                let column = c - first.1;
                if column >= 0 && column < size.1 as i64 {
                    signal[row as usize * size.1 + column as usize] +=
                        share * self.range_share(self.cell_centre_m(c) - echo.range_m);
                }
            }
        }
    }

    /// The sum of the pulses of one cell in units of the thermal noise of one pulse.
    ///
    /// The exponential part of the noise is ½(z₁² + z₂²) of the form with a signal, so the sum goes to
    /// that of noise alone as the signal goes to 0, with the same draws.
    fn draw(&self, signal: f64, background: f64, rng: &mut ChaCha8Rng) -> f64 {
        let bits = rng.next_u64();
        let first = (f64::from(bits as u32) + 0.5) * STEP;
        let waited = gamma_with(first, self.pulses - 1, rng);
        if signal <= 0.0 {
            return background * waited;
        }
        let shift = (2.0 * f64::from(self.pulses) * signal / background).sqrt();
        let turn = (f64::from((bits >> 32) as u32) + 0.5) * STEP;
        let along = (-2.0 * libm::log(first)).sqrt() * libm::cos(TAU * turn);
        background * (waited + shift * (along + 0.5 * shift)).max(0.0)
    }

    /// Words of a beam's stream that one cell takes.
    fn words(&self) -> u64 {
        2 + gamma_words(self.pulses - 1)
    }

    /// The draws of a beam from a cell on; `key` names sensor and scan.
    fn beam_rng(&self, beam: i64, cell: i64, key: DrawKey) -> ChaCha8Rng {
        let entity = beam.rem_euclid(self.beams as i64) as u64;
        let mut rng = DrawKey { entity, ..key }.rng(Purpose::Cells);
        rng.set_word_pos(u128::from(self.words()) * cell.max(0) as u128);
        rng
    }

    /// Whether an echo lies in the box of a cluster, or beside it.
    #[must_use]
    pub fn covers(&self, blob: &Blob, echo: &PointEcho) -> bool {
        let turn = self.beams as i64;
        let (first, last) = (blob.span.beams.0 - 1, blob.span.beams.1 + 1);
        let beam = (self.beam_of(echo.azimuth_rad) - first).rem_euclid(turn);
        let cell = self.cell_of(echo.range_m);
        beam <= last - first && blob.span.cells.0 - 1 <= cell && cell <= blob.span.cells.1 + 1
    }

    /// The cells that scatterers of one target light, and where clusters reach them; beams from 0 to
    /// beyond the turn.
    #[must_use]
    pub fn around(&self, echoes: &[PointEcho]) -> CellBox {
        let origin = echoes.first().map_or(0.0, |e| e.azimuth_rad);
        let (mut beams, mut cells) = ((i64::MAX, i64::MIN), (i64::MAX, i64::MIN));
        for e in echoes {
            let (b, c) =
                (self.beam_of(origin + wrap_pi(e.azimuth_rad - origin)), self.cell_of(e.range_m));
            beams = (beams.0.min(b), beams.1.max(b));
            cells = (cells.0.min(c), cells.1.max(c));
        }
        if echoes.is_empty() {
            return CellBox { beams: (0, -1), cells: (0, -1) };
        }
        let turn = self.beams as i64;
        let shift = (beams.0 - MARGIN).div_euclid(turn) * turn;
        CellBox {
            beams: (beams.0 - MARGIN - shift, beams.1 + MARGIN - shift),
            cells: (cells.0 - JOIN, cells.1 + JOIN),
        }
    }

    /// Clusters in the cells around `echoes`, the faded scatterers of one target or of targets that may
    /// merge; the strongest first. `background` is noise and clutter over noise, at least 1, of a cell.
    ///
    /// `key` names the sensor and the scan; its entity is not used.
    #[must_use]
    pub fn window(
        &self,
        echoes: &mut [PointEcho],
        background: impl Fn(i64) -> f64,
        key: DrawKey,
        work: &mut CellWork,
    ) -> Vec<Blob> {
        let Some(origin) = echoes.first().copied() else { return Vec::new() };
        let CellWork { signal, hits, level } = work;
        // Azimuths on one side of the circle's seam.
        for e in echoes.iter_mut() {
            e.azimuth_rad = origin.azimuth_rad + wrap_pi(e.azimuth_rad - origin.azimuth_rad);
        }
        let (mut low, mut high) = ((i64::MAX, i64::MAX), (i64::MIN, i64::MIN));
        for e in echoes.iter() {
            let (b, c) = (self.beam_of(e.azimuth_rad), self.cell_of(e.range_m));
            low = (low.0.min(b), low.1.min(c));
            high = (high.0.max(b), high.1.max(c));
        }
        let first = (low.0 - MARGIN, (low.1 - MARGIN).max(0));
        let last = (high.0 + MARGIN, (high.1 + MARGIN).min(self.cells as i64 - 1));
        if last.1 < first.1 {
            return Vec::new();
        }
        let size = ((last.0 - first.0 + 1) as usize, (last.1 - first.1 + 1) as usize);
        signal.clear();
        signal.resize(size.0 * size.1, 0.0);
        for e in echoes.iter() {
            self.add(e, first, size, signal);
        }
        hits.clear();
        level.clear();
        level.extend((first.1..=last.1).map(|cell| background(cell).max(1.0)));
        let n = f64::from(self.pulses);
        for (row, beam) in signal.chunks_exact(size.1).zip(first.0..) {
            let mut rng = self.beam_rng(beam, first.1, key);
            for ((s, level), cell) in row.iter().zip(&*level).zip(first.1..) {
                let (sum, limit) = (self.draw(*s, *level, &mut rng), self.threshold * level);
                if sum >= limit {
                    hits.push(Hit {
                        beam,
                        cell,
                        excess: (sum / level - n).max(0.0),
                        weight: sum - limit,
                        peak: sum / limit,
                        cluster: 0,
                    });
                }
            }
        }
        let mut blobs = self.clusters(hits, false);
        blobs.sort_by(|a, b| b.excess.total_cmp(&a.excess));
        blobs
    }

    /// All cells of one scan: picture and clusters. `echoes` are faded; `background` fills in noise and
    /// clutter over noise, at least 1, for the cells of a beam, and says whether the beam is computed at
    /// all. A cell's draw is named by beam, cell and scan, so an echo more changes no other cell.
    #[must_use]
    pub fn video(
        &self,
        echoes: impl IntoIterator<Item = PointEcho>,
        mut background: impl FnMut(usize, &mut [f64]) -> bool,
        threshold: Threshold,
        key: DrawKey,
    ) -> Video {
        let size = (self.beams, self.cells);
        let mut signal = vec![0.0; self.beams * self.cells];
        let turn = self.beams as i64;
        let reach = (1.5 * self.width_rad / self.beam_step_rad()).ceil() as i64 + 1;
        for mut e in echoes {
            e.azimuth_rad = e.azimuth_rad.rem_euclid(TAU);
            let beam = self.beam_of(e.azimuth_rad);
            self.add(&e, (0, 0), size, &mut signal);
            // The other side of the seam.
            if beam < reach {
                e.azimuth_rad += TAU;
                self.add(&e, (0, 0), size, &mut signal);
            } else if beam >= turn - reach {
                e.azimuth_rad -= TAU;
                self.add(&e, (0, 0), size, &mut signal);
            }
        }
        let mut level = vec![1.0; self.cells];
        let factor = match threshold {
            Threshold::Known => self.threshold,
            Threshold::CellAveraging { reference, .. } => {
                f64::from(self.pulses) * cfar_factor(self.pulses, 2 * reference as u32, self.pfa)
            }
        };
        let n = f64::from(self.pulses);
        let mut power = Vec::with_capacity(self.beams * self.cells);
        let mut hits = Vec::new();
        let (mut row, mut sums) = (vec![0.0; self.cells], vec![0.0; self.cells + 1]);
        for beam in 0..self.beams {
            level.fill(1.0);
            if !background(beam, &mut level) {
                power.resize(power.len() + self.cells, 0.0);
                continue;
            }
            let mut rng = self.beam_rng(beam as i64, 0, key);
            level.iter_mut().for_each(|l| *l = l.max(1.0));
            for (cell, value) in row.iter_mut().enumerate() {
                *value = self.draw(signal[beam * self.cells + cell], level[cell], &mut rng);
                sums[cell + 1] = sums[cell] + *value;
            }
            power.extend(row.iter().map(|v| (v / n) as f32));
            for (cell, value) in row.iter().enumerate() {
                // Mean of one pulse in the surroundings.
                let mean = match threshold {
                    Threshold::Known => level[cell],
                    Threshold::CellAveraging { guard, reference } => {
                        surroundings(&sums, cell, guard, reference) / n
                    }
                };
                let limit = factor * mean;
                if *value >= limit && mean > 0.0 {
                    hits.push(Hit {
                        beam: beam as i64,
                        cell: cell as i64,
                        excess: (value / mean - n).max(0.0),
                        weight: value - limit,
                        peak: value / limit,
                        cluster: 0,
                    });
                }
            }
        }
        let blobs = self.clusters(&mut hits, true);
        Video { beams: self.beams, cells: self.cells, power, blobs }
    }

    /// Joins hits (sorted by beam, then cell) that are neighbours; `round` where the last beam is the
    /// first one's neighbour.
    fn clusters(&self, hits: &mut [Hit], round: bool) -> Vec<Blob> {
        let mut parent: Vec<u32> = (0..hits.len() as u32).collect();
        let join = |parent: &mut Vec<u32>, a: usize, b: usize| {
            let (a, b) = (root(parent, a as u32), root(parent, b as u32));
            let (low, high) = (a.min(b), a.max(b));
            parent[high as usize] = low;
        };
        let turn = self.beams as i64;
        for i in 0..hits.len() {
            let (beam, cell) = (hits[i].beam, hits[i].cell);
            if i > 0 && hits[i - 1].beam == beam && cell - hits[i - 1].cell <= JOIN {
                join(&mut parent, i, i - 1);
            }
            let neighbours = |parent: &mut Vec<u32>, other: i64| {
                let begin = hits.partition_point(|h| (h.beam, h.cell) < (other, cell - JOIN));
                for (k, hit) in hits.iter().enumerate().skip(begin) {
                    if hit.beam != other || hit.cell > cell + JOIN {
                        break;
                    }
                    join(parent, i, k);
                }
            };
            neighbours(&mut parent, beam - 1);
            if round && beam == turn - 1 && turn > 2 {
                neighbours(&mut parent, 0);
            }
        }
        for (i, hit) in hits.iter_mut().enumerate() {
            hit.cluster = root(&mut parent, i as u32);
        }
        let mut order: Vec<u32> = (0..hits.len() as u32).collect();
        order.sort_by_key(|&i| (hits[i as usize].cluster, i));
        order
            .chunk_by(|&a, &b| hits[a as usize].cluster == hits[b as usize].cluster)
            .map(|members| {
                let first = hits[members[0] as usize];
                let mut blob = Blob {
                    range_m: 0.0,
                    azimuth_rad: 0.0,
                    cells: 0,
                    peak: 0.0,
                    excess: 0.0,
                    weight: 0.0,
                    spread: [0.0; 2],
                    slant: 0.0,
                    span: CellBox {
                        beams: (first.beam, first.beam),
                        cells: (first.cell, first.cell),
                    },
                };
                // Sums of weight, beam and cell; of beam and cell without weights.
                let (mut weighted, mut plain) = ([0.0; 3], [0.0; 2]);
                let (mut squares, mut product) = ([0.0; 2], 0.0);
                for &m in members {
                    let hit = hits[m as usize];
                    // Beams of a cluster across the seam count from its first one.
                    let mut off = hit.beam - first.beam;
                    if round && off > turn / 2 {
                        off -= turn;
                    }
                    let CellBox { beams, cells } = &mut blob.span;
                    *beams = (beams.0.min(first.beam + off), beams.1.max(first.beam + off));
                    *cells = (cells.0.min(hit.cell), cells.1.max(hit.cell));
                    blob.cells += 1;
                    blob.peak = blob.peak.max(hit.peak);
                    blob.excess += hit.excess;
                    let (off, cell) = (off as f64, hit.cell as f64);
                    weighted[0] += hit.weight;
                    weighted[1] += hit.weight * off;
                    weighted[2] += hit.weight * cell;
                    let from_first = cell - first.cell as f64;
                    squares[0] += hit.weight * off * off;
                    squares[1] += hit.weight * from_first * from_first;
                    product += hit.weight * off * from_first;
                    plain[0] += off;
                    plain[1] += cell;
                }
                let count = members.len() as f64;
                // All exactly at the threshold: each counts the same.
                let [beam, cell] = if weighted[0] > 0.0 {
                    [weighted[1] / weighted[0], weighted[2] / weighted[0]]
                } else {
                    plain.map(|sum| sum / count)
                };
                if weighted[0] > 0.0 {
                    let means = [beam, cell - first.cell as f64];
                    blob.spread =
                        [0, 1].map(|k| (squares[k] / weighted[0] - means[k] * means[k]).max(0.0));
                    blob.slant = product / weighted[0] - means[0] * means[1];
                }
                let centre = first.beam as f64 + 0.5 + beam;
                blob.weight = weighted[0];
                blob.azimuth_rad = wrap_pi(centre * self.beam_step_rad());
                blob.range_m = self.range_min_m + (cell + 0.5) * self.cell_m;
                blob
            })
            .collect()
    }
}

/// Root of a member, halving the paths on the way.
fn root(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        let up = parent[parent[i as usize] as usize];
        parent[i as usize] = up;
        i = up;
    }
    i
}

/// Mean of the reference cells around `cell` that exist.
fn surroundings(sums: &[f64], cell: usize, guard: usize, reference: usize) -> f64 {
    let last = sums.len() - 1;
    let before = (cell.saturating_sub(guard + reference), cell.saturating_sub(guard));
    let after = ((cell + guard + 1).min(last), (cell + guard + 1 + reference).min(last));
    let count = (before.1 - before.0) + (after.1 - after.0);
    if count == 0 {
        return 0.0;
    }
    (sums[before.1] - sums[before.0] + sums[after.1] - sums[after.0]) / count as f64
}

/// Factor on the mean of `cells` reference cells, each the sum of `pulses`, for a false alarm
/// probability `pfa` in exponential noise.
///
/// With a = factor/cells: Pfa = Σ_{j<n} C(nK − 1 + j, j) aʲ/(1 + a)^(nK+j), decreasing in a; halved
/// until it no longer changes.
#[must_use]
pub fn cfar_factor(pulses: u32, cells: u32, pfa: f64) -> f64 {
    let order = f64::from(pulses) * f64::from(cells);
    let alarm = |factor: f64| {
        let a = factor / f64::from(cells);
        let ratio = a / (1.0 + a);
        let mut term = libm::exp(-order * libm::log1p(a));
        let mut sum = 0.0;
        for j in 0..pulses {
            sum += term;
            term *= (order + f64::from(j)) / f64::from(j + 1) * ratio;
        }
        sum
    };
    let (mut low, mut high) = (0.0, 2.0);
    while alarm(high) > pfa && high < 1e12 {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if alarm(middle) > pfa { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// 2⁻³².
const STEP: f64 = 1.0 / 4_294_967_296.0;

/// Words that [`gamma_order`] takes from its stream.
fn gamma_words(order: u32) -> u64 {
    u64::from(order.div_ceil(2)) * 2
}

/// A gamma variate of whole order; 0 for order 0.
fn gamma_order(order: u32, rng: &mut ChaCha8Rng) -> f64 {
    gamma_with(1.0, order, rng)
}

/// −ln `first` and a gamma variate of whole order: minus the logarithm of a product of uniforms, one
/// logarithm for up to sixteen of them. Uniforms are the middles of 2⁻³² steps, never 0.
fn gamma_with(first: f64, order: u32, rng: &mut ChaCha8Rng) -> f64 {
    let (mut left, mut sum, mut product) = (order, 0.0, first);
    loop {
        let now = left.min(16);
        for _ in 0..now / 2 {
            let bits = rng.next_u64();
            product *= (f64::from(bits as u32) + 0.5) * (f64::from((bits >> 32) as u32) + 0.5);
            product *= STEP * STEP;
        }
        if now % 2 == 1 {
            product *= (f64::from(rng.next_u64() as u32) + 0.5) * STEP;
        }
        sum -= libm::log(product);
        left -= now;
        if left == 0 {
            return sum;
        }
        product = 1.0;
    }
}

#[cfg(test)]
mod tests;
