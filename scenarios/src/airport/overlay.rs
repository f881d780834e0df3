//! What no layout file says of an airport, or says wrongly: a TOML file beside it (`[airport] overlay`).
//!
//! Tables and keys: [`keys::OVERLAY`]. Applied in the order hold, edge, taxiway, stand, closed, area, runways, before the network is
//! made; each row says in the report what it did. Names are those of `seeds airport nodes`.

use super::AirportScene;
use crate::document::{Section, one_of, within};
use crate::error::{Problem, ScenarioError};
use crate::keys;
use models::airport::{
    Airport, Area, AreaKind, Edge, EdgeDetail, Hold, Node, StandDetail, distance_to_segment_m,
    inside,
};
use models::frames::Point2;
use models::time::SimTime;
use std::path::Path;

/// A place given for a holding position lies so near to a taxiway, m.
const HOLD_REACH_M: f64 = 30.0;
/// Letters of aerodrome reference codes.
const CODES: [(&str, char); 6] =
    [("A", 'A'), ("B", 'B'), ("C", 'C'), ("D", 'D'), ("E", 'E'), ("F", 'F')];

/// Changes the layout of `scene` as the file says.
///
/// # Errors
/// If the file cannot be read, has an unknown key, or names what the layout does not have.
pub(super) fn apply(scene: &mut AirportScene, file: &Path) -> Result<(), ScenarioError> {
    let root = Section::parse(file, &super::text_of(file)?)?;
    let tables: Vec<&str> = keys::OVERLAY.iter().map(|t| t.word).collect();
    root.only(&tables)?;
    let rows = |word: &str| -> Result<Vec<Section>, ScenarioError> {
        root.sections(word, &keys::overlay_words(word))
    };
    let mut said = Vec::new();
    for row in rows("hold")? {
        said.push(hold(scene, &row)?);
    }
    let layout = &mut scene.layout;
    align(layout);
    for row in rows("edge")? {
        said.push(edge(layout, &row)?);
    }
    for row in rows("taxiway")? {
        said.push(taxiway(layout, &row)?);
    }
    for row in rows("stand")? {
        said.push(stand(layout, &row)?);
    }
    for row in rows("closed")? {
        said.push(closed(scene, &row)?);
    }
    for row in rows("area")? {
        said.push(area(scene, &row)?);
    }
    if let Some(row) = root.section("runways", &keys::overlay_words("runways"))? {
        said.extend(runways(&mut scene.layout, &row)?);
    }
    let line = |text: String| format!("overlay: {text}");
    scene.report.lines.extend(said.into_iter().map(line));
    Ok(())
}

/// Details as long as what they belong to.
fn align(layout: &mut Airport) {
    let (edges, stands) = (layout.edges.len(), layout.stands.len());
    layout.details.edges.resize(edges, EdgeDetail::default());
    layout.details.stands.resize(stands, StandDetail::default());
}

fn unknown(row: &Section, key: &str, found: &str, names: &[&str]) -> ScenarioError {
    row.refuse(key, Problem::NotAllowed { found: found.into(), allowed: one_of(found, names) })
}

fn node_named(
    layout: &Airport,
    row: &Section,
    key: &str,
    name: &str,
) -> Result<usize, ScenarioError> {
    layout.node(name).ok_or_else(|| {
        let names: Vec<&str> = layout.nodes.iter().map(|n| n.name.as_str()).collect();
        unknown(row, key, name, &names)
    })
}

/// The two nodes that a key names.
fn two_nodes(layout: &Airport, row: &Section, key: &str) -> Result<[usize; 2], ScenarioError> {
    let names = row.texts(key)?;
    let [(a, _), (b, _)] = &names[..] else {
        let needed = "names of two nodes".into();
        let found = format!("{} names", names.len());
        return Err(row.refuse(key, Problem::WrongKind { found, needed }));
    };
    Ok([node_named(layout, row, key, a)?, node_named(layout, row, key, b)?])
}

