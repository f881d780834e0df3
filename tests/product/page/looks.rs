//! How the page looks: layers and windows of the map, every size of the window, and what axe says of it.

use super::alerts::alert;
use super::*;
use federates::viewer_logger::detection::Maps;
use federates::viewer_logger::tolerances::{Told, ToleranceRow};
use models::control::alert::Change;

#[test]
fn where_the_radars_do_not_see_is_a_layer_under_the_map() {
    let Some(mut w) = watch(40) else { return };
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/asmgcs.toml");
    let scene = Arc::new(scenarios::load_without_truth(&file).expect("the scene is sound"));
    w.page.update(|viewer| viewer.show_detection(Maps::of(Arc::clone(&scene))));
    w.drawn();
    // The pixel of a place on the map.
    let at = |w: &mut Watched, place_m: [f64; 2]| -> Vec<i64> {
        w.drawn();
        let [x, y] = place_m;
        let colour = w.browser.eval(&format!(
            "(() => {{ const v = __viewer.view, d = [{x} - v.cx, {y} - v.cy].map((m) => m * v.scale), c = document.getElementById('map'); \
             const k = c.width / v.width; return [...c.getContext('2d').getImageData((v.width / 2 + d[0]) * k, (v.height / 2 - d[1]) * k, 1, 1).data]; }})()"
        ));
        (0..3).map(|i| colour[i].as_i64().expect("0 to 255")).collect()
    };
    // Under the radar's mast nothing is displayed: grey there, and the ground's own colour without the layer.
    let radar = scene.sensors.iter().find(|s| s.asde.is_some()).expect("a radar");
    let mast = radar.site_m.expect("a site").xy();
    let beside = [mast.x + 25.0, mast.y + 25.0];
    let before = at(&mut w, beside);
    w.browser.eval("document.getElementById('layer-detection').click()");
    w.browser.until("__viewer.detection !== null");
    let over = at(&mut w, beside);
    assert_ne!(before, over, "grey under the mast");
    assert!(
        w.browser.eval("__viewer.state").as_str().is_some_and(|s| s.contains("lay=")),
        "in the address"
    );
    w.keep_screenshot("detection");
    w.browser.eval("document.getElementById('layer-detection').click()");
    assert_eq!(at(&mut w, beside), before, "and gone again");
    // The video of the radar: its pane opens by itself, the turn of the scan is shown, and follows into the past.
    w.browser.eval("document.getElementById('layer-video').click()");
    w.browser.until("__viewer.panes.includes('sensor:1') && __viewer.videos[0]?.scan === 40");
    let lit = "((c) => c.getContext('2d').getImageData(0, 0, c.width, c.height).data.filter((v, i) => i % 4 === 1 && v > 90).length) \
               (document.querySelector('[data-pane=\"sensor:1\"] canvas'))";
    w.browser.until(&format!("__viewer.videos[0].sweep === 32 && {lit} > 300"));
    w.browser.eval("(() => { const s = document.getElementById('scrub'); s.value = 12; s.dispatchEvent(new Event('input')); })()");
    w.browser.until("__viewer.scan === 12 && __viewer.videos[0].scan === 12");
    w.keep_screenshot("video");
    w.browser.eval("document.getElementById('layer-video').click()");
    w.browser.until("__viewer.videos.length === 0");
    w.assert_no_complaint();
}

