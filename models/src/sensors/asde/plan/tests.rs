//! The bounds against random places of random boxes, and the planner's rules.

use super::bounds::{BoxGrid, Place};
use super::boxes::{band_m, part_m, ring_m};
use super::class::ClassFacts;
use super::outcome::{BoxLoss, BoxOutcome, Detection, LeftOut};
use super::planner::Planner;
use super::reflection::Refinement;
use crate::draw::{DrawKey, Purpose, uniform};
use crate::effects::{Level, Loss, Tolerance};
use crate::environment::surface::MATERIALS;
use crate::environment::{RainCell, Weather};
use crate::frames::Point2;
use crate::keys::Holds;
use crate::sensors::TargetClass;
use crate::sensors::asde::AsdeParameters;
use crate::sensors::radar::detection::{Detector, PdTable, Swerling, to_db};
use crate::sensors::radar::effects::{RadarEffect, VALUE_KEYS, VALUES};
use crate::sensors::radar::equation::{BudgetLevels, Echo, Polarisation, Reflection};
use crate::sensors::radar::extended::{ExtentLevel, centroid};
use crate::sensors::radar::levels::RadarLevels;
use rand::rngs::ChaCha8Rng;

struct Genes(ChaCha8Rng);

impl Genes {
    fn of(n: u64) -> Self {
        Self(DrawKey { run_seed: 77, sensor: 0, entity: n, scan: 0 }.rng(Purpose::Study))
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * uniform(&mut self.0)
    }

    fn scaled(&mut self, low: f64, high: f64) -> f64 {
        low * libm::exp(uniform(&mut self.0) * libm::log(high / low))
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[((uniform(&mut self.0) * from.len() as f64) as usize).min(from.len() - 1)]
    }
}

fn class(kind: usize) -> TargetClass {
    let (aircraft, length_m, span_m, height_m, rcs_m2) = [
        (false, 4.8, 2.0, 1.9, 3.0),
        (false, 12.0, 3.0, 3.7, 10.0),
        (true, 8.3, 11.0, 2.7, 2.0),
        (true, 37.6, 35.8, 11.8, 15.0),
        (true, 70.7, 64.4, 19.4, 60.0),
    ][kind];
    let shape = crate::sensors::radar::sample_shapes::of(aircraft);
    TargetClass { designator: "T".into(), aircraft, length_m, span_m, height_m, rcs_m2, shape }
}

/// A random radar in random weather.
fn radar_and_weather(g: &mut Genes) -> (AsdeParameters, Weather) {
    let mut p = AsdeParameters::ku_band();
    let any_ghz = g.between(5.0, 17.0);
    p.carrier_ghz = g.pick(&[16.0, 9.0, any_ghz]);
    p.polarisation =
        g.pick(&[Polarisation::Horizontal, Polarisation::Vertical, Polarisation::Circular]);
    (p.elevation_beamwidth_deg, p.tilt_deg) = (g.scaled(0.8, 60.0), g.between(-1.0, 10.0));
    p.csc2_limit_deg = g.pick(&[None, Some(31.0)]);
    p.antenna_height_m = g.scaled(5.0, 110.0);
    p.assumed_height_m = p.assumed_height_m.min(p.antenna_height_m);
    p.roughness_m = g.pick(&[0.0, 0.001, 0.003, 0.02, 0.05]);
    p.surface = &MATERIALS[g.pick(&[0, 1, 2, 3, 4, 5])];
    p.peak_power_w *= g.scaled(1e-3, 10.0);
    p.frequency_agile = g.pick(&[true, false]);
    let weather = Weather {
        rain_mm_per_h: g.pick(&[0.0, 1.0, 16.0, 100.0]),
        visibility_m: g.pick(&[f64::INFINITY, 400.0, 50.0]),
        film_mm: g.pick(&[0.0, 0.1, 0.5, 5.0]),
        vapour_g_per_m3: g.between(1.0, 20.0),
        ..Weather::default()
    };
    for key in VALUE_KEYS.iter().copied().flatten() {
        if let Holds::Number { least, most } = key.holds {
            p.own.insert(key.word, g.between(least, most));
        }
    }
    (p, weather)
}

