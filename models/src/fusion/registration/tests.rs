//! Errors of sites: forgotten in time, and applied no more than they stand out.

use super::*;
use crate::draw::{DrawKey, Purpose, normal_pair};
use crate::filter::route::{Edge, Route};
use crate::plot::Polar;

/// A radar's site and the echoes' numbers, without anything seen.
fn nothing() -> Joint {
    Joint::new(&[0.095, 0.56], &PRIOR_ECHO).with_site()
}

/// A pair of a target that stands on the circle, off by this along and across.
fn pair(k: u32, off: [f64; 2], variance_m2: f64) -> Pair {
    let (sin, cos) = libm::sincos(0.1 * f64::from(k));
    let axis = Vector2::new(sin, cos);
    Pair {
        axis,
        ground_m: 1_500.0,
        velocity_mps: Vector2::new(8.0, 0.0),
        vehicle: true,
        half_extent_m: 0.0,
        variance_m2: [variance_m2; 2],
        delta_m: axis * off[0] + Vector2::new(axis.y, -axis.x) * off[1],
    }
}

/// What was known of a site an age ago is known no more, and no less than at the beginning.
#[test]
fn what_was_learnt_long_ago_leaves_the_prior() {
    let mut joint = nothing();
    for k in 0..400 {
        joint.learn(0, &pair(k, [2.0, 0.5], 4.0));
    }
    joint.solve();
    let (range_m, sigma_m) = joint.parameter(0);
    assert!((range_m - 2.0).abs() < 0.5 && sigma_m < 0.3, "{range_m} {sigma_m}");
    // Half of it is forgotten after 1250 s.
    let mut later = joint.clone();
    later.age(1_250.0);
    later.solve();
    let ratio = later.parameter(0).1 / sigma_m;
    assert!((ratio - std::f64::consts::SQRT_2).abs() < 0.05, "{ratio}");
    joint.age(40.0 * AGEING_S);
    joint.solve();
    let prior = nothing();
    for k in 0..5 {
        let (found, wanted) = (joint.parameter(k), prior.parameter(k));
        assert!((found.1 / wanted.1 - 1.0).abs() < 1e-6, "{k}: {found:?} {wanted:?}");
        assert!((found.0 - wanted.0).abs() < 1e-6 * wanted.1, "{k}: {found:?} {wanted:?}");
    }
}

/// A site without errors: of what noise alone lets be found less than half is taken off in the mean square; of an error that is there
/// nearly all.
#[test]
fn what_is_taken_off_stands_out_of_what_noise_finds() {
    let (mut found2, mut applied2, mut left2) = (0.0, 0.0, 0.0);
    for run in 0..100 {
        let draw = |k: u32| {
            let key = DrawKey { run_seed: run, sensor: 1, entity: 0, scan: k.into() };
            let (a, b) = normal_pair(&mut key.rng(Purpose::Study));
            [10.0 * a, 10.0 * b]
        };
        for (bias_m, sum) in [(0.0, &mut applied2), (3.0, &mut left2)] {
            let mut joint = nothing();
            for k in 0..300 {
                let [a, b] = draw(k);
                joint.learn(0, &pair(k, [a + bias_m, b], 100.0));
            }
            joint.solve();
            *sum += (joint.applied(0) - bias_m).powi(2);
            if bias_m == 0.0 {
                found2 += joint.parameter(0).0.powi(2);
            }
        }
    }
    println!(
        "found {found2:.1}, applied {applied2:.1}, left of 3 m {left2:.1} m² in a hundred runs"
    );
    assert!(found2 > 10.0 && applied2 < 0.5 * found2, "{found2} {applied2}");
    assert!(left2 < 0.15 * 900.0, "{left2}");
}

/// The span's number goes with the length's in the ratio that is assumed; of a point, which has none, it stays nothing.
#[test]
fn the_span_follows_the_length_in_its_ratio() {
    let registration = Registration::new(EchoLaw::default());
    for kind in [0, 1] {
        for (length, span) in [(0.1, 0.02), (0.5, 0.5), (0.4, 0.0)] {
            let found = registration.kappa(kind, near_side::Kappa { length, span });
            assert!((found.span - span / length * found.length).abs() < 1e-12, "{found:?}");
            let wanted = near_side::Kappa { span: 0.0, ..found };
            let point = near_side::Kappa { length: 0.0, span };
            assert_eq!(registration.kappa(kind, point), wanted);
        }
    }
}

/// A lane of two kilometres that passes the radar at `away_m`, its normal at this angle (radians clockwise from north).
fn lane_at(angle: f64, away_m: f64) -> (Route, Vector2<f64>, Vector2<f64>) {
    let (sin, cos) = libm::sincos(angle);
    let (out, along) = (Vector2::new(sin, cos), Vector2::new(cos, -sin));
    let ends = [-1.0, 1.0].map(|s| Point2::from(out * away_m + along * (1_000.0 * s)));
    (Route::through(&ends).expect("two points"), out, along)
}

