//! What is planned for whom.

use super::*;
use crate::frames::Point2;

/// The levels at which the target of a key was simulated.
fn levels_of(radar: &Asde, truth: &Straight, key: u64) -> Option<RadarLevels> {
    let index = (0..truth.len()).find(|i| truth.key(*i) == key)?;
    let placed = radar.placed().iter().find(|p| p.index == index)?;
    placed.place.map(|p| radar.boxes()[p as usize].plan.levels)
}

#[test]
fn where_nothing_may_move_nothing_does_though_detection_may_change() {
    // Far off in a wide beam the arc of a plot is bent by what it states of its errors, and that by how strong a look was:
    // a table of the detection would move it by micrometres.
    let truth = Straight::new(&[((2500.0, 2500.0), (0.0, 0.0)), ((-3500.0, 900.0), (0.0, 0.0))]);
    let plots = |levels: Option<RadarLevels>, position_m: f64| {
        let mut radar = asde(|p| {
            (p.azimuth_beamwidth_deg, p.prf_hz, p.swerling) = (2.0, 5000.0, Swerling::One);
            (p.peak_power_w, p.range_step_m, p.azimuth_step_deg) =
                (0.02 * p.peak_power_w, 0.0, 0.0);
        })
        .tolerating(Tolerance { position_m, tail: 0.1, ..Tolerance::default() });
        radar.fixed = levels;
        let mut out = PlotSink::default();
        for scan in 1..=200 {
            radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut out);
        }
        out.plots.iter().map(|plot| (plot.time, plot.position_m)).collect::<Vec<_>>()
    };
    let exact = plots(Some(RadarLevels::EXACT), 0.0);
    assert!(exact.len() > 200, "{}", exact.len());
    assert_eq!(plots(None, 0.0), exact);
    assert_ne!(plots(None, 0.1), exact, "what may move does");
}

#[test]
fn a_target_at_the_towers_foot_changes_nothing_for_one_far_away() {
    let far = ((900.0, 900.0), (0.0, 0.0));
    let alone = Straight::new(&[far]);
    let mut radar = asde(|_| ());
    let scan = |radar: &mut Asde, truth: &Straight| {
        radar.scan(&interval(1, 1.0), truth, &Weather::default(), &mut PlotSink::default());
    };
    scan(&mut radar, &alone);
    let before = levels_of(&radar, &alone, 1).expect("planned");
    assert!(before != radar.base_levels(), "something is left out");
    for near in [30.0, 70.0, 130.0, 250.0] {
        let both = Straight::new(&[far, ((near, 0.0), (0.0, 0.0))]);
        let mut radar = asde(|_| ());
        scan(&mut radar, &both);
        assert_eq!(levels_of(&radar, &both, 1), Some(before), "the other at {near} m");
    }
}

#[test]
fn a_plan_is_the_same_for_targets_in_any_order_and_planned_in_parts() {
    let spiral = |i: usize| {
        let (sin, cos) = libm::sincos(i as f64 * 2.4);
        let r = 150.0 * libm::exp(i as f64 * 0.08);
        ((r * sin, r * cos), (0.0, 0.0))
    };
    let all: Vec<(Pair, Pair)> = (0..40).map(spiral).collect();
    let plans = |order: &[usize]| -> Vec<Option<RadarLevels>> {
        let truth = Straight::new(&order.iter().map(|i| all[*i]).collect::<Vec<_>>());
        let mut radar = asde(|p| p.polarisation = Polarisation::Vertical);
        let mut planned = 0;
        for _ in 0..5 {
            radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut PlotSink::default());
            let now = radar.boxes().len();
            assert!(now - planned <= plan::planner::MOST_NEW, "{now} after {planned}");
            planned = now;
        }
        let place = |i: usize| order.iter().position(|o| *o == i).expect("in the order") as u64;
        (0..all.len()).map(|i| levels_of(&radar, &truth, place(i) + 1)).collect()
    };
    let forward: Vec<usize> = (0..all.len()).collect();
    let backward: Vec<usize> = forward.iter().rev().copied().collect();
    let found = plans(&forward);
    assert!(found.iter().filter(|f| f.is_some()).count() > 30, "{found:?}");
    assert_eq!(found, plans(&backward));
}

