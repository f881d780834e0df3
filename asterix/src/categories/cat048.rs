//! Category 048, monoradar target reports, edition 1.31.

use crate::table::*;

/// The category.
pub static CATEGORY: Category = Category {
    number: 48,
    edition: (1, 31),
    title: "Monoradar target reports",
    uap: &[
        Some(&I010),
        Some(&I140),
        Some(&I020),
        Some(&I040),
        Some(&I070),
        Some(&I090),
        Some(&I130),
        Some(&I220),
        Some(&I240),
        Some(&I250),
        Some(&I161),
        Some(&I042),
        Some(&I200),
        Some(&I170),
        Some(&I210),
        Some(&I030),
        Some(&I080),
        Some(&I100),
        Some(&I110),
        Some(&I120),
        Some(&I230),
        Some(&I260),
        Some(&I055),
        Some(&I050),
        Some(&I065),
        Some(&I060),
        Some(&SP),
        Some(&RE),
    ],
};

items! {
    I010 = 0, "010", "Data source identifier", fixed(&[u("SAC", 8), u("SIC", 8)]);
    I140 = 1, "140", "Time of day", fixed(&[tod("")]);
    I020 = 2, "020", "Target report descriptor", Extended(&[part(&[u("TYP", 3), u("SIM", 1), u("RDP", 1), u("SPI", 1), u("RAB", 1)]), part(&[u("TST", 1), u("ERR", 1), u("XPP", 1), u("ME", 1), u("MI", 1), u("FOEFRI", 2)]), part(&[u("ADSB_EP", 1), u("ADSB", 1), u("SCN_EP", 1), u("SCN", 1), u("PAI_EP", 1), u("PAI", 1), spare(1)])]);
    I040 = 3, "040", "Measured position in polar coordinates", fixed(&[q("RHO", 16, 1.0 / 256.0, "NM"), q("THETA", 16, deg(15), "°")]);
    I070 = 4, "070", "Mode-3/A code in octal representation", fixed(&[u("V", 1), u("G", 1), u("L", 1), spare(1), octal("M3A", 12)]);
    I090 = 5, "090", "Flight level in binary representation", fixed(&[u("V", 1), u("G", 1), sq("FL", 14, 1.0 / 4.0, "FL")]);
    I130_SRL = 0, "SRL", "SSR plot runlength", fixed(&[q("", 8, deg(12), "°")]);
    I130_SRR = 1, "SRR", "Number of received replies for (M)SSR", fixed(&[u("", 8)]);
    I130_SAM = 2, "SAM", "Amplitude of (M)SSR reply", fixed(&[sq("", 8, 1.0, "dBm")]);
    I130_PRL = 3, "PRL", "Primary plot runlength", fixed(&[q("", 8, deg(12), "°")]);
    I130_PAM = 4, "PAM", "Amplitude of primary plot", fixed(&[sq("", 8, 1.0, "dBm")]);
    I130_RPD = 5, "RPD", "Difference in range between PSR and SSR plot", fixed(&[sq("", 8, 1.0 / 256.0, "NM")]);
    I130_APD = 6, "APD", "Difference in azimuth between PSR and SSR plot", fixed(&[sq("", 8, deg(13), "°")]);
    I130 = 6, "130", "Radar plot characteristics", Compound(&[Some(&I130_SRL), Some(&I130_SRR), Some(&I130_SAM), Some(&I130_PRL), Some(&I130_PAM), Some(&I130_RPD), Some(&I130_APD)]);
    I220 = 7, "220", "Aircraft address", fixed(&[u("", 24)]);
    I240 = 8, "240", "Aircraft identification", fixed(&[ident("", 48)]);
    I250 = 9, "250", "BDS register data", Counted(part_of(&[u("MB", 56), u("B1", 4), u("B2", 4)]));
    I161 = 10, "161", "Track number", fixed(&[spare(4), u("TRN", 12)]);
    I042 = 11, "042", "Calculated position in cartesian coordinates", fixed(&[sq("X", 16, 1.0 / 128.0, "NM"), sq("Y", 16, 1.0 / 128.0, "NM")]);
    I200 = 12, "200", "Calculated track velocity in polar coordinates", fixed(&[q("GSP", 16, 1.0 / 16384.0, "NM/s"), q("HDG", 16, deg(15), "°")]);
    I170 = 13, "170", "Track status", Extended(&[part(&[u("CNF", 1), u("RAD", 2), u("DOU", 1), u("MAH", 1), u("CDM", 2)]), part(&[u("TRE", 1), u("GHO", 1), u("SUP", 1), u("TCC", 1), spare(3)])]);
    I210 = 14, "210", "Track quality", fixed(&[q("SIGX", 8, 1.0 / 128.0, "NM"), q("SIGY", 8, 1.0 / 128.0, "NM"), q("SIGV", 8, 1.0 / 16384.0, "NM/s"), q("SIGH", 8, deg(11), "°")]);
    I030 = 15, "030", "Warning/Error conditions and target classification", Chained(part(&[u("", 7)]));
    I080 = 16, "080", "Mode-3/A code confidence indicator", fixed(&[spare(4), u("QA4", 1), u("QA2", 1), u("QA1", 1), u("QB4", 1), u("QB2", 1), u("QB1", 1), u("QC4", 1), u("QC2", 1), u("QC1", 1), u("QD4", 1), u("QD2", 1), u("QD1", 1)]);
    I100 = 17, "100", "Mode-C code and code confidence indicator", fixed(&[u("V", 1), u("G", 1), spare(2), u("MODEC", 12), spare(4), u("QC1", 1), u("QA1", 1), u("QC2", 1), u("QA2", 1), u("QC4", 1), u("QA4", 1), u("QB1", 1), u("QD1", 1), u("QB2", 1), u("QD2", 1), u("QB4", 1), u("QD4", 1)]);
    I110 = 18, "110", "Height measured by a 3D radar", fixed(&[spare(2), sq("3DH", 14, 25.0, "ft")]);
    I120_CAL = 0, "CAL", "Calculated doppler speed", fixed(&[u("D", 1), spare(5), sq("CAL", 10, 1.0, "m/s")]);
    I120_RDS = 1, "RDS", "Raw doppler speed", Counted(part_of(&[q("DOP", 16, 1.0, "m/s"), q("AMB", 16, 1.0, "m/s"), q("FRQ", 16, 1.0, "MHz")]));
    I120 = 19, "120", "Radial doppler speed", Compound(&[Some(&I120_CAL), Some(&I120_RDS)]);
    I230 = 20, "230", "Communications/ACAS capability and flight status", fixed(&[u("COM", 3), u("STAT", 3), u("SI", 1), spare(1), u("MSSC", 1), u("ARC", 1), u("AIC", 1), u("B1A", 1), u("B1B", 4)]);
    I260 = 21, "260", "ACAS resolution advisory report", fixed(&[u("", 56)]);
    I055 = 22, "055", "Mode-1 code in octal representation", fixed(&[u("V", 1), u("G", 1), u("L", 1), u("MODE1", 5)]);
    I050 = 23, "050", "Mode-2 code in octal representation", fixed(&[u("V", 1), u("G", 1), u("L", 1), spare(1), octal("MODE2", 12)]);
    I065 = 24, "065", "Mode-1 code confidence indicator", fixed(&[spare(3), u("QA4", 1), u("QA2", 1), u("QA1", 1), u("QB2", 1), u("QB1", 1)]);
    I060 = 25, "060", "Mode-2 code confidence indicator", fixed(&[spare(4), u("QA4", 1), u("QA2", 1), u("QA1", 1), u("QB4", 1), u("QB2", 1), u("QB1", 1), u("QC4", 1), u("QC2", 1), u("QC1", 1), u("QD4", 1), u("QD2", 1), u("QD1", 1)]);
    SP = 26, "SP", "Special purpose field", Explicit(&[]);
    RE = 27, "RE", "Reserved expansion field", Explicit(&[]);
}
