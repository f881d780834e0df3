//! What each track has shown of itself that tells one line of the flight list from another: the evidence for labels.
//!
//! Each kind of evidence is an episode (a stay, a landing, a take-off, a size) and counts once, as a ratio of what the
//! line foretells to what an unlisted target would show; scans are not independent, so they are not multiplied.
//!
//! | evidence | for a line | for an unlisted target |
//! | --- | --- | --- |
//! | size: ln s² of at least eight second differences of its plots | N(ln v of its type) | mixture of the classes |
//! | landing: time over the threshold | arrival on that runway: N(Δt; 0, σ); any other e⁻⁸ | one in 1 800 s |
//! | take-off | departure on that runway: N(Δt; 0, σ); any other e⁻⁸ | one in 1 800 s |
//! | lining up: along a runway near its beginning | departure on it: N(Δt − 35 s; 0, σ ⊕ 40 s), with a tail; arrival e⁻³ | one in 1 800 s |
//! | a stay of 10 s, never moved, `g = e^{−d²/(2·20²)}` of its stand | departure, with ℓ that it has left its block: (1 − ℓ)(0.02 + 0.98 g) + ½ ℓ (1 − g) | 0.7 − 0.4 g |
//! | moving a minute before its off-block time | departure: 0.05 | 1 |
//! | no landing seen | arrival: that it landed before the track began (three minutes before, if it stands) | 1 |
//! | no take-off four minutes after its time | departure: e⁻³ | 1 |
//!
//! σ is the flight list's own error: six of them with the probability of each, learnt from all landings and take-offs, a
//! name or none: five that each fall on a line within seconds are no chance where the list is off by two minutes. The numbers are
//! assumptions; what they are worth is measured by the share of labels that are right at each probability.

use super::config::{LabelRules, TrackingConfig};
use super::size::{self, Spread};
use crate::filter::Estimate;
use crate::flight_list::{FlightEntry, FlightList, MovementKind};
use crate::frames::{Point2, Vector2};
use crate::time::SimTime;
use std::f64::consts::FRAC_1_SQRT_2;

/// Something that happened on a runway: its place in the flight list's runways, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OnRunway {
    pub(super) runway: usize,
    pub(super) time: SimTime,
}

/// The flight list as it is weighed now, with the error of its times, s.
#[derive(Clone, Copy, Debug)]
pub(super) struct List<'a> {
    pub(super) flights: &'a FlightList,
    pub(super) config: &'a TrackingConfig,
    pub(super) now: SimTime,
    pub(super) times: ListTimes,
}

/// How far the times of the flight list are off: standard deviations, s, and how likely each is. Its error is not known
/// beforehand; the events of a run tell it, named ones and those that fit a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ListTimes {
    pub(super) weights: [f64; SIGMAS],
    sigmas_s: [f64; SIGMAS],
}

/// Standard deviations that are told apart.
pub(super) const SIGMAS: usize = 6;
/// Each is so much larger than the one before.
const RATIO: f64 = 2.2;

impl ListTimes {
    /// As the scene states it: its own figure the likeliest, smaller and larger ones by steps of [`RATIO`].
    pub(super) fn stated(sigma_s: f64) -> Self {
        let sigmas_s =
            std::array::from_fn(|k| (sigma_s * libm::pow(RATIO, k as f64 - 4.0)).max(5.0));
        Self { weights: [0.06, 0.08, 0.12, 0.2, 0.36, 0.18], sigmas_s }
    }

    /// The same after events whose ln likelihood under each deviation is this.
    pub(super) fn after(mut self, ln_likelihood: &[f64; SIGMAS]) -> Self {
        let most = ln_likelihood.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if most.is_finite() {
            let own = self.weights.iter_mut().zip(ln_likelihood);
            own.for_each(|(w, l)| *w *= libm::exp((l - most).max(-600.0)));
            let sum: f64 = self.weights.iter().sum();
            self.weights.iter_mut().for_each(|w| *w /= sum);
        }
        self
    }

