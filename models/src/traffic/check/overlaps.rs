//! Who overlaps whom.

use super::super::outline::{Rectangle, outline, overlap_depth_m};
use super::{Breaches, Row, Rules, Seen, Who};
use crate::frames::Point2;
use std::collections::BTreeSet;

/// Pairs that overlapped, each told once.
#[derive(Clone, Debug, Default)]
pub(super) struct Overlaps {
    found: Breaches,
    pairs: BTreeSet<(usize, usize)>,
}

fn middle_m(s: &Seen) -> Point2<f64> {
    Point2::new(s.position_m.x, s.position_m.y)
}

fn reach_m(who: &Who) -> f64 {
    0.5 * who.size.length_m.max(who.size.span_m)
}

impl Overlaps {
    pub(super) fn look(&mut self, who: &[Who], rules: &Rules, time_s: f64, ground: &[Seen]) {
        let mut order: Vec<&Seen> = ground.iter().collect();
        order.sort_by(|a, b| a.position_m.x.total_cmp(&b.position_m.x).then(a.who.cmp(&b.who)));
        let most_m = ground.iter().map(|s| reach_m(&who[s.who])).fold(0.0, f64::max);
        for (i, a) in order.iter().enumerate() {
            for b in &order[i + 1..] {
                let reach = reach_m(&who[a.who]);
                if b.position_m.x - a.position_m.x > reach + most_m {
                    break;
                }
                let apart = middle_m(a) - middle_m(b);
                if apart.norm() > 1.42 * (reach + reach_m(&who[b.who])) {
                    continue;
                }
                self.found.of += 1;
                let shape = |s: &Seen| outline(who[s.who].size, middle_m(s), s.heading_rad);
                let depth_m = depth_m(&shape(a), &shape(b));
                let pair = (a.who.min(b.who), a.who.max(b.who));
                if depth_m > rules.overlap_m && self.pairs.insert(pair) {
                    self.found.add(|| {
                        format!(
                            "{} and {} by {depth_m:.1} m at {time_s:.1} s, at {:.0} {:.0}",
                            who[pair.0].callsign,
                            who[pair.1].callsign,
                            a.position_m.x,
                            a.position_m.y
                        )
                    });
                }
            }
        }
    }

    pub(super) fn row(self) -> Row {
        self.found.row("overlaps")
    }
}

/// Depth of the deepest overlap of two outlines, m; negative where they are apart.
fn depth_m(a: &[Rectangle; 2], b: &[Rectangle; 2]) -> f64 {
    let pairs = a.iter().flat_map(|x| b.iter().map(move |y| (x, y)));
    pairs
        .map(|(x, y)| overlap_depth_m(&x.corners_m, &y.corners_m))
        .fold(f64::NEG_INFINITY, f64::max)
}
