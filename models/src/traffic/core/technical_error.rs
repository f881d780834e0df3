//! Flight technical error: how movers lie beside the line that they steer along.
//!
//! Source: traffic.md 2.2 and 2.6. What moves along the way knows nothing of it: pieces, clearances and the plan are of the line, and
//! what is published lies beside it.

use super::{Core, Flight, Phase};
use crate::draw::{DrawKey, Purpose, normal_pair};
use crate::traffic::tractrix::drawn_slip_rad;
use std::sync::Arc;

/// Wander across a taxiway of aircraft and vehicles, m, and its time constant, s of driving.
const WANDER_M: [f64; 2] = [0.5, 0.3];
const WANDER_S: f64 = 20.0;
/// A new aim so often, s of driving.
const AIM_S: f64 = 1.0;
/// Length of the body by which it is told what lies beside a bending line, m (assumed).
pub(super) const BODY_M: f64 = 15.0;
/// Its aim moves within this, s (assumed).
const AIMS_S: f64 = 2.0;
/// Steers to it within this, s, and within this way at least, m (assumed).
const STEERS_S: f64 = 3.0;
const STEERS_M: f64 = 8.0;
/// What that leaves of the deviation of the draws: of a process of first order behind lags of 2, 3 and 3 s.
const KEPT: f64 = 0.8904;
/// Keeps to the line for so long before the end of its way, m: stands and line-ups are met (assumed).
const MEETS_M: f64 = 180.0;
/// No draw is larger than this, standard deviations: margins of pieces are 3 m and more.
const MOST: f64 = 3.0;

/// Error of an approach at the threshold, m, and how it grows with the distance to it; that of its height, m.
const LATERAL_M: f64 = 15.0;
const LATERAL_PER_M: f64 = 0.004;
const VERTICAL_M: f64 = 10.0;
/// Distance constant of its draws, and between two of them, m: smoothed by the cubics between them it is 2 km.
const ALONG_M: f64 = 1300.0;
const KNOT_M: f64 = 1000.0;
/// What the cubics leave of the deviation: of the variance 0.718 at draws, 0.700 between them.
const SMOOTHED: f64 = 0.842;
/// It is flown out over the last mile: 15 m beside the middle a runway of 45 m ends for one landing in eight (assumed).
const CLOSES_M: f64 = crate::traffic::runway_roll::NAUTICAL_MILE_M;
/// Draws of wander and of approaches are counted from here, by second of driving and by attempt.
const WANDER_DRAWS: u64 = 1 << 40;
const APPROACH_DRAWS: u64 = 1 << 41;

/// Wander of somebody who taxies: where it is beside its line, and what it aims at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Wander {
    /// To the right of the line, m; how that changes along it, and how that does, 1/m.
    pub(super) aside_m: f64,
    pub(super) slope: f64,
    pub(super) bend_per_m: f64,
    /// Where that points, behind the direction of the line: that of a long body drawn along it, rad, which turns softly at bends.
    pub(super) behind_rad: f64,
    /// Drawn last, in standard deviations; where it aims, m; driven since the last draw, s; draws so far.
    drawn: f64,
    aim_m: f64,
    since_s: f64,
    draws: u64,
}

impl Wander {
    /// On another line: beside nothing, and with draws that no line before it had.
    pub(super) fn anew(self) -> Self {
        Self { draws: self.draws, ..Self::default() }
    }

    /// Its line bends on, over `ds`, m, by its direction so far on.
    pub(super) fn bends(&mut self, ds: f64, heading_rad: impl Fn(f64) -> f64) {
        self.behind_rad = drawn_slip_rad(self.behind_rad, ds, BODY_M, heading_rad);
    }

    /// What its next step depends on.
    pub(super) fn bits(&self) -> [f64; 4] {
        [self.aside_m, self.slope, self.behind_rad, self.aim_m]
    }

