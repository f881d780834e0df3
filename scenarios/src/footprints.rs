//! Buildings of an OpenStreetMap extract as `[[building]]` of a scene: footprints with heights and where
//! each is from. Read are `.osm` (XML), Overpass JSON and GeoJSON.
//!
//! A building is a way or a multipolygon relation (the rings of its outer members; courts are filled) with `building`
//! (not "no") or `aeroway` = terminal or hangar. Its height is `height`,
//! else `building:levels` times 4 m, else what is usual for its kind; the last two are marked assumed.

use crate::error::{Problem, ScenarioError};
use crate::files;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// Octets of the largest extract.
const LARGEST: u64 = 256 << 20;
/// Most buildings that are taken over: the largest ones.
pub const MOST: usize = 300;
/// Height of a storey where only their number is known, m (assumed).
const STOREY_M: f64 = 4.0;
/// Most corners of a footprint.
const CORNERS: usize = 200;
/// Least area of a footprint that matters to a radar, m².
const LEAST_M2: f64 = 100.0;

/// A building of an extract.
#[derive(Clone, Debug, PartialEq)]
pub struct Footprint {
    /// Its name, or its kind and number.
    pub name: String,
    /// Identifier in the extract.
    pub id: String,
    /// Corners, degrees of latitude and longitude, not closed.
    pub corners_deg: Vec<(f64, f64)>,
    /// Height, m.
    pub height_m: f64,
    /// Where the height is from.
    pub height_from: String,
    /// Area, m².
    pub area_m2: f64,
    /// What it is faced with: "metal" for hangars, else "concrete".
    pub facade: &'static str,
}

/// The buildings of an extract, the largest first, at most [`MOST`]; and how many were left out.
///
/// # Errors
/// If the file cannot be read, or is no extract, or has no building.
pub fn read(file: &Path) -> Result<(Vec<Footprint>, usize), ScenarioError> {
    let refuse = |line: usize, problem| ScenarioError::new(file, line, "buildings", problem);
    let text = files::read_text(file, LARGEST)
        .map_err(|e| refuse(1, Problem::Unreadable { reason: e.to_string() }))?;
    let damaged = |line: usize, found: String, needed: &'static str| {
        refuse(line, Problem::Line { found, needed })
    };
    let ways = if text.trim_start().starts_with('<') {
        let document = roxmltree::Document::parse(&text)
            .map_err(|e| damaged(e.pos().row as usize, e.to_string(), "OpenStreetMap XML"))?;
        of_xml(&document)
    } else {
        let document: Value = serde_json::from_str(&text)
            .map_err(|e| damaged(e.line(), e.to_string(), "Overpass JSON or GeoJSON"))?;
        match (document["elements"].as_array(), document["features"].as_array()) {
            (Some(elements), _) => of_overpass(elements),
            (None, Some(features)) => features.iter().flat_map(of_feature).collect(),
            (None, None) => {
                let found = "neither elements nor features".to_owned();
                return Err(damaged(1, found, "Overpass JSON or GeoJSON"));
            }
        }
    };
    let mut found: Vec<Footprint> = ways.into_iter().filter_map(footprint).collect();
    if found.is_empty() {
        let needed = "ways with building = … or aeroway = terminal or hangar, of 100 m² or more";
        return Err(damaged(1, "no building".to_owned(), needed));
    }
    found.sort_by(|a, b| b.area_m2.total_cmp(&a.area_m2).then(a.id.cmp(&b.id)));
    let left_out = found.len().saturating_sub(MOST);
    found.truncate(MOST);
    Ok((found, left_out))
}

/// The buildings as `[[building]]` of a scene, with a head that says where they are from.
#[must_use]
pub fn to_toml(found: &[Footprint], source: &str) -> String {
    let mut text = format!(
        "# Buildings of {source}. Data © OpenStreetMap contributors, Open Database Licence 1.0: say so where you publish it.\n\
         # Facades are assumed, and heights where it says so.\n"
    );
    for b in found {
        let _ = write!(
            text,
            "\n[[building]]\nname = {}\nheight_m = {:.1}   # {}\nfacade = \"{}\"   # assumed; {}\nfootprint = [\n",
            Value::from(b.name.as_str()),
            b.height_m,
            b.height_from,
            b.facade,
            b.id
        );
        for (lat, lon) in &b.corners_deg {
            let _ = writeln!(text, "    {{ lat_deg = {lat:.7}, lon_deg = {lon:.7} }},");
        }
        text.push_str("]\n");
    }
    text
}

#[derive(Clone)]
struct Way {
    id: String,
    tags: BTreeMap<String, String>,
    corners_deg: Vec<(f64, f64)>,
}

