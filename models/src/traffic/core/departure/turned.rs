//! Light aircraft that stand with their nose to the lane: turned by hand where there is no room for a pushback, they leave by themselves.

use super::Pushback;
use crate::draw::uniform;
use crate::traffic::core::plan::Start;
use crate::traffic::core::{Core, Phase};
use crate::traffic::way::Way;
use std::ops::Range;

/// Aircraft up to this length are turned by hand, m (assumed: a light twin, a small jet).
const BY_HAND_M: f64 = 15.0;
/// Starting the engines, s: least, and what is drawn beside it (assumed).
const STARTS_S: [f64; 2] = [60.0, 30.0];

impl Core {
    /// Whether an aircraft is light enough to be turned by hand.
    pub(in crate::traffic::core) fn is_turned_by_hand(&self, m: usize) -> bool {
        let size = self.flights[m].size;
        size.aircraft && size.length_m <= BY_HAND_M
    }

    /// The way off its stand of one who stands with his nose to the lane.
    pub(super) fn find_way_ahead(
        &self,
        m: usize,
        closed: &[bool],
        slow: &[bool],
    ) -> Option<Pushback> {
        let into = self.net.stands[self.movers[m].stand].node.and_then(|n| self.stand_arc(n))?;
        let goal = self.goal_of_way(m);
        let (wanted_m, scant_m) = goal.least_m();
        let is_closed = |e: usize| closed[e] && e != into / 2 || goal.keeps_off(&self.net.edges[e]);
        wanted_m.iter().chain(&scant_m).find_map(|least_m| {
            let ends = |arc: usize| self.ends_way(&goal, arc, *least_m);
            let from = [(into ^ 1, 0.0)];
            let way = self.arcs.quickest(&self.net, &from, ends, is_closed, |a| slow[a])?;
            Some((Vec::new(), Vec::new(), way.arcs))
        })
    }

    /// Lays it.
    pub(super) fn lay_way_ahead(&mut self, m: usize, arcs: &[usize]) -> bool {
        let Some(first_strip) = self.lay_to_runway(m, arcs.to_vec()) else { return false };
        let (under, place_m) = self.ahead_of_stand(m);
        let mover = &mut self.movers[m];
        let (way, driving) = (&mover.way, &mover.driving);
        mover.measures.unhindered_s =
            STARTS_S[0] + 0.5 * STARTS_S[1] + way.unhindered_s(place_m, way.stop_m, driving);
        mover.push = Way::default();
        mover.under = under;
        mover.under.end <= first_strip
    }

    /// Steps under one who stands with his nose to the lane, and the place of his nose wheel on his way, m.
    fn ahead_of_stand(&self, m: usize) -> (Range<usize>, f64) {
        let (mover, size) = (&self.movers[m], self.flights[m].size);
        let place_m = self.short_of_node_m(mover.stand, size) + 0.4 * size.length_m;
        let nose_m = place_m + 0.1 * size.length_m + 1.0;
        let last = mover.way.ends_m.iter().position(|e| *e >= nose_m).unwrap_or(0);
        (0..last + 1, place_m)
    }

    /// Where and when his way begins for the plan.
    pub(super) fn start_ahead(&self, m: usize) -> Start {
        let (under, place_m) = self.ahead_of_stand(m);
        Start::Stand { place_m, first: under.start, pushed: under.end, push_s: 0.0 }
    }

    /// Starts his engines where he stands: what is under him is his already.
    pub(super) fn starts_ahead(&mut self, m: usize) {
        let (_, place_m) = self.ahead_of_stand(m);
        let mut rng = self.rng(m, 2);
        let until_s = self.time_s + STARTS_S[0] + STARTS_S[1] * uniform(&mut rng);
        let mover = &mut self.movers[m];
        mover.phase = Phase::Starting(until_s);
        (mover.first_held, mover.next) = (mover.under.start, mover.under.end);
        (mover.s, mover.slip) = (place_m, 0.0);
        mover.beside_m *= 0.0;
    }
}
