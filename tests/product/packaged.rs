//! The release archive and the Debian package, each tried on a root that holds nothing but the C library.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn words(output: &Output) -> String {
    format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    )
}

fn done(command: &mut Command) -> String {
    let output = command.output().expect("it starts");
    assert!(output.status.success(), "{command:?}: {}", words(&output));
    words(&output)
}

fn has(tool: &str, argument: &str) -> bool {
    Command::new(tool).arg(argument).output().is_ok_and(|o| o.status.success())
}

/// Copies the libraries that an executable is linked against to the same places below `root`.
fn libraries(executable: &Path, root: &Path) {
    let listed = done(Command::new("ldd").arg(executable));
    for path in listed.split_whitespace().filter(|w| w.starts_with('/')) {
        let to = root.join(path.trim_start_matches('/'));
        std::fs::create_dir_all(to.parent().expect("a folder")).expect("made");
        std::fs::copy(path, to).expect("copied");
    }
}

/// Runs the shipped scene for two seconds in the root and nowhere else: no `/proc`, no `/dev`, no file but its own.
fn runs_alone(root: &Path, executable: &str) {
    let mut command = Command::new("chroot");
    command.arg(root).arg(executable);
    command.args(["run", "--in-process", "--fast", "--no-viewer", "--duration", "2"]);
    let said = done(&mut command);
    assert!(said.contains("\"digest\""), "{said}");
}

#[test]
fn archive_and_debian_package_run_on_an_empty_root() {
    let built = Path::new(env!("CARGO_BIN_EXE_seeds")).parent().expect("a folder").to_path_buf();
    let folder: PathBuf =
        std::env::temp_dir().join(format!("seeds-package-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("made");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("package");
    let said = done(Command::new(&script).arg("--from").arg(&built).arg("--to").arg(&folder));
    let made: Vec<PathBuf> = said.lines().map(PathBuf::from).filter(|p| p.is_file()).collect();
    let of = |end: &str| made.iter().find(|p| p.to_string_lossy().ends_with(end));
    let archive = of(".tar.gz").expect("an archive");
    done(
        Command::new("sha256sum")
            .arg("-c")
            .args(["--quiet"])
            .arg(sums(&folder))
            .current_dir(&folder),
    );

    let (unpacked, installed) = (folder.join("unpacked"), folder.join("installed"));
    std::fs::create_dir_all(&unpacked).expect("made");
    done(
        Command::new("tar")
            .arg("-xzf")
            .arg(archive)
            .arg("-C")
            .arg(&unpacked)
            .arg("--strip-components=1"),
    );
    for name in ["bin/seeds", "bin/smdfm", "LICENSE-MIT", "completions/seeds.bash"] {
        assert!(unpacked.join(name).is_file(), "{name} is in the archive");
    }
    if let Some(package) = of(".deb") {
        done(Command::new("dpkg-deb").arg("--extract").arg(package).arg(&installed));
        let fields = done(Command::new("dpkg-deb").arg("--field").arg(package));
        assert!(fields.contains("Depends: libc6 (>= 2."), "{fields}");
    }
    // Only a process of root may have a root of its own.
    if !nix::unistd::geteuid().is_root() || !has("chroot", "--version") {
        eprintln!("skipped: running on an empty root needs root and chroot");
    } else {
        libraries(Path::new(env!("CARGO_BIN_EXE_seeds")), &unpacked);
        runs_alone(&unpacked, "/bin/seeds");
        if installed.is_dir() {
            libraries(Path::new(env!("CARGO_BIN_EXE_seeds")), &installed);
            runs_alone(&installed, "/usr/bin/seeds");
        }
    }
    std::fs::remove_dir_all(&folder).expect("cleaned up");
}

fn sums(folder: &Path) -> PathBuf {
    let mut all = std::fs::read_dir(folder).expect("made").flatten().map(|e| e.path());
    all.find(|p| p.extension().is_some_and(|e| e == "sha256")).expect("sums")
}

#[test]
fn an_executable_that_is_not_there_is_said() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("package");
    let output = Command::new(script).args(["--from", "/nowhere"]).output().expect("it starts");
    assert_eq!(output.status.code(), Some(2), "{}", words(&output));
    assert!(words(&output).contains("/nowhere/seeds: not there"), "{}", words(&output));
}
