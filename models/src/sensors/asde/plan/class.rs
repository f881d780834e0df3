//! What the plan knows of a kind of target: the extremes of its echo over all aspects.

use std::sync::Arc;

use crate::sensors::TargetClass;
use crate::sensors::radar::extended::{ExtentLevel, centroid};

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

impl ClassFacts {
    /// The extremes, from centroids at 1° steps and in the flash at a fifth of that, with what may lie
    /// between: scatterers appear behind the fuselage from one aspect to the next.
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
        facts
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::radar::sample_shapes;

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
