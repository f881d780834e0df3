//! Conformance monitoring: what moves without, or against, a clearance; protected areas.

use super::alert::{AlertKind, Condition, Stage, Subject};
use super::cells::Cells;
use super::clearance::{Board, ClearanceKind, Kinds, Strip};
use super::layout::{Area, AreaKind, Layout, StopBar};
use super::parameters::Parameters;
use super::situation::{MOST_RUNWAYS, Situation, Surveillance, TargetClass};
use crate::airport::distance_to_segment_m;
use crate::frames::Point2;
use crate::time::SimTime;

use ClearanceKind::{Backtrack, Cross, Enter, GoAround, Land, LineUp, Push, TakeOff, Taxi};

/// What the conformance monitor remembers of a track.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Remembered {
    /// It went over a lit bar of this runway, at this distance from its axis, m, and is still there.
    over_bar: Option<(u8, f64)>,
    /// Came over this lit bar, plus one, and may be put there by noise; 0: none.
    coming: u16,
    /// Was told of at this one last, plus one, and has not been well before it since; 0: none.
    told: u16,
    /// Segment of the cleared way that was nearest last.
    segment: u32,
}

impl Remembered {
    /// Whether anything is remembered about a bar.
    fn of_a_bar(&self) -> bool {
        self.over_bar.is_some() || self.coming != 0 || self.told != 0
    }
}

/// The conformance monitor; its memory has one entry a track number.
#[derive(Clone, Debug)]
pub(super) struct Monitor {
    remembered: Vec<Remembered>,
    unknown: Unknown,
    /// Runways with lit bars, and how far from its axis one is at most, m.
    bars_m: Vec<(usize, f64)>,
    parked: Parked,
}

impl Default for Monitor {
    fn default() -> Self {
        Self {
            remembered: vec![Remembered::default(); 4096],
            unknown: Unknown::default(),
            bars_m: Vec::new(),
            parked: Parked::default(),
        }
    }
}

/// Who could be whom in a scan: strips that no track is known to be of, and tracks without a name by runway.
#[derive(Clone, Debug, Default)]
struct Unknown {
    /// Of those with anything to do with a runway; empty where tracks are exact truth, which has all names.
    strips: Vec<u32>,
    /// Tracks in the strip of each runway or on final to it.
    nameless: Vec<u32>,
}

impl Unknown {
    fn look(&mut self, rules: &Rules<'_>, surveillance: &Surveillance) {
        self.strips.clear();
        self.nameless.clear();
        let runways = rules.layout.runways.len();
        self.nameless.resize(runways, 0);
        if rules.parameters.doubt.is_none() {
            return;
        }
        let nameless = |s: &&Situation| s.target.callsign.is_none() && s.of_a_runway();
        for s in surveillance.situations().iter().filter(nameless) {
            for r in 0..runways {
                let there =
                    s.in_strip(r) || s.fast == Some(r) || s.on_final.is_some_and(|f| f.runway == r);
                self.nameless[r] += u32::from(there);
            }
        }
        if self.nameless.iter().all(|count| *count == 0) {
            return;
        }
        let strips = rules.board.about_runways().iter().copied();
        self.strips.extend(strips.filter(|i| surveillance.of_strip(*i).is_none()));
    }
}

/// Who stands in a scan, vehicles apart, by place; looked for when the first one asks.
#[derive(Clone, Debug, Default)]
struct Parked {
    looked: bool,
    of: Vec<u32>,
    cells: Cells,
}

impl Parked {
    fn clear(&mut self) {
        if self.looked {
            self.looked = false;
            self.of.clear();
            self.cells.clear();
        }
    }

    /// Whether something is so of one within [`Parameters::stand_occupied_m`]; also asked of some that are farther.
    fn any_near(
        &mut self,
        situations: &[Situation],
        p: &Parameters,
        at_m: Point2<f64>,
        so: impl Fn(&Situation) -> bool,
    ) -> bool {
        if !self.looked {
            self.looked = true;
            for (index, s) in situations.iter().enumerate() {
                if s.target.class != TargetClass::Vehicle && s.mean_mps < p.push_mps {
                    self.of.push(index as u32);
                    self.cells.add(s.target.position_m);
                }
            }
        }
        let mut any = false;
        self.cells.near(at_m, p.stand_occupied_m, |parked| {
            any = any || so(&situations[self.of[parked] as usize]);
            false
        });
        any
    }
}

