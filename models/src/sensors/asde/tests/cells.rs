//! Cells and video against closed forms.

use super::*;
use crate::frames::Vector2;

#[test]
fn cells_and_closed_centroid_see_the_same_aircraft() {
    let mut truth = Straight::new(&[
        ((-1500.0, 900.0), (0.0, 0.0)),
        ((900.0, 1800.0), (0.0, 0.0)),
        ((1200.0, -1100.0), (0.0, 0.0)),
    ]);
    truth.class.aircraft = true;
    truth.class.shape = crate::sensors::radar::sample_shapes::of(true);
    (truth.class.length_m, truth.class.span_m, truth.class.height_m) = (37.6, 35.8, 5.0);
    let run = |processing| {
        let mut radar = asde(|p| p.pfa = 1e-7).at_levels(RadarLevels::EXACT).processing(processing);
        let mut sink = PlotSink::default();
        for scan in 1..=150 {
            radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut sink);
        }
        // Mean place and plots of each target, errors along the line of sight.
        let mut found = vec![(0.0, 0.0); 3];
        for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
            if let (Some(key), Some(truth_m)) = (cause.key, cause.truth_m) {
                let along = (plot.position_m - truth_m).dot(&truth_m.coords.normalize());
                let slot = &mut found[key as usize - 1];
                *slot = (slot.0 + along, slot.1 + 1.0);
            }
        }
        found.into_iter().map(|(sum, n)| (sum / n, n)).collect::<Vec<_>>()
    };
    let (closed, cells) = (run(Processing::Plot), run(Processing::Cells));
    for (closed, cells) in closed.into_iter().zip(cells) {
        assert!(cells.1 > 120.0, "{closed:?} {cells:?}");
        assert!(
            (closed.0 - cells.0).abs() < 1.5,
            "mean along the line of sight {closed:?} {cells:?}"
        );
    }
}

/// What the cells show of a target's length and width, averaged over the looks. An airliner's length is right within a third
/// from wherever it is seen (its wings scatter little: the width is a lower bound), and a car is short.
#[test]
fn the_cells_of_an_echo_show_how_large_the_target_is() {
    use crate::fusion::extent::{Extent, Moments};
    // The nose points north.
    for (what, place, aircraft, (length, width), limits) in [
        ("airliner ahead", (0.0, 1500.0), true, (37.6, 35.8), (25.0, 45.0)),
        ("airliner aside", (1500.0, 0.0), true, (37.6, 35.8), (25.0, 45.0)),
        ("airliner askew", (-1000.0, 1000.0), true, (37.6, 35.8), (25.0, 45.0)),
        ("car", (700.0, 700.0), false, (4.6, 1.9), (0.0, 9.0)),
    ] {
        let mut truth = Straight::new(&[(place, (0.0, 0.0))]);
        truth.class.aircraft = aircraft;
        truth.class.shape = crate::sensors::radar::sample_shapes::of(aircraft);
        (truth.class.length_m, truth.class.span_m) = (length, width);
        let mut radar =
            asde(|p| p.pfa = 1e-7).at_levels(RadarLevels::EXACT).processing(Processing::Cells);
        let mut sink = PlotSink::default();
        for scan in 1..=60 {
            radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut sink);
        }
        let mut extent = Extent::default();
        for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
            let polar = plot.polar.expect("a radar's plot");
            let (Some(seen), Some(_)) = (polar.extent_m2, cause.key) else { continue };
            let (sin, cos) = libm::sincos(polar.azimuth_rad);
            let seen = Moments::turned(Vector2::new(sin, cos), seen);
            extent.learn(&seen, Some(Vector2::new(0.0, 1.0)));
        }
        let (l, w) = extent.size_m().expect("60 looks");
        println!("{what}: {l:.1} by {w:.1} m, is {length} by {width}");
        assert!((limits.0..=limits.1).contains(&l), "{what}: {l:.1} by {w:.1} m");
        assert!(w <= 1.3 * width.max(5.0), "{what}: {l:.1} by {w:.1} m");
    }
}

