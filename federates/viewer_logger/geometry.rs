//! What decides how well a sensor that is no radar sees: satellites in view and their dilution, stations and theirs, loops. Computed by the
//! models that a run uses, of its scene, for the panes of sensors (`GET /geometry`, `web/geometry.js`).

use models::frames::{Point2, Vector2};
use models::sensors::adsb::{AdsbConfig, position_uncertainty_m};
use models::sensors::declared::Settings;
use models::sensors::dgps::{DgpsConfig, DgpsModel};
use models::sensors::gps::{GpsConfig, GpsModel};
use models::sensors::induction_loop::LoopConfig;
use models::sensors::mlat::{ArrivalGeometry, MlatConfig};
use models::sensors::reporting::constellation::{Sky, SkyConfig, in_view};
use models::time::SimTime;
use scenarios::Scene;
use serde_json::{Value, json};
use std::any::Any;

/// Cells along the longer side of a map of dilution.
const MOST_CELLS: f64 = 72.0;
/// Beyond the outermost place of the airport, m.
const BESIDE_M: f64 = 300.0;
/// Height of a transponder where a map asks for one, m.
const TRANSPONDER_M: f64 = 6.0;
/// Epochs of a sky that are computed at most, for its outages.
const MOST_EPOCHS: f64 = 20_000.0;

/// Of which sensor, at which time of a run with which seed, and for a target where.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// Number of the sensor in the scene.
    pub sensor: u16,
    /// Seed of the run.
    pub seed: u64,
    /// Simulated time.
    pub time: SimTime,
    /// A target, m east and north of the reference point.
    pub target_m: Option<Point2<f64>>,
}

/// The geometry of a sensor, for its pane (JSON; `kind` says which fields there are).
///
/// # Errors
/// There is no such sensor, or nothing decides but its range; as one sentence.
pub fn of(scene: &Scene, asked: &Asked) -> Result<Value, String> {
    let sensor = scene.sensors.iter().find(|s| s.id.0 == asked.sensor);
    let sensor = sensor.ok_or_else(|| format!("there is no sensor {}", asked.sensor))?;
    let settings = sensor.reported.as_deref().ok_or("a radar has its video and its map instead")?;
    let any: &dyn Any = settings;
    if let Some(gps) = any.downcast_ref::<GpsConfig>() {
        return satellites(scene, gps, asked);
    }
    if let Some(dgps) = any.downcast_ref::<DgpsConfig>() {
        return differential(scene, dgps, asked);
    }
    if let Some(mlat) = any.downcast_ref::<MlatConfig>() {
        return Ok(stations(scene, mlat, asked));
    }
    if let Some(adsb) = any.downcast_ref::<AdsbConfig>() {
        return Ok(json!({
            "kind": "adsb", "nacp": adsb.nacp, "radius_95_m": position_uncertainty_m(adsb.nacp),
            "moving_s": adsb.moving_s, "parked_s": adsb.parked_s, "reception": adsb.reception,
            "latency_s": [adsb.latency_min_s, adsb.latency_max_s],
        }));
    }
    if let Some(pair) = any.downcast_ref::<LoopConfig>() {
        return Ok(loops(pair));
    }
    Err(format!("{} has no geometry to show: {}", sensor.name, settings_name(settings)))
}

fn settings_name(settings: &dyn Settings) -> String {
    let text = format!("{settings:?}");
    text.split([' ', '{', '(']).next().unwrap_or_default().to_owned()
}

fn satellites(scene: &Scene, gps: &GpsConfig, asked: &Asked) -> Result<Value, String> {
    match &gps.model {
        GpsModel::Statistical(s) => Ok(json!({
            "kind": "gps", "statistical": true,
            "sigma_m": [s.error.sigma_east_m, s.error.sigma_north_m],
        })),
        GpsModel::Constellation(d) => sky(scene, &d.sky, asked),
        GpsModel::PerSatellite(r) => sky(scene, &r.sky, asked),
    }
}

fn differential(scene: &Scene, dgps: &DgpsConfig, asked: &Asked) -> Result<Value, String> {
    let mut told = match &dgps.model {
        DgpsModel::Budget(b) => json!({
            "kind": "gps", "statistical": true, "correction_age_s": b.correction_age_s(asked.time),
        }),
        DgpsModel::PerSatellite(r) => {
            let mut told = sky(scene, &r.sky, asked)?;
            let made = r.corrections.as_ref().map(|c| c.made_at(asked.time));
            told["correction_age_s"] = made.map(|made| asked.time.since_s(made)).into();
            told
        }
    };
    told["reference_m"] = json!([dgps.reference_m.x, dgps.reference_m.y]);
    Ok(told)
}

