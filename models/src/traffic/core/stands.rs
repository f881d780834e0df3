//! Stands: what lies under an aircraft, which are free, who comes into the run.

use super::departure::SWING_M;
use super::{Core, Direction, Flight, Phase, Policy, Timing, class_of};
use crate::frames::Azimuth;
use crate::traffic::outline::Size;
use crate::traffic::pieces::SIZES;
use crate::traffic::way::Arcs;
use std::sync::Arc;

/// What tells ways off stands apart: stand, size, runway and end.
pub(super) type Left = (usize, (u64, u64), usize, usize);

/// How a stand is left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Leaving {
    /// Pushed back.
    Pushed,
    /// By itself, the nose to the lane.
    Ahead,
}

/// The middle is within this share of a length (of 20 m at least) of the place of a stand.
const ON_PLACE: f64 = 0.65;

impl Core {
    /// How far short of the node of a stand somebody of this size has his middle, m: tails stand in one line, nobody behind the
    /// place of the file, and, where his line is straight enough, nobody with all of his body beyond it.
    pub(super) fn short_of_node_m(&self, stand: usize, size: Size) -> f64 {
        let s = &self.net.stands[stand];
        let code = if s.code_known { s.code.min(5) } else { 2 };
        let longest_m = SIZES[usize::from(code) + 1].length_m;
        let in_line_m = 0.5 * (longest_m - size.length_m);
        // A pushback begins on a straight line, before a nose is swung into the bend of the lead-in.
        let straight_m = self.pieces.straight_to_m(stand, class_of(size));
        let latest_m = straight_m - SWING_M - 0.1 * size.length_m;
        // But he is on his stand: not farther beyond the place than is seen as on it.
        let latest_m = latest_m.max(s.moved_m - ON_PLACE * size.length_m.max(20.0));
        let on_place_m = (s.moved_m - 0.5 * size.length_m).min(latest_m);
        in_line_m.max(on_place_m).clamp(0.0, s.moved_m.max(0.0))
    }

    pub(super) fn stand_pose(&self, stand: usize, size: Size) -> (nalgebra::Point2<f64>, f64) {
        let s = &self.net.stands[stand];
        let Some(node) = s.node else { return (s.at_m, s.heading_rad) };
        let into = self.stand_arc(node);
        let heading = into.map_or(s.heading_rad, |arc| self.arcs.heading_rad(arc));
        let back = Azimuth::from_rad(heading).unit() * self.short_of_node_m(stand, size);
        (self.net.nodes[node].at_m - back, heading)
    }

    /// The arc by which a stand is entered.
    pub(super) fn stand_arc(&self, node: usize) -> Option<usize> {
        let mut arcs = self.arcs.edges_at(node).iter().filter_map(|e| {
            let edge = &self.net.edges[*e];
            let used = edge.nodes.iter().all(|n| self.net.nodes[*n].used);
            if edge.nodes[1] == node && used {
                Some(2 * e)
            } else if edge.nodes[0] == node && edge.two_way && used {
                Some(2 * e + 1)
            } else {
                None
            }
        });
        arcs.next()
    }

    /// Pieces under an aircraft on a stand.
    pub(super) fn pieces_of_stand(&self, stand: usize, size: Size) -> Vec<u32> {
        let Some(mut arc) = self.net.stands[stand].node.and_then(|n| self.stand_arc(n)) else {
            return Vec::new();
        };
        let mut found = Vec::new();
        // Pieces of a lead-in are up to 6 m long, and a tail is narrow: up to 2 m less than half the length.
        let mut room = 0.5 * size.length_m - 2.0 + self.short_of_node_m(stand, size);
        loop {
            let (first, count) = self.pieces.of_edge[arc / 2];
            for i in 0..count {
                let z = if arc % 2 == 0 { first + count - 1 - i } else { first + i };
                let piece = &self.pieces.list[z];
                found.push(z as u32);
                room -= piece.to_m - piece.from_m;
                if room <= 0.0 {
                    return found;
                }
            }
            // Longer than its lead-in: the straightest edge behind it.
            let node = Arcs::from(&self.net, arc);
            let towards = self.arcs.away_from(&self.net, node).map(|a| a ^ 1);
            let behind = towards.filter(|b| b / 2 != arc / 2 && self.arcs.turn_rad(*b, arc) < 1.6);
            let straightest = behind
                .min_by(|p, q| self.arcs.turn_rad(*p, arc).total_cmp(&self.arcs.turn_rad(*q, arc)));
            match straightest {
                Some(next) if found.len() < 64 => arc = next,
                _ => return found,
            }
        }
    }

