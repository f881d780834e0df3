//! Landings that would have to wait whatever follows: seen before the rest of the way is planned, and before others like it are laid.

use super::{Others, Timing};
use crate::traffic::core::Core;

/// A landing is not put off by so much, s, with a second of room: who waits less is left to [`Core::schedule`].
const LATE_S: f64 = 1.5;
/// Beyond what a way shares with another its stop may be nearer by so much, m: a guided point before its stand.
const ROOM_M: f64 = 100.0;

impl Core {
    /// Whether a landing at its time meets somebody on what is taken with it, however soon it goes on: with which arcs a way has
    /// to begin to meet him too.
    ///
    /// Times only rise while they are scheduled, so what is met by somebody who drives alone is met in any case.
    pub(in crate::traffic::core) fn late_with(
        &self,
        m: usize,
        t: &Timing,
        from_s: f64,
        others: &Others,
    ) -> Option<Vec<usize>> {
        let way = &self.movers[m].way;
        let last = *way.group_last.first()?;
        let fronts = t.pass_s.iter().scan(from_s, |front, pass| {
            *front += pass;
            Some(*front)
        });
        let front_s: Vec<f64> = fronts.collect();
        let mut met = Vec::new();
        for k in 0..=last.min(way.pieces.len() - 1) {
            let (told_by, until_s) = match t.release[k] {
                Some((at, back_s)) => (at, front_s[at] - back_s),
                None => (way.pieces.len() - 1, f64::INFINITY),
            };
            met.clear();
            self.against(others, m, way.pieces[k], &mut met);
            if met.iter().any(|(begin, end)| *begin < until_s && *end > from_s + LATE_S) {
                return Some(self.shared_to(m, way.ends_m[told_by]));
            }
        }
        None
    }

    /// Arcs of a mover's way that it has to share with another so that both are driven alike up to a place, m.
    ///
    /// As far beyond it as it takes to stop, nothing tells them apart there; and where the last of the arcs bends depends on the
    /// one behind it.
    fn shared_to(&self, m: usize, place_m: f64) -> Vec<usize> {
        let (way, d) = (&self.movers[m].way, &self.movers[m].driving);
        let alike_m = place_m + d.straight_mps * d.straight_mps / (1.4 * d.dec_mps2) + ROOM_M;
        let (mut pieces, mut count) = (0, 0);
        for arc in &way.arcs {
            pieces += self.pieces.of_edge[arc / 2].1;
            count += 1;
            if way.ends_m[pieces - 1] >= alike_m {
                break;
            }
        }
        way.arcs[..(count + 1).min(way.arcs.len())].to_vec()
    }
}
