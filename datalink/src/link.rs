//! Both directions of a link at once.

use crate::config::LinkConfig;
use crate::error::LinkError;
use crate::receiver::Receiver;
use crate::sender::Sender;

/// A sender and a receiver of the same traffic.
#[derive(Debug)]
pub struct Link;

impl Link {
    /// Opens both directions. Several processes on one host each receive all of broadcast and
    /// multicast, their own included ([`Sender::address`] tells which that is).
    ///
    /// # Errors
    /// [`LinkError`]: what, where, what to do.
    pub fn open(config: &LinkConfig) -> Result<(Sender, Receiver), LinkError> {
        Ok((Sender::open(config)?, Receiver::open(config)?))
    }
}
