//! Compact position reports: latitude and longitude in 17 bits each, even and odd.
//!
//! A zone is `D = 360° / (60 − i)` high (surface: a quarter of it), `i` 0 for even and 1 for odd reports, and as wide as the
//! number of longitude zones `NL` at the latitude that was written allows.

/// Steps of a coordinate within its zone.
const STEPS: f64 = 131_072.0;

/// One report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report {
    /// Latitude within its zone, 17 bits.
    pub lat: u32,
    /// Longitude within its zone, 17 bits.
    pub lon: u32,
    /// Odd zones.
    pub odd: bool,
}

/// Size of all zones together, degrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Span {
    /// Airborne: 360°.
    Airborne,
    /// Surface: 90°, four times as fine.
    Surface,
}

impl Span {
    fn degrees(self) -> f64 {
        match self {
            Self::Airborne => 360.0,
            Self::Surface => 90.0,
        }
    }
}

/// Number of longitude zones at a latitude: 59 at the equator, 1 beyond 87°.
#[must_use]
pub fn longitude_zones(lat_deg: f64) -> u32 {
    let lat_deg = lat_deg.abs();
    if !(lat_deg < 87.0) {
        return if lat_deg == 87.0 { 2 } else { 1 };
    }
    let cosine = libm::cos(lat_deg.to_radians());
    let share = (1.0 - libm::cos(std::f64::consts::PI / 30.0)) / (cosine * cosine);
    libm::floor(2.0 * std::f64::consts::PI / libm::acos(1.0 - share)) as u32
}

fn modulo(a: f64, b: f64) -> f64 {
    a - b * libm::floor(a / b)
}

/// Writes a position.
#[must_use]
pub fn encode(lat_deg: f64, lon_deg: f64, odd: bool, span: Span) -> Report {
    let i = u32::from(odd);
    let height_deg = span.degrees() / f64::from(60 - i);
    let yz = libm::floor(STEPS * modulo(lat_deg, height_deg) / height_deg + 0.5);
    let written_deg = height_deg * (yz / STEPS + libm::floor(lat_deg / height_deg));
    let zones = longitude_zones(written_deg).saturating_sub(i).max(1);
    let width_deg = span.degrees() / f64::from(zones);
    let xz = libm::floor(STEPS * modulo(lon_deg, width_deg) / width_deg + 0.5);
    Report { lat: yz as u32 % 131_072, lon: xz as u32 % 131_072, odd }
}

/// Reads a position, given one within half a zone of it (22 NM on the surface): latitude and longitude, degrees.
#[must_use]
pub fn decode(report: Report, near_deg: [f64; 2], span: Span) -> [f64; 2] {
    let i = u32::from(report.odd);
    let nearest = |near_deg: f64, share: f64, zone_deg: f64| {
        let zone = libm::floor(0.5 + near_deg / zone_deg - share);
        zone_deg * (zone + share)
    };
    let height_deg = span.degrees() / f64::from(60 - i);
    let lat_deg = nearest(near_deg[0], f64::from(report.lat) / STEPS, height_deg);
    let zones = longitude_zones(lat_deg).saturating_sub(i).max(1);
    let width_deg = span.degrees() / f64::from(zones);
    [lat_deg, nearest(near_deg[1], f64::from(report.lon) / STEPS, width_deg)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn zones_shrink_towards_the_poles() {
        for (lat_deg, zones) in [
            (0.0, 59),
            (10.470_471, 59),
            (10.470_472, 58),
            (47.4, 40),
            (-47.4, 40),
            (86.9, 2),
            (87.0, 2),
            (88.0, 1),
        ] {
            assert_eq!(longitude_zones(lat_deg), zones, "{lat_deg}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

        /// Half a step: 1.4 m (360/59·2⁻¹⁷·60 NM) in the air in latitude at most 2.6 m, a quarter on the surface.
        #[test]
        fn what_is_written_is_read_near_by(
            lat in -86.0..86.0_f64, lon in -180.0..180.0_f64, odd: bool, surface: bool,
            north in -0.15..0.15_f64, east in -0.15..0.15_f64,
        ) {
            let span = if surface { Span::Surface } else { Span::Airborne };
            let near = [lat + north, lon + east];
            let [found_lat, found_lon] = decode(encode(lat, lon, odd, span), near, span);
            let step_m = if surface { 0.7 } else { 2.7 };
            prop_assert!((found_lat - lat).abs() * 111_320.0 <= step_m, "{found_lat}");
            // The width of a zone grows as circles of latitude shrink: at most 6.4° · 2⁻¹⁸ at the equator's scale.
            let off_deg = libm::remainder(found_lon - lon, 360.0).abs();
            let zones = longitude_zones(found_lat).saturating_sub(u32::from(odd)).max(1);
            prop_assert!(off_deg <= span.degrees() / f64::from(zones) / STEPS * 0.501, "{found_lon}");
        }
    }
}
