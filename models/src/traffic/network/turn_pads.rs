//! R4b: where nobody comes onto a runway near one of its ends, one backtracks to it and turns on a pad.
//!
//! Files have no turn pads as ways, or loops that lead to the runway alone and say nothing of how one comes to them, so each is assumed: a loop at the end of the runway, and beside the centreline an edge
//! of its own from each of the nearest entries to it. A departure drives entry → edge → loop → centreline, a landing
//! centreline → loop → edge → exit. All of it belongs to the strip of the runway: who backtracks has the runway.

use super::{NetEdge, Network};
use crate::frames::Vector2;
use std::collections::BTreeSet;

/// A pad is made where the nearest entry is farther from an end than this share of the runway.
const FAR_SHARE: f64 = 0.12;
/// And so much farther than the loop, m, that a backtrack gains something.
const GAIN_M: f64 = 120.0;
/// Entries that are joined to a loop.
const ENTRIES: usize = 3;
/// What goes no farther from a runway than one holds before it, and this, is a loop to turn on, m (assumed).
const LOOP_M: f64 = 5.0;
/// From the end of the runway to the far side of the loop, m.
const SHORT_OF_END_M: f64 = 12.0;
/// From the begin of the straight to it to where it leaves the centreline, beyond a veer of 30 degrees, m.
const JOIN_M: f64 = 15.0;
/// Beside the centreline, m: a backtrack and a roll meet on no node.
const BESIDE_M: f64 = 2.0;

/// The loop that a runway of this width has room for, so that the nose wheel stays on it: its radius, m, and the largest code
/// letter (0: A) that turns on it with the nose wheel at no more than some 80 degrees (assumed; wide bodies want 58 m).
fn loop_of(width_m: f64) -> (f64, u8) {
    let margin_m = if width_m < 40.0 { 1.5 } else { 3.5 };
    let code = [22.0, 28.0, 40.0, 58.0].iter().position(|most| width_m < *most).unwrap_or(4) as u8;
    ((0.5 * width_m - margin_m).clamp(5.0, 30.0), code)
}

impl Network {
    pub(super) fn turn_pads(&mut self) {
        for r in 0..self.runways.len() {
            for end in 0..2 {
                self.turn_pad(r, end);
            }
        }
    }

    /// Whether a runway is left at a node of its centreline to somewhere else: not on to a loop beside it, as files draw a place to turn.
    fn leads_away(&self, r: usize, node: usize) -> bool {
        let runway = &self.runways[r];
        let off = |e: &&NetEdge| e.runway.is_none() && !e.backtrack;
        let (mut open, mut seen) = (vec![node], BTreeSet::from([node]));
        while let Some(at) = open.pop() {
            let away = self.nodes[at].stand.is_some()
                || runway.distance_m(self.nodes[at].at_m) > runway.hold_distance_m + LOOP_M;
            if away {
                return true;
            }
            for edge in self.edges.iter().filter(off).filter(|e| e.nodes.contains(&at)) {
                let next = edge.nodes[usize::from(edge.nodes[0] == at)];
                if self.nodes[next].runway != Some(r) && seen.insert(next) {
                    open.push(next);
                }
            }
        }
        false
    }

    fn turn_pad(&mut self, r: usize, end: usize) {
        let runway = self.runways[r].clone();
        let from_end = |place: f64| if end == 0 { place } else { runway.length_m - place };
        let doors = runway.spine.iter().map(|(place, node)| (from_end(*place), *node));
        let mut doors: Vec<(f64, usize)> = doors.filter(|d| self.leads_away(r, d.1)).collect();
        doors.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (radius_m, code) = loop_of(runway.width_m);
        // Along the runway from its end: far side of the loop, where the half circle begins, where the ways to and from it begin.
        let straight_m = SHORT_OF_END_M + 2.0 * radius_m;
        let begin_m = straight_m + (radius_m - BESIDE_M) * 3.0_f64.sqrt() + JOIN_M;
        let Some(nearest_m) = doors.first().map(|d| d.0) else { return };
        if nearest_m < (FAR_SHARE * runway.length_m).max(begin_m + GAIN_M) {
            return;
        }
        let right = {
            let along = (runway.ends_m[1 - end] - runway.ends_m[end]) / runway.length_m;
            Vector2::new(along.y, -along.x)
        };
        let place_of = |from_end_m: f64| {
            if end == 0 { from_end_m } else { runway.length_m - from_end_m }
        };
        let at = |from_end_m: f64, right_m: f64| runway.at(place_of(from_end_m)) + right * right_m;
        let designator = &runway.names[end];
        // The roll begins on the centreline.
        let Some(edge) = runway.spine.windows(2).find_map(|pair| {
            let within = (pair[0].0..pair[1].0).contains(&place_of(begin_m));
            let joins = |e: &NetEdge| e.nodes.contains(&pair[0].1) && e.nodes.contains(&pair[1].1);
            within.then(|| self.edges.iter().position(joins)).flatten()
        }) else {
            return;
        };
        let first_m = self.nodes[self.edges[edge].nodes[0]].at_m;
        let cut_m = (at(begin_m, 0.0) - first_m).norm();
        let roll = self.cut(edge, cut_m, format!("pad_{designator}"));
        self.nodes[roll].runway = Some(r);
        self.runways[r].turn_pads[end] = true;
        let spine = &mut self.runways[r].spine;
        spine.push((place_of(begin_m), roll));
        spine.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let corners = [
            (begin_m, BESIDE_M),
            (straight_m, radius_m),
            (SHORT_OF_END_M, radius_m),
            (SHORT_OF_END_M, -radius_m),
            (straight_m, -radius_m),
        ];
        let mut nodes = Vec::new();
        for (k, (from_end_m, right_m)) in corners.into_iter().enumerate() {
            let name = format!("pad_{designator}_{}", k + 1);
            nodes.push(self.add_node(name, at(from_end_m, right_m)));
        }
        let begin = nodes[0];
        nodes.push(roll);
        let loops = nodes.windows(2).map(|pair| [pair[0], pair[1]]);
        let to_it = doors.iter().take(ENTRIES).map(|d| [d.1, begin]);
        for nodes in loops.chain(to_it).collect::<Vec<_>>() {
            self.edges.push(NetEdge {
                nodes,
                two_way: true,
                runway: None,
                strip: Some(r),
                backtrack: true,
                name: runway.names.join("/"),
                code,
                origin: None,
            });
        }
        let letter = char::from(b'A' + code);
        self.report.push(format!(
            "R4: runway end {designator}: the nearest entry is {nearest_m:.0} m away: backtrack to a turn pad of {radius_m:.0} m there (assumed), up to code {letter}"
        ));
    }
}
