//! The file formats: blocks in, frames out.
//!
//! Sources: the pcap and pcapng formats as described by the IETF drafts `draft-ietf-opsawg-pcap`
//! and `draft-ietf-opsawg-pcapng`.

use crate::bytes::{Order, be16};
use crate::error::{BlockFault, Problem};
use crate::link::link_type;
use crate::source::Source;
use std::io::{self, Read, Seek};

/// Largest block or record taken for sound.
const MOST_BLOCK: u32 = 16 << 20;
/// Interfaces kept for one section; a file with more is damaged.
const MOST_INTERFACES: usize = 4096;
/// Octets looked at in one go when a damaged block is passed over.
const SEARCH_STEP: usize = 64 * 1024;

/// What a recorder of this crate writes as the application's name, followed by its version.
pub(crate) const APPLICATION: &str = "seeds";

/// One frame as captured; its octets are in the buffer that was handed in.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    pub(crate) utc_ns: i64,
    /// Link type, or `None` where the frame is a payload without headers.
    pub(crate) link: Option<u16>,
    /// The frame within the buffer.
    pub(crate) start: usize,
    pub(crate) len: usize,
    /// Octets of the frame that were not captured.
    pub(crate) cut: usize,
    /// The frame within the file.
    pub(crate) file_offset: u64,
    pub(crate) interface: u32,
    pub(crate) comment: Option<String>,
}

#[derive(Debug)]
pub(crate) enum Container {
    Pcap(Pcap),
    Pcapng(Pcapng),
    Bare(Bare),
}

impl Container {
    /// Reads what stands before the first frame. `start` holds the first octets of the file.
    pub(crate) fn detect(start: &[u8], bare: bool) -> Option<Self> {
        if let Some(pcap) = Pcap::detect(start) {
            return Some(Self::Pcap(pcap));
        }
        if start.starts_with(&[0x0a, 0x0d, 0x0d, 0x0a]) {
            return Some(Self::Pcapng(Pcapng::default()));
        }
        // A DIS header: version 1 to 7 and a length that holds at least the header.
        let header = matches!(start.first(), Some(1..=7)) && be16(start, 8) >= Some(12);
        (bare || header).then(|| Self::Bare(Bare::default()))
    }

    /// The next frame, its octets in `buffer`; `None` at the end.
    pub(crate) fn next<R: Read + Seek>(
        &mut self,
        source: &mut Source<R>,
        buffer: &mut Vec<u8>,
    ) -> Option<Result<Frame, Problem>> {
        let found = match self {
            Self::Pcap(p) => p.next(source, buffer),
            Self::Pcapng(p) => p.next(source, buffer),
            Self::Bare(p) => p.next(source, buffer),
        };
        match found {
            Ok(item) => item,
            Err(e) => Some(Err(Problem::Io { offset: source.offset, cause: e })),
        }
    }
}

/// Frames come as `Ok(Some(Ok(..)))`, problems of the file as `Ok(Some(Err(..)))`.
type Next = io::Result<Option<Result<Frame, Problem>>>;

#[derive(Debug)]
pub(crate) struct Pcap {
    order: Order,
    ns_per_tick: i64,
    link: u16,
    record_header: usize,
    begun: bool,
}

impl Pcap {
    fn detect(start: &[u8]) -> Option<Self> {
        let of = |order: Order| {
            let (ns_per_tick, record_header) = match order.u32(start, 0)? {
                0xa1b2_c3d4 => (1_000, 16),
                0xa1b2_3c4d => (1, 16),
                // A variant of old with eight octets more per record.
                0xa1b2_cd34 => (1_000, 24),
                _ => return None,
            };
            let link = order.u32(start, 20)? as u16;
            Some(Self { order, ns_per_tick, link, record_header, begun: false })
        };
        of(Order::Little).or_else(|| of(Order::Big))
    }

    fn next<R: Read + Seek>(&mut self, source: &mut Source<R>, buffer: &mut Vec<u8>) -> Next {
        if !self.begun {
            source.seek_to(24)?;
            self.begun = true;
        }
        let offset = source.offset;
        buffer.clear();
        let have = source.read_more(buffer, self.record_header)?;
        if have == 0 {
            return Ok(None);
        }
        let (Some(s), Some(fraction), Some(captured), Some(original)) = (
            self.order.u32(buffer, 0),
            self.order.u32(buffer, 4),
            self.order.u32(buffer, 8),
            self.order.u32(buffer, 12),
        ) else {
            return Ok(Some(Err(Problem::Cut { offset, bytes: have as u64 })));
        };
        if have < self.record_header {
            return Ok(Some(Err(Problem::Cut { offset, bytes: have as u64 })));
        }
        if captured > MOST_BLOCK {
            // Records have no mark to look for: what follows cannot be found again.
            let skipped = have as u64 + source.skip_rest()?;
            let fault = BlockFault::Length(captured);
            return Ok(Some(Err(Problem::Block { offset, fault, skipped })));
        }
        let file_offset = source.offset;
        buffer.clear();
        let got = source.read_more(buffer, captured as usize)?;
        if got < captured as usize {
            return Ok(Some(Err(Problem::Cut { offset, bytes: (have + got) as u64 })));
        }
        Ok(Some(Ok(Frame {
            utc_ns: i64::from(s) * 1_000_000_000 + i64::from(fraction) * self.ns_per_tick,
            link: Some(self.link),
            start: 0,
            len: got,
            cut: original.saturating_sub(captured) as usize,
            file_offset,
            interface: 0,
            comment: None,
        })))
    }
}

