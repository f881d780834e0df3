//! What stands between radar and target: knife-edge diffraction, buildings, other aircraft.

use crate::environment::surface::Material;
use crate::frames::{Point2, Vector2, wrap_pi};
use crate::special::fresnel_tail;

/// Parameter of a knife edge: `ν = h·√(2(d₁+d₂)/(λ·d₁·d₂))`.
///
/// `height_m` of the edge above the line of sight (negative: clear of it), `d1_m` and `d2_m` to the
/// two ends; both are taken as at least one wavelength. Source: ITU-R P.526-15, eq. (26).
#[must_use]
pub fn knife_edge_parameter(height_m: f64, d1_m: f64, d2_m: f64, wavelength_m: f64) -> f64 {
    let (d1, d2) = (d1_m.max(wavelength_m), d2_m.max(wavelength_m));
    height_m * (2.0 * (d1 + d2) / (wavelength_m * d1 * d2)).sqrt()
}

/// One-way loss behind a knife edge, dB: `6.9 + 20·log₁₀(√((ν−0.1)²+1) + ν − 0.1)`, 0 below ν = −0.78.
///
/// Source: ITU-R P.526-15, eq. (31); within 0.13 dB of the Fresnel integral up to ν = 5.
#[must_use]
pub fn knife_edge_db(v: f64) -> f64 {
    if v <= -0.78 {
        return 0.0;
    }
    let x = v - 0.1;
    6.9 + 20.0 * libm::log10((x * x + 1.0).sqrt() + x)
}

/// The same by the Fresnel integral: exact, with the ripple (gain) on the clear side.
#[must_use]
pub fn knife_edge_exact_db(v: f64) -> f64 {
    if v >= 0.0 {
        return -20.0 * libm::log10(fresnel_tail(v));
    }
    let (c, s) = crate::special::fresnel(v);
    -20.0 * libm::log10(0.5 * libm::hypot(1.0 - c - s, c - s))
}

/// How far beside an obstacle a wave over `range_m` is still weakened at most, m: beyond, ν of any
/// edge is below −0.78.
#[must_use]
pub fn edge_reach_m(wavelength_m: f64, range_m: f64) -> f64 {
    // 0.78/√2 of the zone's width, which is largest half way.
    0.276 * (wavelength_m * range_m).sqrt()
}

/// Something that stands on the airport: a footprint with vertical walls.
#[derive(Clone, Debug, PartialEq)]
pub struct Building {
    /// Name for people.
    pub name: String,
    /// Corners in order, airport frame, m; the last joins the first.
    pub footprint_m: Vec<Point2<f64>>,
    /// Height above the surface, m.
    pub height_m: f64,
    /// What its walls are made of.
    pub facade: &'static Material,
}

impl Building {
    /// Walls as pairs of corners.
    pub fn walls(&self) -> impl Iterator<Item = (Point2<f64>, Point2<f64>)> + '_ {
        let n = self.footprint_m.len();
        (0..n).map(move |i| (self.footprint_m[i], self.footprint_m[(i + 1) % n]))
    }

    /// Distance of its nearest corner or wall from a place, m.
    #[must_use]
    pub fn nearest_m(&self, place_m: Point2<f64>) -> f64 {
        let to_wall = |(a, b): (Point2<f64>, Point2<f64>)| {
            let along = b - a;
            let length2 = along.norm_squared();
            let share = if length2 > 0.0 { (place_m - a).dot(&along) / length2 } else { 0.0 };
            (a + along * share.clamp(0.0, 1.0) - place_m).norm()
        };
        if self.contains(place_m) {
            return 0.0;
        }
        self.walls().map(to_wall).fold(f64::INFINITY, f64::min)
    }

    /// Area of the footprint, m².
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        0.5 * self.walls().map(|(a, b)| a.coords.perp(&b.coords)).sum::<f64>().abs()
    }

    /// Whether a place is inside the footprint.
    #[must_use]
    pub fn contains(&self, place_m: Point2<f64>) -> bool {
        let crossings = self.walls().filter(|(a, b)| {
            (a.y > place_m.y) != (b.y > place_m.y)
                && place_m.x < a.x + (place_m.y - a.y) / (b.y - a.y) * (b.x - a.x)
        });
        crossings.count() % 2 == 1
    }
}

