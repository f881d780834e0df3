//! All scenes of a ladder at once: which rung stands where, what contradicts that on single scenes, and what to take for a
//! budget.
//!
//! Errors of different scenes are made comparable as shares: of the raw plots' error where a ladder has plots, else of the
//! largest error on the scene. Scenes that something was chosen on and scenes held out are kept apart.

use crate::chart::{chart, duration, escaped, times};
use crate::{Bound, Draws, Ladder, Outcome, Report, Row};
use std::fmt::Write;

/// A rung over all scenes of its ladder.
#[derive(Clone, Debug, PartialEq)]
pub struct Standing {
    /// The rung.
    pub rung: String,
    /// What it has that others have not.
    pub needs: Option<String>,
    /// Median of its cost over the scenes, in the ladder's unit (ns where it is time).
    pub cost: f64,
    /// Mean share of the error, over the scenes that something was chosen on; absent without one.
    pub chosen_on: Option<f64>,
    /// The same over the scenes held out.
    pub held_out: Option<f64>,
    /// Its largest share, and the scene of it.
    pub worst: (f64, String),
    /// Mean share of swapped tracks, %, where they are counted.
    pub swaps_pct: Option<f64>,
    /// Scenes on which it lost tracks or failed.
    pub lost_on: Vec<String>,
    /// Share of the error by scene.
    shares: Vec<(String, f64)>,
}

impl Standing {
    /// Mean share over all scenes.
    #[must_use]
    pub fn share(&self) -> f64 {
        typical(self.shares.iter().map(|s| s.1)).unwrap_or(f64::NAN)
    }

    /// What counts when a rung is chosen: the scenes held out, where there are any.
    #[must_use]
    pub fn judged(&self) -> f64 {
        self.held_out.unwrap_or_else(|| self.share())
    }
}

/// A rung that is worse than a cheaper one by more than this share of the error contradicts the order.
const CONTRADICTS: f64 = 0.02;
/// A share of the error that a step has to take off to be named.
const WORTH_SAYING: f64 = 0.02;

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, n) = values.fold((0.0, 0u32), |(sum, n), v| (sum + v, n + 1));
    (n > 0).then(|| sum / f64::from(n))
}

/// The geometric mean: one scene of large shares does not decide all.
fn typical(values: impl Iterator<Item = f64>) -> Option<f64> {
    mean(values.map(|v| libm::log(v.max(1e-6)))).map(libm::exp)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    (!values.is_empty()).then(|| values[values.len() / 2])
}

/// What the errors of a scene are shares of.
fn basis(outcome: &Outcome, scene: &str) -> Option<f64> {
    let raw = outcome.bounds.iter().find(|b| b.scene == scene && b.label == RAW);
    let largest = || {
        let rows = outcome.rows.iter().filter(|r| r.scene == scene);
        rows.filter_map(|r| outcome.ladder.error(r)).reduce(f64::max)
    };
    raw.map(|b| b.error).or_else(largest).filter(|e| *e > 0.0 && e.is_finite())
}

const RAW: &str = "raw plots";

/// Where the rungs of a ladder stand, cheapest first; only those that ran on every scene.
#[must_use]
pub fn standings(outcome: &Outcome) -> Vec<Standing> {
    let Ladder { scenes, held_out, .. } = &outcome.ladder;
    let bases: Vec<(&str, f64)> =
        scenes.iter().filter_map(|s| Some((s.name.as_str(), basis(outcome, &s.name)?))).collect();
    let mut rungs: Vec<&str> = Vec::new();
    for row in &outcome.rows {
        if !rungs.contains(&row.rung.as_str()) {
            rungs.push(&row.rung);
        }
    }
    let mut out = Vec::new();
    for rung in rungs {
        let rows: Vec<(&Row, f64)> = bases
            .iter()
            .filter_map(|(scene, base)| {
                let row = outcome.rows.iter().find(|r| r.rung == rung && r.scene == *scene)?;
                Some((row, outcome.ladder.error(row)? / base))
            })
            .collect();
        let cost = median(rows.iter().filter_map(|(r, _)| outcome.ladder.cost(r)).collect());
        let Some(cost) = cost.filter(|_| rows.len() == bases.len() && !rows.is_empty()) else {
            continue;
        };
        let of = |wanted: bool| {
            let side = rows.iter().filter(|(r, _)| held_out.contains(&r.scene) == wanted);
            typical(side.map(|s| s.1))
        };
        let worst =
            rows.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(r, s)| (*s, r.scene.clone()));
        let lost = |r: &&Row| r.lost_pct.is_some_and(|l| l > 0.0) || !r.failed.is_empty();
        out.push(Standing {
            rung: rung.to_owned(),
            needs: rows[0].0.needs.clone(),
            cost,
            chosen_on: of(false),
            held_out: of(true),
            worst: worst.unwrap_or_default(),
            swaps_pct: mean(rows.iter().filter_map(|(r, _)| r.swaps_pct)),
            lost_on: rows.iter().map(|r| r.0).filter(lost).map(|r| r.scene.clone()).collect(),
            shares: rows.iter().map(|(r, s)| (r.scene.clone(), *s)).collect(),
        });
    }
    out.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    out
}

