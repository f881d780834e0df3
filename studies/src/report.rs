//! The report: a page that explains itself, a table for programs, one line of JSON.

use crate::chart::{chart, duration, escaped, pareto, times};
use crate::{Bound, Ladder, Outcome, Report, Row, Table, overview, requirements};
use models::score::requirements::{Measure, Requirement, Verdict};
use serde_json::json;
use std::fmt::Write;

/// Keys of a row in [`Report::to_json_line`].
pub(crate) const LINE_KEYS: [&str; 13] = [
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
];

impl Report {
    /// `{"machine","commit","rows":[…]}` without a line break; the rows have 13 keys, null
    /// where a measure does not apply.
    #[must_use]
    pub fn to_json_line(&self) -> String {
        let rows: Vec<serde_json::Value> = self
            .rows()
            .map(|row| {
                let all = json!(row);
                let of = |key: &&str| ((*key).to_owned(), all[*key].clone());
                serde_json::Value::Object(LINE_KEYS.iter().map(of).collect())
            })
            .collect();
        json!({ "machine": self.machine, "commit": self.commit, "rows": rows }).to_string()
    }

    /// Everything that was measured: also the bounds, other errors and costs, and the verdicts.
    #[must_use]
    pub fn to_json(&self) -> String {
        let rows: Vec<&Row> = self.rows().collect();
        let bounds: Vec<&Bound> = self.outcomes.iter().flat_map(|o| &o.bounds).collect();
        let verdict = |run: &String, v: &Verdict| {
            let r = &v.requirement;
            json!({
                "run": run, "standard": r.standard, "area": r.area, "name": r.name,
                "probability": r.probability, "at_least": r.at_least, "threshold": r.threshold,
                "found": v.found, "samples": v.samples, "met": v.met, "enough": v.enough,
            })
        };
        let verdicts: Vec<serde_json::Value> = self
            .outcomes
            .iter()
            .flat_map(|o| &o.verdicts)
            .flat_map(|(run, list)| list.iter().map(move |v| verdict(run, v)))
            .collect();
        let tables: Vec<&Table> = self.tables().collect();
        json!({
            "machine": self.machine, "commit": self.commit, "seed": self.seed, "quick": self.quick,
            "rows": rows, "bounds": bounds, "requirements": verdicts, "tables": tables,
        })
        .to_string()
    }

