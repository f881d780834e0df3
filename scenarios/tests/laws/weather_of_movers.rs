//! The weather reaches movers: water, fog, wind and thin air change how they drive, land and take off, and nothing is broken by it.

use models::frames::{Azimuth, Point3, Vector2};
use models::traffic::core::{Core, Day, Direction, Flight, Phase};
use models::traffic::network::Network;
use scenarios::Scene;
use scenarios::hours::{Held, Hour, hour};
use std::path::{Path, PathBuf};

/// Airports that nothing here was tuned on, beside the synthetic one.
const AIRPORTS: [&str; 4] = ["XSYN", "LZIB", "LSZH", "LIMC"];

fn scene(airport: &str, weather: &str, seed: u64) -> Scene {
    let (path, text) = text(airport, weather, seed);
    scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"))
}

fn text(airport: &str, weather: &str, seed: u64) -> (PathBuf, String) {
    let base = Path::new(env!("CARGO_MANIFEST_DIR"));
    let is = |ext: &str| base.join(format!("airports/{airport}.{ext}")).exists();
    let ext = if is("apt.dat") { "apt.dat" } else { "nodes.csv" };
    let net = format!("ground_network = \"airports/{airport}.groundnet.xml\"");
    let net = if is("groundnet.xml") { net } else { String::new() };
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 2400\n[airport]\nlayout = \"airports/{airport}.{ext}\"\n{net}\n\
         [weather]\ntimeline = [{weather}]\n\
         [[traffic]]\nkind = \"generated\"\narrivals_per_h = 10\ndepartures_per_h = 10\n"
    );
    (base.join("weather.toml"), text)
}

/// One flight at a frame.
struct Sample {
    flight: usize,
    time_s: f64,
    phase: Phase,
    position_m: Point3<f64>,
    speed_mps: f64,
}

/// Every flight five times a second, and what the checker says of every frame.
fn watched(scene: &Scene, seed: u64) -> (Vec<Sample>, Held) {
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let count = behaving.flights.len();
    let mut samples = Vec::new();
    let step = &mut |core: &mut Core, frame: i64| {
        core.step(frame);
        if frame % 4 != 0 {
            return;
        }
        for flight in 0..count {
            let Some(state) = core.state(flight) else { continue };
            samples.push(Sample {
                flight,
                time_s: frame as f64 * 0.05,
                phase: core.phase(flight),
                position_m: state.position_m,
                speed_mps: state.velocity_mps.xy().norm(),
            });
        }
    };
    let looks = Hour { seed, every: 1, drain_s: 2700.0, stopping: 0.1 };
    let held = hour(behaving, &scene.run, &scene.airport.layout, &looks, step).expect("truth");
    (samples, held)
}

/// Nothing is broken, everybody is served.
fn kept(name: &str, held: &Held) {
    assert_eq!(held.broken(), Vec::<String>::new(), "{name}");
    assert!(held.core.all_served(), "{name}: {} served", held.core.measures_of_served());
    assert_eq!(held.core.unexpected_deadlocks(), 0, "{name}");
}

/// Speed over the ground at a change of a flight's phase to or from the runway.
fn at(samples: &[Sample], flight: usize, which: impl Fn(&Sample) -> bool) -> Option<&Sample> {
    samples.iter().find(|s| s.flight == flight && which(s))
}

#[test]
fn fog_slows_all_who_taxi_and_nothing_is_broken() {
    for (airport, seed) in AIRPORTS.into_iter().zip(3..) {
        let fog_s = 900.0;
        let fog = format!("{{ at_s = {fog_s}, visibility_m = 250 }}");
        let scene = scene(airport, &fog, seed);
        let (samples, held) = watched(&scene, seed);
        kept(airport, &held);
        let taxiing = samples.iter().filter(|s| s.phase == Phase::Taxiing);
        // Who leaves a runway fast by a rapid exit, or taxies at 30 kt, has slowed down within half a minute at 0.5 m/s2 of braking.
        let (mut before_mps, mut after_mps) = (0.0_f64, 0.0_f64);
        let runways = &scene.traffic.behaving.as_ref().expect("behaves").network.runways;
        for s in taxiing {
            let on_runway = runways.iter().any(|r| {
                let (along_m, off_m) = r.place_m(s.position_m.xy());
                (-100.0..=r.length_m + 100.0).contains(&along_m) && off_m.abs() < 150.0
            });
            match on_runway {
                true => {}
                false if s.time_s < fog_s => before_mps = before_mps.max(s.speed_mps),
                false if s.time_s > fog_s + 30.0 => after_mps = after_mps.max(s.speed_mps),
                false => {}
            }
        }
        assert!(before_mps > 11.0, "{airport}: {before_mps} m/s in clear air");
        // The middle of a body that swings is a little faster than the point that is guided.
        assert!(after_mps < 8.3, "{airport}: {after_mps} m/s in fog");
    }
}

