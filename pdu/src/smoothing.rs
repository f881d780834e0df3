//! Smooth display of entities whose states come in jumps.

use crate::dead_reckoning::{Estimate, Motion};
use geodesy::{Ecef, Euler, Quaternion};

/// Shows one entity without jumps: after each new state the displayed place and orientation glide to
/// the dead-reckoned ones within a time, and the displayed place never moves against the entity's
/// velocity; it rather waits.
///
/// Times are whole nanoseconds, in the order of calls. Corrections longer than `snap_m` are not
/// smoothed: the entity was moved on purpose.
#[derive(Clone, Debug)]
pub struct Smoother {
    glide_ns: i64,
    snap_m: f64,
    state: Option<State>,
}

#[derive(Clone, Copy, Debug)]
struct State {
    motion: Motion,
    motion_at_ns: i64,
    /// When the present correction began, and what it has to take away.
    glide_from_ns: i64,
    offset_m: [f64; 3],
    turn: Quaternion,
    /// What was shown last.
    shown_at_ns: i64,
    shown: Ecef,
}

/// What to display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// Place.
    pub location: Ecef,
    /// Orientation.
    pub orientation: Euler,
}

impl Smoother {
    /// Corrections take `glide_ns`; those longer than `snap_m` metres are made at once.
    #[must_use]
    pub fn new(glide_ns: i64, snap_m: f64) -> Self {
        Self { glide_ns, snap_m, state: None }
    }

    /// A new state of the entity, valid at `valid_ns`, arrives at `now_ns`.
    pub fn receive(&mut self, now_ns: i64, motion: Motion, valid_ns: i64) {
        let target = after(&motion, valid_ns, now_ns);
        let snapped = State {
            motion,
            motion_at_ns: valid_ns,
            glide_from_ns: now_ns,
            offset_m: [0.0; 3],
            turn: Quaternion::IDENTITY,
            shown_at_ns: now_ns,
            shown: target.location,
        };
        let Some(shown) = self.show(now_ns) else {
            self.state = Some(snapped);
            return;
        };
        let offset_m = shown.location.minus(target.location);
        let turn = shown
            .orientation
            .quaternion()
            .times(target.attitude.quaternion().conjugate())
            .normalised();
        // Also false for NaN: what cannot be compared is shown as it is.
        let smooth = geodesy::length(offset_m) <= self.snap_m;
        self.state = Some(if smooth {
            State { offset_m, turn, shown: shown.location, ..snapped }
        } else {
            snapped
        });
    }

    /// What to display at `now_ns`; `None` before the first state.
    pub fn show(&mut self, now_ns: i64) -> Option<Shown> {
        let glide_ns = self.glide_ns;
        let state = self.state.as_mut()?;
        let now_ns = now_ns.max(state.shown_at_ns);
        let target = after(&state.motion, state.motion_at_ns, now_ns);
        let since_ns = (now_ns - state.glide_from_ns) as f64;
        let share = if glide_ns > 0 { (since_ns / glide_ns as f64).clamp(0.0, 1.0) } else { 1.0 };
        // 1 at the start, 0 at the end, without a step in speed at either.
        let left = 1.0 - share * share * (3.0 - 2.0 * share);
        let mut location = target.location.plus(state.offset_m.map(|d| left * d));
        let speed = geodesy::length(target.velocity_mps);
        if speed > 0.0 && speed.is_finite() {
            let along = target.velocity_mps.map(|v| v / speed);
            let step = location.minus(state.shown);
            let forward_m = step[0] * along[0] + step[1] * along[1] + step[2] * along[2];
            if forward_m < 0.0 {
                location = location.plus(along.map(|a| -forward_m * a));
            }
        }
        let rest = Quaternion::IDENTITY.slerp(state.turn, left);
        let attitude = rest.times(target.attitude.quaternion());
        state.shown_at_ns = now_ns;
        state.shown = location;
        Some(Shown { location, orientation: attitude.euler() })
    }
}

