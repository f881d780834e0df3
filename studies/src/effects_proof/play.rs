//! A scene played twice on the same draws, planned and exact.

use super::costs::Costs;
use super::result::SceneResult;
use super::scene::ProofScene;
use models::effects::Tolerance;
use models::environment::Weather;
use models::plot::Callsign;
use models::sensors::asde::Asde;
use models::sensors::radar::levels::RadarLevels;
use models::sensors::{PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use models::time::SimTime;

impl ProofScene {
    /// Plays both runs.
    ///
    /// # Errors
    /// If the parameters are outside their limits.
    pub fn play(&self, seed: u64, scans: u64) -> Result<SceneResult, String> {
        self.play_with(seed, scans, &|radar| radar)
    }

    /// The same with the planned radar changed.
    ///
    /// # Errors
    /// As [`Self::play`].
    pub fn play_with(
        &self,
        seed: u64,
        scans: u64,
        change: &dyn Fn(Asde) -> Asde,
    ) -> Result<SceneResult, String> {
        let mut planned = change(self.radar()?.tolerating(self.tolerance));
        let mut exact = self.radar()?.at_levels(RadarLevels::EXACT);
        let mut result = SceneResult::new(self.truth.len());
        let turn_s = self.turns * 60.0 / self.parameters.rotation_rpm;
        let limit_m = 5.0 * self.tolerance.position_m;
        let mut weather = self.weather.clone();
        for scan in 1..=scans {
            let time = |n: u64| SimTime::from_s(n as f64 * turn_s);
            let interval =
                ScanInterval { run_seed: seed, scan, from: time(scan - 1), to: time(scan) };
            // Cells go with the wind for a minute, then come from the start again.
            let away_s = turn_s * (scan % 60) as f64;
            for (cell, start) in weather.cells.iter_mut().zip(&self.weather.cells) {
                cell.centre_m = start.centre_m + self.weather.wind_mps * away_s;
            }
            let (mut a, mut b) = (PlotSink::default(), PlotSink::default());
            planned.scan(&interval, &self.truth, &weather, &mut a);
            exact.scan(&interval, &self.truth, &weather, &mut b);
            result.scans += 1;
            result.add(&a, &b, limit_m);
        }
        // What is promised of a scan holds for each turn of a longer one.
        result.of_turns(self.turns.ceil() as u64);
        let mut costs = Costs::default();
        costs.add(&planned);
        costs.tell(&mut result);
        Ok(result)
    }

    /// What of the scene is beyond its tolerance: runs again with another seed and twenty times the scans
    /// what looks like it.
    ///
    /// # Errors
    /// As [`Self::play`].
    pub fn judge(
        &self,
        seed: u64,
        scans: u64,
        change: &dyn Fn(Asde) -> Asde,
    ) -> Result<(SceneResult, Vec<String>), String> {
        let first = self.play_with(seed, scans, change)?;
        if !first.is_suspicious(&self.tolerance) {
            return Ok((first, Vec::new()));
        }
        let found = self.beyond(seed + 1_000_003, 20 * scans, change)?;
        Ok((first, found.into_iter().map(|v| format!("{}: {v}", self.name)).collect()))
    }

    /// What is beyond the tolerance in so many scans; in twenty times as many where these cannot tell.
    pub(super) fn beyond(
        &self,
        seed: u64,
        scans: u64,
        change: &dyn Fn(Asde) -> Asde,
    ) -> Result<Vec<String>, String> {
        let played = self.play_with(seed, scans, change)?;
        if played.is_open(&self.tolerance) {
            let longer = self.play_with(seed, 20 * scans, change)?;
            return Ok(longer.violations(&self.tolerance));
        }
        Ok(played.violations(&self.tolerance))
    }
}

/// The movers of a scene that was read, with keys from 1.
struct Movers<'a>(crate::movers::Movers<'a>);

impl Truth for Movers<'_> {
    fn len(&self) -> usize {
        self.0.len()
    }
    fn key(&self, index: usize) -> u64 {
        index as u64 + 1
    }
    fn class(&self, index: usize) -> &TargetClass {
        self.0.class(index)
    }
    fn callsign(&self, index: usize) -> Callsign {
        self.0.callsign(index)
    }
    fn address(&self, index: usize) -> Option<u32> {
        self.0.address(index)
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        self.0.at(index, time)
    }
}

/// Plays the first radar of a scene that was read, planned for a tolerance and exact, with as many
/// seeds; what is beyond the tolerance. Flights that behave are driven once.
///
/// # Errors
/// If it has no radar, or one that cannot be made.
pub fn judge_scene(
    scene: &scenarios::Scene,
    tolerance: Tolerance,
    seeds: std::ops::Range<u64>,
) -> Result<(SceneResult, Vec<String>), String> {
    let sensor = scene.sensors.iter().find(|s| s.asde.is_some()).ok_or("the scene has no radar")?;
    let radar = sensor.asde.as_ref().ok_or("the scene has no radar")?;
    let make = || radar.radar_for(scene, sensor, tolerance).map_err(|e| e.to_string());
    let truth = Movers(crate::movers::Movers::drive(scene, scene.run.duration.s()));
    let mut result = SceneResult::new(truth.len());
    let scans = scene.run.duration.s() as u64;
    let mut costs = Costs::default();
    for seed in seeds {
        let (mut planned, mut exact) = (make()?, make()?.at_levels(RadarLevels::EXACT));
        for scan in 1..=scans {
            let time = |n: u64| SimTime::from_s(n as f64);
            let interval =
                ScanInterval { run_seed: seed, scan, from: time(scan - 1), to: time(scan) };
            let notice = scene.weather.iter().rev().find(|n| n.time <= interval.from);
            let weather = notice.map_or_else(Weather::default, |n| n.weather.clone());
            let (mut a, mut b) = (PlotSink::default(), PlotSink::default());
            planned.scan(&interval, &truth, &weather, &mut a);
            exact.scan(&interval, &truth, &weather, &mut b);
            result.scans += 1;
            result.add(&a, &b, 5.0 * tolerance.position_m);
            costs.add(&planned);
        }
    }
    costs.tell(&mut result);
    let found = result.violations(&tolerance);
    Ok((result, found))
}
