//! Alerts that stand: a frame round each subject, a line between two, their words (`web/position.js` draws the same).

use super::{Anchor, Pen, Shown, targets::sound};
use crate::runtime::messages::{ScanReport, TrackMessage};

/// Half a frame's side, pixels.
const HALF: f64 = 11.0;

pub(super) fn draw(pen: &mut Pen<'_>, shown: &Shown<'_>) {
    if !pen.on("alerts") {
        return;
    }
    for alert in shown.alerts {
        let alarm = alert.stage == "alarm";
        let name = if alarm { "alarm" } else { "information" };
        let colour = pen.colour(name);
        let (width, dash): (f64, &[f64]) = if alarm { (2.5, &[]) } else { (1.5, &[4.0, 3.0]) };
        let subjects: Vec<[f64; 2]> = alert
            .subjects
            .iter()
            .filter_map(|name| subject(shown.scan, name))
            .map(|track| pen.at(track.position_m))
            .collect();
        for [x, y] in &subjects {
            pen.dashed(
                super::corners(x - HALF, y - HALF, 2.0 * HALF, 2.0 * HALF),
                true,
                colour,
                width,
                dash,
            );
        }
        if let [a, b, ..] = subjects[..] {
            pen.dashed(vec![a, b], false, colour, 1.0, dash);
        }
        // Of who has no track, the place is left.
        let at = match subjects.first() {
            Some(at) => *at,
            None if sound(alert.place_m) => pen.at(alert.place_m),
            None => continue,
        };
        let words = format!("{} {}", alert.kind, alert.subjects.join(" "));
        pen.text([at[0], at[1] + HALF + 13.0], &words, 11.0, true, name, Anchor::Middle);
    }
}

/// The track that an alert calls so: by its call sign, else by its number.
fn subject<'a>(scan: &'a ScanReport, name: &str) -> Option<&'a TrackMessage> {
    let of = |test: &dyn Fn(&TrackMessage) -> bool| scan.tracks.iter().find(|t| test(t));
    of(&|t| t.callsign == name && t.assumed.is_empty())
        .or_else(|| of(&|t| t.callsign.is_empty() && t.number.to_string() == name))
        .or_else(|| of(&|t| t.callsign == name))
        .filter(|track| sound(track.position_m))
}
