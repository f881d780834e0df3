//! The public messages: JSON with the names of the database, and their schema made from the same declarations.
//!
//! Within `/1` keys are only added; a key that is removed or means something else is `/2`. What is not known is absent, never
//! null and never NaN. Angles are degrees clockwise from north, positions metres east and north of the reference point.

use models::flight_list::MovementKind;
use models::plot::SensorKind;
use models::track::{TrackStatus, TrackType};
use models::words::Word;
use serde::{Serialize, Serializer};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// Version of all public messages; part of every key (`seeds-v1`).
pub const VERSION: u32 = 1;

/// A value of a public message: how it is described, and whether it is left out.
trait Public {
    /// Whether every message has it.
    const ALWAYS: bool = true;
    fn schema() -> Value;
    fn absent(&self) -> bool {
        false
    }
}

macro_rules! plain {
    ($($ty:ty => $schema:tt),* $(,)?) => { $(impl Public for $ty { fn schema() -> Value { json!($schema) } })* };
}
plain! {
    bool => {"type": "boolean"},
    String => {"type": "string"},
    u16 => {"type": "integer", "minimum": 0},
    u32 => {"type": "integer", "minimum": 0},
    u64 => {"type": "integer", "minimum": 0},
    i64 => {"type": "integer"},
}

impl Public for f64 {
    fn schema() -> Value {
        json!({"type": "number"})
    }
    fn absent(&self) -> bool {
        !self.is_finite()
    }
}

impl<T: Public> Public for Option<T> {
    const ALWAYS: bool = false;
    fn schema() -> Value {
        T::schema()
    }
    fn absent(&self) -> bool {
        self.as_ref().is_none_or(Public::absent)
    }
}

impl<T: Public> Public for Vec<T> {
    fn schema() -> Value {
        json!({"type": "array", "items": T::schema()})
    }
}

impl<T: Public> Public for BTreeMap<String, T> {
    fn schema() -> Value {
        json!({"type": "object", "additionalProperties": T::schema()})
    }
}

/// A value that is said as its word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Said<T>(pub T);

impl<T: Word> Serialize for Said<T> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(&self.0.said())
    }
}

impl<T: Word> Public for Said<T> {
    fn schema() -> Value {
        json!({"type": "string", "enum": T::words()})
    }
}

/// The same where there may be none: the empty word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SaidOrEmpty<T>(pub Option<T>);

impl<T: Word> Serialize for SaidOrEmpty<T> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(&self.0.as_ref().map(Word::said).unwrap_or_default())
    }
}

impl<T: Word> Public for SaidOrEmpty<T> {
    fn schema() -> Value {
        let mut words = T::words();
        words.push("".into());
        json!({"type": "string", "enum": words})
    }
}

impl Public for [f64; 4] {
    fn schema() -> Value {
        json!({"type": "array", "items": {"type": "number"}, "minItems": 4, "maxItems": 4})
    }
}

