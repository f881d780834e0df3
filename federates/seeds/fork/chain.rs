//! What a `fork.toml` says, and from fork to fork back to the run that was recorded.

use super::super::open::RUNS;
use super::{Change, name_of};
use crate::runtime::messages::Frame;
use crate::viewer_logger::archive::Archive;
use crate::viewer_logger::named;
use crate::viewer_logger::opened;
use anyhow::{Context, bail, ensure};
use std::path::{Path, PathBuf};
use toml::Value;

/// Changes that begin together: with the fork, or at a frame of their own.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fragment {
    pub(super) at: Option<Frame>,
    pub(super) changes: Vec<Change>,
}

/// A `fork.toml`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Told {
    parent: String,
    /// Empty where the parent was going on.
    parent_digest: String,
    scene_digest: String,
    pub(super) at: Frame,
    pub(super) until: Option<Frame>,
    pub(super) name: String,
    /// Those of the fork's own frame first.
    pub(super) fragments: Vec<Fragment>,
}

impl Told {
    /// Reads the file.
    pub(super) fn read(file: &Path) -> anyhow::Result<Self> {
        let text =
            std::fs::read_to_string(file).with_context(|| format!("reading {}", file.display()))?;
        Self::of(&text).with_context(|| format!("{}: not a file of a fork", file.display()))
    }

    fn of(text: &str) -> anyhow::Result<Self> {
        let root: toml::Table = text.parse()?;
        let fork = root.get("fork").and_then(Value::as_table).context("[fork] is missing")?;
        let version = fork.get("version").and_then(Value::as_integer);
        ensure!(version == Some(1), "[fork] version = 1 is read, not {version:?}");
        let word = |key: &str| fork.get(key).and_then(Value::as_str).unwrap_or("").to_owned();
        let parent = word("parent");
        ensure!(!parent.is_empty(), "[fork] parent is missing");
        let at = frame(fork, "at_frame")?.context("[fork] at_frame is missing")?;
        let name = name_of(&word("name")).map_err(anyhow::Error::msg)?;
        let mut fragments = vec![Fragment { at: None, changes: Vec::new() }];
        let changes = root.get("change").and_then(Value::as_array).cloned().unwrap_or_default();
        for (number, change) in changes.iter().enumerate() {
            let doing = || format!("[[change]] {}", number + 1);
            let table = change.as_table().with_context(doing)?;
            let key = table.get("key").and_then(Value::as_str);
            let key = key.context("key is missing").with_context(doing)?;
            let value = table.get("value").context("value is missing").with_context(doing)?;
            let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            let from = frame(table, "at_frame").with_context(doing)?.filter(|f| *f != at);
            let change = (key.to_owned(), value);
            match fragments.iter_mut().find(|f| f.at == from) {
                Some(fragment) => fragment.changes.push(change),
                None => fragments.push(Fragment { at: from, changes: vec![change] }),
            }
        }
        Ok(Self {
            parent,
            parent_digest: word("parent_digest"),
            scene_digest: word("scene_digest"),
            at,
            until: frame(fork, "until_frame")?,
            name,
            fragments,
        })
    }

    /// Whether a run is the one that was forked.
    fn accepts(&self, file: &Path, parent: &Path) -> anyhow::Result<()> {
        let archive = Archive::open(parent)?;
        for (what, wanted) in
            [("digest", &self.parent_digest), ("scene_digest", &self.scene_digest)]
        {
            let found = archive.fact(what).unwrap_or_default();
            if !wanted.is_empty() && !found.is_empty() && found != *wanted {
                bail!(
                    "{}: the fork was made of a run with {what} {wanted}, and {} has {found}: it is another run",
                    file.display(),
                    parent.display()
                );
            }
        }
        Ok(())
    }
}

fn frame(table: &toml::Table, key: &str) -> anyhow::Result<Option<Frame>> {
    let Some(value) = table.get(key) else { return Ok(None) };
    let number = value.as_integer().and_then(|n| Frame::try_from(n).ok());
    number.map(Some).with_context(|| format!("{key}: {value} is not a number of a frame"))
}

