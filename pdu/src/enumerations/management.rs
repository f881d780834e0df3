//! Simulation management: reasons, flags, actions, events.

enumeration! {
    /// Why a simulation stops or freezes. SISO-REF-010, UID 67.
    StopReason: u8 {
        OTHER = 0 "Other",
        RECESS = 1 "Recess",
        TERMINATION = 2 "Termination",
        SYSTEM_FAILURE = 3 "System Failure",
        SECURITY_VIOLATION = 4 "Security Violation",
        ENTITY_RECONSTITUTION = 5 "Entity Reconstitution",
        STOP_FOR_RESET = 6 "Stop for reset",
        STOP_FOR_RESTART = 7 "Stop for restart",
        ABORT_TRAINING_RETURN_TO_TACTICAL_OPERATIONS = 8 "Abort Training Return to Tactical Operations",
    }
}

enumeration! {
    /// What is acknowledged. SISO-REF-010, UID 69.
    AcknowledgeFlag: u16 {
        CREATE_ENTITY = 1 "Create Entity",
        REMOVE_ENTITY = 2 "Remove Entity",
        START_RESUME = 3 "Start/Resume",
        STOP_FREEZE = 4 "Stop/Freeze",
        TRANSFER_OWNERSHIP = 5 "Transfer Ownership",
    }
}

enumeration! {
    /// Whether the receiver complies. SISO-REF-010, UID 70.
    ResponseFlag: u16 {
        OTHER = 0 "Other",
        ABLE_TO_COMPLY = 1 "Able to comply",
        UNABLE_TO_COMPLY = 2 "Unable to comply",
        PENDING_OPERATOR_ACTION = 3 "Pending Operator Action",
    }
}

enumeration! {
    /// Requested action. SISO-REF-010, UID 71.
    ActionId: u32 {
        OTHER = 0 "Other",
        LOCAL_STORAGE_OF_THE_REQUESTED_INFORMATION = 1 "Local storage of the requested information",
        INFORM_SM_OF_EVENT_RAN_OUT_OF_AMMUNITION = 2 "Inform SM of event \"ran out of ammunition\"",
        INFORM_SM_OF_EVENT_KILLED_IN_ACTION = 3 "Inform SM of event \"killed in action\"",
        INFORM_SM_OF_EVENT_DAMAGE = 4 "Inform SM of event \"damage\"",
        INFORM_SM_OF_EVENT_MOBILITY_DISABLED = 5 "Inform SM of event \"mobility disabled\"",
        INFORM_SM_OF_EVENT_FIRE_DISABLED = 6 "Inform SM of event \"fire disabled\"",
        INFORM_SM_OF_EVENT_RAN_OUT_OF_FUEL = 7 "Inform SM of event \"ran out of fuel\"",
        RECALL_CHECKPOINT_DATA = 8 "Recall checkpoint data",
        RECALL_INITIAL_PARAMETERS = 9 "Recall initial parameters",
        INITIATE_TETHER_LEAD = 10 "Initiate tether-lead",
        INITIATE_TETHER_FOLLOW = 11 "Initiate tether-follow",
        UNTETHER = 12 "Untether",
        INITIATE_SERVICE_STATION_RESUPPLY = 13 "Initiate service station resupply",
        INITIATE_TAILGATE_RESUPPLY = 14 "Initiate tailgate resupply",
        INITIATE_HITCH_LEAD = 15 "Initiate hitch lead",
        INITIATE_HITCH_FOLLOW = 16 "Initiate hitch follow",
        UNHITCH = 17 "Unhitch",
        MOUNT = 18 "Mount",
        DISMOUNT = 19 "Dismount",
        START_DRC = 20 "Start DRC (Daily Readiness Check)",
        STOP_DRC = 21 "Stop DRC",
        DATA_QUERY = 22 "Data Query",
        STATUS_REQUEST = 23 "Status Request",
        SEND_OBJECT_STATE_DATA = 24 "Send Object State Data",
        RECONSTITUTE = 25 "Reconstitute",
        LOCK_SITE_CONFIGURATION = 26 "Lock Site Configuration",
        UNLOCK_SITE_CONFIGURATION = 27 "Unlock Site Configuration",
        UPDATE_SITE_CONFIGURATION = 28 "Update Site Configuration",
        QUERY_SITE_CONFIGURATION = 29 "Query Site Configuration",
        TETHERING_INFORMATION = 30 "Tethering Information",
        MOUNT_INTENT = 31 "Mount Intent",
        ACCEPT_SUBSCRIPTION = 33 "Accept Subscription",
        UNSUBSCRIBE = 34 "Unsubscribe",
        TELEPORT_ENTITY = 35 "Teleport entity",
        CHANGE_AGGREGATE_STATE = 36 "Change aggregate state",
        REQUEST_START_PDU = 37 "Request Start PDU",
        WAKEUP_GET_READY_FOR_INITIALIZATION = 38 "Wakeup get ready for initialization",
        INITIALIZE_INTERNAL_PARAMETERS = 39 "Initialize internal parameters",
        SEND_PLAN_DATA = 40 "Send plan data",
        SYNCHRONIZE_INTERNAL_CLOCKS = 41 "Synchronize internal clocks",
        RUN = 42 "Run",
        SAVE_INTERNAL_PARAMETERS = 43 "Save internal parameters",
        SIMULATE_MALFUNCTION = 44 "Simulate malfunction",
        JOIN_EXERCISE = 45 "Join exercise",
        RESIGN_EXERCISE = 46 "Resign exercise",
        TIME_ADVANCE = 47 "Time advance",
        TACCSF_LOS_REQUEST_TYPE_1 = 100 "TACCSF LOS Request-Type 1",
        TACCSF_LOS_REQUEST_TYPE_2 = 101 "TACCSF LOS Request-Type 2",
        AIRMOUNT_MOUNT_REQUEST = 4303 "Airmount Mount Request",
        AIRMOUNT_DISMOUNT_REQUEST = 4304 "Airmount Dismount Request",
        AIRMOUNT_INFORMATION_REQUEST = 4305 "Airmount Information Request",
    }
}

