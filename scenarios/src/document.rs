//! A TOML document as a tree that knows the line of every key and value.
//!
//! A [`Section`] is read with its list of allowed keys, so a misspelt key is found before a missing
//! one; every reading function checks kind and limits and gives a [`ScenarioError`] with file, line
//! and key path. A section owns its values: it can be kept, cloned and handed on.

use crate::error::{Problem, ScenarioError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::de::{DeTable, DeValue};

/// A value with its line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Item {
    value: Value,
    line: usize,
}

/// A TOML value, owned.
#[derive(Clone, Debug, PartialEq)]
enum Value {
    Text(String),
    Integer(i64),
    Number(f64),
    Flag(bool),
    /// Nanoseconds since 1970-01-01 UTC, or `None` where the offset or a part of the date is missing.
    Time(Option<i64>, String),
    List(Vec<Item>),
    Table(BTreeMap<String, Entry>),
}

#[derive(Clone, Debug, PartialEq)]
struct Entry {
    key_line: usize,
    item: Item,
}

/// Allowed interval of a number, ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    low: f64,
    high: f64,
    unit: &'static str,
}

/// `low ..= high` in `unit` (the unit's name as in messages: "s", "m", "mm/h", "" for a pure number).
#[must_use]
pub const fn within(low: f64, high: f64, unit: &'static str) -> Limits {
    Limits { low, high, unit }
}

/// One table of a document.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    file: Arc<Path>,
    path: String,
    line: usize,
    entries: BTreeMap<String, Entry>,
}

impl Section {
    /// Reads a document; the section is its root.
    ///
    /// # Errors
    /// If the text is not TOML.
    pub fn parse(file: &Path, text: &str) -> Result<Self, ScenarioError> {
        let lines = LineStarts::of(text);
        let root = DeTable::parse(text).map_err(|error| {
            let line = error.span().map_or(1, |span| lines.line(span.start));
            let message = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
            ScenarioError::new(file, line, "scene", Problem::Syntax { message })
        })?;
        let entries = table(root.get_ref(), &lines);
        Ok(Self { file: file.into(), path: String::new(), line: 1, entries })
    }

    /// The file that the section is from.
    #[must_use]
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Path of the section in the document: `sensor[2]`; empty for the root.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// First line of the section.
    #[must_use]
    pub fn line(&self) -> usize {
        self.line
    }

    /// Line of a key, or of the section where the key is not given.
    #[must_use]
    pub fn line_of(&self, key: &str) -> usize {
        self.entries.get(key).map_or(self.line, |entry| entry.item.line)
    }

    /// True if the key is given.
    #[must_use]
    pub fn has(&self, key: &str) -> bool {
        self.entries.contains_key(key)
    }

    /// True if the key is given and is a list.
    #[must_use]
    pub fn is_list(&self, key: &str) -> bool {
        matches!(self.item(key), Some(Item { value: Value::List(_), .. }))
    }

    /// The section without these keys, for a reader that knows the others only.
    #[must_use]
    pub fn without(&self, keys: &[&str]) -> Self {
        let mut rest = self.clone();
        rest.entries.retain(|key, _| !keys.contains(&key.as_str()));
        rest
    }

