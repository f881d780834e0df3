//! How enumerations stand in messages: each value as its word, so that JSON says what people say, and no other word is a message.

use models::words::Word;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serializer};

/// Writes the word of a value.
pub(crate) fn serialize<T: Word, S: Serializer>(value: &T, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(&value.said())
}

/// Reads the value of a word.
pub(crate) fn deserialize<'de, T: Word, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
    let word = String::deserialize(from)?;
    T::named(&word).ok_or_else(|| unknown::<T, D>(&word))
}

fn unknown<'de, T: Word, D: Deserializer<'de>>(word: &str) -> D::Error {
    let word: String = word.chars().take(32).collect();
    D::Error::custom(format!("{word:?} is not a valid {}", T::WHAT))
}

/// The same of what may be absent: the empty word.
pub(super) mod or_none {
    use super::{Deserialize, Deserializer, Serializer, Word, unknown};

    pub(crate) fn serialize<T: Word, S: Serializer>(
        value: &Option<T>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        to.serialize_str(&value.as_ref().map(Word::said).unwrap_or_default())
    }

    pub(crate) fn deserialize<'de, T: Word, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Option<T>, D::Error> {
        let word = String::deserialize(from)?;
        if word.is_empty() {
            return Ok(None);
        }
        T::named(&word).map(Some).ok_or_else(|| unknown::<T, D>(&word))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{SeatAction, WantNotice};
    use crate::runtime::codec::{decode, encode};
    use models::control::clearance::ClearanceKind;
    use serde::{Deserialize, Serialize};

    /// A notice as somebody else may write it, with any word and any letter.
    #[derive(Serialize)]
    struct Other {
        #[serde(with = "super")]
        kind: Raw,
        #[serde(with = "super::or_none")]
        then: Option<Raw>,
    }

    #[derive(Debug, Deserialize, PartialEq, Serialize)]
    struct Ours {
        #[serde(with = "super")]
        kind: ClearanceKind,
        #[serde(with = "super::or_none")]
        then: Option<ClearanceKind>,
    }

    struct Raw(&'static str);

    impl super::Word for Raw {
        const WHAT: &'static str = "word";
        fn words() -> Vec<std::borrow::Cow<'static, str>> {
            Vec::new()
        }
        fn said(&self) -> std::borrow::Cow<'static, str> {
            self.0.into()
        }
        fn named(_: &str) -> Option<Self> {
            None
        }
    }

    #[test]
    fn a_word_arrives_as_its_value_and_no_other_word_does() {
        let read = |kind, then| {
            decode::<Ours>(&encode(&Other { kind: Raw(kind), then })).map_err(|e| e.to_string())
        };
        let [taxi, hold] = [ClearanceKind::Taxi, ClearanceKind::Hold];
        assert_eq!(read("TAX", None), Ok(Ours { kind: taxi, then: None }));
        assert_eq!(read("TAX", Some(Raw("HLD"))), Ok(Ours { kind: taxi, then: Some(hold) }));
        for (kind, then) in [("FLY", None), ("", None), ("TAX", Some(Raw("tax")))] {
            let refused = read(kind, then).expect_err("no clearance");
            assert!(refused.contains("is not a valid clearance"), "{refused}");
        }
        let want = WantNotice {
            flight: 3,
            kind: ClearanceKind::LineUp,
            group: 0,
            runway: "28".to_owned(),
            asks: true,
        };
        let said = serde_json::to_value(&want).expect("JSON");
        assert_eq!(said["kind"], "LUP", "people read the word");
        assert_eq!(decode::<WantNotice>(&encode(&want)).ok(), Some(want));
    }

    #[test]
    fn a_person_is_told_which_words_there_are() {
        let said = SeatAction::of("say", "SWR1", "TAX").expect("sound");
        assert_eq!(said.said(), ("SWR1", "TAX".into()));
        let refused = SeatAction::of("say", "SWR1", "FLY").expect_err("no clearance");
        assert!(refused.starts_with("there is no clearance \"FLY\": BTR, CRO, "), "{refused}");
        let refused = SeatAction::of("accept", "SWR1", &"x".repeat(500)).expect_err("no advice");
        assert!(refused.starts_with("there is no kind of advice \"xxx") && refused.len() < 200);
    }
}
