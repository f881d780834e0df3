//! Faults that can be planted in a plan on purpose: to show that the proof finds them.

/// A wrong bound, of a kind that plans have had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Targets have no size.
    NoExtent,
    /// Glint by its least instead of its largest value over the aspects.
    LeastGlint,
    /// No facade mirrors anything.
    NoWalls,
    /// The reflected polarisation at the far end of a box only, and a tenth of it.
    PolarisationAtOneEnd,
    /// The steps of the extractor carry nothing.
    NoFlips,
}

impl Fault {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::NoExtent,
        Self::LeastGlint,
        Self::NoWalls,
        Self::PolarisationAtOneEnd,
        Self::NoFlips,
    ];
}
