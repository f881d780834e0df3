//! The whole video of one turn: every cell of the radar with noise, rain, ground, buildings and targets.

use super::looks::{NEXT, Occluding};
use super::{Asde, ScanInterval, TargetClass, TargetState, Traffic, Truth};
use crate::draw::{DrawKey, Purpose, exponential};
use crate::environment::Weather;
use crate::frames::{Azimuth, Point2, Vector2};
use crate::sensors::radar::detection::from_db;
use crate::sensors::radar::effects::value::EchoPlace;
use crate::sensors::radar::equation::{Air, BudgetLevels, Echo, RainAir, RainEcho, RainPath};
use crate::sensors::radar::levels::{RadarLevels, ShadowLevel};
use crate::sensors::radar::shadow::{SightLine, aircraft_obstacles};
use crate::sensors::radar::video::{PointEcho, Threshold, Video};

/// What the ground around the radar returns.
pub trait Ground {
    /// Factor on the ground's reflectivity at a place, 1 for what the radar's γ stands for.
    fn factor(&self, place_m: Point2<f64>) -> f64;
}

/// The same ground everywhere.
#[derive(Clone, Copy, Debug)]
pub struct EvenGround;

impl Ground for EvenGround {
    fn factor(&self, _: Point2<f64>) -> f64 {
        1.0
    }
}

/// What a video shows beside targets, noise and rain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VideoScene {
    /// How the threshold of a cell is set.
    pub threshold: Threshold,
    /// Whether the ground's echo differs from cell to cell (exponentially in power, the same in every
    /// scan) or has its mean everywhere, as plot level reckons.
    pub ground_texture: bool,
    /// Whether walls that face the radar return an echo.
    pub walls: bool,
}

impl VideoScene {
    /// What plot level simulates, cell by cell.
    pub const PLAIN: Self =
        Self { threshold: Threshold::Known, ground_texture: false, walls: false };
    /// What an operator sees.
    pub const PICTURE: Self = Self {
        threshold: Threshold::CellAveraging { guard: 8, reference: 16 },
        ground_texture: true,
        walls: true,
    };
}

impl Asde {
    /// The video of one turn: all cells, with every effect at its exact level (or those that the
    /// radar was given); the most expensive form of this radar.
    ///
    /// The interval should be one turn; of several looks at a target the first counts. Targets are
    /// their scatterers, weakened by what stands before them; they fade from scan to scan unless the
    /// radar's targets are steady. Rain and ground are noise of their mean power (the ground with a
    /// texture where `scene` says so), each cell with the attenuation of the way to it and the ground
    /// with the shadows of buildings and aircraft. Walls reflect diffusely (Lambert): 4·|Γ|²·cos²i per
    /// area. Ghosts and second-trace echoes are left to plot level.
    #[must_use]
    pub fn video(
        &mut self,
        interval: &ScanInterval,
        truth: &dyn Truth,
        weather: &Weather,
        ground: &dyn Ground,
        scene: &VideoScene,
    ) -> Video {
        let air = self.radar.air(weather);
        let (mut looks, mut occluding) = (Vec::new(), Occluding::default());
        self.find_looks(interval, truth, &mut looks, &mut Vec::new(), &mut occluding);
        let mut traffic = Traffic::default();
        traffic.clear();
        occluding.fill(&mut traffic);
        traffic.finish();
        let levels = self.fixed.unwrap_or(self.base_levels());
        let key = self.key(interval, 0);
        let mut echoes = Vec::new();
        let mut aircraft = Vec::new();
        let mut last = None;
        for look in looks.iter().filter(|look| look.number == 0 || look.number == NEXT) {
            if last.replace(look.index) == Some(look.index) {
                continue;
            }
            aircraft.extend(Obstacle::of(truth.class(look.index), &look.state, self.site_m));
            if let Some(r) = self.echo(&air, &levels, truth, &traffic, look) {
                self.add_scatterers(&levels, truth, &r, key, &mut echoes);
            }
        }
        if scene.walls {
            echoes.extend(self.walls(&air));
        }
        let clutter = Clutter::new(self, &air, &levels, ground, scene.ground_texture, aircraft);
        let fill = |beam: usize, row: &mut [f64]| {
            clutter.fill(beam, row);
            true
        };
        self.grid.video(echoes, fill, scene.threshold, key)
    }

