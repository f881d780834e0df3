//! Where everything is in a recording: each datagram, and each state of each entity.

use crate::error::{OpenError, Problem};
use crate::reader::{Datagram, Reader};
use pdu::enumerations::PduType;
use pdu::records::EntityId;
use pdu::{Body, DisTime, Frame};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, Write};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::path::{Path, PathBuf};

/// One datagram of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    /// When it was captured.
    pub(crate) utc_ns: i64,
    /// Where its payload is: in the file, or with [`IN_BLOB`] set in the index itself.
    pub(crate) place: u64,
    pub(crate) len: u32,
    /// Sender and receiver, a place in `pairs`.
    pub(crate) pair: u32,
    /// The timestamp of its first PDU as on the wire, or [`NO_STAMP`].
    pub(crate) stamp: u32,
}

/// Not a timestamp: its units would be a whole hour.
pub(crate) const NO_STAMP: u32 = u32::MAX;

/// Marks a payload that was put together from fragments and stands in the index.
pub(crate) const IN_BLOB: u64 = 1 << 63;
/// Remarks kept in words; the others are counted.
const MOST_REMARKS: usize = 100;
/// A timestamp so far behind the latest, or so far ahead of it, is of another clock, or of a clock that
/// was set: what it stamps is due at once.
const LEAP_BACK_NS: i64 = 30_000_000_000;
const LEAP_AHEAD_NS: i64 = 120_000_000_000;

/// Whose state a PDU tells: exercise, type, entity, and the number of a radio or the like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct StateKey {
    pub(crate) exercise: u8,
    pub(crate) pdu_type: u8,
    pub(crate) id: EntityId,
    pub(crate) part: u16,
}

/// A PDU that tells a state, or that ends it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct State {
    /// Number of the datagram.
    pub(crate) datagram: u32,
    /// Octets from the start of the payload to the PDU; [`GONE`] where the state ends.
    pub(crate) offset: u32,
}

pub(crate) const GONE: u32 = u32::MAX;

/// Where everything is in a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Index {
    pub(crate) entries: Vec<Entry>,
    pub(crate) pairs: Vec<(SocketAddr, SocketAddr)>,
    pub(crate) blob: Vec<u8>,
    pub(crate) states: BTreeMap<StateKey, Vec<State>>,
    /// What was wrong with the file, in words.
    pub(crate) remarks: Vec<String>,
    /// How many things were wrong.
    pub(crate) problems: u64,
}

impl Index {
    /// Reads a whole file. `progress` gets the octets read, now and then.
    pub(crate) fn build<R: Read + Seek>(
        mut reader: Reader<R>,
        progress: &mut dyn FnMut(u64),
    ) -> Self {
        let mut index = Self::default();
        let mut pairs: BTreeMap<(SocketAddr, SocketAddr), u32> = BTreeMap::new();
        let mut datagram = Datagram::empty();
        let mut latest = i64::MIN;
        while let Some(result) = reader.read(&mut datagram) {
            if let Err(problem) = result {
                index.remark(&problem);
                continue;
            }
            let number = index.entries.len() as u32;
            if number.is_multiple_of(4096) {
                progress(reader.position());
            }
            let place = datagram.place.unwrap_or_else(|| {
                index.blob.extend_from_slice(&datagram.payload);
                IN_BLOB | (index.blob.len() - datagram.payload.len()) as u64
            });
            let pair = *pairs.entry((datagram.from, datagram.to)).or_insert_with(|| {
                index.pairs.push((datagram.from, datagram.to));
                index.pairs.len() as u32 - 1
            });
            // A clock that was set back must not make the schedule go backwards.
            latest = latest.max(datagram.utc_ns);
            let len = datagram.payload.len() as u32;
            let stamp = NO_STAMP;
            index.entries.push(Entry { utc_ns: latest, place, len, pair, stamp });
            for frame in pdu::frames(&datagram.payload).map_while(Result::ok) {
                if frame.offset == 0 {
                    index.entries[number as usize].stamp = frame.header.timestamp.0;
                }
                index.note(number, &frame);
            }
        }
        progress(reader.position());
        index
    }

    fn remark(&mut self, problem: &Problem) {
        self.problems += 1;
        if self.remarks.len() < MOST_REMARKS {
            self.remarks.push(problem.to_string());
        }
    }

