//! Edges that a mover cannot use, or is not to use.

use super::{Core, Phase};

/// What a way passes by: all that is closed now, what is closed without end, only what is too narrow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Closed {
    Now,
    Lasting,
    Narrow,
}

impl Core {
    /// Edges that are too narrow for a mover.
    pub(super) fn narrow(&self, m: usize) -> Vec<bool> {
        let class = self.movers[m].class;
        self.net.edges.iter().map(|e| class > e.code + 1).collect()
    }

    /// Edges that a mover cannot use: too narrow, or under somebody who stands for long.
    pub(super) fn closed(&self, m: usize) -> Vec<bool> {
        let (class, mut closed) = (self.movers[m].class, self.narrow(m));
        for o in (0..self.movers.len()).filter(|o| *o != m) {
            let other = &self.movers[o];
            let stands = matches!(other.phase, Phase::Parked | Phase::Docked);
            let promised = matches!(other.phase, Phase::Final | Phase::Landing | Phase::Taxiing);
            let parked = other.parked_pieces.iter().filter(|_| stands || promised);
            for z in parked.chain(other.goal.iter().flat_map(|goal| &goal.1)) {
                for (y, least) in self.pieces.conflicts(*z as usize, other.class) {
                    if class >= *least {
                        closed[self.pieces.list[*y as usize].edge] = true;
                    }
                }
            }
        }
        closed
    }

    /// Edges that a mover cannot use for a time without end: too narrow, or under somebody who does not leave.
    pub(super) fn closed_for_ever(&self, m: usize) -> Vec<bool> {
        let (class, mut closed) = (self.movers[m].class, self.narrow(m));
        for o in (0..self.movers.len()).filter(|o| *o != m) {
            let other = &self.movers[o];
            let stays = match other.phase {
                Phase::Docked => true,
                Phase::Parked => !other.timing.planned,
                _ => false,
            };
            for z in other.parked_pieces.iter().filter(|_| stays) {
                for (y, least) in self.pieces.conflicts(*z as usize, other.class) {
                    if class >= *least {
                        closed[self.pieces.list[*y as usize].edge] = true;
                    }
                }
            }
        }
        closed
    }

    /// Arcs that others who are under way will use the other way round: dear to meet them there.
    pub(super) fn opposed(&self, m: usize) -> Vec<bool> {
        let mut opposed = vec![false; 2 * self.net.edges.len()];
        for o in (0..self.movers.len()).filter(|o| *o != m) {
            if self.active(o) || self.movers[o].phase == Phase::Final {
                self.movers[o].way.arcs.iter().for_each(|a| opposed[a ^ 1] = true);
            }
        }
        opposed
    }
}