    /// Echoes of the walls that face the radar and are not hidden by other buildings.
    pub(super) fn walls(&mut self, air: &Air) -> Vec<PointEcho> {
        let mut out = Vec::new();
        let step_m = 0.5 * self.radar.cell_m;
        let buildings = self.buildings.clone();
        for (own, building) in buildings.iter().enumerate() {
            let turning: f64 = building.walls().map(|(a, b)| a.coords.perp(&b.coords)).sum();
            let gamma = crate::sensors::radar::ghost::facade_reflection(
                building.facade,
                self.radar.carrier_ghz,
            );
            for (from_m, to_m) in building.walls() {
                let along = to_m - from_m;
                let length_m = along.norm();
                if length_m < 0.1 {
                    continue;
                }
                let outward = Vector2::new(along.y, -along.x) / length_m * turning.signum();
                let count = (length_m / step_m).ceil();
                for i in 0..count as u32 {
                    let place_m = from_m + along * ((f64::from(i) + 0.5) / count);
                    let to_radar = self.site_m - place_m;
                    let ground_m = to_radar.norm().max(1.0);
                    let cos = outward.dot(&to_radar) / ground_m;
                    if cos <= 0.0 {
                        continue;
                    }
                    let line = SightLine {
                        site_m: self.site_m,
                        antenna_m: self.radar.antenna_m,
                        target_m: place_m + outward,
                        height_m: building.height_m,
                        wavelength_m: self.radar.wavelength_m,
                    };
                    let azimuth_rad = Azimuth::of(-to_radar).rad();
                    let hidden = self.skyline.before(azimuth_rad, ground_m).any(|other| {
                        let b = &buildings[other];
                        other != own && line.behind(&b.footprint_m, b.height_m).blocked
                    });
                    if hidden {
                        continue;
                    }
                    let area_m2 = length_m / count * building.height_m;
                    let echo = Echo {
                        ground_m,
                        height_m: 0.5 * building.height_m,
                        extent_m: building.height_m,
                        rcs_m2: 4.0 * gamma * gamma * area_m2 * cos * cos,
                    };
                    let levels = BudgetLevels::EXACT;
                    let budget = self.radar.budget(air, &levels, &echo, self.site_m, place_m);
                    out.push(PointEcho { range_m: budget.range_m, azimuth_rad, snr: budget.snr() });
                }
            }
        }
        out
    }
}

/// An aircraft that throws a shadow on the ground.
pub(super) struct Obstacle {
    azimuth: Azimuth,
    ground_m: f64,
    half_m: f64,
    top_m: f64,
    parts: Vec<(Vec<Point2<f64>>, f64)>,
}

impl Obstacle {
    /// What an aircraft on the surface puts into the way; `None` for all others.
    pub(super) fn of(
        class: &TargetClass,
        state: &TargetState,
        site_m: Point2<f64>,
    ) -> Option<Self> {
        if !class.aircraft || state.position_m.z > class.height_m {
            return None;
        }
        let place_m = state.position_m.xy();
        let parts = aircraft_obstacles(place_m, state.heading_rad, class.length_m, class.height_m);
        Some(Self {
            azimuth: Azimuth::of(place_m - site_m),
            ground_m: (place_m - site_m).norm(),
            half_m: 0.5 * class.length_m + 3.0,
            top_m: class.height_m,
            parts: parts.map(|(corners, top_m)| (corners.to_vec(), top_m)).to_vec(),
        })
    }
}

