//! What a radar makes of a target that stands at one place, without draws: for maps of a site.

use super::{Air, Asde, DetectionRule};
use crate::frames::{Azimuth, Point3};
use crate::sensors::TargetClass;
use crate::sensors::radar::detection::{from_db, to_db};
use crate::sensors::radar::equation::{Budget, BudgetLevels, Echo};
use crate::sensors::radar::extended::{ExtentLevel, centroid};
use crate::sensors::radar::ghost::ghost_power;
use crate::sensors::radar::shadow::SightLine;

/// How a class of targets is seen: at one aspect, or over all of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aspect {
    /// Mean cross section, m².
    pub rcs_m2: f64,
    /// Deviation of the echo's centre along the line of sight, m.
    pub along_m: f64,
    /// Across it, m.
    pub across_m: f64,
}

/// Aspects over which means are taken.
const ASPECTS: u32 = 360;

impl Aspect {
    /// One aspect, radians clockwise from ahead; `None` where nothing returns an echo.
    #[must_use]
    pub fn seen(class: &TargetClass, view_rad: f64) -> Option<Self> {
        let c = centroid(ExtentLevel::Centroid, class, view_rad)?;
        Some(Self { rcs_m2: c.rcs_m2, along_m: c.glint_along_m, across_m: c.glint_across_m })
    }

    /// Means of powers over all aspects.
    #[must_use]
    pub fn mean(class: &TargetClass) -> Self {
        let (mut sum, mut n) = (Self { rcs_m2: 0.0, along_m: 0.0, across_m: 0.0 }, 0.0);
        for c in Self::all(class) {
            sum.rcs_m2 += c.rcs_m2;
            sum.along_m += c.along_m * c.along_m;
            sum.across_m += c.across_m * c.across_m;
            n += 1.0;
        }
        let n = f64::max(n, 1.0);
        let (along_m, across_m) = ((sum.along_m / n).sqrt(), (sum.across_m / n).sqrt());
        Self { rcs_m2: sum.rcs_m2 / n, along_m, across_m }
    }

    /// The weakest echo and the largest wander of any aspect.
    #[must_use]
    pub fn worst(class: &TargetClass) -> Self {
        let start = Self { rcs_m2: f64::INFINITY, along_m: 0.0, across_m: 0.0 };
        Self::all(class).fold(start, |worst, c| Self {
            rcs_m2: worst.rcs_m2.min(c.rcs_m2),
            along_m: worst.along_m.max(c.along_m),
            across_m: worst.across_m.max(c.across_m),
        })
    }

    fn all(class: &TargetClass) -> impl Iterator<Item = Self> + '_ {
        (0..ASPECTS).filter_map(|i| Self::seen(class, f64::from(i).to_radians()))
    }
}

/// What a radar makes of a target at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Survey {
    /// Ratio of signal to clutter and noise, dB, shadows included.
    pub scnr_db: f64,
    /// Probability of detection per scan.
    pub pd: f64,
    /// Root of the sum of both variances of a plot on the ground, m: thermal errors, glint, steps.
    pub sigma_m: f64,
    /// Two-way loss by buildings, dB.
    pub shadow_db: f64,
    /// Expected ghosts per scan.
    pub ghosts: f64,
    /// What the plan leaves out there, at most: rms shift, m, and probability of detection.
    pub left_out: (f64, f64),
}

impl Asde {
    /// What everything exact makes of a target of a class that stands at a place (m east, north, up),
    /// seen at an aspect. `None` where the radar displays nothing.
    #[must_use]
    pub fn survey(
        &mut self,
        air: &Air,
        class: &TargetClass,
        aspect: &Aspect,
        place_m: Point3<f64>,
    ) -> Option<Survey> {
        let (budget, shadow_db) = self.budget_at(air, class, aspect, place_m)?;
        let ground_m = (place_m.xy() - self.site_m).norm();
        let height_m = place_m.z.max(0.5 * class.height_m);
        let slant_m = libm::hypot(ground_m, self.radar.antenna_m - height_m);
        let p = &self.parameters;
        let scnr = budget.scnr();
        let (range_sigma_m, azimuth_sigma_rad) = self.sigmas(scnr, budget.reflected);
        let below = p.antenna_height_m - p.assumed_height_m;
        let shown_m = (slant_m * slant_m - below * below).max(0.01 * slant_m * slant_m).sqrt();
        let slope = slant_m / shown_m;
        let step2 = |step: f64| step * step / 12.0;
        let flat = ground_m / slant_m;
        let along_m2 = (range_sigma_m * range_sigma_m
            + aspect.along_m * aspect.along_m * flat * flat
            + step2(p.range_step_m))
            * slope
            * slope;
        let across_m2 = ground_m
            * ground_m
            * (azimuth_sigma_rad * azimuth_sigma_rad + step2(p.azimuth_step_deg.to_radians()))
            + aspect.across_m * aspect.across_m;
        let pd = self.chance(&budget);
        let ghosts = self.expected_ghosts(air, class, place_m, height_m);
        let left_out = self.left_out_at(air, class, place_m);
        Some(Survey {
            scnr_db: to_db(scnr),
            pd,
            sigma_m: (along_m2 + across_m2).sqrt(),
            shadow_db,
            ghosts,
            left_out,
        })
    }

