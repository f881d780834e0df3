//! New scenes of known and of synthetic airports, and what is silly in a scene.

use models::flight_list::MovementKind;
use models::traffic::check::CHECKED_WITHIN_M;
use scenarios::template::{LEFT_OUT, Wanted, layout_of, scene};
use scenarios::warnings::check;
use std::path::{Path, PathBuf};

fn zurich() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("zurich.toml")
}

#[test]
fn a_new_scene_of_every_shipped_airport_is_read_and_nothing_in_it_is_silly() {
    for icao in ["LSZH", "EHAM", "EGCC", "XSYN", "LIMC", "LZIB"] {
        let layout = layout_of(icao).expect(icao);
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("made.toml");
        let wanted = Wanted { layout, path, minutes: 20.0, per_h: 60.0 };
        let (text, made) = scene(&wanted).unwrap_or_else(|e| panic!("{icao}: {e}"));
        assert_eq!(made.sensors.len(), 3, "{icao}");
        // As fine as the check of its traffic wants it.
        assert!(made.run.dead_reckoning.position_m <= CHECKED_WITHIN_M, "{icao}");
        // Flights land and depart; nobody is left with a handful on stands. (60 an hour for 20 minutes, drawn.)
        let of = |m| made.flight_list.entries.iter().filter(|f| f.movement == m).count();
        let (landing, departing) = (of(MovementKind::Arrival), of(MovementKind::Departure));
        assert!(landing + departing >= 8, "{icao}: {landing}, {departing}: {text}");
        let (_, found) = check(&wanted.path, &text).expect("sound");
        assert!(found.is_empty(), "{icao}: {found:?}");
        // A network beside the layout is one.
        assert!(!text.contains("no taxi network"), "{icao}: {text}");
        // What it has in comments, to be driven, is sound as well.
        let (before, car) = text.split_once("# [[traffic]]\n").expect("a car");
        let car: Vec<&str> =
            car.lines().map(|line| line.strip_prefix("# ").unwrap_or(line)).collect();
        let text = format!("{before}[[traffic]]\n{}\n", car.join("\n"));
        let (driven, found) = check(&wanted.path, &text).expect("sound with a car");
        assert!(found.is_empty(), "{icao}: {found:?}");
        assert_eq!(driven.traffic.behaving.as_ref().map(|b| b.driven.len()), Some(1), "{icao}");
    }
    assert_eq!(layout_of("XXXX"), None);
}

