//! Rain: attenuation, volume reflectivity, and what circular polarisation rejects of its echo.

use super::Weather;
use crate::frames::Point2;
use std::f64::consts::PI;

/// Coefficients of the power law `γ = k·R^α` at one carrier, for a horizontal path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RainLaw {
    /// Factor, dB/km at 1 mm/h.
    pub k: f64,
    /// Exponent.
    pub alpha: f64,
}

impl RainLaw {
    /// The law at `carrier_ghz` for a path elevation and a polarisation tilt
    /// (0 horizontal, π/2 vertical, π/4 circular).
    ///
    /// Source: ITU-R P.838-3, eqs. (2) to (5). Valid 1 to 1000 GHz.
    #[must_use]
    pub fn new(carrier_ghz: f64, elevation_rad: f64, tilt_rad: f64) -> Self {
        let log_f = libm::log10(carrier_ghz);
        let k_h = libm::pow(10.0, fit(log_f, &K_H));
        let k_v = libm::pow(10.0, fit(log_f, &K_V));
        let (alpha_h, alpha_v) = (fit(log_f, &ALPHA_H), fit(log_f, &ALPHA_V));
        let cos_el = libm::cos(elevation_rad);
        let w = cos_el * cos_el * libm::cos(2.0 * tilt_rad);
        let k = 0.5 * (k_h + k_v + (k_h - k_v) * w);
        let (ha, va) = (k_h * alpha_h, k_v * alpha_v);
        Self { k, alpha: (ha + va + (ha - va) * w) / (2.0 * k) }
    }

    /// Specific attenuation, dB/km one way, `γ = k·R^α`. No rain gives exactly zero, so a dry scene
    /// and a skipped effect agree bit for bit. Source: ITU-R P.838-3, eq. (1).
    #[must_use]
    pub fn specific_db_per_km(&self, rain_mm_per_h: f64) -> f64 {
        debug_assert!(rain_mm_per_h >= 0.0);
        if rain_mm_per_h == 0.0 {
            return 0.0;
        }
        self.k * libm::pow(rain_mm_per_h, self.alpha)
    }

    /// Two-way loss over `path_km` of uniform rain, dB.
    #[must_use]
    pub fn two_way_db(&self, rain_mm_per_h: f64, path_km: f64) -> f64 {
        2.0 * self.specific_db_per_km(rain_mm_per_h) * path_km
    }

    /// Specific attenuation by a straight line through the origin that meets the law at 16 mm/h:
    /// the cheap form, within 0.3 dB of the law over 11 km of 4 to 16 mm/h at 16 GHz.
    #[must_use]
    pub fn linear_db_per_km(&self, rain_mm_per_h: f64) -> f64 {
        self.specific_db_per_km(16.0) / 16.0 * rain_mm_per_h
    }
}

/// `Σ aⱼ·exp(−((x − bⱼ)/cⱼ)²) + m·x + q`.
fn fit<const N: usize>(x: f64, table: &Fit<N>) -> f64 {
    let mut sum = 0.0;
    for [a, b, c] in table.terms {
        let z = (x - b) / c;
        sum += a * libm::exp(-z * z);
    }
    sum + table.m * x + table.q
}

struct Fit<const N: usize> {
    terms: [[f64; 3]; N],
    m: f64,
    q: f64,
}

// ITU-R P.838-3, Tables 1 to 4.
const K_H: Fit<4> = Fit {
    terms: [
        [-5.33980, -0.10008, 1.13098],
        [-0.35351, 1.26970, 0.45400],
        [-0.23789, 0.86036, 0.15354],
        [-0.94158, 0.64552, 0.16817],
    ],
    m: -0.18961,
    q: 0.71147,
};
const K_V: Fit<4> = Fit {
    terms: [
        [-3.80595, 0.56934, 0.81061],
        [-3.44965, -0.22911, 0.51059],
        [-0.39902, 0.73042, 0.11899],
        [0.50167, 1.07319, 0.27195],
    ],
    m: -0.16398,
    q: 0.63297,
};
const ALPHA_H: Fit<5> = Fit {
    terms: [
        [-0.14318, 1.82442, -0.55187],
        [0.29591, 0.77564, 0.19822],
        [0.32177, 0.63773, 0.13164],
        [-5.37610, -0.96230, 1.47828],
        [16.1721, -3.29980, 3.43990],
    ],
    m: 0.67849,
    q: -1.95537,
};
const ALPHA_V: Fit<5> = Fit {
    terms: [
        [-0.07771, 2.33840, -0.76284],
        [0.56727, 0.95545, 0.54039],
        [-0.20238, 1.14520, 0.26809],
        [-48.2991, 0.791669, 0.116226],
        [48.5833, 0.791459, 0.116479],
    ],
    m: -0.053739,
    q: 0.83433,
};

