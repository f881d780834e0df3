//! Named random draws: every draw is a function of what it is for, not of when it was taken.

use rand::rngs::ChaCha8Rng;
use rand::{Rng, SeedableRng};

/// What a draw belongs to. Equal keys give equal numbers in every process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DrawKey {
    /// Seed of the run.
    pub run_seed: u64,
    /// Sensor (0 where no sensor is concerned).
    pub sensor: u32,
    /// Entity key, or cell, or satellite: whatever is drawn for (0 for the sensor as a whole).
    pub entity: u64,
    /// Scan or other step number.
    pub scan: u64,
}

/// What a draw is for. The numbers are fixed for ever: adding one disturbs no other. What one kind of sensor alone draws
/// is declared in its own file as [`Purpose::Own`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Detection, range and angle noise, glint of one radar return (one stream, in this order).
    RadarReturn,
    /// False alarms of one radar scan.
    FalseAlarms,
    /// Fluctuation of a target's cross section from scan to scan.
    Fluctuation,
    /// Cell- and video-level draws.
    Cells,
    /// Reflections of a target at facades, one stream for all facades.
    Ghosts,
    /// Texture of the ground's echo in a video, the same in every scan.
    GroundTexture,
    /// White part of a satellite positioning error.
    GnssWhite,
    /// Driving noise of a correlated positioning error.
    GnssMarkov,
    /// Coverage, availability and reliability processes.
    GnssService,
    /// Reference station outages.
    ReferenceStation,
    /// Satellite failures and repairs.
    Satellite,
    /// Off-line (statistical) sensor and track models.
    Offline,
    /// Movers of generated traffic.
    Mover,
    /// Studies: `accuracy`, random scenes.
    Study,
    /// A draw of one kind of sensor alone, by its number: from 20, unlike all others.
    Own(u32),
}

impl Purpose {
    /// Those that are no sensor's own.
    pub const SHARED: [Self; 14] = [
        Self::RadarReturn,
        Self::FalseAlarms,
        Self::Fluctuation,
        Self::Cells,
        Self::Ghosts,
        Self::GroundTexture,
        Self::GnssWhite,
        Self::GnssMarkov,
        Self::GnssService,
        Self::ReferenceStation,
        Self::Satellite,
        Self::Offline,
        Self::Mover,
        Self::Study,
    ];

    /// Its number, part of the key.
    #[must_use]
    pub fn number(self) -> u32 {
        match self {
            Self::RadarReturn => 1,
            Self::FalseAlarms => 2,
            Self::Fluctuation => 3,
            Self::Cells => 4,
            Self::Ghosts => 5,
            Self::GroundTexture => 6,
            Self::GnssWhite => 10,
            Self::GnssMarkov => 11,
            Self::GnssService => 12,
            Self::ReferenceStation => 13,
            Self::Satellite => 14,
            Self::Offline => 30,
            Self::Mover => 40,
            Self::Study => 50,
            Self::Own(number) => number,
        }
    }
}

impl DrawKey {
    /// The generator of this key and purpose; nothing is kept between calls.
    #[must_use]
    pub fn rng(&self, purpose: Purpose) -> ChaCha8Rng {
        let mut key = [0u8; 32];
        key[0..8].copy_from_slice(&self.run_seed.to_le_bytes());
        key[8..12].copy_from_slice(&self.sensor.to_le_bytes());
        key[12..16].copy_from_slice(&purpose.number().to_le_bytes());
        key[16..24].copy_from_slice(&self.entity.to_le_bytes());
        key[24..32].copy_from_slice(&self.scan.to_le_bytes());
        ChaCha8Rng::from_seed(key)
    }
}

/// Uniform on [0, 1), in steps of 2⁻⁵³.
#[must_use]
pub fn uniform(rng: &mut ChaCha8Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
}

/// Exponential with mean 1: −ln(1 − u), so that a draw of exactly 0 gives 0, never infinity.
#[must_use]
pub fn exponential(rng: &mut ChaCha8Rng) -> f64 {
    -libm::log1p(-uniform(rng))
}

/// Two independent standard normal numbers (Box and Muller 1958), with `libm` only: the ziggurat of
/// `rand_distr` calls the platform's logarithm, whose bits differ from host to host.
#[must_use]
pub fn normal_pair(rng: &mut ChaCha8Rng) -> (f64, f64) {
    let (first, second) = (uniform(rng), uniform(rng));
    normal_pair_of(first, second)
}

/// The pair that [`normal_pair`] makes of two uniform draws: for draws that may not be needed.
#[must_use]
pub fn normal_pair_of(first: f64, second: f64) -> (f64, f64) {
    let radius = (-2.0 * libm::log1p(-first)).sqrt();
    let (sin, cos) = libm::sincos(std::f64::consts::TAU * second);
    (radius * cos, radius * sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variates_have_their_moments() {
        let mut rng = DrawKey { run_seed: 1, sensor: 2, entity: 3, scan: 4 }.rng(Purpose::Study);
        let n = 200_000;
        let (mut mean, mut square, mut cross, mut fourth, mut waiting) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for _ in 0..n {
            let (a, b) = normal_pair(&mut rng);
            mean += a + b;
            square += a * a + b * b;
            cross += a * b;
            fourth += a.powi(4) + b.powi(4);
            waiting += exponential(&mut rng);
            let u = uniform(&mut rng);
            assert!((0.0..1.0).contains(&u));
        }
        let n = f64::from(n);
        // Four standard deviations of each estimate.
        assert!((mean / (2.0 * n)).abs() < 4.0 / (2.0 * n).sqrt());
        assert!((square / (2.0 * n) - 1.0).abs() < 4.0 * (2.0 / (2.0 * n)).sqrt());
        assert!((cross / n).abs() < 4.0 / n.sqrt());
        assert!((fourth / (2.0 * n) - 3.0).abs() < 4.0 * (96.0 / (2.0 * n)).sqrt());
        assert!((waiting / n - 1.0).abs() < 4.0 / n.sqrt());
    }
}
