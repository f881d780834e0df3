//! Nobody takes off from a runway that is too short for him: refused, or kept on the ground until the weather has turned.

use models::traffic::core::{Core, Phase};
use models::traffic::runway_roll::take_off_run;
use scenarios::Scene;
use scenarios::error::ScenarioError;
use scenarios::schedule::Behaving;
use std::path::Path;

/// Types of a table, with lift-off speed, run and length.
const TYPES: [(&str, f64, f64, f64); 5] = [
    ("B77W", 96.4, 2210.0, 73.86),
    ("B789", 96.1, 2490.0, 62.81),
    ("A320", 85.3, 1650.0, 37.57),
    ("E190", 88.1, 1800.0, 36.24),
    ("C172", 30.0, 290.0, 8.3),
];

/// A run of one departure after a minute, in a weather.
fn scene(
    name: &str,
    airport: &str,
    (kind, end): (&str, &str),
    weather: &str,
) -> Result<Scene, ScenarioError> {
    let file = std::env::temp_dir().join(format!("seeds-short-{}-{name}.csv", std::process::id()));
    let stand = match airport {
        "XSYN" => "C3",
        _ => "A101",
    };
    let rows = format!(
        "callsign,address,type,movement,runway,stand,tobt\nAAA1,400001,{kind},departure,{end},{stand},2026-05-12T06:11:00Z\n"
    );
    std::fs::write(&file, rows).expect("written");
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = 1\nstart = 2026-05-12T06:10:00Z\nduration_s = 3600\n[airport]\nlayout = \"airports/{airport}.apt.dat\"\n\
         [weather]\ntimeline = [{weather}]\n[[traffic]]\nkind = \"schedule\"\nfile = \"{}\"\n",
        file.display()
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("short.toml");
    let scene = scenarios::load_text(&path, &text);
    std::fs::remove_file(&file).ok();
    scene
}

/// Where the flight is when it lifts off: how much of its runway is left, m, and when, s.
fn lifts_off(scene: &Scene) -> (Option<(f64, f64)>, Core) {
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let mut core = behaving.core(&scene.run, 1).expect("truth");
    let mut last = None;
    for frame in 0..72_000_i64 {
        core.step(frame);
        let Some(state) = core.state(0).filter(|_| core.phase(0) == Phase::Rolling) else {
            continue;
        };
        if state.position_m.z > 0.0 {
            let (r, end) = core.flights()[0].runway;
            let runway = &behaving.network.runways[r];
            let along_m = runway.place_m(state.position_m.xy()).0;
            let left_m = if end == 0 { runway.length_m - along_m } else { along_m };
            last = Some((left_m, frame as f64 * 0.05));
            break;
        }
    }
    (last, core)
}

