//! Which echoes share a cell: they become one.

use super::Asde;
use super::echo::Return;
use super::looks::NEXT;
use crate::frames::wrap_pi;
use crate::sensors::radar::effects::RadarEffect;
use std::f64::consts::TAU;

/// Where an echo is, for finding those beside it: sector, range step and place in the list in one
/// number that sorts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place(u64);

/// Length of a range step of [`Place`], m.
pub(super) const PLACE_STEP_M: f64 = 0.1;
/// Range steps: to 1600 km.
pub(super) const PLACE_STEPS: u64 = 1 << 24;

impl Place {
    pub(super) fn new(sector: u32, range_m: f64, index: u32) -> Self {
        let step = ((range_m / PLACE_STEP_M).max(0.0) as u64).min(PLACE_STEPS - 1);
        Self(u64::from(sector) << 48 | step << 24 | u64::from(index))
    }

    pub(super) fn sector(self) -> u64 {
        self.0 >> 48
    }

    pub(super) fn step(self) -> u64 {
        self.0 >> 24 & (PLACE_STEPS - 1)
    }

    pub(super) fn index(self) -> u32 {
        (self.0 & 0xff_ffff) as u32
    }
}

impl Asde {
    /// Echoes in one range and azimuth cell become one: signals add, the centre is that of the power.
    /// The first by target key keeps the echo and its draws.
    pub(super) fn merge(&mut self, returns: &mut [Return], order: &mut Vec<Place>) {
        for (i, r) in returns.iter_mut().enumerate() {
            r.cell = i as u32;
        }
        let (cell_m, beam) = (self.radar.cell_m, self.radar.pattern.azimuth_rad);
        // Sectors not narrower than the beam: echoes in one cell are in one sector or the next.
        let sectors = ((TAU / beam).floor() as u32).max(1);
        let sector = |azimuth_rad: f64| {
            let turn = azimuth_rad / TAU;
            (((turn - turn.floor()) * f64::from(sectors)) as u32).min(sectors - 1)
        };
        order.clear();
        order.extend(
            (0..)
                .zip(&*returns)
                .filter(|(_, r)| r.levels.merging)
                .map(|(i, r)| Place::new(sector(r.azimuth_rad), r.range_m, i)),
        );
        order.sort_unstable();
        // Echoes in one cell are at most so many range steps apart.
        let reach = (cell_m / PLACE_STEP_M) as u64 + 1;
        let turns_per_s = self.parameters.turns_per_s();
        let mut tested = 0;
        let mut test = |returns: &mut [Return], first: Place, second: Place| {
            let (a, b) = (&returns[first.index() as usize], &returns[second.index() as usize]);
            if (a.range_m - b.range_m).abs() >= cell_m {
                return;
            }
            tested += 1;
            let turns = a.look.time.since_s(b.look.time) * turns_per_s;
            let apart = wrap_pi(a.azimuth_rad - b.azimuth_rad).abs();
            if turns.abs() < 0.5 && apart < beam && a.look.index != b.look.index {
                let (root_a, root_b) =
                    (root(returns, first.index()), root(returns, second.index()));
                // An echo of the next interval leads only among its like.
                let rank = |i: u32| (returns[i as usize].look.number == NEXT, i);
                let (low, high) =
                    if rank(root_a) < rank(root_b) { (root_a, root_b) } else { (root_b, root_a) };
                returns[high as usize].cell = low;
            }
        };
        // The first echo of the next sector that may be near, moving on with the echoes of this one.
        let mut from = 0;
        let mut last_sector = u64::MAX;
        for place in 0..order.len() {
            let first = order[place];
            for &second in &order[place + 1..] {
                if second.sector() != first.sector() || second.step() > first.step() + reach {
                    break;
                }
                test(returns, first, second);
            }
            let next = (first.sector() + 1) % u64::from(sectors);
            if first.sector() != last_sector {
                last_sector = first.sector();
                from = order.partition_point(|p| p.sector() < next);
            }
            while from < order.len()
                && order[from].sector() == next
                && order[from].step() + reach < first.step()
            {
                from += 1;
            }
            for &second in &order[from..] {
                if second.sector() != next || second.step() > first.step() + reach {
                    break;
                }
                test(returns, first, second);
            }
        }
        self.tally.add(RadarEffect::Merging, tested);
        for i in 0..returns.len() as u32 {
            let head = root(returns, i);
            returns[i as usize].cell = head;
            if head != i {
                let member = returns[i as usize];
                let r = &mut returns[head as usize];
                let total = r.budget.signal_w + member.budget.signal_w;
                if total > 0.0 {
                    let share = member.budget.signal_w / total;
                    r.range_m += share * (member.range_m - r.range_m);
                    r.azimuth_rad += share * wrap_pi(member.azimuth_rad - r.azimuth_rad);
                }
                r.budget.signal_w = total;
            }
        }
    }
}

fn root(returns: &[Return], mut i: u32) -> u32 {
    while returns[i as usize].cell != i {
        i = returns[i as usize].cell;
    }
    i
}
