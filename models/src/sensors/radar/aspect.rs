//! Centroid and glint of a class by aspect, from a table: what [`centroid`] says, within a stated error.
//!
//! Between the aspects at which a fuselage begins or ends to hide a scatterer, everything is smooth in the aspect.
//! Half a degree is a cubic through four aspects, taken where between them it is within half of the stated error;
//! elsewhere, and where a scatterer appears, the sums are taken as they are. A cell is a function of its class alone,
//! made when it is first asked for. The left of a body that is its right one mirrored needs no cells of its own.

use super::extended::{Centroid, ExtentLevel, centroid};
use super::shape::Shape;
use crate::frames::wrap_pi;
use crate::sensors::TargetClass;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Largest error of the bias, and of the glint, m.
pub const ERROR_M: f64 = 1e-4;
/// Largest error of the cross section, dB.
pub const ERROR_DB: f64 = 2e-4;

/// The same as a share.
const ERROR_SHARE: f64 = 4.6e-5;
/// Cells of a turn.
const CELLS: usize = 720;
const CELL_RAD: f64 = TAU / CELLS as f64;
/// Classes with a table; those of further ones are taken as they are.
const MOST_CLASSES: usize = 1000;

/// What depends on the aspect: bias along and across, glint along and across, m; cross section over the median.
const PARTS: usize = 5;

type Parts = [f64; PARTS];

/// Factors of 1, t, t² and t³ over a cell, by part.
type Cubics = [[f32; 4]; PARTS];

#[derive(Clone, Debug)]
enum Cell {
    /// Not asked for yet.
    New,
    /// Not smooth enough.
    Exact,
    Smooth(Cubics),
}

/// The table of the bodies of a shape with one length and span.
#[derive(Clone, Debug)]
struct Table {
    shape: Arc<Shape>,
    length_m: f64,
    span_m: f64,
    /// Whether cells are of the right side only.
    mirrored: bool,
    /// From behind, or with `mirrored` from ahead, clockwise.
    cells: Vec<Cell>,
}

/// The tables of all classes that a radar has met.
#[derive(Clone, Debug, Default)]
pub struct AspectTables {
    tables: Vec<Table>,
    /// The table of each target of the truth, as a guess.
    guesses: Vec<u16>,
}

impl AspectTables {
    /// The centroid of a target, by its place in the truth and its class, seen from `view_rad` in [−π, π]. `None` if
    /// nothing returns an echo.
    pub fn centroid(
        &mut self,
        target: usize,
        class: &TargetClass,
        view_rad: f64,
    ) -> Option<Centroid> {
        if self.guesses.len() <= target {
            self.guesses.resize(target + 1, 0);
        }
        let guess = usize::from(self.guesses[target]);
        let place = if self.tables.get(guess).is_some_and(|table| table.is_of(class)) {
            guess
        } else if let Some(place) = self.tables.iter().position(|table| table.is_of(class)) {
            place
        } else if self.tables.len() < MOST_CLASSES {
            self.tables.push(Table::of(class));
            self.tables.len() - 1
        } else {
            return centroid(ExtentLevel::Centroid, class, view_rad);
        };
        self.guesses[target] = place as u16;
        self.tables[place].centroid(class, view_rad)
    }
}

impl Table {
    fn of(class: &TargetClass) -> Self {
        let mirrored = class.shape.is_symmetric();
        let shape = class.shape.clone();
        let cells = vec![Cell::New; if mirrored { CELLS / 2 } else { CELLS }];
        let (length_m, span_m) = (class.length_m, class.span_m);
        let mut table = Self { shape, length_m, span_m, mirrored, cells };
        for view_rad in hidden_from(class) {
            // Beside an edge of cells by less than rounding: both.
            for beside in [-1e-9, 1e-9] {
                if let Some((place, _)) = table.place(wrap_pi(view_rad + beside)) {
                    table.cells[place] = Cell::Exact;
                }
            }
        }
        table
    }

    /// Whether a class has the same shape and size; the median does not matter.
    fn is_of(&self, class: &TargetClass) -> bool {
        self.length_m == class.length_m
            && self.span_m == class.span_m
            && (Arc::ptr_eq(&self.shape, &class.shape) || self.shape == class.shape)
    }

    /// The cell of an aspect, and how far into it.
    fn place(&self, view_rad: f64) -> Option<(usize, f64)> {
        let from_rad = if self.mirrored { view_rad.abs() } else { view_rad + PI };
        let at = from_rad * (CELLS as f64 / TAU);
        // An aspect that is no number, or beyond the turn, has no cell.
        let within = at >= 0.0 && at < self.cells.len() as f64;
        within.then_some((at as usize, at - (at as usize) as f64))
    }

