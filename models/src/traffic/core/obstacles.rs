//! Movers that are functions of time (recorded, on a route, parked): they do not give way, so what behaves does.
//!
//! Once a second each of them holds the pieces that its outline touches now and on the way on which it could stop, and
//! every runway in whose strip it is within the next minute. Nobody behaving takes these; who has taken one before is
//! reported if they overlap.

use super::{Core, Mover, Phase};
use crate::frames::Vector2;
use crate::time::SimTime;
use crate::traffic::outline::{Rectangle, Size, distance_m, distance_to_line_m, outline};
use crate::traffic::pieces::SIZES;
use crate::truth::Trajectory;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A mover that the core does not move.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// For messages.
    pub callsign: String,
    /// Size on the ground.
    pub size: Size,
    /// Where it is at every time.
    pub trajectory: Arc<Trajectory>,
}

/// Obstacles and what they hold now.
#[derive(Clone, Debug, Default)]
pub(super) struct Obstacles {
    all: Arc<Vec<Obstacle>>,
    /// By piece: its line; by square: pieces.
    lines: Arc<Vec<[Vector2<f64>; 2]>>,
    squares: Arc<BTreeMap<(i64, i64), Vec<u32>>>,
    /// By piece: who touches it, from how far from its line, m.
    held: BTreeMap<u32, Vec<(u32, f64)>>,
    /// By runway: who is or will be in its strip.
    runways: Vec<Option<usize>>,
    told: BTreeSet<(usize, usize)>,
}

const SQUARE_M: f64 = 100.0;
/// Room beside a body, m, as pieces have it.
const ROOM_M: f64 = 2.0;
/// Braking by which its stop is judged, m/s² (assumed), and longest look ahead, s.
const BRAKES_MPS2: f64 = 0.7;
const MOST_AHEAD_S: f64 = 20.0;
/// A runway is left to those who come into its strip within, s.
const RUNWAY_AHEAD_S: f64 = 60.0;

fn square(at: Vector2<f64>) -> (i64, i64) {
    ((at.x / SQUARE_M).floor() as i64, (at.y / SQUARE_M).floor() as i64)
}

impl Core {
    /// The same core with obstacles, before its first step.
    #[must_use]
    pub fn with_obstacles(mut self, all: Vec<Obstacle>) -> Self {
        if all.is_empty() {
            return self;
        }
        let line = |piece: &crate::traffic::pieces::Piece| {
            let [a, b] = self.net.edges[piece.edge].nodes.map(|n| self.net.nodes[n].at_m);
            let along = (b - a) / (b - a).norm().max(1e-9);
            [a + along * piece.from_m, a + along * piece.to_m]
        };
        let lines: Vec<[Vector2<f64>; 2]> = self.pieces.list.iter().map(line).collect();
        let mut squares: BTreeMap<(i64, i64), Vec<u32>> = BTreeMap::new();
        for (z, [a, b]) in lines.iter().enumerate() {
            // Pieces are shorter than a square: both ends say where they are.
            let ends = BTreeSet::from([square(*a), square(*b)]);
            ends.into_iter().for_each(|s| squares.entry(s).or_default().push(z as u32));
        }
        self.obstacles = Obstacles {
            all: Arc::new(all),
            lines: Arc::new(lines),
            squares: Arc::new(squares),
            held: BTreeMap::new(),
            runways: vec![None; self.net.runways.len()],
            told: BTreeSet::new(),
        };
        // Whoever was put on a stand is put again, beside them.
        let seed = self.seed;
        let flights = Arc::clone(&self.flights);
        self.movers =
            flights.iter().enumerate().map(|(f, flight)| Mover::of(f, flight, seed)).collect();
        self.holders.iter_mut().for_each(Vec::clear);
        self.rolls.iter_mut().for_each(Vec::clear);
        self.remarks.clear();
        self.clearances.clear();
        self.look_at_obstacles();
        self.appear();
        self
    }

    /// An obstacle that holds a piece against a mover of a class: counted on from the movers.
    pub(super) fn obstacle_on(&self, piece: u32, class: super::Class) -> Option<usize> {
        let held = self.obstacles.held.get(&piece)?;
        let reach_m = SIZES[class as usize].half_span_m + ROOM_M;
        let near = held.iter().find(|(_, distance_m)| *distance_m < reach_m);
        near.map(|(o, _)| self.movers.len() + *o as usize)
    }

    /// An obstacle in, or soon in, the strip of this runway or of one that crosses it.
    pub(super) fn obstacle_on_runway(&self, r: usize) -> Option<usize> {
        if self.obstacles.all.is_empty() {
            return None;
        }
        self.crossing[r].iter().find_map(|c| self.obstacles.runways[*c])
    }

