//! Clearances: what a controller allows, as strips that stand for a time.

use crate::plot::Callsign;
use crate::time::SimTime;
use crate::words::words;

/// What a clearance allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum ClearanceKind {
    /// Backtrack along the runway.
    Backtrack,
    /// Cross the runway.
    Cross,
    /// Enter a runway or an area (vehicles).
    Enter,
    /// Go around.
    GoAround,
    /// Hold position.
    Hold,
    /// Land.
    Land,
    /// Line up and wait.
    LineUp,
    /// Push and start.
    Push,
    /// Revoke what stands.
    Revoke,
    /// Speed on final or when taxiing.
    Speed,
    /// Taxi.
    Taxi,
    /// Take off.
    TakeOff,
}

words! {
    "clearance": ClearanceKind {
        Backtrack = "BTR",
        Cross = "CRO",
        Enter = "ENT",
        GoAround = "GOA",
        Hold = "HLD",
        Land = "LND",
        LineUp = "LUP",
        Push = "PSH",
        Revoke = "REV",
        Speed = "SPD",
        Taxi = "TAX",
        TakeOff = "TOF",
    }
}

impl ClearanceKind {
    /// Whether it allows to be on a runway.
    #[must_use]
    pub fn enters_runway(self) -> bool {
        use ClearanceKind::{Backtrack, Cross, Enter, Land, LineUp, TakeOff};
        matches!(self, Backtrack | Cross | Enter | Land | LineUp | TakeOff)
    }

    fn bit(self) -> u16 {
        1 << self as u8
    }
}

/// A set of kinds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kinds(u16);

impl Kinds {
    /// These kinds.
    #[must_use]
    pub fn of(kinds: &[ClearanceKind]) -> Self {
        Self(kinds.iter().fold(0, |set, kind| set | kind.bit()))
    }
    /// Whether it holds one of `others`.
    #[must_use]
    #[inline]
    pub fn any(self, others: Self) -> bool {
        self.0 & others.0 != 0
    }
    /// Whether it holds this kind.
    #[must_use]
    #[inline]
    pub fn has(self, kind: ClearanceKind) -> bool {
        self.0 & kind.bit() != 0
    }
    fn add(&mut self, kind: ClearanceKind) {
        self.0 |= kind.bit();
    }
}

/// A clearance as it was given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Who is cleared.
    pub callsign: Callsign,
    /// For what.
    pub kind: ClearanceKind,
    /// Runway of the layout, and which end; both directions where the end is not named.
    pub runway: Option<(usize, Option<usize>)>,
    /// Entry or crossing place along the axis of the runway from its first end, m.
    pub place_m: Option<f64>,
    /// Holds from.
    pub from: SimTime,
    /// Ended: vacated, crossed or airborne was reported, or it was taken back.
    pub until: Option<SimTime>,
}

/// One aircraft or vehicle and what it is cleared for now.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// Who.
    pub callsign: Callsign,
    /// Everything that stands.
    pub standing: Vec<Clearance>,
    /// The kinds of it.
    pub kinds: Kinds,
    /// When a push or taxi clearance last ended.
    pub moved_until: Option<SimTime>,
    /// Runway and time at which a clearance to take off or land last ended by itself.
    pub flew_until: Option<(usize, SimTime)>,
    /// When a clearance to take off last ended by itself: as the wheels left the ground.
    pub lifted_off: Option<SimTime>,
    /// Cleared way, m; empty: not known.
    pub way_m: Vec<crate::frames::Point2<f64>>,
    /// Its stand, m.
    pub stand_m: Option<crate::frames::Point2<f64>>,
    /// The way or the runway is too small for its type.
    pub too_small: bool,
}

impl Strip {
    /// What it is cleared for on a runway.
    pub fn on_runway(&self, runway: usize) -> impl Iterator<Item = &Clearance> {
        self.standing.iter().filter(move |c| c.runway.is_some_and(|r| r.0 == runway))
    }

    /// Whether it flies although it is not seen how high: it was sent around, or lifted off less than `rolled_s` ago.
    #[must_use]
    pub fn flies(&self, now: SimTime, rolled_s: f64) -> bool {
        self.kinds.has(ClearanceKind::GoAround)
            || self.lifted_off.is_some_and(|at| now.since_s(at) <= rolled_s)
    }

    /// When the standing clearance of a kind for a runway was given.
    #[must_use]
    pub fn since(&self, kind: ClearanceKind, runway: usize) -> Option<SimTime> {
        self.on_runway(runway).find(|c| c.kind == kind).map(|c| c.from)
    }
}

