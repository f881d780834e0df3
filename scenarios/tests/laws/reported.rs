//! Sensors that targets carry, and loops, as a scene says them.

use std::path::{Path, PathBuf};

fn zurich() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("zurich.toml")
}

/// The default scene with more sensors behind it.
fn with(sensors: &str) -> Result<scenarios::Scene, String> {
    let text = std::fs::read_to_string(zurich()).expect("the default scene");
    scenarios::load_text(&zurich(), &format!("{text}\n{sensors}")).map_err(|e| e.to_string())
}

#[test]
fn every_kind_and_level_becomes_a_sensor() {
    let site = "site = { lat_deg = 47.4581, lon_deg = 8.5481 }";
    let stations = "stations = [{ lat_deg = 47.4581, lon_deg = 8.5481 }, { lat_deg = 47.4681, \
                    lon_deg = 8.5481, range_m = 5000 }, { lat_deg = 47.4581, lon_deg = 8.5681, \
                    blind = [{ from_deg = 350, to_deg = 10, beyond_m = 100 }] }]";
    for (kind, more) in [
        ("gps", "parameters = \"sps_1995\"\nequipped = 0.5"),
        (
            "gps",
            "overrides = { level = \"constellation\", uere_m = 2.0, satellite_failures = false }",
        ),
        ("gps", "overrides = { level = \"per_satellite\", weighted = true, report_s = 0.1 }"),
        ("gps", "overrides = { coverage = 0.9, coverage_mttr_s = 60, vehicles = false }"),
        ("dgps", site),
        ("dgps", "overrides = { level = \"per_satellite\", correction_s = 5 }"),
        ("adsb", "overrides = { nacp = 9 }"),
        ("mlat", &format!("overrides = {{ {stations} }}")),
        ("loop", &format!("{site}\noverrides = {{ direction_deg = 30 }}")),
        ("loop", &format!("{site}\nparameters = \"single\"\noverrides = {{ direction_deg = 30 }}")),
        ("dynamic", "overrides = { resets = [{ lat_deg = 47.4581, lon_deg = 8.5481 }] }"),
    ] {
        let scene = with(&format!("[[sensor]]\nkind = \"{kind}\"\nname = \"new\"\n{more}"))
            .unwrap_or_else(|e| panic!("{kind} {more}: {e}"));
        let last = scene.sensors.last().expect("a sensor");
        let sensor = last.reported.as_ref().expect(kind);
        let sensor = sensor.sensor(models::effects::Tolerance::EXACT, 600.0).expect(kind);
        assert_eq!((sensor.id(), sensor.kind()), (last.id, last.kind));
    }
    let scene = with("").expect("sound");
    assert!(scene.sensors[0].reported.is_none(), "a radar is none of these");
}

#[test]
fn what_the_model_refuses_is_said_with_its_line() {
    let site = "site = { lat_deg = 47.4581, lon_deg = 8.5481 }";
    for (more, expected) in [
        ("kind = \"gps\"\noverrides = { sigma_north_m = -1 }", "overrides.sigma_north_m"),
        ("kind = \"gps\"\noverrides = { sigma_nort_m = 1 }", "did you mean `sigma_north_m`?"),
        (
            "kind = \"gps\"\noverrides = { level = \"constellation\", sigma_north_m = 1 }",
            "unknown key",
        ),
        ("kind = \"gps\"\noverrides = { coverage = 0 }", "overrides.coverage"),
        ("kind = \"gps\"\nparameters = \"sps_1066\"", "\"sps_2020\""),
        ("kind = \"adsb\"\noverrides = { nacp = 5 }", "nacp = 5 is outside 6 ..= 11"),
        ("kind = \"mlat\"", "overrides.stations: missing"),
        (
            "kind = \"mlat\"\noverrides = { stations = [{ lat_deg = 47.4581, lon_deg = 8.5481 }] }",
            "stations has 1 entries",
        ),
        (
            "kind = \"mlat\"\noverrides = { stations = [{ lat_deg = 47.4581, lon_deg = 8.5481 }, \
             { lat_deg = 47.4581, lon_deg = 8.5481 }, { lat_deg = 47.4581, lon_deg = 8.5481 }] }",
            "stations: all of them in one place or on one line (0.000 m)",
        ),
        (
            "kind = \"mlat\"\noverrides = { stations = [{ lat_deg = 47.4581, lon_deg = 8.5481 }, \
             { lat_deg = 47.4581, lon_deg = 8.5581 }, { lat_deg = 47.4581, lon_deg = 8.5681 }, \
             { lat_deg = 47.4581, lon_deg = 8.5781 }] }",
            "needed is a station at least 10 m off the line",
        ),
        (&format!("kind = \"loop\"\n{site}"), "overrides.direction_deg: missing"),
        (&format!("kind = \"loop\"\n{site}\nequipped = 0.5"), "].equipped"),
        ("kind = \"dgps\"\noverrides = { report_s = 0 }", "report_s = 0 is outside"),
    ] {
        let error = with(&format!("[[sensor]]\nname = \"new\"\n{more}")).expect_err(more);
        assert!(error.contains(expected) && error.lines().count() == 1, "{more}: {error}");
        let line: usize = error.split(':').nth(1).and_then(|n| n.parse().ok()).expect(&error);
        assert!(line > 40, "the line of the new sensor: {error}");
    }
}
