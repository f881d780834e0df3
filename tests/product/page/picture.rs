//! `seeds picture` draws what the page draws.

use super::*;
use federates::viewer_logger::drawing::view::View;
use federates::viewer_logger::drawing::{Drawing, Shown, png, svg};
use federates::viewer_logger::picture::AirportMap;
use models::track::TrackStatus;

#[test]
fn the_picture_without_a_browser_is_the_page() {
    let Some(mut w) = watch(40) else { return };
    w.browser.eval("document.querySelector('[data-view=targets]').click()");
    w.drawn();
    let view = w.browser.eval("__viewer.view");
    let get = |name: &str| view[name].as_f64().expect("a figure");
    let mut seen = View::new([get("width"), get("height")]);
    let fragment = w.browser.eval("__viewer.state");
    seen.read(fragment.as_str().expect("an address")).expect("read");
    let report = w.demo.scan(40);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/zurich.toml");
    let map = AirportMap::of(&scenarios::load(&file).expect("the scene is sound"));
    let shown =
        Shown { map: &map, scan: &report, trails: &[], weather: None, alerts: &[], caption: "" };
    let drawing = Drawing::of(&shown, &seen);
    assert_eq!(drawing.marks.len(), report.tracks.len(), "every track is in view");
    let tracks = w.browser.eval("__viewer.tracks");
    let labels = w.browser.eval("__viewer.labels.map((l) => l.id)");
    for mark in &drawing.marks {
        let screen = &by(&tracks, "number", &json!(mark.number))["screen"];
        let at = ["x", "y"].map(|k| screen[k].as_f64().expect("pixels"));
        let far = libm::hypot(mark.at[0] - at[0], mark.at[1] - at[1]);
        assert!(far < 1.0, "track {}: {far} px from where the page draws it", mark.number);
        let [red, green, blue] = mark.colour.rgb.map(i64::from);
        let pixel = w.pixel_at(mark.number);
        let apart = (pixel[0] - red).abs() + (pixel[1] - green).abs() + (pixel[2] - blue).abs();
        // A coasting one is hollow and shows the ground in its middle.
        let hollow = report
            .tracks
            .iter()
            .any(|t| t.number == mark.number && t.status == TrackStatus::Coasting);
        assert!(hollow || apart < 60, "track {}: {pixel:?}, not {:?}", mark.number, mark.colour);
        let labelled =
            labels.as_array().expect("labels").contains(&json!(format!("t{}", mark.number)));
        assert!(labelled && !mark.label.is_empty(), "track {} has no label", mark.number);
    }
    let words = w.browser.eval(
        "import('/traffic.js').then(({ labelLines }) => __viewer.tracks.map((t) => [t.number, labelLines(t)]))",
    );
    for line in words.as_array().expect("labels") {
        let mark = drawing.marks.iter().find(|m| json!(m.number) == line[0]).expect("a mark");
        assert_eq!(json!(mark.label), line[1], "the same words");
    }
    let png = png::write(&drawing).expect("a picture");
    assert!(png.starts_with(b"\x89PNG") && png.len() > 10_000);
    assert!(svg::write(&drawing).contains("<title>CAI3208</title>"));
}