    /// Whether somebody of this class could stand there: nobody there or beside, nobody's way over it,
    /// nobody else on his way to it.
    pub(super) fn stand_is_free(&self, m: usize, stand: usize, pieces: &[u32]) -> bool {
        if pieces.is_empty() || pieces.iter().any(|z| self.blocker(m, *z, false, &[]).is_some()) {
            return false;
        }
        let touches = |other: usize, z: u32| {
            let class = self.movers[other].class;
            pieces.iter().any(|p| {
                self.pieces
                    .conflicts(*p as usize, self.movers[m].class)
                    .iter()
                    .any(|(o, least)| *o == z && class >= *least)
            })
        };
        for o in (0..self.movers.len()).filter(|o| *o != m) {
            let other = &self.movers[o];
            let coming = matches!(other.phase, Phase::Final | Phase::Landing)
                || (other.phase == Phase::Taxiing
                    && self.flights[o].direction == Direction::Arrival);
            if coming
                && (other.stand == stand || other.parked_pieces.iter().any(|z| touches(o, *z)))
            {
                return false;
            }
            if let Some((goal, there)) = &other.goal
                && (*goal == stand || there.iter().any(|z| touches(o, *z)))
            {
                return false;
            }
            // Under a plan those who drive over it come before an arrival, but not before one who is put there.
            let put =
                self.policy != Policy::Planned || self.flights[m].direction == Direction::Departure;
            let ways = self.active(o) || other.timing.planned && other.phase != Phase::Docked;
            if put && ways {
                let (p, w) = self.first_untaken(o);
                let rest = other.push.pieces.iter().skip(p).chain(other.way.pieces.iter().skip(w));
                if rest.into_iter().any(|z| touches(o, *z)) {
                    return false;
                }
            }
        }
        true
    }

    /// Whether somebody like `m` can leave a stand and find a way to his runway on an empty airport; of an arrival his next flight.
    pub(super) fn can_leave(&mut self, m: usize, stand: usize) -> bool {
        self.leaving(m, stand).is_some()
    }

    /// How he leaves it; pushed back if nobody does.
    fn leaving(&mut self, m: usize, stand: usize) -> Option<Leaving> {
        let next = self.flights.iter().position(|g| g.turnaround_of == Some(m));
        let leaves = match self.flights[m].direction {
            Direction::Departure => Some(m),
            Direction::Arrival => next,
            Direction::Vehicle => None,
        };
        let Some(d) = leaves else { return Some(Leaving::Pushed) };
        let (runway, end) = self.flights[d].runway;
        let key = (stand, self.flights[d].key_of_size(), runway, end);
        if let Some(known) = self.leaves.get(&key) {
            return *known;
        }
        let old = self.movers[d].clone();
        let told = self.remarks.len();
        let narrow = self.narrow(d);
        let easy = vec![false; 2 * self.net.edges.len()];
        self.movers[d].stand = stand;
        let ways = [Leaving::Pushed, Leaving::Ahead];
        let found = ways.into_iter().find(|way| {
            self.movers[d].turned = *way == Leaving::Ahead;
            let fits = *way == Leaving::Pushed || self.is_turned_by_hand(d);
            fits && self.plan_departure(d, &narrow, &easy, &[])
        });
        self.movers[d] = old;
        self.remarks.truncate(told);
        self.leaves.insert(key, found);
        found
    }

    /// Free stands for a flight, best first, at most `most`: the wanted one, else the smallest that are large
    /// enough, nearest to it.
    pub(super) fn free_stands(&mut self, m: usize, most: usize) -> Vec<(usize, Vec<u32>)> {
        let flights = Arc::clone(&self.flights);
        let f = &flights[m];
        let mut found = Vec::new();
        let wanted = self.pieces_of_stand(f.stand, f.size);
        if self.stand_is_free(m, f.stand, &wanted) && self.can_leave(m, f.stand) {
            found.push((f.stand, wanted));
        }
        let need = class_of(f.size).saturating_sub(1);
        let at = self.net.stands[f.stand].at_m;
        let mut others: Vec<usize> = (0..self.net.stands.len())
            .filter(|s| {
                let stand = &self.net.stands[*s];
                *s != f.stand
                    && stand.code >= need
                    && stand.node.is_some_and(|n| self.net.nodes[n].used)
            })
            .collect();
        others.sort_by(|a, b| {
            let key = |s: usize| (self.net.stands[s].code, (self.net.stands[s].at_m - at).norm());
            let ((ca, da), (cb, db)) = (key(*a), key(*b));
            ca.cmp(&cb).then(da.total_cmp(&db)).then(a.cmp(b))
        });
        for s in others {
            if found.len() >= most {
                break;
            }
            let pieces = self.pieces_of_stand(s, f.size);
            if self.stand_is_free(m, s, &pieces) && self.can_leave(m, s) {
                found.push((s, pieces));
            }
        }
        found.truncate(most);
        found
    }

