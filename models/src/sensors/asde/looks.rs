//! When the beam points at which target.

use super::{Asde, Azimuth, Point2, ScanInterval, SimTime, TargetState, Traffic, Truth, wrap_pi};
use crate::frames::Point3;
use crate::sensors::radar::shadow::edge_reach_m;
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

/// Where a target is at the end of an interval, or was when last seen in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct End {
    /// Its place.
    pub(super) place_m: Point3<f64>,
    /// Its azimuth from the radar, rad.
    pub(super) azimuth_rad: f64,
    /// Whether it is still there.
    pub(super) there: bool,
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

    /// All times at which the beam passes a fixed direction within the interval.
    pub(super) fn passes(
        &self,
        interval: &ScanInterval,
        azimuth_rad: f64,
    ) -> impl Iterator<Item = SimTime> + use<> {
        let (turn_s, to) = (1.0 / self.parameters.turns_per_s(), interval.to);
        let first = self.pass(interval, azimuth_rad);
        let all = (0..).map_while(move |turn| Some(first?.plus_s(f64::from(turn) * turn_s)));
        all.take_while(move |time| *time <= to)
    }

    pub(super) fn azimuth_rad(&self, state: &TargetState) -> f64 {
        Azimuth::of(state.position_m.xy() - self.site_m).rad()
    }

    /// All looks of the interval by target, where each target is at its end, and the aircraft that may shadow others.
    pub(super) fn find_looks(
        &self,
        interval: &ScanInterval,
        truth: &dyn Truth,
        looks: &mut Vec<Look>,
        ends: &mut Vec<Option<End>>,
        occluding: &mut Occluding,
    ) {
        looks.clear();
        // What stood at the end of the last interval is at the beginning of this one.
        ends.resize(truth.len(), None);
        occluding.clear();
        let sweep = self.sweep(interval);
        let edge_m = edge_reach_m(self.radar.wavelength_m, self.parameters.range_max_m);
        for index in 0..truth.len() {
            let end = self.looks(interval, &sweep, truth, index, ends[index].as_ref(), looks);
            ends[index] = end.map(|(end, ..)| end);
            let Some((End { azimuth_rad, .. }, state)) = end else { continue };
            let class = truth.class(index);
            if class.aircraft && state.position_m.z <= class.height_m {
                let ground_m = (state.position_m.xy() - self.site_m).norm();
                let way_m = state.velocity_mps.norm() * sweep.duration_s;
                let reach_m = 0.51 * class.length_m + way_m + edge_m;
                let top_m = class.height_m;
                occluding.add(Aircraft { index, azimuth_rad, ground_m, top_m, reach_m });
            }
        }
    }

    /// The looks at one target during the interval, in time order, appended to `out`; where it is at the end of the
    /// interval, and its state there.
    ///
    /// The number of looks follows from the beam's angle past the target at both ends of the interval,
    /// and the end of one interval is the beginning of the next: no look is lost or seen twice,
    /// however the target moves across the beam's starting direction. `before` is where it was at the end of another
    /// interval: there it is seen in the same direction.
    pub(super) fn looks(
        &self,
        interval: &ScanInterval,
        sweep: &Sweep,
        truth: &dyn Truth,
        index: usize,
        before: Option<&End>,
        out: &mut Vec<Look>,
    ) -> Option<(End, TargetState)> {
        let (first, last) = (truth.at(index, interval.from), truth.at(index, interval.to));
        let (begin, end) = (first.or(last)?, last.or(first)?);
        let known = |state: &TargetState, end: Option<&End>| {
            end.filter(|end| end.place_m == state.position_m).map(|end| end.azimuth_rad)
        };
        let azimuth_begin = known(&begin, before).unwrap_or_else(|| self.azimuth_rad(&begin));
        let at_begin = End { place_m: begin.position_m, azimuth_rad: azimuth_begin, there: true };
        let azimuth_end = known(&end, Some(&at_begin)).unwrap_or_else(|| self.azimuth_rad(&end));
        let passed_begin = passed_rad(sweep.begin_rad, azimuth_begin);
        let passed_end = passed_rad(sweep.end_rad, azimuth_end);
        let advance = sweep.swept_rad - wrap_pi(azimuth_end - azimuth_begin);
        let there = last.is_some();
        let at_end = End { place_m: end.position_m, azimuth_rad: azimuth_end, there };
        if advance <= 0.0 {
            return Some((at_end, end));
        }
        let looks = ((advance - (passed_end - passed_begin)) / TAU).round();
        for k in 1..=(looks.clamp(0.0, 250.0) as u8) {
            let fraction = (TAU * f64::from(k) - passed_begin) / advance;
            let within = |time: SimTime| time.clamp(SimTime(interval.from.0 + 1), interval.to);
            let mut time = within(interval.from.plus_s(fraction * sweep.duration_s));
            let Some(mut state) = truth.at(index, time) else { continue };
            // The azimuth moved meanwhile: once more with the target where it is then.
            let standing = known(&state, Some(&at_begin));
            let mut azimuth_rad = standing.unwrap_or_else(|| self.azimuth_rad(&state));
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
        if there && passed_end > TAU - self.radar.pattern.azimuth_rad {
            // Within a beamwidth ahead of the beam: its look is in the next interval, its echo in the
            // same cell as those of targets that the beam has just passed.
            let azimuth_rad = azimuth_end;
            out.push(Look { index, number: NEXT, time: interval.to, state: end, azimuth_rad });
        }
        Some((at_end, end))
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

/// An aircraft on the ground, with how far it reaches within a scan.
#[derive(Clone, Copy, Debug)]
struct Aircraft {
    index: usize,
    azimuth_rad: f64,
    ground_m: f64,
    top_m: f64,
    reach_m: f64,
}

/// Aircraft that may shadow others: the nearest by sector, so that most targets need no further look.
#[derive(Clone, Debug)]
pub(super) struct Occluding {
    list: Vec<Aircraft>,
    nearest_m: [f64; OCCLUDED],
}

/// Sectors of the table.
const OCCLUDED: usize = 64;

impl Default for Occluding {
    fn default() -> Self {
        Self { list: Vec::new(), nearest_m: [f64::INFINITY; OCCLUDED] }
    }
}

impl Occluding {
    fn clear(&mut self) {
        self.list.clear();
        self.nearest_m = [f64::INFINITY; OCCLUDED];
    }

    fn add(&mut self, aircraft: Aircraft) {
        let Aircraft { azimuth_rad, ground_m, reach_m, .. } = aircraft;
        self.list.push(aircraft);
        let half = if reach_m < ground_m { libm::asin(reach_m / ground_m) } else { TAU };
        let width = TAU / OCCLUDED as f64;
        let reach = ((half / width).ceil() as usize).min(OCCLUDED / 2);
        let middle = Self::sector(azimuth_rad);
        for i in 0..(2 * reach + 1).min(OCCLUDED) {
            let nearest = &mut self.nearest_m[(middle + OCCLUDED - reach + i) % OCCLUDED];
            *nearest = nearest.min(ground_m - reach_m);
        }
    }

    fn sector(azimuth_rad: f64) -> usize {
        let turn = azimuth_rad / TAU;
        (((turn - turn.floor()) * OCCLUDED as f64) as usize).min(OCCLUDED - 1)
    }

    /// Whether one may stand before the target of a look.
    pub(super) fn may_shadow(&self, look: &Look, site_m: Point2<f64>) -> bool {
        let nearest_m = self.nearest_m[Self::sector(look.azimuth_rad)];
        let others =
            self.list.len() > 1 || self.list.first().is_some_and(|a| a.index != look.index);
        others && nearest_m < (look.state.position_m.xy() - site_m).norm()
    }

    /// All of them, for the scan's own search.
    pub(super) fn fill(&self, traffic: &mut Traffic) {
        for a in &self.list {
            traffic.add(a.index, a.azimuth_rad, a.ground_m, a.top_m, a.reach_m);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Vector3;

    #[test]
    fn a_target_may_be_shadowed_by_another_that_is_nearer_in_its_direction() {
        let look = |index: usize, azimuth_rad: f64, ground_m: f64| {
            let (sin, cos) = libm::sincos(azimuth_rad);
            let state = TargetState {
                position_m: Point3::new(10.0 + ground_m * sin, 20.0 + ground_m * cos, 0.0),
                velocity_mps: Vector3::zeros(),
                heading_rad: 0.0,
            };
            Look { index, number: 0, time: SimTime::ZERO, state, azimuth_rad }
        };
        let site = Point2::new(10.0, 20.0);
        let aircraft = |index, azimuth_rad, ground_m, reach_m| Aircraft {
            index,
            azimuth_rad,
            ground_m,
            top_m: 12.0,
            reach_m,
        };
        let mut occluding = Occluding::default();
        assert!(!occluding.may_shadow(&look(0, 1.0, 5_000.0), site), "nobody is there");
        occluding.add(aircraft(3, 1.0, 1_000.0, 20.0));
        assert!(!occluding.may_shadow(&look(3, 1.0, 1_000.0), site), "itself");
        for (azimuth_rad, ground_m, may) in [
            (1.0, 1_200.0, true),
            (1.0, 990.0, true),
            (1.0, 970.0, false),
            (1.02, 5e3, true),
            (1.5, 5e3, false),
            (-2.0, 5e3, false),
        ] {
            assert_eq!(
                occluding.may_shadow(&look(0, azimuth_rad, ground_m), site),
                may,
                "{azimuth_rad} {ground_m}"
            );
        }
        // Over the radar it is in every direction; across north too.
        occluding.add(aircraft(4, 0.0, 400.0, 60.0));
        assert!(
            occluding.may_shadow(&look(0, -0.1, 500.0), site)
                && occluding.may_shadow(&look(0, 6.2, 500.0), site)
        );
        assert!(!occluding.may_shadow(&look(0, 3.0, 500.0), site));
        occluding.add(aircraft(5, 2.0, 10.0, 30.0));
        assert!((0..60).all(|k| occluding.may_shadow(&look(0, 0.1 * f64::from(k), 1.0), site)));
        occluding.clear();
        assert!(!occluding.may_shadow(&look(0, 1.0, 5_000.0), site));
    }
}
