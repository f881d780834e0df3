//! Height and the times at which the wheels leave and touch the ground.

use super::super::fit::{Bound, Control, Datum, Fit};
use super::super::limits::Limits;
use super::super::spline::Spline;
use super::reject::{Clean, median};
use super::{Record, Rule, Tally};

/// When it flies, and how high.
pub(super) struct Air {
    /// Off the ground, at whole seconds.
    flying: Vec<bool>,
    /// Time and height over the ground of altitudes that can be true.
    heights: Vec<(f64, f64)>,
    /// Pressure altitude on the ground, m.
    pub(super) offset_m: Option<f64>,
}

impl Air {
    /// Steepest climb and sink, m/s; largest vertical acceleration, m/s².
    const CLIMB_MPS: f64 = 30.0;
    const VERTICAL_MS2: f64 = 2.5;
    /// Height below which the wheels may be on the ground: one step of the altitude code, m.
    const STEP_M: f64 = 7.62;

    /// What speeds and altitudes say; ground flags are only counted where they contradict.
    pub(super) fn seen(
        records: &[Record],
        clean: &Clean,
        limits: &Limits,
        tally: &mut Tally,
    ) -> Self {
        let end = clean.last_s();
        let time = |r: &Record| r.time_ms.map(|ms| ms.saturating_sub(clean.t0_ms) as f64 * 1e-3);
        let within = |t: &f64| (0.0..=end as f64).contains(t);
        let slow = |t: f64| clean.speed(t) < 0.5 * limits.least_air_mps;
        let mut altitudes: Vec<(usize, f64, f64)> = Vec::new();
        let mut on_ground = Vec::new();
        for record in records {
            let (Some(t), Some(altitude_m)) = (time(record).filter(within), record.altitude_m)
            else {
                continue;
            };
            if slow(t) && altitude_m.abs() > 300.0 {
                tally.add(Rule::AltitudeSpike, record.line);
                continue;
            }
            if slow(t) {
                on_ground.push(altitude_m);
            }
            altitudes.push((record.line, t, altitude_m));
        }
        let offset_m = median(on_ground);
        let mut air = Self { flying: vec![false; end + 1], heights: Vec::new(), offset_m };
        if limits.least_air_mps.is_infinite() {
            return air;
        }
        air.heights = flyable(&altitudes, offset_m.unwrap_or(0.0), tally);
        for (i, flying) in air.flying.iter_mut().enumerate() {
            let t = i as f64;
            let speed = clean.speed(t);
            // In the air: fast enough, and above one step of the altitude code around it.
            let near = air.heights.iter().filter(|(ht, _)| (ht - t).abs() <= 4.0);
            let (count, high) = near
                .fold((0, 0), |(n, h), (_, z)| (n + 1, h + usize::from(*z > 1.5 * Self::STEP_M)));
            let above =
                if count == 0 { speed > 1.1 * limits.least_air_mps } else { 2 * high > count };
            *flying = speed >= limits.least_air_mps && above;
        }
        drop_short_runs(&mut air.flying, true, 5);
        drop_short_runs(&mut air.flying, false, 5);
        for record in records {
            let (Some(t), Some(flag)) = (time(record).filter(within), record.on_ground) else {
                continue;
            };
            let i = t as usize;
            let (before, after) = (i.saturating_sub(3), (i + 3).min(end));
            if air.flying[before] == air.flying[after] && flag == air.flying[i] {
                tally.add(Rule::GroundFlag, record.line);
            }
        }
        air
    }

    /// True if it is off the ground during the second after `piece`.
    pub(super) fn flies(&self, piece: usize) -> bool {
        let at = |i: usize| self.flying.get(i).copied().unwrap_or(false);
        at(piece) && at(piece + 1)
    }

    /// Keeps on the ground what is too slow to fly.
    pub(super) fn settle(&mut self, progress: &Spline<1>, limits: &Limits) {
        for (i, flying) in self.flying.iter_mut().enumerate() {
            *flying &= progress.at(i as f64).first[0] >= limits.least_air_mps;
        }
    }

