//! Records as JSON, both ways.
//!
//! A record is an object of items by their number. A field is a number or a text; an item with one field is its bare
//! value, others are objects by the fields' names; an extended item says with `_parts` how many parts were there; a
//! repetitive item is a list; a compound item an object of its subitems; an explicit item of unknown
//! structure a text of hexadecimal digits. Reading takes an object with one entry for a bare value too, fields that are
//! not named are zero, and without `_parts` an extended item has the parts up to its last named field.

use crate::decode::Record;
use crate::encode::{EncodeError, ItemWriter, Reason, record as encode_record};
use crate::table::{Category, Field, Item, Kind, Part, Structure};
use crate::value::{Value, ValueError};
use crate::view::{PartView, View};
use serde_json::{Map, Number, Value as Json};

/// A record as an object.
#[must_use]
pub fn record(record: &Record<'_>) -> Json {
    Json::Object(record.items().map(|view| (view.item.id.to_owned(), item(&view))).collect())
}

/// An item (or subitem) as a value.
#[must_use]
pub fn item(view: &View<'_>) -> Json {
    match &view.item.structure {
        Structure::Fixed(_) => view.parts().next().map_or(Json::Null, |p| part(&p)),
        Structure::Extended(_) => {
            let mut fields = Map::new();
            let mut parts = 0;
            for part in view.parts() {
                parts += 1;
                fields.extend(part.values().map(|(f, v)| (f.name.to_owned(), scalar(v))));
            }
            fields.insert("_parts".into(), Json::from(parts));
            Json::Object(fields)
        }
        Structure::Counted(_) | Structure::Chained(_) => {
            Json::Array(view.parts().map(|p| part(&p)).collect())
        }
        Structure::Explicit([]) => {
            Json::String(view.octets()[1..].iter().map(|o| format!("{o:02x}")).collect())
        }
        Structure::Compound(_) | Structure::Explicit(_) => {
            let subitems = view.subitems().map(|sub| (sub.item.id.to_owned(), item(&sub)));
            Json::Object(subitems.collect())
        }
    }
}

fn part(part: &PartView<'_>) -> Json {
    let mut values = part.values();
    if part.part.values() == 1 {
        return values.next().map_or(Json::Null, |(_, v)| scalar(v));
    }
    Json::Object(values.map(|(field, v)| (field.name.to_owned(), scalar(v))).collect())
}

fn scalar(value: Value) -> Json {
    match value {
        Value::Integer(i) => Json::from(i),
        Value::Number(n) => Number::from_f64(n).map_or(Json::Null, Json::Number),
        Value::Text(t) => Json::from(t.as_str()),
        Value::Octal(_) => Json::from(value.to_string()),
    }
}

/// Appends the record that this object describes.
///
/// # Errors
/// If it is not an object, names what the category has not, or holds a value that does not fit; `out` is then as it was.
pub fn encode(
    out: &mut Vec<u8>,
    category: &'static Category,
    json: &Json,
) -> Result<(), EncodeError> {
    let object = json.as_object().ok_or_else(|| shape("", "a record as an object"))?;
    let known = |id: &String| category.uap.iter().flatten().any(|item| item.id == id.as_str());
    if let Some(id) = object.keys().find(|id| !known(id)) {
        return Err(EncodeError::item(id, Reason::Unknown));
    }
    encode_record(out, category, |items| {
        for own in category.uap.iter().flatten() {
            if let Some(value) = object.get(own.id) {
                put(items, own, value)?;
            }
        }
        Ok(())
    })
}

fn shape(id: &str, wanted: &'static str) -> EncodeError {
    EncodeError::item(id, Reason::Value(ValueError::Kind(wanted)))
}

