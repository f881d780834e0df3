//! One mover of a scene, and how movers are dealt out.

use models::plot::Callsign;
use models::sensors::TargetClass;
use models::truth::Trajectory;
use models::truth::recorded::Report;

/// One mover.
#[derive(Clone, Debug, PartialEq)]
pub struct Entity {
    /// Call sign or vehicle name; the DIS marking.
    pub callsign: Callsign,
    /// 24-bit Mode S address, where known.
    pub address: Option<u32>,
    /// Size and echo; `class.designator` is its type.
    pub class: TargetClass,
    /// DIS application number: the partition of the traffic that it belongs to, never a process.
    pub application: u16,
    /// DIS entity number.
    pub number: u16,
    /// Its true movement; it does not exist outside. `None` in a scene loaded without its truth.
    pub trajectory: Option<Trajectory>,
    /// What the import of its recording did, where it has one.
    pub report: Option<Report>,
}

impl Entity {
    /// Key for draws: DIS site, application and entity in one number.
    #[must_use]
    pub fn key(&self, site: u16) -> u64 {
        u64::from(site) << 32 | u64::from(self.application) << 16 | u64::from(self.number)
    }
}

/// Partitions of the traffic: entities are dealt out to them in turn.
pub const PARTITIONS: u16 = 16;
