//! `lint`: what hurts in practice although every PDU may be well formed.

use super::{DisReader, json, type_name};
use crate::error::OpenError;
use crate::reader::Datagram;
use geodesy::Ecef;
use pdu::enumerations::{
    AcknowledgeFlag, DeadReckoningAlgorithm, EntityKind, ForceId, MarkingCharacterSet,
    PlatformDomain, ResponseFlag, StopReason,
};
use pdu::records::EntityId;
use pdu::{Body, DisTime, EntityState, Frame};
use std::collections::BTreeMap;
use std::fmt;
use std::net::SocketAddr;
use std::path::Path;

/// Kinds of findings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rule {
    /// The file itself is damaged.
    File,
    /// A PDU whose length and content do not fit.
    Length,
    /// A PDU of a bundle that does not begin on a multiple of eight octets.
    Boundary,
    /// A header whose version, type and family do not go together.
    Header,
    /// A number that its enumeration does not have.
    Enumeration,
    /// NaN or infinity.
    NotFinite,
    /// A position inside the earth.
    InsideEarth,
    /// A dead-reckoning model that stands still, with a velocity.
    StillModel,
    /// An entity silent for longer than the time-out that was neither removed nor deactivated.
    Heartbeat,
    /// One identifier used by two entities.
    Duplicate,
    /// Time that goes backwards.
    Backwards,
}

impl Rule {
    /// All rules.
    pub const ALL: [Self; 11] = [
        Self::File,
        Self::Length,
        Self::Boundary,
        Self::Header,
        Self::Enumeration,
        Self::NotFinite,
        Self::InsideEarth,
        Self::StillModel,
        Self::Heartbeat,
        Self::Duplicate,
        Self::Backwards,
    ];

    /// Its name in output and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::File => "file",
            Self::Length => "length",
            Self::Boundary => "boundary",
            Self::Header => "header",
            Self::Enumeration => "enumeration",
            Self::NotFinite => "not-finite",
            Self::InsideEarth => "inside-earth",
            Self::StillModel => "still-model",
            Self::Heartbeat => "heartbeat",
            Self::Duplicate => "duplicate",
            Self::Backwards => "backwards",
        }
    }
}

/// One finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Its kind.
    pub rule: Rule,
    /// Frame in the file, from 1; 0 where it is about the file.
    pub frame: u64,
    /// PDU in the datagram, from 0.
    pub pdu: usize,
    /// The entity, where it is about one.
    pub entity: Option<EntityId>,
    /// What was found.
    pub what: String,
}

/// How strict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Silence of an entity that is too long, ns: 2.4 heartbeats of 5 s (IEEE 1278.1-2012, 4.2.3).
    pub silence_ns: i64,
    /// Time stamps may go back by so much, ns: senders with several threads.
    pub back_ns: i64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { silence_ns: 12_000_000_000, back_ns: 1_000_000 }
    }
}

/// Looks at every PDU of a file; gives the number of findings of each kind.
///
/// # Errors
/// [`OpenError`], with the path.
pub fn lint(
    path: impl AsRef<Path>,
    ports: &[u16],
    limits: Limits,
    mut tell: impl FnMut(&Finding),
) -> Result<BTreeMap<Rule, u64>, OpenError> {
    let mut reader = DisReader::open(path, ports)?;
    let mut counts = BTreeMap::new();
    let mut linter = Linter { limits, ..Linter::default() };
    let mut datagram = Datagram::empty();
    while let Some(result) = reader.read(&mut datagram) {
        match result {
            Ok(()) => linter.datagram(&datagram),
            Err(problem) => linter.found.push(Finding {
                rule: Rule::File,
                frame: 0,
                pdu: 0,
                entity: None,
                what: problem.to_string(),
            }),
        }
        for finding in linter.found.drain(..) {
            *counts.entry(finding.rule).or_default() += 1;
            tell(&finding);
        }
    }
    linter.end();
    for finding in linter.found.drain(..) {
        *counts.entry(finding.rule).or_default() += 1;
        tell(&finding);
    }
    Ok(counts)
}

/// What is remembered of an entity.
#[derive(Debug)]
struct Known {
    from: SocketAddr,
    kind: String,
    marking: String,
    stamp: DisTime,
    last_ns: i64,
    frame: u64,
    gone: bool,
}

#[derive(Debug, Default)]
struct Linter {
    limits: Limits,
    entities: BTreeMap<(u8, EntityId), Known>,
    last_ns: Option<i64>,
    found: Vec<Finding>,
}

