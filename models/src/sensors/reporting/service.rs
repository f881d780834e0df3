//! Whether a position is obtained: services that fail and are restored.
//!
//! The prior probability model of satellite positioning multiplies coverage, availability given
//! coverage, and reliability given both. Coins thrown once a second would give outages of one
//! second, which no receiver shows; here each probability is the long-run share of an alternating
//! process with exponential times up and down, and its trajectory is drawn in continuous time: it
//! does not depend on how often it is looked at.
//!
//! Source: Barlow & Proschan, *Mathematical Theory of Reliability* (1965), ch. 3 (renewal), and
//! Cox, *Renewal Theory* (1962), for the alternating process; closed forms derived from them.

use rand::rngs::ChaCha8Rng;

use crate::draw::{DrawKey, Purpose, exponential, uniform};
use crate::sensors::declared::Given;
use crate::time::SimTime;

/// A two-state process with exponential times up and down.
///
/// Kept as two mean times, so that a tiny share of outage loses no digits; the unit is s wherever the
/// process is simulated, and any one unit in the closed forms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alternating {
    /// Mean time up (between the end of an outage and the next), infinite if it never fails.
    pub mean_up_s: f64,
    /// Mean length of an outage, above 0.
    pub mean_down_s: f64,
}

impl Alternating {
    /// A service that never fails.
    pub const NEVER_FAILS: Self = Self { mean_up_s: f64::INFINITY, mean_down_s: 1.0 };

    /// From the long-run share of time up, P = U/(U + V), and the mean outage V.
    #[must_use]
    pub fn from_share(up_share: f64, mean_down_s: f64) -> Self {
        Self { mean_up_s: mean_down_s * up_share / (1.0 - up_share), mean_down_s }
    }

    /// From mean time between failures and mean time to repair.
    #[must_use]
    pub fn from_mtbf(mtbf_s: f64, mttr_s: f64) -> Self {
        Self { mean_up_s: mtbf_s, mean_down_s: mttr_s }
    }

    /// Long-run share of time up, A = U/(U + V).
    #[must_use]
    pub fn up_share(&self) -> f64 {
        1.0 / (1.0 + self.mean_down_s / self.mean_up_s)
    }

    /// Long-run share of outage, 1 − A, with all digits when small.
    #[must_use]
    pub fn down_share(&self) -> f64 {
        self.mean_down_s / self.mean_up_s * self.up_share()
    }

    /// Probability to be up after `t_s` given the state now: A + (1−A)e^(−(λ+μ)t) from up,
    /// A(1 − e^(−(λ+μ)t)) from down.
    #[must_use]
    pub fn up_after(&self, up_now: bool, t_s: f64) -> f64 {
        if up_now { 1.0 - self.down_after(t_s) } else { self.up_share() * self.mixed(t_s) }
    }

    /// Probability to be down after `t_s`, from up: −(1−A) expm1(−(λ+μ)t), with all digits when small.
    #[must_use]
    pub fn down_after(&self, t_s: f64) -> f64 {
        self.down_share() * self.mixed(t_s)
    }

    /// 1 − e^(−(λ+μ)t) with λ + μ = 1/U + 1/V.
    fn mixed(&self, t_s: f64) -> f64 {
        if t_s <= 0.0 {
            return 0.0;
        }
        -libm::expm1(-(t_s / self.mean_up_s + t_s / self.mean_down_s))
    }
}

/// Where one realisation of an [`Alternating`] process stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServiceState {
    up: bool,
    /// Instant of the last change (or of the first look).
    since: SimTime,
    /// Instant of the next change.
    until: SimTime,
    /// Number of the present sojourn, for its draw.
    sojourn: u64,
}

impl ServiceState {
    /// The stationary state at `now`: up with the long-run share, with a whole exponential time to
    /// go, as exponential times have no memory. `key.scan` is ignored.
    #[must_use]
    pub fn start(process: &Alternating, key: DrawKey, now: SimTime) -> Self {
        let mut rng = DrawKey { scan: 0, ..key }.rng(Purpose::GnssService);
        let up = uniform(&mut rng) < process.up_share();
        Self { up, since: now, until: now, sojourn: 0 }.with_sojourn(process, now, &mut rng)
    }

