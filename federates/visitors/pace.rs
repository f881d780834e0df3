//! What time it is in the exercise, by the host's clock: from when frames were executed.
//!
//! The station grants frames at an even pace, and each is executed at its time or a little later. So
//! the pace is the line through the last seconds of frames, laid along their early side.

use std::collections::VecDeque;

/// Frames looked at: those of the last four seconds of the host's clock, and at most so many.
const WINDOW_NS: i64 = 4_000_000_000;
const FRAMES: usize = 2048;

/// A pause in the frames longer than this is a freeze, ns.
const PAUSE_NS: i64 = 1_000_000_000;

/// The exercise's time against the host's.
#[derive(Clone, Debug, Default)]
pub struct Pace {
    /// (exercise time, UTC) of executed frames.
    frames: VecDeque<(i64, i64)>,
    /// Exercise seconds in a second of the host's clock.
    rate: f64,
    /// UTC of the last frame's time on that line.
    last_utc_ns: f64,
}

impl Pace {
    /// A frame of exercise time `time_ns` was executed at `utc_ns`.
    pub fn executed(&mut self, time_ns: i64, utc_ns: i64) {
        let begin_again = self.frames.back().is_some_and(|(time, utc)| {
            time_ns <= *time || utc_ns < *utc || utc_ns - utc > PAUSE_NS
        });
        if begin_again {
            self.frames.clear();
        }
        self.frames.push_back((time_ns, utc_ns));
        while self.frames.len() > FRAMES
            || self.frames.front().is_some_and(|(_, utc)| utc_ns - utc > WINDOW_NS)
        {
            self.frames.pop_front();
        }
        self.fit();
    }

    fn fit(&mut self) {
        let Some(&(time0, utc0)) = self.frames.back() else { return };
        self.last_utc_ns = utc0 as f64;
        let count = self.frames.len() as f64;
        if count < 5.0 {
            // Too few for a pace: that of before, real time at the start.
            if self.rate == 0.0 {
                self.rate = 1.0;
            }
            return;
        }
        let pairs = || self.frames.iter().map(|(t, u)| ((t - time0) as f64, (u - utc0) as f64));
        let (sum_t, sum_u) = pairs().fold((0.0, 0.0), |(a, b), (t, u)| (a + t, b + u));
        let (mean_t, mean_u) = (sum_t / count, sum_u / count);
        let (tt, tu) = pairs().fold((0.0, 0.0), |(tt, tu), (t, u)| {
            (tt + (t - mean_t) * (t - mean_t), tu + (t - mean_t) * (u - mean_u))
        });
        let slope = tu / tt;
        if !(slope.is_finite() && slope > 1e-6) {
            return;
        }
        self.rate = 1.0 / slope;
        let early = pairs().map(|(t, u)| u - slope * t).fold(f64::INFINITY, f64::min);
        self.last_utc_ns = utc0 as f64 + early;
    }

    /// Exercise time at `utc_ns`, and the rate; not far beyond the last frame, since time may stand.
    #[must_use]
    pub fn at(&self, utc_ns: i64) -> Option<(i64, f64)> {
        let &(time, _) = self.frames.back()?;
        let since_ns = (utc_ns as f64 - self.last_utc_ns).clamp(-10e9, 0.25e9);
        Some((time.saturating_add((since_ns * self.rate) as i64), self.rate))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_NS: i64 = 50_000_000;
    const UTC_NS: i64 = 1_700_000_000_000_000_000;

    #[test]
    fn late_frames_do_not_move_the_pace() {
        for rate in [0.5, 1.0, 4.0, 20.0] {
            let mut pace = Pace::default();
            let (mut worst_ns, mut executed_ns) = (0.0_f64, UTC_NS);
            for frame in 1..4000_i64 {
                let nominal = UTC_NS + (frame as f64 * STEP_NS as f64 / rate) as i64;
                // Every third frame up to 8 ms late.
                let late = if frame % 3 == 0 { (frame * 7919) % 1009 * 7_900 } else { 100_000 };
                // The next frame is executed after it, however late it was.
                executed_ns = executed_ns.max(nominal + late);
                pace.executed(frame * STEP_NS, executed_ns);
                // Five seconds of the host's clock.
                if frame as f64 > 5.0 * rate / 0.05 {
                    let (time, found) = pace.at(nominal).expect("frames were executed");
                    assert!((found / rate - 1.0).abs() < 5e-3, "rate {rate}: {found}");
                    worst_ns = worst_ns.max((time - frame * STEP_NS).abs() as f64 / rate);
                }
            }
            // Of the host's clock; 0.35 m at 70 m/s.
            assert!(worst_ns < 5e6, "rate {rate}: {worst_ns} ns");
        }
    }

    #[test]
    fn a_freeze_and_a_restart_begin_again() {
        let mut pace = Pace::default();
        for frame in 0..100 {
            pace.executed(frame * STEP_NS, UTC_NS + frame * STEP_NS);
        }
        let frozen = pace.at(UTC_NS + 60_000_000_000).expect("there").0;
        assert!(frozen <= 100 * STEP_NS + 250_000_000, "time stands");
        pace.executed(100 * STEP_NS, UTC_NS + 60_000_000_000);
        assert_eq!(pace.at(UTC_NS + 60_000_000_000), Some((100 * STEP_NS, pace.rate)));
        pace.executed(0, UTC_NS + 61_000_000_000);
        assert_eq!(pace.at(UTC_NS + 61_000_000_000).map(|(t, _)| t), Some(0));
    }
}
