//! What a browser is shown scans from: the run that goes on ([`super::history::History`]) or a finished one out of its
//! database ([`super::archive::Archive`]). A [`super::Session`] cannot tell which.

use crate::runtime::messages::ScanReport;
use models::time::SimTime;
use models::track::TrackStatus;
use serde::Serialize;
use std::collections::BTreeMap;

/// One point of an error curve.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CurvePoint {
    /// Scan number.
    pub scan: u64,
    /// Time, s.
    pub time_s: f64,
    /// Error of the track, m; none while it has no truth.
    pub error_m: Option<f32>,
    /// What the track claims: root of the trace of its position covariance, m.
    pub claimed_m: f32,
    /// Error of the plots of the same entity in this scan, m, largest by kind of sensor.
    pub plots_m: BTreeMap<String, f32>,
}

/// Scans in ascending order, with what belongs to them.
pub trait Source: Send + std::fmt::Debug {
    /// Numbers of the oldest and the newest scan.
    fn range(&self) -> Option<(u64, u64)>;

    /// Times of the oldest and the newest scan.
    fn times(&self) -> Option<(SimTime, SimTime)>;

    /// Number of the scan nearest to `scan` from below, or the oldest.
    fn nearest(&self, scan: u64) -> Option<u64>;

    /// Number of the newest scan that is not later than `time`; none before the first one and more than a scan and
    /// a half after the last or into a gap: a picture of another time is not this one's.
    fn at(&self, time: SimTime) -> Option<u64>;

    /// Time of a scan that is there.
    fn time_of(&self, scan: u64) -> Option<SimTime>;

    /// The message of the scan nearest to `scan` (see [`super::frame`]), with the trails that led there.
    fn message(&self, scan: u64) -> Option<Vec<u8>>;

    /// The curve of the track `number` from scan `from` to scan `upto`.
    fn curve(&self, number: u16, from: u64, upto: u64) -> Vec<CurvePoint>;

    /// What every simulated effect did to the plots of the track `number`, or of the target that it follows, in the
    /// scan nearest to `scan`: JSON objects.
    fn effects(&self, number: u16, scan: u64) -> Vec<String>;

    /// The sums of every scan, in their order.
    fn sums(&self) -> &[ScanSums];

    /// What happened, in the order of time.
    fn events(&self) -> &[Event];

    /// Scans that are no longer there.
    fn dropped(&self) -> u64 {
        0
    }
}

/// What the time line needs of a scan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScanSums {
    /// Number of the scan.
    pub scan: u64,
    /// Its time.
    pub time: SimTime,
    /// Largest error of a track that follows an entity, m; none without such a track.
    pub worst_error_m: Option<f32>,
    /// Mean of these errors, m.
    pub mean_error_m: Option<f32>,
    /// Entities that no track follows.
    pub untracked: u32,
    /// Confirmed tracks that follow nothing.
    pub false_tracks: u32,
    /// Tracks with the call sign of another entity.
    pub wrong_labels: u32,
}

impl ScanSums {
    /// Of one scan.
    #[must_use]
    pub fn of(scan: &ScanReport) -> Self {
        let errors = scan.truth.iter().filter_map(|t| t.track.map(|p| p.1));
        let (count, sum, worst) =
            errors.fold((0_u32, 0.0, 0.0_f64), |(n, sum, worst), e| (n + 1, sum + e, worst.max(e)));
        let pairs = super::frame::pairs(scan);
        let mut false_tracks = 0;
        let mut wrong_labels = 0;
        for track in &scan.tracks {
            match pairs.get(&track.number) {
                None => false_tracks += u32::from(track.status == TrackStatus::Confirmed),
                Some((at, _)) => {
                    let other = scan.truth[*at].callsign != track.callsign;
                    wrong_labels += u32::from(!track.callsign.is_empty() && other);
                }
            }
        }
        Self {
            scan: scan.scan,
            time: SimTime(scan.time_ns),
            worst_error_m: (count > 0).then_some(worst as f32),
            mean_error_m: (count > 0).then(|| (sum / f64::from(count)) as f32),
            untracked: scan.truth.iter().filter(|t| t.track.is_none()).count() as u32,
            false_tracks,
            wrong_labels,
        }
    }
}

