//! The filter along a way held against dense matrices and against the chain of two states that leaving and returning are.

use super::super::testing::{drawn, plot_at};
use super::*;
use crate::filter::route::{Edge, Route};
use nalgebra::{Matrix2, Matrix2x4, Matrix4, SMatrix, Vector4};

/// A covariance with four unlike deviations, all of them correlated.
fn covariance(seed: u64) -> Matrix4<f64> {
    let scale = [3.0, 1.5, 0.6, 1.2];
    let mut root = Matrix4::zeros();
    for i in 0..4 {
        for j in 0..=i {
            let drawn = drawn(seed, 1, i as u64, j as u64).x;
            root[(i, j)] = scale[i] * if i == j { 0.6 + drawn.abs() } else { 0.4 * drawn };
        }
    }
    root * root.transpose()
}

fn along(x: [f64; 4], p: &Matrix4<f64>) -> Along {
    Along {
        x,
        p: [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|at| p[at]),
        pd: [p[(0, 3)], p[(1, 3)], p[(2, 3)]],
        dd: p[(3, 3)],
        ..Along::default()
    }
}

fn dense(a: &Along) -> Matrix4<f64> {
    let ([ss, sv, sa, vv, va, aa], [sd, vd, ad]) = (a.p, a.pd);
    Matrix4::new(ss, sv, sa, sd, sv, vv, va, vd, sa, va, aa, ad, sd, vd, ad, a.dd)
}

fn close<const R: usize, const C: usize>(
    what: &str,
    found: SMatrix<f64, R, C>,
    wanted: SMatrix<f64, R, C>,
) {
    let off = (found - wanted).amax();
    assert!(off <= 1e-9 * (1.0 + wanted.amax()), "{what}: {found} {wanted}");
}

fn straight(course: f64) -> Route {
    Route::from_course(Point2::new(40.0, -70.0), course).line(1000.0, 0.0)
}

#[test]
fn a_straight_way_is_a_linear_filter_in_its_own_axes() {
    for seed in 0..12 {
        let course = 0.55 * seed as f64;
        let map = MapKnowledge::of(Network::single(straight(course)));
        let p = covariance(seed);
        let x = [400.0 + seed as f64, 11.0, -0.7, 0.9];
        let before = along(x, &p);
        for motion in [ca(0.4), cv(0.7)] {
            let (step, keep, fresh) = (motion.step(1.3), 0.8, 0.33);
            let after = before.predicted(&step, keep, fresh);
            let Step { t, f02, f12, f22, q } = step;
            let f = Matrix4::new(
                1.0, t, f02, 0.0, 0.0, 1.0, f12, 0.0, 0.0, 0.0, f22, 0.0, 0.0, 0.0, 0.0, keep,
            );
            let noise = along([0.0; 4], &Matrix4::zeros());
            let noise = dense(&Along { p: q, dd: fresh, ..noise });
            close("mean", Vector4::from(after.x), f * Vector4::from(x));
            close("covariance", dense(&after), f * p * f.transpose() + noise);
        }
        let (sin, cos) = libm::sincos(course);
        let h = Matrix2x4::new(cos, 0.0, 0.0, -sin, sin, 0.0, 0.0, cos);
        let r = Sym2 { xx: 2.5, xy: 1.1, yy: 4.0 };
        let z = Point2::new(40.0, -70.0) + Vector2::new(cos, sin) * 405.0 + drawn(seed, 2, 0, 0);
        let mut after = before;
        let log = after.update(&map, z, r).expect("sound");
        let nu = z.coords - Vector2::new(40.0, -70.0) - h * Vector4::from(x);
        let s: Matrix2<f64> = h * p * h.transpose() + r.matrix();
        let inverse = s.try_inverse().expect("definite");
        let gain = p * h.transpose() * inverse;
        close("updated", Vector4::from(after.x), Vector4::from(x) + gain * nu);
        close("updated covariance", dense(&after), p - gain * h * p);
        let wanted = -0.5 * (nu.dot(&(inverse * nu)) + libm::log(s.determinant()));
        assert!((log - wanted).abs() < 1e-9, "{log} {wanted}");
    }
}

