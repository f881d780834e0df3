//! What a type of aircraft says of a flight: size, speeds, runs, fuel.

use crate::types::TypeRow;
use models::flight_list::WakeCategory;
use models::traffic::core::{Direction, Flight};
use models::traffic::outline::Size;

/// What a type says of a flight.
pub(crate) fn flight_of(row: &TypeRow) -> Flight {
    let (class, k) = (&row.class, &row.kinematics);
    let usual = runs_where_unknown(&class.designator, row.wake);
    Flight {
        callsign: String::new(),
        size: Size { length_m: class.length_m, span_m: class.span_m, aircraft: class.aircraft },
        direction: Direction::Arrival,
        runway: (0, 0),
        stand: 0,
        time_s: 0.0,
        ctot_s: None,
        turnaround_of: None,
        wake: row.wake.unwrap_or(WakeCategory::Medium).into(),
        taxi_mps: (k.taxi_straight_mps, k.taxi_turn_mps),
        taxi_acc_mps2: (k.taxi_acc_ms2, k.taxi_dec_ms2),
        take_off: (
            k.liftoff_mps.unwrap_or(usual.liftoff_mps),
            row.takeoff_dist_m.unwrap_or(usual.run_m),
        ),
        landing: (
            k.touchdown_mps.unwrap_or(usual.touchdown_mps),
            k.braking_ms2.unwrap_or(usual.braking_mps2),
        ),
        wheelbase_m: wheelbase_m(&class.designator, class.length_m),
        idle_kg_per_s: idle_kg_per_s(&class.designator),
        key: 0,
    }
}

/// Runs of a type where `types.csv` knows none.
struct UsualRuns {
    liftoff_mps: f64,
    run_m: f64,
    touchdown_mps: f64,
    braking_mps2: f64,
}

/// Usual values of manuals, from memory; other light types fly like a light twin, all others like an A320.
fn runs_where_unknown(designator: &str, wake: Option<WakeCategory>) -> UsualRuns {
    let (liftoff_mps, run_m, touchdown_mps, braking_mps2) = match (designator, wake) {
        ("C172", _) => (30.0, 290.0, 28.0, 1.2),
        ("C550", _) => (55.0, 850.0, 54.0, 1.4),
        ("AT75", _) => (56.6, 1100.0, 56.0, 1.3),
        ("DH8D", _) => (62.0, 1100.0, 61.0, 1.4),
        ("E145", _) => (68.0, 1500.0, 66.0, 1.3),
        ("CRJ9", _) => (76.0, 1600.0, 71.0, 1.3),
        (_, Some(WakeCategory::Light)) => (45.0, 600.0, 42.0, 1.2),
        _ => (85.3, 1650.0, 69.4, 1.22),
    };
    UsualRuns { liftoff_mps, run_m, touchdown_mps, braking_mps2 }
}

/// From nose wheel to main gear, m (standard literature, from memory; others 0.37 of the length).
pub(crate) fn wheelbase_m(designator: &str, length_m: f64) -> f64 {
    let known = [
        ("A319", 11.0),
        ("A320", 12.6),
        ("A321", 16.9),
        ("B737", 12.6),
        ("B738", 15.6),
        ("B752", 18.3),
        ("B763", 22.8),
        ("A332", 22.2),
        ("A333", 25.4),
        ("B788", 22.8),
        ("B789", 25.8),
        ("A359", 28.7),
        ("B744", 25.6),
        ("B77W", 31.2),
        ("A388", 31.9),
        ("E190", 13.8),
        ("CRJ9", 17.3),
        ("E145", 14.5),
        ("AT75", 10.8),
        ("DH8D", 13.9),
        ("C550", 5.6),
        ("C172", 1.7),
    ];
    known.iter().find(|k| k.0 == designator).map_or(0.37 * length_m, |k| k.1)
}

/// Fuel of all engines at idle, kg/s (orders of the ICAO databank, from memory).
fn idle_kg_per_s(designator: &str) -> f64 {
    match designator {
        "B752" => 0.36,
        "B763" => 0.40,
        "A332" | "A333" | "A359" => 0.52,
        "B744" => 0.84,
        "B77W" => 0.76,
        "B788" | "B789" => 0.44,
        "A388" => 1.20,
        "E190" => 0.18,
        "CRJ9" | "E145" => 0.12,
        "AT75" | "DH8D" => 0.10,
        "C550" => 0.04,
        // About 5 l of petrol an hour.
        "C172" => 0.001,
        _ => 0.22,
    }
}