    /// Moves to `now` and tells whether the service is up. Each sojourn is one draw keyed by its number.
    pub fn advance(&mut self, process: &Alternating, key: DrawKey, now: SimTime) -> bool {
        while self.until <= now {
            let left_s = now.since_s(self.until);
            let cycle_s = process.mean_up_s + process.mean_down_s;
            let mut rng = DrawKey { scan: self.sojourn + 1, ..key }.rng(Purpose::GnssService);
            let mut next = *self;
            next.sojourn += 1;
            if left_s > MAX_CYCLES * cycle_s {
                // Too many changes to follow one by one: the transition probability is exact too.
                next.up = uniform(&mut rng) < process.up_after(!self.up, left_s);
                next.since = now;
                *self = next.with_sojourn(process, now, &mut rng);
                // A change in the very nanosecond is a sojourn of its own.
                self.until = self.until.max(SimTime(now.0 + 1));
            } else {
                next.up = !self.up;
                next.since = self.until;
                *self = next.with_sojourn(process, self.until, &mut rng);
            }
        }
        self.up
    }

    /// Number of the present sojourn: the same outage has the same number.
    #[must_use]
    pub fn sojourn(&self) -> u64 {
        self.sojourn
    }

    /// Seconds since the last change.
    #[must_use]
    pub fn age_s(&self, now: SimTime) -> f64 {
        now.since_s(self.since)
    }

    fn with_sojourn(mut self, process: &Alternating, from: SimTime, rng: &mut ChaCha8Rng) -> Self {
        let mean_s = if self.up { process.mean_up_s } else { process.mean_down_s };
        let length_s = mean_s * exponential(rng);
        // Beyond a hundred years (or for ever): later than any run.
        self.until = if length_s < 3e9 {
            SimTime(from.0.saturating_add(SimTime::from_s(length_s).0.max(1)))
        } else {
            SimTime(i64::MAX)
        };
        self
    }
}

/// Cycles followed one by one before the closed form takes over.
const MAX_CYCLES: f64 = 64.0;

/// Coverage, availability given coverage, and reliability given both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Service {
    /// A position is possible at this place and time; an outage means no measurement.
    pub coverage: Alternating,
    /// Enough healthy satellites; an outage means no measurement.
    pub availability: Alternating,
    /// The error is within its statistics; an outage is a soft failure: a measurement far off.
    pub reliability: Alternating,
}

impl Service {
    /// Nothing ever fails.
    pub const PERFECT: Self = Self {
        coverage: Alternating::NEVER_FAILS,
        availability: Alternating::NEVER_FAILS,
        reliability: Alternating::NEVER_FAILS,
    };

    /// Probability that a position is obtained and reliable.
    #[must_use]
    pub fn position_probability(&self) -> f64 {
        position_probability(
            self.coverage.up_share(),
            self.availability.up_share(),
            self.reliability.up_share(),
        )
    }
}

/// P = P_c · P_sa · P_sr, the probability of a good position from the three conditional ones.
#[must_use]
pub fn position_probability(coverage: f64, availability: f64, reliability: f64) -> f64 {
    coverage * availability * reliability
}

/// Probability that a reference station fails within a phase of `phase` (unit of `mtbf`):
/// 1 − P_rsc = −expm1(−T/MTBF), with all digits when small.
#[must_use]
pub fn reference_loss_probability(phase: f64, mtbf: f64) -> f64 {
    -libm::expm1(-phase / mtbf)
}

/// Continuity of a reference station over a phase: P_rsc = e^(−T/MTBF).
#[must_use]
pub fn reference_continuity(phase: f64, mtbf: f64) -> f64 {
    libm::exp(-phase / mtbf)
}

/// One failure mode: mean times between failures and to repair, in one unit (h in the vectors).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FailureMode {
    /// Mean time between failures.
    pub mtbf: f64,
    /// Mean time to repair.
    pub mttr: f64,
}

impl FailureMode {
    /// λ/μ = MTTR/MTBF: without division by a rate, so that MTTR → 0 is no special case.
    #[must_use]
    pub fn load(&self) -> f64 {
        self.mttr / self.mtbf
    }
}

/// Probability that a slot with these modes (one at a time) works: 1/(1 + Σ λᵢ/μᵢ).
#[must_use]
pub fn slot_up(modes: &[FailureMode]) -> f64 {
    1.0 / (1.0 + modes.iter().map(FailureMode::load).sum::<f64>())
}

