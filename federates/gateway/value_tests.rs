//! Courses in all forms that go out.

use super::tests::{on_final, scene};
use super::*;

/// A course just left of north is none of 360°, whoever writes it.
#[test]
fn no_course_is_rounded_up_to_360() {
    for (course_deg, expected) in [(359.999, 0.0), (359.9, 359.9), (0.001, 0.0), (180.0, 180.0_f64)]
    {
        let (flights, mut report) = on_final(1);
        let (east, north) = libm::sincos(f64::to_radians(course_deg));
        for truth in &mut report.truth {
            truth.velocity_mps = [70.0 * east, 70.0 * north, 0.0];
        }
        // One that stands says where its nose points.
        report.truth[1].velocity_mps = [0.0; 3];
        report.truth[1].heading_rad = f64::to_radians(course_deg);
        let board = board::Board::new(&scene(), 1, false);
        board.on_flights(flights);
        board.on_scan(&std::sync::Arc::new(report));
        let aircraft = board.value("aircraft.json").expect("there");
        let states = board.value("states").expect("there");
        let said = [
            &aircraft["aircraft"][0]["track"],
            &aircraft["aircraft"][1]["true_heading"],
            &states["states"][0][10],
            &states["states"][1][10],
        ];
        assert!(said.iter().all(|said| said.as_f64() == Some(expected)), "{course_deg}: {said:?}");
    }
}
