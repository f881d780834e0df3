//! The bus over Eclipse Zenoh: peer mode, explicit endpoints, gossip on, no server; or clients of one router.
//!
//! With certificates, every link is mutual TLS and [`super::access_list`] is enforced at both of its ends. Messages are
//! bounded either way: `max_message_size` of the library is no exact bound, its low-pass filter is.
//!
//! One endpoint is enough to know of: the administration station listens, everybody connects to it,
//! and gossip makes the peers connect directly to each other. Scouting by multicast is off.

use super::bus::{AliveSink, Bus, BusError, Class, Replies, Request, Sink};
use super::certs::Certs;
use serde_json::{Value, json};
use std::sync::Mutex;
use std::time::Duration;
use zenoh::qos::CongestionControl;
use zenoh::sample::SampleKind;
use zenoh::{Config, Session, Wait};

/// What a session is to the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Connects to everybody whom it learns of, and passes nothing on.
    Peer,
    /// Speaks with everybody through the router that it connects to.
    Client,
    /// Passes on what its clients say.
    Router,
}

/// How to find the others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ZenohConfig {
    /// Endpoints to listen on ("tcp/127.0.0.1:7447").
    pub listen: Vec<String>,
    /// Endpoints to connect to.
    pub connect: Vec<String>,
    /// DIS exercise, which separates federations.
    pub exercise: u8,
    /// How long to try to connect.
    pub connect_timeout: Duration,
    /// What proves who this is; without it anybody who connects is believed.
    pub certs: Option<Certs>,
    /// What it is to the others.
    pub part: Part,
}

/// A session of the federation.
pub struct ZenohBus {
    session: Session,
    prefix: String,
    tokens: Mutex<Vec<zenoh::liveliness::LivelinessToken>>,
}

impl ZenohBus {
    /// Opens the session: listens, connects, and returns when connected.
    ///
    /// # Errors
    /// If an endpoint is malformed, taken, or not reachable within the time-out.
    pub fn open(config: &ZenohConfig) -> Result<Self, BusError> {
        let doing = || match (&config.listen[..], &config.connect[..]) {
            (listen, []) => format!("listening on {}", listen.join(", ")),
            (_, connect) => format!("connecting to {}", connect.join(", ")),
        };
        let open = |reason: String| BusError::Open { doing: doing(), reason };
        let list = |endpoints: &[String]| {
            let quoted: Vec<_> = endpoints.iter().map(|e| format!("{e:?}")).collect();
            format!("[{}]", quoted.join(","))
        };
        let mode = match config.part {
            Part::Peer => "\"peer\"",
            Part::Client => "\"client\"",
            Part::Router => "\"router\"",
        };
        let mut zenoh = Config::default();
        let timeout_ms = config.connect_timeout.as_millis().to_string();
        for (key, value) in [
            ("mode", mode),
            ("listen/endpoints", &list(&config.listen)),
            ("connect/endpoints", &list(&config.connect)),
            ("connect/timeout_ms", &timeout_ms),
            ("connect/exit_on_failure", "true"),
            ("listen/timeout_ms", "0"),
            ("listen/exit_on_failure", "true"),
            ("scouting/multicast/enabled", "false"),
            ("scouting/gossip/enabled", "true"),
            ("transport/link/tx/lease", "2000"),
            // Who connects and says nothing has a place for 4 s, not 10, and takes one of 400, not of 100.
            ("transport/unicast/accept_pending", "400"),
            ("transport/unicast/accept_timeout", "4000"),
            // A receiver that stands still holds a sender for at most half a second.
            ("transport/link/tx/queue/congestion_control/block/wait_before_close", "500000"),
            // A scan of some hundred targets is longer than the two batches that it has as it comes, and would be dropped for
            // readers that are only late.
            ("transport/link/tx/queue/size/data", "16"),
            ("transport/link/rx/max_message_size", "8388608"),
            ("queries_default_timeout", "2000"),
        ] {
            zenoh
                .insert_json5(key, value)
                .map_err(|e| open(plain(&format!("setting {key} to {value}: {e}"))))?;
        }
        for (key, value) in protection(config) {
            zenoh
                .insert_json5(key, &value.to_string())
                .map_err(|e| open(plain(&format!("setting {key}: {e}"))))?;
        }
        let session = zenoh::open(zenoh).wait().map_err(|e| {
            let reason = plain(&e.to_string());
            let nobody = !config.connect.is_empty() && reason.starts_with("Unable to connect");
            let mut why =
                if nobody { nobody_there(config.connect_timeout) } else { reason };
            if nobody && config.certs.is_some() {
                why += ", or one of the two certificates is not of this federation: `seeds certs check DIR`";
            }
            open(why)
        })?;
        Ok(Self {
            session,
            prefix: format!("seeds/{}/", config.exercise),
            tokens: Mutex::default(),
        })
    }

    fn key(&self, key: &str) -> String {
        format!("{}{key}", self.prefix)
    }
}

/// Octets of the largest order, question or command. What is longer is not one of ours.
const SHORT: u64 = 64 << 10;

