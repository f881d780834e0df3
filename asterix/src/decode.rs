//! Octets to records, items and values, without allocating.

use crate::error::{DecodeError, Fault};
use crate::lengths::{Damage, item_end, specification};
use crate::table::{Category, Item, MOST_POSITIONS};
use crate::view::{Datum, View, each};

/// The blocks of a datagram, in order. A damaged header ends them; what came before it counts.
#[must_use]
pub fn blocks(datagram: &[u8]) -> Blocks<'_> {
    Blocks { datagram, at: 0 }
}

/// See [`blocks`].
#[derive(Clone, Debug)]
pub struct Blocks<'a> {
    datagram: &'a [u8],
    at: usize,
}

impl<'a> Iterator for Blocks<'a> {
    type Item = Result<Block<'a>, DecodeError>;

    fn next(&mut self) -> Option<Self::Item> {
        let offset = self.at;
        let rest = &self.datagram[offset..];
        let &[number, high, low, ..] = rest else {
            self.at = self.datagram.len();
            let fault = Fault::HeaderCut { left: rest.len() };
            let category = rest.first().copied();
            return (!rest.is_empty()).then_some(Err(header(offset, category, fault)));
        };
        let length = usize::from(u16::from_be_bytes([high, low]));
        let fault = if length < 3 {
            Fault::LengthTooSmall { length }
        } else if length > rest.len() {
            Fault::LengthBeyond { length, left: rest.len() }
        } else {
            self.at += length;
            let category = crate::category(number);
            return Some(Ok(Block { number, category, offset, octets: &rest[..length] }));
        };
        self.at = self.datagram.len();
        Some(Err(header(offset, Some(number), fault)))
    }
}

fn header(offset: usize, category: Option<u8>, fault: Fault) -> DecodeError {
    DecodeError { offset, category, record: 0, item: None, subitem: None, fault }
}

/// A data block: records of one category.
#[derive(Clone, Copy, Debug)]
pub struct Block<'a> {
    /// Category number.
    pub number: u8,
    /// Its table; `None` for a category that this crate does not know.
    pub category: Option<&'static Category>,
    /// Where in the datagram the block begins.
    pub offset: usize,
    octets: &'a [u8],
}

impl<'a> Block<'a> {
    /// The whole block with its header.
    #[must_use]
    pub fn octets(&self) -> &'a [u8] {
        self.octets
    }

    /// Its records in order, none for an unknown category. A damaged one ends them.
    #[must_use]
    pub fn records(&self) -> Records<'a> {
        Records { block: *self, at: 3, record: 0 }
    }

    /// Whether every record is sound; with their number.
    ///
    /// # Errors
    /// The first damage.
    pub fn check(&self) -> Result<usize, DecodeError> {
        let mut count = 0;
        for record in self.records() {
            record?;
            count += 1;
        }
        Ok(count)
    }
}

/// The records of a block, see [`Block::records`].
#[derive(Clone, Debug)]
pub struct Records<'a> {
    block: Block<'a>,
    at: usize,
    record: usize,
}

impl<'a> Iterator for Records<'a> {
    type Item = Result<Record<'a>, DecodeError>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        let category = self.block.category?;
        let rest = &self.block.octets[self.at..];
        if rest.is_empty() {
            return None;
        }
        self.record += 1;
        let offset = self.block.offset + self.at;
        match Record::read(category, rest, offset) {
            Ok(record) => {
                self.at += record.length;
                Some(Ok(record))
            }
            Err(damage) => {
                self.at = self.block.octets.len();
                Some(Err(DecodeError {
                    offset: offset + damage.at,
                    category: Some(category.number),
                    record: self.record,
                    item: damage.item,
                    subitem: damage.subitem,
                    fault: damage.fault,
                }))
            }
        }
    }
}

/// One record; its items have been found and fit.
#[derive(Clone, Copy, Debug)]
pub struct Record<'a> {
    /// The table.
    pub category: &'static Category,
    /// Where in the datagram it begins.
    pub offset: usize,
    /// From the record's beginning to the end of its block, and how many of them are its own.
    rest: &'a [u8],
    length: usize,
    /// Bit n: position n is there.
    present: u64,
    /// Beginnings of the items that are there, in order, and the end.
    starts: [u16; MOST_POSITIONS + 1],
}

