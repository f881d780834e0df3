//! When an entity's state is due to be sent again, and when an entity that is not heard is gone.
//!
//! Pure decisions on whole nanoseconds of simulated time; nothing here reads a clock or sends.

use crate::dead_reckoning::{Estimate, Motion};
use crate::records::EntityId;
use geodesy::{Ecef, Euler};

/// When to send. Defaults of the standard: 1 m, 3°, 5 s (IEEE 1278.1-2012, annex B).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// True distance between the entity and what receivers dead-reckon, metres.
    pub distance_m: f64,
    /// True angle of the one rotation between the two orientations, radians.
    pub angle_rad: f64,
    /// Longest silence, nanoseconds.
    pub heartbeat_ns: i64,
    /// Heartbeats come earlier by up to this share of the interval, differently for each entity and
    /// each time, so that entities that began together do not send together. 0 to 1.
    pub jitter: f64,
}

impl Default for Thresholds {
    fn default() -> Self {
        Self {
            distance_m: 1.0,
            angle_rad: 3f64.to_radians(),
            heartbeat_ns: 5_000_000_000,
            jitter: 0.1,
        }
    }
}

/// Why a PDU is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// Nothing was sent yet.
    First,
    /// The entity is farther than the threshold from where receivers believe it.
    Distance,
    /// It is turned by more than the threshold.
    Angle,
    /// It was silent for long enough.
    Heartbeat,
    /// The caller said that something else changed (appearance, marking …).
    Changed,
}

/// Decides for one entity whether its state has to be sent.
///
/// ```
/// use pdu::{EntityState, publishing::{Due, Publisher, Thresholds}};
/// let mut publisher = Publisher::new(Thresholds::default());
/// let state = EntityState::default(); // what would be sent now, as it would be encoded
/// let (place, attitude) = (state.location.into(), state.orientation.into());
/// assert_eq!(publisher.due(0, place, attitude), Some(Due::First));
/// publisher.sent(0, &state);
/// assert_eq!(publisher.due(50_000_000, place, attitude), None);
/// ```
#[derive(Clone, Debug)]
pub struct Publisher {
    thresholds: Thresholds,
    last: Option<Sent>,
    changed: bool,
    count: u64,
}

#[derive(Clone, Copy, Debug)]
struct Sent {
    at_ns: i64,
    heartbeat_ns: i64,
    motion: Motion,
}

impl Publisher {
    /// An entity that has sent nothing yet.
    #[must_use]
    pub fn new(thresholds: Thresholds) -> Self {
        Self { thresholds, last: None, changed: false, count: 0 }
    }

    /// Whether a PDU is due at `now_ns` for an entity that is truly at `location` with `orientation`.
    ///
    /// What receivers believe is dead-reckoned from the state of the last [`Self::sent`], as they got it:
    /// velocities and angles rounded to 32 bits. A place or orientation that is not finite is always
    /// due: it cannot be compared.
    #[must_use]
    pub fn due(&self, now_ns: i64, location: Ecef, orientation: Euler) -> Option<Due> {
        let Some(last) = &self.last else { return Some(Due::First) };
        if self.changed {
            return Some(Due::Changed);
        }
        let silent_ns = now_ns.saturating_sub(last.at_ns);
        let believed = last.motion.after(silent_ns as f64 * 1e-9);
        let off_m = believed.location.distance_m(location);
        if off_m > self.thresholds.distance_m || !off_m.is_finite() {
            return Some(Due::Distance);
        }
        let off_rad = believed.attitude.angle_to(&orientation.matrix());
        if off_rad > self.thresholds.angle_rad || !off_rad.is_finite() {
            return Some(Due::Angle);
        }
        (silent_ns >= last.heartbeat_ns).then_some(Due::Heartbeat)
    }

    /// When an entity that keeps to what receivers believe is due next; `None` before the first [`Self::sent`].
    #[must_use]
    pub fn heartbeat_at_ns(&self) -> Option<i64> {
        let last = self.last.filter(|_| !self.changed)?;
        Some(last.at_ns.saturating_add(last.heartbeat_ns))
    }

    /// What receivers believe of the entity at `now_ns`; `None` before the first [`Self::sent`].
    #[must_use]
    pub fn believed(&self, now_ns: i64) -> Option<Estimate> {
        let last = self.last.as_ref()?;
        Some(last.motion.after(now_ns.saturating_sub(last.at_ns) as f64 * 1e-9))
    }

    /// Something that dead reckoning does not see has changed: the next PDU is due at once.
    pub fn change(&mut self) {
        self.changed = true;
    }

    /// Notes that this state was sent with the timestamp `now_ns`.
    pub fn sent(&mut self, now_ns: i64, state: &crate::EntityState<'_>) {
        let heartbeat_ns = self.heartbeat_ns(state.entity_id);
        self.last = Some(Sent { at_ns: now_ns, heartbeat_ns, motion: state.into() });
        self.changed = false;
        self.count += 1;
    }

    /// The heartbeat after the PDU number `count` of this entity: the same in every run.
    fn heartbeat_ns(&self, id: EntityId) -> i64 {
        let key = u64::from(id.site) << 48
            | u64::from(id.application) << 32
            | u64::from(id.entity) << 16
            | self.count & 0xffff;
        let share = (mixed(key) >> 11) as f64 / (1_u64 << 53) as f64;
        let full = self.thresholds.heartbeat_ns;
        full - (full as f64 * self.thresholds.jitter.clamp(0.0, 1.0) * share) as i64
    }
}