/// Root mean square error per axis of the plots of targets alone, and plots per look.
fn errors_of(pulse_s: f64, truth: &Straight, processing: Processing, scans: u64) -> (f64, f64) {
    let levels = RadarLevels::EXACT
        .with(RadarEffect::Merging, Level::Skipped)
        .with(RadarEffect::AircraftShadow, Level::Skipped);
    let pulse = |p: &mut AsdeParameters| {
        (p.pulse_s, p.bandwidth_hz) = (pulse_s, 1.0 / pulse_s);
        p.range_min_m = 200.0;
    };
    let mut radar = asde(pulse).at_levels(levels).processing(processing);
    let (mut sum, mut count, mut looks) = (0.0, 0.0, 0);
    for scan in 1..=scans {
        let mut sink = PlotSink::default();
        radar.scan(&interval(scan, 1.0), truth, &Weather::default(), &mut sink);
        for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
            if let Some(truth_m) = cause.truth_m {
                sum += (plot.position_m - truth_m).norm_squared();
                count += 1.0;
            }
        }
        looks += sink.looks;
    }
    ((0.5 * sum / count).sqrt(), count / looks as f64)
}

#[test]
fn plot_level_errs_like_the_cells_within_what_the_plan_says() {
    for (name, pulse_s, aircraft, length_m, span_m, rcs_m2) in [
        ("car", 36e-9, false, 4.8, 2.0, 5.0),
        ("car, long pulse", 100e-9, false, 4.8, 2.0, 5.0),
        ("light aircraft", 36e-9, true, 8.3, 11.0, 3.0),
        ("narrow body", 36e-9, true, 37.6, 35.8, 20.0),
        ("narrow body, long pulse", 100e-9, true, 37.6, 35.8, 20.0),
        ("wide body", 36e-9, true, 70.7, 64.4, 60.0),
    ] {
        for ground_m in [600.0, 1500.0, 3000.0] {
            // Eight cells of range, so that every place within a cell and every aspect comes.
            let mut truth = ring(144, ground_m, rcs_m2);
            for (i, (place_m, _)) in truth.targets.iter_mut().enumerate() {
                *place_m *= 1.0 + 0.3 * i as f64 / ground_m;
            }
            truth.class.aircraft = aircraft;
            truth.class.shape = crate::sensors::radar::sample_shapes::of(aircraft);
            (truth.class.length_m, truth.class.span_m) = (length_m, span_m);
            let (plot, plots) = errors_of(pulse_s, &truth, Processing::Plot, 16);
            let (cells, in_cells) = errors_of(pulse_s, &truth, Processing::Cells, 16);
            let mut radar = asde(|p| (p.pulse_s, p.range_min_m) = (pulse_s, 200.0));
            radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut PlotSink::default());
            let row = radar.plan().last().expect("a plan").clone();
            let differ = (plot - cells).abs();
            println!(
                "{name} at {ground_m} m: {plot:.3} and {cells:.3} m, {:.3} allowed",
                row.bound
            );
            assert_eq!((row.effect, row.unit), ("signal processing", "m"));
            assert!(differ <= row.bound, "{name} at {ground_m} m: {differ} of {}", row.bound);
            assert!((plots - in_cells).abs() < 0.01, "{name}: {plots} and {in_cells} plots a look");
        }
    }
}

#[test]
fn cells_detect_a_point_as_often_as_the_formula_within_a_few_percent() {
    // The cells lose by straddling and the beam's shape what the budget's losses had counted for it.
    for (swerling, most) in
        [(Swerling::Steady, 0.06), (Swerling::One, 0.03), (Swerling::Three, 0.03)]
    {
        for rcs_m2 in [0.002, 0.003, 0.005, 0.02] {
            let truth = ring(200, 2000.0, rcs_m2);
            let share = |processing| {
                let mut radar = asde(|p| {
                    p.swerling = swerling;
                    p.roughness_m = 1.0;
                })
                .at_levels(plain())
                .processing(processing);
                let mut out = PlotSink::default();
                for scan in 1..=30 {
                    radar.scan(&interval(scan, 1.0), &truth, &Weather::default(), &mut out);
                }
                out.plots.len() as f64 / out.looks as f64
            };
            let (plot, cells) = (share(Processing::Plot), share(Processing::Cells));
            assert!((plot - cells).abs() < most, "{swerling:?} {rcs_m2} m²: {plot} and {cells}");
        }
    }
}

