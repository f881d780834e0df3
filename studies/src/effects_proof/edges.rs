//! Scenes of the proof put on edges: where boxes and the display end, at exact aspects, with what only a scene that was
//! written states (shapes, heights that are assumed, tolerances), and at a pace at which nothing stays in its box.

use super::scene::{Genes, ProofScene, proof_scene};
use models::effects::Tolerance;
use models::environment::surface::Material;
use models::frames::{Azimuth, Point2, Point3, Vector2, Vector3};
use models::sensors::radar::shadow::Building;
use models::sensors::radar::shape::{Fuselage, Scatterer, Shape, View};
use scenarios::ScenarioError;
use std::f64::consts::TAU;
use std::sync::Arc;

/// What a scene is put on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// The display begins or ends within metres of a target.
    Display,
    /// Targets stand where rings, their parts and sectors meet.
    Lattice,
    /// They are as high as a band ends, and rise or sink through it.
    Band,
    /// They are seen from ahead, from behind and from the side.
    Aspect,
    /// Shapes that no table has.
    Shape,
    /// One part of the tolerance is a thousand times narrower or wider than usual.
    Tolerance,
    /// A wall stands between two targets.
    WallBetween,
    /// Three walls stand around the first target.
    Walls,
    /// Rain cells go past while the beam turns.
    Drift,
    /// Targets go through many boxes.
    Fast,
    /// A scan is half a turn, or several.
    Looks,
    /// Targets without size, and of more than any type has.
    Size,
    /// Echoes come from beyond the unambiguous range.
    SecondTrace,
    /// The extractor assumes that targets are as high as they may be.
    Assumed,
    /// Rarer and more frequent false alarms, weaker and stronger echoes.
    Detector,
}

impl Edge {
    /// All of them.
    pub const ALL: [Self; 15] = [
        Self::Display,
        Self::Lattice,
        Self::Band,
        Self::Aspect,
        Self::Shape,
        Self::Tolerance,
        Self::WallBetween,
        Self::Walls,
        Self::Drift,
        Self::Fast,
        Self::Looks,
        Self::Size,
        Self::SecondTrace,
        Self::Assumed,
        Self::Detector,
    ];
}

/// Scene `n` of a seed on one to three edges, which its name tells; `only` one of them where it is given.
///
/// # Errors
/// If a parameter set that ships is missing.
pub fn edge_scene(seed: u64, n: u64, only: Option<Edge>) -> Result<ProofScene, ScenarioError> {
    let plain = proof_scene(seed, n, &[])?;
    let g = &mut Genes::new(seed, n + (1 << 40), &[]);
    // An edge may not go with a radar: again, with other numbers.
    for _ in 0..20 {
        let mut scene = plain.clone();
        let count = if only.is_some() { 1 } else { g.pick(&[1, 1, 2, 3]) };
        let edges: Vec<Edge> =
            (0..count).map(|_| only.unwrap_or_else(|| g.pick(&Edge::ALL))).collect();
        edges.iter().for_each(|edge| edge.put(&mut scene, g));
        if scene.parameters.validate().is_ok() {
            scene.name = format!("{}, edges {edges:?}", plain.name);
            return Ok(scene);
        }
    }
    Ok(plain)
}

