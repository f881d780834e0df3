//! Alerts on tracks, or of somebody else's safety net, held against the alerts of the rules on exact truth.

use crate::frames::Point2;
use std::collections::BTreeMap;

/// An alert as it was told: by call signs, so that track numbers do not matter.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// Word of its kind.
    pub kind: String,
    /// Subjects, sorted.
    pub subjects: Vec<String>,
    /// Raised at, s.
    pub on_s: f64,
    /// Ended at, s; infinite while it stands.
    pub end_s: f64,
    /// How near the two came to each other while it stood, or one to whoever was nearest to it, m; `None`: not known.
    pub nearest_m: Option<f64>,
}

impl Told {
    /// Looks how near its subjects are at a time at which it stands: `places` by name, m.
    pub fn look(&mut self, time_s: f64, places: &[(&str, Point2<f64>)]) {
        if time_s < self.on_s || time_s > self.end_s {
            return;
        }
        let own = |name: &str| self.subjects.iter().any(|s| s == name);
        let mut nearest_m = self.nearest_m.unwrap_or(f64::INFINITY);
        for (name, at) in places.iter().filter(|(name, _)| own(name)) {
            let others = places
                .iter()
                .filter(|(other, _)| other != name && (self.subjects.len() < 2 || own(other)));
            nearest_m = others.map(|(_, p)| (p - at).norm()).fold(nearest_m, f64::min);
        }
        self.nearest_m = Some(nearest_m).filter(|m| m.is_finite());
    }

    /// Whether it says that a clearance or a limit was broken: then it is about something, however far others are.
    fn tells_breach(&self) -> bool {
        let words = ["STOPBAR", "ROUTE_DEV", "NOMOV", "HIGH_SPEED", "AREA", "WRTY", "RWY_CLOSED"];
        // The same as message types of ASTERIX category 004.
        let types = ["16", "2", "40", "29", "32", "42", "10", "39", "15"];
        let kind = self.kind.as_str();
        kind.starts_with("NOCLR") || words.contains(&kind) || types.contains(&kind)
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.on_s <= other.end_s + EXPLAINED_S && other.on_s <= self.end_s + EXPLAINED_S
    }
}

/// Nearer than this a situation came to something, m.
pub const CAME_TO_M: f64 = 200.0;

/// Whether a true alert came to nothing: its pair stayed farther than 200 m from each other, and none of its subjects broke
/// a clearance meanwhile.
fn came_to_nothing(told: &Told, reference: &[Told]) -> bool {
    let far = told.nearest_m.is_some_and(|m| m > CAME_TO_M);
    let breaks = |other: &Told| {
        other.tells_breach()
            && other.overlaps(told)
            && other.subjects.iter().any(|s| told.subjects.contains(s))
    };
    far && !told.tells_breach() && !reference.iter().any(breaks)
}

/// How far apart the same alert may be raised on truth and on tracks, s.
pub const DETECTED_S: f64 = 3.0;
/// A true alert explains one on tracks from so long before it is raised until so long after it ended, s.
pub const EXPLAINED_S: f64 = 10.0;

/// How good the alerts of one kind are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KindScore {
    /// Word of the kind.
    pub kind: String,
    /// True alerts.
    pub reference: u32,
    /// Of these raised on tracks within 3 s.
    pub detected: u32,
    /// Raised on tracks minus raised on truth, s, of the detected ones, sorted.
    pub responses_s: Vec<f64>,
    /// Raised on tracks without a true one.
    pub false_alerts: u32,
    /// Raised on tracks for a true one that came to nothing.
    pub nuisance_alerts: u32,
}

impl KindScore {
    /// Adds the score of another run, or another kind.
    pub fn add(&mut self, other: &Self) {
        self.reference += other.reference;
        self.detected += other.detected;
        self.false_alerts += other.false_alerts;
        self.nuisance_alerts += other.nuisance_alerts;
        self.responses_s.extend(&other.responses_s);
        self.responses_s.sort_by(f64::total_cmp);
    }

    /// True alerts that were not raised in time.
    #[must_use]
    pub fn missed(&self) -> u32 {
        self.reference - self.detected
    }

