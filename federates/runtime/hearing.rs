//! Whether a consumer hears its producers on the data plane. A datagram that is lost is repaired over the other
//! plane and changes no result; a whole data plane that is dead is a fault that a person must hear of.

use super::clock::WallNs;
use super::messages::Kind;
use std::collections::BTreeMap;

/// What a data plane is called, for messages to people.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Group, broadcast address or list of hosts.
    pub group: String,
    /// Interface.
    pub interface: String,
    /// Share of datagrams dropped on purpose.
    pub loss: f64,
}

/// What a consumer hears of each producer.
#[derive(Debug, Default)]
pub struct Hearing {
    plane: Option<Plane>,
    producers: BTreeMap<String, Heard>,
    now: WallNs,
    run: u32,
    /// Producers that were ready for a run before this process was configured for it, and which run.
    early: BTreeMap<String, u32>,
}

#[derive(Debug, Default)]
struct Heard {
    /// When it said that it is ready; its probes go out from then on.
    ready_at: Option<WallNs>,
    /// PDUs and probes that came by themselves.
    direct: u64,
    /// PDUs that came by repair.
    repaired: u64,
    /// Since when nothing has come by itself, and how many PDUs were named since.
    silent: (WallNs, u64),
    /// Since when it looks deaf; time for what waits in a socket after a pause of this process.
    suspect: Option<WallNs>,
    /// The last 10 s: since when, PDUs that came by themselves and by repair.
    lately: (WallNs, u64, u64),
    alarm: Option<String>,
    /// Short probes that came, since when, and whether a long one did.
    short: (u32, WallNs),
    long: bool,
    /// Short datagrams come and long ones do not.
    narrow: Option<String>,
}

/// PDUs named without one that came: beyond this, loss by chance is ruled out.
const NAMED: f64 = 20.0;
/// How long nothing must have come.
const SILENT_NS: WallNs = 1_000_000_000;
/// How long that must be seen, on top of it.
const SUSPECT_NS: WallNs = 400_000_000;
const LATELY_NS: WallNs = 10_000_000_000;
/// Short probes without a long one, and for how long: beyond this, loss by chance is ruled out.
const SHORT: u32 = 4;
const NARROW_NS: WallNs = 1_000_000_000;
/// Producers that may be sooner than this process, more than a federation has.
const EARLY: usize = 256;
/// How often [`Hearing::tick`] wants to be called.
pub const LOOK_NS: WallNs = 200_000_000;

impl Hearing {
    /// There is a data plane outside this process, called `plane`.
    pub fn on(&mut self, plane: Plane) {
        self.plane = Some(plane);
    }

