//! Which tracks raise no alert by themselves: what a tracker makes beside its targets, and what moved as nothing can.

use super::memory::{KEPT, Memory};
use super::{Situation, Surveillance, Target};
use crate::control::parameters::Doubt;
use crate::frames::Vector2;
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
    pub(super) fn keep_names(&mut self, now: SimTime, doubt: &Doubt) {
        for index in 0..self.situations.len() {
            let situation = &mut self.situations[index];
            let place = usize::from(self.places[usize::from(situation.target.number)]) - 1;
            let memory = &mut self.memories[place];
            if let Some(strip) = situation.strip {
                memory.had = Some((strip, situation.target, now));
                continue;
            }
            let Some((strip, named, at)) =
                memory.had.filter(|_| situation.target.callsign.is_none())
            else {
                continue;
            };
            let free = self.by_strip.get(strip as usize).is_some_and(|taken| *taken == 0);
            if free && now.since_s(at) <= doubt.name_s {
                situation.strip = Some(strip);
                let Target { callsign, class, arriving, length_m, .. } = named;
                situation.target =
                    Target { callsign, class, arriving, length_m, ..situation.target };
                self.by_strip[strip as usize] = index as u32 + 1;
                let young = now.since_s(memory.born) < doubt.unnamed_s;
                let coasts = now.since_s(situation.target.last_plot) > doubt.coasting_s;
                if !young && !coasts && !memory.within(memory.leapt, now, doubt.leap_s) {
                    situation.doubt = memory.of_a_name(doubt, now, &situation.target);
                }
            }
        }
    }

    /// Tracks without a name beside or right behind a named one are its doubles.
    pub(super) fn find_doubles(&mut self, doubt: &Doubt) {
        let wanted =
            |s: &Situation| s.strip.is_none() && s.target.callsign.is_none() && s.doubt.is_none();
        if !self.situations.iter().any(wanted) {
            return;
        }
        let named = self.situations.iter().filter(|s| s.strip.is_some());
        let mut named: Vec<(Vector2<f64>, f64)> = named
            .map(|s| (s.target.position_m, doubt.double_m + doubt.double_s * s.speed_mps))
            .collect();
        named.sort_by(|a, b| a.0.x.total_cmp(&b.0.x).then(a.0.y.total_cmp(&b.0.y)));
        let most_m = named.iter().map(|n| n.1).fold(0.0, f64::max);
        for situation in self.situations.iter_mut().filter(|s| wanted(s)) {
            let at_m = situation.target.position_m;
            let from = named.partition_point(|n| n.0.x < at_m.x - most_m);
            let near = named[from..].iter().take_while(|n| n.0.x <= at_m.x + most_m);
            if near.into_iter().any(|(p, reach_m)| (p - at_m).norm() < *reach_m) {
                situation.doubt = Some(Doubted::Weak);
            }
        }
    }
}

impl Memory {
    fn within(&self, at: Option<SimTime>, now: SimTime, seconds: f64) -> bool {
        at.is_some_and(|at| now.since_s(at) <= seconds)
    }