/// What a scan is judged by.
pub(super) struct Rules<'a> {
    pub now: SimTime,
    pub layout: &'a Layout,
    pub parameters: &'a Parameters,
    pub board: &'a Board,
    pub bars: &'a [StopBar],
    pub areas: &'a [Area],
}

impl Rules<'_> {
    /// How far a bar is from the axis of its runway, m.
    fn line_m(&self, bar: &StopBar) -> f64 {
        let hold_m = self.layout.runways.get(bar.runway).map_or(0.0, |r| r.hold_m);
        bar.across_m.map_or(hold_m, f64::abs) - self.parameters.bar_margin_m
    }
}

impl Monitor {
    /// Adds the conditions of every track (`NOCLR_*`, `STOPBAR`, `ROUTE_DEV`, `NOMOV`, `HIGH_SPEED`, `AREA`,
    /// `WRTY`, `STOCC`).
    pub(super) fn conditions(
        &mut self,
        rules: &Rules<'_>,
        surveillance: &Surveillance,
        out: &mut Vec<Condition>,
    ) {
        self.unknown.look(rules, surveillance);
        self.bars_m.clear();
        for r in 0..rules.layout.runways.len() {
            let lit = rules.bars.iter().filter(|bar| bar.lit && bar.runway == r);
            let most_m = lit.map(|bar| rules.line_m(bar)).fold(0.0, f64::max);
            self.bars_m.extend((most_m > 0.0).then_some((r, most_m)));
        }
        // Nobody's nose is farther ahead than half his length: who is not near a runway comes over no bar that is.
        let near = |(r, most_m): &&(usize, f64)| {
            *r < MOST_RUNWAYS && *most_m <= rules.layout.runways[*r].hold_m
        };
        let close = self.bars_m.iter().filter(near).fold(0, |all, (r, _)| all | 1_u32 << r);
        let far = !self.bars_m.iter().all(|bars| near(&bars));
        self.parked.clear();
        for situation in surveillance.situations() {
            let remembered = &mut self.remembered[usize::from(situation.target.number)];
            if situation.target.first {
                *remembered = Remembered::default();
            }
            let mut one = One { rules, unknown: &self.unknown, situation, strip: None, out };
            one.strip = situation.strip.map(|i| &rules.board.strips()[i as usize]);
            if remembered.of_a_bar() || situation.near & close != 0 || far {
                one.bar(remembered, &self.bars_m, surveillance);
            }
            if situation.of_a_runway() {
                one.on_runway();
            }
            one.off_runway(remembered);
            one.too_small();
            if situation.target.arriving {
                one.stand(surveillance, &mut self.parked);
            }
            for area in rules.areas {
                let p = situation.target.position_m;
                if !situation.airborne && area.holds(rules.now, p) {
                    let closed = area.kind == AreaKind::Closed;
                    if !closed && one.is_allowed() {
                        continue;
                    }
                    one.raise(
                        AlertKind::Area,
                        if closed { Stage::Alarm } else { Stage::Information },
                        None,
                    );
                }
            }
        }
    }
}

struct One<'a, 'b> {
    rules: &'a Rules<'b>,
    unknown: &'a Unknown,
    situation: &'a Situation,
    strip: Option<&'a Strip>,
    out: &'a mut Vec<Condition>,
}

impl One<'_, '_> {
    fn raise(&mut self, kind: AlertKind, stage: Stage, runway: Option<usize>) {
        let target = &self.situation.target;
        let subjects = (Subject::Track(target.number), None);
        let (place_m, crosses) = (target.position_m, false);
        self.out.push(Condition { kind, subjects, stage, runway, place_m, crosses });
    }

    /// Whether it stands cleared for one of these on a runway (end `None`: in any direction).
    fn cleared(&self, kinds: &[ClearanceKind], runway: usize, end: Option<usize>) -> bool {
        let fits = |c: &super::clearance::Clearance| {
            let given = c.runway.and_then(|r| r.1);
            kinds.contains(&c.kind) && (end.is_none() || given.is_none() || given == end)
        };
        self.its(runway, |strip| strip.on_runway(runway).any(fits))
    }