    /// A run begins, in which this process reads `producers`.
    pub fn configure<'a>(&mut self, run: u32, producers: impl Iterator<Item = &'a String>) {
        self.producers.clear();
        self.run = run;
        let early = std::mem::take(&mut self.early);
        for producer in producers.filter(|name| early.get(*name) == Some(&run) && sends_pdus(name))
        {
            self.ready(self.now, producer, run);
        }
    }

    /// `producer` is configured for `run` and sends probes from now on. It may be sooner than this process.
    pub fn ready(&mut self, now: WallNs, producer: &str, run: u32) {
        self.now = now;
        if run != self.run {
            if run > self.run && (self.early.len() < EARLY || self.early.contains_key(producer)) {
                self.early.insert(producer.to_owned(), run);
            }
            return;
        }
        if !sends_pdus(producer) {
            return;
        }
        let heard = self.of(producer);
        heard.ready_at.get_or_insert(now);
        heard.silent.0 = now;
    }

    /// `producer` has named `count` PDUs, of which `direct` had come by themselves.
    pub fn named(&mut self, now: WallNs, producer: &str, count: u64, direct: u64) {
        self.now = now;
        if count == 0 {
            return;
        }
        let heard = self.of(producer);
        if heard.silent.1 == 0 {
            heard.silent.0 = now;
        }
        heard.silent.1 += count;
        self.came(producer, direct);
    }

    /// `count` PDUs or probes of `producer` came by themselves.
    pub fn came(&mut self, producer: &str, count: u64) {
        let now = self.now;
        if count == 0 {
            return;
        }
        let heard = self.of(producer);
        heard.direct += count;
        heard.lately.1 += count;
        heard.silent = (now, 0);
        heard.suspect = None;
        if heard.alarm.take().is_some() {
            tracing::info!("hears {producer} on the data plane now");
        }
    }

    /// A probe of `producer` came, a short one or one as long as the longest datagram.
    pub fn probed(&mut self, producer: &str, long: bool) {
        let now = self.now;
        let heard = self.of(producer);
        heard.long |= long;
        if !long {
            heard.short = (heard.short.0 + 1, if heard.short.0 == 0 { now } else { heard.short.1 });
        } else if heard.narrow.take().is_some() {
            tracing::info!("hears long PDUs of {producer} now");
        }
        self.came(producer, 1);
    }

    /// `count` PDUs of `producer` came by repair.
    pub fn repaired(&mut self, producer: &str, count: u64) {
        let heard = self.of(producer);
        heard.repaired += count;
        heard.lately.2 += count;
    }

    fn of(&mut self, producer: &str) -> &mut Heard {
        if !self.producers.contains_key(producer) {
            self.producers.insert(producer.to_owned(), Heard::default());
        }
        self.producers.get_mut(producer).expect("it was put there")
    }

    /// Time passed: what has gone wrong since the last call, for a person.
    pub fn tick(&mut self, now: WallNs) -> Vec<String> {
        self.now = now;
        let Some(plane) = &self.plane else { return Vec::new() };
        let needed = (NAMED / (1.0 - plane.loss)) as u64;
        let mut said = Vec::new();
        for (name, heard) in &mut self.producers {
            let long = now.saturating_sub(heard.silent.0) >= SILENT_NS;
            let never = heard.direct == 0 && heard.ready_at.is_some();
            if long && (never || heard.silent.1 >= needed) {
                let since = *heard.suspect.get_or_insert(now);
                if now.saturating_sub(since) >= SUSPECT_NS && heard.alarm.is_none() {
                    said.push(heard.sound(none_of(name, heard.repaired, plane)));
                }
            }
            let (short, since) = heard.short;
            let only_short = !heard.long && short >= SHORT;
            if only_short && heard.narrow.is_none() && now.saturating_sub(since) >= NARROW_NS {
                let text = format!(
                    "hears short PDUs of {name} on {} via {} and none of 1400 octets, which are repaired over the other plane: a host or switch between has a smaller MTU: give all of them the same (ip link set dev INTERFACE mtu 1500)",
                    plane.group, plane.interface
                );
                heard.narrow = Some(text.clone());
                said.push(text);
            }
            let (since, direct, repaired) = heard.lately;
            if now.saturating_sub(since) >= LATELY_NS {
                if repaired > direct && repaired >= needed && heard.alarm.is_none() {
                    let all = direct + repaired;
                    let text = format!(
                        "{repaired} of the last {all} PDUs of {name} on {} via {} came only by repair over the other plane: an overloaded network or receiver",
                        plane.group, plane.interface
                    );
                    said.push(heard.sound(text));
                }
                heard.lately = (now, 0, 0);
            }
        }
        said
    }

    /// The run ends: what a run too short for [`Hearing::tick`] would otherwise never say.
    pub fn finish(&mut self) -> Vec<String> {
        let Some(plane) = &self.plane else { return Vec::new() };
        let needed = (NAMED / (1.0 - plane.loss)) as u64;
        let now = self.now;
        let deaf = |(_, h): &(&String, &mut Heard)| {
            // A producer of few PDUs: not one came, and none of its probes for a second.
            let probed = h.ready_at.is_some_and(|at| now.saturating_sub(at) >= SILENT_NS);
            let few = h.repaired > 0 && probed && plane.loss == 0.0;
            h.direct == 0 && (few || h.repaired >= needed) && h.alarm.is_none()
        };
        let deaf = self.producers.iter_mut().filter(deaf);
        deaf.map(|(name, heard)| heard.sound(none_of(name, heard.repaired, plane))).collect()
    }

    /// What is wrong now.
    pub fn alarms(&self) -> impl Iterator<Item = &str> {
        self.producers
            .values()
            .flat_map(|h| [&h.alarm, &h.narrow])
            .filter_map(|alarm| alarm.as_deref())
    }
}

