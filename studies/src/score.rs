//! The score of a recorded run for people and programs: text, JSON, one page.

use crate::chart::escaped;
use crate::report::{STYLE, asks, percent, requirement_table};
use crate::requirements;
use models::score::areas::AreaMap;
use models::score::recording::{Recording, Report};
use models::score::requirements::Verdict;
use models::score::robust::quantile;
use models::score::run::{AreaScore, Rules, Score, score};
use serde_json::{Value, json};
use std::fmt::Write;

/// A scored recording.
#[derive(Clone, Debug)]
pub struct ScoreReport {
    /// What was scored, in one line.
    pub title: String,
    /// What the reader should know (where areas come from, what was left out).
    pub notes: Vec<String>,
    /// What was found.
    pub score: Score,
    /// The requirements held against it.
    pub verdicts: Vec<Verdict>,
    /// The same of the tracks one scan earlier, as the next scan's plots revise them, where they were recorded: for a
    /// consumer that can wait.
    pub second_ago: Option<(Score, Vec<Verdict>)>,
}

/// One line of the table of areas.
struct Line {
    name: &'static str,
    values: [Option<f64>; 13],
}

/// Heads of the table of areas: name, unit, digits.
const COLUMNS: [(&str, &str, usize); 13] = [
    ("target scans", "", 0),
    ("reports", "", 0),
    ("position rms", "m", 2),
    ("95 %", "m", 2),
    ("99 %", "m", 2),
    ("speed 90 %", "m/s", 2),
    ("course 90 %", "°", 1),
    ("behind, mean", "s", 3),
    ("reported", "%", 2),
    ("false beyond 60 m", "%", 3),
    ("without coasting", "%", 3),
    ("label right", "%", 2),
    ("label wrong", "%", 2),
];

fn line(area: &AreaScore) -> Line {
    let share = |hits: u64, of: u64| (of > 0).then(|| 100.0 * hits as f64 / of as f64);
    let speeds: Vec<f64> = area.speed.iter().map(|s| s.0).collect();
    let behind = area.behind_s.iter().sum::<f64>() / area.behind_s.len().max(1) as f64;
    let (reported, due) = area.reports_due(1.0);
    let (far, without_coasting) = area.false_reports(60.0);
    let reports = area.nearest_target_m.len() as u64;
    Line {
        name: area.area.name(),
        values: [
            Some(area.target_scans() as f64),
            Some(area.nearest_target_m.len() as f64),
            area.rmse_m(),
            quantile(&area.position_m, 0.95),
            quantile(&area.position_m, 0.99),
            quantile(&speeds, 0.9),
            quantile(&area.course_rad, 0.9).map(f64::to_degrees),
            (!area.behind_s.is_empty()).then_some(behind),
            share(reported, due),
            share(far, reports),
            share(without_coasting, reports),
            share(area.right_labels, area.labels_due),
            share(area.wrong_labels, area.labels_due),
        ],
    }
}

impl ScoreReport {
    /// Scores a recording that is in order, and judges it.
    #[must_use]
    pub fn of(
        title: String,
        notes: Vec<String>,
        recording: &Recording,
        areas: &AreaMap,
        rules: &Rules,
    ) -> Self {
        let score = score(recording, areas, rules);
        let verdicts = requirements::all().iter().map(|r| r.judge(&score)).collect();
        Self { title, notes, score, verdicts, second_ago: None }
    }

    /// With the second publication: `reports` as they were revised one scan later. Each is published when the scan after it
    /// ends, so its latency is a scan more, and of the last scan there is none: truth behind the last of them is left out.
    #[must_use]
    pub fn with_second_ago(
        mut self,
        recording: &Recording,
        reports: Vec<Report>,
        areas: &AreaMap,
        rules: &Rules,
    ) -> Self {
        if reports.is_empty() {
            return self;
        }
        let mut revised = Recording { reports, ..recording.clone() };
        revised.put_in_order();
        let last = revised.reports.last().map(|r| r.time);
        for target in &mut revised.targets {
            target.path.retain(|p| Some(p.time) <= last);
        }
        let found = score(&revised, areas, rules);
        let verdicts = requirements::all().iter().map(|r| r.judge(&found)).collect();
        self.second_ago = Some((found, verdicts));
        self
    }