/// A level of every effect of the budget, exact or left out at random.
fn some_levels(g: &mut Genes) -> BudgetLevels {
    let mut levels = RadarLevels::EXACT;
    for effect in [
        RadarEffect::Lobing,
        RadarEffect::Roughness,
        RadarEffect::WaterFilm,
        RadarEffect::ReflectedPolarisation,
        RadarEffect::RoundEarth,
    ] {
        if g.pick(&[true, false]) {
            levels = levels.with(effect, Level::Skipped);
        }
    }
    levels.budget
}

#[test]
fn no_effect_changes_more_than_its_bound_anywhere_in_its_box() {
    let boxes = 400;
    let mut tightness: Vec<(&str, Vec<f64>)> = Vec::new();
    let mut failed: Vec<String> = Vec::new();
    for n in 0..boxes {
        let g = &mut Genes::of(n);
        let (p, weather) = radar_and_weather(g);
        let radar = p.radar();
        let air = radar.air(&weather);
        let class = class(g.pick(&[0, 1, 2, 3, 4]));
        let facts = ClassFacts::of(&class);
        let (ring, band) = (g.pick(&[0, 1, 3, 5, 7, 9, 10]), g.pick(&[0, 0, 0, 1, 3, 9, 13]));
        let (low, high) = band_m(band);
        let half = 0.5 * class.height_m;
        let height_m =
            if band == 0 { (half, half.max(high)) } else { (low.max(half), high.max(half)) };
        let ground_m = part_m(ring, g.pick(&[0, 0, 1, 2, 3, 4]));
        let place = Place { ground_m, height_m, rain_on_way: false, rain_here: false };
        let correlation = p.rain_correlation();
        let bounds = BoxGrid::new(&radar, &air, correlation, &facts, place).bounds(Refinement::ANY);
        let mut worst: Vec<(&str, f64, f64)> = Vec::new();
        let mut note = |name: &'static str, found: f64, bound: f64| match worst
            .iter_mut()
            .find(|w| w.0 == name)
        {
            Some(w) => w.1 = w.1.max(found),
            None => worst.push((name, found, bound)),
        };
        for _ in 0..300 {
            let d = g.scaled(place.ground_m.0, place.ground_m.1);
            let h = g.between(height_m.0, height_m.1);
            let view = g.between(-std::f64::consts::PI, std::f64::consts::PI);
            let view = if g.pick(&[true, false, false, false]) {
                std::f64::consts::FRAC_PI_2
            } else {
                view
            };
            let echo = |rcs_m2| Echo { ground_m: d, height_m: h, extent_m: class.height_m, rcs_m2 };
            let to = Point2::new(0.0, d);
            let budget = |levels: &BudgetLevels, rcs| {
                radar.budget(&air, levels, &echo(rcs), Point2::origin(), to)
            };
            let scnr = |levels: &BudgetLevels, corr: f64| {
                let b = budget(levels, class.rcs_m2);
                to_db(b.signal_w / (b.noise_w + corr * b.rain_w + b.ground_w + b.other_w))
            };
            let exact = BudgetLevels::EXACT;
            let c = centroid(ExtentLevel::Centroid, &class, view).expect("an echo");
            let own = budget(&exact, c.rcs_m2);
            let ratio = own.signal_w
                / (own.noise_w + correlation * own.rain_w + own.ground_w + own.other_w);
            note("least ratio", to_db(bounds.ratio.low) - to_db(ratio), 0.0);
            note("largest ratio", to_db(own.scnr()) - to_db(bounds.ratio.high), 0.0);
            for corr in [1.0, correlation] {
                let all = scnr(&exact, corr);
                let without = |change: &dyn Fn(&mut BudgetLevels)| {
                    let mut levels = exact;
                    change(&mut levels);
                    scnr(&levels, corr) - all
                };
                let none = RadarLevels::EXACT;
                let off = |e| none.with(e, Level::Skipped).budget;
                note("rain", without(&|l| *l = off(RadarEffect::RainAttenuation)), bounds.rain_db);
                for ((effect, value), losses) in VALUES.iter().zip(&bounds.values) {
                    for level in std::iter::once(Level::Skipped).chain(value.worth()) {
                        let (at, loss) = (none.with(*effect, level).budget, losses[level as usize]);
                        let found = without(&|l| *l = at);
                        if level == Level::Skipped {
                            note(value.name, found, loss.raises_db);
                        }
                        note("a value: raises", found - loss.raises_db, 0.0);
                        note("a value: lowers", -found - loss.lowers_db, 0.0);
                        let moved = |l: &BudgetLevels| budget(l, 1.0).moved_m;
                        let ((x, y), (u, v)) = (moved(&exact), moved(&at));
                        note("a value: moves", libm::hypot(x - u, y - v) - loss.fixed_m, 0.0);
                    }
                }
                note("ground", without(&|l| l.ground_echo = false), bounds.ground_db);
                note(
                    "rain clutter",
                    without(&|l| *l = off(RadarEffect::RainClutter)),
                    bounds.rain_clutter_db,
                );
                let dry = off(RadarEffect::RainClutter);
                let both = BudgetLevels { ground_echo: false, ..dry };
                note("clutter", without(&|l| *l = both), bounds.clutter_db);
                let line = none.with(RadarEffect::RainAttenuation, Level::Cheap).budget;
                if weather.rain_mm_per_h > 0.0 {
                    note("line high", without(&|l| *l = line), bounds.linear_db.0);
                    note("line low", -without(&|l| *l = line), bounds.linear_db.1);
                }
            }
            let reflected = |levels: &BudgetLevels| to_db(budget(levels, 1.0).propagation);
            let b = &bounds.reflection;
            let none = BudgetLevels { reflection: Reflection::None, ..exact };
            note("reflection high", reflected(&none) - reflected(&exact), b.reflection_db.0);
            note("reflection low", reflected(&exact) - reflected(&none), b.reflection_db.1);
            // Refinements with the others at any level.
            let others = some_levels(g);
            let with = |change: &dyn Fn(&mut BudgetLevels)| {
                let mut levels = others;
                change(&mut levels);
                reflected(&levels)
            };
            let lobes = with(&|l| l.reflection = Reflection::Extended);
            let mean = with(&|l| l.reflection = Reflection::Incoherent);
            note("lobing high", mean - lobes, b.lobing_db.0);
            note("lobing low", lobes - mean, b.lobing_db.1);
            for (name, effect, refinement) in [
                ("roughness", RadarEffect::Roughness, Refinement::Roughness),
                ("film", RadarEffect::WaterFilm, Refinement::Film),
                ("polarisation", RadarEffect::ReflectedPolarisation, Refinement::Polarisation),
                ("curvature", RadarEffect::RoundEarth, Refinement::Curvature),
            ] {
                let base = RadarLevels { budget: others, ..RadarLevels::EXACT };
                let on = base.with(effect, Level::Exact).budget;
                let off = base.with(effect, Level::Skipped).budget;
                let found = (reflected(&on) - reflected(&off)).abs();
                note(name, found, b.refined_db[refinement as usize]);
                let q = |l: &BudgetLevels| budget(l, 1.0).reflected;
                let moved = (q(&on) - q(&off)).abs();
                note("amplitude", moved - b.change[refinement as usize], 0.0);
            }
        }
        for (name, found, bound) in worst {
            if found > bound + 1e-6 + 1e-6 * bound.abs() {
                failed.push(format!("box {n} ring {ring} band {band}: {name} {found} > {bound}"));
            }
            if found > 1e-3 && bound.is_finite() {
                match tightness.iter_mut().find(|t| t.0 == name) {
                    Some(t) => t.1.push(bound / found),
                    None => tightness.push((name, vec![bound / found])),
                }
            }
        }
    }
    for (name, ratios) in &mut tightness {
        ratios.sort_by(f64::total_cmp);
        let at = |share: f64| ratios[((ratios.len() - 1) as f64 * share) as usize];
        println!(
            "{name}: {} boxes, bound/found median {:.2}, 95 % {:.2}",
            ratios.len(),
            at(0.5),
            at(0.95)
        );
        // Nor is a bound wide: in half of the boxes it is at most so many times what was found there.
        let most = match *name {
            "gases" | "fog" => 1.05,
            "rain" | "clutter" => 1.1,
            "ground" | "line low" => 1.2,
            "rain clutter" => 1.3,
            "line high" => 1.5,
            "reflection low" | "lobing high" | "lobing low" => 1.6,
            "roughness" | "film" | "polarisation" => 4.5,
            "curvature" => 6.0,
            _ => 25.0,
        };
        assert!(at(0.5) <= most, "{name}: {} times what was found", at(0.5));
    }
    assert!(failed.is_empty(), "{} beyond: {failed:#?}", failed.len());
}

