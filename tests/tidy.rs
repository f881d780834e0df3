//! Who may not know whom: the table of `ARCHITECTURE.md`, held against the sources.

use std::path::{Path, PathBuf};

fn sources(folder: &str) -> Vec<(PathBuf, String)> {
    fn walk(folder: &Path, found: &mut Vec<(PathBuf, String)>) {
        for entry in std::fs::read_dir(folder).expect("a folder of sources").flatten() {
            let path = entry.path();
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&path).expect("text");
                found.push((path, text));
            }
        }
    }
    let mut found = Vec::new();
    walk(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), &mut found);
    assert!(!found.is_empty(), "{folder} has sources");
    found
}

fn refuse(folder: &str, words: &[&str]) {
    for (path, text) in sources(folder) {
        if path.components().any(|c| c.as_os_str() == "tests") {
            continue; // tests may read the sources that they speak of
        }
        for word in words {
            assert!(!text.contains(word), "{}: '{word}' has no place in {folder}", path.display());
        }
    }
}

#[test]
fn estimation_cannot_name_truth() {
    for folder in ["models/src/filter", "models/src/association", "models/src/fusion"] {
        for (path, text) in sources(folder) {
            if path.components().any(|c| c.as_os_str() == "tests") || path.ends_with("tests.rs") {
                continue; // tests hold tracks against a truth of their own
            }
            for word in ["crate::truth", "crate::sensors", "Cause", "PlotSink"] {
                assert!(!text.contains(word), "{}: names '{word}'", path.display());
            }
        }
    }
}

#[test]
fn pure_crates_do_no_io_and_read_no_clock() {
    let io =
        ["std::net", "std::fs", "tokio", "socket2", "SystemTime", "Instant::now", "std::thread"];
    for folder in ["pdu/src", "asterix/src", "mode_s/src", "models/src", "geodesy/src"] {
        refuse(folder, &io);
    }
    refuse("models/src", &["serde", "pdu::", "scenarios::", "HashMap"]);
    refuse("pdu/src", &["nalgebra", "models::", "scenarios::"]);
    refuse("scenarios/src", &["std::net::Udp", "tokio", "pdu::"]);
}

#[test]
fn federates_know_neither_sockets_nor_clocks() {
    let words = ["tokio", "socket2", "std::fs", "Instant::now", "SystemTime", "zenoh", "bincode"];
    for folder in ["federates/traffic_generator", "federates/external_world", "federates/smdfm"] {
        refuse(folder, &words);
    }
    for (path, text) in sources("federates") {
        if !path.ends_with("codec.rs") {
            assert!(!text.contains("bincode::"), "{}: bincode belongs in codec.rs", path.display());
        }
    }
}

#[test]
fn control_cannot_name_truth() {
    let mut found = 0;
    for folder in ["models/src/control", "federates/control"] {
        for (path, text) in sources(folder) {
            found += 1;
            for word in [
                "truth::",
                "TruthState",
                "TruthMessage",
                "traffic::core",
                "traffic::exact",
                "pdu::",
            ] {
                assert!(!text.contains(word), "{}: names {word}", path.display());
            }
            assert!(
                !path.starts_with("federates/control")
                    || text.contains("fn reads_pdus")
                    || path.ends_with("main.rs")
            );
        }
    }
    assert!(found >= 12, "{found} files");
}

#[test]
fn federates_know_each_other_by_the_exchange_only() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("federates");
    let shared = ["exchange", "runtime", "seeds"];
    let names: Vec<String> = std::fs::read_dir(root)
        .expect("the federates")
        .flatten()
        .filter(|e| e.path().is_dir())
        .map(|e| e.file_name().into_string().expect("a plain name"))
        .filter(|n| !shared.contains(&n.as_str()))
        .collect();
    assert!(names.len() >= 7, "{names:?}");
    for folder in names.iter().map(String::as_str).chain(["exchange", "runtime"]) {
        for (path, text) in sources(&format!("federates/{folder}")) {
            let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
            if name.ends_with("tests.rs") || name == "main.rs" {
                continue; // a test may put several on one bus
            }
            for other in names.iter().filter(|n| *n != folder) {
                let word = format!("crate::{other}");
                assert!(!text.contains(&word), "{}: names {word}", path.display());
            }
        }
    }
}

