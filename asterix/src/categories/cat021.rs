//! Category 021, ADS-B messages, edition 2.6.

use crate::table::*;

/// The category.
pub static CATEGORY: Category = Category {
    number: 21,
    edition: (2, 6),
    title: "ADS-B messages",
    uap: &[
        Some(&I010),
        Some(&I040),
        Some(&I161),
        Some(&I015),
        Some(&I071),
        Some(&I130),
        Some(&I131),
        Some(&I072),
        Some(&I150),
        Some(&I151),
        Some(&I080),
        Some(&I073),
        Some(&I074),
        Some(&I075),
        Some(&I076),
        Some(&I140),
        Some(&I090),
        Some(&I210),
        Some(&I070),
        Some(&I230),
        Some(&I145),
        Some(&I152),
        Some(&I200),
        Some(&I155),
        Some(&I157),
        Some(&I160),
        Some(&I165),
        Some(&I077),
        Some(&I170),
        Some(&I020),
        Some(&I220),
        Some(&I146),
        Some(&I148),
        Some(&I110),
        Some(&I016),
        Some(&I008),
        Some(&I271),
        Some(&I132),
        Some(&I250),
        Some(&I260),
        Some(&I400),
        Some(&I295),
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
    I010 = 0, "010", "Data source identification", fixed(&[u("SAC", 8), u("SIC", 8)]);
    I040 = 1, "040", "Target report descriptor", Extended(&[part(&[u("ATP", 3), u("ARC", 2), u("RC", 1), u("RAB", 1)]), part(&[u("DCR", 1), u("GBS", 1), u("SIM", 1), u("TST", 1), u("SAA", 1), u("CL", 2)]), part(&[spare(1), u("LLC", 1), u("IPC", 1), u("NOGO", 1), u("CPR", 1), u("LDPJ", 1), u("RCF", 1)]), part(&[u("TBC_EP", 1), u("TBC", 6)]), part(&[u("MBC_EP", 1), u("MBC", 6)])]);
    I161 = 2, "161", "Track number", fixed(&[spare(4), u("TRNUM", 12)]);
    I015 = 3, "015", "Service identification", fixed(&[u("", 8)]);
    I071 = 4, "071", "Time of applicability for position", fixed(&[tod("")]);
    I130 = 5, "130", "Position in WGS-84 coordinates", fixed(&[sq("LAT", 24, deg(23), "°"), sq("LON", 24, deg(23), "°")]);
    I131 = 6, "131", "High-Resolution position in WGS-84 coordinates", fixed(&[sq("LAT", 32, deg(30), "°"), sq("LON", 32, deg(30), "°")]);
    I072 = 7, "072", "Time of applicability for velocity", fixed(&[tod("")]);
    I150 = 8, "150", "Air speed", fixed(&[u("IM", 1), u("AS", 15)]);
    I151 = 9, "151", "True airspeed", fixed(&[u("RE", 1), q("TAS", 15, 1.0, "kt")]);
    I080 = 10, "080", "Target address", fixed(&[u("", 24)]);
    I073 = 11, "073", "Time of message reception for position", fixed(&[tod("")]);
    I074 = 12, "074", "Time of message reception of Position-High precision", fixed(&[u("FSI", 2), q("TOMRP", 30, 1.0 / 1073741824.0, "s")]);
    I075 = 13, "075", "Time of message reception for velocity", fixed(&[tod("")]);
    I076 = 14, "076", "Time of message reception of Velocity-High precision", fixed(&[u("FSI", 2), q("TOMRP", 30, 1.0 / 1073741824.0, "s")]);
    I140 = 15, "140", "Geometric height", fixed(&[sq("", 16, 6.25, "ft")]);
    I090 = 16, "090", "Quality indicators", Extended(&[part(&[u("NACV", 3), u("NIC", 4)]), part(&[u("NICBARO", 1), u("SIL", 2), u("NACP", 4)]), part(&[spare(2), u("SILS", 1), u("SDA", 2), u("GVA", 2)]), part(&[u("PIC", 4), spare(3)])]);
    I210 = 17, "210", "MOPS version", fixed(&[spare(1), u("VNS", 1), u("VN", 3), u("LTT", 3)]);
    I070 = 18, "070", "Mode 3/A code in octal representation", fixed(&[spare(4), octal("M3A", 12)]);
    I230 = 19, "230", "Roll angle", fixed(&[sq("", 16, 0.01, "°")]);
    I145 = 20, "145", "Flight level", fixed(&[sq("", 16, 1.0 / 4.0, "FL")]);
    I152 = 21, "152", "Magnetic heading", fixed(&[q("", 16, deg(15), "°")]);
    I200 = 22, "200", "Target status", fixed(&[u("ICF", 1), u("LNAV", 1), u("ME", 1), u("PS", 3), u("SS", 2)]);
    I155 = 23, "155", "Barometric vertical rate", fixed(&[u("RE", 1), sq("R", 15, 6.25, "ft/min")]);
    I157 = 24, "157", "Geometric vertical rate", fixed(&[u("RE", 1), sq("R", 15, 6.25, "ft/min")]);
    I160 = 25, "160", "Airborne ground vector", fixed(&[u("RE", 1), q("GS", 15, 1.0 / 16384.0, "NM/s"), q("TA", 16, deg(15), "°")]);
    I165 = 26, "165", "Track angle rate", fixed(&[spare(6), sq("TAR", 10, 1.0 / 32.0, "°/s")]);
    I077 = 27, "077", "Time of ASTERIX report transmission", fixed(&[tod("")]);
    I170 = 28, "170", "Target identification", fixed(&[ident("", 48)]);
    I020 = 29, "020", "Emitter category", fixed(&[u("", 8)]);
    I220_WS = 0, "WS", "Wind speed", fixed(&[q("", 16, 1.0, "kt")]);
    I220_WD = 1, "WD", "Wind direction", fixed(&[q("", 16, 1.0, "°")]);
    I220_TMP = 2, "TMP", "Temperature", fixed(&[sq("", 16, 1.0 / 4.0, "°C")]);
    I220_TRB = 3, "TRB", "Turbulence", fixed(&[u("", 8)]);
    I220 = 30, "220", "Met information", Compound(&[Some(&I220_WS), Some(&I220_WD), Some(&I220_TMP), Some(&I220_TRB)]);
    I146 = 31, "146", "Selected altitude", fixed(&[u("SAS", 1), u("S", 2), sq("ALT", 13, 25.0, "ft")]);
    I148 = 32, "148", "Final state selected altitude", fixed(&[u("MV", 1), u("AH", 1), u("AM", 1), sq("ALT", 13, 25.0, "ft")]);
    I110_TIS = 0, "TIS", "Trajectory intent status", Extended(&[part(&[u("NAV", 1), u("NVB", 1), spare(5)])]);
    I110_TID = 1, "TID", "Trajectory intent data", Counted(part_of(&[u("TCA", 1), u("NC", 1), u("TCPN", 6), sq("ALT", 16, 10.0, "ft"), sq("LAT", 24, deg(23), "°"), sq("LON", 24, deg(23), "°"), u("PT", 4), u("TD", 2), u("TRA", 1), u("TOA", 1), q("TOV", 24, 1.0, "s"), q("TTR", 16, 0.01, "NM")]));
    I110 = 33, "110", "Trajectory intent", Compound(&[Some(&I110_TIS), Some(&I110_TID)]);
    I016 = 34, "016", "Service management", fixed(&[q("", 8, 1.0 / 2.0, "s")]);
    I008 = 35, "008", "Aircraft operational status", fixed(&[u("RA", 1), u("TC", 2), u("TS", 1), u("ARV", 1), u("CDTIA", 1), u("NOTTCAS", 1), u("SA", 1)]);
    I271 = 36, "271", "Surface capabilities and characteristics", Extended(&[part(&[spare(2), u("POA", 1), u("CDTIS", 1), u("B2LOW", 1), u("RAS", 1), u("IDENT", 1)]), part(&[u("LW", 4), spare(3)])]);
    I132 = 37, "132", "Message amplitude", fixed(&[sq("", 8, 1.0, "dBm")]);
    I250 = 38, "250", "Mode S MB data", Counted(part_of(&[u("MB", 56), u("B1", 4), u("B2", 4)]));
    I260 = 39, "260", "ACAS resolution advisory report", fixed(&[u("TYP", 5), u("STYP", 3), u("ARA", 14), u("RAC", 4), u("RAT", 1), u("MTE", 1), u("TTI", 2), u("TID", 26)]);
    I400 = 40, "400", "Receiver ID", fixed(&[u("", 8)]);
    I295_AOS = 0, "AOS", "Aircraft operational status age", fixed(&[q("", 8, 0.1, "s")]);
    I295_TRD = 1, "TRD", "Target report descriptor age", fixed(&[q("", 8, 0.1, "s")]);
    I295_M3A = 2, "M3A", "Mode 3/A age", fixed(&[q("", 8, 0.1, "s")]);
    I295_QI = 3, "QI", "Quality indicators age", fixed(&[q("", 8, 0.1, "s")]);
    I295_TI1 = 4, "TI1", "Trajectory intent age", fixed(&[q("", 8, 0.1, "s")]);
    I295_MAM = 5, "MAM", "Message amplitude age", fixed(&[q("", 8, 0.1, "s")]);
    I295_GH = 6, "GH", "Geometric height age", fixed(&[q("", 8, 0.1, "s")]);
    I295_FL = 7, "FL", "Flight level age", fixed(&[q("", 8, 0.1, "s")]);
    I295_SAL = 8, "SAL", "Selected altitude age", fixed(&[q("", 8, 0.1, "s")]);
    I295_FSA = 9, "FSA", "Final state selected altitude age", fixed(&[q("", 8, 0.1, "s")]);
    I295_AS = 10, "AS", "Air speed age", fixed(&[q("", 8, 0.1, "s")]);
    I295_TAS = 11, "TAS", "True air speed age", fixed(&[q("", 8, 0.1, "s")]);
    I295_MH = 12, "MH", "Magnetic heading age", fixed(&[q("", 8, 0.1, "s")]);
    I295_BVR = 13, "BVR", "Barometric vertical rate age", fixed(&[q("", 8, 0.1, "s")]);
    I295_GVR = 14, "GVR", "Geometric vertical rate age", fixed(&[q("", 8, 0.1, "s")]);
    I295_GV = 15, "GV", "Ground vector age", fixed(&[q("", 8, 0.1, "s")]);
    I295_TAR = 16, "TAR", "Track angle rate age", fixed(&[q("", 8, 0.1, "s")]);
    I295_TI2 = 17, "TI2", "Target identification age", fixed(&[q("", 8, 0.1, "s")]);
    I295_TS = 18, "TS", "Target status age", fixed(&[q("", 8, 0.1, "s")]);
    I295_MET = 19, "MET", "Met information age", fixed(&[q("", 8, 0.1, "s")]);
    I295_ROA = 20, "ROA", "Roll angle age", fixed(&[q("", 8, 0.1, "s")]);
    I295_ARA = 21, "ARA", "ACAS resolution advisory age", fixed(&[q("", 8, 0.1, "s")]);
    I295_SCC = 22, "SCC", "Surface capabilities and characteristics age", fixed(&[q("", 8, 0.1, "s")]);
    I295 = 41, "295", "Data ages", Compound(&[Some(&I295_AOS), Some(&I295_TRD), Some(&I295_M3A), Some(&I295_QI), Some(&I295_TI1), Some(&I295_MAM), Some(&I295_GH), Some(&I295_FL), Some(&I295_SAL), Some(&I295_FSA), Some(&I295_AS), Some(&I295_TAS), Some(&I295_MH), Some(&I295_BVR), Some(&I295_GVR), Some(&I295_GV), Some(&I295_TAR), Some(&I295_TI2), Some(&I295_TS), Some(&I295_MET), Some(&I295_ROA), Some(&I295_ARA), Some(&I295_SCC)]);
    RE_BPS = 0, "BPS", "Barometric pressure setting", fixed(&[spare(4), q("BPS", 12, 0.1, "hPa")]);
    RE_SH = 1, "SH", "Selected heading", fixed(&[spare(4), u("HDR", 1), u("STAT", 1), q("SH", 10, deg(8), "°")]);
    RE_NAV = 2, "NAV", "Navigation mode", fixed(&[u("AP", 1), u("VN", 1), u("AH", 1), u("AM", 1), u("MFM_EP", 1), u("MFM", 1), spare(2)]);
    RE_GAO = 3, "GAO", "GPS antenna offset", fixed(&[u("", 8)]);
    RE_SGV = 4, "SGV", "Surface ground vector", Extended(&[part(&[u("STP", 1), u("HTS", 1), u("HTT", 1), u("HRD", 1), q("GSS", 11, 1.0 / 8.0, "kt")]), part(&[q("HGT", 7, deg(6), "°")])]);
    RE_STA = 5, "STA", "Aircraft status", Extended(&[part(&[u("ES", 1), u("UAT", 1), u("RCE_EP", 1), u("RCE", 2), u("RRL_EP", 1), u("RRL", 1)]), part(&[u("PS3_EP", 1), u("PS3", 3), u("TPW_EP", 1), u("TPW", 2)]), part(&[u("TSI_EP", 1), u("TSI", 2), u("MUO_EP", 1), u("MUO", 1), u("RWC_EP", 1), u("RWC", 1)]), part(&[u("DAA_EP", 1), u("DAA", 2), u("DF17CA_EP", 1), u("DF17CA", 3)]), part(&[u("SVH_EP", 1), u("SVH", 2), u("CATC_EP", 1), u("CATC", 3)]), part(&[u("TAO_EP", 1), u("TAO", 5), spare(1)])]);
    RE_TNH = 6, "TNH", "True north heading", fixed(&[q("", 16, deg(15), "°")]);
    RE_MES_SUM = 0, "SUM", "Mode 5 summary", fixed(&[u("M5", 1), u("ID", 1), u("DA", 1), u("M1", 1), u("M2", 1), u("M3", 1), u("MC", 1), u("PO", 1)]);
    RE_MES_PNO = 1, "PNO", "Mode 5 PIN / national origin", fixed(&[spare(2), u("PIN", 14), spare(5), u("NO", 11)]);
    RE_MES_EM1 = 2, "EM1", "Extended mode 1 code in octal representation", fixed(&[u("V", 1), spare(1), u("L", 1), spare(1), octal("EM1", 12)]);
    RE_MES_XP = 3, "XP", "X pulse presence", fixed(&[spare(2), u("XP", 1), u("X5", 1), u("XC", 1), u("X3", 1), u("X2", 1), u("X1", 1)]);
    RE_MES_FOM = 4, "FOM", "Figure of merit", fixed(&[spare(3), u("FOM", 5)]);
    RE_MES_M2 = 5, "M2", "Mode 2 code in octal representation", fixed(&[u("V", 1), spare(1), u("L", 1), spare(1), octal("MODE2", 12)]);
    RE_MES = 7, "MES", "Military extended squitter", Compound(&[Some(&RE_MES_SUM), Some(&RE_MES_PNO), Some(&RE_MES_EM1), Some(&RE_MES_XP), Some(&RE_MES_FOM), Some(&RE_MES_M2)]);
    RE = 47, "RE", "Reserved expansion field", Explicit(&[Some(&RE_BPS), Some(&RE_SH), Some(&RE_NAV), Some(&RE_GAO), Some(&RE_SGV), Some(&RE_STA), Some(&RE_TNH), Some(&RE_MES)]);
    SP = 48, "SP", "Special purpose field", Explicit(&[]);
}