/// Most strips of a board: more than a scene may have movers.
pub const MOST_STRIPS: usize = 1 << 16;
/// Most clearances of one strip that stand or wait for their time.
const MOST_OF_ONE: usize = 32;

/// What has no end.
const NEVER: SimTime = SimTime(i64::MAX);

/// All strips: the state of all clearances at a time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Board {
    strips: Vec<Strip>,
    /// Indices of `strips`, sorted by call sign.
    order: Vec<u32>,
    /// Given for later.
    waiting: Vec<Clearance>,
    /// Strips with runway clearances, sorted.
    on_runways: Vec<u32>,
    /// Changes with every new strip.
    version: u64,
    /// Strips that have, or had, to do with a runway, sorted.
    about_runways: Vec<u32>,
    /// Nothing that stands ends before this.
    next_end: SimTime,
}

impl Board {
    /// The strips; their indices stay.
    #[must_use]
    pub fn strips(&self) -> &[Strip] {
        &self.strips
    }

    /// Index of a strip.
    #[must_use]
    pub fn find(&self, callsign: Callsign) -> Option<usize> {
        let at = self.order.binary_search_by_key(&callsign, |i| self.strips[*i as usize].callsign);
        at.ok().map(|at| self.order[at] as usize)
    }

    /// Indices of the strips with clearances of a runway, ascending.
    #[must_use]
    pub fn on_runways(&self) -> &[u32] {
        &self.on_runways
    }

    /// Indices of the strips with anything about a runway, also who has flown or was sent around, ascending.
    #[must_use]
    pub fn about_runways(&self) -> &[u32] {
        &self.about_runways
    }

    /// Counts up with every new strip.
    #[must_use]
    pub fn version(&self) -> u64 {
        self.version
    }

    /// The strip of a call sign, made if there is none; `None` if the board is full.
    pub fn strip(&mut self, callsign: Callsign) -> Option<&mut Strip> {
        // Who asks may change what stands.
        self.next_end = SimTime(i64::MIN);
        self.found_or_made(callsign)
    }

    fn found_or_made(&mut self, callsign: Callsign) -> Option<&mut Strip> {
        let at =
            match self.order.binary_search_by_key(&callsign, |i| self.strips[*i as usize].callsign)
            {
                Ok(at) => self.order[at] as usize,
                Err(place) => {
                    if self.strips.len() >= MOST_STRIPS {
                        return None;
                    }
                    self.order.insert(place, self.strips.len() as u32);
                    self.strips.push(Strip {
                        callsign,
                        standing: Vec::new(),
                        kinds: Kinds::default(),
                        moved_until: None,
                        flew_until: None,
                        lifted_off: None,
                        way_m: Vec::new(),
                        stand_m: None,
                        too_small: false,
                    });
                    self.version += 1;
                    self.strips.len() - 1
                }
            };
        Some(&mut self.strips[at])
    }

    /// Gives a clearance, from its time on; what it replaces ends then. False if the board is full.
    pub fn give(&mut self, clearance: Clearance) -> bool {
        let theirs = self.waiting.iter().filter(|c| c.callsign == clearance.callsign).count();
        if theirs >= MOST_OF_ONE || self.found_or_made(clearance.callsign).is_none() {
            return false;
        }
        self.waiting.push(clearance);
        true
    }

    /// Ends what stands of a kind (for a runway) at a time. What begins as another one of its kind ends goes on.
    pub fn end(
        &mut self,
        callsign: Callsign,
        kind: ClearanceKind,
        runway: Option<usize>,
        at: SimTime,
    ) {
        let meant = |c: &&Clearance| {
            c.callsign == callsign
                && c.kind == kind
                && (runway.is_none() || c.runway.map(|r| r.0) == runway)
        };
        let index = self.find(callsign);
        let standing = index.map_or(&[][..], |index| &self.strips[index].standing[..]);
        let mut all = standing.iter().chain(&self.waiting).filter(meant);
        let before = all.any(|c| c.from < at);
        let ends = |c: &&mut Clearance| meant(&&**c) && (c.from < at || c.from == at && !before);
        let earlier = |until: Option<SimTime>| Some(until.map_or(at, |u| u.min(at)));
        if let Some(index) = index {
            for c in self.strips[index].standing.iter_mut().filter(ends) {
                c.until = earlier(c.until);
                self.next_end = self.next_end.min(at);
            }
        }
        for c in self.waiting.iter_mut().filter(ends) {
            c.until = earlier(c.until);
        }
    }