    /// Notes what a PDU tells about states.
    fn note(&mut self, datagram: u32, frame: &Frame<'_>) {
        let exercise = frame.header.exercise_id;
        match frame.header.pdu_type {
            PduType::ENTITY_STATE => {
                if let Ok(pdu) = frame.decode()
                    && let Body::EntityState(state) = pdu.body()
                {
                    // Bit 23 of every appearance word: deactivated (SISO-REF-010).
                    let gone = state.appearance >> 23 & 1 == 1;
                    self.add(frame, datagram, state.entity_id, 0, gone);
                }
            }
            PduType::REMOVE_ENTITY => {
                if let Ok(pdu) = frame.decode()
                    && let Body::RemoveEntity(remove) = pdu.body()
                {
                    let gone = State { datagram, offset: GONE };
                    for (key, states) in &mut self.states {
                        if key.exercise == exercise && remove.receiving_id.addresses(key.id) {
                            states.push(gone);
                        }
                    }
                }
            }
            // Types whose body begins with the entity that it describes in full.
            PduType(23 | 28 | 33 | 41) => self.note_raw(datagram, frame, false),
            // Radios: the number of the radio follows the entity.
            PduType(25) => self.note_raw(datagram, frame, true),
            _ => {}
        }
    }

    fn note_raw(&mut self, datagram: u32, frame: &Frame<'_>, with_part: bool) {
        let word = |at: usize| crate::bytes::be16(frame.octets, at);
        if let (Some(site), Some(application), Some(entity), Some(part)) =
            (word(12), word(14), word(16), word(18))
        {
            let id = EntityId { site, application, entity };
            self.add(frame, datagram, id, if with_part { part } else { 0 }, false);
        }
    }

    fn add(&mut self, frame: &Frame<'_>, datagram: u32, id: EntityId, part: u16, gone: bool) {
        let (exercise, pdu_type) = (frame.header.exercise_id, frame.header.pdu_type.0);
        let key = StateKey { exercise, pdu_type, id, part };
        let offset = if gone { GONE } else { frame.offset as u32 };
        self.states.entry(key).or_default().push(State { datagram, offset });
    }

    /// When each datagram is due by the clocks of its senders; see [`Recording::by_stamps`].
    ///
    /// [`Recording::by_stamps`]: crate::Recording::by_stamps
    pub(crate) fn times_by_stamps(&self) -> Vec<i64> {
        let Some(first) = self.entries.first() else { return Vec::new() };
        // What is added to the clock of a sender; none to that of the first one.
        let mut ahead_ns: BTreeMap<SocketAddr, i64> = BTreeMap::new();
        let mut latest_ns: Option<i64> = None;
        let by_clock = |e: &Entry| {
            if e.stamp == NO_STAMP {
                return latest_ns.unwrap_or(0);
            }
            let stamp = DisTime(e.stamp);
            let latest = *latest_ns.get_or_insert_with(|| stamp.near(0));
            let ahead = ahead_ns.entry(self.pairs[e.pair as usize].0).or_default();
            let mut due = stamp.near(latest - *ahead) + *ahead;
            if !(-LEAP_BACK_NS..=LEAP_AHEAD_NS).contains(&(due - latest)) {
                *ahead += latest - due;
                due = latest;
            }
            let latest = latest.max(due);
            latest_ns = Some(latest);
            latest
        };
        let clock: Vec<i64> = self.entries.iter().map(by_clock).collect();
        clock.iter().map(|ns| first.utc_ns + (ns - clock[0]).max(0)).collect()
    }

    /// Number of the first datagram at or after `utc_ns`.
    pub(crate) fn first_at(&self, utc_ns: i64) -> usize {
        self.entries.partition_point(|e| e.utc_ns < utc_ns)
    }

    /// The states that hold just before datagram `number` at time `utc_ns`; `lasting_ns` is the age
    /// at which a state has timed out.
    pub(crate) fn alive(&self, number: usize, utc_ns: i64, lasting_ns: i64) -> Vec<State> {
        let mut alive = Vec::new();
        for (key, states) in &self.states {
            let behind = states.partition_point(|s| (s.datagram as usize) < number);
            let Some(last) = behind.checked_sub(1).map(|i| states[i]) else { continue };
            if last.offset == GONE {
                continue;
            }
            let told_ns = self.entries[last.datagram as usize].utc_ns;
            let fresh = utc_ns.saturating_sub(told_ns) <= lasting_ns;
            // Slow heartbeats: the next state comes, so the entity was there all the time.
            let comes_again = states.get(behind).is_some_and(|next| {
                let next_ns = self.entries[next.datagram as usize].utc_ns;
                next_ns.saturating_sub(told_ns) <= SLOW_HEARTBEATS * lasting_ns
            });
            // An environmental process lasts until it is changed.
            if fresh || comes_again || key.pdu_type == 41 {
                alive.push(last);
            }
        }
        alive.sort_unstable_by_key(|s| (s.datagram, s.offset));
        alive
    }
}

/// Gaps of up to so many time-outs are taken for slow heartbeats.
const SLOW_HEARTBEATS: i64 = 12;

/// The file beside a recording that holds its index.
#[must_use]
pub(crate) fn sidecar(recording: &Path) -> PathBuf {
    let mut name = recording.as_os_str().to_owned();
    name.push(".idx");
    name.into()
}

