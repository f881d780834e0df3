//! Airports that nobody has drawn: made at random.

use models::draw::{DrawKey, Purpose, uniform};
use std::fmt::Write as _;

/// Draws of one airport, in a row.
pub(crate) struct Draws {
    pub(crate) seed: u64,
    pub(crate) counter: u64,
}

impl Draws {
    pub(crate) fn next(&mut self) -> f64 {
        self.counter += 1;
        let (run_seed, entity) = (self.seed, self.counter);
        uniform(&mut DrawKey { run_seed, sensor: 77, entity, scan: 0 }.rng(Purpose::Mover))
    }

    pub(crate) fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    pub(crate) fn chance(&mut self, share: f64) -> bool {
        self.next() < share
    }
}

/// An airport as a file: runway, taxiway with entries, an apron of lanes with stands, all of it turned.
#[derive(Default)]
pub(crate) struct Drawn {
    pub(crate) turned_rad: f64,
    pub(crate) nodes: Vec<(f64, f64)>,
    pub(crate) edges: String,
    pub(crate) stands: String,
    pub(crate) runways: String,
}

impl Drawn {
    /// Latitude and longitude of a place, m.
    pub(crate) fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let (s, c) = libm::sincos(self.turned_rad);
        let (e, n) = (x * c + y * s, y * c - x * s);
        (45.0 + n / 111_132.0, 10.0 + e / 78_847.0)
    }

    pub(crate) fn node(&mut self, x: f64, y: f64) -> usize {
        self.nodes.push((x, y));
        self.nodes.len() - 1
    }

    pub(crate) fn edge(&mut self, a: usize, b: usize, one_way: bool, name: &str) {
        let way = if one_way { "oneway" } else { "twoway" };
        writeln!(self.edges, "1202 {a} {b} {way} taxiway_E {name}").expect("text");
    }

    pub(crate) fn runway(&mut self, x0: f64, y0: f64, x1: f64, y1: f64, names: [&str; 2]) {
        let ((a, b), (c, d)) = (self.at(x0, y0), self.at(x1, y1));
        let [first, second] = names;
        writeln!(
            self.runways,
            "100 45.00 1 0 0.25 1 3 1 {first} {a:.8} {b:.8} 0.00 0.00 3 2 1 0 {second} {c:.8} {d:.8} 0.00 0.00 3 2 1 0"
        )
        .expect("text");
    }

    pub(crate) fn stand(&mut self, x: f64, y: f64, name: &str) {
        let (lat, lon) = self.at(x, y);
        let heading = self.turned_rad.to_degrees().rem_euclid(360.0);
        writeln!(self.stands, "1300 {lat:.8} {lon:.8} {heading:.2} gate jets|turboprops {name}")
            .expect("text");
    }

    /// Stands beside a lane along x that leads on from a node at a place, to a side of it (1: above, -1: below).
    #[allow(dead_code, reason = "not every test that draws has aprons")]
    pub(crate) fn apron(&mut self, from: usize, (x, y): (f64, f64), side: f64, count: usize) {
        let lane_y = y + 120.0 * side;
        let mut lane = self.node(x, lane_y);
        self.edge(from, lane, false, "C");
        for k in 0..count {
            let x = x + 60.0 * (k as f64 + 1.0);
            let next = self.node(x, lane_y);
            self.edge(lane, next, false, "L");
            lane = next;
            self.stand(x, lane_y + 95.0 * side, &format!("S{from}.{k}"));
        }
    }

    /// Two runways along x, 13L/31R `gap_m` beyond 13R/31L, ways over both at `places`, a taxiway beyond them and aprons, each beside one
    /// of the places with so many stands.
    #[allow(dead_code, reason = "not every test that draws has two runways")]
    pub(crate) fn parallel(gap_m: f64, places: [f64; 4], aprons: &[(usize, usize)]) -> Self {
        let mut a = Self { turned_rad: 0.7, ..Self::default() };
        a.runway(0.0, 0.0, 2600.0, 0.0, ["13R", "31L"]);
        a.runway(0.0, gap_m, 2600.0, gap_m, ["13L", "31R"]);
        let taxi_y = gap_m + 180.0;
        let mut tops: Vec<usize> = Vec::new();
        for (i, x) in places.into_iter().enumerate() {
            let top = a.node(x, taxi_y);
            if let Some(before) = tops.last() {
                a.edge(*before, top, false, "A");
            }
            tops.push(top);
            let mut from = top;
            for y in [gap_m + 100.0, gap_m, 0.5 * gap_m, 0.0] {
                let to = a.node(x, y);
                a.edge(from, to, false, &format!("E{i}"));
                from = to;
            }
        }
        for (at, count) in aprons {
            a.apron(tops[*at], (places[*at], taxi_y), 1.0, *count);
        }
        a
    }

    pub(crate) fn text(&self) -> String {
        let mut text = "I\n1000 Version - drawn at random\n\n1 30 0 0 XRND Random\n".to_owned();
        text += &self.runways;
        text += &self.stands;
        for (i, (x, y)) in self.nodes.iter().enumerate() {
            let (lat, lon) = self.at(*x, *y);
            writeln!(text, "1201 {lat:.8} {lon:.8} both {i} N{i}").expect("text");
        }
        text + &self.edges + "99\n"
    }
}

