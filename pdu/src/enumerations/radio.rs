//! Radios.

enumeration! {
    /// Whether a transmitter is on the air. SISO-REF-010, UID 164.
    TransmitState: u8 {
        OFF = 0 "Off",
        ON_BUT_NOT_TRANSMITTING = 1 "On but not transmitting",
        ON_AND_TRANSMITTING = 2 "On and transmitting",
    }
}

enumeration! {
    /// Where the audio of a transmitter comes from. SISO-REF-010, UID 165.
    InputSource: u8 {
        OTHER = 0 "Other",
        PILOT = 1 "Pilot",
        COPILOT = 2 "Copilot",
        FIRST_OFFICER = 3 "First Officer",
        DRIVER = 4 "Driver",
        LOADER = 5 "Loader",
        GUNNER = 6 "Gunner",
        COMMANDER = 7 "Commander",
        DIGITAL_DATA_DEVICE = 8 "Digital Data Device",
        INTERCOM = 9 "Intercom",
        AUDIO_JAMMER = 10 "Audio Jammer",
        DATA_JAMMER = 11 "Data Jammer",
        GPS_JAMMER = 12 "GPS Jammer",
        GPS_MEACONER = 13 "GPS Meaconer",
        SATCOM_UPLINK_JAMMER = 14 "SATCOM Uplink Jammer",
        CREW_OBSERVER_1 = 15 "Crew Observer 1",
        CREW_OBSERVER_2 = 16 "Crew Observer 2",
        AERIAL_REFUELING_OFFICER = 17 "Aerial Refueling Officer (ARO)",
        AERIAL_REFUELING_OFFICER_INSTRUCTOR = 18 "Aerial Refueling Officer Instructor (AROI)",
    }
}

enumeration! {
    /// Encryption of a transmitter. SISO-REF-010, UID 166.
    CryptoSystem: u16 {
        NO_ENCRYPTION_DEVICE = 0 "No Encryption Device",
        KY_28 = 1 "KY-28",
        KY_58 = 2 "KY-58",
        NARROW_SPECTRUM_SECURE_VOICE = 3 "Narrow Spectrum Secure Voice (NSVE)",
        WIDE_SPECTRUM_SECURE_VOICE = 4 "Wide Spectrum Secure Voice (WSVE)",
        SINCGARS_ICOM = 5 "SINCGARS ICOM",
        KY_75 = 6 "KY-75",
        KY_100 = 7 "KY-100",
        KY_57 = 8 "KY-57",
        KYV_5 = 9 "KYV-5",
        LINK_11_KG_40A_P = 10 "Link 11 KG-40A-P (NTDS)",
        LINK_11B_KG_40A_S = 11 "Link 11B KG-40A-S",
        LINK_11_KG_40AR = 12 "Link 11 KG-40AR",
        KGV_135A = 13 "KGV-135A",
        TACTICAL_SECURE_VOICE = 14 "Tactical Secure Voice (TSV)",
    }
}

enumeration! {
    /// Kind of an antenna pattern. SISO-REF-010, UID 167.
    AntennaPatternType: u16 {
        ISOTROPIC = 0 "Isotropic (Spherical Radiation Pattern)",
        BEAM = 1 "Beam",
        TRANSMITTER_RADIATION_VOLUME = 4 "Transmitter Radiation Volume",
        BEAM_AND_TRANSMITTER_RADIATION_VOLUME = 5 "Beam and Transmitter Radiation Volume",
        OMNIDIRECTIONAL = 6 "Omnidirectional (Toroidal Radiation Pattern)",
    }
}

enumeration! {
    /// Major modulation of a transmitter. SISO-REF-010, UID 155.
    MajorModulation: u16 {
        NO_STATEMENT = 0 "No Statement",
        AMPLITUDE = 1 "Amplitude",
        AMPLITUDE_AND_ANGLE = 2 "Amplitude and Angle",
        ANGLE = 3 "Angle",
        COMBINATION = 4 "Combination",
        PULSE = 5 "Pulse",
        UNMODULATED = 6 "Unmodulated",
        CARRIER_PHASE_SHIFT_MODULATION = 7 "Carrier Phase Shift Modulation (CPSM)",
        SATCOM = 8 "SATCOM",
    }
}

enumeration! {
    /// Modulation system of a transmitter. SISO-REF-010, UID 163.
    ModulationSystem: u16 {
        OTHER = 0 "Other",
        GENERIC_RADIO_OR_SIMPLE_INTERCOM = 1 "Generic Radio or Simple Intercom",
        HAVE_QUICK_I = 2 "HAVE QUICK I",
        HAVE_QUICK_II = 3 "HAVE QUICK II",
        SATURN = 4 "SATURN",
        SINCGARS = 5 "SINCGARS",
        CCTT_SINCGARS = 6 "CCTT SINCGARS",
        EPLRS = 7 "EPLRS (Enhanced Position Location Reporting System)",
        JTIDS_MIDS = 8 "JTIDS/MIDS",
        LINK_11 = 9 "Link 11",
        LINK_11B = 10 "Link 11B",
        L_BAND_SATCOM = 11 "L-Band SATCOM",
        ENHANCED_SINCGARS_7_3 = 12 "Enhanced SINCGARS 7.3",
        NAVIGATION_AID = 13 "Navigation Aid",
        MUOS = 14 "MUOS",
    }
}

enumeration! {
    /// Tactical data link of a signal. SISO-REF-010, UID 178.
    TdlType: u16 {
        OTHER = 0 "Other",
        PADIL = 1 "PADIL",
        NATO_LINK_1 = 2 "NATO Link-1",
        ATDL_1 = 3 "ATDL-1",
        LINK_11B = 4 "Link 11B (TADIL B)",
        SITUATIONAL_AWARENESS_DATA_LINK = 5 "Situational Awareness Data Link (SADL)",
        LINK_16_LEGACY_FORMAT = 6 "Link 16 Legacy Format (JTIDS/TADIL-J)",
        LINK_16_LEGACY_FORMAT_7 = 7 "Link 16 Legacy Format (JTIDS/FDL/TADIL-J)",
        LINK_11 = 8 "Link 11 (TADIL A)",
    }
}

enumeration! {
    /// Whether a receiver receives. SISO-REF-010, UID 179.
    ReceiverState: u16 {
        OFF = 0 "Off",
        ON_BUT_NOT_RECEIVING = 1 "On but not receiving",
        ON_AND_RECEIVING = 2 "On and receiving",
    }
}