    /// Drives on by `ds`, m, at `v` m/s; `aims`: by so much it wanders, m.
    fn drives(&mut self, (ds, v): (f64, f64), dt: f64, aims_m: f64, normal: impl Fn(u64) -> f64) {
        self.since_s += dt;
        if self.since_s >= AIM_S {
            self.since_s -= AIM_S;
            self.draws += 1;
            let keeps = libm::exp(-AIM_S / WANDER_S);
            let drives = (-libm::expm1(-2.0 * AIM_S / WANDER_S)).sqrt();
            self.drawn = (keeps * self.drawn + drives * normal(self.draws)).clamp(-MOST, MOST);
        }
        self.aim_m += (aims_m / KEPT * self.drawn - self.aim_m) * -libm::expm1(-dt / AIMS_S);
        // Critically damped, in steps along the way: who stands does not move sideways.
        let within_m = (STEERS_S * v).max(STEERS_M);
        let off_m = self.aim_m - self.aside_m;
        self.bend_per_m = (off_m / within_m - 2.0 * self.slope) / within_m;
        self.slope += self.bend_per_m * ds;
        self.aside_m += self.slope * ds;
    }
}

/// Errors of an approach at equal distances from the threshold on, in standard deviations: to the right and up.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Approach(Arc<[(f64, f64)]>);

/// To the right and up: m, m/s and m/s².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Off {
    pub(super) aside: [f64; 3],
    pub(super) above: [f64; 3],
}

impl Approach {
    /// Of somebody who enters the final so far out, m.
    fn drawn(out_m: f64, mut normals: impl FnMut() -> (f64, f64)) -> Self {
        let knots = (out_m / KNOT_M).max(0.0) as usize + 5;
        let keeps = libm::exp(-KNOT_M / ALONG_M);
        let drives = (-libm::expm1(-2.0 * KNOT_M / ALONG_M)).sqrt();
        let mut at = normals();
        let mut outer: Vec<(f64, f64)> = Vec::with_capacity(knots);
        for _ in 0..knots {
            outer.push((at.0.clamp(-MOST, MOST), at.1.clamp(-MOST, MOST)));
            let (aside, above) = normals();
            at = (keeps * at.0 + drives * aside, keeps * at.1 + drives * above);
        }
        outer.reverse();
        Self(outer.into())
    }

    /// So far from the threshold, m, at a speed, m/s: nothing behind it, and for those who have none.
    pub(super) fn at(&self, out_m: f64, v: f64) -> Off {
        if self.0.is_empty() || out_m <= 0.0 {
            return Off::default();
        }
        let of = |axis: fn(&(f64, f64)) -> f64, near_m: f64, per_m: f64| {
            let [x, dx, ddx] = self.value(out_m, axis);
            let z = (out_m / CLOSES_M).clamp(0.0, 1.0);
            let open = z * z * z * (10.0 - z * (15.0 - 6.0 * z));
            let d_open = 30.0 * z * z * (1.0 - z) * (1.0 - z) / CLOSES_M;
            let dd_open = 60.0 * z * (1.0 - z) * (1.0 - 2.0 * z) / (CLOSES_M * CLOSES_M);
            let sigma_m = near_m + per_m * out_m;
            // The product of both, and its derivatives.
            let (y, dy) = (sigma_m * open, per_m * open + sigma_m * d_open);
            let ddy = 2.0 * per_m * d_open + sigma_m * dd_open;
            let slope = dy * x + y * dx;
            [y * x, -slope * v, (ddy * x + 2.0 * dy * dx + y * ddx) * v * v]
        };
        Off { aside: of(|x| x.0, LATERAL_M, LATERAL_PER_M), above: of(|x| x.1, VERTICAL_M, 0.0) }
    }

