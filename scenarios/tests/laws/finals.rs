//! Finals: alerts where those of two runways cross, as of Zurich's 14 and 16, and how far out arrivals are seen.

use models::control::alert::Change;
use models::control::clearance::Board;
use models::control::layout::{Layout, RunwayAxis};
use models::control::parameters::Parameters;
use models::control::safety_net::{SafetyNet, Scan};
use models::control::situation::{Target, TargetClass};
use models::frames::{Point2, Vector2};
use models::plot::Callsign;
use models::sensors::mlat::ArrivalGeometry;
use models::time::SimTime;
use std::path::Path;

fn target(number: u16, name: &str, at: (f64, f64), v: (f64, f64), second: u32) -> Target {
    Target {
        number,
        callsign: Some(Callsign::new(name)),
        class: TargetClass::Aircraft,
        arriving: false,
        length_m: 38.0,
        position_m: Point2::new(at.0, at.1),
        velocity_mps: Vector2::new(v.0, v.1),
        altitude_m: None,
        last_plot: SimTime::from_s(f64::from(second)),
        first: second == 1,
    }
}

/// Finals of two runways whose lines meet before the thresholds: Zurich's 14 and 16. Whose path crosses the other line is
/// nearest to that for a scan, and does not land there against somebody's roll.
#[test]
fn who_crosses_the_line_of_another_final_is_on_his_own() {
    let (u, n) = (Vector2::new(0.2924, 0.9563), Vector2::new(0.9563, -0.2924));
    let threshold = Point2::new(0.0, -1200.0) + u * 1500.0 + n * 10.0;
    let other = [threshold, threshold + u * 3000.0];
    let own = [Point2::new(0.0, 0.0), Point2::new(0.0, 3000.0)];
    let axes = [
        RunwayAxis::new(["36".into(), "18".into()], own, 45.0, 90.0),
        RunwayAxis::new(["02".into(), "20".into()], other, 45.0, 90.0),
    ];
    let raised = |parameters: Parameters, crosses: bool| {
        let mut net =
            SafetyNet::new(Layout::new(axes.iter().flatten().cloned().collect()), parameters);
        let mut board = Board::default();
        for name in ["ABC1", "XYZ2"] {
            assert!(board.strip(Callsign::new(name)).is_some());
        }
        let mut found = Vec::new();
        for second in 1..=45_u32 {
            let t = f64::from(second);
            let (p, v) = if crosses {
                (Vector2::new(0.0, -1200.0) + u * (70.0 * (t - 30.0)), u * 70.0)
            } else {
                (Vector2::new(0.0, -1200.0 + 70.0 * (t - 30.0)), Vector2::new(0.0, 70.0))
            };
            let targets = [
                target(3, "ABC1", (p.x, p.y), (v.x, v.y), second),
                target(7, "XYZ2", (0.0, 2900.0 - 50.0 * t), (0.0, -50.0), second),
            ];
            let scan = Scan {
                now: SimTime::from_s(t),
                targets: &targets,
                board: &board,
                bars: &[],
                areas: &[],
                low_visibility: false,
            };
            let new = net.scan(&scan).iter().filter(|(c, _)| *c == Change::Raised);
            found.extend(new.map(|(_, a)| a.condition.kind.word()));
        }
        found.iter().any(|k| k == "RMCA_OPP")
    };
    assert!(raised(Parameters::default(), true), "by the definition, for a scan");
    assert!(!raised(Parameters::on_tracks(), true));
    assert!(raised(Parameters::on_tracks(), false), "who does land against a roll");
}

/// The standard multilateration locates who is 40 s of flight at 70 m/s from any threshold: alerts that look 30 s ahead need a
/// track some seconds before. The ring alone is past its limit of dilution (10) at most of these. One has no ground network here.
#[test]
fn standard_multilateration_sees_every_final_before_its_alerts_are_due() {
    for airport in [
        "layout = \"airports/LZIB.apt.dat\"",
        "layout = \"airports/XSYN.apt.dat\"",
        "layout = \"airports/LIMC.apt.dat\"",
        "layout = \"airports/LSZH.apt.dat\"\nground_network = \"airports/LSZH.groundnet.xml\"",
        "layout = \"airports/EHAM.apt.dat\"\nground_network = \"airports/EHAM.groundnet.xml\"",
        "layout = \"airports/EGCC.nodes.csv\"",
    ] {
        let text = format!(
            "[run]\ntitle = \"t\"\nseed = 1\nstart = 2026-01-01T06:00:00Z\nduration_s = 60\n[airport]\n{airport}\n"
        );
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("finals.toml");
        let scene = scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"));
        let layout = &scene.airport.layout;
        let stations = |radius_m: f64| -> Vec<Point2<f64>> {
            let table = scenarios::control::multilateration("MLAT", layout, radius_m);
            let table: toml::Table = table.parse().expect("TOML");
            let stations = table["sensor"][0]["overrides"]["stations"].as_array().expect("places");
            let number = |s: &toml::Value, key| s[key].as_float().expect("a number");
            stations
                .iter()
                .map(|s| Point2::new(number(s, "east_m"), number(s, "north_m")))
                .collect()
        };
        let (all, ring) = (stations(10_000.0), stations(0.0));
        assert_eq!(ring.len(), 8, "{airport}: none beyond the radius");
        let worst = |stations: &[Point2<f64>]| {
            let ends = layout.runways.iter().flat_map(|r| {
                let [one, other] = r.thresholds_m;
                [(one, other), (other, one)]
            });
            let dilution = |(near, far): (Point2<f64>, Point2<f64>)| {
                let at = near + (near - far).normalize() * (40.0 * 70.0);
                ArrivalGeometry::of(stations, at).map_or(f64::INFINITY, |g| g.horizontal())
            };
            ends.map(dilution).fold(0.0, f64::max)
        };
        println!("{airport}: {:.1}, by the ring alone {:.1}", worst(&all), worst(&ring));
        assert!(worst(&all) < 2.0, "{airport}: {}", worst(&all));
        assert!(worst(&ring) > 3.0 * worst(&all), "{airport}: {}", worst(&ring));
    }
}
