//! Datagrams out of a file.

use crate::container::{Container, Frame};
use crate::error::{OpenError, Problem};
use crate::fragments::Fragments;
use crate::link::{Content, open_frame};
use crate::source::Source;
use std::collections::VecDeque;
use std::fs::File;
use std::io::{Read, Seek};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::Path;

/// One UDP datagram (or one PDU of a file of bare PDUs).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Datagram {
    /// When it was captured, nanoseconds since 1970-01-01 UTC. In a file of bare PDUs: from the
    /// PDU's time stamp, counted from the hour in which the file begins.
    pub utc_ns: i64,
    /// Sender (unspecified address and port 0 in a file of bare PDUs).
    pub from: SocketAddr,
    /// Receiver, the group or broadcast address where it is one.
    pub to: SocketAddr,
    /// What UDP carried.
    pub payload: Vec<u8>,
    /// Octets of the payload that the capture left out at its end.
    pub missing: usize,
    /// Number of the frame, from 1, as Wireshark counts; the first one of a fragmented packet.
    pub frame: u64,
    /// Where the payload stands in the file; `None` where it was put together from fragments.
    pub place: Option<u64>,
    /// Number of the interface within its section.
    pub interface: u32,
    /// Comment on the frame.
    pub comment: Option<String>,
}

/// What kind of file it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The format of tcpdump of old.
    Pcap,
    /// The format of Wireshark and of our recordings.
    Pcapng,
    /// PDUs one behind the other.
    Bare,
}

/// What was passed over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Frames so far.
    pub frames: u64,
    /// Datagrams so far.
    pub datagrams: u64,
    /// Frames that hold no UDP, or a part of a fragmented packet.
    pub others: u64,
}

/// Reads a file from front to back: an iterator of datagrams and of [`Problem`]s.
#[derive(Debug)]
pub struct Reader<R = File> {
    source: Source<R>,
    container: Container,
    buffer: Vec<u8>,
    fragments: Fragments,
    waiting: VecDeque<Problem>,
    counts: Counts,
    ended: bool,
}

impl Reader<File> {
    /// Opens a file and finds out what it is: pcap or pcapng by its first octets, else bare PDUs.
    /// A file named `.raw`, `.bin` or `.dis` holds bare PDUs even if its first one is damaged.
    ///
    /// # Errors
    /// [`OpenError`], with the path.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        let path = path.as_ref();
        let name = path.display().to_string();
        let file = File::open(path).map_err(|cause| OpenError::Io { path: name.clone(), cause })?;
        let bare = path
            .extension()
            .and_then(|e| e.to_str())
            .is_some_and(|e| ["raw", "bin", "dis"].contains(&e.to_ascii_lowercase().as_str()));
        Self::new(file, &name, bare)
    }
}

impl<R: Read + Seek> Reader<R> {
    /// Reads from anything; `name` is for error messages, `bare` as for the file names in
    /// [`Reader::open`].
    ///
    /// # Errors
    /// [`OpenError`], with `name`.
    pub fn new(inner: R, name: &str, bare: bool) -> Result<Self, OpenError> {
        let mut source = Source::new(inner);
        let path = || name.to_owned();
        let start = source.peek().map_err(|cause| OpenError::Io { path: path(), cause })?;
        let start = start[..start.len().min(24)].to_vec();
        let with = match start.as_slice() {
            [] => return Err(OpenError::Empty { path: path() }),
            [0x1f, 0x8b, ..] => Some("gzip"),
            [0x28, 0xb5, 0x2f, 0xfd, ..] => Some("zstd"),
            [0x04, 0x22, 0x4d, 0x18, ..] => Some("lz4"),
            [0xfd, b'7', b'z', b'X', b'Z', ..] => Some("xz"),
            _ => None,
        };
        if let Some(with) = with {
            return Err(OpenError::Compressed { path: path(), with });
        }
        let Some(container) = Container::detect(&start, bare) else {
            let start = start.iter().take(8).map(|b| format!("{b:02x}")).collect();
            return Err(OpenError::Unknown { path: path(), start });
        };
        Ok(Self {
            source,
            container,
            buffer: Vec::new(),
            fragments: Fragments::default(),
            waiting: VecDeque::new(),
            counts: Counts::default(),
            ended: false,
        })
    }

