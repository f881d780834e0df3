use super::*;

#[test]
fn a_taken_port_is_named_with_the_flag_that_helps() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = taken.local_addr().expect("address");
    let page = Page::new(Viewer::new(1 << 16));
    let error = serve(address, page, Box::new(|_, _| (true, String::new()))).err().expect("taken");
    let text = error.to_string();
    for part in [&address.to_string()[..], "taken", "--page"] {
        assert!(text.contains(part), "{text}");
    }
    assert!(!text.contains('\n'));
}

/// The first JSON answer of type `reply` or `refused` to a freeze, by somebody who shows `token` or comes from the page.
fn freeze(server: &Server, origin: bool, token: Option<&str>) -> Result<String, String> {
    let address = format!("127.0.0.1:{}", server.address().port());
    let uri = format!("ws://{address}/socket").parse().expect("a URI");
    let mut request = tungstenite::ClientRequestBuilder::new(uri);
    if origin {
        request = request.with_header("Origin", format!("http://{address}"));
    }
    let mut socket = tungstenite::connect(request).map_err(|e| e.to_string())?.0;
    if let Some(token) = token {
        let first = format!(r#"{{"type":"token","token":"{token}"}}"#);
        socket.send(tungstenite::Message::text(first)).map_err(|e| e.to_string())?;
    }
    let freeze = r#"{"type":"command","id":1,"command":"freeze"}"#;
    socket.send(tungstenite::Message::text(freeze)).map_err(|e| e.to_string())?;
    loop {
        let message = socket.read().map_err(|e| e.to_string())?;
        if let Ok(text) = message.to_text()
            && [r#""type":"reply""#, r#""type":"refused""#].iter().any(|t| text.contains(t))
        {
            return Ok(text.to_owned());
        }
    }
}

#[test]
fn a_run_is_commanded_only_by_who_may() {
    let commands = Arc::new(Mutex::new(0));
    for (listen, url_to_look) in [("127.0.0.1:0", false), ("0.0.0.0:0", true)] {
        let counted = Arc::clone(&commands);
        *commands.lock().expect("sound") = 0;
        let operate: Operate = Box::new(move |_, _| {
            *counted.lock().expect("sound") += 1;
            (true, "FROZEN".to_owned())
        });
        let page = Page::new(Viewer::new(1 << 16));
        let server = serve(listen.parse().expect("address"), page, operate).expect("served");
        let access = server.access();
        let told = |what: &str| *commands.lock().expect("sound") == usize::from(what == "yes");
        assert!(freeze(&server, false, None).map_or(true, |t| t.contains("token")), "{listen}");
        assert!(told("no"), "{listen}: without origin and token");
        assert_eq!(access.url_to_look().is_some(), url_to_look, "{listen}");
        if let Some(url) = access.url_to_look() {
            let look = url.split_once("#key=").expect("a token").1;
            let command = access.url().split_once("#key=").expect("a token").1.to_owned();
            for (token, words) in [(None, "token"), (Some("00"), "token"), (Some(look), "looking")]
            {
                let answer = freeze(&server, true, token).expect("an answer");
                assert!(answer.contains(words), "{token:?}: {answer}");
            }
            assert!(told("no"), "wrong tokens and the one to look command nothing");
            let answer = freeze(&server, true, Some(&command)).expect("an answer");
            assert!(answer.contains("FROZEN"), "{answer}");
        } else {
            assert!(freeze(&server, true, None).expect("an answer").contains("FROZEN"));
        }
        assert!(told("yes"), "{listen}: who may, may");
        server.stop();
    }
}

#[test]
fn figures_are_for_who_may_look() {
    use std::io::{Read, Write};
    let get = |server: &Server, token: Option<&str>| {
        let to = (IpAddr::from([127, 0, 0, 1]), server.address().port());
        let mut stream = std::net::TcpStream::connect(to).expect("connected");
        let bearer = token.map(|t| format!("Authorization: Bearer {t}\r\n")).unwrap_or_default();
        let head = "Host: 127.0.0.1\r\nConnection: close\r\n";
        write!(stream, "GET /metrics HTTP/1.1\r\n{head}{bearer}\r\n").expect("sent");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("an answer");
        answer
    };
    for listen in ["127.0.0.1:0", "0.0.0.0:0"] {
        let page = Page::new(Viewer::new(1 << 16));
        page.update(|viewer| viewer.on_state(&crate::runtime::messages::RunState::default()));
        let operate: Operate = Box::new(|_, _| (true, String::new()));
        let server = serve(listen.parse().expect("address"), page, operate).expect("served");
        let good = |answer: &str| answer.contains("200 OK") && answer.contains("seeds_frame 0");
        match server.access().url_to_look() {
            None => assert!(good(&get(&server, None))),
            Some(url) => {
                let token = url.split_once("#key=").expect("a token").1;
                assert!(good(&get(&server, Some(token))));
                assert!(get(&server, None).starts_with("HTTP/1.1 403"));
                assert!(get(&server, Some("00")).starts_with("HTTP/1.1 403"));
            }
        }
        server.stop();
    }
}

#[test]
fn browsers_have_places_and_one_client_a_share() {
    let operate: Operate = Box::new(|_, _| (true, String::new()));
    let here = "127.0.0.1:0".parse().expect("an address");
    let shared = Arc::new(Shared {
        page: Page::new(Viewer::new(1 << 16)),
        operate,
        access: Arc::new(Access::at(here).expect("random numbers")),
        browsers: Mutex::default(),
    });
    let far = |n: u8| IpAddr::from([192, 0, 2, n]);
    let mut seats: Vec<_> = (0..40).map_while(|_| Seat::take(&shared, far(1)).ok()).collect();
    assert_eq!(seats.len(), MAX_OF_ONE_CLIENT);
    for n in 2..=3 {
        seats.extend((0..MAX_OF_ONE_CLIENT).map(|_| Seat::take(&shared, far(n)).expect("one")));
    }
    let here = IpAddr::from([127, 0, 0, 1]);
    seats.extend((0..40).map_while(|_| Seat::take(&shared, here).ok()));
    assert_eq!(seats.len(), MAX_BROWSERS);
    assert!(Seat::take(&shared, far(9)).is_err());
    seats.pop();
    assert!(Seat::take(&shared, far(9)).is_ok());
    drop(seats);
    assert!(shared.browsers().is_empty());
}
