//! `seeds site SCENE -o DIR`: maps of what the sensors of a scene make of every place of the airport.

use crate::runtime::cli::out;
use crate::runtime::cli::{self, BAD_INPUT, FAILED, fail, load_scene};
use anyhow::{Context, bail};
use clap::Args;
use models::environment::Weather;
use models::frames::Vector2;
use models::sensors::TargetClass;
use models::sensors::mlat::MlatConfig;
use scenarios::{Scene, SensorScene};
use serde_json::{Value, json};
use std::any::Any;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use studies::metar;
use studies::siting::{self, Grid, Map, Subject};
use studies::siting_picture;

/// Maps of a site: detection, ratio, deviation, shadows and ghosts of every radar, dilution of multilateration
#[derive(Args, Clone, Debug)]
pub struct SiteArgs {
    /// Scene: a TOML file, or the name of a scene that comes with SEEDS
    #[arg(value_name = "SCENE", default_value = "zurich")]
    scene: String,

    /// Folder for the maps (.bil with .hdr, .blw and .prj, .png, .csv) and site.json
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,

    /// Side of a cell, m, 1 to 100
    #[arg(long, value_name = "M", default_value_t = 5.0, value_parser = step)]
    step: f64,

    /// Weather: "timeline" of the scene, or a text file of METAR reports, one a line
    #[arg(long, value_name = "timeline|FILE", default_value = "timeline")]
    weather: String,

    /// What stands there: a type designator (A320, FIRE) or a shape (narrow, car)
    #[arg(long, value_name = "NAME", default_value = "narrow")]
    class: String,

    /// Height of the target over the ground, m
    #[arg(long, value_name = "M", default_value_t = 0.0, value_parser = height)]
    height: f64,

    /// By the worst aspect of the target instead of the mean of all
    #[arg(long)]
    worst: bool,

    /// A scene of the same airport: maps of the differences, this one less that one, sensors by name
    #[arg(long, value_name = "SCENE", conflicts_with = "candidates")]
    against: Option<String>,

    /// Sites for one radar: lines "name,east_m,north_m"; rates each, best first, and writes no maps
    #[arg(long, value_name = "FILE")]
    candidates: Option<PathBuf>,

    /// Name of the radar that --candidates places [default: the first one]
    #[arg(long, value_name = "NAME", requires = "candidates")]
    sensor: Option<String>,
}

fn bounded(text: &str, low: f64, high: f64) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(m) if (low..=high).contains(&m) => Ok(m),
        _ => Err(format!("'{text}' is not a number of metres from {low} to {high}")),
    }
}

fn step(text: &str) -> Result<f64, String> {
    bounded(text, 1.0, 100.0)
}

fn height(text: &str) -> Result<f64, String> {
    bounded(text, 0.0, 3000.0)
}

