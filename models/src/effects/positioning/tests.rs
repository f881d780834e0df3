//! The plan of one sensor, by hand.

use super::*;

static MODEL: Model = Model {
    name: "a toy",
    reads_speed: true,
    reads_distance: true,
    costs: &[
        (PositioningEffect::White, Level::Exact, 100),
        (PositioningEffect::White, Level::Cheap, 10),
        (PositioningEffect::Multipath, Level::Exact, 50),
        (PositioningEffect::Reception, Level::Exact, 20),
    ],
};

static BLIND: Model =
    Model { name: "blind", reads_speed: false, reads_distance: false, costs: &[] };

fn planned(effect: PositioningEffect, losses: &[(Level, Loss)], given: bool) -> PlannedEffect {
    let rungs = losses.iter().map(|&(level, loss)| rung(level, loss)).collect();
    let ladder = Ladder { effect: effect.name(), called_for: "a scene".into(), rungs };
    PlannedEffect { effect, ladder, given }
}

fn ladders(step_m: f64) -> Ladders {
    use Level::{Cheap, Exact, Skipped};
    let effects = vec![
        planned(
            PositioningEffect::White,
            &[(Skipped, Loss::moves(9.0)), (Cheap, Loss::moves(0.25)), (Exact, Loss::NONE)],
            false,
        ),
        planned(
            PositioningEffect::Multipath,
            &[(Skipped, Loss::moves(0.5)), (Exact, Loss::NONE)],
            false,
        ),
        planned(
            PositioningEffect::Reception,
            &[(Skipped, Loss::odds(0.125)), (Exact, Loss::NONE)],
            false,
        ),
        planned(
            PositioningEffect::Rounding,
            &[(Skipped, Loss::odds(0.5)), (Cheap, Loss::moves(2.0))],
            true,
        ),
    ];
    Ladders { model: &MODEL, effects, step_m }
}

fn scene(any: bool, position_m: f64, detection: f64) -> PositioningScene {
    let tolerance = Tolerance { position_m, detection, ..Tolerance::EXACT };
    let conditions = Conditions { any, speed_mps: 5.0, distance_m: 500.0, dilution: 1.0 };
    PositioningScene { conditions, horizon_s: 60.0, tolerance }
}

fn levels(plan: &PositioningPlan) -> Vec<Level> {
    plan.rows.iter().map(|row| row.level).collect()
}

#[test]
fn every_effect_is_at_its_cheapest_level_within_the_sum_of_what_is_tolerated() {
    use Level::{Cheap, Exact, Skipped};
    let cases = [
        // Position, detection, step, spent; what is planned.
        (0.0, 0.0, 0.0, Loss::NONE, [Exact, Exact, Exact]),
        (0.25, 0.0, 0.0, Loss::NONE, [Cheap, Exact, Exact]),
        (0.5, 0.0, 0.0, Loss::NONE, [Cheap, Exact, Exact]),
        (0.75, 0.0, 0.0, Loss::NONE, [Cheap, Skipped, Exact]),
        (0.75, 0.125, 0.0, Loss::NONE, [Cheap, Skipped, Skipped]),
        (0.74, 0.12, 0.0, Loss::NONE, [Cheap, Exact, Exact]),
        (9.5, 0.2, 0.0, Loss::NONE, [Skipped, Skipped, Skipped]),
        // The least move may carry a report over a step.
        (0.75, 0.125, 0.01, Loss::NONE, [Cheap, Exact, Skipped]),
        (0.01, 0.125, 0.01, Loss::NONE, [Exact, Exact, Skipped]),
        (0.0, 0.125, 5.0, Loss::NONE, [Exact, Exact, Skipped]),
        // What is spent is spent.
        (0.75, 0.125, 0.0, Loss::moves(0.25), [Cheap, Exact, Skipped]),
        (0.75, 0.125, 0.0, Loss::moves(0.8), [Exact, Exact, Exact]),
        (0.75, 0.125, 0.0, Loss::odds(0.01), [Cheap, Skipped, Exact]),
    ];
    for (position_m, detection, step_m, spent, expected) in cases {
        let scene = scene(true, position_m, detection);
        let plan = plan(SensorId(3), ladders(step_m), &scene, spent);
        let name = format!("{position_m} {detection} {step_m} {spent:?}");
        assert_eq!(levels(&plan), [&expected[..], &[Cheap]].concat(), "{name}");
        let lost = plan.rows[..3].iter().fold(spent, |sum, row| sum.plus(row.loss));
        assert_eq!(plan.total, lost, "{name}");
        for (&effect, row) in plan.effects.iter().zip(&plan.rows) {
            assert_eq!((plan.levels.of(effect), row.effect), (row.level, effect.name()), "{name}");
            assert_eq!(plan.levels.on(effect), row.level != Skipped, "{name}");
            let cost = MODEL.cost_ns(effect, row.level);
            assert_eq!(
                (row.cost_ns, row.sensor, row.called_for.as_str()),
                (cost, SensorId(3), "a scene")
            );
        }
        let shown: Vec<_> = plan.rows.iter().map(|row| (row.bound, row.unit)).collect();
        assert_eq!(shown, [(9.0, "m"), (0.5, "m"), (0.125, "probability"), (0.5, "probability")]);
    }
    let costs = [Exact, Cheap, Skipped].map(|l| MODEL.cost_ns(PositioningEffect::White, l));
    assert_eq!(costs, [100.0, 10.0, 0.0]);
}

