//! The public plane: a second Zenoh session that knows nothing of the private one.
//!
//! Keys are `seeds-v1/{exercise}/…`. What is published is encoded only while somebody subscribes; every key answers a query with its
//! last value. A subscriber that does not read loses messages; nobody waits for it.

use super::board::{Board, KEYS};
use super::commands::{self, LONGEST, Rights};
use super::public::VERSION;
use crate::runtime::bus::BusError;
use crate::runtime::certs::{self, Certs};
use crossbeam_channel::{Sender, TrySendError, bounded};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;
use zenoh::bytes::Encoding;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;
use zenoh::query::Query;
use zenoh::{Config, Session, Wait};

/// Where clients connect when a gateway runs.
pub const DEFAULT_ENDPOINT: &str = "tcp/127.0.0.1:7448";

/// Commands that may wait for their turn.
const COMMANDS: usize = 16;
/// How long the last message may be on its way before the session ends.
const LAST_WORDS: Duration = Duration::from_millis(100);
/// Federates that are published.
const FEDERATES: usize = 64;

/// The public plane's endpoint, and who may command there.
#[derive(Clone, Debug)]
pub struct PublicConfig {
    /// Endpoint that clients connect to.
    pub endpoint: String,
    /// Somebody asked for it; else a port that is taken is no failure.
    pub asked: bool,
    /// DIS exercise.
    pub exercise: u8,
    /// What proves who both ends are; beyond this host it must be there.
    pub certs: Option<Certs>,
    /// Who may command.
    pub rights: Rights,
}

impl PublicConfig {
    /// Whether the endpoint may be opened.
    ///
    /// # Errors
    /// If it can be reached from other hosts and nothing protects it.
    pub fn check(endpoint: &str, certs: bool) -> Result<(), String> {
        let plain = endpoint.starts_with("tcp/");
        if plain && certs::is_loopback(endpoint) {
            return Ok(());
        }
        if !plain && !endpoint.starts_with("tls/") {
            return Err(format!(
                "--public {endpoint}: an endpoint is tcp/ADDR:PORT or tls/ADDR:PORT"
            ));
        }
        match (plain, certs) {
            (false, true) => Ok(()),
            _ => Err(format!(
                "--public {endpoint}: beyond this host clients need certificates: tls/{} with --certs DIR (`seeds certs DIR` makes them)",
                endpoint.split_once('/').map_or(endpoint, |(_, place)| place)
            )),
        }
    }
}

/// An open public plane.
pub struct PublicPlane {
    session: Session,
    board: Arc<Board>,
    prefix: String,
    publishers: BTreeMap<String, Publisher<'static>>,
    /// Messages published.
    pub published: u64,
}

impl PublicPlane {
    /// Opens the session and answers queries.
    ///
    /// # Errors
    /// If the endpoint is malformed or taken.
    pub fn open(config: &PublicConfig, board: Arc<Board>) -> Result<Self, BusError> {
        let refuse = |reason: String| BusError::Open {
            doing: format!("opening the public plane at {}", config.endpoint),
            reason,
        };
        let mut zenoh = Config::default();
        for (key, value) in settings(config) {
            zenoh
                .insert_json5(key, &value.to_string())
                .map_err(|e| refuse(format!("setting {key}: {e}")))?;
        }
        let session = zenoh::open(zenoh).wait().map_err(|e| {
            refuse(format!("{e}: end the program that uses it, or choose another with --public tcp/127.0.0.1:PORT"))
        })?;
        let prefix = format!("seeds-v{VERSION}/{}", config.exercise);
        let mut plane = Self { session, board, prefix, publishers: BTreeMap::new(), published: 0 };
        for key in KEYS {
            plane.declare(key).map_err(|e| refuse(e.to_string()))?;
        }
        plane.serve(config.rights.clone()).map_err(|e| refuse(e.to_string()))?;
        Ok(plane)
    }

    fn declare(&mut self, key: &str) -> Result<(), zenoh::Error> {
        let publisher = self
            .session
            .declare_publisher(format!("{}/{key}", self.prefix))
            .congestion_control(CongestionControl::Drop)
            .encoding(Encoding::APPLICATION_JSON)
            .express(true)
            .wait()?;
        self.publishers.insert(key.to_owned(), publisher);
        Ok(())
    }

    fn serve(&self, rights: Rights) -> Result<(), zenoh::Error> {
        let (ask, asked) = bounded::<Query>(COMMANDS);
        let board = Arc::clone(&self.board);
        let named = std::thread::Builder::new().name("commands".into());
        named.spawn(move || {
            for query in asked {
                let octets = query.payload().map(|p| p.to_bytes().into_owned()).unwrap_or_default();
                let (answered, reached) = commands::carry_out(&octets, &rights);
                if let Some(state) = reached {
                    board.on_state(state);
                }
                reply(&query, &commands::answer(&answered, board.value("state")));
            }
        })?;
        let (prefix, board) = (self.prefix.clone(), Arc::clone(&self.board));
        self.session
            .declare_queryable(format!("{prefix}/**"))
            .callback(move |query| on_query(query, &prefix, &board, &ask))
            .background()
            .wait()
    }

    /// Publishes the last value of a key, if somebody listens.
    pub fn publish(&mut self, key: &str) {
        if !self.publishers.contains_key(key)
            && (self.publishers.len() >= KEYS.len() + FEDERATES || self.declare(key).is_err())
        {
            return;
        }
        let Some(publisher) = self.publishers.get(key) else { return };
        let heard = publisher.matching_status().wait().is_ok_and(|status| status.matching());
        if heard && let Some(value) = self.board.value(key) {
            self.published += 1;
            if let Err(error) = publisher.put(value.to_string()).wait() {
                tracing::debug!(%error, "a public message was not published");
            }
        }
    }

