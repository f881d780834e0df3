//! `seeds sweep SCENE --vary KEY=V1,V2 --seeds A..B -o FILE`: many runs, one table.

use super::in_process::{Interrupt, federation};
use super::run_args::RunArgs;
use crate::runtime::cli::{self, BAD_INPUT, COMPLETE, FAILED, fail, out};
use crate::runtime::clock::monotonic_ns;
use anyhow::{Context, bail, ensure};
use clap::{Args, Parser};
use serde_json::{Map, Value, json};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// Run a scene many times as fast as possible and collect the summaries in one table
#[derive(Args, Clone, Debug)]
pub struct SweepArgs {
    /// Scene: a TOML file, or the name of a scene that comes with SEEDS
    #[arg(value_name = "SCENE", default_value = "zurich")]
    scene: String,

    /// A key of the scene and its values: tracking.profile=paper,accurate; lists are entered by number, name or kind: sensor.0.rpm=30,60. Several keys: all combinations
    #[arg(long, value_name = "KEY=V1,V2,…", value_parser = vary)]
    vary: Vec<Vary>,

    /// Seeds: one, a list with commas, or a range A..B (B among them)
    #[arg(long, value_name = "A..B", default_value = "1", value_parser = seeds)]
    seeds: Seeds,

    /// Simulated duration of each run, s [default: the scene's]
    #[arg(long, value_name = "S", value_parser = cli::seconds)]
    duration: Option<f64>,

    /// Table: .csv, or .json with one object a run
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
}

/// One key and the values that it takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Vary {
    key: String,
    values: Vec<String>,
}

/// Seeds of the runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seeds(Vec<u64>);

/// Runs of one sweep.
const MOST: usize = 100_000;

