//! Where the direct and the reflected ray run, over a flat plane and over a round earth.

/// Effective earth radius for standard refraction, m: 4/3 of 6371 km (Blake; Kerr).
pub const EFFECTIVE_EARTH_RADIUS_M: f64 = 4.0 / 3.0 * 6_371_000.0;

/// The two paths between an antenna and a scatterer over a flat reflecting plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoPaths {
    /// Direct slant range, m.
    pub direct_m: f64,
    /// Length of the reflected leg, m.
    pub reflected_m: f64,
    /// Reflected minus direct, m.
    pub difference_m: f64,
    /// Grazing angle at the reflection point, which is also its depression, rad.
    pub grazing_rad: f64,
    /// Depression of the scatterer from the antenna, rad, positive downwards.
    pub depression_rad: f64,
    /// Ground range of the reflection point, m.
    pub reflection_point_m: f64,
}

impl TwoPaths {
    /// Paths over a flat plane at ground distance `d_m`; heights in metres, all zero or positive.
    ///
    /// The difference is `4·h_a·h_t/(R_r + R)`: subtracting the lengths loses every digit at small heights.
    #[must_use]
    pub fn flat(d_m: f64, antenna_m: f64, target_m: f64) -> Self {
        let (down, up) = (antenna_m - target_m, antenna_m + target_m);
        let lean = LeanPaths::flat(d_m, antenna_m, target_m);
        Self {
            direct_m: lean.direct_m,
            reflected_m: lean.reflected_m,
            difference_m: lean.difference_m,
            grazing_rad: libm::atan2(up, d_m),
            depression_rad: libm::atan2(down, d_m),
            reflection_point_m: if up > 0.0 { d_m * antenna_m / up } else { 0.5 * d_m },
        }
    }
}

/// `√(x² + y²)`: directly where no square can overflow or lose its digits, else with scaling.
fn hypotenuse(x: f64, y: f64) -> f64 {
    let square = x * x + y * y;
    if square > 1e-200 && square < 1e200 { square.sqrt() } else { libm::hypot(x, y) }
}

/// The same paths as a budget asks for them: by the sines of the angles only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeanPaths {
    /// Direct slant range, m.
    pub direct_m: f64,
    /// Length of the reflected leg, m.
    pub reflected_m: f64,
    /// Sine of the depression of the scatterer.
    pub sin_depression: f64,
    /// Reflected minus direct, m.
    pub difference_m: f64,
    /// Sine of the grazing angle.
    pub sin_grazing: f64,
    /// Its cosine.
    pub cos_grazing: f64,
}

impl LeanPaths {
    /// Paths over a flat plane at ground distance `d_m`; heights in metres, all zero or positive.
    #[must_use]
    pub fn flat(d_m: f64, antenna_m: f64, target_m: f64) -> Self {
        let (down, up) = (antenna_m - target_m, antenna_m + target_m);
        let direct_m = hypotenuse(d_m, down);
        let reflected_m = hypotenuse(d_m, up);
        let sum = direct_m + reflected_m;
        // At the foot of the mast itself there is no direction: straight down.
        let (sin_depression, sin_grazing, cos_grazing) = if direct_m > 0.0 && reflected_m > 0.0 {
            (down / direct_m, up / reflected_m, d_m / reflected_m)
        } else {
            (1.0, 1.0, 0.0)
        };
        let difference_m = if sum > 0.0 { 4.0 * antenna_m * target_m / sum } else { 0.0 };
        Self { direct_m, reflected_m, sin_depression, difference_m, sin_grazing, cos_grazing }
    }
}

/// The reflection over a round earth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundEarth {
    /// Ground range of the reflection point, m.
    pub reflection_point_m: f64,
    /// Antenna height above the plane that touches the earth there, m.
    pub antenna_m: f64,
    /// Scatterer height above that plane, m.
    pub target_m: f64,
    /// Path difference, m.
    pub difference_m: f64,
    /// Grazing angle, rad.
    pub grazing_rad: f64,
    /// Divergence factor on the amplitude, at most 1.
    pub divergence: f64,
}

