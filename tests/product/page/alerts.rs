//! Alerts, strips and panes: what was said is shown, and a key acknowledges.

use super::*;
use federates::runtime::messages::AlertMessage;
use federates::viewer_logger::said::Topic;
use models::control::alert::{AlertKind, Change, Stage};
use models::frames::Point2;

/// Alert `id` of two targets of the demo run.
pub(super) fn alert(id: u32, change: Change, s: i64) -> AlertMessage {
    AlertMessage {
        time_ns: s * 1_000_000_000,
        run: 1,
        change,
        id,
        kind: AlertKind::RunwayArrival,
        stage: Stage::Alarm,
        subjects: "CAI3208 EDW229".to_owned(),
        since_ns: s * 1_000_000_000,
        asterix: 9,
        place_m: Point2::origin(),
        number: 0,
    }
}

#[test]
fn alerts_strips_and_panes_are_what_was_said_and_a_key_acknowledges() {
    let Some(mut w) = watch(40) else { return };
    let hidden = w.browser.eval("document.getElementById('alerts').hidden");
    assert_eq!(hidden, true, "nothing was said");
    w.page.update(|viewer| viewer.on_alerts(&[alert(5, Change::Raised, 39)]));
    w.browser.until("__viewer.alerts.length === 1");
    w.drawn();
    let text = w.browser.eval("document.querySelector('#alerts li').textContent");
    for words in ["alarm", "CAI3208 / EDW229", "runway not free for an arrival"] {
        assert!(text.as_str().expect("words").contains(words), "{text}");
    }
    let levels = w
        .browser
        .eval("__viewer.labels.filter((l) => ['t1', 't2'].includes(l.id)).map((l) => l.level)");
    assert_eq!(levels, json!([3, 3]), "both say everything");
    // The frame round the symbol is the alarm's red.
    let pixel = w.browser.eval(
        "(() => { const t = __viewer.tracks.find((t) => t.number === 2); \
         return [...document.getElementById('map').getContext('2d').getImageData(t.screen.x - 11, t.screen.y + 6, 1, 1).data]; })()",
    );
    let [red, green, blue] = [0, 1, 2].map(|i| pixel[i].as_i64().expect("0 to 255"));
    assert!(red > 180 && green < 130 && blue < 130, "{pixel}");
    // A controller is told of the alarm, and of no error.
    w.browser.click_on("#skin");
    let heads = "[...document.querySelectorAll('#tracks th')].filter((e) => e.offsetParent).map((e) => e.dataset.key)";
    let without = json!(["callsign", "number", "type", "speed", "heading", "status"]);
    assert_eq!(w.browser.eval(heads), without);
    let judged = "['effects', 'filter', 'sensors'].filter((t) => document.getElementById(`tab-${t}`).offsetParent).length";
    assert_eq!(w.browser.eval(judged), 0);
    w.browser.click_on("#skin");
    assert_eq!(w.browser.eval(judged), 3);
    w.browser.key("k");
    w.browser.until("__viewer.alerts[0].acknowledged === 'page'");
    w.page.update(|viewer| {
        let done = viewer.take_done();
        assert_eq!((done.len(), &done[0].command[..]), (1, "acknowledge 5"));
    });
    w.browser.click_on("#alerts li button");
    w.browser.until("['t1', 't2'].includes(__viewer.selected)");
    // Looked back at, it has not been raised yet.
    w.browser.eval("(() => { const s = document.getElementById('scrub'); s.value = 12; s.dispatchEvent(new Event('input')); })()");
    w.browser.until("__viewer.scan === 12 && __viewer.alerts.length === 0");
    w.browser.key("l");
    w.browser.until("__viewer.live && __viewer.alerts.length === 1");
    w.page.update(|viewer| viewer.on_alerts(&[alert(5, Change::Ended, 40)]));
    w.browser.until("__viewer.alerts.length === 0");

    // What flights that behave say: the strip, and why it waits.
    let waits = json!({"for": "EDW229", "at": "A (31-32)", "since_s": 30.0, "planned_s": 12.0});
    let mover = json!({
        "callsign": "SWR137H", "phase": "taxiing", "stand": "I_98", "runway": "28", "waits": waits, "held": [4],
        "cleared": [{"kind": "TAX", "runway": "", "since_s": 1.0}], "authority_m": [[0, 0], [30, 40]], "planned_m": [[30, 40], [30, 90]],
    });
    let runway = json!({"name": "10/28", "owner": "EDW229", "queue": 2});
    let said = json!({"time_s": 40.0, "movers": [mover], "runways": [runway]}).to_string();
    w.page.update(|viewer| viewer.on_said(Topic::Traffic, &said));
    let bars = r#"{"time_s":40.0,"bars":[{"runway":"10/28","ends_m":[[0,0],[20,0]],"lit":true}]}"#;
    w.page.update(|viewer| viewer.on_said(Topic::Lights, bars));
    w.browser.click_on("#tab-strips");
    w.browser.until("__viewer.strips.some((s) => s.callsign === 'SWR137H' && s.bay === 'hold')");
    let strip =
        w.browser.eval("document.querySelector('#strips [data-strip=SWR137H]').textContent");
    assert!(strip.as_str().expect("words").contains("waits for EDW229 at A (31-32)"), "{strip}");
    w.browser.click_on("#strips [data-strip=SWR137H]");
    w.browser
        .until("document.getElementById('target-facts').textContent.includes('50 m of 100 m')");
    assert_eq!(w.browser.eval("__viewer.said.lights.bars.length"), 1);

    // A pane for the radar, one for the tracks: in the address, and gone when closed.
    w.browser.click_on("[data-pane-of='sensor:1']");
    w.browser.click_on("[data-pane-of=tracks]");
    w.browser
        .until("__viewer.panes.length === 2 && location.hash.includes('pane=map,sensor:1,tracks')");
    w.drawn();
    let told = w
        .browser
        .eval("document.querySelector('[data-pane=\"sensor:1\"] header span').textContent");
    let plots = w.demo.scan(40).plots.iter().filter(|p| p.sensor == 1).count();
    assert!(told.as_str().expect("words").starts_with(&format!("{plots} plots")), "{told}");
    w.keep_screenshot("panes-1280");
    w.browser.click_on("[data-pane=tracks] button");
    w.browser.until("__viewer.panes.length === 1");
    w.assert_no_complaint();
}
