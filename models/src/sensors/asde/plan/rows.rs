//! The plan of a radar for people and programs: a row for each effect, over all boxes.

use super::{BoxEffect, Kind};
use crate::effects::{Level, Loss, PlanRow};
use crate::sensors::asde::{Asde, ScanFacts};
use crate::sensors::radar::costs;
use crate::sensors::radar::effects::RadarEffect;
use crate::sensors::radar::equation::Air;
use crate::sensors::radar::levels::Processing;

/// By how much the root mean square error of a plot, per axis, differs at plot level from that in cells:
/// the larger of a share of the range cell (the grid, for small targets) and of the target's half
/// diagonal (its centroid). An envelope of what
/// `plot_level_errs_like_the_cells_within_what_the_plan_says` measures.
const PLOT_LEVEL_ERROR: (f64, f64) = (0.065, 0.0078);

/// The rows of a radar, every effect once, in their order.
pub(in super::super) fn rows(
    radar: &Asde,
    air: &Air,
    processing: Processing,
    facts: ScanFacts,
) -> Vec<PlanRow> {
    RadarEffect::ALL.iter().map(|&effect| row(radar, air, processing, facts, effect)).collect()
}

fn row(
    radar: &Asde,
    air: &Air,
    processing: Processing,
    facts: ScanFacts,
    effect: RadarEffect,
) -> PlanRow {
    let called_for = called_for(radar, air, processing, facts, effect);
    let new = |bound: f64, unit: &'static str, level: Level, loss: Loss| PlanRow {
        sensor: radar.id,
        effect: effect.name(),
        called_for: called_for.clone(),
        bound,
        unit,
        level,
        loss,
        cost_ns: costs::of_weather(effect, level, !air.weather.cells.is_empty()),
    };
    let there = |there: bool| {
        let (level, odds) = if there { (Level::Exact, 1.0) } else { (Level::Skipped, 0.0) };
        new(odds, "probability", level, Loss::NONE)
    };
    match effect {
        RadarEffect::BuildingShadow => return there(!radar.buildings.is_empty()),
        RadarEffect::AircraftShadow => return there(facts.shadows),
        RadarEffect::Merging => return there(facts.pairs),
        RadarEffect::SecondTrace => return there(facts.beyond),
        RadarEffect::FalseAlarms => {
            let p = &radar.parameters;
            let mean = p.false_alarms_per_s() / p.turns_per_s();
            return new(mean, "plots a scan", Level::Exact, Loss::NONE);
        }
        RadarEffect::Processing => {
            let (of_cell, of_target) = PLOT_LEVEL_ERROR;
            let half_m = radar.planner.half_m();
            let by_size = (of_cell * radar.radar.cell_m).max(of_target * half_m);
            let bound = if half_m > 0.0 { by_size } else { 0.0 };
            return new(bound, "m", processing.level(), Loss::NONE);
        }
        _ => (),
    }
    if processing != Processing::Plot || radar.fixed.is_some() {
        let level = radar.fixed.map_or(Level::Exact, |levels| level_of(levels, effect));
        return new(f64::INFINITY, "", level, Loss::NONE);
    }
    // A ring whose parts are planned is in nobody's use.
    let waits = radar.planner.waiting() > 0;
    let boxes = radar.planner.boxes().iter().filter(|b| waits || !b.parted);
    let of_effect = boxes.filter_map(|b| b.plan.effects.iter().find(|e| e.effect == effect));
    let found: Vec<&BoxEffect> = of_effect.collect();
    let Some(first) = found.first() else {
        let level = if facts.exactly { Level::Exact } else { Level::Skipped };
        return new(0.0, "dB", level, Loss::NONE);
    };
    let left: Vec<&&BoxEffect> = found.iter().filter(|e| e.kind == Kind::LeftOut).collect();
    let bounds: Vec<f64> = if left.is_empty() {
        found.iter().map(|e| e.shown.0).collect()
    } else {
        left.iter().map(|e| e.shown.0).collect()
    };
    let bound = bounds.iter().copied().fold(0.0, |m, b| if b > m || b.is_nan() { b } else { m });
    let worst = found.iter().filter(|e| e.level != Level::Exact).map(|e| e.loss);
    let loss = worst.fold(Loss::NONE, |a, b| if b.db() > a.db() { b } else { a });
    let highest = found.iter().map(|e| e.level).max().unwrap_or(first.level);
    let is_there = found.iter().any(|e| e.kind != Kind::NotThere);
    let level = if facts.exactly && is_there { Level::Exact } else { highest };
    new(bound, if bound.is_finite() { first.shown.1 } else { "" }, level, loss)
}