impl RoundEarth {
    /// Reflection point by the closed solution of the cubic; flat formulas below 10 m.
    ///
    /// Source: Kerr, *Propagation of Short Radio Waves*, ch. 5; Blake, *Radar Range-Performance Analysis*.
    /// Beyond the horizon (a height below the tangent plane) the reflected ray does not exist: the
    /// heights are then zero and so is the divergence.
    #[must_use]
    pub fn new(d_m: f64, antenna_m: f64, target_m: f64) -> Self {
        let tangent = Tangent::new(d_m, antenna_m, target_m);
        let flat = TwoPaths::flat(d_m, tangent.antenna_m, tangent.target_m);
        Self {
            reflection_point_m: tangent.reflection_point_m.unwrap_or(flat.reflection_point_m),
            antenna_m: tangent.antenna_m,
            target_m: tangent.target_m,
            difference_m: flat.difference_m,
            grazing_rad: flat.grazing_rad,
            divergence: tangent.divergence(d_m, libm::sin(flat.grazing_rad)),
        }
    }

    /// The paths of a budget over a round earth, and the divergence.
    #[must_use]
    pub fn lean(d_m: f64, antenna_m: f64, target_m: f64) -> (LeanPaths, f64) {
        let tangent = Tangent::new(d_m, antenna_m, target_m);
        let flat = LeanPaths::flat(d_m, tangent.antenna_m, tangent.target_m);
        (flat, tangent.divergence(d_m, flat.sin_grazing))
    }
}

/// The plane that touches the earth at the reflection point, and the heights above it.
struct Tangent {
    /// `None` where the earth counts as flat.
    reflection_point_m: Option<f64>,
    antenna_m: f64,
    target_m: f64,
}

impl Tangent {
    fn new(d_m: f64, antenna_m: f64, target_m: f64) -> Self {
        if d_m < 10.0 {
            return Self { reflection_point_m: None, antenna_m, target_m };
        }
        let a = EFFECTIVE_EARTH_RADIUS_M;
        let half = 0.5 * d_m;
        let p = 2.0 / 3f64.sqrt() * (a * (antenna_m + target_m) + half * half).sqrt();
        let sine = (2.0 * a * d_m * (target_m - antenna_m) / (p * p * p)).clamp(-1.0, 1.0);
        let d1 = half - p * libm::sin(libm::asin(sine) / 3.0);
        let d2 = d_m - d1;
        Self {
            reflection_point_m: Some(d1),
            antenna_m: (antenna_m - d1 * d1 / (2.0 * a)).max(0.0),
            target_m: (target_m - d2 * d2 / (2.0 * a)).max(0.0),
        }
    }

