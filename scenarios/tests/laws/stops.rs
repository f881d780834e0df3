//! Stops as they are measured, against what truth shows.

use models::traffic::core::Phase;
use std::path::Path;

fn scene(seed: u32) -> scenarios::Scene {
    let text = format!(
        "[run]\ntitle = \"t\"\nseed = {seed}\nduration_s = 3600\n[airport]\nlayout = \"airports/XSYN.apt.dat\"\n[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = 16\ndepartures_per_h = 16\n[control]\nsees = \"none\"\n"
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("stops.toml");
    scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"))
}

/// Slower than half a metre a second for five seconds while it taxies is one stop, and its time is that of the clock: four of ten stops
/// counted twice, each five seconds too long, by the last bit of a sum of times.
#[test]
fn a_stop_is_counted_once_and_lasts_as_long_as_it_does() {
    let (mut seen, mut told, mut seen_s, mut told_s) = (0, 0, 0.0, 0.0);
    for seed in [3, 4] {
        let scene = scene(seed);
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        let mut core = behaving.core(&scene.run, u64::from(seed)).expect("with truth");
        let dt = scene.run.frame.s();
        let count = core.flights().len();
        let mut still = vec![0_u32; count];
        let stops = (5.0 / dt).round() as u32;
        for frame in 1..=(3600.0 / dt) as i64 {
            core.step(frame);
            for (m, still) in still.iter_mut().enumerate() {
                let slow = core.phase(m) == Phase::Taxiing
                    && core.state(m).is_some_and(|s| s.velocity_mps.norm() < 0.5);
                *still = if slow { *still + 1 } else { 0 };
                seen += u32::from(*still == stops);
                seen_s += match *still {
                    n if n < stops => 0.0,
                    n if n == stops => 5.0,
                    _ => dt,
                };
            }
        }
        for m in 0..count {
            told += core.measures(m).stops;
            told_s += core.measures(m).stopped_s;
        }
    }
    assert!(seen >= 15, "{seen} stops");
    // The middle of a body that turns on its gear may be slower than its nose.
    assert!(told.abs_diff(seen) <= 1, "{told} told, {seen} seen");
    assert!((told_s - seen_s).abs() < 0.02 * seen_s + 6.0, "{told_s} s told, {seen_s} s seen");
}
