//! A car driven by a person among flights that behave: it goes where it is driven, everybody gives way to it, nobody touches it, the
//! rules raise the alert, and traffic goes on when it has left.

use models::airport::Airport;
use models::control::alert::Change;
use models::control::clearance::ClearanceKind;
use models::control::layout::Layout;
use models::control::parameters::Parameters;
use models::frames::{Azimuth, Point2, Vector2, wrap_pi};
use models::time::SimTime;
use models::traffic::core::{Core, Direction, Notice, Order, Phase, Wish};
use models::traffic::exact::Watch;
use models::traffic::outline::{Size, distance_m, outline};
use models::truth::route;
use scenarios::Scene;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

const CAR: Size = Size { length_m: 4.6, span_m: 1.9, aircraft: false };
const NAME: &str = "FOLLOW1";

fn loaded(airport: &str, stand: Option<&str>) -> Scene {
    loaded_with(airport, stand, "")
}

fn loaded_with(airport: &str, stand: Option<&str>, control: &str) -> Scene {
    let net = format!("airports/{airport}.groundnet.xml");
    let there = Path::new(env!("CARGO_MANIFEST_DIR")).join(&net).exists();
    let net = if there { format!("ground_network = \"{net}\"\n") } else { String::new() };
    let car = stand.map_or(String::new(), |stand| {
        format!("[[traffic]]\nkind = \"driven\"\ncallsign = \"{NAME}\"\ntype = \"FOLLOWME\"\nstand = \"{stand}\"\n")
    });
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = 4\nduration_s = 2400\n[airport]\nlayout = \"airports/{airport}.apt.dat\"\n{net}[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = 14\ndepartures_per_h = 14\n{car}[control]\nsees = \"truth\"\n{control}"
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("driven.toml");
    scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{airport}: {e}"))
}

/// Somebody who drives along a line, five inputs a second: wheels towards a place ahead on it, slower in bends, and stops at its end.
struct Driver {
    line: Vec<Point2<f64>>,
    next: usize,
    said: u64,
    arrived: bool,
}

impl Driver {
    fn along(airport: &Airport, nodes: &[usize]) -> Self {
        let ends: Vec<_> = nodes.iter().map(|n| airport.nodes[*n].position_m).collect();
        let mut line = vec![ends[0]];
        for pair in ends.windows(2) {
            let steps = ((pair[1] - pair[0]).norm() / 4.0).ceil().max(1.0) as usize;
            line.extend(
                (1..=steps).map(|k| pair[0] + (pair[1] - pair[0]) * (k as f64 / steps as f64)),
            );
        }
        Self { line, next: 0, said: 0, arrived: false }
    }

    fn say(&mut self, core: &mut Core, frame: i64, order: Order) {
        self.said += 1;
        let (effect_frame, flight) = (frame + 4, core.first_driven());
        let source = format!("driver {NAME}");
        core.notice(Notice { effect_frame, source, sequence: self.said, flight, order });
    }

    fn look(&mut self, core: &mut Core, frame: i64) {
        if self.said == 0 {
            self.say(core, frame, Order::Take);
        }
        if frame % 4 != 0 {
            return;
        }
        let now = core.at_wheel(0).expect("a car");
        let nose = now.at_m + Azimuth::from_rad(now.heading_rad).unit() * (0.4 * CAR.length_m);
        let ahead_m = 6.0 + 0.6 * now.speed_mps;
        while self.next + 1 < self.line.len() && (self.line[self.next] - nose).norm() < ahead_m {
            self.next += 1;
        }
        let to = self.line[self.next] - nose;
        let off = wrap_pi(Azimuth::of(to).rad() - now.heading_rad);
        let left_m = to.norm() + 4.0 * (self.line.len() - 1 - self.next) as f64;
        // Slow in the bend and before the next one: wheels take seconds from side to side.
        let later = self.line[(self.next + 8).min(self.line.len() - 1)] - self.line[self.next];
        let bend = match later.norm() > 1.0 {
            true => wrap_pi(Azimuth::of(later).rad() - Azimuth::of(to).rad()).abs(),
            false => 0.0,
        };
        let most_mps: f64 = match off.abs().max(bend) {
            x if x > 0.6 => 1.2,
            x if x > 0.2 => 2.5,
            _ => 11.0,
        };
        let wished_mps = most_mps.min((1.2 * left_m).sqrt());
        self.arrived |= left_m < 5.0;
        let throttle = if self.arrived { 0.0 } else { 1000.0 * wished_mps / 27.8 };
        // Onto the circle through the place ahead (pure pursuit), whose curvature is 2 sin(off)/distance.
        let sin_off = Azimuth::from_rad(off.clamp(-1.57, 1.57)).unit().x;
        let curvature = 2.0 * sin_off / to.norm().max(4.0);
        let sin = (0.58 * CAR.length_m * curvature).clamp(-0.9, 0.9);
        let steer_rad = Azimuth::of(Vector2::new(sin, (1.0 - sin * sin).sqrt())).rad();
        let wish = Wish {
            throttle: throttle as i16,
            brake: if self.arrived { 500 } else { 0 },
            steer: (1000.0 * steer_rad / 1.134).clamp(-1000.0, 1000.0) as i16,
        };
        self.say(core, frame, Order::Drive(wish));
    }
}

