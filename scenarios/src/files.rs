//! Where the files of a scene are: on disk, or inside the executable.
//!
//! What ships with SEEDS is compiled in, so that an executable copied anywhere runs its scenes. Such a
//! file has a path that begins with [`SHIPPED`], like `shipped:/airports/LSZH.apt.dat`; everything
//! that reads a scene reads both kinds through [`read`].

use flate2::read::DeflateDecoder;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

/// First part of the path of a file that is inside the executable.
pub const SHIPPED: &str = "shipped:";

/// Name below `scenarios/` and deflated content of every file that ships, sorted by name.
const FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/shipped.rs"));

/// The path of a shipped file, by its name below `scenarios/`.
#[must_use]
pub fn shipped(name: &str) -> PathBuf {
    Path::new(SHIPPED).join(name)
}

/// Name below `scenarios/`, where `path` is inside the executable. A scene may say `../x`: so does the name, and nothing is found.
fn inside(path: &Path) -> Option<&Path> {
    path.strip_prefix(SHIPPED).ok()
}

/// Deflated.
fn content(name: &Path) -> Option<&'static [u8]> {
    let name = name.to_str()?;
    let at = FILES.binary_search_by(|(known, _)| (*known).cmp(name)).ok()?;
    Some(FILES[at].1)
}

/// A whole file of at most `limit` octets; a device or a pipe may never end.
///
/// # Errors
/// What the system says; for a shipped file that it does not exist.
pub fn read(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let mut octets = Vec::new();
    if let Some(name) = inside(path) {
        let missing = || io::Error::new(io::ErrorKind::NotFound, "does not come with SEEDS");
        DeflateDecoder::new(content(name).ok_or_else(missing)?).read_to_end(&mut octets)?;
        return Ok(octets);
    }
    std::fs::File::open(path)?.take(limit + 1).read_to_end(&mut octets)?;
    if octets.len() as u64 > limit {
        let reason = format!("longer than {} MiB", limit >> 20);
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, reason));
    }
    Ok(octets)
}

/// [`read`] without what spreadsheets add: the byte order mark, and the first half of ends of lines (with which readers of tables miscount
/// them).
///
/// # Errors
/// As [`read`].
pub fn read_table(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let mut octets = read(path, limit)?;
    if octets.starts_with("\u{feff}".as_bytes()) {
        octets.drain(..3);
    }
    let mut kept = 0;
    for i in 0..octets.len() {
        if octets[i] != b'\r' || octets.get(i + 1) != Some(&b'\n') {
            octets[kept] = octets[i];
            kept += 1;
        }
    }
    octets.truncate(kept);
    Ok(octets)
}

/// Lines of the rows of a table. A reader's position is where it began to look for a row: before blank lines, comments and the second half
/// of an end of line, all of which it skips.
#[derive(Clone, Debug)]
pub struct Lines<'a> {
    octets: &'a [u8],
    comments: bool,
    /// First octet of a line, and its number from 1.
    at: usize,
    line: usize,
}

impl<'a> Lines<'a> {
    /// Of what the reader reads, from its first octet on; `comments`: it skips lines that begin with `#`.
    #[must_use]
    pub fn new(octets: &'a [u8], comments: bool) -> Self {
        Self { octets, comments, at: 0, line: 1 }
    }

    /// Line, from 1, of the row or the fault at a position; 1 where there is none.
    pub fn of(&mut self, position: Option<&csv::Position>) -> usize {
        let Some(position) = position else { return 1 };
        let from = usize::try_from(position.byte()).unwrap_or(usize::MAX);
        if from < self.at {
            (self.at, self.line) = (0, 1);
        }
        while let Some((text, length)) = self.next() {
            let skipped = text.is_empty() || self.comments && text.starts_with(b"#");
            if self.at >= from && !skipped {
                break;
            }
            self.at += length;
            self.line += 1;
        }
        self.line
    }

    /// The line that begins here, and its length with its end; `None` for one that does not end.
    fn next(&self) -> Option<(&'a [u8], usize)> {
        let rest = self.octets.get(self.at..)?;
        let end = rest.iter().position(|o| matches!(o, b'\r' | b'\n'))?;
        let two = rest[end..].starts_with(b"\r\n");
        Some((&rest[..end], end + 1 + usize::from(two)))
    }
}

/// [`read`] as UTF-8 text.
///
/// # Errors
/// As [`read`], or if it is not UTF-8.
pub fn read_text(path: &Path, limit: u64) -> io::Result<String> {
    String::from_utf8(read(path, limit)?)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "not UTF-8 text"))
}

/// Whether `path` is a file, on disk or inside the executable.
#[must_use]
pub fn is_file(path: &Path) -> bool {
    inside(path).map_or_else(|| path.is_file(), |name| content(name).is_some())
}

