use super::*;
use crate::runtime::bus::Request;
use crate::runtime::local_bus::LocalHub;
use crate::runtime::messages::Welcome;
use crate::runtime::messages::{Accepted, AlertMessage, Answer, Operation, Outcome, RunState};
use crate::viewer_logger::log::tests::Folder;
use crate::viewer_logger::tests::{scan, weather};
use models::control::alert::{AlertKind, Change, Stage};
use models::frames::Point2;
use std::path::Path;
use std::thread;

fn scene() -> Arc<Scene> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/zurich.toml");
    Arc::new(scenarios::load(&file).expect("the scene is sound"))
}

fn task(files: Files, page: bool) -> Task {
    Task {
        name: "viewer-logger".to_owned(),
        page: page.then(|| "127.0.0.1:0".parse().expect("address")),
        files,
        patience: Duration::from_secs(5),
        endpoint: "this process".to_owned(),
    }
}

/// A conductor as far as a spectator can tell: takes joins and commands, serves the last state.
fn conductor(hub: &LocalHub, welcome: Welcome) -> Arc<dyn Bus> {
    let bus: Arc<dyn Bus> = Arc::new(hub.join());
    let answer = move |request: Request| request.answer(encode(&welcome));
    bus.serve("ctl/join", Box::new(answer)).expect("served");
    let frozen = RunState { run: 1, phase: Phase::Frozen, ..RunState::default() };
    let done = Answer { ok: true, text: "FROZEN at frame 40".to_owned(), state: frozen };
    let answer = move |request: Request| request.answer(encode(&done));
    bus.serve("ctl/command", Box::new(answer)).expect("served");
    let weather = encode(&weather(10.0));
    let answer = move |request: Request| request.answer(weather.clone());
    bus.serve("obs/weather/last", Box::new(answer)).expect("served");
    bus.announce("alive/admin-station/1").expect("announced");
    bus
}

fn state(phase: Phase) -> Vec<u8> {
    encode(&RunState { run: 1, phase, seed: 1, ..RunState::default() })
}

fn rows(file: &Path, question: &str) -> i64 {
    let reader = rusqlite::Connection::open(file).expect("a database");
    reader.query_row(question, [], |row| row.get(0)).expect(question)
}

