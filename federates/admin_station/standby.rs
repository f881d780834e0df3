//! A standby as a process: what reaches it, and what it asks.

use super::{Event, StationError, Succeeds, ask_voter, who_has};
use crate::runtime::bus::{Bus, BusError, watch_stations};
use crate::runtime::clock::monotonic_ns;
use crate::runtime::codec::{decode, encode};
use crate::runtime::conductor::ConductorConfig;
use crate::runtime::follower::{Becomes, Follower};
use crate::runtime::journal::Journal;
use crate::runtime::messages::{Numbered, Order};
use crate::runtime::process::random_id;
use crate::runtime::succession::{Steps, Voted};
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, unbounded};
use std::path::Path;
use std::time::Duration;

/// How long a station is looked for, and how long a standby waits for voices.
const PATIENCE_NS: u64 = 120_000_000_000;

/// How long an answer is awaited.
const ANSWER: Duration = Duration::from_millis(1_000);

/// How often it looks at the clock.
const LOOK: Duration = Duration::from_millis(50);

/// What reaches a standby.
enum Heard {
    /// The answer to a question of that number; none: no more will come.
    Steps(u64, Option<Vec<u8>>),
    /// A voter answered.
    Voted(String, Vec<u8>),
    /// A station beats.
    Beat,
    /// The connection of a station came or went.
    Alive(bool),
    /// An order to the members.
    Order(Vec<u8>),
}

/// Follows the station on `bus` until it is no more: the run that is to be led on; none if the run is over.
///
/// # Errors
/// [`StationError`]: the journal, a refusal, no station, not enough voters.
pub(super) fn follow(
    bus: &dyn Bus,
    config: &ConductorConfig,
    (path, endpoint): (&Path, &str),
    events: &Receiver<Event>,
) -> Result<Option<Box<Succeeds>>, StationError> {
    let (send, receive) = unbounded();
    listen(bus, &send)?;
    let opened = Journal::open_copy(path, config)?;
    let who = (who_has(opened.0.path()), random_id());
    let mut follower = Follower::open(opened, config, who, monotonic_ns());
    loop {
        if let Some((number, ask)) = follower.ask(monotonic_ns())? {
            let replies = send.clone();
            let replies = move |reply| drop(replies.send(Heard::Steps(number, reply)));
            bus.request("ctl/steps", encode(&ask), ANSWER, Box::new(replies))?;
        }
        let heard = match receive.recv_timeout(LOOK) {
            Ok(heard) => Some(heard),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return Ok(None),
        };
        let now = monotonic_ns();
        let mut becomes = Becomes::Standby;
        match heard {
            Some(Heard::Steps(number, body)) => {
                let steps = body.map(|body| decode::<Steps>(&body)).transpose();
                let steps = steps.map_err(|e| StationError::Refused(e.to_string()))?;
                becomes = follower.told(now, number, steps)?;
            }
            Some(Heard::Voted(name, body)) => {
                if let Ok(voted) = decode::<Voted>(&body) {
                    becomes = follower.voted(now, &name, &voted);
                }
            }
            Some(Heard::Beat) => follower.heard(now),
            Some(Heard::Alive(alive)) => follower.connected(alive),
            Some(Heard::Order(body)) => {
                if let Ok(order) = decode::<Numbered<Order>>(&body) {
                    becomes = follower.ordered(&order);
                }
            }
            None => {}
        }
        match becomes {
            Becomes::Standby => {}
            Becomes::Leader(led) => {
                let (lead, log) = follower.lead(led, monotonic_ns())?;
                return Ok(Some(Box::new(Succeeds(lead, log))));
            }
            Becomes::Over => {
                follower.over();
                return Ok(None);
            }
            Becomes::Refused(why) => return Err(StationError::Refused(why)),
        }
        if events.try_iter().any(|event| matches!(event, Event::Stop | Event::Leave)) {
            return Ok(None);
        }
        for (voter, question) in follower.questions(now) {
            let replies = send.clone();
            ask_voter(bus, &voter, &question, move |name, body| {
                let _ = replies.send(Heard::Voted(name, body));
            })?;
        }
        if now > follower.silent_since() + PATIENCE_NS {
            return Err(match follower.standing() {
                Some((here, all)) => {
                    StationError::Cut { seconds: PATIENCE_NS / 1_000_000_000, here, all }
                }
                None => StationError::NoStation {
                    endpoint: endpoint.to_owned(),
                    seconds: PATIENCE_NS / 1_000_000_000,
                },
            });
        }
    }
}

fn listen(bus: &dyn Bus, send: &Sender<Heard>) -> Result<(), BusError> {
    let to = send.clone();
    bus.subscribe("ctl/beat", Box::new(move |_, _| drop(to.send(Heard::Beat))))?;
    let to = send.clone();
    bus.subscribe(
        "ctl/order",
        Box::new(move |_, body| drop(to.send(Heard::Order(body.to_vec())))),
    )?;
    let to = send.clone();
    watch_stations(bus, move |alive| drop(to.send(Heard::Alive(alive))))?;
    Ok(())
}
