use super::*;
use crate::truth::route::{self, Halt};
use crate::truth::{Kinematics, TruthState};
use proptest::prelude::*;

fn a320() -> Limits {
    let kinematics = Kinematics {
        liftoff_mps: Some(85.3),
        takeoff_acc_ms2: Some(1.93),
        touchdown_mps: Some(69.4),
        braking_ms2: Some(1.22),
        taxi_straight_mps: 15.4,
        taxi_turn_mps: 5.1,
        taxi_acc_ms2: 0.7,
        taxi_dec_ms2: 0.7,
    };
    Limits::of(true, &kinematics)
}

/// Taxiing round two corners, with a halt of 40 s before the second.
fn sound() -> Trajectory {
    let line = [(0.0, 0.0), (600.0, 50.0), (650.0, -400.0), (1400.0, -450.0)];
    let line = line.map(|(x, y)| Point2::new(x, y));
    let halts = [Halt { point: 2, duration_s: 40.0 }];
    let span = (SimTime::ZERO, SimTime::from_s(330.0));
    route::drive(&line, &halts, &a320(), span, 10.0).expect("a sound line")
}

/// Its positions once a second, with errors of up to a metre from `noise`.
fn records(truth: &Trajectory, noise: &[(f64, f64)]) -> Vec<Record> {
    (0..=320)
        .map(|i| {
            let state = truth.at(SimTime::from_s(i as f64)).expect("within");
            let (east, north) = noise.get(i % noise.len().max(1)).copied().unwrap_or((0.0, 0.0));
            Record {
                line: i + 2,
                time_ms: Some(1_500_000_000_000 + 1000 * i as i64),
                position_m: Some(state.position_m.xy() + Vector2::new(east, north)),
                altitude_m: None,
                on_ground: Some(true),
            }
        })
        .collect()
}

/// Errors of the positions that are the same every time.
fn noise(draw: i32) -> Vec<(f64, f64)> {
    let error = |i: i32| (libm::sin(1.7 * f64::from(i)), libm::cos(2.3 * f64::from(i)));
    (0..321).map(|i| error(i + 331 * draw)).collect()
}

/// One kind of damage to one place of the records.
#[derive(Clone, Debug)]
enum Damage {
    /// The position of record `at` is repeated for so many records.
    Freeze { at: usize, count: usize },
    /// A single position so far off.
    Jump { at: usize, east_m: f64, north_m: f64 },
    /// No position in so many records.
    Missing { at: usize, count: usize },
    /// A record swapped with its neighbour.
    Swap { at: usize },
    /// A clock that is wrong once.
    Clock { at: usize, ms: i64 },
    /// An altitude that cannot be.
    Spike { at: usize },
}

fn damage() -> impl Strategy<Value = Damage> {
    let at = 5usize..300;
    let far = prop_oneof![-9000.0..-150.0, 150.0..9000.0];
    prop_oneof![
        (at.clone(), 2usize..25).prop_map(|(at, count)| Damage::Freeze { at, count }),
        (at.clone(), far, -900.0..900.0).prop_map(|(at, east_m, north_m)| Damage::Jump {
            at,
            east_m,
            north_m
        }),
        (at.clone(), 1usize..25).prop_map(|(at, count)| Damage::Missing { at, count }),
        at.clone().prop_map(|at| Damage::Swap { at }),
        (at.clone(), -100_000i64..100_000).prop_map(|(at, ms)| Damage::Clock { at, ms }),
        at.prop_map(|at| Damage::Spike { at }),
    ]
}

fn inflict(records: &mut [Record], damage: &Damage) {
    let last = records.len();
    match *damage {
        Damage::Freeze { at, count } => {
            let held = records[at].position_m;
            records[at..(at + count).min(last)].iter_mut().for_each(|r| r.position_m = held);
        }
        Damage::Jump { at, east_m, north_m } => {
            records[at].position_m =
                records[at].position_m.map(|p| p + Vector2::new(east_m, north_m));
        }
        Damage::Missing { at, count } => {
            records[at..(at + count).min(last)].iter_mut().for_each(|r| r.position_m = None);
        }
        Damage::Swap { at } => records.swap(at, at + 1),
        Damage::Clock { at, ms } => {
            records[at].time_ms = records[at].time_ms.map(|t| t + ms);
        }
        Damage::Spike { at } => records[at].altitude_m = Some(12_000.0),
    }
}