    /// Names of the keys given, sorted.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.entries.keys().map(String::as_str)
    }

    /// An error at the line of `key`.
    #[must_use]
    pub fn refuse(&self, key: &str, problem: Problem) -> ScenarioError {
        ScenarioError::new(&self.file, self.line_of(key), self.key_path(key), problem)
    }

    /// Wraps an error of a model that refused the value of `key`.
    #[must_use]
    pub fn refused_by_model(
        &self,
        key: &str,
        error: impl std::error::Error + Send + Sync + 'static,
    ) -> ScenarioError {
        self.refuse(key, Problem::Model(Box::new(error)))
    }

    /// Checks that no other keys than `allowed` are given.
    ///
    /// # Errors
    /// The first unknown key, with the allowed one that looks most like it.
    pub fn only(&self, allowed: &[&str]) -> Result<(), ScenarioError> {
        let mut unknown: Vec<_> =
            self.entries.iter().filter(|(key, _)| !allowed.contains(&key.as_str())).collect();
        unknown.sort_by_key(|(_, entry)| entry.key_line);
        match unknown.first() {
            None => Ok(()),
            Some((key, entry)) => Err(ScenarioError::new(
                &self.file,
                entry.key_line,
                self.key_path(key),
                Problem::UnknownKey { nearest: nearest(key, allowed), allowed: allowed.join(", ") },
            )),
        }
    }

    /// A number within limits, `None` where not given.
    ///
    /// # Errors
    /// If it is not a number (a text with a unit is not), not finite, or outside the limits.
    pub fn number(&self, key: &str, limits: Limits) -> Result<Option<f64>, ScenarioError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let found = match item.value {
            Value::Number(number) => number,
            Value::Integer(integer) => integer as f64,
            _ => return Err(self.wrong_kind(key, item, format!("a number{}", of_unit(limits)))),
        };
        if found >= limits.low && found <= limits.high {
            return Ok(Some(found));
        }
        let Limits { low, high, unit } = limits;
        Err(self.refuse(key, Problem::OutOfRange { found, low, high, unit }))
    }

    /// A number within limits, or `default` where not given.
    ///
    /// # Errors
    /// As [`Section::number`].
    pub fn number_or(&self, key: &str, default: f64, limits: Limits) -> Result<f64, ScenarioError> {
        Ok(self.number(key, limits)?.unwrap_or(default))
    }

    /// A number within limits that has to be given.
    ///
    /// # Errors
    /// As [`Section::number`], and if it is missing.
    pub fn need_number(&self, key: &str, limits: Limits) -> Result<f64, ScenarioError> {
        let needed = || format!("a number{}", of_unit(limits));
        self.number(key, limits)?.ok_or_else(|| self.missing(key, needed()))
    }

    /// A whole number within `low ..= high`, `None` where not given.
    ///
    /// # Errors
    /// If it is not a whole number or outside the limits.
    pub fn integer(&self, key: &str, low: i64, high: i64) -> Result<Option<i64>, ScenarioError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let Value::Integer(found) = item.value else {
            return Err(self.wrong_kind(key, item, "a whole number".into()));
        };
        if (low..=high).contains(&found) {
            return Ok(Some(found));
        }
        let (found, low, high) = (found as f64, low as f64, high as f64);
        Err(self.refuse(key, Problem::OutOfRange { found, low, high, unit: "" }))
    }

    /// A text, `None` where not given.
    ///
    /// # Errors
    /// If it is not a text.
    pub fn text(&self, key: &str) -> Result<Option<&str>, ScenarioError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        match &item.value {
            Value::Text(text) => Ok(Some(text)),
            _ => Err(self.wrong_kind(key, item, "a text in quotation marks".into())),
        }
    }

    /// A text that has to be given; `what` says what for.
    ///
    /// # Errors
    /// If it is missing or no text.
    pub fn need_text(&self, key: &str, what: &str) -> Result<&str, ScenarioError> {
        self.text(key)?.ok_or_else(|| self.missing(key, what.into()))
    }

    /// One word of a list, translated; `None` where not given.
    ///
    /// # Errors
    /// If it is not one of the words.
    pub fn choice<T: Clone>(
        &self,
        key: &str,
        allowed: &[(&str, T)],
    ) -> Result<Option<T>, ScenarioError> {
        let Some(found) = self.text(key)? else { return Ok(None) };
        if let Some((_, value)) = allowed.iter().find(|(word, _)| *word == found) {
            return Ok(Some(value.clone()));
        }
        let words: Vec<_> = allowed.iter().map(|(word, _)| format!("\"{word}\"")).collect();
        let problem = Problem::NotAllowed { found: found.into(), allowed: words.join(", ") };
        Err(self.refuse(key, problem))
    }

    /// True or false, `None` where not given.
    ///
    /// # Errors
    /// If it is neither.
    pub fn flag(&self, key: &str) -> Result<Option<bool>, ScenarioError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        match item.value {
            Value::Flag(flag) => Ok(Some(flag)),
            _ => Err(self.wrong_kind(key, item, "true or false".into())),
        }
    }

    /// A date with time and offset, nanoseconds since 1970-01-01 UTC; `None` where not given.
    ///
    /// # Errors
    /// If it is not one, or has no offset.
    pub fn time_utc_ns(&self, key: &str) -> Result<Option<i64>, ScenarioError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        match item.value {
            Value::Time(Some(ns), _) => Ok(Some(ns)),
            Value::Text(_) => {
                let needed = "a time without quotation marks, like 2019-11-24T09:00:00Z";
                Err(self.wrong_kind(key, item, needed.into()))
            }
            _ => Err(self.wrong_kind(key, item, "a UTC time like 2019-11-24T09:00:00Z".into())),
        }
    }

    /// A list of texts with their lines; empty where not given.
    ///
    /// # Errors
    /// If it is not a list, or an element is not a text.
    pub fn texts(&self, key: &str) -> Result<Vec<(String, usize)>, ScenarioError> {
        let needed = "a list of texts in quotation marks";
        self.list(key, needed)?
            .iter()
            .map(|item| match &item.value {
                Value::Text(text) => Ok((text.clone(), item.line)),
                _ => Err(self.wrong_kind(key, item, needed.into())),
            })
            .collect()
    }

    /// A list of numbers within limits; empty where not given.
    ///
    /// # Errors
    /// If it is not a list, or an element is not a number or outside the limits.
    pub fn numbers(&self, key: &str, limits: Limits) -> Result<Vec<f64>, ScenarioError> {
        let needed = format!("a list of numbers{}", of_unit(limits));
        self.list(key, &needed)?
            .iter()
            .map(|item| {
                let found = match item.value {
                    Value::Number(number) => number,
                    Value::Integer(integer) => integer as f64,
                    _ => return Err(self.wrong_kind(key, item, needed.clone())),
                };
                let Limits { low, high, unit } = limits;
                let problem = Problem::OutOfRange { found, low, high, unit };
                if found >= low && found <= high {
                    Ok(found)
                } else {
                    Err(ScenarioError::new(&self.file, item.line, self.key_path(key), problem))
                }
            })
            .collect()
    }

    /// A number within limits, or a list of such numbers; empty where not given.
    ///
    /// # Errors
    /// If it is neither, the list is empty, or a number is outside the limits.
    pub fn number_or_numbers(&self, key: &str, limits: Limits) -> Result<Vec<f64>, ScenarioError> {
        match self.item(key) {
            Some(Item { value: Value::List(items), .. }) if items.is_empty() => {
                let needed = format!("a number{}, or a list of them", of_unit(limits));
                Err(self.refuse(key, Problem::WrongKind { found: "an empty list".into(), needed }))
            }
            Some(Item { value: Value::List(_), .. }) => self.numbers(key, limits),
            _ => Ok(self.number(key, limits)?.into_iter().collect()),
        }
    }

    /// A list of lists of numbers, each with its line; empty where the key is not given.
    ///
    /// # Errors
    /// If it is something else.
    pub fn rows(&self, key: &str) -> Result<Vec<(Vec<f64>, usize)>, ScenarioError> {
        let needed = "a list of lists of numbers";
        let wrong = |line: usize, item: &Item| {
            let problem =
                Problem::WrongKind { found: item.value.described(), needed: needed.into() };
            ScenarioError::new(&self.file, line, self.key_path(key), problem)
        };
        let number = |item: &Item| match item.value {
            Value::Number(number) => Some(number),
            Value::Integer(integer) => Some(integer as f64),
            _ => None,
        };
        let row = |item: &Item| match &item.value {
            Value::List(items) => {
                let numbers: Option<Vec<f64>> = items.iter().map(number).collect();
                numbers.map(|row| (row, item.line)).ok_or_else(|| wrong(item.line, item))
            }
            _ => Err(wrong(item.line, item)),
        };
        self.list(key, needed)?.iter().map(row).collect()
    }

    /// A table below this one, checked for unknown keys; `None` where not given.
    ///
    /// # Errors
    /// If it is not a table, or has a key that is not `allowed`.
    pub fn section(&self, key: &str, allowed: &[&str]) -> Result<Option<Self>, ScenarioError> {
        let Some(section) = self.any_section(key)? else { return Ok(None) };
        section.only(allowed)?;
        Ok(Some(section))
    }

    /// A table below this one whose keys are checked elsewhere; `None` where not given.
    ///
    /// # Errors
    /// If it is not a table.
    pub fn any_section(&self, key: &str) -> Result<Option<Self>, ScenarioError> {
        let Some(item) = self.item(key) else { return Ok(None) };
        let Value::Table(entries) = &item.value else {
            return Err(self.wrong_kind(key, item, format!("a table [{}]", self.key_path(key))));
        };
        Ok(Some(self.child(self.key_path(key), item.line, entries)))
    }

    /// The empty table at `key`, for sections that may be left out.
    #[must_use]
    pub fn empty(&self, key: &str) -> Self {
        self.child(self.key_path(key), self.line, &BTreeMap::new())
    }

    /// A list of tables (`[[key]]`), each checked for unknown keys; empty where not given.
    ///
    /// # Errors
    /// If it is not a list of tables, or one has a key that is not `allowed`.
    pub fn sections(&self, key: &str, allowed: &[&str]) -> Result<Vec<Self>, ScenarioError> {
        let needed = format!("a list of tables [[{}]]", self.key_path(key));
        let list = self.list(key, &needed)?;
        let mut sections = Vec::with_capacity(list.len());
        for (index, item) in list.iter().enumerate() {
            let Value::Table(entries) = &item.value else {
                return Err(self.wrong_kind(key, item, needed));
            };
            let path = format!("{}[{}]", self.key_path(key), index + 1);
            let section = self.child(path, item.line, entries);
            section.only(allowed)?;
            sections.push(section);
        }
        Ok(sections)
    }

    /// The tables below `key`, one or several, whatever keys they have; empty where it holds none.
    pub(crate) fn tables(&self, key: &str) -> Vec<Self> {
        let Some(item) = self.item(key) else { return Vec::new() };
        match &item.value {
            Value::Table(entries) => vec![self.child(self.key_path(key), item.line, entries)],
            Value::List(list) => {
                let one = |(index, item): (usize, &Item)| {
                    let Value::Table(entries) = &item.value else { return None };
                    let path = format!("{}[{}]", self.key_path(key), index + 1);
                    Some(self.child(path, item.line, entries))
                };
                list.iter().enumerate().filter_map(one).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Path of a file named by `key`, from the folder of the scene; it has to exist.
    ///
    /// # Errors
    /// If it is not a text or the file does not exist.
    pub fn file_path(&self, key: &str) -> Result<Option<PathBuf>, ScenarioError> {
        let Some(name) = self.text(key)? else { return Ok(None) };
        let path = self.file.parent().unwrap_or(Path::new("")).join(name);
        let found = crate::data_file(&self.file, name);
        if crate::files::is_file(&found) {
            return Ok(Some(found));
        }
        let reason =
            if path.exists() { "is not a file".into() } else { String::from("does not exist") };
        Err(self.refuse(key, Problem::File { path, reason }))
    }

    /// Feeds the values (not the layout, nor comments) of `key` to `hash`, in the order of the keys.
    pub(crate) fn feed_key(&self, key: &str, hash: &mut crate::hash::Fnv) {
        if let Some(item) = self.item(key) {
            item.value.feed(hash);
        }
    }

    /// An error for a key that has to be given.
    #[must_use]
    pub fn missing(&self, key: &str, needed: String) -> ScenarioError {
        self.refuse(key, Problem::Missing { needed })
    }

    fn item(&self, key: &str) -> Option<&Item> {
        self.entries.get(key).map(|entry| &entry.item)
    }

    fn list(&self, key: &str, needed: &str) -> Result<&[Item], ScenarioError> {
        match self.item(key) {
            None => Ok(&[]),
            Some(Item { value: Value::List(items), .. }) => Ok(items),
            Some(item) => Err(self.wrong_kind(key, item, needed.into())),
        }
    }

    fn child(&self, path: String, line: usize, entries: &BTreeMap<String, Entry>) -> Self {
        Self { file: self.file.clone(), path, line, entries: entries.clone() }
    }

    fn key_path(&self, key: &str) -> String {
        if self.path.is_empty() { key.into() } else { format!("{}.{key}", self.path) }
    }

    fn wrong_kind(&self, key: &str, item: &Item, needed: String) -> ScenarioError {
        let problem = Problem::WrongKind { found: item.value.described(), needed };
        ScenarioError::new(&self.file, item.line, self.key_path(key), problem)
    }
}

impl Value {
    fn described(&self) -> String {
        match self {
            Self::Text(text) => format!("the text {text:?}"),
            Self::Integer(integer) => format!("the number {integer}"),
            Self::Number(number) => format!("the number {number}"),
            Self::Flag(flag) => format!("{flag}"),
            Self::Time(_, text) => format!("the time {text}"),
            Self::List(items) => format!("a list of {}", items.len()),
            Self::Table(_) => "a table".into(),
        }
    }

    fn feed(&self, hash: &mut crate::hash::Fnv) {
        match self {
            Self::Text(text) => hash.tagged(1, text.as_bytes()),
            // 600 and 600.0 are the same value.
            Self::Integer(integer) => hash.tagged(2, &(*integer as f64).to_bits().to_le_bytes()),
            Self::Number(number) => hash.tagged(2, &number.to_bits().to_le_bytes()),
            Self::Flag(flag) => hash.tagged(3, &[u8::from(*flag)]),
            Self::Time(_, text) => hash.tagged(4, text.as_bytes()),
            Self::List(items) => {
                hash.tagged(5, &(items.len() as u64).to_le_bytes());
                items.iter().for_each(|item| item.value.feed(hash));
            }
            Self::Table(entries) => feed_table(entries, hash),
        }
    }
}

fn feed_table(entries: &BTreeMap<String, Entry>, hash: &mut crate::hash::Fnv) {
    hash.tagged(6, &(entries.len() as u64).to_le_bytes());
    for (key, entry) in entries {
        hash.tagged(7, key.as_bytes());
        entry.item.value.feed(hash);
    }
}

fn of_unit(limits: Limits) -> String {
    if limits.unit.is_empty() { String::new() } else { format!(" in {} (no unit)", limits.unit) }
}

/// How many names are allowed, and the one that is nearest to a wrong one.
pub(crate) fn one_of(word: &str, allowed: &[&str]) -> String {
    let near = allowed.iter().map(|a| (edit_distance(word, a), *a)).min();
    let near = near.map_or(String::new(), |(_, near)| format!(", the nearest is \"{near}\""));
    format!("one of {} names{near}", allowed.len())
}

/// The allowed key with the smallest edit distance, if it is close, or one that differs in its unit only.
fn nearest(key: &str, allowed: &[&str]) -> Option<String> {
    let stem = |k: &str| k.split('_').next().unwrap_or("").to_owned();
    let close = allowed.iter().map(|a| (edit_distance(key, a), *a)).min();
    match close {
        Some((distance, candidate)) if distance <= 1 + key.len() / 4 => Some(candidate.into()),
        _ => allowed.iter().find(|a| stem(a) == stem(key)).map(|a| (*a).into()),
    }
}

/// Levenshtein distance.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let next = (diagonal + usize::from(ca != *cb)).min(row[j] + 1).min(row[j + 1] + 1);
            diagonal = row[j + 1];
            row[j + 1] = next;
        }
    }
    row[b.len()]
}

