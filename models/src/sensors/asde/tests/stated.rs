//! What a plot states is what the radar can measure: no type, and noise that looks like noise.

use super::*;
use crate::draw::DrawKey;

/// Targets of one kind on a ring, all the same to the radar equation.
fn plots(aircraft: bool, size_m: (f64, f64), processing: Processing) -> Vec<Plot> {
    let mut truth = ring(40, 1500.0, 10.0);
    truth.class.aircraft = aircraft;
    (truth.class.length_m, truth.class.span_m, truth.class.height_m) = (size_m.0, size_m.1, 4.0);
    let mut radar = asde(|p| p.pfa = 1e-12)
        .at_levels(RadarLevels::EXACT.with(RadarEffect::FalseAlarms, Level::Skipped))
        .processing(processing);
    let mut out = PlotSink::default();
    for scan in 1..=20 {
        radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut out);
    }
    out.plots
}

#[test]
fn equal_strength_states_equal_accuracy_whatever_the_type() {
    let car = plots(false, (4.6, 1.9), Processing::Plot);
    let jumbo = plots(true, (70.7, 64.4), Processing::Plot);
    assert!(car.len() > 700 && jumbo.len() > 700);
    // The deviations as functions of the stated strength, which is all that one plot tells.
    let stated = |plots: &[Plot]| {
        let mut rows: Vec<(f64, f64, f64)> = plots
            .iter()
            .map(|p| {
                let polar = p.polar.expect("a radar's plot");
                (p.scnr_db.expect("a radar's plot"), polar.sigma_range_m, polar.sigma_azimuth_rad)
            })
            .collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        rows
    };
    let (car, jumbo) = (stated(&car), stated(&jumbo));
    let at = |rows: &[(f64, f64, f64)], db: f64| {
        rows[rows.partition_point(|r| r.0 < db).min(rows.len() - 1)]
    };
    let lowest = car[0].0.max(jumbo[0].0);
    let highest = car[car.len() - 1].0.min(jumbo[jumbo.len() - 1].0);
    for step in 0..10 {
        let db = lowest + (highest - lowest) * f64::from(step) / 10.0;
        let (a, b) = (at(&car, db), at(&jumbo, db));
        assert!((a.1 - b.1).abs() < 0.05 * a.1, "{db} dB: range {} and {} m", a.1, b.1);
        // In metres across: the range of all is that of the ring, a few metres off.
        assert!((a.2 - b.2).abs() < 0.05 * a.2, "{db} dB: azimuth {} and {}", a.2, b.2);
    }
    let mut radar = asde(|p| p.pfa = 1e-12);
    radar.parameters.glint_sigma_m = 0.0;
    assert!(jumbo[0].1 > radar.parameters.thermal_sigmas(from_db(jumbo[0].0)).0, "glint is stated");
}

#[test]
fn in_cells_the_extent_of_the_echo_says_how_far_its_centre_wanders() {
    let mean = |plots: Vec<Plot>| {
        let n = plots.len() as f64;
        plots.iter().map(|p| p.polar.expect("a radar's plot").sigma_range_m).sum::<f64>() / n
    };
    let car = mean(plots(false, (4.6, 1.9), Processing::Cells));
    let jumbo = mean(plots(true, (70.7, 64.4), Processing::Cells));
    assert!(car < 1.5 && jumbo > 1.5 * car && jumbo < 6.0, "{car} {jumbo} m");
}

/// Largest distance between the distributions of two samples.
fn apart(mut a: Vec<f64>, mut b: Vec<f64>) -> f64 {
    a.sort_by(f64::total_cmp);
    b.sort_by(f64::total_cmp);
    let share = |s: &[f64], x: f64| s.partition_point(|v| *v <= x) as f64 / s.len() as f64;
    a.iter().chain(&b).map(|x| (share(&a, *x) - share(&b, *x)).abs()).fold(0.0, f64::max)
}

#[test]
fn false_plots_have_the_strength_of_noise_that_crossed_the_threshold() {
    for pulses in [1, 4, 14] {
        let detector = Detector::new(pulses, 2e-3);
        let key = DrawKey { run_seed: u64::from(pulses), sensor: 0, entity: 0, scan: 0 };
        let mut rng = key.rng(Purpose::Study);
        // Noise as it is: sums of exponential powers, those above the threshold.
        let mut crossed = Vec::new();
        while crossed.len() < 1500 {
            let sum: f64 = (0..pulses).map(|_| exponential(&mut rng)).sum();
            if sum > detector.threshold {
                crossed.push(sum / f64::from(pulses) - 1.0);
            }
        }
        let drawn = (0..1500).map(|_| detector.noise_snr(1.0 - uniform(&mut rng))).collect();
        // Two samples of 1500: 99.9 % of distances are below 1.95 √(2/1500).
        let found = apart(crossed, drawn);
        assert!(found < 1.95 * (2.0f64 / 1500.0).sqrt(), "{pulses} pulses: {found}");
    }
    let mut radar = asde(|p| p.pfa = 1e-4);
    let mut out = PlotSink::default();
    for scan in 1..=10 {
        let nobody = Straight::new(&[]);
        radar.scan(&interval(scan, 1.0), &nobody, &Weather::default(), &mut out);
    }
    let mut rng = DrawKey { run_seed: 1, sensor: 0, entity: 0, scan: 0 }.rng(Purpose::Study);
    let shown: Vec<f64> = out.plots.iter().map(|p| from_db(p.scnr_db.expect("stated"))).collect();
    let noise: Vec<f64> =
        shown.iter().map(|_| radar.detector.noise_snr(1.0 - uniform(&mut rng))).collect();
    assert!(shown.len() > 500, "{}", shown.len());
    let limit = 1.95 * (2.0 / shown.len() as f64).sqrt();
    let found = apart(shown, noise);
    assert!(found < limit, "{found} of {limit}");
}

