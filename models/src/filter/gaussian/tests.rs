//! Stored numbers against full matrices.

use super::super::motion::Motion;
use super::*;
use crate::filter::testing::plot_at;
use crate::frames::Point2;
use nalgebra::SVector;

type Full = (SVector<f64, 6>, SMatrix<f64, 6, 6>);

/// A state of which all 27 numbers differ, positive definite.
fn state(seed: f64) -> Gaussian {
    let a = SMatrix::<f64, 6, 6>::from_fn(|i, j| {
        libm::sin(seed + 1.7 * i as f64 + 2.3 * (i * j) as f64 + j as f64)
    });
    let x = SVector::<f64, 6>::from_fn(|i, _| libm::cos(seed + 3.1 * i as f64) * 5.0);
    stored((x, a * a.transpose() + SMatrix::identity() * 0.3))
}

fn full(g: &Gaussian) -> Full {
    let part = |i: usize| g.x[i % 3].array()[i / 3];
    (SVector::from_fn(|i, _| part(i)), g.covariance())
}

fn stored((x, p): Full) -> Gaussian {
    let pair = |i: usize, j: usize| Pair::new(p[(i, j)], p[(i + 3, j + 3)]);
    Gaussian {
        x: std::array::from_fn(|i| Pair::new(x[i], x[i + 3])),
        p: [pair(0, 0), pair(0, 1), pair(0, 2), pair(1, 1), pair(1, 2), pair(2, 2)],
        cross: std::array::from_fn(|k| p[(k / 3, 3 + k % 3)]),
    }
}

fn same(name: &str, found: &Gaussian, (x, p): &Full) {
    let (own, covariance) = full(found);
    assert!((own - x).amax() < 1e-9 * (1.0 + x.amax()), "{name}: {own} for {x}");
    assert!((covariance - p).amax() < 1e-9 * (1.0 + p.amax()), "{name}: {covariance} for {p}");
}

/// Rows that measure the position, or one line of it.
fn rows(
    m: &Measurement,
) -> (nalgebra::DMatrix<f64>, nalgebra::DVector<f64>, nalgebra::DMatrix<f64>) {
    use nalgebra::{DMatrix, DVector};
    match *m {
        Measurement::Position { z, r } => {
            let mut h = DMatrix::zeros(2, 6);
            (h[(0, 0)], h[(1, 3)]) = (1.0, 1.0);
            (
                h,
                DVector::from_vec(vec![z.x, z.y]),
                DMatrix::from_row_slice(2, 2, &[r.xx, r.xy, r.xy, r.yy]),
            )
        }
        Measurement::Line { z, axis, variance } => {
            let mut h = DMatrix::zeros(1, 6);
            (h[(0, 0)], h[(0, 3)]) = (axis.x, axis.y);
            (
                h,
                DVector::from_element(1, z.coords.dot(&axis)),
                DMatrix::from_element(1, 1, variance),
            )
        }
    }
}

/// The textbook's update: state, νᵀS⁻¹ν, det S.
fn updated(g: &Gaussian, m: &Measurement) -> (Full, f64, f64) {
    let (x, p) = full(g);
    let (h, z, r) = rows(m);
    let s = &h * p * h.transpose() + r;
    let nu = z - &h * x;
    let inverse = s.clone().try_inverse().expect("regular");
    let k = p * h.transpose() * &inverse;
    let x = x + SVector::<f64, 6>::from_iterator((&k * &nu).iter().copied());
    let p =
        p - SMatrix::<f64, 6, 6>::from_iterator((&k * s.clone() * k.transpose()).iter().copied());
    ((x, p), (nu.transpose() * inverse * &nu)[0], s.determinant())
}

fn measurements() -> [Measurement; 3] {
    let (sin, cos) = libm::sincos(0.7);
    [
        Measurement::Position { z: Point2::new(2.0, -1.0), r: Sym2 { xx: 2.0, xy: 0.7, yy: 1.0 } },
        Measurement::Position { z: Point2::new(-3.0, 9.0), r: Sym2 { xx: 0.5, xy: 0.0, yy: 40.0 } },
        Measurement::Line { z: Point2::new(1.0, 5.0), axis: Vector2::new(cos, sin), variance: 3.0 },
    ]
}