    /// Between the draws by uniform cubic B-splines, so that nobody is thrown about: value, its change by metre, and that of it.
    fn value(&self, out_m: f64, axis: fn(&(f64, f64)) -> f64) -> [f64; 3] {
        let last = self.0.len() - 4;
        let place = (out_m / KNOT_M).clamp(0.0, (last + 1) as f64);
        let k = (place as usize).min(last);
        let t = place - k as f64;
        let [a, b, c, d] = [k, k + 1, k + 2, k + 3].map(|i| axis(&self.0[i]) / SMOOTHED);
        let (first, second, third) = (c - a, a - 2.0 * b + c, d - a + 3.0 * (b - c));
        let value = (a + 4.0 * b + c + t * (3.0 * first + t * (3.0 * second + t * third))) / 6.0;
        let change = (first + t * (2.0 * second + t * third)) / (2.0 * KNOT_M);
        [value, change, (second + t * third) / (KNOT_M * KNOT_M)]
    }
}

impl Core {
    /// A mover has driven on by `ds`, m.
    pub(super) fn wanders(&mut self, m: usize, ds: f64) {
        let aircraft = self.flights[m].size.aircraft;
        let key = DrawKey { run_seed: self.seed, sensor: 0, entity: self.flights[m].key, scan: 0 };
        let mover = &mut self.movers[m];
        let free = mover.phase == Phase::Taxiing && mover.way.stop_m - mover.s > MEETS_M;
        let aims_m = if free { WANDER_M[usize::from(!aircraft)] } else { 0.0 };
        let normal = |draw: u64| {
            let mut rng = DrawKey { scan: WANDER_DRAWS + draw, ..key }.rng(Purpose::Mover);
            normal_pair(&mut rng).0
        };
        mover.wander.drives((ds, mover.v), self.step_s, aims_m, normal);
    }

