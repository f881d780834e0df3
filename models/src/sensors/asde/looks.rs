//! When the beam points at which target.

use super::{Asde, Azimuth, ScanInterval, SimTime, TargetState, Traffic, Truth, wrap_pi};
use crate::effects::radar::{AreaSum, TargetArea};
use crate::sensors::shadow::edge_reach_m;
use std::f64::consts::TAU;

/// One look of the beam at one target.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    /// Which target, by its place in the truth.
    pub(super) index: usize,
    /// Number of the look within the scan, from 0; [`NEXT`] for the first one of the next.
    pub(super) number: u8,
    /// When.
    pub(super) time: SimTime,
    /// The target then.
    pub(super) state: TargetState,
    /// Its azimuth from the radar, rad.
    pub(super) azimuth_rad: f64,
}

/// Number of a look that belongs to the next interval: the beam has begun to paint the target when
/// the interval ends.
pub(super) const NEXT: u8 = u8::MAX;

/// Where the beam points at both ends of an interval.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sweep {
    begin_rad: f64,
    end_rad: f64,
    duration_s: f64,
    /// Whole angle swept, rad.
    swept_rad: f64,
}

impl Sweep {
    /// Whether the beam passes a direction, or comes within `margin_rad` of it.
    pub(super) fn passes(&self, azimuth_rad: f64, margin_rad: f64) -> bool {
        let mut ahead = azimuth_rad + margin_rad - self.begin_rad;
        ahead -= (ahead / TAU).floor() * TAU;
        ahead <= self.swept_rad + 2.0 * margin_rad
    }
}

impl Asde {
    /// Where the beam points at `time`, radians clockwise from north, in [0, 2π).
    pub(super) fn beam_rad(&self, time: SimTime) -> f64 {
        let start = self.parameters.start_azimuth_deg / 360.0;
        let turns = start + time.s() * self.parameters.turns_per_s();
        (turns - turns.floor()) * TAU
    }

    pub(super) fn sweep(&self, interval: &ScanInterval) -> Sweep {
        let duration_s = interval.to.since_s(interval.from);
        Sweep {
            begin_rad: self.beam_rad(interval.from),
            end_rad: self.beam_rad(interval.to),
            duration_s,
            swept_rad: duration_s * self.parameters.turns_per_s() * TAU,
        }
    }

    /// When the beam next passes a fixed direction within the interval.
    pub(super) fn pass(&self, interval: &ScanInterval, azimuth_rad: f64) -> Option<SimTime> {
        let left = TAU - passed_rad(self.beam_rad(interval.from), azimuth_rad);
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
        let mut area = AreaSum::default();
        let sweep = self.sweep(interval);
        let edge_m = edge_reach_m(self.radar.wavelength_m, self.parameters.range_max_m);
        for index in 0..truth.len() {
            let Some((state, azimuth_rad)) = self.looks(interval, &sweep, truth, index, looks)
            else {
                continue;
            };
            let class = truth.class(index);
            let ground_m2 = (state.position_m.xy() - self.site_m).norm_squared();
            area.add(class, ground_m2, state.position_m.z);
            if class.aircraft && state.position_m.z <= class.height_m {
                let ground_m = ground_m2.sqrt();
                let way_m = state.velocity_ms.norm() * sweep.duration_s;
                let reach_m = 0.51 * class.length_m + way_m + edge_m;
                traffic.add(index, azimuth_rad, ground_m, class.height_m, reach_m);
            }
        }
        area.area()
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
        sweep: &Sweep,
        truth: &dyn Truth,
        index: usize,
        out: &mut Vec<Look>,
    ) -> Option<(TargetState, f64)> {
        let (first, last) = (truth.at(index, interval.from), truth.at(index, interval.to));
        let (begin, end) = (first.or(last)?, last.or(first)?);
        let (azimuth_begin, azimuth_end) = (self.azimuth_rad(&begin), self.azimuth_rad(&end));
        let passed_begin = passed_rad(sweep.begin_rad, azimuth_begin);
        let passed_end = passed_rad(sweep.end_rad, azimuth_end);
        let advance = sweep.swept_rad - wrap_pi(azimuth_end - azimuth_begin);
        if advance <= 0.0 {
            return Some((end, azimuth_end));
        }
        let looks = ((advance - (passed_end - passed_begin)) / TAU).round();
        for k in 1..=(looks.clamp(0.0, 250.0) as u8) {
            let fraction = (TAU * f64::from(k) - passed_begin) / advance;
            let within = |time: SimTime| time.clamp(SimTime(interval.from.0 + 1), interval.to);
            let mut time = within(interval.from.plus_s(fraction * sweep.duration_s));
            let Some(mut state) = truth.at(index, time) else { continue };
            // The azimuth moved meanwhile: once more with the target where it is then.
            let mut azimuth_rad = self.azimuth_rad(&state);
            let miss = wrap_pi(azimuth_rad - self.beam_rad(time));
            let correction_s = miss / advance * sweep.duration_s;
            if correction_s.abs() > 1e-6 {
                time = within(time.plus_s(correction_s));
                let Some(moved) = truth.at(index, time) else { continue };
                state = moved;
                azimuth_rad = self.azimuth_rad(&state);
            }
            out.push(Look { index, number: k - 1, time, state, azimuth_rad });
        }
        if passed_end > TAU - self.radar.pattern.azimuth_rad {
            // Within a beamwidth ahead of the beam: its look is in the next interval, its echo in the
            // same cell as those of targets that the beam has just passed.
            let azimuth_rad = azimuth_end;
            out.push(Look { index, number: NEXT, time: interval.to, state: end, azimuth_rad });
        }
        Some((end, azimuth_end))
    }
}

/// How far a beam in [0, 2π) has passed a direction in [−π, π], in [0, 2π).
fn passed_rad(beam_rad: f64, azimuth_rad: f64) -> f64 {
    let mut passed = beam_rad - azimuth_rad;
    if passed < 0.0 {
        passed += TAU;
    }
    if passed >= TAU { passed - TAU } else { passed }
}
