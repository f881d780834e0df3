//! Weather and what it does to radio waves: one effect, one file.

pub mod fog;
pub mod gas;
pub mod mie;
pub mod rain;
pub mod surface;

use crate::frames::{Point2, Vector2};

/// Speed of light, m/s.
pub const SPEED_OF_LIGHT: f64 = 299_792_458.0;

/// Wavelength of a carrier, m.
#[must_use]
pub fn wavelength_m(carrier_ghz: f64) -> f64 {
    SPEED_OF_LIGHT / (carrier_ghz * 1e9)
}

/// A round cell of heavier rain, moving with the wind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RainCell {
    /// Centre at the time of the notice, airport frame, m.
    pub centre_m: Point2<f64>,
    /// Radius, m.
    pub radius_m: f64,
    /// Rain rate inside, mm/h (in place of the uniform one where larger).
    pub rain_mm_per_h: f64,
}

/// The weather over the airport from one notice to the next.
#[derive(Clone, Debug, PartialEq)]
pub struct Weather {
    /// Uniform rain rate, mm/h, 0 to 1000.
    pub rain_mm_per_h: f64,
    /// Meteorological visibility, m; infinite when clear.
    pub visibility_m: f64,
    /// Air temperature, K.
    pub temperature_k: f64,
    /// Dry air pressure, hPa.
    pub pressure_hpa: f64,
    /// Water vapour density, g/m³.
    pub vapour_g_per_m3: f64,
    /// Wind, m/s east and north (where it blows to).
    pub wind_mps: Vector2<f64>,
    /// Pavement covered by a water film of this thickness, mm; 0 when dry.
    pub film_mm: f64,
    /// Cells of heavier rain.
    pub cells: Vec<RainCell>,
}

impl Weather {
    /// The same weather `seconds` after its notice: cells have moved with the wind.
    #[must_use]
    pub fn after(&self, seconds: f64) -> Self {
        let mut moved = self.clone();
        for cell in &mut moved.cells {
            cell.centre_m += self.wind_mps * seconds;
        }
        moved
    }

    /// Whether `other` is this weather with its cells elsewhere.
    #[must_use]
    pub fn is_moved(&self, other: &Self) -> bool {
        let cells = |w: &Self| -> Vec<(f64, f64)> {
            w.cells.iter().map(|c| (c.radius_m, c.rain_mm_per_h)).collect()
        };
        self.rain_mm_per_h == other.rain_mm_per_h
            && self.visibility_m == other.visibility_m
            && self.temperature_k == other.temperature_k
            && self.pressure_hpa == other.pressure_hpa
            && self.vapour_g_per_m3 == other.vapour_g_per_m3
            && self.film_mm == other.film_mm
            && cells(self) == cells(other)
    }
}

impl Default for Weather {
    /// Clear, dry, 15 °C, 1013.25 hPa, 7.5 g/m³ of vapour (the mean of ITU-R P.835), no wind.
    fn default() -> Self {
        Self {
            rain_mm_per_h: 0.0,
            visibility_m: f64::INFINITY,
            temperature_k: 288.15,
            pressure_hpa: 1013.25,
            vapour_g_per_m3: 7.5,
            wind_mps: Vector2::zeros(),
            film_mm: 0.0,
            cells: Vec::new(),
        }
    }
}