#[test]
fn rings_are_cut_where_parts_leave_out_more_and_their_own_plan_holds_until_then() {
    let spiral = |i: usize| {
        let (sin, cos) = libm::sincos(i as f64 * 2.4);
        let r = 150.0 * libm::exp(i as f64 * 0.045);
        ((r * sin, r * cos), (0.0, 0.0))
    };
    let truth = Straight::new(&(0..60).map(spiral).collect::<Vec<_>>());
    let storm = Weather { rain_mm_per_h: 20.0, film_mm: 0.5, ..Weather::default() };
    let mut sink = PlotSink::default();
    let (mut by_ring, mut in_parts, mut saved_ns) = (0, 0, 0);
    for power in [1.0, 0.1, 0.01, 1e-3] {
        let mut radar = asde(|p| p.peak_power_w *= power);
        let mut planned = 0;
        for scan in 1..=12 {
            radar.scan(&interval(scan, 1.0), &truth, &storm, &mut sink);
            let boxes = radar.boxes();
            assert!(boxes.len() - planned <= plan::planner::MOST_NEW);
            planned = boxes.len();
            for placed in radar.placed() {
                let Some(place) = placed.place else { continue };
                let found = &boxes[place as usize];
                let state = truth.at(placed.index, SimTime(0)).expect("it stands");
                let (near, far) = found.key.ground_m();
                let d = state.position_m.xy().coords.norm();
                assert!(d >= near * (1.0 - 1e-9) && d <= far * (1.0 + 1e-9), "{d} m in {found:?}");
                by_ring += usize::from(found.parted);
            }
        }
        // All parts that are asked for are there, and take the ring's place.
        let boxes = radar.boxes();
        assert_eq!(radar.planner().waiting(), 0);
        let of = |part: bool| boxes.iter().filter(move |b| (b.key.part > 0) == part);
        assert!(of(true).all(|b| boxes.iter().any(|w| w.parted && w.key == b.key.whole())));
        assert!(!boxes.iter().any(|b| b.parted && b.targets > 0), "a part takes the ring's place");
        assert!(of(true).all(|b| b.plan.share <= 1.0 + 1e-9));
        in_parts += of(true).filter(|b| b.targets > 0).count();
        for whole in of(false) {
            let parts = of(true).filter(|b| b.key.whole() == whole.key);
            let saved =
                |b: &plan::PlannedBox| whole.plan.cost_ns().0.saturating_sub(b.plan.cost_ns().0);
            saved_ns += parts.map(saved).max().unwrap_or(0);
        }
    }
    assert!(in_parts > 10 && saved_ns > 30, "{in_parts} boxes of parts, {saved_ns} ns");
    assert!(by_ring > 0, "while parts waited, the ring's plan held");

    // With a budget of time a ring's plan is the front of one factor.
    let budget = Tolerance { time_budget_us: Some(20.0), ..Tolerance::default() };
    let mut radar = asde(|_| ()).tolerating(budget);
    for scan in 1..=3 {
        radar.scan(&interval(scan, 1.0), &truth, &storm, &mut sink);
    }
    assert!(radar.boxes().len() > 5 && radar.boxes().iter().all(|b| b.key.part == 0));
}

#[test]
fn a_target_that_is_not_displayed_is_simulated_for_nobody() {
    let far = asde(|_| ()).parameters().range_max_m + 500.0;
    let (dark, near) = (((far, 0.0), (0.0, 0.0)), ((900.0, 900.0), (0.0, 0.0)));
    let foot = ((60.0, 0.0), (0.0, 0.0));
    let scan = |targets: &[(Pair, Pair)], nearest_m: f64| {
        let mut radar = asde(|p| p.range_min_m = nearest_m);
        let truth = Straight::new(targets);
        radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut PlotSink::default());
        let shown: Vec<bool> = radar.placed().iter().map(|p| p.shown).collect();
        let levels = radar.plan().iter().map(|row| (row.effect, row.level)).collect::<Vec<_>>();
        (shown, levels)
    };
    let (shown, alone) = scan(&[near], 300.0);
    assert_eq!(shown, [true]);
    let (shown, levels) = scan(&[near, dark, foot], 300.0);
    assert_eq!(shown, [true, false, false]);
    assert_eq!(levels, alone, "nobody's plan changes");
    // Displayed at the foot of the tower: everything is exact for it.
    let (shown, levels) = scan(&[near, foot], 25.0);
    assert_eq!(shown, [true, true]);
    assert_ne!(levels, alone);
}

#[test]
fn rain_without_cells_costs_no_walk_through_cells() {
    let truth = Straight::new(&[((900.0, 900.0), (0.0, 0.0))]);
    let cost = |weather: &Weather| {
        let mut radar = asde(|_| ());
        radar.scan(&interval(1, 1.0), &truth, weather, &mut PlotSink::default());
        let effects = radar.boxes()[0].plan.effects.clone();
        let own = effects.iter().find(|e| e.effect == RadarEffect::RainAttenuation);
        let row = radar.plan().iter().find(|r| r.effect == RadarEffect::RainAttenuation.name());
        (own.expect("an effect").exact_ns, row.expect("a row").cost_ns)
    };
    let rain = Weather { rain_mm_per_h: 40.0, ..Weather::default() };
    let cell = crate::environment::RainCell {
        centre_m: Point2::new(500.0, 500.0),
        radius_m: 300.0,
        rain_mm_per_h: 80.0,
    };
    let (plain, row_ns) = cost(&rain);
    let (cells, _) = cost(&Weather { cells: vec![cell], ..rain });
    assert!(plain < 10 && row_ns < 10.0 && cells > 50, "{plain} ns, {row_ns} ns, {cells} ns");
}