fn within_limits(state: &TruthState, limits: &Limits) -> bool {
    let nose = Vector2::new(libm::sin(state.heading_rad), libm::cos(state.heading_rad));
    let along = state.acceleration_ms2.xy().dot(&nose).abs();
    let across =
        (state.acceleration_ms2.xy() - nose * state.acceleration_ms2.xy().dot(&nose)).norm();
    state.velocity_mps.norm() <= limits.taxi_mps
        && along <= limits.taxi_acc_ms2.max(limits.taxi_dec_ms2)
        && across <= limits.lateral_ms2
        && state.position_m.z == 0.0
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// Whatever is done to some records: the import keeps the limits and stays near the truth.
    #[test]
    fn damage_is_repaired_within_the_limits(
        noise in prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64), 200),
        damages in prop::collection::vec(damage(), 0..7),
    ) {
        let truth = sound();
        let limits = a320();
        let clean = records(&truth, &noise);
        let mut records = clean.clone();
        for damage in &damages {
            inflict(&mut records, damage);
        }
        let last_sound_s = (0..clean.len()).rev().find(|&i| records[i] == clean[i]).unwrap_or(0);
        let start_ms = 1_500_000_000_000;
        let first = records.iter().filter(|r| r.position_m.is_some()).find_map(|r| r.time_ms);
        prop_assume!(first == Some(start_ms));
        let (found, report) = import(&records, &limits, &[], SimTime::ZERO)
            .map_err(|refusal| TestCaseError::fail(format!("line {}: {refusal}", refusal.line())))?;
        // A spike counts where its record's clock still lies within the recording.
        let seconds = |r: &Record| r.time_ms.map(|t| (t - start_ms) as f64 * 1e-3);
        let within = |t: f64| (0.0..=last_sound_s as f64).contains(&t);
        let mut spikes = records.iter().filter(|r| r.altitude_m.is_some()).filter_map(seconds);
        let told = report.tally.count(Rule::AltitudeSpike) > 0;
        let inflicted = damages.iter().any(|d| matches!(d, Damage::Spike { .. }));
        prop_assert!(!told || inflicted, "told of a spike that nobody inflicted");
        prop_assert!(told || !spikes.any(within), "a spike was not told of");
        prop_assert_eq!(report.pushbacks, 0, "nose first all the way");
        let mut far = 0;
        let mut count = 0;
        let mut before: Option<TruthState> = None;
        for i in 0..=(320 * 20) {
            let time = SimTime(i * 50_000_000);
            let (Some(state), Some(sound)) = (found.at(time), truth.at(time)) else { continue };
            prop_assert!(within_limits(&state, &limits), "at {} s: {state:?}", time.s());
            if let Some(last) = before {
                prop_assert!((state.position_m - last.position_m).norm() < 0.9, "at {} s", time.s());
            }
            before = Some(state);
            let off_m = (state.position_m - sound.position_m).norm();
            // Freezes and gaps of 25 s hide what the speed did meanwhile.
            prop_assert!(off_m < 130.0, "{off_m} m off at {} s", time.s());
            count += 1;
            far += usize::from(off_m > 25.0);
        }
        prop_assert!(count >= last_sound_s * 20, "only {count} frames to {last_sound_s} s");
        prop_assert!(far * 5 < count, "more than 25 m off in {far} of {count} frames");
    }

    /// Nonsense is refused or gives something finite, never a panic.
    #[test]
    fn nonsense_does_no_harm(
        rows in prop::collection::vec(
            (prop::option::of(-100_000i64..100_000), prop::option::of((-1e5..1e5f64, -1e5..1e5f64))), 0..40),
    ) {
        let records: Vec<Record> = rows.iter().enumerate().map(|(i, (t, p))| Record {
            line: i + 2,
            time_ms: *t,
            position_m: p.map(|(x, y)| Point2::new(x, y)),
            altitude_m: Some(1e5),
            on_ground: None,
        }).collect();
        if let Ok((found, _)) = import(&records, &a320(), &[], SimTime::ZERO) {
            let state = found.at(found.start()).expect("its own begin");
            prop_assert!(state.position_m.iter().chain(state.velocity_mps.iter()).all(|x| x.is_finite()));
        }
    }
}

