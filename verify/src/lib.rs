//! Reference vectors (`*.json` with `cases`, or `vectors`) run through the functions that the federates call.
//!
//! A file is known by its name; each known name has one check in [`radar`], [`effects`], [`gnss`], [`tracking`],
//! [`tracking_sets`], [`tracking_estimates`], [`traffic`], [`control`], [`wire`], [`datagrams`] or [`mode_s`]. A file of another name without either is input of other files and is passed over. `seeds verify DIR`
//! and the tests of this crate are the same code.

use serde_json::Value;
use std::path::{Path, PathBuf};

pub mod control;
pub mod datagrams;
pub mod effects;
pub mod gnss;
pub mod mode_s;
pub mod radar;
pub mod tracking;
pub mod tracking_estimates;
pub mod tracking_sets;
pub mod traffic;
pub mod wire;

/// One case of one file.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseResult {
    /// The case's name, or its number.
    pub name: String,
    /// Largest |error| / tolerance over its quantities; at most 1 passes. Infinite where a value is
    /// missing, of the wrong kind, NaN, or refused.
    pub worst: f64,
    /// The quantity that is `worst`, with found and expected value, for people.
    pub detail: String,
}

/// A check of one file: all its cases, in order.
pub type Check = fn(&Value) -> Vec<CaseResult>;

/// The check for a file name without its folder, or `None` if nothing here covers it.
#[must_use]
pub fn check_for(file_name: &str) -> Option<Check> {
    let stem = file_name.strip_suffix(".json")?;
    radar::check_for(stem)
        .or_else(|| effects::check_for(stem))
        .or_else(|| gnss::check_for(stem))
        .or_else(|| tracking::check_for(stem))
        .or_else(|| tracking_sets::check_for(stem))
        .or_else(|| traffic::check_for(stem))
        .or_else(|| control::check_for(stem))
        .or_else(|| tracking_estimates::check_for(stem))
        .or_else(|| wire::check_for(stem))
        .or_else(|| datagrams::check_for(stem))
        .or_else(|| mode_s::check_for(stem))
}

/// What one file gave.
#[derive(Clone, Debug)]
pub struct FileReport {
    /// The file.
    pub path: PathBuf,
    /// Cases in order; empty where not covered.
    pub cases: Vec<CaseResult>,
    /// False if no check knows the file's name.
    pub covered: bool,
}

impl FileReport {
    /// Cases within tolerance.
    #[must_use]
    pub fn passed(&self) -> usize {
        self.cases.iter().filter(|c| c.worst <= 1.0).count()
    }
    /// Cases outside tolerance.
    #[must_use]
    pub fn failed(&self) -> usize {
        self.cases.len() - self.passed()
    }
    /// The case nearest to (or farthest beyond) its tolerance.
    #[must_use]
    pub fn worst(&self) -> Option<&CaseResult> {
        self.cases.iter().max_by(|a, b| a.worst.total_cmp(&b.worst))
    }
}

/// Why a folder or file could not be verified.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// Not readable.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Reason.
        source: std::io::Error,
    },
    /// Not JSON.
    #[error("{path}: not JSON: {source}", path = path.display())]
    Json {
        /// File.
        path: PathBuf,
        /// Reason, with line and column.
        source: serde_json::Error,
    },
    /// No `*.json` below the folder.
    #[error("{path}: no vector files (*.json) below this folder", path = path.display())]
    Empty {
        /// Folder.
        path: PathBuf,
    },
}

/// Runs every `*.json` with `cases` or `vectors` below `dir` (or the one file `dir`), sorted by path; one whose name a
/// check knows fails where it has no case.
///
/// # Errors
/// If the folder or a file cannot be read, is not JSON, or if there is no vector file at all.
pub fn run(dir: &Path) -> Result<Vec<FileReport>, VerifyError> {
    let mut files = Vec::new();
    collect(dir, &mut files)?;
    files.sort();
    let mut reports = Vec::new();
    for path in files {
        let text = std::fs::read_to_string(&path)
            .map_err(|source| VerifyError::Io { path: path.clone(), source })?;
        let mut document: Value = serde_json::from_str(&text)
            .map_err(|source| VerifyError::Json { path: path.clone(), source })?;
        add_parameter_sets(&path, &mut document);
        // Vectors of ways name an airport whose layout is looked for from here.
        if let Some(object) = document.as_object_mut() {
            object.entry("path").or_insert_with(|| path.to_string_lossy().into());
        }
        let list = |key| document.get(key).is_some_and(Value::is_array);
        let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let (cases, covered) = match check_for(&name) {
            // Where a check knows the name, cases are meant to be there.
            Some(check) => (some_of(check(&document)), true),
            None if !list("cases") && !list("vectors") => continue,
            None => (Vec::new(), false),
        };
        reports.push(FileReport { path, cases, covered });
    }
    if reports.is_empty() {
        return Err(VerifyError::Empty { path: dir.to_path_buf() });
    }
    Ok(reports)
}