    /// Measures of the run as a whole: key, words, value, unit.
    fn whole(&self) -> Vec<(&'static str, &'static str, Option<f64>, &'static str)> {
        let s = &self.score;
        let ground = s.position_errors_m(false);
        let delays: Vec<f64> = s.targets.iter().filter_map(|t| t.delay_s).collect();
        let delay = delays.iter().sum::<f64>() / delays.len().max(1) as f64;
        let count = |n: u64| Some(n as f64);
        let mut all = vec![
            ("scans", "scans", count(s.scans), ""),
            ("targets", "targets", count(s.targets.len() as u64), ""),
            ("tracks", "tracks", count(s.tracks), ""),
            (
                "mse_reduction_pct",
                "reduction of the mean squared error against the radars' plots",
                s.mse_reduction_pct(),
                "%",
            ),
            ("plot_rmse_m", "position error of the radars' plots, rms", s.plot_rmse_m, "m"),
            ("rmse_m", "position error of the tracks, rms", s.rmse_m(), "m"),
            ("p95_m", "position error on the ground, 95 %", quantile(&ground, 0.95), "m"),
            ("p99_m", "position error on the ground, 99 %", quantile(&ground, 0.99), "m"),
            ("gospa_m", "GOSPA, mean of the scans (cut-off 20 m)", Some(s.gospa.total_m), "m"),
            ("gospa_per_root_m", "the same per root of targets", Some(s.gospa.per_root_m), "m"),
            (
                "gospa_localisation_m2",
                "of its square: localisation",
                Some(s.gospa.localisation_m2),
                "m²",
            ),
            ("gospa_missed_m2", "of its square: missed targets", Some(s.gospa.missed_m2), "m²"),
            ("gospa_false_m2", "of its square: false tracks", Some(s.gospa.false_m2), "m²"),
            ("swaps", "swaps (a track goes over to another target)", count(s.swaps), ""),
            ("breaks", "breaks (a target's track is followed by another)", count(s.breaks), ""),
            ("false_tracks", "tracks that never followed a target", count(s.false_tracks), ""),
            (
                "missed_targets",
                "targets that no track followed",
                count(s.missed_targets() as u64),
                "",
            ),
            (
                "delay_s",
                "from a target's appearance to its first report, mean",
                (!delays.is_empty()).then_some(delay),
                "s",
            ),
            ("latency_s", "from validity to publication, mean", s.latency_s, "s"),
        ];
        if let Some((later, verdicts)) = &self.second_ago {
            // What was revised has no velocity: rows about it are left out of both counts.
            let met = |of: fn(&(&Verdict, &Verdict)) -> Option<bool>| {
                let both = self.verdicts.iter().zip(verdicts);
                let both = both.filter(|(now, ago)| now.met.is_some() && ago.met.is_some());
                both.filter(|pair| of(pair) == Some(true)).count() as f64
            };
            let ground = later.position_errors_m(false);
            all.extend([
                (
                    "second_ago_rmse_m",
                    "position error one scan earlier, as revised, rms",
                    later.rmse_m(),
                    "m",
                ),
                ("second_ago_p95_m", "the same on the ground, 95 %", quantile(&ground, 0.95), "m"),
                (
                    "requirements_met",
                    "requirements met, of those measured in both",
                    Some(met(|(now, _)| now.met)),
                    "",
                ),
                (
                    "second_ago_requirements_met",
                    "the same one scan earlier",
                    Some(met(|(_, ago)| ago.met)),
                    "",
                ),
            ]);
        }
        all
    }