#[test]
fn a_window_in_the_map_shows_its_own_place_and_stands_in_the_address() {
    let Some(mut w) = watch(40) else { return };
    w.browser.key("i");
    w.browser.until("__viewer.insets.length === 1");
    w.browser.key("i");
    w.browser.until("__viewer.insets.length === 2");
    w.browser.key("i");
    w.browser.until("__viewer.answer?.text.includes('two windows at most')");
    // As the address says: the second one over a target, turned; its call sign is in it, at the place of its own camera.
    let target = w.browser.eval("(() => { const t = __viewer.tracks.find((t) => t.callsign === 'EDW229'); return [t.x, t.y]; })()");
    let [x, y] = [0, 1].map(|i| target[i].as_f64().expect("metres"));
    w.browser.eval(&format!("location.hash = '#in2={x:.1},{y:.1},1.5,90'"));
    w.browser.until("__viewer.insets.length === 1 && __viewer.insets[0].number === 2");
    w.drawn();
    let inset = w.browser.eval("__viewer.insets[0]");
    assert_eq!((inset["scale"].as_f64(), inset["rot"].as_f64()), (Some(1.5), Some(90.0)));
    assert!((inset["cx"].as_f64().expect("m") - x).abs() < 0.06, "{inset}, not {x}");
    let id = w.browser.eval("__viewer.tracks.find((t) => t.callsign === 'EDW229').id");
    assert!(inset["labels"].as_array().expect("ids").contains(&id), "{inset}");
    w.browser.until("__viewer.state.includes('in2=') && !__viewer.state.includes('in1=')");
    // A click on its middle selects the target there.
    w.browser.click_on(".inset canvas");
    w.browser.until(&format!("__viewer.selected === {id}"));
    // No label of the map lies under it.
    let under = w.browser.eval(
        "(() => { const b = document.querySelector('.inset').getBoundingClientRect(), m = document.getElementById('map').getBoundingClientRect(); \
         return __viewer.labels.map((l) => l.box).filter((l) => l.x < b.right - m.x && b.x - m.x < l.x + l.w && l.y < b.bottom - m.y && b.y - m.y < l.y + l.h).length; })()",
    );
    assert_eq!(under, 0);
    w.keep_screenshot("window");
    w.browser.click_on(".inset button");
    w.browser.until("__viewer.insets.length === 0 && !__viewer.state.includes('in2=')");
    w.assert_no_complaint();
}

#[test]
fn who_has_no_label_for_lack_of_room_is_listed_and_a_click_selects() {
    let Some(mut w) = watch(40) else { return };
    assert_eq!(w.browser.eval("document.getElementById('labels-hidden').hidden"), true);
    let mut crowd = w.demo.scan(41);
    let one = crowd.tracks[0].clone();
    crowd.tracks.extend((0..200).map(|n| {
        let mut other = one.clone();
        (other.number, other.callsign) = (500 + n, format!("CROWD{n}"));
        other
    }));
    w.page.update(|viewer| viewer.on_scan(&crowd));
    w.browser
        .until("__viewer.labelsHidden > 40 && !document.getElementById('labels-hidden').hidden");
    w.browser.click_on("#labels-hidden summary");
    w.browser.until("document.querySelectorAll('#labels-hidden button').length > 40");
    let name = w.browser.eval("document.querySelector('#labels-hidden button').textContent");
    w.browser.click_on("#labels-hidden button");
    w.browser.until(&format!("document.getElementById('target-name').textContent === {name}"));
    w.browser.until("__viewer.labels.some((l) => l.id === __viewer.selected)");
    w.assert_no_complaint();
}

#[test]
fn nothing_is_cut_off_in_any_window() {
    let Some(mut w) = watch(95) else { return };
    w.drawn();
    w.browser.click_on("#tracks tbody tr");
    w.browser.until("__viewer.curve.length > 50");
    for (size, name) in
        [([1280, 800], "1280"), ([1920, 1080], "1920"), ([420, 860], "420"), ([800, 600], "800")]
    {
        w.browser.resize(size);
        w.browser
            .until(&format!("innerWidth === {} && __viewer.view.width <= innerWidth", size[0]));
        w.keep_screenshot(name);
        let wide = w
            .browser
            .eval("document.documentElement.scrollWidth - document.documentElement.clientWidth");
        assert_eq!(wide, 0, "{name}: the page scrolls sideways");
        let cut = w.browser.eval(
            "[...document.querySelectorAll('header > *, footer > *, #controls button, #tracks td, #tracks th')] \
             .filter((e) => e.offsetParent && e.getBoundingClientRect().right > document.documentElement.clientWidth + 1).map((e) => e.outerHTML.slice(0, 80))",
        );
        assert_eq!(cut, json!([]), "{name}");
        let line = w.browser.eval("document.getElementById('line').clientWidth / innerWidth");
        assert!(line.as_f64() > Some(0.6), "{name}: {line} of the width for the time line");
    }
    w.browser.resize([1920, 1080]);
    w.browser.key("n");
    assert_eq!(w.browser.eval("__viewer.colours"), "day");
    w.keep_screenshot("day-1920");
    w.assert_no_complaint();
}

