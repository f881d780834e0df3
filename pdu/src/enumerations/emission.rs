//! Emitters, IFF transponders, lasers.

enumeration! {
    /// Emitter system; of the 2 800 names those of air traffic control. SISO-REF-010, UID 75.
    EmitterName: u16 {
        AN_FPN_1 = 5491 "AN/FPN-1",
        AN_FPN_28 = 5493 "AN/FPN-28",
        AN_FPN_33 = 5494 "AN/FPN-33",
        AN_FPN_40 = 5495 "AN/FPN-40",
        AN_FPN_62 = 5500 "AN/FPN-62",
        AN_FPN_66 = 5502 "AN/FPN-66",
        AN_FPN_67 = 5504 "AN/FPN-67",
        ARSR_3 = 8380 "ARSR-3",
        ARSR_1 = 8382 "ARSR-1",
        ARSR_4 = 8384 "ARSR-4",
        ARSR_18 = 8390 "ARSR-18",
        ASDE_KDD = 8756 "ASDE-KDD",
        ASR_2000 = 8771 "ASR-2000",
        ASR_4 = 8772 "ASR-4",
        ASR_4D = 8773 "ASR-4D",
        ASR_O = 8775 "ASR O",
        ASR_12 = 8776 "ASR-12",
        ASR_22AL = 8778 "ASR-22AL",
        ASR_3 = 8779 "ASR-3",
        ASR_5 = 8780 "ASR-5",
        ASR_7 = 8782 "ASR-7",
        ASR_8 = 8785 "ASR-8",
        ASR_9 = 8790 "ASR-9",
        ASR_9000 = 8791 "ASR-9000",
        ASR_11_DASR = 8793 "ASR-11/DASR",
        ASR_23SS = 8816 "ASR-23SS",
        ATCR_22 = 8830 "ATCR-22",
        ATCR_22_M = 8831 "ATCR-22 M",
        ATCR_2T = 8832 "ATCR-2T",
        ATCR_33 = 8840 "ATCR-33",
        ATCR_33_K_M = 8845 "ATCR 33 K/M",
        ATCR_33S = 8846 "ATCR-33S",
        ATCR_3T = 8847 "ATCR-3T",
        ATCR_44 = 8848 "ATCR-44",
        ATCR_44_K = 8849 "ATCR-44 K",
        ATCR_44_M_S = 8851 "ATCR-44 M/S",
        ATCR_4T = 8852 "ATCR-4T",
        GARMIN_GWX_68_WEATHER_RADAR = 16825 "Garmin GWX 68 Weather Radar",
        PAR_2 = 23045 "PAR-2",
        PAR_2000 = 23050 "PAR-2000",
        PAR_2090C = 23053 "PAR-2090C",
        PAR_80 = 23055 "PAR-80",
        SCANTER_1002 = 27095 "SCANTER 1002",
        SCANTER_4002 = 27109 "SCANTER 4002",
        SCANTER_5102 = 27111 "SCANTER 5102",
        SCANTER_5502 = 27113 "SCANTER 5502",
        SCANTER_MIL_S = 27137 "SCANTER MIL S",
        SCANTER_SMR = 27139 "Scanter SMR",
        SCANTER = 27140 "SCANTER (CSR)",
        TDR_94 = 34607 "TDR-94 (MODE S)",
        WATCHMAN_S = 38275 "WATCHMAN-S",
        WATCHMAN_T = 38276 "WATCHMAN-T",
    }
}

