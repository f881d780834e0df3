//! Places of producers away from busy hosts, by what hosts and federates measure. Where a place is decides nothing of what it makes, so
//! this may be as little repeatable as clocks are.

use crate::runtime::clock::WallNs;
use crate::runtime::messages::{Command, FederateStatus};
use std::collections::BTreeMap;

/// A host whose processors are busy to this share, for so long, gives a place away.
const BUSY_PCT: f64 = 90.0;
const BUSY_NS: WallNs = 10_000_000_000;
/// To a host that is busy to this share at most with it.
const FREE_PCT: f64 = 70.0;
/// From one move to the next: measures are of the time after it by then.
const REST_NS: WallNs = 30_000_000_000;

/// Which hosts are busy, and since when.
#[derive(Debug, Default)]
pub(super) struct Balance {
    busy_since: BTreeMap<String, WallNs>,
    rests_until: WallNs,
}

impl Balance {
    /// What to do by what all `federates` said last, once a second; `places` are those that can be moved.
    pub(super) fn look(
        &mut self,
        now: WallNs,
        federates: &BTreeMap<String, FederateStatus>,
        places: &[String],
    ) -> Option<Command> {
        let measured = |f: &&FederateStatus| f.host_cores > 0;
        let hosts: BTreeMap<&str, (f64, f64)> = federates
            .values()
            .filter(measured)
            .map(|f| (f.host.as_str(), (f.host_busy_pct, f64::from(f.host_cores))))
            .collect();
        let busy = |host: &str| hosts.get(host).is_some_and(|(busy, _)| *busy >= BUSY_PCT);
        self.busy_since.retain(|host, _| busy(host));
        for host in hosts.keys().filter(|host| busy(host)) {
            self.busy_since.entry((*host).to_owned()).or_insert(now);
        }
        if now < self.rests_until {
            return None;
        }
        let movable = |f: &&FederateStatus| places.contains(&f.name);
        // A process with several places divides what it uses among them.
        let share_pct = |f: &FederateStatus| {
            let beside = |o: &&FederateStatus| (&o.host, o.pid) == (&f.host, f.pid);
            f.cpu_pct / federates.values().filter(beside).count().max(1) as f64
        };
        let long = |f: &&FederateStatus| {
            self.busy_since.get(&f.host).is_some_and(|since| now - since >= BUSY_NS)
        };
        let mut given: Vec<&FederateStatus> =
            federates.values().filter(movable).filter(long).collect();
        given.sort_by(|a, b| share_pct(b).total_cmp(&share_pct(a)));
        let takers: Vec<&FederateStatus> = federates.values().filter(movable).collect();
        for place in given {
            let with = |to: &FederateStatus| {
                let (busy, cores) = hosts.get(to.host.as_str())?;
                Some(busy + share_pct(place) / cores)
            };
            let free = |to: &&&FederateStatus| {
                to.host != place.host && with(to).is_some_and(|with| with <= FREE_PCT)
            };
            let order = |a: &&&FederateStatus, b: &&&FederateStatus| {
                with(a).unwrap_or(f64::MAX).total_cmp(&with(b).unwrap_or(f64::MAX))
            };
            if let Some(to) = takers.iter().filter(free).min_by(order) {
                self.rests_until = now + REST_NS;
                return Some(Command::Move { name: place.name.clone(), to: to.name.clone() });
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: WallNs = 1_000_000_000;

    /// Name, process, host, share of a core, %, share of the host's processors, %.
    type Said<'a> = (&'a str, u32, &'a str, f64, f64);

    fn said(all: &[Said<'_>]) -> BTreeMap<String, FederateStatus> {
        let status = |&(name, pid, host, cpu_pct, host_busy_pct): &Said<'_>| FederateStatus {
            name: name.to_owned(),
            host: host.to_owned(),
            pid,
            cpu_pct,
            host_busy_pct,
            host_cores: 2,
            ..FederateStatus::default()
        };
        all.iter().map(|one| (one.0.to_owned(), status(one))).collect()
    }

    fn places() -> Vec<String> {
        ["external-world", "g-1", "g-2", "g-3"].map(str::to_owned).to_vec()
    }

    /// The first command within `seconds`, and when.
    fn within(
        balance: &mut Balance,
        all: &[Said<'_>],
        seconds: u64,
    ) -> Option<(u64, String, String)> {
        (0..seconds).find_map(|s| match balance.look(s * S, &said(all), &places())? {
            Command::Move { name, to } => Some((s, name, to)),
            other => panic!("{other:?}"),
        })
    }

    #[test]
    fn the_largest_place_that_fits_goes_from_a_busy_host_to_the_freest() {
        let all = [
            ("smdfm", 1, "a", 120.0, 98.0),
            ("g-1", 2, "a", 30.0, 98.0),
            ("g-2", 3, "a", 50.0, 98.0),
            ("g-3", 4, "b", 20.0, 40.0),
            ("external-world", 5, "c", 1.0, 50.0),
        ];
        let mut balance = Balance::default();
        let to_b = (10, "g-2".to_owned(), "g-3".to_owned());
        assert_eq!(within(&mut balance, &all, 60), Some(to_b), "only when it was busy for 10 s");
        assert_eq!(balance.look(39 * S, &said(&all), &places()), None, "one in half a minute");
        assert!(balance.look(40 * S, &said(&all), &places()).is_some());
    }

    #[test]
    fn what_fits_nowhere_stays_and_the_next_one_goes() {
        // With 50 of 200 more b would be busy to 75, with 30 to 65.
        let all =
            [("g-1", 2, "a", 30.0, 98.0), ("g-2", 3, "a", 50.0, 98.0), ("g-3", 4, "b", 20.0, 50.0)];
        let to = within(&mut Balance::default(), &all, 20);
        assert_eq!(to.map(|(_, name, to)| (name, to)), Some(("g-1".into(), "g-3".into())));
        let full = [("g-1", 2, "a", 30.0, 98.0), ("g-3", 4, "b", 20.0, 60.0)];
        assert_eq!(within(&mut Balance::default(), &full, 60), None);
    }

    #[test]
    fn a_process_with_several_places_divides_its_use_and_one_host_has_nowhere_to_go() {
        // Together 80 of a core: 40 each, with which b is at 70.
        let all =
            [("g-1", 2, "a", 80.0, 95.0), ("g-2", 2, "a", 80.0, 95.0), ("g-3", 4, "b", 9.0, 50.0)];
        assert!(within(&mut Balance::default(), &all, 20).is_some());
        let alone = [("g-1", 2, "a", 80.0, 100.0), ("g-2", 3, "a", 80.0, 100.0)];
        assert_eq!(within(&mut Balance::default(), &alone, 60), None);
    }

    #[test]
    fn a_host_that_is_busy_now_and_then_keeps_its_places() {
        let busy = |pct| [("g-1", 2, "a", 30.0, pct), ("g-3", 4, "b", 20.0, 10.0)];
        let mut balance = Balance::default();
        for s in 0..100 {
            let pct = if s % 9 == 8 { 80.0 } else { 99.0 };
            assert_eq!(balance.look(s * S, &said(&busy(pct)), &places()), None, "{s}");
        }
    }
}
