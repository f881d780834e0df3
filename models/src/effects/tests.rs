use super::choice::{Candidate, cheapest};
use super::*;
use proptest::prelude::*;

fn ladder(rungs: &[(u32, Loss)]) -> Vec<Candidate<Loss>> {
    rungs.iter().map(|&(cost_ns, loss)| Candidate { cost_ns, loss }).collect()
}

fn simple(db: f64) -> Vec<Candidate<Loss>> {
    ladder(&[(0, Loss::raises(db)), (10, Loss::NONE)])
}

fn within(limit: f64) -> impl Fn(&Loss) -> bool {
    move |loss| loss.is_known() && loss.db() <= limit
}

#[test]
fn the_sum_counts_and_not_each_bound() {
    let ladders = [simple(0.3), simple(0.3), simple(0.3), simple(0.05)];
    let choice = cheapest(&ladders, within(0.7), Loss::db).expect("exact is tolerated");
    assert_eq!(choice.chosen.iter().filter(|&&r| r == 0).count(), 3);
    assert!((choice.loss.raises_db - 0.65).abs() < 1e-12 && choice.is_best);
}

#[test]
fn what_cannot_be_told_is_simulated() {
    for bound in [f64::NAN, f64::INFINITY] {
        let choice = cheapest(&[simple(bound)], Loss::is_known, Loss::db).expect("exact");
        assert_eq!(choice.chosen, [1], "{bound}");
    }
}

#[test]
fn the_cheapest_level_that_fits_is_taken() {
    let rungs = ladder(&[
        (0, Loss::raises(5.0)),
        (2, Loss { lowers_db: 0.4, ..Loss::raises(0.4) }),
        (8, Loss { lowers_db: 0.1, ..Loss::raises(0.1) }),
        (30, Loss::NONE),
    ]);
    for (limit, expected) in [(10.0, 0), (1.0, 1), (0.2, 2), (0.0, 3)] {
        let choice = cheapest(std::slice::from_ref(&rungs), within(limit), Loss::db);
        assert_eq!(choice.expect("exact is tolerated").chosen, [expected], "limit {limit}");
    }
}

#[test]
fn a_dearer_effect_is_worth_more_than_two_smaller_bounds() {
    // Smallest bound first would take the two cheap ones and leave the dear one.
    let ladders = [
        ladder(&[(0, Loss::raises(0.2)), (10, Loss::NONE)]),
        ladder(&[(0, Loss::raises(0.2)), (10, Loss::NONE)]),
        ladder(&[(0, Loss::raises(0.9)), (100, Loss::NONE)]),
    ];
    let choice = cheapest(&ladders, within(1.0), Loss::db).expect("exact is tolerated");
    assert_eq!((choice.chosen, choice.cost_ns), (vec![1, 1, 0], 20));
}

/// The least cost of all choices that are tolerated.
fn by_hand(ladders: &[Vec<Candidate<Loss>>], limit: f64) -> u64 {
    let mut all = vec![(0u64, 0.0)];
    for ladder in ladders {
        all = all
            .iter()
            .flat_map(|&(cost, db)| {
                ladder.iter().map(move |c| (cost + u64::from(c.cost_ns), db + c.loss.raises_db))
            })
            .collect();
    }
    all.iter().filter(|(_, db)| *db <= limit).map(|(cost, _)| *cost).min().expect("exact")
}

proptest! {
    #[test]
    fn no_tolerated_choice_is_cheaper(
        rungs in proptest::collection::vec(
            proptest::collection::vec((0..40u32, 0..40u32), 0..4), 1..6,
        ),
        dear in 0..60u32,
        limit in 0..60u32,
    ) {
        // Quarters of a decibel: sums are exact.
        let ladders: Vec<_> = rungs
            .iter()
            .map(|rungs| {
                let losing = rungs.iter().map(|&(cost, db)| (cost, Loss::raises(f64::from(db) * 0.25)));
                ladder(&losing.chain([(dear, Loss::NONE)]).collect::<Vec<_>>())
            })
            .collect();
        let limit = f64::from(limit) * 0.25;
        let choice = cheapest(&ladders, within(limit), Loss::db).expect("exact is tolerated");
        let of = |l: usize| ladders[l][choice.chosen[l]].clone();
        let cost: u64 = (0..ladders.len()).map(|l| u64::from(of(l).cost_ns)).sum();
        let db: f64 = (0..ladders.len()).map(|l| of(l).loss.raises_db).sum();
        prop_assert_eq!((choice.cost_ns, choice.loss.raises_db), (cost, db));
        prop_assert!(db <= limit && choice.is_best);
        prop_assert_eq!(cost, by_hand(&ladders, limit));
    }
}

