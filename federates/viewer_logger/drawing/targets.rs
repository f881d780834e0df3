//! What moves: rain, trails, plots, truth, errors, ellipses, vectors, tracks (`web/traffic.js` draws the same).

use super::{Anchor, Colour, Mark, Pen, Shown};
use crate::runtime::messages::{TrackMessage, TruthMessage};
use crate::viewer_logger::frame;
use crate::viewer_logger::picture::KindLook;
use models::track::{TrackStatus, TrackType};

/// Slower targets stand, m/s.
pub(super) const STILL_MPS: f64 = 0.5;

pub(super) fn draw(pen: &mut Pen<'_>, shown: &Shown<'_>) {
    let scan = shown.scan;
    if pen.on("weather") {
        rain(pen, shown);
    }
    let tracks: Vec<&TrackMessage> = match pen.on("tracks") {
        true => scan.tracks.iter().filter(|t| sound(t.position_m.into())).collect(),
        false => Vec::new(),
    };
    if pen.on("history") {
        trails(pen, shown);
    }
    if pen.on("plots") {
        plots(pen, shown);
    }
    if pen.on("ellipses") {
        for track in &tracks {
            ellipse(pen, track);
        }
    }
    if pen.on("truth") {
        for truth in &scan.truth {
            outline(pen, truth);
        }
    }
    if pen.on("errors") {
        let error = pen.colour("error");
        let pairs = frame::pairs(scan);
        for track in &tracks {
            let Some((index, _)) = pairs.get(&track.number) else { continue };
            let [x, y, _]: [f64; 3] = scan.truth[*index].position_m.into();
            let ends = [pen.at(track.position_m.into()), pen.at([x, y])].to_vec();
            pen.line(ends, error, 1.6);
        }
    }
    if pen.on("vectors") {
        for track in &tracks {
            let ([vx, vy], [x, y]): ([f64; 2], [f64; 2]) =
                (track.velocity_mps, track.position_m.into());
            if libm::hypot(vx, vy) >= STILL_MPS {
                let s = pen.view.vector_s;
                let ends = [pen.at([x, y]), pen.at([x + vx * s, y + vy * s])].to_vec();
                let colour = pen.colour(colour_of(track));
                pen.line(ends, colour, 1.2);
            }
        }
    }
    for track in &tracks {
        symbol(pen, track);
    }
    let chosen = tracks.iter().find(|t| is_selected(pen, t));
    if let Some(track) = chosen {
        let ([x, y], colour) = (pen.at(track.position_m.into()), pen.colour("select"));
        for (sx, sy) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let corner = [[12.0, 7.0], [12.0, 12.0], [7.0, 12.0]];
            let points = corner.map(|[a, b]| [x + sx * a, y + sy * b]).to_vec();
            pen.line(points, colour, 1.6);
        }
    }
}

/// Whether the address selects this one.
pub(super) fn is_selected(pen: &Pen<'_>, track: &TrackMessage) -> bool {
    let number = format!("#{}", track.number);
    let names = [&track.callsign, &track.assumed, &number];
    pen.view.selected.as_ref().is_some_and(|s| !s.is_empty() && names.contains(&s))
}

pub(super) fn sound(position_m: [f64; 2]) -> bool {
    position_m.iter().all(|x| x.is_finite() && x.abs() < 1e6)
}

/// Name of a track's colour.
pub(super) fn colour_of(track: &TrackMessage) -> &'static str {
    match (track.movement, track.track_type) {
        (Some(movement), _) => movement.word(),
        (None, TrackType::Vehicle) => "vehicle",
        (None, _) => "unknown",
    }
}

fn rain(pen: &mut Pen<'_>, shown: &Shown<'_>) {
    let rain = pen.colour("rain");
    for [east, north, radius_m, rate] in shown.weather.into_iter().flat_map(|w| w.cells.clone()) {
        let (at, radius) = (pen.at([east, north]), radius_m * pen.view.camera.scale);
        if !(at[0].is_finite() && at[1].is_finite() && radius.is_finite() && radius > 0.0) {
            continue;
        }
        let fill = rain.faded((0.06 + rate / 400.0).min(0.26));
        let stroke = Some((rain.faded(0.8), 1.0));
        pen.drawing.items.push(super::Item::Disc { at, radius, fill: Some(fill), stroke });
        let words = format!("{rate:.0} mm/h");
        pen.text([at[0], at[1] - radius + 14.0], &words, 10.0, false, "rain", Anchor::Middle);
    }
}

fn trails(pen: &mut Pen<'_>, shown: &Shown<'_>) {
    for track in &shown.scan.tracks {
        let Some((_, points)) = shown.trails.iter().find(|t| t.0 == track.number) else { continue };
        let count = points.len().min(pen.view.dots);
        for (i, point) in points.iter().take(count).enumerate() {
            let age = (6 * i / (count + 1)).min(5) as f64;
            let at = pen.at(point.map(f64::from));
            let colour = pen.colour(colour_of(track)).faded(0.6 - 0.09 * age);
            if pen.inside(at, 2.0) {
                let ring = super::corners(at[0] - 1.0, at[1] - 1.0, 2.0, 2.0);
                pen.drawing.items.push(super::Item::Area { rings: vec![ring], fill: colour });
            }
        }
    }
}

fn plots(pen: &mut Pen<'_>, shown: &Shown<'_>) {
    let kinds = KindLook::all();
    for plot in shown.scan.plots.iter().filter(|p| sound(p.position_m.into())) {
        let [x, y] = pen.at(plot.position_m.into());
        if !pen.inside([x, y], 4.0) {
            continue;
        }
        let name = format!("plot-{}", plot.kind.word);
        let colour = pen.colour(if pen.palette.has(&name) { &name } else { "plot-other" });
        let Some(kind) = kinds.iter().find(|k| k.word == plot.kind.word) else { continue };
        for line in &kind.symbol {
            let points =
                line.iter().map(|[a, b]| [x + 3.5 * f64::from(*a), y + 3.5 * f64::from(*b)]);
            pen.line(points.collect(), colour, 1.2);
        }
    }
}

