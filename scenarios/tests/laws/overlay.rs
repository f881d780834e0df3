//! Overlays of airports: what a file says beside the layout is done, said in the report, and refused where it names nothing.

use models::airport::Hold;
use models::frames::center;
use scenarios::hours::{Hour, hour};
use std::path::{Path, PathBuf};

fn written(name: &str, text: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("seeds-overlay-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join(name);
    std::fs::write(&file, text).expect("a file");
    file
}

fn base() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Bratislava with an overlay and flights by rates.
fn scene(name: &str, overlay: &str) -> Result<scenarios::Scene, String> {
    let file = written(name, overlay);
    let text = format!(
        "[run]\ntitle = \"t\"\nduration_s = 1800\n[airport]\nlayout = \"airports/LZIB.apt.dat\"\noverlay = {:?}\n[[traffic]]\n\
         kind = \"generated\"\narrivals_per_h = 8\ndepartures_per_h = 8\n",
        file.display().to_string()
    );
    scenarios::load_text(&base().join("overlay.toml"), &text).map_err(|e| {
        e.to_string().replace(
            &format!("{}/", file.parent().map_or("".into(), |p| p.display().to_string())),
            "",
        )
    })
}

#[test]
fn each_row_of_an_overlay_does_what_it_says() {
    let plain = scene("plain.toml", "").expect("sound").airport;
    let layout = &plain.layout;
    let far = layout.edges.iter().find(|e| e.name == "F" && !e.runway).expect("F");
    let middle_m = center(&layout.nodes[far.from].position_m, &layout.nodes[far.to].position_m);
    let count = |name: &str| layout.edges.iter().filter(|e| e.name == name).count();
    let text = format!(
        "[[hold]]\neast_m = {}\nnorth_m = {}\n[[hold]]\nnode = \"12006\"\noff = true\n\
         [[edge]]\nbetween = [\"12006\", \"GA_Ramp_14\"]\nname = \"X\"\none_way = true\ncode = \"B\"\n\
         [[taxiway]]\nname = \"D\"\ncode = \"C\"\nwidth_m = 15\n[[stand]]\nname = \"Ramp_20\"\nkind = \"cargo\"\ncode = \"F\"\n\
         heading_deg = 90\n[[closed]]\ntaxiway = \"GG\"\n[[closed]]\nstand = \"GA_Ramp_17\"\n[runways]\narrival = [\"22\"]\ndeparture = [\"13\"]\n",
        middle_m.x, middle_m.y
    );
    let airport = scene("all.toml", &text).unwrap_or_else(|e| panic!("{e}")).airport;
    let changed = &airport.layout;
    let near = |n: &&models::airport::Node| (n.position_m - middle_m).norm() < 0.01;
    let held = changed.nodes.iter().find(near).expect("cut there");
    assert_eq!(held.hold, Hold::Runway);
    assert_eq!(changed.nodes[changed.node("12006").expect("there")].hold, Hold::None);
    let added = changed.edges.iter().position(|e| e.name == "X").expect("added");
    assert!(!changed.edges[added].two_way);
    assert_eq!(changed.details.edges[added].code, Some('B'));
    for (e, edge) in changed.edges.iter().enumerate().filter(|(_, e)| e.name == "D") {
        assert_eq!((edge.width_m, changed.details.edges[e].code), (15.0, Some('C')));
    }
    let s = changed.stands.iter().position(|s| s.name == "Ramp_20").expect("there");
    let detail = &changed.details.stands[s];
    assert_eq!((detail.kind.as_str(), detail.code), ("cargo", Some('F')));
    assert!((changed.stands[s].heading_rad - 90_f64.to_radians()).abs() < 1e-12);
    assert!(count("GG") > 0 && changed.edges.iter().all(|e| e.name != "GG"));
    assert!(layout.stand("GA_Ramp_17").is_some() && changed.stand("GA_Ramp_17").is_none());
    // Details still belong to what they belonged to.
    for (e, edge) in
        layout.edges.iter().enumerate().filter(|(_, e)| !["D", "GG"].contains(&e.name.as_str()))
    {
        let same = |o: &usize| {
            let other = &changed.edges[*o];
            let name = |n: usize| &changed.nodes[n].name;
            *name(other.from) == layout.nodes[edge.from].name
                && *name(other.to) == layout.nodes[edge.to].name
        };
        if let Some(other) = (0..changed.edges.len()).find(same) {
            assert_eq!(
                changed.details.edges[other],
                layout.details.edges.get(e).cloned().unwrap_or_default()
            );
        }
    }
    assert_eq!(changed.details.in_use, [vec!["22".to_owned()], vec!["13".to_owned()]]);
    let said: Vec<&String> =
        airport.report.lines.iter().filter(|l| l.starts_with("overlay: ")).collect();
    assert_eq!(said.len(), 9, "{said:?}");
}

/// A taxiway, and what is closed, may be named by the edge between two nodes; an edge that is added has the width that it is given.
#[test]
fn a_row_may_name_an_edge() {
    let layout = scene("plain-edges.toml", "").expect("sound").airport.layout;
    let between = |e: &models::airport::Edge| {
        [&layout.nodes[e.from].name, &layout.nodes[e.to].name].map(String::clone)
    };
    let open: Vec<_> =
        layout.edges.iter().filter(|e| !e.runway && e.two_way && e.name == "D").collect();
    let [narrow, closed] = [between(open[0]), between(open[1])];
    let text = format!(
        "[[edge]]\nbetween = [\"12006\", \"GA_Ramp_14\"]\nname = \"X\"\nwidth_m = 31\n\
         [[taxiway]]\nedge = {narrow:?}\nwidth_m = 17\none_way = true\n[[closed]]\nedge = {closed:?}\n"
    );
    let changed = scene("edges.toml", &text).unwrap_or_else(|e| panic!("{e}")).airport.layout;
    let of = |names: &[String; 2]| {
        let name = |n: usize| &changed.nodes[n].name;
        let found = changed.edges.iter().find(|e| {
            [name(e.from), name(e.to)] == [&names[0], &names[1]]
                || [name(e.to), name(e.from)] == [&names[0], &names[1]]
        });
        found.map(|e| (e.width_m, e.two_way, name(e.from).clone()))
    };
    assert_eq!(of(&narrow), Some((17.0, false, narrow[0].clone())));
    assert_eq!(of(&closed), None);
    let x = changed.edges.iter().find(|e| e.name == "X").expect("added");
    assert_eq!((x.width_m, x.two_way), (31.0, true));
}

/// Traffic keeps off what is closed, and lands and takes off where the overlay says.
#[test]
fn nobody_drives_over_a_closed_area_and_runways_in_use_are_used() {
    let plain = scene("open.toml", "").expect("sound");
    let served = |scene: &scenarios::Scene| {
        let behaving = scene.traffic.behaving.as_ref().expect("behaves");
        let looks = Hour { seed: 1, every: 20, drain_s: 3600.0, stopping: 0.0 };
        let mut seen = Vec::new();
        let step = &mut |core: &mut models::traffic::core::Core, frame| {
            core.step(frame);
            if frame % 20 == 0 {
                let all = 0..core.flights().len();
                let ground = all.filter_map(|f| core.state(f)).filter(|s| s.position_m.z < 1.0);
                seen.extend(ground.map(|s| s.position_m.xy()));
            }
        };
        let held = hour(behaving, &scene.run, &scene.airport.layout, &looks, step).expect("truth");
        assert_eq!(held.core.measures_of_served(), held.core.flights().len());
        let ends: Vec<String> = held
            .core
            .flights()
            .iter()
            .map(|f| held.core.network().runways[f.runway.0].names[f.runway.1].clone())
            .collect();
        (seen, ends)
    };
    let (seen, _) = served(&plain);
    // A square around an edge of taxiway F that traffic uses when it is open.
    let layout = &plain.airport.layout;
    let squares = layout
        .edges
        .iter()
        .filter(|e| !e.runway && e.name == "D")
        .map(|e| center(&layout.nodes[e.from].position_m, &layout.nodes[e.to].position_m));
    let used =
        |c: &models::frames::Point2<f64>| seen.iter().filter(|p| (**p - c).amax() < 20.0).count();
    let middle = squares.max_by_key(used).expect("D");
    assert!(used(&middle) > 0, "D is used");
    let corner =
        |x: f64, y: f64| format!("{{ east_m = {}, north_m = {} }}", middle.x + x, middle.y + y);
    let text = format!(
        "[[closed]]\narea = [{}, {}, {}, {}]\n[runways]\narrival = [\"31\"]\ndeparture = [\"31\"]\n",
        corner(-20.0, -20.0),
        corner(20.0, -20.0),
        corner(20.0, 20.0),
        corner(-20.0, 20.0)
    );
    let (seen, ends) = served(&scene("closed.toml", &text).unwrap_or_else(|e| panic!("{e}")));
    assert!(
        seen.iter().all(|p| (*p - middle).amax() > 20.0),
        "somebody drove through what is closed"
    );
    assert!(!ends.is_empty() && ends.iter().all(|e| e == "31"), "{ends:?}");
}

#[test]
fn an_overlay_that_names_nothing_is_refused_with_its_line() {
    for (name, text, wanted) in [
        (
            "node.toml",
            "[[hold]]\nnode = \"1200x\"\n",
            "node.toml:2: hold[1].node: found \"1200x\", allowed is one of",
        ),
        ("far.toml", "\n[[hold]]\neast_m = 8000\nnorth_m = 0\n", "far.toml:2"),
        ("taxi.toml", "[[closed]]\ntaxiway = \"ZZ\"\n", "taxi.toml:2"),
        ("both.toml", "[[closed]]\ntaxiway = \"D\"\nstand = \"Ramp_20\"\n", "2 of them"),
        ("corners.toml", "[[closed]]\narea = [{ east_m = 0, north_m = 0 }]\n", "1 corners"),
        ("way.toml", "[[taxiway]]\nname = \"D\"\none_way = true\n", "edge = [from, to]"),
        ("end.toml", "[runways]\narrival = [\"14\"]\n", "end.toml:2"),
        ("two.toml", "[[hold]]\nnode = \"12006\"\neast_m = 0\n", "either node or a place"),
        (
            "way2.toml",
            "[[taxiway]]\nname = \"D\"\nedge = [\"12006\", \"6544\"]\n",
            "either name or edge",
        ),
        ("key.toml", "[[stand]]\nname = \"Ramp_20\"\ncolour = \"red\"\n", "colour"),
        ("table.toml", "[[stands]]\nname = \"Ramp_20\"\n", "stands"),
    ] {
        let said = scene(name, text).err().unwrap_or_else(|| panic!("{name} is taken"));
        assert!(said.contains(wanted), "{name}: {said}");
        assert!(said.lines().count() == 1, "{said}");
    }
    let alone = scenarios::airport::check(&written("alone.toml", "[[closed]]\ntaxiway = \"D\"\n"));
    let said = alone.err().map(|e| e.to_string()).unwrap_or_default();
    assert!(said.contains("an overlay changes a layout"), "{said}");
    // And of `seeds airport check LAYOUT --with FILE`.
    let files = [
        base().join("airports/LZIB.apt.dat"),
        written("with.toml", "[[closed]]\ntaxiway = \"GG\"\n"),
    ];
    let (layout, report) =
        scenarios::airport::check_files(&files, None).unwrap_or_else(|e| panic!("{e}"));
    assert!(layout.edges.iter().all(|e| e.name != "GG"));
    assert!(
        report.lines.iter().any(|l| l.contains("edges and 0 stands closed")),
        "{:?}",
        report.lines
    );
}

/// An overlay that lies beside its layout is taken by `seeds scene new`.
#[test]
fn a_new_scene_takes_the_overlay_that_lies_beside_its_layout() {
    let layout = written(
        "OWN.apt.dat",
        &std::fs::read_to_string(base().join("airports/LZIB.apt.dat")).expect("read"),
    );
    written("OWN.overlay.toml", "[runways]\narrival = [\"22\"]\n");
    let wanted = scenarios::template::Wanted {
        path: layout.with_file_name("own.toml"),
        layout: "OWN.apt.dat".into(),
        per_h: 20.0,
        minutes: 20.0,
    };
    let (text, scene) = scenarios::template::scene(&wanted).unwrap_or_else(|e| panic!("{e}"));
    assert!(text.contains("overlay = \"OWN.overlay.toml\""), "{text}");
    assert_eq!(scene.airport.layout.details.in_use[0], ["22"]);
}
