//! `seeds traffic import TABLE`: recorded movements of a scene out of somebody's table.

use crate::runtime::cli::{BAD_INPUT, FAILED, fail, out};
use clap::Args;
use scenarios::movements::import::{Imported, import};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Movements out of somebody's table (CSV: time, call sign, place; many names and forms of columns are known), one file each
#[derive(Args, Clone, Debug)]
pub struct ImportArgs {
    /// The table
    #[arg(value_name = "TABLE")]
    table: PathBuf,

    /// Only this call sign; may be said several times. Of a table without call signs: whose movement it is
    #[arg(long = "callsign", value_name = "CALLSIGN")]
    callsigns: Vec<String>,

    /// File to write, or folder for one file a call sign [default: standard output, of one movement]
    #[arg(short, long, value_name = "FILE|DIR")]
    out: Option<PathBuf>,
}

/// Imports and tells what was left out.
#[must_use]
pub fn run(args: &ImportArgs) -> ExitCode {
    let found = match import(&args.table, &args.callsigns) {
        Ok(found) => found,
        Err(error) => return fail(BAD_INPUT, error),
    };
    let [one] = &found[..] else {
        return match &args.out {
            Some(folder) if !folder.is_file() => many(&found, folder),
            _ => {
                let names: Vec<&str> = found.iter().take(12).map(|m| &*m.callsign).collect();
                let text = format!(
                    "{} holds {} movements ({}{}): name one with --callsign, or a folder with --out",
                    args.table.display(),
                    found.len(),
                    names.join(", "),
                    if found.len() > names.len() { ", …" } else { "" }
                );
                fail(BAD_INPUT, text)
            }
        };
    };
    match &args.out {
        None => {
            out!("{}", one.csv.trim_end());
            ExitCode::SUCCESS
        }
        Some(folder) if folder.is_dir() || folder.extension().is_none() => many(&found, folder),
        Some(file) => all(&[(one, file.clone())]),
    }
}

fn many(found: &[Imported], folder: &Path) -> ExitCode {
    if let Err(error) = std::fs::create_dir_all(folder) {
        return fail(FAILED, format!("{}: {error}", folder.display()));
    }
    let names = names(found.iter().map(|m| &*m.callsign));
    let files: Vec<(&Imported, PathBuf)> =
        found.iter().zip(names).map(|(m, name)| (m, folder.join(name))).collect();
    all(&files)
}

/// Names of files for call signs, each another one. A call sign may hold anything; a name of a file may not, and some know no capitals.
fn names<'a>(callsigns: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut given = BTreeSet::new();
    let sound = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    callsigns
        .map(|callsign| {
            let stem: String = callsign.chars().take(40).map(sound).collect();
            let mut name = stem.clone();
            let mut n = 1;
            while !given.insert(name.to_ascii_lowercase()) {
                n += 1;
                name = format!("{stem}_{n}");
            }
            name + ".csv"
        })
        .collect()
}

/// Writes movements, and says what a scene would say of them: all or, where a file of theirs is there, none.
fn all(files: &[(&Imported, PathBuf)]) -> ExitCode {
    if let Some((_, there)) = files.iter().find(|(_, file)| file.exists()) {
        let text = format!("{} is there: nothing is written; name another place", there.display());
        return fail(BAD_INPUT, text);
    }
    // The earliest of them begins with the run, the others as much later as they did.
    let earliest_s = files.iter().map(|(m, _)| m.first_s).fold(f64::INFINITY, f64::min);
    for (movement, file) in files {
        if let Err(error) = std::fs::write(file, &movement.csv) {
            return fail(FAILED, format!("{}: {error}", file.display()));
        }
        tell(movement, file, movement.first_s - earliest_s);
    }
    ExitCode::SUCCESS
}

/// What a scene would say of a movement.
fn tell(movement: &Imported, file: &Path, start_s: f64) {
    let Imported { callsign, designator, records, damaged, lasts_s, .. } = movement;
    let left =
        damaged.iter().map(|(why, n, line)| format!("; {n} with {why} left out (line {line})"));
    out!("# {records} records, {lasts_s:.0} s{}", left.collect::<String>());
    let text = |text: &str| serde_json::Value::from(text).to_string(); // a JSON text is a TOML text
    let (kind, remark) = match designator {
        Some(designator) => (designator.as_str(), ""),
        None => ("A320", "  # assumed: the table does not say it"),
    };
    out!(
        "[[traffic]]\nkind = \"recorded\"\ncallsign = {}\ntype = {}{remark}\nfile = {}\nstart_s = {}\n",
        text(callsign),
        text(kind),
        text(&file.display().to_string()),
        to_ms(start_s)
    );
}

/// A time to the millisecond, as short as it can be written.
fn to_ms(time_s: f64) -> f64 {
    (1e3 * time_s).round() / 1e3
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_start_is_written_to_the_millisecond() {
        for ms in 0..20_000_u32 {
            // As the difference of two times of a day.
            let start_s = 40_000.0 + f64::from(ms) * 1e-3 - 40_000.0;
            let text = format!("{}", super::to_ms(start_s));
            let decimals = text.split_once('.').map_or(0, |(_, d)| d.len());
            assert!(decimals <= 3, "{text}");
            assert_eq!(text.parse::<f64>().map(|s| (1e3 * s).round()), Ok(f64::from(ms)), "{text}");
        }
    }

    #[test]
    fn each_call_sign_has_a_file_of_its_own() {
        let found = super::names(["A/1", "a_1", "A.1", "B", "Ä1"].into_iter());
        assert_eq!(found, ["A_1.csv", "a_1_2.csv", "A_1_3.csv", "B.csv", "_1.csv"]);
    }
}
