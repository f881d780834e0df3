//! A person at a controller's seat: takes it, clears by button, digit and line, hears why not, gives it up.

use super::{Watched, watch};
use federates::runtime::messages::{SeatAction, SeatAnswer, SeatOrder};
use federates::viewer_logger::said::Topic;
use models::control::clearance::ClearanceKind;
use serde_json::{Value, json};
use std::sync::{Arc, Mutex};

const GROUND: &str = "[data-seat=ground]";

/// How the seats stand: the ground by somebody, two who wait for it, one who is told something.
fn stands(w: &Watched, time_s: f64, by: &Value, pending: &Value) {
    let wants = |all: &[(&str, &str)]| -> Vec<Value> {
        let want = |w: &(&str, &str)| json!({"callsign": w.0, "clearance": w.1, "since_s": 30.0});
        all.iter().map(want).collect()
    };
    let seat = |name: &str, by: &Value, all: &[(&str, &str)]| json!({"name": name, "by": by, "since_s": null, "wants": wants(all)});
    let state = json!({
        "time_s": time_s,
        "seats": [
            seat("apron", &Value::Null, &[]), seat("ground", by, &[("SWR137H", "TAX"), ("EDW229", "TAX")]),
            seat("tower 1", &json!("ben"), &[("CAI3208", "LND")]),
        ],
        "pending": pending, "held": [], "answers": [],
        "radio": [{"time_s": 31.0, "from": "SWR137H", "to": "ground", "kind": "request", "clearance": "TAX"}],
    });
    w.page.update(|viewer| viewer.on_said(Topic::Seats, &state.to_string()));
}

fn orders(w: &Watched) -> Arc<Mutex<Vec<SeatOrder>>> {
    let orders: Arc<Mutex<Vec<SeatOrder>>> = Arc::default();
    let noted = Arc::clone(&orders);
    w.page.let_speak(Arc::new(move |order| {
        let mut noted = noted.lock().expect("not poisoned");
        if matches!(&order.action, SeatAction::Say { clearance, .. } if *clearance == ClearanceKind::LineUp) {
            return Err("LUP for SWR137H is given by tower 1".to_owned());
        }
        if order.action != SeatAction::Here {
            noted.push(order.clone());
        }
        Ok(SeatAnswer { accepted: true, number: noted.len() as u64, text: String::new() })
    }));
    orders
}

/// Takes the ground and shows who waits there.
pub(super) fn sit_down(w: &mut Watched) -> Value {
    w.browser.eval("document.getElementById('tab-seats').click()");
    stands(w, 40.0, &Value::Null, &json!([]));
    w.browser.until(&format!("document.querySelector('{GROUND}')?.textContent === 'Take'"));
    let me = w.browser.eval("document.getElementById('person').value");
    stands(w, 41.0, &me, &json!([]));
    w.browser.until(&format!("document.querySelector('{GROUND}').textContent === 'Give up'"));
    me
}

