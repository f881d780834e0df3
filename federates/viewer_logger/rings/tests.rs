use super::*;
use crate::runtime::messages::{ScanReport, TruthMessage};
use models::frames::Point3;

/// A scan at a time, s, with aircraft that stand where these are, m.
fn scan(at_s: f64, places_m: &[[f64; 3]]) -> Vec<u8> {
    let targets: Vec<_> = places_m.iter().map(|place_m| ("A320", *place_m)).collect();
    scan_of(at_s, &targets)
}

/// The same with targets of these types.
fn scan_of(at_s: f64, targets: &[(&str, [f64; 3])]) -> Vec<u8> {
    let truth = targets.iter().enumerate().map(|(i, &(name, [x, y, z]))| TruthMessage {
        id: [1, 2, 3 + i as u16],
        callsign: format!("TEST{i}"),
        address: None,
        type_designator: name.to_owned(),
        aircraft: name == "A320",
        size_m: [37.6, 34.1],
        position_m: Point3::new(x, y, z),
        velocity_mps: [0.0; 3],
        heading_rad: 0.3,
        ours: true,
        track: None,
    });
    let time_ns = (at_s * 1e9) as i64;
    let truth = truth.collect();
    frame::encode(&ScanReport { scan: at_s as u64, time_ns, truth, ..Default::default() })
}

/// A shipped scene with its first radar and the site of that.
fn scene(name: &str) -> (Scene, u16, Point2<f64>) {
    let scene = scenarios::load_without_truth(&scenarios::locate(name)).expect("shipped");
    let row = scene.sensors.iter().find(|s| s.asde.is_some()).expect("a radar");
    let (sensor, site_m) = (row.id.0, row.site_m.expect("a site").xy());
    (scene, sensor, site_m)
}

struct Told(Value);

impl Told {
    fn of(scene: &Scene, sensor: u16, scan: Vec<u8>) -> Self {
        Self(of(scene, &Asked { sensor, seed: 7, scan }).expect("rings"))
    }

    fn cells(&self) -> &[Value] {
        self.0["cells"].as_array().expect("cells")
    }

    /// The letter of an effect in a cell.
    fn state(&self, cell: usize, effect: &str) -> char {
        let names = self.0["effects"].as_array().expect("names");
        let at = names.iter().position(|name| name == effect).expect("an effect");
        let states = self.cells()[cell]["states"].as_str().expect("letters");
        assert_eq!(states.len(), names.len());
        char::from(states.as_bytes()[at])
    }

    fn edges(&self, cell: usize) -> [f64; 2] {
        [0, 1].map(|i| self.cells()[cell]["ring_m"][i].as_f64().expect("a distance"))
    }
}

/// A place so far from the radar in this direction, degrees from north.
fn at(site_m: Point2<f64>, metres: f64, degrees: f64) -> [f64; 3] {
    let azimuth = degrees.to_radians();
    [site_m.x + metres * libm::sin(azimuth), site_m.y + metres * libm::cos(azimuth), 0.0]
}

#[test]
fn every_target_that_is_displayed_lies_in_its_cell_and_no_other() {
    for name in ["zurich", "asmgcs"] {
        let (scene, sensor, site_m) = scene(name);
        for (metres, degrees, sector) in
            [(230.0, 1.0, 0), (700.0, 100.0, 4), (1_500.0, 191.0, 8), (2_600.0, 359.0, 15)]
        {
            let told = Told::of(&scene, sensor, scan(40.0, &[at(site_m, metres, degrees)]));
            assert_eq!(told.cells().len(), 1, "{name}, {metres} m");
            let [near, far] = told.edges(0);
            assert!(near <= metres && metres <= far && far < 1.5 * near, "{near} to {far}");
            assert_eq!(told.cells()[0]["sector"], sector, "{degrees}");
            assert_eq!(told.cells()[0]["targets"], 1);
            assert_eq!(told.cells()[0]["band_m"], json!([0.0, 0.5]));
            // Its own shape is at work; nothing is there to merge with or to shadow it.
            assert_ne!(told.state(0, "target extent"), 'n');
            assert_eq!(told.state(0, "merging"), 'n');
            assert_eq!(told.state(0, "aircraft shadow"), 'n');
        }
        // Beyond what is displayed there is no plan.
        let reach_m = Told::of(&scene, sensor, scan(40.0, &[])).0["to_m"].as_f64().expect("one");
        let told = Told::of(&scene, sensor, scan(40.0, &[at(site_m, reach_m + 400.0, 10.0)]));
        assert!(told.cells().is_empty());
    }
}

#[test]
fn a_shadow_is_on_where_an_aircraft_stands_before_a_target() {
    let (scene, sensor, site_m) = scene("zurich");
    let near = at(site_m, 900.0, 60.0);
    let behind = at(site_m, 1_300.0, 60.0);
    let aside = at(site_m, 1_300.0, 150.0);
    let cars = [("A320", near), ("FOLLOWME", behind), ("FOLLOWME", aside)];
    let told = Told::of(&scene, sensor, scan_of(40.0, &cars));
    let shadowed: Vec<_> = (0..told.cells().len())
        .filter(|cell| told.state(*cell, "aircraft shadow") == 'e')
        .map(|cell| (told.cells()[cell]["sector"].clone(), told.edges(cell)[0] > 1_000.0))
        .collect();
    assert_eq!(shadowed, [(json!(2), true)], "who stands behind an aircraft");
}

#[test]
fn rain_calls_for_its_effects_from_when_it_comes() {
    let (scene, sensor, site_m) = scene("zurich");
    let wet = scene.weather.iter().find(|n| n.weather.rain_mm_per_h > 0.0).expect("rain");
    let place = at(site_m, 800.0, 40.0);
    let told = |at_s: f64| Told::of(&scene, sensor, scan(at_s, &[place]));
    let begin_s = wet.time.s();
    assert!(begin_s > 2.0, "{begin_s}");
    // The plan of a scan is that of the weather at its begin.
    for (at_s, called_for) in [(1.0, false), (begin_s, false), (begin_s + 2.0, true)] {
        let state = told(at_s).state(0, "rain clutter");
        assert_eq!(state != 'n', called_for, "at {at_s} s: {state}");
    }
}

#[test]
fn what_is_no_radar_or_no_scan_is_refused_with_a_sentence() {
    let (scene, sensor, site_m) = scene("zurich");
    let scan = scan(40.0, &[at(site_m, 900.0, 10.0)]);
    let other = scene.sensors.iter().find(|s| s.asde.is_none()).expect("another").id.0;
    for sensor in [other, 999] {
        let refused = of(&scene, &Asked { sensor, seed: 1, scan: scan.clone() });
        assert!(refused.expect_err("refused").contains("not a radar"));
    }
    let none = of(&scene, &Asked { sensor, seed: 1, scan: b"SEED".to_vec() });
    assert!(none.expect_err("refused").contains("no such scan"));
}
