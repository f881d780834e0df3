//! Names of the files of a run: the database of a recording, the recording of a database, and the logs of later runs.

use rusqlite::{Connection, OpenFlags};
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// What a log of a later run says of itself: the file name of the first one.
pub const FOLLOWS: &str = "follows";

/// Whether a name ends as recordings do.
fn ends_as_recording(path: &Path) -> bool {
    path.extension().is_some_and(|e| e == "pcapng" || e == "pcap")
}

/// Whether a file is a recording, by its name or by its first octets.
#[must_use]
pub fn is_recording(path: &Path) -> bool {
    ends_as_recording(path) || begins_as_recording(path)
}

fn begins_as_recording(path: &Path) -> bool {
    let mut magic = [0; 4];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut magic));
    let known = [0x0a0d_0d0a, 0xa1b2_c3d4, 0xd4c3_b2a1, 0xa1b2_3c4d, 0x4d3c_b2a1];
    read.is_ok() && known.contains(&u32::from_be_bytes(magic))
}

/// The database beside a recording: `x.pcapng` has `x.sqlite`, a name without such an ending (`rate0.1`) is kept whole.
#[must_use]
pub fn database_of(recording: &Path) -> PathBuf {
    if ends_as_recording(recording) {
        return recording.with_extension("sqlite");
    }
    let mut name = recording.as_os_str().to_owned();
    name.push(".sqlite");
    PathBuf::from(name)
}

/// The recording beside a database.
#[must_use]
pub fn recording_of(database: &Path) -> PathBuf {
    let usual = database.with_extension("pcapng");
    let others = ["pcap", ""].map(|ending| database.with_extension(ending));
    let there = |file: &PathBuf| file != database && file.is_file();
    if usual.is_file() { usual } else { others.into_iter().find(there).unwrap_or(usual) }
}

/// Refuses to record into a file that is something else, or into the place of a database.
///
/// # Errors
/// Says which file and why.
pub fn check_recording(path: &Path) -> anyhow::Result<()> {
    anyhow::ensure!(
        path.extension().is_none_or(|e| e != "sqlite"),
        "recording {}: this ending is the database's, which is written beside; name it .pcapng",
        path.display()
    );
    let something = std::fs::metadata(path).is_ok_and(|m| m.is_file() && m.len() > 0);
    anyhow::ensure!(
        !something || begins_as_recording(path),
        "recording {}: this file is there and no recording; it is not replaced",
        path.display()
    );
    Ok(())
}

/// The log of run number `run` of the process whose first log is `first`: `run-2.sqlite`, and where that is another's
/// `run-2_2.sqlite`.
#[must_use]
pub fn following(first: &Path, run: u32) -> PathBuf {
    let mut number = 1;
    loop {
        let file = name_of(first, run, number);
        if !file.exists() || follows(&file, first) {
            return file;
        }
        number += 1;
    }
}

/// The name of the log of run number `run`, of which there are others: `run-2.sqlite`, `run-2_2.sqlite`.
fn name_of(first: &Path, run: u32, number: u32) -> PathBuf {
    let stem = first.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let more = if number == 1 { String::new() } else { format!("_{number}") };
    first.with_file_name(format!("{stem}-{run}{more}.sqlite"))
}

/// The logs of later runs of the process whose first log is `first`, in order; where none says whom it follows (they were written
/// before logs said so), those with their names.
#[must_use]
pub fn later(first: &Path) -> Vec<PathBuf> {
    let of = |run: u32| {
        let names = (1..).map(|number| name_of(first, run, number)).take_while(|f| f.is_file());
        names.into_iter().find(|file| follows(file, first))
    };
    let own: Vec<_> = (2..).map_while(of).collect();
    if own.is_empty() {
        let untold = |file: &PathBuf| file.is_file() && follower(file).is_none();
        return (2..).map(|run| name_of(first, run, 1)).take_while(untold).collect();
    }
    own
}

