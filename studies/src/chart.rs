//! Error against cost as a picture: logarithmic axes, the Pareto front, bounds as lines.

use crate::{Bound, Ladder, Row};
use std::fmt::Write;

/// Share of the error that a rung has to take off to stand on the drawn front.
pub(crate) const LEAST_GAIN: f64 = 0.005;

/// Which rows no other row beats in both error and cost, cheapest first. A rung that needs more than the
/// plots so far or lost tracks is not compared, and a gain of less than `least` (a share) is none.
pub(crate) fn pareto<'a>(ladder: &Ladder, rows: &[&'a Row], least: f64) -> Vec<&'a Row> {
    let point = |r: &Row| Some((ladder.cost(r)?, ladder.error(r)?));
    let sound = |r: &&Row| {
        point(r).is_some()
            && r.failed.is_empty()
            && r.needs.is_none()
            && r.lost_pct.is_none_or(|l| l == 0.0)
    };
    let mut sorted: Vec<&Row> = rows.iter().copied().filter(sound).collect();
    sorted.sort_by(|a, b| {
        let (a, b) = (point(a).unwrap_or_default(), point(b).unwrap_or_default());
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut best = f64::INFINITY;
    sorted.retain(|r| {
        let error = ladder.error(r).unwrap_or(f64::INFINITY);
        let front = error < (1.0 - least) * best;
        best = if front { error } else { best };
        front
    });
    sorted
}

pub(crate) fn times(factor: f64) -> String {
    if factor < 10.0 { format!("{factor:.1} times") } else { format!("{factor:.0} times") }
}

pub(crate) fn duration(ns: f64) -> String {
    if ns < 10.0 {
        format!("{ns:.1} ns")
    } else if ns < 1e3 {
        format!("{ns:.0} ns")
    } else if ns < 1e6 {
        format!("{:.1} µs", ns / 1e3)
    } else {
        format!("{:.1} ms", ns / 1e6)
    }
}

/// A logarithmic axis.
#[derive(Clone, Copy)]
struct Axis {
    low: f64,
    high: f64,
    /// Pixel of `low` and of `high`.
    pixels: (f64, f64),
}

impl Axis {
    /// Room for all values, a little more on both ends.
    fn around(values: impl Iterator<Item = f64>, pixels: (f64, f64), margin: f64) -> Option<Self> {
        let (low, high) = values
            .filter(|v| *v > 0.0 && v.is_finite())
            .fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
        (high > 0.0).then(|| Self { low: low / margin, high: high * margin, pixels })
    }
    fn at(&self, value: f64) -> f64 {
        let share = libm::log(value / self.low) / libm::log(self.high / self.low);
        self.pixels.0 + share * (self.pixels.1 - self.pixels.0)
    }
    /// 1, 2, 5, 10, … within the range; every tenth part of small ranges.
    fn ticks(&self) -> Vec<f64> {
        let steps: &[f64] = if self.high / self.low > 300.0 {
            &[1.0]
        } else if self.high / self.low > 8.0 {
            &[1.0, 2.0, 5.0]
        } else {
            &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0]
        };
        let mut ticks = Vec::new();
        for decade in -12..=15 {
            for step in steps {
                let value = step * libm::pow(10.0, f64::from(decade));
                if value >= self.low && value <= self.high {
                    ticks.push(value);
                }
            }
        }
        ticks
    }
}

const WIDTH: f64 = 620.0;
const HEIGHT: f64 = 420.0;
const LEFT: f64 = 52.0;
const RIGHT: f64 = 600.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 372.0;