/// The cases, or one that failed where there is none.
fn some_of(cases: Vec<CaseResult>) -> Vec<CaseResult> {
    if !cases.is_empty() {
        return cases;
    }
    let detail = "no case was found".to_owned();
    vec![CaseResult { name: "none".to_owned(), worst: f64::INFINITY, detail }]
}

/// Puts the `parameter_sets.json` of the same folder, which has no cases of its own, into the document.
fn add_parameter_sets(path: &Path, document: &mut Value) {
    let beside = path.with_file_name("parameter_sets.json");
    let sets = std::fs::read_to_string(beside).ok().and_then(|t| serde_json::from_str(&t).ok());
    if let (Some(sets), Some(object)) = (sets, document.as_object_mut()) {
        object.entry("parameter_sets").or_insert(sets);
    }
}

fn collect(path: &Path, files: &mut Vec<PathBuf>) -> Result<(), VerifyError> {
    let io = |source| VerifyError::Io { path: path.to_path_buf(), source };
    if path.is_file() {
        files.push(path.to_path_buf());
        return Ok(());
    }
    for entry in std::fs::read_dir(path).map_err(io)? {
        let entry = entry.map_err(io)?.path();
        if entry.is_dir() {
            collect(&entry, files)?;
        } else if entry.extension().is_some_and(|e| e == "json") {
            files.push(entry);
        }
    }
    Ok(())
}

/// Every case of the repository's copies passes; each file has the number of cases named with it.
#[cfg(test)]
pub(crate) fn assert_all_pass(files: &[(&str, usize)]) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/vectors");
    for &(file, cases) in files {
        let reports = run(&root.join(format!("{file}.json"))).expect(file);
        let [report] = &reports[..] else { panic!("{file}: one report") };
        let worst = report.worst().expect(file);
        let (ratio, name, detail) = (worst.worst, &worst.name, &worst.detail);
        println!("{file}: {} cases, worst {ratio:.3} of {name}: {detail}", report.cases.len());
        assert_eq!((report.covered, report.cases.len()), (true, cases), "{file}");
        assert_eq!(report.failed(), 0, "{file}: {:#?}", report.cases);
    }
}

/// Gathers the worst ratio of error to tolerance over the quantities of a case.
#[derive(Debug)]
pub struct Judge {
    worst: f64,
    detail: String,
}

impl Default for Judge {
    fn default() -> Self {
        Self { worst: 0.0, detail: String::new() }
    }
}

impl Judge {
    /// Compares one number: passes if `|found − expected| ≤ tolerance`.
    pub fn number(&mut self, quantity: &str, found: f64, expected: f64, tolerance: f64) {
        let error = (found - expected).abs();
        let ratio = if found == expected {
            0.0
        } else if error.is_finite() && tolerance > 0.0 {
            error / tolerance
        } else {
            f64::INFINITY
        };
        self.ratio(ratio, || format!("{quantity}: found {found:e}, expected {expected:e}"));
    }

    /// Records something that must hold exactly.
    pub fn holds(&mut self, quantity: &str, holds: bool) {
        self.ratio(if holds { 0.0 } else { f64::INFINITY }, || {
            format!("{quantity}: does not hold")
        });
    }

    /// Records a ratio of error to tolerance that the caller computed.
    pub fn ratio(&mut self, ratio: f64, detail: impl FnOnce() -> String) {
        let ratio = if ratio.is_nan() { f64::INFINITY } else { ratio };
        if ratio > self.worst || self.detail.is_empty() {
            self.worst = ratio;
            self.detail = detail();
        }
    }

    /// The case's result.
    #[must_use]
    pub fn case(self, name: impl Into<String>) -> CaseResult {
        CaseResult { name: name.into(), worst: self.worst, detail: self.detail }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file whose name is known and whose cases are not found is no success, and does not panic.
    #[test]
    fn a_known_file_without_a_case_fails() {
        let folder = std::env::temp_dir().join(format!("seeds-verify-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let of = |name: &str, text: &str| {
            let path = folder.join(name);
            std::fs::write(&path, text).expect("written");
            let found = run(&path).map(|reports| (reports[0].covered, reports[0].failed()));
            std::fs::remove_file(&path).expect("removed");
            found.ok()
        };
        for name in ["euler.json", "quantiser.json", "asterix-vectors.json"] {
            for text in [r#"{"cases": []}"#, r#"{"case": [{}]}"#, "{}", "[]", r#"{"cases": {}}"#] {
                assert_eq!(of(name, text), Some((true, 1)), "{name}: {text}");
            }
        }
        assert_eq!(of("unknown.json", r#"{"cases": []}"#), Some((false, 0)));
        assert_eq!(of("unknown.json", "{}"), None, "input of other files");
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn every_file_of_the_repository_passes() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/vectors");
        for report in run(&root).expect("read") {
            assert_eq!((report.covered, report.failed()), (true, 0), "{}", report.path.display());
        }
    }
}
