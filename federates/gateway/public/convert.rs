//! The federation's messages as public ones.

use super::{
    Federate, Flight, Flights, Handover, Head, Lag, Member, OperationDone, Plot, Plots, Said,
    SaidOrEmpty, Scan, State, Track, Tracks, Truth, Truths, VERSION, Weather,
};
use crate::exchange::driven;
use crate::gateway::Gateway;
use crate::runtime::messages::{
    FederateStatus, FlightNotice, HANDOVER_SEAT, Operation, PlotMessage, RunState, ScanReport,
    SeatEvent, SeatMessage, TrackMessage, TruthMessage, WeatherNotice,
};
use serde::Serialize;
use serde_json::{Map, Value, json};

/// `2019-11-24T09:03:51.000Z`.
#[must_use]
pub fn iso8601(utc_ns: i64) -> String {
    let (date, time) = mode_s::sbs::date_and_time(utc_ns);
    format!("{}T{time}Z", date.replace('/', "-"))
}

/// What messages are headed with.
#[derive(Clone, Debug, Default)]
pub struct Heading {
    /// DIS exercise.
    pub exercise: u8,
    /// Scene.
    pub scene: String,
    /// Number of the run.
    pub run: u32,
    /// Number of the last scan.
    pub scan: u64,
    /// Simulated time, ns.
    pub time_ns: i64,
}

/// A body under its head, as one object.
#[must_use]
pub fn message(gateway: &Gateway, heading: &Heading, name: &str, body: &impl Serialize) -> Value {
    let head = Head {
        schema: format!("seeds.{name}/{VERSION}"),
        exercise: heading.exercise.into(),
        run: heading.run,
        scan: heading.scan,
        time_s: heading.time_ns as f64 / 1e9,
        utc: iso8601(gateway.utc_ns(heading.time_ns)),
        scene: heading.scene.clone(),
    };
    let object = |value: Value| match value {
        Value::Object(fields) => fields,
        _ => Map::new(),
    };
    let mut all = object(serde_json::to_value(head).unwrap_or_default());
    all.extend(object(serde_json::to_value(body).unwrap_or_default()));
    Value::Object(all)
}

fn some(text: &str) -> Option<String> {
    (!text.is_empty()).then(|| text.to_owned())
}

fn degrees(rad: f64) -> f64 {
    rad.to_degrees().rem_euclid(360.0)
}

fn track(gateway: &Gateway, x: &TrackMessage, pair: Option<(&TruthMessage, f64)>) -> Track {
    let [lat_deg, lon_deg] = gateway.place(x.position_m.into());
    Track {
        track: x.number,
        status: Said(x.status),
        r#type: Said(x.track_type),
        callsign: x.callsign.clone(),
        type_designator: x.type_designator.clone(),
        movement: SaidOrEmpty(x.movement),
        x_m: x.position_m[0],
        y_m: x.position_m[1],
        lat_deg,
        lon_deg,
        vx_ms: x.velocity_mps[0],
        vy_ms: x.velocity_mps[1],
        speed_ms: libm::hypot(x.velocity_mps[0], x.velocity_mps[1]),
        heading_deg: degrees(x.heading_rad),
        altitude_m: x.altitude_m,
        var_ee_m2: x.cov_m2[0],
        var_en_m2: x.cov_m2[1],
        var_nn_m2: x.cov_m2[2],
        manoeuvre: x.manoeuvre.into(),
        entity: pair.map(|(truth, _)| truth.callsign.clone()),
        error_m: pair.map(|(_, error_m)| error_m),
        assumed: some(&x.assumed),
        label_p: x.label_p,
        altitude_age_s: x.altitude_ns.map(|told_ns| (x.time_ns - told_ns) as f64 / 1e9),
        lag: x.lag.as_ref().map(|l| Lag {
            time_ns: l.time_ns,
            x_m: l.position_m[0],
            y_m: l.position_m[1],
            var_ee_m2: l.cov_m2[0],
            var_en_m2: l.cov_m2[1],
            var_nn_m2: l.cov_m2[2],
            coasted: l.coasted,
            error_m: l.error_m,
        }),
    }
}

