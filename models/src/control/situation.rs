//! The surveillance function: what each track is to the airport in this scan.
//!
//! Tracks in, one [`Situation`] a track out: nose, mean speed, relation to the runways, clearances. Alerts,
//! guidance and planning read nothing else. What lies more than a scan back is kept per track, bounded.

use super::cells::Cells;
use super::clearance::Board;
use super::layout::Layout;
use super::parameters::Parameters;
use crate::frames::{Point2, Vector2};
use crate::plot::Callsign;
use crate::time::SimTime;

mod doubt;
mod look;
mod memory;

pub use doubt::Doubted;
use look::Look;
use memory::{Memory, OfStrip};

/// What moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TargetClass {
    /// Not known: no label.
    #[default]
    Unknown,
    /// An aircraft.
    Aircraft,
    /// A vehicle.
    Vehicle,
}

/// A track as the safety net takes it. Airport frame, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Track number, below 32 768.
    pub number: u16,
    /// Call sign, where the track has one.
    pub callsign: Option<Callsign>,
    /// Aircraft or vehicle.
    pub class: TargetClass,
    /// An arrival by its flight plan.
    pub arriving: bool,
    /// Length by its type; 0 where not known.
    pub length_m: f64,
    /// Middle of its length.
    pub position_m: Point2<f64>,
    /// Velocity, m/s.
    pub velocity_mps: Vector2<f64>,
    /// Height over the aerodrome, m, where known.
    pub altitude_m: Option<f64>,
    /// Time of its last plot.
    pub last_plot: SimTime,
    /// First report of this number: what was known of it is of another.
    pub first: bool,
}

/// On final to a runway.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Final {
    /// Runway.
    pub runway: usize,
    /// End that it flies to.
    pub end: usize,
    /// Distance to the threshold, m.
    pub distance_m: f64,
    /// Time to it, s.
    pub time_s: f64,
}

/// What one track is to the airport in one scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Situation {
    /// The track.
    pub target: Target,
    /// Its strip on the board.
    pub strip: Option<u32>,
    /// Its nose, m.
    pub nose_m: Point2<f64>,
    /// Where the memory of its track is.
    memory: u32,
    /// Ground speed, m/s.
    pub speed_mps: f64,
    /// Mean speed over the last ten seconds, without its jumps; 0 for a younger track.
    pub mean_mps: f64,
    /// The same over the last three seconds.
    pub recent_mps: f64,
    /// Not moved since.
    pub still_since: SimTime,
    /// Known to be in the air.
    pub airborne: bool,
    /// Runways to whose strip it is so near that a part of it may be there, one bit each.
    pub(super) near: u32,
    /// Runways in whose strip it is, one bit each.
    pub strips: u32,
    /// Runway along which it rolls.
    pub fast: Option<usize>,
    /// On final.
    pub on_final: Option<Final>,
    /// Last on final: when, and to which runway.
    pub last_final: Option<(SimTime, usize)>,
    /// Last fast on a runway.
    pub last_fast: Option<SimTime>,
    /// Within the box of the ground network.
    pub on_ground_area: bool,
    /// Ground speed that is judged: of the track, or where that is less, 2 m/s above the mean of three seconds.
    pub judged_mps: f64,
    /// Why it raises nothing by itself.
    pub doubt: Option<Doubted>,
}

impl Situation {
    /// Of a track that nobody has looked at yet.
    fn new(target: Target) -> Self {
        Self {
            target,
            strip: None,
            nose_m: target.position_m,
            memory: 0,
            speed_mps: 0.0,
            mean_mps: 0.0,
            recent_mps: 0.0,
            still_since: target.last_plot,
            airborne: false,
            near: 0,
            strips: 0,
            fast: None,
            on_final: None,
            last_final: None,
            last_fast: None,
            on_ground_area: true,
            judged_mps: 0.0,
            doubt: None,
        }
    }
    /// Whether it is in the strip of a runway.
    #[must_use]
    #[inline]
    pub fn in_strip(&self, runway: usize) -> bool {
        self.strips >> runway & 1 == 1
    }
    /// Whether it was on final within the last `seconds`.
    #[must_use]
    pub fn was_on_final(&self, now: SimTime, seconds: f64) -> Option<usize> {
        self.last_final.filter(|(at, _)| now.since_s(*at) <= seconds).map(|(_, runway)| runway)
    }
    /// Whether it has anything to do with a runway.
    #[must_use]
    #[inline]
    pub fn of_a_runway(&self) -> bool {
        self.strips != 0 || self.fast.is_some() || self.on_final.is_some()
    }
}

/// Runways that are looked at; more than any airport has.
pub const MOST_RUNWAYS: usize = 32;
/// A track not seen for so long is another one when its number comes again, s.
const FORGET_S: f64 = 20.0;

