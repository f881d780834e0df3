//! The tables of keys: the reference is made of them and is current, and their limits are the reader's own.

use models::keys::{Holds, Key};
use scenarios::keys::TABLES;
use scenarios::{load_text, reference};
use std::path::{Path, PathBuf};

fn zurich() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("zurich.toml")
}

#[test]
fn the_reference_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/scene.md");
    let made = reference::markdown();
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        std::fs::write(&path, &made).expect("written");
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(kept == made, "docs/scene.md is old: seeds scene doc > docs/scene.md");
}

/// A scene in which every table of numbers is there once; `KEY` lines are put in by the test.
const BASE: &str = r#"
[run]
title = "keys"
start = 2019-11-24T09:00:00Z
duration_s = 600
dead_reckoning = { algorithm = "rvw" }
heartbeat = { moving_s = 5 }
[airport]
layout = "airports/LSZH.apt.dat"
ground_network = "airports/LSZH.groundnet.xml"
reference = { lat_deg = 47.458, lon_deg = 8.548, height_m = 432 }
tower = { place = { east_m = 10, north_m = 20 }, cab_height_m = 30 }
[weather]
timeline = [{ at_s = 0, wind_mps = 1, wind_from_deg = 10, cells = [{ east_m = 0, north_m = 0, radius_m = 10, rain_mm_per_h = 1 }] }]
[[traffic]]
kind = "recorded"
callsign = "EDW229"
type = "A320"
file = "movements/EDW229.csv"
start_s = 10
flight = { movement = "arrival" }
[[building]]
name = "b"
footprint = [{ east_m = 0, north_m = 0 }, { east_m = 50, north_m = 0 }, { east_m = 50, north_m = 50 }]
height_m = 10
[[board]]
name = "p"
place = { x_m = 10, y_m = 20 }
centre_height_m = 12
size_m = 3
luminance_ratio = 0.5
[tracking]
confirm_of = 32
identified_of = 32
association = "joint"
[accuracy]
position_m = 0.1
[network]
ttl = 1
[external]
adsb = { from = "truth" }
[[external.asterix]]
to = "127.0.0.1:8600"
[[external.asterix_in]]
listen = "127.0.0.1:8601"
reference = { lat_deg = 47, lon_deg = 8, height_m = 432 }
[control]
policy = "free"
seats = { ground = "model" }
"#;

/// Where a table of keys stands in [`BASE`].
fn set(root: &mut toml::Table, path: &[&str], word: &str, value: toml::Value) -> bool {
    let Some((first, rest)) = path.split_first() else {
        root.insert(word.to_owned(), value);
        return true;
    };
    match root.get_mut(*first) {
        Some(toml::Value::Table(table)) => set(table, rest, word, value),
        Some(toml::Value::Array(list)) => match list.first_mut() {
            Some(toml::Value::Table(table)) => set(table, rest, word, value),
            _ => false,
        },
        _ => false,
    }
}

fn error_of(path: &[&str], word: &str, value: toml::Value) -> Option<String> {
    let mut root: toml::Table = BASE.parse().expect("TOML");
    assert!(set(&mut root, path, word, value), "{path:?} is not in the base scene");
    load_text(&zurich(), &root.to_string()).err().map(|e| e.to_string())
}

/// Words of keys that the base scene does not get to: kinds of traffic are read one by one, buildings need a facade.
const SKIPPED: [&str; 2] = ["kind", "profile"];

fn check(path: &[&'static str], keys: &'static [Key], counted: &mut usize) {
    for key in keys {
        let beyond: Vec<(toml::Value, String)> = match key.holds {
            Holds::Number { least, most } => {
                [(least, least - 1.0 - least.abs()), (most, most * 2.0 + 1.0)]
                    .into_iter()
                    .filter(|(limit, _)| limit.is_finite())
                    .map(|(limit, value)| (toml::Value::Float(value), format!("{limit}")))
                    .collect()
            }
            Holds::Whole { least, most } => [(least, least - 1), (most, most.saturating_add(1))]
                .into_iter()
                .filter(|(limit, value)| limit != value)
                .map(|(limit, value)| (toml::Value::Integer(value), format!("{limit}")))
                .collect(),
            Holds::Word(words) if !SKIPPED.contains(&key.word) => {
                let magic = toml::Value::String("magic".into());
                let error = error_of(path, key.word, magic).unwrap_or_default();
                let own: Vec<String> = words().iter().map(|word| format!("\"{word}\"")).collect();
                let end = format!("allowed is {}", own.join(", "));
                assert!(
                    error.ends_with(&end),
                    "{}.{}: {error}, not {end}",
                    path.join("."),
                    key.word
                );
                *counted += 1;
                continue;
            }
            Holds::Table(inner) | Holds::Tables(inner) if !inner.is_empty() => {
                // Halts and shares are of kinds that the base scene has not.
                if key.word != "halts" {
                    check(&[path, &[key.word]].concat(), inner, counted);
                }
                continue;
            }
            _ => continue,
        };
        if path == ["traffic"]
            && (scenarios::keys::GENERATED.contains(&key.word) || key.word == "count")
            && key.word != "kind"
        {
            continue;
        }
        for (value, limit) in beyond {
            let shown = format!("{}.{} = {value}", path.join("."), key.word);
            let error =
                error_of(path, key.word, value).unwrap_or_else(|| panic!("{shown} is read"));
            let allowed = error.split("allowed is ").nth(1);
            let allowed = allowed.unwrap_or_else(|| panic!("{shown}: {error}"));
            assert!(error.contains(key.word), "{shown}: {error}");
            assert!(
                allowed.split([' ', '\n']).any(|w| w == limit),
                "{shown}: {error} is not {limit}"
            );
            assert!(allowed.contains(key.unit), "{shown}: {error} is not in {}", key.unit);
            *counted += 1;
        }
    }
}

#[test]
fn every_limit_of_the_tables_is_the_readers_own() {
    assert_eq!(
        error_of(&["run"], "seed", toml::Value::Integer(3)),
        None,
        "the base scene is sound"
    );
    let mut counted = 0;
    for table in TABLES.iter().filter(|t| !["sensor", "failure", "shape"].contains(&t.word)) {
        check(&[table.word], table.keys, &mut counted);
    }
    assert!(counted > 100, "{counted} limits");
}

#[test]
fn every_key_has_its_line() {
    for table in TABLES {
        let mut words: Vec<&str> = table.keys.iter().map(|key| key.word).collect();
        for key in table.keys {
            assert!(key.doc.len() > 5 && !key.doc.ends_with('.'), "{}.{}", table.word, key.word);
        }
        words.sort_unstable();
        words.dedup();
        assert_eq!(words.len(), table.keys.len(), "a key twice in {}", table.word);
    }
}