/// The straight line from an antenna to an echo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SightLine {
    /// Foot of the antenna, airport frame, m.
    pub site_m: Point2<f64>,
    /// Height of the antenna, m.
    pub antenna_m: f64,
    /// Foot of the echo, m.
    pub target_m: Point2<f64>,
    /// Height of the echo, m.
    pub height_m: f64,
    /// Wavelength, m.
    pub wavelength_m: f64,
}

/// What an obstacle does to a sight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstruction {
    /// Whether the straight line is cut.
    pub blocked: bool,
    /// One-way diffraction loss, dB; zero or more.
    pub loss_db: f64,
}

impl Obstruction {
    /// A free line.
    pub const FREE: Self = Self { blocked: false, loss_db: 0.0 };
}

impl SightLine {
    /// An obstacle with vertical walls (`corners` in order) up to `height_m` on the line.
    ///
    /// Where the line crosses the footprint, the wave goes over the roof or round either side: the
    /// knife edge with the least loss counts. Where it passes beside, only the nearer edge does, and
    /// only if the wall is as high as the line there.
    #[must_use]
    pub fn behind(&self, corners: &[Point2<f64>], height_m: f64) -> Obstruction {
        let way = self.target_m - self.site_m;
        let d = way.norm();
        if d < self.wavelength_m {
            return Obstruction::FREE;
        }
        let along = way / d;
        let height_at = |s: f64| self.antenna_m + (self.height_m - self.antenna_m) * s / d;
        // Corners in coordinates along the line and to its left.
        let local = |corner: &Point2<f64>| {
            let offset = corner - self.site_m;
            (offset.dot(&along), along.perp(&offset))
        };
        let parameter = |h: f64, s: f64| knife_edge_parameter(h, s, d - s, self.wavelength_m);
        let mut roof = f64::NEG_INFINITY;
        let mut blocked = false;
        let (mut left, mut right) = ((f64::NEG_INFINITY, 0.0), (f64::INFINITY, 0.0));
        let mut nearest = (f64::INFINITY, 0.0);
        let Some(last) = corners.last() else { return Obstruction::FREE };
        let mut before = local(last);
        for corner in corners {
            let here = local(corner);
            if (before.1 > 0.0) != (here.1 > 0.0) {
                let s = before.0 - before.1 * (here.0 - before.0) / (here.1 - before.1);
                if s > 0.0 && s < d {
                    let above = height_m - height_at(s);
                    roof = roof.max(parameter(above, s));
                    blocked |= above > 0.0;
                }
            }
            if here.0 > 0.0 && here.0 < d {
                if here.1 > left.0 {
                    left = (here.1, here.0);
                }
                if here.1 < right.0 {
                    right = (here.1, here.0);
                }
                if here.1.abs() < nearest.0 {
                    nearest = (here.1.abs(), here.0);
                }
            }
            before = here;
        }
        if roof > f64::NEG_INFINITY {
            let mut loss_db = knife_edge_db(roof);
            for (offset, s) in [left, (-right.0, right.1)] {
                if loss_db > 0.0 && offset.is_finite() && offset >= 0.0 {
                    loss_db = loss_db.min(knife_edge_db(parameter(offset, s)));
                }
            }
            return Obstruction { blocked, loss_db };
        }
        let (offset, s) = nearest;
        if offset.is_finite() && height_at(s) < height_m {
            return Obstruction { blocked: false, loss_db: knife_edge_db(parameter(-offset, s)) };
        }
        Obstruction::FREE
    }
}

/// Buildings around one radar, found by sector.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skyline {
    sectors: Vec<Vec<u32>>,
    near_m: Vec<f64>,
}

/// Sectors of the table.
const SECTORS: usize = 512;

/// The sector of an azimuth.
fn sector(azimuth_rad: f64) -> usize {
    let turn = azimuth_rad / std::f64::consts::TAU;
    (((turn - turn.floor()) * SECTORS as f64) as usize).min(SECTORS - 1)
}

