//! The page in headless Chromium: what it draws, how it is operated, and what it does when things go wrong.
//!
//! Screenshots of every run are left in `target/page` for a person to look at.

#[path = "page/alerts.rs"]
mod alerts;
#[path = "page/browser.rs"]
pub(crate) mod browser;
#[path = "page/demo.rs"]
mod demo;
#[path = "page/drive.rs"]
mod drive;
#[path = "page/looks.rs"]
mod looks;
#[path = "page/panes.rs"]
mod panes;
#[path = "page/picture.rs"]
mod picture;
#[path = "page/seats.rs"]
mod seats;
#[path = "page/wrong.rs"]
mod wrong;

use browser::Browser;
use demo::Demo;
use federates::runtime::life_cycle::Phase;
use federates::runtime::messages::{Command, Operation, ScanReport};
use federates::viewer_logger::Viewer;
use federates::viewer_logger::beside::RungRow;
use federates::viewer_logger::server::{Operate, Page, Server, serve};
use serde_json::{Value, json};
use std::net::SocketAddr;
use std::path::Path;
use std::sync::{Arc, Mutex};

const WINDOW: [u32; 2] = [1280, 800];

/// A served page with `scans` scans of the demo run, and a browser on it; none without Chromium.
struct Watched {
    demo: Demo,
    page: Arc<Page>,
    server: Server,
    commands: Arc<Mutex<Vec<(String, Command)>>>,
    browser: Browser,
}

fn watch(scans: u64) -> Option<Watched> {
    let demo = Demo::load();
    let page = Page::new(Viewer::new(64 << 20));
    page.update(|viewer| {
        demo.begin(viewer);
        (1..=scans).for_each(|n| viewer.on_scan(&demo.scan(n)));
        viewer.on_state(&demo.state(Phase::Running, scans * 20));
    });
    let commands = Arc::default();
    let server = start("127.0.0.1:0".parse().expect("address"), &page, &commands);
    let url = format!("http://{}/", server.address());
    let Some(mut browser) = Browser::open(&url, WINDOW) else {
        skipped();
        return None;
    };
    browser.until(&format!("__viewer.scan === {scans} && __viewer.frames > 2"));
    browser.eval("document.fonts.ready.then(() => true)");
    Some(Watched { demo, page, server, commands, browser })
}

#[expect(clippy::print_stderr, reason = "a skipped test says so")]
fn skipped() {
    eprintln!("skipped: chromium is not installed (./test installs it)");
}

/// Serves the page; commands are noted, and freeze and start change the state that the page is told.
fn start(
    address: SocketAddr,
    page: &Arc<Page>,
    commands: &Arc<Mutex<Vec<(String, Command)>>>,
) -> Server {
    let (feed, noted) = (page.clone(), commands.clone());
    let operate: Operate = Box::new(move |words, command| {
        noted.lock().expect("not poisoned").push((words.to_owned(), command.clone()));
        let demo = Demo::load();
        let (ok, text, phase) = match command {
            Command::Freeze => (true, "FROZEN at frame 800", Phase::Frozen),
            Command::Start => (true, "RUNNING", Phase::Running),
            _ => (false, "refused: this run only freezes and resumes", Phase::Running),
        };
        feed.update(|viewer| {
            if ok {
                viewer.on_state(&demo.state(phase, 800));
            }
            viewer.on_operation(Operation {
                source: "page".to_owned(),
                command: words.to_owned(),
                ok,
                text: text.to_owned(),
                ..Operation::default()
            });
        });
        (ok, text.to_owned())
    });
    serve(address, page.clone(), operate).expect("the page is served")
}

impl Watched {
    /// Asserts that tracks and truth of `report` are what the page has and where it draws them.
    fn assert_shows(&mut self, report: &ScanReport) {
        let tracks = self.browser.eval("__viewer.tracks");
        let view = self.browser.eval("__viewer.view");
        let get = |name: &str| view[name].as_f64().expect("a figure");
        assert_eq!(tracks.as_array().expect("tracks").len(), report.tracks.len());
        for track in &report.tracks {
            let shown = by(&tracks, "number", &json!(track.number));
            assert_eq!(shown["callsign"], track.callsign.as_str());
            assert_near(shown, track.position_m.into());
            let x = get("width") / 2.0 + (track.position_m[0] - get("cx")) * get("scale");
            let y = get("height") / 2.0 - (track.position_m[1] - get("cy")) * get("scale");
            let at =
                [&shown["screen"]["x"], &shown["screen"]["y"]].map(|v| v.as_f64().expect("pixel"));
            assert!(
                (at[0] - x).abs() < 1e-6 && (at[1] - y).abs() < 1e-6,
                "{} at {at:?}",
                track.callsign
            );
        }
        let truth = self.browser.eval("__viewer.truth");
        for entity in &report.truth {
            let shown = by(&truth, "callsign", &json!(entity.callsign));
            assert_near(shown, [entity.position_m[0], entity.position_m[1]]);
        }
    }

