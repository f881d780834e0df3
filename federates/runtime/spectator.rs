//! What every spectator does alike: join under a free name, hear what may be lost, ask for last values.

use super::bus::{Bus, BusError, ask};
use super::clock::monotonic_ns;
use super::codec::{decode, encode};
use super::messages::{Hello, Kind, Welcome};
use super::process::{host_name, random_id};
use serde::de::DeserializeOwned;
use std::time::Duration;

/// Spectators of one kind that a federation may have.
const INSTANCES: u32 = 64;
/// How long one question waits for its answer.
const ANSWER_WITHIN: Duration = Duration::from_millis(500);
/// How long to wait before the next question.
const PAUSE: Duration = Duration::from_millis(20);

/// Who wants to look on.
#[derive(Clone, Debug)]
pub struct Spectator<'a> {
    /// Its name; a number is added where another one has it.
    pub name: &'a str,
    /// What it is.
    pub kind: Kind,
    /// Hash of the scene and its data.
    pub scene_hash: u64,
    /// How long to look for an administration station.
    pub patience: Duration,
    /// How it is reached, for messages to people.
    pub endpoint: &'a str,
}

/// A spectator that takes part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Joined {
    /// Name within the federation.
    pub name: String,
    /// Federation.
    pub fed: u128,
    /// Incarnation.
    pub inc: u64,
}

impl Spectator<'_> {
    /// Joins; none if `stopped`, which waits for as long as it is told, says that the operator wants this process to end.
    ///
    /// # Errors
    /// If nobody answers, or the administration station refuses.
    pub fn join(
        &self,
        bus: &dyn Bus,
        mut stopped: impl FnMut(Duration) -> bool,
    ) -> anyhow::Result<Option<Joined>> {
        let mut hello = Hello {
            name: self.name.to_owned(),
            kind: self.kind,
            pid: std::process::id(),
            host: host_name(),
            version: super::build::IDENTITY.to_owned(),
            scene_hash: self.scene_hash,
            instance: random_id(),
            was: None,
        };
        let started = monotonic_ns();
        let mut instance = 1;
        loop {
            let answer = ask(bus, "ctl/join", encode(&hello), ANSWER_WITHIN)?;
            match answer.as_deref().map(decode::<Welcome>) {
                Some(Ok(Welcome::Accepted(accepted))) => {
                    let (fed, inc) = (accepted.fed, accepted.inc);
                    return Ok(Some(Joined { name: hello.name, fed, inc }));
                }
                Some(Ok(Welcome::NameTaken)) if instance < INSTANCES => {
                    instance += 1;
                    hello.name = format!("{}-{instance}", self.name);
                    continue;
                }
                Some(Ok(Welcome::NameTaken)) => anyhow::bail!(
                    "{INSTANCES} {}s are in this federation already: end one",
                    self.kind.name()
                ),
                Some(Ok(Welcome::Refused(why))) => {
                    anyhow::bail!("the administration station refused: {why}")
                }
                Some(Err(error)) => anyhow::bail!("the administration station refused: {error}"),
                Some(Ok(Welcome::Later(_))) | None => {}
            }
            anyhow::ensure!(
                monotonic_ns() - started < self.patience.as_nanos() as u64,
                "{}: no administration station answered at {} within {} s: start one there (seeds admin-station), or check --sync-connect and --exercise",
                self.name,
                self.endpoint,
                self.patience.as_secs()
            );
            if stopped(PAUSE) {
                return Ok(None);
            }
        }
    }
}

/// Hands every message of `pattern` to `take`; what cannot be read is dropped with a word.
///
/// # Errors
/// If the session is closed.
pub fn hear<T: DeserializeOwned>(
    bus: &dyn Bus,
    pattern: &str,
    take: impl Fn(T) + Send + Sync + 'static,
) -> Result<(), BusError> {
    let sink = move |key: &str, octets: &[u8]| match decode(octets) {
        Ok(message) => take(message),
        Err(error) => tracing::warn!(key, %error, "a message was dropped"),
    };
    bus.subscribe(pattern, Box::new(sink))
}

/// Asks for what was said before this process listened.
///
/// # Errors
/// If the session is closed.
pub fn last<T: DeserializeOwned>(
    bus: &dyn Bus,
    key: &str,
    take: impl FnOnce(T),
) -> Result<(), BusError> {
    if let Some(octets) = ask(bus, key, Vec::new(), ANSWER_WITHIN)?
        && let Ok(message) = decode(&octets)
    {
        take(message);
    }
    Ok(())
}