#[test]
fn a_search_ends_where_nothing_cheaper_is_left_and_after_its_last_node() {
    let ladders: Vec<_> = (0..10)
        .map(|k| {
            ladder(&[
                (k, Loss::raises(0.1)),
                (50 + k, Loss::raises(0.05)),
                (90, Loss::raises(0.01)),
                (99, Loss::NONE),
            ])
        })
        .collect();
    // All at their cheapest: no other choice has to be looked at.
    let mut asked = 0;
    let all = |loss: &Loss| {
        asked += 1;
        loss.db() <= 2.0
    };
    let choice = cheapest(&ladders, all, Loss::db).expect("exact is tolerated");
    assert_eq!((choice.chosen, choice.cost_ns, choice.is_best), (vec![0; 10], 45, true));
    assert!(asked < 100, "{asked}");
    // So many alike that they cannot all be looked at: what was found is tolerated, and not said to be the best.
    let alike: Vec<_> = (0..40u32)
        .map(|k| {
            ladder(&[
                (k % 7, Loss::raises(0.1 + 1e-3 * f64::from(k % 5))),
                (60 + k % 3, Loss::NONE),
            ])
        })
        .collect();
    let mut asked = 0;
    let half = |loss: &Loss| {
        asked += 1;
        loss.db() <= 2.0
    };
    let choice = cheapest(&alike, half, Loss::db).expect("exact is tolerated");
    assert!(!choice.is_best && choice.loss.db() <= 2.0 && choice.cost_ns < 1_500);
    assert!(asked <= choice::MOST_NODES + 100, "{asked}");
    assert!(cheapest(&alike, |_| false, Loss::db).is_none());
}

#[test]
fn the_least_factor_is_where_a_cheaper_choice_is_tolerated_first() {
    // What a choice takes is what it needs, whatever it was given.
    let steps = [(7.0, 5.0), (2.5, 20.0), (0.3, 60.0), (0.0, 100.0)];
    let cost = |factor: f64| {
        let (share, ns) = steps.into_iter().find(|(share, _)| factor >= *share).expect("exact");
        (ns, share)
    };
    let least = |budget| choice::least_factor(budget, 1e6, cost);
    for (budget, factor) in
        [(99.0, 0.3), (60.0, 0.3), (59.0, 2.5), (20.0, 2.5), (19.0, 7.0), (5.0, 7.0)]
    {
        assert_eq!(least(budget), Some(factor), "{budget}");
    }
    assert_eq!((least(100.0), least(4.9)), (Some(0.0), None));
    // A share that is more than what was given, by rounding, is not asked for.
    assert_eq!(choice::least_factor(100.0, 8.0, |_| (50.0, 1e-9)), Some(0.0));
    assert_eq!(
        choice::least_factor(1.0, 8.0, |f| (8.0 - f, f + 1.0)).map(|f| (f * 1e9).round()),
        Some(7e9)
    );
    let found = choice::least_factor(1.0, 8.0, |f| (8.0 - f, f)).expect("it fits");
    assert!((found - 7.0).abs() < 1e-11, "{found}");
}

#[test]
fn tolerances_grow_by_a_factor_and_shares_up_to_one() {
    let usual = Tolerance { track_m: Some(0.5), ..Tolerance::default() };
    let twice = usual.times(2.0);
    assert_eq!((twice.position_m, twice.tail, twice.detection), (0.2, 0.002, 0.02));
    assert_eq!((twice.false_plots, twice.track_m, twice.jerk_m2_s5), (0.02, Some(1.0), 0.3));
    let most = usual.times(1e6);
    assert_eq!((most.tail, most.detection, most.false_plots), (1.0, 1.0, 1e4));
}

