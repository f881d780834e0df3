//! The building blocks of the wire format: values of fixed size, big-endian, and the macros that
//! declare records, PDU bodies and enumerations once for both directions.

/// A value that always has the same number of octets on the wire (big-endian, bits kept, NaN included).
///
/// Implemented for the numbers, for arrays, and for every record of the standard with a fixed size.
/// Not meant to be implemented outside this crate.
pub trait Wire: Sized {
    /// Octets on the wire.
    const SIZE: usize;
    /// Reads from exactly [`Self::SIZE`] octets.
    fn get(octets: &[u8]) -> Self;
    /// Writes to exactly [`Self::SIZE`] octets.
    fn put(&self, octets: &mut [u8]);
    /// For error messages: the first part that does not fit into `left` octets, and its offset.
    #[must_use]
    fn part_beyond(left: usize) -> Option<Part> {
        let _ = left;
        None
    }
}

/// A part of a record, for error messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// The part's name.
    pub name: &'static str,
    /// The part of that part, where it is a record itself.
    pub inner: Option<&'static str>,
    /// Octets from the start of the record.
    pub offset: usize,
    /// Octets that the innermost part needs.
    pub size: usize,
}

macro_rules! wire_number {
    ($($t:ty),*) => {$(
        impl Wire for $t {
            const SIZE: usize = size_of::<$t>();
            #[inline(always)]
            fn get(octets: &[u8]) -> Self {
                let mut bytes = [0; size_of::<$t>()];
                bytes.copy_from_slice(octets);
                <$t>::from_be_bytes(bytes)
            }
            #[inline(always)]
            fn put(&self, octets: &mut [u8]) {
                octets.copy_from_slice(&self.to_be_bytes());
            }
        }
    )*};
}
wire_number!(u8, u16, u32, u64, i8, i16, i32, i64, f32, f64);

impl<T: Wire + Copy + Default, const N: usize> Wire for [T; N] {
    const SIZE: usize = N * T::SIZE;
    #[inline(always)]
    fn get(octets: &[u8]) -> Self {
        let mut values = [T::default(); N];
        for (value, part) in values.iter_mut().zip(octets.chunks_exact(T::SIZE)) {
            *value = T::get(part);
        }
        values
    }
    #[inline(always)]
    fn put(&self, octets: &mut [u8]) {
        for (value, part) in self.iter().zip(octets.chunks_exact_mut(T::SIZE)) {
            value.put(part);
        }
    }
}

