//! Laws of what is driven by hand: whatever a person does, it stays a vehicle.

use super::*;
use proptest::prelude::*;

const DT: f64 = 0.05;

fn car() -> Driven {
    Driven {
        callsign: "FOLLOW1".into(),
        size: Size { length_m: 4.6, span_m: 1.9, aircraft: false },
        wheelbase_m: 2.7,
        most_mps: 27.8,
        acc_dec_mps2: (2.0, 3.0),
        at_m: Point2::new(100.0, -50.0),
        heading_rad: 1.0,
    }
}

fn airliner() -> Driven {
    Driven {
        callsign: "HBIJA".into(),
        size: Size { length_m: 37.57, span_m: 35.8, aircraft: true },
        wheelbase_m: 12.6,
        most_mps: 15.4,
        acc_dec_mps2: (0.7, 0.7),
        ..car()
    }
}

/// Drives with one wish for so long, heard all the time.
fn driven(hand: &mut Hand, from_s: f64, for_s: f64, wish: Wish) -> f64 {
    (hand.taken, hand.wish) = (true, wish);
    let steps = (for_s / DT).round() as usize;
    for k in 1..=steps {
        let now_s = from_s + k as f64 * DT;
        hand.heard_s = now_s;
        hand.step(now_s, DT);
    }
    from_s + for_s
}

fn wish(throttle: i16, brake: i16, steer: i16) -> Wish {
    Wish { throttle, brake, steer }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// 60 drivers with 200 wishes each, some of them silent for seconds.
    #[test]
    fn whatever_is_wished_it_stays_within_its_limits(
        inputs in prop::collection::vec(
            (-1000_i16..=1000, prop_oneof![3 => Just(0_i16), 1 => 0_i16..=1000], -1000_i16..=1000, 1_u32..60, prop::bool::weighted(0.9)),
            200,
        ),
        heavy: bool,
    ) {
        let of = if heavy { airliner() } else { car() };
        let mut hand = Hand::new(of.clone());
        hand.taken = true;
        let mut now_s = 0.0;
        for (throttle, brake, steer, steps, heard) in inputs {
            hand.wish = wish(throttle, brake, steer);
            for _ in 0..steps {
                now_s += DT;
                if heard {
                    hand.heard_s = now_s;
                }
                let before = hand.clone();
                hand.step(now_s, DT);
                let (state, old) = (hand.state(), before.state());
                let all = [hand.v, hand.a, hand.heading_rad, hand.steer_rad, hand.nose_m.x, hand.nose_m.y];
                prop_assert!(all.iter().all(|x| x.is_finite()));
                prop_assert!((0.0..=of.most_mps + 0.2).contains(&hand.v), "{} m/s", hand.v);
                let change = (hand.v - before.v) / DT;
                let least = -HARDEST_MPS2.max(of.acc_dec_mps2.1) - 0.1;
                let stands = hand.v == 0.0;
                prop_assert!(change <= of.acc_dec_mps2.0 + 0.01 && (change >= least || stands), "{change} m/s2");
                let jolt = (hand.a - before.a).abs();
                prop_assert!(stands || jolt <= JERK_MPS3 * DT + 1e-9, "{jolt}");
                // Never turned in a step by more than the wheels do, nor pressed aside more than bounded.
                let moved_m = (state.position_m - old.position_m).norm();
                prop_assert!(moved_m <= (before.v.max(hand.v) * DT) * 1.2 + 1e-9, "{moved_m} m");
                let turn = wrap_pi(hand.heading_rad - before.heading_rad).abs() / DT;
                prop_assert!(turn * hand.v <= LATERAL_MPS2 * 1.05, "{} m/s2 aside", turn * hand.v);
                prop_assert!(!of.size.aircraft || !hand.backwards, "an aircraft does not go backwards by itself");
                prop_assert!(!hand.backwards || hand.v <= BACKWARDS_MPS + 0.05);
            }
        }
    }
}

/// A silent driver is taken for gone: it stands within the way that usual braking needs, and does not move any more.
#[test]
fn silence_of_a_second_brings_it_to_a_stand() {
    for of in [car(), airliner()] {
        let mut hand = Hand::new(of.clone());
        let now_s = driven(&mut hand, 0.0, 40.0, wish(1000, 0, 0));
        let (v, from) = (hand.v, hand.middle_m());
        assert!((v - of.most_mps).abs() < 0.1, "{v} m/s");
        let mut stood_s = None;
        for k in 1..=1200 {
            hand.step(now_s + DT * f64::from(k), DT);
            if hand.v == 0.0 {
                stood_s.get_or_insert(DT * f64::from(k));
            }
        }
        let (dec, jerk) = (of.acc_dec_mps2.1, JERK_MPS3);
        let needs_s = SILENT_S + v / dec + dec / jerk;
        let took_s = stood_s.expect("it stands");
        assert!((took_s - needs_s).abs() < 1.0, "{took_s} s, {needs_s} s");
        let way_m = (hand.middle_m() - from).norm();
        let needs_m = v * SILENT_S + v * v / (2.0 * dec) + 0.5 * v * dec / jerk;
        assert!((way_m - needs_m).abs() < 0.1 * needs_m + 2.0, "{way_m} m, {needs_m} m");
    }
}

