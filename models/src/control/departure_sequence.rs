//! The order of departures of one runway: first come, a limited shift from it, or the best of all.
//!
//! Minimises, in this order, the flights that miss their slot, the sum of the delays, and the last take-off.
//! Each takes off as early as it may behind the one before, so a partial sequence is a set, its last flight,
//! and (late, delay, time); of those with the same set and last flight only the undominated are kept. That is
//! exact, because a later time or a larger delay never helps afterwards.

pub use crate::wake::Recat;
use crate::wake::icao_departure_gap_s;
use std::collections::BTreeMap;

/// One departure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Departure {
    /// Earliest at the runway, s.
    pub ready_s: f64,
    /// Wake category.
    pub recat: Recat,
    /// Departure way, by number; the same way takes 90 s.
    pub way: Option<u32>,
    /// Slot, s: from 300 s before to 600 s after.
    pub ctot_s: Option<f64>,
}

/// What has to be kept between departures; all in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Wake as ICAO separates it, by the category that stands for that of RECAT-EU; else RECAT-EU.
    pub icao: bool,
    /// On the same departure way.
    pub same_way_s: f64,
    /// Slot opens so long before.
    pub slot_before_s: f64,
    /// Slot closes so long after.
    pub slot_after_s: f64,
}

impl Default for Rules {
    fn default() -> Self {
        Self { icao: false, same_way_s: 90.0, slot_before_s: 300.0, slot_after_s: 600.0 }
    }
}

impl Rules {
    fn gap_s(&self, first: &Departure, then: &Departure) -> f64 {
        let same = first.way.is_some() && first.way == then.way;
        let wake_s = match self.icao {
            true => icao_departure_gap_s(first.recat.icao(), then.recat.icao()),
            false => first.recat.departure_gap_s(then.recat),
        };
        wake_s.max(if same { self.same_way_s } else { 0.0 })
    }

    fn take_off_s(&self, before: Option<(f64, &Departure)>, next: &Departure) -> f64 {
        let slot = next.ctot_s.map_or(f64::NEG_INFINITY, |ctot| ctot - self.slot_before_s);
        let behind = before.map_or(f64::NEG_INFINITY, |(at, first)| at + self.gap_s(first, next));
        next.ready_s.max(slot).max(behind)
    }
}

/// A sequence and what it costs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sequence {
    /// Flights in the order of their take-offs, by index.
    pub order: Vec<usize>,
    /// Take-off of each in that order, s.
    pub times_s: Vec<f64>,
    /// Flights that miss their slot.
    pub late: u32,
    /// Sum of take-off minus ready, s.
    pub delay_s: f64,
}

impl Sequence {
    /// Last take-off, s; 0 of an empty sequence.
    #[must_use]
    pub fn makespan_s(&self) -> f64 {
        self.times_s.last().copied().unwrap_or(0.0)
    }
}

/// The sequence that keeps an order.
#[must_use]
pub fn in_order(
    flights: &[Departure],
    order: &[usize],
    before: Option<(f64, Departure)>,
    rules: &Rules,
) -> Sequence {
    let mut sequence = Sequence::default();
    let mut last = before;
    for index in order {
        let flight = flights[*index];
        let at = rules.take_off_s(last.as_ref().map(|(t, f)| (*t, f)), &flight);
        sequence.order.push(*index);
        sequence.times_s.push(at);
        sequence.late += u32::from(flight.ctot_s.is_some_and(|c| at > c + rules.slot_after_s));
        sequence.delay_s += at - flight.ready_s;
        last = Some((at, flight));
    }
    sequence
}

/// Largest shift, and most flights of the best of all: the sets of a step are bits of a word.
pub const MOST_SHIFT: usize = 15;
/// Partial sequences that one step keeps at most; beyond, the worst are left out and the result is not exact.
const MOST_KEPT: usize = 200_000;

/// Why there is no sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SequenceError {
    /// More than can be searched.
    #[error("a shift of {0} places is more than {MOST_SHIFT}: name a smaller one")]
    Shift(usize),
}

#[derive(Clone, Copy)]
struct Label {
    late: u32,
    delay_s: f64,
    at_s: f64,
    /// Places between where all so far are and where they were, in sum.
    moved: u32,
    last: u16,
    parent: u32,
}

