//! Guidance by lights: a stop bar is lit but for who is cleared to pass it, until its tail has passed or 60 s have
//! gone by unused.

use super::clearance::{Board, ClearanceKind};
use super::layout::{Layout, StopBar};
use super::situation::{Situation, Surveillance};
use crate::time::SimTime;

/// An entry and a clearance belong together within this distance along the runway, m (assumed).
const SAME_ENTRY_M: f64 = 60.0;
/// A bar that is not passed is lit again after, s (assumed).
const UNUSED_S: f64 = 60.0;

/// Stop bars of a runway that do not do what they are told, for a time: a function of the scene and its seed.
#[derive(Clone, Debug, PartialEq)]
pub struct FailedBars {
    /// One of the names of the runway.
    pub runway: String,
    /// From, s of the run.
    pub from_s: f64,
    /// Until, s of the run.
    pub until_s: f64,
    /// Those that are lit stay lit; else all are dark.
    pub lit: bool,
}

impl FailedBars {
    /// Whether they fail at a time, s.
    #[must_use]
    pub fn at(&self, time_s: f64) -> bool {
        (self.from_s..=self.until_s).contains(&time_s)
    }
}

/// Bars of a runway that do not do what they are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failed {
    /// Runway of the layout.
    pub runway: usize,
    /// Those that are lit stay lit; else all are dark.
    pub lit: bool,
}

impl Failed {
    /// The bars of the layout's runway of this name; `lit`: they stay lit, not dark.
    #[must_use]
    pub fn of(layout: &Layout, runway: &str, lit: bool) -> Option<Self> {
        layout.runway(runway).map(|(runway, _)| Self { runway, lit })
    }
}

/// Switches stop bars by clearances and by who has passed; `failed` ones stay as they are, or dark.
pub fn switch(
    bars: &mut [StopBar],
    failed: &[Failed],
    now: SimTime,
    layout: &Layout,
    board: &Board,
    surveillance: &Surveillance,
) {
    let before: Vec<bool> = bars.iter().map(|bar| bar.lit).collect();
    bars.iter_mut().for_each(|bar| bar.lit = true);
    for index in board.on_runways() {
        let strip = &board.strips()[*index as usize];
        let situation = surveillance.of_strip(*index);
        for c in &strip.standing {
            use ClearanceKind::{Backtrack, Cross, Enter, LineUp, TakeOff};
            let Some((runway, _)) = c.runway else { continue };
            if !matches!(c.kind, LineUp | TakeOff | Cross | Enter | Backtrack) {
                continue;
            }
            // Who crosses behind an end is at that end.
            let length_m = layout.runways.get(runway).map_or(f64::INFINITY, |r| r.length_m);
            let on_it = |place_m: f64| place_m.clamp(0.0, length_m);
            for bar in bars.iter_mut().filter(|bar| bar.runway == runway && bar.lit) {
                let apart_m = |p: f64| (on_it(p) - on_it(bar.entry_m)).abs();
                let here = c.place_m.is_none_or(|p| apart_m(p) <= SAME_ENTRY_M);
                // Of whom no track is known the bar is his for as long as one may be unused.
                let cleared_s = now.since_s(c.from);
                let waits = situation
                    .map_or(cleared_s <= UNUSED_S, |s| before_bar(s, bar, layout, cleared_s));
                bar.lit = !(here && waits);
            }
        }
    }
    for (bar, was_lit) in bars.iter_mut().zip(before) {
        if let Some(failed) = failed.iter().find(|f| f.runway == bar.runway) {
            bar.lit = failed.lit && (bar.lit || was_lit);
        }
    }
}

/// Lights that nobody switches: red before who would come onto a runway in use, or take off towards somebody.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunwayLights {
    /// By stop bar of the layout: the entry lights behind it are lit.
    pub entries: Vec<bool>,
    /// By runway and end: the take-off hold lights of who begins there are lit.
    pub holds: Vec<[bool; 2]>,
}

/// An arrival lights the entries of its runway from so long before its threshold on, s (assumed).
const ENTRY_S: f64 = 45.0;
/// Who is lined up stands on the runway within so far of its begin, m, slower than this, m/s (assumed: intersections too).
const LINED_UP_M: f64 = 1200.0;
const LINED_UP_MPS: f64 = 5.0;

