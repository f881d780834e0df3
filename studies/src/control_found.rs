//! What the choices of a safety net are, and what each made of a scene.

use crate::expected::cause;
use models::control::scoring::{KindScore, Told, Verdict, judge};
use models::traffic::core::Shown;

/// Sensor sets, by the names of their sensors.
pub(crate) const SETS: [(&str, &[&str]); 6] = [
    ("radar", &["ASDE tower"]),
    ("two radars", &["ASDE tower", "ASDE far"]),
    ("MLAT", &["MLAT"]),
    ("radar + ADS-B", &["ASDE tower", "ADS-B"]),
    ("radar + MLAT", &["ASDE tower", "MLAT"]),
    ("radar + MLAT + ADS-B", &["ASDE tower", "MLAT", "ADS-B"]),
];

/// Profiles of the tracker.
pub(crate) const PROFILES: [&str; 3] = ["bulk", "paper", "accurate"];

/// Scans in a row that raise an alert.
pub(crate) const CONFIRMATIONS: [u32; 2] = [1, 2];

/// What one chain with one confirmation made of a scene.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub(crate) set: usize,
    pub(crate) profile: usize,
    pub(crate) confirm: usize,
    pub(crate) score: KindScore,
    pub(crate) us_per_scan: f64,
    /// The alerts that were missed or are none: seconds, verdict, kind, subjects, and the failure that they are about.
    pub(crate) wrong: Vec<[String; 5]>,
}

impl Found {
    /// Nuisance alerts that are about no failure: those that rules and ordinary traffic make.
    pub(crate) fn unprovoked(&self) -> u32 {
        let plain = |w: &&[String; 5]| w[1] == Verdict::Nuisance.word() && w[4].is_empty();
        self.wrong.iter().filter(plain).count() as u32
    }
}

/// The alerts of a safety net that were missed or are false or a nuisance, by time.
pub(crate) fn wrong(reference: &[Told], found: &[Told], shown: &[Shown]) -> Vec<[String; 5]> {
    let judged = judge(reference, found);
    let missed = reference.iter().zip(&judged.responses_s).filter(|(_, r)| r.is_none());
    let missed = missed.map(|(told, _)| (told, "missed"));
    let others = found.iter().zip(&judged.found).filter(|(_, v)| **v != Verdict::Right);
    let mut all: Vec<(&Told, &str)> = missed.chain(others.map(|(t, v)| (t, v.word()))).collect();
    all.sort_by(|a, b| a.0.on_s.total_cmp(&b.0.on_s).then(a.1.cmp(b.1)));
    let line = |(told, word): (&Told, &str)| {
        let failure = cause(shown, told).map_or("", |s| s.kind.word());
        let (at, who) = (format!("{:.2}", told.on_s), told.subjects.join(" "));
        [at, word.into(), told.kind.clone(), who, failure.into()]
    };
    all.into_iter().map(line).collect()
}

/// What came out of a scene.
#[derive(Clone, Debug)]
pub(crate) struct Flown {
    pub(crate) hours: f64,
    pub(crate) movements: u32,
    pub(crate) truth_us: f64,
    pub(crate) found: Vec<Found>,
}

impl Flown {
    /// The sum of two scenes; times are means.
    pub(crate) fn and(mut self, other: &Self) -> Self {
        let (a, b) = (self.hours, other.hours);
        let mean = |x: f64, y: f64| (x * a + y * b) / (a + b);
        self.truth_us = mean(self.truth_us, other.truth_us);
        for (one, more) in self.found.iter_mut().zip(&other.found) {
            one.score.add(&more.score);
            one.wrong.extend(more.wrong.iter().cloned());
            one.us_per_scan = mean(one.us_per_scan, more.us_per_scan);
        }
        self.hours += other.hours;
        self.movements += other.movements;
        self
    }
}