#[test]
fn a_bound_of_decibels_is_of_no_use_and_one_that_cannot_be_told_has_no_unit() {
    let effects = vec![
        planned(PositioningEffect::White, &[(Level::Exact, Loss::NONE)], false),
        planned(
            PositioningEffect::Scale,
            &[(Level::Skipped, Loss::moves(f64::NAN)), (Level::Exact, Loss::NONE)],
            false,
        ),
    ];
    let plan = plan(
        SensorId(1),
        Ladders { model: &MODEL, effects, step_m: 0.0 },
        &scene(true, f64::INFINITY, 1.0),
        Loss::NONE,
    );
    assert_eq!(levels(&plan), [Level::Exact, Level::Exact]);
    let shown: Vec<_> = plan.rows.iter().map(|row| (row.bound, row.unit)).collect();
    assert_eq!(shown, [(0.0, "m"), (f64::INFINITY, "")]);
}

#[test]
fn for_nobody_nothing_is_simulated() {
    let plan = plan(SensorId(1), ladders(0.0), &scene(false, 0.0, 0.0), Loss::NONE);
    for row in &plan.rows {
        assert_eq!(
            (row.level, row.loss, row.bound, row.unit),
            (Level::Skipped, Loss::NONE, 0.0, "m")
        );
        assert_eq!((row.cost_ns, row.called_for.as_str()), (0.0, "no equipped target"));
    }
}

#[test]
fn conditions_are_rounded_outwards_with_a_margin() {
    let of = |speed_mps, distance_m, dilution| {
        let seen = Conditions { any: true, speed_mps, distance_m, dilution };
        let r = seen.rounded();
        (r.speed_mps, r.distance_m, r.dilution)
    };
    assert_eq!(of(0.0, 0.0, 0.0), (0.0, 0.0, 0.0));
    assert_eq!(of(0.1, 1.0, 0.1), (5.0, 500.0, 0.25));
    assert_eq!(of(4.0, 450.0, 1.25), (5.0, 500.0, 1.25));
    assert_eq!(of(4.1, 451.0, 1.3), (10.0, 1000.0, 1.5));
}

fn planning(model: &'static Model) -> Planning {
    let mut planning = Planning::new(SensorId(1), model);
    planning.tolerate(scene(true, 0.75, 0.125).tolerance, 60.0);
    planning
}

fn prepare(planning: &mut Planning) -> bool {
    let mut made = false;
    planning.prepare(|_| {
        made = true;
        ladders(0.0)
    });
    made
}

fn at(speed_mps: f64) -> Vector3<f64> {
    // What climbs is no faster on the ground.
    Vector3::new(0.6 * speed_mps, -0.8 * speed_mps, 30.0)
}

#[test]
fn targets_are_looked_through_while_there_is_nobody_and_when_some_came_or_went() {
    let mut planning = planning(&MODEL);
    assert!(planning.wants_survey(0) && planning.wants_survey(0) && !planning.anybody());
    planning.see(&at(3.0), 100.0);
    assert!(planning.anybody() && !planning.wants_survey(0));
    assert!(planning.wants_survey(2) && !planning.wants_survey(2) && planning.wants_survey(1));
    assert!(Planning::new(SensorId(1), &MODEL).always().anybody());
}

#[test]
fn a_plan_is_made_again_when_more_is_seen_than_it_was_made_for() {
    let mut planning = planning(&MODEL);
    assert!(planning.plan().is_none() && planning.rows().is_empty());
    planning.see(&at(3.0), 100.0);
    planning.see_dilution(1.1);
    assert!(prepare(&mut planning) && !prepare(&mut planning));
    let conditions = planning.plan().expect("made").conditions;
    assert_eq!(
        (conditions.speed_mps, conditions.distance_m, conditions.dilution),
        (5.0, 500.0, 1.25)
    );
    // Less, or a little more: as it is.
    planning.see(&at(1.0), 10.0);
    planning.see_dilution(1.2);
    planning.see_dilution(0.5);
    assert!(!prepare(&mut planning));
    for (speed, distance, dilution) in [(7.0, 0.0, 0.0), (0.0, 700.0, 0.0), (0.0, 0.0, 1.3)] {
        planning.see(&at(speed), distance);
        planning.see_dilution(dilution);
        assert!(prepare(&mut planning), "{speed} {distance} {dilution}");
    }
    let conditions = planning.plan().expect("made").conditions;
    assert_eq!(
        (conditions.speed_mps, conditions.distance_m, conditions.dilution),
        (10.0, 1000.0, 1.5)
    );
    planning.tolerate(Tolerance::EXACT, 60.0);
    assert!(prepare(&mut planning));
    assert!(planning.rows().iter().all(|row| row.level != Level::Skipped));
    // What a model does not read calls for no plan.
    let mut blind = self::planning(&BLIND);
    blind.see(&at(3.0), 100.0);
    assert!(prepare(&mut blind));
    blind.see(&at(90.0), 9e4);
    assert!(!prepare(&mut blind));
}