/// The first log of the process of whose later run this is the log; `None` where it is the first.
#[must_use]
pub fn first_of(log: &Path) -> Option<PathBuf> {
    follower(log).map(|name| log.with_file_name(name))
}

/// Whether a log is of a later run of the process whose first log has this name.
fn follows(log: &Path, first: &Path) -> bool {
    let told = follower(log);
    told.is_some_and(|told| first.file_name().is_some_and(|name| name.to_string_lossy() == told))
}

/// What a log says of whom it follows.
fn follower(log: &Path) -> Option<String> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let told = Connection::open_with_flags(log, flags).and_then(|log| {
        let question = "SELECT value FROM run WHERE name = ?1";
        log.query_row(question, [FOLLOWS], |row| row.get::<_, String>(0))
    });
    told.ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer_logger::log::tests::Folder;

    #[test]
    fn recordings_with_names_of_their_own_have_databases_of_their_own_and_find_back() {
        let folder = Folder::new();
        let names = ["a.pcapng", "b.pcap", "rate0.1", "rate0.5", "plain"];
        let all: std::collections::BTreeSet<_> =
            names.iter().map(|name| database_of(Path::new(name))).collect();
        assert_eq!(all.len(), names.len(), "{all:?}");
        assert!(all.contains(Path::new("a.sqlite")) && all.contains(Path::new("rate0.1.sqlite")));
        for name in ["a.pcapng", "b.pcap", "rate0.1", "plain"] {
            let recording = folder.0.join(name);
            std::fs::write(&recording, [0x0a, 0x0d, 0x0d, 0x0a]).expect("written");
            assert_eq!(recording_of(&database_of(&recording)), recording);
            assert!(is_recording(&recording) && check_recording(&recording).is_ok(), "{name}");
        }
    }

    /// The second run of a process was logged beside a stranger's log of that name, and the stranger's was opened as the second run.
    #[test]
    fn later_runs_are_found_by_what_they_say_and_old_ones_by_their_names() {
        let folder = Folder::new();
        let at = |name: &str| folder.0.join(name);
        let log = |name: &str, of: Option<&str>| {
            let log = Connection::open(at(name)).expect("a file");
            log.execute("CREATE TABLE run (name TEXT, value TEXT)", []).expect("a table");
            if let Some(of) = of {
                log.execute("INSERT INTO run VALUES (?1, ?2)", [FOLLOWS, of]).expect("a row");
            }
        };
        log("run.sqlite", None);
        assert!(later(&at("run.sqlite")).is_empty());
        log("run-2.sqlite", None);
        log("run-3.sqlite", None);
        let found = |names: &[&str]| names.iter().map(|n| at(n)).collect::<Vec<_>>();
        assert_eq!(later(&at("run.sqlite")), found(&["run-2.sqlite", "run-3.sqlite"]));
        let second = following(&at("run.sqlite"), 2);
        assert_eq!(second, at("run-2_2.sqlite"));
        log("run-2_2.sqlite", Some("run.sqlite"));
        assert_eq!(following(&at("run.sqlite"), 2), second, "its own of before is replaced");
        assert_eq!(
            later(&at("run.sqlite")),
            std::slice::from_ref(&second),
            "nothing of the strangers"
        );
        assert_eq!(first_of(&second), Some(at("run.sqlite")));
        assert_eq!(first_of(&at("run-2.sqlite")), None);
    }

    /// A text and a database were overwritten.
    #[test]
    fn nothing_but_a_recording_is_recorded_over() {
        let folder = Folder::new();
        let text = folder.0.join("notes.txt");
        assert!(check_recording(&text).is_ok(), "nothing is there");
        std::fs::write(&text, []).expect("written");
        assert!(check_recording(&text).is_ok(), "it is empty");
        std::fs::write(&text, "my letters").expect("written");
        let refused = check_recording(&text).expect_err("a text").to_string();
        assert!(refused.contains("notes.txt") && refused.contains("no recording"), "{refused}");
        assert!(check_recording(&folder.0.join("x.sqlite")).is_err(), "the database's own name");
    }
}
