//! Candidate sites for one sensor, out of a table.

use models::frames::{Point2, Point3};
use scenarios::Scene;
use std::collections::BTreeMap;

/// Name of the row of the site that the scene has.
pub const PRESENT: &str = "present site";
/// Most candidates of a table.
const MOST: usize = 1000;
/// Heights of an antenna over the ground, m: as for the key `antenna_height_m`.
const HEIGHTS_M: (f64, f64) = (1.0, 500.0);
const COLUMNS: [&str; 6] = ["name", "lat_deg", "lon_deg", "east_m", "north_m", "height_m"];

/// A site that a sensor could have.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Its name.
    pub name: String,
    /// East, north and height of the antenna over the ground, m.
    pub site_m: Point3<f64>,
    /// Whether it is the site that the scene has.
    pub present: bool,
}

/// The table: comma-separated, columns named in its first line, lines beginning with `#` left out.
/// Without a column (or value) of heights the antenna is as high as it is at `present_height_m`.
///
/// # Errors
/// `FILE:LINE: what; what to do`, of the first line that is wrong.
pub fn read(
    file: &str,
    text: &str,
    scene: &Scene,
    present_height_m: f64,
) -> Result<Vec<Candidate>, String> {
    let mut rows = (1..)
        .zip(text.trim_start_matches('\u{feff}').lines())
        .filter(|(_, row)| !row.trim().is_empty() && !row.trim_start().starts_with('#'));
    let Some((line, head)) = rows.next() else {
        return Err(format!(
            "{file}: no lines; write the header name,east_m,north_m,height_m and a line for each candidate"
        ));
    };
    let columns = header(head).map_err(|e| format!("{file}:{line}: {e}"))?;
    let mut found: Vec<Candidate> = Vec::new();
    let mut lines: BTreeMap<String, usize> = BTreeMap::new();
    for (line, row) in rows {
        let said = |e: String| format!("{file}:{line}: {e}");
        let candidate = candidate(row, &columns, scene, present_height_m).map_err(said)?;
        if let Some(first) = lines.insert(candidate.name.clone(), line) {
            let name = &candidate.name;
            return Err(said(format!("'{name}' is line {first}'s name, too; give it another one")));
        }
        if found.len() == MOST {
            return Err(said(format!("more than {MOST} candidates; split the table")));
        }
        found.push(candidate);
    }
    if found.is_empty() {
        return Err(format!("{file}: no lines below the header; write one for each candidate"));
    }
    Ok(found)
}

/// Fields of a line; one in double quotes may hold commas, and double quotes that are written twice.
fn fields(row: &str) -> Result<Vec<String>, String> {
    let (mut all, mut field, mut quoted) = (Vec::new(), String::new(), false);
    let mut signs = row.chars().peekable();
    while let Some(c) = signs.next() {
        match c {
            '"' if quoted && signs.next_if_eq(&'"').is_some() => field.push('"'),
            '"' => quoted = !quoted,
            ',' if !quoted => all.push(std::mem::take(&mut field).trim().to_owned()),
            _ => field.push(c),
        }
    }
    all.push(field.trim().to_owned());
    if quoted { Err("a double quote is not closed; close or remove it".into()) } else { Ok(all) }
}

fn header(row: &str) -> Result<Vec<&'static str>, String> {
    let mut columns = Vec::new();
    for word in fields(row)? {
        let Some(column) = COLUMNS.into_iter().find(|c| *c == word) else {
            return Err(format!(
                "column '{word}' is unknown; the first line names columns, comma-separated: name, \
                 lat_deg and lon_deg or east_m and north_m, and height_m if wanted"
            ));
        };
        if columns.contains(&column) {
            return Err(format!("column '{word}' is there twice; remove one"));
        }
        columns.push(column);
    }
    let has = |word: &str| columns.contains(&word);
    let (degrees, metres) = (["lat_deg", "lon_deg"].map(has), ["east_m", "north_m"].map(has));
    if !has("name") {
        return Err("no column name; add it".into());
    }
    if degrees.contains(&true) && metres.contains(&true) {
        return Err("two places; keep either lat_deg and lon_deg or east_m and north_m".into());
    }
    if degrees != [true; 2] && metres != [true; 2] {
        return Err("no place; add the columns lat_deg and lon_deg, or east_m and north_m".into());
    }
    Ok(columns)
}