    /// One line a row, with a head line; empty where a measure does not apply.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let mut out = String::from(
            "group,scene,rung,needs,mse_reduction_pct,reduction_se_pct,rmse_m,p95_m,nees,nees_in_bounds_pct,\
             lost_pct,swaps_pct,gospa,ns_per_update,ns_p99,error,cost,cost_unit,error_unit,required,failed\n",
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
                r.cost,
            ];
            let numbers: Vec<String> =
                numbers.iter().map(|v| v.map_or_else(String::new, |v| v.to_string())).collect();
            let _ = writeln!(
                out,
                "{},{},{},{},{},{},{},{},{}",
                quoted(&r.group),
                quoted(&r.scene),
                quoted(&r.rung),
                quoted(r.needs.as_deref().unwrap_or("")),
                numbers.join(","),
                quoted(r.cost_unit.as_deref().unwrap_or("")),
                quoted(r.error_unit.as_deref().unwrap_or("")),
                r.required.map_or("", |met| if met { "PASS" } else { "FAIL" }),
                quoted(&r.failed.join("; ")),
            );
        }
        out
    }

    /// One sentence per ladder: what the next step up costs and what it buys.
    #[must_use]
    pub fn closing(&self) -> String {
        let lines = self.outcomes.iter().map(|o| format!("{}: {}\n", o.ladder.group, closing(o)));
        let mut text: String = lines.collect();
        if self.outcomes.iter().any(|o| o.ladder.group == "filters") {
            let asked = self.budget.map_or_else(|| overview::BUDGETS.to_vec(), |one| vec![one]);
            for (budget_us, targets) in asked {
                text += &overview::recommendation(self, budget_us, targets);
                text.push('\n');
            }
        }
        text
    }

    /// Tables for a terminal, then [`Self::closing`].
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut out = format!("{}; commit {}; seed {}\n", self.machine, self.commit, self.seed);
        let head = ["reduction %", "rms m", "95 % m", "NEES", "lost %", "swaps %", "GOSPA"];
        for outcome in &self.outcomes {
            let wide = |get: fn(&Row) -> &str| {
                outcome.rows.iter().map(|r| get(r).chars().count()).max().unwrap_or(0).max(5)
            };
            let (scene, rung) = (wide(|r| &r.scene), wide(|r| &r.rung));
            let _ = write!(out, "\n{}\n{:scene$}  {:rung$}", outcome.ladder.title, "scene", "rung");
            for name in head {
                let _ = write!(out, " {name:>11}");
            }
            out.push_str("        time    99 % time  other\n");
            for r in &outcome.rows {
                let _ = write!(out, "{:scene$}  {:rung$}", r.scene, r.rung);
                for value in [
                    r.mse_reduction_pct,
                    r.rmse_m,
                    r.p95_m,
                    r.nees,
                    r.lost_pct,
                    r.swaps_pct,
                    r.gospa,
                ] {
                    let _ = write!(out, " {:>11}", value.map_or("-".into(), |v| format!("{v:.2}")));
                }
                let time = |ns: Option<f64>| ns.map_or("-".into(), duration);
                let _ = write!(out, " {:>11}  {:>11} ", time(r.ns_per_update), time(r.ns_p99));
                for (value, unit) in [(r.cost, &r.cost_unit), (r.error, &r.error_unit)] {
                    if let (Some(value), Some(unit)) = (value, unit) {
                        let _ = write!(out, " {value:.3} {unit};");
                    }
                }
                for reason in &r.failed {
                    let _ = write!(out, " FAILED: {reason};");
                }
                out.push('\n');
            }
        }
        out.push('\n');
        out.push_str(&self.closing());
        out
    }

    /// A page without scripts and without anything from elsewhere.
    #[must_use]
    pub fn to_html(&self) -> String {
        let mut contents = String::new();
        let mut body = String::new();
        for outcome in &self.outcomes {
            let _ = write!(
                contents,
                "<tr><td><a href=\"#{}\">{}</a></td><td>{}</td></tr>",
                escaped(&outcome.ladder.group),
                escaped(&outcome.ladder.title),
                escaped(&closing(outcome)),
            );
            section(&mut body, outcome);
        }
        let judged = self.outcomes.iter().any(|o| !o.verdicts.is_empty());
        if judged {
            contents.push_str(
                "<tr><td><a href=\"#requirements\">Requirements</a></td><td>Requirement values of A-SMGCS \
                 surveillance, PASS or FAIL.</td></tr>",
            );
            requirement_section(&mut body, &self.outcomes);
        }
        format!(
            "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">\
             <meta name=\"viewport\" content=\"width=device-width\"><title>Accuracy against time</title>\
             <style>{STYLE}</style></head><body><header><h1>What accuracy costs in time</h1>\
             <p>A ladder is one task done in several ways, from cheap to exact; each way is a rung. All rungs of a ladder are \
             measured on the same draws. Find the ladder, read its sentence, then \
             its pictures: each point is one rung; <b>farther left is cheaper, lower is more exact</b>, both axes \
             are logarithmic.</p><p class=\"key\">{KEY}</p>\
             <dl><dt>Machine</dt><dd>{}</dd><dt>Commit</dt><dd>{}</dd><dt>Seed</dt><dd>{}</dd>\
             <dt>Extent</dt><dd>{}</dd></dl></header>\
             {}<h2>What the next step up costs, and what it buys</h2>\
             <table class=\"contents\">{contents}</table>{body}</body></html>\n",
            escaped(&self.machine),
            escaped(&self.commit),
            self.seed,
            if self.quick { "quick: fewer runs and scenes" } else { "full" },
            overview::first_screen(self),
        )
    }
}

