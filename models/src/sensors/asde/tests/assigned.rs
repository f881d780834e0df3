//! What the assignment remembers from scan to scan, sorts and cuts short is for speed alone: every target gets what it would
//! get by itself.

use super::*;
use crate::environment::RainCell;
use crate::frames::Point2;
use crate::frames::Point3;
use crate::sensors::asde::plan::boxes::{Key, band_m};
use crate::sensors::asde::plan::{Kind, PlannedBox};
use crate::sensors::radar::equation::BudgetLevels;
use crate::sensors::radar::{aspect, sample_shapes};

/// A target: class, place at time zero, velocity, and when it is there, s.
type Mover = (usize, Point3<f64>, Vector3<f64>, (f64, f64));

/// Targets of several classes that come, move and go.
struct Crowd {
    classes: Vec<TargetClass>,
    movers: Vec<Mover>,
}

impl Crowd {
    /// On a spiral from `near_m` outwards, with `count` turns and pairs of its own.
    fn new(count: usize, near_m: f64) -> Self {
        let class = |aircraft, length_m: f64, shape| TargetClass {
            designator: "T".into(),
            aircraft,
            length_m,
            span_m: 0.9 * length_m,
            height_m: 0.3 * length_m,
            rcs_m2: 10.0,
            shape,
        };
        let classes = vec![
            class(false, 5.0, sample_shapes::of(false)),
            class(true, 38.0, sample_shapes::of(true)),
            class(true, 70.0, sample_shapes::of(true)),
        ];
        let mover = |i: usize| {
            let of = i as f64;
            let (sin, cos) = libm::sincos(of * 2.4);
            let r = near_m * libm::exp(4.2 * of / count as f64);
            let up_m = if i % 9 == 4 { 3.0 * of } else { 0.0 };
            let (east, north) = libm::sincos(of * 1.7);
            let speed = [0.0, 12.0, 40.0][i % 3];
            let there = if i % 5 == 2 { (4.0 + (i % 7) as f64, 17.0) } else { (0.0, 1e9) };
            (
                i % 3,
                Point3::new(r * sin, r * cos, up_m),
                Vector3::new(east, north, 0.0) * speed,
                there,
            )
        };
        Self { classes, movers: (0..count).map(mover).collect() }
    }
}

impl Truth for Crowd {
    fn len(&self) -> usize {
        self.movers.len()
    }
    fn key(&self, index: usize) -> u64 {
        index as u64 + 1
    }
    fn class(&self, index: usize) -> &TargetClass {
        &self.classes[self.movers[index].0]
    }
    fn callsign(&self, _: usize) -> Callsign {
        Callsign::default()
    }
    fn address(&self, _: usize) -> Option<u32> {
        None
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        let (_, start, velocity_mps, (from, to)) = self.movers[index];
        let there = time.s() >= from && time.s() <= to;
        let position_m = start + velocity_mps * time.s();
        there.then_some(TargetState { position_m, velocity_mps, heading_rad: 0.7 })
    }
}

/// The box of a key among all, looked for one by one.
fn box_of(boxes: &[PlannedBox], key: &Key) -> Option<u32> {
    let place = |key: &Key| boxes.iter().position(|b| b.key == *key).map(|place| place as u32);
    place(key).or_else(|| place(&key.whole()))
}

/// Keys of targets, each made for it alone.
struct Alone<'a> {
    radar: &'a Asde,
    planner: plan::Planner,
    size: u8,
}

impl Alone<'_> {
    fn key(&mut self, class: &TargetClass, place_m: Point3<f64>) -> Option<Key> {
        let radar = self.radar;
        let cells: Vec<_> = radar.rain_seen(radar.air.as_ref().expect("scanned")).collect();
        let azimuth_rad = Azimuth::of(place_m.xy() - radar.site_m).rad();
        let sight = radar.sight(class, place_m, azimuth_rad);
        radar.key_of(&mut self.planner, &mut 0, &cells, self.size, class, &sight)
    }
}

