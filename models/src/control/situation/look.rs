//! One look at a track: what it is to the airport in this scan, and what is remembered of it.

use super::doubt::{Lately, nose_on};
use super::memory::{Back, Memory, UNKNOWN_HALF_M};
use super::{Final, MOST_RUNWAYS, Situation, Target, TargetClass};
use crate::control::clearance::{Board, Clearance, ClearanceKind, Strip};
use crate::control::layout::Layout;
use crate::control::parameters::Parameters;
use crate::time::SimTime;

/// A final of a track that has lasted so long stays that to its runway, s (assumed).
const STEADY_FINAL_S: f64 = 3.0;
/// Who gains speed moves less than twice as fast as his places of three seconds show, but for this, m/s (assumed).
const JUMP_MPS: f64 = 1.0;
/// Who holds before a line stops so far short of it, m: the most of 5 m ± 2 m (assumed).
const SHORT_M: f64 = 7.0;
/// Who is longer than twice this holds before no line, m (assumed).
const MOST_HALF_M: f64 = 30.0;
/// Who has stood for so long stands, s (assumed).
const STANDS_S: f64 = 10.0;

/// What all tracks of a scan are looked at with.
pub(super) struct Look<'a> {
    now: SimTime,
    layout: &'a Layout,
    parameters: &'a Parameters,
    board: &'a Board,
    cos_aligned: f64,
    /// For the mean speed, and for that of three seconds.
    mean: Back,
    recent: Back,
    /// Tracks that were born until then have a mean speed.
    settled: SimTime,
    /// Nothing where tracks are exact.
    pub(super) lately: Option<Lately<'a>>,
}

impl<'a> Look<'a> {
    pub(super) fn new(
        now: SimTime,
        layout: &'a Layout,
        parameters: &'a Parameters,
        board: &'a Board,
    ) -> Self {
        let cos_aligned = libm::cos(parameters.aligned_deg.to_radians());
        let (mean, recent) = (Back::new(now, parameters.mean_s), Back::new(now, 3.0));
        let lately = parameters.doubt.as_ref().map(|doubt| Lately::new(now, doubt));
        let guessed_s = parameters.doubt.as_ref().map(|doubt| parameters.mean_s + doubt.young_s);
        let settled = guessed_s.map_or(now, |seconds| now.back_s(seconds));
        Self { now, layout, parameters, board, cos_aligned, mean, recent, settled, lately }
    }