/// Straight on and in a bend either way: by the derivatives of place, velocity and acceleration by path, speed, acceleration and
/// deviation, and what is added on purpose.
#[test]
fn a_state_on_the_way_is_carried_over_by_its_derivatives() {
    for (seed, radius_m, width_m) in [(1, 0.0, 0.0), (2, 80.0, 0.0), (3, -50.0, 23.0)] {
        let route = Route::from_course(Point2::new(-5.0, 3.0), 0.7).line(50.0, 0.0);
        let route = match radius_m {
            0.0 => route.line(100.0, 0.0),
            r => route.arc(f64::signum(r) * 1.5, f64::abs(r)),
        };
        let curvature = if radius_m == 0.0 { 0.0 } else { 1.0 / radius_m };
        let edge = Edge { route: route.clone(), next: vec![], width_m };
        let map = MapKnowledge::of(Network { edges: vec![edge] });
        let (x, p) = ([90.0, 9.0, 0.8, 0.7], covariance(seed));
        let found = along(x, &p).cartesian(&map);
        let point = route.at(90.0);
        let (u, n, v) = (point.along, Vector2::new(-point.along.y, point.along.x), x[1]);
        let place = point.position + n * 0.7;
        let accelerated = u * 0.8 + n * (curvature * v * v);
        for axis in 0..2 {
            let wanted = [place.coords[axis], u[axis] * v, accelerated[axis]];
            for (k, wanted) in wanted.into_iter().enumerate() {
                assert!((found.x[k].array()[axis] - wanted).abs() < 1e-9, "{seed} {axis} {k}");
            }
        }
        // In the order of a full covariance: x, vx, ax, y, vy, ay.
        let mut by = SMatrix::<f64, 6, 4>::zeros();
        let mut added = SMatrix::<f64, 6, 6>::zeros();
        for axis in 0..2 {
            let (u, n, at) = (u[axis], n[axis], 3 * axis);
            (by[(at, 0)], by[(at, 3)]) = (u, n);
            (by[(at + 1, 1)], by[(at + 1, 0)]) = (u, n * curvature * v);
            (by[(at + 2, 2)], by[(at + 2, 1)]) = (u, 2.0 * n * curvature * v);
        }
        let drift = if width_m > 0.0 { 0.05 * v } else { 0.0 };
        for i in 0..2 {
            for j in 0..2 {
                added[(3 * i + 1, 3 * j + 1)] = drift * drift * n[i] * n[j];
                added[(3 * i + 2, 3 * j + 2)] = 0.09 * n[i] * n[j];
            }
        }
        close("covariance", found.covariance(), by * p * by.transpose() + added);
        // A deviation that is known better than paint is stated as well as paint.
        let known = along(x, &Matrix4::from_diagonal(&Vector4::new(4.0, 1.0, 0.25, 1e-9)));
        let p = known.cartesian(&map).position_cov();
        let across = p.xx * n.x * n.x + 2.0 * p.xy * n.x * n.y + p.yy * n.y * n.y;
        assert!((across - 0.0025).abs() < 1e-9, "{across}");
    }
}

/// A plot of everywhere says nothing: what is believed of the map goes by the chain of leaving and returning alone.
#[test]
fn without_a_word_from_plots_the_belief_is_the_chain() {
    let modes = Modes::new(&[cv(0.01)], &[&[1.0]], &[1.0]).expect("one");
    let map = MapKnowledge {
        leave_per_s: 0.02,
        return_per_s: 0.05,
        off_prior: 0.1,
        along: modes,
        ..MapKnowledge::of(Network::single(straight(0.3)))
    };
    let first = plot_at(0.0, 500.0, 100.0, 4.0);
    let route = &map.network.edges[0].route;
    let on_way = route.at(500.0).position;
    let first = Plot { position_m: on_way, ..first };
    let mut filter =
        MapAided::<9>::from_plot(&first, Arc::new(map), Arc::new(Modes::three()), Start::default())
            .expect("sound");
    assert!((filter.on_map() - 0.9).abs() < 1e-9, "{}", filter.on_map());
    let (mut on, mut time) = (0.9, 0.0);
    for k in 0..60 {
        let dt = if k % 3 == 0 { 2.0 } else { 0.7 };
        time += dt;
        let (leave, back) = (1.0 - libm::exp(-0.02 * dt), 1.0 - libm::exp(-0.05 * dt));
        on = on * (1.0 - leave) + (1.0 - on) * back;
        let plot = Plot { position_m: on_way, ..plot_at(time, 0.0, 0.0, 1e16) };
        filter.update(&plot).expect("sound");
        assert!((filter.on_map() - on).abs() < 1e-4, "{time}: {} {on}", filter.on_map());
        let histories: f64 =
            filter.kept[..filter.len].iter().map(|h| libm::exp(h.log_weight)).sum();
        assert!((histories - filter.on_map()).abs() < 1e-9 && filter.len == 1);
    }
    assert!((on - 5.0 / 7.0).abs() < 0.03, "{on}");
}

