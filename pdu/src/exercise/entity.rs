//! One entity of others: its states in the receiver's time.

use super::clock::Validity;
use super::{Arrival, Limits, Transponder};
use crate::dead_reckoning::{Estimate, Motion};
use crate::enumerations::{AirAppearance, DeadReckoningAlgorithm};
use crate::records::{EntityId, EntityType};
use crate::{EntityState, EntityStateUpdate};

/// An entity as its sender describes it.
#[derive(Clone, Debug)]
pub struct Entity {
    /// The last Entity State, without its variable parameters.
    last: EntityState<'static>,
    /// By time of validity, ascending.
    states: Vec<State>,
    heard: Arrival,
    silence_s: f64,
    /// Exercise time from which on it is gone.
    left_ns: Option<i64>,
    /// What its transponder said last, and when.
    pub(super) transponder: Option<(Transponder, Arrival)>,
}

#[derive(Clone, Copy, Debug)]
struct State {
    valid: Validity,
    motion: Motion,
    frozen: bool,
}

/// Where an entity is believed to be at some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Place, velocity (per second of the sender) and attitude.
    pub estimate: Estimate,
    /// Seconds of the sender in one second of the exercise: what is seen moves at
    /// `estimate.velocity_mps` times this.
    pub pace: f64,
    /// Age of the state by the sender's clock, s.
    pub age_s: f64,
    /// The sender has stopped its time.
    pub frozen: bool,
}

/// Whether every coordinate is a number.
#[must_use]
pub fn is_finite(state: &EntityState<'_>) -> bool {
    let l = state.location;
    let o = state.orientation;
    let numbers =
        [l.x_m, l.y_m, l.z_m].into_iter().chain([o.psi_rad, o.theta_rad, o.phi_rad].map(f64::from));
    let vectors =
        [state.linear_velocity_mps, state.linear_acceleration_mps2, state.angular_velocity_rad_s];
    numbers.chain(vectors.iter().flat_map(|v| v.to_f64())).all(f64::is_finite)
}

impl Entity {
    pub(super) fn new(state: &EntityState<'_>, arrival: &Arrival) -> Self {
        Self {
            last: without_parameters(state),
            states: Vec::new(),
            heard: *arrival,
            silence_s: Limits::default().silence_s,
            left_ns: None,
            transponder: None,
        }
    }

    /// Identifier.
    #[must_use]
    pub fn id(&self) -> EntityId {
        self.last.entity_id
    }

    /// Type.
    #[must_use]
    pub fn entity_type(&self) -> EntityType {
        self.last.entity_type
    }

    /// Marking, for instance a call sign.
    #[must_use]
    pub fn marking(&self) -> String {
        self.last.marking.text()
    }

