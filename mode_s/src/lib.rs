//! Extended squitters of 1090 MHz (ADS-B), and the two line formats in which receivers hand them on.
//!
//! [`Message`] is one squitter of 112 bits: made by [`SurfacePosition`], [`AirbornePosition`], [`AirborneVelocity`],
//! [`Identification`] and [`OperationalStatus`], read by [`read`]. [`cpr`] has the compact position reports. [`beast`] frames messages as
//! receivers do, [`sbs`] writes BaseStation lines, [`gdl90`] what displays in cockpits read. [`Schedule`] says what a target sends when. The crate knows no sockets and no clocks.
//!
//! Sources: RTCA DO-260B / EUROCAE ED-102A in the public description "The 1090 Megahertz Riddle" (J. Sun); ICAO Annex 10 Vol. IV for
//! the parity. Units are in the names; angles are degrees from true north, heights feet as on the air.
//!
//! ```
//! use mode_s::{Emitter, Identification, Message, Reading, read};
//! let message = Identification { callsign: "SWR137H", category: 0xa3 }.message(Emitter::aircraft(0xb0_f3e6, true))?;
//! assert_eq!(message.hex(), "8cb0f3e6234d74b1cf72202d016f");
//! let (_, Reading::Identification { callsign, .. }) = read(&message)? else { panic!() };
//! assert_eq!(callsign, "SWR137H");
//! # Ok::<(), mode_s::ModeSError>(())
//! ```

pub mod beast;
mod bits;
pub mod cpr;
pub mod gdl90;
mod message;
mod reading;
pub mod sbs;
mod schedule;
mod squitters;

pub use message::{Emitter, Message, ModeSError};
pub use reading::{Reading, read};
pub use schedule::{Due, Schedule, Target};
pub use squitters::{
    AirbornePosition, AirborneVelocity, Identification, OperationalStatus, SurfacePosition,
    length_width_code, movement_code, movement_speed_kt, nic_type_code,
};

/// One knot, m/s.
pub const KNOT_MPS: f64 = 1852.0 / 3600.0;
/// One foot, m.
pub const FOOT_M: f64 = 0.3048;
