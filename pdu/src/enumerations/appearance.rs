//! Appearance bits of the entities that an airport shows.

/// Declares the bits of an appearance word: a getter and a `with_` setter each.
macro_rules! bits {
    ($name:ident { $($bit:literal $get:ident $with:ident $text:literal,)* }) => {
        impl $name {
            $(
                #[doc = concat!($text, " (bit ", $bit, ").")]
                #[must_use]
                pub fn $get(self) -> bool {
                    self.0 >> $bit & 1 == 1
                }
                #[doc = concat!("The same with \"", $text, "\" set or cleared.")]
                #[must_use]
                pub fn $with(self, on: bool) -> Self {
                    Self(self.0 & !(1 << $bit) | u32::from(on) << $bit)
                }
            )*

            /// How damaged the entity looks (bits 3 and 4).
            #[must_use]
            pub fn damage(self) -> Damage {
                match self.0 >> 3 & 3 {
                    0 => Damage::None,
                    1 => Damage::Slight,
                    2 => Damage::Moderate,
                    _ => Damage::Destroyed,
                }
            }
            /// The same with another damage.
            #[must_use]
            pub fn with_damage(self, damage: Damage) -> Self {
                Self(self.0 & !(3 << 3) | (damage as u32) << 3)
            }

            /// The names of all bits that are set, in the order of the bits.
            pub fn names(self) -> impl Iterator<Item = &'static str> {
                [$(($bit, $text)),*]
                    .into_iter()
                    .filter(move |(bit, _)| self.0 >> bit & 1 == 1)
                    .map(|(_, text)| text)
            }
        }
    };
}

/// Visible damage. SISO-REF-010, UID 379.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// No damage.
    None = 0,
    /// Slight damage.
    Slight = 1,
    /// Moderate damage.
    Moderate = 2,
    /// Destroyed.
    Destroyed = 3,
}

/// Appearance of a land platform. SISO-REF-010, UID 31.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LandAppearance(
    /// The word on the wire.
    pub u32,
);

bits!(LandAppearance {
    0 camouflaged with_camouflaged "camouflage paint",
    1 mobility_killed with_mobility_killed "mobility killed",
    5 smoking with_smoking "smoke emanating",
    6 engine_smoke with_engine_smoke "engine emitting smoke",
    12 head_lights with_head_lights "head lights on",
    13 tail_lights with_tail_lights "tail lights on",
    14 brake_lights with_brake_lights "brake lights on",
    15 flaming with_flaming "flaming",
    21 frozen with_frozen "frozen",
    22 power_plant with_power_plant "power plant on",
    23 deactivated with_deactivated "deactivated",
    26 blackout_lights with_blackout_lights "blackout lights on",
    28 spot_light with_spot_light "spot or search light on",
    29 interior_lights with_interior_lights "interior lights on",
});

/// Appearance of an air platform. SISO-REF-010, UID 32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AirAppearance(
    /// The word on the wire.
    pub u32,
);

bits!(AirAppearance {
    0 camouflaged with_camouflaged "camouflage paint",
    1 propulsion_killed with_propulsion_killed "propulsion killed",
    5 smoking with_smoking "smoke emanating",
    6 engine_smoke with_engine_smoke "engine emitting smoke",
    12 landing_lights with_landing_lights "landing lights on",
    13 navigation_lights with_navigation_lights "navigation lights on",
    14 anti_collision_lights with_anti_collision_lights "anti-collision lights on",
    15 flaming with_flaming "flaming",
    16 afterburner with_afterburner "afterburner on",
    20 blinking with_blinking "lights blinking",
    21 frozen with_frozen "frozen",
    22 power_plant with_power_plant "power plant on",
    23 deactivated with_deactivated "deactivated",
    24 formation_lights with_formation_lights "formation lights on",
    25 landing_gear with_landing_gear "landing gear extended",
    26 cargo_doors with_cargo_doors "cargo doors open",
    28 spot_light with_spot_light "spot or search light on",
    29 interior_lights with_interior_lights "interior lights on",
    30 reverse_thrust with_reverse_thrust "reverse thrust engaged",
    31 weight_on_wheels with_weight_on_wheels "weight on wheels",
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_stand_where_the_standard_has_them() {
        let taxiing = AirAppearance::default()
            .with_landing_lights(true)
            .with_power_plant(true)
            .with_landing_gear(true)
            .with_weight_on_wheels(true);
        assert_eq!(taxiing.0, 1 << 12 | 1 << 22 | 1 << 25 | 1 << 31);
        assert_eq!(taxiing.with_landing_lights(false).0, 1 << 22 | 1 << 25 | 1 << 31);
        assert_eq!(
            taxiing.names().collect::<Vec<_>>(),
            ["landing lights on", "power plant on", "landing gear extended", "weight on wheels"]
        );
        let car = LandAppearance(0).with_damage(Damage::Destroyed).with_frozen(true);
        assert_eq!((car.0, car.damage()), (3 << 3 | 1 << 21, Damage::Destroyed));
    }
}