fn after(motion: &Motion, from_ns: i64, to_ns: i64) -> Estimate {
    motion.after(to_ns.saturating_sub(from_ns) as f64 * 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::enumerations::DeadReckoningAlgorithm;
    use proptest::prelude::*;

    const FRAME_NS: i64 = 16_666_667;

    fn going(x_m: f64, v: f64) -> Motion {
        Motion {
            algorithm: DeadReckoningAlgorithm::FPW,
            location: Ecef { x_m, y_m: 100.0, z_m: 0.0 },
            velocity_mps: [v, 0.0, 0.0],
            ..Motion::default()
        }
    }

    #[test]
    fn an_overshoot_waits_instead_of_going_back() {
        let mut smoother = Smoother::new(1_000_000_000, 50.0);
        smoother.receive(0, going(0.0, 20.0), 0);
        // It braked: the next state is 8 m behind what was shown.
        let mut last = smoother.show(1_000_000_000).expect("received").location.x_m;
        smoother.receive(1_000_000_000, going(12.0, 2.0), 1_000_000_000);
        for frame in 0..600 {
            let now_ns = 1_000_000_000 + frame * FRAME_NS;
            let x = smoother.show(now_ns).expect("received").location.x_m;
            assert!(x >= last - 1e-12, "frame {frame}: back from {last} to {x}");
            assert!(x - last < 1.0, "frame {frame}: jump from {last} to {x}");
            last = x;
        }
        // In the end it is where it is believed to be.
        let believed = 12.0 + 2.0 * (599 * FRAME_NS) as f64 * 1e-9;
        assert!((last - believed).abs() < 1e-9, "{last} for {believed}");
    }

    #[test]
    fn a_teleport_is_shown_at_once() {
        let mut smoother = Smoother::new(1_000_000_000, 50.0);
        smoother.receive(0, going(0.0, 20.0), 0);
        smoother.receive(1, going(10_000.0, 20.0), 1);
        assert_eq!(smoother.show(1).expect("received").location.x_m, 10_000.0);
    }

    #[test]
    fn a_turn_is_spread_over_the_glide() {
        let mut smoother = Smoother::new(1_000_000_000, 50.0);
        smoother.receive(0, going(0.0, 0.0), 0);
        let turned =
            Motion { orientation: Euler { psi_rad: 1.0, ..Euler::default() }, ..going(0.0, 0.0) };
        smoother.receive(0, turned, 0);
        let psi = |s: &mut Smoother, ns| s.show(ns).expect("received").orientation.psi_rad;
        assert!(psi(&mut smoother, 0).abs() < 1e-12);
        assert!((psi(&mut smoother, 500_000_000) - 0.5).abs() < 1e-12);
        assert!((psi(&mut smoother, 1_000_000_000) - 1.0).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn never_backwards_and_always_there_in_the_end(
            states in prop::collection::vec((0.1..3.0f64, -20.0..20.0f64, 0.0..25.0f64), 1..8),
        ) {
            let mut smoother = Smoother::new(1_000_000_000, 1e3);
            let (mut now_ns, mut x, mut motion) = (0, 0.0, going(0.0, 10.0));
            smoother.receive(0, motion, 0);
            let mut last = f64::NEG_INFINITY;
            let mut valid_ns = 0;
            for (wait_s, off_m, v) in states {
                let until_ns = now_ns + (wait_s * 1e9) as i64;
                while now_ns < until_ns {
                    let shown = smoother.show(now_ns).expect("received").location;
                    prop_assert!(shown.x_m >= last - 1e-9, "{} after {}", shown.x_m, last);
                    prop_assert!((shown.y_m - 100.0).abs() < 1e-9);
                    last = shown.x_m;
                    now_ns += FRAME_NS;
                }
                x += wait_s * motion.velocity_mps[0] + off_m;
                motion = going(x, v + 0.01);
                valid_ns = now_ns;
                smoother.receive(now_ns, motion, valid_ns);
            }
            let end_ns = now_ns + 40_000_000_000_000;
            let believed = motion.after((end_ns - valid_ns) as f64 * 1e-9).location.x_m;
            let shown = smoother.show(end_ns).expect("received").location.x_m;
            prop_assert!((shown - believed).abs() < 1e-6);
        }
    }
}