/// The standings that no cheaper one beats by their mean share.
fn front(standings: &[Standing], least: f64) -> Vec<&Standing> {
    let mut best = f64::INFINITY;
    let sound = standings.iter().filter(|s| s.needs.is_none() && s.lost_on.is_empty());
    sound
        .filter(|s| {
            let better = s.share() < (1.0 - least) * best;
            best = if better { s.share() } else { best };
            better
        })
        .collect()
}

/// A ladder's rungs over all its scenes in words; absent where it has not two scenes and two rungs to compare.
#[must_use]
pub fn sentence(outcome: &Outcome) -> Option<String> {
    let all = standings(outcome);
    let ladder = &outcome.ladder;
    if ladder.scenes.len() < 2 || all.len() < 2 {
        return None;
    }
    let cost = |value: f64| match &ladder.cost_label {
        Some(label) => format!("{value:.2} {label}"),
        None => duration(value),
    };
    let plots = outcome.bounds.iter().any(|b| b.label == RAW);
    let held = ladder.scenes.iter().filter(|s| ladder.held_out.contains(&s.name)).count();
    let mut text = format!("Over {} scenes", ladder.scenes.len());
    if held > 0 {
        let _ = write!(text, " ({held} of them held out)");
    }
    let _ = write!(
        text,
        ", mean error (geometric) as a share of {}: ",
        if plots { "that of the plots" } else { "the largest on each" }
    );
    let steps = front(&all, WORTH_SAYING);
    let mut said = Vec::new();
    for (number, step) in steps.iter().enumerate() {
        let more = number.checked_sub(1).map(|before| {
            let before = steps[before];
            format!(
                ", {} for {:.0} % less error",
                times(step.cost / before.cost),
                100.0 * (1.0 - step.share() / before.share())
            )
        });
        said.push(format!(
            "{} {:.2} ({}{}; worst {:.2}, {})",
            step.rung,
            step.share(),
            cost(step.cost),
            more.unwrap_or_default(),
            step.worst.0,
            step.worst.1,
        ));
    }
    text += &said.join("; ");
    text.push('.');
    for other in all.iter().filter(|s| s.needs.is_some() && s.lost_on.is_empty()) {
        let needs = other.needs.as_deref().unwrap_or_default();
        let _ = write!(
            text,
            " With {needs}: {} {:.2} ({}).",
            other.rung,
            other.share(),
            cost(other.cost)
        );
    }
    let against = contradictions(&steps);
    if !against.is_empty() {
        let _ = write!(text, " On single scenes the order is another: {}.", against.join("; "));
    }
    let beaten: Vec<&str> = all
        .iter()
        .filter(|s| s.needs.is_none() && !steps.iter().any(|f| f.rung == s.rung))
        .filter(|s| {
            all.iter().any(|a| a.cost < s.cost && a.needs.is_none() && a.share() < s.share())
        })
        .map(|s| s.rung.as_str())
        .collect();
    if !beaten.is_empty() {
        let _ = write!(text, " Beaten by a cheaper rung on the mean: {}.", beaten.join(", "));
    }
    let swaps: Vec<String> =
        all.iter().filter_map(|s| Some(format!("{} {:.1} %", s.rung, s.swaps_pct?))).collect();
    if !swaps.is_empty() {
        let _ = write!(text, " Swapped or lost tracks: {}.", swaps.join(", "));
    }
    Some(text)
}