#[test]
fn losses_add_part_by_part_the_worse_is_taken_part_by_part_and_what_says_most_is_shown() {
    let one = Loss {
        raises_db: 1.0,
        lowers_db: 2.0,
        fixed_m: 3.0,
        own_m2: 4.0,
        coupled_rad: 5.0,
        odds: 0.25,
        false_plots: 7.0,
    };
    let two = Loss { raises_db: 4.0, lowers_db: 1.0, fixed_m: 1.0, odds: 0.5, ..Loss::NONE };
    let both = Loss { raises_db: 5.0, lowers_db: 3.0, fixed_m: 4.0, odds: 0.75, ..one };
    assert_eq!((one.plus(two), two.plus(one)), (both, both));
    let worst = Loss { raises_db: 4.0, odds: 0.5, ..one };
    assert_eq!((one.worse(&two), two.worse(&one), one.worse(&one)), (worst, worst, one));
    assert_eq!((one.db(), two.db()), (2.0, 4.0));
    assert!(Loss::raises(f64::NAN).db().is_nan() && Loss::lowers(f64::NAN).db().is_nan());
    assert_eq!(one.shown(), (3.0, "m"));
    assert_eq!(Loss { fixed_m: 0.0, ..one }.shown(), (0.25, "probability"));
    assert_eq!(Loss { fixed_m: 0.0, odds: 0.0, ..one }.shown(), (2.0, "dB"));
    let parts: [fn(&mut Loss) -> &mut f64; 7] = [
        |l| &mut l.raises_db,
        |l| &mut l.lowers_db,
        |l| &mut l.fixed_m,
        |l| &mut l.own_m2,
        |l| &mut l.coupled_rad,
        |l| &mut l.odds,
        |l| &mut l.false_plots,
    ];
    for part in parts {
        for bad in [f64::NAN, f64::INFINITY] {
            let mut loss = one;
            *part(&mut loss) = bad;
            assert!(!loss.is_known() && loss.shown() == (f64::INFINITY, ""), "{loss:?}");
            let [a, b] = [one.worse(&loss), loss.worse(&one)].map(|mut l| *part(&mut l));
            assert!(!a.is_finite() && !b.is_finite(), "{loss:?}");
        }
    }
    assert!(one.is_known());
}

#[test]
fn what_changed_between_two_plans_is_told_by_sensor_and_effect() {
    let row = |sensor, effect, level| PlanRow {
        sensor: SensorId(sensor),
        effect,
        called_for: String::new(),
        bound: 0.0,
        unit: "m",
        level,
        loss: Loss::NONE,
        cost_ns: 0.0,
    };
    let from =
        [row(1, "rain", Level::Exact), row(1, "fog", Level::Cheap), row(2, "rain", Level::Skipped)];
    let to = [
        row(2, "fog", Level::Exact),
        row(2, "rain", Level::Middle),
        row(1, "fog", Level::Cheap),
        row(1, "rain", Level::Skipped),
    ];
    let change = |sensor, effect, from, to| Change { sensor: SensorId(sensor), effect, from, to };
    let expected = [
        change(1, "rain", Level::Exact, Level::Skipped),
        change(2, "rain", Level::Skipped, Level::Middle),
    ];
    assert_eq!(changes(&from, &to), expected);
    assert_eq!(changes(&from, &to[..2]), expected[1..]);
    assert!(from[2].is_skipped() && !from[0].is_skipped());
}

/// What saves nothing is not worth a loss, in whatever order the levels stand.
#[test]
fn of_levels_that_cost_the_same_the_one_that_loses_less_is_taken() {
    let (small, large) = ((2, Loss::raises(0.1)), (2, Loss::raises(0.6)));
    for cheap in [[small, large], [large, small]] {
        let rungs = ladder(&[cheap[0], cheap[1], (30, Loss::NONE)]);
        let both = [rungs, simple(0.2)];
        let choice = cheapest(&both, within(1.0), Loss::db).expect("exact is tolerated");
        assert!((choice.loss.db() - 0.3).abs() < 1e-12, "{choice:?}");
    }
}
