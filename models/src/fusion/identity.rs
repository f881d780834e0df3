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
//! | a stay of 10 s, never moved, `g = e^{−d²/(2·20²)}` of its stand | departure: 0.02 + 0.98 g | 0.7 − 0.4 g |
//! | moving a minute before its off-block time | departure: 0.05 | 1 |
//! | no landing seen | arrival: that it landed before the track began (three minutes before, if it stands) | 1 |
//! | no take-off four minutes after its time | departure: e⁻³ | 1 |
//!
//! σ is the flight list's own error, learnt from the events of targets that a name has settled. The numbers are
//! assumptions; what they are worth is measured by the share of labels that are right at each probability.

use super::config::{LabelRules, TrackingConfig};
use super::track_file::Track;
use crate::filter::Estimate;
use crate::flight_list::{FlightEntry, FlightList, MovementKind};
use crate::frames::Vector2;
use crate::plot::{Plot, SensorId};
use crate::time::SimTime;

/// Something that happened on a runway: its place in the flight list's runways, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OnRunway {
    pub(super) runway: usize,
    pub(super) time: SimTime,
}

/// What a track has shown of itself.
#[derive(Clone, Debug, Default)]
pub(super) struct Evidence {
    /// The last two radar plots.
    plots: [Option<(SimTime, Vector2<f64>, SensorId)>; 2],
    /// Mean square of the plots' second differences over six, m²: the variance of one plot, both axes together.
    spread_m2: f64,
    /// How many differences it rests on, at most [`DIFFERENCES`].
    differences: f64,
    /// Where and since when it has been within [`STAYS_M`].
    anchor: Option<(SimTime, Vector2<f64>)>,
    birthplace: Option<Vector2<f64>>,
    /// When it was first farther than [`MOVED_M`] from where it was first seen.
    pub(super) moved: Option<SimTime>,
    /// Where it stood before it ever moved, for ten seconds.
    pub(super) stood_m: Option<Vector2<f64>>,
    /// It stood at a stand after it had moved.
    parked: bool,
    pub(super) landed: Option<OnRunway>,
    pub(super) took_off: Option<OnRunway>,
    /// When it was last slower than a take-off run begins.
    slow: Option<SimTime>,
    /// An episode began or ended since the labels were last weighed.
    pub(super) news: bool,
}

/// Differences over which the spread is averaged.
const DIFFERENCES: f64 = 60.0;
/// Fewer of them say nothing.
const FEWEST_DIFFERENCES: f64 = 8.0;
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
/// Course within 14° of the runway.
const ALONG_RUNWAY: f64 = 0.97;
/// A young track's speed is not trusted.
const FEWEST_PLOTS: u32 = 6;

impl Evidence {
    /// A plot that updated the track: its size.
    pub(super) fn take_plot(&mut self, plot: &Plot, interval_s: f64) {
        if !plot.kind.radar || !plot.across_m2.is_finite() {
            return;
        }
        let now = (plot.time, plot.position_m, plot.sensor);
        if let [Some(first), Some(second)] = self.plots {
            let gap = |a: (SimTime, Vector2<f64>, SensorId),
                       b: (SimTime, Vector2<f64>, SensorId)| {
                let dt_s = b.0.since_s(a.0);
                a.2 == b.2 && dt_s > 0.5 * interval_s && dt_s < 1.5 * interval_s
            };
            if gap(first, second) && gap(second, now) {
                let squared = (first.1 - second.1 * 2.0 + now.1).norm_squared() / 6.0;
                self.differences = (self.differences + 1.0).min(DIFFERENCES);
                self.spread_m2 += (squared - self.spread_m2) / self.differences;
            }
        }
        self.plots = [self.plots[1], Some(now)];
    }

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
        if speed < RUNWAY_SPEED_MPS || self.took_off.is_some() {
            return;
        }
        let Some((runway, way)) = along_runway(position, velocity / speed, flights, rules) else {
            return;
        };
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

    fn stays(&mut self, place: Vector2<f64>, flights: &FlightList, rules: &LabelRules) {
        if self.moved.is_none() {
            self.news |= self.stood_m.is_none();
            self.stood_m = Some(place);
        } else if !self.parked {
            let near = |stand: Vector2<f64>| (stand - place).norm() <= rules.stand_radius_m;
            self.parked = flights.entries.iter().filter_map(|e| e.stand_m).any(near);
            self.news |= self.parked;
        }
    }

    /// Whether an episode tells lines apart.
    pub(super) fn shows(&self) -> bool {
        self.landed.is_some() || self.took_off.is_some() || self.stood_m.is_some()
    }