    /// Tables for a terminal.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut out = format!("{}\n", self.title);
        for note in &self.notes {
            let _ = writeln!(out, "  {note}");
        }
        out.push('\n');
        for (_, words, value, unit) in self.whole() {
            let value = value.map_or("-".into(), |v| rounded(v, 3));
            let _ = writeln!(out, "{words:62} {value:>12} {unit}");
        }
        let _ = write!(out, "\n{:10}", "area");
        for (name, unit, _) in COLUMNS {
            let head = if unit.is_empty() { name.to_owned() } else { format!("{name} {unit}") };
            let _ = write!(out, " {head:>16}");
        }
        out.push('\n');
        for area in &self.score.areas {
            let line = line(area);
            let _ = write!(out, "{:10}", line.name);
            for (value, (_, _, digits)) in line.values.iter().zip(COLUMNS) {
                let text = value.map_or("-".into(), |v| format!("{v:.digits$}"));
                let _ = write!(out, " {text:>16}");
            }
            out.push('\n');
        }
        out.push_str("\ntarget        scans  reported %   first after s     rms m  tracks\n");
        for t in &self.score.targets {
            let number = |v: Option<f64>| v.map_or("-".into(), |v| format!("{v:.2}"));
            let _ = writeln!(
                out,
                "{:11} {:7} {:11.2} {:>15} {:>9}  {}",
                t.name,
                t.scans,
                100.0 * t.reported as f64 / t.scans.max(1) as f64,
                number(t.delay_s),
                number(t.rmse_m),
                numbers(&t.tracks),
            );
        }
        out.push_str("\nrequirements\n");
        for v in &self.verdicts {
            let r = &v.requirement;
            let found = v.found.map_or("-".into(), |f| format!("{} of {}", percent(f), v.samples));
            let _ = writeln!(
                out,
                "{:8} {:17} {:39} {:33} {:>20}  {}",
                r.standard,
                r.area,
                r.name,
                asks(r),
                found,
                word(v),
            );
            if let Some(words) = &v.remark {
                let _ = writeln!(out, "{:8} {words}", "");
            }
        }
        out
    }

    /// One JSON object.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let whole: serde_json::Map<String, Value> =
            self.whole().into_iter().map(|(key, _, v, _)| (key.to_owned(), json!(v))).collect();
        let key = |name: &str| {
            let mut key = String::new();
            for c in name.chars() {
                match c {
                    'a'..='z' | 'A'..='Z' | '0'..='9' => key.push(c.to_ascii_lowercase()),
                    '%' => key.push_str("pct"),
                    _ if !key.ends_with('_') => key.push('_'),
                    _ => {}
                }
            }
            key.trim_end_matches('_').to_owned()
        };
        let areas: Vec<Value> = self
            .score
            .areas
            .iter()
            .map(|area| {
                let line = line(area);
                let mut object = serde_json::Map::new();
                object.insert("area".into(), json!(line.name));
                for (value, (name, unit, _)) in line.values.iter().zip(COLUMNS) {
                    let unit = unit.replace('°', "deg").replace("m/s", "ms").replace('%', "pct");
                    object.insert(key(&format!("{name} {unit}")), json!(value));
                }
                Value::Object(object)
            })
            .collect();
        let targets: Vec<Value> = self
            .score
            .targets
            .iter()
            .map(|t| {
                json!({
                    "name": t.name, "scans": t.scans, "reported": t.reported, "delay_s": t.delay_s,
                    "rmse_m": t.rmse_m, "tracks": t.tracks,
                })
            })
            .collect();
        let rows = |verdicts: &[Verdict]| -> Vec<Value> { verdicts.iter().map(row).collect() };
        let mut all = json!({
            "title": self.title, "notes": self.notes, "run": whole, "areas": areas,
            "targets": targets, "requirements": rows(&self.verdicts),
        });
        if let Some((_, verdicts)) = &self.second_ago {
            all["second_ago_requirements"] = json!(rows(verdicts));
        }
        all
    }

    /// A page without anything from elsewhere.
    #[must_use]
    pub fn to_html(&self) -> String {
        let mut out = format!(
            "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">\
             <meta name=\"viewport\" content=\"width=device-width\"><title>Score</title><style>{STYLE}</style></head>\
             <body><header><h1>Score of a run</h1><p>{}</p></header>",
            escaped(&self.title)
        );
        let judged: Vec<&Verdict> = self.verdicts.iter().filter(|v| v.met.is_some()).collect();
        let met = judged.iter().filter(|v| v.met == Some(true)).count();
        let _ = write!(
            out,
            "<p class=\"closing\">{met} of the {} requirements that this run could be held against are met.</p>",
            judged.len()
        );
        for note in &self.notes {
            let _ = write!(out, "<p>{}</p>", escaped(note));
        }
        out.push_str("<h2>The run</h2><table class=\"gains\"><tbody>");
        for (_, words, value, unit) in self.whole() {
            let value = value.map_or("–".into(), |v| rounded(v, 3));
            let _ = write!(out, "<tr><td>{}</td><td>{value} {unit}</td></tr>", escaped(words));
        }
        out.push_str("</tbody></table><h2>Area by area</h2>");
        out.push_str(
            "<p>Errors of reports that follow a target, each against the truth of its own time. \"Behind\" is the \
             error along the path over the speed, of targets faster than 3 m/s. \"Reported\" counts every scan of \
             every target from its first moment, so the time until a track is confirmed counts as missed. \"False\" are reports far from every target; \"without \
             coasting\" leaves out those of tracks whose target ended less than 15 s before. No requirement is judged by \
             the latter.</p>\
             <div class=\"wide\"><table class=\"gains\"><thead><tr><th>area</th>",
        );
        for (name, unit, _) in COLUMNS {
            let _ = write!(out, "<th>{name}<br>{unit}</th>");
        }
        out.push_str("</tr></thead><tbody>");
        for area in &self.score.areas {
            let line = line(area);
            let _ = write!(out, "<tr><td>{}</td>", line.name);
            for (value, (_, _, digits)) in line.values.iter().zip(COLUMNS) {
                let text = value.map_or("–".into(), |v| format!("{v:.digits$}"));
                let _ = write!(out, "<td>{text}</td>");
            }
            out.push_str("</tr>");
        }
        out.push_str("</tbody></table></div><h2>Target by target</h2><div class=\"wide\"><table class=\"gains\"><thead>\
                      <tr><th>target</th><th>scans</th><th>reported, %</th><th>first report after, s</th>\
                      <th>rms error, m</th><th>tracks</th></tr></thead><tbody>");
        for t in &self.score.targets {
            let number = |v: Option<f64>| v.map_or("–".into(), |v| format!("{v:.2}"));
            let _ = write!(
                out,
                "<tr><td>{}</td><td>{}</td><td>{:.2}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
                escaped(&t.name),
                t.scans,
                100.0 * t.reported as f64 / t.scans.max(1) as f64,
                number(t.delay_s),
                number(t.rmse_m),
                numbers(&t.tracks),
            );
        }
        let _ = write!(
            out,
            "</tbody></table></div><h2>Requirements</h2><p>Values: {}.</p>",
            escaped(&requirements::source())
        );
        match &self.second_ago {
            Some((_, later)) => {
                let names = ["this run", "one scan earlier, as revised"];
                requirement_table(&mut out, &names, &[&self.verdicts, later]);
            }
            None => requirement_table(&mut out, &["this run"], &[&self.verdicts]),
        }
        out.push_str("</body></html>\n");
        out
    }
}