/// What came of a run.
struct Driven {
    core: Core,
    /// Kinds of alerts in which the car is a subject, by time of raising.
    alerts: Vec<(f64, String)>,
    touched: Vec<String>,
}

/// Steps a core, asks `person` each frame, and looks whom the car touches four times a second.
fn run(scene: &Scene, mut person: impl FnMut(&mut Core, i64)) -> Driven {
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let mut core = behaving.core(&scene.run, scene.run.seed).expect("with truth");
    let layout = Layout::of(&scene.airport.layout).with_network(&behaving.network);
    let mut watch = Watch::new(layout, Parameters::default(), false);
    let (mut alerts, mut touched) = (Vec::new(), Vec::new());
    for frame in 1..=scene.run.frames() as i64 + 72_000 {
        person(&mut core, frame);
        core.step(frame);
        let now = SimTime(frame * scene.run.frame.0);
        if frame % 20 == 0 {
            for (change, alert) in watch.scan(&core, now) {
                if *change == Change::Raised && alert.subjects().contains(NAME) {
                    alerts.push((now.s(), alert.condition.kind.word()));
                }
            }
        }
        if frame % 5 == 0 {
            let new = touches(&core)
                .filter(|who| touched.last().is_none_or(|t: &String| !t.ends_with(who)));
            touched.extend(new.map(|who| format!("{:.1} s: {who}", now.s())));
        }
        if frame % 1200 == 0 && core.measures_of_served() == core.flights().len() {
            break;
        }
    }
    Driven { core, alerts, touched }
}

fn touches(core: &Core) -> Option<String> {
    let car = core.state(core.first_driven())?;
    let own = outline(CAR, car.position_m.xy(), car.heading_rad);
    (0..core.flights().len()).find_map(|f| {
        let s = core.state(f).filter(|s| s.position_m.z < 3.0)?;
        let near = (s.position_m - car.position_m).norm() < 60.0;
        let theirs = outline(core.flights()[f].size, s.position_m.xy(), s.heading_rad);
        (near && distance_m(&own, &theirs) == 0.0).then(|| core.flights()[f].callsign.clone())
    })
}

/// Nodes on the runway that arrivals use, away from its ends, and the way there from the stand that is nearest by road.
fn onto_a_runway(scene: &Scene) -> (String, Vec<usize>, Vec<usize>) {
    let layout = &scene.airport.layout;
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let lands = behaving.flights.iter().find(|f| f.direction == Direction::Arrival);
    let runway = &behaving.network.runways[lands.expect("an arrival").runway.0];
    let on = |n: &usize| {
        let (place, across) = runway.place_m(layout.nodes[*n].position_m);
        (400.0..runway.length_m - 400.0).contains(&place) && across.abs() < 5.0
    };
    let near_any = |n: &usize| {
        behaving.network.runways.iter().any(|r| {
            let (place, across) = r.place_m(layout.nodes[*n].position_m);
            (-100.0..r.length_m + 100.0).contains(&place) && across.abs() < r.hold_distance_m + 20.0
        })
    };
    let mut best: Option<(f64, String, Vec<usize>)> = None;
    for stand in layout.stands.iter().filter(|s| s.node.is_some_and(|n| !near_any(&n))).step_by(3) {
        for node in (0..layout.nodes.len()).filter(on) {
            let way = stand.node.and_then(|from| route::shortest(layout, from, node));
            let Some(way) = way.filter(|w| w.nodes.len() > 3 && w.length_m > 300.0) else {
                continue;
            };
            // Onto the runway at the end of the way, not along it.
            let enters = way.nodes.iter().position(on).expect("its end");
            let best_m = best.as_ref().map_or(f64::INFINITY, |b| b.0);
            if enters + 1 == way.nodes.len() && way.length_m < best_m {
                best = Some((way.length_m, stand.name.clone(), way.nodes));
            }
        }
    }
    let (_, stand, there) = best.expect("a way onto the runway");
    // Back where it came from.
    let back = there.iter().rev().copied().collect();
    (stand, there, back)
}