/// Holds a scan against every target by itself; how many boxes, pairs across south and mirrored targets it saw.
fn held(radar: &Asde, truth: &Crowd, interval: &ScanInterval) -> [usize; 3] {
    let (work, boxes) = (&radar.work, radar.boxes());
    let assigned = &work.assignment;
    let reach_m = radar.parameters.range_max_m;
    let state = |i: usize| truth.at(i, interval.to).or_else(|| truth.at(i, interval.from));
    let near =
        |i: &usize| state(*i).is_some_and(|s| (s.position_m.xy() - radar.site_m).norm() < reach_m);
    let count = (0..truth.len()).filter(near).count().max(1);
    let size = if radar.facades.is_empty() { 0 } else { libm::log2(count as f64).ceil() as u8 };
    let mut seen = [0; 3];
    let mut targets = vec![0u32; boxes.len()];
    let mut alone = Alone { radar, planner: radar.planner.clone(), size };
    let mut key_of = |look: &Look| alone.key(truth.class(look.index), look.state.position_m);
    let keys: Vec<Option<Key>> = work.looks.iter().map(&mut key_of).collect();
    for (i, look) in work.looks.iter().enumerate() {
        let place_m = look.state.position_m;
        let key = keys[i];
        let place = key.and_then(|key| box_of(boxes, &key));
        assert_eq!(assigned.places[i], place, "look {i} at {place_m:?} of {key:?}");
        if let Some(key) = key {
            let (near, far) = key.ground_m();
            let d = (place_m.xy() - radar.site_m).norm();
            assert!(d > near * (1.0 - 1e-9) && d < far * (1.0 + 1e-9));
            let (low, high) = band_m(key.band);
            assert!(key.band == 0 || place_m.z >= low && place_m.z <= high);
        }
        // Any two whose echoes may lie in one cell.
        let bias_m = |k: usize| {
            let class = truth.class(work.looks[k].index);
            match keys[k] {
                Some(key) => radar.planner.facts(key.class).bias_m,
                None => 0.5 * (class.length_m + class.span_m),
            }
        };
        let slant_m = |k: usize| {
            let (p, class) = (work.looks[k].state.position_m, truth.class(work.looks[k].index));
            let down_m = radar.radar.antenna_m - p.z.max(0.5 * class.height_m);
            libm::hypot((p.xy() - radar.site_m).norm(), down_m)
        };
        let mut may = (false, false);
        for k in (0..work.looks.len()).filter(|k| work.looks[*k].index != look.index) {
            let apart_m = (slant_m(i) - slant_m(k)).abs();
            let turned = look.azimuth_rad - work.looks[k].azimuth_rad;
            let aside_rad = wrap_pi(turned).abs();
            let biased_m = bias_m(i) + bias_m(k);
            let d = |k: usize| (work.looks[k].state.position_m.xy() - radar.site_m).norm();
            let wide_rad = radar.radar.pattern.azimuth_rad + biased_m / d(i).min(d(k)).max(1.0);
            // Ranges are compared in steps: what these decide is left open.
            may.0 |= apart_m < radar.radar.cell_m + biased_m && aside_rad < wide_rad;
            may.1 |= apart_m < radar.radar.cell_m + biased_m + 0.5 && aside_rad < wide_rad;
            seen[1] += usize::from(may.0 && turned.abs() > 6.0);
        }
        let paired = assigned.paired[i];
        assert!(paired || !may.0, "look {i} shares a cell");
        assert!(!paired || may.1, "look {i} shares no cell");
        let levels = radar.planned_levels(assigned, i);
        match place {
            Some(place) if !paired => assert_eq!(levels, boxes[place as usize].plan.levels),
            _ => assert_eq!(levels, radar.base_levels()),
        }
        if look.number == 0 {
            let placed = assigned.placed.iter().find(|p| p.index == look.index).expect("placed");
            assert_eq!((placed.place, placed.paired), (place, paired));
            place.iter().for_each(|place| targets[*place as usize] += 1);
        }
    }
    seen[0] = targets.iter().filter(|n| **n > 0).count();
    assert_eq!(targets, boxes.iter().map(|b| b.targets).collect::<Vec<_>>());
    for index in 0..if radar.facades.is_empty() { 0 } else { truth.len() } {
        let at_end = truth.at(index, interval.to);
        let ghosts = at_end.is_some_and(|state| {
            let (class, place_m) = (truth.class(index), state.position_m);
            let Some(key) = alone.key(class, place_m) else { return true };
            let height_m = place_m.z.max(0.5 * class.height_m);
            let (antenna_m, wavelength_m) = (radar.radar.antenna_m, radar.radar.wavelength_m);
            let meets = |f: &Facade| f.ghost(antenna_m, place_m.xy(), height_m, wavelength_m);
            let mirrored = radar.facades.iter().any(|f| meets(f).is_some());
            assert_eq!(key.mirrored.0 > 0, mirrored, "target {index} at {place_m:?}");
            seen[2] += usize::from(mirrored);
            let exact = |place: u32| boxes[place as usize].plan.levels.ghosts;
            mirrored && box_of(boxes, &key).is_none_or(exact)
        });
        assert_eq!(assigned.ghosts[index], ghosts, "target {index}");
    }
    seen
}