    /// The last Entity State, brought up to date by updates; without variable parameters.
    #[must_use]
    pub fn state(&self) -> &EntityState<'static> {
        &self.last
    }

    /// What its transponder says, while it is on.
    #[must_use]
    pub fn transponder(&self) -> Option<&Transponder> {
        self.transponder.as_ref().map(|(said, _)| said).filter(|said| said.on)
    }

    /// Whether it may be asked: it has not said that its transponder is off.
    #[must_use]
    pub fn answers(&self) -> bool {
        self.transponder.is_none_or(|(said, _)| said.on)
    }

    /// Arrival of its last PDU.
    #[must_use]
    pub fn heard(&self) -> Arrival {
        self.heard
    }

    /// Whether it has left at `time_ns`.
    #[must_use]
    pub fn has_left(&self, time_ns: i64) -> bool {
        self.left_ns.is_some_and(|left| left <= time_ns)
    }

    /// Where it is believed to be at `time_ns` of the exercise; `None` before its first state, after
    /// it left, and when it has been silent too long.
    #[must_use]
    pub fn at(&self, time_ns: i64) -> Option<Placed> {
        if self.has_left(time_ns) {
            return None;
        }
        let at = self.states.partition_point(|s| s.valid.time_ns <= time_ns).checked_sub(1)?;
        let State { valid, motion, frozen } = &self.states[at];
        let age_s = time_ns.saturating_sub(valid.time_ns) as f64 * 1e-9 * valid.pace;
        if age_s > self.silence_s {
            return None;
        }
        Some(Placed { estimate: motion.after(age_s), pace: valid.pace, age_s, frozen: *frozen })
    }

    pub(super) fn stated(
        &mut self,
        arrival: &Arrival,
        valid: Validity,
        state: &EntityState<'_>,
        limits: &Limits,
    ) {
        self.silence_s = limits.silence_s;
        self.heard = *arrival;
        let appearance = AirAppearance(state.appearance);
        // Who used the identifier before it was left is somebody else. A state from before it left was overtaken on its way.
        if self.left_ns.is_some_and(|left| valid.time_ns > left) && !appearance.deactivated() {
            self.left_ns = None;
            self.states.clear();
            self.transponder = None;
        }
        self.hear_transponder(arrival, appearance.frozen(), limits);
        let newest = self.states.last().is_none_or(|last| last.valid.time_ns <= valid.time_ns);
        if appearance.deactivated() {
            self.leave(valid.time_ns);
            return;
        }
        if newest {
            self.last = without_parameters(state);
        }
        let mut motion = Motion::from(state);
        let frozen = appearance.frozen();
        if frozen {
            motion.algorithm = DeadReckoningAlgorithm::STATIC;
        }
        let place = self.states.partition_point(|s| s.valid.time_ns <= valid.time_ns);
        self.states.insert(place, State { valid, motion, frozen });
        if self.states.len() > limits.states.max(1) {
            self.states.remove(self.spare());
        }
    }

    /// The state that is missed least: whose neighbours are nearest to each other, the older of two. The first and the last stay, so
    /// that the whole time since [`Self::forget_before`] can be asked for, and with `n` states kept of `s` seconds no gap that this leaves is
    /// longer than `2 s / (n − 1)`.
    fn spare(&self) -> usize {
        let gap_ns = |(a, b): (&State, &State)| b.valid.time_ns.saturating_sub(a.valid.time_ns);
        let inner = self.states.iter().zip(self.states.iter().skip(2)).map(gap_ns).enumerate();
        inner.min_by_key(|(_, gap_ns)| *gap_ns).map_or(0, |(index, _)| index + 1)
    }

    /// Forgets a transponder that does not say any more that it is on, by both clocks of the receiver; a sender whose time stands says
    /// nothing of its transponders.
    pub(super) fn hear_transponder(&mut self, arrival: &Arrival, frozen: bool, limits: &Limits) {
        let Some((said, at)) = &mut self.transponder else { return };
        if frozen {
            *at = *arrival;
        }
        if said.on && limits.is_silent(at, arrival) {
            self.transponder = None;
        }
    }

    /// The last Entity State with what an update says.
    #[must_use]
    pub fn updated(&self, update: &EntityStateUpdate<'_>) -> EntityState<'static> {
        EntityState {
            linear_velocity_mps: update.linear_velocity_mps,
            location: update.location,
            orientation: update.orientation,
            appearance: update.appearance,
            ..self.last.clone()
        }
    }

    #[cfg(test)]
    pub(super) fn states(&self) -> usize {
        self.states.len()
    }

    /// Whether it has not said that it leaves.
    pub(super) fn is_here(&self) -> bool {
        self.left_ns.is_none()
    }

    pub(super) fn leave(&mut self, time_ns: i64) {
        self.left_ns = Some(self.left_ns.map_or(time_ns, |left| left.min(time_ns)));
    }

    /// False if nothing of it can be asked for any more.
    pub(super) fn forget_before(&mut self, time_ns: i64, limits: &Limits) -> bool {
        let current = self.states.partition_point(|s| s.valid.time_ns <= time_ns).saturating_sub(1);
        self.states.drain(..current);
        let silent = self.states.last().is_none_or(|last| {
            time_ns.saturating_sub(last.valid.time_ns) as f64 * 1e-9 * last.valid.pace
                > limits.silence_s
        });
        !silent && !self.has_left(time_ns)
    }
}

fn without_parameters(state: &EntityState<'_>) -> EntityState<'static> {
    EntityState {
        entity_id: state.entity_id,
        force_id: state.force_id,
        entity_type: state.entity_type,
        alternative_entity_type: state.alternative_entity_type,
        linear_velocity_mps: state.linear_velocity_mps,
        location: state.location,
        orientation: state.orientation,
        appearance: state.appearance,
        dead_reckoning_algorithm: state.dead_reckoning_algorithm,
        dead_reckoning_parameters: state.dead_reckoning_parameters,
        linear_acceleration_mps2: state.linear_acceleration_mps2,
        angular_velocity_rad_s: state.angular_velocity_rad_s,
        marking: state.marking,
        capabilities: state.capabilities,
        ..EntityState::default()
    }
}
