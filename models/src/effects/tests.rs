use super::choice::{Candidate, cheapest};
use super::*;

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
