//! Numbers with names, after SISO-REF-010 (version 35 of 2025-04-27; reprinted with permission from
//! SISO Inc.).
//!
//! Each is a number that may have a name. Unknown numbers are kept and shown as they are; nothing is
//! refused because it has no name here.
//!
//! ```
//! use pdu::enumerations::{AcknowledgeFlag, PduType};
//! assert_eq!(PduType::ENTITY_STATE.to_string(), "Entity State (1)");
//! assert_eq!(AcknowledgeFlag(777).to_string(), "777");
//! ```

mod appearance;
mod datum;
mod emission;
mod environment;
mod management;
mod platform;
mod radio;
mod relation;

pub use appearance::{AirAppearance, Damage, LandAppearance};
pub use datum::DatumId;
pub use emission::*;
pub use environment::*;
pub use management::*;
pub use platform::*;
pub use radio::*;
pub use relation::*;

enumeration! {
    /// Type of a PDU. SISO-REF-010, UID 4.
    PduType: u8 {
        OTHER = 0 "Other",
        ENTITY_STATE = 1 "Entity State",
        FIRE = 2 "Fire",
        DETONATION = 3 "Detonation",
        COLLISION = 4 "Collision",
        SERVICE_REQUEST = 5 "Service Request",
        RESUPPLY_OFFER = 6 "Resupply Offer",
        RESUPPLY_RECEIVED = 7 "Resupply Received",
        RESUPPLY_CANCEL = 8 "Resupply Cancel",
        REPAIR_COMPLETE = 9 "Repair Complete",
        REPAIR_RESPONSE = 10 "Repair Response",
        CREATE_ENTITY = 11 "Create Entity",
        REMOVE_ENTITY = 12 "Remove Entity",
        START_RESUME = 13 "Start/Resume",
        STOP_FREEZE = 14 "Stop/Freeze",
        ACKNOWLEDGE = 15 "Acknowledge",
        ACTION_REQUEST = 16 "Action Request",
        ACTION_RESPONSE = 17 "Action Response",
        DATA_QUERY = 18 "Data Query",
        SET_DATA = 19 "Set Data",
        DATA = 20 "Data",
        EVENT_REPORT = 21 "Event Report",
        COMMENT = 22 "Comment",
        ELECTROMAGNETIC_EMISSION = 23 "Electromagnetic Emission",
        DESIGNATOR = 24 "Designator",
        TRANSMITTER = 25 "Transmitter",
        SIGNAL = 26 "Signal",
        RECEIVER = 27 "Receiver",
        IFF = 28 "IFF",
        UNDERWATER_ACOUSTIC = 29 "Underwater Acoustic",
        SUPPLEMENTAL_EMISSION_ENTITY_STATE = 30 "Supplemental Emission / Entity State",
        INTERCOM_SIGNAL = 31 "Intercom Signal",
        INTERCOM_CONTROL = 32 "Intercom Control",
        AGGREGATE_STATE = 33 "Aggregate State",
        IS_GROUP_OF = 34 "IsGroupOf",
        TRANSFER_OWNERSHIP = 35 "Transfer Ownership",
        IS_PART_OF = 36 "IsPartOf",
        MINEFIELD_STATE = 37 "Minefield State",
        MINEFIELD_QUERY = 38 "Minefield Query",
        MINEFIELD_DATA = 39 "Minefield Data",
        MINEFIELD_RESPONSE_NACK = 40 "Minefield Response NACK",
        ENVIRONMENTAL_PROCESS = 41 "Environmental Process",
        GRIDDED_DATA = 42 "Gridded Data",
        POINT_OBJECT_STATE = 43 "Point Object State",
        LINEAR_OBJECT_STATE = 44 "Linear Object State",
        AREAL_OBJECT_STATE = 45 "Areal Object State",
        TSPI = 46 "TSPI",
        APPEARANCE = 47 "Appearance",
        ARTICULATED_PARTS = 48 "Articulated Parts",
        LE_FIRE = 49 "LE Fire",
        LE_DETONATION = 50 "LE Detonation",
        CREATE_ENTITY_R = 51 "Create Entity-R",
        REMOVE_ENTITY_R = 52 "Remove Entity-R",
        START_RESUME_R = 53 "Start/Resume-R",
        STOP_FREEZE_R = 54 "Stop/Freeze-R",
        ACKNOWLEDGE_R = 55 "Acknowledge-R",
        ACTION_REQUEST_R = 56 "Action Request-R",
        ACTION_RESPONSE_R = 57 "Action Response-R",
        DATA_QUERY_R = 58 "Data Query-R",
        SET_DATA_R = 59 "Set Data-R",
        DATA_R = 60 "Data-R",
        EVENT_REPORT_R = 61 "Event Report-R",
        COMMENT_R = 62 "Comment-R",
        RECORD_R = 63 "Record-R",
        SET_RECORD_R = 64 "Set Record-R",
        RECORD_QUERY_R = 65 "Record Query-R",
        COLLISION_ELASTIC = 66 "Collision-Elastic",
        ENTITY_STATE_UPDATE = 67 "Entity State Update",
        DIRECTED_ENERGY_FIRE = 68 "Directed Energy Fire",
        ENTITY_DAMAGE_STATUS = 69 "Entity Damage Status",
        INFORMATION_OPERATIONS_ACTION = 70 "Information Operations Action",
        INFORMATION_OPERATIONS_REPORT = 71 "Information Operations Report",
        ATTRIBUTE = 72 "Attribute",
    }
}

enumeration! {
    /// Version of the protocol. SISO-REF-010, UID 3.
    ProtocolVersion: u8 {
        OTHER = 0 "Other",
        DIS1 = 1 "DIS PDU version 1.0 (May 92)",
        IEEE_1278_1993 = 2 "IEEE 1278-1993",
        DIS3 = 3 "DIS Applications Version 2.0 - Third Draft (28 May 1993)",
        DIS4 = 4 "DIS Application Protocols Version 2.0 - Fourth Draft (Revised) (16 March 1994)",
        DIS5 = 5 "IEEE 1278.1-1995",
        DIS6 = 6 "IEEE 1278.1A-1998",
        DIS7 = 7 "IEEE 1278.1-2012",
    }
}

enumeration! {
    /// Family of a PDU. SISO-REF-010, UID 5.
    ProtocolFamily: u8 {
        OTHER = 0 "Other",
        ENTITY_INFORMATION_INTERACTION = 1 "Entity Information/Interaction",
        WARFARE = 2 "Warfare",
        LOGISTICS = 3 "Logistics",
        RADIO_COMMUNICATIONS = 4 "Radio Communications",
        SIMULATION_MANAGEMENT = 5 "Simulation Management",
        DISTRIBUTED_EMISSION_REGENERATION = 6 "Distributed Emission Regeneration",
        ENTITY_MANAGEMENT = 7 "Entity Management",
        MINEFIELD = 8 "Minefield",
        SYNTHETIC_ENVIRONMENT = 9 "Synthetic Environment",
        SIMULATION_MANAGEMENT_WITH_RELIABILITY = 10 "Simulation Management with Reliability",
        LIVE_ENTITY_INFORMATION_INTERACTION = 11 "Live Entity (LE) Information/Interaction",
        NON_REAL_TIME = 12 "Non-Real-Time",
        INFORMATION_OPERATIONS = 13 "Information Operations",
    }
}
