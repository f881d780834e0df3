//! All that is wrong in a scene, as far as its tables of keys tell it: the reader itself ends at the first error.

use crate::document::{Section, within};
use crate::error::{Problem, ScenarioError};
use crate::keys::{ROOT, TABLES, words};
use models::keys::{Holds, Key};
use std::path::Path;

/// The reader's error first, then unknown keys and values outside their limits elsewhere, by line.
#[must_use]
pub fn errors(path: &Path, text: &str, first: ScenarioError) -> Vec<ScenarioError> {
    let mut more = Vec::new();
    if let Ok(root) = Section::parse(path, text) {
        let tables = TABLES.iter().map(|table| table.word);
        only(&root, &tables.chain(words(ROOT)).collect::<Vec<_>>(), &mut more);
        for table in TABLES {
            for section in root.tables(table.word) {
                of_table(&section, table.keys, &mut more);
            }
        }
    }
    let same = |a: &ScenarioError, b: &ScenarioError| {
        a.file == b.file && a.line == b.line && a.key == b.key
    };
    more.retain(|error| !same(error, &first));
    more.sort_by_key(|error| error.line);
    let mut all = vec![first];
    all.extend(more);
    all
}

/// Every key that is not among these.
fn only(section: &Section, allowed: &[&str], found: &mut Vec<ScenarioError>) {
    let mut rest = section.clone();
    while let Err(error) = rest.only(allowed) {
        let key = error.key.rsplit('.').next().unwrap_or("").to_owned();
        let before = rest.keys().count();
        rest = rest.without(&[&key]);
        found.push(error);
        if rest.keys().count() == before {
            break; // a key with a dot in its name
        }
    }
}

fn of_table(section: &Section, keys: &[Key], found: &mut Vec<ScenarioError>) {
    only(section, &keys.iter().map(|key| key.word).collect::<Vec<_>>(), found);
    for key in keys.iter().filter(|key| section.has(key.word)) {
        let error = match key.holds {
            Holds::Number { least, most } => {
                section.number(key.word, within(least, most, key.unit)).err()
            }
            Holds::Whole { least, most } => {
                section.number(key.word, within(least as f64, most as f64, key.unit)).err()
            }
            Holds::Word(allowed) => match section.text(key.word) {
                Ok(Some(word)) if !allowed().contains(&word) => {
                    let quoted: Vec<String> =
                        allowed().iter().map(|w| format!("\"{w}\"")).collect();
                    let (found, allowed) = (word.to_owned(), quoted.join(", "));
                    Some(section.refuse(key.word, Problem::NotAllowed { found, allowed }))
                }
                Ok(_) => None,
                Err(error) => Some(error),
            },
            Holds::Text => section.text(key.word).err(),
            Holds::File => section.file_path(key.word).err(),
            Holds::Table(inner) | Holds::Tables(inner) if !inner.is_empty() => {
                section.tables(key.word).iter().for_each(|table| of_table(table, inner, found));
                None
            }
            _ => None,
        };
        found.extend(error);
    }
}
