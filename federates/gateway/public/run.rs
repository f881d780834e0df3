//! Public messages about the run itself: state, flights, weather, operators, federates, commands.

use super::{Public, Said, SaidOrEmpty};
use models::flight_list::{MovementKind, WakeCategory};
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

public! {
    /// A federate as the conductor sees it.
    Member {
        /// Name.
        name: String,
        /// Host.
        host: String,
        /// Process.
        pid: u32,
        /// Whether the run waits for it.
        essential: bool,
        /// Joined and alive.
        alive: bool,
        /// Last frame executed.
        frame: u64,
    }
}

public! {
    /// How the run stands.
    State {
        /// INIT, CONFIGURED, RUNNING, FROZEN or STOPPED.
        phase: String,
        /// Lowest frame that every essential member has executed.
        frame: u64,
        /// Last frame of the run.
        last_frame: u64,
        /// Length of a frame, s.
        step_s: f64,
        /// Seed.
        seed: u64,
        /// Simulated seconds per wall second; absent: as fast as possible.
        rate: Option<f64>,
        /// The same as achieved over the last seconds.
        achieved_rate: f64,
        /// Why it is degraded or frozen; empty when all is well.
        reasons: Vec<String>,
        /// Members and spectators.
        federates: Vec<Member>,
        /// Latitude of the reference point, degrees.
        reference_lat_deg: f64,
        /// Longitude of the reference point, degrees.
        reference_lon_deg: f64,
        /// Its height, m.
        elevation_m: f64,
        /// Aerodrome.
        airport: String,
        /// Version of the program.
        version: String,
    }
}

public! {
    /// One line of the flight list.
    Flight {
        /// Call sign or vehicle name.
        callsign: String,
        /// 24-bit address, six hexadecimal digits.
        address: Option<String>,
        /// Type designator.
        r#type: String,
        /// Wake category; empty for vehicles.
        wake: SaidOrEmpty<WakeCategory>,
        /// What it is about.
        movement: Said<MovementKind>,
        /// Runway; empty for vehicles.
        runway: String,
        /// Stand.
        stand: String,
        /// Arrival expected or departure calculated, s of simulated time.
        eta_ctd_s: f64,
        /// Off-block time of a departure, s of simulated time.
        off_block_s: Option<f64>,
        /// Taxiways of the clearance.
        routing: Vec<String>,
    }
}

public! {
    /// The flight list as it stands.
    Flights {
        /// Its lines.
        flights: Vec<Flight>,
    }
}

public! {
    /// Weather from a time on.
    Weather {
        /// From when on, s of simulated time.
        from_s: f64,
        /// Rain, mm/h.
        rain_mm_per_h: f64,
        /// Visibility, m; absent: clear.
        visibility_m: Option<f64>,
        /// Temperature, °C.
        temperature_c: f64,
        /// Pressure, hPa.
        pressure_hpa: f64,
        /// Water vapour, g/m³.
        vapour_g_per_m3: f64,
        /// Wind to the east, m/s.
        wind_east_ms: f64,
        /// Wind to the north, m/s.
        wind_north_ms: f64,
        /// Water on the pavement, mm.
        film_mm: f64,
        /// Rain cells: m east, m north, radius m, mm/h.
        cells: Vec<[f64; 4]>,
    }
}

public! {
    /// An operator's command and what became of it.
    OperationDone {
        /// Frame at which the run stood.
        frame: u64,
        /// Where it came from.
        source: String,
        /// What was asked.
        command: String,
        /// Whether it was carried out.
        done: bool,
        /// State reached, or why not.
        answer: String,
    }
}

public! {
    /// Load and counters of a federate.
    Federate {
        /// Name.
        name: String,
        /// Host.
        host: String,
        /// Process.
        pid: u32,
        /// Frame executed, or seen.
        frame: u64,
        /// Processor seconds since its start.
        cpu_s: f64,
        /// Share of one core, %.
        cpu_percent: f64,
        /// Resident memory, octets.
        memory_bytes: u64,
        /// PDUs received.
        pdus_in: u64,
        /// PDUs sent.
        pdus_out: u64,
        /// PDUs that did not arrive by themselves.
        lost: u64,
        /// PDUs fetched again.
        repaired: u64,
        /// Dropped, by reason.
        dropped: BTreeMap<String, u64>,
        /// Mean time to execute a frame or a scan, µs.
        exec_us: f64,
        /// What a person should look after.
        alarms: Vec<String>,
    }
}

public! {
    /// An aircraft that was given to the traffic, or a flight that was to be let go, and what came of it.
    Handover {
        /// Counted with all inputs of the run.
        number: u64,
        /// Who asked.
        client: String,
        /// give or release.
        asked: String,
        /// Call sign.
        callsign: String,
        /// Frame from which it is ours, or is not any more.
        frame: u64,
        /// Time of that frame, s.
        time_s: f64,
        /// Why not; absent: it was done.
        refused: Option<String>,
    }
}

public! {
    /// The last handovers, in the order in which they were asked for.
    Handovers {
        /// At most 64.
        handovers: Vec<Handover>,
    }
}

public! {
    /// What a client asks of the run; "resume" is another name of "start".
    CommandAsked {
        /// freeze, start, resume, stop, restart, step, rate, status, move, without, give or release.
        command: String,
        /// Frames of a step.
        n: Option<u64>,
        /// Simulated seconds per wall second; absent in rate: as fast as possible.
        rate: Option<f64>,
        /// move: whose place is given to another process; without: which lost federate the run goes on without.
        name: Option<String>,
        /// move: whose process takes it.
        to: Option<String>,
        /// Who asks, for the log of operations.
        client: Option<String>,
        /// give, release: call sign, 1 to 8 upper-case letters and digits.
        callsign: Option<String>,
        /// give: type designator.
        r#type: Option<String>,
        /// give: 24-bit address, hexadecimal.
        address: Option<String>,
        /// give: latitude, WGS 84.
        lat_deg: Option<f64>,
        /// give: longitude.
        lon_deg: Option<f64>,
        /// give: height above the ellipsoid, as DIS has it.
        height_m: Option<f64>,
        /// give: velocity towards east, where it is.
        vx_ms: Option<f64>,
        /// give: towards north.
        vy_ms: Option<f64>,
        /// give: upwards.
        vz_ms: Option<f64>,
        /// give: how old the state was when it was sent; absent: 0.
        age_s: Option<f64>,
        /// give: the time of the run at which it was there, in place of age_s; absent: by that.
        time_s: Option<f64>,
        /// give: runway end; absent: the nearest final.
        runway: Option<String>,
        /// give: stand wanted.
        stand: Option<String>,
    }
}

public! {
    /// The answer to a command, once its state is reached.
    CommandAnswered {
        /// Name and version.
        schema: String,
        /// Whether it was carried out.
        ok: bool,
        /// State reached, or why not and what is possible.
        text: String,
    }
}
