//! A drawing as PNG.

use super::{Colour, Drawing, Item, font, svg};
use font::Step;
use tiny_skia::{
    FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, StrokeDash, Transform,
};

/// Largest side of a picture, pixels.
pub const MOST_PIXELS: f64 = 8192.0;

fn paint(colour: Colour) -> Paint<'static> {
    let [r, g, b] = colour.rgb;
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, (255.0 * colour.opacity.clamp(0.0, 1.0)).round() as u8);
    paint.anti_alias = true;
    paint
}

fn polygon<'a>(rings: impl IntoIterator<Item = &'a Vec<[f64; 2]>>, closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for ring in rings {
        for (i, [x, y]) in ring.iter().enumerate() {
            let (x, y) = (*x as f32, *y as f32);
            if i == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
        }
        if closed && !ring.is_empty() {
            path.close();
        }
    }
    path.finish()
}

fn letters(steps: &[Step]) -> Option<Path> {
    let f = |[x, y]: [f64; 2]| (x as f32, y as f32);
    let mut path = PathBuilder::new();
    for step in steps {
        match *step {
            Step::Move(p) => path.move_to(f(p).0, f(p).1),
            Step::Line(p) => path.line_to(f(p).0, f(p).1),
            Step::Curve(c, p) => path.quad_to(f(c).0, f(c).1, f(p).0, f(p).1),
            Step::Cubic(c, d, p) => {
                path.cubic_to(f(c).0, f(c).1, f(d).0, f(d).1, f(p).0, f(p).1);
            }
            Step::Close => path.close(),
        }
    }
    path.finish()
}

fn stroke(width: f64, dash: &[f64]) -> Stroke {
    let lengths: Vec<f32> = dash.iter().map(|d| *d as f32).collect();
    Stroke {
        width: width as f32,
        line_cap: if dash.is_empty() { LineCap::Round } else { LineCap::Butt },
        line_join: LineJoin::Round,
        dash: StrokeDash::new(lengths, 0.0),
        ..Stroke::default()
    }
}

/// The file; none where the picture has no area or is too large.
#[must_use]
pub fn write(drawing: &Drawing) -> Option<Vec<u8>> {
    let [w, h] = drawing.size;
    if !(w <= MOST_PIXELS && h <= MOST_PIXELS) {
        return None;
    }
    let mut map = Pixmap::new(w as u32, h as u32)?;
    let whole = Transform::identity();
    for item in &drawing.items {
        match item {
            Item::Area { rings, fill } => {
                if let Some(path) = polygon(rings, true) {
                    map.fill_path(&path, &paint(*fill), FillRule::EvenOdd, whole, None);
                }
            }
            Item::Line { points, closed, colour, width, dash } => {
                if let Some(path) = polygon([points], *closed) {
                    map.stroke_path(&path, &paint(*colour), &stroke(*width, dash), whole, None);
                }
            }
            Item::Disc { at, radius, fill, stroke: outline } => {
                let Some(path) =
                    PathBuilder::from_circle(at[0] as f32, at[1] as f32, *radius as f32)
                else {
                    continue;
                };
                if let Some(fill) = fill {
                    map.fill_path(&path, &paint(*fill), FillRule::Winding, whole, None);
                }
                if let Some((colour, width)) = outline {
                    map.stroke_path(&path, &paint(*colour), &stroke(*width, &[]), whole, None);
                }
            }
            Item::Text { at, text, size, bold, colour, anchor } => {
                let at = svg::begin(*at, text, *size, *bold, *anchor);
                if let Some(path) = letters(&font::outlines(text, *size, *bold, at)) {
                    map.fill_path(&path, &paint(*colour), FillRule::Winding, whole, None);
                }
            }
        }
    }
    // Everything lies on an opaque ground, so that the pixels need no division by their opacity.
    let rgb: Vec<u8> = map.pixels().iter().flat_map(|p| [p.red(), p.green(), p.blue()]).collect();
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, map.width(), map.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(&rgb).ok()?;
    writer.finish().ok()?;
    Some(out)
}
