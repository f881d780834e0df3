//! Runway ends that traffic uses where the scene names none: nobody takes off towards those who land, nobody has the wind from behind.

use models::frames::{Azimuth, wrap_pi};
use models::traffic::core::Direction;
use models::traffic::network::Network;
use scenarios::template::layout_of;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Layouts that ship, with their ground network, and those of `SEEDS_LAYOUTS` (a folder of apt.dat files), where it is set.
fn airports() -> Vec<String> {
    let shipped = ["LSZH", "EHAM", "EGCC", "XSYN", "LIMC", "LZIB"];
    let mut all: Vec<String> = shipped.map(|icao| layout_of(icao).expect(icao)).into();
    if let Some(folder) = std::env::var_os("SEEDS_LAYOUTS") {
        let entries = std::fs::read_dir(folder).expect("a folder");
        let paths = entries.map(|e| e.expect("an entry").path().display().to_string());
        all.extend(paths.filter(|p| p.ends_with(".apt.dat")));
    }
    all.iter().map(|layout| keys_of(layout)).collect()
}

/// The keys of an airport: its layout, and its ground network where one lies beside it.
fn keys_of(layout: &str) -> String {
    let network = layout.replace(".apt.dat", ".groundnet.xml");
    let there = network != layout && PathBuf::from(&network).exists();
    let network = if there { format!("\nground_network = \"{network}\"") } else { String::new() };
    format!("layout = \"{layout}\"{network}")
}

