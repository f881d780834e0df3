use super::*;
use serde_json::json;

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

type Socket = tungstenite::WebSocket<tungstenite::stream::MaybeTlsStream<std::net::TcpStream>>;

/// A browser of this page, with what stands after the address of its socket.
fn browser(server: &Server, query: &str) -> Socket {
    let address = format!("127.0.0.1:{}", server.address().port());
    let uri = format!("ws://{address}/socket{query}").parse().expect("a URI");
    let request = tungstenite::ClientRequestBuilder::new(uri)
        .with_header("Origin", format!("http://{address}"));
    let socket = tungstenite::connect(request).expect("connected").0;
    if let tungstenite::stream::MaybeTlsStream::Plain(stream) = socket.get_ref() {
        stream.set_read_timeout(Some(Duration::from_secs(120))).expect("a time");
    }
    socket
}

fn ask(socket: &mut Socket, text: &str) {
    socket.send(tungstenite::Message::text(text)).expect("sent");
}

/// The next message of a type for which something holds.
fn told(
    socket: &mut Socket,
    kind: &str,
    so: impl Fn(&serde_json::Value) -> bool,
) -> serde_json::Value {
    loop {
        let message = socket.read().expect("a message");
        let Ok(text) = message.to_text() else { continue };
        let Ok(message) = serde_json::from_str::<serde_json::Value>(text) else { continue };
        if message["type"] == kind && so(&message) {
            return message;
        }
    }
}

/// The next scan.
fn scan_of(socket: &mut Socket) -> Vec<u8> {
    loop {
        if let tungstenite::Message::Binary(octets) = socket.read().expect("a message") {
            return octets.to_vec();
        }
    }
}

