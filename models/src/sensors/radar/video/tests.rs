use super::*;
use crate::sensors::TargetClass;
use crate::sensors::radar::detection::{Swerling, from_db};
use crate::sensors::radar::extended::{centroid_of, echoes, half_extent_m};

fn radar() -> CellRadar {
    let (pulses, pfa) = (14, 1e-6);
    CellRadar {
        cell_m: 5.4,
        range_min_m: 500.0,
        cells: 300,
        beams: 1440,
        width_rad: 0.25_f64.to_radians(),
        pulses,
        pfa,
        threshold: Detector::new(pulses, pfa).threshold,
        recovered: 1.0,
    }
}

/// Fades and looks at one target in its window.
fn window(
    radar: &CellRadar,
    echoes: &[PointEcho],
    background: f64,
    fading: Fading,
    key: DrawKey,
    work: &mut CellWork,
) -> Vec<Blob> {
    let mut echoes = echoes.to_vec();
    fading.fade(&mut echoes, key);
    radar.window(&mut echoes, |_| background, key, work)
}

fn key(scan: u64) -> DrawKey {
    DrawKey { run_seed: 3, sensor: 1, entity: 42, scan }
}

#[test]
fn variates_have_their_orders_moments() {
    let mut rng = key(0).rng(Purpose::Study);
    for order in [0, 1, 2, 14, 16, 17, 40] {
        let n = 40_000;
        let (mut sum, mut square) = (0.0, 0.0);
        for _ in 0..n {
            let x = gamma_order(order, &mut rng);
            sum += x;
            square += x * x;
        }
        let (mean, wanted) = (sum / f64::from(n), f64::from(order));
        let variance = square / f64::from(n) - mean * mean;
        assert!((mean - wanted).abs() <= 4.0 * (wanted / f64::from(n)).sqrt(), "{order}: {mean}");
        assert!((variance - wanted).abs() <= 0.06 * wanted, "{order}: {variance}");
    }
}

#[test]
fn a_cell_is_detected_as_often_as_the_detector_says() {
    let detector = Detector::new(14, 1e-2);
    let radar = CellRadar { pfa: 1e-2, threshold: detector.threshold, ..radar() };
    for (snr_db, background) in [(-300.0, 1.0), (-10.0, 1.0), (-5.0, 1.0), (0.0, 1.0), (3.0, 2.0)] {
        let snr = from_db(snr_db);
        let mut rng = key(7).rng(Purpose::Study);
        let n = 30_000;
        let limit = radar.threshold * background;
        let hits = (0..n).filter(|_| radar.draw(snr, background, &mut rng) >= limit).count();
        let expected = detector.probability(snr / background, Swerling::Steady);
        let sigma = (expected * (1.0 - expected) / f64::from(n)).sqrt();
        let found = hits as f64 / f64::from(n);
        assert!((found - expected).abs() < 4.0 * sigma, "{snr_db} dB: {found} {expected}");
    }
}

#[test]
fn shares_are_shares() {
    let radar = radar();
    let beams: f64 =
        (-5..=5).map(|b| radar.beam_share(f64::from(b) * radar.beam_step_rad() + 1e-4)).sum();
    // Summed over beam positions: the two-way width over the step.
    assert!((beams - 0.752_69).abs() < 1e-3, "{beams}");
    assert_eq!(radar.range_share(0.0), 1.0);
    assert_eq!(radar.range_share(6.0), 0.0);
    let straddling = radar.straddling_share();
    assert!(straddling > 0.3 && straddling < 0.6, "{straddling}");
}

#[test]
fn cfar_keeps_its_false_alarms() {
    // One pulse: Pfa = (1 + factor/K)^(−K) in closed form.
    for (cells, pfa) in [(16_u32, 1e-6), (32, 1e-3), (8, 1e-4)] {
        let k = f64::from(cells);
        let closed = k * (libm::pow(pfa, -1.0 / k) - 1.0);
        assert!((cfar_factor(1, cells, pfa) / closed - 1.0).abs() < 1e-9);
    }
    let detector = Detector::new(14, 1e-3);
    // Many reference cells know the background.
    assert!((14.0 * cfar_factor(14, 1 << 20, 1e-3) / detector.threshold - 1.0).abs() < 1e-3);
    let radar = CellRadar { pfa: 1e-3, threshold: detector.threshold, beams: 720, ..radar() };
    for threshold in [Threshold::Known, Threshold::CellAveraging { guard: 2, reference: 16 }] {
        // Clutter that falls with range: known exactly, or nearly constant over the reference cells.
        let fill = |_, row: &mut [f64]| {
            for (c, level) in (0..).zip(row) {
                *level = 1.0 + 1e5 / radar.cell_centre_m(c).powi(2);
            }
            true
        };
        let video = radar.video([], fill, threshold, key(1));
        let hits: u32 = video.blobs.iter().map(|b| b.cells).sum();
        let expected = 1e-3 * (radar.beams * radar.cells) as f64;
        assert!(
            (f64::from(hits) - expected).abs() < 5.0 * expected.sqrt(),
            "{threshold:?}: {hits}"
        );
    }
}