/// Probability that it does not: Σ λᵢ/μᵢ · p_up, with all digits when small.
#[must_use]
pub fn slot_down(modes: &[FailureMode]) -> f64 {
    modes.iter().map(FailureMode::load).sum::<f64>() * slot_up(modes)
}

/// Probability that `down` of `slots` fail at once, repairs independent: the binomial law.
#[must_use]
pub fn down_independent(modes: &[FailureMode], slots: u32, down: u32) -> f64 {
    if down > slots {
        return 0.0;
    }
    let (up, out) = (slot_up(modes), slot_down(modes));
    let mut probability = libm::pow(up, f64::from(slots - down));
    for i in 0..down {
        probability *= f64::from(slots - i) / f64::from(i + 1) * out;
    }
    probability
}

/// Probability that `down` of `slots` fail at once when one is repaired at a time:
/// π_k = π₀ · N(N−1)…(N−k+1)(λ/μ)^k.
#[must_use]
pub fn down_single_repair(mode: &FailureMode, slots: u32, down: u32) -> f64 {
    if down > slots {
        return 0.0;
    }
    let (mut sum, mut term, mut wanted) = (1.0, 1.0, 1.0);
    for k in 1..=slots {
        term *= f64::from(slots - k + 1) * mode.load();
        sum += term;
        if k == down {
            wanted = term;
        }
    }
    wanted / sum
}

/// A process given by its share of time up and its mean outage.
pub(crate) fn read_process(
    given: &Given<'_>,
    share: &'static str,
    outage: &'static str,
    process: &mut Alternating,
) {
    let (mut up, mut down_s) = (process.up_share(), process.mean_down_s);
    given.number(share, &mut up);
    given.number(outage, &mut down_s);
    if given.has(share) || given.has(outage) {
        *process = Alternating::from_share(up, down_s);
    }
}

