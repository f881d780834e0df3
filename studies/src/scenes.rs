//! Single-target scenes: exact truth, and the plots of one radar.

use models::draw::{DrawKey, Purpose};
use models::filter::route::Route;
use models::frames::{Azimuth, Point2, Vector2};
use models::plot::{Plot, Polar, SensorId, SensorKind, polar_to_cartesian};
use models::time::SimTime;
use rand_distr::{Distribution, StandardNormal};

/// A piece of a path at constant tangential acceleration and constant curvature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Duration, s.
    pub duration_s: f64,
    /// Acceleration along the path, m/s².
    pub acceleration_ms2: f64,
    /// Curvature, 1/m, positive to the left.
    pub curvature: f64,
    /// Turn on the spot before the leg, radians to the left.
    pub corner_rad: f64,
}

impl Leg {
    /// A straight leg.
    #[must_use]
    pub fn straight(duration_s: f64, acceleration_ms2: f64) -> Self {
        Self { duration_s, acceleration_ms2, curvature: 0.0, corner_rad: 0.0 }
    }
    /// A turn at constant speed: `angle_rad` to the left with `radius_m`, at `speed_mps`.
    #[must_use]
    pub fn turn(angle_rad: f64, radius_m: f64, speed_mps: f64) -> Self {
        Self {
            duration_s: angle_rad.abs() * radius_m / speed_mps,
            acceleration_ms2: 0.0,
            curvature: angle_rad.signum() / radius_m,
            corner_rad: 0.0,
        }
    }
}

/// A target's path: legs from a start at rest or in motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Name in the report.
    pub name: &'static str,
    /// One line for people.
    pub about: &'static str,
    /// Speed at t = 0, m/s; the path starts at the origin towards +x.
    pub speed_mps: f64,
    /// The legs.
    pub legs: Vec<Leg>,
    /// Plots at 0, 1, … s.
    pub samples: usize,
}

/// True state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruePoint {
    /// Position, m.
    pub position_m: Point2<f64>,
    /// Direction of motion, radians from +x to the left.
    pub course_rad: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Path length since the start, m.
    pub along_m: f64,
}

impl Scene {
    /// The state at `t` seconds; beyond the last leg straight on.
    #[must_use]
    pub fn at(&self, t: f64) -> TruePoint {
        let mut point = TruePoint {
            position_m: Point2::origin(),
            course_rad: 0.0,
            speed_mps: self.speed_mps,
            along_m: 0.0,
        };
        let mut left = t;
        let last = self.legs.len().saturating_sub(1);
        for (k, leg) in self.legs.iter().enumerate() {
            let duration = if k == last { left } else { leg.duration_s.min(left) };
            point = advance(&point, leg, duration);
            left -= duration;
            if left <= 0.0 {
                break;
            }
        }
        point
    }

    /// The centreline that the target follows exactly.
    #[must_use]
    pub fn route(&self) -> Route {
        let mut route = Route::from_course(Point2::origin(), 0.0);
        let (mut before, mut time) = (self.at(0.0), 0.0);
        let end = self.samples as f64 + 60.0;
        for leg in &self.legs {
            time += leg.duration_s.min(end - time);
            let after = self.at(time);
            let length = after.along_m - before.along_m;
            before = after;
            if length <= 0.0 {
                continue;
            }
            route = if leg.curvature == 0.0 {
                route.line(length, leg.corner_rad)
            } else {
                route.arc(length * leg.curvature, 1.0 / leg.curvature.abs())
            };
        }
        route
    }

    /// Times at which a leg ends, s.
    #[must_use]
    pub fn switches_s(&self) -> Vec<f64> {
        let ends = self.legs.iter().scan(0.0, |t, leg| {
            *t += leg.duration_s;
            Some(*t)
        });
        ends.take(self.legs.len().saturating_sub(1)).collect()
    }

    /// Braking from 300 to 70 km/h with 2 m/s², then 60° to the left in no time: about 2 g, which no
    /// aircraft does. The stress scene.
    #[must_use]
    pub fn landing() -> Self {
        let (v0, v1) = (300.0 / 3.6, 70.0 / 3.6);
        let mut after = Leg::straight(1e9, 0.0);
        after.corner_rad = 60f64.to_radians();
        Self {
            name: "landing",
            about: "braking from 300 to 70 km/h at 2 m/s², then a 60° corner in no time (2 g: a stress test)",
            speed_mps: v0,
            legs: vec![Leg::straight((v0 - v1) / 2.0, -2.0), after],
            samples: 62,
        }
    }

    /// The same with an arc of 150 m instead of the corner (2.5 m/s² to the side).
    #[must_use]
    pub fn landing_arc() -> Self {
        let (v0, v1) = (300.0 / 3.6, 70.0 / 3.6);
        Self {
            name: "landing_arc",
            about: "the same, the corner replaced by a 150 m arc that an aircraft can roll",
            speed_mps: v0,
            legs: vec![
                Leg::straight((v0 - v1) / 2.0, -2.0),
                Leg::turn(60f64.to_radians(), 150.0, v1),
                Leg::straight(1e9, 0.0),
            ],
            samples: 62,
        }
    }

