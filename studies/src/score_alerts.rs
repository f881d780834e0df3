//! The alerts of a safety net, ours or somebody else's, held against those of the rules on exact truth: the score for
//! people and programs, as text, CSV, JSON and one page.
//!
//! What counts as detected, missed, false and a nuisance: [`models::control::scoring`].

use crate::chart::escaped;
use crate::report::STYLE;
use models::control::alert::AlertKind;
use models::control::scoring::{Judged, KindScore, Told, Verdict, in_all, judge, score};
use serde_json::{Value, json};
use std::fmt::Write;

/// A scored safety net.
#[derive(Clone, Debug)]
pub struct AlertReport {
    /// What was scored, in one line.
    pub title: String,
    /// What the reader should know.
    pub notes: Vec<String>,
    /// Hours of the run.
    pub hours: f64,
    /// Movements served in the run.
    pub movements: u32,
    /// Scores by kind.
    pub scores: Vec<KindScore>,
    reference: Vec<Told>,
    found: Vec<Told>,
    judged: Judged,
}

/// Heads of the table: key, words for a page.
const COLUMNS: [(&str, &str); 13] = [
    ("kind", "kind"),
    ("reference", "true"),
    ("detected", "detected"),
    ("detected_percent", "detected, %"),
    ("missed", "missed"),
    ("response_median_s", "response, median, s"),
    ("response_95_percent_s", "response, 95 %, s"),
    ("false", "false"),
    ("false_per_hour", "false per hour"),
    ("false_per_100_movements", "false per 100 movements"),
    ("nuisance", "nuisance"),
    ("nuisance_per_hour", "nuisance per hour"),
    ("nuisance_per_100_movements", "nuisance per 100 movements"),
];

/// Missed and false alerts that a text or page names at most.
const NAMED: usize = 40;

/// Kinds by numbers of message types (ASTERIX category 004), where the safety net has no others: a roll with one that
/// crosses (13) is a roll (12).
fn by_message_types(reference: &mut [Told], found: &mut [Told]) -> bool {
    if found.is_empty() || !found.iter().all(|t| t.kind.parse::<u8>().is_ok()) {
        return false;
    }
    for told in found.iter_mut().filter(|t| t.kind == "13") {
        told.kind = "12".into();
    }
    for told in reference {
        if let Some(kind) = AlertKind::of(&told.kind) {
            told.kind = kind.asterix().to_string();
        }
    }
    true
}

impl AlertReport {
    /// Scores the alerts of a safety net (`found`) against the true ones of a run that lasted `hours` and in which so many
    /// `movements` were served.
    #[must_use]
    pub fn of(
        title: String,
        mut notes: Vec<String>,
        mut reference: Vec<Told>,
        mut found: Vec<Told>,
        (hours, movements): (f64, u32),
    ) -> Self {
        if by_message_types(&mut reference, &mut found) {
            notes.push("Kinds are message types of ASTERIX category 004.".into());
        } else {
            let mut strange: Vec<&str> = found.iter().map(|t| t.kind.as_str()).collect();
            strange.retain(|kind| AlertKind::of(kind).is_none());
            strange.sort_unstable();
            let count = strange.len();
            strange.dedup();
            if count > 0 {
                notes.push(format!(
                    "{count} alerts are of kinds that the rules do not have ({}) and count as false: give them the rules' \
                     words (docs/control.md), or the message types of ASTERIX category 004 to all of them.",
                    strange.join(", ")
                ));
            }
        }
        let unknown = |t: &&Told| t.subjects.iter().all(|s| s.parse::<u32>().is_ok());
        let nameless = found.iter().filter(unknown).count();
        if nameless > 0 {
            notes.push(format!(
                "{nameless} alerts name track numbers in place of call signs: they can be right of nobody."
            ));
        }
        let (scores, judged) = (score(&reference, &found), judge(&reference, &found));
        Self { title, notes, hours, movements, scores, reference, found, judged }
    }

    /// The sum over all kinds.
    #[must_use]
    pub fn all(&self) -> KindScore {
        in_all(&self.scores)
    }

    /// The figures of a kind, in the order of the columns after the first.
    fn figures(&self, s: &KindScore) -> [Option<f64>; 12] {
        let count = |n: u32| Some(f64::from(n));
        let share =
            (s.reference > 0).then(|| 100.0 * f64::from(s.detected) / f64::from(s.reference));
        let per_hour = |n: u32| (self.hours > 0.0).then(|| f64::from(n) / self.hours);
        let per_hundred =
            |n: u32| (self.movements > 0).then(|| 100.0 * f64::from(n) / f64::from(self.movements));
        [
            count(s.reference),
            count(s.detected),
            share,
            count(s.missed()),
            s.response_s(0.5),
            s.response_s(0.95),
            count(s.false_alerts),
            per_hour(s.false_alerts),
            per_hundred(s.false_alerts),
            count(s.nuisance_alerts),
            per_hour(s.nuisance_alerts),
            per_hundred(s.nuisance_alerts),
        ]
    }

