//! Category 011, A-SMGCS data, edition 1.3.

use crate::table::*;

/// The category.
pub static CATEGORY: Category = Category {
    number: 11,
    edition: (1, 3),
    title: "A-SMGCS data",
    uap: &[
        Some(&I010),
        Some(&I000),
        Some(&I015),
        Some(&I140),
        Some(&I041),
        Some(&I042),
        Some(&I202),
        Some(&I210),
        Some(&I060),
        Some(&I245),
        Some(&I380),
        Some(&I161),
        Some(&I170),
        Some(&I290),
        Some(&I430),
        Some(&I090),
        Some(&I093),
        Some(&I092),
        Some(&I215),
        Some(&I270),
        Some(&I390),
        Some(&I300),
        Some(&I310),
        Some(&I500),
        Some(&I600),
        Some(&I605),
        Some(&I610),
        Some(&SP),
        Some(&RE),
    ],
};

items! {
    I010 = 0, "010", "Data source identifier", fixed(&[u("SAC", 8), u("SIC", 8)]);
    I000 = 1, "000", "Message type", fixed(&[u("", 8)]);
    I015 = 2, "015", "Service identification", fixed(&[u("", 8)]);
    I140 = 3, "140", "Time of track information", fixed(&[tod("")]);
    I041 = 4, "041", "Position in WGS-84 coordinates", fixed(&[sq("LAT", 32, deg(31), "°"), sq("LON", 32, deg(31), "°")]);
    I042 = 5, "042", "Calculated position in cartesian coordinates", fixed(&[sq("X", 16, 1.0, "m"), sq("Y", 16, 1.0, "m")]);
    I202 = 6, "202", "Calculated track velocity in cartesian coordinates", fixed(&[sq("VX", 16, 1.0 / 4.0, "m/s"), sq("VY", 16, 1.0 / 4.0, "m/s")]);
    I210 = 7, "210", "Calculated acceleration", fixed(&[sq("AX", 8, 1.0 / 4.0, "m/s²"), sq("AY", 8, 1.0 / 4.0, "m/s²")]);
    I060 = 8, "060", "Mode-3/A code in octal representation", fixed(&[spare(4), octal("M3A", 12)]);
    I245 = 9, "245", "Target identification", fixed(&[u("STI", 2), spare(6), ident("ID", 48)]);
    I380_MB = 0, "MB", "BDS", Counted(part_of(&[u("MB", 56), u("B1", 4), u("B2", 4)]));
    I380_ADR = 1, "ADR", "24 bits aircraft address", fixed(&[u("", 24)]);
    I380_COMACAS = 3, "COMACAS", "Communications/ACAS capability and flight status", fixed(&[u("COM", 3), u("STAT", 4), spare(1), u("SSC", 1), u("ARC", 1), u("AIC", 1), u("B1A", 1), u("B1B", 4), u("AC", 1), u("MN", 1), u("DC", 1), spare(5)]);
    I380_ACT = 7, "ACT", "Aircraft derived aircraft type", fixed(&[ascii("", 32)]);
    I380_ECAT = 8, "ECAT", "Emitter category", fixed(&[u("", 8)]);
    I380_AVTECH = 10, "AVTECH", "Available technologies", fixed(&[u("VDL", 1), u("MDS", 1), u("UAT", 1), spare(5)]);
    I380 = 10, "380", "Mode-S / ADS-B related data", Compound(&[Some(&I380_MB), Some(&I380_ADR), None, Some(&I380_COMACAS), None, None, None, Some(&I380_ACT), Some(&I380_ECAT), None, Some(&I380_AVTECH)]);
    I161 = 11, "161", "Track number", fixed(&[spare(1), u("FTN", 15)]);
    I170 = 12, "170", "Track status", Extended(&[part(&[u("MON", 1), u("GBS", 1), u("MRH", 1), u("SRC", 3), u("CNF", 1)]), part(&[u("SIM", 1), u("TSE", 1), u("TSB", 1), u("FRIFOE", 2), u("ME", 1), u("MI", 1)]), part(&[u("AMA", 1), u("SPI", 1), u("CST", 1), u("FPC", 1), u("AFF", 1), spare(2)]), part(&[spare(1), u("PSR", 1), u("SSR", 1), u("MDS", 1), u("ADS", 1), u("SUC", 1), u("AAC", 1)])]);
    I290_PSR = 0, "PSR", "Age of the last primary report used to update the track", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_SSR = 1, "SSR", "Age of the last secondary report used to update the track", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_MDA = 2, "MDA", "Age of the last valid mode A report used to update the track", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_MFL = 3, "MFL", "Age of the last valid and credible mode C used to update the track", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_MDS = 4, "MDS", "Age of the last mode S report used to update the track", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_ADS = 5, "ADS", "Age of the last ADS report used to update the track", fixed(&[q("", 16, 1.0 / 4.0, "s")]);
    I290_ADB = 6, "ADB", "Age of the last ADS-B report used to update the track", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_MD1 = 7, "MD1", "Age of the last valid mode 1 used to update the track", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_MD2 = 8, "MD2", "Age of the last valid mode 2 used to update the track", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_LOP = 9, "LOP", "Age of the last magentic loop detection", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_TRK = 10, "TRK", "Actual track age since first occurrence", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290_MUL = 11, "MUL", "Age of the last multilateration detection", fixed(&[q("", 8, 1.0 / 4.0, "s")]);
    I290 = 13, "290", "System track update ages", Compound(&[Some(&I290_PSR), Some(&I290_SSR), Some(&I290_MDA), Some(&I290_MFL), Some(&I290_MDS), Some(&I290_ADS), Some(&I290_ADB), Some(&I290_MD1), Some(&I290_MD2), Some(&I290_LOP), Some(&I290_TRK), Some(&I290_MUL)]);
    I430 = 14, "430", "Phase of flight", fixed(&[u("", 8)]);
    I090 = 15, "090", "Measured flight level", fixed(&[sq("", 16, 1.0 / 4.0, "FL")]);
    I093 = 16, "093", "Calculated track barometric altitude", fixed(&[u("QNH", 1), sq("ALT", 15, 1.0 / 4.0, "FL")]);
    I092 = 17, "092", "Calculated track geometric altitude", fixed(&[sq("", 16, 6.25, "ft")]);
    I215 = 18, "215", "Calculated rate of Climb/Descent", fixed(&[sq("", 16, 6.25, "ft/min")]);
    I270 = 19, "270", "Target size and orientation", Extended(&[part(&[q("LENGTH", 7, 1.0, "m")]), part(&[q("ORIENTATION", 7, deg(6), "°")]), part(&[q("WIDTH", 7, 1.0, "m")])]);
    I390_FPPSID = 0, "FPPSID", "FPPS identification tag", fixed(&[u("SAC", 8), u("SIC", 8)]);
    I390_CSN = 1, "CSN", "Callsign", fixed(&[ascii("", 56)]);
    I390_IFPS = 2, "IFPS", "IFPS_FLIGHT_ID", fixed(&[u("TYP", 2), spare(3), u("NBR", 27)]);
    I390_FLIGHTCAT = 3, "FLIGHTCAT", "Flight category", fixed(&[u("GATOAT", 2), u("FR", 2), u("RVSM", 2), u("HPR", 1), spare(1)]);
    I390_TOA = 4, "TOA", "Type of aircraft", fixed(&[ascii("", 32)]);
    I390_WTC = 5, "WTC", "Wake turbulence category", fixed(&[ascii("", 8)]);
    I390_ADEP = 6, "ADEP", "Departure airport", fixed(&[ascii("", 32)]);
    I390_ADES = 7, "ADES", "Destination airport", fixed(&[ascii("", 32)]);
    I390_RWY = 8, "RWY", "Runway designation", fixed(&[ascii("", 24)]);
    I390_CFL = 9, "CFL", "Current cleared flight level", fixed(&[q("", 16, 1.0 / 4.0, "FL")]);
    I390_CCP = 10, "CCP", "Current control position", fixed(&[u("C", 8), u("P", 8)]);
    I390_TOD = 11, "TOD", "Time of departure", Counted(part_of(&[u("TYP", 5), u("DAY", 2), spare(4), u("HOR", 5), spare(2), u("MIN", 6), u("AVS", 1), spare(1), u("SEC", 6)]));
    I390_AST = 12, "AST", "Aircraft stand", fixed(&[ascii("", 48)]);
    I390_STS = 13, "STS", "Stand status", fixed(&[u("EMP", 2), u("AVL", 2), spare(4)]);
    I390 = 20, "390", "Flight plan related data", Compound(&[Some(&I390_FPPSID), Some(&I390_CSN), Some(&I390_IFPS), Some(&I390_FLIGHTCAT), Some(&I390_TOA), Some(&I390_WTC), Some(&I390_ADEP), Some(&I390_ADES), Some(&I390_RWY), Some(&I390_CFL), Some(&I390_CCP), Some(&I390_TOD), Some(&I390_AST), Some(&I390_STS)]);
    I300 = 21, "300", "Vehicle fleet identification", fixed(&[u("", 8)]);
    I310 = 22, "310", "Pre-programmed message", fixed(&[u("TRB", 1), u("MSG", 7)]);
    I500_APC = 0, "APC", "Estimated accuracy of track position (cartesian)", fixed(&[q("X", 8, 1.0 / 4.0, "m"), q("Y", 8, 1.0 / 4.0, "m")]);
    I500_APW = 1, "APW", "Estimated accuracy of track position (WGS84)", fixed(&[sq("LAT", 16, deg(31), "°"), sq("LON", 16, deg(31), "°")]);
    I500_ATH = 2, "ATH", "Estimated accuracy of track height", fixed(&[sq("", 16, 1.0 / 2.0, "m")]);
    I500_AVC = 3, "AVC", "Estimated accuracy of track velocity (cartesian)", fixed(&[q("X", 8, 0.1, "m/s"), q("Y", 8, 0.1, "m/s")]);
    I500_ARC = 4, "ARC", "Estimated accuracy of rate of climb / descent", fixed(&[sq("", 16, 0.1, "m/s")]);
    I500_AAC = 5, "AAC", "Estimated accuracy of acceleration (cartesian)", fixed(&[q("X", 8, 0.01, "m/s²"), q("Y", 8, 0.01, "m/s²")]);
    I500 = 23, "500", "Estimated accuracies", Compound(&[Some(&I500_APC), Some(&I500_APW), Some(&I500_ATH), Some(&I500_AVC), Some(&I500_ARC), Some(&I500_AAC)]);
    I600 = 24, "600", "Alert messages", fixed(&[u("ACK", 1), u("SVR", 2), spare(5), u("AT", 8), u("AN", 8)]);
    I605 = 25, "605", "Tracks in alert", Counted(part_of(&[spare(4), u("FTN", 12)]));
    I610 = 26, "610", "Holdbar status", Counted(part_of(&[u("BKN", 4), u("I", 12)]));
    SP = 27, "SP", "Special purpose field", Explicit(&[]);
    RE = 28, "RE", "Reserved expansion field", Explicit(&[]);
}