fn plot(x: &PlotMessage) -> Plot {
    let error_m = x.truth_m.map(|t| libm::hypot(x.position_m[0] - t[0], x.position_m[1] - t[1]));
    Plot {
        sensor: x.sensor,
        sequence: x.sequence,
        kind: Said(x.kind),
        time_ns: x.time_ns,
        x_m: x.position_m[0],
        y_m: x.position_m[1],
        var_ee_m2: x.cov_m2[0],
        var_en_m2: x.cov_m2[1],
        var_nn_m2: x.cov_m2[2],
        range_m: x.polar.map(|p| p[0]),
        azimuth_deg: x.polar.map(|p| degrees(p[1])),
        scnr_db: x.scnr_db,
        altitude_m: x.altitude_m,
        identity: some(&x.identity),
        track: x.track,
        cause: some(&x.cause),
        truth_x_m: x.truth_m.map(|t| t[0]),
        truth_y_m: x.truth_m.map(|t| t[1]),
        error_m,
    }
}

fn truth(gateway: &Gateway, x: &TruthMessage) -> Truth {
    let [east_m, north_m, up_m]: [f64; 3] = x.position_m.into();
    let place = gateway.frame.to_ecef(geodesy::Enu { east_m, north_m, up_m }).to_geodetic();
    Truth {
        entity: x.key(),
        dis_id: format!("{}.{}.{}", x.id[0], x.id[1], x.id[2]),
        callsign: x.callsign.clone(),
        r#type: x.type_designator.clone(),
        aircraft: x.aircraft,
        ours: x.ours,
        x_m: east_m,
        y_m: north_m,
        lat_deg: place.lat_deg(),
        lon_deg: place.lon_deg(),
        altitude_m: up_m,
        vx_ms: x.velocity_mps[0],
        vy_ms: x.velocity_mps[1],
        heading_deg: degrees(x.heading_rad),
        length_m: x.size_m[0],
        width_m: x.size_m[1],
        track: x.track.map(|p| p.0),
        track_error_m: x.track.map(|p| p.1),
    }
}

/// Tracks of a scan.
#[must_use]
pub fn tracks(gateway: &Gateway, scan: &ScanReport) -> Tracks {
    let pairs = scan.followed();
    let pair = |number: &u16| {
        pairs.get(number).and_then(|(i, error_m)| Some((scan.truth.get(*i)?, *error_m)))
    };
    Tracks { tracks: scan.tracks.iter().map(|x| track(gateway, x, pair(&x.number))).collect() }
}

/// Plots of a scan.
#[must_use]
pub fn plots(scan: &ScanReport) -> Plots {
    Plots { plots: scan.plots.iter().map(plot).collect() }
}

/// Truth of a scan.
#[must_use]
pub fn truths(gateway: &Gateway, scan: &ScanReport) -> Truths {
    Truths { truth: scan.truth.iter().map(|x| truth(gateway, x)).collect() }
}

/// All of a scan.
#[must_use]
pub fn scan(gateway: &Gateway, scan: &ScanReport) -> Scan {
    Scan {
        tracks: tracks(gateway, scan).tracks,
        plots: plots(scan).plots,
        truth: truths(gateway, scan).truth,
        measures: scan.measures.iter().filter(|m| m.1.is_finite()).cloned().collect(),
    }
}

/// A handover; `None` where the input is another, or nothing has come of it.
#[must_use]
pub fn handover(message: &SeatMessage, frame_s: f64) -> Option<Handover> {
    let SeatEvent::Input { frame, input, refused } = &message.event else { return None };
    if input.order.seat != HANDOVER_SEAT {
        return None;
    }
    // It takes effect a little after the frame in which it was let in.
    let frame = frame + driven::delay_in(frame_s);
    Some(Handover {
        number: input.number,
        client: input.order.person.clone(),
        asked: input.order.action.word().to_owned(),
        callsign: input.order.action.said().0.to_owned(),
        frame,
        time_s: frame as f64 * frame_s,
        refused: (!refused.is_empty()).then(|| refused.clone()),
    })
}