struct LineStarts(Vec<usize>);

impl LineStarts {
    fn of(text: &str) -> Self {
        let after_newlines =
            text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i + 1);
        Self(std::iter::once(0).chain(after_newlines).collect())
    }

    fn line(&self, offset: usize) -> usize {
        self.0.partition_point(|start| *start <= offset)
    }
}

fn table(from: &DeTable<'_>, lines: &LineStarts) -> BTreeMap<String, Entry> {
    from.iter()
        .map(|(key, value)| {
            let key_line = lines.line(key.span().start);
            let mut item = item(value.get_ref(), value.span().start, lines);
            if matches!(item.value, Value::Table(_)) {
                item.line = key_line; // the header's line, also for dotted keys
            }
            (key.get_ref().to_string(), Entry { key_line, item })
        })
        .collect()
}

fn item(from: &DeValue<'_>, offset: usize, lines: &LineStarts) -> Item {
    let value = match from {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Integer(integer) => match i64::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(integer) => Value::Integer(integer),
            Err(_) => Value::Number(integer.as_str().parse().unwrap_or(f64::INFINITY)),
        },
        DeValue::Float(float) => Value::Number(float.as_str().parse().unwrap_or(f64::INFINITY)),
        DeValue::Boolean(flag) => Value::Flag(*flag),
        DeValue::Datetime(time) => Value::Time(utc_ns(time), time.to_string()),
        DeValue::Array(array) => {
            Value::List(array.iter().map(|v| item(v.get_ref(), v.span().start, lines)).collect())
        }
        DeValue::Table(inner) => Value::Table(table(inner, lines)),
    };
    Item { value, line: lines.line(offset) }
}

