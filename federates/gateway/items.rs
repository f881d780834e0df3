//! What texts, codes and levels look like inside items.

use models::flight_list::WakeCategory;

/// One foot, m.
pub const FOOT_M: f64 = 0.3048;

/// A call sign as six-bit characters carry it: capitals, digits and spaces, at most eight.
#[must_use]
pub fn ident(text: &str) -> String {
    let capitals = text.chars().map(|c| c.to_ascii_uppercase());
    capitals.filter(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || *c == ' ').take(8).collect()
}

/// The first `most` characters that ASCII has.
#[must_use]
pub fn ascii(text: &str, most: usize) -> String {
    text.chars().filter(|c| (' '..='~').contains(c)).take(most).collect()
}

/// Number of a vehicle's fleet in categories 010, 020 and 062.
#[must_use]
pub fn fleet(designator: &str) -> u8 {
    match designator {
        "FOLLOWME" => 16,
        "FIRE" => 3,
        "SNOW" => 5,
        "BUS" => 9,
        "TUG" => 10,
        "FUEL" => 12,
        _ => 0,
    }
}

/// The same in category 011, where follow-me and unknown change places.
#[must_use]
pub fn fleet_011(designator: &str) -> u8 {
    match fleet(designator) {
        16 => 0,
        0 => 16,
        other => other,
    }
}

/// Emitter category of an aircraft by its wake category, of a vehicle by its type.
#[must_use]
pub fn emitter(aircraft: bool, wake: Option<WakeCategory>, designator: &str) -> u8 {
    match (aircraft, wake) {
        (false, _) if designator == "FIRE" => 20,
        (false, _) => 21,
        (true, Some(WakeCategory::Light)) => 1,
        (true, Some(WakeCategory::Medium)) => 3,
        (true, Some(WakeCategory::Heavy | WakeCategory::Super)) => 5,
        (true, None) => 0,
    }
}

/// Navigation accuracy category of a position by the variances of its axes, m².
///
/// The 95 % radius is taken as 2.45 times the larger standard deviation (a circle around the ellipse).
#[must_use]
pub fn nac_p([ee_m2, en_m2, nn_m2]: [f64; 3]) -> u8 {
    let (mean_m2, half_m2) = ((ee_m2 + nn_m2) / 2.0, (ee_m2 - nn_m2) / 2.0);
    let largest_m2 = mean_m2 + (half_m2 * half_m2 + en_m2 * en_m2).sqrt();
    let radius_m = 2.447_746_830_680_816 * largest_m2.max(0.0).sqrt();
    let limits = [
        (3.0, 11),
        (10.0, 10),
        (30.0, 9),
        (92.6, 8),
        (185.2, 7),
        (555.6, 6),
        (926.0, 5),
        (1852.0, 4),
        (3704.0, 3),
        (7408.0, 2),
        (18_520.0, 1),
    ];
    limits.iter().find(|(limit_m, _)| radius_m <= *limit_m).map_or(0, |(_, category)| *category)
}

/// `sign · √|x|`.
#[must_use]
pub fn signed_root(x: f64) -> f64 {
    x.abs().sqrt().copysign(x)
}

/// Pressure altitude of a height above the sea, m, where the pressure at the reference is `pressure_hpa`.
///
/// `h_p = 44330.77 · (1 − (p₀ / 1013.25)^0.190263) + z`. Source: ICAO standard atmosphere (Doc 7488) below 11 km.
#[must_use]
pub fn pressure_altitude_m(height_m: f64, pressure_hpa: f64) -> f64 {
    44_330.77 * (1.0 - libm::pow(pressure_hpa / 1013.25, 0.190_263)) + height_m
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_fit_their_fields() {
        assert_eq!(ident("follow_me 12"), "FOLLOWME");
        assert_eq!(ascii("Zürich 1", 7), "Zrich 1");
        assert_eq!((fleet("FOLLOWME"), fleet_011("FOLLOWME")), (16, 0));
        assert_eq!((fleet("CAR"), fleet_011("CAR")), (0, 16));
        assert_eq!((fleet("BUS"), fleet_011("BUS")), (9, 9));
        assert_eq!(["L", "M", "J"].map(|w| emitter(true, WakeCategory::of(w), "")), [1, 3, 5]);
        assert_eq!(emitter(false, None, "FIRE"), 20);
    }

    #[test]
    fn accuracy_categories_follow_the_larger_axis() {
        for (cov_m2, category) in [
            ([1.0, 0.0, 1.0], 11),
            ([16.0, 0.0, 1.0], 10),
            ([10.0, 9.9, 10.0], 9),
            ([1e6, 0.0, 1.0], 3),
            ([1e9, 0.0, 1.0], 0),
        ] {
            assert_eq!(nac_p(cov_m2), category, "{cov_m2:?}");
        }
        assert_eq!(signed_root(-4.0), -2.0);
    }

    #[test]
    fn pressure_altitude_follows_the_standard_atmosphere() {
        assert!((pressure_altitude_m(432.0, 1013.25) - 432.0).abs() < 1e-9);
        // 8.23 m a hectopascal near the ground.
        let lower_m = pressure_altitude_m(0.0, 1003.25);
        assert!((lower_m - 83.6).abs() < 0.5, "{lower_m}");
    }
}
