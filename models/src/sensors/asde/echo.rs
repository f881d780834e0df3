//! The echo of one look at one target: its budget in watts, where it is centred, and what stands before it.

use super::Asde;
use super::looks::Look;
use crate::sensors::radar::detection::from_db;
use crate::sensors::radar::effects::RadarEffect;
use crate::sensors::radar::equation::{Air, Budget, Echo};
use crate::sensors::radar::extended::{self, Centroid, ExtentLevel};
use crate::sensors::radar::levels::{RadarLevels, ShadowLevel};
use crate::sensors::radar::shadow::{SightLine, Traffic, aircraft_obstacles, edge_reach_m};
use crate::sensors::radar::span::Span;
use crate::sensors::{TargetClass, Truth};

/// Two-way losses on one sight line, dB, by what stands in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Shadows {
    pub(super) buildings_db: f64,
    pub(super) aircraft_db: f64,
}

impl Shadows {
    pub(super) fn db(&self) -> f64 {
        self.buildings_db + self.aircraft_db
    }
}

/// One echo before detection.
#[derive(Clone, Copy, Debug)]
pub(super) struct Return {
    pub(super) look: Look,
    /// At which levels it is simulated.
    pub(super) levels: RadarLevels,
    pub(super) budget: Budget,
    /// Slant range and azimuth of the centre of the echo.
    pub(super) range_m: f64,
    pub(super) azimuth_rad: f64,
    /// Where the reference point is seen.
    pub(super) bias_along_m: f64,
    pub(super) bias_across_m: f64,
    pub(super) glint_along_m: f64,
    pub(super) glint_across_m: f64,
    /// Two-way loss by shadows.
    pub(super) shadow: Shadows,
    /// First of the echoes in the same cell, by place in the list; itself if it stands alone.
    pub(super) cell: u32,
}

impl Asde {
    /// The budget of one look at one target, with shadows, and where its echo is centred. `None`
    /// outside the display range, and where nothing of the target returns an echo.
    pub(super) fn echo(
        &mut self,
        air: &Air,
        levels: &RadarLevels,
        truth: &dyn Truth,
        traffic: &Traffic,
        look: &Look,
    ) -> Option<Return> {
        let class = truth.class(look.index);
        let state = &look.state;
        let offset = state.position_m.xy() - self.site_m;
        let ground_m = offset.norm();
        let azimuth_rad = look.azimuth_rad;
        // The echo comes from the middle of the body; a body on the surface stands half its height above it.
        let height_m = state.position_m.z.max(0.5 * class.height_m);
        let down_m = self.radar.antenna_m - height_m;
        let slant_m = (ground_m * ground_m + down_m * down_m).sqrt();
        self.apparent_m(levels, slant_m)?;
        let shadow = self.shadows(levels, truth, traffic, look, azimuth_rad, ground_m, height_m)?;
        // In a shadow the ratio is none that the plan reckons with: everything exact.
        let exact = self.base_levels();
        let levels = if shadow.db() > 0.0 && self.fixed.is_none() { &exact } else { levels };
        let centroid = self.centroid(levels.extent, class, look)?;
        let echo = Echo { ground_m, height_m, extent_m: class.height_m, rcs_m2: centroid.rcs_m2 };
        let mut budget =
            self.radar.budget(air, &levels.budget, &echo, self.site_m, state.position_m.xy());
        self.tally.note(budget.evaluated);
        if shadow.db() > 0.0 {
            budget.signal_w *= from_db(-shadow.db());
        }
        // Along and across are on the ground; the range grows by the projection.
        let slope = ground_m / budget.range_m;
        let (along_m, across_m) = budget.moved_m;
        Some(Return {
            look: *look,
            levels: *levels,
            range_m: budget.range_m + (centroid.bias_along_m + along_m) * slope,
            azimuth_rad: azimuth_rad + (centroid.bias_across_m + across_m) / ground_m.max(1.0),
            budget,
            bias_along_m: centroid.bias_along_m,
            bias_across_m: centroid.bias_across_m,
            glint_along_m: centroid.glint_along_m * slope,
            glint_across_m: centroid.glint_across_m,
            shadow,
            cell: 0,
        })
    }

