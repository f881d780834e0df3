//! Errors of scene and data files: always one line, `file:line: key: what was found, what is allowed`; a file that is
//! not there has no lines.

use std::path::{Path, PathBuf};

/// Why a scene, or a data file that it names, was refused.
#[derive(Debug, thiserror::Error)]
#[error("{}{problem}", place(file, *line, key))]
pub struct ScenarioError {
    /// The file with the fault.
    pub file: PathBuf,
    /// Line of the fault, from 1; 0 for the file as a whole.
    pub line: usize,
    /// Where in the document: `sensor[2].site.height_m`, or the column of a table.
    pub key: String,
    /// What is wrong, and what would be right.
    pub problem: Box<Problem>,
}

fn place(file: &Path, line: usize, key: &str) -> String {
    match line {
        0 => format!("{key} {}: ", file.display()),
        line => format!("{}:{line}: {key}: ", file.display()),
    }
}

impl ScenarioError {
    /// An error at a line of a file.
    #[must_use]
    pub fn new(file: &Path, line: usize, key: impl Into<String>, problem: Problem) -> Self {
        Self { file: file.to_path_buf(), line, key: key.into(), problem: Box::new(problem) }
    }
}

/// The sentence of [`Problem::OutOfRange`]: limits that are none are not named.
fn out_of_range(found: f64, low: f64, high: f64, unit: &str) -> String {
    format!("found {found}, allowed is {}", limits(low, high, unit))
}

fn limits(low: f64, high: f64, unit: &str) -> String {
    let allowed = match (low.is_finite(), high.is_finite()) {
        (true, true) => format!("{low} to {high} {unit}"),
        (true, false) => format!("{low} {unit} or more"),
        (false, true) => format!("{high} {unit} or less"),
        (false, false) => format!("a number {unit}"),
    };
    allowed.trim_end().to_owned()
}

/// What is wrong with a value, and what is allowed in its place.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    /// Not TOML.
    #[error("not TOML: {message}")]
    Syntax {
        /// The parser's reason, on one line.
        message: String,
    },
    /// A key that nothing reads.
    #[error("unknown key{}; allowed here: {allowed}", nearest.as_ref().map_or(String::new(), |n| format!(", did you mean `{n}`?")))]
    UnknownKey {
        /// The allowed key that looks most like it.
        nearest: Option<String>,
        /// All allowed keys.
        allowed: String,
    },
    /// A key that has to be there.
    #[error("missing; needed is {needed}")]
    Missing {
        /// What has to be given.
        needed: String,
    },
    /// A value of the wrong kind (also: a number with its unit in a text).
    #[error("found {}, needed is {needed}", brief(found))]
    WrongKind {
        /// The value as read.
        found: String,
        /// What has to be given, with its unit.
        needed: String,
    },
    /// A number outside its limits.
    #[error("{}", out_of_range(*found, *low, *high, unit))]
    OutOfRange {
        /// The value.
        found: f64,
        /// Smallest allowed value.
        low: f64,
        /// Largest allowed value.
        high: f64,
        /// Unit of all three.
        unit: &'static str,
    },
    /// A word that is none of the allowed ones.
    #[error("found \"{}\", allowed is {}", brief(found), if allowed.is_empty() { "nothing here" } else { allowed })]
    NotAllowed {
        /// The word.
        found: String,
        /// The allowed words.
        allowed: String,
    },
    /// A key that was read once.
    #[error("is no longer read; {instead}")]
    Replaced {
        /// What takes its place.
        instead: &'static str,
    },
    /// A footprint whose walls cross.
    #[error(
        "the wall from corner {first} crosses the one from corner {second}; needed are corners in \
         order round the building"
    )]
    Crossing {
        /// First corner of one wall, from 1.
        first: usize,
        /// First corner of the other.
        second: usize,
    },
    /// A name that has to be unique, a second time.
    #[error("\"{found}\" is there a second time; first in line {first_line}; names must differ")]
    Duplicate {
        /// The name.
        found: String,
        /// Where it was first.
        first_line: usize,
    },
    /// A file that cannot be read.
    #[error("file {path}: {reason}; paths count from the folder of the scene file", path = path.display())]
    File {
        /// The file as looked for.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// The file itself cannot be read, or is not text.
    #[error("{reason}")]
    Unreadable {
        /// Why not.
        reason: String,
    },
    /// A place away from the airport.
    #[error(
        "{distance_m:.0} m from the aerodrome reference point, allowed is at most {limit_m:.0} m (airport.radius_m)"
    )]
    OutsideAirport {
        /// Distance, m.
        distance_m: f64,
        /// Limit, m.
        limit_m: f64,
    },
    /// Times in the wrong order, or outside the run.
    #[error("found {found} s, needed is {needed}")]
    Order {
        /// The time, s.
        found: f64,
        /// What would be right.
        needed: &'static str,
    },
    /// A route that the ground network does not have.
    #[error("no way from \"{from}\" to \"{to}\" along the ground network; choose connected nodes")]
    NoRoute {
        /// Start.
        from: String,
        /// End.
        to: String,
    },
    /// Two names of a route of which the second is not reached from the first.
    #[error(
        "no way from \"{from}\" to \"{to}\" but over others that have a name; {}",
        match connected.split_first() {
            None => format!("nothing that has a name meets \"{from}\""),
            Some((nearest, [])) => format!("\"{nearest}\" meets \"{from}\""),
            Some((nearest, rest)) =>
                format!("\"{nearest}\" meets \"{from}\" nearest to it, and so do {}", rest.join(", ")),
        }
    )]
    Apart {
        /// The first.
        from: String,
        /// The second.
        to: String,
        /// What the first one meets, the nearest to the second one first.
        connected: Vec<String>,
    },
    /// A data file with a damaged line.
    #[error("found \"{}\", needed is {needed}", brief(found))]
    Line {
        /// What is there.
        found: String,
        /// What should be there.
        needed: &'static str,
    },
    /// A model refused the value.
    #[error("{0}")]
    Model(Box<dyn std::error::Error + Send + Sync>),
}

