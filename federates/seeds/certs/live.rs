//! `seeds certs check DIR --live ENDPOINT`: each certificate against a running federation. A certificate that is refused looks
//! like a station that is not there, and a line that the access list lacks like silence: here they get a name.

use crate::runtime::access_list;
use crate::runtime::bus::{Bus as _, Class, ask};
use crate::runtime::certs::Certs;
use crate::runtime::clock::monotonic_ns;
use crate::runtime::codec::encode;
use crate::runtime::member::CONDUCTOR;
use crate::runtime::messages::{Fetch, FetchOf};
use crate::runtime::zenoh_bus::{Part, ZenohBus, ZenohConfig};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::time::Duration;

/// How long a connection may take, and what is to be heard or answered.
const WITHIN: Duration = Duration::from_secs(5);
const AGAIN: Duration = Duration::from_millis(100);
/// A question that is not to be answered is given up after this.
const REFUSED_WITHIN: Duration = Duration::from_secs(1);

/// What shows that the holder of a certificate is let do what it needs; all of it without effect on a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Needs {
    /// A key that it hears a few times a second.
    hears: Option<&'static str>,
    /// A key that answers it.
    asks: Option<&'static str>,
    /// A key that must not answer it.
    refused: Option<&'static str>,
}

/// By name.
fn needs(name: &str) -> Needs {
    let (hears, asks, refused) = match name {
        "operator" => (None, Some("ctl/statistics"), Some("log/conductor")),
        // It is asked where it listens itself.
        "agent" => (None, None, Some("ctl/statistics")),
        "viewer-logger" => (Some("obs/state"), Some("ctl/statistics"), Some("log/conductor")),
        "gateway" => (Some("obs/state"), Some("obs/state/last"), Some("ctl/statistics")),
        "recorder" => (Some("obs/state"), Some("obs/state/last"), Some("ctl/statistics")),
        "admin-station" | "admin-station-standby" | "router" => {
            (Some("ctl/beat"), Some("ctl/statistics"), None)
        }
        _ => (Some("ctl/beat"), Some("log/conductor"), Some("ctl/statistics")),
    };
    Needs { hears, asks, refused }
}

/// A question for nothing: of a federation that is not.
fn question(key: &str) -> Vec<u8> {
    match key {
        "log/conductor" => {
            let fetch = Fetch { fed: 0, inc: 0, from: 0, to: 0 };
            encode(&FetchOf { of: CONDUCTOR.to_owned(), fetch })
        }
        _ => Vec::new(),
    }
}

fn open(folder: &Path, name: &str, endpoint: &str, exercise: u8) -> Result<ZenohBus, String> {
    let config = ZenohConfig {
        part: Part::Peer,
        // Members hear each other directly: nobody passes on what is said to him.
        listen: vec!["tls/127.0.0.1:0".to_owned()],
        connect: vec![endpoint.to_owned()],
        exercise,
        connect_timeout: WITHIN,
        certs: Some(Certs::of(folder, name)?),
    };
    ZenohBus::open(&config).map_err(|e| e.to_string())
}

/// Tries `act` until `done`, for a while.
fn within(act: impl Fn(), done: impl Fn() -> bool) -> bool {
    let until = monotonic_ns() + WITHIN.as_nanos() as u64;
    loop {
        act();
        std::thread::sleep(AGAIN);
        if done() {
            return true;
        }
        if monotonic_ns() > until {
            return false;
        }
    }
}

/// Whether something comes at `key` by itself or because of `act`.
fn hears(bus: &ZenohBus, key: &str, act: impl Fn()) -> bool {
    let heard = Arc::new(AtomicBool::new(false));
    let mark = Arc::clone(&heard);
    let listening = bus.subscribe(key, Box::new(move |_, _| mark.store(true, SeqCst)));
    listening.is_ok() && within(act, || heard.load(SeqCst))
}

fn answered(bus: &ZenohBus, key: &str, deadline: Duration) -> bool {
    ask(bus, key, question(key), deadline).is_ok_and(|answer| answer.is_some())
}