#[test]
fn a_detected_echo_is_as_strong_as_its_fluctuation_makes_it() {
    for swerling in [Swerling::One, Swerling::Two, Swerling::Three, Swerling::Four] {
        let detector = Detector::new(5, 1e-3);
        let mut rng = DrawKey { run_seed: 5, sensor: 0, entity: 0, scan: 0 }.rng(Purpose::Study);
        let snr = 4.0;
        let mut crossed = Vec::new();
        while crossed.len() < 1500 {
            // Powers of the echo: one for all pulses, or one each; of one or two parts.
            let parts = if matches!(swerling, Swerling::One | Swerling::Two) { 1 } else { 2 };
            let mut power =
                || (0..parts).map(|_| exponential(&mut rng)).sum::<f64>() / f64::from(parts);
            let same = matches!(swerling, Swerling::One | Swerling::Three);
            let powers: Vec<f64> =
                if same { vec![power(); 5] } else { (0..5).map(|_| power()).collect() };
            let sum: f64 = powers
                .iter()
                .map(|p| {
                    let (a, b) = normal_pair(&mut rng);
                    let (re, im) = (a / 2f64.sqrt() + (snr * p).sqrt(), b / 2f64.sqrt());
                    re * re + im * im
                })
                .sum();
            if sum > detector.threshold {
                crossed.push(sum / 5.0 - 1.0);
            }
        }
        let drawn: Vec<f64> = (0..1500)
            .map(|_| detector.measured_snr(snr, swerling, 1.0 - uniform(&mut rng)))
            .collect();
        // The closed forms are not exact at so few pulses and so low a threshold.
        let found = apart(crossed, drawn);
        assert!(found < 0.08, "{swerling:?}: {found}");
    }
    let steady = Detector::new(14, 1e-6);
    assert!((steady.measured_snr(1e3, Swerling::Steady, 0.3) - 1e3).abs() < 1e-9);
    for swerling in [Swerling::One, Swerling::Two, Swerling::Three, Swerling::Four] {
        for snr in [0.0, 1e-300, 1e-6, 1.0, 1e6, 1e12, f64::INFINITY] {
            for share in [0.0, 1e-300, 1e-9, 0.5, 1.0] {
                let found = steady.measured_snr(snr, swerling, share);
                let least = steady.threshold / 14.0 - 1.0;
                assert!(found.is_finite() && found >= least, "{swerling:?} {snr} {share}: {found}");
            }
        }
    }
}

/// What the tracker is told of noise is that of the plots that noise makes: where they begin, and how far above that they are. The tail
/// of a sum of pulses is a little steeper than the exponential one of the law; on the false plots of a radar it says "noise" and on
/// echoes a little above the threshold "target".
#[test]
fn the_strengths_that_a_tracker_is_told_are_those_of_false_plots() {
    for (pulses, most) in [(1, 0.052), (4, 0.08), (14, 0.1)] {
        let detector = Detector::new(pulses, 1e-5);
        let law = detector.strengths();
        let key = DrawKey { run_seed: u64::from(pulses), sensor: 1, entity: 0, scan: 0 };
        let mut rng = key.rng(Purpose::Study);
        let drawn: Vec<f64> =
            (0..3_000).map(|_| detector.noise_snr(1.0 - uniform(&mut rng))).collect();
        let least = drawn.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(least >= law.threshold && least < law.threshold + 0.01 * law.noise.max(1.0));
        let mean = drawn.iter().sum::<f64>() / 3_000.0 - law.threshold;
        assert!((mean / law.noise - 1.0).abs() < 0.06, "{pulses}: {mean} for {law:?}");
        let told = (0..3_000).map(|_| law.threshold + law.noise * exponential(&mut rng)).collect();
        let found = apart(drawn, told);
        assert!(found < most, "{pulses} pulses: {found}");
    }
    let mut radar = asde(|p| p.pfa = 1e-4);
    let mut out = PlotSink::default();
    for scan in 1..=10 {
        let nobody = Straight::new(&[]);
        radar.scan(&interval(scan, 1.0), &nobody, &Weather::default(), &mut out);
    }
    let law = radar.detector.strengths();
    let said: Vec<f64> =
        out.plots.iter().map(|p| law.log_ratio(from_db(p.scnr_db.expect("stated")))).collect();
    let against = said.iter().filter(|said| **said < 0.0).count();
    assert!(said.len() > 500 && against > said.len() * 9 / 10, "{against} of {}", said.len());
}