#[derive(Clone, Copy, Debug)]
struct Interface {
    link: u16,
    /// Ticks per second.
    ticks: u64,
    offset_s: i64,
}

impl Interface {
    /// Nanoseconds since 1970, rounded down; saturates beyond the years that fit.
    fn utc_ns(&self, ticks: u64) -> i64 {
        let ns = i128::from(ticks) * 1_000_000_000 / i128::from(self.ticks)
            + i128::from(self.offset_s) * 1_000_000_000;
        ns.clamp(i64::MIN.into(), i64::MAX.into()) as i64
    }
}

#[derive(Debug, Default)]
pub(crate) struct Pcapng {
    order: Option<Order>,
    interfaces: Vec<Interface>,
    /// The section was written by a recorder of this crate.
    ours: bool,
    /// Statistics came after the last frame: the writer closed the file.
    closed: bool,
    told: bool,
}

mod block {
    pub(super) const SECTION: u32 = 0x0a0d_0d0a;
    pub(super) const INTERFACE: u32 = 1;
    pub(super) const OLD_PACKET: u32 = 2;
    pub(super) const SIMPLE_PACKET: u32 = 3;
    pub(super) const STATISTICS: u32 = 5;
    pub(super) const PACKET: u32 = 6;
}

impl Pcapng {
    fn next<R: Read + Seek>(&mut self, source: &mut Source<R>, buffer: &mut Vec<u8>) -> Next {
        loop {
            let offset = source.offset;
            buffer.clear();
            match self.read_block(source, buffer)? {
                Read1::End if self.ours && !self.closed && !self.told => {
                    self.told = true;
                    return Ok(Some(Err(Problem::NotClosed { offset })));
                }
                Read1::End => return Ok(None),
                Read1::Fault(fault) => {
                    let skipped = self.skip_to_sound_block(source, offset)?;
                    return Ok(Some(Err(Problem::Block { offset, fault, skipped })));
                }
                Read1::Cut(bytes) => {
                    // Either the end of the file, or a damaged length in the middle of it.
                    let skipped = self.skip_to_sound_block(source, offset)?;
                    let problem = if skipped == bytes {
                        self.told = true;
                        Problem::Cut { offset, bytes }
                    } else {
                        let have = bytes;
                        let needed = self.order.and_then(|o| o.u32(buffer, 4)).unwrap_or(12).into();
                        Problem::Block {
                            offset,
                            fault: BlockFault::Short { needed, have },
                            skipped,
                        }
                    };
                    return Ok(Some(Err(problem)));
                }
                Read1::Block { kind, order } => {
                    match self.take_block(kind, order, buffer, offset) {
                        Ok(Some(frame)) => return Ok(Some(Ok(frame))),
                        Ok(None) => {}
                        Err(fault) => {
                            let skipped = buffer.len() as u64;
                            return Ok(Some(Err(Problem::Block { offset, fault, skipped })));
                        }
                    }
                }
            }
        }
    }

    /// Reads one block with its lengths into `buffer`.
    fn read_block<R: Read + Seek>(
        &mut self,
        source: &mut Source<R>,
        buffer: &mut Vec<u8>,
    ) -> io::Result<Read1> {
        let have = source.read_more(buffer, 12)?;
        if have == 0 {
            return Ok(Read1::End);
        }
        if have < 12 {
            return Ok(Read1::Cut(have as u64));
        }
        let section = buffer.starts_with(&block::SECTION.to_be_bytes());
        let order = match (section, Order::Little.u32(buffer, 8)) {
            (true, Some(0x1a2b_3c4d)) => Order::Little,
            (true, Some(0x4d3c_2b1a)) => Order::Big,
            (true, mark) => return Ok(Read1::Fault(BlockFault::OctetOrder(mark.unwrap_or(0)))),
            (false, _) => match self.order {
                Some(order) => order,
                None => return Ok(Read1::Fault(BlockFault::OctetOrder(0))),
            },
        };
        let kind = order.u32(buffer, 0).unwrap_or(0);
        let length = order.u32(buffer, 4).unwrap_or(0);
        if !sane_length(length) {
            return Ok(Read1::Fault(BlockFault::Length(length)));
        }
        source.read_more(buffer, length as usize - 12)?;
        if buffer.len() < length as usize {
            return Ok(Read1::Cut(buffer.len() as u64));
        }
        let trailing = order.u32(buffer, length as usize - 4).unwrap_or(0);
        if trailing != length {
            return Ok(Read1::Fault(BlockFault::Lengths { leading: length, trailing }));
        }
        if section {
            self.order = Some(order);
        }
        Ok(Read1::Block { kind, order })
    }

