//! When targets are seen.

use super::*;

#[test]
fn every_target_is_seen_once_per_turn_when_the_beam_points_at_it() {
    // Across the starting direction both ways, round the radar, away from it, and standing still.
    let truth = Straight::new(&[
        ((-50.0, 2000.0), (3.0, 0.0)),
        ((50.0, 2000.0), (-3.0, 0.0)),
        ((0.0, 2000.0), (0.0, 0.0)),
        ((0.0, -2000.0), (0.0, 0.0)),
        ((1000.0, 0.0), (0.0, 80.0)),
        ((-900.0, 300.0), (25.0, -3.0)),
    ]);
    for (scan_s, rpm) in [(1.0, 60.0), (0.3, 60.0), (1.0, 41.0), (2.5, 60.0)] {
        let radar = asde(|p| p.rotation_rpm = rpm);
        let scans = (60.0 / scan_s) as u64;
        let mut last = vec![None::<f64>; truth.len()];
        let mut count = vec![0u32; truth.len()];
        let mut looks = Vec::new();
        for scan in 1..=scans {
            let interval = interval(scan, scan_s);
            for index in 0..truth.len() {
                looks.clear();
                radar.looks(&interval, &radar.sweep(&interval), &truth, index, None, &mut looks);
                for look in looks.iter().filter(|look| look.number != looks::NEXT) {
                    assert!(interval.from < look.time && look.time <= interval.to);
                    let miss = wrap_pi(radar.beam_rad(look.time) - radar.azimuth_rad(&look.state));
                    assert!(miss.abs() < 1e-5, "target {index}: beam off by {miss:e} rad");
                    if let Some(previous) = last[index] {
                        let turn = (look.time.s() - previous) * rpm / 60.0;
                        assert!((turn - 1.0).abs() < 0.05, "target {index}: {turn} turns");
                    }
                    last[index] = Some(look.time.s());
                    count[index] += 1;
                }
            }
        }
        let turns = rpm / 60.0 * scans as f64 * scan_s;
        assert!(count.iter().all(|&n| (f64::from(n) - turns).abs() <= 1.0), "{count:?} of {turns}");
    }
}

#[test]
fn the_beam_passes_what_it_sweeps_and_what_is_as_near_as_the_margin() {
    // From north to east.
    let radar = asde(|p| (p.rotation_rpm, p.start_azimuth_deg) = (60.0, 0.0));
    let sweep = radar.sweep(&interval(1, 0.25));
    for (degrees, margin, passes) in [
        (45.0, 0.0, true),
        (100.0, 0.0, false),
        (100.0, 11.0, true),
        (-10.0, 0.0, false),
        (-10.0, 11.0, true),
        (180.0, 11.0, false),
        (-135.0, 0.0, false),
        (360.0 + 45.0, 0.0, true),
    ] {
        let (azimuth, margin_rad) = (f64::to_radians(degrees), f64::to_radians(margin));
        assert_eq!(sweep.passes(azimuth, margin_rad), passes, "{degrees} with {margin}");
    }
}