/// What the tracks of a scan light: entries while somebody is fast on the runway or on final to it, take-off hold lights while
/// somebody is in the strip ahead of one who is lined up.
#[must_use]
pub fn runway_lights(layout: &Layout, board: &Board, surveillance: &Surveillance) -> RunwayLights {
    let of_runways = || {
        let all = surveillance.of_runways().iter();
        all.filter_map(|i| surveillance.situations().get(*i as usize)).filter(|s| s.doubt.is_none())
    };
    let used = |r: usize| {
        of_runways().any(|s| {
            let lands = s.on_final.is_some_and(|f| f.runway == r && f.time_s <= ENTRY_S);
            lands || s.fast == Some(r)
        })
    };
    let in_use: Vec<bool> = (0..layout.runways.len()).map(used).collect();
    let of_bar = |bar: &StopBar| in_use.get(bar.runway).copied().unwrap_or(false);
    let holds = layout.runways.iter().enumerate().map(|(r, axis)| {
        let inside = || of_runways().filter(move |s| s.in_strip(r) && !s.airborne);
        [1.0, -1.0].map(|direction| {
            let begin_m = if direction > 0.0 { 0.0 } else { axis.length_m };
            let along_m =
                |s: &Situation| (axis.place_m(s.target.position_m).0 - begin_m) * direction;
            let lined_up = |s: &&Situation| {
                let (_, across_m) = axis.place_m(s.target.position_m);
                let end = usize::from(direction < 0.0);
                let cleared =
                    s.strip.and_then(|i| board.strips().get(i as usize)).is_some_and(|s| {
                        s.on_runway(r).any(|c| {
                            let takes_off =
                                matches!(c.kind, ClearanceKind::LineUp | ClearanceKind::TakeOff);
                            takes_off && c.runway.is_some_and(|(_, of)| of.is_none_or(|e| e == end))
                        })
                    });
                cleared
                    && across_m.abs() <= 0.5 * axis.width_m
                    && along_m(s) <= LINED_UP_M
                    && s.recent_mps < LINED_UP_MPS
            };
            inside().filter(lined_up).any(|own| {
                let own_m = along_m(own);
                inside().any(|s| s.target.number != own.target.number && along_m(s) > own_m)
            })
        })
    });
    RunwayLights { entries: layout.bars.iter().map(of_bar).collect(), holds: holds.collect() }
}

/// Whether a bar is off for one that is cleared since `cleared_s`: on its side, and the tail has not passed.
fn before_bar(situation: &Situation, bar: &StopBar, layout: &Layout, cleared_s: f64) -> bool {
    let Some(runway) = layout.runways.get(bar.runway) else { return false };
    let across_m = bar.across_m.unwrap_or(runway.hold_m);
    let p = situation.target.position_m;
    let nose = runway.place_m(situation.nose_m).1;
    let tail = runway.place_m(p + (p - situation.nose_m)).1;
    let side = across_m.signum();
    let (nose, tail, line) = (nose * side, tail * side, across_m.abs());
    let passed = tail.max(nose) < line;
    let unused = nose >= line && cleared_s > UNUSED_S;
    !passed && !unused
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::clearance::Clearance;
    use crate::control::layout::RunwayAxis;
    use crate::frames::Point2;
    use crate::plot::Callsign;

    /// Of whom no track is known the bar is dark for a minute, and lit again when he has not used it.
    #[test]
    fn a_bar_that_is_not_used_for_a_minute_is_lit_again_without_a_track() {
        let ends = [Point2::new(0.0, 0.0), Point2::new(0.0, 3000.0)];
        let axis = RunwayAxis::new(["36".into(), "18".into()], ends, 45.0, 90.0);
        let layout = Layout::new(axis.into_iter().collect());
        let bar = StopBar { runway: 0, place_m: 0.0, across_m: None, entry_m: 0.0, lit: true };
        let mut board = Board::default();
        let callsign = Callsign::new("AAL1");
        assert!(board.give(Clearance {
            callsign,
            kind: crate::control::clearance::ClearanceKind::LineUp,
            runway: Some((0, Some(0))),
            place_m: Some(0.0),
            from: SimTime::from_s(10.0),
            until: None,
        }));
        let mut bars = vec![bar];
        for (at_s, lit) in [(5.0, true), (10.0, false), (69.0, false), (71.0, true), (200.0, true)]
        {
            let now = SimTime::from_s(at_s);
            board.advance(now);
            switch(&mut bars, &[], now, &layout, &board, &Surveillance::default());
            assert_eq!(bars[0].lit, lit, "at {at_s} s");
        }
    }
}
