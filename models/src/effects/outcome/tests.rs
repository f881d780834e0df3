//! The rules of this file against sums, grids and filters that take longer.

use super::*;

fn close(found: f64, expected: f64, relative: f64) -> bool {
    (found - expected).abs() <= relative * expected.abs()
}

/// Q(z) of tables (Abramowitz and Stegun, 26.1) twice: both sides.
const BEYOND_2: f64 = 0.045_500_26;
const BEYOND_1: f64 = 0.317_310_51;

#[test]
fn a_wrong_ratio_shifts_by_the_difference_of_the_deviations_at_the_worst_ratio() {
    let sigma = |ratio: f64, least: f64| 3.0 / ratio.max(least).sqrt();
    for (least, lowest, raises, lowers) in [
        (0.5, 2.0, 1.0, 0.0),
        (0.5, 2.0, 0.0, 1.0),
        (0.5, 2.0, 2.0, 1.0),
        (0.5, 2.0, 1.0, 6.0),
        (4.0, 0.1, 1.5, 1.5),
        (4.0, 5.0, 0.2, 3.0),
        (1.0, 100.0, 0.0, 0.0),
    ] {
        // Every exact ratio from the lowest up, in steps of a thousandth, shown too high and too low.
        let worst =
            (0..20_000).map(|k| lowest * libm::pow(1.001, f64::from(k))).fold(0.0, |w, exact| {
                let off = |db: f64| {
                    let shown = exact * libm::pow(10.0, db / 10.0);
                    (sigma(exact, least) - sigma(shown, least)).abs()
                };
                f64::max(w, f64::max(off(raises), off(-lowers)))
            });
        let found = shift_by_ratio(3.0, least, lowest, raises, lowers);
        assert!(
            close(found, worst, 2e-3),
            "{least} {lowest} {raises} {lowers}: {found} for {worst}"
        );
    }
}

/// The sums over edges at four thousand places of a step, with as many edges as count.
fn summed(u: f64, f: impl Fn(f64) -> f64) -> f64 {
    let edges = (9.0 / u).ceil() as i32;
    let at = |place: i32| {
        let offset = f64::from(place) / 4_000.0;
        u * (-edges - 1..=edges).map(|k| f((f64::from(k) + offset) * u)).sum::<f64>()
    };
    (0..=4_000).map(at).fold(0.0, f64::max)
}

fn density(z: f64) -> f64 {
    libm::exp(-0.5 * z * z) / (2.0 * std::f64::consts::PI).sqrt()
}

#[test]
fn factors_of_steps_are_those_of_the_worst_place() {
    for u in
        [0.05, 0.1, 0.19, 0.2, 0.3, 0.7, 0.99, 1.0, 1.3, 1.9, 2.0, 2.4, 3.0, 5.0, 8.0, 11.5, 20.0]
    {
        // Spread places, or where fewer than five steps are in a deviation: the worst.
        let worst = summed(u, |z| z.abs() * density(z)).max((2.0 / std::f64::consts::PI).sqrt());
        let found = edge_factor(u);
        let slack = if u < 0.2 { 1.7e-3 } else { 3e-4 };
        assert!(
            found > worst * (1.0 - slack) && found < worst * (1.0 + 1e-9),
            "{u}: {found} for {worst}"
        );
        // Poisson's sum: 1 + 2 Σ exp(−2π²m²/u²), largest on an edge.
        let waves = |m: i32| libm::exp(-2.0 * (std::f64::consts::PI * f64::from(m) / u).powi(2));
        let worst = 1.0 + 2.0 * (1..200).map(waves).sum::<f64>();
        let found = density_factor(u);
        let slack = if u < 1.0 { 1e-7 } else { 1e-6 };
        assert!(close(found, worst, slack), "{u}: {found} for {worst}");
    }
}