/// Makes the maps.
#[must_use]
pub fn run(args: &SiteArgs) -> ExitCode {
    let scene = match load_scene(&args.scene) {
        Ok(scene) => scene,
        Err(code) => return code,
    };
    let against = match args.against.as_deref().map(load_scene).transpose() {
        Ok(other) => other,
        Err(code) => return code,
    };
    let Some(class) = class_of(&scene, &args.class) else {
        let types = scene.traffic.types.designators().collect::<Vec<_>>().join(", ");
        let shapes = scene.traffic.types.shapes().names().collect::<Vec<_>>().join(", ");
        return fail(BAD_INPUT, format!("--class {}: known are {shapes}, {types}", args.class));
    };
    let subject = Subject { class, height_m: args.height, worst: args.worst };
    let made = match &args.candidates {
        Some(file) => rate(&scene, args, file, &subject),
        None => maps(&scene, against.as_ref(), args, &subject),
    };
    match made {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

fn class_of(scene: &Scene, name: &str) -> Option<TargetClass> {
    let types = &scene.traffic.types;
    if let Some(row) = types.get(name) {
        return Some(row.class.clone());
    }
    let shape = types.shapes().get(name)?;
    // A body of the shape's usual proportions; its height is that of its kind.
    let aircraft = shape.fuselage.is_some();
    let height_m = if aircraft { 0.3 * shape.size_m.0 } else { 0.35 * shape.size_m.0 };
    Some(TargetClass {
        designator: name.to_owned(),
        aircraft,
        length_m: shape.size_m.0,
        span_m: shape.size_m.1,
        height_m: height_m.clamp(1.5, 25.0),
        rcs_m2: shape.rcs_m2,
        shape: shape.clone(),
    })
}

/// Weathers with their names.
fn weathers(scene: &Scene, args: &SiteArgs) -> anyhow::Result<Vec<(String, Weather)>> {
    if args.weather == "timeline" {
        let named =
            |n: &scenarios::WeatherNotice| (format!("{:.0} s", n.time.s()), n.weather.clone());
        let all: Vec<_> = scene.weather.iter().map(named).collect();
        return Ok(if all.is_empty() { vec![("dry".into(), Weather::default())] } else { all });
    }
    let path = Path::new(&args.weather);
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("--weather {}: a text file of METAR reports", path.display()))?;
    let classes = metar::classes(&text);
    if classes.is_empty() {
        bail!("--weather {}: no line is a METAR report", path.display());
    }
    for class in &classes {
        out!("{}: {:.1} % of {} reports", class.name, 100.0 * class.share, class.of);
    }
    Ok(classes.into_iter().map(|c| (c.name, c.weather)).collect())
}

fn sites(scene: &Scene) -> Vec<Vector2<f64>> {
    scene.sensors.iter().filter_map(|s| Some(s.site_m?.xy())).collect()
}

fn radars(scene: &Scene) -> impl Iterator<Item = &SensorScene> {
    scene.sensors.iter().filter(|s| s.asde.is_some())
}

/// All maps of a scene.
fn all_maps(
    scene: &Scene,
    weathers: &[(String, Weather)],
    grid: &Grid,
    subject: &Subject,
) -> anyhow::Result<Vec<Map>> {
    let mut found = Vec::new();
    for (name, weather) in weathers {
        let first = found.len();
        for radar in radars(scene) {
            let made = siting::radar_maps(scene, radar, None, (name, weather), grid, subject);
            found.extend(made.map_err(anyhow::Error::msg).with_context(|| radar.name.clone())?);
        }
        let pds: Vec<&Map> = found[first..].iter().filter(|m| m.layer == "pd").collect();
        if pds.len() > 1 {
            let any = siting::any_of(grid, name, &pds);
            found.push(any);
        }
    }
    for sensor in &scene.sensors {
        let settings = sensor.reported.as_deref().map(|settings| settings as &dyn Any);
        if let Some(system) = settings.and_then(|any| any.downcast_ref::<MlatConfig>()) {
            found.extend(siting::mlat_maps(scene, &sensor.name, system, grid, subject.height_m));
        }
    }
    Ok(found)
}

fn maps(
    scene: &Scene,
    against: Option<&Scene>,
    args: &SiteArgs,
    subject: &Subject,
) -> anyhow::Result<()> {
    let grid = Grid::of(scene, args.step).map_err(anyhow::Error::msg)?;
    let weathers = weathers(scene, args)?;
    let mut found = all_maps(scene, &weathers, &grid, subject)?;
    if found.is_empty() {
        bail!("the scene has neither a radar nor multilateration");
    }
    if let Some(other) = against {
        let others = all_maps(other, &weathers, &grid, subject)?;
        let same =
            |a: &Map, b: &Map| (&a.sensor, &a.weather, a.layer) == (&b.sensor, &b.weather, b.layer);
        found = found
            .iter()
            .filter_map(|map| Some(map.less(others.iter().find(|b| same(map, b))?)))
            .collect();
        if found.is_empty() {
            bail!("the two scenes share no sensor by name");
        }
    }
    std::fs::create_dir_all(&args.out).with_context(|| args.out.display().to_string())?;
    let (header, world) = (siting::header(&grid), siting::world_file(&grid));
    let (projection, sites) = (siting::projection(scene), sites(scene));
    let mut summary = Vec::new();
    for map in &found {
        let path = |ending: &str| args.out.join(format!("{}.{ending}", map.file_stem()));
        let about = map.summary(&grid);
        cli::save(&path("bil"), map.bil())?;
        cli::save(&path("hdr"), header.clone())?;
        cli::save(&path("blw"), world.clone())?;
        cli::save(&path("prj"), projection.clone())?;
        let picture = siting_picture::png(map, &grid, &sites, &scene.buildings);
        cli::save(&path("png"), picture.map_err(anyhow::Error::msg)?)?;
        cli::save(&path("csv"), worst_places(scene, map, &found, &grid))?;
        let number = |key: &str| about[key].as_f64().unwrap_or(f64::NAN);
        out!(
            "{}: {:.3} to {:.3}, mean {:.3} {}",
            map.file_stem(),
            number("least"),
            number("most"),
            number("mean"),
            map.unit
        );
        summary.push(about);
    }
    let document = json!({
        "scene": scene.name, "against": against.map(|s| s.name.clone()),
        "class": subject.class.designator, "height_m": subject.height_m, "worst_aspect": subject.worst,
        "step_m": grid.step_m, "columns": grid.size.0, "rows": grid.size.1,
        "first_m": [grid.first_m.x, grid.first_m.y],
        "cells_of_area": grid.area.iter().filter(|a| **a).count(),
        "maps": summary,
    });
    cli::save(&args.out.join("site.json"), format!("{document:#}\n"))
}

/// The twenty worst places of a map, with what is nearest and what makes them so.
fn worst_places(scene: &Scene, map: &Map, all: &[Map], grid: &Grid) -> String {
    let beside = |layer: &str| {
        let same =
            |m: &&Map| m.layer == layer && m.sensor == map.sensor && m.weather == map.weather;
        all.iter().find(same)
    };
    let (shadow, ratio) = (beside("shadow"), beside("scnr"));
    let mut text = String::from("place,east_m,north_m,value,cause\n");
    for cell in map.worst(20) {
        let place = grid.place(cell);
        let at = |m: Option<&Map>| m.map(|m| m.values[cell]);
        let cause = match (at(shadow), at(ratio)) {
            (Some(db), _) if db > 1.0 => format!("building shadow of {db:.1} dB"),
            (_, Some(db)) if db < 20.0 => format!("ratio of {db:.1} dB"),
            _ if map.layer.starts_with("mlat") => "place of the stations".to_owned(),
            _ => "distance and glint".to_owned(),
        };
        let _ = writeln!(
            text,
            "\"{}\",{:.1},{:.1},{},{cause}",
            siting::nearest(scene, place).replace('"', "'"),
            place.x,
            place.y,
            map.values[cell]
        );
    }
    text
}

fn rate(scene: &Scene, args: &SiteArgs, file: &Path, subject: &Subject) -> anyhow::Result<()> {
    let radar = match &args.sensor {
        Some(name) => radars(scene).find(|s| s.name == *name),
        None => radars(scene).next(),
    };
    let Some(radar) = radar else {
        let known: Vec<&str> = radars(scene).map(|s| &*s.name).collect();
        bail!("--candidates places a radar; the scene has: {}", known.join(", "));
    };
    let text = std::fs::read_to_string(file).with_context(|| file.display().to_string())?;
    let mut candidates = Vec::new();
    for (line, row) in (1..).zip(text.lines()) {
        let row = row.trim();
        if row.is_empty() || row.starts_with('#') || row.starts_with("name,") {
            continue;
        }
        let parts: Vec<&str> = row.split(',').map(str::trim).collect();
        let number =
            |i: usize| parts.get(i).and_then(|p| p.parse::<f64>().ok()).filter(|x| x.abs() < 1e6);
        let (Some(east), Some(north)) = (number(1), number(2)) else {
            bail!("{}:{line}: '{row}' is not \"name,east_m,north_m\"", file.display());
        };
        candidates.push((parts[0].to_owned(), Vector2::new(east, north)));
    }
    if candidates.is_empty() || candidates.len() > 1000 {
        bail!("{}: {} candidates; 1 to 1000 are possible", file.display(), candidates.len());
    }
    let grid = Grid::of(scene, args.step).map_err(anyhow::Error::msg)?;
    let weathers = weathers(scene, args)?;
    let rated = siting::rate(scene, radar, &candidates, &weathers, &grid, subject);
    let rated = rated.map_err(anyhow::Error::msg)?;
    std::fs::create_dir_all(&args.out).with_context(|| args.out.display().to_string())?;
    let mut table = String::from("name,east_m,north_m,share,sigma_m\n");
    out!("{}: share of the weighted area with Pd 0.9 and sigma 3.5 m, worst weather", radar.name);
    for r in &rated {
        let (east, north) = (r.site_m.x, r.site_m.y);
        let _ = writeln!(table, "{},{east},{north},{},{}", r.name, r.share, r.sigma_m);
        out!("  {:<24} {:>7.3}  mean sigma {:.2} m", r.name, r.share, r.sigma_m);
    }
    cli::save(&args.out.join("candidates.csv"), table)?;
    let rows: Vec<Value> = rated
        .iter()
        .map(|r| {
            json!({ "name": r.name, "east_m": r.site_m.x, "north_m": r.site_m.y,
                         "share": r.share, "sigma_m": r.sigma_m })
        })
        .collect();
    let document = json!({ "scene": scene.name, "sensor": radar.name, "candidates": rows });
    cli::save(&args.out.join("site.json"), format!("{document:#}\n"))
}