    /// `1/√(1 + 2·d₁·d₂/(a·d·sin ψ))`; 1 over a flat earth, 0 where no ray arrives.
    fn divergence(&self, d_m: f64, sin_grazing: f64) -> f64 {
        let Some(d1) = self.reflection_point_m else { return 1.0 };
        if sin_grazing <= 0.0 {
            return 0.0;
        }
        let along = 2.0 * d1 * (d_m - d1) / (EFFECTIVE_EARTH_RADIUS_M * d_m * sin_grazing);
        1.0 / (1.0 + along).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn over_a_plane_the_reflected_ray_is_that_from_the_image_of_the_antenna() {
        for (d, antenna, target) in
            [(300.0, 30.0, 5.0), (5_000.0, 20.0, 40.0), (0.5, 30.0, 2.0), (800.0, 10.0, 0.0)]
        {
            let paths = TwoPaths::flat(d, antenna, target);
            let lean = LeanPaths::flat(d, antenna, target);
            let (direct, reflected) =
                (libm::hypot(d, antenna - target), libm::hypot(d, antenna + target));
            let close =
                |a: f64, b: f64| assert!((a - b).abs() < 1e-9 * (1.0 + b.abs()), "{a} for {b}");
            for (found, expected) in [
                (paths.direct_m, direct),
                (paths.reflected_m, reflected),
                (paths.difference_m, reflected - direct),
                (lean.sin_depression, libm::sin(paths.depression_rad)),
                (lean.sin_grazing, libm::sin(paths.grazing_rad)),
                (lean.cos_grazing, libm::cos(paths.grazing_rad)),
                (libm::tan(paths.grazing_rad), (antenna + target) / d),
                (libm::tan(paths.depression_rad), (antenna - target) / d),
                // Equal angles on both sides.
                (antenna * (d - paths.reflection_point_m), target * paths.reflection_point_m),
            ] {
                close(found, expected);
            }
        }
        // At the antenna, at the foot of its mast, and on the ground.
        let at = LeanPaths::flat(0.0, 30.0, 30.0);
        assert_eq!(
            (at.direct_m, at.sin_depression, at.sin_grazing, at.cos_grazing),
            (0.0, 1.0, 1.0, 0.0)
        );
        let foot = LeanPaths::flat(0.0, 30.0, 0.0);
        assert_eq!((foot.sin_depression, foot.sin_grazing, foot.difference_m), (1.0, 1.0, 0.0));
        let nowhere = LeanPaths::flat(0.0, 0.0, 0.0);
        assert_eq!((nowhere.sin_depression, nowhere.difference_m), (1.0, 0.0));
        assert_eq!(TwoPaths::flat(40.0, 0.0, 0.0).reflection_point_m, 20.0);
        for side in [1e-180, 1e180] {
            assert!(
                (LeanPaths::flat(3.0 * side, 4.0 * side, 0.0).direct_m / (5.0 * side) - 1.0).abs()
                    < 1e-12
            );
        }
    }

    #[test]
    fn over_the_earth_both_rays_make_the_same_angle_with_the_plane_that_touches_it() {
        let a = EFFECTIVE_EARTH_RADIUS_M;
        for (d, antenna, target) in [
            (5_000.0, 30.0, 5.0),
            (20_000.0, 40.0, 40.0),
            (12_000.0, 20.0, 60.0),
            (15_000.0, 30.0, 3.0),
        ] {
            let round = RoundEarth::new(d, antenna, target);
            let (d1, d2) = (round.reflection_point_m, d - round.reflection_point_m);
            // The earth falls away by d²/2a.
            let (h1, h2) = (antenna - d1 * d1 / (2.0 * a), target - d2 * d2 / (2.0 * a));
            assert!(
                (round.antenna_m - h1).abs() < 1e-9 && (round.target_m - h2.max(0.0)).abs() < 1e-9
            );
            if h1 > 0.0 && h2 > 0.0 {
                assert!((h1 / d1 - h2 / d2).abs() < 1e-9 * (h1 / d1), "{d}: {h1} {d1} {h2} {d2}");
            }
            let sine = libm::sin(round.grazing_rad);
            let spread = 1.0 / (1.0 + 2.0 * d1 * d2 / (a * d * sine)).sqrt();
            assert!((round.divergence - spread).abs() < 1e-12, "{d}: {}", round.divergence);
            assert!(round.divergence > 0.2 && round.divergence < 1.0);
            let (lean, divergence) = RoundEarth::lean(d, antenna, target);
            assert!((divergence - spread).abs() < 1e-9 && (lean.sin_grazing - sine).abs() < 1e-9);
        }
        // Nearby it is flat, beyond the horizon no ray arrives.
        let near = RoundEarth::new(9.9, 30.0, 5.0);
        assert_eq!((near.divergence, near.antenna_m, near.target_m), (1.0, 30.0, 5.0));
        assert_eq!(near.reflection_point_m, TwoPaths::flat(9.9, 30.0, 5.0).reflection_point_m);
        let far = RoundEarth::new(90_000.0, 10.0, 2.0);
        assert_eq!((far.divergence, far.antenna_m, far.target_m), (0.0, 0.0, 0.0));
    }
}