#[test]
fn the_table_of_factors_is_never_below_them_nor_far_above() {
    let table = StepTable::default();
    for k in 0..=1_300u32 {
        let u = f64::from(k) * 0.013;
        let (edge, dense) = table.at(u);
        let (exact_edge, exact_dense) = (edge_factor(u), density_factor(u));
        assert!(edge > 0.999 * exact_edge && edge < 1.08 * exact_edge, "{u}: {edge} {exact_edge}");
        assert!(
            dense > 0.999 * exact_dense && dense < 1.11 * exact_dense,
            "{u}: {dense} {exact_dense}"
        );
    }
    // The last entry of the table is where only one edge counts any more.
    for u in [12.0, 13.7, 400.0] {
        let (edge, dense) = table.at(u);
        assert!(close(edge, u * libm::exp(-0.5) / (2.0 * std::f64::consts::PI).sqrt(), 1e-5));
        assert!(close(dense, u / (2.0 * std::f64::consts::PI).sqrt(), 1e-12));
    }
}

#[test]
fn a_change_of_detection_is_the_largest_along_the_curve() {
    let rising = |db: f64| 1.0 / (1.0 + libm::exp(-(db - 13.0)));
    for (range, raises, lowers) in [
        ((0.0, 30.0), 1.0, 0.0),
        ((0.0, 30.0), 0.0, 1.0),
        ((0.0, 30.0), 0.5, 2.0),
        ((0.0, 30.0), 2.0, 0.5),
        ((14.0, 60.0), 1.0, 1.0),
        ((-60.0, 9.0), 1.0, 1.0),
        ((0.0, 30.0), 0.0, 0.0),
        // Flat to the last bit but for one end.
        ((-4_000.0, 20.0), 1.0, 1.0),
        ((12.0, 9_000.0), 1.0, 1.0),
    ] {
        let worst = (0..=200_000).fold(0.0, |w, k| {
            let db = range.0 + (range.1 - range.0) * f64::from(k) / 200_000.0;
            let change =
                f64::max(rising(db + raises) - rising(db), rising(db) - rising(db - lowers));
            f64::max(w, change)
        });
        let found = detection_change(rising, range, raises, lowers, 60);
        let slack = 1e-3 * worst;
        assert!((found - worst).abs() <= slack, "{range:?} {raises} {lowers}: {found} for {worst}");
    }
}

/// Whatever was looked at counts: the ends, and both places of every step.
#[test]
fn the_largest_of_what_was_looked_at_is_kept() {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    for peak in [0.0, 1.0 - golden, golden, 1.0] {
        let bump = |x: f64| libm::exp(-(x - peak) * (x - peak) * 1e4);
        assert!((largest(&bump, (0.0, 1.0), 1) - 1.0).abs() < 1e-9, "{peak}");
    }
    assert_eq!([largest(&|x| x, (0.0, 1.0), 0), largest(&|x| 1.0 - x, (0.0, 1.0), 0)], [1.0; 2]);
}

const STILL: AxisShift = AxisShift {
    drawn_m: 0.0,
    fixed_m: 0.0,
    own_m: 0.0,
    bounded_m: 0.0,
    step_m: 0.0,
    factors: (0.0, 0.0),
    on_edge: false,
};

#[test]
fn without_steps_shifts_of_different_origin_add_as_squares_and_bounded_ones_as_they_are() {
    let shift = AxisShift { drawn_m: 3.0, fixed_m: 4.0, own_m: 12.0, ..STILL };
    assert_eq!(shift.square_m2(), 169.0);
    let bounded = AxisShift { bounded_m: 2.0, ..shift };
    assert_eq!(bounded.square_m2(), 81.0 + 144.0);
    assert_eq!((STILL.square_m2(), STILL.flip()), (0.0, 0.0));
    assert_eq!(AxisShift { step_m: 5.0, on_edge: true, ..STILL }.square_m2(), 0.0);
    // On an edge the least shift is a step more.
    let edge = AxisShift { step_m: 5.0, on_edge: true, ..bounded };
    assert_eq!((edge.square_m2(), edge.flip()), (26.0 * 26.0, 1.0));
    assert_eq!(AxisShift { on_edge: true, ..bounded }.square_m2(), bounded.square_m2());
    assert_eq!(AxisShift { on_edge: true, ..bounded }.flip(), 0.0);
    // Shifts of any origin carry it, and none makes up for another.
    let on_edge = AxisShift { step_m: 5.0, on_edge: true, ..STILL };
    for shift in [
        AxisShift { drawn_m: 1.0, ..on_edge },
        AxisShift { fixed_m: 1.0, ..on_edge },
        AxisShift { own_m: 1.0, ..on_edge },
        AxisShift { drawn_m: 1.0, own_m: 1.0, ..on_edge },
        AxisShift { fixed_m: 1.0, own_m: 1.0, ..on_edge },
        AxisShift { drawn_m: 1.0, fixed_m: 1.0, ..on_edge },
    ] {
        assert_eq!(shift.flip(), 1.0, "{shift:?}");
    }
}

