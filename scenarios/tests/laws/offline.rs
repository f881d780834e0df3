//! Sensors by figures that `seeds fit` wrote.

use models::effects::Tolerance;
use models::environment::Weather;
use models::plot::SensorKind;
use models::sensors::{PlotSink, ScanInterval, Sensor, TargetClass, TargetState, Truth};
use models::time::SimTime;
use std::path::{Path, PathBuf};

/// As `seeds fit --out` writes it, without what no scene reads.
const FIGURES: &str = r#"{
  "scene": "zurich", "version": "0.1.0", "fitted_on": [1], "compared_on": [2],
  "sensors": [
    { "name": "ASDE tower", "kind": "asde", "mean_m": [0.5, -0.1], "sigma_m": [1.2, 2.5],
      "correlated_share": 0.4, "tau_s": 8.0, "pd": 0.93, "outage_reports": 1.5, "period_s": 1.0,
      "far_share": 0.01, "samples": 5000, "reach_m": 2500.0 },
    { "name": "GPS", "kind": "gps", "mean_m": [0.0, 0.0], "sigma_m": [3.7, 2.7],
      "correlated_share": 0.95, "tau_s": 300.0, "pd": 1.0, "outage_reports": 1.0, "period_s": 1.0,
      "far_share": 0.0, "samples": 500, "reach_m": null },
    { "name": "MLAT", "refused": "3 reports are too few to fit a sensor; 100 are needed" }
  ]
}"#;

/// The default scene with files beside it, in a folder of its own.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("offline-{name}"));
        std::fs::create_dir_all(&path).expect("a folder for the test");
        Self(path)
    }

    fn file(&self, name: &str, text: &str) {
        std::fs::write(self.0.join(name), text).expect("a file for the test");
    }

    /// The default scene with more sensors behind it, its own files at their places.
    fn load(&self, sensors: &str) -> Result<scenarios::Scene, String> {
        let ships = Path::new(env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(ships.join("zurich.toml")).expect("the default scene");
        let at = |folder: &str| format!("\"{}/{folder}", ships.display());
        let text = text.replace("\"airports/", &at("airports/"));
        let text = text.replace("\"movements/", &at("movements/"));
        scenarios::load_text(&self.0.join("scene.toml"), &format!("{text}\n{sensors}"))
            .map_err(|e| e.to_string())
    }
}

/// A truck that stands 500 m and one that stands 5 km east of the reference point.
struct Trucks(TargetClass);

impl Truth for Trucks {
    fn len(&self) -> usize {
        2
    }
    fn key(&self, index: usize) -> u64 {
        index as u64
    }
    fn class(&self, _: usize) -> &TargetClass {
        &self.0
    }
    fn callsign(&self, _: usize) -> models::plot::Callsign {
        models::plot::Callsign::new("TRUCK")
    }
    fn address(&self, _: usize) -> Option<u32> {
        None
    }
    fn at(&self, index: usize, _: SimTime) -> Option<TargetState> {
        let east_m = if index == 0 { 500.0 } else { 5000.0 };
        Some(TargetState {
            position_m: models::frames::Point3::new(east_m, 0.0, 0.0),
            velocity_mps: models::frames::Vector3::zeros(),
            heading_rad: 0.0,
        })
    }
}

fn play(sensor: &mut dyn Sensor, seconds: u64) -> PlotSink {
    let class = TargetClass {
        designator: "FIRE".into(),
        aircraft: false,
        length_m: 12.0,
        span_m: 3.0,
        height_m: 3.5,
        rcs_m2: 20.0,
        shape: scenarios::shapes::named("truck"),
    };
    let mut sink = PlotSink::default();
    for scan in 1..=seconds {
        let at = |scan: u64| SimTime(scan as i64 * 1_000_000_000);
        let interval = ScanInterval { run_seed: 5, scan, from: at(scan - 1), to: at(scan) };
        sensor.scan(&interval, &Trucks(class.clone()), &Weather::default(), &mut sink);
    }
    sink
}