/// The sectors within `half_rad` of an azimuth.
fn sectors_around(azimuth_rad: f64, half_rad: f64) -> impl Iterator<Item = usize> {
    let width = std::f64::consts::TAU / SECTORS as f64;
    let reach = ((half_rad / width).ceil() as usize).min(SECTORS / 2);
    let middle = sector(azimuth_rad);
    (0..(2 * reach + 1).min(SECTORS)).map(move |i| (middle + SECTORS - reach + i) % SECTORS)
}

impl Skyline {
    /// The table for an antenna over `site_m`.
    #[must_use]
    pub fn new(buildings: &[Building], site_m: Point2<f64>) -> Self {
        if buildings.is_empty() {
            return Self::default();
        }
        let mut sectors = vec![Vec::new(); SECTORS];
        let mut near_m = Vec::new();
        for (index, building) in buildings.iter().enumerate() {
            let near = building.nearest_m(site_m);
            near_m.push(near);
            let n = building.footprint_m.len() as f64;
            let corners = building.footprint_m.iter().map(|corner| corner.coords);
            let centre = Point2::from(corners.sum::<Vector2<f64>>() / n);
            let middle = crate::frames::Azimuth::of(centre - site_m);
            let mut half = 0.0f64;
            for corner in &building.footprint_m {
                let azimuth = crate::frames::Azimuth::of(corner - site_m);
                half = half.max(azimuth.minus(middle).abs());
            }
            // An edge reaches a few metres into the light beside it.
            half += libm::atan2(10.0, near.max(1.0));
            if near < 10.0 {
                half = std::f64::consts::PI;
            }
            for s in sectors_around(middle.rad(), half) {
                sectors[s].push(index as u32);
            }
        }
        Self { sectors, near_m }
    }

    /// Buildings that may stand before a target at this azimuth and ground distance.
    pub fn before(&self, azimuth_rad: f64, ground_m: f64) -> impl Iterator<Item = usize> + '_ {
        let list = self.sectors.get(sector(azimuth_rad)).map_or(&[][..], Vec::as_slice);
        list.iter().map(|&i| i as usize).filter(move |&i| self.near_m[i] < ground_m)
    }
}

/// An aircraft as seen from the radar, rounded outwards.
#[derive(Clone, Copy, Debug)]
struct Occluder {
    ground_m: f64,
    azimuth_rad: f64,
    half_rad: f64,
    index: u32,
}

/// Aircraft that may shadow others in one scan, found by sector and distance.
#[derive(Clone, Debug, Default)]
pub struct Traffic {
    sectors: Vec<Vec<Occluder>>,
    highest_m: f64,
    longest_m: f64,
}

impl Traffic {
    /// Forgets everything, for a new scan.
    pub fn clear(&mut self) {
        self.sectors.resize(SECTORS, Vec::new());
        self.sectors.iter_mut().for_each(Vec::clear);
        (self.highest_m, self.longest_m) = (0.0, 0.0);
    }

    /// Adds an aircraft by azimuth and distance; `reach_m` covers its size, its way within the scan and
    /// what its edges weaken beside it.
    pub fn add(&mut self, index: usize, azimuth_rad: f64, ground_m: f64, top_m: f64, reach_m: f64) {
        let half =
            if reach_m < ground_m { libm::asin(reach_m / ground_m) } else { std::f64::consts::PI };
        for s in sectors_around(azimuth_rad, half) {
            self.sectors[s].push(Occluder {
                ground_m,
                azimuth_rad,
                half_rad: half,
                index: index as u32,
            });
        }
        self.highest_m = self.highest_m.max(top_m);
        self.longest_m = self.longest_m.max(reach_m);
    }

    /// Sorts by distance; to be called after the last [`Self::add`].
    pub fn finish(&mut self) {
        let order = |a: &Occluder, b: &Occluder| {
            a.ground_m.total_cmp(&b.ground_m).then(a.index.cmp(&b.index))
        };
        self.sectors.iter_mut().for_each(|list| list.sort_unstable_by(order));
    }