    /// The best free stand.
    pub(super) fn free_stand(&mut self, m: usize) -> Option<(usize, Vec<u32>)> {
        self.free_stands(m, 1).pop()
    }

    /// Who comes into the run: departures on their stands, arrivals on final.
    pub(super) fn appear(&mut self) {
        for m in 0..self.movers.len() {
            if self.movers[m].phase != Phase::Absent || self.movers[m].next_try_s > self.time_s {
                continue;
            }
            let flights = Arc::clone(&self.flights);
            let f = &flights[m];
            match f.direction {
                Direction::Departure => self.appear_on_stand(m, f),
                Direction::Arrival => self.appear_on_final(m, f),
                Direction::Vehicle => self.appear_to_drive(m, f),
            }
        }
    }

    pub(super) fn appear_on_stand(&mut self, m: usize, f: &Flight) {
        if let Some(to) = self.movers[m].tow_to {
            let pieces = self.pieces_of_stand(to, f.size);
            let found = match self.stand_is_free(m, to, &pieces) {
                true => Some(to),
                false => self.stand_to_tow_to(m),
            };
            if let Some(stand) = found {
                self.movers[m].tow_to = None;
                self.park(m, stand);
            }
            return;
        }
        // The aircraft of a turn-round becomes the departure when it is due.
        if let Some(arrival) = f.turnaround_of {
            let docked = self.movers[arrival].phase == Phase::Docked;
            let rested =
                self.movers[arrival].measures.aibt_s.is_some_and(|t| self.time_s >= t + 300.0);
            if docked && rested && self.time_s >= f.time_s - 60.0 {
                let stand = self.movers[arrival].stand;
                self.leave_stand(arrival);
                self.park(m, stand);
            }
            return;
        }
        if self.time_s < f.time_s - 1800.0 && self.time_s > 0.0 {
            return;
        }
        let wanted = self.pieces_of_stand(f.stand, f.size);
        let leaves = self.can_leave(m, f.stand);
        if !leaves || !self.stand_is_free(m, f.stand, &wanted) {
            // An aircraft there that nobody needs any more is taken for this one.
            let idle = (0..self.movers.len()).find(|o| {
                self.movers[*o].phase == Phase::Docked
                    && self.movers[*o].stand == f.stand
                    && !self.flights.iter().any(|g| g.turnaround_of == Some(*o))
            });
            match idle {
                Some(idle) if leaves && self.time_s >= f.time_s - 600.0 => {
                    self.leave_stand(idle);
                    if !self.stand_is_free(m, f.stand, &wanted) {
                        return;
                    }
                }
                _ if leaves && self.time_s < f.time_s => return,
                _ => {
                    let mut found = self.free_stand(m);
                    if found.is_none() && self.time_s >= f.time_s {
                        found = self.make_room(m);
                    }
                    if found.is_none() && self.movers[m].waits_since_s.is_none() {
                        self.remark(format!("{}: no free stand to leave from", f.callsign));
                        self.movers[m].waits_since_s = Some(self.time_s);
                    }
                    if let Some((stand, _)) = found {
                        self.movers[m].waits_since_s = None;
                        let why = if leaves { "is not free" } else { "has no way to the runway" };
                        let text = format!(
                            "{}: stand {} {why}, at {} instead",
                            f.callsign, self.net.stands[f.stand].name, self.net.stands[stand].name
                        );
                        self.remark(text);
                        self.park(m, stand);
                    }
                    return;
                }
            }
        }
        self.park(m, f.stand);
    }

    pub(super) fn park(&mut self, m: usize, stand: usize) {
        let pieces = self.pieces_of_stand(stand, self.flights[m].size);
        pieces.iter().for_each(|z| self.hold(m, *z, false));
        let turned = self.is_turned_on(m, stand);
        let mover = &mut self.movers[m];
        mover.turned = turned;
        mover.stand = stand;
        mover.parked_pieces = pieces;
        mover.phase = Phase::Parked;
        mover.next_try_s = 0.0;
    }

    /// Whether a flight stands on a stand with its nose to the lane, and leaves without a pushback.
    pub(super) fn is_turned_on(&mut self, m: usize, stand: usize) -> bool {
        self.flights[m].direction == Direction::Departure
            && self.is_turned_by_hand(m)
            && self.leaving(m, stand) == Some(Leaving::Ahead)
    }

    pub(super) fn leave_stand(&mut self, m: usize) {
        let pieces = std::mem::take(&mut self.movers[m].parked_pieces);
        pieces.iter().for_each(|z| self.release(m, *z, false));
        self.movers[m].phase = Phase::Gone;
        self.movers[m].timing = Timing::default();
    }
}
