//! The cells of a picture against the budget of a target there, and its walls against finer ones.

use super::*;
use crate::environment::RainCell;
use crate::environment::surface::MATERIALS;
use crate::frames::Vector2;
use crate::sensors::asde::picture::{Clutter, EvenGround, Obstacle};
use crate::sensors::radar::ghost::facade_reflection;
use crate::sensors::radar::shadow::{SightLine, aircraft_obstacles};

fn hall(corners: [Pair; 4], height_m: f64) -> Building {
    let footprint_m = corners.map(|(x, y)| Point2::new(x, y)).to_vec();
    Building { name: "hall".into(), footprint_m, height_m, facade: &MATERIALS[5] }
}

fn low_radar() -> Asde {
    asde(|p| (p.antenna_height_m, p.range_min_m, p.range_max_m) = (30.0, 100.0, 2500.0))
}

/// Rain and ground of each cell are what plot level reckons with for a target there; the ground lies in the shadow of all before it.
#[test]
fn cells_have_the_clutter_of_a_budget_and_the_shadows_of_all_that_stands_before_them() {
    let buildings = [
        hall([(-60.0, 400.0), (60.0, 400.0), (60.0, 430.0), (-60.0, 430.0)], 18.0),
        hall([(300.0, -90.0), (300.0, -40.0), (280.0, -40.0), (280.0, -90.0)], 12.0),
    ];
    let class = crate::sensors::testing::class(true, 40.0, 36.0, 15.0);
    let parked = [((-260.0, 40.0), 0.4), ((350.0, 320.0), 2.0)].map(|((x, y), heading_rad)| {
        let position_m = Point3::new(x, y, 0.0);
        TargetState { position_m, velocity_mps: Vector3::zeros(), heading_rad }
    });
    let cell = |x: f64, y: f64, radius_m: f64| RainCell {
        centre_m: Point2::new(x, y),
        radius_m,
        rain_mm_per_h: 60.0,
    };
    let wet = Weather { rain_mm_per_h: 12.0, film_mm: 0.3, ..Weather::default() };
    let cells = vec![cell(700.0, 500.0, 300.0), cell(-900.0, -300.0, 400.0)];
    let showers = Weather { rain_mm_per_h: 1.0, cells, ..Weather::default() };
    let exact = RadarLevels::EXACT;
    let open = exact
        .with(RadarEffect::BuildingShadow, Level::Skipped)
        .with(RadarEffect::AircraftShadow, Level::Skipped);
    let bare = exact.with(RadarEffect::GroundClutter, Level::Skipped);
    for (weather, levels) in
        [(Weather::default(), exact), (wet.clone(), open), (showers, exact), (wet, bare)]
    {
        let radar = low_radar().among(buildings.to_vec().into()).at_levels(levels);
        let air = radar.radar.air(&weather);
        let aircraft: Vec<Obstacle> =
            parked.iter().filter_map(|s| Obstacle::of(&class, s, radar.site_m)).collect();
        assert_eq!(aircraft.len(), 2);
        let clutter = Clutter::new(&radar, &air, &levels, &EvenGround, false, aircraft);
        let mut row = vec![0.0; radar.grid.cells];
        let (mut dark, mut light) = (0, 0);
        for beam in (0..radar.grid.beams).step_by(7) {
            clutter.fill(beam, &mut row);
            let (sin, cos) = libm::sincos((beam as f64 + 0.5) * radar.grid.beam_step_rad());
            for (cell, found) in row.iter().enumerate().step_by(11) {
                let range_m = radar.grid.cell_centre_m(cell as i64);
                let ground_m = (range_m * range_m - 900.0).sqrt();
                let place = Point2::new(sin, cos) * ground_m;
                let echo = Echo { ground_m, height_m: 0.0, extent_m: 0.0, rcs_m2: 1.0 };
                let budget = radar.radar.budget(&air, &levels.budget, &echo, radar.site_m, place);
                let line = SightLine {
                    site_m: radar.site_m,
                    antenna_m: 30.0,
                    target_m: place,
                    height_m: 0.0,
                    wavelength_m: radar.radar.wavelength_m,
                };
                let by_halls: f64 =
                    buildings.iter().map(|b| line.behind(&b.footprint_m, b.height_m).loss_db).sum();
                let by_aircraft = |state: &TargetState| {
                    let at = state.position_m.xy();
                    aircraft_obstacles(at, state.heading_rad, 40.0, class.height_m)
                        .iter()
                        .map(|(corners, top_m)| line.behind(corners, *top_m).loss_db)
                        .fold(0.0, f64::max)
                };
                let by_aircraft: f64 = parked.iter().map(by_aircraft).sum();
                // Half-lit margins of what aircraft shadow are left open.
                let shadow_db = if levels == open { 0.0 } else { by_halls + by_aircraft };
                if levels != open && by_aircraft > 0.0 && by_aircraft < 6.5 {
                    continue;
                }
                let over_noise = (budget.rain_w * radar.rain_correlation
                    + budget.ground_w * from_db(-2.0 * shadow_db)
                    + budget.other_w)
                    / budget.noise_w;
                assert!(
                    (found - 1.0 - over_noise).abs() <= 0.03 * over_noise,
                    "{beam} {cell}: {found}, not 1 + {over_noise}, {shadow_db} dB"
                );
                if shadow_db > 6.5 { dark += 1 } else { light += 1 }
            }
        }
        assert!(light > 3_000 && (dark > 60 || levels == open), "{dark} {light}");
    }
}