    /// Colour of the canvas at a target's symbol: red, green, blue.
    fn pixel_at(&mut self, number: u16) -> Vec<i64> {
        self.drawn();
        let colour = self.browser.eval(&format!(
            "(() => {{ const t = __viewer.tracks.find((t) => t.number === {number}); \
             return [...document.getElementById('map').getContext('2d').getImageData(t.screen.x, t.screen.y, 1, 1).data]; }})()"
        ));
        (0..3).map(|i| colour[i].as_i64().expect("0 to 255")).collect()
    }

    /// Waits for the next drawing.
    fn drawn(&mut self) {
        self.browser.eval(
            "new Promise((done) => { const look = () => __viewer.busy ? requestAnimationFrame(look) : requestAnimationFrame(() => done(1)); \
             requestAnimationFrame(() => requestAnimationFrame(look)); })",
        );
    }

    fn keep_screenshot(&mut self, name: &str) {
        self.drawn();
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/page");
        std::fs::create_dir_all(&folder).expect("target/page");
        std::fs::write(folder.join(format!("{name}.png")), self.browser.screenshot())
            .expect("written");
    }

    fn assert_no_complaint(&mut self) {
        assert!(self.browser.complaints.is_empty(), "{:#?}", self.browser.complaints);
    }
}

/// Equal but for the last digit, which JSON on its way here may change.
fn assert_near(shown: &Value, position_m: [f64; 2]) {
    for (name, metres) in ["x", "y"].into_iter().zip(position_m) {
        let far = (shown[name].as_f64().expect("metres") - metres).abs();
        assert!(far < 1e-9, "{name}: {shown}, not {metres}");
    }
}

fn by<'a>(list: &'a Value, key: &str, value: &Value) -> &'a Value {
    let found = list.as_array().expect("a list").iter().find(|item| item[key] == *value);
    found.unwrap_or_else(|| panic!("no {key} {value} on the page"))
}

#[test]
fn targets_are_drawn_where_the_server_says_and_listed_in_the_table() {
    let Some(mut w) = watch(40) else { return };
    w.assert_shows(&w.demo.scan(40));
    // The pixels, not only the figures: the symbol of an arrival is amber, of a departure blue.
    for (number, colour) in [(1, [240, 195, 106]), (6, [132, 197, 244])] {
        let pixel = w.pixel_at(number);
        let far = pixel.iter().zip(colour).map(|(a, b)| (a - b).abs()).max().expect("three");
        assert!(far < 40, "track {number} is drawn in {pixel:?}");
    }
    let rows = w.browser.eval(
        "[...document.querySelectorAll('#tracks tbody tr')].map((r) => [...r.cells].map((c) => c.textContent))",
    );
    let report = w.demo.scan(40);
    let rows = rows.as_array().expect("rows");
    assert_eq!(rows.len(), report.tracks.len());
    for track in &report.tracks {
        let row = rows.iter().find(|r| r[0] == track.callsign.as_str()).expect("a row");
        assert_eq!(row[1], track.number.to_string());
        let error_m = report
            .truth
            .iter()
            .find_map(|t| t.track.filter(|p| p.0 == track.number))
            .expect("error")
            .1;
        assert_eq!(row[5], format!("{error_m:.1}"), "{}", track.callsign);
    }
    // Sorting by speed, downwards.
    w.browser.click_on("#tracks th[data-key=speed] button");
    w.browser.click_on("#tracks th[data-key=speed] button");
    let first = w.browser.eval("document.querySelector('#tracks tbody tr').cells[0].textContent");
    assert_eq!(first, "EDW229", "the landing aircraft is the fastest");
    // Zoom and pan by keys keep the figures and the drawing together.
    for key in ["+", "+", "ArrowLeft"] {
        w.browser.key(key);
    }
    w.drawn();
    w.assert_shows(&w.demo.scan(40));
    let frozen = w.browser.eval(
        "Object.isFrozen(__viewer) && (() => { try { 'use strict'; __viewer.selected = 't1'; } catch { } \
         window.__viewer = 5; return __viewer.selected === null && Object.isFrozen(__viewer.tracks); })()",
    );
    assert_eq!(frozen, true, "the hook is read-only");
    w.assert_no_complaint();
}