    /// Only the deviation of this number.
    pub(super) fn only(mut self, k: usize) -> Self {
        self.weights = std::array::from_fn(|i| f64::from(u8::from(i == k)));
        self
    }

    /// ln of the density of an error `off_s` of the list and `own_s` of the event itself, per second.
    fn ln_density(&self, off_s: f64, own_s: f64) -> f64 {
        let parts = self.weights.iter().zip(&self.sigmas_s).map(|(w, s)| {
            let sigma = libm::hypot(*s, own_s);
            let d = off_s / sigma;
            w * libm::exp(-0.5 * d * d) / (sigma * SQRT_TAU)
        });
        libm::log(parts.sum::<f64>().max(1e-30))
    }

    /// Probability that what the list says happens no later than `off_s` after its time, which varies by `own_s` itself.
    fn below(&self, off_s: f64, own_s: f64) -> f64 {
        let parts = self.weights.iter().zip(&self.sigmas_s).map(|(w, s)| {
            let sigma = libm::hypot(*s, own_s);
            w * 0.5 * libm::erfc(-off_s / sigma * FRAC_1_SQRT_2)
        });
        parts.sum()
    }

    /// Mean standard deviation, s.
    fn mean_s(&self) -> f64 {
        self.weights.iter().zip(&self.sigmas_s).map(|(w, s)| w * s).sum()
    }
}

/// What a track has shown of itself.
#[derive(Clone, Debug, Default)]
pub(super) struct Evidence {
    /// Where and since when it has been within [`STAYS_M`].
    anchor: Option<(SimTime, Point2<f64>)>,
    birthplace: Option<Point2<f64>>,
    /// When it was first farther than [`MOVED_M`] from where it was first seen.
    pub(super) moved: Option<SimTime>,
    /// Where it stood before it ever moved, for ten seconds.
    pub(super) stood_m: Option<Point2<f64>>,
    /// It stood at a stand after it had moved.
    parked: bool,
    pub(super) landed: Option<OnRunway>,
    pub(super) took_off: Option<OnRunway>,
    /// When it was first seen to roll or stand on a runway near its beginning, along it.
    pub(super) lined_up: Option<OnRunway>,
    /// When it was last slower than a take-off run begins.
    slow: Option<SimTime>,
    /// An episode began or ended since the labels were last weighed.
    pub(super) news: bool,
}

/// A target that stays within this has not moved, m: the errors of the plots of a large one.
const STAYS_M: f64 = 15.0;
/// For this long it is a stay, s.
const STAY_S: f64 = 10.0;
/// Farther than this from where it was first seen it has moved, m.
const MOVED_M: f64 = 40.0;
/// Faster than this along a runway it lands or takes off, m/s.
const RUNWAY_SPEED_MPS: f64 = 35.0;
/// Slower than this so many seconds before, it takes off.
const SLOW_MPS: f64 = 20.0;
const RUN_UP_S: f64 = 25.0;
/// What moves along a runway within this of its threshold, faster than this, lines up or begins its run, m and m/s.
const LINE_UP_WAY_M: f64 = 900.0;
const LINE_UP_MPS: f64 = 2.0;
/// So long before its take-off, s, and how much that varies.
const LINE_UP_S: f64 = 35.0;
const LINE_UP_SIGMA_S: f64 = 40.0;
const LINE_UP_TAIL_S: f64 = 400.0;
/// Course within 14° of the runway.
const ALONG_RUNWAY: f64 = 0.97;
/// What is fast follows the runway within 6°: an approach does within 3°, and the course of a track at such speeds is good to 2°.
const ALONG_AT_SPEED: f64 = 0.995;
/// What is fast and so many times farther aside than anything on final is no landing.
const BESIDE: f64 = 3.0;
/// A young track's speed is not trusted.
const FEWEST_PLOTS: u32 = 6;