#[test]
fn wet_surfaces_lengthen_landings_and_take_exits_slowly() {
    for (airport, seed) in AIRPORTS.into_iter().zip(3..) {
        let [dry, wet] = ["", "{ at_s = 0, film_mm = 1.0 }"].map(|w| scene(airport, w, seed));
        let runs = [&dry, &wet].map(|s| watched(s, seed));
        let mut turning_mps = [0.0_f64; 2];
        for ((samples, held), fastest) in runs.iter().zip(&mut turning_mps) {
            kept(airport, held);
            let flights = held.core.flights();
            for f in (0..flights.len()).filter(|f| flights[*f].direction == Direction::Arrival) {
                let off = at(samples, f, |s| s.phase == Phase::Taxiing);
                *fastest = fastest.max(off.map_or(0.0, |s| s.speed_mps));
            }
        }
        // Half of 50 kt, and what the middle swings.
        assert!(turning_mps[1] < 13.3, "{airport}: turns off at {} m/s", turning_mps[1]);
        assert!(turning_mps[1] <= turning_mps[0] + 0.5, "{airport}: {turning_mps:?}");
    }
}

#[test]
fn wind_and_thin_air_change_speeds_over_the_ground_as_the_closed_forms_say() {
    for (airport, seed) in AIRPORTS.into_iter().zip(3..) {
        // 9 m/s from 300 degrees, 30 °C at 900 hPa: 84 % of the air.
        let day = "{ at_s = 0, wind_mps = 9, wind_from_deg = 300, temperature_c = 30, pressure_hpa = 900 }";
        let scene = scene(airport, day, seed);
        let (samples, held) = watched(&scene, seed);
        kept(airport, &held);
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        let ratio = 900.0 / 1013.25 * 288.15 / 303.15;
        let from = Azimuth::from_rad(300_f64.to_radians());
        let (mut landed, mut left) = (0, 0);
        for (f, flight) in held.core.flights().iter().enumerate() {
            let (r, end) = flight.runway;
            let runway = &behaving.network.runways[r];
            let along = Azimuth::of(runway.ends_m[1 - end] - runway.ends_m[end]);
            let head_mps = 9.0 * from.unit().dot(&along.unit());
            assert!(
                head_mps > -2.5,
                "{airport}: {} with {head_mps} m/s of head wind",
                flight.callsign
            );
            if flight.direction == Direction::Arrival {
                let Some(down) = at(&samples, f, |s| s.phase == Phase::Landing) else { continue };
                let expected = flight.landing.0 - head_mps;
                assert!(
                    (down.speed_mps - expected).abs() < 1.0,
                    "{airport}: {} touches down at {} m/s, {expected} expected",
                    flight.callsign,
                    down.speed_mps
                );
                landed += 1;
                continue;
            }
            let rolls = at(&samples, f, |s| s.phase == Phase::Rolling);
            let off = at(&samples, f, |s| s.phase == Phase::Rolling && s.position_m.z > 0.0);
            let Some((rolls, off)) = rolls.zip(off) else { continue };
            let run =
                models::traffic::runway_roll::take_off_run(&flight.take_off_on(ratio, head_mps));
            let run = run.expect("can lift off");
            let name = &flight.callsign;
            assert!(
                (off.speed_mps - run.liftoff_ground_mps).abs() < 1.0,
                "{airport}: {name} lifts off at {} m/s, {run:?}",
                off.speed_mps
            );
            let rolled_m = (off.position_m - rolls.position_m).xy().norm();
            // Thrust builds up over 5 s: time, and a little way.
            let longer_m = rolled_m - run.distance_m;
            assert!(
                (-15.0..60.0).contains(&longer_m),
                "{airport}: {name} rolls {rolled_m} m, {run:?}"
            );
            assert!(
                run.distance_m > 1.05 * flight.take_off.1 || head_mps > 4.0,
                "{airport}: {name} {run:?}"
            );
            left += 1;
        }
        assert!(landed >= 2 && left >= 3, "{airport}: {landed} landings, {left} take-offs");
    }
}