    /// Whether something is so of its strip. A track without a name may be any of those whom no track is known to be, as long as
    /// there are at least as many of these, of whom it is so, as tracks without a name at that runway.
    fn its(&self, runway: usize, so: impl Fn(&Strip) -> bool) -> bool {
        if self.strip.is_some() || self.situation.target.callsign.is_some() {
            return self.strip.is_some_and(so);
        }
        let strips = self.rules.board.strips();
        let could = self.unknown.strips.iter().filter(|i| so(&strips[**i as usize])).count();
        could > 0 && self.unknown.nameless[runway] as usize <= could
    }

    fn goes_around(&self, runway: usize) -> bool {
        self.its(runway, |strip| strip.kinds.has(GoAround))
    }

    /// Whether its take-off or landing was cleared until just now: a clearance ends when the wheels leave the ground, before a
    /// track is known to be in the air.
    fn has_flown(&self, r: usize) -> bool {
        let (now, most_s) = (self.rules.now, self.rules.parameters.rolled_s);
        let just = |(runway, at): (usize, SimTime)| runway == r && now.since_s(at) <= most_s;
        self.its(r, |strip| strip.flew_until.is_some_and(just))
    }

    fn kinds(&self) -> Kinds {
        self.strip.map_or_else(Kinds::default, |s| s.kinds)
    }

    fn on_runway(&mut self) {
        let (p, now, s) = (self.rules.parameters, self.rules.now, self.situation);
        let landed_on = s.was_on_final(now, p.landed_s);
        if let Some(f) = s.on_final {
            let cleared =
                self.goes_around(f.runway) || self.cleared(&[Land], f.runway, Some(f.end));
            if f.time_s <= p.landing_clearance_s && !cleared && s.fast.is_none() {
                self.raise(AlertKind::NoLandingClearance, Stage::Information, Some(f.runway));
            }
        }
        if let Some(r) = s.fast.filter(|_| s.target.class != TargetClass::Vehicle)
            && !self.goes_around(r)
            && !self.has_flown(r)
            && !self.cleared(&[TakeOff, Land], r, None)
        {
            // The speed of a track may be far above what its places show.
            let shows =
                p.doubt.as_ref().is_none_or(|d| s.recent_mps + d.roll_lag_mps >= p.fast_mps);
            match landed_on {
                Some(_) => self.raise(AlertKind::NoLandingClearance, Stage::Alarm, Some(r)),
                None if shows => self.raise(AlertKind::NoTakeOffClearance, Stage::Alarm, Some(r)),
                None => {}
            }
        }
        for r in (0..self.rules.layout.runways.len()).filter(|r| s.in_strip(*r)) {
            self.in_strip(r, landed_on);
        }
    }

    fn in_strip(&mut self, r: usize, landed_on: Option<usize>) {
        let (p, now, s) = (self.rules.parameters, self.rules.now, self.situation);
        let allowed = [LineUp, TakeOff, Cross, Land, Enter, Backtrack];
        let crosses = |other: usize| {
            let pair = [r.min(other), r.max(other)];
            self.rules.layout.crossings.iter().any(|c| c.runways == pair)
        };
        // Where the strips of two runways overlap, who is cleared for one is in that of the other, too.
        let elsewhere = || {
            let others = (0..self.rules.layout.runways.len()).filter(|o| *o != r && s.in_strip(*o));
            others.into_iter().any(|o| self.cleared(&allowed, o, None))
        };
        let landed = landed_on.is_some_and(|runway| runway == r || crosses(runway));
        // Who rolled a scan ago and does not for this one rolls: a track's velocity turns aside for as long.
        let rolled = p.doubt.is_some() && s.last_fast.is_some_and(|at| now.since_s(at) <= ROLLS_S);
        let rolls = s.fast.is_some() || rolled;
        let entered = !rolls && s.on_final.is_none() && !s.airborne && !landed;
        if entered && !self.cleared(&allowed, r, None) && !elsewhere() {
            self.raise(AlertKind::NoRunwayClearance, Stage::Alarm, Some(r));
        }
        let Some(strip) = self.strip.filter(|_| s.target.class != TargetClass::Vehicle) else {
            return;
        };
        let stands = |since: SimTime, most_s: f64| now.since_s(since.max(s.still_since)) >= most_s;
        let take_off = strip.since(TakeOff, r);
        let late = match (take_off, strip.since(LineUp, r)) {
            (Some(since), _) => stands(since, p.stands_cleared_s),
            (None, Some(since)) => stands(since, p.stands_lined_up_s),
            (None, None) => false,
        };
        if late {
            self.raise(AlertKind::NoMovement, Stage::Information, Some(r));
        }
    }