fn metal_wall() -> Building {
    let corner = |x: f64, y: f64| Point2::new(300.0 + x, 250.0 + y);
    Building {
        name: "wall".into(),
        footprint_m: vec![
            corner(0.0, 0.0),
            corner(200.0, 0.0),
            corner(200.0, 30.0),
            corner(0.0, 30.0),
        ],
        height_m: 40.0,
        facade: crate::environment::surface::Material::named("metal").expect("a material"),
    }
}

#[test]
fn every_target_of_a_crowd_gets_what_it_would_get_by_itself() {
    let mut truth = Crowd::new(140, 60.0);
    // Pairs across south, where azimuths jump: near, far, and one at rest whose partner goes away.
    for (r, aside) in [(400.0, 1.0), (1500.0, 2.0), (3000.0, 4.0)] {
        for east in [-aside, aside] {
            let speed = if east > 0.0 { Vector3::new(0.3, -2.0, 0.0) } else { Vector3::zeros() };
            truth.movers.push((0, Point3::new(east, -r, 0.0), speed, (0.0, 1e9)));
        }
    }
    let cell = |east: f64| RainCell {
        centre_m: Point2::new(east, 600.0),
        radius_m: 500.0,
        rain_mm_per_h: 30.0,
    };
    let dry = Weather::default();
    let wet = Weather { rain_mm_per_h: 16.0, film_mm: 0.5, ..dry.clone() };
    for built in [false, true] {
        // Low before a high wall: it mirrors.
        let mut radar = asde(|p| p.antenna_height_m = if built { 15.0 } else { 60.0 });
        if built {
            radar = radar.among([metal_wall()].into());
        }
        let mut seen = [0; 3];
        for scan in 1..=24 {
            let weather = match scan {
                1..=9 => dry.clone(),
                // Cells that move are no new notice.
                10..=17 => Weather { cells: vec![cell(60.0 * scan as f64)], ..wet.clone() },
                _ => wet.clone(),
            };
            let interval = interval(scan, 1.0);
            radar.scan(&interval, &truth, &weather, &mut PlotSink::default());
            let now = held(&radar, &truth, &interval);
            (0..3).for_each(|i| seen[i] += now[i]);
        }
        assert!(seen[0] > 500 && seen[1] > 20, "{seen:?}");
        assert_eq!(seen[2] > 20, built, "{seen:?}");
    }
}

#[test]
fn levels_follow_the_budget_of_time_when_it_has_to_give_way() {
    let mut truth = Crowd::new(24, 150.0);
    truth.movers.iter_mut().for_each(|m| (m.2, m.3) = (Vector3::zeros(), (0.0, 1e9)));
    // Half of them go.
    truth.movers.iter_mut().step_by(2).for_each(|m| m.3 = (0.0, 6.5));
    let tolerance = Tolerance { time_budget_us: Some(3.2), ..Tolerance::default() };
    let mut radar = asde(|_| ()).tolerating(tolerance);
    let mut factors = Vec::new();
    for scan in 1..=10 {
        let interval = interval(scan, 1.0);
        radar.scan(&interval, &truth, &Weather::default(), &mut PlotSink::default());
        held(&radar, &truth, &interval);
        for (place, b) in (0u32..).zip(radar.boxes()) {
            assert_eq!(*radar.planner().levels(place), b.plan.levels, "scan {scan}: {:?}", b.key);
        }
        factors.push(radar.planner().factor());
    }
    let (crowded, sparse) = (factors[5], factors[9]);
    assert!(sparse < 0.7 * crowded, "{factors:?}");
}

