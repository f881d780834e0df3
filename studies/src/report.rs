//! The report: a page that explains itself, a table for programs, one line of JSON.

use crate::{Bound, Ladder, Outcome, Report, Row};
use serde_json::json;
use std::fmt::Write;

impl Report {
    /// `{"machine","commit","seed","quick","rows":[…],"bounds":[…]}` without a line break.
    #[must_use]
    pub fn to_json_line(&self) -> String {
        let rows: Vec<&Row> = self.rows().collect();
        let bounds: Vec<&Bound> = self.outcomes.iter().flat_map(|o| &o.bounds).collect();
        json!({
            "machine": self.machine, "commit": self.commit, "seed": self.seed, "quick": self.quick,
            "rows": rows, "bounds": bounds,
        })
        .to_string()
    }

    /// One line a row, with a head line; empty where a measure does not apply.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let mut out = String::from(
            "group,scene,rung,needs,mse_reduction_pct,reduction_se_pct,rmse_m,p95_m,nees,nees_in_bounds_pct,\
             lost_pct,swaps_pct,gospa,ns_per_update,ns_p99,error,error_unit,required,failed\n",
        );
        for r in self.rows() {
            let numbers = [
                r.mse_reduction_pct,
                r.reduction_se_pct,
                r.rmse_m,
                r.p95_m,
                r.nees,
                r.nees_in_bounds_pct,
                r.lost_pct,
                r.swaps_pct,
                r.gospa,
                r.ns_per_update,
                r.ns_p99,
                r.error,
            ];
            let numbers: Vec<String> =
                numbers.iter().map(|v| v.map_or_else(String::new, |v| v.to_string())).collect();
            let _ = writeln!(
                out,
                "{},{},{},{},{},{},{},{}",
                quoted(&r.group),
                quoted(&r.scene),
                quoted(&r.rung),
                quoted(r.needs.as_deref().unwrap_or("")),
                numbers.join(","),
                quoted(r.error_unit.as_deref().unwrap_or("")),
                r.required.map_or("", |met| if met { "PASS" } else { "FAIL" }),
                quoted(&r.failed.join("; ")),
            );
        }
        out
    }

    /// A page without scripts and without anything from elsewhere.
    #[must_use]
    pub fn to_html(&self) -> String {
        let mut body = String::new();
        for outcome in &self.outcomes {
            section(&mut body, outcome);
        }
        format!(
            "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">\
             <meta name=\"viewport\" content=\"width=device-width\"><title>Accuracy against time</title>\
             <style>{STYLE}</style></head><body><header><h1>What accuracy costs in time</h1>\
             <p>Every rung of every ladder on the same draws. In each picture a point is one rung: the \
             farther left, the cheaper; the lower, the more exact. The stepped line joins the rungs that \
             no other one beats in both (the Pareto front, filled points; half a percent of error does not \
             count). Diamonds have something that the others have not: a second more time, a map, or all \
             plots. Dashed lines are bounds: told what is written beside them, nothing can be below.</p>\
             <dl><dt>Machine</dt><dd>{}</dd><dt>Commit</dt><dd>{}</dd><dt>Seed</dt><dd>{}</dd>\
             <dt>Extent</dt><dd>{}</dd></dl></header>{body}</body></html>\n",
            escaped(&self.machine),
            escaped(&self.commit),
            self.seed,
            if self.quick { "quick: fewer runs and scenes" } else { "full" },
        )
    }
}

fn section(out: &mut String, outcome: &Outcome) {
    let Ladder { group, title, about, error_label, scenes } = &outcome.ladder;
    let _ = write!(
        out,
        "<section id=\"{}\"><h2>{}</h2><p>{}</p><p class=\"closing\">{}</p><div class=\"charts\">",
        escaped(group),
        escaped(title),
        escaped(about),
        escaped(&closing(outcome)),
    );
    for scene in scenes {
        let rows: Vec<&Row> = outcome.rows.iter().filter(|r| r.scene == scene.name).collect();
        let bounds: Vec<&Bound> = outcome.bounds.iter().filter(|b| b.scene == scene.name).collect();
        let _ = write!(
            out,
            "<figure><figcaption><b>{}</b>: {}</figcaption>{}</figure>",
            escaped(&scene.name),
            escaped(&scene.about),
            chart(&rows, &bounds, error_label),
        );
    }
    for picture in &outcome.pictures {
        let _ = write!(out, "<figure>{picture}</figure>");
    }
    out.push_str("</div>");
    table(out, outcome);
    out.push_str("</section>");
}