/// Cells on the way, of any size: nothing that they take is more than the bound, and the bound is not wide.
#[test]
fn rain_in_cells_takes_no_more_than_its_bound_says() {
    let mut nearest = [0.0f64; 3];
    for n in 0..300 {
        let g = &mut Genes::of(50_000 + n);
        let (p, _) = radar_and_weather(g);
        let radar = p.radar();
        let ring = g.pick(&[3, 5, 7, 9]);
        let (near_m, far_m) = ring_m(ring);
        let cells = (0..g.pick(&[1, 1, 2, 4])).map(|_| RainCell {
            centre_m: Point2::new(0.0, far_m * g.between(0.0, 1.0)),
            radius_m: g.scaled(20.0, 5_000.0),
            rain_mm_per_h: g.scaled(5.0, 150.0),
        });
        let cells: Vec<RainCell> = cells.collect();
        let rain_mm_per_h = g.pick(&[0.0, 0.0, 4.0]);
        let weather = Weather { rain_mm_per_h, cells, ..Weather::default() };
        let air = radar.air(&weather);
        let class = class(g.pick(&[0, 1, 3]));
        let facts = ClassFacts::of(&class);
        let half = 0.5 * class.height_m;
        let place = Place {
            ground_m: (near_m, far_m),
            height_m: (half, half.max(band_m(0).1)),
            rain_on_way: true,
            rain_here: true,
        };
        let correlation = p.rain_correlation();
        let bounds = BoxGrid::new(&radar, &air, correlation, &facts, place).bounds(Refinement::ANY);
        for _ in 0..40 {
            let d = g.scaled(near_m, far_m);
            let h = g.between(place.height_m.0, place.height_m.1);
            let echo =
                Echo { ground_m: d, height_m: h, extent_m: class.height_m, rcs_m2: class.rcs_m2 };
            let budget = |levels: RadarLevels| {
                let to = Point2::new(0.0, d);
                radar.budget(&air, &levels.budget, &echo, Point2::origin(), to)
            };
            let exact = RadarLevels::EXACT;
            // Where a cell is over the target, its echo is in the bound of what rain returns.
            let (with, without) =
                (budget(exact), budget(exact.with(RadarEffect::RainClutter, Level::Skipped)));
            let raised = to_db(without.scnr() / with.scnr());
            assert!(raised <= bounds.rain_clutter_db + 1e-6, "{n}: {raised} of {bounds:?}");
            nearest[2] = nearest[2].max(raised / bounds.rain_clutter_db.max(1e-3));
            for level in [Level::Middle, Level::Exact] {
                let with = budget(exact.with(RadarEffect::RainAttenuation, level));
                let dry = budget(exact.with(RadarEffect::RainAttenuation, Level::Skipped));
                // What the way there and back takes of the signal.
                let lost = to_db(dry.signal_w / with.signal_w);
                let most = 2.0 * air.most_rain_db(with.range_m, with.range_m / d);
                assert!(lost <= most * (1.0 + 1e-9) + 1e-9, "{n}: {lost} of {most} dB");
                nearest[0] = nearest[0].max(lost / most);
                if level == Level::Exact {
                    // What leaving it out does to the ratio.
                    let raised = to_db(dry.scnr()) - to_db(with.scnr());
                    assert!(raised <= bounds.rain_db + 1e-6, "{n}: {raised} of {bounds:?}");
                    nearest[1] = nearest[1].max(raised / bounds.rain_db);
                }
            }
        }
    }
    // A bound of half the size would be broken.
    assert!(nearest[0] > 0.99 && nearest[1] > 0.6 && nearest[2] > 0.6, "{nearest:?}");
}