#[test]
fn a_budget_of_time_counts_all_that_a_scan_simulates_and_says_where_it_is_not_reached() {
    // Far and alone, two beside each other, one at the foot of the tower that is in no box.
    let mut truth = Crowd::new(6, 300.0);
    let at = |x: f64, y: f64| Point3::new(x, y, 0.0);
    let places = [at(900.0, 0.0), at(0.0, 1500.0), at(-700.0, 0.0), at(-700.0, 3.0), at(60.0, 0.0)];
    truth.movers.truncate(places.len());
    for (i, mover) in truth.movers.iter_mut().enumerate() {
        *mover = (i % 2, places[i], Vector3::zeros(), (0.0, 1e9));
    }
    let fitted = |budget_us: f64| {
        let tolerance = Tolerance { time_budget_us: Some(budget_us), ..Tolerance::default() };
        let mut radar = asde(|p| p.range_min_m = 25.0).tolerating(tolerance);
        for scan in 1..=4 {
            let sink = &mut PlotSink::default();
            radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), sink);
        }
        let found = Sensor::fitted(&radar).expect("a budget");
        // What no factor changes: of the two and the one everything, of each what is around it.
        let mut ns = 0.0;
        let nobody = |p: &Placed| p.paired || p.place.is_none();
        assert!(radar.placed().iter().filter(|p| nobody(p)).count() == 3, "{:?}", radar.placed());
        for p in radar.placed() {
            let plan = p.place.map(|place| &radar.boxes()[place as usize].plan);
            match plan.filter(|_| !nobody(p)) {
                Some(plan) => ns += plan.cost_ns().0 as f64,
                None => ns += 200.0,
            }
        }
        assert!(found.cost_us > ns / 1000.0, "{found:?}: more than {ns} ns");
        assert_eq!(found.reached, found.cost_us <= budget_us, "{found:?}");
        assert_eq!(found.factor, radar.planner().factor());
        found
    };
    let (least, plenty) = (fitted(0.001), fitted(1000.0));
    assert!(!least.reached && plenty.reached);
    assert!(least.factor > 90.0 && plenty.factor < 0.1, "{least:?} {plenty:?}");
    // Just what it takes, and a nanosecond less.
    let (just, less) = (fitted(least.cost_us), fitted(least.cost_us - 0.001));
    assert!(just.reached && !less.reached && less.cost_us == least.cost_us, "{just:?} {less:?}");
}

#[test]
fn centres_of_echoes_come_from_a_table_where_its_loss_is_tolerated() {
    let truth = Crowd::new(24, 150.0);
    let planned = |position_m: f64| {
        let mut radar = asde(|_| ()).tolerating(Tolerance { position_m, ..Tolerance::default() });
        for scan in 1..=6 {
            radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut PlotSink::default());
        }
        radar
    };
    let radar = planned(0.1);
    let by_table = |b: &&PlannedBox| b.plan.levels.extent == ExtentLevel::Table;
    let found: Vec<_> = radar.boxes().iter().filter(by_table).collect();
    assert!(found.len() > radar.boxes().len() / 2, "{} of {}", found.len(), radar.boxes().len());
    for b in found {
        let loss = &b.plan.loss;
        assert!(loss.fixed_m >= aspect::ERROR_M && loss.own_m2 >= aspect::ERROR_M.powi(2));
        assert!(loss.raises_db >= aspect::ERROR_DB && loss.lowers_db >= aspect::ERROR_DB);
        let row = b.plan.effects.iter().find(|e| e.effect == RadarEffect::Extent).expect("a row");
        assert_eq!((row.kind, row.level), (Kind::Table, Level::Middle));
        assert!(row.loss.fixed_m == aspect::ERROR_M && row.shown.0 > 0.5, "{row:?}");
        assert!(b.plan.outcome.rms_m > 0.0 && row.cost_ns < row.exact_ns / 4);
    }
    // Half of what the table may be off.
    let strict = planned(0.5 * aspect::ERROR_M);
    assert!(!strict.boxes().is_empty() && strict.boxes().iter().filter(by_table).count() == 0);
}

