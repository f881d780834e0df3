//! What people at controllers' seats, or programs in their place, say: asked of the member `visitors`, which stamps it into
//! a frame.

use super::words;
use models::control::advice;
use models::control::clearance::ClearanceKind;
use models::words::Word;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// What somebody does at a seat.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SeatAction {
    /// Sits down: the model of the seat decides nothing any more.
    Take,
    /// Gives it up to the model.
    Leave,
    /// Is still there.
    Here,
    /// Decides upon an advice.
    Decide {
        /// For whom it is: the first of its subjects.
        callsign: String,
        /// What kind of advice.
        #[serde(with = "words")]
        kind: advice::Kind,
        /// It is followed.
        accept: bool,
    },
    /// Asks what would be if: the answer is shown, nothing is done.
    WhatIf {
        /// Whom it is about.
        callsign: String,
        /// What is done otherwise: "HOLD 120" (s), "STAND A12", "RUNWAY 28".
        change: String,
    },
    /// Gives a clearance.
    Say {
        /// To whom.
        callsign: String,
        /// Which clearance.
        #[serde(with = "words")]
        clearance: ClearanceKind,
    },
    /// Gives an aircraft to the traffic, at the seat "handover".
    Give {
        /// Its call sign.
        callsign: String,
        /// Its state in words (`exchange::handover`).
        state: String,
    },
    /// Asks that a flight that climbs away be let go, at the same.
    Release {
        /// Its call sign.
        callsign: String,
    },
    /// Drives what the seat has, in thousandths: throttle −1000 (backwards) to 1000, brake 0 to 1000, steer −1000 (left) to 1000.
    Drive {
        /// Share of the largest speed.
        throttle: i16,
        /// Share of the brake.
        brake: i16,
        /// Share of the largest angle of the wheels.
        steer: i16,
    },
}

impl SeatAction {
    /// Its word.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Take => "take",
            Self::Leave => "leave",
            Self::Here => "here",
            Self::Decide { accept: true, .. } => "accept",
            Self::Decide { accept: false, .. } => "refuse",
            Self::WhatIf { .. } => "what-if",
            Self::Say { .. } => "say",
            Self::Give { .. } => "give",
            Self::Release { .. } => "release",
            Self::Drive { .. } => "drive",
        }
    }

    /// The action of a word; to whom and which clearance where it says one.
    ///
    /// # Errors
    /// What is wrong, in a sentence.
    pub fn of(word: &str, callsign: &str, clearance: &str) -> Result<Self, String> {
        match word {
            "take" => Ok(Self::Take),
            "leave" => Ok(Self::Leave),
            "here" => Ok(Self::Here),
            "say" if callsign.is_empty() || clearance.is_empty() => {
                Err("say: name a callsign and a clearance (\"TAX\")".to_owned())
            }
            "say" => Ok(Self::Say { callsign: callsign.to_owned(), clearance: read(clearance)? }),
            "accept" | "refuse" if callsign.is_empty() || clearance.is_empty() => Err(format!(
                "{word}: name the callsign and, as clearance, the kind of the advice (\"HOLD_STAND\")"
            )),
            "accept" | "refuse" => Ok(Self::Decide {
                callsign: callsign.to_owned(),
                kind: read(clearance)?,
                accept: word == "accept",
            }),
            "what-if" if callsign.is_empty() || clearance.is_empty() => Err(
                "what-if: name the callsign and, as clearance, what is done otherwise (\"HOLD 120\", \"STAND A12\" or \
                 \"RUNWAY 28\")"
                    .to_owned(),
            ),
            "what-if" => {
                Ok(Self::WhatIf { callsign: callsign.to_owned(), change: clearance.to_owned() })
            }
            "give" | "release" if callsign.is_empty() => {
                Err(format!("{word}: name the callsign of the aircraft"))
            }
            "give" => {
                Ok(Self::Give { callsign: callsign.to_owned(), state: clearance.to_owned() })
            }
            "release" => Ok(Self::Release { callsign: callsign.to_owned() }),
            "drive" => {
                let wish = clearance.split_whitespace().map(str::parse::<i16>);
                match wish.collect::<Result<Vec<_>, _>>().as_deref() {
                    Ok(&[throttle, brake, steer])
                        if throttle.abs() <= 1000
                            && (0..=1000).contains(&brake)
                            && steer.abs() <= 1000 =>
                    {
                        Ok(Self::Drive { throttle, brake, steer })
                    }
                    _ => Err("drive: give as clearance throttle (-1000 to 1000), brake (0 to 1000) and steer (-1000 to 1000) \
                         with blanks between, like \"300 0 -150\""
                        .to_owned()),
                }
            }
            other => {
                let other: String = other.chars().take(32).collect();
                Err(format!(
                    "there is no action {other:?}: take, leave, here, say, accept, refuse, what-if, give, release or drive"
                ))
            }
        }
    }

    /// To whom something is said, and what, which advice is decided upon, or how it is driven; empty where nothing is. What
    /// [`SeatAction::of`] reads.
    #[must_use]
    pub fn said(&self) -> (&str, Cow<'_, str>) {
        match self {
            Self::Say { callsign, clearance } => (callsign, clearance.said()),
            Self::Decide { callsign, kind, .. } => (callsign, kind.said()),
            Self::WhatIf { callsign, change } => (callsign, change.into()),
            Self::Give { callsign, state } => (callsign, state.into()),
            Self::Release { callsign } => (callsign, "".into()),
            Self::Drive { throttle, brake, steer } => {
                ("", format!("{throttle} {brake} {steer}").into())
            }
            _ => ("", "".into()),
        }
    }
}