    /// Draws how somebody on final flies it.
    pub(super) fn draw_approach(&mut self, m: usize, f: &Flight, out_m: f64) {
        let attempt = u64::from(self.movers[m].measures.go_arounds);
        let scan = APPROACH_DRAWS + attempt;
        let key = DrawKey { run_seed: self.seed, sensor: 0, entity: f.key, scan };
        let mut rng = key.rng(Purpose::Mover);
        self.movers[m].approach = Approach::drawn(out_m, || normal_pair(&mut rng));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::uniform;

    fn normals(key: u64) -> impl FnMut() -> (f64, f64) {
        let key = DrawKey { run_seed: 7, sensor: 0, entity: key, scan: 0 };
        let mut rng = key.rng(Purpose::Mover);
        move || normal_pair(&mut rng)
    }

    fn deviation(of: impl Iterator<Item = f64>) -> f64 {
        let (mut squares, mut count) = (0.0, 0.0);
        of.for_each(|x| {
            squares += x * x;
            count += 1.0;
        });
        (squares / count).sqrt()
    }

    /// Half a metre for aircraft at any taxi speed, with the time constant that is stated.
    #[test]
    fn who_taxies_wanders_as_far_and_as_slowly_as_stated() {
        for v in [4.0, 8.0, 15.0] {
            let (dt, mut wander, mut seen) = (0.05, Wander::default(), Vec::new());
            for k in 0..4_000_000_u64 {
                let normal = |draw: u64| normals(draw + 1_000_000 * v as u64)().0;
                wander.drives((v * dt, v), dt, 0.5, normal);
                if k % 20 == 0 {
                    seen.push(wander.aside_m);
                }
            }
            let sigma = deviation(seen.iter().copied());
            assert!((sigma - 0.5).abs() < 0.02, "{sigma} at {v} m/s");
            let later = |lag: usize| {
                let pairs = seen.iter().zip(&seen[lag..]);
                pairs.map(|(a, b)| a * b).sum::<f64>() / (seen.len() - lag) as f64 / sigma / sigma
            };
            assert!((later(40) - 0.16).abs() < 0.04, "{} after 40 s", later(40));
            assert!(seen.iter().all(|x| x.abs() < 3.0 * 0.5 / KEPT), "margins are 3 m");
        }
    }

    /// It moves beside its line only while it drives along it, and is back on it where that is wanted.
    #[test]
    fn who_stands_does_not_slide_and_who_comes_to_his_stand_meets_it() {
        let mut wander = Wander::default();
        let normal = |draw: u64| normals(draw)().0;
        (0..4000).for_each(|_| wander.drives((0.25, 5.0), 0.05, 0.5, normal));
        let before = wander.aside_m;
        assert!(before.abs() > 0.05);
        (0..400).for_each(|_| wander.drives((0.0, 0.0), 0.05, 0.5, normal));
        assert_eq!(wander.aside_m, before);
        (0..720).for_each(|_| wander.drives((0.25, 5.0), 0.05, 0.0, normal));
        assert!(wander.aside_m.abs() < 0.01 && wander.slope.abs() < 1e-3, "{wander:?}");
    }

    /// A vehicle drives many times in a run, and not beside its line as it did the time before.
    #[test]
    fn no_drive_wanders_as_the_one_before() {
        let normal = |draw: u64| normals(draw)().0;
        let drive = |mut wander: Wander| {
            let mut seen = Vec::new();
            for _ in 0..2000 {
                wander.drives((0.4, 8.0), 0.05, 0.3, normal);
                seen.push(wander.aside_m);
            }
            (wander, seen)
        };
        let (wander, first) = drive(Wander::default());
        let (_, second) = drive(wander.anew());
        assert_eq!(wander.anew().aside_m, 0.0);
        let most = first.iter().zip(&second).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(most > 0.05, "{most} m apart");
    }

    /// The funnel of traffic.md 2.6, by its distances; its correlation; nothing over the threshold.
    #[test]
    fn approaches_lie_off_their_path_as_far_as_stated() {
        let drawn: Vec<Approach> =
            (0..4000).map(|k| Approach::drawn(18_520.0, normals(k))).collect();
        let at = |out_m: f64| drawn.iter().map(move |a| a.at(out_m, 70.0));
        for (out_m, within) in [(2000.0, 0.04), (7250.0, 0.04), (10_500.0, 0.04), (18_400.0, 0.04)]
        {
            let aside = deviation(at(out_m).map(|off| off.aside[0])) / (15.0 + 0.004 * out_m);
            let above = deviation(at(out_m).map(|off| off.above[0])) / 10.0;
            assert!((aside - 1.0).abs() < within, "{out_m} m: {aside} aside");
            assert!((above - 1.0).abs() < within, "{out_m} m: {above} above");
        }
        let both = at(4000.0).zip(at(6000.0));
        let together: f64 = both.map(|(a, b)| a.above[0] * b.above[0]).sum::<f64>() / 4000.0;
        assert!((together / 100.0 - 0.368).abs() < 0.05, "{together}");
        assert!(at(0.0).chain(at(-300.0)).all(|off| off == Off::default()));
        assert!(at(1.0).all(|off| off.aside[0].abs() < 1e-3 && off.above[0].abs() < 1e-3));
    }

    /// Rates and accelerations are those of the places, and nobody is thrown about.
    #[test]
    fn an_approach_moves_as_it_says() {
        let dt = 0.01;
        for k in 0..200 {
            let approach = Approach::drawn(18_520.0, normals(k));
            let key = DrawKey { run_seed: k, sensor: 0, entity: 0, scan: 0 };
            let mut rng = key.rng(Purpose::Study);
            for _ in 0..50 {
                let (out_m, v) = (18_000.0 * uniform(&mut rng) + 5.0, 75.0);
                let [before, now, after] = [-dt, 0.0, dt].map(|t| approach.at(out_m - v * t, v));
                for (x, most) in [(|o: &Off| o.aside, 20.0), (|o: &Off| o.above, 4.0)]
                    as [(fn(&Off) -> [f64; 3], f64); 2]
                {
                    let rate = (x(&after)[0] - x(&before)[0]) / (2.0 * dt);
                    assert!((rate - x(&now)[1]).abs() < 1e-3, "{rate} at {out_m}");
                    let change = (x(&after)[1] - x(&before)[1]) / (2.0 * dt);
                    assert!((change - x(&now)[2]).abs() < 0.02, "{change} at {out_m}");
                    assert!(rate.abs() < most && change.abs() < 3.0, "{rate}, {change}");
                }
            }
        }
    }
}
