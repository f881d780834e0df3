//! Plots of real sensors on their way in: whose they are, and a budget a frame.
//!
//! A datagram is taken apart into records, each goes to the sensor of the scene that it is of, and waits for the next frame as
//! data blocks that fit into a stamped report. What is refused is counted by reason; a flood costs its sensor, never the run.

use crate::exchange::stamp::StampedPlots;
use asterix::blocks;
use datalink::{Destination, Destinations, LinkConfig};
use pdu::exercise::Arrival;
use scenarios::{ForeignScene, ForeignSource, Scene};
use std::collections::{BTreeMap, VecDeque};
use std::net::SocketAddr;

/// Octets let into a frame, shared among the sensors.
pub const OCTETS_A_FRAME: usize = 64 * 1024;
/// Octets that may wait, shared among the sensors.
const OCTETS_WAITING: usize = 1 << 20;
/// Octets of a report's blocks.
const LONGEST: usize = 1400;
/// Octets of the header of a data block.
const HEADER: usize = 3;

/// Blocks of one sensor that wait for a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Waiting {
    /// Number of the sensor in the scene.
    pub sensor: u16,
    /// UTC of their arrival, ns.
    pub utc_ns: i64,
    /// Who sent them.
    pub from: SocketAddr,
    /// Data blocks.
    pub octets: Vec<u8>,
}

impl Waiting {
    /// What is stamped, with the time of arrival in the exercise.
    #[must_use]
    pub fn stamped(self, arrival: Arrival) -> StampedPlots {
        StampedPlots { sensor: self.sensor, arrival, from: self.from, octets: self.octets }
    }
}

/// The door for plots.
#[derive(Debug, Default)]
pub struct PlotDoor {
    sensors: Vec<(u16, ForeignScene)>,
    waiting: BTreeMap<u16, VecDeque<Waiting>>,
    octets: BTreeMap<u16, usize>,
    refused: BTreeMap<&'static str, u64>,
    heard: u64,
}

/// Where the real sensors of a scene are listened for, each place once.
#[must_use]
pub fn links(scene: &Scene) -> Vec<(SocketAddr, LinkConfig)> {
    let mut links: Vec<(SocketAddr, LinkConfig)> = Vec::new();
    for sensor in &scene.sensors {
        let Some(ForeignSource::Live { listen, interface, .. }) =
            sensor.foreign.as_ref().map(|foreign| &foreign.source)
        else {
            continue;
        };
        if links.iter().any(|(known, _)| known == listen) {
            continue;
        }
        // One host is listened for at its own address and port.
        let host = matches!(Destination::of(*listen), Destination::Host(_));
        let Ok(to) = Destinations::new(vec![Destination::of(*listen)]) else { continue };
        let config = LinkConfig {
            to,
            interface: *interface,
            listen: (listen.is_ipv4() && host).then_some(*listen),
            ..LinkConfig::default()
        };
        links.push((*listen, config));
    }
    links
}

