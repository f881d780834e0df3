//! What is verified is what flies: public functions of `models` that no run, tool or study reaches are listed here, each a debt.
//!
//! By names, so a function counts as reached if any reached code has its name: what is listed is certainly reached by nothing but
//! tests and vectors. A new one fails; one that is deleted has to leave the list, one that is flown is named.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Functions that only vectors and tests call, by file. Textbook forms that bound or check what flies may stay, with the
/// reason behind them; the others are to be flown or deleted.
const NOT_FLOWN: &[(&str, &[&str])] = &[
    ("control/departure_sequence.rs", &["makespan_s"]),
    ("environment/surface.rs", &["circular_opposite", "circular_same"]),
    ("filter/consistency.rs", &["gate_2d"]),
    // The last two put in rules of somebody else's.
    ("fusion/tracker.rs", &["site_biases", "with_association", "with_initiation"]),
    ("plot.rs", &["polar_bias_m", "principal_axes"]),
    ("score/sets.rs", &["ospa"]),
    ("sensors/asde.rs", &["plan_scan", "planting"]),
    ("sensors/radar/parameters.rs", &["ku_band"]),
    ("sensors/reporting/constellation.rs", &["geometric"]),
    ("sensors/mod.rs", &["model_named"]),
    ("sensors/radar/detection.rs", &["marcum_q", "sankaran", "shnidman_db"]),
    ("sensors/reporting/gauss_markov.rs", &["averaged_variance_ratio"]),
    ("sensors/induction_loop/config.rs", &["occupancy_s"]),
    ("sensors/radar/propagation.rs", &["one_way_real", "sinc"]),
    ("sensors/radar/equation.rs", &["floor_db"]),
    ("sensors/radar/radial.rs", &["probability_within", "radial_quantile"]),
    ("sensors/reporting/ranging.rs", &["with_selective_availability"]),
    (
        "sensors/reporting/service.rs",
        &[
            "down_independent",
            "down_single_repair",
            "position_probability",
            "reference_continuity",
            "reference_loss_probability",
            "slot_down",
            "slot_up",
        ],
    ),
    ("sensors/radar/shadow.rs", &["knife_edge_exact_db"]),
    ("special.rs", &["fresnel"]),
    ("traffic/ordered.rs", &["is_ordered"]),
    ("traffic/profile.rs", &["leg_profile"]),
    ("traffic/runway_roll.rs", &["time_to_s"]),
    ("traffic/tractrix.rs", &["slip_on_straight_rad"]),
    ("traffic/windows.rs", &["earliest_arrival_s", "free_windows"]),
];

/// Words of a text.
fn words(text: &str) -> BTreeSet<&str> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|w| !w.is_empty()).collect()
}

/// The text without comments and without the module of tests at its end.
fn code(path: &Path) -> String {
    let text = std::fs::read_to_string(path).expect("readable");
    let end = text.find("#[cfg(test)]\nmod tests {").unwrap_or(text.len());
    let lines = text[..end].lines().map(|line| line.split("//").next().unwrap_or(""));
    lines.collect::<Vec<_>>().join("\n")
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.map(|e| e.expect("an entry").path()) {
        let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let tests = name.contains("tests")
            || ["testing.rs", "hard_cases.rs", "sample_shapes.rs"].contains(&&*name);
        if path.is_dir() && !tests {
            sources(&path, found);
        } else if name.ends_with(".rs") && !tests {
            found.push(path);
        }
    }
    found.sort();
}

/// A function: its file, name, whether it is public, and its text.
struct Function {
    file: String,
    name: String,
    public: bool,
    text: String,
}