/// Rungs of the front that are worse than a cheaper one of it, with the scenes.
fn contradictions(steps: &[&Standing]) -> Vec<String> {
    let mut out = Vec::new();
    for (number, dear) in steps.iter().enumerate() {
        let Some(cheap) = number.checked_sub(1).map(|k| steps[k]) else { continue };
        let worse: Vec<&str> = dear
            .shares
            .iter()
            .zip(&cheap.shares)
            .filter(|((_, d), (_, c))| *d > (1.0 + CONTRADICTS) * c)
            .map(|((scene, _), _)| scene.as_str())
            .collect();
        if !worse.is_empty() {
            let more = if worse.len() > 4 {
                format!(" and {} more", worse.len() - 4)
            } else {
                String::new()
            };
            let named = worse.iter().take(4).copied().collect::<Vec<_>>().join(", ");
            out.push(format!("{} is worse than {} on {named}{more}", dear.rung, cheap.rung));
        }
    }
    out
}

/// What the budget buys: one line.
#[must_use]
pub fn recommendation(report: &Report, budget_us: f64, targets: u64) -> String {
    let of = |group: &str| report.outcomes.iter().find(|o| o.ladder.group == group);
    let asked = format!(
        "{budget_us} µs for a target and scan, {targets} targets ({} a scan)",
        duration(budget_us * 1e3 * targets as f64)
    );
    let Some(filters) = of("filters") else {
        return format!("{asked}: the group filters was not measured, nothing to recommend.");
    };
    let filters: Vec<Standing> = standings(filters)
        .into_iter()
        .filter(|s| s.needs.is_none() && s.lost_on.is_empty())
        .collect();
    let methods = of("association").map_or_else(Vec::new, |o| methods_for(o, targets));
    let none = vec![Method { name: None, ns: 0.0, swaps: 0.0 }];
    let methods = if methods.is_empty() { none } else { methods };
    let mut best: Option<(f64, f64, &Standing, &Method)> = None;
    let mut cheapest: Option<(f64, &Standing)> = None;
    for filter in &filters {
        for method in &methods {
            let ns = filter.cost + method.ns;
            if cheapest.is_none_or(|(least, _)| ns < least) {
                cheapest = Some((ns, filter));
            }
            // Both are shares: of the plots' error, and of the tracks.
            let worth = filter.judged() + method.swaps;
            let fits = ns <= 1e3 * budget_us;
            if fits && best.is_none_or(|(b, before, ..)| (worth, ns) < (b, before)) {
                best = Some((worth, ns, filter, method));
            }
        }
    }
    let Some((_, ns, filter, method)) = best else {
        let least = cheapest.map_or_else(String::new, |(ns, f)| {
            format!("; the cheapest, {}, takes {}", f.rung, duration(ns))
        });
        return format!("{asked}: no rung fits{least}.");
    };
    let mut text = format!("{asked}: filter = \"{}\"", filter.rung);
    if let Some(name) = &method.name {
        let _ = write!(text, ", association = \"{name}\"");
    }
    let _ = write!(text, ": {} of it, error {:.2} of the plots'", duration(ns), filter.judged());
    if filter.held_out.is_some() {
        text += " on the scenes held out";
    }
    let _ = write!(text, " (worst {:.2}, {})", filter.worst.0, filter.worst.1);
    if method.name.is_some() {
        let _ = write!(text, ", {:.1} % of tracks that meet swapped or lost", 100.0 * method.swaps);
    }
    let dearer = filters
        .iter()
        .find(|s| s.cost > filter.cost && s.judged() < (1.0 - WORTH_SAYING) * filter.judged());
    if let Some(next) = dearer {
        let _ = write!(
            text,
            "; {} more would buy {} ({:.0} % less)",
            duration(next.cost - filter.cost),
            next.rung,
            100.0 * (1.0 - next.judged() / filter.judged())
        );
    }
    text.push('.');
    text
}

/// A way of associating at some number of targets.
#[derive(Clone, Debug)]
struct Method {
    name: Option<String>,
    /// A target and scan.
    ns: f64,
    /// Share of tracks swapped or lost.
    swaps: f64,
}

