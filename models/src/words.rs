//! Words of enumerations: what a value is called in scenes, messages, tables and the database, and the value of a word.

use std::borrow::Cow;

/// A value that has a word of its own, and is found by it.
pub trait Word: Sized {
    /// What such a value is, for sentences ("status of a track").
    const WHAT: &'static str;

    /// Every word, in the order of the values.
    fn words() -> Vec<Cow<'static, str>>;

    /// Its word.
    fn said(&self) -> Cow<'static, str>;

    /// The value of a word; none where there is no such word.
    fn named(word: &str) -> Option<Self>;
}

/// Values of an enumeration, each with its one word: writes `ALL`, `word`, `of` and [`Word`].
macro_rules! words {
    ($what:literal: $name:ident { $($value:ident = $word:literal,)+ }) => {
        impl $name {
            /// All of them, in their order.
            pub const ALL: [Self; [$($word),+].len()] = [$(Self::$value),+];

            /// Its word.
            #[must_use]
            pub fn word(self) -> &'static str {
                match self {
                    $(Self::$value => $word,)+
                }
            }

            /// The value of a word.
            #[must_use]
            pub fn of(word: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|value| value.word() == word)
            }
        }

        impl $crate::words::Word for $name {
            const WHAT: &'static str = $what;

            fn words() -> Vec<std::borrow::Cow<'static, str>> {
                Self::ALL.into_iter().map(|value| value.word().into()).collect()
            }

            fn said(&self) -> std::borrow::Cow<'static, str> {
                self.word().into()
            }

            fn named(word: &str) -> Option<Self> {
                Self::of(word)
            }
        }
    };
}
pub(crate) use words;

#[cfg(test)]
mod tests {
    use super::Word;
    use crate::control::actors::message::MessageKind;
    use crate::control::advice::{Became, Decision, Kind};
    use crate::control::alert::{AlertKind, Change, Stage};
    use crate::control::clearance::ClearanceKind;
    use crate::flight_list::{MovementKind, WakeCategory};
    use crate::plot::SensorKind;
    use crate::track::{TrackStatus, TrackType};
    use std::collections::BTreeSet;

    /// Every word names one value, and that value says it.
    fn one_to_one<T: Word>() {
        let words = T::words();
        let different: BTreeSet<_> = words.iter().collect();
        assert_eq!(different.len(), words.len(), "{}: {words:?}", T::WHAT);
        for word in &words {
            assert_eq!(
                T::named(word).map(|value| value.said()).as_ref(),
                Some(word),
                "{}",
                T::WHAT
            );
        }
        assert!(T::named("").is_none() && T::named("no such word").is_none(), "{}", T::WHAT);
    }

    #[test]
    fn a_word_is_one_value_and_a_value_one_word() {
        one_to_one::<AlertKind>();
        one_to_one::<Became>();
        one_to_one::<Change>();
        one_to_one::<ClearanceKind>();
        one_to_one::<Decision>();
        one_to_one::<Kind>();
        one_to_one::<MessageKind>();
        one_to_one::<MovementKind>();
        one_to_one::<SensorKind>();
        one_to_one::<Stage>();
        one_to_one::<TrackStatus>();
        one_to_one::<TrackType>();
        one_to_one::<WakeCategory>();
    }

    #[test]
    fn alerts_of_two_clearances_are_all_named_and_the_same_either_way_round() {
        let words = AlertKind::words();
        assert_eq!(words.len(), 17 + 12 * 13 / 2);
        let either = |a, b| AlertKind::Conflicting(a, b).word();
        let [cross, take_off] = [ClearanceKind::Cross, ClearanceKind::TakeOff];
        assert_eq!(either(cross, take_off), "CATC_CRO_TOF");
        assert_eq!(either(take_off, cross), "CATC_CRO_TOF");
    }
}
