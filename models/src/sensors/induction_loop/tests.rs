use super::*;
use crate::frames::{Point2, Vector3};
use crate::sensors::testing::Parked;

/// A target that starts 60 m before the loop and rolls over it, north or south.
fn pass(config: LoopConfig, speed_mps: f64, north: bool, scan_ns: i64) -> PlotSink {
    pass_at(0.0, config, speed_mps, north, scan_ns)
}

/// The same at a height, m.
fn pass_at(
    height_m: f64,
    config: LoopConfig,
    speed_mps: f64,
    north: bool,
    scan_ns: i64,
) -> PlotSink {
    let mut truth = Parked::aircraft(&[1]);
    truth.up_m = height_m;
    let sign = if north { 1.0 } else { -1.0 };
    truth.velocity_mps = Vector3::new(0.0, sign * speed_mps, 0.0);
    truth.heading_rad = if north { 0.0 } else { std::f64::consts::PI };
    // The target is at north 100 m at time 0.
    let config = LoopConfig { site_m: Point2::new(0.0, 100.0 + sign * 60.0), ..config };
    let mut sensor = InductionLoop::new(config).expect("sound");
    let mut sink = PlotSink { explain: true, ..PlotSink::default() };
    let end_ns = (150.0 / speed_mps * 1e9) as i64;
    let mut from = SimTime::ZERO;
    while from.0 < end_ns {
        let to = SimTime(from.0 + scan_ns);
        let interval = ScanInterval { run_seed: 4, scan: (to.0 / scan_ns) as u64, from, to };
        sensor.scan(&interval, &truth, &Weather::default(), &mut sink);
        from = to;
    }
    sink
}

fn config() -> LoopConfig {
    LoopConfig {
        false_per_h: 0.0,
        pd: 1.0,
        ..LoopConfig::pair_at(SensorId(6), Point2::origin(), 0.0)
    }
}

#[test]
fn a_pair_knows_the_centre_and_a_loop_the_nose() {
    for north in [true, false] {
        for speed_mps in [2.0, 10.0, 25.0] {
            let sink = pass(config(), speed_mps, north, 1_000_000_000);
            assert_eq!((sink.plots.len(), sink.looks), (1, 1), "{speed_mps} {north}");
            let (plot, truth) = (&sink.plots[0], sink.causes[0].truth_m.expect("a target"));
            let error = (plot.position_m - truth).dot(&plot.axis);
            assert!(error.abs() < 4.0 * plot.along_m2.sqrt() + 0.05 * speed_mps, "{error}");
            assert!(plot.along_m2.sqrt() < 1.0 + 0.15 * speed_mps, "{}", plot.along_m2);
            assert!(plot.across_m2.is_infinite());

            let single = LoopConfig { pair: None, ..config() };
            let sink = pass(single, speed_mps, north, 1_000_000_000);
            assert_eq!((sink.plots.len(), sink.looks), (1, 1));
            let (plot, truth) = (&sink.plots[0], sink.causes[0].truth_m.expect("a target"));
            // 37.6 m long against 30 m assumed: 3.8 m, within its stated 10 m.
            assert!((plot.position_m - truth).norm() < 6.0 + 0.05 * speed_mps);
        }
    }
}

#[test]
fn a_passage_does_not_depend_on_the_scan_interval() {
    let coarse = pass(config(), 7.3, true, 1_000_000_000);
    let fine = pass(config(), 7.3, true, 50_000_000);
    assert_eq!(coarse.plots.len(), 1);
    let (a, b) = (&coarse.plots[0], &fine.plots[0]);
    assert!((a.time.0 - b.time.0).abs() < 10_000 && (a.position_m - b.position_m).norm() < 1e-3);
}

/// What is left out for a while draws nothing from what comes afterwards.
#[test]
fn false_passages_are_the_same_after_a_time_in_which_they_were_left_out() {
    use crate::effects::positioning::PositioningLevels;
    let after_half_a_minute = |left_out: u64| {
        let every_second = LoopConfig { false_per_h: 3600.0, ..config() };
        let mut sensor = InductionLoop::new(every_second).expect("sound");
        let (truth, mut times) = (Parked::aircraft(&[]), Vec::new());
        for scan in 1..=60 {
            let level = if scan <= left_out { Level::Skipped } else { Level::Exact };
            sensor.planning_mut().fix(PositioningLevels::EXACT.with(E::FalsePassages, level));
            let at = |scan: u64| SimTime::from_s(scan as f64);
            let interval = ScanInterval { run_seed: 4, scan, from: at(scan - 1), to: at(scan) };
            let mut sink = PlotSink::default();
            sensor.scan(&interval, &truth, &Weather::default(), &mut sink);
            assert!(level == Level::Exact || sink.plots.is_empty());
            assert!(sink.plots.iter().all(|p| p.time > interval.from && p.time <= interval.to));
            times.extend(sink.plots.iter().filter(|_| scan > 30).map(|p| p.time));
        }
        times
    };
    let always = after_half_a_minute(0);
    assert!((12..50).contains(&always.len()), "one a second: {}", always.len());
    for left_out in [1, 7, 30] {
        assert_eq!(after_half_a_minute(left_out), always, "{left_out}");
    }
}