    /// What a sound block says; a frame where it holds one.
    fn take_block(
        &mut self,
        kind: u32,
        order: Order,
        whole: &[u8],
        offset: u64,
    ) -> Result<Option<Frame>, BlockFault> {
        // Without the lengths at both ends; offsets in a body below count from its start.
        let body = &whole[8..whole.len() - 4];
        let short = |needed: u64| BlockFault::Short { needed, have: body.len() as u64 };
        let u32_at = |at: usize| order.u32(body, at).ok_or(short(at as u64 + 4));
        match kind {
            block::SECTION => {
                self.interfaces.clear();
                let application = options(order, body, 16).find(|(code, _)| *code == 4);
                self.ours = application.is_some_and(|(_, v)| v.starts_with(APPLICATION.as_bytes()));
                self.closed = false;
                Ok(None)
            }
            block::INTERFACE => {
                let link = order.u16(body, 0).ok_or(short(8))?;
                let mut interface = Interface { link, ticks: 1_000_000, offset_s: 0 };
                for (code, value) in options(order, body, 8) {
                    match (code, value) {
                        (9, [resolution, ..]) => interface.ticks = ticks_per_s(*resolution),
                        (14, value) => interface.offset_s = order.i64(value, 0).unwrap_or(0),
                        _ => {}
                    }
                }
                if self.interfaces.len() < MOST_INTERFACES {
                    self.interfaces.push(interface);
                }
                Ok(None)
            }
            block::STATISTICS => {
                self.closed = true;
                Ok(None)
            }
            block::PACKET | block::OLD_PACKET | block::SIMPLE_PACKET => {
                self.closed = false;
                let (number, ticks, captured, original, data) = match kind {
                    block::SIMPLE_PACKET => {
                        let original = u32_at(0)?;
                        (0, None, original.min(body.len() as u32 - 4), original, 4)
                    }
                    _ => {
                        let number = if kind == block::PACKET {
                            u32_at(0)?
                        } else {
                            order.u16(body, 0).ok_or(short(20))?.into()
                        };
                        let ticks = u64::from(u32_at(4)?) << 32 | u64::from(u32_at(8)?);
                        (number, Some(ticks), u32_at(12)?, u32_at(16)?, 20usize)
                    }
                };
                let interface =
                    self.interfaces.get(number as usize).ok_or(BlockFault::Interface(number))?;
                let end = data as u64 + u64::from(captured);
                if end > body.len() as u64 {
                    return Err(short(end));
                }
                let padded = (end as usize).next_multiple_of(4);
                let comment = (kind == block::PACKET)
                    .then(|| options(order, body, padded).find(|(code, _)| *code == 1))
                    .flatten()
                    .map(|(_, text)| String::from_utf8_lossy(text).into_owned());
                Ok(Some(Frame {
                    utc_ns: ticks.map_or(0, |t| interface.utc_ns(t)),
                    link: Some(interface.link),
                    start: 8 + data,
                    len: captured as usize,
                    cut: original.saturating_sub(captured) as usize,
                    file_offset: offset + 8 + data as u64,
                    interface: number,
                    comment,
                }))
            }
            // Names, secrets, private blocks: nothing for us.
            _ => Ok(None),
        }
    }

    /// Looks for a block of a known kind, with equal lengths at both ends, behind a damaged one that
    /// starts at `from`. Leaves the source there (or at the end); gives the octets passed over.
    fn skip_to_sound_block<R: Read + Seek>(
        &self,
        source: &mut Source<R>,
        from: u64,
    ) -> io::Result<u64> {
        let mut at = from + 1;
        let mut window = Vec::with_capacity(SEARCH_STEP + 12);
        loop {
            source.seek_to(at)?;
            window.clear();
            source.read_more(&mut window, SEARCH_STEP + 11)?;
            if window.len() < 12 {
                source.seek_to(at)?;
                source.skip_rest()?;
                return Ok(source.offset - from);
            }
            for i in 0..window.len() - 11 {
                let Some(length) = self.sound_head(&window[i..]) else { continue };
                let start = at + i as u64;
                source.seek_to(start + u64::from(length) - 4)?;
                let mut trailing = [0; 4];
                let same = source.read(&mut trailing)? == 4 && trailing == window[i + 4..i + 8];
                if same {
                    source.seek_to(start)?;
                    return Ok(start - from);
                }
            }
            at += (window.len() - 11) as u64;
        }
    }

