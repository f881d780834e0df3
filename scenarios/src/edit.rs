//! Changes to the text of a scene that leave everything else as it was written, comments and order too.

use std::fmt::Write as _;
use toml_edit::{DocumentMut, InlineTable, Item, TableLike, Value};

/// A mover along the ground network, to be written into a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NewRoute {
    /// Call sign; empty: the first free one of `ROUTE1`, `ROUTE2`, ….
    pub callsign: String,
    /// Type designator; empty: `A320`.
    pub designator: String,
    /// Stands and nodes in order.
    pub via: Vec<String>,
    /// When it sets off, s.
    pub start_s: f64,
    /// `arrival`, `departure` or `vehicle`; empty: nobody expects it.
    pub movement: String,
    /// Its runway; empty: none.
    pub runway: String,
    /// Its stand; empty: none.
    pub stand: String,
}

/// The text with a mover more, at its end. What of the route the scene cannot have is said by its reader, not here.
#[must_use]
pub fn add_route(text: &str, route: &NewRoute) -> String {
    let quoted = |text: &str| Value::from(text).to_string();
    let word = |text: &str, usual: &str| quoted(if text.is_empty() { usual } else { text });
    let free = (1..).map(|n| format!("ROUTE{n}")).find(|name| !text.contains(name.as_str()));
    let via: Vec<String> = route.via.iter().map(|name| quoted(name)).collect();
    let mut out = text.trim_end().to_owned();
    let _ = write!(
        out,
        "\n\n[[traffic]]                     # made on the page of `seeds scene author`\nkind = \"route\"\ncallsign = {}\ntype = {}\nvia = [{}]\nstart_s = {}\n",
        word(&route.callsign, &free.unwrap_or_default()),
        word(&route.designator, "A320"),
        via.join(", "),
        route.start_s,
    );
    if !route.movement.is_empty() {
        let mut flight = InlineTable::new();
        for (key, value) in
            [("movement", &route.movement), ("runway", &route.runway), ("stand", &route.stand)]
        {
            if !value.is_empty() {
                flight.insert(key, value.as_str().into());
            }
        }
        let _ = writeln!(out, "flight = {flight}");
    }
    out
}

/// The text with the site of a sensor at another place, m east and north of the reference point; its height stays.
///
/// # Errors
/// One sentence if the text is not TOML, or has no sensor of that name with a site.
pub fn move_sensor(text: &str, name: &str, [east_m, north_m]: [f64; 2]) -> Result<String, String> {
    let mut document: DocumentMut = text.parse().map_err(|e: toml_edit::TomlError| {
        format!("not TOML: {}", e.message().split_whitespace().collect::<Vec<_>>().join(" "))
    })?;
    let sensors = document.get_mut("sensor").and_then(Item::as_array_of_tables_mut);
    let sensors = sensors.ok_or("the scene has no [[sensor]]")?;
    let named = |t: &&mut toml_edit::Table| t.get("name").and_then(Item::as_str) == Some(name);
    let sensor = sensors.iter_mut().find(named);
    let sensor = sensor.ok_or_else(|| format!("there is no sensor '{name}'"))?;
    let site = sensor.get_mut("site").and_then(Item::as_table_like_mut);
    let site = site.ok_or_else(|| format!("the sensor '{name}' has no site"))?;
    for key in ["lat_deg", "lon_deg"] {
        site.remove(key);
    }
    for (key, metres) in [("east_m", east_m), ("north_m", north_m)] {
        set(site, key, (metres * 10.0).round() / 10.0);
    }
    Ok(document.to_string())
}