/// Rain and ground of every cell, prepared by range.
pub(super) struct Clutter<'a> {
    radar: &'a Asde,
    air: &'a Air,
    levels: BudgetLevels,
    /// Whether buildings shadow the ground.
    shadows: bool,
    ground: &'a dyn Ground,
    texture: bool,
    aircraft: Vec<Obstacle>,
    /// By cell: ground distance (none above the antenna's foot), `K/(R⁴·N)`, the ground's cross
    /// section, the rain's for unit reflectivity.
    cells: Vec<(Option<f64>, f64, f64, f64)>,
    /// By cell: cross section of what effects that are values add.
    other_m2: Vec<f64>,
}

impl<'a> Clutter<'a> {
    pub(super) fn new(
        asde: &'a Asde,
        air: &'a Air,
        levels: &RadarLevels,
        ground: &'a dyn Ground,
        texture: bool,
        mut aircraft: Vec<Obstacle>,
    ) -> Self {
        let shadows = levels.buildings != ShadowLevel::None;
        if levels.aircraft == ShadowLevel::None {
            aircraft.clear();
        }
        let levels = levels.budget;
        let radar = &asde.radar;
        let correlation = asde.rain_correlation;
        let cell = |c: usize| {
            let range_m = asde.grid.cell_centre_m(c as i64);
            let below = range_m * range_m - radar.antenna_m * radar.antenna_m;
            let ground_m = (below > 0.0).then(|| below.sqrt());
            let spread = radar.constant / range_m.powi(4) / radar.noise_w;
            let has_ground = below > 0.0 && levels.ground_echo;
            let ground_m2 = if has_ground { radar.ground_m2(range_m) } else { 0.0 };
            let volume_m3 = radar.rain_volume_m3(levels.rain_echo, range_m) * correlation;
            (ground_m, spread, ground_m2, volume_m3)
        };
        let cells: Vec<_> = (0..asde.grid.cells).map(cell).collect();
        let other = |(c, (ground_m, ..)): (usize, &(Option<f64>, f64, f64, f64))| {
            let range_m = asde.grid.cell_centre_m(c as i64);
            let place = EchoPlace { range_m, ground_m: ground_m.unwrap_or(0.0), height_m: 0.0 };
            radar.change_at(air, &levels, &place).clutter_m2
        };
        let other_m2 = cells.iter().enumerate().map(other).collect();
        Self { radar: asde, air, levels, shadows, ground, texture, aircraft, cells, other_m2 }
    }

    /// Noise and clutter over noise of the cells of one beam.
    pub(super) fn fill(&self, beam: usize, row: &mut [f64]) {
        let asde = self.radar;
        let azimuth_rad = (beam as f64 + 0.5) * asde.grid.beam_step_rad();
        let azimuth = Azimuth::from_rad(azimuth_rad);
        let unit = azimuth.unit();
        let weather = &self.air.weather;
        let uniform_db = self.air.without_rain_db_per_km(&self.levels);
        let rain_db = |rain: &RainAir| self.air.rain_db_per_km(self.levels.rain, rain);
        let cell_km = asde.grid.cell_m / 1000.0;
        let in_beam = self.in_beam(azimuth);
        let rainy = !weather.cells.is_empty()
            && (self.levels.rain != RainPath::None || self.levels.rain_echo != RainEcho::None);
        let key =
            DrawKey { run_seed: 0, sensor: u32::from(asde.id.0), entity: beam as u64, scan: 0 };
        let mut rng = key.rng(Purpose::GroundTexture);
        // The way to the first cell.
        let mut rain = *self.air.uniform();
        let first_km = asde.grid.range_min_m / 1000.0;
        let mut two_way_db = 2.0 * first_km * (uniform_db + rain_db(&rain));
        let cells = self.cells.iter().zip(&self.other_m2);
        for (value, (&(ground_m, spread, ground_m2, volume), other_m2)) in row.iter_mut().zip(cells)
        {
            let place_m = asde.site_m + unit * ground_m.unwrap_or(0.0);
            if rainy {
                rain = *self.air.rain(weather.rain_at(place_m));
            }
            let half_db = cell_km * (uniform_db + rain_db(&rain));
            let attenuation = from_db(-(two_way_db + half_db));
            two_way_db += 2.0 * half_db;
            let texture = if self.texture { exponential(&mut rng) } else { 1.0 };
            let mut patch_m2 = 0.0;
            if let Some(ground_m) = ground_m.filter(|_| ground_m2 > 0.0) {
                patch_m2 = ground_m2 * texture * self.ground.factor(place_m);
                let loss_db = self.shadow_db(&in_beam, azimuth_rad, place_m, ground_m);
                if loss_db > 0.0 {
                    patch_m2 *= from_db(-2.0 * loss_db);
                }
            }
            *value = 1.0
                + spread
                    * attenuation
                    * (self.air.rain_echo(self.levels.rain_echo, &rain) * volume
                        + patch_m2
                        + other_m2);
        }
    }