/// At airports on whose ways nothing was tuned a person drives onto the runway in use, stands there for two minutes, and turns back: who
/// is about to land goes around or has landed, the alert names the car, nobody touches it, and everybody is served.
#[test]
fn a_car_that_is_driven_onto_the_runway_raises_the_alert_and_nobody_touches_it() {
    for airport in ["LZIB", "XSYN", "LIMC"] {
        let (stand, there, back) = onto_a_runway(&loaded(airport, None));
        let scene = loaded(airport, Some(&stand));
        let layout = &scene.airport.layout;
        let goal_m = layout.nodes[*there.last().expect("a way")].position_m;
        let mut driver = Driver::along(layout, &there);
        let mut home: Option<Driver> = None;
        let (mut stood_from, mut left_s) = (None, None);
        let end = run(&scene, |core, frame| {
            let now_s = frame as f64 * scene.run.frame.s();
            if now_s < 600.0 {
                return;
            }
            if let Some(home) = &mut home {
                home.look(core, frame);
                if home.arrived {
                    left_s.get_or_insert(now_s);
                }
                return;
            }
            driver.look(core, frame);
            if driver.arrived {
                let since = *stood_from.get_or_insert(now_s);
                if now_s - since > 120.0 {
                    let mut way = Driver::along(layout, &back);
                    way.said = driver.said;
                    home = Some(way);
                }
            }
        });
        let arrived_s = stood_from.unwrap_or_else(|| panic!("{airport}: never there"));
        let length_m: f64 = there
            .windows(2)
            .map(|w| (layout.nodes[w[1]].position_m - layout.nodes[w[0]].position_m).norm())
            .sum();
        assert!(
            arrived_s - 600.0 < length_m / 5.0 + 60.0,
            "{airport}: {arrived_s} s for {length_m} m"
        );
        let at_m = end.core.at_wheel(0).expect("a car").at_m;
        assert!((at_m - goal_m).norm() > 60.0 && left_s.is_some(), "{airport}: it is off again");
        assert!(!end.alerts.is_empty(), "{airport}: no alert names it");
        let in_time = |(at_s, _): &&(f64, String)| (600.0..arrived_s + 130.0).contains(at_s);
        assert_eq!(
            end.alerts.iter().filter(in_time).count(),
            end.alerts.len(),
            "{airport}: {:?}",
            end.alerts
        );
        assert!(end.touched.is_empty(), "{airport}: {:?}", end.touched);
        assert_eq!(end.core.at_wheel(0).map(|c| c.contacts), Some(0), "{airport}");
        // Who taxies to the very stand on whose lead-in the car parks again waits for it (at Malpensa one): he is given no other one yet.
        let waiting = (0..end.core.flights().len()).filter_map(|f| end.core.waiting(f));
        let behind = waiting.filter(|w| w.behind == Some(NAME) && w.place.starts_with(&stand));
        let behind = behind.count();
        assert!(behind <= usize::from(airport == "LIMC"), "{airport}: {behind} wait for the car");
        assert_eq!(
            end.core.measures_of_served() + behind,
            end.core.flights().len(),
            "{airport}: {:?}",
            end.core.remarks()
        );
        assert_eq!(end.core.unexpected_deadlocks(), 0, "{airport}");
    }
}

/// The node off all strips on which most flights come by within the first half hour.
fn busiest_node(scene: &Scene) -> (usize, String) {
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let mut core = behaving.core(&scene.run, scene.run.seed).expect("with truth");
    let layout = &scene.airport.layout;
    let mut by: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for frame in 1..36_000 {
        core.step(frame);
        if frame % 20 != 0 {
            continue;
        }
        for f in (0..core.flights().len()).filter(|f| core.phase(*f) == Phase::Taxiing) {
            let Some(state) = core.state(f) else { continue };
            let near =
                |n: &usize| (layout.nodes[*n].position_m - state.position_m.xy()).norm() < 15.0;
            for n in (0..layout.nodes.len()).filter(near) {
                by.entry(n).or_default().insert(f);
            }
        }
    }
    let stand = |n: usize| {
        layout.stands.iter().any(|s| (s.position_m - layout.nodes[n].position_m).norm() < 120.0)
    };
    let far = |n: &usize| {
        !stand(*n)
            && behaving.network.runways.iter().all(|r| {
                let (place, across) = r.place_m(layout.nodes[*n].position_m);
                !(-300.0..r.length_m + 300.0).contains(&place)
                    || across.abs() > r.hold_distance_m + 60.0
            })
    };
    let (node, _) = by
        .iter()
        .filter(|(n, _)| far(n))
        .max_by_key(|(n, who)| (who.len(), usize::MAX - **n))
        .expect("a node");
    (*node, layout.nodes[*node].name.clone())
}