/// The airport of a seed, as text of an apt.dat file.
pub(crate) fn drawn(seed: u64) -> String {
    let mut d = Draws { seed, counter: 0 };
    let turned_rad = d.within(0.0, std::f64::consts::TAU);
    let mut a = Drawn { turned_rad, ..Drawn::default() };
    let degrees = turned_rad.to_degrees() + 90.0;
    let number = |deg: f64| ((deg / 10.0).round() as i64).rem_euclid(36);
    let name = |n: i64| format!("{:02}", if n == 0 { 36 } else { n });
    let (first, second) = (name(number(degrees)), name(number(degrees + 180.0)));
    // The runway lies along x, the taxiway above it.
    let length = d.within(1800.0, 3400.0);
    a.runway(0.0, 0.0, length, 0.0, [&first, &second]);
    let taxi_y = d.within(130.0, 200.0);
    let entries = 2 + (d.next() * 5.0) as usize;
    // Sometimes nothing leads to an end: a backtrack.
    let (low, high) = (
        if d.chance(0.3) { 0.15 * length } else { 10.0 },
        if d.chance(0.3) { 0.85 * length } else { length - 10.0 },
    );
    let mut places: Vec<f64> = (0..entries).map(|_| d.within(low, high)).collect();
    places.extend([low, high]);
    let links = 1 + (d.next() * 3.0) as usize;
    let mut feet: Vec<f64> = (0..links).map(|_| d.within(0.2 * length, 0.8 * length)).collect();
    feet.sort_by(f64::total_cmp);
    feet.dedup_by(|p, q| (*p - *q).abs() < 150.0);
    let mut along: Vec<(f64, bool)> = places.iter().map(|p| (*p, false)).collect();
    along.extend(feet.iter().map(|f| (*f, true)));
    along.sort_by(|p, q| p.0.total_cmp(&q.0));
    along.dedup_by(|p, q| !p.1 && (p.0 - q.0).abs() < 90.0);
    let mut taxi: Vec<(f64, usize)> = Vec::new();
    for (x, _) in &along {
        let node = a.node(*x, taxi_y);
        if let Some((_, before)) = taxi.last().copied() {
            a.edge(before, node, false, "A");
        }
        taxi.push((*x, node));
    }
    for (i, x) in places.iter().enumerate() {
        let Some((at, top)) = taxi.iter().copied().find(|t| (t.0 - x).abs() < 90.0) else {
            continue;
        };
        // Straight or at an angle.
        let slant = if d.chance(0.3) { d.within(-120.0, 120.0) } else { 0.0 };
        let foot = a.node((at + slant).clamp(0.0, length), 0.0);
        let half = a.node(at + 0.5 * slant, 0.55 * taxi_y);
        a.edge(top, half, false, &format!("E{i}"));
        a.edge(half, foot, false, &format!("E{i}"));
    }
    // The apron: a lane along the taxiway, stands beyond it.
    let lane_y = taxi_y + d.within(90.0, 160.0);
    let gap = d.within(52.0, 75.0);
    let count = 4 + (d.next() * 14.0) as usize;
    let reach = d.within(85.0, 110.0);
    let from = (feet[0] - 0.5 * gap * count as f64).max(0.0);
    let mut stops: Vec<(f64, Option<usize>)> = feet.iter().map(|f| (*f, None)).collect();
    stops.extend((0..count).map(|k| (from + gap * (k as f64 + 0.5), Some(k))));
    stops.sort_by(|p, q| p.0.total_cmp(&q.0));
    let one_way = feet.len() > 1 && d.chance(0.3);
    let mut before: Option<usize> = None;
    for (x, stand) in stops {
        let lane = a.node(x, lane_y);
        if let Some(before) = before {
            a.edge(before, lane, false, "L");
        }
        before = Some(lane);
        match stand {
            None => {
                let foot = taxi.iter().find(|t| t.0 == x).map_or(taxi[0].1, |t| t.1);
                a.edge(foot, lane, one_way && x == feet[0], "C");
            }
            Some(k) => {
                a.stand(x, lane_y + reach, &format!("S{k}"));
                if d.chance(0.7) {
                    writeln!(a.stands, "1301 C airline").expect("text");
                }
                // Some lead-ins are in the file, some are not.
                if d.chance(0.5) {
                    let end = a.node(x, lane_y + reach);
                    a.edge(lane, end, false, "");
                }
            }
        }
    }
    a.text()
}
