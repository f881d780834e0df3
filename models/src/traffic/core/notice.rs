//! What comes into a core from outside: clearances, holds and failures, each with an effect frame.
//!
//! Whoever produces one (a controller, a person, a failure of the scene) asks for a frame; the core applies it at the
//! later of that and the next frame, in the order (effect frame, source, sequence). So equal notices give equal
//! bits, also in a replay and in whoever simulates itself to the present.

use super::hand::Wish;
use super::{Core, Phase};
use crate::control::clearance::ClearanceKind;

/// Who clears the movers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ClearedBy {
    /// Everything is cleared as the plan comes to it.
    #[default]
    Plan,
    /// Nothing without a notice: `PSH`, `TAX`, `CRO`, `LUP`, `TOF`, `LND`. A clearance is permission; space is still the
    /// core's.
    Notices,
    /// As by notices, which the core's own controllers give.
    Controllers,
}

/// What is asked of a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// May do this once, from now on (`TAX` also ends a hold); `GOA` sends an arrival around.
    Clear(ClearanceKind),
    /// Does this by a person's word: onto a runway whoever has it, with nothing but eyes.
    Insist(ClearanceKind),
    /// May not do it any more, if it has not begun; a take-off run stops if it still can.
    Revoke(ClearanceKind),
    /// Holds position where it can stop, until `TAX`.
    Hold,
    /// Stands still for so long, s: an engine, a tyre, somebody asleep.
    Stop(f64),
    /// A person takes a driven mover,
    Take,
    /// gives it up, so that it brakes and stands,
    Leave,
    /// and drives it.
    Drive(Wish),
}

impl Order {
    /// What a flight does that is told so by a controller: a model, or a person.
    #[must_use]
    pub fn told(kind: ClearanceKind, by_person: bool) -> Self {
        match kind {
            ClearanceKind::Hold => Self::Hold,
            ClearanceKind::Revoke => Self::Revoke(ClearanceKind::TakeOff),
            // Whoever is told to goes around, cleared or not.
            ClearanceKind::GoAround => Self::Insist(kind),
            kind if by_person => Self::Insist(kind),
            kind => Self::Clear(kind),
        }
    }
}

/// One input.
#[derive(Clone, Debug, PartialEq)]
pub struct Notice {
    /// Frame from which it holds.
    pub effect_frame: i64,
    /// Who said it.
    pub source: String,
    /// Number of its source.
    pub sequence: u64,
    /// Flight (index into [`Core::flights`]), or a driven mover (from [`Core::first_driven`] on).
    pub flight: usize,
    /// What is asked.
    pub order: Order,
}

/// Permissions of a mover, one bit a kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Granted(u16);

impl Granted {
    fn bit(kind: ClearanceKind) -> u16 {
        1 << (kind as u16)
    }

    pub(super) fn set(&mut self, kind: ClearanceKind, on: bool) {
        if on {
            self.0 |= Self::bit(kind);
        } else {
            self.0 &= !Self::bit(kind);
        }
    }

    pub(super) fn has(self, kind: ClearanceKind) -> bool {
        self.0 & Self::bit(kind) != 0
    }

    pub(super) fn bits(self) -> u16 {
        self.0
    }
}

/// Notices that wait at most; beyond that the one whose turn is last is left out and remarked.
const MOST_WAITING: usize = 10_000;

/// From the words of a take-off clearance to the roll it takes about so long, s.
const SOON_S: f64 = 12.0;

impl Core {
    /// The same core with somebody else who clears, before its first step.
    #[must_use]
    pub fn cleared_by(mut self, who: ClearedBy) -> Self {
        self.cleared_by = who;
        self
    }

    /// Takes a notice in; the frame at which it takes effect.
    pub fn notice(&mut self, notice: Notice) -> i64 {
        let effect_frame = notice.effect_frame.max(self.frame + 1);
        if self.waiting.len() >= MOST_WAITING || !self.takes(&notice) {
            self.remark(format!("a notice of {} was left out", notice.source));
            return effect_frame;
        }
        let notice = Notice { effect_frame, ..notice };
        let key = |n: &Notice| (n.effect_frame, n.source.clone(), n.sequence);
        let at = self.waiting.partition_point(|n| key(n) <= key(&notice));
        self.waiting.insert(at, notice);
        effect_frame
    }