/// Ways out of a junction share what comes to it as they are stated, and modes as their transitions say.
#[test]
fn a_junction_shares_what_comes_to_it() {
    let stem = Route::from_course(Point2::origin(), 0.0).line(200.0, 0.0);
    let end = Point2::new(200.0, 0.0);
    let way = |course| Edge {
        route: Route::from_course(end, course).line(400.0, 0.0),
        next: vec![],
        width_m: 0.0,
    };
    let stem = Edge { route: stem, next: vec![(1, 0.7), (2, 0.3)], width_m: 0.0 };
    let modes = Modes::new(&[cv(0.01)], &[&[1.0]], &[1.0]).expect("one");
    let network = Network { edges: vec![stem, way(0.0), way(0.4)] };
    let map = MapKnowledge { along: modes, ..MapKnowledge::of(network) };
    let first = plot_at(0.0, 100.0, 0.0, 4.0);
    let mut filter = MapAided::<9>::from_plot(
        &first,
        Arc::new(map),
        Arc::new(Modes::three()),
        Start { sigma_v_mps: 5.0, ..Start::default() },
    )
    .expect("sound");
    assert_eq!(filter.len, 1, "the way that it is on");
    // Not yet there: within two deviations of the end it would be.
    filter.kept[0].x = [150.0, 10.0, 0.0, 0.0];
    filter.kept[0].p = [4.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    let mut out = [Along::default(); CHILDREN];
    for (t, ways) in [(4.0, 1), (4.5, 2)] {
        // s ± 2σ: 190 + 2·√(4 + 16) = 198.94 and 195 + 2·√(4 + 20.25) = 204.85.
        let count = filter.children(t, &mut out);
        assert_eq!(count, ways, "{t}");
        let step = cv(0.01).step(t);
        for child in &out[..count] {
            let (edge, share) = (child.edge, child.log_weight - filter.kept[0].log_weight);
            let (before_m, part) = match edge {
                0 => (0.0, 1.0),
                1 => (200.0, 0.7),
                _ => (200.0, 0.3),
            };
            assert!((child.x[0] - (150.0 + 10.0 * step.t - before_m)).abs() < 1e-9, "{child:?}");
            assert!((share - libm::log(part)).abs() < 1e-9, "{child:?}");
        }
    }
}

/// Ways of a new state: within the gates across the way and of the velocity across it, against the way only a little.
#[test]
fn a_state_is_found_on_the_ways_that_it_fits() {
    let one = Modes::new(&[cv(0.01)], &[&[1.0]], &[1.0]).expect("one");
    let free = Arc::new(Modes::three());
    let there = |across_m: f64, across_mps: f64, width_m: f64| {
        let route = Route::from_course(Point2::origin(), 0.0).line(1000.0, 0.0);
        let edge = Edge { route, next: vec![], width_m };
        let map =
            MapKnowledge { along: one.clone(), ..MapKnowledge::of(Network { edges: vec![edge] }) };
        let first = plot_at(0.0, 500.0, across_m, 4.0);
        let mut filter =
            MapAided::<9>::from_plot(&first, Arc::new(map), Arc::clone(&free), Start::default())
                .expect("sound");
        let at = Point2::new(500.0, across_m);
        let mut state = Gaussian::at_position(at, Sym2 { xx: 9.0, xy: 0.0, yy: 4.0 }, 2.0, 0.5);
        state.x[1] = Pair::new(10.0, across_mps);
        filter.find_on_map(&state, 0.8);
        assert!((filter.on_map() - if filter.len > 0 { 0.8 } else { 0.0 }).abs() < 1e-9);
        filter.len
    };
    // 99.9 %: √10.828 = 3.2906 deviations, of 2 m, or of 2 m and 30 m / 15 together.
    for (width_m, sigma_m) in [(0.0, 2.0), (30.0, libm::sqrt(8.0))] {
        assert_eq!(there(3.28 * sigma_m, 0.0, width_m), 1);
        assert_eq!(there(3.30 * sigma_m, 0.0, width_m), 0);
        assert_eq!(there(-3.30 * sigma_m, 0.0, width_m), 0);
    }
    // The velocity: 2² + 0.01·10² + 0.25.
    let sigma_mps = libm::sqrt(5.25);
    assert_eq!((there(0.0, 3.28 * sigma_mps, 0.0), there(0.0, 3.30 * sigma_mps, 0.0)), (1, 0));
    // There and back: e² likelier along the way than against it.
    let both = [0.0, std::f64::consts::PI].map(|course| {
        let from = Point2::new(500.0 - 500.0 * libm::cos(course), 0.0);
        let route = Route::from_course(from, course).line(1000.0, 0.0);
        Edge { route, next: vec![], width_m: 0.0 }
    });
    let map = MapKnowledge { along: one, ..MapKnowledge::of(Network { edges: both.to_vec() }) };
    let first = plot_at(0.0, 500.0, 0.0, 4.0);
    let mut filter =
        MapAided::<9>::from_plot(&first, Arc::new(map), free, Start::default()).expect("sound");
    let mut state = filter.off.estimate().state;
    state.x[1] = Pair::new(10.0, 0.0);
    filter.find_on_map(&state, 0.8);
    let logs: Vec<(u16, f64)> =
        filter.kept[..filter.len].iter().map(|h| (h.edge, h.log_weight)).collect();
    let [(0, ahead), (1, back)] = logs[..] else { panic!("{logs:?}") };
    assert!((ahead - back - 2.0).abs() < 1e-6, "{logs:?}");
    assert!((libm::exp(ahead) + libm::exp(back) - 0.8).abs() < 1e-9, "{logs:?}");
}