/// The shortest way from a node to a stand that nobody has or is to have.
fn away(core: &Core, layout: &Airport, node: usize) -> Vec<usize> {
    let taken: Vec<_> = (0..core.flights().len()).map(|f| core.stand_m(core.stand(f))).collect();
    let free =
        |s: &&models::airport::Stand| taken.iter().all(|at| (at - s.position_m).norm() > 80.0);
    let ways = layout.stands.iter().filter(free).filter_map(|s| {
        let way = route::shortest(layout, node, s.node?)?;
        (way.nodes.len() > 2).then_some((way.length_m, way.nodes))
    });
    ways.min_by(|a, b| a.0.total_cmp(&b.0)).expect("a way to a free stand").1
}

/// A car stands on the busiest taxiway until somebody drives it away: flights wait behind it or go around it, none touches it, and
/// all are served once it has left.
#[test]
fn a_car_that_stands_on_a_taxiway_is_waited_for_and_not_touched() {
    for airport in ["LZIB", "LSZH", "XSYN"] {
        let (node, name) = busiest_node(&loaded(airport, None));
        let scene = loaded(airport, Some(&format!("#{name}")));
        let layout = &scene.airport.layout;
        let mut driver: Option<Driver> = None;
        let mut waited = 0;
        let end = run(&scene, |core, frame| {
            if frame % 200 == 0 {
                let behind = |f: usize| core.waiting(f).is_some_and(|w| w.behind == Some(NAME));
                waited += usize::from((0..core.flights().len()).any(behind));
            }
            if frame > 30_000 {
                driver
                    .get_or_insert_with(|| Driver::along(layout, &away(core, layout, node)))
                    .look(core, frame);
            }
        });
        assert!(waited > 3, "{airport}: nobody waited for it ({waited})");
        assert!(
            driver.is_some_and(|d| d.arrived) && end.touched.is_empty(),
            "{airport}: {:?}",
            end.touched
        );
        assert_eq!(
            end.core.measures_of_served(),
            end.core.flights().len(),
            "{airport}: {:?}",
            end.core.remarks()
        );
        assert_eq!(end.core.unexpected_deadlocks(), 0, "{airport}");
    }
}

/// Where a car darts in front of a flight: when, from where, and the line that the flight taxies along there.
struct Dart {
    flight: usize,
    at_s: f64,
    meets_m: Point2<f64>,
    across: Vector2<f64>,
}

/// Place, heading and speed of who taxies.
type Seen = (Point2<f64>, f64, f64);

/// Places where a flight taxies straight and fast with nobody near: one for each of some flights.
fn darts(scene: &Scene) -> Vec<Dart> {
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let mut core = behaving.core(&scene.run, scene.run.seed).expect("with truth");
    let mut seen: Vec<Vec<Option<Seen>>> = Vec::new();
    for frame in 1..=36_000 {
        core.step(frame);
        if frame % 20 == 0 {
            let of = |f: usize| {
                let s = core.state(f).filter(|_| core.phase(f) == Phase::Taxiing)?;
                Some((s.position_m.xy(), s.heading_rad, s.velocity_mps.norm()))
            };
            seen.push((0..core.flights().len()).map(of).collect());
        }
    }
    let mut found: Vec<Dart> = Vec::new();
    for second in 60..seen.len().saturating_sub(60) {
        for (flight, now) in seen[second].iter().enumerate() {
            let Some((at, heading, speed)) = *now else { continue };
            if !(6.0..13.0).contains(&speed) || found.iter().any(|d| d.flight == flight) {
                continue;
            }
            let ahead = Azimuth::from_rad(heading).unit();
            let meets_m = at + ahead * (8.0 * speed + 65.0);
            let straight = (1..=22).all(|k| {
                seen[second + k][flight].is_none_or(|(p, h, _)| {
                    let off = p - at;
                    (off - ahead * off.dot(&ahead)).norm() < 0.5
                        && wrap_pi(h - heading).abs() < 0.03
                })
            });
            let passes = seen[second + 22][flight]
                .is_some_and(|(p, ..)| (p - at).dot(&ahead) > 8.0 * speed + 90.0);
            let alone = (second - 30..second + 60).all(|k| {
                let others = seen[k].iter().enumerate().filter(|(f, _)| *f != flight);
                others.filter_map(|(_, o)| *o).all(|(p, ..)| (p - meets_m).norm() > 250.0)
            });
            let off_strips = behaving.network.runways.iter().all(|r| {
                let (place, across) = r.place_m(meets_m);
                !(-300.0..r.length_m + 300.0).contains(&place)
                    || across.abs() > r.hold_distance_m + 90.0
            });
            if straight && passes && alone && off_strips {
                let across = Vector2::new(ahead.y, -ahead.x);
                found.push(Dart { flight, at_s: (second + 1) as f64, meets_m, across });
            }
        }
    }
    found
}

