//! What the house knows of surface movement radars.

use crate::keys::Key;
use crate::kind::{Assumed, Kind, Symbol};
use crate::sensors::declared::Declared;
use crate::sensors::radar::effects::VALUE_KEYS;
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
        keys: &ALL_KEYS,
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

/// Keys of the radar and of its effects that are values.
pub const ALL_KEYS: [&[Key]; 1 + VALUE_KEYS.len()] = {
    let mut all = [KEYS; 1 + VALUE_KEYS.len()];
    let mut n = 0;
    while n < VALUE_KEYS.len() {
        all[n + 1] = VALUE_KEYS[n];
        n += 1;
    }
    all
};