#[test]
fn errors_have_their_deviation() {
    let (mut sum, mut bias, mut n) = (0.0, 0.0, 0.0);
    for id in 1..400 {
        let sink = pass(LoopConfig { id: SensorId(id), ..config() }, 10.0, true, 1_000_000_000);
        for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
            let error = (plot.position_m - cause.truth_m.expect("a target")).dot(&plot.axis);
            sum += error * error / plot.along_m2;
            bias += error;
            n += 1.0;
        }
    }
    // Delays have a mean of 25 ms: the vehicle is 0.25 m on when it is reported.
    assert!(n > 390.0 && (bias / n).abs() < 0.5, "{}", bias / n);
    assert!((sum / n - 1.0).abs() < 0.35, "{}", sum / n);
}

#[test]
fn hard_passages_end_in_an_answer() {
    for (name, speed_mps, delay_s) in [
        ("faster than the delays", 90.0, 5.0),
        ("hardly moving", 0.3, 0.05),
        ("no delay", 10.0, 0.0),
    ] {
        let sink = pass(LoopConfig { delay_s, ..config() }, speed_mps, true, 1_000_000_000);
        for plot in &sink.plots {
            assert!(plot.position_m.iter().all(|x| x.is_finite()), "{name}");
            assert!(plot.along_m2.is_finite() && plot.along_m2 > 0.0, "{name}");
        }
    }
    let parked = Parked::aircraft(&[0]);
    let on_loop = LoopConfig { site_m: Point2::origin(), ..config() };
    let mut sensor = InductionLoop::new(on_loop).expect("sound");
    let mut sink = PlotSink::default();
    let interval =
        ScanInterval { run_seed: 1, scan: 1, from: SimTime::ZERO, to: SimTime::from_s(100.0) };
    sensor.scan(&interval, &parked, &Weather::default(), &mut sink);
    assert!(sink.plots.is_empty(), "who stands on a loop passes nothing");
}

#[test]
fn false_passages_come_at_their_rate() {
    let config = LoopConfig { false_per_h: 100.0, ..config() };
    let mut sensor = InductionLoop::new(config).expect("sound");
    let mut sink = PlotSink::default();
    for scan in 1..=36_000_u64 {
        let at = |scan: u64| SimTime(scan as i64 * 1_000_000_000);
        let interval = ScanInterval { run_seed: 4, scan, from: at(scan - 1), to: at(scan) };
        sensor.scan(&interval, &Parked::aircraft(&[]), &Weather::default(), &mut sink);
    }
    assert!((sink.plots.len() as f64 - 1000.0).abs() < 4.0 * 1000_f64.sqrt());
    assert!(sink.causes.iter().all(|c| c.key.is_none()));
}