/// A car darts onto the line of a taxiing aircraft, 65 m before its nose, where it has taken all pieces to beyond: its pilot sees it, brakes,
/// stands before it, is said to wait for it, and goes on when it has left.
#[test]
fn a_car_that_darts_in_front_of_an_aircraft_is_seen_and_not_hit() {
    let mut met = 0;
    for airport in ["LZIB", "LSZH", "LIMC", "EHAM"] {
        let scene = loaded(airport, None);
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        for dart in darts(&scene).into_iter().take(4) {
            let from_m = dart.meets_m + dart.across * 62.0;
            let car = models::traffic::core::Driven {
                callsign: NAME.into(),
                size: CAR,
                wheelbase_m: 2.7,
                most_mps: 27.8,
                acc_dec_mps2: (2.0, 3.0),
                at_m: from_m,
                heading_rad: Azimuth::of(-dart.across).rad(),
            };
            let far = 300.0;
            let square = [(-far, -far), (far, -far), (far, far), (-far, far)];
            let pavement = square.map(|(x, y)| dart.meets_m + Vector2::new(x, y)).to_vec();
            let core = behaving.core(&scene.run, scene.run.seed).expect("with truth");
            let mut core = core.with_driven(&[car], false, vec![pavement]);
            let case =
                format!("{airport} {} at {} s", core.flights()[dart.flight].callsign, dart.at_s);
            let (mut said, mut least_m, mut stood, mut beyond) = (0, f64::INFINITY, 0, false);
            let mut named = 0;
            let start = (dart.at_s / scene.run.frame.s()) as i64;
            for frame in 1..=start + 3000 {
                core.step(frame);
                let after_s = (frame - start) as f64 * scene.run.frame.s();
                if after_s < 0.0 {
                    continue;
                }
                let now = core.at_wheel(0).expect("a car");
                let left_m = (now.at_m - dart.meets_m).dot(&dart.across);
                if frame % 4 == 0 {
                    said += 1;
                    let stops = after_s < 40.0
                        && left_m < 1.0 + now.speed_mps * (1.2 + now.speed_mps / 5.0);
                    let wish = match stops {
                        true => Wish { throttle: 0, brake: 1000, steer: 0 },
                        false if after_s < 60.0 => Wish { throttle: 1000, brake: 0, steer: 0 },
                        false => Wish { throttle: 0, brake: 1000, steer: 0 },
                    };
                    let order = if said == 1 { Order::Take } else { Order::Drive(wish) };
                    let (source, flight) = ("driver".to_owned(), core.first_driven());
                    core.notice(Notice {
                        effect_frame: frame + 1,
                        source,
                        sequence: said,
                        flight,
                        order,
                    });
                }
                let Some(state) = core.state(dart.flight) else { continue };
                let size = core.flights()[dart.flight].size;
                let theirs = outline(size, state.position_m.xy(), state.heading_rad);
                let own = outline(CAR, now.at_m, now.heading_rad);
                least_m = least_m.min(distance_m(&own, &theirs));
                let stands = after_s < 40.0 && state.velocity_mps.norm() < 0.1;
                stood += u64::from(stands);
                let waits = core.waiting(dart.flight).and_then(|w| w.behind);
                named += u64::from(stands && waits == Some(NAME));
                let along = Vector2::new(-dart.across.y, dart.across.x);
                beyond |=
                    (state.position_m.xy() - dart.meets_m).dot(&along) > 20.0 && after_s > 45.0;
            }
            assert!(least_m > 1.0, "{case}: {least_m} m");
            assert_eq!(core.at_wheel(0).map(|c| c.contacts), Some(0), "{case}");
            if stood > 100 {
                met += 1;
                assert!(beyond, "{case}: it does not go on");
                assert!(10 * named > 9 * stood, "{case}: named in {named} of {stood} frames");
            }
        }
    }
    assert!(met >= 6, "{met} stood before the car");
}

