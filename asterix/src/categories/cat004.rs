//! Category 004, safety net messages, edition 1.13.

use crate::table::*;

/// The category.
pub static CATEGORY: Category = Category {
    number: 4,
    edition: (1, 13),
    title: "Safety net messages",
    uap: &[
        Some(&I010),
        Some(&I000),
        Some(&I015),
        Some(&I020),
        Some(&I040),
        Some(&I045),
        Some(&I060),
        Some(&I030),
        Some(&I170),
        Some(&I120),
        Some(&I070),
        Some(&I076),
        Some(&I074),
        Some(&I075),
        Some(&I100),
        Some(&I035),
        Some(&I171),
        Some(&I110),
        None,
        Some(&RE),
        Some(&SP),
    ],
};

items! {
    I010 = 0, "010", "Data source identifier", fixed(&[u("SAC", 8), u("SIC", 8)]);
    I000 = 1, "000", "Message type", fixed(&[u("", 8)]);
    I015 = 2, "015", "SDPS identifier", Counted(part_of(&[u("SAC", 8), u("SIC", 8)]));
    I020 = 3, "020", "Time of message", fixed(&[tod("")]);
    I040 = 4, "040", "Alert identifier", fixed(&[u("", 16)]);
    I045 = 5, "045", "Area and alert status", fixed(&[u("AREA_EP", 1), u("AREA", 3), u("STAT", 3), spare(1)]);
    I060 = 6, "060", "Safety net function and system status", Extended(&[part(&[u("MRVA", 1), u("RAMLD", 1), u("RAMHD", 1), u("MSAW", 1), u("APW", 1), u("CLAM", 1), u("STCA", 1)]), part(&[u("APM", 1), u("RIMCA", 1), u("ACASRA", 1), u("NTCA", 1), u("DG", 1), u("OF", 1), u("OL", 1)]), part(&[u("AIW", 1), u("PAIW", 1), u("OCAT", 1), u("SAM", 1), u("VCD", 1), u("CHAM", 1), u("DSAM", 1)]), part(&[u("DBPSMARR", 1), u("DBPSMDEP", 1), u("DBPSMTL", 1), u("VRAMCRM", 1), u("VRAMVTM", 1), u("VRAMVRM", 1), u("HAMHD", 1)]), part(&[u("HAMRD", 1), u("HAMVD", 1), u("HVI", 1), u("LTW", 1), u("VPM", 1), u("TTA", 1), u("CRA", 1)]), part(&[u("ASM", 1), u("IAVM", 1), u("FTD", 1), u("ITD", 1), u("IIA", 1), u("SQW", 1), u("CUW", 1)]), part(&[u("CATC", 1), u("NOCLR", 1), u("NOMOV", 1), u("NOH", 1), u("WRTY", 1), u("STOCC", 1), u("ONGOING", 1)]), part(&[u("NTZ", 1), spare(6)])]);
    I030 = 7, "030", "Track number 1", fixed(&[u("", 16)]);
    I170_AI1 = 0, "AI1", "Aircraft identifier (in 7 characters) of aircraft 1 involved in the conflict", fixed(&[ascii("", 56)]);
    I170_M31 = 1, "M31", "Mode 3/A code aircraft 1", fixed(&[spare(4), octal("M3A", 12)]);
    I170_CPW = 2, "CPW", "Predicted conflict position target 1 in WGS-84 coordinates", fixed(&[sq("LAT", 32, deg(25), "°"), sq("LON", 32, deg(25), "°"), sq("ALT", 16, 25.0, "ft")]);
    I170_CPC = 3, "CPC", "Predicted conflict position for the aircraft 1 involved in the conflict", fixed(&[sq("X", 24, 1.0 / 2.0, "m"), sq("Y", 24, 1.0 / 2.0, "m"), sq("Z", 16, 25.0, "ft")]);
    I170_TT1 = 4, "TT1", "Time to runway threshold for first approaching aircraft in a RIMCA", fixed(&[q("", 24, 1.0 / 128.0, "s")]);
    I170_DT1 = 5, "DT1", "Distance to runway threshold for aircraft 1 involved in a RIMCA", fixed(&[q("", 16, 1.0 / 2.0, "m")]);
    I170_AC1 = 6, "AC1", "Characteristics of aircraft 1 involved in the conflict", Extended(&[part(&[u("GATOAT", 2), u("FR", 2), u("RVSM", 2), u("HPR", 1)]), part(&[u("CDM", 2), u("PRI", 1), u("GV", 1), spare(3)])]);
    I170_MS1 = 7, "MS1", "Aircraft identification downloaded from aircraft 1 involved in the conflict if equipped with a Mode-S transponder", fixed(&[ident("", 48)]);
    I170_FP1 = 8, "FP1", "Number of the flight plan correlated to aircraft 1 involved in the conflict", fixed(&[spare(5), u("NBR", 27)]);
    I170_CF1 = 9, "CF1", "Cleared flight level for aircraft 1 involved in the conflict", fixed(&[q("", 16, 1.0 / 4.0, "FL")]);
    I170 = 8, "170", "Aircraft identification and characteristics 1", Compound(&[Some(&I170_AI1), Some(&I170_M31), Some(&I170_CPW), Some(&I170_CPC), Some(&I170_TT1), Some(&I170_DT1), Some(&I170_AC1), Some(&I170_MS1), Some(&I170_FP1), Some(&I170_CF1)]);
    I120_CN = 0, "CN", "Conflict nature", Extended(&[part(&[u("MAS", 1), u("CAS", 1), u("FLD", 1), u("FVD", 1), u("TYPE", 1), u("CROSS", 1), u("DIV", 1)]), part(&[u("RRC", 1), u("RTC", 1), u("MRVA", 1), u("VRAMCRM", 1), u("VRAMVRM", 1), u("VRAMVTM", 1), u("HAMHD", 1)]), part(&[u("HAMRD", 1), u("HAMVD", 1), u("DBPSMARR", 1), u("DBPSMDEP", 1), u("DBPSMTL", 1), u("AIW", 1), spare(1)])]);
    I120_CC = 1, "CC", "Conflict classification", fixed(&[u("TID", 4), u("CPC", 3), u("CS", 1)]);
    I120_CP = 2, "CP", "Conflict probability", fixed(&[q("", 8, 1.0 / 2.0, "%")]);
    I120_CD = 3, "CD", "Conflict duration", fixed(&[q("", 24, 1.0 / 128.0, "s")]);
    I120 = 9, "120", "Conflict characteristics", Compound(&[Some(&I120_CN), Some(&I120_CC), Some(&I120_CP), Some(&I120_CD)]);
    I070_TC = 0, "TC", "Time to conflict", fixed(&[q("", 24, 1.0 / 128.0, "s")]);
    I070_TCA = 1, "TCA", "Time to closest approach", fixed(&[q("", 24, 1.0 / 128.0, "s")]);
    I070_CHS = 2, "CHS", "Current horizontal separation", fixed(&[q("", 24, 1.0 / 2.0, "m")]);
    I070_MHS = 3, "MHS", "Estimated minimum horizontal separation", fixed(&[q("", 16, 1.0 / 2.0, "m")]);
    I070_CVS = 4, "CVS", "Current vertical separation", fixed(&[q("", 16, 25.0, "ft")]);
    I070_MVS = 5, "MVS", "Estimated minimum vertical separation", fixed(&[q("", 16, 25.0, "ft")]);
    I070 = 10, "070", "Conflict timing and separation", Compound(&[Some(&I070_TC), Some(&I070_TCA), Some(&I070_CHS), Some(&I070_MHS), Some(&I070_CVS), Some(&I070_MVS)]);
    I076 = 11, "076", "Vertical deviation", fixed(&[sq("", 16, 25.0, "ft")]);
    I074 = 12, "074", "Longitudinal deviation", fixed(&[sq("", 16, 32.0, "m")]);
    I075 = 13, "075", "Transversal distance deviation", fixed(&[sq("", 24, 1.0 / 2.0, "m")]);
    I100_AN = 0, "AN", "Area name", fixed(&[ident("", 48)]);
    I100_CAN = 1, "CAN", "Crossing area name", fixed(&[ascii("", 56)]);
    I100_RT1 = 2, "RT1", "Runway/Taxiway designator 1", fixed(&[ascii("", 56)]);
    I100_RT2 = 3, "RT2", "Runway/Taxiway designator 2", fixed(&[ascii("", 56)]);
    I100_SB = 4, "SB", "Stop bar designator", fixed(&[ascii("", 56)]);
    I100_G = 5, "G", "Gate designator", fixed(&[ascii("", 56)]);
    I100 = 14, "100", "Area definition", Compound(&[Some(&I100_AN), Some(&I100_CAN), Some(&I100_RT1), Some(&I100_RT2), Some(&I100_SB), Some(&I100_G)]);
    I035 = 15, "035", "Track number 2", fixed(&[u("", 16)]);
    I171_AI2 = 0, "AI2", "Aircraft identifier (in 7 characters) of aircraft 2 involved in the conflict", fixed(&[ascii("", 56)]);
    I171_M32 = 1, "M32", "Mode 3/A code aircraft 2", fixed(&[spare(4), octal("M3A", 12)]);
    I171_CPW = 2, "CPW", "Predicted conflict position target 2 in WGS-84 coordinates", fixed(&[sq("LAT", 32, deg(25), "°"), sq("LON", 32, deg(25), "°"), sq("ALT", 16, 25.0, "ft")]);
    I171_CPL = 3, "CPL", "Predicted conflict position for the aircraft 2 involved in the conflict", fixed(&[sq("X", 24, 1.0 / 2.0, "m"), sq("Y", 24, 1.0 / 2.0, "m"), sq("Z", 16, 25.0, "ft")]);
    I171_TT2 = 4, "TT2", "Time to runway threshold for second approaching aircraft in a RIMCA", fixed(&[q("", 24, 1.0 / 128.0, "s")]);
    I171_DT2 = 5, "DT2", "Distance to runway threshold for aircraft 2 involved in a RIMCA", fixed(&[q("", 16, 1.0 / 2.0, "m")]);
    I171_AC2 = 6, "AC2", "Characteristics of aircraft 2 involved in the conflict", Extended(&[part(&[u("GATOAT", 2), u("FR", 2), u("RVSM", 2), u("HPR", 1)]), part(&[u("CDM", 2), u("PRI", 1), u("GV", 1), spare(3)])]);
    I171_MS2 = 7, "MS2", "Aircraft identification downloaded from aircraft 2 involved in the conflict if eequipped with a Mode-S transponder", fixed(&[ident("", 48)]);
    I171_FP2 = 8, "FP2", "Number of the flight plan correlated to aircraft 2 involved in the conflict", fixed(&[spare(5), u("NBR", 27)]);
    I171_CF2 = 9, "CF2", "Cleared flight level for aircraft 2 involved in the conflict", fixed(&[q("", 16, 1.0 / 4.0, "FL")]);
    I171 = 16, "171", "Aircraft identification and characteristics 2", Compound(&[Some(&I171_AI2), Some(&I171_M32), Some(&I171_CPW), Some(&I171_CPL), Some(&I171_TT2), Some(&I171_DT2), Some(&I171_AC2), Some(&I171_MS2), Some(&I171_FP2), Some(&I171_CF2)]);
    I110 = 17, "110", "FDPS sector control identification", Counted(part_of(&[u("CEN", 8), u("POS", 8)]));
    RE = 19, "RE", "Reserved expansion field", Explicit(&[]);
    SP = 20, "SP", "Special purpose field", Explicit(&[]);
}