/// Whether a member of this name sends PDUs: an SMDFM beside the first, and control, tell notices alone.
fn sends_pdus(name: &str) -> bool {
    ![Kind::Smdfm, Kind::Control].iter().any(|kind| name.starts_with(kind.name()))
}

impl Heard {
    fn sound(&mut self, text: String) -> String {
        self.alarm = Some(text.clone());
        text
    }
}

fn none_of(name: &str, repaired: u64, plane: &Plane) -> String {
    format!(
        "hears none of {name}'s PDUs on {} via {} ({repaired} repaired over the other plane): wrong group, interface or firewall",
        plane.group, plane.interface
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: WallNs = 1_000_000;

    fn hearing(loss: f64) -> Hearing {
        let mut hearing = Hearing::default();
        hearing.on(Plane { group: "239.1.2.3:3000".into(), interface: "10.0.0.1".into(), loss });
        hearing
    }

    /// Ticks every 200 ms from `from_ms` to `to_ms`; what was said, and when first.
    fn ticks(hearing: &mut Hearing, from_ms: u64, to_ms: u64) -> (Vec<String>, Option<u64>) {
        let mut said = Vec::new();
        let mut first = None;
        for ms in (from_ms..to_ms).step_by(200) {
            let now = hearing.tick(ms * MS);
            if !now.is_empty() {
                first.get_or_insert(ms);
            }
            said.extend(now);
        }
        (said, first)
    }

    #[test]
    fn who_sends_no_pdus_is_not_missed_on_the_data_plane() {
        let mut hearing = hearing(0.0);
        let names = ["control", "smdfm-2", "traffic-generator-3"].map(str::to_owned);
        hearing.ready(0, "smdfm-3", 1);
        hearing.configure(1, names.iter());
        for name in &names {
            hearing.ready(0, name, 1);
        }
        let (said, _) = ticks(&mut hearing, 200, 5_000);
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(said[0].contains("traffic-generator-3"), "{said:?}");
    }

    #[test]
    fn a_dead_data_plane_is_told_within_two_seconds_of_being_configured() {
        let mut hearing = hearing(0.0);
        hearing.ready(100 * MS, "traffic-generator", 0);
        hearing.ready(100 * MS, "external-world", 0);
        hearing.came("external-world", 1);
        let (said, first) = ticks(&mut hearing, 200, 20_000);
        assert_eq!(
            said,
            [
                "hears none of traffic-generator's PDUs on 239.1.2.3:3000 via 10.0.0.1 (0 repaired over the other plane): wrong group, interface or firewall"
            ]
        );
        assert!(first.is_some_and(|ms| ms <= 2_100), "{first:?}");
        assert_eq!(hearing.alarms().count(), 1);
        hearing.came("traffic-generator", 1);
        assert_eq!(hearing.alarms().count(), 0, "heard again");
    }

    #[test]
    fn a_producer_that_was_ready_sooner_than_this_process_is_missed_as_well() {
        for (run, missed) in [(1, 1), (2, 0)] {
            let mut hearing = hearing(0.0);
            hearing.ready(100 * MS, "external-world", run);
            hearing.ready(100 * MS, "somebody", run);
            hearing.configure(1, [&"external-world".to_owned()].into_iter());
            let (said, _) = ticks(&mut hearing, 200, 20_000);
            assert_eq!(said.len(), missed, "{run}: {said:?}");
        }
    }

    #[test]
    fn a_way_that_lets_short_datagrams_through_only_is_told_within_two_seconds() {
        let probes = |longs: &[u64]| {
            let mut hearing = hearing(0.0);
            hearing.ready(0, "g", 0);
            let (mut said, mut first) = (Vec::new(), None);
            for ms in (0..6_000).step_by(100) {
                said.extend(hearing.tick(ms * MS));
                if !said.is_empty() {
                    first.get_or_insert(ms);
                }
                if ms % 300 == 0 && ms < 3_000 {
                    hearing.probed("g", false);
                }
                if longs.contains(&ms) {
                    hearing.probed("g", true);
                }
            }
            (said, first, hearing.alarms().count())
        };
        let (said, first, alarms) = probes(&[]);
        assert!(said.len() == 1 && said[0].contains("smaller MTU") && said[0].contains("ip link"));
        assert!(first.is_some_and(|ms| ms <= 2_000) && alarms == 1, "{first:?}, {alarms}");
        // Three of four lost by chance are no word; one that comes later ends it.
        assert_eq!(probes(&[900]).0, Vec::<String>::new());
        let (said, _, alarms) = probes(&[3_000]);
        assert_eq!((said.len(), alarms), (1, 0));
        // Three short ones: chance may have taken the long ones.
        let mut few = hearing(0.0);
        few.ready(0, "g", 0);
        for _ in 0..3 {
            few.probed("g", false);
        }
        assert_eq!(ticks(&mut few, 200, 9_000).0, Vec::<String>::new());
    }

    #[test]
    fn a_data_plane_that_dies_under_way_is_told_and_chance_is_not() {
        for (loss, named, words) in [(0.0, 25, true), (0.9, 25, false), (0.9, 250, true)] {
            let mut hearing = hearing(loss);
            hearing.ready(0, "g", 0);
            hearing.named(0, "g", 500, 400);
            hearing.named(100 * MS, "g", named, 0);
            hearing.repaired("g", named);
            let (said, first) = ticks(&mut hearing, 200, 9_000);
            assert_eq!(!said.is_empty(), words, "loss {loss}, {named} named: {said:?}");
            assert!(!words || first.is_some_and(|ms| ms <= 2_100), "{first:?}");
        }
        // Silence with nothing named: a scene where everything is parked, or a producer that is gone.
        let mut quiet = hearing(0.0);
        quiet.ready(0, "g", 0);
        quiet.named(0, "g", 500, 500);
        assert_eq!(ticks(&mut quiet, 200, 60_000).0, Vec::<String>::new());
    }

    #[test]
    fn a_paused_consumer_first_reads_what_waits_for_it() {
        let mut hearing = hearing(0.0);
        hearing.ready(0, "g", 0);
        hearing.named(0, "g", 100, 100);
        // Paused for 5 s; the reports of that time come before the datagrams.
        hearing.named(5_000 * MS, "g", 100, 0);
        assert!(hearing.tick(5_001 * MS).is_empty());
        hearing.named(6_100 * MS, "g", 1, 0);
        assert!(hearing.tick(6_101 * MS).is_empty());
        hearing.came("g", 101);
        assert_eq!(ticks(&mut hearing, 6_300, 20_000).0, Vec::<String>::new());
    }

    #[test]
    fn more_than_half_repaired_is_told() {
        let mut hearing = hearing(0.0);
        hearing.ready(0, "g", 0);
        let mut said = Vec::new();
        for ms in (0..30_000).step_by(200) {
            hearing.named(ms * MS, "g", 10, 4);
            hearing.repaired("g", 6);
            said.extend(hearing.tick(ms * MS));
        }
        assert_eq!(said.iter().filter(|s| s.contains("only by repair")).count(), said.len());
        assert!(!said.is_empty());
    }

    #[test]
    fn a_run_too_short_for_the_clock_is_told_at_its_end() {
        let mut deaf = hearing(0.0);
        deaf.named(0, "g", 100, 0);
        deaf.repaired("g", 100);
        assert_eq!(deaf.finish().len(), 1);
        // A producer of few PDUs, of whose probes none has come for a second either; one that was ready just now is not told.
        for (ready_ms, told) in [(0, 1), (700, 0)] {
            let mut deaf = hearing(0.0);
            deaf.ready(ready_ms * MS, "world", 0);
            deaf.named(1_500 * MS, "world", 3, 0);
            deaf.repaired("world", 3);
            assert_eq!(deaf.finish().len(), told, "ready at {ready_ms} ms");
        }
        let mut in_one_process = Hearing::default();
        in_one_process.named(0, "g", 100, 0);
        in_one_process.repaired("g", 100);
        assert!(in_one_process.finish().is_empty());
    }
}