    /// What kind of file it is.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self.container {
            Container::Pcap(_) => Kind::Pcap,
            Container::Pcapng(_) => Kind::Pcapng,
            Container::Bare(_) => Kind::Bare,
        }
    }

    /// Octets read so far, for showing progress.
    #[must_use]
    pub fn position(&self) -> u64 {
        self.source.offset
    }

    /// What was read and passed over so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The next datagram into `into`, whose memory is used again; `None` at the end.
    ///
    /// # Errors
    /// [`Problem`]; reading goes on behind it with the next call.
    pub fn read(&mut self, into: &mut Datagram) -> Option<Result<(), Problem>> {
        loop {
            if let Some(problem) = self.waiting.pop_front() {
                return Some(Err(problem));
            }
            if self.ended {
                return None;
            }
            let frame = match self.container.next(&mut self.source, &mut self.buffer) {
                Some(Ok(frame)) => frame,
                Some(Err(problem)) => {
                    self.ended = matches!(problem, Problem::Io { .. });
                    return Some(Err(problem));
                }
                None => {
                    self.ended = true;
                    self.fragments.finish();
                    self.tell_given_up(self.source.offset);
                    continue;
                }
            };
            self.counts.frames += 1;
            match self.take_frame(&frame, into) {
                Ok(true) => {
                    self.counts.datagrams += 1;
                    return Some(Ok(()));
                }
                Ok(false) => self.counts.others += 1,
                Err(problem) => return Some(Err(problem)),
            }
        }
    }

    /// Fills `into`; false if the frame is of no interest.
    fn take_frame(&mut self, frame: &Frame, into: &mut Datagram) -> Result<bool, Problem> {
        let octets = &self.buffer[frame.start..frame.start + frame.len];
        into.utc_ns = frame.utc_ns;
        into.frame = self.counts.frames;
        into.interface = frame.interface;
        into.comment.clone_from(&frame.comment);
        into.payload.clear();
        into.missing = 0;
        let Some(link) = frame.link else {
            let nobody = SocketAddr::new(Ipv4Addr::UNSPECIFIED.into(), 0);
            (into.from, into.to) = (nobody, nobody);
            into.payload.extend_from_slice(octets);
            into.missing = frame.cut;
            into.place = Some(frame.file_offset);
            return Ok(true);
        };
        let number = self.counts.frames;
        let content = open_frame(link, octets, frame.cut, number, &mut self.fragments);
        let found = match content {
            Ok(Content::Udp { from, to, start, len, missing }) => {
                (into.from, into.to, into.missing) = (from, to, missing);
                into.payload.extend_from_slice(&octets[start..start + len]);
                into.place = Some(frame.file_offset + start as u64);
                true
            }
            Ok(Content::Whole { from, to, payload, first_frame }) => {
                (into.from, into.to, into.payload) = (from, to, payload);
                into.frame = first_frame;
                into.place = None;
                true
            }
            Ok(Content::Other) => false,
            Err(fault) => {
                return Err(Problem::Frame { frame: number, offset: frame.file_offset, fault });
            }
        };
        self.tell_given_up(frame.file_offset);
        Ok(found)
    }

    fn tell_given_up(&mut self, offset: u64) {
        for (frame, fault) in self.fragments.take_given_up() {
            self.waiting.push_back(Problem::Frame { frame, offset, fault });
        }
    }
}

impl Datagram {
    /// A place for [`Reader::read`] to fill.
    #[must_use]
    pub fn empty() -> Self {
        let nobody = SocketAddr::new(Ipv4Addr::UNSPECIFIED.into(), 0);
        Self {
            utc_ns: 0,
            from: nobody,
            to: nobody,
            payload: Vec::new(),
            missing: 0,
            frame: 0,
            place: None,
            interface: 0,
            comment: None,
        }
    }
}

impl<R: Read + Seek> Iterator for Reader<R> {
    type Item = Result<Datagram, Problem>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut datagram = Datagram::empty();
        self.read(&mut datagram).map(|result| result.map(|()| datagram))
    }
}