/// A file may have any name: what is made of it is read, and says that name.
#[test]
fn a_layout_of_any_name_makes_a_scene_that_is_read() {
    let folder = std::env::temp_dir().join(format!("seeds-names-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("airports/XSYN.apt.dat");
    for name in
        ["the \"old\" one", "back\\slash", "Zürich Flughafen", "it's", "tab\there", "a#b = [c]"]
    {
        let layout = folder.join(format!("{name}.apt.dat"));
        std::fs::copy(&shipped, &layout).expect("copied");
        let wanted = Wanted {
            layout: layout.display().to_string(),
            path: folder.join("made.toml"),
            minutes: 5.0,
            per_h: 10.0,
        };
        let (text, made) = scene(&wanted).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(made.run.title.starts_with(name), "{name}: {text}");
    }
    std::fs::remove_dir_all(&folder).expect("removed");
}

/// A runway and nothing else: who made the file is told why nobody moves in its scene.
#[test]
fn a_scene_of_an_airport_without_ways_says_why_nobody_moves() {
    let folder = std::env::temp_dir().join(format!("seeds-bare-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let layout = folder.join("BARE.apt.dat");
    let bare = "I\n1100 Version\n\n1 100 0 0 BARE Bare\n\
                100 45.00 1 0 0.25 0 2 0 09 47.0 8.0 0 0 2 0 0 0 27 47.0 8.03 0 0 2 0 0 0\n99\n";
    let stand = "1300 47.001 8.01 90.0 gate jets|turboprops A1\n";
    for (text, movers, said) in [
        (bare.to_owned(), 0, ", and nobody stands here: "),
        (bare.replace("99\n", &format!("{stand}99\n")), 1, "take off: "),
    ] {
        std::fs::write(&layout, text).expect("a layout");
        let wanted = Wanted {
            layout: layout.display().to_string(),
            path: folder.join("bare.toml"),
            minutes: 20.0,
            per_h: 30.0,
        };
        let (text, made) = scene(&wanted).expect("a scene");
        assert_eq!(made.traffic.entities.len(), movers, "{text}");
        let why = text.lines().find(|line| line.starts_with(LEFT_OUT)).expect("a reason");
        let (_, reason) = why.split_once(said).unwrap_or_else(|| panic!("{why}"));
        println!("{why}");
        assert!(reason.len() > 10 && !reason.contains(".toml"), "{why}");
        assert!(text.contains("title = \"BARE: nobody moves\"") && !text.contains("-0,"), "{text}");
    }
    std::fs::remove_dir_all(&folder).ok();
}

#[test]
fn what_is_silly_is_said_with_number_line_and_cure_and_can_be_silenced() {
    let text = std::fs::read_to_string(zurich()).expect("zurich");
    let (_, clean) = check(&zurich(), &text).expect("sound");
    assert!(clean.is_empty(), "{clean:?}");
    for (from, to, number, word) in [
        ("seed = 1\n", "seed = 0\n", "W05", "seed"),
        ("duration_s = 600", "duration_s = 600.55", "W06", "duration_s"),
        ("visibility_m = 400", "visibility_m = 20", "W07", "visibility_m"),
        ("start_s = 30\n", "start_s = 900\n", "W02", "start_s"),
    ] {
        assert!(text.contains(from), "{from}");
        let (_, found) = check(&zurich(), &text.replacen(from, to, 1)).expect("legal");
        let one = found
            .iter()
            .find(|w| w.word() == number)
            .unwrap_or_else(|| panic!("{number}: {found:?}"));
        assert!(one.key.ends_with(word), "{one:?}");
        let line = text.lines().nth(one.line - 1).expect("a line");
        assert!(line.contains(word), "{one:?} is not at {line}");
        let silenced = to.trim_end().to_owned() + "  # seeds: allow " + number + "\n";
        if from.ends_with('\n') {
            let (_, found) = check(&zurich(), &text.replacen(from, &silenced, 1)).expect("legal");
            assert!(found.iter().all(|w| w.word() != number), "{found:?}");
        }
    }
    // What another key's value leaves nothing to do.
    let radar = "parameters = \"ku_asde3\"\n";
    for (from, to, words) in [
        ("[tracking]\n", "[tracking]\njoint_limit = 50\n", "association"),
        ("[tracking]\n", "[control]\nconfirm_scans = 2\nsees = \"truth\"\n[tracking]\n", "tracks"),
        (
            "[tracking]\n",
            "[control]\nbar_margin_m = 2\nsees = \"tracks\"\n[tracking]\n",
            "stop_bars",
        ),
        ("[tracking]\n", "[control]\nsequence = \"cps\"\n[tracking]\n", "generated"),
        (radar, "parameters = \"ku_asde3\"\noverrides = { pd = 0.8 }\n", "threshold"),
        (
            radar,
            "parameters = \"ku_asde3\"\noverrides = { polarisation = \"vertical\", axial_ratio_db = 2 }\n",
            "circular",
        ),
    ] {
        assert!(text.contains(from), "{from}");
        let (_, found) = check(&zurich(), &text.replacen(from, to, 1)).expect("legal");
        let idle: Vec<_> = found.iter().filter(|w| w.word() == "W16").collect();
        assert!(
            idle.len() == 1 && idle[0].text.contains(words) && idle[0].line > 0,
            "{to}: {found:?}"
        );
    }
    let (from, both) = ("[tracking]\n", "[tracking]\nassociation = \"joint\"\njoint_limit = 50\n");
    let (_, found) = check(&zurich(), &text.replacen(from, both, 1)).expect("legal");
    assert!(found.iter().all(|w| w.word() != "W16"), "{found:?}");
    let nobody = text.split("[[sensor]]").next().expect("a head");
    let (_, found) = check(&zurich(), nobody).expect("legal");
    assert!(found.iter().any(|w| w.word() == "W09"), "{found:?}");
    let twice = format!(
        "{text}\n{}",
        "[[traffic]]\nkind = \"parked\"\ncallsign = \"A1\"\ntype = \"A320\"\nstand = \"D_16\"\n[[traffic]]\nkind = \"parked\"\ncallsign = \"A2\"\ntype = \"A320\"\nstand = \"D_16\"\n"
    );
    let (_, found) = check(&zurich(), &twice).expect("legal");
    let words: Vec<String> = found.iter().map(|w| w.word()).collect();
    assert_eq!(words, ["W03", "W03", "W01"], "{found:?}");
}

/// Each is said of a scene that has it, at its line, and not of the one that it was made of.
#[test]
fn movers_stands_runways_and_sensors_that_lead_to_nothing_are_said() {
    let text = std::fs::read_to_string(zurich()).expect("zurich");
    let route = |via: &str, start_s: u32| {
        format!(
            "\n[[traffic]]\nkind = \"route\"\ncallsign = \"CAR9\"\ntype = \"FOLLOWME\"\nvia = [{via}]\nstart_s = {start_s}\n"
        )
    };
    let sensor = |more: &str| format!("\n[[sensor]]\nname = \"one more\"\n{more}\n");
    let short = "kind = \"asde\"\nparameters = \"ku_asde3\"\noverrides = { range_max_m = 1500 }\nsite = { east_m = 3500, north_m = 4500, height_m = 20 }";
    for (number, key, silly, sound) in [
        ("W17", "via", route("\"E_19\", \"D_57\"", 590), route("\"E_19\", \"D_57\"", 5)),
        ("W18", "site", sensor(short), sensor(&short.replace("1500", "7400"))),
        (
            "W18",
            "equipped",
            sensor("kind = \"gps\"\nequipped = 0"),
            sensor("kind = \"gps\"\nequipped = 1"),
        ),
        (
            "W19",
            "via",
            route("\"E_19\", \"runway 28\", \"D_57\"", 5),
            route("\"Terminal_A_Gate_48\", \"D_57\"", 5),
        ),
    ] {
        let of = |more: &str| {
            let (_, found) =
                check(&zurich(), &format!("{text}{more}")).unwrap_or_else(|e| panic!("{e}"));
            found.into_iter().filter(|w| w.word() == number).collect::<Vec<_>>()
        };
        let found = of(&silly);
        assert_eq!(found.len(), 1, "{number}: {found:?}");
        let whole = format!("{text}{silly}");
        let line = whole.lines().nth(found[0].line - 1).expect("a line");
        assert!(line.starts_with(key) || line.contains(&format!("{key} =")), "{found:?} at {line}");
        assert!(of(&sound).is_empty(), "{number}: {:?}", of(&sound));
        let silenced = silly.replacen(line, &format!("{line} # seeds: allow {number}"), 1);
        assert!(of(&silenced).is_empty(), "{number} is silenced");
    }
}

/// An A388 on a stand of code B, one that lies on a taxiway, a recording that is too fast for its type, and an arrival after the end.
#[test]
fn stands_and_types_that_do_not_fit_are_said() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fits.toml");
    let text = |traffic: &str| {
        format!(
            "[run]\ntitle = \"t\"\nseed = 3\nstart = 2026-06-01T09:00:00Z\nduration_s = 600\n[airport]\nlayout = \"airports/XSYN.apt.dat\"\n\
             [[sensor]]\nkind = \"gps\"\nname = \"GPS\"\n{traffic}"
        )
    };
    let found = |traffic: &str, number: &str| {
        let text = text(traffic);
        let (_, found) = check(&path, &text).unwrap_or_else(|e| panic!("{e}"));
        let found: Vec<_> = found.into_iter().filter(|w| w.word() == number).collect();
        let line = found.first().map(|w| text.lines().nth(w.line - 1).expect("a line").to_owned());
        (found.len(), line.unwrap_or_default())
    };
    let layout =
        scenarios::airport::check(&path.with_file_name("airports/XSYN.apt.dat")).expect("read").0;
    let code = |letter: char| {
        let codes = layout.stands.iter().zip(&layout.details.stands);
        let found = codes.clone().find(|(_, d)| d.code == Some(letter));
        found.map(|(stand, _)| stand.name.clone())
    };
    let parked = |designator: &str, stand: &str| {
        format!(
            "[[traffic]]\nkind = \"parked\"\ncallsign = \"S1\"\ntype = \"{designator}\"\nstand = \"{stand}\"\n"
        )
    };
    let small = code('C').expect("a stand of code C");
    assert_eq!(found(&parked("A388", &small), "W21").0, 1);
    assert!(found(&parked("A388", &small), "W21").1.starts_with("stand = "));
    assert_eq!(found(&parked("A320", &small), "W21").0, 0);
    let landing = |eta_s: u32| {
        format!(
            "{}flight = {{ movement = \"arrival\", runway = \"09\", stand = \"{small}\", eta_ctd_s = {eta_s} }}\n",
            parked("A320", &small)
        )
    };
    assert_eq!(found(&landing(700), "W17").0, 1);
    assert_eq!(found(&landing(300), "W17").0, 0);
    assert_eq!(found(&landing(300), "W23").0, 0);
    assert_eq!(found(&parked("A320", &small), "W22").0, 0);
}

/// The reader ends at the first error; the rest is found by the tables of keys, and each says its parts.
#[test]
fn all_that_is_wrong_is_said_at_once_by_line_key_found_and_allowed() {
    let text = std::fs::read_to_string(zurich()).expect("zurich");
    let wrong = text
        .replacen("seed = 1\n", "sed = 1\n", 1)
        .replacen("visibility_m = 400", "visibility_m = -4", 1)
        .replacen("type = \"FIRE\"", "type = \"FIRE\"\nspeed_kt = 20\nspeed = 1", 1)
        .replacen("[tracking]\n", "[tracking]\nfilter = \"magic\"\n", 1);
    let first = check(&zurich(), &wrong).expect_err("wrong");
    let all = scenarios::warnings::errors(&zurich(), &wrong, first);
    let lines: Vec<&str> = wrong.lines().collect();
    let said: Vec<(&str, Option<String>, bool)> = all
        .iter()
        .map(|e| (&e.key[..], e.problem.found(), e.problem.allowed().is_some()))
        .collect();
    let (unknown, out) = ((None, true), |found: &str| (Some(found.to_owned()), true));
    for (key, (found, allowed)) in [
        ("run.sed", unknown.clone()),
        ("weather.timeline[2].visibility_m", out("-4")),
        ("traffic[8].speed_kt", unknown.clone()),
        ("traffic[8].speed", unknown),
        ("tracking.filter", out("magic")),
    ] {
        assert!(said.contains(&(key, found, allowed)), "{key}: {said:?}");
        let error = all.iter().find(|e| e.key == key).expect("found");
        let word = key.rsplit('.').next().expect("a word");
        assert!(lines[error.line - 1].contains(word), "{key} is not in line {}", error.line);
    }
    assert_eq!(all.len(), 5, "nothing else: {said:?}");
    // Of a sound scene with one error it is that one.
    let one = text.replacen("seed = 1\n", "sed = 1\n", 1);
    let first = check(&zurich(), &one).expect_err("wrong");
    assert_eq!(scenarios::warnings::errors(&zurich(), &one, first).len(), 1);
}
