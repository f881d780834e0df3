//! Echoes that share a cell.

use super::*;

#[test]
fn two_targets_in_one_cell_give_one_plot_between_them() {
    let near = Straight::new(&[((1500.0, 0.0), (0.0, 0.0)), ((1502.0, 1.0), (0.0, 0.0))]);
    let far = Straight::new(&[((1500.0, 0.0), (0.0, 0.0)), ((1510.0, 20.0), (0.0, 0.0))]);
    for (truth, plots) in [(near, 1), (far, 2)] {
        let mut radar = asde(|p| p.pfa = 1e-12);
        let mut out = PlotSink::default();
        radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut out);
        assert_eq!((out.plots.len(), out.looks), (plots, 2));
        // Nothing planned, everything at its exact level; and without merging, two.
        for (levels, plots) in [(RadarLevels::EXACT, plots), (plain(), 2)] {
            let mut radar = asde(|p| p.pfa = 1e-12).at_levels(levels);
            let mut out = PlotSink::default();
            radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut out);
            assert_eq!((out.plots.len(), out.looks), (plots, 2));
        }
    }
}

#[test]
fn echoes_in_one_cell_are_found_across_every_sector_border() {
    // Pairs half a beam apart, all round: each must merge wherever the border between sectors falls.
    let half = 0.125f64.to_radians() * 0.5;
    let mut targets = Vec::new();
    for i in 0..180 {
        let azimuth = (f64::from(i) * 2.0 + 1.0).to_radians() + 0.001 * f64::from(i % 7);
        for side in [-half, half] {
            let (sin, cos) = libm::sincos(azimuth + side);
            targets.push(((2000.0 * sin, 2000.0 * cos), (0.0, 0.0)));
        }
    }
    let truth = Straight::new(&targets);
    let mut radar = asde(|p| p.pfa = 1e-12);
    let mut out = PlotSink::default();
    radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut out);
    assert_eq!((out.looks, out.plots.len()), (360, 180));
}

#[test]
fn two_targets_across_the_end_of_a_scan_are_one_plot_as_anywhere_else() {
    // The beam starts at azimuth 0: pairs on both sides of it, of either order, 1.5 m or 30 m apart.
    // Ten scans a turn have their ends elsewhere; the last pair stands across one of those.
    let tenth = TAU / 10.0;
    for (name, azimuth, swap, apart_m, together) in [
        ("north", 0.0, false, 1.5, true),
        ("north, the later one first", 0.0, true, 1.5, true),
        ("a tenth of a turn", tenth, false, 1.5, true),
        ("apart", 0.0, false, 30.0, false),
    ] {
        let place = |side: f64| {
            let (sin, cos) = libm::sincos(azimuth + side * 0.5 * apart_m / 1500.0);
            ((1500.0 * sin, 1500.0 * cos), (0.0, 0.0))
        };
        let sides = if swap { [1.0, -1.0] } else { [-1.0, 1.0] };
        let truth = Straight::new(&sides.map(place));
        for scan_s in [1.0, 0.1] {
            let mut radar = asde(|p| p.pfa = 1e-12);
            let mut out = PlotSink::default();
            let scans = (20.0 / scan_s) as u64;
            for scan in 1..=scans {
                radar.scan(&interval(scan, scan_s), &truth, &Weather::default(), &mut out);
            }
            // Before the first turn is complete the beam has passed only one of a pair across its start.
            let wanted = if together { 20.0 } else { 40.0 };
            let found = out.plots.len() as f64;
            assert!((found - wanted).abs() <= 1.0, "{name}, {scan_s} s: {found} plots");
            if together {
                let amid = |plot: &Plot| {
                    let off = wrap_pi(plot.polar.expect("a radar's plot").azimuth_rad - azimuth);
                    off.abs() * 1500.0 < 3.0
                };
                assert!(out.plots.iter().all(amid), "{name}");
            }
        }
    }
}