/// Whoever plays with the wheel for half an hour among the traffic: the car stays a car, what it touches is counted, equal inputs give
/// equal bits, and those it does not stand before are served.
#[test]
fn whatever_a_driver_does_the_run_is_sound_and_can_be_repeated() {
    let name = busiest_node(&loaded("LZIB", None)).1;
    let scene = loaded("LZIB", Some(&format!("#{name}")));
    let digest = || {
        let mut draw = 1999_u64;
        let mut random = move |n: u64| {
            draw = draw
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (draw >> 33) % n
        };
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        let mut core = behaving.core(&scene.run, 4).expect("with truth");
        let mut last = core.at_wheel(0).expect("a car").at_m;
        let (mut moved_m, mut said) = (0.0, 0);
        for frame in 1..=36_000_i64 {
            if frame % 40 == 0 {
                said += 1;
                let order = match random(12) {
                    0 => Order::Leave,
                    1 | 2 => Order::Take,
                    _ => Order::Drive(Wish {
                        throttle: random(2001) as i16 - 1000,
                        brake: if random(4) == 0 { random(1001) as i16 } else { 0 },
                        steer: random(2001) as i16 - 1000,
                    }),
                };
                let (source, flight) = ("driver".to_owned(), core.first_driven());
                core.notice(Notice { effect_frame: frame, source, sequence: said, flight, order });
            }
            core.step(frame);
            let at = core.at_wheel(0).expect("a car");
            assert!(at.at_m.x.is_finite() && at.heading_rad.is_finite(), "frame {frame}");
            let step_m = (at.at_m - last).norm();
            assert!(step_m < 28.0 * 0.05 * 1.2 + 0.01, "frame {frame}: {step_m} m");
            moved_m += step_m;
            last = at.at_m;
        }
        assert!(moved_m > 500.0, "{moved_m} m");
        (core.digest(), core.remarks().len())
    };
    assert_eq!(digest(), digest());
}

#[test]
fn what_cannot_be_driven_is_refused_with_a_reason() {
    let text = |traffic: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("driven.toml");
        let text = format!(
            "[run]\ntitle = \"t\"\nstart = 2019-11-24T09:00:00Z\nduration_s = 60\n[airport]\nlayout = \"airports/LZIB.apt.dat\"\n{traffic}"
        );
        scenarios::load_text(&path, &text).map(|_| ()).expect_err("refused").to_string()
    };
    let flights = "[[traffic]]\nkind = \"generated\"\narrivals_per_h = 3\n";
    let car = |name: &str, stand: &str| {
        format!(
            "[[traffic]]\nkind = \"driven\"\ncallsign = \"{name}\"\ntype = \"FOLLOWME\"\nstand = \"{stand}\"\n"
        )
    };
    for (traffic, why) in [
        (car("FOLLOW1", "GA_Ramp_14"), "flights that behave"),
        (format!("{flights}{}", car("FOLLOW-1", "GA_Ramp_14")), "letters and digits only"),
        (format!("{flights}{}", car("FOLLOW1", "nowhere")), "a stand, or the number of a node"),
        (
            format!("{flights}{}{}", car("FOLLOW1", "GA_Ramp_14"), car("FOLLOW1", "GA_Ramp_17")),
            "FOLLOW1",
        ),
        (format!("{flights}{}via = [\"1\"]\n", car("FOLLOW1", "GA_Ramp_14")), "via"),
    ] {
        let error = text(&traffic);
        assert!(error.contains(why), "{error}");
    }
}

/// What a person wishes who taxies a flight along its own way, up to where it may, at some 6 m/s.
fn along_its_way(core: &Core, flight: usize) -> Wish {
    let now = core.flight_at_wheel(flight).expect("by hand");
    let (may, planned) = core.ways_ahead(flight);
    let line: Vec<_> =
        may.iter().chain(planned.iter().skip(1)).map(|p| Point2::new(p[0], p[1])).collect();
    let step_m = |w: &[[f64; 2]]| Vector2::new(w[1][0] - w[0][0], w[1][1] - w[0][1]).norm();
    let may_m: f64 = may.windows(2).map(step_m).sum();
    let size = core.flights()[flight].size;
    let nose = now.at_m + Azimuth::from_rad(now.heading_rad).unit() * (0.4 * size.length_m);
    let ahead_m = 10.0 + now.speed_mps;
    let far = line.iter().find(|p| (*p - nose).norm() > ahead_m).or(line.last());
    let to = far.map_or(Vector2::new(0.0, 1.0), |p| p - nose);
    let off = wrap_pi(Azimuth::of(to).rad() - now.heading_rad);
    // The wheels point at the place: the nose goes where they point.
    let wished_mps =
        (if off.abs() > 0.3 { 3.0_f64 } else { 6.0 }).min((0.5 * (may_m - 25.0).max(0.0)).sqrt());
    let most_mps = core.flights()[flight].taxi_mps.0;
    Wish {
        throttle: (1000.0 * wished_mps / most_mps) as i16,
        brake: if may_m < 26.0 { 400 } else { 0 },
        steer: (1000.0 * off / 1.134).clamp(-1000.0, 1000.0) as i16,
    }
}

