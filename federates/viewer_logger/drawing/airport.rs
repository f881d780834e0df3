//! The airport: pavement, buildings, runways, names, stands, sensors (`web/paint.js` draws the same).

use super::{Anchor, Pen, font};
use crate::viewer_logger::picture::{AirportMap, NamedLine, RunwayShape};

pub(super) fn draw(pen: &mut Pen<'_>, map: &AirportMap) {
    let scale = pen.view.camera.scale;
    let line = |pen: &Pen<'_>, way: &NamedLine| -> Vec<[f64; 2]> {
        way.points_m.iter().map(|p| pen.at(*p)).collect()
    };
    let pavement = pen.colour("pavement");
    for way in &map.taxiways {
        let points = line(pen, way);
        pen.line(points, pavement, (23.0 * scale).max(1.5));
    }
    let rings = |pen: &Pen<'_>, rings: &[Vec<[f64; 2]>]| -> Vec<Vec<[f64; 2]>> {
        rings.iter().map(|ring| ring.iter().map(|p| pen.at(*p)).collect()).collect()
    };
    for area in &map.pavements {
        let area = rings(pen, &area.rings);
        pen.area(area, "pavement", 1.0);
    }
    if pen.on("buildings") {
        for area in &map.buildings {
            let area = rings(pen, &area.rings);
            pen.area(area, "pavement-edge", 1.0);
        }
        for block in &map.blocks {
            let area = rings(pen, std::slice::from_ref(&block.ring));
            pen.area(area, "pavement-edge", 1.0);
        }
    }
    for runway in &map.runways {
        draw_runway(pen, runway);
    }
    let taxi = pen.colour("taxi");
    for way in &map.taxiways {
        let points = line(pen, way);
        pen.line(points, taxi, (2.0 * scale).clamp(0.7, 1.6));
    }
    let mark = pen.colour("runway-mark");
    for [a, b] in map.holds.iter().map(|hold| hold.ends_m) {
        let ends = vec![pen.at(a), pen.at(b)];
        pen.line(ends, mark, (0.9 * scale).clamp(1.0, 2.5));
    }
    if pen.on("stands") {
        stands(pen, map);
    }
    if pen.on("taxiways") && scale >= 0.1 {
        names(pen, map);
    }
    for site in &map.sensors {
        let Some(at) = site.position_m else { continue };
        let ([x, y], dim) = (pen.at(at), pen.colour("dim"));
        let triangle = vec![[x, y - 6.0], [x + 5.0, y + 4.0], [x - 5.0, y + 4.0]];
        pen.dashed(triangle, true, dim, 1.2, &[]);
        let name = if site.name.is_empty() { &site.kind } else { &site.name };
        pen.text([x, y + 16.0], name, 10.0, false, "dim", Anchor::Middle);
    }
}

/// A runway's outline, `more` metres larger on every side.
pub(super) fn ring(runway: &RunwayShape, more: f64) -> Vec<[f64; 2]> {
    let [a, b] = runway.ends;
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length = libm::hypot(dx, dy).max(1e-9);
    let (ux, uy, half) = (dx / length, dy / length, runway.width_m / 2.0 + more);
    let corner = |end: [f64; 2], along: f64, side: f64| {
        [end[0] + ux * along - uy * half * side, end[1] + uy * along + ux * half * side]
    };
    vec![corner(a, -more, 1.0), corner(b, more, 1.0), corner(b, more, -1.0), corner(a, -more, -1.0)]
}