    /// 2 m/s² from rest for 40 s.
    #[must_use]
    pub fn takeoff() -> Self {
        Self {
            name: "takeoff",
            about: "2 m/s² from rest for 40 s",
            speed_mps: 0.0,
            legs: vec![Leg::straight(1e9, 2.0)],
            samples: 41,
        }
    }

    /// A departure queue: three moves of 60 m with stops of 25 s.
    #[must_use]
    pub fn queue() -> Self {
        let move_up = [
            Leg::straight(25.0, 0.0),
            Leg::straight(6.0, 1.0),
            Leg::straight(6.0, 0.0),
            Leg::straight(4.0, -1.5),
        ];
        let legs = std::iter::repeat_n(move_up, 3).flatten().chain([Leg::straight(1e9, 0.0)]);
        Self {
            name: "queue",
            about: "stop and go: three moves of 66 m at up to 6 m/s, 25 s of standing between them",
            speed_mps: 0.0,
            legs: legs.collect(),
            samples: 150,
        }
    }

    /// Taxiing at 10 m/s through a turn of 90° with 60 m.
    #[must_use]
    pub fn outage() -> Self {
        Self {
            name: "outage",
            about: "taxiing at 10 m/s through a 90° turn with no plots from 26 s to 33 s",
            speed_mps: 10.0,
            legs: vec![
                Leg::straight(22.0, 0.0),
                Leg::turn(90f64.to_radians(), 60.0, 10.0),
                Leg::straight(1e9, 0.0),
            ],
            samples: 60,
        }
    }

    /// The scenes of the report, in its order.
    #[must_use]
    pub fn reported() -> Vec<Self> {
        vec![Self::landing(), Self::landing_arc(), Self::takeoff(), Self::queue()]
    }

    /// For tuning only, never reported: a high-speed exit, a taxiway with two turns, a stop.
    #[must_use]
    pub fn tuning() -> Vec<Self> {
        let exit = Self {
            name: "tune_exit",
            about: "runway, exit at 30° with 400 m at 25 m/s, braking to taxi speed, 90° turn",
            speed_mps: 70.0,
            legs: vec![
                Leg::straight(18.0, -2.5),
                Leg::turn(30f64.to_radians(), 400.0, 25.0),
                Leg::straight(10.0, -1.5),
                Leg::straight(8.0, 0.0),
                Leg::turn(90f64.to_radians(), 50.0, 10.0),
                Leg::straight(1e9, 0.0),
            ],
            samples: 70,
        };
        let taxi = Self {
            name: "tune_taxi",
            about: "taxiing at 12 m/s with two turns and a hold",
            speed_mps: 12.0,
            legs: vec![
                Leg::straight(20.0, 0.0),
                Leg::turn(-90f64.to_radians(), 60.0, 12.0),
                Leg::straight(15.0, 0.0),
                Leg::straight(10.0, -1.2),
                Leg::straight(12.0, 0.0),
                Leg::straight(8.0, 1.0),
                Leg::turn(60f64.to_radians(), 40.0, 8.0),
                Leg::straight(1e9, 0.0),
            ],
            samples: 90,
        };
        let roll = Self {
            name: "tune_roll",
            about: "line-up, hold, take-off at 2.5 m/s²",
            speed_mps: 6.0,
            legs: vec![Leg::straight(6.0, -1.0), Leg::straight(10.0, 0.0), Leg::straight(1e9, 2.5)],
            samples: 50,
        };
        vec![exit, taxi, roll]
    }
}

/// Exact motion over `t` seconds of a leg: straight lines and circular arcs.
fn advance(from: &TruePoint, leg: &Leg, t: f64) -> TruePoint {
    let along = from.speed_mps * t + 0.5 * leg.acceleration_ms2 * t * t;
    let course = from.course_rad + leg.corner_rad;
    let turned = leg.curvature * along;
    // Chord of an arc: length · sinc(turned/2), at half the turn.
    let half = 0.5 * turned;
    let chord = if half.abs() < 1e-6 { along } else { along * libm::sin(half) / half };
    let (sin, cos) = libm::sincos(course + half);
    TruePoint {
        position_m: from.position_m + Vector2::new(cos, sin) * chord,
        course_rad: course + turned,
        speed_mps: from.speed_mps + leg.acceleration_ms2 * t,
        along_m: from.along_m + along,
    }
}

/// What the plots are like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise {
    /// Range and azimuth errors of a radar at `radar_m`.
    Radar {
        /// Standard deviation of the range, m.
        range_m: f64,
        /// Standard deviation of the azimuth, rad.
        azimuth_rad: f64,
        /// Site, m.
        radar_m: Point2<f64>,
    },
    /// The same deviation in every direction, m.
    Circular(f64),
}

/// A noise level with its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseLevel {
    /// Name in the report; empty for the headline level.
    pub name: &'static str,
    /// One line for people.
    pub about: &'static str,
    /// The noise.
    pub noise: Noise,
}