/// Volume reflectivity of rain in the Rayleigh region, m²/m³.
///
/// `η = π⁵·|K|²·Z·10⁻¹⁸/λ⁴` with `|K|² = 0.93` and `Z = 200·R^1.6` mm⁶/m³ (Marshall & Palmer 1948).
#[must_use]
pub fn reflectivity(carrier_ghz: f64, rain_mm_per_h: f64) -> f64 {
    if rain_mm_per_h == 0.0 {
        return 0.0;
    }
    let lambda = super::wavelength_m(carrier_ghz);
    let z = 200.0 * libm::pow(rain_mm_per_h, 1.6);
    let squared = lambda * lambda;
    let pi_5 = PI * PI * PI * PI * PI;
    pi_5 * 0.93 * z * 1e-18 / (squared * squared)
}

/// Rejection of the rain echo by circular polarisation because drops are oblate, dB.
///
/// `26.1 − 5.9·L + 0.8·L²`, `L = log₁₀ max(R, 0.1)`: a fit to oblate Rayleigh drops with axis ratio
/// `min(1, 1.03 − 0.062·D)` over the Marshall-Palmer spectrum, within 0.2 dB from 0.5 to 150 mm/h.
#[must_use]
pub fn drop_rejection_db(rain_mm_per_h: f64) -> f64 {
    let l = libm::log10(rain_mm_per_h.max(0.1));
    26.1 - 5.9 * l + 0.8 * l * l
}

/// Fraction of the rain echo that a circularly polarised radar receives: its own axial ratio lets
/// `((r²−1)/(r²+1))²` through, oblate drops `10^(−ICR/10)`.
#[must_use]
pub fn circular_fraction(axial_ratio_db: f64, rain_mm_per_h: f64) -> f64 {
    leaked_fraction(axial_ratio_db, drop_rejection_db(rain_mm_per_h))
}

/// The same from the rejection of the drops in dB.
#[must_use]
pub fn leaked_fraction(axial_ratio_db: f64, rejection_db: f64) -> f64 {
    // r = 10^(AR/20), so (r² − 1)/(r² + 1) = tanh(ln(10)·AR/20): no difference of near numbers.
    let leak = libm::tanh(std::f64::consts::LN_10 * axial_ratio_db / 20.0);
    leak * leak + libm::pow(10.0, -0.1 * rejection_db)
}

/// A straight piece of a path with one rain rate.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Crossing {
    from: f64,
    to: f64,
    rain_mm_per_h: f64,
}

/// Mean of `f(rain)` along the straight ground path from `from` to `to`, cells included.
///
/// A cell counts with its own rate where it is heavier than the uniform rain; where cells overlap,
/// the heaviest counts. Exact for round cells: the path is cut where it enters and leaves each cell.
#[must_use]
pub fn path_mean(
    weather: &Weather,
    from: Point2<f64>,
    to: Point2<f64>,
    f: impl Fn(f64) -> f64,
) -> f64 {
    let uniform = weather.rain_mm_per_h;
    let mut crossings: Vec<Crossing> = Vec::new();
    for cell in weather.cells.iter().filter(|c| c.rain_mm_per_h > uniform) {
        if let Some((enter, leave)) = chord(from, to, cell.centre_m, cell.radius_m) {
            crossings.push(Crossing { from: enter, to: leave, rain_mm_per_h: cell.rain_mm_per_h });
        }
    }
    if crossings.is_empty() {
        return f(uniform);
    }
    let mut cuts: Vec<f64> = crossings.iter().flat_map(|c| [c.from, c.to]).collect();
    cuts.extend([0.0, 1.0]);
    cuts.sort_by(f64::total_cmp);
    let mut mean = 0.0;
    for pair in cuts.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        if b <= a {
            continue;
        }
        let middle = 0.5 * (a + b);
        let here = crossings.iter().filter(|c| c.from <= middle && middle <= c.to);
        mean += (b - a) * f(here.fold(uniform, |rain, c| rain.max(c.rain_mm_per_h)));
    }
    mean
}