/// Something that the time line marks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Event {
    /// Simulated time, ns.
    pub time_ns: i64,
    /// "alert", "operator", "weather", "lost", "swap", "clearance", "fork" or "fault".
    pub kind: String,
    /// Whom it is about: a call sign, or empty.
    pub subject: String,
    /// One line.
    pub text: String,
}

/// Finds tracks that were lost and tracks or labels that were swapped, scan by scan.
#[derive(Clone, Debug, Default)]
pub struct EventFinder {
    /// What each track followed and was called in the scan before.
    before: std::collections::BTreeMap<u16, (String, String)>,
}

impl EventFinder {
    /// What happened between the scan before and this one.
    pub fn scan(&mut self, scan: &ScanReport) -> Vec<Event> {
        let pairs = super::frame::pairs(scan);
        let now: std::collections::BTreeMap<u16, (String, String)> = scan
            .tracks
            .iter()
            .map(|t| {
                let entity = pairs.get(&t.number).map_or("", |p| scan.truth[p.0].callsign.as_str());
                (t.number, (entity.to_owned(), t.callsign.clone()))
            })
            .collect();
        let mut events = Vec::new();
        let mut tell = |kind: &str, subject: &str, text: String| {
            events.push(Event {
                time_ns: scan.time_ns,
                kind: kind.to_owned(),
                subject: subject.to_owned(),
                text,
            });
        };
        for (number, (entity, label)) in &self.before {
            match now.get(number) {
                None if !entity.is_empty() => {
                    // Lost only while the target is still there and nobody else has taken it over.
                    let there =
                        scan.truth.iter().find(|t| t.callsign == *entity && t.track.is_none());
                    if there.is_some() {
                        tell("lost", entity, format!("track {number} of {entity} lost"));
                    }
                }
                Some((other, _)) if !entity.is_empty() && !other.is_empty() && other != entity => {
                    tell("swap", entity, format!("track {number} went from {entity} to {other}"));
                }
                Some((_, other)) if !label.is_empty() && !other.is_empty() && other != label => {
                    tell("swap", label, format!("label of track {number}: {label} is now {other}"));
                }
                _ => {}
            }
        }
        self.before = now;
        events
    }
}

/// Columns of the time line: of the scans in each the worst, as the browser draws them.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Strip {
    /// Time of the left end, s.
    pub from_s: f64,
    /// Time of the right end, s.
    pub to_s: f64,
    /// Largest error of a track, m; none without one.
    pub worst_m: Vec<Option<f32>>,
    /// Most entities without a track.
    pub untracked: Vec<u32>,
    /// Most confirmed tracks of nothing.
    pub false_tracks: Vec<u32>,
    /// Most wrong labels.
    pub wrong_labels: Vec<u32>,
}

/// Most columns that a browser may ask for.
pub const MOST_COLUMNS: usize = 2000;

impl Strip {
    /// `columns` equal parts of the time from `from_s` to `to_s`.
    #[must_use]
    pub fn of(sums: &[ScanSums], from_s: f64, to_s: f64, columns: usize) -> Self {
        let columns = columns.clamp(1, MOST_COLUMNS);
        let mut strip = Self {
            from_s,
            to_s,
            worst_m: vec![None; columns],
            untracked: vec![0; columns],
            false_tracks: vec![0; columns],
            wrong_labels: vec![0; columns],
        };
        let width = to_s - from_s;
        if !(width > 0.0) {
            return strip;
        }
        let first = sums.partition_point(|s| s.time.s() < from_s);
        for s in sums[first..].iter().take_while(|s| s.time.s() <= to_s) {
            let at = ((s.time.s() - from_s) / width * columns as f64) as usize;
            let at = at.min(columns - 1);
            let worst = &mut strip.worst_m[at];
            *worst = match (*worst, s.worst_error_m) {
                (Some(a), Some(b)) => Some(a.max(b)),
                (a, b) => a.or(b),
            };
            for (column, value) in [
                (&mut strip.untracked[at], s.untracked),
                (&mut strip.false_tracks[at], s.false_tracks),
                (&mut strip.wrong_labels[at], s.wrong_labels),
            ] {
                *column = (*column).max(value);
            }
        }
        strip
    }
}

