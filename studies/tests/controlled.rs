//! Hours that models of controllers clear on tracks: everybody is served, nobody touches anybody, and nothing is raised.

use models::control::alert::Change;
use scenarios::hours::{self, Hour};
use scenarios::{Scene, template, vary};
use studies::clearing::Tower;

/// What `seeds scene new` makes of an airport that ships, with controllers on tracks.
fn scene(airport: &str, movements: f64, seed: u64) -> Scene {
    let path = scenarios::locate("zurich").with_file_name("controlled.toml");
    let layout = template::layout_of(airport).expect("it ships");
    let wanted = template::Wanted { layout, path: path.clone(), minutes: 60.0, per_h: movements };
    let (text, _) = template::scene(&wanted).expect("a scene");
    let text = format!("{text}\n[control]\nsees = \"tracks\"\ncontrollers = \"model\"\n");
    let text = vary::with_key(&text, "run.seed", &seed.to_string()).expect("a seed");
    scenarios::load_text(&path, &text).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn an_hour_cleared_on_tracks_is_served_and_raises_nothing() {
    for (airport, movements, seed) in [("XSYN", 36.0, 51), ("LIMC", 24.0, 52), ("EHAM", 24.0, 53)] {
        let scene = scene(airport, movements, seed);
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        let mut tower = Tower::new(&scene, seed).expect("a tower");
        let looks = Hour { seed, every: 10, drain_s: 2700.0, stopping: 0.0 };
        let mut raised = Vec::new();
        let held =
            hours::hour(behaving, &scene.run, &scene.airport.layout, &looks, |core, frame| {
                core.step(frame);
                let told = tower.frame(core, frame).map(|scan| scan.told).unwrap_or_default();
                let told = told.into_iter().filter(|(change, _)| *change == Change::Raised);
                raised.extend(told.map(|(_, a)| (a.condition.kind.word(), a.subjects())));
            });
        let (name, held) = (format!("{airport}, seed {seed}"), held.expect("with truth"));
        let count = held.core.flights().len();
        assert!(count >= 15, "{name}: {count} flights");
        assert_eq!(held.core.measures_of_served(), count, "{name}");
        assert_eq!(held.core.unexpected_deadlocks(), 0, "{name}");
        for row in ["overlaps", "holds", "runways", "gridlocks"] {
            let row = held.rows.iter().find(|r| r.name == row);
            assert!(row.is_none_or(|r| r.kept), "{name}: {row:?}");
        }
        assert!(raised.is_empty(), "{name}: {raised:?}");
        // Somebody was kept back by what the tower saw, and not all were.
        let (_, kept_back_s) = tower.controllers().cost();
        assert!((1..4000).contains(&kept_back_s), "{name}: {kept_back_s}");
    }
}