enumeration! {
    /// What an emitter system does. SISO-REF-010, UID 76.
    EmitterFunction: u8 {
        OTHER = 0 "Other",
        MULTI_FUNCTION = 1 "Multi-function",
        EARLY_WARNING_SURVEILLANCE = 2 "Early Warning/Surveillance",
        HEIGHT_FINDER = 3 "Height Finder",
        FIRE_CONTROL = 4 "Fire Control",
        ACQUISITION_DETECTION = 5 "Acquisition/Detection",
        TRACKER = 6 "Tracker",
        GUIDANCE_ILLUMINATION = 7 "Guidance/Illumination",
        FIRING_POINT_LAUNCH_POINT_LOCATION = 8 "Firing point/launch point location",
        RANGE_ONLY = 9 "Range-Only",
        RADAR_ALTIMETER = 10 "Radar Altimeter",
        IMAGING = 11 "Imaging",
        MOTION_DETECTION = 12 "Motion Detection",
        NAVIGATION = 13 "Navigation",
        WEATHER_METEOROLOGICAL = 14 "Weather / Meteorological",
        INSTRUMENTATION = 15 "Instrumentation",
        IDENTIFICATION_CLASSIFICATION = 16 "Identification/Classification (including IFF)",
        AAA_FIRE_CONTROL = 17 "AAA (Anti-Aircraft Artillery) Fire Control",
        AIR_SEARCH_BOMB = 18 "Air Search/Bomb",
        AIR_INTERCEPT = 19 "Air Intercept",
        ALTIMETER = 20 "Altimeter",
        AIR_MAPPING = 21 "Air Mapping",
        AIR_TRAFFIC_CONTROL = 22 "Air Traffic Control",
        BEACON = 23 "Beacon",
        BATTLEFIELD_SURVEILLANCE = 24 "Battlefield Surveillance",
        GROUND_CONTROL_APPROACH = 25 "Ground Control Approach",
        GROUND_CONTROL_INTERCEPT = 26 "Ground Control Intercept",
        COASTAL_SURVEILLANCE = 27 "Coastal Surveillance",
        DECOY_MIMIC = 28 "Decoy/Mimic",
        DATA_TRANSMISSION = 29 "Data Transmission",
        EARTH_SURVEILLANCE = 30 "Earth Surveillance",
        GUN_LAY_BEACON = 31 "Gun Lay Beacon",
        GROUND_MAPPING = 32 "Ground Mapping",
        HARBOR_SURVEILLANCE = 33 "Harbor Surveillance",
        IFF = 34 "IFF (Identify Friend or Foe)",
        ILS = 35 "ILS (Instrument Landing System)",
        IONOSPHERIC_SOUND = 36 "Ionospheric Sound",
        INTERROGATOR = 37 "Interrogator",
        DECEPTIVE_JAMMING = 40 "Deceptive Jamming",
        JAMMER = 42 "Jammer",
        NOISE_JAMMING = 43 "Noise Jamming",
        MISSILE_ACQUISITION = 47 "Missile Acquisition",
        MISSILE_DOWNLINK = 48 "Missile Downlink",
        METEOROLOGICAL = 49 "Meteorological",
        SPACE = 50 "Space",
        SURFACE_SEARCH = 51 "Surface Search",
        SHELL_TRACKING = 52 "Shell Tracking",
        TELEVISION = 56 "Television",
        UNKNOWN = 57 "Unknown",
        VIDEO_REMOTING = 58 "Video Remoting",
        EXPERIMENTAL_OR_TRAINING = 59 "Experimental or Training",
        MISSILE_GUIDANCE = 60 "Missile Guidance",
        MISSILE_HOMING = 61 "Missile Homing",
        MISSILE_TRACKING = 62 "Missile Tracking",
        DECOY = 66 "Decoy",
        NAVIGATION_DISTANCE_MEASURING_EQUIPMENT = 71 "Navigation/Distance Measuring Equipment",
        TERRAIN_FOLLOWING = 72 "Terrain Following",
        WEATHER_AVOIDANCE = 73 "Weather Avoidance",
        PROXIMITY_FUSE = 74 "Proximity Fuse",
        INSTRUMENTATION_75 = 75 "Instrumentation",
        RADIOSONDE = 76 "Radiosonde",
        SONOBUOY = 77 "Sonobuoy",
        BATHYTHERMAL_SENSOR = 78 "Bathythermal Sensor",
        TOWED_COUNTER_MEASURE = 79 "Towed Counter Measure",
        DIPPING_SONAR = 80 "Dipping Sonar",
        TOWED_ACOUSTIC_SENSOR = 81 "Towed Acoustic Sensor",
        WEAPON_NON_LETHAL = 96 "Weapon, non-lethal",
        WEAPON_LETHAL = 97 "Weapon, lethal",
        TEST_EQUIPMENT = 98 "Test Equipment",
        ACQUISITION_TRACK = 99 "Acquisition Track",
        TRACK_GUIDANCE = 100 "Track Guidance",
        GUIDANCE_ILLUMINATION_TRACK_ACQUISITION = 101 "Guidance Illumination Track Acquisition",
        SEARCH_ACQUISITION = 102 "Search Acquisition",
        DROPSONDE = 103 "Dropsonde",
    }
}

enumeration! {
    /// Whether an emission PDU is a heartbeat or a change. SISO-REF-010, UID 77.
    StateUpdateIndicator: u8 {
        HEARTBEAT_UPDATE = 0 "Heartbeat Update",
        CHANGED_DATA_UPDATE = 1 "Changed Data Update",
    }
}

enumeration! {
    /// What a beam does. SISO-REF-010, UID 78.
    BeamFunction: u8 {
        OTHER = 0 "Other",
        SEARCH = 1 "Search",
        HEIGHT_FINDING = 2 "Height Finding",
        ACQUISITION = 3 "Acquisition",
        TRACKING = 4 "Tracking",
        ACQUISITION_AND_TRACKING = 5 "Acquisition and tracking",
        COMMAND_GUIDANCE = 6 "Command guidance",
        ILLUMINATION = 7 "Illumination",
        RANGING = 8 "Ranging",
        MISSILE_BEACON = 9 "Missile beacon",
        MISSILE_FUSING = 10 "Missile Fusing",
        ACTIVE_RADAR_MISSILE_SEEKER = 11 "Active radar missile seeker",
        JAMMING = 12 "Jamming",
        IFF = 13 "IFF",
        NAVIGATION_WEATHER = 14 "Navigation / Weather",
        METEOROLOGICAL = 15 "Meteorological",
        DATA_TRANSMISSION = 16 "Data transmission",
        NAVIGATIONAL_DIRECTIONAL_BEACON = 17 "Navigational directional beacon",
        TIME_SHARED_SEARCH = 20 "Time-Shared Search",
        TIME_SHARED_ACQUISITION = 21 "Time-Shared Acquisition",
        TIME_SHARED_TRACK = 22 "Time-Shared Track",
        TIME_SHARED_COMMAND_GUIDANCE = 23 "Time-Shared Command Guidance",
        TIME_SHARED_ILLUMINATION = 24 "Time-Shared Illumination",
        TIME_SHARED_JAMMING = 25 "Time-Shared Jamming",
    }
}

