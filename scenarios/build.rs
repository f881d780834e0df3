//! Lists the files that ship with SEEDS, deflated, so that an executable carries them wherever it is copied:
//! scenes, airports, movements, parameter sets, types and echoes (`files.rs` reads the list).

use flate2::{Compression, write::DeflateEncoder};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// What of this folder is program and not data.
const PROGRAM: [&str; 7] =
    ["src", "tests", "examples", "benches", "target", "Cargo.toml", "build.rs"];

fn main() {
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("set by cargo"));
    let mut files = Vec::new();
    for entry in entries(&root) {
        let name = entry.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        if !PROGRAM.contains(&name.as_str()) && !name.starts_with('.') {
            walk(&entry, &mut files);
        }
    }
    // By the whole name, as `files.rs` looks it up: a path is sorted by its parts.
    files.sort_by_key(|file| file.to_string_lossy().into_owned());
    println!("cargo:rerun-if-changed=.");
    let out = PathBuf::from(std::env::var("OUT_DIR").expect("set by cargo"));
    let mut list = String::from("&[\n");
    for (n, file) in files.iter().enumerate() {
        let name = file.strip_prefix(&root).expect("below the root").to_string_lossy().into_owned();
        let deflated = out.join(format!("shipped-{n}"));
        let octets = deflate(&std::fs::read(file).expect("a file that ships"));
        std::fs::write(&deflated, octets).expect("the build folder can be written");
        writeln!(list, "    ({name:?}, include_bytes!({:?})),", deflated.to_string_lossy())
            .expect("a string takes everything");
    }
    list.push_str("]\n");
    std::fs::write(out.join("shipped.rs"), list).expect("the build folder can be written");
}

fn deflate(octets: &[u8]) -> Vec<u8> {
    let mut deflated = DeflateEncoder::new(Vec::new(), Compression::best());
    deflated.write_all(octets).and_then(|()| deflated.finish()).expect("memory takes everything")
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    std::fs::read_dir(folder)
        .map(|list| list.flatten().map(|e| e.path()).collect())
        .unwrap_or_default()
}

fn walk(path: &Path, files: &mut Vec<PathBuf>) {
    if path.is_dir() {
        for entry in entries(path) {
            walk(&entry, files);
        }
    } else {
        files.push(path.to_path_buf());
    }
}
