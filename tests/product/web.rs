//! The laws of the page's own modules, run by Node where it is there.

use std::path::Path;
use std::process::Command;

#[test]
fn the_modules_of_the_page_keep_their_laws() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("federates/viewer_logger/web_tests");
    let files: Vec<_> = std::fs::read_dir(&folder)
        .expect("the folder")
        .flatten()
        .map(|e| e.path())
        .filter(|p| p.to_string_lossy().ends_with(".test.js"))
        .collect();
    assert!(files.len() >= 5, "a cut checkout tests nothing");
    match Command::new("node").arg("--test").args(&files).output() {
        Ok(done) => {
            let told = String::from_utf8_lossy(&done.stdout);
            assert!(done.status.success(), "{told}\n{}", String::from_utf8_lossy(&done.stderr));
        }
        Err(error) => skipped(&error),
    }
}

#[expect(clippy::print_stderr, reason = "a skipped test says so")]
fn skipped(error: &std::io::Error) {
    eprintln!("skipped: node is not installed ({error})");
}
