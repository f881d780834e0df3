//! What a member says of the frames that it has executed: in reports of bounded length, and joined again.

use super::{Frame, Notice, Weight};
use crate::runtime::codec::encoded_size;
use serde::{Deserialize, Serialize};

/// All frames from `first` to `last` have been executed by the sender.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameEnds {
    /// Number of the run.
    pub run: u32,
    /// First frame of this message.
    pub first: Frame,
    /// Last frame of this message.
    pub last: Frame,
    /// Hashes of the PDUs of each frame that has any: (frame, hashes in ascending order).
    pub pdus: Vec<(Frame, Vec<u64>)>,
    /// Notices: in which frame each was made, in which it takes effect (that one or later), and the notice.
    pub notices: Vec<(Frame, Frame, Notice)>,
    /// What the sender used of those whose PDUs it reads.
    pub used: Vec<Used>,
    /// Digest of the sender's state at `last`; none in a part that others follow.
    pub state: Option<u64>,
    /// Frame `last` goes on in the next report of the sender.
    pub goes_on: bool,
}

/// PDUs of one producer that a consumer handed to its federate in one step, to be held against what that producer named.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Used {
    /// Whose.
    pub of: String,
    /// Those of this frame
    pub first: Frame,
    /// to this one.
    pub last: Frame,
    /// Wrapping sum of their hashes.
    pub sum: u64,
}

/// Octets of one report: a longer one is told in parts.
pub(super) const REPORT_OCTETS: usize = 192 << 10;

/// Octets of what one frame may consist of in all: 64 MiB, four million PDUs.
const FRAME_OCTETS: usize = 64 << 20;

impl FrameEnds {
    /// The same in reports of bounded length: cut between frames, and within one that is too long by itself.
    #[must_use]
    pub fn parts(self) -> Vec<Self> {
        if encoded_size(&self) <= REPORT_OCTETS {
            return vec![self];
        }
        if self.first >= self.last {
            return self.parts_of_a_frame();
        }
        let middle = self.first + (self.last - self.first) / 2;
        let Self { run, first, last, pdus, notices, used, state, goes_on } = self;
        let (pdus, later_pdus) = pdus.into_iter().partition(|(frame, _)| *frame <= middle);
        let (notices, later_notices) = notices.into_iter().partition(|(made, ..)| *made <= middle);
        let head = Self { run, first, last: middle, pdus, notices, ..Self::default() };
        let (pdus, notices) = (later_pdus, later_notices);
        let tail = Self { run, first: middle + 1, last, pdus, notices, used, state, goes_on };
        [head.parts(), tail.parts()].concat()
    }

    fn parts_of_a_frame(self) -> Vec<Self> {
        let Self { run, first, last, pdus, notices, used, state, goes_on } = self;
        let part = || Self { run, first, last, goes_on: true, ..Self::default() };
        let mut parts = Vec::new();
        for (frame, hashes) in pdus {
            for chunk in hashes.chunks(REPORT_OCTETS / 16) {
                parts.push(Self { pdus: vec![(frame, chunk.to_vec())], ..part() });
            }
        }
        let mut octets = REPORT_OCTETS;
        for (made, effect, notice) in notices {
            for piece in notice.pieces() {
                let size = encoded_size(&piece);
                if octets + size > REPORT_OCTETS {
                    parts.push(part());
                    octets = 0;
                }
                octets += size;
                if let Some(last) = parts.last_mut() {
                    last.notices.push((made, effect, piece));
                }
            }
        }
        if let Some(last) = parts.last_mut() {
            (last.used, last.state, last.goes_on) = (used, state, goes_on);
        }
        parts
    }

    /// Adds the next part of the frame with which this ends.
    fn join(&mut self, next: Self) {
        for (frame, hashes) in next.pdus {
            match self.pdus.last_mut() {
                Some((last, known)) if *last == frame => known.extend(hashes),
                _ => self.pdus.push((frame, hashes)),
            }
        }
        for (made, effect, notice) in next.notices {
            match (self.notices.last_mut(), notice) {
                (Some((_, _, Notice::Flights(known))), Notice::MoreFlights(more)) => {
                    known.extend(more);
                }
                (_, notice) => self.notices.push((made, effect, notice)),
            }
        }
        self.used.extend(next.used);
        (self.last, self.state, self.goes_on) = (next.last, next.state, next.goes_on);
    }
}

/// Puts frame ends that came in parts together again.
#[derive(Clone, Debug, Default)]
pub struct Joined {
    /// Number of the first part, and what came so far.
    open: Option<(u64, FrameEnds)>,
}

impl Joined {
    /// The next report of the stream, with its number: what is complete now, with the number of its first part.
    pub fn take(&mut self, seq: u64, ends: FrameEnds) -> Option<(u64, FrameEnds)> {
        let (seq, whole) = match self.open.take() {
            Some((first, mut open)) if (open.run, open.last) == (ends.run, ends.first) => {
                open.join(ends);
                (first, open)
            }
            _ => (seq, ends),
        };
        if !whole.goes_on {
            return Some((seq, whole));
        }
        // What no sender of ours would make is not kept: its frame never ends.
        if whole.octets() <= FRAME_OCTETS {
            self.open = Some((seq, whole));
        }
        None
    }
}

impl Weight for FrameEnds {
    fn octets(&self) -> usize {
        let hashes: usize = self.pdus.iter().map(|(_, hashes)| 16 + 8 * hashes.len()).sum();
        let notices = self.notices.iter().map(|(_, _, notice)| match notice {
            Notice::Flights(flights) | Notice::MoreFlights(flights) => 64 + 256 * flights.len(),
            Notice::Outsider { octets, .. } => 64 + octets.len(),
            Notice::Tracks(tracks) => 64 + 128 * tracks.len(),
            Notice::Clearances(all) => all.iter().map(|c| 128 + 16 * c.way_m.len()).sum(),
            Notice::Wants { wants, .. } => 64 + 64 * wants.len(),
            Notice::Plots(of) => 256 + 256 * of.plots.len(),
            Notice::Stands(all) => 64 + 64 * all.len(),
            Notice::Weather(weather) => 128 + 32 * weather.cells.len(),
            Notice::Given(_) | Notice::Seat(_) => 256,
        });
        128 + hashes + notices.sum::<usize>() + 64 * self.used.len()
    }
}
