//! Datagrams into a file: pcapng with stamps in nanoseconds, which Wireshark opens.
//!
//! Blocks are collected and written whole, in one call to the system per [`Recorder::flush`] (or per
//! 64 KiB): a process killed at any moment leaves a file in which at most what was collected since
//! then is missing, and a [`crate::Reader`] says so, because the closing statistics are missing.

use crate::container::{APPLICATION, LINK_OF_RECORDINGS};
use crate::frame::{MOST_PAYLOAD, build};
use std::fs::File;
use std::io::{self, Write};
use std::net::SocketAddr;
use std::path::Path;

/// Octets collected before they are written without being asked.
const BLOCK: usize = 64 * 1024;

/// Where a recording goes: a file, or something in a test that behaves as one.
pub trait Sink: Write {
    /// Cuts off what stands behind the first `len` octets, and goes on writing there.
    ///
    /// # Errors
    /// As the system says.
    fn cut_to(&mut self, len: u64) -> io::Result<()>;
}

impl Sink for File {
    fn cut_to(&mut self, len: u64) -> io::Result<()> {
        use std::io::{Seek, SeekFrom};
        self.set_len(len)?;
        self.seek(SeekFrom::Start(len)).map(|_| ())
    }
}

/// Why a recording is not complete.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The system took no more. Said once; what cannot be written until it takes more is counted,
    /// and the place is marked in the file by a comment.
    #[error(
        "recording {path}: {cause}; recording stands still after {written} bytes, free some space and it goes on"
    )]
    Write {
        /// The file as named by the caller.
        path: String,
        /// Octets that are safe in the file.
        written: u64,
        /// What the system said.
        cause: io::Error,
    },
    /// More octets than a UDP datagram can have.
    #[error("recording: a payload of {0} bytes does not fit a UDP datagram ({MOST_PAYLOAD})")]
    TooLong(usize),
}

/// Writes a recording.
#[derive(Debug)]
pub struct Recorder<W: Sink = File> {
    sink: W,
    path: String,
    /// Whole blocks not yet given to the system.
    pending: Vec<u8>,
    pending_datagrams: u64,
    /// Lost ones that comments in `pending` speak of.
    pending_gap: u64,
    /// Octets known to be in the file.
    written: u64,
    recorded: u64,
    lost: u64,
    /// Lost since the last datagram that was written.
    gap: u64,
    standing: bool,
    last_utc_ns: i64,
    closed: bool,
}

impl Recorder<File> {
    /// Makes the file (one that is there is overwritten) and writes what stands before the first
    /// datagram.
    ///
    /// # Errors
    /// As the system says: no such folder, no permission, disk full. A file that was not there is not there then.
    pub fn create(path: impl AsRef<Path>) -> io::Result<Self> {
        let path = path.as_ref();
        let new = !path.exists();
        let file = File::create(path)?;
        let recorder = Self::new(file, &path.display().to_string());
        if recorder.is_err() && new {
            let _ = std::fs::remove_file(path);
        }
        recorder
    }
}

impl<W: Sink> Recorder<W> {
    /// Records into anything; `name` is for error messages.
    ///
    /// # Errors
    /// If the first blocks cannot be written.
    pub fn new(mut sink: W, name: &str) -> io::Result<Self> {
        let mut start = Vec::new();
        block(&mut start, 0x0a0d_0d0a, |b| {
            b.extend_from_slice(&0x1a2b_3c4du32.to_le_bytes());
            b.extend_from_slice(&[1, 0, 0, 0]);
            // Length of the section: not known while it is written.
            b.extend_from_slice(&(-1i64).to_le_bytes());
            let application = concat!("seeds ", env!("CARGO_PKG_VERSION"));
            debug_assert!(application.starts_with(APPLICATION));
            option(b, 4, application.as_bytes());
            option(b, 0, &[]);
        });
        block(&mut start, 1, |b| {
            b.extend_from_slice(&LINK_OF_RECORDINGS.to_le_bytes());
            b.extend_from_slice(&[0, 0]);
            // No limit on the octets kept of a frame.
            b.extend_from_slice(&0u32.to_le_bytes());
            option(b, 2, b"dis");
            // Stamps in nanoseconds.
            option(b, 9, &[9]);
            option(b, 0, &[]);
        });
        sink.write_all(&start)?;
        Ok(Self {
            sink,
            path: name.to_owned(),
            pending: Vec::with_capacity(2 * BLOCK),
            pending_datagrams: 0,
            pending_gap: 0,
            written: start.len() as u64,
            recorded: 0,
            lost: 0,
            gap: 0,
            standing: false,
            last_utc_ns: 0,
            closed: false,
        })
    }

    /// Records one datagram, sound or not, that arrived at `utc_ns` (nanoseconds since 1970 UTC).
    /// It is in the file after the next [`Recorder::flush`], or when 64 KiB came together.
    ///
    /// # Errors
    /// [`RecordError::Write`] once when the system takes no more; while that lasts, datagrams are
    /// counted in [`Recorder::lost`] and calls succeed. [`RecordError::TooLong`].
    pub fn record(
        &mut self,
        utc_ns: i64,
        from: SocketAddr,
        to: SocketAddr,
        payload: &[u8],
    ) -> Result<(), RecordError> {
        self.record_with(utc_ns, from, to, payload, None)
    }

