//! How long a member waits for the station of its own federation.

use super::clock::WallNs;

/// A station is waited for so long, ns.
pub const GRACE_NS: WallNs = 120_000_000_000;

/// Since when the station of a federation is not there.
#[derive(Debug)]
pub struct Grace {
    fed: u128,
    since: Option<WallNs>,
}

impl Grace {
    /// In the federation `fed`, whose station was heard.
    #[must_use]
    pub fn new(fed: u128) -> Self {
        Self { fed, since: None }
    }

    /// No connection to any station is left.
    pub fn gone(&mut self, now: WallNs) {
        self.since.get_or_insert(now);
    }

    /// A station told something in the federation `fed`. That of another one, at the same endpoint, knows nothing of this member.
    pub fn heard(&mut self, now: WallNs, fed: u128) {
        if fed == self.fed {
            self.since = None;
        } else {
            self.gone(now);
        }
    }

    /// Whether it was waited for long enough.
    #[must_use]
    pub fn is_over(&self, now: WallNs) -> bool {
        self.since.is_some_and(|since| now > since + GRACE_NS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: WallNs = 1_000_000_000;

    /// Whether a member has given up at each of 200 seconds in which it hears a station of this federation, if any.
    fn over(grace: &mut Grace, fed: Option<u128>) -> Vec<bool> {
        let second = |s| {
            fed.into_iter().for_each(|fed| grace.heard(s * S, fed));
            grace.is_over(s * S)
        };
        (1..=200).map(second).collect()
    }

    #[test]
    fn a_station_of_another_federation_is_not_waited_for() {
        let last = Some(&true);
        let gone = || {
            let mut grace = Grace::new(7);
            grace.gone(0);
            grace
        };
        assert_eq!(over(&mut gone(), None).iter().position(|o| *o), Some(120), "121 s");
        assert_eq!(over(&mut gone(), Some(8)).iter().position(|o| *o), Some(120), "121 s");
        assert_eq!(
            over(&mut Grace::new(7), Some(8)).last(),
            last,
            "the other one came before it went"
        );
        assert!(!over(&mut gone(), Some(7)).contains(&true), "it is back");
        let mut both = Grace::new(7);
        for s in 1..200 {
            both.heard(s * S, 8);
            both.heard(s * S + S / 10, 7);
            assert!(!both.is_over(s * S), "both are there");
        }
    }
}