#[test]
fn each_page_of_a_finished_run_compares_at_its_own_time() {
    use crate::viewer_logger::log::{Log, tests::Folder};
    use crate::viewer_logger::picture::{AirportMap, RunInfo};
    let folder = Folder::new();
    let file = folder.0.join("run.sqlite");
    let mut log =
        Log::create(&file, &RunInfo::default(), &AirportMap::default()).expect("a new log");
    let scene = scenarios::load(&scenarios::locate("zurich")).expect("a shipped scene");
    crate::viewer_logger::kept_scene::keep(&mut log, &scene);
    (1..=60).for_each(|n| log.scan(&crate::viewer_logger::tests::scan(n)).expect("written"));
    log.close().expect("closed");
    let page = Page::new(crate::viewer_logger::opened::viewer(&file).expect("opened"));
    let operate: Operate = Box::new(|_, _| (false, String::new()));
    let server =
        serve("127.0.0.1:0".parse().expect("address"), Arc::clone(&page), operate).expect("served");
    let (mut a, mut b) = (browser(&server, ""), browser(&server, ""));
    scan_of(&mut a);
    ask(&mut a, r#"{"type":"compare","on":true,"ghost":"imm3"}"#);
    let ended = |scan: u64| move |m: &serde_json::Value| m["done"] == 1.0 && m["scan"] == scan;
    let whole = told(&mut a, "rungs", ended(60));
    assert!(whole["rows"].as_array().is_some_and(|r| r.len() > 10), "{whole}");
    assert_eq!(whole["ghost"].as_array().map(Vec::len), Some(1));
    scan_of(&mut b);
    ask(&mut b, r#"{"type":"show","scan":20}"#);
    scan_of(&mut b);
    ask(&mut b, r#"{"type":"compare","on":true}"#);
    let early = told(&mut b, "rungs", ended(20));
    assert_eq!(early["ghost"], json!([]));
    assert!(early["rows"][0]["plots"].as_u64() < whole["rows"][0]["plots"].as_u64());
    ask(&mut a, r#"{"type":"show","scan":40}"#);
    told(&mut a, "rungs", ended(40));
    ask(&mut a, r#"{"type":"tolerances","on":true}"#);
    told(&mut a, "tolerances", ended(40));
    ask(&mut a, r#"{"type":"compare","on":false}"#);
    assert_eq!(told(&mut a, "rungs", |_| true)["comparing"], false);
    // Two are at work; of others two more begin, and a third is refused.
    while Arc::strong_count(&page.comparisons) != 3 {
        std::thread::sleep(Duration::from_millis(5));
    }
    let mut more: Vec<Socket> = (0..3).map(|_| browser(&server, "")).collect();
    for (n, socket) in more.iter_mut().enumerate() {
        scan_of(socket);
        ask(socket, r#"{"type":"compare","on":true}"#);
        if n < 2 {
            told(socket, "rungs", ended(60));
        } else {
            let why = told(socket, "refused", |_| true);
            assert!(why["text"].as_str().is_some_and(|t| t.contains("stop one")), "{why}");
        }
    }
    server.stop();
}

#[test]
fn a_second_page_of_who_sits_is_sent_no_truth_from_its_first_message_on() {
    let page = Page::new(Viewer::new(1 << 20));
    page.update(|viewer| viewer.on_scan(&crate::viewer_logger::tests::scan(3)));
    page.let_speak(Arc::new(|_| Ok(SeatAnswer { accepted: true, number: 1, text: String::new() })));
    let operate: Operate = Box::new(|_, _| (true, String::new()));
    let server =
        serve("127.0.0.1:0".parse().expect("address"), Arc::clone(&page), operate).expect("served");
    let truth = |octets: &[u8]| crate::viewer_logger::frame::entities(octets).len();
    let mut first = browser(&server, "?person=ann");
    assert_eq!(truth(&scan_of(&mut first)), 1, "nobody sits");
    ask(&mut first, r#"{"type":"seat","id":1,"seat":"ground","person":"ann","action":"take"}"#);
    assert_eq!(truth(&scan_of(&mut first)), 0);
    let mut second = browser(&server, "?person=ann");
    assert_eq!(truth(&scan_of(&mut second)), 0, "the first picture already");
    let mut judge = browser(&server, "?person=bob");
    assert_eq!(truth(&scan_of(&mut judge)), 1, "who has no seat judges");
    let mut nobody = browser(&server, "");
    assert_eq!(truth(&scan_of(&mut nobody)), 1);
    // Who says later that he is ann sees as she does; giving up the seat gives everything back to both.
    ask(&mut nobody, r#"{"type":"person","person":"ann"}"#);
    assert_eq!(told(&mut nobody, "sees", |_| true)["seats"], json!(["ground"]));
    assert_eq!(truth(&scan_of(&mut nobody)), 0);
    ask(&mut first, r#"{"type":"seat","id":2,"seat":"ground","person":"ann","action":"leave"}"#);
    assert_eq!(truth(&scan_of(&mut first)), 1);
    assert_eq!(truth(&scan_of(&mut second)), 1);
    server.stop();
}

#[test]
fn runs_of_one_name_can_all_be_opened() {
    let called = |id: &str| {
        let mut viewer = Viewer::new(1 << 16);
        viewer.set_id(id);
        viewer
    };
    let page = Page::new(called("filter-imm3"));
    let added: Vec<String> = ["filter-imm3", "other", "filter-imm3-2", "filter-imm3"]
        .map(|id| page.add(called(id)))
        .into();
    assert_eq!(added, ["filter-imm3-2", "other", "filter-imm3-2-2", "filter-imm3-3"]);
    page.with_all(|all| {
        for id in &added {
            let mut session = super::super::Session::default();
            session.open(all, std::slice::from_ref(id)).expect("there");
            let told = session.poll_runs(all);
            let shown = format!(r#""shown":["{id}"]"#);
            let list = |m: &super::super::Outgoing| matches!(m, super::super::Outgoing::Text(t) if t.contains(&shown));
            assert!(told.iter().any(list), "{id}: {told:?}");
        }
    });
}