/// What an index belongs to: a recording that changed has another identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Identity {
    octets: u64,
    modified_ns: i64,
    ends: u64,
}

/// Octets at both ends of a recording that its identity covers.
const ENDS: u64 = 4096;

impl Identity {
    pub(crate) fn of(file: &File) -> std::io::Result<Self> {
        use std::os::unix::fs::{FileExt, MetadataExt};
        let meta = file.metadata()?;
        let octets = meta.len();
        let mut hash = Checksum::default();
        let mut part = vec![0; octets.min(ENDS) as usize];
        file.read_exact_at(&mut part, 0)?;
        hash.add(&part);
        file.read_exact_at(&mut part, octets - octets.min(ENDS))?;
        hash.add(&part);
        let modified_ns = meta.mtime().saturating_mul(1_000_000_000) + meta.mtime_nsec();
        Ok(Self { octets, modified_ns, ends: hash.0 })
    }
}

/// Not against forgery: tells a damaged index from a sound one.
#[derive(Debug)]
struct Checksum(u64);

impl Default for Checksum {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Checksum {
    /// FNV-1a over words of eight octets (an incomplete last one padded with zeros).
    fn add(&mut self, octets: &[u8]) {
        for chunk in octets.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.0 = (self.0 ^ u64::from_le_bytes(word)).wrapping_mul(0x0100_0000_01b3);
            self.0 ^= self.0 >> 29;
        }
    }
}

/// First octets of a sidecar; the last one is the version.
const MAGIC: [u8; 8] = *b"DISIDX\0\x02";

impl Index {
    /// Writes the index into the sidecar of `recording`: whole or not at all.
    pub(crate) fn save(&self, recording: &Path, identity: Identity) -> std::io::Result<()> {
        let path = sidecar(recording);
        let mut part = path.clone().into_os_string();
        part.push(".part");
        let part = PathBuf::from(part);
        let written = File::create(&part).and_then(|mut file| {
            let octets = self.to_octets(identity);
            file.write_all(&octets)?;
            std::fs::rename(&part, &path)
        });
        if written.is_err() {
            let _ = std::fs::remove_file(&part);
        }
        written
    }

    /// The index in the sidecar of `recording`, if it is there, whole, and of this very file.
    pub(crate) fn load(recording: &Path, identity: Identity) -> Option<Self> {
        Self::from_octets(&std::fs::read(sidecar(recording)).ok()?, identity)
    }