    /// Name of a flight or obstacle.
    pub(super) fn name_of(&self, who: usize) -> &str {
        match self.flights.get(who) {
            Some(flight) => &flight.callsign,
            None => self.obstacles.all.get(who - self.flights.len()).map_or("", |o| &o.callsign),
        }
    }

    /// Once a second: what obstacles hold, and whom they overlap.
    pub(super) fn look_at_obstacles(&mut self) {
        if self.obstacles.all.is_empty() {
            return;
        }
        let all = Arc::clone(&self.obstacles.all);
        let now = SimTime::from_s(self.time_s);
        let after = |s: f64| SimTime::from_s(self.time_s + s);
        let mut held: BTreeMap<u32, Vec<(u32, f64)>> = BTreeMap::new();
        let mut runways = vec![None; self.net.runways.len()];
        let mut bodies: Vec<(usize, Vector2<f64>, [Rectangle; 2])> = Vec::new();
        for (o, obstacle) in all.iter().enumerate() {
            for k in 0..=12 {
                let ahead_s = RUNWAY_AHEAD_S * f64::from(k) / 12.0;
                let Some(state) = obstacle.trajectory.at(after(ahead_s)) else { continue };
                for (r, runway) in self.net.runways.iter().enumerate() {
                    let (place, across) = runway.place_m(state.position_m.xy());
                    let beside = (-60.0..=runway.length_m + 60.0).contains(&place);
                    // One that is only parked beside it has been there when the airport was made.
                    let moves = state.velocity_mps.norm() > 0.0;
                    let inside = beside && across.abs() < runway.hold_distance_m - 5.0;
                    let on = across.abs() < 0.5 * runway.width_m + 5.0;
                    if inside && (moves || on) && state.position_m.z < 150.0 {
                        runways[r].get_or_insert(self.movers.len() + o);
                    }
                }
            }
            let Some(state) = obstacle.trajectory.at(now).filter(|s| s.position_m.z < 3.0) else {
                continue;
            };
            let speed = state.velocity_mps.norm();
            let most_s = if speed > 0.0 {
                (speed / (2.0 * BRAKES_MPS2) + 3.0).min(MOST_AHEAD_S)
            } else {
                // About to start: where it is in two seconds.
                2.0
            };
            let mut touched: BTreeMap<u32, f64> = BTreeMap::new();
            let mut ahead_s = 0.0;
            let mut last = None;
            while ahead_s <= most_s {
                let then = obstacle.trajectory.at(after(ahead_s)).filter(|s| s.position_m.z < 3.0);
                ahead_s += 1.0;
                let Some(then) = then else { continue };
                let at = then.position_m.xy();
                if last == Some(at) {
                    continue;
                }
                last = Some(at);
                let body = outline(obstacle.size, at, then.heading_rad);
                let (x, y) = square(at);
                for near in (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| (x, y))) {
                    for z in self.obstacles.squares.get(&near).into_iter().flatten() {
                        let line = self.obstacles.lines[*z as usize];
                        let distance_m = distance_to_line_m(&body, line);
                        if distance_m < SIZES[SIZES.len() - 1].half_span_m + ROOM_M {
                            let least = touched.entry(*z).or_insert(f64::INFINITY);
                            *least = least.min(distance_m);
                        }
                    }
                }
            }
            for (z, distance_m) in touched {
                held.entry(z).or_default().push((o as u32, distance_m));
            }
            let body = outline(obstacle.size, state.position_m.xy(), state.heading_rad);
            bodies.push((o, state.position_m.xy(), body));
        }
        if held != self.obstacles.held || runways != self.obstacles.runways {
            self.version += 1;
        }
        self.obstacles.held = held;
        self.obstacles.runways = runways;
        self.tell_overlaps(&bodies);
    }

    fn tell_overlaps(&mut self, bodies: &[(usize, Vector2<f64>, [Rectangle; 2])]) {
        let mut found = Vec::new();
        for m in 0..self.movers.len() {
            let there = !matches!(self.movers[m].phase, Phase::Absent | Phase::Gone | Phase::Final);
            if !there {
                continue;
            }
            let Some(state) = self.state(m).filter(|s| s.position_m.z < 3.0) else { continue };
            let size = self.flights[m].size;
            for (o, at, body) in bodies {
                let apart = (state.position_m.xy() - at).norm();
                if apart > 160.0 || self.obstacles.told.contains(&(m, *o)) {
                    continue;
                }
                let own = outline(size, state.position_m.xy(), state.heading_rad);
                if distance_m(&own, body) == 0.0 {
                    found.push((m, *o));
                }
            }
        }
        for (m, o) in found {
            self.obstacles.told.insert((m, o));
            let theirs = self.obstacles.all[o].callsign.clone();
            self.remark(format!("{theirs} overlaps {}", self.flights[m].callsign));
        }
    }
}
