//! Holding positions, runways and wake.

use super::{Breaches, Given, Row, Rules, Seen, Who};
use crate::control::clearance::ClearanceKind;
use crate::control::layout::{Layout, RunwayAxis};
use crate::frames::{Azimuth, Point2};
use crate::traffic::core::Direction;
use crate::traffic::runway_roll::NAUTICAL_MILE_M;
use std::collections::BTreeSet;

/// Somebody came over a holding position.
#[derive(Clone, Copy, Debug)]
struct Entry {
    who: usize,
    runway: usize,
    time_s: f64,
    at_m: Point2<f64>,
}

/// What was seen of runways.
#[derive(Clone, Debug)]
pub(super) struct Runways {
    /// By mover: in which strips it was, one bit each; whether it was in the air.
    inside: Vec<u64>,
    flying: Vec<Option<bool>>,
    entries: Vec<Entry>,
    shared: Breaches,
    shared_pairs: BTreeSet<(usize, usize, usize)>,
    /// Take-offs: runway, time, who.
    airborne: Vec<(usize, f64, usize)>,
    wake: Breaches,
}

/// Slowest along a runway that is a roll, m/s.
const ROLL_MPS: f64 = 18.0;
/// Runways that are looked at; more than any airport has.
const MOST: usize = 64;

fn plane(s: &Seen) -> Point2<f64> {
    Point2::new(s.position_m.x, s.position_m.y)
}

fn nose(who: &Who, s: &Seen) -> Point2<f64> {
    plane(s) + Azimuth::from_rad(s.heading_rad).unit() * (0.5 * who.size.length_m)
}

impl Runways {
    pub(super) fn new(_runways: usize, movers: usize) -> Self {
        Self {
            inside: vec![0; movers],
            flying: vec![None; movers],
            entries: Vec::new(),
            shared: Breaches::default(),
            shared_pairs: BTreeSet::new(),
            airborne: Vec::new(),
            wake: Breaches::default(),
        }
    }

    fn in_strip(runway: &RunwayAxis, rules: &Rules, who: &Who, s: &Seen) -> bool {
        let within = |p: Point2<f64>| {
            let (place, across) = runway.place_m(p);
            let beside = (-30.0..=runway.length_m + 30.0).contains(&place);
            beside && across.abs() < runway.hold_at_m(place, across) - rules.hold_m
        };
        within(plane(s)) || within(nose(who, s))
    }

    pub(super) fn look(
        &mut self,
        layout: &Layout,
        rules: &Rules,
        who: &[Who],
        time_s: f64,
        seen: &[Seen],
    ) {
        let runways = &layout.runways[..layout.runways.len().min(MOST)];
        for s in seen {
            let low = s.position_m.z < 1.0;
            let mut now = 0_u64;
            // Who flies over a strip enters nothing.
            if low {
                for (r, runway) in runways.iter().enumerate() {
                    now |= u64::from(Self::in_strip(runway, rules, &who[s.who], s)) << r;
                }
            }
            let known = self.flying[s.who].is_some();
            let fresh = now & !self.inside[s.who];
            for r in (0..runways.len()).filter(|r| known && fresh >> r & 1 == 1) {
                self.entries.push(Entry { who: s.who, runway: r, time_s, at_m: plane(s) });
            }
            self.inside[s.who] = now;
            if self.flying[s.who] == Some(false) && s.position_m.z > 1.0 {
                let nearest = (0..runways.len()).min_by(|a, b| {
                    let across = |r: usize| runways[r].place_m(plane(s)).1.abs();
                    across(*a).total_cmp(&across(*b))
                });
                self.airborne.extend(nearest.map(|r| (r, time_s, s.who)));
            }
            let was = self.flying[s.who];
            if was == Some(true) && low {
                self.landed(runways, who, time_s, s, seen);
            }
            self.flying[s.who] = Some(if low {
                false
            } else if s.position_m.z > 1.0 {
                true
            } else {
                was.unwrap_or(false)
            });
        }
        for (r, runway) in runways.iter().enumerate() {
            self.one_roll(r, runway, who, rules, time_s, seen);
        }
    }