impl Evidence {
    /// The state at the end of a scan: stays, landings, take-offs.
    pub(super) fn take_state(
        &mut self,
        at: &Estimate,
        plots: u32,
        flights: &FlightList,
        rules: &LabelRules,
    ) {
        if plots < FEWEST_PLOTS {
            return;
        }
        let (now, position, velocity) = (at.time, at.position_m(), at.velocity_mps());
        let speed = libm::hypot(velocity.x, velocity.y);
        let birthplace = *self.birthplace.get_or_insert(position);
        if self.moved.is_none() && (position - birthplace).norm() > MOVED_M {
            (self.moved, self.news) = (Some(now), true);
        }
        match self.anchor {
            Some((since, place)) if (position - place).norm() <= STAYS_M => {
                // Asked once: what it stands at does not change while it stands.
                if (STAY_S..STAY_S + 2.0).contains(&now.since_s(since)) {
                    self.stays(place, flights, rules);
                }
            }
            _ => self.anchor = Some((now, position)),
        }
        if speed < SLOW_MPS {
            self.slow = Some(now);
        }
        let astray = |at| speed > RUNWAY_SPEED_MPS && is_beside(position, at, flights, rules);
        if self.landed.is_some_and(astray) {
            // Runways are straight: it was none that lands, but crossed the line (an echo of a pulse before the last does).
            (self.landed, self.news) = (None, true);
        }
        if self.took_off.is_some() || speed < LINE_UP_MPS {
            return;
        }
        let course = velocity / speed;
        let Some((runway, way, aligned)) = along_runway(position, course, flights, rules) else {
            return;
        };
        if speed < RUNWAY_SPEED_MPS {
            let begins = (-50.0..LINE_UP_WAY_M).contains(&way) && self.landed.is_none();
            if begins && self.lined_up.is_none() {
                (self.lined_up, self.news) = (Some(OnRunway { runway, time: now }), true);
            }
            return;
        }
        if aligned < ALONG_AT_SPEED {
            return;
        }
        if self.slow.is_some_and(|slow| now.since_s(slow) <= RUN_UP_S) {
            // What braked from a landing was fast before it was slow.
            if self.landed.is_none() {
                (self.took_off, self.news) = (Some(OnRunway { runway, time: now }), true);
            }
        } else if self.landed.is_none() && self.slow.is_none() {
            let time = now.plus_s(-way / speed);
            (self.landed, self.news) = (Some(OnRunway { runway, time }), true);
        }
    }

    fn stays(&mut self, place: Point2<f64>, flights: &FlightList, rules: &LabelRules) {
        if self.moved.is_none() {
            self.news |= self.stood_m.is_none();
            self.stood_m = Some(place);
        } else if !self.parked {
            let near = |stand: Point2<f64>| (stand - place).norm() <= rules.stand_radius_m;
            self.parked = flights.entries.iter().filter_map(|e| e.stand_m).any(near);
            self.news |= self.parked;
        }
    }

    /// Whether an episode tells lines apart.
    pub(super) fn shows(&self) -> bool {
        self.is_event() || self.lined_up.is_some() || self.stood_m.is_some()
    }

    /// When it landed or took off.
    pub(super) fn event(&self) -> Option<SimTime> {
        self.landed.or(self.took_off).map(|at| at.time)
    }

    /// Whether it landed or took off: what tells how far the list's times are off.
    pub(super) fn is_event(&self) -> bool {
        self.landed.is_some() != self.took_off.is_some()
    }

