//! Tracks of somebody else's tracker for the page: of each the last report, for as long as it is worth showing.

use crate::runtime::messages::ForeignReport;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// A track of which nothing came for so long is not shown any more, ns of simulated time.
const HOLDS_NS: i64 = 10_000_000_000;

/// Tracks that are kept, at most: anybody may send.
const MOST: usize = 4096;

/// The last report of each track, by its source and number.
#[derive(Clone, Debug, Default)]
pub struct ForeignTracks(BTreeMap<(String, u32), ForeignReport>);

impl ForeignTracks {
    /// Takes reports in; a track that says that it ends is gone.
    pub fn take(&mut self, reports: &[ForeignReport]) {
        for report in reports {
            let key = (report.source.clone(), report.track);
            if report.last {
                self.0.remove(&key);
            } else if self.0.len() < MOST || self.0.contains_key(&key) {
                self.0.insert(key, report.clone());
            }
        }
        let newest_ns = reports.iter().map(|report| report.time_ns).max();
        if let Some(newest_ns) = newest_ns {
            // Before: of a run that was begun again.
            let near = |report: &ForeignReport| (newest_ns - report.time_ns).abs() <= HOLDS_NS;
            self.0.retain(|_, report| near(report));
        }
    }

    /// For the page: m, m/s, s of simulated time.
    #[must_use]
    pub fn message(&self) -> Value {
        let track = |report: &ForeignReport| {
            let mut track = json!({
                "source": report.source,
                "track": report.track,
                "time_s": report.time_ns as f64 * 1e-9,
                "x_m": report.position_m[0],
                "y_m": report.position_m[1],
                "callsign": report.callsign,
                "coasting": report.coasting,
            });
            if let Some([vx, vy]) = report.velocity_mps {
                (track["vx_ms"], track["vy_ms"]) = (vx.into(), vy.into());
            }
            track
        };
        json!({ "type": "foreign", "tracks": self.0.values().map(track).collect::<Vec<_>>() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::frames::Point2;

    fn report(track: u32, time_s: i64) -> ForeignReport {
        ForeignReport {
            source: "77/9".into(),
            track,
            time_ns: time_s * 1_000_000_000,
            position_m: Point2::new(1.0, 2.0),
            velocity_mps: None,
            callsign: String::new(),
            coasting: false,
            last: false,
            received_ns: 0,
        }
    }

    fn shown(tracks: &ForeignTracks) -> Vec<(u64, f64)> {
        let message = tracks.message();
        let of =
            |t: &Value| (t["track"].as_u64().expect("a number"), t["time_s"].as_f64().expect("s"));
        message["tracks"].as_array().expect("a list").iter().map(of).collect()
    }

    #[test]
    fn a_track_is_shown_until_it_ends_or_is_silent() {
        let mut tracks = ForeignTracks::default();
        tracks.take(&[report(1, 10), report(2, 10)]);
        tracks.take(&[ForeignReport { velocity_mps: Some([3.0, 4.0]), ..report(1, 11) }]);
        assert_eq!(shown(&tracks), [(1, 11.0), (2, 10.0)]);
        let message = tracks.message();
        assert_eq!(
            (&message["tracks"][0]["vy_ms"], &message["tracks"][0]["x_m"]),
            (&4.0.into(), &1.0.into())
        );
        assert!(message["tracks"][1].get("vx_ms").is_none());
        tracks.take(&[ForeignReport { last: true, ..report(1, 12) }]);
        assert_eq!(shown(&tracks), [(2, 10.0)]);
        tracks.take(&[report(3, 21)]);
        assert_eq!(shown(&tracks), [(3, 21.0)], "silent for more than ten seconds");
        tracks.take(&[report(4, 2)]);
        assert_eq!(shown(&tracks), [(4, 2.0)], "another run");
    }

    #[test]
    fn a_flood_of_numbers_fills_no_memory() {
        let mut tracks = ForeignTracks::default();
        let all: Vec<ForeignReport> = (0..10_000).map(|n| report(n, 5)).collect();
        tracks.take(&all);
        assert_eq!(tracks.0.len(), MOST);
    }
}
