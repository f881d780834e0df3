//! Category 019, multilateration system status messages, edition 1.3.

use crate::table::*;

/// The category.
pub static CATEGORY: Category = Category {
    number: 19,
    edition: (1, 3),
    title: "Multilateration system status messages",
    uap: &[
        Some(&I010),
        Some(&I000),
        Some(&I140),
        Some(&I550),
        Some(&I551),
        Some(&I552),
        Some(&I553),
        Some(&I600),
        Some(&I610),
        Some(&I620),
        None,
        None,
        Some(&RE),
        Some(&SP),
    ],
};

items! {
    I010 = 0, "010", "Data source identifier", fixed(&[u("SAC", 8), u("SIC", 8)]);
    I000 = 1, "000", "Message type", fixed(&[u("", 8)]);
    I140 = 2, "140", "Time of day", fixed(&[tod("")]);
    I550 = 3, "550", "System status", fixed(&[u("NOGO", 2), u("OVL", 1), u("TSV", 1), u("TTF", 1), spare(3)]);
    I551 = 4, "551", "Tracking processor detailed status", fixed(&[u("", 8)]);
    I552 = 5, "552", "Remote sensor detailed status", Counted(part_of(&[u("RSI", 8), spare(1), u("RS1090", 1), u("TX1030", 1), u("TX1090", 1), u("RSS", 1), u("RSO", 1), spare(2)]));
    I553 = 6, "553", "Reference transponder detailed status", Extended(&[part(&[u("R1", 2), spare(2), u("R2", 2), spare(1)]), part(&[u("R3", 2), spare(2), u("R4", 2), spare(1)])]);
    I600 = 7, "600", "Position of the MLT system reference point", fixed(&[sq("LAT", 32, deg(30), "°"), sq("LON", 32, deg(30), "°")]);
    I610 = 8, "610", "Height of the MLT system reference point", fixed(&[sq("", 16, 1.0 / 4.0, "m")]);
    I620 = 9, "620", "WGS-84 undulation", fixed(&[sq("", 8, 1.0, "m")]);
    RE = 12, "RE", "Reserved expansion field", Explicit(&[]);
    SP = 13, "SP", "Special purpose field", Explicit(&[]);
}