/// The part of the segment inside a circle, as fractions of its length.
fn chord(
    from: Point2<f64>,
    to: Point2<f64>,
    centre: Point2<f64>,
    radius: f64,
) -> Option<(f64, f64)> {
    let (along, start) = (to - from, from - centre);
    let a = along.norm_squared();
    let inside = radius * radius - start.norm_squared();
    if a == 0.0 {
        return (inside > 0.0).then_some((0.0, 1.0));
    }
    let b = along.dot(&start);
    let discriminant = b * b + a * inside;
    if discriminant <= 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let (enter, leave) = (((-b - root) / a).max(0.0), ((-b + root) / a).min(1.0));
    (enter < leave).then_some((enter, leave))
}

impl Weather {
    /// Rain rate at a place, mm/h: the heaviest cell over it, or the uniform rate.
    #[must_use]
    pub fn rain_at(&self, place_m: Point2<f64>) -> f64 {
        self.cells.iter().fold(self.rain_mm_per_h, |rain, cell| {
            let inside = (place_m - cell.centre_m).norm_squared() < cell.radius_m * cell.radius_m;
            if inside { rain.max(cell.rain_mm_per_h) } else { rain }
        })
    }

    /// The heaviest rain anywhere, mm/h.
    #[must_use]
    pub fn heaviest_mm_per_h(&self) -> f64 {
        self.cells.iter().fold(self.rain_mm_per_h, |rain, cell| rain.max(cell.rain_mm_per_h))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::RainCell;
    use crate::frames::Vector2;

    fn with_cell(uniform: f64, centre: (f64, f64), radius_m: f64, rain: f64) -> Weather {
        let centre_m = Point2::new(centre.0, centre.1);
        let cells = vec![RainCell { centre_m, radius_m, rain_mm_per_h: rain }];
        Weather { rain_mm_per_h: uniform, cells, ..Weather::default() }
    }

    #[test]
    fn a_cell_counts_with_its_chord() {
        let weather = with_cell(1.0, (500.0, 0.0), 100.0, 16.0);
        let path = |w: &Weather, y: f64| {
            path_mean(w, Point2::new(0.0, y), Point2::new(1000.0, y), |rain| rain)
        };
        assert!((path(&weather, 0.0) - (0.8 + 0.2 * 16.0)).abs() < 1e-12);
        assert!((path(&weather, 60.0) - (0.84 + 0.16 * 16.0)).abs() < 1e-12);
        assert_eq!(path(&weather, 100.0), 1.0);
        let mut two = weather.clone();
        two.cells.push(two.cells[0]);
        assert!((path(&two, 0.0) - path(&weather, 0.0)).abs() < 1e-12, "an overlap counts once");
        let lighter = with_cell(20.0, (500.0, 0.0), 100.0, 16.0);
        assert_eq!(path(&lighter, 0.0), 20.0);
    }

    #[test]
    fn a_target_at_the_radar_sees_the_rain_over_it() {
        let weather = with_cell(1.0, (0.0, 0.0), 100.0, 16.0);
        let here = Point2::origin();
        assert_eq!(path_mean(&weather, here, here, |rain| rain), 16.0);
        assert_eq!(weather.rain_at(here), 16.0);
    }

    #[test]
    fn a_cell_drifts_with_the_wind_and_stays_the_same_weather() {
        let mut weather = with_cell(1.0, (0.0, 0.0), 100.0, 16.0);
        weather.wind_mps = Vector2::new(5.0, -2.0);
        let later = weather.after(60.0);
        assert_eq!(later.rain_at(Point2::new(300.0, -120.0)), 16.0);
        assert_eq!(later.rain_at(Point2::origin()), 1.0);
        assert!(weather.is_moved(&later));
        let heavier = Weather { rain_mm_per_h: 2.0, ..later };
        assert!(!weather.is_moved(&heavier));
    }

    #[test]
    fn a_rotationally_perfect_antenna_still_sees_oblate_drops() {
        let fraction = circular_fraction(0.0, 16.0);
        assert!((10.0 * libm::log10(fraction) + drop_rejection_db(16.0)).abs() < 1e-12);
        assert!((10.0 * libm::log10(circular_fraction(1.0, 1e-9)) + 18.6).abs() < 0.2);
    }
}