    fn bar(
        &mut self,
        remembered: &mut Remembered,
        bars_m: &[(usize, f64)],
        surveillance: &Surveillance,
    ) {
        let (p, s) = (self.rules.parameters, self.situation);
        if let Some((r, line_m)) = remembered.over_bar {
            let Some(runway) = self.rules.layout.runways.get(usize::from(r)) else { return };
            let beyond = |m: Point2<f64>| runway.place_m(m).1.abs() > line_m;
            if beyond(s.nose_m) && beyond(s.target.position_m) {
                remembered.over_bar = None;
            } else {
                self.raise(AlertKind::StopBar, Stage::Alarm, Some(usize::from(r)));
            }
            return;
        }
        let needed = p.doubt.map_or(1, |doubt| doubt.before_bar_scans).min(3);
        let was_coming = std::mem::take(&mut remembered.coming);
        // Who was over it by noise, and is back just before it, comes still.
        let came = self.rules.bars.get(usize::from(was_coming).wrapping_sub(1));
        if came.is_some_and(|bar| (0.0..=JUST_BEFORE_M).contains(&self.before_m(bar))) {
            remembered.coming = was_coming;
        }
        let told = self.rules.bars.get(usize::from(remembered.told).wrapping_sub(1));
        if told.is_none_or(|bar| self.before_m(bar) > WELL_BEFORE_M) {
            remembered.told = 0;
        }
        for &(r, most_m) in bars_m {
            let runway = &self.rules.layout.runways[r];
            let (place_m, d) = runway.place_m(s.nose_m);
            if d.abs() >= most_m {
                continue;
            }
            let before = &surveillance.noses_before_m(s)[..needed];
            let off_m = |m: &Option<Point2<f64>>| m.map(|m| runway.place_m(m).1.abs());
            let inward_mps = runway.across_mps(s.target.velocity_mps) * -d.signum();
            let here = |(bar, _): &(&StopBar, u16)| {
                bar.runway == r && (place_m - bar.place_m).abs() <= p.bar_reach_m && bar.lit
            };
            for (bar, number) in self.rules.bars.iter().zip(1..).filter(here) {
                let line_m = self.rules.line_m(bar);
                let over = d.abs() < line_m;
                let other_side = bar.across_m.is_some_and(|across| across * d < 0.0);
                let before_it = |m: &Option<Point2<f64>>| off_m(m).is_some_and(|m| m >= line_m);
                let comes = || was_coming == number || before.iter().all(before_it);
                if !over || other_side || s.airborne || !comes() {
                    continue;
                }
                // Where ways meet before a runway, each has its bar: one passes that of his own way, which is the nearest.
                let beside = |other: &StopBar| {
                    let same_side = match [other, bar].map(|b| b.across_m) {
                        [Some(x), Some(y)] => x * y > 0.0,
                        _ => true,
                    };
                    let off_m = |b: &StopBar| (place_m - b.place_m).abs();
                    other.runway == r && same_side && off_m(other) < off_m(bar)
                };
                if self.rules.bars.iter().any(beside) {
                    continue;
                }
                // Noise alone takes the nose of one who stands before his line, or is pushed along it, over it, and not once.
                let from_m = before.last().and_then(off_m).unwrap_or(line_m);
                let goes_on = p.doubt.is_none_or(|doubt| {
                    let slowly = d.abs() <= line_m - doubt.past_line_m
                        || inward_mps >= doubt.over_bar_mps && from_m - d.abs() >= doubt.over_bar_m;
                    s.recent_mps >= p.taxi_mps || slowly && remembered.told != number
                });
                if goes_on {
                    remembered.told = number;
                    remembered.over_bar = Some((r as u8, line_m));
                    self.raise(AlertKind::StopBar, Stage::Alarm, Some(r));
                    return;
                }
                remembered.coming = number;
            }
        }
    }

