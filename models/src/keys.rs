//! Keys of scene files as data: what each may hold, in which unit and limits, what it is for.
//!
//! A table of keys is the one place that knows them: the reader takes kinds and limits from it, checks of models their
//! limits, and reference, schema and completion are made of it.

/// What a key holds.
#[derive(Clone, Copy, Debug)]
pub enum Holds {
    /// A number within limits, ends included.
    Number {
        /// Least value.
        least: f64,
        /// Largest value.
        most: f64,
    },
    /// A whole number within limits, ends included.
    Whole {
        /// Least value.
        least: i64,
        /// Largest value.
        most: i64,
    },
    /// True or false.
    Flag,
    /// Any text.
    Text,
    /// A file, by its path from the folder of the scene.
    File,
    /// One word of a list.
    Word(fn() -> Vec<&'static str>),
    /// A date with time and offset.
    Time,
    /// A list of numbers within limits.
    Numbers {
        /// Least value.
        least: f64,
        /// Largest value.
        most: f64,
    },
    /// A number within limits, or a list of such numbers.
    NumberOrNumbers {
        /// Least value.
        least: f64,
        /// Largest value.
        most: f64,
    },
    /// A list of lists of numbers.
    Rows,
    /// A list of texts.
    Texts,
    /// A number within 0 to 1, or a list of names.
    ShareOrNames,
    /// A whole number within limits, or one word.
    WholeOr {
        /// Least value.
        least: i64,
        /// Largest value.
        most: i64,
        /// The word.
        word: &'static str,
    },
    /// A value for all federates, or a table of values by name.
    ByName(&'static Holds),
    /// A table.
    Table(&'static [Key]),
    /// A list of tables.
    Tables(&'static [Key]),
    /// A place: a table with [`PLACE`].
    Place,
    /// A list of tables, each with a place ([`PLACE`]) and these keys.
    Places(&'static [Key]),
    /// A table of names of the scene's own choosing, each with a number within 0 to 1.
    Shares,
    /// A table of names of the scene's own choosing, each with how many.
    Counts {
        /// Largest value.
        most: i64,
    },
    /// A table whose keys another key chooses.
    Open,
}

/// One key of a table of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// The key, unit last.
    pub word: &'static str,
    /// Unit of its number, as messages write it; empty for a pure number.
    pub unit: &'static str,
    /// What it holds.
    pub holds: Holds,
    /// Whether it has to be given.
    pub needed: bool,
    /// What holds where it is not given, for people; empty where nothing does.
    pub default: &'static str,
    /// What it is for: one line.
    pub doc: &'static str,
}

impl Key {
    /// A key with a line of text.
    #[must_use]
    pub const fn new(word: &'static str, holds: Holds, doc: &'static str) -> Self {
        Self { word, unit: "", holds, needed: false, default: "", doc }
    }

    /// A number in `unit` within limits.
    #[must_use]
    pub const fn number(
        word: &'static str,
        unit: &'static str,
        least: f64,
        most: f64,
        doc: &'static str,
    ) -> Self {
        Self { unit, ..Self::new(word, Holds::Number { least, most }, doc) }
    }

    /// A whole number within limits.
    #[must_use]
    pub const fn whole(word: &'static str, least: i64, most: i64, doc: &'static str) -> Self {
        Self::new(word, Holds::Whole { least, most }, doc)
    }

    /// True or false.
    #[must_use]
    pub const fn flag(word: &'static str, doc: &'static str) -> Self {
        Self::new(word, Holds::Flag, doc)
    }

    /// Any text.
    #[must_use]
    pub const fn text(word: &'static str, doc: &'static str) -> Self {
        Self::new(word, Holds::Text, doc)
    }

    /// One of some words.
    #[must_use]
    pub const fn word(
        word: &'static str,
        words: fn() -> Vec<&'static str>,
        doc: &'static str,
    ) -> Self {
        Self::new(word, Holds::Word(words), doc)
    }

    /// The same, which has to be given.
    #[must_use]
    pub const fn needed(mut self) -> Self {
        self.needed = true;
        self
    }

    /// The same, with what holds where it is not given.
    #[must_use]
    pub const fn or(mut self, default: &'static str) -> Self {
        self.default = default;
        self
    }
}

/// The key of that word in groups of keys.
#[must_use]
pub fn find(groups: &[&'static [Key]], word: &str) -> Option<&'static Key> {
    groups.iter().flat_map(|group| group.iter()).find(|key| key.word == word)
}

/// Keys of a place: by latitude and longitude, or from the reference point.
pub const PLACE: &[Key] = &[
    Key::number("lat_deg", "°", -90.0, 90.0, "Latitude; goes with `lon_deg`"),
    Key::number("lon_deg", "°", -180.0, 180.0, "Longitude"),
    Key::number("east_m", "m", -1e6, 1e6, "East of the reference point; goes with `north_m`"),
    Key::number("north_m", "m", -1e6, 1e6, "North of the reference point"),
    Key::number("x_m", "m", -1e6, 1e6, "The same as `east_m`, as logs call it; goes with `y_m`"),
    Key::number("y_m", "m", -1e6, 1e6, "The same as `north_m`"),
    Key::number("height_m", "m", -500.0, 9000.0, "Height above the reference plane"),
];