#[test]
fn what_is_stored_is_the_matrix_in_its_order() {
    let g = state(0.4);
    assert_eq!(stored(full(&g)), g);
    let p = g.covariance();
    assert!((p - p.transpose()).amax() == 0.0 && p.cholesky().is_some());
    assert_eq!(
        (p[(0, 3)], p[(1, 5)], p[(5, 1)], p[(4, 2)]),
        (g.cross[0], g.cross[5], g.cross[5], g.cross[7])
    );
    assert_eq!(g.position(), Point2::new(full(&g).0[0], full(&g).0[3]));
    assert_eq!(g.position_cov(), Sym2 { xx: p[(0, 0)], xy: p[(0, 3)], yy: p[(3, 3)] });
    assert_eq!(g.motion().1, Vector2::new(full(&g).0[1], full(&g).0[4]));
}

#[test]
fn a_step_is_the_transition_of_the_whole_covariance_with_the_noise() {
    for (k, motion) in [
        Motion::ConstantVelocity { q: 0.7 },
        Motion::ConstantAcceleration { q: 0.3 },
        Motion::Singer { rate: 0.4, q: 0.5 },
        Motion::Singer { rate: 2.0, q: 0.5 },
    ]
    .into_iter()
    .enumerate()
    {
        for t in [0.0, 0.6, 2.5] {
            let (g, step) = (state(k as f64 + t), motion.step(t));
            let mut phi = SMatrix::<f64, 6, 6>::identity();
            let mut q = SMatrix::<f64, 6, 6>::zeros();
            for b in [0, 3] {
                (phi[(b, b + 1)], phi[(b, b + 2)]) = (step.t, step.f02);
                (phi[(b + 1, b + 2)], phi[(b + 2, b + 2)]) = (step.f12, step.f22);
                for (n, (i, j)) in
                    [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate()
                {
                    (q[(b + i, b + j)], q[(b + j, b + i)]) = (step.q[n], step.q[n]);
                }
            }
            let (x, p) = full(&g);
            let expected = (phi * x, phi * p * phi.transpose() + q);
            same(&format!("{motion:?} {t}"), &g.predicted(&step), &expected);
            let (at, cov) = g.predicted_position(&step);
            assert!((at - Point2::new(expected.0[0], expected.0[3])).norm() < 1e-9);
            let p = expected.1;
            let off = [cov.xx - p[(0, 0)], cov.xy - p[(0, 3)], cov.yy - p[(3, 3)]];
            assert!(off.iter().all(|o| o.abs() < 1e-9 * p.amax()), "{motion:?} {t}: {off:?}");
            if let Motion::ConstantVelocity { .. } = motion {
                // Whatever was said of the acceleration.
                same(
                    "steady",
                    &g.predicted_steady(&step),
                    &full(&g.without_acceleration().predicted(&step)),
                );
            }
        }
    }
}

#[test]
fn an_update_is_that_of_the_textbook_for_positions_and_lines() {
    for (k, m) in measurements().iter().enumerate() {
        let before = state(2.0 + k as f64);
        let (expected, d2, det) = updated(&before, m);
        let mut g = before;
        let nis = g.update(m).expect("sound");
        same("update", &g, &expected);
        let look = before.innovation(m).expect("sound");
        let at = before.nis(m).expect("sound");
        for (name, found) in [("update", nis.d2), ("innovation", look.d2), ("nis", at.d2)] {
            assert!((found - d2).abs() < 1e-9 * (1.0 + d2), "{name}: {found} for {d2}");
        }
        for found in [libm::log(nis.det), look.ln_det, at.ln_det()] {
            assert!((found - libm::log(det)).abs() < 1e-9, "{found} for {det}");
        }
        assert_eq!([nis.dof, look.dof, at.dof], [if k == 2 { 1 } else { 2 }; 3]);
        // Without an acceleration.
        let mut steady = before.without_acceleration();
        let (expected, d2, _) = updated(&steady, m);
        let nis = steady.update_steady(m).expect("sound");
        same("steady", &steady, &expected);
        assert!((nis.d2 - d2).abs() < 1e-9 * (1.0 + d2));
        let (h, z, _) = rows(m);
        let nu = z - h * full(&before).0;
        let own = match *m {
            Measurement::Line { axis, .. } => axis * nu[0],
            Measurement::Position { .. } => Vector2::new(nu[0], nu[1]),
        };
        assert!((look.nu - own).norm() < 1e-9);
    }
    let line = measurements()[2];
    let Measurement::Line { axis, variance, .. } = line else { panic!("a line") };
    let (g, s) = (state(4.0), state(4.0).innovation(&line).expect("sound").s);
    let p = g.position_cov();
    let along =
        p.xx * axis.x * axis.x + 2.0 * p.xy * axis.x * axis.y + p.yy * axis.y * axis.y + variance;
    let expected = axis * axis.transpose() * along;
    assert!((s.matrix() - expected).amax() < 1e-9 && (quadratic(s, axis) - along).abs() < 1e-9);
}

#[test]
fn what_no_covariance_allows_leaves_the_state_as_it_was() {
    let before = state(1.0);
    let wild = Sym2 { xx: -1e3, xy: 0.0, yy: -1e3 };
    for m in [
        Measurement::Position { z: Point2::origin(), r: wild },
        Measurement::Position {
            z: Point2::new(f64::NAN, 0.0),
            r: Sym2 { xx: 1.0, xy: 0.0, yy: 1.0 },
        },
        Measurement::Line { z: Point2::origin(), axis: Vector2::x(), variance: -1e3 },
        Measurement::Line { z: Point2::new(f64::INFINITY, 0.0), axis: Vector2::x(), variance: 1.0 },
    ] {
        let (mut a, mut b) = (before, before.without_acceleration());
        assert!(a.update(&m).is_err() && b.update_steady(&m).is_err(), "{m:?}");
        assert_eq!((a, b), (before, before.without_acceleration()));
        assert!(a.update_weighted(&[(measurements()[0], 0.5), (m, 0.5)]).is_err());
        assert_eq!(a, before);
    }
}

/// Weights of parts as moments: first and second, then the second about the mean.
fn mixed(parts: &[(Gaussian, f64)]) -> Full {
    let sum: f64 = parts.iter().map(|p| p.1).sum();
    assert!((sum - 1.0).abs() < 1e-12);
    let mean = parts.iter().map(|(g, w)| full(g).0 * *w).sum::<SVector<f64, 6>>();
    let second = parts.iter().map(|(g, w)| {
        let (x, p) = full(g);
        (p + x * x.transpose()) * *w
    });
    let second = second.sum::<SMatrix<f64, 6, 6>>();
    (mean, second - mean * mean.transpose())
}

#[test]
fn mixtures_have_the_moments_of_their_parts() {
    let parts = [state(0.0), state(1.0), state(2.0)];
    let weights = [0.5, 0.3, 0.2];
    let of = |parts: &[Gaussian; 3]| mixed(&[(parts[0], 0.5), (parts[1], 0.3), (parts[2], 0.2)]);
    same("mixture", &Gaussian::mixture(&weights, &parts), &of(&parts));
    let steady = parts.map(|part| part.without_acceleration());
    same("steady", &Gaussian::mixture_steady(&weights, &steady), &of(&steady));
    same("whatever is said of it", &Gaussian::mixture_steady(&weights, &parts), &of(&steady));
    let (position, velocity) = Gaussian::mean_motion(&weights, &parts);
    let (x, _) = of(&parts);
    assert!((position - Point2::new(x[0], x[3])).norm() < 1e-9);
    assert!((velocity - Vector2::new(x[1], x[4])).norm() < 1e-9);
}

#[test]
fn several_plots_are_the_mixture_of_what_each_would_make_and_of_none() {
    let [a, b, c] = measurements();
    for weighted in [vec![(a, 0.5), (b, 0.2)], vec![(a, 0.6), (b, 0.3), (c, 0.1)], vec![(c, 0.25)]]
    {
        let before = state(3.0);
        let missed = 1.0 - weighted.iter().map(|(_, beta)| beta).sum::<f64>();
        let mut parts = vec![(before, missed)];
        for (m, beta) in &weighted {
            parts.push((stored(updated(&before, m).0), *beta));
        }
        let mut g = before;
        g.update_weighted(&weighted).expect("sound");
        same("weighted", &g, &mixed(&parts));
    }
}

#[test]
fn two_plots_give_the_position_and_velocity_that_they_say() {
    let (r1, r2) = (Sym2 { xx: 3.0, xy: 0.4, yy: 5.0 }, Sym2 { xx: 2.0, xy: -0.6, yy: 1.0 });
    let (z1, z2) = (Point2::new(1.0, 8.0), Point2::new(7.0, -4.0));
    let g = Gaussian::from_two((z1, r1), (z2, r2), 2.0, 3.0, false);
    let (x, p) = full(&g);
    assert_eq!(x.as_slice(), [7.0, 3.0, 0.0, -4.0, -6.0, 0.0]);
    assert_eq!((p[(0, 0)], p[(0, 1)], p[(1, 1)], p[(2, 2)], p[(1, 2)]), (2.0, 1.0, 1.25, 9.0, 0.0));
    assert_eq!((p[(3, 3)], p[(3, 4)], p[(4, 4)], p[(5, 5)]), (1.0, 0.5, 1.5, 9.0));
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} for {b}");
    near(p[(0, 3)], -0.6);
    near(p[(0, 4)], -0.3);
    near(p[(1, 3)], -0.3);
    near(p[(1, 4)], -0.05);
    // An acceleration of 3 m/s² in two seconds: 3 m/s either way of the mean velocity.
    let (_, vague) = full(&Gaussian::from_two((z1, r1), (z2, r2), 2.0, 3.0, true));
    assert_eq!(
        (vague[(1, 1)], vague[(4, 4)], vague[(1, 2)], vague[(5, 4)]),
        (10.25, 10.5, 9.0, 9.0)
    );
    let (x, p) = full(&Gaussian::at_position(z1, r1, 4.0, 3.0));
    assert_eq!(x.as_slice(), [1.0, 0.0, 0.0, 8.0, 0.0, 0.0]);
    let mut expected = SMatrix::<f64, 6, 6>::from_diagonal(&SVector::from_column_slice(&[
        3.0, 16.0, 9.0, 5.0, 16.0, 9.0,
    ]));
    (expected[(0, 3)], expected[(3, 0)]) = (0.4, 0.4);
    assert_eq!(p, expected);
}

