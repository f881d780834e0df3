//! What controllers, pilots and drivers say to each other: one form for models and people.

use crate::control::clearance::ClearanceKind;
use crate::words::words;

/// Who speaks or listens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Seat {
    /// Clearance and apron: push-backs.
    Apron,
    /// Ground: taxiing.
    Ground,
    /// Tower of a group of runways that cross each other, by number.
    Tower(u8),
    /// Pilot or driver of a flight, by its index.
    Flight(u32),
}

impl Seat {
    /// Its name in tables ("tower 1").
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Apron => "apron".into(),
            Self::Ground => "ground".into(),
            Self::Tower(group) => format!("tower {}", u32::from(group) + 1),
            Self::Flight(flight) => format!("flight {flight}"),
        }
    }

    /// The controller's seat of a name; none where it is nobody's or a flight's.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "apron" => Some(Self::Apron),
            "ground" => Some(Self::Ground),
            _ => {
                let number: u8 = name.strip_prefix("tower ")?.parse().ok()?;
                let seat = Self::Tower(number.checked_sub(1)?);
                (seat.name() == name).then_some(seat)
            }
        }
    }

    /// The controller who gives a clearance of a kind; `group`: of the runway concerned.
    #[must_use]
    pub fn of(kind: ClearanceKind, group: u8) -> Self {
        match kind {
            ClearanceKind::Push => Self::Apron,
            ClearanceKind::Taxi | ClearanceKind::Hold => Self::Ground,
            _ => Self::Tower(group),
        }
    }
}

/// What a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageKind {
    /// A pilot or driver asks for it.
    Request,
    /// A controller gives it.
    Clearance,
    /// A pilot or driver says it back as he heard it.
    Readback,
    /// A controller heard another one than he gave, and says it again.
    Correction,
}

words! {
    "kind of a message": MessageKind {
        Request = "request",
        Clearance = "clearance",
        Readback = "readback",
        Correction = "correction",
    }
}

/// One message, as it goes over a frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Message {
    /// Who says it.
    pub from: Seat,
    /// To whom.
    pub to: Seat,
    /// Frame at whose time its last word is spoken.
    pub at_frame: i64,
    /// What it is.
    pub kind: MessageKind,
    /// What it is about.
    pub body: ClearanceKind,
}

/// Words of a message about a clearance (assumed).
#[must_use]
pub fn words(kind: MessageKind, about: ClearanceKind) -> u32 {
    use ClearanceKind::{Cross, GoAround, Hold, Land, LineUp, Push, Revoke, TakeOff, Taxi};
    let clearance = match about {
        Push => 8,
        Taxi => 12,
        Cross => 7,
        LineUp | TakeOff | Land => 6,
        GoAround | Revoke => 4,
        Hold => 3,
        _ => 8,
    };
    match kind {
        MessageKind::Request => 6,
        MessageKind::Clearance | MessageKind::Readback => clearance,
        MessageKind::Correction => clearance + 2,
    }
}