    /// Leaves.
    pub fn close(self) {
        let (done, wait) = bounded(1);
        let session = self.session.clone();
        drop(self.publishers);
        // The end of a session may overtake what was published last: the end of the run.
        if self.published > 0 {
            std::thread::sleep(LAST_WORDS);
        }
        std::thread::spawn(move || {
            done.send(session.close().wait().is_ok()).ok();
        });
        wait.recv_timeout(Duration::from_millis(500)).ok();
    }
}

fn on_query(query: Query, prefix: &str, board: &Board, ask: &Sender<Query>) {
    let wanted = query.key_expr().clone();
    if wanted.as_str() == format!("{prefix}/command") {
        let long = query.payload().is_some_and(|p| p.len() > LONGEST);
        if long {
            let (answered, _) =
                commands::carry_out(&vec![0; LONGEST + 1], &Rights::ReadOnly(String::new()));
            return reply(&query, &commands::answer(&answered, None));
        }
        if let Err(TrySendError::Full(query) | TrySendError::Disconnected(query)) =
            ask.try_send(query)
        {
            let text = "too many commands at once: ask again";
            reply(
                &query,
                &json!({"schema": format!("seeds.answer/{VERSION}"), "ok": false, "text": text}),
            );
        }
        return;
    }
    let keys = KEYS.iter().map(|key| (*key).to_owned()).chain(["schema".to_owned()]);
    let federates = board.federates().into_iter().map(|name| format!("federate/{name}"));
    for key in keys.chain(federates) {
        let whole = format!("{prefix}/{key}");
        let Ok(expression) = zenoh::key_expr::KeyExpr::try_from(whole) else { continue };
        if wanted.intersects(&expression)
            && let Some(value) = board.value(&key)
        {
            answer(&query, expression, &value);
        }
    }
}

fn reply(query: &Query, value: &Value) {
    answer(query, query.key_expr().clone(), value);
}

fn answer(query: &Query, key: zenoh::key_expr::KeyExpr<'static>, value: &Value) {
    let sent = query.reply(key, value.to_string()).encoding(Encoding::APPLICATION_JSON).wait();
    if let Err(error) = sent {
        tracing::debug!(%error, "an answer found no way back");
    }
}

/// What the session is made with: it listens, connects to nobody, and takes nothing that is long.
fn settings(config: &PublicConfig) -> Vec<(&'static str, Value)> {
    let mut settings = vec![
        ("mode", json!("peer")),
        ("listen/endpoints", json!([config.endpoint])),
        ("connect/endpoints", json!([])),
        ("listen/timeout_ms", json!(0)),
        ("listen/exit_on_failure", json!(true)),
        ("scouting/multicast/enabled", json!(false)),
        ("scouting/gossip/enabled", json!(false)),
        ("transport/link/tx/lease", json!(2000)),
        ("transport/link/rx/max_message_size", json!(4 * LONGEST)),
        ("queries_default_timeout", json!(12_000)),
    ];
    if let Some(certs) = &config.certs {
        settings.push(("transport/link/tls", certs.of_links()));
        settings.push(("access_control", access_control(config.exercise)));
    }
    settings
}

/// Everybody with a certificate of the federation may look; who has the operator's may command.
fn access_control(exercise: u8) -> Value {
    let key = |name: &str| format!("seeds-v{VERSION}/{exercise}/{name}");
    let mut public: Vec<String> = KEYS.iter().map(|name| key(name)).collect();
    public.extend([key("federate/*"), key("schema")]);
    let rule = |id: &str, keys: &[String], flows: &[&str], messages: &[&str]| json!({"id": id, "permission": "allow", "flows": flows, "messages": messages, "key_exprs": keys});
    let command = [key("command")];
    json!({
        "enabled": true,
        "default_permission": "deny",
        "rules": [
            rule("look", &public, &["ingress"], &["declare_subscriber", "query"]),
            rule("show", &public, &["egress"], &["put", "reply", "declare_queryable"]),
            rule("serve", &[key("**")], &["egress"], &["declare_queryable"]),
            rule("command", &command, &["ingress"], &["query"]),
            rule("answer", &command, &["egress"], &["reply"]),
        ],
        "subjects": [{"id": "everybody"}, {"id": "operator", "cert_common_names": ["operator"]}],
        "policies": [
            {"rules": ["look", "show", "serve"], "subjects": ["everybody"]},
            {"rules": ["command", "answer"], "subjects": ["operator"]},
        ],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beyond_this_host_certificates_are_needed() {
        for (endpoint, certs, allowed) in [
            ("tcp/127.0.0.1:7448", false, true),
            ("tcp/127.0.0.1:7448", true, true),
            ("tcp/localhost:7448", false, true),
            ("tcp/0.0.0.0:7448", false, false),
            ("tcp/192.0.2.1:7448", true, false),
            ("tls/192.0.2.1:7448", true, true),
            ("tls/192.0.2.1:7448", false, false),
            ("udp/127.0.0.1:7448", false, false),
            ("127.0.0.1:7448", false, false),
        ] {
            let checked = PublicConfig::check(endpoint, certs);
            assert_eq!(checked.is_ok(), allowed, "{endpoint} {certs}: {checked:?}");
        }
    }
}