    fn centroid(&mut self, class: &TargetClass, view_rad: f64) -> Option<Centroid> {
        let as_it_is = || centroid(ExtentLevel::Centroid, class, view_rad);
        if !(class.rcs_m2 > 0.0 && class.rcs_m2.is_finite()) {
            return as_it_is();
        }
        let Some((place, t)) = self.place(view_rad) else { return as_it_is() };
        if let Cell::New = self.cells[place] {
            let from_rad = if self.mirrored { 0.0 } else { -PI };
            self.cells[place] = cell(class, from_rad + place as f64 * CELL_RAD);
        }
        let Cell::Smooth(of) = &self.cells[place] else { return as_it_is() };
        let [along, across, glint_along, glint_across, share] = parts_at(of, t);
        Some(Centroid {
            bias_along_m: along,
            bias_across_m: if self.mirrored && view_rad < 0.0 { -across } else { across },
            glint_along_m: glint_along.max(0.0),
            glint_across_m: glint_across.max(0.0),
            rcs_m2: share * class.rcs_m2,
        })
    }
}

/// The aspects at which the fuselage begins or ends to hide a scatterer, rad.
fn hidden_from(class: &TargetClass) -> impl Iterator<Item = f64> {
    let fuselage = class.shape.fuselage.is_some();
    let beside = class.shape.scatterers.iter().filter(move |s| fuselage && s.y != 0.0);
    beside.flat_map(|s| {
        let (x_m, y_m) = (s.x * class.length_m, s.y * class.span_m);
        // On the other side of the fuselage, past its nose or its tail.
        [-0.5, 0.5].map(|end| libm::atan2(-y_m, end * class.length_m - x_m))
    })
}

fn parts_at(of: &Cubics, t: f64) -> Parts {
    of.map(|[a, b, c, d]| f64::from(a) + t * (f64::from(b) + t * (f64::from(c) + t * f64::from(d))))
}

/// The cubic through values at 0, 1/3, 2/3 and 1.
fn cubic([a, b, c, d]: [f64; 4]) -> [f32; 4] {
    let (first, second, third) = (b - a, c - 2.0 * b + a, d - 3.0 * (c - b) - a);
    let of = [a, 3.0 * first - 1.5 * second + third, 4.5 * (second - third), 4.5 * third];
    of.map(|x| x as f32)
}

