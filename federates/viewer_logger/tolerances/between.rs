//! The truth of the scans between two of them: a cubic through both states.

use super::{MOVING_MPS, Work};
use crate::runtime::messages::TruthMessage;
use models::frames::{Vector3, wrap_pi};
use models::plot::Callsign;
use models::sensors::{TargetClass, TargetState, Truth};
use models::time::SimTime;
use scenarios::Scene;
use std::collections::BTreeMap;

/// What stands where a type is unknown, else the first of the scene's.
const TYPE: &str = "A320";

/// The entities of a scan between its two ends.
pub(super) struct Between<'a> {
    at: SimTime,
    step_s: f64,
    pub(super) targets: Vec<Target<'a>>,
}

/// One entity at the end of the scan, and at its begin where it was there.
pub(super) struct Target<'a> {
    pub(super) key: u64,
    now: &'a TruthMessage,
    before: Option<&'a TruthMessage>,
    class: &'a TargetClass,
}

impl<'a> Between<'a> {
    /// Of one scan.
    pub(super) fn of(scene: &'a Scene, work: &'a Work, scan: SimTime) -> Self {
        let types = &scene.traffic.types;
        let usual = types.get(TYPE).or_else(|| types.get(types.designators().next()?));
        // A scan that was lost between them is none to draw a curve over.
        let before = work.before.as_ref().filter(|b| work.to.0 - b.0.0 == scan.0);
        let old: BTreeMap<u64, &TruthMessage> =
            before.iter().flat_map(|b| &b.1).map(|t| (t.key(), t)).collect();
        let mut targets: Vec<_> = work
            .truth
            .iter()
            .filter_map(|now| {
                let class = &types.get(&now.type_designator).or(usual)?.class;
                let key = now.key();
                Some(Target { key, now, before: old.get(&key).copied(), class })
            })
            .collect();
        targets.sort_by_key(|t| t.key);
        targets.dedup_by_key(|t| t.key);
        Self { at: work.to, step_s: scan.s(), targets }
    }

    /// Whether the target moves.
    pub(super) fn moves(&self, key: u64) -> bool {
        let found = self.targets.binary_search_by_key(&key, |t| t.key);
        let speed = |t: &Target<'_>| Vector3::from(t.now.velocity_mps).xy().norm();
        found.is_ok_and(|at| speed(&self.targets[at]) >= MOVING_MPS)
    }
}

impl Truth for Between<'_> {
    fn len(&self) -> usize {
        self.targets.len()
    }
    fn key(&self, index: usize) -> u64 {
        self.targets[index].key
    }
    fn class(&self, index: usize) -> &TargetClass {
        self.targets[index].class
    }
    fn callsign(&self, index: usize) -> Callsign {
        Callsign::new(&self.targets[index].now.callsign)
    }
    fn address(&self, _: usize) -> Option<u32> {
        None
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        let Target { now, before, .. } = &self.targets[index];
        let (p1, v1) = (now.position_m, Vector3::from(now.velocity_mps));
        let since_s = time.since_s(self.at);
        let Some(before) = before.filter(|_| since_s > -self.step_s && since_s < 0.0) else {
            let position_m = p1 + v1 * since_s;
            return Some(TargetState {
                position_m,
                velocity_mps: v1,
                heading_rad: now.heading_rad,
            });
        };
        // Hermite's cubic through both states.
        let (h, u) = (self.step_s, 1.0 + since_s / self.step_s);
        let (p0, v0) = (before.position_m.coords, Vector3::from(before.velocity_mps));
        let (u2, u3) = (u * u, u * u * u);
        let position_m = p0 * (2.0 * u3 - 3.0 * u2 + 1.0)
            + v0 * (h * (u3 - 2.0 * u2 + u))
            + p1.coords * (3.0 * u2 - 2.0 * u3)
            + v1 * (h * (u3 - u2));
        let turned_rad = wrap_pi(now.heading_rad - before.heading_rad);
        Some(TargetState {
            position_m: position_m.into(),
            velocity_mps: v0 + (v1 - v0) * u,
            heading_rad: before.heading_rad + turned_rad * u,
        })
    }
}
