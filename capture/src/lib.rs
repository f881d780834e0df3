//! Files of DIS datagrams: read, written, searched, played.
//!
//! [`Reader`] takes pcap, pcapng and files of bare PDUs apart, down to the UDP payload, and says where
//! a file is damaged. [`Recorder`] writes pcapng that Wireshark opens. No sockets and no clock here:
//! stamps come from the caller.
//!
//! ```no_run
//! for item in capture::Reader::open("exercise.pcapng")? {
//!     match item {
//!         Ok(datagram) => println!("{} {} octets", datagram.utc_ns, datagram.payload.len()),
//!         Err(problem) => println!("{problem}"),
//!     }
//! }
//! # Ok::<(), capture::OpenError>(())
//! ```

mod bytes;
mod container;
mod error;
mod fragments;
mod frame;
mod index;
mod link;
mod player;
mod reader;
mod recorder;
mod recording;
mod rewrite;
mod source;
pub mod tools;
mod utc;

pub use error::{BlockFault, FrameFault, OpenError, Problem};
pub use frame::MOST_PAYLOAD;
pub use player::{BadRate, Pace, Phase, Player, Timeline};
pub use reader::{Counts, Datagram, Kind, Reader};
pub use recorder::{RecordError, Recorder, Sink};
pub use recording::{AlivePdu, Recording};
pub use rewrite::Rewrite;
pub use utc::{BadTime, Utc, When};
