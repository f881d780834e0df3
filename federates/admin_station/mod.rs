//! The administration station: configures, starts, freezes, steps, stops, restarts and measures a run.
//!
//! It owns the [`Conductor`](crate::runtime::conductor::Conductor) and is the only process that paces time.

mod actions;
mod asked;
mod awaiting;
mod balance;
#[cfg(test)]
mod clock_tests;
pub mod command;
mod created;
mod desk;
mod ears;
#[cfg(test)]
mod lead_tests;
mod operate;
mod participants;
pub mod simman;
mod standby;
mod station;
mod statistics;
pub mod summary;
mod watch;

use crate::runtime::bus::{Bus, BusError, Request};
use crate::runtime::codec::encode;
use crate::runtime::conductor::{ClosedRun, ConductorConfig};
use crate::runtime::digest::pdu_hash;
use crate::runtime::journal::JournalError;
use crate::runtime::lead::Lead;
use crate::runtime::life_cycle::Phase;
use crate::runtime::messages::{Answer, Command, Frame, RunState};
use crate::runtime::process::host_name;
use crate::runtime::run_log::RunLog;
use crate::runtime::succession::{Candidacy, STATIONS};
use crossbeam_channel::{Receiver, Sender};
use station::Station;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::time::Duration;

pub use statistics::Statistics;

/// What reaches the administration station from outside.
pub enum Event {
    /// A federate asks to join.
    Join(Request),
    /// A report of a member.
    Report(String, Vec<u8>),
    /// A beat of a member.
    Beat(String, Vec<u8>),
    /// A member lacks orders, or reports of another one.
    Fetch(Request),
    /// A consumer lacks PDUs of a producer that it does not hear.
    Repair(Request),
    /// Lost reports were told again.
    Fetched(Vec<u8>),
    /// One that returns reads the log of the run.
    Log(Request),
    /// A command from a second terminal or the page.
    Command(Request),
    /// A command from inside this process (DIS simulation management), with where it came from and
    /// the channel for the answer.
    Local(Command, String, Sender<Answer>),
    /// A member's liveliness changed: name, incarnation.
    Alive(String, u64, bool),
    /// A part of this process cannot go on: a fault of the run, which itself goes on.
    Broken(String),
    /// A standby reads the journal.
    Steps(Request),
    /// The voter of that name answered.
    Voted(String, Vec<u8>),
    /// A station says that it leads.
    Leads(Vec<u8>),
    /// The spectators that the run waits for will not come.
    NoSpectators,
    /// The operator of this process wants the run to end.
    Stop,
    /// This process is to end, and the run to go on when it is started again.
    Leave,
}

/// The name of an administration station.
pub const STATION: &str = STATIONS[0];

/// The name of its standby.
pub const STANDBY: &str = STATIONS[1];

/// Told of a phase reached: phase, frame, reason.
pub type PhaseHook = Box<dyn FnMut(Phase, Frame, Option<&str>) + Send>;

/// Told how the run stands.
pub type StateHook = Box<dyn FnMut(&RunState) + Send>;

/// What the administration station needs.
pub struct AdminContext {
    /// The synchronisation plane.
    pub bus: Arc<dyn Bus>,
    /// What this station is called: [`STATION`], or [`STANDBY`] where it was one.
    pub name: &'static str,
    /// The run.
    pub config: ConductorConfig,
    /// Events, also from simulation management and Ctrl-C.
    pub events: (Sender<Event>, Receiver<Event>),
    /// Told of every phase reached: phase, frame, reason.
    pub reached: PhaseHook,
    /// Told how the run stands, some times a second.
    pub stated: StateHook,
    /// Told of every closed run.
    pub closed: Box<dyn FnMut(&ClosedRun) + Send>,
    /// Told of the lowest frame executed and the last frame, about once a second.
    pub progress: Option<Box<dyn FnMut(Frame, Frame) + Send>>,
    /// How long expected federates may take to join, when in batch.
    pub patience: Duration,
    /// Where what the conductor is told is kept, so that a station that is started again goes on with the run.
    pub journal: Option<PathBuf>,
    /// The run of a station of which this process was the standby: it leads that one on.
    pub succeeds: Option<Box<Succeeds>>,
    /// Moves places of producers away from busy hosts.
    pub balance: bool,
    /// Requests of simulation management from hosts that may not drive the run, so far.
    pub refused: Arc<AtomicU64>,
}

/// What a standby knows when it leads: the conductor, and the log of the run.
pub struct Succeeds(Lead, RunLog);

/// Why an administration station cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum StationError {
    /// The synchronisation plane.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The journal.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// Its standby leads.
    #[error("its standby leads the run by now (epoch {0}): this administration station ends")]
    Deposed(u32),
    /// It is not to be a standby.
    #[error("this standby is refused: {0}")]
    Refused(String),
    /// No station is there whose standby it could be.
    #[error(
        "no administration station answered at {endpoint} within {seconds} s: a standby follows one that runs with --journal"
    )]
    NoStation {
        /// Endpoint.
        endpoint: String,
        /// Patience.
        seconds: u64,
    },
    /// Neither the station is heard nor enough voters.
    #[error(
        "nothing was heard of the administration station for {seconds} s, and {here} of {all} voters are here where more than half are needed: this standby ends"
    )]
    Cut {
        /// How long.
        seconds: u64,
        /// Voices that it has.
        here: usize,
        /// All.
        all: usize,
    },
}

/// Runs the federation until it is over; returns the exit code.
///
/// # Errors
/// If the bus fails, or the journal belongs to another run.
pub fn run(context: AdminContext) -> Result<u8, StationError> {
    let (station, events) = Station::open(context)?;
    station.run(&events)
}

/// Who a station or standby with that journal is to the voters, whichever process of it.
fn who_has(journal: &Path) -> u64 {
    let path = std::fs::canonicalize(journal).unwrap_or_else(|_| journal.to_owned());
    pdu_hash(format!("{} {}", host_name(), path.display()).as_bytes())
}

/// Asks a voter who is to lead.
fn ask_voter(
    bus: &dyn Bus,
    voter: &str,
    question: &Candidacy,
    answered: impl Fn(String, Vec<u8>) + Send + 'static,
) -> Result<(), BusError> {
    let name = voter.to_owned();
    let replies = move |reply: Option<Vec<u8>>| {
        if let Some(body) = reply {
            answered(name.clone(), body);
        }
    };
    let within = Duration::from_millis(500);
    bus.request(&format!("candidate/{voter}"), encode(question), within, Box::new(replies))
}
