//! Tracks of somebody's tracker as they come: ASTERIX from the network, placed in the airport's plane and told to the federation.
//!
//! They change nothing: the log keeps them beside our own. A thread takes datagrams; what comes faster than they are read is
//! dropped and counted, and so is what is damaged, by reason. A time of day is of the day nearest to the last scan.

use super::Gateway;
use super::foreign::{ForeignPlace, ForeignTrack, track};
use crate::runtime::messages::ForeignReport;
use anyhow::Context;
use asterix::blocks;
use asterix::time::of_some_day_ns;
use crossbeam_channel::{Receiver, TrySendError, bounded};
use datalink::LinkConfig;
use geodesy::{Enu, Geodetic, LocalFrame};
use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// Datagrams that may wait.
const WAITING: usize = 1024;
/// Datagrams that are read at once.
const AT_ONCE: usize = 256;
/// Farther than this from the reference point nothing belongs to an airport, m.
const FARTHEST_M: f64 = 100_000.0;
/// Farther than this from the last scan in time nothing belongs to a run, ns.
const FARTHEST_NS: i64 = 3_600_000_000_000;

/// A stream of somebody's tracks.
#[derive(Clone, Debug)]
pub struct HeardLink {
    /// Where it is listened for.
    pub link: LinkConfig,
    /// Only of these senders; of all if there is none.
    pub from: Vec<IpAddr>,
    /// What its positions in metres are about; the scene's reference without it.
    pub about: Option<Geodetic>,
}

struct Arrived {
    /// Which stream.
    stream: usize,
    utc_ns: i64,
    octets: Box<[u8]>,
}

/// Listens for foreign tracks.
pub struct ForeignEar {
    take: Receiver<Arrived>,
    lost: Arc<AtomicU64>,
    ends: Arc<AtomicBool>,
    /// Of each stream.
    references: Vec<Option<LocalFrame>>,
    refused: BTreeMap<String, u64>,
    reports: u64,
}

impl ForeignEar {
    /// Opens the links. Where a stream says `from`, what others send is passed over.
    ///
    /// # Errors
    /// If one cannot be listened on.
    pub fn open(streams: &[HeardLink]) -> anyhow::Result<Self> {
        let references = streams.iter().map(|s| s.about.map(LocalFrame::at)).collect();
        let (put, take) = bounded(WAITING);
        let lost = Arc::new(AtomicU64::new(0));
        let ends = Arc::new(AtomicBool::new(false));
        for (stream, HeardLink { link, from, .. }) in streams.iter().enumerate() {
            let mut receiver = datalink::Receiver::open(link)
                .with_context(|| format!("--asterix-in {}", link.to.first()))?;
            let (put, lost, ends, from) =
                (put.clone(), Arc::clone(&lost), Arc::clone(&ends), from.to_vec());
            std::thread::Builder::new().name("asterix-in".into()).spawn(move || {
                while !ends.load(Ordering::SeqCst) {
                    let heard = receiver.receive(Some(Duration::from_millis(250)), |a| {
                        if !from.is_empty() && !from.contains(&a.from.ip()) {
                            return;
                        }
                        let arrived =
                            Arrived { stream, utc_ns: a.utc_ns, octets: a.payload.into() };
                        if let Err(TrySendError::Full(_)) = put.try_send(arrived) {
                            lost.fetch_add(1, Ordering::Relaxed);
                        }
                    });
                    if let Err(error) = heard {
                        tracing::warn!(%error, "foreign tracks are not heard any more");
                        return;
                    }
                }
            })?;
        }
        Ok(Self { take, lost, ends, references, refused: BTreeMap::new(), reports: 0 })
    }

    /// Reports that were read so far, and what was not, by reason.
    #[must_use]
    pub fn counted(&self) -> (u64, Vec<(String, u64)>) {
        let mut refused: Vec<(String, u64)> = self.refused.clone().into_iter().collect();
        match self.lost.load(Ordering::Relaxed) {
            0 => {}
            lost => refused.push(("foreign datagrams faster than they are read".to_owned(), lost)),
        }
        (self.reports, refused)
    }

