//! Fog and cloud: permittivity of water and the attenuation of droplets small against the wavelength.

use nalgebra::Complex;

/// Relative permittivity `ε' − jε''` of liquid water (double Debye).
///
/// Source: ITU-R P.840-8, eqs. (6) to (11); valid to 1000 GHz, −20 to +40 °C.
#[must_use]
pub fn water_permittivity(carrier_ghz: f64, temperature_k: f64) -> Complex<f64> {
    let f = carrier_ghz;
    let theta = 300.0 / temperature_k - 1.0;
    let e0 = 77.66 + 103.3 * theta;
    let (e1, e2) = (0.0671 * e0, 3.52);
    let fp = 20.20 - 146.0 * theta + 316.0 * theta * theta;
    let fs = 39.8 * fp;
    let (xp, xs) = (f / fp, f / fs);
    let (dp, ds) = (1.0 + xp * xp, 1.0 + xs * xs);
    let re = (e0 - e1) / dp + (e1 - e2) / ds + e2;
    let im = xp * (e0 - e1) / dp + xs * (e1 - e2) / ds;
    Complex::new(re, -im)
}

/// Specific attenuation coefficient `K_l` of droplets, (dB/km)/(g/m³).
///
/// `K_l = 0.819·f/(ε''(1 + η²))`, `η = (2 + ε')/ε''`. Source: ITU-R P.840-8, eq. (3); to 200 GHz.
#[must_use]
pub fn coefficient(carrier_ghz: f64, temperature_k: f64) -> f64 {
    let water = water_permittivity(carrier_ghz, temperature_k);
    let (re, im) = (water.re, -water.im);
    let eta = (2.0 + re) / im;
    0.819 * carrier_ghz / (im * (1.0 + eta * eta))
}

/// How liquid water follows from visibility.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum FogLaw {
    /// The straight line in log-log through the two fogs of ITU-R P.840: 0.05 g/m³ at 300 m and
    /// 0.5 g/m³ at 50 m.
    #[default]
    TwoPoint,
    /// `(0.024/V_km)^(1/0.65)` g/m³.
    Eldridge,
}

impl FogLaw {
    /// Liquid water, g/m³, at a visibility in metres; an infinite visibility holds none.
    #[must_use]
    pub fn liquid_water(self, visibility_m: f64) -> f64 {
        debug_assert!(visibility_m > 0.0);
        match self {
            Self::TwoPoint => {
                let exponent = std::f64::consts::LN_10 / libm::log(6.0);
                0.05 * libm::pow(300.0 / visibility_m, exponent)
            }
            Self::Eldridge => libm::pow(24.0 / visibility_m, 1.0 / 0.65),
        }
    }
}

/// Specific attenuation of fog, dB/km one way.
#[must_use]
pub fn specific_db_per_km(
    carrier_ghz: f64,
    temperature_k: f64,
    visibility_m: f64,
    law: FogLaw,
) -> f64 {
    if visibility_m == f64::INFINITY {
        return 0.0;
    }
    coefficient(carrier_ghz, temperature_k) * law.liquid_water(visibility_m)
}