/// What steps do to a shift, by every place of a step, every draw of the error and every draw of the shift's own.
fn carried(step_m: f64, drawn: f64, fixed: f64, own: f64) -> (f64, f64) {
    let normal = || (-40..=40).map(|k| f64::from(k) * 0.1).map(|z| (z, density(z) * 0.1));
    let (mut flips, mut square) = (0.0, 0.0);
    for (n, chance) in normal() {
        for (m, other) in normal() {
            let shift = drawn * n + fixed + own * m;
            // From a place that is anywhere in its step.
            let share = shift.abs() / step_m;
            flips += chance * other * share.min(1.0);
            let (whole, rest) = (share.floor(), share - share.floor());
            let mean = (1.0 - rest) * whole * whole + rest * (whole + 1.0) * (whole + 1.0);
            square += chance * other * mean * step_m * step_m;
        }
    }
    (flips, square)
}

#[test]
fn steps_carry_a_plot_as_often_as_counted_one_by_one() {
    for (drawn, fixed, own) in
        [(0.1, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.1), (0.05, 0.02, 0.05)]
    {
        let step_m = 3.0;
        let factors = (MEAN_ABS, 1.0);
        let shift =
            AxisShift { drawn_m: drawn, fixed_m: fixed, own_m: own, step_m, factors, ..STILL };
        let (flips, square) = carried(step_m, drawn, fixed, own);
        let alone = (drawn == 0.0) as u8 + (fixed == 0.0) as u8 + (own == 0.0) as u8 == 2;
        // A bound; of one kind of shift alone it is the value itself and the two hundredths.
        let (above, most) = (shift.flip() / flips, if alone { 1.03 } else { 2.0 });
        assert!((1.0..most).contains(&above), "{drawn} {fixed} {own}: {above}");
        let above = shift.square_m2() / square;
        assert!((1.0..most + 0.05).contains(&above), "{drawn} {fixed} {own}: {above}");
    }
    // Never more often than always.
    let far = AxisShift { fixed_m: 50.0, step_m: 3.0, factors: (MEAN_ABS, 1.0), ..STILL };
    assert_eq!(far.flip(), 1.0);
}

#[test]
fn the_tail_of_a_shift_is_that_of_the_normal_distribution_beyond_what_is_fixed() {
    let axis = |drawn_m, fixed_m, own_m, bounded_m| AxisShift {
        drawn_m,
        fixed_m,
        own_m,
        bounded_m,
        ..STILL
    };
    let cases = [
        ("nothing moves", [axis(0.0, 0.0, 0.0, 0.0), STILL], 0.0, 0.0),
        ("one axis", [axis(1.0, 0.0, 0.0, 0.0), STILL], 2.0, BEYOND_2),
        ("the other axis", [STILL, axis(1.0, 0.0, 0.0, 0.0)], 1.0, BEYOND_1),
        ("both axes", [axis(0.6, 0.0, 0.0, 0.0), axis(0.8, 0.0, 0.0, 0.0)], 2.0, BEYOND_2),
        ("draws of its own", [axis(0.6, 0.0, 0.4, 0.0), STILL], 2.0, BEYOND_2),
        ("a fixed part", [axis(1.0, 3.0, 0.0, 0.0), axis(0.0, 4.0, 0.0, 0.0)], 7.0, BEYOND_2),
        ("a bounded part", [axis(1.0, 2.0, 0.0, 1.0), axis(0.0, 1.0, 0.0, 3.0)], 7.0, BEYOND_2),
        ("fixed within", [axis(0.0, 3.0, 0.0, 0.0), axis(0.0, 4.0, 0.0, 0.0)], 5.0, 0.0),
        ("fixed beyond", [axis(0.0, 3.0, 0.0, 0.0), axis(0.0, 4.0, 0.0, 0.0)], 4.9, 1.0),
        ("drawn and fixed beyond", [axis(1.0, 3.0, 0.0, 0.0), STILL], 2.0, 1.0),
    ];
    for (name, axes, limit, expected) in cases {
        let found = tail(&axes, limit);
        assert!((found - expected).abs() < 1e-7, "{name}: {found} for {expected}");
    }
}