/// What the marks mean.
const KEY: &str = "<svg viewBox=\"0 0 14 14\"><circle class=\"best\" cx=\"7\" cy=\"7\" r=\"5\"/></svg> on the Pareto \
front: no other rung is both cheaper and more exact (the stepped line joins them; half a percent does not count) \
<svg viewBox=\"0 0 14 14\"><circle class=\"other\" cx=\"7\" cy=\"7\" r=\"5\"/></svg> beaten by another rung \
<svg viewBox=\"0 0 14 14\"><path class=\"other\" d=\"M7 1l6 6-6 6-6-6z\"/></svg> has what the others have not: a \
second more time, a map, all plots \
<svg viewBox=\"0 0 14 14\"><circle class=\"failed\" cx=\"7\" cy=\"7\" r=\"5\"/></svg> lost tracks or failed \
<svg viewBox=\"0 0 30 14\"><line class=\"bound\" x1=\"0\" y1=\"7\" x2=\"30\" y2=\"7\"/></svg> bound: told what is \
written beside it, nothing can be lower \
<svg viewBox=\"0 0 30 14\"><line class=\"raw\" x1=\"0\" y1=\"7\" x2=\"30\" y2=\"7\"/></svg> raw plots";

fn section(out: &mut String, outcome: &Outcome) {
    let Ladder { group, title, about, scenes, .. } = &outcome.ladder;
    let _ = write!(
        out,
        "<section id=\"{}\"><h2>{}</h2><p>{}</p><p class=\"closing\">{}</p>",
        escaped(group),
        escaped(title),
        escaped(about),
        escaped(&closing(outcome)),
    );
    gains(out, outcome);
    out.push_str("<div class=\"charts\">");
    for scene in scenes {
        let rows: Vec<&Row> = outcome.rows.iter().filter(|r| r.scene == scene.name).collect();
        let bounds: Vec<&Bound> = outcome.bounds.iter().filter(|b| b.scene == scene.name).collect();
        let _ = write!(
            out,
            "<figure><figcaption><b>{}</b>: {}</figcaption>{}</figure>",
            escaped(&scene.name),
            escaped(&scene.about),
            chart(&outcome.ladder, &rows, &bounds),
        );
    }
    for picture in &outcome.pictures {
        let _ = write!(out, "<figure>{picture}</figure>");
    }
    out.push_str("</div>");
    outcome.tables.iter().for_each(|one| own_table(out, one));
    let _ = write!(out, "<details><summary>All {} rows as a table</summary>", outcome.rows.len());
    table(out, outcome);
    out.push_str("</details></section>");
}

fn own_table(out: &mut String, one: &Table) {
    let cells = |out: &mut String, of: &[String], tag: &str| {
        out.push_str("<tr>");
        of.iter().for_each(|cell| {
            let _ = write!(out, "<{tag}>{}</{tag}>", escaped(cell));
        });
        out.push_str("</tr>");
    };
    let _ = write!(
        out,
        "<details><summary>{} ({} rows; {}.csv)</summary><div class=\"wide\"><table><thead>",
        escaped(&one.title),
        one.rows.len(),
        escaped(&one.name)
    );
    cells(out, &one.heads, "th");
    out.push_str("</thead><tbody>");
    one.rows.iter().for_each(|row| cells(out, row, "td"));
    out.push_str("</tbody></table></div></details>");
}