    /// Whether there is such a mover, and it can do that.
    fn takes(&self, notice: &Notice) -> bool {
        let by_hand = matches!(notice.order, Order::Take | Order::Leave | Order::Drive(_));
        let hand = notice.flight.checked_sub(self.first_driven());
        match by_hand {
            true => {
                hand.is_some_and(|n| n < self.hands.len())
                    || self.flights_by_hand && notice.flight < self.flights.len()
            }
            false => notice.flight < self.flights.len(),
        }
    }

    pub(super) fn apply_notices(&mut self) {
        while self.waiting.first().is_some_and(|n| n.effect_frame <= self.frame) {
            let notice = self.waiting.remove(0);
            let (m, now) = (notice.flight, self.time_s);
            if m >= self.flights.len() {
                self.drive_by_hand(m - self.first_driven(), notice.order);
                continue;
            }
            match notice.order {
                Order::Take | Order::Leave | Order::Drive(_) => {
                    self.fly_by_hand(m, notice.order);
                }
                // One that is cleared to land has the runway already, and lands; a person may think better of it.
                Order::Clear(ClearanceKind::GoAround) => {
                    let mover = &self.movers[m];
                    if mover.phase == Phase::Final && !mover.cleared {
                        self.go_around(m, "it was told to");
                    }
                }
                Order::Clear(kind) | Order::Insist(kind) => {
                    match notice.order {
                        Order::Insist(kind) => self.insist(m, kind),
                        _ => self.movers[m].granted.set(kind, true),
                    }
                    if self.movers[m].wants == Some(kind) {
                        self.movers[m].wants = None;
                    }
                    if kind == ClearanceKind::Taxi && self.movers[m].holds {
                        self.movers[m].holds = false;
                        self.taxies_again(m);
                    }
                }
                Order::Revoke(kind) => {
                    self.used(m, kind);
                    if kind == ClearanceKind::TakeOff {
                        self.cancel_take_off(m);
                    }
                }
                Order::Hold if self.movers[m].holds => {}
                Order::Hold => {
                    self.movers[m].holds = true;
                    self.end_clearance(m, "TAX");
                    self.clear(m, "HLD", String::new());
                }
                Order::Stop(for_s) => {
                    let until = now + for_s.max(0.0);
                    self.movers[m].stopped_until_s = self.movers[m].stopped_until_s.max(until);
                }
            }
            self.movers[m].refused_at = None;
        }
    }

    /// Who held may taxi on: what that ended stands again.
    fn taxies_again(&mut self, m: usize) {
        let flight = self.movers[m].flight;
        let of = |kind: &str| {
            let mut latest = self.clearances.iter().rev();
            latest.find(|c| c.flight == flight && c.kind == kind).map(|c| (c.from_s, c.until_s))
        };
        let (held, taxied) = (of("HLD"), of("TAX"));
        self.end_clearance(m, "HLD");
        let held_from_s = held.map(|(from_s, _)| from_s);
        if held_from_s.is_some() && taxied.is_some_and(|(_, until_s)| until_s == held_from_s) {
            self.clear(m, "TAX", String::new());
        }
    }

    /// Whether a mover may do this now; if not, that it wants to.
    pub(super) fn permitted(&mut self, m: usize, kind: ClearanceKind) -> bool {
        let asks = self.cleared_by != ClearedBy::Plan && !self.is_vehicle(m);
        let may = !asks || self.movers[m].granted.has(kind);
        self.movers[m].wants = (!may).then_some(kind);
        may
    }

    /// One that is lined up is cleared to take off when the wake of the one before is nearly gone, not only then.
    pub(super) fn asks_for_take_off(&mut self, m: usize) {
        let soon = self.cleared_by != ClearedBy::Plan
            && self.wake_left_s(m) <= SOON_S
            && !self.car_blocks(self.flights[m].runway.0);
        if soon {
            self.permitted(m, ClearanceKind::TakeOff);
        }
    }

    /// A permission has been used, or is void.
    pub(super) fn used(&mut self, m: usize, kind: ClearanceKind) {
        self.movers[m].granted.set(kind, false);
        self.movers[m].insisted.set(kind, false);
    }

    /// The clearance that a flight waits for.
    #[must_use]
    pub fn wants(&self, flight: usize) -> Option<ClearanceKind> {
        self.movers[flight].wants
    }
}
