//! `diff`: what one file has and another has not.

use super::fields::Value;
use super::{Ports, json, type_name};
use crate::error::OpenError;
use crate::recording::{AlivePdu, Recording};
use pdu::enumerations::PduType;
use pdu::records::EntityId;
use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::path::Path;

/// By what PDUs of two files are taken for the same one; of several, the first goes with the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// Exercise.
    pub exercise: u8,
    /// Type.
    pub pdu_type: u8,
    /// The entity that the body begins with (nobody where it is too short).
    pub entity: EntityId,
    /// Time stamp as on the wire (0 where times are ignored).
    pub timestamp: u32,
}

/// One difference.
#[derive(Clone, Debug, PartialEq)]
pub enum Difference {
    /// Only the first file has it.
    OnlyFirst(Key, u64),
    /// Only the second file has it.
    OnlySecond(Key, u64),
    /// Both have it with other content.
    Changed {
        /// What it is.
        key: Key,
        /// Number of its datagram in both files, from 1.
        datagrams: (u64, u64),
        /// Field, value in the first file, value in the second.
        fields: Vec<(String, String, String)>,
    },
}

/// What was counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Diff {
    /// PDUs that both have, octet by octet.
    pub same: u64,
    /// PDUs that both have with other content.
    pub changed: u64,
    /// PDUs that only the first has.
    pub only_first: u64,
    /// PDUs that only the second has.
    pub only_second: u64,
}

impl Diff {
    /// True if there is no difference.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.changed + self.only_first + self.only_second == 0
    }
}

/// Where a PDU is, and a sum of its octets.
#[derive(Clone, Copy)]
struct Place {
    datagram: u32,
    offset: u32,
    sum: u64,
}

/// Compares the PDUs of two files. With `ignore_times`, time stamps do not count. Damaged PDUs are
/// compared as far as their length cuts them out.
///
/// # Errors
/// [`OpenError`], with the path; also if a file changes while it is read.
pub fn diff(
    first: &Path,
    second: &Path,
    ports: &[u16],
    ignore_times: bool,
    mut tell: impl FnMut(&Difference),
) -> Result<Diff, OpenError> {
    let (a, mut in_a) = places(first, ports, ignore_times)?;
    let (b, in_b) = places(second, ports, ignore_times)?;
    let mut counts = Diff::default();
    let (mut octets_a, mut octets_b) = (Vec::new(), Vec::new());
    let number = |place: &Place| u64::from(place.datagram) + 1;
    for (key, list) in in_b {
        for place_b in list {
            let Some(place_a) = in_a.get_mut(&key).and_then(VecDeque::pop_front) else {
                counts.only_second += 1;
                tell(&Difference::OnlySecond(key, number(&place_b)));
                continue;
            };
            if place_a.sum == place_b.sum {
                counts.same += 1;
                continue;
            }
            counts.changed += 1;
            read(&a, first, place_a, &mut octets_a)?;
            read(&b, second, place_b, &mut octets_b)?;
            let fields = changed_fields(&octets_a, &octets_b, ignore_times);
            let datagrams = (number(&place_a), number(&place_b));
            tell(&Difference::Changed { key, datagrams, fields });
        }
    }
    for (key, list) in in_a {
        for place in list {
            counts.only_first += 1;
            tell(&Difference::OnlyFirst(key, number(&place)));
        }
    }
    Ok(counts)
}

type Places = BTreeMap<Key, VecDeque<Place>>;

fn places(
    path: &Path,
    ports: &[u16],
    ignore_times: bool,
) -> Result<(Recording, Places), OpenError> {
    let ports = Ports::of(path, ports)?;
    let recording = Recording::open(path)?;
    let mut places = Places::new();
    let mut payload = Vec::new();
    for i in 0..recording.len() {
        if !ports.contain(recording.from_to(i).1.port()) {
            continue;
        }
        recording.payload(i, &mut payload).map_err(|cause| io_error(path, cause))?;
        for frame in pdu::frames(&payload).map_while(Result::ok) {
            let header = &frame.header;
            let word = |at: usize| crate::bytes::be16(frame.octets, at).unwrap_or(0);
            let key = Key {
                exercise: header.exercise_id,
                pdu_type: header.pdu_type.0,
                entity: EntityId::new(word(12), word(14), word(16)),
                timestamp: if ignore_times { 0 } else { header.timestamp.0 },
            };
            let place = Place {
                datagram: i as u32,
                offset: frame.offset as u32,
                sum: sum(frame.octets, ignore_times),
            };
            places.entry(key).or_default().push_back(place);
        }
    }
    Ok((recording, places))
}