/// Reductions of the mean squared error, rung by scene, with the bounds below.
fn gains(out: &mut String, outcome: &Outcome) {
    let scenes: Vec<&str> = outcome
        .ladder
        .scenes
        .iter()
        .map(|s| s.name.as_str())
        .filter(|s| outcome.rows.iter().any(|r| r.scene == *s && r.mse_reduction_pct.is_some()))
        .collect();
    if scenes.is_empty() {
        return;
    }
    let mut rungs: Vec<&str> = Vec::new();
    for row in outcome.rows.iter().filter(|r| r.mse_reduction_pct.is_some()) {
        if !rungs.contains(&row.rung.as_str()) {
            rungs.push(&row.rung);
        }
    }
    let mut bounds: Vec<&str> = Vec::new();
    for bound in outcome.bounds.iter().filter(|b| b.label.starts_with("bound")) {
        if !bounds.contains(&bound.label.as_str()) {
            bounds.push(&bound.label);
        }
    }
    out.push_str("<div class=\"wide\"><table class=\"gains\"><caption>Reduction of the mean squared position \
                  error against the raw plots, %; negative is worse than no filter</caption><thead><tr><th>rung</th>");
    for scene in &scenes {
        let _ = write!(out, "<th>{}</th>", escaped(scene));
    }
    out.push_str("<th>time</th></tr></thead><tbody>");
    for rung in rungs {
        let _ = write!(out, "<tr><td>{}</td>", escaped(rung));
        let of = |scene: &str| outcome.rows.iter().find(|r| r.rung == rung && r.scene == scene);
        for scene in &scenes {
            let row = of(scene);
            let lost = row.and_then(|r| r.lost_pct).filter(|l| *l > 0.0);
            match (row.and_then(|r| r.mse_reduction_pct), lost) {
                (Some(gain), None) => {
                    let shade = (gain / 100.0).clamp(0.0, 1.0) * 0.55;
                    let _ = write!(
                        out,
                        "<td style=\"background:rgba(42,120,184,{shade:.2})\">{gain:.0}</td>"
                    );
                }
                (Some(gain), Some(lost)) => {
                    let _ = write!(out, "<td class=\"fail\">{gain:.0} ({lost:.0} % lost)</td>");
                }
                (None, _) => out.push_str("<td>–</td>"),
            }
        }
        let time = scenes.iter().find_map(|s| of(s)?.ns_per_update);
        let _ = write!(out, "<td>{}</td></tr>", time.map_or("–".into(), duration));
    }
    for label in bounds {
        let _ = write!(out, "<tr class=\"told\"><td>{}</td>", escaped(label));
        for scene in &scenes {
            let found = outcome.bounds.iter().find(|b| b.label == label && b.scene == *scene);
            let text = found.and_then(|b| b.mse_reduction_pct);
            let _ = write!(out, "<td>{}</td>", text.map_or("–".into(), |v| format!("{v:.0}")));
        }
        out.push_str("<td>–</td></tr>");
    }
    out.push_str("</tbody></table></div>");
}

/// Share of the error that a step has to buy to be named in the closing sentence.
const WORTH_SAYING: f64 = 0.05;

/// Steps that a closing sentence names one by one.
const MOST_STEPS: usize = 3;

/// What the next step up costs and what it buys, in words: over all scenes, and in numbers on the ladder's first one.
fn closing(outcome: &Outcome) -> String {
    if let Some(said) = &outcome.said {
        return said.clone();
    }
    let first = closing_on_first(outcome);
    match overview::sentence(outcome) {
        Some(all) => format!("{all} {first}"),
        None => first,
    }
}

