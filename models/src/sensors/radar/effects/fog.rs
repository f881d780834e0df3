//! Attenuation by fog: Rayleigh absorption of its water (ITU-R P.840), the same along the whole way.

use super::value::EffectValue;
use crate::effects::Level;
use crate::environment::fog;

/// The effect.
pub const VALUE: EffectValue = EffectValue {
    name: "fog",
    called_for: |setting| format!("visibility {} m", setting.weather.visibility_m),
    levels: &[(Level::Exact, 11)],
    attenuation_db_per_km: |_, setting| {
        let weather = setting.weather;
        let (kelvin, visibility_m) = (weather.temperature_k, weather.visibility_m);
        fog::specific_db_per_km(setting.carrier_ghz, kelvin, visibility_m, setting.fog_law)
    },
    ..EffectValue::NOTHING
};