/// The surveillance function with its memory of at most one entry a track number.
#[derive(Clone, Debug)]
pub struct Surveillance {
    /// By track number: place in `memories`, plus one.
    places: Vec<u16>,
    memories: Vec<Memory>,
    situations: Vec<Situation>,
    /// Places in `situations` of those that have to do with a runway.
    of_runways: Vec<u32>,
    /// By strip: place in `situations`, plus one.
    by_strip: Vec<u32>,
    /// By strip: what outlives its track.
    of_strips: Vec<OfStrip>,
    /// Places in `situations` of those without strip and name.
    unnamed: Vec<u32>,
    /// Those of them that raise alerts, by where they are.
    cells: Cells,
}

impl Default for Surveillance {
    fn default() -> Self {
        Self {
            places: vec![0; 4096],
            memories: Vec::new(),
            situations: Vec::new(),
            of_runways: Vec::new(),
            by_strip: Vec::new(),
            of_strips: Vec::new(),
            unnamed: Vec::new(),
            cells: Cells::default(),
        }
    }
}

impl Surveillance {
    /// The situations of the last scan, in the order of its tracks.
    #[must_use]
    pub fn situations(&self) -> &[Situation] {
        &self.situations
    }

    /// Places in [`Self::situations`] of those that have to do with a runway, ascending.
    #[must_use]
    pub fn of_runways(&self) -> &[u32] {
        &self.of_runways
    }

    /// The situation of a track.
    #[must_use]
    pub fn of_track(&self, number: u16) -> Option<&Situation> {
        let memory = usize::from(*self.places.get(usize::from(number))?).checked_sub(1)?;
        let situation = self.situations.get(self.memories[memory].index as usize)?;
        (situation.target.number == number).then_some(situation)
    }

    /// The situation of a strip's track.
    #[must_use]
    pub fn of_strip(&self, strip: u32) -> Option<&Situation> {
        let place = *self.by_strip.get(strip as usize)?;
        (place > 0).then(|| &self.situations[place as usize - 1])
    }

    /// Where the nose of one of these was in the scans before, the last one first.
    pub(super) fn noses_before_m(&self, situation: &Situation) -> [Option<Point2<f64>>; 3] {
        self.memories[situation.memory as usize].places.noses_before_m()
    }

    /// Takes in the tracks of a scan. Tracks that coast for too long, and numbers above 4095, are left out.
    pub fn scan(
        &mut self,
        now: SimTime,
        layout: &Layout,
        parameters: &Parameters,
        board: &Board,
        targets: &[Target],
    ) {
        // What was seen in the last scan is written over.
        let mut seen = 0;
        self.of_runways.clear();
        self.unnamed.clear();
        self.by_strip.clear();
        self.by_strip.resize(board.strips().len(), 0);
        self.of_strips.resize(board.strips().len(), OfStrip::default());
        let look = Look::new(now, layout, parameters, board);
        let (coasting, forgotten) = (now.back_s(parameters.coasting_s), now.back_s(FORGET_S));
        for target in targets {
            // Zero times a number that is not finite is no zero, nor is it of a sum with one.
            let (p, v) = (target.position_m, target.velocity_mps);
            let finite = 0.0 * ((p.x + p.y) + (v.x + v.y)) == 0.0;
            if !finite || target.last_plot < coasting {
                continue;
            }
            let Some(place) = self.places.get(usize::from(target.number)).copied() else {
                continue;
            };
            let place = if place == 0 {
                self.memories.push(Memory::new(now, target));
                self.places[usize::from(target.number)] = self.memories.len() as u16;
                self.memories.len() - 1
            } else {
                usize::from(place) - 1
            };
            let memory = &mut self.memories[place];
            if target.first || memory.seen < forgotten {
                *memory = Memory::new(now, target);
            }
            memory.name(now, board, target, &mut self.of_strips);
            let index = seen as u32;
            memory.index = index;
            if seen == self.situations.len() {
                self.situations.push(Situation::new(*target));
            }
            let situation = &mut self.situations[seen];
            situation.memory = place as u32;
            look.at(target, memory, situation);
            seen += 1;
            if let Some(strip) = situation.strip {
                self.by_strip[strip as usize] = index + 1;
                self.of_strips[strip as usize] = OfStrip {
                    last_final: memory.last_final,
                    last_fast: memory.last_fast,
                    had: Some((target.number, now)),
                };
                memory.had_at = now;
            } else if target.callsign.is_none() {
                self.unnamed.push(index);
            }
            if situation.of_a_runway() {
                self.of_runways.push(index);
            }
        }
        self.situations.truncate(seen);
        if let Some(lately) = &look.lately {
            self.keep_names(lately, parameters, board);
            self.find_doubles(lately);
        }
    }
}