/// One object: its fields in their order, each with what it says.
macro_rules! public {
    ($(#[doc = $about:literal])+ $name:ident { $( $(#[doc = $doc:literal])+ $field:ident: $ty:ty, )* }) => {
        $(#[doc = $about])+
        #[derive(Clone, Debug, PartialEq, Serialize)]
        pub struct $name { $( $(#[doc = $doc])+ #[serde(skip_serializing_if = "Public::absent")] pub $field: $ty, )* }
        impl Public for $name {
            fn schema() -> Value {
                let mut properties = Map::new();
                let mut required = Vec::new();
                $(
                    let name = stringify!($field).trim_start_matches("r#");
                    let mut schema = <$ty as Public>::schema();
                    schema["description"] = json!(concat!($($doc),+).trim());
                    properties.insert(name.to_owned(), schema);
                    if <$ty as Public>::ALWAYS { required.push(name); }
                )*
                json!({"type": "object", "description": concat!($($about),+).trim(), "properties": properties, "required": required})
            }
        }
    };
}

public! {
    /// What every message begins with.
    Head {
        /// Name of the message and its version.
        schema: String,
        /// DIS exercise.
        exercise: u32,
        /// Number of the run; a restart counts it up.
        run: u32,
        /// Number of the scan, from 1; 0 before the first.
        scan: u64,
        /// Simulated time, s.
        time_s: f64,
        /// The same in UTC of the scene, ISO 8601 with ms.
        utc: String,
        /// Scene.
        scene: String,
    }
}

public! {
    /// A system track as published.
    Track {
        /// Track number: 0 to 4095, of a `bulk` tracker also 8192 to 32767 (4096 to 8191: begun by an outsider's plot).
        track: u16,
        /// Where it is in its life.
        status: Said<TrackStatus>,
        /// Whether it is an aircraft or a vehicle of the flight list.
        r#type: Said<TrackType>,
        /// Call sign of the label; empty if none.
        callsign: String,
        /// Type designator; empty if none.
        type_designator: String,
        /// What its label says that it is about; empty if none.
        movement: SaidOrEmpty<MovementKind>,
        /// m east of the reference point.
        x_m: f64,
        /// m north of the reference point.
        y_m: f64,
        /// Latitude of that point of the airport's plane, degrees.
        lat_deg: f64,
        /// Longitude, degrees.
        lon_deg: f64,
        /// m/s to the east.
        vx_ms: f64,
        /// m/s to the north.
        vy_ms: f64,
        /// Speed over ground, m/s.
        speed_ms: f64,
        /// Course over ground, degrees.
        heading_deg: f64,
        /// Height above the aerodrome reference, m.
        altitude_m: Option<f64>,
        /// Variance to the east, m².
        var_ee_m2: f64,
        /// Covariance east and north, m².
        var_en_m2: f64,
        /// Variance to the north, m².
        var_nn_m2: f64,
        /// 1: a manoeuvre was marked.
        manoeuvre: u32,
        /// The entity that it follows (call sign): evaluation, not known to the tracker.
        entity: Option<String>,
        /// Distance from it, m.
        error_m: Option<f64>,
        /// A call sign that is likely, but too unsure for a label.
        assumed: Option<String>,
        /// Probability of the label, or of what is assumed.
        label_p: Option<f64>,
        /// How long ago that height was reported, s.
        altitude_age_s: Option<f64>,
        /// The publication before, revised by the plots of this scan; absent in a first report.
        lag: Option<Lag>,
    }
}

public! {
    /// A track at the publication before, as it is known now.
    Lag {
        /// Time of validity, ns of simulated time.
        time_ns: i64,
        /// m east of the reference point.
        x_m: f64,
        /// m north of the reference point.
        y_m: f64,
        /// Variance to the east, m².
        var_ee_m2: f64,
        /// Covariance east and north, m².
        var_en_m2: f64,
        /// Variance to the north, m².
        var_nn_m2: f64,
        /// No plot came between: it is what was published then.
        coasted: bool,
        /// Distance from the entity that the track follows, m.
        error_m: Option<f64>,
    }
}

public! {
    /// A plot, with its cause for evaluation.
    Plot {
        /// Number of the sensor.
        sensor: u16,
        /// Number within sensor and scan.
        sequence: u32,
        /// Kind of the sensor.
        kind: Said<SensorKind>,
        /// Time of the measurement, ns of simulated time.
        time_ns: i64,
        /// m east of the reference point.
        x_m: f64,
        /// m north of the reference point.
        y_m: f64,
        /// Variance to the east, m².
        var_ee_m2: f64,
        /// Covariance east and north, m².
        var_en_m2: f64,
        /// Variance to the north, m².
        var_nn_m2: f64,
        /// Slant range of a radar, m.
        range_m: Option<f64>,
        /// Azimuth of a radar, degrees.
        azimuth_deg: Option<f64>,
        /// Signal to clutter and noise, dB.
        scnr_db: Option<f64>,
        /// Reported height above the aerodrome reference, m.
        altitude_m: Option<f64>,
        /// As the target reported it.
        identity: Option<String>,
        /// Track that took it.
        track: Option<u16>,
        /// Entity that caused it; absent: false alarm.
        cause: Option<String>,
        /// Where that was then, m east.
        truth_x_m: Option<f64>,
        /// m north.
        truth_y_m: Option<f64>,
        /// Distance between the two, m.
        error_m: Option<f64>,
    }
}

public! {
    /// True state of an entity, as the sensors received it.
    Truth {
        /// Key of the entity: its DIS identifier as one number.
        entity: u64,
        /// DIS identifier: site.application.entity.
        dis_id: String,
        /// Marking.
        callsign: String,
        /// Type designator; empty if not known.
        r#type: String,
        /// Whether it is an aircraft.
        aircraft: bool,
        /// Whether it belongs to the federation.
        ours: bool,
        /// m east of the reference point.
        x_m: f64,
        /// m north of the reference point.
        y_m: f64,
        /// Latitude, degrees.
        lat_deg: f64,
        /// Longitude, degrees.
        lon_deg: f64,
        /// m up from the airport's plane.
        altitude_m: f64,
        /// m/s to the east.
        vx_ms: f64,
        /// m/s to the north.
        vy_ms: f64,
        /// Where the nose points, degrees.
        heading_deg: f64,
        /// Length, m.
        length_m: f64,
        /// Span or width, m.
        width_m: f64,
        /// Track that follows it.
        track: Option<u16>,
        /// Distance from that track, m.
        track_error_m: Option<f64>,
    }
}

public! {
    /// Tracks, plots, truth and measures of one scan.
    Scan {
        /// Tracks, by number.
        tracks: Vec<Track>,
        /// Plots, by sensor and sequence.
        plots: Vec<Plot>,
        /// Entities.
        truth: Vec<Truth>,
        /// Measures since the start of the run, by name.
        measures: BTreeMap<String, f64>,
    }
}

public! {
    /// Tracks of one scan.
    Tracks {
        /// By number.
        tracks: Vec<Track>,
    }
}

public! {
    /// Plots of one scan.
    Plots {
        /// By sensor and sequence.
        plots: Vec<Plot>,
    }
}

public! {
    /// Truth at the end of one scan.
    Truths {
        /// Entities.
        truth: Vec<Truth>,
    }
}

/// Every message: its name, and the schema of its body.
fn messages() -> Vec<(&'static str, Value)> {
    vec![
        ("state", State::schema()),
        ("scan", Scan::schema()),
        ("tracks", Tracks::schema()),
        ("plots", Plots::schema()),
        ("truth", Truths::schema()),
        ("flights", Flights::schema()),
        ("weather", Weather::schema()),
        ("operation", OperationDone::schema()),
        ("federate", Federate::schema()),
        ("handovers", Handovers::schema()),
    ]
}

/// JSON Schema (2020-12) of all messages: `$defs` has one entry a message, `command` and `answer` beside them.
#[must_use]
pub fn schema() -> Value {
    let mut definitions = Map::new();
    for (name, mut body) in messages() {
        let head = Head::schema();
        let (Some(properties), Some(of_head)) =
            (body["properties"].as_object().cloned(), head["properties"].as_object().cloned())
        else {
            continue;
        };
        let mut all = of_head;
        all.extend(properties);
        all["schema"]["const"] = json!(format!("seeds.{name}/{VERSION}"));
        let names = |v: &Value| v["required"].as_array().cloned().unwrap_or_default();
        let required: Vec<Value> = names(&head).into_iter().chain(names(&body)).collect();
        body["properties"] = Value::Object(all);
        body["required"] = Value::Array(required);
        definitions.insert(name.to_owned(), body);
    }
    definitions.insert("command".into(), CommandAsked::schema());
    let mut answer = CommandAnswered::schema();
    answer["properties"]["schema"]["const"] = json!(format!("seeds.answer/{VERSION}"));
    answer["properties"]["state"] = json!({"$ref": "#/$defs/state"});
    definitions.insert("answer".into(), answer);
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": format!("urn:seeds:public:{VERSION}"),
        "title": "Public messages of SEEDS",
        "$defs": definitions,
    })
}

mod run;
pub use run::{
    CommandAnswered, CommandAsked, Federate, Flight, Flights, Handover, Handovers, Member,
    OperationDone, State, Weather,
};

mod convert;
pub use convert::{
    Heading, federate, flights, geojson, handover, iso8601, message, operation, plots, scan, state,
    tracks, truths, weather,
};

#[cfg(test)]
mod tests;