/// FNV-1a over the octets.
fn sum(octets: &[u8], ignore_times: bool) -> u64 {
    let mut sum = 0xcbf2_9ce4_8422_2325_u64;
    for (at, octet) in octets.iter().enumerate() {
        if !(ignore_times && (4..8).contains(&at)) {
            sum = (sum ^ u64::from(*octet)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    sum
}

fn read(
    recording: &Recording,
    path: &Path,
    place: Place,
    into: &mut Vec<u8>,
) -> Result<(), OpenError> {
    let pdu = AlivePdu { datagram: place.datagram as usize, offset: place.offset as usize };
    recording.pdu(pdu, into).map_err(|cause| io_error(path, cause))
}

fn io_error(path: &Path, cause: std::io::Error) -> OpenError {
    OpenError::Io { path: path.display().to_string(), cause }
}

/// Field by field where both decode, else the first octet that differs.
fn changed_fields(a: &[u8], b: &[u8], ignore_times: bool) -> Vec<(String, String, String)> {
    let lines = |octets: &[u8]| {
        let received = pdu::pdus(octets).next()?.ok()?;
        let mut lines: BTreeMap<String, String> = BTreeMap::new();
        lines.extend(prefixed("header", Value::of(received.header()).lines()));
        lines.extend(prefixed("body", Value::of(received.body()).lines()));
        if ignore_times {
            lines.remove("header.timestamp");
        }
        Some(lines)
    };
    if let (Some(of_a), Some(of_b)) = (lines(a), lines(b)) {
        let nothing = String::from("absent");
        let names: std::collections::BTreeSet<&String> = of_a.keys().chain(of_b.keys()).collect();
        let changed: Vec<_> = names
            .into_iter()
            .filter(|name| of_a.get(*name) != of_b.get(*name))
            .map(|name| {
                let value =
                    |of: &BTreeMap<String, String>| of.get(name).unwrap_or(&nothing).clone();
                (name.clone(), value(&of_a), value(&of_b))
            })
            .collect();
        if !changed.is_empty() {
            return changed;
        }
    }
    let at = a.iter().zip(b).take_while(|(a, b)| a == b).count();
    let octet = |of: &[u8]| of.get(at).map_or("absent".to_owned(), |o| format!("{o:#04x}"));
    vec![(format!("octet {at}"), octet(a), octet(b))]
}

fn prefixed(
    prefix: &str,
    lines: Vec<(String, String)>,
) -> impl Iterator<Item = (String, String)> + '_ {
    lines.into_iter().map(move |(name, value)| (format!("{prefix}.{name}"), value))
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, stamp) = (type_name(PduType(self.pdu_type)), pdu::DisTime(self.timestamp));
        write!(f, "{name} of {} at {stamp}, exercise {}", self.entity, self.exercise)
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OnlyFirst(key, n) => write!(f, "- {key} (datagram {n})"),
            Self::OnlySecond(key, n) => write!(f, "+ {key} (datagram {n})"),
            Self::Changed { key, datagrams: (a, b), fields } => {
                write!(f, "! {key} (datagrams {a}, {b})")?;
                for (name, a, b) in fields {
                    write!(f, "\n    {name}: {a} -> {b}")?;
                }
                Ok(())
            }
        }
    }
}

impl Difference {
    /// For programs: one object.
    #[must_use]
    pub fn json(&self) -> String {
        let object = |kind: &str, key: &Key| {
            json::Object::default()
                .text("difference", kind)
                .raw("exercise", key.exercise)
                .raw("type", key.pdu_type)
                .text("entity", key.entity)
                .raw("timestamp", key.timestamp)
        };
        match self {
            Self::OnlyFirst(key, n) => object("only_first", key).raw("datagram", n).end(),
            Self::OnlySecond(key, n) => object("only_second", key).raw("datagram", n).end(),
            Self::Changed { key, datagrams, fields } => {
                let fields = fields.iter().fold(json::Object::default(), |o, (name, a, b)| {
                    let mut pair = String::from("[");
                    json::string(&mut pair, a);
                    pair.push(',');
                    json::string(&mut pair, b);
                    pair.push(']');
                    o.raw(name, pair)
                });
                object("changed", key)
                    .raw("datagrams", format_args!("[{},{}]", datagrams.0, datagrams.1))
                    .raw("fields", fields.end())
                    .end()
            }
        }
    }
}

impl Diff {
    /// The closing line for programs.
    #[must_use]
    pub fn json(&self) -> String {
        json::Object::default()
            .raw("same", self.same)
            .raw("changed", self.changed)
            .raw("only_first", self.only_first)
            .raw("only_second", self.only_second)
            .end()
    }
}

impl fmt::Display for Diff {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { same, changed, only_first, only_second } = self;
        write!(
            f,
            "{same} same, {changed} changed, {only_first} only in the first, {only_second} only in the second"
        )
    }
}