/// A day that nobody has seen before comes in the middle of everything: who drives, who is about to land, who rolls.
#[test]
fn weather_that_turns_at_once_breaks_nothing() {
    for (airport, seed) in AIRPORTS.into_iter().zip(7..) {
        let turning = "{ at_s = 700, film_mm = 2.0, visibility_m = 300 }, { at_s = 1100, film_mm = 0.0, visibility_m = 20000, \
                       wind_mps = 12, wind_from_deg = 200 }, { at_s = 1500, film_mm = 1.0, wind_mps = 3, wind_from_deg = 30 }";
        let scene = scene(airport, turning, seed);
        let (_, held) = watched(&scene, seed);
        kept(airport, &held);
    }
}

/// A wind from 300 degrees that comes from 120 after twenty minutes.
const TURNS: &str = "{ at_s = 0, wind_mps = 8, wind_from_deg = 300 }, { at_s = 1200, wind_mps = 10, wind_from_deg = 120 }";

/// Wind from behind at a runway end, m/s.
fn tail_mps(network: &Network, (r, end): (usize, usize), day: &Day) -> f64 {
    let ends_m = network.runways[r].ends_m;
    -day.head_mps(Azimuth::of(ends_m[1 - end] - ends_m[end]))
}

/// Ends that a scene names stay: who lands with the wind from behind later is told of, with how many.
#[test]
fn a_wind_that_turns_behind_the_ends_in_use_is_said() {
    for airport in AIRPORTS {
        let (path, free) = text(airport, TURNS, 3);
        let network = &scene(airport, TURNS, 3).traffic.behaving.expect("behaves").network;
        let day = Day { wind_mps: wind(8.0, 300.0), ..Day::default() };
        let ends = (0..network.runways.len()).flat_map(|r| [(r, 0), (r, 1)]);
        let into =
            ends.min_by(|a, b| tail_mps(network, *a, &day).total_cmp(&tail_mps(network, *b, &day)));
        let (r, end) = into.expect("an end");
        let name = &network.runways[r].names[end];
        let named =
            format!("{free}arrival_runways = [\"{name}\"]\ndeparture_runways = [\"{name}\"]\n");
        for (text, said) in [(&free, false), (&named, true)] {
            let (_, found) =
                scenarios::warnings::check(&path, text).unwrap_or_else(|e| panic!("{e}"));
            let told: Vec<_> = found.iter().filter(|w| w.word() == "W24").collect();
            assert_eq!(told.len(), usize::from(said), "{airport}: {told:?}");
            assert!(told.iter().all(|w| w.text.contains("m/s from behind")), "{airport}: {told:?}");
        }
    }
}

fn wind(speed_mps: f64, from_deg: f64) -> Vector2<f64> {
    let from = f64::to_radians(from_deg);
    -speed_mps * Vector2::new(libm::sin(from), libm::cos(from))
}

/// When each flight is on its runway: a landing from the touchdown on, a take-off until it lifts off, s.
fn on_runways(samples: &[Sample], held: &Held) -> Vec<(usize, f64)> {
    let on = |(m, flight): (usize, &Flight)| {
        let mut own = samples.iter().filter(|s| s.flight == m);
        let sample = match flight.direction {
            Direction::Arrival => own.find(|s| s.phase == Phase::Landing),
            _ => {
                let rolls = own.find(|s| s.phase == Phase::Rolling)?;
                own.take_while(|s| s.position_m.z < rolls.position_m.z + 1.0).last()
            }
        };
        sample.map(|s| (m, s.time_s))
    };
    held.core.flights().iter().enumerate().filter_map(on).collect()
}

/// Between who lifts off and who lands towards him then is more than the minute of `RMCA_OPP`.
fn nobody_takes_off_before_a_landing_towards_him(
    name: &str,
    network: &Network,
    samples: &[Sample],
    held: &Held,
) {
    let flights = held.core.flights();
    let times = on_runways(samples, held);
    assert_eq!(times.len(), flights.len(), "{name}: all are seen on a runway");
    let towards = |m: usize| {
        let (r, end) = flights[m].runway;
        (network.runways[r].ends_m[1 - end] - network.runways[r].ends_m[end]).normalize()
    };
    let (arrivals, departures): (Vec<_>, Vec<_>) =
        times.iter().partition(|(m, _)| flights[*m].direction == Direction::Arrival);
    for (d, up_s) in &departures {
        for (a, lands_s) in &arrivals {
            let same = flights[*d].runway.0 == flights[*a].runway.0;
            let head_on = same && towards(*d).dot(&towards(*a)) < -0.5;
            assert!(
                !head_on || lands_s < up_s || lands_s - up_s > 60.0,
                "{name}: {} lifts off at {up_s} s, {} lands towards it at {lands_s} s",
                flights[*d].callsign,
                flights[*a].callsign
            );
        }
    }
}