#[test]
fn a_scene_names_figures_in_place_of_a_model() {
    let folder = Folder::new("sound");
    folder.file("figures.json", FIGURES);
    let site = "site = { lat_deg = 47.4581, lon_deg = 8.5481, height_m = 50 }";
    let scene = folder
        .load(&format!(
            "[[sensor]]\nkind = \"offline\"\nname = \"radar\"\nfigures = \"figures.json\"\n\
             of = \"ASDE tower\"\n{site}\n\
             [[sensor]]\nkind = \"offline\"\nname = \"positions\"\nfigures = \"figures.json\"\n\
             of = \"GPS\""
        ))
        .unwrap_or_else(|e| panic!("{e}"));
    let made = |index: usize| {
        let sensor = scene.sensors[index].reported.as_ref().expect("by figures");
        sensor.sensor(Tolerance::default(), 600.0).expect("sound figures")
    };
    let (mut radar, mut gps) = (made(3), made(4));
    assert_eq!((radar.kind(), gps.kind()), (SensorKind::Asde, SensorKind::Gps));
    assert_eq!(scene.sensors[3].kind, SensorKind::Asde, "it stands for a radar");
    let seen = play(radar.as_mut(), 2000);
    assert!(seen.causes.iter().all(|c| c.key == Some(0)), "5 km is beyond the radar's reach");
    let share = seen.plots.len() as f64 / seen.looks as f64;
    assert!((share - 0.93).abs() < 0.03, "{share}");
    let outward = |(p, c): (&models::plot::Plot, &models::sensors::Cause)| {
        (p.position_m - c.truth_m.expect("a target")).dot(&p.axis)
    };
    let errors = seen.plots.iter().zip(&seen.causes).map(outward);
    let mean_m = errors.sum::<f64>() / seen.plots.len() as f64;
    assert!((mean_m - 0.5).abs() < 0.3, "half a metre away from the radar: {mean_m}");
    assert!(seen.plots.iter().all(|p| p.identity.is_none()), "a radar knows no names");
    let seen = play(gps.as_mut(), 50);
    assert!(seen.plots.len() > 90 && seen.plots.iter().all(|p| p.identity.is_some()));
    let rows: Vec<_> = gps.plan().iter().map(|row| row.effect).collect();
    assert_eq!(rows, ["geometry", "hard failures", "correlated error", "white error"]);

    let only_gps = "[[sensor]]\nkind = \"offline\"\nname = \"positions\"\n\
                    figures = \"figures.json\"\nof = \"GPS\"";
    let before = folder.load(only_gps).expect("sound").hash;
    folder.file("figures.json", &FIGURES.replace("3.7", "3.8"));
    let after = folder.load(only_gps).expect("sound").hash;
    assert_ne!(before, after, "the figures belong to the scene");
}

#[test]
fn what_is_wrong_with_figures_is_said_with_its_line() {
    let folder = Folder::new("wrong");
    folder.file("figures.json", FIGURES);
    folder.file("broken.json", "{ \"sensors\": [");
    folder.file("other.json", "{ \"tracks\": [] }");
    folder.file("short.json", "{ \"sensors\": [{ \"name\": \"GPS\", \"kind\": \"gps\" }] }");
    folder.file("one.json", &FIGURES.replace("\"pd\": 1.0", "\"pd\": 1.7"));
    folder.file("kind.json", &FIGURES.replace("\"gps\"", "\"sonar\""));
    let of_gps = "of = \"GPS\"\nfigures =";
    for (more, expected) in [
        ("name = \"x\"".to_owned(), ".figures: missing; needed is a file that `seeds fit"),
        ("figures = \"none.json\"".into(), "none.json: does not exist; paths count from"),
        ("figures = \".\"".into(), "is not a file"),
        (format!("{of_gps} \"broken.json\""), "is not JSON"),
        (format!("{of_gps} \"other.json\""), "has no list `sensors`"),
        (format!("{of_gps} \"short.json\""), "missing field `mean_m`"),
        (format!("{of_gps} \"one.json\""), "pd = 1.7 is outside 0 ..= 1"),
        (format!("{of_gps} \"kind.json\""), "kind \"sonar\" is not a kind of sensor"),
        ("figures = \"figures.json\"".into(), "one of ASDE tower, GPS, MLAT"),
        (
            "figures = \"figures.json\"\nof = \"DGPS\"".into(),
            "found \"DGPS\", allowed is \"ASDE tower\", \"GPS\", \"MLAT\"",
        ),
        ("figures = \"figures.json\"\nof = \"MLAT\"".into(), "3 reports are too few"),
        ("figures = \"figures.json\"\nof = \"ASDE tower\"".into(), ".site: missing"),
        (format!("parameters = \"sps_2020\"\n{of_gps} \"figures.json\""), ".parameters"),
        (format!("overrides = {{ pd = 1 }}\n{of_gps} \"figures.json\""), ".overrides"),
    ] {
        let name = if more.contains("name =") { "" } else { "name = \"new\"\n" };
        let text = format!("[[sensor]]\nkind = \"offline\"\n{name}{more}");
        let error = folder.load(&text).expect_err(&more);
        assert!(error.contains(expected) && error.lines().count() == 1, "{more}: {error}");
        let line: usize = error.split(':').nth(1).and_then(|n| n.parse().ok()).expect(&error);
        assert!(line > 40, "the line of the new sensor: {error}");
    }
    let error = folder
        .load("[[sensor]]\nkind = \"gps\"\nname = \"new\"\nfigures = \"figures.json\"")
        .expect_err("a model takes no figures");
    assert!(error.contains("for kind = \"offline\" only"), "{error}");
}
