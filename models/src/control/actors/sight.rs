//! What a controller who has only tracks knows of those who wait: who is where, and whether a runway looks free.
//!
//! Who calls is heard, whatever the tracks say. Who stands at a line is cleared when a track of his name is there; whom
//! nobody sees calls after a while and is cleared on his word. A runway that looks occupied is not given away; what
//! stands in a strip for long without being a target is known for what it is (a look out of the window).

use super::Wanted;
use crate::control::clearance::ClearanceKind;
use crate::control::layout::{Layout, RunwayAxis};
use crate::control::situation::{Situation, Surveillance};
use std::collections::BTreeMap;

/// Somebody who waits, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Waiting {
    /// What he wants.
    pub wanted: Wanted,
    /// His strip on the board.
    pub strip: Option<u32>,
    /// Runway of the layout that he wants it for.
    pub runway: Option<usize>,
}

/// Whom no track shows calls after so long at his line, s (assumed).
pub const CALLS_AFTER_S: f64 = 20.0;
/// A track beside this far from the strip is not at its line, m (assumed).
const NEAR_M: f64 = 150.0;
/// A runway is not given away to somebody on the ground while an arrival is nearer than this, s (assumed).
const ARRIVAL_S: f64 = 30.0;
/// A track that keeps a runway closed for so long is looked for with the eyes, s (assumed).
pub const LOOKS_AFTER_S: f64 = 60.0;
/// From so far past the place of whoever lines up or crosses on, m, and from this speed on, m/s, one who lands or rolls has passed (assumed).
const PASSED_M: f64 = 50.0;
const AWAY_MPS: f64 = 5.0;
/// Who was fast on the runway so shortly ago is one of them, s (assumed); a car that drives along it is not.
const ROLLED_S: f64 = 60.0;
/// A track that has not been in the way for so long begins anew, s.
const FORGOTTEN_S: f64 = 10.0;

/// The memory of what is seen: bounded by flights and track numbers.
#[derive(Clone, Debug, Default)]
pub struct Sight {
    /// By flight: what it waits for, since, s.
    waits: BTreeMap<u32, (ClearanceKind, f64)>,
    /// By track in somebody's way: since and until, s.
    in_the_way: BTreeMap<u16, (f64, f64)>,
    called: u64,
    kept_back: u64,
}

impl Sight {
    /// How many were cleared on their word because no track showed them, and how many seconds a runway looked occupied to
    /// those who were kept back, by one each.
    #[must_use]
    pub fn cost(&self) -> (u64, u64) {
        (self.called, self.kept_back)
    }

    /// Looks at everybody who waits, once a scan; for each whether he may be cleared as it looks.
    pub fn look(
        &mut self,
        now_s: f64,
        waiting: &[Waiting],
        layout: &Layout,
        surveillance: &Surveillance,
    ) -> Vec<bool> {
        let kind_of =
            |flight: u32| waiting.iter().find(|w| w.wanted.flight == flight).map(|w| w.wanted.kind);
        self.waits.retain(|flight, (kind, _)| kind_of(*flight) == Some(*kind));
        self.in_the_way.retain(|_, (_, until_s)| now_s - *until_s <= FORGOTTEN_S);
        waiting.iter().map(|w| self.may(now_s, w, layout, surveillance)).collect()
    }

