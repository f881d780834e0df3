//! Tests of forks.

use super::*;

#[test]
fn a_change_of_who_moves_how_is_said_to_move_nobody_in_a_fork() {
    let said = |keys: &[&str]| without_effect(keys.iter().copied());
    let text = said(&["tracking.filter", "control.policy"]).expect("said");
    assert!(text.starts_with("control.policy: ") && text.contains("it changes none"), "{text}");
    let text = said(&["traffic[1].rate", "control.sees", "control.sees"]).expect("said");
    assert!(text.starts_with("control.sees, traffic[1].rate: "), "{text}");
    assert!(text.contains("they change none"), "{text}");
    let real = ["tracking.filter", "sensor[control].enabled", "weather.rain_factor", "controls"];
    assert_eq!(said(&real), None);
}

#[test]
fn the_weather_of_a_fork_is_amended_with_its_cells_and_from_its_own_time_on() {
    let notice = |from_ns: i64, rain: f64| WeatherNotice {
        from_ns,
        rain_mm_per_h: rain,
        visibility_m: f64::INFINITY,
        temperature_k: 288.15,
        pressure_hpa: 1013.25,
        vapour_g_per_m3: 7.5,
        wind_mps: [0.0; 2],
        film_mm: 0.0,
        cells: vec![[1.0, 2.0, 300.0, 4.0 * rain]],
    };
    let (fog, rain) = (
        Amend { visibility_m: Some(500.0), ..Amend::default() },
        Amend { rain_factor: 2.0, visibility_m: Some(500.0), ..Amend::default() },
    );
    let seed = Amend { seed: Some(3), ..rain.clone() };
    let stages = [(15, &fog), (20, &rain), (25, &seed)];
    let told =
        amended(vec![notice(0, 1.0), notice(10, 2.0), notice(20, 3.0), notice(30, 4.0)], &stages);
    let rows: Vec<_> =
        told.iter().map(|w| (w.from_ns, w.rain_mm_per_h, w.cells[0][3], w.visibility_m)).collect();
    let clear = f64::INFINITY;
    assert_eq!(
        rows,
        [
            (0, 1.0, 4.0, clear),
            (10, 2.0, 8.0, clear),
            (15, 2.0, 8.0, 500.0),
            (20, 6.0, 24.0, 500.0),
            (30, 8.0, 32.0, 500.0),
        ],
        "another seed is no other weather"
    );
    assert_eq!(told[4].cells[0][..3], [1.0, 2.0, 300.0]);
    assert!(amended(Vec::new(), &stages).is_empty());
    assert_eq!(amended(vec![notice(0, 1.0)], &[]), [notice(0, 1.0)]);
}

#[test]
fn a_fork_has_a_name_that_says_what_changed() {
    let of = |key: &str, value: &str| default_name(&[(key.to_owned(), value.to_owned())]);
    assert_eq!(of("tracking.filter", "abg"), "filter-abg");
    assert_eq!(of("sensor[ASDE tower].enabled", "false"), "asde-tower-enabled-false");
    assert_eq!(of("a.ö", "ß"), "fork");
    assert_eq!(default_name(&[]), "again");
    assert!(name_of(&of("weather.rain_factor", &"9".repeat(99))).is_ok());
    for bad in ["", "A", "a b", "../x", &"a".repeat(41)] {
        assert!(name_of(bad).is_err(), "{bad}");
    }
    for bad in ["", "a", "=1", "a="] {
        assert!(change_of(bad).is_err(), "{bad}");
    }
}

#[test]
fn a_fork_lasts_a_scan_at_least_and_not_beyond_its_run() {
    // Scans of 20 frames of 50 ms, from 60 s of a run of 120 s.
    let of = |until: u64| span(1200, until, 20, 2400, 0.05);
    for before in [0, 1199, 1200, 1219] {
        let error = of(before).expect_err("refused").to_string();
        assert!(error.contains("begins at 60 s") && error.contains("to 61 s"), "{error}");
    }
    for within in [1220, 2400] {
        assert_eq!(of(within).expect("taken"), None);
    }
    let text = of(2401).expect("taken").expect("a warning");
    assert!(text.contains("--until 120.05: the run ends at 120 s"), "{text}");
}

#[test]
fn a_fork_begins_a_scan_before_the_end_of_its_run_at_the_latest() {
    for (at, end) in [(2400, 2400), (2400, 2419), (2381, 2400), (0, 0), (0, 19)] {
        let error = begins(at, 20, end, 0.05).expect_err("refused").to_string();
        let said = format!("--at {}: the run ends at {} s", at as f64 / 20.0, end as f64 / 20.0);
        assert!(error.starts_with(&said) && error.ends_with("of 1 s"), "{error}");
    }
    for (at, end) in [(2380, 2400), (0, 20), (0, 2400), (2380, 2419)] {
        assert!(begins(at, 20, end, 0.05).is_ok(), "{at} of {end}");
    }
}
