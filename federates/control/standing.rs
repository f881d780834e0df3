//! Alerts that stand, for whoever hears of them late: an alert may stand for hours, and what is told again is forgotten after two minutes.

use crate::runtime::messages::AlertMessage;
use models::control::alert::Change;
use std::collections::BTreeMap;

/// Of each alert that has not ended how it was raised, and what was told of it last.
#[derive(Debug, Default)]
pub(super) struct Standing(BTreeMap<u32, Vec<AlertMessage>>);

impl Standing {
    /// Something changed of an alert.
    pub(super) fn take(&mut self, message: &AlertMessage) {
        if message.change == Change::Ended {
            self.0.remove(&message.id);
            return;
        }
        let told = self.0.entry(message.id).or_default();
        told.truncate(1);
        told.push(message.clone());
    }

    /// What is told again, and before it what is not any more and stands, by number.
    pub(super) fn before(&self, again: Vec<AlertMessage>) -> Vec<AlertMessage> {
        let first = again.first().map_or(u64::MAX, |message| message.number);
        let older = self.0.values().flatten().filter(|message| message.number < first);
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

    /// Alert 1 stands for an hour, others come and go: whoever hears any message of the time has all that stand, and nobody a number twice.
    #[test]
    fn whoever_hears_late_has_what_stands() {
        let (mut again, mut standing) = (Repeated::default(), Standing::default());
        let tell = |again: &mut Repeated<AlertMessage>, standing: &mut Standing, id, change| {
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
        };
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
}
