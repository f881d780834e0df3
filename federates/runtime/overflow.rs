//! Datagrams that the system throws away because a receive buffer is full: nothing is lost by it, all of them are repaired over the
//! other plane, but a run that lives on repair is slow, and a person can mend it.

use super::clock::WallNs;
use super::hearing::Plane;

/// What became of one receive buffer.
#[derive(Debug, Default)]
pub struct Overflow {
    dropped: u64,
    /// When it last overflowed.
    last: Option<WallNs>,
    alarm: Option<String>,
}

/// So long after the last loss it is one of the past.
const PAST_NS: WallNs = 10_000_000_000;

impl Overflow {
    /// `dropped` datagrams were thrown away up to now, by a buffer of which (`asked`, `obtained`) octets were asked for and obtained: a word,
    /// when it begins.
    pub fn look(
        &mut self,
        now: WallNs,
        dropped: u64,
        (asked, obtained): (usize, usize),
        plane: Option<&Plane>,
    ) -> Option<String> {
        if dropped <= self.dropped {
            if self.last.is_some_and(|last| now.saturating_sub(last) >= PAST_NS) {
                (self.last, self.alarm) = (None, None);
            }
            return None;
        }
        let lost = dropped - self.dropped;
        self.dropped = dropped;
        self.last = Some(now);
        // The counters go on; the word stays what it was, or it would be said again for each loss.
        if self.alarm.is_some() {
            return None;
        }
        let on = plane.map_or_else(String::new, |p| format!(" on {} via {}", p.group, p.interface));
        let what = if obtained < asked {
            format!(
                "{obtained} octets instead of {asked}: sysctl -w net.core.rmem_max={asked} allows more"
            )
        } else {
            format!("{obtained} octets: this host has too much to do, or somebody floods it")
        };
        let text = format!(
            "loses datagrams{on} ({lost} at once, repaired over the other plane): its receive buffer is full, {what}"
        );
        self.alarm = Some(text.clone());
        Some(text)
    }

    /// What is wrong now.
    #[must_use]
    pub fn alarm(&self) -> Option<&str> {
        self.alarm.as_deref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: WallNs = 1_000_000_000;

    #[test]
    fn a_full_buffer_is_told_when_it_begins_with_what_to_do_and_forgotten_afterwards() {
        let plane =
            Plane { group: "239.1.2.3:3000".into(), interface: "10.0.0.1".into(), loss: 0.0 };
        let small = (4 << 20, 212_992);
        let mut overflow = Overflow::default();
        assert_eq!(overflow.look(S, 0, small, Some(&plane)), None);
        let said = overflow.look(2 * S, 30, small, Some(&plane)).expect("a word");
        assert_eq!(
            said,
            "loses datagrams on 239.1.2.3:3000 via 10.0.0.1 (30 at once, repaired over the other plane): its receive buffer is full, 212992 octets instead of 4194304: sysctl -w net.core.rmem_max=4194304 allows more"
        );
        assert_eq!(overflow.look(3 * S, 70, small, Some(&plane)), None, "said once");
        assert_eq!(overflow.alarm(), Some(said.as_str()), "and not changed");
        assert_eq!(overflow.look(12 * S, 70, small, Some(&plane)), None);
        assert!(overflow.alarm().is_some());
        assert_eq!(overflow.look(13 * S, 70, small, Some(&plane)), None);
        assert_eq!(overflow.alarm(), None, "ten seconds without a loss");
        let said = overflow.look(14 * S, 71, (4 << 20, 4 << 20), None).expect("it begins again");
        assert!(said.contains("(1 at once") && said.contains("too much to do"), "{said}");
        assert!(!said.contains("sysctl"), "more would not be obtained: {said}");
    }
}
