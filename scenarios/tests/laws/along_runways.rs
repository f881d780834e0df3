//! Who taxies keeps off the runways of others where there is another stand or another exit.

use models::traffic::core::{Direction, Phase};
use std::path::Path;

const LIMC: &str =
    "layout = \"airports/LIMC.apt.dat\"\nground_network = \"airports/LIMC.groundnet.xml\"";

/// Arrivals that taxied along a runway for longer than a crossing takes, each with for how long, s, and flights that have landed.
fn along_runways(airport: &str, seed: u64) -> (Vec<(String, i64)>, usize) {
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 1200\n[airport]\n{airport}\n[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = 15\ndepartures_per_h = 15\n"
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("along.toml");
    let scene = scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"));
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let mut core = behaving.core(&scene.run, seed).expect("with truth");
    let flights = core.flights().to_vec();
    let mut along_s = vec![0; flights.len()];
    for frame in 1..=24_000 {
        core.step(frame);
        if frame % 20 != 0 {
            continue;
        }
        for (m, flight) in flights.iter().enumerate() {
            if flight.direction != Direction::Arrival || core.phase(m) != Phase::Taxiing {
                continue;
            }
            let Some(state) = core.state(m) else { continue };
            let at_m = state.position_m.xy();
            along_s[m] += i64::from(behaving.network.runways.iter().any(|r| {
                let (along_m, off_m) = r.place_m(at_m);
                (0.0..=r.length_m).contains(&along_m) && off_m.abs() < 10.0
            }));
        }
    }
    let landed = (0..flights.len()).filter(|m| core.measures(*m).aldt_s.is_some()).count();
    let long = |m: &usize| along_s[*m] > 30;
    let found =
        (0..flights.len()).filter(long).map(|m| (flights[m].callsign.to_string(), along_s[m]));
    (found.collect(), landed)
}

/// Malpensa's north stands lie behind a turn of 169 degrees for who comes from the west runway: the way round it led 3.7 km along
/// the other runway, against those who take off there.
#[test]
fn an_arrival_does_not_taxi_along_the_runway_of_those_who_take_off() {
    for seed in 1..=3 {
        let (found, landed) = along_runways(LIMC, seed);
        assert!(landed >= 2, "seed {seed}: {landed} landed");
        assert_eq!(found, [], "seed {seed}");
    }
}