fn footprint(way: Way) -> Option<Footprint> {
    let Way { id, tags, mut corners_deg } = way;
    let building = tags.get("building").filter(|v| *v != "no");
    let aeroway = tags.get("aeroway").filter(|v| matches!(v.as_str(), "terminal" | "hangar"));
    let kind = aeroway.or(building)?.clone();
    if corners_deg.len() > 1 && corners_deg.first() == corners_deg.last() {
        corners_deg.pop();
    }
    corners_deg.dedup();
    if corners_deg.len() < 3 {
        return None;
    }
    // As many corners as a scene takes: every nth of a round one.
    if corners_deg.len() > CORNERS {
        let every = corners_deg.len().div_ceil(CORNERS);
        corners_deg = corners_deg.into_iter().step_by(every).collect();
    }
    let area_m2 = area_m2(&corners_deg);
    if !(area_m2 >= LEAST_M2) {
        return None;
    }
    let stated = tags.get("height").and_then(|text| metres(text)).map(|m| (m, "height".to_owned()));
    let storeys = || {
        let levels: f64 = tags.get("building:levels")?.trim().parse().ok()?;
        (levels > 0.0).then(|| (levels * STOREY_M, format!("{levels} storeys of 4 m, assumed")))
    };
    let usual = match kind.as_str() {
        "terminal" => 15.0,
        "hangar" => 14.0,
        _ => 8.0,
    };
    let (height_m, height_from) =
        stated.or_else(storeys).unwrap_or_else(|| (usual, "assumed, usual for its kind".into()));
    let name = tags.get("name").or(tags.get("ref")).cloned();
    Some(Footprint {
        name: name
            .unwrap_or_else(|| format!("{} {id}", if kind == "yes" { "building" } else { &kind })),
        facade: if kind == "hangar" { "metal" } else { "concrete" },
        id,
        corners_deg,
        height_m: height_m.clamp(1.0, 500.0),
        height_from,
        area_m2,
    })
}

/// "12", "12 m", "12.5m", "40 ft", "40'": metres.
fn metres(text: &str) -> Option<f64> {
    let text = text.trim();
    let end = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    let number: f64 = text[..end].parse().ok()?;
    let factor = match text[end..].trim() {
        "" | "m" => 1.0,
        "ft" | "'" => 0.3048,
        _ => return None,
    };
    (number > 0.0).then_some(number * factor)
}

/// Area on the plane that touches the first corner.
fn area_m2(corners_deg: &[(f64, f64)]) -> f64 {
    const PER_DEGREE_M: f64 = 111_320.0;
    let Some(&(lat0, lon0)) = corners_deg.first() else { return 0.0 };
    let cos = models::frames::Azimuth::from_rad(lat0.to_radians()).unit().y;
    let flat =
        |&(lat, lon): &(f64, f64)| ((lon - lon0) * PER_DEGREE_M * cos, (lat - lat0) * PER_DEGREE_M);
    let next = corners_deg.iter().cycle().skip(1);
    let twice: f64 = corners_deg
        .iter()
        .zip(next)
        .map(|(a, b)| {
            let ((ax, ay), (bx, by)) = (flat(a), flat(b));
            ax * by - ay * bx
        })
        .sum();
    0.5 * twice.abs()
}

/// A multipolygon: its outer members by number, with their places where the extract gives them.
struct Relation {
    id: String,
    tags: BTreeMap<String, String>,
    outer: Vec<(String, Vec<(f64, f64)>)>,
}

/// The rings of relations beside the ways; outer members of a building that closes are no buildings themselves.
fn with_relations(mut ways: Vec<Way>, relations: Vec<Relation>) -> Vec<Way> {
    let mut rings = Vec::new();
    let mut members = std::collections::BTreeSet::new();
    for Relation { id, tags, outer } in relations {
        // An airport, an apron or a site that has buildings among its members is none.
        let multipolygon = tags.get("type").is_none_or(|t| t == "multipolygon");
        let built = tags.get("building").is_some_and(|v| v != "no")
            || tags.get("aeroway").is_some_and(|v| matches!(v.as_str(), "terminal" | "hangar"));
        if !multipolygon || !built {
            continue;
        }
        let part = |(of, own): &(String, Vec<(f64, f64)>)| match own.is_empty() {
            true => ways.iter().find(|w| w.id == *of).map_or(Vec::new(), |w| w.corners_deg.clone()),
            false => own.clone(),
        };
        let found = joined(outer.iter().map(part).collect());
        if !found.is_empty() {
            members.extend(outer.into_iter().map(|(of, _)| of));
        }
        let way = |corners_deg| Way { id: id.clone(), tags: tags.clone(), corners_deg };
        rings.extend(found.into_iter().map(way));
    }
    ways.retain(|way| !members.contains(&way.id));
    ways.extend(rings);
    ways
}