/// Edges of a taxiway by name, or the one between two nodes.
fn edges_meant(
    layout: &Airport,
    row: &Section,
    name_key: &str,
) -> Result<Vec<usize>, ScenarioError> {
    let meant: Vec<usize> = match row.text(name_key)? {
        Some(name) => {
            let found: Vec<usize> =
                (0..layout.edges.len()).filter(|e| layout.edges[*e].name == name).collect();
            if found.is_empty() {
                let mut names: Vec<&str> = layout.edges.iter().map(|e| e.name.as_str()).collect();
                names.sort_unstable();
                names.dedup();
                return Err(unknown(row, name_key, name, &names));
            }
            found
        }
        None => {
            let [a, b] = two_nodes(layout, row, "edge")?;
            let between = |e: &Edge| [e.from, e.to] == [a, b] || [e.from, e.to] == [b, a];
            (0..layout.edges.len()).filter(|e| between(&layout.edges[*e])).collect()
        }
    };
    if meant.is_empty() {
        let needed = "two nodes that an edge joins".into();
        return Err(row.refuse("edge", Problem::WrongKind { found: "none there".into(), needed }));
    }
    Ok(meant)
}

/// A runway holding position at a node, or at a place, where its taxiway is cut.
fn hold(scene: &mut AirportScene, row: &Section) -> Result<String, ScenarioError> {
    let off = row.flag("off")?.unwrap_or(false);
    if row.has("node")
        && let Some(place) = keys::place_words().into_iter().find(|word| row.has(word))
    {
        let needed = "either node or a place".into();
        return Err(row.refuse(place, Problem::WrongKind { found: "both".into(), needed }));
    }
    let node = match row.text("node")? {
        Some(name) => node_named(&scene.layout, row, "node", name)?,
        None => {
            let at_m = scene.site(&row.without(&["node", "off"]))?.xy();
            cut_at(&mut scene.layout, at_m, row)?
        }
    };
    let layout = &mut scene.layout;
    layout.nodes[node].hold = if off { Hold::None } else { Hold::Runway };
    let name = &layout.nodes[node].name;
    Ok(if off { format!("nobody holds at {name}") } else { format!("holding position at {name}") })
}

/// The node at a place on a taxiway: the one that is there, or one that cuts it.
fn cut_at(layout: &mut Airport, at_m: Point2<f64>, row: &Section) -> Result<usize, ScenarioError> {
    let ends = |e: &Edge| [layout.nodes[e.from].position_m, layout.nodes[e.to].position_m];
    let off_m = |e: usize| {
        let [a, b] = ends(&layout.edges[e]);
        distance_to_segment_m(at_m, a, b)
    };
    let taxiways = (0..layout.edges.len()).filter(|e| !layout.edges[*e].runway);
    let nearest = taxiways.min_by(|a, b| off_m(*a).total_cmp(&off_m(*b)));
    let Some(e) = nearest.filter(|e| off_m(*e) <= HOLD_REACH_M) else {
        let found = "a place far from every taxiway".into();
        let needed = format!("a node, or a place within {HOLD_REACH_M} m of a taxiway");
        return Err(row.refuse("node", Problem::WrongKind { found, needed }));
    };
    let [a, b] = ends(&layout.edges[e]);
    let length_m = (b - a).norm();
    let place_m = ((at_m - a).dot(&(b - a)) / length_m.max(1e-9)).clamp(0.0, length_m);
    let Edge { from, to, .. } = layout.edges[e];
    if place_m < 2.0 || length_m - place_m < 2.0 {
        return Ok(if place_m < 2.0 { from } else { to });
    }
    align(layout);
    let node = layout.nodes.len();
    let position_m = a + (b - a) * (place_m / length_m);
    layout.nodes.push(Node { name: format!("overlay_{node}"), position_m, hold: Hold::None });
    let rest = Edge { from: node, ..layout.edges[e].clone() };
    let detail = layout.details.edges[e].clone();
    layout.edges[e].to = node;
    layout.edges.push(rest);
    layout.details.edges.push(detail);
    if !layout.details.numbers.is_empty() {
        layout.details.numbers.push(String::new());
    }
    Ok(node)
}

fn code_of(row: &Section) -> Result<Option<char>, ScenarioError> {
    row.choice("code", &CODES)
}

/// An edge that the file lacks.
fn edge(layout: &mut Airport, row: &Section) -> Result<String, ScenarioError> {
    let [from, to] = two_nodes(layout, row, "between")?;
    let name = row.text("name")?.unwrap_or("").to_owned();
    let two_way = !row.flag("one_way")?.unwrap_or(false);
    let width_m = row.number_or("width_m", super::ASSUMED_WIDTH_M, within(5.0, 100.0, "m"))?;
    let names = [from, to].map(|n| layout.nodes[n].name.clone());
    layout.edges.push(Edge { from, to, two_way, runway: false, name, width_m });
    layout.details.edges.push(EdgeDetail { code: code_of(row)?, zones: Vec::new() });
    Ok(format!("edge {}-{} added", names[0], names[1]))
}

