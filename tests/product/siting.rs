//! `seeds site --candidates`: a site behind a building is worse than one with free sight.

use crate::common::{Folder, seeds};
use serde_json::Value;

/// LZIB in two weathers with a hall of 40 m between the aprons and one of the candidates.
fn scene(folder: &Folder) -> String {
    let airports = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/airports");
    let text = format!(
        "[run]\ntitle = \"siting\"\nseed = 1\nstart = 2026-01-01T06:00:00Z\nduration_s = 60\n\
         [airport]\nicao = \"LZIB\"\nlayout = \"{airports}/LZIB.apt.dat\"\n\
         [[traffic]]\nkind = \"generated\"\narrivals_per_h = 1\ndepartures_per_h = 1\nmix = {{ A320 = 1 }}\n\
         [[sensor]]\nkind = \"asde\"\nname = \"tower\"\nparameters = \"ku_asde3\"\n\
         site = {{ east_m = 250, north_m = 250, height_m = 30 }}\n\
         [weather]\ntimeline = [{{ at_s = 0, rain_mm_per_h = 0 }}, {{ at_s = 30, rain_mm_per_h = 16 }}]\n\
         [[building]]\nname = \"hall\"\nheight_m = 40\n\
         footprint = [{{ east_m = -200, north_m = -60 }}, {{ east_m = 200, north_m = -60 }},\n\
         {{ east_m = 200, north_m = -20 }}, {{ east_m = -200, north_m = -20 }}]\n\
         [tracking]\nprofile = \"accurate\"\n"
    );
    let file = folder.file("own.toml");
    std::fs::write(&file, text).expect("a scene");
    file
}

#[test]
fn a_candidate_behind_a_building_ranks_below_one_with_free_sight() {
    let folder = Folder::new("siting");
    let (scene, table, out) = (scene(&folder), folder.file("sites.csv"), folder.file("maps"));
    // The same ground: close to the wall at 15 m, and on the roof behind it at 60 m.
    std::fs::write(&table, "name,east_m,north_m,height_m\nbehind,0,-10,15\nfree,0,-40,60\n")
        .expect("a table");
    let site = |more: &[&str]| {
        let mut command = seeds();
        command.args(["site", &scene, "--step", "100", "--candidates", &table, "-o", &out]);
        command.args(more).output().expect("it runs")
    };
    let done = site(&[]);
    let said = String::from_utf8_lossy(&done.stdout).into_owned();
    assert!(done.status.success(), "{said}{}", String::from_utf8_lossy(&done.stderr));
    let read = |name: &str| std::fs::read_to_string(format!("{out}/{name}")).expect(name);
    let document: Value = serde_json::from_str(&read("candidates.json")).expect("JSON");
    let rows = document["candidates"].as_array().expect("rows");
    let row = |name: &str| rows.iter().find(|r| r["name"] == name).expect(name);
    let number = |name: &str, key: &str| row(name)["worst"][key].as_f64().expect("a number");
    assert_eq!(rows.len(), 3, "the present site is a row");
    assert_eq!(row("present site")["present"], true);
    assert!(row("free")["rank"].as_u64() < row("behind")["rank"].as_u64(), "{said}");
    assert!(number("behind", "shadow_share") > 0.2, "{said}");
    assert!(number("free", "shadow_share") < 0.1, "{said}");
    assert!(number("free", "share_pd") > number("behind", "share_pd") + 0.1, "{said}");
    // Both weathers; the worst of them counts, and more rain does not help.
    for r in rows {
        let by = r["weathers"].as_array().expect("weathers");
        let share = |i: usize| by[i]["share_pd"].as_f64().expect("a share");
        assert_eq!(by.len(), 2);
        assert!(share(1) <= share(0) && r["worst"]["share_pd"] == by[1]["share_pd"]);
    }
    // The table says the same, and the maps are the best candidate's.
    let csv = read("candidates.csv");
    assert_eq!(csv.lines().count(), 4);
    let place = said.find("free").zip(said.find("behind")).expect("both in the table");
    assert!(place.0 < place.1, "{said}");
    assert!(said.contains("maps with tower at free"), "{said}");
    assert!(read("site.json").contains("\"pd\""));
    let picture = std::fs::read(format!("{out}/candidates.png")).expect("a picture");
    assert!(picture.starts_with(b"\x89PNG") && picture.len() > 1000);

    // What a person says wrongly is refused before anything is computed.
    std::fs::write(&table, "name,east_m,north_m\na,0,-100\nb,0,90000\n").expect("a table");
    let refused = site(&[]);
    let error = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(2), "{error}");
    assert!(
        error.contains("sites.csv:3: 'b' is") && error.contains("outside the airport"),
        "{error}"
    );
    let refused = site(&["--sensor", "mast"]);
    assert!(String::from_utf8_lossy(&refused.stderr).contains("radars are tower"));
}
