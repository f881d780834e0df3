#![allow(
    clippy::disallowed_methods,
    reason = "the naive forms are written as one would without care"
)]

//! Hard cases of the radar: each law holds, and the naive form breaks it.

use models::environment::Weather;
use models::environment::rain::{RainLaw, path_mean};
use models::environment::surface::{Fresnel, MATERIALS, Roughness};
use models::frames::Point2;
use models::sensors::radar::antenna::Pattern;
use models::sensors::radar::detection::{Detector, Swerling, from_db, ln_ratio, marcum_q, to_db};
use models::sensors::radar::geometry::{LeanPaths, RoundEarth, TwoPaths};
use models::sensors::radar::propagation;
use models::sensors::radar::shadow::{knife_edge_db, knife_edge_parameter};
use models::sensors::reporting::constellation::Dop;
use models::sensors::reporting::gauss_markov::{Gm1Step, Gm2Step};
use models::special::i0e;
use std::f64::consts::PI;
use std::hint::black_box;

struct Case {
    name: &'static str,
    law: &'static str,
    /// Whether the product's form obeys the law.
    holds: fn() -> bool,
    /// Whether the textbook form, written down as it stands, breaks it.
    naive_breaks: fn() -> bool,
}

const PFA: f64 = 1e-6;

fn ku() -> Pattern {
    Pattern {
        azimuth_rad: 0.25f64.to_radians(),
        elevation_rad: 1.6f64.to_radians(),
        axis_rad: 1f64.to_radians(),
        skirt_end_rad: Some(31f64.to_radians()),
        floor: 1e-3,
    }
}