    /// Length of the block that may start here.
    fn sound_head(&self, octets: &[u8]) -> Option<u32> {
        let order = match (octets.starts_with(&block::SECTION.to_be_bytes()), octets.get(8..12)?) {
            (true, [0x4d, 0x3c, 0x2b, 0x1a]) => Order::Little,
            (true, [0x1a, 0x2b, 0x3c, 0x4d]) => Order::Big,
            (true, _) => return None,
            (false, _) => self.order?,
        };
        let least = match order.u32(octets, 0)? {
            block::SECTION => 28,
            block::INTERFACE => 20,
            block::OLD_PACKET | block::PACKET => 32,
            block::SIMPLE_PACKET => 16,
            block::STATISTICS => 24,
            _ => return None,
        };
        order.u32(octets, 4).filter(|length| sane_length(*length) && *length >= least)
    }
}

/// What came of reading one block.
enum Read1 {
    End,
    Cut(u64),
    Fault(BlockFault),
    Block { kind: u32, order: Order },
}

fn sane_length(length: u32) -> bool {
    (12..=MOST_BLOCK).contains(&length) && length.is_multiple_of(4)
}

/// Ticks per second of an `if_tsresol` octet: a power of ten, or of two with the highest bit set.
/// Resolutions finer than fit 64 bits are taken at the finest that does.
fn ticks_per_s(resolution: u8) -> u64 {
    let exponent = u32::from(resolution & 0x7f);
    let base = if resolution & 0x80 == 0 { 10u64 } else { 2 };
    base.checked_pow(exponent).unwrap_or(u64::MAX)
}

/// Code and value of each option from `at` on, until the end mark or the first that does not fit.
fn options(order: Order, body: &[u8], mut at: usize) -> impl Iterator<Item = (u16, &[u8])> {
    std::iter::from_fn(move || {
        let (code, len) = (order.u16(body, at)?, usize::from(order.u16(body, at + 2)?));
        if code == 0 {
            return None;
        }
        let value = body.get(at + 4..at + 4 + len)?;
        at += 4 + len.next_multiple_of(4);
        Some((code, value))
    })
}

/// PDUs one behind the other, nothing between them. Time comes from their time stamps: units of
/// 3600 s / (2³¹ − 1) within an hour (IEEE 1278.1-2012, 6.2.88), unwrapped from PDU to PDU.
#[derive(Debug, Default)]
pub(crate) struct Bare {
    last: Option<(i64, i64)>,
}

const HOUR_NS: i64 = 3_600_000_000_000;

impl Bare {
    fn next<R: Read + Seek>(&mut self, source: &mut Source<R>, buffer: &mut Vec<u8>) -> Next {
        let offset = source.offset;
        buffer.clear();
        let have = source.read_more(buffer, 12)?;
        if have == 0 {
            return Ok(None);
        }
        // A length below the header tells nothing about what follows: the rest goes out as it is.
        let length = match be16(buffer, 8) {
            Some(n) if n >= 12 => usize::from(n),
            _ => 65_507,
        };
        let known = have >= 12 && be16(buffer, 8) >= Some(12);
        let got = have + source.read_more(buffer, length - have)?;
        Ok(Some(Ok(Frame {
            utc_ns: self.utc_ns(buffer),
            link: None,
            start: 0,
            len: got,
            cut: if known { length - got } else { 0 },
            file_offset: offset,
            interface: 0,
            comment: None,
        })))
    }

    fn utc_ns(&mut self, header: &[u8]) -> i64 {
        let Some(stamp) = Order::Big.u32(header, 4) else {
            return self.last.map_or(0, |(_, utc)| utc);
        };
        let in_hour = i64::try_from(
            (i128::from(stamp >> 1) * i128::from(HOUR_NS) + i128::from((1u32 << 30) - 1))
                / i128::from((1u32 << 31) - 1),
        )
        .unwrap_or(0);
        let utc = match self.last {
            None => in_hour,
            // The shorter way round the hour.
            Some((before, utc)) => {
                utc + (in_hour - before + HOUR_NS / 2).rem_euclid(HOUR_NS) - HOUR_NS / 2
            }
        };
        self.last = Some((in_hour, utc));
        utc
    }
}

/// Whether frames of this link type carry an Ethernet header.
pub(crate) const LINK_OF_RECORDINGS: u16 = link_type::ETHERNET;
