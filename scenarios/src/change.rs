//! A scene with some of its values changed, as `seeds fork` does: `tracking.filter = "abg"`, `sensor[NAME].range_max_m = 3000`.

use crate::{ScenarioError, Scene, TruthOf, read};
use std::path::Path;
use toml::{Table, Value};

/// Why a scene cannot be changed so.
#[derive(Debug, thiserror::Error)]
pub enum ChangeError {
    /// The key does not name a place in the scene.
    #[error("{key}: {reason}")]
    Key {
        /// As given.
        key: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The changed scene is not sound.
    #[error(transparent)]
    Scene(#[from] ScenarioError),
}

/// The scene of `text`, which would stand at `path`, with the values of `changes` in place of its own: without movements,
/// as [`crate::load_without_truth`]. Values are TOML; what is not is a text.
///
/// # Errors
/// If a key names nothing, or the scene is refused with the value.
pub fn load_changed(
    path: &Path,
    text: &str,
    changes: &[(String, String)],
) -> Result<Scene, ChangeError> {
    if changes.is_empty() {
        return Ok(read(path, text, TruthOf::Nobody)?);
    }
    let mut root: Table = match text.parse() {
        Ok(root) => root,
        // Says where, with the line of the text itself.
        Err(_) => return Ok(read(path, text, TruthOf::Nobody)?),
    };
    for (key, value) in changes {
        let refuse = |reason: String| ChangeError::Key { key: key.clone(), reason };
        set(&mut root, key, value_of(value)).map_err(refuse)?;
    }
    let changed = toml::to_string(&root)
        .map_err(|e| ChangeError::Key { key: changes[0].0.clone(), reason: e.to_string() })?;
    Ok(read(path, &changed, TruthOf::Nobody)?)
}

/// The value now at a key, as TOML; none where the scene leaves it to the default.
#[must_use]
pub fn value_at(text: &str, key: &str) -> Option<String> {
    let mut root: Table = text.parse().ok()?;
    let (table, last) = place(&mut root, key).ok()?;
    table.get(&last).map(ToString::to_string)
}

fn value_of(text: &str) -> Value {
    let line = format!("v = {text}");
    let parsed = line.parse::<Table>().ok().and_then(|mut t| t.remove("v"));
    parsed.unwrap_or_else(|| Value::String(text.to_owned()))
}

fn set(root: &mut Table, key: &str, value: Value) -> Result<(), String> {
    let (table, last) = place(root, key)?;
    table.insert(last, value);
    Ok(())
}

/// The table that holds a key, and the key's last part.
fn place<'a>(root: &'a mut Table, key: &str) -> Result<(&'a mut Table, String), String> {
    let parts = parts_of(key)?;
    let Some(((last, None), path)) = parts.split_last().map(|(l, p)| (l.clone(), p)) else {
        return Err("names a list, not one of its values".to_owned());
    };
    let mut table = root;
    for (name, of) in path {
        let at = table.entry(name.clone()).or_insert_with(|| Value::Table(Table::new()));
        table = match (at, of) {
            (Value::Table(inside), None) => inside,
            (Value::Array(list), Some(wanted)) => {
                let known: Vec<String> = list
                    .iter()
                    .filter_map(|v| v.get("name").and_then(Value::as_str).map(str::to_owned))
                    .collect();
                list.iter_mut()
                    .filter_map(Value::as_table_mut)
                    .find(|t| t.get("name").and_then(Value::as_str) == Some(wanted))
                    .ok_or_else(|| {
                        format!("there is no {name} '{wanted}'; there are {}", known.join(", "))
                    })?
            }
            (Value::Array(_), None) => {
                return Err(format!("say which {name}: {name}[NAME].KEY"));
            }
            _ => return Err(format!("{name} is not a section of the scene")),
        };
    }
    Ok((table, last))
}

type Part = (String, Option<String>);

/// `sensor[ASDE tower].range_max_m` as (sensor, ASDE tower), (`range_max_m`, none).
fn parts_of(key: &str) -> Result<Vec<Part>, String> {
    let mut parts = Vec::new();
    let mut rest = key;
    while !rest.is_empty() {
        let end = rest.find(['.', '[']).unwrap_or(rest.len());
        let name = rest[..end].trim();
        if name.is_empty() {
            return Err("is not a key like tracking.filter or sensor[NAME].range_max_m".to_owned());
        }
        let mut of = None;
        rest = &rest[end..];
        if let Some(inside) = rest.strip_prefix('[') {
            let close = inside.find(']').ok_or("a ] is missing")?;
            of = Some(inside[..close].to_owned());
            rest = &inside[close + 1..];
        }
        parts.push((name.to_owned(), of));
        match rest.strip_prefix('.') {
            Some(more) if !more.is_empty() => rest = more,
            None if rest.is_empty() => {}
            _ => return Err("is not a key like tracking.filter".to_owned()),
        }
    }
    if parts.len() < 2 { Err("names a whole section, not a value".to_owned()) } else { Ok(parts) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn zurich() -> (std::path::PathBuf, String) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("zurich.toml");
        let text = std::fs::read_to_string(&path).expect("the scene");
        (path, text)
    }

    #[test]
    fn a_changed_scene_has_the_value_and_an_unchanged_one_is_the_same() {
        let (path, text) = zurich();
        let same = load_changed(&path, &text, &[]).expect("sound");
        assert_eq!(same, crate::load_without_truth(&path).expect("sound"));
        let change = [("tracking.filter".to_owned(), "abg".to_owned())];
        let changed = load_changed(&path, &text, &change).expect("sound");
        assert_eq!(changed.tracking.config.filter.rung.name(), "abg");
        assert_ne!(changed.hash, same.hash);
        assert_eq!(changed.traffic.entities.len(), same.traffic.entities.len());
    }

    #[test]
    fn a_bad_key_is_refused_with_what_there_is() {
        let (path, text) = zurich();
        for (key, value, part) in [
            ("tracking.filtr", "abg", "filter"),
            ("sensor[X].range_max_m", "1", "there are"),
            ("sensor.range_max_m", "1", "say which sensor"),
            ("run", "1", "whole section"),
            ("", "1", "whole section"),
            ("a..b", "1", "is not a key"),
            ("sensor[X", "1", "missing"),
            ("tracking.filter", "nonsense", "nonsense"),
        ] {
            let said = load_changed(&path, &text, &[(key.to_owned(), value.to_owned())])
                .expect_err(key)
                .to_string();
            assert!(said.contains(part) && !said.contains('\n'), "{key}: {said}");
        }
    }
}
