//! The tables: one file a category, one row an item.
//!
//! Sources: the EUROCONTROL category specifications of the editions named in each file, in the machine-readable
//! form of asterix-specs. Fields have their names there, but for those that a reader would not
//! know (`M3A` for a Mode 3/A code, `ID` for a call sign, `ALT` for an altitude). Three rows follow the decoders of the
//! field instead of that text: I010/202 and 210 have an LSB of 0.25 (the stated ranges fit no other),
//! the correlation in I020/500 and the level of I048/090 are signed.

pub mod cat004;
pub mod cat010;
pub mod cat011;
pub mod cat019;
pub mod cat020;
pub mod cat021;
pub mod cat034;
pub mod cat048;
pub mod cat062;
pub mod cat065;
pub mod cat247;
