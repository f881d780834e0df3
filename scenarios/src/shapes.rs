//! Target shapes: the file that ships, and what a scene puts in their place.

use crate::document::{Section, within};
use crate::error::{Problem, ScenarioError};
use crate::keys::{self, words};
use models::sensors::radar::shape::{Fuselage, Scatterer, Shape, View};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// Name of the file that ships.
pub const FILE: &str = "target-shapes.toml";
/// Most shapes of a scene.
const MOST: usize = 500;
/// Octets of the largest file of shapes.
const LARGEST: u64 = 1 << 20;

/// Shapes by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShapeSet(BTreeMap<String, Arc<Shape>>);

impl ShapeSet {
    /// The shape of this name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Arc<Shape>> {
        self.0.get(name)
    }

    /// All names, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// The shape of a body of which only kind and length are known.
    #[must_use]
    pub fn usual(&self, aircraft: bool, length_m: f64) -> Arc<Shape> {
        let name = match (aircraft, length_m) {
            (true, l) if l < 15.0 => "light",
            (true, l) if l < 30.0 => "regional_prop",
            (true, l) if l < 52.0 => "narrow",
            (true, _) => "wide",
            (false, l) if l < 8.0 => "car",
            (false, _) => "truck",
        };
        self.get(name).cloned().unwrap_or_else(Shape::point)
    }

    /// Takes in the shapes of a section, each in place of one of the same name; what is noticed goes to
    /// `warnings`.
    fn add(&mut self, root: &Section, warnings: &mut Vec<String>) -> Result<(), ScenarioError> {
        let mut seen: BTreeMap<String, usize> = BTreeMap::new();
        for section in root.sections("shape", &words(keys::SHAPE))? {
            let shape = shape(&section)?;
            if let Some(first_line) = seen.insert(shape.name.clone(), section.line()) {
                let problem = Problem::Duplicate { found: shape.name, first_line };
                return Err(section.refuse("name", problem));
            }
            if let Some((db, degrees)) = shape.lopsided() {
                warnings.push(format!(
                    "{}:{}: shape \"{}\": left and right differ by {db:.1} dB at {degrees:.0} degrees \
                     from ahead",
                    section.file().display(),
                    section.line(),
                    shape.name
                ));
            }
            self.0.insert(shape.name.clone(), Arc::new(shape));
            if self.0.len() > MOST {
                let found = self.0.len() as f64;
                let problem =
                    Problem::OutOfRange { found, low: 1.0, high: MOST as f64, unit: "shapes" };
                return Err(section.refuse("name", problem));
            }
        }
        Ok(())
    }
}

fn file(path: &Path, set: &mut ShapeSet, warnings: &mut Vec<String>) -> Result<(), ScenarioError> {
    let text = crate::files::read_text(path, LARGEST).map_err(|error| {
        let problem = Problem::Unreadable { reason: error.to_string() };
        ScenarioError::new(path, 1, "shape", problem)
    })?;
    let root = Section::parse(path, &text)?;
    root.only(&["shape"])?;
    set.add(&root, warnings)
}

/// The shapes that ship.
///
/// # Errors
/// If the file inside the executable is damaged.
pub fn shipped() -> Result<ShapeSet, ScenarioError> {
    let mut set = ShapeSet::default();
    file(&crate::files::shipped(FILE), &mut set, &mut Vec::new())?;
    Ok(set)
}

/// The shape of this name among those that ship; a point where it is none of them.
#[must_use]
pub fn named(name: &str) -> Arc<Shape> {
    static SHIPPED: OnceLock<ShapeSet> = OnceLock::new();
    let set = SHIPPED.get_or_init(|| shipped().unwrap_or_default());
    set.get(name).cloned().unwrap_or_else(Shape::point)
}

/// The shapes of a scene: those that ship, those of `shapes = "FILE"`, those of `[[shape]]`, each in place
/// of one of the same name; the files read, and what was noticed.
pub(crate) fn read(root: &Section) -> Result<(ShapeSet, Vec<PathBuf>, Vec<String>), ScenarioError> {
    let (mut set, mut warnings) = (shipped()?, Vec::new());
    let mut files = Vec::new();
    if let Some(path) = root.file_path("shapes")? {
        file(&path, &mut set, &mut warnings)?;
        files.push(path);
    }
    set.add(root, &mut warnings)?;
    Ok((set, files, warnings))
}

