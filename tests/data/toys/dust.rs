//! A toy: dust in the air, none unless a scene says so. It attenuates, returns an echo of its own from every cell, and
//! delays. The figures are made up.

use super::value::{AtPlace, Change, ChangeSpan, EffectValue, Setting};
use crate::effects::Level;
use crate::keys::Key;
use crate::sensors::radar::span::Span;

/// The effect.
pub const VALUE: EffectValue = EffectValue {
    name: "dust",
    keys: &[Key::number("dust_g_per_m3", "g/m³", 0.0, 10.0, "Dust in the air").or("0")],
    called_for: |setting| format!("{} g/m³ of dust", dust(setting)),
    levels: &[(Level::Cheap, 5), (Level::Exact, 30)],
    attenuation_db_per_km: |_, setting| 0.02 * setting.carrier_ghz * dust(setting),
    at_place: Some(AtPlace {
        at: |level, setting, place| {
            let exact = level == Level::Exact;
            Change {
                clutter_m2: if exact { clutter_m2(setting, place.range_m) } else { 0.0 },
                along_m: if exact { 1e-4 * dust(setting) * place.range_m } else { 0.0 },
                ..Change::default()
            }
        },
        // The cell's volume and the delay grow with the range.
        over: |level, setting, places| {
            let (near, far) = (places.range_m.low, places.range_m.high);
            let ends = |of: &dyn Fn(f64) -> f64| match level {
                Level::Exact => Span { low: of(near), high: of(far) },
                _ => Span::default(),
            };
            ChangeSpan {
                clutter_m2: ends(&|range_m| clutter_m2(setting, range_m)),
                along_m: ends(&|range_m| 1e-4 * dust(setting) * range_m),
                ..ChangeSpan::default()
            }
        },
    }),
    ..EffectValue::NOTHING
};

fn dust(setting: &Setting<'_>) -> f64 {
    setting.own("dust_g_per_m3", 0.0)
}

/// What the dust of a cell returns, a layer of ten metres.
fn clutter_m2(setting: &Setting<'_>, range_m: f64) -> f64 {
    1e-7 * dust(setting) * setting.cell_m * range_m * setting.azimuth_rad * 10.0
}
