//! Radars and buildings of a scene: sets that ship, overrides, and one line for what is wrong.

use scenarios::{ScenarioError, Scene, load_text};
use std::path::{Path, PathBuf};

fn zurich() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("zurich.toml")
}

fn with(set: &str, overrides: &str, more: &str) -> Result<Scene, ScenarioError> {
    let text = std::fs::read_to_string(zurich()).expect("zurich.toml");
    let from = "parameters = \"ku_asde3\"\n";
    assert!(text.contains(from));
    let to = format!("parameters = \"{set}\"\noverrides = {{ {overrides} }}\n");
    load_text(&zurich(), &format!("{}\n{more}", text.replacen(from, &to, 1)))
}

/// The line of the radar's parameters in zurich.toml; its overrides are in the next.
fn placed(expected: &str) -> String {
    let text = std::fs::read_to_string(zurich()).expect("zurich.toml");
    let at = 1 + text.lines().position(|l| l.starts_with("parameters =")).expect("a radar");
    let (parameters, overrides) = (at.to_string(), (at + 1).to_string());
    expected.replace("PARAMETERS", &parameters).replace("OVERRIDES", &overrides)
}

fn line(result: Result<Scene, ScenarioError>) -> String {
    let line = result.expect_err("an error").to_string();
    line.replace(&format!("{}/", env!("CARGO_MANIFEST_DIR")), "")
}

#[test]
fn every_set_that_ships_is_sound() {
    for (set, carrier) in [("ku_asde3", 16.0), ("x_paper", 9.0), ("x_smr25", 9.0)] {
        let scene = with(set, "", "").unwrap_or_else(|e| panic!("{e}"));
        let radar = scene.sensors[0].asde.as_ref().expect("a radar");
        assert_eq!(radar.parameters.carrier_ghz, carrier);
        assert_eq!(radar.parameters.antenna_height_m, 60.0, "the site's height");
        assert!(radar.warnings.is_empty());
    }
}

#[test]
fn a_soil_beyond_its_published_range_is_a_warning() {
    let scene = with("ku_asde3", "surface = \"wet_ground\"", "").unwrap_or_else(|e| panic!("{e}"));
    let radar = scene.sensors[0].asde.as_ref().expect("a radar");
    assert_eq!(radar.warnings.len(), 1);
    assert!(
        radar.warnings[0].contains(&placed("zurich.toml:OVERRIDES: sensor[1].overrides: surface")),
        "{:?}",
        radar.warnings
    );
}

#[test]
fn what_says_less_than_it_seems_is_a_warning_with_its_place() {
    for (name, overrides, more, parts) in [
        (
            "more gain than its beams have",
            "gain_dbi = 70",
            "",
            ["OVERRIDES: sensor[1].overrides: gain_dbi = 70", "at most 48"],
        ),
        (
            "a skirt that would begin below its end",
            "csc2_limit_deg = 0.5",
            "",
            ["OVERRIDES: sensor[1].overrides: csc2_limit_deg = 0.5", "1.80 degrees"],
        ),
        (
            "a soil beyond its published range",
            "surface = \"wet_ground\"",
            "",
            ["OVERRIDES: sensor[1].overrides: surface", "extrapolated"],
        ),
    ] {
        let scene = with("ku_asde3", overrides, more).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(scene.warnings.len(), 1, "{name}: {:?}", scene.warnings);
        for part in parts {
            assert!(scene.warnings[0].contains(&placed(part)), "{name}: {:?}", scene.warnings);
        }
    }
    let text = std::fs::read_to_string(zurich()).expect("zurich.toml");
    let rain =
        text.lines().position(|l| l.contains("rain_mm_per_h = 16")).expect("rain of 16 mm/h");
    let cell = "cells = [{ east_m = 0, north_m = 0, radius_m = 500, rain_mm_per_h = 2 }], ";
    let drier = text.replacen("rain_mm_per_h = 16", &format!("{cell}rain_mm_per_h = 16"), 1);
    let scene = load_text(&zurich(), &drier).unwrap_or_else(|e| panic!("{e}"));
    let place = format!("zurich.toml:{}: weather.timeline[", rain + 1);
    assert!(scene.warnings[0].contains(&place), "{:?}", scene.warnings);
    assert!(scene.warnings[0].contains("2 mm/h in rain of 16 mm/h"), "{:?}", scene.warnings);
}

