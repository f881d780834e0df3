//! The recipes of CONTRIBUTING.md, done in a copy of the repository: a new kind of thing is one new file and one line.
//!
//! The copy is made and counted in every run. Building it takes minutes, so that is a command of its own:
//! `cargo test --release --test toys -- --ignored`.

use std::path::{Path, PathBuf};
use std::process::Command;

/// A new kind of thing: its file, where that goes, and the line that registers it behind another one.
struct Toy {
    file: &'static str,
    goes_to: &'static str,
    registry: &'static str,
    behind: &'static str,
    line: &'static str,
}

const TOYS: &[Toy] = &[
    Toy {
        file: "camera.rs",
        goes_to: "models/src/sensors/camera.rs",
        registry: "models/src/sensors/mod.rs",
        behind: "    dynamic as Dynamic,\n",
        line: "    camera as Camera,\n",
    },
    Toy {
        file: "dust.rs",
        goes_to: "models/src/sensors/radar/effects/dust.rs",
        registry: "models/src/sensors/radar/effects.rs",
        behind: "    Gases in gases,\n",
        line: "    Dust in dust,\n",
    },
    Toy {
        file: "rolling.rs",
        goes_to: "models/src/filter/rolling.rs",
        registry: "models/src/filter/mod.rs",
        behind: "    [six_state] Ca6 = six_state::CA6,\n",
        line: "    [rolling] Rolling = rolling::ROLLING,\n",
    },
    Toy {
        file: "pace.js",
        goes_to: "federates/viewer_logger/web/panels/pace.js",
        registry: "federates/viewer_logger/web/panels.js",
        behind: "  \"sensors\",\n",
        line: "  \"pace\",\n",
    },
];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn toy_file(name: &str) -> String {
    std::fs::read_to_string(root().join("tests/data/toys").join(name)).expect(name)
}

/// Copies what a build needs, and nothing that a build made.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("readable") {
        let entry = entry.expect("an entry");
        let name = entry.file_name();
        if ["target", ".git", "runs"].iter().any(|no| name == *no) {
            continue;
        }
        let (path, copied) = (entry.path(), to.join(&name));
        if path.is_dir() {
            copy(&path, &copied);
        } else {
            std::fs::copy(&path, &copied).expect("copied");
        }
    }
}

/// Adds a toy to the copy at `root`.
fn add(toy: &Toy, root: &Path) {
    let file = root.join(toy.goes_to);
    assert!(!file.exists(), "{} is there", toy.goes_to);
    std::fs::write(file, toy_file(toy.file)).expect("written");
    let registry = root.join(toy.registry);
    let text = std::fs::read_to_string(&registry).expect(toy.registry);
    assert_eq!(text.matches(toy.behind).count(), 1, "{:?} in {}", toy.behind, toy.registry);
    let line = format!("{}{}", toy.behind, toy.line);
    std::fs::write(registry, text.replace(toy.behind, &line)).expect("written");
}

#[test]
fn a_recipe_is_one_file_and_one_line_and_contributing_says_it() {
    let recipes = std::fs::read_to_string(root().join("CONTRIBUTING.md")).expect("recipes");
    for toy in TOYS {
        let registry = std::fs::read_to_string(root().join(toy.registry)).expect(toy.registry);
        assert_eq!(registry.matches(toy.behind).count(), 1, "{}", toy.registry);
        assert_eq!(toy.line.lines().count(), 1);
        for said in [toy.registry, toy.line.trim(), toy.file] {
            assert!(recipes.contains(said), "CONTRIBUTING.md says nothing of `{said}`");
        }
    }
}

#[test]
#[ignore = "builds the workspace a second time: a command of its own, see CONTRIBUTING.md"]
fn toys_are_built_and_run_in_a_copy() {
    let home = std::env::temp_dir().join(format!("seeds-toys-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&home);
    copy(&root(), &home);
    for toy in TOYS {
        add(toy, &home);
    }
    std::fs::write(home.join("scenarios/tests/toy.rs"), toy_file("scene_check.rs"))
        .expect("written");
    let cargo = |args: &[&str]| {
        let status = Command::new(env!("CARGO"))
            .current_dir(&home)
            // A folder of its own: Cargo takes a copy's packages for the original's, and would leave paths of the copy behind.
            .env("CARGO_TARGET_DIR", root().join("target/toys"))
            .args(args)
            .status();
        assert!(status.expect("cargo").success(), "cargo {args:?} in {}", home.display());
    };
    // Laws of all kinds and effects: words, colours, draws, costs, what is skipped and what is not, bounds over boxes.
    cargo(&[
        "test",
        "--release",
        "-p",
        "models",
        "--lib",
        "--",
        "sensors::planned",
        "sensors::declared",
        "sensors::asde",
        "sensors::radar::levels",
    ]);
    // Laws of all rungs: sound whatever comes, on the road with missing and gross plots, bounded errors.
    cargo(&["test", "--release", "-p", "models", "--lib", "--", "filter::hard_cases"]);
    cargo(&["test", "--release", "-p", "scenarios", "--test", "toy"]);
    // Every panel of the page has a tab, is filled and fits its box.
    cargo(&["test", "--release", "--test", "page", "--", "every_list_is_filled"]);
    // The whole of the product, pages and tools included.
    cargo(&["check", "--release", "--workspace", "--all-targets"]);
    std::fs::remove_dir_all(&home).expect("cleaned up");
}
