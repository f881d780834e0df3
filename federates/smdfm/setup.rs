//! From a scene to its sensors.

use super::inlets::Elsewhere;
use models::effects::Tolerance;
use models::sensors::Sensor;
use scenarios::{Scene, SensorScene};

/// The sensors of a scene, in its order, planned for the tolerance of the scene.
///
/// # Errors
/// One sentence if a sensor cannot be made; the scene's check should have said so before.
pub fn make_sensors(scene: &Scene) -> Result<Vec<Box<dyn Sensor>>, String> {
    make_sensors_for(scene, tolerance(scene))
}

/// The same, planned for another tolerance.
///
/// # Errors
/// As [`make_sensors`].
pub fn make_sensors_for(
    scene: &Scene,
    tolerance: Tolerance,
) -> Result<Vec<Box<dyn Sensor>>, String> {
    scene.sensors.iter().map(|sensor| make_sensor(scene, sensor, tolerance)).collect()
}

fn make_sensor(
    scene: &Scene,
    sensor: &SensorScene,
    tolerance: Tolerance,
) -> Result<Box<dyn Sensor>, String> {
    let failed = |e: &dyn std::fmt::Display| format!("sensor '{}': {e}", sensor.name);
    match (&sensor.asde, &sensor.reported) {
        (Some(radar), _) => {
            let asde = radar.radar_for(scene, sensor, tolerance).map_err(|e| failed(&e))?;
            Ok(Box::new(asde))
        }
        (None, Some(reported)) => {
            reported.sensor(tolerance, scene.run.duration.s()).map_err(|e| failed(&e))
        }
        (None, None) if sensor.foreign.is_some() => {
            Ok(Box::new(Elsewhere { id: sensor.id, kind: sensor.kind }))
        }
        (None, None) => Err(failed(&"the scene gives it no parameters")),
    }
}

/// What the scene tolerates against everything simulated exactly.
#[must_use]
pub fn tolerance(scene: &Scene) -> Tolerance {
    scene.tolerance()
}
