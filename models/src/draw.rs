//! Named random draws: every draw is a function of what it is for, not of when it was taken.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

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

/// What a draw is for. The numbers are fixed for ever: adding one disturbs no other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Purpose {
    /// Detection, range and angle noise, glint of one radar return (one stream, in this order).
    RadarReturn = 1,
    /// False alarms of one radar scan.
    FalseAlarms = 2,
    /// Fluctuation of a target's cross section from scan to scan.
    Fluctuation = 3,
    /// Cell- and video-level draws.
    Cells = 4,
    /// White part of a satellite positioning error.
    GnssWhite = 10,
    /// Driving noise of a correlated positioning error.
    GnssMarkov = 11,
    /// Coverage, availability and reliability processes.
    GnssService = 12,
    /// Reference station outages.
    ReferenceStation = 13,
    /// Satellite failures and repairs.
    Satellite = 14,
    /// ADS-B reports.
    Adsb = 20,
    /// Multilateration reports.
    Mlat = 21,
    /// Induction loops.
    Loop = 22,
    /// On-board odometry.
    Dynamic = 23,
    /// Off-line (statistical) sensor and track models.
    Offline = 30,
    /// Movers of generated traffic.
    Mover = 40,
    /// Studies: `accuracy`, random scenes.
    Study = 50,
}

impl DrawKey {
    /// The generator of this key and purpose; nothing is kept between calls.
    #[must_use]
    pub fn rng(&self, purpose: Purpose) -> ChaCha8Rng {
        let mut key = [0u8; 32];
        key[0..8].copy_from_slice(&self.run_seed.to_le_bytes());
        key[8..12].copy_from_slice(&self.sensor.to_le_bytes());
        key[12..16].copy_from_slice(&(purpose as u32).to_le_bytes());
        key[16..24].copy_from_slice(&self.entity.to_le_bytes());
        key[24..32].copy_from_slice(&self.scan.to_le_bytes());
        ChaCha8Rng::from_seed(key)
    }
}