fn closing_on_first(outcome: &Outcome) -> String {
    let ladder = &outcome.ladder;
    let failed: Vec<&Row> = outcome.rows.iter().filter(|r| !r.failed.is_empty()).collect();
    let Some(scene) = ladder.scenes.first() else {
        return match failed.len() {
            0 => format!("All {} statements hold.", outcome.rows.len()),
            n => format!("{n} of {} statements do not hold.", outcome.rows.len()),
        };
    };
    let rows: Vec<&Row> = outcome.rows.iter().filter(|r| r.scene == scene.name).collect();
    let front = pareto(ladder, &rows, WORTH_SAYING);
    let Some(first) = front.first() else { return "No rung has both an error and a time.".into() };
    let unit = if ladder.unit.is_empty() { "m" } else { &ladder.unit };
    let cost = |r: &Row| ladder.cost(r).unwrap_or(0.0);
    let error = |r: &Row| ladder.error(r).unwrap_or(0.0);
    let said = |value: f64| match &ladder.cost_label {
        Some(label) => format!("{value:.2} {label}"),
        None => duration(value),
    };
    let off = |value: f64| match value {
        v if v == 0.0 || v >= 0.095 => format!("{v:.2} {unit}"),
        v => format!("{} {unit}", significant(v)),
    };
    let loses = rows.iter().any(|r| r.lost_pct.is_some_and(|l| l > 0.0));
    let mut text = format!(
        "On {}, the cheapest rung{} is {} ({}, error {})",
        scene.name,
        if loses { " that lost no track" } else { "" },
        first.rung,
        said(cost(first)),
        off(error(first)),
    );
    for (number, pair) in front.windows(2).enumerate().take(MOST_STEPS) {
        let (a, b) = (pair[0], pair[1]);
        let _ = write!(
            text,
            "; {}{}, costs {} more ({}) and buys {} ({:.0} % less error)",
            if number == 0 { "the next step up, " } else { "the next, " },
            b.rung,
            said(cost(b) - cost(a)),
            times(cost(b) / cost(a)),
            off(error(a) - error(b)),
            100.0 * (1.0 - error(b) / error(a)),
        );
    }
    if let Some(last) = front.last().filter(|_| front.len() > MOST_STEPS + 1) {
        let _ = write!(
            text,
            "; so it goes on to {} ({}, error {})",
            last.rung,
            said(cost(last)),
            off(error(last))
        );
    }
    if front.len() == 1 && rows.len() > 1 {
        text += "; no other rung takes off another 5 %";
    }
    for row in rows.iter().filter(|r| r.failed.is_empty() && r.ns_per_update.is_some()) {
        if let (Some(needs), Some(last)) = (&row.needs, front.last()) {
            let _ = write!(
                text,
                "; with {needs}, {} is at {} for {} ({:+.0} % against {})",
                row.rung,
                off(error(row)),
                said(cost(row)),
                100.0 * (error(row) / error(last) - 1.0),
                last.rung,
            );
        }
    }
    text.push('.');
    let lossy = rows.iter().filter_map(|r| Some((r, r.lost_pct.filter(|l| *l > 0.0)?)));
    let lossy: Vec<String> = lossy.map(|(r, l)| format!("{} {l:.0} %", r.rung)).collect();
    if !lossy.is_empty() {
        let _ = write!(text, " Tracks lost there: {}.", lossy.join(", "));
    }
    let mut lost: Vec<&str> = Vec::new();
    for row in &outcome.rows {
        let bad = row.lost_pct.is_some_and(|l| l > 0.0) || !row.failed.is_empty();
        if bad && !lost.contains(&row.rung.as_str()) {
            lost.push(&row.rung);
        }
    }
    if !lost.is_empty() {
        let _ = write!(
            text,
            " Tracks were lost or plots refused, on some scene, by: {}.",
            lost.join(", ")
        );
    }
    text
}

/// Two digits that mean something.
fn significant(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let digits = (1.0 - libm::floor(libm::log10(value.abs()))).clamp(0.0, 12.0) as usize;
    format!("{value:.digits$}")
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
    if any(|r| r.cost.is_some()) {
        out.push_str("<th>cost</th>");
    }
    out.push_str("<th>other error</th><th>failures</th></tr></thead><tbody>");
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
        if let Some(cost) = row.cost {
            let unit = escaped(row.cost_unit.as_deref().unwrap_or(""));
            let _ = write!(out, "<td>{cost:.3} {unit}</td>");
        }
        let unit = row.error_unit.as_deref().unwrap_or("");
        let _ = write!(
            out,
            "<td>{}</td><td>{}</td></tr>",
            row.error.map_or_else(
                || "–".to_owned(),
                |v| format!("{} {}", significant(v), escaped(unit))
            ),
            if row.failed.is_empty() { "none".to_owned() } else { escaped(&row.failed.join("; ")) },
        );
    }
    out.push_str("</tbody></table></div>");
}