/// TLS, access list and bounds.
fn protection(config: &ZenohConfig) -> Vec<(&'static str, Value)> {
    let exercise = config.exercise;
    let keys = |keys: &[&str]| -> Vec<String> {
        keys.iter().map(|key| format!("seeds/{exercise}/{key}")).collect()
    };
    let bound = |id: &str, messages: &[&str], keys: Vec<String>, octets: u64| {
        json!({
            "id": id, "flows": ["ingress"], "messages": messages, "key_exprs": keys,
            "size_limit": octets,
        })
    };
    let short = keys(&[
        "ctl/order",
        "ctl/beat",
        "ctl/lead",
        "ctl/join",
        "ctl/command",
        "ctl/statistics",
        "ctl/steps",
        "candidate/*",
        "agent/*",
    ]);
    let long = keys(&["fed/*", "frames/**", "log/**", "obs/**", "tracks/**", "control/**"]);
    let data = ["put", "delete", "query", "reply"];
    let bounds = json!([
        bound("orders and questions", &["put", "delete", "query"], short, SHORT),
        bound("reports", &data, long, super::codec::LIMIT + 1),
    ]);
    let mut settings = vec![("low_pass_filter", bounds)];
    if let Some(certs) = &config.certs {
        settings.push(("transport/link/tls", certs.of_links()));
        settings.push(("access_control", super::access_list::access_control(exercise)));
    }
    settings
}

/// What to do where nobody answers.
fn nobody_there(within: Duration) -> String {
    format!(
        "nobody answers there ({} s tried): start the run or its administration station first, or name its endpoint with --sync-connect",
        within.as_secs()
    )
}

/// An error of the library without the place in its source where it was made.
fn plain(error: &str) -> String {
    let mut words = Vec::new();
    let mut rest = error.split(' ').peekable();
    while let Some(word) = rest.next() {
        let place = |w: &&str| w.contains(".rs:");
        if word == "at" && rest.next_if(place).is_some() {
            continue;
        }
        words.push(word);
    }
    words.join(" ").trim_end_matches('.').to_owned()
}

fn failed(doing: &'static str, key: &str) -> impl FnOnce(zenoh::Error) -> BusError {
    let key = key.to_owned();
    move |e| BusError::Use { doing, key, reason: e.to_string() }
}

impl Bus for ZenohBus {
    fn publish(&self, key: &str, class: Class, body: Vec<u8>) -> Result<(), BusError> {
        let congestion = match class {
            Class::Must => CongestionControl::Block,
            Class::Lossy => CongestionControl::Drop,
        };
        self.session
            .put(self.key(key), body)
            .congestion_control(congestion)
            .express(true)
            .wait()
            .map_err(failed("publishing", key))
    }

    fn subscribe(&self, pattern: &str, sink: Sink) -> Result<(), BusError> {
        let prefix = self.prefix.len();
        self.session
            .declare_subscriber(self.key(pattern))
            .callback(move |sample| {
                let key = sample.key_expr().as_str().get(prefix..).unwrap_or_default();
                sink(key, &sample.payload().to_bytes());
            })
            .background()
            .wait()
            .map_err(failed("subscribing to", pattern))
    }

    fn serve(
        &self,
        key: &str,
        handler: Box<dyn Fn(Request) + Send + Sync>,
    ) -> Result<(), BusError> {
        self.session
            .declare_queryable(self.key(key))
            .callback(move |query| {
                let body = query.payload().map(|p| p.to_bytes().into_owned()).unwrap_or_default();
                handler(Request::new(body, move |answer| {
                    let key = query.key_expr().clone();
                    if let Err(e) = query.reply(key, answer).wait() {
                        tracing::debug!("an answer found no way back: {e}");
                    }
                }));
            })
            .background()
            .wait()
            .map_err(failed("serving", key))
    }

    fn request(
        &self,
        key: &str,
        body: Vec<u8>,
        deadline: Duration,
        replies: Replies,
    ) -> Result<(), BusError> {
        let end = End(Mutex::new(replies));
        self.session
            .get(self.key(key))
            .payload(body)
            .timeout(deadline)
            .callback(move |reply| {
                if let Ok(sample) = reply.result() {
                    end.tell(Some(sample.payload().to_bytes().into_owned()));
                }
            })
            .wait()
            .map_err(failed("asking", key))
    }

    fn announce(&self, key: &str) -> Result<(), BusError> {
        let token = self
            .session
            .liveliness()
            .declare_token(self.key(key))
            .wait()
            .map_err(failed("announcing", key))?;
        if let Ok(mut tokens) = self.tokens.lock() {
            tokens.push(token);
        }
        Ok(())
    }

    fn watch(&self, pattern: &str, sink: AliveSink) -> Result<(), BusError> {
        let prefix = self.prefix.len();
        self.session
            .liveliness()
            .declare_subscriber(self.key(pattern))
            .history(true)
            .callback(move |sample| {
                let key = sample.key_expr().as_str().get(prefix..).unwrap_or_default();
                sink(key, sample.kind() == SampleKind::Put);
            })
            .background()
            .wait()
            .map_err(failed("watching", pattern))
    }

    fn close(&self) {
        // Closing may take ten seconds when a peer is gone; a process that leaves does not wait for it.
        let (done, wait) = crossbeam_channel::bounded(1);
        let session = self.session.clone();
        std::thread::spawn(move || {
            let _ = done.send(session.close().wait());
        });
        if let Ok(Err(e)) = wait.recv_timeout(Duration::from_millis(500)) {
            tracing::debug!("closing the synchronisation plane: {e}");
        }
    }
}

/// Tells once that no more replies come: when zenoh drops the callback.
struct End(Mutex<Replies>);

impl End {
    fn tell(&self, reply: Option<Vec<u8>>) {
        if let Ok(mut replies) = self.0.lock() {
            replies(reply);
        }
    }
}

impl Drop for End {
    fn drop(&mut self) {
        self.tell(None);
    }
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn places_in_the_librarys_source_are_not_told() {
        let told = "setting \"foo\": not <protocol>/<address>: foo at /home/a/endpoint.rs:615. at /b/config.rs:86.";
        assert_eq!(plain(told), "setting \"foo\": not <protocol>/<address>: foo");
        assert_eq!(plain("cannot listen at tcp/1.2.3.4:5"), "cannot listen at tcp/1.2.3.4:5");
    }
}
