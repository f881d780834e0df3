//! Simulation management: create, start, stop, ask, tell.
//!
//! Receiving identifiers may hold wildcards ([`EntityId::ALL`]). A request and its answer share the
//! request identifier.

use crate::enumerations::{
    AcknowledgeFlag, ActionId, DatumId, EventType, RequestStatus, ResponseFlag, StopReason,
};
use crate::records::{ClockTime, EntityId, FixedDatum, VariableDatum};

record! {
    /// Create Entity (type 11). Source: IEEE 1278.1-2012, 7.5.2.
    CreateEntity {
        /// Who asks.
        originating_id: EntityId,
        /// Who shall create, or what shall be created.
        receiving_id: EntityId,
        /// Number of the request.
        request_id: u32,
    }
}
fixed_body!(CreateEntity = CREATE_ENTITY);

record! {
    /// Remove Entity (type 12). Source: IEEE 1278.1-2012, 7.5.3.
    RemoveEntity {
        /// Who asks.
        originating_id: EntityId,
        /// What shall be removed.
        receiving_id: EntityId,
        /// Number of the request.
        request_id: u32,
    }
}
fixed_body!(RemoveEntity = REMOVE_ENTITY);

record! {
    /// Start/Resume (type 13). Source: IEEE 1278.1-2012, 7.5.4.
    StartResume {
        /// Who asks.
        originating_id: EntityId,
        /// Who shall start.
        receiving_id: EntityId,
        /// When to start, in real time.
        real_world_time: ClockTime,
        /// The simulation time at the start.
        simulation_time: ClockTime,
        /// Number of the request.
        request_id: u32,
    }
}
fixed_body!(StartResume = START_RESUME);

record! {
    /// Stop/Freeze (type 14). Source: IEEE 1278.1-2012, 7.5.5.
    StopFreeze {
        /// Who asks.
        originating_id: EntityId,
        /// Who shall stop.
        receiving_id: EntityId,
        /// When to stop, in real time.
        real_world_time: ClockTime,
        /// Why.
        reason: StopReason,
        /// What goes on while frozen: bit 0 the clock, bit 1 sending, bit 2 receiving.
        frozen_behaviour: u8,
        /// Unused.
        padding: u16,
        /// Number of the request.
        request_id: u32,
    }
}
fixed_body!(StopFreeze = STOP_FREEZE);

record! {
    /// Acknowledge (type 15). Source: IEEE 1278.1-2012, 7.5.6.
    Acknowledge {
        /// Who answers.
        originating_id: EntityId,
        /// Who asked.
        receiving_id: EntityId,
        /// What is acknowledged.
        acknowledge_flag: AcknowledgeFlag,
        /// Whether it will be done.
        response_flag: ResponseFlag,
        /// Number of the request.
        request_id: u32,
    }
}
fixed_body!(Acknowledge = ACKNOWLEDGE);

body! {
    /// Action Request (type 16). Source: IEEE 1278.1-2012, 7.5.7.
    ActionRequest = ACTION_REQUEST {
        /// Who asks.
        originating_id: EntityId;
        /// Who shall act.
        receiving_id: EntityId;
        /// Number of the request.
        request_id: u32;
        /// The action.
        action_id: ActionId;
        count number_of_fixed_datums: u32 = fixed_datums;
        count number_of_variable_datums: u32 = variable_datums;
        /// Data of fixed size.
        list fixed_datums: FixedDatum, number_of_fixed_datums;
        /// Data of variable size.
        list variable_datums: VariableDatum<'a>, number_of_variable_datums;
    }
}

body! {
    /// Action Response (type 17). Source: IEEE 1278.1-2012, 7.5.8.
    ActionResponse = ACTION_RESPONSE {
        /// Who answers.
        originating_id: EntityId;
        /// Who asked.
        receiving_id: EntityId;
        /// Number of the request.
        request_id: u32;
        /// How it went.
        request_status: RequestStatus;
        count number_of_fixed_datums: u32 = fixed_datums;
        count number_of_variable_datums: u32 = variable_datums;
        /// Data of fixed size.
        list fixed_datums: FixedDatum, number_of_fixed_datums;
        /// Data of variable size.
        list variable_datums: VariableDatum<'a>, number_of_variable_datums;
    }
}

body! {
    /// Data Query (type 18). Source: IEEE 1278.1-2012, 7.5.9.
    DataQuery = DATA_QUERY {
        /// Who asks.
        originating_id: EntityId;
        /// Who is asked.
        receiving_id: EntityId;
        /// Number of the request.
        request_id: u32;
        /// Interval of repeated answers as timestamp units, 0 for one answer.
        time_interval: crate::DisTime;
        count number_of_fixed_datums: u32 = fixed_datum_ids;
        count number_of_variable_datums: u32 = variable_datum_ids;
        /// What is asked, of fixed size.
        list fixed_datum_ids: DatumId, number_of_fixed_datums;
        /// What is asked, of variable size.
        list variable_datum_ids: DatumId, number_of_variable_datums;
    }
}

body! {
    /// Set Data (type 19). Source: IEEE 1278.1-2012, 7.5.10.
    SetData = SET_DATA {
        /// Who asks.
        originating_id: EntityId;
        /// Whose data shall be set.
        receiving_id: EntityId;
        /// Number of the request.
        request_id: u32;
        /// Unused.
        padding: u32;
        count number_of_fixed_datums: u32 = fixed_datums;
        count number_of_variable_datums: u32 = variable_datums;
        /// Data of fixed size.
        list fixed_datums: FixedDatum, number_of_fixed_datums;
        /// Data of variable size.
        list variable_datums: VariableDatum<'a>, number_of_variable_datums;
    }
}

body! {
    /// Data (type 20). Source: IEEE 1278.1-2012, 7.5.11.
    Data = DATA {
        /// Who answers.
        originating_id: EntityId;
        /// Who asked.
        receiving_id: EntityId;
        /// Number of the request.
        request_id: u32;
        /// Unused.
        padding: u32;
        count number_of_fixed_datums: u32 = fixed_datums;
        count number_of_variable_datums: u32 = variable_datums;
        /// Data of fixed size.
        list fixed_datums: FixedDatum, number_of_fixed_datums;
        /// Data of variable size.
        list variable_datums: VariableDatum<'a>, number_of_variable_datums;
    }
}

body! {
    /// Event Report (type 21). Source: IEEE 1278.1-2012, 7.5.12.
    EventReport = EVENT_REPORT {
        /// Who reports.
        originating_id: EntityId;
        /// To whom.
        receiving_id: EntityId;
        /// What happened.
        event_type: EventType;
        /// Unused.
        padding: u32;
        count number_of_fixed_datums: u32 = fixed_datums;
        count number_of_variable_datums: u32 = variable_datums;
        /// Data of fixed size.
        list fixed_datums: FixedDatum, number_of_fixed_datums;
        /// Data of variable size.
        list variable_datums: VariableDatum<'a>, number_of_variable_datums;
    }
}

body! {
    /// Comment (type 22): free text in variable datums. Source: IEEE 1278.1-2012, 7.5.13.
    Comment = COMMENT {
        /// Who comments.
        originating_id: EntityId;
        /// To whom.
        receiving_id: EntityId;
        count number_of_fixed_datums: u32 = fixed_datums;
        count number_of_variable_datums: u32 = variable_datums;
        /// Should be empty; kept where it is not.
        list fixed_datums: FixedDatum, number_of_fixed_datums;
        /// The comments.
        list variable_datums: VariableDatum<'a>, number_of_variable_datums;
    }
}
