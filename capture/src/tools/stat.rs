//! `stat`: what is in a file.

use super::{DisReader, json, type_name};
use crate::error::OpenError;
use crate::reader::Datagram;
use crate::utc::Utc;
use pdu::Body;
use pdu::enumerations::PduType;
use pdu::records::EntityId;
use std::collections::BTreeMap;
use std::fmt;
use std::net::SocketAddr;
use std::path::Path;

/// Counts of PDUs and octets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Amount {
    /// PDUs (datagrams where senders are counted).
    pub count: u64,
    /// Their octets.
    pub octets: u64,
}

impl Amount {
    fn add(&mut self, octets: usize) {
        self.count += 1;
        self.octets += octets as u64;
    }
}

/// One entity as its Entity State PDUs tell it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EntityStat {
    /// Marking of its last PDU.
    pub marking: String,
    /// Type of its last PDU, in the usual notation.
    pub entity_type: String,
    /// Its Entity State PDUs.
    pub states: u64,
    /// First one, ns since 1970 UTC.
    pub first_ns: i64,
    /// Last one.
    pub last_ns: i64,
}

/// What is in a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stat {
    /// DIS datagrams.
    pub datagrams: Amount,
    /// Datagrams with more than one PDU.
    pub bundles: u64,
    /// PDUs that could be cut out by their length, sound or not.
    pub pdus: u64,
    /// PDUs and octets by type.
    pub by_type: BTreeMap<u8, Amount>,
    /// By protocol version.
    pub by_version: BTreeMap<u8, u64>,
    /// By exercise.
    pub by_exercise: BTreeMap<u8, u64>,
    /// Datagrams by sender.
    pub by_sender: BTreeMap<SocketAddr, Amount>,
    /// Datagrams by receiver.
    pub by_receiver: BTreeMap<SocketAddr, Amount>,
    /// Entities by exercise and identifier.
    pub entities: BTreeMap<(u8, EntityId), EntityStat>,
    /// First and last stamp, ns since 1970 UTC.
    pub span_ns: Option<(i64, i64)>,
    /// Most datagrams in one second.
    pub busiest_second: u64,
    /// Damaged PDUs and odd octets.
    pub damaged: u64,
    /// Datagrams to other ports.
    pub others: u64,
    /// What is wrong with the file itself, in words (the first hundred).
    pub problems: Vec<String>,
}

/// Counts what is in a file.
///
/// # Errors
/// [`OpenError`], with the path.
pub fn stat(path: impl AsRef<Path>, ports: &[u16]) -> Result<Stat, OpenError> {
    let mut reader = DisReader::open(path, ports)?;
    let mut stat = Stat::default();
    let mut datagram = Datagram::empty();
    let (mut second, mut in_second) = (i64::MIN, 0);
    while let Some(result) = reader.read(&mut datagram) {
        if let Err(problem) = result {
            if stat.problems.len() < 100 {
                stat.problems.push(problem.to_string());
            }
            continue;
        }
        let now = datagram.utc_ns;
        let (first, last) = stat.span_ns.unwrap_or((now, now));
        stat.span_ns = Some((first.min(now), last.max(now)));
        if now.div_euclid(1_000_000_000) != second {
            (second, in_second) = (now.div_euclid(1_000_000_000), 0);
        }
        in_second += 1;
        stat.busiest_second = stat.busiest_second.max(in_second);
        stat.add(&datagram);
    }
    stat.others = reader.others();
    Ok(stat)
}

impl Stat {
    fn add(&mut self, datagram: &Datagram) {
        self.datagrams.add(datagram.payload.len());
        self.by_sender.entry(datagram.from).or_default().add(datagram.payload.len());
        self.by_receiver.entry(datagram.to).or_default().add(datagram.payload.len());
        let mut in_datagram = 0;
        for frame in pdu::frames(&datagram.payload) {
            let Ok(frame) = frame else {
                self.damaged += 1;
                continue;
            };
            in_datagram += 1;
            self.pdus += 1;
            let header = &frame.header;
            self.by_type.entry(header.pdu_type.0).or_default().add(frame.octets.len());
            *self.by_version.entry(header.version.0).or_default() += 1;
            *self.by_exercise.entry(header.exercise_id).or_default() += 1;
            match frame.decode() {
                Err(_) => self.damaged += 1,
                Ok(pdu) => {
                    if let Body::EntityState(state) = pdu.body() {
                        let key = (header.exercise_id, state.entity_id);
                        let entity = self.entities.entry(key).or_default();
                        if entity.states == 0 {
                            entity.first_ns = datagram.utc_ns;
                        }
                        entity.states += 1;
                        entity.last_ns = datagram.utc_ns;
                        entity.marking = state.marking.text();
                        entity.entity_type = state.entity_type.to_string();
                    }
                }
            }
        }
        self.bundles += u64::from(in_datagram > 1);
    }

