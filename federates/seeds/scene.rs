//! `seeds scene`: make, check and describe scene files.

use crate::runtime::cli::out;
use crate::runtime::cli::{BAD_INPUT, FAILED, fail};
use clap::{Args, Subcommand};
use scenarios::warnings::Warning;
use scenarios::{ScenarioError, reference, template, warnings};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Make, check and describe scene files
#[derive(Args, Clone, Debug)]
pub struct SceneArgs {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Clone, Debug)]
enum Command {
    /// What is wrong with a scene, and what is legal but silly; `# seeds: allow W07` on a line silences a warning
    Check {
        /// Scene: a TOML file, or the name of a scene that comes with SEEDS
        #[arg(value_name = "FILE")]
        file: String,
        /// JSON: one object
        #[arg(long)]
        json: bool,
        /// End with 1 if there are warnings
        #[arg(long)]
        strict: bool,
    },
    /// JSON schema of scene files, for editors
    Schema,
    /// Reference of scene files, in Markdown
    Doc,
    Author(super::author::AuthorArgs),
    /// A scene of an airport that runs at once
    New {
        /// Airport that comes with SEEDS (EHAM), or its layout: apt.dat, .xml, nodes.csv, .json, .geojson
        #[arg(value_name = "AIRPORT")]
        airport: String,
        /// File to write [default: standard output]
        #[arg(short, long, value_name = "FILE")]
        out: Option<PathBuf>,
        /// Length of the run, min
        #[arg(long, value_name = "MIN", default_value_t = 20.0)]
        minutes: f64,
        /// Movements an hour, arrivals and departures
        #[arg(long, value_name = "N", default_value_t = 30.0)]
        movers: f64,
    },
}

/// Does what the command line says.
#[must_use]
pub fn run(args: &SceneArgs) -> ExitCode {
    match &args.command {
        Command::Check { file, json, strict } => check(file, *json, *strict),
        Command::Schema => {
            out!("{:#}", reference::schema());
            ExitCode::SUCCESS
        }
        Command::Doc => {
            out!("{}", reference::markdown().trim_end());
            ExitCode::SUCCESS
        }
        Command::Author(args) => super::author::run(args),
        Command::New { airport, out, minutes, movers } => {
            if !(1.0..=1440.0).contains(minutes) || !(0.0..=4000.0).contains(movers) {
                return fail(BAD_INPUT, "--minutes goes from 1 to 1440, --movers from 0 to 4000");
            }
            new(airport, out.as_deref(), *minutes, *movers)
        }
    }
}

fn check(file: &str, as_json: bool, strict: bool) -> ExitCode {
    let path = scenarios::locate(file);
    let read = scenarios::text_of(&path).and_then(|text| warnings::check(&path, &text));
    match read {
        Err(error) => {
            let text = scenarios::text_of(&path).unwrap_or_default();
            let all = warnings::errors(&path, &text, error);
            if as_json {
                let errors: Vec<_> = all.iter().map(as_fields).collect();
                let first = all[0].to_string();
                out!("{}", json!({"file": path, "error": first, "errors": errors, "warnings": []}));
            }
            all.into_iter().for_each(|error| {
                fail(BAD_INPUT, error);
            });
            ExitCode::from(BAD_INPUT)
        }
        Ok((scene, found)) => {
            let lines: Vec<String> = found.iter().map(|w| line(&path, w)).collect();
            let remarks = scene.traffic.behaving.as_ref().map_or(&[][..], |b| &b.remarks);
            let told = ["the wind turns", "opposite ends", "closed runway"];
            let notes = remarks.iter().filter(|r| told.iter().any(|word| r.starts_with(word)));
            let notes: Vec<&String> = notes.collect();
            if as_json {
                let of = |w: &Warning| json!({"number": w.word(), "file": path, "line": w.line, "key": w.key, "text": w.text});
                let warnings: Vec<_> = found.iter().map(of).collect();
                out!(
                    "{}",
                    json!({"file": path, "errors": [], "warnings": warnings, "read": scene.warnings, "notes": notes})
                );
            } else {
                scene.warnings.iter().chain(&lines).for_each(|line| out!("{line}"));
                notes.iter().for_each(|note| out!("{}: note: {note}", path.display()));
                let (movers, sensors) = (scene.traffic.entities.len(), scene.sensors.len());
                let count = scene.warnings.len() + lines.len();
                out!("{}: {movers} movers, {sensors} sensors, {count} warnings", path.display());
            }
            let warned = !(found.is_empty() && scene.warnings.is_empty());
            if strict && warned { ExitCode::from(FAILED) } else { ExitCode::SUCCESS }
        }
    }
}

/// An error by its parts; null where the sentence alone says it.
fn as_fields(error: &ScenarioError) -> serde_json::Value {
    json!({
        "file": error.file, "line": error.line, "key": error.key,
        "found": error.problem.found(), "allowed": error.problem.allowed(), "text": error.problem.to_string(),
    })
}

fn line(path: &Path, warning: &Warning) -> String {
    let (path, word) = (path.display(), warning.word());
    match warning.line {
        0 => format!("{path}: {word} {}: {}", warning.key, warning.text),
        line => format!("{path}:{line}: {word} {}: {}", warning.key, warning.text),
    }
}

fn new(airport: &str, out: Option<&Path>, minutes: f64, per_h: f64) -> ExitCode {
    let given = Path::new(airport);
    let layout = if given.is_file() {
        // Paths of a scene count from its folder: another folder's are written whole.
        match given.canonicalize() {
            Ok(path) => path.display().to_string(),
            Err(error) => return fail(BAD_INPUT, format!("{airport}: {error}")),
        }
    } else {
        match template::layout_of(airport) {
            Some(layout) => layout,
            None => {
                let text = format!(
                    "{airport} is neither a file nor an airport that comes with SEEDS; give the path of a layout \
                     (apt.dat, .xml, nodes.csv, .json, .geojson)"
                );
                return fail(BAD_INPUT, text);
            }
        }
    };
    let path = out.map_or_else(|| PathBuf::from("scene.toml"), Path::to_path_buf);
    let wanted = template::Wanted { layout, path, minutes, per_h };
    let (text, scene) = match template::scene(&wanted) {
        Ok(made) => made,
        Err(error) => return fail(BAD_INPUT, error),
    };
    let Some(out) = out else {
        out!("{}", text.trim_end());
        return ExitCode::SUCCESS;
    };
    if out.exists() {
        return fail(BAD_INPUT, format!("{} is there: name another file", out.display()));
    }
    let movers = scene.traffic.entities.len();
    let why = text.lines().find(|line| line.starts_with(template::LEFT_OUT));
    let left_out = why.map(|line| line.trim_start_matches("# ").to_owned());
    let schema = out.with_file_name("scene.schema.json");
    let schema_text = format!("{:#}\n", reference::schema());
    let written = std::fs::write(out, text).and_then(|()| std::fs::write(&schema, schema_text));
    if let Err(error) = written {
        return fail(FAILED, format!("{}: {error}", out.display()));
    }
    out!("{}: {movers} movers, {} sensors; seeds run {0}", out.display(), scene.sensors.len());
    for warning in &scene.warnings {
        out!("{warning}");
    }
    if let Some(why) = left_out {
        out!("{why}; seeds airport check says what the layout lacks");
    }
    ExitCode::SUCCESS
}