enumeration! {
    /// Whether a beam tracks or jams more targets than it lists. SISO-REF-010, UID 79.
    HighDensityTrackJam: u8 {
        NOT_SELECTED = 0 "Not Selected",
        SELECTED = 1 "Selected",
    }
}

enumeration! {
    /// Kind of an IFF, ATC or NAVAIDS system. SISO-REF-010, UID 82.
    IffSystemType: u16 {
        MARK_X_XII_ATCRBS_TRANSPONDER = 1 "Mark X/XII/ATCRBS Transponder",
        MARK_X_XII_ATCRBS_INTERROGATOR = 2 "Mark X/XII/ATCRBS Interrogator",
        SOVIET_TRANSPONDER = 3 "Soviet Transponder",
        SOVIET_INTERROGATOR = 4 "Soviet Interrogator",
        RRB_TRANSPONDER = 5 "RRB Transponder",
        MARK_XIIA_INTERROGATOR = 6 "Mark XIIA Interrogator",
        MODE_5_INTERROGATOR = 7 "Mode 5 Interrogator",
        MODE_S_INTERROGATOR = 8 "Mode S Interrogator",
        MARK_XIIA_TRANSPONDER = 9 "Mark XIIA Transponder",
        MODE_5_TRANSPONDER = 10 "Mode 5 Transponder",
        MODE_S_TRANSPONDER = 11 "Mode S Transponder",
        MARK_XIIA_COMBINED_INTERROGATOR_TRANSPONDER = 12 "Mark XIIA Combined Interrogator/Transponder (CIT)",
        MARK_XII_COMBINED_INTERROGATOR_TRANSPONDER = 13 "Mark XII Combined Interrogator/Transponder (CIT)",
        TCAS_ACAS_TRANSCEIVER = 14 "TCAS/ACAS Transceiver",
    }
}

enumeration! {
    /// Name of an IFF, ATC or NAVAIDS system. SISO-REF-010, UID 83.
    IffSystemName: u16 {
        GENERIC_MARK_X = 1 "Generic Mark X",
        GENERIC_MARK_XII = 2 "Generic Mark XII",
        GENERIC_ATCRBS = 3 "Generic ATCRBS",
        GENERIC_SOVIET = 4 "Generic Soviet",
        GENERIC_MODE_S = 5 "Generic Mode S",
        GENERIC_MARK_X_XII_ATCRBS = 6 "Generic Mark X/XII/ATCRBS",
        GENERIC_MARK_X_XII_ATCRBS_MODE_S = 7 "Generic Mark X/XII/ATCRBS/Mode S",
        ARI_5954 = 8 "ARI 5954 (RRB)",
        ARI_5983 = 9 "ARI 5983 (RRB)",
        GENERIC_RRB = 10 "Generic RRB",
        GENERIC_MARK_XIIA = 11 "Generic Mark XIIA",
        GENERIC_MODE_5 = 12 "Generic Mode 5",
        GENERIC_MARK_XIIA_COMBINED_INTERROGATOR_TRANSPONDER = 13 "Generic Mark XIIA Combined Interrogator/Transponder (CIT)",
        GENERIC_MARK_XII_COMBINED_INTERROGATOR_TRANSPONDER = 14 "Generic Mark XII Combined Interrogator/Transponder (CIT)",
        GENERIC_TCAS_I_ACAS_I_TRANSCEIVER = 15 "Generic TCAS I/ACAS I Transceiver",
        GENERIC_TCAS_II_ACAS_II_TRANSCEIVER = 16 "Generic TCAS II/ACAS II Transceiver",
        GENERIC_MARK_X_17 = 17 "Generic Mark X (A)",
        GENERIC_MARK_X_18 = 18 "Generic Mark X (SIF)",
    }
}

enumeration! {
    /// Operating mode of an IFF system. SISO-REF-010, UID 84.
    IffSystemMode: u8 {
        NO_STATEMENT = 0 "No Statement",
        OFF = 1 "Off",
        STANDBY = 2 "Standby",
        NORMAL = 3 "Normal",
        EMERGENCY = 4 "Emergency",
        LOW_OR_LOW_SENSITIVITY = 5 "Low or Low Sensitivity",
    }
}
