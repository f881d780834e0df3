//! A scene that a person writes on a page: routes by click, sensors by drag, the text beside it, checked at every step.
//!
//! The draft is the page's; here it is changed, checked and saved, to the one file that was named, and only if it is sound and
//! nobody else changed the file meanwhile.

use super::picture::{AirportMap, RunInfo};
use models::airport::{Airport, Hold};
use models::frames::Point2;
use models::time::SimTime;
use models::traffic::network::Network;
use scenarios::Scene;
use scenarios::edit::{self, NewRoute};
use scenarios::warnings;
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// What a page does to its draft: a route more, a sensor at another place, or neither; then the draft is checked, and saved if
/// that is asked for.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Act {
    /// The draft.
    pub text: String,
    /// A route to be added.
    #[serde(default)]
    pub route: Option<Route>,
    /// A sensor to be moved: its name and its new place, m east and north.
    #[serde(default)]
    pub sensor: Option<(String, [f64; 2])>,
    /// Whether to save.
    #[serde(default)]
    pub save: bool,
}

/// A route as a page says it.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Route {
    /// Stands and nodes in order.
    pub via: Vec<String>,
    /// Call sign; empty: a free one.
    #[serde(default)]
    pub callsign: String,
    /// Type designator; empty: `A320`.
    #[serde(default)]
    pub designator: String,
    /// When it sets off, s.
    #[serde(default)]
    pub start_s: f64,
}

/// Has a sound draft shown elsewhere: what the radars of it see.
pub type Show<'a> = dyn Fn(&RunInfo, &AirportMap, Arc<Scene>) + 'a;

/// The scene of one file.
#[derive(Debug)]
pub struct Author {
    file: PathBuf,
    /// The text as it was last read or written.
    known: Mutex<String>,
}

/// Points of a way that is drawn, and seconds between them.
const MOST_POINTS: usize = 400;
const LEAST_STEP_S: f64 = 5.0;

impl Author {
    /// For a scene file.
    ///
    /// # Errors
    /// One sentence if it cannot be read.
    pub fn of(file: &Path) -> Result<Self, String> {
        let text = scenarios::text_of(file).map_err(|e| e.to_string())?;
        Ok(Self { file: file.to_path_buf(), known: Mutex::new(text) })
    }

    /// The scene on disk, with airport and places.
    pub fn begin(&self, show: &Show<'_>) -> Value {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        match scenarios::text_of(&self.file) {
            Ok(text) => *known = text,
            Err(error) => return json!({"error": error.to_string()}),
        }
        let mut answer = self.checked(show, known.clone(), true);
        answer["file"] = self.file.display().to_string().into();
        answer
    }

    /// Does something to a draft.
    pub fn act(&self, show: &Show<'_>, act: Act) -> Value {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let mut text = act.text;
        if let Some((name, place_m)) = &act.sensor {
            match edit::move_sensor(&text, name, *place_m) {
                Ok(moved) => text = moved,
                Err(error) => return json!({"text": text, "error": error}),
            }
        }
        if let Some(route) = act.route {
            match self.with_route(&text, route) {
                Ok(more) => text = more,
                Err(error) => return json!({"text": text, "error": error}),
            }
        }
        let mut answer = self.checked(show, text, false);
        if act.save && answer["error"].is_null() {
            let text = answer["text"].as_str().unwrap_or_default().to_owned();
            match self.save(&known, &text) {
                Ok(()) => {
                    *known = text;
                    answer["saved"] = true.into();
                }
                Err(error) => answer["error"] = error.into(),
            }
        }
        answer
    }

    /// The text with a route, whose flight follows from where it begins and ends.
    fn with_route(&self, text: &str, route: Route) -> Result<String, String> {
        if route.via.len() < 2 {
            return Err("a route needs two places at least".to_owned());
        }
        let scene = scenarios::change::load_changed(&self.file, text, &[]);
        let scene = scene.map_err(|e| e.to_string())?;
        let layout = &scene.airport.layout;
        let (first, last) = (&route.via[0], &route.via[route.via.len() - 1]);
        let runway = route.via.iter().find_map(|name| {
            let place_m = layout.nodes[layout.node(name)?].position_m;
            on_runway(layout, place_m).then(|| nearest_end(layout, place_m))
        });
        let stand = |name: &String| layout.stand(name).map(|s| s.name.clone());
        let (movement, stand) = match (stand(first), stand(last)) {
            (_, Some(stand)) if runway.is_some() => ("arrival", stand),
            (Some(stand), _) => ("departure", stand),
            (None, Some(stand)) => ("arrival", stand),
            (None, None) => ("vehicle", String::new()),
        };
        let made = NewRoute {
            callsign: route.callsign,
            designator: route.designator,
            via: route.via,
            start_s: if route.start_s.is_finite() { route.start_s } else { 0.0 },
            movement: movement.to_owned(),
            runway: runway.flatten().unwrap_or_default(),
            stand,
        };
        Ok(edit::add_route(text, &made))
    }

    /// What the scene's reader and its warnings say; whatever is shown of the scene elsewhere follows a sound draft.
    fn checked(&self, show: &Show<'_>, text: String, whole: bool) -> Value {
        let (scene, found) = match warnings::check(&self.file, &text) {
            Ok(read) => read,
            Err(error) => return json!({"text": text, "error": error.to_string()}),
        };
        let scene = Arc::new(scene);
        let (info, map) = (RunInfo::of(&scene, scene.run.seed), AirportMap::of(&scene));
        let warnings: Vec<Value> = found
            .iter()
            .map(|w| json!({"number": w.word(), "line": w.line, "key": w.key, "text": w.text}))
            .chain(scene.warnings.iter().map(|text| json!({"number": "", "text": text})))
            .collect();
        let mut answer = json!({
            "text": text, "error": null, "warnings": warnings, "sensors": map.sensors, "ways": ways(&scene), "saved": false,
            "duration_s": scene.run.duration.s(),
        });
        if whole {
            answer["map"] = json!(map);
            answer["places"] = places(&scene.airport.layout);
            answer["types"] = scene.traffic.types.designators().collect();
        }
        show(&info, &map, scene);
        answer
    }

    fn save(&self, known: &str, text: &str) -> Result<(), String> {
        let failed = |e: &dyn std::fmt::Display| format!("{}: {e}", self.file.display());
        let there = scenarios::text_of(&self.file).map_err(|e| e.to_string())?;
        if there != known {
            return Err(format!(
                "{} was changed by somebody else since it was read: load it again",
                self.file.display()
            ));
        }
        // Whole or not at all.
        let beside = self.file.with_extension("toml.new");
        std::fs::write(&beside, text).and_then(|()| std::fs::rename(&beside, &self.file)).map_err(
            |e| {
                let _ = std::fs::remove_file(&beside);
                failed(&e)
            },
        )
    }
}

