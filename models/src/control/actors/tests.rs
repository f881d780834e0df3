//! Laws of controllers, pilots and frequencies.

use super::*;
use ClearanceKind::{Cross, Land, LineUp, Push, TakeOff, Taxi};

const FRAME_S: f64 = 0.05;

/// Flights that want one thing each from a second on until they may; when each may, s.
fn served(asks: &[(u32, ClearanceKind, f64)], seconds: u32) -> (Actors, BTreeMap<u32, f64>) {
    let mut actors = Actors::new(Habits::default(), 11, FRAME_S);
    let mut may: BTreeMap<u32, f64> = BTreeMap::new();
    for second in 0..seconds {
        let now_s = f64::from(second);
        let waits = |flight: &u32| may.get(flight).is_none_or(|at| *at > now_s);
        let wanted: Vec<Wanted> = asks
            .iter()
            .filter(|(flight, _, from_s)| *from_s <= now_s && waits(flight))
            .map(|(flight, kind, _)| Wanted { flight: *flight, kind: *kind, group: 0 })
            .collect();
        for given in actors.scan(now_s, &wanted) {
            assert!(given.acts_s > now_s, "nothing is allowed for the past");
            may.insert(given.flight, given.acts_s);
        }
    }
    (actors, may)
}

#[test]
fn one_clearance_takes_its_call_thought_words_readback_and_action() {
    let mut taken: Vec<f64> =
        (0..400).map(|n| served(&[(n, Taxi, 0.0)], 80).1.get(&n).copied().unwrap_or(1e9)).collect();
    taken.sort_by(f64::total_cmp);
    // Call 3.6 s, then scans of 1 s; thought 1.5, clearance and readback 5.7 each, 1.0 between, action 2.5: medians.
    let median_s = taken[200];
    assert!((20.0..=21.5).contains(&median_s), "{median_s}");
    assert!(taken[0] >= 3.6 + 2.0 * 5.7 && taken[394] < 60.0, "{} {}", taken[0], taken[394]);
}

#[test]
fn nobody_speaks_while_another_does_and_a_seat_does_one_thing_at_a_time() {
    let asks: Vec<_> = (0..30).map(|n| (n, if n % 2 == 0 { Push } else { Taxi }, 0.0)).collect();
    let (actors, may) = served(&asks, 900);
    assert_eq!(may.len(), 30, "all are served");
    for seat in [Seat::Apron, Seat::Ground] {
        let on: Vec<&Message> =
            actors.messages().filter(|m| m.from == seat || m.to == seat).collect();
        let habits = Habits::default();
        let mut spans: Vec<(f64, f64)> = on
            .iter()
            .map(|m| {
                let end_s = m.at_frame as f64 * FRAME_S;
                (end_s - habits.speaks_s(m.kind, m.body), end_s)
            })
            .collect();
        spans.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert!(spans.len() >= 45, "request, clearance, readback of each: {}", spans.len());
        for pair in spans.windows(2) {
            assert!(pair[1].0 >= pair[0].1 - 2.0 * FRAME_S, "{pair:?}");
        }
    }
}

#[test]
fn who_lands_comes_before_who_lines_up_whoever_came_first() {
    // Who lands has to call first; then he comes before those who were seen at the line all the time.
    let asks = [(1, LineUp, 0.0), (2, LineUp, 0.0), (3, Cross, 0.0), (4, Land, 0.0)];
    let (_, may) = served(&asks, 200);
    assert!(may[&3] < may[&4], "the crossing was begun before the call was over: {may:?}");
    assert!(may[&4] < may[&1] && may[&1] < may[&2], "{may:?}");
}

#[test]
fn a_full_seat_lets_pushes_wait_but_no_landing() {
    assert!(priority(Land) < priority(TakeOff) && priority(LineUp) < priority(Taxi));
    // Forty want to taxi at once: the workload comes near to one, and the queue goes down all the same.
    let asks: Vec<_> = (0..40).map(|n| (n, Taxi, 0.0)).collect();
    let (actors, may) = served(&asks, 1800);
    assert_eq!(may.len(), 40);
    let most = actors.samples().iter().map(|s| s.busy).fold(0.0, f64::max);
    assert!((0.8..=1.0 + 1e-9).contains(&most), "{most}");
    let queues: Vec<u32> = actors.samples().iter().map(|s| s.queue).collect();
    assert!(queues[0] > 30 && queues.last() == Some(&0), "{queues:?}");
}

#[test]
fn the_same_questions_get_the_same_answers() {
    let asks: Vec<_> = (0..20).map(|n| (n, Taxi, f64::from(n))).collect();
    assert_eq!(served(&asks, 600).1, served(&asks, 600).1);
}
