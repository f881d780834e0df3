//! Ghosts: targets seen by way of a facade.

use super::Asde;
use crate::draw::{Purpose, normal_pair, uniform};
use crate::frames::Azimuth;
use crate::plot::{Plot, Polar};
use crate::sensors::radar::detection::to_db;
use crate::sensors::radar::effects::RadarEffect;
use crate::sensors::radar::equation::{Air, Echo};
use crate::sensors::radar::ghost::ghost_power;
use crate::sensors::radar::levels::RadarLevels;
use crate::sensors::{ScanInterval, TargetState, Truth};

impl Asde {
    /// Ghosts of one target in all facades: the double bounce in the direction of the facade, and the
    /// mixed path in both directions.
    pub(super) fn ghosts(
        &mut self,
        air: &Air,
        levels: &RadarLevels,
        interval: &ScanInterval,
        truth: &dyn Truth,
        index: usize,
        out: &mut Vec<(Plot, f64)>,
    ) {
        let Some(state) = truth.at(index, interval.to) else { return };
        let class = truth.class(index);
        let mut rng = None;
        for f in 0..self.facades.len() {
            let facade = self.facades[f];
            let height = |state: &TargetState| state.position_m.z.max(0.5 * class.height_m);
            let antenna_m = self.radar.antenna_m;
            let wavelength_m = self.radar.wavelength_m;
            let mirror = |state: &TargetState| {
                facade.ghost(antenna_m, state.position_m.xy(), height(state), wavelength_m)
            };
            let Some(at_end) = mirror(&state) else { continue };
            let key = self.key(interval, truth.key(index));
            let rng = rng.get_or_insert_with(|| key.rng(Purpose::Ghosts));
            let to_facade = Azimuth::of(at_end.point_m - self.site_m);
            let to_target = Azimuth::of(state.position_m.xy() - self.site_m);
            for (azimuth, direct) in [(to_facade, false), (to_target, true)] {
                for time in self.passes(interval, azimuth.rad()) {
                    let Some(now) = truth.at(index, time) else { continue };
                    let Some(ghost) = mirror(&now) else { continue };
                    self.tally.count(RadarEffect::Ghosts);
                    let offset = now.position_m.xy() - self.site_m;
                    let down_m = antenna_m - height(&now);
                    let direct_m = libm::hypot(offset.norm(), down_m);
                    let apart = Azimuth::of(offset).minus(Azimuth::of(ghost.point_m - self.site_m));
                    let off_beam = self.radar.pattern.azimuth(apart);
                    let (mixed, double) =
                        ghost_power(ghost.reflection, direct_m, ghost.path_m, off_beam);
                    let beam = if direct {
                        Azimuth::of(offset)
                    } else {
                        Azimuth::of(ghost.point_m - self.site_m)
                    };
                    let mut ways = vec![(0.5 * (direct_m + ghost.path_m), mixed)];
                    if !direct {
                        ways.push((ghost.path_m, double));
                    }
                    for (range_m, power) in ways {
                        let chance = uniform(rng);
                        let normal = normal_pair(rng);
                        let Some(range_m) = self.apparent_m(levels, range_m) else { continue };
                        let ground_m = (range_m * range_m - down_m * down_m).max(1.0).sqrt();
                        let echo = Echo {
                            ground_m,
                            height_m: height(&now),
                            extent_m: class.height_m,
                            rcs_m2: class.rcs_m2,
                        };
                        let place_m = self.site_m + beam.unit() * ground_m;
                        let b = levels.budget;
                        let mut budget = self.radar.budget(air, &b, &echo, self.site_m, place_m);
                        self.tally.note(budget.evaluated);
                        // The budget at the ghost's range already has its spreading loss.
                        let again = range_m / direct_m;
                        budget.signal_w *= power * again * again * again * again;
                        let Some(strength) = self.detected(levels, &budget, chance) else {
                            continue;
                        };
                        let (range_sigma_m, azimuth_sigma_rad) =
                            self.sigmas(budget.scnr(), budget.reflected);
                        let stated = self.sigmas(strength, budget.reflected);
                        let glint_m = self.stated_glint_m(levels);
                        let measured = Polar {
                            range_m: range_m + range_sigma_m * normal.0,
                            azimuth_rad: beam.rad() + azimuth_sigma_rad * normal.1,
                            sigma_range_m: libm::hypot(stated.0, glint_m),
                            sigma_azimuth_rad: libm::hypot(stated.1, glint_m / ground_m),
                            extent_m2: None,
                        };
                        out.push((
                            self.plot(levels, time, measured, to_db(strength)),
                            to_db(power),
                        ));
                    }
                }
            }
        }
    }
}
