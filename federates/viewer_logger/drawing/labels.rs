//! Labels: the same words as the page's, each beside its target, none over another, none on a runway, no crossing leaders.
//!
//! The places are found by the page's candidates and costs, for a picture without a picture before it.

use super::{Anchor, Pen, Shown, airport::ring, corners, font, targets};
use crate::runtime::messages::TrackMessage;
use models::track::TrackStatus;

const KNOT: f64 = 1.943_844;
const FOOT: f64 = 3.280_84;
/// Higher targets are in the air, m.
const AIRBORNE_M: f64 = 15.0;
/// Shorter leaders are not drawn.
const SHORT_LEADER: f64 = 14.0;
/// Rings of candidates: radius and directions.
const RINGS: [(f64, usize); 5] = [(13.0, 8), (30.0, 16), (56.0, 16), (90.0, 16), (135.0, 16)];
const GAP: f64 = 2.0;
/// What covering another's symbol, and one's own, costs.
const FOREIGN: f64 = 14.0;
const OWN: f64 = 40.0;

/// Lines of a label: name; type, speed, height; runway and stand.
#[must_use]
pub fn lines(track: &TrackMessage) -> Vec<String> {
    let assumed = track.callsign.is_empty() && !track.assumed.is_empty();
    let name = if assumed { &track.assumed } else { &track.callsign };
    let name = match name.is_empty() {
        true => format!("#{}", track.number),
        false => cut(name),
    };
    let mps = libm::hypot(track.velocity_mps[0], track.velocity_mps[1]);
    let speed = if mps < targets::STILL_MPS { 0.0 } else { (mps * KNOT).round() };
    let kind = match track.wake {
        None => track.type_designator.clone(),
        Some(wake) => format!("{}/{}", track.type_designator, wake.word()),
    };
    let height = track.altitude_m.filter(|h| *h > AIRBORNE_M);
    let height =
        height.map_or(String::new(), |h| format!("{} ft", (h * FOOT / 10.0).round() * 10.0));
    let speed = if speed.is_finite() { format!("{speed} kt") } else { String::new() };
    let second: Vec<String> = [kind, speed, height].into_iter().filter(|s| !s.is_empty()).collect();
    let name = name + if assumed { "?" } else { "" };
    [name, second.join("  "), cut(&track.runway_stand.replace('_', " "))]
        .into_iter()
        .filter(|s| !s.is_empty())
        .collect()
}

fn cut(text: &str) -> String {
    if text.chars().count() <= 24 {
        return text.to_owned();
    }
    text.chars().take(23).chain(['\u{2026}']).collect()
}

/// A label that wants a place.
struct Wanted<'a> {
    track: &'a TrackMessage,
    at: [f64; 2],
    lines: Vec<String>,
    importance: f64,
}

/// A label in its place: x, y, width, height, and where its leader ends.
#[derive(Clone, Copy)]
struct Placed {
    of: usize,
    level: usize,
    area: [f64; 4],
    end: [f64; 2],
}

pub(super) fn draw(pen: &mut Pen<'_>, shown: &Shown<'_>) {
    if !pen.on("labels") || !pen.on("tracks") {
        return;
    }
    let runways: Vec<Vec<[f64; 2]>> = shown
        .map
        .runways
        .iter()
        .map(|r| ring(r, 10.0).into_iter().map(|p| pen.at(p)).collect())
        .collect();
    let mut wanted: Vec<Wanted<'_>> = Vec::new();
    for track in shown.scan.tracks.iter().filter(|t| targets::sound(t.position_m.into())) {
        let at = pen.at(track.position_m.into());
        if !pen.inside(at, 0.0) {
            continue;
        }
        let on = runways.iter().any(|r| holds(r, at));
        let speed = libm::hypot(track.velocity_mps[0], track.velocity_mps[1]);
        let rank = match () {
            () if targets::is_selected(pen, track) => 900.0,
            () if track.altitude_m.is_some_and(|h| h > AIRBORNE_M) => 600.0,
            () if on => 700.0,
            () if speed >= targets::STILL_MPS => 400.0,
            () => 200.0,
        };
        let importance = rank + speed.min(90.0) / 100.0;
        wanted.push(Wanted { track, at, lines: lines(track), importance });
    }
    wanted.sort_by(|a, b| {
        b.importance.total_cmp(&a.importance).then(a.track.number.cmp(&b.track.number))
    });
    let mut placed: Vec<Placed> = Vec::new();
    for of in 0..wanted.len() {
        let found = (1..=wanted[of].lines.len())
            .rev()
            .find_map(|level| cheapest(of, level, &wanted, &placed, &runways, pen));
        match found {
            Some(label) => placed.push(label),
            None => pen.drawing.unlabelled += 1,
        }
    }
    for label in &placed {
        paint(pen, &wanted[label.of], label);
    }
}