#[test]
fn a_spectator_keeps_the_run_shows_it_and_leaves_with_it() {
    let (folder, hub) = (Folder::new(), LocalHub::default());
    let files = Files::beside(&folder.0.join("x.pcapng"));
    let admin = conductor(
        &hub,
        Welcome::Accepted(Box::new(Accepted { fed: 1, inc: 3, orders: 0, enter: None, epoch: 0 })),
    );
    let (bus, inbox, scene) = (Arc::new(hub.join()), Inbox::default(), scene());
    let (told, page) = bounded(1);
    let (sent, task_of) = (inbox.clone(), task(files.clone(), true));
    let viewer = thread::spawn(move || {
        run(&task_of, scene, bus, sent, |server| {
            told.send(server.map(Server::address)).expect("told");
        })
    });
    let told = page.recv_timeout(Duration::from_secs(20)).expect("it joins");
    let address = told.expect("the page's address");
    let send = |key: &str, body: Vec<u8>| admin.publish(key, Class::Lossy, body).expect("sent");
    send("obs/state", state(Phase::Running));
    for n in 1..=3 {
        send("tracks/1/scan", encode(&scan(n)));
    }
    send(
        "obs/operation",
        encode(&Operation { command: "freeze".to_owned(), ..Operation::default() }),
    );
    send("tracks/1/scan", b"no message".to_vec());
    let here = SocketAddr::from(([127, 0, 0, 1], 3000));
    let datagram = Datagram { utc_ns: 5, from: here, to: here, octets: Box::new([7, 1, 2]) };
    inbox.datagrams(vec![datagram.clone(), datagram]);

    // A command from the page reaches the conductor and comes back with its answer.
    let uri = format!("ws://{address}/socket").parse().expect("a URI");
    let from_page = tungstenite::ClientRequestBuilder::new(uri)
        .with_header("Origin", format!("http://{address}"));
    let mut socket = tungstenite::connect(from_page).expect("open").0;
    let freeze = r#"{"type":"command","id":1,"command":"freeze"}"#;
    socket.send(tungstenite::Message::text(freeze)).expect("sent");
    let answer = loop {
        let message = socket.read().expect("an answer");
        if let Ok(text) = message.to_text()
            && text.contains(r#""type":"reply""#)
        {
            break text.to_owned();
        }
    };
    assert!(answer.contains("FROZEN at frame 40"), "{answer}");

    send("obs/state", state(Phase::Stopped));
    for (run, digest) in [(1, "00ff"), (2, "1234")] {
        let facts = vec![("digest".to_owned(), digest.to_owned())];
        send("obs/outcome", encode(&Outcome { run, facts }));
    }
    admin.close();
    let kept = viewer.join().expect("no panic").expect("no error").expect("joined");
    let databases = kept.databases.clone();
    let expected = Kept { scans: 3, scans_lost: 0, datagrams: 2, datagrams_lost: 0, databases };
    assert_eq!(kept, expected);
    let database = files.database.expect("a database");
    for (question, answer) in [
        ("SELECT count(*) FROM scans", 3),
        ("SELECT count(*) FROM operations WHERE command = 'freeze'", 1),
        ("SELECT count(*) FROM states", 2),
        ("SELECT count(*) FROM run WHERE name = 'digest' AND value = '00ff'", 1),
        ("SELECT count(*) FROM weather WHERE rain_mm_per_h = 10", 1),
        ("SELECT count(*) FROM federates WHERE name = 'viewer-logger' LIMIT 1", 1),
    ] {
        assert_eq!(rows(&database, question).min(answer), answer, "{question}");
    }
}

#[test]
fn nobody_there_and_a_refusal_are_said_in_one_line() {
    let hub = LocalHub::default();
    let mut alone = task(Files::default(), false);
    alone.patience = Duration::from_millis(100);
    let lonely = run(&alone, scene(), Arc::new(hub.join()), Inbox::default(), |_| {});
    let text = format!("{:#}", lonely.expect_err("nobody there"));
    assert!(
        text.contains("no administration station") && text.contains("--sync-connect"),
        "{text}"
    );
    let _admin = conductor(&hub, Welcome::Refused("another scene".to_owned()));
    let refused = run(&alone, scene(), Arc::new(hub.join()), Inbox::default(), |_| {});
    let text = format!("{:#}", refused.expect_err("refused"));
    assert!(text.contains("another scene") && !text.contains('\n'), "{text}");
}

#[test]
fn a_full_inbox_loses_and_counts_but_never_blocks() {
    let inbox = Inbox::default();
    let here = SocketAddr::from(([127, 0, 0, 1], 3000));
    let one = Datagram { utc_ns: 5, from: here, to: here, octets: Box::new([7]) };
    for _ in 0..WAITING + 10 {
        inbox.datagrams(vec![one.clone()]);
    }
    assert_eq!(inbox.lost.load(Ordering::Relaxed), 10);
}

#[test]
fn alerts_that_stand_are_asked_for_at_the_start() {
    let told = vec![AlertMessage {
        run: 1,
        time_ns: 0,
        change: Change::Raised,
        id: 5,
        kind: AlertKind::RunwayOpposite,
        stage: Stage::Alarm,
        subjects: "7".into(),
        since_ns: 0,
        asterix: 11,
        place_m: Point2::origin(),
        number: 9,
    }];
    let hub = LocalHub::default();
    let (control, octets) = (hub.join(), encode(&told));
    let answer = move |request: Request| request.answer(octets.clone());
    control.serve("control/1/alerts/last", Box::new(answer)).expect("served");
    let inbox = Inbox::default();
    last_values(&hub.join(), &inbox).expect("asked");
    let heard = inbox.receive.try_recv();
    let Ok(Event::Heard(Heard::Alerts(heard))) = heard else { panic!("no alerts") };
    assert_eq!(heard, told);
}