/// Level of an effect that all levels of a radar give; exact unless it is off.
fn level_of(levels: crate::sensors::radar::levels::RadarLevels, effect: RadarEffect) -> Level {
    let all = [Level::Skipped, Level::Cheap, Level::Middle, Level::Exact];
    all.into_iter().rev().find(|&l| levels.with(effect, l) == levels).unwrap_or(Level::Exact)
}

fn called_for(
    radar: &Asde,
    air: &Air,
    processing: Processing,
    facts: ScanFacts,
    effect: RadarEffect,
) -> String {
    use RadarEffect as E;
    let (p, weather) = (&radar.parameters, &air.weather);
    let longest = radar.planner.longest_m();
    if let Some(value) = effect.value() {
        return (value.called_for)(&radar.radar.setting(weather));
    }
    match effect {
        E::RainAttenuation => match weather.cells.len() {
            0 => format!("rain {} mm/h", weather.rain_mm_per_h),
            n => format!("rain {} mm/h, {n} cells", weather.rain_mm_per_h),
        },
        E::RainClutter => format!("rain up to {} mm/h", air.heaviest().rain_mm_per_h),
        E::GroundClutter => format!("γ {} dB", p.ground_gamma_db),
        E::SurfaceReflection | E::Lobing => format!("{} surface", p.surface.name),
        E::Roughness => format!("{} mm rms", p.roughness_m * 1000.0),
        E::WaterFilm => format!("film of {} mm", weather.film_mm),
        E::ReflectedPolarisation => format!("{:?}", p.polarisation),
        E::RoundEarth => format!("to {:.0} m", p.range_max_m),
        E::Detection => format!("Swerling {:?}, {} pulses", p.swerling, p.pulses_summed()),
        E::Extent | E::Glint if longest > 0.0 => format!("targets up to {longest:.0} m"),
        E::Extent | E::Glint => "no target".to_owned(),
        E::ThermalRange | E::ThermalAzimuth => format!("noise figure {} dB", p.noise_figure_db),
        E::Quantisation => format!("steps {} m, {:.3}°", p.range_step_m, p.azimuth_step_deg),
        E::FalseAlarms => format!("Pfa {:e}", p.pfa),
        E::BuildingShadow => format!("{} buildings", radar.buildings.len()),
        E::AircraftShadow if facts.shadows => "an aircraft before another target".to_owned(),
        E::AircraftShadow => "no aircraft before another target".to_owned(),
        E::Ghosts => format!("{} facades that face the radar", radar.facades.len()),
        E::Merging if facts.pairs => "targets that may share a cell".to_owned(),
        E::Merging => "no two targets near one cell".to_owned(),
        E::SecondTrace if p.frequency_agile => {
            "the carrier hops: echoes of the pulse before are not heard".to_owned()
        }
        E::SecondTrace => format!("unambiguous to {:.0} m", p.unambiguous_m()),
        E::Processing => match radar.processing {
            Some(asked) => format!("the scene asks for \"{}\"", asked.name()),
            None => format!(
                "auto is {} level: cells of {:.1} m draw otherwise, and differ by statistics only",
                processing.name(),
                radar.radar.cell_m
            ),
        },
        // A value has said so itself.
        _ => String::new(),
    }
}
