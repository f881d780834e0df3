//! What is detected and measured, and where it is displayed.

use super::*;
use crate::frames::Point2;

#[test]
fn a_plot_tells_where_the_target_was_at_its_own_time() {
    let truth = Straight::new(&[((1500.0, 700.0), (-40.0, 20.0))]);
    let mut radar = asde(|p| {
        p.pfa = 1e-12;
        p.assumed_height_m = 1.5;
    })
    .at_levels(RadarLevels::EXACT.with(RadarEffect::Extent, Level::Skipped));
    let mut out = PlotSink::default();
    for scan in 1..=200 {
        radar.scan(&interval(scan, 0.1), &truth, &Weather::default(), &mut out);
    }
    assert!(out.plots.len() >= 18, "{}", out.plots.len());
    for (plot, cause) in out.plots.iter().zip(&out.causes) {
        let there = truth.at(0, plot.time).expect("exists").position_m.xy();
        assert!((cause.truth_m.expect("known") - there).norm() < 1e-9);
        let miss = plot.position_m - there;
        let (along, across) = (miss.dot(&plot.axis), miss.dot(&plot.across_axis()));
        let squared = along * along / plot.along_m2 + across * across / plot.across_m2;
        assert!(squared < 25.0, "{squared}: {miss:?}");
    }
}

#[test]
fn false_alarms_come_as_often_as_cells_and_probability_say() {
    let mut radar = asde(|p| p.pfa = 1e-5);
    let truth = Straight::new(&[]);
    let mut out = PlotSink::default();
    for scan in 1..=300 {
        radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut out);
    }
    let expected = radar.false_alarms_per(300.0);
    let found = out.plots.len() as f64;
    assert!((found - expected).abs() < 4.0 * expected.sqrt(), "{found} of {expected}");
    assert!(out.causes.iter().all(|cause| cause.key.is_none()));
}

#[test]
fn outside_its_limits_a_parameter_is_refused_with_key_value_and_limits() {
    type Change = fn(&mut AsdeParameters);
    let cases: [(&str, Change); 10] = [
        ("carrier_ghz", |p| p.carrier_ghz = 0.5),
        ("azimuth_beamwidth_deg", |p| p.azimuth_beamwidth_deg = 0.0),
        ("antenna_height_m", |p| p.antenna_height_m = -1.0),
        ("pfa", |p| p.pfa = 0.0),
        ("peak_power_w", |p| p.peak_power_w = f64::NAN),
        ("rotation_rpm", |p| p.rotation_rpm = 0.0),
        ("range_max_m", |p| p.range_max_m = 8000.0),
        ("range_min_m", |p| p.range_min_m = 5.0),
        ("noise_figure_db", |p| p.noise_figure_db = -1.0),
        ("pulses on target (prf, beamwidth, rotation)", |p| p.azimuth_beamwidth_deg = 20.0),
    ];
    for (key, change) in cases {
        let mut parameters = AsdeParameters::ku_band();
        change(&mut parameters);
        let error = parameters.validate().expect_err(key);
        assert!(error.to_string().starts_with(key), "{key}: {error}");
    }
}

#[test]
fn a_hundred_thousand_plots_deviate_as_the_formulas_say() {
    for energy in [Energy::SinglePulse, Energy::Dwell { factor: 1.5 }] {
        let truth = ring(200, 2000.0, 3.0);
        let mut radar = asde(|p| p.energy = energy).at_levels(plain());
        let mut out = PlotSink::default();
        for scan in 1..=500 {
            radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut out);
        }
        assert!(out.plots.len() > 99_000, "{}", out.plots.len());
        let scnr = from_db(out.plots[0].scnr_db.expect("a radar's plot"));
        let (sigma_range_m, sigma_azimuth_rad) = radar.parameters().thermal_sigmas(scnr);
        let (mut range, mut azimuth, mut stated) = (0.0, 0.0, (0.0, 0.0));
        for (plot, cause) in out.plots.iter().zip(&out.causes) {
            let polar = plot.polar.expect("a radar's plot");
            let there = cause.truth_m.expect("known");
            let slant_m = libm::hypot(there.coords.norm(), 60.0 - 1.5);
            stated.0 += polar.sigma_range_m.powi(2);
            stated.1 += polar.sigma_azimuth_rad.powi(2);
            range += (polar.range_m - slant_m).powi(2);
            azimuth += wrap_pi(polar.azimuth_rad - Azimuth::of(there.coords).rad()).powi(2);
        }
        let n = out.plots.len() as f64;
        let (range, azimuth) = ((range / n).sqrt(), (azimuth / n).sqrt());
        assert!((range / sigma_range_m - 1.0).abs() < 0.01, "{range} of {sigma_range_m}");
        assert!((azimuth / sigma_azimuth_rad - 1.0).abs() < 0.01, "{azimuth}");
        // And each states what it deviates by.
        let stated = ((stated.0 / n).sqrt(), (stated.1 / n).sqrt());
        assert!((range / stated.0 - 1.0).abs() < 0.02, "{range} of {stated:?}");
        assert!((azimuth / stated.1 - 1.0).abs() < 0.02, "{azimuth} of {stated:?}");
    }
}