    /// Second of the lift-off.
    pub(super) fn liftoff_s(&self) -> Option<f64> {
        self.switch(false)
    }

    /// Second of the touchdown.
    pub(super) fn touchdown_s(&self) -> Option<f64> {
        self.switch(true)
    }

    fn switch(&self, from: bool) -> Option<f64> {
        let pairs = self.flying.windows(2);
        pairs.into_iter().position(|w| w[0] == from && w[1] != from).map(|i| (i + 1) as f64)
    }

    /// Height by time; `None` if it stays on the ground.
    pub(super) fn height(&self) -> Option<Spline<1>> {
        let pieces = self.flying.len().saturating_sub(1);
        // A control is free if all of its four pieces fly.
        let mut next = 0;
        let mut controls = Vec::with_capacity(pieces + 3);
        for j in 0..pieces + 3 {
            let (low, high) = (j.saturating_sub(3), j.min(pieces.saturating_sub(1)));
            if (low..=high).all(|piece| self.flies(piece)) {
                controls.push(Control::Free(next));
                next += 1;
            } else {
                controls.push(Control::Fixed([0.0]));
            }
        }
        let weight = 1.0 / (0.5 * Self::STEP_M * Self::STEP_M);
        let data: Vec<Datum<1>> = self
            .heights
            .iter()
            .filter(|(t, _)| self.flying[(*t as usize).min(pieces)])
            .map(|(t, z)| Datum { place: *t, value: [z.max(0.0)], weight })
            .collect();
        if data.len() < 2 || next < 4 {
            return None;
        }
        let mut bounds = Vec::new();
        for j in 0..pieces + 3 {
            bounds.push(Bound::between(0, j, -1e-6, 20_000.0));
            if j + 1 < pieces + 3 {
                bounds.push(Bound::between(1, j, -Self::CLIMB_MPS, Self::CLIMB_MPS));
            }
            if j + 2 < pieces + 3 {
                bounds.push(Bound::between(2, j, -Self::VERTICAL_MS2, Self::VERTICAL_MS2));
            }
        }
        let fit = Fit { controls, data, roughness: 1.0 / 0.02, stiffness: Vec::new(), bounds };
        let floor = fit.bounded()?.into_iter().map(|[z]| [z.max(0.0)]).collect();
        Spline::new(0.0, 1.0, floor)
    }
}

/// Flips runs of `value` of fewer than `least` elements.
fn drop_short_runs(flags: &mut [bool], value: bool, least: usize) {
    let mut i = 0;
    while i < flags.len() {
        let run = flags[i..].iter().take_while(|f| **f == value).count();
        if run > 0 && run < least {
            flags[i..i + run].fill(!value);
        }
        i += run.max(1);
    }
}

/// Heights that can be flown one after the other: the longest chain with at most 30 m/s and 25 m.
fn flyable(altitudes: &[(usize, f64, f64)], offset_m: f64, tally: &mut Tally) -> Vec<(f64, f64)> {
    const LOOK_BACK: usize = 60;
    let mut best: Vec<(usize, Option<usize>)> = Vec::with_capacity(altitudes.len());
    for (j, (_, tb, zb)) in altitudes.iter().enumerate() {
        let mut link = (1, None);
        for i in (j.saturating_sub(LOOK_BACK)..j).rev() {
            let (_, ta, za) = altitudes[i];
            if (zb - za).abs() <= 30.0 * (tb - ta) + 25.0 && best[i].0 + 1 > link.0 {
                link = (best[i].0 + 1, Some(i));
            }
        }
        best.push(link);
    }
    let mut at = (0..altitudes.len()).max_by_key(|i| (best[*i].0, std::cmp::Reverse(*i)));
    let mut keep = vec![false; altitudes.len()];
    while let Some(i) = at {
        keep[i] = true;
        at = best[i].1;
    }
    let mut heights = Vec::new();
    for ((line, t, z), keep) in altitudes.iter().zip(keep) {
        if keep {
            heights.push((*t, z - offset_m));
        } else {
            tally.add(Rule::AltitudeSpike, *line);
        }
    }
    heights
}