/// The cell of a class from an aspect on.
fn cell(class: &TargetClass, from_rad: f64) -> Cell {
    let exact = |t: f64| -> Option<Parts> {
        let c = centroid(ExtentLevel::Centroid, class, from_rad + t * CELL_RAD)?;
        let share = c.rcs_m2 / class.rcs_m2;
        Some([c.bias_along_m, c.bias_across_m, c.glint_along_m, c.glint_across_m, share])
    };
    let nodes = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(exact);
    let [Some(a), Some(b), Some(c), Some(d)] = nodes else { return Cell::Exact };
    let of: Cubics = std::array::from_fn(|i| cubic([a[i], b[i], c[i], d[i]]));
    let near = |t: f64| {
        exact(t).is_some_and(|exact| {
            let found = parts_at(&of, t);
            let off = |i: usize| (found[i] - exact[i]).abs();
            let metres = libm::hypot(off(0), off(1)).max(libm::hypot(off(2), off(3)));
            metres <= 0.5 * ERROR_M && off(4) <= 0.5 * ERROR_SHARE * exact[4]
        })
    };
    let between = [1.0 / 6.0, 0.5, 5.0 / 6.0];
    if between.into_iter().all(near) { Cell::Smooth(of) } else { Cell::Exact }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::testing::class;
    use proptest::prelude::*;

    /// A narrow body with a strong left engine.
    fn lopsided() -> TargetClass {
        let mut class = class(true, 37.6, 35.8, 15.0);
        let mut shape = (*class.shape).clone();
        let left = shape.scatterers.iter().position(|s| s.y < -0.1).expect("one on the left");
        shape.scatterers[left].weight *= 5.0;
        class.shape = Arc::new(shape);
        class
    }

    fn apart(class: &TargetClass, tables: &mut AspectTables, view_rad: f64) -> (f64, f64) {
        let exact = centroid(ExtentLevel::Centroid, class, view_rad).expect("an echo");
        let found = tables.centroid(0, class, view_rad).expect("an echo");
        let bias_m = libm::hypot(
            found.bias_along_m - exact.bias_along_m,
            found.bias_across_m - exact.bias_across_m,
        );
        let glint_m = libm::hypot(
            found.glint_along_m - exact.glint_along_m,
            found.glint_across_m - exact.glint_across_m,
        );
        (bias_m.max(glint_m), 10.0 * libm::log10(found.rcs_m2 / exact.rcs_m2).abs())
    }

    #[test]
    fn most_of_a_turn_is_in_the_table() {
        for class in [
            class(true, 37.6, 35.8, 15.0),
            class(true, 8.3, 11.0, 2.0),
            class(false, 5.0, 2.0, 3.0),
        ] {
            let mut tables = AspectTables::default();
            for i in 0..CELLS {
                tables.centroid(0, &class, (i as f64 + 0.3) * CELL_RAD - PI);
            }
            let cells = &tables.tables[0].cells;
            assert!(cells.iter().all(|c| !matches!(c, Cell::New)));
            let smooth = cells.iter().filter(|c| matches!(c, Cell::Smooth(_)));
            let share = smooth.count() as f64 / cells.len() as f64;
            println!("{} m: {share:.3}", class.length_m);
            assert!(share > 0.9, "{share}");
        }
    }

    #[test]
    fn what_has_no_echo_or_no_aspect_is_taken_as_it_is() {
        let mut tables = AspectTables::default();
        assert_eq!(tables.centroid(0, &class(true, 30.0, 30.0, 0.0), 1.0), None);
        let own = class(true, 30.0, 30.0, 5.0);
        for view_rad in [-PI, PI, 0.0, 4.0 * PI, f64::NAN] {
            let exact = centroid(ExtentLevel::Centroid, &own, view_rad);
            let found = tables.centroid(7, &own, view_rad);
            assert_eq!(found.is_some(), exact.is_some(), "{view_rad}");
        }
    }

    #[test]
    fn classes_of_one_size_share_a_table_and_others_do_not() {
        let mut tables = AspectTables::default();
        let (weak, strong) = (class(true, 30.0, 30.0, 5.0), class(true, 30.0, 30.0, 50.0));
        let one = tables.centroid(0, &weak, 0.7).expect("an echo");
        let other = tables.centroid(1, &strong, 0.7).expect("an echo");
        assert_eq!(tables.tables.len(), 1);
        assert!((other.rcs_m2 - 10.0 * one.rcs_m2).abs() < 1e-9);
        // A target may be of another class in another scan.
        let long = class(true, 60.0, 30.0, 5.0);
        assert_eq!(
            apart(&long, &mut tables, 0.7).0,
            apart(&long, &mut AspectTables::default(), 0.7).0
        );
        assert!(apart(&long, &mut tables, 0.7).0 <= ERROR_M && tables.tables.len() == 2);
    }

    #[test]
    fn where_a_scatterer_appears_and_in_a_sharp_flash_sums_are_taken_as_they_are() {
        let body = class(true, 37.6, 35.8, 15.0);
        let table = Table::of(&body);
        let mut found = 0;
        for view_rad in hidden_from(&body) {
            let (place, _) = table.place(wrap_pi(view_rad)).expect("an aspect");
            assert!(matches!(table.cells[place], Cell::Exact), "{view_rad}");
            let weight = |off: f64| {
                let c = centroid(ExtentLevel::Centroid, &body, view_rad + off).expect("an echo");
                c.rcs_m2 / body.rcs_m2
            };
            // There something does appear.
            found += usize::from((weight(1e-7) - weight(-1e-7)).abs() > 0.01);
        }
        assert!(found >= 10, "{found}");
        let mut sharp = body.clone();
        let mut shape = (*sharp.shape).clone();
        shape.fuselage.iter_mut().for_each(|f| (f.width_deg, f.peak) = (0.5, 100.0));
        sharp.shape = Arc::new(shape);
        let mut tables = AspectTables::default();
        for i in 0..4000 {
            let view_rad = (86.0 + 0.002 * f64::from(i)).to_radians();
            let (metres, db) = apart(&sharp, &mut tables, view_rad);
            assert!(metres <= ERROR_M && db <= ERROR_DB, "{metres} m, {db} dB at {view_rad}");
        }
    }

    #[test]
    fn a_body_whose_sides_differ_has_cells_of_both() {
        let class = lopsided();
        let mut tables = AspectTables::default();
        for i in 0..7200 {
            let view_rad = f64::from(i) / 7200.0 * TAU - PI;
            let (metres, db) = apart(&class, &mut tables, view_rad);
            assert!(metres <= ERROR_M && db <= ERROR_DB, "{metres} m, {db} dB at {view_rad}");
        }
        let left = tables.centroid(0, &class, -0.8).expect("an echo");
        let right = tables.centroid(0, &class, 0.8).expect("an echo");
        assert!(
            (left.bias_across_m + right.bias_across_m).abs() > 0.1
                && tables.tables[0].cells.len() == CELLS
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]
        #[test]
        fn the_table_is_within_its_stated_error(
            length in 1.0_f64..90.0, span in 1.0_f64..90.0, rcs in 0.01_f64..100.0,
            from in -3.1_f64..3.1, aircraft: bool,
        ) {
            let class = class(aircraft, length, span, rcs);
            let mut tables = AspectTables::default();
            // Two cells and a half, finely.
            for step in 0..250 {
                let view_rad = wrap_pi(from + f64::from(step) * 0.005f64.to_radians());
                let (metres, db) = apart(&class, &mut tables, view_rad);
                prop_assert!(metres <= ERROR_M && db <= ERROR_DB, "{} m, {} dB at {}", metres, db, view_rad);
            }
        }
    }
}