/// Takes the functions out of a text; what is left is the second value.
fn functions(file: &str, text: &str) -> (Vec<Function>, String) {
    let mut spans: Vec<(usize, usize, String, bool)> = Vec::new();
    let mut from = 0;
    while let Some(at) = text[from..].find("fn ").map(|i| from + i) {
        from = at + 3;
        let before = text[..at].chars().next_back();
        let name: String =
            text[at + 3..].chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        if name.is_empty() || !before.is_none_or(|c| c.is_whitespace()) {
            continue;
        }
        let Some(open) = text[at..].find('{').map(|i| at + i) else { continue };
        if text[at..open].contains(';') {
            continue;
        }
        let mut depth = 0;
        let close = text[open..].char_indices().find_map(|(i, c)| {
            depth += match c {
                '{' => 1,
                '}' => -1,
                _ => 0,
            };
            (depth == 0).then_some(open + i)
        });
        let Some(close) = close else { continue };
        let line = text[..at].rsplit('\n').next().unwrap_or("").trim_start();
        spans.push((at, close, name, line.starts_with("pub ")));
    }
    let (mut rest, mut end) = (String::new(), 0);
    let mut found = Vec::new();
    for (at, close, name, public) in spans {
        // A function inside another one went with it.
        if at >= end {
            rest.push_str(&text[end..at]);
            end = close;
        }
        let text = text[at..close].to_owned();
        found.push(Function { file: file.to_owned(), name, public, text });
    }
    rest.push_str(&text[end..]);
    (found, rest)
}

#[test]
fn every_public_function_is_flown_or_listed() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for folder in ["../federates", "../scenarios/src", "../studies/src"] {
        sources(&models.join(folder), &mut files);
    }
    let mut roots: BTreeSet<String> = BTreeSet::new();
    for file in &files {
        roots.extend(words(&code(file)).into_iter().map(str::to_owned));
    }
    let (mut all, mut own) = (Vec::new(), Vec::new());
    sources(&models.join("src"), &mut own);
    for path in &own {
        let file = path.strip_prefix(models.join("src")).expect("below").display().to_string();
        let (functions, rest) = functions(&file, &code(path));
        let rest: Vec<&str> =
            rest.lines().filter(|l| !l.trim_start().starts_with("pub use ")).collect();
        roots.extend(words(&rest.join("\n")).into_iter().map(str::to_owned));
        all.extend(functions);
    }
    let mut calls: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for function in &all {
        let mut called = words(&function.text);
        called.remove(&*function.name);
        calls.entry(&function.name).or_default().extend(called);
    }
    // Called by operators and the language.
    let by_language =
        ["fmt", "from", "eq", "cmp", "partial_cmp", "default", "deref", "next", "drop"];
    let mut todo: Vec<&str> = calls
        .keys()
        .filter(|name| roots.contains(**name) || by_language.contains(name))
        .copied()
        .collect();
    let mut reached: BTreeSet<&str> = todo.iter().copied().collect();
    while let Some(name) = todo.pop() {
        for called in &calls[name] {
            if calls.contains_key(called) && reached.insert(called) {
                todo.push(called);
            }
        }
    }
    let mut found: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for function in all.iter().filter(|f| f.public && !reached.contains(&*f.name)) {
        found.entry(&function.file).or_default().insert(&function.name);
    }
    assert!(all.len() > 1000 && reached.len() > 700, "{} of {}", reached.len(), all.len());
    let listed: BTreeMap<&str, BTreeSet<&str>> =
        NOT_FLOWN.iter().map(|(file, names)| (*file, names.iter().copied().collect())).collect();
    for (file, names) in &found {
        for name in names {
            let known = listed.get(file).is_some_and(|l| l.contains(name));
            assert!(
                known,
                "{file}: `{name}` is public and reached by no run, tool or study: fly it or delete it"
            );
        }
    }
    for (file, names) in &listed {
        for name in names {
            let there = all.iter().any(|f| f.public && f.file == *file && f.name == *name);
            assert!(there, "{file}: `{name}` is gone: take it off the list");
            if found.get(file).is_none_or(|f| !f.contains(name)) {
                println!("{file}: `{name}` is flown: take it off the list");
            }
        }
    }
}
