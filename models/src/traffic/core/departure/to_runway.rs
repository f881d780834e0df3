//! The way to a runway: where a departure may enter it, and the way over the entry and along it.

use crate::traffic::core::flight::LINES_UP_LENGTHS;
use crate::traffic::core::{Core, Policy};
use crate::traffic::network::NetEdge;
use crate::traffic::runway_roll::INTERSECTION_SHARE;
use crate::traffic::way::{Arcs, GAP_M, Roll, Way};
use std::sync::Arc;

/// Where a departure may enter its runway.
#[derive(Clone, Copy, Debug)]
pub(in crate::traffic::core) struct Entries {
    /// Runway, and the end that is taken off from.
    runway: (usize, usize),
    /// Runway that is wanted ahead of the entry, m; where no way has that, less.
    pub(in crate::traffic::core) least_m: [f64; 2],
    /// Where no pushback leads to one with that, m: what a take-off from an intersection needs.
    pub(in crate::traffic::core) scant_m: f64,
}

/// Where a way from a stand leads.
#[derive(Clone, Copy, Debug)]
pub(in crate::traffic::core) enum Goal {
    /// To a runway, by one of its entries.
    Runway(Entries),
    /// To the node of a stand, beside all strips.
    Stand(Option<usize>),
}

impl Goal {
    /// Runway that is wanted ahead of the end of the way, and with what less one is content, m.
    pub(super) fn least_m(&self) -> (Vec<f64>, Vec<f64>) {
        match self {
            Self::Runway(entries) => (entries.least_m.to_vec(), vec![entries.scant_m]),
            Self::Stand(_) => (vec![0.0], Vec::new()),
        }
    }

    /// Whether a way there does not lead over an edge.
    pub(super) fn keeps_off(&self, edge: &NetEdge) -> bool {
        match self {
            Self::Runway(entries) => edge.runway == Some(entries.runway.0),
            Self::Stand(_) => edge.runway.is_some() || edge.strip.is_some(),
        }
    }
}

impl Core {
    /// Whether a way may end with an arc, so much of the runway ahead, m.
    pub(in crate::traffic::core) fn ends_way(&self, goal: &Goal, arc: usize, least_m: f64) -> bool {
        match goal {
            Goal::Runway(entries) => self.enters(entries, arc, least_m),
            Goal::Stand(node) => Some(Arcs::to(&self.net, arc)) == *node,
        }
    }

    /// Entries of a departure's runway with enough of it ahead.
    pub(in crate::traffic::core) fn entries(&self, m: usize) -> Entries {
        let f = &self.flights[m];
        let runway = &self.net.runways[f.runway.0];
        let entries = Entries { runway: f.runway, least_m: [0.0; 2], scant_m: 0.0 };
        let longest = self.arcs.longest_run_m(&self.net, f.runway);
        let run_m = self.run_m(m);
        let needed = (1.15 * run_m + 100.0).min(longest);
        let least_m = [needed.max((runway.length_m - 300.0).min(longest)), needed];
        let scant_m = (INTERSECTION_SHARE * run_m).min(longest);
        Entries { least_m, scant_m, ..entries }
    }

    /// Whether an arc ends on the runway with so much of it ahead, m.
    pub(in crate::traffic::core) fn enters(
        &self,
        entries: &Entries,
        arc: usize,
        least_m: f64,
    ) -> bool {
        self.arcs
            .run_ahead_m(&self.net, entries.runway, arc)
            .is_some_and(|run_m| run_m >= least_m - 1.0)
    }

    /// Lays a departure's way over arcs, the last of which enters its runway, and on along that; the first step in its strip.
    /// `None`: no runway is ahead there, and nothing has changed.
    pub(in crate::traffic::core) fn lay_to_runway(
        &mut self,
        m: usize,
        mut arcs: Vec<usize>,
    ) -> Option<usize> {
        let net = Arc::clone(&self.net);
        let (r, end) = self.flights[m].runway;
        let (runway, length) = (&net.runways[r], self.flights[m].size.length_m);
        let class = self.movers[m].class;
        let line_up_node = Arcs::to(&net, arcs[arcs.len() - 1]);
        let before_runway = arcs.len();
        let at = runway.spine.iter().position(|(_, n)| *n == line_up_node).unwrap_or(0);
        let ahead: Vec<usize> = if end == 0 {
            runway.spine[at..].windows(2).filter_map(|w| self.arc_between(w[0].1, w[1].1)).collect()
        } else {
            runway.spine[..=at]
                .windows(2)
                .rev()
                .filter_map(|w| self.arc_between(w[1].1, w[0].1))
                .collect()
        };
        if ahead.is_empty() {
            return None;
        }
        arcs.extend(ahead);
        let mut way = Way::over(&net, &self.pieces, &arcs, class, (0.0, 3000.0), 0.0);
        let pieces_before: usize =
            arcs[..before_runway].iter().map(|a| self.pieces.of_edge[a / 2].1).sum();
        let total = way.pieces.len();
        way.roll = pieces_before..total;
        let mut first_strip = pieces_before;
        while first_strip > 0
            && self.pieces.list[way.pieces[first_strip - 1] as usize].strip == Some(r)
        {
            first_strip -= 1;
        }
        way.group_crossings(&self.pieces, length + 10.0, first_strip..total);
        // Who has crossed a strip and has no room to stand clear of it before his runway lines up as he crosses: else he would stand
        // in the way of who is lined up there.
        let (ahead_m, behind_m, hold_gap_m) = self.body_m(m);
        let strip = |way: &Way, k: usize| self.pieces.list[way.pieces[k] as usize].strip;
        loop {
            way.hold_before(Some(first_strip));
            let Some(crossing) =
                way.crossings.iter().map(|c| c.0).filter(|k| *k < first_strip).max()
            else {
                break;
            };
            let in_strip = (crossing..first_strip).rev().find(|k| strip(&way, *k).is_some());
            let off_m = in_strip.map_or(0.0, |k| way.ends_m[k] + behind_m);
            if way.stop_before_m(first_strip, ahead_m, hold_gap_m) >= off_m {
                break;
            }
            first_strip = crossing;
        }
        let joined = way.ends_m[pieces_before - 1];
        let turned = way
            .path
            .arcs()
            .find(|a| a.0 <= joined + 0.1 && a.1 >= joined - 0.1)
            .map_or(joined, |a| a.1);
        way.stop_m = (turned + LINES_UP_LENGTHS * length).min(way.ends_m[total - 1]);
        // For the line-up as much of the runway as its nose needs, for the roll the rest. The banker's order takes all at once.
        let nose_m = way.stop_m + 0.1 * length + GAP_M + 1.0;
        let lined_up = way.ends_m.partition_point(|e| *e < nose_m).max(pieces_before);
        let whole = self.policy == Policy::Ordered;
        let roll_from = if whole { total } else { (lined_up + 1).min(total) };
        way.group(first_strip, total - 1);
        way.hold_before(Some(first_strip));
        let crossings: Vec<usize> = way.crossings.iter().map(|c| c.0).collect();
        way.clear_strips(&self.pieces, &crossings, first_strip, self.body_m(m));
        let driving = self.movers[m].driving;
        way.limit(&net, &self.pieces, &driving, &Roll::NONE);
        let mover = &mut self.movers[m];
        mover.cleared_from_m = Some(0.0);
        mover.way = way;
        mover.threshold = first_strip as f64;
        mover.roll_from = roll_from;
        let from = (self.stop_before_m(m, first_strip), 0.0, 0.0, 0.0);
        self.movers[m].line_up_s = self.driven_alone_s(m, from);
        Some(first_strip)
    }
}
