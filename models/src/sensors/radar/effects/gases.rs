//! Attenuation by oxygen and water vapour (ITU-R P.676): a constant of the carrier, or line by line.

use super::value::EffectValue;
use crate::effects::Level;
use crate::environment::gas;

/// The effect.
pub const VALUE: EffectValue = EffectValue {
    name: "gases",
    called_for: |setting| format!("{:.1} g/m³ of vapour", setting.weather.vapour_g_per_m3),
    levels: &[(Level::Cheap, 10), (Level::Exact, 8)],
    attenuation_db_per_km: |level, setting| {
        let (ghz, weather) = (setting.carrier_ghz, setting.weather);
        if level == Level::Cheap {
            return gas::constant_db_per_km(ghz);
        }
        let (hpa, vapour, kelvin) =
            (weather.pressure_hpa, weather.vapour_g_per_m3, weather.temperature_k);
        let (oxygen, water) = gas::specific_db_per_km(ghz, hpa, vapour, kelvin);
        oxygen + water
    },
    ..EffectValue::NOTHING
};