/// Passages over loops that err in nothing: at any angle, from either side, of any length, beside the middle or off the strip.
#[test]
fn without_errors_a_passage_is_where_and_when_it_is() {
    let exact = LoopConfig {
        sigma_edge_m: 1e-3,
        delay_s: 0.0,
        sigma_half_length_m: 0.0,
        pair: Some(LoopPair { spacing_m: 7.0, sigma_spacing_m: 0.0 }),
        length_m: 3.0,
        ..config()
    };
    for (direction_deg, skew_rad, speed_mps, across_m) in [
        (0.0, 0.0, 9.0, 0.0),
        (90.0, 0.0, 3.0, 11.0),
        (205.0, 0.3, 14.0, -11.0),
        (330.0, -0.4, 20.0, 2.0),
        (75.0, 0.2, 6.0, 12.0),
        (160.0, 0.0, 6.0, -12.0),
    ] {
        for against in [false, true] {
            let mut truth = Parked::aircraft(&[1]);
            let turned = if against { std::f64::consts::PI } else { 0.0 };
            let (sin, cos) = libm::sincos(f64::to_radians(direction_deg) + turned);
            let (ahead, right) = (Vector2::new(sin, cos), Vector2::new(cos, -sin));
            truth.velocity_mps = Vector3::new(sin * speed_mps, cos * speed_mps, 0.0);
            truth.heading_rad = f64::to_radians(direction_deg) + turned + skew_rad;
            let site_m = Point2::new(0.0, 100.0) + ahead * 60.0 + right * across_m;
            let half_m = 0.5 * 37.6 * libm::cos(skew_rad);
            for pair in [exact.pair, None] {
                let config = LoopConfig {
                    site_m,
                    direction_deg,
                    pair,
                    assumed_half_length_m: half_m,
                    ..exact.clone()
                };
                let mut sensor = InductionLoop::new(config).expect("sound");
                let mut sink = PlotSink::default();
                for scan in 1..=60 {
                    let at = |scan: u64| SimTime::from_s(scan as f64);
                    let (from, to) = (at(scan - 1), at(scan));
                    let interval = ScanInterval { run_seed: 4, scan, from, to };
                    sensor.scan(&interval, &truth, &Weather::default(), &mut sink);
                }
                let case = format!("{direction_deg} {against} {pair:?}: {:?}", sink.plots);
                if f64::abs(across_m) > 11.5 {
                    assert_eq!((sink.plots.len(), sink.looks), (0, 0), "{case}");
                    continue;
                }
                let [plot] = &sink.plots[..] else { panic!("{case}") };
                // Its nose comes to the loop, or its tail leaves the farther one.
                let way_m = match (pair, against) {
                    (None, _) => 60.0 - half_m - 1.5,
                    (Some(_), false) => 67.0 + half_m + 1.5,
                    (Some(_), true) => 60.0 + half_m + 1.5,
                };
                assert!((plot.time.s() - way_m / speed_mps).abs() < 2e-6, "{way_m} {case}");
                let place = Point2::new(0.0, 100.0) + ahead * way_m;
                let off = (plot.position_m - place).dot(&plot.axis);
                assert!(off.abs() < 5e-3 + 1e-4 * speed_mps, "{off} {case}");
                assert!((plot.axis.dot(&ahead).abs() - 1.0).abs() < 1e-9, "{case}");
                assert!((plot.along_m2 - 1e-6).abs() < 1e-12, "{case}");
            }
        }
    }
}

/// Of each error by itself: as large as it is stated (the delays of one passage hang together: up to a fifth more).
#[test]
fn each_error_is_as_large_as_it_is_stated() {
    let none = LoopConfig {
        sigma_edge_m: 1e-3,
        delay_s: 0.0,
        sigma_half_length_m: 0.0,
        pair: Some(LoopPair { spacing_m: 5.0, sigma_spacing_m: 0.0 }),
        ..config()
    };
    let spacing = Some(LoopPair { spacing_m: 5.0, sigma_spacing_m: 0.2 });
    for (name, config, least, most) in [
        ("edge", LoopConfig { sigma_edge_m: 2.0, ..none.clone() }, 0.8, 1.2),
        ("edge of one", LoopConfig { sigma_edge_m: 2.0, pair: None, ..none.clone() }, 0.8, 1.2),
        ("spacing", LoopConfig { pair: spacing, ..none.clone() }, 0.8, 1.2),
        ("delay", LoopConfig { delay_s: 0.04, ..none.clone() }, 0.95, 1.3),
        ("delay of one", LoopConfig { delay_s: 0.3, pair: None, ..none }, 0.8, 1.2),
    ] {
        let (mut errors, mut stated) = (Vec::new(), 0.0);
        for id in 1..=600 {
            let sink =
                pass(LoopConfig { id: SensorId(id), ..config.clone() }, 10.0, true, 1_000_000_000);
            for (plot, cause) in sink.plots.iter().zip(&sink.causes) {
                errors.push((plot.position_m - cause.truth_m.expect("a target")).dot(&plot.axis));
                stated += plot.along_m2;
            }
        }
        let n = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / n;
        let square = errors.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>();
        assert!(
            n == 600.0 && (least..most).contains(&(square / stated)),
            "{name}: {}",
            square / stated
        );
    }
}

/// What flies over a loop on final, or hovers there, is felt by nothing in the ground.
#[test]
fn a_loop_feels_nobody_in_the_air() {
    for (height_m, passages) in [(0.0, 1), (2.0, 1), (15.0, 0), (300.0, 0)] {
        let sink = pass_at(height_m, config(), 30.0, true, 1_000_000_000);
        assert_eq!((sink.plots.len(), sink.looks), (passages, passages as u64), "{height_m} m");
    }
}
