//! Whether the clocks of the hosts agree. Frames need no common time; stamps of arrival in recordings, latencies and the UTC that
//! outsiders are told do, so a person must hear of it.

use super::clock::WallNs;
use std::collections::{BTreeMap, VecDeque};

/// What is heard of the other hosts' clocks.
#[derive(Debug)]
pub struct Clocks {
    own: String,
    hosts: BTreeMap<String, Clock>,
}

/// One host's clock.
#[derive(Debug, Default)]
struct Clock {
    /// When a beat came (monotonic), and how far the own UTC was then beyond the UTC that it was sent at.
    samples: VecDeque<(WallNs, i64)>,
    alarm: Option<String>,
}

/// Clocks that differ by more are told of. A beat takes less on any network on which a run is bearable.
const APART_NS: i64 = 500_000_000;
/// They agree again below this.
const AGREE_NS: i64 = 250_000_000;
/// A word needs beats of so long, of which the fastest counts: some wait in a queue after a pause or a cut link.
const SPAN_NS: WallNs = 1_000_000_000;
const SAMPLES: usize = 20;
/// Anybody may join as a spectator under any host's name.
const HOSTS: usize = 64;

impl Clocks {
    /// Of the station on host `own`.
    #[must_use]
    pub fn of(own: String) -> Self {
        Self { own, hosts: BTreeMap::new() }
    }

    /// A beat of a federate on `host`, sent there at `sent_ns` (UTC; 0: not told), came at `now` and `came_ns` (UTC): what is to be said.
    pub fn heard(&mut self, now: WallNs, host: &str, sent_ns: i64, came_ns: i64) -> Option<String> {
        let known = self.hosts.contains_key(host);
        if sent_ns == 0 || host == self.own || !known && self.hosts.len() >= HOSTS {
            return None;
        }
        let clock = self.hosts.entry(host.to_owned()).or_default();
        clock.samples.push_back((now, came_ns.saturating_sub(sent_ns)));
        let old = |(at, _): &(WallNs, i64)| now.saturating_sub(*at) > 2 * SPAN_NS;
        while clock.samples.len() > SAMPLES || clock.samples.front().is_some_and(old) {
            clock.samples.pop_front();
        }
        let since = clock.samples.front().map_or(now, |(at, _)| *at);
        if now.saturating_sub(since) < SPAN_NS {
            return None;
        }
        let apart_ns = clock.samples.iter().map(|(_, ns)| *ns).min().unwrap_or(0);
        if clock.alarm.is_some() {
            if apart_ns.abs() >= AGREE_NS {
                return None;
            }
            clock.alarm = None;
            return Some(format!("the clock of host {host} agrees with the one here now"));
        }
        if apart_ns.abs() < APART_NS {
            return None;
        }
        let way = if apart_ns < 0 { "ahead of" } else { "behind" };
        let text = format!(
            "the clock of host {host} is {:.1} s {way} the one here ({}): stamps in recordings, latencies and UTC differ by that (the frames do not): let both hosts follow one time server (chronyc tracking, timedatectl)",
            apart_ns.unsigned_abs() as f64 * 1e-9,
            self.own
        );
        clock.alarm = Some(text.clone());
        Some(text)
    }

    /// How far the clock of each other host is ahead of the one here, s, by the fastest beat of the last seconds.
    pub fn ahead_s(&self) -> impl Iterator<Item = (&str, f64)> {
        self.hosts.iter().filter_map(|(host, clock)| {
            let apart_ns = clock.samples.iter().map(|(_, ns)| *ns).min()?;
            Some((&host[..], -(apart_ns as f64) * 1e-9))
        })
    }

    /// What is wrong now.
    pub fn alarms(&self) -> impl Iterator<Item = &str> {
        self.hosts.values().filter_map(|clock| clock.alarm.as_deref())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;
    const UTC: i64 = 1_790_000_000_000_000_000;

    /// Ten beats a second of `host`, whose clock is `ahead_ms` ahead, each `late_ms(ms)` under way: what was said, and when first.
    fn beats(
        clocks: &mut Clocks,
        host: &str,
        from_ms: u64,
        to_ms: u64,
        ahead_ms: i64,
        late_ms: impl Fn(u64) -> u64,
    ) -> (Vec<String>, Option<u64>) {
        let (mut said, mut first) = (Vec::new(), None);
        for ms in (from_ms..to_ms).step_by(100) {
            let came = ms + late_ms(ms);
            let sent_ns = UTC + (ms as i64 + ahead_ms) * MS as i64;
            let text = clocks.heard(came * MS, host, sent_ns, UTC + (came * MS) as i64);
            if text.is_some() {
                first.get_or_insert(came - from_ms);
            }
            said.extend(text);
        }
        (said, first)
    }

    #[test]
    fn a_clock_that_is_off_is_told_within_two_seconds_and_once() {
        for (ahead_ms, words) in
            [(3_000, "3.0 s ahead of"), (-700, "0.7 s behind"), (-86_400_000, "86400.0 s behind")]
        {
            let mut clocks = Clocks::of("a".into());
            let (said, first) = beats(&mut clocks, "b", 0, 20_000, ahead_ms, |_| 5);
            assert_eq!(said.len(), 1, "{said:?}");
            assert!(said[0].contains("host b") && said[0].contains(words), "{said:?}");
            assert!(said[0].contains("chronyc"), "what to do: {said:?}");
            assert!(first.is_some_and(|ms| ms <= 2_000), "{first:?}");
            assert!(clocks.alarms().eq([said[0].as_str()]));
            let ahead: Vec<_> = clocks.ahead_s().collect();
            let under_way = 0.005;
            assert!(ahead[0].0 == "b", "{ahead:?}");
            assert!((ahead[0].1 + under_way - ahead_ms as f64 * 1e-3).abs() < 1e-6, "{ahead:?}");
            let (said, _) = beats(&mut clocks, "b", 20_000, 25_000, 10, |_| 5);
            assert!(said.len() == 1 && said[0].contains("agrees"), "{said:?}");
            assert_eq!(clocks.alarms().count(), 0);
        }
    }

    #[test]
    fn a_slow_network_a_pause_and_the_own_host_are_no_word() {
        let mut clocks = Clocks::of("a".into());
        assert!(beats(&mut clocks, "b", 0, 5_000, 200, |ms| ms % 300).0.is_empty());
        // Five seconds in which nothing goes through: all of it comes at once, the last of it fresh.
        let (said, _) =
            beats(&mut clocks, "b", 5_000, 15_000, 0, |ms| 10_000u64.saturating_sub(ms));
        assert!(said.is_empty(), "{said:?}");
        assert!(beats(&mut clocks, "a", 0, 5_000, 3_000, |_| 0).0.is_empty(), "the own host");
        let untold = (0..50).filter_map(|n| clocks.heard(n * 100 * MS, "c", 0, UTC)).count();
        assert_eq!(untold, 0, "one that tells no time");
    }

    #[test]
    fn a_crowd_of_hosts_fills_no_memory() {
        let mut clocks = Clocks::of("a".into());
        for n in 0..10_000 {
            clocks.heard(n * MS, &format!("forged-{n}"), UTC, UTC);
        }
        assert_eq!(clocks.hosts.len(), HOSTS);
    }
}