    /// What has arrived, as far as it is read at once.
    pub fn poll(&mut self, gateway: &Gateway) -> Vec<ForeignReport> {
        let mut out = Vec::new();
        let arrived: Vec<Arrived> = self.take.try_iter().take(AT_ONCE).collect();
        for Arrived { stream, utc_ns, octets } in arrived {
            self.read(gateway, (stream, utc_ns), &octets, &mut out);
        }
        self.reports += out.len() as u64;
        out
    }

    fn refuse(&mut self, reason: &str) {
        *self.refused.entry(format!("foreign: {reason}")).or_default() += 1;
    }

    /// The good blocks before any damage count.
    fn read(
        &mut self,
        gateway: &Gateway,
        came: (usize, i64),
        octets: &[u8],
        out: &mut Vec<ForeignReport>,
    ) {
        for block in blocks(octets) {
            let block = match block {
                Ok(block) => block,
                Err(e) => return self.refuse(e.fault.word()),
            };
            if block.category.is_none() {
                self.refuse("unknown category");
                continue;
            }
            for record in block.records() {
                match record {
                    Ok(record) => {
                        if let Some(heard) = track(&record) {
                            match self.placed(gateway, came, heard) {
                                Ok(report) => out.push(report),
                                Err(reason) => self.refuse(reason),
                            }
                        }
                    }
                    Err(e) => return self.refuse(e.fault.word()),
                }
            }
        }
    }

    /// A place of the sender's plane in the airport's.
    fn about_reference(
        &self,
        gateway: &Gateway,
        stream: usize,
        [east_m, north_m]: [f64; 2],
    ) -> [f64; 2] {
        match self.references.get(stream) {
            Some(Some(reference)) => {
                let point = reference.to_ecef(Enu { east_m, north_m, up_m: 0.0 });
                let there = gateway.frame.to_enu(point);
                [there.east_m, there.north_m]
            }
            _ => [east_m, north_m],
        }
    }

    /// In the airport's plane and in the time of the run, or why not.
    fn placed(
        &self,
        gateway: &Gateway,
        (stream, received_ns): (usize, i64),
        heard: ForeignTrack,
    ) -> Result<ForeignReport, &'static str> {
        let position_m = match heard.place {
            ForeignPlace::Local(place) => self.about_reference(gateway, stream, place),
            ForeignPlace::Polar([range_m, azimuth_deg]) => {
                let (sin, cos) = libm::sincos(azimuth_deg.to_radians());
                let (sac, sic) = heard.source;
                // A sensor of the scene sees from where it stands (targets on the ground); of others only the reference is known.
                match gateway.sites.get(&sic).filter(|_| sac == gateway.choice.sac) {
                    Some([east_m, north_m, up_m]) => {
                        let ground_m = (range_m * range_m - up_m * up_m).max(0.0).sqrt();
                        [east_m + ground_m * sin, north_m + ground_m * cos]
                    }
                    None => self.about_reference(gateway, stream, [range_m * sin, range_m * cos]),
                }
            }
            ForeignPlace::Degrees([lat, lon]) => {
                // Its point of the airport's plane: the ray of geocentric coordinates through the place on the ellipsoid.
                let height_m = gateway.frame.origin_geodetic().height_m;
                let there =
                    gateway.frame.to_enu(Geodetic::from_degrees(lat, lon, height_m).to_ecef());
                [there.east_m, there.north_m]
            }
        };
        if !(libm::hypot(position_m[0], position_m[1]) <= FARTHEST_M) {
            return Err("position out of 100 km");
        }
        let near_ns = gateway.utc_ns(gateway.last_ns);
        let off_ns = of_some_day_ns((heard.of_day_s * 1e9).round() as i64, near_ns) - near_ns;
        if off_ns.abs() > FARTHEST_NS {
            return Err("time more than an hour from the run's");
        }
        let (sac, sic) = heard.source;
        Ok(ForeignReport {
            source: format!("{sac}/{sic}"),
            track: heard.number,
            time_ns: gateway.last_ns + off_ns,
            position_m: position_m.into(),
            velocity_mps: heard.velocity_mps,
            callsign: heard.label,
            coasting: heard.coasting,
            last: heard.last,
            received_ns,
        })
    }
}

