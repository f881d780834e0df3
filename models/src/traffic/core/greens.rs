//! Follow the greens: lamps of the taxiways show each flight the way that it holds, as a view of the tokens.
//!
//! Lamps are switched by segments: pieces of one edge in a row, off the runways. Lit are those from one behind the nose to the
//! authority, at most [`AHEAD_M`] and [`AHEAD`] segments ahead; where the last one ends a bar is lit across the taxiway. Segments of
//! two flights never touch: of two that would, the one that is nearer to its flight stays.

use super::{Core, Mover, Phase};
use crate::draw::{DrawKey, Purpose, uniform};
use crate::frames::Point2;
use crate::traffic::network::Network;
use crate::traffic::pieces::Pieces;

/// Least length of a segment where its edge is that long, m (assumed).
const LEAST_M: f64 = 60.0;
/// Greens lead so far ahead of the nose at most, m, and so many segments (assumed).
const AHEAD_M: f64 = 200.0;
const AHEAD: usize = 4;
/// Who is led drives so much faster, up to what his type does (assumed).
const FASTER: f64 = 1.08;
/// From a switch to its light, s (assumed).
pub const LAMP_DELAY_S: f64 = 0.3;
/// Share of segments whose lamps are dark in a run, times `[control] errors` (assumed).
const DARK: f64 = 1e-3;

/// Lamps that are switched together.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Both ends on the centreline of the taxiway, m.
    pub ends_m: [Point2<f64>; 2],
    /// It stays dark, whatever it is told.
    pub dark: bool,
}

/// The lamps of an airport's taxiways.
#[derive(Clone, Debug, PartialEq)]
pub struct Lamps {
    segments: Vec<Segment>,
    /// By piece: its segment.
    of_piece: Vec<Option<u32>>,
    /// By segment: those that share an end with it.
    touching: Vec<Vec<u32>>,
}

/// What is lit for a flight.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// Flight, by index.
    pub flight: usize,
    /// Segments from the one behind its nose on, in the order in which it passes them.
    pub segments: Vec<u32>,
    /// Where the last one ends: a bar is lit there, m.
    pub bar_m: Point2<f64>,
}

/// What a flight may be shown: the segment behind the one under its nose, and those from that on, each with the place of its end on
/// the way, m.
#[derive(Clone, Debug)]
struct Led {
    behind: Option<u32>,
    on: Vec<(u32, f64)>,
    behind_lit: bool,
}

/// The turn of what is behind.
const BEHIND: usize = usize::MAX;

impl Lamps {
    /// The lamps of a network; `errors`: times `DARK` of them fail.
    #[must_use]
    pub fn of(net: &Network, pieces: &Pieces, seed: u64, errors: f64) -> Self {
        let mut lamps = Self {
            segments: Vec::new(),
            of_piece: vec![None; pieces.list.len()],
            touching: Vec::new(),
        };
        let mut at_node: Vec<Vec<u32>> = vec![Vec::new(); net.nodes.len()];
        for (e, edge) in net.edges.iter().enumerate().filter(|(_, edge)| edge.runway.is_none()) {
            let (first, count) = pieces.of_edge[e];
            let Some(last) = count.checked_sub(1) else { continue };
            let [a, b] = edge.nodes.map(|n| net.nodes[n].at_m);
            let length_m = (b - a).norm().max(1e-9);
            let at = |place_m: f64| a + (b - a) * (place_m / length_m);
            let own = lamps.segments.len();
            let mut from = first;
            for z in first..=first + last {
                let (begin_m, end_m) = (pieces.list[from].from_m, pieces.list[z].to_m);
                let left_m = length_m - end_m;
                if z < first + last && (end_m - begin_m < LEAST_M || left_m < LEAST_M) {
                    continue;
                }
                let number = lamps.segments.len() as u32;
                let key = DrawKey { run_seed: seed, sensor: 4, entity: u64::from(number), scan: 0 };
                let dark = uniform(&mut key.rng(Purpose::Mover)) < DARK * errors;
                lamps.segments.push(Segment { ends_m: [at(begin_m), at(end_m)], dark });
                lamps.of_piece[from..=z].fill(Some(number));
                let before = (number as usize).checked_sub(1).filter(|n| *n >= own);
                lamps.touching.push(before.map(|n| n as u32).into_iter().collect());
                if let Some(before) = before {
                    lamps.touching[before].push(number);
                }
                from = z + 1;
            }
            at_node[edge.nodes[0]].push(own as u32);
            at_node[edge.nodes[1]].push(lamps.segments.len() as u32 - 1);
        }
        for meeting in at_node {
            for s in &meeting {
                let others = meeting.iter().filter(|o| *o != s);
                lamps.touching[*s as usize].extend(others);
            }
        }
        for (s, touching) in lamps.touching.iter_mut().enumerate() {
            touching.sort_unstable();
            touching.dedup();
            touching.retain(|o| *o as usize != s);
        }
        lamps
    }

