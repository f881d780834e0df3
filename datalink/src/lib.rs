//! DIS over UDP: multicast, broadcast and unicast lists, IPv4 and IPv6, in batches.
//!
//! ```no_run
//! use datalink::{Link, LinkConfig};
//! use std::time::Duration;
//!
//! let config = LinkConfig { to: "239.1.2.3:3000".parse()?, ..LinkConfig::default() };
//! let (mut sender, mut receiver) = Link::open(&config)?;
//! sender.send(&[7, 1, 1, 1, 0, 0, 0, 0, 0, 12, 0, 0])?;
//! receiver.receive(Some(Duration::from_millis(100)), |arrival| {
//!     println!("{} sent {} octets", arrival.from, arrival.payload.len());
//! })?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Nothing here looks into PDUs. Whoever shares a host shares broadcast and multicast: every process
//! gets every datagram, its own included.

mod address;
mod bundle;
mod config;
mod error;
mod link;
mod ports;
mod receiver;
mod sender;
mod socket;

pub use address::{AddressError, Destination, Destinations};
pub use bundle::{Bundle, Packing};
pub use config::LinkConfig;
pub use error::{LinkError, Warning};
pub use link::Link;
pub use ports::free_port;
pub use receiver::{Arrival, Received, Receiver, Waker};
pub use sender::{Sender, Sent};
