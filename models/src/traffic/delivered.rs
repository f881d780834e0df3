//! What traffic was given: separations on runways against those of wake and runway (traffic.md 3.6), delays against the times that
//! were wanted, slots kept (traffic.md 10).

use super::core::{Core, Flight, Measures};
use super::runway_roll::{NAUTICAL_MILE_M, approach_airspeed_mps};

/// Pairs farther apart than what they need and this are not of one stream, s.
const STREAM_S: f64 = 300.0;
/// A time so much shorter than what is needed is a violation, s.
const SLACK_S: f64 = 1.0;
/// A slot is kept from so long before its time to so long after it, s (traffic.md 4.3).
const SLOT_S: [f64; 2] = [-300.0, 600.0];
/// A start-up approval holds for so long before and after its time, s (traffic.md 4.3).
const START_UP_S: f64 = 300.0;

/// Of one kind of movement on one runway.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Separations {
    /// Beyond what was needed, s, in the mean over pairs of one stream.
    pub(super) mean_surplus_s: f64,
    /// Pairs that had less than they needed.
    pub(super) violations: usize,
}

/// Separations of movements at times, s, each needing so much behind the one before; `None` where no two follow each other.
fn separations(
    mut movements: Vec<(f64, usize)>,
    need_s: impl Fn(usize, usize) -> f64,
) -> Option<Separations> {
    movements.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let surplus_s = movements.windows(2).map(|pair| {
        let [(before_s, first), (after_s, then)] = [pair[0], pair[1]];
        after_s - before_s - need_s(first, then)
    });
    let of_stream: Vec<f64> = surplus_s.filter(|s| *s < STREAM_S).collect();
    (!of_stream.is_empty()).then(|| Separations {
        mean_surplus_s: of_stream.iter().sum::<f64>() / of_stream.len() as f64,
        violations: of_stream.iter().filter(|s| **s < -SLACK_S).count(),
    })
}

/// Of take-offs from a runway: from airborne to airborne.
pub(super) fn of_take_offs(core: &Core, flights: &[usize]) -> Option<Separations> {
    let at = flights.iter().filter_map(|f| Some((core.measures(*f).atot_s?, *f)));
    let flight = |f: usize| &core.flights()[f];
    separations(at.collect(), |a, b| flight(a).wake.departure_gap_s(flight(b).wake))
}

/// Of landings on a runway end: the time that the second takes over the distance that it needs, in the head wind of its touchdown.
pub(super) fn of_landings(core: &Core, flights: &[usize]) -> Option<Separations> {
    let at = flights.iter().filter_map(|f| Some((core.measures(*f).aldt_s?, *f)));
    let flight = |f: usize| &core.flights()[f];
    separations(at.collect(), |a, b| {
        let apart_nm = flight(a).wake.landing_gap_nm(flight(b).wake);
        last_miles_s(flight(b).landing.0, core.measures(b).head_mps, apart_nm)
    })
}

/// Time over the last miles before the threshold, s, by hundredths of a mile; infinite against a wind that cannot be flown.
fn last_miles_s(touchdown_mps: f64, head_mps: f64, from_nm: f64) -> f64 {
    let step_m = 0.01 * NAUTICAL_MILE_M;
    let steps = (100.0 * from_nm).round() as u32;
    let slowness = |k: u32| {
        let mps = approach_airspeed_mps((f64::from(k) + 0.5) * step_m, touchdown_mps) - head_mps;
        if mps > 0.0 { 1.0 / mps } else { f64::INFINITY }
    };
    (0..steps).map(slowness).sum::<f64>() * step_m
}

/// Take-off after the time at which it could have been: target off-block and the way driven alone, or, later, the begin of its slot, s.
pub(super) fn take_off_delay_s(flight: &Flight, measures: &Measures) -> Option<f64> {
    let (atot_s, _) = (measures.atot_s?, measures.taxi_s?);
    let alone_s = flight.time_s + measures.unhindered_s;
    let opens_s = flight.ctot_s.map_or(f64::NEG_INFINITY, |ctot_s| ctot_s + SLOT_S[0]);
    Some(atot_s - alone_s.max(opens_s))
}

/// Whether a take-off was within its slot; `None` without one, or before it was.
pub(super) fn keeps_slot(flight: &Flight, measures: &Measures) -> Option<bool> {
    let late_s = measures.atot_s? - flight.ctot_s?;
    Some((SLOT_S[0]..=SLOT_S[1]).contains(&late_s))
}

/// Whether a departure left its stand within its start-up approval; `None` where there is none, or before it did.
pub(super) fn keeps_start_up(core: &Core, flight: usize) -> Option<bool> {
    let late_s = core.measures(flight).aobt_s? - core.milestones(flight)?.tsat_s;
    Some(late_s.abs() <= START_UP_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separations_are_those_of_neighbours_in_time_within_a_stream() {
        // Behind the second 120 s are needed, else 60 s; the last comes an hour later.
        let need_s = |first: usize, _: usize| if first == 1 { 120.0 } else { 60.0 };
        let at = vec![(500.0, 3), (100.0, 0), (190.0, 1), (300.0, 2), (4100.0, 4)];
        // 90 of 60, 110 of 120, 200 of 60, 3 600 of 60.
        let found = separations(at, need_s).expect("a stream");
        assert!((found.mean_surplus_s - (30.0 - 10.0 + 140.0) / 3.0).abs() < 1e-9, "{found:?}");
        assert_eq!(found.violations, 1);
        let exact = separations(vec![(0.0, 0), (59.5, 2)], need_s).expect("a pair");
        assert_eq!((exact.mean_surplus_s, exact.violations), (-0.5, 0));
        assert_eq!(separations(vec![(0.0, 0)], need_s), None);
        assert_eq!(separations(vec![(0.0, 0), (1000.0, 2)], need_s), None);
    }

    #[test]
    fn the_last_miles_take_as_long_as_an_approach_over_them() {
        use crate::traffic::runway_roll::approach_time_s;
        for (touchdown_mps, head_mps) in [(70.0, 0.0), (62.0, 12.0), (29.0, -3.0)] {
            for from_nm in [4.0, 5.0, 8.0] {
                let whole = approach_time_s(touchdown_mps, head_mps, from_nm).expect("flown");
                let found = last_miles_s(touchdown_mps, head_mps, from_nm);
                assert!((found - whole).abs() < 1e-3, "{touchdown_mps} {from_nm}: {found} {whole}");
            }
            let three = 3.0 * NAUTICAL_MILE_M / (1.03 * touchdown_mps - head_mps);
            assert!((last_miles_s(touchdown_mps, head_mps, 3.0) - three).abs() < 1e-9);
        }
        assert_eq!(last_miles_s(60.0, 80.0, 3.0), f64::INFINITY);
    }
}
