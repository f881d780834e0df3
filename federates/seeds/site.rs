//! `seeds site SCENE -o DIR`: maps of what the sensors of a scene make of every place of the airport.

use super::accuracy::{end_of_progress, show};
use crate::runtime::cli::out;
use crate::runtime::cli::{self, BAD_INPUT, FAILED, fail, load_scene};
use crate::runtime::clock::monotonic_ns;
use anyhow::{Context, bail};
use clap::Args;
use models::environment::Weather;
use models::frames::{Point2, Point3};
use models::sensors::TargetClass;
use models::sensors::mlat::MlatConfig;
use models::time::SimTime;
use scenarios::{Scene, SensorScene};
use serde_json::json;
use std::any::Any;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use studies::metar;
use studies::siting::{self, Grid, Map, NO_DATA, Subject};
use studies::siting_candidates::{self, Candidate, PRESENT};
use studies::siting_picture;
use studies::siting_rating::{self, Area, Objective};

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

    /// Sites for one radar (CSV: name, then lat_deg,lon_deg or east_m,north_m, height_m): ranks them and the
    /// present one over the movement area; the maps are the best candidate's
    #[arg(long, value_name = "FILE")]
    candidates: Option<PathBuf>,

    /// Name of the radar that --candidates places [default: the only one]
    #[arg(long, value_name = "NAME", requires = "candidates")]
    sensor: Option<String>,

    /// Probability of detection that a place needs, for --candidates
    #[arg(long, value_name = "P", default_value_t = 0.9, value_parser = probability, requires = "candidates")]
    pd_bound: f64,

    /// What --candidates are ranked by, among equals the next: pd, covered, worst-pd, sigma, shadow, ghosts
    #[arg(
        long,
        value_name = "WORDS",
        value_delimiter = ',',
        default_value = "pd,worst-pd,sigma,shadow,ghosts",
        value_parser = objective,
        requires = "candidates"
    )]
    by: Vec<Objective>,
}

fn probability(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(p) if p > 0.0 && p <= 1.0 => Ok(p),
        _ => Err(format!("'{text}' is not a probability above 0, to 1")),
    }
}

fn objective(word: &str) -> Result<Objective, String> {
    let known = || Objective::WORDS.map(|w| w.0).join(", ");
    Objective::named(word).ok_or_else(|| format!("'{word}' is none of {}", known()))
}

/// Progress for people, from two seconds on, at most every second.
struct Progress {
    next_ns: u64,
    shown: bool,
}

impl Progress {
    fn new() -> Self {
        Self { next_ns: monotonic_ns() + 2_000_000_000, shown: false }
    }

