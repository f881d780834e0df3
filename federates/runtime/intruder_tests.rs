//! Intruders on the synchronisation plane, over real sessions: without a certificate, with one of another authority,
//! and a member that says what is not its own to say.

use super::bus::{Bus, Class, ask};
use super::certs::Certs;
use super::codec::{decode, encode};
use super::messages::{Order, Report};
use super::zenoh_bus::{Part, ZenohBus, ZenohConfig};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use zenoh::Wait;

/// A folder with certificates that goes with its value.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("seeds-tls-{}-{number}", std::process::id()));
        crate::seeds::certs::make_in(&path).expect("certificates");
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn free_port() -> u16 {
    datalink::free_port().expect("a free port")
}

fn open(certs: Option<&Path>, name: &str, listen: &str, connect: Option<&str>) -> ZenohBus {
    let config = ZenohConfig {
        part: Part::Peer,
        listen: vec![listen.to_owned()],
        connect: connect.into_iter().map(str::to_owned).collect(),
        exercise: 1,
        connect_timeout: Duration::from_secs(20),
        certs: certs.map(|folder| Certs::of(folder, name).expect("certificates")),
    };
    ZenohBus::open(&config).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// What somebody heard: keys and octets.
#[derive(Clone, Default)]
struct Ear(Arc<Mutex<Heard>>);

type Heard = Vec<(String, Vec<u8>)>;

impl Ear {
    fn at(bus: &ZenohBus, pattern: &str) -> Self {
        let ear = Self::default();
        let heard = ear.clone();
        let sink = move |key: &str, body: &[u8]| {
            heard.0.lock().expect("sound").push((key.to_owned(), body.to_vec()));
        };
        bus.subscribe(pattern, Box::new(sink)).expect("subscribed");
        ear
    }

    fn heard(&self, key: &str, body: &[u8]) -> bool {
        self.0.lock().expect("sound").iter().any(|(k, b)| k == key && b == body)
    }
}

/// Does `act` again and again until `done`, for at most half a minute.
fn until(what: &str, mut act: impl FnMut(), mut done: impl FnMut() -> bool) {
    for _ in 0..600 {
        act();
        std::thread::sleep(Duration::from_millis(50));
        if done() {
            return;
        }
    }
    panic!("not within half a minute: {what}");
}

fn say(bus: &ZenohBus, key: &str, body: &[u8]) {
    bus.publish(key, Class::Must, body.to_vec()).expect("published");
}

/// Messages with which one would end, wedge or hurry a run.
fn forgeries() -> Vec<Vec<u8>> {
    let orders = [
        Order::Exit { code: 0 },
        Order::Finish { run: 1, frame: 0 },
        Order::Grant { run: 1, upto: u64::MAX },
    ];
    orders.iter().map(encode).collect()
}

#[test]
fn a_member_speaks_for_itself_only_and_a_spectator_for_nobody() {
    let certs = Folder::new();
    let at = format!("tls/127.0.0.1:{}", free_port());
    let join = |name: &str| open(Some(&certs.0), name, "tls/127.0.0.1:0", Some(&at));
    let station = open(Some(&certs.0), "admin-station", &at, None);
    let (generator, smdfm) = (join("traffic-generator"), join("smdfm"));
    let viewer = join("viewer-logger");
    let reports = Ear::at(&station, "fed/*");
    let (orders, ends) = (Ear::at(&smdfm, "ctl/order"), Ear::at(&smdfm, "fed/*"));
    let tracks = Ear::at(&viewer, "tracks/1/scan");
    let (state, too_much) = (Ear::at(&viewer, "obs/state"), Ear::at(&viewer, "**"));
    let figures = Ear::at(&viewer, "obs/fed/*");
    let alive = Ear::default();
    let tokens = alive.clone();
    let seen = move |key: &str, _| tokens.0.lock().expect("sound").push((key.to_owned(), vec![]));
    station.watch("alive/*/*", Box::new(seen)).expect("watched");
    let answer = |bus: &ZenohBus, key: &str| {
        bus.serve(key, Box::new(|request| request.answer(b"yes".to_vec()))).expect("served");
    };
    answer(&station, "ctl/command");
    answer(&generator, "frames/traffic-generator");

    // What each may say reaches those who may hear it.
    let grant = encode(&Order::Grant { run: 1, upto: 7 });
    until("an order", || say(&station, "ctl/order", &grant), || orders.heard("ctl/order", &grant));
    let own = "fed/traffic-generator";
    until(
        "a report",
        || say(&generator, own, b"1"),
        || reports.heard(own, b"1") && ends.heard(own, b"1"),
    );
    until("tracks", || say(&smdfm, "tracks/1/scan", b"2"), || tracks.heard("tracks/1/scan", b"2"));
    until("the state", || say(&station, "obs/state", b"3"), || state.heard("obs/state", b"3"));
    smdfm.announce("alive/smdfm/1").expect("announced");
    until("a token", || {}, || alive.heard("alive/smdfm/1", b""));
    let asks = |bus: &ZenohBus, key: &str| {
        ask(bus, key, vec![], Duration::from_secs(2)).expect("asked").is_some()
    };
    until("a repair", || {}, || asks(&smdfm, "frames/traffic-generator"));
    until("a command of the page", || {}, || asks(&viewer, "ctl/command"));

    // What is not theirs to say reaches nobody. (What somebody says himself, his own session hears.)
    let failed = encode(&Report::Failed { reason: "forged".into() });
    for forger in [&generator, &viewer] {
        for forged in forgeries() {
            say(forger, "ctl/order", &forged);
        }
        for _ in 0..10 {
            say(forger, "fed/smdfm", &failed);
        }
        let _ = forger.announce("alive/smdfm/9");
    }
    for _ in 0..10 {
        say(&generator, "tracks/1/scan", b"forged");
        say(&generator, "obs/state", b"forged");
    }
    let last = "obs/fed/traffic-generator";
    until(
        "the generator's figures",
        || say(&generator, last, b"end"),
        || figures.heard(last, b"end"),
    );
    // What they say last, and may say, has arrived: so would all before it.
    until(
        "the last of the generator",
        || say(&generator, own, b"end"),
        || reports.heard(own, b"end") && ends.heard(own, b"end"),
    );
    let own = "fed/viewer-logger";
    until(
        "the last of the viewer",
        || say(&viewer, own, b"end"),
        || reports.heard(own, b"end") && ends.heard(own, b"end"),
    );
    for forged in forgeries() {
        assert!(!orders.heard("ctl/order", &forged), "{:?}", decode::<Order>(&forged));
    }
    for ear in [&reports, &ends] {
        assert!(!ear.heard("fed/smdfm", &failed), "a report in another's name");
    }
    assert!(!tracks.heard("tracks/1/scan", b"forged") && !state.heard("obs/state", b"forged"));
    assert!(!alive.heard("alive/smdfm/9", b""), "a token in another's name");
    assert!(!asks(&generator, "ctl/command"), "a member commands nothing");
    for (key, body) in too_much.0.lock().expect("sound").iter() {
        let own = key == "fed/viewer-logger" || forgeries().contains(body) || *body == failed;
        let must = key.starts_with("ctl/") || key.starts_with("fed/");
        assert!(own || !must, "a spectator hears what must arrive: {key}");
    }
    for bus in [viewer, smdfm, generator, station] {
        bus.close();
    }
}

/// A session of somebody else's program, which connects to `endpoint`.
fn stranger(endpoint: &str, tls: serde_json::Value) -> Option<zenoh::Session> {
    let mut config = zenoh::Config::default();
    for (key, value) in [
        ("mode", "\"client\"".to_owned()),
        ("connect/endpoints", format!("[{endpoint:?}]")),
        ("connect/timeout_ms", "1500".to_owned()),
        ("connect/exit_on_failure", "true".to_owned()),
        ("scouting/multicast/enabled", "false".to_owned()),
        ("transport/link/tls", tls.to_string()),
    ] {
        config.insert_json5(key, &value).unwrap_or_else(|e| panic!("{key}: {e}"));
    }
    zenoh::open(config).wait().ok()
}

#[test]
fn whoever_has_no_certificate_of_the_federation_reaches_nobody() {
    let (certs, other) = (Folder::new(), Folder::new());
    let port = free_port();
    let at = format!("tls/127.0.0.1:{port}");
    let station = open(Some(&certs.0), "admin-station", &at, None);
    let member = open(Some(&certs.0), "smdfm", "tls/127.0.0.1:0", Some(&at));
    let (orders, reports) = (Ear::at(&member, "ctl/order"), Ear::at(&station, "fed/*"));
    let of = |folder: &Path, name: &str| {
        let file = |ending: &str| folder.join(format!("{name}.{ending}"));
        serde_json::json!({
            "root_ca_certificate": certs.0.join("authority.pem"),
            "connect_certificate": file("pem"),
            "connect_private_key": file("key"),
        })
    };
    let nobody = serde_json::json!({ "root_ca_certificate": certs.0.join("authority.pem") });
    for (who, endpoint, tls) in [
        ("plain TCP on the TLS port", format!("tcp/127.0.0.1:{port}"), nobody.clone()),
        ("no certificate", at.clone(), nobody),
        ("another authority", at.clone(), of(&other.0, "admin-station")),
    ] {
        let Some(session) = stranger(&endpoint, tls) else { continue };
        for forged in forgeries() {
            session
                .put("seeds/1/ctl/order", forged)
                .wait()
                .unwrap_or_else(|e| panic!("{who}: {e}"));
        }
        let failed = encode(&Report::Failed { reason: "forged".into() });
        let _ = session.put("seeds/1/fed/smdfm", failed).wait();
        std::thread::sleep(Duration::from_millis(500));
        let _ = session.close().wait();
    }
    let last = encode(&Order::Grant { run: 1, upto: 1 });
    until("an order", || say(&station, "ctl/order", &last), || orders.heard("ctl/order", &last));
    for forged in forgeries() {
        assert!(!orders.heard("ctl/order", &forged), "{:?}", decode::<Order>(&forged));
    }
    assert!(reports.0.lock().expect("sound").is_empty());
    member.close();
    station.close();
}

#[test]
fn messages_beyond_their_bound_do_not_arrive() {
    let at = format!("tcp/127.0.0.1:{}", free_port());
    let station = open(None, "admin-station", &at, None);
    let member = open(None, "smdfm", "tcp/127.0.0.1:0", Some(&at));
    let (orders, reports) = (Ear::at(&station, "ctl/order"), Ear::at(&station, "fed/*"));
    let longest = |ear: &Ear| ear.0.lock().expect("sound").iter().map(|(_, b)| b.len()).max();
    until(
        "an order",
        || say(&member, "ctl/order", &vec![1; 60_000]),
        || longest(&orders) == Some(60_000),
    );
    say(&member, "ctl/order", &vec![1; 70_000]);
    until(
        "a report",
        || say(&member, "fed/smdfm", &vec![1; 4 << 20]),
        || longest(&reports) == Some(4 << 20),
    );
    say(&member, "fed/smdfm", &vec![1; (8 << 20) + 4096]);
    until("the last", || say(&member, "fed/end", b"1"), || reports.heard("fed/end", b"1"));
    assert_eq!(longest(&orders), Some(60_000));
    assert_eq!(longest(&reports), Some(4 << 20));
    member.close();
    station.close();
}