impl Linter {
    fn datagram(&mut self, datagram: &Datagram) {
        let frame_number = datagram.frame;
        let mut say = |rule, pdu, what: String| {
            self.found.push(Finding { rule, frame: frame_number, pdu, entity: None, what });
        };
        if let Some(last) = self.last_ns.filter(|last| datagram.utc_ns < *last) {
            let back = seconds(last - datagram.utc_ns);
            say(Rule::Backwards, 0, format!("captured {back} s before the datagram before it"));
        }
        self.last_ns = Some(self.last_ns.map_or(datagram.utc_ns, |l| l.max(datagram.utc_ns)));
        if datagram.missing > 0 {
            let n = datagram.missing;
            say(Rule::Length, 0, format!("the capture left out the last {n} bytes"));
        }
        for frame in pdu::frames(&datagram.payload) {
            match frame {
                Ok(frame) => self.frame(datagram, &frame),
                Err(error) => self.found.push(Finding {
                    rule: Rule::Length,
                    frame: frame_number,
                    pdu: error.index,
                    entity: None,
                    what: error.to_string(),
                }),
            }
        }
    }

    fn frame(&mut self, datagram: &Datagram, frame: &Frame<'_>) {
        let mut about = About { datagram, frame, entity: None, found: &mut self.found };
        if !frame.offset.is_multiple_of(8) {
            let at = frame.offset;
            about.say(Rule::Boundary, format!("begins at octet {at}, no multiple of 8"));
        }
        header(&mut about);
        let decoded = match frame.decode() {
            Ok(decoded) => decoded,
            Err(error) => return about.say(Rule::Length, error.to_string()),
        };
        match decoded.body() {
            Body::EntityState(state) => {
                about.entity = Some(state.entity_id);
                entity_state(&mut about, state);
                self.remember(datagram, frame, state);
            }
            Body::RemoveEntity(remove) => {
                for ((exercise, id), known) in &mut self.entities {
                    let same = *exercise == frame.header.exercise_id;
                    known.gone |= same && remove.receiving_id.addresses(*id);
                }
            }
            Body::StopFreeze(stop) => {
                about.named("reason", stop.reason.0, StopReason::name(stop.reason));
            }
            Body::Acknowledge(a) => {
                about.named(
                    "acknowledge_flag",
                    a.acknowledge_flag.0,
                    AcknowledgeFlag::name(a.acknowledge_flag),
                );
                about.named(
                    "response_flag",
                    a.response_flag.0,
                    ResponseFlag::name(a.response_flag),
                );
            }
            _ => {}
        }
    }

    /// What needs the entity's PDUs before this one.
    fn remember(&mut self, datagram: &Datagram, frame: &Frame<'_>, state: &EntityState<'_>) {
        let id = state.entity_id;
        let mut about = About { datagram, frame, entity: Some(id), found: &mut self.found };
        let now = Known {
            from: datagram.from,
            kind: state.entity_type.to_string(),
            marking: state.marking.text(),
            stamp: frame.header.timestamp,
            last_ns: datagram.utc_ns,
            frame: datagram.frame,
            // Bit 23 of every appearance word: deactivated (SISO-REF-010).
            gone: state.appearance >> 23 & 1 == 1,
        };
        let key = (frame.header.exercise_id, id);
        let before = match self.entities.get(&key) {
            Some(before) if !before.gone => before,
            _ => {
                self.entities.insert(key, now);
                return;
            }
        };
        let silence = now.last_ns.saturating_sub(before.last_ns);
        if silence > self.limits.silence_ns {
            about.say(Rule::Heartbeat, format!("silent for {} s before this", seconds(silence)));
        }
        let back = before.stamp.nanos_since(now.stamp);
        if back > self.limits.back_ns {
            about.say(Rule::Backwards, format!("time stamp goes back by {} s", seconds(back)));
        }
        let mut differ = Vec::new();
        if before.from != now.from {
            differ.push(format!("sent by {} and {}", before.from, now.from));
        }
        if before.kind != now.kind {
            differ.push(format!("of type {} and {}", before.kind, now.kind));
        }
        if before.marking != now.marking {
            differ.push(format!("marked `{}` and `{}`", before.marking, now.marking));
        }
        if !differ.is_empty() {
            let frame = before.frame;
            let what = differ.join(", ");
            about.say(Rule::Duplicate, format!("one identifier, {what} (before: frame {frame})"));
        }
        self.entities.insert(key, now);
    }

    /// Who fell silent and never came back.
    fn end(&mut self) {
        let end = self.last_ns.unwrap_or(0);
        for ((_, id), known) in &self.entities {
            let silence = end.saturating_sub(known.last_ns);
            if !known.gone && silence > self.limits.silence_ns {
                let silence = seconds(silence);
                self.found.push(Finding {
                    rule: Rule::Heartbeat,
                    frame: known.frame,
                    pdu: 0,
                    entity: Some(*id),
                    what: format!("the last of it, {silence} s before the end; neither removed nor deactivated"),
                });
            }
        }
    }
}