#[test]
fn a_strong_point_is_where_it_is() {
    let radar = radar();
    let mut work = CellWork::default();
    for (name, azimuth_rad) in [("north", 0.0), ("south", PI), ("somewhere", 1.0), ("seam", -1e-9)]
    {
        let (mut range, mut azimuth, mut square, mut seen) = (0.0, 0.0, 0.0, 0.0);
        for scan in 0..400 {
            // The place within the cell differs from scan to scan.
            let range_m = 1000.0 + 0.37 * scan as f64;
            let echo = PointEcho { range_m, azimuth_rad, snr: 300.0 };
            let blobs = window(&radar, &[echo], 1.0, Fading::Steady, key(scan), &mut work);
            let blob = blobs.first().expect(name);
            let (dr, da) = (blob.range_m - range_m, wrap_pi(blob.azimuth_rad - azimuth_rad));
            range += dr;
            azimuth += da;
            square += dr * dr;
            seen += 1.0;
        }
        assert!((range / seen).abs() < 0.2, "{name}: {}", range / seen);
        assert!((square / seen).sqrt() < 1.2, "{name}: {}", (square / seen).sqrt());
        assert!((azimuth / seen).abs() < 0.3 * radar.width_rad, "{name}: {}", azimuth / seen);
    }
}

#[test]
fn two_targets_in_neighbouring_cells_are_one_plot_and_apart_two() {
    let radar = radar();
    let target = |range_m| PointEcho { range_m, azimuth_rad: 0.5, snr: 100.0 };
    let mut work = CellWork::default();
    for (apart_m, plots) in [(3.0, 1), (40.0, 2)] {
        let pair = [target(1000.0), target(1000.0 + apart_m)];
        let blobs = window(&radar, &pair, 1.0, Fading::Steady, key(5), &mut work);
        assert_eq!(blobs.len(), plots, "{apart_m} m apart");
        let video = radar.video(pair, |_, _| true, Threshold::Known, key(5));
        let near = video.blobs.iter().filter(|b| b.excess > 100.0).count();
        assert_eq!(near, plots, "{apart_m} m apart in the picture");
    }
}

#[test]
fn an_aircraft_in_cells_has_the_centroid_and_glint_of_the_closed_form() {
    let class = TargetClass {
        designator: "A320".into(),
        aircraft: true,
        length_m: 37.6,
        span_m: 35.8,
        height_m: 11.8,
        rcs_m2: 20.0,
        shape: crate::sensors::radar::sample_shapes::of(true),
    };
    let radar = radar();
    let mut work = CellWork::default();
    for view in [0.3, 1.2, 2.5] {
        let scatterers = echoes(&class, view);
        let closed = centroid_of(&scatterers).expect("an echo");
        let (mut sum, mut square, mut n) = (0.0, 0.0, 0.0);
        for scan in 0..600 {
            let points: Vec<_> = point_echoes(&scatterers, 1500.0, 0.7, 1500.0, 2000.0).collect();
            let blobs = window(&radar, &points, 1.0, Fading::Gamma(1), key(scan), &mut work);
            let Some(blob) = blobs.first() else { continue };
            let along = blob.range_m - 1500.0;
            sum += along;
            square += along * along;
            n += 1.0;
        }
        assert!(n > 590.0);
        let mean = sum / n;
        let sigma = f64::sqrt(square / n - mean * mean);
        let (extent_m, _) = half_extent_m(&class, view);
        assert!((mean - closed.bias_along_m).abs() < 1.5, "{view}: {mean} {closed:?}");
        assert!(
            sigma > 0.5 * closed.glint_along_m && sigma < 1.8 * closed.glint_along_m + 0.6,
            "{view}: {sigma} {closed:?}"
        );
        assert!(mean.abs() < extent_m);
    }
}

#[test]
fn a_target_more_changes_no_other_cell() {
    let radar = CellRadar { beams: 360, width_rad: 1_f64.to_radians(), ..radar() };
    let echo = PointEcho { range_m: 1200.0, azimuth_rad: -0.001, snr: 50.0 };
    let video = |echoes: &[PointEcho]| {
        radar.video(echoes.iter().copied(), |_, _| true, Threshold::Known, key(2))
    };
    let (empty, one) = (video(&[]), video(&[echo]));
    let changed: Vec<usize> =
        (0..empty.power.len()).filter(|&i| empty.power[i] != one.power[i]).collect();
    // Those that it lights, and no others.
    let middle = ((1200.0 - radar.range_min_m) / radar.cell_m) as usize;
    assert!(changed.iter().all(|i| (i % radar.cells).abs_diff(middle) <= 1), "{changed:?}");
    let rows: std::collections::BTreeSet<_> = changed.iter().map(|i| i / radar.cells).collect();
    assert!(!rows.is_empty() && rows.len() <= 7, "{rows:?}");
    assert!(rows.contains(&0) && rows.contains(&359), "both sides of north: {rows:?}");
}

#[test]
fn windows_at_the_edges_and_hard_inputs_answer() {
    let radar = radar();
    let mut work = CellWork::default();
    let echo = |range_m, snr| PointEcho { range_m, azimuth_rad: 0.0, snr };
    assert!(window(&radar, &[], 1.0, Fading::Steady, key(1), &mut work).is_empty());
    for (name, range_m, snr) in [
        ("before the first cell", 0.0, 1e3),
        ("beyond the last cell", 1e5, 1e3),
        ("at the first edge", 500.0, 1e3),
        ("at the last edge", 500.0 + 300.0 * 5.4, 1e3),
        ("no signal", 1000.0, 0.0),
        ("huge signal", 1000.0, 1e12),
    ] {
        for blob in window(&radar, &[echo(range_m, snr)], 1.0, Fading::Steady, key(1), &mut work) {
            assert!(blob.range_m.is_finite() && blob.azimuth_rad.is_finite(), "{name}: {blob:?}");
            assert!(blob.range_m >= 500.0 && blob.range_m <= 500.0 + 300.0 * 5.4, "{name}");
        }
    }
    let loose = CellRadar { pfa: 0.9, threshold: 1.0, ..radar };
    let blobs = window(&loose, &[echo(1000.0, 0.0)], 1.0, Fading::Steady, key(1), &mut work);
    assert!(blobs.iter().all(|b| b.range_m.is_finite()));
}