/// Parts that share their ends, joined to closed rings; what does not close is left out.
fn joined(mut parts: Vec<Vec<(f64, f64)>>) -> Vec<Vec<(f64, f64)>> {
    let mut rings = Vec::new();
    parts.retain(|part| part.len() > 1);
    while let Some(mut ring) = parts.pop() {
        while ring.first() != ring.last() {
            let end = ring.last().copied();
            let next =
                parts.iter().position(|p| p.first().copied() == end || p.last().copied() == end);
            let Some(next) = next else { break };
            let mut part = parts.swap_remove(next);
            if part.first().copied() != end {
                part.reverse();
            }
            ring.extend(part.into_iter().skip(1));
        }
        if ring.first() == ring.last() {
            rings.push(ring);
        }
    }
    rings
}

fn sound((lat, lon): (f64, f64)) -> Option<(f64, f64)> {
    (lat.abs() <= 90.0 && lon.abs() <= 180.0).then_some((lat, lon))
}

fn of_xml(document: &roxmltree::Document<'_>) -> Vec<Way> {
    let mut places = BTreeMap::new();
    let (mut ways, mut relations) = (Vec::new(), Vec::new());
    for node in document.descendants() {
        let id = node.attribute("id").unwrap_or("");
        if node.has_tag_name("node") {
            let number = |key: &str| node.attribute(key).and_then(|v| v.parse::<f64>().ok());
            if let Some(place) = number("lat").zip(number("lon")).and_then(sound) {
                places.insert(id.to_owned(), place);
            }
        } else if node.has_tag_name("way") {
            let (mut tags, mut corners_deg) = (BTreeMap::new(), Vec::new());
            for part in node.children() {
                if let Some(place) = part.attribute("ref").and_then(|id| places.get(id)) {
                    corners_deg.push(*place);
                }
                if let (Some(k), Some(v)) = (part.attribute("k"), part.attribute("v")) {
                    tags.insert(k.to_owned(), v.to_owned());
                }
            }
            ways.push(Way { id: format!("way/{id}"), tags, corners_deg });
        } else if node.has_tag_name("relation") {
            let (mut tags, mut outer) = (BTreeMap::new(), Vec::new());
            for part in node.children() {
                let role = part.attribute("role").unwrap_or("");
                if part.attribute("type") == Some("way") && matches!(role, "" | "outer") {
                    outer.extend(part.attribute("ref").map(|id| (format!("way/{id}"), Vec::new())));
                }
                if let (Some(k), Some(v)) = (part.attribute("k"), part.attribute("v")) {
                    tags.insert(k.to_owned(), v.to_owned());
                }
            }
            relations.push(Relation { id: format!("relation/{id}"), tags, outer });
        }
    }
    with_relations(ways, relations)
}

fn tags_of(value: &Value) -> BTreeMap<String, String> {
    let text = |v: &Value| match v {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    };
    let entries = value.as_object().into_iter().flatten();
    entries.filter_map(|(k, v)| Some((k.clone(), text(v)?))).collect()
}

fn of_overpass(elements: &[Value]) -> Vec<Way> {
    let place = |e: &Value| e["lat"].as_f64().zip(e["lon"].as_f64()).and_then(sound);
    let nodes: BTreeMap<i64, (f64, f64)> = elements
        .iter()
        .filter(|e| e["type"] == "node")
        .filter_map(|e| Some((e["id"].as_i64()?, place(e)?)))
        .collect();
    let way = |e: &Value| {
        // "out geom" gives the places themselves.
        let own = e["geometry"].as_array().map(|list| list.iter().filter_map(place).collect());
        let by_number = || {
            let ids = e["nodes"].as_array().map_or(&[][..], Vec::as_slice);
            ids.iter().filter_map(|id| nodes.get(&id.as_i64()?).copied()).collect()
        };
        let corners_deg = own.unwrap_or_else(by_number);
        Way { id: format!("way/{}", e["id"]), tags: tags_of(&e["tags"]), corners_deg }
    };
    let relation = |e: &Value| {
        let members = e["members"].as_array().map_or(&[][..], Vec::as_slice);
        let is_outer = |m: &&Value| {
            m["type"] == "way" && matches!(m["role"].as_str(), None | Some("" | "outer"))
        };
        let outer = members.iter().filter(is_outer).map(|m| {
            let list = m["geometry"].as_array().map_or(&[][..], Vec::as_slice);
            (format!("way/{}", m["ref"]), list.iter().filter_map(place).collect())
        });
        let id = format!("relation/{}", e["id"]);
        Relation { id, tags: tags_of(&e["tags"]), outer: outer.collect() }
    };
    let of_type = |kind: &'static str| elements.iter().filter(move |e| e["type"] == kind);
    with_relations(of_type("way").map(way).collect(), of_type("relation").map(relation).collect())
}

