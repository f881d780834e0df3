//! A person at the wheel: takes a vehicle, drives it by keys, sees it move between two messages, hears why not, gives it up.

use super::{Watched, watch};
use federates::runtime::messages::{SeatAction, SeatAnswer, SeatOrder};
use federates::viewer_logger::said::Topic;
use serde_json::json;
use std::sync::{Arc, Mutex};

const SEAT: &str = "#drive [data-seat=\"driver FOLLOW1\"]";

/// A car at a place north of the reference point, heading east, with its wheels turned to the right.
fn stands(w: &Watched, time_s: f64, taken: bool, speed_mps: f64) {
    let state = json!({"time_s": time_s, "movers": [{
        "callsign": "FOLLOW1", "seat": "driver FOLLOW1", "taken": taken, "at_m": [0.0, 100.0], "heading_rad": 1.57,
        "speed_mps": speed_mps, "acceleration_mps2": 0.0, "steer_rad": 0.2, "length_m": 4.6, "width_m": 1.9, "aircraft": false,
        "wheelbase_m": 2.7, "most_mps": 27.8, "off_pavement": speed_mps > 2.0, "silent": false, "contacts": 0,
    }]});
    w.page.update(|viewer| viewer.on_said(Topic::Driven, &state.to_string()));
}

/// Takes the car and shows its wheel.
pub(super) fn at_the_wheel(w: &mut Watched) {
    w.page.let_speak(Arc::new(|_| Ok(SeatAnswer { accepted: true, ..SeatAnswer::default() })));
    w.browser.eval("document.getElementById('tab-drive').click()");
    stands(w, 42.0, true, 3.0);
    stands(w, 43.0, false, 0.0);
    w.browser.until(&format!("document.querySelector('{SEAT}')?.disabled === false"));
    w.browser.eval(&format!("document.querySelector('{SEAT}').click()"));
    w.browser.until("document.getElementById('wheel').offsetParent !== null");
}

fn wishes(orders: &Mutex<Vec<SeatOrder>>) -> Vec<[i16; 3]> {
    let wish = |o: &SeatOrder| match o.action {
        SeatAction::Drive { throttle, brake, steer } => Some([throttle, brake, steer]),
        _ => None,
    };
    orders.lock().expect("not poisoned").iter().filter_map(wish).collect()
}

#[test]
fn a_person_takes_a_car_and_drives_it_by_keys() {
    let Some(mut w) = watch(40) else { return };
    let orders: Arc<Mutex<Vec<SeatOrder>>> = Arc::default();
    let (noted, refuses) = (Arc::clone(&orders), Arc::new(Mutex::new(false)));
    let refuse = Arc::clone(&refuses);
    w.page.let_speak(Arc::new(move |order| {
        if *refuse.lock().expect("not poisoned") {
            return Err("the run goes at 4.0 times real time: nobody can drive".to_owned());
        }
        noted.lock().expect("not poisoned").push(order.clone());
        Ok(SeatAnswer { accepted: true, number: 1, text: String::new() })
    }));
    w.browser.click_on("#tab-drive");
    w.browser.until("document.querySelector('#drive .empty').offsetParent !== null");
    stands(&w, 40.0, false, 0.0);
    w.browser.until(&format!("document.querySelector('{SEAT}')?.textContent === 'Take'"));
    w.browser.click_on(SEAT);
    stands(&w, 40.1, true, 0.0);
    w.browser.until(&format!("document.querySelector('{SEAT}').textContent === 'Give up'"));
    w.browser.until("document.activeElement.id === 'wheel'");
    // From now on the page is sent who is in sight from there, without plots and errors.
    w.browser.until("document.getElementById('sees').textContent.includes('driver FOLLOW1')");
    w.browser.until(
        "__viewer.plots.length === 0 && __viewer.truth.some((t) => t.callsign === 'FOLLOW1')",
    );
    assert_eq!(w.browser.eval("__viewer.tracks.every((t) => t.errorM === null)"), true);
    let key = |w: &mut Watched, kind: &str, key: &str| {
        w.browser.eval(&format!(
            "document.getElementById('wheel').dispatchEvent(new KeyboardEvent('{kind}', {{key: '{key}', bubbles: true, cancelable: true}}))"
        ));
    };
    let said = |wish: [i16; 3]| super::demo::soon(|| wishes(&orders).contains(&wish));
    // Forward; with a third to the right; backwards from standing; all of the brake; the parking brake keeps it.
    key(&mut w, "keydown", "w");
    assert!(said([1000, 0, 0]), "{:?}", wishes(&orders));
    key(&mut w, "keydown", "Shift");
    key(&mut w, "keydown", "D");
    assert!(said([330, 0, 330]), "{:?}", wishes(&orders));
    for up in ["w", "D", "Shift"] {
        key(&mut w, "keyup", up);
    }
    key(&mut w, "keydown", "ArrowDown");
    assert!(said([-1000, 0, 0]), "{:?}", wishes(&orders));
    key(&mut w, "keyup", "ArrowDown");
    key(&mut w, "keydown", " ");
    assert!(said([0, 1000, 0]), "{:?}", wishes(&orders));
    key(&mut w, "keyup", " ");
    // None of them reached the page's own keys: time goes on, nothing is selected.
    assert_eq!(w.browser.eval("window.__viewer.live"), true);
    // Who has nothing to say says so again before it is too old: at least three times a second.
    let before = wishes(&orders).len();
    std::thread::sleep(std::time::Duration::from_millis(2000));
    let again = wishes(&orders).len() - before;
    assert!((5..=21).contains(&again), "{again} in two seconds");
    // Rolling: it is drawn where it is by now, with its wheels turned: ahead and to the right.
    stands(&w, 41.0, true, 5.0);
    w.browser.until("document.getElementById('wheel').textContent.includes('18 km/h')");
    w.browser.until("document.getElementById('wheel').textContent.includes('off the pavement')");
    w.keep_screenshot("drive-1280");
    let small = "[...document.querySelectorAll('#drive button, #drive a, #drive label')].filter((e) => e.offsetParent && e.getBoundingClientRect().height < 24).length";
    assert_eq!(w.browser.eval(small), 0);
    // What is refused is said where one looks.
    *refuses.lock().expect("not poisoned") = true;
    w.browser.until(
        "document.querySelector('#drive .seat-answer').textContent.includes('4.0 times real time')",
    );
    *refuses.lock().expect("not poisoned") = false;
    w.browser.click_on(SEAT);
    let left = || {
        orders.lock().expect("not poisoned").last().is_some_and(|o| o.action == SeatAction::Leave)
    };
    assert!(super::demo::soon(left));
    w.browser.until("document.getElementById('sees').hidden && __viewer.plots.length > 0");
    // The same from its seat, in the eye.
    let before = wishes(&orders).len();
    stands(&w, 42.0, false, 0.0);
    let origin = w.browser.eval("location.origin");
    w.browser.go(&format!("{}/eye#eye=driver:FOLLOW1", origin.as_str().expect("a text")));
    w.browser.until("window.__eye && document.getElementById('drive') && !document.getElementById('drive').hidden");
    w.browser.click_on("#drive");
    w.browser.until("document.getElementById('drive').getAttribute('aria-pressed') === 'true'");
    w.browser.eval("document.body.dispatchEvent(new KeyboardEvent('keydown', {key: 'a', bubbles: true, cancelable: true}))");
    assert!(super::demo::soon(|| wishes(&orders)[before..].contains(&[0, 0, -1000])));
    w.browser.until("document.getElementById('wheel-says').textContent.includes('0 km/h')");
    w.assert_no_complaint();
}