impl Edge {
    fn put(self, scene: &mut ProofScene, g: &mut Genes<'_>) {
        match self {
            Self::Display => display(scene, g),
            Self::Lattice => lattice(scene, g),
            Self::Band => band(scene, g),
            Self::Aspect => aspect(scene, g),
            Self::Shape => {
                for (class, ..) in &mut scene.truth.list {
                    class.shape = shape(g).unwrap_or_else(|| class.shape.clone());
                }
            }
            Self::Tolerance => tolerance(&mut scene.tolerance, g),
            Self::WallBetween => {
                let Some((_, place, ..)) = scene.truth.list.first() else { return };
                let (out, far_m) = (place.xy().coords.normalize(), place.xy().coords.norm());
                let away_m = g.scaled(5.0, 200.0);
                if let Some((_, second, ..)) = scene.truth.list.get_mut(1) {
                    *second = Point3::new(out.x, out.y, 0.0) * (far_m + 2.0 * away_m);
                }
                let middle = out * (far_m + away_m);
                let across = Vector2::new(out.y, -out.x);
                add_wall(scene, g, middle.into(), across);
            }
            Self::Walls => {
                for _ in 0..3 {
                    let Some((_, place, ..)) = scene.truth.list.first() else { return };
                    let face = Azimuth::from_rad(g.between(0.0, TAU)).unit();
                    let off = Azimuth::from_rad(g.between(0.0, TAU)).unit() * g.scaled(8.0, 600.0);
                    let middle = place.xy() + off;
                    add_wall(scene, g, middle, face);
                }
            }
            Self::Drift => {
                scene.weather.wind_mps =
                    Azimuth::from_rad(g.between(0.0, TAU)).unit() * g.scaled(30.0, 300.0);
                for cell in &mut scene.weather.cells {
                    cell.radius_m = g.scaled(20.0, 400.0);
                }
            }
            Self::Fast => {
                for (_, _, velocity_mps, heading_rad) in &mut scene.truth.list {
                    let way = Azimuth::from_rad(*heading_rad).unit() * g.scaled(5.0, 120.0);
                    *velocity_mps = Vector3::new(way.x, way.y, 0.0);
                }
                scene.truth.back_s = Some(g.pick(&[4.0, 17.0, 60.0]));
            }
            Self::Looks => scene.turns = g.pick(&[0.3, 0.5, 0.999, 1.001, 1.7, 3.2]),
            Self::Size => {
                for (class, ..) in &mut scene.truth.list {
                    class.length_m = g.pick(&[0.0, 0.5, 150.0, 199.0]);
                    class.span_m = g.pick(&[0.0, 0.5, 150.0, 199.0]);
                    class.height_m = g.pick(&[0.0, 0.1, 2.0, 60.0]);
                    class.rcs_m2 = g.scaled(1e-3, 1e5);
                }
            }
            Self::SecondTrace => {
                let Some((_, place, ..)) = scene.truth.list.first() else { return };
                let p = &mut scene.parameters;
                p.frequency_agile = false;
                p.prf_hz *= p.unambiguous_m() / (place.xy().coords.norm() * g.between(0.3, 1.2));
                p.range_max_m = 0.99 * p.unambiguous_m();
                p.range_min_m = p.range_min_m.min(0.5 * p.range_max_m).max(p.blind_m());
            }
            Self::Assumed => {
                let p = &mut scene.parameters;
                p.assumed_height_m = g.pick(&[0.0, 1.0, 0.5, 0.99]) * p.antenna_height_m;
            }
            Self::Detector => {
                let p = &mut scene.parameters;
                p.pfa = g.scaled(1e-12, 1e-3);
                p.glint_sigma_m = g.pick(&[0.0, 0.1, 3.0, 30.0]);
                p.range_step_m = g.pick(&[0.0, 0.01, 0.5, 30.0]);
                p.azimuth_step_deg = g.pick(&[0.0, 0.001, 0.1, 2.0]);
                p.sidelobe_floor_db = g.between(-60.0, -5.0);
            }
        }
    }
}

fn slant_m(scene: &ProofScene, target: usize) -> Option<f64> {
    let (class, place, ..) = scene.truth.list.get(target)?;
    let up_m = scene.parameters.antenna_height_m - place.z.max(0.5 * class.height_m);
    Some(libm::hypot(place.xy().coords.norm(), up_m))
}

fn display(scene: &mut ProofScene, g: &mut Genes<'_>) {
    let target = g.pick(&[0, 0, 1]);
    let Some(slant_m) = slant_m(scene, target).or_else(|| slant_m(scene, 0)) else { return };
    let away_m = match g.pick(&[0, 1, 2]) {
        0 => 0.0,
        1 => g.between(-1.0, 1.0),
        _ => g.between(-40.0, 40.0),
    };
    let p = &mut scene.parameters;
    if g.chance(0.5) {
        p.range_min_m = (slant_m + away_m).max(p.blind_m());
        p.range_max_m = p.range_max_m.max(p.range_min_m + 100.0).min(0.99 * p.unambiguous_m());
    } else {
        p.range_max_m = (slant_m + away_m).min(0.99 * p.unambiguous_m()).max(100.0);
        p.range_min_m = p.range_min_m.min(0.5 * p.range_max_m).max(p.blind_m());
    }
}

fn lattice(scene: &mut ProofScene, g: &mut Genes<'_>) {
    for (_, place, _, heading_rad) in &mut scene.truth.list {
        let beside = |g: &mut Genes<'_>| g.pick(&[0.0, 1e-15, -1e-15, 1e-9, -1e-9, 1e-4, -1e-4]);
        let eighths = (8.0 * libm::log2((place.xy().coords.norm() / 100.0).max(0.5))).round();
        let ground_m = 100.0 * libm::exp2(eighths / 8.0) * (1.0 + beside(g));
        let before = Azimuth::of(place.xy().coords).rad();
        let sector = TAU / 16.0;
        let azimuth = (before / sector).round() * sector + beside(g);
        let at = Azimuth::from_rad(azimuth).unit() * ground_m;
        *heading_rad += azimuth - before;
        *place = Point3::new(at.x, at.y, place.z);
    }
}