const CASES: &[Case] = &[
    Case {
        name: "path difference of 1e-13 m over 1000 km",
        law: "relative error below 1e-12",
        holds: || {
            let d = TwoPaths::flat(1e6, 60.0, 1e-9).difference_m;
            (d / 1.199_999_997_84e-13 - 1.0).abs() < 1e-12
        },
        naive_breaks: || {
            let p = TwoPaths::flat(1e6, 60.0, 1e-9);
            p.reflected_m - p.direct_m == 0.0
        },
    },
    Case {
        name: "ground range 0",
        law: "finite, no path beyond the mast",
        holds: || {
            let p = TwoPaths::flat(0.0, 60.0, 2.0);
            p.direct_m == 58.0 && p.difference_m == 4.0 && p.grazing_rad == PI / 2.0
        },
        naive_breaks: || ((60.0f64 + 2.0) / 0.0).is_infinite(),
    },
    Case {
        name: "all heights 0",
        law: "finite, reflection point in the middle",
        holds: || {
            let p = TwoPaths::flat(100.0, 0.0, 0.0);
            p.reflection_point_m == 50.0 && p.difference_m == 0.0
        },
        naive_breaks: || {
            let (own_m, target_m) = black_box((0.0f64, 0.0));
            (100.0 * own_m / (own_m + target_m)).is_nan()
        },
    },
    Case {
        name: "round earth at range 0 and height 0",
        law: "flat formulas, divergence 1",
        holds: || {
            let r = RoundEarth::new(0.0, 0.0, 0.0);
            r.divergence == 1.0 && r.reflection_point_m == 0.0
        },
        naive_breaks: || (2.0f64 * 0.0 / 0.0f64.powi(3)).is_nan(),
    },
    Case {
        name: "round earth beyond the horizon",
        law: "no reflected ray instead of NaN",
        holds: || {
            let r = RoundEarth::new(60_000.0, 60.0, 1.0);
            r.divergence.is_finite() && r.difference_m >= 0.0 && r.grazing_rad >= 0.0
        },
        naive_breaks: || (60.0 - 50_000.0f64.powi(2) / (2.0 * 8.5e6)) < 0.0,
    },
    Case {
        name: "1 + Γ at a grazing angle of 1e-10",
        law: "relative error below 1e-12",
        holds: || {
            let f = Fresnel::half_space(MATERIALS[1].permittivity(16.0), 1e-10);
            let g = Fresnel::half_space(MATERIALS[1].permittivity(16.0), 1e-9);
            (g.one_plus_horizontal.re / f.one_plus_horizontal.re / 10.0 - 1.0).abs() < 1e-8
        },
        naive_breaks: || {
            let f = Fresnel::half_space(MATERIALS[1].permittivity(16.0), 1e-10);
            let naive = 1.0 + f.horizontal.re;
            (naive / f.one_plus_horizontal.re - 1.0).abs() > 1e-8
        },
    },
    Case {
        name: "grazing exactly 0",
        law: "Γ = −1 for both polarisations",
        holds: || {
            let f = Fresnel::half_space(MATERIALS[1].permittivity(16.0), 0.0);
            f.horizontal.re == -1.0 && f.vertical.re == -1.0 && f.one_plus_vertical.re == 0.0
        },
        naive_breaks: || (0.0f64.ln()).is_infinite(),
    },
    Case {
        name: "multipath null",
        law: "power zero or above, Pd then Pfa",
        holds: || {
            let power = propagation::coherent(1.0, PI);
            let detector = Detector::new(14, PFA);
            power >= 0.0
                && detector.probability(power, Swerling::One) >= PFA
                && (detector.probability(0.0, Swerling::Steady) - PFA).abs() < 1e-20
        },
        naive_breaks: || {
            (0..1000).any(|i| {
                let phase = PI + f64::from(i) * 1e-9;
                1.0 + 1.0 + 2.0 * phase.cos() < (2.0 * (0.5 * phase).cos()).powi(2) * 0.5
            })
        },
    },
    Case {
        name: "roughness of half a metre at 60 degrees",
        law: "finite, between 0 and 1",
        holds: || {
            let rho = Roughness::MillerBrownVegh.factor(0.5, 0.0187, PI / 3.0);
            rho > 0.0 && rho < 0.01
        },
        naive_breaks: || ((-40_600f64).exp() * (40_600f64).exp()).is_nan(),
    },
    Case {
        name: "Marcum Q at a = 40, b = 30",
        law: "1, with ln P about −52",
        holds: || {
            let m = marcum_q(1, 40.0, 30.0);
            m.q == 1.0 && m.p > 0.0 && m.ln_p < -50.0 && m.ln_p > -60.0
        },
        naive_breaks: || (-800f64).exp() == 0.0,
    },
    Case {
        name: "Marcum Q far beyond: a = 1000, b = 900",
        law: "the logarithm of the complement stays finite",
        holds: || {
            let m = marcum_q(1, 1000.0, 900.0);
            m.q == 1.0 && m.ln_p.is_finite() && (m.ln_p + 5000.0).abs() < 20.0
        },
        naive_breaks: || (1.0 - black_box(1.0f64)).ln() == f64::NEG_INFINITY,
    },
    Case {
        name: "miss probability at 40 dB",
        law: "log₁₀ about −4029",
        holds: || {
            let ln = Detector::new(1, PFA).ln_miss(1e4, Swerling::Steady);
            (ln / std::f64::consts::LN_10 + 4029.345).abs() < 1e-2
        },
        naive_breaks: || {
            let pd = Detector::new(1, PFA).probability(1e4, Swerling::Steady);
            (1.0 - pd).log10() == f64::NEG_INFINITY
        },
    },
    Case {
        name: "Pd from −80 to +90 dB, every case, 1 to 512 pulses",
        law: "never below Pfa or above 1, and monotone",
        holds: || {
            [1, 2, 14, 64, 512].iter().all(|&n| {
                let detector = Detector::new(n, PFA);
                (0..=4).all(|case| {
                    let case = Swerling::case(case).expect("a case");
                    let pd = |db: i32| detector.probability(from_db(f64::from(db)), case);
                    (-80..90).all(|db| {
                        let (a, b) = (pd(db), pd(db + 1));
                        a >= PFA && b <= 1.0 && b >= a * (1.0 - 1e-12)
                    })
                })
            })
        },
        naive_breaks: || (-(10f64.powf(9.0))).exp() == 0.0,
    },
    Case {
        name: "rain of 0 mm/h",
        law: "exactly no attenuation",
        holds: || RainLaw::new(16.0, 0.0, PI / 4.0).two_way_db(0.0, 40.0) == 0.0,
        naive_breaks: || (0.0f64.ln() * 1.06).is_infinite(),
    },
    Case {
        name: "rain of 250 mm/h over 40 km",
        law: "decibels finite, power zero or above, display at its floor",
        holds: || {
            let db = RainLaw::new(16.0, 0.0, PI / 4.0).two_way_db(250.0, 40.0);
            let power = from_db(30.0 - db);
            db > 1000.0 && power >= 0.0 && to_db(power) == -300.0
        },
        naive_breaks: || {
            let db = RainLaw::new(35.0, 0.0, PI / 4.0).two_way_db(1000.0, 400.0);
            10.0 * 10f64.powf(-db / 10.0).log10() == f64::NEG_INFINITY
        },
    },
    Case {
        name: "decibels of zero",
        law: "a floor, and the difference of two zeros is zero",
        holds: || to_db(0.0) - to_db(0.0) == 0.0,
        naive_breaks: || (0.0f64.log10() - 0.0f64.log10()).is_nan(),
    },
    Case {
        name: "both edges of the cosecant skirt",
        law: "no step",
        holds: || {
            [1.8f64, 31.0].iter().all(|edge| {
                let at = |e: f64| ku().elevation(e.to_radians());
                (at(edge - 1e-9) / at(edge + 1e-9) - 1.0).abs() < 1e-6
            })
        },
        naive_breaks: || {
            // Skirt normalised to 1 instead of one half at its start.
            let naive = |e: f64| if e > 1.8 { 1.0 } else { 0.5 };
            naive(1.8 + 1e-9) / naive(1.8) > 1.5
        },
    },
    Case {
        name: "rain cell below the antenna's foot",
        law: "no arc sine beyond 1",
        holds: || ku().rain_integral(30.0, 60.0, 3000.0).is_finite(),
        naive_breaks: || (60.0f64 / 30.0).asin().is_nan(),
    },
    Case {
        name: "azimuth across north",
        law: "359.9° and 0.1° are 0.2° apart",
        holds: || {
            let g = ku().azimuth((359.9f64 - 0.1).to_radians());
            (g - ku().azimuth(0.2f64.to_radians())).abs() < 1e-9
        },
        naive_breaks: || (-4.0 * 2f64.ln() * (359.8f64 / 0.25).powi(2)).exp() == 0.0,
    },
    Case {
        name: "knife edge at the target",
        law: "finite",
        holds: || {
            let v = knife_edge_parameter(1.0, 1000.0, 0.0, 0.0187);
            knife_edge_db(v).is_finite() && knife_edge_db(-v) == 0.0
        },
        naive_breaks: || (2.0f64 * 1000.0 / (0.0187 * 1000.0 * 0.0)).is_infinite(),
    },
    Case {
        name: "phase of a path of a million wavelengths",
        law: "within one turn, to 1e-9 rad",
        holds: || {
            let phase = propagation::path_phase_rad(1_000_000.25 * 0.0187, 0.0187);
            (phase - PI / 2.0).abs() < 1e-8
        },
        naive_breaks: || {
            let naive = 2.0 * PI as f32 * (1_000_000.25f32 * 0.0187) / 0.0187;
            (f64::from(naive.rem_euclid(2.0 * PI as f32)) - PI / 2.0).abs() > 1e-2
        },
    },
    Case {
        name: "three satellites, and four in one place",
        law: "no fix instead of a division by zero",
        holds: || {
            let three = [[0.0, 0.9, 0.4], [0.8, -0.4, 0.4], [-0.8, -0.4, 0.4]];
            Dop::of(&three, &[1.0; 3]).is_none()
                && Dop::of(&[[0.0, 0.6, 0.8]; 4], &[1.0; 4]).is_none()
        },
        naive_breaks: || {
            // The determinant of four equal rows.
            let determinant = black_box(0.6f64 * 0.8) - 0.8 * 0.6;
            (1.0 / determinant).is_infinite()
        },
    },
    Case {
        name: "Gauss-Markov step of 1e-10 time constants",
        law: "driving variance 2Δ/τ to 1e-9",
        holds: || (Gm1Step::new(1.0, 1.0, 1e-10).q / 2e-10 - 1.0).abs() < 1e-9,
        naive_breaks: || {
            let naive = 1.0 - black_box(-2e-10f64).exp();
            (naive / 2e-10 - 1.0).abs() > 1e-9
        },
    },
    Case {
        name: "Gauss-Markov step of 1e18 time constants",
        law: "the stationary variance, nothing left of the state",
        holds: || {
            let (one, two) = (Gm1Step::new(3.0, 1e-9, 1e9), Gm2Step::new(3.0, 1e-9, 1e9));
            one.phi == 0.0 && one.q == 9.0 && (two.q11 - 9.0).abs() < 1e-12 && two.q22.is_finite()
        },
        naive_breaks: || {
            // The textbook's (1 + βΔ)·e^(−βΔ) as a ratio of the two.
            let x = black_box(1e18f64);
            ((1.0 + x) / x.exp() * x.exp()).is_nan()
        },
    },
    Case {
        name: "second-order step of 3e-9 time constants",
        law: "Q₁₁ = (4/3)σ²x³ and a positive determinant",
        holds: || {
            let step = Gm2Step::new(1.0, 1.0, 3e-9);
            let leading = 4.0 / 3.0 * 3e-9f64.powi(3);
            (step.q11 / leading - 1.0).abs() < 1e-6 && step.q11 * step.q22 > step.q12 * step.q12
        },
        naive_breaks: || {
            let x = black_box(3e-9f64);
            let naive = 1.0 - (-2.0 * x).exp() * (1.0 + 2.0 * x + 2.0 * x * x);
            (naive / (4.0 / 3.0 * x.powi(3)) - 1.0).abs() > 0.5
        },
    },
    Case {
        name: "Bessel function of 40 600",
        law: "e^(−x)·I₀(x) is 1/√(2πx)·(1 + 1/(8x))",
        holds: || {
            let x = 40_600.0f64;
            let asymptote = (1.0 + 1.0 / (8.0 * x)) / (2.0 * PI * x).sqrt();
            (i0e(x) / asymptote - 1.0).abs() < 1e-9
        },
        naive_breaks: || (black_box(-40_600f64).exp() * black_box(40_600f64).exp()).is_nan(),
    },
    Case {
        name: "logarithm of a power that underflows",
        law: "−4000 dB keeps its logarithm, the power is 0",
        holds: || {
            from_db(-4000.0) == 0.0 && (ln_ratio(-4000.0) + 921.034_037_197_618_3).abs() < 1e-9
        },
        naive_breaks: || 10f64.powf(black_box(-400.0)).ln() == f64::NEG_INFINITY,
    },
    Case {
        name: "antenna at the foot of its own mast, target at the antenna's height",
        law: "finite paths by sines and by angles",
        holds: || {
            let lean = LeanPaths::flat(0.0, 60.0, 60.0);
            lean.direct_m == 0.0 && lean.sin_depression.is_finite() && lean.sin_grazing == 1.0
        },
        naive_breaks: || (black_box(0.0f64) / black_box(0.0)).is_nan(),
    },
    Case {
        name: "rain cell at the radar, path of no length",
        law: "the rain over it",
        holds: || {
            let here = Point2::origin();
            let weather = Weather { rain_mm_per_h: 7.0, ..Weather::default() };
            path_mean(&weather, here, here, |r| r) == 7.0
        },
        naive_breaks: || (black_box(0.0f64) / black_box(0.0)).is_nan(),
    },
];

#[test]
fn every_hard_case_obeys_its_law_and_its_naive_form_does_not() {
    let mut failed = Vec::new();
    for case in CASES {
        println!("{}: {}", case.name, case.law);
        if !(case.holds)() {
            failed.push(format!("{}: {} does not hold", case.name, case.law));
        }
        if !(case.naive_breaks)() {
            failed.push(format!("{}: the naive form is not that bad", case.name));
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
    assert!(CASES.len() >= 28);
}
