//! The movers of a scene as sensors see them, those that behave too: their paths are driven once and kept.

use models::frames::{Point2, Point3, wrap_pi};
use models::plot::Callsign;
use models::sensors::{TargetClass, TargetState, Truth};
use models::time::SimTime;
use scenarios::Scene;

/// Every so many frames a state is kept.
const KEPT_FRAMES: i64 = 5;

/// The movers of a scene: recorded, parked and routed ones exactly, behaving ones between states kept each 0.25 s.
#[derive(Debug)]
pub struct Movers<'a> {
    scene: &'a Scene,
    first: usize,
    kept_ns: i64,
    /// Of each flight, state by state from the start on.
    driven: Vec<Vec<Option<TargetState>>>,
}

impl<'a> Movers<'a> {
    /// Drives a scene for so many seconds.
    #[must_use]
    pub fn drive(scene: &'a Scene, seconds: f64) -> Self {
        let frame_ns = scene.run.frame.0.max(1);
        let kept_ns = KEPT_FRAMES * frame_ns;
        let (mut first, mut driven) = (usize::MAX, Vec::new());
        let behaving = scene.traffic.behaving.as_ref();
        if let Some(behaving) = behaving
            && let Some(mut core) = behaving.core(&scene.run, scene.run.seed)
        {
            first = behaving.first_entity;
            driven = vec![Vec::new(); core.flights().len()];
            let frames = (seconds * 1e9) as i64 / frame_ns + KEPT_FRAMES;
            for frame in 0..=frames {
                if frame > 0 {
                    core.step(frame);
                }
                if frame % KEPT_FRAMES != 0 {
                    continue;
                }
                for (flight, path) in driven.iter_mut().enumerate() {
                    path.push(core.state(flight).map(|truth| TargetState {
                        position_m: {
                            let p = truth.position_m;
                            Point3::new(p.x, p.y, p.z)
                        },
                        velocity_mps: truth.velocity_mps,
                        heading_rad: truth.heading_rad,
                    }));
                }
            }
        }
        Self { scene, first, kept_ns, driven }
    }

    /// The least distance of two movers at one second, m, and how many movers were there at all.
    #[must_use]
    pub fn closest(&self, seconds: u32) -> (f64, usize) {
        let (mut least, mut there) = (f64::INFINITY, vec![false; self.len()]);
        for second in 1..=seconds {
            let at = SimTime::from_s(f64::from(second));
            let mut places: Vec<Point2<f64>> = Vec::new();
            for (index, there) in there.iter_mut().enumerate() {
                if let Some(state) = self.at(index, at) {
                    *there = true;
                    places.push(state.position_m.xy());
                }
            }
            for (k, a) in places.iter().enumerate() {
                places[k + 1..].iter().for_each(|b| least = least.min((a - b).norm()));
            }
        }
        (least, there.into_iter().filter(|t| *t).count())
    }
}

impl Truth for Movers<'_> {
    fn len(&self) -> usize {
        self.scene.traffic.entities.len()
    }
    fn key(&self, index: usize) -> u64 {
        index as u64
    }
    fn class(&self, index: usize) -> &TargetClass {
        &self.scene.traffic.entities[index].class
    }
    fn callsign(&self, index: usize) -> Callsign {
        self.scene.traffic.entities[index].callsign
    }
    fn address(&self, index: usize) -> Option<u32> {
        self.scene.traffic.entities[index].address
    }
    fn at(&self, index: usize, time: SimTime) -> Option<TargetState> {
        if let Some(trajectory) = self.scene.traffic.entities[index].trajectory.as_ref() {
            let truth = trajectory.at(time)?;
            let p = truth.position_m;
            return Some(TargetState {
                position_m: Point3::new(p.x, p.y, p.z),
                velocity_mps: truth.velocity_mps,
                heading_rad: truth.heading_rad,
            });
        }
        let path = self.driven.get(index.checked_sub(self.first)?)?;
        let place = time.0.div_euclid(self.kept_ns);
        let at = |place: i64| *path.get(usize::try_from(place).ok()?)?;
        let (a, b) = (at(place)?, at(place + 1));
        let Some(b) = b else { return Some(a) };
        let (t, whole) = (time.0.rem_euclid(self.kept_ns) as f64, self.kept_ns as f64);
        let (u, seconds) = (t / whole, whole * 1e-9);
        // The cubic through both places with both velocities.
        let (h1, h2, h3) = (u * u * (3.0 - 2.0 * u), u * (1.0 - u) * (1.0 - u), u * u * (u - 1.0));
        Some(TargetState {
            position_m: a.position_m
                + (b.position_m - a.position_m) * h1
                + (a.velocity_mps * h2 + b.velocity_mps * h3) * seconds,
            velocity_mps: a.velocity_mps + (b.velocity_mps - a.velocity_mps) * u,
            heading_rad: wrap_pi(a.heading_rad + wrap_pi(b.heading_rad - a.heading_rad) * u),
        })
    }
}
