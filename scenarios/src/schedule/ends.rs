//! Which runway ends a demand uses when: those that the scene or the layout names, else by the wind (traffic.md 8.4).

use super::reach::{Ground, default_ends, direction_of, end_named};
use crate::types::TypeRow;
use models::control::runway_choice::{Configuration, WindLimits, choose};
use models::traffic::network::Network;

/// Ends for landings and take-offs, from a time on.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ends {
    pub(super) from_s: f64,
    pub(super) landing: Vec<String>,
    pub(super) leaving: Vec<String>,
}

/// For so long nobody lands when the ends change, s: those who were cleared to the old ones leave (assumed).
const CHANGE_S: f64 = 240.0;
/// Who would have landed then lands within so long after the change, s.
const CAUGHT_UP_S: f64 = 3.0 * CHANGE_S;
/// Who leaves his stand so long before the change goes to the new end, s (assumed).
pub(crate) const TO_THE_END_S: f64 = 720.0;

/// The ends of a run of this duration, the first from 0. They change only where the scene and the layout name none (`named`: landings, take-offs).
pub(super) fn by_the_wind(
    ground: &Ground<'_>,
    named: [&[String]; 2],
    mixes: &[Vec<(&TypeRow, f64)>],
    duration_s: f64,
) -> Vec<Ends> {
    let of = |from_s: f64, at: &Ground<'_>| {
        let [landing, leaving] = match named {
            [a, d] if !a.is_empty() && !d.is_empty() => [Vec::new(), Vec::new()],
            _ => default_ends(at, named, mixes),
        };
        let or = |known: &[String], found| if known.is_empty() { found } else { known.to_vec() };
        Ends { from_s, landing: or(named[0], landing), leaving: or(named[1], leaving) }
    };
    let mut all = vec![of(0.0, ground)];
    if named.iter().all(|n| !n.is_empty()) {
        return all;
    }
    // What turns: the directions of the sides that nobody named.
    let configuration = |ends: &Ends| {
        let sides = [(named[0], &ends.landing), (named[1], &ends.leaving)];
        let free = sides.into_iter().filter(|(named, _)| named.is_empty());
        let directions = free.flat_map(|(_, ends)| ends).filter_map(|e| direction_of(ground, e));
        Configuration { directions: directions.collect() }
    };
    let limits = WindLimits::default();
    let mut since_s = f64::NEG_INFINITY;
    let mut times_s: Vec<f64> = ground.days.iter().skip(1).map(|d| d.0).collect();
    let mut asked = 0;
    while let Some(from_s) = times_s.get(asked).copied().filter(|t| *t < duration_s) {
        asked += 1;
        let Some((_, day)) = ground.days.iter().rev().find(|d| d.0 <= from_s) else { continue };
        let present = &all[all.len() - 1];
        let other = of(from_s, &ground.in_wind(day.wind_mps));
        if (&other.landing, &other.leaving) == (&present.landing, &present.leaving) {
            continue;
        }
        let both = [configuration(present), configuration(&other)];
        let kept = Some((0, from_s - since_s));
        if choose(&both, day.wind_mps, kept, &limits) == Some(1) {
            since_s = from_s;
            all.push(other);
            // What is refused before the ends may turn again is asked for then.
            let again_s = since_s + limits.hold_s;
            let at = times_s.partition_point(|t| *t <= again_s);
            times_s.insert(at, again_s);
        }
    }
    all
}

impl Ends {
    /// Ends of one runway of which landings use one, and take-offs the other: landing, leaving.
    pub(super) fn head_on(&self, network: &Network) -> Vec<[String; 2]> {
        let pairs = self.landing.iter().flat_map(|a| self.leaving.iter().map(move |d| [a, d]));
        let other_end = |[a, d]: &[&String; 2]| {
            let of = |name: &str| end_named(network, name);
            of(a).zip(of(d)).is_some_and(|(a, d)| a.0 == d.0 && a.1 != d.1)
        };
        pairs.filter(other_end).map(|pair| pair.map(String::clone)).collect()
    }

    /// The ends of who lands at a time, and when he does: nobody lands while they change.
    pub(super) fn of_landing(all: &[Self], time_s: f64) -> (&Self, f64) {
        let n = all.iter().rposition(|e| e.from_s <= time_s).unwrap_or(0);
        let behind_s = time_s - all[n].from_s;
        if n == 0 || behind_s >= CAUGHT_UP_S {
            return (&all[n], time_s);
        }
        let share = (CAUGHT_UP_S - CHANGE_S) / CAUGHT_UP_S;
        (&all[n], all[n].from_s + CHANGE_S + behind_s * share)
    }

    /// The ends of who leaves his stand at a time.
    pub(super) fn of_leaving(all: &[Self], time_s: f64) -> &Self {
        let n = all.iter().rposition(|e| e.from_s <= time_s + TO_THE_END_S).unwrap_or(0);
        &all[n]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Landings keep their order, none falls into the change, and who comes late enough is not moved.
    #[test]
    fn nobody_lands_while_the_ends_change() {
        let ends = |from_s: f64, name: &str| Ends {
            from_s,
            landing: vec![name.into()],
            leaving: vec![name.into()],
        };
        let all = [ends(0.0, "09"), ends(1800.0, "27")];
        let mut last_s = f64::NEG_INFINITY;
        for t in 0..3600 {
            let (of, time_s) = Ends::of_landing(&all, f64::from(t));
            assert!(time_s > last_s && time_s >= f64::from(t));
            assert_eq!(of.landing[0], if t < 1800 { "09" } else { "27" });
            assert!(!(1800.0..1800.0 + CHANGE_S).contains(&time_s), "{time_s}");
            if !(1800..2520).contains(&t) {
                assert_eq!(time_s, f64::from(t));
            }
            last_s = time_s;
        }
        for (t, end) in [(0.0, "09"), (1079.0, "09"), (1080.0, "27"), (3000.0, "27")] {
            assert_eq!(Ends::of_leaving(&all, t).leaving[0], end, "{t}");
        }
    }
}
