//! The door for people at controllers' seats: what they do waits here for the next frame, and goes into it.
//!
//! Whoever sits down is looked for: after 30 s without a word of him the seat is given up in his name, so that the model of it
//! goes on. Everything that takes effect is in a frame end, with its number; the log of one run (`inputs`) fed to another
//! gives the same bits.

use crate::runtime::messages::{Frame, SeatAction, SeatAnswer, SeatInput, SeatOrder};
use models::control::clearance::ClearanceKind;
use scenarios::Scene;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Longest name of a person.
const NAME: usize = 32;
/// Largest file of inputs that is read, octets: some hundred thousand of them.
const LARGEST_INPUTS: u64 = 16 << 20;
/// What may wait for one frame.
const MOST_WAITING: usize = 64;
/// So long after his last word a person is gone, ns of the host's clock.
pub const SILENT_NS: i64 = 30_000_000_000;
/// How often it is said in frames that somebody is still there, ns of simulated time.
const HERE_NS: i64 = 60_000_000_000;

#[derive(Clone, Debug)]
struct Holder {
    person: String,
    heard_utc_ns: i64,
    /// Frame of what was said of him last.
    told: Frame,
}

/// Inputs of people, until their frame.
#[derive(Debug, Default)]
pub struct SeatDoor {
    /// Names of seats; none where nobody can sit down.
    seats: Vec<String>,
    callsigns: BTreeSet<String>,
    frame_ns: i64,
    holders: BTreeMap<String, Holder>,
    waiting: VecDeque<SeatInput>,
    /// Inputs of an earlier run, by frame.
    script: Vec<(Frame, SeatInput)>,
    next: usize,
    numbers: u64,
    frame: Frame,
}

impl SeatDoor {
    /// The door of a scene.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let behaving = scene.traffic.behaving.as_ref().filter(|_| scene.control.on_tracks());
        let seats = behaving.map(|b| models::control::actors::seats::seats(&b.network));
        Self {
            seats: seats.iter().flatten().map(|seat| seat.name()).collect(),
            callsigns: behaving
                .iter()
                .flat_map(|b| b.flights.iter().map(|f| f.callsign.clone()))
                .collect(),
            frame_ns: scene.run.frame.0,
            ..Self::default()
        }
    }

    /// The keys on which people are heard.
    #[must_use]
    pub fn seats(&self) -> &[String] {
        &self.seats
    }

    /// Inputs of an earlier run are said again, each in its frame.
    pub fn follow(&mut self, script: Vec<(Frame, SeatInput)>) {
        self.script = script;
        self.script.sort_by_key(|(frame, input)| (*frame, input.number));
    }

    /// A new run: nobody has said anything.
    pub fn clear(&mut self) {
        self.holders.clear();
        self.waiting.clear();
        (self.next, self.numbers, self.frame) = (0, 0, 0);
    }

    /// Somebody does something, at a time of the host's clock.
    pub fn ask(&mut self, order: SeatOrder, utc_ns: i64) -> SeatAnswer {
        match self.check(&order, utc_ns) {
            Ok(true) => {
                let number = self.number();
                self.waiting.push_back(SeatInput { number, order });
                SeatAnswer { accepted: true, number, text: String::new() }
            }
            Ok(false) => SeatAnswer { accepted: true, ..SeatAnswer::default() },
            Err(text) => SeatAnswer { text, ..SeatAnswer::default() },
        }
    }

    fn number(&mut self) -> u64 {
        self.numbers += 1;
        self.numbers
    }

    /// Whether it goes into a frame.
    fn check(&mut self, order: &SeatOrder, utc_ns: i64) -> Result<bool, String> {
        let SeatOrder { seat, person, action } = order;
        if self.seats.is_empty() {
            return Err("nobody can sit down in this scene: it needs traffic that behaves (kind = \"schedule\" or \
                 \"generated\") and [control] sees = \"tracks\", controllers = \"model\""
                .to_owned());
        }
        if !self.seats.contains(seat) {
            let seat: String = seat.chars().take(NAME).collect();
            return Err(format!("there is no seat {seat:?}; there are {}", self.seats.join(", ")));
        }
        let sound = |c: char| c.is_ascii_alphanumeric() || "-_. ".contains(c);
        if person.is_empty() || person.len() > NAME || !person.chars().all(sound) {
            return Err(format!(
                "person: 1 to {NAME} letters, digits, blanks, '-', '_' or '.', so that others see who has the seat"
            ));
        }
        if let Some(other) = self.holders.get(seat).filter(|h| h.person != *person) {
            return Err(format!("{seat} is taken by {}", other.person));
        }
        if let SeatAction::Say { callsign, clearance } = action {
            if !self.callsigns.contains(callsign) {
                let callsign: String = callsign.chars().take(NAME).collect();
                return Err(format!("there is no flight {callsign:?} in this scene"));
            }
            if ClearanceKind::of(clearance).is_none() {
                let word: String = clearance.chars().take(NAME).collect();
                return Err(format!(
                    "there is no clearance {word:?}: PSH, TAX, HLD, CRO, LUP, TOF, LND or GOA"
                ));
            }
        }
        if self.waiting.len() >= MOST_WAITING {
            return Err(format!(
                "{MOST_WAITING} inputs wait for a frame: does time stand? Try again when it goes on"
            ));
        }
        let held = self.holders.contains_key(seat);
        if *action == SeatAction::Take {
            let told = self.frame;
            let holder = Holder { person: person.clone(), heard_utc_ns: utc_ns, told };
            self.holders.insert(seat.clone(), holder);
            return Ok(!held);
        }
        let Some(holder) = self.holders.get_mut(seat) else {
            return Err(format!("nobody sits at {seat}: take it first"));
        };
        holder.heard_utc_ns = utc_ns;
        if *action == SeatAction::Leave {
            self.holders.remove(seat);
        }
        Ok(*action != SeatAction::Here)
    }

    /// What goes into a frame.
    pub fn admit(&mut self, frame: Frame, utc_ns: i64) -> Vec<SeatInput> {
        self.frame = frame;
        let mut inputs = Vec::new();
        while let Some((_, input)) = self.script.get(self.next).filter(|(f, _)| *f <= frame) {
            inputs.push(input.clone());
            self.numbers = self.numbers.max(input.number);
            self.next += 1;
        }
        inputs.extend(self.waiting.drain(..));
        let here_frames = (HERE_NS / self.frame_ns.max(1)) as Frame;
        let mut of_holders = Vec::new();
        self.holders.retain(|seat, holder| {
            let gone = utc_ns - holder.heard_utc_ns > SILENT_NS;
            let due = frame >= holder.told + here_frames;
            if gone || due {
                let action = if gone { SeatAction::Leave } else { SeatAction::Here };
                let (seat, person) = (seat.clone(), holder.person.clone());
                of_holders.push(SeatOrder { seat, person, action });
                holder.told = frame;
            }
            !gone
        });
        for order in of_holders {
            let number = self.number();
            inputs.push(SeatInput { number, order });
        }
        for input in &inputs {
            if let Some(holder) = self.holders.get_mut(&input.order.seat) {
                holder.told = frame;
            }
        }
        inputs
    }
}

