//! Movers that are functions of time (recorded, on a route, parked): they do not give way, so what behaves does.
//!
//! Once a second each of them holds the pieces that its outline touches now and on the way on which it could stop, and
//! every runway in whose strip it is within the next minute. Nobody behaving takes these; who has taken one before is
//! reported if they overlap. Movers that people drive ([`hand`](super::hand)) are looked at alike, on the way on which they could stop.

use super::{Core, Mover, Phase};
use crate::frames::Point2;
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
    lines: Arc<Vec<[Point2<f64>; 2]>>,
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

fn square(at: Point2<f64>) -> (i64, i64) {
    ((at.x / SQUARE_M).floor() as i64, (at.y / SQUARE_M).floor() as i64)
}

impl Core {
    /// The same core with obstacles, before its first step.
    #[must_use]
    pub fn with_obstacles(mut self, all: Vec<Obstacle>) -> Self {
        if all.is_empty() {
            return self;
        }
        self.obstacles.all = Arc::new(all);
        self.beside_others();
        self
    }

    /// Whoever was put on a stand is put again, beside obstacles and what people drive.
    pub(super) fn beside_others(&mut self) {
        let line = |piece: &crate::traffic::pieces::Piece| {
            let [a, b] = self.net.edges[piece.edge].nodes.map(|n| self.net.nodes[n].at_m);
            let along = (b - a) / (b - a).norm().max(1e-9);
            [a + along * piece.from_m, a + along * piece.to_m]
        };
        let lines: Vec<[Point2<f64>; 2]> = self.pieces.list.iter().map(line).collect();
        let mut squares: BTreeMap<(i64, i64), Vec<u32>> = BTreeMap::new();
        for (z, [a, b]) in lines.iter().enumerate() {
            // Pieces are shorter than a square: both ends say where they are.
            let ends = BTreeSet::from([square(*a), square(*b)]);
            ends.into_iter().for_each(|s| squares.entry(s).or_default().push(z as u32));
        }
        self.obstacles = Obstacles {
            all: Arc::clone(&self.obstacles.all),
            lines: Arc::new(lines),
            squares: Arc::new(squares),
            held: BTreeMap::new(),
            runways: vec![None; self.net.runways.len()],
            told: BTreeSet::new(),
        };
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
    }

    /// Nobody is there but those who behave.
    fn alone(&self) -> bool {
        self.obstacles.all.is_empty() && self.hands.is_empty() && !self.flights_by_hand
    }

    /// A driven mover among those that `obstacle_on` names.
    pub(super) fn beside_hand(&self, n: usize) -> usize {
        self.movers.len() + self.obstacles.all.len() + n
    }

    /// Lines of pieces within a square of a place.
    pub(super) fn lines_near(&self, at: Point2<f64>) -> impl Iterator<Item = [Point2<f64>; 2]> {
        let (x, y) = square(at);
        let squares = (x - 1..=x + 1).flat_map(move |x| (y - 1..=y + 1).map(move |y| (x, y)));
        let pieces = squares.filter_map(|s| self.obstacles.squares.get(&s)).flatten();
        pieces.map(|z| self.obstacles.lines[*z as usize])
    }

    /// An obstacle that holds a piece against mover `m`: counted on from the movers.
    pub(super) fn obstacle_on(&self, piece: u32, m: usize) -> Option<usize> {
        let held = self.obstacles.held.get(&piece)?;
        let reach_m = SIZES[self.movers[m].class as usize].half_span_m + ROOM_M;
        let own = self.obstacles.all.len() + self.hands.len() + m;
        let near = held.iter().find(|(o, distance_m)| *distance_m < reach_m && *o as usize != own);
        near.map(|(o, _)| self.movers.len() + *o as usize)
    }

    /// An obstacle in, or soon in, the strip of this runway or of one that crosses it.
    pub(super) fn obstacle_on_runway(&self, r: usize) -> Option<usize> {
        if self.alone() {
            return None;
        }
        self.crossing[r].iter().find_map(|c| self.obstacles.runways[*c])
    }

    /// Whether a mover that is a function of time has this name.
    pub(super) fn is_obstacle(&self, name: &str) -> bool {
        self.obstacles.all.iter().any(|o| o.callsign == name)
    }

    /// Name of a flight, an obstacle or a driven mover.
    pub(super) fn name_of(&self, who: usize) -> &str {
        let Some(other) = who.checked_sub(self.flights.len()) else {
            return &self.flights[who].callsign;
        };
        match other.checked_sub(self.obstacles.all.len()) {
            None => &self.obstacles.all[other].callsign,
            Some(n) => match n.checked_sub(self.hands.len()) {
                None => &self.hands[n].of.callsign,
                Some(m) => self.flights.get(m).map_or("", |f| &f.callsign),
            },
        }
    }

    /// Number of a mover that a person drives, as [`Core::name_of`] counts.
    pub(super) fn hand_number(&self, hand: usize) -> usize {
        self.flights.len() + self.obstacles.all.len() + hand
    }

