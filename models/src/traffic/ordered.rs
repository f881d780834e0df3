//! Ordered states: can everybody finish, one after the other, while the rest stand where they are?
//!
//! Source: the banker's algorithm (Dijkstra) on fixed ways of zone-controlled vehicles.

/// One mover in a state: what it holds and what is left of its way.
#[derive(Clone, Debug, PartialEq)]
pub struct Holding {
    /// Pieces held.
    pub held: Vec<usize>,
    /// Pieces still to be used, in order, without those held.
    pub remaining: Vec<usize>,
    /// Holds the last piece of its way for ever (a stand); others leave.
    pub keeps_last: bool,
}

/// Whether the state is ordered, exactly. `conflicts[z]` lists the pieces that conflict with `z`,
/// itself included or not; a piece always conflicts with itself.
///
/// Finishing of one who leaves only frees pieces, so removing these as they can go is exact in any
/// order. One who keeps its last piece may be removed at once where that piece conflicts with nobody's
/// remaining way; the search goes over the rest, at most `limit` steps (beyond it: not ordered, which is
/// safe).
#[must_use]
pub fn is_ordered(conflicts: &[Vec<usize>], movers: &[Holding], limit: usize) -> bool {
    let mut state = State::new(conflicts, movers);
    let mut steps = limit;
    state.search(&mut steps)
}

struct State<'a> {
    conflicts: &'a [Vec<usize>],
    movers: &'a [Holding],
    /// How many movers hold the piece or one that conflicts with it, one count a held piece.
    blocked: Vec<u32>,
    here: Vec<bool>,
}

impl<'a> State<'a> {
    fn new(conflicts: &'a [Vec<usize>], movers: &'a [Holding]) -> Self {
        let blocked = vec![0; conflicts.len()];
        let mut state = Self { conflicts, movers, blocked, here: vec![true; movers.len()] };
        for mover in movers {
            mover.held.iter().for_each(|z| state.count(*z, true));
        }
        state
    }

    fn count(&mut self, piece: usize, more: bool) {
        let change = |n: &mut u32| *n = if more { *n + 1 } else { *n - 1 };
        change(&mut self.blocked[piece]);
        for other in &self.conflicts[piece] {
            if *other != piece {
                change(&mut self.blocked[*other]);
            }
        }
    }

    /// Whether its way is free of everybody else.
    fn can_go(&mut self, mover: usize) -> bool {
        let this = &self.movers[mover];
        this.held.iter().for_each(|z| self.count(*z, false));
        let free = this.remaining.iter().all(|z| self.blocked[*z] == 0);
        this.held.iter().for_each(|z| self.count(*z, true));
        free
    }

    fn remove(&mut self, mover: usize) {
        let this = &self.movers[mover];
        this.held.iter().for_each(|z| self.count(*z, false));
        if let Some(last) = this.kept() {
            self.count(last, true);
        }
        self.here[mover] = false;
    }

    fn restore(&mut self, mover: usize) {
        let this = &self.movers[mover];
        if let Some(last) = this.kept() {
            self.count(last, false);
        }
        this.held.iter().for_each(|z| self.count(*z, true));
        self.here[mover] = true;
    }

    /// Whether what it keeps stands in nobody's way.
    fn harmless(&self, mover: usize) -> bool {
        let Some(last) = self.movers[mover].kept() else { return true };
        let touches = |z: &usize| *z == last || self.conflicts[last].contains(z);
        let others = self.movers.iter().enumerate().filter(|(i, _)| *i != mover && self.here[*i]);
        !others.flat_map(|(_, m)| &m.remaining).any(touches)
    }

    fn search(&mut self, steps: &mut usize) -> bool {
        let mut removed = Vec::new();
        loop {
            let count = self.movers.len();
            let next = (0..count).find(|m| self.here[*m] && self.can_go(*m) && self.harmless(*m));
            let Some(mover) = next else { break };
            self.remove(mover);
            removed.push(mover);
        }
        if !self.here.contains(&true) {
            return true;
        }
        for mover in 0..self.movers.len() {
            if *steps == 0 {
                break;
            }
            if self.here[mover] && self.can_go(mover) {
                *steps -= 1;
                self.remove(mover);
                if self.search(steps) {
                    return true;
                }
                self.restore(mover);
            }
        }
        removed.into_iter().rev().for_each(|m| self.restore(m));
        false
    }
}

impl Holding {
    fn kept(&self) -> Option<usize> {
        let last = self.remaining.last().or(self.held.last()).copied();
        last.filter(|_| self.keeps_last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// n movers on a ring of n pieces, each wants the next one: nobody can go.
    #[test]
    fn a_full_ring_is_not_ordered() {
        let ring = |movers: usize, pieces: usize| {
            let conflicts = vec![Vec::new(); pieces];
            let movers: Vec<Holding> = (0..movers)
                .map(|m| Holding {
                    held: vec![m],
                    remaining: (1..pieces).map(|k| (m + k) % pieces).collect(),
                    keeps_last: false,
                })
                .collect();
            is_ordered(&conflicts, &movers, 1000)
        };
        assert!(!ring(5, 5));
        assert!(ring(1, 5));
    }

    #[test]
    fn two_head_on_in_a_spur_are_not_ordered_unless_one_waits_outside() {
        let conflicts = vec![Vec::new(); 4];
        let going = |held: &[usize], remaining: &[usize], keeps_last| Holding {
            held: held.to_vec(),
            remaining: remaining.to_vec(),
            keeps_last,
        };
        // 0 lane, 1 and 2 spur, 3 stand.
        let out = going(&[2], &[1, 0], false);
        assert!(!is_ordered(&conflicts, &[going(&[1], &[2, 3], true), out.clone()], 100));
        let waits = going(&[], &[0, 1, 2, 3], true);
        assert!(is_ordered(&conflicts, &[waits, out], 100));
    }
}
