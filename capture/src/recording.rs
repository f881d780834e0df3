//! A recording opened for playing: any datagram at once, any time at once.

use crate::error::OpenError;
use crate::index::{self, IN_BLOB, Index};
use crate::player::Timeline;
use std::fs::File;
use std::io;
use std::net::SocketAddr;
use std::os::unix::fs::FileExt;
use std::path::Path;

/// A file of datagrams with an index: every datagram can be read at once.
///
/// The index of a file of more than 8 MiB is kept beside it as `NAME.idx`, and made anew when it is
/// missing, damaged, or older than the file.
#[derive(Debug)]
pub struct Recording {
    file: File,
    index: Index,
    index_made: bool,
}

/// A PDU that tells a state which holds at some time; see [`Recording::alive_at`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AlivePdu {
    /// Number of the datagram that holds it, from 0.
    pub datagram: usize,
    /// Octets from the start of the datagram to the PDU.
    pub offset: usize,
}

impl Recording {
    /// Opens a file of any kind that [`crate::Reader`] reads.
    ///
    /// # Errors
    /// [`OpenError`], with the path.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        Self::open_with(path, |_| ())
    }

    /// As [`Recording::open`]; `progress` gets the octets read so far while the index is made.
    ///
    /// # Errors
    /// [`OpenError`], with the path.
    pub fn open_with(
        path: impl AsRef<Path>,
        mut progress: impl FnMut(u64),
    ) -> Result<Self, OpenError> {
        let (file, index, index_made) = index::open(path.as_ref(), &mut progress)?;
        Ok(Self { file, index, index_made })
    }

    /// Datagrams.
    #[must_use]
    pub fn len(&self) -> usize {
        self.index.entries.len()
    }

    /// True if there is no datagram.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.index.entries.is_empty()
    }

    /// True if the index was made at opening, false if it was found beside the file.
    #[must_use]
    pub fn index_made(&self) -> bool {
        self.index_made
    }

    /// What is wrong with the file: in words (the first hundred), and how many in all.
    #[must_use]
    pub fn problems(&self) -> (&[String], u64) {
        (&self.index.remarks, self.index.problems)
    }

    /// When datagram `i` is due, nanoseconds since 1970 UTC: its stamp, or the latest stamp before it
    /// where the clock was set back.
    #[must_use]
    pub fn time_ns(&self, i: usize) -> i64 {
        self.index.entries[i].utc_ns
    }

    /// The same recording on the schedule of its PDUs' timestamps instead of that of its arrivals: what
    /// was recorded from a run as fast as possible plays in the time that it simulated. The first
    /// datagram stays where it is. The clocks of several senders may differ: a sender's stamp more than
    /// 30 s behind the latest one or 120 s ahead of it tells no time but starts that sender's clock at
    /// the latest one. A stamp behind the latest one, and a datagram without, is due with the latest.
    #[must_use]
    pub fn by_stamps(mut self) -> Self {
        let times = self.index.times_by_stamps();
        for (entry, due_ns) in self.index.entries.iter_mut().zip(times) {
            entry.utc_ns = due_ns;
        }
        self
    }

    /// How long it lasts, ns: from the first datagram to the last, as they arrived and (as after
    /// [`Recording::by_stamps`]) by the PDUs' timestamps.
    #[must_use]
    pub fn lasts_ns(&self) -> (i64, i64) {
        let span = |first: Option<i64>, last: Option<i64>| last.unwrap_or(0) - first.unwrap_or(0);
        let entries = &self.index.entries;
        let times = self.index.times_by_stamps();
        (
            span(entries.first().map(|e| e.utc_ns), entries.last().map(|e| e.utc_ns)),
            span(times.first().copied(), times.last().copied()),
        )
    }

    /// Sender and receiver of datagram `i`.
    #[must_use]
    pub fn from_to(&self, i: usize) -> (SocketAddr, SocketAddr) {
        self.index.pairs[self.index.entries[i].pair as usize]
    }

    /// Number of the first datagram at or after `utc_ns` (the number of all of them if there is none).
    #[must_use]
    pub fn first_at(&self, utc_ns: i64) -> usize {
        self.index.first_at(utc_ns)
    }

    /// Reads the payload of datagram `i` into `into`, whose memory is used again.
    ///
    /// # Errors
    /// As the system says; also if the file has become shorter.
    pub fn payload(&self, i: usize, into: &mut Vec<u8>) -> io::Result<()> {
        let entry = self.index.entries[i];
        self.read(entry.place, entry.len as usize, into)
    }

    /// The state PDUs that hold at `utc_ns`, before the datagrams of that very time: the last Entity
    /// State of each entity, and the last PDU of each emitter, radio, transponder, aggregate and
    /// environmental process. Left out: what was removed, deactivated, or not told for `lasting_ns`
    /// (12 s in DIS: 2.4 heartbeats), unless it is told again within 12 times that (slow heartbeats of
    /// things that stand still).
    #[must_use]
    pub fn alive_at(&self, utc_ns: i64, lasting_ns: i64) -> Vec<AlivePdu> {
        let states = self.index.alive(self.first_at(utc_ns), utc_ns, lasting_ns);
        let pdu = |s: &index::State| AlivePdu {
            datagram: s.datagram as usize,
            offset: s.offset as usize,
        };
        states.iter().map(pdu).collect()
    }

    /// Reads the octets of a state PDU into `into`.
    ///
    /// # Errors
    /// As the system says; also if the file has become shorter or another.
    pub fn pdu(&self, pdu: AlivePdu, into: &mut Vec<u8>) -> io::Result<()> {
        let entry = self.index.entries[pdu.datagram];
        let left = (entry.len as usize).saturating_sub(pdu.offset);
        self.read(entry.place + pdu.offset as u64, left, into)?;
        let length = crate::bytes::be16(into, 8).map_or(0, usize::from);
        if length < 12 || length > into.len() {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "the recording was changed"));
        }
        into.truncate(length);
        Ok(())
    }

    fn read(&self, place: u64, len: usize, into: &mut Vec<u8>) -> io::Result<()> {
        into.clear();
        into.resize(len, 0);
        if place & IN_BLOB == 0 {
            return self.file.read_exact_at(into, place);
        }
        let start = (place & !IN_BLOB) as usize;
        let octets = self.index.blob.get(start..start + len);
        into.copy_from_slice(octets.ok_or(io::ErrorKind::UnexpectedEof)?);
        Ok(())
    }
}

impl Timeline for Recording {
    fn len(&self) -> usize {
        self.len()
    }
    fn time_ns(&self, i: usize) -> i64 {
        self.time_ns(i)
    }
}
