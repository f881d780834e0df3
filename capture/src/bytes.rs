//! Numbers out of octets, in either order; a missing octet gives `None`.

/// Order of octets in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    Little,
    Big,
}

impl Order {
    pub(crate) fn u16(self, octets: &[u8], at: usize) -> Option<u16> {
        let raw = array(octets, at)?;
        Some(match self {
            Self::Little => u16::from_le_bytes(raw),
            Self::Big => u16::from_be_bytes(raw),
        })
    }

    pub(crate) fn u32(self, octets: &[u8], at: usize) -> Option<u32> {
        let raw = array(octets, at)?;
        Some(match self {
            Self::Little => u32::from_le_bytes(raw),
            Self::Big => u32::from_be_bytes(raw),
        })
    }

    pub(crate) fn i64(self, octets: &[u8], at: usize) -> Option<i64> {
        let raw = array(octets, at)?;
        Some(match self {
            Self::Little => i64::from_le_bytes(raw),
            Self::Big => i64::from_be_bytes(raw),
        })
    }
}

/// `N` octets of `octets` from `at` on.
pub(crate) fn array<const N: usize>(octets: &[u8], at: usize) -> Option<[u8; N]> {
    octets.get(at..at.checked_add(N)?)?.try_into().ok()
}

/// A number as the network writes it.
pub(crate) fn be16(octets: &[u8], at: usize) -> Option<u16> {
    Order::Big.u16(octets, at)
}