/// The inputs of an earlier run: table `inputs` of its database, or a line of JSON each
/// (`{"frame": 1200, "seat": "ground", "person": "anna", "action": "say", "callsign": "SWR1A", "clearance": "TAX"}`).
///
/// # Errors
/// What cannot be read, and where.
pub fn read_inputs(path: &std::path::Path) -> anyhow::Result<Vec<(Frame, SeatInput)>> {
    use anyhow::Context;
    use std::io::Read;
    let at = || path.display().to_string();
    if path.extension().is_some_and(|e| e == "sqlite") {
        let flags = rusqlite::OpenFlags::SQLITE_OPEN_READ_ONLY;
        let log = rusqlite::Connection::open_with_flags(path, flags).with_context(at)?;
        let query = "SELECT frame, number, seat, person, action, callsign, clearance FROM inputs ORDER BY frame, number";
        let mut rows = log.prepare(query).with_context(at)?;
        let row = |row: &rusqlite::Row<'_>| {
            Ok(Line {
                frame: row.get::<_, i64>(0)? as u64,
                number: row.get::<_, i64>(1)? as u64,
                seat: row.get(2)?,
                person: row.get(3)?,
                action: row.get(4)?,
                callsign: row.get(5)?,
                clearance: row.get(6)?,
            })
        };
        let lines = rows.query_map([], row).and_then(Iterator::collect::<Result<Vec<_>, _>>);
        return lines.with_context(at)?.into_iter().map(|l| l.input().with_context(at)).collect();
    }
    let (mut text, file) = (String::new(), std::fs::File::open(path).with_context(at)?);
    file.take(LARGEST_INPUTS + 1).read_to_string(&mut text).with_context(at)?;
    anyhow::ensure!(
        text.len() as u64 <= LARGEST_INPUTS,
        "{}: longer than {} MiB: no run has so many inputs",
        at(),
        LARGEST_INPUTS >> 20
    );
    let mut inputs = Vec::new();
    for (index, text) in text.lines().enumerate().filter(|(_, text)| !text.trim().is_empty()) {
        let place = || format!("{}:{}", path.display(), index + 1);
        let line: Line = serde_json::from_str(text).with_context(place)?;
        let line = Line { number: line.number.max(inputs.len() as u64 + 1), ..line };
        inputs.push(line.input().with_context(place)?);
    }
    Ok(inputs)
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    frame: Frame,
    #[serde(default)]
    number: u64,
    seat: String,
    person: String,
    action: String,
    #[serde(default)]
    callsign: String,
    #[serde(default)]
    clearance: String,
}

impl Line {
    fn input(self) -> anyhow::Result<(Frame, SeatInput)> {
        let Self { frame, number, seat, person, action, callsign, clearance } = self;
        let action = SeatAction::of(&action, &callsign, &clearance).map_err(anyhow::Error::msg)?;
        Ok((frame, SeatInput { number, order: SeatOrder { seat, person, action } }))
    }
}

#[cfg(test)]
mod tests;