fn draw_runway(pen: &mut Pen<'_>, runway: &RunwayShape) {
    let scale = pen.view.camera.scale;
    let outline: Vec<[f64; 2]> = ring(runway, 0.0).into_iter().map(|p| pen.at(p)).collect();
    pen.area(vec![outline.clone()], "runway", 1.0);
    let mark = pen.colour("runway-mark");
    pen.dashed(outline, true, mark, 1.0, &[]);
    let [a, b] = runway.ends;
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length = libm::hypot(dx, dy).max(1e-9);
    let (ux, uy) = (dx / length, dy / length);
    let middle = [[a[0] + ux * 80.0, a[1] + uy * 80.0], [b[0] - ux * 80.0, b[1] - uy * 80.0]];
    let middle = middle.map(|p| pen.at(p)).to_vec();
    pen.dashed(middle, false, mark, (0.9 * scale).max(0.8), &[30.0 * scale, 20.0 * scale]);
    let gap = (14.0 / scale + runway.width_m / 2.0) / length;
    let size = (24.0 * scale + 8.0).clamp(11.0, 26.0);
    let places = [[a[0] - dx * gap, a[1] - dy * gap], [b[0] + dx * gap, b[1] + dy * gap]];
    for (place, name) in places.into_iter().zip(&runway.designators) {
        let [x, y] = pen.at(place);
        pen.text([x, y + 0.36 * size], name, size, true, "runway-mark", Anchor::Middle);
    }
}

/// Boxes of texts that are there already: x, y, width, height.
type Taken = Vec<[f64; 4]>;

/// Whether a text of this width fits at a place; then the place is taken.
fn free(pen: &Pen<'_>, taken: &mut Taken, [x, y]: [f64; 2], width: f64) -> bool {
    let cover = |o: &[f64; 4]| {
        o[0] < x + width && x < o[0] + o[2] && o[1] < y + 7.0 && y - 7.0 < o[1] + o[3]
    };
    if !pen.inside([x, y], 14.0) || taken.iter().any(cover) {
        return false;
    }
    taken.push([x, y - 7.0, width, 14.0]);
    true
}

fn stands(pen: &mut Pen<'_>, map: &AirportMap) {
    let scale = pen.view.camera.scale;
    let (radius, colour) = ((4.0 * scale).clamp(1.2, 4.0), pen.colour("stand"));
    for stand in &map.stands {
        pen.disc(pen.at(stand.position_m), radius, Some(colour), None);
    }
    if scale < 0.55 {
        return;
    }
    let mut taken = Taken::new();
    for stand in &map.stands {
        let [x, y] = pen.at(stand.position_m);
        let name = stand.name.replace('_', " ");
        let place = [x + radius + 3.0, y];
        if free(pen, &mut taken, place, font::width(&name, 10.0, false) + 4.0) {
            pen.text([place[0], y + 3.6], &name, 10.0, false, "stand", Anchor::Start);
        }
    }
}

/// Names of taxiways once a screenful each, the longest pieces first.
fn names(pen: &mut Pen<'_>, map: &AirportMap) {
    let ends = |w: &NamedLine| Some((*w.points_m.first()?, *w.points_m.last()?));
    let mut ways: Vec<(f64, [f64; 2], &str)> = map
        .taxiways
        .iter()
        .filter(|w| !w.name.is_empty() && w.name.len() <= 3)
        .filter_map(|w| {
            let (a, b) = ends(w)?;
            let middle = [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0];
            Some((libm::hypot(a[0] - b[0], a[1] - b[1]), pen.at(middle), &w.name[..]))
        })
        .collect();
    ways.sort_by(|p, q| q.0.total_cmp(&p.0).then(p.2.cmp(q.2)));
    let mut taken = Taken::new();
    let mut last: Vec<(&str, [f64; 2])> = Vec::new();
    for (_, [x, y], name) in ways {
        let near =
            |l: &(&str, [f64; 2])| l.0 == name && libm::hypot(l.1[0] - x, l.1[1] - y) < 260.0;
        let width = font::width(name, 10.0, true) + 4.0;
        if last.iter().any(near) || !free(pen, &mut taken, [x - width / 2.0, y], width) {
            continue;
        }
        pen.area(vec![super::corners(x - width / 2.0, y - 6.0, width, 12.0)], "pavement", 1.0);
        pen.text([x, y + 3.6], name, 10.0, true, "taxi-name", Anchor::Middle);
        last.push((name, [x, y]));
    }
}