/// Satellites above the horizon, which of them are in use, the dilution of a fix, and when in the run there is none.
fn sky(scene: &Scene, config: &SkyConfig, asked: &Asked) -> Result<Value, String> {
    let mut sky = Sky::new(config.clone()).map_err(|e| e.to_string())?;
    let step_s = config.step_s;
    let end = scene.run.duration.s().min(MOST_EPOCHS * step_s).max(asked.time.s());
    sky.prepare(asked.seed, SimTime(0), SimTime::from_s(end), 0.0);
    let now = sky.at(asked.time).map(|at| &sky.epochs()[at]).ok_or("there is no such time")?;
    let frame = geodesy::LocalFrame::at(config.site);
    let t_s = config.epoch_s + now.time.s();
    let above = in_view(&config.constellation, &frame, t_s, 0.0, |_| false);
    let views: Vec<Value> = above
        .iter()
        .map(|v| {
            let used = now.satellites.iter().find(|(u, _)| u.slot == v.slot);
            json!({
                "name": config.constellation.slots[v.slot].name,
                "azimuth_deg": v.look.azimuth_rad.to_degrees(),
                "elevation_deg": v.look.elevation_rad.to_degrees(),
                "used": used.is_some(), "error_m": used.map(|u| u.1),
            })
        })
        .collect();
    let mut outages: Vec<[f64; 2]> = Vec::new();
    for epoch in sky.epochs().iter().filter(|e| e.dop.is_none() && e.time.0 >= 0) {
        let from_s = epoch.time.s();
        match outages.last_mut() {
            Some(last) if from_s - last[1] < 0.5 * step_s => last[1] = from_s + step_s,
            _ => outages.push([from_s, from_s + step_s]),
        }
    }
    let dop = now.dop.as_ref().map(|d| {
        json!({"horizontal": d.horizontal(), "vertical": d.vertical(), "position": d.position(), "time": d.time(), "geometric": d.geometric()})
    });
    Ok(json!({
        "kind": "gps", "statistical": false, "mask_deg": config.mask_deg, "pdop_limit": config.pdop_limit,
        "satellites": views, "dop": dop, "outages_s": outages, "until_s": end,
    }))
}

/// Stations with their reach, the dilution over the airport, and which of them can hear a target.
fn stations(scene: &Scene, mlat: &MlatConfig, asked: &Asked) -> Value {
    let hearing = |place_m: Point2<f64>| -> Vec<usize> {
        let all = mlat.stations.iter().enumerate();
        let hears = |s: &&models::sensors::mlat::Station| {
            s.hears(place_m) && s.sees(&mlat.buildings, place_m, TRANSPONDER_M)
        };
        all.filter(|(_, s)| hears(s)).map(|(i, _)| i).collect()
    };
    let dilution = |place_m: Point2<f64>| -> Option<f64> {
        let heard: Vec<Point2<f64>> =
            hearing(place_m).into_iter().map(|i| mlat.stations[i].position_m).collect();
        let hdop = ArrivalGeometry::of(&heard, place_m)?.horizontal();
        hdop.is_finite().then_some(hdop).filter(|h| *h <= mlat.max_dilution)
    };
    let all: Vec<Value> = mlat
        .stations
        .iter()
        .map(|s| json!({"position_m": [s.position_m.x, s.position_m.y], "range_m": s.range_m}))
        .collect();
    let target = asked
        .target_m
        .map(|place_m| json!({"heard_by": hearing(place_m), "dilution": dilution(place_m)}));
    json!({
        "kind": "mlat", "stations": all, "max_dilution": mlat.max_dilution, "target": target,
        "map": if asked.target_m.is_some() { Value::Null } else { map(scene, dilution) },
    })
}

