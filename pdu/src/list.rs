//! Lists of records: borrowed from a datagram, borrowed from the caller, or owned.

use crate::reader::{BodyError, Reader};
use crate::wire::Wire;
use crate::writer::{EncodeError, Writer};

/// An element of a [`List`]: a record of fixed or of its own size.
///
/// Implemented for every [`Wire`] value and for the variable records of this crate.
pub trait Item<'a>: Sized + Clone {
    /// Octets, where all elements have the same number.
    const FIXED: Option<usize>;
    /// Reads one element.
    ///
    /// # Errors
    /// If the PDU ends inside it or its length contradicts its content.
    fn decode_item(reader: &mut Reader<'a>, field: &'static str) -> Result<Self, BodyError>;
    /// Octets of this element.
    fn item_len(&self) -> usize;
    /// Writes this element.
    ///
    /// # Errors
    /// If a length or count does not fit its field.
    fn encode_item(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError>;
}

impl<'a, T: Wire + Clone> Item<'a> for T {
    const FIXED: Option<usize> = Some(T::SIZE);
    #[inline]
    fn decode_item(reader: &mut Reader<'a>, field: &'static str) -> Result<Self, BodyError> {
        reader.get(field)
    }
    #[inline]
    fn item_len(&self) -> usize {
        T::SIZE
    }
    #[inline]
    fn encode_item(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        writer.put(self);
        Ok(())
    }
}

/// A list of records inside a PDU.
///
/// Decoding borrows the octets of the datagram (checked once, nothing copied); for encoding, give a
/// slice or a `Vec`:
///
/// ```
/// use pdu::{List, records::FixedDatum};
/// let datums = [FixedDatum { id: pdu::enumerations::DatumId(240_000), value: [0, 0, 0, 7] }];
/// let list = List::from(&datums[..]);
/// assert_eq!(list.len(), 1);
/// assert_eq!(list.iter().next(), Some(datums[0]));
/// ```
#[derive(Clone)]
pub struct List<'a, T> {
    inner: Inner<'a, T>,
}

#[derive(Clone)]
enum Inner<'a, T> {
    /// `count` elements, sound, as they came.
    Octets(&'a [u8], usize),
    Items(&'a [T]),
    Owned(Vec<T>),
}

impl<'a, T> Default for List<'a, T> {
    fn default() -> Self {
        Self { inner: Inner::Items(&[]) }
    }
}

impl<'a, T> From<&'a [T]> for List<'a, T> {
    fn from(items: &'a [T]) -> Self {
        Self { inner: Inner::Items(items) }
    }
}

impl<'a, T, const N: usize> From<&'a [T; N]> for List<'a, T> {
    fn from(items: &'a [T; N]) -> Self {
        Self { inner: Inner::Items(items) }
    }
}

impl<T> From<Vec<T>> for List<'_, T> {
    fn from(items: Vec<T>) -> Self {
        Self { inner: Inner::Owned(items) }
    }
}

impl<'a, T: Item<'a>> List<'a, T> {
    #[inline]
    pub(crate) fn decode(
        reader: &mut Reader<'a>,
        count: usize,
        field: &'static str,
    ) -> Result<Self, BodyError> {
        let octets = match T::FIXED {
            Some(size) => reader.take(count.saturating_mul(size), field)?,
            None => {
                let mut probe = reader.clone();
                for _ in 0..count {
                    T::decode_item(&mut probe, field)?;
                }
                reader.take(probe.offset() - reader.offset(), field)?
            }
        };
        Ok(Self { inner: Inner::Octets(octets, count) })
    }

    /// As many elements as there are octets left.
    pub(crate) fn decode_rest(
        reader: &mut Reader<'a>,
        field: &'static str,
    ) -> Result<Self, BodyError> {
        let mut probe = reader.clone();
        let mut count = 0;
        while probe.left() > 0 {
            T::decode_item(&mut probe, field)?;
            count += 1;
        }
        let octets = reader.take(reader.left(), field)?;
        Ok(Self { inner: Inner::Octets(octets, count) })
    }

    /// Number of elements.
    #[must_use]
    #[inline]
    pub fn len(&self) -> usize {
        match &self.inner {
            Inner::Octets(_, count) => *count,
            Inner::Items(items) => items.len(),
            Inner::Owned(items) => items.len(),
        }
    }

    /// True if there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The elements, in wire order.
    #[must_use]
    #[inline]
    pub fn iter(&self) -> Iter<'_, 'a, T> {
        match &self.inner {
            Inner::Octets(octets, count) => {
                Iter { octets: Reader::new(octets, 0), left: *count, items: [].iter() }
            }
            Inner::Items(items) => {
                Iter { octets: Reader::new(&[], 0), left: 0, items: items.iter() }
            }
            Inner::Owned(items) => {
                Iter { octets: Reader::new(&[], 0), left: 0, items: items.iter() }
            }
        }
    }

    /// Octets on the wire.
    #[must_use]
    #[inline]
    pub fn octet_len(&self) -> usize {
        let items = match (&self.inner, T::FIXED) {
            (Inner::Octets(octets, _), _) => return octets.len(),
            (_, Some(size)) => return self.len() * size,
            (Inner::Items(items), None) => items,
            (Inner::Owned(items), None) => items.as_slice(),
        };
        // Not by `iter`, which clones, and so allocates for elements that own lists.
        items.iter().map(Item::item_len).sum()
    }

    #[inline]
    pub(crate) fn encode(&self, writer: &mut Writer<'_>) -> Result<(), EncodeError> {
        match &self.inner {
            Inner::Octets(octets, _) => {
                writer.octets(octets);
                Ok(())
            }
            Inner::Items(items) => items.iter().try_for_each(|item| item.encode_item(writer)),
            Inner::Owned(items) => items.iter().try_for_each(|item| item.encode_item(writer)),
        }
    }
}

impl<'a, T: Item<'a> + 'static> List<'a, T> {
    /// The same list without a borrow; allocates unless it is empty or owned already.
    #[must_use]
    pub fn into_owned(self) -> List<'static, T> {
        match self.inner {
            Inner::Owned(items) => List { inner: Inner::Owned(items) },
            _ => List { inner: Inner::Owned(self.iter().collect()) },
        }
    }
}

/// The elements of a [`List`].
#[derive(Clone, Debug)]
pub struct Iter<'s, 'a, T> {
    octets: Reader<'a>,
    left: usize,
    items: std::slice::Iter<'s, T>,
}

impl<'a, T: Item<'a>> Iterator for Iter<'_, 'a, T> {
    type Item = T;

    #[inline]
    fn next(&mut self) -> Option<T> {
        if self.left > 0 {
            self.left -= 1;
            // The list was walked when it was decoded, so this cannot fail.
            return T::decode_item(&mut self.octets, "element").ok();
        }
        self.items.next().cloned()
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let n = self.left + self.items.len();
        (n, Some(n))
    }
}

impl<'a, T: Item<'a> + PartialEq> PartialEq for List<'a, T> {
    fn eq(&self, other: &Self) -> bool {
        self.len() == other.len() && self.iter().eq(other.iter())
    }
}

impl<'a, T: Item<'a> + std::fmt::Debug> std::fmt::Debug for List<'a, T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}
