//! What the house knows of surface movement radars.

use crate::kind::{Assumed, Kind, Symbol};
use crate::sensors::declared::Declared;
use crate::sensors::radar::parameters::KEYS;

/// The kind `asde`.
pub static DECLARED: Declared = Declared {
    kind: Kind {
        word: "asde",
        title: "Surface movement radar",
        about: "Echoes of a rotating beam: rain, fog, ground, reflections, shadows, extent of targets, false alarms",
        colours: ["#c39bf0", "#6d35b5"],
        symbol: Symbol::SQUARE,
        radar: true,
        needs_site: true,
        carried: false,
        presets: &[],
        keys: &[KEYS],
        draws: &[],
        // The tail of glint; where the echo lies is the law of echoes' affair.
        assumed: Assumed {
            detection: 0.9,
            false_density_m2: 2e-8,
            extra_sigma_m: 1.0,
            ..Assumed::NOTHING
        },
    },
    read: None,
    models: &[],
};
