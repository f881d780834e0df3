//! Which sensor set makes the safety net good enough: one picture, a row for each set, a column for each profile and
//! confirmation.

use crate::chart::escaped;
use crate::control_found::{CONFIRMATIONS, Flown, Found, PROFILES, SETS};
use std::fmt::Write;

/// Least share of the true alerts that is detected.
const DETECTED: f64 = 0.99;
/// Most false alerts per 100 movements.
const PER_HUNDRED: f64 = 1.0;
/// Longest response, s: the median and what 95 % stay within.
const RESPONSE_S: [f64; 2] = [1.0, 3.0];

/// Which of the goals are met: detected, response, false. A nuisance is one on exact truth too: it says nothing of the sensors.
pub(crate) fn verdict(found: &Found, flown: &Flown) -> [bool; 3] {
    let s = &found.score;
    let within = |n: u32| 100.0 * f64::from(n) <= PER_HUNDRED * f64::from(flown.movements);
    let quick = |p: f64, most_s: f64| s.response_s(p).is_some_and(|r| r <= most_s);
    [
        s.reference > 0 && f64::from(s.detected) >= DETECTED * f64::from(s.reference),
        quick(0.5, RESPONSE_S[0]) && quick(0.95, RESPONSE_S[1]),
        within(s.false_alerts),
    ]
}

const LEFT: f64 = 200.0;
const TOP: f64 = 78.0;
const CELL: [f64; 2] = [132.0, 66.0];

/// The picture, as SVG.
pub(crate) fn grid(flown: &Flown) -> String {
    let columns = PROFILES.len() * CONFIRMATIONS.len();
    let width = LEFT + CELL[0] * columns as f64 + 10.0;
    let height = TOP + CELL[1] * SETS.len() as f64 + 34.0;
    let mut out = format!(
        "<svg viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" role=\"img\">\
         <title>Which sensor set makes the safety net good enough</title>\
         <text x=\"8\" y=\"20\" font-weight=\"bold\">Which sensor set makes the safety net good enough ({} movements)</text>",
        flown.movements
    );
    for (profile, word) in PROFILES.iter().enumerate() {
        for (confirm, scans) in CONFIRMATIONS.iter().enumerate() {
            let x = LEFT + CELL[0] * (profile * CONFIRMATIONS.len() + confirm) as f64 + 6.0;
            let confirmed = if *scans > 1 { "2 scans of 2" } else { "1 scan" };
            let _ = write!(
                out,
                "<text x=\"{x}\" y=\"{}\" font-weight=\"bold\">{word}</text><text x=\"{x}\" y=\"{}\">{confirmed}</text>",
                TOP - 24.0,
                TOP - 8.0
            );
        }
    }
    for set in 0..SETS.len() {
        let y = TOP + CELL[1] * set as f64 + 0.5 * CELL[1] + 4.0;
        let _ = write!(out, "<text x=\"8\" y=\"{y}\">{}</text>", escaped(SETS[set].0));
    }
    flown.found.iter().for_each(|found| cell(&mut out, found, flown));
    let _ = write!(
        out,
        "<text x=\"8\" y=\"{}\">✓ all goals met   ◐ one not met   ✗ more not met;   ! marks what is not</text></svg>",
        height - 12.0
    );
    out
}

fn cell(out: &mut String, found: &Found, flown: &Flown) {
    let column = found.profile * CONFIRMATIONS.len() + found.confirm;
    let (x, y) = (LEFT + CELL[0] * column as f64, TOP + CELL[1] * found.set as f64);
    let (s, met) = (&found.score, verdict(found, flown));
    let (mark, fill) = match met.iter().filter(|m| !**m).count() {
        0 => ("✓", "#d7efd9"),
        1 => ("◐", "#fdf0cf"),
        _ => ("✗", "#f8d9d5"),
    };
    let flag = |k: usize| if met[k] { "" } else { " !" };
    let hundred = |n: u32| 100.0 * f64::from(n) / f64::from(flown.movements.max(1));
    let response = s.response_s(0.95).map_or_else(|| "–".to_owned(), |r| format!("{r:.0} s"));
    let words = [
        format!("{mark} {} of {}{}, {response}{}", s.detected, s.reference, flag(0), flag(1)),
        format!("false {:.1} per 100{}", hundred(s.false_alerts), flag(2)),
        format!("nuisance {:.1}", hundred(s.nuisance_alerts)),
        format!("{:.0} µs a scan", found.us_per_scan),
    ];
    let _ = write!(
        out,
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{fill}\" stroke=\"#999\"/>",
        x + 1.0,
        y + 1.0,
        CELL[0] - 2.0,
        CELL[1] - 2.0
    );
    for (line, text) in words.iter().enumerate() {
        let _ = write!(
            out,
            "<text x=\"{}\" y=\"{}\" font-size=\"11\" fill=\"#111\">{}</text>",
            x + 6.0,
            y + 15.0 + 15.0 * line as f64,
            escaped(text)
        );
    }
}
