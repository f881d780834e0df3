//! Who may not know whom: the table of `ARCHITECTURE.md`, held against the sources.

use std::collections::{BTreeMap, BTreeSet};
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
            let federate = path.ends_with("federates/control/mod.rs");
            assert!(!federate || text.contains("fn reads_pdus"), "it is sent no PDUs");
        }
    }
    assert!(found >= 12, "{found} files");
    // What it looks ahead with is made of what it sees, and tells measures only.
    for file in ["models/src/traffic/ahead.rs", "models/src/traffic/ahead/perceive.rs"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
        let text = std::fs::read_to_string(&path).expect(file);
        for word in ["truth::", "TruthState", ".state(", "Core::new"] {
            assert!(!text.contains(word), "{file}: names {word}");
        }
    }
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

/// Two builds may join one federation if they give the same bits: whoever makes a part of them is in the hash of `build.rs`.
#[test]
fn whatever_decides_a_digest_is_in_the_identity_of_the_build() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let script = std::fs::read_to_string(root.join("build.rs")).expect("text");
    let list = script.split_once("DECIDING:").expect("the list").1;
    let list = list.split_once("];").expect("its end").0;
    let hashed: BTreeSet<&str> = list.split('"').skip(1).step_by(2).collect();
    // Who only looks on, gives commands that are recorded, or measures.
    let others = ["admin_station", "gateway", "seeds", "viewer_logger", "lib.rs"];
    for entry in std::fs::read_dir(root.join("federates")).expect("federates").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if !others.contains(&&name[..]) {
            assert!(hashed.contains(&format!("federates/{name}")[..]), "{name} is not hashed");
        }
    }
    // And every crate of ours that these name.
    let ours = ["geodesy", "pdu", "asterix", "mode_s", "models", "scenarios"];
    for folder in hashed.iter().filter(|folder| root.join(folder).is_dir()) {
        for (path, text) in sources(folder) {
            for name in ours {
                let named =
                    text.contains(&format!("use {name}::")) || text.contains(&format!(" {name}::"));
                let known = hashed.contains(&format!("{name}/src")[..]);
                assert!(!named || known, "{}: {name} is not hashed", path.display());
            }
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

/// The text without comments, bodies of macros and modules of tests: what a file says for itself.
fn own_words(text: &str) -> String {
    let end = text.find("#[cfg(test)]\nmod tests {").unwrap_or(text.len());
    let lines = text[..end].lines().map(|line| line.split("//").next().unwrap_or(""));
    let text = lines.collect::<Vec<_>>().join("\n");
    let mut kept = String::new();
    let mut rest = &text[..];
    while let Some(at) = rest.find("macro_rules!") {
        kept += &rest[..at];
        // A macro ends at the first line that closes what stands at the margin.
        rest = rest[at..].find("\n}").map_or("", |end| &rest[at + end + 2..]);
    }
    kept + rest
}

/// The paths of `use a::{b, c::{d}};`, each whole.
fn paths_of(import: &str) -> Vec<String> {
    let Some((before, rest)) = import.split_once('{') else {
        return vec![import.split(" as ").next().unwrap_or("").trim().to_owned()];
    };
    let inside = rest.rsplit_once('}').map_or(rest, |(inside, _)| inside);
    let (mut depth, mut parts, mut part) = (0, Vec::new(), String::new());
    for c in inside.chars() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(std::mem::take(&mut part));
                continue;
            }
            _ => {}
        }
        part.push(c);
    }
    parts.push(part);
    let whole = parts.iter().filter(|p| !p.trim().is_empty());
    whole.flat_map(|p| paths_of(&format!("{}{}", before.trim(), p.trim()))).collect()
}

/// Of the files below a folder, which names which: modules by their paths.
fn names(folder: &str) -> BTreeMap<String, BTreeSet<String>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let module = |path: &Path| {
        let inside = path.strip_prefix(&root).expect("below it").with_extension("");
        let words = inside.iter().map(|w| w.to_string_lossy().into_owned());
        words.filter(|w| !["mod", "lib", "main"].contains(&&w[..])).collect::<Vec<_>>().join("::")
    };
    let test = |path: &Path| path.iter().any(|w| w.to_string_lossy().contains("tests"));
    let files: BTreeMap<String, String> = sources(folder)
        .into_iter()
        .filter(|(path, _)| !test(path) && !path.ends_with("main.rs"))
        .map(|(path, text)| (module(&path), own_words(&text)))
        .collect();
    let mut named = BTreeMap::new();
    for (own, text) in &files {
        let imports = text.split("use ").skip(1).filter_map(|t| t.split(';').next());
        let said =
            text.match_indices("crate::").chain(text.match_indices("super::")).map(|(at, _)| {
                let end = |c: char| !(c.is_alphanumeric() || c == '_' || c == ':');
                text[at..].split(end).next().unwrap_or("")
            });
        let mut found = BTreeSet::new();
        for path in imports
            .map(|i| i.split_whitespace().collect::<String>())
            .flat_map(|i| paths_of(&i))
            .chain(said.map(str::to_owned))
        {
            let mut base: Vec<&str> = own.split("::").filter(|w| !w.is_empty()).collect();
            let mut rest = &path[..];
            if let Some(inside) = rest.strip_prefix("crate::") {
                (base, rest) = (Vec::new(), inside);
            } else if !rest.starts_with("super::") && !rest.starts_with("self::") {
                continue;
            }
            while let Some(outer) = rest.strip_prefix("super::") {
                base.pop();
                rest = outer;
            }
            let rest = rest.strip_prefix("self::").unwrap_or(rest);
            let mut whole: Vec<&str> = base.into_iter().chain(rest.split("::")).collect();
            // The longest beginning that is a file.
            while !whole.is_empty() && !files.contains_key(&whole.join("::")) {
                whole.pop();
            }
            let other = whole.join("::");
            let inside = |a: &str, b: &str| a.starts_with(&format!("{b}::"));
            if !other.is_empty() && other != *own && !inside(own, &other) && !inside(&other, own) {
                found.insert(other);
            }
        }
        named.insert(own.clone(), found);
    }
    named
}