fn put(items: &mut ItemWriter<'_>, own: &'static Item, json: &Json) -> Result<(), EncodeError> {
    match &own.structure {
        Structure::Fixed(part) => {
            let mut values = Vec::new();
            read_part(own, part, json, &mut values)?;
            items.put(own, &values)
        }
        Structure::Extended(parts) => {
            let object = json.as_object().ok_or_else(|| shape(own.id, "an object of fields"))?;
            let mut values = Vec::new();
            let mut needed = 0;
            for (index, part) in parts.iter().enumerate() {
                for field in part.fields.iter().filter(|f| !matches!(f.kind, Kind::Spare)) {
                    let given = object.get(field.name);
                    if given.is_some() {
                        needed = index + 1;
                    }
                    values.push(read_scalar(own, field, given)?);
                }
            }
            if let Some(name) = object.keys().find(|name| {
                let known = |p: &Part| p.fields.iter().any(|f| f.name == name.as_str());
                name.as_str() != "_parts" && !parts.iter().any(known)
            }) {
                return Err(unknown(own, name));
            }
            if let Some(asked) = object.get("_parts") {
                let asked = asked.as_u64().and_then(|n| usize::try_from(n).ok());
                match asked {
                    Some(n) if n >= needed.max(1) && n <= parts.len() => needed = n,
                    _ => return Err(unknown(own, "_parts")),
                }
            }
            let count: usize = parts[..needed.max(1)].iter().map(Part::values).sum();
            items.put(own, &values[..count])
        }
        Structure::Counted(part) | Structure::Chained(part) => {
            let list = json.as_array().ok_or_else(|| shape(own.id, "a list"))?;
            let mut values = Vec::new();
            for element in list {
                read_part(own, part, element, &mut values)?;
            }
            items.put(own, &values)
        }
        Structure::Explicit([]) => {
            let contents = json.as_str().and_then(octets);
            items.explicit(
                own,
                &contents.ok_or_else(|| shape(own.id, "a text of hexadecimal digits"))?,
            )
        }
        Structure::Compound(table) | Structure::Explicit(table) => {
            let object = json.as_object().ok_or_else(|| shape(own.id, "an object of subitems"))?;
            let known = |id: &String| table.iter().flatten().any(|sub| sub.id == id.as_str());
            if let Some(name) = object.keys().find(|id| !known(id)) {
                return Err(unknown(own, name));
            }
            if object.is_empty() {
                return items.compound_of_nothing(own);
            }
            items.compound(own, |inner| {
                for sub in table.iter().flatten() {
                    if let Some(value) = object.get(sub.id) {
                        put(inner, sub, value)?;
                    }
                }
                Ok(())
            })
        }
    }
}

fn unknown(own: &Item, name: &str) -> EncodeError {
    EncodeError::field(own.id, name, Reason::Unknown)
}

fn read_part(
    own: &Item,
    part: &Part,
    json: &Json,
    values: &mut Vec<Value>,
) -> Result<(), EncodeError> {
    let fields = || part.fields.iter().filter(|f| !matches!(f.kind, Kind::Spare));
    let single = fields().next().filter(|_| part.values() == 1);
    let Some(object) = json.as_object() else {
        let field = single.ok_or_else(|| shape(own.id, "an object of fields"))?;
        values.push(read_scalar(own, field, Some(json))?);
        return Ok(());
    };
    if let (Some(field), 1) = (single, object.len()) {
        values.push(read_scalar(own, field, object.values().next())?);
        return Ok(());
    }
    if let Some(name) = object.keys().find(|name| !fields().any(|f| f.name == name.as_str())) {
        return Err(unknown(own, name));
    }
    for field in fields() {
        values.push(read_scalar(own, field, object.get(field.name))?);
    }
    Ok(())
}

fn read_scalar(own: &Item, field: &Field, json: Option<&Json>) -> Result<Value, EncodeError> {
    let error = |reason| EncodeError::field(own.id, field.name, Reason::Value(reason));
    let text = matches!(field.kind, Kind::Ascii | Kind::Ident);
    match json {
        None if text => Ok(Value::Text(crate::value::Text::default())),
        None => Ok(Value::Integer(0)),
        Some(Json::Number(n)) => n
            .as_i64()
            .map(Value::Integer)
            .or_else(|| n.as_f64().map(Value::Number))
            .ok_or_else(|| error(ValueError::NotFinite)),
        Some(Json::String(text)) => Ok(Value::Text(
            crate::value::Text::of(text).ok_or_else(|| error(ValueError::TooLong(8)))?,
        )),
        Some(Json::Bool(b)) => Ok(Value::Integer(i64::from(*b))),
        Some(_) => Err(error(ValueError::Kind("a number or a text"))),
    }
}

/// Octets of a text of hexadecimal digits.
#[must_use]
pub fn octets(text: &str) -> Option<Vec<u8>> {
    let digit = |b: &u8| char::from(*b).to_digit(16).map(|d| d as u8);
    let digits: Option<Vec<u8>> = text.as_bytes().iter().map(digit).collect();
    let digits = digits.filter(|d| d.len().is_multiple_of(2))?;
    Some(digits.chunks_exact(2).map(|pair| pair[0] << 4 | pair[1]).collect())
}