/// Persons take one flight after the other while it taxies and give it back: as `wish` drives it, for `for_s`. What was remarked.
fn piloted(
    scene: &Scene,
    for_s: f64,
    mut wish: impl FnMut(&Core, usize, f64) -> Wish,
) -> (Core, Vec<String>) {
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let mut core = behaving.core(&scene.run, scene.run.seed).expect("with truth");
    let step_s = scene.run.frame.s();
    let (mut taken, mut said): (Option<(usize, f64)>, u64) = (None, 0);
    let mut had: BTreeSet<usize> = BTreeSet::new();
    let mut last: BTreeMap<usize, (Point2<f64>, f64, f64, Phase)> = BTreeMap::new();
    let mut faults = Vec::new();
    for frame in 1..=scene.run.frames() as i64 + 72_000 {
        let now_s = frame as f64 * step_s;
        let mut say = |core: &mut Core, flight: usize, order: Order| {
            said += 1;
            core.notice(Notice {
                effect_frame: frame,
                source: "pilot".into(),
                sequence: said,
                flight,
                order,
            });
        };
        match taken {
            None if frame % 20 == 0 => {
                let free = |f: &usize| {
                    core.may_be_taken(*f)
                        && !had.contains(f)
                        && core.state(*f).is_some_and(|s| s.velocity_mps.norm() > 3.0)
                };
                if let Some(flight) = (0..core.flights().len()).find(free) {
                    say(&mut core, flight, Order::Take);
                    had.insert(flight);
                    taken = Some((flight, now_s));
                }
            }
            Some((flight, since)) if frame % 4 == 0 => {
                let by_hand = core.flight_at_wheel(flight).is_some();
                if by_hand && now_s - since < for_s {
                    let wish = wish(&core, flight, now_s - since);
                    say(&mut core, flight, Order::Drive(wish));
                } else if now_s - since > 1.0 {
                    say(&mut core, flight, Order::Leave);
                    taken = None;
                }
            }
            _ => {}
        }
        core.step(frame);
        for flight in had.iter().copied() {
            let Some(state) = core.state(flight) else { continue };
            let speed = state.velocity_mps.norm();
            let now = (state.position_m.xy(), state.heading_rad, speed, core.phase(flight));
            if let Some((at, heading, before, phase)) = last.insert(flight, now)
                && phase == Phase::Taxiing
                && now.3 == Phase::Taxiing
            {
                // Braking of 3 m/s² is the hardest there is; the last step to a stand may be one.
                if before - speed > 4.0 * step_s && before > 0.5 {
                    faults.push(format!(
                        "{}: {now_s:.2} s: from {before:.2} to {speed:.2} m/s in a frame",
                        core.flights()[flight].callsign
                    ));
                }
                let (moved, turned) = ((now.0 - at).norm(), wrap_pi(now.1 - heading).abs());
                if moved > 17.0 * step_s || turned > 0.05 {
                    faults.push(format!(
                        "{}: {now_s:.2} s: {moved:.2} m, {turned:.3} rad in a frame",
                        core.flights()[flight].callsign
                    ));
                }
            }
        }
        if frame % 1200 == 0 && core.measures_of_served() == core.flights().len() {
            break;
        }
    }
    (core, faults)
}

/// Every flight that taxies is taken once by a person who taxies it for 40 s and gives it back: it goes on from where it is, nobody is touched,
/// and all are served.
#[test]
fn a_flight_that_a_person_taxies_is_given_back_and_goes_on() {
    for airport in ["LZIB", "LSZH", "XSYN", "LIMC"] {
        let scene = loaded_with(airport, None, "by_hand = true\n");
        let (core, faults) = piloted(&scene, 40.0, |core, flight, _| along_its_way(core, flight));
        let told = |end: &str| core.remarks().iter().filter(|r| r.text.ends_with(end)).count();
        let (back, flights) = (told("goes on by itself"), core.flights().len());
        assert!(2 * back >= flights, "{airport}: {back} of {flights}: {:?}", core.remarks());
        assert!(faults.is_empty(), "{airport}: {faults:?}");
        assert_eq!(told(" touch"), 0, "{airport}: {:?}", core.remarks());
        assert_eq!(core.measures_of_served(), flights, "{airport}: {:?}", core.remarks());
        assert_eq!(core.unexpected_deadlocks(), 0, "{airport}");
    }
}

