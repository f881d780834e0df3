//! Which tracks raise no alert by themselves: what a tracker makes beside its targets, and what moved as nothing can.

use super::memory::{Jump, Memory, Named};
use super::{Situation, Surveillance, Target};
use crate::control::clearance::Board;
use crate::control::parameters::{Doubt, Parameters};
use crate::frames::Point2;
use crate::time::SimTime;

/// Why a track raises no alert by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubted {
    /// It moved as nothing can: nothing off the runways, and, without a name, nothing at all.
    Jumps,
    /// It jumps time and again: that it moves at all is not believed.
    Restless,
    /// Too young or coasting; without a name, the double of a named one or flying over: nothing at all.
    Weak,
}

impl Surveillance {
    /// A track that has lost its name to nobody keeps it for a while.
    pub(super) fn keep_names(
        &mut self,
        lately: &Lately<'_>,
        parameters: &Parameters,
        board: &Board,
    ) {
        let (now, doubt) = (lately.now, lately.doubt);
        for index in &self.unnamed {
            let situation = &mut self.situations[*index as usize];
            let memory = &self.memories[situation.memory as usize];
            let Some(named) = memory.had else { continue };
            let at = memory.had_at;
            let free = self.by_strip.get(named.strip as usize).is_some_and(|taken| *taken == 0);
            if free && now.since_s(at) <= doubt.name_s {
                situation.strip = Some(named.strip);
                let Named { callsign, class, arriving, length_m, .. } = named;
                situation.target =
                    Target { callsign, class, arriving, length_m, ..situation.target };
                self.by_strip[named.strip as usize] = *index + 1;
                // Who was sent around or has lifted off flies under his old name, too.
                let strip = board.strips().get(named.strip as usize);
                let flies = strip.is_some_and(|s| s.flies(now, parameters.rolled_s))
                    && situation.speed_mps.max(situation.recent_mps) >= parameters.fast_mps;
                if situation.target.altitude_m.is_none() && flies {
                    situation.airborne = true;
                    situation.fast = None;
                }
                let young = now.since_s(memory.born) < doubt.unnamed_s;
                let coasts = situation.target.last_plot < lately.plot;
                if !young && !coasts && memory.leapt < Some(lately.leap) {
                    situation.doubt = memory.of_a_name(lately, &situation.target);
                }
            }
        }
    }

    /// Tracks without a name beside or right behind a named one are its doubles.
    pub(super) fn find_doubles(&mut self, lately: &Lately<'_>) {
        let doubt = lately.doubt;
        // Who has just been given his name back has one.
        let (situations, memories) = (&mut self.situations, &mut self.memories);
        self.unnamed.retain(|index| {
            let s = &situations[*index as usize];
            s.strip.is_none() && s.target.callsign.is_none() && s.doubt.is_none()
        });
        if self.unnamed.is_empty() {
            return;
        }
        self.cells.clear();
        for index in &self.unnamed {
            self.cells.add(situations[*index as usize].target.position_m);
        }
        for index in 0..situations.len() {
            let named = &situations[index];
            if named.strip.is_none() {
                continue;
            }
            let at_m = named.target.position_m;
            // The double of one who takes off or goes around falls behind him.
            let flies = named.airborne || named.fast.is_some();
            let reach_m = doubt.double_m + doubt.double_s * named.speed_mps;
            self.cells.near(at_m, reach_m, |near| {
                let other = &mut situations[self.unnamed[near] as usize];
                let double = (at_m - other.target.position_m).norm() < reach_m;
                if double {
                    other.doubt = Some(Doubted::Weak);
                    if flies {
                        let memory = &mut memories[other.memory as usize];
                        (memory.beside, memory.troubled) = (Some(lately.now), lately.now);
                    }
                }
                double
            });
        }
    }
}

/// What is doubted, and the times of a scan from which on something was lately.
pub(super) struct Lately<'a> {
    now: SimTime,
    doubt: &'a Doubt,
    plot: SimTime,
    found_again: SimTime,
    jump: SimTime,
    restless: SimTime,
    leap: SimTime,
    beside: SimTime,
    /// Nothing that is doubted for a while was before this.
    trouble: SimTime,
}

