//! Another scene, tracker, weather or seed from a scan on, with all that did not change kept: what a fork is made of.

use super::{Smdfm, setup};
use crate::runtime::messages::WeatherNotice;
use models::environment::Weather;
use models::fusion::Tracker;
use scenarios::Scene;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What changes beside the values of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Amend {
    /// Names of sensors that are off.
    pub off: Vec<String>,
    /// Factor on every rain rate.
    pub rain_factor: f64,
    /// Visibility in place of the weather's own, m.
    pub visibility_m: Option<f64>,
    /// Seed of the sensors' draws.
    pub seed: Option<u64>,
}

impl Default for Amend {
    fn default() -> Self {
        Self { off: Vec::new(), rain_factor: 1.0, visibility_m: None, seed: None }
    }
}

impl Amend {
    /// The weather as changed.
    #[must_use]
    pub fn weather(&self, mut weather: Weather) -> Weather {
        if self.rain_factor.to_bits() != 1.0_f64.to_bits() {
            weather.rain_mm_per_h *= self.rain_factor;
            for cell in &mut weather.cells {
                cell.rain_mm_per_h *= self.rain_factor;
            }
        }
        if let Some(visibility_m) = self.visibility_m {
            weather.visibility_m = visibility_m;
        }
        weather
    }

    /// The same of the weather as it is told.
    #[must_use]
    pub fn notice(&self, mut notice: WeatherNotice) -> WeatherNotice {
        if self.rain_factor.to_bits() != 1.0_f64.to_bits() {
            notice.rain_mm_per_h *= self.rain_factor;
            for [.., rain_mm_per_h] in &mut notice.cells {
                *rain_mm_per_h *= self.rain_factor;
            }
        }
        notice.visibility_m = self.visibility_m.unwrap_or(notice.visibility_m);
        notice
    }
}

/// Which sensors a changed scene has anew.
#[derive(Clone, Debug, PartialEq)]
pub enum Anew {
    /// These, by name; the others keep their state.
    Named(Vec<String>),
    /// All of them: what they share changed.
    All,
}

impl Smdfm {
    /// Has the tracker of another scene run along on the same plots from now on, so that it knows the targets when it
    /// takes over.
    pub fn warm_up(&mut self, scene: &Scene) {
        self.warm = Some(Tracker::new(scene.tracking_config()));
    }

    /// Goes on with another scene from the next scan on. The tracker is the one that was warmed up, if there is one.
    ///
    /// # Errors
    /// If a sensor of the scene cannot be made.
    pub fn change(&mut self, scene: &Arc<Scene>, anew: &Anew, amend: Amend) -> Result<(), String> {
        // Those that an earlier change switched off are not among them.
        let there = |name: &&String| !self.amend.off.contains(*name);
        let names = self.scene.sensors.iter().map(|s| &s.name).filter(there);
        let old = std::mem::take(&mut self.sensors);
        let mut old: BTreeMap<&String, _> = names.zip(old).collect();
        let mut sensors = Vec::new();
        for (of, made) in scene.sensors.iter().zip(setup::make_sensors(scene)?) {
            let name = &of.name;
            if amend.off.contains(name) {
                continue;
            }
            let is_new = match anew {
                Anew::All => true,
                Anew::Named(names) => names.contains(name),
            };
            let kept = old.remove(name).filter(|_| !is_new);
            sensors.push(kept.unwrap_or(made));
        }
        self.sensors = sensors;
        if let Some(tracker) = self.warm.take() {
            self.tracker = tracker;
        }
        self.seed = amend.seed.unwrap_or(self.seed);
        self.amend = amend;
        Ok(())
    }
}
