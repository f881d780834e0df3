//! The chart's files as Kubernetes would see them. Its templates use four things of Helm only, which are understood here: values by
//! their path, named templates, `nindent`, `sha256sum`. Anything else is refused: then look whether the chart has to be so clever.

use serde::Deserialize as _;
use serde_yaml::Value;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// The chart.
pub(super) struct Chart {
    values: Value,
    named: BTreeMap<String, String>,
    templates: Vec<String>,
}

/// All documents of a file.
pub(super) fn parsed(text: &str) -> Vec<Value> {
    let documents = serde_yaml::Deserializer::from_str(text).map(Value::deserialize);
    let documents: Result<Vec<Value>, _> = documents.collect();
    documents.unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Command and arguments of a container.
pub(super) fn line(container: &Value) -> Vec<String> {
    let words = |key: &str| container[key].as_sequence().cloned().unwrap_or_default();
    let all = words("command").into_iter().chain(words("args"));
    all.map(|word| word.as_str().unwrap_or_else(|| panic!("{word:?}")).to_owned()).collect()
}

impl Chart {
    /// Where it is.
    pub(super) fn folder() -> PathBuf {
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/deploy/chart"))
    }

    pub(super) fn read() -> Self {
        let text = |path: PathBuf| std::fs::read_to_string(path).expect("a file of the chart");
        let values = parsed(&text(Self::folder().join("values.yaml"))).remove(0);
        let entries = std::fs::read_dir(Self::folder().join("templates")).expect("a folder");
        let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        files.sort();
        let (helpers, files): (Vec<_>, Vec<_>) =
            files.into_iter().partition(|f| f.extension().is_some_and(|e| e == "tpl"));
        let named = helpers.into_iter().flat_map(|file| definitions(&text(file))).collect();
        Self { values, named, templates: files.into_iter().map(text).collect() }
    }

    /// Every object of the chart, with these values over its own.
    pub(super) fn rendered(&self, over: &str) -> Vec<Value> {
        let mut values = self.values.clone();
        for over in parsed(over) {
            merge(&mut values, over);
        }
        let texts = self.templates.iter().map(|template| self.render(&values, template));
        texts.flat_map(|text| parsed(&text)).filter(|object| !object.is_null()).collect()
    }

    fn render(&self, values: &Value, template: &str) -> String {
        let mut out = String::new();
        for (text, action) in actions(template) {
            out += &text;
            let mut pipe = action.split('|').map(str::trim);
            let Some(first) = pipe.next().filter(|first| !first.is_empty()) else { continue };
            let words: Vec<&str> = first.split_whitespace().collect();
            let mut value = match words[..] {
                ["include", name, "."] => self.render(values, &self.named[name.trim_matches('"')]),
                [path] => value_of(values, path),
                _ => panic!("{first}: not understood"),
            };
            for function in pipe {
                value = match function.split_once(' ') {
                    Some(("nindent", n)) => {
                        let gap = format!("\n{}", " ".repeat(n.trim().parse().expect("a number")));
                        gap.clone() + &value.replace('\n', &gap)
                    }
                    None if function == "sha256sum" => "0".repeat(64),
                    _ => panic!("{function}: not understood"),
                };
            }
            out += &value;
        }
        out
    }
}

fn value_of(values: &Value, path: &str) -> String {
    let keys = path.strip_prefix(".Values.").unwrap_or_else(|| panic!("{path}: not understood"));
    match keys.split('.').fold(values, |value, key| &value[key]) {
        Value::String(text) => text.clone(),
        Value::Number(number) => number.to_string(),
        Value::Bool(word) => word.to_string(),
        other => panic!("{path}: {other:?}"),
    }
}

fn merge(values: &mut Value, over: Value) {
    match (values, over) {
        (Value::Mapping(values), Value::Mapping(over)) => {
            for (key, value) in over {
                merge(values.get_mut(&key).unwrap_or_else(|| panic!("no value {key:?}")), value);
            }
        }
        (_, Value::Null) => {}
        (value, over) => *value = over,
    }
}

/// What stands between actions, each with the action behind it; an empty one at the end.
fn actions(template: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut rest = template;
    let mut trims = false;
    while let Some((text, behind)) = rest.split_once("{{") {
        let (action, behind) = behind.split_once("}}").expect("an action that ends");
        let text = if trims { text.trim_start() } else { text };
        let before = action.strip_prefix('-');
        let text = if before.is_some() { text.trim_end() } else { text };
        let action = before.unwrap_or(action);
        trims = action.ends_with('-');
        found.push((text.to_owned(), action.trim_end_matches('-').trim().to_owned()));
        rest = behind;
    }
    let text = if trims { rest.trim_start() } else { rest };
    found.push((text.to_owned(), String::new()));
    found
}

/// The named templates of a file: nothing else stands in it, and none within another.
fn definitions(text: &str) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    for part in text.split("{{- define \"").skip(1) {
        let (name, body) = part.split_once("\" -}}").expect("a name");
        let (body, _) = body.split_once("{{- end }}").expect("an end");
        found.insert(name.to_owned(), body.trim().to_owned());
    }
    found
}
