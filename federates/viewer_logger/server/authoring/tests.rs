use super::super::super::Viewer;
use super::super::{Operate, serve};
use super::*;
use serde_json::json;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

/// A folder of its own with a scene that `seeds scene new` would write.
fn new_scene(name: &str) -> (PathBuf, PathBuf) {
    let folder = std::env::temp_dir().join(format!("seeds-author-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join("own.toml");
    let layout = scenarios::template::layout_of("LZIB").expect("it ships");
    let wanted =
        scenarios::template::Wanted { layout, path: path.clone(), minutes: 20.0, per_h: 0.0 };
    let (text, _) = scenarios::template::scene(&wanted).expect("a scene");
    std::fs::write(&path, text).expect("written");
    (folder, path)
}

fn post(port: u16, path: &str, body: &str) -> String {
    let mut stream = std::net::TcpStream::connect(("127.0.0.1", port)).expect("connected");
    write!(
        stream,
        "POST {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nOrigin: http://127.0.0.1:{port}\r\nConnection: close\r\nContent-Length: {}\r\n\r\n{body}",
        body.len()
    )
    .expect("sent");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("an answer");
    answer
}

fn warned(file: &Path) -> usize {
    let text = scenarios::text_of(file).expect("the scene");
    let (scene, found) = scenarios::warnings::check(file, &text).expect("sound");
    found.len() + scene.warnings.len()
}

#[test]
fn a_route_clicked_and_a_sensor_dragged_are_saved_and_checked() {
    let (folder, file) = new_scene("whole");
    let author = Author::of(&file).expect("a scene");
    let page = Page::new(Viewer::new(1 << 16));
    let scene = author.begin(&shown_on(&page));
    assert!(scene["error"].is_null() && page.viewer().detection().is_some(), "{scene}");
    let places = scene["places"].as_array().expect("places");
    let of = |kind: &str| {
        let all = places.iter().filter(move |p| p["kind"] == kind);
        all.map(|p| p["name"].as_str().expect("a name").to_owned()).collect::<Vec<_>>()
    };
    let (stands, holds, runway) = (of("stand"), of("hold"), of("runway"));
    assert!(!stands.is_empty() && !holds.is_empty() && !runway.is_empty(), "{}", places.len());
    let text = scene["text"].as_str().expect("a text").to_owned();
    let acted =
        |act: Value| author.act(&shown_on(&page), serde_json::from_value(act).expect("an act"));
    // The first of these that are connected: stand, hold, runway.
    let tries = holds.iter().flat_map(|hold| runway.iter().map(move |end| (hold, end))).take(300);
    let mut made = None;
    for (hold, end) in tries {
        let answer =
            acted(json!({"text": text, "route": {"via": [stands[0], hold, end], "start_s": 10}}));
        if answer["error"].is_null() {
            made = Some(answer);
            break;
        }
    }
    let answer = made.expect("one stand is connected with a runway by a hold");
    let way = answer["ways"].as_array().expect("ways").iter().find(|w| w["callsign"] == "ROUTE1");
    assert!(way.expect("drawn")["points_m"].as_array().expect("points").len() > 5);
    assert_eq!(answer["saved"], false);
    // Nothing is on disk yet; then the radar goes elsewhere, and both are saved.
    assert!(!scenarios::text_of(&file).expect("it").contains("ROUTE1"));
    let draft = answer["text"].clone();
    let answer = acted(json!({"text": draft, "sensor": ["radar", [-40.0, 75.04]], "save": true}));
    assert_eq!((&answer["error"], &answer["saved"]), (&Value::Null, &json!(true)), "{answer}");
    assert_eq!(answer["sensors"][0]["position_m"], json!([-40.0, 75.0]));
    assert_eq!(warned(&file), 0, "seeds scene check --strict");
    let saved = scenarios::load(&file).expect("it runs");
    let entry = saved.flight_list.entries.iter().find(|e| e.callsign.as_str() == "ROUTE1");
    assert!(entry.is_some_and(|e| !e.runway.is_empty() && e.stand == stands[0]), "{entry:?}");
    let text = scenarios::text_of(&file).expect("it");
    assert!(text.contains("# another number: other draws"), "comments stay");
    // What is not sound is not saved, and says its line; nor is what somebody else wrote over.
    let broken = text.replace("seed = 1 ", "seed = -1 ");
    let answer = acted(json!({"text": broken, "save": true}));
    assert!(answer["error"].as_str().expect("why").contains("own.toml:6: run.seed"), "{answer}");
    std::fs::write(&file, format!("{text}\n# by hand\n")).expect("written");
    let answer = acted(json!({"text": text, "save": true}));
    assert!(answer["error"].as_str().expect("why").contains("by somebody else"), "{answer}");
    assert!(scenarios::text_of(&file).expect("it").ends_with("# by hand\n"));
    for (act, part) in [
        (json!({"text": text, "route": {"via": ["#1"]}}), "two places"),
        (json!({"text": text, "route": {"via": ["nowhere", "#1"]}}), "nowhere"),
        (json!({"text": text, "sensor": ["no", [0.0, 0.0]]}), "no sensor 'no'"),
        (json!({"text": text, "sensor": ["radar", [6e4, 0.0]]}), "airport.radius_m"),
        (json!({"text": "a ="}), "not TOML"),
    ] {
        let error = acted(act)["error"].as_str().unwrap_or_default().to_owned();
        assert!(error.contains(part) && !error.contains('\n'), "{part}: {error}");
    }
    let _ = std::fs::remove_dir_all(&folder);
}

#[test]
fn only_the_author_s_own_page_writes() {
    let (folder, file) = new_scene("served");
    let page = Page::new(Viewer::new(1 << 16));
    let operate: Operate = Box::new(|_, _| (true, String::new()));
    let here = "127.0.0.1:0".parse().expect("an address");
    let server = serve(here, Arc::clone(&page), operate).expect("served");
    let port = server.address().port();
    let text = scenarios::text_of(&file).expect("it");
    let body = json!({"text": text, "save": true}).to_string();
    assert!(body.len() > 1024, "longer than other messages");
    // A page of a run has no author.
    assert!(post(port, "/author/act", &body).starts_with("HTTP/1.1 404"));
    page.let_write(Arc::new(Author::of(&file).expect("a scene")));
    let answer = post(port, "/author/act", &body);
    assert!(answer.starts_with("HTTP/1.1 200") && answer.contains("\"saved\":true"), "{answer}");
    for body in ["", "{}", r#"{"text": 1}"#, r#"{"text": "", "file": "/etc/passwd"}"#] {
        assert!(post(port, "/author/act", body).starts_with("HTTP/1.1 400"), "{body}");
    }
    let long = json!({"text": "#".repeat(MOST_TEXT)}).to_string();
    assert!(post(port, "/author/act", &long).starts_with("HTTP/1.1 413"));
    // Another site in the same browser is none of ours.
    let mut stream = std::net::TcpStream::connect(("127.0.0.1", port)).expect("connected");
    write!(stream, "POST /author/act HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nOrigin: http://evil.example\r\nConnection: close\r\nContent-Length: {}\r\n\r\n{body}", body.len()).expect("sent");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("an answer");
    assert!(answer.starts_with("HTTP/1.1 403"), "{answer}");
    server.stop();
    let _ = std::fs::remove_dir_all(&folder);
}
