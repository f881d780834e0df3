//! Airport layouts: what is in them is found, damage is mended or refused with its line; never a panic.

use models::airport::Airport;
use scenarios::airport::{LayoutReport, check};
use std::path::{Path, PathBuf};

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("airports").join(name)
}

fn check_text(name: &str, text: &[u8]) -> Result<(Airport, LayoutReport), String> {
    let folder = std::env::temp_dir().join(format!("seeds-airports-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join(name);
    std::fs::write(&file, text).expect("a file");
    let result = check(&file);
    let _ = std::fs::remove_file(&file);
    result.map_err(|e| e.to_string().replace(&format!("{}/", folder.display()), ""))
}

#[test]
fn shipped_layouts_are_read_whole() {
    for (name, runways, nodes, edges, stands, finding) in [
        ("LSZH.apt.dat", 3, 0, 0, 3, "runways 16/34 and 10/28 cross"),
        ("LSZH.groundnet.xml", 0, 325, 380, 35, "no runways in this file"),
        ("LZIB.apt.dat", 2, 181, 209, 33, "runways 13/31 and 04/22 cross"),
        ("EGCC.nodes.csv", 2, 624, 666, 148, ""),
        ("EGCC.osm.json", 2, 0, 0, 54, ""),
        ("EGCC.geojson", 2, 0, 0, 54, ""),
    ] {
        let (layout, report) = check(&shipped(name)).unwrap_or_else(|e| panic!("{e}"));
        let found =
            (layout.runways.len(), layout.nodes.len(), layout.edges.len(), layout.stands.len());
        println!("{name}: {found:?}\n{}\n{}", report.lines.join("\n"), report.findings.join("\n"));
        let wanted = if nodes == 0 && runways == 2 {
            (2, found.1, found.2, stands)
        } else {
            (runways, nodes, edges, stands)
        };
        assert_eq!(found, wanted, "{name}: runways, nodes, edges, stands");
        assert!(found.1 > 0 || runways == 3, "{name}: nodes");
        assert!(
            finding.is_empty() || report.findings.iter().any(|f| f == finding),
            "{name}: {:?}",
            report.findings
        );
    }
}

const NEW_ROWS: &str = "I
1200 Version - data cycle 2024.01

1 433 1 0 XXYY Somewhere \u{fc}ber
1302 city Somewhere
1302 datum_lat 48.1
100 45.00 1 0 0.25 0 2 1 09 48.10000000 011.70000000 0.00 0.00 3 0 0 1 27 48.10000000 011.75000000 300.00 0.00 3 0 0 1
100 45.00 1 0 0.25 0 2 1 18 48.20000000 011.70000000 0.00 0.00 3 0 0 1 36 48.20000000 011.70000000 0.00 0.00 3 0 0 1
110 1 0.25 0.00 apron
111 48.0990 011.7000
112 48.0990 011.7100 48.0992 011.7110
111 48.0980 011.7100
114 48.0980 011.7000 48.0979 011.6990
111 48.0985 011.7050
111 48.0985 011.7060
113 48.0984 011.7060
120 line
111 48.0990 011.7000 51 102
112 48.0991 011.7001 48.0992 011.7002
115 48.0980 011.7100
120 ring
111 48.0990 011.7000
116 48.0980 011.7100 48.0981 011.7101
130 boundary
111 48.0 011.6
111 48.0 011.8
113 48.2 011.8
1300 48.0985 011.7050 90.0 gate jets|props Gate 1
1301 C airline dlh
1300 48.0984 011.7060 -90.0 tie_down all Gate 1
1200
1201 48.0990 011.7000 both 0 A_start
1201 48.0990 011.7050 both 1
1201 48.0990 011.7100 both 2 A_end
1201 48.0990 011.7100 both 2 twice
1201 48.1500 011.7100 both 3 alone
1201 48.1500 011.7110 both 4 alone
1202 0 1 twoway taxiway_E A
1204 departure 09,27
1202 1 2 oneway taxiway_C .
1202 3 4 twoway taxiway
1202 2 9 twoway taxiway B
1202 2 2 twoway taxiway B
1206 0 1 twoway
1400 48.0985 011.7050 90 baggage_train 3 truck
99
";

#[test]
fn rows_of_newer_versions_are_read() {
    let (layout, report) = check_text("new.apt.dat", NEW_ROWS.as_bytes()).expect("sound");
    assert_eq!(layout.icao, "XXYY");
    assert_eq!(layout.runways.len(), 1);
    assert_eq!(layout.pavement.len(), 1, "the hole, lines and the boundary are none");
    assert_eq!(layout.stands.len(), 2);
    assert_eq!(layout.stands[1].name, "Gate_1_2");
    assert_eq!(layout.edges.iter().filter(|e| !e.two_way).count(), 1);
    assert_eq!(
        layout.details.edges[0].zones,
        ["09", "27"],
        "row 1204 belongs to the edge before it"
    );
    assert_eq!(layout.details.edges[0].code, Some('E'));
    assert_eq!(layout.details.stands[0].code, Some('C'));
    assert_eq!((layout.details.roads.len(), layout.details.vehicle_places.len()), (1, 1));
    let all = [report.lines.join("\n"), report.findings.join("\n")].join("\n");
    for expected in [
        "runway 18/36 of no length: left out",
        "node 2 a second time: left out",
        "edge to no node 9: left out",
        "edge from 2 to itself: left out",
        "2 parts of the network without connection",
        "because of one-way edges",
    ] {
        assert!(all.contains(expected), "{expected:?} is not in\n{all}");
    }
}

#[test]
fn other_line_ends_and_letters_are_read() {
    let crlf = NEW_ROWS.replace('\n', "\r\n");
    assert_eq!(check_text("crlf.apt.dat", crlf.as_bytes()).expect("sound").0.runways.len(), 1);
    let latin: Vec<u8> = NEW_ROWS.chars().map(|c| c as u8).collect();
    assert_eq!(check_text("latin.apt.dat", &latin).expect("sound").0.runways.len(), 1);
    let marked = format!("\u{feff}{NEW_ROWS}");
    assert_eq!(check_text("marked.apt.dat", marked.as_bytes()).expect("sound").0.runways.len(), 1);
}

#[test]
fn damaged_layouts_are_refused_with_line_and_reason() {
    for (name, from, to, expected) in [
        (
            "a.apt.dat",
            "1 433",
            "1 high",
            "a.apt.dat:4: elevation: found \"high\", needed is a number",
        ),
        (
            "b.apt.dat",
            "1201 48.0990 011.7050 both 1",
            "1201 98.0 011.7 both 1",
            "b.apt.dat:33: latitude: found 98",
        ),
        (
            "c.apt.dat",
            "oneway taxiway_C",
            "someway taxiway_C",
            "c.apt.dat:40: direction: found \"someway\"",
        ),
        (
            "d.apt.dat",
            "100 45.00 1 0 0.25 0 2 1 09",
            "100 NaN 1 0 0.25 0 2 1 09",
            "d.apt.dat:7: width: found NaN",
        ),
        ("e.apt.dat", "1 433 1 0 XXYY", "17 433 1 0 XXYY", "e.apt.dat:"),
        ("f.xml", "I", "<groundnet><parkingList/></groundnet>", "f.xml:1: groundnet"),
    ] {
        assert!(NEW_ROWS.contains(from), "{from}");
        let text =
            if name.ends_with("xml") { to.to_owned() } else { NEW_ROWS.replacen(from, to, 1) };
        let error = check_text(name, text.as_bytes()).expect_err(name);
        let (file, reason) = expected.split_once(": ").unwrap_or((expected, ""));
        assert!(error.starts_with(file) && error.contains(reason), "{error}\n{expected}");
    }
    assert!(check_text("empty.apt.dat", b"").is_err());
    assert!(check_text("empty.xml", b"").is_err());
    assert!(check(Path::new("no/such.apt.dat")).is_err());
}

/// One line in every so many is struck out, cut short, doubled, or gets a number that cannot be.
#[test]
fn any_line_may_be_damaged() {
    for (name, stride) in [("LZIB.apt.dat", 199), ("LSZH.apt.dat", 59), ("LSZH.groundnet.xml", 101)]
    {
        let text = std::fs::read_to_string(shipped(name)).expect("a layout");
        let lines: Vec<&str> = text.lines().collect();
        for at in (2..lines.len()).step_by(stride) {
            for kind in 0..5 {
                let mut changed: Vec<String> = lines.iter().map(|l| (*l).to_owned()).collect();
                let line = &lines[at];
                changed[at] = match kind {
                    0 => String::new(),
                    1 => line.get(..line.len() / 2).unwrap_or("").into(),
                    2 => format!("{line}\n{line}"),
                    3 => line.replacen(|c: char| c.is_ascii_digit(), "1e309", 1),
                    _ => line.replace(|c: char| c.is_ascii_digit(), "0"),
                };
                if let Err(error) = check_text(name, changed.join("\n").as_bytes()) {
                    assert!(error.starts_with(&format!("{name}:")), "{error}");
                }
            }
        }
    }
}

/// The same extract in both forms: the same network.
#[test]
fn openstreetmap_is_the_same_in_both_forms() {
    let [json, geojson] =
        ["EGCC.osm.json", "EGCC.geojson"].map(|name| check(&shipped(name)).expect(name).0);
    let length = |a: &Airport| {
        let lengths =
            a.edges.iter().map(|e| (a.nodes[e.to].position_m - a.nodes[e.from].position_m).norm());
        lengths.sum::<f64>()
    };
    assert!(
        (length(&json) - length(&geojson)).abs() < 50.0,
        "{} {}",
        length(&json),
        length(&geojson)
    );
    assert_eq!(json.edges.len(), geojson.edges.len());
    let names: Vec<_> = json.runways.iter().map(|r| r.names.join("/")).collect();
    assert!(names.contains(&"05R/23L".to_owned()), "{names:?}");
}

/// An extract with the places inside its ways (Overpass `out geom`), with or without the numbers of their nodes, was "no aeroway".
#[test]
fn openstreetmap_with_the_places_inside_its_ways_is_the_same() {
    use serde_json::{Value, json};
    let text = std::fs::read_to_string(shipped("EGCC.osm.json")).expect("ships");
    let plain: Value = serde_json::from_str(&text).expect("JSON");
    let elements = plain["elements"].as_array().expect("elements");
    let place = |id: &Value| {
        let node = elements.iter().find(|e| e["type"] == "node" && e["id"] == *id).expect("a node");
        json!({ "lat": node["lat"], "lon": node["lon"] })
    };
    let inside = |named: bool| {
        let ways = elements.iter().filter(|e| e["type"] == "way").map(|e| {
            let mut way = e.clone();
            way["geometry"] = e["nodes"].as_array().expect("nodes").iter().map(place).collect();
            if !named {
                way.as_object_mut().expect("a way").remove("nodes");
            }
            way
        });
        let nodes = elements.iter().filter(|e| e["type"] == "node" && e["tags"].is_object());
        json!({ "elements": nodes.cloned().chain(ways).collect::<Vec<_>>() }).to_string()
    };
    let (first, _) = check_text("plain.osm.json", text.as_bytes()).expect("plain");
    let (named, _) = check_text("named.osm.json", inside(true).as_bytes()).expect("named");
    assert_eq!(
        (&named.nodes, &named.edges, &named.stands),
        (&first.nodes, &first.edges, &first.stands)
    );
    let (bare, _) = check_text("bare.osm.json", inside(false).as_bytes()).expect("without numbers");
    assert_eq!(bare.edges.len(), first.edges.len());
    assert_eq!(bare.stands.len(), first.stands.len());
}

/// One-way against its line, a surface of a taxiway and of a runway beside its line, a line mapped twice.
#[test]
fn openstreetmap_lines_are_driven_as_they_say() {
    let at = |id: i64, x: i64, y: i64| {
        format!(
            r#"{{"type":"node","id":{id},"lat":{},"lon":{}}}"#,
            50.0 + y as f64 * 1e-5,
            8.0 + x as f64 * 1e-5
        )
    };
    let way = |id: i64, nodes: &str, tags: &str| {
        format!(r#"{{"type":"way","id":{id},"nodes":[{nodes}],"tags":{{{tags}}}}}"#)
    };
    let mut elements: Vec<String> = (0..8).map(|i| at(i, 400 * (i % 4), 300 * (i / 4))).collect();
    elements.extend([at(8, 0, 10), at(9, 1200, 10), at(10, 1200, -10), at(11, 0, -10)]);
    elements.push(way(1, "0,1,2,3", r#""aeroway":"runway","ref":"09/27""#));
    elements.push(way(2, "11,10,9,8,11", r#""aeroway":"runway","ref":"09/27""#));
    elements.push(way(3, "1,5", r#""aeroway":"taxiway","ref":"A","oneway":"-1""#));
    elements.push(way(4, "2,6", r#""aeroway":"taxiway","ref":"B","oneway":"yes""#));
    elements.push(way(5, "5,6,7", r#""aeroway":"taxiway","ref":"C","oneway":"yes""#));
    elements.push(way(6, "6,5", r#""aeroway":"taxiway","ref":"C","oneway":"yes""#));
    elements.push(way(7, "4,5,6,7,4", r#""aeroway":"taxiway","ref":"C","area":"yes""#));
    let text = format!(r#"{{"elements":[{}]}}"#, elements.join(","));
    let (airport, _) = check_text("drawn.osm.json", text.as_bytes()).expect("an airport");
    let mut edges: Vec<(String, String, bool)> = airport
        .edges
        .iter()
        .map(|e| (airport.nodes[e.from].name.clone(), airport.nodes[e.to].name.clone(), e.two_way))
        .collect();
    edges.sort();
    let of = |a: &str, b: &str, both: bool| (a.to_owned(), b.to_owned(), both);
    let known = [
        of("0", "1", true),
        of("1", "2", true),
        of("2", "3", true),
        of("2", "6", false),
        of("5", "1", false),
        of("5", "6", true),
        of("6", "7", false),
    ];
    assert_eq!(edges, known);
    assert_eq!((airport.runways.len(), airport.pavement.len()), (1, 2));
    let [a, b] = airport.runways[0].ends_m;
    assert!(((b - a).norm() - 860.0).abs() < 10.0, "{}", (b - a).norm());
}

/// A stand is only ever the begin or the end of a way: 333 to B54 at Amsterdam led over X_12.
#[test]
fn no_way_leads_over_a_stand() {
    let (layout, _) = check(&shipped("EHAM.groundnet.xml")).expect("a layout");
    let stands: Vec<usize> = layout.stands.iter().filter_map(|s| s.node).collect();
    let (from, to) = (layout.node("#333").expect("333"), layout.node("B54").expect("B54"));
    let way = models::truth::route::shortest(&layout, from, to).expect("a way");
    let inner = &way.nodes[1..way.nodes.len() - 1];
    assert!(inner.iter().all(|n| !stands.contains(n)), "{:?}", way.nodes);
    assert_eq!(
        models::truth::route::shortest(
            &layout,
            layout.node("#142").expect("142"),
            layout.node("#169").expect("169")
        ),
        None
    );
}

/// An airport that ships is found by its indicator, with the ground network beside it; one that is not there is said so, with those
/// that are, and without the line of a file that nobody has.
#[test]
fn shipped_airports_are_found_by_name() {
    use scenarios::airport::{check_files, files_meant};
    let meant = |name: &str| files_meant(Path::new(name));
    assert_eq!(meant("lszh").len(), 2);
    assert_eq!(meant("EGCC").len(), 1);
    assert_eq!(meant("airports/LZIB.apt.dat").len(), 1);
    let own = shipped("LSZH.apt.dat");
    assert_eq!(files_meant(&own), vec![own.clone()], "a file that is there is meant as it is");
    let (layout, _) = check_files(&meant("LSZH"), None).unwrap_or_else(|e| panic!("{e}"));
    assert!(layout.runways.len() == 3 && layout.nodes.len() > 300);
    let said = check_files(&meant("PARIS"), None).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(said.contains("EGCC, EHAM, LIMC, LSZH, LZIB, XSYN") && !said.contains(":1:"), "{said}");
}

/// A layout with a network of its own, completed by one of another form: what was said of its nodes and stands is not said of others
/// (the network panicked), and its runways stay, with their thresholds.
#[test]
fn a_network_of_any_form_takes_the_place_of_that_of_a_layout() {
    let (own, _) = check(&shipped("LZIB.apt.dat")).expect("a layout");
    for with in ["EGCC.osm.json", "EGCC.geojson", "EGCC.nodes.csv", "EHAM.groundnet.xml"] {
        let files = [shipped("LZIB.apt.dat"), shipped(with)];
        let (both, _) = scenarios::airport::check_files(&files, None).expect(with);
        let d = &both.details;
        assert!(d.joined.iter().all(|e| *e < both.edges.len()), "{with}: edges of others");
        assert!(d.cat3_holds.iter().all(|n| *n < both.nodes.len()), "{with}: holds of others");
        assert!([0, both.edges.len()].contains(&d.edges.len()), "{with}");
        assert!([0, both.stands.len()].contains(&d.stands.len()), "{with}");
        assert_eq!(both.runways, own.runways, "{with}");
    }
}

/// A seaplane base before the airport, a runway written twice, once from its other end, and a heading of more than a turn.
#[test]
fn what_a_file_says_of_others_or_twice_is_no_part_of_an_airport() {
    let text = String::from_utf8_lossy(&std::fs::read(shipped("LZIB.apt.dat")).expect("read"))
        .into_owned();
    let (own, _) = check_text("own.apt.dat", text.as_bytes()).expect("sound");
    let base = "\n17 0 0 0 XHEL Harbour\n14 50.0 10.0 100 1 Tower\n1300 50.0 10.0 0 gate jets Pad\n1201 50.0 10.0 both 7 A\n\n1      436 1 0 LZIB";
    let before = text.replacen("\n1      436 1 0 LZIB", base, 1);
    let (found, _) = check_text("base.apt.dat", before.as_bytes()).expect("sound");
    assert_eq!(found, own, "nothing of the base");
    let runway = "100   45.11   2   1 0.00 1 3 0 31   48.15727749  017.23256243    0.00  246.89 5  2 1 1 13   48.17573051  017.20394636    0.00   29.87 5  0 0 1\n";
    let twice = text.replacen("100   45.11", &format!("{runway}100   45.11"), 1);
    let (found, report) = check_text("twice.apt.dat", twice.as_bytes()).expect("sound");
    assert_eq!(found.runways.len(), own.runways.len());
    assert!(report.lines.iter().any(|l| l.contains("a second time")), "{:?}", report.lines);
}

/// An airport on both sides of 180 degrees lies around its own middle, not around that of the other side of the earth.
#[test]
fn an_airport_on_the_date_line_is_one_place() {
    let end = |name: &str, lon: f64| format!("{name} -17.00000000 {lon:.8} 0.00 0.00 2 0 0 0");
    let text = format!(
        "I\n1000 v\n\n1 10 0 0 XFIJ Line\n100 45.00 1 0 0.25 0 2 1 {} {}\n99\n",
        end("09", 179.995),
        end("27", -179.985)
    );
    let (found, _) = check_text("line.apt.dat", text.as_bytes()).expect("sound");
    let [a, b] = found.runways[0].ends_m;
    assert!(a.coords.norm() < 1200.0 && b.coords.norm() < 1200.0, "{a} {b}");
    assert!(((b - a).norm() - 2129.0).abs() < 10.0, "{}", (b - a).norm());
}
