//! The fields of a PDU as a tree: for people, for JSON, for comparison.
//!
//! Made from the `Debug` form of the values, so that every type of PDU and every record has it.

use super::json;
use std::fmt::{Debug, Write};

/// A value with its parts.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number (NaN and infinities too), as written.
    Number(String),
    /// A number of an enumeration with its name.
    Named {
        /// The number on the wire.
        number: String,
        /// Its name.
        name: String,
    },
    /// Anything that is no number.
    Text(String),
    /// Several values.
    List(Vec<Value>),
    /// Fields.
    Record(Vec<(String, Value)>),
}

impl Value {
    /// The tree of a value.
    pub fn of(value: &impl Debug) -> Self {
        let text = format!("{value:?}");
        let mut parser = Parser { text: &text, at: 0 };
        parser.value()
    }

    /// As JSON. A value of an enumeration is its number; its name is only for people.
    #[must_use]
    pub fn json(&self) -> String {
        let mut out = String::new();
        self.write_json(&mut out);
        out
    }

    fn write_json(&self, out: &mut String) {
        match self {
            Self::Number(n) if n.parse::<f64>().is_ok_and(f64::is_finite) => out.push_str(n),
            // JSON has no NaN and no infinity.
            Self::Number(t) | Self::Text(t) => json::string(out, t),
            Self::Named { number, .. } => out.push_str(number),
            Self::List(items) => {
                out.push('[');
                for (i, item) in items.iter().enumerate() {
                    if i > 0 {
                        out.push(',');
                    }
                    item.write_json(out);
                }
                out.push(']');
            }
            Self::Record(fields) => {
                out.push('{');
                for (i, (name, value)) in fields.iter().enumerate() {
                    if i > 0 {
                        out.push(',');
                    }
                    json::string(out, name);
                    out.push(':');
                    value.write_json(out);
                }
                out.push('}');
            }
        }
    }

    /// One line a field: `name.part[2] = value`.
    #[must_use]
    pub fn lines(&self) -> Vec<(String, String)> {
        let mut lines = Vec::new();
        self.flatten(&mut String::new(), &mut lines);
        lines
    }

    fn flatten(&self, path: &mut String, lines: &mut Vec<(String, String)>) {
        let len = path.len();
        match self {
            Self::Record(fields) => {
                for (name, value) in fields {
                    let _ = write!(path, "{}{name}", if len > 0 { "." } else { "" });
                    value.flatten(path, lines);
                    path.truncate(len);
                }
            }
            Self::List(items) if items.iter().all(|i| matches!(i, Self::Number(_))) => {
                let all: Vec<String> = items.iter().map(Self::plain).collect();
                lines.push((path.clone(), format!("[{}]", all.join(" "))));
            }
            Self::List(items) => {
                for (i, item) in items.iter().enumerate() {
                    let _ = write!(path, "[{i}]");
                    item.flatten(path, lines);
                    path.truncate(len);
                }
            }
            plain => lines.push((path.clone(), plain.plain())),
        }
    }

    fn plain(&self) -> String {
        match self {
            Self::Number(t) | Self::Text(t) => t.clone(),
            Self::Named { number, name } => format!("{name} ({number})"),
            Self::List(_) | Self::Record(_) => String::new(),
        }
    }
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
}

impl Parser<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn skip(&mut self, what: char) -> bool {
        let found = self.rest().starts_with(what);
        self.at += if found { what.len_utf8() } else { 0 };
        found
    }

    fn blanks(&mut self) {
        self.at += self.rest().len() - self.rest().trim_start().len();
    }

    fn value(&mut self) -> Value {
        self.blanks();
        if self.skip('[') {
            return Value::List(self.items(']'));
        }
        if self.rest().starts_with('"') {
            return Value::Text(self.quoted());
        }
        let word_len = self
            .rest()
            .find(|c: char| !(c.is_alphanumeric() || "_-+.#:".contains(c)))
            .unwrap_or(self.rest().len());
        let word = self.rest()[..word_len].to_owned();
        self.at += word_len;
        let before = self.at;
        self.blanks();
        if self.skip('{') {
            return Value::Record(self.fields());
        }
        self.at = before;
        if self.rest().starts_with('(') {
            return self.tuple(&word);
        }
        if word.is_empty() {
            // Nothing that `Debug` writes: taken as it is, so that parsing always goes on.
            let rest = self.rest().chars().next();
            self.at += rest.map_or(0, char::len_utf8);
            return Value::Text(rest.map(String::from).unwrap_or_default());
        }
        plain(word)
    }

    /// `Name(…)`: an enumeration, a wrapped value, or several.
    fn tuple(&mut self, word: &str) -> Value {
        let inside_len = balanced(&self.rest()[1..]);
        let inside = self.rest()[1..1 + inside_len].to_owned();
        let start = self.at + 1;
        if let Some(named) = enumerated(&inside) {
            self.at = (start + inside_len + 1).min(self.text.len());
            return named;
        }
        let looks_like_value = inside.starts_with(['[', '"']) || inside.contains(['{', ',', '(']);
        if !looks_like_value {
            self.at = (start + inside_len + 1).min(self.text.len());
            return plain(inside);
        }
        self.at = start;
        let mut items = self.items(')');
        match items.len() {
            1 => {
                let only = items.remove(0);
                // The kind of a record that comes in several kinds.
                match only {
                    Value::Record(fields) if word != "Some" && !word.is_empty() => {
                        Value::Record(vec![(word.to_owned(), Value::Record(fields))])
                    }
                    other => other,
                }
            }
            _ => Value::List(items),
        }
    }

    fn items(&mut self, end: char) -> Vec<Value> {
        let mut items = Vec::new();
        loop {
            self.blanks();
            if self.skip(end) || self.rest().is_empty() {
                return items;
            }
            items.push(self.value());
            self.blanks();
            self.skip(',');
        }
    }

    fn fields(&mut self) -> Vec<(String, Value)> {
        let mut fields = Vec::new();
        loop {
            self.blanks();
            if self.skip('}') || self.rest().is_empty() {
                return fields;
            }
            let Some(colon) = self.rest().find([':', '}']) else {
                self.at = self.text.len();
                return fields;
            };
            let name = self.rest()[..colon].trim().to_owned();
            self.at += colon;
            self.skip(':');
            let value = self.value();
            if !name.is_empty() {
                fields.push((name, value));
            }
            self.blanks();
            self.skip(',');
        }
    }

    fn quoted(&mut self) -> String {
        let mut out = String::new();
        let mut chars = self.text[self.at + 1..].char_indices();
        let mut end = self.text.len();
        while let Some((i, c)) = chars.next() {
            match c {
                '"' => {
                    end = self.at + 1 + i + 1;
                    break;
                }
                '\\' => match chars.next() {
                    Some((_, 'n')) => out.push('\n'),
                    Some((_, 't')) => out.push('\t'),
                    Some((_, 'r')) => out.push('\r'),
                    Some((_, '0')) => out.push('\0'),
                    Some((_, other)) => out.push(other),
                    None => {}
                },
                c => out.push(c),
            }
        }
        self.at = end;
        out
    }
}

