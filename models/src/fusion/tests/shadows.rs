//! Shadows of the chosen rung.

use super::*;
use crate::filter::{FilterConfig, Rung};

#[test]
fn who_watches_beside_changes_no_bit_and_sees_what_that_choice_gives() {
    for (rung, neighbours) in [
        (Rung::Abg, &[Rung::Ca3][..]),
        (Rung::Ca3, &[Rung::Abg, Rung::Ca3Ud]),
        (Rung::Mh9, &[Rung::Mh3, Rung::Mh27]),
        (Rung::Mh9Lag1, &[Rung::Mh27, Rung::Events9]),
    ] {
        let mut config = TrackingConfig::paper();
        config.filter = FilterConfig::new(rung);
        let mut shadows = Shadows::around(&config);
        let found: Vec<Rung> = shadows.rungs().iter().map(Shadow::rung).collect();
        assert_eq!(found, neighbours);
        let mut alone = Tracker::new(config.clone());
        let mut watched = Tracker::new(config.clone());
        let radar = tower(4, 0.95, 2);
        let paths = traffic();
        let mut tracks = [0, 0];
        for k in 1..=30 {
            let plots: Vec<Plot> = radar.scan(k, &paths).into_iter().map(|l| l.0).collect();
            let t = SimTime::from_s(f64::from(k));
            let expected = alone.scan(t, &plots, &FlightList::default());
            let given = watched.scan(t, &plots, &FlightList::default());
            for (shadow, tracks) in shadows.rungs().iter_mut().zip(&mut tracks) {
                *tracks = shadow.scan(t, &plots, &FlightList::default()).len();
                assert_eq!(shadow.outcomes().len(), plots.len());
            }
            assert_eq!(given, expected, "{rung:?} scan {k}");
        }
        for (shadow, tracks) in shadows.rungs().iter().zip(tracks) {
            // What it gives is what a run with that rung gives.
            let mut own = Tracker::new(TrackingConfig {
                filter: FilterConfig::new(shadow.rung()),
                ..config.clone()
            });
            for k in 1..=30 {
                let plots: Vec<Plot> = radar.scan(k, &paths).into_iter().map(|l| l.0).collect();
                own.scan(SimTime::from_s(f64::from(k)), &plots, &FlightList::default());
            }
            assert_eq!(shadow.outcomes(), own.outcomes(), "{}", shadow.name());
            assert_eq!(shadow.statistics(), own.statistics());
            assert!(tracks >= 7, "{} follows them all: {tracks}", shadow.name());
        }
    }
}