#[test]
fn no_aspect_is_beyond_what_the_class_says() {
    for kind in 0..5 {
        let class = class(kind);
        let facts = ClassFacts::of(&class);
        let g = &mut Genes::of(1000 + kind as u64);
        for _ in 0..20_000 {
            let view = g.between(-std::f64::consts::PI, std::f64::consts::PI);
            let c = centroid(ExtentLevel::Centroid, &class, view).expect("an echo");
            let aspect = c.rcs_m2 / class.rcs_m2;
            assert!(aspect >= facts.aspect.0 && aspect <= facts.aspect.1, "{kind} at {view}");
            assert!(
                libm::hypot(c.bias_along_m, c.bias_across_m) <= facts.bias_m,
                "{kind} at {view}"
            );
            assert!(c.glint_along_m >= facts.along_m.0 && c.glint_along_m <= facts.along_m.1);
            assert!(c.glint_across_m >= facts.across_m.0 && c.glint_across_m <= facts.across_m.1);
        }
    }
}

#[test]
fn a_tolerance_of_nothing_leaves_out_nothing_that_is_there() {
    let p = AsdeParameters::ku_band();
    let radar = p.radar();
    let air = radar.air(&Weather { rain_mm_per_h: 10.0, film_mm: 0.5, ..Weather::default() });
    let detector = Detector::new(p.pulses_summed(), p.pfa);
    let table = PdTable::new(&detector, Swerling::Steady);
    let facts = ClassFacts::of(&class(3));
    let place =
        Place { ground_m: ring_m(5), height_m: (5.9, 5.9), rain_on_way: false, rain_here: false };
    let grid = BoxGrid::new(&radar, &air, p.rain_correlation(), &facts, place);
    let bounds = grid.bounds(Refinement::ANY);
    let detection = Detection {
        parameters: &p,
        table: &table,
        steps: Planner::steps(),
        required: 20.0,
        least_ratio: 3.0,
    };
    let outcome = BoxOutcome::new(&detection, &facts, &bounds, 500.0, &Tolerance::EXACT);
    let losses = [
        BoxLoss { loss: Loss::raises(1e-9), ..BoxLoss::default() },
        BoxLoss { loss: Loss::moves(1e-9), ..BoxLoss::default() },
        BoxLoss { loss: Loss { own_m2: 1e-18, ..Loss::NONE }, ..BoxLoss::default() },
        BoxLoss { out: LeftOut { range: true, ..LeftOut::default() }, ..BoxLoss::default() },
        BoxLoss { loss: Loss { false_plots: 1e-9, ..Loss::NONE }, ..BoxLoss::default() },
    ];
    for loss in losses {
        let effect = outcome.effect(&loss, &Tolerance::EXACT, false);
        assert_eq!(effect.share(&Tolerance::EXACT, 0.0), f64::INFINITY, "{loss:?}");
    }
    let nothing = outcome.effect(&BoxLoss::default(), &Tolerance::EXACT, false);
    assert_eq!(nothing.share(&Tolerance::EXACT, 0.0), 0.0);
    // Not-a-number is not tolerated by anything.
    let unknown = BoxLoss { loss: Loss::raises(f64::NAN), ..BoxLoss::default() };
    let effect = outcome.effect(&unknown, &Tolerance::default(), false);
    assert!(effect.share(&Tolerance::default(), 1.0) > 1.0);
}