/// Width, code and direction of what is there.
fn taxiway(layout: &mut Airport, row: &Section) -> Result<String, ScenarioError> {
    if row.has("name") && row.has("edge") {
        let needed = "either name or edge".into();
        return Err(row.refuse("edge", Problem::WrongKind { found: "both".into(), needed }));
    }
    let meant = edges_meant(layout, row, "name")?;
    let (code, width) = (code_of(row)?, row.number("width_m", within(5.0, 100.0, "m"))?);
    let one_way = row.flag("one_way")?;
    if one_way == Some(true) && row.has("name") {
        let needed = "edge = [from, to], which says the direction".into();
        return Err(row.refuse("one_way", Problem::WrongKind { found: "a name".into(), needed }));
    }
    let first = if row.has("edge") { Some(two_nodes(layout, row, "edge")?) } else { None };
    for e in &meant {
        if let Some(code) = code {
            layout.details.edges[*e].code = Some(code);
        }
        let edge = &mut layout.edges[*e];
        edge.width_m = width.unwrap_or(edge.width_m);
        edge.two_way = one_way.map_or(edge.two_way, |o| !o);
        if let (Some([from, to]), Some(true)) = (first, one_way) {
            (edge.from, edge.to) = (from, to);
        }
    }
    Ok(format!("{} edges changed", meant.len()))
}

fn stand_named(
    layout: &Airport,
    row: &Section,
    key: &str,
    name: &str,
) -> Result<usize, ScenarioError> {
    layout.stands.iter().position(|s| s.name == name).ok_or_else(|| {
        let names: Vec<&str> = layout.stands.iter().map(|s| s.name.as_str()).collect();
        unknown(row, key, name, &names)
    })
}

/// What a stand is for.
fn stand(layout: &mut Airport, row: &Section) -> Result<String, ScenarioError> {
    let name = row.need_text("name", "the name of a stand")?;
    let s = stand_named(layout, row, "name", name)?;
    if let Some(code) = code_of(row)? {
        layout.details.stands[s].code = Some(code);
    }
    if let Some(kind) = row.text("kind")? {
        layout.details.stands[s].kind = kind.to_owned();
    }
    if let Some(deg) = row.number("heading_deg", within(0.0, 360.0, "deg"))? {
        layout.stands[s].heading_rad = deg.to_radians();
    }
    Ok(format!("stand {name} changed"))
}

/// Nobody uses these for the whole run.
fn closed(scene: &mut AirportScene, row: &Section) -> Result<String, ScenarioError> {
    let all = ["taxiway", "edge", "stand", "area", "runway"];
    let given = all.into_iter().filter(|k| row.has(k)).count();
    if given != 1 {
        let needed = "one of taxiway, edge, stand, area, runway".into();
        return Err(
            row.refuse("taxiway", Problem::WrongKind { found: format!("{given} of them"), needed })
        );
    }
    if let Some(name) = row.text("runway")? {
        return closed_runway(&mut scene.layout, row, name);
    }
    if let Some(key) = ["from_s", "until_s"].into_iter().find(|key| row.has(key)) {
        let needed = "only with runway: what else is closed is closed for the whole run".into();
        return Err(row.refuse(key, Problem::WrongKind { found: "a time".into(), needed }));
    }
    let (mut edges, mut stands) = (Vec::new(), Vec::new());
    if let Some(name) = row.text("stand")? {
        stands.push(stand_named(&scene.layout, row, "stand", name)?);
    } else if row.has("area") {
        let corners = outline_m(scene, row, "area")?;
        let layout = &scene.layout;
        let touched = |e: &Edge| {
            let [a, b] = [layout.nodes[e.from].position_m, layout.nodes[e.to].position_m];
            let count = ((b - a).norm() / 2.0).ceil().max(1.0);
            (0..=count as usize).any(|k| inside(&corners, a + (b - a) * (k as f64 / count)))
        };
        edges.extend((0..layout.edges.len()).filter(|e| touched(&layout.edges[*e])));
        let within = |s: &usize| inside(&corners, layout.stands[*s].position_m);
        stands.extend((0..layout.stands.len()).filter(within));
        let times = (SimTime(i64::MIN), SimTime(i64::MAX));
        scene.layout.details.areas.push(Area {
            kind: AreaKind::Closed,
            outline_m: corners,
            from: times.0,
            until: times.1,
        });
    } else {
        edges = edges_meant(&scene.layout, row, "taxiway")?;
    }
    let layout = &mut scene.layout;
    remove_edges(layout, &edges);
    keep(&mut layout.stands, &stands);
    keep(&mut layout.details.stands, &stands);
    Ok(format!("{} edges and {} stands closed", edges.len(), stands.len()))
}

