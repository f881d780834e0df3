//! A scene for an airport that nobody has written one for: it runs at once, and every line says why.

use crate::airport::{NO_NETWORK, check};
use crate::error::ScenarioError;
pub use crate::files::layout_of;
use crate::{Scene, load_text};
use models::frames::Azimuth;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// What a new scene is made of.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The layout, as the scene will name it.
    pub layout: String,
    /// Where the scene will stand: paths count from its folder.
    pub path: PathBuf,
    /// Length of the run, min.
    pub minutes: f64,
    /// Movements an hour, arrivals and departures together.
    pub per_h: f64,
}

/// The text of a scene of an airport, and the scene that it reads as.
///
/// Traffic is what the airport can bear: flights that react to each other where its network has entries and exits,
/// else aircraft on stands, else nobody. What lies beside the layout (`X.groundnet.xml`, `X.overlay.toml` beside `X.apt.dat`)
/// is taken with it: layouts of X-Plane often bear no way from stand to runway.
///
/// # Errors
/// If the layout cannot be read, or no scene can be made of it.
pub fn scene(wanted: &Wanted) -> Result<(String, Scene), ScenarioError> {
    let file = crate::data_file(&wanted.path, &wanted.layout);
    let (layout, report) = check(&file)?;
    let reach_m = layout
        .nodes
        .iter()
        .map(|node| node.position_m)
        .chain(layout.runways.iter().flat_map(|runway| runway.ends_m))
        .chain(layout.stands.iter().map(|stand| stand.position_m))
        .map(|place| place.coords.norm())
        .fold(0.0, f64::max);
    let radius_m = ((reach_m * 1.2 + 500.0) / 500.0).ceil() * 500.0;
    let radius_m = radius_m.clamp(2000.0, 50_000.0);
    let half = 0.5 * wanted.per_h;
    let generated = |arrivals: f64, departures: f64| {
        format!(
            "[[traffic]]                     # flights that react to each other\nkind = \"generated\"\narrivals_per_h = {arrivals}\ndepartures_per_h = {departures}\n"
        )
    };
    let parked: String = layout
        .stands
        .iter()
        .take(3)
        .enumerate()
        .map(|(i, stand)| {
            format!(
                "[[traffic]]                     # the network bears no way: somebody to look at\nkind = \"parked\"\ncallsign = \"PARKED{}\"\ntype = \"A320\"\nstand = {:?}\nflight = {{ movement = \"departure\", stand = {:?} }}\n\n",
                i + 1,
                stand.name,
                stand.name
            )
        })
        .collect();
    let beside = network_beside(wanted);
    let mut failed = None;
    for traffic in
        [generated(half, half), generated(half, 0.0), generated(0.0, half), parked, String::new()]
    {
        for network in beside.iter().map(Some).chain([None]) {
            let size = Size { radius_m, reach_m };
            let text =
                text(wanted, size, network, &less(&traffic, failed.as_ref()), &report.findings);
            match load_text(&wanted.path, &text) {
                Ok(scene) => {
                    let text = text + &to_drive(&scene);
                    return load_text(&wanted.path, &text).map(|scene| (text, scene));
                }
                Err(error) => failed = Some(failed.unwrap_or(error)),
            }
        }
    }
    Err(failed.unwrap_or_else(|| unreachable_error(&wanted.path)))
}

/// How the line begins that says why flights are left out.
pub const LEFT_OUT: &str = "# No flights that land, taxi and take off";

/// Traffic, and in front of it why it is not more.
fn less(traffic: &str, failed: Option<&ScenarioError>) -> String {
    let Some(failed) = failed else { return traffic.to_owned() };
    let nobody = if traffic.is_empty() { ", and nobody stands here" } else { "" };
    format!("{LEFT_OUT}{nobody}: {}\n{traffic}", failed.problem)
}

/// A car to drive by oneself, to be uncommented, where flights behave and it has a place to stand.
fn to_drive(scene: &Scene) -> String {
    let stand = scene.airport.layout.stands.iter().rev().find(|s| s.node.is_some());
    match (stand, &scene.traffic.behaving) {
        (Some(stand), Some(_)) => format!(
            "\n# A car to drive by yourself: take the `#` away, then tab Drive of the page.\n# [[traffic]]\n# kind = \"driven\"\n# callsign = \"FOLLOW1\"\n\
             # type = \"FOLLOWME\"\n# stand = {:?}               # or a node: \"#12\"\n# flight = {{ movement = \"vehicle\" }}\n",
            stand.name
        ),
        _ => String::new(),
    }
}

/// The ground network of the same airport, where one lies beside an `apt.dat`.
fn network_beside(wanted: &Wanted) -> Option<String> {
    let name = format!("{}.groundnet.xml", wanted.layout.strip_suffix(".apt.dat")?);
    crate::files::is_file(&crate::data_file(&wanted.path, &name)).then_some(name)
}