/// A scene may name opposite ends of one runway for landings and take-offs: neither side waits for ever for the other.
#[test]
fn opposite_ends_that_a_scene_names_serve_both_sides() {
    let named = [("EGCC", "23R", "05L"), ("LZIB", "31", "13"), ("LSZH", "28", "10")];
    for (airport, lands, leaves) in named {
        for seed in [1, 2] {
            let (path, text) = text(airport, "", seed);
            let ends =
                format!("arrival_runways = [\"{lands}\"]\ndeparture_runways = [\"{leaves}\"]\n");
            let busy = text.replace("_per_h = 10", "_per_h = 12").replace("= 2400", "= 3600");
            let scene = scenarios::load_text(&path, &format!("{busy}{ends}"))
                .unwrap_or_else(|e| panic!("{e}"));
            let (samples, held) = watched(&scene, seed);
            let name = format!("{airport}, seed {seed}");
            kept(&name, &held);
            // At Zurich who leaves by 10 waits in the last exit of 28.
            let remarks = held.core.remarks();
            let around = remarks.iter().filter(|r| r.text.contains("goes around")).count();
            let arrivals = held.core.flights().iter().filter(|f| f.direction == Direction::Arrival);
            let most = if airport == "LSZH" { arrivals.count() * 2 / 3 + 1 } else { 2 };
            assert!(around <= most, "{name}: {around} go-arounds");
            let network = &scene.traffic.behaving.as_ref().expect("behaves").network;
            nobody_takes_off_before_a_landing_towards_him(&name, network, &samples, &held);
        }
    }
}

/// The ends turn with the wind: nobody who is planned behind it has it from behind, nobody takes off towards
/// somebody who lands, everybody is served.
#[test]
fn ends_that_nobody_names_turn_with_the_wind() {
    for ((airport, seed), rate) in AIRPORTS.into_iter().zip(3..).zip([16, 16, 20, 16]) {
        let (path, free) = text(airport, TURNS, seed);
        let busy = free.replace("arrivals_per_h = 10", &format!("arrivals_per_h = {rate}"));
        let busy = busy.replace("departures_per_h = 10", &format!("departures_per_h = {rate}"));
        let scene = scenarios::load_text(&path, &busy).unwrap_or_else(|e| panic!("{e}"));
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        let told = behaving.remarks.iter().filter(|r| r.contains("the wind turns: from 1200 s on"));
        assert_eq!(told.count(), 1, "{airport}: {:?}", behaving.remarks);
        let (samples, held) = watched(&scene, seed);
        kept(airport, &held);
        let day = Day { wind_mps: wind(10.0, 120.0), ..Day::default() };
        let flights = held.core.flights();
        let network = &behaving.network;
        let times = on_runways(&samples, &held);
        assert_eq!(times.len(), flights.len(), "{airport}");
        let arrival = |m: usize| flights[m].direction == Direction::Arrival;
        let mut turned = [0; 2];
        for (m, t) in &times {
            let tail_mps = tail_mps(network, flights[*m].runway, &day);
            turned[usize::from(arrival(*m))] += usize::from(tail_mps < 0.0);
            // Who was planned before keeps his end, however late he is.
            let planned_s = flights[*m].time_s + if arrival(*m) { 0.0 } else { 720.0 };
            assert!(
                planned_s < 1200.0 || tail_mps <= 2.5,
                "{airport}: {} at {t} s with {tail_mps} m/s from behind",
                flights[*m].callsign
            );
        }
        assert!(turned[0] >= 2 && turned[1] >= 2, "{airport}: {turned:?} into the new wind");
        nobody_takes_off_before_a_landing_towards_him(airport, network, &samples, &held);
    }
}

