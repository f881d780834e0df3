//! Category 065, SDPS service status reports, edition 1.5.

use crate::table::*;

/// The category.
pub static CATEGORY: Category = Category {
    number: 65,
    edition: (1, 5),
    title: "SDPS service status reports",
    uap: &[
        Some(&I010),
        Some(&I000),
        Some(&I015),
        Some(&I030),
        Some(&I020),
        Some(&I040),
        Some(&I050),
        None,
        None,
        None,
        None,
        None,
        Some(&RE),
        Some(&SP),
    ],
};

items! {
    I010 = 0, "010", "Data source identifier", fixed(&[u("SAC", 8), u("SIC", 8)]);
    I000 = 1, "000", "Message type", fixed(&[u("", 8)]);
    I015 = 2, "015", "Service identification", fixed(&[u("", 8)]);
    I030 = 3, "030", "Time of message", fixed(&[tod("")]);
    I020 = 4, "020", "Batch number", fixed(&[u("", 8)]);
    I040 = 5, "040", "SDPS configuration and status", fixed(&[u("NOGO", 2), u("OVL", 1), u("TSV", 1), u("PSS", 2), u("STTN", 1), spare(1)]);
    I050 = 6, "050", "Service status report", fixed(&[u("", 8)]);
    RE = 12, "RE", "Reserved expansion field", Explicit(&[]);
    SP = 13, "SP", "Special purpose field", Explicit(&[]);
}
