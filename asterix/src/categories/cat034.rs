//! Category 034, monoradar service messages, edition 1.29.

use crate::table::*;

/// The category.
pub static CATEGORY: Category = Category {
    number: 34,
    edition: (1, 29),
    title: "Monoradar service messages",
    uap: &[
        Some(&I010),
        Some(&I000),
        Some(&I030),
        Some(&I020),
        Some(&I041),
        Some(&I050),
        Some(&I060),
        Some(&I070),
        Some(&I100),
        Some(&I110),
        Some(&I120),
        Some(&I090),
        Some(&RE),
        Some(&SP),
    ],
};

items! {
    I010 = 0, "010", "Data source identifier", fixed(&[u("SAC", 8), u("SIC", 8)]);
    I000 = 1, "000", "Message type", fixed(&[u("", 8)]);
    I030 = 2, "030", "Time of day", fixed(&[tod("")]);
    I020 = 3, "020", "Sector number", fixed(&[q("", 8, deg(7), "°")]);
    I041 = 4, "041", "Antenna rotation speed", fixed(&[q("", 16, 1.0 / 128.0, "s")]);
    I050_COM = 0, "COM", "Common part", fixed(&[u("NOGO", 1), u("RDPC", 1), u("RDPR", 1), u("OVLR", 1), u("OVLX", 1), u("MSC", 1), u("TSV", 1), spare(1)]);
    I050_PSR = 3, "PSR", "Specific status information for a PSR sensor", fixed(&[u("ANT", 1), u("CHAB", 2), u("OVL", 1), u("MSC", 1), spare(3)]);
    I050_SSR = 4, "SSR", "Specific status information for a SSR sensor", fixed(&[u("ANT", 1), u("CHAB", 2), u("OVL", 1), u("MSC", 1), spare(3)]);
    I050_MDS = 5, "MDS", "Specific status information for a mode S sensor", fixed(&[u("ANT", 1), u("CHAB", 2), u("OVL", 1), u("MSC", 1), u("SCF", 1), u("DLF", 1), u("OVLSCF", 1), u("OVLDLF", 1), spare(7)]);
    I050 = 5, "050", "System configuration and status", Compound(&[Some(&I050_COM), None, None, Some(&I050_PSR), Some(&I050_SSR), Some(&I050_MDS)]);
    I060_COM = 0, "COM", "Common part", fixed(&[spare(1), u("REDRDP", 3), u("REDXMT", 3), spare(1)]);
    I060_PSR = 3, "PSR", "Specific processing mode information for a PSR sensor", fixed(&[u("POL", 1), u("REDRAD", 3), u("STC", 2), spare(2)]);
    I060_SSR = 4, "SSR", "Specific processing mode information for a SSR sensor", fixed(&[u("REDRAD", 3), spare(5)]);
    I060_MDS = 5, "MDS", "Specific processing mode information for a mode S sensor", fixed(&[u("REDRAD", 3), u("CLU", 1), spare(4)]);
    I060 = 6, "060", "System processing mode", Compound(&[Some(&I060_COM), None, None, Some(&I060_PSR), Some(&I060_SSR), Some(&I060_MDS)]);
    I070 = 7, "070", "Message count values", Counted(part_of(&[u("TYP", 5), u("COUNT", 11)]));
    I100 = 8, "100", "Generic polar window", fixed(&[q("RHOST", 16, 1.0 / 256.0, "NM"), q("RHOEND", 16, 1.0 / 256.0, "NM"), q("THETAST", 16, deg(15), "°"), q("THETAEND", 16, deg(15), "°")]);
    I110 = 9, "110", "Data filter", fixed(&[u("", 8)]);
    I120 = 10, "120", "3D-Position of data source", fixed(&[sq("H", 16, 1.0, "m"), sq("LAT", 24, deg(23), "°"), sq("LON", 24, deg(23), "°")]);
    I090 = 11, "090", "Collimation error", fixed(&[sq("RNG", 8, 1.0 / 128.0, "NM"), sq("AZM", 8, deg(13), "°")]);
    RE = 12, "RE", "Reserved expansion field", Explicit(&[]);
    SP = 13, "SP", "Special purpose field", Explicit(&[]);
}