#[test]
fn manifests_keep_the_direction_of_knowledge() {
    let manifest = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name).join("Cargo.toml");
        let text = std::fs::read_to_string(path).expect("a manifest");
        text.split("[dev-dependencies]").next().expect("a first part").to_owned()
    };
    for (name, forbidden) in [
        ("geodesy", &["pdu", "models", "tokio", "nalgebra"][..]),
        ("pdu", &["models", "tokio", "nalgebra", "serde", "socket2"]),
        ("models", &["pdu", "scenarios", "tokio", "serde", "zenoh"]),
        ("scenarios", &["pdu", "tokio", "zenoh", "datalink"]),
        ("capture", &["tokio", "socket2", "models"]),
        ("datalink", &["pdu", "tokio", "models"]),
    ] {
        let text = manifest(name);
        for word in forbidden {
            let depends = text.lines().any(|line| {
                line.starts_with(&format!("{word}.")) || line.starts_with(&format!("{word} "))
            });
            assert!(!depends, "{name} must not depend on {word}");
        }
    }
}

#[test]
fn tests_need_no_second_build_of_what_runs() {
    let packages = |of: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO"));
        command.current_dir(env!("CARGO_MANIFEST_DIR"));
        command.args(["tree", "--offline", "--locked", "--prefix", "none", "-f", "{p} {f}"]);
        let output = command.args(of).output().expect("cargo tree");
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{words}");
        let text = String::from_utf8(output.stdout).expect("text");
        let line = |l: &str| l.trim_end_matches(" (*)").to_owned();
        text.lines().map(line).collect::<std::collections::BTreeSet<_>>()
    };
    let run = packages(&["-p", "seeds", "-e", "normal,build"]);
    let all = packages(&["--workspace", "-e", "normal,build,dev"]);
    assert!(run.iter().any(|p| p.starts_with("zenoh v")));
    let twice: Vec<&String> = run.difference(&all).collect();
    assert!(
        twice.is_empty(),
        "a dev-dependency gives these more features, so that they and all above them are built \
         twice: ask for the same features in [dependencies] of the root manifest: {twice:?}"
    );
}

#[test]
fn every_dependency_has_its_reason() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = |name: &str| std::fs::read_to_string(root.join(name)).expect(name);
    let doc = text("docs/dependencies.md");
    let table = doc.split("Our own").next().expect("a first part");
    let mut explained: Vec<&str> = table
        .lines()
        .filter_map(|line| line.strip_prefix("| `"))
        .flat_map(|line| line.split('|').next().unwrap_or_default().split('`'))
        .filter(|word| word.starts_with(|c: char| c.is_ascii_lowercase()))
        .collect();
    let workspace = text("Cargo.toml");
    let members = workspace.split("members = [").nth(1).and_then(|t| t.split(']').next());
    let own: Vec<&str> =
        members.expect("a list of members").split('"').filter(|m| m.len() > 2).collect();
    let mut used = std::collections::BTreeSet::new();
    for folder in std::iter::once(".").chain(own.iter().copied()) {
        let manifest = text(&format!("{folder}/Cargo.toml"));
        let mut inside = false;
        for line in manifest.lines() {
            if line.starts_with('[') {
                inside = line.ends_with("dependencies]");
            } else if inside
                && let Some((name, _)) = line.split_once(['.', ' ', '='])
                && name.starts_with(|c: char| c.is_ascii_lowercase())
                && !own.contains(&name)
            {
                used.insert(name.to_owned());
            }
        }
    }
    explained.sort_unstable();
    let used: Vec<&str> = used.iter().map(String::as_str).collect();
    assert_eq!(explained, used, "docs/dependencies.md against the manifests");
}

#[test]
fn the_pages_of_decisions_are_all_listed() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/decisions");
    let index = std::fs::read_to_string(folder.join("README.md")).expect("an index");
    for entry in std::fs::read_dir(&folder).expect("a folder").flatten() {
        let name = entry.file_name().into_string().expect("a name");
        assert!(name == "README.md" || index.contains(&format!("({name})")), "{name}");
    }
}