    /// Brings the board to a time: what was given for it begins, what ended goes.
    pub fn advance(&mut self, now: SimTime) {
        let mut changed = false;
        if self.waiting.iter().any(|c| c.from <= now) {
            let mut due: Vec<Clearance> =
                self.waiting.iter().copied().filter(|c| c.from <= now).collect();
            self.waiting.retain(|c| c.from > now);
            due.sort_by_key(|c| c.from);
            for clearance in due {
                self.enter(clearance);
            }
            changed = true;
        }
        changed |= self.next_end <= now && self.end_what_is_over(now);
        if changed {
            for strip in &mut self.strips {
                strip.kinds = Kinds::default();
                for c in &strip.standing {
                    strip.kinds.add(c.kind);
                }
            }
            let indices = |with: fn(&Strip) -> bool| -> Vec<u32> {
                let strips = self.strips.iter().enumerate();
                strips.filter(|(_, s)| with(s)).map(|(i, _)| i as u32).collect()
            };
            self.on_runways = indices(|s| {
                s.standing.iter().any(|c| c.runway.is_some() && c.kind.enters_runway())
            });
            self.about_runways = indices(|s| {
                s.flew_until.is_some()
                    || s.kinds.has(ClearanceKind::GoAround)
                    || s.standing.iter().any(|c| c.runway.is_some())
            });
        }
    }

    /// Whether anything that stood is over.
    fn end_what_is_over(&mut self, now: SimTime) -> bool {
        let mut any = false;
        let over = |c: &Clearance| c.until.is_some_and(|until| until <= now);
        for strip in self.strips.iter_mut().filter(|s| s.standing.iter().any(over)) {
            let moves = |c: &&Clearance| {
                over(c) && matches!(c.kind, ClearanceKind::Push | ClearanceKind::Taxi)
            };
            let ended = strip.standing.iter().filter(moves).filter_map(|c| c.until).max();
            strip.moved_until = strip.moved_until.max(ended);
            let flies = |c: &&Clearance| {
                over(c) && matches!(c.kind, ClearanceKind::TakeOff | ClearanceKind::Land)
            };
            for c in strip.standing.iter().filter(flies) {
                strip.flew_until = c.runway.map(|r| r.0).zip(c.until).or(strip.flew_until);
                if c.kind == ClearanceKind::TakeOff {
                    strip.lifted_off = c.until;
                }
            }
            strip.standing.retain(|c| !over(c));
            any = true;
        }
        let standing = self.strips.iter().flat_map(|strip| &strip.standing);
        self.next_end = standing.filter_map(|c| c.until).min().unwrap_or(NEVER);
        any
    }