    /// How far its nose is before a bar, m; negative: over it.
    fn before_m(&self, bar: &StopBar) -> f64 {
        let runway = self.rules.layout.runways.get(bar.runway);
        let off_m = runway.map_or(f64::INFINITY, |r| r.place_m(self.situation.nose_m).1.abs());
        off_m - self.rules.line_m(bar)
    }

    /// Whether it comes low along a runway to an end of that: a light aircraft that lands, too slow for what counts as on final.
    fn comes_to_an_end(&self) -> bool {
        let (p, target) = (self.rules.parameters, &self.situation.target);
        self.rules.layout.runways.iter().any(|r| {
            let (along_m, off_m) = r.place_m(target.position_m);
            let along_mps = r.along_mps(target.velocity_mps);
            let before_m = if along_mps > 0.0 { -along_m } else { along_m - r.length_m };
            (0.0..=LOW_FINAL_M).contains(&before_m)
                && off_m.abs() <= 0.5 * r.width_m + p.runway_side_m
                && along_mps.abs() >= p.fast_aligned * target.velocity_mps.norm()
        })
    }

    fn off_runway(&mut self, remembered: &mut Remembered) {
        let (p, now, s) = (self.rules.parameters, self.rules.now, self.situation);
        let rolled = s.last_fast.is_some_and(|at| now.since_s(at) <= p.rolled_s);
        let ground = s.strips == 0 && s.on_final.is_none() && !s.airborne && s.on_ground_area;
        if s.target.class != TargetClass::Aircraft || !ground || rolled {
            return;
        }
        let kinds = self.kinds();
        // Its mean looks back: who has come back to where he was moves no more.
        let moves = p.doubt.is_none() || s.recent_mps > 0.5 * p.push_mps;
        if s.mean_mps > p.push_mps && moves {
            // The mean looks back: a clearance that ended within its time still explains it.
            let just = self
                .strip
                .and_then(|s| s.moved_until)
                .is_some_and(|at| now.since_s(at) <= p.mean_s);
            let at_stand = self
                .strip
                .and_then(|s| s.stand_m)
                .is_some_and(|stand_m| (s.target.position_m - stand_m).norm() <= p.stand_reach_m);
            if at_stand {
                if !just && !kinds.any(Kinds::of(&[Push, Taxi])) {
                    self.raise(AlertKind::NoPushClearance, Stage::Information, None);
                }
            } else if s.mean_mps > p.taxi_mps
                && !just
                && !kinds.any(Kinds::of(&[Taxi, Cross, LineUp, TakeOff, Land]))
            {
                self.raise(AlertKind::NoTaxiClearance, Stage::Information, None);
            }
        }
        if s.judged_mps > p.high_speed_mps && !self.comes_to_an_end() {
            let take_off = s.judged_mps > p.taxiway_take_off_mps;
            let stage = if take_off { Stage::Alarm } else { Stage::Information };
            self.raise(AlertKind::HighSpeed, stage, None);
        }
        let Some(strip) = self.strip else { return };
        let off = kinds.has(Taxi)
            && off_way(&strip.way_m, s.target.position_m, p.way_m, &mut remembered.segment);
        if off {
            self.raise(AlertKind::OffWay, Stage::Information, None);
        }
    }

    /// Who is cleared for a way or a runway that is too small for its type, wherever it is.
    fn too_small(&mut self) {
        let cleared = Kinds::of(&[Taxi, LineUp, TakeOff, Land]);
        let told = |strip: &Strip| strip.too_small && strip.kinds.any(cleared);
        if self.situation.target.class == TargetClass::Aircraft && self.strip.is_some_and(told) {
            self.raise(AlertKind::TooSmall, Stage::Information, None);
        }
    }

