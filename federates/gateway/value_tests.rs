//! Altitudes and courses in all forms that go out.

use super::tests::{on_final, plot, read, report, scene, track};
use super::*;
use crate::runtime::messages::PlotMessage;
use asterix::{Record, cat011, cat062};

/// The pressure of a scene is that of its field, however high that lies: at the field every altitude by pressure is the height at which
/// the standard atmosphere has it, above it as much more. Within the step of a flight level and what the vapour is.
#[test]
fn altitudes_by_pressure_begin_at_the_pressure_of_the_field() {
    for elevation_m in [0.0, 432.0, 4061.0] {
        let pressure_hpa = 1013.25 * libm::pow(1.0 - 2.255_77e-5 * elevation_m, 5.255_88);
        let mut scene = scene();
        scene.airport.reference.height_m = elevation_m;
        scene.airport.frame = geodesy::LocalFrame::at(scene.airport.reference);
        let notice = WeatherNotice {
            from_ns: 0,
            temperature_k: 288.15,
            vapour_g_per_m3: 0.0,
            pressure_hpa,
            rain_mm_per_h: 0.0,
            visibility_m: f64::INFINITY,
            wind_mps: [0.0; 2],
            film_mm: 0.0,
            cells: Vec::new(),
        };
        let near = |said_m: f64, within_m: f64, what: &str| {
            let off_m = said_m - (elevation_m + 120.0);
            assert!(off_m.abs() < within_m, "{what} at {elevation_m} m: {off_m} m off");
        };
        let mut gateway = Gateway::new(&scene, Choice::default());
        gateway.on_weather(notice.clone());
        let sent = gateway.on_scan(&report(1, vec![track(7, 1_000_000_000)], vec![]));
        let level_m = |r: &Record<'_>| {
            let item = if r.category.number == 62 { &cat062::I136 } else { &cat011::I090 };
            (r.category.number == 62 || r.get(&cat011::I161).is_some())
                .then(|| r.number(item).map(|level| level * 30.48))?
        };
        let levels = read(&sent, level_m);
        assert_eq!(levels.len(), 2, "{levels:?}");
        levels.iter().for_each(|level_m| near(*level_m, 6.0, "a track"));
        // Squitters of what is true, and of what was reported.
        let (flights, mut truth) = on_final(1);
        truth.truth[0].position_m.z = 120.0;
        let told = PlotMessage {
            kind: SensorKind::Adsb,
            identity: "SWR137H".into(),
            altitude_m: Some(120.0),
            velocity_mps: Some([-70.0, 0.0]),
            ..plot(9, 900_000_000)
        };
        let told = report(1, vec![], vec![told]);
        for (origin, scan) in [(adsb::Origin::Truth, truth), (adsb::Origin::Reports, told)] {
            let board = board::Board::new(&scene, 1, false).sending(origin);
            board.on_flights(flights.clone());
            board.on_weather(notice.clone());
            board.on_scan(&std::sync::Arc::new(scan));
            let states = board.value("states").expect("there");
            near(states["states"][0][7].as_f64().expect("in the air"), 3.0, "a squitter");
        }
    }
}

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