/// All of the brake held stops a car sooner than half of it stops an airliner; the brake rises only while it is held.
#[test]
fn the_brake_is_usual_hard_and_harder() {
    let of = airliner();
    let stops = |brake: i16| {
        let mut hand = Hand::new(of.clone());
        let now_s = driven(&mut hand, 0.0, 40.0, wish(1000, 0, 0));
        let from = hand.middle_m();
        driven(&mut hand, now_s, 30.0, wish(0, brake, 0));
        assert_eq!(hand.v, 0.0);
        (hand.middle_m() - from).norm()
    };
    let (half_m, all_m) = (stops(500), stops(1000));
    // v²/2a of 15.4 m/s: 169 m at 0.7; 1.5 for a second, then 3: about 55 m.
    assert!((160.0..185.0).contains(&half_m), "{half_m} m");
    assert!((45.0..66.0).contains(&all_m), "{all_m} m");
}

/// Wheels held at one angle at walking pace: the point under them runs a circle of radius ℓ / sin β, and is back after one turn.
#[test]
fn held_wheels_draw_a_circle_of_the_wheelbase_over_the_sine() {
    let mut hand = Hand::new(car());
    let mut now_s = driven(&mut hand, 0.0, 10.0, wish(0, 500, 400));
    let steer = 0.4 * MOST_STEER_RAD;
    assert!((hand.steer_rad - steer).abs() < 1e-9, "{}", hand.steer_rad);
    now_s = driven(&mut hand, now_s, 8.0, wish(60, 0, 400));
    let radius_m = hand.of.wheelbase_m / libm::sin(steer);
    let start = hand.nose_m;
    let centre = start
        + Azimuth::from_rad(hand.heading_rad + steer + core::f64::consts::FRAC_PI_2).unit()
            * radius_m;
    let turn_s = core::f64::consts::TAU * radius_m / hand.v;
    let mut gone_s = 0.0;
    while gone_s + DT < turn_s {
        now_s = driven(&mut hand, now_s, DT, wish(60, 0, 400));
        gone_s += DT;
        let apart_m = (hand.nose_m - centre).norm();
        assert!((apart_m - radius_m).abs() < 0.01, "{apart_m} m, {radius_m} m");
    }
    assert!((hand.nose_m - start).norm() < hand.v * DT + 0.02);
}

/// What is said of its motion is what it does: the place a little later is that of speed and acceleration.
#[test]
fn the_state_says_how_it_moves() {
    for of in [car(), airliner()] {
        let mut hand = Hand::new(of);
        let now_s = driven(&mut hand, 0.0, 6.0, wish(500, 0, 300));
        let before = hand.state();
        driven(&mut hand, now_s, DT, wish(500, 0, 300));
        let after = hand.state();
        let reckoned = before.position_m
            + before.velocity_mps * DT
            + before.acceleration_ms2 * (0.5 * DT * DT);
        let apart_m = (after.position_m - reckoned).norm();
        assert!(apart_m < 2e-3, "{apart_m} m");
        let turned = wrap_pi(after.heading_rad - before.heading_rad);
        assert!((turned - before.angular_rate_rads.z * DT).abs() < 2e-3);
        assert!(before.velocity_mps.norm() > 1.0 && before.angular_rate_rads.z > 0.0);
    }
}

/// The way on which it would come to a stand is where it comes to a stand.
#[test]
fn the_stopping_way_is_the_one_that_silence_drives() {
    let mut hand = Hand::new(car());
    let now_s = driven(&mut hand, 0.0, 9.0, wish(700, 0, 150));
    let way = hand.stopping();
    let (after_s, at_m, _) = *way.last().expect("a way");
    let mut then = hand.clone();
    then.taken = false;
    let mut k = 0;
    while then.v > 0.0 {
        k += 1;
        then.step(now_s + DT * f64::from(k), DT);
        assert!(k < 1000);
    }
    assert!((then.middle_m() - at_m).norm() < 3.0, "{} m", (then.middle_m() - at_m).norm());
    assert!((after_s - DT * f64::from(k)).abs() < 0.6);
    assert!(way.windows(2).all(|w| w[0].0 < w[1].0));
}