/// The three services of a satellite receiver, by their keys.
pub(crate) fn read_services(given: &Given<'_>, service: &mut Service) {
    read_process(given, "coverage", "coverage_mttr_s", &mut service.coverage);
    read_process(given, "availability", "availability_mttr_s", &mut service.availability);
    read_process(given, "reliability", "reliability_mttr_s", &mut service.reliability);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(entity: u64) -> DrawKey {
        DrawKey { run_seed: 7, sensor: 1, entity, scan: 0 }
    }

    /// Share up, mean outage and number of outages of one long realisation looked at every `step_s`.
    fn observe(process: &Alternating, entity: u64, step_s: f64, looks: i64) -> (f64, f64, u64) {
        let mut state = ServiceState::start(process, key(entity), SimTime::ZERO);
        let (mut up, mut outages, mut down_looks, mut before) = (0_i64, 0_u64, 0_i64, true);
        for k in 1..=looks {
            let now = state.advance(process, key(entity), SimTime::from_s(k as f64 * step_s));
            up += i64::from(now);
            down_looks += i64::from(!now);
            outages += u64::from(before && !now);
            before = now;
        }
        (up as f64 / looks as f64, down_looks as f64 * step_s / outages as f64, outages)
    }

    #[test]
    fn shares_and_outages_are_as_configured_at_any_rate() {
        for (name, share, mean_down_s, step_s, looks) in [
            ("coverage hole at 1 Hz", 0.9, 60.0, 1.0, 1_000_000),
            ("coverage hole at 10 Hz", 0.9, 60.0, 0.1, 5_000_000),
            // Looked at often enough to miss no short time up.
            ("mostly down", 0.1, 50.0, 0.1, 4_000_000),
        ] {
            let process = Alternating::from_share(share, mean_down_s);
            let (up, outage_s, outages) = observe(&process, 3, step_s, looks);
            let n = outages as f64;
            // Renewal theory: var(share) ≈ 2 P²(1−P)² per outage; outages are exponential.
            let sigma = (2.0 / n).sqrt() * share * (1.0 - share);
            assert!((up - share).abs() < 4.0 * sigma, "{name}: {up} (σ {sigma})");
            assert!((outage_s / mean_down_s - 1.0).abs() < 4.0 / n.sqrt(), "{name}: {outage_s}");
        }
    }

    #[test]
    fn the_trajectory_does_not_depend_on_the_looks() {
        let process = Alternating::from_share(0.8, 30.0);
        let mut coarse = ServiceState::start(&process, key(1), SimTime::ZERO);
        let mut fine = coarse;
        for second in 1..2_000 {
            for tenth in 1..10 {
                fine.advance(
                    &process,
                    key(1),
                    SimTime::from_s(f64::from(second - 1) + f64::from(tenth) * 0.1),
                );
            }
            let now = SimTime::from_s(f64::from(second));
            assert_eq!(fine.advance(&process, key(1), now), coarse.advance(&process, key(1), now));
            assert_eq!(fine, coarse);
        }
    }

    #[test]
    fn hard_service_processes_answer() {
        for (name, share, mean_down_s) in [
            ("repair in a nanosecond", 0.999, 1e-9),
            ("repair far below a nanosecond", 0.5, 1e-15),
            ("microsecond outages, always failing", 1e-6, 1e-6),
            ("never fails", 1.0, 1.0),
            ("fails once in an age", 1.0 - 1e-15, 3600.0),
            ("repair takes an age", 0.5, 1e12),
        ] {
            let process = Alternating::from_share(share, mean_down_s);
            let mut ups = 0;
            for entity in 0..2_000 {
                let mut state = ServiceState::start(&process, key(entity), SimTime::ZERO);
                let mut up = false;
                for hour in 1..4 {
                    up = state.advance(
                        &process,
                        key(entity),
                        SimTime::from_s(3600.0 * f64::from(hour)),
                    );
                }
                ups += u32::from(up);
            }
            let found = f64::from(ups) / 2_000.0;
            let sigma = (share * (1.0 - share) / 2_000.0).sqrt();
            assert!((found - share).abs() <= 4.0 * sigma + 1e-3, "{name}: {found}");
        }
    }

    #[test]
    fn closed_forms_are_published_values() {
        // 2008 and later performance standards: slot availability 0.957 and 0.98 for 21 of 24.
        let slot = [FailureMode { mtbf: 0.957, mttr: 0.043 }];
        let at_least_21: f64 = (0..=3).map(|k| down_independent(&slot, 24, k)).sum();
        assert!((at_least_21 - 0.9818).abs() < 5e-5, "{at_least_21}");
        let modes =
            [FailureMode { mtbf: 65_700.0, mttr: 720.0 }, FailureMode { mtbf: 2880.0, mttr: 24.0 }];
        assert!((slot_up(&modes) - 0.98107).abs() < 5e-6);
        for slots in [0, 1, 24] {
            let all: f64 = (0..=slots).map(|k| down_independent(&modes, slots, k)).sum();
            assert!((all - 1.0).abs() < 1e-13);
            let one: f64 = (0..=slots).map(|k| down_single_repair(&modes[0], slots, k)).sum();
            assert!((one - 1.0).abs() < 1e-13);
        }
        assert_eq!(slot_up(&[FailureMode { mtbf: 1.0, mttr: 0.0 }]), 1.0);
    }

    #[test]
    fn transition_probabilities_meet_the_simulation() {
        let process = Alternating::from_share(0.7, 20.0);
        let n = 20_000_u64;
        let mut later = [0_u64; 2];
        let mut first = [0_u64; 2];
        for entity in 0..n {
            let mut state = ServiceState::start(&process, key(entity), SimTime::ZERO);
            let up0 = state.advance(&process, key(entity), SimTime::ZERO);
            first[usize::from(up0)] += 1;
            later[usize::from(up0)] +=
                u64::from(state.advance(&process, key(entity), SimTime::from_s(11.0)));
        }
        for up0 in [false, true] {
            let (n, hits) = (first[usize::from(up0)] as f64, later[usize::from(up0)] as f64);
            let expected = process.up_after(up0, 11.0);
            let sigma = (expected * (1.0 - expected) / n).sqrt();
            assert!((hits / n - expected).abs() < 4.0 * sigma, "{up0}: {} {expected}", hits / n);
        }
        assert_eq!(process.down_after(0.0), 0.0);
        assert!((process.down_after(11.0) + process.up_after(true, 11.0) - 1.0).abs() < 1e-15);
    }
}
