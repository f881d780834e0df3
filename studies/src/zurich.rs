//! The movements at Zurich, as they come with the scenarios: truth, and the scene's sensors.

use models::frames::{Point2, Point3};
use models::plot::Callsign;
use models::sensors::asde::Asde;
use models::sensors::{Sensor, TargetClass, TargetState, Truth};
use models::time::SimTime;
use scenarios::{ScenarioError, Scene};
use std::sync::Arc;

/// The scene.
///
/// # Errors
/// If it is not there or refused.
pub fn scene() -> Result<Scene, ScenarioError> {
    scenarios::load(&scenarios::locate("zurich"))
}

/// The movers of a scene as sensors see them, exact at every time.
pub struct Traffic<'a>(pub &'a Scene);

impl Truth for Traffic<'_> {
    fn len(&self) -> usize {
        self.0.traffic.entities.len()
    }
    fn key(&self, index: usize) -> u64 {
        index as u64
    }
    fn class(&self, index: usize) -> &TargetClass {
        &self.0.traffic.entities[index].class
    }
    fn callsign(&self, index: usize) -> Callsign {
        self.0.traffic.entities[index].callsign
    }
    fn address(&self, index: usize) -> Option<u32> {
        self.0.traffic.entities[index].address
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        let truth = self.0.traffic.entities[index].trajectory.as_ref()?.at(time)?;
        let p = truth.position_m;
        Some(TargetState {
            position_m: Point3::new(p.x, p.y, p.z),
            velocity_mps: truth.velocity_mps,
            heading_rad: truth.heading_rad,
        })
    }
}

/// The sensors of a scene, planned for its tolerance.
///
/// # Errors
/// One sentence if a sensor cannot be made.
pub fn sensors(scene: &Scene) -> Result<Vec<Box<dyn Sensor>>, String> {
    let tolerance = scene.tolerance();
    let make = |sensor: &scenarios::SensorScene| -> Result<Box<dyn Sensor>, String> {
        let failed = |e: &dyn std::fmt::Display| format!("sensor '{}': {e}", sensor.name);
        match (&sensor.asde, &sensor.reported) {
            (Some(radar), _) => {
                let site_m = sensor.site_m.map_or_else(Point2::origin, |s| s.xy());
                let asde = Asde::new(sensor.id, site_m, radar.parameters.clone());
                let asde = asde.map_err(|e| failed(&e))?;
                Ok(Box::new(asde.among(Arc::from(scene.buildings.clone())).tolerating(tolerance)))
            }
            (None, Some(reported)) => {
                reported.sensor(tolerance, scene.run.duration.s()).map_err(|e| failed(&e))
            }
            (None, None) => Err(failed(&"the scene gives it no parameters")),
        }
    };
    scene.sensors.iter().map(make).collect()
}

/// Stretches of the recorded movements on the ground: positions second by second, at most `samples`
/// of each, with where they begin.
#[must_use]
pub fn stretches(scene: &Scene, samples: usize) -> Vec<(Callsign, Vec<Point2<f64>>)> {
    let mut found = Vec::new();
    for entity in &scene.traffic.entities {
        let Some(trajectory) = &entity.trajectory else { continue };
        let (from, to) = (trajectory.start().s().ceil(), trajectory.end().s());
        let mut path: Vec<Point2<f64>> = Vec::new();
        let mut moved = false;
        let mut second = from;
        while second <= to {
            let state = trajectory.at(SimTime::from_s(second));
            second += 1.0;
            let Some(state) = state.filter(|s| {
                s.position_m.z < 30.0 && libm::hypot(s.position_m.x, s.position_m.y) < 5000.0
            }) else {
                path.clear();
                moved = false;
                continue;
            };
            path.push(state.position_m.xy());
            moved |= !state.is_still();
            if path.len() == samples {
                let whole = std::mem::take(&mut path);
                if std::mem::take(&mut moved) {
                    found.push((entity.callsign, whole));
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_movements_are_whole_and_on_the_ground() {
        let scene = scene().expect("ships with the scenarios");
        let found = stretches(&scene, 60);
        println!("{} stretches", found.len());
        assert!(found.len() >= 20);
        for (name, path) in &found {
            assert_eq!(path.len(), 60, "{name}");
            assert!(path.windows(2).all(|w| (w[1] - w[0]).norm() < 110.0), "{name}");
        }
        assert_eq!(sensors(&scene).expect("sound").len(), scene.sensors.len());
    }
}