/// With `SEEDS_AXE=…/axe.min.js` (npm `axe-core`): no violation in any list, by night and by day, on a screen and on a phone.
#[test]
fn axe_finds_nothing_to_complain_about() {
    let Some(file) = std::env::var_os("SEEDS_AXE") else {
        skipped_axe();
        return;
    };
    let axe = std::fs::read_to_string(file).expect("axe.min.js");
    let Some(mut w) = watch(40) else { return };
    pick(&mut w, 2);
    w.page.update(|viewer| viewer.on_alerts(&[alert(5, Change::Raised, 39)]));
    w.page.update(|viewer| viewer.compare(true, None));
    w.page.update(|viewer| {
        let row =
            ToleranceRow { tolerance_m: 0.1, run: true, plots: 99, ..ToleranceRow::default() };
        let skipped = vec![["ASDE", "gases", "3e-2 dB"].map(str::to_owned)];
        let loose = ToleranceRow { tolerance_m: 1.0, skipped, ..ToleranceRow::default() };
        viewer.compare_tolerances(true, Some(1.0));
        viewer.on_tolerances(&Told { rows: vec![row, loose], taken: 0.5, ..Told::default() });
    });
    w.browser.click_on("[data-pane-of='sensor:1']");
    w.browser.eval("document.getElementById('layer-video').click()");
    w.browser.key("i");
    seats::sit_down(&mut w);
    drive::at_the_wheel(&mut w);
    w.browser.eval(&format!("{axe};1"));
    for size in [WINDOW, [390, 800]] {
        w.browser.resize(size);
        for _ in ["night", "day"] {
            let tabs = "[...document.querySelectorAll('[data-tab]')].map((t) => t.dataset.tab)";
            let tabs = w.browser.eval(tabs);
            let tabs: Vec<&str> =
                tabs.as_array().into_iter().flatten().filter_map(|t| t.as_str()).collect();
            assert!(tabs.len() >= 9, "{tabs:?}");
            for tab in tabs {
                w.browser.eval(&format!("document.getElementById('tab-{tab}').click()"));
                let found = w.browser.eval(
                    "axe.run(document, { resultTypes: ['violations'] }).then((r) => r.violations.map((v) => [v.id, v.nodes[0].html.slice(0, 120)]))",
                );
                assert_eq!(found, json!([]), "{tab} at {size:?}");
            }
            for (what, show) in [
                ("controller", "document.getElementById('skin').click()"),
                ("what if", "document.getElementById('what-if-dialog').showModal()"),
                ("help", "document.getElementById('help').showModal()"),
            ] {
                w.browser.eval(show);
                let found = w.browser.eval(
                    "axe.run(document, { resultTypes: ['violations'] }).then((r) => r.violations.map((v) => [v.id, v.nodes[0].html.slice(0, 120)]))",
                );
                assert_eq!(found, json!([]), "{what} at {size:?}");
                w.browser
                    .eval("for (const d of document.querySelectorAll('dialog[open]')) d.close()");
            }
            w.browser.eval("document.getElementById('skin').click()");
            w.browser.key("n");
        }
    }
}

#[expect(clippy::print_stderr, reason = "a skipped test says so")]
fn skipped_axe() {
    eprintln!("skipped: SEEDS_AXE does not name axe.min.js (npm pack axe-core)");
}