/// What one certificate is let do; faults.
fn tried(folder: &Path, name: &str, endpoint: &str, exercise: u8) -> Vec<String> {
    let bus = match open(folder, name, endpoint, exercise) {
        Ok(bus) => bus,
        Err(why) => return vec![format!("no connection: {why}")],
    };
    let Needs { hears: key, asks, refused } = needs(name);
    let mut faults = Vec::new();
    if let Some(key) = key.filter(|key| !hears(&bus, key, || {})) {
        faults.push(format!("it hears nothing at {key}: the access list at {endpoint} lacks it, or the exercise is another one"));
    }
    // Routes are learned in the first moments of a session.
    if let Some(key) = asks
        && !(0..5).any(|_| answered(&bus, key, WITHIN / 5))
    {
        faults.push(format!("it is not answered at {key}: the access list at {endpoint} lacks it, or the exercise is another one"));
    }
    if let Some(key) = refused.filter(|key| answered(&bus, key, REFUSED_WITHIN)) {
        faults.push(format!("it is answered at {key}, which is not for it: the access list at {endpoint} is not in force"));
    }
    // What members say reaches spectators.
    let member = refused == Some("ctl/statistics") && asks == Some("log/conductor");
    if member
        && faults.is_empty()
        && let Ok(viewer) = open(folder, "viewer-logger", endpoint, exercise)
    {
        let key = format!("obs/fed/{name}");
        // Nothing that anybody could take for figures.
        let say = || drop(bus.publish(&key, Class::Lossy, b"certs check".to_vec()));
        if !hears(&viewer, &key, say) {
            faults.push(format!("what it says at {key} does not reach the viewer-logger"));
        }
        viewer.close();
    }
    bus.close();
    faults
}

/// Faults by name, of those certificates in `folder` that have a role.
pub(super) fn check(
    folder: &Path,
    names: &[String],
    endpoint: &str,
    exercise: u8,
) -> Vec<(String, Vec<String>)> {
    let known = access_list::names(16, crate::federation::MOST_SMDFMS);
    let roles: Vec<&String> = names.iter().filter(|name| known.contains(name)).collect();
    std::thread::scope(|scope| {
        let tries: Vec<_> = roles
            .iter()
            .map(|name| (name, scope.spawn(move || tried(folder, name, endpoint, exercise))))
            .collect();
        let found = tries.into_iter().map(|(name, thread)| {
            let broken = |_| vec!["the check itself failed: a fault of SEEDS".to_owned()];
            ((**name).clone(), thread.join().unwrap_or_else(broken))
        });
        found.collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds::certs::make_in;

    /// A station as far as it speaks by itself, with the certificates in `folder`.
    fn station(folder: &Path, mute: &[&str]) -> (ZenohBus, String) {
        let port = datalink::free_port().expect("a port");
        let endpoint = format!("tls/127.0.0.1:{port}");
        let config = ZenohConfig {
            part: Part::Peer,
            listen: vec![endpoint.clone()],
            connect: vec![],
            exercise: 1,
            connect_timeout: WITHIN,
            certs: Some(Certs::of(folder, "admin-station").expect("there")),
        };
        let bus = ZenohBus::open(&config).expect("it listens");
        for key in ["ctl/statistics", "log/conductor", "obs/state/last"] {
            if !mute.contains(&key) {
                let handler = |request: crate::runtime::bus::Request| request.answer(vec![1]);
                bus.serve(key, Box::new(handler)).expect("served");
            }
        }
        (bus, endpoint)
    }

    #[test]
    fn what_a_refused_certificate_or_a_missing_rule_hides_is_named() {
        let own = std::env::temp_dir().join(format!("seeds-live-{}", std::process::id()));
        let (ours, others) = (own.join("ours"), own.join("others"));
        make_in(&ours).expect("made");
        make_in(&others).expect("made");
        let (bus, endpoint) = station(&ours, &["obs/state/last"]);
        let over = Arc::new(AtomicBool::new(false));
        let end = Arc::clone(&over);
        let speaks = std::thread::spawn(move || {
            while !end.load(SeqCst) {
                let _ = bus.publish("ctl/beat", Class::Lossy, vec![1]);
                let _ = bus.publish("obs/state", Class::Lossy, vec![1]);
                std::thread::sleep(AGAIN);
            }
            bus.close();
        });
        let names = ["gateway", "operator", "smdfm", "viewer-logger"].map(str::to_owned);
        let found = check(&ours, &names, &endpoint, 1);
        for (name, faults) in &found {
            let silent = faults.len() == 1 && faults[0].contains("not answered at obs/state/last");
            assert!(
                if name == "gateway" { silent } else { faults.is_empty() },
                "{name}: {faults:?}"
            );
        }
        let refused = check(&others, &names[1..3], &endpoint, 1);
        over.store(true, SeqCst);
        speaks.join().expect("it ends");
        let _ = std::fs::remove_dir_all(&own);
        assert_eq!((found.len(), refused.len()), (4, 2));
        for (name, faults) in &refused {
            assert!(
                faults.len() == 1 && faults[0].starts_with("no connection: "),
                "{name}: {faults:?}"
            );
        }
    }
}