#[test]
fn room_for_a_manoeuvre_is_as_much_as_makes_the_plot_likely() {
    for (k, m) in measurements().iter().enumerate() {
        for target in [0.01, 0.2] {
            let before = state(k as f64);
            let look = before.innovation(m).expect("sound");
            assert!(look.d2 > target, "{k}: {look:?}");
            let mut g = before;
            let c = g.inflate(&look, 4.0, target);
            let d2 = g.nis(m).expect("sound").d2;
            assert!((d2 - target).abs() < 1e-6, "{k}: {d2} for {target}");
            // It came by an acceleration over four seconds: half as much a second; no more than two g do.
            let rate = 0.5_f64.min(80.0 / c.sqrt());
            let (x, p) = full(&before);
            let mut more = SMatrix::<f64, 6, 6>::zeros();
            for b in [0, 3] {
                more[(b, b)] = c;
                (more[(b, b + 1)], more[(b + 1, b)]) = (c * rate, c * rate);
                more[(b + 1, b + 1)] = c * rate * rate;
            }
            same("inflated", &g, &(x, p + more));
        }
        let before = state(k as f64);
        let look = before.innovation(m).expect("sound");
        let mut g = before;
        assert_eq!((g.inflate(&look, 4.0, look.d2), g), (0.0, before), "likely enough as it is");
        let nothing = Innovation { d2: f64::NAN, ..look };
        assert_eq!((g.inflate(&nothing, 4.0, 0.1), g), (0.0, before));
        // At once there is no time for a change of speed; in a moment hardly any.
        let c = g.inflate(&look, 0.0, 0.01);
        assert!(c > 0.0 && g.p[0] != before.p[0]);
        assert_eq!((g.p[1], g.p[3]), (before.p[1], before.p[3]));
        let mut g = before;
        let c = g.inflate(&look, 1e-3, 0.01);
        let change = (g.p[3] - before.p[3]).east().sqrt();
        assert!((change - 0.02).abs() < 1e-6 || change < 0.02, "{k} {c}: {change}");
    }
}

