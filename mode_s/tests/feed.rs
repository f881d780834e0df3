//! A target's squitters over time, their framing, and octets of others.

use mode_s::cpr::{self, Span};
use mode_s::{Emitter, Message, ModeSError, Reading, Schedule, Target, beast, read};
use proptest::prelude::*;

fn target(speed_mps: f64, on_ground: bool) -> Target {
    Target {
        emitter: Emitter::aircraft(0x4b_18b8, on_ground),
        callsign: "edw_229".into(),
        category: 0xa3,
        lat_deg: 47.46,
        lon_deg: 8.55,
        pressure_altitude_m: 900.0,
        velocity_mps: [speed_mps, 0.0, if on_ground { 0.0 } else { -3.6 }],
        heading_deg: 200.0,
        on_ground,
        size_m: [37.6, 34.1],
        nac_p: 9,
    }
}

/// Metres between two places that are near each other.
fn apart_m(a: [f64; 2], b: [f64; 2]) -> f64 {
    let north = (a[0] - b[0]).to_radians() * 6_371_000.0;
    let east = (a[1] - b[1]).to_radians() * 6_371_000.0 * libm::cos(a[0].to_radians());
    libm::hypot(north, east)
}

fn ten_seconds(target: &Target) -> Vec<(i64, Reading)> {
    let (mut schedule, mut out) = (Schedule::default(), Vec::new());
    for second in 0..10_i64 {
        let (from_ns, to_ns) = (second * 1_000_000_000, (second + 1) * 1_000_000_000);
        let now = target.after(second as f64);
        for due in schedule.due(&now, from_ns, to_ns).expect("it can be sent") {
            assert!((from_ns..to_ns).contains(&due.time_ns));
            let (emitter, reading) = read(&due.message).expect("sound");
            assert_eq!(emitter.capability, if target.on_ground { 4 } else { 5 });
            assert_eq!(emitter.address, 0x4b_18b8);
            out.push((due.time_ns, reading));
        }
    }
    out
}

fn counts(list: &[(i64, Reading)]) -> [usize; 4] {
    let count = |wanted: fn(&Reading) -> bool| list.iter().filter(|(_, r)| wanted(r)).count();
    [
        count(|r| matches!(r, Reading::Surface { .. } | Reading::Airborne { .. })),
        count(|r| matches!(r, Reading::Velocity { .. })),
        count(|r| matches!(r, Reading::Identification { .. })),
        count(|r| matches!(r, Reading::Status { .. })),
    ]
}

#[test]
fn intervals_follow_the_motion() {
    assert_eq!(counts(&ten_seconds(&target(10.0, true))), [20, 0, 2, 4]);
    assert_eq!(counts(&ten_seconds(&target(0.0, true))), [2, 0, 1, 2]);
    assert_eq!(counts(&ten_seconds(&target(70.0, false))), [20, 20, 2, 4]);
}

#[test]
fn positions_alternate_and_lie_where_the_target_is() {
    for on_ground in [true, false] {
        let target = target(40.0, on_ground);
        let mut expected_odd = false;
        for (time_ns, reading) in ten_seconds(&target) {
            let there = target.after(time_ns as f64 * 1e-9);
            let (report, span) = match reading {
                Reading::Surface { report, track_deg, speed_kt, type_code, .. } => {
                    assert_eq!(
                        (type_code, track_deg, speed_kt),
                        (7, Some(90.0), Some(76.0)),
                        "rounded down"
                    );
                    (report, Span::Surface)
                }
                Reading::Airborne { report, altitude_ft } => {
                    let off_ft = altitude_ft.expect("there") - there.pressure_altitude_m / 0.3048;
                    assert!(off_ft.abs() <= 12.5, "{off_ft}");
                    (report, Span::Airborne)
                }
                Reading::Identification { callsign, category } => {
                    assert_eq!((callsign.as_str(), category), ("EDW229", 0xa3));
                    continue;
                }
                Reading::Status { length_width_code, nac_p, sil, version } => {
                    assert_eq!((nac_p, sil, version), (9, 3, 2));
                    assert_eq!(length_width_code, on_ground.then_some(6));
                    continue;
                }
                _ => continue,
            };
            assert_eq!(report.odd, expected_odd);
            expected_odd = !expected_odd;
            let found = cpr::decode(report, [47.4, 8.5], span);
            let off_m = apart_m(found, [there.lat_deg, there.lon_deg]);
            assert!(off_m <= if on_ground { 0.9 } else { 3.6 }, "{off_m} m");
        }
    }
}