/// The requirement table of the runs that were judged.
fn requirement_section(out: &mut String, outcomes: &[Outcome]) {
    let runs: Vec<&(String, Vec<Verdict>)> = outcomes.iter().flat_map(|o| &o.verdicts).collect();
    let _ = write!(
        out,
        "<section id=\"requirements\"><h2>Requirements of A-SMGCS surveillance</h2><p>Published tracks of the \
         runs named in the columns, held against the values of EUROCAE documents, each in its own area. Values: {}. \
         A share that is met over too few reports to show it is marked so. Update intervals before a track is \
         confirmed count as missed.</p>",
        escaped(&requirements::source()),
    );
    let names: Vec<&str> = runs.iter().map(|r| r.0.as_str()).collect();
    let lists: Vec<&[Verdict]> = runs.iter().map(|r| r.1.as_slice()).collect();
    requirement_table(out, &names, &lists);
    out.push_str("</section>");
}

/// Requirements by row, runs by column: what was found, PASS or FAIL.
pub(crate) fn requirement_table(out: &mut String, names: &[&str], lists: &[&[Verdict]]) {
    out.push_str("<div class=\"wide\"><table><thead><tr><th>standard</th><th>area</th><th>requirement</th><th>asks</th>");
    for name in names {
        let _ = write!(out, "<th>{}</th><th></th>", escaped(name));
    }
    out.push_str("</tr></thead><tbody>");
    let Some(first) = lists.first() else { return };
    for (number, verdict) in first.iter().enumerate() {
        let r = &verdict.requirement;
        let _ = write!(
            out,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td>",
            escaped(&r.standard),
            escaped(&r.area),
            escaped(&r.name),
            escaped(&asks(r)),
        );
        for list in lists {
            let Some(v) = list.get(number) else { continue };
            let (class, word) = match v.met {
                Some(true) => ("pass", "PASS"),
                Some(false) => ("fail", "FAIL"),
                None => ("none", "not measured"),
            };
            let found =
                v.found.map_or("–".into(), |f| format!("{} of {}", percent(f), v.samples));
            let few = if v.met == Some(true) && !v.enough { " (too few to show it)" } else { "" };
            let remark = v.remark.as_deref().map_or_else(String::new, |words| {
                format!("<small class=\"remark\">{}</small>", escaped(words))
            });
            let _ = write!(out, "<td>{found}</td><td class=\"{class}\">{word}{few}{remark}</td>");
        }
        out.push_str("</tr>");
    }
    out.push_str("</tbody></table></div>");
}

/// What a requirement asks, in short.
pub(crate) fn asks(r: &Requirement) -> String {
    let bound = if r.at_least { "≥" } else { "≤" };
    let share = format!("{bound} {}", percent(r.probability));
    match r.measure {
        Measure::Report => format!("{share} of intervals of {} s", r.interval_s),
        Measure::Gaps => format!("gaps of {} s {share} of intervals", r.gap_s),
        Measure::Position => format!("{share} within {} m", r.threshold),
        Measure::FalseReports => format!("{share} beyond {} m", r.threshold),
        Measure::Speed => format!("{share} within {} m/s or 10 %", r.threshold),
        Measure::Course => format!("{share} within {}°", r.threshold),
        Measure::Identified => format!("{share} right"),
        Measure::Misidentified => format!("{share} wrong"),
    }
}

pub(crate) fn percent(share: f64) -> String {
    let pct = 100.0 * share;
    if pct == 0.0 || (1.0..99.0).contains(&pct) {
        format!("{pct:.1} %")
    } else if pct >= 99.0 {
        format!("{pct:.2} %").replace("100.00", "100")
    } else {
        format!("{} %", significant(pct))
    }
}

pub(crate) fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