    /// Aircraft near enough before and beside a target to reach into its sight line.
    pub fn before(
        &self,
        line: &SightLine,
        azimuth_rad: f64,
        ground_m: f64,
    ) -> impl Iterator<Item = usize> + '_ {
        let list = self.sectors.get(sector(azimuth_rad)).map_or(&[][..], Vec::as_slice);
        let fall = line.antenna_m - line.height_m;
        let nearest_m = if fall > 0.0 {
            ground_m * ((line.antenna_m - self.highest_m) / fall).max(0.0) - self.longest_m
        } else {
            0.0
        };
        let from = list.partition_point(|entry| entry.ground_m < nearest_m);
        let to = list.partition_point(|entry| entry.ground_m < ground_m + self.longest_m);
        let beside = move |entry: &&Occluder| {
            wrap_pi(entry.azimuth_rad - azimuth_rad).abs() <= entry.half_rad
        };
        list[from.min(to)..to].iter().filter(beside).map(|entry| entry.index as usize)
    }
}

/// Fuselage and fin of an aircraft as obstacles: corners and height of each.
///
/// The fuselage is a box of a tenth of the length in width and 45 % of the height over all; the fin
/// stands over the last eighth of the length. Shapes assumed after common layouts.
#[must_use]
pub fn aircraft_obstacles(
    place_m: Point2<f64>,
    heading_rad: f64,
    length_m: f64,
    height_m: f64,
) -> [([Point2<f64>; 4], f64); 2] {
    let (sin, cos) = libm::sincos(heading_rad);
    let (ahead, right) = (Vector2::new(sin, cos), Vector2::new(cos, -sin));
    let rectangle = |from: f64, to: f64, half: f64| {
        [(from, -half), (to, -half), (to, half), (from, half)]
            .map(|(x, y)| place_m + ahead * (x * length_m) + right * (y * length_m))
    };
    [(rectangle(-0.5, 0.5, 0.05), 0.45 * height_m), (rectangle(-0.5, -0.375, 0.005), height_m)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fin_of_an_aircraft_stands_over_its_tail() {
        let place = Point2::new(100.0, 200.0);
        // Corners are (east, north); an aircraft of 40 m that heads north, then east.
        let [(body, low_m), (fin, high_m)] = aircraft_obstacles(place, 0.0, 40.0, 12.0);
        assert!((low_m - 5.4).abs() < 1e-12 && high_m == 12.0);
        let reach = |corners: [Point2<f64>; 4], axis: usize| {
            let of = corners.map(|c| c[axis]);
            (of.into_iter().fold(f64::INFINITY, f64::min), of.into_iter().fold(-1e9, f64::max))
        };
        let near = |found: (f64, f64), low: f64, high: f64| {
            assert!((found.0 - low).abs() < 1e-9 && (found.1 - high).abs() < 1e-9, "{found:?}");
        };
        near(reach(body, 0), 98.0, 102.0);
        near(reach(body, 1), 180.0, 220.0);
        near(reach(fin, 0), 99.8, 100.2);
        near(reach(fin, 1), 180.0, 185.0);
        let [_, (fin, _)] = aircraft_obstacles(place, std::f64::consts::FRAC_PI_2, 40.0, 12.0);
        near(reach(fin, 0), 80.0, 85.0);
        near(reach(fin, 1), 199.8, 200.2);
    }

    #[test]
    fn a_place_is_inside_a_footprint_or_not() {
        let corner = |x: f64, y: f64| Point2::new(x, y);
        // An L: the square between its arms is outside.
        let footprint_m = vec![
            corner(0.0, 0.0),
            corner(30.0, 0.0),
            corner(30.0, 10.0),
            corner(10.0, 10.0),
            corner(10.0, 30.0),
            corner(0.0, 30.0),
        ];
        let facade = &MATERIALS[0];
        let hall = Building { name: "L".into(), footprint_m, height_m: 9.0, facade };
        for (x, y, inside) in [
            (5.0, 5.0, true),
            (25.0, 5.0, true),
            (5.0, 25.0, true),
            (20.0, 20.0, false),
            (-1.0, 5.0, false),
            (31.0, 5.0, false),
            (5.0, 31.0, false),
        ] {
            assert_eq!(hall.contains(corner(x, y)), inside, "{x} {y}");
        }
    }
    use crate::environment::surface::MATERIALS;

    fn line(east: f64, north: f64, height_m: f64) -> SightLine {
        SightLine {
            site_m: Point2::origin(),
            antenna_m: 30.0,
            target_m: Point2::new(east, north),
            height_m,
            wavelength_m: 0.0187,
        }
    }

    fn hangar() -> Building {
        let c = Point2::new;
        Building {
            name: "hangar".into(),
            footprint_m: vec![c(-50.0, 500.0), c(50.0, 500.0), c(50.0, 540.0), c(-50.0, 540.0)],
            height_m: 20.0,
            facade: &MATERIALS[0],
        }
    }

    #[test]
    fn a_building_hides_what_is_low_behind_it_and_nothing_else() {
        let hangar = hangar();
        let see = |e, n, h| line(e, n, h).behind(&hangar.footprint_m, hangar.height_m);
        assert!(see(0.0, 800.0, 2.0).blocked, "behind");
        assert!(see(0.0, 800.0, 2.0).loss_db > 20.0);
        assert_eq!(see(0.0, 450.0, 2.0), Obstruction::FREE, "before");
        assert_eq!(see(300.0, 800.0, 2.0), Obstruction::FREE, "beside");
        assert!(!see(0.0, 800.0, 40.0).blocked, "above");
        assert!(!see(0.0, 2500.0, 2.0).blocked || see(0.0, 2500.0, 2.0).loss_db > 6.0);
    }

    #[test]
    fn the_loss_grows_without_a_step_from_light_into_shadow() {
        let hangar = hangar();
        // Along the roof: the line over the far edge rises through the roof at 20 m.
        let mut before = 0.0;
        for i in 0..4000 {
            let height = 25.0 - f64::from(i) * 0.005;
            let loss = line(0.0, 800.0, height).behind(&hangar.footprint_m, 20.0).loss_db;
            assert!(loss - before > -1e-9 && loss - before < 0.4, "{height}: {before} {loss}");
            before = loss;
        }
        assert!(before > 15.0);
        // Round the corner: from beside it to behind it.
        let mut before = 0.0;
        for i in 0..4000 {
            let east = 95.0 - f64::from(i) * 0.005;
            let loss = line(east, 800.0, 2.0).behind(&hangar.footprint_m, 20.0).loss_db;
            assert!((loss - before).abs() < 0.5, "{east}: {before} {loss}");
            before = loss;
        }
        assert!(before > 15.0);
    }

    #[test]
    fn the_skyline_finds_every_building_that_obstructs() {
        let hangar = hangar();
        let buildings = [hangar.clone()];
        let skyline = Skyline::new(&buildings, Point2::origin());
        for i in 0..2000 {
            let (sin, cos) = libm::sincos(f64::from(i) * 0.003_141_5);
            let line = line(900.0 * sin, 900.0 * cos, 2.0);
            let found = skyline
                .before(crate::frames::Azimuth::of(line.target_m.coords).rad(), 900.0)
                .count();
            let obstruction = line.behind(&hangar.footprint_m, hangar.height_m);
            assert!(found == 1 || obstruction == Obstruction::FREE, "{i}");
        }
        let beside: usize =
            (0..2000).map(|i| skyline.before(f64::from(i) * 0.003_141_5, 900.0).count()).sum();
        assert!(beside < 200, "{beside} of 2000 directions are tested");
    }

    #[test]
    fn knife_edges_are_finite_at_their_ends() {
        for (name, h, d1, d2) in [
            ("edge at the target", 1.0, 1000.0, 0.0),
            ("edge at the radar", 1.0, 0.0, 1000.0),
            ("far above", 1e6, 1.0, 1.0),
            ("far below", -1e6, 1.0, 1.0),
        ] {
            let v = knife_edge_parameter(h, d1, d2, 0.0187);
            for loss in [knife_edge_db(v), knife_edge_exact_db(v)] {
                assert!(loss.is_finite(), "{name}: {loss}");
            }
        }
    }
}