impl PlotDoor {
    /// The door of a scene.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let live = scene.sensors.iter().filter_map(|sensor| {
            Some((sensor.id.0, sensor.foreign.clone().filter(ForeignScene::is_live)?))
        });
        Self { sensors: live.collect(), ..Self::default() }
    }

    /// Nothing waits: a new run.
    pub fn clear(&mut self) {
        *self = Self { sensors: std::mem::take(&mut self.sensors), ..Self::default() };
    }

    /// A datagram arrived at the address `listen`.
    pub fn knock(&mut self, utc_ns: i64, listen: SocketAddr, from: SocketAddr, datagram: &[u8]) {
        self.heard += 1;
        let heard_here = |foreign: &ForeignScene| match &foreign.source {
            ForeignSource::Live { listen: own, from: allowed, .. } => {
                *own == listen && (allowed.is_empty() || allowed.contains(&from.ip()))
            }
            ForeignSource::Recording { .. } => false,
        };
        if !self.sensors.iter().any(|(_, foreign)| heard_here(foreign)) {
            return self.refuse("plots of a sender that no sensor of the scene names");
        }
        let mut of_sensor: BTreeMap<u16, Vec<Vec<u8>>> = BTreeMap::new();
        // The good records before any damage count.
        'all: for block in blocks(datagram) {
            let block = match block {
                Ok(block) => block,
                Err(e) => {
                    self.refuse(e.fault.word());
                    break;
                }
            };
            if block.category.is_none() {
                self.refuse("plots: unknown category");
                continue;
            }
            let mut open = None;
            for record in block.records() {
                let record = match record {
                    Ok(record) => record,
                    Err(e) => {
                        self.refuse(e.fault.word());
                        break 'all;
                    }
                };
                let Some(source) = record.source() else {
                    self.refuse("plots: a report without its source");
                    continue;
                };
                let own = self.sensors.iter().find(|(_, foreign)| {
                    heard_here(foreign) && foreign.is_of(source, block.number)
                });
                let Some(&(sensor, _)) = own else {
                    self.refuse("reports of no sensor of the scene, by source and category");
                    continue;
                };
                let record = record.octets();
                if HEADER + record.len() > LONGEST {
                    self.refuse("plots: a report longer than 1400 octets");
                    continue;
                }
                append(
                    of_sensor.entry(sensor).or_default(),
                    &mut open,
                    sensor,
                    block.number,
                    record,
                );
            }
        }
        let share = OCTETS_WAITING / self.sensors.len().max(1);
        for (sensor, reports) in of_sensor {
            for octets in reports {
                let waiting = self.octets.entry(sensor).or_default();
                if *waiting + octets.len() > share {
                    self.refuse("plots over the budget of their sensor");
                    continue;
                }
                *waiting += octets.len();
                let one = Waiting { sensor, utc_ns, from, octets };
                self.waiting.entry(sensor).or_default().push_back(one);
            }
        }
    }

    /// What comes into the frame that is executed at `utc_ns`: sensor by sensor, in the order of arrival.
    pub fn admit(&mut self, utc_ns: i64) -> Vec<Waiting> {
        let share = OCTETS_A_FRAME / self.sensors.len().max(1);
        let mut admitted = Vec::new();
        for (sensor, queue) in &mut self.waiting {
            let mut taken = 0;
            let left = self.octets.entry(*sensor).or_default();
            while let Some(first) = queue.front() {
                let length = first.octets.len();
                let old = utc_ns.saturating_sub(first.utc_ns) > 1_000_000_000;
                if !old && taken + length > share {
                    break;
                }
                *left -= length;
                let Some(first) = queue.pop_front() else { break };
                if old {
                    *self.refused.entry("plots over the budget of their sensor").or_default() += 1;
                    continue;
                }
                taken += length;
                admitted.push(first);
            }
        }
        admitted
    }

    fn refuse(&mut self, reason: &'static str) {
        *self.refused.entry(reason).or_default() += 1;
    }

    /// What was refused, by reason.
    #[must_use]
    pub fn refused(&self) -> &BTreeMap<&'static str, u64> {
        &self.refused
    }

    /// Datagrams heard.
    #[must_use]
    pub fn heard(&self) -> u64 {
        self.heard
    }
}

/// Adds a record to the last report, in the block that was opened for its sensor if it is of this one's.
fn append(
    reports: &mut Vec<Vec<u8>>,
    open: &mut Option<(u16, usize)>,
    sensor: u16,
    category: u8,
    record: &[u8],
) {
    let goes_on = open.filter(|(of, _)| *of == sensor).map(|(_, at)| at);
    let needed = record.len() + if goes_on.is_some() { 0 } else { HEADER };
    let begin_again = reports.last().is_none_or(|last| last.len() + needed > LONGEST);
    if begin_again {
        reports.push(Vec::with_capacity(LONGEST));
    }
    let Some(report) = reports.last_mut() else { return };
    let at = match goes_on.filter(|_| !begin_again) {
        Some(at) => at,
        None => {
            report.extend_from_slice(&[category, 0, 0]);
            report.len() - HEADER
        }
    };
    report.extend_from_slice(record);
    let length = (report.len() - at) as u16;
    report[at + 1..at + HEADER].copy_from_slice(&length.to_be_bytes());
    *open = Some((sensor, at));
}

#[cfg(test)]
mod tests {
    use super::*;
    use asterix::{Packer, cat010};

    const UTC_NS: i64 = 1_700_000_000_000_000_000;

    fn foreign(listen: &str, sic: u8) -> ForeignScene {
        ForeignScene {
            source: ForeignSource::Live {
                listen: listen.parse().expect("an address"),
                interface: None,
                from: Vec::new(),
            },
            sac: Some(1),
            sic: Some(sic),
            categories: vec![10],
            sigma_m: 5.0,
            interval_s: 1.0,
            first: false,
        }
    }

    fn door(sics: &[u8]) -> PlotDoor {
        let sensors = sics.iter().map(|sic| (u16::from(*sic), foreign("127.0.0.1:8600", *sic)));
        PlotDoor { sensors: sensors.collect(), ..PlotDoor::default() }
    }

