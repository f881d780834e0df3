//! What goes wrong is shown and does no harm.

use super::*;
use models::frames::Point2;

#[test]
fn what_goes_wrong_is_shown_and_does_no_harm() {
    let Some(mut w) = watch(5) else { return };
    // Names are text, never markup; figures that are none leave the rest of the picture alone.
    let mut odd = w.demo.scan(6);
    odd.tracks[0].callsign = "<b>X</b>".to_owned();
    odd.tracks[1].position_m = Point2::new(f64::NAN, 5.0);
    odd.tracks[1].cov_m2 = [f64::INFINITY; 3];
    odd.truth[3].position_m[0] = f64::INFINITY;
    w.page.update(|viewer| viewer.on_scan(&odd));
    w.browser.until("__viewer.scan === 6");
    w.drawn();
    let names = w
        .browser
        .eval("[...document.querySelectorAll('#tracks td:first-child')].map((c) => c.textContent)");
    assert!(names.as_array().expect("names").contains(&json!("<b>X</b>")));
    assert_eq!(w.browser.eval("document.querySelectorAll('#tracks b').length"), 0);
    // Messages that are none are refused by the reader with a reason.
    for (octets, reason) in [
        ("new Uint8Array(0)", "not a valid scan"),
        ("new Uint8Array(40)", "not a valid scan"),
        (
            "(() => { const a = new Uint8Array(40); a.set([83, 69, 69, 68, 9]); return a; })()",
            "version 9",
        ),
        (
            "(() => { const a = new Uint8Array(40); a.set([83, 69, 69, 68, 3]); a[24] = 200; return a; })()",
            "cut short",
        ),
    ] {
        let said = w.browser.eval(&format!(
            "import('/frame.js').then((m) => {{ try {{ m.decode(({octets}).buffer); return 'taken'; }} catch (e) {{ return e.message; }} }})"
        ));
        assert!(said.as_str().expect("words").contains(reason), "{octets}: {said}");
    }
    // Another page may not use this one.
    let address = w.server.address();
    let knock = |host: &str, origin: &str| {
        let request = tungstenite::http::Request::builder()
            .uri(format!("ws://{address}/socket"))
            .header("Host", host)
            .header("Origin", origin)
            .header("Connection", "Upgrade")
            .header("Upgrade", "websocket")
            .header("Sec-WebSocket-Version", "13")
            .header("Sec-WebSocket-Key", tungstenite::handshake::client::generate_key())
            .body(())
            .expect("a request");
        match tungstenite::connect(request) {
            Ok(_) => 101,
            Err(tungstenite::Error::Http(answer)) => answer.status().as_u16(),
            Err(error) => panic!("{error}"),
        }
    };
    let own = address.to_string();
    assert_eq!(knock(&own, &format!("http://{own}")), 101);
    assert_eq!(knock(&own, "http://evil.example"), 403);
    assert_eq!(knock("evil.example", "http://evil.example"), 403);
    let ask = |method: &str| {
        use std::io::{Read, Write};
        let mut stream = std::net::TcpStream::connect(address).expect("connected");
        write!(stream, "{method} / HTTP/1.1\r\nHost: {own}\r\nConnection: close\r\n\r\n")
            .expect("sent");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("an answer");
        answer.split(' ').nth(1).map(str::to_owned)
    };
    for (method, status) in [("GET", "200"), ("HEAD", "200"), ("POST", "405"), ("DELETE", "405")] {
        assert_eq!(ask(method).as_deref(), Some(status), "{method}");
    }

    // A lost connection is shown, the last picture stays, and the page comes back by itself.
    let Watched { page, server, commands, browser, .. } = &mut w;
    browser.resize([1920, 1080]);
    let stopped =
        std::mem::replace(server, start("127.0.0.1:0".parse().expect("address"), page, commands));
    stopped.stop();
    browser.until("__viewer.connection === 'lost' && !document.getElementById('alert').hidden");
    let words = browser.eval("document.getElementById('alert').textContent");
    assert!(words.as_str().expect("words").contains("lost"), "{words}");
    assert_eq!(
        browser.eval("[__viewer.scan, document.body.classList.contains('stale')]"),
        json!([6, true])
    );
    w.keep_screenshot("lost-1920");
    let Watched { demo, page, server, commands, browser } = &mut w;
    *server = start(address, page, commands);
    let back = demo.scan(7);
    page.update(|viewer| viewer.on_scan(&back));
    browser.until("__viewer.connection === 'open' && __viewer.scan === 7 && document.getElementById('alert').hidden");
    assert!(
        w.browser.complaints.iter().all(|c| !c.contains("Security Policy")),
        "{:?}",
        w.browser.complaints
    );
}