impl<'a> Lately<'a> {
    pub(super) fn new(now: SimTime, doubt: &'a Doubt) -> Self {
        let [plot, found_again] = [doubt.coasting_s, doubt.young_s].map(|s| now.back_s(s));
        let [jump, restless] = [doubt.jump_s, doubt.restless_s].map(|s| now.back_s(s));
        let [leap, beside] = [doubt.leap_s, doubt.beside_s].map(|s| now.back_s(s));
        let Doubt { unnamed_s, young_s, jump_s, restless_s, leap_s, taken_over_s, .. } = *doubt;
        let longest_s =
            [unnamed_s, young_s, jump_s, restless_s, leap_s, taken_over_s, doubt.beside_s]
                .into_iter()
                .fold(0.0, f64::max);
        let trouble = now.back_s(longest_s);
        Self { now, doubt, plot, found_again, jump, restless, leap, beside, trouble }
    }
}

impl Memory {
    /// Whether this place can follow the last ones: where the mean velocity of three seconds leads, within
    /// [`Doubt::step_m`] and a share of the way of a second. And whether there is a plot again after it had coasted.
    pub(super) fn watch_steps(&mut self, lately: &Lately<'_>, target: &Target) {
        let (now, doubt) = (lately.now, lately.doubt);
        self.leaps = false;
        if target.last_plot.since_s(self.last_plot) > doubt.coasting_s {
            (self.found_again, self.troubled) = (Some(now), now);
        }
        if self.places.kept < 4 {
            return;
        }
        let ((last, last_m), (first, first_m)) = (self.places.latest(1), self.places.latest(4));
        let (since_s, over_s) = (now.since_s(last), last.since_s(first));
        if !(0.1..=3.5).contains(&since_s) || !(0.3..=6.0).contains(&over_s) {
            return;
        }
        let mean_mps = (last_m - first_m) / over_s;
        let moved_m = target.position_m - last_m;
        let off_m = (moved_m - mean_mps * since_s).norm();
        if off_m <= doubt.step_m && off_m <= doubt.leap_steps * doubt.step_m {
            self.has_gone_on(now, target.position_m);
            return;
        }
        let room_m = doubt.step_m + doubt.step_s * mean_mps.norm();
        if off_m > room_m {
            let oldest = self.places.latest(usize::from(self.places.kept)).0;
            if self.jumped.is_none_or(|at| at <= oldest) {
                self.before_jumps = (last, last_m);
            }
            // What goes on as one jump is seen for as long as places of before it are looked at.
            if self.jumped.is_some_and(|at| (JUMP_SEEN_S..=AGAIN_S).contains(&now.since_s(at))) {
                self.restless = Some(now);
            }
            let off = moved_m - mean_mps * since_s;
            // What comes back was noise, and for as long as it is in the mean velocity nothing is known of the next one.
            let calm = self.jumped.is_none_or(|at| now.since_s(at) > JUMP_SEEN_S);
            self.goes_on = match self.goes_on {
                Some(jump) => Some(jump).filter(|jump| jump.along.dot(&off) > 0.0),
                None => calm.then(|| Jump {
                    from: last,
                    from_m: last_m,
                    mean_mps,
                    at: now,
                    along: off / off_m,
                    off_m,
                }),
            };
            (self.jumped, self.troubled) = (Some(now), now);
            self.jumps = (self.jumps.0 + moved_m, self.jumps.1 + since_s);
        }
        self.leaps = off_m > doubt.leap_steps * room_m;
        self.has_gone_on(now, target.position_m);
    }

    /// Who goes on from a jump as he jumped, farther and farther from where he would be without it, has set off, or gains or loses speed: a
    /// track that has settled comes after by a jump. Noise comes back.
    fn has_gone_on(&mut self, now: SimTime, position_m: Point2<f64>) {
        let Some(jump) = self.goes_on else { return };
        let since_s = now.since_s(jump.from);
        if since_s > GIVES_UP_S {
            self.goes_on = None;
        } else if now.since_s(jump.at) >= GOES_ON_S {
            let off_m = jump.off(position_m, since_s).dot(&jump.along);
            if off_m >= jump.off_m + GOES_ON_MPS * now.since_s(jump.at) {
                self.went_on = Some(now);
            }
        }
    }

