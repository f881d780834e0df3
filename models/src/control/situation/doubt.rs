//! Which tracks raise no alert by themselves: what a tracker makes beside its targets, and what moved as nothing can.

use super::{Memory, Situation, Surveillance, Target};
use crate::control::parameters::Doubt;
use crate::frames::Vector2;
use crate::time::SimTime;

/// Why a track raises no alert by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubted {
    /// It moved as nothing can: nothing off the runways, and, without a name, nothing at all.
    Jumps,
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
                if !young && !coasts {
                    situation.doubt = None;
                }
            }
        }
    }

    /// Tracks without a name beside or right behind a named one are its doubles.
    pub(super) fn find_doubles(&mut self, doubt: &Doubt) {
        let wanted = |s: &Situation| s.strip.is_none() && s.doubt.is_none();
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
    /// Whether, and why, the track raises nothing by itself.
    pub(super) fn doubted(
        &mut self,
        doubt: &Doubt,
        now: SimTime,
        target: &Target,
        named: bool,
    ) -> Option<Doubted> {
        let change_mps = (target.velocity_mps - self.velocities[2]).norm();
        if change_mps > 3.0 * doubt.jump_mps2 + 5.0 {
            self.jumped = Some(now);
        }
        let jumps = self.jumped.is_some_and(|at| now.since_s(at) <= doubt.jump_s);
        let age_s = now.since_s(self.born);
        let coasts = now.since_s(target.last_plot) > doubt.coasting_s;
        if coasts || age_s < doubt.young_s {
            return Some(Doubted::Weak);
        }
        if named {
            return jumps.then_some(Doubted::Jumps);
        }
        let young = age_s < doubt.unnamed_s;
        let lands =
            self.final_span.is_some_and(|(since, until, _)| until.since_s(since) >= doubt.final_s);
        let flies = !self.was_slow && !lands;
        (young || flies || jumps).then_some(Doubted::Weak)
    }
}