    fn centroid(
        &mut self,
        level: ExtentLevel,
        class: &TargetClass,
        look: &Look,
    ) -> Option<Centroid> {
        if level != ExtentLevel::Point {
            self.tally.count(RadarEffect::Extent);
        }
        let view_rad = extended::view_rad(look.azimuth_rad, look.state.heading_rad);
        match level {
            ExtentLevel::Table => self.aspects.centroid(look.index, class, view_rad),
            ExtentLevel::Point | ExtentLevel::Centroid => {
                extended::centroid(level, class, view_rad)
            }
        }
    }

    /// The range at which an echo from `slant_m` appears, if that is displayed.
    pub(super) fn apparent_m(&self, levels: &RadarLevels, slant_m: f64) -> Option<f64> {
        let range_m = slant_m - self.folded_m(levels, slant_m);
        self.shown().contains(range_m).then_some(range_m)
    }

    /// By how much an echo from `slant_m` appears nearer than it is: whole unambiguous ranges.
    pub(super) fn folded_m(&self, levels: &RadarLevels, slant_m: f64) -> f64 {
        let unambiguous = self.parameters.unambiguous_m();
        if levels.second_trace && slant_m > self.parameters.second_trace_from_m() {
            (slant_m / unambiguous).floor() * unambiguous
        } else {
            0.0
        }
    }

    /// Slant ranges that are displayed.
    pub(super) fn shown(&self) -> Span {
        Span { low: self.parameters.range_min_m, high: self.parameters.range_max_m }
    }

    /// Two-way loss by buildings and aircraft on the sight line; `None` where it is cut and the level
    /// knows only in sight or not.
    #[expect(clippy::too_many_arguments, reason = "all parts of one look, already computed")]
    fn shadows(
        &mut self,
        levels: &RadarLevels,
        truth: &dyn Truth,
        traffic: &Traffic,
        look: &Look,
        azimuth_rad: f64,
        ground_m: f64,
        height_m: f64,
    ) -> Option<Shadows> {
        let line = SightLine {
            site_m: self.site_m,
            antenna_m: self.radar.antenna_m,
            target_m: look.state.position_m.xy(),
            height_m,
            wavelength_m: self.radar.wavelength_m,
        };
        let mut found_db = Shadows::default();
        if levels.buildings != ShadowLevel::None {
            for index in self.skyline.before(azimuth_rad, ground_m) {
                self.tally.count(RadarEffect::BuildingShadow);
                let building = &self.buildings[index];
                let found = line.behind(&building.footprint_m, building.height_m);
                match levels.buildings {
                    ShadowLevel::Binary if found.blocked => return None,
                    ShadowLevel::KnifeEdge => found_db.buildings_db += 2.0 * found.loss_db,
                    _ => {}
                }
            }
        }
        if levels.aircraft != ShadowLevel::None {
            for index in traffic.before(&line, azimuth_rad, ground_m) {
                if index == look.index {
                    continue;
                }
                let Some(state) = truth.at(index, look.time) else { continue };
                let class = truth.class(index);
                let place_m = state.position_m.xy();
                // An aircraft as near as its own size stands beside the target, not before it.
                let before = (place_m - self.site_m).norm();
                if before + 0.5 * class.length_m >= ground_m || state.position_m.z > class.height_m
                {
                    continue;
                }
                let along = line.target_m - self.site_m;
                let aside_m = (along.perp(&(place_m - self.site_m)) / ground_m).abs();
                let reach_m = edge_reach_m(self.radar.wavelength_m, ground_m);
                // Half the diagonal of the fuselage.
                if aside_m > 0.503 * class.length_m + reach_m {
                    continue;
                }
                self.tally.count(RadarEffect::AircraftShadow);
                let obstacles =
                    aircraft_obstacles(place_m, state.heading_rad, class.length_m, class.height_m);
                let mut least = 0.0f64;
                for (corners, top_m) in &obstacles {
                    let found = line.behind(corners, *top_m);
                    match levels.aircraft {
                        ShadowLevel::Binary if found.blocked => return None,
                        ShadowLevel::KnifeEdge => least = least.max(found.loss_db),
                        _ => {}
                    }
                }
                found_db.aircraft_db += 2.0 * least;
            }
        }
        Some(found_db)
    }
}