    /// Whether it is cleared onto a runway in whose strip it is: an area there is not kept free of it.
    fn is_allowed(&self) -> bool {
        let s = self.situation;
        let kinds = [LineUp, TakeOff, Cross, Land, Enter, Backtrack];
        let runways = 0..self.rules.layout.runways.len();
        runways.into_iter().any(|r| s.in_strip(r) && self.cleared(&kinds, r, None))
    }

    fn stand(&mut self, surveillance: &Surveillance, parked: &mut Parked) {
        let (p, s) = (self.rules.parameters, self.situation);
        let Some(stand_m) = self.strip.and_then(|strip| strip.stand_m) else { return };
        let taxi_s = (s.target.position_m - stand_m).norm() / p.stand_taxi_mps;
        let (eta_s, own) = match s.on_final {
            Some(f) => {
                let runway = &self.rules.layout.runways[f.runway];
                let end = if f.end == 0 {
                    runway.displaced_m[0]
                } else {
                    runway.length_m - runway.displaced_m[1]
                };
                let threshold_m = runway.origin_m + runway.along * end;
                (f.time_s + (threshold_m - stand_m).norm() / p.stand_taxi_mps, false)
            }
            None => (taxi_s, taxi_s * p.stand_taxi_mps <= p.stand_occupied_m),
        };
        if own || eta_s > p.stand_ahead_s || !(s.on_final.is_some() || self.kinds().has(Taxi)) {
            return;
        }
        let near2 = p.stand_occupied_m * p.stand_occupied_m;
        // Who stands on another stand does not occupy this one, however near the two are.
        let elsewhere = |at_m: Point2<f64>| {
            let nearest_m2 = (at_m - stand_m).norm_squared();
            self.rules.layout.stands_m.iter().any(|other_m| {
                (at_m - other_m).norm_squared() < nearest_m2
                    && (other_m - stand_m).norm() > p.stands_apart_m
            })
        };
        // Nor does who is on his way and stops beside it: at the line of a runway, in a queue.
        let strips = self.rules.board.strips();
        let on_his_way = |o: &Situation| {
            let Some(strip) = o.strip.map(|i| &strips[i as usize]) else { return false };
            let from_elsewhere =
                strip.stand_m.is_some_and(|own_m| (own_m - stand_m).norm() > p.stands_apart_m);
            strip.kinds.any(Kinds::of(&[LineUp, TakeOff, Cross]))
                || strip.kinds.has(Taxi) && from_elsewhere
        };
        let situations = surveillance.situations();
        let occupied = parked.any_near(situations, p, stand_m, |o| {
            (o.target.position_m - stand_m).norm_squared() <= near2
                && o.target.number != s.target.number
                && !elsewhere(o.target.position_m)
                && !on_his_way(o)
        });
        if occupied {
            self.raise(AlertKind::StandOccupied, Stage::Information, None);
        }
    }
}

/// Who rolled so shortly ago rolls, on tracks, s: a scan and a half (assumed).
const ROLLS_S: f64 = 1.5;
/// Who lands is below fifteen metres no farther before his runway than this, m: with a touchdown 150 m behind the threshold 170.
const LOW_FINAL_M: f64 = 300.0;
/// Noise takes a nose back so far before a bar that it passes slowly, m (assumed).
const JUST_BEFORE_M: f64 = 3.0;
/// Who has been so far before a bar passes it anew, m (assumed).
const WELL_BEFORE_M: f64 = 15.0;

/// Whether a point is farther than `most_m` from a way; looks first where it was nearest before.
fn off_way(way_m: &[Point2<f64>], point_m: Point2<f64>, most_m: f64, segment: &mut u32) -> bool {
    if way_m.len() < 2 {
        return false;
    }
    let count = way_m.len() - 1;
    let near = |i: usize| distance_to_segment_m(point_m, way_m[i], way_m[i + 1]) <= most_m;
    let last = (*segment as usize).min(count - 1);
    for i in [last, (last + 1).min(count - 1)] {
        if near(i) {
            *segment = i as u32;
            return false;
        }
    }
    match (0..count).find(|i| near(*i)) {
        Some(i) => {
            *segment = i as u32;
            false
        }
        None => true,
    }
}
