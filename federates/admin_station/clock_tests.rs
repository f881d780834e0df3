//! The station as a process hears the clocks of other hosts: a member of another host tells its time in its beats.

use super::{AdminContext, Event};
use crate::runtime::bus::{Bus, Class, ask};
use crate::runtime::clock::utc_ns;
use crate::runtime::codec::{decode, encode};
use crate::runtime::conductor::ConductorConfig;
use crate::runtime::local_bus::LocalHub;
use crate::runtime::messages::{Beat, Hello, Kind, Welcome};
use crossbeam_channel::unbounded;
use scenarios::losses::Losses;
use std::sync::Arc;
use std::time::Duration;

pub(super) fn config() -> ConductorConfig {
    ConductorConfig {
        scene: "toy".into(),
        scene_hash: 1,
        version: "v".into(),
        expected: vec!["smdfm".into(), "external-world".into()],
        producers: vec!["external-world".into()],
        optional: Vec::new(),
        generators: 1,
        seed: 7,
        step_ns: 50_000_000,
        start_utc_ns: 0,
        last_frame: 1_000,
        rate: 1.0,
        autostart: true,
        batch: false,
        await_spectators: Vec::new(),
        await_spectators_ns: 0,
        window: 8,
        closes: None,
        front_ends: std::collections::BTreeMap::new(),
        through_router: false,
        fed: 7,
        losses: Losses::default(),
    }
}

/// What a station says of the clocks when a member on host "b", `ahead_ms` ahead, beats for two seconds in the name of federation `fed`.
fn alarms(ahead_ms: i64, fed: u128) -> Vec<String> {
    let hub = LocalHub::default();
    let station = Arc::new(hub.join());
    let events = unbounded();
    let stop = events.0.clone();
    let context = AdminContext {
        name: super::STATION,
        succeeds: None,
        journal: None,
        balance: false,
        refused: Arc::default(),
        bus: station,
        config: config(),
        events,
        reached: Box::new(|_, _, _| {}),
        stated: Box::new(|_| {}),
        closed: Box::new(|_| {}),
        progress: None,
        patience: Duration::from_secs(9),
    };
    let running = std::thread::spawn(move || super::run(context));
    let member = hub.join();
    let hello = encode(&Hello {
        name: "smdfm".into(),
        kind: Kind::Smdfm,
        pid: 1,
        host: "b".into(),
        version: "v".into(),
        scene_hash: 1,
        instance: 1,
        was: None,
    });
    let within = Duration::from_millis(500);
    let answer = (0..20).find_map(|_| {
        let answer = ask(&member, "ctl/join", hello.clone(), within).expect("a bus");
        std::thread::sleep(Duration::from_millis(20));
        answer
    });
    let welcome = decode(&answer.expect("it answers")).expect("a welcome");
    let Welcome::Accepted(accepted) = welcome else { panic!("{welcome:?}") };
    for _ in 0..22 {
        let utc_ns = utc_ns() + ahead_ms * 1_000_000;
        let beat = Beat { fed, inc: accepted.inc, utc_ns, ..Beat::default() };
        member.publish("beat/smdfm", Class::Lossy, encode(&beat)).expect("said");
        std::thread::sleep(Duration::from_millis(100));
    }
    let answer = ask(&member, "ctl/statistics", Vec::new(), within).expect("a bus");
    let statistics: serde_json::Value =
        serde_json::from_slice(&answer.expect("statistics")).expect("JSON");
    let _ = stop.send(Event::Stop);
    running.join().expect("it ends").expect("a bus");
    let alarms = statistics["federates"]["admin-station"]["alarms"].as_array().expect("alarms");
    alarms.iter().filter_map(|a| a.as_str()).map(str::to_owned).collect()
}

#[test]
fn a_host_whose_clock_is_off_is_among_the_alarms_of_the_station() {
    let told = alarms(3_000, 7);
    assert!(told.len() == 1 && told[0].contains("the clock of host b is 3.0 s ahead"), "{told:?}");
    assert_eq!(alarms(30, 7), Vec::<String>::new(), "as clocks are");
    assert_eq!(alarms(3_000, 8), Vec::<String>::new(), "another federation's word");
}
