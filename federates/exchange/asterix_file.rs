//! A recording of ASTERIX in any form: pcap, pcapng, bare blocks, IOSS final, RFF.

use anyhow::{Context, bail};
use asterix::files::{Form, frames};
use asterix::{Block, DecodeError, blocks};
use std::fs::File;
use std::io::{Cursor, Read, Seek};
use std::path::Path;

/// Octets of the largest recording that is read.
const LARGEST: u64 = 1 << 30;

/// A datagram (or frame) of a recording.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Arrival, ns since 1970 (since some midnight where the form has no date), where the form has one.
    pub time_ns: Option<i64>,
    /// Whether [`Self::time_ns`] has a date.
    pub dated: bool,
    /// Where in the file its octets begin.
    pub offset: u64,
    /// Data blocks.
    pub octets: Vec<u8>,
}

/// A recording and what is wrong with its frames.
#[derive(Clone, Debug, Default)]
pub struct Pieces {
    /// What form it has, for people.
    pub form: String,
    /// Datagrams in order.
    pub pieces: Vec<Piece>,
    /// Damage of the file itself.
    pub problems: Vec<String>,
    /// Datagrams passed over because they are not ASTERIX (a DIS run in the same capture).
    pub others: u64,
}

/// Reads a recording; `port`: only datagrams to this UDP port.
///
/// # Errors
/// If the file cannot be read or is too large.
pub fn read(path: &Path, port: Option<u16>) -> anyhow::Result<Pieces> {
    let doing = || path.display().to_string();
    let mut file = File::open(path).with_context(doing)?;
    let mut head = [0; 4];
    let length = file.read(&mut head).with_context(doing)?;
    if length == 4 && is_capture(head) {
        return capture_of(path, port);
    }
    let mut octets = head[..length].to_vec();
    file.take(LARGEST).read_to_end(&mut octets).with_context(doing)?;
    if octets.len() as u64 > LARGEST {
        bail!("{}: longer than {} MiB", path.display(), LARGEST >> 20);
    }
    if octets.is_empty() {
        bail!("{}: empty", path.display());
    }
    Ok(bare(&octets))
}

/// A recording that is in memory already; `name` for what is wrong with it.
///
/// # Errors
/// If it is a capture that cannot be read.
pub fn of_octets(octets: &[u8], name: &str) -> anyhow::Result<Pieces> {
    match octets.first_chunk() {
        Some(head) if is_capture(*head) => pieces_of(Cursor::new(octets), name, None),
        _ => Ok(bare(octets)),
    }
}

fn bare(octets: &[u8]) -> Pieces {
    let form = Form::of_octets(octets);
    let mut read = Pieces { form: form.to_string(), ..Pieces::default() };
    for frame in frames(form, octets) {
        match frame {
            Ok(frame) => read.pieces.push(Piece {
                time_ns: frame.time_ns,
                dated: form == Form::Rff,
                offset: frame.offset as u64,
                octets: frame.content.to_vec(),
            }),
            Err(e) => read.problems.push(e.to_string()),
        }
    }
    read
}

/// Whether a file begins as a capture does: pcapng, or pcap of any byte order and stamp.
#[must_use]
pub fn is_capture(head: [u8; 4]) -> bool {
    let either = |magic: u32| head == magic.to_be_bytes() || head == magic.to_le_bytes();
    head == [0x0a, 0x0d, 0x0d, 0x0a] || either(0xa1b2_c3d4) || either(0xa1b2_3c4d)
}

fn capture_of(path: &Path, port: Option<u16>) -> anyhow::Result<Pieces> {
    let file = File::open(path).with_context(|| path.display().to_string())?;
    pieces_of(file, &path.display().to_string(), port)
}

fn pieces_of(source: impl Read + Seek, name: &str, port: Option<u16>) -> anyhow::Result<Pieces> {
    let reader = capture::Reader::new(source, name, false)?;
    let mut read = Pieces { form: "capture".into(), ..Pieces::default() };
    let mut octets = 0;
    for item in reader {
        match item {
            Ok(datagram) => {
                let wanted = match port {
                    Some(port) => datagram.to.port() == port,
                    None => looks_like_asterix(&datagram.payload),
                };
                if !wanted {
                    read.others += 1;
                    continue;
                }
                octets += datagram.payload.len() as u64;
                if octets > LARGEST {
                    bail!("{name}: more than {} MiB of ASTERIX", LARGEST >> 20);
                }
                read.pieces.push(Piece {
                    time_ns: Some(datagram.utc_ns),
                    dated: true,
                    offset: datagram.place.unwrap_or(0),
                    octets: datagram.payload,
                });
            }
            Err(problem) => read.problems.push(problem.to_string()),
        }
    }
    Ok(read)
}

/// A first block of a category that is known. PDUs of DIS version 4 begin as category 004 does: what is whole PDUs, and not whole blocks, is
/// none.
fn looks_like_asterix(payload: &[u8]) -> bool {
    // Whether lengths of 16 bits, so far from each begin, lead exactly to the end; none is less than what is before it.
    let led_to_the_end = |at: usize| {
        let mut rest = payload;
        while let Some(&[high, low]) = rest.get(at..at + 2) {
            let length = usize::from(u16::from_be_bytes([high, low]));
            match rest.get(length..) {
                Some(after) if length >= at + 2 => rest = after,
                _ => return false,
            }
        }
        rest.is_empty()
    };
    let known = payload.first().is_some_and(|category| asterix::category(*category).is_some());
    known && (led_to_the_end(1) || !led_to_the_end(8))
}

/// The sound blocks of a datagram, each with its records sound, and the damage that ends them.
pub fn sound(octets: &[u8]) -> impl Iterator<Item = Result<Block<'_>, DecodeError>> {
    let mut ended = false;
    blocks(octets).map_while(move |block| {
        if ended {
            return None;
        }
        let checked = block.and_then(|b| b.check().map(|_| b));
        ended = checked.is_err();
        Some(checked)
    })
}

#[cfg(test)]
mod tests {
    use super::looks_like_asterix;

    /// A capture has ASTERIX and DIS beside each other: category 004 and version 4 begin with the same octet.
    #[test]
    fn pdus_of_no_version_are_taken_for_asterix() {
        let pdu = |version: u8, length: u8| {
            let mut octets = vec![0; usize::from(length)];
            octets[..12].copy_from_slice(&[version, 1, 1, 1, 0, 0, 0, 7, 0, length, 0, 0]);
            octets
        };
        for version in 4..=7 {
            assert!(!looks_like_asterix(&pdu(version, 144)), "version {version}");
            let both = [pdu(version, 144), pdu(version, 32)].concat();
            assert!(!looks_like_asterix(&both), "two of version {version} in a datagram");
        }
        // Blocks whose octets 8 and 9 may say anything, whole and cut.
        for (category, length, inner) in [(4, 24, 24), (4, 24, 0), (10, 24, 24), (62, 40, 40)] {
            let mut block = vec![0; length];
            block[..3].copy_from_slice(&[category, 0, length as u8]);
            block[9] = inner;
            assert!(looks_like_asterix(&block), "{category}");
            assert!(looks_like_asterix(&[block.clone(), block.clone()].concat()), "{category}");
            block.truncate(length - 2);
            assert!(looks_like_asterix(&block), "{category}, damaged");
        }
        assert!(!looks_like_asterix(&[]));
    }
}