#[test]
fn labels_never_overlap_and_keep_their_places() {
    let Some(mut w) = watch(1) else { return };
    let mut before: Option<Value> = None;
    let mut turned = 0;
    for n in 2..=40 {
        let report = w.demo.scan(n);
        w.page.update(|viewer| viewer.on_scan(&report));
        w.browser.until(&format!("__viewer.scan === {n}"));
        w.drawn();
        let overlaps = w.browser.eval(
            "(() => { const l = __viewer.labels.map((l) => ({ id: l.id, ...l.box })), o = []; for (let i = 0; i < l.length; i++) for (let j = 0; j < i; j++) \
             if (l[i].x < l[j].x + l[j].w && l[j].x < l[i].x + l[i].w && l[i].y < l[j].y + l[j].h && l[j].y < l[i].y + l[i].h) \
             o.push([l[i].id, l[j].id]); return o; })()",
        );
        assert_eq!(overlaps, json!([]), "scan {n}");
        let places = w.browser.eval(
            "Object.fromEntries(__viewer.labels.map((l) => { const t = __viewer.tracks.find((t) => t.id === l.id) ?? \
             __viewer.truth.find((t) => t.id === l.id); return [l.id, [l.box.x + l.box.w / 2 - t.screen.x, l.box.y + l.box.h / 2 - t.screen.y]]; }))",
        );
        assert_eq!(
            places.as_object().expect("labels").len(),
            report.truth.len(),
            "every target has one"
        );
        if let Some(before) = &before {
            for (id, place) in places.as_object().expect("labels") {
                let Some(last) = before.get(id) else { continue };
                let moved =
                    |k: usize| place[k].as_f64().expect("px") - last[k].as_f64().expect("px");
                turned += u32::from(libm::hypot(moved(0), moved(1)) > 25.0);
            }
        }
        before = Some(places);
    }
    // 8 labels over 38 steps: now and then one has to make room, or to leave a runway that its target comes to.
    assert!(turned <= 15, "{turned} labels jumped");
    // The placement alone, in a crowd: 300 targets in a window.
    let crowd = w.browser.eval(
        "import('/labels.js').then(({ place, overlap, crosses, cuts }) => { \
           const items = Array.from({ length: 300 }, (_, i) => ({ id: `t${i}`, x: 40 + (i * 7919) % 1200, y: 30 + (i * 104729) % 740, \
             importance: i % 7, level: 3, sizes: { 1: { w: 60, h: 19 }, 2: { w: 84, h: 32 }, 3: { w: 84, h: 45 } } })); \
           const t0 = performance.now(); const placed = [...place(items, { view: { x: 0, y: 0, w: 1280, h: 800 } }).values()]; \
           let overlaps = 0, crossing = 0; const line = (p) => [p.item.x, p.item.y, p.ax, p.ay], long = (p) => Math.hypot(p.ax - p.item.x, p.ay - p.item.y) >= 14; \
           placed.forEach((a, i) => placed.slice(i + 1).forEach((b) => { overlaps += overlap(a, b) ? 1 : 0; \
             crossing += (long(a) && long(b) && crosses(...line(a), ...line(b))) || (long(a) && cuts(...line(a), b)) || (long(b) && cuts(...line(b), a)) ? 1 : 0; })); \
           return { placed: placed.length, overlaps, crossing, outside: placed.filter((p) => p.x < 0 || p.y < 0 || p.x + p.w > 1280 || p.y + p.h > 800).length, \
             ms: performance.now() - t0 }; })",
    );
    assert_eq!((&crowd["overlaps"], &crowd["outside"]), (&json!(0), &json!(0)), "{crowd}");
    assert!(crowd["placed"].as_u64().expect("number") >= 200, "{crowd}");
    let crossing = crowd["crossing"].as_u64().expect("number");
    assert!(50 * crossing <= crowd["placed"].as_u64().expect("number"), "{crowd}");
    w.assert_no_complaint();
}

