//! The airport of a run as features and placemarks.

use super::{Run, digits, escaped};
use serde_json::{Value, json};
use std::fmt::Write as _;

/// Where something is.
enum Form {
    Point([f64; 2]),
    Line(Vec<[f64; 2]>),
    /// The outline and its holes.
    Area(Vec<Vec<[f64; 2]>>),
}

/// One thing of the airport.
struct Place {
    kind: &'static str,
    name: String,
    /// What else is said of it, by name.
    more: Option<(&'static str, f64)>,
    form: Form,
}

/// All of it, in the order in which it is drawn: what lies below first.
fn of(run: &Run) -> Vec<Place> {
    let map = &run.map;
    let mut all = Vec::new();
    let mut put = |kind, name: &str, more, form| {
        all.push(Place { kind, name: name.to_owned(), more, form });
    };
    for area in &map.pavements {
        put("pavement", &area.name, None, Form::Area(area.rings.clone()));
    }
    for runway in &map.runways {
        let [[ax, ay], [bx, by]] = runway.ends;
        let length_m = libm::hypot(bx - ax, by - ay).max(1e-9);
        let half = 0.5 * runway.width_m / length_m;
        let (rx, ry) = ((by - ay) * half, (ax - bx) * half);
        let ring =
            vec![[ax - rx, ay - ry], [ax + rx, ay + ry], [bx + rx, by + ry], [bx - rx, by - ry]];
        let more = Some(("width_m", runway.width_m));
        put("runway", &runway.designators.join("/"), more, Form::Area(vec![ring]));
    }
    for line in &map.taxiways {
        put("taxiway", &line.name, None, Form::Line(line.points_m.clone()));
    }
    for hold in &map.holds {
        put("hold", &hold.runway, None, Form::Line(hold.ends_m.to_vec()));
    }
    for stand in &map.stands {
        put("stand", &stand.name, None, Form::Point(stand.position_m));
    }
    for area in map.buildings.iter().filter(|_| map.blocks.is_empty()) {
        put("building", &area.name, None, Form::Area(area.rings.clone()));
    }
    for block in &map.blocks {
        let more = Some(("height_m", block.height_m));
        put("building", &block.name, more, Form::Area(vec![block.ring.clone()]));
    }
    for sensor in &map.sensors {
        if let Some(at) = sensor.position_m {
            put("sensor", &sensor.name, None, Form::Point(at));
        }
    }
    all
}

impl Form {
    /// In degrees; rings closed, the outline counter-clockwise and holes clockwise (RFC 7946).
    fn degrees(&self, run: &Run) -> Self {
        let place = |p: &[f64; 2]| run.place(*p).map(|degrees| digits(degrees, 7));
        let line = |points: &Vec<[f64; 2]>| points.iter().map(place).collect::<Vec<_>>();
        match self {
            Self::Point(at) => Self::Point(place(at)),
            Self::Line(points) => Self::Line(line(points)),
            Self::Area(rings) => {
                let ring = |(number, ring): (usize, &Vec<[f64; 2]>)| {
                    let mut ring = line(ring);
                    if ring.first() == ring.last() {
                        ring.pop();
                    }
                    if (signed_area(&ring) > 0.0) != (number == 0) {
                        ring.reverse();
                    }
                    ring.extend(ring.first().copied());
                    ring
                };
                Self::Area(rings.iter().enumerate().map(ring).collect())
            }
        }
    }
}

/// Twice the area within a ring, positive where it runs counter-clockwise.
fn signed_area(ring: &[[f64; 2]]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum()
}

/// GeoJSON.
pub(super) fn features(run: &Run) -> Vec<Value> {
    let feature = |place: Place| {
        let mut properties = json!({"kind": place.kind, "name": place.name});
        if let Some((name, value)) = place.more {
            properties[name] = json!(digits(value, 3));
        }
        let geometry = match place.form.degrees(run) {
            Form::Point(at) => json!({"type": "Point", "coordinates": at}),
            Form::Line(points) => json!({"type": "LineString", "coordinates": points}),
            Form::Area(rings) => json!({"type": "Polygon", "coordinates": rings}),
        };
        json!({"type": "Feature", "properties": properties, "geometry": geometry})
    };
    of(run).into_iter().map(feature).collect()
}

/// KML, a folder.
pub(super) fn kml(run: &Run, out: &mut String) {
    let places = of(run);
    if places.is_empty() {
        return;
    }
    out.push_str("<Folder><name>airport</name>\n");
    for place in places {
        let text = |points: &[[f64; 2]]| {
            let points = points.iter().map(|[lon, lat]| format!("{lon:.7},{lat:.7}"));
            format!("<coordinates>{}</coordinates>", points.collect::<Vec<_>>().join(" "))
        };
        let form = match place.form.degrees(run) {
            Form::Point(at) => format!("<Point>{}</Point>", text(&[at])),
            Form::Line(points) => format!("<LineString>{}</LineString>", text(&points)),
            Form::Area(rings) => {
                let ring = |(number, ring): (usize, &Vec<[f64; 2]>)| {
                    let side = if number == 0 { "outerBoundaryIs" } else { "innerBoundaryIs" };
                    format!("<{side}><LinearRing>{}</LinearRing></{side}>", text(ring))
                };
                let rings: String = rings.iter().enumerate().map(ring).collect();
                format!("<Polygon>{rings}</Polygon>")
            }
        };
        let name = match place.name.is_empty() {
            true => place.kind.to_owned(),
            false => format!("{} {}", place.kind, place.name),
        };
        writeln!(out, "<Placemark><name>{}</name>{form}</Placemark>", escaped(&name)).ok();
    }
    out.push_str("</Folder>\n");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer_logger::picture::{AirportMap, NamedArea, RunwayShape};
    use geodesy::{Geodetic, LocalFrame};
    use std::collections::BTreeMap;

    /// RFC 7946: rings are closed, the outline runs counter-clockwise and holes clockwise, whichever way they came.
    #[test]
    fn areas_are_closed_and_run_as_the_standard_has_it() {
        let square = |r: f64| vec![[-r, -r], [-r, r], [r, r], [r, -r]];
        let backwards = |ring: Vec<[f64; 2]>| ring.into_iter().rev().collect::<Vec<_>>();
        let mut closed = square(50.0);
        closed.push(closed[0]);
        let pavement = |rings| NamedArea { name: String::new(), rings };
        let runway = RunwayShape {
            designators: ["10".into(), "28".into()],
            ends: [[0.0, 0.0], [3000.0, 100.0]],
            width_m: 60.0,
        };
        let map = AirportMap {
            runways: vec![runway],
            pavements: vec![
                pavement(vec![square(100.0), closed.clone()]),
                pavement(vec![backwards(square(100.0)), backwards(closed)]),
            ],
            ..AirportMap::default()
        };
        let frame = LocalFrame::at(Geodetic::from_degrees(47.46, 8.55, 432.0));
        let database = rusqlite::Connection::open_in_memory().expect("a database");
        let run = Run { database, facts: BTreeMap::new(), map, frame, start_utc_ns: 0 };
        let features = features(&run);
        assert_eq!(features.len(), 3);
        let mut areas = Vec::new();
        for feature in &features {
            let rings = feature["geometry"]["coordinates"].as_array().expect("rings");
            for (number, ring) in rings.iter().enumerate() {
                let ring: Vec<[f64; 2]> = serde_json::from_value(ring.clone()).expect("a ring");
                assert_eq!((ring.first(), ring.len()), (ring.last(), 5), "{feature}");
                areas.push(signed_area(&ring[..4]));
                assert_eq!(signed_area(&ring[..4]) > 0.0, number == 0, "{feature}");
            }
        }
        assert!(areas.iter().any(|a| *a < 0.0));
        assert_eq!(features[2]["properties"]["name"], "10/28");
        // 180 000 m² of runway: degrees of latitude are 111 194 m, of longitude 75 300 m here.
        let square_metres = 0.5 * areas[4] * 111_180.0 * 75_300.0;
        assert!((square_metres / 180_090.0 - 1.0).abs() < 0.02, "{square_metres}");
        let mut text = String::new();
        kml(&run, &mut text);
        assert_eq!(text.matches("<Placemark>").count(), 3);
        assert_eq!(text.matches("<innerBoundaryIs>").count(), 2);
    }
}