/// A wind that comes back within the half hour for which ends stay is asked for again when that is over; nobody asked any more.
#[test]
fn ends_turn_when_they_may_if_they_might_not_before() {
    let mut turned = 0;
    for airport in AIRPORTS {
        let calm = scene(airport, "", 3);
        let behaving = calm.traffic.behaving.as_ref().expect("behaves");
        let (r, end) = behaving.flights[0].runway;
        let ends_m = behaving.network.runways[r].ends_m;
        let into_deg = Azimuth::of(ends_m[1 - end] - ends_m[end]).rad().to_degrees();
        let [into, away] = [0.0, 180.0].map(|by| (into_deg + by).rem_euclid(360.0));
        let weather = format!(
            "{{ at_s = 0, wind_mps = 8, wind_from_deg = {into:.1} }}, {{ at_s = 1200, wind_mps = 10, wind_from_deg = {away:.1} }}, \
             {{ at_s = 1800, wind_mps = 2, wind_from_deg = {into:.1} }}"
        );
        let (path, text) = text(airport, &weather, 3);
        let text = text.replace("duration_s = 2400", "duration_s = 5400");
        let scene = scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"));
        let remarks = &scene.traffic.behaving.as_ref().expect("behaves").remarks;
        let told = |from_s: u32| {
            let told = format!("the wind turns: from {from_s} s on");
            remarks.iter().any(|r| r.contains(&told))
        };
        println!("{airport}: {remarks:?}");
        assert!(!told(1800), "{airport}: within the half hour, {remarks:?}");
        turned += u32::from(told(1200) && told(3000));
    }
    assert!(turned >= 2, "{turned} airports turn back");
}

/// Who leaves towards the new landings stands in their exit. At Bratislava ten of 29 never arrived, and there were 17 go-arounds,
/// when those who took off towards a landing needed two minutes more than landings were apart for.
#[test]
fn landings_towards_which_somebody_will_take_off_are_far_enough_apart() {
    let turns = "{ at_s = 0, wind_mps = 8, wind_from_deg = 300 }, { at_s = 1500, wind_mps = 9, wind_from_deg = 120 }";
    let mut around = 0;
    for seed in [1, 3] {
        let (path, text) = text("LZIB", turns, seed);
        let busy = text.replace("_per_h = 10", "_per_h = 15").replace("= 2400", "= 3600");
        let scene = scenarios::load_text(&path, &busy).unwrap_or_else(|e| panic!("{e}"));
        let (_, held) = watched(&scene, seed);
        kept("LZIB", &held);
        around += held.core.remarks().iter().filter(|r| r.text.contains("goes around")).count();
    }
    assert!(around <= 4, "{around} go-arounds");
}

/// La Paz lies at 4 061 m, where 620 hPa are usual: the pressure is that of the field. Who says none has the air of sea level there, and
/// is told so.
#[test]
fn the_air_of_a_high_airport_is_that_which_is_said() {
    let of = |weather: &str, height_m: f64| {
        let (path, text) = text("XSYN", weather, 3);
        let reference = format!(
            "reference = {{ lat_deg = 44.9991, lon_deg = 10.0038, height_m = {height_m:.1} }}\n[weather]"
        );
        let scene = scenarios::load_text(&path, &text.replace("[weather]", &reference));
        scene.unwrap_or_else(|e| panic!("{e}"))
    };
    let told = |scene: &Scene| {
        scene.warnings.iter().filter(|w| w.contains("pressure_hpa")).cloned().collect::<Vec<_>>()
    };
    let untold = told(&of("", 4061.0));
    assert!(untold.len() == 1 && untold[0].contains("61"), "{untold:?}");
    assert_eq!(told(&of("", 590.0)), Vec::<String>::new());
    let scene = of("{ at_s = 0, temperature_c = 8, pressure_hpa = 620 }", 4061.0);
    assert_eq!(told(&scene), Vec::<String>::new());
    let (samples, held) = watched(&scene, 3);
    kept("XSYN at 4061 m", &held);
    let ratio = 620.0 / 1013.25 * 288.15 / 281.15;
    let mut left = 0;
    for (f, flight) in held.core.flights().iter().enumerate() {
        let lifted = |s: &Sample| s.phase == Phase::Rolling && s.position_m.z > 0.0;
        let Some(off) = at(&samples, f, lifted) else { continue };
        let expected = flight.take_off.0 / f64::sqrt(ratio);
        assert!(
            (off.speed_mps - expected).abs() < 2.0,
            "{}: lifts off at {} m/s, {expected} expected",
            flight.callsign,
            off.speed_mps
        );
        left += 1;
    }
    assert!(left >= 3, "{left} departures");
}
