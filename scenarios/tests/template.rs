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
