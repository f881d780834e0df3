//! What an executable says of its own making (the commit, a hash over the sources that decide results), and the page that it carries.

use std::path::{Path, PathBuf};
use std::process::Command;

/// What decides the bits of a run: two builds with equal hashes here give equal digests.
const DECIDING: [&str; 16] = [
    "Cargo.lock",
    "geodesy/src",
    "pdu/src",
    "asterix/src",
    "mode_s/src",
    "models/src",
    "scenarios/src",
    "federates/federation.rs",
    "federates/take_over.rs",
    "federates/exchange",
    "federates/runtime",
    "federates/traffic_generator",
    "federates/external_world",
    "federates/smdfm",
    "federates/control",
    "federates/visitors",
];

fn main() {
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("set by cargo"));
    let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
    for place in DECIDING {
        println!("cargo:rerun-if-changed={place}");
        feed(&root, &root.join(place), &mut hash);
    }
    list_page(&root);
    println!("cargo:rustc-env=SEEDS_SOURCES={:016x}", hash.0);
    println!(
        "cargo:rustc-env=SEEDS_COMMIT={}",
        commit(&root).unwrap_or_else(|| "unknown".to_owned())
    );
}

/// The files of the page as an array of path and octets, for `include!`.
fn list_page(root: &Path) {
    let web = root.join("federates/viewer_logger/web");
    println!("cargo:rerun-if-changed={}", web.display());
    let mut files = Vec::new();
    let mut folders = vec![web.clone()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder of the page").flatten() {
            match entry.path() {
                path if path.is_dir() => folders.push(path),
                path => files.push(path),
            }
        }
    }
    files.sort();
    let row = |path: &PathBuf| {
        let name = path.strip_prefix(&web).unwrap_or(path).to_string_lossy().replace('\\', "/");
        format!("    ({name:?}, include_bytes!({:?}) as &[u8]),\n", path.display().to_string())
    };
    let text = format!("&[\n{}]\n", files.iter().map(row).collect::<String>());
    let out = PathBuf::from(std::env::var("OUT_DIR").expect("set by cargo"));
    std::fs::write(out.join("web_files.rs"), text).expect("written");
}

/// The commit that is checked out, and word to cargo to look again after the next one.
fn commit(root: &Path) -> Option<String> {
    let git = |args: &[&str]| {
        let output = Command::new("git").current_dir(root).args(args).output().ok()?;
        let text = String::from_utf8(output.stdout).ok()?;
        output.status.success().then(|| text.trim().to_owned())
    };
    // A package unpacked inside another repository is not of that repository.
    let top = PathBuf::from(git(&["rev-parse", "--show-toplevel"])?);
    if top.canonicalize().ok()? != root.canonicalize().ok()? {
        return None;
    }
    let log = root.join(git(&["rev-parse", "--git-path", "logs/HEAD"])?);
    if log.exists() {
        println!("cargo:rerun-if-changed={}", log.display());
    }
    git(&["rev-parse", "--short=10", "HEAD"])
}

fn feed(root: &Path, path: &Path, hash: &mut Fnv) {
    if path.is_dir() {
        let entries = std::fs::read_dir(path).expect("a folder of sources");
        let mut inside: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
        inside.sort();
        for path in inside {
            feed(root, &path, hash);
        }
    } else if let Ok(octets) = std::fs::read(path) {
        let name = path.strip_prefix(root).unwrap_or(path).to_string_lossy().into_owned();
        for part in [name.as_bytes(), &octets] {
            hash.write(&(part.len() as u64).to_le_bytes());
            hash.write(part);
        }
    }
}

/// FNV-1a, 64 bits.
struct Fnv(u64);

impl Fnv {
    fn write(&mut self, octets: &[u8]) {
        for octet in octets {
            self.0 = (self.0 ^ u64::from(*octet)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}