/// Position in sums sorted by time of the newest one not later than `time`, within a scan and a half.
pub(super) fn at(sums: &[ScanSums], time: SimTime) -> Option<u64> {
    let after = sums.partition_point(|s| s.time <= time);
    let found = sums.get(after.checked_sub(1)?)?;
    let step = sums.get(1).map_or(1.0, |second| second.time.since_s(sums[0].time));
    (time.since_s(found.time) < 1.5 * step).then_some(found.scan)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer_logger::tests::scan;

    #[test]
    fn a_column_shows_the_worst_scan_of_its_time() {
        let sums: Vec<ScanSums> = (1..=100).map(|n| ScanSums::of(&scan(n))).collect();
        assert_eq!(sums[2].worst_error_m, Some(0.3));
        let strip = Strip::of(&sums, 0.0, 100.0, 10);
        assert_eq!(strip.worst_m.len(), 10);
        assert_eq!(strip.worst_m[0], Some(0.9), "scans 1 to 9");
        assert_eq!(strip.worst_m[9], Some(10.0), "the end belongs to the last column");
        assert_eq!(Strip::of(&sums, 5.0, 5.0, 4).worst_m, vec![None; 4], "no time, no column");
        assert_eq!(Strip::of(&sums, 0.0, 1.0, 0).worst_m.len(), 1);
        assert_eq!(Strip::of(&sums, 200.0, 300.0, 1_000_000).worst_m, vec![None; MOST_COLUMNS]);
    }

    #[test]
    fn a_time_without_a_scan_has_no_picture() {
        let sums: Vec<ScanSums> = [1, 2, 3, 7, 8].iter().map(|n| ScanSums::of(&scan(*n))).collect();
        let s = |t: f64| at(&sums, SimTime((t * 1e9) as i64));
        assert_eq!((s(0.5), s(1.0), s(2.9), s(3.0)), (None, Some(1), Some(2), Some(3)));
        assert_eq!((s(5.0), s(8.4), s(10.0)), (None, Some(8), None), "a gap, and the end");
        assert_eq!(at(&[], SimTime(0)), None);
    }

    #[test]
    fn lost_and_swapped_are_told_once_and_ends_are_not() {
        let mut finder = EventFinder::default();
        let mut first = scan(1);
        assert!(finder.scan(&first).is_empty(), "nothing before");
        first.scan = 2;
        assert!(finder.scan(&first).is_empty(), "nothing changed");
        let mut lost = first.clone();
        lost.tracks.clear();
        lost.truth[0].track = None;
        let told = finder.scan(&lost);
        assert_eq!((told.len(), &told[0].kind[..], &told[0].subject[..]), (1, "lost", "SWR1"));
        assert!(finder.scan(&lost).is_empty(), "once");
        finder.scan(&first);
        let mut ended = first.clone();
        ended.tracks.clear();
        ended.truth.clear();
        assert!(finder.scan(&ended).is_empty(), "the target is gone, too");
        finder.scan(&first);
        let mut other = first.clone();
        other.truth[0].callsign = "SWR2".to_owned();
        assert_eq!(finder.scan(&other)[0].kind, "swap");
        other.tracks[0].callsign = "SWR2".to_owned();
        assert!(finder.scan(&other)[0].text.contains("label of track 4: SWR1 is now SWR2"));
    }
}