#[test]
fn steps_count_in_a_tail_by_their_chance_or_by_their_length_whichever_is_less() {
    let stepped =
        |drawn_m, step_m| AxisShift { drawn_m, step_m, factors: (MEAN_ABS, 1.0), ..STILL };
    // 1.02 √(2/π) 0.01/10: a step of ten is rare.
    let rare = 8.138_406e-4;
    let found = tail(&[stepped(0.01, 10.0), STILL], 1.0);
    assert!(close(found, rare, 1e-5), "{found}");
    let found = tail(&[stepped(0.01, 10.0), stepped(0.02, 10.0)], 1.0);
    assert!(close(found, 3.0 * rare, 1e-5), "{found}");
    // Where every shift is a step both are taken, three and four: five.
    let edge = |drawn_m, step_m| AxisShift { on_edge: true, ..stepped(drawn_m, step_m) };
    let found = tail(&[edge(1e-3, 3.0), edge(1e-3, 4.0)], 5.0 + 2e-3 * std::f64::consts::SQRT_2);
    assert!(close(found, BEYOND_2, 1e-5), "{found}");
    // One is taken, of the other the chance.
    let found = tail(&[stepped(1e-6, 1.0), stepped(1e-6, 100.0)], 1.5);
    assert!(close(found, 1.02 * MEAN_ABS * 1e-8, 1e-5), "{found}");
}

/// The variance that white jerk of unit density adds in a period, piece by piece.
fn grown(period_s: f64) -> Matrix3<f64> {
    let pieces = 20_000;
    let h = period_s / f64::from(pieces);
    (0..pieces).fold(Matrix3::zeros(), |sum, k| {
        let left = (f64::from(k) + 0.5) * h;
        let at = Vector3::new(0.5 * left * left, left, 1.0);
        sum + at * at.transpose() * h
    })
}

/// Gain and noise gain by the textbook's filter run until it is steady, and by its answer to one wrong plot.
fn filtered(t: f64, jerk: f64, variance: f64) -> (f64, f64) {
    let f = Matrix3::new(1.0, t, 0.5 * t * t, 0.0, 1.0, t, 0.0, 0.0, 1.0);
    let q = grown(t) * jerk;
    let (mut p, mut k) = (Matrix3::identity() * variance, Vector3::zeros());
    for _ in 0..20_000 {
        p = f * p * f.transpose() + q;
        k = p.column(0) / (p[(0, 0)] + variance);
        p -= k * p.row(0);
        p = (p + p.transpose()) * 0.5;
    }
    let (mut x, mut squares) = (k, 0.0);
    for _ in 0..20_000 {
        squares += x[0] * x[0];
        x = f * x;
        x -= k * x[0];
    }
    (k[0], squares)
}

#[test]
fn steady_gains_are_those_of_a_filter_that_has_run_for_long() {
    for (t, jerk, variance) in
        [(1.0, 0.3, 25.0), (0.5, 40.0, 1.0), (4.0, 0.3, 9.0), (2.0, 500.0, 0.5)]
    {
        let found = TrackGain::steady(t, jerk, variance).expect("steady");
        let (gain, noise) = filtered(t, jerk, variance);
        assert!(close(found.gain, gain, 1e-6), "{t} {jerk} {variance}: {} for {gain}", found.gain);
        assert!(close(found.noise_gain, noise, 1e-6), "{t} {jerk} {variance}: {noise}");
    }
    // A filter that hardly moves is Butterworth's of third order: gain 2 (qT⁵/r)^(1/6), noise 5/6 of it.
    let slow = TrackGain::steady(1.0, 1e-12, 1.0).expect("steady");
    assert!(
        close(slow.gain, 0.02, 0.02) && close(slow.noise_gain, 0.02 * 5.0 / 6.0, 0.02),
        "{slow:?}"
    );
    assert!(TrackGain::steady(1.0, f64::NAN, 1.0).is_none());
    assert!(TrackGain::steady(1.0, 1.0, 0.0).is_none());
    let track = TrackGain { gain: 0.5, noise_gain: 0.25 };
    assert_eq!(track.shift_m(8.0, 3.0), 5.0);
}