/// Which rows no other row beats in both error and time, cheapest first. A rung that needs more than the
/// plots so far is not compared, and a gain of half a percent is none.
fn pareto<'a>(rows: &[&'a Row]) -> Vec<&'a Row> {
    let point = |r: &Row| Some((r.ns_per_update?, r.shown_error()?));
    let mut sorted: Vec<&Row> = rows.iter().copied().filter(|r| point(r).is_some()).collect();
    sorted.sort_by(|a, b| {
        let (a, b) = (point(a).unwrap_or_default(), point(b).unwrap_or_default());
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut best = f64::INFINITY;
    sorted.retain(|r| {
        let error = r.shown_error().unwrap_or(f64::INFINITY);
        let front = error < 0.995 * best && r.failed.is_empty() && r.needs.is_none();
        best = if front { error } else { best };
        front
    });
    sorted
}

/// What the next step up costs and what it buys, in words, over the ladder's first scene.
fn closing(outcome: &Outcome) -> String {
    let Some(scene) = outcome.ladder.scenes.first() else { return String::new() };
    let rows: Vec<&Row> = outcome.rows.iter().filter(|r| r.scene == scene.name).collect();
    let front = pareto(&rows);
    let Some(first) = front.first() else { return "No rung has both an error and a time.".into() };
    let time = |r: &Row| r.ns_per_update.unwrap_or(0.0);
    let error = |r: &Row| r.shown_error().unwrap_or(0.0);
    let mut text = format!(
        "On {}: the cheapest rung, {}, needs {} an update and is {:.2} m off.",
        scene.name,
        first.rung,
        duration(time(first)),
        error(first),
    );
    for pair in front.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let _ = write!(
            text,
            " The next step up, {}, costs {} more ({}) and buys {:.2} m: {:.0} % less error.",
            b.rung,
            duration(time(b) - time(a)),
            times(time(b) / time(a)),
            error(a) - error(b),
            100.0 * (1.0 - error(b) / error(a)),
        );
    }
    for row in rows.iter().filter(|r| r.failed.is_empty() && r.ns_per_update.is_some()) {
        if let (Some(needs), Some(last)) = (&row.needs, front.last()) {
            let _ = write!(
                text,
                " With {needs}, {} is {:.2} m off at {} an update ({:+.0} % against {}).",
                row.rung,
                error(row),
                duration(time(row)),
                100.0 * (error(row) / error(last) - 1.0),
                last.rung,
            );
        }
    }
    let lost: Vec<&str> = rows
        .iter()
        .filter(|r| r.lost_pct.is_some_and(|l| l > 0.0) || !r.failed.is_empty())
        .map(|r| r.rung.as_str())
        .collect();
    if lost.is_empty() {
        text += " No rung lost a track.";
    } else {
        let _ = write!(text, " Tracks were lost or refused by: {}.", lost.join(", "));
    }
    text
}

fn times(factor: f64) -> String {
    if factor < 10.0 { format!("{factor:.1} times") } else { format!("{factor:.0} times") }
}