fn of_feature(feature: &Value) -> Vec<Way> {
    let geometry = &feature["geometry"];
    let ring = |list: &Value| -> Vec<(f64, f64)> {
        let place = |c: &Value| c[1].as_f64().zip(c[0].as_f64()).and_then(sound);
        list.as_array().map_or(&[][..], Vec::as_slice).iter().filter_map(place).collect()
    };
    let shape = &geometry["coordinates"];
    let rings = match geometry["type"].as_str() {
        Some("Polygon") => vec![ring(&shape[0])],
        Some("MultiPolygon") => {
            shape.as_array().map_or(&[][..], Vec::as_slice).iter().map(|p| ring(&p[0])).collect()
        }
        Some("LineString") => vec![ring(shape)],
        _ => Vec::new(),
    };
    let tags = tags_of(&feature["properties"]);
    let id = match (&feature["id"], tags.get("@id").or(tags.get("id"))) {
        (Value::String(id), _) => id.clone(),
        (Value::Number(id), _) => id.to_string(),
        (_, Some(id)) => id.clone(),
        _ => "without identifier".to_owned(),
    };
    let way = |corners_deg| Way { id: id.clone(), tags: tags.clone(), corners_deg };
    rings.into_iter().map(way).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hangar of about 100 m by 60 m, a shed too small to matter, a terminal with storeys.
    const GEOJSON: &str = r#"{ "type": "FeatureCollection", "features": [
        { "id": "way/1", "properties": { "aeroway": "hangar", "height": "18 m", "name": "Hangar 1" },
          "geometry": { "type": "Polygon", "coordinates":
            [[[8.55, 47.45], [8.5513, 47.45], [8.5513, 47.4505], [8.55, 47.4505], [8.55, 47.45]]] } },
        { "id": "way/2", "properties": { "building": "shed" },
          "geometry": { "type": "Polygon", "coordinates":
            [[[8.55, 47.45], [8.55003, 47.45], [8.55003, 47.45003], [8.55, 47.45]]] } },
        { "id": "way/3", "properties": { "building": "yes", "building:levels": 3 },
          "geometry": { "type": "Polygon", "coordinates":
            [[[8.56, 47.45], [8.561, 47.45], [8.561, 47.4503], [8.56, 47.4503], [8.56, 47.45]]] } } ] }"#;

    const XML: &str = r#"<osm version="0.6">
        <node id="1" lat="47.45" lon="8.55"/><node id="2" lat="47.45" lon="8.5513"/>
        <node id="3" lat="47.4505" lon="8.5513"/><node id="4" lat="47.4505" lon="8.55"/>
        <way id="7"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/>
          <tag k="aeroway" v="terminal"/></way></osm>"#;

    fn of(name: &str, text: &str) -> Result<(Vec<Footprint>, usize), ScenarioError> {
        let folder = std::env::temp_dir().join(format!("seeds-footprints-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let file = folder.join(name);
        std::fs::write(&file, text).expect("written");
        read(&file)
    }

    #[test]
    fn buildings_of_an_extract_become_buildings_of_a_scene() {
        let (found, left_out) = of("a.geojson", GEOJSON).expect("an extract");
        assert_eq!((found.len(), left_out), (2, 0));
        let (hangar, other) = (&found[0], &found[1]);
        assert_eq!((&*hangar.name, hangar.height_m, hangar.facade), ("Hangar 1", 18.0, "metal"));
        assert!((hangar.area_m2 - 5440.0).abs() < 100.0, "{}", hangar.area_m2);
        assert_eq!(hangar.corners_deg.len(), 4);
        assert_eq!((&*other.name, other.height_m), ("building way/3", 12.0));
        assert!(other.height_from.contains("assumed"));
        let text = to_toml(&found, "a.geojson");
        let root = crate::document::Section::parse(Path::new("x.toml"), &text).expect("TOML");
        let keys = ["name", "height_m", "facade", "footprint"];
        assert_eq!(root.sections("building", &keys).expect("sections").len(), 2);
        let (found, _) = of("b.osm", XML).expect("an extract");
        assert_eq!((found.len(), found[0].height_m, found[0].corners_deg.len()), (1, 15.0, 4));
    }

    #[test]
    fn buildings_whose_outline_is_of_several_ways_are_joined() {
        // Two halves of a hall, one of them written the other way round, and an inner court.
        let nodes: String =
            [(1, 47.45, 8.55), (2, 47.45, 8.5513), (3, 47.4505, 8.5513), (4, 47.4505, 8.55)]
                .iter()
                .map(|(id, lat, lon)| format!("<node id=\"{id}\" lat=\"{lat}\" lon=\"{lon}\"/>"))
                .collect();
        let xml = |second: &str| {
            format!(
                "<osm>{nodes}<way id=\"7\"><nd ref=\"1\"/><nd ref=\"2\"/><nd ref=\"3\"/></way>\
                 <way id=\"8\">{second}<tag k=\"building\" v=\"yes\"/></way>\
                 <relation id=\"9\"><member type=\"way\" ref=\"7\" role=\"outer\"/>\
                 <member type=\"way\" ref=\"8\" role=\"outer\"/><member type=\"way\" ref=\"6\" role=\"inner\"/>\
                 <tag k=\"type\" v=\"multipolygon\"/><tag k=\"aeroway\" v=\"terminal\"/></relation></osm>"
            )
        };
        for second in [
            "<nd ref=\"3\"/><nd ref=\"4\"/><nd ref=\"1\"/>",
            "<nd ref=\"1\"/><nd ref=\"4\"/><nd ref=\"3\"/>",
        ] {
            let (found, _) = of("g.osm", &xml(second)).expect("an extract");
            assert_eq!((found.len(), &*found[0].id), (1, "relation/9"), "{second}");
            assert!((found[0].area_m2 - 5440.0).abs() < 100.0, "{}", found[0].area_m2);
        }
        // What does not close is none; its member is a building by itself, if it is one.
        let (found, _) =
            of("h.osm", &xml("<nd ref=\"2\"/><nd ref=\"3\"/><nd ref=\"4\"/>")).expect("an extract");
        assert_eq!(&*found[0].id, "way/8");
        // A site, an apron and what is said to be no building leave their members as they are.
        for (kind, said) in [
            ("site", "<tag k=\"aeroway\" v=\"terminal\"/>"),
            ("multipolygon", "<tag k=\"aeroway\" v=\"apron\"/>"),
        ] {
            let text = format!(
                "<osm>{nodes}<way id=\"7\"><nd ref=\"1\"/><nd ref=\"2\"/><nd ref=\"3\"/><nd ref=\"4\"/><nd ref=\"1\"/>\
                 <tag k=\"building\" v=\"yes\"/></way><relation id=\"9\"><member type=\"way\" ref=\"7\" role=\"\"/>\
                 <tag k=\"type\" v=\"{kind}\"/>{said}</relation></osm>"
            );
            let (found, _) = of("s.osm", &text).expect("an extract");
            assert_eq!((found.len(), &*found[0].id), (1, "way/7"), "{kind}");
        }
        let json = r#"{ "elements": [ { "type": "relation", "id": 5, "tags": { "building": "yes" }, "members": [
            { "type": "way", "ref": 1, "role": "outer", "geometry": [ { "lat": 47.45, "lon": 8.55 },
              { "lat": 47.45, "lon": 8.5513 }, { "lat": 47.4505, "lon": 8.5513 } ] },
            { "type": "way", "ref": 2, "role": "outer", "geometry": [ { "lat": 47.45, "lon": 8.55 },
              { "lat": 47.4505, "lon": 8.55 }, { "lat": 47.4505, "lon": 8.5513 } ] } ] } ] }"#;
        let (found, _) = of("i.json", json).expect("an extract");
        assert_eq!((found.len(), found[0].corners_deg.len()), (1, 4));
    }

    #[test]
    fn what_is_no_extract_is_refused_with_what_is_needed() {
        for (name, text, said) in [
            ("c.json", "{}", "neither elements nor features"),
            ("d.json", "{ \"elements\": [] }", "no building"),
            ("e.osm", "<osm><way></osm>", "OpenStreetMap XML"),
            ("f.json", "[", "Overpass JSON or GeoJSON"),
        ] {
            let error = of(name, text).expect_err(name).to_string();
            assert!(error.contains(said), "{error}");
        }
        assert_eq!(metres("40 ft").map(|m| (m * 10.0).round()), Some(122.0));
        assert_eq!((metres("12,5"), metres("tall"), metres("-3")), (None, None, None));
    }
}