/// A well-mixed function of its argument. Source: SplitMix64, G. L. Steele et al., OOPSLA 2014.
fn mixed(key: u64) -> u64 {
    let mut z = key.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

/// Silence after which an entity is taken as gone: 2.4 heartbeats (IEEE 1278.1-2012, annex B).
#[must_use]
pub fn timeout_ns(heartbeat_ns: i64) -> i64 {
    heartbeat_ns.saturating_mul(12) / 5
}

/// True if an entity that was last heard at `heard_ns` is gone at `now_ns`.
#[must_use]
pub fn is_gone(heard_ns: i64, now_ns: i64, timeout_ns: i64) -> bool {
    now_ns.saturating_sub(heard_ns) > timeout_ns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EntityState;
    use crate::enumerations::DeadReckoningAlgorithm;
    use crate::records::Vector32;
    use geodesy::Quaternion;

    const STEP_NS: i64 = 50_000_000;

    fn state() -> EntityState<'static> {
        EntityState {
            entity_id: EntityId::new(1, 2, 3),
            dead_reckoning_algorithm: DeadReckoningAlgorithm::FPW,
            linear_velocity_mps: Vector32 { x: 10.0, y: 0.0, z: 0.0 },
            location: Ecef { x_m: 6_378_137.0, y_m: 0.0, z_m: 0.0 }.into(),
            ..EntityState::default()
        }
    }

    #[test]
    fn distance_is_true_distance() {
        let mut publisher = Publisher::new(Thresholds { distance_m: 0.1, ..Default::default() });
        let sent = state();
        publisher.sent(0, &sent);
        let truth = |off: [f64; 3]| Ecef::from(sent.location).plus([10.0, 0.0, 0.0]).plus(off);
        let due = |off| publisher.due(1_000_000_000, truth(off), Euler::default());
        assert_eq!(due([0.0; 3]), None);
        // Each axis below 0.1 m, the distance above.
        assert_eq!(due([0.07, 0.0, 0.0]), None);
        assert_eq!(due([0.07, 0.07, 0.03]), Some(Due::Distance));
        assert_eq!(due([f64::NAN, 0.0, 0.0]), Some(Due::Distance));
    }

    #[test]
    fn angle_is_true_angle_also_near_gimbal_lock() {
        let mut sent = state();
        let nose_up = Euler { psi_rad: 0.3, theta_rad: 1.57, phi_rad: 0.2 };
        sent.orientation = nose_up.into();
        let as_sent = Euler::from(sent.orientation);
        let mut publisher = Publisher::new(Thresholds { angle_rad: 0.01, ..Default::default() });
        publisher.sent(0, &sent);
        let here = sent.location.into();
        // Psi and phi swing by a radian, the orientation hardly at all.
        let same = Euler { psi_rad: 1.3, phi_rad: 1.2, ..nose_up };
        assert_eq!(publisher.due(0, here, same), None);
        let turned =
            Quaternion::from_rotation_vector([0.0, 0.011, 0.0]).times(as_sent.quaternion());
        assert_eq!(publisher.due(0, here, turned.euler()), Some(Due::Angle));
        let turned =
            Quaternion::from_rotation_vector([0.0, 0.009, 0.0]).times(as_sent.quaternion());
        assert_eq!(publisher.due(0, here, turned.euler()), None);
    }

    #[test]
    fn heartbeats_spread_and_come_in_time() {
        let mut first_beats = Vec::new();
        for entity in 0..200 {
            let mut sent = state();
            sent.entity_id.entity = entity;
            sent.linear_velocity_mps = Vector32::default();
            let mut publisher = Publisher::new(Thresholds::default());
            let here = sent.location.into();
            publisher.sent(0, &sent);
            let mut last_ns = 0;
            for frame in 1..2000 {
                let now_ns = frame * STEP_NS;
                if let Some(due) = publisher.due(now_ns, here, Euler::default()) {
                    assert_eq!(due, Due::Heartbeat);
                    let silent_s = (now_ns - last_ns) as f64 * 1e-9;
                    assert!((4.5..=5.05).contains(&silent_s), "{silent_s}");
                    if last_ns == 0 {
                        first_beats.push(now_ns);
                    }
                    last_ns = now_ns;
                    publisher.sent(now_ns, &sent);
                }
            }
            assert!(last_ns > 94_000_000_000);
        }
        first_beats.sort_unstable();
        let most = first_beats.chunk_by(|a, b| a == b).map(<[i64]>::len).max();
        assert!(most < Some(50), "200 entities over 10 frames, {most:?} in one");
    }

    #[test]
    fn other_changes_are_sent_once() {
        let mut publisher = Publisher::new(Thresholds::default());
        let sent = state();
        let here = sent.location.into();
        assert_eq!(publisher.due(0, here, Euler::default()), Some(Due::First));
        publisher.sent(0, &sent);
        publisher.change();
        assert_eq!(publisher.due(0, here, Euler::default()), Some(Due::Changed));
        publisher.sent(0, &sent);
        assert_eq!(publisher.due(0, here, Euler::default()), None);
    }

    #[test]
    fn silence_ends_an_entity() {
        assert_eq!(timeout_ns(5_000_000_000), 12_000_000_000);
        assert!(!is_gone(0, 12_000_000_000, 12_000_000_000));
        assert!(is_gone(0, 12_000_000_001, 12_000_000_000));
        assert!(!is_gone(i64::MIN, i64::MIN, 1) && is_gone(i64::MIN, i64::MAX, 1));
    }
}