    /// Aircraft that this beam may meet.
    fn in_beam(&self, azimuth: Azimuth) -> Vec<&Obstacle> {
        let near = |o: &&Obstacle| azimuth.minus(o.azimuth).abs() * o.ground_m < o.half_m;
        self.aircraft.iter().filter(near).collect()
    }

    /// One-way loss to a patch of ground by buildings and aircraft before it.
    fn shadow_db(
        &self,
        aircraft: &[&Obstacle],
        azimuth_rad: f64,
        place_m: Point2<f64>,
        ground_m: f64,
    ) -> f64 {
        let asde = self.radar;
        let line = SightLine {
            site_m: asde.site_m,
            antenna_m: asde.radar.antenna_m,
            target_m: place_m,
            height_m: 0.0,
            wavelength_m: asde.radar.wavelength_m,
        };
        let mut loss_db = 0.0;
        if self.shadows {
            for index in asde.skyline.before(Azimuth::from_rad(azimuth_rad).rad(), ground_m) {
                let building = &asde.buildings[index];
                loss_db += line.behind(&building.footprint_m, building.height_m).loss_db;
            }
        }
        for obstacle in aircraft {
            let fall = asde.radar.antenna_m - obstacle.top_m;
            let reach = if fall > 0.0 { asde.radar.antenna_m / fall } else { f64::INFINITY };
            let end_m = (obstacle.ground_m + obstacle.half_m) * reach;
            if ground_m > obstacle.ground_m - obstacle.half_m && ground_m < end_m {
                let parts = obstacle.parts.iter();
                let most = parts.map(|(corners, top_m)| line.behind(corners, *top_m).loss_db);
                loss_db += most.fold(0.0, f64::max);
            }
        }
        loss_db
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Point3;
    use crate::frames::Vector3;

    #[test]
    fn aircraft_on_the_ground_stand_in_the_way_and_nothing_else() {
        let at = |up: f64| TargetState {
            position_m: Point3::new(300.0, 400.0, up),
            velocity_mps: Vector3::zeros(),
            heading_rad: 0.0,
        };
        let class = |aircraft| crate::sensors::testing::class(aircraft, 40.0, 36.0, 15.0);
        let of = |aircraft, up| Obstacle::of(&class(aircraft), &at(up), Point2::new(300.0, 0.0));
        assert!(of(false, 0.0).is_none() && of(true, 10.1).is_none() && of(true, 10.0).is_some());
        let obstacle = of(true, 0.0).expect("an aircraft");
        assert_eq!((obstacle.ground_m, obstacle.top_m, obstacle.half_m), (400.0, 10.0, 23.0));
        assert!(!obstacle.parts.is_empty());
        // No part reaches beyond half the length and three metres.
        for corner in obstacle.parts.iter().flat_map(|(corners, _)| corners) {
            assert!((corner - Point2::new(300.0, 400.0)).norm() <= obstacle.half_m, "{corner}");
        }
    }
}