    /// As [`Recorder::record`], with a comment that Wireshark shows at the frame.
    ///
    /// # Errors
    /// As [`Recorder::record`].
    pub fn record_with(
        &mut self,
        utc_ns: i64,
        from: SocketAddr,
        to: SocketAddr,
        payload: &[u8],
        comment: Option<&str>,
    ) -> Result<(), RecordError> {
        if payload.len() > MOST_PAYLOAD {
            return Err(RecordError::TooLong(payload.len()));
        }
        self.last_utc_ns = self.last_utc_ns.max(utc_ns);
        let gap = std::mem::take(&mut self.gap);
        self.pending_gap += gap;
        block(&mut self.pending, 6, |b| {
            // Times before 1970 have no place in the format.
            let stamp = utc_ns.max(0) as u64;
            b.extend_from_slice(&0u32.to_le_bytes());
            b.extend_from_slice(&((stamp >> 32) as u32).to_le_bytes());
            b.extend_from_slice(&(stamp as u32).to_le_bytes());
            let lengths = b.len();
            b.extend_from_slice(&[0; 8]);
            let frame = b.len();
            build(b, from, to, payload);
            let len = ((b.len() - frame) as u32).to_le_bytes();
            b[lengths..lengths + 4].copy_from_slice(&len);
            b[lengths + 4..lengths + 8].copy_from_slice(&len);
            b.resize(frame + (b.len() - frame).next_multiple_of(4), 0);
            if gap > 0 {
                let text = format!("{gap} datagrams before this one could not be written");
                option(b, 1, text.as_bytes());
            }
            if let Some(text) = comment {
                option(b, 1, clip(text).as_bytes());
            }
            if gap > 0 || comment.is_some() {
                option(b, 0, &[]);
            }
        });
        self.pending_datagrams += 1;
        if self.pending.len() >= BLOCK { self.flush() } else { Ok(()) }
    }

    /// Gives everything collected to the system, which keeps it even if this process is killed.
    ///
    /// # Errors
    /// As [`Recorder::record`].
    pub fn flush(&mut self) -> Result<(), RecordError> {
        if self.pending.is_empty() {
            return Ok(());
        }
        let outcome = self.sink.write_all(&self.pending);
        match outcome {
            Ok(()) => {
                self.written += self.pending.len() as u64;
                self.recorded += self.pending_datagrams;
                self.standing = false;
            }
            Err(cause) => {
                // Half a block must not stay: what comes later would be taken for its end.
                // Where even that is refused, the reader finds the next sound block.
                let _ = self.sink.cut_to(self.written);
                self.lost += self.pending_datagrams;
                self.gap += self.pending_datagrams + self.pending_gap;
                if !self.standing {
                    self.standing = true;
                    self.drop_pending();
                    let (path, written) = (self.path.clone(), self.written);
                    return Err(RecordError::Write { path, written, cause });
                }
            }
        }
        self.drop_pending();
        Ok(())
    }

    fn drop_pending(&mut self) {
        self.pending.clear();
        self.pending_datagrams = 0;
        self.pending_gap = 0;
    }

    /// Datagrams safe in the file.
    #[must_use]
    pub fn recorded(&self) -> u64 {
        self.recorded
    }

    /// Datagrams that could not be written.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Octets in the file.
    #[must_use]
    pub fn written(&self) -> u64 {
        self.written
    }

    /// Writes what is left and the mark that the recording is complete. `dropped` is what the system
    /// is known to have thrown away before it reached the recorder. Also done on drop, errors
    /// ignored, with nothing dropped.
    ///
    /// # Errors
    /// As [`Recorder::record`].
    pub fn close(mut self, dropped: u64) -> Result<(), RecordError> {
        self.finish(dropped)
    }

    fn finish(&mut self, dropped: u64) -> Result<(), RecordError> {
        self.closed = true;
        self.flush()?;
        let (utc, received, lost) = (self.last_utc_ns.max(0) as u64, self.recorded, self.lost);
        block(&mut self.pending, 5, |b| {
            b.extend_from_slice(&0u32.to_le_bytes());
            let mut stamp = [0; 8];
            stamp[..4].copy_from_slice(&((utc >> 32) as u32).to_le_bytes());
            stamp[4..].copy_from_slice(&(utc as u32).to_le_bytes());
            b.extend_from_slice(&stamp);
            option(b, 3, &stamp);
            option(b, 4, &(received + lost + dropped).to_le_bytes());
            option(b, 5, &(dropped + lost).to_le_bytes());
            option(b, 0, &[]);
        });
        self.flush()
    }
}

impl<W: Sink> Drop for Recorder<W> {
    fn drop(&mut self) {
        if !self.closed {
            let _ = self.finish(0);
        }
    }
}

/// Appends one block: kind, length, body, length.
fn block(out: &mut Vec<u8>, kind: u32, body: impl FnOnce(&mut Vec<u8>)) {
    let start = out.len();
    out.extend_from_slice(&kind.to_le_bytes());
    out.extend_from_slice(&[0; 4]);
    body(out);
    let length = ((out.len() - start + 4) as u32).to_le_bytes();
    out.extend_from_slice(&length);
    out[start + 4..start + 8].copy_from_slice(&length);
}

/// Appends one option, padded to four octets.
fn option(out: &mut Vec<u8>, code: u16, value: &[u8]) {
    out.extend_from_slice(&code.to_le_bytes());
    out.extend_from_slice(&(value.len() as u16).to_le_bytes());
    out.extend_from_slice(value);
    out.resize(out.len() + value.len().next_multiple_of(4) - value.len(), 0);
}

/// As much of `text` as an option holds.
fn clip(text: &str) -> &str {
    let mut end = text.len().min(60_000);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    &text[..end]
}