    fn to_octets(&self, identity: Identity) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        let mut put = |v: &[u8]| out.extend_from_slice(v);
        put(&identity.octets.to_le_bytes());
        put(&identity.modified_ns.to_le_bytes());
        put(&identity.ends.to_le_bytes());
        put(&(self.entries.len() as u64).to_le_bytes());
        for e in &self.entries {
            put(&e.utc_ns.to_le_bytes());
            put(&e.place.to_le_bytes());
            put(&e.len.to_le_bytes());
            put(&e.pair.to_le_bytes());
            put(&e.stamp.to_le_bytes());
        }
        put(&(self.pairs.len() as u64).to_le_bytes());
        for (from, to) in &self.pairs {
            for address in [from, to] {
                let (v6, kind) = match address.ip() {
                    IpAddr::V4(v4) => (v4.to_ipv6_mapped(), 4u8),
                    IpAddr::V6(v6) => (v6, 6),
                };
                put(&[kind]);
                put(&v6.octets());
                put(&address.port().to_le_bytes());
            }
        }
        put(&(self.blob.len() as u64).to_le_bytes());
        put(&self.blob);
        put(&(self.states.len() as u64).to_le_bytes());
        for (key, states) in &self.states {
            put(&[key.exercise, key.pdu_type]);
            for word in [key.id.site, key.id.application, key.id.entity, key.part] {
                put(&word.to_le_bytes());
            }
            put(&(states.len() as u64).to_le_bytes());
            for s in states {
                put(&s.datagram.to_le_bytes());
                put(&s.offset.to_le_bytes());
            }
        }
        put(&self.problems.to_le_bytes());
        put(&(self.remarks.len() as u64).to_le_bytes());
        for remark in &self.remarks {
            put(&(remark.len() as u64).to_le_bytes());
            put(remark.as_bytes());
        }
        let mut sum = Checksum::default();
        sum.add(&out);
        out.extend_from_slice(&sum.0.to_le_bytes());
        out
    }

    fn from_octets(octets: &[u8], identity: Identity) -> Option<Self> {
        let (body, sum) = octets.split_at_checked(octets.len().checked_sub(8)?)?;
        let mut found = Checksum::default();
        found.add(body);
        let mut cursor = Cursor(body);
        if sum != found.0.to_le_bytes() || cursor.array()? != MAGIC {
            return None;
        }
        let of = Identity {
            octets: u64::from_le_bytes(cursor.array()?),
            modified_ns: i64::from_le_bytes(cursor.array()?),
            ends: u64::from_le_bytes(cursor.array()?),
        };
        if of != identity {
            return None;
        }
        let mut index = Self::default();
        let count = cursor.count(28)?;
        index.entries.reserve(count);
        for _ in 0..count {
            let raw: [u8; 28] = cursor.array()?;
            index.entries.push(Entry {
                utc_ns: i64::from_le_bytes(crate::bytes::array(&raw, 0)?),
                place: u64::from_le_bytes(crate::bytes::array(&raw, 8)?),
                len: u32::from_le_bytes(crate::bytes::array(&raw, 16)?),
                pair: u32::from_le_bytes(crate::bytes::array(&raw, 20)?),
                stamp: u32::from_le_bytes(crate::bytes::array(&raw, 24)?),
            });
        }
        for _ in 0..cursor.count(38)? {
            index.pairs.push((cursor.address()?, cursor.address()?));
        }
        let count = cursor.count(1)?;
        index.blob = cursor.take(count)?.to_vec();
        for _ in 0..cursor.count(18)? {
            let [exercise, pdu_type] = cursor.array()?;
            let mut word = || Some(u16::from_le_bytes(cursor.array()?));
            let id = EntityId { site: word()?, application: word()?, entity: word()? };
            let key = StateKey { exercise, pdu_type, id, part: word()? };
            let count = cursor.count(8)?;
            let mut states = Vec::with_capacity(count);
            for _ in 0..count {
                let datagram = u32::from_le_bytes(cursor.array()?);
                let offset = u32::from_le_bytes(cursor.array()?);
                states.push(State { datagram, offset });
            }
            index.states.insert(key, states);
        }
        index.problems = u64::from_le_bytes(cursor.array()?);
        for _ in 0..cursor.count(8)? {
            let len = cursor.count(1)?;
            index.remarks.push(String::from_utf8(cursor.take(len)?.to_vec()).ok()?);
        }
        index.is_consistent().then_some(index)
    }

    /// Every number that is used as a place points to something.
    fn is_consistent(&self) -> bool {
        let entries = self.entries.len();
        self.entries.is_sorted_by_key(|e| e.utc_ns)
            && self.entries.iter().all(|e| {
                let blob_end = (e.place & !IN_BLOB).checked_add(u64::from(e.len));
                (e.pair as usize) < self.pairs.len()
                    && (e.place & IN_BLOB == 0
                        || blob_end.is_some_and(|end| end <= self.blob.len() as u64))
            })
            && self.states.values().all(|states| {
                states.is_sorted_by_key(|s| s.datagram)
                    && states.iter().all(|s| (s.datagram as usize) < entries)
            })
    }
}

/// Octets taken from the front.
struct Cursor<'a>(&'a [u8]);

impl<'a> Cursor<'a> {
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (front, rest) = self.0.split_at_checked(n)?;
        self.0 = rest;
        Some(front)
    }
    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }
    /// A number of things of at least `least` octets each, which must be there.
    fn count(&mut self, least: usize) -> Option<usize> {
        let count = usize::try_from(u64::from_le_bytes(self.array()?)).ok()?;
        (count.checked_mul(least)? <= self.0.len()).then_some(count)
    }
    fn address(&mut self) -> Option<SocketAddr> {
        let [kind] = self.array()?;
        let v6 = Ipv6Addr::from(self.array::<16>()?);
        let port = u16::from_le_bytes(self.array()?);
        let ip: IpAddr = match kind {
            4 => v6.to_ipv4_mapped().unwrap_or(Ipv4Addr::UNSPECIFIED).into(),
            _ => v6.into(),
        };
        Some(SocketAddr::new(ip, port))
    }
}

/// Opens `path` and gives its index: from the sidecar if that is sound and fresh, else made anew.
/// True if it was made anew.
pub(crate) fn open(
    path: &Path,
    progress: &mut dyn FnMut(u64),
) -> Result<(File, Index, bool), OpenError> {
    let named = |cause| OpenError::Io { path: path.display().to_string(), cause };
    let reader = Reader::open(path)?;
    let file = File::open(path).map_err(named)?;
    let identity = Identity::of(&file).map_err(named)?;
    if let Some(index) = Index::load(path, identity) {
        return Ok((file, index, false));
    }
    let index = Index::build(reader, progress);
    // A folder that cannot be written to costs time at the next opening, nothing else.
    if identity.octets >= WORTH_SAVING {
        let _ = index.save(path, identity);
    }
    Ok((file, index, true))
}

/// Octets of a recording from which on its index is kept beside it.
const WORTH_SAVING: u64 = 8 << 20;

#[cfg(test)]
mod tests;
