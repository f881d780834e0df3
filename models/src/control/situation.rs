//! The surveillance function: what each track is to the airport in this scan.
//!
//! Tracks in, one [`Situation`] a track out: nose, mean speed, relation to the runways, clearances. Alerts,
//! guidance and planning read nothing else. What lies more than a scan back is kept per track, bounded.

use super::clearance::{Board, Clearance, ClearanceKind};
use super::layout::{Layout, RunwayAxis};
use super::parameters::Parameters;
use crate::frames::Vector2;
use crate::plot::Callsign;
use crate::time::SimTime;

mod doubt;
mod memory;

pub use doubt::Doubted;
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
    /// Track number, 0 to 4095.
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
    pub position_m: Vector2<f64>,
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
    pub nose_m: Vector2<f64>,
    /// Where the nose was in the scans before, the last one first.
    pub noses_before_m: [Option<Vector2<f64>>; 3],
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
/// A final of a track that has lasted so long stays that to its runway, s (assumed).
const STEADY_FINAL_S: f64 = 3.0;
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

    /// The situation of a strip's track.
    #[must_use]
    pub fn of_strip(&self, strip: u32) -> Option<&Situation> {
        let place = *self.by_strip.get(strip as usize)?;
        (place > 0).then(|| &self.situations[place as usize - 1])
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
        self.situations.clear();
        self.of_runways.clear();
        self.by_strip.clear();
        self.by_strip.resize(board.strips().len(), 0);
        self.of_strips.resize(board.strips().len(), OfStrip::default());
        let cos_aligned = libm::cos(parameters.aligned_deg.to_radians());
        for target in targets {
            let finite =
                target.position_m.iter().chain(target.velocity_mps.iter()).all(|x| x.is_finite());
            if !finite || now.since_s(target.last_plot) > parameters.coasting_s {
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
            if target.first || now.since_s(memory.seen) > FORGET_S {
                *memory = Memory::new(now, target);
            }
            memory.name(now, board, target, &mut self.of_strips);
            let situation = look(now, layout, parameters, cos_aligned, board, target, memory);
            let index = self.situations.len() as u32;
            if let Some(strip) = situation.strip {
                self.by_strip[strip as usize] = index + 1;
                self.of_strips[strip as usize] = OfStrip {
                    last_final: situation.last_final,
                    last_fast: situation.last_fast,
                    had: Some((target.number, now)),
                };
            }
            if situation.of_a_runway() {
                self.of_runways.push(index);
            }
            self.situations.push(situation);
        }
        if let Some(doubt) = &parameters.doubt {
            self.keep_names(now, doubt);
            self.find_doubles(doubt);
        }
    }
}