/// The database of the run that a `fork.toml` was made of: two folders above it, else in `runs`.
pub(super) fn parent_of(file: &Path, told: &Told) -> anyhow::Result<PathBuf> {
    let whole = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
    let forks = whole.parent().and_then(Path::parent).filter(|f| f.ends_with("forks"));
    let above = forks.and_then(Path::parent).map(Path::to_owned);
    let places = above.into_iter().chain([Path::new(RUNS).join(&told.parent)]);
    for folder in places {
        let files = std::fs::read_dir(&folder).into_iter().flatten().flatten().map(|e| e.path());
        let mut files: Vec<PathBuf> =
            files.filter(|f| f.extension().is_some_and(|e| e == "sqlite")).collect();
        files.sort();
        if let Some(found) = files.into_iter().find(|f| opened::id_of(f) == told.parent) {
            told.accepts(file, &found)?;
            return Ok(found);
        }
    }
    bail!(
        "{}: its parent '{}' is gone: it is neither two folders above nor in {RUNS}/",
        file.display(),
        told.parent
    )
}

/// A recorded run, and what forks changed on the way to another one.
pub(super) struct Chain {
    /// Of the recorded run.
    pub(super) database: PathBuf,
    pub(super) recording: PathBuf,
    /// What forks changed, the first one's first: frame, parent, keys with values.
    pub(super) forks: Vec<(Frame, String, Vec<Change>)>,
    /// Where the last fork ends.
    pub(super) until: Option<Frame>,
}

impl Chain {
    /// Of a run, forked or not.
    pub(super) fn of(database: &Path) -> anyhow::Result<Self> {
        let (mut at, mut forks, mut until) = (database.to_owned(), Vec::<Vec<_>>::new(), None);
        for depth in 0..MOST {
            let recording = named::recording_of(&at);
            if recording.is_file() {
                forks.reverse();
                let forks = forks.into_iter().flatten().collect();
                return Ok(Self { database: at, recording, forks, until });
            }
            let file = at.with_file_name("fork.toml");
            ensure!(
                file.is_file() && at.file_name().is_some_and(|n| n == "run.sqlite"),
                "{}: there is neither a recording nor a fork.toml beside this database, and a fork is made of one",
                at.display()
            );
            let told = Told::read(&file)?;
            at = parent_of(&file, &told)?;
            if depth == 0 {
                until = told.until;
            }
            let of = |f: Fragment| (f.at.unwrap_or(told.at), told.parent.clone(), f.changes);
            forks.push(told.fragments.clone().into_iter().map(of).collect::<Vec<_>>());
        }
        bail!("{}: a fork of {MOST} forks, one of the other", database.display())
    }
}

/// Forks of forks that are followed.
const MOST: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = r#"
[fork]
version = 1
parent = "2026-11-22T08-50-46Z"
parent_digest = "7869ab60c19bc127"
scene_digest = "71a0e704c7a8fb76"
at_frame = 2600
until_frame = 12000
name = "asde-off"
made = 2026-11-22T10:12:00Z
version_of_seeds = "0.1"
[[change]]
key = "sensor[ASDE tower].enabled"
value = false
was = true
[[change]]
key = "weather.rain_factor"
value = 2.5
at_frame = 3000
[[change]]
key = "tracking.filter"
value = "abg"
"#;

    #[test]
    fn a_file_of_a_fork_says_what_changes_and_from_when_on() {
        let told = Told::of(FILE).expect("sound");
        assert_eq!((told.at, told.until, &told.name[..]), (2600, Some(12000), "asde-off"));
        let change = |key: &str, value: &str| (key.to_owned(), value.to_owned());
        let own = [change("sensor[ASDE tower].enabled", "false"), change("tracking.filter", "abg")];
        assert_eq!(
            told.fragments,
            [
                Fragment { at: None, changes: own.to_vec() },
                Fragment { at: Some(3000), changes: vec![change("weather.rain_factor", "2.5")] },
            ]
        );
        for (part, by, says) in [
            ("version = 1", "version = 2", "version = 1 is read"),
            ("parent = \"2026-11-22T08-50-46Z\"", "", "parent is missing"),
            ("at_frame = 2600", "", "at_frame is missing"),
            ("at_frame = 2600", "at_frame = -1", "not a number of a frame"),
            ("name = \"asde-off\"", "name = \"../x\"", "not a name"),
            ("value = false", "", "value is missing"),
            ("at_frame = 3000", "at_frame = 1.5", "not a number of a frame"),
        ] {
            let text = FILE.replacen(part, by, 1);
            assert_ne!(text, FILE, "{part}");
            let said = Told::of(&text).map_err(|e| format!("{e:#}"));
            assert!(said.as_ref().is_err_and(|e| e.contains(says)), "{by}: {said:?}");
        }
    }
}
