//! A narrow body and a car, as the shipped file of shapes has them: for tests and benches of this crate,
//! which reads no files.

use super::shape::{Fuselage, Scatterer, Shape, View};
use std::sync::Arc;

fn everywhere(x: f64, y: f64, weight: f64) -> Scatterer {
    Scatterer { x, y, weight, view: View::All }
}

fn seen_from(from_deg: f64, half_width_deg: f64, x: f64, y: f64, weight: f64) -> Scatterer {
    Scatterer { x, y, weight, view: View::Sector { from_deg, half_width_deg } }
}

/// A transport aircraft with two engines under the wing.
fn narrow() -> Shape {
    let scatterers = vec![
        seen_from(0.0, 90.0, 0.48, 0.0, 0.10),
        everywhere(0.40, 0.0, 0.08),
        everywhere(0.02, -0.07, 0.05),
        everywhere(0.02, 0.07, 0.05),
        everywhere(-0.10, -0.50, 0.03),
        everywhere(-0.10, 0.50, 0.03),
        everywhere(-0.03, 0.0, 0.08),
        everywhere(0.37, 0.0, 0.04),
        everywhere(-0.45, 0.0, 0.12),
        everywhere(-0.47, -0.15, 0.04),
        everywhere(-0.47, 0.15, 0.04),
        seen_from(0.0, 70.0, 0.10, -0.17, 0.14),
        seen_from(0.0, 70.0, 0.10, 0.17, 0.14),
        seen_from(180.0, 70.0, -0.02, -0.17, 0.10),
        seen_from(180.0, 70.0, -0.02, 0.17, 0.10),
    ];
    let points = [-0.35, -0.233_333, -0.116_667, 0.0, 0.116_667, 0.233_333, 0.35].to_vec();
    let fuselage =
        Fuselage { radius: 0.05, behind: 0.05, base: 0.3, peak: 20.0, width_deg: 3.0, points };
    Shape {
        name: "narrow".into(),
        size_m: (37.6, 35.8),
        rcs_m2: 15.0,
        scatterers,
        fuselage: Some(fuselage),
        limits_db: (1.6, 13.2),
        source: "assumed".into(),
    }
}

/// A box on wheels.
fn car() -> Shape {
    let scatterers = vec![
        seen_from(0.0, 90.0, 0.45, 0.0, 0.75),
        seen_from(180.0, 90.0, -0.45, 0.0, 0.75),
        seen_from(90.0, 90.0, 0.0, 0.45, 0.75),
        seen_from(-90.0, 90.0, 0.0, -0.45, 0.75),
        everywhere(0.0, 0.0, 0.25),
    ];
    Shape {
        name: "car".into(),
        size_m: (4.8, 2.0),
        rcs_m2: 3.0,
        scatterers,
        fuselage: None,
        limits_db: (0.1, 0.1),
        source: "assumed".into(),
    }
}

/// The narrow body, or the car.
pub(crate) fn of(aircraft: bool) -> Arc<Shape> {
    Arc::new(if aircraft { narrow() } else { car() })
}