fn band(scene: &mut ProofScene, g: &mut Genes<'_>) {
    for (_, place, velocity_mps, _) in &mut scene.truth.list {
        let edge_m = g.pick(&[0.5, 5.0, 25.0, 30.0, 30.0, 50.0, 290.0, 310.0, 310.0, 620.0]);
        place.z = edge_m + g.pick(&[0.0, 1e-9, -1e-9, 0.1, -0.1]);
        velocity_mps.z = g.pick(&[0.0, 0.0, 0.5, 5.0]);
    }
}

fn aspect(scene: &mut ProofScene, g: &mut Genes<'_>) {
    for (_, place, velocity_mps, heading_rad) in &mut scene.truth.list {
        let sight = Azimuth::of(place.xy().coords).rad();
        *heading_rad =
            sight + g.pick(&[0.0, 0.25, 0.5, 0.75]) * TAU + g.pick(&[0.0, 1e-9, -1e-9, 1e-3]);
        *velocity_mps = Vector3::zeros();
    }
}

fn tolerance(tolerance: &mut Tolerance, g: &mut Genes<'_>) {
    let factor = |g: &mut Genes<'_>| g.pick(&[0.0, 1e-4, 1e-3, 1e-2, 1.0, 1.0, 10.0, 100.0]);
    tolerance.position_m *= factor(g);
    tolerance.tail = (tolerance.tail * factor(g)).min(1.0);
    tolerance.detection = (tolerance.detection * factor(g)).min(1.0);
    tolerance.false_plots *= factor(g);
}

fn add_wall(scene: &mut ProofScene, g: &mut Genes<'_>, middle: Point2<f64>, face: Vector2<f64>) {
    let (long_m, thick_m) = (g.scaled(10.0, 500.0), g.pick(&[0.3, 30.0]));
    let across = Vector2::new(face.y, -face.x);
    let corner = |a: f64, b: f64| middle + face * (0.5 * a * long_m) + across * (b * thick_m);
    let facade = Material::named(if g.chance(0.7) { "metal" } else { "concrete" });
    let wall = Building {
        name: "wall".into(),
        footprint_m: vec![corner(-1.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        height_m: g.scaled(1.0, 80.0),
        facade: facade.unwrap_or(scene.parameters.surface),
    };
    if !wall.contains(Point2::origin()) {
        scene.buildings = scene.buildings.iter().cloned().chain([wall]).collect();
    }
}

/// A shape drawn at random that a scene may state; `None` where none of some is.
fn shape(g: &mut Genes<'_>) -> Option<Arc<Shape>> {
    for _ in 0..40 {
        let count = g.pick(&[1, 2, 3, 6, 12]);
        let mut scatterers: Vec<Scatterer> = (0..count)
            .map(|_| {
                let view = if g.chance(0.3) {
                    View::All
                } else {
                    View::Sector {
                        from_deg: g.between(-180.0, 180.0),
                        half_width_deg: g.scaled(10.0, 180.0),
                    }
                };
                let (x, y) = (g.between(-0.5, 0.5), g.between(-0.5, 0.5));
                Scatterer { x, y, weight: g.scaled(0.003, 1.0), view }
            })
            .collect();
        let sum: f64 = scatterers.iter().map(|s| s.weight).sum();
        scatterers.iter_mut().for_each(|s| s.weight = (s.weight * 1.2 / sum).clamp(1e-6, 1.0));
        let fuselage = g.chance(0.5).then(|| Fuselage {
            radius: g.between(0.0, 0.5),
            behind: g.pick(&[0.0, 0.1, 1.0]),
            base: g.pick(&[0.0, 0.3, 10.0]),
            peak: g.scaled(0.1, 100.0),
            width_deg: g.scaled(0.5, 90.0),
            points: (0..g.pick(&[1, 3, 16])).map(|_| g.between(-0.5, 0.5)).collect(),
        });
        let shape = Shape {
            name: "drawn".into(),
            size_m: (30.0, 30.0),
            rcs_m2: 10.0,
            scatterers,
            fuselage,
            limits_db: (60.0, 60.0),
            source: "drawn".into(),
        };
        if shape.validate().is_ok() {
            return Some(Arc::new(shape));
        }
    }
    None
}
