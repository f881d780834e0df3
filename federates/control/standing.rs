//! Alerts that stand, for whoever hears of them late: an alert may stand for hours, and what is told again is forgotten after two minutes.

use crate::runtime::messages::AlertMessage;
use models::control::alert::Change;
use std::collections::BTreeMap;

/// Of each alert that has not ended how it was raised, and what was told of it last.
#[derive(Debug, Default)]
pub(super) struct Standing {
    of: BTreeMap<u32, Vec<AlertMessage>>,
    /// Scans since anything was told.
    quiet: u32,
}

/// What stands is told again after so many scans in which nothing else is.
const AGAIN_AFTER: u32 = 30;

impl Standing {
    /// Something changed of an alert.
    pub(super) fn take(&mut self, message: &AlertMessage) {
        if message.change == Change::Ended {
            self.of.remove(&message.id);
            return;
        }
        let told = self.of.entry(message.id).or_default();
        told.truncate(1);
        told.push(message.clone());
    }

    /// A scan is over: what is told with it, where `again` of that, or what stands, is due.
    pub(super) fn told(&mut self, again: Option<Vec<AlertMessage>>) -> Option<Vec<AlertMessage>> {
        self.quiet = if again.is_some() { 0 } else { self.quiet + 1 };
        let due = !self.of.is_empty() && self.quiet.is_multiple_of(AGAIN_AFTER);
        match again {
            None => due.then(|| self.before(Vec::new())),
            Some(again) => Some(self.before(again)),
        }
    }

    /// What is told again, and before it what is not any more and stands, by number.
    fn before(&self, again: Vec<AlertMessage>) -> Vec<AlertMessage> {
        let first = again.first().map_or(u64::MAX, |message| message.number);
        let older = self.of.values().flatten().filter(|message| message.number < first);
        let mut all: Vec<AlertMessage> = older.cloned().collect();
        all.sort_by_key(|message| message.number);
        all.extend(again);
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exchange::repeated::Repeated;
    use models::control::alert::{AlertKind, Stage};
    use models::frames::Point2;

    /// Something is told of an alert.
    fn tell(again: &mut Repeated<AlertMessage>, standing: &mut Standing, id: u32, change: Change) {
        let message = AlertMessage {
            run: 1,
            time_ns: 0,
            change,
            id,
            kind: AlertKind::RunwayOpposite,
            stage: Stage::Alarm,
            subjects: "7".into(),
            since_ns: 0,
            asterix: 11,
            place_m: Point2::new(0.0, 0.0),
            number: again.next(),
        };
        standing.take(&message);
        again.tell(message);
    }

    /// Alert 1 stands for an hour, others come and go: whoever hears any message of the time has all that stand, and nobody a number twice.
    #[test]
    fn whoever_hears_late_has_what_stands() {
        let (mut again, mut standing) = (Repeated::default(), Standing::default());
        tell(&mut again, &mut standing, 1, Change::Raised);
        (0..3).for_each(|_| tell(&mut again, &mut standing, 1, Change::Changed));
        let (mut last, mut open) = (Vec::new(), vec![1]);
        for scan in 0..3600_u32 {
            if scan % 500 == 10 {
                open.push(scan);
                tell(&mut again, &mut standing, scan, Change::Raised);
            }
            if scan % 500 == 410 && scan % 1000 > 500 {
                open.retain(|id| *id != scan - 400);
                tell(&mut again, &mut standing, scan - 400, Change::Ended);
            }
            if let Some(told) = again.scan() {
                last = standing.before(told);
            }
            assert!(last.windows(2).all(|pair| pair[0].number < pair[1].number), "{scan}");
            let ended = |id| last.iter().any(|m| m.id == id && m.change == Change::Ended);
            let raised = last.iter().filter(|m| m.change == Change::Raised && !ended(m.id));
            assert!(raised.map(|m| m.id).eq(open.iter().copied()), "{scan}");
        }
        assert_eq!(open.len(), 6, "{open:?}");
        let first: Vec<(u64, Change)> = last.iter().take(2).map(|m| (m.number, m.change)).collect();
        assert_eq!(
            first,
            [(1, Change::Raised), (4, Change::Changed)],
            "how it was raised, and last"
        );
    }

    /// Nothing else is said for hours: whoever was deaf when it was, or joins after control was made again, hears of what stands.
    #[test]
    fn what_stands_is_told_again_where_nothing_else_is() {
        let (mut again, mut standing) = (Repeated::default(), Standing::default());
        tell(&mut again, &mut standing, 1, Change::Raised);
        let mut quiet = 0;
        for scan in 0..3600_u32 {
            match standing.told(again.scan()) {
                Some(told) => {
                    assert!(told.iter().any(|m| m.change == Change::Raised), "{scan}: {told:?}");
                    quiet = 0;
                }
                None => quiet += 1,
            }
            assert!(quiet < AGAIN_AFTER, "{scan}");
        }
        tell(&mut again, &mut standing, 1, Change::Ended);
        let told = (0..3600).filter(|_| standing.told(again.scan()).is_some()).count();
        assert!(told < 130, "of what is over nothing is told for ever: {told}");
    }
}