#[test]
fn a_state_is_sound_if_its_covariance_is_one() {
    let good = state(5.0);
    assert!(good.is_sound());
    let apart = Gaussian { cross: [0.0; 9], ..good };
    assert!(apart.is_sound() && apart.is_clearly_sound());
    assert!(good.without_acceleration().is_sound());
    assert!(apart.without_acceleration().is_clearly_sound());
    assert!(
        Gaussian::at_position(Point2::origin(), Sym2 { xx: 1.0, xy: 1.0, yy: 1.0 }, 1.0, 1.0)
            .is_sound()
    );
    for axis in 0..6 {
        let (x, p) = full(&good);
        let bad = |name: &str, g: Gaussian| {
            assert!(!g.is_sound(), "{name} {axis}");
            assert!(!g.is_clearly_sound(), "{name} {axis}");
        };
        let mut at = x;
        at[axis] = f64::NAN;
        bad("no number", stored((at, p)));
        at[axis] = f64::INFINITY;
        bad("infinite", stored((at, p)));
        for value in [f64::NAN, f64::INFINITY, -1.0] {
            let mut q = p;
            q[(axis, axis)] = value;
            bad("a variance", stored((x, q)));
        }
        for other in 0..6 {
            if other == axis {
                continue;
            }
            let mut q = p;
            let most = 1.01 * (p[(axis, axis)] * p[(other, other)]).sqrt();
            (q[(axis, other)], q[(other, axis)]) = (most, most);
            bad("more than fully correlated", stored((x, q)));
            // What has no variance has no covariance.
            let mut q = p;
            for k in 0..6 {
                (q[(axis, k)], q[(k, axis)]) = (0.0, 0.0);
            }
            (q[(axis, other)], q[(other, axis)]) = (0.1, 0.1);
            bad("a covariance of nothing", stored((x, q)));
        }
        // What is known for certain says nothing of the others.
        let mut q = p;
        for k in 0..6 {
            (q[(axis, k)], q[(k, axis)]) = (0.0, 0.0);
        }
        let [one, two] = [(axis + 1) % 6, (axis + 2) % 6];
        let most = (p[(one, one)] * p[(two, two)]).sqrt();
        assert!(stored((x, q)).is_sound(), "certain {axis}");
        (q[(one, two)], q[(two, one)]) = (1.01 * most, 1.01 * most);
        bad("certain, and others are not", stored((x, q)));
        // Indefinite only in a direction across several.
        let unit =
            SVector::<f64, 6>::from_fn(|i, _| libm::sin(1.0 + (i + axis) as f64)).normalize();
        let least = 1.0 / (unit.transpose() * p.try_inverse().expect("regular") * unit)[0];
        let g = |share: f64| stored((x, p - unit * unit.transpose() * least * share));
        assert!(g(0.999).is_sound(), "{axis}");
        bad("indefinite", g(1.001));
    }
}