#[test]
fn a_clean_recording_is_followed_closely() {
    let truth = sound();
    let (found, report) = import(&records(&truth, &[]), &a320(), &[], SimTime::ZERO).unwrap();
    for i in 0..=3200 {
        let time = SimTime(i * 100_000_000);
        let (a, b) = (found.at(time).unwrap(), truth.at(time).unwrap());
        let off_m = (a.position_m - b.position_m).norm();
        assert!(off_m < 6.0, "{off_m} m at {} s", time.s());
        let turned = crate::frames::wrap_pi(a.heading_rad - b.heading_rad).abs();
        assert!(turned < 0.3, "{turned} rad at {} s", time.s());
    }
    assert_eq!(report.pushbacks, 0);
    assert!(report.stands.1 > 30.0, "the halt is seen: {report}");
}

#[test]
fn somebody_who_never_moves_stands_exactly_still() {
    let mut records = records(&sound(), &[]);
    records.iter_mut().for_each(|r| r.position_m = Some(Point2::new(12.5, -7.25)));
    let (found, _) = import(&records, &a320(), &[], SimTime::ZERO).unwrap();
    let first = found.at(SimTime::ZERO).unwrap();
    assert!((first.position_m.xy() - Point2::new(12.5, -7.25)).norm() < 3.0);
    for i in 0..=320 {
        let state = found.at(SimTime::from_s(f64::from(i))).unwrap();
        assert!(state.is_still() && state.position_m == first.position_m);
    }
}

#[test]
fn what_cannot_be_repaired_is_refused_with_its_line() {
    let truth = sound();
    let limits = a320();
    let refused = |change: &dyn Fn(&mut Vec<Record>)| {
        let mut records = records(&truth, &[]);
        change(&mut records);
        import(&records, &limits, &[], SimTime::ZERO).expect_err("a refusal")
    };
    let few = refused(&|r| r.iter_mut().skip(5).for_each(|r| r.position_m = None));
    assert!(matches!(few, Refusal::TooFew { line: 322, records: 321, .. }), "{few}");
    let gap = refused(&|r| r[40..200].iter_mut().for_each(|r| r.position_m = None));
    assert!(matches!(gap, Refusal::Gap { line: 202, .. }), "{gap}");
    let long = refused(&|r| {
        r.iter_mut().enumerate().for_each(|(i, r)| r.time_ms = Some(60_000 * i as i64))
    });
    assert!(matches!(long, Refusal::TooLong { .. }), "{long}");
    let empty = import(&[], &limits, &[], SimTime::ZERO).expect_err("nothing");
    assert!(matches!(empty, Refusal::TooFew { line: 1, left: 0, records: 0, .. }), "{empty}");
    // In circles, half as fast again as the type can taxi.
    let fast = refused(&|r| {
        for (i, record) in r.iter_mut().enumerate() {
            let turn = i as f64 * 0.25;
            record.position_m = Some(Point2::new(100.0 * libm::sin(turn), 100.0 * libm::cos(turn)));
        }
    });
    assert!(matches!(fast, Refusal::BeyondType { .. }), "{fast}");
}

/// It stops while nobody sees it, and is seen standing to the end: the end is kept.
#[test]
fn a_stop_within_a_gap_is_a_stop() {
    let truth = sound();
    let mut records = records(&truth, &[]);
    inflict(&mut records, &Damage::Missing { at: 250, count: 25 });
    let (found, report) = import(&records, &a320(), &[], SimTime::ZERO).unwrap();
    assert_eq!(report.tally.count(Rule::NotRenewed), 0, "{report}");
    let last = found.at(SimTime::from_s(320.0)).expect("to the last record");
    let off_m = (last.position_m - truth.at(SimTime::from_s(320.0)).unwrap().position_m).norm();
    assert!(off_m < 6.0 && last.velocity_mps.norm() < 0.1, "{off_m} m, {last:?}");
}

/// It brakes and stops while nobody sees it: the smoothed track overshoots and comes back, the mover does not.
#[test]
fn a_stop_within_a_long_gap_is_no_pushback() {
    let truth = sound();
    for draw in 0..20 {
        let mut records = records(&truth, &noise(draw));
        inflict(&mut records, &Damage::Missing { at: 257, count: 39 });
        let (found, report) = import(&records, &a320(), &[], SimTime::ZERO).unwrap();
        assert_eq!(report.pushbacks, 0, "draw {draw}\n{report}");
        for i in 0..=640 {
            let time = SimTime(i * 500_000_000);
            let off_m = found.at(time).unwrap().position_m - truth.at(time).unwrap().position_m;
            assert!(off_m.norm() < 12.0, "{off_m} m at {} s of draw {draw}\n{report}", time.s());
        }
    }
}