/// Nanoseconds since 1970-01-01 UTC; `None` without date, time or offset, or outside 1678 to 2261.
fn utc_ns(time: &toml::value::Datetime) -> Option<i64> {
    let (date, clock, offset) = (time.date?, time.time?, time.offset?);
    let offset_min = match offset {
        toml::value::Offset::Z => 0,
        toml::value::Offset::Custom { minutes } => i64::from(minutes),
    };
    let days = days_from_civil(i64::from(date.year), i64::from(date.month), i64::from(date.day));
    let minutes = days * 1440 + i64::from(clock.hour) * 60 + i64::from(clock.minute) - offset_min;
    (minutes * 60 + i64::from(clock.second.unwrap_or(0)))
        .checked_mul(1_000_000_000)?
        .checked_add(i64::from(clock.nanosecond.unwrap_or(0)))
}

/// Days from 1970-01-01 of a date of the Gregorian calendar (years counted from March).
pub(crate) fn days_from_civil(year: i64, month: i64, day: i64) -> i64 {
    let y = if month <= 2 { year - 1 } else { year };
    let era = y.div_euclid(400);
    let year_of_era = y.rem_euclid(400);
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 719_468
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Section {
        Section::parse(Path::new("scene.toml"), text).expect("TOML")
    }

    #[test]
    fn dates_count_from_1970() {
        let s = read(
            "a = 1970-01-01T00:00:00Z\nb = 2000-02-29T12:00:00.5+01:00\nc = 2020-01-01\nd = \"2020-01-01T00:00:00Z\"",
        );
        assert_eq!(s.time_utc_ns("a").unwrap(), Some(0));
        assert_eq!(s.time_utc_ns("b").unwrap(), Some(951_822_000_500_000_000));
        assert_eq!(
            s.time_utc_ns("c").unwrap_err().to_string(),
            "scene.toml:3: c: found the time 2020-01-01, needed is a UTC time like 2019-11-24T09:00:00Z"
        );
        let quoted = s.time_utc_ns("d").unwrap_err().to_string();
        assert!(quoted.contains("without quotation marks, like"), "{quoted}");
    }

    #[test]
    fn a_wrong_unit_is_an_unknown_key_with_the_right_one() {
        let s = read("[run]\nduration_min = 10");
        assert_eq!(
            s.section("run", &["seed", "duration_s"]).unwrap_err().to_string(),
            "scene.toml:2: run.duration_min: unknown key, did you mean `duration_s`?; allowed here: seed, duration_s"
        );
    }

    #[test]
    fn values_and_layout_of_the_text_are_apart() {
        let hash = |text: &str| {
            let mut fnv = crate::hash::Fnv::default();
            let section = read(text);
            section.keys().for_each(|key| section.feed_key(key, &mut fnv));
            fnv.value()
        };
        assert_eq!(hash("a = 600\nb = \"x\""), hash("# a note\nb='x'\n\na   = 600.0"));
        assert_ne!(hash("a = 600"), hash("a = 601"));
        assert_ne!(hash("a = [1, 2]"), hash("a = [[1], 2]"));
    }
}
