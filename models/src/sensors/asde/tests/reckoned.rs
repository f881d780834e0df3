//! What a plan reckons with, one by one: without it no comparison of runs of a usual scene is off.

use super::*;
use crate::effects::outcome::{AxisShift, MEAN_ABS, tail};
use crate::effects::{Loss, Tolerance};
use crate::environment::RainCell;
use crate::frames::{Point2, Vector2};
use crate::sensors::asde::plan::Planner;
use crate::sensors::asde::plan::bounds::{BoxBounds, BoxGrid, Place};
use crate::sensors::asde::plan::boxes::{Key, ring, sector};
use crate::sensors::asde::plan::class::ClassFacts;
use crate::sensors::asde::plan::outcome::{BoxLoss, BoxOutcome, Detection, LeftOut};
use crate::sensors::asde::plan::reflection::Refinement;
use crate::sensors::radar::shape::Shape;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// A body without extent: nothing but thermal errors spreads its plots.
fn point() -> TargetClass {
    let shape = Shape::point();
    let class = Straight::new(&[]).class;
    TargetClass { length_m: 0.0, span_m: 0.0, rcs_m2: 10.0, shape, ..class }
}

/// The outcome test of a point on the ground between two distances, and its bounds.
fn outcome_of<R>(
    radar: &Asde,
    ground_m: (f64, f64),
    then: impl FnOnce(&BoxOutcome<'_>, &BoxBounds) -> R,
) -> R {
    let facts = ClassFacts::of(&point());
    let air = radar.air(&Weather::default());
    let half = 0.5 * facts.class.height_m;
    let place = Place { ground_m, height_m: (half, half), rain_on_way: false, rain_here: false };
    let bounds = BoxGrid::new(&radar.radar, &air, radar.rain_correlation, &facts, place)
        .bounds(Refinement::ANY);
    let detection = Detection {
        parameters: &radar.parameters,
        table: &radar.table,
        steps: Planner::steps(),
        required: radar.required,
        least_ratio: radar.least_ratio,
    };
    let tolerance = Tolerance::default();
    then(&BoxOutcome::new(&detection, &facts, &bounds, ground_m.0, &tolerance), &bounds)
}

fn loses(loss: Loss) -> BoxLoss {
    BoxLoss { loss, ..BoxLoss::default() }
}

#[test]
fn plans_of_one_weather_are_not_those_of_another() {
    let near = |r: f64| Vector2::new(0.6 * r, 0.8 * r);
    let targets: Vec<(Pair, Pair)> = (0..12)
        .map(|i| 300.0 * libm::exp(0.2 * f64::from(i)))
        .map(|r| ((near(r).x, near(r).y), (0.0, 0.0)))
        .collect();
    let truth = Straight::new(&targets);
    let wet = Weather { rain_mm_per_h: 25.0, film_mm: 1.0, ..Weather::default() };
    let after = |weathers: &[&Weather]| {
        let mut radar = asde(|_| ());
        for (scan, weather) in (1..).zip(weathers.iter().flat_map(|w| [w; 8])) {
            radar.scan(&interval(scan, 1.0), &truth, weather, &mut PlotSink::default());
        }
        let plans = radar.boxes().iter().map(|b| (b.key, b.plan.clone()));
        plans.collect::<BTreeMap<Key, _>>()
    };
    let dry = Weather::default();
    let fresh = after(&[&wet]);
    let other = after(&[&dry]);
    assert!(fresh.len() >= 5 && fresh != other, "{} boxes", fresh.len());
    assert_eq!(fresh, after(&[&dry, &wet]));
    assert_eq!(other, after(&[&wet, &dry]));
}

#[test]
fn a_standing_echo_may_lie_on_the_edge_of_a_step() {
    // Ten steps' tenths: thermal errors a tenth of a step and less.
    let radar = asde(|p| (p.range_step_m, p.azimuth_step_deg) = (5.0, 0.0));
    outcome_of(&radar, (400.0, 560.0), |outcome, bounds| {
        let sigma_m = radar.sigmas(bounds.ratio.high, 0.0).0;
        assert!(sigma_m < 0.2, "{sigma_m}");
        for moved_m in [1e-3, 1e-2] {
            // A fixed move over an edge: the density of the place there times the move, a whole step each time.
            let carried = moved_m / (sigma_m * (2.0 * PI).sqrt());
            let rms_m =
                outcome.effect(&loses(Loss::moves(moved_m)), &Tolerance::default(), false).rms_m;
            assert!(rms_m * rms_m >= 0.99 * 25.0 * carried.min(1.0), "{rms_m} m by {moved_m} m");
        }
    });
}

#[test]
fn a_move_by_draws_of_its_own_is_carried_by_steps_too() {
    for (own_m, step_m) in [(0.01, 0.17), (0.05, 1.0)] {
        let axis = AxisShift { own_m, step_m, factors: (MEAN_ABS, 1.0), ..AxisShift::default() };
        // Spread over the steps, a shift less than one is carried as often as it is of it.
        let exact_m2 = step_m * own_m * MEAN_ABS;
        let bound_m2 = axis.square_m2();
        assert!(bound_m2 >= exact_m2 && bound_m2 <= 1.05 * exact_m2 + 2.0 * own_m * own_m);
    }
}

#[test]
fn steps_beyond_the_tail_count_with_their_odds() {
    let step =
        AxisShift { fixed_m: 0.01, step_m: 1.0, factors: (MEAN_ABS, 1.0), ..AxisShift::default() };
    let odds = tail(&[step, AxisShift::default()], 0.5);
    assert!((0.01..0.011).contains(&odds), "{odds}");
    // Of both axes.
    let odds = tail(&[step, step], 0.5);
    assert!((0.02..0.022).contains(&odds), "{odds}");
    // A step that is short enough is no matter.
    assert_eq!(tail(&[AxisShift { step_m: 0.1, ..step }, AxisShift::default()], 0.5), 0.0);
}

#[test]
fn thermal_azimuths_left_out_take_their_coupling_along() {
    let rms_m = |coupling: f64| {
        let radar = asde(|p| p.reflection_coupling = coupling);
        let beam_rad = radar.radar.pattern.azimuth_rad;
        outcome_of(&radar, (2000.0, 2400.0), |outcome, bounds| {
            let out = LeftOut { azimuth: true, ..LeftOut::default() };
            let left = BoxLoss { loss: Loss::NONE, out };
            let effect = outcome.effect(&left, &Tolerance::default(), false);
            (effect.rms_m, coupling * beam_rad * bounds.reflection.most * 2000.0)
        })
    };
    let (without_m, _) = rms_m(0.0);
    let (with_m, coupled_m) = rms_m(0.3);
    assert!(coupled_m > 0.5 && with_m > without_m, "{coupled_m} m");
    assert!(with_m >= coupled_m, "{with_m} of {coupled_m} m");
}

#[test]
fn wide_beams_bend_the_range_by_what_is_left_out() {
    let rms_m = |beam_deg: f64| {
        let radar = asde(|p| {
            p.azimuth_beamwidth_deg = beam_deg;
            (p.range_step_m, p.azimuth_step_deg) = (0.0, 0.0);
        });
        let loss = loses(Loss { raises_db: 1e-4, ..Loss::NONE });
        outcome_of(&radar, (3000.0, 4000.0), |outcome, _| {
            outcome.effect(&loss, &Tolerance::default(), false).rms_m
        })
    };
    let (narrow_m, wide_m) = (rms_m(0.25), rms_m(6.0));
    // The conversion switches where the arc is bent by a tenth of the error: half of that, once, whatever is lost.
    assert!(narrow_m < 1e-4 && wide_m > 1e-3, "{narrow_m} and {wide_m} m");
}

#[test]
fn what_couples_into_the_azimuth_bends_the_range_too() {
    let rms_m = |coupled_rad: f64| {
        let radar = asde(|p| {
            (p.azimuth_beamwidth_deg, p.reflection_coupling) = (6.0, 0.1);
            (p.range_step_m, p.azimuth_step_deg) = (0.0, 0.0);
        });
        outcome_of(&radar, (3000.0, 4000.0), |outcome, _| {
            let loss = loses(Loss { coupled_rad, ..Loss::NONE });
            outcome.effect(&loss, &Tolerance::default(), false).rms_m
        })
    };
    // By itself it moves 4 µm across; the conversion may switch by it.
    let (nothing_m, coupled_m) = (rms_m(0.0), rms_m(1e-9));
    assert!(nothing_m == 0.0 && coupled_m > 1e-3, "{nothing_m} and {coupled_m} m");
}

#[test]
fn a_rain_cell_touches_every_box_that_it_reaches() {
    let radar = asde(|_| ());
    let mut wide = 0;
    for n in 0..60u32 {
        let of = f64::from(n);
        let (away_m, radius_m) = (700.0 + 67.0 * of, 150.0 + 37.0 * (of * 1.3 % 17.0));
        let (sin, cos) = libm::sincos(2.4 * of);
        let centre_m = Point2::new(sin, cos) * away_m;
        let cell = RainCell { centre_m, radius_m, rain_mm_per_h: 30.0 };
        let air = radar.air(&Weather { cells: vec![cell], ..Weather::default() });
        let seen: Vec<_> = radar.rain_seen(&air).collect();
        let mut sectors = std::collections::BTreeSet::new();
        for i in 0..400 {
            let (sin, cos) = libm::sincos(f64::from(i) * 2.399_963);
            let place_m =
                centre_m + Vector2::new(sin, cos) * (radius_m * (f64::from(i) / 400.0).sqrt());
            let sector = sector(Azimuth::of(place_m.coords).rad());
            sectors.insert(sector);
            let touches = |factor: f64| {
                seen[0].touches(sector, ring((place_m * factor).coords.norm_squared()))
            };
            assert_eq!(touches(1.0), (true, true), "{n}: {place_m:?}");
            assert!(touches(1.5).0, "{n}: behind {place_m:?} the rain is on the way");
        }
        wide += usize::from(sectors.len() >= 3);
    }
    assert!(wide > 5, "{wide} cells of three sectors and more");
}

#[test]
fn targets_share_the_false_plots_of_a_radar() {
    let radar = asde(|_| ());
    let facts = ClassFacts::of(&point());
    let whole = radar.tolerance.false_plots;
    for targets in [1u32, 2, 3, 12, 16, 17, 1000] {
        let size = libm::log2(f64::from(targets)).ceil() as u8;
        let key = Key {
            part: 0,
            class: 0,
            ring: 4,
            band: 0,
            rain_on_way: false,
            rain_here: false,
            mirrored: (1, size),
        };
        let (_, share) = radar.ghosts_in(&key, &facts);
        assert!(share * f64::from(targets) <= whole * (1.0 + 1e-12), "{targets}: {share}");
        assert!(share * f64::from(targets) > 0.49 * whole, "{targets}: {share}");
    }
}
