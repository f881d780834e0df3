//! The door for people at controllers' seats and at the wheel: what they do waits here for the next frame, and goes into it.
//!
//! Whoever sits down is looked for: after 30 s without a word of him the seat is given up in his name, so that the model of it
//! goes on; who drives, after 5 s. Everything that takes effect is in a frame end, with its number; the log of one run (`inputs`) fed to another
//! gives the same bits.

use crate::exchange::operator::may_name;
use crate::exchange::{driven, handover};
use crate::federation::closes_loop;
use crate::runtime::messages::{Frame, SeatAction, SeatAnswer, SeatInput, SeatOrder, SeatWords};
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
/// The same of a person who drives, ns.
pub const WHEEL_SILENT_NS: i64 = 5_000_000_000;
/// Nobody drives in a run that goes faster than this, simulated seconds in a second: real time, as it is measured.
const MOST_RATE: f64 = 1.2;
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
    /// From which somebody drives: some of them, and those of flights that taxi.
    wheels: BTreeSet<String>,
    /// Simulated seconds in a second of the host's clock.
    rate: f64,
    callsigns: BTreeSet<String>,
    /// What may be handed over.
    handover: Option<handover::Rules>,
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
        let behaving = scene.traffic.behaving.as_ref().filter(|_| closes_loop(scene));
        let seats = behaving.map(|b| models::control::actors::seats::seats(&b.network));
        let wheels = driven::seats(scene);
        let handover = handover::Rules::of(scene);
        let given = handover.as_ref().map(|_| handover::SEAT.to_owned());
        let names = seats.iter().flatten().map(|seat| seat.name());
        Self {
            seats: names.chain(wheels.clone()).chain(given).collect(),
            handover,
            wheels: wheels.into_iter().chain(driven::flight_seats(scene)).collect(),
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

    /// How fast simulated time goes now.
    pub fn paced(&mut self, rate: f64) {
        self.rate = rate;
    }

    /// Somebody does something, at a time of the host's clock.
    pub fn ask(&mut self, order: SeatOrder, utc_ns: i64) -> SeatAnswer {
        let mut order = order;
        match self.check(&mut order, utc_ns) {
            Ok(true) => {
                let number = self.number();
                // Of what is driven in one frame the last counts.
                if matches!(order.action, SeatAction::Drive { .. }) {
                    let drives = |i: &SeatInput| matches!(i.order.action, SeatAction::Drive { .. });
                    self.waiting.retain(|i| i.order.seat != order.seat || !drives(i));
                }
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

    /// Whether there is such a seat, and if not, why.
    fn has(&self, seat: &str) -> Result<(), String> {
        if self.wheels.contains(seat) {
            return Ok(());
        }
        if self.seats.is_empty() {
            return Err("nobody can sit down in this scene: it needs traffic that behaves (kind = \"schedule\" or \
                 \"generated\") and [control] sees = \"truth\", or sees = \"tracks\" with controllers = \"model\""
                .to_owned());
        }
        if !self.seats.iter().any(|s| s == seat) {
            let seat: String = seat.chars().take(NAME).collect();
            return Err(format!("there is no seat {seat:?}; there are {}", self.seats.join(", ")));
        }
        Ok(())
    }

    /// From where one drives, in words.
    fn driven(&self) -> String {
        match self.wheels.is_empty() {
            true => "this scene has no [[traffic]] of kind \"driven\"".to_owned(),
            false => {
                let all: Vec<&str> = self.wheels.iter().map(String::as_str).take(12).collect();
                let more = if self.wheels.len() > all.len() { ", …" } else { "" };
                format!("there are {}{more}", all.join(", "))
            }
        }
    }

    /// Whether it goes into a frame.
    fn check(&mut self, order: &mut SeatOrder, utc_ns: i64) -> Result<bool, String> {
        let SeatOrder { seat, person, action } = order;
        self.has(seat)?;
        if person.is_empty() || person.len() > NAME || !person.chars().all(may_name) {
            return Err(format!(
                "person: 1 to {NAME} letters, digits, blanks, '-', '_', '.' or '@', so that others see who has the seat"
            ));
        }
        if seat.as_str() == handover::SEAT
            && let Some(rules) = &self.handover
        {
            *action = rules.check(action, utc_ns)?;
            return self.has_room().map(|()| true);
        }
        if matches!(action, SeatAction::Give { .. } | SeatAction::Release { .. }) {
            return Err(format!("aircraft are handed over at {}, not at {seat}", handover::SEAT));
        }
        if let Some(other) = self.holders.get(seat).filter(|h| h.person != *person) {
            return Err(format!("{seat} is taken by {}", other.person));
        }
        if let SeatAction::Say { callsign, .. }
        | SeatAction::Decide { callsign, .. }
        | SeatAction::WhatIf { callsign, .. } = action
            && !self.callsigns.contains(callsign)
        {
            let callsign: String = callsign.chars().take(NAME).collect();
            return Err(format!("there is no flight {callsign:?} in this scene"));
        }
        let wheel = self.wheels.contains(seat);
        let drives = matches!(action, SeatAction::Drive { .. });
        let to_flight = matches!(
            action,
            SeatAction::Say { .. } | SeatAction::Decide { .. } | SeatAction::WhatIf { .. }
        );
        if wheel && to_flight {
            return Err(format!("{seat} drives: take, drive, here or leave"));
        }
        if !wheel && drives {
            return Err(format!("nothing is driven from {seat}; {}", self.driven()));
        }
        if (drives || wheel && *action == SeatAction::Take) && self.rate > MOST_RATE {
            return Err(format!(
                "the run goes at {:.1} times real time: nobody can drive; `rate 1` is needed",
                self.rate
            ));
        }
        self.has_room()?;
        let held = self.holders.contains_key(seat);
        if *action == SeatAction::Take {
            let told = self.frame;
            let holder = Holder { person: person.clone(), heard_utc_ns: utc_ns, told };
            self.holders.insert(seat.clone(), holder);
            // Inputs of an earlier run may have taken it since: then who asks again is heard again.
            return Ok(!held || !self.script.is_empty());
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

    fn has_room(&self) -> Result<(), String> {
        if self.waiting.len() >= MOST_WAITING {
            return Err(format!(
                "{MOST_WAITING} inputs wait for a frame: does time stand? Try again when it goes on"
            ));
        }
        Ok(())
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
            let wheel = self.wheels.contains(seat);
            let most_ns = if wheel { WHEEL_SILENT_NS } else { SILENT_NS };
            let gone = utc_ns - holder.heard_utc_ns > most_ns;
            let due = !wheel && frame >= holder.told + here_frames;
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
/// What cannot be read, and where; a seat that the scene does not have.
pub fn read_inputs(
    path: &std::path::Path,
    scene: &Scene,
) -> anyhow::Result<Vec<(Frame, SeatInput)>> {
    read_for(path, &SeatDoor::new(scene))
}

fn read_for(path: &std::path::Path, door: &SeatDoor) -> anyhow::Result<Vec<(Frame, SeatInput)>> {
    use anyhow::Context;
    use std::io::Read;
    let at = || path.display().to_string();
    let sound = |frame: Frame, number: u64, words: SeatWords| {
        let order = words.read()?;
        door.has(&order.seat)?;
        if let (handover::SEAT, Some(rules)) = (&*order.seat, &door.handover) {
            rules.check_said(&order.action)?;
        }
        Ok::<_, String>((frame, SeatInput { number, order }))
    };
    if path.extension().is_some_and(|e| e == "sqlite") {
        let flags = rusqlite::OpenFlags::SQLITE_OPEN_READ_ONLY;
        let log = rusqlite::Connection::open_with_flags(path, flags).with_context(at)?;
        let query = "SELECT frame, number, seat, person, action, callsign, clearance FROM inputs WHERE action <> 'silent' ORDER BY frame, number";
        let mut rows = log.prepare(query).with_context(at)?;
        let row = |row: &rusqlite::Row<'_>| {
            let words = SeatWords {
                seat: row.get(2)?,
                person: row.get(3)?,
                action: row.get(4)?,
                callsign: row.get(5)?,
                clearance: row.get(6)?,
            };
            Ok((row.get::<_, i64>(0)? as Frame, row.get::<_, i64>(1)? as u64, words))
        };
        let rows = rows.query_map([], row).and_then(Iterator::collect::<Result<Vec<_>, _>>);
        let input = |(frame, number, words): (Frame, u64, SeatWords)| {
            let place = || format!("{}: table inputs, frame {frame}", path.display());
            sound(frame, number, words).map_err(anyhow::Error::msg).with_context(place)
        };
        return rows.with_context(at)?.into_iter().map(input).collect();
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
        let mut fields: serde_json::Map<String, serde_json::Value> =
            serde_json::from_str(text).with_context(place)?;
        let mut whole = |key: &str| fields.remove(key).map(|v| v.as_u64().ok_or(key.to_owned()));
        let (frame, number) = (whole("frame").transpose(), whole("number").transpose());
        let wrong = |key: String| anyhow::anyhow!("{key}: a whole number, at least 0");
        let number = number.map_err(wrong).with_context(place)?.unwrap_or(0);
        let frame = frame.map_err(wrong).with_context(place)?;
        let frame =
            frame.ok_or_else(|| anyhow::anyhow!("missing field `frame`")).with_context(place)?;
        let number = number.max(inputs.len() as u64 + 1);
        let words = SeatWords::of(fields).map_err(anyhow::Error::msg).with_context(place)?;
        inputs.push(sound(frame, number, words).map_err(anyhow::Error::msg).with_context(place)?);
    }
    Ok(inputs)
}

#[cfg(test)]
mod tests;
