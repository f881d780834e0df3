//! The clock of one sender, as far as its stamps and their arrivals tell.
//!
//! A stamp says when a state was true by the sender's clock; only the arrival is known by ours. The
//! difference, the *lag*, is the offset of the two clocks plus the delay on the way. One way alone
//! cannot part the two, so:
//!
//! * A sender that says its clock is synchronised (absolute stamps) is believed if its smallest lag
//!   could be a delay: from −20 ms to 1 s. Then the offset is zero and each lag is a delay.
//! * Else the fastest PDU of the last half minute is taken to have come at once: the smallest lag is
//!   the offset, what others lag behind it is their delay. A delay that all of them have in common
//!   cannot be seen.
//!
//! Our own exercise may run at another rate than the host's clock. A sender then follows one or the
//! other; the slope of its stamps says which.

use super::Arrival;
use crate::DisTime;
use std::collections::VecDeque;

/// Lags that can be the delay of a synchronised sender, ns.
const PLAUSIBLE_NS: std::ops::RangeInclusive<i64> = -20_000_000..=1_000_000_000;

/// No PDU is taken to be older than this, ns.
const LONGEST_DELAY_NS: i64 = 5_000_000_000;

/// The smallest lag is that of the last one to two of these, ns of the host's clock.
const WINDOW_NS: i64 = 30_000_000_000;

/// A clock that was set, or a sender that stood still: so many lags in a row, all beyond the
/// smallest by more than [`STEP_NS`].
const IN_A_ROW: usize = 8;
const STEP_NS: i64 = 500_000_000;

/// Pairs of arrival and stamp kept for the slope, at least this far apart, ns.
const ANCHORS: usize = 16;
const ANCHOR_EVERY_NS: i64 = 250_000_000;

/// Rates nearer to 1 than this are real time: stamps cannot tell which clock a sender follows.
const REAL_TIME: f64 = 0.02;

/// Which of the receiver's clocks a sender goes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Follows {
    /// The wall clock: it simulates in real time.
    Host,
    /// The exercise's own time, at whatever rate that runs.
    Exercise,
}

/// What is known of a sender's clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockReport {
    /// Which clock it goes with.
    pub follows: Follows,
    /// Whether its stamps were absolute and are believed.
    pub synchronised: bool,
    /// Our clock minus the sender's, s: 0 if it is synchronised.
    pub offset_s: f64,
    /// Delay of its PDUs, smoothed over some twenty, s.
    pub delay_s: f64,
    /// PDUs that were stamped.
    pub pdus: u64,
}

/// When a stamped state is true in the receiver's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Validity {
    /// Exercise time, ns.
    pub time_ns: i64,
    /// Seconds of the sender in one second of exercise time.
    pub pace: f64,
}

/// The smallest lag of the last while.
#[derive(Clone, Debug, Default)]
struct Lags {
    last_ns: i64,
    /// Smallest of the window in hand and of the one before.
    least_ns: Option<(i64, i64)>,
    since_utc_ns: i64,
    recent: VecDeque<i64>,
}

impl Lags {
    /// Takes an arrival at `reference_ns` of some clock of ours; gives the lag.
    fn take(&mut self, utc_ns: i64, reference_ns: i64, stamp: DisTime) -> i64 {
        // Stamps wrap at the hour: the lag is the one nearest to the last.
        let sent = stamp.near(reference_ns.saturating_sub(self.last_ns));
        let lag = reference_ns.saturating_sub(sent);
        self.last_ns = lag;
        if self.recent.len() == IN_A_ROW {
            self.recent.pop_front();
        }
        self.recent.push_back(lag);
        let (now, before) = self.least_ns.unwrap_or((lag, lag));
        self.least_ns = Some(if utc_ns.saturating_sub(self.since_utc_ns) >= WINDOW_NS {
            self.since_utc_ns = utc_ns;
            (lag, now)
        } else {
            (now.min(lag), before)
        });
        let stepped = self.recent.len() == IN_A_ROW && {
            let lately = self.recent.iter().copied().min().unwrap_or(lag);
            lately.saturating_sub(self.least()) > STEP_NS
        };
        if stepped {
            let lately = self.recent.iter().copied().min().unwrap_or(lag);
            self.least_ns = Some((lately, lately));
            self.since_utc_ns = utc_ns;
        }
        lag
    }

    fn least(&self) -> i64 {
        self.least_ns.map_or(0, |(now, before)| now.min(before))
    }
}