    /// One clearance begins: a take-off replaces the line-up, holding replaces taxiing and taxiing holding, a
    /// revocation or a go-around what it takes back, and the same kind for the same runway itself.
    fn enter(&mut self, clearance: Clearance) {
        use ClearanceKind::{GoAround, Hold, Land, LineUp, Revoke, TakeOff, Taxi};
        self.next_end = self.next_end.min(clearance.until.unwrap_or(NEVER));
        let Some(strip) = self.found_or_made(clearance.callsign) else { return };
        let (kind, runway) = (clearance.kind, clearance.runway.map(|r| r.0));
        // Who is told to hold still rolls to a stop.
        if kind == Hold && strip.standing.iter().any(|c| c.kind == Taxi) {
            strip.moved_until = strip.moved_until.max(Some(clearance.from));
        }
        strip.standing.retain(|c| {
            let same_runway = c.runway.map(|r| r.0) == runway || runway.is_none();
            let replaced = match kind {
                TakeOff => c.kind == LineUp,
                Hold => c.kind == Taxi,
                Taxi => c.kind == Hold,
                GoAround => c.kind == Land,
                Revoke => true,
                _ => false,
            };
            !(same_runway && (replaced || c.kind == kind))
        });
        // A line-up that comes after the take-off was cleared says nothing new.
        let rolls = strip.since(TakeOff, runway.unwrap_or(usize::MAX)).is_some();
        if kind != Revoke && !(kind == LineUp && rolls) && strip.standing.len() < MOST_OF_ONE {
            strip.standing.push(clearance);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ClearanceKind::{Cross, Hold, Land, LineUp, Revoke, TakeOff, Taxi};

    fn given(kind: ClearanceKind, at_s: f64, until_s: Option<f64>) -> Clearance {
        Clearance {
            callsign: Callsign::new("AAL1"),
            kind,
            runway: kind.enters_runway().then_some((0, Some(0))),
            place_m: None,
            from: SimTime::from_s(at_s),
            until: until_s.map(SimTime::from_s),
        }
    }

    fn words(board: &Board) -> String {
        let strip = &board.strips()[board.find(Callsign::new("AAL1")).expect("a strip")];
        let words: Vec<&str> = strip.standing.iter().map(|c| c.kind.word()).collect();
        words.join(" ")
    }

    #[test]
    fn a_strip_follows_what_is_given_replaced_and_ended() {
        let mut board = Board::default();
        for (kind, at_s, until_s) in [
            (Taxi, 0.0, None),
            (LineUp, 10.0, None),
            (TakeOff, 20.0, None),
            (LineUp, 20.5, None),
            (Cross, 22.0, Some(30.0)),
            (Hold, 40.0, None),
            (Taxi, 50.0, None),
            (Revoke, 60.0, None),
            (Land, 70.0, None),
        ] {
            assert!(board.give(given(kind, at_s, until_s)));
        }
        for (at_s, expected) in [
            (0.0, "TAX"),
            (10.0, "TAX LUP"),
            (21.0, "TAX TOF"),
            (25.0, "TAX TOF CRO"),
            (30.0, "TAX TOF"),
            (40.0, "TOF HLD"),
            (50.0, "TOF TAX"),
            (60.0, ""),
            (70.0, "LND"),
        ] {
            board.advance(SimTime::from_s(at_s));
            assert_eq!(words(&board), expected, "at {at_s} s");
        }
        // Who was told to hold rolls to a stop: that he moves is explained.
        let moved = board.strips()[board.find(Callsign::new("AAL1")).expect("there")].moved_until;
        assert_eq!(moved, Some(SimTime::from_s(40.0)));
        board.end(Callsign::new("AAL1"), Land, Some(0), SimTime::from_s(80.0));
        board.advance(SimTime::from_s(80.0));
        assert_eq!((words(&board).as_str(), board.on_runways()), ("", &[][..]));
    }

    /// A crossing was cleared as the one that was given wrongly ended: it ended with that, and he crossed without one.
    #[test]
    fn what_begins_as_another_of_its_kind_ends_goes_on() {
        let at = SimTime::from_s;
        let words_after = |from_s: &[f64], ended_s: &[f64], advanced_s: f64| {
            let mut board = Board::default();
            let (first, later) = from_s.split_at(1);
            first.iter().for_each(|s| assert!(board.give(given(Cross, *s, None))));
            board.advance(at(advanced_s));
            later.iter().for_each(|s| assert!(board.give(given(Cross, *s, None))));
            for s in ended_s {
                board.end(Callsign::new("AAL1"), Cross, Some(0), at(*s));
            }
            board.advance(at(60.0));
            words(&board)
        };
        for advanced_s in [5.0, 29.0, 31.0] {
            assert_eq!(words_after(&[10.0, 30.0], &[30.0], advanced_s), "CRO", "{advanced_s}");
            assert_eq!(words_after(&[10.0, 30.5], &[30.0], advanced_s), "CRO", "{advanced_s}");
            assert_eq!(words_after(&[10.0, 30.0], &[30.0, 40.0], advanced_s), "", "{advanced_s}");
            assert_eq!(words_after(&[30.0], &[30.0], advanced_s), "", "given and ended at once");
            assert_eq!(words_after(&[10.0], &[30.0], advanced_s), "", "{advanced_s}");
        }
    }

    #[test]
    fn no_sender_fills_the_board_without_end() {
        let mut board = Board::default();
        let name = |n: usize| Callsign::new(&format!("X{n}"));
        let taken = (0..MOST_STRIPS + 1000).filter(|n| board.strip(name(*n)).is_some());
        assert_eq!(taken.count(), MOST_STRIPS);
        let late = name(MOST_STRIPS + 7);
        assert!(!board.give(Clearance { callsign: late, ..given(Taxi, 1e6, None) }));
        let again = (0..1000).filter(|_| {
            board.give(Clearance { callsign: Callsign::new("X1"), ..given(Taxi, 1e6, None) })
        });
        assert_eq!(again.count(), MOST_OF_ONE);
    }
}
