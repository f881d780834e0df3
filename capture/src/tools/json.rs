//! The little JSON that the tools write.

use std::fmt::Write;

/// Appends `text` as a JSON string.
pub fn string(out: &mut String, text: &str) {
    out.push('"');
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            c if (c as u32) < 0x20 => {
                let _ = write!(out, "\\u{:04x}", c as u32);
            }
            c => out.push(c),
        }
    }
    out.push('"');
}

/// An object that is written member by member.
#[derive(Debug)]
pub struct Object(String);

impl Default for Object {
    fn default() -> Self {
        Self("{".to_owned())
    }
}

impl Object {
    /// Adds a member whose value is JSON already.
    #[must_use]
    pub fn raw(mut self, name: &str, value: impl std::fmt::Display) -> Self {
        if self.0.len() > 1 {
            self.0.push(',');
        }
        string(&mut self.0, name);
        let _ = write!(self.0, ":{value}");
        self
    }

    /// Adds a text.
    #[must_use]
    pub fn text(self, name: &str, value: impl std::fmt::Display) -> Self {
        let mut quoted = String::new();
        string(&mut quoted, &value.to_string());
        self.raw(name, quoted)
    }

    /// The object, whole.
    #[must_use]
    pub fn end(mut self) -> String {
        self.0.push('}');
        self.0
    }
}

/// An object of counts by number or name.
pub fn counts<K: std::fmt::Display>(counts: impl IntoIterator<Item = (K, u64)>) -> String {
    counts.into_iter().fold(Object::default(), |o, (k, n)| o.raw(&k.to_string(), n)).end()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_escaped() {
        let object = Object::default().text("a\"b", "c\\\n\u{1}é").raw("n", 3).end();
        assert_eq!(object, r#"{"a\"b":"c\\\u000a\u0001é","n":3}"#);
        assert_eq!(counts([(1u8, 2u64), (5, 6)]), r#"{"1":2,"5":6}"#);
        assert_eq!(Object::default().end(), "{}");
    }
}