/// Declares a record of fixed size: a plain struct whose fields stand in wire order.
macro_rules! record {
    ($(#[$m:meta])* $name:ident { $($(#[$fm:meta])* $field:ident: $t:ty,)* }) => {
        $(#[$m])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $name { $($(#[$fm])* pub $field: $t,)* }

        impl $crate::wire::Wire for $name {
            const SIZE: usize = 0 $(+ <$t as $crate::wire::Wire>::SIZE)*;
            #[inline(always)]
            fn get(octets: &[u8]) -> Self {
                let mut rest = octets;
                $(
                    let (part, after) = rest.split_at(<$t as $crate::wire::Wire>::SIZE);
                    let $field = <$t as $crate::wire::Wire>::get(part);
                    rest = after;
                )*
                let _ = rest;
                Self { $($field,)* }
            }
            #[inline(always)]
            fn put(&self, octets: &mut [u8]) {
                let mut rest = octets;
                $(
                    let (part, after) = rest.split_at_mut(<$t as $crate::wire::Wire>::SIZE);
                    $crate::wire::Wire::put(&self.$field, part);
                    rest = after;
                )*
                let _ = rest;
            }
            #[cold]
            fn part_beyond(left: usize) -> Option<$crate::wire::Part> {
                let mut offset = 0;
                $(
                    let size = <$t as $crate::wire::Wire>::SIZE;
                    if offset + size > left {
                        let part = $crate::wire::Part {
                            name: stringify!($field), inner: None, offset, size,
                        };
                        let inner = <$t as $crate::wire::Wire>::part_beyond(left - offset);
                        return Some(inner.map_or(part, |i| $crate::wire::Part {
                            inner: Some(i.name), offset: offset + i.offset, size: i.size, ..part
                        }));
                    }
                    offset += size;
                )*
                let _ = offset;
                None
            }
        }
    };
}

/// Declares a PDU body whose size depends on its lists: a plain struct, its decoding and encoding.
/// `count n: u8 = list;` is a number on the wire only, computed from the list; `list name: T, n;` is
/// `n` records of type `T`.
macro_rules! body {
    ($(#[$m:meta])* $name:ident = $code:ident { $($items:tt)* }) => {
        body! { @ [$(#[$m])* $name $code] [reader writer this] [] [] [] [] [] $($items)* }
    };
    (@ $h:tt [$r:ident $w:ident $s:ident] [$($f:tt)*] [$($i:tt)*] [$($d:tt)*] [$($e:tt)*] [$($l:tt)*]
        count $n:ident: $t:ty = $list:ident; $($rest:tt)*) => {
        body! { @ $h [$r $w $s] [$($f)*] [$($i)*]
            [$($d)* let $n = $r.get::<$t>(stringify!($n))? as usize;]
            [$($e)* $w.count::<$t>($s.$list.len(), stringify!($list))?;]
            [$($l)* + <$t as $crate::wire::Wire>::SIZE]
            $($rest)* }
    };
    (@ $h:tt [$r:ident $w:ident $s:ident] [$($f:tt)*] [$($i:tt)*] [$($d:tt)*] [$($e:tt)*] [$($l:tt)*]
        $(#[$fm:meta])* list $n:ident: $t:ty, $c:ident; $($rest:tt)*) => {
        body! { @ $h [$r $w $s]
            [$($f)* $(#[$fm])* pub $n: $crate::list::List<'a, $t>,] [$($i)* $n,]
            [$($d)* let $n = $crate::list::List::decode($r, $c, stringify!($n))?;]
            [$($e)* $s.$n.encode($w)?;]
            [$($l)* + $s.$n.octet_len()]
            $($rest)* }
    };
    (@ $h:tt [$r:ident $w:ident $s:ident] [$($f:tt)*] [$($i:tt)*] [$($d:tt)*] [$($e:tt)*] [$($l:tt)*]
        $(#[$fm:meta])* $n:ident: $t:ty; $($rest:tt)*) => {
        body! { @ $h [$r $w $s]
            [$($f)* $(#[$fm])* pub $n: $t,] [$($i)* $n,]
            [$($d)* let $n = $r.get::<$t>(stringify!($n))?;]
            [$($e)* $w.put(&$s.$n);]
            [$($l)* + <$t as $crate::wire::Wire>::SIZE]
            $($rest)* }
    };
    (@ [$(#[$m:meta])* $name:ident $code:ident] [$r:ident $w:ident $s:ident]
        [$($f:tt)*] [$($i:tt)*] [$($d:tt)*] [$($e:tt)*] [$($l:tt)*]) => {
        $(#[$m])*
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct $name<'a> { $($f)* }

        impl<'a> $crate::codec::DecodeBody<'a> for $name<'a> {
            const PDU_TYPE: $crate::enumerations::PduType = $crate::enumerations::PduType::$code;
            fn decode_body(
                $r: &mut $crate::reader::Reader<'a>,
            ) -> Result<Self, $crate::reader::BodyError> {
                $($d)*
                Ok(Self { $($i)* })
            }
        }
        impl $crate::codec::EncodeBody for $name<'_> {
            fn pdu_type(&self) -> $crate::enumerations::PduType {
                $crate::enumerations::PduType::$code
            }
            fn body_len(&self) -> usize {
                let $s = self;
                let _ = $s;
                0 $($l)*
            }
            fn encode_body(
                &self,
                $w: &mut $crate::writer::Writer<'_>,
            ) -> Result<(), $crate::writer::EncodeError> {
                let $s = self;
                $($e)*
                Ok(())
            }
        }
    };
}

/// Makes a record of fixed size a PDU body.
macro_rules! fixed_body {
    ($name:ident = $code:ident) => {
        impl<'a> $crate::codec::DecodeBody<'a> for $name {
            const PDU_TYPE: $crate::enumerations::PduType = $crate::enumerations::PduType::$code;
            #[inline]
            fn decode_body(
                reader: &mut $crate::reader::Reader<'a>,
            ) -> Result<Self, $crate::reader::BodyError> {
                reader.record()
            }
        }
        impl $crate::codec::EncodeBody for $name {
            #[inline]
            fn pdu_type(&self) -> $crate::enumerations::PduType {
                $crate::enumerations::PduType::$code
            }
            #[inline]
            fn body_len(&self) -> usize {
                <Self as $crate::wire::Wire>::SIZE
            }
            #[inline]
            fn encode_body(
                &self,
                writer: &mut $crate::writer::Writer<'_>,
            ) -> Result<(), $crate::writer::EncodeError> {
                writer.put(self);
                Ok(())
            }
        }
    };
}

/// Declares an enumeration of SISO-REF-010: a number with names for those values that have one here.
macro_rules! enumeration {
    ($(#[$m:meta])* $name:ident: $t:ty { $($konst:ident = $value:literal $text:literal,)* }) => {
        $(#[$m])*
        #[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(
            /// The number on the wire, whether it has a name or not.
            pub $t,
        );

        impl $name {
            $(#[doc = concat!($text, ".")] pub const $konst: Self = Self($value);)*

            /// The value's name, where it has one here.
            #[must_use]
            pub fn name(self) -> Option<&'static str> {
                match self.0 {
                    $($value => Some($text),)*
                    _ => None,
                }
            }

            /// All named values, in the order of their numbers.
            pub const NAMED: &'static [Self] = &[$(Self::$konst),*];
        }
        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                match self.name() {
                    Some(name) => write!(f, "{name} ({})", self.0),
                    None => write!(f, "{}", self.0),
                }
            }
        }
        impl std::fmt::Debug for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                write!(f, concat!(stringify!($name), "({})"), self)
            }
        }
        impl $crate::wire::Wire for $name {
            const SIZE: usize = size_of::<$t>();
            #[inline(always)]
            fn get(octets: &[u8]) -> Self {
                Self(<$t as $crate::wire::Wire>::get(octets))
            }
            #[inline(always)]
            fn put(&self, octets: &mut [u8]) {
                $crate::wire::Wire::put(&self.0, octets);
            }
        }
    };
}
