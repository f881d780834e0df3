//! Category 020, multilateration messages, edition 1.10.

use crate::table::*;

/// The category.
pub static CATEGORY: Category = Category {
    number: 20,
    edition: (1, 10),
    title: "Multilateration messages",
    uap: &[
        Some(&I010),
        Some(&I020),
        Some(&I140),
        Some(&I041),
        Some(&I042),
        Some(&I161),
        Some(&I170),
        Some(&I070),
        Some(&I202),
        Some(&I090),
        Some(&I100),
        Some(&I220),
        Some(&I245),
        Some(&I110),
        Some(&I105),
        Some(&I210),
        Some(&I300),
        Some(&I310),
        Some(&I500),
        Some(&I400),
        Some(&I250),
        Some(&I230),
        Some(&I260),
        Some(&I030),
        Some(&I055),
        Some(&I050),
        Some(&RE),
        Some(&SP),
    ],
};

items! {
    I010 = 0, "010", "Data source identifier", fixed(&[u("SAC", 8), u("SIC", 8)]);
    I020 = 1, "020", "Target report descriptor", Extended(&[part(&[u("SSR", 1), u("MS", 1), u("HF", 1), u("VDL4", 1), u("UAT", 1), u("DME", 1), u("OT", 1)]), part(&[u("RAB", 1), u("SPI", 1), u("CHN", 1), u("GBS", 1), u("CRT", 1), u("SIM", 1), u("TST", 1)]), part(&[u("CF", 2), spare(5)])]);
    I140 = 2, "140", "Time of day", fixed(&[tod("")]);
    I041 = 3, "041", "Position in WGS-84 coordinates", fixed(&[sq("LAT", 32, deg(25), "°"), sq("LON", 32, deg(25), "°")]);
    I042 = 4, "042", "Position in cartesian coordinates", fixed(&[sq("X", 24, 1.0 / 2.0, "m"), sq("Y", 24, 1.0 / 2.0, "m")]);
    I161 = 5, "161", "Track number", fixed(&[spare(4), u("TRN", 12)]);
    I170 = 6, "170", "Track status", Extended(&[part(&[u("CNF", 1), u("TRE", 1), u("CST", 1), u("CDM", 2), u("MAH", 1), u("STH", 1)]), part(&[u("GHO", 1), spare(6)])]);
    I070 = 7, "070", "Mode-3/A code in octal representation", fixed(&[u("V", 1), u("G", 1), u("L", 1), spare(1), octal("M3A", 12)]);
    I202 = 8, "202", "Calculated track velocity in cartesian coordinates", fixed(&[sq("VX", 16, 1.0 / 4.0, "m/s"), sq("VY", 16, 1.0 / 4.0, "m/s")]);
    I090 = 9, "090", "Flight level in binary representation", fixed(&[u("V", 1), u("G", 1), sq("FL", 14, 1.0 / 4.0, "FL")]);
    I100 = 10, "100", "Mode C code", fixed(&[u("V", 1), u("G", 1), spare(2), u("MODEC", 12), spare(4), u("QC1", 1), u("QA1", 1), u("QC2", 1), u("QA2", 1), u("QC4", 1), u("QA4", 1), u("QB1", 1), u("QD1", 1), u("QB2", 1), u("QD2", 1), u("QB4", 1), u("QD4", 1)]);
    I220 = 11, "220", "Target address", fixed(&[u("", 24)]);
    I245 = 12, "245", "Target identification", fixed(&[u("STI", 2), spare(6), ident("ID", 48)]);
    I110 = 13, "110", "Measured height (local cartesian coordinates)", fixed(&[sq("", 16, 6.25, "ft")]);
    I105 = 14, "105", "Geometric height (WGS-84)", fixed(&[sq("", 16, 6.25, "ft")]);
    I210 = 15, "210", "Calculated acceleration", fixed(&[sq("AX", 8, 1.0 / 4.0, "m/s²"), sq("AY", 8, 1.0 / 4.0, "m/s²")]);
    I300 = 16, "300", "Vehicle fleet identification", fixed(&[u("", 8)]);
    I310 = 17, "310", "Pre-programmed message", fixed(&[u("TRB", 1), u("MSG", 7)]);
    I500_DOP = 0, "DOP", "DOP of position", fixed(&[q("X", 16, 1.0 / 4.0, ""), q("Y", 16, 1.0 / 4.0, ""), q("XY", 16, 1.0 / 4.0, "")]);
    I500_SDP = 1, "SDP", "Standard deviation of position", fixed(&[q("X", 16, 1.0 / 4.0, "m"), q("Y", 16, 1.0 / 4.0, "m"), sq("XY", 16, 1.0 / 4.0, "")]);
    I500_SDH = 2, "SDH", "Standard deviation of geometric height (WGS 84)", fixed(&[q("", 16, 1.0 / 2.0, "m")]);
    I500 = 18, "500", "Position accuracy", Compound(&[Some(&I500_DOP), Some(&I500_SDP), Some(&I500_SDH)]);
    I400 = 19, "400", "Contributing devices", Counted(part_of(&[u("", 8)]));
    I250 = 20, "250", "BDS register data", Counted(part_of(&[u("MB", 56), u("B1", 4), u("B2", 4)]));
    I230 = 21, "230", "Communications/ACAS capability and flight status", fixed(&[u("COM", 3), u("STAT", 3), spare(2), u("MSSC", 1), u("ARC", 1), u("AIC", 1), u("B1A", 1), u("B1B", 4)]);
    I260 = 22, "260", "ACAS resolution advisory report", fixed(&[u("", 56)]);
    I030 = 23, "030", "Warning/Error conditions", Chained(part(&[u("", 7)]));
    I055 = 24, "055", "Mode-1 code in octal representation", fixed(&[u("V", 1), u("G", 1), u("L", 1), u("MODE1", 5)]);
    I050 = 25, "050", "Mode-2 code in octal representation", fixed(&[u("V", 1), u("G", 1), u("L", 1), spare(1), octal("MODE2", 12)]);
    RE = 26, "RE", "Reserved expansion field", Explicit(&[]);
    SP = 27, "SP", "Special purpose field", Explicit(&[]);
}
