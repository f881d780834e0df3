//! Types of aircraft and vehicles: `types.csv` (kinematics, sizes) and `echo.csv` (height, echo).

use crate::error::{Problem, ScenarioError};
use crate::shapes::ShapeSet;
use models::flight_list::WakeCategory;
use models::sensors::TargetClass;
use models::sensors::radar::shape::Shape;
use models::truth::Kinematics;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// One type.
#[derive(Clone, Debug, PartialEq)]
pub struct TypeRow {
    /// Size and echo.
    pub class: TargetClass,
    /// Name for people.
    pub name: String,
    /// Wake turbulence category; none for vehicles.
    pub wake: Option<WakeCategory>,
    /// Take-off run, m, where the table has it.
    pub takeoff_dist_m: Option<f64>,
    /// Speeds and accelerations.
    pub kinematics: Kinematics,
}

/// All types by designator, and the shapes of the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TypeTable(BTreeMap<String, TypeRow>, ShapeSet);

impl TypeTable {
    /// The shapes that its types are made of.
    #[must_use]
    pub fn shapes(&self) -> &ShapeSet {
        &self.1
    }

    /// The type of this designator.
    #[must_use]
    pub fn get(&self, designator: &str) -> Option<&TypeRow> {
        self.0.get(designator)
    }

    /// All designators, sorted.
    pub fn designators(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }
}

/// The types that come with SEEDS: the table inside the executable.
///
/// # Errors
/// If the table cannot be found or is damaged.
pub fn shipped() -> Result<TypeTable, ScenarioError> {
    use crate::files::shipped;
    read(&shipped("types.csv"), &shipped("echo.csv"), crate::shapes::shipped()?)
}

/// Reads `types.csv` and `echo.csv`.
pub(crate) fn read(
    types: &Path,
    echo: &Path,
    shapes: ShapeSet,
) -> Result<TypeTable, ScenarioError> {
    let mut echoes = BTreeMap::new();
    for row in Rows::read(echo)?.rows {
        echoes.insert(
            row.text("designator")?.to_owned(),
            (row.need("height_m")?, row.need("rcs_m2")?, row.shape(&shapes)?),
        );
    }
    let mut table = TypeTable(BTreeMap::new(), shapes);
    for row in Rows::read(types)?.rows {
        let designator = row.text("designator")?.to_owned();
        let aircraft = row.text("kind")? == "aircraft";
        let wake_letter = row.text("wake")?;
        let wake = WakeCategory::of(wake_letter);
        let of_kind = if aircraft { format!("*{wake_letter}") } else { "*vehicle".into() };
        let (height_m, rcs_m2, shape) =
            echoes.get(&designator).or_else(|| echoes.get(&of_kind)).cloned().ok_or_else(|| {
                let needed = "a wake category L, M, H or J, or a row in echo.csv";
                row.damaged("wake", wake_letter, needed)
            })?;
        let length_m = row.need("length_m")?;
        let class = TargetClass {
            designator: designator.clone(),
            aircraft,
            length_m,
            span_m: row.need("span_m")?,
            height_m,
            rcs_m2,
            shape: shape.unwrap_or_else(|| table.1.usual(aircraft, length_m)),
        };
        let kinematics = Kinematics {
            liftoff_mps: row.number("liftoff_ms")?,
            takeoff_acc_ms2: row.number("takeoff_acc_ms2")?,
            touchdown_mps: row.number("touchdown_ms")?,
            braking_ms2: row.number("braking_acc_ms2")?.map(f64::abs),
            taxi_straight_mps: row.need("taxi_straight_max_ms")?,
            taxi_turn_mps: row.need("taxi_turn90_max_ms")?,
            taxi_acc_ms2: row.need("taxi_acc_ms2")?,
            taxi_dec_ms2: row.need("taxi_dec_ms2")?,
        };
        let name = row.text("name")?.to_owned();
        let takeoff_dist_m = row.number("takeoff_dist_m")?.filter(|m| *m > 0.0);
        table.0.insert(designator, TypeRow { class, name, wake, takeoff_dist_m, kinematics });
    }
    Ok(table)
}

/// A table with named columns and comment lines (`#`).
struct Rows {
    rows: Vec<Row>,
}

struct Row {
    file: std::path::PathBuf,
    line: usize,
    cells: BTreeMap<String, String>,
}

impl Rows {
    fn read(file: &Path) -> Result<Self, ScenarioError> {
        let damaged = |line: usize, found: String| {
            let problem = Problem::Line { found, needed: "a comma-separated table with a header" };
            ScenarioError::new(file, line, "table", problem)
        };
        let octets = crate::files::read_table(file, crate::LARGEST_DATA)
            .map_err(|error| damaged(1, error.to_string()))?;
        let mut reader =
            csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(octets.as_slice());
        let header = reader.headers().map_err(|error| damaged(1, error.to_string()))?.clone();
        let (mut rows, mut lines) = (Vec::new(), crate::files::Lines::new(&octets, true));
        for record in reader.records() {
            let record = record.map_err(|e| damaged(lines.of(e.position()), e.to_string()))?;
            let line = lines.of(record.position());
            let pairs = header.iter().zip(record.iter());
            let cells = pairs.map(|(key, cell)| (key.trim().into(), cell.trim().into())).collect();
            rows.push(Row { file: file.to_path_buf(), line, cells });
        }
        Ok(Self { rows })
    }
}

impl Row {
    fn text(&self, column: &'static str) -> Result<&str, ScenarioError> {
        let needed = || Problem::Missing { needed: "this column".into() };
        let missing = || ScenarioError::new(&self.file, 1, column, needed());
        self.cells.get(column).map(String::as_str).ok_or_else(missing)
    }

    /// The shape that the row names; a table without that column names none.
    fn shape(&self, shapes: &ShapeSet) -> Result<Option<Arc<Shape>>, ScenarioError> {
        let Some(name) = self.cells.get("shape").filter(|name| !name.is_empty()) else {
            return Ok(None);
        };
        let known = || shapes.names().collect::<Vec<_>>().join(", ");
        let unknown = || Problem::NotAllowed { found: name.clone(), allowed: known() };
        let found = shapes.get(name).cloned();
        found.map(Some).ok_or_else(|| ScenarioError::new(&self.file, self.line, "shape", unknown()))
    }

    fn number(&self, column: &'static str) -> Result<Option<f64>, ScenarioError> {
        let text = self.text(column)?;
        if text.is_empty() {
            return Ok(None);
        }
        let number = text.parse().ok().filter(|n: &f64| n.is_finite());
        number.map(Some).ok_or_else(|| self.damaged(column, text, "a number"))
    }

    fn need(&self, column: &'static str) -> Result<f64, ScenarioError> {
        self.number(column)?.filter(|n| *n > 0.0).ok_or_else(|| {
            self.damaged(column, self.text(column).unwrap_or(""), "a number above 0")
        })
    }

    fn damaged(&self, column: &str, found: &str, needed: &'static str) -> ScenarioError {
        let problem = Problem::Line { found: found.into(), needed };
        ScenarioError::new(&self.file, self.line, column, problem)
    }
}