    fn may(&mut self, now_s: f64, w: &Waiting, layout: &Layout, seen: &Surveillance) -> bool {
        use ClearanceKind::{Cross, Land, LineUp, TakeOff};
        let kind = w.wanted.kind;
        let entry = self.waits.entry(w.wanted.flight).or_insert((kind, now_s));
        let waits_s = now_s - entry.1;
        let (Some(runway), true) = (w.runway, matches!(kind, Cross | Land | LineUp | TakeOff))
        else {
            return true;
        };
        let Some(axis) = layout.runways.get(runway) else { return true };
        if kind != Land {
            let at_line = |s: &Situation| {
                let (along_m, across_m) = axis.place_m(s.target.position_m);
                across_m.abs() <= axis.hold_m + NEAR_M
                    && (-NEAR_M..=axis.length_m + NEAR_M).contains(&along_m)
            };
            let shown = w.strip.and_then(|strip| seen.of_strip(strip)).is_some_and(at_line);
            if !shown && waits_s < CALLS_AFTER_S {
                return false;
            }
            if !shown && waits_s < CALLS_AFTER_S + 1.0 {
                self.called += 1;
            }
        }
        let own_m = w
            .strip
            .and_then(|strip| seen.of_strip(strip))
            .filter(|_| matches!(kind, Cross | LineUp));
        let own_m = own_m.map(|s| axis.place_m(s.target.position_m).0);
        let mut free = true;
        for index in seen.of_runways() {
            let Some(s) = seen.situations().get(*index as usize) else { continue };
            let own = s.strip.is_some() && s.strip == w.strip;
            if own || s.doubt.is_some() {
                continue;
            }
            let rolled = s.last_fast.is_some_and(|at| now_s - at.s() <= ROLLED_S);
            if rolled && own_m.is_some_and(|own_m| leaves_behind(axis, s, own_m)) {
                continue;
            }
            let stands = s.in_strip(runway) && !s.airborne;
            let lands = kind != Land
                && s.on_final.is_some_and(|f| f.runway == runway && f.time_s <= ARRIVAL_S);
            if !stands && !lands {
                continue;
            }
            let span = self.in_the_way.entry(s.target.number).or_insert((now_s, now_s));
            span.1 = now_s;
            // One that moves is seen to move.
            free &= stands && now_s - span.0 > LOOKS_AFTER_S && s.mean_mps < 2.0;
        }
        self.kept_back += u64::from(!free);
        free
    }
}