    /// Whether this place can follow the last ones: where the mean velocity of three seconds leads, within
    /// [`Doubt::step_m`] and a share of the way of a second. And whether there is a plot again after it had coasted.
    pub(super) fn watch_steps(&mut self, doubt: &Doubt, now: SimTime, target: &Target) {
        self.leaps = false;
        if target.last_plot.since_s(self.last_plot) > doubt.coasting_s {
            self.found_again = Some(now);
        }
        if self.kept < 4 {
            return;
        }
        let back = |n: usize| self.places[(self.next + 2 * KEPT - n) % KEPT];
        let (last, first) = (back(1), back(4));
        let (since_s, over_s) = (now.since_s(last.at), last.at.since_s(first.at));
        if !(0.1..=3.5).contains(&since_s) || !(0.3..=6.0).contains(&over_s) {
            return;
        }
        let mean_mps = (last.place_m - first.place_m) / over_s;
        let moved_m = target.position_m - last.place_m;
        let off_m = (moved_m - mean_mps * since_s).norm();
        let room_m = doubt.step_m + doubt.step_s * mean_mps.norm();
        if off_m > room_m {
            let lately = self.jumped.is_some_and(|at| at > back(self.kept).at);
            if !lately {
                self.before_jumps = (last.at, last.place_m);
            }
            // What goes on as one jump is seen for as long as places of before it are looked at.
            if self.jumped.is_some_and(|at| (JUMP_SEEN_S..=AGAIN_S).contains(&now.since_s(at))) {
                self.restless = Some(now);
            }
            self.jumped = Some(now);
            self.jumps = (self.jumps.0 + moved_m, self.jumps.1 + since_s);
        }
        self.leaps = off_m > doubt.leap_steps * room_m;
    }

    /// Whether, and why, the track raises nothing by itself.
    pub(super) fn doubted(
        &mut self,
        doubt: &Doubt,
        now: SimTime,
        situation: &Situation,
        named: bool,
    ) -> Option<Doubted> {
        let target = &situation.target;
        let change_mps = (target.velocity_mps - self.velocities[2]).norm();
        if change_mps > 3.0 * doubt.jump_mps2 + doubt.jump_mps {
            self.jumped = Some(now);
        }
        // A leap of one who stays in the strips in which he was makes no difference to who is on a runway.
        let stays = situation.strips != 0 && situation.strips == self.strips;
        if (self.leaps || change_mps > 3.0 * doubt.leap_mps2 + doubt.leap_mps) && !stays {
            self.leapt = Some(now);
        }
        let leaps = self.within(self.leapt, now, doubt.leap_s);
        let age_s = now.since_s(self.born);
        let coasts = now.since_s(target.last_plot) > doubt.coasting_s;
        let new_name = named && self.taken_over && now.since_s(self.named) < doubt.taken_over_s;
        let again = self.within(self.found_again, now, doubt.young_s);
        if coasts || age_s < doubt.young_s || again || new_name || leaps {
            return Some(Doubted::Weak);
        }
        if named {
            return self.of_a_name(doubt, now, target);
        }
        let young = age_s < doubt.unnamed_s;
        let jumps = self.within(self.jumped, now, doubt.restless_s);
        (young || self.flies(doubt) || jumps).then_some(Doubted::Weak)
    }

    /// Whether it was never slower than a roll, and has not come by a final.
    fn flies(&self, doubt: &Doubt) -> bool {
        let lands = self.final_from_s >= doubt.from_s
            && self.final_span.is_some_and(|(s, until, _)| until.since_s(s) >= doubt.final_s);
        !self.was_slow && !lands
    }

    /// What is doubted of one who has a name or just had it. A name may have been put on the second echo of one who comes,
    /// kilometres short of him: nothing taxies as fast that never was slower.
    fn of_a_name(&self, doubt: &Doubt, now: SimTime, target: &Target) -> Option<Doubted> {
        let echo = self.flies(doubt) && target.velocity_mps.norm() > ECHO_MPS;
        if self.within(self.jumped, now, doubt.jump_s) || echo {
            return Some(Doubted::Jumps);
        }
        self.within(self.restless, now, doubt.restless_s).then_some(Doubted::Restless)
    }
}

/// Where the nose of a body is that has its middle at a place and follows a way: half its length ahead along it. `None`
/// beyond [`OFF_WAY_M`] of the way, and where it ends before.
pub(super) fn nose_on(
    way_m: &[Vector2<f64>],
    middle_m: Vector2<f64>,
    half_m: f64,
) -> Option<Vector2<f64>> {
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

/// What was never slower than this is no taxiing, m/s (assumed).
const ECHO_MPS: f64 = 40.0;

/// One farther from its way than this does not follow it, m (assumed).
const OFF_WAY_M: f64 = 12.0;
