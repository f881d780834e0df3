//! The map as the page draws it, without a browser: a list of lines, areas, discs and texts in pixels, made of the same
//! map and the same scan, in the colours of the page's own style sheet.
//!
//! ```text
//! AirportMap ─┐
//! ScanReport ─┼─► Drawing::of ──► Drawing ──► svg::write | png::write
//! View ───────┘
//! ```

pub mod airport;
pub mod alerts;
pub mod font;
pub mod labels;
pub mod png;
pub mod svg;
pub mod targets;
pub mod view;

use super::history::TRAIL;
use super::picture::AirportMap;
use super::said::AlertLine;
use crate::runtime::messages::{ScanReport, WeatherNotice};
use view::{Palette, View};

/// A colour with its opacity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Colour {
    /// Red, green, blue.
    pub rgb: [u8; 3],
    /// 0 (nothing) to 1.
    pub opacity: f64,
}

impl Colour {
    /// The same, so much less of it.
    #[must_use]
    pub fn faded(self, opacity: f64) -> Self {
        Self { opacity: self.opacity * opacity, ..self }
    }
}

/// Where a text stands to its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// To the right of it.
    Start,
    /// About it.
    Middle,
    /// To the left of it.
    End,
}

/// One thing that is drawn; pixels, y downwards.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// Rings filled by the even-odd rule.
    Area {
        /// Corners of each ring.
        rings: Vec<Vec<[f64; 2]>>,
        /// With what.
        fill: Colour,
    },
    /// A line.
    Line {
        /// Its points.
        points: Vec<[f64; 2]>,
        /// Whether the last is joined to the first.
        closed: bool,
        /// Colour.
        colour: Colour,
        /// Width.
        width: f64,
        /// Drawn and left out in turn; empty: drawn.
        dash: Vec<f64>,
    },
    /// A disc.
    Disc {
        /// Its middle.
        at: [f64; 2],
        /// Its radius.
        radius: f64,
        /// With what it is filled.
        fill: Option<Colour>,
        /// Colour and width of its outline.
        stroke: Option<(Colour, f64)>,
    },
    /// A text on its base line.
    Text {
        /// Where.
        at: [f64; 2],
        /// What.
        text: String,
        /// Height of the letters' body.
        size: f64,
        /// Whether bold.
        bold: bool,
        /// Colour.
        colour: Colour,
        /// On which side of the point.
        anchor: Anchor,
    },
}

/// A target as it was drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Track number.
    pub number: u16,
    /// Middle of its symbol.
    pub at: [f64; 2],
    /// Colour of its symbol.
    pub colour: Colour,
    /// Lines of its label, where it has one.
    pub label: Vec<String>,
}

/// A picture as a list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// Width and height.
    pub size: [f64; 2],
    /// What is drawn, from back to front.
    pub items: Vec<Item>,
    /// The tracks among it.
    pub marks: Vec<Mark>,
    /// Tracks in view without room for a label.
    pub unlabelled: usize,
}

/// Height of the line of text below the map, as in the page's own pictures.
pub const CAPTION: f64 = 26.0;

/// What is shown.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a> {
    /// The airport.
    pub map: &'a AirportMap,
    /// The scan.
    pub scan: &'a ScanReport,
    /// Positions of each track in the scans before, newest first, m.
    pub trails: &'a [super::frame::Trail],
    /// The weather of the time.
    pub weather: Option<&'a WeatherNotice>,
    /// Alerts that stand.
    pub alerts: &'a [AlertLine<'a>],
    /// Words below the map.
    pub caption: &'a str,
}

impl Drawing {
    /// The picture of a view.
    #[must_use]
    pub fn of(shown: &Shown<'_>, view: &View) -> Self {
        let palette = Palette::of(view.day);
        let [width, height] = view.camera.size;
        let mut drawing = Self { size: [width, height + CAPTION], ..Self::default() };
        let mut pen = Pen { drawing: &mut drawing, view, palette: &palette };
        pen.area(vec![corners(0.0, 0.0, width, height)], "ground", 1.0);
        airport::draw(&mut pen, shown.map);
        alerts::runways(&mut pen, shown);
        targets::draw(&mut pen, shown);
        labels::draw(&mut pen, shown);
        alerts::draw(&mut pen, shown);
        pen.scale();
        pen.area(vec![corners(0.0, height, width, CAPTION)], "panel", 1.0);
        pen.text([10.0, height + 17.0], shown.caption, 12.0, false, "text", Anchor::Start);
        drawing
    }
}

/// Draws into a list by names of colours.
pub(super) struct Pen<'a> {
    pub(super) drawing: &'a mut Drawing,
    pub(super) view: &'a View,
    pub(super) palette: &'a Palette,
}

