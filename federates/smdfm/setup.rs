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
    let one = |sensor: &SensorScene| -> Result<Box<dyn Sensor>, String> {
        let elsewhere = || Box::new(Elsewhere { id: sensor.id, kind: sensor.kind }) as _;
        Ok(sensor.made(scene, tolerance)?.unwrap_or_else(elsewhere))
    };
    scene.sensors.iter().map(one).collect()
}

/// What the scene tolerates against everything simulated exactly.
#[must_use]
pub fn tolerance(scene: &Scene) -> Tolerance {
    scene.tolerance()
}