    /// ln of how much likelier all of it is if the track is this line than if it is unlisted.
    pub(super) fn log_ratio(
        &self,
        spread: &Spread,
        born: SimTime,
        entry: &FlightEntry,
        list: &List<'_>,
    ) -> f64 {
        let &List { flights, config, now, times } = list;
        let departs = entry.movement == MovementKind::Departure;
        let mut sum = Self::size_ratio(spread, entry, config);
        let of_runway = |event: OnRunway, before_s: f64, own_s: f64| {
            let named = flights.runways.get(event.runway).map(|(name, _)| name);
            if named != Some(&entry.runway) && !entry.runway.is_empty() {
                return IMPOSSIBLE;
            }
            let off_s = event.time.since_s(entry.eta_ctd) + before_s;
            let ln = times.ln_density(off_s, own_s);
            // How long somebody stands lined up has a long tail: two departures on one runway are not told apart by it.
            let said = if own_s > 0.0 {
                libm::log(0.6 * libm::exp(ln) + 0.4 / LINE_UP_TAIL_S)
            } else {
                ln
            };
            said + libm::log(BETWEEN_EVENTS_S)
        };
        match (self.landed, self.took_off) {
            (None, None) if self.lined_up.is_some() => {
                let own = |at| of_runway(at, LINE_UP_S, LINE_UP_SIGMA_S);
                sum += if departs { self.lined_up.map_or(0.0, own) } else { UNLIKELY };
            }
            (Some(landed), None) => {
                sum += if departs { IMPOSSIBLE } else { of_runway(landed, 0.0, 0.0) };
            }
            (None, Some(took_off)) => {
                sum += if departs { of_runway(took_off, 0.0, 0.0) } else { IMPOSSIBLE };
            }
            (Some(_), Some(_)) => {}
            (None, None) => {
                if departs && now.since_s(entry.eta_ctd) > NO_EVENT_S.max(2.0 * times.mean_s()) {
                    sum += UNLIKELY;
                } else if !departs {
                    // It landed before it was first seen; what stands had to get there.
                    let way_s = if self.stood_m.is_some() { TO_A_STAND_S } else { 0.0 };
                    let before = times.below(born.since_s(entry.eta_ctd) - way_s, 0.0);
                    sum += libm::log(5e-3 + before);
                }
            }
        }
        if departs {
            let off_block = entry.off_block.unwrap_or(entry.eta_ctd);
            if let (Some(stood), Some(stand)) = (self.stood_m, entry.stand_m) {
                // Off its block (by a list as far off as it is) it stands anywhere, for its engines or in a queue.
                let since_s = born.since_s(off_block);
                let early = 0.5 * libm::erfc(-since_s / EARLY_SIGMA_S * FRAC_1_SQRT_2);
                let left = (1.0 - DELAYED) * early.min(times.below(since_s, OFF_BLOCK_SIGMA_S));
                let d2 = (stood - stand).norm_squared();
                let near = libm::exp(-d2 / 800.0);
                let own = (1.0 - left) * (0.02 + 0.98 * near) + left * STANDS_AFTER * (1.0 - near);
                sum += libm::log(own / (0.7 - 0.4 * near));
            }
            if self.parked {
                sum += libm::log(0.1);
            }
            // Off its block for minutes, and it stands where it was first seen.
            if self.stood_m.is_some()
                && self.moved.is_none()
                && now.since_s(off_block) > 180.0
                && now.since_s(born) > 60.0
            {
                sum += UNLIKELY;
            }
            if self.moved.is_some_and(|moved| off_block.since_s(moved) > 60.0) {
                sum += libm::log(0.05);
            }
        }
        sum
    }

    /// ln of the density of what its plots show of its size for this type over that for all kinds of targets: over all of
    /// them, or lately where that speaks against it more. A track that was taken over by another target shows it so.
    fn size_ratio(spread: &Spread, entry: &FlightEntry, config: &TrackingConfig) -> f64 {
        let of = |seen: Option<(f64, f64)>| {
            let (seen_m2, triples) =
                seen.filter(|(v, n)| *n >= size::FEWEST_TRIPLES && *v > 0.0)?;
            let density = |(length, span): (f64, f64)| {
                libm::exp(size::ln_density(seen_m2, triples, length, span))
            };
            let own = density(config.size_of(entry));
            let classes = size::CLASSES.iter();
            let all: f64 = classes.map(|(b, share)| share * density((b.length_m, b.span_m))).sum();
            // Nothing is known so well that a spread far from all classes tells them apart.
            Some(libm::log((own + 1e-4) / (all + 1e-4)))
        };
        let all = of(spread.variance_m2());
        let lately = of(spread.lately_m2()).filter(|l| *l < 0.0);
        all.map_or(0.0, |all| lately.map_or(all, |lately| all.min(lately)))
    }
}