fn duration(ns: f64) -> String {
    if ns < 1e3 {
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

/// Error against time of one scene.
fn chart(rows: &[&Row], bounds: &[&Bound], error_label: &str) -> String {
    let points: Vec<(&Row, f64, f64)> = rows
        .iter()
        .filter_map(|r| Some((*r, r.ns_per_update?, r.shown_error()?)))
        .filter(|(_, x, y)| *x > 0.0 && *y > 0.0)
        .collect();
    let xs = Axis::around(points.iter().map(|p| p.1), (LEFT, RIGHT), 2.2);
    let errors = points.iter().map(|p| p.2).chain(bounds.iter().map(|b| b.error));
    let (Some(x), Some(y)) = (xs, Axis::around(errors, (BOTTOM, TOP), 1.12)) else {
        return "<p>Nothing to draw: no rung has both an error and a time.</p>".to_owned();
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
            duration(tick).replace(".0 ", " "),
        );
    }
    for tick in y.ticks() {
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
        "<text class=\"label\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">time per update (log)</text>\
         <text class=\"label\" transform=\"translate(13 {:.1}) rotate(-90)\" text-anchor=\"middle\">{} (log)</text>",
        0.5 * (LEFT + RIGHT),
        HEIGHT - 12.0,
        0.5 * (TOP + BOTTOM),
        escaped(error_label),
    );
    let mut taken: Vec<[f64; 4]> = points
        .iter()
        .map(|(_, px, py)| {
            let (cx, cy) = (x.at(*px), y.at(*py));
            [cx - 6.0, cy - 6.0, cx + 6.0, cy + 6.0]
        })
        .collect();
    bound_lines(&mut svg, bounds, y, &mut taken);
    let front = pareto(rows);
    let mut path = String::new();
    for (number, row) in front.iter().enumerate() {
        let (cx, cy) =
            (x.at(row.ns_per_update.unwrap_or(1.0)), y.at(row.shown_error().unwrap_or(1.0)));
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
        let title = format!("{}: {} per update, {py:.3}", escaped(&row.rung), duration(*px));
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

fn table(out: &mut String, outcome: &Outcome) {
    let any = |get: fn(&Row) -> bool| outcome.rows.iter().any(get);
    let swaps = any(|r| r.swaps_pct.is_some());
    let gospa = any(|r| r.gospa.is_some());
    let required = any(|r| r.required.is_some());
    out.push_str(
        "<div class=\"wide\"><table><thead><tr><th>scene</th><th>rung</th>\
         <th>needs</th><th>median time</th><th>99 % time</th><th>MSE reduction, %</th>\
         <th>rms error, m</th><th>95 %, m</th>",
    );
    if required {
        out.push_str("<th>95 % ≤ 7.5 m</th>");
    }
    out.push_str("<th>NEES (2 is right)</th><th>scans in 95 % bounds</th><th>lost, %</th>");
    for (shown, head) in [(swaps, "swaps, %"), (gospa, "GOSPA, m")] {
        if shown {
            let _ = write!(out, "<th>{head}</th>");
        }
    }
    out.push_str("<th>from the most exact</th><th>failures</th></tr></thead><tbody>");
    for row in &outcome.rows {
        let cell = |v: Option<f64>, digits: usize| {
            v.map_or_else(|| "–".to_owned(), |v| format!("{v:.digits$}"))
        };
        let reduction = match (row.mse_reduction_pct, row.reduction_se_pct) {
            (Some(v), Some(se)) => format!("{v:.1} ± {se:.1}"),
            (v, _) => cell(v, 1),
        };
        let _ = write!(
            out,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{reduction}</td><td>{}</td><td>{}</td>",
            escaped(&row.scene),
            escaped(&row.rung),
            escaped(row.needs.as_deref().unwrap_or("–")),
            row.ns_per_update.map_or_else(|| "–".to_owned(), duration),
            row.ns_p99.map_or_else(|| "–".to_owned(), duration),
            cell(row.rmse_m, 2),
            cell(row.p95_m, 2),
        );
        if required {
            out.push_str(match row.required {
                Some(true) => "<td class=\"pass\">PASS</td>",
                Some(false) => "<td class=\"fail\">FAIL</td>",
                None => "<td>–</td>",
            });
        }
        let _ = write!(
            out,
            "<td>{}</td><td>{}</td><td>{}</td>",
            cell(row.nees, 2),
            row.nees_in_bounds_pct.map_or_else(|| "–".to_owned(), |v| format!("{v:.0} %")),
            cell(row.lost_pct, 1),
        );
        for (shown, value) in [(swaps, row.swaps_pct), (gospa, row.gospa)] {
            if shown {
                let _ = write!(out, "<td>{}</td>", cell(value, 2));
            }
        }
        let unit = row.error_unit.as_deref().unwrap_or("");
        let _ = write!(
            out,
            "<td>{}</td><td>{}</td></tr>",
            row.error.map_or_else(|| "–".to_owned(), |v| format!("{v:.2} {}", escaped(unit))),
            if row.failed.is_empty() { "none".to_owned() } else { escaped(&row.failed.join("; ")) },
        );
    }
    out.push_str("</tbody></table></div>");
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;color:#1c2733;background:#fff;margin:0 auto;\
max-width:1320px;padding:1.5rem}h1{font-size:1.7rem;margin:.2rem 0}h2{margin:2.2rem 0 .4rem;border-top:1px solid #d5dde5;\
padding-top:1.2rem}p{max-width:62rem}dl{display:grid;grid-template-columns:max-content 1fr;gap:.1rem 1rem;\
font-size:.9rem;color:#445}dd{margin:0}.closing{background:#eef5fb;border-left:4px solid #2a78b8;padding:.7rem 1rem}\
.charts{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(560px,100%),1fr));gap:1.4rem}figure{margin:0}\
figcaption{font-size:.9rem;min-height:3em}svg{width:100%;height:auto}.grid{stroke:#e6ebf0}.tick{font-size:11px;fill:#566}\
.label{font-size:12px;fill:#334}.front{fill:none;stroke:#2a78b8;stroke-width:1.5}.best{fill:#2a78b8}\
.other{fill:#fff;stroke:#7a8a99;stroke-width:1.5}.failed{fill:#fff;stroke:#c0392b;stroke-width:2}\
.name{font-size:12px;fill:#556}.strong{font-weight:600;fill:#123a5c}line.bound{stroke:#b26a00;stroke-dasharray:6 4}\
text.bound{font-size:10px;fill:#8a5200}line.raw{stroke:#888;stroke-dasharray:2 3}text.raw{font-size:10px;fill:#666}\
.wide{overflow-x:auto;margin-top:1rem}table{border-collapse:collapse;font-size:.85rem;white-space:nowrap}\
th,td{padding:.2rem .6rem;text-align:right;border-bottom:1px solid #e6ebf0}th{text-align:right;vertical-align:bottom;\
background:#f5f8fa}td:nth-child(-n+3),th:nth-child(-n+3){text-align:left}.pass{color:#17723b}.fail{color:#b3261e;font-weight:600}";

#[cfg(test)]
mod tests {
    use super::*;

    fn report() -> Report {
        let row = |rung: &str, ns: f64, rmse: f64| Row {
            group: "filters".into(),
            scene: "a<b".into(),
            rung: rung.into(),
            rmse_m: Some(rmse),
            ns_per_update: Some(ns),
            lost_pct: Some(0.0),
            required: Some(rmse < 2.0),
            ..Row::default()
        };
        let mut failing = row("bad", 40.0, 9.0);
        failing.failed = vec!["said \"no\", twice".into()];
        let bound = Bound {
            group: "filters".into(),
            scene: "a<b".into(),
            label: "bound: told".into(),
            error: 0.8,
            mse_reduction_pct: Some(60.0),
        };
        let ladder = Ladder {
            group: "filters".into(),
            title: "Filters".into(),
            about: "how".into(),
            error_label: "error, m".into(),
            scenes: vec![crate::SceneAbout { name: "a<b".into(), about: "one".into() }],
        };
        let rows = vec![
            row("cheap", 20.0, 2.5),
            row("beaten", 300.0, 2.6),
            row("exact", 200.0, 1.0),
            failing,
        ];
        Report {
            machine: "m".into(),
            commit: "c".into(),
            seed: 1,
            quick: true,
            outcomes: vec![Outcome { ladder, rows, bounds: vec![bound], pictures: Vec::new() }],
        }
    }

    #[test]
    fn json_is_one_line_with_the_promised_keys() {
        let line = report().to_json_line();
        assert!(!line.contains('\n'));
        let value: serde_json::Value = serde_json::from_str(&line).unwrap();
        assert_eq!((&value["machine"], &value["commit"]), (&"m".into(), &"c".into()));
        for key in [
            "group",
            "scene",
            "rung",
            "mse_reduction_pct",
            "rmse_m",
            "p95_m",
            "nees",
            "lost_pct",
            "swaps_pct",
            "gospa",
            "ns_per_update",
            "ns_p99",
            "failed",
        ] {
            assert!(value["rows"][0].get(key).is_some(), "{key}");
        }
        assert!(value["rows"][0]["gospa"].is_null());
    }

    #[test]
    fn csv_has_a_line_for_every_row_and_quotes_what_it_must() {
        let csv = report().to_csv();
        assert_eq!(csv.lines().count(), 5);
        let columns = csv.lines().next().unwrap().split(',').count();
        assert_eq!(csv.lines().nth(1).unwrap().split(',').count(), columns);
        assert!(csv.contains("\"said \"\"no\"\", twice\""));
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let report = report();
        let rows: Vec<&Row> = report.rows().collect();
        let names: Vec<&str> = pareto(&rows).iter().map(|r| r.rung.as_str()).collect();
        assert_eq!(names, ["cheap", "exact"]);
        let text = closing(&report.outcomes[0]);
        assert!(text.contains("exact, costs 180 ns more (10 times) and buys 1.50 m"), "{text}");
        assert!(text.contains("refused by: bad"), "{text}");
    }

    #[test]
    fn the_page_is_whole_and_escapes_names() {
        let html = report().to_html();
        assert!(html.starts_with("<!doctype html>") && html.ends_with("</html>\n"));
        assert!(html.contains("a&lt;b") && !html.contains("a<b"));
        assert_eq!(html.matches("<circle").count(), 4);
        assert!(!html.contains("http") && !html.contains("<script"), "nothing from elsewhere");
    }
}
