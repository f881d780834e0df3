//! Records to blocks, and blocks to datagrams.

use crate::buffer::Buffer;
use crate::encode::{EncodeError, ItemWriter, Reason, append};
use crate::table::Category;

/// Octets of a datagram that every network carries in one piece with room for tunnels.
pub const DATAGRAM_LIMIT: usize = 1400;

/// Packs records into blocks and blocks into datagrams: records of one category share a block, several blocks share a
/// datagram, a record is never split.
#[derive(Debug)]
pub struct Packer {
    limit: usize,
    done: Vec<Vec<u8>>,
    current: Buffer,
    /// Beginning and category of the open block.
    open: Option<(usize, u8)>,
    /// Octets of the last record's field specification: the next one's are likely as many, and nothing has to be moved.
    room: usize,
}

impl Packer {
    /// A packer of datagrams of at most `limit` octets (see [`DATAGRAM_LIMIT`]; at most 65 507).
    #[must_use]
    pub fn new(limit: usize) -> Self {
        let limit = limit.min(65_507);
        Self { limit, done: Vec::new(), current: Self::empty(limit), open: None, room: 1 }
    }

    /// A datagram of `limit` octets and the record that no longer fits.
    fn empty(limit: usize) -> Buffer {
        Buffer { octets: vec![0; limit + 512], end: 0 }
    }

    /// Adds a record.
    ///
    /// # Errors
    /// Those of `write`, or if the record is larger than a datagram; then it is left out.
    pub fn record(
        &mut self,
        category: &'static Category,
        write: impl FnOnce(&mut ItemWriter<'_>) -> Result<(), EncodeError>,
    ) -> Result<(), EncodeError> {
        let fits = matches!(self.open, Some((_, number)) if number == category.number);
        let before = (self.current.end, self.open);
        if !fits {
            self.open = Some((self.current.end, category.number));
            self.current.extend(&[category.number, 0, 0]);
        }
        let from = self.current.end;
        if let Err(e) = append(&mut self.current, category, &mut self.room, write) {
            (self.current.end, self.open) = before;
            return Err(e);
        }
        if self.current.end > self.limit {
            // The record begins the next datagram.
            let octets = 3 + self.current.end - from;
            let record = self.current.octets[from..self.current.end].to_vec();
            (self.current.end, self.open) = before;
            if octets > self.limit {
                let reason = Reason::RecordTooLarge { octets, limit: self.limit };
                return Err(EncodeError::item("", reason));
            }
            self.close_datagram();
            self.open = Some((0, category.number));
            self.current.extend(&[category.number, 0, 0]);
            self.current.extend(&record);
        }
        self.close_length();
        Ok(())
    }

    /// The open block's length, as of now.
    #[inline]
    fn close_length(&mut self) {
        if let Some((start, _)) = self.open {
            let length = (self.current.end - start) as u16;
            self.current.octets[start + 1..start + 3].copy_from_slice(&length.to_be_bytes());
        }
    }

    fn close_datagram(&mut self) {
        if self.current.end > 0 {
            let full = std::mem::replace(&mut self.current, Self::empty(self.limit));
            let mut octets = full.octets;
            octets.truncate(full.end);
            self.done.push(octets);
        }
        self.open = None;
    }

    /// Ends the open block: the next record begins another one, in the same datagram if it fits.
    pub fn end_block(&mut self) {
        self.open = None;
    }

    /// The datagrams so far, the open one too.
    #[must_use]
    pub fn take(&mut self) -> Vec<Vec<u8>> {
        self.close_datagram();
        std::mem::take(&mut self.done)
    }
}