/// The flights in the order in which each could go with the runway to itself: who is ready early but whose slot opens late has not come first. A
/// shift counted from this order leaves next to nothing to the best of all; counted from when flights are ready it costs those with a slot much.
#[must_use]
pub fn first_come(flights: &[Departure], rules: &Rules) -> Vec<usize> {
    let mut order: Vec<usize> = (0..flights.len()).collect();
    let earliest_s = |i: usize| rules.take_off_s(None, &flights[i]);
    order.sort_by(|a, b| earliest_s(*a).total_cmp(&earliest_s(*b)).then(a.cmp(b)));
    order
}

/// The best sequence in which no flight is more than `most_shift` places from its place in `flights` (`None`: anywhere); see [`first_come`].
/// `before`: the take-off before the first. Of sequences that are equal to the microsecond that in which fewest change places.
///
/// # Errors
/// If the shift is more than [`MOST_SHIFT`].
pub fn best(
    flights: &[Departure],
    most_shift: Option<usize>,
    before: Option<(f64, Departure)>,
    rules: &Rules,
) -> Result<Sequence, SequenceError> {
    let n = flights.len();
    if n == 0 {
        return Ok(Sequence::default());
    }
    let k = most_shift.unwrap_or(n - 1).min(n - 1);
    if k > MOST_SHIFT {
        return Err(SequenceError::Shift(k));
    }
    // Bit b of a set: the flight with index place − k + b has its place.
    let mut layers: Vec<Vec<Label>> = Vec::with_capacity(n);
    let mut states: BTreeMap<u64, Vec<u32>> = BTreeMap::new();
    let first = (1u64 << k) - 1;
    states.insert(first, Vec::new());
    for place in 0..n {
        let mut layer: Vec<Label> = Vec::new();
        // By set and last flight: the undominated.
        let mut found: BTreeMap<(u64, u16), Vec<Label>> = BTreeMap::new();
        for (set, labels) in &states {
            // The flight that leaves the window must have its place.
            let must = (set & 1 == 0).then_some(0);
            for bit in must.map_or(0..2 * k + 1, |b| b..b + 1) {
                let index = (place + bit).wrapping_sub(k);
                if index >= n || set >> bit & 1 == 1 {
                    continue;
                }
                let flight = &flights[index];
                let mut extend = |from: Option<(u32, &Label)>| {
                    let last = match from {
                        Some((_, l)) => Some((l.at_s, &flights[usize::from(l.last)])),
                        None => before.as_ref().map(|(t, f)| (*t, f)),
                    };
                    let at_s = rules.take_off_s(last, flight);
                    let late =
                        u32::from(flight.ctot_s.is_some_and(|c| at_s > c + rules.slot_after_s));
                    let (late_before, delay_before, moved_before) =
                        from.map_or((0, 0.0, 0), |(_, l)| (l.late, l.delay_s, l.moved));
                    let label = Label {
                        late: late_before + late,
                        delay_s: delay_before + (at_s - flight.ready_s),
                        at_s,
                        moved: moved_before + place.abs_diff(index) as u32,
                        last: index as u16,
                        parent: from.map_or(u32::MAX, |(i, _)| i),
                    };
                    let key = ((set | 1 << bit) >> 1, index as u16);
                    keep(found.entry(key).or_default(), label);
                };
                match layers.last() {
                    None => extend(None),
                    Some(before) => {
                        for i in labels {
                            extend(Some((*i, &before[*i as usize])));
                        }
                    }
                }
            }
        }
        let mut all: Vec<(u64, Label)> = found
            .into_iter()
            .flat_map(|((set, _), ls)| ls.into_iter().map(move |l| (set, l)))
            .collect();
        if all.len() > MOST_KEPT {
            all.sort_by(|a, b| order(&a.1, &b.1));
            all.truncate(MOST_KEPT);
        }
        states = BTreeMap::new();
        for (set, label) in all {
            states.entry(set).or_default().push(layer.len() as u32);
            layer.push(label);
        }
        layers.push(layer);
    }
    let last = &layers[n - 1];
    let Some(mut at) = (0..last.len()).min_by(|a, b| order(&last[*a], &last[*b])) else {
        return Ok(Sequence::default());
    };
    let mut indices = Vec::with_capacity(n);
    for layer in layers.iter().rev() {
        indices.push(usize::from(layer[at].last));
        at = layer[at].parent as usize;
    }
    indices.reverse();
    Ok(in_order(flights, &indices, before, rules))
}

fn order(a: &Label, b: &Label) -> std::cmp::Ordering {
    a.late
        .cmp(&b.late)
        .then(whole_us(a.delay_s).total_cmp(&whole_us(b.delay_s)))
        .then(whole_us(a.at_s).total_cmp(&whole_us(b.at_s)))
        .then(a.moved.cmp(&b.moved))
}