    /// The response that a share `p` of the detected stay within (nearest rank), s.
    #[must_use]
    pub fn response_s(&self, p: f64) -> Option<f64> {
        let count = self.responses_s.len();
        let place = (p * count as f64).ceil().max(1.0) as usize;
        self.responses_s.get(place.min(count).checked_sub(1)?).copied()
    }
}

/// What an alert on tracks was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// A true one stands within 10 s of it.
    Right,
    /// The same, but all of these came to nothing.
    Nuisance,
    /// There is no true one.
    False,
}

impl Verdict {
    /// Its word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Nuisance => "nuisance",
            Self::False => "false",
        }
    }
}

/// Every alert judged, in the order in which they were given.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// Of each true alert, raised on tracks minus raised on truth, s; `None`: missed.
    pub responses_s: Vec<Option<f64>>,
    /// Of each alert on tracks.
    pub found: Vec<Verdict>,
}

/// Judges alerts on tracks against true ones. Each true alert takes the nearest in time of the same kind and subjects
/// that no other has; an alert on tracks is false if no true one of its kind and subjects stands within 10 s of it, and a
/// nuisance if all of these came to nothing.
#[must_use]
pub fn judge(reference: &[Told], found: &[Told]) -> Judged {
    let in_order = |all: &[Told]| -> Vec<usize> {
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.sort_by(|a, b| {
            let (a, b) = (&all[*a], &all[*b]);
            a.on_s.total_cmp(&b.on_s).then_with(|| a.subjects.cmp(&b.subjects))
        });
        order
    };
    let same = |a: &Told, b: &Told| a.kind == b.kind && a.subjects == b.subjects;
    let found_order = in_order(found);
    let mut taken = vec![false; found.len()];
    let mut responses_s = vec![None; reference.len()];
    for r in in_order(reference) {
        let told = &reference[r];
        let apart = |f: usize| (found[f].on_s - told.on_s).abs();
        let near = |f: &usize| !taken[*f] && same(&found[*f], told) && apart(*f) <= DETECTED_S;
        let free = found_order.iter().copied().filter(near);
        if let Some(f) = free.min_by(|a, b| apart(*a).total_cmp(&apart(*b))) {
            taken[f] = true;
            responses_s[r] = Some(found[f].on_s - told.on_s);
        }
    }
    let verdict = |f: &Told| {
        let explains = |t: &&Told| {
            same(t, f) && f.on_s >= t.on_s - EXPLAINED_S && f.on_s <= t.end_s + EXPLAINED_S
        };
        let mut nothing = reference.iter().filter(explains).map(|t| came_to_nothing(t, reference));
        match nothing.next() {
            None => Verdict::False,
            Some(first) if first && nothing.all(|n| n) => Verdict::Nuisance,
            Some(_) => Verdict::Right,
        }
    };
    Judged { responses_s, found: found.iter().map(verdict).collect() }
}

/// Scores by kind, sorted by word.
#[must_use]
pub fn score(reference: &[Told], found: &[Told]) -> Vec<KindScore> {
    let judged = judge(reference, found);
    let mut kinds: BTreeMap<&str, KindScore> = BTreeMap::new();
    for (told, response_s) in reference.iter().zip(&judged.responses_s) {
        let score = kinds.entry(&told.kind).or_default();
        score.reference += 1;
        score.detected += u32::from(response_s.is_some());
        score.responses_s.extend(response_s);
    }
    for (told, verdict) in found.iter().zip(&judged.found) {
        let score = kinds.entry(&told.kind).or_default();
        score.false_alerts += u32::from(*verdict == Verdict::False);
        score.nuisance_alerts += u32::from(*verdict == Verdict::Nuisance);
    }
    let of = |(kind, mut score): (&str, KindScore)| {
        score.responses_s.sort_by(f64::total_cmp);
        KindScore { kind: kind.to_owned(), ..score }
    };
    kinds.into_iter().map(of).collect()
}