/// Octets up to the bracket that closes what was opened before `text`.
fn balanced(text: &str) -> usize {
    let (mut depth, mut quoted, mut escaped) = (1, false, false);
    for (i, c) in text.char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' if quoted => escaped = true,
            '"' => quoted = !quoted,
            '(' if !quoted => depth += 1,
            ')' if !quoted => {
                depth -= 1;
                if depth == 0 {
                    return i;
                }
            }
            _ => {}
        }
    }
    text.len()
}

/// `Name (3)`, as the enumerations of `pdu` show themselves.
fn enumerated(inside: &str) -> Option<Value> {
    let (name, number) = inside.strip_suffix(')')?.rsplit_once(" (")?;
    let is_number = !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit());
    let is_name = !name.contains(['{', '[', '"']);
    (is_number && is_name)
        .then(|| Value::Named { number: number.to_owned(), name: name.to_owned() })
}

fn plain(word: String) -> Value {
    let numeric = matches!(word.as_str(), "NaN" | "inf" | "-inf") || word.parse::<f64>().is_ok();
    if numeric { Value::Number(word) } else { Value::Text(word) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pdu::enumerations::{ActionId, ForceId};
    use pdu::records::{EntityId, Marking};
    use pdu::{DisTime, EntityState, List, management, records::FixedDatum};

    #[test]
    fn an_entity_state_has_all_its_fields() {
        let mut state = EntityState {
            entity_id: EntityId::new(1, 2, 3),
            force_id: ForceId(1),
            marking: Marking::new("a \"b\", c").unwrap(),
            ..EntityState::default()
        };
        state.location.x_m = f64::NAN;
        state.linear_velocity_mps.y = -1.5;
        let value = Value::of(&state);
        let lines = value.lines();
        let get = |name: &str| {
            let line = lines.iter().find(|(n, _)| n == name);
            line.unwrap_or_else(|| panic!("{name} in {lines:?}")).1.clone()
        };
        assert_eq!(get("entity_id.application"), "2");
        assert_eq!(get("force_id"), "Friendly (1)");
        assert_eq!(get("marking"), "a \"b\", c");
        assert_eq!(get("location.x_m"), "NaN");
        assert_eq!(get("linear_velocity_mps.y"), "-1.5");
        assert_eq!(get("dead_reckoning_parameters"), format!("[{}]", ["0"; 15].join(" ")));
        let json = value.json();
        assert!(json.contains(r#""force_id":1,"#), "{json}");
        assert!(json.contains(r#""x_m":"NaN","y_m":0.0"#), "{json}");
    }

    #[test]
    fn names_with_brackets_and_lists_of_records() {
        let datums = [FixedDatum { id: pdu::enumerations::DatumId(7), value: [1, 2, 3, 4] }; 2];
        let request = management::ActionRequest {
            action_id: ActionId::START_DRC,
            fixed_datums: List::from(&datums[..]),
            ..Default::default()
        };
        let lines = Value::of(&request).lines();
        assert!(
            lines.contains(&(
                "action_id".to_owned(),
                "Start DRC (Daily Readiness Check) (20)".to_owned()
            )),
            "{lines:?}"
        );
        assert!(lines.contains(&("fixed_datums[1].value".to_owned(), "[1 2 3 4]".to_owned())));
        let time = Value::of(&(DisTime::relative(61_500_000_000),));
        let raw = DisTime::relative(61_500_000_000).0;
        assert_eq!(time.lines()[0].1, format!("01:01.500000 relative ({raw})"));
        assert_eq!(time.json(), raw.to_string());
    }

    proptest::proptest! {
        #[test]
        fn any_text_ends(text in ".{0,80}") {
            let mut parser = Parser { text: &text, at: 0 };
            let _ = parser.value().json();
        }
    }
}