#[test]
fn a_person_takes_a_seat_and_clears_by_button_digit_line_and_strip() {
    let Some(mut w) = watch(40) else { return };
    let orders = orders(&w);
    let said = |callsign: &str| SeatAction::Say {
        callsign: callsign.into(),
        clearance: ClearanceKind::Taxi,
    };
    w.browser.click_on("#tab-seats");
    stands(&w, 40.0, &Value::Null, &json!([]));
    w.browser.until(&format!("document.querySelector('{GROUND}')?.textContent === 'Take'"));
    assert_eq!(w.browser.eval("document.querySelector('[data-seat=\"tower 1\"]').disabled"), true);
    assert_eq!(w.browser.eval("document.querySelectorAll('#seats .waiting button').length"), 0);
    w.browser.click_on(GROUND);
    let taken = |n: usize| orders.lock().expect("not poisoned").len() >= n;
    assert!(super::demo::soon(|| taken(1)));
    let me = sit_down(&mut w);
    // By button, by digit, and by the line, with a unique ending.
    w.browser.click_on("[data-clear='SWR137H TAX']");
    assert!(super::demo::soon(|| taken(2)));
    w.browser.key("2");
    assert!(super::demo::soon(|| taken(3)));
    w.browser.eval("(() => { const l = document.getElementById('clearance-line'); l.value = '229 t'; l.form.requestSubmit(); })()");
    assert!(super::demo::soon(|| taken(4)));
    // Not his: the reason stands there.
    w.browser.eval("(() => { const l = document.getElementById('clearance-line'); l.value = 'SWR137H u'; l.form.requestSubmit(); })()");
    w.browser.until(
        "document.querySelector('.seat-answer').textContent.includes('is given by tower 1')",
    );
    // While one is being told, no button asks for it again.
    stands(
        &w,
        42.0,
        &me,
        &json!([{"callsign": "SWR137H", "clearance": "TAX", "seat": "ground", "until_s": 55.0}]),
    );
    w.browser.until(
        "document.querySelector('#seats .told')?.textContent.startsWith('TAX said; reads back')",
    );
    assert_eq!(
        w.browser.eval("document.querySelectorAll(\"[data-clear='SWR137H TAX']\").length"),
        0
    );
    let small = "[...document.querySelectorAll('#seats button, #seats input')].filter((e) => e.offsetParent && e.getBoundingClientRect().height < 24).length";
    assert_eq!(w.browser.eval(small), 0);
    w.keep_screenshot("seats-1280");
    w.browser.click_on("#tab-strips");
    w.browser.click_on("#strips li:has([data-strip=EDW229]) .next");
    assert!(super::demo::soon(|| taken(5)));
    w.browser.click_on("#tab-seats");
    w.browser.click_on(GROUND);
    assert!(super::demo::soon(|| taken(6)));
    let all = orders.lock().expect("not poisoned").clone();
    let done: Vec<SeatAction> = all.iter().map(|o| o.action.clone()).collect();
    let [swr, edw] = ["SWR137H", "EDW229"].map(said);
    use SeatAction::{Leave, Take};
    assert_eq!(done, [Take, swr, edw.clone(), edw.clone(), edw, Leave]);
    assert!(all.iter().all(|o| o.seat == "ground" && json!(o.person) == me), "{all:?}");
    w.assert_no_complaint();
}

/// Enter on the map goes to the line, Tab completes, an error stands in words under its column, and up brings back what was said.
#[test]
fn the_line_is_used_by_keyboard_alone() {
    let Some(mut w) = watch(40) else { return };
    let orders = orders(&w);
    sit_down(&mut w);
    w.browser.eval("document.getElementById('map').focus()");
    w.browser.key("Enter");
    w.browser.until("document.activeElement?.id === 'clearance-line'");
    let value = "document.getElementById('clearance-line').value";
    ["e", "d", "w"].iter().for_each(|c| w.browser.key(c));
    w.browser.key("Tab");
    w.browser.until(&format!("{value} === 'EDW229 '"));
    let send = "document.getElementById('clearance-line').form.requestSubmit()";
    ["w", "a", "x"].iter().for_each(|c| w.browser.key(c));
    w.browser.eval(send);
    let said = "document.getElementById('said').textContent";
    w.browser.until(&format!("{said} === '       \u{25b2} no such clearance'"));
    assert!(orders.lock().expect("not poisoned").is_empty(), "nothing was sent");
    ["Backspace", "Backspace", "Backspace"].iter().for_each(|c| w.browser.key(c));
    w.browser.eval("(() => { const l = document.getElementById('clearance-line'); l.value = 'EDW229 t'; l.dispatchEvent(new Event('input')); })()");
    w.browser.until(&format!("{said}.startsWith('EDW229: taxi ')"));
    w.keep_screenshot("line-1280");
    w.browser.eval(send);
    let taken = || orders.lock().expect("not poisoned").len() == 1;
    assert!(super::demo::soon(taken));
    w.browser.until(&format!("{value} === ''"));
    w.browser.key("ArrowUp");
    w.browser.until(&format!("{value} === 'EDW229 t'"));
    w.browser.key("Escape");
    w.browser.until("document.activeElement?.id === 'map'");
    let order = orders.lock().expect("not poisoned")[0].clone();
    assert_eq!(order.seat, "ground");
    assert!(matches!(order.action, SeatAction::Say { clearance: ClearanceKind::Taxi, .. }));
    w.assert_no_complaint();
}