    fn one_roll(
        &mut self,
        r: usize,
        runway: &RunwayAxis,
        who: &[Who],
        rules: &Rules,
        time_s: f64,
        seen: &[Seen],
    ) {
        for k in seen.iter().filter(|s| s.position_m.z < 1.0) {
            let (place, across) = runway.place_m(plane(k));
            let along = runway.along_mps(k.velocity_mps);
            let rolls = along.abs() >= ROLL_MPS
                && along.abs() >= 0.94 * k.velocity_mps.norm()
                && across.abs() <= 0.5 * runway.width_m + 10.0
                && (-60.0..=runway.length_m + 60.0).contains(&place);
            if !rolls {
                continue;
            }
            self.shared.of += 1;
            for m in seen.iter().filter(|m| m.who != k.who && m.position_m.z < 1.0) {
                let ahead_m = (runway.place_m(plane(m)).0 - place) * along.signum();
                let inside = ahead_m > 0.0 && Self::in_strip(runway, rules, &who[m.who], m);
                // The nose of one who holds at an angle may be over the end of another line.
                if inside && self.shared_pairs.insert((r, k.who, m.who)) {
                    self.shared.add(|| {
                        format!(
                            "{} rolls on {} with {} {ahead_m:.0} m ahead at {time_s:.1} s",
                            who[k.who].callsign,
                            runway.names.join("/"),
                            who[m.who].callsign
                        )
                    });
                }
            }
        }
    }

    /// The one behind, when one lands.
    fn landed(
        &mut self,
        runways: &[RunwayAxis],
        who: &[Who],
        time_s: f64,
        s: &Seen,
        seen: &[Seen],
    ) {
        let Some(first) = who[s.who].wake else { return };
        for runway in runways {
            let along = runway.along_mps(s.velocity_mps);
            let (_, across) = runway.place_m(plane(s));
            if across.abs() > runway.width_m || along.abs() < 0.94 * s.velocity_mps.norm() {
                continue;
            }
            for b in seen.iter().filter(|b| b.position_m.z > 30.0 && b.who != s.who) {
                let (_, beside) = runway.place_m(plane(b));
                let theirs = runway.along_mps(b.velocity_mps);
                let behind_m =
                    (runway.place_m(plane(s)).0 - runway.place_m(plane(b)).0) * along.signum();
                let follows = beside.abs() < 300.0 && theirs * along > 0.0 && behind_m > 0.0;
                let Some(then) = who[b.who]
                    .wake
                    .filter(|_| follows && who[b.who].direction == Some(Direction::Arrival))
                else {
                    continue;
                };
                self.wake.of += 1;
                let least = first.landing_gap_nm(then) * NAUTICAL_MILE_M;
                if behind_m < least - 600.0 {
                    self.wake.add(|| {
                        format!(
                            "{} lands on {} {:.1} NM behind {} at {time_s:.0} s, at least {:.0}",
                            who[b.who].callsign,
                            runway.names.join("/"),
                            behind_m / NAUTICAL_MILE_M,
                            who[s.who].callsign,
                            least / NAUTICAL_MILE_M
                        )
                    });
                }
            }
            return;
        }
    }

    pub(super) fn rows(mut self, layout: &Layout, who: &[Who], given: &[Given]) -> [Row; 3] {
        let mut holds = Breaches { of: self.entries.len() as u64, ..Breaches::default() };
        let crosses = |a: usize, b: usize| {
            layout.crossings.iter().any(|c| c.runways == [a.min(b), a.max(b)])
                || layout.strips_meet(a, b)
        };
        for e in &self.entries {
            let cleared = given.iter().any(|g| {
                let on = layout.runway(&g.runway).map(|r| r.0);
                g.who == e.who
                    && (g.kind.enters_runway() || g.kind == ClearanceKind::GoAround)
                    && on.is_some_and(|r| r == e.runway || crosses(r, e.runway))
                    && g.from_s <= e.time_s + 1.0
                    && g.until_s >= e.time_s - 2.0
            });
            if !cleared {
                holds.add(|| {
                    let names = layout.runways[e.runway].names.join("/");
                    let (x, y, name) = (e.at_m.x, e.at_m.y, &who[e.who].callsign);
                    format!(
                        "{name} into {names} at {:.1} s without clearance, at {x:.0} {y:.0}",
                        e.time_s
                    )
                });
            }
        }
        for (i, (r, time_s, k)) in self.airborne.iter().enumerate() {
            let before = self.airborne[..i].iter().rev().find(|(b, _, m)| b == r && m != k);
            let Some((_, before_s, m)) = before else { continue };
            let (Some(first), Some(then)) = (who[*m].wake, who[*k].wake) else { continue };
            self.wake.of += 1;
            let (gap_s, least_s) = (time_s - before_s, first.departure_gap_s(then));
            if gap_s < least_s - 2.0 {
                self.wake.add(|| {
                    format!(
                        "{} takes off {gap_s:.0} s behind {} at {time_s:.0} s, at least {least_s:.0}",
                        who[*k].callsign, who[*m].callsign
                    )
                });
            }
        }
        [holds.row("holds"), self.shared.row("runways"), self.wake.row("wake")]
    }
}