/// Error against cost of one scene.
pub(crate) fn chart(ladder: &Ladder, rows: &[&Row], bounds: &[&Bound]) -> String {
    let mut points: Vec<(&Row, f64, f64)> = rows
        .iter()
        .filter_map(|r| Some((*r, ladder.cost(r)?, ladder.error(r)?)))
        .filter(|(_, x, y)| *x > 0.0 && *y >= 0.0)
        .collect();
    // No logarithm of nothing: errors of zero stand at the bottom, on a line of their own.
    let least = points.iter().map(|p| p.2).filter(|e| *e > 0.0).fold(f64::INFINITY, f64::min);
    let nothing = if least.is_finite() { least / 4.0 } else { 1e-3 };
    let zeros = points.iter().any(|p| p.2 == 0.0);
    points.iter_mut().filter(|p| p.2 == 0.0).for_each(|p| p.2 = nothing);
    let xs = Axis::around(points.iter().map(|p| p.1), (LEFT, RIGHT), 2.2);
    let errors = points.iter().map(|p| p.2).chain(bounds.iter().map(|b| b.error));
    let (Some(x), Some(y)) = (xs, Axis::around(errors, (BOTTOM, TOP), 1.12)) else {
        return "<p>Nothing to draw: no rung has both an error and a cost.</p>".to_owned();
    };
    let mut svg = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"error against time\">"
    );
    for tick in x.ticks() {
        let at = x.at(tick);
        let _ = write!(
            svg,
            "<line class=\"grid\" x1=\"{at:.1}\" y1=\"{TOP}\" x2=\"{at:.1}\" y2=\"{BOTTOM}\"/>\
             <text class=\"tick\" x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            BOTTOM + 16.0,
            if ladder.cost_label.is_some() {
                short(tick)
            } else {
                duration(tick).replace(".0 ", " ")
            },
        );
    }
    if zeros {
        let at = y.at(nothing);
        let _ = write!(
            svg,
            "<line class=\"zero\" x1=\"{LEFT}\" y1=\"{at:.1}\" x2=\"{RIGHT}\" y2=\"{at:.1}\"/>\
             <text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">0</text>",
            LEFT - 6.0,
            at + 4.0,
        );
    }
    for tick in y.ticks().into_iter().filter(|t| !zeros || *t > 2.0 * nothing) {
        let at = y.at(tick);
        let _ = write!(
            svg,
            "<line class=\"grid\" x1=\"{LEFT}\" y1=\"{at:.1}\" x2=\"{RIGHT}\" y2=\"{at:.1}\"/>\
             <text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            LEFT - 6.0,
            at + 4.0,
            short(tick),
        );
    }
    let _ = write!(
        svg,
        "<text class=\"label\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{} (log)</text>\
         <text class=\"label\" transform=\"translate(13 {:.1}) rotate(-90)\" text-anchor=\"middle\">{} (log)</text>",
        0.5 * (LEFT + RIGHT),
        HEIGHT - 12.0,
        escaped(ladder.cost_label.as_deref().unwrap_or("time per update")),
        0.5 * (TOP + BOTTOM),
        escaped(&ladder.error_label),
    );
    let mut taken: Vec<[f64; 4]> = points
        .iter()
        .map(|(_, px, py)| {
            let (cx, cy) = (x.at(*px), y.at(*py));
            [cx - 6.0, cy - 6.0, cx + 6.0, cy + 6.0]
        })
        .collect();
    bound_lines(&mut svg, bounds, y, &mut taken);
    let front = pareto(ladder, rows, LEAST_GAIN);
    let mut path = String::new();
    for (number, row) in front.iter().enumerate() {
        let Some((_, px, py)) = points.iter().find(|p| std::ptr::eq(p.0, *row)) else { continue };
        let (cx, cy) = (x.at(*px), y.at(*py));
        let _ = if number == 0 {
            write!(path, "M{cx:.1} {TOP}V{cy:.1}")
        } else {
            write!(path, "H{cx:.1}V{cy:.1}")
        };
    }
    if !path.is_empty() {
        let _ = write!(svg, "<path class=\"front\" d=\"{path}H{RIGHT}\"/>");
    }
    for (row, px, py) in &points {
        let (cx, cy) = (x.at(*px), y.at(*py));
        let on_front = front.iter().any(|f| std::ptr::eq(*f, *row));
        let failed = !row.failed.is_empty() || row.lost_pct.is_some_and(|l| l > 0.0);
        let class = match (failed, on_front) {
            (true, _) => "failed",
            (false, true) => "best",
            (false, false) => "other",
        };
        let cost = match &ladder.cost_label {
            Some(label) => format!("{px:.3} {}", escaped(label)),
            None => duration(*px),
        };
        let error = ladder.error(row).unwrap_or(0.0);
        let title = format!("{}: {cost}; {error:.3}", escaped(&row.rung));
        let _ = if row.needs.is_some() {
            write!(
                svg,
                "<path class=\"{class}\" d=\"M{cx:.1} {:.1}l6 6-6 6-6-6z\"><title>{title}</title></path>",
                cy - 6.0,
            )
        } else {
            write!(
                svg,
                "<circle class=\"{class}\" cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"5\"><title>{title}</title></circle>",
            )
        };
        let (lx, ly, anchor) = place(&mut taken, cx, cy, row.rung.chars().count() as f64 * 7.4);
        let weight = if on_front { " strong" } else { "" };
        let _ = write!(
            svg,
            "<text class=\"name{weight}\" x=\"{lx:.1}\" y=\"{ly:.1}\" text-anchor=\"{anchor}\">{}</text>",
            escaped(&row.rung),
        );
    }
    svg.push_str("</svg>");
    svg
}