fn candidate(
    row: &str,
    columns: &[&'static str],
    scene: &Scene,
    present_height_m: f64,
) -> Result<Candidate, String> {
    let values = fields(row)?;
    if values.len() != columns.len() {
        return Err(format!(
            "{} values for {} columns; write a value for each of {}",
            values.len(),
            columns.len(),
            columns.join(",")
        ));
    }
    let text = |column: &str| {
        columns.iter().position(|c| *c == column).map(|i| &*values[i]).filter(|v| !v.is_empty())
    };
    let number = |column: &str, (low, high): (f64, f64)| -> Result<f64, String> {
        let said = text(column).unwrap_or("");
        match said.parse::<f64>() {
            Ok(value) if (low..=high).contains(&value) => Ok(value),
            Ok(_) => Err(format!("{column} {said} is outside {low} to {high}; correct it")),
            Err(_) => Err(format!("{column} '{said}' is not a number; write one, {low} to {high}")),
        }
    };
    let name = text("name").ok_or("no name; give the candidate one")?.to_owned();
    if name == PRESENT {
        return Err(format!("'{PRESENT}' is the name of the scene's own site; take another one"));
    }
    let place: Point2<f64> = if columns.contains(&"lat_deg") {
        let (lat, lon) = (number("lat_deg", (-90.0, 90.0))?, number("lon_deg", (-180.0, 180.0))?);
        scene.airport.local_m(lat, lon)
    } else {
        Point2::new(number("east_m", (-1e6, 1e6))?, number("north_m", (-1e6, 1e6))?)
    };
    let (away_m, limit_m) = (place.coords.norm(), scene.airport.radius_m);
    if away_m > limit_m {
        return Err(format!(
            "'{name}' is {away_m:.0} m from the reference point, outside the airport ({limit_m:.0} m); \
             correct its place or raise radius_m of [airport]"
        ));
    }
    let height_m = match text("height_m") {
        Some(_) => number("height_m", HEIGHTS_M)?,
        None => present_height_m,
    };
    let inside = scene.buildings.iter().find(|b| b.contains(place) && b.height_m >= height_m);
    if let Some(building) = inside {
        return Err(format!(
            "'{name}' is an antenna at {height_m} m inside \"{}\"; raise it above the roof at {} m, or \
             take another place",
            building.name, building.height_m
        ));
    }
    Ok(Candidate { name, site_m: Point3::new(place.x, place.y, height_m), present: false })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_of(text: &str) -> Result<Vec<Candidate>, String> {
        let mut scene = scenarios::load_without_truth(&scenarios::locate("xsyn"))
            .unwrap_or_else(|e| panic!("{e}"));
        let corner = |x: f64, y: f64| Point2::new(x, y);
        scene.buildings.push(models::sensors::radar::shadow::Building {
            name: "hall".into(),
            footprint_m: vec![
                corner(10.0, 10.0),
                corner(50.0, 10.0),
                corner(50.0, 50.0),
                corner(10.0, 50.0),
            ],
            height_m: 20.0,
            facade: models::environment::surface::Material::named("concrete").expect("it"),
        });
        read("c.csv", text, &scene, 60.0)
    }

    #[test]
    fn tables_in_metres_and_degrees_are_read() {
        let found = read_of(
            "\u{feff}# sites\r\nheight_m,name,east_m,north_m\r\n20,\"mast, west\",-300,40.5\r\n\r\n,roof,30,30\r\n",
        );
        let found = found.expect("a good table");
        assert_eq!(found.len(), 2);
        assert_eq!(found[0].name, "mast, west");
        assert_eq!(found[0].site_m, Point3::new(-300.0, 40.5, 20.0));
        // No height: as high as the present antenna, above the roof.
        assert_eq!(found[1].site_m, Point3::new(30.0, 30.0, 60.0));
        // A quote in quotes is written twice.
        let found = read_of("name,east_m,north_m\n\"say \"\"west\"\", or\",1,2\n").expect("it");
        assert_eq!(found[0].name, "say \"west\", or");
        // The scene's own radar, in degrees: where the scene has it.
        let scene = scenarios::load_without_truth(&scenarios::locate("xsyn")).expect("a scene");
        let site = scene.sensors[0].site_m.expect("a site");
        let found =
            read_of("name,lat_deg,lon_deg\nsame,44.99532087,9.99619515\n").expect("a table");
        assert!((found[0].site_m.xy() - site.xy()).norm() < 1e-6);
    }

    #[test]
    fn each_wrong_table_is_refused_with_its_line_and_what_to_do() {
        let head = "name,east_m,north_m,height_m\n";
        let lines = |rows: &str| format!("{head}{rows}");
        for (text, place, what, remedy) in [
            (String::new(), "c.csv: ", "no lines", "write the header"),
            (head.to_owned(), "c.csv: ", "no lines below", "write one"),
            (
                "name,x,y\na,1,2\n".into(),
                "c.csv:1: ",
                "column 'x' is unknown",
                "east_m and north_m",
            ),
            ("name,east_m,east_m,north_m\n".into(), "c.csv:1: ", "twice", "remove"),
            ("east_m,north_m\n1,2\n".into(), "c.csv:1: ", "no column name", "add"),
            ("name,east_m\na,1\n".into(), "c.csv:1: ", "no place", "add"),
            ("name,east_m,north_m,lat_deg,lon_deg\n".into(), "c.csv:1: ", "two places", "keep"),
            ("name,lat_deg,lon_deg\na,91,8\n".into(), "c.csv:2: ", "lat_deg 91", "correct"),
            (lines("a,1,2\n"), "c.csv:2: ", "3 values for 4 columns", "write a value"),
            (lines("a,1,2,20\n,3,4,20\n"), "c.csv:3: ", "no name", "give"),
            (lines("a,1,2,20\nb,3,4,20\na,5,6,20\n"), "c.csv:4: ", "line 2's name", "another"),
            (lines("present site,1,2,20\n"), "c.csv:2: ", "scene's own site", "another"),
            (lines("a,one,2,20\n"), "c.csv:2: ", "east_m 'one' is not a number", "write one"),
            (lines("a,NaN,2,20\n"), "c.csv:2: ", "east_m NaN is outside", "correct"),
            (lines("a,90000,2,20\n"), "c.csv:2: ", "outside the airport", "radius_m"),
            (lines("a,1,2,0.5\n"), "c.csv:2: ", "height_m 0.5 is outside 1 to 500", "correct"),
            (lines("a,1,2,501\n"), "c.csv:2: ", "height_m 501 is outside", "correct"),
            (lines("a,30,30,15\n"), "c.csv:2: ", "inside \"hall\"", "above the roof"),
            (lines("\"a,1,2,15\n"), "c.csv:2: ", "quote is not closed", "close"),
        ] {
            let error = read_of(&text).expect_err(&text);
            assert!(error.starts_with(place), "{text}: {error}");
            assert!(error.contains(what) && error.contains(remedy), "{text}: {error}");
        }
        let many: String = (0..=MOST).map(|i| format!("s{i},1,2,20\n")).collect();
        assert!(read_of(&lines(&many)).expect_err("too many").contains("split"));
    }
}
