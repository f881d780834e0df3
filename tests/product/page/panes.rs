//! Panes that show no sensor, by the address: the eye, the error curve, strips, the dial.

use super::watch;

#[test]
fn panes_of_the_address_are_there_and_stay_in_it() {
    let Some(mut w) = watch(40) else { return };
    w.browser.eval("location.hash = 'pane=map,strips,curve,dial'");
    w.browser.until("__viewer.panes.join() === 'strips,curve,dial'");
    w.browser.until("__viewer.state.includes('pane=map,strips,curve,dial')");
    w.browser.until("document.querySelectorAll('[data-pane=strips] .strip').length > 0");
    // The curve of the pane is the selected target's.
    w.browser.until("document.querySelector('#tracks tbody tr') !== null");
    w.browser.eval("document.querySelector('#tracks tbody tr').click()");
    w.browser.until("document.querySelector('[data-pane=curve] .u-legend') !== null && document.querySelector('[data-pane=curve] header span').textContent.length > 2");
    assert_eq!(
        w.browser
            .eval("document.querySelector('[data-pane=dial] button:not([title])').textContent"),
        "Compare all filters"
    );
    w.keep_screenshot("panes-1280");
    // The eye in a frame of its own shows the scan of the map.
    w.browser.until("location.hash === __viewer.state");
    w.browser.eval("location.hash = 'pane=map,eye:tower'");
    w.browser.until("document.querySelector('[data-pane=\"eye:tower\"] iframe')?.contentWindow.__eye?.scan === __viewer.scan");
    w.browser.eval("document.querySelector('[data-time=back]').click()");
    w.browser.until(
        "__viewer.scan === 39 && document.querySelector('iframe').contentWindow.__eye.scan === 39",
    );
    // An address that is written meanwhile goes before one that is typed.
    w.browser.until("location.hash === __viewer.state");
    w.browser.eval("location.hash = 'pane=map'");
    w.browser.until("__viewer.panes.length === 0 && document.getElementById('panes').hidden");
    w.assert_no_complaint();
}