/// Dashed lines with their labels, each label above or below its line where there is room.
fn bound_lines(svg: &mut String, bounds: &[&Bound], y: Axis, taken: &mut Vec<[f64; 4]>) {
    for bound in bounds {
        let at = y.at(bound.error);
        let raw = !bound.label.starts_with("bound");
        let class = if raw { "raw" } else { "bound" };
        let text = match bound.mse_reduction_pct {
            Some(pct) if !raw => format!("{} (−{pct:.0} % MSE)", bound.label),
            _ => bound.label.clone(),
        };
        let width = text.chars().count() as f64 * 5.6;
        let spots = [LEFT + 6.0, RIGHT - width - 4.0, 0.5 * (LEFT + RIGHT - width)];
        let free = |taken: &[[f64; 4]], left: f64, base: f64| {
            let own = [left, base - 9.0, left + width, base + 2.0];
            !taken.iter().any(|t| overlap(t, &own))
        };
        let candidates = spots.iter().flat_map(|left| [(*left, at - 3.0), (*left, at + 11.0)]);
        let (left, base) = candidates
            .clone()
            .find(|(left, base)| *base > TOP + 8.0 && *base < BOTTOM && free(taken, *left, *base))
            .unwrap_or((spots[0], at - 3.0));
        taken.push([left, base - 9.0, left + width, base + 2.0]);
        let _ = write!(
            svg,
            "<line class=\"{class}\" x1=\"{LEFT}\" y1=\"{at:.1}\" x2=\"{RIGHT}\" y2=\"{at:.1}\"/>\
             <text class=\"{class}\" x=\"{left:.1}\" y=\"{base:.1}\">{}</text>",
            escaped(&text),
        );
    }
}

fn overlap(a: &[f64; 4], b: &[f64; 4]) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// A spot for a label of `width` pixels near a point, clear of points and labels so far.
fn place(taken: &mut Vec<[f64; 4]>, cx: f64, cy: f64, width: f64) -> (f64, f64, &'static str) {
    let mut fallback = None;
    for distance in [0.0, 12.0, 24.0, 36.0] {
        for (dx, dy, anchor) in [
            (7.0, -6.0 - distance, "start"),
            (7.0, 15.0 + distance, "start"),
            (-7.0, -6.0 - distance, "end"),
            (-7.0, 15.0 + distance, "end"),
            (10.0, 4.0 - distance, "start"),
        ] {
            let (x, y) = (cx + dx, cy + dy);
            let left = match anchor {
                "start" => x,
                "end" => x - width,
                _ => x - 0.5 * width,
            };
            let own = [left, y - 10.0, left + width, y + 3.0];
            let inside = own[0] > LEFT && own[2] < RIGHT + 10.0 && own[1] > 0.0 && own[3] < BOTTOM;
            fallback = fallback.or(Some((x, y, anchor)));
            if inside && !taken.iter().any(|t| overlap(t, &own)) {
                taken.push(own);
                return (x, y, anchor);
            }
        }
    }
    fallback.unwrap_or((cx, cy, "start"))
}

fn short(value: f64) -> String {
    if value >= 100.0 || value == value.round() {
        format!("{value:.0}")
    } else {
        format!("{value}")
    }
}

pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