/// Files that name each other around a circle cannot be read one after the other.
#[test]
fn files_do_not_name_each_other_in_circles() {
    let folders = [
        "asterix/src",
        "capture/src",
        "datalink/src",
        "federates",
        "geodesy/src",
        "mode_s/src",
        "models/src",
        "pdu/src",
        "scenarios/src",
        "studies/src",
        "verify/src",
    ];
    let mut arrows = 0;
    for folder in folders {
        let mut left = names(folder);
        arrows += left.values().map(BTreeSet::len).sum::<usize>();
        // Whoever names nobody that is left can be read now; what stays is in a circle or waits for one.
        loop {
            let readable: Vec<String> = left
                .iter()
                .filter(|(_, named)| named.is_empty())
                .map(|(own, _)| own.clone())
                .collect();
            if readable.is_empty() {
                break;
            }
            for own in readable {
                left.remove(&own);
                for named in left.values_mut() {
                    named.remove(&own);
                }
            }
        }
        // And whoever nobody names that is left is not in the circle itself.
        loop {
            let wanted: BTreeSet<String> = left.values().flatten().cloned().collect();
            let before = left.len();
            left.retain(|own, _| wanted.contains(own));
            if left.len() == before {
                break;
            }
        }
        assert!(left.is_empty(), "{folder}: a circle is among {left:#?}");
    }
    assert!(arrows > 1000, "the sources were read: {arrows} arrows");
}

/// A mutant whose text has moved on stops the whole command that tries them.
#[test]
fn the_mutants_of_the_list_are_in_the_sources() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let list = std::fs::read_to_string(root.join("tests/mutants/list.toml")).expect("the list");
    let mut looked = 0;
    for mutant in list.split("[[mutant]]").skip(1) {
        let value = |key: &str| {
            let line = mutant.lines().find_map(|l| l.strip_prefix(key)?.strip_prefix(" = "))?;
            let text = line.strip_prefix('"').and_then(|l| l.strip_suffix('"'));
            let plain =
                |t: &str| t.replace("\\n", "\n").replace("\\\"", "\"").replace("\\\\", "\\");
            Some(text.map_or_else(|| line.to_owned(), plain))
        };
        let [Some(file), Some(old)] = ["file", "old"].map(value) else {
            panic!("no file or no old: {mutant}");
        };
        let text = std::fs::read_to_string(root.join(&file)).expect(&file);
        let count = text.matches(&old).count();
        let right = if value("nth").is_some() { count > 0 } else { count == 1 };
        assert!(right, "{file} has {count} times: {old}");
        looked += 1;
    }
    assert!(looked > 100, "{looked}");
}

/// Documents print figures by examples: each that they name is there.
#[test]
fn examples_that_documents_name_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = ["", "docs", "docs/decisions"].map(|f| root.join(f));
    let files = folders.iter().filter_map(|f| std::fs::read_dir(f).ok()).flatten().flatten();
    let mut named = Vec::new();
    for path in files.map(|f| f.path()).filter(|p| p.extension().is_some_and(|e| e == "md")) {
        let text = std::fs::read_to_string(&path).expect("a document");
        for part in text.split("--example ").skip(1) {
            let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
            let name: String = part.chars().take_while(|c| word(*c)).collect();
            if !name.is_empty() {
                named.push((path.clone(), name));
            }
        }
    }
    assert!(named.len() >= 4, "{named:?}");
    let crates = std::fs::read_dir(root).expect("the root").flatten().map(|f| f.path());
    let folders: Vec<_> = crates.chain([root.to_path_buf()]).map(|f| f.join("examples")).collect();
    for (path, name) in named {
        let there = |f: &std::path::PathBuf| {
            f.join(format!("{name}.rs")).is_file() || f.join(&name).join("main.rs").is_file()
        };
        assert!(folders.iter().any(there), "{}: --example {name}", path.display());
    }
}
