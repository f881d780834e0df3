//! What the house knows of a kind of sensor without knowing the sensor: its word, its looks, its keys, and what a tracker
//! assumes of it. Plots carry it; the sensors declare it, each in its own file ([`crate::sensors::declared`]).

use crate::draw::Purpose;
use crate::keys::Key;
use std::cmp::Ordering;
use std::fmt;

/// A kind of sensor as plain data.
#[derive(Debug)]
pub struct Kind {
    /// Word of scenes, messages and tables ("asde"); unique.
    pub word: &'static str,
    /// Name for people.
    pub title: &'static str,
    /// What it is and what of it is simulated: one sentence.
    pub about: &'static str,
    /// Colour of its plots on a dark and on a light page, `#rrggbb`.
    pub colours: [&'static str; 2],
    /// Mark of its plots, so that colour is not the only difference.
    pub symbol: Symbol,
    /// Whether it is a radar: it measures range and azimuth of an echo, and nobody tells it who that is.
    pub radar: bool,
    /// Whether a scene has to say where it stands.
    pub needs_site: bool,
    /// Whether a scene may say which targets carry it.
    pub carried: bool,
    /// Parameter sets by name with a line of text, the one that is taken by itself first.
    pub presets: &'static [(&'static str, &'static str)],
    /// Keys of its `overrides`, in groups.
    pub keys: &'static [&'static [Key]],
    /// Draws of its own, beside those that several kinds share.
    pub draws: &'static [Purpose],
    /// What a tracker assumes of it if nobody says more.
    pub assumed: Assumed,
}

/// A mark as polylines in a square from −1 to 1, right and down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Symbol(pub &'static [&'static [[f32; 2]]]);

impl Symbol {
    /// A square.
    pub const SQUARE: Self =
        Self(&[&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]]]);
    /// An upright cross.
    pub const PLUS: Self = Self(&[&[[-1.3, 0.0], [1.3, 0.0]], &[[0.0, -1.3], [0.0, 1.3]]]);
    /// A diagonal cross.
    pub const CROSS: Self = Self(&[&[[-0.8, -0.8], [0.8, 0.8]], &[[-0.8, 0.8], [0.8, -0.8]]]);
    /// A triangle on its base.
    pub const TRIANGLE: Self = Self(&[&[[0.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [0.0, -1.0]]]);
    /// A square on its corner.
    pub const DIAMOND: Self =
        Self(&[&[[0.0, -1.2], [1.2, 0.0], [0.0, 1.2], [-1.2, 0.0], [0.0, -1.2]]]);
    /// A triangle on its tip.
    pub const WEDGE: Self = Self(&[&[[0.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [0.0, 1.0]]]);
    /// Two triangles tip to tip.
    pub const HOURGLASS: Self =
        Self(&[&[[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [-1.0, -1.0]]]);
    /// An eight-cornered ring.
    pub const RING: Self = Self(&[&[
        [0.4, -1.0],
        [1.0, -0.4],
        [1.0, 0.4],
        [0.4, 1.0],
        [-0.4, 1.0],
        [-1.0, 0.4],
        [-1.0, -0.4],
        [-0.4, -1.0],
        [0.4, -1.0],
    ]]);
}

/// What a tracker assumes of a kind of sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assumed {
    /// Probability of a plot when one is due.
    pub detection: f64,
    /// Density of false plots and new targets, 1/m² and scan.
    pub false_density_m2: f64,
    /// White error beyond what a plot states, standard deviation, m.
    pub extra_sigma_m: f64,
    /// Share of a plot's variance that varies slowly instead of from plot to plot, 0 to 1.
    pub slow_share: f64,
    /// Correlation time of that share, s.
    pub slow_tau_s: f64,
}

impl Assumed {
    /// Nothing is known: white errors as stated.
    pub const NOTHING: Self = Self {
        detection: 0.95,
        false_density_m2: 1e-8,
        extra_sigma_m: 0.0,
        slow_share: 0.0,
        slow_tau_s: 1.0,
    };
}

/// The kind of a sensor, as plots carry it: its declaration.
#[derive(Clone, Copy)]
pub struct SensorKind(pub &'static Kind);

impl std::ops::Deref for SensorKind {
    type Target = Kind;

    fn deref(&self) -> &Kind {
        self.0
    }
}

impl PartialEq for SensorKind {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.0, other.0) || self.0.word == other.0.word
    }
}

impl Eq for SensorKind {}

impl PartialOrd for SensorKind {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for SensorKind {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.word.cmp(other.0.word)
    }
}

impl fmt::Debug for SensorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0.word)
    }
}
