//! Advice in words, as seats, the log and pages get it.

use crate::runtime::messages::{AdviceNotice, Frame};
use models::control::advice::{Advice, Became, What};
use models::control::clearance::ClearanceKind;
use models::time::SimTime;

/// Who gives way is held for about so long, s (assumed).
const HELD_S: f64 = 30.0;

/// Names of what an advice is about.
pub(super) struct Names<'a> {
    /// Call signs of the flights, in their order.
    pub(super) callsigns: &'a [String],
    /// Runways of the network, both ends of each.
    pub(super) runways: &'a [String],
    /// Runways of the safety net's layout, both ends of each.
    pub(super) axes: &'a [String],
    /// Stands of the network.
    pub(super) stands: &'a [String],
    /// UTC of the begin of the run, ns.
    pub(super) start_utc_ns: i64,
}

impl Names<'_> {
    fn flight(&self, flight: u32) -> &str {
        self.callsigns.get(flight as usize).map_or("", String::as_str)
    }

    /// Whoever it is, by name or not.
    fn other(&self, a: &Advice) -> &str {
        a.other.map_or("somebody without a name", |other| self.flight(other))
    }

    /// UTC of a time of the run.
    fn clock(&self, s: f64) -> String {
        let of_day_s = (self.start_utc_ns / 1_000_000_000 + s.round() as i64).rem_euclid(86_400);
        format!("{:02}:{:02}:{:02}", of_day_s / 3600, of_day_s / 60 % 60, of_day_s % 60)
    }

    /// What to do, and what happens otherwise.
    fn words(&self, a: &Advice) -> (String, String) {
        let name = self.flight(a.flight);
        let of = |all: &[String], at: usize| all.get(at).cloned().unwrap_or_default();
        match a.what {
            What::HoldAtStand { runway, take_off_s, before } => {
                let behind =
                    a.other.map_or(String::new(), |f| format!(" behind {}", self.flight(f)));
                let (until, take_off) = (self.clock(a.until_s), self.clock(take_off_s));
                let runway = of(self.runways, runway);
                (
                    format!(
                        "hold {name} at its stand until {until}: it takes off from {runway} at {take_off}{behind}, \
                         {before} before it"
                    ),
                    format!("waits {:.0} s longer at the line, with engines running", a.value),
                )
            }
            What::ConflictAhead { meets_s, behind_s, .. } => {
                let (other, meets) = (self.other(a), self.clock(meets_s));
                (
                    format!(
                        "hold {name}: its way meets that of {other} at {meets}, {behind_s:.0} s behind it"
                    ),
                    format!("stops for {other} where they meet"),
                )
            }
            What::Gap { clearance, runway, open, opens_s, lands_s, needs_s } => {
                let runway = of(self.axes, runway);
                let does = match clearance {
                    ClearanceKind::Cross => "cross",
                    _ => "line up and take off from",
                };
                let (other, opens) = (self.other(a), self.clock(opens_s));
                match lands_s {
                    Some(lands_s) if open => (
                        format!(
                            "{name} can {does} {runway} now: {other} lands at {}, it needs {needs_s:.0} s",
                            self.clock(lands_s)
                        ),
                        format!(
                            "waits about {:.0} s longer, until {other} is off the runway",
                            a.value
                        ),
                    ),
                    Some(_) => (
                        format!(
                            "{name} can {does} {runway} behind {other}, from {opens}: the gap has {:.0} s more than the \
                             {needs_s:.0} s that it needs",
                            a.value
                        ),
                        "waits for a later gap".to_owned(),
                    ),
                    None => (
                        format!(
                            "{name} can {does} {runway} behind {other}, from {opens}: nobody is seen to land after it"
                        ),
                        "waits for a later gap".to_owned(),
                    ),
                }
            }
            What::StandConflict { stand, free_s, comes_s, instead } => {
                let (other, stand) = (self.other(a), of(self.stands, stand));
                let until = free_s.map_or("and nobody knows when it leaves".to_owned(), |s| {
                    format!("until about {}", self.clock(s))
                });
                let instead = instead.map_or("none that is free is large enough".to_owned(), |s| {
                    format!("{} is free", of(self.stands, s))
                });
                (
                    format!(
                        "{name} comes to stand {stand} at {}, {other} is there {until}: {instead}",
                        self.clock(comes_s)
                    ),
                    format!("waits {:.0} s or longer before its stand", a.value),
                )
            }
        }
    }

    /// The question what would be if it were followed, as a person asks it; none where nothing can be asked.
    pub(super) fn question(&self, a: &Advice, now_s: f64) -> Option<String> {
        match a.what {
            What::HoldAtStand { .. } => {
                let for_s = (a.until_s - now_s).round();
                (for_s > 0.0).then(|| format!("HOLD {for_s:.0}"))
            }
            What::ConflictAhead { .. } => Some(format!("HOLD {HELD_S:.0}")),
            What::StandConflict { instead, .. } => {
                instead.and_then(|s| self.stands.get(s)).map(|name| format!("STAND {name}"))
            }
            What::Gap { .. } => None,
        }
    }

    /// An advice as it stands after something became of it.
    pub(super) fn notice(&self, frame: Frame, change: Became, a: &Advice) -> AdviceNotice {
        let (text, otherwise) = self.words(a);
        let subjects = [Some(a.flight), a.other].into_iter().flatten().map(|f| self.flight(f));
        AdviceNotice {
            id: a.id,
            frame,
            change,
            kind: a.kind(),
            seat: a.seat.name(),
            subjects: subjects.collect::<Vec<_>>().join(" "),
            text,
            value: a.value.round(),
            unit: a.kind().unit().to_owned(),
            otherwise,
            until_ns: SimTime::from_s(a.until_s).0,
            decision: a.decision.0,
            by_person: a.decision.1,
        }
    }
}