/// Commas within brackets or quotes separate nothing.
fn vary(text: &str) -> Result<Vary, String> {
    let (key, list) = text.split_once('=').ok_or("KEY=V1,V2 is asked for")?;
    let (mut values, mut depth, mut quoted) = (vec![String::new()], 0_i32, false);
    for c in list.chars() {
        match c {
            '"' => quoted = !quoted,
            '[' | '{' if !quoted => depth += 1,
            ']' | '}' if !quoted => depth -= 1,
            ',' if !quoted && depth == 0 => {
                values.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(value) = values.last_mut() {
            value.push(c);
        }
    }
    if key.is_empty() || values.iter().any(String::is_empty) {
        return Err("KEY=V1,V2 is asked for, without empty values".to_owned());
    }
    Ok(Vary { key: key.to_owned(), values })
}

fn seeds(text: &str) -> Result<Seeds, String> {
    let number =
        |t: &str| t.trim().parse::<u64>().map_err(|_| format!("'{t}' is not a valid seed"));
    let mut list = Vec::new();
    for part in text.split(',') {
        match part.split_once("..") {
            Some((a, b)) => {
                let (a, b) = (number(a)?, number(b)?);
                if a > b || b - a >= MOST as u64 {
                    return Err(format!("'{part}': A..B with A not above B, at most {MOST} seeds"));
                }
                list.extend(a..=b);
            }
            None => list.push(number(part)?),
        }
    }
    if list.iter().any(|seed| *seed > i64::MAX as u64) {
        return Err(format!("a seed is at most {}", i64::MAX));
    }
    Ok(Seeds(list))
}

/// Runs them all; exit code 1 if one failed or somebody wanted an end, with the table of the others.
#[must_use]
pub fn run(args: &SweepArgs) -> ExitCode {
    cli::log_to_stderr(cli::LogFormat::Text, "error");
    let runs = match runs(args) {
        Ok(runs) => runs,
        Err(e) => return fail(BAD_INPUT, format!("{e:#}")),
    };
    let interrupt = Interrupt::heard();
    let one = |one: &One| one_run(args, one, &interrupt);
    match sweep(args, &runs, one, || interrupt.asked()) {
        Ok(Swept { done, failed: 0 }) if done == runs.len() => ExitCode::from(COMPLETE),
        Ok(Swept { done, failed }) if done + failed < runs.len() => {
            fail(FAILED, format!("interrupted: the table has {done} of {} runs", runs.len()))
        }
        Ok(Swept { failed, .. }) => fail(
            FAILED,
            format!("{failed} of {} runs failed; the table has the others", runs.len()),
        ),
        Err(e) => fail(FAILED, format!("{e:#}")),
    }
}

/// One run: values of the varied keys, seed, scene.
struct One {
    values: Vec<String>,
    seed: u64,
    scene: Arc<scenarios::Scene>,
}

/// Refuses keys that a flag says for every run, and those that would be two columns of one name.
fn check_keys(args: &SweepArgs) -> anyhow::Result<()> {
    for (index, Vary { key, .. }) in args.vary.iter().enumerate() {
        ensure!(
            key != "run.seed",
            "--vary run.seed: every run has its seed by --seeds; say --seeds"
        );
        ensure!(
            key != "run.duration_s" || args.duration.is_none(),
            "--vary run.duration_s: --duration says it for every run; leave one of them out"
        );
        let twice = args.vary[..index].iter().any(|before| before.key == *key);
        ensure!(!twice, "--vary {key}: it is said twice; say all its values at once: {key}=V1,V2");
    }
    Ok(())
}

/// All combinations, each read as a scene before the first runs.
fn runs(args: &SweepArgs) -> anyhow::Result<Vec<One>> {
    check_keys(args)?;
    cli::writable(&args.out)?;
    let path = scenarios::locate(&args.scene);
    let text = scenarios::text_of(&path)?;
    let mut combinations: Vec<Vec<String>> = vec![Vec::new()];
    for Vary { values, .. } in &args.vary {
        ensure!(
            combinations.len() * values.len() * args.seeds.0.len() <= MOST,
            "more than {MOST} runs"
        );
        combinations = combinations
            .iter()
            .flat_map(|before| {
                values.iter().map(move |v| [&before[..], std::slice::from_ref(v)].concat())
            })
            .collect();
    }
    let mut runs = Vec::new();
    for values in combinations {
        let mut changed = text.clone();
        let mut said = Vec::new();
        for (Vary { key, .. }, value) in args.vary.iter().zip(&values) {
            said.push(format!("{key}={value}"));
            changed = match scenarios::vary::with_key(&changed, key, value) {
                Ok(changed) => changed,
                Err(e) => bail!("--vary {key}={value}: {e}"),
            };
        }
        let scene =
            scenarios::load_text(&path, if args.vary.is_empty() { &text } else { &changed })
                .with_context(|| format!("with {}", said.join(" ")))?;
        let scene = Arc::new(scene);
        let of_seed =
            |seed: &u64| One { values: values.clone(), seed: *seed, scene: Arc::clone(&scene) };
        runs.extend(args.seeds.0.iter().map(of_seed));
    }
    Ok(runs)
}

/// What became of the runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Swept {
    done: usize,
    failed: usize,
}

/// The summary of one run; none where it failed.
fn one_run(args: &SweepArgs, one: &One, interrupt: &Interrupt) -> anyhow::Result<Option<Value>> {
    let mut line =
        vec!["run".to_owned(), args.scene.clone(), "--fast".into(), "--in-process".into()];
    line.extend(["--no-viewer".into(), "--seed".into(), one.seed.to_string()]);
    if let Some(seconds) = args.duration {
        line.extend(["--duration".to_owned(), seconds.to_string()]);
    }
    let run = Inner::try_parse_from(line).context("the run's own command line")?.run;
    let mut summaries = Vec::new();
    let code = federation(&run, &one.scene, interrupt, |summary| summaries.push(summary))?;
    let summary = summaries.pop().filter(|_| code == COMPLETE);
    Ok(summary.map(serde_json::to_value).transpose()?)
}

/// One after the other, until somebody wants an end. A run that cannot be made is one that failed; the table is written on the way,
/// so that nothing but a minute is lost with this process.
fn sweep(
    args: &SweepArgs,
    runs: &[One],
    mut one_run: impl FnMut(&One) -> anyhow::Result<Option<Value>>,
    interrupted: impl Fn() -> bool,
) -> anyhow::Result<Swept> {
    let (mut table, mut failed, mut written_ns) = (Vec::new(), 0, monotonic_ns());
    for (index, one) in runs.iter().enumerate() {
        if interrupted() {
            break;
        }
        let values: Vec<String> =
            args.vary.iter().zip(&one.values).map(|(v, to)| format!("{}={to} ", v.key)).collect();
        let what = format!("{}seed {}", values.concat(), one.seed);
        let summary = one_run(one).unwrap_or_else(|error| {
            if !interrupted() {
                tracing::error!("{what}: {error:#}");
            }
            None
        });
        if interrupted() {
            break; // it was ended before its time
        }
        match summary {
            Some(summary) => {
                let mut row = Map::new();
                for (Vary { key, .. }, value) in args.vary.iter().zip(&one.values) {
                    row.insert(key.clone(), json!(value));
                }
                flatten("", &summary, &mut row);
                table.push(row);
            }
            None => failed += 1,
        }
        out!("{} of {}: {what}", index + 1, runs.len());
        if monotonic_ns().saturating_sub(written_ns) > WRITE_NS {
            write(args, &table)?;
            written_ns = monotonic_ns();
        }
    }
    write(args, &table)?;
    Ok(Swept { done: table.len(), failed })
}

/// How often the table is written on the way.
const WRITE_NS: u64 = 60_000_000_000;

#[derive(Parser)]
struct Inner {
    #[command(flatten)]
    run: RunArgs,
}

/// Numbers, texts and truth values under their names, those of inner objects as `outer.inner`.
fn flatten(prefix: &str, value: &Value, row: &mut Map<String, Value>) {
    for (name, value) in value.as_object().into_iter().flatten() {
        let name = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
        match value {
            Value::Object(_) => flatten(&name, value, row),
            Value::Array(_) => {}
            other => drop(row.insert(name, other.clone())),
        }
    }
}

fn write(args: &SweepArgs, table: &[Map<String, Value>]) -> anyhow::Result<()> {
    let mut file = Vec::new();
    if args.out.extension().is_some_and(|e| e == "json") {
        serde_json::to_writer_pretty(&mut file, table)?;
        writeln!(file)?;
    } else {
        // Varied keys first, then the seed; the other columns as they come, of all runs.
        let mut columns: Vec<&str> = args.vary.iter().map(|v| v.key.as_str()).collect();
        for name in
            ["seed"].into_iter().chain(table.iter().flat_map(|row| row.keys().map(String::as_str)))
        {
            if !columns.contains(&name) {
                columns.push(name);
            }
        }
        writeln!(file, "{}", columns.iter().map(|c| cell(c)).collect::<Vec<_>>().join(","))?;
        for row in table {
            let cells = columns.iter().map(|name| match row.get(*name) {
                None | Some(Value::Null) => String::new(),
                Some(Value::String(text)) => cell(text),
                Some(other) => other.to_string(),
            });
            writeln!(file, "{}", cells.collect::<Vec<_>>().join(","))?;
        }
    }
    cli::save(&args.out, file)
}

/// A cell of a table; what has commas, quotes or line ends stands in quotes.
pub(crate) fn cell(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_and_seeds_are_read() {
        let read = vary("sensor.0.site=[1, 2],[3, 4]").expect("sound");
        assert_eq!((read.key.as_str(), read.values.len()), ("sensor.0.site", 2));
        assert_eq!(vary("a=\"x,y\",z").expect("sound").values, ["\"x,y\"", "z"]);
        for wrong in ["a", "a=", "=1", "a=1,,2"] {
            assert!(vary(wrong).is_err(), "{wrong}");
        }
        assert_eq!(seeds("3..5,9"), Ok(Seeds(vec![3, 4, 5, 9])));
        for wrong in ["", "5..3", "a", "1..99999999", "-1"] {
            assert!(seeds(wrong).is_err(), "{wrong}");
        }
        assert_eq!(cell("a,\"b\""), "\"a,\"\"b\"\"\"");
    }

    /// What a run is told beside the scene has the word there, so that a column of it would be false; a key has one column.
    #[test]
    fn what_has_a_flag_of_its_own_and_a_key_said_twice_are_refused() {
        let asked = |vary_of: &[&str], duration| {
            let args = SweepArgs {
                scene: "xsyn".to_owned(),
                vary: vary_of.iter().map(|text| vary(text).expect("sound")).collect(),
                seeds: Seeds(vec![1]),
                duration,
                out: std::env::temp_dir().join(format!("seeds-vary-{}.csv", std::process::id())),
            };
            runs(&args).map(|runs| runs.len()).map_err(|e| format!("{e:#}"))
        };
        let refused = |vary: &[&str], duration, word: &str| {
            let said = asked(vary, duration).expect_err(word);
            assert!(said.contains(word) && !said.contains('\n'), "{vary:?}: {said}");
        };
        refused(&["run.seed=5,6"], None, "--seeds");
        refused(&["run.duration_s=30,60"], Some(30.0), "--duration");
        let twice = ["tracking.profile=paper", "tracking.filter=abg", "tracking.profile=accurate"];
        refused(&twice, None, "tracking.profile");
        assert_eq!(asked(&["run.duration_s=30,60"], None), Ok(2));
        assert_eq!(asked(&["tracking.profile=paper,accurate"], Some(30.0)), Ok(2));
    }

    /// The table of three runs, whose second does as told, where somebody wants an end while the run of this place goes on.
    fn table_of(second: fn() -> anyhow::Result<Option<Value>>, end_in: usize) -> (Swept, String) {
        let folder = std::env::temp_dir().join(format!("seeds-sweep-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let args = SweepArgs {
            scene: "zurich".to_owned(),
            vary: vec![vary("tracking.filter=abg").expect("sound")],
            seeds: Seeds(vec![1, 2, 3]),
            duration: None,
            out: folder.join("table.csv"),
        };
        let scene = scenarios::load_without_truth(&scenarios::locate("xsyn")).expect("a scene");
        let scene = Arc::new(scene);
        let one = |seed: &u64| One {
            values: vec!["abg".to_owned()],
            seed: *seed,
            scene: Arc::clone(&scene),
        };
        let runs: Vec<One> = args.seeds.0.iter().map(one).collect();
        let begun = std::cell::Cell::new(0);
        let make = |one: &One| {
            begun.set(begun.get() + 1);
            if one.seed == 2 { second() } else { Ok(Some(json!({"seed": one.seed}))) }
        };
        let swept = sweep(&args, &runs, make, || begun.get() >= end_in).expect("written");
        assert!(begun.get() <= end_in, "none is begun afterwards");
        let table = std::fs::read_to_string(&args.out).expect("a table");
        std::fs::remove_dir_all(&folder).ok();
        (swept, table)
    }

    #[test]
    fn runs_that_fail_and_an_interrupt_leave_the_table_of_the_others() {
        let good = || Ok(Some(json!({"seed": 2})));
        for second in [|| bail!("no thread"), || Ok(None)] {
            let (swept, table) = table_of(second, 9);
            assert_eq!(swept, Swept { done: 2, failed: 1 });
            assert_eq!(table, "tracking.filter,seed\nabg,1\nabg,3\n");
        }
        let (swept, table) = table_of(good, 2);
        assert_eq!(swept, Swept { done: 1, failed: 0 }, "the second was ended");
        assert_eq!(table, "tracking.filter,seed\nabg,1\n");
        assert_eq!(table_of(good, 9).0, Swept { done: 3, failed: 0 });
    }
}
