//! Operating a run from outside its processes: a second terminal, the page.

use crate::runtime::bus::{Bus, BusError, ask};
use crate::runtime::codec::{CodecError, decode, encode};
use crate::runtime::messages::{Answer, Command};
use std::time::Duration;

/// Why a command got no answer.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The bus failed.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Nobody there.
    #[error(
        "no administration station answered at {0}: is a run going on there? Check --sync-connect and --exercise"
    )]
    Nobody(String),
    /// Another version.
    #[error(transparent)]
    Codec(#[from] CodecError),
}

/// Sends a command and waits until its state is reached.
///
/// # Errors
/// [`ClientError`], one sentence each.
pub fn command(bus: &dyn Bus, endpoint: &str, command: &Command) -> Result<Answer, ClientError> {
    let answer = ask(bus, "ctl/command", encode(command), Duration::from_secs(10))?;
    Ok(decode(&answer.ok_or_else(|| ClientError::Nobody(endpoint.to_owned()))?)?)
}

/// The federation's statistics as JSON.
///
/// # Errors
/// [`ClientError`], one sentence each.
pub fn statistics(bus: &dyn Bus, endpoint: &str) -> Result<serde_json::Value, ClientError> {
    let body = ask(bus, "ctl/statistics", Vec::new(), Duration::from_secs(3))?
        .ok_or_else(|| ClientError::Nobody(endpoint.to_owned()))?;
    serde_json::from_slice(&body).map_err(|_| ClientError::Nobody(endpoint.to_owned()))
}
