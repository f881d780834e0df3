//! Progress along a path by time: nearest to the positions within the limits of the type.

use super::super::fit::{Bound, Control, Datum, Fit};
use super::super::limits::AIR_LATERAL_MS2;
use super::super::spline::Spline;
use super::path::{PathTable, TABLE_STEP_M};
use super::phases::Roll;
use super::reject::Fix;
use super::report::Held;
use super::{Work, motion};

/// Spectral density of the change of acceleration along the path, m²/s⁵.
const JERK_DENSITY: f64 = 0.05;
/// Share of the limits that the bounds use: derivatives of path and progress multiply.
const SHARE: f64 = 0.99;

/// A leg with the positions that bear on its progress.
pub(super) struct Seen<'a> {
    /// First and last second.
    pub(super) span: (usize, usize),
    pub(super) path: &'a Spline<2>,
    pub(super) table: &'a PathTable,
    /// Places of the rough track, second by second.
    pub(super) places: &'a [f64],
    /// Positions with their places and distances across.
    pub(super) fixes: &'a [(Fix, f64, f64)],
    /// Place of a leg that begins at rest where the one before it ended.
    pub(super) begins_at: Option<f64>,
}

/// Limits during one second.
#[derive(Clone, Copy)]
pub(super) struct Allowed {
    pub(super) speed: (f64, Held),
    pub(super) acceleration: (f64, Held),
    pub(super) braking: (f64, Held),
    pub(super) lateral_ms2: f64,
    pub(super) flies: bool,
}

/// Factors of the bounds of one second, for what the bounds on the controls do not see.
#[derive(Clone, Copy)]
struct Tight {
    speed: f64,
    acceleration: f64,
}