/// Names without their ending of the files `*.toml` directly in `folder`, on disk or inside the executable.
#[must_use]
pub fn toml_names(folder: &Path) -> Vec<String> {
    let files: Vec<PathBuf> = match inside(folder) {
        Some(inside) => FILES
            .iter()
            .map(|(name, _)| PathBuf::from(name))
            .filter(|name| name.parent() == Some(inside))
            .collect(),
        None => std::fs::read_dir(folder)
            .map(|entries| entries.flatten().map(|e| e.path()).collect())
            .unwrap_or_default(),
    };
    files
        .iter()
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()))
        .filter(|name| name != "Cargo")
        .collect()
}

/// Location indicators of the airports that are inside the executable.
#[must_use]
pub fn airports() -> Vec<&'static str> {
    let names =
        FILES.iter().filter_map(|(name, _)| name.strip_prefix("airports/")?.split('.').next());
    let mut names: Vec<&str> = names.filter(|n| n.len() == 4).collect();
    names.dedup();
    names
}

/// The shipped layout of an airport, by its location indicator.
#[must_use]
pub fn layout_of(icao: &str) -> Option<String> {
    let name = icao.to_ascii_uppercase();
    ["apt.dat", "nodes.csv", "osm.json", "geojson"]
        .iter()
        .map(|ending| format!("airports/{name}.{ending}"))
        .find(|file| is_file(&shipped(file)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_file_is_inside_and_the_same() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        assert!(FILES.len() >= 15, "{}", FILES.len());
        assert!(FILES.is_sorted_by_key(|f| f.0), "names are searched by halves");
        for (name, _) in FILES {
            let octets = read(&shipped(name), 1 << 20).expect(name);
            assert!(std::fs::read(root.join(name)).expect(name) == octets, "{name}");
            assert!(is_file(&shipped(name)), "{name}");
        }
        let [deflated, whole] = [
            FILES.iter().map(|f| f.1.len()).sum::<usize>(),
            FILES.iter().map(|f| read(&shipped(f.0), 1 << 20).map_or(0, |o| o.len())).sum(),
        ];
        assert!(4 * deflated < whole, "{deflated} of {whole} octets in every executable");
        for needed in ["zurich.toml", "types.csv", "echo.csv", "airports/LSZH.apt.dat"] {
            assert!(is_file(&shipped(needed)), "{needed}");
        }
        assert!(!FILES.iter().any(|(name, _)| name.ends_with(".rs") || *name == "Cargo.toml"));
    }

    /// Rows of numbered lines with everything between them that a reader skips, and faults of both kinds.
    #[test]
    fn rows_and_faults_have_the_numbers_of_their_lines() {
        let between = ["", "\n", "\n\n", "# a\n", "# a\n\n# \"b\n", "\n#\n"];
        let mut seen = 0;
        for (comments, end) in [(true, "\n"), (true, "\r\n"), (false, "\n"), (false, "\r\n")] {
            for (first, second) in between.iter().flat_map(|a| between.map(|b| (a, b))) {
                for last in ["\n", ""] {
                    let text = format!("{first}a,b\n{second}c,\"d\ne\"\n{first}{second}f,g{last}");
                    let due: Vec<usize> = (1..)
                        .zip(text.lines())
                        .filter(|(_, l)| !(l.is_empty() || comments && l.starts_with('#')))
                        .filter(|(_, l)| !l.starts_with("e\""))
                        .map(|(n, _)| n)
                        .collect();
                    // Where they are rows, marks in them are quotes no longer.
                    if !comments && text.contains("# \"") {
                        continue;
                    }
                    let text = text.replace('\n', end);
                    let mut reader = csv::ReaderBuilder::new()
                        .has_headers(false)
                        .flexible(true)
                        .comment(comments.then_some(b'#'))
                        .from_reader(text.as_bytes());
                    let mut lines = Lines::new(text.as_bytes(), comments);
                    let rows = reader.records().map(|r| r.expect("text"));
                    let found: Vec<usize> = rows.map(|r| lines.of(r.position())).collect();
                    assert_eq!(found, due, "{text:?}");
                    // From the begin again.
                    let mut again = csv::Position::new();
                    assert_eq!(lines.of(Some(again.set_byte(0))), due[0], "{text:?}");
                    seen += found.len();
                }
            }
        }
        assert!(seen > 500, "{seen}");
        assert_eq!(Lines::new(b"a", true).of(None), 1);
    }

    #[test]
    fn what_does_not_ship_is_said_to_be_missing() {
        for wrong in ["paris.toml", "../Cargo.toml", "", "airports"] {
            let error = read(&shipped(wrong), 1 << 20).expect_err(wrong);
            assert_eq!(error.kind(), io::ErrorKind::NotFound, "{wrong}");
        }
        assert_eq!(
            read(Path::new("/dev/zero"), 10).expect_err("endless").kind(),
            io::ErrorKind::FileTooLarge
        );
    }

    #[test]
    fn the_shipped_scenes_are_listed() {
        assert!(toml_names(Path::new(SHIPPED)).contains(&"zurich".to_owned()));
        assert!(toml_names(&shipped("parameter-sets")).contains(&"ku_asde3".to_owned()));
    }
}