fn shape(section: &Section) -> Result<Shape, ScenarioError> {
    let any = within(-1e9, 1e9, "");
    let pair = |key: &str, names: [&str; 2]| -> Result<(f64, f64), ScenarioError> {
        let inner = section.section(key, &names)?;
        let needed = || section.missing(key, format!("{{ {} = .., {} = .. }}", names[0], names[1]));
        let inner = inner.ok_or_else(needed)?;
        Ok((inner.need_number(names[0], any)?, inner.need_number(names[1], any)?))
    };
    let mut scatterers = Vec::new();
    for (row, line) in section.rows("scatterers")? {
        let view = match row[..] {
            [_, _, _] => View::All,
            [_, _, _, from_deg, half_width_deg] => View::Sector { from_deg, half_width_deg },
            _ => {
                let found = format!("{} numbers", row.len());
                let needed = "x, y, share, or x, y, share, from_deg, half_width_deg".to_owned();
                let problem = Problem::WrongKind { found, needed };
                return Err(ScenarioError::new(section.file(), line, "scatterers", problem));
            }
        };
        scatterers.push(Scatterer { x: row[0], y: row[1], weight: row[2], view });
    }
    let flash = section.section("flash", &words(keys::FLASH))?;
    let fuselage = match flash {
        None => None,
        Some(flash) => Some(Fuselage {
            radius: section.need_number("fuselage_radius", any)?,
            behind: section.need_number("behind_fuselage", any)?,
            base: flash.need_number("base", any)?,
            peak: flash.need_number("peak", any)?,
            width_deg: flash.need_number("width_deg", any)?,
            points: flash.numbers("points", any)?,
        }),
    };
    let shape = Shape {
        name: section.need_text("name", "a name of the shape")?.to_owned(),
        size_m: (section.need_number("length_m", any)?, section.need_number("span_m", any)?),
        rcs_m2: section.need_number("rcs_m2", any)?,
        scatterers,
        fuselage,
        limits_db: pair("limits_db", ["below", "above"])?,
        source: section.need_text("source", "where the shape comes from")?.to_owned(),
    };
    shape.validate().map_err(|(key, found)| {
        section.refuse(key, Problem::Line { found, needed: "a sound shape" })
    })?;
    Ok(shape)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shapes_that_ship_are_sound_and_have_their_sources() {
        let set = shipped().unwrap_or_else(|e| panic!("{e}"));
        let names: Vec<&str> = set.names().collect();
        assert_eq!(names.len(), 10, "{names:?}");
        for name in names {
            let shape = set.get(name).expect("listed");
            assert!(!shape.source.is_empty() && shape.is_symmetric() && shape.lopsided().is_none());
        }
        let (light, large) = (named("light"), named("super"));
        assert_ne!(light.scatterers, large.scatterers);
        assert_eq!(named("no such shape").name, "point");
    }

    #[test]
    fn a_shape_outside_its_bounds_is_refused_with_line_and_key() {
        let text = |rows: &str, above: &str| {
            format!(
                "[[shape]]\nname = \"box\"\nlength_m = 5\nspan_m = 2\nrcs_m2 = 3\nsource = \"test\"\n\
                 limits_db = {{ below = 1, above = {above} }}\nscatterers = [{rows}]\n"
            )
        };
        let read = |text: &str| {
            let root = Section::parse(Path::new("scene.toml"), text).expect("TOML");
            let mut warnings = Vec::new();
            let mut set = ShapeSet::default();
            set.add(&root, &mut warnings).map(|()| (set, warnings)).map_err(|e| e.to_string())
        };
        let sound = read(&text("[0, 0, 1.0]", "1")).expect("sound");
        assert!(sound.0.get("box").is_some() && sound.1.is_empty());
        for (rows, above, said) in [
            ("[0.6, 0, 1.0]", "1", "scatterers: found \"row 1: 0.6 is not within -0.5 to 0.5\""),
            ("[0, 0, 0]", "1", "row 1: 0 is not within"),
            ("[0, 0, 1.0, 0, 5]", "1", "row 1: 5 is not within 10 to 180"),
            ("[0, 0, 1.0, 0]", "1", "4 numbers"),
            ("[0, 0, 1.0, 0, 90]", "1", "at 28.0 degrees from ahead: -1.08 dB, beyond 1 below"),
            ("[0, 0, 1.0], [0, 0, 0.9]", "1", "beyond 1 below and 1 above"),
            ("", "1", "0 rows"),
        ] {
            let error = read(&text(rows, above)).expect_err(rows);
            assert!(error.contains(said) && error.starts_with("scene.toml:"), "{rows}: {error}");
        }
        let lopsided =
            read(&text("[0, 0, 0.5], [0, 0.4, 0.5, 90, 90]", "1")).expect_err("too weak");
        assert!(lopsided.contains("below"), "{lopsided}");
        let warned = read(&text("[0, 0, 1.0], [0, 0.4, 0.5, 90, 90]", "2")).expect("sound");
        assert!(warned.1[0].contains("left and right differ by 1.8 dB"), "{:?}", warned.1);
    }
}
