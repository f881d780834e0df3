//! What control knows of stands: those of the flight data list, and what generators tell after it.

use super::TrafficGenerator;
use crate::runtime::federate::{Federate, FrameInputs, FrameOut};
use crate::runtime::messages::{Notice, RunConfig};
use models::frames::Point2;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// An arrival whose stand was not free got another, which control was never told: "stand occupied" stood until it was in block (3 to 7 an
/// hour at Bratislava and XSYN, none of them so).
#[test]
fn control_is_told_who_gets_another_stand_than_planned() {
    let text = "[run]\ntitle = \"t\"\nseed = 1\nduration_s = 3600\n[airport]\nlayout = \"airports/XSYN.apt.dat\"\n\
                [[traffic]]\nkind = \"generated\"\narrivals_per_h = 24\ndepartures_per_h = 24\n[control]\nsees = \"tracks\"\n";
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/stands.toml");
    let scene = scenarios::load_text(&path, text).unwrap_or_else(|e| panic!("{e}"));
    let scene = Arc::new(scene);
    let behaving = scene.traffic.behaving.as_ref().expect("behaves");
    let config = RunConfig { run: 1, seed: 1, generators: 2, ..RunConfig::default() };
    let mut out = FrameOut::default();
    let mut generators: Vec<TrafficGenerator> =
        [1, 2].map(|share| TrafficGenerator::new(Arc::clone(&scene), 1, share, 2)).into();
    for generator in &mut generators {
        generator.configure(&config, &mut out).expect("it goes");
    }
    let mut core = behaving.told_core(&scene.run, 1).expect("with truth");
    let at_m = |core: &models::traffic::core::Core, flight: usize| core.stand_m(core.stand(flight));
    let listed = |callsign: &str| {
        let entry = |e: &&models::flight_list::FlightEntry| e.callsign.as_str() == callsign;
        let entry = scene.flight_list.entries.iter().find(entry);
        entry.and_then(|e| e.stand_m)
    };
    let mut known: BTreeMap<String, Point2<f64>> = BTreeMap::new();
    let mut told = 0;
    for frame in 1..=72_000 {
        core.step(frame as i64);
        for generator in &mut generators {
            generator.step(frame, &FrameInputs::default(), &mut out);
        }
        for notice in std::mem::take(&mut out).notices {
            let Notice::Stands(stands) = notice else { continue };
            told += stands.len();
            known.extend(stands.into_iter().map(|s| (s.callsign, s.stand_m)));
        }
        if frame % 20 != 0 {
            continue;
        }
        for (flight, f) in core.flights().iter().enumerate() {
            let stand_m = known.get(&f.callsign).copied().or_else(|| listed(&f.callsign));
            assert_eq!(stand_m, Some(at_m(&core, flight)), "{} at frame {frame}", f.callsign);
        }
    }
    assert!(told >= 3, "{told} changes: nothing was put to the test");
    assert!(told < 200, "{told}: each change once");
}