/// A target on one of four lanes around the radar, `aside_m` off it and driving along it, as the radar with this error of its range has
/// it.
fn taxiing(k: u32, aside_m: f64, range_m: f64, speed_mps: f64) -> (Waiting, Network) {
    let lanes = [0, 1, 2, 3].map(|n| lane_at(0.4 + 1.6 * f64::from(n), 800.0));
    let (_, out, along) = &lanes[(k % 4) as usize];
    let key = DrawKey { run_seed: 3, sensor: 1, entity: 0, scan: k.into() };
    let (a, b) = normal_pair(&mut key.rng(Purpose::Study));
    let at = out * (800.0 + aside_m) + along * (f64::from(k % 17) * 50.0 - 400.0);
    let axis = at.normalize();
    let across = Vector2::new(axis.y, -axis.x);
    let seen = at + axis * (range_m + 1.5 * a) + across * (1.5 * b);
    let polar = Polar {
        range_m: seen.norm(),
        azimuth_rad: libm::atan2(seen.x, seen.y),
        sigma_range_m: 1.5,
        sigma_azimuth_rad: 1.5 / seen.norm(),
        extent_m2: None,
    };
    let mut plot = crate::filter::testing::plot_at(f64::from(k), seen.x, seen.y, 2.25);
    (plot.sensor, plot.axis, plot.polar) = (SensorId(1), axis, Some(polar));
    let waiting = Waiting {
        plot,
        taken_off_m: Vector2::zeros(),
        velocity_mps: along * speed_mps,
        body: None,
        course: Some(*along),
        interval_s: 1.0,
    };
    let edge = |(route, ..): (Route, _, _)| Edge { route, next: Vec::new(), width_m: 0.0 };
    (waiting, Network { edges: lanes.map(edge).to_vec() })
}

/// Lanes tell the error of the range as what keeps to them lies off one way everywhere; a tenth of them ten metres aside hardly matters, as
/// the law of deviations has long tails, and what is claimed is no less than what deviations of three metres leave.
#[test]
fn lanes_tell_the_error_of_the_range_and_a_tenth_of_wrong_ones_does_little() {
    let found = |range_m: f64, wrong: bool| {
        let mut registration = Registration::new(EchoLaw::POINT);
        registration.begin(SimTime::ZERO);
        for k in 0..200 {
            let key = DrawKey { run_seed: 4, sensor: 1, entity: 0, scan: k.into() };
            let aside_m = 1.8 * normal_pair(&mut key.rng(Purpose::Study)).0;
            let aside_m = if wrong && k % 10 == 3 { 10.0 } else { aside_m };
            let (waiting, lanes) = taxiing(k, aside_m, range_m, 8.0);
            assert!(registration.learn_lane(&waiting, &lanes) || aside_m > 5.0);
            // Scan by scan, as a run has them.
            registration.begin(SimTime::from_s(f64::from(k + 1)));
        }
        registration.bias(SensorId(1)).expect("pairs")
    };
    for range_m in [-2.0, 0.0, 2.0] {
        let bias = found(range_m, false);
        assert!((bias.range_m - range_m).abs() < 3.0 * bias.sigma_range_m, "{range_m}: {bias:?}");
        assert!((0.15..0.5).contains(&bias.sigma_range_m), "{bias:?}");
        let moved_m = found(range_m, true).range_m - bias.range_m;
        // A mean would have moved by a metre.
        assert!((0.0..0.7).contains(&moved_m), "{range_m}: {moved_m}");
    }
}

/// Neither what is too slow or too fast to taxi, nor what crosses a lane, lies far beside it or beyond its end, says anything; nothing
/// is learnt along a lane.
#[test]
fn only_what_taxis_along_a_lane_is_held_against_it() {
    let taken = |change: &dyn Fn(&mut Waiting)| {
        let mut registration = Registration::new(EchoLaw::POINT);
        registration.begin(SimTime::ZERO);
        let (mut waiting, lanes) = taxiing(0, 1.0, 0.0, 8.0);
        change(&mut waiting);
        (registration.learn_lane(&waiting, &lanes), registration.bias(SensorId(1)).is_some())
    };
    let (_, out, along) = lane_at(0.4, 800.0);
    assert_eq!(taken(&|_| ()), (true, true));
    assert_eq!(taken(&|w| w.velocity_mps = -w.velocity_mps), (true, true));
    let refused: [&dyn Fn(&mut Waiting); 7] = [
        &|w| w.velocity_mps *= 0.3,
        &|w| w.velocity_mps *= 2.0,
        &|w| w.velocity_mps = out * 8.0,
        &|w| w.velocity_mps = along * 8.0 + out * 2.5,
        &|w| w.plot.position_m += out * 25.0,
        &|w| w.plot.position_m += along * 3_000.0,
        &|w| w.plot.polar = None,
    ];
    for (k, change) in refused.iter().enumerate() {
        assert_eq!(taken(change), (false, false), "{k}");
    }
    // One lane alone, whose normal is the line of sight: the azimuth stays as uncertain as it was.
    let mut registration = Registration::new(EchoLaw::POINT);
    registration.begin(SimTime::ZERO);
    for k in 0..100 {
        let (mut waiting, lanes) = taxiing(4 * k, 0.0, 1.0, 8.0);
        let here = Point2::from(out * 801.0);
        (waiting.plot.position_m, waiting.plot.axis) = (here, out);
        registration.learn_lane(&waiting, &lanes);
    }
    registration.begin(SimTime::from_s(1.0));
    let bias = registration.bias(SensorId(1)).expect("pairs");
    assert!(bias.sigma_range_m < 0.6 && bias.sigma_azimuth_rad > 1.99e-3, "{bias:?}");
}