/// Whether a place is on the pavement of a runway.
fn on_runway(layout: &Airport, place_m: Point2<f64>) -> bool {
    layout.runways.iter().any(|runway| {
        let [a, b] = runway.ends_m;
        let along = (b - a).normalize();
        let from = place_m - a;
        let (far, across) = (from.dot(&along), from.x * along.y - from.y * along.x);
        (0.0..=(b - a).norm()).contains(&far) && across.abs() <= 0.5 * runway.width_m
    })
}

/// The designator of the runway end that is nearest: who takes off from there begins there.
fn nearest_end(layout: &Airport, place_m: Point2<f64>) -> Option<String> {
    let ends = layout.runways.iter().flat_map(|r| r.names.iter().zip(r.thresholds_m));
    let far = |end_m: &Point2<f64>| (end_m - place_m).norm();
    ends.min_by(|a, b| far(&a.1).total_cmp(&far(&b.1))).map(|(name, _)| name.clone())
}

/// What a route may be clicked together of: stands with a way, and nodes by number, those that hold and those on a runway marked.
fn places(layout: &Airport) -> Value {
    let mut taken = BTreeSet::new();
    let mut rows = Vec::new();
    for stand in layout.stands.iter().filter(|s| s.node.is_some()) {
        taken.extend(stand.node);
        let at_m = [stand.position_m.x, stand.position_m.y];
        rows.push(json!({"name": stand.name, "kind": "stand", "at_m": at_m}));
    }
    let net = Network::of(layout);
    let holding: BTreeSet<&str> =
        net.nodes.iter().filter(|n| n.used && n.hold_for.is_some()).map(|n| &*n.name).collect();
    for (index, node) in layout.nodes.iter().enumerate().filter(|(i, _)| !taken.contains(i)) {
        let kind = match node.hold {
            _ if on_runway(layout, node.position_m) => "runway",
            Hold::Runway => "hold",
            _ if holding.contains(&*node.name) => "hold",
            _ => "node",
        };
        let number = layout.details.numbers.get(index).unwrap_or(&node.name);
        let at_m = [node.position_m.x, node.position_m.y];
        rows.push(json!({"name": format!("#{number}"), "kind": kind, "at_m": at_m}));
    }
    rows.into()
}

/// Where each mover of known places goes.
fn ways(scene: &Scene) -> Value {
    let end_s = scene.run.duration.s();
    let step_s = LEAST_STEP_S.max(end_s / MOST_POINTS as f64);
    let way = |entity: &scenarios::Entity| {
        let trajectory = entity.trajectory.as_ref()?;
        let at = |n: usize| trajectory.at(SimTime::from_s(n as f64 * step_s));
        let points = (0..=MOST_POINTS).filter_map(at);
        let mut line: Vec<[f64; 2]> = points.map(|s| [s.position_m.x, s.position_m.y]).collect();
        line.dedup_by(|a, b| libm::hypot(a[0] - b[0], a[1] - b[1]) < 1.0);
        Some(json!({"callsign": entity.callsign.as_str(), "points_m": line}))
    };
    scene.traffic.entities.iter().filter_map(way).collect()
}
