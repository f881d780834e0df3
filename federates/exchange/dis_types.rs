//! Entity types of the types of the scene: SISO-REF-010, and back to a size.
//!
//! Enumerations: SISO-REF-010-2025 (v35), Platform of the Air and Land Domains; reprinted with
//! permission from SISO Inc.

use models::sensors::TargetClass;
use pdu::records::EntityType;
use scenarios::types::TypeTable;

/// (designator, entity type: kind, domain, country, category, subcategory, specific, extra).
const TYPES: [(&str, [u16; 7]); 30] = [
    ("A319", [1, 2, 71, 87, 32, 4, 0]),
    ("A320", [1, 2, 71, 87, 32, 1, 0]),
    ("A20N", [1, 2, 71, 87, 32, 1, 29]), // A320-251n
    ("A321", [1, 2, 71, 87, 32, 5, 0]),
    ("A332", [1, 2, 71, 88, 32, 3, 6]), // A330-202
    ("A333", [1, 2, 71, 88, 32, 3, 1]), // A330-301
    ("A359", [1, 2, 71, 88, 32, 4, 1]),
    ("A388", [1, 2, 71, 88, 34, 2, 1]), // A380-841
    ("B737", [1, 2, 225, 87, 32, 5, 7]),
    ("B738", [1, 2, 225, 87, 32, 5, 8]),
    ("B38M", [1, 2, 225, 87, 32, 5, 12]),
    ("B744", [1, 2, 225, 88, 34, 1, 2]),
    ("B752", [1, 2, 225, 87, 32, 6, 1]),
    ("B763", [1, 2, 225, 88, 32, 1, 3]),
    ("B77W", [1, 2, 225, 88, 32, 2, 5]),
    ("B788", [1, 2, 225, 88, 32, 3, 1]),
    ("B789", [1, 2, 225, 88, 32, 3, 2]),
    ("E190", [1, 2, 29, 87, 32, 2, 1]),
    ("CRJ9", [1, 2, 39, 87, 32, 3, 2]),
    ("E145", [1, 2, 29, 87, 32, 3, 3]),
    ("C550", [1, 2, 225, 85, 32, 0, 0]), // Twin Jet; the table has no Citation II
    ("AT75", [1, 2, 71, 87, 22, 1, 4]),
    ("DH8D", [1, 2, 39, 87, 22, 1, 2]),
    ("C172", [1, 2, 225, 85, 11, 1, 0]),
    ("FOLLOWME", [1, 1, 0, 93, 0, 0, 0]), // Utility/Emergency Car
    ("FIRE", [1, 1, 0, 84, 12, 0, 0]),    // Generic Airport Fire Engine
    ("BUS", [1, 1, 0, 82, 17, 0, 0]),     // Generic Airport Transport Bus
    ("TUG", [1, 1, 0, 87, 1, 0, 0]),      // Generic Tug
    ("FUEL", [1, 1, 0, 83, 20, 0, 0]),    // Generic Tanker
    ("SNOW", [1, 1, 0, 84, 90, 0, 0]),    // Generic Utility Truck
];

fn record(t: [u16; 7]) -> EntityType {
    let [kind, domain, country, category, subcategory, specific, extra] = t;
    let [kind, domain, category, subcategory, specific, extra] =
        [kind, domain, category, subcategory, specific, extra].map(|n| n.min(255) as u8);
    EntityType::new(kind, domain, country, category, subcategory, specific, extra)
}

/// The entity type of a class: by its designator, else by its size.
#[must_use]
pub fn of_class(class: &TargetClass) -> EntityType {
    if let Some((_, t)) = TYPES.iter().find(|(designator, _)| *designator == class.designator) {
        return record(*t);
    }
    let category = match (class.aircraft, class.span_m, class.length_m) {
        // Small below 18 m of span, medium, large, heavy civilian fixed wing.
        (true, s, _) if s < 18.0 => 85,
        (true, s, _) if s < 27.0 => 86,
        (true, s, _) if s < 42.0 => 87,
        (true, ..) => 88,
        // Car, single unit utility truck.
        (false, _, l) if l < 5.5 => 81,
        (false, ..) => 84,
    };
    record([1, if class.aircraft { 2 } else { 1 }, 0, category, 0, 0, 0])
}