#[test]
fn windows_and_video_find_the_same_plots_with_the_same_draws() {
    // Aircraft alone, two that touch, one across the beam's start; no false alarms in so few cells.
    let mut truth = Straight::new(&[
        ((400.0, 700.0), (8.0, 0.0)),
        ((-900.0, 300.0), (0.0, 9.0)),
        ((-910.0, 330.0), (0.0, 9.0)),
        ((2.0, 1100.0), (0.0, 0.0)),
        ((300.0, -1200.0), (10.0, 3.0)),
    ]);
    truth.class.aircraft = true;
    truth.class.shape = crate::sensors::radar::sample_shapes::of(true);
    (truth.class.length_m, truth.class.span_m, truth.class.height_m) = (37.6, 35.8, 5.0);
    // On the ground behind an aircraft the video has its shadow, the window has not.
    for (scan_s, swerling, ground) in [
        (1.0, Swerling::One, Level::Skipped),
        (0.25, Swerling::Steady, Level::Skipped),
        (1.0, Swerling::One, Level::Exact),
    ] {
        let run = |processing| {
            let mut radar = asde(|p| {
                p.range_max_m = 1500.0;
                p.pfa = 1e-9;
                p.swerling = swerling;
            })
            .at_levels(RadarLevels::EXACT.with(RadarEffect::GroundClutter, ground))
            .processing(processing);
            let mut sink = PlotSink::default();
            for scan in 1..=(12.0 / scan_s) as u64 {
                radar.scan(&interval(scan, scan_s), &truth, &Weather::default(), &mut sink);
            }
            let keyed = sink.plots.iter().zip(&sink.causes);
            let mut found: Vec<_> =
                keyed.filter_map(|(p, c)| Some((c.key?, p.time, p.position_m))).collect();
            found.sort_by_key(|f| (f.0, f.1));
            found
        };
        let (windows, video) = (run(Processing::Cells), run(Processing::Video));
        assert!(windows.len() > 40, "{}", windows.len());
        let (near_m, most) = if ground == Level::Skipped { (1e-9, 0) } else { (0.3, 2) };
        let apart: Vec<f64> = windows
            .iter()
            .filter_map(|a| Some((a, video.iter().find(|b| (a.0, a.1) == (b.0, b.1))?)))
            .map(|(a, b)| (a.2 - b.2).norm())
            .collect();
        let (all, worst_m) = (apart.len(), apart.iter().copied().fold(0.0, f64::max));
        let rms_m = (apart.iter().map(|d| d * d).sum::<f64>() / all as f64).sqrt();
        println!("{scan_s} s, ground {ground:?}: {rms_m} m rms, {worst_m} m worst, {all} plots");
        assert!(worst_m <= near_m && rms_m <= 0.3 * near_m, "{rms_m} m, {worst_m} m");
        assert!(windows.len() - all <= most && video.len() - all <= most);
    }
}

#[test]
fn the_video_makes_its_false_alarms_of_noise() {
    let mut radar = asde(|p| {
        p.pfa = 1e-4;
        p.range_max_m = 2000.0;
    })
    .at_levels(RadarLevels::EXACT)
    .processing(Processing::Video);
    let truth = Straight::new(&[]);
    let mut out = PlotSink::default();
    for scan in 1..=20 {
        radar.scan(&interval(scan, 0.5), &truth, &Weather::default(), &mut out);
    }
    // Cells near each other make one plot: a little less than cells times probability.
    let expected = radar.false_alarms_per(10.0);
    let found = out.plots.len() as f64;
    assert!(found < expected + 4.0 * expected.sqrt(), "{found} of {expected}");
    assert!(found > 0.98 * expected - 4.0 * expected.sqrt(), "{found} of {expected}");
    for plot in &out.plots {
        let turns = plot.time.s();
        let azimuth = (turns - turns.floor()) * TAU;
        let off = wrap_pi(plot.polar.expect("a radar's plot").azimuth_rad - azimuth);
        assert!(off.abs() < 1e-6, "{off}");
    }
}

#[test]
fn only_the_scene_asks_for_cells() {
    let truth = Straight::new(&[((1500.0, 0.0), (0.0, 0.0))]);
    let row = |tolerance: Tolerance, asked: Option<Processing>| {
        let mut radar = asde(|_| ()).tolerating(tolerance);
        if let Some(asked) = asked {
            radar = radar.processing(asked);
        }
        radar.scan(&interval(1, 1.0), &truth, &Weather::default(), &mut PlotSink::default());
        let counted = radar.tally().of(RadarEffect::Processing) > 0;
        let row = radar.plan().last().expect("a plan").clone();
        assert_eq!(counted, row.level > Level::Cheap);
        (row.level, row.called_for)
    };
    // Two processings draw differently: no tolerance on plots of the same draws can choose between them.
    assert_eq!(row(Tolerance::default(), None).0, Level::Cheap);
    assert_eq!(row(Tolerance::EXACT, None).0, Level::Cheap);
    let cells = row(Tolerance::default(), Some(Processing::Cells));
    assert_eq!(cells, (Level::Middle, "the scene asks for \"cells\"".into()));
    let video = row(Tolerance::default(), Some(Processing::Video));
    assert_eq!(video, (Level::Exact, "the scene asks for \"video\"".into()));
}