#[test]
fn a_standing_target_says_where_its_nose_points() {
    let list = ten_seconds(&target(0.2, true));
    let Some((_, Reading::Surface { track_deg, movement, .. })) = list.first() else { panic!() };
    assert_eq!((*track_deg, *movement), (Some(199.6875), 4));
}

#[test]
fn a_run_that_begins_again_is_sent_again() {
    let (mut schedule, target) = (Schedule::default(), target(0.0, true));
    let second = 1_000_000_000;
    assert_eq!(schedule.due(&target, 600 * second, 601 * second).expect("sent").len(), 3);
    assert_eq!(schedule.due(&target, 601 * second, 602 * second).expect("sent").len(), 0);
    assert_eq!(schedule.due(&target, 0, second).expect("sent").len(), 3);
}

#[test]
fn what_cannot_be_sent_is_refused_and_changes_nothing() {
    let (mut schedule, mut wrong) = (Schedule::default(), target(10.0, true));
    wrong.lat_deg = f64::NAN;
    let refused = schedule.due(&wrong, 0, 1_000_000_000).expect_err("no number");
    assert_eq!(refused.to_string(), "latitude is NaN; degrees from -90 to 90");
    assert_eq!(schedule, Schedule::default());
}

#[test]
fn damage_is_told_by_the_parity() {
    let sound = Message::from_hex("8cec991128180290739a255e6ac5").expect("sound");
    for bit in 0..112 {
        let mut octets = sound.0;
        octets[bit / 8] ^= 0x80 >> (bit % 8);
        assert!(
            matches!(Message::from_octets(&octets), Err(ModeSError::Parity { .. })),
            "bit {bit}"
        );
    }
    assert_eq!(Message::from_hex("8c"), Err(ModeSError::Length(1)));
    assert!(matches!(Message::from_hex("8cé"), Err(ModeSError::Hex(_))));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    /// Frames come back whole, whatever they hold and however they are cut.
    #[test]
    fn beast_frames_come_back(
        list in proptest::collection::vec((0..1_i64 << 50, any::<[u8; 14]>()), 0..20),
        noise in proptest::collection::vec(0..0x1a_u8, 0..5),
        cut in 1..40_usize,
    ) {
        let mut stream = noise;
        for (time_ns, octets) in &list {
            beast::frame(&mut stream, &Message(*octets), *time_ns);
        }
        let (mut buffer, mut found) = (Vec::new(), Vec::new());
        for piece in stream.chunks(cut) {
            buffer.extend_from_slice(piece);
            found.extend(beast::take(&mut buffer));
            prop_assert!(buffer.len() <= 64);
        }
        let octets: Vec<[u8; 14]> = found.iter().map(|(_, _, octets)| *octets).collect();
        prop_assert_eq!(octets, list.iter().map(|(_, octets)| *octets).collect::<Vec<_>>());
        for ((ticks, signal, _), (time_ns, _)) in found.iter().zip(&list) {
            let exact = i128::from(*time_ns) * 12 / 1000 % (1 << 48);
            prop_assert_eq!((i128::from(*ticks), *signal), (exact, beast::SIGNAL));
        }
    }

    #[test]
    fn any_stream_and_any_message_are_read_or_refused(stream in proptest::collection::vec(any::<u8>(), 0..300)) {
        let mut buffer = stream;
        for (_, _, octets) in beast::take(&mut buffer) {
            if let Ok(message) = Message::from_octets(&octets) {
                read(&message).expect("sound");
            }
        }
        let _ = beast::take(&mut buffer);
    }

    /// Every body with its right parity can be read.
    #[test]
    fn any_body_is_read(body in any::<[u8; 7]>(), address in 0..1_u32 << 24) {
        let message = Message::new(Emitter::aircraft(address, true), body);
        prop_assert_eq!(Message::from_hex(&message.hex()), Ok(message));
        read(&message).expect("sound");
    }
}