fn paint(pen: &mut Pen<'_>, wanted: &Wanted<'_>, label: &Placed) {
    let ([x, y, w, h], name) = (label.area, targets::colour_of(wanted.track));
    let (dx, dy) = (label.end[0] - wanted.at[0], label.end[1] - wanted.at[1]);
    let length = libm::hypot(dx, dy);
    if length >= SHORT_LEADER {
        let from = [wanted.at[0] + dx / length * 8.0, wanted.at[1] + dy / length * 8.0];
        let colour = pen.colour(name).faded(0.6);
        pen.line(vec![from, label.end], colour, 1.0);
    }
    pen.area(vec![corners(x, y, w, h)], "label-back", 1.0);
    for (i, line) in wanted.lines.iter().take(label.level).enumerate() {
        let at = [x + 5.0, y + 14.0 + 13.0 * i as f64];
        match i {
            0 => pen.text(at, line, 12.0, true, name, Anchor::Start),
            _ => pen.text(at, line, 11.0, false, "text", Anchor::Start),
        }
    }
    let frame = corners(x + 0.5, y + 0.5, w - 1.0, h - 1.0);
    if targets::is_selected(pen, wanted.track) {
        let colour = pen.colour("select");
        pen.dashed(frame, true, colour, 1.0, &[]);
    } else if wanted.track.status == TrackStatus::Coasting {
        let colour = pen.colour("dim");
        pen.dashed(frame, true, colour, 1.0, &[3.0, 2.0]);
    }
    let shown = wanted.lines[..label.level].to_vec();
    if let Some(mark) = pen.drawing.marks.iter_mut().find(|m| m.number == wanted.track.number) {
        mark.label = shown;
    }
}

fn cheapest(
    of: usize,
    level: usize,
    wanted: &[Wanted<'_>],
    placed: &[Placed],
    runways: &[Vec<[f64; 2]>],
    pen: &Pen<'_>,
) -> Option<Placed> {
    let (item, [width, height]) = (&wanted[of], pen.view.camera.size);
    let texts = item.lines.iter().take(level).enumerate();
    let widest = texts
        .map(|(i, line)| font::width(line, if i == 0 { 12.0 } else { 11.0 }, i == 0))
        .fold(0.0, f64::max);
    let (w, h) = (widest.ceil() + 10.0, 19.0 + 13.0 * (level as f64 - 1.0));
    let mut best: Option<(f64, Placed)> = None;
    for (radius, directions) in RINGS {
        for k in 0..directions {
            let angle = (k as f64 + 0.5) / directions as f64 * std::f64::consts::TAU;
            let (ux, uy) = (libm::cos(angle), libm::sin(angle));
            let x = (item.at[0] + ux * (radius + w / 2.0) - w / 2.0).round();
            let y = (item.at[1] + uy * (radius + h / 2.0) - h / 2.0).round();
            let outside = x < 2.0 || y < 2.0 || x + w > width - 2.0 || y + h > height - 2.0;
            let area = [x, y, w, h];
            if outside || placed.iter().any(|p| overlap(p.area, area, GAP)) {
                continue;
            }
            if runways.iter().any(|r| covers(r, area)) {
                continue;
            }
            let end = [item.at[0].clamp(x, x + w), item.at[1].clamp(y, y + h)];
            let crosses = |p: &Placed| {
                let other = [wanted[p.of].at, p.end];
                meet([item.at, end], other) || cuts([item.at, end], p.area) || cuts(other, area)
            };
            if placed.iter().any(crosses) {
                continue;
            }
            let mut cost = (radius - 13.0) / 4.0;
            cost += if ux < 0.0 { 1.5 } else { 0.0 } + if uy > 0.0 { 1.0 } else { 0.0 };
            for (other, o) in wanted.iter().enumerate() {
                let near = [o.at[0].clamp(x, x + w), o.at[1].clamp(y, y + h)];
                if libm::hypot(o.at[0] - near[0], o.at[1] - near[1]) < 7.0 {
                    cost += if other == of { OWN } else { FOREIGN };
                }
            }
            if best.as_ref().is_none_or(|b| cost < b.0) {
                best = Some((cost, Placed { of, level, area, end }));
            }
        }
    }
    best.map(|b| b.1)
}

fn overlap(a: [f64; 4], b: [f64; 4], gap: f64) -> bool {
    let apart = |k: usize| a[k] >= b[k] + b[k + 2] + gap || b[k] >= a[k] + a[k + 2] + gap;
    !apart(0) && !apart(1)
}

/// Whether a point is inside a convex ring.
fn holds(ring: &[[f64; 2]], p: [f64; 2]) -> bool {
    let side = |i: usize| {
        let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
    };
    let sides: Vec<f64> = (0..ring.len()).map(side).collect();
    sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
}

/// Whether a convex ring and a box touch: by the lines that could part them (separating axes).
fn covers(ring: &[[f64; 2]], [x, y, w, h]: [f64; 4]) -> bool {
    let area = corners(x, y, w, h);
    let parted = |axis: [f64; 2]| {
        let span = |points: &[[f64; 2]]| {
            points
                .iter()
                .map(|p| p[0] * axis[0] + p[1] * axis[1])
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                    (low.min(v), high.max(v))
                })
        };
        let ((a0, a1), (b0, b1)) = (span(ring), span(&area));
        a1 < b0 || b1 < a0
    };
    let normal = |i: usize| {
        let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
        [a[1] - b[1], b[0] - a[0]]
    };
    !([[1.0, 0.0], [0.0, 1.0]].into_iter().any(parted) || (0..ring.len()).map(normal).any(parted))
}

/// Whether two lines cross.
fn meet([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let side = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

/// Whether a line passes through a box (Liang and Barsky).
fn cuts([a, b]: [[f64; 2]; 2], [x, y, w, h]: [f64; 4]) -> bool {
    let (dx, dy, mut from, mut to) = (b[0] - a[0], b[1] - a[1], 0.0_f64, 1.0_f64);
    for (p, q) in [(-dx, a[0] - x), (dx, x + w - a[0]), (-dy, a[1] - y), (dy, y + h - a[1])] {
        if p == 0.0 {
            if q < 0.0 {
                return false;
            }
        } else if p < 0.0 {
            from = from.max(q / p);
        } else {
            to = to.min(q / p);
        }
    }
    from <= to
}
