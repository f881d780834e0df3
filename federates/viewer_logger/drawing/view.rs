//! What is looked at: where, how large, which layers, which colours; as the page's address says it.

use super::Colour;
use std::collections::{BTreeMap, BTreeSet};

/// From metres east and north to pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Middle of the view, m.
    pub centre_m: [f64; 2],
    /// Pixels a metre.
    pub scale: f64,
    /// Bearing that points up, rad.
    pub rot_rad: f64,
    /// Width and height, pixels.
    pub size: [f64; 2],
}

/// Least and largest pixels a metre.
const SCALES: [f64; 2] = [0.02, 40.0];

impl Camera {
    /// Pixels of a place.
    #[must_use]
    pub fn to_screen(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (dx, dy) = ((x - self.centre_m[0]) * self.scale, (y - self.centre_m[1]) * self.scale);
        let (sin, cos) = (libm::sin(self.rot_rad), libm::cos(self.rot_rad));
        [self.size[0] / 2.0 + dx * cos - dy * sin, self.size[1] / 2.0 - dx * sin - dy * cos]
    }

    /// Shows these places whole, with a margin in pixels.
    pub fn fit(&mut self, points_m: &[[f64; 2]], margin: f64) {
        if points_m.is_empty() {
            return;
        }
        let (sin, cos) = (libm::sin(self.rot_rad), libm::cos(self.rot_rad));
        let along: Vec<[f64; 2]> =
            points_m.iter().map(|[x, y]| [x * cos - y * sin, x * sin + y * cos]).collect();
        let (low, high) = super::bounds(&along);
        let scale =
            |axis: usize| (self.size[axis] - 2.0 * margin) / (high[axis] - low[axis]).max(1.0);
        self.scale = scale(0).min(scale(1)).clamp(SCALES[0], SCALES[1]);
        let (u, v) = ((low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0);
        self.centre_m = [u * cos + v * sin, -u * sin + v * cos];
    }
}

/// What is looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// From where.
    pub camera: Camera,
    /// Layers that are on.
    pub layers: BTreeSet<String>,
    /// Day colours instead of night's.
    pub day: bool,
    /// Call sign or `#12` of who is selected.
    pub selected: Option<String>,
    /// Length of the vectors, s.
    pub vector_s: f64,
    /// Dots behind a track.
    pub dots: usize,
    /// What the address asks for that depends on the airport or the targets.
    pub fit: Fit,
}

/// How the place of the view is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fit {
    /// The airport whole.
    Airport,
    /// The targets whole.
    Targets,
    /// As the address says.
    Given,
}

/// Letter in the address and name of every layer that is drawn here.
const LAYERS: [(char, &str); 14] = [
    ('k', "tracks"),
    ('t', "truth"),
    ('e', "errors"),
    ('l', "labels"),
    ('h', "history"),
    ('v', "vectors"),
    ('c', "ellipses"),
    ('w', "weather"),
    ('x', "taxiways"),
    ('s', "stands"),
    ('p', "plots"),
    ('b', "buildings"),
    ('a', "alerts"),
    ('g', "one second ago"),
];

impl View {
    /// The page's own view at the start, in a picture of this size.
    #[must_use]
    pub fn new(size: [f64; 2]) -> Self {
        let on = LAYERS.iter().filter(|l| l.0 != 'g').map(|l| l.1.to_owned());
        Self {
            camera: Camera { centre_m: [0.0; 2], scale: 0.2, rot_rad: 0.0, size },
            layers: on.collect(),
            day: false,
            selected: None,
            vector_s: 15.0,
            dots: super::DOTS,
            fit: Fit::Airport,
        }
    }

    /// Takes over what an address says after its `#`; keys that mean nothing to a picture are passed over.
    ///
    /// # Errors
    /// A value that cannot be read: which.
    pub fn read(&mut self, fragment: &str) -> Result<(), String> {
        for part in fragment.trim_start_matches('#').split('&').filter(|p| !p.is_empty()) {
            let Some((key, value)) = part.split_once('=') else { continue };
            let bad = || {
                format!(
                    "--view: {key}={value} cannot be read; copy the part of the page's address from # on"
                )
            };
            let number = |low: f64, high: f64| {
                let x: Option<f64> = value.parse().ok().filter(|x| (low..=high).contains(x));
                x.ok_or_else(bad)
            };
            match key {
                "x" => self.camera.centre_m[0] = number(-1e7, 1e7)?,
                "y" => self.camera.centre_m[1] = number(-1e7, 1e7)?,
                "z" => self.camera.scale = number(SCALES[0], SCALES[1])?,
                "rot" => self.camera.rot_rad = number(-1e4, 1e4)?.rem_euclid(360.0).to_radians(),
                "vec" => self.vector_s = number(0.0, 60.0)?,
                "hist" => self.dots = number(0.0, super::DOTS as f64)? as usize,
                "col" => {
                    self.day = match value {
                        "day" => true,
                        "night" => false,
                        _ => return Err(bad()),
                    }
                }
                "fit" => {
                    self.fit = match value {
                        "airport" => Fit::Airport,
                        "targets" => Fit::Targets,
                        _ => return Err(bad()),
                    }
                }
                "skin" if value == "controller" => {
                    for name in ["truth", "errors", "ellipses", "plots"] {
                        self.layers.remove(name);
                    }
                    self.vector_s = 30.0;
                }
                "lay" => {
                    let named = |l: &&(char, &str)| value.contains(l.0);
                    self.layers = LAYERS.iter().filter(named).map(|l| l.1.to_owned()).collect();
                }
                "sel" => self.selected = Some(decoded(value).ok_or_else(bad)?),
                _ => {}
            }
            if matches!(key, "x" | "y" | "z") {
                self.fit = Fit::Given;
            }
        }
        Ok(())
    }
}

