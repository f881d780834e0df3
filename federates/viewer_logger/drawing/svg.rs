//! A drawing as SVG. Letters are outlines, so that it looks the same wherever it is opened; the words stand in the title of each text.

use super::{Anchor, Colour, Drawing, Item, font};
use font::Step;
use std::fmt::Write as _;

/// Where a text begins, for the side of its point on which it stands.
pub(super) fn begin(at: [f64; 2], text: &str, size: f64, bold: bool, anchor: Anchor) -> [f64; 2] {
    let width = font::width(text, size, bold);
    match anchor {
        Anchor::Start => at,
        Anchor::Middle => [at[0] - width / 2.0, at[1]],
        Anchor::End => [at[0] - width, at[1]],
    }
}

fn escaped(text: &str) -> String {
    let safe = text.chars().filter(|c| !c.is_control());
    safe.collect::<String>().replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn paint(name: &str, colour: Colour) -> String {
    let [r, g, b] = colour.rgb;
    let mut out = format!("{name}=\"#{r:02x}{g:02x}{b:02x}\"");
    if colour.opacity < 1.0 {
        let _ = write!(out, " {name}-opacity=\"{:.3}\"", colour.opacity);
    }
    out
}

fn path(points: &[[f64; 2]], closed: bool) -> String {
    let mut out = String::new();
    for (i, p) in points.iter().enumerate() {
        let _ = write!(out, "{}{:.2} {:.2}", if i == 0 { "M" } else { "L" }, p[0], p[1]);
    }
    if closed {
        out.push('Z');
    }
    out
}

/// The file.
#[must_use]
pub fn write(drawing: &Drawing) -> String {
    let [w, h] = drawing.size;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" stroke-linejoin=\"round\" stroke-linecap=\"round\" fill=\"none\">\n"
    );
    for item in &drawing.items {
        let _ = match item {
            Item::Area { rings, fill } => {
                let d: String = rings.iter().map(|ring| path(ring, true)).collect();
                writeln!(out, "<path d=\"{d}\" fill-rule=\"evenodd\" {}/>", paint("fill", *fill))
            }
            Item::Line { points, closed, colour, width, dash } => {
                let dash = match dash.is_empty() {
                    true => String::new(),
                    false => {
                        let list: Vec<String> = dash.iter().map(|d| format!("{d:.2}")).collect();
                        format!(" stroke-linecap=\"butt\" stroke-dasharray=\"{}\"", list.join(" "))
                    }
                };
                let (d, stroke) = (path(points, *closed), paint("stroke", *colour));
                writeln!(out, "<path d=\"{d}\" {stroke} stroke-width=\"{width:.2}\"{dash}/>")
            }
            Item::Disc { at, radius, fill, stroke } => {
                let fill = fill.map_or_else(String::new, |c| format!(" {}", paint("fill", c)));
                let stroke = stroke.map_or_else(String::new, |(c, w)| {
                    format!(" {} stroke-width=\"{w:.2}\"", paint("stroke", c))
                });
                let [x, y] = at;
                writeln!(
                    out,
                    "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius:.2}\"{fill}{stroke}/>"
                )
            }
            Item::Text { at, text, size, bold, colour, anchor } => {
                let at = begin(*at, text, *size, *bold, *anchor);
                let mut d = String::new();
                for step in font::outlines(text, *size, *bold, at) {
                    let _ = match step {
                        Step::Move([x, y]) => write!(d, "M{x:.2} {y:.2}"),
                        Step::Line([x, y]) => write!(d, "L{x:.2} {y:.2}"),
                        Step::Curve([a, b], [x, y]) => write!(d, "Q{a:.2} {b:.2} {x:.2} {y:.2}"),
                        Step::Cubic([a, b], [c, e], [x, y]) => {
                            write!(d, "C{a:.2} {b:.2} {c:.2} {e:.2} {x:.2} {y:.2}")
                        }
                        Step::Close => write!(d, "Z"),
                    };
                }
                let (fill, words) = (paint("fill", *colour), escaped(text));
                writeln!(out, "<path d=\"{d}\" {fill}><title>{words}</title></path>")
            }
        };
    }
    out + "</svg>\n"
}