impl Drop for ForeignEar {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::SeqCst);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gateway::Choice;
    use asterix::time::of_day_s;
    use asterix::{Packer, cat062};
    use models::frames::Point2;

    fn system_track(number: u32, time_s: f64, place: [f64; 2]) -> Vec<u8> {
        let mut packer = Packer::new(1400);
        packer
            .record(&cat062::CATEGORY, |items| {
                items.put(&cat062::I010, &[77, 9])?;
                items.put(&cat062::I070, &[time_s])?;
                items.put(&cat062::I100, &place)?;
                items.put(&cat062::I185, &[3.0, -4.0])?;
                items.put(&cat062::I040, &[number])
            })
            .expect("it fits");
        packer.take().concat()
    }

    /// Places in metres about another point, and range and azimuth about a sensor's site or that point, on two airports.
    #[test]
    fn tracks_are_placed_about_their_reference_and_about_the_site_of_their_sensor() {
        for name in ["zurich", "eham"] {
            let scene = scenarios::load_without_truth(&scenarios::locate(name)).expect("the scene");
            let gateway = Gateway::new(&scene, Choice::default());
            let frame = &gateway.frame;
            let radar = scene.sensors.iter().find(|s| s.site_m.is_some()).expect("a radar");
            let (sic, site_m) = (radar.id.0 as u8, radar.site_m.expect("a site"));
            let origin = frame.origin_geodetic();
            let other = Geodetic::from_degrees(
                origin.lat_deg() + 0.03,
                origin.lon_deg() - 0.05,
                origin.height_m + 20.0,
            );
            let there = LocalFrame::at(other);
            let wanted = [1234.0, -987.0];
            let point = frame.to_ecef(Enu { east_m: wanted[0], north_m: wanted[1], up_m: 0.0 });
            let theirs = there.to_enu(point);
            let heard = |source: (u8, u8), place: ForeignPlace, about: Option<Geodetic>| {
                let mut ear = ForeignEar::open(&[]).expect("nothing to open");
                ear.references = vec![None, about.map(LocalFrame::at)];
                let track = ForeignTrack {
                    source,
                    category: 10,
                    number: 1,
                    of_day_s: of_day_s(gateway.utc_ns(0)),
                    place,
                    velocity_mps: None,
                    label: String::new(),
                    tentative: false,
                    coasting: false,
                    last: false,
                };
                let report = ear.placed(&gateway, (1, 0), track).expect("near");
                libm::hypot(report.position_m[0] - wanted[0], report.position_m[1] - wanted[1])
            };
            let local = ForeignPlace::Local([theirs.east_m, theirs.north_m]);
            assert!(heard((0, 99), local, Some(other)) < 0.05, "{name}: in its own plane");
            assert!(heard((0, 99), local, None) > 4000.0, "{name}: not about ours");
            let own = ForeignPlace::Local(wanted);
            assert!(heard((0, 99), own, None) < 1e-9, "{name}: about ours");
            let (e, n) = (wanted[0] - site_m.x, wanted[1] - site_m.y);
            let polar = |e: f64, n: f64, up: f64| {
                let range_m = libm::sqrt(e * e + n * n + up * up);
                ForeignPlace::Polar([range_m, libm::atan2(e, n).to_degrees()])
            };
            assert!(heard((0, sic), polar(e, n, site_m.z), None) < 1e-6, "{name}: from its site");
            assert!(heard((0, sic), polar(e, n, site_m.z), Some(other)) < 1e-6, "{name}");
            // The same number at somebody else's is no sensor of the scene.
            let far = polar(theirs.east_m, theirs.north_m, 0.0);
            assert!(heard((7, sic), far, Some(other)) < 0.05, "{name}: from the reference");
        }
    }

    /// Whatever one sender has for a clock, or sends by mistake, the tracks of all others keep their day; who is an hour off is refused.
    #[test]
    fn one_clock_that_is_wrong_moves_nobody_elses_day() {
        let mut scene =
            scenarios::load_without_truth(&scenarios::locate("zurich")).expect("the scene");
        scene.run.start_utc_ns = 1_574_640_000_000_000_000 - 7200 * 1_000_000_000; // 22:00
        let mut gateway = Gateway::new(&scene, Choice::default());
        let mut ear = ForeignEar::open(&[]).expect("nothing to open");
        let mut times = |gateway: &Gateway, of_day_s: &[f64]| -> Vec<i64> {
            let mut out = Vec::new();
            for of_day_s in of_day_s {
                ear.read(gateway, (0, 5), &system_track(12, *of_day_s, [0.0, 0.0]), &mut out);
            }
            out.iter().map(|r| r.time_ns / 1_000_000_000).collect()
        };
        // At ten o'clock, and from a clock half a day and one a whole afternoon off, again and again.
        let wrong = [36_000.0, 72_000.0, 20_000.0, 60_000.0, 10_000.0, 50_000.0];
        assert!(times(&gateway, &wrong).is_empty());
        assert_eq!(times(&gateway, &[79_201.0, 82_799.0, 82_802.0, 75_601.0]), [1, 3599, -3599]);
        // Two hours and a half later it is another day.
        let time_ns = 9000 * 1_000_000_000;
        let scan = crate::runtime::messages::ScanReport {
            run: 1,
            scan: 9000,
            time_ns,
            ..Default::default()
        };
        gateway.on_scan(&scan);
        assert_eq!(times(&gateway, &[1801.0, 86_399.0, 79_201.0]), [9001, 7199]);
        let (_, refused) = ear.counted();
        let reason = "foreign: time more than an hour from the run's".to_owned();
        assert_eq!(refused, [(reason, 8)]);
    }

    #[test]
    fn tracks_are_placed_and_timed_and_damage_is_counted() {
        let mut scene =
            scenarios::load_without_truth(&scenarios::locate("zurich")).expect("the scene");
        scene.run.start_utc_ns = 1_574_640_000_000_000_000 - 2_000_000_000; // 23:59:58
        let gateway = Gateway::new(&scene, Choice::default());
        let port = datalink::free_port().expect("a port");
        let at = std::net::SocketAddr::from(([127, 0, 0, 1], port));
        let link = LinkConfig {
            to: at.to_string().parse().expect("an address"),
            listen: Some(at),
            ..LinkConfig::default()
        };
        let mut ear = ForeignEar::open(&[HeardLink { link, from: Vec::new(), about: None }])
            .expect("it listens");
        let mut out = Vec::new();
        ear.read(&gateway, (0, 5), &system_track(12, 86_399.0, [100.0, -50.0]), &mut out);
        let far = system_track(12, 1.5, [200_000.0, 0.0]);
        let two = [system_track(12, 1.5, [103.0, -54.0]), vec![62, 0, 200, 1]].concat();
        ear.read(&gateway, (0, 6), &two, &mut out);
        ear.read(&gateway, (0, 7), &far, &mut out);
        ear.read(&gateway, (0, 8), &[99, 0, 4, 1], &mut out);
        let times: Vec<i64> = out.iter().map(|r| r.time_ns).collect();
        assert_eq!(times, [1_000_000_000, 3_500_000_000], "over midnight");
        assert_eq!((out[1].source.as_str(), out[1].track, out[1].received_ns), ("77/9", 12, 6));
        assert_eq!(out[1].position_m, Point2::new(103.0, -54.0));
        assert_eq!(out[1].velocity_mps, Some([3.0, -4.0]));
        let (_, refused) = ear.counted();
        assert_eq!(refused.len(), 3, "{refused:?}");
        assert!(refused.iter().all(|(_, n)| *n == 1), "{refused:?}");
        // A flood is dropped and counted; memory is bounded.
        let flood: Vec<Arrived> = (0..2000)
            .map(|_| Arrived { stream: 0, utc_ns: 0, octets: far.clone().into() })
            .collect();
        let (put, take) = bounded(WAITING);
        ear.take = take;
        let taken = flood.into_iter().map(|a| put.try_send(a).is_ok()).filter(|ok| *ok).count();
        assert_eq!(taken, WAITING);
        assert!(ear.poll(&gateway).is_empty());
        assert_eq!(ear.take.len(), WAITING - AT_ONCE);
    }
}
