//! What every simulated effect did to one plot.

use super::Asde;
use super::echo::Return;
use super::measuring::Draws;
use crate::effects::Level;
use crate::plot::Plot;
use crate::sensors::Contribution;
use crate::sensors::TargetClass;
use crate::sensors::radar::detection::to_db;
use crate::sensors::radar::effects::{RadarEffect, VALUES};
use crate::sensors::radar::equation::{Air, Budget, BudgetLevels, Echo, Reflection};
use crate::sensors::radar::levels::{Processing, RadarLevels};

impl Asde {
    /// Contributions to one plot: for effects in decibels, the ratio with everything simulated
    /// against the ratio without this one effect; for the others, what they moved.
    pub(super) fn explain(
        &self,
        air: &Air,
        class: &TargetClass,
        r: &Return,
        draws: &Draws,
        plot: &Plot,
    ) -> Vec<Contribution> {
        let levels = r.levels;
        let target_m = r.look.state.position_m.xy();
        let ground_m = (target_m - self.site_m).norm();
        let height_m = r.look.state.position_m.z.max(0.5 * class.height_m);
        let echo = Echo { ground_m, height_m, extent_m: class.height_m, rcs_m2: class.rcs_m2 };
        let budget = |levels: &BudgetLevels| -> Budget {
            self.radar.budget(air, levels, &echo, self.site_m, target_m)
        };
        let all = budget(&levels.budget);
        let mut out = Vec::new();
        let mut add = |effect: RadarEffect, value: f64, unit| {
            out.push(Contribution { effect: effect.name(), value, unit });
        };
        let values = VALUES.iter().map(|(effect, _)| *effect);
        for effect in ATTENUATES.into_iter().chain(values).chain(IN_DB) {
            let without = levels.with(effect, Level::Skipped).budget;
            if without == levels.budget || !is_on(effect, &levels) {
                continue;
            }
            let alone = budget(&without);
            let moved_m =
                libm::hypot(all.moved_m.0 - alone.moved_m.0, all.moved_m.1 - alone.moved_m.1);
            if moved_m != 0.0 {
                add(effect, moved_m, "m");
            } else {
                add(effect, to_db(all.scnr()) - to_db(alone.scnr()), "dB");
            }
        }
        for (effect, db) in [
            (RadarEffect::BuildingShadow, r.shadow.buildings_db),
            (RadarEffect::AircraftShadow, r.shadow.aircraft_db),
        ] {
            if db > 0.0 {
                add(effect, -db, "dB");
            }
        }
        if r.bias_along_m != 0.0 || r.bias_across_m != 0.0 {
            add(RadarEffect::Extent, libm::hypot(r.bias_along_m, r.bias_across_m), "m");
        }
        let in_cells = levels.processing != Processing::Plot;
        if in_cells {
            let moved = libm::hypot(draws.glint_along_m, draws.glint_across_m);
            add(RadarEffect::Processing, moved, "m");
        } else if draws.glint_along_m != 0.0 || draws.glint_across_m != 0.0 {
            add(RadarEffect::Glint, libm::hypot(draws.glint_along_m, draws.glint_across_m), "m");
        }
        if levels.thermal_range && !in_cells {
            add(RadarEffect::ThermalRange, draws.range_m, "m");
        }
        if levels.thermal_azimuth && !in_cells {
            add(RadarEffect::ThermalAzimuth, draws.azimuth_rad * ground_m, "m");
        }
        if levels.quantisation
            && let Some(polar) = plot.polar
        {
            let along = polar.range_m - (r.range_m + draws.range_m + draws.glint_along_m);
            add(RadarEffect::Quantisation, along, "m");
        }
        out
    }
}

/// The first of the effects whose contribution is a change of the signal to clutter and noise ratio, before the values.
const ATTENUATES: [RadarEffect; 1] = [RadarEffect::RainAttenuation];

/// The others.
const IN_DB: [RadarEffect; 8] = [
    RadarEffect::RainClutter,
    RadarEffect::GroundClutter,
    RadarEffect::SurfaceReflection,
    RadarEffect::Lobing,
    RadarEffect::Roughness,
    RadarEffect::WaterFilm,
    RadarEffect::ReflectedPolarisation,
    RadarEffect::RoundEarth,
];

fn is_on(effect: RadarEffect, levels: &RadarLevels) -> bool {
    use RadarEffect as E;
    let reflected = levels.budget.reflection != Reflection::None;
    !matches!(
        effect,
        E::Lobing | E::Roughness | E::WaterFilm | E::ReflectedPolarisation | E::RoundEarth
    ) || reflected
}

/// What a ghost is: the power of its way against the direct one.
pub(super) fn ghost(power_db: f64) -> Vec<Contribution> {
    vec![Contribution { effect: RadarEffect::Ghosts.name(), value: power_db, unit: "dB" }]
}