    fn tell(&mut self, done: usize, total: usize, what: &str) {
        let now_ns = monotonic_ns();
        if now_ns >= self.next_ns {
            (self.next_ns, self.shown) = (now_ns + 1_000_000_000, true);
            show(&format!("site {done}/{total}: {what}"));
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if self.shown {
            end_of_progress();
        }
    }
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
        Some(file) => match candidates(&scene, args, file) {
            Ok((radar, candidates)) => rate(&scene, args, radar, &candidates, &subject),
            Err(e) => return fail(BAD_INPUT, e),
        },
        None => match against.as_ref().filter(|other| !is_of_airport(&scene, other)) {
            Some(other) => {
                let said = format!("--against {}: a scene of another airport", other.name);
                return fail(BAD_INPUT, said);
            }
            None => maps(&scene, against.as_ref(), args, &subject),
        },
    };
    match made {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

/// Whether two scenes lie about the same place, to the metre: else their maps have nothing in common.
fn is_of_airport(scene: &Scene, other: &Scene) -> bool {
    let at = other.airport.reference;
    let away_m = scene.airport.local_m(at.lat_rad.to_degrees(), at.lon_rad.to_degrees());
    away_m.coords.norm() < 1.0
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

/// The name of the weather from a time on: no two notices have the same one.
fn at(time: SimTime) -> String {
    format!("{} s", time.0 as f64 / 1e9)
}

/// Weathers with their names.
fn weathers(scene: &Scene, args: &SiteArgs) -> anyhow::Result<Vec<(String, Weather)>> {
    if args.weather == "timeline" {
        let named = |n: &scenarios::WeatherNotice| (at(n.time), n.weather.clone());
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
    let passed = metar::passed_over(&text);
    if passed > 0 {
        out!("{passed} lines are no reports and were passed over");
    }
    Ok(classes.into_iter().map(|c| (c.name, c.weather)).collect())
}

fn sites(scene: &Scene) -> Vec<Point2<f64>> {
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
    let mut progress = Progress::new();
    let total = weathers.len() * radars(scene).count();
    for (nth, (name, weather)) in weathers.iter().enumerate() {
        let first = found.len();
        for (of, radar) in radars(scene).enumerate() {
            let done = nth * radars(scene).count() + of;
            progress.tell(done, total, &format!("{}, {name}", radar.name));
            let made = siting::radar_maps(scene, radar, (name, weather), grid, subject);
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
            found.extend(siting::mlat_maps(scene, sensor, system, grid, subject));
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
    let own = all_maps(scene, &weathers, &grid, subject)?;
    if own.is_empty() {
        bail!("the scene has neither a radar nor multilateration");
    }
    let mut found = own.clone();
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
        cli::save(&path("csv"), worst_places(scene, map, &own, &grid))?;
        let number = |key: &str| about[key].as_f64().unwrap_or(f64::NAN);
        let share = match number("share_of_area") {
            1.0 => String::new(),
            share => format!(" on {:.1} % of the area", 100.0 * share),
        };
        let line = format!(
            "{}: {:.3} to {:.3}, mean {:.3} {}",
            map.file_stem(),
            number("least"),
            number("most"),
            number("mean"),
            map.unit
        );
        out!("{}{share}", line.trim_end());
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

/// The twenty worst places of a map, with what is nearest and what makes them so. `all` are the maps of the scene
/// itself, also where `map` is a difference.
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
            (_, Some(NO_DATA)) => "not displayed".to_owned(),
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

/// The radar that is placed, by its place among the sensors, and the sites: the present one and those of the file.
fn candidates(
    scene: &Scene,
    args: &SiteArgs,
    file: &Path,
) -> Result<(usize, Vec<Candidate>), String> {
    let known = radars(scene).map(|s| &*s.name).collect::<Vec<_>>().join(", ");
    let wanted =
        |s: &SensorScene| s.asde.is_some() && args.sensor.as_ref().is_none_or(|n| s.name == *n);
    let found: Vec<usize> =
        (0..scene.sensors.len()).filter(|i| wanted(&scene.sensors[*i])).collect();
    let &[index] = &found[..] else {
        return Err(match (&args.sensor, &*known) {
            (_, "") => "--candidates places a radar, and the scene has none".to_owned(),
            (Some(name), _) => format!("--sensor {name}: the scene's radars are {known}"),
            (None, _) => format!("--candidates places one radar; name it with --sensor: {known}"),
        });
    };
    let sensor = &scene.sensors[index];
    let height_m = sensor.asde.as_ref().map_or(0.0, |radar| radar.parameters.antenna_height_m);
    let at = sensor.site_m.map_or_else(Point2::origin, |site| site.xy());
    let mut all = vec![Candidate {
        name: PRESENT.into(),
        site_m: Point3::new(at.x, at.y, height_m),
        present: true,
    }];
    let text = std::fs::read_to_string(file)
        .map_err(|e| format!("{}: {e}; --candidates takes a CSV file", file.display()))?;
    let name = file.display().to_string();
    all.extend(siting_candidates::read(&name, &text, scene, height_m)?);
    Ok((index, all))
}

fn rate(
    scene: &Scene,
    args: &SiteArgs,
    index: usize,
    candidates: &[Candidate],
    subject: &Subject,
) -> anyhow::Result<()> {
    let radar = &scene.sensors[index];
    let grid = Grid::of(scene, args.step).map_err(anyhow::Error::msg)?;
    let area = Area::of(scene, &grid).map_err(anyhow::Error::msg)?;
    let weathers = weathers(scene, args)?;
    let mut rated = Vec::new();
    let mut progress = Progress::new();
    for (done, candidate) in candidates.iter().enumerate() {
        progress.tell(done, candidates.len(), &candidate.name);
        let one =
            siting_rating::rate(scene, radar, candidate, &weathers, &area, subject, args.pd_bound);
        rated.push(one.map_err(anyhow::Error::msg).with_context(|| candidate.name.clone())?);
    }
    drop(progress);
    siting_rating::rank(&mut rated, &args.by);
    let words = |o: &Objective| Objective::WORDS.iter().find(|w| w.1 == *o).map_or("", |w| w.0);
    let by: Vec<&str> = args.by.iter().map(words).collect();
    out!(
        "{}: {} sites, each figure in the worst of {} weathers over {} cells of the movement area; by {}",
        radar.name,
        rated.len(),
        weathers.len(),
        area.cells(),
        by.join(", ")
    );
    out!("{}", siting_rating::text(&rated, args.pd_bound).trim_end());
    std::fs::create_dir_all(&args.out).with_context(|| args.out.display().to_string())?;
    cli::save(&args.out.join("candidates.csv"), siting_rating::csv(&rated))?;
    let document = json!({
        "scene": scene.name, "sensor": radar.name, "class": subject.class.designator,
        "height_m": subject.height_m, "worst_aspect": subject.worst, "step_m": args.step,
        "cells": area.cells(), "pd_bound": args.pd_bound, "by": by,
        "candidates": siting_rating::json(&rated),
    });
    cli::save(&args.out.join("candidates.json"), format!("{document:#}\n"))?;
    let picture = siting_picture::candidates_png(scene, &grid, &rated);
    cli::save(&args.out.join("candidates.png"), picture.map_err(anyhow::Error::msg)?)?;
    let best = rated.iter().find(|r| !r.candidate.present).context("a candidate")?;
    out!("maps with {} at {}:", radar.name, best.candidate.name);
    let mut moved = scene.clone();
    moved.sensors[index] = siting_rating::placed(radar, &best.candidate);
    maps(&moved, None, args, subject)
}