const SQRT_TAU: f64 = 2.506_628_274_631_000_5;
/// Time between two such events of unlisted targets, s.
const BETWEEN_EVENTS_S: f64 = 1800.0;
/// ln of what contradicts the line.
const IMPOSSIBLE: f64 = -8.0;
/// ln of what is hardly of it.
const UNLIKELY: f64 = -3.0;
/// So long after its time something should have happened, s.
const NO_EVENT_S: f64 = 240.0;
/// How much the time of leaving a block varies beside the list's error, s.
const OFF_BLOCK_SIGMA_S: f64 = 60.0;
/// Nobody leaves a block much before the list says so, however far off its times are, s.
const EARLY_SIGMA_S: f64 = 50.0;
/// Share of departures that stay at their stand for much longer than listed (assumed).
const DELAYED: f64 = 0.1;
/// Share of departures that, once off their block, are first seen to stand for ten seconds (assumed).
const STANDS_AFTER: f64 = 0.5;
/// From the threshold to a stand, s.
const TO_A_STAND_S: f64 = 180.0;

/// Whether a target at `position` is beside the runway that it seemed to land on, before the runway's end.
fn is_beside(
    position: Point2<f64>,
    at: OnRunway,
    flights: &FlightList,
    rules: &LabelRules,
) -> bool {
    flights.runways.get(at.runway).is_some_and(|(_, [threshold, far_end])| {
        let along = far_end - threshold;
        let (length, from) = (along.norm(), position - threshold);
        let aside = (from.x * along.y - from.y * along.x) / length;
        from.dot(&along) < length * length && aside.abs() > BESIDE * rules.arrival_lateral_m
    })
}