#[test]
fn the_run_is_operated_and_looked_back_on_from_the_page() {
    let Some(mut w) = watch(40) else { return };
    // Select on the map: the table and the curve follow.
    pick(&mut w, 2);
    let row = w
        .browser
        .eval("document.querySelector('#tracks tr[aria-selected=true]').cells[0].textContent");
    assert_eq!(row, "CAI3208");
    let curve = w.browser.eval("__viewer.curve");
    let curve = curve.as_array().expect("points");
    let report = |n: u64| w.demo.scan(n).truth.iter().find_map(|t| t.track.filter(|p| p.0 == 2));
    assert_eq!(curve.len(), 40);
    for (point, n) in curve.iter().zip(1..) {
        let error_m = report(n).expect("tracked").1;
        assert!(
            (point["error_m"].as_f64().expect("error") - error_m).abs() < 1e-5,
            "scan {n}: {point}"
        );
    }
    w.keep_screenshot("selected-1280");

    // Layers: without the layer nothing of the track is drawn.
    let with = w.pixel_at(6);
    w.browser.click_on("#layer-tracks");
    w.browser.click_on("#layer-labels");
    w.browser.click_on("#layer-truth");
    w.browser.click_on("#sensor-1");
    w.drawn();
    assert_ne!(w.pixel_at(6), with);
    assert_eq!(w.browser.eval("[__viewer.layers.tracks, __viewer.labels.length, __viewer.plots.some((p) => p.sensor === 1 && p.shown)]"), json!([false, 0, false]));
    for layer in ["layer-tracks", "layer-labels", "layer-truth", "sensor-1"] {
        w.browser.click_on(&format!("#{layer}"));
    }
    w.drawn();
    assert_eq!(w.pixel_at(6), with);

    // Freeze and a refused command: each is answered in words.
    w.browser.click_on("[data-command=freeze]");
    w.browser.until("__viewer.phase === 'FROZEN' && __viewer.answer?.accepted");
    assert_eq!(
        w.browser.eval("document.getElementById('answer').textContent"),
        "FROZEN at frame 800"
    );
    w.browser.click_on("[data-command=stop]");
    w.browser.until("__viewer.answer?.accepted === false");
    assert!(
        w.browser
            .eval("document.getElementById('answer').textContent")
            .as_str()
            .expect("words")
            .contains("refused")
    );
    w.browser.click_on("[data-command=step]");
    w.browser.until("__viewer.operations.length === 3");
    w.browser.key(" "); // the keyboard acts on the button that has the focus
    w.browser.eval("document.activeElement.blur()");
    w.browser.key(" ");
    w.browser.until("__viewer.phase === 'RUNNING'");
    let commands: Vec<String> =
        w.commands.lock().expect("sound").iter().map(|c| c.0.clone()).collect();
    assert_eq!(commands[..3], ["freeze", "stop", "step 20"]);
    assert_eq!(commands.last().map(String::as_str), Some("start"));

    // Back in time: the picture of then, and new scans do not disturb it.
    w.browser.eval("(() => { const s = document.getElementById('scrub'); s.value = 12; s.dispatchEvent(new Event('input')); })()");
    w.browser.until("__viewer.scan === 12");
    w.drawn();
    w.assert_shows(&w.demo.scan(12));
    let newer = w.demo.scan(41);
    w.page.update(|viewer| viewer.on_scan(&newer));
    w.browser.until("__viewer.timeline.last === 41 && __viewer.curve.length === 41");
    assert_eq!(w.browser.eval("[__viewer.scan, __viewer.live]"), json!([12, false]));
    assert_eq!(w.browser.eval("document.getElementById('past').hidden"), false);
    w.browser.key(".");
    w.browser.until("__viewer.scan === 13");
    w.keep_screenshot("past-1280");
    w.browser.key("l");
    w.browser.until("__viewer.scan === 41 && __viewer.live");
    w.assert_no_complaint();
}

/// Selects a target by a click on its symbol.
fn pick(w: &mut Watched, number: u16) {
    let at = w.browser.eval(&format!(
        "(() => {{ const t = __viewer.tracks.find((t) => t.number === {number}), b = document.getElementById('map').getBoundingClientRect(); \
         return [t.screen.x + b.x, t.screen.y + b.y]; }})()",
    ));
    w.browser.click(at[0].as_f64().expect("x"), at[1].as_f64().expect("y"));
    w.browser.until(&format!("__viewer.selected === 't{number}' && __viewer.curve.length > 0 && document.querySelector('#tracks tr[aria-selected=true]') !== null"));
}