enumeration! {
    /// How a requested action went. SISO-REF-010, UID 72.
    RequestStatus: u32 {
        OTHER = 0 "Other",
        PENDING = 1 "Pending",
        EXECUTING = 2 "Executing",
        PARTIALLY_COMPLETE = 3 "Partially Complete",
        COMPLETE = 4 "Complete",
        REQUEST_REJECTED = 5 "Request rejected",
        RETRANSMIT_REQUEST_NOW = 6 "Retransmit request now",
        RETRANSMIT_REQUEST_LATER = 7 "Retransmit request later",
        INVALID_TIME_PARAMETERS = 8 "Invalid time parameters",
        SIMULATION_TIME_EXCEEDED = 9 "Simulation time exceeded",
        REQUEST_DONE = 10 "Request done",
        TACCSF_LOS_REPLY_TYPE_1 = 100 "TACCSF LOS Reply-Type 1",
        TACCSF_LOS_REPLY_TYPE_2 = 101 "TACCSF LOS Reply-Type 2",
        JOIN_EXERCISE_REQUEST_REJECTED = 201 "Join Exercise Request Rejected",
    }
}

enumeration! {
    /// Kind of an event. SISO-REF-010, UID 73.
    EventType: u32 {
        OTHER = 0 "Other",
        RAN_OUT_OF_AMMUNITION = 2 "Ran Out of Ammunition",
        KILLED_IN_ACTION = 3 "Killed in Action (KIA)",
        DAMAGE = 4 "Damage",
        MOBILITY_DISABLED = 5 "Mobility Disabled",
        FIRE_DISABLED = 6 "Fire Disabled",
        RAN_OUT_OF_FUEL = 7 "Ran Out of Fuel",
        ENTITY_INITIALIZATION = 8 "Entity Initialization",
        REQUEST_FOR_INDIRECT_FIRE_OR_CAS_MISSION = 9 "Request for Indirect Fire or CAS Mission",
        INDIRECT_FIRE_OR_CAS_FIRE = 10 "Indirect Fire or CAS Fire",
        MINEFIELD_ENTRY = 11 "Minefield Entry",
        MINEFIELD_DETONATION = 12 "Minefield Detonation",
        VEHICLE_MASTER_POWER_ON = 13 "Vehicle Master Power On",
        VEHICLE_MASTER_POWER_OFF = 14 "Vehicle Master Power Off",
        AGGREGATE_STATE_CHANGE_REQUESTED = 15 "Aggregate State Change Requested",
        PREVENT_COLLISION_DETONATION = 16 "Prevent Collision / Detonation",
        OWNERSHIP_REPORT = 17 "Ownership Report",
        RADAR_PERCEPTION = 18 "Radar Perception",
        DETECT = 19 "Detect",
    }
}

enumeration! {
    /// Required reliability service of the -R PDUs. SISO-REF-010, UID 74.
    Reliability: u8 {
        ACKNOWLEDGED = 0 "Acknowledged",
        UNACKNOWLEDGED = 1 "Unacknowledged",
    }
}

enumeration! {
    /// Kind of a transfer of ownership. SISO-REF-010, UID 224.
    TransferType: u8 {
        OTHER = 0 "Other",
        PUSH_TRANSFER_ENTITY = 1 "Push Transfer - Entity",
        AUTOMATIC_PULL_TRANSFER_ENTITY = 2 "Automatic Pull Transfer - Entity",
        NOT_USED = 3 "Not Used",
        PUSH_TRANSFER_ENVIRONMENTAL_PROCESS = 4 "Push Transfer - Environmental Process",
        AUTOMATIC_PULL_TRANSFER_ENVIRONMENTAL_PROCESS = 5 "Automatic Pull Transfer - Environmental Process",
        NOT_USED_6 = 6 "Not Used",
        CANCEL_TRANSFER = 7 "Cancel Transfer",
        MANUAL_PULL_TRANSFER_ENTITY = 8 "Manual Pull Transfer - Entity",
        MANUAL_PULL_TRANSFER_ENVIRONMENTAL_PROCESS = 9 "Manual Pull Transfer - Environmental Process",
        REMOVE_ENTITY = 10 "Remove Entity",
    }
}
