//! The reference of scene files, as text and as a JSON schema, made of the reader's own tables.

use crate::keys::{DRIVEN, GENERATED, HANDOVER, MOVER, OVERLAY, ROOT, SCHEDULE, TABLES, Table};
use crate::sensors::FOREIGN;
use models::frames::Point3;
use models::keys::{Holds, Key, PLACE};
use models::plot::SensorId;
use models::sensors::KINDS;
use models::sensors::declared::{Declared, Given, Value as Of};
use models::sensors::reporting::cooperative::Equipage;
use serde_json::{Map, Value, json};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The defaults of a kind's keys, as its first parameter set has them: word and value.
fn defaults(declared: &Declared) -> BTreeMap<&'static str, String> {
    let mut found = BTreeMap::new();
    let Some(read) = declared.read else { return found };
    let groups = declared.kind.keys;
    let level = models::keys::find(groups, "level").map(|key| key.holds);
    let levels = if let Some(Holds::Word(words)) = level { words() } else { vec![""] };
    for level in levels {
        let mut values = BTreeMap::new();
        for key in groups.iter().flat_map(|group| group.iter()).filter(|key| key.needed) {
            if let Holds::Number { least, most } = key.holds {
                values.insert(key.word.to_owned(), Of::Number(0.0_f64.clamp(least, most)));
            }
        }
        if !level.is_empty() {
            values.insert("level".to_owned(), Of::Word(level.to_owned()));
        }
        let given = Given {
            id: SensorId(1),
            preset: declared.kind.presets.first().map_or("", |preset| preset.0),
            values: &values,
            site_m: Some(Point3::origin()),
            equipped: Equipage::all(),
            reference: geodesy::Geodetic::from_degrees(0.0, 0.0, 0.0),
            start_utc_ns: 0,
            buildings: &[],
            asked: RefCell::default(),
        };
        // A key that has to be given stops some; what was asked until then has its default.
        drop(read(&given));
        for (word, value) in given.asked.take() {
            let needed = values.contains_key(word) && word != "level";
            if !needed && !value.is_empty() {
                found.entry(word).or_insert(value);
            }
        }
    }
    found
}

fn number(value: f64) -> String {
    if value != 0.0 && (value.abs() >= 1e6 || value.abs() < 1e-3) {
        format!("{value:e}")
    } else {
        format!("{value}")
    }
}

fn interval(least: &str, most: &str) -> String {
    match (least, most) {
        ("-inf", "inf") => String::new(),
        (_, "inf") => format!("{least} or more"),
        ("-inf", _) => format!("{most} or less"),
        _ => format!("{least} to {most}"),
    }
}

/// What a key holds, for people.
fn held(key: &Key) -> String {
    let text = match key.holds {
        Holds::Number { least, most } => {
            format!("{} {}", interval(&number(least), &number(most)), key.unit)
        }
        Holds::Whole { least, most } if most == i64::MAX => format!("whole, {least} or more"),
        Holds::Whole { least, most } => format!("whole, {least} to {most}"),
        Holds::Numbers { .. } => format!("list of numbers {}", key.unit),
        Holds::NumberOrNumbers { least, most } => {
            format!("{} {}, or a list of them", interval(&number(least), &number(most)), key.unit)
        }
        Holds::Rows => "list of rows of numbers".into(),
        Holds::Flag => "true or false".into(),
        Holds::Text => "text".into(),
        Holds::File => "path from the scene's folder".into(),
        Holds::Word(words) => {
            words().iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(", ")
        }
        Holds::Time => "time with offset".into(),
        Holds::Texts => "list of texts".into(),
        Holds::ShareOrNames => "0 to 1, or list of call signs".into(),
        Holds::WholeOr { least, most, word } => format!("whole, {least} to {most}, or `{word}`"),
        Holds::ByName(inner) => {
            let one = held(&Key { holds: *inner, ..*key });
            format!("{one}; or a table of these by federate")
        }
        Holds::Table(_) => "table".into(),
        Holds::Tables(_) => "list of tables".into(),
        Holds::Place => "place".into(),
        Holds::Places(_) => "list of places".into(),
        Holds::Shares => "table of weights".into(),
        Holds::Counts { most } => format!("table of counts, each 0 to {most}"),
        Holds::Open => "table".into(),
    };
    text.trim().to_owned()
}

fn rows(out: &mut String, keys: &[Key], defaults: &BTreeMap<&'static str, String>) {
    out.push_str("| key | value | without it | what it is |\n| --- | --- | --- | --- |\n");
    for key in keys {
        let without = match (key.needed, defaults.get(key.word)) {
            (true, _) => "refused",
            (false, Some(default)) => default,
            (false, None) => key.default,
        };
        let _ = writeln!(out, "| `{}` | {} | {without} | {} |", key.word, held(key), key.doc);
    }
}