    fn rows(&self) -> Vec<KindScore> {
        let mut rows = self.scores.clone();
        rows.push(self.all());
        rows
    }

    /// One line an alert that was missed or is false, at most some.
    fn named(&self) -> Vec<String> {
        let missed = self.reference.iter().zip(&self.judged.responses_s);
        let missed = missed.filter(|(_, response)| response.is_none()).map(|(t, _)| (t, "missed"));
        let found = self.found.iter().zip(&self.judged.found);
        let found = found.filter(|(_, v)| **v != Verdict::Right).map(|(t, v)| (t, v.word()));
        let mut all: Vec<(&Told, &str)> = missed.chain(found).collect();
        all.sort_by(|a, b| a.0.on_s.total_cmp(&b.0.on_s).then(a.1.cmp(b.1)));
        let more = all.len().saturating_sub(NAMED);
        let line = |(t, what): (&Told, &str)| {
            format!("{:>10.1} s  {:8}  {:14}  {}", t.on_s, what, t.kind, t.subjects.join(" "))
        };
        let mut lines: Vec<String> = all.into_iter().take(NAMED).map(line).collect();
        lines.extend((more > 0).then(|| format!("… and {more} more (--json names all)")));
        lines
    }

    /// Tables for a terminal.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut out = format!("{}\n", self.title);
        for note in &self.notes {
            let _ = writeln!(out, "  {note}");
        }
        let _ = writeln!(out, "  {:.2} h, {} movements served\n", self.hours, self.movements);
        let heads = [
            "kind", "true", "detected", "%", "missed", "median s", "95 % s", "false", "per hour",
            "per 100", "nuisance", "per hour", "per 100",
        ];
        let _ = write!(out, "{:14}", heads[0]);
        heads[1..].iter().for_each(|head| {
            let _ = write!(out, " {head:>9}");
        });
        out.push('\n');
        for row in self.rows() {
            let _ = write!(out, "{:14}", row.kind);
            for figure in self.figures(&row) {
                let _ = write!(out, " {:>9}", shown(figure));
            }
            out.push('\n');
        }
        let named = self.named();
        if !named.is_empty() {
            let _ = write!(out, "\nmissed, false and nuisance alerts\n{}\n", named.join("\n"));
        }
        out
    }

    /// One row a kind, and one for all.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let mut out = COLUMNS.map(|(key, _)| key).join(",") + "\n";
        for row in self.rows() {
            let figures = self.figures(&row).map(|f| f.map_or(String::new(), |f| f.to_string()));
            let _ = writeln!(out, "{},{}", row.kind, figures.join(","));
        }
        out
    }

    /// One JSON object.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let row = |row: &KindScore| {
            let mut object = serde_json::Map::new();
            object.insert("kind".into(), json!(row.kind));
            for ((key, _), figure) in COLUMNS[1..].iter().zip(self.figures(row)) {
                object.insert((*key).into(), json!(figure));
            }
            Value::Object(object)
        };
        let told = |t: &Told| {
            let end_s = Some(t.end_s).filter(|s| s.is_finite());
            json!({"kind": t.kind, "subjects": t.subjects, "time_s": t.on_s, "end_s": end_s})
        };
        let with = |mut object: Value, key: &str, value: Value| {
            object[key] = value;
            object
        };
        let truth = self.reference.iter().zip(&self.judged.responses_s);
        let truth: Vec<Value> = truth.map(|(t, r)| with(told(t), "response_s", json!(r))).collect();
        let found = self.found.iter().zip(&self.judged.found);
        let found: Vec<Value> =
            found.map(|(t, v)| with(told(t), "verdict", json!(v.word()))).collect();
        json!({
            "title": self.title, "notes": self.notes, "hours": self.hours, "movements": self.movements,
            "kinds": self.scores.iter().map(row).collect::<Vec<_>>(), "all": row(&self.all()),
            "truth": truth, "alerts": found,
        })
    }

    /// A page without anything from elsewhere.
    #[must_use]
    pub fn to_html(&self) -> String {
        let mut out = format!(
            "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">\
             <meta name=\"viewport\" content=\"width=device-width\"><title>Score of alerts</title><style>{STYLE}</style></head>\
             <body><header><h1>Score of a safety net</h1><p>{}</p></header>",
            escaped(&self.title)
        );
        for note in &self.notes {
            let _ = write!(out, "<p>{}</p>", escaped(note));
        }
        let _ = write!(
            out,
            "<p>{:.2} h, {} movements served.</p><div class=\"wide\"><table class=\"gains\"><thead><tr>",
            self.hours, self.movements
        );
        for (_, words) in COLUMNS {
            let _ = write!(out, "<th>{words}</th>");
        }
        out.push_str("</tr></thead><tbody>");
        for row in self.rows() {
            let _ = write!(out, "<tr><td>{}</td>", escaped(&row.kind));
            for figure in self.figures(&row) {
                let _ = write!(out, "<td>{}</td>", shown(figure));
            }
            out.push_str("</tr>");
        }
        let _ = writeln!(
            out,
            "</tbody></table></div><h2>Missed, false and nuisance alerts</h2><pre>{}</pre></body></html>",
            escaped(&self.named().join("\n"))
        );
        out
    }
}