/// A wall returns as much as the sum over much finer pieces of it, from where it is; what is hidden or turned away returns nothing.
#[test]
fn walls_return_what_their_parts_do() {
    let near = hall([(-60.0, 400.0), (60.0, 400.0), (80.0, 430.0), (-60.0, 430.0)], 18.0);
    let mut turned = near.clone();
    turned.footprint_m.reverse();
    let beside = hall([(300.0, -90.0), (320.0, -40.0), (280.0, -30.0), (260.0, -80.0)], 12.0);
    let behind = hall([(-20.0, 480.0), (20.0, 480.0), (20.0, 500.0), (-20.0, 500.0)], 6.0);
    let free = [near.clone(), beside.clone()];
    for buildings in [vec![near.clone(), behind, beside.clone()], vec![beside, turned]] {
        let mut radar = low_radar().among(buildings.into());
        let air = radar.radar.air(&Weather::default());
        let found = radar.walls(&air);
        let mut wanted = Vec::new();
        for building in &free {
            let gamma = facade_reflection(building.facade, radar.radar.carrier_ghz);
            let n = building.footprint_m.len() as f64;
            let middle = building.footprint_m.iter().map(|c| c.coords).sum::<Vector2<f64>>() / n;
            for (a, b) in building.walls() {
                for k in 0..2_000 {
                    let place = a + (b - a) * ((f64::from(k) + 0.5) / 2_000.0);
                    let mut out = Vector2::new(b.y - a.y, a.x - b.x).normalize();
                    if out.dot(&(place.coords - middle)) < 0.0 {
                        out = -out;
                    }
                    let ground_m = place.coords.norm();
                    let cos = -out.dot(&place.coords) / ground_m;
                    if cos <= 0.0 {
                        continue;
                    }
                    let height_m = building.height_m;
                    let area_m2 = (b - a).norm() / 2_000.0 * height_m;
                    let echo = Echo {
                        ground_m,
                        height_m: 0.5 * height_m,
                        extent_m: height_m,
                        rcs_m2: 4.0 * (gamma * cos) * (gamma * cos) * area_m2,
                    };
                    let levels = BudgetLevels::EXACT;
                    let budget = radar.radar.budget(&air, &levels, &echo, radar.site_m, place);
                    let azimuth_rad = libm::atan2(place.x, place.y);
                    wanted.push((azimuth_rad, budget.range_m, budget.snr()));
                }
            }
        }
        let found: Vec<(f64, f64, f64)> =
            found.iter().map(|e| (wrap_pi(e.azimuth_rad), e.range_m, e.snr)).collect();
        for (name, azimuth) in [("before it", (-0.3, 0.3)), ("beside it", (1.5, 2.2))] {
            let sums = |points: &[(f64, f64, f64)]| {
                let inside = points.iter().filter(|p| p.0 >= azimuth.0 && p.0 <= azimuth.1);
                inside.fold([0.0; 3], |s, p| [s[0] + p.2, s[1] + p.2 * p.0, s[2] + p.2 * p.1])
            };
            let (found, wanted) = (sums(&found), sums(&wanted));
            assert!((found[0] / wanted[0] - 1.0).abs() < 0.02, "{name}: {found:?} {wanted:?}");
            let at = |s: [f64; 3]| (s[1] / s[0], s[2] / s[0]);
            let ((azimuth, range_m), (azimuth_2, range_2_m)) = (at(found), at(wanted));
            assert!((azimuth - azimuth_2).abs() < 2e-3, "{name}: {azimuth} {azimuth_2}");
            assert!((range_m - range_2_m).abs() < 0.5, "{name}: {range_m} {range_2_m}");
        }
        let elsewhere = found.iter().filter(|p| {
            !wanted.iter().any(|w| (w.0 - p.0).abs() < 0.01 && (w.1 - p.1).abs() < 3.0)
        });
        assert_eq!(elsewhere.count(), 0, "hidden, or turned away");
    }
}