/// Typical sizes of categories that no type of ours belongs to: (domain, category, word, length m, span
/// m, height m, median echo m²). Assumed values.
const CATEGORIES: [(u8, u8, &str, f64, f64, f64, f64); 26] = [
    (2, 1, "fighter", 15.5, 10.5, 4.8, 5.0),
    (2, 2, "attack aircraft", 16.0, 14.0, 4.8, 5.0),
    (2, 3, "bomber", 45.0, 42.0, 10.0, 40.0),
    (2, 4, "cargo aircraft", 40.0, 40.0, 12.0, 30.0),
    (2, 40, "trainer", 11.0, 10.0, 3.5, 3.0),
    (2, 50, "unmanned aircraft", 8.0, 15.0, 2.0, 1.0),
    (2, 80, "ultralight", 3.5, 10.0, 3.0, 1.0),
    (2, 81, "ultralight", 6.0, 9.0, 2.5, 1.0),
    (2, 83, "glider", 7.0, 15.0, 1.5, 1.0),
    (2, 84, "light aircraft", 7.0, 9.0, 2.5, 2.0),
    (2, 85, "small aircraft", 10.0, 12.0, 3.5, 3.0),
    (2, 86, "medium aircraft", 20.0, 20.0, 6.5, 8.0),
    (2, 87, "large aircraft", 37.0, 34.0, 12.0, 20.0),
    (2, 88, "heavy aircraft", 63.0, 60.0, 17.0, 60.0),
    (2, 90, "small helicopter", 9.0, 2.5, 3.0, 3.0),
    (2, 91, "medium helicopter", 13.0, 3.0, 4.0, 5.0),
    (2, 92, "large helicopter", 19.0, 4.0, 5.0, 8.0),
    (1, 80, "motorcycle", 2.2, 0.8, 1.4, 0.8),
    (1, 81, "car", 4.6, 1.9, 1.5, 3.0),
    (1, 82, "bus", 13.0, 2.6, 3.2, 15.0),
    (1, 83, "truck", 9.0, 2.5, 3.3, 10.0),
    (1, 84, "utility truck", 9.0, 2.6, 3.3, 10.0),
    (1, 85, "articulated truck", 16.5, 2.55, 4.0, 20.0),
    (1, 87, "specialty vehicle", 8.0, 3.0, 3.0, 8.0),
    (1, 89, "trailer", 8.0, 2.5, 3.0, 8.0),
    (1, 93, "utility car", 4.6, 1.9, 1.8, 3.0),
];