/// A figure for people: whole numbers without digits.
fn shown(figure: Option<f64>) -> String {
    match figure {
        None => "-".into(),
        Some(f) if f == f.round() => format!("{f:.0}"),
        Some(f) => format!("{f:.2}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(kind: &str, subjects: &str, on_s: f64) -> Told {
        Told {
            kind: kind.into(),
            subjects: subjects.split(' ').map(str::to_owned).collect(),
            on_s,
            end_s: on_s + 20.0,
            nearest_m: None,
        }
    }

    fn report(found: Vec<Told>) -> AlertReport {
        let reference = vec![
            told("RMCA_ARR", "A B", 100.0),
            told("RMCA_ROLL", "C D", 300.0),
            Told { nearest_m: Some(900.0), ..told("CATC_LND_LUP", "A B", 90.0) },
        ];
        AlertReport::of("x".into(), Vec::new(), reference, found, (0.5, 40))
    }

    #[test]
    fn every_form_has_the_same_figures() {
        let report = report(vec![
            told("RMCA_ARR", "A B", 102.0),
            told("CATC_LND_LUP", "A B", 90.0),
            told("STOPBAR", "Z", 500.0),
        ]);
        let all = report.to_json()["all"].clone();
        for (key, value) in [
            ("reference", 3.0),
            ("detected", 2.0),
            ("missed", 1.0),
            ("response_median_s", 0.0),
            ("response_95_percent_s", 2.0),
            ("false", 1.0),
            ("false_per_hour", 2.0),
            ("false_per_100_movements", 2.5),
            ("nuisance", 1.0),
            ("nuisance_per_hour", 2.0),
            ("nuisance_per_100_movements", 2.5),
        ] {
            assert_eq!(all[key], value, "{key}");
        }
        let csv = report.to_csv();
        let last: Vec<&str> = csv.lines().last().expect("a row").split(',').collect();
        assert_eq!(last[..3], ["all", "3", "2"]);
        assert_eq!(csv.lines().next().map(|l| l.split(',').count()), Some(13));
        assert_eq!(last.len(), 13);
        let text = report.to_text();
        for line in [
            "300.0 s  missed    RMCA_ROLL",
            "90.0 s  nuisance  CATC_LND_LUP",
            "500.0 s  false     STOPBAR",
        ] {
            assert!(text.contains(line), "{line}: {text}");
        }
        assert!(report.to_html().contains("<td>RMCA_ROLL</td>"));
        assert!(report.notes.is_empty(), "{:?}", report.notes);
    }

    #[test]
    fn a_net_that_speaks_asterix_is_scored_by_its_message_types() {
        let report = report(vec![
            told("9", "A B", 101.0),
            told("13", "C D", 300.0),
            told("38", "A B", 90.0),
        ]);
        let all = report.all();
        assert_eq!(
            (all.reference, all.detected, all.false_alerts, all.nuisance_alerts),
            (3, 3, 0, 1)
        );
        assert!(report.notes[0].contains("category 004"));
    }

    #[test]
    fn kinds_and_subjects_of_nobody_are_said_to_be_so() {
        let report = report(vec![told("RIMCAS", "A B", 101.0), told("RMCA_ARR", "17 18", 100.0)]);
        assert_eq!((report.all().detected, report.all().false_alerts), (0, 2));
        assert!(
            report.notes[0].starts_with("1 alerts are of kinds")
                && report.notes[0].contains("RIMCAS")
        );
        assert!(report.notes[1].starts_with("1 alerts name track numbers"));
        // A net that says nothing has missed all and disturbed nobody.
        let silent = self::report(Vec::new());
        assert_eq!((silent.all().missed(), silent.all().false_alerts), (3, 0));
    }
}