/// The value that a person's word names.
fn read<T: Word>(word: &str) -> Result<T, String> {
    T::named(word).ok_or_else(|| {
        let word: String = word.chars().take(32).collect();
        format!("there is no {} {word:?}: {}", T::WHAT, T::words().join(", "))
    })
}

/// Somebody at a seat does something: a question to `seat/{name}/say`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SeatOrder {
    /// Name of the seat ("tower 1").
    pub seat: String,
    /// Who: one person holds a seat.
    pub person: String,
    /// What.
    pub action: SeatAction,
}

/// The same in words, flat, as pages, programs and files of inputs say it (JSON).
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeatWords {
    /// Name of the seat.
    pub seat: String,
    /// Who.
    pub person: String,
    /// Word of the action ("say").
    pub action: String,
    /// To whom, with `say`; of whom the advice is, with `accept` and `refuse`; whom it is about, with `what-if`.
    #[serde(default)]
    pub callsign: String,
    /// Which clearance, with `say`; which kind of advice, with `accept` and `refuse`; what is done otherwise, with `what-if`; throttle,
    /// brake and steer, with `drive`.
    #[serde(default)]
    pub clearance: String,
}

impl SeatWords {
    /// Of a JSON object whose other fields have been taken out.
    ///
    /// # Errors
    /// A field that is missing or not known.
    pub fn of(fields: serde_json::Map<String, serde_json::Value>) -> Result<Self, String> {
        serde_json::from_value(fields.into()).map_err(|e| e.to_string())
    }

    /// What is asked with them.
    ///
    /// # Errors
    /// What is wrong, in a sentence.
    pub fn read(self) -> Result<SeatOrder, String> {
        let Self { seat, person, action, callsign, clearance } = self;
        let action = SeatAction::of(&action, &callsign, &clearance)?;
        Ok(SeatOrder { seat, person, action })
    }
}

/// What is answered at once; whether a clearance was possible is told by control (`control/1/positions`).
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SeatAnswer {
    /// It goes into the next frame.
    pub accepted: bool,
    /// Its number, by which control answers.
    pub number: u64,
    /// Why not.
    pub text: String,
}

/// The same as it goes into a frame.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SeatInput {
    /// Counted in the run from 1.
    pub number: u64,
    /// What was asked.
    pub order: SeatOrder,
}

/// The seat at which aircraft are handed over.
pub const HANDOVER_SEAT: &str = "handover";

/// The key on which what is done at a seat is asked.
#[must_use]
pub fn seat_key(seat: &str) -> String {
    match seat {
        HANDOVER_SEAT => "visitors/1/handover".to_owned(),
        seat => format!("seat/{}/say", seat.replace(' ', "-")),
    }
}
