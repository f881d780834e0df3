//! What the plan knows of a kind of target: the extremes of its echo over all aspects.

use std::sync::Arc;

use crate::frames::wrap_pi;
use crate::sensors::TargetClass;
use crate::sensors::radar::extended::{ExtentLevel, centroid};
use crate::sensors::radar::shape::View;

/// Extremes of one class over all aspects.
#[derive(Clone, Debug, PartialEq)]
pub struct ClassFacts {
    /// The class.
    pub class: TargetClass,
    /// Least and largest mean cross section over its median.
    pub aspect: (f64, f64),
    /// Farthest that the centre of the echo lies from the reference point, m.
    pub bias_m: f64,
    /// Least and largest wander of the centre along the line of sight, m.
    pub along_m: (f64, f64),
    /// The same across it.
    pub across_m: (f64, f64),
}

/// Steps of aspect over half a turn.
const STEPS: u32 = 180;
/// Steps between the ends of the flash, three of its widths either side of broadside.
const FLASH_STEPS: u32 = 96;
/// How often an interval between two aspects is halved at most.
const HALVINGS: u32 = 12;
/// What a quantity may be off the straight line between two aspects, of itself; beyond it, what is between is looked at.
const BENT: f64 = 0.02;
/// What is between aspects that were looked at so closely adds no more than this.
const BETWEEN: f64 = 0.01;
/// Lengths below this are nothing, m.
const NOTHING_M: f64 = 0.05;

/// One aspect: cross section over its median, bias, wander along and across.
type Seen = [f64; 4];

impl ClassFacts {
    /// The extremes, from centroids at 1° steps and in the flash at a fifth of that, with what may lie
    /// between: scatterers appear behind the fuselage from one aspect to the next. Shapes of a scene's own may change more
    /// within a degree: where an echo bends, and where sectors and what the fuselage hides end, it is looked at closer.
    #[must_use]
    pub fn of(class: &TargetClass) -> Self {
        // The other half is the mirror image, where the shape is its own.
        let sides: &[f64] = if class.shape.is_symmetric() { &[1.0] } else { &[1.0, -1.0] };
        let share = |i: u32, of: u32| f64::from(i) / f64::from(of);
        let whole = (0..=STEPS).map(|i| share(i, STEPS) * 180.0);
        let wide = class.shape.fuselage.as_ref().map_or(0.0, |f| 3.2 * f.width_deg);
        let flash = (0..=FLASH_STEPS).map(|i| 90.0 + wide * (2.0 * share(i, FLASH_STEPS) - 1.0));
        let views = whole.chain(flash).flat_map(|view| sides.iter().map(move |side| view * side));
        let mut facts = Self {
            class: class.clone(),
            aspect: (f64::INFINITY, 0.0),
            bias_m: 0.0,
            along_m: (f64::INFINITY, 0.0),
            across_m: (f64::INFINITY, 0.0),
        };
        let wider = |range: &mut (f64, f64), value: f64| {
            (range.0, range.1) = (range.0.min(value), range.1.max(value));
        };
        for degrees in views {
            let view = degrees.to_radians();
            let Some(c) = centroid(ExtentLevel::Centroid, class, view) else { continue };
            wider(&mut facts.aspect, c.rcs_m2 / class.rcs_m2);
            facts.bias_m = facts.bias_m.max(libm::hypot(c.bias_along_m, c.bias_across_m));
            wider(&mut facts.along_m, c.glint_along_m);
            wider(&mut facts.across_m, c.glint_across_m);
        }
        let margin = |range: &mut (f64, f64), share: f64| {
            *range = (range.0 * (1.0 - share), range.1 * (1.0 + share));
        };
        margin(&mut facts.aspect, 0.03);
        margin(&mut facts.along_m, 0.05);
        margin(&mut facts.across_m, 0.05);
        facts.bias_m *= 1.05;
        for side in sides {
            facts.look_closer(*side);
        }
        facts
    }

    /// Widens the extremes by what half a turn shows between whole degrees.
    fn look_closer(&mut self, side: f64) {
        let mut views: Vec<f64> = (0..=STEPS).map(|i| side * f64::from(i)).collect();
        // What begins or ends between two aspects is a jump: on both of its sides.
        for border in borders(&self.class) {
            let beside = [border - 1e-7, border + 1e-7].into_iter();
            views.extend(beside.filter(|view| (0.0..=180.0).contains(&(view * side))));
        }
        views.sort_by(f64::total_cmp);
        let mut before = None;
        for view in views {
            let seen = self.seen(view);
            if let Some((last, of_last)) = before {
                self.between((last, of_last), (view, seen), HALVINGS);
            }
            before = Some((view, seen));
        }
    }