/// 95 % ellipse of a covariance: half axes, m, and the angle of the larger from east, rad.
fn axes_of([ee, en, nn]: [f64; 3]) -> Option<(f64, f64, f64)> {
    if ![ee, en, nn].iter().all(|v| v.is_finite()) {
        return None;
    }
    let (mean, gap) = ((ee + nn) / 2.0, libm::hypot((ee - nn) / 2.0, en));
    // Root of the 95 % quantile of chi squared with two degrees of freedom.
    let half = |v: f64| 2.4477 * v.max(0.0).sqrt();
    Some((half(mean + gap), half(mean - gap), libm::atan2(2.0 * en, ee - nn) / 2.0))
}

fn ellipse(pen: &mut Pen<'_>, track: &TrackMessage) {
    let Some((a, b, angle)) = axes_of(track.cov_m2) else { return };
    let scale = pen.view.camera.scale;
    if !(4.0..=4000.0).contains(&(a * scale)) {
        return;
    }
    let [x, y]: [f64; 2] = track.position_m.into();
    let point = |k: usize| {
        let t = k as f64 * std::f64::consts::TAU / 48.0;
        let (u, v) = (a * libm::cos(t), b * libm::sin(t));
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        pen.at([x + u * cos - v * sin, y + u * sin + v * cos])
    };
    let points = (0..48).map(point).collect();
    let colour = pen.colour(colour_of(track)).faded(0.55);
    pen.dashed(points, true, colour, 1.0, &[]);
}

/// Half outlines of an aircraft: across in spans, along in lengths, nose first; as in `web/traffic.js`.
const HALF: [[f64; 2]; 10] = [
    [0.0, 0.5],
    [0.05, 0.42],
    [0.055, 0.14],
    [0.5, -0.1],
    [0.5, -0.17],
    [0.055, -0.06],
    [0.045, -0.36],
    [0.19, -0.45],
    [0.19, -0.5],
    [0.0, -0.46],
];
const VEHICLE: [[f64; 2]; 5] = [[-0.5, -0.5], [-0.5, 0.3], [0.0, 0.5], [0.5, 0.3], [0.5, -0.5]];

fn outline(pen: &mut Pen<'_>, truth: &TruthMessage) {
    let [x, y, _]: [f64; 3] = truth.position_m.into();
    if !sound([x, y]) {
        return;
    }
    let (at, scale) = (pen.at([x, y]), pen.view.camera.scale);
    let or = |v: f64, else_m: f64| if v > 0.0 { v } else { else_m };
    let length = (or(truth.size_m[0], 10.0) * scale).max(9.0);
    let span = (or(truth.size_m[1], 5.0) * scale).max(if truth.aircraft { 8.0 } else { 5.0 });
    let heading = if truth.heading_rad.is_finite() { truth.heading_rad } else { 0.0 };
    let heading = heading - pen.view.camera.rot_rad;
    let (sin, cos) = (libm::sin(heading), libm::cos(heading));
    let shape: Vec<[f64; 2]> = if truth.aircraft {
        let other = HALF[1..HALF.len() - 1].iter().rev().map(|[a, l]| [-a, *l]);
        HALF.into_iter().chain(other).collect()
    } else {
        VEHICLE.to_vec()
    };
    let corner = |[across, along]: [f64; 2]| {
        let (a, l) = (across * span, along * length);
        [at[0] + l * sin + a * cos, at[1] - l * cos + a * sin]
    };
    let colour = pen.colour("truth");
    let dash: &[f64] = if truth.ours { &[] } else { &[3.0, 2.0] };
    pen.dashed(shape.into_iter().map(corner).collect(), true, colour, 1.2, dash);
}

fn symbol(pen: &mut Pen<'_>, track: &TrackMessage) {
    let at = pen.at(track.position_m.into());
    let colour = pen.colour(colour_of(track));
    if !pen.inside(at, 8.0) {
        return;
    }
    let named = !track.callsign.is_empty();
    let known = track.track_type != TrackType::NotAssociated;
    let hollow =
        matches!(track.status, TrackStatus::Coasting | TrackStatus::Tentative) || (!named && known);
    let ground = pen.colour("ground");
    let (fill, stroke) = if hollow { (None, (colour, 1.6)) } else { (Some(colour), (ground, 1.0)) };
    let ring = |corners: &[[f64; 2]]| -> Vec<[f64; 2]> {
        corners.iter().map(|[x, y]| [at[0] + x, at[1] + y]).collect()
    };
    let corners = match track.track_type {
        TrackType::Aircraft => {
            pen.disc(at, 5.0, fill, Some(stroke));
            None
        }
        TrackType::Vehicle => Some(ring(&[[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0]])),
        TrackType::NotAssociated => Some(ring(&[[0.0, -6.0], [6.0, 0.0], [0.0, 6.0], [-6.0, 0.0]])),
    };
    if let Some(corners) = corners {
        if let Some(fill) = fill {
            let rings = vec![corners.clone()];
            pen.drawing.items.push(super::Item::Area { rings, fill });
        }
        pen.dashed(corners, true, stroke.0, stroke.1, &[]);
    }
    mark(pen, track, at, colour);
}

fn mark(pen: &mut Pen<'_>, track: &TrackMessage, at: [f64; 2], colour: Colour) {
    pen.drawing.marks.push(Mark { number: track.number, at, colour, label: Vec::new() });
}
