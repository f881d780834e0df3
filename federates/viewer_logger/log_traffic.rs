//! Tables of traffic that behaves: clearances, movements, measures and remarks.
//!
//! The core is a pure function of scene and seed, so the logger writes what it says by stepping one of its
//! own, at the end of the run, up to the last frame that was executed.

use super::log::{Log, LogError};
use models::traffic::core::{Core, Direction};
use rusqlite::params;
use scenarios::Scene;

/// The core after `frames` frames, or `None` where nothing behaves or the scene cannot be read again.
#[must_use]
pub fn core_after(scene: &Scene, seed: u64, frames: u64) -> Option<Core> {
    scene.traffic.behaving.as_ref()?;
    let whole = scenarios::load(&scene.path).ok().filter(|s| s.hash == scene.hash)?;
    let mut core = whole.traffic.behaving.as_ref()?.core(&whole.run, seed)?;
    for frame in 1..=frames.min(whole.run.frames()) {
        core.step(frame as i64);
    }
    Some(core)
}

impl Log {
    /// Writes what a core did.
    ///
    /// # Errors
    /// If the database cannot be written.
    pub fn traffic(&mut self, scene: &Scene, core: &Core) -> Result<(), LogError> {
        let Some(behaving) = &scene.traffic.behaving else { return Ok(()) };
        let ns = |s: f64| (s * 1e9).round() as i64;
        self.write(|t| {
            for table in ["clearances", "movements", "measures", "remarks"] {
                t.execute(&format!("DELETE FROM {table}"), [])?;
            }
            let mut insert = t.prepare("INSERT INTO clearances VALUES (?,?,?,?,?,?,?)")?;
            for c in core.clearances() {
                let callsign = &core.flights()[c.flight].callsign;
                let (from, until) = (ns(c.from_s), c.until_s.map(ns));
                let runway = (!c.runway.is_empty()).then_some(&c.runway);
                insert.execute(params![from, callsign, c.kind, runway, until, "", "plan"])?;
            }
            let mut insert = t.prepare("INSERT INTO movements VALUES (?,?,?,?,?,?,?,?,?,?,?,?)")?;
            let (mut taxi, mut additional, mut fuel) = (Vec::new(), Vec::new(), 0.0);
            for (index, f) in core.flights().iter().enumerate() {
                let m = core.measures(index);
                let kind = match f.direction {
                    Direction::Arrival => "arrival",
                    Direction::Departure => "departure",
                };
                let runway = &behaving.network.runways[f.runway.0].names[f.runway.1];
                let stand = &behaving.network.stands[core.stand(index)].name;
                let extra_s = m.taxi_s - m.unhindered_s;
                if m.taxi_s > 0.0 {
                    taxi.push(m.taxi_s);
                    additional.push(extra_s);
                }
                fuel += m.fuel_kg;
                insert.execute(params![
                    f.callsign,
                    kind,
                    m.aobt_s.map(ns),
                    m.atot_s.map(ns),
                    m.aldt_s.map(ns),
                    m.aibt_s.map(ns),
                    runway,
                    stand,
                    m.stops,
                    m.taxi_s,
                    extra_s,
                    m.fuel_kg
                ])?;
            }
            let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len().max(1) as f64;
            let mut insert = t.prepare("INSERT INTO measures VALUES (?,?,?,?)")?;
            let served = core.measures_of_served();
            for (name, value, unit) in [
                ("served", served as f64, ""),
                ("flights", core.flights().len() as f64, ""),
                ("unexpected_deadlocks", core.unexpected_deadlocks() as f64, ""),
                ("taxi_mean", mean(&taxi), "s"),
                ("additional_mean", mean(&additional), "s"),
                ("fuel", fuel, "kg"),
                ("co2", 3.16 * fuel, "kg"),
            ] {
                insert.execute(params!["truth", name, value, unit])?;
            }
            let mut insert = t.prepare("INSERT INTO remarks VALUES (?,?)")?;
            for r in core.remarks() {
                insert.execute(params![ns(r.time_s), r.text])?;
            }
            Ok(())
        })
    }
}