    /// The class at an aspect, degrees, which widens the extremes.
    fn seen(&mut self, view_deg: f64) -> Seen {
        let c = centroid(ExtentLevel::Centroid, &self.class, view_deg.to_radians());
        let Some(c) = c else {
            // Nothing returns an echo there.
            self.aspect.0 = 0.0;
            return [0.0; 4];
        };
        let bias_m = libm::hypot(c.bias_along_m, c.bias_across_m);
        let seen = [c.rcs_m2 / self.class.rcs_m2, bias_m, c.glint_along_m, c.glint_across_m];
        let wider = |range: (f64, f64), value: f64, nothing: f64| {
            let least = if value < nothing { 0.0 } else { value * (1.0 - BETWEEN) };
            (range.0.min(least), range.1.max(value * (1.0 + BETWEEN)))
        };
        self.aspect = wider(self.aspect, seen[0], 0.0);
        self.bias_m = self.bias_m.max(bias_m * (1.0 + BETWEEN));
        self.along_m = wider(self.along_m, seen[2], NOTHING_M);
        self.across_m = wider(self.across_m, seen[3], NOTHING_M);
        seen
    }

    /// Looks between two aspects, and again between those as long as the echo bends there.
    fn between(&mut self, a: (f64, Seen), b: (f64, Seen), halvings: u32) {
        let middle = 0.5 * (a.0 + b.0);
        let seen = self.seen(middle);
        let bent = (0..4).any(|i| {
            let least = if i == 0 { 0.0 } else { NOTHING_M };
            (seen[i] - 0.5 * (a.1[i] + b.1[i])).abs() > BENT * seen[i].abs().max(least)
        });
        if bent && halvings > 0 && (b.0 - a.0).abs() > 1e-5 {
            self.between(a, (middle, seen), halvings - 1);
            self.between((middle, seen), b, halvings - 1);
        }
    }

    /// Whether these are the facts of a class: its name does not matter.
    #[must_use]
    pub fn is_of(&self, class: &TargetClass) -> bool {
        let own = &self.class;
        own.length_m == class.length_m
            && own.rcs_m2 == class.rcs_m2
            && own.span_m == class.span_m
            && own.height_m == class.height_m
            && (Arc::ptr_eq(&own.shape, &class.shape) || own.shape == class.shape)
    }

    /// Half the diagonal, m.
    #[must_use]
    pub fn half_m(&self) -> f64 {
        0.5 * libm::hypot(self.class.length_m, self.class.span_m)
    }
}