#[test]
fn targets_are_detected_as_often_as_the_formula_says_at_any_scan_length() {
    for (swerling, rcs_m2) in
        [(Swerling::Steady, 0.0028), (Swerling::One, 0.01), (Swerling::Three, 0.006)]
    {
        for scan_s in [1.0, 0.1] {
            let truth = ring(200, 2000.0, rcs_m2);
            let mut radar = asde(|p| {
                p.swerling = swerling;
                // A spread over the scene's surface: no lobes, or the ring would not be one ratio.
                p.roughness_m = 1.0;
            })
            .at_levels(plain());
            let mut out = PlotSink::default();
            for scan in 1..=((100.0 / scan_s) as u64) {
                radar.scan(&interval(scan, scan_s), &truth, &Weather::default(), &mut out);
            }
            let air = radar.air(&Weather::default());
            let echo = Echo { ground_m: 2000.0, height_m: 1.5, extent_m: 3.0, rcs_m2 };
            let to = Point2::new(0.0, 2000.0);
            let levels = BudgetLevels::EXACT;
            let budget = radar.radar.budget(&air, &levels, &echo, Point2::origin(), to);
            let pd = radar.detector.probability(budget.scnr(), swerling);
            assert!(pd > 0.1 && pd < 0.95, "{swerling:?}: {pd}");
            let n = out.looks as f64;
            assert!((n - 20_000.0).abs() < 201.0, "{n} looks");
            let found = out.plots.len() as f64 / n;
            let sigma = (pd * (1.0 - pd) / n).sqrt();
            assert!((found - pd).abs() < 4.0 * sigma, "{swerling:?} {scan_s} s: {found} of {pd}");
        }
    }
}

#[test]
fn an_echo_from_beyond_the_unambiguous_range_appears_nearer() {
    // 20 kHz: 7.49 km. A landing aircraft at 8.5 km appears at about 1 km.
    let mut truth = Straight::new(&[((0.0, 8500.0), (0.0, 0.0))]);
    truth.class.rcs_m2 = 1e4;
    let plots = |frequency_agile| {
        let mut radar = asde(|p| (p.pfa, p.frequency_agile) = (1e-12, frequency_agile));
        let mut out = PlotSink::default();
        for scan in 1..=5 {
            radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut out);
        }
        out.plots
    };
    // Where the carrier hops, the receiver listens at that of the next pulse.
    assert!(plots(true).is_empty());
    let plots = plots(false);
    assert!(!plots.is_empty());
    let range_m = plots[0].polar.expect("a radar's plot").range_m;
    assert!((range_m - (8500.0 - 7494.8)).abs() < 5.0, "{range_m}");
}

#[test]
fn a_target_that_is_displayed_has_its_plots_at_the_edge_too() {
    // The centre of an echo lies before the middle of a body, and wanders.
    let mut car = Straight::new(&[((0.0, 901.4), (0.0, 0.0))]);
    let mut aircraft = Straight::new(&[((0.0, 903.0), (0.0, 0.0))]);
    aircraft.class = crate::sensors::testing::class(true, 37.6, 35.8, 20.0);
    for truth in [&mut car, &mut aircraft] {
        let slant_m = libm::hypot(truth.targets[0].0.y, 42.7 - 0.5 * truth.class.height_m);
        for (near_m, far_m) in
            [(slant_m - 0.01, 5e3), (slant_m - 0.9, 5e3), (200.0, slant_m + 0.01)]
        {
            for levels in [None, Some(RadarLevels::EXACT)] {
                let mut radar = asde(|p| {
                    (p.range_min_m, p.range_max_m, p.pfa) = (near_m, far_m, 1e-12);
                    (p.range_step_m, p.antenna_height_m) = (0.0, 42.7);
                });
                radar.fixed = levels;
                let mut out = PlotSink::default();
                for scan in 1..=50 {
                    radar.scan(&interval(scan, 1.0), truth, &Weather::default(), &mut out);
                }
                assert_eq!(out.plots.len(), 50, "{near_m} to {far_m} m, {levels:?}");
                for plot in &out.plots {
                    let range_m = plot.polar.expect("of a radar").range_m;
                    assert!(near_m <= range_m && range_m <= far_m, "{range_m} is displayed");
                }
            }
        }
        // And one that is just not has none.
        let mut radar = asde(|p| {
            (p.range_min_m, p.pfa, p.antenna_height_m) = (slant_m + 0.01, 1e-12, 42.7);
        });
        let mut out = PlotSink::default();
        for scan in 1..=50 {
            radar.scan(&interval(scan, 1.0), truth, &Weather::default(), &mut out);
        }
        assert_eq!(out.plots.len(), 0);
    }
}
