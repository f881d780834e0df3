//! What if, from here: a fork that a page asks for, what makes it, and the difference to its parent in numbers.

use super::source::ScanSums;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A fork that a page asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct Wanted {
    /// Number by which the page knows it again.
    pub id: u32,
    /// Name of the parent in the list of runs.
    pub run: String,
    /// Simulated time from which on the changes hold, s.
    pub at_s: f64,
    /// Keys and values, as `seeds fork --set` takes them.
    pub changes: Vec<(String, String)>,
}

/// Makes a fork of a database; the answer is its folder, or one sentence. Ends early, with an error, once the flag is set.
pub type Make = Box<dyn Fn(&Path, &Wanted, &AtomicBool) -> Result<PathBuf, String> + Send + Sync>;

/// Makes forks, one at a time.
pub struct Forks {
    pub(super) make: Make,
    pub(super) busy: AtomicBool,
    pub(super) cancelled: AtomicBool,
}

impl Forks {
    /// With what makes them.
    #[must_use]
    pub fn new(make: Make) -> Arc<Self> {
        Arc::new(Self { make, busy: AtomicBool::new(false), cancelled: AtomicBool::new(false) })
    }

    /// Ends the one that is being made.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }
}

/// A fork held against its parent, scan by scan, from the time of its changes on: each figure of the parent, then of the fork.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Difference {
    /// Scans that both have.
    pub scans: u32,
    /// Of them, those in which both follow somebody.
    pub compared: u32,
    /// Mean over scans of the mean error of the tracks, m.
    pub error_m: [f64; 2],
    /// Mean of the differences (fork less parent), m.
    pub delta_m: f64,
    /// Half of its 95 % interval, m, from means of 30 s; none where there are fewer than five of them.
    pub within_m: Option<f64>,
    /// Mean number of entities that no track follows.
    pub untracked: [f64; 2],
    /// Mean number of confirmed tracks of nothing.
    pub false_tracks: [f64; 2],
    /// Mean number of wrong labels.
    pub wrong_labels: [f64; 2],
    /// Time of the first scan whose sums differ, s.
    pub first_s: Option<f64>,
}

/// Scans of this many seconds are one sample: errors of neighbouring scans are alike.
const BLOCK_S: f64 = 30.0;
const LEAST_BLOCKS: usize = 5;

impl Difference {
    pub(super) fn of(parent: &[ScanSums], fork: &[ScanSums], at_s: f64) -> Self {
        let mut out = Self::default();
        let mut blocks: Vec<(i64, f64, f64)> = Vec::new();
        for own in fork {
            let Ok(at) = parent.binary_search_by_key(&own.time, |s| s.time) else { continue };
            let old = &parent[at];
            let same = |s: &ScanSums| {
                (s.worst_error_m, s.mean_error_m, s.untracked, s.false_tracks, s.wrong_labels)
            };
            if out.first_s.is_none() && same(old) != same(own) {
                out.first_s = Some(own.time.s());
            }
            if own.time.s() < at_s {
                continue;
            }
            out.scans += 1;
            for (sum, pair) in [
                (&mut out.untracked, [old.untracked, own.untracked]),
                (&mut out.false_tracks, [old.false_tracks, own.false_tracks]),
                (&mut out.wrong_labels, [old.wrong_labels, own.wrong_labels]),
            ] {
                sum.iter_mut().zip(pair).for_each(|(sum, n)| *sum += f64::from(n));
            }
            let (Some(a), Some(b)) = (old.mean_error_m, own.mean_error_m) else { continue };
            let (a, b) = (f64::from(a), f64::from(b));
            out.compared += 1;
            out.error_m = [out.error_m[0] + a, out.error_m[1] + b];
            let block = (own.time.s() / BLOCK_S).floor() as i64;
            match blocks.last_mut().filter(|last| last.0 == block) {
                Some(last) => *last = (block, last.1 + b - a, last.2 + 1.0),
                None => blocks.push((block, b - a, 1.0)),
            }
        }
        let share = |sum: f64, n: u32| if n > 0 { sum / f64::from(n) } else { 0.0 };
        out.untracked = out.untracked.map(|n| share(n, out.scans));
        out.false_tracks = out.false_tracks.map(|n| share(n, out.scans));
        out.wrong_labels = out.wrong_labels.map(|n| share(n, out.scans));
        out.error_m = out.error_m.map(|m| share(m, out.compared));
        out.delta_m = out.error_m[1] - out.error_m[0];
        if blocks.len() >= LEAST_BLOCKS {
            let means: Vec<f64> = blocks.iter().map(|b| b.1 / b.2).collect();
            let n = means.len() as f64;
            let mean = means.iter().sum::<f64>() / n;
            let variance = means.iter().map(|m| (m - mean) * (m - mean)).sum::<f64>() / (n - 1.0);
            out.within_m = Some(student(n - 1.0) * (variance / n).sqrt());
        }
        out
    }