/// Whether somebody has passed a place `own_m` along a runway and goes on away from it: one lines up and crosses behind who lands
/// or rolls.
fn leaves_behind(axis: &RunwayAxis, s: &Situation, own_m: f64) -> bool {
    let beyond_m = axis.place_m(s.target.position_m).0 - own_m;
    let along_mps = axis.along_mps(s.target.velocity_mps);
    beyond_m.abs() > PASSED_M + s.target.length_m && along_mps * beyond_m.signum() > AWAY_MPS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::clearance::Board;
    use crate::control::layout::RunwayAxis;
    use crate::control::parameters::Parameters;
    use crate::control::situation::{Target, TargetClass};
    use crate::frames::Point2;
    use crate::frames::Vector2;
    use crate::plot::Callsign;
    use crate::time::SimTime;

    fn layout() -> Layout {
        let ends = [Point2::new(0.0, 0.0), Point2::new(3000.0, 0.0)];
        let names = ["09".into(), "27".into()];
        let axis = RunwayAxis::new(names, ends, 45.0, 90.0).expect("an axis");
        Layout { runways: vec![axis], ..Layout::default() }
    }

    fn target(number: u16, name: Option<&str>, x: f64, y: f64, v: f64, now: SimTime) -> Target {
        Target {
            number,
            callsign: name.map(Callsign::new),
            class: TargetClass::Aircraft,
            arriving: false,
            length_m: 38.0,
            position_m: Point2::new(x, y),
            velocity_mps: Vector2::new(v, 0.0),
            altitude_m: Some(0.0),
            last_plot: now,
            first: false,
        }
    }

    /// When somebody who wants `kind` from second 0 on may have it, s; `tracks` at each second.
    fn may_at(kind: ClearanceKind, tracks: &dyn Fn(f64, SimTime) -> Vec<Target>) -> Option<u32> {
        let (layout, parameters) = (layout(), Parameters::default());
        let mut board = Board::default();
        board.strip(Callsign::new("AAL1"));
        let strip = board.find(Callsign::new("AAL1")).map(|i| i as u32);
        let (mut surveillance, mut sight) = (Surveillance::default(), Sight::default());
        (0..200).find(|second| {
            let now_s = f64::from(*second);
            let now = SimTime::from_s(now_s);
            surveillance.scan(now, &layout, &parameters, &board, &tracks(now_s, now));
            let wanted = Wanted { flight: 4, kind, group: 0 };
            let waiting = [Waiting { wanted, strip, runway: Some(0) }];
            sight.look(now_s, &waiting, &layout, &surveillance)[0]
        })
    }

    #[test]
    fn who_is_seen_at_the_line_of_a_free_runway_is_cleared_at_once_who_is_not_when_he_calls() {
        use ClearanceKind::{Cross, Land, LineUp, Push, TakeOff};
        let there = |_: f64, now| vec![target(1, Some("AAL1"), 100.0, 130.0, 0.0, now)];
        let unnamed = |_: f64, now| vec![target(1, None, 100.0, 130.0, 0.0, now)];
        let elsewhere = |_: f64, now| vec![target(1, Some("AAL1"), 900.0, 1500.0, 0.0, now)];
        for kind in [Cross, LineUp, TakeOff] {
            assert_eq!(may_at(kind, &there), Some(0), "{kind:?}");
            assert_eq!(may_at(kind, &unnamed), Some(CALLS_AFTER_S as u32), "{kind:?}");
            assert_eq!(may_at(kind, &elsewhere), Some(CALLS_AFTER_S as u32), "{kind:?}");
        }
        // Who calls anyway is heard at once.
        for kind in [Push, Land] {
            assert_eq!(may_at(kind, &elsewhere), Some(0), "{kind:?}");
        }
    }

    #[test]
    fn a_runway_that_looks_occupied_is_not_given_away_until_a_look_out_of_the_window() {
        use ClearanceKind::{Land, LineUp, Push};
        let ghost = |x: f64, y: f64| {
            move |_: f64, now: SimTime| {
                let own = target(1, Some("AAL1"), 100.0, 130.0, 0.0, now);
                vec![own, target(2, None, x, y, 0.0, now)]
            }
        };
        let looks = Some(LOOKS_AFTER_S as u32 + 1);
        assert_eq!(may_at(LineUp, &ghost(1500.0, 10.0)), looks);
        assert_eq!(may_at(Land, &ghost(1500.0, 10.0)), looks);
        assert_eq!(may_at(Push, &ghost(1500.0, 10.0)), Some(0));
        assert_eq!(may_at(LineUp, &ghost(1500.0, 200.0)), Some(0), "beside the strip");
        // One that drives along the runway is no ghost: it is waited for until it has left.
        let drives = |now_s: f64, now: SimTime| {
            let own = target(1, Some("AAL1"), 100.0, 130.0, 0.0, now);
            let car = target(2, None, 200.0 + 10.0 * now_s, 0.0, 10.0, now);
            let mut all = vec![own];
            all.extend((now_s < 150.0).then_some(car));
            all
        };
        assert_eq!(may_at(LineUp, &drives), Some(150));
    }

    /// Waiting until a landing has left its runway cost every second gap of a busy runway.
    #[test]
    fn one_lines_up_and_crosses_behind_who_lands_and_takes_off_when_he_has_left() {
        use ClearanceKind::{Cross, LineUp, TakeOff};
        // Passes the line at second 2, brakes to a turn-off at 1 600 m and has left at second 55.
        let lands = |from_m: f64| {
            move |now_s: f64, now: SimTime| {
                let own = target(1, Some("AAL1"), from_m, 130.0, 0.0, now);
                let roll_s = now_s.min(40.0);
                let (x, v) = (70.0 * roll_s - 0.8 * roll_s * roll_s - 40.0, 70.0 - 1.6 * roll_s);
                let mut all = vec![own];
                all.extend((now_s < 55.0).then_some(target(2, Some("BAW2"), x, 0.0, v, now)));
                all
            }
        };
        for kind in [LineUp, Cross] {
            let behind = may_at(kind, &lands(100.0));
            assert!(behind.is_some_and(|at| (3..9).contains(&at)), "{kind:?}: {behind:?}");
        }
        for (kind, from_m) in [(TakeOff, 100.0), (Cross, 1900.0), (LineUp, 1900.0)] {
            assert_eq!(may_at(kind, &lands(from_m)), Some(55), "{kind:?} at {from_m}");
        }
    }

    #[test]
    fn nobody_lines_up_before_an_arrival_that_is_near() {
        let arrives = |now_s: f64, now: SimTime| {
            let own = target(1, Some("AAL1"), 100.0, 130.0, 0.0, now);
            let mut other = target(2, Some("BAW2"), -7000.0 + 70.0 * now_s, 0.0, 70.0, now);
            other.altitude_m = Some(350.0 - 3.5 * now_s);
            vec![own, other]
        };
        // A hundred seconds out: free until 30 s before the threshold.
        assert_eq!(may_at(ClearanceKind::LineUp, &arrives), Some(0));
        let late = |now_s: f64, now: SimTime| arrives(now_s + 75.0, now);
        let at = may_at(ClearanceKind::LineUp, &late);
        assert!(at.is_some_and(|at| at > 20), "{at:?}");
    }
}