pub(crate) const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;color:#1c2733;background:#fff;margin:0 auto;\
max-width:1320px;padding:1.5rem}h1{font-size:1.7rem;margin:.2rem 0}h2{margin:2.4rem 0 .4rem;border-top:1px solid #d5dde5;\
padding-top:1.2rem;font-size:1.3rem}p{max-width:64rem}dl{display:grid;grid-template-columns:max-content 1fr;gap:.1rem 1rem;\
font-size:.9rem;color:#445}dd{margin:0}.closing{background:#eef5fb;border-left:4px solid #2a78b8;padding:.7rem 1rem}\
.key{font-size:.9rem;color:#334}.key svg{height:14px;width:auto;vertical-align:-2px;margin-left:.6rem}\
.contents{white-space:normal}.contents td{text-align:left;vertical-align:top;padding:.35rem .8rem .35rem 0}\
.contents td:first-child{white-space:nowrap}a{color:#1b5f96}\
.charts{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(520px,100%),1fr));gap:1.6rem}figure{margin:0;max-width:680px}.first{max-width:860px}.take{padding-left:1.2rem}\
figcaption{font-size:.9rem;min-height:3em}figure svg{width:100%;height:auto}.grid{stroke:#e6ebf0;fill:none}.zero{stroke:#9fb1c1;stroke-dasharray:1 3}\
.tick{font-size:11px;fill:#566}.label{font-size:12px;fill:#334}.front{fill:none;stroke:#2a78b8;stroke-width:1.5}.best{fill:#2a78b8}\
.other{fill:#fff;stroke:#7a8a99;stroke-width:1.5}.failed{fill:#fff;stroke:#c0392b;stroke-width:2}\
.name{font-size:12px;fill:#556}.strong{font-weight:600;fill:#123a5c}line.bound{stroke:#b26a00;stroke-dasharray:6 4}\
text.bound{font-size:10px;fill:#8a5200}line.raw{stroke:#888;stroke-dasharray:2 3}text.raw{font-size:10px;fill:#666}\
.wide{overflow-x:auto;margin-top:1rem}table{border-collapse:collapse;font-size:.85rem;white-space:nowrap}\
caption{text-align:left;font-weight:600;padding:.3rem 0}details{margin-top:1rem}summary{cursor:pointer;color:#1b5f96}\
th,td{padding:.2rem .6rem;text-align:right;border-bottom:1px solid #e6ebf0}th{text-align:right;vertical-align:bottom;\
background:#f5f8fa}td:nth-child(-n+3),th:nth-child(-n+3){text-align:left}.gains td:not(:first-child),.gains th:not(:first-child){text-align:right}\
.told td{color:#8a5200;font-style:italic}.pass{color:#17723b}.fail{color:#b3261e;font-weight:600}.none{color:#889}.remark{display:block;\
font-weight:400;color:#445;max-width:26rem;white-space:normal;text-align:left}\
@media(max-width:760px){body{padding:.8rem}dl{grid-template-columns:minmax(0,auto) minmax(0,1fr)}dd,p{overflow-wrap:anywhere}\
table{display:block;overflow-x:auto}.contents td:first-child{white-space:normal}}";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::LEAST_GAIN;

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
            ..Ladder::default()
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
            budget: None,
            outcomes: vec![Outcome { ladder, rows, bounds: vec![bound], ..Outcome::default() }],
        }
    }

    #[test]
    fn json_is_one_line_with_the_promised_keys() {
        let line = report().to_json_line();
        assert!(!line.contains('\n'));
        let value: serde_json::Value = serde_json::from_str(&line).unwrap();
        assert_eq!((&value["machine"], &value["commit"]), (&"m".into(), &"c".into()));
        assert_eq!(value.as_object().unwrap().len(), 3);
        assert_eq!(value["rows"][0].as_object().unwrap().len(), 13);
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
        let names: Vec<&str> = pareto(&report.outcomes[0].ladder, &rows, LEAST_GAIN)
            .iter()
            .map(|r| r.rung.as_str())
            .collect();
        assert_eq!(names, ["cheap", "exact"]);
        let text = closing(&report.outcomes[0]);
        assert!(text.contains("exact, costs 180 ns more (10 times) and buys 1.50 m"), "{text}");
        assert!(text.contains("on some scene, by: bad"), "{text}");
        assert!(report.to_text().contains("FAILED: said"));
    }

    #[test]
    fn the_page_is_whole_and_escapes_names() {
        let html = report().to_html();
        assert!(html.starts_with("<!doctype html>") && html.ends_with("</html>\n"));
        assert!(html.contains("a&lt;b") && !html.contains("a<b"));
        assert_eq!(html.matches("<circle").count(), 3 + 4 + 4, "the key, and four rungs twice");
        assert!(!html.contains("http") && !html.contains("<script"), "nothing from elsewhere");
    }
}
