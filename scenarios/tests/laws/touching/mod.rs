//! Whether two touch, for tests in which nobody is to.

use models::traffic::core::Core;
use models::traffic::outline::{distance_m, outline};
use models::truth::TruthState;

/// Two on the ground whose outlines touch.
pub(crate) fn overlap(core: &Core) -> Option<String> {
    let on_ground = |f: usize| core.state(f).filter(|s| s.position_m.z < 3.0).map(|s| (f, s));
    let seen: Vec<_> = (0..core.flights().len()).filter_map(on_ground).collect();
    for (i, (a, s)) in seen.iter().enumerate() {
        for (b, t) in &seen[i + 1..] {
            if (s.position_m - t.position_m).norm() > 90.0 {
                continue;
            }
            let of = |f: usize, s: &TruthState| {
                outline(core.flights()[f].size, s.position_m.xy(), s.heading_rad)
            };
            if distance_m(&of(*a, s), &of(*b, t)) == 0.0 {
                let [a, b] = [*a, *b].map(|f| &core.flights()[f].callsign);
                return Some(format!("{a} and {b}"));
            }
        }
    }
    None
}