fn below(out: &mut String, path: &str, keys: &[Key]) {
    let none = BTreeMap::new();
    for key in keys {
        let (Holds::Table(inner) | Holds::Tables(inner) | Holds::Places(inner)) = key.holds else {
            continue;
        };
        if inner.is_empty() {
            continue;
        }
        let path = format!("{path}.{}", key.word);
        let _ = writeln!(out, "\n### {path}\n\n{}.\n", key.doc);
        rows(out, inner, &none);
        below(out, &path, inner);
    }
}

/// The reference as Markdown.
#[must_use]
pub fn markdown() -> String {
    let mut out = String::from(
        "# Scene files\n\nOne TOML file says everything of a run. This page is made of the tables that the reader uses \
         (`seeds scene doc`);\n`seeds scene schema` prints the same as a JSON schema for editors, `seeds scene check FILE` \
         says what is wrong with a\nscene or silly in it, `seeds scene new AIRPORT` writes one that runs. Unknown keys are \
         refused.\n",
    );
    let none = BTreeMap::new();
    let tables = |out: &mut String, tables: &[Table], level: &str| {
        for Table { word, many, doc, keys, .. } in tables {
            let title = if *many { format!("[[{word}]]") } else { format!("[{word}]") };
            let _ = writeln!(out, "\n{level} {title}\n\n{doc}.\n");
            rows(out, keys, &none);
            below(out, word, keys);
        }
    };
    tables(&mut out, TABLES, "##");
    out.push_str("\n## Above all tables\n\n");
    rows(&mut out, ROOT, &none);
    out.push_str("\n## Places\n\nBy latitude and longitude, or from the reference point.\n\n");
    rows(&mut out, PLACE, &none);
    out.push_str(
        "\n## Overlay\n\nA TOML file beside the layout (`[airport] overlay`, `seeds airport check LAYOUT --with FILE.toml`) says what \
         the layout lacks or says\nwrongly. Applied in this order; the import report has a line for each row.\n",
    );
    tables(&mut out, OVERLAY, "###");
    out.push_str("\n## Kinds of sensors\n\n| kind | name | what of it is simulated | site | carried by targets |\n| --- | --- | --- | --- | --- |\n");
    for declared in KINDS {
        let kind = &declared.kind;
        let yes = |flag: bool, word| if flag { word } else { "" };
        let _ = writeln!(
            out,
            "| `{}` | {} | {} | {} | {} |",
            kind.word,
            kind.title,
            kind.about,
            yes(kind.needs_site, "needed"),
            yes(kind.carried, "yes"),
        );
    }
    out.push_str("| `offline` | Fitted figures | What `seeds fit` wrote of any of these | of a radar's figures | as the kind |\n");
    out.push_str("| `asterix` | Somebody's real sensor | Nothing: its plots come in ASTERIX ([asterix.md](asterix.md#a-real-sensor)) | of one that reports range and azimuth alone | no |\n");
    for declared in KINDS {
        let kind = &declared.kind;
        let _ = writeln!(out, "\n### sensor.overrides of kind = \"{}\"\n", kind.word);
        if !kind.presets.is_empty() {
            let sets: Vec<_> =
                kind.presets.iter().map(|(name, what)| format!("`{name}` ({what})")).collect();
            let _ = writeln!(
                out,
                "`parameters`: {}. Values below are the first one's.\n",
                sets.join(", ")
            );
        }
        let keys: Vec<Key> = kind.keys.iter().flat_map(|group| group.iter().copied()).collect();
        rows(&mut out, &keys, &defaults(declared));
        below(&mut out, "overrides", &keys);
    }
    out
}