#[test]
fn every_list_is_filled_for_the_target_clicked_and_fits_its_box() {
    let Some(mut w) = watch(40) else { return };
    pick(&mut w, 2);
    let legend = w.browser.eval("document.querySelector('figcaption').textContent");
    for word in ["truth", "track", "95 %", "plots"] {
        assert!(
            legend.as_str().expect("words").contains(word),
            "the close-up does not explain {word}"
        );
    }
    // Something is drawn in the close-up besides its background and the scale.
    let colours = w.browser.eval(
        "(() => { const c = document.getElementById('close-up'), d = c.getContext('2d').getImageData(0, 0, c.width, c.height - 30).data; \
         const seen = new Set(); for (let i = 0; i < d.length; i += 4) seen.add(d[i] << 16 | d[i + 1] << 8 | d[i + 2]); return seen.size; })()",
    );
    assert!(colours.as_u64() > Some(20), "the close-up has {colours} colours");

    w.browser.click_on("#tab-effects");
    w.browser.until("document.querySelectorAll('#effects .told tbody tr').length > 0");
    let rows = w.browser.eval(
        "[...document.querySelectorAll('#effects .told tbody tr')].map((r) => [...r.cells].map((c) => c.textContent))",
    );
    let glint = rows.as_array().expect("rows").iter().find(|r| r[1] == "+3.76").expect("glint");
    assert!(glint[0].as_str().expect("words").contains("wanders"), "{glint} is not explained");
    assert_eq!(glint[2], "m");
    let units = w.browser.eval("document.getElementById('effects').textContent.includes('dB: ')");
    assert_eq!(units, true, "the units are explained");

    w.browser.click_on("#tab-filter");
    w.browser.click_on("#compare");
    w.browser.until("document.getElementById('compare').getAttribute('aria-pressed') === 'true'");
    w.page.update(|viewer| assert!(viewer.comparing(), "the viewer was asked"));
    let rung = |rung: &str, chosen: bool, rmse_m: f64, us_per_track: f64| RungRow {
        rung: rung.to_owned(),
        about: models::filter::Rung::of(rung).expect("a rung").declared().about,
        chosen,
        rmse_m: Some(rmse_m),
        rmse_60s_m: Some(rmse_m),
        plots: 200,
        raw_rmse_m: Some(5.0),
        scan_us: 8.0 * us_per_track,
        us_per_track: Some(us_per_track),
        tracks: 8,
        since_s: 12.0,
        ..RungRow::default()
    };
    let rungs =
        [rung("abg", false, 5.0, 1.0), rung("ca3", true, 4.0, 2.0), rung("imm3", false, 3.0, 6.0)];
    w.page.update(|viewer| viewer.on_rungs(&rungs, &[[0.0, 0.0]], false));
    w.browser.until("document.querySelectorAll('#rungs tbody tr').length === 3");
    let change = w.browser.eval(
        "[...document.querySelectorAll('#rungs tbody tr')].map((r) => r.cells[2].textContent)",
    );
    assert_eq!(change, json!(["5.00", "4.00", "3.00"]), "the last minute");
    // A budget finds its rung, and the ghost of that one is asked for.
    w.browser.eval("(() => { const i = document.getElementById('budget-us'); i.value = '7'; i.dispatchEvent(new Event('change')); })()");
    let within = w.browser.eval("document.querySelector('.dial .where').textContent");
    assert!(within.as_str().expect("words").contains("imm3, 3.00 m at 6.00"), "{within}");
    w.browser.until("document.querySelector('.dial .choice').textContent.includes('ghost')");
    w.page.update(|viewer| assert_eq!(viewer.ghost(), Some("imm3")));
    w.browser.click_on("#compare");
    w.browser.until("document.getElementById('compare').getAttribute('aria-pressed') === 'false'");

    let tabs =
        w.browser.eval("[...document.querySelectorAll('[data-tab]')].map((t) => t.dataset.tab)");
    let tabs: Vec<String> = serde_json::from_value(tabs).expect("words");
    assert!(tabs.len() >= 8, "{tabs:?}");
    for tab in &tabs {
        w.browser.click_on(&format!("#tab-{tab}"));
        // A panel that lives by pictures fills itself with the next one.
        w.page.update(|viewer| viewer.on_scan(&w.demo.scan(41)));
        w.drawn();
        let panel = w.browser.eval(&format!(
            "(() => {{ const p = document.getElementById('panel-{tab}'); return [p.innerText.trim().length > 10, p.scrollWidth - p.clientWidth]; }})()"
        ));
        assert_eq!(panel, json!([true, 0]), "{tab}: filled, and not wider than its box");
    }
    w.assert_no_complaint();
}
