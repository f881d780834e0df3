//! ASTERIX, the format in which surveillance data travels: octets to values and back.
//!
//! Categories 004, 010, 011, 019, 020, 021 (with the surface ground vector of its reserved expansion
//! field), 034, 048, 062, 065 and 247, each one [table](categories) that decoder, encoder, [JSON](json) and
//! [checks](presence) read. The crate knows no sockets and no clocks; [`files`] reads and writes the forms in which
//! recordings travel.
//!
//! # Reading
//!
//! [`blocks`] walks a datagram without allocating. Every item is found and fits before a [`Record`] is given out; a
//! damaged record or header is refused with offset, item and reason, what came before it counts, and a block of an
//! unknown category is passed over by its length. [`Record::each`] reads all of a record in one pass, the accessors single items.
//!
//! ```
//! use asterix::{blocks, cat010};
//! let datagram = [0x0a, 0, 10, 0xd0, 0, 7, 2, 0x46, 0x50, 0];
//! for block in blocks(&datagram) {
//!     for record in block?.records() {
//!         let record = record?;
//!         assert_eq!(record.numbers(&cat010::I010), Some([0.0, 7.0])); // SAC, SIC
//!         assert_eq!(record.number(&cat010::I000), Some(2.0)); // start of update cycle
//!         assert_eq!(record.number(&cat010::I140), Some(36_000.0)); // s since midnight UTC
//!     }
//! }
//! # Ok::<(), asterix::DecodeError>(())
//! ```
//!
//! # Writing
//!
//! A [`Packer`] fills datagrams; items go in the order of the table, each with the values of its fields. Quantities are
//! rounded to the nearest step and clipped at their limits, angles and the time of day wrap; a code that does not fit, a text
//! that is too long or a NaN is refused.
//!
//! ```
//! use asterix::{Packer, cat065, DATAGRAM_LIMIT};
//! let mut packer = Packer::new(DATAGRAM_LIMIT);
//! packer.record(&cat065::CATEGORY, |items| {
//!     items.put(&cat065::I010, &[0, 200])?;
//!     items.put(&cat065::I000, &[2])?; // end of batch
//!     items.put(&cat065::I030, &[32_402.03])?;
//!     items.put(&cat065::I020, &[255])
//! })?;
//! assert_eq!(packer.take(), [[0x41, 0, 11, 0xd8, 0, 200, 2, 0x3f, 0x49, 4, 255]]);
//! # Ok::<(), asterix::EncodeError>(())
//! ```

mod buffer;
pub mod categories;
mod decode;
mod encode;
mod error;
pub mod files;
pub mod json;
mod lengths;
mod pack;
pub mod presence;
pub mod table;
pub mod time;
mod value;
mod view;

pub use categories::{
    cat004, cat010, cat011, cat019, cat020, cat021, cat034, cat048, cat062, cat065, cat247,
};
pub use decode::{Block, Blocks, Record, Records, blocks};
pub use encode::{EncodeError, ItemWriter, Reason, Refused, record};
pub use error::{DecodeError, Fault};
pub use pack::{DATAGRAM_LIMIT, Packer};
pub use table::Category;
pub use value::{DAY_S, FieldValue, Text, Value, ValueError};
pub use view::{Datum, PartView, Parts, View};

/// Every category, in the order of their numbers.
pub static CATEGORIES: &[&Category] = &[
    &cat004::CATEGORY,
    &cat010::CATEGORY,
    &cat011::CATEGORY,
    &cat019::CATEGORY,
    &cat020::CATEGORY,
    &cat021::CATEGORY,
    &cat034::CATEGORY,
    &cat048::CATEGORY,
    &cat062::CATEGORY,
    &cat065::CATEGORY,
    &cat247::CATEGORY,
];

/// The table of a category.
#[must_use]
pub fn category(number: u8) -> Option<&'static Category> {
    CATEGORIES.iter().find(|c| c.number == number).copied()
}