    /// ln of how much likelier all of it is if the track is this line than if it is unlisted.
    pub(super) fn log_ratio(
        &self,
        born: SimTime,
        entry: &FlightEntry,
        flights: &FlightList,
        config: &TrackingConfig,
        now: SimTime,
        sigma_s: f64,
    ) -> f64 {
        let departs = entry.movement == MovementKind::Departure;
        let mut sum = self.size_ratio(entry, config);
        let of_runway = |event: OnRunway| {
            let named = flights.runways.get(event.runway).map(|(name, _)| name);
            if named != Some(&entry.runway) && !entry.runway.is_empty() {
                return IMPOSSIBLE;
            }
            let d = event.time.since_s(entry.eta_ctd) / sigma_s;
            -0.5 * d * d - libm::log(sigma_s * SQRT_TAU) + libm::log(BETWEEN_EVENTS_S)
        };
        match (self.landed, self.took_off) {
            (Some(landed), None) => sum += if departs { IMPOSSIBLE } else { of_runway(landed) },
            (None, Some(took_off)) => sum += if departs { of_runway(took_off) } else { IMPOSSIBLE },
            (Some(_), Some(_)) => {}
            (None, None) => {
                if departs && now.since_s(entry.eta_ctd) > NO_EVENT_S.max(2.0 * sigma_s) {
                    sum += UNLIKELY;
                } else if !departs {
                    // It landed before it was first seen; what stands had to get there.
                    let way_s = if self.stood_m.is_some() { TO_A_STAND_S } else { 0.0 };
                    let d = (born.since_s(entry.eta_ctd) - way_s) / sigma_s;
                    sum += libm::log(5e-3 + 0.5 * libm::erfc(-d * std::f64::consts::FRAC_1_SQRT_2));
                }
            }
        }
        if departs {
            let off_block = entry.off_block.unwrap_or(entry.eta_ctd);
            if let (Some(stood), Some(stand)) = (self.stood_m, entry.stand_m)
                && born.since_s(off_block) <= 120.0
            {
                let d2 = (stood - stand).norm_squared();
                let near = libm::exp(-d2 / 800.0);
                sum += libm::log((0.02 + 0.98 * near) / (0.7 - 0.4 * near));
            }
            if self.parked {
                sum += libm::log(0.1);
            }
            if self.moved.is_some_and(|moved| off_block.since_s(moved) > 60.0) {
                sum += libm::log(0.05);
            }
        }
        sum
    }

    /// ln of the density of the spread for this type over that for all kinds of targets.
    fn size_ratio(&self, entry: &FlightEntry, config: &TrackingConfig) -> f64 {
        if self.differences < FEWEST_DIFFERENCES || !(self.spread_m2 > 0.0) {
            return 0.0;
        }
        // χ² of the differences, and the model's own error.
        let sigma2 = 4.0 / self.differences + 0.35 * 0.35;
        let ln = libm::log(self.spread_m2);
        let density = |length: f64, span: f64| {
            let d = ln - libm::log(spread_m2(length, span));
            libm::exp(-0.5 * d * d / sigma2)
        };
        let (length, span) = config.size_of(entry);
        let all: f64 = CLASSES.iter().map(|&(share, [l, s])| share * density(l, s)).sum();
        // Nothing is known so well that a spread far from all classes tells them apart.
        libm::log((density(length, span) + 1e-4) / (all + 1e-4))
    }
}

/// Variance of one plot of a target of this size, both axes together, m²: noise and cells, and the wander of the echo's centre
/// over the body (fitted to radar plots of cars, A320 and B788).
fn spread_m2(length_m: f64, span_m: f64) -> f64 {
    0.7 + 0.0095 * 0.5 * (length_m * length_m + span_m * span_m)
}

/// Share and size of the kinds of targets of which nothing is known: car, truck, light, medium, heavy.
const CLASSES: [(f64, [f64; 2]); 5] = [
    (0.35, [4.6, 1.9]),
    (0.25, [12.0, 3.0]),
    (0.15, [8.3, 11.0]),
    (0.20, [38.0, 36.0]),
    (0.05, [60.0, 60.0]),
];

const SQRT_TAU: f64 = 2.506_628_274_631_000_5;
/// Time between two such events of unlisted targets, s.
const BETWEEN_EVENTS_S: f64 = 1800.0;
/// ln of what contradicts the line.
const IMPOSSIBLE: f64 = -8.0;
/// ln of what is hardly of it.
const UNLIKELY: f64 = -3.0;
/// So long after its time something should have happened, s.
const NO_EVENT_S: f64 = 240.0;
/// From the threshold to a stand, s.
const TO_A_STAND_S: f64 = 180.0;

/// The runway along which a target at `position` goes in direction `course`, and its way from the threshold, m.
fn along_runway(
    position: Vector2<f64>,
    course: Vector2<f64>,
    flights: &FlightList,
    rules: &LabelRules,
) -> Option<(usize, f64)> {
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
        on.then_some((index, way))
    })
}

/// The error of the flight list's times, s: its prior as three events, and the events of targets that told their name.
pub(super) fn list_sigma_s(tracks: &[Track], flights: &FlightList, rules: &LabelRules) -> f64 {
    const PRIOR_EVENTS: f64 = 3.0;
    let mut sum = PRIOR_EVENTS * rules.list_sigma_s * rules.list_sigma_s;
    let mut count = PRIOR_EVENTS;
    for track in tracks.iter().filter(|t| t.callsign.is_some() || t.address.is_some()) {
        let event = track.evidence.landed.or(track.evidence.took_off);
        let entry = track.entry.and_then(|entry| flights.by_callsign(entry));
        if let (Some(event), Some(entry)) = (event, entry) {
            let late_s = event.time.since_s(entry.eta_ctd);
            sum += (late_s * late_s).min(1e8);
            count += 1.0;
        }
    }
    (sum / count).sqrt().max(10.0)
}