/// Sums in another order differ in their last bits: what is equal to the microsecond is equal.
fn whole_us(s: f64) -> f64 {
    (s * 1e6).round()
}

/// Adds a label unless one that is nowhere worse is there; removes those that it beats.
fn keep(labels: &mut Vec<Label>, new: Label) {
    // Of equal ones that with the fewer moved: nobody changes places for nothing.
    let beats = |a: &Label, b: &Label| {
        let [(da, ta), (db, tb)] = [a, b].map(|l| (whole_us(l.delay_s), whole_us(l.at_s)));
        let equal = a.late == b.late && da == db && ta == tb;
        a.late <= b.late && da <= db && ta <= tb && (!equal || a.moved <= b.moved)
    };
    if labels.iter().any(|l| beats(l, &new)) {
        return;
    }
    labels.retain(|l| !beats(&new, l));
    labels.push(new);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn departures() -> impl Strategy<Value = Vec<Departure>> {
        let letter = prop_oneof![Just("A"), Just("B"), Just("C"), Just("D"), Just("E"), Just("F")];
        let slot = proptest::option::weighted(0.3, 0.0..900.0f64);
        let one =
            (0.0..400.0f64, letter, 0u32..3, slot).prop_map(|(ready_s, letter, way, ctot_s)| {
                Departure {
                    ready_s,
                    recat: Recat::of(letter).expect("a letter"),
                    way: Some(way),
                    ctot_s,
                }
            });
        proptest::collection::vec(one, 1..=6).prop_map(|mut all| {
            all.sort_by(|a, b| a.ready_s.total_cmp(&b.ready_s));
            all
        })
    }

    /// All orders in which nobody is more than `k` places away, one by one.
    fn all_orders(n: usize, k: usize, begun: &mut Vec<usize>, each: &mut dyn FnMut(&[usize])) {
        if begun.len() == n {
            return each(begun);
        }
        for i in 0..n {
            if !begun.contains(&i) && begun.len().abs_diff(i) <= k {
                begun.push(i);
                all_orders(n, k, begun, each);
                begun.pop();
            }
        }
    }

    proptest! {
        #[test]
        fn it_is_the_best_of_all_orders(flights in departures(), k in 0usize..6, behind in proptest::option::of(0.0..300.0f64)) {
            let rules = Rules::default();
            let before = behind.map(|t| (t, flights[0]));
            let found = best(&flights, Some(k), before, &rules).expect("within the bounds");
            let mut least: Option<(u32, f64, f64)> = None;
            all_orders(flights.len(), k, &mut Vec::new(), &mut |order| {
                let s = in_order(&flights, order, before, &rules);
                let cost = (s.late, whole_us(s.delay_s), whole_us(s.makespan_s()));
                if least.is_none_or(|l| cost < l) {
                    least = Some(cost);
                }
            });
            let least = least.expect("the order of coming is one");
            prop_assert_eq!(found.late, least.0);
            // Compared in whole microseconds, as sums in another order differ in their last bits.
            prop_assert!((1e6 * found.delay_s - least.1).abs() < 2.0);
            prop_assert!((1e6 * found.makespan_s() - least.2).abs() < 2.0);
        }
    }

    /// Equal ones keep their order: any order of them costs the same.
    #[test]
    fn nobody_changes_places_for_nothing() {
        let flight = |ready_s| Departure { ready_s, recat: Recat::D, way: Some(0), ctot_s: None };
        for ready_s in [0.0, 410.0, 7.3] {
            let flights = [flight(ready_s); 9];
            for k in 1..5 {
                let found = best(&flights, Some(k), None, &Rules::default());
                assert_eq!(found.expect("within").order, (0..9).collect::<Vec<_>>(), "{k}");
            }
        }
    }

    #[test]
    fn sixty_departures_are_sequenced_with_a_shift_of_two() {
        let flights: Vec<Departure> = (0..60)
            .map(|i| Departure {
                ready_s: 70.0 * f64::from(i),
                recat: [Recat::B, Recat::D, Recat::F, Recat::D][i as usize % 4],
                way: Some(i % 3),
                ctot_s: None,
            })
            .collect();
        let rules = Rules::default();
        let first = in_order(&flights, &(0..60).collect::<Vec<_>>(), None, &rules);
        let shifted = best(&flights, Some(2), None, &rules).expect("within the bounds");
        assert!(shifted.delay_s < 0.9 * first.delay_s, "{} {}", shifted.delay_s, first.delay_s);
        assert_eq!(best(&flights, None, None, &rules), Err(SequenceError::Shift(59)));
    }
}