#[test]
fn a_plot_is_a_position_a_line_or_unsound() {
    let (sin, cos) = libm::sincos(0.3);
    let plot = Plot {
        axis: Vector2::new(cos, sin),
        along_m2: 4.0,
        across_m2: 9.0,
        ..plot_at(0.0, 3.0, -5.0, 1.0)
    };
    let Ok(Measurement::Position { z, r }) = Measurement::of(&plot) else { panic!("a position") };
    assert_eq!(z, plot.position_m);
    assert!((r.matrix() - plot.covariance_m2()).amax() < 1e-12);
    let line = Plot { across_m2: f64::INFINITY, ..plot };
    let expected = Measurement::Line { z: plot.position_m, axis: plot.axis, variance: 4.0 };
    assert_eq!(Measurement::of(&line), Ok(expected));
    let exact = Plot { along_m2: 1e-31, ..line };
    assert!(matches!(Measurement::of(&exact), Ok(Measurement::Line { variance: 0.0, .. })));
    let exact = Plot { along_m2: 1e-31, across_m2: 0.0, ..plot };
    let Ok(Measurement::Position { r, .. }) = Measurement::of(&exact) else { panic!("a position") };
    assert_eq!(r, Sym2::default());
    for plot in [plot, line] {
        for bad in [f64::NAN, f64::INFINITY, 1e9, -1e9] {
            for axis in 0..2 {
                let mut far = plot;
                far.position_m[axis] = bad;
                assert!(Measurement::of(&far).is_err(), "{bad} {axis}");
            }
        }
        for bad in [f64::NAN, f64::INFINITY, -1e-3, 1e20] {
            assert!(Measurement::of(&Plot { along_m2: bad, ..plot }).is_err(), "{bad}");
        }
        for axis in [
            Vector2::new(1.0, 0.01),
            Vector2::zeros(),
            Vector2::new(0.9, 0.0),
            Vector2::new(f64::NAN, 0.0),
        ] {
            assert!(Measurement::of(&Plot { axis, ..plot }).is_err(), "{axis}");
        }
    }
    for bad in [f64::NAN, -1.0] {
        assert!(Measurement::of(&Plot { across_m2: bad, ..plot }).is_err(), "{bad}");
    }
    assert!(Measurement::of(&Plot { across_m2: 1e20, ..plot }).is_ok());
}

