//! What may be lost on the bus is told again: every message carries all that was told within two minutes, numbered.

use std::collections::VecDeque;

/// Scans for which something is told again, if nothing else is said.
const TOLD_FOR: u64 = 120;
/// Scans between two messages that tell nothing new.
const AGAIN_EVERY: u64 = 5;
/// Kept at most; beyond, the oldest are told no more.
const MOST: usize = 2000;

/// What was told lately.
#[derive(Debug)]
pub struct Repeated<T> {
    kept: VecDeque<(u64, T)>,
    scan: u64,
    told: u64,
    told_for: u64,
}

impl<T> Default for Repeated<T> {
    fn default() -> Self {
        Self::told_for(TOLD_FOR)
    }
}

impl<T> Repeated<T> {
    /// Tells everything again for so many scans.
    #[must_use]
    pub fn told_for(scans: u64) -> Self {
        Self { kept: VecDeque::new(), scan: 0, told: 0, told_for: scans }
    }
}

impl<T: Clone> Repeated<T> {
    /// Number of the next one, from 1.
    #[must_use]
    pub fn next(&self) -> u64 {
        self.told + 1
    }

    /// One more.
    pub fn tell(&mut self, one: T) {
        self.told += 1;
        if self.kept.len() >= MOST {
            self.kept.pop_front();
        }
        self.kept.push_back((self.scan, one));
    }

    /// A scan is over: what is to be told with it, if anything.
    pub fn scan(&mut self) -> Option<Vec<T>> {
        let now = self.scan;
        self.scan += 1;
        while self.kept.front().is_some_and(|(at, _)| at + self.told_for < now) {
            self.kept.pop_front();
        }
        let new = self.kept.back().is_some_and(|(at, _)| *at == now);
        let due = new || now.is_multiple_of(AGAIN_EVERY) && !self.kept.is_empty();
        due.then(|| self.kept.iter().map(|(_, one)| one.clone()).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_hears_one_message_in_a_minute_misses_nothing() {
        let mut repeated = Repeated::default();
        let (mut told, mut heard, mut sent) = (Vec::new(), Vec::new(), 0);
        for scan in 0..1000_u64 {
            if scan % 7 == 3 && scan < 800 {
                told.push(repeated.next());
                repeated.tell(repeated.next());
            }
            let Some(message) = repeated.scan() else { continue };
            sent += 1;
            assert!(message.len() <= 18, "{}", message.len());
            // Everything is lost but one message a minute.
            if scan % 60 < 5 && scan % 5 == 0 {
                let last = heard.last().copied().unwrap_or(0);
                heard.extend(message.into_iter().filter(|n| *n > last));
            }
        }
        assert_eq!(heard, told);
        assert!(sent < 330, "{sent}");
        let mut full = Repeated::default();
        (0..5000).for_each(|n| full.tell(n));
        assert_eq!(full.scan().map(|m| m.len()), Some(MOST));
    }
}
