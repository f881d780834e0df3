//! Pre-departure sequence: when each departure is to leave its stand so that it meets its take-off.

use super::departure_sequence::{
    Departure, Rules, Sequence, SequenceError, best, first_come, in_order,
};

/// A departure as the planner knows it; times in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planned {
    /// Target off-block time (the airline's).
    pub tobt_s: f64,
    /// Expected time from off-block to the runway, s.
    pub exot_s: f64,
    /// Wake, way and slot; `ready_s` is not read.
    pub departure: Departure,
    /// Take-off that stands: it goes within the frozen time, or has left its stand.
    pub frozen_s: Option<f64>,
}

/// Target times of one departure, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Targets {
    /// Start-up approval.
    pub tsat_s: f64,
    /// Take-off.
    pub ttot_s: f64,
}

/// Parameters of the planner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreDeparture {
    /// Separations and slots.
    pub rules: Rules,
    /// Largest shift; `None`: first come.
    pub shift: Option<usize>,
    /// Departures that wait at the hold on purpose, so that the runway never waits.
    pub queue: usize,
}

impl Default for PreDeparture {
    fn default() -> Self {
        Self { rules: Rules::default(), shift: Some(2), queue: 2 }
    }
}

/// TSAT and TTOT of all, by index. Take-offs keep `rules` behind the frozen ones; `TSAT = max(TOBT, TTOT − EXOT − q)`,
/// where q is the time that `queue` departures before it take, so that some wait at the hold: TSAT is never before TOBT.
///
/// # Errors
/// As [`best`].
pub fn targets(flights: &[Planned], planner: &PreDeparture) -> Result<Vec<Targets>, SequenceError> {
    let ready = |f: &Planned| Departure { ready_s: f.tobt_s + f.exot_s, ..f.departure };
    let all: Vec<Departure> = flights.iter().map(ready).collect();
    let order = first_come(&all, &planner.rules);
    let mut frozen: Vec<(f64, usize)> =
        order.iter().filter_map(|i| flights[*i].frozen_s.map(|t| (t, *i))).collect();
    frozen.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let free: Vec<usize> = order.into_iter().filter(|i| flights[*i].frozen_s.is_none()).collect();
    let departures: Vec<Departure> = free.iter().map(|i| all[*i]).collect();
    let before = frozen.last().map(|(t, i)| (*t, flights[*i].departure));
    let sequence: Sequence = match planner.shift {
        Some(k) => best(&departures, Some(k), before, &planner.rules)?,
        None => in_order(&departures, &(0..free.len()).collect::<Vec<_>>(), before, &planner.rules),
    };
    let mut take_offs: Vec<(usize, f64)> = frozen.iter().map(|(t, i)| (*i, *t)).collect();
    take_offs.extend(sequence.order.iter().zip(&sequence.times_s).map(|(at, t)| (free[*at], *t)));
    let mut out = vec![Targets { tsat_s: 0.0, ttot_s: 0.0 }; flights.len()];
    for (place, (i, ttot_s)) in take_offs.iter().enumerate() {
        let wait_s = ttot_s - take_offs[place.saturating_sub(planner.queue)].1;
        let flight = &flights[*i];
        let tsat_s = flight.tobt_s.max(ttot_s - flight.exot_s - wait_s);
        out[*i] = Targets { tsat_s, ttot_s: *ttot_s };
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::super::departure_sequence::Recat;
    use super::*;

    fn planned(tobt_s: f64, recat: Recat, frozen_s: Option<f64>) -> Planned {
        let departure = Departure { ready_s: 0.0, recat, way: None, ctot_s: None };
        Planned { tobt_s, exot_s: 600.0, departure, frozen_s }
    }

    #[test]
    fn nobody_starts_before_the_airline_is_ready_nor_waits_long_at_the_hold() {
        // Twenty mediums that are ready at once, one a minute on the runway.
        let flights: Vec<Planned> = (0..20).map(|_| planned(0.0, Recat::D, None)).collect();
        let planner = PreDeparture::default();
        let found = targets(&flights, &planner).expect("within the bounds");
        let mut by_take_off = found.clone();
        by_take_off.sort_by(|a, b| a.ttot_s.total_cmp(&b.ttot_s));
        for (n, t) in by_take_off.iter().enumerate() {
            assert_eq!(t.ttot_s, 600.0 + 60.0 * n as f64);
            let waits_s = t.ttot_s - (t.tsat_s + 600.0);
            assert!(t.tsat_s >= 0.0 && (0.0..=120.0).contains(&waits_s), "{n}: {t:?}");
        }
    }

    /// Ready first, but with a slot that opens last: four others would have to let it pass by more than two places.
    #[test]
    fn who_has_a_late_slot_keeps_nobody_back() {
        let slot = |ctot_s| Departure { ctot_s, ..planned(0.0, Recat::D, None).departure };
        let late = Planned { departure: slot(Some(1800.0)), ..planned(0.0, Recat::D, None) };
        let others = (1..5).map(|k| planned(30.0 * f64::from(k), Recat::D, None));
        let flights: Vec<Planned> = std::iter::once(late).chain(others).collect();
        let found = targets(&flights, &PreDeparture::default()).expect("within the bounds");
        let delays = found[1..].iter().zip(&flights[1..]).map(|(t, f)| t.ttot_s - f.tobt_s - 600.0);
        assert!(
            found[0].ttot_s == 1500.0 && delays.sum::<f64>() <= 30.0 + 60.0 + 90.0,
            "{found:?}"
        );
    }

    #[test]
    fn what_is_frozen_stays_and_the_others_follow_it() {
        let flights = [planned(0.0, Recat::F, None), planned(0.0, Recat::A, Some(900.0))];
        let found = targets(&flights, &PreDeparture::default()).expect("within the bounds");
        assert_eq!((found[1].ttot_s, found[0].ttot_s), (900.0, 1080.0));
    }
}
