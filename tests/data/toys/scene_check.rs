//! The toy sensor as a scene says it: placed into the copy beside the tests of `scenarios`.

use models::effects::Tolerance;
use models::plot::SensorKind;
use models::sensors::KINDS;

#[test]
fn a_scene_with_the_toy_sensor_is_read_and_its_limits_are_kept() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("zurich.toml");
    let text = std::fs::read_to_string(&path).expect("zurich");
    let with = |more: &str| {
        let sensor = format!("{text}\n[[sensor]]\nkind = \"camera\"\nname = \"toy\"\n{more}");
        scenarios::load_text(&path, &sensor).map_err(|e| e.to_string())
    };
    let site = "site = { lat_deg = 47.4581, lon_deg = 8.5481 }";
    let scene = with(&format!("{site}\noverrides = {{ range_m = 500 }}")).expect("a camera");
    let last = scene.sensors.last().expect("a sensor");
    assert_eq!(last.kind, SensorKind::of("camera").expect("declared"));
    let settings = last.reported.as_ref().expect("settings");
    assert!(format!("{settings:?}").contains("range_m: 500.0"));
    assert_eq!(settings.sensor(Tolerance::EXACT, 60.0).expect("a sensor").kind(), last.kind);
    assert!(KINDS.iter().any(|d| d.kind.word == "camera"));
    for (more, what) in [
        ("", "site: missing"),
        (&*format!("{site}\noverrides = {{ range_m = 5 }}"), "range_m = 5 is outside 10 ..= 5000"),
        (&*format!("{site}\noverrides = {{ rang_m = 5 }}"), "did you mean `range_m`?"),
        (&*format!("{site}\nequipped = 0.5"), "leave `equipped` out"),
    ] {
        let error = with(more).expect_err(what);
        assert!(error.contains(what), "{error}");
    }
}

#[test]
fn a_scene_that_names_the_toy_rung_is_tracked_by_it() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("zurich.toml");
    let text = std::fs::read_to_string(&path).expect("zurich");
    let text = scenarios::vary::with_key(&text, "tracking.filter", "rolling").expect("a known key");
    let scene = scenarios::load_text(&path, &text).expect("a rung");
    let filter = &scene.tracking.config.filter;
    assert_eq!(filter.rung.declared().about, "constant velocity, one axis at a time");
}
