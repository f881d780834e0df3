//! An executable that was copied away from the sources that it was built from.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// An empty folder with a copy of the executable in it.
fn empty_host(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("seeds-copied-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(folder.join("elsewhere")).expect("a folder");
    std::fs::copy(env!("CARGO_BIN_EXE_seeds"), folder.join("seeds")).expect("a copy");
    folder
}

fn seeds(host: &Path, args: &[&str]) -> Output {
    let folder = host.join("elsewhere");
    Command::new(host.join("seeds")).current_dir(folder).args(args).output().expect("it starts")
}

fn stdout(output: &Output) -> String {
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{words}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn a_copied_executable_runs_the_shipped_scene_and_an_own_one_from_any_folder() {
    let host = empty_host("run");
    let run = ["run", "--in-process", "--fast", "--no-viewer", "--duration", "5"];
    let first = stdout(&seeds(&host, &run));
    assert!(first.contains("\"scene\":\"asmgcs\""), "what a newcomer sees: {first}");
    let summary = stdout(&seeds(&host, &[&["run", "zurich"], &run[1..]].concat()));
    assert!(summary.contains("\"digest\""), "{summary}");

    // An own scene names what ships as the shipped scene does, and gives the same bits.
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let scene = std::fs::read_to_string(root.join("scenarios/zurich.toml")).expect("the scene");
    std::fs::write(host.join("elsewhere/mine.toml"), scene).expect("written");
    let mine = stdout(&seeds(&host, &[&["run", "mine.toml"], &run[1..]].concat()));
    let digest = |summary: &str| {
        let after = summary.split("\"digest\":\"").nth(1).expect("a digest");
        after.split('"').next().map(ToOwned::to_owned)
    };
    assert_eq!(digest(&summary), digest(&mine));

    // A file beside the scene comes before the one inside the executable.
    std::fs::write(host.join("elsewhere/types.csv"), "designator,kind\n").expect("written");
    let other = seeds(&host, &["plan", "mine.toml"]);
    let words = String::from_utf8_lossy(&other.stderr).into_owned();
    assert_eq!(other.status.code(), Some(2), "{words}");

    let unknown = seeds(&host, &["plan", "paris"]);
    let words = String::from_utf8_lossy(&unknown.stderr).into_owned();
    assert!(unknown.status.code() == Some(2) && words.contains("zurich"), "{words}");
    std::fs::remove_dir_all(&host).expect("cleaned up");
}

#[test]
fn the_version_names_the_sources_that_decide_results() {
    for executable in [env!("CARGO_BIN_EXE_seeds"), env!("CARGO_BIN_EXE_smdfm")] {
        let output = Command::new(executable).arg("--version").output().expect("it starts");
        let text = stdout(&output);
        assert!(text.contains(env!("CARGO_PKG_VERSION")), "{text}");
        let sources = text.split("sources ").nth(1).and_then(|t| t.split(')').next());
        let hexadecimal = |s: &str| s.len() == 16 && u64::from_str_radix(s, 16).is_ok();
        assert!(sources.is_some_and(hexadecimal), "{text}");
        assert!(text.contains("commit "), "{text}");
    }
}