/// The runway along which a target at `position` goes in direction `course`, its way from the threshold, m, and the cosine
/// between both courses.
fn along_runway(
    position: Point2<f64>,
    course: Vector2<f64>,
    flights: &FlightList,
    rules: &LabelRules,
) -> Option<(usize, f64, f64)> {
    flights.runways.iter().enumerate().find_map(|(index, (_, [threshold, far_end]))| {
        let along = far_end - threshold;
        let length = along.norm();
        if !(length > 1.0) {
            return None;
        }
        let along = along / length;
        let from = position - threshold;
        let (way, aside) = (from.dot(&along), from.x * along.y - from.y * along.x);
        let on = (-rules.final_length_m..=length).contains(&way)
            && aside.abs() <= rules.arrival_lateral_m
            && course.dot(&along) >= ALONG_RUNWAY;
        on.then_some((index, way, course.dot(&along)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Callsign;

    /// One runway east from the origin, 3 km.
    fn one_runway() -> FlightList {
        let ends = [Point2::origin(), Point2::new(3_000.0, 0.0)];
        FlightList { entries: Vec::new(), runways: vec![("09".into(), ends)] }
    }

    /// What the states at these times, places (m) and velocities (m/s) show, of so many plots each.
    fn shown(plots: u32, states: &[(f64, [f64; 2], [f64; 2])]) -> Evidence {
        let mut evidence = Evidence::default();
        for &(t, at, v) in states {
            let r = crate::filter::Sym2 { xx: 1.0, xy: 0.0, yy: 1.0 };
            let mut state =
                crate::filter::Gaussian::at_position(Point2::new(at[0], at[1]), r, 1.0, 0.1);
            state.x[1] = crate::filter::lanes::Pair::new(v[0], v[1]);
            let state = Estimate::new(SimTime::from_s(t), state);
            evidence.take_state(&state, plots, &one_runway(), &TrackingConfig::paper().labels);
        }
        evidence
    }

    #[test]
    fn who_lines_up_goes_along_the_runway_near_its_beginning_and_not_slowly() {
        let lines_up =
            |plots, at: [f64; 2], v: [f64; 2]| shown(plots, &[(5.0, at, v)]).lined_up.is_some();
        let (at, v) = ([100.0, 3.0], [8.0, 0.1]);
        assert!(lines_up(6, at, v) && !lines_up(5, at, v), "from six plots on");
        for (at, v, expected) in [
            (at, [1.9, 0.0], false),
            (at, [2.0, 0.0], true),
            (at, [34.0, 0.0], true),
            (at, [-8.0, 0.0], false),
            (at, [8.0, 2.1], false),
            (at, [8.0, 1.9], true),
            ([-49.0, 0.0], v, true),
            ([-51.0, 0.0], v, false),
            ([899.0, 0.0], v, true),
            ([901.0, 0.0], v, false),
            ([100.0, 59.0], v, true),
            ([100.0, 61.0], v, false),
            ([100.0, -61.0], v, false),
        ] {
            assert_eq!(lines_up(6, at, v), expected, "{at:?} {v:?}");
        }
        let of = shown(6, &[(5.0, at, v), (6.0, at, v)]);
        assert_eq!(of.lined_up.map(|l| (l.runway, l.time)), Some((0, SimTime::from_s(5.0))));
        assert!(of.news && of.shows() && !of.is_event() && of.event().is_none());
    }

    #[test]
    fn who_is_fast_along_a_runway_took_off_if_it_was_slow_and_landed_if_not() {
        let begun = (0.0, [100.0, 0.0], [19.0, 0.0]);
        let run = |t: f64, speed: f64| (t, [800.0, 0.0], [speed, 0.0]);
        let took_off = shown(6, &[begun, run(20.0, 60.0)]);
        assert_eq!(took_off.took_off.map(|t| (t.runway, t.time)), Some((0, SimTime::from_s(20.0))));
        assert!(took_off.landed.is_none() && took_off.is_event() && took_off.shows());
        assert_eq!(took_off.event(), Some(SimTime::from_s(20.0)));
        // Not fast enough; too long after; never slow.
        assert!(!shown(6, &[begun, run(20.0, 34.9)]).is_event());
        assert!(!shown(6, &[begun, run(25.1, 60.0)]).is_event(), "neither one nor the other");
        assert!(shown(6, &[begun, run(25.0, 60.0)]).is_event());
        let slow = (0.0, [100.0, 0.0], [20.0, 0.0]);
        assert!(
            shown(6, &[slow, run(20.0, 60.0)]).took_off.is_none(),
            "a start of 20 m/s is not slow"
        );
        // A landing is when it is over the threshold, seen before or after it.
        for (at, time_s) in [(-700.0, 20.0), (700.0, 0.0)] {
            let landed = shown(6, &[(10.0, [at, 5.0], [70.0, 0.0])]);
            assert_eq!(
                landed.landed.map(|l| (l.runway, l.time)),
                Some((0, SimTime::from_s(time_s)))
            );
            assert!(landed.took_off.is_none() && landed.is_event());
        }
        // Aside of its course by more than six degrees no landing, nor the other way, nor from too far.
        for (at, v) in [
            ([-700.0, 5.0], [70.0, 7.2]),
            ([700.0, 0.0], [-70.0, 0.0]),
            ([-20_001.0, 0.0], [70.0, 0.0]),
            ([3_001.0, 0.0], [70.0, 0.0]),
        ] {
            assert!(!shown(6, &[(10.0, at, v)]).is_event(), "{at:?}");
        }
        assert!(shown(6, &[(10.0, [-700.0, 5.0], [70.0, 6.8])]).is_event());
        // What landed and braked does not take off; what turns out far beside the runway did not land.
        let rolled = [
            (0.0, [100.0, 0.0], [70.0, 0.0]),
            (20.0, [1_000.0, 0.0], [15.0, 0.0]),
            (30.0, [1_300.0, 0.0], [40.0, 0.0]),
        ];
        assert!(shown(6, &rolled).took_off.is_none() && shown(6, &rolled).landed.is_some());
        for (aside, kept) in [(179.0, true), (181.0, false), (-181.0, false)] {
            let astray = [(0.0, [-900.0, 0.0], [70.0, 0.0]), (10.0, [-200.0, aside], [0.0, 50.0])];
            assert_eq!(shown(6, &astray).landed.is_some(), kept, "{aside}");
            let slow = [(0.0, [-900.0, 0.0], [70.0, 0.0]), (10.0, [-200.0, aside], [0.0, 30.0])];
            assert!(shown(6, &slow).landed.is_some(), "{aside}: what is slow may leave");
        }
    }

    #[test]
    fn who_stays_for_ten_seconds_stands_and_who_leaves_has_moved() {
        let at = |t: f64, x: f64| (t, [x, 500.0], [0.0, 0.0]);
        let stood = |states: &[(f64, [f64; 2], [f64; 2])]| shown(6, states).stood_m;
        assert_eq!(stood(&[at(0.0, 0.0), at(9.0, 0.0)]), None);
        assert_eq!(stood(&[at(0.0, 0.0), at(10.0, 15.0)]), Some(Point2::new(0.0, 500.0)));
        assert_eq!(stood(&[at(0.0, 0.0), at(10.0, 15.1)]), None);
        assert_eq!(stood(&[at(0.0, 0.0), at(5.0, 16.0), at(14.9, 16.0)]), None);
        assert_eq!(
            stood(&[at(0.0, 0.0), at(5.0, 16.0), at(15.0, 16.0)]),
            Some(Point2::new(16.0, 500.0))
        );
        assert!(shown(6, &[at(0.0, 0.0), at(10.0, 0.0)]).shows());
        let moved = |x: f64| shown(6, &[at(0.0, 0.0), at(7.0, x)]).moved;
        assert_eq!(
            (moved(40.0), moved(40.1), moved(-40.1)),
            (None, Some(SimTime::from_s(7.0)), Some(SimTime::from_s(7.0)))
        );
        // What stands after it moved is not where it came from.
        assert_eq!(stood(&[at(0.0, 0.0), at(7.0, 90.0), at(17.0, 90.0)]), None);
    }

    /// A departure that stood far from its stand when it was first seen: strange before it was off its block, nothing after.
    #[test]
    fn what_has_left_its_block_may_stand_anywhere() {
        let config = TrackingConfig::paper();
        let entry = FlightEntry {
            callsign: Callsign::new("SWR1"),
            address: None,
            type_designator: String::new(),
            wake: None,
            movement: MovementKind::Departure,
            runway: String::new(),
            stand: String::new(),
            stand_m: Some(Point2::origin()),
            eta_ctd: SimTime::from_s(900.0),
            off_block: Some(SimTime::from_s(300.0)),
            routing: Vec::new(),
        };
        let flights = FlightList { entries: vec![entry.clone()], runways: Vec::new() };
        let list = List {
            flights: &flights,
            config: &config,
            now: SimTime::from_s(700.0),
            times: ListTimes::stated(30.0),
        };
        let ratio = |born_s: f64, stood: Point2<f64>, moved_s: f64| {
            let evidence = Evidence {
                stood_m: Some(stood),
                moved: Some(SimTime::from_s(moved_s)),
                ..Evidence::default()
            };
            evidence.log_ratio(&Spread::default(), SimTime::from_s(born_s), &entry, &list)
        };
        let far = Point2::new(120.0, 0.0);
        assert!(ratio(50.0, far, 310.0) < -2.0, "before: {}", ratio(50.0, far, 310.0));
        assert!(ratio(600.0, far, 650.0) > -0.7, "after: {}", ratio(600.0, far, 650.0));
        // Minutes on, the one that stands elsewhere speaks no more against this line than the one before did.
        assert!(ratio(400.0, far, 650.0) - ratio(600.0, far, 650.0) < 0.2);
        assert!(ratio(50.0, Point2::origin(), 310.0) > 0.5, "at its stand it speaks for it");
        assert!(ratio(600.0, Point2::origin(), 650.0) < 0.0, "who stands there after is another");
    }

    /// An echo of a pulse before the last follows no runway: what crossed the line of one at 75 m/s, 8° off, "landed" there and
    /// was called by the next arrival's name for a minute (Amsterdam: 36 to 110 reports of an hour).
    #[test]
    fn what_crosses_the_line_of_a_runway_at_speed_has_not_landed_on_it() {
        let config = TrackingConfig::paper();
        let runway = [Point2::origin(), Point2::new(3_000.0, 0.0)];
        let flights = FlightList { entries: Vec::new(), runways: vec![("09".to_owned(), runway)] };
        let fly = |from: Point2<f64>, legs: &[(u32, Vector2<f64>)]| {
            let (mut evidence, mut place, mut t) = (Evidence::default(), from, 0.0);
            for (seconds, velocity) in legs {
                for _ in 0..*seconds {
                    place += *velocity;
                    t += 1.0;
                    let r = crate::filter::Sym2 { xx: 4.0, xy: 0.0, yy: 4.0 };
                    let mut state = crate::filter::Gaussian::at_position(place, r, 1.0, 0.1);
                    state.x[1] = crate::filter::lanes::Pair::new(velocity.x, velocity.y);
                    let at = Estimate::new(SimTime::from_s(t), state);
                    evidence.take_state(&at, 20, &flights, &config.labels);
                }
            }
            evidence
        };
        let (p, v) = (Point2::new, Vector2::new);
        let crossing = fly(p(-1_500.0, 210.0), &[(24, v(74.3, -10.4))]);
        assert_eq!(crossing.landed, None, "eight degrees off");
        let aligned = fly(p(-2_000.0, 0.0), &[(10, v(75.0, 0.0))]);
        assert!(aligned.landed.is_some_and(|at| (at.time.s() - 26.7).abs() < 0.5));
        let left = fly(p(-2_000.0, 0.0), &[(10, v(75.0, 0.0)), (16, v(73.0, -17.0))]);
        assert_eq!(left.landed, None, "aligned for a while, then beside it as fast");
        // Who lands, brakes and turns off keeps it; who goes around keeps it to the runway's end.
        let lands = [(45, v(70.0, 0.0)), (20, v(30.0, 0.0)), (30, v(8.0, -8.0))];
        assert!(fly(p(-2_000.0, 0.0), &lands).landed.is_some());
        let around = [(70, v(75.0, 0.0)), (40, v(53.0, 53.0))];
        assert!(fly(p(-2_000.0, 0.0), &around).landed.is_some());
    }

    /// Whatever is known of the list's error, its density is one (sum 1), and its distribution is the sum of its density.
    #[test]
    fn the_error_of_the_list_is_a_density_and_its_distribution() {
        let learnt = ListTimes::stated(60.0).after(&[0.0, 1.0, -2.0, 0.5, -1.0, 3.0]);
        for (times, own_s) in [(ListTimes::stated(120.0), 0.0), (learnt, 0.0), (learnt, 40.0)] {
            let step = 0.25;
            let mut sum = 0.0;
            for k in -16_000..16_000 {
                let off_s = step * (f64::from(k) + 0.5);
                sum += step * libm::exp(times.ln_density(off_s, own_s));
                if k % 800 == 0 {
                    let end_s = step * f64::from(k + 1);
                    let below = times.below(end_s, own_s);
                    assert!((sum - below).abs() < 1e-5, "{end_s}: {sum} {below}");
                }
            }
            assert!((sum - 1.0).abs() < 1e-5, "{sum}");
        }
    }
}
