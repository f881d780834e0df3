//! B612 as outlines: what a text measures, and its letters as paths, so that a picture needs no fonts of the system.

use std::sync::OnceLock;
use ttf_parser::{Face, OutlineBuilder};

const PLAIN: &[u8] = include_bytes!("../web/vendor/b612-latin-400.ttf");
const BOLD: &[u8] = include_bytes!("../web/vendor/b612-latin-700.ttf");

/// A face that is inside the executable; `None` is for a build whose font is damaged, and then texts are left out.
fn face(bold: bool) -> Option<&'static Face<'static>> {
    static FACES: [OnceLock<Option<Face<'static>>>; 2] = [OnceLock::new(), OnceLock::new()];
    let octets = if bold { BOLD } else { PLAIN };
    FACES[usize::from(bold)].get_or_init(|| Face::parse(octets, 0).ok()).as_ref()
}

/// What every letter of a text is drawn by, in a font of `size` pixels.
fn glyphs(text: &str, size: f64, bold: bool) -> Vec<(ttf_parser::GlyphId, f64)> {
    let Some(face) = face(bold) else { return Vec::new() };
    let scale = size / f64::from(face.units_per_em());
    let mut x = 0.0;
    let place = |c: char| {
        let id = face.glyph_index(c).or_else(|| face.glyph_index('?')).unwrap_or_default();
        let at = x;
        x += f64::from(face.glyph_hor_advance(id).unwrap_or(0)) * scale;
        (id, at)
    };
    text.chars().map(place).collect()
}

/// Width of a text, pixels.
#[must_use]
pub fn width(text: &str, size: f64, bold: bool) -> f64 {
    let Some(face) = face(bold) else { return 0.0 };
    let last = glyphs(text, size, bold).pop();
    last.map_or(0.0, |(id, at)| {
        let advance = f64::from(face.glyph_hor_advance(id).unwrap_or(0));
        at + advance * size / f64::from(face.units_per_em())
    })
}

/// One step of an outline, pixels, y downwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Begins a ring.
    Move([f64; 2]),
    /// A straight line.
    Line([f64; 2]),
    /// A curve of the second order: control point, end.
    Curve([f64; 2], [f64; 2]),
    /// A curve of the third order: both control points, end.
    Cubic([f64; 2], [f64; 2], [f64; 2]),
    /// Ends the ring.
    Close,
}

/// The outlines of a text whose base line begins at `at`.
#[must_use]
pub fn outlines(text: &str, size: f64, bold: bool, at: [f64; 2]) -> Vec<Step> {
    let Some(face) = face(bold) else { return Vec::new() };
    let scale = size / f64::from(face.units_per_em());
    let mut steps = Steps { out: Vec::new(), at, scale };
    for (id, x) in glyphs(text, size, bold) {
        steps.at[0] = at[0] + x;
        face.outline_glyph(id, &mut steps);
    }
    steps.out
}

struct Steps {
    out: Vec<Step>,
    at: [f64; 2],
    scale: f64,
}

impl Steps {
    fn place(&self, x: f32, y: f32) -> [f64; 2] {
        [self.at[0] + f64::from(x) * self.scale, self.at[1] - f64::from(y) * self.scale]
    }
}

impl OutlineBuilder for Steps {
    fn move_to(&mut self, x: f32, y: f32) {
        self.out.push(Step::Move(self.place(x, y)));
    }
    fn line_to(&mut self, x: f32, y: f32) {
        self.out.push(Step::Line(self.place(x, y)));
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.out.push(Step::Curve(self.place(x1, y1), self.place(x, y)));
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.out.push(Step::Cubic(self.place(x1, y1), self.place(x2, y2), self.place(x, y)));
    }
    fn close(&mut self) {
        self.out.push(Step::Close);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_as_wide_as_its_letters() {
        let (plain, bold) = (width("SWR137H", 12.0, false), width("SWR137H", 12.0, true));
        assert!([plain, bold].iter().all(|w| (40.0..70.0).contains(w)), "{plain} {bold}");
        assert!((width("SWR137H", 24.0, false) - 2.0 * plain).abs() < 1e-9);
        assert_eq!(width("", 12.0, false), 0.0);
        assert!(width("\u{1f6eb}", 12.0, false) > 0.0, "what the font lacks is a question mark");
    }

    #[test]
    fn letters_stand_on_their_base_line() {
        let (low, high) = outlines("HE", 100.0, false, [10.0, 50.0]).iter().fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(low, high), step| match step {
                Step::Move(p) | Step::Line(p) | Step::Curve(_, p) | Step::Cubic(_, _, p) => {
                    (low.min(p[1]), high.max(p[1]))
                }
                Step::Close => (low, high),
            },
        );
        assert!((high - 50.0).abs() < 1.0, "{high}");
        assert!((-40.0..-10.0).contains(&low), "{low}: about 70 high");
    }
}