/// A figure over the airport in cells: rows from north to south.
fn map(scene: &Scene, figure: impl Fn(Point2<f64>) -> Option<f64>) -> Value {
    let layout = &scene.airport.layout;
    let places = layout.runways.iter().flat_map(|r| r.ends_m);
    let places = places.chain(layout.nodes.iter().map(|n| n.position_m));
    let places = places.chain(layout.stands.iter().map(|s| s.position_m));
    let mut bounds: Option<(Point2<f64>, Point2<f64>)> = None;
    for place in places.filter(|p| p.coords.norm() <= scene.airport.radius_m) {
        let (low, high) = bounds.unwrap_or((place, place));
        bounds = Some((low.inf(&place), high.sup(&place)));
    }
    let Some((low, high)) = bounds else { return Value::Null };
    let beside = Vector2::repeat(BESIDE_M);
    let (low, high) = (low - beside, high + beside);
    let extent = high - low;
    let step_m = (extent.max() / MOST_CELLS).ceil();
    let [columns, rows] = [extent.x, extent.y].map(|m| (m / step_m).ceil() as usize);
    let cells: Vec<Option<f64>> = (0..columns * rows)
        .map(|cell| {
            let (column, row) = ((cell % columns) as f64, (cell / columns) as f64);
            let place_m =
                Point2::new(low.x + (column + 0.5) * step_m, high.y - (row + 0.5) * step_m);
            figure(place_m).map(|x| (x * 100.0).round() / 100.0)
        })
        .collect();
    json!({"west_m": low.x, "north_m": high.y, "step_m": step_m, "columns": columns, "cells": cells})
}