/// Runway ends of landings and take-offs in an hour, by index of runway and end, with the network.
fn ends_in_use(airport: &str, weather: &str, keys: &str) -> Result<[Ends; 2], String> {
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = 1\nduration_s = 3600\n[airport]\n{airport}\n{weather}\n[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = 20\ndepartures_per_h = 20\n{keys}\n"
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("ends.toml");
    let scene = scenarios::load_text(&path, &text).map_err(|e| e.to_string())?;
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let of = |direction: Direction| {
        let own = behaving.flights.iter().filter(|f| f.direction == direction);
        let ends: BTreeSet<(usize, usize)> = own.map(|f| f.runway).collect();
        let end = |(r, e)| End::of(&behaving.network, r, e);
        ends.into_iter().map(end).collect()
    };
    Ok([of(Direction::Arrival), of(Direction::Departure)])
}

type Ends = Vec<End>;

#[derive(Clone, Debug, PartialEq)]
struct End {
    name: String,
    /// Direction of landings and take-offs, rad.
    towards_rad: f64,
}

impl End {
    fn of(network: &Network, r: usize, end: usize) -> Self {
        let runway = &network.runways[r];
        let towards = runway.ends_m[1 - end] - runway.ends_m[end];
        Self { name: runway.names[end].clone(), towards_rad: Azimuth::of(towards).rad() }
    }

    fn apart_deg(&self, other_rad: f64) -> f64 {
        wrap_pi(self.towards_rad - other_rad).abs().to_degrees()
    }
}

fn none_head_on(case: &str, [landing, leaving]: &[Ends; 2]) {
    for (lands, leaves) in landing.iter().flat_map(|a| leaving.iter().map(move |d| (a, d))) {
        assert!(lands.apart_deg(leaves.towards_rad) <= 120.0, "{case}: {lands:?}, {leaves:?}");
    }
}

/// Manchester landed on 05L and took off from 23L, Seattle on 16L and from 34C.
#[test]
fn nobody_takes_off_towards_those_who_land() {
    let mut looked = 0;
    for airport in airports() {
        let Ok(both) = ends_in_use(&airport, "", "") else { continue };
        println!("{airport}: {both:?}");
        none_head_on(&airport, &both);
        looked += usize::from(both.iter().all(|ends| !ends.is_empty()));
        // Beside an end that is named for one, the other goes the same way.
        for (named, key) in ["arrival_runways", "departure_runways"].into_iter().enumerate() {
            for end in both.iter().flatten() {
                let keys = format!("{key} = [\"{}\"]", end.name);
                let Ok(other) = ends_in_use(&airport, "", &keys) else { continue };
                assert!(other[named].iter().all(|e| e == end), "{airport} {keys}: {other:?}");
                none_head_on(&format!("{airport} {keys}"), &other);
            }
        }
    }
    assert!(looked >= 6, "{looked}");
}

/// From wherever it blows: nobody has more than 5 kt of it from behind, where he could land or take off against it.
#[test]
fn traffic_lands_and_takes_off_against_the_wind() {
    let (mut looked, mut turned) = (0, 0);
    for airport in airports() {
        let Ok(calm) = ends_in_use(&airport, "", "") else { continue };
        for from_deg in (0..360).step_by(30) {
            let weather = format!(
                "[weather]\ntimeline = [{{ at_s = 0, wind_mps = 9.0, wind_from_deg = {from_deg} }}]"
            );
            let Ok(both) = ends_in_use(&airport, &weather, "") else { continue };
            none_head_on(&format!("{airport} {from_deg}"), &both);
            for (end, arrival) in both
                .iter()
                .zip([true, false])
                .flat_map(|(ends, a)| ends.iter().map(move |e| (e, a)))
            {
                let tail_mps = -9.0 * libm::cos(f64::from(from_deg).to_radians() - end.towards_rad);
                if tail_mps > 2.58 {
                    println!("{airport} {from_deg}: {end:?} {arrival} {tail_mps:.1}");
                }
                assert!(
                    tail_mps <= 2.58,
                    "{airport}, wind from {from_deg}: {end:?}, {tail_mps} m/s"
                );
            }
            looked += 1;
            turned += usize::from(both != calm);
        }
        // What hardly blows, or comes when nobody lands or leaves any more, changes nothing.
        for notice in [
            "at_s = 3600, wind_mps = 9.0, wind_from_deg = 40",
            "at_s = 0, wind_mps = 2.4, wind_from_deg = 40",
        ] {
            let weather = format!("[weather]\ntimeline = [{{ {notice} }}]");
            assert_eq!(
                ends_in_use(&airport, &weather, "").as_ref(),
                Ok(&calm),
                "{airport}: {notice}"
            );
        }
    }
    assert!(looked >= 60 && turned >= 20, "{looked} {turned}");
}

/// A gale across the runway that one uses in calm: the one along the wind is taken, where there is one.
#[test]
fn a_gale_from_the_side_takes_another_runway() {
    let airports = airports();
    for icao in ["LSZH", "EHAM", "XSYN"] {
        let airport = airports.iter().find(|a| a.contains(icao)).expect(icao);
        let calm = ends_in_use(airport, "", "").expect("in use");
        for aside_deg in [90.0, -90.0] {
            let from_deg = (calm[0][0].towards_rad.to_degrees() + aside_deg).rem_euclid(360.0);
            let blown = |mps: f64| {
                let weather = format!(
                    "[weather]\ntimeline = [{{ at_s = 0, wind_mps = {mps}, wind_from_deg = {from_deg} }}]"
                );
                ends_in_use(airport, &weather, "").expect("in use")
            };
            let along = |ends: &[Ends; 2]| ends[0][0].apart_deg(calm[0][0].towards_rad);
            assert!(along(&blown(11.9)) % 180.0 < 1.0, "{icao}: {:?}", blown(11.9));
            let gale = blown(13.5);
            assert!((20.0..160.0).contains(&along(&gale)), "{icao}: {calm:?}, {gale:?}");
        }
    }
}

/// What a scene says of its ends is looked at also where nobody comes of its demand, and what is silly about it is told.
#[test]
fn ends_that_a_scene_names_are_looked_at() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("named-ends");
    std::fs::create_dir_all(&folder).expect("a folder");
    let read = |airport: &str, duration_s: u32, keys: &str| {
        let text = format!(
            "[run]\ntitle = \"t\"\nduration_s = {duration_s}\n[airport]\n{airport}\n[[traffic]]\nkind = \"generated\"\n\
             arrivals_per_h = 15\ndepartures_per_h = 15\n{keys}\n"
        );
        let scene = scenarios::load_text(&folder.join("scene.toml"), &text);
        scene
            .map(|s| s.traffic.behaving.expect("behaves").remarks.clone())
            .map_err(|e| e.to_string())
    };
    let told = |remarks: &[String], word: &str| {
        remarks.iter().filter(|r| r.starts_with(word)).cloned().collect::<Vec<_>>()
    };
    for (icao, lands, leaves, other) in
        [("EGCC", "23R", "05L", "23L"), ("LSZH", "28", "10", "32"), ("LZIB", "31", "13", "22")]
    {
        let layout = keys_of(&layout_of(icao).expect(icao));
        let keys = |lands: &str, leaves: &str| {
            format!("arrival_runways = [\"{lands}\"]\ndeparture_runways = [\"{leaves}\"]")
        };
        for unknown in [keys("99", leaves), keys(lands, "99")] {
            let error = read(&layout, 60, &unknown).expect_err("no such end");
            assert!(error.contains("_runways: found \"99\", allowed is"), "{icao}: {error}");
        }
        let opposite = read(&layout, 1800, &keys(lands, leaves)).expect("legal");
        let opposite = told(&opposite, "opposite ends");
        assert!(opposite.len() == 1 && opposite[0].contains(leaves), "{icao}: {opposite:?}");
        let open = read(&layout, 1800, &keys(lands, other)).expect("legal");
        assert_eq!(told(&open, "opposite ends"), Vec::<String>::new(), "{icao}");
        assert_eq!(told(&open, "closed runway"), Vec::<String>::new(), "{icao}");
        // Closed for a while, for the whole run, and after it.
        for (times, count) in
            [("from_s = 300\nuntil_s = 1500", 1), ("", 1), ("from_s = 1800\nuntil_s = 3000", 0)]
        {
            let closed = format!("[[closed]]\nrunway = \"{lands}\"\n{times}\n");
            std::fs::write(folder.join("closed.toml"), closed).expect("an overlay");
            let airport = format!("{layout}\noverlay = \"closed.toml\"");
            let remarks = read(&airport, 1800, &keys(lands, other)).expect("legal");
            assert_eq!(told(&remarks, "closed runway").len(), count, "{icao} {times}: {remarks:?}");
        }
    }
    std::fs::remove_dir_all(&folder).expect("removed");
}