/// Hot days and cold ones, with and against the wind: who is let in lifts off on his runway, who is not would not have.
#[test]
fn who_is_not_refused_lifts_off_on_his_runway() {
    let days = [(15.0, 0.0), (45.0, 0.0), (30.0, -4.0), (45.0, 9.0), (-20.0, 0.0)];
    let (mut refused, mut left) = (0, 0);
    for (n, (temperature_c, head_mps)) in days.into_iter().enumerate() {
        for (kind, v_mps, run_m, length_m) in TYPES {
            for (end, from_deg) in [("18", 180.0), ("27", 270.0)] {
                let from_deg = if head_mps < 0.0 { from_deg - 180.0 } else { from_deg };
                let wind_mps = f64::abs(head_mps);
                let weather = format!(
                    "{{ at_s = 0, temperature_c = {temperature_c:.1}, wind_mps = {wind_mps:.1}, wind_from_deg = {from_deg:.1} }}"
                );
                let name = format!("{n}-{kind}-{end}");
                let what = format!("{kind} from {end} in {weather}");
                match scene(&name, "XSYN", (kind, end), &weather) {
                    Ok(scene) => {
                        let (off, core) = lifts_off(&scene);
                        let remarks: Vec<_> = core.remarks().iter().map(|r| &r.text).collect();
                        let Some((left_m, _)) = off else {
                            // No way leads from a stand for its size to this runway.
                            let no_way = remarks.iter().any(|r| r.contains("no free stand"));
                            assert!(no_way, "{what}: stays, {remarks:?}");
                            continue;
                        };
                        assert!(left_m > 0.0, "{what}: lifts off {left_m} m before the end");
                        left += 1;
                    }
                    Err(error) => {
                        let said = error.to_string();
                        assert!(
                            said.contains("csv:2: runway: ") && said.contains("AAA1"),
                            "{said}"
                        );
                        let airport = if end == "18" { 2201.0 } else { 2992.0 };
                        let flight = models::traffic::runway_roll::TakeOff {
                            liftoff_mps: v_mps,
                            distance_m: run_m,
                            density_ratio: 288.15 / (273.15 + temperature_c),
                            headwind_mps: head_mps,
                            end_ratio: 0.75,
                            thrust_exponent: 0.7,
                            rolling_friction: 0.02,
                        };
                        let needs_m = take_off_run(&flight).map_or(f64::INFINITY, |r| r.distance_m);
                        assert!(needs_m + length_m + 60.0 > airport, "{what}: {needs_m} m, {said}");
                        refused += 1;
                    }
                }
            }
        }
    }
    assert!(refused >= 8 && left >= 30, "{refused} refused, {left} left");
}

/// A gale that nothing so light flies against: it stands until the gale is over, and says so once.
#[test]
fn who_cannot_take_off_now_waits_on_his_stand_and_says_so() {
    let gale = "{ at_s = 0, wind_mps = 37, wind_from_deg = 270 }, { at_s = 1500, wind_mps = 5, wind_from_deg = 270 }";
    let scene = scene("gale", "XSYN", ("C172", "27"), gale).unwrap_or_else(|e| panic!("{e}"));
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    assert!(
        behaving.remarks.iter().any(|r| r.contains("AAA1") && r.contains("it waits")),
        "{:?}",
        behaving.remarks
    );
    let (off, core) = lifts_off(&scene);
    let told = core.remarks().iter().filter(|r| r.text.contains("stays on its stand")).count();
    assert_eq!(told, 1, "{:?}", core.remarks());
    let (left_m, at_s) = off.expect("takes off");
    assert!(at_s > 1500.0 && left_m > 0.0, "{at_s} s, {left_m} m");
}

/// The gale comes when it is under way already, at each of its places: it does not fly then, and does when it is over.
#[test]
fn a_gale_that_comes_on_the_way_turns_a_light_one_back() {
    let mut towed = 0;
    for from_s in (120..420).step_by(20) {
        let gale = format!(
            "{{ at_s = 0 }}, {{ at_s = {from_s}, wind_mps = 37, wind_from_deg = 270 }}, {{ at_s = 1800, wind_mps = 0, wind_from_deg = 0 }}"
        );
        let scene = scene(&format!("turns-{from_s}"), "XSYN", ("C172", "27"), &gale)
            .unwrap_or_else(|e| panic!("{e}"));
        let (off, core) = lifts_off(&scene);
        let (left_m, at_s) = off.unwrap_or_else(|| panic!("{from_s}: stays, {:?}", core.remarks()));
        assert!(left_m > 0.0, "{from_s}: {left_m} m");
        // Who rolls so fast already that the gale lifts him is in the air then.
        assert!(!(f64::from(from_s) + 30.0..1800.0).contains(&at_s), "{from_s}: at {at_s} s");
        towed += usize::from(core.remarks().iter().any(|r| r.text.contains("towed to stand")));
    }
    assert!(towed > 0, "nobody was under way");
}