/// Size and echo of an entity that the scene does not know, by its type: the type of ours that agrees
/// in most of its fields from the left, at least up to the subcategory (and that not 0); else what is
/// usual for its category.
#[must_use]
pub fn class_of(entity_type: EntityType, known: &TypeTable) -> TargetClass {
    let t = entity_type;
    let fields = [
        u16::from(t.kind.0),
        t.domain.into(),
        t.country.0,
        t.category.into(),
        t.subcategory.into(),
        t.specific.into(),
        t.extra.into(),
    ];
    let agreement = |of: &[u16; 7]| of.iter().zip(&fields).take_while(|(a, b)| a == b).count();
    if t.subcategory != 0 {
        let best =
            TYPES.iter().max_by(|a, b| agreement(&a.1).cmp(&agreement(&b.1)).reverse().reverse());
        if let Some((designator, of)) = best
            && agreement(of) >= 6
            && let Some(row) = known.get(designator)
        {
            return row.class.clone();
        }
    }
    let class = |word: &str, aircraft, length_m, span_m, height_m, rcs_m2| TargetClass {
        designator: word.into(),
        aircraft,
        length_m,
        span_m,
        height_m,
        rcs_m2,
        shape: known.shapes().usual(aircraft, length_m),
    };
    let air = t.kind.0 == 1 && t.domain == 2;
    if t.kind.0 == 3 {
        return class("person", false, 0.5, 0.5, 1.8, 0.5);
    }
    if air && (20..30).contains(&t.category) {
        return class("medium helicopter", true, 13.0, 3.0, 4.0, 5.0);
    }
    let category = CATEGORIES.iter().find(|c| (c.0, c.1) == (t.domain, t.category));
    match category.filter(|_| t.kind.0 == 1) {
        Some(&(domain, _, word, length_m, span_m, height_m, rcs_m2)) => {
            class(word, domain == 2, length_m, span_m, height_m, rcs_m2)
        }
        None if air => class("aircraft", true, 38.0, 35.0, 12.0, 20.0),
        None => class("vehicle", false, 6.0, 2.2, 2.0, 5.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pdu::enumerations::{AirCategory, LandCategory};

    #[test]
    fn every_type_that_ships_has_a_type_of_its_own_in_the_right_category() {
        let known = scenarios::types::shipped().expect("the table");
        let mut seen = std::collections::BTreeSet::new();
        for designator in known.designators() {
            let row = known.get(designator).expect("listed");
            let t = of_class(&row.class);
            assert_eq!(t.domain, if row.class.aircraft { 2 } else { 1 }, "{designator}");
            let words = [
                t.country.0,
                t.category.into(),
                t.subcategory.into(),
                t.specific.into(),
                t.extra.into(),
            ];
            assert!(seen.insert((t.domain, words)), "{designator} shares its type");
            let expected: &[u8] = match designator {
                "FIRE" | "SNOW" => &[LandCategory::SINGLE_UNIT_UTILITY_EMERGENCY_TRUCK.0],
                "BUS" => &[LandCategory::BUS.0],
                "FOLLOWME" => &[LandCategory::UTILITY_EMERGENCY_CAR.0],
                "TUG" => &[LandCategory::CONSTRUCTION_SPECIALTY_VEHICLE.0],
                "FUEL" => &[LandCategory::SINGLE_UNIT_CARGO_TRUCK.0],
                // Up to 5.67 t small, up to 115.7 t large, above heavy; two types stand near a limit.
                "C172" | "C550" => &[AirCategory::CIVILIAN_FIXED_WING_AIRCRAFT_SMALL.0],
                _ if row.class.span_m > 45.0 => {
                    &[AirCategory::CIVILIAN_FIXED_WING_AIRCRAFT_HEAVY.0]
                }
                _ => &[AirCategory::CIVILIAN_FIXED_WING_AIRCRAFT_LARGE.0],
            };
            assert!(expected.contains(&t.category), "{designator}: {t:?}");
            if t.subcategory != 0 && (t.specific != 0 || !row.class.aircraft) {
                let back = class_of(t, &known);
                assert_eq!(back.aircraft, row.class.aircraft);
                assert_eq!(
                    back.length_m, row.class.length_m,
                    "{designator} comes back as {}",
                    back.designator
                );
            }
        }
    }

    #[test]
    fn visitors_have_the_size_of_their_category() {
        let known = scenarios::types::shipped().expect("the table");
        let of = |domain, category, subcategory, specific| {
            class_of(EntityType::new(1, domain, 225, category, subcategory, specific, 0), &known)
        };
        assert_eq!(of(2, 87, 32, 5).span_m, 34.32, "some Boeing 737");
        assert_eq!(of(2, 87, 0, 0).designator, "large aircraft");
        assert_eq!(of(1, 82, 0, 0).length_m, 13.0);
        assert_eq!(of(1, 83, 0, 0).designator, "truck");
        assert_eq!(of(2, 21, 4, 0).designator, "medium helicopter");
        assert_eq!(of(1, 6, 0, 0).designator, "vehicle");
        assert_eq!(class_of(EntityType::new(3, 1, 225, 1, 0, 0, 0), &known).designator, "person");
    }
}