#[test]
fn speed_and_course_have_the_deviations_along_and_across_them() {
    use crate::filter::Estimate;
    use crate::time::SimTime;
    let at = |east: f64, north: f64, xx: f64, xy: f64, yy: f64| {
        let mut g = state(0.5);
        g.x[1] = Pair::new(east, north);
        (g.p[3], g.cross[4]) = (Pair::new(xx, yy), xy);
        Estimate::new(SimTime::ZERO, g)
    };
    let near = |(a, b): (f64, f64), (c, d): (f64, f64)| {
        assert!((a - c).abs() < 1e-12 && (b - d).abs() < 1e-12, "{a} {b} for {c} {d}");
    };
    // East: along is east; north-west by three, four: 0.36 xx − 0.96 xy + 0.64 yy.
    near(at(7.0, 0.0, 4.0, 0.5, 9.0).speed_mps(), (7.0, 2.0));
    near(at(0.0, -7.0, 4.0, 0.5, 9.0).speed_mps(), (7.0, 3.0));
    near(at(-3.0, 4.0, 4.0, 0.5, 9.0).speed_mps(), (5.0, 6.72_f64.sqrt()));
    near(at(0.0, 0.0, 4.0, 0.5, 9.0).speed_mps(), (0.0, 3.0));
    near(at(0.0, 0.0, 16.0, 0.5, 9.0).speed_mps(), (0.0, 4.0));
    near(at(5.0, 0.0, -1.0, 0.0, 9.0).speed_mps(), (5.0, 0.0));
    // Course clockwise from north; its deviation is that across over the speed.
    let turn = std::f64::consts::TAU;
    for (east, north, course, sigma) in [
        (0.0, 10.0, 0.0, 0.2),
        (10.0, 0.0, turn / 4.0, 0.3),
        (0.0, -10.0, turn / 2.0, 0.2),
        (-10.0, 0.0, 0.75 * turn, 0.3),
        (-1e-17, 10.0, 0.0, 0.2),
    ] {
        near(at(east, north, 4.0, 0.5, 9.0).heading_rad().expect("moving"), (course, sigma));
    }
    assert!(at(0.99, 0.0, 0.0, 0.0, 0.0).heading_rad().is_none());
    assert!(at(1.0, 0.0, 0.0, 0.0, 0.0).heading_rad().is_some());
    // Thirty degrees are told, more are not.
    let most = 10.0 * 30.0_f64.to_radians();
    assert!(at(10.0, 0.0, 1.0, 0.0, (0.999 * most).powi(2)).heading_rad().is_some());
    assert!(at(10.0, 0.0, 1.0, 0.0, (1.001 * most).powi(2)).heading_rad().is_none());
    let g = at(1.0, 2.0, 4.0, 0.5, 9.0);
    assert_eq!((g.velocity_cov_m2s2()[(0, 1)], g.velocity_cov_m2s2()[(1, 1)]), (0.5, 9.0));
    let (p, both) = (g.state.covariance(), g.position_velocity_cov_m2s());
    for i in 0..2 {
        for j in 0..2 {
            assert_eq!(both[(i, j)], p[(3 * i, 3 * j + 1)], "{i} {j}");
        }
    }
}