/// It stands, and is seen again at speed: meanwhile the smoothed track swings back, the mover does not.
#[test]
fn a_start_within_a_long_gap_is_no_pushback() {
    let truth = sound();
    for draw in 0..20 {
        let mut records = records(&truth, &noise(draw));
        inflict(&mut records, &Damage::Missing { at: 152, count: 36 });
        let (found, report) = import(&records, &a320(), &[], SimTime::ZERO).unwrap();
        assert_eq!(report.pushbacks, 0, "draw {draw}\n{report}");
        for i in 0..=640 {
            let time = SimTime(i * 500_000_000);
            let off_m = found.at(time).unwrap().position_m - truth.at(time).unwrap().position_m;
            assert!(off_m.norm() < 12.0, "{off_m} m at {} s of draw {draw}\n{report}", time.s());
        }
    }
}

/// The same, and the first position after the gap is that of the halt once more.
#[test]
fn a_stale_position_at_a_start_is_no_pushback() {
    let truth = sound();
    for draw in 0..20 {
        let mut records = records(&truth, &noise(draw));
        inflict(&mut records, &Damage::Freeze { at: 181, count: 9 });
        inflict(&mut records, &Damage::Missing { at: 156, count: 30 });
        let (_, report) = import(&records, &a320(), &[], SimTime::ZERO).unwrap();
        assert_eq!(report.pushbacks, 0, "draw {draw}\n{report}");
    }
}

/// Three positions behind a long gap: their errors within two seconds are no speed.
#[test]
fn last_positions_behind_a_long_gap_make_no_loop() {
    let truth = sound();
    for draw in 0..20 {
        let mut records = records(&truth, &noise(draw));
        inflict(&mut records, &Damage::Missing { at: 295, count: 23 });
        let errors = [(-1.0, -0.9), (0.9, 0.9), (0.9, 0.8)];
        for (i, (east, north)) in (318..).zip(errors) {
            let there = truth.at(SimTime::from_s(f64::from(i))).unwrap().position_m.xy();
            records[i as usize].position_m = Some(there + Vector2::new(east, north));
        }
        let (found, report) = import(&records, &a320(), &[], SimTime::ZERO).unwrap();
        for i in 0..=640 {
            let time = SimTime(i * 500_000_000);
            let off_m = found.at(time).unwrap().position_m - truth.at(time).unwrap().position_m;
            assert!(off_m.norm() < 6.0, "{off_m} m at {} s of draw {draw}\n{report}", time.s());
        }
    }
}

/// Pushed back, it turns on its track while nobody sees it: the positions on both sides tell.
#[test]
fn a_pushback_that_ends_within_a_gap_is_one() {
    let line = [(0.0, 0.0), (0.0, 120.0)].map(|(x, y)| Point2::new(x, y));
    let span = (SimTime::ZERO, SimTime::from_s(330.0));
    let out = route::drive(&line, &[], &a320(), span, 10.0).expect("a sound line");
    let mut records = records(&out, &noise(0));
    // Out in 25 s, and at 60 s back again.
    for i in 0..records.len() {
        let ago = if i > 60 { 120_usize.saturating_sub(i) } else { i };
        let there = out.at(SimTime::from_s(ago as f64)).unwrap().position_m.xy();
        let (east, north) = noise(0)[i % 200];
        records[i].position_m = Some(there + Vector2::new(east, north));
    }
    inflict(&mut records, &Damage::Missing { at: 36, count: 49 });
    let (_, report) = import(&records, &a320(), &[], SimTime::ZERO).unwrap();
    assert_eq!(report.pushbacks, 1, "{report}");
}

/// Its last position comes alone, long after the others: the halt before it is a halt, not a loop of the path.
#[test]
fn a_last_position_behind_a_long_gap_makes_no_hook() {
    let truth = sound();
    for draw in 0..20 {
        let mut records = records(&truth, &noise(draw));
        inflict(&mut records, &Damage::Missing { at: 299, count: 21 });
        let (found, report) = import(&records, &a320(), &[], SimTime::ZERO).unwrap();
        for i in 0..=640 {
            let time = SimTime(i * 500_000_000);
            let (state, sound) = (found.at(time).unwrap(), truth.at(time).unwrap());
            assert!(within_limits(&state, &a320()), "at {} s: {state:?}", time.s());
            let off_m = (state.position_m - sound.position_m).norm();
            assert!(off_m < 6.0, "{off_m} m at {} s of draw {draw}\n{report}", time.s());
        }
    }
}