fn look(
    now: SimTime,
    layout: &Layout,
    parameters: &Parameters,
    cos_aligned: f64,
    board: &Board,
    target: &Target,
    memory: &mut Memory,
) -> Situation {
    let (position_m, velocity) = (target.position_m, target.velocity_mps);
    let speed_mps = velocity.norm();
    if let Some(doubt) = &parameters.doubt {
        memory.watch_steps(doubt, now, target);
    }
    // The velocity of one that stands is noise: on tracks the places have to move, too.
    let recent_mps = match &parameters.doubt {
        Some(_) => memory.mean_mps(now, position_m, 3.0),
        None => 0.0,
    };
    let moves = parameters.doubt.is_none() || recent_mps >= parameters.heading_mps;
    if speed_mps >= parameters.heading_mps && (moves || memory.heading.is_none()) {
        memory.heading = Some(velocity / speed_mps);
    }
    let half_m = 0.5 * target.length_m;
    let by_way =
        parameters.doubt.as_ref().filter(|doubt| speed_mps < doubt.slow_mps).and_then(|_| {
            let near = |r: &RunwayAxis| r.place_m(position_m).1.abs() < r.hold_m + target.length_m;
            let strip = &board.strips()[memory.strip? as usize];
            layout
                .runways
                .iter()
                .any(near)
                .then(|| doubt::nose_on(&strip.way_m, position_m, half_m))?
        });
    let nose_m = by_way.unwrap_or_else(|| position_m + memory.heading.unwrap_or_default() * half_m);
    let mean_mps = memory.mean_mps(now, position_m, parameters.mean_s);
    memory.keep(now, position_m);
    memory.seen = now;
    if parameters.doubt.is_some() {
        memory.stand(now, position_m, parameters.anchor_m, moves);
    } else if (position_m - memory.anchor_m).norm() > parameters.anchor_m {
        (memory.anchor_m, memory.still_since) = (position_m, now);
    }
    // Without altitude: in the air who goes around or has just lifted off, until he is as slow as nobody flies.
    let strip = memory.strip.map(|i| &board.strips()[i as usize]);
    let goes_around = strip.is_some_and(|s| s.kinds.has(ClearanceKind::GoAround));
    let lifted_off =
        strip.and_then(|s| s.lifted_off).is_some_and(|at| now.since_s(at) <= parameters.rolled_s);
    let airborne = match target.altitude_m {
        Some(altitude_m) => altitude_m > parameters.airborne_m,
        None => (goes_around || lifted_off) && speed_mps >= parameters.fast_mps,
    };
    let too_high = target.altitude_m.is_some_and(|altitude| altitude > parameters.strip_top_m);
    let mut situation = Situation {
        target: *target,
        strip: memory.strip,
        nose_m,
        noses_before_m: memory.noses_m,
        speed_mps,
        mean_mps,
        recent_mps,
        still_since: memory.still_since,
        airborne,
        strips: 0,
        fast: None,
        on_final: None,
        last_final: None,
        last_fast: None,
        on_ground_area: layout.ground_m.is_none_or(|[low, high]| {
            let within = |p: f64, a: f64, b: f64| a <= p && p <= b;
            within(position_m.x, low.x, high.x) && within(position_m.y, low.y, high.y)
        }),
        judged_mps: speed_mps,
        doubt: None,
    };
    memory.noses_m = [Some(nose_m), memory.noses_m[0], memory.noses_m[1]];
    // The first speeds of a track are guesses.
    let old = parameters.doubt.is_none_or(|d| now.since_s(memory.born) >= d.young_s);
    memory.was_slow |= old && speed_mps < parameters.fast_mps;
    if recent_mps > 0.0 {
        situation.judged_mps = speed_mps.min(recent_mps + 2.0);
    }
    let mut nearest = f64::INFINITY;
    // On tracks a final that has lasted stays the same one while it goes on: to the runway of one whose path crosses the
    // line of another's, nearest of all for a scan, nobody lands.
    let steady = memory.final_span.filter(|(since, until, _)| {
        parameters.doubt.is_some() && until.since_s(*since) >= STEADY_FINAL_S
    });
    let cleared = |r: usize, end: usize| {
        strip.is_some_and(|s| {
            let lands = |c: &Clearance| c.kind == ClearanceKind::Land;
            s.on_runway(r).any(|c| lands(c) && c.runway.is_some_and(|r| r.1 == Some(end)))
        })
    };
    let lands = target.altitude_m.is_none() && target.arriving && !memory.was_slow;
    let (mut stays, mut its_own) = (None, None);
    for (r, runway) in layout.runways.iter().take(MOST_RUNWAYS).enumerate() {
        let (s, d) = runway.place_m(position_m);
        let within = |s: f64| {
            s > -parameters.strip_beyond_m && s < runway.length_m + parameters.strip_beyond_m
        };
        if d.abs() < runway.hold_m + 0.5 * target.length_m && !too_high {
            let (nose_s, nose_d) = runway.place_m(nose_m);
            let inside = |s: f64, d: f64| {
                d.abs() < runway.hold_at_m(s, d) - parameters.strip_margin_m && within(s)
            };
            if inside(s, d) || inside(nose_s, nose_d) {
                situation.strips |= 1 << r;
            }
        }
        if speed_mps < parameters.fast_mps {
            continue;
        }
        let along = runway.along_mps(velocity);
        let side_m = 0.5 * runway.width_m + parameters.runway_side_m;
        let end = usize::from(along < 0.0);
        let from_end = if end == 0 { s } else { runway.length_m - s };
        let distance_m = runway.displaced_m[end] - from_end;
        // Without altitude: who comes is on the ground behind the threshold, not where the runway begins.
        let above = lands && parameters.doubt.is_some() && distance_m > 0.0;
        if !airborne
            && !above
            && along.abs() >= parameters.fast_mps.max(parameters.fast_aligned * speed_mps)
            && d.abs() <= side_m
            && within(s)
            && situation.fast.is_none()
        {
            situation.fast = Some(r);
        }
        if target.class != TargetClass::Vehicle
            && !goes_around
            && speed_mps >= parameters.final_mps
            && along.abs() >= speed_mps * cos_aligned
        {
            let wide = parameters.funnel_m + parameters.funnel_slope * distance_m;
            let before = (0.0..=parameters.funnel_length_m).contains(&distance_m);
            // Of parallel runways the one whose centreline is nearest.
            if before && d.abs() <= wide {
                let time_s = distance_m / along.abs();
                let here = Some(Final { runway: r, end, distance_m, time_s });
                if d.abs() < nearest {
                    nearest = d.abs();
                    situation.on_final = here;
                }
                if steady.is_some_and(|(_, _, runway)| runway == r) {
                    stays = here;
                }
                if cleared(r, end) {
                    its_own = here;
                }
            }
        }
    }
    // Where the finals of two runways run into each other, who is cleared to land on one of them is on final to that.
    situation.on_final = its_own.or(stays).or(situation.on_final);
    // Who is fast on a runway comes to no other, whichever line is ahead of him; without altitude he may fly over it to his own.
    if let Some(r) = situation.fast {
        let over = if target.altitude_m.is_none() { its_own } else { None };
        situation.on_final = situation.on_final.filter(|f| f.runway == r).or(over);
    }
    // Nor has one touched down who comes, was never slower than a roll and is not over a runway: light ones come slower than what
    // is taken for a final.
    situation.airborne |= lands && situation.fast.is_none() && memory.last_fast.is_none();
    // Without altitude: nobody is that fast on the ground but along a runway.
    if target.altitude_m.is_none() && speed_mps >= parameters.final_mps && situation.fast.is_none()
    {
        situation.strips = 0;
    }
    if let Some(on_final) = situation.on_final {
        memory.last_final = Some((now, on_final.runway));
    }
    memory.final_span = match (situation.on_final, memory.final_span) {
        (Some(f), Some((since, _, runway))) if f.runway == runway => Some((since, now, runway)),
        (Some(f), _) => {
            memory.final_from_s = f.time_s;
            Some((now, now, f.runway))
        }
        (None, span) => span.filter(|_| situation.fast.is_some()),
    };
    if let Some(doubt) = &parameters.doubt {
        // Who says his name has one, also where nobody has a strip of him: a car that was never cleared.
        let named = situation.strip.is_some() || target.callsign.is_some();
        situation.doubt = memory.doubted(doubt, now, &situation, named);
    }
    (memory.strips, memory.last_plot) = (situation.strips, target.last_plot);
    memory.velocities = [velocity, memory.velocities[0], memory.velocities[1]];
    if situation.fast.is_some() {
        memory.last_fast = Some(now);
    }
    situation.last_final = memory.last_final;
    situation.last_fast = memory.last_fast;
    situation
}