/// The exact ratio of a target, detector's and formulas', dB.
fn ratio_db(radar: &Asde, air: &Air, class: &TargetClass, place_m: Point3<f64>) -> f64 {
    let height_m = place_m.z.max(0.5 * class.height_m);
    let ground_m = place_m.xy().coords.norm();
    let echo = Echo { ground_m, height_m, extent_m: class.height_m, rcs_m2: class.rcs_m2 };
    let levels = BudgetLevels::EXACT;
    let budget = radar.radar.budget(air, &levels, &echo, Point2::origin(), place_m.xy());
    to_db(budget.scnr())
}

#[test]
fn the_bounds_of_a_part_of_a_ring_are_those_of_its_own_distances() {
    // A point on a rough surface: the ratio falls with the distance, and hardly anything else moves it.
    let mut truth = Crowd::new(1, 150.0);
    truth.classes[0].shape = crate::sensors::radar::shape::Shape::point();
    (truth.classes[0].length_m, truth.classes[0].span_m) = (0.0, 0.0);
    let places = (0..160).map(|i| 500.0 * libm::exp(f64::from(i) * 0.0125));
    let mover = |d: f64| (0, Point3::new(0.0, d, 0.0), Vector3::zeros(), (0.0, 1e9));
    truth.movers = places.map(mover).collect();
    let weather = Weather { rain_mm_per_h: 20.0, ..Weather::default() };
    let mut tested = 0;
    for power in [0.1, 0.01, 1e-3] {
        let mut radar = asde(|p| {
            p.peak_power_w *= power;
            (p.roughness_m, p.range_step_m) = (0.05, 0.0);
        });
        for scan in 1..=20 {
            radar.scan(&interval(scan, 1.0), &truth, &weather, &mut PlotSink::default());
        }
        let air = radar.air(&weather);
        for placed in radar.placed() {
            let Some(found) = placed.place.map(|place| &radar.boxes()[place as usize]) else {
                continue;
            };
            let place_m = truth.movers[placed.index].1;
            let own_db = ratio_db(&radar, &air, &truth.classes[0], place_m);
            let (low, high) = found.plan.ratio_db;
            assert!(own_db > low - 1e-6 && own_db < high + 1e-6, "{own_db} dB in {found:?}");
            if found.key.part > 0 {
                tested += 1;
                // So narrow that the next part's would not hold the far end of this one.
                assert!(high - low < 6.0, "{low} to {high} dB");
            }
        }
    }
    assert!(tested > 40, "{tested} targets in parts");
}

#[test]
fn a_ring_whose_parts_are_planned_says_nothing_in_the_rows() {
    let storm = Weather { rain_mm_per_h: 20.0, film_mm: 0.5, ..Weather::default() };
    let mut told_apart = 0;
    for power in [0.1, 0.01, 1e-3] {
        for i in 0..16 {
            let d = 400.0 * libm::exp(f64::from(i) * 0.13);
            let truth = Straight::new(&[((0.0, d), (0.0, 0.0))]);
            let mut radar = asde(|p| p.peak_power_w *= power);
            for scan in 1..=3 {
                radar.scan(&interval(scan, 1.0), &truth, &storm, &mut PlotSink::default());
            }
            assert_eq!(radar.planner().waiting(), 0);
            let own = radar.placed()[0].place.map(|place| &radar.boxes()[place as usize]);
            let own = own.expect("planned");
            for row in radar.plan() {
                let of = |b: &PlannedBox| {
                    b.plan.effects.iter().find(|e| e.effect.name() == row.effect).map(|e| e.level)
                };
                let Some(level) = of(own) else { continue };
                assert_eq!(row.level, level, "{} at {d} m", row.effect);
                told_apart += usize::from(radar.boxes().iter().any(|b| of(b) > Some(level)));
            }
        }
    }
    assert!(told_apart > 5, "rings that are cut would show in {told_apart} rows");
}