    /// Writes the situation of a track, all of it but where its memory is.
    pub(super) fn at(&self, target: &Target, memory: &mut Memory, situation: &mut Situation) {
        let (now, layout, parameters) = (self.now, self.layout, self.parameters);
        let (position_m, velocity) = (target.position_m, target.velocity_mps);
        let speed_mps = velocity.norm();
        if let Some(lately) = &self.lately {
            memory.watch_steps(lately, target);
        }
        // The velocity of one that stands is noise: on tracks the places have to move, too.
        let recent_mps = match &parameters.doubt {
            Some(_) => memory.mean_mps(now, position_m, &self.recent),
            None => 0.0,
        };
        let moves = parameters.doubt.is_none() || recent_mps >= parameters.heading_mps;
        // One jump makes a speed, too: far above what its places of three seconds show, and of one who has never left where he was first.
        let jumps = || {
            parameters.doubt.is_some()
                && (speed_mps > 2.0 * recent_mps + JUMP_MPS
                    || memory.heading.is_none()
                        && (position_m - memory.anchor_m).norm() < parameters.anchor_m / 3.0)
        };
        if speed_mps >= parameters.heading_mps && moves && !jumps() {
            memory.heading = Some(velocity / speed_mps);
        }
        let strip = memory.strip.map(|i| &self.board.strips()[i as usize]);
        let half_m = match &parameters.doubt {
            Some(_) if target.length_m == 0.0 => memory.held_half_m,
            _ => 0.5 * target.length_m,
        };
        let near = self.near(target, 2.0 * half_m);
        let slow = parameters.doubt.as_ref().is_some_and(|doubt| speed_mps < doubt.slow_mps);
        let way_m = strip.filter(|_| slow && near != 0).map(|strip| &strip.way_m[..]);
        let by_way = way_m.and_then(|way_m| nose_on(way_m, position_m, half_m));
        let nose_m =
            by_way.unwrap_or_else(|| position_m + memory.heading.unwrap_or_default() * half_m);
        // Where a track was in its first seconds is a guess.
        let mean_mps = if memory.born <= self.settled {
            memory.mean_mps(now, position_m, &self.mean)
        } else {
            0.0
        };
        memory.places.keep(now, position_m, nose_m, memory.jumps);
        memory.seen = now;
        if parameters.doubt.is_some() {
            memory.stand(now, position_m, parameters.anchor_m, moves);
        } else if (position_m - memory.anchor_m).norm() > parameters.anchor_m {
            (memory.anchor_m, memory.still_since) = (position_m, now);
        }
        let airborne = match target.altitude_m {
            Some(altitude_m) => altitude_m > parameters.airborne_m,
            // In the air is who goes around or has just lifted off, until he is as slow as nobody flies.
            None => {
                strip.is_some_and(|s| s.flies(now, parameters.rolled_s))
                    && speed_mps.max(recent_mps) >= parameters.fast_mps
            }
        };
        situation.target = *target;
        situation.strip = memory.strip;
        situation.nose_m = nose_m;
        situation.speed_mps = speed_mps;
        situation.mean_mps = mean_mps;
        situation.recent_mps = recent_mps;
        situation.still_since = memory.still_since;
        situation.airborne = airborne;
        situation.near = near;
        situation.on_ground_area = layout.ground_m.is_none_or(|[low, high]| {
            let within = |p: f64, a: f64, b: f64| a <= p && p <= b;
            within(position_m.x, low.x, high.x) && within(position_m.y, low.y, high.y)
        });
        situation.judged_mps =
            if recent_mps > 0.0 { speed_mps.min(recent_mps + 2.0) } else { speed_mps };
        (situation.fast, situation.on_final, situation.doubt) = (None, None, None);
        // The first speeds of a track are guesses, and so are those of one that jumps: its places have to show it, too.
        let shown = || {
            parameters.doubt.is_none_or(|d| {
                let calm = memory.jumped.is_none_or(|at| now.since_s(at) > d.jump_s);
                now.since_s(memory.born) >= d.young_s && calm && recent_mps < parameters.fast_mps
            })
        };
        memory.was_slow = memory.was_slow || speed_mps < parameters.fast_mps && shown();
        situation.strips = self.strips(situation, half_m, memory.strips);
        if target.callsign.is_none() && target.length_m == 0.0 && parameters.doubt.is_some() {
            self.holds(situation, memory);
        }
        let lands = target.altitude_m.is_none() && target.arriving && !memory.was_slow;
        if speed_mps >= parameters.fast_mps {
            self.of_runways(situation, memory, strip, lands);
        }
        // Nor has one touched down who comes, was never slower than a roll and is not over a runway: light ones come slower than
        // what is taken for a final.
        situation.airborne |= lands && situation.fast.is_none() && memory.last_fast.is_none();
        // Without altitude: nobody is that fast on the ground but along a runway, and who was sent around has climbed over it.
        let flies = speed_mps >= parameters.final_mps || goes_around(strip) && situation.airborne;
        if target.altitude_m.is_none() && flies && situation.fast.is_none() {
            situation.strips = 0;
        }
        // The first velocity of a track is a guess: it makes nobody one who landed.
        let known = parameters.doubt.is_none_or(|d| now.since_s(memory.born) >= d.young_s);
        if let Some(on_final) = situation.on_final.filter(|_| known) {
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
        if let Some(lately) = &self.lately {
            // Who says his name has one, also where nobody has a strip of him: a car that was never cleared.
            let named = memory.strip.is_some() || target.callsign.is_some();
            situation.doubt = memory.doubted(lately, situation, named);
        }
        (memory.strips, memory.last_plot) = (situation.strips, target.last_plot);
        memory.velocities = [velocity, memory.velocities[0], memory.velocities[1]];
        if situation.fast.is_some() {
            memory.last_fast = Some(now);
        }
        situation.last_final = memory.last_final;
        situation.last_fast = memory.last_fast;
    }

    /// Runways to whose strip a track is so near that a part of it may be there, one bit each.
    #[inline]
    fn near(&self, target: &Target, length_m: f64) -> u32 {
        let runways = self.layout.runways.iter().take(MOST_RUNWAYS).enumerate();
        runways.fold(0, |near, (r, runway)| {
            let across_m = runway.place_m(target.position_m).1.abs();
            near | u32::from(across_m < runway.hold_m + length_m) << r
        })
    }

    /// Who stands short of a line, without a name and so of unknown length, holds there with his nose [`SHORT_M`] before it.
    fn holds(&self, situation: &Situation, memory: &mut Memory) {
        let parameters = self.parameters;
        let stands = situation.recent_mps < parameters.push_mps
            && self.now.since_s(situation.still_since) >= STANDS_S;
        if !stands {
            return;
        }
        let before_m =
            self.layout.runways.iter().take(MOST_RUNWAYS).enumerate().map(|(r, runway)| {
                let (s, d) = runway.place_m(situation.target.position_m);
                let before_m = d.abs() - runway.hold_at_m(s, d);
                if self.within(r, s, 0.0) && before_m > 0.0 { before_m } else { f64::INFINITY }
            });
        let half_m = before_m.fold(f64::INFINITY, f64::min) - SHORT_M;
        let fits = (UNKNOWN_HALF_M..=MOST_HALF_M).contains(&half_m);
        memory.held_half_m = if fits { half_m } else { UNKNOWN_HALF_M };
    }

    /// Whether a place along a runway is between the ends of its strip, which are no farther out than a holding position on the
    /// axis, as lines beside it short of that by a margin.
    fn within(&self, r: usize, place_m: f64, margin_m: f64) -> bool {
        let runway = &self.layout.runways[r];
        let beyond_m =
            runway.ends_held_m.map(|m| (m - margin_m).min(self.parameters.strip_beyond_m));
        place_m > -beyond_m[0] && place_m < runway.length_m + beyond_m[1]
    }

    /// In whose strips it is; `before`: those of the last scan. Who flies across a runway is over its strip, not in it. One that noise alone
    /// may put over a line, as it stands or creeps, comes in by more than that.
    #[inline]
    fn strips(&self, situation: &Situation, half_m: f64, before: u32) -> u32 {
        let (p, target) = (self.parameters, &situation.target);
        let (nose_m, recent_mps) = (situation.nose_m, situation.recent_mps);
        if situation.near == 0 {
            return 0;
        }
        let too_high = target.altitude_m.is_some_and(|altitude| altitude > p.strip_top_m);
        let (mut strips, mut left) = (0, if too_high { 0 } else { situation.near });
        let creeps_m = match &p.doubt {
            Some(doubt) if recent_mps < p.taxi_mps => doubt.past_line_m,
            _ => 0.0,
        };
        while left != 0 {
            let r = left.trailing_zeros() as usize;
            left &= left - 1;
            let runway = &self.layout.runways[r];
            let (s, d) = runway.place_m(target.position_m);
            if d.abs() >= runway.hold_m + half_m {
                continue;
            }
            let along_mps = runway.along_mps(target.velocity_mps).abs();
            if situation.airborne && along_mps < p.fast_aligned * situation.speed_mps {
                continue;
            }
            let (nose_s, nose_d) = runway.place_m(nose_m);
            let stays = before >> r & 1 == 1;
            let margin_m = p.strip_margin_m + if stays { 0.0 } else { creeps_m };
            let inside = |s: f64, d: f64| {
                d.abs() < runway.hold_at_m(s, d) - margin_m && self.within(r, s, margin_m)
            };
            if inside(s, d) || inside(nose_s, nose_d) {
                strips |= 1 << r;
            }
        }
        strips
    }

    /// Along which runway it rolls, and to which it is on final.
    fn of_runways(
        &self,
        situation: &mut Situation,
        memory: &Memory,
        strip: Option<&Strip>,
        lands: bool,
    ) {
        let p = self.parameters;
        let (target, speed_mps) = (&situation.target, situation.speed_mps);
        let goes_around = goes_around(strip);
        // A jump makes nobody fly.
        let shows = match &p.doubt {
            Some(doubt) => {
                let recent_mps = situation.recent_mps;
                recent_mps == 0.0 || recent_mps + doubt.roll_lag_mps >= p.final_mps
            }
            None => true,
        };
        let mut nearest = f64::INFINITY;
        // On tracks a final that has lasted stays the same one while it goes on: to the runway of one whose path crosses the
        // line of another's, nearest of all for a scan, nobody lands.
        let steady = memory.final_span.filter(|(since, until, _)| {
            p.doubt.is_some() && until.since_s(*since) >= STEADY_FINAL_S
        });
        let cleared = |r: usize, end: usize| {
            strip.is_some_and(|s| {
                let lands = |c: &Clearance| c.kind == ClearanceKind::Land;
                s.on_runway(r).any(|c| lands(c) && c.runway.is_some_and(|r| r.1 == Some(end)))
            })
        };
        let (mut stays, mut its_own) = (None, None);
        for (r, runway) in self.layout.runways.iter().take(MOST_RUNWAYS).enumerate() {
            let (s, d) = runway.place_m(target.position_m);
            let along = runway.along_mps(target.velocity_mps);
            let side_m = 0.5 * runway.width_m + p.runway_side_m;
            let end = usize::from(along < 0.0);
            let from_end = if end == 0 { s } else { runway.length_m - s };
            let distance_m = runway.displaced_m[end] - from_end;
            // Without altitude: who comes is on the ground behind the threshold, not where the runway begins.
            let above = lands && p.doubt.is_some() && distance_m > 0.0;
            if !situation.airborne
                && !above
                && along.abs() >= p.fast_mps.max(p.fast_aligned * speed_mps)
                && d.abs() <= side_m
                && self.within(r, s, 0.0)
                && situation.fast.is_none()
            {
                situation.fast = Some(r);
            }
            if target.class != TargetClass::Vehicle
                && !goes_around
                && speed_mps >= p.final_mps
                && shows
                && along.abs() >= speed_mps * self.cos_aligned
            {
                let wide = p.funnel_m + p.funnel_slope * distance_m;
                let before = (0.0..=p.funnel_length_m).contains(&distance_m);
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
                } else if (cleared(r, end) || steady.is_some_and(|(_, _, runway)| runway == r))
                    && self.within(r, s, 0.0)
                    && d.abs() <= side_m.min(nearest)
                {
                    // Over his own: another whose threshold lies farther on is not his.
                    nearest = d.abs();
                    situation.on_final = None;
                }
            }
        }
        // Where the finals of two runways run into each other, who is cleared to land on one of them is on final to that.
        situation.on_final = its_own.or(stays).or(situation.on_final);
        // Who is fast on one runway comes to no other, whichever line is ahead of him; without altitude he may fly over it to his own.
        if let Some(r) = situation.fast {
            let over = if target.altitude_m.is_none() { its_own } else { None };
            situation.on_final = situation.on_final.filter(|f| f.runway == r).or(over);
        }
    }
}

fn goes_around(strip: Option<&Strip>) -> bool {
    strip.is_some_and(|s| s.kinds.has(ClearanceKind::GoAround))
}