#[test]
fn the_quick_test_of_a_choice_says_what_the_whole_one_says() {
    let (mut held, mut broken) = (0, 0);
    for n in 0..3000 {
        let g = &mut Genes::of(90_000 + n);
        let (p, weather) = radar_and_weather(g);
        let (radar, detector) = (p.radar(), Detector::new(p.pulses_summed(), p.pfa));
        let table = PdTable::new(&detector, g.pick(&[Swerling::Steady, Swerling::One]));
        let air = radar.air(&weather);
        let facts = ClassFacts::of(&class(g.pick(&[0, 3])));
        let half = 0.5 * facts.class.height_m;
        let ground_m = ring_m(g.pick(&[1, 4, 7]));
        let place =
            Place { ground_m, height_m: (half, half), rain_on_way: false, rain_here: false };
        let grid = BoxGrid::new(&radar, &air, p.rain_correlation(), &facts, place);
        let bounds = grid.bounds(Refinement::ANY);
        let detection = Detection {
            parameters: &p,
            table: &table,
            steps: Planner::steps(),
            required: 20.0,
            least_ratio: 3.0,
        };
        let track_m = g.pick(&[None, Some(0.05)]);
        let tolerance = Tolerance { track_m, ..Tolerance::default() };
        let outcome = BoxOutcome::new(&detection, &facts, &bounds, ground_m.0, &tolerance);
        for _ in 0..20 {
            let some = |g: &mut Genes, low: f64, high: f64| {
                if g.pick(&[true, false]) { g.scaled(low, high) } else { 0.0 }
            };
            let loss = Loss {
                raises_db: some(g, 1e-3, 3.0),
                lowers_db: some(g, 1e-3, 3.0),
                fixed_m: some(g, 1e-3, 0.3),
                odds: some(g, 1e-4, 0.03),
                false_plots: some(g, 1e-5, 0.03),
                ..Loss::NONE
            };
            let loss = Loss { raises_db: g.pick(&[loss.raises_db, f64::NAN]), ..loss };
            let out = LeftOut { range: g.pick(&[true, false]), ..LeftOut::default() };
            let loss = BoxLoss { loss, out };
            let share = |quick| outcome.effect(&loss, &tolerance, quick).share(&tolerance, 0.01);
            let limit = g.pick(&[0.5, 1.0, 2.0]);
            let (quick, whole) = (share(true), share(false));
            assert!(
                quick.is_nan() || whole.is_nan() || quick >= whole * (1.0 - 1e-9),
                "{n}: {loss:?}"
            );
            // What rounding decides is left open.
            if (quick - limit).abs() < 1e-9 || (whole - limit).abs() < 1e-9 {
                continue;
            }
            let fits = outcome.fits(&loss, &tolerance, 0.01, limit);
            assert_eq!(fits, quick <= limit || whole <= limit, "{n}: {loss:?} {quick} {whole}");
            if fits { held += 1 } else { broken += 1 }
        }
    }
    assert!(held > 2000 && broken > 2000, "{held} held, {broken} broken");
}

#[test]
fn so_many_classes_are_known_and_those_that_are_known_are_found_again() {
    let mut planner = Planner::default();
    let of = |n: u32| TargetClass { length_m: 5.0 + 0.01 * f64::from(n), ..class(0) };
    for n in 0..1_000 {
        assert!(!planner.is_full(), "{n}");
        assert_eq!(planner.class(&of(n), 7), Some(n as u16));
    }
    assert!(planner.is_full());
    assert_eq!(planner.class(&of(1_000), 7), None, "there are too many");
    for (n, guess) in [(0, 999), (999, 999), (500, 60_000)] {
        assert_eq!(planner.class(&of(n), guess), Some(n as u16));
        assert_eq!(planner.facts(n as u16).class.length_m, of(n).length_m);
    }
}
