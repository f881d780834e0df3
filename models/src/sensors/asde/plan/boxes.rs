//! Where a target is, as the plan counts: class, ring of distance, band of height, and which sets of its
//! sector touch it. Boxes are cells of a fixed lattice.

use std::f64::consts::TAU;

/// Sectors of azimuth, 22.5° each, from north clockwise.
pub const SECTORS: u8 = 16;

/// The ring of a ground distance by its square: edges at 100·2^(k/2) m, −1 inside 100 m.
#[must_use]
pub fn ring(ground_m2: f64) -> i8 {
    let ratio = ground_m2 * 1e-4;
    if ratio >= 1.0 {
        // The exponent of the number itself.
        ((ratio.to_bits() >> 52 & 0x7ff) as i32 - 1023).min(100) as i8
    } else {
        -1
    }
}

/// Nearest and farthest ground distance of a ring, m.
#[must_use]
pub fn ring_m(ring: i8) -> (f64, f64) {
    let edge = |k: i8| 100.0 * libm::exp2(0.5 * f64::from(k));
    if ring < 0 { (0.0, 100.0) } else { (edge(ring), edge(ring + 1)) }
}

/// Parts of a ring, of equal ratio of distance.
pub const PARTS: u8 = 4;

/// The part of its ring that a ground distance is in, by its square: from 1.
#[must_use]
pub fn part(ground_m2: f64) -> u8 {
    const EDGES: [f64; 3] =
        [1.189_207_115_002_721, std::f64::consts::SQRT_2, 1.681_792_830_507_429];
    // The fraction of the number itself, from 1 to 2.
    let within = f64::from_bits((ground_m2 * 1e-4).to_bits() & 0x000f_ffff_ffff_ffff | 1023 << 52);
    1 + EDGES.iter().filter(|edge| within >= **edge).count() as u8
}

/// Nearest and farthest ground distance of a part of a ring, m; part 0 is all of it.
#[must_use]
pub fn part_m(ring: i8, part: u8) -> (f64, f64) {
    if part == 0 || ring < 0 {
        return ring_m(ring);
    }
    let edge = |part: u8| match part {
        0 => ring_m(ring).0,
        PARTS => ring_m(ring).1,
        _ => ring_m(ring).0 * libm::exp2(0.5 * f64::from(part) / f64::from(PARTS)),
    };
    (edge(part - 1), edge(part))
}

/// The sector of an azimuth.
#[must_use]
pub fn sector(azimuth_rad: f64) -> u8 {
    let turn = azimuth_rad / TAU;
    // The azimuths that there are need no call for it.
    let whole = match turn {
        0.0..1.0 => 0.0,
        -1.0..0.0 => -1.0,
        _ => turn.floor(),
    };
    (((turn - whole) * f64::from(SECTORS)) as u8).min(SECTORS - 1)
}

/// Height below which a target is on the ground, m.
const GROUND_M: f64 = 0.5;

/// The band of a height: 0 on the ground; steps of 5 m to 30 m; of 20 m to 300 m; then doubling.
#[must_use]
pub fn band(up_m: f64) -> u8 {
    if up_m < GROUND_M {
        0
    } else if up_m < 30.0 {
        1 + (up_m / 5.0) as u8
    } else if up_m < 310.0 {
        7 + ((up_m - 30.0) / 20.0) as u8
    } else {
        let doublings = libm::log2(up_m / 310.0).floor();
        21 + doublings.min(30.0) as u8
    }
}

/// Lowest and highest place of a band, m; the ground itself has no depth.
#[must_use]
pub fn band_m(band: u8) -> (f64, f64) {
    let of = f64::from(band);
    match band {
        0 => (0.0, GROUND_M),
        1..=6 => ((5.0 * (of - 1.0)).max(GROUND_M), 5.0 * of),
        7..=20 => (30.0 + 20.0 * (of - 7.0), 50.0 + 20.0 * (of - 7.0)),
        _ => (310.0 * libm::exp2(of - 21.0), 310.0 * libm::exp2(of - 20.0)),
    }
}

/// The number of a box: what its plan depends on, beside the weather notice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// Part of the ring, from 1; 0 for all of it. Whole rings come first.
    pub part: u8,
    /// Class, by its place among those that the radar has met.
    pub class: u16,
    /// Ring of distance.
    pub ring: i8,
    /// Band of height.
    pub band: u8,
    /// Whether a rain cell touches the way to the box.
    pub rain_on_way: bool,
    /// Whether a rain cell touches the box itself.
    pub rain_here: bool,
    /// Facades that may mirror it: their sector from 1 and the size of the share of false plots; 0 without.
    pub mirrored: (u8, u8),
}

impl Key {
    /// The box of the whole ring.
    #[must_use]
    pub fn whole(self) -> Self {
        Self { part: 0, ..self }
    }

    /// The whole key in one number, which sorts alike: of two boxes the same only if they are.
    #[must_use]
    pub fn code(&self) -> u64 {
        // Bands stay below 64, facades' sectors below 32 and sizes at most at 64; rings are at most 100.
        let ring = (i16::from(self.ring) + 1) as u64;
        let flags = u64::from(self.rain_on_way) << 1 | u64::from(self.rain_here);
        u64::from(self.part) << 53
            | u64::from(self.class) << 37
            | ring << 29
            | u64::from(self.band) << 21
            | flags << 18
            | u64::from(self.mirrored.0) << 8
            | u64::from(self.mirrored.1)
    }

    /// Nearest and farthest ground distance, m.
    #[must_use]
    pub fn ground_m(&self) -> (f64, f64) {
        part_m(self.ring, self.part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn rings_and_bands_meet_without_gap_and_hold_their_edges() {
        for k in 0..24 {
            let (from, to) = ring_m(k);
            assert_eq!(ring_m(k + 1).0, to);
            // The exponent changes where the square does: a rounding of the edge is the lattice's own.
            assert_eq!(ring(from * from * (1.0 + 1e-12)), k);
            assert_eq!(ring(to * to * (1.0 - 1e-12)), k);
        }
        assert_eq!(ring(0.0), -1);
        for k in 0..24 {
            let (from, to) = ring_m(k);
            assert_eq!((part_m(k, 1).0, part_m(k, PARTS).1, part_m(k, 0)), (from, to, (from, to)));
            for n in 1..PARTS {
                let (edge, next) = (part_m(k, n).1, part_m(k, n + 1).0);
                assert_eq!(edge, next);
                assert_eq!(part(edge * edge * (1.0 - 1e-12)), n);
                assert_eq!(part(edge * edge * (1.0 + 1e-12)), n + 1);
            }
        }
        for b in 1..40 {
            assert_eq!(band_m(b - 1).1, band_m(b).0, "{b}");
        }
    }

    proptest! {
        #[test]
        fn every_place_is_in_its_box(d in 0.0..60_000.0f64, up in -5.0..20_000.0f64, azimuth in -10.0..10.0f64) {
            let (from, to) = ring_m(ring(d * d));
            prop_assert!(d >= from * (1.0 - 1e-12) && d <= to * (1.0 + 1e-12));
            let (low, high) = band_m(band(up));
            prop_assert!(up <= high && (up >= low || band(up) == 0), "{up} in {low} to {high}");
            prop_assert!(sector(azimuth) < SECTORS);
            let (from, to) = part_m(ring(d * d), part(d * d));
            prop_assert!(ring(d * d) < 0 || d >= from * (1.0 - 1e-12) && d <= to * (1.0 + 1e-12));
        }
    }
}
