//! The synchronisation plane as federates see it: notify, request, liveliness. No message is known here.
//!
//! Keys are relative ("ctl/order"); an implementation puts `seeds/{exercise}/` before them. In patterns
//! `*` is one part between slashes and `**` any number of parts at the end. Callbacks run on threads of
//! the bus and must only hand the octets on.

use std::time::Duration;

/// Whether a message may be lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Must arrive; a slow receiver holds the sender back (for at most half a second).
    Must,
    /// Dropped for receivers that do not keep up; never blocks. All that spectators read.
    Lossy,
}

/// Receives (key, octets).
pub type Sink = Box<dyn Fn(&str, &[u8]) + Send + Sync>;

/// Receives each reply, then `None` once: no more will come.
pub type Replies = Box<dyn FnMut(Option<Vec<u8>>) + Send>;

/// Receives (key, alive).
pub type AliveSink = Box<dyn Fn(&str, bool) + Send + Sync>;

/// A question that wants one answer.
pub struct Request {
    /// What was asked.
    pub body: Vec<u8>,
    reply: Box<dyn FnOnce(Vec<u8>) + Send>,
}

impl Request {
    /// A request whose answer goes to `reply`.
    pub fn new(body: Vec<u8>, reply: impl FnOnce(Vec<u8>) + Send + 'static) -> Self {
        Self { body, reply: Box::new(reply) }
    }
    /// Answers. A request dropped without an answer ends at its deadline.
    pub fn answer(self, body: Vec<u8>) {
        (self.reply)(body);
    }
}

impl std::fmt::Debug for Request {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Request({} octets)", self.body.len())
    }
}

/// Why the bus failed, with what a person can do.
#[derive(Debug, thiserror::Error)]
pub enum BusError {
    /// Opening, listening or connecting failed.
    #[error("synchronisation plane: {doing}: {reason}")]
    Open {
        /// What was attempted.
        doing: String,
        /// Why it failed.
        reason: String,
    },
    /// An open session failed to do something.
    #[error("synchronisation plane: {doing} '{key}': {reason}")]
    Use {
        /// What was attempted.
        doing: &'static str,
        /// Key concerned.
        key: String,
        /// Why it failed.
        reason: String,
    },
}

/// Notify, request/reply and liveliness. Everything declared lives as long as the bus.
pub trait Bus: Send + Sync {
    /// Sends `body` to all present subscribers of `key`.
    ///
    /// # Errors
    /// If the session is closed.
    fn publish(&self, key: &str, class: Class, body: Vec<u8>) -> Result<(), BusError>;
    /// Calls `sink` for every message whose key matches `pattern`, in the order of each sender.
    ///
    /// # Errors
    /// If the session is closed.
    fn subscribe(&self, pattern: &str, sink: Sink) -> Result<(), BusError>;
    /// Answers requests for `key`.
    ///
    /// # Errors
    /// If the session is closed.
    fn serve(&self, key: &str, handler: Box<dyn Fn(Request) + Send + Sync>)
    -> Result<(), BusError>;
    /// Asks whoever serves `key`; `replies` gets every answer and then `None`.
    ///
    /// # Errors
    /// If the session is closed.
    fn request(
        &self,
        key: &str,
        body: Vec<u8>,
        deadline: Duration,
        replies: Replies,
    ) -> Result<(), BusError>;
    /// Shows `key` as alive until the bus is closed or the process dies.
    ///
    /// # Errors
    /// If the session is closed.
    fn announce(&self, key: &str) -> Result<(), BusError>;
    /// Calls `sink` when a key that matches `pattern` comes to life or dies; those alive now first.
    ///
    /// # Errors
    /// If the session is closed.
    fn watch(&self, pattern: &str, sink: AliveSink) -> Result<(), BusError>;
    /// Leaves; nothing is sent or received afterwards.
    fn close(&self);
}

/// Asks and waits for the first answer; `None` if none came before `deadline`.
///
/// # Errors
/// If the session is closed.
pub fn ask(
    bus: &dyn Bus,
    key: &str,
    body: Vec<u8>,
    deadline: Duration,
) -> Result<Option<Vec<u8>>, BusError> {
    let (send, receive) = crossbeam_channel::unbounded();
    bus.request(
        key,
        body,
        deadline,
        Box::new(move |reply| {
            let _ = send.send(reply);
        }),
    )?;
    // One second beyond the deadline: the bus reports its end itself.
    Ok(receive.recv_timeout(deadline + Duration::from_secs(1)).ok().flatten())
}

/// Whether `key` matches `pattern`.
#[must_use]
pub fn matches(pattern: &str, key: &str) -> bool {
    let (mut parts, mut keys) = (pattern.split('/'), key.split('/'));
    loop {
        match (parts.next(), keys.next()) {
            (Some("**"), _) | (None, None) => return true,
            (Some("*"), Some(_)) => {}
            (Some(part), Some(key)) if part == key => {}
            _ => return false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn patterns() {
        assert!(matches("fed/*", "fed/smdfm"));
        assert!(!matches("fed/*", "fed/smdfm/x"));
        assert!(matches("obs/**", "obs/fed/smdfm"));
        assert!(matches("ctl/order", "ctl/order"));
        assert!(!matches("ctl/order", "ctl"));
        assert!(!matches("ctl", "ctl/order"));
    }
}