impl<'a> Record<'a> {
    #[inline]
    fn read(category: &'static Category, rest: &'a [u8], offset: usize) -> Result<Self, Damage> {
        let (present, mut at) = specification(category.uap, rest)?;
        let mut starts = [0; MOST_POSITIONS + 1];
        let mut count = 0;
        let mut left = present;
        while left != 0 {
            let position = left.trailing_zeros() as usize;
            left &= left - 1;
            let Some(item) = category.uap[position] else {
                return Err(Fault::SparePosition { position: position + 1 }.into());
            };
            // A block has at most 65535 octets.
            starts[count] = at as u16;
            count += 1;
            at = item_end(item, rest, at)?;
        }
        if count == 0 {
            return Err(Fault::Empty.into());
        }
        starts[count] = at as u16;
        Ok(Self { category, offset, rest, length: at, present, starts })
    }

    /// The octets of the record, FSPEC first.
    #[must_use]
    pub fn octets(&self) -> &'a [u8] {
        &self.rest[..self.length]
    }

    /// The items that are there, in order.
    pub fn items(&self) -> impl Iterator<Item = View<'a>> {
        let (mut left, mut count) = (self.present, 0);
        std::iter::from_fn(move || {
            while left != 0 {
                let position = left.trailing_zeros() as usize;
                left &= left - 1;
                count += 1;
                if let Some(item) = self.category.uap[position] {
                    return Some(self.view(item, count - 1));
                }
            }
            None
        })
    }

    #[inline]
    fn view(&self, item: &'static Item, count: usize) -> View<'a> {
        let (from, to) = (usize::from(self.starts[count]), usize::from(self.starts[count + 1]));
        View::new(item, &self.rest[from..], to - from)
    }

    /// Gives every field that carries a value to `take`: item by item, subitem by subitem, in the order of the octets.
    ///
    /// The fastest way to read a whole record: bits are cut out once and scaled only when asked for.
    ///
    /// ```
    /// use asterix::{blocks, cat010};
    /// let datagram = [0x0a, 0, 10, 0xd0, 0, 7, 2, 0x46, 0x50, 0];
    /// let record = blocks(&datagram).next().unwrap()?.records().next().unwrap()?;
    /// let mut found = Vec::new();
    /// record.each(|datum| found.push((datum.item.id, datum.field.name, datum.raw, datum.number())));
    /// assert_eq!(found[1], ("010", "SIC", 7, Some(7.0)));
    /// assert_eq!(found[3], ("140", "", 4_608_000, Some(36_000.0)));
    /// # Ok::<(), asterix::DecodeError>(())
    /// ```
    #[inline]
    pub fn each(&self, mut take: impl FnMut(Datum)) {
        let (mut left, mut count) = (self.present, 0);
        while left != 0 {
            let position = left.trailing_zeros() as usize;
            left &= left - 1;
            if let Some(item) = self.category.uap[position] {
                let from = usize::from(self.starts[count]);
                each(item, &self.rest[from..], &mut take);
            }
            count += 1;
        }
    }

    /// The item of this row, if it is there (and the row is of this category).
    #[inline]
    #[must_use]
    pub fn get(&self, item: &'static Item) -> Option<View<'a>> {
        let position = usize::from(item.position);
        let there = self.present >> position & 1 == 1
            && self.category.uap[position].is_some_and(|own| own.is(item));
        there.then(|| {
            let before = self.present & ((1 << position) - 1);
            self.view(item, before.count_ones() as usize)
        })
    }

    /// The item of these three digits (or `RE`, `SP`), if it is there.
    #[must_use]
    pub fn find(&self, id: &str) -> Option<View<'a>> {
        self.items().find(|view| view.item.id == id)
    }

    /// System area code and identification code of who sent it (item 010).
    #[must_use]
    pub fn source(&self) -> Option<(u8, u8)> {
        let mut codes = self.find("010")?.data().filter_map(|datum| u8::try_from(datum.raw).ok());
        Some((codes.next()?, codes.next()?))
    }

    /// First number of an item.
    #[must_use]
    pub fn number(&self, item: &'static Item) -> Option<f64> {
        self.get(item)?.data().next()?.number()
    }

    /// The first `N` numbers of an item.
    #[must_use]
    pub fn numbers<const N: usize>(&self, item: &'static Item) -> Option<[f64; N]> {
        let mut data = self.get(item)?.data();
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = data.next()?.number()?;
        }
        Some(numbers)
    }
}
