//! Errors of sites: forgotten in time, and applied no more than they stand out.

use super::*;
use crate::draw::{DrawKey, Purpose, normal_pair};

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