#[test]
fn a_footprint_whose_walls_cross_is_refused_and_one_with_an_inner_corner_is_not() {
    let building = |corners: &str| {
        let more = format!("[[building]]\nname = \"b\"\nheight_m = 9\nfootprint = [{corners}]\n");
        with("ku_asde3", "", &more)
    };
    let corner = |(x, y)| format!("{{ east_m = {x}, north_m = {y} }}");
    let list =
        |corners: &[(i32, i32)]| corners.iter().map(|c| corner(*c)).collect::<Vec<_>>().join(", ");
    let crossing = line(building(&list(&[(0, 0), (80, 40), (80, 0), (0, 60)])));
    assert!(crossing.contains("building[1].footprint"), "{crossing}");
    assert!(crossing.contains("corner 1 crosses the one from corner 3"), "{crossing}");
    let inner = building(&list(&[(0, 0), (80, 0), (80, 40), (40, 10), (0, 40)]));
    assert!(inner.is_ok(), "{:?}", inner.err());
}

#[test]
fn wrong_parameters_give_one_line() {
    for (set, overrides, expected) in [
        (
            "ku_asde3",
            "carrier_ghz = 0.5",
            "zurich.toml:OVERRIDES: sensor[1].overrides.carrier_ghz: carrier_ghz = 0.5 is outside 1 ..= 100",
        ),
        (
            "ku_asde3",
            "azimuth_beamwidth_deg = 0",
            "zurich.toml:OVERRIDES: sensor[1].overrides.azimuth_beamwidth_deg: azimuth_beamwidth_deg = 0 is outside 0.01 ..= 30",
        ),
        (
            "ku_asde3",
            "carrier_ghz = 20, surface = \"wet_ground\"",
            "zurich.toml:OVERRIDES: sensor[1].overrides.carrier_ghz: carrier_ghz (for this surface) = 20 is outside 1 ..= 18",
        ),
        (
            "ku_asde3",
            "beamwidth_deg = 1",
            "zurich.toml:OVERRIDES: sensor[1].overrides.beamwidth_deg: unknown key",
        ),
        (
            "ku_asde3",
            "surface = \"ice\"",
            "zurich.toml:OVERRIDES: sensor[1].overrides.surface: found \"ice\", allowed is \"concrete\", \"asphalt\"",
        ),
        (
            "ku_asde3",
            "swerling = 7",
            "zurich.toml:OVERRIDES: sensor[1].overrides.swerling: found 7, allowed is 0 to 4",
        ),
        (
            "ku_asde3",
            "antenna_height_m = -3",
            "zurich.toml:OVERRIDES: sensor[1].overrides.antenna_height_m: antenna_height_m = -3 is outside 1 ..= 500",
        ),
        (
            "ka_band",
            "",
            "zurich.toml:PARAMETERS: sensor[1].parameters: found \"ka_band\", allowed is \"ku_asde3\", \"x_paper\", \"x_smr25\"",
        ),
    ] {
        let found = line(with(set, overrides, ""));
        let expected = placed(expected);
        assert!(found.starts_with(&expected), "{overrides}:\n{found}\n{expected}");
        assert_eq!(found.lines().count(), 1);
    }
}

#[test]
fn buildings_are_read_and_checked() {
    let building = |corners: &str, height: &str| {
        format!(
            "[[building]]\nname = \"hangar\"\nfootprint = [{corners}]\nheight_m = {height}\nfacade = \"metal\"\n"
        )
    };
    let square = "{ east_m = 0, north_m = 0 }, { east_m = 80, north_m = 0 }, { east_m = 80, north_m = 40 }, { east_m = 0, north_m = 40 }";
    let scene = with("ku_asde3", "", &building(square, "25")).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(scene.buildings.len(), 1);
    assert!((scene.buildings[0].area_m2() - 3200.0).abs() < 1e-9);
    assert_eq!(scene.buildings[0].facade.name, "metal");
    let two = "{ east_m = 0, north_m = 0 }, { east_m = 80, north_m = 0 }";
    assert!(
        line(with("ku_asde3", "", &building(two, "25")))
            .contains("found 2, allowed is 3 to 200 corners")
    );
    let high = line(with("ku_asde3", "", &building(square, "900")));
    assert!(high.contains("building[1].height_m: found 900, allowed is 1 to 500 m"), "{high}");
    let around = "{ lat_deg = 47.4535, lon_deg = 8.5565 }, { lat_deg = 47.4542, lon_deg = 8.5565 }, { lat_deg = 47.4542, lon_deg = 8.5574 }, { lat_deg = 47.4535, lon_deg = 8.5574 }";
    let inside = line(with("ku_asde3", "", &building(around, "80")));
    assert!(inside.contains("an antenna at 60 m inside \"hangar\""), "{inside}");
}

