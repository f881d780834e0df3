//! Who stood and sets off, on radar alone: without a name, and so without a length, he is told of soon, and noise is not.

use super::places::{first, noise, seen, with_bar};
use super::*;

/// Distances from where it stood, m, as a radar's track gave them that had settled on one who held for a minute: the first step of his
/// 6 m was a jump, and he was nobody for twelve seconds.
const SET_OFF_M: [f64; 18] = [
    6.0, 9.0, 14.0, 15.0, 22.0, 31.0, 37.0, 45.0, 54.0, 61.0, 69.0, 72.0, 77.0, 79.0, 80.0, 83.0,
    90.0, 93.0,
];

/// Stands 21 m before the line from second 1 on, and sets off at `from` as [`SET_OFF_M`] says, or comes back after so many steps.
fn sets_off(from: u32, back_after: usize) -> impl Fn(u32) -> Vec<Target> {
    move |s: u32| {
        let gone_m = |s: u32| {
            let step = s.checked_sub(from).map(|step| step as usize);
            let there = step.filter(|step| *step < back_after);
            there.map_or(0.0, |step| SET_OFF_M[step.min(SET_OFF_M.len() - 1)])
        };
        let v = if s > 1 { gone_m(s - 1) - gone_m(s) } else { 0.0 };
        let x = 111.0 - gone_m(s) + 0.4 * noise(s);
        vec![target(7, "", (x, 1000.0 + 0.4 * noise(s + 3)), (0.6 * v, 0.1 * noise(s + 5)), s)]
    }
}

/// He came to the line before he stood there: his nose is ahead of him.
fn comes_first(of: impl Fn(u32) -> Vec<Target>) -> impl Fn(u32) -> Vec<Target> {
    move |s: u32| {
        let mut all = of(s);
        if s < 20 {
            let one = &mut all[0];
            one.position_m.x += 5.0 * f64::from(20 - s);
            one.velocity_mps = Vector2::new(-5.0, 0.0);
        }
        all
    }
}

fn told(targets: impl Fn(u32) -> Vec<Target>) -> [Option<u32>; 2] {
    let found = seen(&with_bar(), &Board::default(), Parameters::on_tracks(), 110, targets);
    ["STOPBAR", "NOCLR_RWY"].map(|kind| first(&found, kind))
}

/// At XSYN somebody passed the bar of his runway at 955 s and was in its strip at 958 s; on radar alone both were told when the silence after
/// his first step was over, at 970 s.
#[test]
fn who_stood_for_long_and_sets_off_is_told_of_in_time() {
    let [bar, runway] = told(comes_first(sets_off(80, usize::MAX)));
    // Of known length 38 m and seen exactly.
    let exact = |s: u32| {
        let (t, x) = (f64::from(s), f64::from(s.max(75) - 75));
        let gone_m = if s < 20 { -5.0 * (20.0 - t) } else { 0.35 * x * x };
        vec![target(
            1,
            "ABC1",
            (111.0 - gone_m, 1000.0),
            (if s < 20 { -5.0 } else { -0.7 * x }, 0.0),
            s,
        )]
    };
    let found = seen(&with_bar(), &Board::default(), Parameters::default(), 110, exact);
    let at = |kind| first(&found, kind).expect("raised");
    let (bar, runway) = (bar.expect("raised"), runway.expect("raised"));
    // He has to have gone on for two seconds.
    assert!(bar <= at("STOPBAR") + 6, "{bar}, {}", at("STOPBAR"));
    assert!(runway <= at("NOCLR_RWY") + 3, "{runway}, {}", at("NOCLR_RWY"));
}

/// By one jump, and by two steps in which somebody else draws it along, nobody has set off.
#[test]
fn who_jumps_and_comes_back_has_not_set_off() {
    for steps in 1..=2 {
        assert_eq!(told(comes_first(sets_off(80, steps))), [None, None], "{steps} steps");
    }
}

/// Noise of a radar alone on one who holds without a name, his nose guessed.
#[test]
fn who_holds_without_a_name_is_over_no_line() {
    for before_m in [8.0, 15.0, 21.0, 30.0, 36.0] {
        let stands = |s: u32| {
            let x = 90.0 + before_m + 1.5 * noise(s);
            vec![target(7, "", (x, 1000.0 + noise(s + 3)), (0.5 * noise(s + 4), 0.3), s)]
        };
        assert_eq!(told(comes_first(stands)), [None, None], "{before_m} m");
    }
}