/// The methods with their time at the measured number of targets next to the one asked for.
fn methods_for(outcome: &Outcome, targets: u64) -> Vec<Method> {
    let size = |scene: &str| scene.rsplit('_').next().and_then(|n| n.parse::<f64>().ok());
    let off = |n: f64| libm::log(n / targets.max(1) as f64).abs();
    let sizes = outcome.rows.iter().filter_map(|r| size(&r.scene));
    let Some(nearest) = sizes.min_by(|a, b| off(*a).total_cmp(&off(*b))) else { return Vec::new() };
    let mut out: Vec<Method> = Vec::new();
    for row in &outcome.rows {
        if out.iter().any(|m| m.name.as_deref() == Some(row.rung.as_str())) {
            continue;
        }
        let own = || outcome.rows.iter().filter(|r| r.rung == row.rung);
        let near = own().filter(|r| size(&r.scene) == Some(nearest));
        let ns = median(near.filter_map(|r| r.ns_per_update).collect());
        let swaps = mean(own().filter_map(|r| r.swaps_pct)).map(|s| s / 100.0);
        if let (Some(ns), Some(swaps)) = (ns, swaps) {
            out.push(Method { name: Some(row.rung.clone()), ns, swaps });
        }
    }
    out
}

/// Budgets that are recommended for where nobody asks for one: µs for a target and scan, targets.
pub const BUDGETS: [(f64, u64); 4] = [(0.1, 10_000), (0.5, 1_000), (5.0, 1_000), (20.0, 100)];

/// The first screen: one picture over all scenes of the filters, and what to take.
pub(crate) fn first_screen(report: &Report) -> String {
    let mut out = String::new();
    if let Some(outcome) = report.outcomes.iter().find(|o| o.ladder.group == "filters") {
        let _ = write!(
            out,
            "<section id=\"overview\"><figure class=\"first\"><figcaption><b>All scenes at once</b>: geometric mean of the error as a share of \
             the plots'. Circles: scenes that something was chosen on. Diamonds: scenes held out. The stepped line joins \
             the circles that nothing beats. Lines: told when motion changes and which legs are steady, no filter can be lower.</figcaption>{}</figure>",
            picture(outcome)
        );
        out.push_str("</section>");
    }
    let asked: Vec<(f64, u64)> = report.budget.map_or_else(|| BUDGETS.to_vec(), |one| vec![one]);
    if report.outcomes.iter().any(|o| o.ladder.group == "filters") {
        out.push_str("<h2>What to take</h2><ul class=\"take\">");
        for (budget_us, targets) in asked {
            let _ =
                write!(out, "<li>{}</li>", escaped(&recommendation(report, budget_us, targets)));
        }
        out.push_str("</ul>");
    }
    out
}

/// Share against time of every rung, chosen-on and held-out scenes apart.
fn picture(outcome: &Outcome) -> String {
    let standings = standings(outcome);
    let row = |s: &Standing, share: f64, held: bool| Row {
        rung: s.rung.clone(),
        needs: held.then(|| "held out".to_owned()),
        rmse_m: Some(share),
        ns_per_update: Some(s.cost),
        ..Row::default()
    };
    let mut rows: Vec<Row> = Vec::new();
    for s in &standings {
        rows.extend(s.chosen_on.map(|share| row(s, share, false)));
        rows.extend(s.held_out.map(|share| row(s, share, true)));
    }
    let bound_of = |held: bool| {
        let scenes = outcome.ladder.scenes.iter();
        typical(scenes.filter(|s| outcome.ladder.held_out.contains(&s.name) == held).filter_map(
            |s| {
                let found = outcome.bounds.iter().find(|b| b.scene == s.name && b.label == LEGS)?;
                Some(found.error / basis(outcome, &s.name)?)
            },
        ))
    };
    let line = |held: bool, label: &str| {
        bound_of(held).map(|error| Bound {
            group: String::new(),
            scene: String::new(),
            label: label.to_owned(),
            error,
            mse_reduction_pct: None,
        })
    };
    let bounds: Vec<Bound> =
        [line(false, "bound: scenes chosen on"), line(true, "bound: scenes held out")]
            .into_iter()
            .flatten()
            .collect();
    let ladder = Ladder {
        error_label: "error over the plots'".into(),
        draws: Draws::Position,
        ..Ladder::default()
    };
    let (rows, bounds): (Vec<&Row>, Vec<&Bound>) = (rows.iter().collect(), bounds.iter().collect());
    chart(&ladder, &rows, &bounds)
}