#[test]
fn a_target_beyond_what_was_planned_for_is_simulated_exactly_and_counted() {
    let mut planning = planning(&MODEL);
    assert_eq!(planning.levels_for(&at(0.0), || 0.0), PositioningLevels::EXACT);
    assert_eq!((planning.levels(), planning.beyond()), (PositioningLevels::EXACT, 0));
    planning.see(&at(3.0), 100.0);
    prepare(&mut planning);
    let planned = planning.levels();
    assert!(!planned.on(PositioningEffect::Multipath) && planned.on(PositioningEffect::White));
    for (speed, distance) in [(0.0, 0.0), (5.0, 500.0), (4.9, 1.0)] {
        assert_eq!(planning.levels_for(&at(speed), || distance), planned, "{speed} {distance}");
    }
    assert_eq!(planning.beyond(), 0);
    assert_eq!(planning.levels_for(&at(5.1), || 0.0), PositioningLevels::EXACT);
    assert_eq!(planning.levels_for(&at(0.0), || 501.0), PositioningLevels::EXACT);
    assert_eq!(planning.beyond(), 2);
    assert!(prepare(&mut planning), "they are planned for from the next scan on");
    assert_eq!(planning.levels_for(&at(5.1), || 501.0), planning.levels());
    // A model that does not read them takes all alike; nor is the distance asked for.
    let mut blind = self::planning(&BLIND);
    blind.see(&at(3.0), 100.0);
    prepare(&mut blind);
    let found = blind.levels_for(&at(90.0), || panic!("the distance was asked for"));
    assert_eq!((found, blind.beyond()), (blind.levels(), 0));
    // Nobody was planned for.
    let mut empty = self::planning(&BLIND);
    prepare(&mut empty);
    assert_eq!(empty.levels(), plan_of_nobody());
    assert_eq!(empty.levels_for(&at(0.0), || 0.0), PositioningLevels::EXACT);
    assert_eq!(empty.beyond(), 1);
    // Fixed levels hold for everybody.
    planning.fix(PositioningLevels::NOTHING);
    assert!(prepare(&mut planning));
    assert_eq!(planning.levels_for(&at(90.0), || 9e9), PositioningLevels::NOTHING);
    assert_eq!(planning.beyond(), 2);
    assert!(planning.rows().iter().all(PlanRow::is_skipped));
}

fn plan_of_nobody() -> PositioningLevels {
    let effects = ladders(0.0).effects.into_iter().map(|p| p.effect);
    effects.fold(PositioningLevels::EXACT, |levels, effect| levels.with(effect, Level::Skipped))
}

#[test]
fn what_was_left_out_and_is_remembered_is_spent_once_it_is_simulated() {
    let mut planning = planning(&MODEL);
    planning.see(&at(3.0), 100.0);
    prepare(&mut planning);
    assert!(planning.rows()[1].is_skipped(), "multipath is left out");
    // It now moves by more: from here on it is simulated, and what it missed is lost for good.
    planning.see(&at(7.0), 100.0);
    let dearer = |multipath_m: f64, white_m: f64| {
        let mut ladders = ladders(0.0);
        ladders.effects[1].ladder.rungs[0].loss = Loss::moves(multipath_m);
        ladders.effects[0].ladder.rungs[1].loss = Loss::moves(white_m);
        ladders
    };
    planning.prepare(|_| dearer(3.0, 0.25));
    assert_eq!(levels(planning.plan().expect("made"))[..2], [Level::Cheap, Level::Exact]);
    assert_eq!(planning.plan().expect("made").total.fixed_m, 0.75);
    planning.see(&at(12.0), 100.0);
    planning.prepare(|_| dearer(3.0, 0.26));
    assert_eq!(levels(planning.plan().expect("made"))[..2], [Level::Exact, Level::Exact]);
    // White errors remember nothing; nor has anybody missed anything where there was nobody.
    let mut planning = self::planning(&MODEL);
    prepare(&mut planning);
    planning.see(&at(3.0), 100.0);
    prepare(&mut planning);
    assert_eq!(planning.plan().expect("made").total, Loss { odds: 0.125, ..Loss::moves(0.75) });
}

#[test]
fn evaluations_are_counted_by_effect_in_the_order_of_the_plan() {
    let mut planning = planning(&MODEL);
    assert!(planning.evaluations().is_empty());
    planning.count(PositioningEffect::Multipath);
    planning.count(PositioningEffect::Multipath);
    planning.add(PositioningEffect::White, 5);
    planning.see(&at(3.0), 100.0);
    prepare(&mut planning);
    let expected =
        [("white error", 5), ("multipath", 2), ("reception", 0), ("position rounding", 0)];
    assert_eq!(planning.evaluations(), expected);
    assert_eq!(planning.tally().of(PositioningEffect::White), 5);
}