/// The overlay of an airport (`X.overlay.toml` beside `X.apt.dat`, `X.nodes.csv`, `X.osm.json`), where there is one.
fn overlay_beside(wanted: &Wanted) -> Option<String> {
    let known = [".apt.dat", ".groundnet.xml", ".nodes.csv", ".osm.json", ".geojson", ".json"];
    let stem = known.iter().find_map(|end| wanted.layout.strip_suffix(end))?;
    let name = format!("{stem}.overlay.toml");
    crate::files::is_file(&crate::data_file(&wanted.path, &name)).then_some(name)
}

/// How far an airport reaches from its reference point, m: its radius in the scene, and its outermost place.
#[derive(Clone, Copy)]
struct Size {
    radius_m: f64,
    reach_m: f64,
}

fn unreachable_error(path: &Path) -> ScenarioError {
    let reason = "no scene can be made of it".into();
    ScenarioError::new(path, 0, "scene", crate::Problem::Unreadable { reason })
}

fn text(
    wanted: &Wanted,
    Size { radius_m, reach_m }: Size,
    network: Option<&String>,
    traffic: &str,
    findings: &[impl std::fmt::Display],
) -> String {
    let stem = Path::new(&wanted.layout).file_stem().map(|n| n.to_string_lossy().into_owned());
    let name = stem.unwrap_or_default();
    let name = name.split('.').next().unwrap_or("airport").to_owned();
    let mut out = String::from("#:schema ./scene.schema.json\n");
    let _ = writeln!(
        out,
        "# {name}, made by `seeds scene new`. Keys: docs/scene.md or `seeds scene doc`.\n"
    );
    let title =
        if traffic.contains("\"generated\"") { "generated traffic" } else { "nobody moves" };
    // Whatever is in the name of a file is the same in TOML.
    let quoted = |text: &str| toml_edit::Value::from(text).to_string();
    let range_m = (reach_m * 1.3 + 500.0).clamp(1000.0, 5500.0).round();
    let _ = write!(
        out,
        "[run]\ntitle = {}\nseed = 1                        # another number: other draws\n\
         start = 2026-01-01T06:00:00Z\nduration_s = {}\n\
         # Truth of the log and of others within 0.1 m: `seeds traffic check` judges speeds and accelerations by it.\n\
         dead_reckoning = {{ algorithm = \"rvw\", position_m = 0.1, orientation_deg = 0.5 }}\n\n\
         [airport]\nlayout = {}\n",
        quoted(&format!("{name}: {title}")),
        60.0 * wanted.minutes,
        quoted(&wanted.layout),
    );
    if let Some(network) = network {
        let _ = writeln!(out, "ground_network = {}   # ways of taxiing and gates", quoted(network));
    }
    if let Some(overlay) = overlay_beside(wanted) {
        let _ = writeln!(out, "overlay = {}   # what these files lack", quoted(&overlay));
    }
    let _ = write!(
        out,
        "radius_m = {radius_m}              # sensors are refused farther out\n\n\
         [weather]\ntimeline = [\n    {{ at_s = 0 }},                                          # clear and dry\n    \
         {{ at_s = {}, rain_mm_per_h = 5, visibility_m = 3000 }},  # then rain\n]\n\n",
        (30.0 * wanted.minutes).round(),
    );
    out.push_str(traffic.trim_end());
    let _ = write!(
        out,
        "\n\n[[sensor]]                      # radar beside the reference point, on a mast\nkind = \"asde\"\nname = \"radar\"\n\
         parameters = \"ku_asde3\"\nsite = {{ east_m = 150, north_m = 150, height_m = 40 }}\noverrides = {{ range_max_m = {range_m} }}\n\n\
         [[sensor]]                      # stations around the airport: who has a transponder is named\nkind = \"mlat\"\nname = \"ring\"\n\
         overrides = {{ stations = [\n"
    );
    let ring_m = (0.9 * radius_m).min(reach_m.max(1000.0) + 300.0);
    for k in 0..6 {
        let place_m = ring_m * Azimuth::from_rad(std::f64::consts::TAU * f64::from(k) / 6.0).unit();
        let range_m = (ring_m + reach_m + 1000.0).round();
        let _ = writeln!(
            out,
            "    {{ east_m = {}, north_m = {}, height_m = 15, range_m = {range_m} }},",
            place_m.x.round() as i64,
            place_m.y.round() as i64
        );
    }
    out.push_str(
        "] }\n\n[[sensor]]                      # what aircraft say of themselves\nkind = \"adsb\"\nname = \"receiver\"\nequipped = 0.9\n\n\
         [tracking]\nprofile = \"accurate\"\n",
    );
    // What the layout lacks and the file beside it has is no finding of the scene.
    let found: Vec<String> = findings.iter().map(ToString::to_string).collect();
    let mut found = found.iter().filter(|f| network.is_none() || *f != NO_NETWORK).peekable();
    if found.peek().is_some() {
        out.push_str("\n# What was found in the layout:\n");
        for finding in found.take(20) {
            let _ = writeln!(out, "# - {finding}");
        }
    }
    out
}