/// Flights that are driven off their way and left there are towed to a stand: all are served.
#[test]
fn a_flight_that_is_left_beside_its_way_is_towed() {
    for airport in ["LZIB", "XSYN"] {
        let scene = loaded_with(airport, None, "by_hand = true\n");
        let (core, faults) = piloted(&scene, 14.0, |_, _, for_s| Wish {
            throttle: 400,
            brake: 0,
            steer: if for_s < 9.0 { 700 } else { 0 },
        });
        let towed =
            core.remarks().iter().filter(|r| r.text.contains("left beside its way")).count();
        assert!(towed >= 3, "{airport}: {towed}: {:?}", core.remarks());
        let open = core.clearances().iter().filter(|c| c.until_s.is_none() && c.kind != "GOA");
        assert_eq!(open.count(), 0, "{airport}: nobody is cleared for anything any more");
        assert!(faults.is_empty(), "{airport}: {faults:?}");
        assert_eq!(
            core.measures_of_served(),
            core.flights().len(),
            "{airport}: {:?}",
            core.remarks()
        );
    }
}

/// Whoever gives a flight back at full speed gives it back to a model that brakes: never harder than anybody can, also where what it may
/// use ends just ahead of it.
#[test]
fn a_flight_that_is_given_back_too_fast_brakes_and_goes_on() {
    for airport in ["LZIB", "LSZH", "XSYN", "LIMC"] {
        let scene = loaded_with(airport, None, "by_hand = true\n");
        let (core, faults) = piloted(&scene, 12.0, |core, flight, _| Wish {
            throttle: 900,
            brake: 0,
            ..along_its_way(core, flight)
        });
        assert!(faults.is_empty(), "{airport}: {faults:?}");
        assert_eq!(core.unexpected_deadlocks(), 0, "{airport}");
        let served = core.measures_of_served();
        assert_eq!(served, core.flights().len(), "{airport}: {:?}", core.remarks());
    }
}

/// Who has rejected his take-off stands on the runway, lined up: he was cleared for nothing, an alert for half a minute.
#[test]
fn who_has_rejected_a_take_off_is_lined_up_again() {
    for (airport, told) in [("LZIB", 6), ("LSZH", 6), ("XSYN", 6)] {
        let scene = loaded_with(airport, None, "");
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        let mut core = behaving.core(&scene.run, scene.run.seed).expect("with truth");
        let (mut said, mut stood) = (0_u64, 0);
        for frame in 1..=scene.run.frames() as i64 {
            core.step(frame);
            for flight in 0..core.flights().len() {
                let speed = core.state(flight).map_or(0.0, |s| s.velocity_mps.norm());
                if core.phase(flight) == Phase::Rolling
                    && (20.0..21.0).contains(&speed)
                    && said < told
                {
                    said += 1;
                    core.notice(Notice {
                        effect_frame: frame + 1,
                        source: "tower".into(),
                        sequence: said,
                        flight,
                        order: Order::Revoke(ClearanceKind::TakeOff),
                    });
                }
            }
            for remark in core.remarks().iter().filter(|r| r.text.ends_with("take-off rejected")) {
                let name = remark.text.split(':').next().unwrap_or_default();
                let flight = core.flights().iter().position(|f| f.callsign == name).expect("one");
                let now_s = frame as f64 * scene.run.frame.s();
                let lined_up = matches!(core.phase(flight), Phase::LinedUp(_));
                if lined_up && now_s < remark.time_s + 20.0 {
                    let open = |c: &&models::traffic::core::Clearance| {
                        c.flight == flight && c.until_s.is_none() && matches!(c.kind, "LUP" | "TOF")
                    };
                    let kinds: Vec<_> =
                        core.clearances().iter().filter(open).map(|c| c.kind).collect();
                    assert_eq!(kinds, ["LUP"], "{airport}: {name} at {now_s} s");
                    stood += 1;
                }
            }
        }
        assert!(stood > 300, "{airport}: {stood} frames of {said}");
        let twice = |c: &models::traffic::core::Clearance| c.kind == "LUP" && c.until_s.is_none();
        let waiting = (0..core.flights().len())
            .filter(|f| matches!(core.phase(*f), Phase::LinedUp(_) | Phase::Taxiing));
        let open = core.clearances().iter().filter(|c| twice(c)).count();
        assert!(open <= waiting.count(), "{airport}: {open}");
    }
}
