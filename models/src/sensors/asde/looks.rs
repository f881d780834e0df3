//! When the beam points at which target.

use super::{Asde, Azimuth, ScanInterval, SimTime, TargetState, Traffic, Truth, wrap_pi};
use crate::effects::radar::TargetArea;
use std::f64::consts::TAU;

/// One look of the beam at one target.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    /// Which target, by its place in the truth.
    pub(super) index: usize,
    /// Number of the look within the scan, from 0.
    pub(super) number: u8,
    /// When.
    pub(super) time: SimTime,
    /// The target then.
    pub(super) state: TargetState,
    /// Its azimuth from the radar, rad.
    pub(super) azimuth_rad: f64,
}

impl Asde {
    /// Where the beam points at `time`, radians clockwise from north, in [0, 2π).
    pub(super) fn beam_rad(&self, time: SimTime) -> f64 {
        let start = self.parameters.start_azimuth_deg / 360.0;
        let turns = start + time.s() * self.parameters.turns_per_s();
        (turns - turns.floor()) * TAU
    }

    /// How far the beam has passed a direction, in [0, 2π).
    fn passed_rad(&self, time: SimTime, azimuth_rad: f64) -> f64 {
        let passed = (self.beam_rad(time) - azimuth_rad).rem_euclid(TAU);
        // Rounding may give 2π itself.
        if passed >= TAU { 0.0 } else { passed }
    }

    /// When the beam next passes a fixed direction within the interval.
    pub(super) fn pass(&self, interval: &ScanInterval, azimuth_rad: f64) -> Option<SimTime> {
        let left = TAU - self.passed_rad(interval.from, azimuth_rad);
        let time = interval.from.plus_s(left / (TAU * self.parameters.turns_per_s()));
        (time > interval.from && time <= interval.to).then_some(time)
    }

    pub(super) fn azimuth_rad(&self, state: &TargetState) -> f64 {
        Azimuth::of(state.position_m.xy() - self.site_m).rad()
    }

    /// All looks of the interval by target, the aircraft that may shadow others, and the area of the targets.
    pub(super) fn find_looks(
        &self,
        interval: &ScanInterval,
        truth: &dyn Truth,
        looks: &mut Vec<Look>,
        traffic: &mut Traffic,
    ) -> TargetArea {
        looks.clear();
        traffic.clear();
        let mut area = TargetArea::EMPTY;
        let duration_s = interval.to.since_s(interval.from);
        for index in 0..truth.len() {
            let Some((state, azimuth_rad)) = self.looks(interval, truth, index, looks) else {
                continue;
            };
            let class = truth.class(index);
            let ground_m = (state.position_m.xy() - self.site_m).norm();
            area.add(class, ground_m, state.position_m.z);
            if class.aircraft && state.position_m.z <= class.height_m {
                let reach_m = 0.5 * class.length_m + state.velocity_ms.norm() * duration_s;
                traffic.add(index, azimuth_rad, ground_m, class.height_m, reach_m);
            }
        }
        area.rounded()
    }

    /// The looks at one target during the interval, in time order, appended to `out`; its state and
    /// azimuth at the end of the interval.
    ///
    /// The number of looks follows from the beam's angle past the target at both ends of the interval,
    /// and the end of one interval is the beginning of the next: no look is lost or seen twice,
    /// however the target moves across the beam's starting direction.
    pub(super) fn looks(
        &self,
        interval: &ScanInterval,
        truth: &dyn Truth,
        index: usize,
        out: &mut Vec<Look>,
    ) -> Option<(TargetState, f64)> {
        let (first, last) = (truth.at(index, interval.from), truth.at(index, interval.to));
        let (begin, end) = (first.or(last)?, last.or(first)?);
        let (azimuth_begin, azimuth_end) = (self.azimuth_rad(&begin), self.azimuth_rad(&end));
        let passed_begin = self.passed_rad(interval.from, azimuth_begin);
        let passed_end = self.passed_rad(interval.to, azimuth_end);
        let duration_s = interval.to.since_s(interval.from);
        let advance =
            duration_s * self.parameters.turns_per_s() * TAU - wrap_pi(azimuth_end - azimuth_begin);
        if advance <= 0.0 {
            return Some((end, azimuth_end));
        }
        let looks = ((advance - (passed_end - passed_begin)) / TAU).round();
        for k in 1..=(looks.clamp(0.0, 255.0) as u8) {
            let fraction = (TAU * f64::from(k) - passed_begin) / advance;
            let within = |time: SimTime| time.clamp(SimTime(interval.from.0 + 1), interval.to);
            let mut time = within(interval.from.plus_s(fraction * duration_s));
            let Some(mut state) = truth.at(index, time) else { continue };
            // The azimuth moved meanwhile: once more with the target where it is then.
            let mut azimuth_rad = self.azimuth_rad(&state);
            let miss = wrap_pi(azimuth_rad - self.beam_rad(time));
            let correction_s = miss / advance * duration_s;
            if correction_s.abs() > 1e-6 {
                time = within(time.plus_s(correction_s));
                let Some(moved) = truth.at(index, time) else { continue };
                state = moved;
                azimuth_rad = self.azimuth_rad(&state);
            }
            out.push(Look { index, number: k - 1, time, state, azimuth_rad });
        }
        Some((end, azimuth_end))
    }
}