/// The clock of one sender.
#[derive(Clone, Debug)]
pub struct SenderClock {
    host: Lags,
    exercise: Lags,
    /// (exercise time, UTC, stamp unwrapped), ns.
    anchors: VecDeque<(i64, i64, i64)>,
    report: ClockReport,
}

impl Default for SenderClock {
    fn default() -> Self {
        Self {
            host: Lags::default(),
            exercise: Lags::default(),
            anchors: VecDeque::new(),
            report: ClockReport {
                follows: Follows::Host,
                synchronised: false,
                offset_s: 0.0,
                delay_s: 0.0,
                pdus: 0,
            },
        }
    }
}

impl SenderClock {
    /// What is known so far.
    #[must_use]
    pub fn report(&self) -> ClockReport {
        self.report
    }

    /// Takes the stamp of a PDU that arrived, and says when its content is true.
    pub fn take(&mut self, arrival: &Arrival, stamp: DisTime) -> Validity {
        if self.report.pdus == 0 {
            (self.host.since_utc_ns, self.exercise.since_utc_ns) = (arrival.utc_ns, arrival.utc_ns);
        }
        let host_ns = self.host.take(arrival.utc_ns, arrival.utc_ns, stamp);
        let exercise_ns = self.exercise.take(arrival.utc_ns, arrival.time_ns, stamp);
        let sent_ns = arrival.utc_ns.saturating_sub(host_ns);
        let far = |last: &(i64, i64, i64)| arrival.utc_ns.saturating_sub(last.1) >= ANCHOR_EVERY_NS;
        if self.anchors.back().is_none_or(far) {
            if self.anchors.len() == ANCHORS {
                self.anchors.pop_front();
            }
            self.anchors.push_back((arrival.time_ns, arrival.utc_ns, sent_ns));
        }
        let believed = |lags: &Lags| stamp.is_absolute() && PLAUSIBLE_NS.contains(&lags.least());
        let follows = self.follows(arrival, believed(&self.host), believed(&self.exercise));
        let (lags, lag_ns) = match follows {
            Follows::Host => (&self.host, host_ns),
            Follows::Exercise => (&self.exercise, exercise_ns),
        };
        let synchronised = believed(lags);
        let offset_ns = if synchronised { 0 } else { lags.least() };
        let delay_ns =
            lag_ns.saturating_sub(offset_ns).clamp(*PLAUSIBLE_NS.start(), LONGEST_DELAY_NS);
        // Stamps are whole units of 1.68 µs: a state sent now is not one of the future.
        let delay_ns = if delay_ns.abs() < 2_000 { 0 } else { delay_ns };
        let count = self.report.pdus + 1;
        let share = (1.0 / count as f64).max(0.05);
        let delay_s = delay_ns as f64 * 1e-9;
        self.report = ClockReport {
            follows,
            synchronised,
            offset_s: offset_ns as f64 * 1e-9,
            delay_s: self.report.delay_s + share * (delay_s - self.report.delay_s),
            pdus: count,
        };
        let rate = sound(arrival.rate);
        match follows {
            Follows::Exercise => {
                Validity { time_ns: arrival.time_ns.saturating_sub(delay_ns), pace: 1.0 }
            }
            Follows::Host => Validity {
                time_ns: arrival.time_ns.saturating_sub((delay_ns as f64 * rate) as i64),
                pace: 1.0 / rate,
            },
        }
    }

    fn follows(&self, arrival: &Arrival, host: bool, exercise: bool) -> Follows {
        let rate = sound(arrival.rate);
        if (rate - 1.0).abs() > REAL_TIME
            && let (Some(first), Some(last)) = (self.anchors.front(), self.anchors.back())
            && last.1.saturating_sub(first.1) >= 2 * ANCHOR_EVERY_NS
            && last.0.saturating_sub(first.0) > 0
        {
            let pace =
                (last.2.saturating_sub(first.2)) as f64 / last.0.saturating_sub(first.0) as f64;
            let off = |expected: f64| libm::fabs(libm::log(pace.max(1e-6) / expected));
            return if off(1.0) < off(1.0 / rate) { Follows::Exercise } else { Follows::Host };
        }
        if exercise && !host { Follows::Exercise } else { Follows::Host }
    }
}

/// A rate that can be divided by; what is not one counts as real time.
fn sound(rate: f64) -> f64 {
    if rate.is_finite() && rate > 1e-6 { rate.min(1e6) } else { 1.0 }
}
