//! Alerts that stand: a frame round each subject, a line between two, their words (`web/position.js` draws the same).

use super::airport::ring;
use super::{Anchor, Pen, Shown, targets::sound};
use crate::runtime::messages::{ScanReport, TrackMessage};
use crate::viewer_logger::picture::RunwayShape;
use crate::viewer_logger::said::AlertLine;
use models::control::alert::Stage;

/// Half a frame's side, pixels.
const HALF: f64 = 11.0;

pub(super) fn draw(pen: &mut Pen<'_>, shown: &Shown<'_>) {
    if !pen.on("alerts") {
        return;
    }
    for alert in shown.alerts {
        let alarm = alert.stage == Stage::Alarm;
        let name = if alarm { "alarm" } else { "information" };
        let colour = pen.colour(name);
        let (width, dash): (f64, &[f64]) = if alarm { (2.5, &[]) } else { (1.5, &[4.0, 3.0]) };
        let subjects: Vec<[f64; 2]> = alert
            .subjects
            .iter()
            .filter_map(|name| subject(shown.scan, name))
            .map(|track| pen.at(track.position_m.into()))
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
        let words = format!("{} {}", alert.kind.word(), alert.subjects.join(" "));
        pen.text([at[0], at[1] + HALF + 13.0], &words, 11.0, true, name, Anchor::Middle);
    }
}

/// Runways that an alarm is about, outlined.
pub(super) fn runways(pen: &mut Pen<'_>, shown: &Shown<'_>) {
    if !pen.on("alerts") {
        return;
    }
    let alarms = shown.alerts.iter().filter(|a| a.stage == Stage::Alarm);
    for runway in alarms.filter_map(|alarm| runway_of(alarm, shown)) {
        let colour = pen.colour("alarm");
        let outline = ring(runway, 4.0).into_iter().map(|p| pen.at(p)).collect();
        pen.dashed(outline, true, colour, 2.5, &[]);
    }
}

/// The runway that an alert is about: where it is, where its subjects are, or whose strip its place lies in.
fn runway_of<'a>(alert: &AlertLine<'_>, shown: &Shown<'a>) -> Option<&'a RunwayShape> {
    let about = ["RMCA", "RWY", "CATC", "NOCLR_RWY", "NOCLR_TOF", "NOCLR_LND"];
    let word = alert.kind.word();
    if !about.iter().any(|kind| word.starts_with(kind)) {
        return None;
    }
    let on = |place: [f64; 2], beside| shown.map.runways.iter().find(|r| is_on(r, place, beside));
    let tracks = alert.subjects.iter().filter_map(|name| subject(shown.scan, name));
    let ground = tracks.filter(|t| t.altitude_m.is_none_or(|m| m <= AIRBORNE_M));
    let mut places = std::iter::once(alert.place_m).chain(ground.map(|t| t.position_m.into()));
    places.find_map(|place| on(place, 0.0)).or_else(|| on(alert.place_m, STRIP_M))
}

/// Whether a place is on a runway, or so many metres beside.
fn is_on(runway: &RunwayShape, [x, y]: [f64; 2], beside: f64) -> bool {
    let [[ax, ay], [bx, by]] = runway.ends;
    let (dx, dy) = (bx - ax, by - ay);
    let length = libm::hypot(dx, dy).max(1e-9);
    let along = ((x - ax) * dx + (y - ay) * dy) / length;
    let across = ((x - ax) * dy - (y - ay) * dx) / length;
    (-beside..=length + beside).contains(&along) && across.abs() <= runway.width_m / 2.0 + beside
}

/// Higher is not on it, m.
const AIRBORNE_M: f64 = 15.0;
/// Half the width of a strip beyond the runway's edge, m.
const STRIP_M: f64 = 75.0;

/// The track that an alert calls so: by its call sign, else by its number.
fn subject<'a>(scan: &'a ScanReport, name: &str) -> Option<&'a TrackMessage> {
    let of = |test: &dyn Fn(&TrackMessage) -> bool| scan.tracks.iter().find(|t| test(t));
    of(&|t| t.callsign == name && t.assumed.is_empty())
        .or_else(|| of(&|t| t.callsign.is_empty() && t.number.to_string() == name))
        .or_else(|| of(&|t| t.callsign == name))
        .filter(|track| sound(track.position_m.into()))
}

#[cfg(test)]
mod tests {
    use super::super::view::{Palette, View};
    use super::super::{Drawing, Item};
    use super::*;
    use crate::viewer_logger::picture::AirportMap;
    use models::control::alert::AlertKind;

    #[test]
    fn an_alarm_about_a_runway_outlines_it_and_nothing_else_does() {
        let designators = ["09", "27"].map(str::to_owned);
        let runway = RunwayShape { designators, ends: [[0.0, 0.0], [3000.0, 0.0]], width_m: 45.0 };
        let map = AirportMap { runways: vec![runway], ..AirportMap::default() };
        let outlined =
            |kind: AlertKind, stage: Stage, place_m: [f64; 2], track_m: [f64; 2], up_m| {
                let mut scan = crate::viewer_logger::tests::scan(3);
                scan.tracks[0].position_m = track_m.into();
                scan.tracks[0].altitude_m = Some(up_m);
                let alert = AlertLine {
                    id: 1,
                    kind,
                    stage,
                    subjects: vec!["SWR1"],
                    since_s: 1.0,
                    end_s: None,
                    place_m,
                    acknowledged: None,
                };
                let alerts = [alert];
                let shown = Shown {
                    map: &map,
                    scan: &scan,
                    trails: &[],
                    weather: None,
                    alerts: &alerts,
                    caption: "",
                };
                let drawing = Drawing::of(&shown, &View::new([800.0, 600.0]));
                let alarm = Palette::of(false).get("alarm");
                drawing.items.iter().any(|item| match item {
                    Item::Line { points, closed: true, colour, .. } => {
                        *colour == alarm && (points[0][0] - points[1][0]).abs() > 100.0
                    }
                    _ => false,
                })
            };
        let (on, beside, far) = ([500.0, 3.0], [500.0, 60.0], [500.0, 400.0]);
        assert!(
            outlined(AlertKind::RunwayRoll, Stage::Alarm, beside, on, 0.0),
            "its subject is on it"
        );
        assert!(
            outlined(AlertKind::RunwayRoll, Stage::Alarm, beside, far, 0.0),
            "it lies in its strip"
        );
        assert!(outlined(AlertKind::NoRunwayClearance, Stage::Alarm, on, far, 0.0));
        assert!(!outlined(AlertKind::RunwayRoll, Stage::Alarm, far, on, 200.0), "flies over");
        assert!(!outlined(AlertKind::RunwayRoll, Stage::Alarm, far, far, 0.0));
        assert!(!outlined(AlertKind::RunwayRoll, Stage::Information, on, on, 0.0));
        assert!(
            !outlined(AlertKind::NoTaxiClearance, Stage::Alarm, on, on, 0.0),
            "not about a runway"
        );
    }
}
