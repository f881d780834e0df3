//! Category 062, system track data, edition 1.20.

use crate::table::*;

/// The category.
pub static CATEGORY: Category = Category {
    number: 62,
    edition: (1, 20),
    title: "System track data",
    uap: &[
        Some(&I010),
        None,
        Some(&I015),
        Some(&I070),
        Some(&I105),
        Some(&I100),
        Some(&I185),
        Some(&I210),
        Some(&I060),
        Some(&I245),
        Some(&I380),
        Some(&I040),
        Some(&I080),
        Some(&I290),
        Some(&I200),
        Some(&I295),
        Some(&I136),
        Some(&I130),
        Some(&I135),
        Some(&I220),
        Some(&I390),
        Some(&I270),
        Some(&I300),
        Some(&I110),
        Some(&I120),
        Some(&I510),
        Some(&I500),
        Some(&I340),
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
    I015 = 2, "015", "Service identification", fixed(&[u("", 8)]);
    I070 = 3, "070", "Time of track information", fixed(&[tod("")]);
    I105 = 4, "105", "Calculated position in WGS-84 coordinates", fixed(&[sq("LAT", 32, deg(25), "°"), sq("LON", 32, deg(25), "°")]);
    I100 = 5, "100", "Calculated track position (cartesian)", fixed(&[sq("X", 24, 1.0 / 2.0, "m"), sq("Y", 24, 1.0 / 2.0, "m")]);
    I185 = 6, "185", "Calculated track velocity (cartesian)", fixed(&[sq("VX", 16, 1.0 / 4.0, "m/s"), sq("VY", 16, 1.0 / 4.0, "m/s")]);
    I210 = 7, "210", "Calculated acceleration (cartesian)", fixed(&[sq("AX", 8, 1.0 / 4.0, "m/s²"), sq("AY", 8, 1.0 / 4.0, "m/s²")]);
    I060 = 8, "060", "Track mode 3/A code", fixed(&[u("V", 1), u("G", 1), u("CH", 1), spare(1), octal("M3A", 12)]);
    I245 = 9, "245", "Target identification", fixed(&[u("STI", 2), spare(6), ident("ID", 48)]);
    I380_ADR = 0, "ADR", "Target address", fixed(&[u("", 24)]);
    I380_ID = 1, "ID", "Target identification", fixed(&[ident("", 48)]);
    I380_MHG = 2, "MHG", "Magnetic heading", fixed(&[q("", 16, deg(15), "°")]);
    I380_IAS = 3, "IAS", "Indicated Airspeed/Mach no", fixed(&[u("IM", 1), u("IAS", 15)]);
    I380_TAS = 4, "TAS", "True airspeed", fixed(&[q("", 16, 1.0, "kt")]);
    I380_SAL = 5, "SAL", "Selected altitude", fixed(&[u("SAS", 1), u("SRC", 2), sq("ALT", 13, 25.0, "ft")]);
    I380_FSS = 6, "FSS", "Final state selected altitude", fixed(&[u("MV", 1), u("AH", 1), u("AM", 1), sq("ALT", 13, 25.0, "ft")]);
    I380_TIS = 7, "TIS", "Trajectory intent status", Extended(&[part(&[u("NAV", 1), u("NVB", 1), spare(5)])]);
    I380_TID = 8, "TID", "Trajectory intent data", Counted(part_of(&[u("TCA", 1), u("NC", 1), u("TCPN", 6), sq("ALT", 16, 10.0, "ft"), sq("LAT", 24, deg(23), "°"), sq("LON", 24, deg(23), "°"), u("PT", 4), u("TD", 2), u("TRA", 1), u("TOA", 1), q("TOV", 24, 1.0, "s"), q("TTR", 16, 0.01, "NM")]));
    I380_COM = 9, "COM", "Communications/ACAS capability and flight status", fixed(&[u("COM", 3), u("STAT", 3), spare(2), u("SSC", 1), u("ARC", 1), u("AIC", 1), u("B1A", 1), u("B1B", 4)]);
    I380_SAB = 10, "SAB", "Status reported by ADS-B", fixed(&[u("AC", 2), u("MN", 2), u("DC", 2), u("GBS", 1), spare(6), u("STAT", 3)]);
    I380_ACS = 11, "ACS", "ACAS resolution advisory report", fixed(&[u("", 56)]);
    I380_BVR = 12, "BVR", "Barometric vertical rate", fixed(&[sq("", 16, 6.25, "ft/min")]);
    I380_GVR = 13, "GVR", "Geometric vertical rate", fixed(&[sq("", 16, 6.25, "ft/min")]);
    I380_RAN = 14, "RAN", "Roll angle", fixed(&[sq("", 16, 0.01, "°")]);
    I380_TAR = 15, "TAR", "Track angle rate", fixed(&[u("TI", 2), spare(6), sq("ROT", 7, 1.0 / 4.0, "°/s"), spare(1)]);
    I380_TAN = 16, "TAN", "Track angle", fixed(&[q("", 16, deg(15), "°")]);
    I380_GS = 17, "GS", "Ground speed", fixed(&[sq("", 16, 1.0 / 16384.0, "NM/s")]);
    I380_VUN = 18, "VUN", "Velocity uncertainty", fixed(&[u("", 8)]);
    I380_MET = 19, "MET", "Meteorological data", fixed(&[u("WS", 1), u("WD", 1), u("TMP", 1), u("TRB", 1), spare(4), q("WSD", 16, 1.0, "kt"), q("WDD", 16, 1.0, "°"), sq("TMPD", 16, 1.0 / 4.0, "°C"), u("TRBD", 8)]);
    I380_EMC = 20, "EMC", "Emitter category", fixed(&[u("", 8)]);
    I380_POS = 21, "POS", "Position", fixed(&[sq("LAT", 24, deg(23), "°"), sq("LON", 24, deg(23), "°")]);
    I380_GAL = 22, "GAL", "Geometric altitude", fixed(&[sq("", 16, 6.25, "ft")]);
    I380_PUN = 23, "PUN", "Position uncertainty", fixed(&[spare(4), u("PUN", 4)]);
    I380_BDSDATA = 24, "BDSDATA", "BDS register DATA", Counted(part_of(&[u("MB", 56), u("B1", 4), u("B2", 4)]));
    I380_IAR = 25, "IAR", "Indicated airspeed", fixed(&[q("", 16, 1.0, "kt")]);
    I380_MAC = 26, "MAC", "Mach number", fixed(&[q("", 16, 0.008, "Mach")]);
    I380_BPS = 27, "BPS", "Barometric pressure setting", fixed(&[spare(4), q("BPS", 12, 0.1, "mb")]);
    I380 = 10, "380", "Aircraft derived data", Compound(&[Some(&I380_ADR), Some(&I380_ID), Some(&I380_MHG), Some(&I380_IAS), Some(&I380_TAS), Some(&I380_SAL), Some(&I380_FSS), Some(&I380_TIS), Some(&I380_TID), Some(&I380_COM), Some(&I380_SAB), Some(&I380_ACS), Some(&I380_BVR), Some(&I380_GVR), Some(&I380_RAN), Some(&I380_TAR), Some(&I380_TAN), Some(&I380_GS), Some(&I380_VUN), Some(&I380_MET), Some(&I380_EMC), Some(&I380_POS), Some(&I380_GAL), Some(&I380_PUN), Some(&I380_BDSDATA), Some(&I380_IAR), Some(&I380_MAC), Some(&I380_BPS)]);
    I040 = 11, "040", "Track number", fixed(&[u("", 16)]);
    I080 = 12, "080", "Track status", Extended(&[part(&[u("MON", 1), u("SPI", 1), u("MRH", 1), u("SRC", 3), u("CNF", 1)]), part(&[u("SIM", 1), u("TSE", 1), u("TSB", 1), u("FPC", 1), u("AFF", 1), u("STP", 1), u("KOS", 1)]), part(&[u("AMA", 1), u("MD4", 2), u("ME", 1), u("MI", 1), u("MD5", 2)]), part(&[u("CST", 1), u("PSR", 1), u("SSR", 1), u("MDS", 1), u("ADS", 1), u("SUC", 1), u("AAC", 1)]), part(&[u("SDS", 2), u("EMS", 3), u("PFT", 1), u("FPLT", 1)]), part(&[u("DUPT", 1), u("DUPF", 1), u("DUPM", 1), u("SFC", 1), u("IDD", 1), u("IEC", 1), u("MLAT", 1)])]);
    I290_TRK = 0, "TRK", "Track age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_PSR = 1, "PSR", "PSR age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_SSR = 2, "SSR", "SSR age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_MDS = 3, "MDS", "Mode S age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_ADS = 4, "ADS", "ADS-C age", fixed(&[q("", 16, 1.0 / 4.0, "s")]);
    I290_ES = 5, "ES", "ADS-B extended squitter age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_VDL = 6, "VDL", "ADS-B VDL mode 4 age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_UAT = 7, "UAT", "ADS-B UAT age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_LOP = 8, "LOP", "Loop age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_MLT = 9, "MLT", "Multilateration age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290 = 13, "290", "System track update ages", Compound(&[Some(&I290_TRK), Some(&I290_PSR), Some(&I290_SSR), Some(&I290_MDS), Some(&I290_ADS), Some(&I290_ES), Some(&I290_VDL), Some(&I290_UAT), Some(&I290_LOP), Some(&I290_MLT)]);
    I200 = 14, "200", "Mode of movement", fixed(&[u("TRANS", 2), u("LONG", 2), u("VERT", 2), u("ADF", 1), spare(1)]);
    I295_MFL = 0, "MFL", "Measured flight level age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_MD1 = 1, "MD1", "Mode 1 age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_MD2 = 2, "MD2", "Mode 2 age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_MDA = 3, "MDA", "Mode 3/A age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_MD4 = 4, "MD4", "Mode 4 age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_MD5 = 5, "MD5", "Mode 5 age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_MHG = 6, "MHG", "Magnetic heading age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_IAS = 7, "IAS", "Indicated airspeed / Mach nb age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_TAS = 8, "TAS", "True airspeed age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_SAL = 9, "SAL", "Selected altitude age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_FSS = 10, "FSS", "Final state selected altitude age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_TID = 11, "TID", "Trajectory intent age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_COM = 12, "COM", "Communication/ACAS capability and flight status age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_SAB = 13, "SAB", "Status reported by ADS-B age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_ACS = 14, "ACS", "ACAS resolution advisory report age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_BVR = 15, "BVR", "Barometric vertical rate age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_GVR = 16, "GVR", "Geometrical vertical rate age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_RAN = 17, "RAN", "Roll angle age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_TAR = 18, "TAR", "Track angle rate age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_TAN = 19, "TAN", "Track angle age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_GSP = 20, "GSP", "Ground speed age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_VUN = 21, "VUN", "Velocity uncertainty age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_MET = 22, "MET", "Meteorological data age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_EMC = 23, "EMC", "Emitter category age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_POS = 24, "POS", "Position age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_GAL = 25, "GAL", "Geometric altitude age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_PUN = 26, "PUN", "Position uncertainty age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_MB = 27, "MB", "Mode S MB data age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_IAR = 28, "IAR", "Indicated airspeed data age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_MAC = 29, "MAC", "Mach number data age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295_BPS = 30, "BPS", "Barometric pressure setting data age", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I295 = 15, "295", "Track data ages", Compound(&[Some(&I295_MFL), Some(&I295_MD1), Some(&I295_MD2), Some(&I295_MDA), Some(&I295_MD4), Some(&I295_MD5), Some(&I295_MHG), Some(&I295_IAS), Some(&I295_TAS), Some(&I295_SAL), Some(&I295_FSS), Some(&I295_TID), Some(&I295_COM), Some(&I295_SAB), Some(&I295_ACS), Some(&I295_BVR), Some(&I295_GVR), Some(&I295_RAN), Some(&I295_TAR), Some(&I295_TAN), Some(&I295_GSP), Some(&I295_VUN), Some(&I295_MET), Some(&I295_EMC), Some(&I295_POS), Some(&I295_GAL), Some(&I295_PUN), Some(&I295_MB), Some(&I295_IAR), Some(&I295_MAC), Some(&I295_BPS)]);
    I136 = 16, "136", "Measured flight level", fixed(&[sq("", 16, 1.0 / 4.0, "FL")]);
    I130 = 17, "130", "Calculated track geometric altitude", fixed(&[sq("", 16, 6.25, "ft")]);
    I135 = 18, "135", "Calculated track barometric altitude", fixed(&[u("QNH", 1), sq("ALT", 15, 1.0 / 4.0, "FL")]);
    I220 = 19, "220", "Calculated rate of Climb/Descent", fixed(&[sq("", 16, 6.25, "ft/min")]);
    I390_TAG = 0, "TAG", "FPPS identification tag", fixed(&[u("SAC", 8), u("SIC", 8)]);
    I390_CS = 1, "CS", "Callsign", fixed(&[ascii("", 56)]);
    I390_IFI = 2, "IFI", "IFPS_FLIGHT_ID", fixed(&[u("TYP", 2), spare(3), u("NBR", 27)]);
    I390_FCT = 3, "FCT", "Flight category", fixed(&[u("GATOAT", 2), u("FR", 2), u("RVSM", 2), u("HPR", 1), spare(1)]);
    I390_TAC = 4, "TAC", "Type of aircraft", fixed(&[ascii("", 32)]);
    I390_WTC = 5, "WTC", "Wake turbulence category", fixed(&[ascii("", 8)]);
    I390_DEP = 6, "DEP", "Departure airport", fixed(&[ascii("", 32)]);
    I390_DST = 7, "DST", "Destination airport", fixed(&[ascii("", 32)]);
    I390_RDS = 8, "RDS", "Runway designation", fixed(&[ascii("", 24)]);
    I390_CFL = 9, "CFL", "Current cleared flight level", fixed(&[q("", 16, 1.0 / 4.0, "FL")]);
    I390_CTL = 10, "CTL", "Current control position", fixed(&[u("C", 8), u("P", 8)]);
    I390_TOD = 11, "TOD", "Time of departure / arrival", Counted(part_of(&[u("TYP", 5), u("DAY", 2), spare(4), u("HOR", 5), spare(2), u("MIN", 6), u("AVS", 1), spare(1), u("SEC", 6)]));
    I390_AST = 12, "AST", "Aircraft stand", fixed(&[ascii("", 48)]);
    I390_STS = 13, "STS", "Stand status", fixed(&[u("EMP", 2), u("AVL", 2), spare(4)]);
    I390_STD = 14, "STD", "Standard instrument departure", fixed(&[ascii("", 56)]);
    I390_STA = 15, "STA", "Standard instrument arrival", fixed(&[ascii("", 56)]);
    I390_PEM = 16, "PEM", "Pre-Emergency mode 3/A", fixed(&[spare(3), u("VA", 1), octal("M3A", 12)]);
    I390_PEC = 17, "PEC", "Pre-Emergency callsign", fixed(&[ascii("", 56)]);
    I390 = 20, "390", "Flight plan related data", Compound(&[Some(&I390_TAG), Some(&I390_CS), Some(&I390_IFI), Some(&I390_FCT), Some(&I390_TAC), Some(&I390_WTC), Some(&I390_DEP), Some(&I390_DST), Some(&I390_RDS), Some(&I390_CFL), Some(&I390_CTL), Some(&I390_TOD), Some(&I390_AST), Some(&I390_STS), Some(&I390_STD), Some(&I390_STA), Some(&I390_PEM), Some(&I390_PEC)]);
    I270 = 21, "270", "Target size and orientation", Extended(&[part(&[q("LENGTH", 7, 1.0, "m")]), part(&[q("ORIENTATION", 7, deg(6), "°")]), part(&[q("WIDTH", 7, 1.0, "m")])]);
    I300 = 22, "300", "Vehicle fleet identification", fixed(&[u("", 8)]);
    I110_SUM = 0, "SUM", "Mode 5 summary", fixed(&[u("M5", 1), u("ID", 1), u("DA", 1), u("M1", 1), u("M2", 1), u("M3", 1), u("MC", 1), u("X", 1)]);
    I110_PMN = 1, "PMN", "Mode 5 PIN/ national Origin/Mission code", fixed(&[spare(2), u("PIN", 14), spare(3), u("NAT", 5), spare(2), u("MIS", 6)]);
    I110_POS = 2, "POS", "Mode 5 reported position", fixed(&[sq("LAT", 24, deg(23), "°"), sq("LON", 24, deg(23), "°")]);
    I110_GA = 3, "GA", "Mode 5 GNSS-derived altitude", fixed(&[spare(1), u("RES", 1), sq("GA", 14, 25.0, "ft")]);
    I110_EM1 = 4, "EM1", "Extended mode 1 code in octal representation", fixed(&[spare(4), octal("EM1", 12)]);
    I110_TOS = 5, "TOS", "Time offset for POS and GA", fixed(&[sq("", 8, 1.0 / 128.0, "s")]);
    I110_XP = 6, "XP", "X pulse presence", fixed(&[spare(3), u("X5", 1), u("XC", 1), u("X3", 1), u("X2", 1), u("X1", 1)]);
    I110 = 23, "110", "Mode 5 data reports and extended mode 1 code", Compound(&[Some(&I110_SUM), Some(&I110_PMN), Some(&I110_POS), Some(&I110_GA), Some(&I110_EM1), Some(&I110_TOS), Some(&I110_XP)]);
    I120 = 24, "120", "Track mode 2 code", fixed(&[spare(4), octal("MODE2", 12)]);
    I510 = 25, "510", "Composed track number", Chained(part(&[u("ID", 8), u("N", 15)]));
    I500_APC = 0, "APC", "Estimated accuracy of track position (cartesian)", fixed(&[q("X", 16, 1.0 / 2.0, "m"), q("Y", 16, 1.0 / 2.0, "m")]);
    I500_COV = 1, "COV", "XY covariance component", fixed(&[sq("", 16, 1.0 / 2.0, "m")]);
    I500_APW = 2, "APW", "Estimated accuracy of track position (WGS-84)", fixed(&[q("LAT", 16, deg(25), "°"), q("LON", 16, deg(25), "°")]);
    I500_AGA = 3, "AGA", "Estimated accuracy of calculated track geometric altitude", fixed(&[q("", 8, 6.25, "ft")]);
    I500_ABA = 4, "ABA", "Estimated accuracy of calculated track barometric altitude", fixed(&[q("", 8, 1.0 / 4.0, "FL")]);
    I500_ATV = 5, "ATV", "Estimated accuracy of track velocity (cartesian)", fixed(&[q("X", 8, 1.0 / 4.0, "m/s"), q("Y", 8, 1.0 / 4.0, "m/s")]);
    I500_AA = 6, "AA", "Estimated accuracy of acceleration (cartesian)", fixed(&[q("X", 8, 1.0 / 4.0, "m/s²"), q("Y", 8, 1.0 / 4.0, "m/s²")]);
    I500_ARC = 7, "ARC", "Estimated accuracy of rate of Climb/Descent", fixed(&[q("", 8, 6.25, "ft/min")]);
    I500 = 26, "500", "Estimated accuracies", Compound(&[Some(&I500_APC), Some(&I500_COV), Some(&I500_APW), Some(&I500_AGA), Some(&I500_ABA), Some(&I500_ATV), Some(&I500_AA), Some(&I500_ARC)]);
    I340_SID = 0, "SID", "Sensor identification", fixed(&[u("SAC", 8), u("SIC", 8)]);
    I340_POS = 1, "POS", "Measured position", fixed(&[q("RHO", 16, 1.0 / 256.0, "NM"), q("TH", 16, deg(15), "°")]);
    I340_HGT = 2, "HGT", "Measured 3-D height", fixed(&[sq("", 16, 25.0, "ft")]);
    I340_MDC = 3, "MDC", "MDC", fixed(&[u("V", 1), u("G", 1), sq("FL", 14, 1.0 / 4.0, "FL")]);
    I340_MDA = 4, "MDA", "MDA", fixed(&[u("V", 1), u("G", 1), u("L", 1), spare(1), octal("M3A", 12)]);
    I340_TYP = 5, "TYP", "TYP", fixed(&[u("TYP", 3), u("SIM", 1), u("RAB", 1), u("TST", 1), spare(2)]);
    I340 = 27, "340", "Measured information", Compound(&[Some(&I340_SID), Some(&I340_POS), Some(&I340_HGT), Some(&I340_MDC), Some(&I340_MDA), Some(&I340_TYP)]);
    RE = 33, "RE", "Reserved expansion field", Explicit(&[]);
    SP = 34, "SP", "Special purpose field", Explicit(&[]);
}