/// The schema of one key's value.
fn value_schema(key: &Key) -> Value {
    let limited = |least: f64, most: f64, kind: &str| {
        let mut of = Map::from_iter([("type".to_owned(), json!(kind))]);
        if least.is_finite() {
            of.insert("minimum".into(), json!(least));
        }
        if most.is_finite() {
            of.insert("maximum".into(), json!(most));
        }
        Value::Object(of)
    };
    let mut schema = match key.holds {
        Holds::Number { least, most } => limited(least, most, "number"),
        Holds::Whole { least, most } => {
            json!({"type": "integer", "minimum": least, "maximum": most})
        }
        Holds::Numbers { least, most } => {
            json!({"type": "array", "items": limited(least, most, "number")})
        }
        Holds::NumberOrNumbers { least, most } => json!({"oneOf": [
            limited(least, most, "number"),
            {"type": "array", "minItems": 1, "items": limited(least, most, "number")}
        ]}),
        Holds::Rows => json!({
            "type": "array", "items": {"type": "array", "items": {"type": "number"}}
        }),
        Holds::Flag => json!({"type": "boolean"}),
        Holds::Text | Holds::File => json!({"type": "string"}),
        Holds::Word(words) => json!({"enum": words()}),
        // Editors hand a time over as text or as an object of their own.
        Holds::Time => json!({}),
        Holds::Texts => json!({"type": "array", "items": {"type": "string"}}),
        Holds::ShareOrNames => json!({"oneOf": [
            {"type": "number", "minimum": 0, "maximum": 1},
            {"type": "array", "items": {"type": "string"}}
        ]}),
        Holds::WholeOr { least, most, word } => json!({"oneOf": [
            {"type": "integer", "minimum": least, "maximum": most}, {"const": word}
        ]}),
        Holds::ByName(inner) => {
            let one = value_schema(&Key { holds: *inner, doc: "", default: "", ..*key });
            json!({"oneOf": [one.clone(), {"type": "object", "additionalProperties": one}]})
        }
        Holds::Table(keys) => table_schema(keys, &[]),
        Holds::Tables(keys) => json!({"type": "array", "items": table_schema(keys, &[])}),
        Holds::Place => table_schema(PLACE, &[]),
        Holds::Places(more) => json!({"type": "array", "items": table_schema(PLACE, more)}),
        Holds::Shares => json!({
            "type": "object",
            "additionalProperties": {"type": "number", "minimum": 0, "maximum": 1e6}
        }),
        Holds::Counts { most } => json!({
            "type": "object",
            "additionalProperties": {"type": "integer", "minimum": 0, "maximum": most}
        }),
        Holds::Open => json!({"type": "object"}),
    };
    if let Value::Object(of) = &mut schema {
        let mut text = key.doc.to_owned();
        if !key.unit.is_empty() {
            let _ = write!(text, " [{}]", key.unit);
            of.insert("x-unit".into(), json!(key.unit));
        }
        if !key.default.is_empty() {
            let _ = write!(text, " (without it: {})", key.default);
        }
        of.insert("description".into(), json!(text));
    }
    schema
}

fn table_schema(keys: &[Key], more: &[Key]) -> Value {
    let all = || keys.iter().chain(more);
    let properties: Map<String, Value> =
        all().map(|key| (key.word.to_owned(), value_schema(key))).collect();
    let needed: Vec<&str> = all().filter(|key| key.needed).map(|key| key.word).collect();
    let mut schema = json!({
        "type": "object", "properties": properties, "additionalProperties": false
    });
    if let (false, Value::Object(of)) = (needed.is_empty(), &mut schema) {
        of.insert("required".into(), json!(needed));
    }
    schema
}

/// Narrows the value of one property; what the key is stays said.
fn say(schema: &mut Value, word: &str, key: Option<&Key>, mut narrowed: Value) {
    narrowed["description"] = json!(key.map_or("", |key| key.doc));
    schema["properties"][word] = narrowed;
}

/// A table that comes in kinds: one form for each.
fn by_kind(forms: Vec<(Value, Vec<Key>)>) -> Value {
    let forms: Vec<Value> = forms
        .into_iter()
        .map(|(kinds, keys)| {
            let mut schema = table_schema(&keys, &[]);
            say(
                &mut schema,
                "kind",
                keys.iter().find(|k| k.word == "kind"),
                json!({ "enum": kinds }),
            );
            schema
        })
        .collect();
    json!({ "oneOf": forms })
}

fn traffic_schema(keys: &'static [Key]) -> Value {
    let of = |words: &[&str], needed: &[&str]| -> Vec<Key> {
        let chosen = keys.iter().filter(|key| words.contains(&key.word));
        chosen.map(|key| Key { needed: key.needed || needed.contains(&key.word), ..*key }).collect()
    };
    by_kind(vec![
        (json!(["parked"]), of(MOVER, &["callsign", "type", "stand"])),
        (json!(["recorded"]), of(MOVER, &["callsign", "type", "file", "start_s"])),
        (json!(["route"]), of(MOVER, &["callsign", "type", "via", "start_s"])),
        (json!(["driven"]), of(DRIVEN, &["callsign", "type", "stand"])),
        (json!(["schedule"]), of(SCHEDULE, &["file"])),
        (json!(["generated"]), of(GENERATED, &[])),
        (json!(["handover"]), of(HANDOVER, &[])),
    ])
}