impl Pen<'_> {
    pub(super) fn colour(&self, name: &str) -> Colour {
        self.palette.get(name)
    }

    pub(super) fn at(&self, metres: [f64; 2]) -> [f64; 2] {
        self.view.camera.to_screen(metres)
    }

    pub(super) fn on(&self, layer: &str) -> bool {
        self.view.layers.contains(layer)
    }

    pub(super) fn area(&mut self, rings: Vec<Vec<[f64; 2]>>, colour: &str, opacity: f64) {
        let fill = self.colour(colour).faded(opacity);
        self.drawing.items.push(Item::Area { rings, fill });
    }

    pub(super) fn line(&mut self, points: Vec<[f64; 2]>, colour: Colour, width: f64) {
        self.dashed(points, false, colour, width, &[]);
    }

    pub(super) fn dashed(
        &mut self,
        points: Vec<[f64; 2]>,
        closed: bool,
        colour: Colour,
        width: f64,
        dash: &[f64],
    ) {
        let room = 200.0;
        let [w, h] = self.view.camera.size;
        let near =
            |p: &[f64; 2]| (-room..w + room).contains(&p[0]) && (-room..h + room).contains(&p[1]);
        // A line wholly outside is not drawn; a long one through the view is.
        let (low, high) = bounds(&points);
        let apart = low[0] > w + room || low[1] > h + room || high[0] < -room || high[1] < -room;
        if points.iter().all(|p| p[0].is_finite() && p[1].is_finite())
            && (points.iter().any(near) || !apart)
        {
            let dash = dash.to_vec();
            self.drawing.items.push(Item::Line { points, closed, colour, width, dash });
        }
    }

    pub(super) fn disc(
        &mut self,
        at: [f64; 2],
        radius: f64,
        fill: Option<Colour>,
        stroke: Option<(Colour, f64)>,
    ) {
        if self.inside(at, radius + 4.0) {
            self.drawing.items.push(Item::Disc { at, radius, fill, stroke });
        }
    }

    pub(super) fn text(
        &mut self,
        at: [f64; 2],
        text: &str,
        size: f64,
        bold: bool,
        colour: &str,
        anchor: Anchor,
    ) {
        let colour = self.colour(colour);
        let text = text.to_owned();
        self.drawing.items.push(Item::Text { at, text, size, bold, colour, anchor });
    }

    /// Whether a point is in the view or so near to it.
    pub(super) fn inside(&self, at: [f64; 2], room: f64) -> bool {
        let [w, h] = self.view.camera.size;
        (-room..w + room).contains(&at[0]) && (-room..h + room).contains(&at[1])
    }

    /// Scale bar and north arrow.
    fn scale(&mut self) {
        let camera = &self.view.camera;
        let ([width, height], scale) = (camera.size, camera.scale);
        let power = libm::pow(10.0, libm::floor(libm::log10(110.0 / scale)));
        let most = 110.0 / scale;
        let metres = [5.0, 2.0, 1.0].map(|k| k * power).into_iter().find(|m| *m <= most);
        let metres = metres.unwrap_or(power);
        let (w, dim) = (metres * scale, self.colour("dim"));
        let (x, y) = (width - w - 16.0, height - 14.0);
        self.line(vec![[x, y - 5.0], [x, y], [x + w, y], [x + w, y - 5.0]], dim, 1.2);
        let words = if metres >= 1000.0 {
            format!("{} km", metres / 1000.0)
        } else {
            format!("{metres} m")
        };
        self.text([x + w / 2.0, y - 5.0], &words, 10.0, false, "dim", Anchor::Middle);
        let (sin, cos) = (libm::sin(camera.rot_rad), libm::cos(camera.rot_rad));
        let (mx, my) = (width - 24.0, height - 56.0);
        // Turned against the view, as the page does.
        let turned = |[px, py]: [f64; 2]| [mx + px * cos + py * sin, my - px * sin + py * cos];
        let arrow = [[0.0, -16.0], [5.0, 0.0], [0.0, -4.0], [-5.0, 0.0]].map(turned);
        self.area(vec![arrow.to_vec()], "dim", 1.0);
        let [nx, ny] = turned([0.0, 12.0]);
        self.text([nx, ny], "N", 10.0, false, "dim", Anchor::Middle);
    }
}

/// Smallest and largest x and y.
pub(super) fn bounds(points: &[[f64; 2]]) -> ([f64; 2], [f64; 2]) {
    points.iter().fold(([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]), |(low, high), p| {
        ([low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])])
    })
}

/// A box as a ring.
pub(super) fn corners(x: f64, y: f64, w: f64, h: f64) -> Vec<[f64; 2]> {
    vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]]
}

/// Dots behind a track, at most.
pub const DOTS: usize = TRAIL;