/// How the run stands.
#[must_use]
pub fn state(gateway: &Gateway, x: &RunState) -> State {
    let [reference_lat_deg, reference_lon_deg] = gateway.place([0.0, 0.0]);
    let member = |m: &crate::runtime::messages::MemberState| Member {
        name: m.name.clone(),
        host: m.host.clone(),
        pid: m.pid,
        essential: m.essential,
        alive: m.alive,
        frame: m.frame,
    };
    State {
        phase: x.phase.to_string(),
        frame: x.frame,
        last_frame: x.last_frame,
        step_s: x.step_ns as f64 / 1e9,
        seed: x.seed,
        rate: Some(x.rate),
        achieved_rate: x.achieved_rate,
        reasons: x.reasons.clone(),
        federates: x.members.iter().map(member).collect(),
        reference_lat_deg,
        reference_lon_deg,
        elevation_m: gateway.elevation_m,
        airport: gateway.icao.clone(),
        version: crate::runtime::build::VERSION.to_owned(),
    }
}

/// The flight list.
#[must_use]
pub fn flights(list: &[FlightNotice]) -> Flights {
    let line = |x: &FlightNotice| Flight {
        callsign: x.callsign.clone(),
        address: x.address.map(|a| format!("{a:06x}")),
        r#type: x.type_designator.clone(),
        wake: SaidOrEmpty(x.wake),
        movement: Said(x.movement),
        runway: x.runway.clone(),
        stand: x.stand.clone(),
        eta_ctd_s: x.eta_ctd_ns as f64 / 1e9,
        off_block_s: x.off_block_ns.map(|ns| ns as f64 / 1e9),
        routing: x.routing.clone(),
    };
    Flights { flights: list.iter().map(line).collect() }
}

/// Weather.
#[must_use]
pub fn weather(x: &WeatherNotice) -> Weather {
    Weather {
        from_s: x.from_ns as f64 / 1e9,
        rain_mm_per_h: x.rain_mm_per_h,
        visibility_m: Some(x.visibility_m),
        temperature_c: x.temperature_k - 273.15,
        pressure_hpa: x.pressure_hpa,
        vapour_g_per_m3: x.vapour_g_per_m3,
        wind_east_ms: x.wind_mps[0],
        wind_north_ms: x.wind_mps[1],
        film_mm: x.film_mm,
        cells: x.cells.clone(),
    }
}

/// A command of somebody.
#[must_use]
pub fn operation(x: &Operation) -> OperationDone {
    OperationDone {
        frame: x.frame,
        source: x.source.clone(),
        command: x.command.clone(),
        done: x.ok,
        answer: x.text.clone(),
    }
}

/// Load and counters of a federate.
#[must_use]
pub fn federate(x: &FederateStatus) -> Federate {
    Federate {
        name: x.name.clone(),
        host: x.host.clone(),
        pid: x.pid,
        frame: x.frame,
        cpu_s: x.cpu_s,
        cpu_percent: x.cpu_pct,
        memory_bytes: x.rss_bytes,
        pdus_in: x.pdus_in,
        pdus_out: x.pdus_out,
        lost: x.lost,
        repaired: x.repaired,
        dropped: x.dropped.iter().cloned().collect(),
        exec_us: x.exec_us,
        alarms: x.alarms.clone(),
    }
}

/// Tracks or truth as a GeoJSON collection of points (RFC 7946); all other keys are properties.
#[must_use]
pub fn geojson(head: Value, list: &str) -> Value {
    let Value::Object(mut all) = head else { return Value::Null };
    let rows = all.remove(list);
    let rows = rows.as_ref().and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let features: Vec<Value> = rows
        .iter()
        .filter_map(|row| {
            let mut properties = row.as_object()?.clone();
            let place = [properties.remove("lon_deg")?, properties.remove("lat_deg")?];
            Some(json!({
                "type": "Feature", "properties": properties,
                "geometry": {"type": "Point", "coordinates": place},
            }))
        })
        .collect();
    all.insert("type".into(), json!("FeatureCollection"));
    all.insert("features".into(), Value::Array(features));
    Value::Object(all)
}