fn sensor_schema(keys: &'static [Key]) -> Value {
    let mut forms = Vec::new();
    for declared in KINDS {
        let kind = &declared.kind;
        let not = |word: &str| match word {
            "processing" => !kind.radar,
            "figures" | "of" => true,
            "equipped" => !kind.carried,
            word => FOREIGN.contains(&word),
        };
        let own: Vec<Key> = keys
            .iter()
            .filter(|key| !not(key.word))
            .map(|key| Key {
                needed: key.needed || (key.word == "site" && kind.needs_site),
                ..*key
            })
            .collect();
        let mut schema = table_schema(&own, &[]);
        let doc = |word: &str| keys.iter().find(|key| key.word == word);
        say(&mut schema, "kind", doc("kind"), json!({ "const": kind.word }));
        let overrides: Vec<Key> = kind
            .keys
            .iter()
            .flat_map(|group| group.iter())
            .map(|key| Key { needed: key.needed && !kind.radar, ..*key })
            .collect();
        say(&mut schema, "overrides", doc("overrides"), table_schema(&overrides, &[]));
        if !kind.presets.is_empty() {
            let names: Vec<&str> = kind.presets.iter().map(|preset| preset.0).collect();
            say(&mut schema, "parameters", doc("parameters"), json!({ "enum": names }));
        }
        forms.push(schema);
    }
    let not = ["processing", "parameters", "overrides", "figures", "equipped"];
    let own: Vec<Key> = keys.iter().filter(|k| !not.contains(&k.word)).copied().collect();
    let mut foreign = table_schema(&own, &[]);
    let doc = keys.iter().find(|key| key.word == "kind");
    say(&mut foreign, "kind", doc, json!({ "const": "asterix" }));
    foreign["oneOf"] = json!([{ "required": ["listen"] }, { "required": ["file"] }]);
    forms.push(foreign);
    let not = |word: &str| {
        ["processing", "parameters", "overrides"].contains(&word) || FOREIGN.contains(&word)
    };
    let own = keys.iter().filter(|k| !not(k.word));
    let own: Vec<Key> =
        own.map(|key| Key { needed: key.needed || key.word == "figures", ..*key }).collect();
    let mut offline = table_schema(&own, &[]);
    say(&mut offline, "kind", doc, json!({ "const": "offline" }));
    forms.push(offline);
    json!({ "oneOf": forms })
}

/// The schema of scenes (JSON Schema 2020-12). It is weaker than the reader where a rule reaches over several keys.
#[must_use]
pub fn schema() -> Value {
    let (mut properties, mut defs) = (Map::new(), Map::new());
    let mut needed = Vec::new();
    for table in TABLES {
        let mut schema = match table.word {
            "traffic" => traffic_schema(table.keys),
            "sensor" => sensor_schema(table.keys),
            _ => table_schema(table.keys, &[]),
        };
        schema["description"] = json!(table.doc);
        defs.insert(table.word.to_owned(), schema);
        let of = json!({ "$ref": format!("#/$defs/{}", table.word) });
        let mut of = if table.many { json!({ "type": "array", "items": of }) } else { of };
        of["description"] = json!(table.doc);
        properties.insert(table.word.to_owned(), of);
        if table.needed {
            needed.push(table.word);
        }
    }
    for key in ROOT {
        properties.insert(key.word.to_owned(), value_schema(key));
    }
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "SEEDS scene",
        "type": "object",
        "properties": properties,
        "required": needed,
        "additionalProperties": false,
        "$defs": defs
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Path of every property that says nothing, and how many there are in all.
    fn silent(of: &Value, path: &str, found: &mut Vec<String>, count: &mut usize) {
        match of {
            Value::Object(table) => {
                // A scene's own table `properties` there is none, so each of the name lists keys.
                if let Some(Value::Object(keys)) = table.get("properties") {
                    *count += keys.len();
                    let mute = |v: &Value| v["description"].as_str().is_none_or(str::is_empty);
                    found.extend(
                        keys.iter().filter(|(_, v)| mute(v)).map(|(k, _)| format!("{path}.{k}")),
                    );
                }
                table.iter().for_each(|(k, v)| silent(v, &format!("{path}.{k}"), found, count));
            }
            Value::Array(list) => list.iter().for_each(|v| silent(v, path, found, count)),
            _ => {}
        }
    }

    #[test]
    fn every_key_of_the_schema_says_what_it_is() {
        let (mut found, mut count) = (Vec::new(), 0);
        silent(&schema(), "", &mut found, &mut count);
        assert_eq!(found, Vec::<String>::new());
        assert!(count > 400, "{count} keys");
    }
}