const LEGS: &str = "bound: + which legs are steady";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SceneAbout;

    /// Two scenes, one held out: `cheap` and `dear` change places there, `lossy` loses a track, `told` has a map.
    fn report() -> Report {
        let row = |scene: &str, rung: &str, ns: f64, rmse: f64| Row {
            group: "filters".into(),
            scene: scene.into(),
            rung: rung.into(),
            rmse_m: Some(rmse),
            ns_per_update: Some(ns),
            lost_pct: Some(if rung == "lossy" { 1.0 } else { 0.0 }),
            needs: (rung == "told").then(|| "a map".to_owned()),
            ..Row::default()
        };
        let mut rows = Vec::new();
        for (scene, errors) in [("a", [2.0, 1.0, 0.1, 0.5]), ("b", [2.0, 2.4, 0.1, 0.5])] {
            for (rung, (ns, error)) in ["cheap", "dear", "lossy", "told"]
                .iter()
                .zip([20.0, 900.0, 10.0, 50.0].iter().zip(errors))
            {
                rows.push(row(scene, rung, *ns, error));
            }
        }
        let bounds = ["a", "b"].map(|scene| Bound {
            group: "filters".into(),
            scene: scene.into(),
            label: RAW.into(),
            error: 4.0,
            mse_reduction_pct: None,
        });
        let about = |name: &str| SceneAbout { name: name.into(), about: String::new() };
        let ladder = Ladder {
            group: "filters".into(),
            scenes: vec![about("a"), about("b")],
            held_out: vec!["b".into()],
            ..Ladder::default()
        };
        let swaps = |rung: &str, ns: f64, swaps: f64| Row {
            swaps_pct: Some(swaps),
            gospa: Some(1.0),
            ..row("crossing_1000", rung, ns, 1.0)
        };
        let association = Outcome {
            ladder: Ladder {
                group: "association".into(),
                scenes: vec![about("crossing_1000")],
                draws: Draws::Gospa,
                ..Ladder::default()
            },
            rows: vec![swaps("nearest", 40.0, 20.0), swaps("joint", 400.0, 2.0)],
            ..Outcome::default()
        };
        Report {
            machine: String::new(),
            commit: String::new(),
            seed: 1,
            quick: true,
            budget: None,
            outcomes: vec![
                Outcome { ladder, rows, bounds: bounds.to_vec(), ..Outcome::default() },
                association,
            ],
        }
    }

    #[test]
    fn scenes_held_out_stand_apart_and_contradictions_are_said() {
        let report = report();
        let all = standings(&report.outcomes[0]);
        let names: Vec<&str> = all.iter().map(|s| s.rung.as_str()).collect();
        assert_eq!(names, ["lossy", "cheap", "told", "dear"], "cheapest first");
        assert_eq!((all[1].chosen_on, all[1].held_out), (Some(0.5), Some(0.5)));
        assert!((all[3].held_out.unwrap() - 0.6).abs() < 1e-12 && all[3].worst.1 == "b");
        let text = sentence(&report.outcomes[0]).expect("two scenes");
        assert!(text.contains("2 scenes (1 of them held out)"), "{text}");
        assert!(text.contains("dear is worse than cheap on b"), "{text}");
        assert!(text.contains("With a map: told"), "{text}");
        assert!(!text.contains("lossy 0"), "what loses tracks is on no front: {text}");
    }

    #[test]
    fn a_budget_buys_what_fits_and_is_best_where_nothing_was_chosen() {
        let report = report();
        // All fits, and `dear` is worse on the scene held out.
        let text = recommendation(&report, 5.0, 1000);
        assert!(text.contains("\"cheap\", association = \"joint\": 420 ns"), "{text}");
        let text = recommendation(&report, 0.1, 1000);
        assert!(text.contains("association = \"nearest\": 60 ns"), "{text}");
        let text = recommendation(&report, 0.05, 1000);
        assert!(text.contains("no rung fits; the cheapest, cheap, takes 60 ns"), "{text}");
        let page = first_screen(&report);
        assert!(page.contains("<svg") && page.matches("<li>").count() == BUDGETS.len());
    }
}
