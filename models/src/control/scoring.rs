//! Alerts on tracks held against the alerts of the same rules on exact truth.

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
}

impl KindScore {
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

/// Scores by kind, sorted by word. Each true alert takes the nearest in time of the same kind and subjects that
/// no other has; an alert on tracks is false if no true one of its kind and subjects stands within 10 s of it.
#[must_use]
pub fn score(reference: &[Told], found: &[Told]) -> Vec<KindScore> {
    let mut kinds: Vec<&str> = reference.iter().chain(found).map(|t| t.kind.as_str()).collect();
    kinds.sort_unstable();
    kinds.dedup();
    kinds.into_iter().map(|kind| score_kind(kind, reference, found)).collect()
}

fn score_kind(kind: &str, reference: &[Told], found: &[Told]) -> KindScore {
    let of = |all: &[Told]| -> Vec<Told> {
        let mut own: Vec<Told> = all.iter().filter(|t| t.kind == kind).cloned().collect();
        own.sort_by(|a, b| a.on_s.total_cmp(&b.on_s).then_with(|| a.subjects.cmp(&b.subjects)));
        own
    };
    let (reference, found) = (of(reference), of(found));
    let mut taken = vec![false; found.len()];
    let mut score = KindScore { kind: kind.to_owned(), ..KindScore::default() };
    for told in &reference {
        score.reference += 1;
        let near = |i: &usize| {
            !taken[*i]
                && found[*i].subjects == told.subjects
                && (found[*i].on_s - told.on_s).abs() <= DETECTED_S
        };
        let apart = |i: usize| (found[i].on_s - told.on_s).abs();
        let nearest = (0..found.len()).filter(near).min_by(|a, b| apart(*a).total_cmp(&apart(*b)));
        if let Some(i) = nearest {
            taken[i] = true;
            score.detected += 1;
            score.responses_s.push(found[i].on_s - told.on_s);
        }
    }
    score.responses_s.sort_by(f64::total_cmp);
    let explained = |f: &Told| {
        reference.iter().any(|t| {
            t.subjects == f.subjects
                && f.on_s >= t.on_s - EXPLAINED_S
                && f.on_s <= t.end_s + EXPLAINED_S
        })
    };
    score.false_alerts = found.iter().filter(|f| !explained(f)).count() as u32;
    score
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(kind: &str, subjects: &str, on_s: f64, end_s: f64) -> Told {
        let subjects = subjects.split(' ').map(str::to_owned).collect();
        Told { kind: kind.into(), subjects, on_s, end_s }
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
}