impl Work<'_> {
    /// Controls of the progress, second by second, within the limits.
    pub(super) fn progress(&self, leg: &Seen<'_>) -> Option<Vec<[f64; 1]>> {
        const ROUNDS: usize = 24;
        // From here on bounds are only tightened.
        const LAST_MOVES: usize = 14;
        const SETTLED_M: f64 = 2.0;
        let (from, to) = leg.span;
        let pieces = (to - from).max(1);
        let count = pieces + 3;
        // Controls within a standstill are one variable; before a fixed begin they do not move.
        let mut joined = vec![false; count];
        for stand in self.stands {
            let (a, b) = (stand.from.max(from), stand.to.min(to));
            if b > a + 1 {
                joined[a - from + 1..(b - from + 3).min(count)].fill(true);
            }
        }
        let mut controls = Vec::with_capacity(count);
        let mut next = 0;
        let mut fixed = leg.begins_at;
        for (j, same) in joined.iter().enumerate() {
            if j > 0 && !same && fixed.take().is_none() {
                next += 1;
            }
            controls.push(fixed.map_or(Control::Free(next), |m| Control::Fixed([m])));
        }
        let mut tight = vec![Tight { speed: 1.0, acceleration: 1.0 }; pieces];
        let mut solution: Option<Spline<1>> = None;
        let l = self.limits;
        let fastest = leg.table.fastest(l.lateral_ms2, l.roll_acc_ms2, l.roll_dec_ms2);
        for round in 0..ROUNDS {
            let data = self.data(leg, solution.as_ref());
            let fit = |leans: bool| Fit {
                controls: controls.clone(),
                data: data.clone(),
                roughness: 1.0 / JERK_DENSITY,
                stiffness: Vec::new(),
                bounds: self.bounds(leg, count, &tight, |j| {
                    self.turn_limit(leg, &fastest, solution.as_ref(), leans, j)
                }),
            };
            // Where the turns are too far off for the limits to change with the place, they do not.
            let mut found = fit(round < LAST_MOVES).bounded().or_else(|| fit(false).bounded())?;
            // What stands stands exactly.
            for j in 1..count {
                found[j][0] = found[j][0].max(found[j - 1][0]);
            }
            // Steps that go on swinging are halved.
            if let Some(before) = solution.as_ref().filter(|_| (6..LAST_MOVES).contains(&round)) {
                let pairs = found.iter_mut().zip(before.controls());
                pairs.for_each(|(now, before)| now[0] = 0.5 * (now[0] + before[0]));
            }
            let moved_m = solution.as_ref().map_or(f64::INFINITY, |before| {
                let pairs = before.controls().iter().zip(&found);
                pairs.map(|(a, b)| (a[0] - b[0]).abs()).fold(0.0, f64::max)
            });
            let found = solution.insert(Spline::new(0.0, 1.0, found)?);
            // Only when it stays where it is do bounds of single seconds mean anything.
            let settled = moved_m < SETTLED_M || round >= LAST_MOVES;
            if !settled {
                tight.fill(Tight { speed: 1.0, acceleration: 1.0 });
            }
            if !self.tighten(leg, found, &mut tight) && settled {
                break;
            }
        }
        Some(solution?.controls().to_vec())
    }

    /// Positions along the path, those far from where the solution so far is weighted down.
    fn data(&self, leg: &Seen<'_>, solution: Option<&Spline<1>>) -> Vec<Datum<1>> {
        let from = leg.span.0;
        let datum = |(fix, place, _): &(Fix, f64, f64)| {
            let (error, speed) = match solution {
                Some(spline) => {
                    let jet = spline.at(fix.t - from as f64);
                    (place - jet.value[0], jet.first[0])
                }
                None => {
                    let last = leg.places.len() - 1;
                    let i = ((fix.t as usize).max(from) - from).min(last);
                    (place - leg.places[i], leg.places[(i + 1).min(last)] - leg.places[i])
                }
            };
            let sigma = self.sigma_along_m(fix.t, speed);
            let ratio2 = error * error / (sigma * sigma);
            let weight = 1.0 / (sigma * sigma * (1.0 + 0.25 * ratio2));
            Datum { place: fix.t - from as f64, value: [*place], weight }
        };
        if leg.fixes.is_empty() {
            return vec![Datum { place: 0.0, value: [leg.places[0]], weight: 1.0 }];
        }
        leg.fixes.iter().map(datum).collect()
    }

    /// The run or flight that second `t` of the whole recording belongs to.
    pub(super) fn roll(&self, t: usize) -> Option<&Roll> {
        self.rolls.iter().find(|roll| (roll.from..=roll.to).contains(&t))
    }

    /// Limits during the second after `t` of the whole recording.
    pub(super) fn allowed(&self, t: usize) -> Allowed {
        let l = self.limits;
        let flies = self.air.flies(t);
        let lateral_ms2 = if flies { AIR_LATERAL_MS2 } else { l.lateral_ms2 };
        match self.roll(t) {
            Some(roll) => {
                let speed_mps = if flies { roll.air_mps } else { roll.ground_mps };
                let of = if roll.lands { Held::LandingSpeed } else { Held::TakeoffSpeed };
                Allowed {
                    speed: (speed_mps, of),
                    acceleration: (l.roll_acc_ms2, Held::RunAcceleration),
                    braking: (l.roll_dec_ms2, Held::RunBraking),
                    lateral_ms2,
                    flies,
                }
            }
            None => Allowed {
                speed: (l.taxi_mps, Held::TaxiSpeed),
                acceleration: (l.taxi_acc_ms2, Held::TaxiAcceleration),
                braking: (l.taxi_dec_ms2, Held::TaxiBraking),
                lateral_ms2,
                flies,
            },
        }
    }

    /// Limit of the speed by turns at the first difference `j`: that speed, the place where it holds,
    /// and how it changes with the place (less than the real limit does, on either side).
    fn turn_limit(
        &self,
        leg: &Seen<'_>,
        fastest: &[f64],
        solution: Option<&Spline<1>>,
        leans: bool,
        j: usize,
    ) -> Option<(f64, f64, f64)> {
        const REACH_M: f64 = 60.0;
        let spline = solution?;
        let last = leg.span.1.max(leg.span.0 + 1) - 1;
        if self.air.flies((leg.span.0 + j).min(last)) {
            return None;
        }
        let middle = (j as f64 - 0.5).max(0.0);
        let at_m = spline.at(middle).value[0];
        let limit = |place_m: f64| {
            fastest[((place_m / TABLE_STEP_M).max(0.0) as usize).min(fastest.len() - 1)]
        };
        let here = limit(at_m);
        let behind = (here - limit(at_m - REACH_M)) / REACH_M;
        let ahead = (limit(at_m + REACH_M) - here) / REACH_M;
        let lean = if !leans {
            0.0
        } else if behind > 0.0 && ahead >= 0.0 {
            behind
        } else if ahead < 0.0 && behind <= 0.0 {
            ahead
        } else {
            0.0
        };
        Some((here, at_m, lean))
    }

    fn bounds(
        &self,
        leg: &Seen<'_>,
        count: usize,
        tight: &[Tight],
        turn_limit: impl Fn(usize) -> Option<(f64, f64, f64)>,
    ) -> Vec<Bound<1>> {
        let from = leg.span.0;
        let limits = self.limits;
        let allowed: Vec<Allowed> = (0..tight.len()).map(|i| self.allowed(from + i)).collect();
        let mut bounds = Vec::with_capacity(3 * count);
        for j in 0..count {
            // The difference of order k at j bears on the pieces j − 3 + k to j.
            let borne =
                |k: usize| (j + k).saturating_sub(3).min(tight.len() - 1)..=j.min(tight.len() - 1);
            let least = |k: usize, value: &dyn Fn(usize) -> f64| {
                borne(k).map(value).fold(f64::INFINITY, f64::min)
            };
            if j + 1 < count {
                let fastest = least(1, &|i| allowed[i].speed.0 * tight[i].speed);
                bounds.push(Bound::between(1, j, 0.0, SHARE * fastest.max(0.3)));
                if let Some((most, at_m, lean)) = turn_limit(j) {
                    let most = SHARE * least(1, &|i| tight[i].speed) * most;
                    bounds.push(Bound::leaning(j, most.max(0.3), at_m, lean));
                }
            }
            if j + 2 < count {
                let acc = least(2, &|i| allowed[i].acceleration.0 * tight[i].acceleration);
                let dec = least(2, &|i| allowed[i].braking.0 * tight[i].acceleration);
                bounds.push(Bound::between(2, j, -SHARE * dec, SHARE * acc));
            }
            if j + 3 < count {
                let rolls = borne(3).any(|i| self.roll(from + i).is_some());
                let jerk = if rolls { limits.roll_jerk_ms3 } else { limits.jerk_ms3 };
                bounds.push(Bound::between(3, j, -jerk, jerk));
            }
        }
        bounds
    }

    /// Looks at the motion itself every tenth of a second; true if it is beyond a limit somewhere.
    fn tighten(&self, leg: &Seen<'_>, progress: &Spline<1>, tight: &mut [Tight]) -> bool {
        const TENTHS: usize = 10;
        let mut beyond = false;
        for (i, tight) in tight.iter_mut().enumerate() {
            let allowed = self.allowed(leg.span.0 + i);
            let (mut speed, mut acceleration) = (0.0_f64, 0.0_f64);
            for tenth in 0..=TENTHS {
                let t = i as f64 + tenth as f64 / TENTHS as f64;
                let now = motion(leg.path, &progress.at(t));
                let turn = (now.lateral_ms2 / allowed.lateral_ms2).sqrt();
                speed = speed.max(now.speed_mps / allowed.speed.0).max(turn);
                let limit =
                    if now.along_ms2 > 0.0 { allowed.acceleration.0 } else { allowed.braking.0 };
                acceleration = acceleration.max(now.along_ms2.abs() / limit);
            }
            if speed > 1.0 {
                beyond = true;
                tight.speed *= 0.995 / speed;
            }
            if acceleration > 1.0 {
                beyond = true;
                tight.acceleration *= 0.995 / acceleration;
            }
        }
        beyond
    }
}