/// Puts a number in the place of another, with what stands round it.
fn set(table: &mut dyn TableLike, key: &str, number: f64) {
    let mut value = Value::from(number);
    match table.get_mut(key).and_then(Item::as_value_mut) {
        Some(old) => {
            *value.decor_mut() = old.decor().clone();
            *old = value;
        }
        None => {
            table.insert(key, Item::Value(value));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn a_sensor_moves_and_nothing_else_changes() {
        let path = crate::locate("asmgcs");
        let text = crate::text_of(&path).expect("the scene");
        let scene = crate::load_without_truth(&path).expect("sound");
        let radar = scene.sensors.iter().find(|s| s.asde.is_some()).expect("a radar");
        let moved = move_sensor(&text, &radar.name, [12.34, -7.0]).expect("moved");
        let again = crate::change::load_changed(&path, &moved, &[]).expect("still sound");
        let found = again.sensors.iter().find(|s| s.name == radar.name).expect("it");
        let (old_m, new_m) = (radar.site_m.expect("site"), found.site_m.expect("site"));
        assert_eq!((new_m.x, new_m.y, new_m.z), (12.3, -7.0, old_m.z));
        let (a, b): (Vec<&str>, Vec<&str>) = (text.lines().collect(), moved.lines().collect());
        assert_eq!(a.len(), b.len(), "comments and lines stay");
        assert_eq!(a.iter().zip(&b).filter(|(a, b)| a != b).count(), 1);
        // Once by metres, always by metres; a comment on the line stays.
        let plain =
            "[[sensor]]\nname = \"x\"\nsite = { east_m = 1, north_m = 2, height_m = 9 } # mast\n";
        assert_eq!(
            move_sensor(plain, "x", [3.0, 4.0]).as_deref(),
            Ok(
                "[[sensor]]\nname = \"x\"\nsite = { east_m = 3.0, north_m = 4.0, height_m = 9 } # mast\n"
            )
        );
        for (text, name, part) in [
            ("a = ", "x", "not TOML"),
            ("a = 1", "x", "no [[sensor]]"),
            (plain, "y", "no sensor 'y'"),
            ("[[sensor]]\nname = \"x\"\n", "x", "no site"),
        ] {
            let error = move_sensor(text, name, [0.0; 2]).expect_err(part);
            assert!(error.contains(part) && !error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn a_route_of_a_new_scene_is_read_and_raises_no_warning() {
        for airport in ["LZIB", "XSYN"] {
            let layout = crate::template::layout_of(airport).expect("it ships");
            let path = Path::new("scene.toml").to_path_buf();
            let wanted =
                crate::template::Wanted { layout, path: path.clone(), minutes: 5.0, per_h: 0.0 };
            let (text, scene) = crate::template::scene(&wanted).expect("a scene");
            let layout = &scene.airport.layout;
            let on_runway = layout.edges.iter().filter(|e| e.runway).map(|e| e.to);
            let mut done = 0;
            for end in on_runway.take(40) {
                let stand = layout.stands.iter().find(|s| {
                    s.node.is_some_and(|n| models::truth::route::shortest(layout, n, end).is_some())
                });
                let Some(stand) = stand else { continue };
                let number = layout.details.numbers.get(end).unwrap_or(&layout.nodes[end].name);
                let route = NewRoute {
                    via: vec![stand.name.clone(), format!("#{number}")],
                    start_s: 20.0,
                    movement: "departure".to_owned(),
                    runway: layout.runways[0].names[0].clone(),
                    stand: stand.name.clone(),
                    ..NewRoute::default()
                };
                let one = add_route(&text, &route);
                let two = add_route(&one, &NewRoute { start_s: 90.0, ..route });
                assert!(two.starts_with(text.trim_end()) && two.contains("ROUTE2"), "{two}");
                let (read, found) = crate::warnings::check(&path, &one).expect("sound");
                assert_eq!(found, [], "{airport}");
                assert!(read.traffic.entities.iter().any(|e| e.callsign.as_str() == "ROUTE1"));
                done += 1;
                break;
            }
            assert!(done > 0, "{airport}: no way to try");
        }
    }

    #[test]
    fn names_of_any_letters_stay_text() {
        let strange = NewRoute {
            callsign: "A\"]\n[run]".to_owned(),
            via: vec!["x\"".to_owned(), "\\".to_owned()],
            movement: "arrival".to_owned(),
            stand: "\" }".to_owned(),
            ..NewRoute::default()
        };
        let text = add_route("[run]\nseed = 1\n", &strange);
        let read: toml::Table = text.parse().expect("TOML");
        let row = &read["traffic"][0];
        assert_eq!(row["callsign"].as_str(), Some("A\"]\n[run]"));
        assert_eq!(row["via"][1].as_str(), Some("\\"));
        assert_eq!(row["flight"]["stand"].as_str(), Some("\" }"));
        assert_eq!(read["run"]["seed"].as_integer(), Some(1));
    }
}