    /// All segments, by number.
    #[must_use]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Whether two segments are one or share an end.
    #[must_use]
    pub fn touch(&self, a: u32, b: u32) -> bool {
        a == b || self.touching[a as usize].binary_search(&b).is_ok()
    }
}

impl Core {
    /// The same core with lamps that lead, before its first step.
    #[must_use]
    pub fn with_greens(mut self, seed: u64, errors: f64) -> Self {
        self.lamps = Some(Lamps::of(&self.net, &self.pieces, seed, errors));
        for m in 0..self.movers.len() {
            self.led(m);
        }
        self
    }

    /// The lamps of the taxiways, where they lead.
    #[must_use]
    pub fn lamps(&self) -> Option<&Lamps> {
        self.lamps.as_ref()
    }

    /// A flight drives as who is led by greens, where there are any.
    pub(super) fn led(&mut self, m: usize) {
        if self.lamps.is_some() && !self.is_vehicle(m) {
            let most_mps = self.flights[m].taxi_mps.0;
            let driving = &mut self.movers[m].driving;
            driving.straight_mps = (FASTER * driving.straight_mps).min(most_mps);
        }
    }

    /// What is to be lit now, by flight; lamps show it [`LAMP_DELAY_S`] later.
    #[must_use]
    pub fn greens(&self) -> Vec<Shown> {
        let Some(lamps) = &self.lamps else { return Vec::new() };
        // By flight: the segment behind the one under its nose, if any, and those from that on.
        let mut ways: Vec<(usize, Led)> = Vec::new();
        // What is under a nose before what is ahead, the nearer before the farther, and what is behind last.
        let mut wanted: Vec<(usize, usize, u32)> = Vec::new();
        for m in 0..self.movers.len() {
            let Some(led) = self.led_along(m, lamps) else { continue };
            wanted.extend(led.on.iter().enumerate().map(|(k, s)| (k, ways.len(), s.0)));
            wanted.extend(led.behind.map(|s| (BEHIND, ways.len(), s)));
            ways.push((m, led));
        }
        wanted.sort_unstable();
        let mut lit = vec![0; ways.len()];
        let mut taken: Vec<Option<usize>> = vec![None; lamps.segments.len()];
        for (k, way, segment) in wanted {
            let others = |s: u32| taken[s as usize].is_some_and(|w| w != way);
            let touching = &lamps.touching[segment as usize];
            let free = !others(segment) && !touching.iter().any(|s| others(*s));
            // Where one is refused what lies beyond it is dark, too.
            let next = if k == BEHIND { lit[way] > 0 } else { lit[way] == k };
            if !(free && next) {
                continue;
            }
            taken[segment as usize] = Some(way);
            match k {
                BEHIND => ways[way].1.behind_lit = true,
                _ => lit[way] = k + 1,
            }
        }
        let shown = ways.iter().zip(lit).filter(|(_, lit)| *lit > 0);
        let shown = shown.map(|((m, led), lit)| Shown {
            flight: *m,
            segments: led
                .behind
                .filter(|_| led.behind_lit)
                .into_iter()
                .chain(led.on[..lit].iter().map(|s| s.0))
                .collect(),
            bar_m: self.movers[*m].way.path.at(led.on[lit - 1].1).at_m,
        });
        shown.collect()
    }

    /// What a flight may be shown; `None`: nothing.
    fn led_along(&self, m: usize, lamps: &Lamps) -> Option<Led> {
        let Mover { way, s, first_held, next, phase, hand, .. } = &self.movers[m];
        if *phase != Phase::Taxiing || hand.is_some() || self.is_vehicle(m) {
            return None;
        }
        let nose_m = s + self.reach_m(m).0;
        let last = (*next).min(way.pieces.len());
        let of = |k: usize| lamps.of_piece[way.pieces[k] as usize];
        let at = (*first_held..last).find(|k| way.ends_m[*k] >= nose_m)?;
        let mut from = at;
        while from > *first_held && of(from - 1) == of(at) {
            from -= 1;
        }
        let behind = from.checked_sub(1).filter(|k| k >= first_held).and_then(of);
        let mut on: Vec<(u32, f64)> = Vec::new();
        let mut k = from;
        while k < last && on.len() <= AHEAD {
            let mut end = k;
            while end + 1 < way.pieces.len() && of(end + 1) == of(k) {
                end += 1;
            }
            // Ahead only what is held to its end: no green leads farther than the authority.
            let within = end < last && way.ends_m[end] - nose_m <= AHEAD_M;
            if k > at && !within {
                break;
            }
            // Over a runway there are none, and they go on behind it.
            on.extend(of(k).map(|segment| (segment, way.ends_m[end.min(last - 1)])));
            k = end + 1;
        }
        (!on.is_empty()).then_some(Led { behind, on, behind_lit: false })
    }
}