    /// Probability of detection, per scan, of a target of a class that stands at a place, as [`Self::survey`] has it. `None`
    /// where the radar displays nothing.
    #[must_use]
    pub fn detection_at(
        &self,
        air: &Air,
        class: &TargetClass,
        aspect: &Aspect,
        place_m: Point3<f64>,
    ) -> Option<f64> {
        let (budget, _) = self.budget_at(air, class, aspect, place_m)?;
        Some(self.chance(&budget))
    }

    /// The budget of such a target, shadows included, and the two-way loss by buildings, dB.
    fn budget_at(
        &self,
        air: &Air,
        class: &TargetClass,
        aspect: &Aspect,
        place_m: Point3<f64>,
    ) -> Option<(Budget, f64)> {
        let offset = place_m.xy() - self.site_m;
        let (ground_m, azimuth_rad) = (offset.norm(), Azimuth::of(offset).rad());
        let height_m = place_m.z.max(0.5 * class.height_m);
        let slant_m = libm::hypot(ground_m, self.radar.antenna_m - height_m);
        let p = &self.parameters;
        if slant_m < p.range_min_m || slant_m > p.range_max_m || ground_m <= 0.0 {
            return None;
        }
        let line = SightLine {
            site_m: self.site_m,
            antenna_m: self.radar.antenna_m,
            target_m: place_m.xy(),
            height_m,
            wavelength_m: self.radar.wavelength_m,
        };
        let behind = |i: usize| {
            2.0 * line.behind(&self.buildings[i].footprint_m, self.buildings[i].height_m).loss_db
        };
        let shadow_db: f64 = self.skyline.before(azimuth_rad, ground_m).map(behind).sum();
        let echo = Echo { ground_m, height_m, extent_m: class.height_m, rcs_m2: aspect.rcs_m2 };
        let exact = BudgetLevels::EXACT;
        let mut budget = self.radar.budget(air, &exact, &echo, self.site_m, place_m.xy());
        budget.signal_w *= from_db(-shadow_db);
        Some((budget, shadow_db))
    }

    /// Probability of detection of an echo, exact.
    fn chance(&self, budget: &Budget) -> f64 {
        let rain_w = budget.rain_w * self.rain_correlation;
        let ratio = budget.signal_w / (budget.noise_w + rain_w + budget.ground_w + budget.other_w);
        match self.parameters.detection {
            DetectionRule::Threshold => f64::from(u8::from(ratio >= self.required)),
            DetectionRule::Bernoulli => self.detector.probability(ratio, self.parameters.swerling),
        }
    }

    /// Expected ghosts per scan of a target: by the mixed path in both directions, and by the double
    /// bounce in that of the facade.
    fn expected_ghosts(
        &self,
        air: &Air,
        class: &TargetClass,
        place_m: Point3<f64>,
        height_m: f64,
    ) -> f64 {
        let antenna_m = self.radar.antenna_m;
        let offset = place_m.xy() - self.site_m;
        let down_m = antenna_m - height_m;
        let direct_m = libm::hypot(offset.norm(), down_m);
        let exact = self.base_levels();
        let mut sum = 0.0;
        for facade in &self.facades {
            let found = facade.ghost(antenna_m, place_m.xy(), height_m, self.radar.wavelength_m);
            let Some(ghost) = found else { continue };
            let to_facade = Azimuth::of(ghost.point_m - self.site_m);
            let to_target = Azimuth::of(offset);
            let beside = self.radar.pattern.azimuth(to_target.minus(to_facade));
            let (mixed, double) = ghost_power(ghost.reflection, direct_m, ghost.path_m, beside);
            let half_way_m = 0.5 * (direct_m + ghost.path_m);
            for (beam, way_m, power) in [
                (to_facade, half_way_m, mixed),
                (to_target, half_way_m, mixed),
                (to_facade, ghost.path_m, double),
            ] {
                let Some(range_m) = self.apparent_m(&exact, way_m) else { continue };
                let ground_m = (range_m * range_m - down_m * down_m).max(1.0).sqrt();
                // By way of a wall another aspect is seen: the median stands for it.
                let (extent_m, rcs_m2) = (class.height_m, class.rcs_m2);
                let echo = Echo { ground_m, height_m, extent_m, rcs_m2 };
                let at_m = self.site_m + beam.unit() * ground_m;
                let levels = BudgetLevels::EXACT;
                let mut budget = self.radar.budget(air, &levels, &echo, self.site_m, at_m);
                let again = range_m / direct_m;
                budget.signal_w *= power * again * again * again * again;
                sum += self.chance(&budget);
            }
        }
        sum
    }
}