/// A verdict for programs.
fn row(v: &Verdict) -> Value {
    let r = &v.requirement;
    json!({
        "standard": r.standard, "area": r.area, "name": r.name, "asks": asks(r),
        "probability": r.probability, "at_least": r.at_least, "found": v.found,
        "samples": v.samples, "met": v.met, "enough": v.enough, "remark": v.remark,
    })
}

fn word(v: &Verdict) -> &'static str {
    match (v.met, v.enough) {
        (Some(true), true) => "PASS",
        (Some(true), false) => "PASS (too few to show it)",
        (Some(false), _) => "FAIL",
        (None, _) => "not measured",
    }
}

fn numbers(tracks: &[u64]) -> String {
    let shown: Vec<String> = tracks.iter().take(12).map(u64::to_string).collect();
    let more =
        if tracks.len() > 12 { format!(" … ({} in all)", tracks.len()) } else { String::new() };
    shown.join(" ") + &more
}

/// Whole numbers without digits, others with `digits`.
fn rounded(value: f64, digits: usize) -> String {
    if value == value.round() { format!("{value:.0}") } else { format!("{value:.digits$}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{profiles, zurich};
    use models::score::areas::AreaRules;

    #[test]
    fn a_run_is_reported_in_all_three_forms() {
        let scene = zurich::scene().expect("ships");
        let seen = profiles::see(&scene, 2, 60.0).expect("sound");
        let (reports, _) = profiles::track(&seen, &scene.tracking_config(), &scene.flight_list);
        let mut recording =
            Recording { targets: profiles::targets(&scene, 60.0), reports, plots: seen.radar };
        assert_eq!(recording.put_in_order(), 0);
        let areas = AreaMap::of(&scene.airport.layout, AreaRules::default());
        let report = ScoreReport::of(
            "a <run>".into(),
            vec!["note".into()],
            &recording,
            &areas,
            &Rules::default(),
        );
        // What can wait a second is nearer, and its own rows are judged.
        let mut tracker = models::fusion::Tracker::new(models::fusion::TrackingConfig::accurate());
        let mut later = Vec::new();
        for (to, plots) in &seen.scans {
            for track in tracker.scan(*to, plots, &scene.flight_list) {
                let Some(lag) = track.second_ago else { continue };
                let now = profiles::report_of(&track, *to);
                later.extend(now.map(|r| Report {
                    time: lag.time,
                    position_m: lag.position_m,
                    velocity_mps: None,
                    ..r
                }));
            }
        }
        let plain = report.to_json();
        assert!(plain["run"].get("second_ago_rmse_m").is_none());
        let report = report.with_second_ago(&recording, later, &areas, &Rules::default());
        let run = &report.to_json()["run"];
        let [now, ago] = ["rmse_m", "second_ago_rmse_m"].map(|k| run[k].as_f64().expect("tracks"));
        assert!(ago < 0.95 * now, "{ago} {now}");
        assert!(report.to_html().contains("one scan earlier, as revised"));
        let text = report.to_text();
        assert!(text.contains("PASS") && text.contains("runway") && text.contains("SWR137H"));
        let html = report.to_html();
        assert!(html.contains("a &lt;run&gt;") && html.ends_with("</html>\n"));
        assert!(!html.contains("http") && !html.contains("<script"));
        let json = report.to_json();
        assert!(json["run"]["rmse_m"].as_f64().expect("tracks") < 6.0);
        assert_eq!(json["requirements"].as_array().expect("list").len(), 89);
        assert!(json["areas"][0].get("position_rms_m").is_some(), "{}", json["areas"][0]);
        assert!(json["areas"][0].get("95_pct_m").is_some(), "{}", json["areas"][0]);
    }

    /// One target, tracked without an error for 30 scans; the last scan is nowhere revised, and what was revised has no velocity.
    #[test]
    fn what_was_revised_is_held_against_what_it_can_know() {
        use models::frames::{Point2, Vector2};
        use models::score::recording::{Target, TruthPoint};
        use models::time::SimTime;
        let velocity_mps = Vector2::new(10.0, 0.0);
        let at = |k: u32| (SimTime::from_s(f64::from(k)), Point2::new(10.0 * f64::from(k), 0.0));
        let point = |k| {
            let (time, position_m) = at(k);
            TruthPoint { time, position_m, velocity_mps, height_m: Some(0.0) }
        };
        let report = |k, velocity_mps| {
            let (time, position_m) = at(k);
            let label = "A".to_owned();
            Report { track: 1, time, published: None, position_m, velocity_mps, label }
        };
        let path: Vec<TruthPoint> = (0..30).map(point).collect();
        // All of it on a taxiway.
        let mut layout = zurich::scene().expect("ships").airport.layout;
        (layout.runways, layout.stands) = (Vec::new(), Vec::new());
        layout.nodes.truncate(2);
        for (node, x) in layout.nodes.iter_mut().zip([-100.0, 500.0]) {
            node.position_m = Point2::new(x, 0.0);
        }
        layout.edges.truncate(1);
        let edge = &mut layout.edges[0];
        (edge.from, edge.to, edge.runway, edge.width_m) = (0, 1, false, 23.0);
        let areas = AreaMap::of(&layout, AreaRules::default());
        let recording = Recording {
            targets: vec![Target { name: "A".into(), path }],
            reports: (0..30).map(|k| report(k, Some(velocity_mps))).collect(),
            ..Recording::default()
        };
        let later = (0..29).map(|k| report(k, None)).collect();
        let rules = Rules::default();
        let scored = ScoreReport::of(String::new(), Vec::new(), &recording, &areas, &rules)
            .with_second_ago(&recording, later, &areas, &rules);
        let json = scored.to_json();
        let run = |key: &str| json["run"][key].as_f64().expect("a number");
        assert!(run("requirements_met") > 20.0);
        assert_eq!(run("requirements_met"), run("second_ago_requirements_met"));
        let failed = |key: &str| {
            let list = json[key].as_array().expect("a list").iter();
            list.filter(|v| v["met"] == false).count()
        };
        assert_eq!((failed("requirements"), failed("second_ago_requirements")), (0, 0));
    }
}
