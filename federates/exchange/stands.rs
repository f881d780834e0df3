//! The stands that flights have now: control, or a stand that was not free, gives an arrival another one than planned, while labels and the
//! flight list have the planned one still. `obs/traffic` says them.

use crate::runtime::messages::{FlightNotice, ScanReport};
use models::frames::Point2;
use serde::Deserialize;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Flights that are remembered, and texts that wait for their scan, at most.
const MOST: (usize, usize) = (100_000, 1_024);

#[derive(Deserialize)]
struct Traffic {
    time_s: f64,
    #[serde(default)]
    movers: Vec<Mover>,
}

#[derive(Deserialize)]
struct Mover {
    callsign: String,
    #[serde(default)]
    stand: String,
}

/// Stand by call sign, as said last. Who is gone keeps his.
#[derive(Clone, Debug, Default)]
pub struct Stands {
    now: BTreeMap<String, String>,
    /// What was said, and as of when, ns, that no scan has come to yet.
    told: Vec<(i64, Vec<Pair>)>,
}

/// Call sign and stand.
type Pair = (String, String);

impl Stands {
    /// Of one text: `obs/traffic` as it was at a time. What is no such text says nothing.
    #[must_use]
    pub fn of(text: &str) -> Self {
        let mut stands = Self::default();
        stands.hear(text);
        stands.come_to(i64::MAX);
        stands
    }

    /// Takes in what is said of traffic that behaves; it counts from the next scan after its time on ([`Self::come_to`]).
    pub fn hear(&mut self, text: &str) {
        let Ok(Traffic { time_s, movers }) = serde_json::from_str(text) else { return };
        if !time_s.is_finite() || self.told.len() >= MOST.1 {
            return;
        }
        let has = movers.into_iter().filter(|m| !m.stand.is_empty());
        let pairs = has.map(|m| (m.callsign, m.stand)).collect();
        self.told.push(((time_s * 1e9).round() as i64, pairs));
    }

    /// What was said as of times before this one, ns, counts from now on: whichever of a scan and what is said of it comes first.
    pub fn come_to(&mut self, now_ns: i64) {
        let due: Vec<_> = self.told.extract_if(.., |told| told.0 < now_ns).collect();
        due.into_iter().flat_map(|told| told.1).for_each(|(name, stand)| self.put(name, stand));
    }

    /// The stand that a flight has from now on.
    pub fn put(&mut self, callsign: String, stand: String) {
        if self.now.len() < MOST.0 || self.now.contains_key(&callsign) {
            self.now.insert(callsign, stand);
        }
    }

    /// The stand of a flight where it is not the planned one.
    fn other(&self, callsign: &str, planned: &str) -> Option<&str> {
        let plain = |name: &str| name.replace('_', " ");
        let stand = self.now.get(callsign)?;
        (plain(stand) != plain(planned)).then_some(stand)
    }

    /// Puts them into a flight list; `at_m` knows where a stand is. Whether anything changed.
    pub fn correct(
        &self,
        flights: &mut [FlightNotice],
        at_m: impl Fn(&str) -> Option<Point2<f64>>,
    ) -> bool {
        let mut changed = false;
        for flight in flights {
            let Some(stand) = self.other(&flight.callsign, &flight.stand) else { continue };
            flight.stand = stand.to_owned();
            flight.stand_m = at_m(stand);
            changed = true;
        }
        changed
    }

    /// A scan whose labels have them: runway, `/`, stand.
    #[must_use]
    pub fn labelled<'a>(&self, scan: &'a ScanReport) -> Cow<'a, ScanReport> {
        let mut scan = Cow::Borrowed(scan);
        for at in 0..scan.tracks.len() {
            let track = &scan.tracks[at];
            let Some((runway, planned)) = track.runway_stand.rsplit_once('/') else { continue };
            let Some(stand) = self.other(&track.callsign, planned) else { continue };
            let label = format!("{runway}/{stand}");
            scan.to_mut().tracks[at].runway_stand = label;
        }
        scan
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runtime::messages::TrackMessage;
    use models::track::{TrackStatus, TrackType};
    use serde_json::json;

    fn said(time_s: f64, stands: &[(&str, &str)]) -> String {
        let mover =
            |(callsign, stand): &(&str, &str)| json!({"callsign": callsign, "stand": stand});
        let movers: Vec<_> = stands.iter().map(mover).collect();
        json!({"time_s": time_s, "movers": movers}).to_string()
    }

    fn scan(labels: &[(&str, &str)]) -> ScanReport {
        let track = |(callsign, label): &(&str, &str)| TrackMessage {
            callsign: (*callsign).into(),
            runway_stand: (*label).into(),
            ..nobody()
        };
        ScanReport { tracks: labels.iter().map(track).collect(), ..ScanReport::default() }
    }

    fn nobody() -> TrackMessage {
        TrackMessage {
            number: 1,
            track_type: TrackType::Aircraft,
            status: TrackStatus::Confirmed,
            first: false,
            time_ns: 0,
            position_m: Point2::origin(),
            velocity_mps: [0.0; 2],
            cov_m2: [1.0, 0.0, 1.0],
            acceleration_ms2: [0.0; 2],
            velocity_cov_m2s2: [1.0, 0.0, 1.0],
            altitude_m: None,
            altitude_ns: None,
            heading_rad: 0.0,
            manoeuvre: false,
            callsign: String::new(),
            type_designator: String::new(),
            wake: None,
            movement: None,
            runway_stand: String::new(),
            ctd_eta_ns: None,
            routing: Vec::new(),
            assumed: String::new(),
            label_p: None,
            address: None,
            existence_p: None,
            unresolved: false,
            lag: None,
        }
    }

    fn labels(scan: &ScanReport) -> Vec<&str> {
        scan.tracks.iter().map(|t| &t.runway_stand[..]).collect()
    }

    #[test]
    fn a_label_has_the_stand_that_was_given_and_keeps_its_own_spelling() {
        let stands = Stands::of(&said(3.0, &[("SWR1", "B 7"), ("SWR2", "A 14"), ("CAR1", "")]));
        let given = scan(&[("SWR1", "28/E_19"), ("SWR2", "14/A_14"), ("SWR3", "28/C_1")]);
        let labelled = stands.labelled(&given);
        assert_eq!(labels(&labelled), ["28/B 7", "14/A_14", "28/C_1"]);
        // Nobody is called "" or has a stand without one in his label; nothing is copied then.
        let others = scan(&[("", "28/E_19"), ("SWR1", "28"), ("CAR1", "")]);
        assert!(matches!(stands.labelled(&others), Cow::Borrowed(_)));
    }

    #[test]
    fn what_is_said_counts_from_the_next_scan_on_and_who_is_gone_keeps_his() {
        let mut stands = Stands::default();
        let given = scan(&[("SWR1", "28/E_19")]);
        stands.hear(&said(5.0, &[("SWR1", "B 7")]));
        for (at_s, label) in [(4, "28/E_19"), (5, "28/E_19"), (6, "28/B 7")] {
            stands.come_to(at_s * 1_000_000_000);
            assert_eq!(labels(&stands.labelled(&given)), [label], "{at_s} s");
        }
        stands.hear(&said(7.0, &[]));
        for text in ["", "{}", "[1]", r#"{"time_s": null, "movers": []}"#] {
            stands.hear(text);
        }
        stands.come_to(i64::MAX);
        assert_eq!(labels(&stands.labelled(&given)), ["28/B 7"]);
        assert!(stands.told.is_empty());
    }
}