    /// Whether, and why, the track raises nothing by itself.
    pub(super) fn doubted(
        &mut self,
        lately: &Lately<'_>,
        situation: &Situation,
        named: bool,
    ) -> Option<Doubted> {
        let (now, doubt) = (lately.now, lately.doubt);
        let Situation { target, strips, mean_mps, .. } = situation;
        let change_mps = (target.velocity_mps - self.velocities[2]).norm();
        if change_mps > 3.0 * doubt.jump_mps2 + doubt.jump_mps {
            (self.jumped, self.troubled) = (Some(now), now);
        }
        // A leap of one who stays in the strips in which he was makes no difference to who is on a runway.
        let stays = *strips != 0 && *strips == self.strips;
        if (self.leaps || change_mps > 3.0 * doubt.leap_mps2 + doubt.leap_mps) && !stays {
            (self.leapt, self.troubled) = (Some(now), now);
        }
        // Most have had no trouble for long.
        if self.troubled < lately.trouble && self.was_slow && target.last_plot >= lately.plot {
            return None;
        }
        let leaps = self.leapt >= Some(lately.leap);
        let age_s = now.since_s(self.born);
        let coasts = target.last_plot < lately.plot;
        let new_name = named && self.taken_over && now.since_s(self.named) < doubt.taken_over_s;
        let again = self.found_again >= Some(lately.found_again);
        if coasts || age_s < doubt.young_s || again || new_name || leaps {
            return Some(Doubted::Weak);
        }
        if named {
            return self.of_a_name(lately, target);
        }
        let young = age_s < doubt.unnamed_s;
        let went_on = self.went_on >= self.jumped && target.velocity_mps.norm() < TAXIES_MPS;
        let jumps = self.jumped >= Some(lately.restless) && !went_on;
        // The echo of one who is far out on his final, nearer by the radar's unambiguous range, is as fast as he is there.
        let lands = (1e-9..=doubt.lands_mps).contains(mean_mps);
        let echo = !self.was_slow && !lands;
        let parted = self.beside >= Some(lately.beside);
        (young || self.flies(doubt) || jumps || echo || parted).then_some(Doubted::Weak)
    }

    /// Whether it was never slower than a roll, and has not come by a final.
    fn flies(&self, doubt: &Doubt) -> bool {
        let lands = self.final_from_s >= doubt.from_s
            && self.final_span.is_some_and(|(s, until, _)| until.since_s(s) >= doubt.final_s);
        !self.was_slow && !lands
    }

    /// What is doubted of one who has a name or just had it. A name may have been put on the second echo of one who comes,
    /// kilometres short of him: nothing taxies as fast that never was slower.
    fn of_a_name(&self, lately: &Lately<'_>, target: &Target) -> Option<Doubted> {
        let echo = self.flies(lately.doubt) && target.velocity_mps.norm() > ECHO_MPS;
        if self.jumped >= Some(lately.jump) || echo {
            return Some(Doubted::Jumps);
        }
        (self.restless >= Some(lately.restless)).then_some(Doubted::Restless)
    }
}

/// Where the nose of a body is that has its middle at a place and follows a way: half its length ahead along it. `None`
/// beyond [`OFF_WAY_M`] of the way, and where it ends before.
pub(super) fn nose_on(
    way_m: &[Point2<f64>],
    middle_m: Point2<f64>,
    half_m: f64,
) -> Option<Point2<f64>> {
    let (mut best, mut found) = (OFF_WAY_M, None);
    for (i, pair) in way_m.windows(2).enumerate() {
        let along = pair[1] - pair[0];
        let share = (middle_m - pair[0]).dot(&along) / along.norm_squared().max(1e-9);
        let foot_m = pair[0] + along * share.clamp(0.0, 1.0);
        let off_m = (middle_m - foot_m).norm();
        if off_m < best {
            (best, found) = (off_m, Some((i, foot_m)));
        }
    }
    let (i, foot_m) = found?;
    // The first point of the way that is half a length away, as the crow flies: a body is stiff.
    let mut from_m = foot_m;
    for to_m in &way_m[i + 1..] {
        let (here, there) = ((from_m - foot_m).norm(), (to_m - foot_m).norm());
        if there >= half_m && there > here {
            let share = (half_m - here) / (there - here);
            let ahead_m = from_m + (to_m - from_m) * share - foot_m;
            let length_m = ahead_m.norm();
            return (length_m > 0.0).then(|| middle_m + ahead_m * (half_m / length_m));
        }
        from_m = *to_m;
    }
    None
}

/// A jump is seen in scans so long after each other, s, and another one within this is one time and again (assumed).
const JUMP_SEEN_S: f64 = 4.5;
const AGAIN_S: f64 = 30.0;

/// Who has jumped goes on for so long, s, and by so much faster than before, m/s, to have moved (assumed); later it is not looked at.
const GOES_ON_S: f64 = 2.0;
const GOES_ON_MPS: f64 = 1.5;
const GIVES_UP_S: f64 = 6.0;
/// Slower than this is who taxies, m/s (assumed): of a roll, jumps are doubted as before.
const TAXIES_MPS: f64 = 15.0;

/// What was never slower than this is no taxiing, m/s (assumed).
const ECHO_MPS: f64 = 40.0;

/// One farther from its way than this does not follow it, m (assumed).
const OFF_WAY_M: f64 = 12.0;
