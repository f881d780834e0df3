//! From a scene to sensors and a tracker.

use models::frames::Vector2;
use models::fusion::TrackingConfig;
use models::fusion::config::{SensorModel, TypeSize};
use models::plot::SensorKind;
use models::sensors::Sensor;
use models::sensors::asde::Asde;
use models::sensors::cooperative::{Equipage, Equipped as Who};
use models::sensors::dgps::{Dgps, DgpsConfig, DgpsModel};
use models::sensors::gps::{Gps, GpsConfig, GpsModel, Statistical};
use scenarios::sensors::{Equipped, SensorScene};
use scenarios::{Scene, tracking::Profile};

/// The sensors of a scene, in its order.
///
/// # Errors
/// One sentence if a sensor cannot be made; the scene's check should have said so before.
pub(super) fn make_sensors(scene: &Scene) -> Result<Vec<Box<dyn Sensor>>, String> {
    scene.sensors.iter().map(|sensor| make_sensor(scene, sensor)).collect()
}

fn make_sensor(_scene: &Scene, sensor: &SensorScene) -> Result<Box<dyn Sensor>, String> {
    let failed = |e: &dyn std::fmt::Display| format!("sensor '{}': {e}", sensor.name);
    let site_m = sensor.site_m.map_or_else(Vector2::zeros, |s| s.xy());
    Ok(match sensor.kind {
        SensorKind::Asde => {
            let radar = sensor.asde.as_ref().ok_or_else(|| failed(&"no parameters"))?;
            let made = Asde::new(sensor.id, site_m, radar.parameters.clone());
            Box::new(made.map_err(|e| failed(&e))?)
        }
        SensorKind::Gps => {
            let mut config = gps_config(sensor);
            config.equipped = equipage(sensor);
            Box::new(Gps::new(config).map_err(|e| failed(&e))?)
        }
        SensorKind::Dgps => {
            let mut config = DgpsConfig::on_airport(sensor.id, site_m);
            config.equipped = equipage(sensor);
            Box::new(Dgps::new(config).map_err(|e| failed(&e))?)
        }
        _ => return Err(failed(&"this kind of sensor is not built in yet")),
    })
}

fn gps_config(sensor: &SensorScene) -> GpsConfig {
    let model = match sensor.parameters.as_deref() {
        Some("sps_1995") => Statistical::sps_1995(),
        Some("sps_2001") => Statistical::sps_2001(),
        _ => Statistical::sps_2020(),
    };
    GpsConfig::of(sensor.id, GpsModel::Statistical(model))
}

fn equipage(sensor: &SensorScene) -> Equipage {
    let who = match &sensor.equipped {
        Equipped::All => Who::All,
        Equipped::Share(share) => Who::Share(*share),
        Equipped::Callsigns(names) => Who::Callsigns(names.iter().copied().collect()),
    };
    Equipage { aircraft: true, vehicles: true, who }
}

/// The tracker's configuration for a scene: its profile, and what is known of its sensors and types.
#[must_use]
pub(super) fn tracking_config(scene: &Scene) -> TrackingConfig {
    let mut config = match scene.tracking.profile {
        Profile::Paper | Profile::Accurate | Profile::Bulk => TrackingConfig::paper(),
    };
    config.sizes = scene
        .traffic
        .types
        .designators()
        .filter_map(|designator| scene.traffic.types.get(designator))
        .map(|row| TypeSize {
            designator: row.class.designator.clone(),
            length_m: row.class.length_m,
            span_m: row.class.span_m,
        })
        .collect();
    config.sensors = scene.sensors.iter().map(sensor_model).collect();
    config
}

fn sensor_model(sensor: &SensorScene) -> SensorModel {
    let model = SensorModel::default_of(sensor.id, sensor.kind);
    match sensor.kind {
        SensorKind::Gps => {
            let config = gps_config(sensor);
            let GpsModel::Statistical(statistical) = config.model else { return model };
            let error = statistical.error;
            let sigma = 0.5 * (error.sigma_north_m + error.sigma_east_m);
            SensorModel {
                slow_sigma_m: sigma * error.correlated_share.sqrt(),
                slow_tau_s: error.tau_s,
                ..model
            }
        }
        SensorKind::Dgps => {
            let DgpsModel::Budget(budget) =
                DgpsConfig::on_airport(sensor.id, Vector2::zeros()).model
            else {
                return model;
            };
            let sigma = budget.budget.sigma_m(2000.0, 0.0, 1.0);
            SensorModel {
                slow_sigma_m: sigma * budget.correlated_share.sqrt(),
                slow_tau_s: budget.tau_s,
                ..model
            }
        }
        _ => model,
    }
}