/// The sum over all kinds, named "all".
#[must_use]
pub fn in_all(scores: &[KindScore]) -> KindScore {
    let mut all = KindScore { kind: "all".into(), ..KindScore::default() };
    scores.iter().for_each(|score| all.add(score));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(kind: &str, subjects: &str, on_s: f64, end_s: f64) -> Told {
        let subjects = subjects.split(' ').map(str::to_owned).collect();
        Told { kind: kind.into(), subjects, on_s, end_s, nearest_m: None }
    }

    #[test]
    fn late_missed_false_and_repeated_alerts_are_told_apart() {
        let truth = [
            told("A", "X Y", 10.0, 20.0),
            told("A", "X Y", 100.0, 120.0),
            told("A", "Z", 50.0, 55.0),
            told("B", "Z", 50.0, f64::INFINITY),
        ];
        let tracks = [
            told("A", "X Y", 11.0, 15.0),   // a second late
            told("A", "X Y", 18.0, 20.0),   // again, within the same true one
            told("A", "X Y", 104.0, 119.0), // too late to count, but not false
            told("A", "Z", 47.0, 55.0),     // before the truth
            told("A", "Y", 50.0, 51.0),     // of another
            told("B", "Z", 900.0, 901.0),   // while the true one stands: late, not false
        ];
        let scores = score(&truth, &tracks);
        let [a, b] = &scores[..] else { panic!("two kinds: {scores:?}") };
        assert_eq!((a.reference, a.detected, a.missed(), a.false_alerts), (3, 2, 1, 1));
        assert_eq!(a.responses_s, [-3.0, 1.0]);
        assert_eq!((b.reference, b.detected, b.false_alerts), (1, 0, 0));
        assert_eq!(b.response_s(0.5), None);
    }

    #[test]
    fn a_true_alert_that_came_to_nothing_is_a_nuisance_when_it_is_raised() {
        let truth = |nearest_m: Option<f64>, breach: Option<Told>| {
            let mut all = vec![Told { nearest_m, ..told("RMCA_ARR", "X Y", 10.0, 20.0) }];
            all.extend(breach);
            all
        };
        let found = [told("RMCA_ARR", "X Y", 10.0, 20.0)];
        let count = |truth: &[Told], found: &[Told]| -> (u32, u32) {
            let all = score(truth, found);
            (all.iter().map(|s| s.nuisance_alerts).sum(), all.iter().map(|s| s.false_alerts).sum())
        };
        assert_eq!(count(&truth(Some(900.0), None), &found), (1, 0));
        assert_eq!(
            count(&truth(Some(900.0), None), &[]),
            (0, 0),
            "not raised, nobody is disturbed"
        );
        assert_eq!(count(&truth(Some(150.0), None), &found), (0, 0), "they came near");
        assert_eq!(count(&truth(None, None), &found), (0, 0), "nobody looked");
        let breach = |subject: &str, at_s: f64| Some(told("NOCLR_RWY", subject, at_s, at_s + 5.0));
        assert_eq!(count(&truth(Some(900.0), breach("Y", 12.0)), &found), (0, 0), "Y broke one");
        assert_eq!(count(&truth(Some(900.0), breach("Z", 12.0)), &found), (1, 0), "somebody else");
        assert_eq!(count(&truth(Some(900.0), breach("Y", 60.0)), &found), (1, 0), "later");
        // A breach is about itself.
        let mut alone = told("NOCLR_TAXI", "X", 10.0, 20.0);
        alone.nearest_m = Some(5000.0);
        assert_eq!(count(&[alone], &[told("NOCLR_TAXI", "X", 11.0, 20.0)]), (0, 0));
    }

    #[test]
    fn nearness_is_that_of_the_pair_while_the_alert_stands() {
        let at = |x: f64| Point2::new(x, 0.0);
        let mut pair = told("RMCA_ARR", "X Y", 10.0, 20.0);
        let mut one = told("NOMOV", "X", 10.0, 20.0);
        for (time_s, x, z) in
            [(5.0, 1.0, 2.0), (12.0, 400.0, 90.0), (15.0, 300.0, 80.0), (25.0, 3.0, 1.0)]
        {
            let places = [("X", at(0.0)), ("Y", at(x)), ("Z", at(z))];
            pair.look(time_s, &places);
            one.look(time_s, &places);
        }
        assert_eq!((pair.nearest_m, one.nearest_m), (Some(300.0), Some(80.0)));
        // Who is gone says nothing.
        let mut gone = told("RMCA_ARR", "X Y", 10.0, 20.0);
        gone.look(12.0, &[("X", at(0.0)), ("Z", at(1.0))]);
        assert_eq!(gone.nearest_m, None);
    }
}