#[test]
fn what_the_plan_of_a_box_leaves_out_is_not_evaluated() {
    let mut left_out = 0;
    for (n, tolerance) in [0.1, 0.5, 3.0].into_iter().enumerate() {
        let truth = Straight::new(&[((300.0 * (n + 1) as f64, 500.0), (0.0, 0.0))]);
        let tolerance = Tolerance { position_m: tolerance, ..Tolerance::default() };
        // Without false alarms, which are always quantised.
        let mut radar = asde(|p| p.pfa = 1e-12).tolerating(tolerance);
        radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut PlotSink::default());
        let tally = radar.tally().clone();
        let place = radar.placed()[0].place.expect("planned") as usize;
        for effect in &radar.boxes()[place].plan.effects {
            if effect.level == Level::Skipped {
                left_out += 1;
                assert_eq!(tally.of(effect.effect), 0, "{}", effect.effect.name());
            }
        }
    }
    assert!(left_out > 15, "{left_out}");
}

#[test]
fn a_shadow_is_named_for_what_casts_it() {
    let mut truth = Straight::new(&[((0.9, 1000.0), (0.0, 0.0)), ((0.0, 1200.0), (0.0, 0.0))]);
    truth.class.aircraft = true;
    truth.class.shape = crate::sensors::radar::sample_shapes::of(true);
    (truth.class.length_m, truth.class.span_m, truth.class.height_m) = (37.6, 35.8, 11.8);
    let corner = |x: f64, y: f64| Point2::new(x, y);
    let hangar = Building {
        name: "hangar".into(),
        footprint_m: vec![corner(-9.0, 600.0), corner(9.0, 600.0), corner(9.0, 620.0)],
        height_m: 11.0,
        facade: &crate::environment::surface::MATERIALS[5],
    };
    let shadows_of_last = |buildings: Vec<Building>| -> Vec<&'static str> {
        let low = |p: &mut AsdeParameters| {
            (p.antenna_height_m, p.peak_power_w) = (15.0, 1e8);
        };
        let mut radar = asde(low).among(buildings.into());
        let mut out = PlotSink { explain: true, ..PlotSink::default() };
        radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut out);
        let last = out.causes.iter().find(|c| c.key == Some(2)).expect("the one behind is seen");
        let shadows = last.effects.iter().filter(|e| e.effect.ends_with("shadow"));
        shadows.inspect(|e| assert!(e.value < 0.0, "{e:?}")).map(|e| e.effect).collect()
    };
    assert_eq!(shadows_of_last(vec![]), ["aircraft shadow"]);
    assert_eq!(shadows_of_last(vec![hangar]), ["building shadow", "aircraft shadow"]);
}

#[test]
fn what_refines_a_reflection_that_is_left_out_explains_nothing() {
    let truth = Straight::new(&[((0.0, 900.0), (0.0, 0.0))]);
    let refining = ["lobing", "roughness", "reflected polarisation", "earth curvature"];
    let told = |levels: RadarLevels| -> Vec<&'static str> {
        let mut radar = asde(|p| p.polarisation = Polarisation::Vertical).at_levels(levels);
        let mut out = PlotSink { explain: true, ..PlotSink::default() };
        radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut out);
        out.causes[0].effects.iter().map(|e| e.effect).collect()
    };
    let with = told(RadarLevels::EXACT);
    assert!(refining.iter().all(|word| with.contains(word)), "{with:?}");
    let mut levels = RadarLevels::EXACT;
    levels.budget.reflection = crate::sensors::radar::equation::Reflection::None;
    let without = told(levels);
    assert!(!refining.iter().any(|word| without.contains(word)), "{without:?}");
}

/// What only buildings or company bring is planned exactly where these are, and skipped where they are not.
#[test]
fn what_takes_buildings_or_company_is_planned_where_they_are() {
    let hall = Building {
        name: "hall".into(),
        footprint_m: [(600.0, 0.0), (620.0, 0.0), (620.0, 30.0)]
            .map(|(x, y)| Point2::new(x, y))
            .to_vec(),
        height_m: 9.0,
        facade: &crate::environment::surface::MATERIALS[5],
    };
    for built in [false, true] {
        for (apart_m, close) in [(400.0, false), (2.0, true)] {
            let targets = [((900.0, 900.0), (0.0, 0.0)), ((900.0 + apart_m, 900.0), (0.0, 0.0))];
            let buildings = if built { vec![hall.clone()] } else { Vec::new() };
            let mut radar = asde(|_| ()).among(buildings.into());
            radar.scan(
                &interval(1, 1.0),
                &Straight::new(&targets),
                &Weather::default(),
                &mut PlotSink::default(),
            );
            for (effect, there) in [
                (RadarEffect::BuildingShadow, built),
                (RadarEffect::Merging, close),
                (RadarEffect::AircraftShadow, false),
            ] {
                let row = radar.plan().iter().find(|r| r.effect == effect.name()).expect("a row");
                let wanted = if there { (Level::Exact, 1.0) } else { (Level::Skipped, 0.0) };
                assert_eq!((row.level, row.bound), wanted, "{} {built} {apart_m}", row.effect);
            }
        }
    }
}