    /// Once a second: what obstacles hold, and whom they overlap.
    pub(super) fn look_at_obstacles(&mut self) {
        if self.alone() {
            return;
        }
        let all = Arc::clone(&self.obstacles.all);
        let mut held: BTreeMap<u32, Vec<(u32, f64)>> = BTreeMap::new();
        let mut runways = vec![None; self.net.runways.len()];
        let mut bodies: Vec<(usize, Point2<f64>, [Rectangle; 2])> = Vec::new();
        let mut hold = |o: usize, touched: BTreeMap<u32, f64>| {
            for (z, distance_m) in touched {
                held.entry(z).or_default().push((o as u32, distance_m));
            }
        };
        let after = |s: f64| SimTime::from_s(self.time_s + s);
        for (o, obstacle) in all.iter().enumerate() {
            for k in 0..=12 {
                let ahead_s = RUNWAY_AHEAD_S * f64::from(k) / 12.0;
                let Some(state) = obstacle.trajectory.at(after(ahead_s)) else { continue };
                if state.position_m.z < 150.0 {
                    // One that is only parked beside it has been there when the airport was made.
                    let moves = state.velocity_mps.norm() > 0.0;
                    self.occupy(&mut runways, o, state.position_m.xy(), moves);
                }
            }
            let on_ground = |s: &crate::truth::TruthState| s.position_m.z < 3.0;
            let Some(state) = obstacle.trajectory.at(after(0.0)).filter(on_ground) else {
                continue;
            };
            let speed = state.velocity_mps.norm();
            let most_s = if speed > 0.0 {
                (speed / (2.0 * BRAKES_MPS2) + 3.0).min(MOST_AHEAD_S)
            } else {
                // About to start: where it is in two seconds.
                2.0
            };
            let times = (0..=most_s as u32).map(|k| after(f64::from(k)));
            let there = times.filter_map(|then| obstacle.trajectory.at(then).filter(on_ground));
            let poses = there.map(|s| (s.position_m.xy(), s.heading_rad));
            hold(o, self.touched(obstacle.size, poses));
            let body = outline(obstacle.size, state.position_m.xy(), state.heading_rad);
            bodies.push((o, state.position_m.xy(), body));
        }
        let hands = self.hands.iter().enumerate();
        let flights = self.beside_their_ways().into_iter();
        for (n, hand) in hands.chain(flights.map(|(m, hand)| (self.hands.len() + m, hand))) {
            let o = all.len() + n;
            let way = hand.stopping();
            for (_, at, _) in &way {
                self.occupy(&mut runways, o, *at, true);
            }
            hold(o, self.touched(hand.of.size, way.into_iter().map(|(_, at, to)| (at, to))));
            if n >= self.hands.len() {
                continue; // touches of flights are looked for by eye
            }
            let at = hand.middle_m();
            bodies.push((o, at, outline(hand.of.size, at, hand.heading_rad)));
        }
        if held != self.obstacles.held || runways != self.obstacles.runways {
            self.version += 1;
        }
        self.obstacles.held = held;
        self.obstacles.runways = runways;
        self.tell_overlaps(&bodies);
    }

    /// An obstacle at a place has the runways in whose strips that is; one that never moves only those that it stands on.
    fn occupy(&self, runways: &mut [Option<usize>], o: usize, at: Point2<f64>, moves: bool) {
        for (r, runway) in self.net.runways.iter().enumerate() {
            let (place, across) = runway.place_m(at);
            let beside = (-60.0..=runway.length_m + 60.0).contains(&place);
            let inside = beside && across.abs() < runway.hold_distance_m - 5.0;
            let on = across.abs() < 0.5 * runway.width_m + 5.0;
            if inside && (moves || on) {
                runways[r].get_or_insert(self.movers.len() + o);
            }
        }
    }

    /// Pieces that somebody is near at some poses (place of the middle, heading), and how near, m.
    fn touched(
        &self,
        size: Size,
        poses: impl Iterator<Item = (Point2<f64>, f64)>,
    ) -> BTreeMap<u32, f64> {
        let mut touched: BTreeMap<u32, f64> = BTreeMap::new();
        let mut last = None;
        for (at, heading_rad) in poses {
            if last.replace(at) == Some(at) {
                continue;
            }
            let body = outline(size, at, heading_rad);
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
        touched
    }

    fn tell_overlaps(&mut self, bodies: &[(usize, Point2<f64>, [Rectangle; 2])]) {
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
        let driven = |o: usize| o >= self.obstacles.all.len();
        for (i, (b, _, body_b)) in bodies.iter().enumerate().filter(|(_, body)| driven(body.0)) {
            for (a, _, body_a) in &bodies[..i] {
                let both = (self.movers.len() + a, *b);
                if !self.obstacles.told.contains(&both) && distance_m(body_a, body_b) == 0.0 {
                    found.push(both);
                }
            }
        }
        let fixed = self.obstacles.all.len();
        for (m, o) in found {
            self.obstacles.told.insert((m, o));
            let theirs = self.name_of(self.movers.len() + o).to_owned();
            self.remark(format!("{theirs} overlaps {}", self.name_of(m)));
            let other = m.checked_sub(self.movers.len()).and_then(|m| m.checked_sub(fixed));
            for n in [o.checked_sub(fixed), other].into_iter().flatten() {
                self.hands[n].contacts += 1;
            }
        }
    }
}
