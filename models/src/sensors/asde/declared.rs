//! What the house knows of surface movement radars.

use crate::environment::surface::MATERIALS;
use crate::keys::Key;
use crate::kind::{Assumed, Kind, Symbol};
use crate::sensors::declared::Declared;

/// Keys of a parameter set and of `overrides`. Limits that depend on other parameters are narrower.
pub const KEYS: &[Key] = &[
    Key::number("carrier_ghz", "GHz", 1.0, 100.0, "Carrier frequency").needed(),
    Key::number("peak_power_w", "W", 1e-3, 1e8, "Peak power of a pulse").needed(),
    Key::number("pulse_s", "s", 1e-9, 1e-3, "Length of a pulse").needed(),
    Key::number("bandwidth_hz", "Hz", 1e3, 1e10, "Bandwidth of the receiver").or("1 / pulse_s"),
    Key::number("noise_figure_db", "dB", 0.0, 40.0, "Noise figure of the receiver").needed(),
    Key::number("system_loss_db", "dB", 0.0, 60.0, "Losses that nothing else names").needed(),
    Key::number(
        "azimuth_beamwidth_deg",
        "°",
        0.01,
        30.0,
        "Width of the beam in azimuth at half power",
    )
    .needed(),
    Key::number(
        "elevation_beamwidth_deg",
        "°",
        0.05,
        90.0,
        "Width of the beam in elevation at half power",
    )
    .needed(),
    Key::number("tilt_deg", "°", -30.0, 60.0, "Depression of the beam's axis").needed(),
    Key::number(
        "csc2_limit_deg",
        "°",
        -30.0,
        90.0,
        "Depression to which cosecant-squared coverage reaches",
    )
    .or("no such coverage"),
    Key::number("gain_dbi", "dBi", 0.0, 70.0, "Gain of the antenna").needed(),
    Key::number(
        "antenna_height_m",
        "m",
        1.0,
        500.0,
        "Height of the antenna; the height of `site` goes before it",
    )
    .needed(),
    Key::number("prf_hz", "Hz", 100.0, 1e6, "Pulse repetition frequency").needed(),
    Key::number("rotation_rpm", "1/min", 1.0, 600.0, "Turns of the antenna").needed(),
    Key::number(
        "start_azimuth_deg",
        "°",
        -360.0,
        360.0,
        "Where the antenna looks when the run begins",
    )
    .or("0"),
    Key::word(
        "polarisation",
        || vec!["circular", "horizontal", "vertical"],
        "Polarisation of the wave",
    )
    .needed(),
    Key::number("axial_ratio_db", "dB", 0.0, 30.0, "Axial ratio of circular polarisation").needed(),
    Key::number(
        "circular_target_loss_db",
        "dB",
        0.0,
        20.0,
        "What circular polarisation takes of a target's echo",
    )
    .needed(),
    Key::number(
        "sidelobe_floor_db",
        "dB",
        -80.0,
        -3.0,
        "Level of the sidelobes below the beam's axis",
    )
    .needed(),
    Key::number("recovery_s", "s", 0.0, 1e-5, "Time after a pulse until the receiver hears")
        .needed(),
    Key::number("range_min_m", "m", 0.0, 60_000.0, "Nearest range that is shown").needed(),
    Key::number(
        "range_max_m",
        "m",
        100.0,
        60_000.0,
        "Farthest range that is shown; below the unambiguous one",
    )
    .needed(),
    Key::number("pfa", "", 1e-12, 0.1, "Probability of a false alarm in a cell").needed(),
    Key::number("pd", "", 0.01, 0.9999, "Probability of detection at the detector's design point")
        .needed(),
    Key::word(
        "detection",
        || vec!["threshold", "bernoulli"],
        "Detection by a threshold, or drawn with its probability",
    )
    .needed(),
    Key::whole("swerling", 0, 4, "Case of fluctuation").needed(),
    Key::word(
        "energy",
        || vec!["single_pulse", "dwell"],
        "What a range and angle are measured with",
    )
    .needed(),
    Key::number(
        "dwell_factor",
        "",
        1.0,
        10.0,
        "With `dwell`: what falls short of the ideal deviation",
    )
    .or("1.5"),
    Key::number("range_step_m", "m", 0.0, 100.0, "Steps of the range; 0: none").needed(),
    Key::number("azimuth_step_deg", "°", 0.0, 5.0, "Steps of the azimuth; 0: none").needed(),
    Key::number(
        "assumed_height_m",
        "m",
        0.0,
        500.0,
        "Height of a target that is assumed for its ground range",
    )
    .needed(),
    Key::flag("frequency_agile", "Whether the carrier hops from pulse to pulse").needed(),
    Key::number("rain_spread_mps", "m/s", 0.01, 20.0, "Spread of the speeds of rain").needed(),
    Key::number(
        "glint_sigma_m",
        "m",
        0.0,
        100.0,
        "Wander of the echo's centre on a large target, deviation",
    )
    .or("that of the model"),
    Key::number(
        "reflection_coupling",
        "",
        0.0,
        10.0,
        "How reflections at the surface shift the azimuth",
    )
    .needed(),
    Key::number("ground_gamma_db", "dB", -60.0, 10.0, "Echo of the ground at normal incidence")
        .needed(),
    Key::word("surface", || MATERIALS.iter().map(|m| m.name).collect(), "What the ground is of")
        .needed(),
    Key::number("roughness_m", "m", 0.0, 10.0, "Roughness of the ground, deviation of its height")
        .needed(),
    Key::number("rain_top_m", "m", 1.0, 20_000.0, "Top of the rain, above the antenna").needed(),
    Key::word("fog_law", || vec!["two_point", "eldridge"], "Water of fog by its visibility")
        .needed(),
];

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