impl NoiseLevel {
    /// The levels of the report: the headline first.
    #[must_use]
    pub fn all() -> [Self; 4] {
        let near = Point2::new(1000.0, -1500.0);
        let far = Point2::new(1000.0, -2800.0);
        // Uniform within a resolution cell: 36 ns and 0.25°.
        let cell =
            (299_792_458.0 * 36e-9 / 2.0 / 12f64.sqrt(), 0.25f64.to_radians() / 12f64.sqrt());
        let radar =
            |(range_m, azimuth_rad), radar_m| Noise::Radar { range_m, azimuth_rad, radar_m };
        let thermal = (0.8348, 0.024_29f64.to_radians());
        [
            Self {
                name: "",
                about: "quantised to cells of 36 ns and 0.25°, radar 1.5 km beside the runway",
                noise: radar(cell, near),
            },
            Self {
                name: "thermal",
                about: "limited by receiver noise at 13.2 dB",
                noise: radar(thermal, near),
            },
            Self {
                name: "asmgcs",
                about: "3.064 m per axis: 7.5 m at 95 %",
                noise: Noise::Circular(7.5 / (-2.0 * libm::log(0.05)).sqrt()),
            },
            Self { name: "far", about: "as the first, radar at 2.8 km", noise: radar(cell, far) },
        ]
    }
}

/// The plots of one run, one a second.
#[must_use]
pub fn plots(scene: &Scene, noise: &Noise, seed: u64, run: u64) -> Vec<Plot> {
    let path: Vec<_> = (0..scene.samples).map(|k| scene.at(k as f64).position_m).collect();
    plots_along(&path, noise, seed, run)
}

/// The plots of one run over a path given second by second.
#[must_use]
pub fn plots_along(path: &[Point2<f64>], noise: &Noise, seed: u64, run: u64) -> Vec<Plot> {
    path.iter()
        .enumerate()
        .map(|(k, at)| {
            let key = DrawKey { run_seed: seed, sensor: 1, entity: run, scan: k as u64 };
            let mut rng = key.rng(Purpose::Study);
            let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
            plot(*at, noise, [normal(), normal()], k)
        })
        .collect()
}

/// One plot of a target at `at` with standard normal errors `draws`.
#[must_use]
pub fn plot(at: Point2<f64>, noise: &Noise, draws: [f64; 2], k: usize) -> Plot {
    let (position_m, axis, along_m2, across_m2, polar) = match *noise {
        Noise::Circular(sigma) => {
            let error = Vector2::new(draws[0], draws[1]) * sigma;
            (at + error, Vector2::new(1.0, 0.0), sigma * sigma, sigma * sigma, None)
        }
        Noise::Radar { range_m: sigma_range_m, azimuth_rad: sigma_azimuth_rad, radar_m } => {
            let (distance, azimuth) = ((at - radar_m).norm(), Azimuth::of(at - radar_m));
            let range_m = distance + draws[0] * sigma_range_m;
            let azimuth = Azimuth::from_rad(azimuth.rad() + draws[1] * sigma_azimuth_rad);
            let (offset, along, across) =
                polar_to_cartesian(azimuth.unit(), range_m, sigma_range_m, sigma_azimuth_rad);
            let polar = Polar {
                range_m,
                azimuth_rad: azimuth.rad(),
                sigma_range_m,
                sigma_azimuth_rad,
                extent_m2: None,
            };
            (radar_m + offset, azimuth.unit(), along, across, Some(polar))
        }
    };
    Plot {
        sensor: SensorId(1),
        kind: SensorKind::Asde,
        time: SimTime(k as i64 * 1_000_000_000),
        sequence: 0,
        position_m,
        axis,
        along_m2,
        across_m2,
        altitude_m: None,
        polar,
        identity: None,
        scnr_db: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_landing_is_the_one_described() {
        let scene = Scene::landing();
        let corner = scene.switches_s()[0];
        assert!((corner - 31.944_444).abs() < 1e-5);
        let at = scene.at(corner);
        assert!((at.along_m - 1_641.589_5).abs() < 1e-3, "{}", at.along_m);
        let later = scene.at(corner + 10.0);
        let moved = later.position_m - at.position_m;
        assert!((moved.norm() - 194.444).abs() < 1e-2);
        assert!((libm::atan2(moved.y, moved.x).to_degrees() - 60.0).abs() < 1e-9);
        let arc = Scene::landing_arc();
        assert!((arc.legs[1].duration_s - 8.078).abs() < 1e-3);
        assert!((arc.at(61.0).course_rad.to_degrees() - 60.0).abs() < 1e-9);
    }

    #[test]
    fn the_queue_stands_still_in_between() {
        let scene = Scene::queue();
        assert_eq!(scene.at(24.0).speed_mps, 0.0);
        assert_eq!(scene.at(60.0).position_m, scene.at(50.0).position_m);
        assert!((scene.at(50.0).along_m - 66.0).abs() < 1e-9);
    }
}