/// Aspects, degrees in (−180, 180], at which an echo jumps or bends: where sectors end, and where the fuselage begins or
/// ends to stand before a scatterer.
fn borders(class: &TargetClass) -> Vec<f64> {
    let mut found = Vec::new();
    for s in &class.shape.scatterers {
        if let View::Sector { from_deg, half_width_deg } = s.view {
            found.extend([from_deg - half_width_deg, from_deg + half_width_deg]);
        }
        if class.shape.fuselage.is_some() {
            // The way to the radar passes an end of the fuselage: (x, y) is on a line with it.
            let (x_m, y_m) = (s.x * class.length_m, s.y * class.span_m);
            for end_m in [-0.5 * class.length_m, 0.5 * class.length_m] {
                let past = libm::atan2(y_m, x_m - end_m).to_degrees();
                found.extend([past, past + 180.0]);
            }
        }
    }
    found.iter().map(|deg| wrap_pi(deg.to_radians()).to_degrees()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::radar::sample_shapes;
    use crate::sensors::radar::shape::{Fuselage, Scatterer, Shape};
    use proptest::prelude::*;

    prop_compose! {
        fn scatterer()(
            x in -0.5..0.5f64,
            y in -0.5..0.5f64,
            weight in 0.003..1.0f64,
            everywhere in 0..3,
            from_deg in -180.0..180.0f64,
            half_width_deg in 10.0..180.0f64,
        ) -> Scatterer {
            let sector = View::Sector { from_deg, half_width_deg };
            Scatterer { x, y, weight, view: if everywhere == 0 { View::All } else { sector } }
        }
    }

    prop_compose! {
        fn shape()(
            scatterers in prop::collection::vec(scatterer(), 1..8),
            fuselage in prop::option::of((
                0.0..0.5f64,
                0..3usize,
                0.1..100.0f64,
                0.5..90.0f64,
                prop::collection::vec(-0.5..0.5f64, 1..5),
            )),
        ) -> Shape {
            let fuselage = fuselage.map(|(radius, behind, peak, width_deg, points)| {
                let behind = [0.0, 0.1, 1.0][behind];
                Fuselage { radius, behind, base: 0.3, peak, width_deg, points }
            });
            let point = (*Shape::point()).clone();
            Shape { scatterers, fuselage, limits_db: (60.0, 60.0), ..point }
        }
    }

    /// Without what is between degrees the least echo was up to 2.4 times too large, the wander 1.6 times too small.
    fn within(range: (f64, f64), value: f64) -> bool {
        0.98 * range.0 <= value && value <= 1.02 * range.1 + 1e-9
    }

    /// A wander below what matters for steps is none.
    fn wander_within(range: (f64, f64), value_m: f64) -> bool {
        let least_m = if range.0 < 2.0 * NOTHING_M { 0.0 } else { range.0 };
        within((least_m, range.1.max(NOTHING_M)), value_m)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]
        #[test]
        fn no_aspect_of_a_shape_of_ones_own_is_outside_what_is_said_of_all(shape in shape()) {
            prop_assume!(shape.validate().is_ok());
            let class = TargetClass {
                designator: "OWN".into(),
                aircraft: true,
                length_m: 37.6,
                span_m: 35.8,
                height_m: 11.8,
                rcs_m2: 15.0,
                shape: Arc::new(shape),
            };
            let facts = ClassFacts::of(&class);
            for k in -18_000..18_000 {
                let view = (f64::from(k) * 0.01 + 0.003).to_radians();
                let Some(c) = centroid(ExtentLevel::Centroid, &class, view) else {
                    prop_assert_eq!(facts.aspect.0, 0.0);
                    continue;
                };
                let share = c.rcs_m2 / class.rcs_m2;
                prop_assert!(within(facts.aspect, share), "{} at {}", share, view);
                prop_assert!(wander_within(facts.along_m, c.glint_along_m), "{:?} at {}", c, view);
                prop_assert!(wander_within(facts.across_m, c.glint_across_m), "{:?} at {}", c, view);
                let bias_m = libm::hypot(c.bias_along_m, c.bias_across_m);
                prop_assert!(bias_m <= 1.02 * facts.bias_m + 1e-9, "{} at {}", bias_m, view);
            }
        }
    }

    #[test]
    fn facts_are_those_of_classes_of_the_same_size_echo_and_shape() {
        let class = TargetClass {
            designator: "A320".into(),
            aircraft: true,
            length_m: 37.6,
            span_m: 35.8,
            height_m: 11.8,
            rcs_m2: 15.0,
            shape: sample_shapes::of(true),
        };
        let facts = ClassFacts::of(&class);
        assert!(facts.is_of(&class));
        let alike = TargetClass {
            designator: "B738".into(),
            shape: sample_shapes::of(true),
            ..class.clone()
        };
        assert!(facts.is_of(&alike), "its name does not matter, nor where its shape is kept");
        for other in [
            TargetClass { length_m: 37.7, ..class.clone() },
            TargetClass { span_m: 35.9, ..class.clone() },
            TargetClass { height_m: 11.9, ..class.clone() },
            TargetClass { rcs_m2: 15.1, ..class.clone() },
            TargetClass { shape: sample_shapes::of(false), ..class.clone() },
        ] {
            assert!(!facts.is_of(&other), "{other:?}");
        }
        assert!((facts.half_m() - 25.958_621).abs() < 1e-5);
        // No aspect lies outside what is said of all.
        for k in 0..1_440 {
            let Some(c) = centroid(ExtentLevel::Centroid, &class, f64::from(k) * 0.004_363) else {
                continue;
            };
            let within = |range: (f64, f64), value: f64| range.0 <= value && value <= range.1;
            assert!(within(facts.aspect, c.rcs_m2 / class.rcs_m2), "{k}");
            assert!(
                within(facts.along_m, c.glint_along_m) && within(facts.across_m, c.glint_across_m),
                "{k}"
            );
            assert!(libm::hypot(c.bias_along_m, c.bias_across_m) <= facts.bias_m, "{k}");
        }
    }
}