/// The corners of a place, m.
fn outline_m(
    scene: &AirportScene,
    row: &Section,
    key: &str,
) -> Result<Vec<Point2<f64>>, ScenarioError> {
    let corners = row.sections(key, &keys::place_words())?;
    let corners: Vec<Point2<f64>> =
        corners.iter().map(|c| scene.site(c).map(|p| p.xy())).collect::<Result<_, _>>()?;
    if corners.len() < 3 {
        let found = format!("{} corners", corners.len());
        return Err(row.refuse(key, Problem::WrongKind { found, needed: "3 at least".into() }));
    }
    Ok(corners)
}

/// From when and until when a row holds.
fn times(row: &Section) -> Result<[SimTime; 2], ScenarioError> {
    let from_s = row.number_or("from_s", 0.0, within(0.0, 1e6, "s"))?;
    let until_s = row.number("until_s", within(0.0, 1e6, "s"))?;
    if let Some(until_s) = until_s.filter(|until_s| *until_s <= from_s) {
        let (found, needed) = (format!("{until_s}"), format!("a time after from_s = {from_s}"));
        return Err(row.refuse("until_s", Problem::WrongKind { found, needed }));
    }
    Ok([SimTime::from_s(from_s), until_s.map_or(SimTime(i64::MAX), SimTime::from_s)])
}

/// A runway that is closed for a time.
fn closed_runway(layout: &mut Airport, row: &Section, name: &str) -> Result<String, ScenarioError> {
    let ends = || layout.runways.iter().flat_map(|r| r.names.iter().map(String::as_str));
    if !ends().any(|end| end == name) {
        return Err(unknown(row, "runway", name, &ends().collect::<Vec<_>>()));
    }
    layout.details.closures.push((name.to_owned(), times(row)?));
    Ok(format!("runway {name} is closed for a time"))
}

/// Ground that is protected for a time.
fn area(scene: &mut AirportScene, row: &Section) -> Result<String, ScenarioError> {
    let kinds = [
        ("closed", AreaKind::Closed),
        ("ils", AreaKind::Ils),
        ("restricted", AreaKind::Restricted),
    ];
    let kind = row.choice("kind", &kinds)?;
    let kind =
        kind.ok_or_else(|| row.missing("kind", "why it is protected, like \"ils\"".into()))?;
    let (outline_m, [from, until]) = (outline_m(scene, row, "corners")?, times(row)?);
    scene.layout.details.areas.push(Area { kind, outline_m, from, until });
    Ok(format!("an area is {}", row.text("kind")?.unwrap_or_default()))
}

fn keep<T>(list: &mut Vec<T>, without: &[usize]) {
    let mut index = 0;
    list.retain(|_| {
        index += 1;
        !without.contains(&(index - 1))
    });
}

fn remove_edges(layout: &mut Airport, out: &[usize]) {
    let joined = std::mem::take(&mut layout.details.joined);
    let left = joined.into_iter().filter(|e| !out.contains(e));
    layout.details.joined = left.map(|e| e - out.iter().filter(|o| **o < e).count()).collect();
    keep(&mut layout.edges, out);
    keep(&mut layout.details.edges, out);
}

/// Ends in use.
fn runways(layout: &mut Airport, row: &Section) -> Result<Vec<String>, ScenarioError> {
    let mut said = Vec::new();
    for (way, key) in ["arrival", "departure"].into_iter().enumerate() {
        let ends: Vec<String> = row.texts(key)?.into_iter().map(|(name, _)| name).collect();
        let names: Vec<&str> =
            layout.runways.iter().flat_map(|r| r.names.iter().map(String::as_str)).collect();
        if let Some(wrong) = ends.iter().find(|e| !names.contains(&e.as_str())) {
            return Err(unknown(row, key, wrong, &names));
        }
        if !ends.is_empty() {
            said.push(format!("runways of {key}s: {}", ends.join(", ")));
            layout.details.in_use[way] = ends;
        }
    }
    Ok(said)
}