    /// For programs: one object.
    #[must_use]
    pub fn json(&self) -> String {
        let amounts = |map: &BTreeMap<SocketAddr, Amount>| {
            json::counts(map.iter().map(|(k, a)| (k, a.count)))
        };
        let entities: Vec<String> = self
            .entities
            .iter()
            .map(|((exercise, id), e)| {
                json::Object::default()
                    .raw("exercise", exercise)
                    .text("id", id)
                    .text("marking", &e.marking)
                    .text("type", &e.entity_type)
                    .raw("states", e.states)
                    .raw("first_utc_ns", e.first_ns)
                    .raw("last_utc_ns", e.last_ns)
                    .end()
            })
            .collect();
        let (first, last) = self.span_ns.unwrap_or((0, 0));
        let problems: Vec<String> = self
            .problems
            .iter()
            .map(|p| {
                let mut quoted = String::new();
                json::string(&mut quoted, p);
                quoted
            })
            .collect();
        json::Object::default()
            .raw("datagrams", self.datagrams.count)
            .raw("octets", self.datagrams.octets)
            .raw("bundles", self.bundles)
            .raw("pdus", self.pdus)
            .raw("by_type", json::counts(self.by_type.iter().map(|(t, a)| (t, a.count))))
            .raw("by_version", json::counts(self.by_version.iter().map(|(v, n)| (v, *n))))
            .raw("by_exercise", json::counts(self.by_exercise.iter().map(|(v, n)| (v, *n))))
            .raw("by_sender", amounts(&self.by_sender))
            .raw("by_receiver", amounts(&self.by_receiver))
            .raw("first_utc_ns", first)
            .raw("last_utc_ns", last)
            .raw("busiest_second", self.busiest_second)
            .raw("damaged", self.damaged)
            .raw("other_datagrams", self.others)
            .raw("entities", format_args!("[{}]", entities.join(",")))
            .raw("problems", format_args!("[{}]", problems.join(",")))
            .end()
    }
}

impl fmt::Display for Stat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((first, last)) = self.span_ns {
            let s = (last - first) as f64 * 1e-9;
            writeln!(f, "from {} to {}, {s:.3} s", Utc(first), Utc(last))?;
            if s > 0.0 {
                let (rate, octets) = (self.pdus as f64 / s, self.datagrams.octets as f64 / s);
                writeln!(
                    f,
                    "{rate:.1} PDU/s, {octets:.0} B/s, busiest second {} datagrams",
                    self.busiest_second
                )?;
            }
        }
        writeln!(f, "{:>10} datagrams, {} bytes", self.datagrams.count, self.datagrams.octets)?;
        writeln!(f, "{:>10} of them bundles", self.bundles)?;
        writeln!(f, "{:>10} PDUs", self.pdus)?;
        for (t, a) in &self.by_type {
            writeln!(f, "{:>10}   {} ({t}), {} bytes", a.count, type_name(PduType(*t)), a.octets)?;
        }
        for (v, n) in &self.by_version {
            writeln!(f, "{n:>10}   of version {v}")?;
        }
        for (e, n) in &self.by_exercise {
            writeln!(f, "{n:>10}   of exercise {e}")?;
        }
        writeln!(f, "{:>10} damaged", self.damaged)?;
        if self.others > 0 {
            writeln!(f, "{:>10} datagrams to other ports", self.others)?;
        }
        for (what, map) in [("from", &self.by_sender), ("to", &self.by_receiver)] {
            for (address, a) in map {
                writeln!(f, "{:>10} datagrams {what} {address}", a.count)?;
            }
        }
        writeln!(f, "{:>10} entities", self.entities.len())?;
        for ((exercise, id), e) in &self.entities {
            let s = (e.last_ns - e.first_ns) as f64 * 1e-9;
            let (states, marking, kind) = (e.states, &e.marking, &e.entity_type);
            writeln!(
                f,
                "{states:>10}   states of {id} `{marking}` {kind}, exercise {exercise}, {s:.3} s"
            )?;
        }
        for problem in &self.problems {
            writeln!(f, "{problem}")?;
        }
        Ok(())
    }
}
