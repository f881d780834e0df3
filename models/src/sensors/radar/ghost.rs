//! Ghosts: echoes by way of a facade that acts as a mirror.

use crate::environment::surface::{Fresnel, Material, modulus};
use crate::frames::{Point2, Vector2, center};
use crate::sensors::radar::shadow::Building;
use std::f64::consts::FRAC_PI_2;

/// Amplitude that a facade reflects at normal incidence: 1 for metal, about 0.4 for concrete.
#[must_use]
pub fn facade_reflection(facade: &Material, carrier_ghz: f64) -> f64 {
    modulus(Fresnel::half_space(facade.permittivity(carrier_ghz), FRAC_PI_2).horizontal)
}

/// A wall that may mirror towards one radar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facade {
    from_m: Point2<f64>,
    to_m: Point2<f64>,
    height_m: f64,
    /// Mirror image of the radar in the wall's plane.
    image_m: Point2<f64>,
    /// Unit vector out of the building.
    outward: Vector2<f64>,
    /// Amplitude reflected.
    reflection: f64,
}

/// Power of the ghosts of a target in a facade against its direct echo: by the mixed path and by the
/// double bounce.
///
/// `reflection` is the facade's amplitude, `direct_m` and `image_m` the direct way and that by the facade,
/// `beside` the beam's one-way gain between the directions of target and facade.
#[must_use]
pub fn ghost_power(reflection: f64, direct_m: f64, image_m: f64, beside: f64) -> (f64, f64) {
    // Amplitude² of one reflection, and of the other way being longer.
    let once = reflection * reflection;
    let spread = (direct_m / image_m) * (direct_m / image_m);
    // Both orders of the mixed path arrive together: amplitudes add.
    (4.0 * once * spread * beside, once * once * spread * spread)
}

/// One reflection of a target at a facade.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ghost {
    /// Where the ray meets the facade, airport frame, m.
    pub point_m: Point2<f64>,
    /// Length of the way radar, facade, target, m (slant).
    pub path_m: f64,
    /// Amplitude that the facade reflects.
    pub reflection: f64,
}

/// The facades of all buildings that face a radar at `site_m`.
#[must_use]
pub fn facades(buildings: &[Building], site_m: Point2<f64>, carrier_ghz: f64) -> Vec<Facade> {
    let mut out = Vec::new();
    for building in buildings {
        let reflection = facade_reflection(building.facade, carrier_ghz);
        // Positive where the corners run anticlockwise: the outside is then on the right of a wall.
        let turning: f64 = building.walls().map(|(a, b)| a.coords.perp(&b.coords)).sum();
        for (from_m, to_m) in building.walls() {
            let along = to_m - from_m;
            let length = along.norm();
            if length == 0.0 {
                continue;
            }
            let right = Vector2::new(along.y, -along.x) / length;
            let outward = if turning > 0.0 { right } else { -right };
            let before = (site_m - from_m).dot(&outward);
            if before > 0.0 {
                let image_m = site_m - outward * (2.0 * before);
                let height_m = building.height_m;
                out.push(Facade { from_m, to_m, height_m, image_m, outward, reflection });
            }
        }
    }
    out
}

impl Facade {
    /// Amplitude that it reflects.
    #[must_use]
    pub fn reflection(&self) -> f64 {
        self.reflection
    }

    /// Whether a target within `radius_m` of a place may be mirrored: whether that circle touches the
    /// wedge before the wall that is seen from the radar's image through it. `margin_m` is by how much the
    /// specular point may lie beside the wall.
    #[must_use]
    pub fn may_mirror(&self, place_m: Point2<f64>, radius_m: f64, margin_m: f64) -> bool {
        let along = (self.to_m - self.from_m).normalize();
        let (from_m, to_m) = (self.from_m - along * margin_m, self.to_m + along * margin_m);
        let offset = place_m - self.image_m;
        if (place_m - self.from_m).dot(&self.outward) < -radius_m {
            return false;
        }
        // Signed distances from the two rays of the wedge, positive inside.
        let inside = |edge: Point2<f64>, middle: Point2<f64>| {
            let ray = (edge - self.image_m).normalize();
            let side = ray.perp(&(middle - self.image_m)).signum();
            side * ray.perp(&offset)
        };
        let middle = center(&from_m, &to_m);
        inside(from_m, middle) >= -radius_m && inside(to_m, middle) >= -radius_m
    }

    /// The ghost of a target in this facade, if the specular point lies on it, within the Fresnel zone
    /// `√(λs/2)` of its ends, and below its roof.
    #[must_use]
    pub fn ghost(
        &self,
        antenna_m: f64,
        target_m: Point2<f64>,
        height_m: f64,
        wavelength_m: f64,
    ) -> Option<Ghost> {
        let before = (target_m - self.from_m).dot(&self.outward);
        if before <= 0.0 {
            return None;
        }
        let behind = (self.from_m - self.image_m).dot(&self.outward);
        let share = behind / (behind + before);
        let point_m = self.image_m + (target_m - self.image_m) * share;
        let along = self.to_m - self.from_m;
        let length = along.norm();
        let place = (point_m - self.from_m).dot(&along) / length;
        let ground_m = (target_m - self.image_m).norm();
        let margin = (0.5 * wavelength_m * (1.0 - share) * ground_m).sqrt();
        if place < -margin || place > length + margin {
            return None;
        }
        let height_at_wall = antenna_m + (height_m - antenna_m) * share;
        if height_at_wall > self.height_m || height_at_wall < 0.0 {
            return None;
        }
        let down = antenna_m - height_m;
        let path_m = libm::hypot(ground_m, down);
        Some(Ghost { point_m, path_m, reflection: self.reflection })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::surface::MATERIALS;

    fn hangar() -> Building {
        let corner = Point2::new;
        Building {
            name: "hangar".into(),
            footprint_m: vec![
                corner(-50.0, 1000.0),
                corner(50.0, 1000.0),
                corner(50.0, 1040.0),
                corner(-50.0, 1040.0),
            ],
            height_m: 20.0,
            facade: &MATERIALS[5],
        }
    }

    #[test]
    fn only_walls_that_face_the_radar_mirror_it() {
        let found = facades(&[hangar()], Point2::origin(), 16.0);
        assert_eq!(found.len(), 1);
        assert!((found[0].image_m - Point2::new(0.0, 2000.0)).norm() < 1e-9);
        assert!((found[0].reflection - 1.0).abs() < 1e-2);
        let clockwise =
            Building { footprint_m: hangar().footprint_m.into_iter().rev().collect(), ..hangar() };
        assert_eq!(facades(&[clockwise], Point2::origin(), 16.0).len(), 1);
    }

    #[test]
    fn the_specular_point_is_half_way_for_equal_distances() {
        let facade = facades(&[hangar()], Point2::origin(), 16.0)[0];
        let ghost = facade.ghost(10.0, Point2::new(60.0, 0.0), 2.0, 0.019).expect("on the wall");
        assert!((ghost.point_m - Point2::new(30.0, 1000.0)).norm() < 1e-9);
        assert!((ghost.path_m - libm::hypot(libm::hypot(60.0, 2000.0), 8.0)).abs() < 1e-9);
        assert_eq!(facade.ghost(10.0, Point2::new(160.0, 0.0), 2.0, 0.019), None, "beside it");
        assert_eq!(facade.ghost(10.0, Point2::new(0.0, 1200.0), 2.0, 0.019), None, "behind it");
        assert_eq!(facade.ghost(100.0, Point2::new(60.0, 0.0), 2.0, 0.019), None, "over the roof");
    }
}