/// A wind that turns over an end that the scene names: one flight that is drawn behind it cost the whole scene. It is left out and told of,
/// all others are those of the scene in which the wind does not turn.
#[test]
fn drawn_flights_that_lack_runway_are_left_out_and_the_others_come() {
    let drawn = |seed: u64, arrivals: u32, wind: &str| {
        let text = format!(
            "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 3600\n[airport]\nlayout = \"airports/XSYN.apt.dat\"\n\
             [weather]\ntimeline = [{{ at_s = 0 }}{wind}]\n[[traffic]]\nkind = \"generated\"\narrivals_per_h = {arrivals}\n\
             departures_per_h = 12\nturnaround_min = 10\narrival_runways = [\"27\"]\ndeparture_runways = [\"18\"]\n"
        );
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("short.toml");
        let scene = scenarios::load_text(&path, &text);
        scene.unwrap_or_else(|e| panic!("{seed}, {arrivals}: {e}")).traffic.behaving.expect("some")
    };
    let mut left_out = 0;
    for (seed, arrivals) in (1..=6).zip([0, 6].into_iter().cycle()) {
        let calm = drawn(seed, arrivals, "");
        let windy = drawn(seed, arrivals, ", { at_s = 1200, wind_mps = 15, wind_from_deg = 0 }");
        let names = |b: &Behaving| -> Vec<String> {
            b.flights.iter().map(|f| f.callsign.clone()).collect()
        };
        let (all, there) = (names(&calm), names(&windy));
        let gone: Vec<&String> = all.iter().filter(|n| !there.contains(n)).collect();
        assert!(there.iter().all(|n| all.contains(n)), "{seed}: {there:?} of {all:?}");
        let told: Vec<_> =
            windy.left_out.iter().filter(|r| r.contains("of runway 18 for its take-off")).collect();
        assert_eq!(told.len(), usize::from(!gone.is_empty()), "{seed}: {:?}", windy.left_out);
        if let ([first, ..], [told]) = (&gone[..], &told[..]) {
            let count = format!("{} of {} drawn flights are left out", gone.len(), all.len());
            assert!(told.starts_with(&count) && told.contains(*first), "{told}: {gone:?}");
        }
        for f in calm.flights.iter().filter(|f| gone.contains(&&f.callsign)) {
            assert!(f.time_s >= 1200.0 && f.callsign.starts_with("GD"), "{}", f.callsign);
        }
        // A turn-round is still that of its own arrival.
        let turned = |b: &Behaving| -> Vec<(String, String)> {
            let of = |f: &models::traffic::core::Flight| {
                Some((f.callsign.clone(), b.flights[f.turnaround_of?].callsign.clone()))
            };
            b.flights.iter().filter_map(of).filter(|t| there.contains(&t.0)).collect()
        };
        assert_eq!(turned(&windy), turned(&calm), "{seed}");
        left_out += gone.len();
    }
    assert!(left_out >= 6, "{left_out} left out");
}

/// A tail wind that makes its runway too short comes while it rolls: who is slow enough stops on it, nobody lifts off behind its end.
#[test]
fn who_rolls_when_the_wind_turns_stops_or_lifts_off_on_his_runway() {
    let of = |name: &str, weather: &str| {
        let scene = scene(name, "XSYN", ("A320", "18"), weather).unwrap_or_else(|e| panic!("{e}"));
        lifts_off(&scene)
    };
    let (left_m, off_s) = of("calm", "{ at_s = 0 }").0.expect("takes off");
    assert!(left_m > 0.0);
    // It rolls for 39 s.
    for before_s in [34.0, 30.0, 26.0, 22.0, 18.0] {
        let from_s = off_s - before_s;
        let weather = format!(
            "{{ at_s = 0 }}, {{ at_s = {from_s:.1}, wind_mps = 17, wind_from_deg = 360 }}, {{ at_s = 2400, wind_mps = 0, wind_from_deg = 0 }}"
        );
        let (off, core) = of(&format!("rolls-{before_s}"), &weather);
        let (left_m, at_s) =
            off.unwrap_or_else(|| panic!("{weather}: stays, {:?}", core.remarks()));
        assert!(left_m > 0.0, "{weather}: lifts off {left_m} m before the end");
        assert!(at_s > 2400.0, "{weather}: at {at_s} s, {left_m} m before the end");
    }
}