    fn datagram(sics: impl Iterator<Item = u8>) -> Vec<u8> {
        let mut packer = Packer::new(60_000);
        for (n, sic) in sics.enumerate() {
            packer
                .record(&cat010::CATEGORY, |items| {
                    items.put(&cat010::I010, &[1, sic])?;
                    items.put(&cat010::I000, &[1])?;
                    items.put(&cat010::I140, &[n as f64])?;
                    items.put(&cat010::I042, &[1.0, 2.0])
                })
                .expect("fits");
        }
        packer.take().concat()
    }

    fn knock(door: &mut PlotDoor, utc_ns: i64, datagram: &[u8]) {
        let listen = "127.0.0.1:8600".parse().expect("an address");
        door.knock(utc_ns, listen, "10.0.0.7:4000".parse().expect("an address"), datagram);
    }

    fn times(waiting: &[Waiting]) -> Vec<(u16, f64)> {
        let mut times = Vec::new();
        for one in waiting {
            assert!(one.octets.len() <= LONGEST);
            for block in blocks(&one.octets) {
                for record in block.expect("sound").records() {
                    let time_s = record.expect("sound").number(&cat010::I140).expect("a time");
                    times.push((one.sensor, time_s));
                }
            }
        }
        times
    }

    #[test]
    fn every_record_goes_to_its_sensor_once_and_reports_stay_short() {
        let mut door = door(&[2, 3]);
        let mixed = datagram((0..700).map(|n| 2 + (n / 5 % 3) as u8));
        knock(&mut door, UTC_NS, &mixed);
        let found = times(&door.admit(UTC_NS));
        let expected = |sic: u16| (0..700).filter(move |n| 2 + n / 5 % 3 == u32::from(sic));
        for sic in [2, 3] {
            let own: Vec<f64> = found.iter().filter(|(s, _)| *s == sic).map(|(_, t)| *t).collect();
            assert!(own.iter().copied().eq(expected(sic).map(f64::from)), "{sic}");
        }
        let none = "reports of no sensor of the scene, by source and category";
        assert_eq!(door.refused()[none], expected(4).count() as u64);
        assert!(door.admit(UTC_NS).is_empty());
    }

    #[test]
    fn only_the_addresses_of_the_scene_are_taken() {
        let mut door = door(&[2, 3]);
        let ForeignSource::Live { from, .. } = &mut door.sensors[0].1.source else {
            unreachable!("live");
        };
        from.push("10.0.0.8".parse().expect("an address"));
        // From 10.0.0.7: the second sensor takes anybody's.
        knock(&mut door, UTC_NS, &datagram([2, 3].into_iter()));
        assert_eq!(times(&door.admit(UTC_NS)), [(3, 1.0)]);
        let ForeignSource::Live { from, .. } = &mut door.sensors[0].1.source else {
            unreachable!("live");
        };
        from.push("10.0.0.7".parse().expect("an address"));
        knock(&mut door, UTC_NS, &datagram([2, 3].into_iter()));
        assert_eq!(times(&door.admit(UTC_NS)), [(2, 0.0), (3, 1.0)]);
    }

    #[test]
    fn damage_costs_what_is_behind_it() {
        let mut door = door(&[2]);
        let mut octets = datagram([2, 2].into_iter());
        octets.extend_from_slice(&[10, 0, 200, 1]);
        knock(&mut door, UTC_NS, &octets);
        knock(&mut door, UTC_NS, &[99, 0, 4, 0]);
        knock(&mut door, UTC_NS, &[]);
        assert_eq!(times(&door.admit(UTC_NS)).len(), 2);
        assert_eq!(door.refused().values().sum::<u64>(), 2, "{:?}", door.refused());
    }

    #[test]
    fn a_flood_costs_its_sensor_alone() {
        let mut door = door(&[2, 3]);
        let (flood, one) = (datagram((0..2000).map(|_| 2)), datagram([3].into_iter()));
        for frame in 0..50_i64 {
            let utc_ns = UTC_NS + frame * 50_000_000;
            (0..40).for_each(|_| knock(&mut door, utc_ns, &flood));
            knock(&mut door, utc_ns, &one);
            let admitted = door.admit(utc_ns);
            assert!(admitted.iter().map(|w| w.octets.len()).sum::<usize>() <= OCTETS_A_FRAME);
            assert_eq!(admitted.iter().filter(|w| w.sensor == 3).count(), 1, "frame {frame}");
            let waiting: usize = door.waiting.values().flatten().map(|w| w.octets.len()).sum();
            assert_eq!(waiting, door.octets.values().sum::<usize>());
            assert!(waiting <= OCTETS_WAITING);
        }
        assert!(door.refused()["plots over the budget of their sensor"] > 1000);
    }
}