    /// The same for people.
    pub(super) fn words(&self) -> String {
        let [a, b] = self.error_m;
        if self.compared == 0 {
            return "no scan in which both follow somebody: nothing to compare".to_owned();
        }
        let Some(first_s) = self.first_s else {
            return format!("no difference in {} scans", self.scans);
        };
        let sure = match self.within_m {
            Some(within) => format!("{:+.2} ± {within:.2} m (95 %)", self.delta_m),
            None => format!("{:+.2} m, too few scans for an interval", self.delta_m),
        };
        let counts = [
            ("untracked", self.untracked),
            ("false tracks", self.false_tracks),
            ("wrong labels", self.wrong_labels),
        ];
        let counts: Vec<String> =
            counts.iter().map(|(word, [a, b])| format!("{word} {a:.2} → {b:.2}")).collect();
        format!(
            "mean error {a:.2} → {b:.2} m, {sure}, over {} scans; {} a scan; first difference at {first_s:.0} s",
            self.compared,
            counts.join(", ")
        )
    }
}

/// The 97.5 % quantile of Student's t (Cornish and Fisher's expansion: within 2 % from four degrees of freedom on).
fn student(freedom: f64) -> f64 {
    let z: f64 = 1.959_964;
    let (z3, z5) = (z.powi(3), z.powi(5));
    z + (z3 + z) / (4.0 * freedom) + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * freedom * freedom)
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::time::SimTime;

    fn sums(error_m: impl Fn(u64) -> Option<f32>) -> Vec<ScanSums> {
        let scan = |n: u64| ScanSums {
            scan: n,
            time: SimTime::from_s(n as f64),
            mean_error_m: error_m(n),
            worst_error_m: error_m(n),
            untracked: u32::from(error_m(n).is_none()),
            ..ScanSums::default()
        };
        (1..=600).map(scan).collect()
    }

    #[test]
    fn a_fork_is_held_against_its_parent_from_its_changes_on() {
        let wave = |n: u64| (n as f32 * 0.7).sin();
        let parent = sums(|n| Some(3.0 + wave(n)));
        // Before 200 s the same, then half a metre worse, with some noise of its own.
        let worse = sums(|n| {
            Some(3.0 + wave(n) + if n < 200 { 0.0 } else { 0.5 + 0.2 * (n as f32 * 0.13).cos() })
        });
        let found = Difference::of(&parent, &worse, 200.0);
        assert_eq!((found.scans, found.compared, found.first_s), (401, 401, Some(200.0)));
        let within = found.within_m.expect("enough");
        assert!((found.delta_m - 0.5).abs() < within.max(0.05), "{found:?}");
        assert!(within > 0.0 && within < 0.2, "{found:?}");
        assert!(found.words().contains("→") && found.words().contains("at 200 s"), "{found:?}");
        // The same run: no difference, and said so. Too short: no interval.
        let same = Difference::of(&parent, &parent, 0.0);
        assert_eq!((same.delta_m, same.first_s, same.within_m), (0.0, None, Some(0.0)));
        assert_eq!(same.words(), "no difference in 600 scans");
        let short = Difference::of(&parent, &worse[..260], 200.0);
        assert_eq!(short.within_m, None);
        assert!(short.words().contains("too few"), "{}", short.words());
        // A target lost half the time counts, and nothing is made of scans without tracks.
        let lost = sums(|n| (n % 2 == 0).then_some(3.0 + wave(n)));
        let found = Difference::of(&parent, &lost, 0.0);
        assert_eq!((found.compared, found.untracked), (300, [0.0, 0.5]));
        let none = Difference::of(&parent, &sums(|_| None), 0.0);
        assert!(none.words().contains("nothing to compare") && none.error_m == [0.0; 2]);
        for (freedom, exact) in [(4.0, 2.776), (9.0, 2.262), (29.0, 2.045)] {
            assert!((student(freedom) / exact - 1.0).abs() < 0.02, "{freedom}");
        }
    }
}
