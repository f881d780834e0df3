//! `seeds traffic import TABLE`: recorded movements of a scene out of somebody's table.

use crate::runtime::cli::{BAD_INPUT, FAILED, fail, out};
use clap::Args;
use scenarios::movements::import::{Imported, import};
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
        Some(file) => match write(one, file) {
            Ok(()) => ExitCode::SUCCESS,
            Err(code) => code,
        },
    }
}

fn many(found: &[Imported], folder: &Path) -> ExitCode {
    if let Err(error) = std::fs::create_dir_all(folder) {
        return fail(FAILED, format!("{}: {error}", folder.display()));
    }
    for movement in found {
        // A call sign may hold anything; a name of a file may not.
        let sound = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let name: String = movement.callsign.chars().take(40).map(sound).collect();
        if let Err(code) = write(movement, &folder.join(format!("{name}.csv"))) {
            return code;
        }
    }
    ExitCode::SUCCESS
}

/// Writes a movement, and says what a scene would say of it.
fn write(movement: &Imported, file: &Path) -> Result<(), ExitCode> {
    if file.exists() {
        return Err(fail(BAD_INPUT, format!("{} is there: name another file", file.display())));
    }
    if let Err(error) = std::fs::write(file, &movement.csv) {
        return Err(fail(FAILED, format!("{}: {error}", file.display())));
    }
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
        "[[traffic]]\nkind = \"recorded\"\ncallsign = {}\ntype = {}{remark}\nfile = {}\nstart_s = 0\n",
        text(callsign),
        text(kind),
        text(&file.display().to_string())
    );
    Ok(())
}