/// A percent-encoded text.
fn decoded(value: &str) -> Option<String> {
    let mut octets = Vec::new();
    let mut rest = value.bytes();
    while let Some(octet) = rest.next() {
        if octet != b'%' {
            octets.push(octet);
            continue;
        }
        let digit = |o: Option<u8>| char::from(o?).to_digit(16);
        octets.push((digit(rest.next())? * 16 + digit(rest.next())?) as u8);
    }
    String::from_utf8(octets).ok()
}

/// Colours by their names in the page's style sheet, so that the two pictures cannot drift apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Palette(BTreeMap<String, Colour>);

const STYLE: &str = include_str!("../web/style.css");

impl Palette {
    /// By day or by night; kinds of sensors have theirs as `plot-WORD`.
    #[must_use]
    pub fn of(day: bool) -> Self {
        let mut colours = BTreeMap::new();
        let mut take = |selector: &str| {
            let Some((_, rest)) = STYLE.split_once(selector) else { return };
            let Some((rules, _)) = rest.split_once('}') else { return };
            for rule in rules.split(';') {
                let Some((name, value)) = rule.split_once(':') else { continue };
                if let (Some(name), Some(colour)) = (name.trim().strip_prefix("--"), hex(value)) {
                    colours.insert(name.to_owned(), colour);
                }
            }
        };
        take(":root {");
        if day {
            take(":root[data-colours=\"day\"] {");
        }
        for kind in super::super::picture::KindLook::all() {
            if let Some(colour) = hex(&kind.colours[usize::from(day)]) {
                colours.insert(format!("plot-{}", kind.word), colour);
            }
        }
        Self(colours)
    }

    /// The colour of a name; of one that is not there a grey.
    #[must_use]
    pub fn get(&self, name: &str) -> Colour {
        self.0.get(name).copied().unwrap_or(Colour { rgb: [128; 3], opacity: 1.0 })
    }

    /// Whether there is a colour of this name.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }
}

/// `#rrggbb` or `#rrggbbaa`.
fn hex(text: &str) -> Option<Colour> {
    let digits = text.trim().strip_prefix('#')?;
    let octet = |at: usize| u8::from_str_radix(digits.get(at..at + 2)?, 16).ok();
    let rgb = [octet(0)?, octet(2)?, octet(4)?];
    let opacity = if digits.len() == 8 { f64::from(octet(6)?) / 255.0 } else { 1.0 };
    Some(Colour { rgb, opacity })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_address_says_what_is_looked_at() {
        let mut view = View::new([1600.0, 1000.0]);
        view.read("#run=a&t=12&x=-120.5&y=40&z=0.5&rot=370&lay=kl&sel=A%20%C3%A9&col=day&new=1")
            .expect("read");
        assert_eq!(view.camera.centre_m, [-120.5, 40.0]);
        assert!((view.camera.rot_rad.to_degrees() - 10.0).abs() < 1e-9);
        assert_eq!(view.layers, ["labels", "tracks"].map(str::to_owned).into());
        assert_eq!((view.selected.as_deref(), view.fit, view.day), (Some("A é"), Fit::Given, true));
        for bad in ["z=0", "x=nan", "col=red", "sel=%zz", "fit=all"] {
            assert!(View::new([9.0; 2]).read(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_fitted_view_holds_every_point_and_touches_its_margin() {
        for rot_deg in [0.0, 33.0, 271.0_f64] {
            let mut camera = View::new([800.0, 500.0]).camera;
            camera.rot_rad = rot_deg.to_radians();
            let points = [[-1300.0, 20.0], [900.0, 700.0], [40.0, -1500.0]];
            camera.fit(&points, 44.0);
            let seen = points.map(|p| camera.to_screen(p));
            let (low, high) = super::super::bounds(&seen);
            let room = [low[0], low[1], 800.0 - high[0], 500.0 - high[1]];
            assert!(room.iter().all(|r| *r > 43.999), "{rot_deg}: {room:?}");
            assert!(room.iter().any(|r| (*r - 44.0).abs() < 1e-6), "{rot_deg}: {room:?}");
        }
    }

    #[test]
    fn every_colour_that_is_used_is_in_the_style_sheet() {
        for day in [false, true] {
            let palette = Palette::of(day);
            for name in [
                "ground",
                "panel",
                "text",
                "dim",
                "pavement",
                "pavement-edge",
                "runway",
                "runway-mark",
                "taxi",
                "taxi-name",
                "stand",
                "arrival",
                "departure",
                "vehicle",
                "unknown",
                "truth",
                "error",
                "rain",
                "select",
                "label-back",
                "plot-other",
                "plot-asde",
            ] {
                assert!(palette.has(name), "{name}");
            }
        }
        let back = Palette::of(false).get("label-back");
        assert!((back.opacity - 168.0 / 255.0).abs() < 1e-9, "{back:?}");
        assert_ne!(Palette::of(false).get("arrival"), Palette::of(true).get("arrival"));
    }
}
