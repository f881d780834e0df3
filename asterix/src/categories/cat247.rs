//! Category 247, version number exchange, edition 1.3.

use crate::table::*;

/// The category.
pub static CATEGORY: Category = Category {
    number: 247,
    edition: (1, 3),
    title: "Version number exchange",
    uap: &[Some(&I010), Some(&I015), Some(&I140), Some(&I550), None, Some(&SP), Some(&RE)],
};

items! {
    I010 = 0, "010", "Data source identifier", fixed(&[u("SAC", 8), u("SIC", 8)]);
    I015 = 1, "015", "Service identification", fixed(&[u("", 8)]);
    I140 = 2, "140", "Time of day", fixed(&[tod("")]);
    I550 = 3, "550", "Category version number report", Counted(part_of(&[u("CAT", 8), u("MAIN", 8), u("SUB", 8)]));
    SP = 5, "SP", "Special purpose field", Explicit(&[]);
    RE = 6, "RE", "Reserved expansion field", Explicit(&[]);
}
