//! A finished run: its log against what the page is shown, and what if, from here.

use federates::viewer_logger::archive::Archive;
use federates::viewer_logger::source::Source;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("seeds-views-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a temporary folder");
        Self(path)
    }

    fn seeds(&self, arguments: &[&str]) -> Output {
        let seeds = Command::new(env!("CARGO_BIN_EXE_seeds"))
            .args(arguments)
            .current_dir(&self.0)
            .output()
            .expect("seeds starts");
        assert!(
            seeds.status.success(),
            "{arguments:?}: {}",
            String::from_utf8_lossy(&seeds.stderr)
        );
        seeds
    }

    fn run(&self) -> PathBuf {
        let ended = self.seeds(&["run", "--fast", "--duration", "90", "--page", "127.0.0.1:0"]);
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        let last = said.lines().last().expect("a line");
        let folder = last.strip_prefix("seeds open ").unwrap_or_else(|| panic!("{said}"));
        self.0.join(folder)
    }

    fn fork(&self, run: &Path, more: &[&str]) -> Archive {
        let run = run.to_str().expect("a name");
        let said = self.seeds(&[&["fork", run][..], more].concat());
        let line = String::from_utf8_lossy(&said.stdout).into_owned();
        let folder = line.trim().rsplit(' ').next().expect("a folder").to_owned();
        open(Path::new(&folder))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).ok();
    }
}

fn open(folder: &Path) -> Archive {
    Archive::open(&folder.join("run.sqlite")).expect("a database")
}

/// Scans whose frames differ, the flags aside.
fn different(a: &Archive, b: &Archive) -> Vec<u64> {
    let frame = |archive: &Archive, scan| {
        let mut octets = archive.message(scan).expect("a frame");
        octets[5] = 0;
        octets
    };
    assert_eq!(a.range(), b.range());
    let (first, last) = a.range().expect("scans");
    (first..=last).filter(|scan| frame(a, *scan) != frame(b, *scan)).collect()
}

#[test]
fn a_fork_is_its_parent_until_it_begins_and_what_changed_after() {
    let folder = Folder::new("fork");
    let run = folder.run();
    let parent = open(&run);
    assert_eq!(parent.range(), Some((1, 90)), "every scan is kept");
    assert!(different(&parent, &folder.fork(&run, &["--at", "40"])).is_empty(), "nothing changed");
    for (what, change) in [
        ("a sensor off", "sensor[ASDE tower].enabled=false"),
        ("another filter", "tracking.filter=imm3"),
        ("rain", "weather.rain_factor=3"),
        ("another seed", "run.sensor_seed=77"),
    ] {
        let fork = folder.fork(&run, &["--at", "40", "--set", change]);
        let first = different(&parent, &fork).first().copied();
        match what {
            "rain" => assert_eq!(first, None, "it is dry until 200 s"),
            _ => assert!(first.is_some_and(|n| n > 40 && n < 60), "{what}: from scan {first:?} on"),
        }
        assert!(fork.events().iter().any(|e| e.kind == "fork" && e.time_ns == 40_000_000_000));
    }
    let refused = Command::new(env!("CARGO_BIN_EXE_seeds"))
        .args(["fork", run.to_str().expect("a name"), "--at", "4000"])
        .output()
        .expect("seeds starts");
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("lasts from 0 to 90"));
}