/// Loops in the pavement as rectangles, m east and north.
fn loops(config: &LoopConfig) -> Value {
    let along = config.direction_deg.to_radians();
    let (e, n) = (libm::sin(along), libm::cos(along));
    let rectangle = |ahead_m: f64| -> Vec<[f64; 2]> {
        let (half, wide) = (0.5 * config.length_m, config.half_width_m);
        [(-half, -wide), (half, -wide), (half, wide), (-half, wide)]
            .map(|(a, b)| {
                let a = ahead_m + a;
                [config.site_m.x + a * e + b * n, config.site_m.y + a * n - b * e]
            })
            .to_vec()
    };
    let second = config.pair.as_ref().map(|pair| rectangle(pair.spacing_m));
    let all: Vec<_> = std::iter::once(rectangle(0.0)).chain(second).collect();
    json!({"kind": "loop", "loops_m": all, "pd": config.pd, "delay_s": config.delay_s})
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn scene(sensors: &str) -> Scene {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/geometry.toml");
        let text = format!(
            "[run]\ntitle = \"t\"\nseed = 1\nstart = 2019-11-24T09:00:00Z\nduration_s = 3600\n[airport]\nlayout = \"airports/XSYN.apt.dat\"\n{sensors}"
        );
        scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"))
    }

    fn told(scene: &Scene, sensor: u16, time_s: f64, target_m: Option<Point2<f64>>) -> Value {
        let asked = Asked { sensor, seed: 3, time: SimTime::from_s(time_s), target_m };
        of(scene, &asked).expect("a geometry")
    }

    #[test]
    fn the_sky_plot_has_the_satellites_of_the_fix_and_their_dilution() {
        let scene = scene(
            "[[sensor]]\nkind = \"gps\"\nname = \"GPS\"\noverrides = { level = \"constellation\" }\n[[sensor]]\nkind = \"gps\"\nname = \"plain\"\n",
        );
        let now = told(&scene, 1, 600.0, None);
        let all = now["satellites"].as_array().expect("a list");
        let used: Vec<&Value> = all.iter().filter(|s| s["used"] == true).collect();
        assert!((5..=12).contains(&used.len()) && all.len() >= used.len(), "{now}");
        // The dilution of those directions, by the definition of it.
        let units: Vec<[f64; 3]> = used
            .iter()
            .map(|s| {
                let [a, e] = ["azimuth_deg", "elevation_deg"]
                    .map(|k| s[k].as_f64().expect("degrees").to_radians());
                [libm::cos(e) * libm::sin(a), libm::cos(e) * libm::cos(a), libm::sin(e)]
            })
            .collect();
        let dop = models::sensors::reporting::constellation::Dop::of(&units, &[]).expect("a fix");
        for (name, want) in [("horizontal", dop.horizontal()), ("vertical", dop.vertical())] {
            let got = now["dop"][name].as_f64().expect("a figure");
            assert!((got - want).abs() < 1e-9 * want, "{name}: {got} {want}");
        }
        assert!(used.iter().all(|s| s["elevation_deg"].as_f64() >= now["mask_deg"].as_f64()));
        let later = told(&scene, 1, 3000.0, None);
        assert_ne!(later["satellites"], now["satellites"], "they move");
        assert_eq!(told(&scene, 2, 600.0, None)["statistical"], true);
    }

    #[test]
    fn the_map_of_multilateration_is_the_dilution_of_the_stations_that_hear() {
        let scene = scene(
            "[[sensor]]\nkind = \"mlat\"\nname = \"MLAT\"\noverrides = { stations = [{ east_m = -900, north_m = -600, range_m = 3000 }, { east_m = 900, north_m = -600, range_m = 3000 }, { east_m = 0, north_m = 900, range_m = 3000 }, { east_m = 5000, north_m = 5000, range_m = 400 }] }\n",
        );
        let all = told(&scene, 1, 0.0, None);
        let (map, places) = (&all["map"], all["stations"].as_array().expect("stations"));
        assert_eq!(places.len(), 4);
        let cells = map["cells"].as_array().expect("cells");
        let number = |key: &str| map[key].as_f64().expect("a number");
        let columns = number("columns") as usize;
        let mut known = 0;
        for (at, cell) in cells.iter().enumerate().step_by(97) {
            let place_m = Point2::new(
                number("west_m") + ((at % columns) as f64 + 0.5) * number("step_m"),
                number("north_m") - ((at / columns) as f64 + 0.5) * number("step_m"),
            );
            let near: Vec<Point2<f64>> = places
                .iter()
                .map(|s| {
                    Point2::new(
                        s["position_m"][0].as_f64().unwrap_or(0.0),
                        s["position_m"][1].as_f64().unwrap_or(0.0),
                    )
                })
                .zip(places.iter().map(|s| s["range_m"].as_f64().unwrap_or(0.0)))
                .filter(|(p, range_m)| (place_m - p).norm() <= *range_m)
                .map(|(p, _)| p)
                .collect();
            let want = ArrivalGeometry::of(&near, place_m).map(|g| g.horizontal());
            let want = want.filter(|h| *h <= all["max_dilution"].as_f64().unwrap_or(0.0));
            match (cell.as_f64(), want) {
                (None, None) => {}
                (Some(got), Some(want)) => {
                    known += 1;
                    assert!((got - want).abs() < 0.0051, "{place_m}: {got} {want}");
                }
                other => panic!("{place_m}: {other:?}"),
            }
        }
        assert!(known > 10, "{known}");
        let target = told(&scene, 1, 0.0, Some(Point2::new(0.0, 0.0)));
        assert_eq!(target["target"]["heard_by"], json!([0, 1, 2]), "the fourth is out of reach");
        assert!(target["target"]["dilution"].as_f64().is_some_and(|h| h > 0.5 && h < 2.0));
        assert!(target["map"].is_null());
    }

    #[test]
    fn a_loop_lies_along_its_taxiway_and_what_has_no_geometry_says_so() {
        let scene = scene(
            "[[sensor]]\nkind = \"loop\"\nname = \"L\"\nsite = { east_m = 100, north_m = 50 }\noverrides = { direction_deg = 90 }\n[[sensor]]\nkind = \"adsb\"\nname = \"A\"\noverrides = { nacp = 9 }\n[[sensor]]\nkind = \"asde\"\nname = \"R\"\nparameters = \"ku_asde3\"\nsite = { east_m = 0, north_m = 0, height_m = 20 }\n",
        );
        let ring = told(&scene, 1, 0.0, None)["loops_m"][0].clone();
        let east: Vec<f64> = (0..4).filter_map(|i| ring[i][0].as_f64()).collect();
        let north: Vec<f64> = (0..4).filter_map(|i| ring[i][1].as_f64()).collect();
        let span = |v: &[f64]| {
            v.iter().copied().fold(f64::MIN, f64::max) - v.iter().copied().fold(f64::MAX, f64::min)
        };
        let mean = |v: &[f64]| v.iter().sum::<f64>() / 4.0;
        assert!((mean(&east) - 100.0).abs() < 1e-9 && (mean(&north) - 50.0).abs() < 1e-9);
        assert!(span(&east) < span(&north), "eastward: {ring}");
        let adsb = told(&scene, 2, 0.0, None);
        assert_eq!((&adsb["nacp"], &adsb["radius_95_m"]), (&json!(9), &json!(30.0)));
        let asked = |sensor| Asked { sensor, seed: 0, time: SimTime(0), target_m: None };
        assert!(of(&scene, &asked(3)).expect_err("a radar").contains("radar"));
        assert!(of(&scene, &asked(9)).expect_err("none").contains("no sensor 9"));
    }
}
