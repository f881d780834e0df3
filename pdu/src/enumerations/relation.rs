//! Aggregates, parts, attributes.

enumeration! {
    /// State of an aggregate. SISO-REF-010, UID 204.
    AggregateState: u8 {
        OTHER = 0 "Other",
        AGGREGATED = 1 "Aggregated",
        DISAGGREGATED = 2 "Disaggregated",
        FULLY_DISAGGREGATED = 3 "Fully disaggregated",
        PSEUDO_DISAGGREGATED = 4 "Pseudo-disaggregated",
        PARTIALLY_DISAGGREGATED = 5 "Partially-disaggregated",
    }
}

enumeration! {
    /// Formation of an aggregate. SISO-REF-010, UID 205.
    AggregateFormation: u32 {
        OTHER = 0 "Other",
        ASSEMBLY = 1 "Assembly",
        VEE = 2 "Vee",
        WEDGE = 3 "Wedge",
        LINE = 4 "Line",
        COLUMN = 5 "Column",
    }
}

enumeration! {
    /// Kind of an aggregate. SISO-REF-010, UID 206.
    AggregateKind: u8 {
        OTHER = 0 "Other",
        MILITARY_HIERARCHY = 1 "Military Hierarchy",
        COMMON_TYPE = 2 "Common Type",
        COMMON_MISSION = 3 "Common Mission",
        SIMILAR_CAPABILITIES = 4 "Similar Capabilities",
        COMMON_LOCATION = 5 "Common Location",
    }
}

enumeration! {
    /// Nature of the relationship of a part. SISO-REF-010, UID 210.
    PartNature: u16 {
        OTHER = 0 "Other",
        HOST_FIREABLE_MUNITION = 1 "Host-fireable munition",
        MUNITION_CARRIED_AS_CARGO = 2 "Munition carried as cargo",
        FUEL_CARRIED_AS_CARGO = 3 "Fuel carried as cargo",
        GUNMOUNT_ATTACHED_TO_HOST = 4 "Gunmount attached to host",
        COMPUTER_GENERATED_FORCES_CARRIED_AS_CARGO = 5 "Computer generated forces carried as cargo",
        VEHICLE_CARRIED_AS_CARGO = 6 "Vehicle carried as cargo",
        EMITTER_MOUNTED_ON_HOST = 7 "Emitter mounted on host",
        MOBILE_COMMAND_AND_CONTROL_ENTITY_CARRIED_ABOARD_HOST = 8 "Mobile command and control entity carried aboard host",
        ENTITY_STATIONED_AT_POSITION_WITH_RESPECT_TO_HOST = 9 "Entity stationed at position with respect to host",
        TEAM_MEMBER_IN_FORMATION_WITH = 10 "Team member in formation with",
    }
}

enumeration! {
    /// Where a part is. SISO-REF-010, UID 211.
    PartPosition: u16 {
        OTHER = 0 "Other",
        ON_TOP_OF = 1 "On top of",
        INSIDE_OF = 2 "Inside of",
    }
}

enumeration! {
    /// Named station of a part. SISO-REF-010, UID 212.
    StationName: u16 {
        OTHER = 0 "Other",
        AIRCRAFT_WINGSTATION = 1 "Aircraft Wingstation",
        SHIP_S_FORWARD_GUNMOUNT = 2 "Ship's Forward Gunmount (Starboard)",
        SHIP_S_FORWARD_GUNMOUNT_3 = 3 "Ship's Forward Gunmount (Port)",
        SHIP_S_FORWARD_GUNMOUNT_4 = 4 "Ship's Forward Gunmount (Centerline)",
        SHIP_S_AFT_GUNMOUNT = 5 "Ship's Aft Gunmount (Starboard)",
        SHIP_S_AFT_GUNMOUNT_6 = 6 "Ship's Aft Gunmount (Port)",
        SHIP_S_AFT_GUNMOUNT_7 = 7 "Ship's Aft Gunmount (Centerline)",
        FORWARD_TORPEDO_TUBE = 8 "Forward Torpedo Tube",
        AFT_TORPEDO_TUBE = 9 "Aft Torpedo Tube",
        BOMB_BAY = 10 "Bomb Bay",
        CARGO_BAY = 11 "Cargo Bay",
        TRUCK_BED = 12 "Truck Bed",
        TRAILER_BED = 13 "Trailer Bed",
        WELL_DECK = 14 "Well Deck",
        ON_STATION_RANGE_AND_BEARING = 15 "On Station Range and Bearing",
        ON_STATION_XYZ = 16 "On Station xyz",
        AIR_TO_AIR_REFUELING_BOOM = 17 "Air-to-Air Refueling Boom",
        AERIAL_REFUELING_RECEPTACLE = 18 "Aerial Refueling Receptacle",
        PORT_SIDE_REFUELING_DROGUE = 19 "Port Side Refueling Drogue",
        STARBOARD_SIDE_REFUELING_DROGUE = 20 "Starboard Side Refueling Drogue",
        CENTER_REFUELING_DROGUE = 21 "Center Refueling Drogue",
        AIR_REFUELING_PROBE = 22 "Air Refueling Probe",
    }
}

enumeration! {
    /// What an attribute PDU asks for. SISO-REF-010, UID 295.
    AttributeActionCode: u8 {
        NO_STATEMENT = 0 "No Statement",
    }
}