/// A PDU that findings are about.
struct About<'a> {
    datagram: &'a Datagram,
    frame: &'a Frame<'a>,
    entity: Option<EntityId>,
    found: &'a mut Vec<Finding>,
}

impl About<'_> {
    fn say(&mut self, rule: Rule, what: String) {
        self.found.push(Finding {
            rule,
            frame: self.datagram.frame,
            pdu: self.frame.index,
            entity: self.entity,
            what,
        });
    }

    fn named(&mut self, field: &str, value: impl fmt::Display, name: Option<&str>) {
        if name.is_none() {
            self.say(Rule::Enumeration, format!("{field} = {value} is not in SISO-REF-010"));
        }
    }
}

fn header(about: &mut About<'_>) {
    let h = about.frame.header;
    if !(5..=7).contains(&h.version.0) {
        about.say(Rule::Header, format!("version {} is not one of 5, 6, 7", h.version.0));
    }
    if !(1..=72).contains(&h.pdu_type.0) {
        about.say(Rule::Header, format!("type {} is not in the standard", h.pdu_type.0));
    } else if h.family != pdu::family_of(h.pdu_type) {
        let (name, family) = (type_name(h.pdu_type), pdu::family_of(h.pdu_type));
        about.say(
            Rule::Header,
            format!("family {} for {name}, which is of family {family}", h.family),
        );
    }
}

/// Deeper than anything stands on land (the Dead Sea's shore is at −430 m).
const DEEPEST_ON_LAND_M: f64 = -1_000.0;
/// Deeper than the sea (the Mariana Trench has 10 935 m).
const DEEPEST_IN_SEA_M: f64 = -12_000.0;

fn entity_state(about: &mut About<'_>, s: &EntityState<'_>) {
    let kind = s.entity_type.kind;
    about.named("entity_type.kind", kind.0, EntityKind::name(kind));
    if kind == EntityKind::PLATFORM {
        let domain = s.entity_type.platform_domain();
        about.named("entity_type.domain", domain.0, PlatformDomain::name(domain));
    }
    // UID 6 has forces up to 30; names here go as far as most users.
    if s.force_id.0 > 30 {
        about.named("force_id", s.force_id.0, ForceId::name(s.force_id));
    }
    let model = s.dead_reckoning_algorithm;
    about.named("dead_reckoning_algorithm", model.0, DeadReckoningAlgorithm::name(model));
    let characters = s.marking.character_set;
    about.named("marking.character_set", characters.0, MarkingCharacterSet::name(characters));

    let (l, o) = (s.location, s.orientation);
    let velocity = s.linear_velocity_mps.to_f64();
    for (field, values) in [
        ("location", [l.x_m, l.y_m, l.z_m]),
        ("orientation", [o.psi_rad, o.theta_rad, o.phi_rad].map(f64::from)),
        ("linear_velocity", velocity),
        ("linear_acceleration", s.linear_acceleration_mps2.to_f64()),
        ("angular_velocity", s.angular_velocity_rad_s.to_f64()),
    ] {
        if values.iter().any(|v| !v.is_finite()) {
            let [x, y, z] = values;
            about.say(Rule::NotFinite, format!("{field} = {x} {y} {z}"));
        }
    }
    if [l.x_m, l.y_m, l.z_m].iter().all(|v| v.is_finite()) {
        let height_m = Ecef::from(l).to_geodetic().height_m;
        let on_land_or_above = kind == EntityKind::PLATFORM
            && s.entity_type.platform_domain() != PlatformDomain::SUBSURFACE;
        let deepest = if on_land_or_above { DEEPEST_ON_LAND_M } else { DEEPEST_IN_SEA_M };
        if height_m.is_nan() || height_m < deepest {
            about.say(Rule::InsideEarth, format!("height {height_m:.0} m above WGS 84"));
        }
    }
    if model == DeadReckoningAlgorithm::STATIC && velocity.iter().any(|v| *v != 0.0) {
        let [x, y, z] = velocity;
        about.say(Rule::StillModel, format!("{model} with velocity {x} {y} {z} m/s"));
    }
}

fn seconds(ns: i64) -> String {
    format!("{:.3}", ns as f64 * 1e-9)
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.rule.name())?;
        if self.frame > 0 {
            write!(f, "frame {}, PDU {}: ", self.frame, self.pdu)?;
        }
        if let Some(id) = self.entity {
            write!(f, "entity {id}: ")?;
        }
        f.write_str(&self.what)
    }
}

impl Finding {
    /// For programs: one object.
    #[must_use]
    pub fn json(&self) -> String {
        let object = json::Object::default()
            .text("rule", self.rule.name())
            .raw("frame", self.frame)
            .raw("pdu", self.pdu);
        match self.entity {
            Some(id) => object.text("entity", id),
            None => object,
        }
        .text("what", &self.what)
        .end()
    }
}
