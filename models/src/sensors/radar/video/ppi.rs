//! The picture of a scan as an operator sees it: plan position, north up, in the colours of a radar tube.

use super::{CellRadar, Video};
use std::f64::consts::TAU;

/// An image: rows from the top, three octets a pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels across and down.
    pub size: usize,
    /// Red, green, blue of every pixel.
    pub rgb: Vec<u8>,
}

/// How a video becomes a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ppi {
    /// Pixels across and down.
    pub size: usize,
    /// Range at the rim, m.
    pub rim_m: f64,
    /// Distance between range rings, m.
    pub ring_m: f64,
    /// Height of the antenna, m: the picture shows ground distance.
    pub antenna_m: f64,
    /// Sensitivity time control: share of the mean level of each range (its median over all azimuths, in
    /// decibels) that is taken away, so that near clutter does not drown what is in it.
    pub stc: f64,
    /// Level that is black, dB over thermal noise after the sensitivity time control.
    pub black_db: f64,
    /// Level that is brightest, dB likewise.
    pub white_db: f64,
}

impl Ppi {
    /// Draws the video.
    #[must_use]
    pub fn draw(&self, radar: &CellRadar, video: &Video) -> Picture {
        let n = self.size;
        let gain = self.gain_by_range(video);
        let mut rgb = vec![0u8; 3 * n * n];
        let scale_m = 2.0 * self.rim_m / n as f64;
        let middle = 0.5 * n as f64;
        for y in 0..n {
            for x in 0..n {
                // Four points a pixel.
                let mut power = 0.0;
                let mut inside = 0;
                for (dx, dy) in [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)] {
                    let east_m = (x as f64 + dx - middle) * scale_m;
                    let north_m = (middle - y as f64 - dy) * scale_m;
                    if let Some(p) = self.power(radar, video, &gain, east_m, north_m) {
                        power += p;
                        inside += 1;
                    }
                }
                let at = 3 * (y * n + x);
                let colour =
                    if inside == 0 { [0.0; 3] } else { self.colour(power / f64::from(inside)) };
                for (slot, part) in rgb[at..at + 3].iter_mut().zip(colour) {
                    *slot = (part * 255.0).round().clamp(0.0, 255.0) as u8;
                }
            }
        }
        let mut picture = Picture { size: n, rgb };
        self.graticule(&mut picture);
        picture
    }

    /// The power of the cell at a place; `None` outside what the radar displays.
    fn power(
        &self,
        radar: &CellRadar,
        video: &Video,
        gain: &[f64],
        east_m: f64,
        north_m: f64,
    ) -> Option<f64> {
        let ground2 = east_m * east_m + north_m * north_m;
        if ground2 > self.rim_m * self.rim_m {
            return None;
        }
        let range_m = (ground2 + self.antenna_m * self.antenna_m).sqrt();
        let cell = ((range_m - radar.range_min_m) / radar.cell_m).floor();
        if cell < 0.0 || cell >= video.cells as f64 {
            return Some(0.0);
        }
        let turn = libm::atan2(east_m, north_m) / TAU;
        let beam = ((turn - turn.floor()) * video.beams as f64) as usize;
        let cell = cell as usize;
        let power = video.power[beam.min(video.beams - 1) * video.cells + cell];
        Some(f64::from(power) * gain[cell])
    }

    /// What the sensitivity time control leaves of each range, a power factor.
    fn gain_by_range(&self, video: &Video) -> Vec<f64> {
        let mut column = vec![0.0f32; video.beams];
        let gain = |cell: usize| {
            for (beam, slot) in column.iter_mut().enumerate() {
                *slot = video.power[beam * video.cells + cell];
            }
            column.sort_unstable_by(f32::total_cmp);
            let median = f64::from(column[video.beams / 2]).max(1.0);
            libm::pow(median, -self.stc)
        };
        (0..video.cells).map(gain).collect()
    }

    /// Black over deep green to a pale yellow, by decibels over noise.
    fn colour(&self, power: f64) -> [f64; 3] {
        let db = 10.0 * libm::log10(power.max(1e-6));
        let v = ((db - self.black_db) / (self.white_db - self.black_db)).clamp(0.0, 1.0);
        [
            0.02 + 0.95 * v * v * v,
            0.04 + 0.93 * libm::pow(v, 0.8),
            0.05 + 0.1 * v + 0.5 * v * v * v * v,
        ]
    }

    /// Range rings with their distances and a tick every ten degrees.
    fn graticule(&self, picture: &mut Picture) {
        let n = self.size;
        let middle = 0.5 * n as f64;
        let pixel_m = 2.0 * self.rim_m / n as f64;
        let mut dot = |x: f64, y: f64, strength: f64| {
            if x >= 0.0 && y >= 0.0 && x < n as f64 && y < n as f64 {
                let at = 3 * (y as usize * n + x as usize);
                for (slot, part) in picture.rgb[at..at + 3].iter_mut().zip([0.25, 0.45, 0.6]) {
                    let now = f64::from(*slot);
                    *slot = (now + (part * 255.0 - now).max(0.0) * strength) as u8;
                }
            }
        };
        let mut ring_m = self.ring_m;
        while ring_m <= self.rim_m {
            let radius = (ring_m / pixel_m).min(middle - 1.0);
            let steps = (TAU * radius).ceil() as u32;
            for i in 0..steps {
                let (sin, cos) = libm::sincos(f64::from(i) / f64::from(steps) * TAU);
                dot(middle + radius * sin, middle - radius * cos, 0.45);
            }
            // Metres, beside the ring to the north.
            let text = format!("{ring_m:.0}");
            for (place, digit) in text.bytes().enumerate() {
                let rows = DIGITS[usize::from(digit.saturating_sub(b'0')).min(9)];
                for (row, bits) in rows.iter().enumerate() {
                    for column in 0..3u32 {
                        if bits >> (2 - column) & 1 == 1 {
                            for (i, j) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                                let x = middle + 6.0 + 8.0 * place as f64 + 2.0 * f64::from(column);
                                let y = middle - radius + 4.0 + 2.0 * row as f64;
                                dot(x + i, y + j, 1.0);
                            }
                        }
                    }
                }
            }
            ring_m += self.ring_m;
        }
        for ten in 0..36u32 {
            let (sin, cos) = libm::sincos(f64::from(ten) / 36.0 * TAU);
            let long = if ten % 9 == 0 { 24 } else { 10 };
            for i in 0..long {
                let radius = middle - 1.0 - f64::from(i);
                dot(middle + radius * sin, middle - radius * cos, 0.9);
            }
        }
    }
}

/// Digits of three by five dots, rows from the top, the left dot in the highest of three bits.
const DIGITS: [[u8; 5]; 10] = [
    [7, 5, 5, 5, 7],
    [2, 6, 2, 2, 7],
    [7, 1, 7, 4, 7],
    [7, 1, 7, 1, 7],
    [5, 5, 7, 1, 1],
    [7, 4, 7, 1, 7],
    [7, 4, 7, 5, 7],
    [7, 1, 2, 2, 2],
    [7, 5, 7, 5, 7],
    [7, 5, 7, 1, 7],
];

#[cfg(test)]
mod tests;