#[test]
fn what_no_model_covers_is_refused_with_key_value_and_limits() {
    let original = std::fs::read_to_string(zurich()).expect("zurich.toml");
    let changed = |from: &str, to: &str| {
        assert!(original.contains(from), "{from}");
        line(load_text(&zurich(), &original.replacen(from, to, 1)))
    };
    let rain = "{ at_s = 400, rain_mm_per_h = 16 }";
    let cell = "{ at_s = 400, cells = [{ east_m = 0, north_m = 0, radius_m = 500, rain_mm_per_h = 1001 }] }";
    for (name, found, parts) in [
        (
            "rain",
            changed(rain, "{ at_s = 400, rain_mm_per_h = 1001 }"),
            ["weather.timeline[3].rain_mm_per_h", "1001", "0 to 1000 mm/h"],
        ),
        (
            "less than no rain",
            changed(rain, "{ at_s = 400, rain_mm_per_h = -1 }"),
            ["weather.timeline[3].rain_mm_per_h", "-1", "0 to 1000 mm/h"],
        ),
        (
            "rain of a cell",
            changed(rain, cell),
            ["weather.timeline[3].cells[1].rain_mm_per_h", "1001", "0 to 1000 mm/h"],
        ),
        (
            "tower below ground",
            changed("height_m = 60 }", "height_m = -5 }"),
            ["sensor[1].site.height_m", "-5", "0 to 500 m"],
        ),
        (
            "tower of no height",
            changed("height_m = 60 }", "height_m = 0 }"),
            ["height_m", "= 0", "1 ..= 500"],
        ),
        (
            "ghosts are those of the facades, not a number",
            line(with("ku_asde3", "ghosts = 12", "")),
            ["sensor[1].overrides.ghosts", "unknown key", "allowed here"],
        ),
        (
            "a facade of what has no permittivity",
            line(with(
                "ku_asde3",
                "",
                "[[building]]\nname = \"b\"\nheight_m = 9\nfacade = \"glass\"\nfootprint = [{ east_m = 0, north_m = 0 }, { east_m = 80, north_m = 0 }, { east_m = 80, north_m = 40 }]\n",
            )),
            ["building[1].facade", "\"glass\"", "\"metal\""],
        ),
        (
            "a sum of decibels, which promised nothing",
            changed("detection = 0.01", "detection = 0.01\nsum_db = 0.5"),
            ["accuracy.sum_db", "no longer read", "position_m, tail, detection, false_plots"],
        ),
        (
            "a share of plots above one",
            changed("detection = 0.01", "detection = 0.01\ntail = 1.5"),
            ["accuracy.tail", "1.5", "0 to 1"],
        ),
        (
            "no rotation",
            line(with("ku_asde3", "rotation_rpm = 0", "")),
            ["rotation_rpm", "= 0", "1 ..= 600"],
        ),
        (
            "a number that is none",
            line(with("ku_asde3", "peak_power_w = nan", "")),
            ["peak_power_w", "found NaN", "allowed is a number"],
        ),
    ] {
        assert_eq!(found.lines().count(), 1, "{name}: {found}");
        for part in parts {
            assert!(found.contains(part), "{name}: {part} in\n{found}");
        }
    }
}

#[test]
fn a_scene_says_how_echoes_become_plots() {
    use models::sensors::radar::levels::Processing;
    let text = std::fs::read_to_string(zurich()).expect("zurich.toml");
    let from = "parameters = \"ku_asde3\"\n";
    let with = |more: &str, scan: &str| {
        let text = text.replacen(from, &format!("{from}{more}\n"), 1);
        load_text(&zurich(), &text.replacen("[run]\n", &format!("[run]\n{scan}\n"), 1))
    };
    for (word, expected) in [
        ("", None),
        ("processing = \"auto\"", None),
        ("processing = \"plot\"", Some(Processing::Plot)),
        ("processing = \"cells\"", Some(Processing::Cells)),
        ("processing = \"video\"", Some(Processing::Video)),
    ] {
        let scene = with(word, "").unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(scene.sensors[0].asde.as_ref().expect("a radar").processing, expected);
    }
    for (name, found, parts) in [
        (
            "a level that there is not",
            line(with("processing = \"pixels\"", "")),
            ["sensor[1].processing", "\"pixels\"", "\"auto\", \"plot\", \"cells\", \"video\""],
        ),
        (
            "a video of more than a turn",
            line(with("processing = \"video\"\noverrides = { rotation_rpm = 90 }", "")),
            ["sensor[1].processing", "scans of 1 s", "at most one turn"],
        ),
        (
            "a video of too many cells",
            line(with(
                "processing = \"video\"\noverrides = { azimuth_beamwidth_deg = 0.02, pulse_s = 4e-9 }",
                "",
            )),
            ["sensor[1].processing", "cells a turn", "at most 20000000"],
        ),
        (
            "cells of what has none",
            line(load_text(
                &zurich(),
                &format!(
                    "{text}\n[[sensor]]\nkind = \"adsb\"\nname = \"x\"\nprocessing = \"cells\"\n"
                ),
            )),
            ["processing", "a key of radars", "kind = \"asde\""],
        ),
    ] {
        assert_eq!(found.lines().count(), 1, "{name}: {found}");
        for part in parts {
            assert!(found.contains(part), "{name}: {part} in\n{found}");
        }
    }
}
