//! Category 010, monosensor surface movement data, edition 1.1.

use crate::table::*;

/// The category.
pub static CATEGORY: Category = Category {
    number: 10,
    edition: (1, 1),
    title: "Monosensor surface movement data",
    uap: &[
        Some(&I010),
        Some(&I000),
        Some(&I020),
        Some(&I140),
        Some(&I041),
        Some(&I040),
        Some(&I042),
        Some(&I200),
        Some(&I202),
        Some(&I161),
        Some(&I170),
        Some(&I060),
        Some(&I220),
        Some(&I245),
        Some(&I250),
        Some(&I300),
        Some(&I090),
        Some(&I091),
        Some(&I270),
        Some(&I550),
        Some(&I310),
        Some(&I500),
        Some(&I280),
        Some(&I131),
        Some(&I210),
        None,
        Some(&SP),
        Some(&RE),
    ],
};

items! {
    I010 = 0, "010", "Data source identifier", fixed(&[u("SAC", 8), u("SIC", 8)]);
    I000 = 1, "000", "Message type", fixed(&[u("", 8)]);
    I020 = 2, "020", "Target report descriptor", Extended(&[part(&[u("TYP", 3), u("DCR", 1), u("CHN", 1), u("GBS", 1), u("CRT", 1)]), part(&[u("SIM", 1), u("TST", 1), u("RAB", 1), u("LOP", 2), u("TOT", 2)]), part(&[u("SPI", 1), spare(6)])]);
    I140 = 3, "140", "Time of day", fixed(&[tod("")]);
    I041 = 4, "041", "Position in WGS-84 coordinates", fixed(&[sq("LAT", 32, deg(31), "°"), sq("LON", 32, deg(31), "°")]);
    I040 = 5, "040", "Measured position in polar coordinates", fixed(&[q("RHO", 16, 1.0, "m"), q("TH", 16, deg(15), "°")]);
    I042 = 6, "042", "Position in cartesian coordinates", fixed(&[sq("X", 16, 1.0, "m"), sq("Y", 16, 1.0, "m")]);
    I200 = 7, "200", "Calculated track velocity in polar coordinates", fixed(&[q("GSP", 16, 1.0 / 16384.0, "NM/s"), q("TRA", 16, deg(15), "°")]);
    I202 = 8, "202", "Calculated track velocity in cartesian coordinates", fixed(&[sq("VX", 16, 1.0 / 4.0, "m/s"), sq("VY", 16, 1.0 / 4.0, "m/s")]);
    I161 = 9, "161", "Track number", fixed(&[spare(4), u("TRK", 12)]);
    I170 = 10, "170", "Track status", Extended(&[part(&[u("CNF", 1), u("TRE", 1), u("CST", 2), u("MAH", 1), u("TCC", 1), u("STH", 1)]), part(&[u("TOM", 2), u("DOU", 3), u("MRS", 2)]), part(&[u("GHO", 1), spare(6)])]);
    I060 = 11, "060", "Mode-3/A code in octal representation", fixed(&[u("V", 1), u("G", 1), u("L", 1), spare(1), octal("M3A", 12)]);
    I220 = 12, "220", "Target address", fixed(&[u("", 24)]);
    I245 = 13, "245", "Target identification", fixed(&[u("STI", 2), spare(6), ident("ID", 48)]);
    I250 = 14, "250", "Mode S MB data", Counted(part_of(&[u("MB", 56), u("B1", 4), u("B2", 4)]));
    I300 = 15, "300", "Vehicle fleet identification", fixed(&[u("", 8)]);
    I090 = 16, "090", "Flight level in binary representation", fixed(&[u("V", 1), u("G", 1), sq("FL", 14, 1.0 / 4.0, "FL")]);
    I091 = 17, "091", "Measured height", fixed(&[sq("", 16, 6.25, "ft")]);
    I270 = 18, "270", "Target size and orientation", Extended(&[part(&[q("LENGTH", 7, 1.0, "m")]), part(&[q("ORIENTATION", 7, deg(6), "°")]), part(&[q("WIDTH", 7, 1.0, "m")])]);
    I550 = 19, "550", "System status", fixed(&[u("NOGO", 2), u("OVL", 1), u("TSV", 1), u("DIV", 1), u("TTF", 1), spare(2)]);
    I310 = 20, "310", "Pre-programmed message", fixed(&[u("TRB", 1), u("MSG", 7)]);
    I500 = 21, "500", "Standard deviation of position", fixed(&[q("DEVX", 8, 1.0 / 4.0, "m"), q("DEVY", 8, 1.0 / 4.0, "m"), sq("COV", 16, 1.0 / 4.0, "m")]);
    I280 = 22, "280", "Presence", Counted(part_of(&[sq("DRHO", 8, 1.0, "m"), sq("DTHETA", 8, 0.15, "°")]));
    I131 = 23, "131", "Amplitude of primary plot", fixed(&[u("", 8)]);
    I210 = 24, "210", "Calculated acceleration", fixed(&[sq("AX", 8, 1.0 / 4.0, "m/s²"), sq("AY", 8, 1.0 / 4.0, "m/s²")]);
    SP = 26, "SP", "Special purpose field", Explicit(&[]);
    RE = 27, "RE", "Reserved expansion field", Explicit(&[]);
}