impl Problem {
    /// What stands there, where that is one value.
    #[must_use]
    pub fn found(&self) -> Option<String> {
        match self {
            Self::WrongKind { found, .. }
            | Self::NotAllowed { found, .. }
            | Self::Duplicate { found, .. }
            | Self::Line { found, .. } => Some(brief(found)),
            Self::OutOfRange { found, .. } | Self::Order { found, .. } => Some(found.to_string()),
            _ => None,
        }
    }

    /// What may stand there in its place, where that can be said.
    #[must_use]
    pub fn allowed(&self) -> Option<String> {
        match self {
            Self::UnknownKey { allowed, .. } | Self::NotAllowed { allowed, .. } => {
                Some(allowed.clone())
            }
            Self::Missing { needed } | Self::WrongKind { needed, .. } => Some(needed.clone()),
            Self::OutOfRange { low, high, unit, .. } => Some(limits(*low, *high, unit)),
            Self::Order { needed, .. } | Self::Line { needed, .. } => Some((*needed).to_owned()),
            Self::Apart { connected, .. } if !connected.is_empty() => Some(connected.join(", ")),
            _ => None,
        }
    }
}

/// What fits into one line of a message: a damaged file may have a megabyte in place of a word.
fn brief(found: &str) -> String {
    const MOST: usize = 80;
    let Some((cut, _)) = found.char_indices().nth(MOST) else { return found.to_owned() };
    format!("{}… ({} octets)", &found[..cut], found.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_not_there_has_no_line() {
        let missing = crate::load(Path::new("paris")).expect_err("there is none").to_string();
        assert!(missing.starts_with("scene paris: No such file"), "{missing}");
        assert!(missing.contains("zurich"), "{missing}");
        let named = crate::load(Path::new("no/paris.toml")).expect_err("none").to_string();
        assert!(named.contains("`seeds scene new AIRPORT -o FILE`"), "{named}");
    }
}
